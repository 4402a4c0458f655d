//! Time of the hand's whole tick: sample, proxy, contact, coupling, passivity, limit, queueing.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench haptic_tick`.

use std::time::Instant;

use glam::Vec3;
use pottery_client::HapticLoop;
use pottery_client::boundary::boundary;
use pottery_client::device::Device;
use pottery_shared::clay::{Conditions, MethodKind, Phase, Pot, PotSpec, Wheel};
use pottery_shared::haptics::{DeviceSpecs, Setup};
use pottery_shared::prediction::{Field, Patch};
use pottery_shared::tool::{Sphere, Tool};
use pottery_shared::units::{Metres, Rpm, Tick};

const TICKS: u64 = 20_000;
/// Times that the same ticks are done: they are the same work each time, so that what differs is the machine's doing.
const RUNS: usize = 5;
/// A palm.
const TOOL_MM: f32 = 30.0;

/// A device that goes up and down a wall, pressed in deep.
struct Pressed {
    depth_m: f32,
}

impl Device for Pressed {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        let height_m = 0.1 + 0.04 * (seconds as f32 * 1.3).sin();
        Some(Vec3::new(0.060 + TOOL_MM * 1e-3 - self.depth_m, 0.0, height_m))
    }

    fn tool(&self) -> Tool {
        Sphere::new(Metres::from_mm(TOOL_MM)).expect("the tool is in range").into()
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        // strong enough to press a palm's contact, which no small device is
        DeviceSpecs { peak_force_n: 100.0, continuous_force_n: None, ..DeviceSpecs::OMNI }
    }

    fn setup(&self, _: f32) -> Setup {
        Setup { felt_share: 0.2, ..Setup::for_device(self.specs(), 1.0) }
    }
}

fn main() {
    println!(
        "p50, p99, p99.9 and max are of all ticks of {RUNS} runs; own_p99.9 takes of each tick the median of the runs, which leaves"
    );
    println!("out what interrupted one of them.");
    println!("grid       depth_mm elements_p50 tick_us_p50 tick_us_p99 tick_us_p99.9 own_p99.9 tick_us_max");
    for depth_mm in [5.0, 15.0, 25.0, 35.0] {
        let runs: Vec<_> = (0..RUNS).map(|_| run(depth_mm)).collect();
        let elements = sorted(runs[0].iter().map(|(_, elements)| *elements));
        let all_us = sorted(runs.iter().flatten().map(|(us, _)| *us));
        let own_us = sorted((0..TICKS as usize).map(|tick| at(&sorted(runs.iter().map(|run| run[tick].0)), 0.5)));
        let shape = PotSpec::default().shape;
        println!(
            "{:>4} × {:<3} {depth_mm:>8} {:>13} {:>11.1} {:>11.1} {:>13.1} {:>9.1} {:>11.1}",
            shape.columns(),
            shape.rows(),
            at(&elements, 0.5),
            at(&all_us, 0.5),
            at(&all_us, 0.99),
            at(&all_us, 0.999),
            at(&own_us, 0.999),
            at(&all_us, 1.0),
        );
    }
}

fn sorted(figures: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut figures: Vec<f64> = figures.collect();
    figures.sort_by(f64::total_cmp);
    figures
}

fn at(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

/// Of every tick how long it took, µs, and how many elements it touched.
fn run(depth_mm: f32) -> Vec<(f64, f64)> {
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0)));
    let conditions = Conditions { wheel, method: MethodKind::Plastic, ..Conditions::default() };
    let pot = Pot::new(PotSpec::default()).expect("the default pot can be made");
    let (side, mut net) =
        boundary(&Patch { field: Field::new(pot, Tick(0)), conditions, rack: pottery_shared::tool::rack::standard() });
    let mut hand = HapticLoop::new(Box::new(Pressed { depth_m: depth_mm * 1e-3 }), side);
    let ticks = (1..=TICKS).map(|local| {
        let begin = Instant::now();
        hand.tick(local);
        let us = begin.elapsed().as_secs_f64() * 1e6;
        while net.next_sample().is_some() {}
        (us, f64::from(net.status().elements()))
    });
    ticks.collect()
}
