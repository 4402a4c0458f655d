//! Undo and redo at one wheel: who asks for it and what they are told, and clay that was made again taking its place.
//!
//! Owns the requests that wait for their tick; what can be undone is the history's.
//! Invariant: clay is replaced at a snapshot and never between two, and everybody at the wheel gets it in the same one.

use alloc::collections::{BTreeMap, BTreeSet};
use alloc::sync::Arc;
use alloc::vec::Vec;

use super::Bench;
use crate::clay::Pot;
use crate::protocol::{Notice, StepsWire};
use crate::room::history::{Anew, History, Step};
use crate::room::journal::Happening;
use crate::room::{Lane, Outbox, PeerId, Transmit};
use crate::session::Peer;
use crate::snapshot::{TileLayout, Version, quantise, steps_of};
use crate::units::Tick;

/// A step that somebody asked for, to be done when everything up to a tick has been pressed.
#[derive(Clone, Debug)]
pub(super) struct Wish {
    peer: PeerId,
    step: Step,
    held: Tick,
}

impl Wish {
    /// Whether a peer brought clay for it.
    pub(super) const fn is_clay_of(&self, peer: PeerId) -> bool {
        self.peer.0 == peer.0 && matches!(self.step, Step::Anew(Anew::Clay(_)))
    }
}

/// Most steps of one peer that wait at one time: somebody who asks for more hammers at a key.
const WISHES_MAX: usize = 16;
/// Ticks that a step waits at most: as far as samples may be ahead.
const WAIT_MAX: i64 = 1_500;

impl Bench {
    /// Takes in that a peer, whose newest sample is of tick `held`, wants to undo or redo a stroke.
    pub(in crate::room) fn ask_step(&mut self, peer: PeerId, step: Step, held: u64, now: Tick) {
        if self.wishes.iter().filter(|wish| wish.peer == peer).count() < WISHES_MAX {
            let held = Tick(held.min(now.offset(WAIT_MAX).0));
            self.wishes.push_back(Wish { peer, step, held });
        }
    }

    /// Does the steps that are due, and so much of the work they make; twice what was pressed in this tick comes on top, so
    /// that clay made again catches up with any number of people.
    pub(super) fn go_back_and_forth(&mut self, tick: Tick, samples: u32, outbox: &mut Outbox) {
        // each person's in their order; nobody waits for another's
        let mut waiting = BTreeSet::new();
        for _ in 0..self.wishes.len() {
            let Some(wish) = self.wishes.pop_front() else { break };
            let Some(seat) = self.seats.get(&wish.peer) else { continue };
            let is_early = wish.held > tick || self.history.recalls_for_another(seat.client);
            if is_early || waiting.contains(&wish.peer) {
                waiting.insert(wish.peer);
                self.wishes.push_back(wish);
                continue;
            }
            if let Err(reason) = self.history.step(wish.step, seat.client, wish.held, &self.pot) {
                outbox
                    .push_back(Transmit { to: wish.peer, lane: Lane::Control(Peer::notice(&Notice::NoStep(reason))) });
            }
        }
        self.history.go_on(&mut self.substep, &self.pot, samples + 2 * self.pressed_in_tick, tick);
        self.pressed_in_tick = 0;
    }

    /// Whether there is clay to be made again here.
    pub(in crate::room) const fn is_remaking(&self) -> bool {
        self.history.is_remaking()
    }

    /// Takes in that time has passed, also where nobody is.
    pub(in crate::room) fn note_time(&mut self, now: Tick) {
        self.history.note_time(now);
    }

    pub(in crate::room) const fn history(&self) -> &History {
        &self.history
    }

    /// The tiles of what is no skin that are not as in a pot nobody has touched.
    pub(super) fn folds(&self) -> Vec<(u8, u32, Arc<[u16]>)> {
        let (spec, even) = (self.pot.spec(), quantise(self.pot.spec().radius.0));
        let folds = (0..).zip(self.pot.surfaces()).skip(spec.skins());
        let tiles = folds.flat_map(|(number, folds)| {
            let layout = TileLayout::new(folds.shape());
            (0..layout.tiles()).map(move |tile| (number, tile, steps_of(folds, layout.window(tile))))
        });
        tiles.filter(|(_, _, steps)| steps.iter().any(|step| *step != even)).collect()
    }

    /// Puts other clay of the same grid in the place of the clay, in every tile that differs.
    pub(super) fn replace(&mut self, tick: Tick, pot: &Pot) {
        let mut tiles = Vec::new();
        for (number, new) in pot.surfaces().iter().enumerate() {
            let layout = TileLayout::new(new.shape());
            for tile in 0..layout.tiles() {
                let window = layout.window(tile);
                let rows = window.first_row as usize..window.end_row() as usize;
                let mut columns = window.first_column..window.first_column + window.columns;
                let old = &self.pot.surfaces()[number];
                if columns.any(|column| old.column_m(column)[rows.clone()] != new.column_m(column)[rows.clone()]) {
                    self.pot.copy_window(pot, number, window);
                    self.touched.add(number, tile);
                    tiles.push((number as u8, tile, steps_of(new, window)));
                }
            }
        }
        if let Some(journal) = &mut self.journal {
            journal.note(tick, Happening::Replaced(tiles));
        }
        // what was pressed does not lead there
        self.transcript = None;
    }

    /// Brings everybody who needs it the newest snapshot in a keyframe, since it was too much to tell.
    pub(super) fn bring_clay(&self, is_for: impl Fn(bool) -> bool, outbox: &mut Outbox) {
        let since = self.author.latest().0.saturating_sub(1);
        let mut made = BTreeMap::new();
        for (&to, seat) in self.present().filter(|(_, seat)| is_for(seat.retells)) {
            let goes_on = !seat.retells;
            let bytes = made.entry(goes_on).or_insert_with(|| self.author.keyframe(Version(since), goes_on));
            self.send_keyframe(to, since, 0, bytes.clone(), outbox);
        }
    }

    /// Tells each what can be undone and redone now, where that is not what they have heard.
    pub(super) fn tell_steps(&mut self, outbox: &mut Outbox) {
        let is_remaking = self.is_remaking();
        for (&to, seat) in self.seats.iter_mut().filter(|(_, seat)| !seat.leaving) {
            let (back, forth) = self.history.counts(seat.client);
            let [back, forth] = [back, forth].map(|steps| u16::try_from(steps).unwrap_or(u16::MAX));
            let steps = StepsWire { back, forth, is_remaking };
            if seat.told_steps != steps {
                seat.told_steps = steps;
                let notice = Peer::notice(&Notice::Steps(steps));
                outbox.push_back(Transmit { to, lane: Lane::Control(notice) });
            }
        }
    }
}
