//! Where the teacher's tool is to be felt: between the places that were heard of, as late as the line is uneven.
//!
//! Owns how late; holds no clock. What is drawn of other hands goes by the same rule.
//! Invariant: what it answers lies on the straight way between two places that were heard of, at a time that never goes back; it
//! allocates nothing, and its work in a tick is bounded by [`Playout::PLACES_MAX`].

use glam::Vec3;

use crate::tool::Position;
use crate::units::{Seconds, Tick};

/// A tool's places on their way through a network.
///
/// A place is `age` ticks old when the hand's own tick is that much later than its own; a hand runs ahead of the room by what its line
/// takes, so that a place is old in it that has just come. What is played is `lag` ticks old, and the
/// lag follows the largest age of late: up by standing still, down by going a fifth faster. So what is lost or late is bridged by
/// what came after it, and nothing is ever extrapolated: a teacher who stops would be felt beyond where she stopped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Playout {
    /// A ring, the newest before `next`.
    places: [Option<(Tick, Vec3)>; Self::PLACES_MAX],
    next: usize,
    /// The largest age of late, and how old what is played is, ticks.
    worst: f32,
    lag: Option<f32>,
    asked: Option<Tick>,
    /// The newest place that was there when it was last asked, and since when.
    fresh: Option<(Tick, Tick)>,
}

impl Default for Playout {
    fn default() -> Self {
        Self { places: [None; Self::PLACES_MAX], next: 0, worst: 0.0, lag: None, asked: None, fresh: None }
    }
}

impl Playout {
    /// Places that are kept: a second of them.
    const PLACES_MAX: usize = 64;
    /// A teacher of whom nothing new was heard for longer has vanished, ticks; and so has one whose newest place is that old.
    const SILENCE_MAX: i64 = 400;
    const AGE_MAX: i64 = 2000;
    /// Places farther apart in time are not joined: the tool was away.
    const GAP_MAX: i64 = 250;
    /// How fast a bad moment is forgotten, ticks a tick: one of 20 ms in a second.
    const FORGOTTEN: f32 = 0.02;
    /// How much faster than time the played time goes while it catches up.
    const HURRY: f32 = 0.2;

    /// Takes in a place; says how far the tool went since the last one and in which time, when they belong together. A place that is
    /// no number, out of reach or older than what is known is left out.
    pub(super) fn hear(&mut self, tick: Tick, at_m: Vec3) -> Option<(f32, Seconds)> {
        Position::nearest(at_m)?;
        let before = self.newest();
        if before.is_some_and(|(newest, _)| tick <= newest) {
            return None;
        }
        self.places[self.next] = Some((tick, at_m));
        self.next = (self.next + 1) % Self::PLACES_MAX;
        let (then, before_m) = before?;
        let ticks = tick.since(then);
        (ticks <= Self::GAP_MAX).then(|| (before_m.distance(at_m), Seconds(ticks as f32 * Tick::PERIOD.0)))
    }

    fn newest(&self) -> Option<(Tick, Vec3)> {
        self.places[(self.next + Self::PLACES_MAX - 1) % Self::PLACES_MAX]
    }

    /// Where the tool is to be felt in the hand's own tick; nowhere before anything was heard, nor after long silence.
    pub(super) fn at(&mut self, now: Tick) -> Option<Vec3> {
        let (newest, _) = self.newest()?;
        let age = now.since(newest);
        let (_, since) = *self.fresh.insert(self.fresh.filter(|(known, _)| *known == newest).unwrap_or((newest, now)));
        if now.since(since) > Self::SILENCE_MAX || age > Self::AGE_MAX {
            self.lag = None;
            return None;
        }
        let age = age.max(0) as f32;
        let passed = self.asked.replace(now).map_or(0, |then| now.since(then)).clamp(0, 50) as f32;
        self.worst = age.max(self.worst - Self::FORGOTTEN * passed);
        let lag = match self.lag {
            None => self.worst,
            // never back in time, and never past the newest
            Some(lag) if self.worst > lag => self.worst.min(lag + passed),
            Some(lag) => self.worst.max(lag - Self::HURRY * passed),
        };
        let lag = lag.max(age);
        self.lag = Some(lag);
        self.between(now, lag)
    }

    /// How old what is played is, ticks.
    pub(super) fn lag(&self) -> Option<f32> {
        self.lag
    }

    /// The place `lag` ticks ago.
    fn between(&self, now: Tick, lag: f32) -> Option<Vec3> {
        let mut after: Option<(f32, Vec3)> = None;
        for back in 1..=Self::PLACES_MAX {
            let Some((tick, at_m)) = self.places[(self.next + Self::PLACES_MAX - back) % Self::PLACES_MAX] else {
                break;
            };
            // counted from the time that is played
            let ahead = lag - now.since(tick) as f32;
            if ahead <= 0.0 {
                let Some((later, later_m)) = after else { return Some(at_m) };
                let gap = later - ahead;
                let share = if gap > Self::GAP_MAX as f32 { 0.0 } else { -ahead / gap };
                return Some(at_m.lerp(later_m, share));
            }
            after = Some((ahead, at_m));
        }
        // earlier than anything that is known: where it began
        after.map(|(_, at_m)| at_m)
    }
}
