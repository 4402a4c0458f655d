//! Whether the result depends on the size of the steps and of the elements.
//!
//! Owns the press in few and in many steps; the presses on other grids are those of [`super::speed`].
//! Invariant: a change is taken against the finest of its own method, never against the reference.

use pottery_shared::clay::GridShape;

use super::ChartError;
use super::cases::{CASES, reference_dent};
use super::csv::{Cell, Row};
use super::entrant::{ENTRANTS, methods};
use super::extent::Extent;
use super::progress::Progress;
use super::speed::GridErrors;
use crate::dent::{Dent, Dented};

/// Steps in which a press on another grid reaches its depth.
const STEPS_IN: u32 = 300;

/// What was made finer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Varied {
    /// The steps.
    Steps,
    /// The elements.
    Grid,
}

/// The dent that stays after 2 mm, backed, made in so many steps on such a grid.
#[derive(Clone, Copy, Debug)]
pub struct ConvergenceFigures {
    /// Row of the table of methods.
    pub row: usize,
    /// What was made finer.
    pub varied: Varied,
    /// Steps in which the tool reached its depth within 0.3 s; it stood for five times as many.
    pub steps_in: u32,
    /// The grid.
    pub grid: GridShape,
    /// RMS error against the reference, over the travel.
    pub error: f64,
    /// RMS difference to the finest, over the travel.
    pub change: f64,
    /// Force at rest, N.
    pub force_n: f64,
    /// The finest's force, N.
    pub finest_force_n: f64,
}

impl ConvergenceFigures {
    /// The figures of a press on another grid.
    pub(super) const fn of_grid(errors: &GridErrors) -> Self {
        Self {
            row: errors.row,
            varied: Varied::Grid,
            steps_in: STEPS_IN,
            grid: errors.grid,
            error: errors.deep_error,
            change: errors.deep_change,
            force_n: errors.force_n,
            finest_force_n: errors.finest_force_n,
        }
    }
}

/// Presses in several numbers of steps, with every method that has steps.
///
/// # Errors
/// [`ChartError`] as for a single dent.
pub fn over_steps(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<ConvergenceFigures>, ChartError> {
    let deep = CASES.iter().find(|case| case.is_base() && case.depth_mm == 2 && case.release);
    let reference = deep.expect("the backed dent of 2 mm is in the list").reference()?;
    let mut figures = Vec::new();
    for (row, method) in methods() {
        progress.begin(&format!("{}: size of steps", ENTRANTS[row].title));
        let dent = Dent { method, ..reference_dent(extent.case_grid, 2.0, true) };
        let mut finest: Option<Dented> = None;
        for &steps_in in extent.step_counts.iter().rev() {
            let dented = dent.press_in(steps_in)?;
            let against = finest.get_or_insert_with(|| dented.clone());
            figures.push(ConvergenceFigures {
                row,
                varied: Varied::Steps,
                steps_in,
                grid: extent.case_grid,
                error: dented.error(&reference, &dent),
                change: dented.difference_mm(against, &dent) / f64::from(dent.depth.as_mm()),
                force_n: dented.force_n.into(),
                finest_force_n: against.force_n.into(),
            });
        }
    }
    Ok(figures)
}

impl Row for ConvergenceFigures {
    const COLUMNS: &'static [&'static str] = &[
        "method",
        "varied",
        "steps_to_depth",
        "step_ms",
        "columns",
        "rows",
        "rms_error_percent_of_depth",
        "rms_change_percent_of_depth",
        "force_n",
        "force_change_n",
    ];

    fn cells(&self) -> Vec<Cell> {
        vec![
            ENTRANTS[self.row].name.into(),
            if self.varied == Varied::Steps { "steps" } else { "grid" }.into(),
            self.steps_in.into(),
            // the tool takes 0.3 s in all
            (300.0 / f64::from(self.steps_in)).into(),
            self.grid.columns().into(),
            self.grid.rows().into(),
            (self.error * 100.0).into(),
            (self.change * 100.0).into(),
            self.force_n.into(),
            (self.force_n - self.finest_force_n).into(),
        ]
    }
}
