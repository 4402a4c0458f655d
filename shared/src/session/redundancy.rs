//! How many samples are said again beside the new ones.
//!
//! Holds no clock; judges a line by how late samples came and by silence.
//! Invariant: a line that loses little carries [`Redundancy::FEW`].
//!
//! The server takes samples in their order, so that a burst of losses longer than what is said again holds up all that follow
//! by a round trip and more. On the worst line of the simulator that made one sample in seven late, and a hundred samples
//! said again make it one in forty.

use core::time::Duration;

/// What is known of a line.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Redundancy {
    more_until: Duration,
}

impl Redundancy {
    /// Samples on a line that loses little: four datagrams' worth.
    const FEW: u32 = 40;
    /// Samples on one that loses much: ten.
    const MANY: u32 = 100;
    /// Bytes of samples beyond which fewer are said again, so that a hand sends no more than 60 kbit/s over any line: a sphere's
    /// never are so long, a tool's that turns says some 30 again.
    pub(super) const BYTES: usize = 64;
    /// How long a line counts as one that loses much.
    const LOSSY: Duration = Duration::from_secs(10);

    /// Samples to say again now.
    pub(super) fn samples(&self, now: Duration) -> u32 {
        if now < self.more_until { Self::MANY } else { Self::FEW }
    }

    /// Takes in the worst slack of a pulse: later than what is said again can make up for.
    pub(super) fn handle_slack(&mut self, slack: i16, now: Duration) {
        if i64::from(slack) < -i64::from(Self::FEW) {
            self.more_until = now + Self::LOSSY;
        }
    }

    /// Takes in that the server has acknowledged nothing for a while.
    pub(super) fn handle_silence(&mut self, now: Duration) {
        self.more_until = now + Self::LOSSY;
    }
}
