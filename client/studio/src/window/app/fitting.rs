//! A device that is fitted to the hand: what the card, the key and the device's own button ask for.
//!
//! Owns the order of steps towards device and preferences; the card itself is `window/fitting.rs`.
//! Invariant: while the hand is measured the device has no tool and no force, and whatever ends the fitting gives both back.

use std::time::Instant;

use pottery_client::device::{Fitting, Step};

use super::App;
use crate::preferences::KeptFit;
use crate::window::fitting::{Answer, Shown};

impl App {
    /// Whether a hand is being measured.
    pub(super) fn is_fitting(&self) -> bool {
        self.panel.fitting.is_some_and(|shown| shown.fitting.step() != Step::Done)
    }

    /// Takes in where the device is, and what the person asked for since the last picture.
    pub(super) fn fit(&mut self) {
        let Some(monitor) = &self.held.monitor else { return };
        let is_pressed = monitor.is_pressed();
        let was_pressed = std::mem::replace(&mut self.device_was_pressed, is_pressed);
        if let Some(shown) = self.panel.fitting.as_mut().filter(|shown| shown.fitting.step() != Step::Done) {
            let place_m = monitor.place_m();
            shown.is_there = place_m.is_some();
            if let Some(place_m) = place_m {
                shown.fitting.see(place_m);
            }
            if is_pressed && !was_pressed {
                self.panel.fitting_answer.get_or_insert(Answer::GoOn);
            }
        }
        if let Some(answer) = self.panel.fitting_answer.take() {
            self.answer_fitting(answer);
        }
    }

    /// Does what was asked for; of what cannot be fitted, it says so.
    pub(super) fn answer_fitting(&mut self, answer: Answer) {
        let Some(monitor) = &self.held.monitor else {
            self.refusal = Some((Instant::now(), self.panel.words.say("no-fitting")));
            return;
        };
        let Some(Shown { mut fitting, is_there }) = self.panel.fitting else {
            if matches!(answer, Answer::Begin | Answer::GoOn) {
                monitor.set_fitting(true);
                self.panel.fitting = Some(Shown { fitting: Fitting::new(monitor.fit()), is_there: true });
            }
            return;
        };
        match answer {
            Answer::Begin => {}
            Answer::GoOn if fitting.step() == Step::Done => {
                self.panel.fitting = None;
                self.panel.liking.fits.insert(self.held.name.to_owned(), KeptFit::of(fitting.fit()));
                return;
            }
            Answer::GoOn => {
                // where it is now and not where it was at the last picture, which may be long ago on a busy machine
                if let Some(place_m) = monitor.place_m() {
                    fitting.see(place_m);
                }
                fitting.go_on();
                if fitting.step() == Step::Done {
                    monitor.fit_to(fitting.fit());
                    monitor.set_fitting(false);
                }
            }
            Answer::Scale(scale) => {
                fitting.set_scale(scale);
                monitor.fit_to(fitting.fit());
            }
            Answer::Leave => {
                monitor.fit_to(fitting.before());
                monitor.set_fitting(false);
                self.panel.fitting = None;
                return;
            }
        }
        self.panel.fitting = Some(Shown { fitting, is_there });
    }
}
