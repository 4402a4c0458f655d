//! The controls of the clay: presets, one control of wetness, and what the pot is shown as.
//!
//! Owns their layout alone.
//! Invariant: what somebody else set is shown and not asked for anew.

use egui::RichText;
use pottery_client::render::Finish;
use pottery_shared::clay::{Material, Preset, Wetness};

use super::{WETNESS, WETNESS_STEP};
use crate::words::Words;

/// A preset's button is lit this near to it: as far as the slider shows.
const PRESET_WITHIN: f32 = 0.005;

/// Presets, one control of wetness, the sponge, whether the clay dries, and what it then is.
pub(super) fn show(ui: &mut egui::Ui, words: &Words, wetness: &mut f32, dries: &mut Option<bool>) {
    ui.horizontal(|ui| {
        for preset in Preset::ALL {
            let index = preset.wetness().liquidity_index();
            let name = words.say(&format!("clay-{}", preset.name()));
            if ui.selectable_label((*wetness - index).abs() < PRESET_WITHIN, name).clicked() {
                *wetness = index;
            }
        }
    });
    // shown to two decimals and not rounded to them, or what somebody else set would be asked for anew
    let slider = egui::Slider::new(wetness, WETNESS.0..=WETNESS.1)
        .custom_formatter(|value, _| words.number(value, 2))
        .custom_parser(Words::parse);
    ui.add(slider.text(words.say("wetness")));
    ui.horizontal(|ui| {
        if ui.button(words.say("sponge")).on_hover_text(words.say("sponge-hint")).clicked() {
            *wetness = (*wetness + WETNESS_STEP).min(WETNESS.1);
        }
        if let Some(dries) = dries {
            ui.checkbox(dries, words.say("dries")).on_hover_text(words.say("dries-hint"));
        }
    });
    let material = Material::from_wetness(Wetness::nearest(*wetness));
    let figures = words.say_with(
        "clay-figures",
        &[
            ("yield", &words.number(f64::from(material.strength.yield_pa) * 1e-3, 0)),
            ("youngs", &words.number(f64::from(material.strength.youngs_pa) * 1e-6, 2)),
            ("time", &words.number(f64::from(material.viscosity.0) * 1e3, 0)),
        ],
    );
    ui.label(RichText::new(figures).small());
}

/// What the pot is shown as.
pub(super) fn show_finish(ui: &mut egui::Ui, words: &Words, finish: &mut Finish) {
    let called = |finish: Finish| words.say(&format!("finish-{}", finish.name()));
    ui.horizontal(|ui| {
        egui::ComboBox::from_id_salt("finish").selected_text(called(*finish)).width(130.0).show_ui(ui, |ui| {
            for other in Finish::ALL {
                ui.selectable_value(finish, other, called(other));
            }
        });
        ui.label(words.say("finish"));
    });
}
