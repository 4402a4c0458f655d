//! Other people's tools as they are drawn: between the places that were heard of, a little late, and never past them.
//!
//! Owns how late; holds no clock.
//! Invariant: a tool is drawn on the straight way between two places that were heard of one after the other, at a time that
//! never goes back: it cannot overshoot, and what jitters is how late, not where.
//!
//! A place is drawn once the next one is there as a rule: as late as, over the last second, the newest place was old at worst
//! when the next came. Nothing is extrapolated; who stops stands still where he stopped, and so does who falls silent.

use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;

use pottery_shared::session::RemoteTool;
use pottery_shared::tool::{Orientation, Position};
use pottery_shared::units::Tick;

/// Time over which it is remembered how old the newest place became.
const REMEMBERED: Duration = Duration::from_secs(1);
/// A tool is drawn no later than this behind the newest place: who is silent for longer jumps.
const LATE_MAX_MS: f64 = 250.0;
/// Places farther apart in time are not joined: the tool was away.
const GAP_MAX_TICKS: u64 = 250;
/// Places of one tool that are kept: a second of them.
const PLACES_MAX: usize = 64;
/// How much faster or slower than time the drawn time goes while it is put right.
const HURRY: f64 = 0.2;

/// Everybody's tools on their ways.
#[derive(Clone, Debug, Default)]
pub struct RemoteHands {
    /// By the number of the client.
    ways: BTreeMap<u16, Way>,
    heard: Option<Tick>,
    /// When a place came, and how far the one before it was then behind the own time, ms.
    behind: VecDeque<(Duration, f64)>,
    /// The own time when it was last drawn, and the tick that was drawn.
    drawn: Option<(Duration, f64)>,
}

#[derive(Clone, Debug, Default)]
struct Way {
    places: VecDeque<(u64, RemoteTool)>,
    /// Since when it is not told of.
    gone: Option<u64>,
}

impl RemoteHands {
    /// Takes in where everybody's tools were at a tick, unless it is known or older.
    pub fn hear(&mut self, tools: &[RemoteTool], tick: Tick, now: Duration) {
        if self.heard.is_some_and(|heard| heard >= tick) {
            return;
        }
        if let Some(heard) = self.heard {
            self.behind.push_back((now, heard.0 as f64 - milliseconds(now)));
        }
        while self.behind.front().is_some_and(|(came, _)| now.saturating_sub(*came) > REMEMBERED) {
            self.behind.pop_front();
        }
        self.heard = Some(tick);
        for (client, way) in &mut self.ways {
            if !tools.iter().any(|tool| tool.client == *client) {
                way.gone.get_or_insert(tick.0);
            }
        }
        for tool in tools {
            let way = self.ways.entry(tool.client).or_default();
            way.gone = None;
            way.places.push_back((tick.0, *tool));
            if way.places.len() > PLACES_MAX {
                way.places.pop_front();
            }
        }
    }

    /// The tools to draw now.
    pub fn draw(&mut self, now: Duration, tools: &mut Vec<RemoteTool>) {
        tools.clear();
        let Some(at) = self.tick_at(now) else { return };
        self.ways.retain(|_, way| way.gone.is_none_or(|gone| at < gone as f64));
        tools.extend(self.ways.values_mut().filter_map(|way| way.at(at)));
    }

    /// The tick to draw; it never goes back.
    fn tick_at(&mut self, now: Duration) -> Option<f64> {
        let newest = self.heard?.0 as f64;
        let now_ms = milliseconds(now);
        let behind_ms = self.behind.iter().map(|(_, behind_ms)| *behind_ms).fold(f64::INFINITY, f64::min);
        let wanted = (now_ms + behind_ms).clamp(newest - LATE_MAX_MS, newest);
        let at = match self.drawn {
            None => wanted,
            Some((then, at)) => {
                let passed_ms = milliseconds(now.saturating_sub(then));
                let as_time_goes = at + passed_ms;
                let hurry = passed_ms * HURRY;
                let steered = wanted.clamp(as_time_goes - hurry, as_time_goes + hurry);
                steered.clamp((newest - LATE_MAX_MS).max(at), newest.max(at))
            }
        };
        self.drawn = Some((now, at));
        Some(at)
    }
}

impl Way {
    /// Where the tool is at a tick; none before it was first told of.
    fn at(&mut self, at: f64) -> Option<RemoteTool> {
        while self.places.get(1).is_some_and(|(tick, _)| *tick as f64 <= at) {
            self.places.pop_front();
        }
        let &(from, before) = self.places.front()?;
        if from as f64 > at {
            return None;
        }
        let Some(&(to, after)) = self.places.get(1) else { return Some(before) };
        if to - from > GAP_MAX_TICKS {
            return Some(before);
        }
        let share = (at - from as f64) / (to - from) as f64;
        let between = |from: i32, to: i32| from + (f64::from(to - from) * share).round() as i32;
        let centre = std::array::from_fn(|axis| between(before.centre.0[axis], after.centre.0[axis]));
        let turned = std::array::from_fn(|axis| {
            // the shorter way round
            let (from, to) = (before.orientation.0[axis], after.orientation.0[axis]);
            from.wrapping_add((f64::from(to.wrapping_sub(from)) * share).round() as i16)
        });
        Some(RemoteTool { centre: Position(centre), orientation: Orientation(turned), ..before })
    }
}

fn milliseconds(time: Duration) -> f64 {
    time.as_secs_f64() * 1e3
}
