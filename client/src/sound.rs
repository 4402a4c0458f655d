//! The sound of a tool on clay: what is rubbed how, the voice that makes samples of it, and where they are heard.
//!
//! Knows no clay and no hand: both arrive as a [`Rub`].
//! Invariant: a machine without sound is silent, says why to whoever asks, and is heard when a sound server comes.

#[cfg(all(feature = "sound", target_os = "linux"))]
mod pulse;
mod voice;

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};
use std::time::Duration;

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

/// How long nothing is asked for until a server counts as gone; one at work asks every 10 ms.
const GONE_AFTER: Duration = Duration::from_secs(3);
/// Time between two looks for a server where there is none.
const LOOK_EVERY: Duration = Duration::from_secs(5);

/// How the last look for a server ended; none before the first one has.
type Outcome = Option<Result<(), SoundError>>;

/// The sound of one hand, in a thread of its own, which looks for a server that plays it, and for another when that one is gone.
///
/// It ends with the value.
#[derive(Debug)]
pub struct Sound {
    is_muted: Arc<AtomicBool>,
    outcome: Arc<Mutex<Outcome>>,
    /// Hung up when the value goes, which ends the thread.
    _ends: mpsc::SyncSender<()>,
}

impl Sound {
    /// Looks for where to play, without waiting for it; `listen` says how the tool rubs the clay now, some hundred times a second.
    #[must_use]
    pub fn start(is_muted: bool, listen: impl FnMut() -> Rub + Send + 'static) -> Self {
        let (ends, over) = mpsc::sync_channel(0);
        let sound = Self { is_muted: Arc::new(AtomicBool::new(is_muted)), outcome: Arc::default(), _ends: ends };
        let (is_muted, outcome) = (Arc::clone(&sound.is_muted), Arc::clone(&sound.outcome));
        let player = Arc::new(Mutex::new(Player { listen, is_muted, voice: Voice::default(), asked: 0 }));
        let thread = std::thread::Builder::new().name("sound".into()).spawn(move || keep(&player, &outcome, &over));
        if let Err(error) = thread {
            *locked(&sound.outcome) = Some(Err(SoundError::NoServer { reason: error.to_string() }));
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
        matches!(*locked(&self.outcome), Some(Ok(())))
    }

    /// Why nothing is heard; none while that is not known yet, or when it is heard.
    #[must_use]
    pub fn trouble(&self) -> Option<SoundError> {
        locked(&self.outcome).as_ref()?.as_ref().err().cloned()
    }
}

/// Plays until it is `over`, at whatever server there is.
fn keep<L: FnMut() -> Rub + Send + 'static>(
    player: &Arc<Mutex<Player<L>>>,
    outcome: &Mutex<Outcome>,
    over: &mpsc::Receiver<()>,
) {
    loop {
        let heard = play(Arc::clone(player));
        *locked(outcome) = Some(heard.as_ref().map(|_| ()).map_err(Clone::clone));
        if matches!(heard, Err(SoundError::Unsupported)) {
            return;
        }
        let wait = if heard.is_ok() { GONE_AFTER } else { LOOK_EVERY };
        let mut before = None;
        loop {
            let asked = Some(locked(player).asked);
            if asked == before {
                // a server that asks no more is gone
                break;
            }
            before = asked;
            if over.recv_timeout(wait) != Err(mpsc::RecvTimeoutError::Timeout) {
                return;
            }
        }
    }
}

/// Whoever panicked with it held nothing that is half done.
fn locked<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
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
    /// How often it was asked.
    asked: u64,
}

#[cfg(all(feature = "sound", target_os = "linux"))]
impl<L: FnMut() -> Rub> Player<L> {
    fn fill(&mut self, samples: &mut [f32]) {
        self.asked += 1;
        let rub = if self.is_muted.load(Ordering::Relaxed) { Rub::default() } else { (self.listen)() };
        self.voice.fill(rub, samples);
    }
}

#[cfg(all(feature = "sound", target_os = "linux"))]
use pulse::play;

#[cfg(not(all(feature = "sound", target_os = "linux")))]
fn play<L>(_: Arc<Mutex<Player<L>>>) -> Result<(), SoundError> {
    Err(SoundError::Unsupported)
}
