//! The same clay on other grids: what is kept, what comes back, and how fine a grid has to be.

use glam::Vec3;
use pottery_shared::clay::{GridShape, MethodKind, Pot, PotSpec, Press, SubStep};
use pottery_shared::tool::Sphere;
use pottery_shared::units::Metres;
use pottery_tests::dice::Dice;

const SEED: u64 = 0x9e5a_3b1e;

fn grid(columns: u32, rows: u32) -> GridShape {
    GridShape::new(columns, rows).expect("the test's grids are in range")
}

fn pot(shape: GridShape) -> Pot {
    Pot::new(PotSpec { shape, ..PotSpec::default() }).expect("the default pot can be made")
}

/// A pot with every radius other by up to 3 mm.
fn rough(shape: GridShape, seed: u64) -> Pot {
    let (mut pot, mut dice) = (pot(shape), Dice::new(seed));
    for column in 0..shape.columns() {
        for row in 0..shape.rows() {
            pot.surfaces_mut()[0].set_radius(column, row, 0.06 + 0.003 * (2.0 * dice.share() as f32 - 1.0));
        }
    }
    pot
}

/// A dent of 2 mm, as deep as it gets.
fn dented(shape: GridShape) -> Pot {
    let mut pot = pot(shape);
    let tool = Sphere::new(Metres::from_mm(12.0)).expect("the tool is in range");
    let press = Press { response: 1.0, ..Press::held(tool, Vec3::new(0.070, 0.0, 0.1)) };
    let mut substep = SubStep::for_grid(shape);
    for _ in 0..20 {
        substep.advance(&mut pot, &[press], MethodKind::Plastic, |_, _| ());
    }
    pot
}

/// An f32 has seven figures, and errors of single radii cancel.
#[test]
fn volume_is_kept_on_every_grid() {
    let from = rough(grid(90, 100), SEED);
    for (columns, rows) in [(90, 100), (45, 50), (180, 199), (30, 34), (97, 103), (360, 400), (64, 333), (8, 4)] {
        let to = from.resampled(grid(columns, rows));
        let change = to.enclosed_volume_m3() / from.enclosed_volume_m3() - 1.0;
        assert!(change.abs() < 1e-6, "seed {SEED:#x}: {change:e} of the volume on {columns} x {rows}");
    }
}

/// The ledger comes along: a pot grows on the new grid as it would have on the old one.
#[test]
fn pot_grows_on_another_grid_as_on_its_own() {
    let mut own = dented(grid(180, 200));
    let mut other = own.resampled(grid(360, 399));
    for pot in [&mut own, &mut other] {
        let shape = pot.spec().shape;
        let everything = pottery_shared::clay::Window::around(shape, 0, shape.columns(), 0, i64::from(shape.rows()));
        pot.settle([(0, everything)].into_iter());
    }
    let [own_m, other_m] = [&own, &other].map(|pot| pot.surfaces()[0].height_m());
    // a unit in the last place of a height of 0.2 m
    assert!(
        (own_m - other_m).abs() <= 2.0 * f32::EPSILON * own_m,
        "{own_m} m on its own grid, {other_m} m on the other"
    );
}

/// What a finer grid holds comes back to a unit in the last place of a radius of 60 mm, 4 nm, and what is left of the passes.
#[test]
fn finer_and_back_is_as_it_was() {
    let from = rough(grid(48, 31), SEED + 1);
    for factor in [1, 2, 3, 4, 5] {
        let finer = grid(48 * factor, 30 * factor + 1);
        let back = from.resampled(finer).resampled(from.spec().shape);
        let (before, after) = (from.surfaces()[0].radii_m(), back.surfaces()[0].radii_m());
        let worst_m = before.iter().zip(after).map(|(one, other)| (one - other).abs()).fold(0.0, f32::max);
        assert!(worst_m <= 2e-8, "seed {:#x}: {worst_m} m off after a factor of {factor}", SEED + 1);
    }
}

#[test]
fn same_grid_is_the_same_clay() {
    let from = rough(grid(90, 100), SEED + 2);
    let digests = [&from, &from.resampled(from.spec().shape)].map(Pot::digest);
    assert_eq!(digests[0], digests[1]);
}

/// Steps of w by h on a paraboloid of half axis a are off by `√(w² + h²)/(2·a)` of it: the mean square of its slope is d²/a² each
/// way, that of its depth d²/3, and a step is off by a twelfth of the square of its length. The rim is steeper: twice that.
#[test]
fn coarser_dents_lose_what_their_elements_are_too_large_for() {
    let finest = dented(grid(720, 801));
    let error = |factor: u32| {
        let coarse = finest.resampled(grid(720 / factor, 800 / factor + 1));
        let back = coarse.resampled(finest.spec().shape);
        let pairs = finest.surfaces()[0].radii_m().iter().zip(back.surfaces()[0].radii_m());
        let dent = |radius_m: f32| f64::from(radius_m - 0.06).powi(2);
        let (mut off, mut all) = (0.0, 0.0);
        for (&before, &after) in pairs {
            off += f64::from(before - after).powi(2);
            all += dent(before);
        }
        (off / all).sqrt()
    };
    let errors = [2, 4, 8].map(error);
    println!("off by {errors:.4?} of the dent on a half, a quarter and an eighth of 720 x 801");
    assert!(errors[0] < errors[1] && errors[1] < errors[2], "{errors:?}");
    for (error, factor) in errors.into_iter().zip([2.0_f64, 4.0, 8.0]) {
        let (width_mm, height_mm, half_axis_mm) = (377.0 / 720.0 * factor, 0.25 * factor, 6.6);
        let steps = width_mm.hypot(height_mm) / (2.0 * half_axis_mm);
        assert!(error < 2.0 * steps, "{error} on a grid {factor} times coarser, where steps are {steps}");
    }
}

#[test]
fn grid_follows_the_smallest_tool_and_the_finest_viewer() {
    let pot = PotSpec::default();
    let shape = |tool_mm: f32, seen_mm: f32| {
        GridShape::for_tool_and_view(&pot, Metres::from_mm(tool_mm), Metres::from_mm(seen_mm))
            .expect("such a grid exists")
    };
    // 377 mm round and 200 mm high in elements of 3 mm, of 1 mm, and of 2 mm, which is all that anybody sees
    assert_eq!(shape(12.0, 0.1), grid(126, 68));
    assert_eq!(shape(4.0, 0.1), grid(377, 201));
    assert_eq!(shape(4.0, 2.0), grid(189, 101));
    assert_eq!(shape(1e4, 0.1), grid(8, 4));
}

#[test]
fn lengths_that_make_no_grid_are_told() {
    let pot = PotSpec::default();
    for bad_mm in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let (bad, good) = (Metres::from_mm(bad_mm), Metres::from_mm(5.0));
        let fault = GridShape::for_tool_and_view(&pot, bad, good).expect_err("no such tool");
        assert!(fault.to_string().starts_with("a tool radius of"), "{fault}");
        let fault = GridShape::for_tool_and_view(&pot, good, bad).expect_err("no such view");
        assert!(fault.to_string().starts_with("a visible length of"), "{fault}");
    }
    let fine = Metres::from_mm(0.01);
    let fault = GridShape::for_tool_and_view(&pot, fine, fine).expect_err("too many elements");
    assert!(fault.to_string().contains("elements"), "{fault}");
}
