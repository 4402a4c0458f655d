//! A wheel whose journal is gone through again.
//!
//! Presses what was pressed and rounds when it was rounded, with the room's own clay; knows no people and no bytes.
//! Invariant: after an entry the clay is what the room's was, or the first snapshot that came out otherwise is known.

use alloc::collections::BTreeMap;
use alloc::sync::Arc;
use alloc::vec::Vec;

use super::journal::{Happening, WheelState};
use crate::clay::{Conditions, Pot, Press, SubStep, Surface};
use crate::protocol::MeshWire;
use crate::session::{BROUGHT_MAX, BringError, tool_of, with_one_more};
use crate::snapshot::{Author, Moment, TileLayout, Touched, lay};
use crate::tool::{ConvexTool, Shape, ToolSample};
use crate::units::Tick;

/// Why an entry cannot be gone through; no room tells such a thing.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ReplayError {
    /// A tool that nobody could bring.
    #[error("its tool {shape} cannot be made: {source}")]
    Mesh {
        /// Its number.
        shape: u8,
        /// Why not.
        source: BringError,
    },
    /// A tool out of turn.
    #[error("its tool {shape} hangs where tool {expected} should")]
    Rack {
        /// The number it has.
        shape: u8,
        /// The next number there is.
        expected: usize,
    },
    /// A press with a tool that is not there.
    #[error("it presses with tool {shape}, and {tools} hang in the rack")]
    Tool {
        /// The tool's number.
        shape: u8,
        /// How many there are.
        tools: usize,
    },
    /// Clay where the pot has none.
    #[error("it replaces tile {tile} of surface {surface} by {radii} radii, which this pot does not have there")]
    Tile {
        /// Number of the surface.
        surface: u8,
        /// Number of the tile.
        tile: u32,
        /// How many radii it has.
        radii: usize,
    },
    /// Time that runs backwards.
    #[error("it goes from tick {before} back to tick {after}")]
    Time {
        /// The tick before.
        before: u64,
        /// The tick after it.
        after: u64,
    },
}

/// What was compared on the way.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Comparison {
    /// Snapshots whose digest was compared.
    pub snapshots: u64,
    /// The tick of the first one that came out otherwise.
    pub first_unlike: Option<Tick>,
}

/// One wheel, replayed.
#[derive(Debug)]
pub struct Replay {
    pot: Pot,
    author: Author,
    touched: Touched,
    conditions: Conditions,
    substep: SubStep,
    brought: Vec<(u8, MeshWire)>,
    people: BTreeMap<u16, Option<ToolSample>>,
    tick: Tick,
    comparison: Comparison,
    presses: Vec<Press>,
}

impl Replay {
    /// A wheel that stands as it stood after `tick`.
    ///
    /// # Errors
    /// [`ReplayError`] for tools that nobody could bring, or folds of a pot that has none.
    pub fn starting_from(tick: Tick, state: &WheelState) -> Result<Self, ReplayError> {
        let mut pot = Pot::new(*state.pot.spec()).expect("the specification was checked with the record");
        let author = Author::starting_from(&mut pot, &state.pot);
        let mut replay = Self {
            touched: Touched::none(pot.surfaces().iter().map(Surface::shape)),
            substep: SubStep::for_grid(pot.spec().shape),
            pot,
            author,
            conditions: state.conditions.clone(),
            brought: Vec::new(),
            people: state.people.iter().copied().collect(),
            tick,
            comparison: Comparison::default(),
            presses: Vec::new(),
        };
        for (shape, mesh) in &state.brought {
            replay.hang(*shape, mesh)?;
        }
        replay.replace(&state.folds)?;
        replay.author.publish_untold(&mut replay.pot, &mut replay.touched, Moment::default());
        Ok(replay)
    }

    /// Goes through what happened next.
    ///
    /// Where everything stands is compared, and taken over when it came out otherwise, so that what follows is again as
    /// it was.
    ///
    /// # Errors
    /// [`ReplayError`]; the clay is then as after the entry before.
    pub fn take(&mut self, tick: Tick, what: &Happening) -> Result<(), ReplayError> {
        if tick < self.tick {
            return Err(ReplayError::Time { before: self.tick.0, after: tick.0 });
        }
        match what {
            Happening::State(state) => self.meet(tick, state)?,
            Happening::Came { client } => {
                self.people.insert(*client, None);
            }
            Happening::Left { client } => {
                self.people.remove(client);
            }
            Happening::Wheel { from, rate } => self.conditions.wheel.schedule(*from, *rate),
            Happening::Clay { from, clay } => self.conditions.material.set(*from, *clay),
            Happening::Tool { shape, mesh } => self.hang(*shape, mesh)?,
            Happening::Pressed(pressed) => self.press(pressed)?,
            Happening::Replaced(tiles) => self.replace(tiles)?,
            Happening::Snapshot { digest } => self.snapshot(tick, *digest),
        }
        self.tick = tick;
        Ok(())
    }

    fn meet(&mut self, tick: Tick, state: &WheelState) -> Result<(), ReplayError> {
        let there = Self::starting_from(tick, state)?;
        let is_alike = there.digest() == self.digest() && there.conditions.phase(tick) == self.conditions.phase(tick);
        let mut comparison = self.comparison;
        comparison.note(tick, is_alike);
        if !is_alike {
            *self = there;
        }
        self.comparison = comparison;
        Ok(())
    }

    fn hang(&mut self, shape: u8, mesh: &MeshWire) -> Result<(), ReplayError> {
        let expected = self.substep.tools().len();
        if usize::from(shape) != expected || self.brought.len() == BROUGHT_MAX {
            return Err(ReplayError::Rack { shape, expected });
        }
        let tool = tool_of(mesh).map_err(|source| ReplayError::Mesh { shape, source })?;
        let mut rack = with_one_more(self.substep.tools(), tool);
        self.substep.swap_rack(&mut rack);
        self.brought.push((shape, mesh.clone()));
        Ok(())
    }

    fn press(&mut self, pressed: &[(u16, ToolSample)]) -> Result<(), ReplayError> {
        let tools = self.substep.tools().len();
        let mut held = pressed.iter().filter_map(|(_, sample)| sample.tool.shape());
        if let Some(Shape(shape)) = held.find(|Shape(shape)| usize::from(*shape) >= tools) {
            return Err(ReplayError::Tool { shape, tools });
        }
        self.presses.clear();
        for (client, sample) in pressed {
            let before = self.people.insert(*client, Some(*sample)).flatten();
            self.presses.push(self.conditions.press(sample, before.as_ref()));
        }
        let touched = &mut self.touched;
        self.substep.advance(&mut self.pot, &self.presses, self.conditions.method, |surface, window| {
            touched.add_window(surface, window);
        });
        Ok(())
    }

    fn replace(&mut self, tiles: &[(u8, u32, Arc<[u16]>)]) -> Result<(), ReplayError> {
        let window_of = |&(number, tile, ref steps): &(u8, u32, Arc<[u16]>)| {
            let layout = TileLayout::new(self.pot.surfaces().get(usize::from(number))?.shape());
            let window = (tile < layout.tiles()).then(|| layout.window(tile))?;
            (steps.len() == (window.columns * window.rows) as usize).then_some(window)
        };
        // all or none
        let windows: Vec<_> = tiles.iter().map(window_of).collect();
        for (&(surface, tile, ref steps), window) in tiles.iter().zip(&windows) {
            if window.is_none() {
                return Err(ReplayError::Tile { surface, tile, radii: steps.len() });
            }
        }
        for (&(surface, tile, ref steps), window) in tiles.iter().zip(windows) {
            let Some(window) = window else { continue };
            lay(&mut self.pot.surfaces_mut()[usize::from(surface)], window, steps);
            self.touched.add(usize::from(surface), tile);
        }
        Ok(())
    }

    fn snapshot(&mut self, tick: Tick, digest: u64) {
        let now = Moment { tick, phase: self.conditions.phase(tick) };
        self.author.publish_untold(&mut self.pot, &mut self.touched, now);
        self.comparison.note(tick, self.author.digest() == digest);
    }

    /// The clay.
    #[must_use]
    pub const fn pot(&self) -> &Pot {
        &self.pot
    }

    /// Digest of the newest snapshot.
    #[must_use]
    pub fn digest(&self) -> u64 {
        self.author.digest()
    }

    /// Wheel, material and method.
    #[must_use]
    pub const fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// The convex tools of the wheel, by their number.
    #[must_use]
    pub fn rack(&self) -> Arc<[ConvexTool]> {
        self.substep.rack()
    }

    /// The people, ascending, each with the sample of its tool that was pressed last.
    pub fn people(&self) -> impl Iterator<Item = (u16, Option<ToolSample>)> + '_ {
        self.people.iter().map(|(&client, &sample)| (client, sample))
    }

    /// The tick of the entry that was gone through last.
    #[must_use]
    pub const fn tick(&self) -> Tick {
        self.tick
    }

    /// What was compared so far.
    #[must_use]
    pub const fn comparison(&self) -> &Comparison {
        &self.comparison
    }
}

impl Comparison {
    fn note(&mut self, tick: Tick, is_alike: bool) {
        self.snapshots += 1;
        if !is_alike {
            self.first_unlike.get_or_insert(tick);
        }
    }
}
