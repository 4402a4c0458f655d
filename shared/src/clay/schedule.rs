//! A setting that changes at known ticks.
//!
//! The wheel's speed has its own place in `wheel`, since its effect adds up; everything else that all must change at
//! the same sub-step stands in one of these.
//! Invariant: entries ascend in tick and there is always one.

use alloc::vec::Vec;

use crate::units::Tick;

/// The value of a setting as a pure function of the tick.
#[derive(Clone, Debug, PartialEq)]
pub struct Schedule<T> {
    entries: Vec<(Tick, T)>,
}

impl<T: Copy + Default> Default for Schedule<T> {
    fn default() -> Self {
        Self::new(T::default())
    }
}

impl<T: Copy> Schedule<T> {
    /// Most values kept, as many as a wheel keeps speeds; older ones are forgotten first.
    const ENTRIES_MAX: usize = 256;

    /// A setting that has always been `value`.
    #[must_use]
    pub fn new(value: T) -> Self {
        Self { entries: alloc::vec![(Tick(0), value)] }
    }

    /// The value at a tick; the oldest known one for ticks before it.
    #[must_use]
    pub fn at(&self, tick: Tick) -> T {
        let later = self.entries.partition_point(|(from, _)| *from <= tick);
        self.entries[later.saturating_sub(1)].1
    }

    /// Every known value and the tick from which it holds, earliest first.
    pub fn entries(&self) -> impl Iterator<Item = (Tick, T)> + '_ {
        self.entries.iter().copied()
    }

    /// Takes `value` from tick `from` on; whatever was scheduled for later is dropped.
    pub fn set(&mut self, from: Tick, value: T) {
        let keep = self.entries.partition_point(|(at, _)| *at < from);
        self.entries.truncate(keep);
        if self.entries.len() == Self::ENTRIES_MAX {
            self.entries.remove(0);
        }
        self.entries.push((from, value));
    }
}
