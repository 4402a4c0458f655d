//! Going back to an earlier time, and other clay on a wheel: what is remembered, and for how long.
//!
//! Invariant under test: an order is carried out at all wheels that it means or at none, and can be taken back.

use pottery_shared::clay::Form;
use pottery_shared::protocol::{NoOrder, Order, PotOf, Request};
use pottery_shared::room::PeerId;

use super::{Class, dent};

#[test]
fn going_back_is_a_step_that_can_be_taken_back_and_overwrites_nothing() {
    let mut class = Class::open();
    class.teacher(1, 2);
    class.student(2, 1);
    class.student(3, 1);
    let mut seen = vec![(class.now, class.digest(0))];
    for stroke in 0..6 {
        class.pass(250, &[(2, dent(0.04 + 0.02 * stroke as f32)), (3, [-0.069, 0.0, 0.05])]);
        class.pass(350, &[]);
        seen.push((class.now, class.digest(0)));
    }
    let last = class.digest(0);
    for &(tick, digest) in seen.iter().rev() {
        assert_eq!(class.order(1, Order::GoBack { wheel: 1, to: tick }), None);
        class.pass(1500, &[]);
        assert_eq!(class.digest(0), digest, "back to tick {tick}");
        assert!(class.holds(2, 0) && class.holds(3, 0));
        assert_eq!(class.order(1, Order::TakeBack { wheel: 1 }), None);
        class.pass(1500, &[]);
        assert_eq!(class.digest(0), last, "and the lesson goes on from where it was");
    }
    // taken back before it has come, nothing comes and nothing else is undone
    assert_eq!(class.order(1, Order::GoBack { wheel: 1, to: seen[1].0 }), None);
    assert_eq!(class.order(1, Order::TakeBack { wheel: 1 }), None);
    class.pass(1500, &[]);
    assert_eq!(class.digest(0), last);
    // what is undone stays undone at the time that is gone back to, and others press on meanwhile
    class.pass(1, &[]);
    class.line(2);
    let held = class.now + 10;
    class.ask(2, &Request::Undo { held });
    class.order(1, Order::GoBack { wheel: 1, to: class.now });
    class.pass(800, &[(3, [-0.069, 0.0, 0.1])]);
    class.pass(1500, &[]);
    assert!(class.holds(2, 0) && class.holds(3, 0) && class.digest(0) != last);
    // at a wheel that nobody is at as well
    class.room.handle_gone(PeerId(2));
    class.room.handle_gone(PeerId(3));
    class.pass(300, &[]);
    assert_eq!(class.order(1, Order::GoBack { wheel: 1, to: seen[2].0 }), None);
    class.pass(3000, &[]);
    assert!(class.digest(0) != last);
    assert_eq!(class.class(1).wheels[0].oldest, 0);
}

/// It was begun again with every step, and never done.
#[test]
fn students_who_step_back_and_forth_keep_no_teacher_from_going_back() {
    let mut class = Class::open();
    class.teacher(1, 2);
    class.student(2, 1);
    class.student(3, 1);
    class.pass(300, &[]);
    let stood = class.digest(0);
    let to = class.now;
    class.pass(2500, &[(2, dent(0.05)), (3, [-0.069, 0.0, 0.1])]);
    class.pass(300, &[]);
    assert_eq!(class.order(1, Order::GoBack { wheel: 1, to }), None);
    for round in 0..40 {
        let held = class.now;
        class.ask(2, &if round % 2 == 0 { Request::Undo { held } } else { Request::Redo { held } });
        class.pass(20, &[]);
    }
    // what was asked for meanwhile is done afterwards, on the clay that the teacher wanted
    let mut was = false;
    for _ in 0..400 {
        class.pass(10, &[]);
        was |= class.digest(0) == stood;
    }
    assert!(was, "the wheel never went back");
}

#[test]
fn a_wheel_remembers_no_farther_than_it_says() {
    let mut class = Class::open();
    class.teacher(1, 1);
    for _ in 0..2 {
        class.pass(250, &[(1, dent(0.1))]);
        class.pass(300, &[]);
        // ten minutes in one step: nobody is at the wheel meanwhile but the teacher, who holds still
        class.now += 620_000;
        class.pass(100, &[]);
    }
    class.pass(250, &[(1, dent(0.05))]);
    class.pass(600, &[]);
    let oldest = class.class(1).wheels[0].oldest;
    assert!(oldest > 0);
    assert_eq!(class.order(1, Order::GoBack { wheel: 1, to: oldest - 1 }), Some(NoOrder::TooLongAgo { oldest }));
    assert_eq!(class.order(1, Order::GoBack { wheel: 1, to: oldest }), None);
}

#[test]
fn where_one_of_all_wheels_does_not_remember_a_time_none_goes_back_to_it() {
    let mut class = Class::open();
    class.teacher(1, 2);
    class.student(2, 1);
    class.pass(250, &[(2, dent(0.1))]);
    for _ in 0..2 {
        class.pass(250, &[(1, dent(0.1))]);
        class.pass(300, &[]);
        class.now += 620_000;
        class.pass(100, &[]);
    }
    class.pass(250, &[(1, dent(0.05)), (2, dent(0.05))]);
    class.pass(600, &[]);
    let [first, second] = [0, 1].map(|wheel| class.class(1).wheels[wheel].oldest);
    assert!(first < second, "{first}, {second}");
    let stood = [0, 1, 2].map(|wheel| class.digest(wheel));
    let order = Order::GoBack { wheel: 0, to: second - 1 };
    assert_eq!(class.order(1, order), Some(NoOrder::TooLongAgo { oldest: second }));
    class.pass(1500, &[]);
    assert_eq!([0, 1, 2].map(|wheel| class.digest(wheel)), stood);
}

#[test]
fn pots_that_are_put_on_a_wheel_are_forgotten_although_nobody_presses() {
    let mut class = Class::open();
    class.teacher(1, 1);
    for number in 0..120 {
        let form = if number % 2 == 0 { Form::Bowl } else { Form::Bottle };
        let held = class.now;
        class.ask(1, &Request::NewPot { held, form: form.number() });
        class.pass(50, &[]);
        class.now += 10_000;
    }
    class.pass(100, &[]);
    let oldest = class.class(1).wheels[0].oldest;
    // ten minutes, and half as long again, since marks are the rarer the older they are
    assert!(oldest + 900_000 > class.now, "after {} ms it remembers {oldest}", class.now);
}

#[test]
fn everybody_starts_from_the_same_pot() {
    let mut class = Class::open();
    class.teacher(1, 1);
    class.student(2, 2);
    class.pass(300, &[(1, dent(0.1)), (2, dent(0.05))]);
    class.pass(100, &[]);
    assert_eq!(class.order(1, Order::Pot { wheel: 0, of: PotOf::Wheel(1) }), None);
    class.pass(100, &[]);
    assert!((0..3).all(|wheel| class.digest(wheel) == class.digest(0)), "also where nobody is");
    assert!(class.holds(1, 0) && class.holds(2, 1));
    let shown = class.digest(0);
    assert_eq!(class.order(1, Order::Pot { wheel: 0, of: PotOf::Form(Form::Bowl.number()) }), None);
    class.pass(100, &[]);
    assert!((0..3).all(|wheel| class.digest(wheel) == class.digest(0) && class.digest(0) != shown));
    // and back, at all of them
    assert_eq!(class.order(1, Order::TakeBack { wheel: 0 }), None);
    class.pass(1000, &[]);
    assert!((0..3).all(|wheel| class.digest(wheel) == shown));
}
