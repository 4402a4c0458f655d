//! A server that leaps: it says what cannot be true now and then, and is honest otherwise.
//!
//! The room is the real one; what is false is put among its messages as they come to one of those who listen, since the line itself cannot be lied on.
//! Invariant under test: what is false is counted, everybody holds the room's clay again soon after, and nobody holds more memory than is said.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod invented;

use std::collections::BTreeMap;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{Material, MethodKind, Pot, PotSpec, Surface, Window};
use pottery_shared::protocol::{
    self, Body, DATAGRAM_MEMORY_MAX, Fragment, FragmentOf, Inputs, KEYFRAME_MAX, Keyframe, Pulse, PulseHead, Request,
    ShapeWire, Sight, SightName, ToolWire, Upload,
};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{Client, ClientEvent, Implausible, WAITING_BYTES_MAX, Watcher};
use pottery_shared::snapshot::{Author, Detail, Moment, TileLayout, Touched, Version};
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};
use pottery_tests::allocations::{Counting, held_bytes};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// Way of everything, ms.
const WAY_MS: u64 = 20;
/// Those who press: the first presses again what was pressed, the second takes deltas. And those who look on, each at another detail.
const POTTERS: u64 = 2;
const LOOKERS: [Detail; 3] = [Detail::RETOLD, Detail::SPECTATOR, Detail::GALLERY];

/// What the server says in one message.
#[derive(Clone, Debug)]
enum Said {
    Datagram(Vec<u8>),
    Control(Vec<u8>),
    Keyframe(Vec<u8>),
}

enum Up {
    Datagram(Vec<u8>),
    Control(Vec<u8>),
}

#[derive(Default)]
struct Looker {
    watcher: Option<Watcher>,
    /// Its last honest datagram.
    last: Option<Sight>,
    unsound: u64,
}

#[derive(Default)]
struct Potter {
    client: Option<Client>,
    last: Option<Pulse>,
    /// Messages that were dropped.
    unsound: u64,
    leapt: u64,
}

struct World {
    room: Room,
    potters: Vec<Potter>,
    lookers: Vec<Looker>,
    down: BTreeMap<(u64, u64), (PeerId, Said)>,
    up: BTreeMap<(u64, u64), (PeerId, Up)>,
    sent: u64,
    /// Datagrams of the first potter do not come through then.
    mute_ms: std::ops::Range<u64>,
}

impl World {
    fn new() -> Self {
        let room = Room::new(RoomConfig {
            code: "CLAY".into(),
            wheels: 1,
            people_max: 8,
            pot: PotSpec::default(),
            method: MethodKind::Plastic,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        });
        let mut world = Self {
            room: room.unwrap(),
            potters: (0..POTTERS).map(|_| Potter::default()).collect(),
            lookers: LOOKERS.map(|_| Looker::default()).into(),
            down: BTreeMap::new(),
            up: BTreeMap::new(),
            sent: 0,
            mute_ms: 0..0,
        };
        for person in 0..POTTERS + LOOKERS.len() as u64 {
            let greeting = match person {
                0..POTTERS => Client::greeting("CLAY", 1, person == 0),
                _ => Watcher::greeting("CLAY", 10_000_000),
            };
            world.up.insert((WAY_MS, person), (PeerId(person), Up::Control(greeting)));
        }
        world
    }

    fn step(&mut self, now: u64, hand: impl Fn(u64, u64) -> Option<Vec3>) {
        self.room.advance(Tick(now));
        while let Some(transmit) = self.room.poll_transmit() {
            let said = match transmit.lane {
                Lane::Datagram(bytes) => Said::Datagram(bytes.into()),
                Lane::Control(bytes) => Said::Control(bytes),
                Lane::Keyframe(bytes) => Said::Keyframe(bytes),
                Lane::Close => panic!("somebody is let go"),
            };
            self.sent += 1;
            self.down.insert((now + WAY_MS, self.sent), (transmit.to, said));
        }
        while let Some(entry) = self.up.first_entry().filter(|entry| entry.key().0 <= now) {
            match entry.remove() {
                (peer, Up::Datagram(bytes)) => self.room.handle_datagram(peer, &bytes),
                (peer, Up::Control(frame)) => self.room.handle_control(peer, &frame[2..]),
            }
        }
        while let Some(entry) = self.down.first_entry().filter(|entry| entry.key().0 <= now) {
            let (peer, said) = entry.remove();
            self.note(peer, &said);
            self.hear(peer, said, now);
        }
        for peer in 0..POTTERS {
            self.press(peer, now, hand(peer, now));
        }
        for (peer, looker) in (POTTERS..).zip(&mut self.lookers) {
            let Some(watcher) = &mut looker.watcher else { continue };
            if now.is_multiple_of(10) {
                watcher.handle_time(Duration::from_millis(now));
            }
            while let Some(frame) = watcher.poll_control() {
                self.sent += 1;
                self.up.insert((now + WAY_MS, self.sent), (PeerId(peer), Up::Control(frame)));
            }
        }
    }

    fn press(&mut self, peer: u64, now: u64, at: Option<Vec3>) {
        let potter = &mut self.potters[peer as usize];
        let Some(client) = &mut potter.client else { return };
        if let Some(point) = at {
            let (tick, centre) = (Tick(0).offset(now as i64 + client.tick_offset()), Position::nearest(point).unwrap());
            let (tool, orientation) = (Tool::default(), Orientation::default());
            client.handle_sample(ToolSample { tick, tool, orientation, centre, side: Side::Outside });
        }
        client.rebase();
        potter.leapt +=
            std::iter::from_fn(|| client.poll_event()).filter(|event| *event == ClientEvent::Leapt).count() as u64;
        let is_time = now % 10 == peer;
        let datagrams = std::iter::from_fn(|| client.poll_datagram(Duration::from_millis(now)).filter(|_| is_time));
        let is_mute = peer == 0 && self.mute_ms.contains(&now);
        let datagrams: Vec<_> =
            if is_time { datagrams.map(Up::Datagram).filter(|_| !is_mute).collect() } else { Vec::new() };
        let frames: Vec<_> = std::iter::from_fn(|| client.poll_control()).map(Up::Control).collect();
        for up in frames.into_iter().chain(datagrams) {
            self.sent += 1;
            self.up.insert((now + WAY_MS, self.sent), (PeerId(peer), up));
        }
    }

    /// Keeps what the room said last to each, to make lies of.
    fn note(&mut self, PeerId(peer): PeerId, said: &Said) {
        let Said::Datagram(bytes) = said else { return };
        match peer {
            0..POTTERS => self.potters[peer as usize].last = protocol::decode::<DATAGRAM_MEMORY_MAX, _>(bytes).ok(),
            _ => self.lookers[(peer - POTTERS) as usize].last = protocol::decode::<DATAGRAM_MEMORY_MAX, _>(bytes).ok(),
        }
    }

    fn hear(&mut self, PeerId(peer): PeerId, said: Said, now: u64) {
        let (time, round_trip) = (Duration::from_millis(now), Duration::from_millis(2 * WAY_MS));
        if peer < POTTERS {
            let potter = &mut self.potters[peer as usize];
            let is_sound = match (said, &mut potter.client) {
                (Said::Datagram(bytes), Some(client)) => client.handle_datagram(&bytes, time),
                (Said::Keyframe(bytes), Some(client)) => client.handle_keyframe(&bytes, time),
                (Said::Control(frame), Some(client)) => client.handle_control(&frame[2..]).is_ok(),
                (Said::Control(frame), client) => {
                    *client = Some(Client::open(&frame[2..], now, round_trip).unwrap());
                    true
                }
                (Said::Datagram(_) | Said::Keyframe(_), None) => true,
            };
            potter.unsound += u64::from(!is_sound);
            return;
        }
        let number = (peer - POTTERS) as usize;
        let looker = &mut self.lookers[number];
        let is_sound = match (said, &mut looker.watcher) {
            (Said::Datagram(bytes), Some(watcher)) => watcher.handle_datagram(&bytes, time),
            (Said::Keyframe(bytes), Some(watcher)) => watcher.handle_keyframe(&bytes, time),
            (Said::Control(frame), Some(watcher)) => watcher.handle_control(&frame[2..]).is_ok(),
            (Said::Control(frame), watcher) => {
                let watcher = watcher.insert(Watcher::open(&frame[2..], round_trip).unwrap());
                watcher.watch(1, LOOKERS[number], time);
                true
            }
            (Said::Datagram(_) | Said::Keyframe(_), None) => true,
        };
        looker.unsound += u64::from(!is_sound);
    }

    fn client(&self, person: usize) -> &Client {
        self.potters[person].client.as_ref().unwrap()
    }

    /// All hold the room's clay, and nothing is missing; `what` happened before.
    fn assert_same(&self, what: &str) {
        let (digest, pot) = (self.room.digest(0).unwrap(), self.room.pot(0).unwrap().digest());
        for person in 0..POTTERS as usize {
            let client = self.client(person);
            assert_eq!(
                (client.replica().digest(), client.predicted().digest()),
                (digest, pot),
                "{what}: potter {person}"
            );
            assert!(client.is_settled(), "{what}: potter {person} at {:?}", client.replica().version());
        }
        let (pot, spec) = (self.room.pot(0).unwrap(), *self.room.pot(0).unwrap().spec());
        for (asked, looker) in LOOKERS.iter().zip(&self.lookers) {
            let watcher = looker.watcher.as_ref().unwrap();
            let sight = watcher.sight(1).unwrap();
            let detail = sight.detail();
            // whose clay came out wrong again and again takes deltas instead
            let shown = if asked.is_retold() && !watcher.keeps_up() { Detail::SPECTATOR } else { *asked };
            assert_eq!(detail, shown, "{what}");
            assert!(!watcher.is_behind(), "{what}: {detail:?} at {:?}", sight.version());
            if detail.grid_of(spec.shape) != spec.shape {
                continue;
            }
            let off = sight.pot().surfaces()[0].radii_m().iter().zip(pot.surfaces()[0].radii_m());
            let off_m = off.map(|(seen, room)| (seen - room).abs()).fold(0.0, f32::max);
            assert!(off_m <= 0.51 * detail.quantum().metres(), "{what}: {detail:?} is off by {off_m} m");
        }
    }

    fn implausible(&self, peer: u64) -> Implausible {
        match peer {
            0..POTTERS => *self.client(peer as usize).implausible(),
            _ => self.lookers[(peer - POTTERS) as usize].watcher.as_ref().unwrap().implausible(),
        }
    }

    fn unsound(&self, peer: u64) -> u64 {
        match peer {
            0..POTTERS => self.potters[peer as usize].unsound,
            _ => self.lookers[(peer - POTTERS) as usize].unsound,
        }
    }
}

/// Two people opposite each other, from 0.4 s on.
fn hand(person: u64, now: u64, until: u64) -> Option<Vec3> {
    if !(400..until).contains(&now) {
        return None;
    }
    let time = (now - 400) as f32 * 1e-3;
    let angle = person as f32 * 3.0;
    let distance = 0.0705 - 0.002 * (time * 2.0).sin().max(0.0);
    let height = 0.06 + 0.03 * (time + person as f32).sin();
    Some(Vec3::new(distance * angle.cos(), distance * angle.sin(), height))
}

/// Tiles of an untouched pot of which some elements are pressed in.
fn wrong_tiles() -> Vec<u8> {
    let mut pot = Pot::new(PotSpec::default()).unwrap();
    let mut author = Author::new(&mut pot);
    let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
    for tile in [7, 200, 433] {
        let Window { first_column, first_row, .. } = TileLayout::new(pot.surfaces()[0].shape()).window(tile);
        let radius_m = pot.surfaces()[0].column_m(first_column)[first_row as usize];
        pot.surfaces_mut()[0].set_radius(first_column, first_row, radius_m - 0.002);
        touched.add(0, tile);
    }
    author.publish(&mut pot, &mut touched, Moment::default()).unwrap();
    author.keyframe(Version(0), false)
}

/// What is false in a pulse, or the body of a sight; each may be several messages.
type Bend = fn(&Body, u32) -> Vec<(Body, u32)>;

/// A body of nothing but its time and version.
fn word(tick: u64, latest: u32) -> Body {
    Body { tick, latest, digest: None, tools: None, fragments: Vec::new() }
}

/// The same of a version that many on, with a piece of another: versions on, number and count.
fn with_piece(body: &Body, on: u32, (of, index, count): (u32, u16, u16)) -> Body {
    let (version, bytes) = (body.latest + of, vec![0x5a; 30]);
    let fragment = Fragment { version, of: FragmentOf::Delta, index, count, bytes };
    Body { fragments: vec![fragment], ..word(body.tick, body.latest + on) }
}

const fn tool() -> ToolWire {
    let (centre, tool) = ([9000, 0, 9000], ShapeWire::Sphere { radius_um: 12_000 });
    ToolWire { client: 0, centre, tool, touching: false, inside: false }
}

/// Name, what is said, and whether it is found out at once.
const LIES: [(&str, Bend, bool); 17] = [
    ("an acknowledgement of samples never made", |body, taken| vec![(body.clone(), taken.wrapping_add(60_000))], true),
    ("half of all numbers acknowledged", |body, taken| vec![(body.clone(), taken.wrapping_add(1 << 30))], true),
    ("the last of all versions", |body, taken| vec![(word(body.tick, u32::MAX), taken)], true),
    ("a version of the next minute", |body, taken| vec![(word(body.tick, body.latest + 4000), taken)], true),
    ("a version of the next seconds", |body, taken| vec![(word(body.tick + 1, body.latest + 300), taken)], true),
    ("a version of long ago", |body, taken| vec![(word(body.tick + 1, 1), taken)], true),
    ("an old word of a newer version", |body, taken| vec![(word(body.tick - 500, body.latest + 1), taken)], true),
    ("the last of all ticks", |body, taken| vec![(Body { tick: u64::MAX, ..body.clone() }, taken)], true),
    ("an hour on", |body, taken| vec![(Body { tick: body.tick + 3_600_000, ..body.clone() }, taken)], true),
    ("an hour on, with more", |body, taken| vec![(word(body.tick + 3_600_000, body.latest + 200_000), taken)], true),
    ("as far on as may be", |body, taken| vec![(word(body.tick + 240, body.latest + 500), taken)], true),
    ("no time at all", |body, taken| vec![(Body { tick: 0, tools: Some(vec![tool()]), ..body.clone() }, taken)], false),
    (
        "back and forth",
        |body, taken| {
            let ticks = [3_600_000, 0, 1 << 40, body.tick - 500, body.tick + 90_000_000];
            ticks.map(|tick| (word(tick, body.latest), taken)).into()
        },
        true,
    ),
    (
        "a piece of a snapshot that there is not yet",
        |body, taken| vec![(with_piece(body, 0, (1000, 0, 1)), taken)],
        true,
    ),
    (
        "the next snapshot in another number of pieces",
        |body, taken| vec![(with_piece(body, 1, (1, 3, 1000)), taken)],
        false,
    ),
    ("a snapshot of other bytes", |body, taken| vec![(with_piece(body, 1, (1, 0, 1)), taken)], false),
    (
        "another digest",
        |body, taken| vec![(Body { digest: Some(1), ..word(body.tick + 1, body.latest) }, taken)],
        false,
    ),
];

#[test]
fn a_false_word_to_one_who_works_or_looks_on_is_counted_and_forgotten() {
    for peer in 0..POTTERS + LOOKERS.len() as u64 {
        for (name, bend, is_seen) in LIES {
            let what = format!("{name} to {peer}");
            let mut world = World::new();
            // three words are waited for, and of a gallery at which nothing happens there is one a second
            let ends = if peer == POTTERS + 2 { 5500 } else { 2100 };
            for now in 0..ends {
                world.step(now, |person, now| hand(person, now, 1000));
                if now != 900 {
                    continue;
                }
                assert_eq!((0..5).map(|peer| world.unsound(peer)).sum::<u64>(), 0, "{what}");
                let lies: Vec<Vec<u8>> = if peer < POTTERS {
                    let Pulse { head, body } = world.potters[peer as usize].last.clone().unwrap();
                    let pulse = |(body, acknowledged)| Pulse { head: PulseHead { acknowledged, ..head.clone() }, body };
                    bend(&body, head.acknowledged)
                        .into_iter()
                        .map(pulse)
                        .map(|pulse| protocol::encode(&pulse))
                        .collect()
                } else {
                    let Sight { name, turning, body } = world.lookers[(peer - POTTERS) as usize].last.clone().unwrap();
                    let sight = |(body, _)| Sight { name, turning: turning.clone(), body };
                    bend(&body, 0).into_iter().map(sight).map(|sight| protocol::encode(&sight)).collect()
                };
                for lie in lies {
                    world.hear(PeerId(peer), Said::Datagram(lie), now);
                }
            }
            world.assert_same(&what);
            let (refused, unsound) = (world.implausible(peer), world.unsound(peer));
            println!("{what}: {refused:?}, {unsound} dropped");
            // one who looks on was told no time, acknowledges nothing, and takes more for possible
            assert!(!is_seen || peer >= POTTERS || refused.total() + unsound > 0, "{what}: {refused:?}");
            assert!(unsound <= 40, "{what}: {unsound} messages were dropped");
            let others = (0..5).filter(|other| *other != peer);
            assert_eq!(others.map(|other| world.unsound(other)).sum::<u64>(), 0, "{what}: somebody else noticed");
            assert_eq!(world.potters.iter().map(|potter| potter.leapt).sum::<u64>(), 0, "{what}");
        }
    }
}

#[test]
fn a_false_keyframe_is_counted_or_mended() {
    type Change = fn(&mut Keyframe);
    let lies: [(&str, Change); 10] = [
        ("of the last version", |keyframe| keyframe.version = u32::MAX),
        ("of a version of the next minute", |keyframe| keyframe.version += 4000),
        ("of a version of the next seconds", |keyframe| keyframe.version += 100),
        ("of the next version", |keyframe| keyframe.version += 1),
        ("of the last tick", |keyframe| keyframe.tick = u64::MAX),
        ("of the last version, as late as can be", |keyframe| (keyframe.version, keyframe.tick) = (u32::MAX, 1 << 48)),
        ("of an hour on", |keyframe| keyframe.tick += 3_600_000),
        ("of samples never made", |keyframe| keyframe.acknowledged += 100_000),
        ("from a version that never was", |keyframe| keyframe.since += 5000),
        ("of another pot", |_| {}),
    ];
    for peer in 0..POTTERS + 2 {
        for (name, change) in lies {
            let what = format!("a keyframe {name} to {peer}");
            let mut world = World::new();
            for now in 0..2700 {
                world.step(now, |person, now| hand(person, now, 1000));
                // while everybody presses, and while nobody does any more
                if now != 900 && now != 1300 {
                    continue;
                }
                let (body, sight) = match peer {
                    0..POTTERS => (world.potters[peer as usize].last.clone().unwrap().body, None),
                    _ => {
                        let Sight { name, body, .. } = world.lookers[(peer - POTTERS) as usize].last.clone().unwrap();
                        (body, Some(name))
                    }
                };
                let Body { tick, latest, .. } = body;
                let (since, acknowledged, goes_on) = (0, 0, false);
                let (version, bytes, mended) = (latest, wrong_tiles(), 0);
                let mut keyframe =
                    Keyframe { version, since, tick: tick + 1, acknowledged, sight, mended, goes_on, bytes };
                change(&mut keyframe);
                world.hear(PeerId(peer), Said::Keyframe(protocol::encode(&keyframe)), now);
            }
            world.assert_same(&what);
            let others = (0..5).filter(|other| *other != peer);
            assert_eq!(others.map(|other| world.unsound(other)).sum::<u64>(), 0, "{what}: somebody else noticed");
            println!("{what}: {:?}, {} dropped", world.implausible(peer), world.unsound(peer));
        }
    }
}

/// A hand whose last samples are lost on the way while the server says that it has them.
#[test]
fn samples_that_were_acknowledged_and_never_came_hold_up_no_later_ones() {
    let mut world = World::new();
    world.mute_ms = 1000..1100;
    let two_strokes = |person: u64, now: u64| hand(person, now, 2000).filter(|_| !(1100..1400).contains(&now));
    for now in 0..3400 {
        world.step(now, two_strokes);
        // all that was made so far, in the middle of what is lost
        if (1040..1100).contains(&now) {
            let Pulse { head, mut body } = world.potters[0].last.clone().unwrap();
            body.tick = now;
            let made = world.client(0).replica().version();
            body.latest = made.0;
            for ahead in (0..100).rev() {
                let head = PulseHead { acknowledged: head.acknowledged + ahead, ..head.clone() };
                let lie = Pulse { head, body: Body { fragments: Vec::new(), tools: None, ..body.clone() } };
                world.hear(PeerId(0), Said::Datagram(protocol::encode(&lie)), now);
            }
        }
    }
    world.assert_same("acknowledged and lost");
    let refused = world.room.counts().refusals.out_of_workspace;
    println!("{:?}, {refused} samples that are none", world.implausible(0));
    assert!((1..=120).contains(&refused), "{refused}");
    // what was pressed after that is in the room's clay
    let pressing = world.potters[0].last.as_ref().unwrap().head.acknowledged;
    assert!(pressing > 1150, "{pressing} samples were taken");
}

#[test]
fn a_server_that_begins_anew_under_an_old_session_is_found_out_within_a_second() {
    let mut world = World::new();
    for now in 0..3600 {
        world.step(now, |person, now| hand(person, now, 1600));
    }
    let now = 20_000;
    let head = PulseHead { acknowledged: 0, slack: None, teacher: None };
    // until then it may be what a newer word has overtaken
    let found_out = 1000_u64.div_ceil(17);
    for number in 0..=found_out + 1 {
        let body = Body { digest: None, ..word(500 + 17 * number, 3) };
        let pulse = Pulse { head: head.clone(), body: body.clone() };
        world.hear(PeerId(0), Said::Datagram(protocol::encode(&pulse)), now + 17 * number);
        world.press(0, now + 17 * number, None);
        assert_eq!(world.potters[0].leapt, u64::from(number >= found_out), "word {number}");
        let name = SightName { wheel: 1, detail: Detail::SPECTATOR.into() };
        let sight = Sight { name, turning: None, body };
        world.hear(PeerId(POTTERS + 1), Said::Datagram(protocol::encode(&sight)), now + 17 * number);
    }
    // who looks on asks for the whole pot, since it follows any clock
    let watcher = world.lookers[1].watcher.as_mut().unwrap();
    watcher.handle_time(Duration::from_millis(now + 1500));
    let asked: Vec<Request> = std::iter::from_fn(|| watcher.poll_control())
        .map(|frame| protocol::decode::<{ protocol::CONTROL_MAX }, _>(&frame[2..]).unwrap())
        .collect();
    assert!(asked.iter().any(|request| matches!(request, Request::Watch { have: 0, .. })), "{asked:?}");
}

#[test]
fn a_request_for_what_never_was_is_refused_and_counted() {
    let mut world = World::new();
    for now in 0..1200 {
        world.step(now, |person, now| hand(person, now, 1000));
    }
    let latest = world.client(0).replica().version().0;
    let before = world.room.counts();
    for (time, have) in (0..).zip([latest + 1, latest + 1000, u32::MAX]) {
        let upload =
            Upload { inputs: Inputs { first: 0, runs: Vec::new(), rests: true }, hand: None, again: Some(have) };
        world.room.handle_datagram(PeerId(0), &protocol::encode(&upload));
        for request in [Request::Resync { have }, Request::Again { have }] {
            world.room.handle_control(PeerId(0), &protocol::encode(&request));
        }
        for now in 1200 + time * 40..1200 + (time + 1) * 40 {
            world.room.advance(Tick(now));
        }
    }
    let counts = world.room.counts();
    assert_eq!((counts.never_were, counts.repeats, counts.resyncs), (9, before.repeats, before.resyncs));
    let is_keyframe = |lane: &Lane| matches!(lane, Lane::Keyframe(_));
    let answers = std::iter::from_fn(|| world.room.poll_transmit()).filter(|transmit| is_keyframe(&transmit.lane));
    assert_eq!(answers.count(), 0);
    // what there is is answered as ever
    world.room.handle_control(PeerId(0), &protocol::encode(&Request::Resync { have: latest }));
    let answers = std::iter::from_fn(|| world.room.poll_transmit()).filter(|transmit| is_keyframe(&transmit.lane));
    assert_eq!((answers.count(), world.room.counts().resyncs), (1, before.resyncs + 1));
}

/// Pieces without an end, of as many snapshots as time allows for.
#[test]
fn unfinished_snapshots_take_no_more_memory_than_is_said() {
    let mut world = World::new();
    for now in 0..1200 {
        world.step(now, |person, now| hand(person, now, 1000));
    }
    let Pulse { head, body } = world.potters[0].last.clone().unwrap();
    let client = world.potters[0].client.as_mut().unwrap();
    let (before, mut most) = (held_bytes(), 0);
    for round in 0..60_000_u32 {
        let version = body.latest + 2 + round % 40;
        let of = if round % 80 < 40 { FragmentOf::Delta } else { FragmentOf::Transcript };
        let piece = Fragment { version, of, index: (round / 80) as u16, count: 1000, bytes: vec![round as u8; 1100] };
        let body = Body { fragments: vec![piece], ..word(body.tick + 1, body.latest + 60) };
        let lie = protocol::encode(&Pulse { head: head.clone(), body });
        client.handle_datagram(&lie, Duration::from_millis(1200));
        while client.poll_control().is_some() {}
        drop(lie);
        most = most.max(held_bytes() - before);
    }
    println!("{most} B of unfinished snapshots, {WAITING_BYTES_MAX} B at most");
    assert!(most > WAITING_BYTES_MAX as i64 / 8 && most <= WAITING_BYTES_MAX as i64, "{most} B");
}

/// The keyframes that lies are made of are what a replica takes, or the tests above would hold for nothing.
#[test]
fn a_keyframe_of_another_pot_is_taken_when_nothing_speaks_against_it() {
    let mut world = World::new();
    for now in 0..1200 {
        world.step(now, |person, now| hand(person, now, 1000));
    }
    let digest = world.client(0).replica().digest();
    let Body { tick, latest, .. } = world.potters[0].last.clone().unwrap().body;
    let (version, bytes) = (latest, wrong_tiles());
    let keyframe = Keyframe { version, since: 0, tick, acknowledged: 0, sight: None, mended: 0, goes_on: false, bytes };
    let bytes = protocol::encode(&keyframe);
    assert!(protocol::decode::<KEYFRAME_MAX, Keyframe>(&bytes).is_ok());
    world.hear(PeerId(0), Said::Keyframe(bytes), 1200);
    assert!(world.client(0).replica().digest() != digest && world.unsound(0) == 0);
}
