//! The class register of a server that may be killed: kept while it runs, so that the next one lets the same people back in.
//!
//! Owns the file in the data folder, and until when a code that lies in it is good; what stands in a register is the room's affair.
//! Invariant: a server that ends as it should leaves no register behind, and the file can be read by its user alone.

use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use std::time::Duration;

use pottery_shared::protocol::JoinCode;
use pottery_shared::room::{Register, Room};
use pottery_shared::units::Tick;
use tokio::task::JoinHandle;

use crate::ServerConfig;
use crate::folder::write_private;

/// The file in the data folder.
const FILE: &str = "class-register";
/// What such a file begins with: of what make it is. One of another make is none.
const MAKE: [u8; 8] = *b"POTREG\0\x01";
/// How old a register may be, counted from the last change in it: a class that was there before is over.
const GOOD_FOR: Duration = Duration::from_secs(12 * 3600);
/// As many milliseconds as a code is good that is good for as long as the server runs.
const ALWAYS: u64 = u64::MAX;

/// What a server that came to no end has left.
#[derive(Debug)]
pub(crate) struct Left {
    register: Register,
    /// For how many milliseconds its code is still good, if not for as long as the server runs.
    code_ms: Option<u64>,
}

impl Left {
    /// What lies in the data folder of a server that begins so, if it can be read and is not over. Teachers are struck out of it where their token is to be
    /// another one.
    pub(crate) fn of(config: &ServerConfig) -> Option<Self> {
        let path = config.data.as_deref().filter(|_| !config.is_fresh)?.join(FILE);
        let age = fs::metadata(&path).and_then(|about| about.modified()).ok()?.elapsed().unwrap_or_default();
        let bytes = fs::read(path).ok().filter(|_| age < GOOD_FOR)?;
        let (code_ms, register) = bytes.strip_prefix(&MAKE)?.split_first_chunk()?;
        // one that is given anew is as good as a new one
        let code_ms = Some(u64::from_le_bytes(*code_ms)).filter(|ms| *ms != ALWAYS && config.code.is_none());
        let code_ms = code_ms.map(|ms| ms.saturating_sub(age.as_millis() as u64));
        let mut register = Register::from_bytes(register)?;
        if config.renews_teacher {
            register.strike_teachers();
        }
        Some(Self { register, code_ms })
    }

    /// The code in it, while it is good.
    pub(crate) fn code(&self) -> Option<JoinCode> {
        self.register.code().parse().ok().filter(|_| self.code_ms != Some(0))
    }

    /// Has a room go on with it that begins. A code that goes on has been good for some of the ticks for which a new one is.
    pub(crate) fn hand_over(self, room: &mut Room, code_ticks: Option<u64>) {
        tracing::info!(people = self.register.people(), "the server before was killed: its class can come back");
        let left = self.code_ms.filter(|_| self.register.code() == room.code());
        room.go_on_from(self.register, code_ticks.map(|whole| left.map_or(whole, |left| left.min(whole))));
    }
}

/// The register as it was last kept.
#[derive(Debug)]
pub(crate) struct ClassRegister {
    path: PathBuf,
    register: Register,
    writing: Option<JoinHandle<()>>,
}

impl ClassRegister {
    /// Keeps the register of a room that begins.
    pub(crate) fn begin(folder: &Path, room: &Room) -> Self {
        let (path, register) = (folder.join(FILE), room.register());
        write(&path, code_ms(room), &register);
        Self { path, register, writing: None }
    }

    /// Keeps what has changed since, beside the room's work; what comes too soon after something else waits for the next call.
    pub(crate) fn follow(&mut self, room: &Room) {
        if self.writing.as_ref().is_some_and(|writing| !writing.is_finished()) {
            return;
        }
        let register = room.register();
        if self.register == register {
            return;
        }
        self.register = register.clone();
        let (path, code_ms) = (self.path.clone(), code_ms(room));
        self.writing = Some(tokio::task::spawn_blocking(move || write(&path, code_ms, &register)));
    }

    /// Leaves no register behind.
    pub(crate) async fn end(self) {
        if let Some(writing) = self.writing {
            // one that panicked has written nothing
            drop(writing.await);
        }
        match fs::remove_file(&self.path) {
            Err(error) if error.kind() != ErrorKind::NotFound => {
                tracing::warn!("the class register is left in {}: {error}", self.path.display());
            }
            _ => {}
        }
    }
}

/// For how many milliseconds from now on a room's code is good.
fn code_ms(room: &Room) -> u64 {
    room.code_expires().map_or(ALWAYS, |Tick(expires)| expires.saturating_sub(room.now().0))
}

fn write(path: &Path, code_ms: u64, register: &Register) {
    let bytes = [&MAKE[..], &code_ms.to_le_bytes(), &register.to_bytes()].concat();
    if let Err(reason) = write_private(path, &bytes) {
        tracing::warn!(
            "a server that is killed will come back with another join code and without its people: {reason}"
        );
    }
}
