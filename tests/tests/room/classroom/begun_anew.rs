//! A server that was killed and begun anew: what its class register brings back, and what it does not.
//!
//! Invariant under test: people, doors and wheels are as they were, and a register that is no such thing changes nothing.

use pottery_shared::protocol::{Hello, Notice, Order, Pass, Presence, Purpose, Refusal, Request, Role};
use pottery_shared::room::{DoorConfig, PeerId, Register};

use super::{Class, TOKEN, doors, works};

/// What a class's room leaves, written and read.
fn left(class: &Class) -> Register {
    let register = class.room.register();
    let read = Register::from_bytes(&register.to_bytes()).unwrap();
    assert_eq!(read, register);
    read
}

/// A class in the room of the next server, whose secret is another one.
fn anew(register: Register) -> Class {
    let mut class = Class::with(DoorConfig { secret: Some([8; 32]), ..doors() });
    class.room.go_on_from(register, None);
    class
}

#[test]
fn people_come_back_with_name_number_role_and_wheel_to_doors_and_wheels_as_they_were() {
    let mut class = Class::open();
    let teacher = class.teacher(1, 1);
    let student = class.student(2, 2);
    class.student(3, 3);
    let guest = Hello { purpose: Purpose::Watches { bytes_per_s: 9000 }, ..works(1, Pass::None) };
    assert!(matches!(class.greet(4, &guest), Some(Notice::Audience(_))));
    let gone = class.student(5, 1);
    class.room.handle_gone(PeerId(5));
    assert_eq!(class.order(1, Order::Seat { client: student.client, wheel: 3, works: true }), None);
    for order in [
        Order::Freeze { wheel: 3, is_frozen: true },
        Order::Open { wheel: 2, is_open: false },
        Order::NewCode,
        Order::Lock { is_locked: true },
    ] {
        assert_eq!(class.order(1, order), None);
    }
    // somebody who left for good is not in it, somebody whose connection broke is
    class.ask(3, &Request::Leave);
    let register = left(&class);
    assert_eq!((register.people(), register.code()), (4, class.room.code()));
    let tokens = [1, 2, 4, 5].map(|peer| class.line(peer).resume.unwrap());
    let bytes = register.to_bytes();
    assert!(tokens.iter().all(|token| !bytes.windows(16).any(|window| window == token.0)), "a token lies in the file");

    let mut after = anew(register);
    assert_eq!(after.room.people(), 0, "nobody has a connection yet");
    let away = after.room.everybody();
    assert!(away.len() == 4 && away.iter().all(|person| person.presence == Presence::Away), "{away:?}");
    let wheels = after.room.lesson().wheels;
    let stand: Vec<_> = wheels.iter().map(|wheel| (wheel.is_open, wheel.is_frozen)).collect();
    assert_eq!(stand, [(true, false), (false, false), (true, true)]);
    assert!(after.room.lesson().is_locked);

    let back = |at: usize| Pass::Resume(tokens[at]);
    assert!(matches!(after.greet(1, &works(1, Pass::Return(tokens[0], TOKEN))), Some(Notice::Welcome(_))));
    assert!(matches!(after.greet(2, &works(1, back(1))), Some(Notice::Welcome(_))));
    assert!(matches!(after.greet(5, &works(1, back(3))), Some(Notice::Welcome(_))));
    let [taught, worked, broken] = [1, 2, 5].map(|peer| after.place(peer));
    assert_eq!((taught.client, taught.name, taught.role), (teacher.client, teacher.name, Role::Teacher));
    assert_eq!((worked.client, worked.name, worked.wheel), (student.client, student.name, 3));
    assert!(!worked.may_press && taught.may_press, "the student's wheel is frozen as it was");
    assert_eq!((broken.client, broken.name, broken.wheel), (gone.client, gone.name, 1));
    let guest = Hello { pass: back(2), ..guest };
    assert!(matches!(after.greet(4, &guest), Some(Notice::Audience(_))));
    // the code of before is known for what it is, and a guess for a guess
    assert_eq!(
        after.greet(6, &works(1, Pass::None)),
        Some(Notice::Refused(Refusal::Locked)),
        "the room's code is its own"
    );
    assert_eq!(after.order(1, Order::Lock { is_locked: false }), None);
    let newcomer = after.student(7, 1);
    let taken = [teacher, student, gone].map(|place| (place.client, place.name));
    assert!(taken.iter().all(|(client, name)| *client != newcomer.client && *name != newcomer.name), "{newcomer:?}");
}

#[test]
fn who_does_not_come_back_within_ten_minutes_is_forgotten_and_a_lobby_that_was_asked_for_stays() {
    let mut class = Class::open();
    class.student(2, 2);
    let token = class.line(2).resume.unwrap();
    let mut after = Class::with(DoorConfig { has_lobby: true, secret: Some([8; 32]), ..doors() });
    after.room.go_on_from(left(&class), None);
    assert!(after.room.lesson().has_lobby);
    after.now = 600_500;
    after.pass(1, &[]);
    assert!(after.room.everybody().is_empty());
    assert_eq!(after.greet(2, &works(2, Pass::Resume(token))), Some(Notice::Waiting), "a stranger like others");
}

#[test]
fn a_code_that_goes_on_expires_when_it_would_have_and_an_older_one_is_told_from_a_guess() {
    let mut class = Class::open();
    class.teacher(1, 1);
    assert_eq!(class.order(1, Order::NewCode), None);
    let mut after = Class::with(DoorConfig { code_ticks: Some(50_000), secret: Some([8; 32]), ..doors() });
    // this room has the first code again, and the one that took its place is one of those before
    let between = class.room.code().to_owned();
    after.room.go_on_from(left(&class), Some(1000));
    let with = |code: &str| Hello { code: code.into(), ..works(1, Pass::None) };
    assert_eq!(after.greet(2, &with(&between)), Some(Notice::Refused(Refusal::CodeGone)));
    assert_eq!(after.greet(3, &with("00000000")), Some(Notice::Refused(Refusal::Code)));
    after.student(4, 1);
    after.pass(1000, &[]);
    assert_eq!(after.greet(5, &works(1, Pass::None)), Some(Notice::Refused(Refusal::CodeGone)));
}

#[test]
fn teachers_are_struck_out_where_the_token_is_new_and_bytes_that_are_no_register_are_none() {
    let mut class = Class::open();
    class.teacher(1, 1);
    class.student(2, 3);
    let [teachers, students] = [1, 2].map(|peer| class.line(peer).resume.unwrap());
    let mut register = left(&class);
    register.strike_teachers();
    assert_eq!(register.people(), 1);
    let mut after = anew(register.clone());
    after.greet(1, &works(1, Pass::Resume(teachers)));
    assert_eq!(after.place(1).role, Role::Student);
    after.greet(2, &works(1, Pass::Resume(students)));
    assert_eq!(after.place(2).wheel, 3);

    let bytes = register.to_bytes();
    assert!((0..bytes.len()).all(|length| Register::from_bytes(&bytes[..length]).is_none()));
    assert!(Register::from_bytes(&[&bytes[..], &[0]].concat()).is_none());
    // of a server with more wheels: who sat where there is none now is left out
    let mut small = Class::with_wheels(2, doors());
    small.room.go_on_from(register, None);
    assert!(small.room.everybody().is_empty());
}
