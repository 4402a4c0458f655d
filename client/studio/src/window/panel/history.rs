//! Undo and redo in the panel: the buttons, what can be taken back, and a word while clay is made again.
//!
//! Owns what the person asked for until it is sent; what can be undone is the room's to say.
//! Invariant: a sentence that says why nothing was undone stays for [`SAID_FOR`] and no longer.

use std::time::{Duration, Instant};

use egui::RichText;
use pottery_client::Command;
use pottery_client::view::View;
use pottery_shared::clay::Form;
use pottery_shared::protocol::{NoStep, StepsWire};

use crate::words::Words;

/// How long a sentence stays.
const SAID_FOR: Duration = Duration::from_secs(4);

/// Steps back and forth of one window.
#[derive(Debug, Default)]
pub(in crate::window) struct History {
    steps: StepsWire,
    wishes: Vec<Command>,
    said: Option<(Instant, NoStep)>,
}

impl History {
    pub(in crate::window) fn undo(&mut self) {
        self.wishes.push(Command::Undo);
    }

    pub(in crate::window) fn redo(&mut self) {
        self.wishes.push(Command::Redo);
    }

    pub(in crate::window) fn begin_anew(&mut self, form: Option<Form>) {
        self.wishes.push(Command::NewPot(form));
    }

    /// Takes in what the room says.
    pub(in crate::window) fn hear(&mut self, view: &mut View) {
        self.steps = view.steps;
        if let Some(reason) = view.no_step.take() {
            self.said = Some((Instant::now(), reason));
        }
        self.said.take_if(|(at, _)| at.elapsed() > SAID_FOR);
    }

    /// What the person asked for, in order.
    pub(in crate::window) fn take_wishes(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.wishes)
    }

    /// Lays out the controls, for who may change what is on the wheel.
    pub(super) fn show(&mut self, ui: &mut egui::Ui, words: &Words, may_change: bool) {
        let StepsWire { back, forth, is_remaking } = self.steps;
        ui.horizontal(|ui| {
            if !may_change {
                ui.disable();
            }
            let undo = egui::Button::new(words.say("undo"));
            if ui.add_enabled(back > 0, undo).on_hover_text(words.keys("Ctrl + Z")).clicked() {
                self.undo();
            }
            let redo = egui::Button::new(words.say("redo"));
            if ui.add_enabled(forth > 0, redo).on_hover_text(words.keys("Ctrl + Y")).clicked() {
                self.redo();
            }
            ui.menu_button(words.say("new-pot"), |ui| {
                let forms = Form::ALL.map(|form| (Some(form), words.say(&format!("form-{}", form.name()))));
                for (form, name) in [(None, words.say("new-pot-again"))].into_iter().chain(forms) {
                    if ui.button(name).on_hover_text(words.say("new-pot-hint")).clicked() {
                        self.begin_anew(form);
                        ui.close();
                    }
                }
            });
        });
        let said = match self.said {
            Some((_, NoStep::NoPot)) => Some("no-pot"),
            Some((_, NoStep::NothingBack)) => Some("no-undo"),
            Some((_, NoStep::NothingForth)) => Some("no-redo"),
            None => is_remaking.then_some("remaking"),
        };
        if let Some(said) = said {
            ui.label(RichText::new(words.say(said)).small());
        }
    }
}
