//! How a tool is turned in the hand, in steps that travel as they are.
//!
//! Knows no clay and no wheel; the frame that the angles are seen in is the tool's own place.
//! Invariant: every value is an orientation, whatever a peer sends, and gives the same quaternion everywhere.

use core::f32::consts::TAU;

use glam::{Quat, Vec3};

use super::Pose;
use crate::lanes::hypot;

/// How a tool is turned, seen from where it stands: x points away from the axis, y round it, z up.
///
/// Yaw ψ, pitch θ and roll φ in steps of [`Orientation::STEP_RAD`], `R = R_z(ψ)·R_y(θ)·R_x(φ)`. All zero holds a tool as
/// its mesh has it: those of the rack stand upright with their edge towards the axis. A tool that goes round the pot and
/// keeps facing it has one orientation, which costs nothing to send. Angles wrap, so that there is no value that a peer
/// could send and that would not be an orientation.
///
/// ```
/// use glam::Vec3;
/// use pottery_shared::tool::Orientation;
///
/// let leaning = Orientation::nearest([0.0, 0.1, 0.0]).ok_or("these are angles")?;
/// // at the back of the pot, 180° round, it leans as it did in front: its upper end away from the axis
/// let up = leaning.at(Vec3::new(-0.06, 0.0, 0.1)) * Vec3::Z;
/// assert!(up.x < -0.099 && up.y.abs() < 1e-3);
/// # Ok::<(), &str>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Orientation(pub [i16; 3]);

impl Orientation {
    /// Resolution of an angle: 14 µm at the end of the largest tool, about the step of a position.
    pub const STEP_RAD: f32 = TAU / 65_536.0;

    /// The nearest step to yaw, pitch and roll, rad; `None` when one of them is not finite.
    #[must_use]
    pub fn nearest(angles_rad: [f32; 3]) -> Option<Self> {
        let step = |angle_rad: f32| {
            let turns = f64::from(angle_rad) / f64::from(TAU);
            // whole turns are the same, and the cast must not see them: half a turn wraps
            libm::round((turns - libm::floor(turns)) * 65_536.0) as u32 as u16 as i16
        };
        angles_rad.iter().all(|angle| angle.is_finite()).then(|| Self(angles_rad.map(step)))
    }

    /// The nearest to a tool turned by `turn` at a place, both in the room: what a device with six degrees of freedom
    /// reports. `None` when the quaternion has no length or is not finite.
    #[must_use]
    pub fn of(turn: Quat, place_m: Vec3) -> Option<Self> {
        let facing = Pose::about_z(turn, -f64::from(azimuth_rad(place_m)));
        let rotation = Pose { centre_m: Vec3::ZERO, orientation: facing }.turn()?;
        let [down, across] = [-rotation.x_axis.z, hypot(rotation.x_axis.x, rotation.x_axis.y)];
        let pitch = libm::atan2f(down, across);
        // upright along x, yaw and roll are one angle
        let (yaw, roll) = if across > 1e-4 {
            (libm::atan2f(rotation.x_axis.y, rotation.x_axis.x), libm::atan2f(rotation.y_axis.z, rotation.z_axis.z))
        } else {
            (libm::atan2f(-rotation.y_axis.x, rotation.y_axis.y), 0.0)
        };
        Self::nearest([yaw, pitch, roll])
    }

    /// Yaw, pitch and roll, rad, from −π to π.
    #[must_use]
    pub fn angles_rad(self) -> [f32; 3] {
        self.0.map(|steps| f32::from(steps) * Self::STEP_RAD)
    }

    /// The turn of a tool held at a place, in the frame in which the place is given, room or pot.
    #[must_use]
    pub fn at(self, place_m: Vec3) -> Quat {
        let [(sy, cy), (sp, cp), (sr, cr)] = self.angles_rad().map(|angle| libm::sincos(0.5 * f64::from(angle)));
        let facing = Quat::from_xyzw(
            (sr * cp * cy - cr * sp * sy) as f32,
            (cr * sp * cy + sr * cp * sy) as f32,
            (cr * cp * sy - sr * sp * cy) as f32,
            (cr * cp * cy + sr * sp * sy) as f32,
        );
        Pose::about_z(facing, f64::from(azimuth_rad(place_m)))
    }

    /// A share of the way to another orientation, each angle the short way round.
    #[must_use]
    pub fn towards(self, other: Self, share: f32) -> Self {
        let part = |(from, to): (i16, i16)| {
            from.wrapping_add(libm::roundf(f32::from(to.wrapping_sub(from)) * share.clamp(0.0, 1.0)) as i16)
        };
        let mut pairs = self.0.into_iter().zip(other.0).map(part);
        Self(core::array::from_fn(|_| pairs.next().unwrap_or_default()))
    }
}

/// The angle round the axis at which a place lies; 0 on the axis itself.
fn azimuth_rad(place_m: Vec3) -> f32 {
    libm::atan2f(place_m.y, place_m.x)
}
