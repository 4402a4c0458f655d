//! The session file: everything that happened at the wheels of a studio, so that it can be gone through again.
//!
//! Owns the way to the disk and back; what there is to tell is the room's ([`Happening`]), how it lies in bytes is
//! `format`'s and `entries`' affair, and `server/SESSION-FILE.md` describes it for other programs.
//! Invariant: what is read back is what was written, up to the last block that is whole; from any other bytes comes an error
//! and nothing else.
//!
//! [`Happening`]: pottery_shared::room::Happening

mod entries;
mod format;
mod playback;
mod reader;
mod recorder;
mod state;
mod writer;

pub use playback::Playback;
pub use reader::Recording;
pub(crate) use recorder::Recorder;
pub use writer::RecordingWriter;

use pottery_shared::room::ReplayError;

/// Why a session file cannot be gone through.
#[derive(Debug, thiserror::Error)]
pub enum RecordingError {
    /// The system does not give the file; look for it elsewhere.
    #[error("it cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// Something else than a session file; choose another file.
    #[error("it is no session file")]
    NotASession,
    /// Written by a studio of a later day; get that one.
    #[error(
        "it is a session file of version {version} and this studio reads up to version {newest}: get a newer studio"
    )]
    FromTheFuture {
        /// The version in the file.
        version: u32,
        /// The newest that is known here.
        newest: u32,
    },
    /// The bytes are not those that were written; take another copy.
    #[error("its bytes from {at} on are not those that were written: take another copy of it")]
    Damaged {
        /// Where the block begins that is not whole.
        at: u64,
    },
    /// The bytes are sound and stand for nothing; the file was not written by a studio.
    #[error("its {what} at byte {at} means nothing: it was not written by a studio")]
    Meaningless {
        /// What should be there.
        what: &'static str,
        /// Where its block begins.
        at: u64,
    },
    /// It ends before anything was kept; there is nothing to see in it.
    #[error("it ends before anything was kept of wheel {wheel}: the studio was closed at once, or killed")]
    Empty {
        /// The wheel, numbered from 1.
        wheel: u16,
    },
    /// A wheel that the studio did not have; choose another.
    #[error("there is no wheel {wheel}: they are numbered from 1, and the studio had {wheels}")]
    Wheel {
        /// The wheel asked for, numbered from 1.
        wheel: u16,
        /// How many there were.
        wheels: u16,
    },
    /// What is told cannot have happened; the file was not written by a studio.
    #[error("it cannot be gone through, {source}: it was not written by a studio")]
    Replay {
        /// What is in the way.
        #[from]
        source: ReplayError,
    },
}
