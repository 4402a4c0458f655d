//! The one interface behind which the deformation methods stand.
//!
//! Owns what a method is told and what it answers; each method has its own file.
//! Invariant: a method reads the surface and writes only its footprint, so that presses of one sub-step do not see
//! each other.

use glam::Vec3;

use super::{Footprint, ImprovedCsem, OriginalCsem, PlasticCsem, Press, Surface};

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
