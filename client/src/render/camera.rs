//! Where the picture is seen from.
//!
//! Owns the projection and its inverse; of a pot it knows the size, and no device.
//! Invariant: a ray through the place where a point is shown passes through that point.

use glam::camera::rh;
use glam::{Mat4, Vec2, Vec3, Vec4};
use pottery_shared::clay::Pot;

/// A camera on an orbit round a target, room frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// Angle about the wheel's axis from x towards y at which the camera stands, rad.
    pub azimuth_rad: f32,
    /// Angle above the horizontal, rad; kept within ±[`Camera::ELEVATION_MAX_RAD`].
    pub elevation_rad: f32,
    /// Distance from the target, m; kept above [`Camera::DISTANCE_MIN_M`].
    pub distance_m: f32,
    /// The point that it looks at, m.
    pub target_m: Vec3,
    /// Where that is shown across the picture, from −1 at its left edge to 1 at its right: beside what lies over the picture.
    pub aside_ndc: f32,
    /// Angle of view over the height of a picture that is at least as wide as [`Camera::ASPECT_MIN`], rad.
    pub view_angle_rad: f32,
}

impl Default for Camera {
    /// In front of a pot of 200 mm height and 60 mm radius, high enough to look into it, with room above to pull up.
    fn default() -> Self {
        Self {
            azimuth_rad: -core::f32::consts::FRAC_PI_2,
            elevation_rad: 0.45,
            distance_m: 0.62,
            target_m: Vec3::new(0.0, 0.0, 0.09),
            aside_ndc: 0.0,
            view_angle_rad: 0.56,
        }
    }
}

impl Camera {
    /// Steepest view up or down, rad: short of the axis, where no side would be up.
    pub const ELEVATION_MAX_RAD: f32 = 1.54;
    /// Highest that a pointer turns the view, rad: nearly from above.
    pub const ABOVE_RAD: f32 = 1.4;
    /// Least distance from the target, m.
    pub const DISTANCE_MIN_M: f32 = 0.05;
    /// Narrower pictures (width over height) widen the angle of view instead of cutting the pot off.
    pub const ASPECT_MIN: f32 = 1.1;
    /// By how much a pixel turns the view round the axis and up, rad, and how far it looks up from below the target, rad.
    const TURN_RAD: Vec2 = Vec2::new(0.008, 0.006);
    const BELOW_RAD: f32 = -0.1;
    const NEAR_M: f32 = 0.02;
    const FAR_M: f32 = 8.0;

    /// The default view, from farther away the larger a pot is than the one that it is made for.
    #[must_use]
    pub fn on(pot: &Pot) -> Self {
        let surface = &pot.surfaces()[0];
        let widest_m = surface.radii_m().iter().copied().fold(0.0, f32::max);
        let larger = (surface.height_m() / 0.2).max(widest_m / 0.1);
        let view = Self::default();
        Self { distance_m: view.distance_m * larger, target_m: Vec3::Z * (0.45 * surface.height_m()), ..view }
    }

    /// Turns the view by so many pixels of a pointer's way, as if it held the room.
    pub fn turn(&mut self, by: Vec2) {
        let by_rad = by * Self::TURN_RAD;
        self.azimuth_rad -= by_rad.x;
        self.elevation_rad = (self.elevation_rad + by_rad.y).clamp(Self::BELOW_RAD, Self::ABOVE_RAD);
    }

    fn backwards(&self) -> Vec3 {
        let elevation = self.elevation_rad.clamp(-Self::ELEVATION_MAX_RAD, Self::ELEVATION_MAX_RAD);
        let (rise, along) = elevation.sin_cos();
        let (y, x) = self.azimuth_rad.sin_cos();
        Vec3::new(along * x, along * y, rise)
    }

    /// Where the camera stands, m.
    #[must_use]
    pub fn eye_m(&self) -> Vec3 {
        self.target_m + self.backwards() * self.distance_m.max(Self::DISTANCE_MIN_M)
    }

    /// Half the height of the picture at distance 1.
    #[must_use]
    pub fn half_height(&self, aspect: f32) -> f32 {
        let half = (0.5 * self.view_angle_rad.clamp(0.05, 2.5)).tan();
        half * (Self::ASPECT_MIN / aspect).max(1.0)
    }

    /// The matrix from the room to clip space (x right, y up, depth 0 to 1) for a picture of width over height
    /// `aspect`.
    #[must_use]
    pub fn view_projection(&self, aspect: f32) -> Mat4 {
        let angle = 2.0 * self.half_height(aspect).atan();
        let projection = rh::proj::directx::perspective(angle, aspect, Self::NEAR_M, Self::FAR_M);
        // a shift of the finished picture: the perspective stays that of the middle
        let aside = Mat4::from_translation(Vec3::X * self.aside_ndc);
        aside * projection * rh::view::look_at_mat4(self.eye_m(), self.target_m, Vec3::Z)
    }

    /// The ray through a point of the picture: where it starts (the camera, m) and its direction of length one.
    ///
    /// `ndc` runs from −1 to 1, x to the right and y upwards.
    #[must_use]
    pub fn ray(&self, ndc: Vec2, aspect: f32) -> (Vec3, Vec3) {
        let forwards = -self.backwards();
        let right = forwards.cross(Vec3::Z).normalize();
        let up = right.cross(forwards);
        let half = self.half_height(aspect);
        let direction = forwards + right * ((ndc.x - self.aside_ndc) * half * aspect) + up * (ndc.y * half);
        (self.eye_m(), direction.normalize())
    }

    /// Where a point of the room is shown (x right, y up, −1 to 1), unless it lies behind the camera.
    #[must_use]
    pub fn ndc(&self, point_m: Vec3, aspect: f32) -> Option<Vec2> {
        let clip: Vec4 = self.view_projection(aspect) * point_m.extend(1.0);
        (clip.w > Self::NEAR_M).then(|| Vec2::new(clip.x, clip.y) / clip.w)
    }
}
