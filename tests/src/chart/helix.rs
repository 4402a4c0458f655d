//! A tool that goes along a turning wheel: the thread that it leaves, over its pitch.
//!
//! A sphere at depth δ leaves cusps between its grooves. With the length of contact `2a = 2·√(2Rδ − δ²)` and the pitch P,
//! the surface lies above the groove's bottom by `RMS/δ = 0.447·(P/2a)²` (0.447 = 1/√5, from a parabola). Where that is small,
//! the pot is a profile over its height and one turn says all.
//! Invariant: the wheel turns so slowly that the clay rests under the tool, so that only geometry and the method remain.

use std::f32::consts::TAU;

use pottery_shared::clay::GridShape;
use pottery_shared::units::Seconds;

use super::ChartError;
use super::cases::reference_dent;
use super::csv::{Cell, Row};
use super::entrant::{ENTRANTS, methods};
use super::extent::Extent;
use super::progress::Progress;
use crate::dent::{Dent, Pressing};

/// Depth of the tool, mm.
pub(super) const DEPTH_MM: f32 = 2.0;
/// Columns of the grid, and steps in a turn: the tool stands once before every column.
const COLUMNS: u32 = 180;
/// Length of a step: ten times the time in which clay gives way.
const STEP: Seconds = Seconds(1.2);

/// The thread of one pitch.
#[derive(Clone, Copy, Debug)]
pub struct HelixFigures {
    /// Row of the table of methods.
    pub row: usize,
    /// Feed along the axis for each turn, mm.
    pub pitch_mm: f64,
    /// The same over the length of contact.
    pub pitch_over_contact: f64,
    /// Turns of the wheel.
    pub turns: f64,
    /// RMS height above the deepest place, over the tool's depth.
    pub cusps: f64,
    /// RMS difference to the depth at which the tool goes, over it.
    pub off_depth: f64,
    /// Mean depth of the groove, mm.
    pub mean_depth_mm: f64,
}

impl HelixFigures {
    /// Cusp theory: `0.447·(P/2a)²`.
    #[must_use]
    pub fn theory(&self) -> f64 {
        0.2_f64.sqrt() * self.pitch_over_contact.powi(2)
    }
}

/// Turns a thread of every pitch with every method.
///
/// # Errors
/// [`ChartError`] when a pot cannot be made.
///
/// # Panics
/// When the extent's number of rows makes no grid.
pub fn measure(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<HelixFigures>, ChartError> {
    let grid = GridShape::new(COLUMNS, extent.helix_rows).expect("the chart's grids are in range");
    let mut figures = Vec::new();
    for (row, method) in methods() {
        progress.begin(&format!("{}: thread on a turning wheel", ENTRANTS[row].title));
        for &pitch in &extent.pitches {
            figures.push(thread(row, &Dent { method, ..reference_dent(grid, DEPTH_MM, true) }, pitch)?);
        }
    }
    Ok(figures)
}

fn thread(row: usize, dent: &Dent, pitch: f32) -> Result<HelixFigures, ChartError> {
    let mut pressing = Pressing::new(*dent, STEP)?;
    let contact_m = 2.0 * (2.0 * dent.tool.0 * dent.depth.0 - dent.depth.0.powi(2)).sqrt();
    let pitch_m = pitch * contact_m;
    // the ends, where grooves are missing on one side, are as long as the contact; two pitches lie between them
    let turns = (2.0 * contact_m / pitch_m).ceil() + 2.0;
    let start_m = 0.5 * (dent.pot.height.0 - turns * pitch_m);
    for number in 0..=(turns as u32 * COLUMNS) {
        let turned = number as f32 / COLUMNS as f32;
        pressing.step((turned * TAU) % TAU, dent.depth.0, start_m + pitch_m * turned, 1);
    }
    let (from_m, to_m) = (start_m + contact_m, start_m + turns * pitch_m - contact_m);
    let surface = &pressing.pot().surfaces()[0];
    let rows: Vec<usize> = (0..surface.shape().rows())
        .filter(|row| (from_m..=to_m).contains(&surface.row_z_m(*row)))
        .map(|row| row as usize)
        .collect();
    let columns = 0..surface.shape().columns();
    let depths_m: Vec<f64> = columns
        .flat_map(|column| rows.iter().map(move |row| surface.column_m(column)[*row]))
        .map(|radius_m| f64::from(dent.pot.radius.0) - f64::from(radius_m))
        .collect();
    let depth_m = f64::from(dent.depth.0);
    let deepest_m = depths_m.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let mean = |of: &dyn Fn(f64) -> f64| depths_m.iter().map(|depth| of(*depth)).sum::<f64>() / depths_m.len() as f64;
    Ok(HelixFigures {
        row,
        pitch_mm: f64::from(pitch_m) * 1e3,
        pitch_over_contact: pitch.into(),
        turns: turns.into(),
        cusps: mean(&|depth| (deepest_m - depth).powi(2)).sqrt() / depth_m,
        off_depth: mean(&|depth| (depth_m - depth).powi(2)).sqrt() / depth_m,
        mean_depth_mm: mean(&|depth| depth) * 1e3,
    })
}

impl Row for HelixFigures {
    const COLUMNS: &'static [&'static str] = &[
        "method",
        "pitch_mm",
        "pitch_over_contact_ratio",
        "turns",
        "rms_above_bottom_percent_of_depth",
        "cusp_theory_percent_of_depth",
        "rms_off_tool_depth_percent_of_depth",
        "mean_depth_mm",
    ];

    fn cells(&self) -> Vec<Cell> {
        vec![
            ENTRANTS[self.row].name.into(),
            self.pitch_mm.into(),
            self.pitch_over_contact.into(),
            self.turns.into(),
            (self.cusps * 100.0).into(),
            (self.theory() * 100.0).into(),
            (self.off_depth * 100.0).into(),
            self.mean_depth_mm.into(),
        ]
    }
}
