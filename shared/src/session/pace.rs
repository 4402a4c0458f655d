//! How often a client is told what happened, and how: less often while what is sent waits on the way.
//!
//! Owns the choice; what waited, and how long, is measured by whoever has the line. Holds no clock.
//! Invariant: the rate goes down while things wait, a step at a time, and up a step after a quiet time that gets longer with
//! each try that failed.
//!
//! It stands on a congestion controller that fills a line, and keeps it from being filled. A pulse less is its head, its list of tools and QUIC's own bytes less; what is told of the clay is the same. A line that does
//! not carry that either loses a piece now and then, and who lost one waits for it while more is sent: on 60 kB a second, four
//! tools' changes were never caught up with. There it is told by keyframes alone, each asked for when the one before has come: the
//! line is then never full, and clay as old as a way and back and the keyframe's own time.

use core::time::Duration;

/// How a client is told.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Telling {
    /// Every so many snapshots, of all of them.
    Every(u64),
    /// When it asks, of what has changed in all.
    Asked,
}

/// The choice for one line.
#[derive(Clone, Copy, Debug)]
pub struct Pace {
    /// Number of the step in [`Pace::STEPS`].
    step: usize,
    /// When the step was changed, or things last waited.
    since: Duration,
    /// Quiet time after which more is tried.
    quiet: Duration,
}

impl Default for Pace {
    fn default() -> Self {
        Self { step: 0, since: Duration::ZERO, quiet: Self::QUIET }
    }
}

impl Pace {
    /// 60, 30 and 15 pulses a second, and none but answers.
    const STEPS: [Telling; 4] = [Telling::Every(1), Telling::Every(2), Telling::Every(4), Telling::Asked];
    /// Time beyond the line's shortest from which on things wait.
    const WAITS: Duration = Duration::from_millis(40);
    /// Time beyond it from which on a line is as good as full.
    const WAITS_LONG: Duration = Duration::from_millis(100);
    /// Time in which a change shows.
    const PATIENCE: Duration = Duration::from_millis(200);
    /// Shortest and longest quiet time after which it is tried whether more goes through.
    const QUIET: Duration = Duration::from_secs(2);
    const QUIET_MAX: Duration = Duration::from_secs(64);

    /// Takes in how long a way and back takes now, and how long it takes at the shortest: a long way is an uneven one.
    pub fn handle(&mut self, round_trip: Duration, shortest: Duration, now: Duration) {
        let waits = round_trip.saturating_sub(shortest);
        let passed = now.saturating_sub(self.since);
        let last = Self::STEPS.len() - 1;
        if waits > Self::WAITS_LONG.max(shortest) && self.step < last {
            (self.step, self.since) = (last, now);
            self.quiet = (self.quiet * 2).min(Self::QUIET_MAX);
        } else if waits > Self::WAITS + shortest / 4 {
            if passed >= Self::PATIENCE && self.step + 1 < last {
                self.step += 1;
            }
            if passed >= Self::PATIENCE || self.step + 1 >= last {
                self.since = now;
            }
        } else if self.step > 0 && passed >= self.quiet {
            self.step -= 1;
            self.since = now;
        } else if passed >= Self::QUIET_MAX {
            self.quiet = Self::QUIET;
        }
    }

    /// How the client is to be told.
    #[must_use]
    pub const fn telling(&self) -> Telling {
        Self::STEPS[self.step]
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::Telling::Every;
    use super::*;

    const fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn what_waits_a_little_is_told_less_often_and_more_again_after_a_quiet_time() {
        let mut pace = Pace::default();
        let mut seen = Vec::new();
        for now in (10_000..40_000).step_by(100) {
            let waits = if now < 10_500 { ms(60) } else { ms(5) };
            pace.handle(ms(20) + waits, ms(20), ms(now));
            if seen.last() != Some(&pace.telling()) {
                seen.push(pace.telling());
            }
        }
        assert_eq!(seen, [Every(2), Every(4), Every(2), Every(1)]);
    }

    #[test]
    fn a_full_line_answers_only_and_each_vain_try_takes_longer_to_the_next() {
        let mut pace = Pace::default();
        let mut fell_at = Vec::new();
        for now in (1000..200_000).step_by(100) {
            // the line carries answers and nothing else
            let waits = if pace.telling() == Telling::Asked { ms(10) } else { ms(150) };
            let before = pace.telling();
            pace.handle(ms(20) + waits, ms(20), ms(now));
            if before != Telling::Asked && pace.telling() == Telling::Asked {
                fell_at.push(now);
            }
        }
        let between: Vec<u64> = fell_at.windows(2).map(|two| two[1] - two[0]).collect();
        assert_eq!(between, [4100, 8100, 16_100, 32_100, 64_100, 64_100]);
    }
}
