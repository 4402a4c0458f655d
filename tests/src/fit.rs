//! Where the constants of the studio's own clay come from: its law fitted to finite-element dents of a backed wall, what a
//! sliding tool adds to it to finite-element strokes, how a hollow wall yields to forces on one, and what a quick press raises to what
//! a slow one does.
//!
//! Owns which constants are free and what counts as a misfit; the dents to meet are [`dents`]', the strokes [`strokes`]', the
//! forces [`walls`]', the presses that are quick and slow [`speeds`]', those on other grids [`sides`]'.
//! Invariant: the same dents, start and number of iterations give the same constants, bit for bit.

pub mod dents;
pub mod sides;
pub mod simplex;
pub mod speeds;
pub mod strokes;
pub mod walls;

use pottery_shared::clay::{GridShape, PlasticCsem, PlasticLaw};

use crate::dent::DentError;
use crate::reference::BadProfile;
use dents::KnownDent;
use strokes::StrokeFigures;

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
/// Weights of the dent that stays and of the force.
const PERMANENT: f64 = 1.5;
const FORCE: f64 = 0.7;
/// Error of the force that counts twice as much as so many small ones.
const FORCE_LARGE: f64 = 0.04;

/// Constants that dents are fitted with, in this order.
pub const FREE: [&str; 12] = [
    "hardness",
    "hardness_by_slope",
    "hardness_by_layer",
    "hardness_strain",
    "recovery",
    "recovery_by_layer",
    "recovery_edge",
    "sink_width",
    "rim_rises",
    "rim_strain",
    "rim_width",
    "rim_around",
];

/// The free constants of a law.
#[must_use]
pub fn free(law: &PlasticLaw) -> [f64; 12] {
    [
        law.hardness,
        law.hardness_by_slope,
        law.hardness_by_layer,
        law.hardness_strain,
        law.recovery,
        law.recovery_by_layer,
        law.recovery_edge,
        law.sink_width,
        law.rim_rises,
        law.rim_strain,
        law.rim_width,
        law.rim_around,
    ]
    .map(f64::from)
}

/// The law with these free constants and what is held of another; `None` where it makes no sense.
#[must_use]
pub fn law_of(free: [f64; 12], held: &PlasticLaw) -> Option<PlasticLaw> {
    let [
        hardness,
        hardness_by_slope,
        hardness_by_layer,
        hardness_strain,
        recovery,
        recovery_by_layer,
        recovery_edge,
        sink_width,
        rim_rises,
        rim_strain,
        rim_width,
        rim_around,
    ] = free.map(|value| value as f32);
    let sense = hardness > 0.5
        && recovery > 0.05
        && sink_width > 0.01
        && (0.05..=0.75).contains(&rim_rises)
        && rim_strain > 1.0
        && rim_width > 0.05;
    let law = PlasticLaw {
        hardness,
        hardness_by_slope,
        hardness_by_layer,
        hardness_strain,
        recovery,
        recovery_by_layer,
        recovery_edge,
        sink_width,
        rim_rises,
        rim_strain,
        rim_width,
        rim_around,
        ..*held
    };
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
        let score = PERMANENT * permanent + loaded + FORCE * counted(force);
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

/// What an error of a force counts.
fn counted(force: f64) -> f64 {
    force.abs() * (1.0 + force.abs() / FORCE_LARGE)
}

/// Mean score of some misfits: `1.5·RMS permanent + RMS loaded + 0.7·|force error|`.
#[must_use]
pub fn score(misfits: &[Misfit]) -> f64 {
    misfits.iter().map(|misfit| misfit.score).sum::<f64>() / misfits.len().max(1) as f64
}

/// Constants of a sliding tool, in this order.
pub const SLIDING: [&str; 8] = [
    "slide_bottom",
    "slide_rises",
    "slide_strain",
    "slide_open",
    "slide_soft",
    "slide_steep",
    "slide_steep_from",
    "slide_narrow",
];

/// The sliding constants of a law.
#[must_use]
pub fn sliding(law: &PlasticLaw) -> [f64; SLIDING.len()] {
    [
        law.slide_bottom,
        law.slide_rises,
        law.slide_strain,
        law.slide_open,
        law.slide_soft,
        law.slide_steep,
        law.slide_steep_from,
        law.slide_narrow,
    ]
    .map(f64::from)
}

/// The law with these sliding constants; `None` where it makes no sense.
#[must_use]
pub fn sliding_law(sliding: [f64; SLIDING.len()], held: &PlasticLaw) -> Option<PlasticLaw> {
    let [slide_bottom, slide_rises, slide_strain, slide_open, slide_soft, slide_steep, slide_steep_from, slide_narrow] =
        sliding.map(|value| value as f32);
    let sense = (0.05..=1.0).contains(&slide_bottom)
        && (0.05..=0.75).contains(&slide_rises)
        && slide_strain > 0.1
        && slide_soft < 1.0
        && (0.0..=0.9).contains(&slide_steep)
        && slide_steep_from > 0.0;
    let law = PlasticLaw {
        slide_bottom,
        slide_rises,
        slide_strain,
        slide_open,
        slide_soft,
        slide_steep,
        slide_steep_from,
        slide_narrow,
        ..*held
    };
    (sense && slide_narrow >= 0.0).then_some(law)
}

/// The law with which the forces along the motion of the strokes come out best, with all else held: they are proportional to
/// `1 + slide_heap`, so that the least squares are a quotient.
///
/// # Errors
/// [`FitError`] when a file is damaged.
pub fn fit_heap(start: PlasticLaw, grid: GridShape) -> Result<PlasticLaw, FitError> {
    let drawn = strokes::draw(PlasticCsem { law: PlasticLaw { slide_heap: 0.0, ..start } }, grid)?;
    let sum = |of: fn(&StrokeFigures) -> f64| drawn.iter().map(of).sum::<f64>();
    let greater =
        sum(|stroke| stroke.force_n[1] * stroke.reference_force_n[1]) / sum(|stroke| stroke.force_n[1].powi(2));
    Ok(PlasticLaw { slide_heap: (greater - 1.0) as f32, ..start })
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
    let rated = |values: [f64; FREE.len()]| match law_of(values, &start) {
        Some(law) => misfits(law, known).map(|misfits| score(&misfits)),
        None => Ok(OUT_OF_RANGE),
    };
    let found = simplex::descend(free(&start), iterations, rated, tell)?;
    Ok(Fitted { law: law_of(found.at, &start).unwrap_or(start), score: found.value })
}

/// Score of the strokes of a law: eighth root of the mean eighth power of the larger of `RMS groove` and `1.2·|force error|`, so that the
/// worst counts most.
///
/// # Errors
/// [`FitError`] when a file is damaged.
pub fn strokes_score(law: PlasticLaw, grid: GridShape) -> Result<f64, FitError> {
    let drawn = strokes::draw(PlasticCsem { law }, grid)?;
    let powers = drawn.iter().map(|figures| figures.score().powi(8));
    Ok((powers.sum::<f64>() / drawn.len() as f64).powf(0.125))
}

/// Fits the sliding constants to the strokes, with all else of `start` held.
///
/// # Errors
/// [`FitError`] when a file is damaged.
pub fn fit_strokes(
    start: PlasticLaw,
    grid: GridShape,
    iterations: u32,
    tell: impl FnMut(u32, f64),
) -> Result<Fitted, FitError> {
    let rated = |values: [f64; SLIDING.len()]| match sliding_law(values, &start) {
        Some(law) => strokes_score(law, grid),
        None => Ok(OUT_OF_RANGE),
    };
    let found = simplex::descend(sliding(&start), iterations, rated, tell)?;
    Ok(Fitted { law: sliding_law(found.at, &start).unwrap_or(start), score: found.value })
}
