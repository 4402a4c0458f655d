//! A window that goes from a wheel to looking on, or comes from there.
//!
//! Owns what is handed over: window, device and view; who goes where is the visit's.
//! Invariant: the clay that was drawn last is drawn until the other's is.

use std::time::Instant;

use pottery_client::Potter;
use pottery_client::view::SharedView;

use super::App;
use crate::window::stage::Seen;

impl App {
    /// The same, for a visitor, who may look on instead; or for who may not.
    pub(in crate::window) fn for_visitor(mut self, is_one: bool) -> Self {
        self.panel.looks_on = is_one.then_some(false);
        self
    }

    /// Whether the person wants to look on instead, said once.
    pub(in crate::window) fn wants_to_look_on(&mut self) -> bool {
        let wants = self.panel.looks_on.as_mut().is_some_and(std::mem::take);
        if wants {
            // why it could not be the last time is said no longer
            self.refusal = None;
        }
        wants
    }

    /// Lifts the tool; what there is to see, to know when everything pressed is confirmed.
    pub(in crate::window) fn lift(&mut self) -> SharedView {
        self.potter.status().lift(true);
        self.potter.view().clone()
    }

    /// Works on after all, and says why.
    pub(in crate::window) fn stay(&mut self, reason: String) {
        self.potter.status().lift(false);
        self.refusal = Some((Instant::now(), reason));
        self.is_dirty = true;
    }

    /// Takes over a window that showed this wheel.
    pub(in crate::window) fn go_on(&mut self, seen: Option<Seen>) {
        let Some(Seen { mut stage, overlay, camera }) = seen else { return };
        let mut view = self.potter.view().lock();
        stage.show_pot(view.picture.drawn());
        view.changed.clear();
        drop(view);
        stage.window.set_title("Pottery studio");
        stage.gpu().name().clone_into(&mut self.panel.adapter);
        self.camera = camera;
        (self.stage, self.overlay) = (Some(stage), Some(overlay));
        self.is_dirty = true;
    }

    /// The potter, to leave with, and the window.
    pub(in crate::window) fn give_up(self) -> (Potter, Option<Seen>) {
        let seen = self.stage.zip(self.overlay);
        (self.potter, seen.map(|(stage, overlay)| Seen { stage, overlay, camera: self.camera }))
    }
}
