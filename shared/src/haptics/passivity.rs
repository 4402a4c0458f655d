//! Passivity observer and controller: what a sampled, late or corrected force feeds to the hand is taken back.
//!
//! Owns the account of energy; knows no clay.
//! Invariant: it only ever adds a force against the movement, no larger than the damping it may use.

use glam::Vec3;

use super::VelocityEstimate;
use super::given::Given;
use crate::units::Seconds;

/// Time-domain passivity control (Hannaford and Ryu 2002), observing against the model's own energy as reference (Ryu, Preusche,
/// Hannaford and Hirzinger 2005).
///
/// Clay takes so much energy that an account of all of it would let a loop feed millijoules back unseen. So what is observed is the
/// difference: the work `f·v·dt` of the force that really acted while the device moved, the one given `1 + t_d/T` ticks ago, less
/// that of the force which coupling and clay would have given all the way, `½(f₀ + f₁)·v·dt`, and less what the device's own
/// damping takes, `b·v²·dt`. Where that account W is above zero the controller damps by `α = W/(v²·dt)` until it is paid. What it damped by then
/// goes at 50 N/s and not at once: a brake that lets go of a hand in a tick is a jolt of up to `B·v`, 0.7 N at 0.14 m/s, which nobody caused, and
/// what it takes meanwhile is energy taken.
///
/// v and both forces go through the low-pass of [`VelocityEstimate`]: a place that flickers by a step of the encoder is no
/// movement, and damping it would shake the hand. What trembles at 80 Hz counts half.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Passivity {
    given: Given,
    wanted_n: Vec3,
    /// The force that acted less that of the model, filtered.
    excess_n: Vec3,
    /// Energy that was fed to the hand and not taken back, J.
    owed_j: f32,
    /// How strongly it damped in the last tick, N.
    braked_n: f32,
}

impl Passivity {
    /// Most that is owed, J: a longer debt would be felt as treacle long after its cause.
    const OWED_MAX_J: f32 = 5e-3;
    /// Slower is no movement, m/s.
    const STILL_M_S: f32 = 1e-4;
    /// How fast it ceases to damp, N/s: half of what the force may change by after a stall.
    const EASES_N_S: f32 = 50.0;

    /// The force to add to what is wanted, N, for a device that moves at `velocity_m_s`; `own_ns_m` is the device's own damping and
    /// `most_ns_m` the largest that may be rendered.
    pub(super) fn control(
        &mut self,
        wanted_n: Vec3,
        velocity_m_s: Vec3,
        (dt, delay): (Seconds, Seconds),
        (own_ns_m, most_ns_m): (f32, f32),
    ) -> Vec3 {
        let acted_n = self.given.acted(dt, delay);
        let model_n = 0.5 * (wanted_n + self.wanted_n);
        self.wanted_n = wanted_n;
        self.excess_n += (acted_n - model_n - self.excess_n) * VelocityEstimate::share(dt);
        let speed2 = velocity_m_s.length_squared();
        let fed_w = self.excess_n.dot(velocity_m_s) - own_ns_m * speed2;
        self.owed_j = (self.owed_j + fed_w * dt.0).clamp(0.0, Self::OWED_MAX_J);
        if speed2 < Self::STILL_M_S * Self::STILL_M_S {
            self.braked_n = 0.0;
            return Vec3::ZERO;
        }
        let speed = velocity_m_s.length();
        let eased_ns_m = (self.braked_n - Self::EASES_N_S * dt.0).max(0.0) / speed;
        let damping_ns_m = (self.owed_j / (speed2 * dt.0)).max(eased_ns_m).min(most_ns_m);
        self.braked_n = damping_ns_m * speed;
        velocity_m_s * -damping_ns_m
    }

    /// Notes what is given to the device in this tick.
    pub(super) const fn note(&mut self, given_n: Vec3) {
        self.given.note(given_n);
    }

    /// Forgets everything, since there is no force.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}
