//! What a pot is to become: a profile, and how far a pot is from it.
//!
//! Owns the comparison; who set the target and who is to reach it are others' affair.
//! Invariant: every radius is finite and within what a pot can have, and there are [`Target::POINTS`] of them.

use super::{Pot, PotSpec};

/// A profile of revolution: radii at even heights from the foot to the rim.
#[derive(Clone, Debug, PartialEq)]
pub struct Target {
    height_m: f32,
    radii_m: [f32; Self::POINTS],
}

/// How far a pot is from a target, over all elements of its outer wall that are no higher than the target, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Deviation {
    /// Root of the mean of the squares.
    pub rms_m: f32,
    /// The largest, and the height at which it is.
    pub most_m: f32,
    /// The height of the largest.
    pub most_at_m: f32,
    /// How much higher the pot is than the target, below zero for a lower one.
    pub higher_m: f32,
}

impl Target {
    /// Radii of a profile: one every 3 mm of a pot of 200 mm.
    pub const POINTS: usize = 65;
    /// Higher than clay gets, m.
    const HEIGHT_MAX_M: f32 = 2.0;

    /// The profile of those radii, m, evenly spread over the height, m; none for what no pot can be.
    #[must_use]
    pub fn new(height_m: f32, radii_m: [f32; Self::POINTS]) -> Option<Self> {
        let is_up_to = |length_m: f32, most_m: f32| length_m > 0.0 && length_m <= most_m;
        let is_one = is_up_to(height_m, Self::HEIGHT_MAX_M)
            && radii_m.iter().all(|radius_m| is_up_to(*radius_m, PotSpec::RADIUS_MAX.0));
        is_one.then_some(Self { height_m, radii_m })
    }

    /// The profile of a pot: the mean radius of its outer wall at every height.
    ///
    /// ```
    /// use pottery_shared::clay::{Pot, PotSpec, Target};
    /// let pot = Pot::new(PotSpec::default())?;
    /// let target = Target::of(&pot);
    /// assert!((target.radius_m(0.1).unwrap() - pot.spec().radius.0).abs() < 1e-6);
    /// assert_eq!((target.radius_m(-0.01), target.radius_m(1.0)), (None, None));
    /// # Ok::<(), pottery_shared::clay::PotError>(())
    /// ```
    #[must_use]
    pub fn of(pot: &Pot) -> Self {
        let surface = &pot.surfaces()[0];
        let (columns, rows) = (surface.shape().columns(), surface.shape().rows());
        let mean = |row: u32| {
            let sum: f64 = (0..columns).map(|column| f64::from(surface.column_m(column)[row as usize])).sum();
            (sum / f64::from(columns)) as f32
        };
        let radii_m = core::array::from_fn(|point| {
            let at = point as f32 / (Self::POINTS - 1) as f32 * (rows - 1) as f32;
            let below = (at as u32).min(rows - 2);
            let (low, high) = (mean(below), mean(below + 1));
            low + (high - low) * (at - below as f32)
        });
        Self { height_m: surface.height_m(), radii_m }
    }

    /// Its height, m.
    #[must_use]
    pub const fn height_m(&self) -> f32 {
        self.height_m
    }

    /// Its radii, m, from the foot to the rim.
    #[must_use]
    pub const fn radii_m(&self) -> &[f32; Self::POINTS] {
        &self.radii_m
    }

    /// Its radius at a height, m; none below the foot and above the rim.
    #[must_use]
    pub fn radius_m(&self, height_m: f32) -> Option<f32> {
        let at = height_m / self.height_m * (Self::POINTS - 1) as f32;
        if !(0.0..=(Self::POINTS - 1) as f32).contains(&at) {
            return None;
        }
        let below = (at as usize).min(Self::POINTS - 2);
        let (low, high) = (self.radii_m[below], self.radii_m[below + 1]);
        Some(low + (high - low) * (at - below as f32))
    }

    /// How far a pot is from it: `√(Σ(r − r_T)²/n)` and `max |r − r_T|`.
    #[must_use]
    pub fn deviation(&self, pot: &Pot) -> Deviation {
        let surface = &pot.surfaces()[0];
        let (columns, rows) = (surface.shape().columns(), surface.shape().rows());
        let (mut squares, mut elements) = (0.0_f64, 0_u64);
        let mut deviation = Deviation { higher_m: surface.height_m() - self.height_m, ..Deviation::default() };
        for row in 0..rows {
            // the rim may be rounded above itself, where there is no target
            let at_m = surface.row_z_m(row).min(surface.height_m());
            let Some(wanted_m) = self.radius_m(at_m) else { continue };
            for column in 0..columns {
                let off_m = surface.column_m(column)[row as usize] - wanted_m;
                squares += f64::from(off_m) * f64::from(off_m);
                if off_m.abs() > deviation.most_m {
                    (deviation.most_m, deviation.most_at_m) = (off_m.abs(), at_m);
                }
            }
            elements += u64::from(columns);
        }
        deviation.rms_m = libm::sqrt(squares / elements.max(1) as f64) as f32;
        deviation
    }
}
