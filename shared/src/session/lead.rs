//! How far ahead of the server's time a client stamps its samples.
//!
//! Steered by the slack that the server reports; holds no clock.
//! Invariant: a change is judged only by samples that were made after it, so that a backlog cannot drive the offset away; and
//! whatever the server says, the offset stays within [`Lead::AWAY_MAX`] of what its welcome told, and a thousandth of the time
//! since.
//!
//! Of the slacks of the last two seconds the least counts: a line whose packets are late by 0 to 60 ms needs a lead for the
//! latest of them, and one early packet is no reason to stamp closer. What is too little is made up for at once, since a
//! sample that comes late is pressed late; what is too much is given back a few ticks at a time, since the tool rests for as
//! long.

use core::time::Duration;

use crate::units::Tick;

/// The offset between a client's own count of ticks and the ticks it stamps.
#[derive(Clone, Copy, Debug)]
pub struct Lead {
    offset: i64,
    /// The offset with no lead at all, as the welcome told it.
    origin: i64,
    /// The client's count of ticks at the welcome.
    welcomed: u64,
    /// The offset with no lead, as the quickest word of the server's time told it.
    heard: i64,
    /// The least slack in each of the last spans of time, the running one first.
    least: [Option<i16>; Self::SPANS],
    span_began: Duration,
    changed_at: Duration,
    /// Number of the first sample that surely was stamped with this offset.
    stamped_from: u32,
}

impl Lead {
    /// Slack aimed at, in ticks: a late burst of the scheduler should not make a sample late.
    const TARGET: i64 = 6;
    /// Slack up to which more is wanted.
    const LITTLE: i64 = 2;
    /// Least slack of all spans above which samples wait longer than they need to.
    const TOO_MUCH: i64 = 9;
    /// Slack near which the server begins to refuse samples: back at once.
    const FAR: i64 = 1000;
    /// A change back, or by a single tick, needs time to be felt as nothing.
    const PATIENCE: Duration = Duration::from_millis(120);
    /// Most ticks forward at one time: a repeated sample is later than the line is slow.
    const FORWARD_MAX: i64 = 100;
    /// Most ticks back at one time: the tool rests for as long, and may then move no faster than a hand.
    const BACK_MAX: i64 = 4;
    /// Share of what is too much that is given back at one time.
    const BACK_SHARE: i64 = 8;
    /// Ticks by which a welcome was slower than what came after it that count as lost and sent again: no jitter.
    const STALE: i64 = 50;
    /// Ticks after the welcome in which that is looked at: later it would be a clock that drifts.
    const WELCOME_TICKS: u64 = 5000;
    /// Samples that may be on their way out of the hand when the offset changes.
    const ON_THE_WAY: u32 = 16;
    /// Spans whose least slacks are kept.
    const SPANS: usize = 8;
    /// Length of a span.
    const SPAN: Duration = Duration::from_millis(250);
    /// Farthest that the offset goes from what the welcome told: a line that is silent for longer is given up.
    pub const AWAY_MAX: i64 = 12_000;
    /// Ticks in which clocks may drift apart by one more; those of computers need ten times as many.
    const DRIFT_TICKS: u64 = 1000;

    /// A lead that makes local tick `local` stamp the server's tick `server`, plus `ahead` ticks.
    #[must_use]
    pub const fn new(local: u64, server: Tick, ahead: u64) -> Self {
        let origin = server.0 as i64 - local as i64;
        Self {
            offset: origin + ahead as i64,
            origin,
            welcomed: local,
            heard: origin,
            least: [None; Self::SPANS],
            span_began: Duration::ZERO,
            changed_at: Duration::ZERO,
            stamped_from: 0,
        }
    }

    /// What to add to a local tick.
    #[must_use]
    pub const fn offset(&self) -> i64 {
        self.offset
    }

    /// Takes in that the server was at `server` when it sent what is here at the client's tick `local`, while `next` is the number of the next
    /// sample.
    ///
    /// A welcome that was lost and sent again tells a time that is long gone. Without this a hand that presses at once is late by as much, and makes
    /// that up a tenth of a second in a way and back.
    pub fn handle_tick(&mut self, server: Tick, local: u64, next: u32, now: Duration) {
        // farther ahead than this is nobody's clock, and the change is bounded anyway
        let server = server.0.min(1 << 48) as i64;
        let quicker = server.saturating_sub(local as i64).saturating_sub(self.heard);
        if quicker > Self::STALE && local.saturating_sub(self.welcomed) < Self::WELCOME_TICKS {
            self.heard += quicker;
            self.change(quicker, next, now);
        }
    }

    /// Takes in the worst slack of a pulse that acknowledges all samples below `acknowledged`, while `next` is the
    /// number of the next sample.
    pub fn handle_slack(&mut self, slack: i16, acknowledged: u32, next: u32, now: Duration) {
        if (acknowledged.wrapping_sub(self.stamped_from) as i32) < 0 {
            return;
        }
        self.note(slack, now);
        let slack = i64::from(slack);
        let is_time = now.saturating_sub(self.changed_at) >= Self::PATIENCE;
        if slack < 1 {
            self.change((Self::TARGET - slack).min(Self::FORWARD_MAX), next, now);
        } else if slack > Self::FAR {
            self.change(Self::TARGET - slack, next, now);
        } else if slack <= Self::LITTLE && is_time {
            self.change(1, next, now);
        } else if is_time
            && let Some(least) = self.least_of_all()
            && least > Self::TOO_MUCH
        {
            self.change(-((least - Self::TARGET) / Self::BACK_SHARE).clamp(1, Self::BACK_MAX), next, now);
        }
    }

    fn note(&mut self, slack: i16, now: Duration) {
        if now.saturating_sub(self.span_began) >= Self::SPAN {
            self.least.rotate_right(1);
            self.least[0] = None;
            self.span_began = now;
        }
        let least = &mut self.least[0];
        *least = Some(least.map_or(slack, |least| least.min(slack)));
    }

    /// The least slack, once every span has one.
    fn least_of_all(&self) -> Option<i64> {
        let known = self.least.iter().flatten();
        (known.clone().count() == Self::SPANS).then(|| known.min().copied().map(i64::from))?
    }

    fn change(&mut self, ticks: i64, next: u32, now: Duration) {
        let drift = (now.as_millis() as u64).saturating_sub(self.welcomed) / Self::DRIFT_TICKS;
        let away = Self::AWAY_MAX + drift as i64;
        let before = self.offset;
        self.offset = (before + ticks).clamp(self.origin - away, self.origin + away);
        let ticks = self.offset - before;
        self.changed_at = now;
        if ticks.abs() <= Self::BACK_MAX {
            // what was seen would have been seen with so much more or less to spare
            for least in self.least.iter_mut().flatten() {
                *least = least.saturating_add(ticks as i16);
            }
        } else {
            // a small step shows too little to be waited for
            self.least = [None; Self::SPANS];
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
        assert_eq!(lead.offset(), 5000 - 1400 + Lead::TARGET);
        lead.handle_slack(i16::MIN, 26, 30, Duration::from_secs(1));
        assert_eq!(lead.offset(), 3706);
    }

    #[test]
    fn welcome_that_was_sent_again_is_made_up_for_by_the_first_pulse() {
        let mut lead = Lead::new(1000, Tick(5000), 30);
        for (local, server) in [(1010, 5010), (1020, 5049), (1030, 5900), (1046, 5916), (1062, 5900)] {
            lead.handle_tick(Tick(server), local, 0, Duration::from_millis(local));
        }
        // the welcome was 870 ms on its way longer than the third pulse
        assert_eq!(lead.offset(), 4000 + 30 + 870);
        lead.handle_tick(Tick(90_000), 7000, 0, Duration::from_secs(7));
        assert_eq!(lead.offset(), 4900);
        let mut lead = Lead::new(1000, Tick(5000), 30);
        lead.handle_tick(Tick(u64::MAX), 1010, 0, Duration::ZERO);
        assert_eq!(lead.offset(), 4000 + Lead::AWAY_MAX);
    }

    #[test]
    fn early_packets_alone_take_nothing_back() {
        let mut lead = Lead::new(0, Tick(0), 50);
        // one in twenty has but 5 ticks to spare
        for pulse in 0..600_u32 {
            let slack = if pulse.is_multiple_of(20) { 5 } else { 60 };
            lead.handle_slack(slack, 10 * pulse, 10 * pulse + 90, Duration::from_millis(u64::from(pulse) * 16));
        }
        assert_eq!(lead.offset(), 50);
    }

    #[test]
    fn a_server_that_claims_anything_moves_the_offset_within_bounds() {
        for claimed in [i16::MIN, -1, 0, 1, 2, 1001, i16::MAX] {
            let mut lead = Lead::new(7_000_000, Tick(90_000), 30);
            for pulse in 0..100_000_u32 {
                let now = Duration::from_millis(7_000_000 + u64::from(pulse) * 16);
                lead.handle_slack(claimed, u32::MAX / 4 + 1000 * pulse, 17 * pulse, now);
                let away = lead.offset() - (90_000 - 7_000_000);
                assert!(away.abs() <= Lead::AWAY_MAX + i64::from(pulse) * 16 / 1000, "{claimed}: {away} at {pulse}");
            }
        }
    }
}
