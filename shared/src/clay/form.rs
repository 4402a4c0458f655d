//! Pots to begin with: forms that potters know, as profiles of revolution.
//!
//! Owns the profiles; a pot made from one is a pot like any other.
//! Invariant: a form encloses what a cylinder of its specification's radius and height does, so that it is as high as it was
//! made until somebody presses it.

use super::{Pot, PotError, PotSpec};
use crate::units::Metres;

/// A form to begin with.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Form {
    /// Straight walls: the paper's pot.
    #[default]
    Cylinder,
    /// Wide and low, opening upwards.
    Bowl,
    /// A belly, shoulders and a narrow neck.
    Bottle,
    /// A sphere without its poles.
    Ball,
}

impl Form {
    /// Every form.
    pub const ALL: [Self; 4] = [Self::Cylinder, Self::Bowl, Self::Bottle, Self::Ball];

    /// Its name, as people write it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cylinder => "cylinder",
            Self::Bowl => "bowl",
            Self::Bottle => "bottle",
            Self::Ball => "ball",
        }
    }

    /// The form of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|form| form.name() == name)
    }

    /// Height and widest radius, mm; a cylinder has those that are asked for.
    const fn measures_mm(self) -> Option<[f32; 2]> {
        match self {
            Self::Cylinder => None,
            Self::Bowl => Some([100.0, 100.0]),
            Self::Bottle => Some([240.0, 70.0]),
            Self::Ball => Some([130.0, 80.0]),
        }
    }

    /// Radius over the widest one at a share of the height, both from 0 to 1.
    fn profile(self, share: f32) -> f32 {
        // from 0 to 1 without a bend at either end
        let smooth = |from: f32, to: f32| {
            let part = ((share - from) / (to - from)).clamp(0.0, 1.0);
            part * part * (3.0 - 2.0 * part)
        };
        match self {
            Self::Cylinder => 1.0,
            // a quarter of an ellipse, cut off above its vertex, where the wall would lie flat
            Self::Bowl => {
                let part = 0.1 + 0.9 * share;
                libm::sqrtf(part * (2.0 - part))
            }
            Self::Bottle => 0.72 + 0.28 * smooth(0.0, 0.35) - 0.62 * smooth(0.45, 0.82) + 0.06 * smooth(0.9, 1.0),
            Self::Ball => {
                let height = 1.6 * (share - 0.5);
                libm::sqrtf(1.0 - height * height)
            }
        }
    }

    /// Its number in messages: the order of [`Form::ALL`], from 1 on.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Cylinder => 1,
            Self::Bowl => 2,
            Self::Bottle => 3,
            Self::Ball => 4,
        }
    }

    /// The form of a number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.into_iter().find(|form| form.number() == number)
    }

    /// Mean of the square of the profile as a surface takes it, half a row at foot and rim: the share of the volume of the
    /// widest cylinder that the form encloses.
    fn mean_square(self, rows: u32) -> f32 {
        let weight = |row: u32| if row == 0 || row == rows - 1 { 0.5 } else { 1.0 };
        let squares = (0..rows).map(|row| weight(row) * libm::powf(self.profile(share(row, rows)), 2.0));
        squares.sum::<f32>() / (rows - 1) as f32
    }

    /// The clay of a specification's cylinder in this form, with the form's own relation of height to width: h·w²·m = h₀·r₀²
    /// with h = a·w makes w = ∛(h₀·r₀²/(a·m)). The height follows where clay keeps its volume, as it does when somebody presses.
    ///
    /// # Errors
    /// [`PotError`] when no pot is made like that.
    pub fn of_clay_of(self, spec: PotSpec) -> Result<Pot, PotError> {
        let mut pot = Pot::new(spec)?;
        let Some([height_mm, widest_mm]) = self.measures_mm() else { return Ok(pot) };
        let relation = height_mm / widest_mm;
        let clay_m3 = spec.height.0 * spec.radius.0 * spec.radius.0;
        let widest_m = libm::cbrtf(clay_m3 / (relation * self.mean_square(spec.shape.rows())));
        self.give(&mut pot, widest_m);
        Ok(pot)
    }

    /// Gives every surface of a pot the profile.
    fn give(self, pot: &mut Pot, widest_m: f32) {
        for surface in pot.surfaces_mut() {
            let (columns, rows) = (surface.shape().columns(), surface.shape().rows());
            for row in 0..rows {
                let radius_m = widest_m * self.profile(share(row, rows));
                for column in 0..columns {
                    surface.set_radius(column, row, radius_m);
                }
            }
        }
    }

    /// A pot of this form with the grid, wall and support of a specification; a cylinder has its measures as well.
    ///
    /// # Errors
    /// [`PotError`] when no pot is made like that.
    pub fn pot(self, spec: PotSpec) -> Result<Pot, PotError> {
        let Some([height_mm, widest_mm]) = self.measures_mm() else { return Pot::new(spec) };
        let radius = Metres::from_mm(widest_mm * libm::sqrtf(self.mean_square(spec.shape.rows())));
        let mut pot = Pot::new(PotSpec { height: Metres::from_mm(height_mm), radius, ..spec })?;
        self.give(&mut pot, Metres::from_mm(widest_mm).0);
        Ok(pot)
    }
}

/// How high a row lies, from 0 at the foot to 1 at the rim.
fn share(row: u32, rows: u32) -> f32 {
    row as f32 / (rows - 1) as f32
}
