//! A session file, looked through once, from which any block can then be read.
//!
//! Owns the checks of the whole file; what is in a block is looked at when it is played.
//! Invariant: every block in the list was whole, in order of number and, for each wheel, of time; memory for a block is bounded
//! by what is really there.

use std::io::{self, ErrorKind, Read, Seek, SeekFrom};

use pottery_shared::room::Happening;
use pottery_shared::units::Tick;

use super::RecordingError;
use super::entries::read_entries;
use super::format::{
    BLOCK_HEAD_BYTES, BlockHead, CHECKSUM_BYTES, FILE_HEAD_BYTES, FileFault, FileHead, HeadFault, Kind, VERSION, unpack,
};
use super::state;

/// A session file.
#[derive(Debug)]
pub struct Recording<R> {
    source: R,
    head: FileHead,
    blocks: Vec<(u64, BlockHead)>,
    end: Option<Tick>,
}

/// What is found where a block may begin.
enum Found {
    Block(BlockHead),
    /// The file ends before the block does.
    CutShort,
}

impl<R: Read + Seek> Recording<R> {
    /// Looks through a file.
    ///
    /// One that was cut short, because the studio was killed or the disk was full, is sound up to there.
    ///
    /// # Errors
    /// [`RecordingError`] for one that is no session file, of a later day, or damaged.
    pub fn open(mut source: R) -> Result<Self, RecordingError> {
        source.seek(SeekFrom::Start(0))?;
        let mut bytes = Vec::new();
        source.by_ref().take(FILE_HEAD_BYTES as u64).read_to_end(&mut bytes)?;
        let head = FileHead::read(&bytes).map_err(|fault| match fault {
            FileFault::NotASession => RecordingError::NotASession,
            FileFault::Version(0) => RecordingError::Meaningless { what: "version", at: 0 },
            FileFault::Version(version) => RecordingError::FromTheFuture { version, newest: VERSION },
            FileFault::Damaged => RecordingError::Damaged { at: 0 },
            FileFault::Meaningless(what) => RecordingError::Meaningless { what, at: 0 },
        })?;
        let mut recording = Self { source, head, blocks: Vec::new(), end: None };
        recording.look_through()?;
        Ok(recording)
    }

    fn look_through(&mut self) -> Result<(), RecordingError> {
        let mut at = FILE_HEAD_BYTES as u64;
        // of each wheel, the end of its last block
        let mut reached: Vec<Option<Tick>> = vec![None; usize::from(self.head.wheels)];
        while let Found::Block(block) = self.block_at(at)? {
            let meaningless = |what| RecordingError::Meaningless { what, at };
            if block.number as usize != self.blocks.len() {
                return Err(meaningless("number"));
            }
            if block.kind == Kind::End {
                if self.source.read(&mut [0])? != 0 {
                    return Err(meaningless("rest"));
                }
                self.end = Some(block.last);
                return Ok(());
            }
            let reached = reached.get_mut(usize::from(block.wheel)).ok_or(meaningless("wheel"))?;
            let is_in_order = match (*reached, block.kind) {
                (None, kind) => kind == Kind::State,
                (Some(reached), _) => block.first >= reached,
            };
            if !is_in_order {
                return Err(meaningless("order"));
            }
            *reached = Some(block.last);
            self.blocks.push((at, block));
            at += block.length();
        }
        Ok(())
    }

    /// The head of the block that begins at a byte, when all of the block is there and whole.
    fn block_at(&mut self, at: u64) -> Result<Found, RecordingError> {
        let mut bytes = [0; BLOCK_HEAD_BYTES];
        self.source.seek(SeekFrom::Start(at))?;
        if !fill(&mut self.source, &mut bytes)? {
            return Ok(Found::CutShort);
        }
        let head = BlockHead::read(&bytes).map_err(|fault| match fault {
            HeadFault::Damaged => RecordingError::Damaged { at },
            HeadFault::Meaningless(what) => RecordingError::Meaningless { what, at },
        })?;
        let mut packed = self.source.by_ref().take(head.packed.into());
        let mut hasher = crc32fast::Hasher::new();
        let mut piece = [0; 8192];
        loop {
            match packed.read(&mut piece) {
                Ok(0) => break,
                Ok(length) => hasher.update(&piece[..length]),
                Err(error) if error.kind() == ErrorKind::Interrupted => {}
                Err(error) => return Err(error.into()),
            }
        }
        let mut checksum = [0; CHECKSUM_BYTES];
        if packed.limit() > 0 || !fill(&mut self.source, &mut checksum)? {
            return Ok(Found::CutShort);
        }
        if hasher.finalize().to_le_bytes() != checksum {
            return Err(RecordingError::Damaged { at });
        }
        Ok(Found::Block(head))
    }

    /// Number of wheels that the studio had.
    pub const fn wheels(&self) -> u16 {
        self.head.wheels
    }

    /// The program that wrote it.
    pub fn writer(&self) -> &str {
        &self.head.writer
    }

    /// Whether it ends where the studio was closed, and not before.
    pub const fn is_whole(&self) -> bool {
        self.end.is_some()
    }

    /// The first tick of a wheel, numbered from 0, and the last one that is known of; `None` when nothing was kept of it.
    pub fn span(&self, wheel: u16) -> Option<(Tick, Tick)> {
        let mut blocks = self.blocks.iter().map(|(_, block)| block).filter(|block| block.wheel == wheel);
        let first = blocks.next()?;
        let last = blocks.next_back().unwrap_or(first).last;
        Some((first.first, self.end.unwrap_or(last)))
    }

    /// The place of the newest state of a wheel at a tick or before, in the list of blocks; its first one when all are later.
    pub(super) fn state_before(&self, wheel: u16, tick: Tick) -> Option<usize> {
        let is_state = |(_, block): &(u64, BlockHead)| block.wheel == wheel && block.kind == Kind::State;
        let before = self.blocks.iter().rposition(|found| is_state(found) && found.1.last <= tick);
        before.or_else(|| self.blocks.iter().position(is_state))
    }

    /// The next block of a wheel from a place in the list on.
    pub(super) fn next_of(&self, wheel: u16, from: usize) -> Option<usize> {
        let found = self.blocks.get(from..)?.iter().position(|(_, block)| block.wheel == wheel)?;
        Some(from + found)
    }

    /// When the block at a place in the list begins.
    pub(super) fn begins(&self, place: usize) -> Option<Tick> {
        self.blocks.get(place).map(|(_, block)| block.first)
    }

    /// What is in the block at a place in the list.
    pub(super) fn read(&mut self, place: usize) -> Result<Vec<(Tick, Happening)>, RecordingError> {
        let (at, head) = self.blocks[place];
        self.source.seek(SeekFrom::Start(at + BLOCK_HEAD_BYTES as u64))?;
        let mut packed = Vec::new();
        self.source.by_ref().take(head.packed.into()).read_to_end(&mut packed)?;
        let meaningless = |what| RecordingError::Meaningless { what, at };
        let plain = unpack(&head, &packed).ok_or(meaningless("packing"))?;
        match head.kind {
            Kind::State => {
                let state = state::read(self.head.version, head.first, &plain).ok_or(meaningless("state"))?;
                Ok(vec![(head.first, Happening::State(Box::new(state)))])
            }
            Kind::Entries => read_entries(&plain, head.first, head.last).ok_or(meaningless("list of what happened")),
            Kind::End => Ok(Vec::new()),
        }
    }
}

/// Fills a buffer; false when the file ends before.
fn fill(source: &mut impl Read, buffer: &mut [u8]) -> io::Result<bool> {
    match source.read_exact(buffer) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}
