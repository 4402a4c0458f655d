//! A pot's profile over the one that it is to become, in a picture of any size.
//!
//! Owns colours and scale; who is compared with what is others' affair.
//! Invariant: both profiles stand on the same foot, in one scale, within the picture.

use egui::{Color32, Painter, Rect, Stroke, pos2};
use pottery_shared::clay::Target;

/// The deviation that is drawn darkest, m.
const FAR_M: f32 = 0.005;
/// Height of a picture with lines of full width, points.
const FULL: f32 = 130.0;

/// Paints both: what is wanted in dashes, what is there from green to red, as far as it is off.
pub(in crate::window) fn paint(painter: &Painter, within: Rect, target: &Target, is: &Target) {
    let widest_m = target.radii_m().iter().chain(is.radii_m()).copied().fold(0.0, f32::max);
    let tallest_m = target.height_m().max(is.height_m());
    let scale = (within.height() / tallest_m).min(0.5 * within.width() / widest_m) * 0.95;
    let foot = within.center_bottom();
    let outline = |profile: &Target, sign: f32| {
        let step_m = profile.height_m() / (Target::POINTS - 1) as f32;
        let places = profile.radii_m().iter().enumerate();
        places
            .map(|(row, radius_m)| pos2(foot.x + sign * radius_m * scale, foot.y - row as f32 * step_m * scale))
            .collect::<Vec<_>>()
    };
    let thick = (within.height() / FULL).clamp(0.5, 1.0);
    for sign in [-1.0, 1.0] {
        let dashes = Stroke::new(1.5 * thick, Color32::GRAY);
        painter.extend(egui::Shape::dashed_line(&outline(target, sign), dashes, 5.0 * thick, 3.0 * thick));
        let own = outline(is, sign);
        let step_m = is.height_m() / (Target::POINTS - 1) as f32;
        for (row, ends) in own.windows(2).enumerate() {
            let off_m =
                target.radius_m(row as f32 * step_m).map_or(FAR_M, |wanted_m| (is.radii_m()[row] - wanted_m).abs());
            let colour = Color32::from_rgb(0x30, 0xa0, 0x60)
                .lerp_to_gamma(Color32::from_rgb(0xd0, 0x30, 0x30), (off_m / FAR_M).min(1.0));
            painter.line_segment([ends[0], ends[1]], Stroke::new(2.5 * thick, colour));
        }
    }
}
