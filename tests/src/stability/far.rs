//! What a hand feels when the room is far away: the same as with no network, and no more energy than it gave.
//!
//! Owns the scenarios of force over a line; sessions are played by [`super::online`].
//! Invariant: what is compared differs in the line alone.

use std::f64::consts::TAU;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::MethodKind;
use pottery_shared::haptics::{Coupling, DeviceSpecs};

use super::bench::{Bench, Felt, Scene};
use super::mechanism::Grip;
use super::online::{BEGIN, Held, Holder, Session, hold};
use super::plane::bound_n_m;
use super::resting::{LOOKED_AT, PUSH_N, STILL_M, about_a_line, pressing};
use crate::chart::csv::{Cell, Row};
use crate::failures::larger;
use crate::line::{BurstLoss, Quality};
use crate::simulation::ms;

/// 100 ms each way, and one in twenty packets lost.
const FAR: Quality = Quality {
    latency: ms(100),
    jitter: Duration::ZERO,
    loss: BurstLoss { in_burst: 0.05, otherwise: 0.05, ..BurstLoss::NONE },
    duplicates: 0.0,
    rate: None,
};
/// Of the line's dice.
const SEEDS: [u64; 2] = [1, 2];
/// For so long a hand holds on until it is looked at, s.
const SECONDS: u16 = 3;

/// A hand with no network, on the clay of a room and at the ticks of one.
fn near(scene: &Scene, grip: Grip, seconds: u16) -> Vec<Felt> {
    let mut bench = Bench::of_a_room(scene);
    bench.stall(BEGIN as u64);
    bench.hold(grip, u32::from(seconds) * 1000, pressing(grip, PUSH_N))
}

/// The same hand in a room that is far away.
fn far(scene: &Scene, grip: Grip, seconds: u16, seed: u64) -> Held {
    let session = Session { scene: *scene, line: FAR, seed, seconds };
    hold(&session, &[Holder::new(grip, pressing(grip, PUSH_N))])
}

/// Both, of every hand with all dice, for so many seconds.
fn pairs(method: MethodKind, seconds: u16) -> impl Iterator<Item = (Vec<Felt>, Held)> {
    let scene = Scene::of(method);
    Grip::ALL.into_iter().flat_map(move |grip| {
        let near = near(&scene, grip, seconds);
        SEEDS.map(|seed| (near.clone(), far(&scene, grip, seconds, seed)))
    })
}

/// Ticks in which the force differs by a bit from that with no network, until the lead first changes; infinite when the hand was not in
/// the clay by then.
pub(super) fn other_bits(method: MethodKind) -> f64 {
    let differ = pairs(method, 1).map(|(near, far)| {
        let same_ticks = || near.iter().zip(&far.felt[0]).take(far.steady[0]);
        let bits = |felt: &Felt| felt.force_n.to_array().map(f32::to_bits);
        let is_felt = same_ticks().any(|(near, _)| near.force_n != Vec3::ZERO);
        let differ = same_ticks().filter(|(near, far)| bits(near) != bits(far)).count();
        if is_felt { differ as f64 } else { f64::INFINITY }
    });
    differ.fold(0.0, larger)
}

/// Largest difference of the force from that with no network, N, whatever the lead does.
pub(super) fn other_force(method: MethodKind) -> f64 {
    let differ = pairs(method, 2).flat_map(|(near, far)| {
        let felt = far.felt.into_iter().next().unwrap_or_default();
        near.into_iter().zip(felt).map(|(near, far)| f64::from(near.force_n.distance(far.force_n)))
    });
    differ.fold(0.0, larger)
}

/// Least energy that device and clay have taken from a hand since it was last in the air, mJ, while another goes in and out beside it, far
/// away, and then undoes that.
pub(super) fn energy(method: MethodKind) -> f64 {
    let in_and_out = |depth_m: f64, hertz: f64, beside_m: f32| {
        move |seconds: f64| {
            let depth_m = depth_m * (0.5 - 0.6 * (seconds * TAU * hertz).cos());
            Bench::TOUCHING_M + Vec3::new(-depth_m as f32, 0.0, beside_m)
        }
    };
    let mut least_j = f64::INFINITY;
    for (seed, grip) in (1..).zip(Grip::ALL) {
        let own = Holder::new(grip, in_and_out(2.0 / grip.stiffness_n_m, 2.0, 0.0));
        let deep = in_and_out(4.0 / Grip::FIRM.stiffness_n_m, 1.3, 2e-3);
        let other = Holder { undoes_s: Some(2.6), ..Holder::new(Grip::FIRM, deep) };
        let held = hold(&Session { scene: Scene::of(method), line: FAR, seed, seconds: 4 }, &[own, other]);
        // it counts only where the room came to the same clay
        if held.settled.is_none() || held.lost > 0 {
            return f64::NEG_INFINITY;
        }
        let (mut taken_j, mut before_j) = (0.0, 0.0);
        for felt in &held.felt[0] {
            let is_free = felt.force_n == Vec3::ZERO;
            taken_j = if is_free { 0.0 } else { taken_j - (felt.work_j - before_j) };
            before_j = felt.work_j;
            least_j = least_j.min(taken_j);
        }
    }
    least_j * 1e3
}

/// The edge of what is stable on clay, with no network and far away.
#[derive(Clone, Copy, Debug)]
pub struct FarPoint {
    /// Who holds the device.
    pub grip: Grip,
    /// The line's dice.
    pub seed: u64,
    /// Delay of the device, s.
    pub delay_s: f64,
    /// Largest stable stiffness of the coupling with no network, N/m.
    pub near_n_m: f64,
    /// The same through 200 ms and 5 % of loss.
    pub far_n_m: f64,
}

impl Row for FarPoint {
    const COLUMNS: &'static [&'static str] = &["hand", "seed", "delay_ms", "near_n_m", "far_n_m"];

    fn cells(&self) -> Vec<Cell> {
        let Self { grip, seed, delay_s, near_n_m, far_n_m } = *self;
        vec![grip.name.into(), (seed as u32).into(), (delay_s * 1e3).into(), near_n_m.into(), far_n_m.into()]
    }
}

/// Where our loop on our clay ceases to be stable, for every hand, with a device so late that it does.
#[must_use]
pub fn measure_far() -> Vec<FarPoint> {
    /// Between two stiffnesses that are tried; the first is the bound by theory.
    const RATIO: f64 = 1.05;
    /// With less of it the firmest hand is stable on clay whatever the coupling.
    const DELAY_S: f64 = 5e-3;
    /// So many steps below the edge is begun far away.
    const AGAIN: i32 = 3;
    let scene = |stiffness_n_m: f64| Scene {
        // it is the loop that is tried, not the motors
        specs: DeviceSpecs { peak_force_n: 100.0, continuous_force_n: None, ..DeviceSpecs::OMNI },
        delay_s: DELAY_S,
        coupling: Some(Coupling { stiffness_n_m: stiffness_n_m as f32, damping_ns_m: 0.0 }),
        ..Scene::of(MethodKind::Plastic)
    };
    let is_still = |felt: &[Felt]| {
        let along: Vec<f64> = felt[LOOKED_AT..].iter().map(|felt| felt.at_m.x).collect();
        about_a_line(&along) <= STILL_M
    };
    let edge = |from: i32, is_stable: &dyn Fn(i32) -> bool| {
        let stable = (from..).take_while(|step| is_stable(*step)).count();
        from + stable as i32 - 1
    };
    let mut points = Vec::new();
    for grip in Grip::ALL {
        let stiffness_n_m = |step| bound_n_m(&grip, DELAY_S) * RATIO.powi(step);
        let near = edge(0, &|step| is_still(&near(&scene(stiffness_n_m(step)), grip, SECONDS)));
        for seed in SEEDS {
            let is_stable = |step| is_still(&far(&scene(stiffness_n_m(step)), grip, SECONDS, seed).felt[0]);
            let far = edge(near - AGAIN, &is_stable);
            let [near_n_m, far_n_m] = [near, far].map(stiffness_n_m);
            points.push(FarPoint { grip, seed, delay_s: DELAY_S, near_n_m, far_n_m });
        }
    }
    points
}
