//! A lesson: who may do what, who comes in with what, and what a teacher orders.
//!
//! A room and its people joined in one process without a wire between them; time is the test's.
//! Invariant under test: what a role may not do changes nothing, and whoever comes back finds their own seat.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod begun_anew;
mod going_back;

use std::collections::BTreeMap;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{GridShape, Material, MethodKind, PotSpec};
use pottery_shared::protocol::{
    self, CONTROL_MAX, ClassWire, ClayWire, DetailWire, FrameReader, GuidanceWire, Hello, MeshWire, NoOrder, Notice,
    Order, Pass, PersonWire, PlaceWire, PotOf, Presence, Purpose, Refusal, Request, ResumeToken, Role, SightName,
    TeacherToken,
};
use pottery_shared::room::{DoorConfig, Lane, PeerId, Room, RoomConfig, may, may_press, token_hash};
use pottery_shared::session::{Client, greeting};
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};

const CODE: &str = "K7QM3XPD";
const TOKEN: TeacherToken = TeacherToken([0x5a; 32]);

/// Somebody's connection, and what was said on it.
#[derive(Default)]
struct Line {
    client: Option<Client>,
    notices: Vec<Notice>,
    is_closed: bool,
    resume: Option<ResumeToken>,
}

struct Class {
    room: Room,
    lines: BTreeMap<PeerId, Line>,
    now: u64,
}

fn doors() -> DoorConfig {
    DoorConfig { secret: Some([7; 32]), teacher: Some(token_hash(&TOKEN.0)), code_ticks: None, has_lobby: false }
}

fn works(wheel: u16, pass: Pass) -> Hello {
    Hello { code: CODE.into(), wheel, purpose: Purpose::Works { retells: true }, pass }
}

fn sample(tick: u64, at_m: [f32; 3]) -> ToolSample {
    ToolSample {
        tick: Tick(tick),
        tool: Tool::default(),
        orientation: Orientation::default(),
        side: Side::Outside,
        centre: Position::nearest(Vec3::from(at_m)).unwrap(),
    }
}

impl Class {
    fn with(doors: DoorConfig) -> Self {
        Self::with_wheels(3, doors)
    }

    fn with_wheels(wheels: u16, doors: DoorConfig) -> Self {
        let config = RoomConfig {
            code: CODE.into(),
            wheels,
            people_max: 12,
            pot: PotSpec { shape: GridShape::new(90, 100).unwrap(), ..PotSpec::default() },
            method: MethodKind::Plastic,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        };
        let mut room = Room::new(config).unwrap();
        room.keep_doors(doors);
        Self { room, lines: BTreeMap::new(), now: 0 }
    }

    fn open() -> Self {
        Self::with(doors())
    }

    /// Somebody greets; returns what they are told first.
    fn greet(&mut self, peer: u64, hello: &Hello) -> Option<Notice> {
        self.lines.insert(PeerId(peer), Line::default());
        self.room.handle_control(PeerId(peer), &bare(&greeting(hello)));
        self.listen();
        self.line(peer).notices.first().cloned()
    }

    fn student(&mut self, peer: u64, wheel: u16) -> PlaceWire {
        let said = self.greet(peer, &works(wheel, Pass::None));
        assert!(matches!(said, Some(Notice::Welcome(_))), "{said:?}");
        self.place(peer)
    }

    fn teacher(&mut self, peer: u64, wheel: u16) -> PlaceWire {
        let said = self.greet(peer, &Hello { code: String::new(), ..works(wheel, Pass::Teacher(TOKEN)) });
        assert!(matches!(said, Some(Notice::Welcome(_))), "{said:?}");
        self.place(peer)
    }

    fn line(&self, peer: u64) -> &Line {
        &self.lines[&PeerId(peer)]
    }

    fn place(&self, peer: u64) -> PlaceWire {
        let places = self.line(peer).notices.iter().rev();
        places.filter_map(|said| if let Notice::Place(place) = said { Some(*place) } else { None }).next().unwrap()
    }

    /// What somebody was told last of the lesson.
    fn class(&self, peer: u64) -> ClassWire {
        self.line(peer).client.as_ref().unwrap().class().class().unwrap().clone()
    }

    fn people(&self, peer: u64) -> Vec<PersonWire> {
        self.line(peer).client.as_ref().unwrap().class().people().copied().collect()
    }

    fn ask(&mut self, peer: u64, request: &Request) {
        self.room.handle_control(PeerId(peer), &protocol::encode(request));
        self.listen();
    }

    /// Orders; returns why not.
    fn order(&mut self, peer: u64, order: Order) -> Option<NoOrder> {
        let before = self.line(peer).notices.len();
        self.ask(peer, &Request::Order(order));
        self.line(peer).notices[before..].iter().find_map(|said| match said {
            Notice::NoOrder(reason) => Some(*reason),
            _ => None,
        })
    }

    fn listen(&mut self) {
        while let Some(transmit) = self.room.poll_transmit() {
            let line = self.lines.entry(transmit.to).or_default();
            let time = Duration::from_millis(self.now);
            match transmit.lane {
                Lane::Control(framed) => {
                    let frame = bare(&framed);
                    let notice: Notice = protocol::decode::<CONTROL_MAX, _>(&frame).unwrap();
                    match (&notice, &mut line.client) {
                        (Notice::Welcome(_), _) => {
                            line.client = Some(Client::open(&frame, self.now, Duration::ZERO).unwrap());
                        }
                        (Notice::Refused(_), _) => {}
                        (_, Some(client)) => client.handle_control(&frame).unwrap(),
                        _ => {}
                    }
                    if let Notice::Place(place) = &notice {
                        line.resume = place.resume.or(line.resume);
                    }
                    line.notices.push(notice);
                }
                Lane::Datagram(bytes) => {
                    if let Some(client) = &mut line.client {
                        assert!(client.handle_datagram(&bytes, time));
                        client.rebase();
                    }
                }
                Lane::Keyframe(bytes) => {
                    if let Some(client) = &mut line.client {
                        assert!(client.handle_keyframe(&bytes, time));
                        client.rebase();
                    }
                }
                Lane::Close => line.is_closed = true,
            }
        }
    }

    /// Lets milliseconds pass, in each of which these people hold their tools somewhere.
    fn pass(&mut self, ticks: u64, hands: &[(u64, [f32; 3])]) {
        for _ in 0..ticks {
            self.now += 1;
            for (peer, at_m) in hands {
                let line = self.lines.get_mut(&PeerId(*peer)).unwrap();
                if let Some(client) = line.client.as_mut().filter(|_| !line.is_closed) {
                    client.handle_sample(sample(self.now + 5, *at_m));
                }
            }
            let time = Duration::from_millis(self.now);
            for (&peer, line) in &mut self.lines {
                while let Some(client) = line.client.as_mut().filter(|_| !line.is_closed) {
                    let Some(frame) = client.poll_control() else { break };
                    self.room.handle_control(peer, &bare(&frame));
                }
                if self.now.is_multiple_of(10) {
                    while let Some(bytes) = line.client.as_mut().and_then(|client| client.poll_datagram(time)) {
                        self.room.handle_datagram(peer, &bytes);
                    }
                }
            }
            self.room.advance(Tick(self.now));
            self.listen();
        }
    }

    fn digest(&self, wheel: usize) -> u64 {
        self.room.digest(wheel).unwrap()
    }

    fn holds(&self, peer: u64, wheel: usize) -> bool {
        self.line(peer).client.as_ref().unwrap().replica().digest() == self.digest(wheel)
    }
}

fn bare(framed: &[u8]) -> Vec<u8> {
    let mut reader = FrameReader::default();
    reader.push(framed);
    reader.next_frame().unwrap().unwrap()
}

/// A dent on one side, 3 mm deep, at a height.
const fn dent(z_m: f32) -> [f32; 3] {
    [0.069, 0.0, z_m]
}

const SIGHT: SightName = SightName { wheel: 1, detail: DetailWire::Spectator };

/// Every request that there is, with whether teacher, student and guest may make it.
fn table() -> Vec<(Request, [bool; 3])> {
    let clay = ClayWire { viscosity_s: 0.12, youngs_pa: 2e6, yield_pa: 4e4 };
    let mesh = MeshWire { corners_m: Vec::new(), facets: Vec::new() };
    let (all, working, teaching) = ([true; 3], [true, true, false], [true, false, false]);
    let mut table = vec![
        (Request::WheelSpeed { rpm: 1.0 }, working),
        (Request::Clay { clay }, working),
        (Request::Tool { mesh }, working),
        (Request::Again { have: 1 }, working),
        (Request::Resync { have: 1 }, working),
        (Request::Watch { sight: SIGHT, have: 0 }, all),
        (Request::Unwatch { sight: SIGHT }, all),
        (Request::Retell { retells: true }, working),
        (Request::Leave, all),
        (Request::Mend { have: 1, tiles: Vec::new() }, working),
        (Request::Undo { held: 0 }, working),
        (Request::Redo { held: 0 }, working),
        (Request::NewPot { held: 0, form: 0 }, working),
        (Request::Pot { held: 0, piece: 0, bytes: Vec::new() }, working),
        (Request::MendSight { sight: SIGHT, have: 1, tiles: Vec::new() }, all),
        (Request::Guide { student: 2, guidance: GuidanceWire { mode: 0, strength: 50 } }, teaching),
        (Request::EndGuidance, working),
        (Request::Target(None), teaching),
    ];
    for order in orders() {
        table.push((Request::Order(order), teaching));
    }
    table
}

/// Every order that there is.
fn orders() -> Vec<Order> {
    let clay = ClayWire { viscosity_s: 0.12, youngs_pa: 2e6, yield_pa: 4e4 };
    vec![
        Order::Freeze { wheel: 1, is_frozen: true },
        Order::Open { wheel: 1, is_open: false },
        Order::WheelSpeed { wheel: 1, rpm: 200.0 },
        Order::Clay { wheel: 1, clay },
        Order::Seat { client: 2, wheel: 2, works: false },
        Order::Pot { wheel: 0, of: PotOf::Form(2) },
        Order::GoBack { wheel: 1, to: 0 },
        Order::TakeBack { wheel: 1 },
        Order::Lock { is_locked: true },
        Order::NewCode,
        Order::Lobby { is_on: true },
        Order::Admit { client: 0, is_admitted: true },
        Order::End,
    ]
}

#[test]
fn table_of_rights_holds_for_every_role_and_request() {
    // the choice of a message is its first byte: none of them is left out here
    let numbers = |bytes: Vec<Vec<u8>>, at: usize| bytes.into_iter().map(|bytes| bytes[at]).collect::<Vec<_>>();
    let mut requests = numbers(table().iter().map(|(request, _)| protocol::encode(request)).collect(), 0);
    requests.sort_unstable();
    requests.dedup();
    assert_eq!(requests, (0..=18).collect::<Vec<_>>());
    assert_eq!(numbers(orders().iter().map(protocol::encode).collect(), 0), (0..=12).collect::<Vec<_>>());
    for (request, allowed) in table() {
        for (role, allowed) in Role::ALL.into_iter().zip(allowed) {
            assert_eq!(may(role, &request), allowed, "{} {request:?}", role.name());
        }
    }
    assert_eq!(Role::ALL.map(may_press), [true, true, false]);
}

#[test]
fn forged_orders_change_nothing_and_are_told() {
    let mut class = Class::open();
    class.student(1, 1);
    class.student(2, 1);
    let guest = Hello { purpose: Purpose::Watches { bytes_per_s: 10_000 }, ..works(1, Pass::None) };
    assert!(matches!(class.greet(3, &guest), Some(Notice::Audience(_))));
    assert_eq!(class.place(3).role, Role::Guest);
    class.pass(300, &[]);
    let (digests, people): (Vec<_>, Vec<_>) =
        ((0..3).map(|wheel| class.digest(wheel)).collect(), class.room.everybody());
    for peer in [1, 3] {
        for order in orders() {
            assert_eq!(class.order(peer, order), Some(NoOrder::NotTeacher), "{order:?}");
        }
    }
    class.pass(600, &[]);
    assert_eq!((0..3).map(|wheel| class.digest(wheel)).collect::<Vec<_>>(), digests);
    assert_eq!(class.room.everybody(), people);
    assert_eq!((class.room.code(), class.room.counts().forbidden), (CODE, 26));
    assert_eq!(class.room.conditions(0).unwrap().wheel.speed(Tick(class.now)).0.round(), 60.0);
    // what a guest asks of a wheel does nothing either
    class.ask(3, &Request::WheelSpeed { rpm: 200.0 });
    assert_eq!(class.room.counts().forbidden, 27);
    // nobody who was not let in orders anything
    class.room.handle_control(PeerId(9), &protocol::encode(&Request::Order(Order::End)));
    class.listen();
    assert!(class.line(9).is_closed && !class.line(1).is_closed);
}

#[test]
fn a_teachers_token_of_another_room_is_refused_and_counted_as_a_guess() {
    let mut class = Class::open();
    let foreign = Pass::Teacher(TeacherToken([0x5b; 32]));
    assert_eq!(class.greet(1, &works(1, foreign)), Some(Notice::Refused(Refusal::Token)));
    assert_eq!(class.room.poll_wrong_code(), Some(PeerId(1)));
    assert_eq!(class.teacher(2, 1).role, Role::Teacher);
    assert_eq!(class.room.poll_wrong_code(), None);
    // where nobody teaches, no token does
    let mut class = Class::with(DoorConfig { teacher: None, ..doors() });
    assert_eq!(class.greet(1, &works(1, Pass::Teacher(TOKEN))), Some(Notice::Refused(Refusal::Token)));
    // the token reads back as it is shown, and nothing shows it by mistake
    assert_eq!(TOKEN.to_string().parse(), Ok(TOKEN));
    assert_eq!(TOKEN.to_string().to_lowercase().replace('-', "").parse(), Ok(TOKEN));
    assert!(!format!("{:?}", works(1, Pass::Teacher(TOKEN))).contains("5a"));
    assert!("K7QM".parse::<TeacherToken>().is_err() && "Z".repeat(52).parse::<TeacherToken>().is_err());
}

#[test]
fn of_two_teachers_the_last_word_holds_and_both_are_told() {
    let mut class = Class::open();
    class.teacher(1, 1);
    class.teacher(2, 2);
    class.student(3, 1);
    for (teacher, is_frozen) in [(1, true), (2, false), (1, true)] {
        assert_eq!(class.order(teacher, Order::Freeze { wheel: 1, is_frozen }), None);
        assert_eq!(class.place(3).may_press, !is_frozen);
    }
    class.pass(300, &[]);
    for teacher in [1, 2] {
        assert!(class.class(teacher).wheels[0].is_frozen && !class.class(teacher).wheels[1].is_frozen);
        assert_eq!(class.people(teacher).len(), 3);
    }
    assert!(class.line(3).client.as_ref().unwrap().class().class().is_none(), "the code is for teachers");
}

#[test]
fn wrong_old_expired_and_locked_codes_are_told_apart_and_only_guesses_are_counted() {
    let mut class = Class::with(DoorConfig { code_ticks: Some(5_000), ..doors() });
    class.teacher(1, 1);
    let with = |code: &str| Hello { code: code.into(), ..works(1, Pass::None) };
    assert_eq!(class.greet(2, &with("00000000")), Some(Notice::Refused(Refusal::Code)));
    assert_eq!(class.room.poll_wrong_code(), Some(PeerId(2)));
    class.student(3, 1);
    assert_eq!(class.order(1, Order::Lock { is_locked: true }), None);
    assert_eq!(class.greet(4, &with(CODE)), Some(Notice::Refused(Refusal::Locked)));
    assert_eq!(class.order(1, Order::Lock { is_locked: false }), None);
    assert_eq!(class.order(1, Order::NewCode), None);
    assert_eq!(class.greet(5, &with(CODE)), Some(Notice::Refused(Refusal::CodeGone)));
    class.pass(300, &[]);
    let new = class.class(1).code;
    assert!(new != CODE && new.len() == 8 && new.parse::<protocol::JoinCode>().is_ok(), "{new}");
    assert!(matches!(class.greet(6, &with(&new)), Some(Notice::Welcome(_))));
    class.pass(5_000, &[]);
    assert_eq!(class.greet(7, &with(&new)), Some(Notice::Refused(Refusal::CodeGone)));
    // who is in stays in, a teacher comes in whatever the door, and the next code is good again
    assert!(!class.line(3).is_closed && !class.line(6).is_closed);
    class.teacher(8, 1);
    assert_eq!(class.order(8, Order::NewCode), None);
    class.pass(300, &[]);
    let newest = class.class(8).code;
    assert!(matches!(class.greet(9, &with(&newest)), Some(Notice::Welcome(_))));
    assert_eq!(class.room.poll_wrong_code(), None);
}

#[test]
fn a_teacher_who_comes_back_teaches_also_where_the_server_has_begun_anew() {
    let mut class = Class::open();
    let before = class.teacher(1, 1);
    let token = class.line(1).resume.unwrap();
    class.student(2, 2);
    class.room.handle_gone(PeerId(1));
    assert!(matches!(class.greet(3, &works(1, Pass::Return(token, TOKEN))), Some(Notice::Welcome(_))));
    class.pass(100, &[]);
    assert_eq!(class.place(3), PlaceWire { resume: None, ..before });

    // another server, which knows neither of them
    let mut anew = Class::open();
    assert!(matches!(anew.greet(1, &works(1, Pass::Return(token, TOKEN))), Some(Notice::Welcome(_))));
    anew.pass(100, &[]);
    assert_eq!(anew.place(1).role, Role::Teacher);
    // what is no teacher's token there is as nothing
    let foreign = Pass::Return(ResumeToken([0; 16]), TeacherToken([0x5b; 32]));
    assert!(matches!(anew.greet(2, &works(2, foreign)), Some(Notice::Welcome(_))));
    anew.pass(100, &[]);
    assert_eq!(anew.place(2).role, Role::Student);
}

#[test]
fn whoever_comes_back_finds_seat_name_number_and_pot_whatever_the_door() {
    let mut class = Class::open();
    class.teacher(1, 1);
    let before = class.student(2, 2);
    assert_eq!((before.role, before.wheel, before.may_press), (Role::Student, 2, true));
    let token = class.line(2).resume.unwrap();
    class.pass(400, &[(2, dent(0.1))]);
    assert_eq!(class.order(1, Order::Lock { is_locked: true }), None);
    class.order(1, Order::NewCode);
    // the line is dead and the server does not know it yet
    let said = class.greet(3, &works(1, Pass::Resume(token)));
    assert!(matches!(said, Some(Notice::Welcome(_))), "{said:?}");
    assert_eq!(class.place(3), PlaceWire { resume: None, ..before });
    assert!(class.line(2).is_closed && class.room.people() == 2);
    class.pass(100, &[]);
    assert!(class.holds(3, 1), "the pot is there within a tenth of a second");
    // and when the server has noticed
    class.pass(200, &[(3, dent(0.1))]);
    class.room.handle_gone(PeerId(3));
    class.pass(300, &[]);
    let away = class.people(1).into_iter().find(|person| person.client == before.client).unwrap();
    assert_eq!((away.presence, away.wheel), (Presence::Away, 2));
    assert!(matches!(class.greet(4, &works(1, Pass::Resume(token))), Some(Notice::Welcome(_))));
    class.pass(100, &[]);
    assert_eq!(class.place(4), PlaceWire { resume: None, ..before });
    // what it pressed before can still be undone
    let steps = *class.line(4).client.as_ref().unwrap().steps();
    assert_eq!(steps.back, 1);
    // who says goodbye is forgotten, and a token that is not known is as none
    class.ask(4, &Request::Leave);
    assert_eq!(class.greet(5, &works(1, Pass::Resume(token))), Some(Notice::Refused(Refusal::CodeGone)));
    let other = class.room.everybody().len();
    class.pass(300, &[]);
    assert_eq!((other, class.people(1).len()), (1, 1));
}

#[test]
fn who_comes_back_for_something_else_may_do_no_more_than_before() {
    let mut class = Class::open();
    class.teacher(1, 1);
    let student = class.student(2, 2);
    let [taught, worked] = [1, 2].map(|peer| class.line(peer).resume.unwrap());
    assert_eq!(class.order(1, Order::Seat { client: student.client, wheel: 2, works: false }), None);
    let watches = |pass| Hello { purpose: Purpose::Watches { bytes_per_s: 9000 }, ..works(1, pass) };
    assert!(matches!(class.greet(3, &watches(Pass::Resume(worked))), Some(Notice::Audience(_))));
    assert!(matches!(class.greet(4, &works(2, Pass::Resume(worked))), Some(Notice::Welcome(_))));
    assert!(!class.place(4).may_press, "it was made to look on");
    // a teacher is one also after having looked on
    assert!(matches!(class.greet(5, &watches(Pass::Resume(taught))), Some(Notice::Audience(_))));
    assert!(matches!(class.greet(6, &works(3, Pass::Resume(taught))), Some(Notice::Welcome(_))));
    assert!(class.place(6).may_press && class.place(6).role == Role::Teacher);
    // a guest comes to work as anybody does: with the code, through an open door
    assert!(matches!(class.greet(7, &watches(Pass::None)), Some(Notice::Audience(_))));
    let guest = class.line(7).resume.unwrap();
    class.order(6, Order::Lock { is_locked: true });
    assert_eq!(class.greet(8, &works(1, Pass::Resume(guest))), Some(Notice::Refused(Refusal::Locked)));
    class.order(6, Order::Lock { is_locked: false });
    assert!(matches!(class.greet(9, &works(1, Pass::Resume(guest))), Some(Notice::Welcome(_))));
    assert!(class.place(9).role == Role::Student && class.place(9).may_press);
}

#[test]
fn nobody_is_expected_for_ever() {
    let mut class = Class::open();
    class.student(1, 1);
    let token = class.line(1).resume.unwrap();
    class.room.handle_gone(PeerId(1));
    class.now = 600_500;
    class.pass(1, &[]);
    assert_eq!(class.room.everybody().len(), 0);
    // the code is good, so that it comes in as somebody new
    assert!(matches!(class.greet(2, &works(3, Pass::Resume(token))), Some(Notice::Welcome(_))));
    assert_eq!(class.place(2).wheel, 3);
}

#[test]
fn at_a_frozen_or_closed_wheel_nobodys_press_counts_until_it_thaws() {
    let mut class = Class::open();
    class.teacher(1, 2);
    class.student(2, 1);
    class.student(3, 2);
    class.pass(400, &[(2, dent(0.1)), (3, dent(0.1))]);
    for (held, free) in [
        (Order::Freeze { wheel: 1, is_frozen: true }, Order::Freeze { wheel: 1, is_frozen: false }),
        (Order::Open { wheel: 1, is_open: false }, Order::Open { wheel: 1, is_open: true }),
    ] {
        // samples that are under way when it freezes are taken out and not pressed
        class.pass(3, &[(2, dent(0.12))]);
        class.order(1, held);
        class.pass(20, &[]);
        let frozen = class.digest(0);
        let other = class.digest(1);
        class.pass(400, &[(2, dent(0.12)), (3, dent(0.12))]);
        assert_eq!(class.digest(0), frozen, "{held:?}");
        assert!(class.digest(1) != other || matches!(held, Order::Open { .. }));
        let client = class.line(2).client.as_ref().unwrap();
        assert!(client.is_settled() && !client.class().may_press() && class.holds(2, 0));
        // what a student asks for does nothing, what the teacher orders does
        class.ask(2, &Request::WheelSpeed { rpm: 150.0 });
        class.order(1, Order::WheelSpeed { wheel: 1, rpm: 90.0 });
        class.pass(400, &[]);
        assert_eq!(class.room.conditions(0).unwrap().wheel.speed(Tick(class.now)).0.round(), 90.0);
        class.order(1, free);
        class.pass(400, &[(2, dent(0.14))]);
        // a snapshot waits for the samples that belong into it: what was told is all there is once the hand rests
        class.pass(100, &[]);
        assert!(class.digest(0) != frozen && class.holds(2, 0));
    }
    // nobody comes to a closed wheel, but a teacher
    class.order(1, Order::Open { wheel: 3, is_open: false });
    assert_eq!(class.greet(4, &works(3, Pass::None)), Some(Notice::Refused(Refusal::WheelClosed { wheel: 3 })));
    class.teacher(5, 3);
    // a hostile client that presses on although it was told is not pressed
    class.order(1, Order::Freeze { wheel: 0, is_frozen: true });
    let frozen = class.digest(1);
    let mut hostile = Client::open(&protocol::encode(&class.line(3).notices[0]), class.now, Duration::ZERO).unwrap();
    for tick in 0..300 {
        hostile.handle_sample(sample(class.now + tick, dent(0.16)));
    }
    while let Some(bytes) = hostile.poll_datagram(Duration::from_secs(9)) {
        class.room.handle_datagram(PeerId(3), &bytes);
    }
    class.pass(600, &[]);
    assert_eq!(class.digest(1), frozen);
}

#[test]
fn people_are_seated_and_come_back_to_another_wheel() {
    let mut class = Class::open();
    class.teacher(1, 1);
    let before = class.student(2, 1);
    let token = class.line(2).resume.unwrap();
    let client = before.client;
    assert_eq!(class.order(1, Order::Seat { client, wheel: 1, works: false }), None);
    assert!(!class.place(2).may_press);
    class.pass(300, &[(2, dent(0.1))]);
    assert_eq!(class.digest(0), class.digest(1), "who looks on presses nothing");
    assert_eq!(class.order(1, Order::Seat { client, wheel: 3, works: true }), None);
    assert!(class.line(2).is_closed && class.line(2).notices.contains(&Notice::Come { wheel: 3 }));
    class.greet(4, &works(1, Pass::Resume(token)));
    assert_eq!(class.place(4), PlaceWire { wheel: 3, may_press: true, resume: None, ..before });
    class.pass(300, &[(4, dent(0.1))]);
    assert!(class.digest(2) != class.digest(1) && class.holds(4, 2));
    for (order, reason) in [
        (Order::Seat { client, wheel: 4, works: true }, NoOrder::Wheel { wheel: 4 }),
        (Order::Seat { client: 99, wheel: 1, works: true }, NoOrder::Person { client: 99 }),
        (Order::Freeze { wheel: 4, is_frozen: true }, NoOrder::Wheel { wheel: 4 }),
        (Order::Pot { wheel: 1, of: PotOf::Wheel(0) }, NoOrder::Wheel { wheel: 0 }),
        (Order::Admit { client, is_admitted: true }, NoOrder::Person { client }),
        (Order::TakeBack { wheel: 1 }, NoOrder::NothingBack),
    ] {
        assert_eq!(class.order(1, order), Some(reason));
    }
    // who looks on with a program that has no hand keeps to that
    class.greet(5, &Hello { purpose: Purpose::Watches { bytes_per_s: 1000 }, ..works(0, Pass::None) });
    let guest = class.place(5).client;
    assert_eq!(class.order(1, Order::Seat { client: guest, wheel: 1, works: true }), Some(NoOrder::CannotWork));
}

#[test]
fn who_waits_in_the_lobby_can_do_nothing_until_a_teacher_lets_them_in() {
    let mut class = Class::with(DoorConfig { has_lobby: true, ..doors() });
    class.teacher(1, 1);
    for peer in 2..5 {
        assert_eq!(class.greet(peer, &works(1, Pass::None)), Some(Notice::Waiting));
        class.ask(peer, &Request::WheelSpeed { rpm: 200.0 });
        class.ask(peer, &Request::Resync { have: 0 });
    }
    class.pass(600, &[]);
    assert_eq!(class.room.conditions(0).unwrap().wheel.speed(Tick(class.now)).0.round(), 60.0);
    let waiting: Vec<_> = class.people(1).into_iter().filter(|person| person.presence == Presence::Waiting).collect();
    assert_eq!((waiting.len(), class.room.people_at(0)), (3, 1));
    assert!(class.line(2).notices == [Notice::Waiting], "{:?}", class.line(2).notices);
    class.order(1, Order::Admit { client: waiting[0].client, is_admitted: true });
    assert!(matches!(class.line(2).notices[1], Notice::Welcome(_)) && class.place(2).may_press);
    class.order(1, Order::Admit { client: waiting[1].client, is_admitted: false });
    assert!(class.line(3).notices.contains(&Notice::Refused(Refusal::NotAdmitted)) && class.line(3).is_closed);
    // one who gives up is forgotten
    class.room.handle_gone(PeerId(4));
    class.order(1, Order::Lobby { is_on: false });
    class.student(6, 2);
    class.pass(300, &[]);
    assert_eq!(class.people(1).len(), 3);
}

#[test]
fn a_student_knows_of_those_at_the_wheel_and_of_teachers_and_of_nobody_else() {
    let mut class = Class::open();
    class.teacher(1, 1);
    class.student(2, 2);
    class.student(3, 2);
    class.student(4, 3);
    class.pass(300, &[(3, dent(0.1))]);
    let known: Vec<_> = class.people(2).iter().map(|person| (person.role, person.wheel, person.touching)).collect();
    assert_eq!(known, [(Role::Teacher, 1, false), (Role::Student, 2, false), (Role::Student, 2, false)]);
    let touching: Vec<_> = class.people(1).iter().filter(|person| person.touching).map(|person| person.wheel).collect();
    assert_eq!(touching, [2], "a teacher is told who touches");
    let names: std::collections::BTreeSet<_> = class.people(1).iter().map(|person| person.name).collect();
    assert_eq!(names.len(), 4, "everybody has a name of their own");
    class.ask(3, &Request::Leave);
    class.pass(300, &[]);
    assert_eq!((class.people(2).len(), class.people(1).len(), class.people(4).len()), (2, 3, 2));
}

#[test]
fn the_end_sends_everybody_home_and_locks_the_door() {
    let mut class = Class::open();
    class.teacher(1, 1);
    class.student(2, 1);
    let token = class.line(2).resume.unwrap();
    class.greet(3, &Hello { purpose: Purpose::Watches { bytes_per_s: 1000 }, ..works(0, Pass::None) });
    class.pass(300, &[(2, dent(0.1))]);
    class.pass(100, &[]);
    let pot = class.digest(0);
    assert_eq!(class.order(1, Order::End), None);
    for peer in [2, 3] {
        assert!(class.line(peer).notices.contains(&Notice::Closing) && class.line(peer).is_closed);
    }
    assert!(!class.line(1).is_closed && class.room.people() == 1);
    assert_eq!(class.greet(4, &works(1, Pass::Resume(token))), Some(Notice::Refused(Refusal::Locked)));
    class.pass(100, &[]);
    assert!(class.holds(1, 0) && class.digest(0) == pot, "the pot stays");
    class.order(1, Order::Lock { is_locked: false });
    class.student(5, 1);
}

#[test]
fn a_clock_that_jumps_ahead_or_stands_still_or_goes_back_costs_nobody_seat_or_pot() {
    let mut class = Class::open();
    class.teacher(1, 1);
    class.student(2, 2);
    class.pass(400, &[(2, dent(0.1))]);
    class.pass(100, &[]);
    let (seat, before) = (class.place(2), class.digest(1));
    // an hour in one step, as after a machine was asleep
    class.now += 3_600_000;
    class.pass(300, &[]);
    assert_eq!(class.digest(1), before, "nobody has pressed meanwhile");
    // ahead, not at all, and back: the room's own time only ever goes on
    for (number, jump) in [3_600_000_i64, 0, -5_000, -3_600_000].into_iter().enumerate() {
        let (room, before) = (class.room.now(), class.digest(1));
        class.room.advance(Tick(class.now.saturating_add_signed(jump)));
        class.listen();
        assert!(class.room.now() >= room, "{jump}: the room goes back");
        // the hand hears of the room's time, and goes on from there
        class.now = class.room.now().0;
        class.pass(600, &[(2, dent(0.04 + 0.03 * number as f32))]);
        class.pass(300, &[]);
        assert!(class.digest(1) != before && class.holds(2, 1), "{jump}: the lesson does not go on");
        assert_eq!((class.place(2), class.people(1).len()), (seat, 2));
    }
}
