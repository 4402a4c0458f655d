//! How a tool is turned: every value is a turn, the same seen from everywhere round the pot, and what a device reports is
//! kept to the step.

use glam::{Quat, Vec3};
use pottery_shared::tool::{Orientation, Pose};
use proptest::prelude::*;

/// Where a turn takes the three axes.
fn axes(turn: Quat) -> [Vec3; 3] {
    let turn = Pose { centre_m: Vec3::ZERO, orientation: turn }.turn().expect("a quaternion with a length");
    [turn.x_axis, turn.y_axis, turn.z_axis]
}

fn farthest(one: Quat, other: Quat) -> f32 {
    axes(one).into_iter().zip(axes(other)).map(|(a, b)| a.distance(b)).fold(0.0, f32::max)
}

fn place() -> impl Strategy<Value = Vec3> {
    prop::array::uniform3(-0.3_f32..0.3).prop_map(Vec3::from_array)
}

proptest! {
    #[test]
    fn every_value_is_a_turn_of_length_one(steps in any::<[i16; 3]>(), place in prop::array::uniform3(-1.0_f32..1.0)) {
        let turn = Orientation(steps).at(Vec3::from_array(place));
        // three roundings of an f32 in each of four parts
        prop_assert!((turn.length() - 1.0).abs() < 1e-6, "{turn}");
    }

    #[test]
    fn angles_give_their_steps_back(steps in any::<[i16; 3]>(), turns in prop::array::uniform3(-3_i8..3)) {
        let orientation = Orientation(steps);
        prop_assert_eq!(Orientation::nearest(orientation.angles_rad()), Some(orientation));
        let mut more = orientation.angles_rad();
        for (angle, turns) in more.iter_mut().zip(turns) {
            *angle += f32::from(turns) * std::f32::consts::TAU;
        }
        prop_assert_eq!(Orientation::nearest(more), Some(orientation));
    }

    #[test]
    fn a_turn_in_the_room_is_kept_to_the_step(
        axis in prop::array::uniform3(-1.0_f32..1.0), angle in -7.0_f32..7.0, place in place(),
    ) {
        let axis = Vec3::from_array(axis);
        prop_assume!(axis.length() > 1e-2);
        let turn = Quat::from_axis_angle(axis.normalize(), angle);
        let orientation = Orientation::of(turn, place).expect("this quaternion has a length");
        // half a step in each of three angles, and what the arcs lose beside the pole: 1e-4
        prop_assert!(farthest(orientation.at(place), turn) < 3.0 * Orientation::STEP_RAD + 2e-4);
        // of any length, but for a half step that falls to the other side
        let longer = Orientation::of(turn * 3.0, place).expect("this quaternion has a length");
        prop_assert!(farthest(longer.at(place), orientation.at(place)) < 2.0 * Orientation::STEP_RAD);
    }

    #[test]
    fn a_tool_that_goes_round_the_pot_keeps_facing_it(steps in any::<[i16; 3]>(), place in place(), by in -3.0_f32..3.0) {
        prop_assume!(place.truncate().length() > 1e-3);
        let there = Quat::from_rotation_z(by) * place;
        let carried = Quat::from_rotation_z(by) * Orientation(steps).at(place);
        // the angle of a place 1 mm from the axis is known to 1e-7 of it
        prop_assert!(farthest(Orientation(steps).at(there), carried) < 5e-6);
    }

    #[test]
    fn the_way_to_another_orientation_is_the_short_one(from in any::<[i16; 3]>(), to in any::<[i16; 3]>()) {
        let (from, to) = (Orientation(from), Orientation(to));
        prop_assert_eq!((from.towards(to, 0.0), from.towards(to, 1.0)), (from, to));
        let half = from.towards(to, 0.5);
        for axis in 0..3 {
            let whole = i32::from(to.0[axis].wrapping_sub(from.0[axis]));
            let part = i32::from(half.0[axis].wrapping_sub(from.0[axis]));
            prop_assert!((2 * part - whole).abs() <= 1, "{from:?} {half:?} {to:?}");
        }
    }
}

#[test]
fn what_is_no_turn_is_none() {
    let place = Vec3::new(0.1, 0.0, 0.0);
    for turn in
        [Quat::from_array([0.0; 4]), Quat::from_array([f32::NAN, 0.0, 0.0, 1.0]), Quat::from_array([f32::INFINITY; 4])]
    {
        assert_eq!(Orientation::of(turn, place), None, "{turn}");
    }
    for angle in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
        assert_eq!(Orientation::nearest([0.0, angle, 0.0]), None, "{angle}");
    }
}

#[test]
fn a_rib_as_it_hangs_shows_its_edge_to_the_axis_from_everywhere() {
    for degrees in [0.0_f32, 73.0, 180.0, -90.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let place = Vec3::new(0.08 * cos, 0.08 * sin, 0.1);
        let edge = Orientation::default().at(place) * Vec3::NEG_X;
        assert!(edge.dot(place.with_z(0.0).normalize()) < -0.999_999, "{degrees}°: {edge}");
    }
}
