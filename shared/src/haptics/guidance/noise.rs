//! A force of random direction, the same at every run.
//!
//! Owns its dice; what it is scaled by is `guidance`'s.
//! Invariant: it is never longer than 1.

use glam::Vec3;

use crate::units::Seconds;

/// A direction and a length that change eight times a second, through a low-pass: slow enough that a hand feels pushed and not shaken,
/// too fast to be leant against.
#[derive(Clone, Copy, Debug)]
pub(super) struct Noise {
    dice: u32,
    meant: Vec3,
    now: Vec3,
    left_s: f32,
}

impl Default for Noise {
    fn default() -> Self {
        Self { dice: 0x9e37_79b9, meant: Vec3::ZERO, now: Vec3::ZERO, left_s: 0.0 }
    }
}

impl Noise {
    /// Time between two changes, s, and of the low-pass.
    const HOLD_S: f32 = 0.125;
    const SMOOTH_S: f32 = 0.04;

    /// The next one, `dt` later.
    pub(super) fn pass(&mut self, dt: Seconds) -> Vec3 {
        self.left_s -= dt.0;
        if self.left_s <= 0.0 {
            self.left_s = Self::HOLD_S;
            self.meant = Vec3::from_array([0; 3].map(|_: u8| self.roll())).clamp_length_max(1.0);
        }
        self.now += (self.meant - self.now) * (dt.0 / Self::SMOOTH_S).min(1.0);
        self.now
    }

    /// From −1 to 1: the next of Marsaglia's xorshift of 32 bits (2003).
    fn roll(&mut self) -> f32 {
        self.dice ^= self.dice << 13;
        self.dice ^= self.dice >> 17;
        self.dice ^= self.dice << 5;
        self.dice as i32 as f32 / 2_147_483_648.0
    }
}
