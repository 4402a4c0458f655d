//! Clay with one person's samples applied, up to a tick.
//!
//! Owns the rounding at snapshot ticks, which must fall where the author's falls.
//! Invariant: at every snapshot tick that `through` has passed, all touched tiles were rounded to the quantum.

use alloc::vec::Vec;

use crate::clay::{Conditions, Contact, GridShape, Pot, Press, SubStep, Window};
use crate::snapshot::{SnapshotClock, Touched, dequantise, quantise};
use crate::tool::ToolSample;
use crate::units::Tick;

/// A pot, and how far in time its owner's samples have been applied to it.
#[derive(Clone, Debug)]
pub struct Field {
    pot: Pot,
    /// Tiles pressed since the last snapshot tick, and those that were rounded at the last one with any; whether somebody has still to be told of them.
    unrounded: Touched,
    rounded: Touched,
    is_rounded: bool,
    through: Tick,
    clock: SnapshotClock,
    /// The sample pressed last.
    last: Option<ToolSample>,
    /// Where others' tools were last heard of, which hold against a wall that bends.
    beside: Vec<ToolSample>,
}

impl Field {
    /// Most tools of others that are reckoned with.
    pub const BESIDE_MAX: usize = 4;

    /// A field of the given clay in which nothing is pressed after `through`, rounded as at the first wheel.
    #[must_use]
    pub fn new(pot: Pot, through: Tick) -> Self {
        let unrounded = Touched::none(shapes(&pot).into_iter());
        let beside = Vec::with_capacity(Self::BESIDE_MAX);
        let rounded = unrounded.clone();
        Self {
            pot,
            unrounded,
            rounded,
            is_rounded: false,
            through,
            clock: SnapshotClock::default(),
            last: None,
            beside,
        }
    }

    /// The same, rounded at a wheel's own snapshots.
    #[must_use]
    pub const fn at(mut self, clock: SnapshotClock) -> Self {
        self.clock = clock;
        self
    }

    /// The clay.
    #[must_use]
    pub const fn pot(&self) -> &Pot {
        &self.pot
    }

    /// The tick up to which samples have been applied.
    #[must_use]
    pub const fn through(&self) -> Tick {
        self.through
    }

    /// Presses one sample and adds the tiles it changes to `touched`; an older one than `through` does nothing.
    pub fn press(
        &mut self,
        sample: &ToolSample,
        conditions: &Conditions,
        substep: &mut SubStep,
        touched: Option<&mut Touched>,
    ) -> Contact {
        if sample.tick <= self.through {
            return Contact::default();
        }
        self.advance(sample.tick.offset(-1));
        let press = conditions.press(sample, self.last.as_ref());
        self.last = Some(*sample);
        let beside = self.held_beside(&press, sample.tick, conditions);
        let (mut own, beside) = (touched, &beside[..self.beside.len()]);
        let unrounded = &mut self.unrounded;
        let contacts = substep.advance_beside(&mut self.pot, &[press], beside, conditions.method, |surface, window| {
            unrounded.add_window(surface, window);
            if let Some(touched) = &mut own {
                touched.add_window(surface, window);
            }
        });
        let contact = contacts[0];
        self.advance(sample.tick);
        contact
    }

    /// What the clay opposes to a tool that would be at a sample, without being moved by it.
    pub fn feel(&self, sample: &ToolSample, conditions: &Conditions, substep: &mut SubStep) -> Contact {
        let press = conditions.press(sample, self.last.as_ref());
        let beside = self.held_beside(&press, sample.tick, conditions);
        substep.feel_beside(&self.pot, &press, &beside[..self.beside.len()], conditions.method)
    }

    /// How others' tools stand at the pot at a tick, as far as there are any.
    fn held_beside(&self, own: &Press, tick: Tick, conditions: &Conditions) -> [Press; Self::BESIDE_MAX] {
        core::array::from_fn(|number| match self.beside.get(number) {
            Some(tool) => conditions.press(&ToolSample { tick, ..*tool }, None),
            None => *own,
        })
    }

    /// Whether its wall bends, so that others' tools tell under one's own.
    #[must_use]
    pub fn bends(&self) -> bool {
        self.pot.bending().is_some()
    }

    /// Others' tools that hold against the wall.
    #[must_use]
    pub fn beside(&self) -> &[ToolSample] {
        &self.beside
    }

    /// Takes in where they are, the first [`Field::BESIDE_MAX`]; says whether that is news.
    pub fn set_beside(&mut self, tools: impl Iterator<Item = ToolSample>) -> bool {
        let (mut count, mut is_news) = (0, false);
        for tool in tools.take(Self::BESIDE_MAX) {
            match self.beside.get_mut(count) {
                Some(known) => {
                    // when it was heard of does not matter
                    is_news |= ToolSample { tick: known.tick, ..tool } != *known;
                    *known = tool;
                }
                None => {
                    self.beside.push(tool);
                    is_news = true;
                }
            }
            count += 1;
        }
        is_news |= self.beside.len() > count;
        self.beside.truncate(count);
        is_news
    }

    /// Lets time pass to `tick`, rounding the clay at the snapshot ticks on the way.
    pub fn advance(&mut self, tick: Tick) {
        if tick <= self.through {
            return;
        }
        if self.clock.any_within(self.through, tick) && !self.unrounded.is_empty() {
            for (surface, _, window) in self.unrounded.iter() {
                round(&mut self.pot, surface, window);
            }
            self.pot.settle(self.unrounded.iter().map(|(surface, _, window)| (surface, window)));
            core::mem::swap(&mut self.rounded, &mut self.unrounded);
            self.unrounded.clear();
            self.is_rounded = true;
        }
        self.through = tick;
    }

    /// Tiles pressed since the last snapshot tick.
    pub(super) const fn unrounded(&self) -> &Touched {
        &self.unrounded
    }

    /// The tiles that were rounded at a snapshot tick, and the clay, once after it.
    pub(super) fn take_rounded(&mut self) -> Option<(&Touched, &Pot)> {
        core::mem::take(&mut self.is_rounded).then_some((&self.rounded, &self.pot))
    }

    /// Becomes the confirmed clay again in the given tiles, with no sample applied after `through`; `last` is the one
    /// applied last.
    pub(super) fn rewind(&mut self, confirmed: &Pot, tiles: &Touched, through: Tick, last: Option<ToolSample>) {
        for (surface, _, window) in tiles.iter() {
            self.pot.copy_window(confirmed, surface, window);
        }
        self.pot.settle(tiles.iter().map(|(surface, _, window)| (surface, window)));
        self.unrounded.clear();
        self.through = through;
        self.last = last;
    }

    /// Takes over another field of the same pot without allocating.
    ///
    /// # Panics
    /// When the pots differ in shape.
    pub fn copy_from(&mut self, other: &Self) {
        self.pot.copy_from(&other.pot);
        self.unrounded.clear();
        self.unrounded.add_all(&other.unrounded);
        self.is_rounded = false;
        (self.through, self.clock) = (other.through, other.clock);
        self.last = other.last;
        self.beside.clone_from(&other.beside);
    }
}

/// The shapes of a pot's surfaces.
pub(super) fn shapes(pot: &Pot) -> Vec<GridShape> {
    pot.surfaces().iter().map(crate::clay::Surface::shape).collect()
}

fn round(pot: &mut Pot, surface: usize, window: Window) {
    pot.surfaces_mut()[surface].change_window(window, |radius_m| dequantise(quantise(radius_m)));
}
