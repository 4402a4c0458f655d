//! What happens at a wheel, told in order to whoever keeps a record of it.
//!
//! Owns what there is to tell and when the whole state is told anew; knows no bytes and no file. Connections do not occur
//! in it: no code, no address, nothing that somebody sent and that was not pressed.
//! Invariant: from any [`Happening::State`] on, the entries make the same clay again, bit for bit ([`super::Replay`]).

use alloc::boxed::Box;
use alloc::collections::VecDeque;
use alloc::sync::Arc;
use alloc::vec::Vec;

use crate::clay::{Conditions, Material};
use crate::protocol::MeshWire;
use crate::snapshot::PotRecord;
use crate::tool::ToolSample;
use crate::units::Tick;

/// Everything that a wheel goes on from.
#[derive(Clone, Debug, PartialEq)]
pub struct WheelState {
    /// The clay, as the newest snapshot has it.
    pub pot: PotRecord,
    /// What a hollow wall remembers of its folds, which no record of its skins has, in tiles as those of [`Happening::Replaced`]; where it has
    /// never folded, none.
    pub folds: Vec<(u8, u32, Arc<[u16]>)>,
    /// Wheel, material and method.
    pub conditions: Conditions,
    /// The tools that people brought, with their ascending numbers in the rack.
    pub brought: Vec<(u8, MeshWire)>,
    /// The people, ascending, each with the sample of its tool that was pressed last.
    pub people: Vec<(u16, Option<ToolSample>)>,
}

/// Something that happened at a wheel.
#[derive(Clone, Debug, PartialEq)]
pub enum Happening {
    /// How everything stands.
    State(Box<WheelState>),
    /// Somebody came to the wheel.
    Came {
        /// The number given in the welcome.
        client: u16,
    },
    /// Somebody left it, and all that was sent is pressed.
    Left {
        /// The number given in the welcome.
        client: u16,
    },
    /// The wheel's turning was changed.
    Wheel {
        /// First tick of the new turning.
        from: Tick,
        /// Phase steps a tick.
        rate: i32,
    },
    /// The clay was changed.
    Clay {
        /// First tick at which it is another.
        from: Tick,
        /// What it is made of then.
        clay: Material,
    },
    /// A tool was hung in the rack.
    Tool {
        /// Its number.
        shape: u8,
        /// Its surface.
        mesh: MeshWire,
    },
    /// Samples were pressed, all in one sub-step: whose, and which.
    Pressed(Vec<(u16, ToolSample)>),
    /// Other clay came in the place of what there was, since strokes were undone or redone: in each of these tiles of a surface, the
    /// radii, `[columns][rows]`, in quantum steps.
    Replaced(Vec<(u8, u32, Arc<[u16]>)>),
    /// A snapshot was taken after something had been pressed or replaced.
    Snapshot {
        /// Digest of the clay.
        digest: u64,
    },
}

/// Something that happened, where and when.
#[derive(Clone, Debug, PartialEq)]
pub struct Entry {
    /// At which wheel, numbered from 0.
    pub wheel: u16,
    /// In which tick.
    pub tick: Tick,
    /// What.
    pub what: Happening,
}

/// The journal of one wheel.
#[derive(Debug)]
pub(super) struct Journal {
    entries: VecDeque<(Tick, Happening)>,
    /// When the state was told last.
    state_at: Tick,
    /// Whether anything was pressed or replaced since the last snapshot.
    is_pressed: bool,
    /// Whether a snapshot was told since the state.
    is_changed: bool,
}

impl Journal {
    /// Ticks after which the state is told anew if the clay has changed: whoever seeks goes through no more than half a
    /// minute, and a state of the paper's grid is some 100 kB.
    const STATE_EVERY: i64 = 30_000;

    /// A journal that begins with how everything stands.
    pub(super) fn beginning_with(tick: Tick, state: WheelState) -> Self {
        let entries = [(tick, Happening::State(Box::new(state)))].into();
        Self { entries, state_at: tick, is_pressed: false, is_changed: false }
    }

    pub(super) fn note(&mut self, tick: Tick, what: Happening) {
        self.is_pressed |= matches!(what, Happening::Pressed(_) | Happening::Replaced(_));
        self.entries.push_back((tick, what));
    }

    /// Notes a snapshot if anything was pressed, and how everything stands if it is time.
    pub(super) fn note_snapshot(
        &mut self,
        tick: Tick,
        digest: impl FnOnce() -> u64,
        state: impl FnOnce() -> WheelState,
    ) {
        if core::mem::take(&mut self.is_pressed) {
            self.is_changed = true;
            self.entries.push_back((tick, Happening::Snapshot { digest: digest() }));
        }
        if self.is_changed && tick.since(self.state_at) >= Self::STATE_EVERY {
            self.entries.push_back((tick, Happening::State(Box::new(state()))));
            (self.state_at, self.is_changed) = (tick, false);
        }
    }

    pub(super) fn poll(&mut self) -> Option<(Tick, Happening)> {
        self.entries.pop_front()
    }
}
