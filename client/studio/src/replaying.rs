//! A session file gone through again: in a window, or without one to compare every digest.
//!
//! Owns the sentences about it; the file is `pottery_server::recording`'s.
//! Invariant: without a window it ends in success only when every snapshot came out as it was recorded.

use std::fs::{self, File};
use std::io::BufReader;
use std::path::{Path, PathBuf};

use anyhow::{Context, bail};
use pottery_client::pot_file::PotFile;
use pottery_server::recording::{Playback, Recording};
use pottery_shared::units::Tick;

use crate::window;

/// What to go through, and how.
#[derive(Clone, Debug)]
pub(crate) struct ReplaySession {
    pub(crate) path: PathBuf,
    /// From the first tick that was kept.
    pub(crate) at_s: Option<f64>,
    /// Numbered from 1.
    pub(crate) wheel: u16,
    /// Folder for the pot; none with a window.
    pub(crate) out: Option<PathBuf>,
}

/// A session that stands where it is to begin.
#[derive(Debug)]
pub(crate) struct Session {
    pub(crate) playback: Playback<BufReader<File>>,
    /// First and last tick.
    pub(crate) span: (Tick, Tick),
}

impl Session {
    fn open(path: &Path, wheel: u16) -> anyhow::Result<Self> {
        let opened = || format!("the session {}", path.display());
        let file = File::open(path).with_context(opened)?;
        let recording = Recording::open(BufReader::new(file)).with_context(opened)?;
        let Some(place) = wheel.checked_sub(1) else { bail!("there is no wheel 0: they are numbered from 1") };
        let playback = Playback::begin(recording, place).with_context(opened)?;
        let recording = playback.recording();
        let span = recording.span(place).unwrap_or_default();
        if !recording.is_whole() {
            note!("the session was cut short after {:.1} s: it is replayed up to there", seconds(span.1, span));
        }
        Ok(Self { playback, span })
    }

    /// The tick so many seconds after the first.
    pub(crate) fn tick_at(&self, at_s: f64) -> Tick {
        Tick(self.span.0.0.saturating_add((at_s * Tick::PER_SECOND as f64).round() as u64).min(self.span.1.0))
    }

    /// Seconds from the first tick to where it stands.
    pub(crate) fn at_s(&self) -> f64 {
        seconds(self.playback.tick(), self.span)
    }
}

/// Seconds from the first tick of a span to another.
pub(crate) fn seconds(tick: Tick, span: (Tick, Tick)) -> f64 {
    tick.since(span.0) as f64 / Tick::PER_SECOND as f64
}

/// Goes through a session.
pub(crate) fn run(asked: &ReplaySession) -> anyhow::Result<()> {
    let mut session = Session::open(&asked.path, asked.wheel)?;
    let length_s = seconds(session.span.1, session.span);
    if asked.at_s.is_some_and(|at_s| at_s > length_s) {
        note!("the session ends after {length_s:.1} s: its end is shown");
    }
    let Some(out) = &asked.out else {
        let at = session.tick_at(asked.at_s.unwrap_or(0.0));
        session.playback.seek(at)?;
        return match window::replay(session)? {
            window::Ended::ByPerson => Ok(()),
            window::Ended::NoDisplay(reason) => bail!("no window can be opened here ({reason}): use --headless"),
        };
    };
    fs::create_dir_all(out)
        .with_context(|| format!("the folder {} cannot be made; choose another with --out", out.display()))?;
    let to = asked.at_s.map_or(session.span.1, |at_s| session.tick_at(at_s));
    // from the beginning, so that all is compared
    session.playback.advance(to)?;
    let replay = session.playback.replay();
    PotFile::of(replay.pot(), replay.conditions(), to).write(&out.join("pot.pot"))?;
    let comparison = replay.comparison();
    say!("replayed   {:.1} s of wheel {}, written by {}", session.at_s(), asked.wheel, session.writer());
    say!("written    pot.pot in {}", out.display());
    match comparison.first_unlike {
        None => say!("agreement  all of {} snapshots ({:016x})", comparison.snapshots, replay.digest()),
        Some(tick) => bail!(
            "the clay of {:.3} s came out otherwise than it was recorded by {}; this is {}",
            seconds(tick, session.span),
            session.writer(),
            env!("CARGO_PKG_VERSION"),
        ),
    }
    Ok(())
}

impl Session {
    /// The program that wrote it.
    fn writer(&self) -> &str {
        self.playback.recording().writer()
    }
}
