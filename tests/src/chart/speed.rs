//! Time of a step against error, for every method, yardstick and grid.
//!
//! Owns the walk that is timed: a sphere of 12 mm, 2 mm deep, round the pot once a second and up and down by 50 mm a turn,
//! so that most of what it meets is untouched; and first steps on clay that is untouched, in which all touch the same elements.
//! Invariant: the methods take turns of ten steps, so that a disturbance of the machine meets all of them.

use std::time::Instant;

use pottery_shared::clay::{GridShape, Method, MethodKind, Phase, Wheel, Window};
use pottery_shared::snapshot::Moment;
use pottery_shared::units::{Rpm, Seconds, Tick};

use super::ChartError;
use super::cases::{CASES, reference_dent};
use super::csv::{Cell, Row};
use super::entrant::{ENTRANTS, Step, stepping};
use super::extent::Extent;
use super::progress::Progress;
use crate::dent::{Dent, DentError, Dented, Pressing};

/// Length of a step, s.
const STEP: Seconds = Seconds(1e-3);
/// Depth of the walk, mm.
const DEPTH_MM: f32 = 2.0;
/// Steps that a method makes before it is the next one's turn.
const TURN_STEPS: u32 = 10;
/// Steps that are not counted, until caches and memory are warm.
const WARM_STEPS: u32 = 50;
/// First steps of each method on each grid.
const FIRST_STEPS: u32 = 100;

/// A tool that goes round and round, up and down.
pub(super) struct Walk {
    pub(super) pressing: Pressing,
    number: u32,
}

impl Walk {
    pub(super) fn new(method: MethodKind, grid: GridShape) -> Result<Self, DentError> {
        let mut dent = Dent { method, ..reference_dent(grid, DEPTH_MM, false) };
        dent.pot.keeps_volume = method.keeps_volume();
        Ok(Self { pressing: Pressing::new(dent, STEP)?, number: 0 })
    }

    /// When it is, and how a wheel stands on which the tool is at rest.
    pub(super) fn moment(&self) -> Moment {
        let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(-60.0)));
        let tick = Tick(self.number.into());
        Moment { tick, phase: wheel.phase(tick) }
    }

    /// One step; returns its time, ns.
    pub(super) fn step(&mut self, touched: impl FnMut(usize, Window)) -> f64 {
        self.timed(|pressing, angle_rad, z_m| pressing.step_telling(angle_rad, DEPTH_MM * 1e-3, z_m, 1, touched))
    }

    /// One step of another kind; returns its time, ns.
    fn step_by(&mut self, step: Step) -> f64 {
        self.timed(|pressing, angle_rad, z_m| step(pressing, angle_rad, DEPTH_MM * 1e-3, z_m, 1))
    }

    fn timed(&mut self, step: impl FnOnce(&mut Pressing, f32, f32) -> f32) -> f64 {
        self.number += 1;
        let seconds = f64::from(self.number) * f64::from(STEP.0);
        let angle_rad = (seconds.fract() * std::f64::consts::TAU) as f32;
        // 50 mm up and 50 mm down, again and again
        let z_m = 0.075 + 0.05 * ((seconds + 1.0).rem_euclid(2.0) - 1.0).abs() as f32;
        let begin = Instant::now();
        step(&mut self.pressing, angle_rad, z_m);
        begin.elapsed().as_nanos() as f64
    }
}

/// Times of many steps.
#[derive(Clone, Copy, Debug)]
pub struct Times {
    /// Number of steps.
    pub steps: u32,
    /// Mean, µs.
    pub mean_us: f64,
    /// Shortest, µs.
    pub least_us: f64,
    /// Median, µs.
    pub p50_us: f64,
    /// The time that 99 of 100 steps keep to, µs.
    pub p99_us: f64,
    /// The time that 999 of 1000 steps keep to, µs.
    pub p999_us: f64,
    /// Longest, µs.
    pub most_us: f64,
}

impl Times {
    /// The times of some steps, given in ns.
    ///
    /// # Panics
    /// Without any.
    #[must_use]
    pub fn of(mut samples_ns: Vec<f64>) -> Self {
        assert!(!samples_ns.is_empty());
        samples_ns.sort_by(f64::total_cmp);
        let last = samples_ns.len() - 1;
        let at = |share: f64| samples_ns[(last as f64 * share).round() as usize] * 1e-3;
        Self {
            steps: samples_ns.len() as u32,
            mean_us: samples_ns.iter().sum::<f64>() * 1e-3 / samples_ns.len() as f64,
            least_us: at(0.0),
            p50_us: at(0.5),
            p99_us: at(0.99),
            p999_us: at(0.999),
            most_us: at(1.0),
        }
    }
}

/// Times of a method on a grid, and the elements that it touched in a step on average.
#[derive(Clone, Copy, Debug)]
pub struct Timed {
    row: usize,
    grid: GridShape,
    times: Times,
    contacts: f64,
    /// Median of a first step, µs.
    first_us: f64,
}

/// Times every method on every grid.
///
/// # Errors
/// [`ChartError`] when a pot cannot be made.
pub fn time(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<Timed>, ChartError> {
    let mut all = Vec::new();
    for &grid in &extent.grids {
        progress.begin(&format!("time a step on {} x {}", grid.columns(), grid.rows()));
        let mut walks = Vec::new();
        for (row, method, step) in stepping().filter(|(row, ..)| ENTRANTS[*row].takes(grid)) {
            let samples = Vec::with_capacity(extent.timed_steps as usize);
            walks.push((row, Walk::new(method, grid)?, step, samples, 0.0));
        }
        let mut steps = 0;
        while steps < WARM_STEPS + extent.timed_steps {
            for (_, walk, step, samples, contacts) in &mut walks {
                for number in steps..steps + TURN_STEPS {
                    let nanoseconds = walk.step_by(*step);
                    if number >= WARM_STEPS {
                        samples.push(nanoseconds);
                        *contacts += f64::from(walk.pressing.contact().elements);
                    }
                }
            }
            steps += TURN_STEPS;
        }
        for ((row, _, _, samples, contacts), first_us) in walks.into_iter().zip(first_steps(grid)?) {
            let contacts = contacts / samples.len() as f64;
            all.push(Timed { row, grid, times: Times::of(samples), contacts, first_us });
        }
    }
    Ok(all)
}

/// Median of a first step on untouched clay, µs, for every row of the table that is timed, in their order.
fn first_steps(grid: GridShape) -> Result<Vec<f64>, ChartError> {
    let mut walks = Vec::new();
    for (_, method, step) in stepping().filter(|(row, ..)| ENTRANTS[*row].takes(grid)) {
        walks.push((Walk::new(method, grid)?, step, Vec::new()));
    }
    let untouched = walks.iter().map(|(walk, ..)| walk.pressing.pot().clone()).collect::<Vec<_>>();
    for _ in 0..FIRST_STEPS {
        for ((walk, step, samples), untouched) in walks.iter_mut().zip(&untouched) {
            walk.pressing.pot_mut().copy_from(untouched);
            walk.pressing.lift();
            samples.push(walk.step_by(*step));
        }
    }
    Ok(walks.into_iter().map(|(_, _, samples)| Times::of(samples).p50_us).collect())
}

/// Errors of a row of the table on a grid.
#[derive(Clone, Debug)]
pub struct GridErrors {
    pub(super) row: usize,
    pub(super) grid: GridShape,
    /// Mean over 1 and 2 mm of RMS error over travel, backed: the sphere taken away, and still in.
    pub(super) permanent: f64,
    pub(super) loaded: f64,
    /// The dent that stays after 2 mm: its own error, and the RMS of its difference to the finest grid's, over the travel.
    pub(super) deep_error: f64,
    pub(super) deep_change: f64,
    /// Force at 2 mm, N, and the finest grid's.
    pub(super) force_n: f64,
    pub(super) finest_force_n: f64,
    /// Median time of a step while it was pressed, ns, as the model itself says.
    step_ns: f64,
}

/// Presses the backed cases on every grid.
///
/// # Errors
/// [`ChartError`] as for a single dent.
pub fn errors(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<GridErrors>, ChartError> {
    let mut all = Vec::new();
    for (row, entrant) in ENTRANTS.iter().enumerate() {
        let mut finest: Option<Dented> = None;
        for grid in extent.grids_of(entrant) {
            progress.begin(&format!("{}: error on {} x {}", entrant.title, grid.columns(), grid.rows()));
            let (mut permanent, mut loaded, mut deep) = (0.0, 0.0, None);
            for case in CASES.iter().filter(|case| case.is_base()) {
                let dent = case.dent(grid);
                let dented = entrant.dent(&dent, case.support)?;
                let error = dented.error(&case.reference()?, &dent);
                // two depths
                *(if case.release { &mut permanent } else { &mut loaded }) += error * 0.5;
                if case.release && case.depth_mm == 2 {
                    deep = Some((dented, dent, error));
                }
            }
            let (dented, dent, deep_error) = deep.expect("the backed dents of 2 mm are in the list");
            let against = finest.get_or_insert_with(|| dented.clone());
            all.push(GridErrors {
                row,
                grid,
                permanent,
                loaded,
                deep_error,
                deep_change: dented.difference_mm(against, &dent) / f64::from(dent.depth.as_mm()),
                force_n: dented.force_n.into(),
                finest_force_n: against.force_n.into(),
                step_ns: dented.step_ns,
            });
        }
    }
    Ok(all)
}

/// Time and error of a row of the table on a grid.
#[derive(Clone, Debug)]
pub struct MethodFigures {
    /// Row of the table of methods.
    pub row: usize,
    /// The grid.
    pub grid: GridShape,
    /// Median time of a step, µs.
    pub p50_us: f64,
    /// All that was timed; nothing for a yardstick, which says its median itself.
    pub times: Option<Times>,
    /// Elements touched in a step.
    pub contacts: Option<f64>,
    /// Mean over 1 and 2 mm of RMS error over travel, backed, the sphere taken away.
    pub permanent: f64,
    /// The same with the sphere still in.
    pub loaded: f64,
    /// Median over that of the studio's own method on the same grid.
    pub over_ours: f64,
    /// Median of a first step on untouched clay, in which all touch the same elements, µs, and over that of the studio's own; nothing for a yardstick
    /// that is asked for whole dents.
    pub first: Option<[f64; 2]>,
}

/// Puts times and errors of the same row and grid together, coarse grids first.
#[must_use]
pub fn joined(timed: &[Timed], errors: &[GridErrors]) -> Vec<MethodFigures> {
    let time_of = |row: usize, grid: GridShape| timed.iter().find(|timed| timed.row == row && timed.grid == grid);
    let figures = errors.iter().rev().map(|errors| {
        let timed = time_of(errors.row, errors.grid);
        let p50_us = timed.map_or(errors.step_ns * 1e-3, |timed| timed.times.p50_us);
        MethodFigures {
            row: errors.row,
            grid: errors.grid,
            p50_us,
            times: timed.map(|timed| timed.times),
            contacts: timed.map(|timed| timed.contacts),
            permanent: errors.permanent,
            loaded: errors.loaded,
            // ours is the first row
            over_ours: time_of(0, errors.grid).map_or(f64::NAN, |ours| p50_us / ours.times.p50_us),
            first: timed
                .zip(time_of(0, errors.grid))
                .map(|(timed, ours)| [timed.first_us, timed.first_us / ours.first_us]),
        }
    });
    let mut figures: Vec<MethodFigures> = figures.collect();
    figures.sort_by_key(|figures| (figures.row, figures.grid.elements()));
    figures
}

impl Row for MethodFigures {
    const COLUMNS: &'static [&'static str] = &[
        "method",
        "columns",
        "rows",
        "elements",
        "touched_elements",
        "timed_steps",
        "step_p50_us",
        "step_p99_us",
        "step_p999_us",
        "step_p50_ns_per_contact_element",
        "step_p50_to_ours_ratio",
        "first_step_p50_us",
        "first_step_p50_to_ours_ratio",
        "permanent_rms_error_percent_of_depth",
        "loaded_rms_error_percent_of_depth",
    ];

    fn cells(&self) -> Vec<Cell> {
        vec![
            ENTRANTS[self.row].name.into(),
            self.grid.columns().into(),
            self.grid.rows().into(),
            (self.grid.elements() as u32).into(),
            self.contacts.into(),
            self.times.map_or(0, |times| times.steps).into(),
            self.p50_us.into(),
            self.times.map(|times| times.p99_us).into(),
            self.times.map(|times| times.p999_us).into(),
            self.contacts.map(|contacts| self.p50_us * 1e3 / contacts).into(),
            self.over_ours.into(),
            self.first.map(|[first_us, _]| first_us).into(),
            self.first.map(|[_, over_ours]| over_ours).into(),
            (self.permanent * 100.0).into(),
            (self.loaded * 100.0).into(),
        ]
    }
}
