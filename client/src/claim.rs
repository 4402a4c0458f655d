//! What a thread that must not be late asks of the system, and what it gets: priority, a core and sharp timers; and how often it goes round.
//!
//! Knows no tick; asked once, before the first.
//! Invariant: what the system refuses is a sentence and never the end of anything.

use std::fmt;
use std::str::FromStr;

use crate::pacing::LoopRate;

/// What a thread asks for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Claim {
    /// To go before everything that is not real-time itself.
    pub is_raised: bool,
    /// To stay on one core.
    pub core: Option<Core>,
    /// How often it goes round.
    pub rate: LoopRate,
}

/// A processor core that this program may use.
///
/// ```
/// use pottery_client::Core;
///
/// assert!("9999".parse::<Core>().unwrap_err().to_string().contains("9999"));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Core(usize);

/// Why a thread cannot be put on a core.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CoreError {
    /// Not a number of a core; count from 0.
    #[error("{text:?} is no core: give its number, counted from 0")]
    Number {
        /// What was given.
        text: String,
    },
    /// The system keeps the program off that core, or has no such core; choose another.
    #[error("core {number} is not among those that this program may use: choose one of {allowed}")]
    NotAllowed {
        /// The core.
        number: usize,
        /// Those that may be used.
        allowed: String,
    },
    /// Nobody wrote it for this system; leave the choice to the system.
    #[error("threads are put on a core on Linux alone so far: leave --pin-core out")]
    Unsupported,
}

/// The order in which the system lets the thread run.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Priority {
    /// As everything else, since more was not asked for.
    Ordinary,
    /// Before everything that is not real-time itself.
    RealTime,
    /// As everything else, since the system allows no more.
    Refused {
        /// What the system said.
        reason: String,
    },
}

impl fmt::Display for Priority {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Ordinary => f.write_str("ordinary priority, since more was not asked for"),
            Self::RealTime => f.write_str("real-time priority"),
            Self::Refused { reason } => {
                let remedy = if cfg!(target_os = "linux") {
                    "; to allow it, put `@audio - rtprio 20` into /etc/security/limits.conf, be in that group and log in again"
                } else {
                    ""
                };
                write!(f, "ordinary priority, since the system refuses real time ({reason}){remedy}")
            }
        }
    }
}

/// What a thread got.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Granted {
    /// Its priority.
    pub priority: Priority,
    /// The core on which it stays, if it was put on one.
    pub core: Option<Core>,
    /// How often it goes round, which nobody can refuse.
    pub rate: LoopRate,
}

impl fmt::Display for Granted {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.priority.fmt(f)?;
        match self.core {
            Some(Core(number)) => write!(f, ", on core {number}"),
            None => f.write_str(", on any core"),
        }
    }
}

impl Claim {
    /// Asks the system for it, for the thread that calls.
    #[must_use]
    pub fn stake(self) -> Granted {
        sharpen_timers();
        let core = self.core.filter(|core| match core.pin() {
            Ok(()) => true,
            Err(reason) => {
                tracing::warn!(%reason, "the hand's thread stays on any core");
                false
            }
        });
        let priority = match self.is_raised.then(raise) {
            None => Priority::Ordinary,
            Some(Ok(())) => Priority::RealTime,
            Some(Err(reason)) => Priority::Refused { reason },
        };
        Granted { priority, core, rate: self.rate }
    }
}

/// Level of the thread among real-time ones, 1 to 99: over what asks for the least, under sound servers and the kernel's own.
#[cfg(target_os = "linux")]
const LEVEL: u8 = 20;

#[cfg(target_os = "linux")]
fn raise() -> Result<(), String> {
    use thread_priority::unix::{
        RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
    };
    let level = LEVEL.try_into().map_err(|_| "its level is none".to_owned())?;
    set_thread_priority_and_policy(
        thread_native_id(),
        thread_priority::ThreadPriority::Crossplatform(level),
        ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo),
    )
    .map_err(|error| said(&error))
}

#[cfg(not(target_os = "linux"))]
fn raise() -> Result<(), String> {
    thread_priority::ThreadPriority::Max.set_for_current().map_err(|error| said(&error))
}

/// The system's error in its own words.
fn said(error: &thread_priority::Error) -> String {
    match error {
        thread_priority::Error::OS(code) => std::io::Error::from_raw_os_error(*code).to_string(),
        other => other.to_string(),
    }
}

/// Has the thread woken up when it asks to be, and not up to 50 µs later together with others.
fn sharpen_timers() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1)) {
        tracing::debug!(%error, "the timer slack stays as it is");
    }
}

#[cfg(target_os = "linux")]
impl Core {
    /// The core of a number, counted from 0.
    ///
    /// # Errors
    /// [`CoreError`] when the program may not use it.
    pub fn new(number: usize) -> Result<Self, CoreError> {
        let allowed = Self::allowed();
        if allowed.contains(&number) {
            return Ok(Self(number));
        }
        let allowed = allowed.iter().map(ToString::to_string).collect::<Vec<_>>().join(", ");
        Err(CoreError::NotAllowed { number, allowed })
    }

    fn allowed() -> Vec<usize> {
        use rustix::thread::{CpuSet, sched_getaffinity};
        let set = sched_getaffinity(None).unwrap_or_default();
        (0..CpuSet::MAX_CPU).filter(|&number| set.is_set(number)).collect()
    }

    fn pin(self) -> std::io::Result<()> {
        let mut only = rustix::thread::CpuSet::new();
        only.set(self.0);
        Ok(rustix::thread::sched_setaffinity(None, &only)?)
    }
}

#[cfg(not(target_os = "linux"))]
impl Core {
    /// No core, since threads are put on one on Linux alone so far.
    ///
    /// # Errors
    /// [`CoreError::Unsupported`].
    pub const fn new(_: usize) -> Result<Self, CoreError> {
        Err(CoreError::Unsupported)
    }

    fn pin(self) -> std::io::Result<()> {
        Err(std::io::ErrorKind::Unsupported.into())
    }
}

impl FromStr for Core {
    type Err = CoreError;

    fn from_str(text: &str) -> Result<Self, CoreError> {
        Self::new(text.parse().map_err(|_| CoreError::Number { text: text.to_owned() })?)
    }
}
