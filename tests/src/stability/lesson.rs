//! A teacher's hand on a student's, through a network that is slow, uneven and loses: what is felt, and what is learnt to follow.
//!
//! Owns teacher, student and the way between them; the student's loop is the studio's own.
//! Invariant: the dice are the same every run, and the teacher's way is the same for every student.

use std::collections::BTreeMap;
use std::time::Duration;

use glam::Vec3;
use pottery_client::boundary::GuideNews;
use pottery_shared::clay::MethodKind;
use pottery_shared::haptics::{Guidance, GuidanceMode};
use pottery_shared::snapshot::SnapshotClock;
use pottery_shared::units::Tick;

use super::bench::{Bench, Scene};
use super::mechanism::{Grip, Mechanism};
use crate::dice::Dice;
use crate::line::{BurstLoss, Line, Quality};

/// Each way between a person and the studio: 100 ms there and back, up to 40 ms more each way, and one in twenty lost.
const LINE: Quality = Quality {
    latency: Duration::from_millis(50),
    jitter: Duration::from_millis(40),
    loss: BurstLoss { otherwise: 0.05, ..BurstLoss::NONE },
    duplicates: 0.01,
    rate: None,
};
/// Damper against which a teacher leads, N·s/m, as in `shared/src/haptics/guidance/tank.rs`.
const LEADING_NS_M: f64 = 4.0;
/// How long a lesson takes, from when the student's errors count, and when the teacher's fate comes, ms.
const LENGTH_MS: u64 = 12_000;
const COUNTS_MS: u64 = 2000;
const FATE_MS: u64 = 6000;
/// How far from the clay a lesson in the air is, m.
const AIR_M: f32 = 0.03;
/// Time between what a student sees and what the hand means, ms.
const REACTION_MS: usize = 150;

/// What becomes of the teacher after six seconds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fate {
    /// She goes on.
    GoesOn,
    /// Her hand stands still.
    Stops,
    /// Nothing is heard of her any more.
    Vanishes,
    /// Her tool is 50 mm elsewhere from one tick to the next, and back after half a second.
    Jumps,
    /// Her tool's place is no number for half a second.
    NoNumber,
}

impl Fate {
    /// Every one.
    pub const ALL: [Self; 5] = [Self::GoesOn, Self::Stops, Self::Vanishes, Self::Jumps, Self::NoNumber];
}

/// A lesson.
#[derive(Clone, Copy, Debug)]
pub struct Lesson {
    /// The student's hand.
    pub grip: Grip,
    /// How late the student's device gives its force, s.
    pub delay_s: f64,
    /// How the student is guided.
    pub guidance: Guidance,
    /// What becomes of the teacher.
    pub fate: Fate,
    /// How deep the teacher goes into clay, m; none for a lesson in the air.
    pub depth_m: Option<f32>,
}

/// What came of it.
#[derive(Clone, Copy, Debug)]
pub struct Learnt {
    /// Root of the mean square of how far the tool, and the student's device, was from the teacher's as it was shown, mm.
    pub tool_rms_mm: f64,
    /// The same for the student's own device.
    pub hand_rms_mm: f64,
    /// Largest force of guidance, N.
    pub guidance_n: f64,
    /// Largest rise of the whole force in a tick, N: what runs out or ends does so at once.
    pub jolt_n: f64,
    /// Least of what had come in at both devices' ports, mJ: the work of the teacher's hand on hers, less that of the student's on the
    /// student's. `E(t) = ∫(F_T·v_T − F_S·v_S)·dt`, and nothing was granted at first: below zero, guidance had made energy.
    pub energy_mj: f64,
    /// What the teacher's hand has given at her device until the end, and what was done on the student's at theirs, mJ.
    pub teacher_mj: f64,
    /// The same at the student's device; what the student's hand has done against it counts below zero.
    pub student_mj: f64,
    /// How old the teacher's place was when it was felt, on average, ms.
    pub late_ms: f64,
}

/// Where the teacher's tool is, m: up and down along the wall, to and fro round it, in and out.
pub(super) fn teacher_m(ms: u64, lesson: &Lesson) -> Vec3 {
    let turn = |hertz: f64, ms: u64| (std::f64::consts::TAU * hertz * ms as f64 * 1e-3).sin() as f32;
    let until = if lesson.fate == Fate::Stops { ms.min(FATE_MS) } else { ms };
    let angle = 0.5 * turn(0.23, until);
    let inwards_m = lesson.depth_m.map_or(-AIR_M, |depth_m| depth_m * turn(0.155, until).powi(2));
    let (sin, cos) = angle.sin_cos();
    let radius_m = Bench::TOUCHING_M.x - inwards_m;
    let at_m = Vec3::new(radius_m * cos, radius_m * sin, Bench::TOUCHING_M.z + 0.02 * turn(0.17, until));
    let is_odd = (FATE_MS..FATE_MS + 500).contains(&ms);
    match lesson.fate {
        Fate::Jumps if is_odd => at_m + Vec3::new(0.03, 0.0, 0.04),
        Fate::NoNumber if is_odd => Vec3::NAN,
        _ => at_m,
    }
}

/// What a student does wrong, m.
fn error_m(ms: u64) -> Vec3 {
    let turn = |hertz: f64| (std::f64::consts::TAU * hertz * ms as f64 * 1e-3).sin() as f32;
    Vec3::new(0.5e-3 * turn(0.37), 4e-3 * turn(0.43), 4e-3 * turn(0.29))
}

/// The teacher's places on their way: sent a hundred times a second, told on sixty times.
struct Way {
    up: Line,
    down: Line,
    at_studio: BTreeMap<u64, (Tick, Vec3)>,
    newest: Option<(Tick, Vec3)>,
    at_student: BTreeMap<(u64, u64), (Tick, Vec3)>,
    sent: u64,
}

impl Way {
    fn new(seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        let (up, down) = (Line::new(LINE, dice.split()), Line::new(LINE, dice.split()));
        Self { up, down, at_studio: BTreeMap::new(), newest: None, at_student: BTreeMap::new(), sent: 0 }
    }

    /// What comes to the student at a tick.
    fn pass(&mut self, ms: u64, said: Option<Vec3>) -> Vec<(Tick, Vec3)> {
        const BYTES: usize = 40;
        let (now, tick) = (Duration::from_millis(ms), Tick(ms));
        if let Some(at_m) = said.filter(|_| ms.is_multiple_of(10)) {
            for arrival in self.up.carry(now, BYTES) {
                self.at_studio.insert(arrival.as_micros() as u64, (tick, at_m));
            }
        }
        let later = self.at_studio.split_off(&(ms * 1000 + 1));
        for (_, heard) in std::mem::replace(&mut self.at_studio, later) {
            if self.newest.is_none_or(|(newest, _)| heard.0 > newest) {
                self.newest = Some(heard);
            }
        }
        if let Some(newest) = self.newest.filter(|_| SnapshotClock::default().is_due(tick)) {
            for arrival in self.down.carry(now, BYTES) {
                self.sent += 1;
                self.at_student.insert((arrival.as_micros() as u64, self.sent), newest);
            }
        }
        let later = self.at_student.split_off(&(ms * 1000 + 1, 0));
        std::mem::replace(&mut self.at_student, later).into_values().collect()
    }
}

/// Gives a lesson.
#[must_use]
pub fn give(method: MethodKind, lesson: &Lesson) -> Learnt {
    let mut bench = Bench::new(&Scene { delay_s: lesson.delay_s, ..Scene::of(method) });
    let mut way = Way::new(7);
    bench.net.tell(GuideNews::Guided(Some(lesson.guidance)));
    let begin_m = teacher_m(0, lesson) + error_m(0);
    let mut student = Mechanism::at_rest(lesson.grip, begin_m, 55e-6, lesson.delay_s);
    let mut seen = vec![begin_m; REACTION_MS];
    let mut sums = Sums::default();
    let mut last_n = 0.0;
    for ms in 0..LENGTH_MS {
        let at_m = teacher_m(ms, lesson);
        let moved_m = at_m.distance(teacher_m(ms.saturating_sub(1), lesson));
        // a hand does not jump: somebody has moved the tool, and does no work with it
        let way_m = if moved_m < 1e-3 { f64::from(moved_m) } else { 0.0 };
        sums.teacher_j += LEADING_NS_M * way_m * way_m * 1e3;
        let is_gone = lesson.fate == Fate::Vanishes && ms >= FATE_MS;
        for (tick, heard_m) in way.pass(ms, Some(at_m).filter(|_| !is_gone)) {
            bench.net.tell(GuideNews::Teacher(tick, heard_m));
        }
        let device_m = student.reported_m();
        let (force_n, _) = bench.tick(Some(device_m));
        let shown_m = bench.net.status().teacher_m();
        seen.push(shown_m.unwrap_or(seen[seen.len() - 1]));
        let meant_m = seen[seen.len() - 1 - REACTION_MS] + error_m(ms);
        sums.work_j += student.pass(force_n, meant_m, 1e-3);
        sums.note(ms, &bench, (device_m, shown_m), f64::from(force_n.length()) - last_n);
        last_n = f64::from(force_n.length());
    }
    sums.learnt()
}

#[derive(Debug)]
struct Sums {
    teacher_j: f64,
    work_j: f64,
    least_j: f64,
    tool_m2: f64,
    hand_m2: f64,
    late_s: f64,
    counted: f64,
    guidance_n: f64,
    jolt_n: f64,
}

impl Default for Sums {
    fn default() -> Self {
        Self {
            teacher_j: 0.0,
            work_j: 0.0,
            least_j: f64::INFINITY,
            tool_m2: 0.0,
            hand_m2: 0.0,
            late_s: 0.0,
            counted: 0.0,
            guidance_n: 0.0,
            jolt_n: 0.0,
        }
    }
}

impl Sums {
    fn note(&mut self, ms: u64, bench: &Bench, (device_m, shown_m): (Vec3, Option<Vec3>), jolt_n: f64) {
        let status = bench.net.status();
        self.least_j = self.least_j.min(self.teacher_j - self.work_j);
        self.jolt_n = self.jolt_n.max(jolt_n);
        let Some(figures) = status.guided() else { return };
        self.guidance_n = self.guidance_n.max(f64::from(figures.force_n));
        if let (Some(shown_m), Some(tool_m)) = (shown_m, status.tool_m())
            && ms >= COUNTS_MS
        {
            self.counted += 1.0;
            self.tool_m2 += f64::from(tool_m.distance_squared(shown_m));
            self.hand_m2 += f64::from(device_m.distance_squared(shown_m));
            self.late_s += f64::from(figures.late_s);
        }
    }

    fn learnt(self) -> Learnt {
        let root_mm = |sum_m2: f64| (sum_m2 / self.counted).sqrt() * 1e3;
        Learnt {
            tool_rms_mm: root_mm(self.tool_m2),
            hand_rms_mm: root_mm(self.hand_m2),
            guidance_n: self.guidance_n,
            jolt_n: self.jolt_n,
            energy_mj: self.least_j * 1e3,
            teacher_mj: self.teacher_j * 1e3,
            student_mj: self.work_j * 1e3,
            late_ms: self.late_s / self.counted * 1e3,
        }
    }
}

/// Every way of guiding that is tried, and what it is called.
pub const WAYS: [(&str, Guidance); 9] = [
    ("seen only", Guidance::new(GuidanceMode::Point, 1.0)),
    ("lead 25 %", Guidance::new(GuidanceMode::Lead, 0.25)),
    ("lead 50 %", Guidance::new(GuidanceMode::Lead, 0.5)),
    ("lead 100 %", Guidance::new(GuidanceMode::Lead, 1.0)),
    ("share 25 %", Guidance::new(GuidanceMode::Share, 0.25)),
    ("share 50 %", Guidance::new(GuidanceMode::Share, 0.5)),
    ("take over", Guidance::TAKE_OVER),
    ("noise 100 %", Guidance::new(GuidanceMode::Noise, 1.0)),
    ("repel 100 %", Guidance::new(GuidanceMode::Repel, 1.0)),
];
