//! How much a peer may ask for.
//!
//! Owns the rule and its state; what a request costs is for the room to say.
//! Invariant: for long, no more is granted than one plain request in [`Allowance::TICKS_PER_REQUEST`] ticks.

use crate::units::Tick;

/// What one peer may still ask for.
#[derive(Clone, Copy, Debug, Default)]
pub struct Allowance {
    /// What requests have cost and time has not yet paid off, in ticks.
    spent_ticks: i64,
    spent_at: Tick,
}

impl Allowance {
    const TICKS_PER_REQUEST: i64 = 50;
    const TICKS_AT_ONCE: i64 = 2000;

    /// Whether a request may be answered: a person makes at most twenty plain ones a second for long, and a few at once.
    ///
    /// `cost` is what it costs the server, 1 for a plain one.
    pub fn grant(&mut self, now: Tick, cost: i64) -> bool {
        let unpaid = (self.spent_ticks - now.since(self.spent_at)).max(0);
        let spent = unpaid + cost * Self::TICKS_PER_REQUEST;
        if spent > Self::TICKS_AT_ONCE {
            return false;
        }
        (self.spent_ticks, self.spent_at) = (spent, now);
        true
    }
}
