//! The wheel's laws: its phase is a pure function of the tick, adds up, and has no jump where the speed changes.

use glam::Vec3;
use pottery_shared::clay::{Phase, Wheel};
use pottery_shared::units::{Rpm, Tick};
use proptest::prelude::*;

/// Fewer changes than a wheel remembers.
const CHANGES: usize = 30;

/// Speed changes: ticks since the one before, and the new speed.
fn changes(count: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<(u64, f32)>> {
    prop::collection::vec((1_u64..5_000, -450.0_f32..450.0), count)
}

/// A wheel from tick 0 with the changes scheduled, and the ticks of the changes.
fn wheel(start: (u32, f32), changes: &[(u64, f32)]) -> (Wheel, Vec<Tick>) {
    let mut wheel = Wheel::starting_at(Tick(0), Phase(start.0), Wheel::rate_of(Rpm(start.1)));
    let mut at = Tick(0);
    let mut ticks = Vec::new();
    for &(after, rpm) in changes {
        at = Tick(at.0 + after);
        wheel.schedule(at, Wheel::rate_of(Rpm(rpm)));
        ticks.push(at);
    }
    (wheel, ticks)
}

fn steps(from: Phase, to: Phase) -> u32 {
    to.0.wrapping_sub(from.0)
}

proptest! {
    #[test]
    fn phase_is_the_sum_of_the_rates_tick_by_tick(start in any::<u32>(), rpm in -400.0_f32..400.0, changes in changes(1..CHANGES)) {
        let (wheel, ticks) = wheel((start, rpm), &changes);
        let end = ticks.last().unwrap().0 + 100;
        let mut sum = Phase(start);
        for tick in (0..end).map(Tick) {
            prop_assert_eq!(wheel.phase(tick), sum, "at {}", tick);
            sum = Phase(sum.0.wrapping_add_signed(wheel.rate(tick)));
        }
    }

    #[test]
    fn phase_over_two_stretches_is_the_phase_over_both(
        rpm in -400.0_f32..400.0,
        from in 0..u64::MAX / 4,
        first in 0..u64::MAX / 4,
        second in 0..u64::MAX / 4,
    ) {
        let (wheel, _) = wheel((0, rpm), &[]);
        let [begin, middle, end] = [from, from + first, from + first + second].map(|tick| wheel.phase(Tick(tick)));
        prop_assert_eq!(steps(begin, end), steps(begin, middle).wrapping_add(steps(middle, end)));
        // even turning knows no time of its own: the same stretch turns it by the same angle anywhere
        prop_assert_eq!(steps(begin, middle), steps(Phase(0), wheel.phase(Tick(first))));
    }

    #[test]
    fn asking_changes_nothing(changes in changes(0..20), asked in prop::collection::vec(any::<u64>(), 1..50)) {
        let (asked_wheel, _) = wheel((7, 33.0), &changes);
        let (silent_wheel, _) = wheel((7, 33.0), &changes);
        let before: Vec<_> = asked.iter().map(|&tick| asked_wheel.phase(Tick(tick))).collect();
        let again: Vec<_> = asked.iter().rev().map(|&tick| asked_wheel.phase(Tick(tick))).collect();
        prop_assert!(before.iter().eq(again.iter().rev()));
        prop_assert_eq!(asked_wheel, silent_wheel);
    }

    #[test]
    fn new_speed_does_not_turn_the_past(
        changes in changes(0..200),
        from in 0_u64..600_000,
        rpm in -400.0_f32..400.0,
        asked in prop::collection::vec(0_u64..600_000, 1..50),
    ) {
        let (before, _) = wheel((1 << 31, 60.0), &changes);
        let mut after = before.clone();
        after.schedule(Tick(from), Wheel::rate_of(Rpm(rpm)));
        for tick in asked.into_iter().map(|tick| Tick(tick.min(from))) {
            prop_assert_eq!(after.phase(tick), before.phase(tick), "at {}", tick);
        }
        prop_assert_eq!(after.rate(Tick(from)), Wheel::rate_of(Rpm(rpm)));
        prop_assert_eq!(after.rate(Tick(u64::MAX)), Wheel::rate_of(Rpm(rpm)), "later changes are dropped");
    }

    #[test]
    fn phase_has_no_jump_where_the_speed_changes(changes in changes(1..CHANGES)) {
        let (wheel, ticks) = wheel((0, 60.0), &changes);
        for tick in ticks {
            let before = tick.offset(-1);
            prop_assert_eq!(steps(wheel.phase(before), wheel.phase(tick)) as i32, wheel.rate(before));
            prop_assert_eq!(steps(wheel.phase(tick), wheel.phase(tick.next())) as i32, wheel.rate(tick));
        }
    }

    #[test]
    fn speed_is_what_was_asked_for_within_the_limit(rpm in -1_000.0_f32..1_000.0) {
        let (wheel, _) = wheel((0, rpm), &[]);
        let limited = rpm.clamp(-Wheel::RPM_MAX.0, Wheel::RPM_MAX.0);
        // half a phase step a tick is 7e-6 rpm; an f32 resolves 3e-5 at 400
        prop_assert!((wheel.speed(Tick(0)).0 - limited).abs() < 4e-5, "{} for {rpm}", wheel.speed(Tick(0)).0);
    }

    #[test]
    fn wheel_holds_a_bounded_number_of_changes(changes in changes(0..600)) {
        let (wheel, ticks) = wheel((0, 60.0), &changes);
        let held: Vec<_> = wheel.segments().collect();
        prop_assert!((1..=ticks.len() + 1).contains(&held.len()));
        prop_assert!(held.len() <= HELD_MAX, "{} changes held", held.len());
        prop_assert!(held.is_sorted_by(|one, next| one.0 < next.0));
        if let Some(&last) = ticks.last() {
            prop_assert_eq!(held.last().unwrap().0, last);
        }
    }

    #[test]
    fn forgotten_changes_leave_what_is_remembered_as_it_was(changes in changes(300..400)) {
        let (mut wheel, _) = wheel((0, 60.0), &[]);
        let mut at = Tick(0);
        for (after, rpm) in changes {
            let before = wheel.clone();
            at = Tick(at.0 + after);
            wheel.schedule(at, Wheel::rate_of(Rpm(rpm)));
            for (from, phase, _) in wheel.segments() {
                prop_assert_eq!(before.phase(from), phase);
            }
        }
    }

    #[test]
    fn room_and_pot_are_each_others_inverse(phase in any::<u32>(), point in prop::array::uniform3(-1.0_f32..1.0)) {
        let point = Vec3::from_array(point);
        let phase = Phase(phase);
        // two roundings to f32 of coordinates up to 1.5 m: 2 × 0.06 µm an axis
        prop_assert!(phase.room_from_pot(phase.pot_from_room(point)).distance(point) < 1e-6);
        prop_assert!(phase.pot_from_room(phase.room_from_pot(point)).distance(point) < 1e-6);
        prop_assert!((phase.pot_from_room(point).length() - point.length()).abs() < 1e-6);
        prop_assert_eq!(phase.pot_from_room(point).z, point.z);
    }
}

/// Changes that a wheel may hold: 20 a second over the ten seconds for which samples are taken, and some.
const HELD_MAX: usize = 256;

#[test]
fn standing_wheel_turns_nothing() {
    let (wheel, _) = wheel((42, 0.0), &[]);
    assert_eq!(wheel.phase(Tick(u64::MAX)), Phase(42));
    let point = Vec3::new(0.06, -0.02, 0.1);
    assert_eq!(Phase(0).pot_from_room(point), point);
}

#[test]
fn phase_wraps_after_a_turn() {
    // 2³² / 60,000 is no whole number: after one minute at 1 rpm the rounded rate is off by at most half a step a tick
    let (wheel, _) = wheel((0, 1.0), &[]);
    let after_a_minute = wheel.phase(Tick(60_000)).0 as i32;
    assert!(after_a_minute.abs() <= 30_000, "{after_a_minute} steps");
    let top = Wheel::starting_at(Tick(0), Phase(u32::MAX), 1);
    assert_eq!(top.phase(Tick(1)), Phase(0));
    assert!(Phase(u32::MAX).radians() < std::f64::consts::TAU);
}

#[test]
fn quarter_turn_carries_x_to_y() {
    // the pot's x axis, a quarter of a turn later, points along the room's y
    let quarter = Phase(1 << 30);
    let seen = quarter.room_from_pot(Vec3::X);
    assert!(seen.distance(Vec3::Y) < 1e-7, "{seen}");
    let on_pot = quarter.pot_from_room(Vec3::Y);
    assert!(on_pot.distance(Vec3::X) < 1e-7, "{on_pot}");
}

#[test]
fn speed_that_is_no_number_stands_still_and_an_endless_one_is_limited() {
    assert_eq!(Wheel::rate_of(Rpm(f32::NAN)), 0);
    assert_eq!(Wheel::rate_of(Rpm(f32::INFINITY)), Wheel::rate_of(Wheel::RPM_MAX));
    assert_eq!(Wheel::rate_of(Rpm(f32::NEG_INFINITY)), -Wheel::rate_of(Wheel::RPM_MAX));
}
