//! The sound of a tool on clay: what is rubbed how, the voice that makes samples of it, and where they are heard.
//!
//! Knows no clay and no hand: both arrive as a [`Rub`].
//! Invariant: a machine without sound is silent, and says why to whoever asks.

#[cfg(all(feature = "sound", target_os = "linux"))]
mod pulse;
mod voice;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock, mpsc};

pub use voice::{STEP_MAX, Voice};

/// Samples a second.
pub const RATE_HZ: u32 = 48_000;

/// How a tool rubs the clay at a moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rub {
    /// Force on the tool, N.
    pub force_n: f32,
    /// How fast the clay goes by under it, m/s.
    pub slip_m_s: f32,
    /// How wet the clay is, from 0 (crumbles) to 1 (runs).
    pub wetness: f32,
}

/// Why nothing is heard.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SoundError {
    /// Nobody plays sound here; start a sound server or do without.
    #[error("no sound server answers ({reason}): start PulseAudio or PipeWire to hear the clay")]
    NoServer {
        /// What was tried and what came of it.
        reason: String,
    },
    /// Nobody wrote it for this system, or the program was built without it.
    #[error("sound is played on Linux alone so far, by programs built with --features sound")]
    Unsupported,
}

/// The sound of one hand, in a thread of its own.
///
/// It ends with the value.
#[derive(Debug)]
pub struct Sound {
    is_muted: Arc<AtomicBool>,
    outcome: Arc<OnceLock<Result<(), SoundError>>>,
    /// Hung up when the value goes, which ends the thread.
    _ends: mpsc::SyncSender<()>,
}

impl Sound {
    /// Looks for where to play, without waiting for it; `listen` says how the tool rubs the clay now, some hundred times a second.
    #[must_use]
    pub fn start(is_muted: bool, listen: impl FnMut() -> Rub + Send + 'static) -> Self {
        let (ends, over) = mpsc::sync_channel(0);
        let sound =
            Self { is_muted: Arc::new(AtomicBool::new(is_muted)), outcome: Arc::new(OnceLock::new()), _ends: ends };
        let (muted, outcome) = (Arc::clone(&sound.is_muted), Arc::clone(&sound.outcome));
        let thread = std::thread::Builder::new().name("sound".into()).spawn(move || {
            let heard = play(Player { listen, is_muted: muted, voice: Voice::default() });
            let played = heard.as_ref().map(|_| ()).map_err(Clone::clone);
            // there is one thread, and it says so once
            outcome.get_or_init(|| played);
            // an error is what the end sounds like: nobody ever sends
            over.recv().ok();
            drop(heard);
        });
        if let Err(error) = thread {
            sound.outcome.get_or_init(|| Err(SoundError::NoServer { reason: error.to_string() }));
        }
        sound
    }

    /// Silences it, or lets it be heard again.
    pub fn mute(&self, is_muted: bool) {
        self.is_muted.store(is_muted, Ordering::Relaxed);
    }

    /// Whether a server plays it.
    #[must_use]
    pub fn is_played(&self) -> bool {
        self.outcome.get().is_some_and(Result::is_ok)
    }

    /// Why nothing is heard; none while that is not known yet, or when it is heard.
    #[must_use]
    pub fn trouble(&self) -> Option<&SoundError> {
        self.outcome.get()?.as_ref().err()
    }
}

/// What a server asks for samples.
#[cfg_attr(
    not(all(feature = "sound", target_os = "linux")),
    expect(dead_code, reason = "nothing that plays was built in")
)]
struct Player<L> {
    listen: L,
    is_muted: Arc<AtomicBool>,
    voice: Voice,
}

#[cfg(all(feature = "sound", target_os = "linux"))]
impl<L: FnMut() -> Rub> Player<L> {
    fn fill(&mut self, samples: &mut [f32]) {
        let rub = if self.is_muted.load(Ordering::Relaxed) { Rub::default() } else { (self.listen)() };
        self.voice.fill(rub, samples);
    }
}

#[cfg(all(feature = "sound", target_os = "linux"))]
use pulse::play;

#[cfg(not(all(feature = "sound", target_os = "linux")))]
fn play<L>(_: Player<L>) -> Result<(), SoundError> {
    Err(SoundError::Unsupported)
}
