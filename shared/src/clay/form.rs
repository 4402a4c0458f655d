//! Pots to begin with: forms that potters know, as profiles of revolution.
//!
//! Owns the profiles; a pot made from one is a pot like any other.
//! Invariant: a form holds as much clay as a cylinder of its specification's radius and height, so that it is as high as it was made
//! until somebody presses it; one whose radii no pot of its specification may have is not made.

use super::lanes::root;
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
                root(part * (2.0 - part))
            }
            Self::Bottle => 0.72 + 0.28 * smooth(0.0, 0.35) - 0.62 * smooth(0.45, 0.82) + 0.06 * smooth(0.9, 1.0),
            Self::Ball => {
                let height = 1.6 * (share - 0.5);
                root(1.0 - height * height)
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
            Support::Backed => widest_m * root(mean_square),
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
                (wall_m + root(wall_m * wall_m + 8.0 * mean * clay_m2 / relation)) / (4.0 * mean)
            }
        }
    }

    /// The clay of a specification's cylinder in this form, with the form's own relation of height to width. The height follows where clay keeps
    /// its volume, as it does when somebody presses.
    ///
    /// # Errors
    /// [`PotError`] when no pot is made like that, or the clay makes the form wider or narrower than its pot may be.
    pub fn of_clay_of(self, spec: PotSpec) -> Result<Pot, PotError> {
        let mut pot = Pot::new(spec)?;
        if let Some(widest_m) = self.widest_of_clay_m(&spec) {
            self.give(&mut pot, widest_m)?;
        }
        Ok(pot)
    }

    /// Whether the clay with which a pot was made can be had in this form, without a pot being made.
    ///
    /// # Errors
    /// [`PotError::Measure`] as in [`Form::of_clay_of`].
    pub(crate) fn check_clay_of(self, pot: &Pot) -> Result<(), PotError> {
        self.widest_of_clay_m(pot.spec()).map_or(Ok(()), |widest_m| self.check(pot, widest_m))
    }

    /// Its widest radius of a specification's clay, m; none for a cylinder, which has the specification's own.
    fn widest_of_clay_m(self, spec: &PotSpec) -> Option<f32> {
        self.measures_mm().map(|[height_mm, widest_mm]| self.widest_m(spec, height_mm / widest_mm))
    }

    /// Radii of this form's rows on one of a pot's skins, which lies so far within the outer one, m.
    fn radii_m(self, rows: u32, widest_m: f32, inset_m: f32) -> impl Iterator<Item = f32> {
        (0..rows).map(move |row| widest_m * self.profile(share(row, rows)) - inset_m)
    }

    /// Checks that every radius is within the bounds of its surface: clamped, both skins of a wall could be one.
    fn check(self, pot: &Pot, widest_m: f32) -> Result<(), PotError> {
        for (surface, inset_m) in pot.surfaces().iter().zip(insets_m(pot)) {
            let (low_m, high_m) = surface.bounds_m();
            let radii_m = || self.radii_m(surface.shape().rows(), widest_m, inset_m);
            let ends_m = [
                ("widest radius", radii_m().fold(f32::MIN, f32::max)),
                ("narrowest radius", radii_m().fold(f32::MAX, f32::min)),
            ];
            for (field, radius_m) in ends_m {
                if !(low_m..=high_m).contains(&radius_m) {
                    let [value_mm, min_mm, max_mm] =
                        [radius_m, low_m, high_m].map(|length_m| Metres(length_m).told_mm());
                    return Err(PotError::Measure { field, value_mm, min_mm, max_mm });
                }
            }
        }
        Ok(())
    }

    /// Gives every surface of a pot the profile.
    fn give(self, pot: &mut Pot, widest_m: f32) -> Result<(), PotError> {
        self.check(pot, widest_m)?;
        let insets_m = insets_m(pot);
        for (surface, inset_m) in pot.surfaces_mut().iter_mut().zip(insets_m) {
            let (columns, rows) = (surface.shape().columns(), surface.shape().rows());
            for (row, radius_m) in (0..).zip(self.radii_m(rows, widest_m, inset_m)) {
                for column in 0..columns {
                    surface.set_radius(column, row, radius_m);
                }
            }
        }
        Ok(())
    }

    /// A pot of this form with the grid, wall and support of a specification; a cylinder has its measures as well.
    ///
    /// # Errors
    /// [`PotError`] when no pot is made like that, or the wall is too thick for where the form is narrowest.
    pub fn pot(self, spec: PotSpec) -> Result<Pot, PotError> {
        let Some([height_mm, widest_mm]) = self.measures_mm() else { return Pot::new(spec) };
        let radius = Metres(self.cylinder_m(&spec, Metres::from_mm(widest_mm).0));
        let mut pot = Pot::new(PotSpec { height: Metres::from_mm(height_mm), radius, ..spec })?;
        self.give(&mut pot, Metres::from_mm(widest_mm).0)?;
        Ok(pot)
    }
}

/// How far a pot's skins lie within the outer one, m.
const fn insets_m(pot: &Pot) -> [f32; 2] {
    [0.0, pot.spec().wall.0]
}

/// How high a row lies, from 0 at the foot to 1 at the rim.
fn share(row: u32, rows: u32) -> f32 {
    row as f32 / (rows - 1) as f32
}
