//! From what the clay answers to what the hand feels: the checks and limits of one tick.
//!
//! Knows no network, no clock and no device; reads the clay's answer, never changes clay.
//! Invariant: the force it returns is finite and no longer than the device's limit, whatever came in.

mod specs;
mod velocity;

use glam::Vec3;

use crate::tool::Position;
pub use specs::{DevicePreset, DeviceSpecs, PRESETS, SpecsError};
pub use velocity::VelocityEstimate;

/// Why the loop gives no force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Fault {
    /// A coordinate is not a number, or out of reach; the device or its driver is at fault.
    #[error("the device reported a position that makes no sense; the force is off until it reports sound ones again")]
    Position,
    /// The device jumped farther in a tick than a hand can.
    #[error("the device jumped; the force is off until it moves like a hand again")]
    Jump,
    /// The clay's answer is not a number.
    #[error("the clay answered with a force that makes no sense; the force is off")]
    Force,
    /// The device's limits are zero, or none.
    #[error("the device reports limits that make no sense; the force is off: give its limits in the settings")]
    Specs,
}

/// The checks and limits between device and clay, one tick at a time.
#[derive(Clone, Copy, Debug)]
pub struct Haptics {
    specs: Result<DeviceSpecs, SpecsError>,
    felt_share: f32,
    last: Option<Position>,
    fault: Option<Fault>,
    sound_ticks: u32,
}

impl Haptics {
    /// Farthest that counts as a movement within one tick, m: 5 m/s.
    pub const JUMP_M: f32 = 0.005;
    /// Sound ticks after which a fault is over.
    pub const RECOVERY_TICKS: u32 = 100;

    /// A loop for a device with the given specs, and the share of the clay's force to feel; the force stays off when the specs
    /// make no sense.
    #[must_use]
    pub fn new(specs: DeviceSpecs, felt_share: f32) -> Self {
        Self { specs: specs.checked(), felt_share, last: None, fault: None, sound_ticks: 0 }
    }

    /// The fault that keeps the force off, if any.
    #[must_use]
    pub const fn fault(&self) -> Option<Fault> {
        if self.specs.is_err() { Some(Fault::Specs) } else { self.fault }
    }

    /// Checks what the device reported, m; `None` when there is nothing to press with in this tick.
    ///
    /// A tool that is taken away and comes back elsewhere has not jumped.
    pub fn accept(&mut self, reported_m: Option<Vec3>) -> Option<Position> {
        let Some(reported_m) = reported_m else {
            self.last = None;
            self.recover();
            return None;
        };
        let Some(position) = Position::nearest(reported_m) else {
            self.fail(Fault::Position);
            return None;
        };
        if self.last.replace(position).is_some_and(|last| last.distance_m(position) > Self::JUMP_M) {
            self.fail(Fault::Jump);
            return None;
        }
        self.recover();
        self.fault.is_none().then_some(position)
    }

    /// The force to give to the device for the clay's force, N.
    ///
    /// `f = s·F`, shortened to the peak with its direction kept; zero while a fault lasts.
    pub fn render(&mut self, clay_force_n: Vec3) -> Vec3 {
        if !clay_force_n.is_finite() {
            self.fail(Fault::Force);
        }
        match self.specs {
            Ok(specs) if self.fault.is_none() => (clay_force_n * self.felt_share).clamp_length_max(specs.peak_force_n),
            _ => Vec3::ZERO,
        }
    }

    fn fail(&mut self, fault: Fault) {
        self.fault = Some(fault);
        self.sound_ticks = 0;
    }

    fn recover(&mut self) {
        self.sound_ticks = self.sound_ticks.saturating_add(1);
        if self.sound_ticks >= Self::RECOVERY_TICKS {
            self.fault = None;
        }
    }
}
