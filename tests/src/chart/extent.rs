//! How much is measured: all, as much as a few minutes allow, or hardly anything.
//!
//! Invariant: grids ascend, and the grid of the cases is one of them.

use pottery_shared::clay::GridShape;

use super::cases::CASES;
use super::entrant::{Entrant, methods};

/// How much is measured.
#[derive(Clone, Debug)]
pub struct Extent {
    /// Grids for time and error, the coarsest first.
    pub grids: Vec<GridShape>,
    /// The grid on which everything else is measured.
    pub case_grid: GridShape,
    /// Steps that are timed, for each method and grid.
    pub timed_steps: u32,
    /// Numbers of steps in which the tool reaches its depth.
    pub step_counts: Vec<u32>,
    /// Travels at which the force is read, mm.
    pub travels_mm: Vec<f32>,
    /// Pitches of the helix over the length of contact, P/2a.
    pub pitches: Vec<f32>,
    /// Pitches over the length of contact of a fast wheel as a profile.
    pub lathe_pitches: Vec<f32>,
    /// Rows of the helix's grid.
    pub helix_rows: u32,
    /// Steps of the long stroke.
    pub stroke_steps: u32,
    /// Whether it is less than all, which the page then says.
    pub quick: bool,
}

/// The paper's grid with both sides multiplied by a power of two.
fn grid(columns: u32, rows: u32) -> GridShape {
    GridShape::new(columns, rows).expect("the chart's grids are in range")
}

impl Extent {
    /// Everything.
    #[must_use]
    pub fn full() -> Self {
        Self {
            timed_steps: 10_000,
            travels_mm: (1..=16).map(|part| part as f32 * 0.125).collect(),
            pitches: vec![0.1, 0.15, 0.2, 0.25, 0.34, 0.5, 0.7, 0.85, 1.0],
            helix_rows: 3200,
            stroke_steps: 100_000,
            quick: false,
            ..Self::quick()
        }
    }

    /// What fits into five minutes on two slow cores.
    #[must_use]
    pub fn quick() -> Self {
        Self {
            grids: [(90, 100), (180, 200), (360, 400), (720, 800), (1440, 1600)].map(|(c, r)| grid(c, r)).to_vec(),
            case_grid: GridShape::PAPER,
            timed_steps: 3000,
            step_counts: vec![10, 30, 100, 300, 1000],
            travels_mm: vec![0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 1.75, 2.0],
            pitches: vec![0.15, 0.25, 0.34, 0.5, 0.7, 1.0],
            lathe_pitches: vec![0.02, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4],
            helix_rows: 1600,
            stroke_steps: 10_000,
            quick: true,
        }
    }

    /// Hardly anything: enough to see that every file is made.
    #[must_use]
    pub fn smallest() -> Self {
        Self {
            grids: vec![grid(60, 70), grid(90, 100)],
            case_grid: grid(90, 100),
            timed_steps: 20,
            step_counts: vec![10, 30],
            travels_mm: vec![0.5, 2.0],
            pitches: vec![0.7, 1.0],
            lathe_pitches: vec![0.05, 0.1],
            helix_rows: 200,
            stroke_steps: 100,
            quick: true,
        }
    }

    /// Number of pieces of work.
    pub(super) fn pieces(&self, entrants: &[Entrant]) -> u32 {
        let methods = methods().count();
        let asked: usize = entrants.iter().map(|entrant| self.grids_of(entrant).count()).sum();
        let on_case_grid = entrants.iter().filter(|entrant| self.asks(entrant));
        let cases: usize = on_case_grid
            .clone()
            .map(|entrant| CASES.iter().filter(|case| entrant.stands_on(case.support)).count())
            .sum();
        (self.grids.len() + 2 + asked + cases + 2 * on_case_grid.count() + 3 * methods) as u32
    }

    /// Whether a row of the table is asked on the grid of the cases.
    pub(super) fn asks(&self, entrant: &Entrant) -> bool {
        entrant.takes(self.case_grid)
    }

    /// The grids on which a row of the table is asked, the finest first.
    pub(super) fn grids_of(&self, entrant: &Entrant) -> impl Iterator<Item = GridShape> {
        self.grids.iter().rev().copied().filter(|grid| entrant.takes(*grid))
    }
}
