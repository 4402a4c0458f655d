//! What a teacher shows over the picture: lines drawn on the pot, and the pot that it is to become.
//!
//! Owns how they are painted; what was drawn and what is wanted are the potter's view's.
//! Invariant: what is on the far side of a pot is not painted over its near side.

use egui::{Color32, LayerId, Order, Painter, Pos2, Rect, Shape, Stroke, Vec2};
use glam::Vec3;
use pottery_client::guiding::{GuidanceShown, LinePlace};
use pottery_client::render::Camera;
use pottery_shared::clay::{Phase, Pot, Target};
use pottery_shared::tool::Side;

/// How far over the clay lines are painted, m.
const OVER_M: f32 = 0.0005;
/// Rings of a pot that is wanted, and points of a ring.
const RINGS: usize = 9;
const RING_POINTS: usize = 48;
/// Every how manieth point of a profile is painted.
const PROFILE_STEP: usize = 2;
const LINE: Color32 = Color32::from_rgb(0xff, 0xd8, 0x40);
const WANTED: Color32 = Color32::from_rgba_premultiplied(0x50, 0xa8, 0xc8, 0xb0);

/// Where the room is seen.
struct Sight<'a> {
    camera: &'a Camera,
    window: Rect,
}

impl Sight<'_> {
    fn place(&self, point_m: Vec3) -> Option<Pos2> {
        let size = self.window.size();
        let at = self.camera.ndc(point_m, size.x / size.y.max(1.0))?;
        Some(self.window.min + Vec2::new(0.5 + 0.5 * at.x, 0.5 - 0.5 * at.y) * size)
    }

    /// Whether a point of an upright wall that looks away from the axis is turned to the camera.
    fn is_near_side(&self, point_m: Vec3) -> bool {
        (self.camera.eye_m() - point_m).dot(point_m.with_z(0.0)) > 0.0
    }

    /// Whether a point of the wall's inside, which looks to the axis, is seen: over a rim of that radius and height, m, or past it where
    /// the pot is shown cut open.
    fn is_seen_inside(&self, point_m: Vec3, (rim_m, height_m): (f32, f32), is_cut: bool) -> bool {
        if self.is_near_side(point_m) {
            return false;
        }
        // the way to the eye leaves the pot at |p + t·w| = r, seen from above
        let (from, way) = (point_m.truncate(), (self.camera.eye_m() - point_m).truncate());
        let (along, past) = (from.dot(way), from.length_squared() - rim_m * rim_m);
        let root = along * along - way.length_squared() * past;
        let leaves = (root.max(0.0).sqrt() - along) / way.length_squared().max(f32::MIN_POSITIVE);
        is_cut || point_m.z + leaves.clamp(0.0, 1.0) * (self.camera.eye_m().z - point_m.z) > height_m
    }

    /// Paints the parts of a line that are seen.
    fn line(&self, painter: &Painter, points_m: &[Vec3], stroke: Stroke, is_seen: impl Fn(Vec3) -> bool) {
        let mut part = Vec::new();
        for point_m in points_m {
            match self.place(*point_m).filter(|_| is_seen(*point_m)) {
                Some(place) => part.push(place),
                None => draw(painter, &mut part, stroke),
            }
        }
        draw(painter, &mut part, stroke);
    }
}

fn draw(painter: &Painter, part: &mut Vec<Pos2>, stroke: Stroke) {
    if part.len() > 1 {
        painter.add(Shape::line(std::mem::take(part), stroke));
    }
    part.clear();
}

/// Paints what the teacher drew and what the pot is to become, over the pot and under everything else.
pub(super) fn show(
    context: &egui::Context,
    camera: &Camera,
    shown: &GuidanceShown,
    (pot, phase): (&Pot, Phase),
    is_cut: bool,
) {
    let sight = Sight { camera, window: context.content_rect() };
    let painter = context.layer_painter(LayerId::new(Order::Background, egui::Id::unique("ghosts")));
    if let Some(target) = &shown.target {
        paint_target(&sight, &painter, target);
    }
    for line in shown.lines.chunk_by(|_, next| !next.begins) {
        let points_m: Vec<_> = line.iter().map(|place| on_clay_m(pot, phase, place)).collect();
        let (side, rim) = (line[0].side, inner_rim(pot));
        sight.line(&painter, &points_m, Stroke::new(3.0, LINE), |point_m| match side {
            Side::Outside => sight.is_near_side(point_m),
            Side::Inside => sight.is_seen_inside(point_m, rim, is_cut),
        });
    }
}

/// Paints the pot that is wanted and nothing else.
pub(super) fn show_target(context: &egui::Context, camera: &Camera, target: &Target) {
    let sight = Sight { camera, window: context.content_rect() };
    let painter = context.layer_painter(LayerId::new(Order::Background, egui::Id::unique("ghosts")));
    paint_target(&sight, &painter, target);
}

/// A place of a line, on the clay of the pot as it is turned, m.
fn on_clay_m(pot: &Pot, phase: Phase, place: &LinePlace) -> Vec3 {
    let [outer, inner] = pot.skins();
    // out of the clay on either side
    let (skin, over_m) = match place.side {
        Side::Outside => (outer, OVER_M),
        Side::Inside => (inner, -OVER_M),
    };
    let surface = &pot.surfaces()[skin.surface];
    let shape = surface.shape();
    let out = place.at_m.with_z(0.0).normalize_or(Vec3::X);
    let column = (out.y.atan2(out.x) / shape.column_angle_rad()).round() as i64;
    let row = (place.at_m.z / surface.row_height_m()).round().clamp(0.0, (shape.rows() - 1) as f32) as usize;
    let radius_m = (surface.column_m(shape.wrap(column))[row] - skin.inset_m + over_m).max(0.0);
    phase.room_from_pot((out * radius_m).with_z(place.at_m.z))
}

/// Radius and height of the wall's inside at the rim, m: the narrowest there, so that what is seen over it is seen whichever way it stands.
fn inner_rim(pot: &Pot) -> (f32, f32) {
    let [_, inner] = pot.skins();
    let surface = &pot.surfaces()[inner.surface];
    let shape = surface.shape();
    let last = shape.rows() as usize - 1;
    let radii_m = (0..shape.columns()).map(|column| surface.column_m(column)[last] - inner.inset_m);
    (radii_m.fold(f32::INFINITY, f32::min).max(0.0), surface.height_m())
}

/// The pot that is wanted: rings, and the outline as it is seen from here.
fn paint_target(sight: &Sight<'_>, painter: &Painter, target: &Target) {
    let height_m = target.height_m();
    let stroke = Stroke::new(1.5, WANTED);
    for ring in 0..RINGS {
        let at_m = height_m * ring as f32 / (RINGS - 1) as f32;
        let Some(radius_m) = target.radius_m(at_m) else { continue };
        let points_m: Vec<_> = (0..=RING_POINTS)
            .map(|point| {
                let (sin, cos) = (std::f32::consts::TAU * point as f32 / RING_POINTS as f32).sin_cos();
                Vec3::new(radius_m * cos, radius_m * sin, at_m)
            })
            .collect();
        // the rim is seen all round, as a look into the pot
        sight.line(painter, &points_m, stroke, |point_m| ring == RINGS - 1 || sight.is_near_side(point_m));
    }
    let towards = (sight.camera.eye_m() - sight.camera.target_m).with_z(0.0).normalize_or(Vec3::X);
    let aside = towards.cross(Vec3::Z);
    let step_m = height_m / (Target::POINTS - 1) as f32;
    for sign in [-1.0, 1.0] {
        let radii_m = target.radii_m().iter().enumerate().step_by(PROFILE_STEP);
        let points_m: Vec<_> =
            radii_m.map(|(row, radius_m)| (aside * (sign * radius_m)).with_z(row as f32 * step_m)).collect();
        sight.line(painter, &points_m, Stroke::new(2.0, WANTED), |_| true);
    }
}

#[cfg(test)]
mod tests {
    use pottery_shared::clay::PotSpec;
    use pottery_shared::units::Tick;

    use super::*;

    #[test]
    fn a_line_lies_on_the_face_on_which_it_was_drawn_and_is_seen_where_that_is() {
        let spec = PotSpec::default();
        let pot = Pot::new(spec).expect("the usual pot can be made");
        let drawn = |side, angle: f32, z_m: f32| {
            let at_m = Vec3::new(0.05 * angle.cos(), 0.05 * angle.sin(), z_m);
            on_clay_m(&pot, Phase(0), &LinePlace { at_m, side, begins: true, tick: Tick(0) })
        };
        let (outer_m, inner_m) = (spec.radius.0, spec.radius.0 - spec.wall.0);
        for (side, radius_m) in [(Side::Outside, outer_m + OVER_M), (Side::Inside, inner_m - OVER_M)] {
            let lies_m = drawn(side, 1.0, 0.1).truncate().length();
            assert!((lies_m - radius_m).abs() < 1e-5, "{side:?}: {lies_m} m, not {radius_m} m");
        }
        // from the front and above, the far side's inside right under the rim is seen, and neither the near side's nor the foot
        let camera = Camera { elevation_rad: 0.6, ..Camera::default() };
        let rim = inner_rim(&pot);
        let is_seen = |camera: &Camera, angle: f32, z_m: f32, is_cut| {
            let sight = Sight { camera, window: Rect::EVERYTHING };
            sight.is_seen_inside(drawn(Side::Inside, angle, z_m), rim, is_cut)
        };
        let (near, far) = (camera.azimuth_rad, camera.azimuth_rad + std::f32::consts::PI);
        assert!(is_seen(&camera, far, 0.98 * rim.1, false));
        assert!(!is_seen(&camera, far, 0.05 * rim.1, false) && is_seen(&camera, far, 0.05 * rim.1, true));
        assert!(!is_seen(&camera, near, 0.98 * rim.1, false) && !is_seen(&camera, near, 0.5 * rim.1, true));
        let level = Camera { elevation_rad: 0.0, ..camera };
        assert!(!is_seen(&level, far, 0.5 * rim.1, false));
    }
}
