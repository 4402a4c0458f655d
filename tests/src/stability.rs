//! How firmly a hand can hold on to clay: scenarios of the whole loop, device, hand, chain and clay.
//!
//! Owns the table, the plane and their files; the table's form is that of [`crate::failures`].
//! Invariant: nothing is timed; a scenario is the same run every time.

mod bench;
mod felt;
mod guided;
mod jolts;
mod lesson;
mod list;
mod mechanism;
mod plane;

use std::path::Path;

use crate::chart::ChartError;
use crate::failures::{self, Outcome};
pub use guided::{GuidanceFigures, measure_guidance};
pub use lesson::{Fate, Learnt, Lesson, WAYS, give};
pub use list::SCENARIOS;
pub use mechanism::{Grip, Mechanism};
pub use plane::{PlanePoint, Stage, bound_n_m, leave_out, measure_plane, stable_stiffness_n_m};

/// Writes `stability.csv` and `stability.md`, and `stability-plane.csv` and `stability-plane.png` when there is a plane, into a folder,
/// which is made when it is not there.
///
/// # Errors
/// [`ChartError`] when one cannot be written; choose another folder.
pub fn write(outcomes: &[Outcome], plane: &[PlanePoint], folder: &Path) -> Result<(), ChartError> {
    failures::write_as(outcomes, folder, "stability", "How firmly a hand can hold on")?;
    if plane.is_empty() {
        return Ok(());
    }
    for (name, bytes) in crate::chart::stability::files(plane)? {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|source| ChartError::Write { path, source })?;
    }
    Ok(())
}
