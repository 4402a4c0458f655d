//! Hands that guide, as the room passes them on: whatever a client says of its hand, what a student is told of is a hand that can be.
//!
//! No socket and no clock: frames and datagrams are handed to the room, and what it answers is read.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;

use pottery_shared::clay::{Material, MethodKind, PotSpec};
use pottery_shared::protocol::{
    self, Greeting, GuidanceEnd, GuidanceWire, HandWire, Hello, Inputs, NoGuidance, Notice, Pass, Pulse, Purpose,
    Request, ShapeWire, TargetWire, TeacherToken, Upload,
};
use pottery_shared::room::{DoorConfig, Lane, PeerId, Room, RoomConfig, token_hash};
use pottery_shared::units::{Rpm, Tick};

const TOKEN: TeacherToken = TeacherToken([7; 32]);
const HOW: GuidanceWire = GuidanceWire { mode: 1, strength: 50 };
const HAND: HandWire = HandWire {
    tick: 100,
    centre: [8000, 0, 9000],
    tool: ShapeWire::Sphere { radius_um: 12_000 },
    force_mn: 700,
    draws: true,
    inside: false,
};

struct Studio {
    room: Room,
    notices: BTreeMap<PeerId, Vec<Notice>>,
    hands: BTreeMap<PeerId, Option<HandWire>>,
}

impl Studio {
    fn open() -> Self {
        let mut room = Room::new(RoomConfig {
            code: "CLAY".into(),
            wheels: 2,
            people_max: 8,
            pot: PotSpec::default(),
            method: MethodKind::default(),
            wheel_speed: Rpm(0.0),
            clay: Material::default(),
        })
        .unwrap();
        room.keep_doors(DoorConfig { teacher: Some(token_hash(&TOKEN.0)), ..DoorConfig::default() });
        Self { room, notices: BTreeMap::new(), hands: BTreeMap::new() }
    }

    /// Lets somebody in; their number.
    fn join(&mut self, peer: u64, wheel: u16, pass: Pass) -> u16 {
        let hello = Hello { code: "CLAY".into(), wheel, purpose: Purpose::Works { retells: false }, pass };
        let (version, hello) = (protocol::VERSION.to_le_bytes(), protocol::encode(&hello));
        let greeting = Greeting { magic: Greeting::MAGIC, version, hello };
        self.room.handle_control(PeerId(peer), &protocol::encode(&greeting));
        self.listen();
        let welcome = self.notices[&PeerId(peer)].iter().find_map(|notice| match notice {
            Notice::Welcome(welcome) => Some(welcome.client),
            _ => None,
        });
        welcome.unwrap()
    }

    fn ask(&mut self, peer: u64, request: &Request) {
        self.room.handle_control(PeerId(peer), &protocol::encode(request));
        self.listen();
    }

    fn show(&mut self, peer: u64, hand: HandWire) {
        let upload =
            Upload { inputs: Inputs { first: 0, runs: Vec::new(), rests: true }, hand: Some(hand), again: None };
        self.room.handle_datagram(PeerId(peer), &protocol::encode(&upload));
    }

    /// Lets a tenth of a second pass; the hand that a peer was told of last.
    fn heard(&mut self, peer: u64) -> Option<HandWire> {
        let now = self.room.now();
        self.room.advance(now.offset(100));
        self.listen();
        self.hands.get(&PeerId(peer)).copied().flatten()
    }

    fn listen(&mut self) {
        while let Some(transmit) = self.room.poll_transmit() {
            match transmit.lane {
                Lane::Control(frame) => {
                    let notice = protocol::decode::<{ protocol::CONTROL_MAX }, Notice>(&frame[2..]).unwrap();
                    self.notices.entry(transmit.to).or_default().push(notice);
                }
                Lane::Datagram(bytes) => {
                    assert!(bytes.len() <= protocol::DATAGRAM_MAX, "{} bytes", bytes.len());
                    let pulse = protocol::decode::<{ protocol::DATAGRAM_MEMORY_MAX }, Pulse>(&bytes).unwrap();
                    self.hands.insert(transmit.to, pulse.head.teacher);
                }
                Lane::Keyframe(_) | Lane::Close => {}
            }
        }
    }

    fn last(&self, peer: u64) -> Option<&Notice> {
        let told = |notice: &&Notice| !matches!(notice, Notice::People { .. } | Notice::Class(_) | Notice::Place(_));
        self.notices[&PeerId(peer)].iter().rev().find(told)
    }
}

/// A teacher at the first wheel who guides a student at the second.
fn guided() -> (Studio, u16) {
    let mut studio = Studio::open();
    studio.join(1, 1, Pass::Teacher(TOKEN));
    let student = studio.join(2, 2, Pass::None);
    studio.ask(1, &Request::Guide { student, guidance: HOW });
    (studio, student)
}

#[test]
fn the_newest_hand_is_passed_on_to_the_student_alone_and_nowhere_once_it_has_ended() {
    let (mut studio, _) = guided();
    studio.join(3, 2, Pass::None);
    assert_eq!(studio.heard(2), None, "nothing was said yet");
    studio.show(1, HAND);
    assert_eq!((studio.heard(2), studio.heard(1), studio.heard(3)), (Some(HAND), None, None));
    // datagrams overtake each other
    studio.show(1, HandWire { tick: 120, ..HAND });
    studio.show(1, HandWire { tick: 110, ..HAND });
    assert_eq!(studio.heard(2).map(|hand| hand.tick), Some(120));
    // what somebody else says of a hand is no teacher's
    studio.show(3, HandWire { tick: 500, ..HAND });
    assert_eq!(studio.heard(2).map(|hand| hand.tick), Some(120));
    studio.ask(2, &Request::EndGuidance);
    assert_eq!(studio.heard(2), None);
    assert_eq!(studio.last(1), Some(&Notice::GuidanceEnded(GuidanceEnd::Student)));
}

#[test]
fn a_hand_that_cannot_be_is_passed_on_to_nobody_and_the_next_sound_one_is() {
    let (mut studio, _) = guided();
    let far = [i32::MAX, 0, 0];
    let odd = [
        HandWire { tick: 101, centre: far, ..HAND },
        HandWire { tick: 102, centre: [0, 100_001, 0], ..HAND },
        HandWire { tick: 103, tool: ShapeWire::Sphere { radius_um: 0 }, ..HAND },
        HandWire { tick: 104, tool: ShapeWire::Sphere { radius_um: u16::MAX }, ..HAND },
        HandWire { tick: u64::MAX, ..HAND },
    ];
    for hand in odd {
        studio.show(1, hand);
        assert_eq!(studio.heard(2), None, "{hand:?}");
    }
    // a tool that somebody brought to one wheel hangs at no other, and a sphere stands for it there
    let brought = ShapeWire::Convex { shape: 9, orientation: [1, 2, 3] };
    studio.show(1, HandWire { tick: 200, tool: brought, ..HAND });
    assert!(matches!(studio.heard(2).map(|hand| hand.tool), Some(ShapeWire::Sphere { .. })));
}

#[test]
fn who_may_not_asks_in_vain_and_who_asks_too_often_is_not_answered() {
    let (mut studio, student) = guided();
    for guidance in [GuidanceWire { mode: 5, ..HOW }, GuidanceWire { strength: 101, ..HOW }] {
        studio.ask(1, &Request::Guide { student, guidance });
        assert_eq!(studio.last(1), Some(&Notice::NoGuidance(NoGuidance::Unknown)), "{guidance:?}");
    }
    studio.ask(2, &Request::Guide { student: 1, guidance: HOW });
    assert_eq!(studio.last(2), Some(&Notice::NoGuidance(NoGuidance::NotTeacher)));
    let other = studio.join(4, 2, Pass::Teacher(TOKEN));
    studio.ask(1, &Request::Guide { student: other, guidance: HOW });
    assert_eq!(studio.last(1), Some(&Notice::NoGuidance(NoGuidance::Nobody)), "who teaches is led by nobody");
    let odd = TargetWire { height_m: f32::NAN, radii: vec![15_000; 65] };
    studio.ask(1, &Request::Target(Some(odd)));
    assert_eq!(studio.last(1), Some(&Notice::NoGuidance(NoGuidance::Unknown)));
    let before = studio.notices[&PeerId(2)].len();
    for strength in 0..=100 {
        studio.ask(1, &Request::Guide { student, guidance: GuidanceWire { strength, ..HOW } });
    }
    let told = studio.notices[&PeerId(2)].len() - before;
    assert!((10..=40).contains(&told), "told {told} times of a hundred");
}

#[test]
fn a_student_who_leaves_and_a_teacher_who_is_gone_end_it_for_the_other() {
    let (mut studio, _) = guided();
    studio.ask(2, &Request::Leave);
    assert_eq!(studio.last(1), Some(&Notice::GuidanceEnded(GuidanceEnd::Gone)));
    let (mut studio, _) = guided();
    studio.room.advance(Tick(50));
    studio.room.handle_gone(PeerId(1));
    studio.listen();
    assert_eq!(studio.last(2), Some(&Notice::GuidanceEnded(GuidanceEnd::Gone)));
    assert_eq!(studio.heard(2), None);
}
