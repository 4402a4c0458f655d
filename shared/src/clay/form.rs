//! Pots to begin with: forms that potters know, as profiles of revolution.
//!
//! Owns the profiles; a pot made from one is a pot like any other.
//! Invariant: a form holds as much clay as a cylinder of its specification's radius and height, so that it is as high as it was made
//! until somebody presses it.

use super::{Pot, PotError, PotSpec, Support};
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

    /// Means of the profile and of its square as a surface takes them, half a row at foot and rim.
    fn means(self, rows: u32) -> [f32; 2] {
        let weight = |row: u32| if row == 0 || row == rows - 1 { 0.5 } else { 1.0 };
        let sum = |power: f32| -> f32 {
            (0..rows).map(|row| weight(row) * libm::powf(self.profile(share(row, rows)), power)).sum()
        };
        [1.0, 2.0].map(|power| sum(power) / (rows - 1) as f32)
    }

    /// Radius of the cylinder that is as high and holds as much clay as this form with a widest radius: with the means m of the profile and m₂ of
    /// its square, `w·√m₂` on a core, `w·m` where there is nothing within the wall.
    fn cylinder_m(self, spec: &PotSpec, widest_m: f32) -> f32 {
        let [mean, mean_square] = self.means(spec.shape.rows());
        match spec.support {
            Support::Backed => widest_m * libm::sqrtf(mean_square),
            Support::Hollow => widest_m * mean,
        }
    }

    /// The widest radius of this form with a height for its width and as much clay as a specification's cylinder. With h = a·w
    /// and that cylinder's h₀ and r₀:
    /// - on a core `h·w²·m₂ = h₀·r₀²`, so that `w = ∛(h₀·r₀²/(a·m₂))`;
    /// - of a wall of thickness t `h·(2·w·m − t) = h₀·(2·r₀ − t) = K`, so that `w = (t + √(t² + 8·m·K/a))/(4·m)`.
    fn widest_m(self, spec: &PotSpec, relation: f32) -> f32 {
        let [mean, mean_square] = self.means(spec.shape.rows());
        let (height_m, radius_m, wall_m) = (spec.height.0, spec.radius.0, spec.wall.0);
        match spec.support {
            Support::Backed => libm::cbrtf(height_m * radius_m * radius_m / (relation * mean_square)),
            Support::Hollow => {
                let clay_m2 = height_m * (2.0 * radius_m - wall_m);
                (wall_m + libm::sqrtf(wall_m * wall_m + 8.0 * mean * clay_m2 / relation)) / (4.0 * mean)
            }
        }
    }

    /// The clay of a specification's cylinder in this form, with the form's own relation of height to width. The height follows where clay keeps
    /// its volume, as it does when somebody presses.
    ///
    /// # Errors
    /// [`PotError`] when no pot is made like that.
    pub fn of_clay_of(self, spec: PotSpec) -> Result<Pot, PotError> {
        let mut pot = Pot::new(spec)?;
        let Some([height_mm, widest_mm]) = self.measures_mm() else { return Ok(pot) };
        self.give(&mut pot, self.widest_m(&spec, height_mm / widest_mm));
        Ok(pot)
    }

    /// Gives every surface of a pot the profile.
    fn give(self, pot: &mut Pot, widest_m: f32) {
        let walls_m = [0.0, pot.spec().wall.0];
        for (surface, inset_m) in pot.surfaces_mut().iter_mut().zip(walls_m) {
            let (columns, rows) = (surface.shape().columns(), surface.shape().rows());
            for row in 0..rows {
                let radius_m = widest_m * self.profile(share(row, rows)) - inset_m;
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
        let radius = Metres(self.cylinder_m(&spec, Metres::from_mm(widest_mm).0));
        let mut pot = Pot::new(PotSpec { height: Metres::from_mm(height_mm), radius, ..spec })?;
        self.give(&mut pot, Metres::from_mm(widest_mm).0);
        Ok(pot)
    }
}

/// How high a row lies, from 0 at the foot to 1 at the rim.
fn share(row: u32, rows: u32) -> f32 {
    row as f32 / (rows - 1) as f32
}
