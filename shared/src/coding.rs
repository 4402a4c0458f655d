//! Entropy coding: a range coder, what it learns of symbols, and codes of numbers and of movements made of it.
//!
//! What is coded is the affair of whoever asks; nothing here knows of clay, tools or connections.
//! Invariant: what is decoded from an encoding, with the same sequence of models, is what went in.

mod adaptive;
mod coder;
mod magnitude;
mod movement;

pub(crate) use adaptive::{BitModel, KindModel};
pub(crate) use coder::{Decoder, Encoder, Symbols};
pub(crate) use magnitude::Magnitude;
pub(crate) use movement::{Movement, Signed, StepModel};
