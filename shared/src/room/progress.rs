//! How far the pot of every wheel is from what it is to become, told to who teaches while it changes.
//!
//! Owns whose turn it is to be compared, and as what each was compared last; the comparison is the target's.
//! Invariant: one wheel is compared in [`COMPARE_EVERY`] ticks, however many there are, and none whose clay has not changed.

use alloc::vec::Vec;

use super::{Lane, Room};
use crate::clay::{Deviation, Target};
use crate::protocol::{Notice, ProgressWire, Role};
use crate::session::{Peer, target_of, target_wire};

/// Ticks from one comparison to the next: one takes a few tenths of a millisecond, and a class of 24 wheels has been through in 0.6 s.
const COMPARE_EVERY: u64 = 25;

/// Whose turn it is.
#[derive(Debug, Default)]
pub(super) struct Progress {
    next: usize,
    /// The digest of each wheel's clay when it was compared.
    compared: Vec<Option<u64>>,
}

impl Room {
    /// Begins anew: pots are to become something else, or nothing any more, or there is a teacher who knows of none.
    pub(super) fn begin_progress(&mut self) {
        self.guidance.progress.compared.clear();
        if self.guidance.target.is_none() {
            self.tell_progress(Vec::new());
        }
    }

    /// Compares the next wheel whose clay has changed, if it is time and somebody teaches.
    pub(super) fn compare_next(&mut self) {
        if !self.now.0.is_multiple_of(COMPARE_EVERY) || !self.people.here().any(|(_, who, _)| who.role == Role::Teacher)
        {
            return;
        }
        let Some(target) = self.guidance.target.as_ref().and_then(target_of) else { return };
        let (wheels, progress) = (self.benches.len(), &mut self.guidance.progress);
        progress.compared.resize(wheels, None);
        let mut turns = (0..wheels).map(|at| (progress.next + at) % wheels);
        let due = turns.find(|&place| progress.compared[place] != Some(self.benches[place].digest()));
        let Some(place) = due else { return };
        (progress.next, progress.compared[place]) = (place + 1, Some(self.benches[place].digest()));
        let pot = self.benches[place].pot();
        let Deviation { rms_m, most_m, most_at_m, .. } = target.deviation(pot);
        let is = target_wire(&Target::of(pot));
        self.tell_progress(alloc::vec![ProgressWire { wheel: place as u16 + 1, is, rms_m, most_m, most_at_m }]);
    }

    fn tell_progress(&mut self, progress: Vec<ProgressWire>) {
        let teachers: Vec<_> =
            self.people.here().filter(|(_, who, _)| who.role == Role::Teacher).map(|(_, _, peer)| peer).collect();
        let notice = Peer::notice(&Notice::Progress(progress));
        for to in teachers {
            self.send(to, Lane::Control(notice.clone()));
        }
    }
}
