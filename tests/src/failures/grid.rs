//! What a grid of elements lets slip: its resolution, its seam, tools that are small or fast, and a wheel that turns.
//!
//! Owns the scenarios in which another grid, another place or another way of stepping should change nothing.
//! Invariant: what is compared differs in that one thing.

use std::f32::consts::TAU;

use glam::Vec3;
use pottery_shared::clay::{MethodKind, Press};
use pottery_shared::units::{Metres, Seconds};

use super::scene::{Scene, bearing_n, larger, smaller, spread_percent};
use crate::dice::Dice;

/// Grids from 18,000 to 2.3 million elements.
const GRIDS: [(u32, u32); 3] = [(180, 100), (360, 400), (1440, 1600)];

/// Places of the tool in the rows of forces: at one alone, what the edge of a contact counts in whole elements decides.
const PLACES: usize = 60;
/// A place that is an element of no grid in question: angle, rad, and height, mm.
const PLACE: (f32, f32) = (0.1234, 98.7);

/// Largest difference of the mean force at first touch from that on the finest grid, in percent.
pub(super) fn force_on_coarser_grids(method: MethodKind) -> f64 {
    let forces = GRIDS.map(|(columns, rows)| {
        // in no time nothing yields, so that every place finds the same clay
        let mut scene = Scene::new(method, columns, rows).with_step(Seconds(0.0));
        let mut dice = Dice::new(0xf0ace);
        let forces: f64 = (0..PLACES)
            .map(|_| {
                let (angle_rad, z_mm) = (TAU * dice.share() as f32, 50.0 + 100.0 * dice.share() as f32);
                let contact = scene.press(scene.pressed(12.0, 3.0, angle_rad, z_mm));
                scene.unless_broken(f64::from(contact.force_n.length()))
            })
            .sum();
        forces / PLACES as f64
    });
    let finest = forces[GRIDS.len() - 1];
    forces.iter().map(|force| (force / finest - 1.0).abs()).fold(0.0, larger) * 100.0
}

/// Largest over smallest dent on any of the grids, less 1, in percent.
pub(super) fn dent_on_finer_grids(method: MethodKind) -> f64 {
    let dents = GRIDS.map(|(columns, rows)| {
        // few long steps, since the sum of the improved method takes long on the finest grid
        let mut scene = Scene::new(method, columns, rows).with_step(Seconds(0.05));
        let (angle_rad, z_mm) = PLACE;
        for _ in 0..4 {
            scene.press(scene.pressed(12.0, 3.0, angle_rad, z_mm));
        }
        scene.unless_broken(scene.dent_m3())
    });
    spread_percent(&dents)
}

/// Largest difference of radii between a stroke and the same one turned over the seam and over π, as a share.
pub(super) fn over_the_seam(method: MethodKind) -> f64 {
    let stroke = |begin_rad: f64| {
        let mut scene = Scene::new(method, 180, 200).with_step(Seconds(5e-3));
        for tick in 0..100_u8 {
            let part = f64::from(tick) / 100.0;
            let depth_mm = (4.0 * (part * std::f64::consts::PI).sin() - 0.5) as f32;
            let angle = begin_rad + 0.9 * part;
            let distance_mm = f64::from(72.0 - depth_mm);
            let place = [distance_mm * angle.cos(), distance_mm * angle.sin(), 60.0 + 80.0 * part];
            let press = scene.tool(12.0, Vec3::from_array(place.map(|along| (along * 1e-3) as f32)));
            scene.press(press);
        }
        scene
    };
    let straight = stroke(0.1);
    let mut largest = 0.0_f64;
    for columns in [1, 90, 120, 170] {
        let turned = stroke(0.1 + f64::from(columns) * std::f64::consts::TAU / 180.0);
        let (one, other) = (&straight.pot.surfaces()[0], &turned.pot.surfaces()[0]);
        for column in 0..180 {
            let there = other.column_m((column + columns) % 180);
            let pairs = one.column_m(column).iter().zip(there);
            largest = pairs.map(|(one, other)| f64::from((one - other).abs() / one)).fold(largest, larger);
        }
    }
    straight.unless_broken(largest)
}

/// The least sphere pressed 0.3 mm in, here and there on the default grid and on a coarse one: share of places where it finds
/// no clay, in percent.
pub(super) fn small_sphere_misses(method: MethodKind) -> f64 {
    let touches = small_sphere(method);
    touches.iter().filter(|touch| touch.elements == 0).count() as f64 / touches.len() as f64 * 100.0
}

/// The largest force there, over what clay bears on the square round the tool, grown by half an element on every side.
pub(super) fn small_sphere_force(method: MethodKind) -> f64 {
    small_sphere(method).iter().map(|touch| touch.force_over_bearing).fold(0.0, larger)
}

struct Touch {
    elements: u32,
    force_over_bearing: f64,
}

fn small_sphere(method: MethodKind) -> Vec<Touch> {
    const RADIUS_MM: f32 = 0.5;
    let mut dice = Dice::new(0x5a11);
    let mut touches = Vec::new();
    for (columns, rows) in [(360, 400), (90, 100)] {
        let mut scene = Scene::new(method, columns, rows).with_step(Seconds(0.0));
        let surface = &scene.pot.surfaces()[0];
        let arc_m = f64::from(surface.shape().column_angle_rad() * scene.untouched_m());
        let across_m = f64::from(Metres::from_mm(2.0 * RADIUS_MM).0);
        let area_m2 = (across_m + arc_m) * (across_m + f64::from(surface.row_height_m()));
        for _ in 0..200 {
            let (angle_rad, z_mm) = (dice.share() as f32 * TAU, 20.0 + 160.0 * dice.share() as f32);
            let contact = scene.press(scene.pressed(RADIUS_MM, 0.3, angle_rad, z_mm));
            let force = scene.unless_broken(f64::from(contact.force_n.length()));
            let force_over_bearing = force / bearing_n(scene.material.strength, area_m2);
            touches.push(Touch { elements: contact.elements, force_over_bearing });
        }
    }
    touches
}

/// A tool that moves three of its radii a tick: the depth of its groove over that of the same stroke in ticks a hundred times
/// as short, where it is least.
pub(super) fn fast_stroke(method: MethodKind) -> f64 {
    let strokes: [Stroke; 3] = [
        |tick| (0.1, 20.0 + 9.0 * tick),
        |tick| (0.1 + 0.15 * tick, 101.3),
        |tick| (0.1 + 0.1 * tick, 20.0 + 6.0 * tick),
    ];
    let mut least = f64::INFINITY;
    for stroke in strokes {
        let (fast, slow) = (groove(method, stroke, 1), groove(method, stroke, 100));
        least = fast.iter().zip(slow).map(|(fast, slow)| fast / slow).fold(least, smaller);
    }
    least
}

/// Angle, rad, and height, mm, at a time, in ticks.
type Stroke = fn(f32) -> (f32, f32);

/// Depths along the middle of a stroke of 16 ticks, each in so many parts, mm.
fn groove(method: MethodKind, stroke: Stroke, parts: u16) -> Vec<f64> {
    // clay so runny and ticks so long that a groove is there at once
    let step = Seconds(0.02 / f32::from(parts));
    let mut scene = Scene::new(method, 360, 400).with_viscosity(Seconds(0.002)).with_step(step);
    for part in 0..=16 * parts {
        let (angle_rad, z_mm) = stroke(f32::from(part) / f32::from(parts));
        scene.press(scene.pressed(3.0, 1.5, angle_rad, z_mm));
    }
    let surface = &scene.pot.surfaces()[0];
    let depth_mm = |(angle_rad, z_mm): (f32, f32)| {
        let column = (angle_rad / surface.shape().column_angle_rad()).round() as i64;
        let row = (z_mm * 1e-3 / surface.row_height_m()).round() as usize;
        let radius_m = surface.column_m(surface.shape().wrap(column))[row];
        scene.unless_broken(f64::from(scene.untouched_m() - radius_m) * 1e3)
    };
    (40..120_u8).map(|tenth| depth_mm(stroke(f32::from(tenth) / 10.0))).collect()
}

/// A tool held 1 mm in a wheel that turns at up to 300 rpm until nothing changes: unevenness of the groove over that
/// millimetre, in percent.
pub(super) fn held_on_the_wheel(method: MethodKind) -> f64 {
    const DEPTH_MM: f32 = 1.0;
    let mut worst = 0.0_f64;
    for (rpm, ticks) in [(30.0, 4000), (60.0, 3000), (150.0, 2400), (300.0, 2000)] {
        let mut scene = Scene::new(method, 360, 400).with_viscosity(Seconds(0.002));
        let per_tick = rpm / 60.0 * f64::from(scene.step.0) * std::f64::consts::TAU;
        let mut angle = 0.0;
        for tick in 0..ticks {
            angle = f64::from(tick) * per_tick;
            // the wheel turns away from under the tool
            let press = scene.pressed(12.0, DEPTH_MM, (-angle).rem_euclid(std::f64::consts::TAU) as f32, 100.0);
            scene.press(Press { turning: 1, ..press });
        }
        let surface = &scene.pot.surfaces()[0];
        let tool = (-angle).rem_euclid(std::f64::consts::TAU) / f64::from(surface.shape().column_angle_rad());
        let row = (100.0e-3 / surface.row_height_m()).round() as usize;
        // what it leaves: the clay before and under it is still on its way
        let left: Vec<f64> = (60..300)
            .map(|aside| {
                let column = surface.shape().wrap(tool.round() as i64 + aside);
                f64::from(scene.untouched_m() - surface.column_m(column)[row])
            })
            .collect();
        let most = left.iter().copied().fold(f64::NEG_INFINITY, larger);
        let least = left.iter().copied().fold(f64::INFINITY, smaller);
        worst = larger(worst, scene.unless_broken((most - least) / f64::from(DEPTH_MM) * 1e5));
    }
    worst
}
