//! What keys, pointer and fingers do at the wheel.
//!
//! Owns which key does what; what is done is the hand's, the panel's and the camera's.
//! Invariant: every key here stands in the table of keys.

use std::time::Instant;

use glam::Vec2;
use pottery_client::render::Camera;
use winit::event::{KeyEvent, Touch};
use winit::event_loop::ActiveEventLoop;
use winit::keyboard::{Key, NamedKey};

use super::App;
use crate::window::fingers::Asked;
use crate::window::fitting::Answer;
use crate::window::overlay::Overlay;
use crate::window::panel::{RPM_MAX, WETNESS, WETNESS_STEP};

/// A push by one step of the mouse wheel or one key, m.
const PUSH_STEP_M: f32 = 0.001;
/// What one key, or one step of the mouse wheel, turns a tool by, degrees.
const TURN_STEP_DEG: f32 = 5.0;
/// What it leans a tool by: over the length of a rib, that is 2 mm.
const LEAN_STEP_DEG: f32 = 1.0;
/// How far one key moves the tool across the picture, of half its width or height.
const POINT_STEP: f32 = 0.01;
/// How many times closer one key or one step of the mouse wheel brings the view, and how near and far it goes, m.
const CLOSER: f32 = 1.0 / 0.9;
const DISTANCE_M: (f32, f32) = (0.25, 2.0);

/// Whether a key that is held down does again and again what it does.
fn goes_on(key: &Key) -> bool {
    match key.as_ref() {
        Key::Named(named) => matches!(
            named,
            NamedKey::ArrowUp
                | NamedKey::ArrowDown
                | NamedKey::ArrowLeft
                | NamedKey::ArrowRight
                | NamedKey::PageUp
                | NamedKey::PageDown
        ),
        Key::Character(letter) => {
            matches!(letter, "+" | "=" | "-" | "q" | "e" | "f" | "g" | "a" | "d" | "v" | "b" | "w" | "s")
        }
        _ => false,
    }
}

/// Which way an arrow moves the tool.
fn across(key: &Key) -> Option<Vec2> {
    let way = match key.as_ref() {
        Key::Named(NamedKey::ArrowLeft) => -Vec2::X,
        Key::Named(NamedKey::ArrowRight) => Vec2::X,
        Key::Named(NamedKey::ArrowUp) => Vec2::Y,
        Key::Named(NamedKey::ArrowDown) => -Vec2::Y,
        _ => return None,
    };
    Some(way * POINT_STEP)
}

/// The key in small letters, which Shift and Caps Lock make large.
fn small(key: &Key) -> Key {
    match key {
        Key::Character(letter) => Key::Character(letter.to_lowercase().into()),
        key => key.clone(),
    }
}

/// Where the tool is to be in the picture.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pointed {
    /// −1 to 1, to the right and up.
    at: Vec2,
    /// Whether keys moved it there, so that a pointer over the panel has no say.
    is_by_keys: bool,
}

impl App {
    /// Takes a key that goes down, or that is held down and comes again.
    pub(super) fn press_key(&mut self, event_loop: &ActiveEventLoop, event: &KeyEvent, is_panels: bool) {
        if event.logical_key == Key::Named(NamedKey::Enter) {
            if !event.repeat {
                self.switch_force(is_panels);
            }
            return;
        }
        let has_control = self.modifiers.control_key();
        // what is typed into the panel is for it alone
        if is_panels && !has_control {
            return;
        }
        let key = small(&event.logical_key);
        if event.repeat && (has_control || !goes_on(&key)) {
            return;
        }
        match (has_control, self.modifiers.shift_key().then(|| across(&key)).flatten()) {
            (true, _) => self.shortcut(&key),
            (false, Some(by)) => self.move_tool(by),
            (false, None) => self.key(event_loop, &key),
        }
    }

    /// Moves the tool across the picture, from its middle where it is nowhere yet.
    fn move_tool(&mut self, by: Vec2) {
        let at = self.followed().map_or(Vec2::ZERO, |at| at + by);
        self.point_at(Pointed { at: at.clamp(-Vec2::ONE, Vec2::ONE), is_by_keys: true });
    }

    fn point_at(&mut self, pointed: Pointed) {
        self.pointed = Some(pointed);
        self.point();
        // the hand's thread hears of it now, and what it makes of it is in the next picture
        self.guide(0.0);
    }

    fn shortcut(&mut self, key: &Key) {
        match key.as_ref() {
            Key::Character("s") => self.files.save(),
            Key::Character("e") => self.files.export(),
            Key::Character("o") => self.files.open(),
            // in a text, they are the text's
            Key::Character("z" | "y") if self.overlay.as_ref().is_some_and(Overlay::has_keyboard) => {}
            Key::Character("z") if !self.modifiers.shift_key() => self.panel.history.undo(),
            Key::Character("y" | "z") => self.panel.history.redo(),
            Key::Character("n") => self.panel.history.begin_anew(None),
            _ => {}
        }
    }

    /// Closes what lies over the pot, a menu first, which does so by itself; with nothing there, leaves.
    fn close_or_leave(&mut self, event_loop: &ActiveEventLoop) {
        if self.overlay.as_ref().is_some_and(Overlay::has_menu) {
            return;
        }
        if self.panel.shows_help {
            self.panel.shows_help = false;
        } else if self.panel.fitting.is_some() {
            self.answer_fitting(Answer::Leave);
        } else if self.invitation.is_none() || !self.panel.class.has_others() || self.is_leaving() {
            event_loop.exit();
        } else {
            self.refusal = Some((Instant::now(), self.panel.words.say("leaving-ends")));
        }
    }

    /// Whether it was said that leaving closes the studio for others as well, and still stands there.
    fn is_leaving(&self) -> bool {
        self.refusal.as_ref().is_some_and(|(_, said)| *said == self.panel.words.say("leaving-ends"))
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, key: &Key) {
        match key.as_ref() {
            Key::Named(NamedKey::Escape) => self.close_or_leave(event_loop),
            Key::Named(NamedKey::ArrowUp) => self.panel.rpm = (self.panel.rpm + 10.0).min(RPM_MAX),
            Key::Named(NamedKey::ArrowDown) => self.panel.rpm = (self.panel.rpm - 10.0).max(0.0),
            Key::Named(NamedKey::ArrowLeft) => self.camera.azimuth_rad -= 0.1,
            Key::Named(NamedKey::ArrowRight) => self.camera.azimuth_rad += 0.1,
            Key::Named(NamedKey::PageUp) => self.zoom(CLOSER),
            Key::Named(NamedKey::PageDown) => self.zoom(1.0 / CLOSER),
            Key::Named(NamedKey::Space) => {
                let rpm = self.panel.rpm;
                self.panel.rpm = if rpm > 0.0 { 0.0 } else { self.rpm_before_stop };
                if rpm > 0.0 {
                    self.rpm_before_stop = rpm;
                }
            }
            Key::Character("+" | "=") => self.panel.holding.grow(1.0),
            Key::Character("-") => self.panel.holding.grow(-1.0),
            Key::Character("t") => self.panel.holding.take_next(&self.potter.view().lock().rack),
            Key::Character("q") => self.panel.holding.turn(0, TURN_STEP_DEG),
            Key::Character("e") => self.panel.holding.turn(0, -TURN_STEP_DEG),
            Key::Character("f") => self.panel.holding.turn(1, LEAN_STEP_DEG),
            Key::Character("g") => self.panel.holding.turn(1, -LEAN_STEP_DEG),
            Key::Character("a") => self.panel.holding.turn(2, TURN_STEP_DEG),
            Key::Character("d") => self.panel.holding.turn(2, -TURN_STEP_DEG),
            Key::Character("x") => self.panel.holding.angles_deg = [0.0; 3],
            Key::Character("v") => {
                self.panel.wetness = (self.panel.wetness - WETNESS_STEP).max(WETNESS.0);
            }
            Key::Character("b") => {
                self.panel.wetness = (self.panel.wetness + WETNESS_STEP).min(WETNESS.1);
            }
            Key::Character("w") => self.hand.push(PUSH_STEP_M),
            Key::Character("s") => self.hand.push(-PUSH_STEP_M),
            Key::Character("r" | "1") => self.camera = Camera::on(&self.potter.view().lock().pot),
            Key::Character("2") => self.camera.elevation_rad = 0.0,
            Key::Character("3") => self.camera.elevation_rad = Camera::ABOVE_RAD,
            Key::Character("k") => self.is_cut = !self.is_cut,
            Key::Character("l") => self.panel.liking.finish = self.panel.liking.finish.next(),
            Key::Character("i") => self.hand.change_side(),
            Key::Character("c") => self.answer_fitting(Answer::GoOn),
            Key::Character("j") => self.panel.guidance.take_over_or_let_go(),
            Key::Character("n") => self.panel.guidance.switch(),
            Key::Character("u") => self.panel.guidance.record(),
            Key::Character("y") => self.panel.guidance.play(),
            Key::Character("p") => self.panel.fold(),
            // where nothing is heard anyway, nobody would see what it did
            Key::Character("m") if self.panel.no_sound.is_none() => self.panel.is_heard = !self.panel.is_heard,
            Key::Character("h") => self.panel.shows_help = !self.panel.shows_help,
            _ => {}
        }
    }

    /// The emergency key: takes the force away whatever else is going on. Whoever types into the panel ends that with the same
    /// key, so that it gives nothing back there.
    pub(super) fn switch_force(&mut self, is_typing: bool) {
        if is_typing && (self.panel.is_force_off || self.held.monitor.is_none()) {
            return;
        }
        self.panel.is_force_off = !self.panel.is_force_off;
        self.potter.status().switch_force_off(self.panel.is_force_off);
    }

    pub(super) fn moved(&mut self, to: Vec2) {
        let by = to - self.cursor;
        self.cursor = to;
        let Some(stage) = &self.stage else { return };
        let size = stage.window.inner_size();
        if self.turning_view {
            self.camera.turn(by);
        }
        let ndc = Vec2::new(2.0 * to.x / size.width.max(1) as f32 - 1.0, 1.0 - 2.0 * to.y / size.height.max(1) as f32);
        self.point_at(Pointed { at: ndc, is_by_keys: false });
        self.timing.moved(self.shown.own_m);
    }

    /// Points the hand where the pointer is, unless that is over the panel, or where keys moved it; whether it pointed elsewhere.
    pub(super) fn point(&mut self) -> bool {
        self.hand.point_to(self.followed())
    }

    fn followed(&self) -> Option<Vec2> {
        let is_panels = self.overlay.as_ref().is_some_and(Overlay::has_pointer);
        self.pointed.filter(|pointed| pointed.is_by_keys || !is_panels).map(|pointed| pointed.at)
    }

    /// One finger is the mouse with its left button down, two turn the view and bring it closer.
    pub(super) fn touched(&mut self, touch: &Touch, is_panels: bool) {
        let at = Vec2::new(touch.location.x as f32, touch.location.y as f32);
        match self.fingers.take(touch.id, touch.phase, at, is_panels) {
            Asked::Nothing => {}
            Asked::Tool { at, is_held } => {
                self.moved(at);
                self.hand.press_button(is_held);
                if !is_held {
                    self.pointed = None;
                    self.point();
                }
            }
            Asked::View { by, closer } => {
                self.camera.turn(by);
                self.zoom(closer);
            }
        }
    }

    /// Brings the view so many times closer.
    fn zoom(&mut self, closer: f32) {
        self.camera.distance_m = (self.camera.distance_m / closer).clamp(DISTANCE_M.0, DISTANCE_M.1);
    }

    pub(super) fn scrolled(&mut self, lines: f32) {
        if self.modifiers.control_key() {
            self.zoom(CLOSER.powf(lines));
        } else if self.modifiers.shift_key() {
            self.panel.holding.turn(2, lines * TURN_STEP_DEG);
        } else if self.modifiers.alt_key() {
            self.panel.holding.turn(1, lines * LEAN_STEP_DEG);
        } else {
            self.hand.push(lines * PUSH_STEP_M);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_switches_or_asks_does_so_once_however_long_it_is_held() {
        let letter = |letter: &str| small(&Key::Character(letter.into()));
        for once in ["i", "k", "j", "n", "u", "y", "m", "h", "p", "l", "t", "r", "x", "c", "1", "2", "3"] {
            assert!(!goes_on(&letter(once)), "{once}");
        }
        for once in [NamedKey::Space, NamedKey::Escape, NamedKey::Enter] {
            assert!(!goes_on(&Key::Named(once)), "{once:?}");
        }
        for held in ["w", "S", "q", "E", "a", "d", "f", "g", "V", "b", "+", "-"] {
            assert!(goes_on(&letter(held)), "{held}");
        }
        assert!(goes_on(&Key::Named(NamedKey::ArrowUp)));
    }
}
