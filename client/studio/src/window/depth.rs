//! How far a tool is from the clay, for the ring by which a person sees it.
//!
//! Pure: knows no window. Looks at elements only, coarsely first and then all of those about the nearest.
//! Invariant: what it finds is the way to an element of the pot, and none of those looked at is nearer.

use glam::Vec3;
use pottery_shared::clay::{Phase, Pot, Skin};

/// Elements left out between two that are looked at first, each way.
const COARSE: u32 = 6;

/// From a point of the room to the nearest element of a pot that has turned by `phase`, m.
pub(super) fn to_clay_m(pot: &Pot, phase: Phase, point_m: Vec3) -> f32 {
    let at_m = phase.pot_from_room(point_m);
    let nearest = pot.skins().into_iter().map(|skin| nearest_square_m2(pot, skin, at_m)).fold(f32::INFINITY, f32::min);
    nearest.sqrt()
}

fn nearest_square_m2(pot: &Pot, skin: Skin, at_m: Vec3) -> f32 {
    let surface = &pot.surfaces()[skin.surface];
    let shape = surface.shape();
    let (columns, rows) = (i64::from(shape.columns()), i64::from(shape.rows()));
    let square = |column: i64, row: i64| {
        let column = column.rem_euclid(columns) as u32;
        let radius_m = surface.column_m(column)[row as usize] - skin.inset_m;
        let (sin, cos) = (column as f32 * shape.column_angle_rad()).sin_cos();
        let element_m = Vec3::new(radius_m * cos, radius_m * sin, surface.row_z_m(row as u32));
        (element_m.distance_squared(at_m), column as i64, row)
    };
    let nearer = |one: (f32, i64, i64), other: (f32, i64, i64)| if other.0 < one.0 { other } else { one };
    let step = COARSE as usize;
    let coarse = (0..columns).step_by(step).flat_map(|column| (0..rows).step_by(step).map(move |row| (column, row)));
    let (_, column, row) = coarse.map(|(column, row)| square(column, row)).fold((f32::INFINITY, 0, 0), nearer);
    let about = i64::from(COARSE);
    let fine = (column - about..=column + about)
        .flat_map(|column| ((row - about).max(0)..=(row + about).min(rows - 1)).map(move |row| (column, row)));
    fine.map(|(column, row)| square(column, row)).fold((f32::INFINITY, 0, 0), nearer).0
}

#[cfg(test)]
mod tests {
    use super::*;
    use pottery_shared::clay::PotSpec;

    #[test]
    fn a_point_beside_a_cylinder_is_as_far_as_it_was_put() {
        let pot = Pot::new(PotSpec::default()).expect("the usual pot can be made");
        let spec = PotSpec::default();
        for turned in [0, 1 << 30, 3_000_000_000] {
            for (angle, z_m, gap_m) in [(0.3_f32, 0.1, 0.02), (-2.0, 0.05, 0.004), (3.1, 0.19, 0.05)] {
                let at = |radius_m: f32| Vec3::new(radius_m * angle.cos(), radius_m * angle.sin(), z_m);
                let outside_m = to_clay_m(&pot, Phase(turned), at(spec.radius.0 + gap_m));
                // half an element each way: 0.5 mm round the pot and 0.25 mm along it, at 4 mm 0.04 mm farther
                assert!((outside_m - gap_m).abs() < 5e-5, "{outside_m} for {gap_m}");
                let inner_m = spec.radius.0 - spec.wall.0;
                let inside_m = to_clay_m(&pot, Phase(turned), at(inner_m - gap_m.min(0.02)));
                assert!((inside_m - gap_m.min(0.02)).abs() < 5e-5, "{inside_m} for {gap_m}");
            }
        }
    }
}
