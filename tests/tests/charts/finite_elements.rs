//! The finite-element yardstick against closed forms: what the clay is fitted to must itself be right.
//!
//! Invariant: every expected figure is a formula in this file.

use pottery_tests::yardstick::fem::body::{Body, Obstacle};
use pottery_tests::yardstick::fem::element::Material;
use pottery_tests::yardstick::fem::mesh::{Mesh, even, graded};
use pottery_tests::yardstick::fem::press::{Pace, Wall};
use pottery_tests::yardstick::fem::rezone::Lines;
use pottery_tests::yardstick::fem::stroke::{self, Drawing, Stroke};
use std::f64::consts::{FRAC_PI_2, PI};

const CLAY: Material = Material { young_pa: 2e6, poisson: 0.45, yield_pa: 40e3, density_kg_m3: 2000.0 };
/// The same without a yield point within reach.
const ELASTIC: Material = Material { yield_pa: 1e12, ..CLAY };

/// Lets the body move for a time.
fn settle(body: &mut Body, time_s: f64) {
    let mut elapsed_s = 0.0;
    while elapsed_s < time_s {
        body.step(&[], &mut []);
        elapsed_s += body.step_s;
    }
}

/// A block of 3×3×3 bricks whose nodes are moved out of line by `jolt` of their place on the grid, except where that
/// would move them off the block's faces.
fn crooked_block(jolt: impl Fn([f64; 3]) -> [f64; 3]) -> Mesh {
    let side_m = 0.03;
    let axis = even(0.0, side_m, 3);
    let mut mesh = Mesh::block(&axis, &axis, &axis);
    for node in &mut mesh.nodes {
        let moved = jolt(node.map(|part| part / side_m * 3.0));
        for axis in 0..3 {
            if node[axis] > 1e-9 && node[axis] < side_m - 1e-9 {
                node[axis] += moved[axis];
            }
        }
    }
    mesh
}

/// Carries the whole boundary of a block along one homogeneous motion: the inside must follow, and its stress be Hooke's.
fn assert_homogeneous(mesh: Mesh, assumed_shear: bool) {
    let mut body = Body::new(mesh, ELASTIC, 0.5);
    body.assumed_shear = assumed_shear;
    let rate = [[0.4, 0.1, -0.3], [0.2, -0.5, 0.25], [-0.15, 0.35, 0.3]];
    let field = |x: [f64; 3]| -> [f64; 3] { [0, 1, 2].map(|i| (0..3).map(|j| rate[i][j] * x[j]).sum()) };
    let boundary = |x: [f64; 3]| x.iter().any(|part| *part < 1e-9 || *part > 0.03 - 1e-9);
    for node in 0..body.position.len() {
        body.velocity[node] = field(body.mesh.nodes[node]);
        if boundary(body.mesh.nodes[node]) {
            body.free[node] = [0.0; 3];
        }
    }
    let mut time_s = 0.0;
    for _ in 0..40 {
        body.step(&[], &mut []);
        time_s += body.step_s;
    }
    // the stress is that of the positions before the step: one more, at rest
    body.velocity.iter_mut().for_each(|velocity| *velocity = [0.0; 3]);
    body.step(&[], &mut []);
    for (now, was) in body.position.iter().zip(&body.mesh.nodes) {
        let moved = field(*was);
        for axis in 0..3 {
            // rounding: some hundred operations a step on numbers near 0.03 m
            assert!((now[axis] - was[axis] - time_s * moved[axis]).abs() < 1e-13, "{now:?} from {was:?}");
        }
    }
    let first = body.stress(0, 0);
    let strain = |i: usize, j: usize| 0.5 * time_s * (rate[i][j] + rate[j][i]);
    let (shear, bulk) = (ELASTIC.shear_pa(), ELASTIC.bulk_pa());
    let dilation = strain(0, 0) + strain(1, 1) + strain(2, 2);
    let hooke = |i: usize, j: usize| {
        2.0 * shear * strain(i, j) + if i == j { (bulk - 2.0 / 3.0 * shear) * dilation } else { 0.0 }
    };
    let expected = [hooke(0, 0), hooke(1, 1), hooke(2, 2), hooke(0, 1), hooke(0, 2), hooke(1, 2)];
    // strains reach 0.1 %, and the bulk modulus is ten times the shear modulus: second-order terms stay below 1 %
    let scale = expected.iter().fold(0.0, |most: f64, part| most.max(part.abs()));
    for part in 0..6 {
        assert!((first[part] - expected[part]).abs() < 0.01 * scale, "{first:?} {expected:?}");
        for brick in 0..body.mesh.bricks.len() {
            for point in 0..8 {
                assert!((body.stress(brick, point)[part] - first[part]).abs() < 1e-9 * scale);
            }
        }
    }
}

#[test]
fn constant_strain_stays_constant_on_crooked_bricks() {
    let jolt = |[i, j, k]: [f64; 3]| [0.0021 * i * j - 0.004, 0.0017 * (j + 2.0 * k) - 0.008, 0.0011 * (i + k) - 0.002];
    assert_homogeneous(crooked_block(jolt), false);
}

#[test]
fn assumed_shear_keeps_constant_strain_on_bricks_with_parallel_sides() {
    assert_homogeneous(crooked_block(|[i, j, _]| [0.0021 * i * j - 0.004, 0.0017 * (j - 2.0 * i), 0.0]), true);
}

/// A quarter of a ring, 4 mm long, mirrored on both cuts; in plane strain or free to change its length.
fn quarter(material: Material, inner_m: f64, outer_m: f64, bricks: [usize; 2], plane_strain: bool) -> Body {
    let width_m = 0.004;
    let mesh = Mesh::wall(&even(0.0, FRAC_PI_2, bricks[0]), &[0.0, width_m], &even(inner_m, outer_m, bricks[1]));
    let mut body = Body::new(mesh, material, 0.8);
    for row in 0..2 {
        for layer in 0..=bricks[1] {
            body.free[body.mesh.node(0, row, layer)][1] = 0.0;
            body.free[body.mesh.node(bricks[0], row, layer)][0] = 0.0;
            for column in 0..=bricks[0] {
                let node = body.mesh.node(column, row, layer);
                if plane_strain || row == 0 {
                    body.free[node][2] = 0.0;
                }
            }
        }
    }
    body
}

/// Forces (N) that hold a wall in a small displacement (m).
fn holding_n(mut body: Body, moved_m: &[[f64; 3]]) -> Vec<[f64; 3]> {
    body.free.iter_mut().for_each(|free| *free = [0.0; 3]);
    for (velocity, moved) in body.velocity.iter_mut().zip(moved_m) {
        *velocity = moved.map(|part| part / body.step_s);
    }
    body.step(&[], &mut []);
    // the first step strains the deviator, the second the volume
    body.velocity.iter_mut().for_each(|velocity| *velocity = [0.0; 3]);
    body.step(&[], &mut []);
    body.force_n
}

#[test]
fn work_is_the_same_in_either_order() {
    for assumed_shear in [false, true] {
        let mut body = quarter(ELASTIC, 0.05, 0.06, [6, 2], false);
        body.assumed_shear = assumed_shear;
        let count = body.position.len();
        let field = |pitch: f64| -> Vec<[f64; 3]> {
            (0..count)
                .map(|node| [0.0, 1.0, 2.0].map(|axis| 1e-8 * (pitch * (3.0 * node as f64 + axis)).sin()))
                .collect()
        };
        let (first, second) = (field(1.7), field(2.9));
        let work = |moved: &[[f64; 3]], force: &[[f64; 3]]| -> f64 {
            moved.iter().zip(force).map(|(a, b)| a[0] * b[0] + a[1] * b[1] + a[2] * b[2]).sum()
        };
        let there = work(&first, &holding_n(body.clone(), &second));
        let back = work(&second, &holding_n(body.clone(), &first));
        let scale = work(&first, &holding_n(body.clone(), &first)).abs();
        // Maxwell and Betti; displacements of 1e-6 of a brick leave as much of second order
        assert!((there - back).abs() < 1e-4 * scale, "{there} {back} of {scale}, assumed shear {assumed_shear}");
    }
}

#[test]
fn thick_cylinder_under_pressure_follows_lame() {
    let (inner_m, outer_m, pressure_pa) = (0.04, 0.06, 500.0);
    let columns = 16;
    let mut body = quarter(ELASTIC, inner_m, outer_m, [columns, 10], true);
    let share_n = pressure_pa * inner_m * 0.004 * FRAC_PI_2 / columns as f64 / 2.0;
    for column in 0..=columns {
        let part = if column == 0 || column == columns { 0.5 } else { 1.0 };
        for row in 0..2 {
            let node = body.mesh.node(column, row, 0);
            let at = body.mesh.nodes[node];
            let along = at[0].hypot(at[1]);
            body.load_n[node] = [part * share_n * at[0] / along, part * share_n * at[1] / along, 0.0];
        }
    }
    body.drag_per_s = 1000.0;
    settle(&mut body, 0.03);
    let (a2, b2) = (inner_m * inner_m, outer_m * outer_m);
    let grade = pressure_pa * a2 / (b2 - a2);
    // Lamé, plane strain: u = (1 + ν)/E · p a²/(b² − a²) · ((1 − 2ν) r + b²/r)
    let lame = |r: f64| (1.0 + 0.45) / 2e6 * grade * ((1.0 - 0.9) * r + b2 / r);
    for (layer, radius_m) in [(0, inner_m), (10, outer_m)] {
        let node = body.mesh.node(columns / 2, 0, layer);
        let moved = body.position[node][0].hypot(body.position[node][1]) - radius_m;
        println!("u({radius_m}) {moved:.4e} lame {:.4e}", lame(radius_m));
        // 16 flat facets on a quarter circle: chord error (π/32)²/2 = 0.5 %
        assert!((moved / lame(radius_m) - 1.0).abs() < 0.01, "{moved} {}", lame(radius_m));
    }
}

#[test]
fn tube_at_its_limit_carries_the_plastic_pressure() {
    let (inner_m, outer_m, columns) = (0.04, 0.06, 16);
    // stiff clay, so that the limit is reached while the tube keeps its shape
    let stiff = Material { yield_pa: 4e3, ..CLAY };
    let mut body = quarter(stiff, inner_m, outer_m, [columns, 10], true);
    body.drag_per_s = 500.0;
    let speed = 0.004;
    for column in 0..=columns {
        for row in 0..2 {
            let node = body.mesh.node(column, row, 0);
            let at = body.mesh.nodes[node];
            body.velocity[node] = [speed * at[0] / inner_m, speed * at[1] / inner_m, 0.0];
            body.free[node] = [0.0; 3];
        }
    }
    settle(&mut body, 0.1);
    body.velocity.iter_mut().for_each(|velocity| *velocity = [0.0; 3]);
    settle(&mut body, 0.03);
    let mut force_n = 0.0;
    for column in 0..=columns {
        for row in 0..2 {
            let node = body.mesh.node(column, row, 0);
            let (at, force) = (body.position[node], body.force_n[node]);
            force_n -= (force[0] * at[0] + force[1] * at[1]) / at[0].hypot(at[1]);
        }
    }
    let radius = |layer: usize| {
        let at = body.position[body.mesh.node(columns / 2, 0, layer)];
        at[0].hypot(at[1])
    };
    let (a, b) = (radius(0), radius(10));
    let pressure_pa = force_n / (FRAC_PI_2 * a * 0.004);
    // Hill 1950: p = 2Y/√3 · ln(b/a) in plane strain
    let limit_pa = 2.0 * 4e3 / 3.0_f64.sqrt() * (b / a).ln();
    println!("p {pressure_pa:.2} limit {limit_pa:.2} a {a} b {b}");
    assert!((pressure_pa / limit_pa - 1.0).abs() < 0.015, "{pressure_pa} {limit_pa}");
}

#[test]
fn bar_yields_at_its_yield_stress_and_unloads_along_its_stiffness() {
    let side = even(0.0, 0.01, 2);
    let mut body = Body::new(Mesh::block(&side, &side, &even(0.0, 0.02, 4)), CLAY, 0.7);
    // ρ · drag · speed · length stays below 0.1 % of the yield stress
    body.drag_per_s = 100.0;
    let drive = |body: &mut Body, rate: f64| {
        for node in 0..body.position.len() {
            let was = body.mesh.nodes[node];
            for axis in (0..3).filter(|axis| was[*axis] < 1e-9) {
                body.free[node][axis] = 0.0;
            }
            if was[2] > 0.02 - 1e-9 {
                body.free[node][2] = 0.0;
                body.velocity[node][2] = rate * 0.02;
            }
        }
    };
    let pull = |body: &Body| -> f64 {
        let side = |level: usize| body.position[body.mesh.node(2, 2, level)];
        // a bar that flows necks a little where it first flowed; its weakest section carries the yield stress
        let area = (0..=4).map(|level| side(level)[0] * side(level)[1]).fold(f64::INFINITY, f64::min);
        let top = (0..body.position.len()).filter(|node| body.mesh.nodes[*node][2] > 0.02 - 1e-9);
        -top.map(|node| body.force_n[node][2]).sum::<f64>() / area
    };
    for node in 0..body.position.len() {
        let at = body.mesh.nodes[node];
        body.velocity[node] = [-0.45 * 0.3 * at[0], -0.45 * 0.3 * at[1], 0.3 * at[2]];
    }
    drive(&mut body, 0.3);
    settle(&mut body, 0.1);
    let flowing = pull(&body);
    println!("flow {flowing}");
    assert!((flowing / 40e3 - 1.0).abs() < 2e-3, "{flowing}");
    drive(&mut body, 0.0);
    settle(&mut body, 0.01);
    let flowing = pull(&body);
    let before = body.position[body.mesh.node(0, 0, 4)][2];
    drive(&mut body, -0.3);
    settle(&mut body, 0.03);
    drive(&mut body, 0.0);
    settle(&mut body, 0.03);
    let (after, left) = (body.position[body.mesh.node(0, 0, 4)][2], pull(&body));
    let stiffness = (flowing - left) / (before / after).ln();
    println!("E {stiffness}");
    assert!((stiffness / 2e6 - 1.0).abs() < 0.01, "{stiffness}");
}

/// Force on a rigid ball pressed into a deep elastic block, with bricks of this edge.
fn hertz_n(edge_m: f64) -> f64 {
    let (radius_m, depth_m, size_m) = (0.04, 0.000_225, 0.1);
    let side = graded(size_m, edge_m, 0.0045, 1.5, 0.03);
    let down: Vec<f64> = side.iter().rev().map(|depth| -depth).collect();
    let mut body = Body::new(Mesh::block(&side, &side, &down), ELASTIC, 0.85);
    let mut surface = Vec::new();
    let top = down.len() - 1;
    for i in 0..side.len() {
        for j in 0..side.len() {
            surface.push(body.mesh.node(i, j, top) as u32);
            body.free[body.mesh.node(i, j, 0)][2] = 0.0;
            for k in 0..=top {
                let (low, high) = (body.mesh.node(0, j, k), body.mesh.node(i, 0, k));
                body.free[low][0] = 0.0;
                body.free[high][1] = 0.0;
            }
        }
    }
    body.drag_per_s = 600.0;
    let mut reactions = [[0.0; 3]];
    let (mut time_s, mut sum_n, mut count) = (0.0, 0.0, 0.0);
    while time_s < 0.012 {
        time_s += body.step_s;
        let phase = (time_s / 0.006).min(1.0);
        let ball =
            Obstacle::Ball { centre_m: [0.0, 0.0, radius_m - depth_m * (0.5 - 0.5 * (PI * phase).cos())], radius_m };
        body.step(&[(ball, &surface)], &mut reactions);
        if time_s > 0.010 {
            sum_n += 4.0 * reactions[0][2];
            count += 1.0;
        }
    }
    sum_n / count
}

#[test]
fn ball_on_an_elastic_block_converges_to_hertz() {
    let stiffness = 2e6 / (1.0 - 0.45 * 0.45);
    let hertz = 4.0 / 3.0 * stiffness * 0.04_f64.sqrt() * 0.000_225_f64.powf(1.5);
    let (coarse, fine) = (hertz_n(0.0015) / hertz, hertz_n(0.00075) / hertz);
    println!("coarse {coarse} fine {fine}");
    // two and four bricks to the radius of contact; the block's depth alone adds 1 %
    assert!((coarse - 1.0).abs() < 0.05, "{coarse}");
    assert!((fine - 1.0).abs() < 0.02, "{fine}");
}

#[test]
fn ring_between_two_lines_flattens_as_theory_says() {
    let (inner_m, outer_m) = (0.048, 0.052);
    let (columns, layers) = (24, 2);
    let mut body = quarter(ELASTIC, inner_m, outer_m, [columns, layers], false);
    let load_n = 1e-3;
    for row in 0..2 {
        let node = body.mesh.node(0, row, layers);
        body.load_n[node][0] = -0.25 * load_n;
    }
    // slowest mode near 15 Hz
    body.drag_per_s = 150.0;
    settle(&mut body, 0.25);
    let node = body.mesh.node(0, 0, 1);
    let shorter = 2.0 * (body.mesh.nodes[node][0] - body.position[node][0]);
    // Timoshenko: ΔD = 0.1488 P R³/(E I), I = w t³/12
    let inertia = 0.004 * 0.004_f64.powi(3) / 12.0;
    let theory = 0.1488 * load_n * 0.05_f64.powi(3) / (2e6 * inertia);
    println!("ring {shorter:.4e} theory {theory:.4e} {}", shorter / theory);
    assert!((shorter / theory - 1.0).abs() < 0.03, "{}", shorter / theory);
}

#[test]
fn bricks_made_anew_lie_on_their_lines_and_leave_surface_and_stress_where_they_are() {
    let (inner_m, outer_m) = (0.052, 0.060);
    let (angles, heights_m) = (even(-0.3, 0.3, 20), even(0.0, 0.03, 15));
    let bumpy_m = |angle: f64, z_m: f64| outer_m + 5e-4 * (angle * 12.0).cos() * (z_m * 150.0).cos();
    let mut mesh = Mesh::wall(&angles, &heights_m, &even(inner_m, outer_m, 3));
    let lines = Lines::of(&Body::new(mesh.clone(), ELASTIC, 0.5));
    for node in &mut mesh.nodes {
        // rows a third of a brick off, and later columns
        node[2] += 0.33 * 0.002 * (PI * node[2] / 0.03).sin();
        let (angle, radius_m) = (node[1].atan2(node[0]), node[0].hypot(node[1]));
        let part = (radius_m - inner_m) / (outer_m - inner_m);
        let wider = (inner_m + part * (bumpy_m(angle, node[2]) - inner_m)) / radius_m;
        (node[0], node[1]) = (node[0] * wider, node[1] * wider);
    }
    let mut body = Body::new(mesh, ELASTIC, 0.5);
    body.assumed_shear = false;
    // turned about the axis and stretched along it, each the same everywhere
    let (turns_per_s, stretches_per_s) = (18.0, 30.0);
    for node in 0..body.position.len() {
        let [x, y, z] = body.mesh.nodes[node];
        body.velocity[node] = [-turns_per_s * y, turns_per_s * x, stretches_per_s * z];
        body.free[node] = [0.0; 3];
    }
    let mut time_s = 0.0;
    while time_s < 5e-4 {
        body.step(&[], &mut []);
        time_s += body.step_s;
    }
    // the stress is that of the positions before the step: one more, at rest
    body.velocity.fill([0.0; 3]);
    body.step(&[], &mut []);
    let stress = body.stress(0, 0);
    let mass_kg: f64 = body.mass_kg.iter().sum();
    let astray = lines.astray(&body);
    assert!(astray > 0.2, "{astray} of a brick");
    body.free.fill([1.0; 3]);
    lines.rezone(&mut body, 0.1);
    // a section is as long as the chords between its nodes, which are others now
    assert!(lines.astray(&body) < 0.01, "{}", lines.astray(&body));
    for brick in 0..body.mesh.bricks.len() {
        for point in 0..8 {
            let new = body.stress(brick, point);
            let mean = |stress: &[f64; 6]| (stress[0] + stress[1] + stress[2]) / 3.0;
            let pressed = mean(&new) - mean(&stress);
            // what the chords cut off between nodes is given back, and makes the bricks that moved a little fuller
            assert!(pressed.abs() < 1e-3 * stress[2].abs(), "{stress:?} {new:?}");
            let grown = [pressed, pressed, pressed, 0.0, 0.0, 0.0];
            let off = (0..6).map(|part| (stress[part] + grown[part] - new[part]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6 * stress[2].abs(), "{stress:?} {new:?}");
        }
    }
    let [columns, rows, layers] = body.mesh.counts;
    let turned = (turns_per_s * time_s).atan();
    let wider = turned.cos().recip();
    for column in 2..columns - 2 {
        for row in 2..rows - 2 {
            let at = body.position[body.mesh.node(column, row, layers - 1)];
            let surface_m = wider * bumpy_m(at[1].atan2(at[0]) - turned, at[2] / (1.0 + stretches_per_s * time_s));
            // cubics between points 1.8 and 2 mm apart, on bumps 31 and 42 mm long
            assert!((at[0].hypot(at[1]) - surface_m).abs() < 2e-6, "{at:?} {surface_m}");
        }
    }
    let new_kg: f64 = body.mass_kg.iter().sum();
    assert!((new_kg / mass_kg - 1.0).abs() < 1e-9, "{new_kg} of {mass_kg} kg");
}

/// Strokes of 1 mm of a ball of 12 mm along a coarse, short wall.
fn strokes(heights_m: &[f64]) -> Vec<Stroke> {
    let drawing = Drawing {
        wall: Wall {
            radius_m: 0.060,
            wall_m: 0.008,
            height_m: 0.060,
            layers: 3,
            fine_m: 0.0025,
            fine_until_m: 0.010,
            growth: 1.5,
            coarse_m: 0.012,
        },
        ball_m: 0.012,
        strokes: heights_m.iter().map(|height_m| [0.001, *height_m]).collect(),
        length_m: 0.020,
        margin_m: 0.015,
        speed_m_s: 0.8,
        material: CLAY,
        pace: Pace { load_s_m: 10.0, rest_s: 0.01, moving_drag_per_s: 100.0, resting_drag_per_s: 400.0, courant: 0.8 },
    };
    let mut strokes = Vec::new();
    stroke::run(&drawing, |stroke| strokes.push(stroke.clone())).expect("a mesh so coarse keeps its shape");
    strokes
}

#[test]
fn half_a_wall_is_pressed_as_the_whole_one_is() {
    let (half, whole) = (&strokes(&[0.03])[0], &strokes(&[0.03, 0.03])[0]);
    for (half_n, whole_n) in [(half.moving_n, whole.moving_n), (half.held_n, whole.held_n)] {
        println!("half {half_n:.3?} N, whole {whole_n:.3?} N");
        // the whole wall is clamped at its foot, 30 mm below the ball, and nodes of so coarse a mesh come into contact at other moments
        let off = |axis: usize| (half_n[axis] - whole_n[axis]).abs() / whole_n[0];
        assert!(off(0) < 0.1 && off(1) < 0.05, "{half_n:?} {whole_n:?}");
        assert_eq!(half_n[2], 0.0);
    }
    let (half, whole) = (&half.unloaded.0, &whole.unloaded.0);
    let (path_mm, mut squares, mut count) = (30.0, 0.0, 0.0);
    for row in half.iter().filter(|row| (row[4] - path_mm).abs() < 12.0) {
        let [angle0, z0_mm] = [row[3], row[4]];
        let at = |rows: &[[f64; 6]], z_mm: f64| {
            rows.iter().find(|row| (row[3] - angle0).abs() < 1e-6 && (row[4] - z_mm).abs() < 1e-6).copied()
        };
        let mirror = at(half, 2.0 * path_mm - z0_mm).unwrap();
        assert_eq!((row[0], row[2]), (mirror[0], mirror[2]));
        let other = at(whole, z0_mm).unwrap();
        squares += (row[2] - other[2]).powi(2);
        count += 1.0;
    }
    let apart_mm = f64::sqrt(squares / count);
    println!("surfaces differ by {apart_mm:.4} mm, RMS of {count} points");
    // a twentieth of the travel, as neighbouring meshes do
    assert!(apart_mm < 0.05, "{apart_mm} mm");
}
