//! Tools on their way: what is held, and how it is turned, arrives at the server bit for bit, and a tool that is held
//! still costs no more than a sphere.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::time::Duration;

use pottery_shared::clay::{GridShape, Material, MethodKind, PotSpec};
use pottery_shared::protocol::{self, DATAGRAM_MAX, DATAGRAM_MEMORY_MAX, FrameReader, Inputs, Run, ShapeWire, Upload};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{Client, InputQueue};
use pottery_shared::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample};
use pottery_shared::units::{Metres, Rpm, Tick};
use proptest::prelude::*;

/// A client that was let in.
fn client() -> Client {
    let mut room = Room::new(RoomConfig {
        code: "CLAY".into(),
        wheels: 1,
        people_max: 1,
        pot: PotSpec { shape: GridShape::new(24, 21).unwrap(), ..PotSpec::default() },
        method: MethodKind::Original,
        wheel_speed: Rpm(0.0),
        clay: Material::default(),
    })
    .unwrap();
    let mut reader = FrameReader::default();
    reader.push(&Client::greeting("CLAY", 1, true));
    room.handle_control(PeerId(0), &reader.next_frame().unwrap().unwrap());
    let Some(Lane::Control(welcome)) = room.poll_transmit().map(|transmit| transmit.lane) else { panic!("no welcome") };
    reader.push(&welcome);
    Client::open(&reader.next_frame().unwrap().unwrap(), 0, Duration::ZERO).unwrap()
}

/// Sends samples for consecutive ticks from 1 on; what arrives, and the length of each datagram that it took.
fn sent(samples: &[(Tool, Orientation, [i32; 3], Side)]) -> (Vec<ToolSample>, Vec<usize>) {
    let (mut client, mut queue, mut lengths) = (client(), InputQueue::default(), Vec::new());
    for (tick, &(tool, orientation, centre, side)) in (1..).map(Tick).zip(samples) {
        assert!(client.handle_sample(ToolSample { tick, tool, orientation, centre: Position(centre), side }));
    }
    while let Some(datagram) = client.poll_datagram(Duration::ZERO) {
        assert!(datagram.len() <= DATAGRAM_MAX, "{} bytes", datagram.len());
        lengths.push(datagram.len());
        let Upload { inputs, .. } = protocol::decode::<DATAGRAM_MEMORY_MAX, _>(&datagram).unwrap();
        queue.handle_inputs(&inputs, Tick(0), 4);
    }
    assert_eq!(queue.refusals().total(), 0);
    (std::iter::from_fn(|| queue.take_due(Tick(u64::MAX / 4))).collect(), lengths)
}

fn tool() -> impl Strategy<Value = Tool> {
    prop_oneof![
        (500_u16..40_000).prop_map(|um| Tool::from(Sphere::new(Metres(f32::from(um) * 1e-6)).unwrap())),
        (0_u8..4).prop_map(|shape| Tool::Convex(Shape(shape))),
    ]
}

/// What one stretch of a stroke does: a tool, how it is turned at first and from tick to tick, how it moves, how long.
fn stretch() -> impl Strategy<Value = (Tool, [i16; 3], [i16; 3], [i8; 3], bool, usize)> {
    let turning = prop_oneof![Just([0; 3]), prop::array::uniform3(-40_i16..40), any::<[i16; 3]>()];
    (tool(), any::<[i16; 3]>(), turning, any::<[i8; 3]>(), any::<bool>(), 1_usize..60)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn what_a_hand_holds_arrives_as_it_was(stretches in prop::collection::vec(stretch(), 1..8)) {
        let mut samples = Vec::new();
        let mut centre = [30_000, 0, 10_000];
        for (tool, first, turning, moving, inside, ticks) in stretches {
            let side = if inside { Side::Inside } else { Side::Outside };
            // nothing is said of how a sphere is turned
            let (first, turning) = if tool.sphere().is_some() { ([0; 3], [0; 3]) } else { (first, turning) };
            for tick in 0..ticks {
                let turned = |axis: usize| first[axis].wrapping_add(turning[axis].wrapping_mul(tick as i16));
                samples.push((tool, Orientation([turned(0), turned(1), turned(2)]), centre, side));
                for (along, by) in centre.iter_mut().zip(moving) {
                    *along += i32::from(by);
                }
            }
        }
        let (arrived, _) = sent(&samples);
        prop_assert_eq!(arrived.len(), samples.len());
        for (tick, (found, (tool, orientation, centre, side))) in (1..).map(Tick).zip(arrived.iter().zip(samples)) {
            let expected = ToolSample { tick, tool, orientation, centre: Position(centre), side };
            prop_assert_eq!(found, &expected);
        }
    }
}

#[test]
fn a_rib_that_is_held_still_costs_what_a_sphere_costs_and_a_turning_one_twice_as_much() {
    const SAMPLES: usize = 1000;
    let datagrams = |tool: Tool, turning: i16| {
        let sample = |tick: usize| {
            let angle = 900 + turning * tick as i16;
            (tool, Orientation([angle, -angle, angle / 2]), [8000 + tick as i32, 0, 9000], Side::Outside)
        };
        sent(&(0..SAMPLES).map(sample).collect::<Vec<_>>()).1
    };
    let [sphere, still, turning] = [(Tool::default(), 0), (Tool::Convex(Shape::RIB), 0), (Tool::Convex(Shape::RIB), 3)]
        .map(|(tool, turning)| datagrams(tool, turning));
    let bytes = |datagrams: &[usize]| datagrams.iter().sum::<usize>();
    println!("{SAMPLES} samples: sphere {sphere:?} B, rib {still:?} B, turning rib {turning:?} B");
    // a run's head says the orientation once, in six bytes
    assert_eq!(sphere.len(), still.len());
    assert!(bytes(&still) <= bytes(&sphere) + 6 * still.len());
    // as steady a hand as this one takes a fraction of a bit a sample
    assert!(bytes(&turning) <= 2 * bytes(&sphere), "{turning:?}");
}

/// A hand's steps: at any speed, hardly changing it from one tick to the next.
fn way() -> impl Strategy<Value = Vec<[i16; 3]>> {
    let change = prop::array::uniform3(-2_i16..=2);
    (prop::array::uniform3(-400_i16..400), prop::collection::vec(change, 0..200)).prop_map(|(start, changes)| {
        let mut at = start;
        let go = |change: [i16; 3]| {
            for (along, by) in at.iter_mut().zip(change) {
                *along += by;
            }
            at
        };
        changes.into_iter().map(go).collect()
    })
}

/// What samples of a sphere take that go this way.
fn bytes_of(way: &[[i16; 3]]) -> usize {
    let (tool, steps) = (ShapeWire::Sphere { radius_um: 12_000 }, way.to_vec());
    let run = Run { first_tick: 0, tool, inside: false, start: [0; 3], steps, turns: Vec::new() };
    protocol::encode(&Inputs { first: 0, runs: vec![run], rests: false }).len()
}

proptest! {
    #[test]
    fn a_hand_s_step_takes_a_byte_or_so(way in way()) {
        let bytes = bytes_of(&way);
        // what stands before it, velocities of at most 20 bits, and two bytes a step that changes by two along three axes
        prop_assert!(bytes * 8 <= 160 + 3 * 40 + way.len() * 16, "{bytes} bytes for {} steps", way.len());
    }

    #[test]
    fn steps_of_any_kind_are_never_longer_than_foreseen(way in prop::collection::vec(any::<[i16; 3]>(), 0..100)) {
        let bytes = bytes_of(&way);
        // an Exp-Golomb code of seventeen bits takes 35, of which those that come again are learned
        prop_assert!(bytes * 8 <= 160 + way.len() * 3 * 40, "{bytes} bytes for {} steps", way.len());
    }
}
