//! The controls of the tool: which one, its size or how it is turned, and the side of the wall.
//!
//! Owns their layout alone.
//! Invariant: what is offered is what hangs in the rack.

use pottery_shared::tool::{Shape, Side};

use super::PanelState;
use crate::window::holding::{ANGLES, TOOL_MM};
use crate::words::Words;

/// What a tool is called.
fn called(words: &Words, shape: Option<Shape>) -> String {
    match shape.map(|shape| (shape, shape.name())) {
        None => words.say("sphere"),
        Some((_, Some(name))) => words.say(&format!("tool-{name}")),
        Some((shape, None)) => words.say_with("tool-numbered", &[("number", &shape.0.to_string())]),
    }
}

/// Which tool is held, and its size or how it is turned.
pub(super) fn show(ui: &mut egui::Ui, state: &mut PanelState) {
    let (words, holding) = (&state.words, &mut state.holding);
    ui.horizontal(|ui| {
        let chosen = egui::ComboBox::from_id_salt("tool").selected_text(called(words, holding.shape)).width(100.0);
        chosen.show_ui(ui, |ui| {
            for shape in std::iter::once(None).chain((0..state.rack).map(|number| Some(Shape(number as u8)))) {
                ui.selectable_value(&mut holding.shape, shape, called(words, shape));
            }
        });
        if holding.shape.is_none() {
            let radius = egui::DragValue::new(&mut holding.sphere_mm).range(TOOL_MM.0..=TOOL_MM.1).speed(0.1);
            let radius = radius.custom_formatter(|value, _| words.number(value, 1)).custom_parser(Words::parse);
            ui.add(radius.prefix(format!("{} ", words.say("radius"))).suffix(" mm"));
        }
    });
    if holding.shape.is_some() {
        ui.horizontal(|ui| {
            for (angle_deg, (name, most_deg)) in holding.angles_deg.iter_mut().zip(ANGLES) {
                let angle = egui::DragValue::new(angle_deg).range(-most_deg..=most_deg).max_decimals(0);
                ui.add(angle.prefix(format!("{} ", words.say(name))).suffix("°"));
            }
        });
    }
    ui.horizontal(|ui| {
        for (side, name) in [(Side::Outside, "side-outside"), (Side::Inside, "side-inside")] {
            let is_chosen = state.side == side;
            state.changes_side |= ui.selectable_label(is_chosen, words.say(name)).clicked() && !is_chosen;
        }
    });
}
