//! The paper's Table I and rates beside this machine's, for the same 144,000 elements.
//!
//! Owns the paper's figures and the walk in which ours are taken; the pot is the paper's 360 × 400 whatever the extent.
//! Invariant: what is not the same thing is said beside the figure.

use std::fmt::Write;
use std::time::Instant;

use pottery_shared::clay::{GridShape, Surface};
use pottery_shared::snapshot::{Author, Touched};

use super::ChartError;
use super::csv::{Cell, Row};
use super::entrant::{ENTRANTS, methods};
use super::extent::Extent;
use super::machine::Machine;
use super::progress::Progress;
use super::speed::{Times, Walk};

/// Steps between two snapshots: 60 a second at 1 kHz.
const STEPS_A_SNAPSHOT: u32 = 17;
/// Fewest snapshots.
const SNAPSHOTS_MIN: u32 = 10;

/// A row of the paper.
struct Published {
    title: &'static str,
    /// Mean, shortest and longest, ms.
    total_ms: [f64; 3],
    transformation_ms: [f64; 3],
    /// Mean and slowest, Hz.
    haptic_hz: [u32; 2],
    picture_hz: u32,
}

const PAPER: [Published; 2] = [
    Published {
        title: "original CSEM",
        total_ms: [3.93, 0.93, 8.56],
        transformation_ms: [2.84, 0.75, 5.71],
        haptic_hz: [259, 136],
        picture_hz: 52,
    },
    Published {
        title: "improved CSEM",
        total_ms: [0.83, 0.16, 1.99],
        transformation_ms: [0.07, 0.02, 0.28],
        haptic_hz: [879, 567],
        picture_hz: 510,
    },
];

/// What the paper has: whose, the means of transformation and total, ms, and pictures a second.
pub(super) fn published() -> [(&'static str, [f64; 2], u32); 2] {
    PAPER.map(|row| (row.title, [row.transformation_ms[0], row.total_ms[0]], row.picture_hz))
}

/// Times of a method on 144,000 elements.
#[derive(Clone, Copy, Debug)]
pub struct Table1Figures {
    /// Row of the table of methods.
    pub row: usize,
    /// Contact, response, propagation and force: one step.
    pub step: Times,
    /// Rounding and packing what changed, for everybody who looks on: once in 17 steps.
    pub snapshot: Times,
}

/// Times every method.
///
/// # Errors
/// [`ChartError`] when a pot cannot be made.
pub fn measure(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<Table1Figures>, ChartError> {
    progress.begin("the paper's Table I");
    let mut figures = Vec::new();
    for (row, method) in methods() {
        let mut walk = Walk::new(method, GridShape::PAPER)?;
        let mut author = Author::new(walk.pressing.pot_mut());
        let mut touched = Touched::none(walk.pressing.pot().surfaces().iter().map(Surface::shape));
        let (mut steps, mut snapshots) = (Vec::new(), Vec::new());
        for number in 1..=extent.timed_steps.max(SNAPSHOTS_MIN * STEPS_A_SNAPSHOT) {
            steps.push(walk.step(|surface, window| touched.add_window(surface, window)));
            if number % STEPS_A_SNAPSHOT == 0 {
                let now = walk.moment();
                let begin = Instant::now();
                let delta = author.publish(walk.pressing.pot_mut(), &mut touched, now);
                snapshots.push(begin.elapsed().as_nanos() as f64);
                std::hint::black_box(delta);
            }
        }
        figures.push(Table1Figures { row, step: Times::of(steps), snapshot: Times::of(snapshots) });
    }
    Ok(figures)
}

impl Row for Table1Figures {
    const COLUMNS: &'static [&'static str] = &[
        "method",
        "step_mean_ms",
        "step_least_ms",
        "step_most_ms",
        "snapshot_mean_ms",
        "snapshot_least_ms",
        "snapshot_most_ms",
        "steps_a_second_hz",
    ];

    fn cells(&self) -> Vec<Cell> {
        let Self { step, snapshot, .. } = self;
        let times = [step.mean_us, step.least_us, step.most_us, snapshot.mean_us, snapshot.least_us, snapshot.most_us];
        let mut cells = vec![Cell::from(ENTRANTS[self.row].name)];
        cells.extend(times.map(|us| Cell::from(us * 1e-3)));
        cells.push((1e6 / step.mean_us).into());
        cells
    }
}

/// The page.
#[must_use]
pub fn page(figures: &[Table1Figures], machine: &Machine) -> String {
    let mut page = String::from("# The paper's Table I, and the same 144,000 elements here\n\n");
    page.push_str("As published (Pentium 4 at 3.2 GHz, GeForce 8800 GTS, PHANToM Omni); times in ms:\n\n");
    page.push_str("| | total, mean | least | most | of which transformation, mean | least | most | haptic, mean | slowest | picture |\n");
    page.push_str("|---|---|---|---|---|---|---|---|---|---|\n");
    for Published { title, total_ms, transformation_ms, haptic_hz, picture_hz } in &PAPER {
        let times =
            [total_ms.map(|ms| ms.to_string()).join(" | "), transformation_ms.map(|ms| ms.to_string()).join(" | ")];
        let [haptic, slowest] = haptic_hz;
        let row = format!("| {title} | {} | {haptic} Hz | {slowest} Hz | {picture_hz} Hz |\n", times.join(" | "));
        page.push_str(&row);
    }
    let here = format!("\nHere ({}); times in ms:\n\n", machine.sentence());
    page.push_str(&here);
    page.push_str("| | step, mean | least | most | snapshot, mean | least | most | step and snapshot, mean | steps a second, one core |\n");
    page.push_str("|---|---|---|---|---|---|---|---|---|\n");
    for Table1Figures { row, step, snapshot } in figures {
        let ms = |us: f64| format!("{:.4}", us * 1e-3);
        let cells = [step.mean_us, step.least_us, step.most_us, snapshot.mean_us, snapshot.least_us, snapshot.most_us];
        let written = writeln!(
            page,
            "| {} | {} | {} | {:.0} |",
            ENTRANTS[*row].title,
            cells.map(ms).join(" | "),
            ms(step.mean_us + snapshot.mean_us),
            1e6 / step.mean_us
        );
        written.expect("writing to a string does not fail");
    }
    page.push_str(NOTES);
    page
}

/// What has to be known to read the two tables side by side.
const NOTES: &str = "
The machines are about twenty years apart, so the columns say what is possible now and not which program is better
written; the rows of one table can be compared with each other.

- A *step* is the contact with the tool, the answer of the clay and the force on the hand: the paper's total without its
  transformation. The studio takes a thousand a second, by the clock; the last column is what one core could take.
- The *transformation* is absent here: vertices and normals are made by the graphics card from the texture of radii
  that changed. `accuracy-chart transform` measures it, beside one on the processor.
- A *snapshot* rounds and packs what changed, for everybody who works on the pot; it is made 60 times a second, on the
  server. The paper's system has one user and nothing like it.
- Both papers move the tool along a path of their own. Here it goes round once a second, 2 mm deep, 50 mm up or down a
  turn, so that nearly all of what it meets is untouched.
";
