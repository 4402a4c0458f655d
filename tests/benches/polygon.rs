//! Time in which a convex tool is cut by the lattice, beside the sphere's closed form, and of whole steps of the clay with
//! one, beside those with a sphere that touches as many elements.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench polygon`.

use std::hint::black_box;
use std::sync::Arc;
use std::time::Instant;

use glam::{Quat, Vec2, Vec3};
use pottery_shared::clay::{MethodKind, Pot, PotSpec, Press, SubStep, Support};
use pottery_shared::tool::{ConvexError, ConvexTool, Lattice, Pose, Sections, Shape, Side, Sides, Sphere, Tool, rack};
use pottery_shared::units::Metres;

const COLUMNS: usize = 360;
const ROWS: u32 = 400;
const ROW_HEIGHT_M: f32 = 0.2 / 399.0;
/// Radius of the cylinder of clay that is pressed, m.
const CLAY_M: f32 = 0.06;
const PRESSES: usize = 4000;

fn main() -> Result<(), ConvexError> {
    let directions: Vec<Vec2> =
        (0..COLUMNS).map(|column| Vec2::from_angle(column as f32 * std::f32::consts::TAU / COLUMNS as f32)).collect();
    let lattice = Lattice { directions: &directions, rows: ROWS, row_height_m: ROW_HEIGHT_M };
    let ball_of = |subdivisions, radius_mm| rack::ball(subdivisions, Metres::from_mm(radius_mm));
    let ball = |subdivisions| ball_of(subdivisions, 12.0);
    // flat to the clay, with its long side round the pot
    let lying = Quat::from_xyzw(1.0, 0.0, 1.0, 0.0);
    let tilted = Quat::from_xyzw(0.1, 0.2, 0.3, 0.9);
    println!("tool      facets elements columns cut_ns_p50 cut_ns_p99 sphere_ns_p50");
    for (name, tool, orientation) in [
        ("rib", rack::rib()?, lying),
        ("rib", rack::rib()?, tilted),
        ("blade", rack::blade()?, tilted),
        ("knuckle", rack::knuckle()?, tilted),
        ("loop", rack::loop_end()?, tilted),
        ("ball(2)", ball(2)?, tilted),
        ("ball(3)", ball(3)?, tilted),
        ("ball(4)", ball(4)?, tilted),
    ] {
        for elements in [300, 1000] {
            run(name, &tool, orientation, &lattice, elements);
        }
    }
    println!(
        "\nmethod   side    tool           elements step_ns_p50 step_ns_p99 sphere_mm sphere_elements sphere_ns_p50 sphere_ns_p99 ratio_p50"
    );
    let tools = [
        ("rib", rack::rib()?, 12.0),
        ("blade", rack::blade()?, 12.0),
        ("knuckle", rack::knuckle()?, 12.0),
        ("loop", rack::loop_end()?, 12.0),
        ("ball(2)", ball(2)?, 12.0),
        ("ball(3)", ball(3)?, 12.0),
        ("ball(3) 16 mm", ball_of(3, 16.0)?, 16.0),
        ("ball(3) 20 mm", ball_of(3, 20.0)?, 20.0),
        ("ball(3) 25 mm", ball_of(3, 25.0)?, 25.0),
        ("ball(4)", ball(4)?, 12.0),
    ];
    let rack: Arc<[ConvexTool]> = tools.iter().map(|(_, tool, _)| tool.clone()).collect();
    for (method, side, wanted) in [
        (MethodKind::Original, Side::Outside, &[300, 1000][..]),
        (MethodKind::Plastic, Side::Outside, &[300, 1000]),
        // a wall that bends is touched by no more
        (MethodKind::Plastic, Side::Inside, &[300]),
    ] {
        for (number, (name, _, sphere_mm)) in tools.iter().enumerate() {
            for wanted in wanted {
                steps((method, side), name, (&rack, number), *sphere_mm, *wanted);
            }
        }
    }
    Ok(())
}

/// Whole steps with a tool of facets and with a sphere in turn, each on its own pot that turns under it: on a core from outside, in a wall from
/// inside.
fn steps(
    (method, side): (MethodKind, Side),
    name: &str,
    (tools, number): (&Arc<[ConvexTool]>, usize),
    sphere_mm: f32,
    wanted: u32,
) {
    let is_inside = side == Side::Inside;
    let support = if is_inside { Support::Hollow } else { Support::Backed };
    let spec = PotSpec { support, ..PotSpec::default() };
    let mut pots = [0, 1].map(|_| Pot::new(spec).expect("the pot can be made"));
    let shape = pots[0].spec().shape;
    let mut substep = SubStep::with_rack(shape, Arc::clone(tools));
    let facets = Tool::Convex(Shape(number as u8));
    let sphere = Tool::Sphere(Sphere::new(Metres::from_mm(sphere_mm)).expect("the tool is in range"));
    // a rib presses with its straight edge upright, a hair tilted
    let tilted = Quat::from_xyzw(0.02, 0.03, -0.7, 0.7);
    let held = |tool: Tool, step: usize, distance_m: f32| {
        let pose = pose(step, distance_m, tilted);
        Press { side, orientation: pose.orientation, turning: 1, response: 0.0, ..Press::held(tool, pose.centre_m) }
    };
    let mut distance_m = |tool: Tool| {
        let (mut near_m, mut far_m) = if is_inside { (0.02, CLAY_M) } else { (0.03, CLAY_M + 0.1) };
        for _ in 0..25 {
            let middle_m = (near_m + far_m) / 2.0;
            let contact = substep.advance(&mut pots[0], &[held(tool, 0, middle_m)], method, |_, _| {})[0];
            if (contact.elements > wanted) != is_inside { near_m = middle_m } else { far_m = middle_m }
        }
        near_m
    };
    let presses = [facets, sphere].map(|tool| (tool, distance_m(tool)));
    let mut times_ns = [Vec::with_capacity(PRESSES), Vec::with_capacity(PRESSES)];
    let mut elements = [0; 2];
    for step in 0..PRESSES {
        for (which, (tool, distance_m)) in presses.into_iter().enumerate() {
            // so soft an answer that as many elements are touched in the end
            let press = Press { response: 1e-4, ..held(tool, step, distance_m) };
            let begin = Instant::now();
            let contact = substep.advance(&mut pots[which], &[press], method, |_, _| {})[0];
            times_ns[which].push(begin.elapsed().as_nanos());
            elements[which] = black_box(contact.elements);
        }
    }
    let [own, sphere] = times_ns.map(|mut times| {
        times.sort_unstable();
        [times[PRESSES / 2], times[PRESSES * 99 / 100]]
    });
    println!(
        "{:<8} {:<7} {name:<14} {:>8} {:>11} {:>11} {sphere_mm:>9} {:>15} {:>13} {:>13} {:>9.2}",
        format!("{method:?}"),
        format!("{side:?}"),
        elements[0],
        own[0],
        own[1],
        elements[1],
        sphere[0],
        sphere[1],
        own[0] as f64 / sphere[0] as f64,
    );
}

/// The tool at a distance from the axis, as the wheel turns under it.
fn pose(step: usize, distance_m: f32, orientation: Quat) -> Pose {
    let turn_rad = step as f32 * 1e-3 * std::f32::consts::TAU;
    let out = Vec2::from_angle(turn_rad) * distance_m;
    Pose { centre_m: out.extend(0.07 + step as f32 * 1e-5), orientation: Quat::from_rotation_z(turn_rad) * orientation }
}

fn elements(sections: &Sections) -> usize {
    sections.iter().map(|section| section.near_m.len()).sum()
}

fn run(name: &str, tool: &ConvexTool, orientation: Quat, lattice: &Lattice<'_>, wanted: usize) {
    let mut sections = Sections::for_lattice(COLUMNS as u32, ROWS);
    // as near to the axis as it takes for so many elements
    let (mut near_m, mut far_m) = (0.02, CLAY_M + tool.radius().0);
    for _ in 0..30 {
        let distance_m = (near_m + far_m) / 2.0;
        sections.cut(tool, &pose(0, distance_m, orientation), lattice, CLAY_M, Sides::Near);
        if elements(&sections) > wanted { near_m = distance_m } else { far_m = distance_m }
    }
    let (mut cuts_ns, mut spheres_ns) = (Vec::with_capacity(PRESSES), Vec::with_capacity(PRESSES));
    let mut near_by_row_m = vec![0.0; ROWS as usize];
    for step in 0..PRESSES {
        let held = pose(step, near_m, orientation);
        let begin = Instant::now();
        sections.cut(tool, &held, lattice, CLAY_M, Sides::Near);
        cuts_ns.push(begin.elapsed().as_nanos());
        black_box(&sections);
        let centre_m = pose(step, sphere_distance_m(wanted), orientation).centre_m;
        let begin = Instant::now();
        sphere(centre_m, lattice, &mut near_by_row_m);
        spheres_ns.push(begin.elapsed().as_nanos());
    }
    cuts_ns.sort_unstable();
    spheres_ns.sort_unstable();
    println!(
        "{name:<9} {:>6} {:>8} {:>7} {:>10} {:>10} {:>13}",
        tool.normals().len(),
        elements(&sections),
        sections.iter().len(),
        cuts_ns[PRESSES / 2],
        cuts_ns[PRESSES * 99 / 100],
        spheres_ns[PRESSES / 2],
    );
}

/// Distance from the axis of a sphere of 12 mm that touches about so many elements.
fn sphere_distance_m(elements: usize) -> f32 {
    CLAY_M + 0.012 - if elements > 500 { 0.009 } else { 0.0026 }
}

/// Near side of a sphere of 12 mm over its window, row by row without a branch: `s = b − √(b² − c)`.
fn sphere(centre_m: Vec3, lattice: &Lattice<'_>, near_m: &mut [f32]) {
    const RADIUS_M: f32 = 0.012;
    let middle = (f32::atan2(centre_m.y, centre_m.x) / std::f32::consts::TAU * COLUMNS as f32).round() as i64;
    let distance_m = centre_m.truncate().length();
    let half = ((RADIUS_M / distance_m).asin() / std::f32::consts::TAU * COLUMNS as f32).ceil() as i64;
    let first_row = ((centre_m.z - RADIUS_M) / ROW_HEIGHT_M).ceil().max(0.0) as usize;
    let end_row = (((centre_m.z + RADIUS_M) / ROW_HEIGHT_M) as usize + 1).min(ROWS as usize);
    for column in middle - half..=middle + half {
        let direction = lattice.directions[column.rem_euclid(COLUMNS as i64) as usize];
        let (along_m, aside_m) = (direction.dot(centre_m.truncate()), direction.perp_dot(centre_m.truncate()));
        let within_m2 = RADIUS_M * RADIUS_M - aside_m * aside_m;
        for (row, near_m) in (first_row as i32..).zip(&mut near_m[first_row..end_row]) {
            let above_m = row as f32 * ROW_HEIGHT_M - centre_m.z;
            let chord_m2 = within_m2 - above_m * above_m;
            *near_m = if chord_m2 > 0.0 { along_m - chord_m2.sqrt() } else { f32::INFINITY };
        }
        black_box(&mut *near_m);
    }
}
