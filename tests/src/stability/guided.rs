//! What a student feels of a teacher far away: energy, force, jolts, the end of it, and what it helps.
//!
//! Owns the scenarios and the table of all ways of guiding; how a lesson goes is [`super::lesson`]'s.
//! Invariant: every hand from light to firm has every lesson, and the worst counts.

use pottery_client::boundary::GuideNews;
use pottery_shared::clay::MethodKind;
use pottery_shared::haptics::{DeviceSpecs, Guidance, GuidanceMode};
use pottery_shared::units::Tick;

use super::bench::{Bench, Scene};
use super::lesson::{Fate, Learnt, Lesson, WAYS, give, teacher_m};
use super::mechanism::Grip;
use crate::chart::csv::{Cell, Row};
use crate::failures::{larger, smaller};

/// How deep a teacher goes into clay, m.
const DEPTH_M: f32 = 1.5e-3;

/// A lesson of every hand.
fn lessons(method: MethodKind, lesson: Lesson) -> impl Iterator<Item = Learnt> {
    Grip::ALL.into_iter().map(move |grip| give(method, &Lesson { grip, ..lesson }))
}

const fn lesson(guidance: Guidance, fate: Fate, depth_m: Option<f32>) -> Lesson {
    Lesson { grip: Grip::STANDARD, delay_s: 0.0, guidance, fate, depth_m }
}

/// The strongest of every mode that is felt.
fn strongest() -> impl Iterator<Item = Guidance> {
    GuidanceMode::ALL.into_iter().map(|mode| Guidance::new(mode, 1.0)).filter(|way| way.mode() != GuidanceMode::Point)
}

/// Lessons in which the teacher stops, vanishes, jumps or is no number, in the air.
fn odd_lessons(method: MethodKind) -> impl Iterator<Item = Learnt> {
    let odd = Fate::ALL.into_iter().filter(|fate| *fate != Fate::GoesOn);
    let each = odd.flat_map(|fate| strongest().map(move |guidance| lesson(guidance, fate, None)));
    each.flat_map(move |lesson| lessons(method, lesson))
}

/// Least energy at both ports, mJ, over every way of guiding, in clay, with devices that are 0 and 2 ms late.
pub(super) fn energy(method: MethodKind) -> f64 {
    let ways = WAYS.into_iter().flat_map(|(_, guidance)| {
        [0.0, 2e-3].map(|delay_s| Lesson { delay_s, ..lesson(guidance, Fate::GoesOn, Some(DEPTH_M)) })
    });
    let learnt = ways.flat_map(|lesson| lessons(method, lesson));
    learnt.map(|learnt| learnt.energy_mj).fold(f64::INFINITY, smaller)
}

/// The same when something becomes of the teacher.
pub(super) fn odd_energy(method: MethodKind) -> f64 {
    odd_lessons(method).map(|learnt| learnt.energy_mj).fold(f64::INFINITY, smaller)
}

/// Largest rise of force in a tick, N, whatever becomes of the teacher.
pub(super) fn odd_jolt(method: MethodKind) -> f64 {
    odd_lessons(method).map(|learnt| learnt.jolt_n).fold(0.0, larger)
}

/// Largest force of guidance over a quarter of what the device gives.
pub(super) fn strength(method: MethodKind) -> f64 {
    let quarter_n = f64::from(DeviceSpecs::OMNI.peak_force_n) / 4.0;
    let learnt = strongest().flat_map(|guidance| lessons(method, lesson(guidance, Fate::GoesOn, Some(DEPTH_M))));
    learnt.map(|learnt| learnt.guidance_n / quarter_n).fold(0.0, larger)
}

/// Ticks until there is no force after the student has ended it, in the air, whatever the teacher does on; without end where there was
/// no force to be ended.
pub(super) fn ticks_to_end(method: MethodKind) -> f64 {
    strongest().map(|guidance| ticks_to_end_of(method, guidance)).fold(0.0, larger)
}

fn ticks_to_end_of(method: MethodKind, guidance: Guidance) -> f64 {
    let mut bench = Bench::new(&Scene::of(method));
    let at_m = Bench::TOUCHING_M + glam::Vec3::X * 0.02;
    let lesson = lesson(guidance, Fate::GoesOn, None);
    bench.net.tell(GuideNews::Guided(Some(guidance)));
    // she moves, since a teacher at rest has given nothing to be felt with
    let tick = |bench: &mut Bench| {
        let heard = GuideNews::Teacher(Tick(bench.local()), teacher_m(bench.local(), &lesson));
        bench.net.tell(heard);
        bench.tick(Some(at_m)).0
    };
    let felt_n = (0..1000).map(|_| tick(&mut bench)).last();
    if felt_n.is_none_or(|force_n| force_n == glam::Vec3::ZERO) {
        return f64::INFINITY;
    }
    bench.net.status().end_guidance();
    let with_force = (1..=1000).filter(|_| tick(&mut bench) != glam::Vec3::ZERO).last();
    with_force.map_or(1.0, |last| f64::from(last + 1))
}

/// What a light hand that is led with half the strength is off by, over what it is off by when it only sees the teacher.
pub(super) fn help(method: MethodKind) -> f64 {
    let off_mm = |mode| {
        let guidance = Guidance::new(mode, 0.5);
        give(method, &Lesson { grip: Grip::LIGHT, ..lesson(guidance, Fate::GoesOn, None) }).tool_rms_mm
    };
    off_mm(GuidanceMode::Lead) / off_mm(GuidanceMode::Point)
}

/// A way of guiding in a hand.
#[derive(Clone, Copy, Debug)]
pub struct GuidanceFigures {
    /// What the way is called; see [`WAYS`].
    pub way: &'static str,
    /// Who is guided.
    pub grip: Grip,
    /// Whether on clay, or in the air.
    pub on_clay: bool,
    /// What came of it.
    pub learnt: Learnt,
}

impl Row for GuidanceFigures {
    const COLUMNS: &'static [&'static str] = &[
        "guidance",
        "hand",
        "on_clay",
        "tool_rms_mm",
        "hand_rms_mm",
        "largest_guidance_n",
        "largest_rise_n",
        "least_energy_mj",
        "teacher_gave_mj",
        "done_on_student_mj",
        "late_ms",
    ];

    fn cells(&self) -> Vec<Cell> {
        let Learnt { tool_rms_mm, hand_rms_mm, guidance_n, jolt_n, late_ms, .. } = self.learnt;
        let Learnt { energy_mj, teacher_mj, student_mj, .. } = self.learnt;
        let figures = [tool_rms_mm, hand_rms_mm, guidance_n, jolt_n, energy_mj, teacher_mj, student_mj, late_ms];
        let names = [self.way.into(), self.grip.name.into(), self.on_clay.into()];
        names.into_iter().chain(figures.map(Cell::from)).collect()
    }
}

/// Every way of guiding in every hand, on clay and in the air.
#[must_use]
pub fn measure_guidance() -> Vec<GuidanceFigures> {
    let mut figures = Vec::new();
    for depth_m in [None, Some(DEPTH_M)] {
        for (way, guidance) in WAYS {
            for grip in Grip::ALL {
                let lesson = Lesson { grip, ..lesson(guidance, Fate::GoesOn, depth_m) };
                let learnt = give(MethodKind::Plastic, &lesson);
                figures.push(GuidanceFigures { way, grip, on_clay: depth_m.is_some(), learnt });
            }
        }
    }
    figures
}
