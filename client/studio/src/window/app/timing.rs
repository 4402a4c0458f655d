//! How long a window takes to show its first picture, and what a person did.
//!
//! Owns the moments; tells them to the log at debug level (`RUST_LOG=pottery_studio=debug`) and to nobody else.
//! Invariant: a movement is counted from the event to the picture in which the tool has gone on, and the next is counted after it.

use std::sync::OnceLock;
use std::time::Instant;

use glam::Vec3;

/// When the program began, and when it asked to join.
static BEGAN: OnceLock<Instant> = OnceLock::new();
static ASKED: OnceLock<Instant> = OnceLock::new();

/// Notes that the program begins.
pub(crate) fn begin() {
    BEGAN.get_or_init(Instant::now);
}

/// Notes that it asks to join.
pub(in crate::window) fn join() {
    ASKED.get_or_init(Instant::now);
}

/// What is on its way to a picture.
#[derive(Debug, Default)]
pub(in crate::window) struct Timing {
    pictures: u64,
    /// When the pointer moved, where the tool was then, and the pictures so far.
    moved: Option<(Instant, Option<Vec3>, u64)>,
}

impl Timing {
    /// The pointer moved while the tool was drawn there.
    pub(in crate::window) fn moved(&mut self, tool_m: Option<Vec3>) {
        self.moved.get_or_insert((Instant::now(), tool_m, self.pictures));
    }

    /// A picture with the tool there was shown.
    pub(in crate::window) fn drawn(&mut self, tool_m: Option<Vec3>) {
        self.pictures += 1;
        if let (Some(began), Some(asked), 1) = (BEGAN.get(), ASKED.get(), self.pictures) {
            let (ms, since_join_ms) = (began.elapsed().as_millis() as u64, asked.elapsed().as_millis() as u64);
            tracing::debug!(ms, since_join_ms, "first picture");
        }
        if let Some((at, _, before)) = self.moved.take_if(|(_, before_m, _)| *before_m != tool_m) {
            tracing::debug!(
                ms = at.elapsed().as_secs_f64() * 1e3,
                pictures = self.pictures - before,
                "input in picture"
            );
        }
    }
}
