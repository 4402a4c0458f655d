//! Recordings of strokes, written as they grow and at the end of a session.
//!
//! Owns the thread that writes what a session has recorded so far; what is recorded is the worker's.
//! Invariant: a recording is written whole or a sentence says why not, and whoever is killed loses half a minute of it, or a twentieth.

use std::fs::{self, OpenOptions};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{RecvTimeoutError, SyncSender, sync_channel};
use std::thread::JoinHandle;
use std::time::Duration;

use anyhow::{Context, ensure};
use pottery_client::sentence;
use pottery_client::stroke::StrokeRecorder;
use pottery_client::whole_file::write_whole;

/// Time between two looks whether more was recorded.
const LOOK_EVERY: Duration = Duration::from_millis(500);

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

/// Writes what was recorded so far, for a program that may be killed, until it is dropped.
#[derive(Debug)]
pub(crate) struct Keeping {
    /// Its end is the thread's.
    ends: Option<SyncSender<()>>,
    thread: Option<JoinHandle<()>>,
}

impl Keeping {
    /// Begins; `take` gives what was recorded so far, once.
    pub(crate) fn begin(path: &Path, mut take: impl FnMut() -> Option<StrokeRecorder> + Send + 'static) -> Self {
        let (ends, ended) = sync_channel::<()>(1);
        let path = PathBuf::from(path);
        let keep = move || {
            let mut is_said = false;
            while ended.recv_timeout(LOOK_EVERY) == Err(RecvTimeoutError::Timeout) {
                let Some(recording) = take().filter(|recording| !recording.is_empty()) else { continue };
                let written = write_whole(&path, |file| recording.write_to(file));
                if let (Err(error), false) = (&written, is_said) {
                    note!("what is recorded is not kept at the moment: {}", sentence(error));
                    is_said = true;
                }
            }
        };
        let thread = std::thread::Builder::new().name("recording".into()).spawn(keep);
        if let Err(error) = &thread {
            note!("what is recorded is written at the end alone: {error}");
        }
        Self { ends: Some(ends), thread: thread.ok() }
    }
}

impl Drop for Keeping {
    fn drop(&mut self) {
        drop(self.ends.take());
        if self.thread.take().is_some_and(|thread| thread.join().is_err()) {
            note!("what is recorded was not kept to the end");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use pottery_client::stroke::Stroke;
    use pottery_shared::tool::{Orientation, Tool};
    use pottery_shared::units::Rpm;

    #[test]
    fn what_is_recorded_is_in_the_file_before_the_end() {
        let path = std::env::temp_dir().join(format!("pottery-keeping-{}.csv", std::process::id()));
        let mut recording = StrokeRecorder::new(Tool::default(), Rpm(20.0));
        recording.push(0.5, Vec3::new(0.08, 0.0, 0.1), Orientation::default()).expect("the first sample can be taken");
        let mut slot = Some(recording);
        let keeping = Keeping::begin(&path, move || slot.take());
        while !path.exists() {
            std::thread::sleep(LOOK_EVERY / 10);
        }
        drop(keeping);
        assert_eq!(Stroke::read(&path).expect("it is a stroke").end(), 0.5);
        fs::remove_file(path).expect("it is there");
    }
}
