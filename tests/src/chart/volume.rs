//! What becomes of the clay that a tool pushes away.
//!
//! Owns the sums over a surface, before and after. A pot whose method keeps its volume grows at every snapshot by the clay
//! that does not rise beside the tool.
//! Invariant: volumes are taken against the untouched pot, in wide numbers.

use pottery_shared::clay::{GridShape, Method, Pot, Window};
use pottery_shared::units::Seconds;

use super::ChartError;
use super::cases::reference_dent;
use super::csv::{Cell, Row};
use super::entrant::{ENTRANTS, methods};
use super::extent::Extent;
use super::progress::Progress;
use super::speed::Walk;
use crate::dent::{Dent, Pressing};

/// Steps between two snapshots, at which a pot that keeps its volume grows.
const STEPS_A_SNAPSHOT: u32 = 17;
/// Steps of a press of 2 mm, until it rests.
const PRESS_STEPS: u32 = 1800;

/// Volumes of one scenario.
#[derive(Clone, Copy, Debug)]
pub struct VolumeFigures {
    /// Row of the table of methods.
    pub row: usize,
    /// What was done, in files.
    pub scenario: &'static str,
    /// Steps that it took.
    pub steps: u32,
    /// The grid.
    pub grid: GridShape,
    /// Volume that lies below the untouched surface, mm³.
    pub in_mm3: f64,
    /// Volume that lies above it, mm³.
    pub out_mm3: f64,
    /// How much higher the pot is, mm.
    pub grown_mm: f64,
    /// Volume of the pot out to its axis afterwards, over that of the untouched one.
    pub whole: f64,
}

/// Measures a press and a long stroke.
///
/// # Errors
/// [`ChartError`] when a pot cannot be made.
pub fn measure(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<VolumeFigures>, ChartError> {
    let grid = extent.case_grid;
    let mut figures = Vec::new();
    for (row, method) in methods() {
        progress.begin(&format!("{}: volume kept", ENTRANTS[row].title));
        let mut dent = Dent { method, ..reference_dent(grid, 2.0, true) };
        dent.pot.keeps_volume = method.keeps_volume();
        let mut pressing = Pressing::new(dent, Seconds(1e-3))?;
        let mut changed = Vec::new();
        for number in 1..=PRESS_STEPS {
            // the depth is reached after a sixth of the steps, as in the reference
            let depth_m = dent.depth.0 * (number as f32 * 6.0 / PRESS_STEPS as f32).min(1.0);
            let middle_m = dent.pot.height.0 * 0.5;
            pressing.step_telling(0.0, depth_m, middle_m, 0, |surface, window| changed.push((surface, window)));
            settle(number, PRESS_STEPS, pressing.pot_mut(), &mut changed);
        }
        figures.push(VolumeFigures::of(row, "press of 2 mm", PRESS_STEPS, pressing.pot()));
        let mut walk = Walk::new(method, grid)?;
        for number in 1..=extent.stroke_steps {
            walk.step(|surface, window| changed.push((surface, window)));
            settle(number, extent.stroke_steps, walk.pressing.pot_mut(), &mut changed);
        }
        figures.push(VolumeFigures::of(row, "round and up and down", extent.stroke_steps, walk.pressing.pot()));
    }
    Ok(figures)
}

/// Lets the pot grow when it is time for a snapshot, and at the end.
fn settle(number: u32, last: u32, pot: &mut Pot, changed: &mut Vec<(usize, Window)>) {
    if number.is_multiple_of(STEPS_A_SNAPSHOT) || number == last {
        pot.settle(changed.drain(..));
    }
}

impl VolumeFigures {
    /// Volumes below and above the untouched surface, Σ ½·|r² − r₀²|·Δθ·Δz, and of the whole.
    fn of(row: usize, scenario: &'static str, steps: u32, pot: &Pot) -> Self {
        let surface = &pot.surfaces()[pot.skins()[0].surface];
        let first = f64::from(pot.spec().radius.0);
        let element = f64::from(surface.shape().column_angle_rad()) * f64::from(surface.row_height_m());
        let (mut in_mm3, mut out_mm3) = (0.0, 0.0);
        for &radius_m in surface.radii_m() {
            let volume = 0.5 * (f64::from(radius_m).powi(2) - first * first) * element * 1e9;
            *(if volume < 0.0 { &mut in_mm3 } else { &mut out_mm3 }) += volume.abs();
        }
        let untouched_m3 = std::f64::consts::PI * first * first * f64::from(pot.spec().height.0);
        Self {
            row,
            scenario,
            steps,
            grid: surface.shape(),
            in_mm3,
            out_mm3,
            grown_mm: f64::from(surface.height_m() - pot.spec().height.0) * 1e3,
            whole: pot.enclosed_volume_m3() / untouched_m3,
        }
    }
}

impl Row for VolumeFigures {
    const COLUMNS: &'static [&'static str] = &[
        "method",
        "scenario",
        "steps",
        "columns",
        "rows",
        "volume_in_mm3",
        "volume_out_mm3",
        "rim_percent_of_volume_in",
        "pot_grown_mm",
        "pot_volume_change_percent",
    ];

    fn cells(&self) -> Vec<Cell> {
        vec![
            ENTRANTS[self.row].name.into(),
            self.scenario.into(),
            self.steps.into(),
            self.grid.columns().into(),
            self.grid.rows().into(),
            self.in_mm3.into(),
            self.out_mm3.into(),
            (self.out_mm3 / self.in_mm3 * 100.0).into(),
            self.grown_mm.into(),
            ((self.whole - 1.0) * 100.0).into(),
        ]
    }
}
