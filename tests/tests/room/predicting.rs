//! Predicted clay that is left as it is where a snapshot is what was predicted, against clay that is pressed again at every snapshot.
//!
//! Author, replica and two predictors of one hand in one process; the second one is made unsure before every snapshot.
//! Invariant under test: both hold the same clay to the bit, whatever others do and however late samples come, and whoever takes over what is said to
//! have changed has it too.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::VecDeque;
use std::f32::consts::PI;

use glam::Vec3;
use pottery_shared::clay::{
    Conditions, GridShape, Material, MethodKind, Pot, PotSpec, SubStep, Support, Surface, Wheel,
};
use pottery_shared::prediction::{Field, Hand, Patch, Predictor};
use pottery_shared::snapshot::{Author, Delta, Moment, Replica, SnapshotClock, Touched};
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample, rack};
use pottery_shared::units::{Rpm, Seconds, Tick};
use proptest::prelude::*;

/// What happens at a wheel, beside a hand that presses it.
#[derive(Clone, Debug)]
struct Course {
    support: Support,
    rpm: f32,
    /// Ticks that snapshots take to the hand.
    delay: u64,
    /// Ticks at which another hand begins to press, and how far from it around the pot, rad.
    others: Vec<(u64, f32)>,
    /// Ticks from which on samples come late, by how much.
    stalls: Vec<(u64, u64)>,
    /// Ticks at which the clay becomes wetter, from when on the author says.
    wetter: Vec<u64>,
    /// Ticks at which somebody is heard of who holds against the wall.
    beside: Vec<u64>,
    /// Ticks in which the hand is in the air, and from when on it is gone.
    rests: std::ops::Range<u64>,
    ends: u64,
}

const ALONE: Course = Course {
    support: Support::Backed,
    rpm: 40.0,
    delay: 90,
    others: Vec::new(),
    stalls: Vec::new(),
    wetter: Vec::new(),
    beside: Vec::new(),
    rests: 0..0,
    ends: 450,
};

const ENDS: u64 = 700;

fn hand(tick: u64, angle_rad: f32, is_off: bool) -> ToolSample {
    let seconds = tick as f32 * 1e-3;
    let distance_mm = if is_off { 90.0 } else { 71.5 - 2.0 * (seconds * 9.0).sin().abs() };
    let height_mm = 90.0 + 12.0 * (seconds * 5.0).sin();
    let at_mm = Vec3::new(distance_mm * angle_rad.cos(), distance_mm * angle_rad.sin(), height_mm);
    ToolSample {
        tick: Tick(tick),
        tool: Tool::default(),
        orientation: Orientation::default(),
        centre: Position::nearest(at_mm * 1e-3).unwrap(),
        side: Side::Outside,
    }
}

fn no_tiles(pot: &Pot) -> Touched {
    Touched::none(pot.surfaces().iter().map(Surface::shape))
}

/// What the author says at a snapshot.
struct Word {
    tick: Tick,
    acknowledged: u32,
    delta: Option<Delta>,
}

/// How often the clay was confirmed, and how often it was then pressed again.
#[derive(Debug, Default)]
struct Counts {
    confirmed: u32,
    pressed_again: u32,
}

fn run(course: &Course) -> Counts {
    let spec = PotSpec { shape: GridShape::new(120, 100).unwrap(), support: course.support, ..PotSpec::default() };
    let mut pot = Pot::new(spec).unwrap();
    let mut author = Author::new(&mut pot);
    let mut replica = Replica::new(Pot::new(spec).unwrap());
    let wheel = Wheel::starting_at(Tick(0), Default::default(), Wheel::rate_of(Rpm(course.rpm)));
    let mut conditions = Conditions { wheel, method: MethodKind::Plastic, ..Conditions::default() };
    let (clock, mut substep, mut touched) = (SnapshotClock::default(), SubStep::for_grid(spec.shape), no_tiles(&pot));
    let mut sure = Predictor::new(&replica, Tick(0), clock);
    let mut unsure = Predictor::new(&replica, Tick(0), clock);
    let mut seen = sure.field().pot().clone();
    // the hand learns of conditions when it is told, as of the tick from which on they hold
    let (mut known, mut told) = (conditions.clone(), VecDeque::new());
    let (mut waiting, mut last): (VecDeque<ToolSample>, [Option<ToolSample>; 2]) = (VecDeque::new(), [None; 2]);
    let (mut words, mut counts, mut acknowledged) = (VecDeque::new(), Counts::default(), 0);
    for tick in 1..=ENDS {
        let own = (tick < course.ends).then(|| hand(tick, 0.0, course.rests.contains(&tick)));
        if course.wetter.contains(&tick) {
            conditions.material.set(Tick(tick + 20), Material { viscosity: Seconds(0.05), ..Material::default() });
            told.push_back((tick + course.delay, conditions.clone()));
        }
        // the author has every sample in its own tick, but for those that come late
        waiting.extend(own);
        let is_late = course.stalls.iter().any(|&(from, ticks)| (from..from + ticks).contains(&tick));
        let mut presses = Vec::new();
        if !is_late {
            for sample in waiting.drain(..) {
                presses.push(vec![conditions.press(&sample, last[0].as_ref())]);
                last[0] = Some(sample);
                acknowledged += 1;
            }
        }
        for &(from, angle_rad) in &course.others {
            if (from..from + 60).contains(&tick) {
                let sample = hand(tick, angle_rad, false);
                presses.push(vec![conditions.press(&sample, last[1].as_ref())]);
                last[1] = Some(sample);
            }
        }
        for press in presses {
            substep.advance(&mut pot, &press, conditions.method, |surface, window| touched.add_window(surface, window));
        }
        if clock.is_due(Tick(tick)) {
            let now = Moment { tick: Tick(tick), phase: conditions.phase(Tick(tick)) };
            let delta = author.publish(&mut pot, &mut touched, now);
            words.push_back((tick + course.delay, Word { tick: Tick(tick), acknowledged, delta }));
        }
        // at the hand
        if let Some((_, news)) = told.pop_front_if(|(at, _)| *at <= tick) {
            known = news;
        }
        for predictor in [&mut sure, &mut unsure] {
            if course.beside.contains(&tick) {
                predictor.set_beside([hand(tick, 0.2, false)].into_iter());
            }
        }
        let mut changed = no_tiles(&pot);
        if let Some(own) = own {
            sure.handle_sample(own, &known, &mut changed);
            unsure.handle_sample(own, &known, &mut no_tiles(&pot));
        }
        while let Some((_, word)) = words.pop_front_if(|(at, _)| *at <= tick) {
            let (mut news, mut changed_now) = (no_tiles(&pot), no_tiles(&pot));
            if let Some(Delta { version, bytes }) = &word.delta {
                replica.apply_delta(*version, bytes, &mut news).unwrap();
            }
            let rack = unsure.rack();
            unsure.set_rack(rack);
            let again =
                unsure.handle_confirmed(&replica, word.tick, word.acknowledged, &known, &news, &mut no_tiles(&pot));
            let left = sure.handle_confirmed(&replica, word.tick, word.acknowledged, &known, &news, &mut changed_now);
            assert_eq!(left, again, "tick {tick}, of {:?}", word.tick);
            counts.confirmed += 1;
            counts.pressed_again += u32::from(!changed_now.is_empty());
            changed.add_all(&changed_now);
        }
        for (surface, _, window) in changed.iter() {
            seen.copy_window(sure.field().pot(), surface, window);
        }
        assert!(sure.field().pot() == unsure.field().pot(), "tick {tick}");
    }
    assert!(seen == *sure.field().pot());
    counts
}

#[test]
fn clay_that_nobody_else_presses_is_not_pressed_again() {
    for support in [Support::Backed, Support::Hollow] {
        let counts = run(&Course { support, ..ALONE });
        // the first time, since nothing was predicted before it
        assert!(counts.confirmed > 30 && counts.pressed_again <= 1, "{support:?}: {counts:?}");
    }
}

#[test]
fn clay_that_somebody_else_presses_far_away_is_pressed_again_while_they_do() {
    // a snapshot in which other tiles change than one's own is not what was predicted
    let counts = run(&Course { others: vec![(200, PI)], ..ALONE });
    assert!((3..10).contains(&counts.pressed_again), "{counts:?}");
}

/// A tool that went through the pot in a tick is stopped at it, and one that was put down here and is taken up there has not gone through: it
/// was drawn right through the clay when the pointer left the window on one side and came back on the other.
#[test]
fn a_tool_that_is_taken_up_elsewhere_has_not_gone_there_through_the_clay() {
    let field = Field::new(Pot::new(PotSpec::default()).unwrap(), Tick(0));
    let mut hand = Hand::new(Patch { field, conditions: Conditions::default(), rack: rack::standard() });
    // as a loop has it: on which side first, and then where it is stopped and pressed
    let stands = |hand: &mut Hand, tick: u64, x_m: f32| {
        let (tick, tool) = (Tick(tick), Tool::default());
        let asked = Position::nearest(Vec3::new(x_m, 0.001, 0.1)).unwrap();
        let side = hand.side(tick, tool, asked);
        let sample = ToolSample { tick, tool, orientation: Orientation::default(), side, centre: asked };
        let centre = hand.stopped_at_clay(&sample);
        let touched = hand.press(&ToolSample { centre, ..sample }).elements;
        (centre == asked, touched)
    };
    assert_eq!(stands(&mut hand, 1, 0.09), (true, 0));
    let (is_there, touched) = stands(&mut hand, 2, -0.09);
    assert!(!is_there && touched > 0, "it went through the pot within a tick");
    hand.put_down();
    assert_eq!(stands(&mut hand, 900, 0.09), (true, 0));
    hand.put_down();
    assert_eq!(stands(&mut hand, 902, -0.09), (true, 0), "it was taken up there");
    assert_eq!(stands(&mut hand, 903, -0.0901), (true, 0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn predicted_clay_is_what_pressing_it_again_would_give(
        is_hollow in any::<bool>(),
        rpm in -90.0_f32..90.0,
        delay in 0_u64..200,
        others in prop::collection::vec((1_u64..500, -0.6_f32..0.6), 0..3),
        stalls in prop::collection::vec((1_u64..500, 1_u64..80), 0..3),
        wetter in prop::collection::vec(1_u64..400, 0..2),
        beside in prop::collection::vec(1_u64..500, 0..2),
        rests in 1_u64..400,
        length in 0_u64..100,
        ends in 300_u64..500,
    ) {
        let support = if is_hollow { Support::Hollow } else { Support::Backed };
        run(&Course { support, rpm, delay, others, stalls, wetter, beside, rests: rests..rests + length, ends });
    }
}
