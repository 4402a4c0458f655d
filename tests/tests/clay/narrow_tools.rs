//! Narrow tools with sharp edges on a turning wheel: felt evenly, whatever stands between the elements.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f32::consts::TAU;

use glam::{Quat, Vec3};
use pottery_shared::clay::{GridShape, MethodKind, Pot, PotSpec, Press, SubStep, Support};
use pottery_shared::tool::{Shape, Tool};

/// Force of a tool whose edge is upright, held 1 mm deep at the middle of a pot that turns, as the room sees it, N: tick by tick, once it is in.
fn felt(shape: Shape, edge_mm: f32, grid: GridShape, rpm: f32) -> Vec<Vec3> {
    let spec = PotSpec { shape: grid, support: Support::Backed, ..PotSpec::default() };
    let (mut pot, mut step) = (Pot::new(spec).unwrap(), SubStep::for_grid(grid));
    let place = |tick: u16| {
        let in_m = (f32::from(tick) * 5e-6).min(1e-3);
        let angle_rad = f32::from(tick) * 1e-3 * rpm / 60.0 * TAU;
        let distance_m = spec.radius.0 + edge_mm * 1e-3 - in_m;
        (Vec3::new(distance_m * angle_rad.cos(), distance_m * angle_rad.sin(), 0.1), Quat::from_rotation_z(angle_rad))
    };
    let forces = (1..900).map(|tick| {
        let ((from_m, _), (centre_m, turn)) = (place(tick - 1), place(tick));
        let press =
            Press { from_m: Some(from_m), turning: 1, orientation: turn, ..Press::held(Tool::Convex(shape), centre_m) };
        turn.inverse() * step.advance(&mut pot, &[press], MethodKind::Plastic, |_, _| {})[0].force_n
    });
    forces.skip(300).collect()
}

#[test]
fn an_upright_edge_is_felt_evenly_as_clay_turns_under_it_and_alike_on_every_grid() {
    // looked at along columns, the blade pressed with nothing and with 24 N in turn, and the rib with 13 and with 33
    for (shape, name, edge_mm) in
        [(Shape::RIB, "rib", 21.18), (Shape::BLADE, "blade", 11.98), (Shape::LOOP, "loop", 14.97)]
    {
        for rpm in [6.0, 60.0] {
            let means = [(360, 400), (720, 800)].map(|(columns, rows)| {
                let forces = felt(shape, edge_mm, GridShape::new(columns, rows).unwrap(), rpm);
                let mean = forces.iter().sum::<Vec3>() / forces.len() as f32;
                let spread: f32 = forces.iter().map(|force| force.distance_squared(mean)).sum();
                let spread = (spread / forces.len() as f32).sqrt() / mean.length();
                let leap = forces.windows(2).map(|pair| pair[0].distance(pair[1])).fold(0.0, f32::max) / mean.length();
                println!("{name} at {rpm} turns on {columns} x {rows}: {:.2} N, {spread:.4} of it about that, leaps {leap:.4}", mean.length());
                assert!(mean.length() > 1.0 && spread < 0.06 && leap < 0.06, "{name} at {rpm} turns on {columns} columns");
                mean.length()
            });
            assert!((means[1] / means[0] - 1.0).abs() < 0.05, "{name} at {rpm} turns: {means:?} N");
        }
    }
}
