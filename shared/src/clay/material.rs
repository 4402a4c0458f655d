//! What clay is made of: how strong it is and how slowly it gives way.
//!
//! Owns the numbers of a material and their bounds; how a press turns them into a dent is the methods' affair.
//! Invariant: a material's viscosity is finite and within its bounds.

use crate::units::Seconds;

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
