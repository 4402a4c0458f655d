//! The card by which a person fits a device to the hand: two steps, then a look whether it suits.
//!
//! Owns words and picture; what is measured is the fitting's.
//! Invariant: it changes nothing itself but answers with what the person asked for.

use egui::{Align2, Color32, RichText, Sense, Stroke, StrokeKind, pos2, vec2};
use pottery_client::device::{Calibration, Fit, Fitting, MIDDLE_ROOM_M, REACH_ROOM_M, Step};

use crate::words::Words;

/// The part of the room that is drawn, seen from the front: its width, and its height above the wheel, m.
const SHOWN_M: [f32; 2] = [0.4, 0.24];
/// Points a metre.
const POINTS_PER_M: f32 = 700.0;
/// What the hand reaches, and its rest.
const REACHED: Color32 = Color32::from_rgb(178, 84, 46);

/// A fitting under way, and what it is shown with.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Shown {
    pub(super) fitting: Fitting,
    /// Whether the device says where it is.
    pub(super) is_there: bool,
}

/// What a person asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Answer {
    /// To begin.
    Begin,
    /// The step is done; after the last, the fit is kept.
    GoOn,
    /// Another scale.
    Scale(f32),
    /// As it was before.
    Leave,
}

impl Shown {
    /// Lays the card out.
    pub(super) fn show(self, context: &egui::Context, words: &Words) -> Option<Answer> {
        let mut answer = None;
        let fit = self.fitting.fit();
        let window = egui::Window::new(words.say("fitting")).id(egui::Id::unique("fitting")).resizable(false);
        window.anchor(Align2::RIGHT_BOTTOM, [-12.0, -64.0]).default_width(300.0).show(context, |ui| {
            ui.set_width((context.content_rect().width() - 40.0).clamp(0.0, 300.0));
            let (step, how) = match self.fitting.step() {
                Step::Rest => ("fitting-rest", "fitting-rest-how"),
                Step::Reach => ("fitting-reach", "fitting-reach-how"),
                Step::Done => ("fitting-done", "fitting-done-how"),
            };
            ui.label(RichText::new(words.say(step)).strong());
            ui.label(words.say(how));
            if self.fitting.step() == Step::Done {
                let mut scale = fit.scale;
                let range = Calibration::SCALE_MIN..=Calibration::SCALE_MAX;
                let slider = egui::Slider::new(&mut scale, range).logarithmic(true).text(words.say("fitting-scale"));
                let slider = slider.custom_formatter(|value, _| words.number(value, 2)).custom_parser(Words::parse);
                if ui.add(slider).changed() {
                    answer = Some(Answer::Scale(scale));
                }
            } else if !self.is_there {
                ui.label(words.say("fitting-nowhere"));
            }
            if self.fitting.step() != Step::Rest {
                self.draw(ui, fit, words);
            }
            ui.horizontal(|ui| {
                let done = self.fitting.step() == Step::Done;
                if ui.button(words.say(if done { "fitting-keep" } else { "fitting-go-on" })).clicked() {
                    answer = Some(Answer::GoOn);
                }
                if ui.button(words.say("fitting-leave")).clicked() {
                    answer = Some(Answer::Leave);
                }
            });
        });
        answer
    }

    /// What the hand reaches in the room, from the front, between the foot and the rim of a pot.
    fn draw(self, ui: &mut egui::Ui, fit: Fit, words: &Words) {
        let width = (SHOWN_M[0] * POINTS_PER_M).min(ui.available_width());
        let (response, painter) = ui.allocate_painter(vec2(width, SHOWN_M[1] * POINTS_PER_M), Sense::hover());
        let area = response.rect;
        let place = |x_m: f32, z_m: f32| {
            pos2(
                area.center().x + POINTS_PER_M * x_m,
                area.bottom() - POINTS_PER_M * (z_m + 0.5 * SHOWN_M[1] - REACH_ROOM_M),
            )
        };
        let line = Stroke::new(1.0, ui.visuals().weak_text_color());
        let font = egui::TextStyle::Small.resolve(ui.style());
        for (name, z_m) in [("fitting-foot", -REACH_ROOM_M), ("fitting-rim", REACH_ROOM_M)] {
            let z_m = MIDDLE_ROOM_M.z + z_m;
            let (left, right) = (place(-0.5 * SHOWN_M[0], z_m), place(0.5 * SHOWN_M[0], z_m));
            painter.line_segment([left.max(area.left_top()), right.min(area.right_bottom())], line);
            let text = words.say(name);
            painter.text(pos2(area.left(), left.y), Align2::LEFT_BOTTOM, text, font.clone(), line.color);
        }
        let [low_m, high_m] = self.fitting.reach_m().map(|corner_m| MIDDLE_ROOM_M + corner_m * fit.scale);
        let reached = egui::Rect::from_two_pos(place(low_m.x, low_m.z), place(high_m.x, high_m.z));
        painter.rect_stroke(reached.intersect(area), 2.0, Stroke::new(2.0, REACHED), StrokeKind::Inside);
        let here_m = MIDDLE_ROOM_M + self.fitting.here_m().unwrap_or_default() * fit.scale;
        painter.circle_filled(place(MIDDLE_ROOM_M.x, MIDDLE_ROOM_M.z), 2.0, line.color);
        if self.fitting.step() == Step::Reach {
            painter.circle_filled(place(here_m.x, here_m.z), 4.0, REACHED);
        }
    }
}
