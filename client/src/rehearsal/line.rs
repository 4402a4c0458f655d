//! What a line does to packets: latency, jitter, bursts of loss, duplicates, a rate and a queue.
//!
//! Knows neither sockets nor a clock: time is an argument, and the answer is when a packet arrives, if it does.
//! Invariant: the fate of a packet depends on the seed, the packets before it and their times, and on nothing else.

use std::fmt;
use std::time::Duration;

use super::dice::Dice;

/// Loss as Gilbert (1960) and Elliott (1963) model it: a good state with little loss and a bad one with much.
///
/// The states change with time and not with packets, as whatever disturbs a line ends whether or not somebody sends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BurstLoss {
    /// Mean time from the end of a burst to the next one.
    pub every: Duration,
    /// Mean time that a burst lasts.
    pub lasts: Duration,
    /// Probability that a packet of a burst is lost.
    pub in_burst: f64,
    /// Probability that any other packet is lost.
    pub otherwise: f64,
}

impl BurstLoss {
    /// No loss at all.
    pub const NONE: Self =
        Self { every: Duration::from_secs(1), lasts: Duration::from_secs(1), in_burst: 0.0, otherwise: 0.0 };

    /// Share of the packets that are lost in the long run.
    #[must_use]
    pub fn mean(&self) -> f64 {
        self.share() * self.in_burst + (1.0 - self.share()) * self.otherwise
    }

    /// Share of the time in a burst.
    fn share(&self) -> f64 {
        self.lasts.as_secs_f64() / (self.lasts + self.every).as_secs_f64()
    }

    /// Probability of a burst `passed` after it was or was not one.
    ///
    /// `p(t) = π + (s − π)·exp(−t/τ₁ − t/τ₂)`: π the share of bursts, s 1 in a burst and else 0, τ₁ and τ₂ the mean times
    /// of burst and gap.
    fn probability(&self, was_in_burst: bool, passed: Duration) -> f64 {
        let share = self.share();
        let rates = 1.0 / self.lasts.as_secs_f64() + 1.0 / self.every.as_secs_f64();
        share + (f64::from(u8::from(was_in_burst)) - share) * (-passed.as_secs_f64() * rates).exp()
    }
}

/// A rate with a bounded queue before it; what does not fit in is dropped, as by any router.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rate {
    /// Bytes of UDP payload a second.
    pub bytes_per_s: u64,
    /// Bytes that wait.
    pub queue_bytes: u64,
}

/// One direction of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Time every packet takes.
    pub latency: Duration,
    /// Most time that a packet may take in addition, evenly spread and rolled for each packet, so that packets closer
    /// together than this overtake each other.
    pub jitter: Duration,
    /// Losses.
    pub loss: BurstLoss,
    /// Probability that a packet arrives twice.
    pub duplicates: f64,
    /// Limit, if there is one.
    pub rate: Option<Rate>,
}

const fn bursts(every_ms: u64, lasts_ms: u64) -> BurstLoss {
    BurstLoss { every: Duration::from_millis(every_ms), lasts: Duration::from_millis(lasts_ms), ..BurstLoss::NONE }
}

impl Quality {
    /// A cable in one building.
    pub const LAN: Self = Self {
        latency: Duration::from_micros(300),
        jitter: Duration::from_micros(200),
        loss: BurstLoss::NONE,
        duplicates: 0.0,
        rate: None,
    };
    /// A classroom on one access point: short ways, but frames wait for the air and are lost in groups.
    /// Mean loss 2.4 %.
    pub const SCHOOL_WIFI: Self = Self {
        latency: Duration::from_millis(3),
        jitter: Duration::from_millis(18),
        loss: BurstLoss { in_burst: 0.5, otherwise: 0.005, ..bursts(1000, 40) },
        duplicates: 0.005,
        rate: Some(Rate { bytes_per_s: 1_250_000, queue_bytes: 64_000 }),
    };
    /// Two homes in one country.
    pub const HOME: Self = Self {
        latency: Duration::from_millis(15),
        jitter: Duration::from_millis(8),
        loss: BurstLoss { in_burst: 0.4, otherwise: 0.002, ..bursts(5000, 30) },
        duplicates: 0.001,
        rate: Some(Rate { bytes_per_s: 1_250_000, queue_bytes: 100_000 }),
    };
    /// Two continents.
    pub const INTERCONTINENTAL: Self = Self {
        latency: Duration::from_millis(110),
        jitter: Duration::from_millis(15),
        loss: BurstLoss { in_burst: 0.5, otherwise: 0.003, ..bursts(4000, 50) },
        duplicates: 0.001,
        rate: Some(Rate { bytes_per_s: 1_250_000, queue_bytes: 200_000 }),
    };
    /// A train, or a wireless network that gives up: mean loss 13 %, and many packets overtake each other.
    pub const AWFUL: Self = Self {
        latency: Duration::from_millis(60),
        jitter: Duration::from_millis(60),
        loss: BurstLoss { in_burst: 0.75, otherwise: 0.03, ..bursts(500, 80) },
        duplicates: 0.05,
        rate: Some(Rate { bytes_per_s: 250_000, queue_bytes: 32_000 }),
    };
    /// Every preset with its name.
    pub const PRESETS: [(&'static str, Self); 5] = [
        ("lan", Self::LAN),
        ("school-wifi", Self::SCHOOL_WIFI),
        ("home", Self::HOME),
        ("intercontinental", Self::INTERCONTINENTAL),
        ("awful", Self::AWFUL),
    ];
}

impl fmt::Display for Quality {
    /// What it does to packets, in a phrase.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (least_ms, most_ms) = (self.latency.as_secs_f64() * 1e3, (self.latency + self.jitter).as_secs_f64() * 1e3);
        write!(f, "{least_ms:.1} to {most_ms:.1} ms each way, {:.1} % lost", self.loss.mean() * 100.0)?;
        match self.rate {
            Some(rate) => write!(f, ", {:.0} Mbit/s", rate.bytes_per_s as f64 * 8e-6),
            None => Ok(()),
        }
    }
}

/// What happened to packets.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LineCounts {
    /// Packets handed in.
    pub packets: u64,
    /// Bytes handed in.
    pub bytes: u64,
    /// Packets lost on the way.
    pub lost: u64,
    /// Packets that found the queue full.
    pub overflowed: u64,
    /// Packets that arrive twice.
    pub doubled: u64,
}

impl LineCounts {
    /// Adds another count to this one.
    pub const fn add(&mut self, other: &Self) {
        self.packets += other.packets;
        self.bytes += other.bytes;
        self.lost += other.lost;
        self.overflowed += other.overflowed;
        self.doubled += other.doubled;
    }
}

/// One direction of a line at work.
#[derive(Clone, Debug)]
pub struct Line {
    quality: Quality,
    dice: Dice,
    is_in_burst: bool,
    /// Until when the bursts were rolled.
    rolled_at: Duration,
    is_cut: bool,
    /// When the last byte that waits will have left.
    free_at: Duration,
    counts: LineCounts,
}

impl Line {
    /// A line of that quality.
    #[must_use]
    pub fn new(quality: Quality, dice: Dice) -> Self {
        Self {
            quality,
            dice,
            is_in_burst: false,
            rolled_at: Duration::ZERO,
            is_cut: false,
            free_at: Duration::ZERO,
            counts: LineCounts::default(),
        }
    }

    /// Cuts the line, so that nothing comes through, or mends it.
    pub const fn cut(&mut self, is_cut: bool) {
        self.is_cut = is_cut;
    }

    /// What happened so far.
    #[must_use]
    pub const fn counts(&self) -> &LineCounts {
        &self.counts
    }

    /// When a packet of so many bytes, sent at `now`, arrives: never, once or twice.
    pub fn carry(&mut self, now: Duration, bytes: usize) -> impl Iterator<Item = Duration> + use<> {
        let arrivals = self.arrivals(now, bytes as u64);
        arrivals.into_iter().flatten()
    }

    fn arrivals(&mut self, now: Duration, bytes: u64) -> [Option<Duration>; 2] {
        self.counts.packets += 1;
        self.counts.bytes += bytes;
        let loss = self.quality.loss;
        let passed = now.saturating_sub(self.rolled_at);
        self.is_in_burst = self.dice.chance(loss.probability(self.is_in_burst, passed));
        self.rolled_at = self.rolled_at.max(now);
        let is_lost = self.dice.chance(if self.is_in_burst { loss.in_burst } else { loss.otherwise });
        let is_doubled = self.dice.chance(self.quality.duplicates);
        let late = [self.late(), self.late()];
        if is_lost || self.is_cut {
            self.counts.lost += 1;
            return [None; 2];
        }
        let Some(sent) = self.sent_at(now, bytes) else {
            self.counts.overflowed += 1;
            return [None; 2];
        };
        self.counts.doubled += u64::from(is_doubled);
        let due = sent + self.quality.latency;
        [Some(due + late[0]), is_doubled.then(|| due + late[1])]
    }

    fn late(&mut self) -> Duration {
        self.quality.jitter.mul_f64(self.dice.share())
    }

    /// When the packet's last byte has left; `None` when it finds no room in the queue.
    fn sent_at(&mut self, now: Duration, bytes: u64) -> Option<Duration> {
        let Some(rate) = self.quality.rate else { return Some(now) };
        let waiting = self.free_at.saturating_sub(now);
        let queued = waiting.as_micros() as u64 * rate.bytes_per_s / 1_000_000;
        if queued + bytes > rate.queue_bytes {
            return None;
        }
        self.free_at = now.max(self.free_at) + Duration::from_micros(bytes * 1_000_000 / rate.bytes_per_s);
        Some(self.free_at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn burst_loss_meets_its_stationary_share() {
        for (name, quality) in Quality::PRESETS {
            let mut line = Line::new(Quality { rate: None, ..quality }, Dice::new(7));
            let packets = 200_000_u32;
            let arrived: u32 = (0..packets)
                .map(|number| u32::from(line.carry(Duration::from_millis(number.into()), 1000).next().is_some()))
                .sum();
            let expected = quality.loss.mean();
            let found = 1.0 - f64::from(arrived) / f64::from(packets);
            // four standard deviations, were losses independent, and ten times that: a packet each millisecond finds
            // itself in a burst with up to 80 others, and the root of that is 9
            let tolerance = 40.0 * (expected / f64::from(packets)).sqrt();
            assert!((found - expected).abs() <= tolerance, "{name}: lost {found:.4}, expected {expected:.4}");
        }
    }

    #[test]
    fn queue_passes_its_rate_and_drops_the_rest() {
        let rate = Rate { bytes_per_s: 10_000, queue_bytes: 3_000 };
        let quality = Quality { jitter: Duration::ZERO, rate: Some(rate), ..Quality::LAN };
        let mut line = Line::new(quality, Dice::new(1));
        let mut last = Duration::ZERO;
        let mut passed = 0_u64;
        for now in 0..2000 {
            for arrival in line.carry(Duration::from_millis(now), 100) {
                assert!(arrival >= last);
                last = arrival;
                passed += 100;
            }
        }
        // two seconds of the rate and what is still in the queue
        assert!((20_000..=23_100).contains(&passed), "{passed} bytes");
        assert_eq!(line.counts().overflowed, 2000 - passed / 100);
    }

    #[test]
    fn jitter_lets_packets_overtake_and_the_seed_says_which() {
        let arrivals = |seed| -> Vec<Duration> {
            let mut line = Line::new(Quality::AWFUL, Dice::new(seed));
            (0..200).flat_map(|now| line.carry(Duration::from_millis(now * 5), 300)).collect()
        };
        assert_eq!(arrivals(3), arrivals(3));
        assert_ne!(arrivals(3), arrivals(4));
        assert!(!arrivals(3).is_sorted());
    }
}
