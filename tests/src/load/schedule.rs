//! When inputs are due, and how far the generator is behind.
//!
//! Holds no clock: the time since the run's beginning is an argument.
//! Invariant: every moment of the schedule is handed out once, in order, and never moved.

use std::time::Duration;

/// Moments that are a period apart.
///
/// ```
/// use std::time::Duration;
/// use pottery_tests::load::schedule::Schedule;
///
/// let ms = Duration::from_millis;
/// let mut schedule = Schedule::new(ms(3), ms(10));
/// assert_eq!(schedule.next_due(ms(2)), None);
/// assert_eq!(schedule.next_due(ms(3)), Some(ms(3)));
/// // whoever comes late gets every moment that went by, as it was
/// assert_eq!(schedule.next_due(ms(25)), Some(ms(13)));
/// assert_eq!(schedule.next_due(ms(25)), Some(ms(23)));
/// assert_eq!(schedule.next_due(ms(25)), None);
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    next: Duration,
    period: Duration,
}

impl Schedule {
    /// Begins at `first`.
    #[must_use]
    pub const fn new(first: Duration, period: Duration) -> Self {
        Self { next: first, period }
    }

    /// The next moment.
    #[must_use]
    pub const fn deadline(&self) -> Duration {
        self.next
    }

    /// The next moment if it is not after `now`.
    pub fn next_due(&mut self, now: Duration) -> Option<Duration> {
        let due = self.next;
        (due <= now).then(|| {
            self.next += self.period;
            due
        })
    }
}

/// How late the generator may be before its figures are those of the generator and not of the server.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Punctuality {
    /// Largest 99th percentile of how late a send begins. Those who only look on may be as late as that, or by a snapshot's period
    /// where that is longer: whoever reads what came later than that makes it older than the server did.
    pub lag_max: Duration,
}

impl Punctuality {
    /// A send that begins this many times `lag_max` late is not the send that was due: it is counted as dropped, and what it
    /// should have carried goes with the next.
    pub const DROPPED_AFTER: u32 = 10;
    /// Largest share of dropped sends.
    pub const DROPPED_SHARE_MAX: f64 = 0.001;

    /// Time between two snapshots.
    const PERIOD: Duration = Duration::from_micros(16_667);

    /// Whether a send is a dropped one.
    #[must_use]
    pub fn is_dropped(&self, lag: Duration) -> bool {
        lag > self.lag_max * Self::DROPPED_AFTER
    }

    /// Why a run is invalid; `None` when the generator kept its schedule. Of the lags, p99 each, the first is that of sends and the second
    /// that of those who look on.
    #[must_use]
    pub fn fault(&self, lags: [Duration; 2], sends: u64, dropped: u64) -> Option<String> {
        let [hands, eyes] =
            [("those who press were", self.lag_max), ("those who look on were", self.lag_max.max(Self::PERIOD))];
        let late = [hands, eyes].into_iter().zip(lags).find(|((_, lag_max), lag)| lag > lag_max);
        if let Some(((who, lag_max), lag)) = late {
            return Some(format!(
                "{who} behind the generator's own schedule by {:.1} ms at the 99th percentile, more than {:.1} ms: keep \
                 a spawned server to cores of its own with --server-cores, use a machine with more time to spare, fewer people, or \
                 --lag-max-ms",
                lag.as_secs_f64() * 1e3,
                lag_max.as_secs_f64() * 1e3
            ));
        }
        (dropped as f64 > sends as f64 * Self::DROPPED_SHARE_MAX).then(|| {
            format!(
                "the generator left out {dropped} of {sends} sends, more than {} %: use a machine with more time to spare, \
                 or fewer people",
                Self::DROPPED_SHARE_MAX * 100.0
            )
        })
    }
}

impl Default for Punctuality {
    fn default() -> Self {
        Self { lag_max: Duration::from_millis(5) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generator_is_at_fault_for_being_late_or_for_leaving_out() {
        let ms = Duration::from_millis;
        let punctuality = Punctuality::default();
        let fault = |lags: [u64; 2], dropped| punctuality.fault(lags.map(ms), 10_000, dropped);
        assert_eq!(fault([5, 16], 10), None);
        assert!(fault([6, 0], 0).is_some_and(|said| said.contains("those who press were behind")));
        assert!(fault([0, 17], 0).is_some_and(|said| said.contains("those who look on were behind")));
        assert!(fault([1, 0], 11).is_some_and(|said| said.contains("left out 11 of 10000")));
        assert!(!punctuality.is_dropped(ms(50)) && punctuality.is_dropped(ms(51)));
    }
}
