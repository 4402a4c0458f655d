//! The one interface behind which the deformation methods stand.
//!
//! Owns what a method is told and what it answers; each method has its own file.
//! Invariant: a method reads the surface and writes only its footprint, so that presses of one sub-step do not see
//! each other.

use glam::Vec3;

use super::{Footprint, ImprovedCsem, OriginalCsem, PlasticCsem, Press, Surface};
use crate::units::Seconds;

/// What a press meets: the force on the tool and how much clay it touches.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Contact {
    /// Force of the clay on the tool, N, in the frame in which the press was given.
    pub force_n: Vec3,
    /// Number of elements in contact.
    pub elements: u32,
    /// Largest penetration, m.
    pub penetration_m: f32,
}

/// How strong clay is, for the methods that ask.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Young's modulus E, Pa.
    pub youngs_pa: f32,
    /// Yield stress σ_y, Pa.
    pub yield_pa: f32,
}

impl Default for Strength {
    /// Clay for throwing: E = 2 MPa, σ_y = 40 kPa (an undrained strength of about 20 kPa).
    fn default() -> Self {
        Self { youngs_pa: 2e6, yield_pa: 40e3 }
    }
}

/// How the clay answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Time constant τ with which clay gives way to a tool.
    pub viscosity: Seconds,
    /// How strong it is.
    pub strength: Strength,
}

impl Material {
    /// Runniest clay: gives way within one tick.
    pub const VISCOSITY_MIN: Seconds = Seconds(0.002);
    /// Stiffest clay.
    pub const VISCOSITY_MAX: Seconds = Seconds(5.0);

    /// A material whose viscosity is brought into the allowed range; not a number takes the default.
    #[must_use]
    pub fn new(viscosity: Seconds) -> Self {
        if viscosity.0.is_nan() {
            return Self::default();
        }
        let viscosity = Seconds(viscosity.0.clamp(Self::VISCOSITY_MIN.0, Self::VISCOSITY_MAX.0));
        Self { viscosity, strength: Strength::default() }
    }

    /// Share of the penetration that yields within `dt`: `1 − exp(−dt/τ)`.
    ///
    /// The original's `1/ν` a tick is the same with τ = −dt / ln(1 − 1/ν), which makes the depth independent of the
    /// loop's rate.
    #[must_use]
    pub fn response(self, dt: Seconds) -> f32 {
        1.0 - libm::expf(-dt.0 / self.viscosity.0)
    }
}

impl Default for Material {
    /// The original's ν = 120 at 1 kHz: τ = 119.5 ms.
    fn default() -> Self {
        Self { viscosity: Seconds(0.1195), strength: Strength::default() }
    }
}

/// A way for clay to answer a press.
pub trait Method {
    /// Evaluates one press against a surface and writes the displacement it asks for.
    ///
    /// The footprint is empty afterwards when nothing is touched.
    fn press(&self, surface: &Surface, press: &Press, footprint: &mut Footprint) -> Contact;
}

/// The methods one can choose from.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MethodKind {
    /// Circular Sector Element Method without interaction of neighbours.
    Original,
    /// The same with local propagation of the response.
    #[default]
    Improved,
    /// The studio's own: elastic up to yield, plastic beyond, displaced clay returned as a rim.
    Plastic,
}

impl MethodKind {
    /// Its number in messages and files.
    #[must_use]
    pub const fn number(self) -> u8 {
        match self {
            Self::Original => 0,
            Self::Improved => 1,
            Self::Plastic => 2,
        }
    }

    /// The method of a name, as people write it.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        match name {
            "original" => Some(Self::Original),
            "improved" => Some(Self::Improved),
            "plastic" => Some(Self::Plastic),
            _ => None,
        }
    }

    /// The method of a number; the default one for a number that means nothing here.
    #[must_use]
    pub const fn from_number(number: u8) -> Self {
        match number {
            0 => Self::Original,
            2 => Self::Plastic,
            _ => Self::Improved,
        }
    }

    /// The method itself.
    #[must_use]
    pub fn method(self) -> &'static dyn Method {
        match self {
            Self::Original => &OriginalCsem,
            Self::Improved => &ImprovedCsem,
            Self::Plastic => &PlasticCsem,
        }
    }
}
