//! The client of the pottery studio: a thin shell round the shared core.
//!
//! Owns files, devices, the connection, the 1 kHz thread and the picture; what the clay does is decided in
//! `pottery-shared`. Never depends on the server.
//! Invariant: nothing that waits, locks or allocates stands on the 1 kHz side of [`boundary`].

pub mod boundary;
mod claim;
mod connection;
pub mod device;
pub mod export;
pub mod fade;
mod finding;
pub mod guiding;
mod haptic_loop;
mod link;
mod onlooker;
mod pacing;
mod potter;
pub mod rehearsal;
pub mod remote_hands;
pub mod render;
pub mod sound;
mod streams;
pub mod stroke;
pub mod tool_file;
mod transport;
pub mod view;
mod way_back;
mod worker;

pub use pottery_files::sentence::{of_line, sentence};
pub use pottery_files::{flags, pot_file, whole_file};
pub use quinn::Endpoint;

pub use claim::{Claim, Core, CoreError, Granted, Priority};
pub use connection::{JoinError, Joined, Target, join};
pub use finding::{FindError, Found, find};
pub use haptic_loop::{HapticLoop, HapticReport};
pub use link::{Link, LinkError};
pub use onlooker::{Onlooker, WatchReport};
pub use pacing::{IdleLoop, LoopRate, LoopRateError, Pacing, Spin};
pub use potter::{Potter, PotterOptions, PotterReport, Seat};
pub use streams::{Arrival, Streams};
pub use transport::{client_config, endpoint};
pub use worker::{Command, NetworkReport, Worker};
