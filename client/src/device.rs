//! What a person holds: position in, force out.
//!
//! A device is asked once a tick, in the 1 kHz thread: it may not wait, lock or allocate.
//! Invariant: positions are metres in the room's frame, z up along the wheel's axis, the foot of the pot at zero.

mod calibration;
mod choice;
mod driven;
#[cfg(feature = "falcon")]
pub mod falcon;
mod fault;
mod fitting;
#[cfg(feature = "gamepad")]
pub mod gamepad;
#[cfg(feature = "inverse3")]
pub mod inverse3;
mod limits;
#[cfg(feature = "openhaptics")]
pub mod openhaptics;
mod pointer;
mod rhythm;
mod scripted;
mod simulated;

use glam::Vec3;
use pottery_shared::haptics::{DeviceSpecs, Setup};
use pottery_shared::tool::{Orientation, Tool};

use crate::sound::Rub;

pub use calibration::{Axes, Calibration, MIDDLE_ROOM_M, ScaleError};
pub use choice::{ChoiceError, DeviceChoice, Feel, OpenedDevice, Survey, survey};
pub use driven::{DrivenDevice, Driver, Monitor, Pace, Port, ROUND, Reading, SILENCE, Watch};
pub use fault::DeviceFault;
pub use fitting::{Fit, Fitting, REACH_ROOM_M, Step};
pub use limits::{Limits, Reported};
pub use pointer::{Pointer, PointerDevice, pointer};
pub use scripted::ScriptedDevice;
pub use simulated::{HandModel, SimulatedDevice};

/// A haptic device or what stands for one.
pub trait Device: Send {
    /// Where the tool's centre is at `seconds` since the hand began, m; `None` while there is no tool in the hand.
    fn position(&mut self, seconds: f64) -> Option<Vec3>;

    /// How fast the tool went when [`Device::position`] was asked last, m/s, for a device that measures it; others leave it to
    /// [`pottery_shared::haptics::VelocityEstimate`].
    fn velocity(&self) -> Option<Vec3> {
        None
    }

    /// The buttons that were down then: bit n is button n.
    fn buttons(&self) -> u32 {
        0
    }

    /// The tool in the hand.
    fn tool(&self) -> Tool;

    /// How the tool is turned at the position last asked for; a device that cannot turn holds its tool upright, edge to
    /// the clay. One that knows a turn in the room asks [`Orientation::of`].
    fn orientation(&self) -> Orientation {
        Orientation::default()
    }

    /// Takes the force to give to the hand, N.
    fn set_force(&mut self, force_n: Vec3);

    /// Takes how the tool rubs the clay, before the force, for a device that lets a hand feel it in another way; most do not.
    fn set_rub(&mut self, _: Rub) {}

    /// What it can render; asked before the first tick and when it has become another.
    fn specs(&self) -> DeviceSpecs;

    /// Whether it became another since it was asked last, so that the chain has to be set up anew: a device that was plugged in, or the
    /// mouse in its place. Asked after each [`Device::position`], which had no place to give when it did.
    fn is_another(&mut self) -> bool {
        false
    }

    /// Whether it rests and gives no force, whatever it is told; when it does again, the force is to come by the ramp.
    fn rests(&self) -> bool {
        false
    }

    /// How the chain between it and the clay is set up, given the method's share for a small device; asked as the specs are.
    ///
    /// A device whose force comes late says so here, one that plays a stroke turns stages off, and a share that a person has
    /// chosen replaces the method's.
    fn setup(&self, share_of_small: f32) -> Setup {
        Setup::for_device(self.specs(), share_of_small)
    }

    /// Takes the force away and lets the device go; called once, after the last tick, and may take its time.
    fn close(&mut self) {
        self.set_force(Vec3::ZERO);
    }
}
