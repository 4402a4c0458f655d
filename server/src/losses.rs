//! What a server could not keep, told when it has stopped.
//!
//! Owns the figures and the sentence; the log has said why, when it happened.
//! Invariant: whoever asks for nothing to be kept loses nothing.

use std::fmt;

/// What a server could not keep.
///
/// ```
/// use pottery_server::Losses;
/// let losses = Losses { pots: 2, has_broken_recording: true, ..Losses::default() };
/// assert_eq!(losses.to_string(), "not everything was kept (2 pots, the end of the recording): the log says why");
/// assert!(Losses::default().is_none() && !losses.is_none());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Losses {
    /// Pots that have changed since they were written.
    pub pots: usize,
    /// Whether the recording ends before the studio did.
    pub has_broken_recording: bool,
    /// Whether the room's task ended with a fault, so that nobody knows what was kept.
    pub has_failed: bool,
}

impl Losses {
    /// Whether everything was kept.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::default()
    }
}

impl fmt::Display for Losses {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let pots = match self.pots {
            0 => None,
            1 => Some("1 pot".to_owned()),
            pots => Some(format!("{pots} pots")),
        };
        let recording = self.has_broken_recording.then(|| "the end of the recording".to_owned());
        let rest = self.has_failed.then(|| "what the room did last".to_owned());
        let lost: Vec<_> = [pots, recording, rest].into_iter().flatten().collect();
        write!(f, "not everything was kept ({}): the log says why", lost.join(", "))
    }
}
