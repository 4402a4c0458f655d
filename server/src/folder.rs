//! The data folder in the hands of one server.
//!
//! Owns the lock, the proof that the folder takes files, and how one is kept from others; what else lies in it is `store`'s, `certificate`'s, `teacher`'s and `class_register`'s.
//! Invariant: of two servers on one folder one is refused, and one that is killed leaves nothing locked.

use std::fs::{self, File, TryLockError};
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use pottery_files::whole_file::write_whole;

use crate::store::StoreError;

/// The file that is locked; it holds nothing and stays.
const LOCK: &str = "server.lock";

/// A folder that no other server uses as long as this value lives.
#[derive(Debug)]
pub(crate) struct Folder {
    path: PathBuf,
    _lock: File,
}

impl Folder {
    /// Makes the folder where it is missing, sees that files can be made in it, and locks it.
    ///
    /// # Errors
    /// [`StoreError`] saying what is in the way.
    pub(crate) fn hold(path: &Path) -> Result<Self, StoreError> {
        if path.is_file() {
            return Err(StoreError::NoFolder { path: path.to_path_buf() });
        }
        let refused = |source| StoreError::Folder { path: path.to_path_buf(), source };
        fs::create_dir_all(path).map_err(refused)?;
        try_out(path).map_err(refused)?;
        let lock = File::options().write(true).create(true).truncate(false).open(path.join(LOCK)).map_err(refused)?;
        match lock.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(StoreError::Taken { path: path.to_path_buf() }),
            // some network disks have no locks
            Err(TryLockError::Error(error)) => {
                tracing::warn!("nobody can see whether another server uses the data folder: {error}");
            }
        }
        Ok(Self { path: path.to_path_buf(), _lock: lock })
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }
}

/// Writes a file that nobody but the server's user may read.
///
/// # Errors
/// What is in the way, in words.
pub(crate) fn write_private(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let mut options = File::options();
    options.write(true).create(true).truncate(false);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    // where there is none, an empty one first, whose permissions stay
    options.open(path).map_err(|error| error.to_string())?;
    write_whole(path, |file| file.write_all(bytes)).map_err(|error| error.to_string())
}

/// Makes a file and takes it away again, as every pot is written.
fn try_out(folder: &Path) -> io::Result<()> {
    let path = folder.join(format!(".pottery-{}-try.part", std::process::id()));
    File::create(&path)?;
    fs::remove_file(&path)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_folder_is_one_servers_until_that_server_is_gone() {
        let path = std::env::temp_dir().join(format!("pottery-folder-{}", std::process::id()));
        let first = Folder::hold(&path).expect("a new folder can be made");
        let said = Folder::hold(&path).expect_err("two servers would write over each other's pots").to_string();
        assert!(said.contains("another server") && said.contains("--data"), "{said}");
        drop(first);
        drop(Folder::hold(&path).expect("the first is gone"));
        let said = Folder::hold(&path.join(LOCK)).expect_err("that is a file").to_string();
        assert!(said.contains("no folder"), "{said}");
        let left: Vec<_> = fs::read_dir(&path).expect("it is there").map(|entry| entry.unwrap().file_name()).collect();
        assert_eq!(left, [LOCK], "nothing is left of trying it out");
        fs::remove_dir_all(path).expect("what was made can be removed");
    }
}
