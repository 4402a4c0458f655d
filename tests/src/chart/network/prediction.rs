//! How far the clay that a hand feels is from what the room makes of the same samples, under the hand's own tool.
//!
//! Owns the cases: way and back, loss and overlap of two tools. Hands are ticked by the studio's own loop; the room's clay is that of the
//! recording, at the same tick. Where samples came later than that, it is the clay that the room had when it had pressed them: before, the room
//! does not know better than the hand, it knows less.
//! Invariant: every snapshot at which the tool touched is compared, element by element.

use std::path::Path;
use std::time::Duration;

use glam::Vec3;
use pottery_client::device::Device;
use pottery_shared::clay::{MethodKind, Phase, Pot, Support, Wheel};
use pottery_shared::haptics::{DeviceSpecs, Setup, Stages};
use pottery_shared::room::Happening;
use pottery_shared::snapshot::SnapshotClock;
use pottery_shared::tool::Tool;
use pottery_shared::units::{Rpm, Tick};

use super::NetworkError;
use super::session::Clay;
use super::studio::{Scene, play};
use crate::chart::csv::{Cell, Row};
use crate::line::{BurstLoss, Quality};

const WHEEL_SPEED: Rpm = Rpm(60.0);
/// The recording of the case that is measured.
const FILE: &str = "prediction.session";
/// Seconds after a hand's first press from which on it is compared: the lead has found itself.
const SETTLES_S: f64 = 1.0;
/// Radius of the tool, and how near the surface it touches, m.
const TOOL_M: f32 = 12e-3;
const TOUCH_M: f32 = 0.1e-3;

/// Where the other tool is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Overlap {
    /// There is none.
    Alone,
    /// 60 mm above.
    Apart,
    /// 16 mm above and a quarter of a turn away: the clay meets the other tool's edge every second, and 250 ms later this tool.
    Near,
    /// At the same height and 15 mm away: the tools overlap, and clay comes from one to the other in 40 ms.
    Overlapping,
}

impl Overlap {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Alone, Self::Apart, Self::Near, Self::Overlapping];

    /// In a word.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Alone => "alone",
            Self::Apart => "apart",
            Self::Near => "near",
            Self::Overlapping => "overlapping",
        }
    }

    /// Height above and angle after the first tool, m and rad.
    const fn away(self) -> (f32, f32) {
        match self {
            Self::Alone | Self::Apart => (60e-3, 0.0),
            Self::Near => (16e-3, std::f32::consts::FRAC_PI_2),
            Self::Overlapping => (0.0, 0.25),
        }
    }
}

/// A network and two hands.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Case {
    /// Way and back, ms.
    pub round_trip_ms: u32,
    /// Packets lost each way, in bursts of 40 ms in which half is lost, %.
    pub loss_percent: u32,
    /// Where the other tool is.
    pub overlap: Overlap,
}

impl Case {
    /// Every combination.
    #[must_use]
    pub fn all(round_trips_ms: &[u32], losses_percent: &[u32], overlaps: &[Overlap]) -> Vec<Self> {
        let mut all = Vec::new();
        for &overlap in overlaps {
            for &loss_percent in losses_percent {
                all.extend(round_trips_ms.iter().map(|&round_trip_ms| Self { round_trip_ms, loss_percent, overlap }));
            }
        }
        all
    }

    /// In a few words.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}, {} ms, {} % lost", self.overlap.title(), self.round_trip_ms, self.loss_percent)
    }

    fn line(&self) -> Quality {
        let (in_burst, lasts_ms) = (0.5, 40.0);
        let share = f64::from(self.loss_percent) / 100.0 / in_burst;
        let loss = match self.loss_percent {
            0 => BurstLoss::NONE,
            _ => BurstLoss {
                every: Duration::from_secs_f64(lasts_ms * 1e-3 * (1.0 - share) / share),
                lasts: Duration::from_secs_f64(lasts_ms * 1e-3),
                in_burst,
                otherwise: 0.0,
            },
        };
        let latency = Duration::from_micros(u64::from(self.round_trip_ms) * 500);
        Quality { latency, jitter: Duration::ZERO, loss, duplicates: 0.0, rate: None }
    }
}

/// What came of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct PredictionFigures {
    /// Which.
    pub case: Case,
    /// Largest error under the tool at a snapshot, mm: median, 99th percentile and largest over the snapshots of both hands.
    pub worst_mm: [f64; 3],
    /// Root of the mean square of all elements at all snapshots, mm.
    pub rms_mm: f64,
    /// Largest correction under an own tool over the whole run, mm: what a client took back of what it had predicted.
    pub corrected_mm: f64,
    /// Snapshots at which nothing was off, to the last bit, as a share.
    pub exact: f64,
    /// Snapshots that were compared.
    pub snapshots: u64,
}

/// What a hand felt at a snapshot: column, row and radius of what its tool touched.
struct Felt {
    number: usize,
    tick: Tick,
    elements: Vec<(u32, u32, f32)>,
}

/// A hand that goes up and down and in and out, the second otherwise than the first.
struct Swaying {
    number: usize,
    overlap: Overlap,
    begun_s: f64,
    ends_s: f64,
}

impl Swaying {
    fn at(&self, seconds: f64) -> Option<Vec3> {
        let time = (seconds - self.begun_s) as f32;
        if time < 0.0 || seconds >= self.ends_s {
            return None;
        }
        let (above_m, after) = if self.number == 0 { (0.0, 0.0) } else { self.overlap.away() };
        let shift = self.number as f32 * 1.3;
        let distance_m = 0.0715 - 0.0025 * (time * 2.1 + shift).sin().abs();
        let height_m = 0.09 + above_m + 0.004 * (time * 1.7 + shift).sin();
        Some(Vec3::new(distance_m * after.cos(), distance_m * after.sin(), height_m))
    }
}

impl Device for Swaying {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        self.at(seconds)
    }

    fn tool(&self) -> Tool {
        Tool::default()
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }

    /// Presses exactly where it goes, so that all cases press the same.
    fn setup(&self, share_of_small: f32) -> Setup {
        Setup { stages: Stages::EXACT, ..Setup::for_device(self.specs(), share_of_small) }
    }
}

/// Plays a case and compares.
///
/// # Errors
/// [`NetworkError`].
pub fn measure(case: &Case, seconds: f64, folder: &Path) -> Result<PredictionFigures, NetworkError> {
    let file = folder.join(FILE);
    let scene = Scene {
        seed: 7 + u64::from(case.round_trip_ms) + 1000 * u64::from(case.loss_percent),
        method: MethodKind::Plastic,
        support: Support::Backed,
        wheel_speed: WHEEL_SPEED,
        line: case.line(),
        seconds: SETTLES_S + seconds,
        file: &file,
    };
    let people = if case.overlap == Overlap::Alone { 1 } else { 2 };
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(WHEEL_SPEED));
    let mut felt: Vec<Felt> = Vec::new();
    let mut last = vec![Tick(0); people];
    let mut settled = vec![Tick(u64::MAX); people];
    let hand = |number, begun_s: f64| -> Box<dyn Device> {
        let ends_s = begun_s + SETTLES_S + seconds;
        Box::new(Swaying { number, overlap: case.overlap, begun_s: begun_s + 0.3, ends_s })
    };
    let reports = play(&scene, people, hand, |number, tick, tool_m, pot| {
        if settled[number] == Tick(u64::MAX) && tool_m.is_some() {
            settled[number] = tick.offset((SETTLES_S * 1e3) as i64);
        }
        if tick > last[number].max(settled[number]) && SnapshotClock::default().is_due(tick) {
            let elements = tool_m.map_or_else(Vec::new, |at_m| touched(pot, wheel.phase(tick).pot_from_room(at_m)));
            felt.push(Felt { number, tick, elements });
        }
        last[number] = last[number].max(tick);
    })?;
    let corrections = reports.iter().map(|report| report.correction_nm.max() as f64 * 1e-6);
    let corrected_mm = corrections.fold(0.0, f64::max);
    compare(*case, corrected_mm, felt, Clay::open(&file)?)
}

/// Takes the last case's recording away.
pub(super) fn tidy(folder: &Path) {
    // one that is left is in nobody's way
    drop(std::fs::remove_file(folder.join(FILE)));
}

/// The elements that a tool at a place of the pot's frame touches, with their radii.
fn touched(pot: &Pot, at_m: Vec3) -> Vec<(u32, u32, f32)> {
    let surface = &pot.surfaces()[0];
    let mut elements = Vec::new();
    for column in 0..surface.shape().columns() {
        let [x, y] = surface.direction(column);
        // the other side of the pot, and what is too far round
        if x * at_m.x + y * at_m.y < 0.0 || (x * at_m.y - y * at_m.x).abs() > TOOL_M + TOUCH_M {
            continue;
        }
        for (row, &radius_m) in (0..).zip(surface.column_m(column)) {
            let away_m = Vec3::new(radius_m * x, radius_m * y, surface.row_z_m(row)) - at_m;
            if away_m.length_squared() <= (TOOL_M + TOUCH_M).powi(2) {
                elements.push((column, row, radius_m));
            }
        }
    }
    elements
}

/// Where in a recording what a hand felt can be held against the clay.
#[derive(Default)]
struct Places {
    /// The tick of every entry.
    ticks: Vec<Tick>,
    /// The entries that are snapshots.
    snapshots: Vec<usize>,
    /// Everybody's samples, in the order in which they came: their ticks, and the entries with which they were pressed.
    pressed: Vec<Vec<(Tick, usize)>>,
}

impl Places {
    fn of(clay: &mut Clay) -> Result<Self, NetworkError> {
        let mut places = Self::default();
        let mut clients = Vec::new();
        while let Some((tick, what)) = clay.step()? {
            let entry = places.ticks.len();
            match what {
                Happening::Came { client } => {
                    clients.push(client);
                    places.pressed.push(Vec::new());
                }
                Happening::Pressed(samples) => {
                    for (client, sample) in samples {
                        let number = clients.iter().position(|one| *one == client);
                        let of = number.and_then(|number| places.pressed.get_mut(number));
                        of.expect("who presses has come before").push((sample.tick, entry));
                    }
                }
                Happening::Snapshot { .. } => places.snapshots.push(entry),
                _ => {}
            }
            places.ticks.push(tick);
        }
        Ok(places)
    }

    /// The entry after which the room's clay is held against what was felt.
    fn of_felt(&self, felt: &Felt) -> usize {
        let same_tick = self.ticks.partition_point(|tick| *tick <= felt.tick).saturating_sub(1);
        let pressed = &self.pressed[felt.number];
        let had = pressed.partition_point(|(tick, _)| *tick <= felt.tick);
        let Some(&(_, came)) = had.checked_sub(1).and_then(|last| pressed.get(last)) else { return same_tick };
        if came <= same_tick {
            return same_tick;
        }
        // as it was rounded, if it was before the hand's next sample
        let next = pressed.get(had).map_or(self.ticks.len(), |(_, entry)| *entry);
        let rounded = self.snapshots.get(self.snapshots.partition_point(|entry| *entry < came));
        rounded.copied().filter(|entry| *entry < next).unwrap_or(came)
    }
}

/// Holds what hands felt against the clay of the recording.
fn compare(case: Case, corrected_mm: f64, felt: Vec<Felt>, mut clay: Clay) -> Result<PredictionFigures, NetworkError> {
    let places = Places::of(&mut clay.again()?)?;
    let felt = felt.into_iter().filter(|felt| !felt.elements.is_empty());
    let mut in_order: Vec<(usize, Felt)> = felt.map(|felt| (places.of_felt(&felt), felt)).collect();
    in_order.sort_by_key(|(entry, _)| *entry);
    let (mut worst_mm, mut squares, mut elements) = (Vec::new(), 0.0, 0_u64);
    let mut gone_through = 0;
    for (entry, felt) in in_order {
        while gone_through <= entry && clay.step()?.is_some() {
            gone_through += 1;
        }
        let room = &clay.pot().surfaces()[0];
        let mut worst = 0.0_f64;
        for &(column, row, radius_m) in &felt.elements {
            let off_mm = f64::from(radius_m - room.column_m(column)[row as usize]) * 1e3;
            worst = worst.max(off_mm.abs());
            squares += off_mm * off_mm;
        }
        elements += felt.elements.len() as u64;
        worst_mm.push(worst);
    }
    worst_mm.sort_by(f64::total_cmp);
    let at = |share: f64| worst_mm.get((worst_mm.len().saturating_sub(1) as f64 * share) as usize).copied();
    let exact = worst_mm.iter().filter(|worst| **worst == 0.0).count();
    Ok(PredictionFigures {
        case,
        worst_mm: [0.5, 0.99, 1.0].map(|share| at(share).unwrap_or(f64::NAN)),
        corrected_mm,
        rms_mm: (squares / elements as f64).sqrt(),
        exact: exact as f64 / worst_mm.len() as f64,
        snapshots: worst_mm.len() as u64,
    })
}

impl Row for PredictionFigures {
    const COLUMNS: &'static [&'static str] = &[
        "overlap",
        "round_trip_ms",
        "loss_percent",
        "error_p50_mm",
        "error_p99_mm",
        "error_max_mm",
        "error_rms_mm",
        "correction_max_mm",
        "exact_percent",
        "snapshots",
    ];

    fn cells(&self) -> Vec<Cell> {
        let Self { case, worst_mm: [p50, p99, most], rms_mm, corrected_mm, exact, snapshots } = self;
        vec![
            case.overlap.title().into(),
            case.round_trip_ms.into(),
            case.loss_percent.into(),
            (*p50).into(),
            (*p99).into(),
            (*most).into(),
            (*rms_mm).into(),
            (*corrected_mm).into(),
            (exact * 100.0).into(),
            Cell::Count(*snapshots),
        ]
    }
}
