//! Hollow pots pressed to every depth that the finite elements know a force at: how much a wall softens that yields, and the clay at
//! it; and how far the inner wall goes with a dent outside.
//!
//! Owns the list of files and what of a curve is compared; surfaces are [`super::dents`]'.
//! Invariant: a curve is read once, on its first way in.

use pottery_shared::clay::{GridShape, PlasticCsem, PlasticLaw, Support};

use super::dents::{KnownDent, STOPS_WITHIN_MM};
use super::{FitError, Fitted, STEPS_IN, misfits, simplex};
use crate::chart::cases::{BASE, Scene};
use crate::dent::Dent;
use crate::reference::ForceCurve;

/// Travels that are compared, mm.
const DEPTHS_MM: [f32; 5] = [0.5, 1.0, 2.0, 3.0, 4.0];
struct File {
    scene: Scene,
    force: &'static str,
}

macro_rules! file {
    ($name:literal, $scene:expr) => {
        File {
            scene: Scene { name: concat!("hollow_", $name), ..$scene },
            force: include_str!(concat!("../../data/fem/hollow_", $name, "_depth_force.csv")),
        }
    };
}

const FILES: &[File] = &[
    file!("base", BASE),
    file!("ball20", Scene { tool_mm: 20.0, ..BASE }),
    file!("e1y15", Scene { youngs_mpa: 1.0, yield_kpa: 15.0, ..BASE }),
    file!("r40w6", Scene { pot_mm: [40.0, 6.0], ..BASE }),
    file!("wall12", Scene { pot_mm: [60.0, 12.0], ..BASE }),
];

/// A hollow pot pressed to a depth, and what force that takes.
#[derive(Clone, Copy, Debug)]
pub struct KnownForce {
    /// The case.
    pub name: &'static str,
    /// The press.
    pub dent: Dent,
    /// The reference's force at that depth, and its largest, N.
    pub force_n: f64,
    /// See `force_n`.
    pub largest_force_n: f64,
}

/// Every finite-element force on a hollow wall, to be found again on a grid.
///
/// # Errors
/// [`FitError::Reference`] when a file is damaged.
pub fn finite_elements(grid: GridShape) -> Result<Vec<KnownForce>, FitError> {
    let mut known = Vec::new();
    for File { scene, force } in FILES {
        let file = || format!("{}_depth_force.csv", scene.name);
        let curve = ForceCurve::parse(force).map_err(|source| FitError::Reference { file: file(), source })?;
        for depth_mm in DEPTHS_MM {
            let Some(force_n) = curve.first_at_n(f64::from(depth_mm) - STOPS_WITHIN_MM) else { continue };
            let mut dent = scene.dent(grid, depth_mm, false);
            (dent.pot.support, dent.pot.keeps_volume) = (Support::Hollow, false);
            known.push(KnownForce { name: scene.name, dent, force_n, largest_force_n: curve.largest_n() });
        }
    }
    Ok(known)
}

/// Error of a law's force over the largest of the same curve, press by press; positive is too hard.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn errors(law: PlasticLaw, known: &[KnownForce]) -> Result<Vec<f64>, FitError> {
    known
        .iter()
        .map(|known| {
            let pressed = known.dent.press_with(PlasticCsem { law }, STEPS_IN)?;
            Ok((f64::from(pressed.contact().force_n.x) - known.force_n) / known.largest_force_n)
        })
        .collect()
}

/// Constants of a hollow wall, in this order.
pub const HOLLOW: [&str; 2] = ["wall_softer", "wall_weaker"];

/// The constants of a hollow wall.
#[must_use]
pub fn hollow(law: &PlasticLaw) -> [f64; 2] {
    [law.wall_softer, law.wall_weaker].map(f64::from)
}

/// Root mean square of the errors of a law's forces, and the mean over dents of hollow walls of the root mean squares of both surfaces,
/// over the travel.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn score(law: PlasticLaw, forces: &[KnownForce], dents: &[KnownDent]) -> Result<f64, FitError> {
    let errors = errors(law, forces)?;
    let misfits = misfits(law, dents)?;
    let surfaces = misfits.iter().map(|misfit| misfit.loaded + misfit.permanent).sum::<f64>() / misfits.len() as f64;
    Ok((errors.iter().map(|error| error * error).sum::<f64>() / errors.len() as f64).sqrt() + surfaces)
}

/// Fits both constants, with all else of `start` held.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn fit(
    start: PlasticLaw,
    forces: &[KnownForce],
    dents: &[KnownDent],
    iterations: u32,
    tell: impl FnMut(u32, f64),
) -> Result<Fitted, FitError> {
    let law = |at: [f64; 2]| {
        let [wall_softer, wall_weaker] = at.map(|value| value.max(0.0) as f32);
        PlasticLaw { wall_softer, wall_weaker, ..start }
    };
    let found = simplex::descend(hollow(&start), iterations, |at| score(law(at), forces, dents), tell)?;
    Ok(Fitted { law: law(found.at), score: found.value })
}

/// Constants of how a wall's other skin goes along, in this order.
pub const FOLLOWING: [&str; 2] = ["wall_follows", "wall_follows_from"];

/// The constants of how a wall's other skin goes along.
#[must_use]
pub fn following(law: &PlasticLaw) -> [f64; 2] {
    [law.wall_follows, law.wall_follows_from].map(f64::from)
}

/// By how much farther inwards than in the finite elements the inner wall has gone behind each dent, over the travel.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn behind(law: PlasticLaw, dents: &[KnownDent]) -> Result<Vec<f64>, FitError> {
    dents
        .iter()
        .map(|known| {
            let pressed = known.dent.press_with(PlasticCsem { law }, STEPS_IN)?;
            Ok((known.behind_mm - pressed.behind_mm()) / f64::from(known.dent.depth.as_mm()))
        })
        .collect()
}

/// Fits how a wall's other skin goes along, with all else of `start` held, by the root mean square of [`behind`].
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn fit_following(
    start: PlasticLaw,
    dents: &[KnownDent],
    iterations: u32,
    tell: impl FnMut(u32, f64),
) -> Result<Fitted, FitError> {
    let law = |at: [f64; 2]| {
        let [wall_follows, wall_follows_from] = at.map(|value| value.max(0.0) as f32);
        PlasticLaw { wall_follows, wall_follows_from, ..start }
    };
    let score = |at| -> Result<f64, FitError> {
        let off = behind(law(at), dents)?;
        Ok((off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt())
    };
    let found = simplex::descend(following(&start), iterations, score, tell)?;
    Ok(Fitted { law: law(found.at), score: found.value })
}
