//! Entries of a journal, written as they come.
//!
//! Owns which entries make a block; knows no thread and no file.
//! Invariant: a block is handed to the system in one piece, so that who is killed leaves whole blocks before the last.

use std::collections::BTreeMap;
use std::io::{self, Write};

use pottery_shared::room::{Entry, Happening};
use pottery_shared::units::Tick;

use super::entries::EntryWriter;
use super::format::{FileHead, Kind, PLAIN_MAX, VERSION, block};
use super::state;

/// Bytes after which a block is long enough.
const LONG_ENOUGH_BYTES: usize = 1 << 20;

/// Writes a session file.
#[derive(Debug)]
pub struct RecordingWriter<W> {
    out: W,
    /// Blocks written.
    number: u32,
    last: Tick,
}

/// The block that is being filled for a wheel.
struct Begun {
    entries: EntryWriter,
    first: Tick,
    last: Tick,
}

impl<W: Write> RecordingWriter<W> {
    /// Begins the file of a studio with so many wheels.
    ///
    /// # Errors
    /// What the system says.
    pub fn begin(mut out: W, wheels: u16) -> io::Result<Self> {
        let writer = concat!("pottery ", env!("CARGO_PKG_VERSION")).replace(' ', "-");
        out.write_all(&FileHead { version: VERSION, wheels, writer }.bytes())?;
        Ok(Self { out, number: 0, last: Tick(0) })
    }

    /// Appends what happened, a block a wheel or more; what is written can be replayed at once.
    ///
    /// # Errors
    /// What the system says; the file then ends with the last block that is whole.
    pub fn write(&mut self, entries: &[Entry]) -> io::Result<()> {
        let mut begun: BTreeMap<u16, Begun> = BTreeMap::new();
        for Entry { wheel, tick, what } in entries {
            self.last = self.last.max(*tick);
            if let Happening::State(state) = what {
                if let Some(begun) = begun.remove(wheel) {
                    self.put(*wheel, begun)?;
                }
                self.block(Kind::State, *wheel, (*tick, *tick), &state::write(*tick, state))?;
                continue;
            }
            let filled = begun.entry(*wheel).or_insert_with(|| Begun {
                entries: EntryWriter::starting_at(*tick),
                first: *tick,
                last: *tick,
            });
            filled.entries.put(*tick, what);
            filled.last = *tick;
            if filled.entries.len() >= LONG_ENOUGH_BYTES
                && let Some(begun) = begun.remove(wheel)
            {
                self.put(*wheel, begun)?;
            }
        }
        for (wheel, begun) in begun {
            self.put(wheel, begun)?;
        }
        Ok(())
    }

    fn put(&mut self, wheel: u16, begun: Begun) -> io::Result<()> {
        self.block(Kind::Entries, wheel, (begun.first, begun.last), &begun.entries.into_bytes())
    }

    fn block(&mut self, kind: Kind, wheel: u16, span: (Tick, Tick), plain: &[u8]) -> io::Result<()> {
        if plain.len() > PLAIN_MAX {
            // nobody could read it
            return Err(io::Error::new(io::ErrorKind::InvalidData, "a block is longer than any may be"));
        }
        self.out.write_all(&block(kind, wheel, self.number, span, plain))?;
        self.number += 1;
        Ok(())
    }

    /// Writes that the studio was closed before `now`, and gives back what was written to.
    ///
    /// # Errors
    /// What the system says.
    pub fn finish(mut self, now: Tick) -> io::Result<W> {
        let end = now.max(self.last);
        self.block(Kind::End, 0, (end, end), &[])?;
        self.out.flush()?;
        Ok(self.out)
    }
}
