//! A wheel of a session file that is played: forward entry by entry, anywhere else from the nearest state.
//!
//! Owns the place in the file; the clay is the replay's.
//! Invariant: at a tick the clay is the same, however one got there.

use std::collections::VecDeque;
use std::io::{Read, Seek};

use pottery_shared::room::{Happening, Replay};
use pottery_shared::units::Tick;

use super::{Recording, RecordingError};

/// A wheel that is played.
#[derive(Debug)]
pub struct Playback<R> {
    recording: Recording<R>,
    wheel: u16,
    replay: Replay,
    /// Read and not gone through.
    waiting: VecDeque<(Tick, Happening)>,
    /// Place in the list of blocks behind those that were read.
    next: usize,
    tick: Tick,
}

impl<R: Read + Seek> Playback<R> {
    /// A wheel, numbered from 0, as it stood at the beginning.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn begin(mut recording: Recording<R>, wheel: u16) -> Result<Self, RecordingError> {
        if wheel >= recording.wheels() {
            return Err(RecordingError::Wheel { wheel: wheel.saturating_add(1), wheels: recording.wheels() });
        }
        let empty = RecordingError::Empty { wheel: wheel + 1 };
        let place = recording.state_before(wheel, Tick(0)).ok_or(empty)?;
        let replay = stand_at(&mut recording, place)?;
        Ok(Self { recording, wheel, tick: replay.tick(), replay, waiting: VecDeque::new(), next: place + 1 })
    }

    /// Goes to a tick: on from here if nothing shorter leads there.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn seek(&mut self, tick: Tick) -> Result<(), RecordingError> {
        let state = self.recording.state_before(self.wheel, tick);
        if let Some(place) = state.filter(|place| tick < self.tick || *place >= self.next) {
            self.replay = stand_at(&mut self.recording, place)?;
            self.tick = self.replay.tick();
            self.waiting.clear();
            self.next = place + 1;
        }
        self.advance(tick)
    }

    /// Goes through everything up to and with a tick.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn advance(&mut self, to: Tick) -> Result<(), RecordingError> {
        loop {
            while let Some((tick, what)) = self.waiting.pop_front() {
                if tick > to {
                    self.waiting.push_front((tick, what));
                    self.tick = self.tick.max(to);
                    return Ok(());
                }
                self.replay.take(tick, &what)?;
            }
            let place = self.recording.next_of(self.wheel, self.next);
            let Some(place) = place.filter(|&place| self.recording.begins(place).is_some_and(|first| first <= to))
            else {
                self.tick = self.tick.max(to);
                return Ok(());
            };
            self.waiting = self.recording.read(place)?.into();
            self.next = place + 1;
        }
    }

    /// Goes through one entry; which, or `None` behind the last one.
    ///
    /// # Errors
    /// [`RecordingError`].
    pub fn step(&mut self) -> Result<Option<(Tick, Happening)>, RecordingError> {
        loop {
            if let Some((tick, what)) = self.waiting.pop_front() {
                self.replay.take(tick, &what)?;
                self.tick = self.tick.max(tick);
                return Ok(Some((tick, what)));
            }
            let Some(place) = self.recording.next_of(self.wheel, self.next) else { return Ok(None) };
            self.waiting = self.recording.read(place)?.into();
            self.next = place + 1;
        }
    }

    /// The clay, and what was compared since the last seek.
    pub const fn replay(&self) -> &Replay {
        &self.replay
    }

    /// The file.
    pub const fn recording(&self) -> &Recording<R> {
        &self.recording
    }

    /// Up to which tick everything was gone through.
    pub const fn tick(&self) -> Tick {
        self.tick
    }
}

/// A replay that stands as the state at a place in the list of blocks says.
fn stand_at<R: Read + Seek>(recording: &mut Recording<R>, place: usize) -> Result<Replay, RecordingError> {
    let entries = recording.read(place)?;
    let Some((tick, Happening::State(state))) = entries.first() else {
        unreachable!("a block of a state has one");
    };
    Ok(Replay::starting_from(*tick, state)?)
}
