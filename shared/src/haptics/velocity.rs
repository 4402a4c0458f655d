//! The speed of a device that reports places only.
//!
//! Owns the filter and states its delay.
//! Invariant: the estimate is finite for finite places, whatever they do.

use glam::Vec3;

use crate::units::Seconds;

/// Velocity from places: their difference over the step, through one low-pass.
///
/// `v ← v + (1 − exp(−dt/τ))·((x − x₀)/dt − v)` with τ = 2 ms. A steady acceleration is followed with a delay of
/// `dt/2 + dt/(exp(dt/τ) − 1)`, half a step of the difference and what the low-pass adds: 2.04 ms at 1 kHz, and τ at any higher rate.
/// A place that flickers by a step q of the encoder shows as at most `0.4·q/dt`, 22 mm/s for the 0.055 mm of a PHANToM Omni,
/// instead of 55.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct VelocityEstimate {
    last_m: Option<Vec3>,
    velocity_m_s: Vec3,
}

impl VelocityEstimate {
    /// Time constant of the low-pass, which is the estimate's delay within 3 % from 1 kHz on.
    pub const DELAY: Seconds = Seconds(2e-3);

    /// Takes the next place, m, `dt` after the last one, and returns the velocity, m/s; zero for the first.
    pub fn follow(&mut self, position_m: Vec3, dt: Seconds) -> Vec3 {
        let before = self.last_m.replace(position_m);
        if let Some(before) = before.filter(|_| dt.0 > 0.0) {
            self.velocity_m_s += ((position_m - before) / dt.0 - self.velocity_m_s) * Self::share(dt);
        }
        self.velocity_m_s
    }

    /// Share of a change that the low-pass lets through in a step.
    pub(super) fn share(dt: Seconds) -> f32 {
        1.0 - libm::expf(-dt.0 / Self::DELAY.0)
    }

    /// Forgets the way, since the tool was away.
    pub const fn forget(&mut self) {
        *self = Self { last_m: None, velocity_m_s: Vec3::ZERO };
    }
}
