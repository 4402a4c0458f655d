//! What keeps the hand from jolts that it did not cause: corrected clay, a force that begins, a loop that stood still.
//!
//! Owns the two rates.
//! Invariant: both only put off a change; what is given comes to what is wanted.

use glam::Vec3;

use super::Haptics;
use crate::units::Seconds;

/// The error that a correction of the clay left in the force, taken away little by little.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Correction {
    /// What a step of the device's encoders changes the force by, N.
    step_n: f32,
    error_n: Vec3,
    before_n: Vec3,
    settles_s: f32,
}

impl Correction {
    /// How long the proxy takes to find corrected clay, s: ten Newton steps.
    const SETTLES_S: f32 = 0.01;
    /// Fastest that an error goes, N/s.
    const RATE_MAX_N_S: f32 = 20.0;
    /// Within 20 ms the force changes by 6 % or 0.09 N: a hand does not tell 7 % or 0.1 N apart, and the clay gives way meanwhile.
    const WITHIN_S: f32 = 0.02;
    const SHARE: f32 = 0.06;
    const LEAST_N: f32 = 0.09;
    /// Share of that which is the correction's own however coarse the encoders are, so that it ends.
    const OWN_SHARE: f32 = 0.5;

    /// For a device whose encoders have steps of K·q, N: a hand that gives way to a correction goes over one of them, which is felt at once, and
    /// with what is let in it is to be no more than a hand tells apart.
    pub(super) fn beside_steps_of(step_n: f32) -> Self {
        Self { step_n, ..Self::default() }
    }

    /// How fast an error goes under a force, N/s.
    fn rate_n_s(&self, force_n: f32) -> f32 {
        let told_n = (Self::SHARE * force_n).max(Self::LEAST_N);
        let own_n = (told_n - self.step_n).max(Self::OWN_SHARE * told_n);
        (own_n / Self::WITHIN_S).min(Self::RATE_MAX_N_S)
    }

    /// Says that the clay under the tool is another from now on.
    pub(super) const fn begin(&mut self) {
        self.settles_s = Self::SETTLES_S;
    }

    /// The coupling's force with what is left of the error, N, after `dt`, s; `moved_n` is how far the device moved times the coupling's
    /// stiffness, N, and `normal` the contact's, of length one.
    ///
    /// While the proxy looks for the new clay, every change that the device's own movement does not explain is error: along the normal, and across
    /// it what is more than the coupling of that movement, since a proxy slides aside on a slope that was not there.
    pub(super) fn blend(&mut self, force_n: Vec3, normal: Vec3, moved_n: Vec3, dt: Seconds) -> Vec3 {
        if self.settles_s > 0.0 {
            self.settles_s -= dt.0;
            // who moves away loses a force, and gets none that pulls; one that is there already stays
            let least_n = self.before_n.dot(normal).min(0.0);
            let explained = (self.before_n - moved_n).dot(normal).max(least_n);
            let across = |vector: Vec3| vector - normal * vector.dot(normal);
            let slid_n = across(force_n - self.before_n).clamp_length_max(across(moved_n).length());
            self.error_n += normal * explained + across(self.before_n) + slid_n - force_n;
        }
        self.before_n = force_n;
        let error_n = self.error_n.length();
        if error_n > 0.0 {
            let rate_n_s = self.rate_n_s((force_n + self.error_n).length());
            let left_n = (error_n - rate_n_s * dt.0).max(0.0);
            self.error_n *= left_n / error_n;
        }
        force_n + self.error_n
    }

    pub(super) fn forget(&mut self) {
        *self = Self::beside_steps_of(self.step_n);
    }
}

/// The ramp by which the force comes, after a pause of whatever kind.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Ramp {
    given_n: Vec3,
    is_follower: bool,
    /// Time since the pause, s.
    passed_s: f32,
}

impl Ramp {
    /// How fast the force comes, N/s: a tenth of a newton in a tick of 1 kHz.
    const RATE_N_S: f32 = 100.0;
    /// For so long after a pause nothing is followed yet, s: a proxy that begins in the clay finds its place in ten Newton steps, and a hand that the
    /// force of before the pause has thrown swings back within a tenth of a second.
    const SETTLES_S: f32 = 0.1;
    /// A tick that is longer is a loop that stood still.
    const STALL_S: f32 = 3.5e-3;
    const TICK_S: f32 = 1e-3;
    /// After one so long the device has no force left, s: two ticks more than a driver waits, since a tick may begin late. A shorter one has its force
    /// still, and to take that away would be a jolt.
    const SILENT_S: f32 = (Haptics::SILENCE_TICKS + 2) as f32 * Self::TICK_S;

    /// The force to give, N.
    pub(super) fn ease(&mut self, force_n: Vec3, dt: Seconds) -> Vec3 {
        if dt.0 > Self::STALL_S {
            (self.is_follower, self.passed_s) = (false, 0.0);
        }
        if dt.0 > Self::SILENT_S {
            self.given_n = Vec3::ZERO;
        }
        let change_n = force_n - self.given_n;
        let most_n = Self::RATE_N_S * dt.0.min(Self::TICK_S);
        self.passed_s += dt.0.min(Self::TICK_S);
        let keeps_up = change_n.length() <= most_n;
        self.is_follower |= keeps_up && self.passed_s > Self::SETTLES_S;
        // what keeps up is the force itself, to the bit
        let is_there = keeps_up || self.is_follower;
        self.given_n = if is_there { force_n } else { self.given_n + change_n.clamp_length_max(most_n) };
        self.given_n
    }

    /// Begins at nothing again.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }
}
