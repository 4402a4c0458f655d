//! Whether a client keeps up with pressing again what others pressed.
//!
//! Owns the rule by which it goes over to deltas and back; measures no time itself.
//! Invariant: between two changes of mind lies at least [`Effort::WINDOW`].

use core::time::Duration;

/// Time spent on taking clay in, against the time there was.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Effort {
    since: Duration,
    spent: Duration,
    /// When it tries again after it could not keep up.
    again_at: Option<Duration>,
}

impl Effort {
    /// How long it looks before it decides.
    const WINDOW: Duration = Duration::from_secs(1);
    /// It keeps up while it spends less than one in so many seconds.
    const SHARE: u32 = 3;
    /// How long it leaves be what it could not keep up with.
    const REST: Duration = Duration::from_secs(30);

    /// Takes in the time `spent` since it was last called; `Some` when the client is to press again what others press, or no
    /// longer to.
    pub(super) fn handle(&mut self, spent: Duration, now: Duration) -> Option<bool> {
        self.spent += spent;
        let passed = now.saturating_sub(self.since);
        if passed < Self::WINDOW {
            return None;
        }
        let is_too_much = self.spent * Self::SHARE > passed;
        (self.since, self.spent) = (now, Duration::ZERO);
        match self.again_at {
            None if is_too_much => {
                self.again_at = Some(now + Self::REST);
                Some(false)
            }
            Some(again_at) if now >= again_at => {
                self.again_at = None;
                Some(true)
            }
            _ => None,
        }
    }
}
