//! Where the constants of the studio's own clay come from: its law fitted to finite-element dents of a backed wall.
//!
//! Owns which constants are free and what counts as a misfit; the dents to meet are [`dents`]', the strokes, which nothing
//! is fitted to but one share, are [`strokes`]'.
//! Invariant: the same dents, start and number of iterations give the same constants, bit for bit.

pub mod dents;
pub mod simplex;
pub mod strokes;

use pottery_shared::clay::{PlasticCsem, PlasticLaw};

use crate::dent::DentError;
use crate::reference::BadProfile;
use dents::KnownDent;

/// Why nothing can be fitted.
#[derive(Debug, thiserror::Error)]
pub enum FitError {
    /// A dent cannot be pressed.
    #[error(transparent)]
    Dent(#[from] DentError),
    /// A file of the reference is damaged.
    #[error("{file}: {source}; take it anew from the repository")]
    Reference {
        /// Which, in `tests/data/fem`.
        file: String,
        /// Why.
        source: BadProfile,
    },
    /// A force is not given at a travel.
    #[error("{file} knows no force at {depth_mm} mm; take it anew from the repository, or a travel that it reaches")]
    Force {
        /// Which, in `tests/data/fem`.
        file: String,
        /// Travel, mm.
        depth_mm: f32,
    },
}

/// Steps in which the tool comes in while a law is fitted; it stands for five times as many. The law does not depend on it.
const STEPS_IN: u32 = 60;
/// Score of constants with which the law makes no sense: worse than any that does.
const OUT_OF_RANGE: f64 = 10.0;
/// Weights of the dent that stays, of the force, and of the force of a dent of 4 mm: a hand hardly goes so deep, and the law,
/// whose force is 7 to 14 % too large there, shall not bend for it elsewhere.
const PERMANENT: f64 = 1.5;
const FORCE: f64 = 0.7;
const DEEP_FORCE: f64 = 0.2;
/// From here on a dent is deep, mm.
const DEEP_MM: f32 = 3.0;

/// Constants that are free, in this order; `rim_end` and `slide_share` are held.
pub const FREE: [&str; 6] =
    ["hardness", "recovery", "rim_strain", "rim_width", "hardness_by_stiffness", "hardness_by_slope"];

/// The free constants of a law.
#[must_use]
pub fn free(law: &PlasticLaw) -> [f64; 6] {
    [law.hardness, law.recovery, law.rim_strain, law.rim_width, law.hardness_by_stiffness, law.hardness_by_slope]
        .map(f64::from)
}

/// The law with these free constants and what is held of another; `None` where it makes no sense.
#[must_use]
pub fn law_of(free: [f64; 6], held: &PlasticLaw) -> Option<PlasticLaw> {
    let [hardness, recovery, rim_strain, rim_width, hardness_by_stiffness, hardness_by_slope] =
        free.map(|value| value as f32);
    let sense = hardness > 0.5 && recovery > 0.05 && rim_strain > 1.0 && rim_width > 0.05;
    let law =
        PlasticLaw { hardness, hardness_by_stiffness, hardness_by_slope, recovery, rim_strain, rim_width, ..*held };
    sense.then_some(law)
}

/// How far a law is from one dent.
#[derive(Clone, Copy, Debug)]
pub struct Misfit {
    /// Root mean square over 15 mm to all sides of the tool, over its travel, of the surface that stays.
    pub permanent: f64,
    /// The same with the tool in.
    pub loaded: f64,
    /// Error of the force over the largest of the dent's press; positive is too hard.
    pub force: f64,
    /// What of it counts.
    pub score: f64,
}

impl Misfit {
    /// Presses a dent with a law.
    ///
    /// # Errors
    /// [`FitError::Dent`] for figures that make no sense.
    pub fn of(law: PlasticLaw, known: &KnownDent) -> Result<Self, FitError> {
        let pressed = known.dent.press_with(PlasticCsem { law }, STEPS_IN)?;
        let (permanent, loaded) = (known.difference(&pressed, true), known.difference(&pressed, false));
        let force = (f64::from(pressed.contact().force_n.x) - known.force_n) / known.largest_force_n;
        let weight = if known.dent.depth.as_mm() < DEEP_MM { FORCE } else { DEEP_FORCE };
        let score = PERMANENT * permanent + loaded + weight * force.abs();
        Ok(Self { permanent, loaded, force, score })
    }
}

/// How far a law is from each dent.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn misfits(law: PlasticLaw, known: &[KnownDent]) -> Result<Vec<Misfit>, FitError> {
    known.iter().map(|known| Misfit::of(law, known)).collect()
}

/// Mean score of some misfits: `1.5·RMS permanent + RMS loaded + 0.7·|force error|`, the force 0.2 when deep.
#[must_use]
pub fn score(misfits: &[Misfit]) -> f64 {
    misfits.iter().map(|misfit| misfit.score).sum::<f64>() / misfits.len().max(1) as f64
}

/// What a fit found.
#[derive(Clone, Copy, Debug)]
pub struct Fitted {
    /// The law.
    pub law: PlasticLaw,
    /// Its score.
    pub score: f64,
}

/// Fits the free constants to dents, from those of `start`, which gives the others too. `tell` hears the number of the
/// iteration that begins and the best score so far.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn fit(
    start: PlasticLaw,
    known: &[KnownDent],
    iterations: u32,
    tell: impl FnMut(u32, f64),
) -> Result<Fitted, FitError> {
    let rated = |values: [f64; 6]| match law_of(values, &start) {
        Some(law) => misfits(law, known).map(|misfits| score(&misfits)),
        None => Ok(OUT_OF_RANGE),
    };
    let found = simplex::descend(free(&start), iterations, rated, tell)?;
    Ok(Fitted { law: law_of(found.at, &start).unwrap_or(start), score: found.value })
}
