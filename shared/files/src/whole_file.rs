//! Files that are written whole or not at all.
//!
//! Owns the way to the disk; what a file holds is the caller's affair.
//! Invariant: until the last byte is on the disk, what stood under the name still stands there.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Names that are tried beside a file before giving up: others may be writing there too.
const NAMES_TRIED: u32 = 100;

/// Why a file was not written; what stood there before still stands there.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// A folder has that name; choose a name inside of it.
    #[error("{path} is a folder: choose the name of a file")]
    Folder {
        /// Which.
        path: PathBuf,
    },
    /// The system refused, or the disk is full; choose another place or make room.
    #[error("{path} cannot be written ({source}): choose another place, or make room there")]
    Refused {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
}

/// Writes a file: into a new one beside it, which takes its name once it is whole.
///
/// A link is followed, and permissions stay. What is no ordinary file (a pipe, a device) has nothing to be kept and is
/// written as it is.
///
/// # Errors
/// [`WriteError`]; what was there is then as it was, and nothing is left beside it.
pub fn write_whole(
    path: &Path,
    contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> Result<(), WriteError> {
    let refused = |source| WriteError::Refused { path: path.to_path_buf(), source };
    match fs::metadata(path) {
        Ok(standing) if standing.is_dir() => Err(WriteError::Folder { path: path.to_path_buf() }),
        Ok(standing) if standing.is_file() => replace(path, &standing, contents).map_err(refused),
        Ok(_) => {
            OpenOptions::new().write(true).open(path).and_then(|file| fill(file, contents).map(drop)).map_err(refused)
        }
        Err(error) if error.kind() == io::ErrorKind::NotFound => {
            Beside::new(path).and_then(|beside| beside.become_file(path, contents)).map_err(refused)
        }
        Err(error) => Err(refused(error)),
    }
}

fn replace(
    path: &Path,
    standing: &Metadata,
    contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
) -> io::Result<()> {
    if standing.permissions().readonly() {
        // the folder may allow a new name even so, but whoever protected the file meant it
        return Err(io::ErrorKind::PermissionDenied.into());
    }
    let path = path.canonicalize()?;
    let beside = Beside::new(&path)?;
    fs::set_permissions(&beside.path, standing.permissions())?;
    beside.become_file(&path, contents)
}

fn fill(file: File, contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>) -> io::Result<File> {
    let mut out = BufWriter::new(file);
    contents(&mut out)?;
    out.flush()?;
    out.into_inner().map_err(io::IntoInnerError::into_error)
}

/// A file that is not finished, removed when it does not come to that.
#[derive(Debug)]
struct Beside {
    path: PathBuf,
    file: Option<File>,
}

impl Beside {
    fn new(path: &Path) -> io::Result<Self> {
        if path.file_name().is_none() {
            return Err(io::ErrorKind::InvalidFilename.into());
        }
        for number in 0..NAMES_TRIED {
            let path = path.with_file_name(format!(".pottery-{}-{number}.part", std::process::id()));
            match OpenOptions::new().write(true).create_new(true).open(&path) {
                Ok(file) => return Ok(Self { path, file: Some(file) }),
                Err(error) if error.kind() == io::ErrorKind::AlreadyExists => {}
                Err(error) => return Err(error),
            }
        }
        Err(io::ErrorKind::AlreadyExists.into())
    }

    fn become_file(
        mut self,
        path: &Path,
        contents: impl FnOnce(&mut BufWriter<File>) -> io::Result<()>,
    ) -> io::Result<()> {
        let file = self.file.take().expect("a file is filled once");
        fill(file, contents)?.sync_all()?;
        fs::rename(&self.path, path)
    }
}

impl Drop for Beside {
    fn drop(&mut self) {
        // gone already when it took its name
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => {
                tracing::warn!(path = %self.path.display(), %error, "an unfinished file is left behind");
            }
            _ => {}
        }
    }
}
