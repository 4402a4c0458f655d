//! Pots that outlast the server: a file for each wheel in a folder, written while people work and read at the next start, or only put by.
//!
//! Owns the folder, when a pot is due and what is said when the disk does not take it; the clay is copied, never held up.
//! Invariant: a file is replaced whole or not at all, and none is ever thrown away but of those put by, of which the last one of each wheel stays.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use pottery_files::pot_file::{PotFile, PotFileError};
use pottery_shared::clay::Material;
use tokio::sync::oneshot;
use tokio::sync::oneshot::error::TryRecvError;

use crate::folder::Folder;

/// Longest time that pressed clay is only in memory.
const KEEP_EVERY: Duration = Duration::from_secs(30);
/// Time from one [`Store::look`] to the next.
pub(crate) const LOOK_EVERY: Duration = Duration::from_millis(100);
/// Looks within which every wheel is looked at: ten seconds.
const LOOKS: usize = 100;

/// Why a folder is no place for pots.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// It cannot be had.
    #[error("the folder {path} cannot be used for pots ({source}): choose another with --data")]
    Folder {
        /// Which.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// A file stands there.
    #[error("{path} is a file and no folder: choose a folder with --data")]
    NoFolder {
        /// Which.
        path: PathBuf,
    },
    /// Another server's pots lie in it.
    #[error("another server uses the folder {path}: choose another with --data, or stop that server")]
    Taken {
        /// Which.
        path: PathBuf,
    },
    /// A pot in it cannot be opened.
    #[error(
        "{source}; take the file out of the folder, or begin with new pots (--fresh), which keeps it under another name"
    )]
    Pot {
        /// What is in the way.
        source: PotFileError,
    },
    /// Pots of different makes.
    #[error(
        "the pot kept for wheel {wheel} has another grid, size or wall than the first one: take it out of the folder, or begin with new pots (--fresh)"
    )]
    Unlike {
        /// Which, counted from 1.
        wheel: usize,
    },
    /// A pot was to be opened where others are kept.
    #[error("{path} has pots already: leave the opened one out, or begin with new pots (--fresh)")]
    Opened {
        /// The folder.
        path: PathBuf,
    },
}

/// What tells whether a file is still true: digest of the pot, and what it is made of.
pub(crate) type Mark = (u64, Material);

/// One wheel's file.
#[derive(Debug)]
struct Shelf {
    path: PathBuf,
    /// Where its pot goes at the end, if it is only put by.
    last: Option<PathBuf>,
    /// That of the pot in the file.
    kept: Option<Mark>,
    /// Digest of the clay that is not worth a file.
    untouched: Option<u64>,
    /// When it was last looked at.
    looked_at: Duration,
    writing: Option<oneshot::Receiver<Result<Mark, String>>>,
}

impl Shelf {
    const fn empty(path: PathBuf) -> Self {
        Self { path, last: None, kept: None, untouched: None, looked_at: Duration::ZERO, writing: None }
    }

    /// Whether the file is to be written for a pot of that mark.
    fn lacks(&self, mark: Mark) -> bool {
        self.kept != Some(mark) && self.untouched != Some(mark.0)
    }
}

/// The pots of a room on disk.
#[derive(Debug)]
pub(crate) struct Store {
    shelves: Vec<Shelf>,
    /// Nobody else writes there until the last pot is written.
    _folder: Folder,
    /// The wheel that is looked at next.
    next: usize,
    /// Pots that could not be written, in a row.
    failures: u64,
    written: u64,
}

/// What the store did since it was last asked, for those who watch.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct StoreCounts {
    /// Pots written.
    pub written: u64,
    /// Pots in a row that could not be.
    pub failures: u64,
}

/// The file of a wheel, numbered from 0.
fn file(folder: &Path, wheel: usize) -> PathBuf {
    folder.join(format!("wheel-{}.pot", wheel + 1))
}

/// Where the pot of a wheel, numbered from 0, lies that was put by in a [`spare`](crate::ServerConfig::spare) folder, once its server has ended.
#[must_use]
pub fn last_pot(spare: &Path, wheel: usize) -> PathBuf {
    spare.join(format!("wheel-{}-last.pot", wheel + 1))
}

/// Has the pot that was put by in a file, if there is one, take the place of the last one.
fn make_last(path: &Path, last: &Path) -> io::Result<()> {
    match fs::rename(path, last) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => Ok(()),
        renamed => renamed,
    }
}

/// Gives what stands at a path another name, the first that is free.
fn put_aside(path: &Path) -> io::Result<PathBuf> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let name = |number: u32| path.with_file_name(format!("{stem}-before-{number}.pot"));
    let free = (1..).map(name).find(|path| !path.exists()).unwrap_or_else(|| name(0));
    fs::rename(path, &free)?;
    Ok(free)
}

impl Store {
    /// Opens a folder that is held for so many wheels, and the pots that lie in it; `fresh` puts those aside.
    ///
    /// # Errors
    /// [`StoreError`] saying what is in the way.
    pub(crate) fn open(folder: Folder, wheels: usize, fresh: bool) -> Result<(Self, Vec<Option<PotFile>>), StoreError> {
        let refused = |source| StoreError::Folder { path: folder.path().to_path_buf(), source };
        let mut pots = Vec::new();
        let mut shelves = Vec::new();
        for wheel in 0..wheels {
            let path = file(folder.path(), wheel);
            let is_there = path.try_exists().map_err(refused)?;
            if is_there && fresh {
                let aside = put_aside(&path).map_err(refused)?;
                tracing::info!(pot = %aside.display(), "an earlier pot was put aside");
            }
            let pot = match is_there && !fresh {
                true => Some(PotFile::read(&path).map_err(|source| StoreError::Pot { source })?),
                false => None,
            };
            shelves.push(Shelf::empty(path));
            pots.push(pot);
        }
        Ok((Self { shelves, _folder: folder, next: 0, failures: 0, written: 0 }, pots))
    }

    /// Opens a folder in which pots are only put by; those from before get the name of [`last_pot`], and clay as it is now is not worth a file.
    ///
    /// # Errors
    /// [`StoreError`] saying what is in the way.
    pub(crate) fn put_by(
        folder: Folder,
        wheels: usize,
        mark: impl Fn(usize) -> Option<Mark>,
    ) -> Result<Self, StoreError> {
        let refused = |source| StoreError::Folder { path: folder.path().to_path_buf(), source };
        let mut shelves = Vec::new();
        for wheel in 0..wheels {
            let (path, last) = (file(folder.path(), wheel), last_pot(folder.path(), wheel));
            // of a server that was killed
            make_last(&path, &last).map_err(refused)?;
            let untouched = mark(wheel).map(|(digest, _)| digest);
            shelves.push(Shelf { last: Some(last), untouched, ..Shelf::empty(path) });
        }
        Ok(Self { shelves, _folder: folder, next: 0, failures: 0, written: 0 })
    }

    /// Notes that the pots are as they are on disk, or not worth a file yet.
    pub(crate) fn know(&mut self, mark: impl Fn(usize) -> Option<Mark>) {
        for (wheel, shelf) in self.shelves.iter_mut().enumerate() {
            shelf.kept = mark(wheel);
        }
    }

    /// Looks at the next wheels, so many that each has its turn often enough, and begins to write a pot when that is due: it has changed,
    /// and either half a minute will have gone by before the next look or everybody has left it. `take` copies the pot.
    pub(crate) fn look(
        &mut self,
        now: Duration,
        mark: impl Fn(usize) -> Option<Mark>,
        is_left: impl Fn(usize) -> bool,
        mut take: impl FnMut(usize) -> Option<PotFile>,
    ) {
        let wheels = self.shelves.len();
        let at_once = wheels.div_ceil(LOOKS);
        let round = LOOK_EVERY * wheels.div_ceil(at_once.max(1)) as u32;
        for _ in 0..at_once {
            let wheel = self.next;
            self.next = (wheel + 1) % wheels;
            self.settle(wheel);
            let is_due = now + round >= self.shelves[wheel].looked_at + KEEP_EVERY || is_left(wheel);
            self.keep(wheel, now, is_due, &mark, &mut take);
        }
    }

    /// Begins to write a wheel's pot when that is due and it has changed.
    fn keep(
        &mut self,
        wheel: usize,
        now: Duration,
        is_due: bool,
        mark: impl Fn(usize) -> Option<Mark>,
        take: impl FnOnce(usize) -> Option<PotFile>,
    ) {
        let Some(shelf) = self.shelves.get_mut(wheel) else { return };
        if !is_due || shelf.writing.is_some() {
            return;
        }
        let Some(mark) = mark(wheel).filter(|mark| shelf.lacks(*mark)) else {
            shelf.looked_at = now;
            return;
        };
        let Some(pot) = take(wheel) else { return };
        shelf.looked_at = now;
        let path = shelf.path.clone();
        let (outcome, written) = oneshot::channel();
        shelf.writing = Some(written);
        tokio::task::spawn_blocking(move || {
            // nobody waits for it when the server has ended meanwhile
            drop(outcome.send(pot.write(&path).map(|()| mark).map_err(|error| error.to_string())));
        });
    }

    /// Takes in what came of writing a wheel's pot, if it is through.
    fn settle(&mut self, wheel: usize) {
        let Some(shelf) = self.shelves.get_mut(wheel) else { return };
        let outcome = match shelf.writing.as_mut().map(oneshot::Receiver::try_recv) {
            None | Some(Err(TryRecvError::Empty)) => return,
            Some(Ok(outcome)) => outcome,
            Some(Err(TryRecvError::Closed)) => Err("the thread did not end well".into()),
        };
        shelf.writing = None;
        match outcome {
            Ok(mark) => {
                shelf.kept = Some(mark);
                self.written += 1;
                if std::mem::take(&mut self.failures) > 0 {
                    tracing::info!("pots are kept again");
                }
            }
            Err(reason) => {
                self.failures += 1;
                if self.failures == 1 {
                    tracing::error!("pots are not kept at the moment, and the lesson goes on: {reason}");
                }
            }
        }
    }

    pub(crate) const fn counts(&self) -> StoreCounts {
        StoreCounts { written: self.written, failures: self.failures }
    }

    /// Writes all that has changed and waits for it, and has what was put by take the place of the last; the sentences of what could not be.
    pub(crate) async fn finish(
        mut self,
        mark: impl Fn(usize) -> Option<Mark>,
        take: impl Fn(usize) -> Option<PotFile>,
    ) -> Vec<String> {
        let mut troubles = Vec::new();
        for (wheel, shelf) in self.shelves.iter_mut().enumerate() {
            if let Some(task) = shelf.writing.take()
                && let Ok(Ok(written)) = task.await
            {
                shelf.kept = Some(written);
            }
            let changed = mark(wheel).is_some_and(|mark| shelf.lacks(mark)).then(|| take(wheel)).flatten();
            if let Some(pot) = changed {
                let path = shelf.path.clone();
                match tokio::task::spawn_blocking(move || pot.write(&path)).await {
                    Ok(Ok(())) => {}
                    Ok(Err(error)) => troubles.push(error.to_string()),
                    Err(error) => troubles.push(error.to_string()),
                }
            }
            if let Some(last) = &shelf.last
                && let Err(error) = make_last(&shelf.path, last)
            {
                troubles.push(format!("{} stays at {} ({error})", last.display(), shelf.path.display()));
            }
        }
        troubles
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pottery_shared::clay::{Conditions, Pot, PotSpec};
    use pottery_shared::units::Tick;

    /// Lets time pass, a second at a time, with somebody at the one wheel, whose clay has that digest; how often its pot was copied.
    async fn passed(store: &mut Store, seconds: std::ops::Range<u64>, digest: u64) -> u32 {
        let mut copied = 0;
        for second in seconds {
            let take = |_| {
                copied += 1;
                let pot = Pot::new(PotSpec::default()).ok()?;
                Some(PotFile::of(&pot, &Conditions::default(), Tick(0)))
            };
            store.look(Duration::from_secs(second), |_| Some((digest, Material::default())), |_| false, take);
            // what is written is written before the next second
            if let Some(writing) = store.shelves[0].writing.take() {
                let outcome = writing.await.expect("the thread ends well");
                store.shelves[0].kept = Some(outcome.expect("there is room for a pot"));
            }
        }
        copied
    }

    #[tokio::test]
    async fn a_pot_that_people_work_at_is_written_every_half_minute_and_only_when_it_changes() {
        let folder = std::env::temp_dir().join(format!("pottery-store-{}", std::process::id()));
        let held = Folder::hold(&folder).expect("a new folder can be made");
        let (mut store, _) = Store::open(held, 1, false).expect("it has no pots");
        store.know(|_| Some((1, Material::default())));
        let path = file(&folder, 0);
        assert_eq!(passed(&mut store, 0..120, 1).await, 0, "nobody has touched it");
        assert!(!path.exists());
        // the last look was at 90 s, so that the next is at 120 s
        assert_eq!((passed(&mut store, 120..121, 2).await, path.exists()), (1, true));
        assert_eq!(passed(&mut store, 121..150, 3).await, 0, "not before half a minute has passed");
        assert_eq!(passed(&mut store, 150..151, 3).await, 1);
        assert_eq!(passed(&mut store, 151..400, 3).await, 0, "it is as it was written");
        fs::remove_dir_all(folder).expect("what was written can be removed");
    }

    #[tokio::test]
    async fn no_pot_waits_longer_than_half_a_minute_however_many_there_are() {
        for wheels in [1, 99, 150, 300, 301, 1024] {
            let folder = std::env::temp_dir().join(format!("pottery-store-many-{}-{wheels}", std::process::id()));
            let held = Folder::hold(&folder).expect("a new folder can be made");
            let (mut store, _) = Store::open(held, wheels, false).expect("it has no pots");
            store.know(|_| Some((1, Material::default())));
            let mut waiting: std::collections::BTreeSet<_> = (0..wheels).collect();
            let mut most = 0;
            for look in 0..=300 {
                let before = waiting.len();
                // nothing is written: how often a pot is due is what counts
                let take = |wheel| {
                    waiting.remove(&wheel);
                    None
                };
                store.look(LOOK_EVERY * look, |_| Some((2, Material::default())), |_| false, take);
                most = most.max(before - waiting.len());
            }
            assert!(waiting.is_empty(), "of {wheels} pots {} wait longer", waiting.len());
            assert!(most <= wheels.div_ceil(LOOKS), "{most} pots are copied at once");
            fs::remove_dir_all(folder).expect("what was made can be removed");
        }
    }

    #[tokio::test]
    async fn a_pot_that_was_put_by_is_the_last_one_and_untouched_clay_is_not_put_by() {
        let folder = std::env::temp_dir().join(format!("pottery-store-spare-{}", std::process::id()));
        let open = || {
            let held = Folder::hold(&folder).expect("the folder can be had");
            Store::put_by(held, 1, |_| Some((1, Material::default()))).expect("its files can be renamed")
        };
        let pot = |_| Some(PotFile::of(&Pot::new(PotSpec::default()).ok()?, &Conditions::default(), Tick(0)));
        let (now, last) = (file(&folder, 0), last_pot(&folder, 0));
        let is_there = || (now.exists(), last.exists());
        let mut store = open();
        assert_eq!(passed(&mut store, 0..100, 2).await, 1);
        assert_eq!(passed(&mut store, 100..200, 1).await, 0, "a new pot does not take the place of what was pressed");
        assert_eq!(is_there(), (true, false));
        // one that was killed
        drop(store);
        assert_eq!(passed(&mut open(), 0..100, 1).await, 0);
        assert_eq!(is_there(), (false, true), "a session in which nobody pressed leaves the last pot where it is");
        fs::remove_file(&last).expect("it is there");
        assert!(open().finish(|_| Some((1, Material::default())), pot).await.is_empty());
        assert_eq!(is_there(), (false, false));
        assert!(open().finish(|_| Some((2, Material::default())), pot).await.is_empty());
        assert_eq!(is_there(), (false, true));
        fs::remove_dir_all(folder).expect("what was written can be removed");
    }

    #[tokio::test]
    async fn a_pot_whose_folder_has_gone_is_told_at_the_end() {
        let folder = std::env::temp_dir().join(format!("pottery-store-gone-{}", std::process::id()));
        let open = || {
            let held = Folder::hold(&folder).expect("a new folder can be made");
            let (mut store, _) = Store::open(held, 2, false).expect("it has no pots");
            store.know(|_| Some((1, Material::default())));
            store
        };
        let pot = || Some(PotFile::of(&Pot::new(PotSpec::default()).ok()?, &Conditions::default(), Tick(0)));
        let (whole, lost) = (open().finish(|_| Some((2, Material::default())), |_| pot()).await, open());
        assert!(whole.is_empty(), "{whole:?}");
        fs::remove_dir_all(&folder).expect("what was written can be removed");
        let told = lost.finish(|wheel| Some((1 + wheel as u64, Material::default())), |_| pot()).await;
        assert!(told.len() == 1 && told[0].contains("wheel-2.pot"), "the first is as it was: {told:?}");
    }
}
