//! The shapes that are pressed into the clay: the sphere.
//!
//! Knows no clay: a tool is a shape, where it stands is said by whoever presses with it.
//! Invariant: a tool that exists has a size within [`Sphere::RADIUS_MIN`] and [`Sphere::RADIUS_MAX`].

use crate::units::Metres;

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
                radius_mm: radius.as_mm(),
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
}

impl Default for Sphere {
    /// A fingertip: 12 mm.
    fn default() -> Self {
        Self { radius: Metres::from_mm(12.0) }
    }
}
