//! From pointer and buttons to where the tool should be.
//!
//! Pure: knows no window and no time but what it is told. The tool moves on the plane through the wheel's axis that faces
//! the viewer, in front of the clay, and is pushed towards the plane.
//! Invariant: a tool that is not pushed does not touch the clay that was there when it was last free.

use glam::{Vec2, Vec3};
use pottery_client::render::Camera;
use pottery_shared::clay::Pot;

use super::holding::Reach;

/// Gap between a free tool and the clay, m.
const GAP_M: f32 = 0.004;
/// How fast the button pushes in and lets out, m/s.
const PUSH_M_S: f32 = 0.015;
const RELEASE_M_S: f32 = 0.12;
/// How deep the button pushes, m.
const BUTTON_DEPTH_M: f32 = 0.006;
/// Farthest to the side of the axis that the tool follows, m.
const SIDE_MAX_M: f32 = 0.3;
/// Deepest push, m.
const PUSHED_MAX_M: f32 = 0.04;

/// How the tool is held.
#[derive(Debug)]
pub(super) struct Hand {
    /// Where the pointer is in the picture, −1 to 1.
    pointer: Option<Vec2>,
    button: bool,
    /// What the button pushes at the moment, m.
    by_button_m: f32,
    /// What was set by wheel or key, m.
    by_wheel_m: f32,
    /// Widest radius of each row when the tool was last free, m.
    outline_m: Vec<f32>,
    row_height_m: f32,
}

impl Hand {
    pub(super) fn new(pot: &Pot) -> Self {
        let mut hand = Self {
            pointer: None,
            button: false,
            by_button_m: 0.0,
            by_wheel_m: 0.0,
            outline_m: Vec::new(),
            row_height_m: 1.0,
        };
        hand.look_at(pot);
        hand
    }

    pub(super) const fn point_to(&mut self, pointer: Option<Vec2>) {
        self.pointer = pointer;
    }

    pub(super) const fn press_button(&mut self, pressed: bool) {
        self.button = pressed;
    }

    /// Pushes in by so much more, or less.
    pub(super) fn push(&mut self, by_m: f32) {
        self.by_wheel_m = (self.by_wheel_m + by_m).clamp(0.0, PUSHED_MAX_M);
    }

    /// How deep the tool is pushed beyond the surface of the free clay, m.
    pub(super) fn pushed_m(&self) -> f32 {
        let pushed_m = self.by_button_m.max(self.by_wheel_m);
        if pushed_m > 0.0 { pushed_m - GAP_M } else { 0.0 }
    }

    /// Whether the clay's outline may be taken anew.
    pub(super) fn is_free(&self) -> bool {
        self.by_button_m <= 0.0 && self.by_wheel_m <= 0.0
    }

    /// Takes the widest outline of the pot.
    pub(super) fn look_at(&mut self, pot: &Pot) {
        let surface = &pot.surfaces()[pot.skins()[0].surface];
        self.row_height_m = surface.row_height_m();
        self.outline_m.clear();
        self.outline_m.resize(surface.shape().rows() as usize, 0.0);
        for column in surface.radii_m().chunks_exact(surface.shape().rows() as usize) {
            for (widest, &radius) in self.outline_m.iter_mut().zip(column) {
                *widest = widest.max(radius);
            }
        }
    }

    /// Lets `seconds` pass.
    pub(super) fn pass(&mut self, seconds: f32) {
        if self.button {
            // the gap costs no time
            self.by_button_m = (self.by_button_m.max(GAP_M) + PUSH_M_S * seconds).min(GAP_M + BUTTON_DEPTH_M);
        } else {
            self.by_button_m = (self.by_button_m - RELEASE_M_S * seconds).max(0.0);
        }
    }

    /// Where a tool of that reach should be, m; `None` while the pointer is not over the wheel.
    pub(super) fn target_m(&self, camera: &Camera, aspect: f32, reach: &Reach) -> Option<Vec3> {
        let (eye, direction) = camera.ray(self.pointer?, aspect);
        let towards = (eye - camera.target_m).with_z(0.0).normalize_or(Vec3::X);
        let aside = towards.cross(Vec3::Z);
        let slope = direction.dot(towards);
        if slope > -1e-3 {
            return None;
        }
        // The free tool is drawn under the pointer: the plane on which the ray is met stands before the axis by as much
        // as the tool does, which depends on where the ray meets it; it settles in a few turns.
        let mut before_m = 0.0;
        let (mut along, mut height, mut free_m) = (0.0, 0.0, 0.0);
        for _ in 0..4 {
            let at = eye + direction * ((before_m - eye.dot(towards)) / slope);
            along = at.dot(aside);
            height = at.z.clamp(reach.lowest_m, self.height_m() + reach.over_rim_m);
            free_m = self.widest_m(height - reach.below_m, height + reach.above_m) + reach.inwards_m + GAP_M;
            before_m = in_front_m(free_m, along);
        }
        if along.abs() > SIDE_MAX_M {
            return None;
        }
        let pushed_m = self.by_button_m.max(self.by_wheel_m);
        let distance_m = (free_m - pushed_m).max(0.0);
        if along.abs() < free_m {
            // pushed towards the axis
            let share = distance_m / free_m;
            Some((aside * along + towards * before_m) * share + Vec3::Z * height)
        } else {
            let along = along.signum() * (along.abs() - pushed_m).max(0.0);
            Some(aside * along + Vec3::Z * height)
        }
    }

    fn height_m(&self) -> f32 {
        self.row_height_m * (self.outline_m.len() - 1) as f32
    }

    /// Widest radius between two heights.
    fn widest_m(&self, from_m: f32, to_m: f32) -> f32 {
        let row = |z_m: f32| (z_m / self.row_height_m).clamp(0.0, (self.outline_m.len() - 1) as f32) as usize;
        let rows = row(from_m)..=row(to_m);
        self.outline_m[rows].iter().copied().fold(0.0, f32::max)
    }
}

/// How far in front of the plane through the axis a point of the circle of `radius_m` round the axis stands.
fn in_front_m(radius_m: f32, along_m: f32) -> f32 {
    (radius_m * radius_m - along_m * along_m).max(0.0).sqrt()
}
