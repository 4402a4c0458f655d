//! The join code of a server that may be killed: kept while it runs, so that the next one lets the same people back in.
//!
//! Owns the file in the data folder; what the code is, the settings and the room say.
//! Invariant: a server that ends as it should leaves no code behind, and the file can be read by its user alone.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use pottery_shared::protocol::JoinCode;
use tokio::task::JoinHandle;

use crate::folder::write_private;

/// The file in the data folder.
const FILE: &str = "join-code";

/// The code as it was last kept.
#[derive(Debug)]
pub(crate) struct KeptCode {
    path: PathBuf,
    code: String,
    writing: Option<JoinHandle<()>>,
}

impl KeptCode {
    /// The code of a server that came to no end, if one has left it in the folder within so many hours.
    pub(crate) fn left_in(folder: &Path, hours: Option<f64>) -> Option<JoinCode> {
        let path = folder.join(FILE);
        let code = fs::read_to_string(&path).ok()?;
        let age = fs::metadata(&path).and_then(|about| about.modified()).ok()?.elapsed().unwrap_or_default();
        let is_good = hours.is_none_or(|hours| age.as_secs_f64() < hours * 3600.0);
        code.trim().parse().ok().filter(|_| is_good)
    }

    /// Keeps the code of a server that begins.
    pub(crate) fn begin(folder: &Path, code: &str) -> Self {
        let path = folder.join(FILE);
        write(&path, code);
        Self { path, code: code.to_owned(), writing: None }
    }

    /// Keeps another code, if it is one, beside the room's work; one that comes too soon after another waits for the next call.
    pub(crate) fn follow(&mut self, code: &str) {
        if self.code == code || self.writing.as_ref().is_some_and(|writing| !writing.is_finished()) {
            return;
        }
        code.clone_into(&mut self.code);
        let (path, code) = (self.path.clone(), self.code.clone());
        self.writing = Some(tokio::task::spawn_blocking(move || write(&path, &code)));
    }

    /// Leaves no code behind.
    pub(crate) async fn end(self) {
        if let Some(writing) = self.writing {
            // one that panicked has written nothing
            drop(writing.await);
        }
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                tracing::warn!("the join code is left in {}: {error}", self.path.display());
            }
            _ => {}
        }
    }
}

fn write(path: &Path, code: &str) {
    if let Err(reason) = write_private(path, code.as_bytes()) {
        tracing::warn!("a server that is killed will come back with another join code: {reason}");
    }
}
