//! Recordings of strokes, written at the end of a session.
//!
//! Invariant: a recording is written whole or a sentence says why not, and until then no file is left for it.

use std::fs::{self, OpenOptions};
use std::path::Path;

use anyhow::{Context, ensure};
use pottery_client::stroke::StrokeRecorder;
use pottery_client::whole_file::write_whole;

/// Says now, not after an hour's work, that a recording cannot be written, or that one is there already.
pub(crate) fn check_writable(path: &Path) -> anyhow::Result<()> {
    let refused = || format!("the recording {} cannot be written; choose another file", path.display());
    let is_new = !path.exists();
    let file = OpenOptions::new().append(true).create(true).open(path).with_context(refused)?;
    let is_empty = file.metadata().is_ok_and(|about| about.len() == 0);
    ensure!(is_empty, "there is something in {} already; choose another file for the recording", path.display());
    if is_new {
        // where a link leads, so that the link stays
        path.canonicalize().and_then(fs::remove_file).with_context(refused)?;
    }
    Ok(())
}

/// Writes a recording, or says that there is nothing to write.
pub(crate) fn write(recording: Option<StrokeRecorder>, path: &Path) -> anyhow::Result<()> {
    let Some(recording) = recording.filter(|recording| !recording.is_empty()) else {
        say!("nothing was recorded: the tool was never in hand");
        return Ok(());
    };
    write_whole(path, |file| recording.write_to(file))?;
    say!("recorded   {}", path.display());
    Ok(())
}
