//! What is counted while people come, press and look on.
//!
//! Owns histograms and counters, gathered by the second; judges nothing.
//! Invariant: what one second's tally holds is in no other.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use hdrhistogram::Histogram;
use serde::{Deserialize, Serialize};

/// A histogram of times in µs or of lengths in nm, to three digits, up to a minute or six centimetres.
fn histogram() -> Histogram<u64> {
    Histogram::new_with_bounds(1, 60_000_000, 3).expect("these bounds are valid")
}

/// What happened in some time.
#[derive(Clone, Debug)]
pub struct Tally {
    /// From the first packet to the welcome, µs.
    pub join_us: Histogram<u64>,
    /// From the moment at which an input was due to the clay that carries it, µs.
    pub input_delta_us: Histogram<u64>,
    /// The same from the moment at which it was sent: what one would see without the waiting before.
    pub input_delta_sent_us: Histogram<u64>,
    /// Age of clay when it is whole, µs.
    pub age_us: Histogram<u64>,
    /// Corrections under the own tool, nm, of full potters.
    pub correction_nm: Histogram<u64>,
    /// How late sends began, µs.
    pub lag_us: Histogram<u64>,
    /// How late those who only look on did what they do by the clock, µs.
    pub look_lag_us: Histogram<u64>,
    /// Sends that were due.
    pub sends: u64,
    /// Sends that began so late that they count as left out.
    pub dropped_sends: u64,
    /// Datagrams that found the connection's buffer full and waited for the next send.
    pub held_back: u64,
    /// Datagrams taken in.
    pub datagrams: u64,
    /// Bytes received and sent, UDP payload.
    pub down_bytes: u64,
    /// See `down_bytes`.
    pub up_bytes: u64,
    /// Packets sent by people, and of those the lost ones.
    pub up_packets: u64,
    /// See `up_packets`.
    pub up_lost: u64,
    /// Requests to be told again, or for a keyframe, because something was missing.
    pub asked: u64,
    /// Connections that broke without being asked to.
    pub broken: u64,
    /// Connections that broke on purpose and came again.
    pub reconnects: u64,
    /// Joins that did not succeed.
    pub failed_joins: u64,
    /// Messages that made no sense, or clay that was not everybody's.
    pub unlike: u64,
}

impl Default for Tally {
    fn default() -> Self {
        Self {
            join_us: histogram(),
            input_delta_us: histogram(),
            input_delta_sent_us: histogram(),
            age_us: histogram(),
            correction_nm: histogram(),
            lag_us: histogram(),
            look_lag_us: histogram(),
            sends: 0,
            dropped_sends: 0,
            held_back: 0,
            datagrams: 0,
            down_bytes: 0,
            up_bytes: 0,
            up_packets: 0,
            up_lost: 0,
            asked: 0,
            broken: 0,
            reconnects: 0,
            failed_joins: 0,
            unlike: 0,
        }
    }
}

impl Tally {
    /// Adds what another holds.
    ///
    /// # Panics
    /// Never: all histograms have the same bounds.
    pub fn add(&mut self, other: &Self) {
        for (own, others) in [
            (&mut self.join_us, &other.join_us),
            (&mut self.input_delta_us, &other.input_delta_us),
            (&mut self.input_delta_sent_us, &other.input_delta_sent_us),
            (&mut self.age_us, &other.age_us),
            (&mut self.correction_nm, &other.correction_nm),
            (&mut self.lag_us, &other.lag_us),
            (&mut self.look_lag_us, &other.look_lag_us),
        ] {
            own.add(others).expect("all histograms have the same bounds");
        }
        for (own, others) in [
            (&mut self.sends, other.sends),
            (&mut self.dropped_sends, other.dropped_sends),
            (&mut self.held_back, other.held_back),
            (&mut self.datagrams, other.datagrams),
            (&mut self.down_bytes, other.down_bytes),
            (&mut self.up_bytes, other.up_bytes),
            (&mut self.up_packets, other.up_packets),
            (&mut self.up_lost, other.up_lost),
            (&mut self.asked, other.asked),
            (&mut self.broken, other.broken),
            (&mut self.reconnects, other.reconnects),
            (&mut self.failed_joins, other.failed_joins),
            (&mut self.unlike, other.unlike),
        ] {
            *own += others;
        }
    }

    /// Adds the joins that another holds, those that took place and those that did not, and nothing else.
    ///
    /// # Panics
    /// Never: all histograms have the same bounds.
    pub fn add_joins(&mut self, other: &Self) {
        self.join_us.add(&other.join_us).expect("all histograms have the same bounds");
        self.failed_joins += other.failed_joins;
    }
}

/// Where everybody counts.
#[derive(Debug)]
pub struct Recorder {
    shards: Vec<Mutex<Tally>>,
    /// Smallest difference between the moment at which clay came and the tick it is of, µs.
    earliest_us: AtomicI64,
    /// Smallest round trip, µs.
    round_trip_us: AtomicU64,
    /// People who are in.
    people: AtomicI64,
    /// People who were turned away and have not been in yet.
    outside: AtomicI64,
    /// Why people could not come in, and how often.
    reasons: Mutex<BTreeMap<String, u64>>,
    /// Whether the server itself has turned somebody away.
    is_answered: AtomicBool,
}

impl Default for Recorder {
    fn default() -> Self {
        Self {
            shards: (0..4).map(|_| Mutex::default()).collect(),
            earliest_us: AtomicI64::new(i64::MAX),
            round_trip_us: AtomicU64::new(u64::MAX),
            people: AtomicI64::new(0),
            outside: AtomicI64::new(0),
            reasons: Mutex::default(),
            is_answered: AtomicBool::new(false),
        }
    }
}

impl Recorder {
    /// Reasons that are told apart.
    const REASONS_MAX: usize = 16;

    /// Counts something of person `number`.
    pub fn count(&self, number: usize, change: impl FnOnce(&mut Tally)) {
        let shard = &self.shards[number % self.shards.len()];
        change(&mut shard.lock().unwrap_or_else(PoisonError::into_inner));
    }

    /// What was counted since the last call.
    #[must_use]
    pub fn take(&self) -> Tally {
        let mut all = Tally::default();
        for shard in &self.shards {
            all.add(&std::mem::take(&mut *shard.lock().unwrap_or_else(PoisonError::into_inner)));
        }
        all
    }

    /// Takes in why somebody could not come in, and whether the server said so.
    pub fn refuse(&self, reason: String, is_answer: bool) {
        self.is_answered.fetch_or(is_answer, Ordering::Relaxed);
        let mut reasons = self.reasons.lock().unwrap_or_else(PoisonError::into_inner);
        if reasons.len() < Self::REASONS_MAX || reasons.contains_key(&reason) {
            *reasons.entry(reason).or_default() += 1;
        }
    }

    /// Whether the server has turned somebody away: who asks again is told the same.
    #[must_use]
    pub fn is_answered(&self) -> bool {
        self.is_answered.load(Ordering::Relaxed)
    }

    /// Why people could not come in, in a line, the most frequent reason first; none where everybody could.
    #[must_use]
    pub fn refusals(&self) -> Option<String> {
        let reasons = self.reasons.lock().unwrap_or_else(PoisonError::into_inner);
        let mut reasons: Vec<_> = reasons.iter().collect();
        reasons.sort_by_key(|(_, times)| std::cmp::Reverse(**times));
        match reasons.as_slice() {
            [] => None,
            [(reason, _)] => Some((*reason).clone()),
            many => Some(
                many.iter().map(|(reason, times)| format!("{times} times: {reason}")).collect::<Vec<_>>().join("; "),
            ),
        }
    }

    /// Takes in a round trip that was measured.
    pub fn note_round_trip(&self, round_trip: Duration) {
        self.round_trip_us.fetch_min(round_trip.as_micros() as u64, Ordering::Relaxed);
    }

    /// Age of clay of a tick that came at a moment of the run, µs: over the youngest clay that anybody got, and half of the
    /// shortest round trip, since nobody can say how far two machines' clocks are apart.
    #[must_use]
    pub fn age_us(&self, now: Duration, tick: u64) -> u64 {
        let difference = now.as_micros() as i64 - tick as i64 * 1000;
        let earliest = self.earliest_us.fetch_min(difference, Ordering::Relaxed).min(difference);
        let round_trip = self.round_trip_us.load(Ordering::Relaxed);
        let half = if round_trip == u64::MAX { 0 } else { round_trip / 2 };
        (difference - earliest) as u64 + half
    }

    /// Somebody came in or left.
    pub fn come(&self, by: i64) {
        self.people.fetch_add(by, Ordering::Relaxed);
    }

    /// People who are in.
    #[must_use]
    pub fn people(&self) -> i64 {
        self.people.load(Ordering::Relaxed)
    }

    /// Somebody who has not been in yet was turned away, or came in at last.
    pub fn stand_outside(&self, by: i64) {
        self.outside.fetch_add(by, Ordering::Relaxed);
    }

    /// People who were turned away and have not been in yet.
    #[must_use]
    pub fn outside(&self) -> u32 {
        self.outside.load(Ordering::Relaxed).max(0) as u32
    }
}

/// What is told of a histogram.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Quantiles {
    /// Number of values.
    pub count: u64,
    /// Mean.
    pub mean: f64,
    /// 50th percentile.
    pub p50: f64,
    /// 90th percentile.
    pub p90: f64,
    /// 95th percentile.
    pub p95: f64,
    /// 99th percentile.
    pub p99: f64,
    /// 99.9th percentile.
    pub p999: f64,
    /// Largest.
    pub max: f64,
}

impl Quantiles {
    /// Of a histogram whose unit is `unit` of what is told.
    #[must_use]
    pub fn of(histogram: &Histogram<u64>, unit: f64) -> Self {
        let at = |quantile| histogram.value_at_quantile(quantile) as f64 * unit;
        Self {
            count: histogram.len(),
            mean: histogram.mean() * unit,
            p50: at(0.5),
            p90: at(0.9),
            p95: at(0.95),
            p99: at(0.99),
            p999: at(0.999),
            max: histogram.max() as f64 * unit,
        }
    }

    /// One of them by its name.
    #[must_use]
    pub fn named(&self, name: &str) -> Option<f64> {
        Some(match name {
            "count" => self.count as f64,
            "mean" => self.mean,
            "p50" => self.p50,
            "p90" => self.p90,
            "p95" => self.p95,
            "p99" => self.p99,
            "p999" | "p99.9" => self.p999,
            "max" => self.max,
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn joins_before_the_measured_time_count_whether_they_took_place_or_not_and_nothing_else_does() {
        let mut before = Tally { failed_joins: 3, sends: 7, ..Tally::default() };
        before.join_us.saturating_record(5);
        let mut total = Tally { failed_joins: 1, ..Tally::default() };
        total.add_joins(&before);
        assert_eq!((total.failed_joins, total.join_us.len(), total.sends), (4, 1, 0));
    }
}
