//! A tool at a hollow pot: the wall bends in series with the clay under the tool, against the finite-element reference.
//!
//! The reference is not of this project's making; `tests/data/reference/README.md` says where it stands.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::Vec3;
use pottery_shared::clay::{
    Contact, GridShape, MethodKind, PlasticLaw, Pot, PotSpec, Press, Strength, SubStep, Support, WallBending,
};
use pottery_shared::tool::{Side, Sphere};
use pottery_shared::units::Metres;
use pottery_tests::chart::cases::{Support as Standing, reference_profile};
use pottery_tests::dent::{Dent, Dented};
use pottery_tests::fit::{dents, misfits, walls};
use pottery_tests::reference::ForceCurve;

const FORCE: &str = include_str!("../../data/reference/A_depth_force.csv");

fn spec(shape: GridShape) -> PotSpec {
    PotSpec { shape, support: Support::Hollow, ..PotSpec::default() }
}

fn dent(depth_mm: u32, release: bool, shape: GridShape) -> Dent {
    Dent {
        method: MethodKind::Plastic,
        pot: spec(shape),
        strength: Strength::default(),
        tool: Metres::from_mm(12.0),
        depth: Metres::from_mm(depth_mm as f32),
        finger: None,
        release,
        round: None,
    }
}

fn pressed(depth_mm: u32, release: bool) -> (Dented, f64) {
    let dent = dent(depth_mm, release, GridShape::PAPER);
    let dented = dent.press().unwrap();
    let error = dented.error(&reference_profile(Standing::Hollow, depth_mm, release), &dent);
    (dented, error)
}

/// One step of a sphere whose near side stands `depth_mm` deep in the wall at an angle and a height.
fn step(pot: &mut Pot, side: Side, depth_mm: f32, angle_rad: f32, z_mm: f32) -> Contact {
    let tool = Sphere::new(Metres::from_mm(12.0)).unwrap();
    let distance_mm = match side {
        Side::Outside => 60.0 + 12.0 - depth_mm,
        Side::Inside => 52.0 - 12.0 + depth_mm,
    };
    let (sin, cos) = angle_rad.sin_cos();
    let press = Press { side, ..Press::held(tool, Vec3::new(distance_mm * cos, distance_mm * sin, z_mm) * 1e-3) };
    SubStep::for_grid(pot.spec().shape).advance(pot, &[press], MethodKind::Plastic, |_, _| {})[0]
}

#[test]
fn hollow_pot_under_the_tool_has_the_reference_s_shape() {
    let errors: Vec<f64> = [1, 2].iter().map(|&depth| pressed(depth, false).1).collect();
    println!("loaded, RMS over travel: {errors:.4?}");
    // three quarters of it is bending, of which this reference has nine tenths of the shell's at the same force; on a finer
    // mesh the same pot bends as the shell within 3 %
    assert!(errors.iter().all(|error| *error < 0.02), "{errors:.4?}");
}

#[test]
fn hollow_pot_springs_back_but_for_the_dent_under_the_tool() {
    for depth in [1, 2] {
        let (dented, error) = pressed(depth, true);
        let (tip, reference) =
            (dented.radial_mm_at(0.0, 100.0), reference_profile(Standing::Hollow, depth, true).radial_mm(0.0, 100.0));
        let quarter = dented.radial_mm_at(std::f64::consts::FRAC_PI_2, 100.0);
        println!("{depth} mm: error {error:.4}, tip {tip:.3} mm, reference {reference:.3} mm");
        // of a reference that is good to a fifth of its dent, whose tip here is one element of its mesh
        assert!(
            error < 0.01 && (tip / reference - 1.0).abs() < 0.35,
            "{depth} mm: {error:.4}, {tip:.3}, {reference:.3}"
        );
        assert!(quarter == 0.0, "{depth} mm: {quarter} mm stay a quarter round");
    }
}

#[test]
fn hollow_pots_have_the_shape_of_finite_elements_fitted_and_held_out() {
    let [fitted, held_out] = [dents::hollow, dents::hollow_held_out].map(|read| read(GridShape::PAPER).unwrap());
    for known in [&fitted, &held_out] {
        for (known, misfit) in known.iter().zip(misfits(PlasticLaw::FITTED, known).unwrap()) {
            println!("{} {:?}: {misfit:.4?}", known.name, known.dent.depth);
            assert!(misfit.loaded < 0.015 && misfit.permanent < 0.015, "{} {misfit:?}", known.name);
        }
    }
    // a wall that springs back wholly has another shape where it has folded
    let springs_back = PlasticLaw { wall_stays: 0.0, ..PlasticLaw::FITTED };
    let worst =
        misfits(springs_back, &fitted).unwrap().iter().fold(0.0, |worst: f64, misfit| worst.max(misfit.permanent));
    println!("{worst:.4} of what stays at most with a wall that springs back");
    assert!(worst > 0.05, "{worst}");
    // clay as firm as on a core has another shape where the wall folds
    let as_firm = PlasticLaw { wall_weaker: 0.0, ..PlasticLaw::FITTED };
    let worst = misfits(as_firm, &fitted).unwrap().iter().fold(0.0, |worst: f64, misfit| worst.max(misfit.loaded));
    println!("{worst:.4} at most with clay as firm as on a core");
    assert!(worst > 0.03, "{worst}");
}

#[test]
fn hollow_pot_carries_the_tool_with_the_reference_s_force() {
    let curve = ForceCurve::parse(FORCE).unwrap();
    for depth in [1, 2] {
        let force = f64::from(pressed(depth, false).0.force_n);
        let reference = curve.first_at_n(depth.into()).unwrap();
        println!("{depth} mm: {force:.3} N, reference {reference:.3} N");
        // its mesh is 5 % stiffer than the finer one of our own, whose force is met within 1 %
        let within = 0.05 * curve.largest_n();
        assert!((force - reference).abs() < within, "{depth} mm: {force:.3} N, reference {reference:.3} N");
    }
    let mut own = walls::finite_elements(GridShape::PAPER).unwrap();
    own.retain(|known| known.name == "hollow_base" && [1.0, 2.0].contains(&known.depth_mm()));
    let errors = walls::errors(PlasticLaw::FITTED, &own).unwrap();
    println!("{errors:.4?} over the largest of our own");
    assert!(errors.len() == 2 && errors.iter().all(|error| error.abs() < 0.011), "{errors:.4?}");
}

#[test]
fn thin_walls_give_way_evenly_however_wide_the_contact() {
    // from some depth on, each contact is wider than a wall so thin is a plate
    for (wall_mm, tool_mm, depths_mm) in [(1.0, 40.0, 7..11), (1.0, 25.0, 14..18), (2.0, 40.0, 16..20)] {
        let shape = GridShape::new(180, 200).unwrap();
        let forces_n = depths_mm.map(|depth_mm| {
            let pot = PotSpec { wall: Metres::from_mm(wall_mm), ..spec(shape) };
            let dented = Dent { pot, tool: Metres::from_mm(tool_mm), ..dent(depth_mm, false, shape) }.press().unwrap();
            let [least_mm, most_mm] =
                [f32::min, f32::max].map(|of| dented.radial_mm.iter().copied().reduce(of).unwrap());
            println!("{wall_mm} mm, {depth_mm} mm deep: {:.3} N, {least_mm:.2} to {most_mm:.2} mm", dented.force_n);
            assert!(
                least_mm > -1.3 * depth_mm as f32 && most_mm < 10.0,
                "{wall_mm} mm, {depth_mm} mm deep: {least_mm} to {most_mm} mm"
            );
            dented.force_n
        });
        let forces_n: Vec<f32> = forces_n.collect();
        for pair in forces_n.windows(2) {
            assert!((0.9..1.3).contains(&(pair[1] / pair[0])), "{wall_mm} mm, {tool_mm} mm: {forces_n:?}");
        }
    }
}

#[test]
fn hollow_pots_yield_under_deep_presses_as_finite_elements_do() {
    // half a millimetre to six, two balls, three pots, two clays, by a calculation of our own that knows nothing of this law
    let mut known = walls::finite_elements(GridShape::PAPER).unwrap();
    known.retain(|known| known.side == Side::Outside);
    let worst =
        |law| walls::errors(law, &known).unwrap().into_iter().fold(0.0, |worst: f64, error| worst.max(error.abs()));
    let [used, elastic] =
        [PlasticLaw::FITTED, PlasticLaw { wall_softer: 0.0, wall_weaker: 0.0, ..PlasticLaw::FITTED }].map(worst);
    println!(
        "{} forces, over the largest: {used:.4} at most, {elastic:.4} with a wall that stays elastic",
        known.len()
    );
    // that calculation's own thin walls are uncertain by 5 %
    assert!(used < 0.06, "{used}");
    assert!(elastic > 0.2, "{elastic}");
}

#[test]
fn hollow_pot_bears_balls_inside_as_finite_elements_do() {
    let known = walls::finite_elements(GridShape::PAPER).unwrap();
    let mut presses = 0;
    // the finite elements stand still at these depths; between them the moving wall's own weight is in their forces
    let stands = [1.0, 2.0, 4.0, 6.0];
    for known in known.iter().filter(|known| known.side == Side::Inside && stands.contains(&known.depth_mm())) {
        let force_n = known.borne_n(PlasticLaw::FITTED).unwrap();
        let error = force_n / known.force_n - 1.0;
        let is_wide_or_soft = known.dent.tool > Metres::from_mm(20.0) || known.dent.strength.yield_pa < 40e3;
        let within = if is_wide_or_soft { 0.05 } else { 0.03 };
        let press = format!("{}, {} mm deep", known.name, known.depth_mm());
        println!("{press}: {force_n:.3} N, finite elements {:.3} N, {error:+.3}", known.force_n);
        assert!(error.abs() < within, "{press}: {force_n:.3} N for {:.3} N", known.force_n);
        presses += 1;
    }
    assert_eq!(presses, 14);
}

/// A curved wall is less stiff the farther it is pressed in and stiffer the farther it is pressed out. The law knows nothing of that: a fault, which is
/// 6 to 11 % of the force 4 mm deep.
#[test]
fn hollow_pots_that_never_yield_bear_balls_nearly_as_finite_elements_do() {
    let known = walls::elastic(GridShape::PAPER).unwrap();
    let errors = walls::errors(PlasticLaw::FITTED, &known).unwrap();
    for (known, error) in known.iter().zip(&errors) {
        let press = format!("{}, {} mm deep", known.name, known.depth_mm());
        println!("{press}: {error:+.3} of the largest");
        assert!(error.abs() < 0.12, "{press}: {error:+.3}");
        let is_too_hard = known.side == Side::Outside || known.dent.tool > Metres::from_mm(20.0);
        assert_eq!(*error > 0.0, is_too_hard, "{press}: {error:+.3}");
    }
}

#[test]
fn hollow_pots_bear_balls_as_finite_elements_that_nothing_was_fitted_to() {
    let known = walls::held_out(GridShape::PAPER).unwrap();
    for (known, error) in known.iter().zip(walls::errors(PlasticLaw::FITTED, &known).unwrap()) {
        let press = format!("{}, {} mm deep", known.name, known.depth_mm());
        println!("{press}: {error:+.3} of the largest");
        assert!(error.abs() < 0.09, "{press}: {error:+.3}");
    }
}

#[test]
fn wall_takes_three_quarters_of_the_travel() {
    let mut pot = Pot::new(spec(GridShape::PAPER)).unwrap();
    let contact = (0..300).map(|_| step(&mut pot, Side::Outside, 1.0, 0.0, 100.0)).last().unwrap();
    let bend = contact.sink.unwrap().bend(&pot.surfaces()[0]).unwrap();
    let (bent_mm, side_mm) = (bend.at_m(0.0, 0.1) * 1e3, -bend.at_m(std::f32::consts::FRAC_PI_2, 0.1) * 1e3);
    println!("1 mm of travel: {bent_mm:.3} mm bending, {side_mm:.3} mm outwards a quarter round");
    // the reference: 0.76 mm and 0.207 mm, with a wall that bends nine tenths as much as a shell
    assert!((0.68..0.80).contains(&bent_mm) && (0.18..0.25).contains(&side_mm), "{bent_mm} mm, {side_mm} mm");
}

#[test]
fn wall_and_clay_carry_the_same_force() {
    let youngs_pa = Strength::default().youngs_pa;
    for (side, inwards) in [(Side::Outside, 1.0), (Side::Inside, -1.0)] {
        let (mut worst, mut balanced) = (0.0_f32, 0);
        for (number, z_mm) in [5.0, 60.0, 100.0, 150.0, 195.0].into_iter().enumerate() {
            for depth_mm in [0.01, 0.1, 0.5, 1.0, 2.0, 5.0] {
                let mut pot = Pot::new(spec(GridShape::PAPER)).unwrap();
                // the first steps on untouched clay, where the contact changes most, and later ones
                for _ in 0..30 {
                    let angle = number as f32;
                    let contact = step(&mut pot, side, depth_mm, angle, z_mm);
                    let Some(sink) = contact.sink else { continue };
                    let radial_n = contact.force_n.dot(Vec3::new(angle.cos(), angle.sin(), 0.0)) * inwards;
                    let wall_n = sink.load_m2 * inwards * youngs_pa;
                    let off = (wall_n / radial_n - 1.0).abs();
                    assert!(off.is_finite(), "{side:?}, {z_mm} mm, {depth_mm} mm: {wall_n} N and {radial_n} N");
                    (worst, balanced) = (worst.max(off), balanced + 1);
                }
            }
        }
        println!("{side:?}: {worst:.5} in {balanced} steps");
        // at five places and six depths, all but those that are too shallow to load the wall
        assert!(balanced > 600, "{side:?}: {balanced} of 900 steps");
        // the balance is found to a quarter of a per cent, and less closely where the last look comes first
        assert!(worst < 0.01, "{side:?}: {worst}");
    }
}

#[test]
fn hollow_pot_is_softer_and_keeps_less_than_a_backed_one() {
    let mut before = f32::INFINITY;
    for support in [Support::Backed, Support::Hollow] {
        let mut pot = Pot::new(PotSpec { support, ..PotSpec::default() }).unwrap();
        let contact = (0..300).map(|_| step(&mut pot, Side::Outside, 1.0, 1.0, 100.0)).last().unwrap();
        assert!(contact.force_n.length() < 0.5 * before, "{support:?}: {contact:?}");
        before = contact.force_n.length();
    }
    // the rim gives way more than the foot
    let force =
        |z_mm| step(&mut Pot::new(spec(GridShape::PAPER)).unwrap(), Side::Outside, 1.0, 0.0, z_mm).force_n.length();
    assert!(force(190.0) < force(100.0) && force(100.0) < force(15.0));
}

#[test]
fn force_and_dent_of_a_hollow_pot_do_not_depend_on_the_grid() {
    let fine = GridShape::new(1080, 1200).unwrap();
    for release in [false, true] {
        let (coarse, _) = pressed(2, release);
        let fine = dent(2, release, fine).press().unwrap();
        let force = (coarse.force_n / fine.force_n - 1.0).abs();
        let shape = coarse.difference_mm(&fine, &dent(2, release, GridShape::PAPER)) / 2.0;
        println!("three times finer: force {force:.4}, shape {shape:.4} of the travel");
        // what the clay methods are asked for between 360 × 400 and finer
        assert!(force < 0.01 && shape < 0.01, "force {force:.4}, shape {shape:.4}");
    }
}

#[test]
fn hollow_pot_does_not_depend_on_the_number_of_steps() {
    let forces: Vec<f32> =
        [30, 300].iter().map(|&steps| dent(2, true, GridShape::PAPER).press_in(steps).unwrap().force_n).collect();
    // the balance is found to a quarter of a per cent in each
    assert!((forces[0] / forces[1] - 1.0).abs() < 0.01, "{forces:?}");
}

#[test]
fn a_finger_inside_stays_opposite_a_tool_that_goes_round() {
    let held = Dent {
        finger: Some(Metres::from_mm(15.0)),
        round: Some((60.0, Metres(0.0), 0.3)),
        ..dent(2, false, GridShape::PAPER)
    };
    let alone = Dent { finger: None, ..held }.press().unwrap();
    let held = held.press().unwrap();
    let finger_n = held.finger_n.unwrap();
    println!("{} N, {finger_n} N on the finger, {} N without one", held.force_n, alone.force_n);
    // what the finger takes up is what the wall alone does not bear
    assert!(finger_n > 0.5 * held.force_n && held.force_n > 1.3 * alone.force_n, "{finger_n} of {} N", held.force_n);
}

#[test]
fn pots_share_their_bending() {
    let pot = Pot::new(spec(GridShape::PAPER)).unwrap();
    let copy = pot.clone();
    let at = |pot: &Pot| std::ptr::from_ref::<WallBending>(pot.surfaces()[0].bending().unwrap());
    assert_eq!(at(&pot), at(&copy));
    assert_eq!(pot, Pot::new(spec(GridShape::PAPER)).unwrap());
    assert!(Pot::new(PotSpec::default()).unwrap().surfaces()[0].bending().is_none());
    assert_ne!(pot, Pot::new(PotSpec::default()).unwrap());
}
