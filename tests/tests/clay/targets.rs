//! What a pot is to become: that a profile is the pot's own, and that what is off by is off by that much.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use pottery_shared::clay::{Form, GridShape, Pot, PotSpec, Target};
use pottery_shared::protocol::TargetWire;
use pottery_shared::session::{target_of, target_wire};
use pottery_shared::units::Metres;

/// The usual pot with every radius changed by what a column and a row say, m.
fn changed(by_m: impl Fn(u32, u32) -> f32) -> Pot {
    let mut pot = Pot::new(PotSpec { keeps_volume: false, ..PotSpec::default() }).unwrap();
    let surface = &mut pot.surfaces_mut()[0];
    for column in 0..surface.shape().columns() {
        for row in 0..surface.shape().rows() {
            let radius_m = surface.column_m(column)[row as usize];
            surface.set_radius(column, row, radius_m + by_m(column, row));
        }
    }
    pot
}

#[test]
fn a_pot_is_nowhere_off_its_own_profile() {
    for form in Form::ALL {
        let pot = form.pot(PotSpec::default()).unwrap();
        let deviation = Target::of(&pot).deviation(&pot);
        // 65 radii are joined by straight lines: steepest at the poles of the ball, where 2 mm of height bend by a tenth
        assert!(deviation.rms_m < 5e-5 && deviation.most_m < 3e-4, "{form:?}: {deviation:?}");
        assert_eq!(deviation.higher_m, 0.0);
    }
}

#[test]
fn what_is_off_is_off_by_that_much_and_where_it_is() {
    let target = Target::of(&changed(|_, _| 0.0));
    let even = target.deviation(&changed(|_, _| 0.002));
    assert!((even.rms_m - 0.002).abs() < 1e-7 && (even.most_m - 0.002).abs() < 1e-7, "{even:?}");
    // half of the columns 2 mm in and half 2 mm out: round as a mean, and yet off
    let oval = target.deviation(&changed(|column, _| if column < 180 { 0.002 } else { -0.002 }));
    assert!((oval.rms_m - 0.002).abs() < 1e-7, "{oval:?}");
    // a dent of one element in 144,000, 10 mm deep: √(10²/144,000) mm
    let dent = target.deviation(&changed(|column, row| if (column, row) == (7, 100) { -0.01 } else { 0.0 }));
    assert!((dent.rms_m - 0.01 / 144_000_f32.sqrt()).abs() < 1e-8, "{dent:?}");
    // row 100 of 400 over 200 mm
    assert!((dent.most_m - 0.01).abs() < 1e-7 && (dent.most_at_m - 0.2 * 100.0 / 399.0).abs() < 1e-6, "{dent:?}");
}

#[test]
fn the_rim_counts_however_high_the_pot_is() {
    let shape = GridShape::new(8, 400).unwrap();
    for height_mm in 100..300_u16 {
        let height = Metres::from_mm(f32::from(height_mm));
        let mut pot = Pot::new(PotSpec { shape, height, ..PotSpec::default() }).unwrap();
        let target = Target::of(&pot);
        for column in 0..8 {
            pot.surfaces_mut()[0].set_radius(column, 399, 0.062);
        }
        // 399 of the distances between rows are more than the height itself in 1 of 20 pots, by a rounding
        let found = target.deviation(&pot);
        assert!((found.most_m - 0.002).abs() < 1e-7, "{height_mm} mm: {found:?}");
        assert!((found.most_at_m - height.0).abs() < 1e-7, "{height_mm} mm: {found:?}");
        assert!((found.rms_m - 0.002 / 20.0).abs() < 1e-8, "{height_mm} mm: {found:?}");
    }
}

#[test]
fn what_travels_is_the_profile_to_two_micrometres_and_what_is_none_is_refused() {
    for form in Form::ALL {
        let target = Target::of(&form.pot(PotSpec::default()).unwrap());
        let back = target_of(&target_wire(&target)).unwrap();
        let off_m = target.radii_m().iter().zip(back.radii_m()).map(|(one, other)| (one - other).abs());
        assert!(off_m.fold(0.0, f32::max) <= 2.01e-6 && back.height_m() == target.height_m());
    }
    let sound = target_wire(&Target::of(&changed(|_, _| 0.0)));
    for height_m in [f32::NAN, 0.0, -0.2, 5.0, f32::INFINITY] {
        assert_eq!(target_of(&TargetWire { height_m, ..sound.clone() }), None, "{height_m} m");
    }
    for radii in [Vec::new(), vec![15_000; 64], vec![15_000; 66], vec![0; 65], vec![u16::MAX; 65]] {
        assert_eq!(target_of(&TargetWire { radii: radii.clone(), ..sound.clone() }), None, "{radii:?}");
    }
}
