//! What a subscription names: quantum, rate, grid and rows, and that it gets that and pays for no more.
//!
//! Invariant under test: what is shown in the rows that were asked for is what was made, however many ask for whatever else.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::time::Duration;

use pottery_shared::clay::{Pot, PotSpec};
use pottery_shared::protocol::{self, DetailWire, SightName};
use pottery_shared::snapshot::{Band, Detail, Quantum};
use pottery_shared::units::Metres;
use pottery_tests::looking::{World, allowed_m, worst_in_m, worst_m};
use proptest::prelude::*;

const PLENTY: u32 = 10_000_000;

fn own(steps: u16, fold: u8, every: u8) -> Detail {
    Detail::new(Quantum::of_steps(steps), fold, every).unwrap()
}

fn band(first: u8, end: u8) -> Band {
    Band::new(first, end).unwrap()
}

#[test]
fn names_are_two_bytes_and_figures_seven_more_at_the_most() {
    let bytes = |wheel, detail: Detail| protocol::encode(&SightName { wheel, detail: detail.into() }).len();
    assert_eq!(Detail::PRESETS.map(|detail| bytes(60, detail)), [2; 3]);
    assert_eq!((bytes(60, own(8, 2, 6)), bytes(60, own(256, 8, 60).in_band(band(4, 9)))), (8, 10));
}

proptest! {
    #[test]
    fn a_detail_is_said_in_one_way_and_nothing_else_is_one(
        quantum in 0_u16..300, fold in 0_u8..10, every in 0_u8..70, (first, end) in any::<(u8, u8)>(), tools in any::<bool>()
    ) {
        let wire = DetailWire::Own { quantum, fold, every, first, end, tools };
        let is_one = (1..=256).contains(&quantum) && (1..=8).contains(&fold) && (1..=60).contains(&every) && first < end;
        let is_named = Detail::PRESETS.iter().any(|preset| {
            !preset.is_retold()
                && (preset.quantum().steps(), preset.fold(), preset.every()) == (quantum, fold.into(), every.into())
                && (preset.shows_tools(), first, end) == (tools, 0, u8::MAX)
        });
        match Detail::try_from(wire) {
            Ok(detail) => {
                prop_assert!(is_one && !is_named);
                prop_assert_eq!(DetailWire::from(detail), wire);
            }
            Err(_) => prop_assert!(!is_one || is_named),
        }
    }

    #[test]
    fn a_picture_gets_the_coarsest_elements_that_are_no_higher_than_a_pixel(
        pixel_um in 10.0_f32..10_000.0, element_um in 100.0_f32..2000.0
    ) {
        let detail = Detail::for_picture(Metres(pixel_um * 1e-6), Metres(element_um * 1e-6));
        let fold = detail.fold() as f32;
        prop_assert!(fold == 1.0 || fold * element_um <= pixel_um);
        prop_assert!(detail.fold() == 8 || 2.0 * fold * element_um > pixel_um);
        // radii are off by less than half of a pixel as well
        let off_um = 0.5 * detail.quantum().metres() * 1e6;
        prop_assert!(detail.fold() == 1 || off_um <= 0.5 * pixel_um, "{} µm", off_um);
        prop_assert_eq!(Detail::try_from(DetailWire::from(detail)), Ok(detail));
    }
}

/// What a hand at the wheel made in so many milliseconds, and how those see it who asked for these details.
fn pressed(details: &[Detail], press_ms: u64) -> (Pot, Vec<Pot>) {
    let mut world = World::new(1, 10, 0.0);
    let peers: Vec<_> = (0..details.len() as u64).map(|number| world.look_on(number, PLENTY)).collect();
    for now in 1..press_ms + 1200 {
        world.step(now, now < press_ms);
        if now == 50 {
            for (peer, detail) in peers.iter().zip(details) {
                world.watcher(*peer).watch(1, *detail, Duration::from_millis(now));
            }
        }
    }
    let made = world.room.pot(0).unwrap().clone();
    (made, peers.into_iter().map(|peer| world.watcher(peer).sight(1).unwrap().pot().clone()).collect())
}

/// The largest distance of an element from the outline that another pot is drawn with, m.
fn worst_outline_m(drawn: &Pot, made: &Pot) -> f32 {
    let (drawn, made) = (&drawn.surfaces()[0], &made.surfaces()[0]);
    let mut worst_m = 0.0_f32;
    for column in (0..made.shape().columns()).step_by(15) {
        let radii = drawn.column_m(column * drawn.shape().columns() / made.shape().columns());
        let line: Vec<_> =
            (0..).map(|row| drawn.row_z_m(row)).zip(radii.iter().copied()).map(glam::Vec2::from).collect();
        for (row, radius_m) in (0..).zip(made.column_m(column)) {
            let point = glam::Vec2::new(made.row_z_m(row), *radius_m);
            let distance = |ends: &[glam::Vec2]| {
                let along = ends[1] - ends[0];
                let share = ((point - ends[0]).dot(along) / along.length_squared()).clamp(0.0, 1.0);
                (point - ends[0] - share * along).length()
            };
            worst_m = worst_m.max(line.windows(2).map(distance).fold(f32::MAX, f32::min));
        }
    }
    worst_m
}

#[test]
fn outline_of_a_pressed_pot_is_within_half_a_pixel_in_every_picture() {
    let element_m = Pot::new(PotSpec::default()).unwrap().surfaces()[0].row_height_m();
    let pixels_m = [1.0_f32, 2.0, 4.0, 8.0].map(|fold| fold * element_m);
    let details = pixels_m.map(|pixel_m| Detail::for_picture(Metres(pixel_m), Metres(element_m)));
    assert_eq!(details.map(Detail::fold), [1, 2, 4, 8]);
    assert_eq!(details[2], Detail::GALLERY);
    let (made, seen) = pressed(&details, 3000);
    for (pixel_m, seen) in pixels_m.iter().zip(&seen) {
        let off_m = worst_outline_m(seen, &made);
        println!("a pixel of {:.2} mm: outline {:.2} of it off", pixel_m * 1e3, off_m / pixel_m);
        assert!(off_m <= 0.5 * pixel_m, "{off_m} m of {pixel_m}");
    }
}

#[test]
fn those_who_ask_for_the_same_share_it_and_their_rows_are_what_was_made() {
    let mut world = World::new(1, 30, 0.1);
    let details =
        [own(8, 2, 6), own(1, 1, 1).with_tools().in_band(band(9, 18)), own(25, 1, 3).in_band(band(16, u8::MAX))];
    let rows = [0..200, 144..288, 256..400];
    let peers: Vec<_> = (0..6).map(|number| world.look_on(number, PLENTY)).collect();
    let mut at_joining = None;
    for now in 1..4500 {
        // the hand rests when the last of them comes
        world.step(now, now < 1450 || (1900..2500).contains(&now));
        for (number, peer) in (0_u64..).zip(&peers) {
            if now == 100 + 300 * number {
                let detail = details[number as usize % 3];
                world.watcher(*peer).watch(1, detail, Duration::from_millis(now));
            }
        }
        if now == 1800 {
            at_joining = Some(world.room.pot(0).unwrap().clone());
        }
    }
    let (made, at_joining) = (world.room.pot(0).unwrap().clone(), at_joining.unwrap());
    for (number, detail) in details.into_iter().enumerate() {
        let held = [number, number + 3].map(|number| {
            let watcher = world.watcher(peers[number]);
            assert!(!watcher.is_behind() && watcher.mismatches() == 0, "{detail:?}");
            let seen = watcher.sight(1).unwrap();
            assert_eq!(seen.detail(), detail);
            let worst = worst_in_m(seen.pot(), &made, rows[number % 3].clone());
            assert!(worst <= allowed_m(detail), "{detail:?}: {worst} m");
            (seen.version(), seen.digest())
        });
        assert_eq!(held[0], held[1], "{detail:?}");
    }
    // rows outside are those of when somebody last came, and not untouched
    let seen = world.watcher(peers[2]).sight(1).unwrap().pot().clone();
    let outside = |made: &Pot| worst_in_m(&seen, made, 64..240);
    println!(
        "outside: {:.0} µm from what was there, {:.0} from what is",
        outside(&at_joining) * 1e6,
        outside(&made) * 1e6
    );
    assert!(outside(&at_joining) <= allowed_m(details[2]) && outside(&made) > 300e-6);
    assert_eq!(world.room.counts().refusals.total(), 0);
}

#[test]
fn one_more_view_than_there_is_room_for_is_refused_and_the_named_one_comes() {
    let mut world = World::new(2, 20, 0.0);
    let peers: Vec<_> = (0..8).map(|number| world.look_on(number, PLENTY)).collect();
    let details = [own(4, 1, 3), own(8, 2, 6), own(32, 8, 24), own(5, 1, 2).with_tools()];
    let (picture, close) = (own(9, 2, 6), Detail::SPECTATOR.in_band(band(3, 9)));
    let mut closely = false;
    for now in 1..3000 {
        world.step(now, now < 2500);
        let time = Duration::from_millis(now);
        match now {
            100 => {
                // at the other wheel there is room of its own
                for (peer, detail) in peers.iter().zip(details) {
                    world.watcher(*peer).watch(1, detail, time);
                    world.watcher(*peer).watch(2, picture, time);
                }
            }
            300 => {
                world.watcher(peers[4]).watch(1, picture, time);
                world.watcher(peers[5]).watch(1, close, time);
                // the same as somebody else has takes no room
                world.watcher(peers[6]).watch(1, details[1], time);
            }
            1000 => closely = world.watcher(peers[5]).sight(1).unwrap().detail() == Detail::SPECTATOR,
            1200 => world.watcher(peers[0]).unwatch(1),
            1400 => world.watcher(peers[5]).watch(1, close, time),
            _ => {}
        }
    }
    assert!(closely);
    let made = world.room.pot(0).unwrap().clone();
    let expected = [(1, details[1]), (2, details[2]), (3, details[3]), (4, Detail::GALLERY), (6, details[1])];
    for (number, detail) in expected {
        let watcher = world.watcher(peers[number]);
        let seen = watcher.sight(1).unwrap();
        assert!(seen.detail() == detail && !watcher.is_behind() && watcher.mismatches() == 0, "{number}");
        assert!(worst_m(seen.pot(), &made) <= allowed_m(detail), "{number}");
    }
    assert_eq!(world.watcher(peers[5]).sight(1).unwrap().detail(), close);
    assert_eq!(world.watcher(peers[0]).sight(2).unwrap().detail(), picture);
    assert_eq!(world.room.counts().refusals.requests, 2);
}

/// Payload of details that are looked at beside each other at a wheel with one hand that never rests, kbit/s.
fn kbit_per_s(details: &[Detail]) -> Vec<f64> {
    let mut world = World::new(1, 5, 0.0);
    world.depth_mm = 2.5;
    let peers: Vec<_> = (0..details.len() as u64).map(|number| world.look_on(number, PLENTY)).collect();
    let mut begun = Vec::new();
    for now in 1..=4100 {
        world.step(now, true);
        if now == 50 {
            for (peer, detail) in peers.iter().zip(details) {
                world.watcher(*peer).watch(1, *detail, Duration::from_millis(now));
            }
        }
        if now == 1100 {
            begun = peers.iter().map(|peer| world.lookers[peer].datagram_bytes).collect();
        }
    }
    let ended = peers.iter().map(|peer| world.lookers[peer].datagram_bytes);
    ended.zip(begun).map(|(ended, begun)| (ended - begun) as f64 * 8.0 / 3000.0).collect()
}

#[test]
fn who_wants_less_is_sent_less() {
    let spectator = Detail::SPECTATOR;
    let details = [
        ("11 µm at 30 Hz", spectator),
        ("31 µm", own(8, 1, 2).with_tools()),
        ("10 Hz", own(3, 1, 6).with_tools()),
        ("31 µm at 10 Hz", own(8, 1, 6).with_tools()),
        ("the upper half", spectator.in_band(band(13, u8::MAX))),
    ];
    let costs = kbit_per_s(&details.map(|(_, detail)| detail));
    let pictures: Vec<_> =
        [0.5, 1.0, 2.0, 4.0].map(|pixel| Detail::for_picture(Metres(pixel * 1e-3), Metres(0.5e-3))).into();
    let sizes = kbit_per_s(&pictures);
    for ((name, _), cost) in details.iter().zip(&costs) {
        println!("{name}: {cost:.1} kbit/s");
    }
    println!("pictures with a pixel of 0.5, 1, 2 and 4 mm: {sizes:.1?} kbit/s");
    // as it was when a wheel was shown in three ways, to which nothing was added
    assert!(costs[0] < 55.5, "{costs:?}");
    assert!(costs[1] < 0.8 * costs[0] && costs[2] < 0.75 * costs[0] && costs[3] < costs[1].min(costs[2]), "{costs:?}");
    // a hand strokes from 60 to 140 mm, so half of the time above the middle
    assert!((0.3..0.75).contains(&(costs[4] / costs[0])), "{costs:?}");
    // each is at least a third cheaper than the next larger
    assert!(sizes.windows(2).all(|two| two[1] < 0.67 * two[0]), "{sizes:?}");
}
