//! What a tool meets on its way and where it stands, without pressing anything.
//!
//! Owns the quick looks at the clay that a tick of the hand takes beside its press.
//! Invariant: the clay stays as it is, and a look visits no more than the columns under the tool.

use glam::Vec3;

use crate::clay::{Pot, Surface};
use crate::tool::Side;

/// Difference of radii that is none, m: the quantum of the snapshots.
const QUANTUM_M: f32 = 4e-6;

/// A straight way of a sphere, in the pot's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct Way {
    pub(super) from_m: Vec3,
    pub(super) to_m: Vec3,
    pub(super) radius_m: f32,
    pub(super) side: Side,
}

/// Shorter ways are not looked at: 20 mm/s.
const SHORT_M: f32 = 0.02e-3;
/// How well the surface is found, and how far behind it the tool is stopped: farther than a place is rounded by, or the tool would
/// stand before the clay and feel a wall that it does not press.
const FOUND_M: f32 = 0.01e-3;
const BEHIND_M: f32 = 0.015e-3;
/// Most looks.
const LOOKS_MAX: f32 = 16.0;
/// How far a tool of facets goes between two looks, m: half a millimetre lies between two columns or rows of a usual pot.
pub(super) const FACETS_LOOK_M: f32 = 0.5e-3;

/// Share of a way of such a length, m, after which a tool first `touches` clay, 1 when it does not, or began in it.
///
/// Looked for in steps of `look_m` and then by halves, so that the tool stops 15 to 25 µm behind the surface.
pub(super) fn free_share(length_m: f32, look_m: f32, mut touches: impl FnMut(f32) -> bool) -> f32 {
    if length_m < SHORT_M || touches(0.0) {
        return 1.0;
    }
    let looks = libm::ceilf(length_m / look_m).clamp(1.0, LOOKS_MAX) as u32;
    let Some(met) = (1..=looks).find(|&look| touches(look as f32 / looks as f32)) else { return 1.0 };
    let (mut free, mut met) = ((met - 1) as f32 / looks as f32, met as f32 / looks as f32);
    while (met - free) * length_m > FOUND_M {
        let middle = 0.5 * (free + met);
        *if touches(middle) { &mut met } else { &mut free } = middle;
    }
    (met + BEHIND_M / length_m).min(1.0)
}

impl Way {
    /// [`free_share`] of it, with six looks a radius.
    pub(super) fn free_share(&self, pot: &Pot) -> f32 {
        free_share(self.from_m.distance(self.to_m), self.radius_m / 6.0, |share| self.touches(pot, share))
    }

    /// Whether the sphere touches the clay of the column that it stands before, as a press would find it.
    fn touches(&self, pot: &Pot, share: f32) -> bool {
        let centre_m = self.from_m.lerp(self.to_m, share);
        let surface = pot.met_from(self.side);
        let column = column_before(surface, centre_m);
        let [cos, sin] = surface.direction(column);
        let (along_m, aside_m) = (centre_m.x * cos + centre_m.y * sin, centre_m.y * cos - centre_m.x * sin);
        let reach_m2 = self.radius_m * self.radius_m - aside_m * aside_m;
        rows_beside(surface, centre_m.z, self.radius_m).any(|row| {
            let above_m = surface.row_z_m(row) - centre_m.z;
            let half_m2 = reach_m2 - above_m * above_m;
            let clay_m = surface.column_m(column)[row as usize] - surface.inset_m(self.side);
            let half_m = libm::sqrtf(half_m2.max(0.0));
            half_m2 > 0.0
                && match self.side {
                    Side::Outside => along_m - half_m < clay_m,
                    Side::Inside => along_m + half_m > clay_m,
                }
        })
    }
}

/// Area of an element where a sphere outside or inside of a wall touches it, m².
pub(super) fn element_m2(surface: &Surface, centre_m: Vec3, radius_m: f32, side: Side) -> f32 {
    let distance_m = libm::hypotf(centre_m.x, centre_m.y);
    let met_m = match side {
        Side::Outside => distance_m - radius_m,
        Side::Inside => distance_m + radius_m,
    };
    surface.shape().column_angle_rad() * met_m.max(0.0) * surface.row_height_m()
}

/// Whether two pots of one shape differ in the clay under a sphere.
pub(super) fn differs(one: &Pot, other: &Pot, centre_m: Vec3, radius_m: f32) -> bool {
    let reach_rad = radius_m / libm::hypotf(centre_m.x, centre_m.y).max(radius_m);
    one.surfaces().iter().zip(other.surfaces()).any(|(one, other)| {
        let half = libm::ceilf(reach_rad / one.shape().column_angle_rad()) as i64;
        let middle = i64::from(column_before(one, centre_m));
        (-half..=half).any(|away| {
            let column = one.shape().wrap(middle + away);
            rows_beside(one, centre_m.z, radius_m).any(|row| {
                let [one_m, other_m] = [one, other].map(|surface| surface.column_m(column)[row as usize]);
                (one_m - other_m).abs() > QUANTUM_M
            })
        })
    })
}

fn column_before(surface: &Surface, centre_m: Vec3) -> u32 {
    let angle_rad = libm::atan2f(centre_m.y, centre_m.x);
    surface.shape().wrap(libm::roundf(angle_rad / surface.shape().column_angle_rad()) as i64)
}

/// The rows within a sphere's reach, as a press finds them.
fn rows_beside(surface: &Surface, centre_z_m: f32, radius_m: f32) -> core::ops::Range<u32> {
    let (row_m, rows) = (surface.row_height_m(), surface.shape().rows() as f32);
    let first = libm::ceilf((centre_z_m - radius_m) / row_m).clamp(0.0, rows);
    let last = libm::floorf((centre_z_m + radius_m) / row_m).clamp(-1.0, rows - 1.0);
    first as u32..(last + 1.0) as u32
}
