//! From a device's own frame to the room: the one place where axes, middle and scale are applied.
//!
//! Pure: knows no device, no clock.
//! Invariant: a force goes back along the axes that the position came by, so that work in the room and at the device
//! have one sign.

use glam::{Mat3, Vec3};
use pottery_shared::haptics::DeviceSpecs;

use super::fitting::Fit;

/// Where the middle of a device's workspace lies in the room, m: 40 mm in front of the untouched pot's wall, halfway up.
pub const MIDDLE_ROOM_M: Vec3 = Vec3::new(0.0, -0.100, 0.100);

/// How a device's axes lie in the room, for a person who sits before the wheel as the first picture shows it: right is
/// +x, away is +y, up is +z.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axes {
    /// x right, y up, z towards the person: HDAPI, the Falcon, the gamepad.
    YUp,
    /// x right, y away from the person, z up: Haply's basis `XYZ`, which is the room's own.
    ZUp,
}

impl Axes {
    /// Turns a vector in the device's frame into one in the room's.
    const fn room_from_device(self) -> Mat3 {
        match self {
            Self::YUp => Mat3::from_cols(Vec3::X, Vec3::Z, Vec3::NEG_Y),
            Self::ZUp => Mat3::IDENTITY,
        }
    }
}

/// Workspace to pot.
///
/// `room = middle_room + s·(R·device − middle)`, force `device = Rᵀ·room`; all lengths in m. What is felt is
/// the room's force, so that a workspace scaled by s feels s times as stiff: [`Calibration::specs_in_room`] allows for it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    room_from_device: Mat3,
    fit: Fit,
}

/// A scale that no workspace can have.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("a scale of {scale} cannot be used: choose one from {} to {}", Calibration::SCALE_MIN, Calibration::SCALE_MAX)]
pub struct ScaleError {
    /// What was asked for.
    pub scale: f32,
}

impl Calibration {
    /// Least and greatest scale.
    pub const SCALE_MIN: f32 = 0.1;
    /// See [`Calibration::SCALE_MIN`].
    pub const SCALE_MAX: f32 = 10.0;

    /// Puts the middle of a device's workspace, m in its own frame, before the pot.
    #[must_use]
    pub fn new(axes: Axes, middle_device_m: Vec3) -> Self {
        let room_from_device = axes.room_from_device();
        Self { room_from_device, fit: Fit { middle_m: room_from_device * middle_device_m, scale: 1.0 } }
    }

    /// Lets the tool go `scale` times as far as the hand.
    ///
    /// # Errors
    /// [`ScaleError`] when no hand could work with it.
    pub fn scaled(mut self, scale: f32) -> Result<Self, ScaleError> {
        if !(Self::SCALE_MIN..=Self::SCALE_MAX).contains(&scale) {
            return Err(ScaleError { scale });
        }
        self.fit.scale = scale;
        Ok(self)
    }

    /// Middle and scale as a person has fitted them; a fit that makes no sense changes nothing.
    #[must_use]
    pub fn fitted(self, fit: Fit) -> Self {
        Self { fit: fit.sound().unwrap_or(self.fit), ..self }
    }

    /// Middle and scale.
    #[must_use]
    pub const fn fit(&self) -> Fit {
        self.fit
    }

    /// A place of the device, m, along the room's axes: as [`Fit::middle_m`].
    #[must_use]
    pub fn turned(&self, device_m: Vec3) -> Vec3 {
        self.room_from_device * device_m
    }

    /// A place in the room, m.
    #[must_use]
    pub fn place(&self, device_m: Vec3) -> Vec3 {
        MIDDLE_ROOM_M + (self.turned(device_m) - self.fit.middle_m) * self.fit.scale
    }

    /// A velocity in the room, m/s.
    #[must_use]
    pub fn velocity(&self, device_m_s: Vec3) -> Vec3 {
        self.room_from_device * device_m_s * self.fit.scale
    }

    /// A force of the room in the device's frame, N.
    #[must_use]
    pub fn force_to_device(&self, room_n: Vec3) -> Vec3 {
        self.room_from_device.transpose() * room_n
    }

    /// What the device can do, seen from the room: lengths grow with the scale, and everything that is a force over a
    /// length, a velocity or an acceleration shrinks with it.
    #[must_use]
    pub fn specs_in_room(&self, device: DeviceSpecs) -> DeviceSpecs {
        let scale = self.fit.scale;
        DeviceSpecs {
            stiffness_max_n_m: device.stiffness_max_n_m / scale,
            damping_max_ns_m: device.damping_max_ns_m / scale,
            workspace_radius_m: (device.workspace_radius_m * scale).min(pottery_shared::tool::Position::REACH.0),
            mass_kg: device.mass_kg / scale,
            damping_ns_m: device.damping_ns_m / scale,
            resolution_m: device.resolution_m * scale,
            ..device
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn calibrations() -> [Calibration; 3] {
        let new = |axes, scale| Calibration::new(axes, Vec3::new(0.01, -0.02, 0.125)).scaled(scale).unwrap();
        [new(Axes::YUp, 1.0), new(Axes::ZUp, 0.5), new(Axes::YUp, 4.0)]
    }

    #[test]
    fn axes_are_right_handed_and_keep_lengths() {
        for axes in [Axes::YUp, Axes::ZUp] {
            let matrix = axes.room_from_device();
            assert_eq!((matrix.determinant(), matrix * matrix.transpose()), (1.0, Mat3::IDENTITY));
        }
        // a y-up device: right, up, towards the person
        let matrix = Axes::YUp.room_from_device();
        assert_eq!([matrix * Vec3::X, matrix * Vec3::Y, matrix * Vec3::Z], [Vec3::X, Vec3::Z, Vec3::NEG_Y]);
    }

    #[test]
    fn work_in_the_room_is_the_scale_times_work_at_the_device() {
        let (moved_m, force_n) = (Vec3::new(1e-3, -2e-3, 0.5e-3), Vec3::new(0.5, -1.0, 2.0));
        for calibration in calibrations() {
            let device_m = Vec3::new(0.02, 0.03, 0.1);
            let room_m = calibration.place(device_m + moved_m) - calibration.place(device_m);
            let (in_room, at_device) = (force_n.dot(room_m), calibration.force_to_device(force_n).dot(moved_m));
            // places of 0.1 m hold 1e-8 m
            assert!((in_room - calibration.fit.scale * at_device).abs() < 2e-7, "{in_room} and {at_device} J");
            assert!((calibration.velocity(moved_m) - room_m).length() < 1e-7);
        }
    }

    #[test]
    fn middle_is_where_it_is_put_and_nonsense_does_not_move_it() {
        for calibration in calibrations() {
            assert_eq!(calibration.place(Vec3::new(0.01, -0.02, 0.125)), MIDDLE_ROOM_M);
            let here = Vec3::new(-0.03, 0.04, 0.11);
            let fit = Fit { middle_m: calibration.turned(here), scale: 2.0 };
            let fitted = calibration.fitted(fit);
            assert_eq!((fitted.place(here), fitted.fit()), (MIDDLE_ROOM_M, fit));
            for nonsense in [Fit { middle_m: Vec3::NAN, ..fit }, Fit { scale: 0.0, ..fit }] {
                assert_eq!(fitted.fitted(nonsense), fitted);
            }
        }
    }

    #[test]
    fn what_is_a_spring_at_the_device_is_a_softer_one_in_a_larger_room() {
        let specs = calibrations()[2].specs_in_room(DeviceSpecs::OMNI);
        assert_eq!(specs.stiffness_max_n_m, 175.0);
        assert_eq!(specs.workspace_radius_m, 0.4);
        assert_eq!(specs.peak_force_n, DeviceSpecs::OMNI.peak_force_n);
        assert!(specs.checked().is_ok());
        for scale in [0.0, -1.0, f32::NAN, 11.0] {
            assert!(Calibration::new(Axes::YUp, Vec3::ZERO).scaled(scale).is_err());
        }
    }
}
