//! How far ahead of the server's time a client stamps its samples.
//!
//! Steered by the slack that the server reports; holds no clock.
//! Invariant: the offset moves forward at once when samples come late, and back slowly when they wait; a change is
//! judged only by samples that were made after it, so that a backlog cannot drive the offset away.

use core::time::Duration;

use crate::units::Tick;

/// The offset between a client's own count of ticks and the ticks it stamps.
#[derive(Clone, Copy, Debug)]
pub struct Lead {
    offset: i64,
    changed_at: Duration,
    /// Number of the first sample that surely was stamped with this offset.
    stamped_from: u32,
}

impl Lead {
    /// Slack aimed at, in ticks: a late burst of the scheduler should not make a sample late.
    const TARGET: i16 = 6;
    /// Slack above which samples wait longer than they need to.
    const TOO_MUCH: i16 = 18;
    /// Slack near which the server begins to refuse samples: back at once.
    const FAR: i16 = 1000;
    /// A change back needs time to be felt as nothing.
    const PATIENCE_BACK: Duration = Duration::from_millis(120);
    /// Most ticks forward at one time: a repeated sample is later than the line is slow.
    const FORWARD_MAX: i64 = 100;
    /// Most ticks back at one time: the tool rests for as long, and may then move no faster than a hand.
    const BACK_MAX: i64 = 4;
    /// Samples that may be on their way out of the hand when the offset changes.
    const ON_THE_WAY: u32 = 16;

    /// A lead that makes local tick `local` stamp the server's tick `server`, plus `ahead` ticks.
    #[must_use]
    pub const fn new(local: u64, server: Tick, ahead: u64) -> Self {
        Self { offset: (server.0 + ahead) as i64 - local as i64, changed_at: Duration::ZERO, stamped_from: 0 }
    }

    /// What to add to a local tick.
    #[must_use]
    pub const fn offset(&self) -> i64 {
        self.offset
    }

    /// Takes in the worst slack of a pulse that acknowledges all samples below `acknowledged`, while `next` is the
    /// number of the next sample.
    pub fn handle_slack(&mut self, slack: i16, acknowledged: u32, next: u32, now: Duration) {
        if (acknowledged.wrapping_sub(self.stamped_from) as i32) < 0 {
            return;
        }
        let excess = i64::from(slack) - i64::from(Self::TARGET);
        let change = if slack < 1 {
            (-excess).min(Self::FORWARD_MAX)
        } else if slack > Self::FAR {
            -excess
        } else if slack > Self::TOO_MUCH && now.saturating_sub(self.changed_at) >= Self::PATIENCE_BACK {
            -(excess / 32).clamp(1, Self::BACK_MAX)
        } else {
            return;
        };
        self.offset += change;
        self.changed_at = now;
        // a small step back shows too little to be waited for
        if !(-Self::BACK_MAX..=0).contains(&change) {
            self.stamped_from = next.wrapping_add(Self::ON_THE_WAY);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn backlog_moves_the_offset_once() {
        let mut lead = Lead::new(0, Tick(0), 0);
        for pulse in 0..60 {
            lead.handle_slack(-3000, 10 * pulse, 1000, Duration::from_millis(u64::from(pulse) * 16));
        }
        assert_eq!(lead.offset(), Lead::FORWARD_MAX);
        lead.handle_slack(-3000, 1016, 2000, Duration::from_secs(2));
        assert_eq!(lead.offset(), 2 * Lead::FORWARD_MAX);
    }

    #[test]
    fn slack_far_too_large_is_taken_back_at_once() {
        let mut lead = Lead::new(0, Tick(5000), 0);
        lead.handle_slack(1400, 0, 10, Duration::ZERO);
        assert_eq!(lead.offset(), 5000 - 1400 + i64::from(Lead::TARGET));
        lead.handle_slack(i16::MIN, 26, 30, Duration::from_secs(1));
        assert_eq!(lead.offset(), 3706);
    }
}
