//! Clay of an earlier time, made again beside the clay that people work at, for a teacher who goes back to it.
//!
//! Owns how far it is; what is undone stays undone in it, and it is put on the wheel as any other clay.
//! Invariant: nothing is taken from the log: going back is a step more, which can be taken back.

use super::remake::Remake;
use super::{Anew, History};
use crate::clay::{Pot, SubStep};
use crate::snapshot::KeptClay;
use crate::units::Tick;

/// Clay of an earlier time on its way.
#[derive(Debug)]
pub(super) struct Recall {
    /// Who wants it.
    client: u16,
    /// The first span that is not in it any more.
    until: u64,
    made: Option<Remake>,
}

impl Recall {
    /// Whether it is that client who wants it.
    pub(super) const fn is_of(&self, client: u16) -> bool {
        self.client == client
    }

    /// Begins again, since what it is made of has changed.
    pub(super) fn restart(&mut self) {
        self.made = None;
    }
}

impl History {
    /// The earliest tick to which the wheel can go back.
    pub(in crate::room) fn oldest(&self) -> Tick {
        let first = self.marks.oldest().place;
        self.log.since(first.span).unwrap_or(first.tick)
    }

    /// Makes the clay of a tick and puts it on the wheel when it is made, as a step of a client.
    ///
    /// # Errors
    /// The earliest tick that there is, when that is later.
    pub(in crate::room) fn go_back(&mut self, client: u16, to: Tick) -> Result<(), Tick> {
        if to < self.oldest() {
            return Err(self.oldest());
        }
        self.recall = Some(Recall { client, until: self.log.after(to), made: None });
        Ok(())
    }

    /// Puts clay on the wheel at the next snapshot, as a step of a client.
    pub(in crate::room) fn put(&mut self, client: u16, clay: KeptClay) {
        self.anew = Some((client, Anew::Clay(clay)));
    }

    /// Whether clay of an earlier time is on its way for another client: what is asked for meanwhile waits, or it would never be there.
    pub(in crate::room) fn recalls_for_another(&self, client: u16) -> bool {
        self.recall.as_ref().is_some_and(|recall| !recall.is_of(client))
    }

    /// Whether there is something to do although nobody is at the wheel.
    pub(in crate::room) const fn has_work(&self) -> bool {
        self.anew.is_some() || self.recall.is_some() || self.is_remaking()
    }

    /// Presses so many samples again on the way to the clay that is wanted; `pot` is the wheel's.
    pub(super) fn recall_on(&mut self, substep: &mut SubStep, pot: &Pot, samples: u32) {
        let Some(recall) = &mut self.recall else { return };
        let made = recall.made.get_or_insert_with(|| {
            self.strokes.leave_out_from(0);
            let mark = self.marks.before(recall.until);
            let mut pot = pot.clone();
            mark.clay.lay_on(&mut pot, &mut self.since_mark.emptied());
            Remake::starting_from(pot, mark.conditions.clone(), mark.place.span)
        });
        let mut left = samples;
        while left > 0 && made.span() < recall.until {
            let work = made.go_on(&self.log, &self.strokes, substep, left);
            left = left.saturating_sub(work.pressed.max(1));
            self.remade += u64::from(work.pressed);
        }
        if made.span() >= recall.until {
            let (client, clay) = (recall.client, KeptClay::of(made.pot()));
            self.recall = None;
            self.put(client, clay);
        }
    }
}
