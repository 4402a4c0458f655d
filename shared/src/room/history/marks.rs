//! Clay that is kept along the log, so that little has to be pressed again: near now often, farther back ever more rarely.
//!
//! Owns which clay is kept and its bounds; knows no strokes.
//! Invariant: marks ascend, and the clay of each is what pressing the log from the mark before it makes.

use alloc::collections::VecDeque;

use crate::clay::{Conditions, Pot};
use crate::snapshot::{KeptClay, Touched};
use crate::units::Tick;

/// A place in the log, between two spans.
#[derive(Clone, Copy, Debug)]
pub(super) struct Place {
    /// The span that follows.
    pub(super) span: u64,
    /// Samples before it, since the wheel began.
    pub(super) pressed: u64,
    /// When it was come to.
    pub(super) tick: Tick,
}

/// Clay that is kept.
#[derive(Debug)]
pub(super) struct Mark {
    pub(super) place: Place,
    pub(super) clay: KeptClay,
    pub(super) conditions: Conditions,
    /// Bytes that it takes beside the mark before it.
    bytes: usize,
}

impl Mark {
    fn bytes_beside(&self, other: &Self) -> usize {
        let settings = self.conditions.wheel.segments().count() + self.conditions.material.entries().count();
        size_of::<Self>() + 16 * (settings + self.clay.tiles()) + self.clay.unshared_bytes(&other.clay)
    }
}

/// The marks of a log.
#[derive(Debug)]
pub(super) struct Marks(VecDeque<Mark>);

impl Marks {
    /// How far back every stroke can be undone.
    const TICKS: i64 = 600_000;
    /// Longest time that marks are thinned out to: what was pressed is forgotten no later than so long after it need not be known any more.
    const GAP_TICKS: i64 = 300_000;
    /// Most bytes kept beside the oldest clay; where that is long, eight times as many as it takes.
    const BYTES_MAX: usize = 12 << 20;

    /// A pot that was just put on the wheel.
    pub(super) fn beginning_with(pot: &Pot, conditions: &Conditions, tick: Tick) -> Self {
        let place = Place { span: 0, pressed: 0, tick };
        Self([Mark { place, clay: KeptClay::of(pot), conditions: conditions.clone(), bytes: 0 }].into())
    }

    /// The newest.
    pub(super) fn newest(&self) -> &Mark {
        self.0.back().expect("there is always one")
    }

    /// The newest in which nothing of a span is, or the oldest.
    pub(super) fn before(&self, span: u64) -> &Mark {
        let at = self.0.partition_point(|mark| mark.place.span <= span);
        &self.0[at.saturating_sub(1)]
    }

    /// The oldest.
    pub(super) fn oldest(&self) -> &Mark {
        &self.0[0]
    }

    /// Drops those behind the beginning of a span.
    pub(super) fn drop_behind(&mut self, span: u64) {
        let keep = self.0.partition_point(|mark| mark.place.span <= span);
        self.0.truncate(keep.max(1));
    }

    /// Keeps a pot that differs from the newest mark in the changed tiles, which are then forgotten.
    pub(super) fn keep(&mut self, place: Place, pot: &Pot, changed: &mut Touched, conditions: &Conditions) {
        let newest = self.newest();
        let clay = newest.clay.after(pot, changed);
        changed.clear();
        let mut mark = Mark { place, clay, conditions: conditions.clone(), bytes: 0 };
        mark.bytes = mark.bytes_beside(newest);
        self.0.push_back(mark);
        self.thin_out();
    }

    /// Drops marks that would save little: no gap is longer than half of what lies behind it, nor than [`Marks::GAP_TICKS`].
    fn thin_out(&mut self) {
        let now = self.newest().place.pressed;
        for at in (1..self.0.len().saturating_sub(1)).rev() {
            let (before, after) = (self.0[at - 1].place, self.0[at + 1].place);
            let is_short = after.tick.since(before.tick) <= Self::GAP_TICKS;
            if is_short && 2 * (after.pressed - before.pressed) <= now - after.pressed {
                self.0.remove(at);
                self.0[at].bytes = self.0[at].bytes_beside(&self.0[at - 1]);
            }
        }
    }

    /// Bytes that are kept.
    pub(super) fn bytes(&self) -> usize {
        self.0[0].clay.bytes() + self.bytes_beside()
    }

    fn bytes_beside(&self) -> usize {
        self.0.iter().map(|mark| mark.bytes).sum()
    }

    /// Drops the oldest mark if the next reaches back far enough, or everything takes too much beside a log of so many bytes;
    /// says which span is then the first.
    pub(super) fn forget(&mut self, now: Tick, log_bytes: usize) -> Option<u64> {
        let next = self.0.get(1)?;
        let is_old = now.since(next.place.tick) > Self::TICKS;
        let bytes_max = Self::BYTES_MAX.max(8 * self.0[0].clay.bytes());
        if !is_old && self.bytes_beside() + log_bytes <= bytes_max {
            return None;
        }
        self.0.pop_front();
        self.0[0].bytes = 0;
        Some(self.0[0].place.span)
    }
}
