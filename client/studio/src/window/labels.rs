//! Names beside the tools of other people.
//!
//! Owns where they stand over the picture; who is who is the panel's to say.
//! Invariant: a name stands beside its own tool, and no click or screen reader meets it twice.

use egui::{Align2, Color32, FontId, LayerId, Order, Pos2, Vec2};
use glam::Vec3;
use pottery_client::render::{Camera, ToolView};

use super::panel::{Person, colour_of};
use crate::words::Words;

/// From the tool's middle to its name, m, and the size of the letters, points.
const ASIDE_M: f32 = 0.016;
const LETTERS: f32 = 13.0;

/// Writes the names; `people` and `tools` are those of everybody else, in the same order.
pub(super) fn show(context: &egui::Context, words: &Words, camera: &Camera, people: &[Person], tools: &[ToolView]) {
    let window = context.content_rect();
    let aspect = window.width() / window.height().max(1.0);
    let painter = context.layer_painter(LayerId::new(Order::Background, egui::Id::unique("names")));
    for (person, tool) in people.iter().zip(tools) {
        let Some(at) = camera.ndc(tool.centre_m + Vec3::Z * ASIDE_M, aspect) else { continue };
        let share = Vec2::new(0.5 + 0.5 * at.x, 0.5 - 0.5 * at.y);
        let place = window.min + share * window.size();
        let (name, font) = (person.name(words), FontId::proportional(LETTERS));
        let write = |at: Pos2, colour| painter.text(at, Align2::CENTER_BOTTOM, &name, font.clone(), colour);
        write(place + Vec2::splat(1.0), Color32::from_black_alpha(200));
        // a person's colour may be as dark as the shadow
        write(place, colour_of(person.colour).lerp_to_gamma(Color32::WHITE, 0.45));
    }
}
