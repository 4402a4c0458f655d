//! What jolts a hand that did nothing of the kind: transitions, stalls, corrections, faults, walls passed through.
//!
//! Owns the scenarios in which the device goes where it is told, whatever it is given; stalls and corrections also meet hands that hold it.
//! Invariant: forces are those that the device gets.

use glam::Vec3;
use pottery_shared::clay::{MethodKind, Support};
use pottery_shared::haptics::{Coupling, DeviceSpecs};
use pottery_shared::prediction::Field;
use pottery_shared::tool::{Shape, Side, Tool};
use pottery_shared::units::{Seconds, Tick};

use super::bench::{Bench, Scene};
use super::mechanism::{Grip, Mechanism};
use crate::failures::larger;

/// A place `depth_mm` deeper than where the tool just touches.
fn deep(depth_mm: f32) -> Vec3 {
    Bench::TOUCHING_M - Vec3::X * (depth_mm * 1e-3)
}

/// Stiffness that a hand feels at most, N/m: the coupling's, or the steepest rise of the force where there is none.
pub(super) fn stiffness_n_m(method: MethodKind, step_mm: f32) -> f32 {
    if method == MethodKind::Plastic {
        return Coupling::tuned(&DeviceSpecs::OMNI, Tick::PERIOD, Seconds(0.0)).stiffness_n_m;
    }
    let mut bench = Bench::new(&unlimited(method));
    let mut last_n = 0.0;
    let mut steepest = 0.0_f32;
    for tick in 0..(4.0 / step_mm) as u16 {
        let force_n = bench.tick(Some(deep(step_mm * f32::from(tick) - 1.0))).0.x;
        steepest = steepest.max((force_n - last_n).abs() / (step_mm * 1e-3));
        last_n = force_n;
    }
    steepest
}

/// A device that bears any force, so that the limit hides nothing.
fn unlimited(method: MethodKind) -> Scene {
    let mut scene = Scene::of(method);
    scene.specs.peak_force_n = 100.0;
    scene.specs.continuous_force_n = None;
    scene
}

/// Largest change of force in a tick over K·v·T while the tool goes in until its centre is 3 mm behind the wall, and out again.
pub(super) fn centre_crosses(method: MethodKind) -> f64 {
    const STEP_MM: f32 = 0.2;
    let even_n = stiffness_n_m(method, STEP_MM) * STEP_MM * 1e-3;
    let mut bench = Bench::new(&unlimited(method));
    let mut last_n = Vec3::ZERO;
    let mut largest_n = 0.0_f32;
    for tick in 0..170_i16 {
        let depth_mm = STEP_MM * f32::from(85 - (tick - 85).abs()) - 2.0;
        let (force_n, _) = bench.tick(Some(deep(depth_mm)));
        largest_n = largest_n.max((force_n - last_n).length());
        last_n = force_n;
    }
    f64::from(largest_n / even_n)
}

/// How a device knows where it is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoders {
    /// Exactly, so that what is felt is the loop's own.
    Exact,
    /// In the steps of a PHANToM Omni.
    Omni,
}

/// What hands of every kind are given, tick by tick. They mean to rest so deep that they push with two newtons, and `deeper_mm` deeper; the loop
/// stands still in the ticks of which `meanwhile` says so, and the force stays as it was.
fn held(
    method: MethodKind,
    encoders: Encoders,
    ticks: u16,
    deeper_mm: impl Fn(u16) -> f32,
    mut meanwhile: impl FnMut(&mut Bench, u16) -> bool,
) -> [Vec<Vec3>; 3] {
    Grip::ALL.map(|grip| {
        let scene = Scene::of(method);
        let mut bench = Bench::new(&scene);
        let rest_mm = 2e3 / grip.stiffness_n_m as f32;
        // the way in takes a third of a second
        let meant_m = |tick: u16| deep((rest_mm + 4.0) * (3e-3 * f32::from(tick)).min(1.0) - 2.0 + deeper_mm(tick));
        let resolution_m = if encoders == Encoders::Omni { f64::from(scene.specs.resolution_m) } else { 0.0 };
        let mut mechanism = Mechanism::at_rest(grip, meant_m(0), resolution_m, scene.delay_s);
        let mut force_n = Vec3::ZERO;
        let ticks = (0..ticks).map(|tick| {
            if meanwhile(&mut bench, tick) {
                bench.stall(1);
            } else {
                (force_n, _) = bench.tick(Some(mechanism.reported_m()));
            }
            mechanism.pass(force_n, meant_m(tick), 1e-3);
            force_n
        });
        ticks.collect()
    })
}

/// When the loop stands still, ticks.
const STALLS: std::ops::Range<u16> = 600..650;

/// Largest change of force in a tick, N, after the loop stood still for 50 ms while the device went 8 mm deeper, or while a hand went on at 20 mm/s.
pub(super) fn stall(method: MethodKind) -> f64 {
    let goes_on = |tick: u16| 0.02 * f32::from(tick.clamp(STALLS.start, STALLS.end) - STALLS.start);
    held_through_a_stall(method, goes_on).max(told_to_stall(method))
}

/// The same for a hand that means to go 8 mm deeper from its first tick on: it is thrown by the force that stands, and comes back from it at up to a
/// third of a metre a second.
pub(super) fn stall_while_a_hand_lunges(method: MethodKind) -> f64 {
    held_through_a_stall(method, |tick| if tick < STALLS.start { 0.0 } else { 8.0 })
}

fn held_through_a_stall(method: MethodKind, deeper_mm: impl Fn(u16) -> f32) -> f64 {
    let hands = held(method, Encoders::Exact, 1400, deeper_mm, |_, tick| STALLS.contains(&tick));
    let change = |pair: &[Vec3]| f64::from((pair[1] - pair[0]).length());
    let after = hands.iter().flat_map(|forces_n| forces_n[usize::from(STALLS.end) - 1..].windows(2).map(change));
    after.fold(0.0, larger)
}

fn told_to_stall(method: MethodKind) -> f64 {
    let mut bench = Bench::new(&Scene::of(method));
    for tick in 0..200_u8 {
        bench.tick(Some(deep(f32::from(tick) * 0.01)));
    }
    let (mut last_n, _) = bench.tick(Some(deep(2.0)));
    bench.stall(50);
    let mut largest_n = 0.0_f32;
    for _ in 0..300 {
        let (force_n, _) = bench.tick(Some(deep(10.0)));
        largest_n = largest_n.max((force_n - last_n).length());
        last_n = force_n;
    }
    f64::from(largest_n)
}

/// Most ticks until there is no force, after a jump, a place that is none, and a device that is gone.
pub(super) fn faults(method: MethodKind) -> f64 {
    let odd = [Some(deep(52.0)), Some(deep(-50.0)), Some(Vec3::NAN), Some(Vec3::splat(f32::INFINITY)), None];
    let slowest = odd.map(|odd| {
        let mut bench = Bench::new(&Scene::of(method));
        for tick in 0..200_u8 {
            bench.tick(Some(deep(f32::from(tick) * 0.01)));
        }
        let ticks = (1..20).find(|_| bench.tick(odd).0 == Vec3::ZERO);
        // the session goes on, and what is sound again is felt again
        let is_back = (0..400).any(|_| bench.tick(Some(deep(2.0))).0.x > 0.05);
        ticks.filter(|_| is_back).map_or(f64::INFINITY, f64::from)
    });
    slowest.into_iter().fold(0.0, larger)
}

/// Largest change of force within 20 ms, over 7 % of it or 0.1 N, when the clay under the tool is suddenly 0.5 mm lower.
pub(super) fn correction(method: MethodKind, encoders: Encoders) -> f64 {
    corrected(method, encoders, -0.5e-3)
}

/// The same when it is 2 mm higher: somebody has undone what they pressed there.
pub(super) fn undoing(method: MethodKind, encoders: Encoders) -> f64 {
    corrected(method, encoders, 2e-3)
}

/// As the clay is now, but for its outer surface, which lies elsewhere.
fn moved(bench: &Bench, by_m: f32) -> Field {
    let mut pot = bench.clay().clone();
    let surface = &mut pot.surfaces_mut()[0];
    for column in 0..surface.shape().columns() {
        for row in 0..surface.shape().rows() {
            let radius_m = surface.column_m(column)[row as usize];
            surface.set_radius(column, row, radius_m + by_m);
        }
    }
    Field::new(pot, Tick(bench.local()))
}

/// For a device that is told to stay 3 mm deep, and for hands of every kind; the correction is heard 50 ms after the room has made it.
fn corrected(method: MethodKind, encoders: Encoders, by_m: f32) -> f64 {
    // long enough for the clay to have given way
    const MADE: u16 = 1500;
    const HEARD: u16 = MADE + 50;
    const TICKS: u16 = MADE + 600;
    let mut made = None;
    let mut correct = |bench: &mut Bench, tick: u16| {
        if tick == MADE {
            made = Some(moved(bench, by_m));
        } else if tick == HEARD
            && let Some(field) = made.take()
        {
            bench.net.publish(|patch| patch.field = field);
        }
        false
    };
    let mut bench = Bench::new(&Scene::of(method));
    let told = (0..TICKS).map(|tick| {
        correct(&mut bench, tick);
        bench.tick(Some(deep((f32::from(tick) * 0.01).min(3.0)))).0
    });
    let told: Vec<_> = told.collect();
    let jolt = |pair: &[Vec3]| {
        let (first, last) = (pair[0], pair[pair.len() - 1]);
        f64::from((last - first).length() / (0.07 * first.length()).max(0.1))
    };
    let all = held(method, encoders, TICKS, |_| 0.0, correct).into_iter().chain([told]);
    all.flat_map(|forces_n| forces_n[usize::from(MADE)..].windows(21).map(jolt).collect::<Vec<_>>()).fold(0.0, larger)
}

/// What becomes of a tool that is thrown through a pot at 4 m/s.
#[derive(Clone, Copy, Debug, Default)]
struct Thrown {
    /// How far it is in the clay in the tick in which it first touches, m, and how far it comes through the wall, over the wall's
    /// thickness.
    first_m: f32,
    through: f32,
}

/// The most of the sphere and, where tools of facets can be pressed with, of rib, blade and knuckle, from outside and from within. The loop is
/// made to cut: with three newtons it goes through clay as a wire does, from tick to tick.
fn thrown(method: MethodKind) -> Thrown {
    const BLUNT: [Shape; 3] = [Shape::RIB, Shape::BLADE, Shape::KNUCKLE];
    let facets = BLUNT.into_iter().filter(|_| method == MethodKind::Plastic).map(Tool::Convex);
    let tools = std::iter::once(Tool::default()).chain(facets);
    let ways = [(Support::Backed, Side::Outside), (Support::Hollow, Side::Outside), (Support::Hollow, Side::Inside)];
    let all = tools.flat_map(|tool| ways.map(|(support, side)| throw(method, tool, support, side)));
    all.fold(Thrown::default(), |most, one| Thrown {
        first_m: most.first_m.max(one.first_m),
        through: most.through.max(one.through),
    })
}

fn throw(method: MethodKind, tool: Tool, support: Support, side: Side) -> Thrown {
    const NEVER: Thrown = Thrown { first_m: f32::INFINITY, through: f32::INFINITY };
    const SPEED_MM: f32 = 4.0;
    const SLOW_MM: f32 = 0.05;
    let scene = Scene { support, ..Scene::of(method) };
    // from the air to far beyond the wall
    let (from_m, to_m): (f32, f32) = match side {
        Side::Outside => (0.14, -0.03),
        Side::Inside => (0.0, 0.14),
    };
    let ahead = (to_m - from_m).signum();
    let length_mm = (to_m - from_m).abs() * 1e3;
    let at = |gone_mm: f32| Vec3::new(from_m + ahead * gone_mm * 1e-3, 0.0, Bench::TOUCHING_M.z);
    // where it touches when it comes slowly
    let mut slow = Bench::with(&scene, tool);
    let met = (0..(length_mm / SLOW_MM) as u16).map(|tick| at(SLOW_MM * f32::from(tick))).find(|&device_m| {
        slow.tick(Some(device_m));
        slow.net.status().elements() > 0
    });
    let Some(met_m) = met else { return NEVER };
    let mut bench = Bench::with(&scene, tool);
    let wall_m = bench.clay().spec().wall.0;
    let (mut first_m, mut farthest_m) = (None, 0.0_f32);
    for tick in 0..(length_mm / SPEED_MM) as u16 {
        let (_, sample) = bench.tick(Some(at(SPEED_MM * f32::from(tick))));
        let Some(sample) = sample else { continue };
        if sample.side != side {
            return NEVER;
        }
        let deep_m = ahead * (sample.centre.point_m().x - met_m.x);
        if bench.net.status().elements() > 0 {
            first_m.get_or_insert(deep_m.max(0.0));
        }
        farthest_m = farthest_m.max(deep_m);
    }
    let Some(first_m) = first_m else { return NEVER };
    // a hollow wall bends away under it, so that there it is the side alone that tells
    Thrown { first_m, through: if support == Support::Backed { farthest_m / wall_m } else { 0.0 } }
}

/// How far a thrown tool comes through the wall that it meets, over the wall's thickness.
pub(super) fn thrown_through(method: MethodKind) -> f64 {
    f64::from(thrown(method).through)
}

/// How far a thrown tool is in the clay in the tick in which it first touches, mm.
pub(super) fn first_touch(method: MethodKind) -> f64 {
    f64::from(thrown(method).first_m) * 1e3
}

/// Largest angle between the force that is given and the one that is wanted, in degrees, for a tool pushed in aslant until
/// the device gives all it can.
pub(super) fn saturation(method: MethodKind) -> f64 {
    let press = |scene: &Scene| {
        let mut bench = Bench::new(scene);
        let forces = (0..1000_u16).map(|tick| {
            let way = f32::from(tick) * 1e-5;
            bench.tick(Some(deep(0.0) + Vec3::new(-way, 0.0, 0.5 * way))).0
        });
        forces.collect::<Vec<_>>()
    };
    let (mut weak, strong) = (Scene::of(method), unlimited(method));
    // the published methods hardly reach what a device gives
    weak.specs.peak_force_n = 0.2;
    weak.specs.continuous_force_n = None;
    // ours presses the clay with no more than is felt, so that the clay itself is another: there the coupling says what is wanted
    let wanted = if method == MethodKind::Plastic { coupled(&weak) } else { press(&strong) };
    let (mut largest, mut saturated) = (0.0_f32, 0);
    for (given, wanted) in press(&weak).into_iter().zip(wanted) {
        if given.length() > weak.specs.peak_force_n * 1.0001 {
            return f64::INFINITY;
        }
        if wanted.length() > weak.specs.peak_force_n * 1.5 {
            saturated += 1;
            largest = largest.max(given.angle_between(wanted));
        }
    }
    if saturated > 100 { f64::from(largest).to_degrees() } else { f64::INFINITY }
}

/// The force of the coupling alone for the press of [`saturation`].
fn coupled(scene: &Scene) -> Vec<Vec3> {
    let mut bench = Bench::new(scene);
    let stiffness = Coupling::tuned(&scene.specs, Tick::PERIOD, Seconds(0.0)).stiffness_n_m;
    let forces = (0..1000_u16).map(|tick| {
        let way = f32::from(tick) * 1e-5;
        let device_m = deep(0.0) + Vec3::new(-way, 0.0, 0.5 * way);
        bench.tick(Some(device_m));
        bench.net.status().tool_m().map_or(Vec3::ZERO, |tool_m| (tool_m - device_m) * stiffness)
    });
    forces.collect()
}
