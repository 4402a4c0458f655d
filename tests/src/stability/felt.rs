//! What a hand feels while it holds on: trembling, grit, energy, and what comes of a loop of another rate.
//!
//! Owns the scenarios of a hand that gives way.
//! Invariant: every hand from light to firm is tried, and the worst counts.

use glam::Vec3;
use pottery_shared::clay::MethodKind;
use pottery_shared::haptics::{DeviceSpecs, Haptics, Setup, Touch};
use pottery_shared::units::Seconds;

use super::bench::{Bench, Felt, Scene};
use super::mechanism::{Grip, Mechanism};
use super::plane::{bound_n_m, stable_stiffness_n_m, stages};
use crate::failures::{Scene as Clay, larger, smaller};

/// Delays that are tried, s.
const DELAYS_S: [f64; 4] = [0.0, 1e-3, 2e-3, 5e-3];
/// A light contact, N: a seventh of what an Omni gives, and less than any in which a step of its encoder, 0.055 mm of 0.7 N/mm, could be
/// hidden by much. At 0.3 N the step alone is 13 % of the force, and ours comes to 7 % above 20 Hz.
const LIGHT_N: f64 = 0.5;
/// Less is no contact, N.
const LEAST_N: f64 = 0.01;
/// How far from the clay a hand begins, m.
const AIR_M: f64 = 2e-3;
/// Where forces are told to begin to tremble, Hz.
const TREMOR_HZ: usize = 20;

/// Least stable stiffness of a hand over the bound by theory, at any of the delays.
pub(super) fn stiffness(method: MethodKind, grip: Grip) -> f64 {
    let share = |delay_s| stable_stiffness_n_m(method, grip, delay_s) / bound_n_m(&grip, delay_s);
    DELAYS_S.into_iter().map(share).fold(f64::INFINITY, smaller)
}

/// A hand that means to press with so many newtons for two seconds: as deep as its own stiffness and that of a coupling to an Omni
/// take, whatever it meets.
fn pressing(scene: &Scene, grip: Grip, push_n: f64) -> Vec<Felt> {
    let depth_m = push_n / grip.stiffness_n_m + push_n / f64::from(DeviceSpecs::OMNI.stiffness_max_n_m);
    // the way in takes a quarter of a second
    let meant_m = |seconds: f64| {
        let way_m = (depth_m + AIR_M) * (4.0 * seconds).min(1.0);
        Bench::TOUCHING_M - Vec3::X * (way_m - AIR_M) as f32
    };
    Bench::new(scene).hold(grip, 2000, meant_m)
}

/// Force above 20 Hz over the mean force, in percent, in the second half of a light contact; infinite when no force is left.
pub(super) fn light_contact(method: MethodKind, rpm: f32, resolution_m: f32) -> f64 {
    let mut worst = 0.0_f64;
    for grip in Grip::ALL {
        let mut scene = Scene { rpm, ..Scene::of(method) };
        scene.specs.resolution_m = resolution_m;
        worst = larger(worst, tremor_percent(&pressing(&scene, grip, LIGHT_N)[1000..]));
    }
    worst
}

/// Root of the mean square above [`TREMOR_HZ`] over the mean, in percent, of a second at 1 kHz.
fn tremor_percent(felt: &[Felt]) -> f64 {
    let forces: Vec<f64> = felt.iter().map(|felt| f64::from(felt.force_n.x)).collect();
    let ticks = forces.len() as f64;
    let mean = forces.iter().sum::<f64>() / ticks;
    // Hann's window keeps a slow change out of the high band; its power is 3/8
    let turn = |at: usize, turns: usize| (at * turns) as f64 / ticks * std::f64::consts::TAU;
    let windowed = forces.iter().enumerate().map(|(at, force)| (force - mean) * (0.5 - 0.5 * turn(at, 1).cos()));
    let windowed: Vec<f64> = windowed.collect();
    let all = windowed.iter().map(|force| force * force).sum::<f64>() / ticks;
    let low: f64 = (0..=TREMOR_HZ)
        .map(|hertz| {
            let (mut even, mut odd) = (0.0, 0.0);
            for (at, force) in windowed.iter().enumerate() {
                let (sin, cos) = turn(at, hertz).sin_cos();
                (even, odd) = (even + force * cos, odd + force * sin);
            }
            (even * even + odd * odd) / (ticks * ticks) * if hertz == 0 { 1.0 } else { 2.0 }
        })
        .sum();
    // the published methods let a still hand sink until it feels nothing
    if mean < LEAST_N { f64::INFINITY } else { ((all - low).max(0.0) * 8.0 / 3.0).sqrt() / mean * 100.0 }
}

/// Longest run of ticks in which the force goes up and down by more than a millinewton in turn.
pub(super) fn grit(method: MethodKind) -> f64 {
    const LEAST_N: f32 = 1e-3;
    let mut longest = 0;
    for grip in Grip::ALL {
        let felt = pressing(&Scene::of(method), grip, LIGHT_N);
        let mut run = 0;
        for three in felt[1000..].windows(3) {
            let [before, now, after] = [0, 1, 2].map(|at| three[at].force_n.x);
            let (one, other) = (now - before, after - now);
            run = if one * other < 0.0 && one.abs().min(other.abs()) > LEAST_N { run + 1 } else { 0 };
            longest = longest.max(run);
        }
    }
    f64::from(longest)
}

/// Fastest that a hand is shaken that presses with 1.5 N, mm/s, with one tick of delay, at 0 and 60 rpm.
pub(super) fn shaken(method: MethodKind) -> f64 {
    let mut fastest = 0.0_f64;
    for grip in Grip::ALL {
        for rpm in [0.0, 60.0] {
            let felt = pressing(&Scene { rpm, delay_s: 1e-3, ..Scene::of(method) }, grip, 1.5);
            fastest = felt[1500..].iter().map(|felt| felt.speed_m_s).fold(fastest, larger);
        }
    }
    fastest * 1e3
}

/// Least energy that device and clay have taken from the hand, mJ, over ten presses and releases.
pub(super) fn energy(method: MethodKind) -> f64 {
    let mut least = f64::INFINITY;
    for grip in Grip::ALL {
        for delay_s in [0.0, 2e-3] {
            let depth_m = 2.0 / grip.stiffness_n_m;
            let meant_m = |seconds: f64| {
                let depth_m = depth_m * (0.5 - 0.6 * (seconds * std::f64::consts::TAU * 2.0).cos());
                Bench::TOUCHING_M - Vec3::X * depth_m as f32
            };
            let felt = Bench::new(&Scene { delay_s, ..Scene::of(method) }).hold(grip, 5000, meant_m);
            least = felt.iter().map(|felt| -felt.work_j).fold(least, smaller);
        }
    }
    least * 1e3
}

/// Depth of the dent after a second of pressing by a hand, in a loop of 1 to 10 kHz that is tuned to its rate: most over least, less 1, in
/// percent. The mean of ten hands that go a tenth of a step of the encoders farther each: which step one of them ends on is chance, and a
/// step is a tenth of a firm hand's dent.
pub(super) fn rate_of_the_loop(method: MethodKind) -> f64 {
    Grip::ALL.map(|grip| rate_felt_by(method, grip)).into_iter().fold(0.0, larger)
}

fn rate_felt_by(method: MethodKind, grip: Grip) -> f64 {
    let depths = [1000_u32, 2000, 5000, 10_000]
        .map(|rate| (0..10).map(|tenth| pressed_at(method, grip, rate, 0.1 * f64::from(tenth))).sum::<f64>() / 10.0);
    crate::failures::spread_percent(&depths)
}

/// Depth of the dent of a hand that goes so many steps of the encoders farther, m.
fn pressed_at(method: MethodKind, grip: Grip, rate: u32, farther: f64) -> f64 {
    let dt = Seconds(1.0 / rate as f32);
    let mut clay = Clay::new(method, 180, 200).with_step(dt);
    let device = Setup::for_device(Scene::of(method).specs, method.felt_share());
    let setup = Setup { stages: stages(method), period: dt, ..device };
    let mut chain = Haptics::new(setup);
    let begin_m = Bench::TOUCHING_M + Vec3::X * 2e-3;
    let mut hand = Mechanism::at_rest(grip, begin_m, f64::from(setup.specs.resolution_m), 0.0);
    // as far as the standard hand has to go for two newtons and a third
    let way_m = 7.0 / 3.0 / grip.stiffness_n_m + 2.2e-3 + farther * f64::from(setup.specs.resolution_m);
    for tick in 0..rate {
        let seconds = f64::from(tick) / f64::from(rate);
        let meant_m = begin_m - Vec3::X * (way_m * (4.0 * seconds).min(1.0)) as f32;
        let force_n = chain.accept(Some(hand.reported_m()), None, dt).map_or(Vec3::ZERO, |centre| {
            // straight in, so that no way has to be told: rounded to 10 µm in 0.1 ms it would look like sliding
            let contact = clay.advance(&[clay.tool(12.0, centre.point_m())])[0];
            let (force_n, penetration_m) = (contact.force_n, contact.penetration_m);
            chain.render(&Touch { centre, force_n, penetration_m, held_n: contact.held_n, wet: None })
        });
        hand.pass(force_n, meant_m, f64::from(dt.0));
    }
    clay.unless_broken(clay.deepest_m())
}
