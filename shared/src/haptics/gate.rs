//! What keeps the force off: places that make no sense, jumps, forces and limits that are none.
//!
//! Owns the faults and when they are over.
//! Invariant: a place that passes is finite, within reach and no farther from the last than a hand gets.

use glam::Vec3;

use crate::tool::Position;
use crate::units::Seconds;

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
    #[error("the device reports limits that make no sense; the force is off")]
    Specs,
}

/// The fault at hand, and what has been sound since.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Gate {
    last_m: Option<Vec3>,
    fault: Option<Fault>,
    sound_ticks: u32,
}

impl Gate {
    /// Fastest that counts as a movement, m/s.
    pub(super) const SPEED_MAX_M_S: f32 = 5.0;
    /// Farthest that counts as one after a stall, however long.
    const JUMP_MAX_M: f32 = 0.025;
    /// Sound ticks after which a fault is over.
    pub(super) const RECOVERY_TICKS: u32 = 100;

    pub(super) const fn fault(&self) -> Option<Fault> {
        self.fault
    }

    /// Checks what the device reported, m, `dt` after the last report; `None` when there is nothing to press with.
    ///
    /// A tool that is taken away and comes back elsewhere has not jumped.
    pub(super) fn check(&mut self, reported_m: Option<Vec3>, dt: Seconds) -> Option<Vec3> {
        let Some(reported_m) = reported_m else {
            self.last_m = None;
            self.recover();
            return None;
        };
        if Position::nearest(reported_m).is_none() {
            self.fail(Fault::Position);
            return None;
        }
        let farthest_m = (Self::SPEED_MAX_M_S * dt.0).min(Self::JUMP_MAX_M);
        if self.last_m.replace(reported_m).is_some_and(|last_m| last_m.distance(reported_m) > farthest_m) {
            self.fail(Fault::Jump);
            return None;
        }
        self.recover();
        self.fault.is_none().then_some(reported_m)
    }

    pub(super) const fn fail(&mut self, fault: Fault) {
        self.fault = Some(fault);
        self.sound_ticks = 0;
    }

    const fn recover(&mut self) {
        self.sound_ticks = self.sound_ticks.saturating_add(1);
        if self.sound_ticks >= Self::RECOVERY_TICKS {
            self.fault = None;
        }
    }
}
