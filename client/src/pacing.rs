//! When ticks are due: absolute deadlines, slept for and then spun for.
//!
//! Owns the way from one deadline to the next; knows no tick's work and, but for [`wait_until`], no clock.
//! Invariant: no tick begins before its deadline, and a deadline that went by is counted and never made up for.

use std::time::{Duration, Instant};

/// Part of the wait that is spun, since sleep wakes up late by about this much: by its timer slack of 50 µs and the
/// scheduler's own time, or by the latter alone where the slack can be had away.
const SPIN: Duration = Duration::from_micros(if cfg!(target_os = "linux") { 60 } else { 120 });

/// Which tick is next, counted in periods since a beginning.
///
/// Time arrives as an argument, as what has passed since then.
///
/// ```
/// use std::time::Duration;
/// use pottery_client::Pacing;
///
/// let mut pacing = Pacing::after(Duration::from_micros(300));
/// assert_eq!((pacing.local(), pacing.deadline()), (1, Duration::from_millis(1)));
/// // the tick took until shortly before the fourth deadline: two went by, and the fourth is kept
/// pacing.done(Duration::from_micros(3900));
/// assert_eq!((pacing.local(), pacing.missed()), (4, 2));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Pacing {
    local: u64,
    missed: u64,
}

impl Pacing {
    /// Length of a tick.
    pub const PERIOD: Duration = Duration::from_millis(1);
    /// A tick that begins later than this after its deadline is late.
    pub const LATE: Duration = Duration::from_micros(200);

    /// Begins with the first deadline after now.
    #[must_use]
    pub const fn after(now: Duration) -> Self {
        Self { local: whole_ticks(now) + 1, missed: 0 }
    }

    /// Number of the next tick.
    #[must_use]
    pub const fn local(&self) -> u64 {
        self.local
    }

    /// When it is due.
    #[must_use]
    pub const fn deadline(&self) -> Duration {
        Duration::from_millis(self.local)
    }

    /// How long after its deadline it begins, when it begins now.
    #[must_use]
    pub const fn lateness(&self, now: Duration) -> Duration {
        now.saturating_sub(self.deadline())
    }

    /// Its work is done: the next tick is that of the first deadline which has not gone by.
    pub fn done(&mut self, now: Duration) {
        let due = whole_ticks(now);
        self.missed += due.saturating_sub(self.local);
        self.local = due.max(self.local) + 1;
    }

    /// Deadlines that went by while a tick was still at work.
    #[must_use]
    pub const fn missed(&self) -> u64 {
        self.missed
    }
}

/// Whole ticks in a time.
pub(crate) const fn whole_ticks(time: Duration) -> u64 {
    time.as_millis() as u64
}

/// Sleeps for most of the wait and spins for the rest.
pub(crate) fn wait_until(deadline: Instant) {
    let left = deadline.saturating_duration_since(Instant::now());
    if left > SPIN {
        std::thread::sleep(left - SPIN);
    }
    while Instant::now() < deadline {
        std::hint::spin_loop();
    }
}
