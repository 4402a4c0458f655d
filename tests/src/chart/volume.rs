//! What becomes of the clay that a tool pushes away.
//!
//! Owns the sums over a surface; a method that books clay elsewhere adds it here.
//! Invariant: volumes are taken against the untouched pot, in wide numbers.

use pottery_shared::clay::{GridShape, Pot};

use super::ChartError;
use super::cases::reference_dent;
use super::csv::{Cell, Row};
use super::entrant::{ENTRANTS, methods};
use super::extent::Extent;
use super::progress::Progress;
use super::speed::Walk;
use crate::dent::Dent;

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
    /// Volume of the untouched pot out to its axis, mm³.
    pub whole_mm3: f64,
}

impl VolumeFigures {
    /// Share of the displaced clay that is still there.
    #[must_use]
    pub fn kept(&self) -> f64 {
        self.out_mm3 / self.in_mm3
    }
}

/// Measures a press that is let go, and a long stroke.
///
/// # Errors
/// [`ChartError`] as for a single dent.
pub fn measure(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<VolumeFigures>, ChartError> {
    let grid = extent.case_grid;
    let whole_mm3 =
        Pot::new(reference_dent(grid, 2.0, true).pot).map_or(f64::NAN, |pot| pot.enclosed_volume_m3() * 1e9);
    let mut figures = Vec::new();
    for (row, method) in methods() {
        progress.begin(&format!("{}: volume kept", ENTRANTS[row].title));
        let pressed = Dent { method, ..reference_dent(grid, 2.0, true) }.press()?;
        let (in_mm3, out_mm3) = (pressed.volume_in_mm3, pressed.volume_out_mm3);
        figures.push(VolumeFigures { row, scenario: "press of 2 mm", steps: 1800, grid, in_mm3, out_mm3, whole_mm3 });
        let mut walk = Walk::new(method, grid)?;
        for _ in 0..extent.stroke_steps {
            walk.step(|_, _| {});
        }
        let (in_mm3, out_mm3) = moved_mm3(walk.pressing.pot());
        let (scenario, steps) = ("round and up and down", extent.stroke_steps);
        figures.push(VolumeFigures { row, scenario, steps, grid, in_mm3, out_mm3, whole_mm3 });
    }
    Ok(figures)
}

/// Volumes below and above the untouched surface, mm³: Σ ½·|r² − r₀²|·Δθ·Δz.
fn moved_mm3(pot: &Pot) -> (f64, f64) {
    let surface = &pot.surfaces()[pot.skins()[0].surface];
    let first = f64::from(pot.spec().radius.0);
    let element = f64::from(surface.shape().column_angle_rad()) * f64::from(surface.row_height_m());
    let (mut below, mut above) = (0.0, 0.0);
    for &radius_m in surface.radii_m() {
        let volume = 0.5 * (f64::from(radius_m).powi(2) - first * first) * element * 1e9;
        *(if volume < 0.0 { &mut below } else { &mut above }) += volume.abs();
    }
    (below, above)
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
        "kept_percent",
        "lost_percent_of_pot",
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
            (self.kept() * 100.0).into(),
            ((self.in_mm3 - self.out_mm3) / self.whole_mm3 * 100.0).into(),
        ]
    }
}
