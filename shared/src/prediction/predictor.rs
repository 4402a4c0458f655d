//! The predicted clay beside the network: unacknowledged samples, replay and correction.
//!
//! The caller passes in its own samples and what was confirmed; it never waits.
//! Invariant: `pending` holds only samples newer than what was acknowledged, in ascending order.

use alloc::collections::VecDeque;
use alloc::sync::Arc;

use super::Field;
use super::field::shapes;
use super::milestones::Milestones;
use crate::clay::{Conditions, Pot, SubStep};
use crate::snapshot::{Replica, SnapshotClock, Touched};
use crate::tool::{ConvexTool, ToolSample};
use crate::units::{Metres, Tick};

/// A sample that the server has not yet said to have applied.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pending {
    /// Its number in the client's stream of samples.
    pub sequence: u32,
    /// The sample.
    pub sample: ToolSample,
}

/// By how much the prediction changed when clay was confirmed.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Correction {
    /// Largest change in tiles that own unacknowledged samples had touched: what the hand may feel. `None` when there
    /// were no such tiles.
    pub under_own_tool: Option<Metres>,
    /// Largest change anywhere, what others did included.
    pub anywhere: Metres,
}

/// Keeps the predicted clay of one client.
#[derive(Debug)]
pub struct Predictor {
    field: Field,
    /// The clay before a correction, to measure the correction by.
    before: Pot,
    substep: SubStep,
    pending: VecDeque<Pending>,
    next_sequence: u32,
    last_tick: Option<Tick>,
    /// The newest own sample that the confirmed clay holds.
    confirmed: Option<ToolSample>,
    /// Tiles in which the field may differ from the confirmed clay.
    ahead: Touched,
    milestones: Milestones,
    /// What the pending samples were pressed under, and whether they would be pressed in the same way again.
    under: Conditions,
    is_sure: bool,
}

impl Predictor {
    /// Most samples kept unacknowledged: beyond it, pressing stops until the server answers.
    pub const PENDING_MAX: usize = 4096;

    /// A predictor over the untouched pot of a wheel with these snapshots.
    #[must_use]
    pub fn new(replica: &Replica, now: Tick, clock: SnapshotClock) -> Self {
        let pot = replica.pot().clone();
        let ahead = Touched::none(shapes(&pot).into_iter());
        let shape = pot.spec().shape;
        Self {
            before: pot.clone(),
            field: Field::new(pot, now).at(clock),
            substep: SubStep::for_grid(shape),
            pending: VecDeque::with_capacity(Self::PENDING_MAX),
            next_sequence: 0,
            last_tick: None,
            confirmed: None,
            milestones: Milestones::none(&ahead),
            ahead,
            under: Conditions::default(),
            is_sure: false,
        }
    }

    /// The predicted clay.
    #[must_use]
    pub const fn field(&self) -> &Field {
        &self.field
    }

    /// The convex tools that own samples may name.
    #[must_use]
    pub fn rack(&self) -> Arc<[ConvexTool]> {
        self.substep.rack()
    }

    /// Takes another rack, which holds every tool of the one before under its number.
    pub fn set_rack(&mut self, mut rack: Arc<[ConvexTool]>) {
        self.substep.swap_rack(&mut rack);
        self.is_sure = false;
    }

    /// Takes in where others' tools are, which hold against a wall that bends; says whether that is news.
    pub fn set_beside(&mut self, tools: impl Iterator<Item = ToolSample>) -> bool {
        let is_news = self.field.set_beside(tools);
        self.is_sure &= !is_news;
        is_news
    }

    /// Samples not yet acknowledged, oldest first.
    #[must_use]
    pub const fn pending(&self) -> &VecDeque<Pending> {
        &self.pending
    }

    /// Number of the next sample.
    #[must_use]
    pub const fn next_sequence(&self) -> u32 {
        self.next_sequence
    }

    /// The tick of the newest sample; 0 before the first.
    #[must_use]
    pub fn last_tick(&self) -> Tick {
        self.last_tick.unwrap_or_default()
    }

    /// Whether a sample can be taken in: it must be later than the last one, and there must be room.
    #[must_use]
    pub fn can_take(&self, sample: &ToolSample) -> bool {
        self.pending.len() < Self::PENDING_MAX && self.last_tick.is_none_or(|last| sample.tick > last)
    }

    /// Takes in one of the client's own samples, presses it and adds the tiles it changes to `changed`.
    pub fn handle_sample(&mut self, sample: ToolSample, conditions: &Conditions, changed: &mut Touched) {
        debug_assert!(self.can_take(&sample));
        self.last_tick = Some(sample.tick);
        self.pending.push_back(Pending { sequence: self.next_sequence, sample });
        self.next_sequence = self.next_sequence.wrapping_add(1);
        // what comes later than the clay it belongs into is pressed with the next that is confirmed
        self.is_sure &= sample.tick > self.field.through();
        self.press(&sample, conditions);
        changed.add_all(&self.ahead);
    }

    /// Presses a sample, and notes what came of it at snapshots that it passes.
    fn press(&mut self, sample: &ToolSample, conditions: &Conditions) {
        self.advance(sample.tick.offset(-1));
        self.field.press(sample, conditions, &mut self.substep, Some(&mut self.ahead));
        if !self.field.unrounded().is_empty() {
            self.milestones.open(sample.tick);
        }
        self.note_rounded(sample.tick);
    }

    /// Lets time pass to a tick; whether anything was rounded on the way.
    fn advance(&mut self, tick: Tick) -> bool {
        let last = self.field.through();
        self.field.advance(tick);
        self.note_rounded(last)
    }

    fn note_rounded(&mut self, last: Tick) -> bool {
        let rounded = self.field.take_rounded();
        if let Some((tiles, pot)) = rounded {
            self.milestones.pass(last, tiles, pot);
        }
        rounded.is_some()
    }

    /// Takes in confirmed clay that holds every own sample below `acknowledged`, and replays the rest on it, or leaves them as they are where
    /// it is what was predicted.
    ///
    /// `news` are the tiles in which the replica changed; every tile that may look different afterwards is added to
    /// `changed`.
    pub fn handle_confirmed(
        &mut self,
        replica: &Replica,
        at: Tick,
        acknowledged: u32,
        conditions: &Conditions,
        news: &Touched,
        changed: &mut Touched,
    ) -> Correction {
        // the author has rounded up to here, so the prediction is compared rounded up to here
        let is_rounded = self.advance(at);
        while self.pending.front().is_some_and(|first| (first.sequence.wrapping_sub(acknowledged) as i32) < 0) {
            self.confirmed = self.pending.pop_front().map(|pending| pending.sample);
        }
        let own = self.ahead.clone();
        self.ahead.clear();
        if self.is_as_predicted(replica, at, conditions, news) {
            if is_rounded {
                changed.add_all(&own);
            }
            self.milestones.forget(at, &mut self.ahead);
            self.ahead.add_all(self.field.unrounded());
            let unchanged = Metres(0.0);
            return Correction { under_own_tool: (!own.is_empty()).then_some(unchanged), anywhere: unchanged };
        }
        let mut dirty = own.clone();
        dirty.add_all(news);
        for (surface, _, window) in dirty.iter() {
            self.before.copy_window(self.field.pot(), surface, window);
        }
        let through = self.field.through();
        let rewound_to = self.pending.front().map_or(at, |first| at.min(first.sample.tick.offset(-1)));
        self.field.rewind(replica.pot(), &dirty, rewound_to, self.confirmed);
        self.milestones.clear();
        for at in 0..self.pending.len() {
            let sample = self.pending[at].sample;
            self.press(&sample, conditions);
        }
        self.advance(through);
        self.under.clone_from(conditions);
        self.is_sure = true;
        changed.add_all(&dirty);
        changed.add_all(&self.ahead);
        Correction {
            under_own_tool: (!own.is_empty()).then(|| self.largest_difference(&own)),
            anywhere: self.largest_difference(&dirty),
        }
    }

    /// Whether pressing the pending samples on confirmed clay would give what is predicted: it was predicted itself, with all samples up to it and
    /// none after it, and they were pressed under what holds now.
    fn is_as_predicted(&mut self, replica: &Replica, at: Tick, conditions: &Conditions, news: &Touched) -> bool {
        self.is_sure
            && self.under == *conditions
            && self.confirmed.is_none_or(|confirmed| confirmed.tick <= at)
            && self.pending.front().is_none_or(|first| first.sample.tick > at)
            && self.milestones.are_confirmed(replica, at, news)
    }

    fn largest_difference(&self, tiles: &Touched) -> Metres {
        let mut largest = 0.0_f32;
        for (surface, _, window) in tiles.iter() {
            let (now, before) = (&self.field.pot().surfaces()[surface], &self.before.surfaces()[surface]);
            let rows = window.first_row as usize..(window.first_row + window.rows) as usize;
            for column in window.first_column..window.first_column + window.columns {
                for (now, before) in
                    now.column_m(column)[rows.clone()].iter().zip(&before.column_m(column)[rows.clone()])
                {
                    largest = largest.max((now - before).abs());
                }
            }
        }
        Metres(largest)
    }
}
