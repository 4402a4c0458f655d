//! The panel beside the pot: how to join, how the wheel and the clay are set, who is here, and the keys.
//!
//! Owns words and layout; changes nothing itself but answers with what the person asked for.
//! Invariant: every control that is shown has an effect.

mod clay;
mod guidance;
mod history;
mod invitation;
mod keys;
mod liking;
mod people;
pub(super) mod profiles;
mod tool;

use egui::{Align2, Color32, RichText};
use pottery_client::device::Feel;
use pottery_shared::clay::Wetness;
use pottery_shared::protocol::Nickname;
use pottery_shared::tool::Side;

pub(super) use guidance::{Guidance, Wanted};
pub(super) use history::History;
pub(super) use invitation::Invitation;
pub(super) use people::{People, nickname};

use super::files::Files;
use super::fitting;
use super::holding::Holding;
use super::lesson::Lesson;
use crate::preferences::{Preferences, Theme};
use crate::words::Words;

/// Somebody at the wheel.
#[derive(Clone, Debug)]
pub(super) struct Person {
    /// None for who sits at this window.
    pub(super) number: Option<u16>,
    /// What the room calls it, as far as that was heard.
    pub(super) name: Option<Nickname>,
    pub(super) colour: [f32; 3],
    pub(super) touching: bool,
}

impl Person {
    /// What it is called.
    pub(super) fn name(&self, words: &Words) -> String {
        let number = |number: u16| words.say_with("potter", &[("number", &number.to_string())]);
        let called = |client: u16| self.name.map_or_else(|| number(client), |name| nickname(words, name));
        self.number.map_or_else(|| words.say("you"), called)
    }
}

/// What the panel shows and lets be changed.
#[derive(Debug)]
pub(super) struct PanelState {
    pub(super) words: Words,
    pub(super) liking: Preferences,
    pub(super) rpm: f32,
    pub(super) holding: Holding,
    /// The side of the wall on which the person works, and whether the other one is wanted.
    pub(super) side: Side,
    pub(super) changes_side: bool,
    /// Number of tools in the rack.
    pub(super) rack: usize,
    /// How wet the clay is, a liquidity index.
    pub(super) wetness: f32,
    /// Whether the wheel's clay dries slowly; none where that is another's to say.
    pub(super) dries: Option<bool>,
    pub(super) pushed_mm: f32,
    pub(super) force_n: f32,
    /// The largest force that the device gives, N, and how a person is told of it.
    pub(super) peak_n: f32,
    pub(super) feel: Feel,
    pub(super) is_touching: bool,
    /// The person wants no force.
    pub(super) is_force_off: bool,
    /// The person wants to hear the clay, and why it cannot be.
    pub(super) is_heard: bool,
    pub(super) no_sound: Option<String>,
    pub(super) people: Vec<Person>,
    /// Whether the person wants to look on instead; none where that cannot be.
    pub(super) looks_on: Option<bool>,
    pub(super) class: People,
    pub(super) history: History,
    pub(super) guidance: Guidance,
    /// Whether the connection stands; one that is silent for a moment does.
    pub(super) is_in: bool,
    /// None while nothing is heard on it.
    pub(super) round_trip_ms: Option<f32>,
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
    /// The fitting of a device to the hand, while there is one, what was asked of it, and whether there is a device for it.
    pub(super) fitting: Option<fitting::Shown>,
    pub(super) fitting_answer: Option<fitting::Answer>,
    pub(super) can_be_fitted: bool,
    /// The first lesson, while it is taken.
    pub(super) lesson: Option<Lesson>,
    /// Whether the controls lie open; as the window's width allows until somebody says.
    pub(super) is_open: Option<bool>,
    /// Share of the window's width that they cover, from its left edge.
    pub(super) covers: f32,
}

impl PanelState {
    /// Folds the controls away, or opens them; twice between two pictures leaves them as they were.
    pub(super) fn fold(&mut self) {
        self.is_open = Some(!self.is_seen());
    }

    /// Whether the controls lie open.
    fn is_seen(&self) -> bool {
        self.is_open.unwrap_or(self.covers > 0.0)
    }

    /// Who guides this hand and how to let go, where the controls do not say it.
    pub(super) fn guided(&self) -> Option<String> {
        self.guidance.notice(&self.words).filter(|_| !self.is_seen())
    }
}

/// Colour of the force's bar while the tool touches the clay: of fired clay.
const TOUCHING: Color32 = Color32::from_rgb(178, 84, 46);
/// Width of that bar while the controls are folded away, points.
const WIDTH_FOLDED: f32 = 96.0;
/// Width of the controls, and that of a window in which they leave the pot room enough to be open at first, points.
const WIDTH: f32 = 250.0;
const WINDOW_OPEN: f32 = 720.0;
/// Width that a sentence over the pot needs, points.
const NOTICE_LEAST: f32 = 160.0;
/// Ranges of the controls.
pub(super) const RPM_MAX: f32 = 300.0;
/// What a sponge makes the clay wetter by, and one key drier.
pub(super) const WETNESS_STEP: f32 = 0.02;
pub(super) const WETNESS: (f32, f32) = (Wetness::DRIEST.liquidity_index(), Wetness::WETTEST.liquidity_index());
/// How fast potters turn a wheel for what they do, rpm: fastest to centre, slower as the wall gets thin.
const SPEEDS: [(&str, f32); 4] =
    [("wheel-centre", 200.0), ("wheel-open", 140.0), ("wheel-pull", 80.0), ("wheel-trim", 120.0)];

/// The colour of a linear RGB triple.
pub(super) fn colour_of([red, green, blue]: [f32; 3]) -> Color32 {
    egui::Rgba::from_rgb(red, green, blue).into()
}

/// Takes over how the person likes the window to look.
pub(super) fn dress(context: &egui::Context, liking: &Preferences) {
    context.set_theme(match liking.theme {
        Theme::Dark => egui::ThemePreference::Dark,
        Theme::Light => egui::ThemePreference::Light,
        Theme::System => egui::ThemePreference::System,
    });
}

/// Lays the panel out over the picture.
pub(super) fn show(
    context: &egui::Context,
    state: &mut PanelState,
    invitation: Option<&Invitation>,
    files: &mut Files,
) {
    dress(context, &state.liking);
    let window = context.content_rect();
    let is_open = state.is_open.unwrap_or(window.width() >= WINDOW_OPEN);
    let panel = egui::Window::new("studio").title_bar(false).resizable(false).anchor(Align2::LEFT_TOP, [12.0, 12.0]);
    let shown = panel.show(context, |ui| {
        let fold = state.words.say(if is_open { "fold" } else { "unfold" });
        if ui.small_button(fold).clicked() {
            state.is_open = Some(!is_open);
        }
        if is_open {
            // above the line of figures at the foot of the window
            let room = window.height() - 90.0;
            egui::ScrollArea::vertical().max_height(room).min_scrolled_height(room).show(ui, |ui| {
                ui.set_width(WIDTH);
                show_controls(ui, state, invitation, files);
            });
        } else {
            show_gauge(ui, state, WIDTH_FOLDED);
        }
    });
    let end = shown.map_or(0.0, |shown| shown.response.rect.right());
    let right = if is_open { end } else { 0.0 };
    state.covers = (right / window.width().max(1.0)).clamp(0.0, 1.0);
    show_status(context, state);
    if let Some(notice) = &state.notice {
        // beside the panel, and at the foot of a window that it leaves nothing of
        let left = if is_open || window.width() < WINDOW_OPEN { end } else { 0.0 };
        let (edge, left, down) = match window.width() - left < NOTICE_LEAST {
            true => (Align2::CENTER_BOTTOM, 0.0, -34.0),
            false => (Align2::CENTER_TOP, left, 24.0),
        };
        let place = egui::Window::new("notice").title_bar(false).anchor(edge, [0.5 * left, down]);
        place.max_width((window.width() - left - 48.0).max(NOTICE_LEAST)).show(context, |ui| {
            ui.label(RichText::new(notice).strong());
        });
    }
    if let Some(fitting) = state.fitting {
        state.fitting_answer = fitting.show(context, &state.words).or(state.fitting_answer);
    } else if let Some(lesson) = &mut state.lesson
        && lesson.show(context, &state.words)
    {
        state.lesson = None;
        state.liking.knows_lesson = true;
    }
    if state.shows_help {
        keys::show(context, &state.words);
    }
}

/// Lays out a part of the panel whose controls stay the same ones whatever comes and goes above it, so that a menu of it stays open.
fn part<R>(ui: &mut egui::Ui, name: impl egui::AsIdSalt, show: impl FnOnce(&mut egui::Ui) -> R) -> R {
    let id = ui.scope_id().with(name);
    ui.scope_builder(egui::UiBuilder::new().scope_id(id), show).inner
}

fn show_controls(ui: &mut egui::Ui, state: &mut PanelState, invitation: Option<&Invitation>, files: &mut Files) {
    if let Some(invitation) = invitation {
        invitation.show(ui, &state.words);
        ui.separator();
    }
    // what everybody at the wheel has in common cannot be changed while nobody hears of it
    let is_in = state.is_in;
    ui.add_enabled_ui(is_in, |ui| {
        ui.add(egui::Slider::new(&mut state.rpm, 0.0..=RPM_MAX).text(state.words.say("wheel-rpm")).integer());
        ui.horizontal(|ui| {
            for (name, rpm) in SPEEDS {
                if ui.selectable_label(state.rpm == rpm, state.words.say(name)).clicked() {
                    state.rpm = rpm;
                }
            }
        });
    });
    tool::show(ui, state);
    ui.separator();
    ui.add_enabled_ui(is_in, |ui| clay::show(ui, &state.words, &mut state.wetness, &mut state.dries));
    clay::show_finish(ui, &state.words, &mut state.liking.finish);
    ui.separator();
    show_force(ui, state);
    ui.separator();
    ui.add_enabled_ui(is_in, |ui| {
        state.guidance.show(ui, &state.words, &state.class);
        part(ui, "history", |ui| state.history.show(ui, &state.words, state.class.may_change()));
    });
    ui.separator();
    part(ui, "files", |ui| files.show(ui, &state.words));
    ui.separator();
    ui.add_enabled_ui(is_in, |ui| {
        state.class.show(ui, &state.words, &state.people, state.wetness, state.rpm);
    });
    ui.separator();
    if let Some(looks_on) = &mut state.looks_on {
        let button = egui::Button::new(state.words.say("look-on"));
        *looks_on |= part(ui, "look-on", |ui| ui.add_enabled(is_in, button).clicked());
        ui.separator();
    }
    part(ui, "preferences", |ui| liking::show(ui, state));
}

fn show_force(ui: &mut egui::Ui, state: &mut PanelState) {
    show_gauge(ui, state, WIDTH);
    let words = &state.words;
    if ui.button(words.say(if state.is_force_off { "force-on" } else { "force-off" })).clicked() {
        state.is_force_off = !state.is_force_off;
    }
    let depth = words.number(f64::from(state.pushed_mm.max(0.0)), 1);
    ui.label(words.say_with(if state.is_touching { "touching" } else { "not-touching" }, &[("depth", &depth)]));
    let feel = match state.feel {
        Feel::Force => "feel-force",
        Feel::Hum => "feel-hum",
        Feel::Lag => "feel-lag",
        Feel::Nobody => "feel-nobody",
    };
    ui.label(RichText::new(words.say(feel)).small());
    if state.can_be_fitted && state.fitting.is_none() && ui.button(words.say("fitting-begin")).clicked() {
        state.fitting_answer = Some(fitting::Answer::Begin);
    }
    match &state.no_sound {
        None => {
            ui.checkbox(&mut state.is_heard, words.say("hear"));
        }
        Some(reason) => {
            ui.label(RichText::new(words.say("no-sound")).small()).on_hover_text(reason);
        }
    }
}

/// The force on the hand as a part of the largest that its device gives; coloured while the tool touches the clay.
fn show_gauge(ui: &mut egui::Ui, state: &PanelState, width: f32) {
    let force = format!("{} N", state.words.number(f64::from(state.force_n), 2));
    let bar = egui::ProgressBar::new((state.force_n / state.peak_n).clamp(0.0, 1.0)).text(force);
    let bar = if state.is_touching { bar.fill(TOUCHING) } else { bar };
    ui.add(bar.desired_width(width));
}

/// The line of figures at the foot of the window.
fn show_status(context: &egui::Context, state: &PanelState) {
    let words = &state.words;
    let connection = state.round_trip_ms.map_or_else(
        || words.say("no-connection"),
        |round_trip_ms| {
            let rtt = words.number(f64::from(round_trip_ms), 1);
            words.say_with("connection", &[("rtt", &rtt), ("quality", &words.say(quality(round_trip_ms)))])
        },
    );
    let figures = words.say_with(
        "status",
        &[
            ("connection", &connection),
            ("device", &state.device),
            ("pace", &state.pace),
            ("late", &words.number(f64::from(state.late_percent), 1)),
            ("pictures", &words.number(f64::from(state.frames_per_s), 0)),
            ("adapter", &state.adapter),
        ],
    );
    show_line(context, Align2::LEFT_BOTTOM, &figures);
}

/// A small line over the picture, at one of the window's edges; what is under it can be clicked.
pub(super) fn show_line(context: &egui::Context, edge: Align2, said: &str) {
    let inwards = -10.0 * edge.to_sign();
    let area = egui::Area::new(egui::Id::unique(("line", edge))).interactable(false);
    area.order(egui::Order::Foreground).anchor(edge, [1.4 * inwards.x, inwards.y]).show(context, |ui| {
        // what is left out where the window is narrow stands last
        ui.style_mut().wrap_mode = Some(egui::TextWrapMode::Truncate);
        ui.set_max_width((context.content_rect().width() - 28.0).max(0.0));
        // the picture is as dark in either look
        let said = RichText::new(said).small().color(Color32::from_gray(200));
        ui.add(egui::Label::new(said).selectable(false));
    });
}

/// Takes a figure over that a window at rest shows, where it says something else: by more than a quarter, and by more than `least`.
pub(super) fn renew(shown: &mut f32, figure: f32, least: f32) {
    if (figure - *shown).abs() > (0.25 * *shown).max(least) {
        *shown = figure;
    }
}

/// The connection in a word.
fn quality(round_trip_ms: f32) -> &'static str {
    match round_trip_ms {
        ..15.0 => "quality-excellent",
        ..60.0 => "quality-good",
        ..150.0 => "quality-fair",
        _ => "quality-slow",
    }
}

#[cfg(test)]
mod tests {
    use egui::{Event, Modifiers, PointerButton, Pos2, RawInput, Rect, vec2};

    use super::*;

    /// Draws so many lines above a button that opens a menu: where the button is, and whether the menu is open.
    fn draw(context: &egui::Context, lines: usize, events: Vec<Event>) -> (Rect, bool) {
        let screen_rect = Some(Rect::from_min_size(Pos2::ZERO, vec2(400.0, 400.0)));
        let mut seen = (Rect::NOTHING, false);
        let mut output = context.run_ui(RawInput { screen_rect, events, ..RawInput::default() }, |ui| {
            for line in 0..lines {
                ui.label(line.to_string());
            }
            let menu = part(ui, "menu", |ui| ui.menu_button("menu", |ui| ui.label("entry")));
            seen = (menu.response.rect, menu.inner.is_some());
        });
        output.textures_delta.clear();
        seen
    }

    #[test]
    fn a_menu_stays_open_when_a_line_comes_above_it() {
        let context = egui::Context::default();
        let (button, is_open) = draw(&context, 1, Vec::new());
        assert!(!is_open);
        let (pos, modifiers, button) = (button.center(), Modifiers::default(), PointerButton::Primary);
        draw(&context, 1, vec![Event::PointerMoved(pos)]);
        for pressed in [true, false] {
            draw(&context, 1, vec![Event::PointerButton { pos, button, pressed, modifiers }]);
        }
        for lines in [1, 2, 3, 0] {
            let (_, is_open) = draw(&context, lines, Vec::new());
            assert!(is_open, "with {lines} lines above it");
        }
    }
}
