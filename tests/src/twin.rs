//! Stand-ins for haptic devices, gamepads and a sound server: each keeps its protocol from the other side, and can be told to break it.
//!
//! None of the devices was at hand: what is held against a twin is held to the protocol as its public sources have it,
//! and to nothing else.
//! Invariant: a twin never gives a force by itself; what it has received can be asked for.

#[cfg(unix)]
mod compiled;
#[cfg(target_os = "linux")]
pub mod evdev;
pub mod falcon;
mod hand;
pub mod haply;
#[cfg(unix)]
pub mod hdapi;
#[cfg(target_os = "linux")]
pub mod pulse;

pub use hand::HandSession;
