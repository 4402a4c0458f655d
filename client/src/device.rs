//! What a person holds: position in, force out.
//!
//! A device is asked once a tick, in the 1 kHz thread: it may not wait, lock or allocate.
//! Invariant: positions are metres in the room's frame, z up along the wheel's axis, the foot of the pot at zero.

mod pointer;
mod scripted;
mod simulated;

use glam::Vec3;
use pottery_shared::haptics::ForceLimits;
use pottery_shared::tool::Sphere;

pub use pointer::{Pointer, PointerDevice, pointer};
pub use scripted::ScriptedDevice;
pub use simulated::{HandModel, SimulatedDevice};

/// A haptic device or what stands for one.
pub trait Device: Send {
    /// Where the tool's centre is at `seconds` since the hand began, m; `None` while there is no tool in the hand.
    fn position(&mut self, seconds: f64) -> Option<Vec3>;

    /// The tool in the hand.
    fn tool(&self) -> Sphere;

    /// Takes the force to give to the hand, N.
    fn set_force(&mut self, force_n: Vec3);

    /// What it can render.
    fn limits(&self) -> ForceLimits {
        ForceLimits::default()
    }
}
