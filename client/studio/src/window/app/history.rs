//! Undo and redo in the window: what the person asks for, and why there was nothing to undo.
//!
//! Owns what was asked for until it is sent; what can be undone is the room's to say.
//! Invariant: a sentence that says why nothing was undone stays for [`SAID_FOR`] and no longer.

use std::time::{Duration, Instant};

use pottery_client::Command;
use pottery_client::view::View;
use pottery_shared::protocol::NoStep;

/// How long a sentence stays.
const SAID_FOR: Duration = Duration::from_secs(4);

/// Steps back and forth of one window.
#[derive(Debug, Default)]
pub(super) struct History {
    wishes: Vec<Command>,
    said: Option<(Instant, NoStep)>,
}

impl History {
    pub(super) fn undo(&mut self) {
        self.wishes.push(Command::Undo);
    }

    pub(super) fn redo(&mut self) {
        self.wishes.push(Command::Redo);
    }

    pub(super) fn begin_anew(&mut self) {
        self.wishes.push(Command::NewPot);
    }

    /// Takes in what the room says.
    pub(super) fn hear(&mut self, view: &mut View) {
        if let Some(reason) = view.no_step.take() {
            self.said = Some((Instant::now(), reason));
        }
        self.said.take_if(|(at, _)| at.elapsed() > SAID_FOR);
    }

    /// Why the last step was none, for a while.
    pub(super) fn said(&self) -> Option<String> {
        self.said.map(|(_, reason)| reason.to_string())
    }

    /// What the person asked for, in order.
    pub(super) fn take_wishes(&mut self) -> Vec<Command> {
        std::mem::take(&mut self.wishes)
    }
}
