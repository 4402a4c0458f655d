//! Balls pressed to one depth within different times: finite-element clay knows no rate, so what is left has to be the same.
//!
//! Owns the presses and what of two pots is compared. What a quick press raises is fitted to what a slow one does.
//! Invariant: clay yields as quickly as it does on a wheel, and has yielded when the pots are compared.

use pottery_shared::clay::{GridShape, Material, PlasticCsem, PlasticLaw};
use pottery_shared::units::Seconds;

use super::{FitError, Fitted, simplex};
use crate::chart::cases::{BASE, Scene};
use crate::dent::{Dent, Pressing};

/// Length of a step.
const STEP: Seconds = Seconds(1e-3);
/// Steps that a slow press takes, those that quick ones take, and those for which a tool then stands still.
const SLOW: u32 = 4000;
const QUICK: [u32; 4] = [1, 100, 300, 1000];
const STILL: u32 = 1500;
/// Radius of the balls and how deep they go, mm.
const PRESSES_MM: [[f32; 2]; 5] = [[8.0, 1.0], [12.0, 1.0], [12.0, 2.0], [16.0, 4.0], [20.0, 3.65]];

/// A press within a time, and by how much what it leaves differs from what a slow one does.
#[derive(Clone, Copy, Debug)]
pub struct Quick {
    /// Radius of the ball and how deep it goes, mm.
    pub press_mm: [f32; 2],
    /// How long the tool comes in, ms.
    pub within_ms: u32,
    /// Root mean square over the elements that a slow press moves, over the travel.
    pub rms: f64,
    /// Height of the ridge after it and after a slow press, mm.
    pub ridge_mm: [f64; 2],
}

/// Every quick press of a law beside the slow one.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn press(law: PlasticLaw, grid: GridShape) -> Result<Vec<Quick>, FitError> {
    let mut all = Vec::new();
    for [tool_mm, depth_mm] in PRESSES_MM {
        let mut dent = Scene { tool_mm, ..BASE }.dent(grid, depth_mm, true);
        dent.pot.keeps_volume = false;
        let slow = pressed(law, dent, SLOW)?;
        for within_ms in QUICK {
            let quick = pressed(law, dent, within_ms)?;
            let moved = slow.iter().zip(&quick).filter(|(slow, _)| **slow != 0.0);
            let (squares, count) =
                moved.fold((0.0, 0_u32), |(sum, count), (slow, quick)| (sum + (quick - slow).powi(2), count + 1));
            let ridge_mm = [&quick, &slow].map(|pot| pot.iter().copied().fold(0.0, f64::max));
            let rms = (squares / f64::from(count.max(1))).sqrt() / f64::from(depth_mm);
            all.push(Quick { press_mm: [tool_mm, depth_mm], within_ms, rms, ridge_mm });
        }
    }
    Ok(all)
}

/// By how much every element of the wall has moved, mm.
fn pressed(law: PlasticLaw, dent: Dent, steps: u32) -> Result<Vec<f64>, FitError> {
    let mut pressing = Pressing::in_clay(dent, STEP, Material::default().viscosity)?;
    for step in 1..=steps + STILL {
        let share = (step as f32 / steps as f32).min(1.0);
        pressing.step_with(PlasticCsem { law }, 0.0, dent.depth.0 * share, 0.5 * dent.pot.height.0, 0);
    }
    let moved_mm = |&radius_m: &f32| f64::from(radius_m - dent.pot.radius.0) * 1e3;
    Ok(pressing.pot().surfaces()[0].radii_m().iter().map(moved_mm).collect())
}

/// Root mean square of what quick presses differ by from slow ones.
#[must_use]
pub fn score(quick: &[Quick]) -> f64 {
    (quick.iter().map(|quick| quick.rms * quick.rms).sum::<f64>() / quick.len().max(1) as f64).sqrt()
}

/// Fits `rim_ahead`, with all else of `start` held.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn fit(
    start: PlasticLaw,
    grid: GridShape,
    iterations: u32,
    tell: impl FnMut(u32, f64),
) -> Result<Fitted, FitError> {
    let law = |[ahead]: [f64; 1]| PlasticLaw { rim_ahead: ahead.clamp(0.0, 1.0) as f32, ..start };
    let rated = |at| press(law(at), grid).map(|quick| score(&quick));
    let found = simplex::descend([f64::from(start.rim_ahead)], iterations, rated, tell)?;
    Ok(Fitted { law: law(found.at), score: found.value })
}
