//! The thread that writes a session file while the studio is open.
//!
//! Owns the queue between the room's task and the disk. The task never waits for the disk: where the disk does not keep up,
//! the recording ends there and says so.
//! Invariant: nothing that happened is left out between two things that are in the file.

use std::fs::{File, OpenOptions};
use std::io;
use std::path::Path;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread::JoinHandle;

use pottery_shared::room::{Entry, Room};
use pottery_shared::units::Tick;

use super::RecordingWriter;

/// Ticks that are written at once: what a studio that is killed loses at most.
const WRITE_EVERY: i64 = 1000;
/// Batches that may wait for the disk: half a minute.
const WAITING_MAX: usize = 32;

/// What waits for the disk.
#[derive(Debug)]
enum Batch {
    Entries(Vec<Entry>),
    End(Tick),
}

/// Keeps what a room's journal tells.
#[derive(Debug)]
pub(crate) struct Recorder {
    entries: Vec<Entry>,
    written_at: Tick,
    queue: SyncSender<Batch>,
    /// Whether it wrote all.
    writing: JoinHandle<bool>,
}

impl Recorder {
    /// Begins a file, which must not exist yet, and the room's journal.
    ///
    /// # Errors
    /// What the system says.
    pub(crate) fn begin(path: &Path, room: &mut Room) -> io::Result<Self> {
        let file = OpenOptions::new().write(true).create_new(true).open(path)?;
        let wheels = u16::try_from(room.wheels()).map_err(|_| io::ErrorKind::InvalidInput)?;
        let writer = RecordingWriter::begin(file, wheels)?;
        let (queue, waiting) = sync_channel(WAITING_MAX);
        let writing = std::thread::Builder::new().name("recording".into()).spawn(move || write(writer, &waiting))?;
        room.keep_journal();
        Ok(Self { entries: Vec::new(), written_at: room.now(), queue, writing })
    }

    /// Takes over what the journal tells; false when the file can be written no longer, which is said then.
    pub(crate) fn take(&mut self, room: &mut Room) -> bool {
        self.entries.extend(std::iter::from_fn(|| room.poll_journal()));
        if room.now().since(self.written_at) < WRITE_EVERY {
            return true;
        }
        self.written_at = room.now();
        let entries = std::mem::take(&mut self.entries);
        if entries.is_empty() {
            return true;
        }
        let sent = self.queue.try_send(Batch::Entries(entries));
        if let Err(TrySendError::Full(_)) = sent {
            // a thread that has ended said why
            tracing::error!("the recording ends here: the disk does not keep up");
        }
        sent.is_ok()
    }

    /// What is left to be written when the studio is closed.
    pub(crate) fn last(mut self, room: &mut Room) -> Last {
        self.entries.extend(std::iter::from_fn(|| room.poll_journal()));
        Last { recorder: self, now: room.now() }
    }
}

/// The last of a recording.
#[derive(Debug)]
pub(crate) struct Last {
    recorder: Recorder,
    now: Tick,
}

impl Last {
    /// Writes it, and waits until it is on the disk; false when the file is not whole.
    pub(crate) fn write(self) -> bool {
        let Recorder { entries, queue, writing, .. } = self.recorder;
        // a thread that has ended said why
        drop(queue.send(Batch::Entries(entries)));
        drop(queue.send(Batch::End(self.now)));
        drop(queue);
        writing.join().unwrap_or_else(|_| {
            tracing::error!("the thread of the recording did not end well");
            false
        })
    }
}

fn write(mut writer: RecordingWriter<File>, waiting: &Receiver<Batch>) -> bool {
    let outcome = loop {
        match waiting.recv() {
            Ok(Batch::Entries(entries)) => {
                if let Err(error) = writer.write(&entries) {
                    break Err(error);
                }
            }
            Ok(Batch::End(tick)) => break writer.finish(tick).and_then(|file| file.sync_all()),
            // let go without an end: the file ends with the last block
            Err(_) => break Ok(()),
        }
    };
    outcome
        .inspect_err(|error| tracing::error!(%error, "the recording ends here: it cannot be written any longer"))
        .is_ok()
}
