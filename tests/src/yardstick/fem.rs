//! A finite-element method for clay: the offline truth that the studio's own, much quicker clay is fitted to and held
//! against. Nonlinear, elastic-plastic, in motion; minutes for a press.
//!
//! Owns a wall of bricks ([`mesh`], [`element`]), its motion under rigid tools ([`body`]), its mesh anew ([`rezone`]), the presses and strokes made
//! with it ([`press`], [`stroke`], [`cases`]) and their tables ([`tables`]). Units are SI; tables are in millimetres.
//! Invariant: nothing here knows the studio's clay, so agreement between the two says something.
//!
//! What it leaves out: friction, rate dependence, drainage, hardening, softening and gravity.

pub mod body;
pub mod cases;
pub mod element;
mod lanes;
pub mod mesh;
pub mod press;
pub mod rezone;
pub mod stroke;
pub mod tables;
