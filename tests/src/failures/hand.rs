//! What a hand feels where methods kick, sink or give energy back.
//!
//! Owns the scenarios of one hand and one tool.
//! Invariant: the hand is the scenario's own; no device and no coupling stands between it and the clay.

use std::f32::consts::TAU;

use glam::Vec3;
use pottery_shared::clay::{MethodKind, PotSpec, Press};
use pottery_shared::tool::Side;
use pottery_shared::units::{Metres, Seconds};

use super::scene::{Scene, around, flow_n, larger, smaller, spread_percent};

/// Stiffness K of a contact, N/m: the steepest rise of the force over a tick while a tool goes 3 mm in.
fn stiffness_n_m(method: MethodKind, speed_m_s: f32) -> f64 {
    let mut scene = Scene::new(method, 360, 400);
    let travel_mm = speed_m_s * scene.step.0 * 1e3;
    let (mut last, mut steepest) = (0.0, 0.0_f64);
    for number in 1..=(3.0 / travel_mm) as u32 {
        let press = scene.pressed(12.0, number as f32 * travel_mm, 0.1, 101.3);
        let force = scene.press(press).force_n.length();
        steepest = larger(steepest, f64::from((force - last).abs()) / f64::from(travel_mm * 1e-3));
        last = force;
    }
    steepest
}

/// Largest change of force in a tick over K·v·T, for a tool on its way.
fn kick(scene: &mut Scene, speed_m_s: f32, way: impl Iterator<Item = Press>) -> f64 {
    let even = stiffness_n_m(scene.method, speed_m_s) * f64::from(speed_m_s * scene.step.0);
    let mut last = Vec3::ZERO;
    let mut largest = 0.0_f64;
    for press in way {
        let force = scene.press(press).force_n;
        largest = larger(largest, f64::from((force - last).length()));
        last = force;
    }
    scene.unless_broken(largest / even)
}

/// The tool goes in until its centre is 4 mm behind the wall, through clay that has no time to yield.
pub(super) fn centre_crosses(method: MethodKind) -> f64 {
    const SPEED_M_S: f32 = 0.2;
    let mut scene = Scene::new(method, 360, 400).with_viscosity(Seconds(5.0));
    let presses: Vec<_> = (0..80).map(|tick| scene.pressed(12.0, 0.2 * tick as f32, 0.1, 101.3)).collect();
    kick(&mut scene, SPEED_M_S, presses.into_iter())
}

/// The tool comes down onto the rim with its centre above the middle of the wall.
pub(super) fn over_the_rim(method: MethodKind) -> f64 {
    const SPEED_M_S: f32 = 0.1;
    let mut scene = Scene::new(method, 360, 400);
    let presses: Vec<_> = (0..200).map(|tick| scene.tool(12.0, around(56.0, 0.1, 213.0 - 0.1 * tick as f32))).collect();
    kick(&mut scene, SPEED_M_S, presses.into_iter())
}

/// A hand that pushes with 3 N; how fast it still sinks after two seconds, mm/s.
pub(super) fn still_hand(method: MethodKind) -> f64 {
    const PUSH_N: f32 = 3.0;
    // the hand gives way slowly enough for the loop itself to be stable on the stiffest of these contacts
    const DAMPING_NS_M: f32 = 200.0;
    let mut scene = Scene::new(method, 180, 200);
    let (mut depth_mm, mut before_mm) = (0.0, 0.0);
    for tick in 0..2000 {
        let press = scene.pressed(12.0, depth_mm, 0.1, 101.3);
        let force = scene.press(press).force_n.dot(around(1e3, 0.1, 0.0));
        if tick == 1900 {
            before_mm = depth_mm;
        }
        depth_mm = (depth_mm + (PUSH_N - force) / DAMPING_NS_M * scene.step.0 * 1e3).min(55.0);
    }
    scene.unless_broken(f64::from(depth_mm - before_mm) / 0.1)
}

/// Mean pressure 6 mm in the clay over that 2 mm in it, both reached within 10 ms.
pub(super) fn saturation(method: MethodKind) -> f64 {
    let pressure = |depth_mm: f32| {
        let mut scene = Scene::new(method, 360, 400);
        let mut pressure = 0.0;
        for tick in 1..=10 {
            let press = scene.pressed(12.0, depth_mm * tick as f32 / 10.0, 0.1, 101.3);
            let contact = scene.press(press);
            let area = f64::from(contact.elements) * scene.element_rad_m() * f64::from(scene.untouched_m());
            pressure = f64::from(contact.force_n.length()) / area;
        }
        pressure
    };
    pressure(6.0) / pressure(2.0)
}

/// Least energy that the clay has taken since the tool last was in the air, mJ.
///
/// Ten times in and out, ten circles up and down, and ten to and fro along the wall; every tenth begins in the air.
pub(super) fn energy(method: MethodKind) -> f64 {
    const TICKS: u32 = 60;
    let mut least = f64::INFINITY;
    for round in 0..3 {
        let mut scene = Scene::new(method, 180, 200);
        let (mut taken, mut last): (f64, Option<(Vec3, Vec3)>) = (0.0, None);
        for tick in 0..10 * TICKS {
            let turn = (tick % TICKS) as f32 / TICKS as f32 * TAU;
            let depth_mm = 1.3 - 1.5 * turn.cos();
            let aside_mm = 1.5 * turn.sin();
            let (angle_rad, z_mm) = match round {
                0 => (0.1, 101.3),
                1 => (0.1, 101.3 + aside_mm),
                _ => (0.1 + aside_mm / 60.0, 101.3),
            };
            let press = scene.pressed(12.0, depth_mm, angle_rad, z_mm);
            let contact = scene.press(press);
            if contact.elements == 0 {
                taken = 0.0;
            } else if let Some((place, force)) = last {
                let travel = press.centre_m - place;
                taken -= 0.5 * f64::from((force + contact.force_n).dot(travel));
            }
            last = Some((press.centre_m, contact.force_n));
            least = smaller(least, taken);
            if scene.unless_broken(0.0) > 0.0 {
                return f64::NEG_INFINITY;
            }
        }
    }
    least * 1e3
}

/// Largest force while the tool goes through the axis and rests there, over what clay bears on a smooth sphere that
/// is wholly in it.
pub(super) fn through_the_axis(method: MethodKind) -> f64 {
    let mut scene = Scene::new(method, 180, 200);
    let mut largest = 0.0_f64;
    for tick in 0..400_i32 {
        let distance_mm = 75.0 - 0.5 * tick.min(300) as f32;
        // on the axis itself, where neither angle nor distance has a direction, for a while
        let distance_mm = if (145..155).contains(&tick) { 0.0 } else { distance_mm };
        let press = scene.tool(12.0, around(distance_mm, 0.3, 99.7));
        let force = f64::from(scene.press(press).force_n.length());
        largest = larger(largest, scene.unless_broken(force / flow_n(&press)));
    }
    largest
}

/// Most elements that a step works at while the tool goes to the axis, rests on it and goes on, over those at the tool's heights all round the pot
/// and for each part into which the step cuts its way; half a millimetre a tick, and `leap_mm` onto the axis and off it.
pub(super) fn work_at_the_axis(method: MethodKind, leap_mm: f32) -> f64 {
    const STEP_MM: f32 = 0.5;
    const BEGIN_MM: f32 = 75.0;
    let steps = ((BEGIN_MM - leap_mm) / STEP_MM) as u16;
    let there = (0..=steps).rev().map(|step| leap_mm + STEP_MM * f32::from(step));
    // ten ticks on the axis itself
    let way = there.clone().chain([0.0; 11]).chain(there.rev().map(|distance_mm| -distance_mm));
    let mut most = 0.0_f64;
    let mut last_mm = BEGIN_MM;
    let mut scene = Scene::new(method, 180, 200);
    for distance_mm in way {
        let contact = scene.press(scene.tool(12.0, around(distance_mm, 0.3, 99.7)));
        let way_mm = std::mem::replace(&mut last_mm, distance_mm) - distance_mm;
        // the published methods know of no way
        let parts = if method == MethodKind::Plastic { parts_of(way_mm, 12.0) } else { 1.0 };
        let worked = scene.worked_at().max(u64::from(contact.elements)) as f64;
        // 24 mm of 200, and a row for each end
        most = larger(most, worked / (parts * 180.0 * 26.0));
    }
    scene.unless_broken(most)
}

/// Parts into which a sphere's way is cut, as `shared/src/clay/substep.rs` says it: `⌈d/√(8·s·R)⌉` with a ridge s of 15 µm, sixteen at most.
fn parts_of(way_mm: f32, radius_mm: f32) -> f64 {
    const RIDGE_MM: f32 = 0.015;
    f64::from((way_mm / (8.0 * RIDGE_MM * radius_mm).sqrt()).ceil().clamp(1.0, Press::PARTS_MAX as f32))
}

/// Largest force on a tool that was in the air a tick before, over what clay bears on a smooth sphere that is wholly in
/// it.
pub(super) fn born_in_the_clay(method: MethodKind) -> f64 {
    let mut largest = 0.0_f64;
    for depth_mm in [6.0, 12.0, 20.0, 30.0, 40.0, 50.0, 58.0, 66.0, 72.0] {
        let mut scene = Scene::new(method, 360, 400);
        let air = scene.pressed(12.0, -10.0, 0.1, 101.3);
        scene.press(air);
        let press = scene.pressed(12.0, depth_mm, 0.1, 101.3);
        let force = f64::from(scene.press(press).force_n.length());
        largest = larger(largest, scene.unless_broken(force / flow_n(&press)));
    }
    largest
}

/// A tool wider than the pot comes down into it, or presses from outside: how many radii are misplaced at the worst; infinite
/// when it met no clay.
pub(super) fn larger_than_the_opening(method: MethodKind) -> f64 {
    let spec = *Scene::new(method, 90, 100).pot.spec();
    let narrow = PotSpec { radius: Metres::from_mm(30.0), wall: Metres::from_mm(4.0), ..spec };
    let mut worst = 0.0_f64;
    for side in [Side::Inside, Side::Outside] {
        let mut scene = Scene::of(method, narrow).with_viscosity(Seconds(0.002));
        let mut met = 0;
        for tick in 0..150 {
            let centre_m = match side {
                Side::Inside => around(3.0, 0.1, 240.0 - tick as f32),
                Side::Outside => around(75.0 - 0.5 * tick as f32, 0.1, 150.0),
            };
            let press = Press { side, ..scene.tool(40.0, centre_m) };
            met = met.max(scene.press(press).elements);
            worst = larger(worst, scene.unless_broken(scene.misplaced() as f64));
        }
        if met == 0 {
            return f64::INFINITY;
        }
    }
    worst
}

/// Depth after a second in which the tool goes 3 mm in, at 250 Hz to 10 kHz: most over least, less 1, in percent.
pub(super) fn rate_of_the_loop(method: MethodKind) -> f64 {
    let depths = [250_u16, 500, 1000, 2000, 4000, 10_000].map(|rate| {
        let mut scene = Scene::new(method, 90, 100).with_step(Seconds(1.0 / f32::from(rate)));
        for tick in 1..=rate {
            let depth_mm = 3.0 * f32::from(tick) / f32::from(rate);
            scene.press(scene.pressed(12.0, depth_mm, 0.1, 101.3));
        }
        scene.unless_broken(scene.deepest_m())
    });
    spread_percent(&depths)
}
