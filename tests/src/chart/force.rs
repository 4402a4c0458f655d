//! Force on the tool over its travel, held against the reference's.
//!
//! Owns the two ways of reading it: at rest, as the reference does, and on the way in.
//! Invariant: errors are taken over the reference's largest force, so that a small force cannot make them large.

use pottery_shared::clay::{self, PotSpec};
use pottery_shared::units::Seconds;

use super::ChartError;
use super::cases::{Support, reference_dent};
use super::csv::{Cell, Row};
use super::entrant::ENTRANTS;
use super::extent::Extent;
use super::progress::Progress;
use crate::dent::{Dent, Pressing};
use crate::reference::ForceCurve;

const BACKED: &str = include_str!("../../data/reference/B_depth_force.csv");
const HOLLOW: &str = include_str!("../../data/reference/A_depth_force.csv");
/// The supports whose force is read.
pub(super) const SUPPORTS: [Support; 2] = [Support::Backed, Support::Hollow];
/// Steps of 1 ms in which the tool reaches 2 mm when the force is read on the way.
const STEPS_IN: u32 = 300;

/// The reference's force over its travel, backed or hollow.
///
/// # Errors
/// [`ChartError::Reference`] when the file is damaged.
pub fn reference(hollow: bool) -> Result<ForceCurve, ChartError> {
    Ok(ForceCurve::parse(if hollow { HOLLOW } else { BACKED })?)
}

/// Force at one travel.
#[derive(Clone, Copy, Debug)]
pub struct ForceFigures {
    /// Row of the table of methods.
    pub row: usize,
    /// What holds the wall.
    pub support: Support,
    /// Travel of the tool, mm.
    pub travel_mm: f64,
    /// Force when the tool has stood for 1.5 s, N.
    pub resting_n: f64,
    /// Force while it comes in at 6.7 mm/s, N; nothing for a yardstick.
    pub moving_n: Option<f64>,
    /// The reference's force when it gets there for the first time, N.
    pub reference_n: Option<f64>,
    /// The reference's largest force, N.
    pub reference_largest_n: f64,
}

impl ForceFigures {
    /// Difference of the force at rest to the reference's over its largest.
    #[must_use]
    pub fn error(&self) -> Option<f64> {
        Some((self.resting_n - self.reference_n?) / self.reference_largest_n)
    }
}

/// Reads the force at every travel: backed with every row of the table, hollow with those that know what that is.
///
/// # Errors
/// [`ChartError`] as for a single dent.
pub fn measure(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<ForceFigures>, ChartError> {
    let mut figures = Vec::new();
    for (row, entrant) in ENTRANTS.iter().enumerate().filter(|(_, entrant)| extent.asks(entrant)) {
        progress.begin(&format!("{}: force over travel", entrant.title));
        for support in SUPPORTS {
            if support == Support::Backed || entrant.supports.contains(&support) {
                figures.extend(over_travel(row, support, extent)?);
            }
        }
    }
    Ok(figures)
}

fn over_travel(row: usize, support: Support, extent: &Extent) -> Result<Vec<ForceFigures>, ChartError> {
    let (entrant, curve) = (&ENTRANTS[row], reference(support == Support::Hollow)?);
    let moving = match entrant.method() {
        Some(method) => {
            let dent = reference_dent(extent.case_grid, 2.0, false);
            let support = if support == Support::Hollow { clay::Support::Hollow } else { clay::Support::Backed };
            on_the_way(&Dent { method, pot: PotSpec { support, ..dent.pot }, ..dent })?
        }
        None => Vec::new(),
    };
    let figures = extent.travels_mm.iter().map(|&travel_mm| {
        let dented = entrant.dent(&reference_dent(extent.case_grid, travel_mm, false), support)?;
        let passed = moving.iter().find(|(depth_mm, _)| *depth_mm >= travel_mm - 1e-4);
        Ok(ForceFigures {
            row,
            support,
            travel_mm: travel_mm.into(),
            resting_n: dented.force_n.into(),
            moving_n: passed.map(|(_, force_n)| f64::from(*force_n)),
            reference_n: curve.first_at_n(travel_mm.into()),
            reference_largest_n: curve.largest_n(),
        })
    });
    figures.collect()
}

/// Travel, mm, and force, N, at every step while the tool comes in.
fn on_the_way(dent: &Dent) -> Result<Vec<(f32, f32)>, ChartError> {
    let mut pressing = Pressing::new(*dent, Seconds(1e-3))?;
    let middle_m = dent.pot.height.0 * 0.5;
    let step = |number: u32| {
        let depth_m = dent.depth.0 * number as f32 / STEPS_IN as f32;
        (depth_m * 1e3, pressing.step(0.0, depth_m, middle_m, 0))
    };
    Ok((1..=STEPS_IN).map(step).collect())
}

impl Row for ForceFigures {
    const COLUMNS: &'static [&'static str] = &[
        "method",
        "support",
        "travel_mm",
        "force_at_rest_n",
        "force_moving_n",
        "reference_force_n",
        "error_percent_of_largest_reference_force",
    ];

    fn cells(&self) -> Vec<Cell> {
        vec![
            ENTRANTS[self.row].name.into(),
            self.support.name().into(),
            self.travel_mm.into(),
            self.resting_n.into(),
            self.moving_n.into(),
            self.reference_n.into(),
            self.error().map(|error| error * 100.0).into(),
        ]
    }
}
