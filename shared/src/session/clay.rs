//! The clay's numbers between the core and the wire, for both ends.
//!
//! The one conversion, so that no end takes numbers that the other would not.
//! Invariant: whatever arrives becomes a material within its bounds.

use crate::clay::{Material, Strength};
use crate::protocol::ClayWire;
use crate::units::Seconds;

impl From<Material> for ClayWire {
    fn from(material: Material) -> Self {
        let Material { viscosity, strength } = material;
        Self { viscosity_s: viscosity.0, youngs_pa: strength.youngs_pa, yield_pa: strength.yield_pa }
    }
}

impl From<ClayWire> for Material {
    /// The nearest material that is allowed; see [`Material::nearest`].
    fn from(clay: ClayWire) -> Self {
        let strength = Strength { youngs_pa: clay.youngs_pa, yield_pa: clay.yield_pa };
        Self::nearest(Seconds(clay.viscosity_s), strength)
    }
}
