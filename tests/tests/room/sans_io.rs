//! A room and its clients joined in one process, over virtual time and a lossy, reordering, duplicating wire.
//!
//! No socket and no runtime: what one end polls is handed to the other after a seeded delay.
//! Invariant under test: whatever the wire does to datagrams, all ends hold the same clay after a quiet time.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{Material, MethodKind, Pot, PotSpec, Preset, Support, Wetness};
use pottery_shared::protocol::{self, FrameReader, Pulse, Request};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{Client, ClientEvent};
use pottery_shared::snapshot::SnapshotClock;
use pottery_shared::tool::{Orientation, Position, Shape, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};

/// splitmix64: enough for a test's dice.
struct Dice(u64);

impl Dice {
    fn roll(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut bits = self.0;
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        bits ^ (bits >> 31)
    }
    fn percent(&mut self, chance: u64) -> bool {
        self.roll() % 100 < chance
    }
}

/// Whether a person presses again what was pressed.
const fn retells(person: u64) -> bool {
    person.is_multiple_of(2)
}

/// Nearer to the axis a tool works from inside.
const INSIDE_M: f32 = 0.05;

struct Wire {
    delay_ms: u64,
    jitter_ms: u64,
    loss_percent: u64,
    duplicate_percent: u64,
}

enum Parcel {
    ToServer(PeerId, Vec<u8>),
    ControlToServer(PeerId, Vec<u8>),
    ToClient(PeerId, Vec<u8>),
    ControlToClient(PeerId, Vec<u8>),
    KeyframeToClient(PeerId, Vec<u8>),
}

struct World {
    room: Room,
    clients: BTreeMap<PeerId, (Option<Client>, FrameReader)>,
    parcels: BTreeMap<(u64, u64), Parcel>,
    sent: u64,
    /// Where everybody sits.
    wheel: u16,
    wire: Wire,
    dice: Dice,
    corrections_um: Vec<f32>,
    down_bytes: u64,
    up_bytes: u64,
    /// What a person holds at a time, and how.
    held: fn(u64, u64) -> (Tool, Orientation),
    /// What a person's own clock says at a time of the room's, ms.
    clock: fn(u64, u64) -> u64,
    /// When no datagram reaches a client, and of every so many milliseconds how many in which none reaches the room.
    deaf_ms: std::ops::Range<u64>,
    mute_ms: (u64, u64),
    /// The least time that samples had to spare, in ticks.
    latest: i16,
    /// How often a piece was sent to a client: who, version, number of the piece.
    carried: BTreeMap<(PeerId, u32, u16), u32>,
}

impl World {
    fn new(people: u64, wire: Wire, seed: u64) -> Self {
        Self::of(MethodKind::Improved, people, wire, seed)
    }

    fn of(method: MethodKind, people: u64, wire: Wire, seed: u64) -> Self {
        Self::round(PotSpec::default(), method, people, wire, seed)
    }

    /// People round a pot.
    fn round(pot: PotSpec, method: MethodKind, people: u64, wire: Wire, seed: u64) -> Self {
        Self::at(1, pot, method, people, wire, seed)
    }

    /// People round the pot of a wheel.
    fn at(wheel: u16, pot: PotSpec, method: MethodKind, people: u64, wire: Wire, seed: u64) -> Self {
        let room = Room::new(RoomConfig {
            code: "CLAY".into(),
            wheels: wheel,
            people_max: 8,
            pot,
            method,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        })
        .unwrap();
        let mut world = Self {
            room,
            wheel,
            clients: BTreeMap::new(),
            parcels: BTreeMap::new(),
            sent: 0,
            wire,
            dice: Dice(seed),
            corrections_um: Vec::new(),
            down_bytes: 0,
            up_bytes: 0,
            held: |_, _| (Tool::default(), Orientation::default()),
            clock: |_, now| now,
            deaf_ms: 0..0,
            mute_ms: (1, 0),
            latest: 0,
            carried: BTreeMap::new(),
        };
        for person in 0..people {
            let peer = PeerId(person);
            world.clients.insert(peer, (None, FrameReader::default()));
            // every second person takes the tiles that changed, the others press again what was pressed
            let greeting = Client::greeting("CLAY", wheel, retells(person));
            world.post(0, true, Parcel::ControlToServer(peer, greeting));
        }
        world
    }

    fn post(&mut self, now: u64, reliable: bool, parcel: Parcel) {
        if !reliable && self.dice.percent(self.wire.loss_percent) {
            return;
        }
        let jitter = if reliable { 0 } else { self.dice.roll() % (self.wire.jitter_ms + 1) };
        self.sent += 1;
        self.parcels.insert((now + self.wire.delay_ms + jitter, self.sent), parcel);
    }

    fn post_datagram(&mut self, now: u64, bytes: Vec<u8>, wrap: impl Fn(Vec<u8>) -> Parcel) {
        if self.dice.percent(self.wire.duplicate_percent) {
            self.post(now, false, wrap(bytes.clone()));
        }
        self.post(now, false, wrap(bytes));
    }

    fn step(&mut self, now: u64, hand: impl Fn(u64, u64) -> Option<Vec3>) {
        self.room.advance(Tick(now));
        while let Some(transmit) = self.room.poll_transmit() {
            let to = transmit.to;
            match transmit.lane {
                Lane::Datagram(bytes) => {
                    assert!(bytes.len() <= 1150, "{} bytes", bytes.len());
                    self.down_bytes += bytes.len() as u64;
                    let pulse: Pulse = protocol::decode::<{ protocol::DATAGRAM_MEMORY_MAX }, _>(&bytes).unwrap();
                    self.latest = self.latest.min(pulse.head.slack.unwrap_or_default());
                    for fragment in &pulse.body.fragments {
                        *self.carried.entry((to, fragment.version, fragment.index)).or_default() += 1;
                    }
                    if !self.deaf_ms.contains(&now) {
                        self.post_datagram(now, bytes.into(), |bytes| Parcel::ToClient(to, bytes));
                    }
                }
                Lane::Control(bytes) => self.post(now, true, Parcel::ControlToClient(to, bytes)),
                Lane::Keyframe(bytes) => self.post(now, true, Parcel::KeyframeToClient(to, bytes)),
                Lane::Close => {}
            }
        }
        while let Some(entry) = self.parcels.first_entry() {
            if entry.key().0 > now {
                break;
            }
            let parcel = entry.remove();
            self.deliver(parcel, now);
        }
        let peers: Vec<_> = self.clients.keys().copied().collect();
        for peer in peers {
            let Some((Some(client), _)) = self.clients.get_mut(&peer) else { continue };
            let clock = |now| (self.clock)(peer.0, now);
            let time = Duration::from_millis(clock(now));
            // a clock that is fast makes two ticks of one now and then, a slow one none
            for local in clock(now.saturating_sub(1)) + 1..=clock(now) {
                let tick = Tick(0).offset(local as i64 + client.tick_offset());
                let Some(point) = hand(peer.0, now) else { continue };
                let centre = Position::nearest(point).unwrap();
                let (tool, orientation) = (self.held)(peer.0, now);
                let side = if point.truncate().length() < INSIDE_M { Side::Inside } else { Side::Outside };
                client.handle_sample(ToolSample { tick, tool, orientation, centre, side });
            }
            client.rebase();
            let mut outgoing = Vec::new();
            if now % 10 == peer.0 {
                outgoing.extend(std::iter::from_fn(|| client.poll_datagram(time)));
            }
            while let Some(event) = client.poll_event() {
                if let ClientEvent::Confirmed(correction) = event {
                    self.corrections_um.extend(correction.under_own_tool.map(|metres| metres.0 * 1e6));
                }
            }
            let frames: Vec<_> = std::iter::from_fn(|| client.poll_control()).collect();
            for bytes in outgoing {
                self.up_bytes += bytes.len() as u64;
                if now % self.mute_ms.0 < self.mute_ms.1 {
                    continue;
                }
                self.post_datagram(now, bytes, |bytes| Parcel::ToServer(peer, bytes));
            }
            for frame in frames {
                self.post(now, true, Parcel::ControlToServer(peer, frame));
            }
        }
    }

    fn deliver(&mut self, parcel: Parcel, now: u64) {
        let local = |peer: PeerId| (self.clock)(peer.0, now);
        let time = |peer| Duration::from_millis(local(peer));
        match parcel {
            Parcel::ToServer(peer, bytes) => self.room.handle_datagram(peer, &bytes),
            Parcel::ControlToServer(peer, bytes) => {
                let mut reader = FrameReader::default();
                reader.push(&bytes);
                self.room.handle_control(peer, &reader.next_frame().unwrap().unwrap());
            }
            Parcel::ControlToClient(peer, bytes) => {
                let (client, reader) = self.clients.get_mut(&peer).unwrap();
                reader.push(&bytes);
                while let Some(frame) = reader.next_frame().unwrap() {
                    match client {
                        Some(client) => client.handle_control(&frame).unwrap(),
                        None => {
                            let round_trip = Duration::from_millis(2 * self.wire.delay_ms + self.wire.jitter_ms);
                            *client = Some(Client::open(&frame, local(peer), round_trip).unwrap());
                        }
                    }
                }
            }
            Parcel::ToClient(peer, bytes) => {
                if let Some((Some(client), _)) = self.clients.get_mut(&peer) {
                    assert!(client.handle_datagram(&bytes, time(peer)));
                }
            }
            Parcel::KeyframeToClient(peer, bytes) => {
                if let Some((Some(client), _)) = self.clients.get_mut(&peer) {
                    assert!(client.handle_keyframe(&bytes, time(peer)));
                }
            }
        }
    }

    fn assert_same(&self, seed: u64) {
        for (peer, (client, _)) in &self.clients {
            let client = client.as_ref().unwrap();
            assert_eq!(
                Some(client.replica().digest()),
                self.room.digest(usize::from(self.wheel) - 1),
                "seed {seed}: {peer:?}"
            );
        }
    }

    fn assert_settled(&self, seed: u64) {
        self.assert_same(seed);
        for (peer, (client, _)) in &self.clients {
            let client = client.as_ref().unwrap();
            assert!(client.is_settled(), "seed {seed}: {peer:?} has {:?}", client.replica().version());
            assert_eq!(client.mismatches(), 0, "seed {seed}: {peer:?}");
            let steps = client.step_counts();
            // of a light touch the changed tiles are the shorter, and what was lost comes as tiles too
            let sound = if retells(peer.0) { steps.retold > 30 } else { steps.retold == 0 && steps.deltas > 30 };
            assert!(sound, "seed {seed}: {peer:?} {steps:?}");
            assert_eq!(steps.unlike, 0, "seed {seed}: {peer:?}");
            assert_eq!(
                client.predicted().digest(),
                self.room.pot(usize::from(self.wheel) - 1).unwrap().digest(),
                "seed {seed}: {peer:?}"
            );
        }
    }
}

/// Two people opposite each other, the third over the first.
fn hand(person: u64, now: u64) -> Option<Vec3> {
    if !(400..3400).contains(&now) {
        return None;
    }
    let time = (now - 400) as f32 * 1e-3;
    let angle = person as f32 * 2.2;
    let distance = 0.072 - 0.004 * (time * 2.0).sin().max(0.0);
    let height = 0.1 + 0.03 * (time + person as f32).sin();
    Some(Vec3::new(distance * angle.cos(), distance * angle.sin(), height))
}

#[test]
fn everybody_holds_the_same_clay_after_loss_reorder_and_duplication() {
    for seed in 0..6 {
        let wire = Wire { delay_ms: 20, jitter_ms: 30, loss_percent: 10, duplicate_percent: 5 };
        let mut world = World::new(3, wire, seed);
        for now in 0..4800 {
            world.step(now, hand);
        }
        world.assert_settled(seed);
        let pressed_mm3 = world.room.pot(0).unwrap().pressed_m3() * 1e9;
        assert!(pressed_mm3 > 5_000.0, "seed {seed}: {pressed_mm3} mm³");
        println!("seed {seed}: pressed {pressed_mm3:.0} mm³, down {} B, up {} B", world.down_bytes, world.up_bytes);
    }
}

#[test]
fn clocks_that_are_fast_or_slow_or_elsewhere_end_with_the_same_clay() {
    for (seed, method) in [(0, MethodKind::Plastic), (1, MethodKind::Improved)] {
        let wire = Wire { delay_ms: 20, jitter_ms: 30, loss_percent: 5, duplicate_percent: 2 };
        let mut world = World::of(method, 3, wire, seed);
        // ten times as far off as quartz: 25 ms in the end, more than a sample has to spare; and hours from the room's own time
        world.clock = |person, now| match person {
            0 => now + now / 1_000,
            1 => 9_876_543 + now - now / 1_000,
            _ => 1_234 + now,
        };
        for now in 0..26_500 {
            // strokes, so that there is quiet between for a lead to go back in
            world.step(now, |person, now| hand(person, now % 5_000).filter(|_| now < 24_000));
        }
        world.assert_settled(seed);
        let counts = world.room.counts();
        assert_eq!(counts.refusals.total(), 0, "seed {seed}: {counts:?}");
        let offsets: Vec<_> =
            world.clients.values().map(|(client, _)| client.as_ref().unwrap().tick_offset()).collect();
        println!("seed {seed}, {method:?}: offsets {offsets:?} ms, samples up to {} ms late", -world.latest);
        // the room's time less the own clock's at the end, and a lead of no more than two ways and what is said again
        for (offset, less) in offsets.into_iter().zip([-26, -9_876_517, -1_234]) {
            assert!((0..=2 * 50 + 150).contains(&(offset - less)), "seed {seed}: {offset} ms");
        }
    }
}

#[test]
fn a_line_that_loses_nothing_carries_everything_once() {
    let wire = Wire { delay_ms: 10, jitter_ms: 20, loss_percent: 0, duplicate_percent: 0 };
    let mut world = World::new(2, wire, 5);
    for now in 0..4800 {
        world.step(now, hand);
    }
    world.assert_settled(5);
    let counts = world.room.counts();
    assert_eq!((counts.repeats, counts.resyncs), (0, 0));
    // half of three seconds is pressing, and two are told of it
    assert!(world.carried.len() > 150, "{}", world.carried.len());
    assert!(world.carried.values().all(|&times| times == 1));
}

#[test]
fn what_a_clean_line_lost_is_told_again_and_then_everything_twice() {
    let wire = Wire { delay_ms: 20, jitter_ms: 0, loss_percent: 0, duplicate_percent: 0 };
    let mut world = World::new(2, wire, 6);
    // six pulses, in the middle of pressing
    world.deaf_ms = 1000..1100;
    let mut at_deaf = 0;
    for now in 0..4800 {
        world.step(now, hand);
        if now == 1100 {
            at_deaf = world.carried.keys().map(|(_, version, _)| *version).max().unwrap();
        }
    }
    world.assert_settled(6);
    // each asks with every datagram until the answer is there, a way and back and a pulse later, and is answered every 40 ms
    // of that; no keyframe
    let counts = world.room.counts();
    assert!((2..=4).contains(&counts.repeats) && counts.resyncs == 0, "{counts:?}");
    // before the loss once, but for what was lost; after it was heard of twice: 60 ms later and a way
    // for who presses again and for who takes deltas
    let times = |range: std::ops::Range<u32>, expected: [u32; 2]| {
        for (peer, expected) in (0..).zip(expected) {
            let of = world.carried.iter().filter(|((to, version, _), _)| to.0 == peer && range.contains(version));
            assert!(of.clone().count() > 10 && of.clone().all(|(_, &times)| times == expected), "{range:?} {expected}");
        }
    };
    times(0..at_deaf - 7, [1, 1]);
    let last = world.carried.keys().map(|(_, version, _)| *version).max().unwrap();
    // and the last third of a second more often, when there is nothing else to tell: what was pressed with each of eight pulses
    times(at_deaf + 8..last - 19, [2, 2]);
    times(last - 19..last, [10, 5]);
}

#[test]
fn who_cannot_keep_up_takes_deltas_and_tries_again_later() {
    let wire = Wire { delay_ms: 10, jitter_ms: 0, loss_percent: 0, duplicate_percent: 0 };
    let mut world = World::new(1, wire, 2);
    let mut counts = Vec::new();
    for now in 0..2400 {
        world.step(now, hand);
        let (Some(client), _) = world.clients.get_mut(&PeerId(0)).unwrap() else { continue };
        // half of the first second is spent on clay
        let spent = if now < 1000 { 5 } else { 1 };
        if now % 10 == 0 {
            client.handle_effort(Duration::from_millis(spent), Duration::from_millis(now));
        }
        if now % 800 == 799 {
            counts.push((client.retells(), *client.step_counts()));
        }
    }
    let [(true, first), (false, _), (false, last)] = counts[..] else { panic!("{counts:?}") };
    assert!(first.retold > 15 && last.deltas > 40 && last.unlike == 0, "{counts:?}");
    let (Some(client), _) = world.clients.get_mut(&PeerId(0)).unwrap() else { panic!() };
    client.handle_effort(Duration::ZERO, Duration::from_secs(60));
    assert!(client.retells(), "it never tries again");
    world.assert_same(2);
}

#[test]
fn an_own_stroke_that_nobody_else_touches_needs_no_correction() {
    let wire = Wire { delay_ms: 40, jitter_ms: 0, loss_percent: 0, duplicate_percent: 0 };
    let mut world = World::new(1, wire, 1);
    for now in 0..4200 {
        world.step(now, hand);
    }
    world.assert_settled(1);
    let largest = world.corrections_um.iter().copied().fold(0.0, f32::max);
    assert!(world.corrections_um.len() > 100);
    assert_eq!(largest, 0.0, "largest correction {largest} µm");
}

/// Strokes of a hand, each in and out of the clay, with pauses between.
fn strokes(person: u64, now: u64) -> Option<Vec3> {
    hand(person, now).filter(|_| now % 900 < 760)
}

#[test]
fn an_own_stroke_needs_no_correction_whatever_is_lost_and_late_on_the_way() {
    let lines = [
        (5, 5, 1, (1, 0)),
        (40, 0, 5, (1, 0)),
        (20, 60, 10, (1, 0)),
        (40, 20, 30, (1, 0)),
        (20, 0, 0, (310, 70)),
        (100, 40, 5, (400, 150)),
    ];
    for (seed, (delay_ms, jitter_ms, loss_percent, mute_ms)) in (0..12).zip(lines.iter().cycle()) {
        for method in [MethodKind::Improved, MethodKind::Plastic] {
            let (delay_ms, jitter_ms, loss_percent) = (*delay_ms, *jitter_ms, *loss_percent);
            let wire = Wire { delay_ms, jitter_ms, loss_percent, duplicate_percent: 3 };
            let mut world = World::of(method, 1, wire, seed);
            world.mute_ms = *mute_ms;
            for now in 0..5400 {
                world.step(now, strokes);
            }
            world.assert_settled(seed);
            let corrections = &world.corrections_um;
            let off = corrections.iter().filter(|&&um| um > 0.0).count();
            let largest = corrections.iter().copied().fold(0.0, f32::max);
            println!(
                "seed {seed}, {method:?}, {delay_ms} + {jitter_ms} ms, {loss_percent} % lost, mute {mute_ms:?}: samples up to {} ms late, \
                 {off} of {} corrections, {largest} µm",
                -world.latest,
                corrections.len()
            );
            assert!(corrections.len() > 40 && (mute_ms.1 == 0 || world.latest < -17), "seed {seed}: {}", world.latest);
            assert_eq!(largest, 0.0, "seed {seed}, {method:?}: {off} corrections of up to {largest} µm");
        }
    }
}

#[test]
fn at_every_wheel_an_own_stroke_needs_no_correction_and_no_two_of_eight_are_told_of_at_once() {
    let mut told = Vec::new();
    for wheel in 1..=8 {
        let wire = Wire { delay_ms: 40, jitter_ms: 0, loss_percent: 0, duplicate_percent: 0 };
        let mut world = World::at(wheel, PotSpec::default(), MethodKind::Plastic, 1, wire, 1);
        for now in 0..3000 {
            world.step(now, |person, now| if now < 2500 { hand(person, now) } else { None });
        }
        world.assert_settled(1);
        let largest = world.corrections_um.iter().copied().fold(0.0, f32::max);
        assert!(world.corrections_um.len() > 60 && largest == 0.0, "wheel {wheel}: {largest} µm");
        let (Some(client), _) = &world.clients[&PeerId(0)] else { panic!("nobody at wheel {wheel}") };
        told.push(client.tools_tick().0);
    }
    let clock = |wheel: usize| SnapshotClock::of_wheel(wheel - 1);
    assert!((1..).zip(&told).all(|(wheel, &tick)| clock(wheel).is_due(Tick(tick))), "{told:?}");
    for tick in (1..1000).map(Tick) {
        assert!((1..=8).filter(|&wheel| clock(wheel).is_due(tick)).count() <= 1, "{tick:?}");
    }
}

/// Each person has a tool of facets, sways and leans it, and takes the next one after half of the time.
fn held_tool(person: u64, now: u64) -> (Tool, Orientation) {
    let time = now as f32 * 1e-3;
    let angles_rad = [0.3 * (3.0 * time).sin(), 0.1 * (2.0 * time).cos(), 0.2 * time.sin()];
    let shape = Shape(((person + now / 1900) % 4) as u8);
    (Tool::Convex(shape), Orientation::nearest(angles_rad).unwrap())
}

/// Volume between a pot's wall and the untouched one, mm³: what was pressed away and what rose both count.
fn moved_mm3(pot: &Pot) -> f64 {
    let untouched = Pot::new(*pot.spec()).unwrap();
    let [wall, untouched] = [pot, &untouched].map(|pot| &pot.surfaces()[0]);
    let areas_m2 = wall.radii_m().iter().zip(untouched.radii_m()).map(|(&radius_m, &was_m)| {
        let [radius_m, was_m] = [radius_m, was_m].map(f64::from);
        0.5 * (radius_m * radius_m - was_m * was_m).abs()
    });
    let column_rad = std::f64::consts::TAU / f64::from(pot.spec().shape.columns());
    areas_m2.sum::<f64>() * column_rad * f64::from(wall.row_height_m()) * 1e9
}

/// As [`hand`], and as much farther out as a rib's edge is from its centre than a fingertip's.
fn hand_with_a_rib(person: u64, now: u64) -> Option<Vec3> {
    hand(person, now).map(|place| place + 0.009 * place.with_z(0.0).normalize())
}

#[test]
fn everybody_holds_the_same_clay_whatever_tools_are_turned_in_their_hands() {
    for method in [MethodKind::Original, MethodKind::Plastic] {
        let wire = Wire { delay_ms: 20, jitter_ms: 30, loss_percent: 10, duplicate_percent: 5 };
        let mut world = World::of(method, 3, wire, 3);
        world.held = held_tool;
        let mut seen = [false; 4];
        for now in 0..4800 {
            world.step(now, hand_with_a_rib);
            let (watcher, _) = &world.clients[&PeerId(0)];
            for tool in watcher.as_ref().map_or(&[][..], Client::tools) {
                if let Tool::Convex(shape) = tool.tool {
                    seen[usize::from(shape.0)] |= tool.orientation != Orientation::default();
                }
            }
        }
        world.assert_settled(3);
        let moved_mm3 = moved_mm3(world.room.pot(0).unwrap());
        println!("{method:?}: moved {moved_mm3:.0} mm³, down {} B, up {} B", world.down_bytes, world.up_bytes);
        assert!(moved_mm3 > 500.0, "{method:?}: {moved_mm3} mm³");
        assert_eq!(seen, [true; 4], "{method:?}: tools of others that were seen turned");
    }
}

#[test]
fn an_own_stroke_with_a_rib_that_turns_needs_no_correction() {
    for method in [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic] {
        let wire = Wire { delay_ms: 40, jitter_ms: 0, loss_percent: 0, duplicate_percent: 0 };
        let mut world = World::of(method, 1, wire, 1);
        world.held = |_, now| (Tool::Convex(Shape::RIB), held_tool(0, now).1);
        for now in 0..4200 {
            world.step(now, hand_with_a_rib);
        }
        world.assert_settled(1);
        let largest = world.corrections_um.iter().copied().fold(0.0, f32::max);
        assert!(world.corrections_um.len() > 100);
        assert_eq!(largest, 0.0, "{method:?}: largest correction {largest} µm");
        assert!(world.room.pot(0).unwrap().pressed_m3().abs() * 1e9 > 100.0, "{method:?} pressed nothing");
    }
}

#[test]
fn a_hollow_pot_is_hollow_for_everybody_and_their_clay_the_same() {
    let pressed_mm3 = [Support::Backed, Support::Hollow].map(|support| {
        let wire = Wire { delay_ms: 20, jitter_ms: 30, loss_percent: 10, duplicate_percent: 5 };
        let mut world = World::round(PotSpec { support, ..PotSpec::default() }, MethodKind::Plastic, 3, wire, 1);
        for now in 0..4800 {
            world.step(now, hand);
        }
        world.assert_settled(1);
        for (client, _) in world.clients.values() {
            assert_eq!(client.as_ref().unwrap().predicted().spec().support, support);
        }
        world.room.pot(0).unwrap().pressed_m3() * 1e9
    });
    println!("pressed {pressed_mm3:.0?} mm³, backed and hollow");
    // of a wall that bends away less than half is pressed
    assert!(pressed_mm3[1] < 0.5 * pressed_mm3[0] && pressed_mm3[1] > 0.0, "{pressed_mm3:?} mm³");
}

/// One outside, and from half a second later on a finger opposite, which only stands there.
fn pinch(person: u64, now: u64) -> Option<Vec3> {
    let (begin, distance) = if person == 0 { (400, 0.0715) } else { (900, 0.0401) };
    (begin..3400).contains(&now).then_some(Vec3::new(distance, 0.0, 0.1))
}

#[test]
fn who_presses_a_hollow_wall_reckons_with_a_finger_that_holds_it() {
    let wire = Wire { delay_ms: 20, jitter_ms: 30, loss_percent: 10, duplicate_percent: 5 };
    let spec = PotSpec { support: Support::Hollow, ..PotSpec::default() };
    let mut world = World::round(spec, MethodKind::Plastic, 2, wire, 1);
    let beside = |world: &World, person| {
        let client = world.clients[&PeerId(person)].0.as_ref().unwrap();
        client.patch().field.beside().iter().map(|sample| sample.side).collect::<Vec<_>>()
    };
    for now in 0..4800 {
        world.step(now, pinch);
        match now {
            800 => assert!(beside(&world, 0).is_empty()),
            1500 => assert_eq!((beside(&world, 0), beside(&world, 1)), (vec![Side::Inside], vec![Side::Outside])),
            _ => {}
        }
    }
    world.assert_same(1);
    // nobody holds against it any more
    assert!(beside(&world, 0).is_empty() && beside(&world, 1).is_empty());
}

/// Lets everybody press while the first asks for the wetness of each entry at its time; says what is left of the clay, mm³.
fn press_while_it_gets_wetter(world: &mut World, seed: u64, wetter: &[(u64, f32)]) -> f64 {
    for now in 0..4800 {
        for &(_, index) in wetter.iter().filter(|(at, _)| *at == now) {
            let clay = Material::from_wetness(Wetness::new(index).unwrap()).into();
            let (client, _) = world.clients.get_mut(&PeerId(0)).unwrap();
            client.as_mut().unwrap().request(&Request::Clay { clay });
        }
        world.step(now, hand);
    }
    world.assert_settled(seed);
    for (peer, (client, _)) in &world.clients {
        let material = client.as_ref().unwrap().conditions().material.at(Tick(4800));
        let last = wetter.last().map_or(Preset::Throwing.wetness(), |(_, index)| Wetness::new(*index).unwrap());
        assert_eq!(material, Material::from_wetness(last), "seed {seed}: {peer:?}");
    }
    -world.room.pot(0).unwrap().pressed_m3() * 1e9
}

#[test]
fn clay_that_gets_wetter_under_two_hands_stays_the_same_for_both() {
    let wetter = [(900, 0.6), (1500, 0.05), (1560, 1.0), (2400, 0.45)];
    for (seed, method) in [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic].into_iter().enumerate() {
        let seed = seed as u64;
        let world = || {
            let wire = Wire { delay_ms: 20, jitter_ms: 30, loss_percent: 10, duplicate_percent: 5 };
            World::of(method, 2, wire, seed)
        };
        let left = press_while_it_gets_wetter(&mut world(), seed, &wetter);
        let as_it_was = press_while_it_gets_wetter(&mut world(), seed, &[]);
        println!("{method:?}: {:.0} mm³ less when it gets wetter", as_it_was - left);
        assert!((as_it_was - left).abs() > 1.0, "{method:?}: the wetness changed nothing");
    }
}

#[test]
fn a_wetness_that_changes_in_mid_stroke_needs_no_correction() {
    for method in [MethodKind::Improved, MethodKind::Plastic] {
        let wire = Wire { delay_ms: 40, jitter_ms: 0, loss_percent: 0, duplicate_percent: 0 };
        let mut world = World::of(method, 1, wire, 1);
        press_while_it_gets_wetter(&mut world, 1, &[(900, 0.6), (1500, 0.0), (2400, 1.0)]);
        let largest = world.corrections_um.iter().copied().fold(0.0, f32::max);
        assert!(world.corrections_um.len() > 100);
        assert_eq!(largest, 0.0, "{method:?}: largest correction {largest} µm");
    }
}
