//! The server's queue of one client's samples: numbering, checks and refusals.
//!
//! Samples are taken strictly in the order of their numbers; what is missing is waited for, since the client
//! repeats all that was not acknowledged. So nothing pressed is lost and nothing is pressed twice.
//! Invariant: the queue holds at most [`InputQueue::LENGTH_MAX`] samples, ascending in number and in tick.

use alloc::collections::VecDeque;

use super::runs;
use crate::protocol::Inputs;
use crate::tool::{Tool, ToolSample};
use crate::units::Tick;

/// Samples refused so far, by reason.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Refusals {
    /// Datagrams that were no message of this protocol.
    pub malformed: u64,
    /// Samples out of the workspace or with an impossible tool.
    pub out_of_workspace: u64,
    /// Samples that moved faster than a hand.
    pub too_fast: u64,
    /// Samples for a tick long gone, or not after the one before.
    pub from_the_past: u64,
    /// Samples for a tick far ahead.
    pub from_the_future: u64,
    /// Samples that came while the queue was full; the client will repeat them.
    pub flood: u64,
    /// Requests beyond what a person makes.
    pub requests: u64,
}

impl Refusals {
    /// Adds another count to this one.
    pub const fn add(&mut self, other: &Self) {
        self.malformed += other.malformed;
        self.out_of_workspace += other.out_of_workspace;
        self.too_fast += other.too_fast;
        self.from_the_past += other.from_the_past;
        self.from_the_future += other.from_the_future;
        self.flood += other.flood;
        self.requests += other.requests;
    }

    /// All of them.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.malformed + self.out_of_workspace + self.too_fast + self.from_the_past + self.from_the_future + self.flood
    }
}

/// Samples of one client that wait for their tick.
#[derive(Debug, Default)]
pub struct InputQueue {
    queue: VecDeque<(u32, ToolSample)>,
    /// Number of the first sample not yet seen.
    next: u32,
    last: Option<ToolSample>,
    /// Whether the client has said that no sample follows the last one soon.
    rests: bool,
    slack: Option<i16>,
    refusals: Refusals,
}

impl InputQueue {
    /// Most samples that wait: four seconds.
    pub const LENGTH_MAX: usize = 4096;
    /// Ticks after which a sample is too old to press: as long as a silent connection is kept.
    pub const PAST_MAX: i64 = 10_000;
    /// Ticks before which a sample is too early to believe.
    pub const FUTURE_MAX: i64 = 1_500;

    /// Takes in a datagram while `now` is the next tick to be done and the rack has so many `tools`.
    pub fn handle_inputs(&mut self, inputs: &Inputs, now: Tick, tools: usize) {
        let mut end = runs::number_near(self.next, inputs.first);
        for (number, sample) in runs::unpack(inputs, self.next, now) {
            end = number.wrapping_add(1);
            let sample = sample.filter(|sample| match sample.tool {
                Tool::Sphere(_) => true,
                Tool::Convex(shape) => usize::from(shape.0) < tools,
            });
            let ahead = number.wrapping_sub(self.next) as i32;
            if ahead < 0 {
                continue;
            }
            if ahead > 0 {
                return;
            }
            if self.queue.len() == Self::LENGTH_MAX {
                self.refusals.flood += 1;
                return;
            }
            self.next = end;
            self.rests = false;
            if let Some(sample) = self.checked(sample, now) {
                self.last = Some(sample);
                self.queue.push_back((number, sample));
                self.note_slack(sample.tick.since(now));
            }
        }
        // what was said before samples that are here already is old
        self.rests |= inputs.rests && end == self.next;
    }

    fn note_slack(&mut self, ticks: i64) {
        let spare = ticks.clamp(i64::from(i16::MIN), i64::from(i16::MAX)) as i16;
        self.slack = Some(self.slack.map_or(spare, |worst| worst.min(spare)));
    }

    /// Counts a datagram that was no message.
    pub const fn count_malformed(&mut self) {
        self.refusals.malformed += 1;
    }

    /// Counts a request that was not answered.
    pub const fn count_request(&mut self) {
        self.refusals.requests += 1;
    }

    fn checked(&mut self, sample: Option<ToolSample>, now: Tick) -> Option<ToolSample> {
        let Some(sample) = sample else {
            self.refusals.out_of_workspace += 1;
            return None;
        };
        let ahead = sample.tick.since(now);
        let ticks = self.last.map(|last| sample.tick.since(last.tick));
        if ahead < -Self::PAST_MAX || ticks.is_some_and(|ticks| ticks <= 0) {
            self.refusals.from_the_past += 1;
            return None;
        }
        if ahead > Self::FUTURE_MAX {
            self.refusals.from_the_future += 1;
            // or the client would never learn that it is too far ahead
            self.note_slack(ahead);
            return None;
        }
        if let (Some(last), Some(ticks)) = (self.last, ticks) {
            let allowed_m = ToolSample::SPEED_MAX_M_S * Tick::PERIOD.0 * ticks as f32;
            if sample.centre.distance_m(last.centre) > allowed_m {
                self.refusals.too_fast += 1;
                return None;
            }
        }
        Some(sample)
    }

    /// The oldest sample whose tick is not after `tick`, taken out.
    pub fn take_due(&mut self, tick: Tick) -> Option<ToolSample> {
        if self.queue.front()?.1.tick > tick {
            return None;
        }
        self.queue.pop_front().map(|(_, sample)| sample)
    }

    /// The tick of the oldest sample that waits.
    #[must_use]
    pub fn next_tick(&self) -> Option<Tick> {
        self.queue.front().map(|(_, sample)| sample.tick)
    }

    /// Whether every sample up to a tick was taken out, as far as can be known: the client goes on with a later one, or rests.
    #[must_use]
    pub fn is_through(&self, tick: Tick) -> bool {
        match self.next_tick() {
            Some(next) => next > tick,
            None => self.rests || self.last.is_none_or(|last| last.tick >= tick),
        }
    }

    /// Number below which every sample was taken out or refused.
    #[must_use]
    pub fn acknowledged(&self) -> u32 {
        self.queue.front().map_or(self.next, |(number, _)| *number)
    }

    /// Whether nothing waits.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.queue.is_empty()
    }

    /// Whether nothing waits and nothing has come since the slack was last asked for.
    #[must_use]
    pub fn is_quiet(&self) -> bool {
        self.queue.is_empty() && self.slack.is_none()
    }

    /// Worst slack since it was last asked for, in ticks; negative when a sample came late.
    pub const fn take_slack(&mut self) -> Option<i16> {
        self.slack.take()
    }

    /// What was refused so far.
    #[must_use]
    pub const fn refusals(&self) -> &Refusals {
        &self.refusals
    }
}
