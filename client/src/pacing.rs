//! When ticks are due: absolute deadlines, slept for and then spun for.
//!
//! Owns the way from one deadline to the next; knows no tick's work and, but for [`Spin`], no clock.
//! Invariant: no tick begins before its deadline, and a deadline that went by is counted and never made up for.

use std::fmt;
use std::str::FromStr;
use std::time::{Duration, Instant};

/// Part of the wait that is spun at first, since sleep wakes up late by about this much: by its timer slack of 50 µs and the
/// scheduler's own time, or by the latter alone where the slack can be had away.
const SPIN: Duration = Duration::from_micros(if cfg!(target_os = "linux") { 60 } else { 120 });
/// Longest part that is spun: a quarter of a core. What is later than that has other reasons than sleep.
const SPIN_MAX: Duration = Duration::from_micros(250);
/// What is spun longer after a sleep that ended past the deadline, and shorter after one that did not: when one sleep of 10,000 ends too late,
/// both come to the same.
const LONGER: Duration = Duration::from_nanos(30_000);
const SHORTER: Duration = Duration::from_nanos(3);

/// How often a second a hand's loop goes round: so many times a tick. The clay and the network keep to ticks; between them the
/// device is read, the clay felt and the force given anew.
///
/// ```
/// use pottery_client::LoopRate;
///
/// assert_eq!("4000".parse::<LoopRate>().unwrap().turns_a_tick(), 4);
/// assert!("1500".parse::<LoopRate>().unwrap_err().to_string().contains("1000 to 10000"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LoopRate(u8);

/// Why a loop cannot go at a rate.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("a loop cannot go at {text:?} Hz: choose a thousand, or whole thousands more, from {min} to {max}", min = LoopRate::HZ.0, max = LoopRate::HZ.1)]
pub struct LoopRateError {
    /// What was asked for.
    pub text: String,
}

impl LoopRate {
    /// Slowest and fastest, Hz.
    pub const HZ: (u32, u32) = (1_000, 10_000);

    /// Turns of the loop in a tick.
    #[must_use]
    pub const fn turns_a_tick(self) -> u64 {
        self.0 as u64
    }

    /// Length of a turn.
    #[must_use]
    pub fn period(self) -> Duration {
        Pacing::PERIOD / u32::from(self.0)
    }

    /// Whole turns in a time.
    const fn whole_turns(self, time: Duration) -> u64 {
        (time.as_nanos() * self.0 as u128 / Pacing::PERIOD.as_nanos()) as u64
    }
}

impl fmt::Display for LoopRate {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} kHz", self.0)
    }
}

impl Default for LoopRate {
    /// A turn a tick: 1 kHz.
    fn default() -> Self {
        Self(1)
    }
}

impl FromStr for LoopRate {
    type Err = LoopRateError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let turns = text.trim().parse::<u32>().ok().filter(|hz| hz % Self::HZ.0 == 0).map(|hz| hz / Self::HZ.0);
        let turns = turns.filter(|turns| (1..=Self::HZ.1 / Self::HZ.0).contains(turns));
        turns.map(|turns| Self(turns as u8)).ok_or_else(|| LoopRateError { text: text.to_owned() })
    }
}

/// Which turn of the loop is next, counted since a beginning.
///
/// Time arrives as an argument, as what has passed since then.
///
/// ```
/// use std::time::Duration;
/// use pottery_client::{LoopRate, Pacing};
///
/// let mut pacing = Pacing::after(Duration::from_micros(300), LoopRate::default());
/// assert_eq!((pacing.turn(), pacing.deadline()), (1, Duration::from_millis(1)));
/// // the tick took until shortly before the fourth deadline: two went by, and the fourth is kept
/// pacing.done(Duration::from_micros(3900));
/// assert_eq!((pacing.turn(), pacing.missed()), (4, 2));
/// // nobody is there to feel the next three
/// pacing.rest(4);
/// assert_eq!((pacing.turn(), pacing.missed()), (7, 2));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Pacing {
    rate: LoopRate,
    turn: u64,
    missed: u64,
}

impl Pacing {
    /// Length of a tick.
    pub const PERIOD: Duration = Duration::from_millis(1);
    /// A tick that begins later than this after its deadline is late.
    pub const LATE: Duration = Duration::from_micros(200);

    /// Begins with the first deadline after now, at a rate.
    #[must_use]
    pub const fn after(now: Duration, rate: LoopRate) -> Self {
        Self { rate, turn: rate.whole_turns(now) + 1, missed: 0 }
    }

    /// Number of the next turn; every so many of them, from 0 on, are a tick.
    #[must_use]
    pub const fn turn(&self) -> u64 {
        self.turn
    }

    /// Whether the next turn is a tick.
    #[must_use]
    pub const fn is_tick(&self) -> bool {
        self.turn.is_multiple_of(self.rate.turns_a_tick())
    }

    /// When it is due: no earlier than its share of the tick, to the nanosecond.
    #[must_use]
    pub const fn deadline(&self) -> Duration {
        let turns = self.rate.turns_a_tick();
        Duration::from_nanos((self.turn * Self::PERIOD.as_nanos() as u64).div_ceil(turns))
    }

    /// How long after its deadline it begins, when it begins now.
    #[must_use]
    pub const fn lateness(&self, now: Duration) -> Duration {
        now.saturating_sub(self.deadline())
    }

    /// Its work is done: the next turn is that of the first deadline which has not gone by.
    pub fn done(&mut self, now: Duration) {
        let (due, turns) = (self.rate.whole_turns(now).max(self.turn), self.rate.turns_a_tick());
        self.missed += due / turns - self.turn / turns;
        self.turn = due + 1;
    }

    /// Leaves out deadlines, so that the next turn is the tick `ticks` later; they do not count as missed.
    pub const fn rest(&mut self, ticks: u64) {
        let turns = self.rate.turns_a_tick();
        self.turn = (self.turn.div_ceil(turns) + ticks.saturating_sub(1)) * turns;
    }

    /// Ticks whose deadline went by while the loop was still at work.
    #[must_use]
    pub const fn missed(&self) -> u64 {
        self.missed
    }
}

/// What a loop with nothing to do kept of its deadlines.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IdleLoop {
    /// Ticks that began.
    pub ticks: u64,
    /// Those that began later than [`Pacing::LATE`].
    pub late: u64,
    /// Ticks whose deadline went by.
    pub missed: u64,
}

impl IdleLoop {
    /// Keeps such a loop on this thread for a time: whatever it is late by, it is the machine's doing.
    #[must_use]
    pub fn keep(rate: LoopRate, time: Duration) -> Self {
        let epoch = Instant::now();
        let mut pacing = Pacing::after(Duration::ZERO, rate);
        let (mut kept, mut spin) = (Self::default(), Spin::default());
        while pacing.deadline() < time {
            spin.wait_until(epoch + pacing.deadline());
            let now = epoch.elapsed();
            if pacing.is_tick() {
                kept.ticks += 1;
                kept.late += u64::from(pacing.lateness(now) > Pacing::LATE);
            }
            pacing.done(now);
        }
        Self { missed: pacing.missed(), ..kept }
    }

    /// Both together.
    #[must_use]
    pub const fn with(self, other: Self) -> Self {
        Self { ticks: self.ticks + other.ticks, late: self.late + other.late, missed: self.missed + other.missed }
    }

    /// Share of the ticks that began too late.
    #[must_use]
    pub fn late_share(&self) -> f64 {
        self.late as f64 / self.ticks.max(1) as f64
    }
}

/// Whole ticks in a time.
pub(crate) const fn whole_ticks(time: Duration) -> u64 {
    time.as_millis() as u64
}

/// Sleeps, and comes back late by as much as sleep does: for who has nothing in the hand that could feel it.
pub(crate) fn wait_for(deadline: Instant) {
    let left = deadline.saturating_duration_since(Instant::now());
    if !left.is_zero() {
        std::thread::sleep(left);
    }
}

/// Waits by sleep for the most part and spins for the rest, which is as long as this machine's sleep needs: a virtual one wakes up late by twice a
/// real one's time.
///
/// The part follows the quantile of how late sleep ends that one sleep of 10,000 passes, by stochastic approximation (H. Robbins and S. Monro,
/// "A stochastic approximation method", Ann. Math. Statist. 22, 1951), within bounds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Spin {
    part: Duration,
}

impl Default for Spin {
    fn default() -> Self {
        Self { part: SPIN }
    }
}

impl Spin {
    /// The part of a wait that is spun.
    #[must_use]
    pub const fn part(&self) -> Duration {
        self.part
    }

    /// A sleep ended past the deadline by so much, or by nothing; one that no spinning could have caught says nothing.
    ///
    /// ```
    /// use std::time::Duration;
    /// use pottery_client::Spin;
    ///
    /// let mut spin = Spin::default();
    /// let first = spin.part();
    /// (0..3).for_each(|_| spin.slept(Duration::from_micros(50)));
    /// assert_eq!(spin.part(), first + Duration::from_micros(90));
    /// (0..10_000).for_each(|_| spin.slept(Duration::ZERO));
    /// assert_eq!(spin.part(), first + Duration::from_micros(60));
    /// spin.slept(Duration::from_millis(3));
    /// assert_eq!(spin.part(), first + Duration::from_micros(60));
    /// ```
    pub fn slept(&mut self, past: Duration) {
        let part = match past {
            Duration::ZERO => self.part.saturating_sub(SHORTER),
            past if past <= SPIN_MAX => self.part + LONGER,
            _ => return,
        };
        self.part = part.clamp(SPIN, SPIN_MAX);
    }

    /// Waits.
    pub(crate) fn wait_until(&mut self, deadline: Instant) {
        let left = deadline.saturating_duration_since(Instant::now());
        // a fast loop spins no more than half of its time, or it would never sleep
        let spun = self.part.min(SPIN.max(left / 2));
        if left > spun {
            std::thread::sleep(left - spun);
            self.slept(Instant::now().saturating_duration_since(deadline));
        }
        while Instant::now() < deadline {
            std::hint::spin_loop();
        }
    }
}
