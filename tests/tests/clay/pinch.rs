//! Several tools at one hollow wall: they bend it together, against the finite-element pot with a finger inside.
//!
//! The reference is not of this project's making; `tests/data/reference/README.md` says where it stands.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::f32::consts::PI;
use std::path::Path;

use glam::{Quat, Vec3};
use pottery_client::stroke::Stroke;
use pottery_shared::clay::{
    Conditions, Contact, GridShape, MethodKind, Phase, Pot, PotSpec, Press, Strength, SubStep, Support, Wheel,
};
use pottery_shared::prediction::{Field, Hand, Patch};
use pottery_shared::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample, rack};
use pottery_shared::units::{Metres, Seconds, Tick};
use pottery_tests::chart::cases::{FINGER, Support as Standing, reference_dent, reference_profile};
use pottery_tests::dent::{Dent, Dented, Pressing};
use pottery_tests::reference::ForceCurve;
use proptest::prelude::*;

const FORCE: &str = include_str!("../../data/reference/F_depth_force.csv");

fn hollow(shape: GridShape) -> Pot {
    Pot::new(PotSpec { shape, support: Support::Hollow, ..PotSpec::default() }).unwrap()
}

fn coarse() -> GridShape {
    GridShape::new(90, 100).unwrap()
}

/// A ball that is so deep in the untouched wall, mm, at an angle and a height.
fn ball(radius_mm: f32, side: Side, depth_mm: f32, angle_rad: f32, z_mm: f32) -> Press {
    let distance_mm = match side {
        Side::Outside => 60.0 + radius_mm - depth_mm,
        Side::Inside => 52.0 - radius_mm + depth_mm,
    };
    let centre_mm = Vec3::new(distance_mm * angle_rad.cos(), distance_mm * angle_rad.sin(), z_mm);
    let tool = Sphere::new(Metres::from_mm(radius_mm)).unwrap();
    Press { side, ..Press::held(tool, centre_mm * 1e-3) }
}

/// The first standard tool of facets, a rib that stands upright, so deep in the wall at angle 0.
fn rib(depth_mm: f32, z_mm: f32) -> Press {
    let tool = Tool::Convex(Shape(0));
    let press = Press { tool, ..ball(5.0, Side::Outside, 0.0, 0.0, z_mm) };
    // its edge is 20 mm from its centre
    Press { centre_m: press.centre_m.with_x(0.080 - depth_mm * 1e-3), ..press }
}

fn felt(pot: &Pot, press: &Press, beside: &[Press]) -> Contact {
    SubStep::for_grid(pot.spec().shape).feel_beside(pot, press, beside, MethodKind::Plastic)
}

/// Two to five tools on either side of the wall, most of them near each other and some so deep that the wall has to fold.
fn several() -> impl Strategy<Value = Vec<Press>> {
    let angle_rad = prop_oneof![3 => -0.3_f32..0.3, 1 => -PI..PI];
    let one = (5.0_f32..20.0, any::<bool>(), -1.0_f32..12.0, angle_rad, -20.0_f32..20.0, any::<bool>());
    (0.0_f32..210.0, prop::collection::vec(one, 2..=5)).prop_map(|(height_mm, all)| {
        let of = |(radius_mm, is_inside, depth_mm, angle_rad, above_mm, is_rib)| {
            let side = if is_inside { Side::Inside } else { Side::Outside };
            let press = ball(radius_mm, side, depth_mm, angle_rad, height_mm + above_mm);
            if is_rib && !is_inside { Press { tool: Tool::Convex(Shape(0)), ..press } } else { press }
        };
        all.into_iter().map(of).collect()
    })
}

#[test]
fn finger_inside_holds_the_wall_as_in_the_reference() {
    let reference_n = ForceCurve::parse(FORCE).unwrap().largest_n();
    let profile = reference_profile(Standing::Finger, 1, false);
    let dent = Dent {
        pot: PotSpec { support: Support::Hollow, ..PotSpec::default() },
        finger: Some(FINGER),
        ..reference_dent(GridShape::PAPER, 1.0, false)
    };
    let [held, free] = [dent, Dent { finger: None, ..dent }].map(|dent| dent.press().unwrap());
    let error = |dented: &Dented| dented.error(&profile, &dent);
    let finger_n = held.finger_n.unwrap();
    println!(
        "1 mm: {:.2} N, {finger_n:.2} N of it on the finger, reference {reference_n:.2} N; without a finger {:.2} N. Shape off by \
         {:.3} of the travel, without a finger {:.3}",
        held.force_n,
        free.force_n,
        error(&held),
        error(&free)
    );
    let gone = Dent { release: true, ..dent };
    let stays = reference_profile(Standing::Finger, 1, true);
    let left = gone.press().unwrap();
    let [thick_mm, thick_there_mm] = [
        8.0 + left.radial_mm_at(0.0, 100.0) - left.behind_mm.unwrap(),
        60.0 + stays.radial_mm(0.0, 100.0) - stays.inner_mm(0.0, 100.0),
    ];
    println!(
        "released {:.3}, and a wall of {thick_mm:.2} mm between both, where the reference has {thick_there_mm:.2}",
        left.error(&stays, &gone)
    );
    assert!(left.error(&stays, &gone) < 0.04);
    assert!((thick_mm - thick_there_mm).abs() < 0.2, "{thick_mm} mm");
    assert!((f64::from(held.force_n) / reference_n - 1.0).abs() < 0.08, "{} N", held.force_n);
    assert!(f64::from(free.force_n) < 0.4 * reference_n, "{} N", free.force_n);
    assert!(finger_n > 0.6 * held.force_n && finger_n < held.force_n);
    assert!(error(&held) < 0.08, "{}", error(&held));
}

#[test]
fn a_wall_that_is_pressed_on_against_a_finger_goes_on_bearing() {
    // pot's radius, wall, ball and finger, mm
    for scene in [[60.0, 8.0, 12.0, 12.0], [60.0, 8.0, 20.0, 12.0], [60.0, 5.0, 12.0, 20.0], [40.0, 8.0, 8.0, 8.0]] {
        let [radius, wall, tool, finger] = scene.map(Metres::from_mm);
        let deepest_m = (wall.0 - 1.05e-3).min(6.5e-3);
        let pot = PotSpec { radius, wall, support: Support::Hollow, ..PotSpec::default() };
        let reference = reference_dent(GridShape::PAPER, 1.0, false);
        let dent = Dent { pot, tool, finger: Some(finger), depth: Metres(deepest_m), ..reference };
        let mut pressing = Pressing::new(dent, Seconds(1e-3)).unwrap();
        let (mut before_n, mut most_n, mut largest) = (0.0, 0.0_f32, 0.0_f32);
        for step in 1..=(deepest_m / 1e-5) as u32 {
            let force_n = pressing.step(0.0, step as f32 * 1e-5, 0.1, 0);
            most_n = most_n.max(force_n);
            largest = largest.max((before_n - force_n) / most_n);
            before_n = force_n;
        }
        println!("{scene:?}: up to {most_n:.1} N, and within 10 µm less by up to {largest:.3} of that");
        assert!(largest < 0.1, "{scene:?}: {largest}");
        assert!(before_n > 0.8 * most_n, "{scene:?}: {before_n} of {most_n} N");
    }
}

#[test]
fn a_wall_held_between_ball_and_finger_bears_the_more_the_deeper_down_to_the_thinnest() {
    // wall, ball and finger, mm
    let scenes = [
        [3.0, 12.0, 15.0],
        [4.0, 12.0, 15.0],
        [5.0, 12.0, 15.0],
        [5.0, 20.0, 12.0],
        [6.0, 16.0, 10.0],
        [8.0, 12.0, 15.0],
    ];
    for scene @ [wall_mm, tool_mm, finger_mm] in scenes {
        let pot = PotSpec { wall: Metres::from_mm(wall_mm), support: Support::Hollow, ..PotSpec::default() };
        let reference = reference_dent(GridShape::PAPER, 1.0, false);
        let dent = Dent { pot, tool: Metres::from_mm(tool_mm), finger: Some(Metres::from_mm(finger_mm)), ..reference };
        let mut pressing = Pressing::new(dent, Seconds(1e-3)).unwrap();
        let (mut held_n, mut before_um) = (Vec::new(), 0);
        for depth_um in
            (1..).map(|twentieth| 50 * twentieth).take_while(|&depth_um| depth_um as f32 <= 1e3 * wall_mm - 1e3)
        {
            for um in (before_um..depth_um).step_by(10) {
                pressing.step(0.0, (um + 10) as f32 * 1e-6, 0.1, 0);
            }
            let forces_n = [0; 60].map(|_| pressing.step(0.0, depth_um as f32 * 1e-6, 0.1, 0));
            held_n.push(forces_n[59]);
            before_um = depth_um;
        }
        println!("{scene:?}, every 0.05 mm: {held_n:.2?} N");
        assert!(held_n.is_sorted_by(|before_n, now_n| *now_n > 0.99 * before_n), "{scene:?}: {held_n:?} N");
    }
}

/// Thickness of the wall at every element, mm.
fn walls_mm(pot: &Pot) -> Vec<f32> {
    let [outer, inner, ..] = pot.surfaces() else { panic!("a hollow pot has two skins") };
    outer.radii_m().iter().zip(inner.radii_m()).map(|(outer_m, inner_m)| (outer_m - inner_m) * 1e3).collect()
}

/// Presses so often and lets the pot settle.
fn pressed(pot: &mut Pot, presses: &[Press], steps: u32) {
    let mut substep = SubStep::for_grid(pot.spec().shape);
    let mut changed = Vec::new();
    for _ in 0..steps {
        substep.advance(pot, presses, MethodKind::Plastic, |surface, window| changed.push((surface, window)));
    }
    pot.settle(changed.drain(..));
}

#[test]
fn what_two_hands_squeeze_out_of_a_wall_makes_the_pot_higher() {
    let mut pot = hollow(GridShape::PAPER);
    let before_m3 = pot.clay_m3();
    let all_round = |depth_mm: f32| -> Vec<Press> {
        let places = (0..24).map(|place| place as f32 * PI / 12.0);
        let sides = [Side::Outside, Side::Inside];
        places.flat_map(|angle_rad| sides.map(|side| ball(12.0, side, depth_mm, angle_rad, 100.0))).collect()
    };
    pressed(&mut pot, &all_round(2.0), 400);
    let thin_mm = walls_mm(&pot);
    let [outer, inner, ..] = pot.surfaces() else { panic!("a hollow pot has two skins") };
    let at = |column: usize, row: usize| column * 400 + row;
    let middle_mm = thin_mm[at(0, 200)];
    // 2 mm from either side, less what springs back
    assert!((4.0..5.5).contains(&middle_mm), "{middle_mm} mm");
    let moved_mm = [60.0 - outer.column_m(0)[200] * 1e3, inner.column_m(0)[200] * 1e3 - 52.0];
    assert!((moved_mm[0] - moved_mm[1]).abs() < 0.3, "both skins give way: {moved_mm:?}");
    let height_mm = outer.height_m() * 1e3;
    println!("{middle_mm:.2} mm thick, {height_mm:.2} mm high");
    assert!(height_mm > 200.3 && outer.height_m() == inner.height_m(), "{height_mm} mm");
    assert!((pot.clay_m3() / before_m3 - 1.0).abs() < 1e-4, "{} of {before_m3} m³", pot.clay_m3());
    assert!(pot.pressed_m3() > 0.0);
}

/// A stroke's tool at a tick, as a press on a turning wheel, while it is there.
fn drawn(
    stroke: &Stroke,
    conditions: &Conditions,
    tick: Tick,
    side: Side,
    last: &mut Option<ToolSample>,
) -> Option<Press> {
    let at_s = tick.0 as f64 * f64::from(Tick::PERIOD.0);
    let centre = Position::nearest(stroke.at(at_s)?).unwrap();
    let sample = ToolSample { tick, tool: stroke.tool_at(at_s), orientation: Orientation::default(), centre, side };
    let press = conditions.press(&sample, last.as_ref());
    *last = Some(sample);
    Some(press)
}

#[test]
fn two_hands_pull_a_wall_up() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/strokes");
    let strokes = ["pull-outside.csv", "pull-inside.csv"].map(|name| Stroke::read(folder.join(name)).unwrap());
    let rate = Wheel::rate_of(strokes[0].wheel_speed());
    let conditions = Conditions { wheel: Wheel::starting_at(Tick(0), Phase(0), rate), ..Conditions::default() };
    let mut pot = hollow(GridShape::PAPER);
    let (mut substep, mut changed) = (SubStep::for_grid(pot.spec().shape), Vec::new());
    let (before_m3, mut last) = (pot.clay_m3(), [None; 2]);
    for tick in (0..24_000).map(Tick) {
        let sides = [Side::Outside, Side::Inside].into_iter();
        let presses: Vec<_> = sides
            .zip(&strokes)
            .zip(&mut last)
            .filter_map(|((side, stroke), last)| drawn(stroke, &conditions, tick, side, last))
            .collect();
        substep.advance(&mut pot, &presses, conditions.method, |surface, window| changed.push((surface, window)));
        if tick.0 % 17 == 0 {
            pot.settle(changed.drain(..));
        }
    }
    let (walls_mm, height_mm) = (walls_mm(&pot), pot.surfaces()[0].height_m() * 1e3);
    let pulled = |column: usize| walls_mm[column * 400 + 120..column * 400 + 280].iter().sum::<f32>() / 160.0;
    let mean_mm = (0..360).map(pulled).sum::<f32>() / 360.0;
    let uneven_mm = (0..360).map(|column| (pulled(column) - mean_mm).abs()).fold(0.0, f32::max);
    println!("a wall of 8 mm is {mean_mm:.2} mm thick, uneven by {uneven_mm:.2} mm, and {height_mm:.1} mm high");
    assert!((5.5..7.5).contains(&mean_mm) && uneven_mm < 0.1, "{mean_mm} mm, uneven by {uneven_mm} mm");
    assert!(height_mm > 208.0, "{height_mm} mm");
    assert!((pot.clay_m3() / before_m3 - 1.0).abs() < 1e-4, "{} of {before_m3} m³", pot.clay_m3());
    // nobody was at the foot
    assert!(walls_mm.chunks(400).all(|column| (column[10] - 8.0).abs() < 0.01));
}

#[test]
fn no_wall_is_squeezed_through() {
    let thinnest_mm = |pot: &Pot| walls_mm(pot).into_iter().fold(f32::INFINITY, f32::min);
    for (outside_mm, inside_mm) in [(7.0, 7.0), (12.0, 1.0), (1.0, 12.0), (14.0, -20.0), (-20.0, 14.0)] {
        let mut pot = hollow(coarse());
        let presses = [(Side::Outside, outside_mm), (Side::Inside, inside_mm)]
            .map(|(side, depth_mm)| ball(10.0, side, depth_mm, 0.0, 100.0));
        pressed(&mut pot, &presses, 4000);
        let thinnest_mm = thinnest_mm(&pot);
        println!("{outside_mm} mm outside, {inside_mm} mm inside: {thinnest_mm:.3} mm are left");
        assert!(thinnest_mm > PotSpec::WALL_MIN.as_mm() - 1e-3, "{thinnest_mm} mm");
    }
}

#[test]
fn a_gentle_press_dents_its_own_skin_and_a_firm_one_takes_the_wall_along() {
    for side in [Side::Outside, Side::Inside] {
        let moved_mm = |depth_mm: f32| -> [f32; 2] {
            let mut pot = hollow(GridShape::PAPER);
            pressed(&mut pot, &[ball(12.0, side, depth_mm, 0.0, 100.0)], 1500);
            let skins_mm = [0, 1].map(|skin| pot.surfaces()[skin].column_m(0)[200] * 1e3 - [60.0, 52.0][skin]);
            let [own, other] = if side == Side::Outside { [0, 1] } else { [1, 0] };
            [skins_mm[own].abs(), skins_mm[other].abs()]
        };
        let ([gentle, behind], [firm, along]) = (moved_mm(0.8), moved_mm(6.0));
        println!("{side:?}: {gentle:.3} mm and {behind:.3} mm, {firm:.3} mm and {along:.3} mm");
        assert!(gentle > 0.02 && behind < 0.02 * gentle, "{gentle} {behind}");
        assert!(along > 0.4 * firm, "{firm} {along}");
    }
}

#[test]
fn a_wall_that_was_squeezed_gives_way_as_one_that_was_made_so_thin() {
    for thin_mm in [6.0, 4.0, 3.0] {
        let mut squeezed = hollow(GridShape::PAPER);
        let shape = squeezed.spec().shape;
        for (column, row) in (0..shape.columns()).flat_map(|column| (0..shape.rows()).map(move |row| (column, row))) {
            squeezed.surfaces_mut()[1].set_radius(column, row, (60.0 - thin_mm) * 1e-3);
        }
        let made = Pot::new(PotSpec { wall: Metres::from_mm(thin_mm), ..*squeezed.spec() }).unwrap();
        assert!((squeezed.thickness_about(3.1, 0.1) - thin_mm / 8.0).abs() < 1e-4);
        for depth_mm in [0.5, 1.0, 2.0] {
            let force_n = [&squeezed, &made]
                .map(|pot| felt(pot, &ball(12.0, Side::Outside, depth_mm, 0.0, 100.0), &[]).force_n.x);
            println!("{thin_mm} mm, {depth_mm} mm deep: {force_n:?} N");
            assert!((force_n[0] / force_n[1] - 1.0).abs() < 0.08, "{thin_mm} mm, {depth_mm} mm: {force_n:?} N");
        }
    }
}

#[test]
fn how_thick_a_wall_is_about_a_place_changes_evenly_also_at_the_seam() {
    let mut pot = hollow(GridShape::PAPER);
    assert!((pot.thickness_about(1.0, 0.05) - 1.0).abs() < 1e-5);
    pressed(&mut pot, &[Side::Outside, Side::Inside].map(|side| ball(15.0, side, 2.5, PI, 100.0)), 400);
    let mut before = pot.thickness_about(PI - 0.4, 0.08);
    let (mut least, mut steepest) = (before, 0.0_f32);
    for step in 1..=2000 {
        let share = step as f32 / 2000.0;
        let now = pot.thickness_about(PI - 0.4 + 0.8 * share, 0.08 + 0.04 * share);
        (least, steepest) = (least.min(now), steepest.max((now - before).abs()));
        before = now;
    }
    println!("{least:.4} of the wall at least, {steepest:.6} a step");
    // a step is 24 µm round the pot and 20 µm up
    assert!((0.8..0.99).contains(&least) && steepest < 1e-3, "{least} {steepest}");
    let there = [-PI, PI].map(|angle_rad| pot.thickness_about(angle_rad, 0.1));
    assert!((there[0] - there[1]).abs() < 1e-5, "{there:?}");
    // foot and rim end the wall, whatever is asked for
    assert!([-1.0, 0.0, 0.2, 5.0].into_iter().all(|z_m| (pot.thickness_about(0.0, z_m) - 1.0).abs() < 0.01));
}

#[test]
fn force_rises_evenly_as_a_finger_comes_nearer_and_is_one_tool_s_while_it_is_far() {
    let pot = hollow(GridShape::PAPER);
    let tool = ball(12.0, Side::Outside, 1.0, 0.0, 100.0);
    let alone = felt(&pot, &tool, &[]);
    let mut before = (alone.force_n.x, 0.0);
    for step in 0..=200 {
        let depth_mm = -1.2 + 0.01 * step as f32;
        let finger = ball(15.0, Side::Inside, depth_mm, 0.0, 100.0);
        let [one, other] = [felt(&pot, &tool, &[finger]), felt(&pot, &finger, &[tool])];
        let now = (one.force_n.x, -other.force_n.x);
        if depth_mm < -0.8 {
            // the wall gives way by less
            assert_eq!((one, other.elements), (alone, 0), "{depth_mm} mm");
        }
        // 3.8 N/mm at most; each force is known to a quarter of a per cent of the larger one
        let rises = [now.0 - before.0, now.1 - before.1];
        assert!(rises.iter().all(|rise| (-0.02..0.08).contains(rise)), "{depth_mm} mm: {rises:?} N");
        before = now;
    }
    assert!(before.0 > 2.5 * alone.force_n.x && before.1 > 2.0 * alone.force_n.x, "{before:?}");
}

#[test]
fn wall_answers_the_same_there_and_back_and_as_under_a_single_load() {
    let pot = hollow(coarse());
    let bending = pot.surfaces()[0].bending().unwrap();
    let places = [[0.0, 0.1], [0.3, 0.05], [-0.2, 0.12], [3.0, 0.19], [-3.0, 0.15], [PI, 0.1], [0.05, 0.105]];
    for one in places {
        for other in places {
            let [there, back] = [(one, other), (other, one)].map(|(at, load)| bending.between(at, load, 0.004));
            let most = bending.compliance(one[1], 0.004).max(bending.compliance(other[1], 0.004));
            assert!((there - back).abs() < 1e-4 * most, "{one:?} {other:?}: {there} {back}");
            let bend = bending.under(1.0, 0.0, other[0], other[1], 0.004).at_m(one[0], one[1]);
            // which leaves out what the harmonics beyond the last add close to the load
            assert!((there - bend).abs() < 0.02 * most, "{one:?} {other:?}: {there} {bend}");
        }
        let own = bending.between(one, one, 0.004);
        assert!((own / bending.compliance(one[1], 0.004) - 1.0).abs() < 1e-4, "{one:?}: {own}");
    }
}

#[test]
fn wall_bears_what_a_long_tool_does() {
    let pot = hollow(GridShape::PAPER);
    let youngs_pa = Strength::default().youngs_pa;
    for z_mm in [60.0, 100.0, 140.0] {
        let mut before_n = 0.0;
        for step in 1..=20 {
            let contact = felt(&pot, &rib(0.25 * step as f32, z_mm), &[]);
            let (force_n, wall_n) = (contact.force_n.x, contact.sink.unwrap().load_m2 * youngs_pa);
            assert!((wall_n / force_n - 1.0).abs() < 0.03, "{z_mm} mm, step {step}: {force_n} N on {wall_n} N");
            assert!(force_n > 0.97 * before_n, "{z_mm} mm, step {step}: {force_n} N after {before_n} N");
            before_n = force_n;
        }
        // where it folds under 4 to 5 N; taken as rigid it bore 16 N
        assert!((3.0..6.5).contains(&before_n), "{z_mm} mm: {before_n} N");
    }
}

#[test]
fn force_of_a_long_tool_that_leans_rises_evenly_on_either_side_of_a_wall() {
    // rib and blade with their edges upright, and leant by 4 to 20 degrees, so that they touch near an end
    for (number, name) in [(0, "rib"), (1, "blade")] {
        for side in [Side::Outside, Side::Inside] {
            for leans in [0.02_f32, 0.05, 0.1] {
                let pot = hollow(GridShape::PAPER);
                let mut substep = SubStep::for_grid(pot.spec().shape);
                let mut at = |distance_m: f32| {
                    let orientation = Quat::from_xyzw(leans, 1.5 * leans, 0.0, 1.0);
                    let press =
                        Press { tool: Tool::Convex(Shape(number)), orientation, ..ball(5.0, side, 0.0, 0.0, 100.0) };
                    let press = Press { centre_m: Vec3::new(distance_m, 0.0, 0.1), ..press };
                    substep.feel_beside(&pot, &press, &[], MethodKind::Plastic)
                };
                let (mut off_m, mut on_m) = if side == Side::Inside { (0.0, 0.06) } else { (0.25, 0.06) };
                for _ in 0..25 {
                    let middle_m = 0.5 * (off_m + on_m);
                    if at(middle_m).elements > 0 { on_m = middle_m } else { off_m = middle_m }
                }
                let further_m = 2e-5 * (on_m - off_m).signum();
                let forces_n: Vec<f32> =
                    (1..=200).map(|step| at(off_m + further_m * step as f32).force_n.length()).collect();
                // as much as a blade meets at once with one more row of elements
                let leap_n = forces_n.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
                let what = format!("{name} {side:?}, leant by {leans}");
                assert!(leap_n < 0.2, "{what}: {leap_n} N within 0.02 mm");
                let fallen_n = forces_n.iter().fold([0.0_f32; 2], |[most_n, fallen_n], &force_n| {
                    [most_n.max(force_n), fallen_n.max(most_n - force_n)]
                })[1];
                assert!(fallen_n < 0.2, "{what}: {fallen_n} N less than before");
                // where the wall folds under 4 to 5 N
                assert!((1.0..6.5).contains(&forces_n[199]), "{what}: {} N at 4 mm", forces_n[199]);
            }
        }
    }
}

/// Two to four balls within 17° of each other, 6 to 8 mm deep in a wall from either side: the more there are, the more it folds.
fn deep(scene: u16) -> Vec<Press> {
    // evenly scattered, each figure by an irrational number of its own
    let share = |figure: u16| (f32::from(scene) * f32::from(figure).sqrt()).fract();
    let one = |tool: u16| {
        let [radius, side, depth, angle, height] = [2, 3, 5, 7, 11].map(|figure| share(figure + 100 * tool));
        let side = if side < 0.5 { Side::Outside } else { Side::Inside };
        ball(8.0 + 7.0 * radius, side, 6.0 + 2.0 * depth, 0.3 * (angle - 0.5), 100.0 + 18.0 * (height - 0.5))
    };
    (0..2 + scene % 3).map(one).collect()
}

#[test]
fn force_of_several_tools_deep_in_a_wall_does_not_leap() {
    // where loads are balanced by what they bend, Newton's steps end at no balance, and forces leap by 20 to 30 N
    for (shape, most_n) in [(coarse(), 3.0), (GridShape::PAPER, 0.5)] {
        let pot = hollow(shape);
        let mut substep = SubStep::for_grid(shape);
        for scene in 0..150 {
            let mut before: Option<Vec<Vec3>> = None;
            for step in 0..12_u16 {
                let mut presses = deep(scene);
                for (tool, press) in (0_u16..).zip(&mut presses) {
                    // two micrometres to and fro
                    let away =
                        [3, 5, 7].map(|figure| (f32::from(step + 1) * f32::from(figure + 100 * tool).sqrt()).fract());
                    press.centre_m += (Vec3::from_array(away) - 0.5) * 4e-6;
                }
                let mut pressed = pot.clone();
                let held: Vec<Press> = presses.iter().map(|press| Press { response: 0.0, ..*press }).collect();
                let contacts = substep.advance(&mut pressed, &held, MethodKind::Plastic, |_, _| {});
                let forces_n: Vec<Vec3> = contacts.iter().map(|contact| contact.force_n).collect();
                for (now, before) in forces_n.iter().zip(before.iter().flatten()) {
                    let leap_n = now.distance(*before);
                    assert!(leap_n < most_n, "{shape:?}, scene {scene}: {leap_n} N within 4 µm");
                }
                before = Some(forces_n);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn order_of_tools_cannot_be_felt_in_a_wall_that_bends(presses in several()) {
        let pressed = |order: &[usize]| {
            let mut pot = hollow(coarse());
            let presses: Vec<_> = order.iter().map(|&number| presses[number]).collect();
            let mut substep = SubStep::for_grid(pot.spec().shape);
            let steps = (0..4).map(|_| substep.advance(&mut pot, &presses, MethodKind::Plastic, |_, _| {}).to_vec());
            let contacts = steps.last().unwrap();
            (pot.digest(), contacts)
        };
        let forth: Vec<usize> = (0..presses.len()).collect();
        let (digest, contacts) = pressed(&forth);
        for contact in &contacts {
            let sink = contact.sink.unwrap_or_default();
            let numbers = [contact.force_n.length(), contact.held_n, contact.penetration_m, sink.load_m2, sink.hinge_m];
            prop_assert!(numbers.iter().all(|number| number.is_finite()), "{contact:?}");
        }
        for turn in 1..presses.len() {
            let mut order = forth.clone();
            order.rotate_left(turn);
            if turn % 2 == 0 {
                order.reverse();
            }
            let (other, found) = pressed(&order);
            prop_assert_eq!(digest, other);
            for (number, contact) in order.iter().zip(found) {
                prop_assert_eq!(contact, contacts[*number]);
            }
        }
    }

    #[test]
    fn whoever_met_nothing_can_be_left_out_when_it_is_pressed_again(presses in several()) {
        let (mut first, mut again) = (hollow(coarse()), hollow(coarse()));
        let (mut substep, mut other) = (SubStep::for_grid(coarse()), SubStep::for_grid(coarse()));
        for _ in 0..4 {
            substep.advance(&mut first, &presses, MethodKind::Plastic, |_, _| {});
            let met: Vec<_> = presses.iter().zip(substep.met()).filter(|(_, met)| **met).map(|(press, _)| *press).collect();
            other.advance(&mut again, &met, MethodKind::Plastic, |_, _| {});
            prop_assert_eq!(first.digest(), again.digest());
        }
    }

    #[test]
    fn any_wall_and_any_clay_bend_to_something_finite(
        presses in several(),
        (wall_mm, radius_mm, height_mm) in (1.0_f32..12.0, 30.0_f32..120.0, 20.0_f32..300.0),
        (youngs_mpa, yield_share) in (0.05_f32..50.0, 0.001_f32..0.2),
    ) {
        let [wall, radius, height] = [wall_mm, radius_mm, height_mm].map(Metres::from_mm);
        let spec = PotSpec { shape: coarse(), support: Support::Hollow, wall, radius, height, ..PotSpec::default() };
        let mut pot = Pot::new(spec).unwrap();
        let youngs_pa = youngs_mpa * 1e6;
        let strength = Strength { youngs_pa, yield_pa: yield_share * youngs_pa };
        let presses: Vec<_> = presses.into_iter().map(|press| {
            let centre_m = press.centre_m * Vec3::new(radius.0 / 0.06, radius.0 / 0.06, height.0 / 0.2);
            Press { strength, centre_m, ..press }
        }).collect();
        let mut substep = SubStep::for_grid(coarse());
        for _ in 0..4 {
            for contact in substep.advance(&mut pot, &presses, MethodKind::Plastic, |_, _| {}) {
                let sink = contact.sink.unwrap_or_default();
                let numbers = [contact.force_n.length(), contact.held_n, contact.penetration_m, sink.load_m2, sink.hinge_m];
                prop_assert!(numbers.iter().all(|number| number.is_finite()), "{contact:?}");
            }
        }
    }
}

#[test]
fn a_hand_feels_what_somebody_else_holds_against_the_wall() {
    let pot = hollow(GridShape::PAPER);
    let place = |side, depth_mm| {
        let centre = Position::nearest(ball(12.0, side, depth_mm, 0.0, 100.0).centre_m).unwrap();
        ToolSample { tick: Tick(1), tool: Tool::default(), orientation: Orientation::default(), centre, side }
    };
    let (own, other) = (place(Side::Outside, 1.0), place(Side::Inside, 0.0));
    let mut field = Field::new(pot, Tick(0));
    let patch =
        |field: &Field| Patch { field: field.clone(), conditions: Conditions::default(), rack: rack::standard() };
    let alone = Hand::new(patch(&field)).press(&own);
    assert!(field.set_beside([other].into_iter()), "it is news");
    assert!(
        !field.set_beside([ToolSample { tick: Tick(9), ..other }].into_iter()),
        "when it was heard of does not matter"
    );
    let mut hand = Hand::new(patch(&field));
    let held = hand.feel(&own);
    assert!(held.force_n.x > 2.0 * alone.force_n.x, "{} N and {} N", held.force_n.x, alone.force_n.x);
    assert_eq!(hand.press(&own).force_n, held.force_n);
    // the other hand feels it where it would touch nothing alone
    let touched = |beside: &[ToolSample]| {
        let mut field = field.clone();
        field.set_beside(beside.iter().copied());
        Hand::new(patch(&field)).feel(&place(Side::Inside, -0.2)).elements
    };
    assert!(touched(&[own]) > 0 && touched(&[]) == 0);
    // once it is gone, the clay is another under the tool
    assert!(field.set_beside(core::iter::empty()));
    let mut gone = patch(&field);
    assert!(hand.catch_up(&mut gone, 64) && hand.is_corrected_since(&gone));
}
