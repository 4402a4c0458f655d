//! The table of keys.
//!
//! Owns what is said of them; what they do is the window's.
//! Invariant: every key that the window takes stands here.

use egui::{Align2, Grid, Label, RichText, ScrollArea, vec2};

use crate::words::Words;

/// How a key is written, as it is or by the message of that name, and the message of what it does.
const KEYS: [(&str, &str); 27] = [
    ("Enter", "key-force"),
    ("press-left", "key-press"),
    ("press-wheel", "key-push"),
    ("press-move", "key-move"),
    ("I", "key-side"),
    ("press-right", "key-view"),
    ("press-zoom", "key-zoom"),
    ("press-arrows", "key-wheel"),
    ("T", "key-tool"),
    ("+ -", "key-size"),
    ("Q E", "key-turn"),
    ("press-roll", "key-roll"),
    ("press-lean", "key-lean"),
    ("V B", "key-clay"),
    ("C", "key-middle"),
    ("M", "key-sound"),
    ("R, 1, 2, 3", "key-views"),
    ("K", "key-cut"),
    ("L", "key-finish"),
    ("J", "key-take-over"),
    ("N", "key-guide"),
    ("U, Y", "key-record"),
    ("Ctrl + Z, Ctrl + Y", "key-undo"),
    ("Ctrl + N", "key-new"),
    ("Ctrl + S, Ctrl + O, Ctrl + E", "key-files"),
    ("P", "key-panel"),
    ("H, Esc", "key-help"),
];

/// Shows the table.
pub(super) fn show(context: &egui::Context, words: &Words) {
    let window = egui::Window::new(words.say("keys")).id(egui::Id::unique("keys"));
    window.anchor(Align2::RIGHT_TOP, [-12.0, 12.0]).resizable(false).show(context, |ui| {
        // below the title, above the line at the window's lower edge, and as far from its sides as it stands
        let room = (context.content_rect().size() - vec2(48.0, 84.0)).max(vec2(1.0, 1.0));
        let area = ScrollArea::vertical().max_width(room.x).max_height(room.y);
        area.min_scrolled_height(room.y).show(ui, |ui| {
            // two columns, and a bar beside them
            Grid::new("table").max_col_width(0.5 * (room.x - 24.0)).show(ui, |ui| {
                for (key, effect) in KEYS {
                    let key = if key.starts_with("press-") { words.say(key) } else { words.keys(key) };
                    ui.add(Label::new(RichText::new(key).monospace()).wrap());
                    ui.add(Label::new(words.say(effect)).wrap());
                    ui.end_row();
                }
            });
        });
    });
}
