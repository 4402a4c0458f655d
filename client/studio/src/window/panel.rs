//! The panel beside the pot: how to join, how the wheel and the clay are set, who is here, and the keys.
//!
//! Owns words and layout; changes nothing itself but answers with what the person asked for.
//! Invariant: every control that is shown has an effect.

use std::net::SocketAddr;

use egui::{Align2, Color32, RichText};
use pottery_shared::clay::{Material, Preset, Wetness};
use pottery_shared::protocol::JoinCode;
use pottery_shared::tool::Shape;

use super::files::Files;
use super::holding::{self, ANGLES, Holding, TOOL_MM};

/// What others type to join.
#[derive(Clone, Debug)]
pub(super) struct Invitation {
    address: String,
    code: String,
}

impl Invitation {
    pub(super) fn new(address: SocketAddr, code: &JoinCode) -> Self {
        Self { address: address.to_string(), code: code.to_string() }
    }

    /// The command for another machine.
    pub(super) fn command(&self) -> String {
        format!("others join with:  pottery-studio join {} --code {}", self.address, self.code)
    }
}

/// Somebody at the wheel.
#[derive(Clone, Debug)]
pub(super) struct Person {
    pub(super) name: String,
    pub(super) colour: [f32; 3],
    pub(super) touching: bool,
}

/// What the panel shows and lets be changed.
#[derive(Debug)]
pub(super) struct PanelState {
    pub(super) rpm: f32,
    pub(super) holding: Holding,
    /// Number of tools in the rack.
    pub(super) rack: usize,
    /// How wet the clay is, a liquidity index.
    pub(super) wetness: f32,
    pub(super) pushed_mm: f32,
    pub(super) force_n: f32,
    pub(super) is_touching: bool,
    /// The person wants no force.
    pub(super) is_force_off: bool,
    /// The person wants to hear the clay, and why it cannot be.
    pub(super) is_heard: bool,
    pub(super) no_sound: Option<String>,
    pub(super) people: Vec<Person>,
    pub(super) round_trip_ms: f32,
    pub(super) late_percent: f32,
    pub(super) frames_per_s: f32,
    pub(super) adapter: String,
    /// What is in the hand.
    pub(super) device: String,
    /// What its thread goes before.
    pub(super) pace: String,
    /// A sentence that the person must see.
    pub(super) notice: Option<String>,
    pub(super) shows_help: bool,
    /// Whether the controls lie open; as the window's width allows until somebody says.
    pub(super) is_open: Option<bool>,
    /// Share of the window's width that they cover, from its left edge.
    pub(super) covers: f32,
}

impl PanelState {
    /// Folds the controls away, or opens them.
    pub(super) fn fold(&mut self) {
        self.is_open = Some(self.covers == 0.0);
    }
}

/// Width of the controls, and that of a window in which they leave the pot room enough to be open at first, points.
const WIDTH: f32 = 250.0;
const WINDOW_OPEN: f32 = 720.0;
/// Ranges of the controls.
pub(super) const RPM_MAX: f32 = 300.0;
pub(super) const WETNESS: (f32, f32) = (Wetness::DRIEST.liquidity_index(), Wetness::WETTEST.liquidity_index());
/// A preset's button is lit this near to it: as far as the slider shows.
const PRESET_WITHIN: f32 = 0.005;

const KEYS: [(&str, &str); 20] = [
    ("Enter", "no force at once; again: force"),
    ("left button", "press the tool in"),
    ("mouse wheel, W S", "push deeper, let out"),
    ("right button", "turn the view"),
    ("Ctrl + wheel", "closer, farther"),
    ("up, down, space", "wheel faster, slower, stop"),
    ("T", "next tool"),
    ("+ -", "larger, smaller sphere"),
    ("Q E", "turn the tool about its upright"),
    ("A D, Shift + wheel", "roll it"),
    ("F G, Alt + wheel; X", "lean it; upright again"),
    ("V B", "drier, wetter clay"),
    ("C", "a device's middle is here"),
    ("M", "hear the clay or not"),
    ("R or 1", "view as at first"),
    ("2, 3", "as a profile, from above"),
    ("K", "cut the pot open, close it"),
    ("Ctrl + S, Ctrl + E", "save the pot, export it"),
    ("P", "fold the panel, open it"),
    ("H, Esc", "these keys, leave"),
];

/// The colour of a linear RGB triple.
fn colour_of([red, green, blue]: [f32; 3]) -> Color32 {
    egui::Rgba::from_rgb(red, green, blue).into()
}

/// Lays the panel out over the picture.
pub(super) fn show(
    context: &egui::Context,
    state: &mut PanelState,
    invitation: Option<&Invitation>,
    files: &mut Files,
) {
    let window = context.content_rect();
    let is_open = state.is_open.unwrap_or(window.width() >= WINDOW_OPEN);
    let panel = egui::Window::new("studio").title_bar(false).resizable(false).anchor(Align2::LEFT_TOP, [12.0, 12.0]);
    let shown = panel.show(context, |ui| {
        if !is_open {
            if ui.button("Panel (P)").clicked() {
                state.is_open = Some(true);
            }
            return;
        }
        if ui.small_button("fold (P)").clicked() {
            state.is_open = Some(false);
        }
        // above the line of figures at the foot of the window
        let room = window.height() - 90.0;
        egui::ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, |ui| {
            ui.set_width(WIDTH);
            if let Some(invitation) = invitation {
                ui.label(RichText::new("Others join with").small());
                ui.label(RichText::new(format!("address  {}", invitation.address)).monospace());
                ui.label(RichText::new("code").monospace());
                ui.label(RichText::new(&invitation.code).monospace().strong());
                if ui.button("Copy the command").clicked() {
                    let command = format!("pottery-studio join {} --code {}", invitation.address, invitation.code);
                    ui.ctx().copy_text(command);
                }
                ui.separator();
            }
            ui.add(egui::Slider::new(&mut state.rpm, 0.0..=RPM_MAX).text("wheel, rpm").integer());
            show_tool(ui, &mut state.holding, state.rack);
            ui.separator();
            show_clay(ui, &mut state.wetness);
            ui.separator();
            let bar =
                egui::ProgressBar::new((state.force_n / 3.3).clamp(0.0, 1.0)).text(format!("{:.2} N", state.force_n));
            ui.add(bar.desired_width(WIDTH));
            let switch = if state.is_force_off { "Give force again (Enter)" } else { "No force at once (Enter)" };
            if ui.button(switch).clicked() {
                state.is_force_off = !state.is_force_off;
            }
            let touch = if state.is_touching { "touching the clay" } else { "not touching" };
            ui.label(format!("{touch}; pushed in {:.1} mm", state.pushed_mm.max(0.0)));
            match &state.no_sound {
                None => {
                    ui.checkbox(&mut state.is_heard, "hear the clay (M)");
                }
                Some(reason) => {
                    ui.label(RichText::new("no sound here").small()).on_hover_text(reason);
                }
            }
            ui.separator();
            files.show(ui);
            ui.separator();
            for person in &state.people {
                let doing = if person.touching { ", touching" } else { "" };
                ui.colored_label(colour_of(person.colour), format!("{}{doing}", person.name));
            }
        });
    });
    let right = shown.filter(|_| is_open).map_or(0.0, |shown| shown.response.rect.right());
    state.covers = (right / window.width().max(1.0)).clamp(0.0, 1.0);
    egui::Area::new(egui::Id::unique("status")).anchor(Align2::LEFT_BOTTOM, [14.0, -10.0]).show(context, |ui| {
        ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Extend);
        ui.label(
            RichText::new(format!(
                "round trip {:.1} ms · {} · {}, hand {}, {:.1} % late · {:.0} pictures/s on {} · H: keys",
                state.round_trip_ms,
                quality(state.round_trip_ms),
                state.device,
                state.pace,
                state.late_percent,
                state.frames_per_s,
                state.adapter
            ))
            .small()
            .color(Color32::from_gray(200)),
        );
    });
    if let Some(notice) = &state.notice {
        egui::Window::new("notice").title_bar(false).anchor(Align2::CENTER_TOP, [0.0, 24.0]).show(context, |ui| {
            ui.label(RichText::new(notice).strong());
        });
    }
    if state.shows_help {
        egui::Window::new("Keys").anchor(Align2::RIGHT_TOP, [-12.0, 12.0]).resizable(false).show(context, |ui| {
            egui::Grid::new("keys").show(ui, |ui| {
                for (key, effect) in KEYS {
                    ui.label(RichText::new(key).monospace());
                    ui.label(effect);
                    ui.end_row();
                }
            });
        });
    }
}

/// Which tool is held, and its size or how it is turned.
fn show_tool(ui: &mut egui::Ui, holding: &mut Holding, rack: usize) {
    let called = |shape: Option<Shape>| shape.map_or_else(|| "sphere".to_owned(), holding::name);
    ui.horizontal(|ui| {
        let chosen = egui::ComboBox::from_id_salt("tool").selected_text(called(holding.shape)).width(100.0);
        chosen.show_ui(ui, |ui| {
            for shape in std::iter::once(None).chain((0..rack).map(|number| Some(Shape(number as u8)))) {
                ui.selectable_value(&mut holding.shape, shape, called(shape));
            }
        });
        if holding.shape.is_none() {
            let radius = egui::DragValue::new(&mut holding.sphere_mm).range(TOOL_MM.0..=TOOL_MM.1).speed(0.1);
            ui.add(radius.prefix("radius ").suffix(" mm"));
        }
    });
    if holding.shape.is_some() {
        ui.horizontal(|ui| {
            for (angle_deg, (text, most_deg)) in holding.angles_deg.iter_mut().zip(ANGLES) {
                let angle = egui::DragValue::new(angle_deg).range(-most_deg..=most_deg).max_decimals(0);
                ui.add(angle.prefix(text).suffix("°"));
            }
        });
    }
}

/// Presets, one control of wetness, and what the clay then is.
fn show_clay(ui: &mut egui::Ui, wetness: &mut f32) {
    ui.horizontal(|ui| {
        for preset in Preset::ALL {
            let index = preset.wetness().liquidity_index();
            if ui.selectable_label((*wetness - index).abs() < PRESET_WITHIN, preset.name()).clicked() {
                *wetness = index;
            }
        }
    });
    // shown to two decimals and not rounded to them: what somebody else set is not to be asked for anew
    let slider = egui::Slider::new(wetness, WETNESS.0..=WETNESS.1).custom_formatter(|value, _| format!("{value:.2}"));
    ui.add(slider.text("wetness"));
    let material = Material::from_wetness(Wetness::nearest(*wetness));
    ui.label(
        RichText::new(format!(
            "yields at {:.0} kPa, E {:.2} MPa, {:.0} ms",
            material.strength.yield_pa * 1e-3,
            material.strength.youngs_pa * 1e-6,
            material.viscosity.0 * 1e3
        ))
        .small(),
    );
}

/// The connection in a word.
fn quality(round_trip_ms: f32) -> &'static str {
    match round_trip_ms {
        ..15.0 => "excellent",
        ..60.0 => "good",
        ..150.0 => "fair",
        _ => "slow",
    }
}
