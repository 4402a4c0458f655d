//! A thread with nothing to do, which tells a server that comes late from a machine that keeps everybody waiting.
//!
//! Owns the thread and what it counts; says nothing of the server.
//! Invariant: it asks for a millisecond of sleep at a time, as a server does at work, and for nothing else.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use pottery_shared::units::Tick;

/// How late counts as late: a snapshot's period, as for the server's tick.
const LATE: Duration = Duration::from_micros(16_667);

/// Stands beside from when it is made until it is dropped.
#[derive(Debug)]
pub struct Bystander {
    late: Arc<AtomicU64>,
    is_over: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Bystander {
    /// One that begins to wait now.
    ///
    /// # Errors
    /// Where the system gives no thread.
    pub fn stand() -> std::io::Result<Self> {
        let (late, is_over) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicBool::new(false)));
        let (counted, told) = (Arc::clone(&late), Arc::clone(&is_over));
        let thread = std::thread::Builder::new().name("bystander".into()).spawn(move || {
            let mut due = Instant::now();
            while !told.load(Ordering::Relaxed) {
                due += Duration::from_secs_f32(Tick::PERIOD.0);
                std::thread::sleep(due.saturating_duration_since(Instant::now()));
                let now = Instant::now();
                if now.saturating_duration_since(due) > LATE {
                    counted.fetch_add(1, Ordering::Relaxed);
                    // a delay is counted once
                    due = now;
                }
            }
        })?;
        Ok(Self { late, is_over, thread: Some(thread) })
    }

    /// Times that it woke up later than it had asked for by more than a snapshot's period.
    #[must_use]
    pub fn late(&self) -> u64 {
        self.late.load(Ordering::Relaxed)
    }
}

impl Drop for Bystander {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // a thread that only sleeps does not fail
            drop(thread.join());
        }
    }
}
