//! The pot file: a pot with what its wheel was set to, so that work can go on another day.
//!
//! Owns what is kept and the sentences when a file cannot be used; how it lies in bytes is `format`'s affair, and
//! `shared/files/POT-FILE.md` describes it for other programs.
//! Invariant: the pot read back is the pot written, bit for bit; from any other bytes comes an error and nothing else.

mod format;

use std::fs::File;
use std::io::{self, Read, Write};
use std::path::{Path, PathBuf};

use pottery_shared::clay::{Conditions, Material, MaterialError, MethodKind, Pot, Wheel};
use pottery_shared::snapshot::{PotRecord, RecordError};
use pottery_shared::units::{Rpm, Tick};

use crate::whole_file::{WriteError, write_whole};

/// A pot and what its wheel was set to.
///
/// ```
/// use pottery_files::pot_file::PotFile;
/// use pottery_shared::clay::{Conditions, Pot, PotSpec};
/// use pottery_shared::units::Tick;
///
/// let file = PotFile::of(&Pot::new(PotSpec::default())?, &Conditions::default(), Tick(0));
/// assert_eq!(PotFile::decode(&file.encode())?, file);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct PotFile {
    pot: PotRecord,
    method: MethodKind,
    wheel_speed: Rpm,
    clay: Material,
}

/// Why bytes are no pot.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FormatError {
    /// Something else than a pot file; choose another file.
    #[error("it is no pot file")]
    NotAPot,
    /// Written by a studio of a later day; get that one.
    #[error("it is a pot file of version {version} and this studio reads up to version {newest}: get a newer studio")]
    FromTheFuture {
        /// The version in the file.
        version: u32,
        /// The newest that is known here.
        newest: u32,
    },
    /// Cut short, or grown; take another copy.
    #[error("it has {bytes} bytes where a whole one has {expected}: take another copy of it")]
    Length {
        /// What there is.
        bytes: usize,
        /// What there should be.
        expected: usize,
    },
    /// The bytes are not those that were written; take another copy.
    #[error("its bytes are not those that were written: take another copy of it")]
    Checksum,
    /// A number stands for nothing; the file was not written by a studio.
    #[error("its {field} {number} means nothing: it was not written by a studio")]
    Number {
        /// Which.
        field: &'static str,
        /// What the file says.
        number: u32,
    },
    /// The wheel would turn too fast, or not by a number; the file was not written by a studio.
    #[error("its wheel turns at {rpm} rpm, where one turns at -{max} to {max}: it was not written by a studio")]
    WheelSpeed {
        /// What the file says.
        rpm: f32,
        /// Fastest.
        max: f32,
    },
    /// Its clay cannot be had; the file was not written by a studio.
    #[error("its clay cannot be had: {0}")]
    Clay(#[from] MaterialError),
    /// The radii are not packed as they should be; the file was not written by a studio.
    #[error("its radii cannot be unpacked: it was not written by a studio")]
    Packing,
    /// The radii make no pot of its measures; the file was not written by a studio.
    #[error(transparent)]
    Pot(#[from] RecordError),
    /// This studio would make another pot of it; use the one that wrote it.
    #[error("its pot would come out differently here: use the studio that wrote it")]
    Digest,
}

/// Why a pot file was not read or written.
#[derive(Debug, thiserror::Error)]
pub enum PotFileError {
    /// The system does not give the file; look for it elsewhere.
    #[error("{path} cannot be read: {source}")]
    Read {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The file is no pot that can be opened.
    #[error("{path} cannot be opened: {source}")]
    Format {
        /// Which file.
        path: PathBuf,
        /// What is in the way.
        source: FormatError,
    },
    /// The file was not written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl PotFile {
    /// What there is to keep of a pot on a wheel at a tick; the radii are rounded as a snapshot rounds them.
    #[must_use]
    pub fn of(pot: &Pot, conditions: &Conditions, tick: Tick) -> Self {
        let fastest = Wheel::RPM_MAX.0;
        Self {
            pot: PotRecord::of(pot),
            method: conditions.method,
            // a speed that was rounded to the wheel's steps may lie a step beyond what may be asked for
            wheel_speed: Rpm(conditions.wheel.speed(tick).0.clamp(-fastest, fastest)),
            clay: conditions.material.at(tick),
        }
    }

    /// The pot.
    #[must_use]
    pub const fn pot(&self) -> &PotRecord {
        &self.pot
    }

    /// How its clay deforms.
    #[must_use]
    pub const fn method(&self) -> MethodKind {
        self.method
    }

    /// How fast its wheel turned.
    #[must_use]
    pub const fn wheel_speed(&self) -> Rpm {
        self.wheel_speed
    }

    /// What its clay is made of.
    #[must_use]
    pub const fn clay(&self) -> Material {
        self.clay
    }

    /// The file's bytes.
    #[must_use]
    pub fn encode(&self) -> Vec<u8> {
        format::encode(self)
    }

    /// The pot of a file's bytes.
    ///
    /// What is allocated is bounded by the bytes given and by the largest grid, whatever the file claims.
    ///
    /// # Errors
    /// [`FormatError`] for bytes that are no whole pot file of a version known here.
    pub fn decode(bytes: &[u8]) -> Result<Self, FormatError> {
        format::decode(bytes)
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`PotFileError::Read`] or [`PotFileError::Format`].
    pub fn read(path: &Path) -> Result<Self, PotFileError> {
        let mut bytes = Vec::new();
        // a byte more than any pot file has tells a longer one from the longest
        let read = File::open(path).and_then(|file| file.take(format::BYTES_MAX as u64 + 1).read_to_end(&mut bytes));
        read.map_err(|source| PotFileError::Read { path: path.to_path_buf(), source })?;
        Self::decode(&bytes).map_err(|source| PotFileError::Format { path: path.to_path_buf(), source })
    }

    /// Writes a file, whole or not at all.
    ///
    /// # Errors
    /// [`PotFileError::Write`]; what stood there before is then untouched.
    pub fn write(&self, path: &Path) -> Result<(), PotFileError> {
        let bytes = self.encode();
        Ok(write_whole(path, |out| out.write_all(&bytes))?)
    }
}
