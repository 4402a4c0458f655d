//! A hollow wall as it is seen while tools are at it: where the law says that it gives way to, and nowhere else.
#![expect(clippy::unwrap_used, reason = "an error here is a failed test")]

use std::sync::Arc;

use glam::{Quat, Vec3};
use pottery_client::render::{Camera, Deflection, Gpu, Scene, ToolView, picture_rgba};
use pottery_shared::clay::{Conditions, MethodKind, Phase, Pot, PotSpec, Press, SubStep, Support, Wheel};
use pottery_shared::tool::{ConvexTool, Shape, Side, Sphere, Tool, rack};
use pottery_shared::units::{Metres, Rpm, Tick};

fn gpu() -> Gpu {
    Gpu::headless().unwrap_or_else(|error| panic!("{error}"))
}

fn pot(support: Support) -> Pot {
    Pot::new(PotSpec { support, ..PotSpec::default() }).unwrap()
}

/// A tool as it is seen, at an angle and a height and so far from the axis.
fn tool(tool: Tool, angle_rad: f32, [distance_m, z_m]: [f32; 2]) -> ToolView {
    let centre_m = Vec3::new(distance_m * angle_rad.cos(), distance_m * angle_rad.sin(), z_m);
    let turn = Quat::from_rotation_z(angle_rad);
    ToolView { tool, turn, centre_m, colour: [0.0, 0.0, 1.0], touching: true, side: Side::Outside, clay_m: None }
}

fn ball(radius_mm: f32) -> (Tool, f32) {
    (Tool::Sphere(Sphere::new(Metres::from_mm(radius_mm)).unwrap()), radius_mm * 1e-3)
}

/// A ball of 12 mm, pressed in by 4 mm from one side.
fn pressing(side: Side, angle_rad: f32, z_m: f32) -> ToolView {
    let (of, radius_m) = ball(12.0);
    let distance_m = match side {
        Side::Outside => 0.060 + radius_m - 0.004,
        Side::Inside => 0.052 - radius_m + 0.004,
    };
    ToolView { side, ..tool(of, angle_rad, [distance_m, z_m]) }
}

fn followed(pot: &Pot, conditions: &Conditions, tools: &[ToolView]) -> Deflection {
    let mut deflection = Deflection::default();
    deflection.follow(pot, (conditions, Tick(0)), &rack::standard(), tools);
    deflection
}

/// The same clay where its wall has moved as it is drawn.
fn moved(pot: &Pot, deflection: &Deflection) -> Pot {
    let mut moved = pot.clone();
    for surface in moved.surfaces_mut() {
        let (columns, rows) = (surface.shape().columns(), surface.shape().rows());
        for column in 0..columns {
            for row in 0..rows {
                let angle_rad = column as f32 * surface.shape().column_angle_rad();
                let by_m = deflection.at_m(angle_rad, row as f32 / (rows - 1) as f32);
                surface.set_radius(column, row, surface.column_m(column)[row as usize] - by_m);
            }
        }
    }
    moved
}

#[test]
fn wall_gives_way_in_the_picture_as_the_law_says_between_all_tools() {
    let (pot, conditions) = (pot(Support::Hollow), Conditions::default());
    let tools = [pressing(Side::Outside, 0.3, 0.1), pressing(Side::Inside, 2.0, 0.15)];
    let deflection = followed(&pot, &conditions, &tools);
    let material = conditions.material.at(Tick(0));
    let presses = tools.map(|tool| Press {
        side: tool.side,
        strength: material.strength,
        ..Press::held(tool.tool, tool.centre_m)
    });
    let mut step = SubStep::for_grid(pot.spec().shape);
    let bends = step.feel_together(&pot, &presses, conditions.method).to_vec();
    let bends: Vec<_> = bends.iter().map(|contact| contact.sink.unwrap().bend(&pot.surfaces()[0]).unwrap()).collect();
    let (mut most_m, mut missed_m) = ([0.0_f32; 2], 0.0_f32);
    for number in 0..7000 {
        let (angle_rad, up) = (number as f32 * 0.617, (number as f32 * 0.377).fract());
        let law_m: f32 = bends.iter().map(|bend| bend.at_m(angle_rad, up * 0.2)).sum();
        missed_m = missed_m.max((deflection.at_m(angle_rad, up) - law_m).abs());
        most_m = [most_m[0].max(law_m), most_m[1].min(law_m)];
    }
    println!("{most_m:?} m of bending, {missed_m} m missed");
    assert!(most_m[0] > 2e-3 && most_m[1] < -2e-3, "both bend it: {most_m:?}");
    // straight lines between places
    assert!(missed_m < 0.01 * most_m[0], "{missed_m} m of {most_m:?}");
    // where nobody is, it leans and turns oval, and no more
    assert!(deflection.at_m(0.3, 0.0).abs() < 1e-6, "the foot is held");
}

#[test]
fn picture_of_a_wall_that_gives_way_is_that_of_a_pot_of_that_shape() {
    let (gpu, pot, conditions) = (gpu(), pot(Support::Hollow), Conditions::default());
    let differs = |one: &[u8], other: &[u8]| {
        let all: u64 = one.iter().zip(other).map(|(one, other)| u64::from(one.abs_diff(*other))).sum();
        all as f64 / one.len() as f64
    };
    // in the middle of the wall from outside, and at the rim from within, where the lip goes along
    for (side, z_m, elevation_rad) in [(Side::Outside, 0.1, 0.2), (Side::Inside, 0.19, 0.7), (Side::Inside, 0.12, 0.0)]
    {
        let deflection = followed(&pot, &conditions, &[pressing(side, -1.2, z_m)]);
        assert!(deflection.is_any());
        let moved = moved(&pot, &deflection);
        for is_cut in [false, true] {
            let camera = Camera { elevation_rad, distance_m: 0.35, ..Camera::default() };
            let scene = Scene { camera, is_cut, ..Scene::default() };
            let draw = |pot: &Pot, scene: &Scene<'_>| picture_rgba(&gpu, pot, scene, 480, 360).unwrap();
            let stands = draw(&pot, &scene);
            let wanted = draw(&moved, &scene);
            let seen = draw(&pot, &Scene { deflection: Some(&deflection), ..scene.clone() });
            let (off, off_undrawn) = (differs(&seen, &wanted), differs(&stands, &wanted));
            println!("{side:?} at {z_m} m, cut {is_cut}: {off:.3} steps off, {off_undrawn:.3} where nothing moves");
            assert!(off < 0.25 * off_undrawn && off < 0.5, "{side:?} at {z_m} m, cut {is_cut}: {off} of {off_undrawn}");
        }
    }
}

#[test]
fn outline_goes_with_a_tool_at_a_hollow_wall() {
    let (gpu, pot, conditions) = (gpu(), pot(Support::Hollow), Conditions::default());
    const SIZE: [u32; 2] = [1200, 800];
    let aspect = SIZE[0] as f32 / SIZE[1] as f32;
    // level with the tool, the row in the middle of the picture is one height of the pot
    let camera =
        Camera { elevation_rad: 0.0, target_m: Vec3::new(0.04, 0.0, 0.1), distance_m: 0.3, ..Camera::default() };
    let px = |ndc: f32| f64::from(0.5 * (ndc + 1.0) * SIZE[0] as f32);
    let outline_px = |deflection: &Deflection| {
        let scene = Scene { camera, deflection: Some(deflection), ..Scene::default() };
        let pixels = picture_rgba(&gpu, &pot, &scene, SIZE[0], SIZE[1]).unwrap();
        let row = &pixels[(SIZE[1] / 2 * SIZE[0] * 4) as usize..][..(SIZE[0] * 4) as usize];
        // clay is much redder than blue; its last pixel's middle lies within the outline
        let is_clay = |[red, _, blue, _]: &[u8; 4]| i32::from(*red) > i32::from(*blue) + 24;
        row.as_chunks::<4>().0.iter().rposition(is_clay).unwrap() as f64 + 1.0
    };
    let expected_px = |deflection: &Deflection| {
        let seen = (0..1440).filter_map(|step| {
            let angle_rad = step as f32 / 1440.0 * std::f32::consts::TAU;
            let radius_m = 0.060 - deflection.at_m(angle_rad, 0.5);
            camera.ndc(Vec3::new(radius_m * angle_rad.cos(), radius_m * angle_rad.sin(), 0.1), aspect)
        });
        px(seen.map(|ndc| ndc.x).fold(f32::MIN, f32::max))
    };
    let still = Deflection::default();
    assert!((outline_px(&still) - expected_px(&still)).abs() < 1.0);
    // the camera stands at −y: angle zero is at the right
    for side in [Side::Outside, Side::Inside] {
        let deflection = followed(&pot, &conditions, &[pressing(side, 0.0, 0.1)]);
        let (seen, expected) = (outline_px(&deflection), expected_px(&deflection));
        println!("{side:?}: {seen} px, {expected:.1} expected, {:.1} untouched", expected_px(&still));
        assert!((expected - expected_px(&still)).abs() > 2.0, "{side:?}: too little to be seen");
        assert!((seen - expected).abs() < 1.0, "{side:?}: outline at {seen} px and not {expected}");
    }
}

#[test]
fn a_tool_that_is_deep_in_a_wall_still_pushes_it_from_where_it_came() {
    let (pot, conditions) = (pot(Support::Hollow), Conditions::default());
    // its centre is nearer to the axis than the wall's middle, or farther from it
    for (side, distance_m, sign) in [(Side::Outside, 0.050, 1.0), (Side::Inside, 0.060, -1.0)] {
        let deep = ToolView { side, ..tool(ball(12.0).0, 0.0, [distance_m, 0.1]) };
        let moved_m = sign * followed(&pot, &conditions, &[deep]).at_m(0.0, 0.5);
        // 22 and 20 mm in, of which the clay under it takes a little
        println!("{side:?}: the wall gives way by {:.1} mm", moved_m * 1e3);
        assert!((0.012..0.023).contains(&moved_m), "{side:?}: {moved_m} m");
    }
}

#[test]
fn nothing_gives_way_on_a_core_without_tools_nor_with_methods_that_know_no_bending() {
    let (hollow, backed, conditions) = (pot(Support::Hollow), pot(Support::Backed), Conditions::default());
    let tools = [pressing(Side::Outside, 0.0, 0.1)];
    assert!(followed(&hollow, &conditions, &tools).is_any());
    assert!(!followed(&backed, &conditions, &tools).is_any());
    assert!(!followed(&hollow, &conditions, &[]).is_any());
    for method in [MethodKind::Original, MethodKind::Improved] {
        assert!(!followed(&hollow, &Conditions { method, ..Conditions::default() }, &tools).is_any());
    }
    // one that stands beside the wall, one that is nowhere, and one that is in no rack
    let away = tool(ball(12.0).0, 0.0, [0.09, 0.1]);
    let nowhere = ToolView { centre_m: Vec3::NAN, ..away };
    let unknown = ToolView { tool: Tool::Convex(Shape(200)), ..pressing(Side::Outside, 0.0, 0.1) };
    assert!(!followed(&hollow, &conditions, &[away, nowhere, unknown]).is_any());
    // what was followed once is gone with the tool
    let mut deflection = followed(&hollow, &conditions, &tools);
    deflection.follow(&hollow, (&conditions, Tick(1)), &rack::standard(), &[away]);
    assert!(!deflection.is_any() && deflection.at_m(0.0, 0.5) == 0.0);
}

#[test]
fn tools_of_facets_bend_it_as_they_are_turned_on_a_wheel_that_has_turned() {
    let pot = pot(Support::Hollow);
    let own: Arc<[ConvexTool]> = vec![rack::ball(2, Metres::from_mm(12.0)).unwrap(), rack::rib().unwrap()].into();
    let still = Conditions::default();
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0)));
    let turned = Conditions { wheel, ..Conditions::default() };
    for (shape, distance_m) in [(0, 0.068), (1, 0.078)] {
        let seen = tool(Tool::Convex(Shape(shape)), 0.4, [distance_m, 0.1]);
        let mut deflection = Deflection::default();
        deflection.follow(&pot, (&still, Tick(0)), &own, &[seen]);
        let at_m = deflection.at_m(0.4, 0.5);
        assert!(at_m > 1e-4, "shape {shape}: {at_m}");
        // a third of a turn on, the same place of the room is another of the pot
        let tick = Tick(333);
        let phase_rad = turned.phase(tick).radians() as f32;
        assert!(phase_rad.abs() > 1.0);
        deflection.follow(&pot, (&turned, tick), &own, &[seen]);
        let again_m = deflection.at_m(0.4 - phase_rad, 0.5);
        assert!((again_m - at_m).abs() < 0.03 * at_m, "shape {shape}: {again_m} and {at_m}");
    }
}
