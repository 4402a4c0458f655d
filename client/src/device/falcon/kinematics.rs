//! The Novint Falcon as a mechanism: three legs of one motor each that hold one grip.
//!
//! Pure: encoder counts to angles, angles to the grip's place and back, forces to torques. Lengths are those of
//! libnifalcon's `FalconGeometry.h`, after Stamper's thesis (1997) on the three-legged mechanism; the equations are derived here.
//! Invariant: a place that [`place_m`] returns has the angles it was asked for to 1e-9 rad.

use std::f64::consts::PI;

use glam::{DMat3, DVec3};

/// Motor axis to knee, m.
const THIGH_M: f64 = 0.060;
/// Length of the shin's parallelogram, m.
const SHIN_M: f64 = 0.1025;
/// Knee to shin and shin to grip along the leg, m, together.
const JOINTS_M: f64 = 2.0 * 0.01125;
/// Middle of the grip to where a shin takes hold of it, along and across the leg, m.
const GRIP_M: (f64, f64) = (0.01443, -0.025);
/// Middle of the base to the motor's axis, along and across the leg, m.
const BASE_M: (f64, f64) = (0.0400, -0.02309);
/// Directions of the legs about z, rad: 90°, −30° and −150°, turned by 15° against the desk.
const LEGS_RAD: [f64; 3] = [PI / 2.0 + PI / 12.0, -PI / 6.0 + PI / 12.0, -5.0 * PI / 6.0 + PI / 12.0];
/// Angle of a leg at encoder count zero, degrees.
const ANGLE_AT_ZERO_DEG: f64 = 35.0;
/// The motor's drum over the leg's, and counts in a turn of the motor: 320 slots, read fourfold.
const DRUMS: f64 = 14.25 / 110.0;
const COUNTS_IN_A_TURN: f64 = 1280.0;

/// Middle of the workspace in the device's frame (x right, y up, z towards the person), m.
pub const MIDDLE_M: DVec3 = DVec3::new(0.0, 0.0, 0.125);

/// Newton steps after which no place is found; from anywhere in the workspace eight are enough.
const STEPS_MAX: usize = 40;
/// Longest step, m, and how near the angles have to come, rad.
const STEP_MAX_M: f64 = 0.02;
const NEAR_RAD: f64 = 1e-10;

/// Angle of a leg, rad.
///
/// `θ° = counts · (14.25/110) · 360/1280 + 35` (libnifalcon, `FalconKinematic.h`).
#[must_use]
pub fn angle_rad(counts: i16) -> f64 {
    (f64::from(counts) * DRUMS * 360.0 / COUNTS_IN_A_TURN + ANGLE_AT_ZERO_DEG).to_radians()
}

/// The count nearest to an angle, rad: what the encoder shows there.
#[must_use]
pub fn counts_at(angle_rad: f64) -> i16 {
    ((angle_rad.to_degrees() - ANGLE_AT_ZERO_DEG) * COUNTS_IN_A_TURN / (360.0 * DRUMS)).round() as i16
}

/// The point where a leg's shin takes hold of the grip, from the leg's motor: along it, across it, and up (z).
fn hold_m(leg: usize, grip_m: DVec3) -> DVec3 {
    let (sine, cosine) = LEGS_RAD[leg].sin_cos();
    DVec3::new(
        cosine * grip_m.x + sine * grip_m.y - BASE_M.0 + GRIP_M.0,
        cosine * grip_m.y - sine * grip_m.x - BASE_M.1 + GRIP_M.1,
        grip_m.z,
    )
}

/// Length of the shin in the plane of its thigh, m, when it stands `across_m` out of it, and the root it was made with.
fn reach_m(across_m: f64) -> Option<(f64, f64)> {
    let square = SHIN_M * SHIN_M - across_m * across_m;
    (square > 0.0).then(|| (JOINTS_M + square.sqrt(), square.sqrt()))
}

/// Angles of the legs that hold the grip at a place, rad; `None` where the legs do not reach.
///
/// With the hold (u, v, w) of a leg, `(u − a·cos θ)² + (w − a·sin θ)² = L(v)²`: of its two solutions the one with the
/// knee outside.
#[must_use]
pub fn angles_rad(grip_m: DVec3) -> Option<[f64; 3]> {
    let mut angles = [0.0; 3];
    for (leg, angle) in angles.iter_mut().enumerate() {
        let hold = hold_m(leg, grip_m);
        let (reach, _) = reach_m(hold.y)?;
        let square = hold.x * hold.x + hold.z * hold.z;
        let cosine = (square + THIGH_M * THIGH_M - reach * reach) / (2.0 * THIGH_M * square.sqrt());
        if cosine.is_nan() || cosine.abs() > 1.0 {
            return None;
        }
        *angle = hold.z.atan2(hold.x) - cosine.acos();
    }
    Some(angles)
}

/// How the angles change with the place, rad/m: row i is ∂θᵢ/∂(x, y, z).
///
/// From the derivative of the leg's equation; `None` in a pose in which a leg can give way without its motor.
fn angles_by_place(grip_m: DVec3, angles_rad: [f64; 3]) -> Option<DMat3> {
    let mut rows = [DVec3::ZERO; 3];
    for (leg, row) in rows.iter_mut().enumerate() {
        let hold = hold_m(leg, grip_m);
        let (reach, root) = reach_m(hold.y)?;
        let (sine, cosine) = angles_rad[leg].sin_cos();
        let by_angle = THIGH_M * (hold.x * sine - hold.z * cosine);
        // 0.1 mm of lever: far outside of the workspace
        if by_angle.abs() < THIGH_M * 1e-4 {
            return None;
        }
        let along = hold.x - THIGH_M * cosine;
        let across = reach * hold.y / root;
        let up = hold.z - THIGH_M * sine;
        let (turn_sine, turn_cosine) = LEGS_RAD[leg].sin_cos();
        *row = -DVec3::new(along * turn_cosine - across * turn_sine, along * turn_sine + across * turn_cosine, up)
            / by_angle;
    }
    Some(DMat3::from_cols(rows[0], rows[1], rows[2]).transpose())
}

/// Where the grip is, m, when the legs have these angles, sought from a place near it; `None` when no place has them.
#[must_use]
pub fn place_m(wanted_rad: [f64; 3], near_m: DVec3) -> Option<DVec3> {
    let mut place = if angles_rad(near_m).is_some() { near_m } else { MIDDLE_M };
    for _ in 0..STEPS_MAX {
        let angles = angles_rad(place)?;
        let off = DVec3::from_array(wanted_rad) - DVec3::from_array(angles);
        if off.abs().max_element() < NEAR_RAD {
            return Some(place);
        }
        let matrix = angles_by_place(place, angles)?;
        if matrix.determinant().abs() < 1.0 {
            return None;
        }
        let mut step = (matrix.inverse() * off).clamp_length_max(STEP_MAX_M);
        // back into reach, if the step leads out of it
        for _ in 0..8 {
            if angles_rad(place + step).is_some() {
                break;
            }
            step *= 0.5;
        }
        place += step;
    }
    None
}

/// Torques of the motors' legs, N·m, that give a force at the grip, N.
///
/// By virtual work `τ = Jᵀ·F` with `J = ∂(x, y, z)/∂θ`; `None` in a pose in which the force cannot be given.
#[must_use]
pub fn torques_nm(grip_m: DVec3, force_n: DVec3) -> Option<[f64; 3]> {
    let matrix = angles_by_place(grip_m, angles_rad(grip_m)?)?;
    if matrix.determinant().abs() < 1.0 {
        return None;
    }
    Some((matrix.inverse().transpose() * force_n).to_array())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid over the 4-inch cube, as far as the legs reach.
    fn workspace() -> impl Iterator<Item = DVec3> {
        let steps = |n: i32| (-n..=n).map(move |i| f64::from(i) / f64::from(n));
        steps(4)
            .flat_map(move |x| steps(4).flat_map(move |y| steps(4).map(move |z| DVec3::new(x, y, z))))
            .map(|unit| MIDDLE_M + unit * 0.045)
            .filter(|place| angles_rad(*place).is_some())
    }

    #[test]
    fn place_found_from_angles_is_where_they_came_from() {
        let mut reached = 0;
        for place in workspace() {
            let angles = angles_rad(place).unwrap();
            let Some(found) = place_m(angles, MIDDLE_M) else { panic!("nothing found for {place}") };
            let again = angles_rad(found).unwrap();
            for leg in 0..3 {
                assert!(
                    (again[leg] - angles[leg]).abs() < 1e-9,
                    "{place}: leg {leg} off by {}",
                    again[leg] - angles[leg]
                );
            }
            // 1e-9 rad at a leg of some 0.1 m
            assert!(found.distance(place) < 1e-8, "{place} was found at {found}");
            reached += 1;
        }
        assert!(reached > 500, "only {reached} places in reach");
    }

    #[test]
    fn angles_are_those_of_the_public_drivers_equations() {
        // evaluated from the half-angle equations of libnifalcon's FalconKinematicStamper.cpp, which are written otherwise
        for (place, expected) in [
            (DVec3::new(0.0, 0.0, 0.125), [0.483618371, 0.483618371, 0.483618371]),
            (DVec3::new(0.02, -0.03, 0.11), [0.757538369, 0.053398491, 0.300611495]),
            (DVec3::new(-0.035, 0.01, 0.15), [0.743152273, 1.217599167, 0.776006616]),
        ] {
            let found = angles_rad(place).unwrap();
            for leg in 0..3 {
                assert!((found[leg] - expected[leg]).abs() < 1e-8, "{place}: {found:?}");
            }
        }
    }

    #[test]
    fn derivative_of_the_angles_is_their_difference() {
        for place in workspace() {
            let Some(matrix) = angles_by_place(place, angles_rad(place).unwrap()) else { continue };
            let step = 1e-6;
            for (axis, direction) in [DVec3::X, DVec3::Y, DVec3::Z].into_iter().enumerate() {
                let (Some(after), Some(before)) =
                    (angles_rad(place + direction * step), angles_rad(place - direction * step))
                else {
                    continue;
                };
                for leg in 0..3 {
                    let difference = (after[leg] - before[leg]) / (2.0 * step);
                    let derivative = matrix.row(leg)[axis];
                    // second order in the step, with curvatures up to 1e6 where a leg is nearly stretched
                    let scale = matrix.row(leg).length();
                    assert!((difference - derivative).abs() < 1e-4 * scale, "{place}: {difference} and {derivative}");
                }
            }
        }
    }

    #[test]
    fn work_of_the_torques_is_work_of_the_force() {
        let force = DVec3::new(1.0, -2.0, 0.5);
        for place in workspace() {
            let Some(torques) = torques_nm(place, force) else { continue };
            let matrix = angles_by_place(place, angles_rad(place).unwrap()).unwrap();
            for moved in [DVec3::X, DVec3::Y, DVec3::Z] {
                let turned = matrix * moved;
                let done = DVec3::from_array(torques).dot(turned);
                assert!((done - force.dot(moved)).abs() < 1e-9, "{place}: {done} J a metre");
            }
        }
    }

    #[test]
    fn a_turn_of_the_motor_is_the_drums_share_of_a_turn_of_the_leg() {
        assert!((angle_rad(0).to_degrees() - 35.0).abs() < 1e-12);
        let turn = (angle_rad(1280) - angle_rad(0)).to_degrees();
        assert!((turn - 360.0 * 14.25 / 110.0).abs() < 1e-9, "{turn}");
        for counts in [-1500, -1, 0, 7, 1500] {
            assert_eq!(counts_at(angle_rad(counts)), counts);
        }
    }

    #[test]
    fn angles_that_no_grip_has_give_no_place() {
        assert_eq!(place_m([angle_rad(i16::MAX), 0.5, 0.5], MIDDLE_M), None);
        assert_eq!(place_m([f64::NAN; 3], MIDDLE_M), None);
        assert_eq!(angles_rad(DVec3::new(0.0, 0.0, 1.0)), None);
    }
}
