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

    /// A pot of this form with the grid, wall and support of a specification; a cylinder has its measures as well.
    ///
    /// # Errors
    /// [`PotError`] when no pot is made like that.
    pub fn pot(self, spec: PotSpec) -> Result<Pot, PotError> {
        let Some([height_mm, widest_mm]) = self.measures_mm() else { return Pot::new(spec) };
        let rows = spec.shape.rows();
        let share = |row: u32| row as f32 / (rows - 1) as f32;
        // the mean of r² as a surface takes it: half a row at foot and rim
        let weight = |row: u32| if row == 0 || row == rows - 1 { 0.5 } else { 1.0 };
        let squares = (0..rows).map(|row| weight(row) * libm::powf(self.profile(share(row)), 2.0));
        let mean = squares.sum::<f32>() / (rows - 1) as f32;
        let radius = Metres::from_mm(widest_mm * libm::sqrtf(mean));
        let mut pot = Pot::new(PotSpec { height: Metres::from_mm(height_mm), radius, ..spec })?;
        for surface in pot.surfaces_mut() {
            for column in 0..surface.shape().columns() {
                for row in 0..rows {
                    surface.set_radius(column, row, Metres::from_mm(widest_mm * self.profile(share(row))).0);
                }
            }
        }
        Ok(pot)
    }
}
