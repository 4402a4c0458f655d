//! What clay is made of: how strong it is, how stiff, how slowly it gives way, and how all of it follows its wetness.
//!
//! Owns the numbers of a material, their bounds and the moisture law; how a press turns them into a dent is the
//! methods' affair. The published methods know the time constant alone, so wetness changes little for them.
//! Invariant: a material made here is finite and within its bounds in every number.
//!
//! Sourced: the strength at the liquid limit, 1.7 kPa (Wroth and Wood 1978); its growth by a factor of 35 to the
//! plastic limit (Vardanega and Haigh 2014, 641 fall-cone tests); that viscosity falls exponentially with the liquidity
//! index where clay is plastic (Mahajan and Budhu 2009) and grows with strength as in Locat and Demers 1988.
//! Chosen: the reference clay, its E/σ_y of 50 (published moduli of wet clay spread over 1–5 MPa), its τ, which is the
//! original program's, and where the presets lie.

use crate::units::Seconds;

/// Why a material cannot be had.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{field} = {value} cannot be used: choose a number from {min} to {max}")]
pub struct MaterialError {
    /// Name of the quantity, with its unit.
    pub field: &'static str,
    /// What was given.
    pub value: f32,
    /// Least allowed.
    pub min: f32,
    /// Largest allowed.
    pub max: f32,
}

/// A quantity's name and range.
struct Range {
    field: &'static str,
    min: f32,
    max: f32,
}

impl Range {
    fn check(&self, value: f32) -> Result<f32, MaterialError> {
        if (self.min..=self.max).contains(&value) {
            return Ok(value);
        }
        Err(MaterialError { field: self.field, value, min: self.min, max: self.max })
    }

    /// The nearest allowed value; `otherwise` when it is not a number.
    const fn nearest(&self, value: f32, otherwise: f32) -> f32 {
        if value.is_nan() { otherwise } else { value.clamp(self.min, self.max) }
    }
}

const WETNESS: Range = Range { field: "wetness", min: 0.0, max: 1.0 };
/// From one that gives way within two ticks to one that a hand takes for solid.
const VISCOSITY: Range = Range { field: "viscosity (s)", min: 0.002, max: 5.0 };
/// A decade beyond what the moisture law gives on either side.
const YIELD: Range = Range { field: "yield stress (Pa)", min: 300.0, max: 1e6 };
/// As far as the yield stresses with E/σ_y from 30 to 100.
const YOUNGS: Range = Range { field: "Young's modulus (Pa)", min: 1e4, max: 1e8 };

/// How wet clay is: the liquidity index, (water − plastic limit)/(liquid limit − plastic limit).
///
/// 0 at the plastic limit, where clay begins to crumble; 1 at the liquid limit, where it begins to run.
///
/// ```
/// use pottery_shared::clay::Wetness;
/// assert_eq!(Wetness::new(0.4).unwrap().liquidity_index(), 0.4);
/// assert!(Wetness::new(1.5).is_err());
/// ```
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub struct Wetness(f32);

impl Wetness {
    /// Clay at its plastic limit.
    pub const DRIEST: Self = Self(WETNESS.min);
    /// Clay at its liquid limit.
    pub const WETTEST: Self = Self(WETNESS.max);

    /// The wetness of a liquidity index.
    ///
    /// # Errors
    /// [`MaterialError`] for one that is not between [`Self::DRIEST`] and [`Self::WETTEST`].
    pub fn new(liquidity_index: f32) -> Result<Self, MaterialError> {
        WETNESS.check(liquidity_index).map(Self)
    }

    /// The wetness nearest to a liquidity index; that of throwing clay for what is not a number.
    #[must_use]
    pub const fn nearest(liquidity_index: f32) -> Self {
        Self(WETNESS.nearest(liquidity_index, Preset::Throwing.wetness().0))
    }

    /// The liquidity index.
    #[must_use]
    pub const fn liquidity_index(self) -> f32 {
        self.0
    }
}

/// Clay as potters name it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Preset {
    /// A little wetter than the plastic limit: keeps its shape, needs force.
    Stiff,
    /// For throwing, the reference clay.
    #[default]
    Throwing,
    /// Wetter than one throws by choice.
    Soft,
    /// At the liquid limit: hardly carries itself.
    Slip,
}

impl Preset {
    /// Every preset, from the driest to the wettest.
    pub const ALL: [Self; 4] = [Self::Stiff, Self::Throwing, Self::Soft, Self::Slip];

    /// How wet it is; clay is thrown at a liquidity index from 0.2 to 0.4, the others lie about that.
    #[must_use]
    pub const fn wetness(self) -> Wetness {
        Wetness(match self {
            Self::Stiff => 0.10,
            Self::Throwing => 0.27,
            Self::Soft => 0.45,
            Self::Slip => 1.0,
        })
    }

    /// Its name, as people write it.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Stiff => "stiff",
            Self::Throwing => "throwing",
            Self::Soft => "soft",
            Self::Slip => "slip",
        }
    }

    /// The preset of a name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|preset| preset.name() == name)
    }
}

/// How strong clay is, for the methods that ask.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strength {
    /// Young's modulus E, Pa.
    pub youngs_pa: f32,
    /// Yield stress σ_y, Pa.
    pub yield_pa: f32,
}

impl Strength {
    /// Whether both numbers are within the bounds of a material.
    #[must_use]
    pub fn is_sound(&self) -> bool {
        YOUNGS.check(self.youngs_pa).is_ok() && YIELD.check(self.yield_pa).is_ok()
    }
}

impl Default for Strength {
    /// The reference clay: E = 2 MPa, σ_y = 40 kPa (an undrained strength of 23 kPa).
    fn default() -> Self {
        Material::REFERENCE.strength
    }
}

/// How the clay answers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Time constant τ with which clay beyond its yield gives way to a tool.
    pub viscosity: Seconds,
    /// How strong it is.
    pub strength: Strength,
}

impl Material {
    /// Runniest clay: gives way within two ticks.
    pub const VISCOSITY_MIN: Seconds = Seconds(VISCOSITY.min);
    /// Slowest clay.
    pub const VISCOSITY_MAX: Seconds = Seconds(VISCOSITY.max);
    /// Least Young's modulus, Pa.
    pub const YOUNGS_PA_MIN: f32 = YOUNGS.min;
    /// Largest Young's modulus, Pa.
    pub const YOUNGS_PA_MAX: f32 = YOUNGS.max;
    /// Least yield stress, Pa.
    pub const YIELD_PA_MIN: f32 = YIELD.min;
    /// Largest yield stress, Pa.
    pub const YIELD_PA_MAX: f32 = YIELD.max;

    /// Clay for throwing, that of the finite-element dents, with the original's ν = 120 at 1 kHz: τ = 119.5 ms.
    ///
    /// The moisture law gives 39.5 kPa for its wetness; 40 kPa is that to the two digits in which its constant is known.
    const REFERENCE: Self = Self { viscosity: Seconds(0.1195), strength: Strength { youngs_pa: 2e6, yield_pa: 40e3 } };
    /// ln 35: the growth of strength from the liquid to the plastic limit. Vardanega and Haigh 2014.
    const STRENGTH_GROWTH: f32 = 3.555_348;
    /// Exponent of τ over strength: `η ∝ s_u^1.16` by the ends of what Locat and Demers 1988 measured (90 Pa with 0.2 Pa·s,
    /// 5 Pa with 0.007 Pa·s), less the 1 of the stiffness that resists.
    const TIME_OVER_STRENGTH: f32 = 0.16;

    /// A material of these numbers.
    ///
    /// # Errors
    /// [`MaterialError`] for the first that is out of its range, or not a number.
    pub fn new(viscosity: Seconds, strength: Strength) -> Result<Self, MaterialError> {
        Ok(Self {
            viscosity: Seconds(VISCOSITY.check(viscosity.0)?),
            strength: Strength {
                youngs_pa: YOUNGS.check(strength.youngs_pa)?,
                yield_pa: YIELD.check(strength.yield_pa)?,
            },
        })
    }

    /// The nearest material that is allowed: each number on its own, and the reference clay's where it is not a number.
    #[must_use]
    pub const fn nearest(viscosity: Seconds, strength: Strength) -> Self {
        let reference = Self::REFERENCE;
        Self {
            viscosity: Seconds(VISCOSITY.nearest(viscosity.0, reference.viscosity.0)),
            strength: Strength {
                youngs_pa: YOUNGS.nearest(strength.youngs_pa, reference.strength.youngs_pa),
                yield_pa: YIELD.nearest(strength.yield_pa, reference.strength.yield_pa),
            },
        }
    }

    /// Clay of that wetness: the moisture law.
    ///
    /// With LI the liquidity index and LI₀ that of throwing clay:
    /// - strength: `s_u = 1.7 kPa·35^(1 − LI)`, undrained, and `σ_y = √3·s_u` (von Mises in pure shear); written as
    ///   `σ_y = 40 kPa·35^(LI₀ − LI)`, so that the reference clay is met to the bit;
    /// - stiffness: `E = 50·σ_y`; what a dent looks like is governed by E/σ_y;
    /// - time constant: `τ = η/G` with `η ∝ s_u^1.16` and `G ∝ E ∝ s_u`, so `τ = 119.5 ms·35^(0.16·(LI₀ − LI))`.
    ///
    /// The viscosities were measured at LI from 2 to 5 and are carried on along strength, not along LI; at LI₀ that
    /// gives 125 Pa·s, and their own power law `(9.27/LI)^3.3` mPa·s 117. Such a clay over its shear modulus would give
    /// way in 0.2 ms, so only the change with wetness is the clay's; the 119.5 ms are what the original's hand felt.
    /// Below LI 0.2 the strength is an extrapolation.
    #[must_use]
    pub fn from_wetness(wetness: Wetness) -> Self {
        let drier = Preset::Throwing.wetness().0 - wetness.0;
        let stronger = libm::expf(Self::STRENGTH_GROWTH * drier);
        let slower = libm::expf(Self::TIME_OVER_STRENGTH * Self::STRENGTH_GROWTH * drier);
        let Self { viscosity, strength } = Self::REFERENCE;
        Self {
            viscosity: Seconds(viscosity.0 * slower),
            strength: Strength { youngs_pa: strength.youngs_pa * stronger, yield_pa: strength.yield_pa * stronger },
        }
    }

    /// How wet clay of this yield stress is by the moisture law; the nearest end for what is beyond it.
    #[must_use]
    pub fn wetness(self) -> Wetness {
        let stronger = self.strength.yield_pa / Self::REFERENCE.strength.yield_pa;
        Wetness::nearest(Preset::Throwing.wetness().0 - libm::logf(stronger) / Self::STRENGTH_GROWTH)
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
    /// The reference clay, which is that of [`Preset::Throwing`].
    fn default() -> Self {
        Self::REFERENCE
    }
}
