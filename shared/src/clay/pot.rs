//! The pot: its surfaces and its wall.
//!
//! The only place that knows how many surfaces a pot has: on a core the outer one, which the inner wall follows; of a hollow pot both
//! skins of the wall.
//! Invariant: a pot made from the same specification is the same, bit for bit.

use alloc::sync::Arc;
use alloc::vec::Vec;

use glam::Vec3;

use super::lanes::hypot;
use super::{Digest, GridError, GridShape, Surface, WallBending, Window, folds};
use crate::tool::Side;
use crate::units::Metres;

/// What a pot is made from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PotSpec {
    /// Elements of each surface.
    pub shape: GridShape,
    /// Height.
    pub height: Metres,
    /// Outer radius of the untouched cylinder.
    pub radius: Metres,
    /// Thickness of wall and bottom.
    pub wall: Metres,
    /// Whether clay that is pressed away and not raised beside makes the pot higher, as in
    /// [`super::Method::keeps_volume`].
    pub keeps_volume: bool,
    /// What stands behind the wall.
    pub support: Support,
}

/// What stands behind a pot's wall.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Support {
    /// A rigid core on which the clay slides: the wall cannot give way as a whole.
    #[default]
    Backed,
    /// Nothing: the wall bends under a tool and springs back, but for what of it has folded.
    Hollow,
}

impl Support {
    /// Its number in messages.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Backed => 0,
            Self::Hollow => 1,
        }
    }

    /// The support of a number; the default one for a number that means nothing here.
    #[must_use]
    pub const fn from_number(number: u8) -> Self {
        match number {
            1 => Self::Hollow,
            _ => Self::Backed,
        }
    }

    /// Its name, as people write it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Backed => "backed",
            Self::Hollow => "hollow",
        }
    }

    /// The support of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        [Self::Backed, Self::Hollow].into_iter().find(|support| support.name() == name)
    }
}

/// Why a pot cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PotError {
    /// The grid does not fit; choose another.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A measure is not a number or out of range; choose one within it.
    #[error("a pot {field} of {value_mm} mm cannot be used: choose one from {min_mm} to {max_mm} mm")]
    Measure {
        /// Which measure.
        field: &'static str,
        /// What was asked for, mm.
        value_mm: f32,
        /// Smallest allowed, mm.
        min_mm: f32,
        /// Largest allowed, mm.
        max_mm: f32,
    },
}

impl Default for PotSpec {
    /// The paper's 360 × 400 elements on a cylinder of 60 mm radius, 200 mm height and 8 mm wall, backed.
    fn default() -> Self {
        Self {
            shape: GridShape::PAPER,
            height: Metres::from_mm(200.0),
            radius: Metres::from_mm(60.0),
            wall: Metres::from_mm(8.0),
            keeps_volume: true,
            support: Support::Backed,
        }
    }
}

impl PotSpec {
    /// Largest radius any pot may reach.
    pub const RADIUS_MAX: Metres = Metres::from_mm(200.0);
    /// Thinnest wall, made or squeezed.
    pub const WALL_MIN: Metres = Metres::from_mm(1.0);

    /// How many surfaces bound the pot's clay: one on a core, both skins of a wall.
    #[must_use]
    pub const fn skins(&self) -> usize {
        match self.support {
            Support::Backed => 1,
            Support::Hollow => 2,
        }
    }

    /// Checks every measure.
    ///
    /// # Errors
    /// [`PotError::Measure`] naming the first measure out of range.
    pub fn check(&self) -> Result<(), PotError> {
        let within = |field, value: Metres, min_mm, max_mm| {
            if value.told_mm() >= min_mm && value.told_mm() <= max_mm {
                Ok(())
            } else {
                Err(PotError::Measure { field, value_mm: value.told_mm(), min_mm, max_mm })
            }
        };
        within("height", self.height, 20.0, 600.0)?;
        within("radius", self.radius, 10.0, 150.0)?;
        within("wall", self.wall, Self::WALL_MIN.as_mm(), Metres(self.radius.0 * 0.5).told_mm())
    }
}

/// A face of the pot that can be seen: which surface it follows and how far inside it lies.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Skin {
    /// Number of the surface whose radii it takes.
    pub surface: usize,
    /// Subtracted from the surface's radius, m.
    pub inset_m: f32,
    /// Whether the face looks away from the axis.
    pub faces_outwards: bool,
}

/// Clay on a wheel: surfaces over one height, with a wall between outside and inside.
#[derive(Clone, Debug, PartialEq)]
pub struct Pot {
    spec: PotSpec,
    surfaces: Vec<Surface>,
}

impl Pot {
    /// Thinnest column of clay, as a share of the first radius: the original's 3 of 20 units.
    const RADIUS_MIN_SHARE: f32 = 3.0 / 20.0;
    /// Farthest that a pot grows or shrinks.
    const GROWTH_MAX: f64 = 2.0;

    /// An untouched cylinder.
    ///
    /// # Errors
    /// [`PotError::Measure`] when a measure of the specification is out of range.
    pub fn new(spec: PotSpec) -> Result<Self, PotError> {
        spec.check()?;
        // the inner wall needs room beside the axis
        let radius_min_m = (spec.radius.0 * Self::RADIUS_MIN_SHARE).max(spec.wall.0 * 1.25).min(spec.radius.0);
        let bending = (spec.support == Support::Hollow)
            .then(|| Arc::new(WallBending::new(spec.radius.0, spec.wall.0, spec.height.0)));
        let skin = |inset_m: f32| {
            let bounds_m = (radius_min_m - inset_m, PotSpec::RADIUS_MAX.0);
            Surface::cylinder(
                spec.shape,
                spec.height.0,
                spec.radius.0 - inset_m,
                bounds_m,
                spec.wall.0,
                bending.clone(),
            )
        };
        let surfaces = match spec.support {
            Support::Backed => alloc::vec![skin(0.0)],
            Support::Hollow => {
                let folds = folds::untouched(&spec, (radius_min_m, PotSpec::RADIUS_MAX.0));
                alloc::vec![skin(0.0).met_from(Side::Outside), skin(spec.wall.0).met_from(Side::Inside), folds]
            }
        };
        Ok(Self { spec, surfaces })
    }

    /// The same pot with surfaces of another grid.
    pub(super) fn on_grid(&self, shape: GridShape, surface: impl FnMut(&Surface) -> Surface) -> Self {
        let (skins, others) = self.surfaces.split_at(self.spec.skins());
        let surfaces = skins.iter().map(surface).chain(others.iter().cloned()).collect();
        Self { spec: PotSpec { shape, ..self.spec }, surfaces }
    }

    /// What it was made from.
    #[must_use]
    pub const fn spec(&self) -> &PotSpec {
        &self.spec
    }

    /// Its surfaces: the skins, and of a hollow pot one more, on a grid of its own, that says how far the wall has folded
    /// ([`Pot::folded_m`]).
    #[must_use]
    pub fn surfaces(&self) -> &[Surface] {
        &self.surfaces
    }

    /// Its surfaces, to be changed.
    pub fn surfaces_mut(&mut self) -> &mut [Surface] {
        &mut self.surfaces
    }

    /// The surface that a tool on this side of the wall meets.
    #[must_use]
    pub fn met_from(&self, side: Side) -> &Surface {
        match (side, &*self.surfaces) {
            (Side::Inside, [_, inner, ..]) => inner,
            (_, surfaces) => &surfaces[0],
        }
    }

    /// How the wall bends; nothing when it is backed.
    #[must_use]
    pub fn bending(&self) -> Option<&WallBending> {
        self.surfaces[0].bending()
    }

    /// The faces to draw and to build solids from, the outermost first.
    #[must_use]
    pub fn skins(&self) -> [Skin; 2] {
        let inner = self.spec.skins() - 1;
        [
            Skin { surface: 0, inset_m: 0.0, faces_outwards: true },
            Skin { surface: inner, inset_m: self.surfaces[inner].inset_m(Side::Inside), faces_outwards: false },
        ]
    }

    /// Whether a point, m, stands above the rim, where a tool may change its side of the wall.
    #[must_use]
    pub fn is_above_rim(&self, point_m: Vec3) -> bool {
        point_m.z > self.surfaces[0].height_m()
    }

    /// The side of the wall's middle on which a point stands, m; at the heights of foot and rim beyond them.
    #[must_use]
    pub fn side_of(&self, point_m: Vec3) -> Side {
        let surface = &self.surfaces[0];
        let (shape, last) = (surface.shape(), surface.shape().rows() - 1);
        let column = libm::roundf(libm::atan2f(point_m.y, point_m.x) / shape.column_angle_rad());
        let row = libm::roundf((point_m.z / surface.row_height_m()).clamp(0.0, last as f32));
        let face_m = |side: Side| {
            let surface = self.met_from(side);
            surface.column_m(shape.wrap(column as i64))[row as usize] - surface.inset_m(side)
        };
        let radius_m = 0.5 * (face_m(Side::Outside) + face_m(Side::Inside));
        if hypot(point_m.x, point_m.y) < radius_m { Side::Inside } else { Side::Outside }
    }

    /// Volume within the outermost surface, m³.
    #[must_use]
    pub fn enclosed_volume_m3(&self) -> f64 {
        self.surfaces[0].enclosed_volume_m3()
    }

    /// Volume of the clay between foot and rim, m³: of a wall, or of what stands on a core with the core itself.
    #[must_use]
    pub fn clay_m3(&self) -> f64 {
        self.between(Surface::enclosed_volume_m3)
    }

    /// What is so much within the outermost surface, less what of it is within the inner skin of a hollow pot.
    fn between(&self, within: impl Fn(&Surface) -> f64) -> f64 {
        match &*self.surfaces {
            [outer, inner, ..] => within(outer) - within(inner),
            surfaces => within(&surfaces[0]),
        }
    }

    /// Lets the pot grow by what was pressed away, after radii in the given windows of its surfaces have changed.
    ///
    /// `h = h₀·V₀/V`, V the volume of the clay at the first height h₀, within half and twice that height.
    pub fn settle(&mut self, windows: impl Iterator<Item = (usize, Window)>) {
        if !self.spec.keeps_volume {
            return;
        }
        for (surface, window) in windows {
            self.surfaces[surface].note_changed(window);
        }
        self.surfaces.iter_mut().for_each(Surface::sum_up);
        let [first_m2, now_m2] = [0, 1].map(|at| self.between(|surface| surface.square_sums_m2()[at]));
        let growth = (first_m2 / now_m2).clamp(1.0 / Self::GROWTH_MAX, Self::GROWTH_MAX);
        let height_m = (f64::from(self.surfaces[0].first_height_m()) * growth) as f32;
        self.surfaces.iter_mut().for_each(|surface| surface.set_height(height_m));
    }

    /// Becomes another pot of the same specification without allocating.
    ///
    /// # Panics
    /// When the pots differ in shape.
    pub fn copy_from(&mut self, from: &Self) {
        for (surface, from) in self.surfaces.iter_mut().zip(&from.surfaces) {
            surface.copy_from(from);
        }
    }

    /// Volume of clay that was pressed away since the pot was untouched, m³, negative when it was pressed out: `V₀ − V` at the first
    /// height. A pot that keeps its volume has grown by as much.
    #[must_use]
    pub fn pressed_m3(&self) -> f64 {
        self.between(Surface::pressed_m3)
    }

    /// Takes the radii of a window of one surface over from a pot of the same specification, and its height, which all surfaces have.
    ///
    /// # Panics
    /// When the pots differ in shape or there is no such surface.
    pub fn copy_window(&mut self, from: &Self, surface: usize, window: Window) {
        self.surfaces[surface].copy_window(&from.surfaces[surface], window);
        let height_m = from.surfaces[surface].height_m();
        self.surfaces.iter_mut().for_each(|surface| surface.set_height(height_m));
    }

    /// Digest of every radius, bit for bit.
    #[must_use]
    pub fn digest(&self) -> u64 {
        let mut digest = Digest::default();
        for surface in &self.surfaces {
            surface.digest_into(&mut digest);
        }
        digest.finish()
    }
}
