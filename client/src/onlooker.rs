//! Somebody who looks on: a connection without a hand.
//!
//! Owns the task between network and what is seen, and comes back when the line broke; which wheels at which detail is for the caller
//! to say.
//! Invariant: after `leave` the task has ended, and what is seen stays to be seen however the line is.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pottery_shared::protocol::Purpose;
use pottery_shared::session::{Implausible, Watcher};
use tokio::sync::Notify;
use tokio::time::{Instant, MissedTickBehavior, timeout};

use crate::connection::{self, JoinError, Joined, Target};
use crate::streams::{Arrival, Streams, closed_or_lost};
use crate::view::Link;
use crate::way_back::{WayBack, greet, hear_the_rest};

/// How often it looks whether something has to be asked for.
const LOOK_EVERY: Duration = Duration::from_millis(20);
/// Time in which a goodbye is answered.
const GOODBYE_WITHIN: Duration = Duration::from_secs(1);

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
    /// Messages that made no sense or could not be true.
    pub malformed: u64,
    /// What could not be true of them.
    pub implausible: Implausible,
    /// How the connection ended.
    pub link: Link,
}

/// What task and looker share; neither is the 1 kHz thread, so a lock may stand between them.
#[derive(Debug)]
struct Shared {
    seen: Mutex<Seen>,
    /// Something was asked of the watcher.
    asked: Notify,
    /// The person leaves.
    leaving: Notify,
}

#[derive(Debug)]
struct Seen {
    watcher: Watcher,
    link: Link,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Seen> {
        // a watcher is whole between any two messages, so a panic elsewhere leaves nothing half done
        self.seen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Somebody who looks on.
#[derive(Debug)]
pub struct Onlooker {
    shared: Arc<Shared>,
    epoch: Instant,
    fingerprint: Option<[u8; 32]>,
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
        Self::join_asking(endpoint, target, bytes_per_s, connection::log_waiting).await
    }

    /// The same, for whom `waits` is told that a teacher is asked to let them in.
    ///
    /// # Errors
    /// [`JoinError`] with a sentence for the person.
    pub async fn join_asking(
        endpoint: &quinn::Endpoint,
        target: &Target,
        bytes_per_s: u32,
        waits: impl Fn(),
    ) -> Result<Self, JoinError> {
        let purpose = Purpose::Watches { bytes_per_s };
        let greeting = greet(target, purpose, target.pass());
        let (joined, watcher) =
            connection::join_asking(endpoint, target, None, &greeting, Watcher::open, waits).await?;
        let fingerprint = joined.fingerprint;
        let way_back = WayBack::new(endpoint.clone(), target, purpose, fingerprint);
        let seen = Mutex::new(Seen { watcher, link: Link::Open });
        let shared = Arc::new(Shared { seen, asked: Notify::new(), leaving: Notify::new() });
        let epoch = Instant::now();
        let task = Task { joined, shared: Arc::clone(&shared), epoch, way_back, counts: Counts::default() };
        Ok(Self { shared, epoch, fingerprint, task: tokio::spawn(task.run()) })
    }

    /// Looks, and asks for other sights; hold what is looked through no longer than a copy takes.
    pub fn look<T>(&self, look: impl FnOnce(&mut Watcher, Duration) -> T) -> T {
        let seen = look(&mut self.shared.lock().watcher, self.epoch.elapsed());
        self.shared.asked.notify_one();
        seen
    }

    /// SHA-256 of the certificate that the server showed.
    #[must_use]
    pub const fn fingerprint(&self) -> Option<[u8; 32]> {
        self.fingerprint
    }

    /// How the connection stands.
    #[must_use]
    pub fn link(&self) -> Link {
        let seen = self.shared.lock();
        if seen.watcher.is_closing() { Link::Closed } else { seen.link.clone() }
    }

    /// Says goodbye.
    ///
    /// # Errors
    /// [`JoinError::Network`] when the task did not end well.
    pub async fn leave(self) -> Result<WatchReport, JoinError> {
        self.shared.leaving.notify_one();
        self.task.await.map_err(|error| JoinError::Network { reason: error.to_string() })
    }
}

/// What all connections of a stay counted.
#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    down_bytes: u64,
    up_bytes: u64,
    malformed: u64,
}

/// The task's state.
struct Task {
    joined: Joined,
    shared: Arc<Shared>,
    epoch: Instant,
    way_back: WayBack,
    counts: Counts,
}

impl Task {
    /// Takes in what arrives until the person leaves or the connection ends for good.
    async fn run(mut self) -> WatchReport {
        loop {
            let link = self.work().await;
            self.add_counts();
            if let Err(link) = self.come_back(link).await {
                return self.finish(link);
            }
        }
    }

    /// Takes in what arrives until the connection ends; says how.
    async fn work(&mut self) -> Link {
        let Joined { connection, streams: Streams { outgoing, arriving }, .. } = &mut self.joined;
        let (shared, epoch) = (&self.shared, self.epoch);
        let mut look = tokio::time::interval(LOOK_EVERY);
        look.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut is_leaving = false;
        loop {
            tokio::select! {
                // always in this order, so that a run repeats from its seed
                biased;
                () = shared.leaving.notified() => {
                    shared.lock().watcher.leave();
                    is_leaving = true;
                }
                _ = look.tick() => shared.lock().watcher.handle_time(epoch.elapsed()),
                () = shared.asked.notified() => {}
                datagram = connection.read_datagram() => match datagram {
                    Ok(bytes) => {
                        let watcher = &mut shared.lock().watcher;
                        let begin = Instant::now();
                        self.counts.malformed += u64::from(!watcher.handle_datagram(&bytes, epoch.elapsed()));
                        watcher.handle_effort(begin.elapsed(), epoch.elapsed());
                    }
                    Err(error) => break closed_or_lost(&error),
                },
                Some(arrival) = arriving.recv() => match arrival {
                    Arrival::Frame(frame) => {
                        let taken = shared.lock().watcher.handle_control(&frame);
                        if let Err(error) = taken {
                            break Link::Lost(error.to_string());
                        }
                    }
                    Arrival::Keyframe(bytes) => {
                        let is_sound = shared.lock().watcher.handle_keyframe(&bytes, epoch.elapsed());
                        self.counts.malformed += u64::from(!is_sound);
                    }
                    Arrival::StreamEnded => break Link::Closed,
                },
            }
            let frames: Vec<_> = {
                let watcher = &mut shared.lock().watcher;
                std::iter::from_fn(|| watcher.poll_control()).collect()
            };
            for frame in frames {
                if outgoing.send(frame).await.is_err() {
                    tracing::debug!("the control stream is closed");
                }
            }
            if is_leaving {
                if timeout(GOODBYE_WITHIN, connection.closed()).await.is_err() {
                    tracing::debug!("the server did not confirm the goodbye");
                }
                break Link::Closed;
            }
        }
    }

    /// Comes back after the connection ended so; how it stands when that cannot be.
    async fn come_back(&mut self, link: Link) -> Result<(), Link> {
        let shared = Arc::clone(&self.shared);
        let taken = |frame: &[u8]| shared.lock().watcher.handle_control(frame).is_ok();
        hear_the_rest(&mut self.joined.streams.arriving, taken).await;
        self.way_back.note_place(shared.lock().watcher.class());
        let way = self.way_back.begin(link)?;
        shared.lock().link = Link::ComingBack(way.0.clone());
        let tell = |link| shared.lock().link = link;
        let (joined, mut watcher) = tokio::select! {
            biased;
            found = self.way_back.knock(way, self.joined.connection.rtt(), Watcher::open, tell) => found?,
            () = shared.leaving.notified() => return Err(Link::Closed),
        };
        self.joined = joined;
        let mut seen = shared.lock();
        let gone_on = watcher.go_on_from(&mut seen.watcher, self.epoch.elapsed());
        gone_on.map_err(|error| Link::Lost(error.to_string()))?;
        (seen.watcher, seen.link) = (watcher, Link::Open);
        self.way_back.note_return();
        // what is looked at was asked for
        shared.asked.notify_one();
        Ok(())
    }

    /// Adds what this connection carried to the report.
    fn add_counts(&mut self) {
        let stats = quinn::Connection::stats(&self.joined.connection);
        self.counts.down_bytes += stats.udp_rx.bytes;
        self.counts.up_bytes += stats.udp_tx.bytes;
    }

    fn finish(self, link: Link) -> WatchReport {
        self.joined.connection.close(0, b"goodbye");
        let mut seen = self.shared.lock();
        seen.link = link.clone();
        let watcher = &seen.watcher;
        let Counts { down_bytes, up_bytes, malformed } = self.counts;
        WatchReport {
            duration: self.epoch.elapsed(),
            down_bytes,
            up_bytes,
            mismatches: watcher.mismatches(),
            mended_tiles: watcher.mend_counts().tiles,
            retold: watcher.retold(),
            asked: watcher.asked(),
            malformed,
            implausible: watcher.implausible(),
            link,
        }
    }
}
