//! Why a device gives no positions and takes no forces: one sentence for the person, with what to do.
//!
//! Invariant: whatever a driver meets becomes one of these; none of them ends the session.

/// Why a device cannot be used now.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DeviceFault {
    /// Nothing is there; do what the remedy says.
    #[error("no {device} was found: {reason}; {remedy}")]
    NotFound {
        /// What was looked for.
        device: &'static str,
        /// Why it was not found.
        reason: String,
        /// What the person can do.
        remedy: String,
    },
    /// It is there and cannot be used yet; do what the remedy says.
    #[error("the {device} cannot be used: {reason}; {remedy}")]
    Unusable {
        /// Which device.
        device: &'static str,
        /// Why not.
        reason: String,
        /// What the person can do.
        remedy: String,
    },
    /// It went away; plug it in again.
    #[error("the {device} has gone ({reason}): its force is off; plug it in again and it goes on")]
    Gone {
        /// Which device.
        device: &'static str,
        /// How it was noticed.
        reason: String,
    },
    /// It does not answer; its force is off until it does.
    #[error("the {device} has not answered for {ms} ms: its force is off until it answers again")]
    Silent {
        /// Which device.
        device: &'static str,
        /// How long, ms.
        ms: u64,
    },
    /// It answered with what its protocol does not know; its force is off.
    #[error("the {device} broke its protocol: expected {expected}, got {found}; its force is off until it keeps to it")]
    Protocol {
        /// Which device.
        device: &'static str,
        /// What should have come.
        expected: &'static str,
        /// What came.
        found: String,
    },
}
