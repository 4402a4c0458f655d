//! How many wheels share a window, and what stands under each.
//!
//! Owns the grid of parts; draws no clay.
//! Invariant: the parts do not overlap, and a click in one means its wheel.

use egui::text::LayoutJob;
use egui::{Align, FontId, Rect, Sense, pos2, vec2};
use glam::Vec2;

/// Width over height that suits a wheel.
const ASPECT: f32 = 1.25;
/// Largest letters under a wheel, points, and the least share of a part's height that they are.
const LETTERS: f32 = 15.0;

/// Equal parts of a window, row by row from the top left.
#[derive(Clone, Copy, Debug)]
pub(super) struct Tiles {
    columns: usize,
    rows: usize,
    count: usize,
}

impl Tiles {
    /// The grid for so many wheels in a window of that width over height: the one whose parts hold the largest wheels.
    pub(super) fn of(count: usize, aspect: f32) -> Self {
        let count = count.max(1);
        let largest = |columns: &usize| {
            let rows = count.div_ceil(*columns);
            let (width, height) = (aspect / *columns as f32, 1.0 / rows as f32);
            width.min(ASPECT * height)
        };
        let columns = (1..=count).max_by(|one, other| largest(one).total_cmp(&largest(other))).unwrap_or(1);
        Self { columns, rows: count.div_ceil(columns), count }
    }

    /// Middle and half the size of a part, −1 to 1, y upwards.
    pub(super) fn place(&self, number: usize) -> (Vec2, Vec2) {
        let half = Vec2::new(1.0 / self.columns as f32, 1.0 / self.rows as f32);
        let (column, row) = ((number % self.columns) as f32, (number / self.columns) as f32);
        (Vec2::new(-1.0 + half.x * (2.0 * column + 1.0), 1.0 - half.y * (2.0 * row + 1.0)), half)
    }

    /// Lays a button over every part, with what is said of it at the foot, lines apart, and paints over it; the one that was pressed.
    pub(super) fn show(
        &self,
        context: &egui::Context,
        said: impl Fn(usize) -> String,
        paint: impl Fn(usize, &egui::Painter, Rect),
    ) -> Option<usize> {
        let window = context.content_rect();
        let size = vec2(window.width() / self.columns as f32, window.height() / self.rows as f32);
        let letters = LETTERS.min(0.12 * size.y);
        let mut pressed = None;
        egui::Area::new(egui::Id::unique("wheels")).fixed_pos(window.min).show(context, |ui| {
            for number in 0..self.count {
                let at = vec2((number % self.columns) as f32, (number / self.columns) as f32);
                let part = Rect::from_min_size(window.min + at * size, size).shrink(2.0);
                let response = ui.interact(part, ui.scope_id().with(number), Sense::click());
                let said = said(number);
                response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Button, true, said.replace('\n', ": ")));
                let is_met = response.hovered() || response.has_focus();
                let visuals = ui.visuals();
                let colour = if is_met { visuals.strong_text_color() } else { egui::Color32::from_gray(190) };
                if is_met {
                    let stroke = egui::Stroke::new(1.5, visuals.selection.bg_fill);
                    ui.painter().rect_stroke(part, 6.0, stroke, egui::StrokeKind::Inside);
                }
                let mut job = LayoutJob::simple(said, FontId::proportional(letters), colour, part.width() - 8.0);
                job.halign = Align::Center;
                let words = ui.painter().layout_job(job);
                let top = pos2(part.center().x, part.max.y - 4.0 - words.size().y);
                ui.painter().galley(top, words, colour);
                paint(number, ui.painter(), part);
                if response.clicked() {
                    pressed = Some(number);
                }
            }
        });
        pressed
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_cover_the_window_once_and_are_nearly_as_wide_as_a_wheel() {
        for count in 1..=60 {
            for aspect in [0.6, 1.0, 1.6, 3.0] {
                let tiles = Tiles::of(count, aspect);
                assert!(tiles.columns * tiles.rows >= count && (tiles.rows - 1) * tiles.columns < count, "{tiles:?}");
                for number in 0..count {
                    let (middle, half) = tiles.place(number);
                    assert!((middle.abs() + half).max_element() < 1.0 + 1e-5, "{count}: {middle} {half}");
                }
                for (one, other) in (1..count).map(|number| (tiles.place(number - 1), tiles.place(number))) {
                    let apart = (one.0 - other.0).abs();
                    assert!(apart.x > 1.99 * one.1.x || apart.y > 1.99 * one.1.y);
                }
            }
        }
        assert_eq!((Tiles::of(12, 1.6).columns, Tiles::of(12, 1.6).rows), (4, 3));
        assert_eq!((Tiles::of(1, 1.6).columns, Tiles::of(0, 1.6).rows), (1, 1));
    }
}
