//! A light hand: samples of a stroke, stamped and repeated as a client's are, with no clay of its own.
//!
//! Holds no clock and no socket. It goes through its stroke again and again, each time elsewhere on the pot.
//! Invariant: which samples are made depends on the schedule, the seed and the server's word on the lead, on nothing else.

use std::collections::VecDeque;
use std::sync::Arc;
use std::time::Duration;

use glam::Vec3;
use pottery_client::rehearsal::dice::Dice;
use pottery_client::stroke::Stroke;
use pottery_shared::prediction::Pending;
use pottery_shared::protocol::{self, DATAGRAM_MAX, Upload};
use pottery_shared::session::{Lead, Packed, pack};
use pottery_shared::tool::{Position, Side, ToolSample};
use pottery_shared::units::Tick;

/// How often a hand's samples are sent: as often as the studio's client does.
pub const SEND_EVERY: Duration = Duration::from_millis(10);
/// Samples repeated beside the new ones, as the studio's client does.
const REDUNDANT: u32 = 40;
/// Silence after which everything unacknowledged is sent again.
const REPEAT_AFTER: Duration = Duration::from_millis(150);
/// How long, and how often, the last samples are said again with the word that no others follow.
const LAST_FOR: Duration = Duration::from_millis(100);
const LAST_EVERY: Duration = Duration::from_millis(10);
/// Most samples kept unacknowledged.
const PENDING_MAX: usize = 4096;
/// Time between two rounds of a stroke, s.
const PAUSE_S: f64 = 0.4;
/// Farthest a round goes up or down from where the stroke was made, m.
const UP_AND_DOWN_M: f32 = 0.02;

/// One round of a stroke somewhere on the pot.
#[derive(Clone, Copy, Debug)]
struct Round {
    begins_s: f64,
    angle: f32,
    up_m: f32,
}

/// Where a hand is at which millisecond of the run.
#[derive(Debug)]
pub struct Path {
    stroke: Arc<Stroke>,
    dice: Dice,
    round: Round,
}

impl Path {
    /// A path of its own for every seed.
    #[must_use]
    pub fn new(stroke: Arc<Stroke>, seed: u64) -> Self {
        let mut dice = Dice::new(seed);
        // not everybody begins with the same part
        let begins_s = -dice.share() * stroke.duration();
        let round = Round { begins_s, ..Round::rolled(&mut dice, 0.0) };
        Self { stroke, dice, round }
    }

    /// The sample of a millisecond to be stamped with `tick`; milliseconds ascend.
    pub fn sample(&mut self, millisecond: u64, tick: Tick) -> Option<ToolSample> {
        let now_s = millisecond as f64 * 1e-3;
        let length_s = self.stroke.duration() + PAUSE_S;
        while now_s >= self.round.begins_s + length_s {
            self.round = Round::rolled(&mut self.dice, self.round.begins_s + length_s);
        }
        let at_s = self.stroke.start() + now_s - self.round.begins_s;
        let centre_m = self.round.place(self.stroke.at(at_s)?);
        Some(ToolSample {
            tick,
            tool: self.stroke.tool_at(at_s),
            orientation: self.stroke.orientation_at(at_s),
            centre: Position::nearest(centre_m)?,
            side: Side::Outside,
        })
    }
}

impl Round {
    fn rolled(dice: &mut Dice, begins_s: f64) -> Self {
        let angle = dice.share() as f32 * std::f32::consts::TAU;
        let up_m = (dice.share() as f32 * 2.0 - 1.0) * UP_AND_DOWN_M;
        Self { begins_s, angle, up_m }
    }

    fn place(&self, centre_m: Vec3) -> Vec3 {
        let (sin, cos) = self.angle.sin_cos();
        let Vec3 { x, y, z } = centre_m;
        Vec3::new(x * cos - y * sin, x * sin + y * cos, z + self.up_m)
    }
}

/// An input on its way: the last of a datagram's new samples.
#[derive(Clone, Copy, Debug)]
struct Mark {
    last: u32,
    due: Duration,
    sent: Duration,
}

/// How long an input took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Answered {
    /// Since it was due.
    pub since_due: Duration,
    /// Since it was sent.
    pub since_sent: Duration,
}

/// The sending half of a potter without clay.
#[derive(Debug)]
pub struct Hand {
    lead: Lead,
    pending: VecDeque<Pending>,
    next: u32,
    unsent: u32,
    acknowledged: u32,
    last_tick: Option<Tick>,
    progress_at: Duration,
    repeated_at: Duration,
    sent_at: Duration,
    news_sent_at: Duration,
    marks: VecDeque<Mark>,
}

impl Hand {
    /// A hand that was welcomed at `server`'s tick, with the round trip of its line.
    #[must_use]
    pub fn new(local: u64, server: Tick, round_trip: Duration) -> Self {
        // as the studio's client begins
        let lead = Lead::new(local, server, round_trip.as_millis() as u64 + 25);
        Self {
            lead,
            pending: VecDeque::new(),
            next: 0,
            unsent: 0,
            acknowledged: 0,
            last_tick: None,
            progress_at: Duration::ZERO,
            repeated_at: Duration::ZERO,
            sent_at: Duration::ZERO,
            news_sent_at: Duration::ZERO,
            marks: VecDeque::new(),
        }
    }

    /// The tick to stamp at a local millisecond.
    #[must_use]
    pub fn tick(&self, local: u64) -> Tick {
        Tick(0).offset(local as i64 + self.lead.offset())
    }

    /// Takes in a sample; one that is not later than the last is dropped, as a client does after its lead went back.
    pub fn take(&mut self, sample: ToolSample) {
        if self.pending.len() < PENDING_MAX && self.last_tick.is_none_or(|last| sample.tick > last) {
            self.last_tick = Some(sample.tick);
            self.pending.push_back(Pending { sequence: self.next, sample });
            self.next = self.next.wrapping_add(1);
        }
    }

    /// Notes that what is new by now was due at a moment and goes out now.
    pub fn mark(&mut self, due: Duration, now: Duration) {
        let last = self.next.wrapping_sub(1);
        let is_new = !self.pending.is_empty() && self.marks.back().is_none_or(|mark| mark.last != last);
        if is_new && last.wrapping_sub(self.acknowledged) as i32 >= 0 {
            self.marks.push_back(Mark { last, due, sent: now });
        }
    }

    /// The next datagram; ask again until there is none.
    pub fn poll_datagram(&mut self, now: Duration) -> Option<Vec<u8>> {
        let (oldest, newest) = (self.pending.front()?.sequence, self.pending.back()?.sequence);
        let is_news = newest.wrapping_sub(self.unsent) as i32 >= 0;
        if is_news {
            self.news_sent_at = now;
        }
        let is_last =
            now.saturating_sub(self.news_sent_at) <= LAST_FOR && now.saturating_sub(self.sent_at) >= LAST_EVERY;
        let rests = !is_news && now > self.news_sent_at;
        let is_silent = now.saturating_sub(self.progress_at.max(self.repeated_at)) >= REPEAT_AFTER;
        let start = if is_silent {
            self.repeated_at = now;
            self.unsent = oldest;
            oldest
        } else if is_news {
            let behind_oldest = self.unsent.wrapping_sub(oldest) as i32;
            if behind_oldest <= 0 { oldest } else { self.unsent.wrapping_sub(REDUNDANT.min(behind_oldest as u32)) }
        } else if is_last {
            oldest
        } else {
            return None;
        };
        self.sent_at = now;
        let skip = start.wrapping_sub(oldest) as usize;
        let Packed { mut inputs, count, .. } = pack(self.pending.iter().skip(skip), DATAGRAM_MAX - 16);
        let end = start.wrapping_add(count);
        inputs.rests = rests && end == newest.wrapping_add(1);
        if end.wrapping_sub(self.unsent) as i32 > 0 {
            self.unsent = end;
        }
        Some(protocol::encode(&Upload { inputs, hand: None, again: None }))
    }

    /// Takes in how much time samples had to spare.
    pub fn handle_slack(&mut self, slack: i16, acknowledged: u32, now: Duration) {
        self.lead.handle_slack(slack, acknowledged, self.next, now);
    }

    /// Takes in that clay which holds all samples below a number is whole, and hands on how long each input took.
    pub fn confirm(&mut self, acknowledged: u32, now: Duration, mut answered: impl FnMut(Answered)) {
        if acknowledged.wrapping_sub(self.acknowledged) as i32 <= 0 {
            return;
        }
        self.acknowledged = acknowledged;
        self.progress_at = now;
        let is_below = |number: u32| (number.wrapping_sub(acknowledged) as i32) < 0;
        while self.pending.front().is_some_and(|first| is_below(first.sequence)) {
            self.pending.pop_front();
        }
        while let Some(mark) = self.marks.pop_front_if(|mark| is_below(mark.last)) {
            answered(Answered { since_due: now - mark.due, since_sent: now - mark.sent });
        }
    }

    /// Whether everything is confirmed.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        self.pending.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    /// A hand that presses for 100 ms and was due to send at 10, 20 … ms, but sent when it could.
    fn pressed(sent_late: Duration) -> Hand {
        let mut hand = Hand::new(0, Tick(0), Duration::ZERO);
        for local in 0..100 {
            let centre = Position([9000, 0, local]);
            let tick = hand.tick(local as u64);
            let (tool, orientation) = Default::default();
            hand.take(ToolSample { tick, tool, orientation, centre, side: Side::Outside });
            if local % 10 == 9 {
                let due = ms(local as u64 + 1);
                hand.mark(due, due + sent_late);
                while hand.poll_datagram(due + sent_late).is_some() {}
            }
        }
        hand
    }

    #[test]
    fn latency_counts_from_when_an_input_was_due() {
        let mut hand = pressed(ms(300));
        let mut seen = Vec::new();
        hand.confirm(100, ms(500), |answered| seen.push(answered));
        assert_eq!(seen.len(), 10);
        assert_eq!(seen[0], Answered { since_due: ms(490), since_sent: ms(190) });
        assert!(hand.is_settled());
    }

    #[test]
    fn inputs_that_are_not_in_the_clay_yet_stay_open() {
        let mut hand = pressed(Duration::ZERO);
        let mut seen = 0;
        hand.confirm(39, ms(60), |_| seen += 1);
        assert_eq!(seen, 3, "the fourth input ends with sample 39, which is not in");
        hand.confirm(40, ms(61), |_| seen += 1);
        assert_eq!(seen, 4);
    }
}
