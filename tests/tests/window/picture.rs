//! What is drawn between what is heard: corrections that fade, and other people's tools on their ways.
//!
//! Invariant under test: nothing that is drawn jumps, overshoots or goes back because of the network.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::time::Duration;

use glam::Vec3;
use pottery_client::fade::Fade;
use pottery_client::remote_hands::RemoteHands;
use pottery_shared::clay::{Pot, PotSpec, Surface, Window};
use pottery_shared::session::RemoteTool;
use pottery_shared::snapshot::Touched;
use pottery_shared::tool::{Orientation, Position, Side, Tool};
use pottery_shared::units::Tick;
use pottery_tests::dice::Dice;

const fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

fn no_tiles(pot: &Pot) -> Touched {
    Touched::none(pot.surfaces().iter().map(Surface::shape))
}

fn move_element(pot: &mut Pot, column: u32, row: u32, by_m: f32) -> Touched {
    let radius_m = pot.surfaces()[0].column_m(column)[row as usize];
    pot.surfaces_mut()[0].set_radius(column, row, radius_m + by_m);
    let mut tiles = no_tiles(pot);
    tiles.add_window(0, Window { first_column: column, columns: 1, first_row: row, rows: 1 });
    tiles
}

fn at(pot: &Pot, column: u32, row: u32) -> f32 {
    pot.surfaces()[0].column_m(column)[row as usize]
}

#[test]
fn a_correction_fades_in_and_an_own_press_is_there_at_once() {
    let mut predicted = Pot::new(PotSpec::default()).unwrap();
    let mut fade = Fade::new(&predicted);
    let mut changed = no_tiles(&predicted);
    let nothing = no_tiles(&predicted);
    fade.draw(&predicted, &nothing, ms(1000), &mut changed);
    assert!(changed.is_empty());
    let (old_m, by_m) = (at(&predicted, 40, 50), -0.001_f32);
    let tiles = move_element(&mut predicted, 40, 50, by_m);
    fade.correct(&predicted, &tiles);
    fade.draw(&predicted, &tiles, ms(1004), &mut changed);
    assert!((at(fade.drawn(), 40, 50) - old_m).abs() < 1e-8, "it jumps");
    // the own hand presses beside it, in the same tile, while it fades
    let own = move_element(&mut predicted, 41, 50, -0.0005);
    let mut last_m = old_m;
    let mut left = BTreeMap::new();
    for now in 1005..1400 {
        changed.clear();
        let news = if now == 1020 { &own } else { &nothing };
        fade.draw(&predicted, news, ms(now), &mut changed);
        let drawn_m = at(fade.drawn(), 40, 50);
        assert!(drawn_m <= last_m && drawn_m >= old_m + by_m - 1e-8, "{now}: {drawn_m} m after {last_m} m");
        // 12 ms of 30 at one time, or 13
        assert!(last_m - drawn_m <= 0.36 * -by_m, "{now}: a step of {} mm", (last_m - drawn_m) * 1e3);
        assert_eq!(drawn_m != last_m, !changed.is_empty() && now != 1020, "{now}");
        assert!(now < 1020 || at(fade.drawn(), 41, 50) == at(&predicted, 41, 50), "{now}");
        last_m = drawn_m;
        left.insert(now - 1000, (drawn_m - old_m - by_m) / -by_m);
    }
    // within the 12 ms from one step to the next
    for (after_ms, share) in [(30, 0.368_f32), (100, 0.036)] {
        let found = left[&after_ms];
        let (most, least) = (share * (15.0_f32 / 30.0).exp(), share * (-3.0_f32 / 30.0).exp());
        assert!((least..=most).contains(&found), "{found} of it is left after {after_ms} ms");
    }
    assert_eq!(fade.drawn().digest(), predicted.digest());
}

#[test]
fn corrections_on_corrections_never_jump() {
    let mut predicted = Pot::new(PotSpec::default()).unwrap();
    let mut fade = Fade::new(&predicted);
    let mut changed = no_tiles(&predicted);
    let mut dice = Dice::new(3);
    let mut largest_mm = 0.0_f32;
    for now in 1000..4000 {
        let before_m = at(fade.drawn(), 100, 100);
        let mut news = no_tiles(&predicted);
        if now < 3500 && now % 16 == 0 {
            // somebody presses there, a tenth of a millimetre at a time, and now and then it is taken back
            let by_m = if dice.chance(0.2) { 0.0004 } else { -0.0001 };
            news = move_element(&mut predicted, 100, 100, by_m);
            fade.correct(&predicted, &news);
        }
        fade.draw(&predicted, &news, ms(now), &mut changed);
        largest_mm = largest_mm.max((at(fade.drawn(), 100, 100) - before_m).abs() * 1e3);
    }
    println!("largest step in the picture {largest_mm} mm");
    assert!(largest_mm < 0.3, "{largest_mm} mm");
    assert_eq!(fade.drawn().digest(), predicted.digest());
}

fn tool(x_m: f32) -> RemoteTool {
    let centre = Position::nearest(Vec3::new(x_m, 0.1, 0.1)).unwrap();
    let (tool, orientation, side) = (Tool::default(), Orientation::default(), Side::default());
    RemoteTool { client: 4, tool, orientation, centre, touching: false, side }
}

/// What was drawn of one hand: when, and where, in steps of 10 µm; and where it was at the tick of every pulse that came.
struct Drawn {
    frames: Vec<(u64, i32)>,
    heard: Vec<(u64, i32)>,
}

/// A hand that is told of sixty times a second, over a line of so much jitter and loss, and drawn every 7 ms.
fn drawn(seed: u64, jitter_ms: u64, loss: f64, until_ms: u64, hand: impl Fn(u64) -> f32) -> Drawn {
    let mut dice = Dice::new(seed);
    let mut hands = RemoteHands::default();
    let mut arrivals = BTreeMap::new();
    let mut out = Drawn { frames: Vec::new(), heard: Vec::new() };
    let mut tools = Vec::new();
    for now in 0..until_ms {
        if now * 60 / 1000 != (now + 1) * 60 / 1000 && !dice.chance(loss) {
            let arrival = now + 20 + dice.roll() % (jitter_ms + 1);
            arrivals.insert((arrival, now), tool(hand(now)));
        }
        while let Some(entry) = arrivals.first_entry().filter(|entry| entry.key().0 <= now) {
            let ((_, tick), tool) = entry.remove_entry();
            hands.hear(&[tool], Tick(tick + 1_000_000), ms(now));
            if out.heard.last().is_none_or(|(last, _)| *last < tick) {
                out.heard.push((tick, tool.centre.0[0]));
            }
        }
        if now % 7 == 0 {
            hands.draw(ms(now), &mut tools);
            out.frames.extend(tools.first().map(|tool| (now, tool.centre.0[0])));
        }
    }
    out
}

const LINES: [(u64, f64); 4] = [(0, 0.0), (8, 0.0), (18, 0.025), (60, 0.13)];

#[test]
fn a_hand_that_goes_one_way_is_drawn_going_one_way_and_stops_where_it_stopped() {
    for (jitter_ms, loss) in LINES {
        for seed in 0..4 {
            // a fifth of a metre a second, a stop, and on
            let hand = |now: u64| match now {
                0..1500 => 0.0002 * now as f32 - 0.3,
                1500..2500 => 0.0,
                _ => 0.0002 * (now - 2500) as f32,
            };
            let Drawn { frames, heard } = drawn(seed, jitter_ms, loss, 3500, hand);
            let name = format!("{jitter_ms} ms, {loss}, seed {seed}");
            for two in frames.windows(2) {
                let [(_, before), (now, after)] = two else { continue };
                assert!(after >= before, "{name}: back by {} at {now} ms", before - after);
                // 7 ms at a fifth of a metre a second, by a fifth faster while it is late, and rounded
                assert!(after - before <= 170, "{name}: {} steps at {now} ms", after - before);
            }
            let stopped: Vec<i32> =
                frames.iter().filter(|(now, _)| (2000..2500).contains(now)).map(|(_, x)| *x).collect();
            let last_heard = heard.iter().rev().find(|(tick, _)| *tick < 1900).unwrap();
            assert!(stopped.iter().all(|x| *x == 0) && last_heard.1 == 0, "{name}: {stopped:?}");
        }
    }
}

#[test]
fn a_hand_that_shakes_is_drawn_within_what_was_heard_and_little_later() {
    for (jitter_ms, loss) in LINES {
        for seed in 0..4 {
            let hand = |now: u64| 0.02 * (now as f32 * 0.0063).sin();
            let Drawn { frames, heard } = drawn(seed, jitter_ms, loss, 6000, hand);
            let (least, most) =
                (heard.iter().map(|(_, x)| *x).min().unwrap(), heard.iter().map(|(_, x)| *x).max().unwrap());
            let name = format!("{jitter_ms} ms, {loss}, seed {seed}");
            assert!(frames.iter().all(|(_, x)| (least..=most).contains(x)), "{name}: it overshoots");
            // the delay at which the drawn way fits the real one best
            let misses = |late: u64| {
                let after = frames.iter().filter(|(now, _)| *now > 2000);
                after.map(|(now, x)| (f64::from(*x) - f64::from(hand(now - late)) * 1e5).powi(2)).sum::<f64>()
            };
            let late = (0..400).min_by(|a, b| misses(*a).total_cmp(&misses(*b))).unwrap();
            let rms_mm = (misses(late) / frames.len() as f64).sqrt() * 0.01;
            println!("{name}: drawn {late} ms late, off by {rms_mm:.2} mm");
            // the way of 20 ms, the jitter twice, and as long as the places lost in a row at worst within a second
            let lost_ms = if loss > 0.1 {
                4 * 17
            } else if loss > 0.0 {
                2 * 17
            } else {
                0
            };
            assert!(late <= 20 + 2 * jitter_ms + 2 * 17 + lost_ms, "{name}: {late} ms late");
        }
    }
}

#[test]
fn a_tool_that_was_away_is_not_drawn_on_its_way_back() {
    let mut hands = RemoteHands::default();
    let mut tools = Vec::new();
    let mut seen = Vec::new();
    for now in 0..3000_u64 {
        if now % 16 == 0 {
            let heard: &[RemoteTool] = match now {
                0..1000 => &[tool(-0.1)],
                1000..2000 => &[],
                _ => &[tool(0.1)],
            };
            hands.hear(heard, Tick(now), ms(now + 30));
        }
        hands.draw(ms(now + 30), &mut tools);
        seen.push(tools.first().map(|tool| tool.centre.0[0]));
    }
    seen.dedup();
    assert_eq!(seen, [Some(-10_000), None, Some(10_000)]);
}
