//! What a hand feels of a correction: clay that others pressed, or took back, under a tool that is held still.
//!
//! Server, worker, prediction and the whole haptic chain are the real ones, over a network in memory and virtual time. The wheel stands still, so
//! that nothing but corrections changes the clay under the tool.
//! Invariant under test: whatever comes over the network, the force changes by no more than 0.02 N in a millisecond.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::{Arc, Mutex};
use std::time::Duration;

use glam::Vec3;
use pottery_client::device::Device;
use pottery_client::{Command, HapticLoop, NetworkReport, Seat};
use pottery_server::ServerConfig;
use pottery_shared::clay::MethodKind;
use pottery_shared::haptics::{DeviceSpecs, Setup, Stages};
use pottery_shared::tool::Tool;
use pottery_shared::units::Rpm;
use pottery_tests::line::{BurstLoss, Quality};
use pottery_tests::simulation::{BURSTS, Joined, Simulation, in_virtual_time, ms};
use tokio::time::{Instant, sleep_until};

/// Where the standard tool just touches, and how deep the device of the hand that is held still goes beyond.
const TOUCHING_M: Vec3 = Vec3::new(0.072, 0.0, 0.1);
const HELD_M: f32 = 2.5e-3;
/// When the other hand presses and when it takes that back, s after all are there; and when all ends.
const PRESSES_S: std::ops::Range<f64> = 2.5..4.0;
const UNDOES_S: f64 = 6.0;
const ENDS_S: f64 = 9.0;

/// The force that a device was given at every tick, N.
type Forces = Arc<Mutex<Vec<Vec3>>>;

/// A device that is held where it is told.
struct Told {
    at_m: Arc<Mutex<Option<Vec3>>>,
    forces: Forces,
    stages: Stages,
}

impl Device for Told {
    fn position(&mut self, _: f64) -> Option<Vec3> {
        *self.at_m.lock().unwrap()
    }

    fn tool(&self) -> Tool {
        Tool::default()
    }

    fn set_force(&mut self, force_n: Vec3) {
        self.forces.lock().unwrap().push(force_n);
    }

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }

    fn setup(&self, share_of_small: f32) -> Setup {
        Setup { stages: self.stages, ..Setup::for_device(self.specs(), share_of_small) }
    }
}

/// Where the two devices are at a time, m.
fn places(seconds: f64, other_m: f32) -> [Option<Vec3>; 2] {
    let held = TOUCHING_M - Vec3::X * HELD_M * (seconds as f32).min(1.0);
    // in and out within a fifth of a second, as deep as it goes
    let from_s = seconds - PRESSES_S.start;
    let until_s = PRESSES_S.end - seconds;
    let share = (from_s.min(until_s) * 5.0).min(1.0) as f32;
    let pressing = (share > 0.0).then(|| TOUCHING_M + Vec3::X * (1e-3 - share * (1e-3 + other_m)));
    [Some(held), pressing]
}

/// What the still hand was given, and what its worker measured; the other one presses so deep, if at all. Where the line is cut meanwhile, all that
/// was pressed comes at once.
fn hold(seed: u64, quality: Quality, is_cut: bool, other_m: Option<f32>) -> (Vec<Vec3>, NetworkReport) {
    in_virtual_time(async {
        let config = ServerConfig { wheel_speed: Rpm(0.0), method: MethodKind::Plastic, ..ServerConfig::default() };
        let studio = Simulation::open(seed, config).unwrap();
        let mut people = Vec::new();
        // the hand that is held has the whole chain, the other one goes exactly where it is told
        for (number, stages) in (0..).zip([Stages::WHOLE, Stages::EXACT]) {
            let target = studio.target(1);
            let Joined { endpoint, seat, .. } = studio.join(number, quality, quality, &target).await.unwrap();
            let Seat { commands, epoch, worker, hand, .. } = seat;
            let (at_m, forces) = (Arc::new(Mutex::new(None)), Forces::default());
            let device = Told { at_m: Arc::clone(&at_m), forces: Arc::clone(&forces), stages };
            let hand = HapticLoop::new(Box::new(device), hand);
            people.push((endpoint, commands, epoch, tokio::spawn(worker.run()), hand, at_m, forces));
        }
        let begun = Instant::now();
        for tick in 1..=(ENDS_S * 1e3) as u64 {
            sleep_until(begun + ms(tick)).await;
            if is_cut {
                let since_s = tick as f64 * 1e-3 - PRESSES_S.start;
                studio.network.cut(Simulation::address_of(0), (-0.1..1.0).contains(&since_s));
            }
            let places = places(tick as f64 * 1e-3, other_m.unwrap_or_default());
            for (number, (_, commands, epoch, _, hand, at_m, _)) in people.iter_mut().enumerate() {
                *at_m.lock().unwrap() = places[number].filter(|_| number == 0 || other_m.is_some());
                hand.tick(epoch.elapsed().as_millis() as u64);
                if number == 1 && tick == (UNDOES_S * 1e3) as u64 && other_m.is_some() {
                    commands.send(Command::Undo).await.unwrap();
                }
            }
        }
        let (_, commands, _, worker, _, _, forces) = people.remove(0);
        commands.send(Command::Leave).await.unwrap();
        let report = worker.await.unwrap();
        studio.server.stop().await;
        let forces = forces.lock().unwrap().clone();
        (forces, report)
    })
}

/// Largest change from one tick to the next, N.
fn step_n(forces: &[Vec3]) -> f32 {
    forces.windows(2).map(|pair| pair[0].distance(pair[1])).fold(0.0, f32::max)
}

#[test]
fn no_correction_changes_the_force_by_more_than_a_fiftieth_of_a_newton_in_a_millisecond() {
    let line = |latency_ms, loss| Quality {
        latency: ms(latency_ms),
        jitter: Duration::ZERO,
        loss,
        duplicates: 0.0,
        rate: None,
    };
    let bursts = BurstLoss { every: ms(360), lasts: ms(40), in_burst: 0.5, otherwise: 0.0 };
    for (quality, is_cut) in [
        (line(10, BurstLoss::NONE), false),
        (line(100, BurstLoss::NONE), false),
        (line(100, bursts), false),
        (line(100, BurstLoss::NONE), true),
    ] {
        assert_no_jolt(5, quality, is_cut);
    }
}

/// `POTTERY_SEEDS=100` tries so many instead of a few. With seed 42 the tool slides aside on a slope that a correction has left: by 27.5 mN in a
/// millisecond, while only what changed along the contact's normal was put off.
#[test]
fn no_correction_over_a_line_that_loses_in_bursts_and_reorders_changes_it_by_more_either() {
    let asked = std::env::var("POTTERY_SEEDS").map(|seeds| (0..seeds.parse().unwrap()).collect());
    for seed in asked.unwrap_or_else(|_| vec![0, 1, 2, 42]) {
        assert_no_jolt(seed, BURSTS, false);
    }
}

fn assert_no_jolt(seed: u64, quality: Quality, is_cut: bool) {
    // the hand has come to rest by then
    let rest = (PRESSES_S.start * 1e3) as usize - 100;
    let (alone, _) = hold(seed, quality, is_cut, None);
    let still_n = step_n(&alone[rest..]);
    for other_mm in [3.0, 5.0] {
        let (forces, report) = hold(seed, quality, is_cut, Some(other_mm * 1e-3));
        let (before, after) = forces[rest..].split_at(UNDOES_S as usize * 1000 - rest);
        let (pressed_n, undone_n) = (step_n(before), step_n(after));
        let correction_mm = report.correction_nm.max() as f64 * 1e-6;
        let [held_n, left_n, back_n] = [before[0], before[before.len() - 1], after[after.len() - 1]].map(Vec3::length);
        println!(
            "seed {seed}, {quality}, {}{other_mm} mm: corrected by {correction_mm:.3} mm at most; {held_n:.2} N, then {left_n:.2} N, then \
             {back_n:.2} N; steps {:.3} mN as it is pressed, {:.3} mN as it is undone, {:.3} mN with nobody else",
            if is_cut { "cut while the other presses, " } else { "" },
            pressed_n * 1e3,
            undone_n * 1e3,
            still_n * 1e3
        );
        assert!(
            held_n > 0.5 && left_n < held_n - 0.2 && back_n > left_n + 0.2,
            "seed {seed}, {quality}, {other_mm} mm: {held_n} N, {left_n} N, {back_n} N"
        );
        assert!(
            pressed_n.max(undone_n).max(still_n) <= 0.02,
            "seed {seed}, {quality}, {other_mm} mm: {pressed_n} N, {undone_n} N and {still_n} N"
        );
    }
}
