//! From one hand to another round the wheel's axis: a straight way between two tools outside of a pot would go through it.
//!
//! Owns the geometry; knows no pot.
//! Invariant: near the axis, where there is no way round it, everything is straight.

use glam::{Vec2, Vec3, Vec3Swizzles};

/// Nearer to the axis than this there is no way round it, m.
const NEAR_M: f32 = 0.01;

/// The student's device and the teacher's tool, room's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Around {
    pub(super) from_m: Vec3,
    pub(super) to_m: Vec3,
}

/// Both in the wheel's own coordinates.
struct Polar {
    /// Direction of the first from the axis.
    out: Vec2,
    from_m: f32,
    to_m: f32,
    /// From the first to the second, the shorter way, rad.
    angle: f32,
}

impl Around {
    fn polar(&self) -> Option<Polar> {
        let (from, to) = (self.from_m.xy(), self.to_m.xy());
        let (from_m, to_m) = (from.length(), to.length());
        let angle = libm::atan2f(from.perp_dot(to), from.dot(to));
        (from_m.min(to_m) > NEAR_M).then(|| Polar { out: from / from_m, from_m, to_m, angle })
    }

    /// The place a share of the way from the first to the second, m: radius, angle and height each by that share.
    pub(super) fn between(&self, share: f32) -> Vec3 {
        let Some(Polar { out, from_m, to_m, angle }) = self.polar() else {
            return self.from_m.lerp(self.to_m, share);
        };
        let radius_m = from_m + (to_m - from_m) * share;
        let there = turned(out, angle * share) * radius_m;
        there.extend(self.from_m.z + (self.to_m.z - self.from_m.z) * share)
    }

    /// From the first to the second, m: outwards, along the circle on which the first stands, and upwards.
    pub(super) fn error_m(&self) -> Vec3 {
        let Some(Polar { out, from_m, to_m, angle }) = self.polar() else { return self.to_m - self.from_m };
        let flat = out * (to_m - from_m) + out.perp() * (from_m * angle);
        flat.extend(self.to_m.z - self.from_m.z)
    }

    /// What the first hand feels of a force at the place between, N: the force that does the same work when the first moves,
    /// `F = Jᵀ·f` with J the derivative of [`Around::between`] by the first place.
    pub(super) fn felt(&self, force_n: Vec3, share: f32) -> Vec3 {
        let left = 1.0 - share;
        let Some(Polar { out, from_m, to_m, angle }) = self.polar() else { return force_n * left };
        let there = turned(out, angle * share);
        let (outwards_n, along_n) = (force_n.xy().dot(there), force_n.xy().dot(there.perp()));
        let radius_m = from_m + (to_m - from_m) * share;
        let flat = out * outwards_n + out.perp() * (along_n * (radius_m / from_m).min(2.0));
        flat.extend(force_n.z) * left
    }
}

fn turned(direction: Vec2, angle: f32) -> Vec2 {
    let (sin, cos) = libm::sincosf(angle);
    Vec2::new(cos, sin).rotate(direction)
}
