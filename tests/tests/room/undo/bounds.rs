//! How much a wheel remembers, and for how long: also while people step back and forth without end, and where nobody is.
//!
//! Invariant under test: history is bounded in age and bytes, whatever is asked for.

use pottery_shared::clay::{Form, MethodKind};
use pottery_shared::room::PeerId;

use super::{World, band};

#[test]
fn history_is_bounded_in_age_and_bytes() {
    let mut world = World::new(MethodKind::Improved, (48, 40), 0.0, 7);
    world.come(0);
    // three tenths of a second in every five, for thirteen minutes
    let hand = |person: u64, now: u64| (now > 300 && now % 5000 < 300).then(|| band(person, now, now / 90_000));
    let mut most = 0;
    while world.now < 780_000 {
        world.step(hand);
        world.entries.clear();
        most = most.max(world.room.counts().history_bytes);
    }
    let steps = *world.potter(0).steps();
    // ten minutes are 120 strokes; marks thin out backwards, and the oldest lies up to half as far beyond
    assert!((120..=156).contains(&steps.back), "{steps:?}");
    assert!(most < 1 << 20, "{most} bytes");
    println!("{} strokes in {} bytes, at most {most}", steps.back, world.room.counts().history_bytes);
}

#[test]
fn steps_without_end_and_new_pots_beside_them_let_no_history_grow() {
    let mut world = World::new(MethodKind::Plastic, (96, 80), 0.0, 7);
    world.come(0);
    world.come(1);
    world.run(500, |_, _| None);
    // a stroke that takes some seconds to be made again
    world.run(8000, |person, now| (person == 0).then(|| band(0, now, now / 200)));
    let before = world.room.counts().history_bytes;
    let (mut most, mut puts) = (0, 0);
    for round in 0..400_u32 {
        // undone and redone again and again, and a pot of another form five times a second
        if round % 2 == 0 {
            world.potter(0).undo()
        } else {
            world.potter(0).redo()
        }
        for form in [Form::Bowl, Form::Bottle] {
            world.potter(1).begin_anew(Some(form));
            puts += 1;
            let to = world.now + 200;
            world.run(to, |_, _| None);
            most = most.max(world.room.counts().history_bytes);
        }
    }
    let remade = world.room.counts().remade;
    println!("{before} bytes before, {most} at most, {puts} pots asked for, {remade} samples made again");
    // all pots that were asked for take thirty kilobytes each
    assert!(remade > 100_000 && most < 4 << 20, "{before} bytes before, {most} at most, {remade} samples made again");
    let to = world.now + 30_000;
    world.run(to, |_, _| None);
    world.assert_settled("at last");
}

#[test]
fn a_wheel_that_nobody_is_at_forgets_what_was_pressed_there() {
    for leaves_at in [1_100, 4_000] {
        let mut world = World::new(MethodKind::Plastic, (48, 40), 0.0, 7);
        world.come(0);
        world.run(500, |_, _| None);
        // one goes with the tool in the clay
        world.run(leaves_at, |_, now| (now < 1_100).then(|| band(0, now, 0)));
        world.room.handle_gone(PeerId(0));
        let pressed = world.room.counts().history_bytes;
        (world.people, world.parcels) = Default::default();
        world.now += 620_000;
        world.run(world.now + 1, |_, _| None);
        let left = world.room.counts().history_bytes;
        println!("left at {leaves_at} ms: {pressed} bytes, {left} after ten minutes");
        // the newest clay alone
        assert!(left < pressed, "left at {leaves_at} ms: {left} bytes of {pressed}");
        assert!(world.room.lesson().wheels[0].oldest >= 1_100, "what was pressed is known still");
    }
}
