//! What a hand that never rests sends, over lines that lose and with tools that turn: payload of datagrams, without QUIC's own bytes.
//!
//! Room and session are the real ones, joined by a line with a seed, so that what is said again is said as often as there.
//! Invariant under test: the 60 kbit/s that the project has set itself.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{GridShape, Material, MethodKind, PotSpec};
use pottery_shared::protocol::{self, Upload};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::Client;
use pottery_shared::tool::{Orientation, Position, Shape, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};
use pottery_tests::dice::Dice;
use pottery_tests::line::{Line, Quality};
use pottery_tests::simulation::BURSTS;

/// What was set, kbit/s.
const UP: f64 = 60.0;
/// Ticks before and in which bytes are counted, and in which nobody presses any more.
const WARM: u64 = 2_000;
const COUNTED: u64 = 20_000;
const QUIET: u64 = 3_000;

/// From little that is lost to more than there will be.
const LINES: [(&str, Quality); 6] = [
    ("lan", Quality::LAN),
    ("school-wifi", Quality::SCHOOL_WIFI),
    ("home", Quality::HOME),
    ("intercontinental", Quality::INTERCONTINENTAL),
    ("awful", Quality::AWFUL),
    ("bursts", BURSTS),
];

enum Parcel {
    Up(Vec<u8>),
    Down(Vec<u8>),
}

/// A tremor of so many millimetres and thousandths of a turn beside what the hand means to do: none goes as smoothly as a sine.
fn sample(tick: Tick, now: u64, is_rib: bool) -> ToolSample {
    let time = now as f32 * 1e-3;
    let shake = [(time * 57.0).sin() + 0.4 * (time * 131.0).sin(), (time * 63.0).cos(), (time * 49.0).sin()];
    let out = if is_rib { 0.009 } else { 0.0 };
    let distance = 0.0715 + out - 0.0015 * (time * 2.0).sin().abs();
    let angle = 0.2 * (time * 0.7).sin();
    let at = Vec3::new(distance * angle.cos(), distance * angle.sin(), 0.09 + 0.03 * time.sin());
    let centre = Position::nearest(at + Vec3::from_array(shake) * 0.05e-3).unwrap();
    let turned_rad = [0.3 * (3.0 * time).sin(), 0.1 * (2.0 * time).cos(), 0.2 * time.sin()];
    let orientation = if is_rib {
        Orientation::nearest([0, 1, 2].map(|about| turned_rad[about] + 0.004 * shake[about])).unwrap()
    } else {
        Orientation::default()
    };
    let tool = if is_rib { Tool::Convex(Shape::RIB) } else { Tool::default() };
    ToolSample { tick, tool, orientation, centre, side: Side::Outside }
}

/// What a hand sends over a line, kbit/s, and the share of its samples that are said again.
fn upstream(seed: u64, quality: Quality, is_rib: bool) -> (f64, f64) {
    let mut room = Room::new(RoomConfig {
        code: "CLAY".into(),
        wheels: 1,
        people_max: 1,
        // a coarse one: what a hand sends tells nothing of the clay
        pot: PotSpec { shape: GridShape::new(90, 100).unwrap(), ..PotSpec::default() },
        method: MethodKind::Plastic,
        wheel_speed: Rpm(60.0),
        clay: Material::default(),
    })
    .unwrap();
    let peer = PeerId(0);
    room.handle_control(peer, &Client::greeting("CLAY", 1, true)[2..]);
    let Lane::Control(welcome) = room.poll_transmit().unwrap().lane else { panic!("no welcome") };
    let mut client = Client::open(&welcome[2..], 0, (quality.latency + quality.jitter / 2) * 2).unwrap();
    let (mut up, mut down) = (Line::new(quality, Dice::new(seed)), Line::new(quality, Dice::new(seed + 1000)));
    let mut parcels: BTreeMap<(Duration, u64), Parcel> = BTreeMap::new();
    let (mut sent, mut bytes_up, mut said, mut made) = (0_u64, 0_usize, 0_u64, 0_u64);
    for now in 0..WARM + COUNTED + QUIET {
        let time = Duration::from_millis(now);
        while let Some(entry) = parcels.first_entry().filter(|entry| entry.key().0 <= time) {
            match entry.remove() {
                Parcel::Up(bytes) => room.handle_datagram(peer, &bytes),
                Parcel::Down(bytes) => {
                    client.handle_datagram(&bytes, time);
                }
            }
        }
        room.advance(Tick(now));
        let is_counted = (WARM..WARM + COUNTED).contains(&now);
        if now < WARM + COUNTED {
            let tick = Tick(0).offset(now as i64 + client.tick_offset());
            made += u64::from(client.handle_sample(sample(tick, now, is_rib)) && is_counted);
        }
        client.rebase();
        while let Some(frame) = client.poll_control() {
            room.handle_control(peer, &frame[2..]);
        }
        while now.is_multiple_of(10)
            && let Some(bytes) = client.poll_datagram(time)
        {
            if is_counted {
                bytes_up += bytes.len();
                let upload: Upload = protocol::decode::<{ protocol::DATAGRAM_MEMORY_MAX }, _>(&bytes).unwrap();
                said += upload.inputs.runs.iter().map(|run| 1 + run.steps.len() as u64).sum::<u64>();
            }
            for arrival in up.carry(time, bytes.len()) {
                sent += 1;
                parcels.insert((arrival, sent), Parcel::Up(bytes.clone()));
            }
        }
        while let Some(transmit) = room.poll_transmit() {
            match transmit.lane {
                Lane::Datagram(bytes) => {
                    for arrival in down.carry(time, bytes.len()) {
                        sent += 1;
                        parcels.insert((arrival, sent), Parcel::Down(bytes.to_vec()));
                    }
                }
                Lane::Control(frame) => client.handle_control(&frame[2..]).unwrap(),
                Lane::Keyframe(bytes) => assert!(client.handle_keyframe(&bytes, time)),
                Lane::Close => panic!("let go"),
            }
        }
    }
    assert!(client.is_settled() && client.replica().digest() == room.digest(0).unwrap(), "seed {seed}");
    assert_eq!(room.counts().refusals.total(), 0, "seed {seed}");
    (bytes_up as f64 * 8.0 / COUNTED as f64, said as f64 / made as f64)
}

#[test]
fn a_hand_sends_what_was_set_over_every_line_with_every_tool() {
    for (name, quality) in LINES {
        for is_rib in [false, true] {
            let found = [1, 2, 3].map(|seed| upstream(seed, quality, is_rib));
            let held = if is_rib { "a rib that turns" } else { "a sphere" };
            println!("{name}, {held}: {found:.1?} kbit/s and times that each sample is said");
            // what is not acknowledged yet is said again
            assert!(found.iter().all(|(_, times)| *times > 2.0), "{name}, {held}: {found:?}");
            assert!(found.iter().all(|(kbit_s, _)| *kbit_s <= UP), "{name}, {held}: {found:?}");
        }
    }
}
