//! Clay with one person's samples applied, up to a tick.
//!
//! Owns the rounding at snapshot ticks, which must fall where the author's falls.
//! Invariant: at every snapshot tick that `through` has passed, all touched tiles were rounded to the quantum.

use alloc::vec::Vec;

use crate::clay::{Conditions, Contact, GridShape, Pot, SubStep, Window};
use crate::snapshot::{SnapshotClock, Touched, dequantise, quantise};
use crate::tool::ToolSample;
use crate::units::Tick;

/// A pot, and how far in time its owner's samples have been applied to it.
#[derive(Clone, Debug)]
pub struct Field {
    pot: Pot,
    /// Tiles pressed since the last snapshot tick.
    unrounded: Touched,
    through: Tick,
    clock: SnapshotClock,
    /// The sample pressed last.
    last: Option<ToolSample>,
}

impl Field {
    /// A field of the given clay in which nothing is pressed after `through`, rounded as at the first wheel.
    #[must_use]
    pub fn new(pot: Pot, through: Tick) -> Self {
        let unrounded = Touched::none(shapes(&pot).into_iter());
        Self { pot, unrounded, through, clock: SnapshotClock::default(), last: None }
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
        let mut own = touched;
        let unrounded = &mut self.unrounded;
        let contacts = substep.advance(&mut self.pot, &[press], conditions.method, |surface, window| {
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
        substep.feel(&self.pot, &conditions.press(sample, self.last.as_ref()), conditions.method)
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
            self.unrounded.clear();
        }
        self.through = tick;
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
        (self.through, self.clock) = (other.through, other.clock);
        self.last = other.last;
    }
}

/// The shapes of a pot's surfaces.
pub(super) fn shapes(pot: &Pot) -> Vec<GridShape> {
    pot.surfaces().iter().map(crate::clay::Surface::shape).collect()
}

fn round(pot: &mut Pot, surface: usize, window: Window) {
    pot.surfaces_mut()[surface].change_window(window, |radius_m| dequantise(quantise(radius_m)));
}
