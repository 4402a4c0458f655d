//! Recordings of strokes, written at the end of a session.
//!
//! Invariant: a recording is written whole or a sentence says why not.

use std::path::Path;

use pottery_client::stroke::StrokeRecorder;
use pottery_client::whole_file::write_whole;

/// Writes a recording, or says that there is nothing to write.
pub(crate) fn write(recording: Option<StrokeRecorder>, path: &Path) -> anyhow::Result<()> {
    let Some(recording) = recording.filter(|recording| !recording.is_empty()) else {
        say!("nothing was recorded: the tool was never in hand");
        // the empty file that showed it could be written
        if std::fs::metadata(path).is_ok_and(|file| file.len() == 0) {
            std::fs::remove_file(path)?;
        }
        return Ok(());
    };
    write_whole(path, |file| recording.write_to(file))?;
    say!("recorded   {}", path.display());
    Ok(())
}
