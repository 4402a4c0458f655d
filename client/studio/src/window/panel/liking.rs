//! The controls of what a person likes: language, look, size of the text, the lesson.
//!
//! Owns their layout; what is kept of it is the window's.
//! Invariant: what is chosen is seen at once.

use super::PanelState;
use crate::preferences::{TEXT_PERCENT, Theme};
use crate::window::lesson::Lesson;
use crate::words::{Language, Words};

/// What a button makes text larger or smaller by, %.
const TEXT_STEP: u16 = 10;

/// Lays the controls out, folded until they are wanted.
pub(super) fn show(ui: &mut egui::Ui, state: &mut PanelState) {
    let title = state.words.say("preferences");
    egui::CollapsingHeader::new(title).id_salt("preferences").show(ui, |ui| {
        let mut language = state.words.language();
        ui.horizontal(|ui| {
            egui::ComboBox::from_id_salt("language").selected_text(language.name()).width(100.0).show_ui(ui, |ui| {
                for other in Language::ALL {
                    ui.selectable_value(&mut language, other, other.name());
                }
            });
            ui.label(state.words.say("language"));
        });
        if language != state.words.language() {
            state.words = Words::new(language);
            state.liking.language = Some(language);
        }
        let words = &state.words;
        ui.horizontal(|ui| {
            let themes = [(Theme::Dark, "theme-dark"), (Theme::Light, "theme-light"), (Theme::System, "theme-system")];
            for (theme, name) in themes {
                ui.selectable_value(&mut state.liking.theme, theme, words.say(name));
            }
        });
        ui.horizontal(|ui| {
            let percent = &mut state.liking.text_percent;
            if ui.button("−").clicked() {
                *percent = percent.saturating_sub(TEXT_STEP).max(TEXT_PERCENT.0);
            }
            ui.label(percent.to_string());
            if ui.button("+").clicked() {
                *percent = (*percent + TEXT_STEP).min(TEXT_PERCENT.1);
            }
            ui.label(words.say("text-size"));
        });
        if ui.button(words.say("lesson-again")).clicked() {
            state.lesson = Some(Lesson::default());
        }
    });
}
