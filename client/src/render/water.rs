//! The water on the clay as it is seen: where wet hands have passed, and how it dries.
//!
//! Owns a coarse map of the wall and the law of drying. What the clay is made of is the wheel's setting, which everybody shares and
//! which alone governs it; this changes the picture and nothing else. Holds no clock: the wheel's ticks are its time.
//! Invariant: what a tick leaves depends on what was heard up to it and not on how many pictures were drawn meanwhile, but for the
//! ways of hands between two pictures; and two who see the same hands differ by less than `exp(−t/τ)` after t.

use glam::Vec3;
use pottery_shared::clay::{Conditions, Phase};
use pottery_shared::units::Tick;

/// Water on a pot's wall, 0 to 1, inside and outside as one.
///
/// A touching tool wets what passes it, a sponge wets everything, and what is wet dries by `exp(−t/τ)` with
/// τ = [`Water::DRYING_S`]. The sponge is told from the wheel's setting: whoever makes the clay wetter goes over it with one, so that
/// everybody sees it at the same tick.
///
/// ```
/// use pottery_client::render::Water;
/// use pottery_shared::clay::Conditions;
/// use pottery_shared::units::Tick;
///
/// let conditions = Conditions::default();
/// let mut water = Water::default();
/// water.pass(Tick(0), &conditions, 0.2, []);
/// let fresh = water.at(0.0, 0.5);
/// water.pass(Tick(60_000), &conditions, 0.2, []);
/// assert!(water.at(0.0, 0.5) < 0.4 * fresh);
/// ```
#[derive(Clone, Debug)]
pub struct Water {
    /// `[columns][rows]`.
    share: Vec<f32>,
    /// Up to when it has dried, how the wheel stood then, and the wetness that the clay was set to.
    since: Option<(Tick, Phase, f32)>,
    /// Counts what can be seen of its changes.
    stamp: u64,
    /// Drying that was not yet counted as seen.
    unseen: f32,
}

impl Default for Water {
    /// Clay as it comes on the wheel: wet all over.
    fn default() -> Self {
        Self { share: vec![1.0; Self::COLUMNS * Self::ROWS], since: None, stamp: 1, unseen: 0.0 }
    }
}

/// A hand on the clay: where its tool is in the room, m, and how large, m.
pub type WetHand = (Vec3, f32);

impl Water {
    /// Elements round the pot and from foot to rim: four millimetres of a usual pot each, finer than a hand's edge is sharp.
    pub const COLUMNS: usize = 96;
    /// Elements from foot to rim.
    pub const ROWS: usize = 48;
    /// Time in which water falls to 1/e, s: by eye, a minute or two from shining to dull. Not measured.
    pub const DRYING_S: f32 = 50.0;
    /// How far beyond its tool a hand wets, m.
    const BEYOND_M: f32 = 0.004;
    /// A change of less is not drawn: a step of the picture's bytes is 1/255.
    const SEEN: f32 = 0.008;

    /// Lets time pass up to a tick: what is wet dries, what passes a hand becomes wet, and the wheel's setting tells of the sponge.
    ///
    /// `height_m` is the pot's height. A tick before the last one begins anew from there, as a recording that is wound back does.
    pub fn pass(
        &mut self,
        now: Tick,
        conditions: &Conditions,
        height_m: f32,
        hands: impl IntoIterator<Item = WetHand>,
    ) {
        let (phase, wetness) = (conditions.phase(now), conditions.material.at(now).wetness().liquidity_index());
        let (since, from, was_wetness) = self.since.replace((now, phase, wetness)).unwrap_or((now, phase, wetness));
        self.dry(now.since(since).max(0) as f32 / Tick::PER_SECOND as f32);
        // rounding of what was sent and taken back is no sponge
        if wetness > was_wetness + 1e-4 {
            self.sponge();
        }
        let turned = i64::from(conditions.wheel.rate(now)) * now.since(since).max(0);
        for (at_m, radius_m) in hands {
            self.wet(at_m, radius_m + Self::BEYOND_M, height_m, from, turned);
        }
    }

    /// Wets everything.
    pub fn sponge(&mut self) {
        self.share.fill(1.0);
        self.stamp += 1;
    }

    fn dry(&mut self, seconds: f32) {
        let left = (-seconds / Self::DRYING_S).exp();
        let mut most = 0.0_f32;
        for share in &mut self.share {
            most = most.max(*share);
            *share *= left;
        }
        self.unseen += most * (1.0 - left);
        if self.unseen > Self::SEEN {
            (self.stamp, self.unseen) = (self.stamp + 1, 0.0);
        }
    }

    /// Wets what passed a hand of that reach while the pot turned on by so many steps of the phase.
    fn wet(&mut self, at_m: Vec3, reach_m: f32, height_m: f32, from: Phase, turned: i64) {
        let away_m = at_m.truncate().length().max(reach_m);
        if !at_m.is_finite() || height_m <= 0.0 {
            return;
        }
        let turn = 2.0_f64.powi(32);
        let columns = Self::COLUMNS as f64;
        // the tool goes backwards over the pot while the pot turns on
        let begin = f64::from(at_m.y).atan2(f64::from(at_m.x)) / std::f64::consts::TAU - f64::from(from.0) / turn;
        let reach = f64::from(reach_m / away_m) / std::f64::consts::TAU;
        let end = begin - turned as f64 / turn;
        let (low, high) = (begin.min(end) - reach, begin.max(end) + reach);
        let first = (low * columns).floor() as i64;
        let count = (((high - low) * columns).ceil() as usize).clamp(1, Self::COLUMNS);
        let mut is_seen = false;
        for row in 0..Self::ROWS {
            let z_m = (row as f32 + 0.5) / Self::ROWS as f32 * height_m;
            let off = (z_m - at_m.z).abs() / reach_m;
            if off >= 1.0 {
                continue;
            }
            // an edge that fades over the outer half
            let wet = (2.0 * (1.0 - off)).min(1.0);
            for column in 0..count {
                let column = (first + column as i64).rem_euclid(Self::COLUMNS as i64) as usize;
                let share = &mut self.share[column * Self::ROWS + row];
                is_seen |= wet > *share + Self::SEEN;
                *share = share.max(wet);
            }
        }
        self.stamp += u64::from(is_seen);
    }

    /// The water at an angle of the pot, rad, and a share of its height.
    #[must_use]
    pub fn at(&self, angle_rad: f32, up: f32) -> f32 {
        let turns = (angle_rad / std::f32::consts::TAU).rem_euclid(1.0);
        let column = (turns * Self::COLUMNS as f32) as usize % Self::COLUMNS;
        let row = ((up * Self::ROWS as f32).max(0.0) as usize).min(Self::ROWS - 1);
        self.share[column * Self::ROWS + row]
    }

    /// Changes whenever a picture of it would.
    #[must_use]
    pub const fn stamp(&self) -> u64 {
        self.stamp
    }

    /// As texels, 255 for wet, `[columns][rows]`.
    pub(super) fn texels(&self) -> Vec<u8> {
        self.share.iter().map(|share| (share * 255.0).round() as u8).collect()
    }
}
