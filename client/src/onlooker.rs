//! Somebody who looks on: a connection without a hand.
//!
//! Owns the task between network and what is seen; which wheels at which detail is for the caller to say.
//! Invariant: after `leave` the task has ended.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pottery_shared::protocol::{Hello, Purpose};
use pottery_shared::session::{Watcher, greeting};
use tokio::sync::Notify;
use tokio::time::{Instant, MissedTickBehavior};
use web_transport_quinn::Session;

use crate::connection::{self, JoinError, Joined, Target};
use crate::streams::{Arrival, Streams, closed_or_lost};
use crate::view::Link;

/// How often it looks whether something has to be asked for.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// What looking on gave.
#[derive(Clone, Debug)]
pub struct WatchReport {
    /// Time since the welcome.
    pub duration: Duration,
    /// Bytes received, UDP payload.
    pub down_bytes: u64,
    /// Bytes sent, UDP payload.
    pub up_bytes: u64,
    /// Digests that did not match.
    pub mismatches: u64,
    /// Tiles that differed and were mended.
    pub mended_tiles: u64,
    /// Snapshots that it came to by pressing again what was pressed.
    pub retold: u64,
    /// How often it asked for what was missing.
    pub asked: u64,
    /// Messages that made no sense.
    pub malformed: u64,
    /// How the connection ended.
    pub link: Link,
}

/// What task and looker share; neither is the 1 kHz thread, so a lock may stand between them.
#[derive(Debug)]
struct Shared {
    watcher: Mutex<Watcher>,
    /// Something was asked of the watcher.
    asked: Notify,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Watcher> {
        // a watcher is whole between any two messages, so a panic elsewhere leaves nothing half done
        self.watcher.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Somebody who looks on.
#[derive(Debug)]
pub struct Onlooker {
    shared: Arc<Shared>,
    epoch: Instant,
    task: tokio::task::JoinHandle<WatchReport>,
}

impl Onlooker {
    /// Joins a studio to look on, for no more than so many bytes a second for long; the target's wheel has no meaning.
    ///
    /// Call it within a tokio runtime, which will carry the connection.
    ///
    /// # Errors
    /// [`JoinError`] with a sentence for the person.
    pub async fn join(endpoint: &quinn::Endpoint, target: &Target, bytes_per_s: u32) -> Result<Self, JoinError> {
        let (code, purpose) = (target.code.room().to_owned(), Purpose::Watches { bytes_per_s });
        let greeting = greeting(&Hello { code, wheel: 0, purpose, pass: target.pass() });
        let (joined, watcher) = connection::join(endpoint, target, &greeting, Watcher::open).await?;
        let shared = Arc::new(Shared { watcher: Mutex::new(watcher), asked: Notify::new() });
        let epoch = Instant::now();
        let task = tokio::spawn(run(joined, Arc::clone(&shared), epoch));
        Ok(Self { shared, epoch, task })
    }

    /// Looks, and asks for other sights; hold what is looked through no longer than a copy takes.
    pub fn look<T>(&self, look: impl FnOnce(&mut Watcher, Duration) -> T) -> T {
        let seen = look(&mut self.shared.lock(), self.epoch.elapsed());
        self.shared.asked.notify_one();
        seen
    }

    /// Whether the connection has ended, or the studio closes.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.task.is_finished() || self.shared.lock().is_closing()
    }

    /// Says goodbye.
    ///
    /// # Errors
    /// [`JoinError::Network`] when the task did not end well.
    pub async fn leave(self) -> Result<WatchReport, JoinError> {
        self.look(|watcher, _| watcher.leave());
        self.task.await.map_err(|error| JoinError::Network { reason: error.to_string() })
    }
}

/// Takes in what arrives until the connection ends.
async fn run(joined: Joined, shared: Arc<Shared>, epoch: Instant) -> WatchReport {
    let Joined { connection, streams: Streams { outgoing, mut arriving }, .. } = joined;
    let mut look = tokio::time::interval(LOOK_EVERY);
    look.set_missed_tick_behavior(MissedTickBehavior::Delay);
    let mut malformed = 0;
    let link = loop {
        tokio::select! {
            // always in this order, so that a run repeats from its seed
            biased;
            _ = look.tick() => shared.lock().handle_time(epoch.elapsed()),
            () = shared.asked.notified() => {}
            datagram = connection.read_datagram() => match datagram {
                Ok(bytes) => {
                    let mut watcher = shared.lock();
                    let begin = Instant::now();
                    malformed += u64::from(!watcher.handle_datagram(&bytes, epoch.elapsed()));
                    watcher.handle_effort(begin.elapsed(), epoch.elapsed());
                }
                Err(error) => break closed_or_lost(&error),
            },
            Some(arrival) = arriving.recv() => match arrival {
                Arrival::Frame(frame) => {
                    let taken = shared.lock().handle_control(&frame);
                    if let Err(error) = taken {
                        break Link::Lost(error.to_string());
                    }
                }
                Arrival::Keyframe(bytes) => {
                    malformed += u64::from(!shared.lock().handle_keyframe(&bytes, epoch.elapsed()));
                }
                Arrival::StreamEnded => break Link::Closed,
            },
        }
        let frames: Vec<_> = {
            let mut watcher = shared.lock();
            std::iter::from_fn(|| watcher.poll_control()).collect()
        };
        for frame in frames {
            if outgoing.send(frame).await.is_err() {
                tracing::debug!("the control stream is closed");
            }
        }
    };
    finish(&connection, &shared, epoch, link, malformed)
}

fn finish(connection: &Session, shared: &Shared, epoch: Instant, link: Link, malformed: u64) -> WatchReport {
    connection.close(0, b"goodbye");
    let stats = quinn::Connection::stats(connection);
    let watcher = shared.lock();
    WatchReport {
        duration: epoch.elapsed(),
        down_bytes: stats.udp_rx.bytes,
        up_bytes: stats.udp_tx.bytes,
        mismatches: watcher.mismatches(),
        mended_tiles: watcher.mend_counts().tiles,
        retold: watcher.retold(),
        asked: watcher.asked(),
        malformed,
        link,
    }
}
