//! The authoritative pottery server: a thin QUIC shell round the room.
//!
//! Owns sockets, time and tasks; every decision about clay and people is `pottery_shared::room`'s.
//! Invariant: a peer that is slow, gone or hostile costs its own connection, never the tick.

mod announcing;
#[cfg(target_os = "linux")]
mod batching;
mod bounds;
mod bucket;
mod certificate;
mod class_register;
mod config;
mod connection;
mod crew;
mod doorkeeper;
mod event;
mod figures;
mod folder;
mod input;
mod lesson;
mod link;
mod losses;
mod opening;
mod operation;
mod orders;
pub mod recording;
mod server;
mod signal;
mod store;
mod teacher;
mod ticking;
mod transport;

pub use bounds::{CONNECTION_BYTES_MAX, CONTROL_BYTES, CONTROL_QUEUE, KEYFRAME_BYTES};
pub use certificate::Certificate;
pub use config::{ConfigError, FileConfig, Finest, ServerConfig};
pub use crew::Helpers;
pub use doorkeeper::{Arrivals, InputCounts};
pub use figures::Figures;
pub use input::Input;
pub use losses::Losses;
pub use orders::{ORDERS, OrderError, order_of};
pub use server::{Server, ServerError, Standing};
pub use signal::stop_signal;
pub use store::{StoreCounts, StoreError, last_pot};
pub use transport::{address, bind, endpoint, server_config};
