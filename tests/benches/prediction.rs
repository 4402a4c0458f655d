//! What the network thread of a hand takes for its prediction, over shorter and longer lines: where confirmed clay that is as predicted is left, and where
//! everything unconfirmed is pressed on it again, as while somebody else presses there too.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench prediction`.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_shared::clay::{Conditions, GridShape, MethodKind, Phase, Pot, PotSpec, SubStep, Support, Surface, Wheel};
use pottery_shared::prediction::Predictor;
use pottery_shared::snapshot::{Author, Delta, Moment, Replica, SnapshotClock, Touched};
use pottery_shared::tool::{Orientation, Position, Shape, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};

/// Milliseconds of a run, and from which on they count.
const ENDS: u64 = 4000;
const WARM: u64 = 1000;

fn sample(tick: u64, is_rib: bool) -> ToolSample {
    let seconds = tick as f32 * 1e-3;
    let distance_mm = if is_rib { 80.0 } else { 71.5 } - 1.5 * (seconds * 2.0).sin().abs();
    let at_mm = Vec3::new(distance_mm, 0.0, 90.0 + 20.0 * seconds.sin());
    ToolSample {
        tick: Tick(tick),
        tool: if is_rib { Tool::Convex(Shape::RIB) } else { Tool::default() },
        orientation: Orientation::default(),
        centre: Position::nearest(at_mm * 1e-3).expect("a place beside the pot"),
        side: Side::Outside,
    }
}

/// Microseconds a tick of prediction, without the press of the newest sample, so many milliseconds after it was pressed by the author.
fn run(support: Support, is_rib: bool, delay: u64, is_pressed_again: bool) -> f64 {
    let spec = PotSpec { shape: GridShape::PAPER, support, ..PotSpec::default() };
    let mut pot = Pot::new(spec).expect("the pot can be made");
    let mut author = Author::new(&mut pot);
    let mut replica = Replica::new(Pot::new(spec).expect("the pot can be made"));
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0)));
    let conditions = Conditions { wheel, method: MethodKind::Plastic, ..Conditions::default() };
    let none = Touched::none(pot.surfaces().iter().map(Surface::shape));
    let (clock, mut substep, mut touched) = (SnapshotClock::default(), SubStep::for_grid(spec.shape), none.clone());
    let mut predictor = Predictor::new(&replica, Tick(0), clock);
    let (mut last, mut words, mut changed) = (None, VecDeque::<(Tick, Option<Delta>)>::new(), none.clone());
    let mut took = Duration::ZERO;
    for tick in 1..=ENDS {
        let own = sample(tick, is_rib);
        let press = conditions.press(&own, last.as_ref());
        last = Some(own);
        substep.advance(&mut pot, &[press], conditions.method, |surface, window| touched.add_window(surface, window));
        if clock.is_due(Tick(tick)) {
            let now = Moment { tick: Tick(tick), phase: conditions.phase(Tick(tick)) };
            words.push_back((Tick(tick), author.publish(&mut pot, &mut touched, now)));
        }
        predictor.handle_sample(own, &conditions, &mut changed);
        while let Some((at, delta)) = words.pop_front_if(|(at, _)| at.0 + delay <= tick) {
            let mut news = none.clone();
            if let Some(Delta { version, bytes }) = delta {
                replica.apply_delta(version, &bytes, &mut news).expect("the author's next delta");
            }
            if is_pressed_again {
                let rack = predictor.rack();
                predictor.set_rack(rack);
            }
            let begin = Instant::now();
            predictor.handle_confirmed(&replica, at, at.0 as u32, &conditions, &news, &mut changed);
            if tick > WARM {
                took += begin.elapsed();
            }
        }
    }
    took.as_secs_f64() * 1e6 / (ENDS - WARM) as f64
}

fn main() {
    println!("µs a tick that confirmed clay takes a hand which presses alone, 360 x 400 elements, 60 rpm");
    println!("{:<16}{:>10}{:>10}{:>16}", "", "line ms", "left", "pressed again");
    let cases = [
        ("a sphere", Support::Backed, false),
        ("a rib", Support::Backed, true),
        ("a hollow wall", Support::Hollow, false),
    ];
    for (name, support, is_rib) in cases {
        for delay in [10, 50, 100, 200, 400] {
            let [left_us, again_us] = [false, true].map(|again| run(support, is_rib, delay, again));
            println!("{name:<16}{delay:>10}{left_us:>10.2}{again_us:>16.2}");
        }
    }
}
