//! How often a device sends readings, learned from the readings, and from when on the next one is late.
//!
//! Pure: is told how long each took and holds no clock.
//! Invariant: a rhythm is steady only after [`BLOCK`] readings in a row of which none was late by their own median.

/// Readings by which a rhythm is judged.
const BLOCK: usize = 16;
/// Shortest interval that is told from a shorter one, s: the tick's, which takes one reading at most.
const SHORTEST_S: f32 = 1e-3;
/// Change of the interval that counts as one. Medians of a device that sleeps for a millisecond on a busy machine lie within it.
const CHANGE: f32 = 1.5;

/// Longest interval of a device that is given force, s: by then [`late_after_s`] is [`super::SILENCE`].
pub(super) const LONGEST_S: f32 = 16e-3;

/// Time without a reading, s, after which the next one is late: three intervals and two ticks.
///
/// One interval is the device's own, one may be lost or held up on the way without anything being wrong, and one goes for two
/// rhythms that drift past each other; a tick each for that of the loop and for a thread that woke late.
pub(super) const fn late_after_s(interval_s: f32) -> f32 {
    3.0 * interval_s + 2e-3
}

/// What is known of a device's rhythm.
#[derive(Clone, Copy, Debug)]
pub(super) struct Rhythm {
    gaps_s: [f32; BLOCK],
    count: usize,
    interval_s: f32,
    is_steady: bool,
}

impl Default for Rhythm {
    /// Nothing is known yet.
    fn default() -> Self {
        Self { gaps_s: [0.0; BLOCK], count: 0, interval_s: SHORTEST_S, is_steady: false }
    }
}

impl Rhythm {
    /// Takes in a reading that came `gap_s` after the last one.
    pub(super) fn hear(&mut self, gap_s: f32) {
        if self.is_steady && gap_s > late_after_s(self.interval_s) {
            // what comes after it shows whether it was the only one
            (self.is_steady, self.count) = (false, 0);
            return;
        }
        self.gaps_s[self.count] = gap_s;
        self.count += 1;
        if self.count == BLOCK {
            self.count = 0;
            self.judge();
        }
    }

    fn judge(&mut self) {
        self.gaps_s.sort_unstable_by(f32::total_cmp);
        let median_s = self.gaps_s[BLOCK / 2].max(SHORTEST_S);
        let is_other = median_s > self.interval_s * CHANGE || median_s < self.interval_s / CHANGE;
        if is_other || !self.is_steady {
            self.interval_s = median_s;
            self.is_steady = median_s <= LONGEST_S && self.gaps_s[BLOCK - 1] <= late_after_s(median_s);
        }
    }

    /// Time from one reading to the next, s, as far as it is known: never less than the tick's.
    pub(super) const fn interval_s(&self) -> f32 {
        self.interval_s
    }

    /// Whether readings come in time.
    pub(super) const fn is_steady(&self) -> bool {
        self.is_steady
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(rhythm: &mut Rhythm, gaps_ms: impl IntoIterator<Item = f32>) {
        gaps_ms.into_iter().for_each(|gap_ms| rhythm.hear(gap_ms * 1e-3));
    }

    fn steady(interval_ms: f32) -> Rhythm {
        let mut rhythm = Rhythm::default();
        heard(&mut rhythm, [interval_ms; BLOCK - 1]);
        assert!(!rhythm.is_steady());
        heard(&mut rhythm, [interval_ms]);
        rhythm
    }

    #[test]
    fn the_slowest_device_with_force_is_late_when_it_is_silent() {
        assert!((late_after_s(LONGEST_S) - super::super::SILENCE.as_secs_f32()).abs() < 1e-6);
        assert!(steady(15.9).is_steady() && !steady(16.1).is_steady() && !steady(30.0).is_steady());
        // one that is faster than the tick is as fast as the tick
        assert!((steady(0.25).interval_s() - 1e-3).abs() < 1e-9);
    }

    #[test]
    fn slow_device_with_some_jitter_is_never_late() {
        for interval_ms in [1.0, 4.0, 10.0] {
            let mut rhythm = steady(interval_ms);
            let known_s = rhythm.interval_s();
            for reading in 0..10_000_u16 {
                // from half an interval to one and a half, and two of each hundred twice as long
                let share = f32::from(reading % 101 * 37 % 101) / 101.0 + 0.5;
                let lost = if reading % 50 == 0 { 1.0 } else { 0.0 };
                heard(&mut rhythm, [interval_ms * (share + lost)]);
                assert!(rhythm.is_steady(), "{interval_ms} ms, reading {reading}");
            }
            assert!((rhythm.interval_s() - known_s).abs() < 1e-9, "{interval_ms} ms: {}", rhythm.interval_s());
        }
    }

    #[test]
    fn one_late_reading_costs_a_block_and_teaches_nothing() {
        for late_ms in [10.0, 30.0] {
            let mut rhythm = steady(1.0);
            heard(&mut rhythm, [late_ms]);
            assert!(!rhythm.is_steady());
            heard(&mut rhythm, [1.0; BLOCK - 1]);
            assert!(!rhythm.is_steady());
            heard(&mut rhythm, [1.0]);
            assert!(rhythm.is_steady() && rhythm.interval_s() < 1.001e-3, "{late_ms} ms: {rhythm:?}");
        }
    }

    #[test]
    fn device_that_has_become_slow_is_another_and_one_that_is_late_now_and_then_is_not_steady() {
        let mut rhythm = steady(1.0);
        // not late yet, and too slow for what is tuned to a millisecond
        heard(&mut rhythm, [3.0; 2 * BLOCK]);
        assert!(rhythm.is_steady() && (rhythm.interval_s() - 3e-3).abs() < 1e-6, "{rhythm:?}");
        heard(&mut rhythm, [12.0; BLOCK]);
        assert!(!rhythm.is_steady());
        heard(&mut rhythm, [12.0; BLOCK]);
        assert!(rhythm.is_steady() && (rhythm.interval_s() - 12e-3).abs() < 1e-6, "{rhythm:?}");
        heard(&mut rhythm, [1.0; 2 * BLOCK]);
        assert!(rhythm.is_steady() && rhythm.interval_s() < 1.001e-3, "{rhythm:?}");
        for reading in 0..1000 {
            heard(&mut rhythm, [if reading % 8 == 0 { 12.0 } else { 1.0 }]);
            assert!(reading < 8 || !rhythm.is_steady(), "reading {reading}");
        }
    }
}
