//! The forces that were given lately, so that the one that acts now is known for a device that is late.
//!
//! Owns a ring of them; knows nothing of what they are for.
//! Invariant: a force is found again for [`Given::TICKS_MAX`] ticks.

use glam::Vec3;

use crate::units::Seconds;

/// Forces, the newest before `next`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Given {
    forces_n: [Vec3; Self::TICKS_MAX + 1],
    next: usize,
}

impl Default for Given {
    fn default() -> Self {
        Self { forces_n: [Vec3::ZERO; Self::TICKS_MAX + 1], next: 0 }
    }
}

impl Given {
    /// Most ticks of delay that can be accounted for.
    const TICKS_MAX: usize = 64;

    /// The force that acted in the tick that is over: it was given `1 + t_d/T` ticks ago.
    pub(super) fn acted(&self, dt: Seconds, delay: Seconds) -> Vec3 {
        let late = libm::roundf(delay.0 / dt.0).clamp(0.0, (Self::TICKS_MAX - 1) as f32) as usize;
        self.forces_n[(self.next + Self::TICKS_MAX - late) % (Self::TICKS_MAX + 1)]
    }

    /// Notes what is given to the device in this tick.
    pub(super) const fn note(&mut self, force_n: Vec3) {
        self.forces_n[self.next] = force_n;
        self.next = (self.next + 1) % (Self::TICKS_MAX + 1);
    }
}
