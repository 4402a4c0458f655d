//! What people send to a room: whatever makes no sense is refused and counted by its reason, and everything else is
//! pressed, of the same person and of everybody else.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;

use glam::Vec3;
use pottery_shared::clay::{GridShape, Material, MethodKind, Phase, PotSpec, Strength, Wetness, Wheel};
use pottery_shared::protocol::{
    self, ClayWire, DATAGRAM_MEMORY_MAX, Greeting, Hello, Inputs, Notice, Pass, Pulse, Purpose, Refusal, Request, Run,
    ShapeWire, Upload,
};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{InputQueue, Refusals};
use pottery_shared::tool::Position;
use pottery_shared::units::{Rpm, Seconds, Tick};
use proptest::prelude::*;

const CODE: &str = "CLAY";
/// Late enough that a sample can be too old.
const OPENED: u64 = 20_000;

struct Studio {
    room: Room,
    /// Control messages and closings, in order; what a datagram acknowledged last.
    said: BTreeMap<PeerId, Vec<Said>>,
    acknowledged: BTreeMap<PeerId, u32>,
}

#[derive(Clone, Debug, PartialEq)]
enum Said {
    Notice(Notice),
    Close,
}

impl Studio {
    /// A studio of two wheels for three people at tick [`OPENED`].
    fn open() -> Self {
        let room = Room::new(RoomConfig {
            code: CODE.into(),
            wheels: 2,
            people_max: 3,
            pot: PotSpec { shape: GridShape::new(90, 100).unwrap(), ..PotSpec::default() },
            method: MethodKind::Improved,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        })
        .unwrap();
        let mut studio = Self { room, said: BTreeMap::new(), acknowledged: BTreeMap::new() };
        studio.advance(OPENED - 1);
        studio
    }

    fn with(people: u64) -> Self {
        let mut studio = Self::open();
        for person in 0..people {
            studio.join(PeerId(person));
        }
        studio
    }

    fn join(&mut self, peer: PeerId) {
        self.greet(peer, &greeting(protocol::VERSION, CODE, 1));
        assert!(matches!(self.said[&peer].last(), Some(Said::Notice(Notice::Welcome(_)))), "{peer:?}");
    }

    fn greet(&mut self, peer: PeerId, frame: &[u8]) {
        self.room.handle_control(peer, frame);
        self.listen();
    }

    fn request(&mut self, peer: PeerId, request: &Request) {
        self.room.handle_control(peer, &protocol::encode(request));
        self.listen();
    }

    fn send(&mut self, peer: PeerId, inputs: &Inputs) {
        let upload = Upload { inputs: inputs.clone(), hand: None, again: None };
        self.room.handle_datagram(peer, &protocol::encode(&upload));
    }

    fn advance(&mut self, to: u64) {
        self.room.advance(Tick(to));
        self.listen();
    }

    fn listen(&mut self) {
        while let Some(transmit) = self.room.poll_transmit() {
            let said = match transmit.lane {
                Lane::Control(framed) => {
                    Said::Notice(protocol::decode::<{ protocol::CONTROL_MAX }, _>(&framed[2..]).unwrap())
                }
                Lane::Close => Said::Close,
                Lane::Datagram(bytes) => {
                    let pulse: Pulse = protocol::decode::<DATAGRAM_MEMORY_MAX, _>(&bytes).unwrap();
                    self.acknowledged.insert(transmit.to, pulse.head.acknowledged);
                    continue;
                }
                Lane::Keyframe(_) => continue,
            };
            // what is told of the lesson is another test's
            if !matches!(said, Said::Notice(Notice::Place(_) | Notice::People { .. })) {
                self.said.entry(transmit.to).or_default().push(said);
            }
        }
    }

    fn clay(&self) -> u64 {
        self.room.pot(0).unwrap().digest()
    }

    fn removed_mm3(&self) -> f64 {
        self.room.pot(0).unwrap().pressed_m3() * 1e9
    }

    fn refusals(&self) -> Refusals {
        self.room.counts().refusals
    }
}

fn greeting(version: u16, code: &str, wheel: u16) -> Vec<u8> {
    let hello = protocol::encode(&Hello {
        code: code.into(),
        wheel,
        purpose: Purpose::Works { retells: false },
        pass: Pass::None,
    });
    protocol::encode(&Greeting { magic: Greeting::MAGIC, version: version.to_le_bytes(), hello })
}

/// Where a sound stroke is: 3 mm deep, moving up, one side of the pot for each person.
fn stroke_at(person: u64, tick: u64) -> [i32; 3] {
    let angle = person as f32 * 2.0;
    let z_m = 0.05 + (tick - OPENED) as f32 * 1e-4;
    let Position(steps) = Position::nearest(Vec3::new(0.069 * angle.cos(), 0.069 * angle.sin(), z_m)).unwrap();
    steps
}

fn run_of(first_tick: u64, positions: &[[i32; 3]]) -> Run {
    let step = |pair: &[[i32; 3]]| std::array::from_fn(|axis| (pair[1][axis] - pair[0][axis]) as i16);
    let steps = positions.windows(2).map(step).collect();
    Run { steps, ..single(first_tick, 12_000, positions[0]) }
}

/// A person's sound stroke over the given ticks, as one run.
fn stroke(person: u64, ticks: std::ops::Range<u64>) -> Run {
    let positions: Vec<_> = ticks.clone().map(|tick| stroke_at(person, tick)).collect();
    run_of(ticks.start, &positions)
}

/// A run of one sample.
fn single(tick: u64, radius_um: u16, start: [i32; 3]) -> Run {
    let tool = ShapeWire::Sphere { radius_um };
    Run { first_tick: tick as u16, tool, inside: false, start, steps: Vec::new(), turns: Vec::new() }
}

/// The same with a convex tool.
fn convex(tick: u64, shape: u8, start: [i32; 3]) -> Run {
    let tool = ShapeWire::Convex { shape, orientation: [i16::MIN, i16::MAX, 1] };
    Run { tool, ..single(tick, 12_000, start) }
}

#[test]
fn sample_that_makes_no_sense_is_counted_by_its_reason_and_the_rest_is_pressed() {
    let (begin, middle, end) = (OPENED + 20, OPENED + 70, OPENED + 120);
    let sound = stroke_at(0, middle);
    let far = [sound[0], sound[1], sound[2] + 600];
    let one = Refusals::default();
    // each takes the place of the sample at `middle`
    let hostile = [
        ("outside of the workspace", single(middle, 12_000, [100_001, 0, 0]), Refusals { out_of_workspace: 1, ..one }),
        (
            "at the end of numbers",
            single(middle, 12_000, [-Run::PLACE_MAX - 1, Run::PLACE_MAX, 0]),
            Refusals { out_of_workspace: 1, ..one },
        ),
        ("no tool", single(middle, 0, sound), Refusals { out_of_workspace: 1, ..one }),
        ("a tool too large", single(middle, u16::MAX, sound), Refusals { out_of_workspace: 1, ..one }),
        ("a tool that is not in the rack", convex(middle, 4, sound), Refusals { out_of_workspace: 1, ..one }),
        ("6 mm in a tick", single(middle, 12_000, far), Refusals { too_fast: 1, ..one }),
        ("the tick before again", single(middle - 1, 12_000, sound), Refusals { from_the_past: 1, ..one }),
        ("before the one before", single(begin, 12_000, sound), Refusals { from_the_past: 1, ..one }),
        ("long gone", single(OPENED - 10_001, 12_000, sound), Refusals { from_the_past: 1, ..one }),
        ("the first tick of all", single(0, 12_000, sound), Refusals { from_the_past: 1, ..one }),
        ("far ahead", single(OPENED + 1501, 12_000, sound), Refusals { from_the_future: 1, ..one }),
        // of a tick 16 bits are said
        ("as far ahead as can be said", single(OPENED + 32_000, 12_000, sound), Refusals { from_the_future: 1, ..one }),
    ];
    let pressed = |between: Option<&Run>| {
        let mut studio = Studio::with(2);
        let mut runs = vec![stroke(0, begin..middle)];
        runs.extend(between.cloned());
        runs.push(stroke(0, middle + 1..end));
        studio.send(PeerId(0), &Inputs { first: 0, runs, rests: true });
        studio.send(PeerId(1), &Inputs { first: 0, runs: vec![stroke(1, begin..end)], rests: true });
        studio.advance(end + 20);
        studio
    };
    let sound = pressed(None);
    assert!(sound.removed_mm3() > 100.0, "{} mm³", sound.removed_mm3());
    assert_eq!((sound.refusals(), sound.acknowledged[&PeerId(0)]), (Refusals::default(), 99));
    for (what, run, refusals) in hostile {
        let studio = pressed(Some(&run));
        assert_eq!(studio.refusals(), refusals, "{what}");
        assert!(studio.clay() == sound.clay(), "{what}: the sound samples were not pressed as they were meant");
        // what was refused is acknowledged too, or it would be sent for ever
        assert_eq!(studio.acknowledged[&PeerId(0)], 100, "{what}");
        assert_eq!(studio.acknowledged[&PeerId(1)], 100, "{what}");
    }
}

#[test]
fn flood_is_counted_and_may_come_again_later() {
    let ticks = OPENED - 9_900..OPENED - 4_900;
    let in_the_air = |ticks: std::ops::Range<u64>| run_of(ticks.start, &vec![[30_000, 0, 0]; ticks.count()]);
    let datagrams: Vec<_> = ticks
        .clone()
        .step_by(100)
        .map(|from| Inputs {
            first: (from - ticks.start) as u16,
            runs: vec![in_the_air(from..from + 100)],
            rests: true,
        })
        .collect();
    let stroke = Inputs { first: 0, runs: vec![stroke(1, OPENED + 20..OPENED + 120)], rests: true };
    let mut calm = Studio::with(2);
    calm.send(PeerId(1), &stroke);
    calm.advance(OPENED + 700);
    let mut studio = Studio::with(2);
    for datagram in &datagrams {
        studio.send(PeerId(0), datagram);
    }
    let full = InputQueue::LENGTH_MAX;
    // what follows the first that finds no room has a gap before it, and waits to be repeated
    assert_eq!(studio.refusals(), Refusals { flood: 1, ..Refusals::default() });
    studio.send(PeerId(1), &stroke);
    studio.advance(OPENED + 700);
    assert!(calm.removed_mm3() > 10.0, "{} mm³", calm.removed_mm3());
    assert_eq!(studio.clay(), calm.clay());
    assert_eq!(studio.acknowledged[&PeerId(0)] as usize, full);
    for datagram in &datagrams {
        studio.send(PeerId(0), datagram);
    }
    studio.advance(OPENED + 1400);
    assert_eq!(studio.acknowledged[&PeerId(0)] as usize, datagrams.len() * 100);
    assert_eq!(studio.refusals().total(), 1);
}

/// Numbers of which the ends are likely.
fn number() -> impl Strategy<Value = u16> {
    prop_oneof![0_u16..200, u16::MAX - 200..=u16::MAX, Just(1 << 15), any::<u16>()]
}

fn tick() -> impl Strategy<Value = u64> {
    let near = OPENED - 12_000..OPENED + 2_000;
    prop_oneof![4 => near, 1 => 0_u64..100, 1 => u64::MAX - 200..=u64::MAX, 1 => any::<u64>()]
}

fn hostile_inputs() -> impl Strategy<Value = Inputs> {
    let coordinate = prop_oneof![-12_000_i32..12_000, any::<i32>()];
    let steps = prop::collection::vec(prop::array::uniform3(prop_oneof![-20_i16..20, any::<i16>()]), 0..50);
    let turns = (any::<bool>(), prop::collection::vec(any::<[i16; 3]>(), 0..50));
    let radius = prop_oneof![500_u16..40_000, any::<u16>()];
    let tool = prop_oneof![
        radius.prop_map(|radius_um| ShapeWire::Sphere { radius_um }),
        (0_u8..6, any::<[i16; 3]>()).prop_map(|(shape, orientation)| ShapeWire::Convex { shape, orientation }),
    ];
    let run = (tick(), tool, prop::array::uniform3(coordinate), steps, turns).prop_map(
        |(first_tick, tool, start, steps, (alike, mut turns))| {
            if alike {
                turns.resize(steps.len(), [7; 3]);
            }
            Run { first_tick: first_tick as u16, tool, inside: false, start, steps, turns }
        },
    );
    (number(), prop::collection::vec(run, 0..5), any::<bool>()).prop_map(|(first, runs, rests)| Inputs {
        first,
        runs,
        rests,
    })
}

#[test]
fn samples_without_what_follows_them_are_malformed() {
    let mut studio = Studio::with(1);
    // as bytes of chance are once in some hundred runs
    let samples = Inputs { first: 0, runs: Vec::new(), rests: true };
    studio.room.handle_datagram(PeerId(0), &protocol::encode(&samples));
    assert_eq!(studio.refusals().malformed, 1);
    studio.room.handle_datagram(PeerId(0), &protocol::encode(&Upload { inputs: samples, hand: None, again: None }));
    assert_eq!(studio.refusals().malformed, 1);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn datagrams_of_chance_are_malformed_and_nothing_else(
        datagrams in prop::collection::vec(prop::collection::vec(any::<u8>(), 0..1200), 1..20),
    ) {
        let mut studio = Studio::with(1);
        for bytes in &datagrams {
            studio.room.handle_datagram(PeerId(0), bytes);
        }
        let malformed = datagrams.iter().filter(|bytes| protocol::decode::<DATAGRAM_MEMORY_MAX, Upload>(bytes).is_err());
        prop_assert_eq!(studio.refusals().malformed, malformed.count() as u64);
        studio.advance(OPENED + 20);
    }

    #[test]
    fn sound_samples_are_pressed_beside_hostile_ones(datagrams in prop::collection::vec(hostile_inputs(), 1..12)) {
        let mut studio = Studio::with(3);
        let mut quiet = Studio::with(3);
        for studio in [&mut studio, &mut quiet] {
            studio.send(PeerId(1), &Inputs { first: 0, runs: vec![stroke(1, OPENED + 20..OPENED + 50)], rests: true });
        }
        // at the other wheel, so that nothing it presses can be confused with the stroke
        studio.request(PeerId(0), &Request::Leave);
        studio.greet(PeerId(7), &greeting(protocol::VERSION, CODE, 2));
        for inputs in &datagrams {
            studio.send(PeerId(7), inputs);
        }
        studio.advance(OPENED + 70);
        quiet.advance(OPENED + 70);
        prop_assert!(studio.clay() == quiet.clay() && quiet.removed_mm3() > 10.0);
        prop_assert_eq!(studio.acknowledged[&PeerId(1)], 30);
        let surface = &studio.room.pot(1).unwrap().surfaces()[0];
        let (low, high) = surface.bounds_m();
        prop_assert!(surface.radii_m().iter().all(|radius| (low..=high).contains(radius)));
    }

    #[test]
    fn samples_are_taken_once_and_in_order_however_they_arrive(
        pieces in prop::collection::vec((0_u64..400, 1_u64..60), 0..40),
    ) {
        let sent = |from: u64, to: u64| Inputs { first: from as u16, runs: vec![stroke(0, OPENED + from..OPENED + to)], rests: true };
        let mut queue = InputQueue::default();
        for (from, length) in pieces {
            queue.handle_inputs(&sent(from, from + length), Tick(OPENED), 0);
        }
        // at the latest, the client repeats everything
        queue.handle_inputs(&sent(0, 500), Tick(OPENED), 0);
        let mut taken = Vec::new();
        for now in OPENED..OPENED + 500 {
            let due: Vec<_> = std::iter::from_fn(|| queue.take_due(Tick(now))).collect();
            prop_assert!(due.iter().all(|sample| sample.tick <= Tick(now)));
            taken.extend(due);
        }
        let expected: Vec<_> = (OPENED..OPENED + 500).map(|tick| (Tick(tick), Position(stroke_at(0, tick)))).collect();
        prop_assert!(taken.iter().map(|sample| (sample.tick, sample.centre)).eq(expected));
        prop_assert_eq!((queue.acknowledged(), queue.is_empty(), queue.refusals().total()), (500, true, 0));
    }
}

#[test]
fn numbers_of_samples_wrap() {
    let mut queue = InputQueue::default();
    // the last six numbers, seen long ago, and the first 14
    queue.handle_inputs(
        &Inputs { first: u16::MAX - 5, runs: vec![stroke(0, OPENED..OPENED + 20)], rests: true },
        Tick(OPENED),
        0,
    );
    assert_eq!(queue.take_due(Tick(OPENED + 20)).unwrap().tick, Tick(OPENED + 6));
    while queue.take_due(Tick(OPENED + 20)).is_some() {}
    assert_eq!((queue.acknowledged(), queue.refusals().total()), (14, 0));
}

#[test]
fn datagram_of_somebody_who_was_not_let_in_is_ignored() {
    let mut studio = Studio::with(1);
    let stroke = Inputs { first: 0, runs: vec![stroke(0, OPENED + 20..OPENED + 50)], rests: true };
    let stranger = PeerId(99);
    studio.send(stranger, &stroke);
    studio.room.handle_datagram(stranger, b"nonsense");
    studio.greet(stranger, &greeting(protocol::VERSION, "CLAX", 1));
    studio.send(stranger, &stroke);
    studio.advance(OPENED + 70);
    assert_eq!(studio.clay(), Studio::open().clay());
    assert_eq!(studio.refusals().total(), 0);
    assert!(!studio.acknowledged.contains_key(&stranger));
}

#[test]
fn whoever_may_not_come_in_is_told_why_and_let_go() {
    let version = protocol::VERSION;
    let wrong_hello = Greeting { magic: Greeting::MAGIC, version: version.to_le_bytes(), hello: vec![0xff; 20] };
    let wrong_magic = Greeting { magic: *b"PANS", version: version.to_le_bytes(), hello: Vec::new() };
    let refused = [
        ("wrong code", greeting(version, "CLAX", 1), Refusal::Code),
        ("no code", greeting(version, "", 1), Refusal::Code),
        ("code and more", greeting(version, "CLAYS", 1), Refusal::Code),
        ("no wheel", greeting(version, CODE, 0), Refusal::Wheel { wheel: 0, wheels: 2 }),
        ("unknown wheel", greeting(version, CODE, 3), Refusal::Wheel { wheel: 3, wheels: 2 }),
        ("last of wheels", greeting(version, CODE, u16::MAX), Refusal::Wheel { wheel: u16::MAX, wheels: 2 }),
        ("newer", greeting(version + 1, CODE, 1), Refusal::Version { server: version, client: version + 1 }),
        ("older", greeting(0, CODE, 1), Refusal::Version { server: version, client: 0 }),
        ("wrong hello", protocol::encode(&wrong_hello), Refusal::Greeting),
        ("another protocol", protocol::encode(&wrong_magic), Refusal::Greeting),
        ("a request", protocol::encode(&Request::Leave), Refusal::Greeting),
        ("nothing", Vec::new(), Refusal::Greeting),
        ("a web page", b"GET / HTTP/1.1\r\n\r\n".to_vec(), Refusal::Greeting),
    ];
    for (what, frame, refusal) in refused {
        let mut studio = Studio::with(1);
        let stranger = PeerId(99);
        studio.greet(stranger, &frame);
        let told = vec![Said::Notice(Notice::Refused(refusal)), Said::Close];
        assert_eq!(studio.said[&stranger], told, "{what}");
        assert_eq!((studio.room.people(), studio.room.counts().refused), (1, 1), "{what}");
        assert_eq!(studio.said[&PeerId(0)].len(), 1, "{what}: somebody else was told");
    }
}

#[test]
fn full_studio_refuses_until_somebody_leaves() {
    let mut studio = Studio::with(3);
    studio.greet(PeerId(3), &greeting(protocol::VERSION, CODE, 2));
    assert_eq!(studio.said[&PeerId(3)], [Said::Notice(Notice::Refused(Refusal::Full { people: 3 })), Said::Close]);
    studio.request(PeerId(1), &Request::Leave);
    assert_eq!(studio.said[&PeerId(1)].last(), Some(&Said::Close));
    assert_eq!(studio.room.people(), 2);
    studio.join(PeerId(4));
    assert_eq!((studio.room.people(), studio.room.counts().joined), (3, 4));
}

#[test]
fn request_that_is_none_ends_the_connection_and_nothing_else() {
    for frame in [&[0xff; 9][..], &[], &greeting(protocol::VERSION, CODE, 1)] {
        let mut studio = Studio::with(2);
        studio.send(PeerId(0), &Inputs { first: 0, runs: vec![stroke(0, OPENED + 20..OPENED + 50)], rests: true });
        studio.greet(PeerId(0), frame);
        assert_eq!(studio.said[&PeerId(0)].last(), Some(&Said::Close));
        assert_eq!((studio.room.people(), studio.said[&PeerId(1)].len()), (1, 1));
        studio.advance(OPENED + 70);
        assert!(studio.removed_mm3() > 10.0, "what had been sent before was not pressed");
    }
}

#[test]
fn all_that_was_sent_is_pressed_though_its_maker_left() {
    let inputs = Inputs { first: 0, runs: vec![stroke(0, OPENED + 20..OPENED + 400)], rests: true };
    let mut stayed = Studio::with(1);
    stayed.send(PeerId(0), &inputs);
    stayed.advance(OPENED + 500);
    for leave_at in [OPENED, OPENED + 10, OPENED + 200, OPENED + 399] {
        for says_goodbye in [true, false] {
            let mut studio = Studio::with(1);
            studio.send(PeerId(0), &inputs);
            studio.advance(leave_at);
            if says_goodbye {
                studio.request(PeerId(0), &Request::Leave);
            } else {
                studio.room.handle_gone(PeerId(0));
            }
            let told = studio.said[&PeerId(0)].len();
            studio.acknowledged.clear();
            studio.advance(OPENED + 500);
            assert_eq!(studio.clay(), stayed.clay(), "left at {leave_at}, goodbye {says_goodbye}");
            assert_eq!(studio.room.people(), 0);
            let heard = studio.said[&PeerId(0)].len() > told || studio.acknowledged.contains_key(&PeerId(0));
            assert!(!heard, "something was sent to somebody who is gone");
        }
    }
    assert!(stayed.removed_mm3() > 100.0);
}

fn is_allowed(clay: &ClayWire) -> bool {
    let strength = Strength { youngs_pa: clay.youngs_pa, yield_pa: clay.yield_pa };
    Material::new(Seconds(clay.viscosity_s), strength).is_ok()
}

/// Clay of a wetness as it is asked for.
fn clay_request(liquidity_index: f32) -> Request {
    Request::Clay { clay: Material::from_wetness(Wetness::nearest(liquidity_index)).into() }
}

/// The wheel as a newcomer is told of it.
fn told_wheel(studio: &mut Studio, newcomer: u64) -> Wheel {
    let peer = PeerId(newcomer);
    studio.join(peer);
    let Some(Said::Notice(Notice::Welcome(welcome))) = studio.said[&peer].first() else { panic!("not let in") };
    let mut segments = welcome.wheel.iter();
    let first = segments.next().unwrap();
    let mut wheel = Wheel::starting_at(Tick(first.from), Phase(first.phase), first.rate);
    segments.for_each(|segment| wheel.schedule(Tick(segment.from), segment.rate));
    for (_, clay) in &welcome.clay {
        assert!(is_allowed(clay), "{clay:?}");
    }
    studio.request(peer, &Request::Leave);
    wheel
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn settings_stay_finite_whatever_is_asked_for(
        asked in prop::collection::vec((any::<bool>(), [prop::num::f32::ANY; 3]), 1..6),
        odd in prop::sample::select(vec![f32::NAN, f32::INFINITY, f32::NEG_INFINITY, -0.0, f32::MAX, f32::MIN]),
    ) {
        let mut studio = Studio::with(1);
        for (is_speed, values) in asked.into_iter().chain([(true, [odd; 3]), (false, [odd; 3])]) {
            let [rpm, youngs_pa, yield_pa] = values;
            let clay = ClayWire { viscosity_s: rpm, youngs_pa, yield_pa };
            let request = if is_speed { Request::WheelSpeed { rpm } } else { Request::Clay { clay } };
            studio.request(PeerId(0), &request);
        }
        studio.advance(OPENED + 20);
        let rate_max = Wheel::rate_of(Wheel::RPM_MAX);
        for said in &studio.said[&PeerId(0)][1..] {
            match said {
                Said::Notice(Notice::Wheel { rate, .. }) => prop_assert!((-rate_max..=rate_max).contains(rate)),
                Said::Notice(Notice::Clay { clay, .. }) => prop_assert!(is_allowed(clay), "{:?}", clay),
                other => prop_assert!(false, "{:?}", other),
            }
        }
        told_wheel(&mut studio, 50);
        studio.send(PeerId(0), &Inputs { first: 0, runs: vec![stroke(0, OPENED + 400..OPENED + 450)], rests: true });
        studio.advance(OPENED + 460);
        prop_assert!(studio.removed_mm3() > 0.0 && studio.removed_mm3().is_finite());
    }
}

#[test]
fn settings_asked_for_without_pause_do_not_turn_the_wheel_back() {
    let mut studio = Studio::with(1);
    let Some(Said::Notice(Notice::Welcome(welcome))) = studio.said[&PeerId(0)].first() else { panic!("not let in") };
    let [first] = &welcome.wheel.clone()[..] else { panic!("{:?}", welcome.wheel) };
    let mut known: Vec<(Tick, Phase)> = Vec::new();
    for number in 0..600 {
        let now = OPENED + number;
        // a slider that is dragged, or a program that means harm
        studio.request(PeerId(0), &Request::WheelSpeed { rpm: (number * 37 % 300) as f32 });
        studio.request(PeerId(0), &clay_request(0.1 * (1 + number % 7) as f32));
        if number % 20 == 0 {
            let wheel = told_wheel(&mut studio, 100 + number);
            for &(tick, phase) in &known {
                assert_eq!(wheel.phase(tick), phase, "the phase of {tick} was another before {now}");
            }
            known.push((Tick(now), wheel.phase(Tick(now))));
        }
        studio.advance(now);
    }
    assert_eq!(known.len(), 30);
    // who was there all the time was told of every change, and the wheel stands for both where it does
    let mut wheel = Wheel::starting_at(Tick(first.from), Phase(first.phase), first.rate);
    studio.advance(OPENED + 700);
    for said in &studio.said[&PeerId(0)] {
        if let Said::Notice(Notice::Wheel { from, rate }) = said {
            wheel.schedule(Tick(*from), *rate);
        }
    }
    let (last, newcomers) = (Tick(OPENED + 1500), told_wheel(&mut studio, 1000));
    assert_eq!(wheel.phase(last), newcomers.phase(last));
    assert!(known.iter().all(|&(tick, phase)| wheel.phase(tick) == phase), "it stood otherwise for them");
}

#[test]
fn requests_too_many_are_counted_and_hurt_nobody_else() {
    let mut studio = Studio::with(2);
    let told = |studio: &Studio| studio.said[&PeerId(1)].len();
    let before = told(&studio);
    for _ in 0..100 {
        studio.request(PeerId(0), &Request::WheelSpeed { rpm: 30.0 });
    }
    // forty at once, then twenty a second; all are told the last word alone
    assert_eq!(studio.refusals().requests, 60);
    studio.request(PeerId(1), &Request::WheelSpeed { rpm: 90.0 });
    assert_eq!(studio.refusals().requests, 60);
    studio.advance(OPENED + 20);
    assert_eq!(told(&studio) - before, 1);
    let last = Wheel::rate_of(Rpm(90.0));
    let said = studio.said[&PeerId(1)].last();
    assert!(matches!(said, Some(Said::Notice(Notice::Wheel { rate, .. })) if *rate == last), "{said:?}");
    studio.advance(OPENED + 1000);
    for _ in 0..100 {
        studio.request(PeerId(0), &Request::WheelSpeed { rpm: 30.0 });
    }
    assert!((139..=141).contains(&studio.refusals().requests), "{}", studio.refusals().requests);
    studio.request(PeerId(0), &Request::Leave);
    assert!(studio.said[&PeerId(0)].contains(&Said::Close), "whoever asked too much may still leave");
}

#[test]
fn clay_asked_for_is_told_to_all_and_to_who_comes_later() {
    let mut studio = Studio::with(2);
    let Some(Said::Notice(Notice::Welcome(welcome))) = studio.said[&PeerId(0)].first() else { panic!("not let in") };
    assert_eq!(welcome.clay, [(0, Material::default().into())]);
    studio.request(PeerId(0), &clay_request(0.6));
    studio.request(PeerId(1), &clay_request(0.8));
    studio.advance(OPENED + 20);
    let wanted = Material::from_wetness(Wetness::new(0.8).unwrap());
    let told: Vec<_> = [0, 1].map(|person| studio.said[&PeerId(person)][1..].to_vec()).into();
    let [Said::Notice(Notice::Clay { from, clay })] = told[0][..] else { panic!("{:?}", told[0]) };
    assert_eq!(told[0], told[1], "everybody is told the same");
    // the last word alone, at a common step of changes, in time to be heard before
    assert_eq!(Material::from(clay), wanted);
    assert!(from.is_multiple_of(50) && (OPENED + 200..OPENED + 270).contains(&from), "{from}");
    studio.join(PeerId(2));
    let Some(Said::Notice(Notice::Welcome(welcome))) = studio.said[&PeerId(2)].first() else { panic!("not let in") };
    assert_eq!(welcome.clay.last(), Some(&(from, clay)));
}
