//! A fast wheel as a profile: what it saves, and by how much it is off the grid, over the pitch of the thread.
//!
//! Owns the strokes and the picture; the choice between profile and grid is the core's, here with the loosest bound there is.
//! Invariant: grid and profile are timed in turns, a turn of the wheel each.

use std::f32::consts::TAU;
use std::time::Instant;

use glam::Vec3;
use pottery_shared::clay::{ErrorBound, Lathe, MethodKind, PlasticCsem, Pot, PotSpec, Press, SubStep, Surface};
use pottery_shared::tool::Sphere;
use pottery_shared::units::Tick;

use super::canvas::{Canvas, FRAME, INK};
use super::cases::reference_dent;
use super::csv::{Cell, Row};
use super::extent::Extent;
use super::panel::{Axis, Look, Panel, Sign};
use super::pictures::{cell, sheet};
use super::progress::Progress;
use super::{ChartError, Figures};
use crate::dent::{Dent, DentError};

/// Depth of the tool, mm.
const DEPTH_MM: f32 = 2.0;
/// Turns in which the tool comes in, and in which it goes along.
const TURNS_IN: u32 = 6;
const TURNS: u32 = 14;
/// Turning speeds: the slowest and the fastest of the work on clay, and one between them.
const SPEEDS_RPM: [f32; 3] = [60.0, 120.0, 300.0];
/// As loose as a bound can be, so that the profile is not left where it is bad.
const BOUND: f32 = 0.2;

/// A stroke at one speed and pitch.
#[derive(Clone, Copy, Debug)]
pub struct LatheFigures {
    /// Turns a minute.
    pub rpm: f32,
    /// Feed in a turn over the length of contact.
    pub pitch_over_contact: f32,
    /// Median time of a tick on the grid and as a profile, ns; the latter only if it ever was one for a whole turn.
    pub grid_ns: f64,
    /// See `grid_ns`.
    pub profile_ns: f64,
    /// RMS difference between both over the depth, on all rows that the stroke moved.
    pub error: f64,
    /// What the core estimates, over the depth.
    pub estimate: f64,
}

impl LatheFigures {
    fn saved(&self) -> f64 {
        self.grid_ns / self.profile_ns
    }
}

/// Makes every stroke twice.
///
/// # Errors
/// [`ChartError`] when a pot or a tool cannot be made.
///
/// # Panics
/// When the loosest bound is none.
pub fn measure(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<LatheFigures>, ChartError> {
    progress.begin("fast wheel as a profile");
    let dent = reference_dent(extent.case_grid, DEPTH_MM, true);
    let mut figures = Vec::new();
    for rpm in SPEEDS_RPM {
        for &pitch_over_contact in &extent.lathe_pitches {
            figures.push(stroke(&dent, rpm, pitch_over_contact)?);
        }
    }
    Ok(figures)
}

fn stroke(dent: &Dent, rpm: f32, pitch: f32) -> Result<LatheFigures, ChartError> {
    let tool = Sphere::new(dent.tool).map_err(DentError::from)?;
    let mut full = Pot::new(dent.pot).map_err(DentError::from)?;
    let mut profiled = full.clone();
    let mut substep = SubStep::for_spheres(dent.pot.shape);
    let bound = ErrorBound::new(BOUND).expect("the loosest bound is one");
    let mut lathe = Lathe::new(&profiled.surfaces()[0], bound, PlasticCsem::default());
    let tick_rad = rpm / 60.0 * TAU * Tick::PERIOD.0;
    let contact_m = 2.0 * (2.0 * dent.tool.0 * dent.depth.0 - dent.depth.0.powi(2)).sqrt();
    let centre_m = |tick: u32| {
        let (turned, (sin, cos)) = (tick as f32 * tick_rad / TAU, (tick as f32 * tick_rad).sin_cos());
        let depth_m = dent.depth.0 * (turned / TURNS_IN as f32).min(1.0);
        let along_m = pitch * contact_m * (turned - TURNS_IN as f32).max(0.0);
        let distance_m = dent.pot.radius.0 + dent.tool.0 - depth_m;
        Vec3::new(distance_m * cos, distance_m * sin, 0.3 * dent.pot.height.0 + along_m)
    };
    let ticks = (TAU / tick_rad) as u32;
    let (mut grid_ns, mut profile_ns, mut last) = (Vec::new(), Vec::new(), None);
    for turn in 0..TURNS_IN + TURNS {
        let presses: Vec<Press> = (turn * ticks..(turn + 1) * ticks)
            .map(|tick| {
                let from_m = tick.checked_sub(1).map(centre_m);
                Press { from_m, turning: -1, strength: dent.strength, ..Press::held(tool, centre_m(tick)) }
            })
            .collect();
        let mut begin = Instant::now();
        for press in &presses {
            substep.advance(&mut full, &[*press], MethodKind::Plastic, |_, _| ());
        }
        let full_ns = begin.elapsed().as_nanos() as f64 / f64::from(ticks);
        begin = Instant::now();
        let mut whole = true;
        for press in &presses {
            if lathe.advance(&mut profiled.surfaces_mut()[0], press, tick_rad, |_| ()).is_none() {
                whole = false;
                substep.advance(&mut profiled, &[*press], MethodKind::Plastic, |_, _| ());
            }
        }
        if whole {
            grid_ns.push(full_ns);
            profile_ns.push(begin.elapsed().as_nanos() as f64 / f64::from(ticks));
        }
        last = presses.last().copied();
    }
    let estimate = last.map_or(f32::NAN, |press| lathe.error_estimate(&press, dent.pot.radius.0));
    lathe.leave(&mut profiled.surfaces_mut()[0], |_| ());
    Ok(LatheFigures {
        rpm,
        pitch_over_contact: pitch,
        grid_ns: median(&mut grid_ns),
        profile_ns: median(&mut profile_ns),
        error: error(&full.surfaces()[0], &profiled.surfaces()[0], dent),
        estimate: estimate.into(),
    })
}

/// Not a number when there is none.
fn median(samples: &mut [f64]) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples.get(samples.len() / 2).copied().unwrap_or(f64::NAN)
}

fn error(grid: &Surface, profile: &Surface, dent: &Dent) -> f64 {
    let (mut squares, mut count) = (0.0, 0.0_f64);
    for row in 0..grid.shape().rows() as usize {
        let columns = 0..grid.shape().columns();
        let radii_m = columns.map(|column| (grid.column_m(column)[row], profile.column_m(column)[row]));
        if radii_m.clone().any(|(radius_m, _)| (radius_m - dent.pot.radius.0).abs() > 0.02 * dent.depth.0) {
            squares += radii_m.map(|(one_m, other_m)| f64::from(one_m - other_m).powi(2)).sum::<f64>();
            count += f64::from(grid.shape().columns());
        }
    }
    (squares / count.max(1.0)).sqrt() / f64::from(dent.depth.0)
}

impl Row for LatheFigures {
    const COLUMNS: &'static [&'static str] = &[
        "method",
        "speed_rpm",
        "pitch_over_contact_ratio",
        "grid_tick_us",
        "profile_tick_us",
        "saved_ratio",
        "rms_error_percent_of_depth",
        "estimate_percent_of_depth",
    ];

    fn cells(&self) -> Vec<Cell> {
        vec![
            "ours".into(),
            f64::from(self.rpm).into(),
            f64::from(self.pitch_over_contact).into(),
            (self.grid_ns * 1e-3).into(),
            (self.profile_ns * 1e-3).into(),
            self.saved().into(),
            (self.error * 100.0).into(),
            (self.estimate * 100.0).into(),
        ]
    }
}

/// Error and saving over the pitch.
pub(super) fn picture(figures: &Figures) -> Canvas {
    let all = &figures.lathe;
    let looks = || SPEEDS_RPM.iter().enumerate().map(|(row, rpm)| (Look::of_row(row), *rpm));
    let mut entries = vec![(Sign::Line(INK), "estimate of the core, 44 % · (P/2a)² + 110 % · (δ/r)²".to_owned())];
    entries.extend(looks().map(|(look, rpm)| (Sign::Marked(look), format!("{rpm} rpm"))));
    let (canvas, room) = sheet(
        "A fast wheel as a profile: error made and time saved",
        &entries,
        "P: feed of the tool in one turn. 2a: length of its contact, 13.3 mm for a 12 mm sphere δ = 2 mm deep in a pot of r = 60 mm. Error: RMS difference \
         to the full grid over the depth, wherever the stroke moved clay, the thread under the tool included. Dashed: 1 %, the \
         bound of the core unless another is set, above which it takes the grid.",
    );
    let x = || Axis::log("pitch over length of contact, P/2a", all.iter().map(|one| one.pitch_over_contact.into()));
    let errors = all.iter().map(|one| one.error * 100.0).chain([1.0]);
    let saved = all.iter().map(LatheFigures::saved);
    let (left, right) = (cell(room, (0, 2), (0, 1)), cell(room, (1, 2), (0, 1)));
    let panels = [
        Panel::new(&canvas, left, "error made", x(), Axis::log("RMS error, % of depth", errors)),
        Panel::new(&canvas, right, "time saved", x(), Axis::log("time on the grid over time as a profile", saved)),
    ];
    let [cusps, deep] = [Lathe::CUSPS, Lathe::DEEP].map(|share| 100.0 * f64::from(share));
    let depth = f64::from(DEPTH_MM / PotSpec::default().radius.as_mm());
    let estimate = |p: f64| [p, cusps * p * p + deep * depth * depth];
    let theory: Vec<[f64; 2]> = (1..=60).map(|part| estimate(f64::from(part) * 0.01)).collect();
    panels[0].line(&theory, INK, 2.0);
    panels[0].dashed(&[[1e-9, 1.0], [1e9, 1.0]], FRAME, 1.5);
    for (look, rpm) in looks() {
        let own = || all.iter().filter(|one| one.rpm == rpm).map(|one| (f64::from(one.pitch_over_contact), one));
        let errors: Vec<_> = own().map(|(pitch, one)| [pitch, one.error * 100.0]).collect();
        let saved: Vec<_> = own().map(|(pitch, one)| [pitch, one.saved()]).collect();
        for (panel, line) in panels.iter().zip([errors, saved]) {
            panel.line(&line, look.colour, 2.5);
            panel.marks(&line, look);
        }
    }
    canvas
}
