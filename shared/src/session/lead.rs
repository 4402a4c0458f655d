//! How far ahead of the server's time a client stamps its samples.
//!
//! Steered by the slack that the server reports; holds no clock.
//! Invariant: the offset moves forward at once when samples come late, and back slowly when they wait.

use core::time::Duration;

use crate::units::Tick;

/// The offset between a client's own count of ticks and the ticks it stamps.
#[derive(Clone, Copy, Debug)]
pub struct Lead {
    offset: i64,
    changed_at: Duration,
}

impl Lead {
    /// Slack aimed at, in ticks: a late burst of the scheduler should not make a sample late.
    const TARGET: i16 = 6;
    /// Slack above which samples wait longer than they need to.
    const TOO_MUCH: i16 = 18;
    /// A change needs a round trip to show.
    const PATIENCE_FORWARD: Duration = Duration::from_millis(250);
    const PATIENCE_BACK: Duration = Duration::from_millis(120);
    const JUMP_MAX: i64 = 1000;

    /// A lead that makes local tick `local` stamp the server's tick `server`, plus `ahead` ticks.
    #[must_use]
    pub const fn new(local: u64, server: Tick, ahead: u64) -> Self {
        Self { offset: (server.0 + ahead) as i64 - local as i64, changed_at: Duration::ZERO }
    }

    /// What to add to a local tick.
    #[must_use]
    pub const fn offset(&self) -> i64 {
        self.offset
    }

    /// Takes in the worst slack of a pulse.
    pub fn handle_slack(&mut self, slack: i16, now: Duration) {
        let since = now.saturating_sub(self.changed_at);
        if slack < 1 && since >= Self::PATIENCE_FORWARD {
            self.offset += i64::from(Self::TARGET - slack).min(Self::JUMP_MAX);
            self.changed_at = now;
        } else if slack > Self::TOO_MUCH && since >= Self::PATIENCE_BACK {
            self.offset -= 1;
            self.changed_at = now;
        }
    }
}
