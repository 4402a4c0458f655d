//! A pot that nobody touches costs nothing: no element is visited, no tile looked at, nothing sent of it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::cell::Cell;

use glam::Vec3;
use pottery_shared::clay::{
    Contact, Footprint, Material, Method, MethodKind, Phase, Pot, PotSpec, Press, SubStep, Surface,
};
use pottery_shared::protocol::{self, FrameReader, Inputs, Pulse, Run, ShapeWire, Upload};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::Client;
use pottery_shared::snapshot::{Author, Moment, Touched, Version};
use pottery_shared::tool::Sphere;
use pottery_shared::units::{Rpm, Tick};

/// The studio's own method, and how often it was asked.
struct Counted<'a>(&'a Cell<u32>);

impl Method for Counted<'_> {
    fn press(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        self.0.set(self.0.get() + 1);
        MethodKind::Plastic.press(pot, press, footprint)
    }
}

/// A thousand steps of a pot under the same presses, and its snapshots: how often the method was asked.
fn asked_in_a_second(presses: &[Press]) -> u32 {
    let mut pot = Pot::new(PotSpec::default()).unwrap();
    let mut author = Author::new(&mut pot);
    let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
    let mut substep = SubStep::for_grid(pot.spec().shape);
    let (before, asked) = (pot.digest(), Cell::new(0));
    for step in 0..1000 {
        let contacts = substep.advance(&mut pot, presses, Counted(&asked), |surface, window| {
            touched.add_window(surface, window);
        });
        assert!(contacts.iter().all(|contact| contact.elements == 0), "{contacts:?}");
        assert!(touched.is_empty(), "a window was touched at step {step}");
        if step % 17 == 0 {
            let now = Moment { tick: Tick(step), phase: Phase(0) };
            assert!(author.publish(&mut pot, &mut touched, now).is_none(), "a delta at step {step}");
        }
    }
    assert_eq!((author.latest(), pot.digest()), (Version(0), before));
    asked.get()
}

#[test]
fn step_without_a_tool_asks_no_method() {
    assert_eq!(asked_in_a_second(&[]), 0);
}

#[test]
fn tool_in_the_air_touches_no_element() {
    let tool = Sphere::default();
    let beside = Press::held(tool, Vec3::new(0.06 + tool.radius().0 + 0.001, 0.0, 0.1));
    let above = Press::held(tool, Vec3::new(0.06, 0.0, 0.2 + tool.radius().0 + 0.001));
    assert_eq!(asked_in_a_second(&[beside, above]), 2000);
}

/// A wheel that turns, with nobody at it.
fn wheel() -> Room {
    Room::new(RoomConfig {
        code: "CLAY".into(),
        wheels: 1,
        people_max: 8,
        pot: PotSpec::default(),
        method: MethodKind::Plastic,
        wheel_speed: Rpm(60.0),
        clay: Material::default(),
    })
    .unwrap()
}

fn sit_down(room: &mut Room, peer: PeerId) {
    let mut reader = FrameReader::default();
    reader.push(&Client::greeting("CLAY", 1, true));
    room.handle_control(peer, &reader.next_frame().unwrap().unwrap());
}

/// The pulses to one of the people since the last time.
fn pulses(room: &mut Room, of: PeerId) -> Vec<Pulse> {
    let mut pulses = Vec::new();
    while let Some(transmit) = room.poll_transmit() {
        match transmit.lane {
            Lane::Datagram(bytes) if transmit.to == of => {
                let pulse: Pulse = protocol::decode::<{ protocol::DATAGRAM_MEMORY_MAX }, _>(&bytes).unwrap();
                assert_eq!((pulse.body.latest, pulse.body.fragments.len()), (0, 0), "{pulse:?}");
                pulses.push(pulse);
            }
            Lane::Keyframe(_) => unreachable!("a keyframe that nobody asked for"),
            Lane::Datagram(_) | Lane::Control(_) | Lane::Close => {}
        }
    }
    pulses
}

/// Somebody sits at a turning wheel and does nothing: pulses go on, after half a second a quarter as many, and nothing of the clay is in them.
#[test]
fn room_sends_nothing_of_a_pot_that_nobody_touches() {
    let mut room = wheel();
    sit_down(&mut room, PeerId(0));
    let before = room.digest(0).unwrap();
    let mut count = 0;
    for tick in 0..2500 {
        room.advance(Tick(tick));
        count += pulses(&mut room, PeerId(0)).len();
    }
    // thirty and some, and then fifteen a second
    assert!((58..=64).contains(&count), "{count} pulses in two seconds and a half");
    assert_eq!(room.digest(0), Some(before));
}

/// A tool that rests in the air says so four times a second: others go on seeing it, and are told as rarely as of nothing. Where it
/// moves, they are told with every pulse from the first on.
#[test]
fn tool_that_rests_is_seen_and_costs_as_little_as_none() {
    let mut room = wheel();
    for peer in [PeerId(0), PeerId(1)] {
        sit_down(&mut room, peer);
    }
    let mut counts = [0; 4];
    for tick in 0..4000_u64 {
        let has_moved = tick >= 3000;
        if has_moved || tick.is_multiple_of(250) {
            let place = [10_000, if has_moved { (tick - 2999) as i32 } else { 0 }, 10_000];
            let run = Run {
                first_tick: (tick + 6) as u16,
                tool: ShapeWire::Sphere { radius_um: Sphere::default().micrometres() },
                inside: false,
                start: place,
                steps: Vec::new(),
                turns: Vec::new(),
            };
            let number = if has_moved { 12 + tick - 3000 } else { tick / 250 } as u16;
            let inputs = Inputs { first: number, runs: vec![run], rests: false };
            let upload = Upload { inputs, hand: None, again: None };
            room.handle_datagram(PeerId(1), &protocol::encode(&upload));
        }
        room.advance(Tick(tick));
        for pulse in pulses(&mut room, PeerId(0)) {
            let tools = pulse.body.tools.unwrap();
            assert!(tick < 20 || tools.len() == 1, "tick {tick}: {tools:?}");
            counts[(tick / 1000) as usize] += 1;
        }
    }
    let [_, one, two, moving] = counts;
    assert!((14..=16).contains(&one) && (14..=16).contains(&two) && moving >= 59, "{counts:?}");
}
