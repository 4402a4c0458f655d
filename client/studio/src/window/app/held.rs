//! What is in the hand, as a window knows it: which device, how its force is felt, and how fast it and the hand's thread go.
//!
//! Owns the device's name and when rates were read; asks the driver's monitor and tells it nothing.
//! Invariant: a rate is what was counted over at least [`OVER`], and none is told of before that.

use std::sync::Arc;
use std::time::{Duration, Instant};

use pottery_client::device::{Feel, Monitor};
use pottery_client::sound::Sound;
use pottery_client::{Granted, HapticLoop, Priority};

use crate::words::Words;

/// Time over which a rate is taken.
const OVER: Duration = Duration::from_secs(1);

/// What is in the hand.
#[derive(Debug)]
pub(in crate::window) struct Held {
    pub(in crate::window) name: &'static str,
    /// How its force is felt, and the largest that it gives, N.
    pub(in crate::window) feel: Feel,
    pub(in crate::window) peak_n: f32,
    /// What its driver says, if it has one.
    pub(in crate::window) monitor: Option<Arc<Monitor>>,
    /// What is heard of it.
    pub(in crate::window) sound: Sound,
    /// Whether it begins without.
    pub(in crate::window) is_muted: bool,
    pub(in crate::window) rates: Rates,
}

impl Held {
    /// How its force is felt now: while it is not there the mouse takes its place.
    pub(super) fn feel(&self) -> Feel {
        let is_there = |monitor: &Arc<Monitor>| monitor.about().is_some() && monitor.notice().is_none();
        if self.monitor.as_ref().is_none_or(is_there) { self.feel } else { Feel::Lag }
    }

    /// Counts on: the hand's thread has done so many ticks; true when there is something new to say.
    pub(super) fn count(&mut self, ticks: u64) -> bool {
        let exchanges = self.monitor.as_ref().map_or(0, |monitor| monitor.exchanges());
        self.rates.read(Instant::now(), ticks, exchanges)
    }

    /// Which device it is and how fast it answers, as far as that was counted.
    pub(super) fn said(&self, words: &Words) -> String {
        let about = self.monitor.as_ref().and_then(|monitor| monitor.about());
        let about = about
            .unwrap_or_else(|| if self.name == "mouse" { words.say("device-mouse") } else { self.name.to_owned() });
        match self.rates.a_second {
            Some((_, exchanges)) if exchanges > 0.0 => {
                // to ten, so that a device at rest says the same all the time
                let rate = words.number(f64::from((exchanges / 10.0).round() * 10.0), 0);
                words.say_with("device-rate", &[("device", &about), ("rate", &rate)])
            }
            _ => about,
        }
    }

    /// How fast the hand's thread goes, and what it goes before.
    pub(super) fn pace(&self, words: &Words, granted: &Granted) -> String {
        let asked_hz = 1e3 * granted.rate.turns_a_tick() as f32;
        let rate = match self.rates.a_second {
            None => granted.rate.to_string(),
            // between a hand that feels something and one that does not lies a factor of four
            Some((ticks, _)) if ticks * HapticLoop::IDLE_TICKS as f32 <= 1.5e3 => words.say("hand-rests"),
            Some((ticks, _)) => format!("{} kHz", words.number(f64::from(ticks * 1e-6 * asked_hz), 2)),
        };
        let priority = match granted.priority {
            Priority::RealTime => "priority-real-time",
            Priority::Ordinary | Priority::Refused { .. } => "priority-ordinary",
        };
        format!("{rate}, {}", words.say(priority))
    }
}

/// How often a second something happened, of late.
#[derive(Debug)]
pub(in crate::window) struct Rates {
    since: Instant,
    /// Ticks of the hand and exchanges with the device until then.
    counted: (u64, u64),
    /// The same a second.
    a_second: Option<(f32, f32)>,
}

impl Rates {
    /// Counts from `now` on.
    pub(in crate::window) const fn new(now: Instant) -> Self {
        Self { since: now, counted: (0, 0), a_second: None }
    }

    /// Takes in how many ticks and exchanges there were until `now`; true when the rates are new.
    pub(super) fn read(&mut self, now: Instant, ticks: u64, exchanges: u64) -> bool {
        let seconds = now.saturating_duration_since(self.since);
        if seconds < OVER {
            return false;
        }
        let rate = |now: u64, before: u64| now.saturating_sub(before) as f32 / seconds.as_secs_f32();
        self.a_second = Some((rate(ticks, self.counted.0), rate(exchanges, self.counted.1)));
        (self.since, self.counted) = (now, (ticks, exchanges));
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rates_are_what_was_counted_over_a_second_or_more() {
        let start = Instant::now();
        let after = |ms| start + Duration::from_millis(ms);
        let mut rates = Rates::new(start);
        assert!(!rates.read(after(999), 999, 250));
        assert_eq!(rates.a_second, None);
        assert!(rates.read(after(2000), 2000, 500));
        assert_eq!(rates.a_second, Some((1000.0, 250.0)));
        // a device that sends nothing any more and a hand that is kept from its ticks show
        assert!(!rates.read(after(2500), 2300, 500));
        assert!(rates.read(after(4000), 3800, 500));
        assert_eq!(rates.a_second, Some((900.0, 0.0)));
    }
}
