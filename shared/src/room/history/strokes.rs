//! Who made which stroke, and which of them are undone.
//!
//! A stroke is what one hand presses from its first contact until it has been off the clay for [`Strokes::GAP_TICKS`]; who puts
//! other clay on the wheel makes one as well. Knows ticks and no clay.
//! Invariant: strokes of one hand do not overlap and ascend in time; one that is undone never grows.

use alloc::collections::{BTreeMap, VecDeque};
use alloc::vec::Vec;

use crate::protocol::NoStep;
use crate::units::Tick;

/// One stroke of one hand.
#[derive(Clone, Copy, Debug)]
struct Stroke {
    first: Tick,
    last: Tick,
    /// The span of the log in which it begins.
    span: u64,
    is_undone: bool,
    /// Whether the clay that is made again is made without it.
    is_left_out: bool,
    /// Whether it put other clay on the wheel, and pressed none.
    is_put: bool,
}

/// The strokes of one hand that can still be undone or redone, and those that were.
#[derive(Debug, Default)]
struct Hand {
    strokes: VecDeque<Stroke>,
    /// The undone ones that can be redone, by first tick and whether they put clay, the next one last.
    redo: Vec<(Tick, bool)>,
    /// How many are not undone.
    back: usize,
}

impl Hand {
    /// The stroke during which a tick fell.
    fn at(&self, tick: Tick) -> Option<&Stroke> {
        let later = self.strokes.partition_point(|stroke| stroke.first <= tick);
        let mut before = self.strokes.range(..later).rev();
        before.find(|stroke| !stroke.is_put).filter(|stroke| tick <= stroke.last)
    }

    /// Begins a stroke, after all that began before it.
    fn begin(&mut self, tick: Tick, span: u64, is_put: bool) {
        // whoever goes on working has decided
        self.redo.clear();
        self.back += 1;
        let at = self.strokes.partition_point(|stroke| stroke.first <= tick);
        let stroke = Stroke { first: tick, last: tick, span, is_undone: false, is_left_out: false, is_put };
        self.strokes.insert(at, stroke);
    }
}

/// Everybody's strokes at one wheel.
#[derive(Debug, Default)]
pub(super) struct Strokes {
    hands: BTreeMap<u16, Hand>,
}

impl Strokes {
    /// Ticks off the clay after which a stroke is over: longer than a tool skips, shorter than a hand rests.
    pub(super) const GAP_TICKS: i64 = 200;

    /// Notes that a hand touched clay at a tick, in a span of the log.
    pub(super) fn note(&mut self, client: u16, tick: Tick, span: u64) {
        let hand = self.hands.entry(client).or_default();
        let later = hand.strokes.partition_point(|stroke| stroke.first <= tick);
        let before = later.checked_sub(1).and_then(|at| hand.strokes.get_mut(at));
        let goes_on =
            |stroke: &&mut Stroke| !stroke.is_put && !stroke.is_undone && tick.since(stroke.last) <= Self::GAP_TICKS;
        match before.filter(goes_on) {
            Some(stroke) => stroke.last = stroke.last.max(tick),
            None => hand.begin(tick, span, false),
        }
    }

    /// Notes that a client put other clay on the wheel at a tick, in a span of the log.
    pub(super) fn note_put(&mut self, client: u16, tick: Tick, span: u64) {
        self.hands.entry(client).or_default().begin(tick, span, true);
    }

    /// Whether nobody has touched clay for so long that every stroke is over.
    pub(super) fn are_over(&self, now: Tick) -> bool {
        let is_over = |stroke: &Stroke| stroke.is_undone || stroke.is_put || now.since(stroke.last) > Self::GAP_TICKS;
        self.hands.values().all(|hand| hand.strokes.back().is_none_or(is_over))
    }

    /// Marks the newest stroke of a hand that began up to a tick, or put other clay there, and is not undone, with all of it that was held up to then; says in
    /// which span it begins.
    pub(super) fn undo(&mut self, client: u16, held: Tick) -> Result<u64, NoStep> {
        let hand = self.hands.get_mut(&client).ok_or(NoStep::NothingBack)?;
        // a client's wishes keep their order, so that clay it put there was asked for before, although it holds no sample since
        let can_be = |stroke: &Stroke| !stroke.is_undone && (stroke.is_put || stroke.first <= held);
        let number = hand.strokes.iter().rposition(can_be).ok_or(NoStep::NothingBack)?;
        let next = hand.strokes.get(number + 1).map(|next| next.first);
        let stroke = &mut hand.strokes[number];
        let rest = (!stroke.is_put && stroke.last > held).then(|| Stroke { first: held.next(), ..*stroke });
        if !stroke.is_put && held.since(stroke.last) <= Self::GAP_TICKS {
            // what of it is still on its way is undone with it
            stroke.last = next.map_or(held, |next| held.min(next.offset(-1)));
        }
        stroke.is_undone = true;
        hand.back -= 1;
        let (name, span) = ((stroke.first, stroke.is_put), stroke.span);
        if let Some(rest) = rest {
            // pressed on before this was heard of
            hand.back += 1;
            hand.strokes.insert(number + 1, rest);
        }
        if hand.strokes.range(number + 1..).all(|later| later.is_undone) {
            hand.redo.push(name);
        }
        Ok(span)
    }

    /// Takes back the last undoing of a hand; says in which span the stroke begins.
    pub(super) fn redo(&mut self, client: u16) -> Result<u64, NoStep> {
        let hand = self.hands.get_mut(&client).ok_or(NoStep::NothingForth)?;
        let name = hand.redo.pop().ok_or(NoStep::NothingForth)?;
        let is_it = |stroke: &&mut Stroke| (stroke.first, stroke.is_put) == name;
        let stroke = hand.strokes.iter_mut().find(is_it).ok_or(NoStep::NothingForth)?;
        stroke.is_undone = false;
        hand.back += 1;
        Ok(stroke.span)
    }

    /// How many strokes of a hand can be undone, and how many redone.
    pub(super) fn counts(&self, client: u16) -> (usize, usize) {
        self.hands.get(&client).map_or((0, 0), |hand| (hand.back, hand.redo.len()))
    }

    /// Whether a tick falls into an undone stroke of a hand.
    pub(super) fn is_undone(&self, client: u16, tick: Tick) -> bool {
        self.hands.get(&client).and_then(|hand| hand.at(tick)).is_some_and(|stroke| stroke.is_undone)
    }

    /// Whether clay that is made again is made without what a hand did at a tick.
    pub(super) fn is_left_out(&self, client: u16, tick: Tick) -> bool {
        self.hands.get(&client).and_then(|hand| hand.at(tick)).is_some_and(|stroke| stroke.is_left_out)
    }

    /// The same of what a client put on the wheel at a tick.
    pub(super) fn is_put_left_out(&self, client: u16, tick: Tick) -> bool {
        let mut strokes = self.hands.get(&client).into_iter().flat_map(|hand| &hand.strokes);
        strokes.any(|stroke| stroke.is_put && stroke.first == tick && stroke.is_left_out)
    }

    /// From now on, clay is made again without the strokes that are undone now, of those that begin in a span or later.
    pub(super) fn leave_out_from(&mut self, span: u64) {
        let all = self.hands.values_mut().flat_map(|hand| &mut hand.strokes);
        all.filter(|stroke| stroke.span >= span).for_each(|stroke| stroke.is_left_out = stroke.is_undone);
    }

    /// Forgets what began before a span: it stays as it is.
    pub(super) fn forget_before(&mut self, span: u64) {
        self.hands.retain(|_, hand| {
            while let Some(stroke) = hand.strokes.front().copied().filter(|stroke| stroke.span < span) {
                hand.strokes.pop_front();
                hand.back -= usize::from(!stroke.is_undone);
                hand.redo.retain(|name| *name != (stroke.first, stroke.is_put));
            }
            !hand.strokes.is_empty()
        });
    }
}
