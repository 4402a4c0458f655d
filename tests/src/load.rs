//! Load for a server: many people at its wheels, in one process, on a schedule that does not wait for answers.
//!
//! Owns what is asked of a run ([`plan`]), when each input is due ([`schedule`]), the people ([`hand`], [`follower`],
//! [`person`], [`virtual_room`]), the server's process ([`host`]), what it is compared with ([`mod@bare`]), the machine ([`bystander`], [`cores`]), what is counted ([`figures`]) and what is made of it ([`result`](mod@result),
//! [`threshold`], [`page`]) and what ends it before its time ([`stop`]); [`run`](mod@run) goes through it, [`knee`], [`law`] and [`soak`] go through many.
//! Invariant: a latency runs from the moment at which its input was due, however late the generator or the server is.

pub mod bare;
pub mod bystander;
pub mod cores;
pub mod figures;
pub mod follower;
pub mod hand;
pub mod host;
pub mod knee;
pub mod law;
pub mod page;
pub mod person;
pub mod plan;
pub mod result;
pub mod run;
pub mod schedule;
pub mod soak;
pub mod stop;
pub mod strangers;
pub mod threshold;
pub mod virtual_room;
