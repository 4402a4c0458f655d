//! How firmly a hand can hold on to clay: scenarios of the whole loop, device, hand, chain and clay.
//!
//! Owns the table, the plane and their files; the table's form is that of [`crate::failures`].
//! Invariant: nothing is timed; a scenario is the same run every time.

mod bench;
mod far;
mod felt;
mod guided;
mod jolts;
mod lesson;
mod lines;
mod list;
mod mechanism;
mod online;
mod packets;
mod plane;
mod resting;
mod sides;

use std::path::Path;

use crate::chart::{ChartError, csv};
use crate::failures::{self, Outcome};
pub use far::{FarPoint, measure_far};
pub use guided::{GuidanceFigures, measure_guidance};
pub use lesson::{Fate, Learnt, Lesson, WAYS, give};
pub use list::SCENARIOS;
pub use mechanism::{Grip, Mechanism};
pub use plane::{PLANE_DELAYS_S, PlanePoint, Stage, bound_n_m, leave_out, measure_plane, stable_stiffness_n_m};
pub use resting::{RestPoint, measure_rest};

/// The edges of what is stable, measured point by point.
#[derive(Clone, Debug)]
pub struct Edges {
    /// On a linear wall.
    pub plane: Vec<PlanePoint>,
    /// With each method's own clay in the loop.
    pub rest: Vec<RestPoint>,
    /// Of our loop on our clay, with no network and far away.
    pub far: Vec<FarPoint>,
}

impl Edges {
    /// Measures them all, the plane at so many delays, s.
    #[must_use]
    pub fn measure(delays_s: &[f64]) -> Self {
        Self { plane: measure_plane(delays_s), rest: measure_rest(), far: measure_far() }
    }
}

/// Writes `stability.csv` and `stability.md`, and with edges `stability-plane.csv`, `stability-plane.png`, `stability-clay.csv` and
/// `stability-far.csv`, into a folder, which is made when it is not there.
///
/// # Errors
/// [`ChartError`] when one cannot be written; choose another folder.
pub fn write(outcomes: &[Outcome], edges: Option<&Edges>, folder: &Path) -> Result<(), ChartError> {
    failures::write_as(outcomes, folder, "stability", "How firmly a hand can hold on")?;
    let Some(Edges { plane, rest, far }) = edges else { return Ok(()) };
    let tables = [("stability-clay.csv", csv::text(rest).into()), ("stability-far.csv", csv::text(far).into())];
    for (name, bytes) in crate::chart::stability::files(plane)?.into_iter().chain(tables) {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|source| ChartError::Write { path, source })?;
    }
    Ok(())
}
