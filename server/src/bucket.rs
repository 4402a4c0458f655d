//! So much at once and so much a second: the one rule behind every limit by address.
//!
//! Pure: time is an argument, counted from any beginning.
//! Invariant: no more is left than fits, however long nobody takes anything, and no time counts twice, in whichever order it is told.

use std::time::Duration;

/// How much fits into a bucket, and how much of it comes back a second.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rate {
    pub(crate) burst: f64,
    pub(crate) per_s: f64,
}

/// What is left, and when that was so.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Bucket {
    left: f64,
    at: Duration,
}

impl Bucket {
    /// One from which nothing was taken.
    pub(crate) const fn full(rate: Rate, now: Duration) -> Self {
        Self { left: rate.burst, at: now }
    }

    /// What is left by now.
    pub(crate) fn left(&self, rate: Rate, now: Duration) -> f64 {
        let since_s = now.saturating_sub(self.at).as_secs_f64();
        (self.left + since_s * rate.per_s).min(rate.burst)
    }

    /// Takes so much, if it is there.
    pub(crate) fn take(&mut self, cost: f64, rate: Rate, now: Duration) -> bool {
        let left = self.left(rate, now);
        let has_it = left >= cost;
        *self = Self { left: if has_it { left - cost } else { left }, at: self.at.max(now) };
        has_it
    }

    /// Takes so much whether it is there or not, and leaves a debt of at most `debt`.
    pub(crate) fn charge(&mut self, cost: f64, debt: f64, rate: Rate, now: Duration) {
        *self = Self { left: (self.left(rate, now) - cost).max(-debt), at: self.at.max(now) };
    }

    /// How long it takes until so much is there; for ever where so much never fits.
    pub(crate) fn until(&self, cost: f64, rate: Rate, now: Duration) -> Duration {
        let missing = (cost - self.left(rate, now)).max(0.0);
        Duration::try_from_secs_f64(missing / rate.per_s).unwrap_or(Duration::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: Rate = Rate { burst: 10.0, per_s: 5.0 };

    fn at(seconds: f64) -> Duration {
        Duration::from_secs_f64(seconds)
    }

    #[test]
    fn no_time_counts_twice_when_threads_tell_it_out_of_order() {
        let mut bucket = Bucket::full(RATE, at(0.0));
        assert!(bucket.take(10.0, RATE, at(0.0)));
        let taken = (1..=1_000).filter(|turn| {
            // of two, who read the clock later comes first
            let now = f64::from((turn - 1) / 2) * 1e-2;
            bucket.take(1.0, RATE, at(now + 1e-2 * f64::from(turn % 2)))
        });
        // five seconds' worth
        assert!((24..=26).contains(&taken.count()));
    }

    #[test]
    fn a_debt_is_paid_off_by_time_and_bounded() {
        let mut bucket = Bucket::full(RATE, at(0.0));
        for _ in 0..100 {
            bucket.charge(10.0, 20.0, RATE, at(0.0));
        }
        assert!(!bucket.take(1.0, RATE, at(4.1)), "twenty are owed, and five a second paid");
        assert_eq!(bucket.until(1.0, RATE, at(4.1)), at(0.1));
        assert!(bucket.take(1.0, RATE, at(4.2)) && bucket.left(RATE, at(60.0)) == 10.0);
        assert_eq!(bucket.until(11.0, Rate { per_s: 0.0, ..RATE }, at(60.0)), Duration::MAX);
    }
}
