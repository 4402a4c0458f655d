//! The shapes that are pressed into the clay, and their motion as it is sampled: the sphere, and convex tools of flat
//! facets.
//!
//! Knows no clay: a tool is a shape, where it stands is said by whoever presses with it.
//! Invariant: a tool that exists has a size within [`Sphere::RADIUS_MIN`] and [`Sphere::RADIUS_MAX`], or
//! [`ConvexTool::RADIUS_MIN`] and [`ConvexTool::RADIUS_MAX`].

mod convex;
mod cut;
mod facets;
mod orientation;
mod outline;
pub mod rack;
mod ray;
mod ridges;
mod section;

pub use convex::{ConvexError, ConvexTool};
pub use orientation::Orientation;
pub(crate) use ray::Ray;
pub(crate) use section::Eights;
pub use section::{Extent, Lattice, Pose, Section, Sections, Sides};

use glam::Vec3;

use crate::units::{Metres, Tick};

/// Least part of a normal along a ray by which a tool's slope is told: where a tool grazes clay, its slope has no end.
pub(crate) const STEEPEST: f32 = 0.5;

/// A spherical tool, the paper's haptic interface point (HIP).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    radius: Metres,
}

/// Why a tool cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ToolError {
    /// The radius is not a number or outside the allowed range; choose one within it.
    #[error("a tool radius of {radius_mm} mm cannot be used: choose one from {min_mm} to {max_mm} mm")]
    Radius {
        /// The radius asked for, mm.
        radius_mm: f32,
        /// Smallest allowed radius, mm.
        min_mm: f32,
        /// Largest allowed radius, mm.
        max_mm: f32,
    },
}

impl Sphere {
    /// Smallest sphere: half a millimetre, about one element of the default grid.
    pub const RADIUS_MIN: Metres = Metres::from_mm(0.5);
    /// Largest sphere: a flat palm.
    pub const RADIUS_MAX: Metres = Metres::from_mm(40.0);

    /// A sphere of the given radius.
    ///
    /// # Errors
    /// [`ToolError::Radius`] outside [`Sphere::RADIUS_MIN`] to [`Sphere::RADIUS_MAX`], or when not a number.
    pub fn new(radius: Metres) -> Result<Self, ToolError> {
        if radius.0 >= Self::RADIUS_MIN.0 && radius.0 <= Self::RADIUS_MAX.0 {
            Ok(Self { radius })
        } else {
            Err(ToolError::Radius {
                radius_mm: radius.told_mm(),
                min_mm: Self::RADIUS_MIN.as_mm(),
                max_mm: Self::RADIUS_MAX.as_mm(),
            })
        }
    }

    /// The sphere's radius.
    #[must_use]
    pub const fn radius(self) -> Metres {
        self.radius
    }

    /// The sphere of a radius in whole micrometres, as it travels, if there is one.
    #[must_use]
    pub fn of_micrometres(radius_um: u16) -> Option<Self> {
        Self::new(Metres(f32::from(radius_um) * 1e-6)).ok()
    }

    /// Its radius to the nearest micrometre.
    #[must_use]
    pub fn micrometres(self) -> u16 {
        libm::roundf(self.radius.0 * 1e6) as u16
    }
}

impl Default for Sphere {
    /// A fingertip: 12 mm.
    fn default() -> Self {
        Self { radius: Metres::from_mm(12.0) }
    }
}

/// Which convex tool: its place in a rack, counted from 0. The first four hang on every wall.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape(pub u8);

impl Shape {
    /// [`rack::rib`].
    pub const RIB: Self = Self(0);
    /// [`rack::blade`].
    pub const BLADE: Self = Self(1);
    /// [`rack::knuckle`].
    pub const KNUCKLE: Self = Self(2);
    /// [`rack::loop_end`].
    pub const LOOP: Self = Self(3);
    /// Those that hang on every wall, with what people call them.
    pub const NAMED: [(&str, Self); 4] =
        [("rib", Self::RIB), ("blade", Self::BLADE), ("knuckle", Self::KNUCKLE), ("loop", Self::LOOP)];

    /// Its name, if it hangs on every wall.
    #[must_use]
    pub fn name(self) -> Option<&'static str> {
        Self::NAMED.iter().find(|(_, shape)| *shape == self).map(|(name, _)| *name)
    }

    /// The shape of that name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        Self::NAMED.iter().find(|(known, _)| *known == name).map(|(_, shape)| *shape)
    }
}

/// What is pressed into the clay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tool {
    /// A sphere, alike from all sides.
    Sphere(Sphere),
    /// A convex tool, which has an orientation.
    Convex(Shape),
}

impl Tool {
    /// The sphere, if it is one.
    #[must_use]
    pub const fn sphere(self) -> Option<Sphere> {
        match self {
            Self::Sphere(sphere) => Some(sphere),
            Self::Convex(_) => None,
        }
    }

    /// Its number in the rack, if it is convex.
    #[must_use]
    pub const fn shape(self) -> Option<Shape> {
        match self {
            Self::Sphere(_) => None,
            Self::Convex(shape) => Some(shape),
        }
    }
}

impl Default for Tool {
    fn default() -> Self {
        Self::Sphere(Sphere::default())
    }
}

impl From<Sphere> for Tool {
    fn from(sphere: Sphere) -> Self {
        Self::Sphere(sphere)
    }
}

/// On which side of the wall a tool works.
///
/// It follows from where the tool came, over the rim or not, and never from where it is: a hand that pushes deep does not
/// come out inside.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Side {
    /// Pushes towards the axis.
    #[default]
    Outside,
    /// Pushes away from the axis.
    Inside,
}

/// Where a tool stands, in steps of [`Position::STEP`]: what a client presses with is exactly what it sends.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Position(pub [i32; 3]);

impl Position {
    /// Resolution of a position: 10 µm, below what devices resolve (55 µm for a PHANToM Omni).
    pub const STEP: Metres = Metres(1e-5);
    /// Farthest a tool may be from the foot of the pot on any axis.
    pub const REACH: Metres = Metres(1.0);

    /// The nearest step to a point, m; `None` when it is not a number or out of [`Position::REACH`].
    #[must_use]
    pub fn nearest(point_m: Vec3) -> Option<Self> {
        let reach = Self::REACH.0;
        let within = point_m.to_array().iter().all(|along| along.is_finite() && (-reach..=reach).contains(along));
        within.then(|| Self(point_m.to_array().map(|along| libm::roundf(along / Self::STEP.0) as i32)))
    }

    /// The point, m.
    #[must_use]
    pub fn point_m(self) -> Vec3 {
        Vec3::from_array(self.0.map(|steps| steps as f32 * Self::STEP.0))
    }

    /// Whether it lies within [`Position::REACH`].
    #[must_use]
    pub fn is_within_reach(self) -> bool {
        let reach = (Self::REACH.0 / Self::STEP.0) as i32;
        self.0.iter().all(|steps| (-reach..=reach).contains(steps))
    }

    /// Distance to another position, m.
    #[must_use]
    pub fn distance_m(self, other: Self) -> f32 {
        self.point_m().distance(other.point_m())
    }
}

/// A tool held at a place in the room for one tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolSample {
    /// The tick for which it was held there.
    pub tick: Tick,
    /// The tool.
    pub tool: Tool,
    /// How it is turned; says nothing of a sphere.
    pub orientation: Orientation,
    /// Its centre in the room: z up along the wheel's axis, the foot of the pot at zero.
    pub centre: Position,
    /// On which side of the wall it works.
    pub side: Side,
}

impl ToolSample {
    /// Fastest a hand moves; a faster sample is refused.
    pub const SPEED_MAX_M_S: f32 = 5.0;
    /// Ticks between two samples of which the later goes on where the earlier was.
    const GAP_MAX: i64 = 4;

    /// Whether the tool went from `before` to here: the same one on the same side, a few ticks ago, no faster than a hand.
    #[must_use]
    pub fn follows(&self, before: &Self) -> bool {
        let ticks = self.tick.since(before.tick);
        (1..=Self::GAP_MAX).contains(&ticks)
            && self.tool == before.tool
            && self.side == before.side
            && self.centre.distance_m(before.centre) <= Self::SPEED_MAX_M_S * Tick::PERIOD.0 * ticks as f32
    }
}
