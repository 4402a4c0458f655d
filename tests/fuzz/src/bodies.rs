//! The laws that hold for any bytes, as functions that panic when one does not.
//!
//! Owns how bytes become scripts; uses the core alone. Everything is small, so that millions of runs fit into an hour.
//! Invariant: the same bytes do the same.

use std::time::Duration;

use pottery_shared::clay::{GridShape, Material, MethodKind, Phase, Pot, PotSpec, Surface, Window};
use pottery_shared::protocol::{
    self, CONTROL_MAX, DATAGRAM_MEMORY_MAX, FrameReader, Greeting, Hello, KEYFRAME_MAX, Keyframe, Notice, Pulse,
    Request, Retelling, Sight, Upload,
};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{Client, Peer, Watcher};
use pottery_shared::snapshot::{Author, Detail, Moment, Replica, Touched, Transcript, Version, dequantise, quantise};
use pottery_shared::units::{Rpm, Tick};

const CODE: &str = "CLAY";

/// A grid with tiles that are whole and such that are not.
fn spec() -> PotSpec {
    PotSpec { shape: GridShape::new(44, 37).expect("within the limits"), ..PotSpec::default() }
}

fn pot() -> Pot {
    Pot::new(spec()).expect("the default pot can be made")
}

/// A message that is read from any bytes is read again from what it is written to.
macro_rules! assert_is_read_back {
    ($bytes:expr, $limit:expr, $($message:ty),*) => {
        $(if let Ok(message) = protocol::decode::<{ $limit }, $message>($bytes) {
            let written = protocol::encode(&message);
            let again: $message = protocol::decode::<{ $limit }, _>(&written).expect("what was written is read");
            // floats may be no numbers, which differ from themselves, but their bytes do not
            assert_eq!(protocol::encode(&again), written, "{message:?}");
        })*
    };
}

/// Any bytes as any message, and as a stream that comes in pieces.
pub fn envelope(bytes: &[u8]) {
    assert_is_read_back!(bytes, CONTROL_MAX, Greeting, Hello, Request, Notice, Retelling);
    assert_is_read_back!(bytes, DATAGRAM_MEMORY_MAX, Upload, Pulse, Sight);
    assert_is_read_back!(bytes, KEYFRAME_MAX, Keyframe);
    let (mut whole, mut pieces) = (FrameReader::default(), FrameReader::default());
    whole.push(bytes);
    let frames = |reader: &mut FrameReader| -> Vec<_> { std::iter::from_fn(|| reader.next_frame().ok()?).collect() };
    let at_once = frames(&mut whole);
    let mut one_by_one = Vec::new();
    for piece in bytes.chunks(7) {
        pieces.push(piece);
        one_by_one.extend(frames(&mut pieces));
    }
    assert_eq!(at_once, one_by_one);
}

/// A script out of bytes: an operation, and up to so many bytes for it.
fn script(mut bytes: &[u8]) -> impl Iterator<Item = (u8, &[u8])> {
    std::iter::from_fn(move || {
        let (&[operation, low, high], rest) = bytes.split_first_chunk()?;
        let length = usize::from(u16::from_le_bytes([low, high])).min(rest.len());
        let (own, rest) = rest.split_at(length);
        bytes = rest;
        Some((operation, own))
    })
}

fn touched(pot: &Pot) -> Touched {
    Touched::none(pot.surfaces().iter().map(Surface::shape))
}

/// Deltas and keyframes that strangers wrote: refused whole or taken whole, alike by everybody who takes them.
pub fn tiles(bytes: &[u8]) {
    let detail = |replica: &Replica| (replica.version(), replica.digest(), replica.pot().digest());
    let (mut one, mut other) = (Replica::new(pot()), Replica::new(pot()));
    let mut changed = touched(one.pot());
    for (operation, own) in script(bytes) {
        let before = detail(&one);
        let mut take = |replica: &mut Replica| match operation % 4 {
            0 => {
                let version = Version(replica.version().0 + 1 + u32::from(operation / 128));
                replica.apply_delta(version, own, &mut changed).is_ok()
            }
            _ => {
                let version = Version(replica.version().0 + u32::from(operation / 64));
                let since = if operation % 4 == 1 { Version(0) } else { replica.version() };
                replica.apply_keyframe(version, since, own, operation & 4 == 0, &mut changed).is_ok()
            }
        };
        let is_taken = take(&mut one);
        assert_eq!(is_taken, take(&mut other));
        assert_eq!(detail(&one), detail(&other));
        assert!(is_taken || detail(&one) == before, "a refused message has changed something");
        let (least_m, most_m) = one.pot().surfaces()[0].bounds_m();
        assert!(one.pot().surfaces()[0].radii_m().iter().all(|radius_m| (least_m..=most_m).contains(radius_m)));
    }
}

/// The codec beside a copy of all steps: whatever changes, who follows holds what the copy holds.
pub fn copies(bytes: &[u8]) {
    let mut pot = pot();
    let mut author = Author::new(&mut pot);
    let (columns, rows) = (pot.spec().shape.columns(), pot.spec().shape.rows());
    let mut copy = vec![quantise(pot.surfaces()[0].radii_m()[0]); pot.spec().shape.elements()];
    let (mut follower, mut late) = (Replica::new(self::pot()), Replica::new(self::pot()));
    let (mut pressed, mut changed) = (touched(&pot), touched(&pot));
    let mut tick = Tick(0);
    for (number, (operation, own)) in (0..).zip(script(bytes)) {
        for edit in own.chunks_exact(5) {
            let &[column, row, wide, low, high] = edit else { continue };
            let (column, row) = (u32::from(column) % columns, u32::from(row) % rows);
            let width = (u32::from(wide) % 9 + 1).min(columns - column);
            for column in column..column + width {
                let (least_m, most_m) = pot.surfaces()[0].bounds_m();
                let asked_m = dequantise(u16::from_le_bytes([low, high]));
                pot.surfaces_mut()[0].set_radius(column, row, asked_m.clamp(least_m, most_m));
                pressed.add_window(0, Window { first_column: column, columns: 1, first_row: row, rows: 1 });
                // what a pot can be, rounded as a snapshot rounds it
                let radius_m = pot.surfaces()[0].column_m(column)[row as usize];
                copy[(column * rows + row) as usize] = quantise(radius_m);
            }
        }
        tick = Tick(tick.0 + 1 + u64::from(operation));
        let now = Moment { tick, phase: Phase(u32::from(operation) << 20) };
        let Some(delta) = author.publish(&mut pot, &mut pressed, now) else { continue };
        follower.apply_delta(delta.version, &delta.bytes, &mut changed).expect("the next delta is taken");
        if number % 3 == u32::from(operation) % 3 {
            let have = late.version();
            let keyframe = author.keyframe(have, operation & 1 == 0);
            late.apply_keyframe(author.latest(), have, &keyframe, operation & 1 == 0, &mut changed)
                .expect("a keyframe is taken");
            assert_eq!(late.digest(), author.digest());
        }
        assert_eq!(follower.digest(), author.digest());
        let held = follower.pot().surfaces()[0].radii_m();
        let differs = held.iter().zip(&copy).position(|(radius_m, step)| quantise(*radius_m) != *step);
        assert_eq!(differs, None, "snapshot {}", delta.version);
    }
}

/// Samples that strangers sent: what is pressed is in order and within reach, and what waits is bounded.
pub fn samples(bytes: &[u8]) {
    let mut peer = Peer::default();
    let mut now = Tick(20_000);
    let (mut last, mut acknowledged) = (None, 0);
    for (operation, own) in script(bytes) {
        if let Some(transcript) = Transcript::decode(own, now) {
            assert_eq!(Transcript::decode(&transcript.encode(now), now), Some(transcript));
        }
        peer.handle_datagram(own, now, 4);
        now = Tick(now.0 + u64::from(operation));
        while let Some(sample) = peer.take_due(now) {
            assert!(sample.tick <= now && sample.centre.is_within_reach());
            assert!(last.is_none_or(|last| last < sample.tick), "samples out of order");
            assert!(sample.tool.shape().is_none_or(|shape| shape.0 < 4));
            last = Some(sample.tick);
        }
        let next = peer.inputs().acknowledged();
        assert!((next.wrapping_sub(acknowledged) as i32) >= 0, "an acknowledgement was taken back");
        acknowledged = next;
    }
}

fn room() -> Room {
    let config = RoomConfig {
        code: CODE.into(),
        wheels: 2,
        people_max: 3,
        pot: spec(),
        method: MethodKind::Original,
        wheel_speed: Rpm(60.0),
        clay: Material::default(),
    };
    Room::new(config).expect("the pot can be made")
}

fn frame_of(framed: &[u8]) -> Vec<u8> {
    framed.get(2..).unwrap_or_default().to_vec()
}

/// A room and whatever four peers do: it answers with bounded messages, and its clay stays clay.
pub fn server(bytes: &[u8]) {
    let mut room = room();
    room.advance(Tick(0));
    for (operation, own) in script(bytes) {
        let peer = PeerId(u64::from(operation / 8 % 4));
        match operation % 8 {
            0 => room.handle_control(peer, own),
            1 => room.handle_control(peer, &frame_of(&Client::greeting(CODE, 1 + u16::from(operation / 128), true))),
            2 => room.handle_control(peer, &frame_of(&Watcher::greeting(CODE, 1000))),
            3 | 4 => room.handle_datagram(peer, own),
            5 => room.handle_gone(peer),
            6 => room.handle_loss(peer),
            _ => room.advance(Tick(room.now().0 + u64::from(operation / 4))),
        }
        let mut sent_bytes = 0;
        while let Some(transmit) = room.poll_transmit() {
            sent_bytes += match transmit.lane {
                Lane::Datagram(bytes) => {
                    assert!(bytes.len() <= protocol::DATAGRAM_MAX, "{} bytes", bytes.len());
                    bytes.len()
                }
                Lane::Control(framed) => {
                    assert!(framed.len() <= CONTROL_MAX + 2);
                    framed.len()
                }
                Lane::Keyframe(bytes) => bytes.len(),
                Lane::Close => 0,
            };
        }
        assert!(sent_bytes < 1 << 20, "{sent_bytes} bytes at once");
        assert!(room.people() <= 3);
    }
    for pot in (0..2).filter_map(|wheel| room.pot(wheel)) {
        let (least_m, most_m) = pot.surfaces()[0].bounds_m();
        assert!(pot.surfaces()[0].radii_m().iter().all(|radius_m| (least_m..=most_m).contains(radius_m)));
    }
}

/// The first control frame that a room sends to who greets it so.
fn answer(greeting: &[u8]) -> Vec<u8> {
    let mut room = room();
    room.handle_control(PeerId(1), &frame_of(greeting));
    let first = room.poll_transmit().expect("a greeting is answered");
    let Lane::Control(framed) = first.lane else { unreachable!("the answer is a frame") };
    frame_of(&framed)
}

/// A client, one that works and one that looks on, and whatever a server says: errors and requests, and clay that stays clay.
pub fn client(bytes: &[u8]) {
    let round_trip = Duration::from_millis(40);
    let welcome = answer(&Client::greeting(CODE, 1, true));
    let mut client = Client::open(&welcome, 0, round_trip).expect("a room's welcome is taken");
    let mut watcher = Watcher::open(&answer(&Watcher::greeting(CODE, 1000)), round_trip).expect("and so is this");
    watcher.watch(1, Detail::SPECTATOR, Duration::ZERO);
    let mut now = Duration::ZERO;
    for (operation, own) in script(bytes) {
        now += Duration::from_millis(u64::from(operation / 8));
        // what cannot be understood ends the session, which is for the shell to do
        match operation % 8 {
            0 => drop(client.handle_control(own)),
            1 | 2 => drop(client.handle_datagram(own, now)),
            3 => drop(client.handle_keyframe(own, now)),
            4 => drop(watcher.handle_control(own)),
            5 => drop(watcher.handle_datagram(own, now)),
            6 => drop(watcher.handle_keyframe(own, now)),
            _ => watcher.handle_time(now),
        }
        client.rebase();
        while client.poll_event().is_some() {}
        let asked = std::iter::from_fn(|| client.poll_control()).count();
        let wished = std::iter::from_fn(|| watcher.poll_control()).count();
        assert!(asked + wished < 64, "{asked} and {wished} requests at once");
        drop(client.poll_datagram(now));
    }
    let (least_m, most_m) = client.predicted().surfaces()[0].bounds_m();
    assert!(client.predicted().surfaces()[0].radii_m().iter().all(|radius_m| (least_m..=most_m).contains(radius_m)));
}
