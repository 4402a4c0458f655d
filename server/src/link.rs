//! The room's side of a connection: bounded queues out of the tick.
//!
//! Never waits: what a connection cannot take at once is dropped (datagrams, keyframes) or ends it (control frames).
//! Invariant: whatever a peer does, it holds at most [`CONTROL_QUEUE`] frames of [`CONTROL_BYTES`] and [`KEYFRAME_BYTES`] of keyframes, or
//! one longer than that.

use std::net::IpAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::Duration;

use bytes::Bytes;
use pottery_shared::session::{Pace, Telling};
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use web_transport_quinn::Session;

use crate::bounds::{CONTROL_BYTES, CONTROL_QUEUE, KEYFRAME_BYTES};

/// What waits for the control stream.
pub(crate) enum Outgoing {
    /// A frame, its length before it, and the room that it takes among those that wait.
    Frame(Vec<u8>, OwnedSemaphorePermit),
    /// Nothing comes after this.
    Finish,
}

impl std::fmt::Debug for Outgoing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Frame(bytes, _) => write!(f, "Frame({} bytes)", bytes.len()),
            Self::Finish => f.write_str("Finish"),
        }
    }
}

/// The room's side of a connection.
#[derive(Debug)]
pub(crate) struct Link {
    session: Session,
    control: mpsc::Sender<Outgoing>,
    control_room: Arc<Semaphore>,
    keyframes: Arc<Semaphore>,
    dropped: AtomicU64,
    is_in: Arc<AtomicBool>,
    /// The place among those who have not been let in.
    stranger: Option<OwnedSemaphorePermit>,
    /// Whether the room has done with it, so that nothing more is heard of it.
    is_over: bool,
    /// Packets that were lost on the way when it was last looked at.
    lost: u64,
    /// Shortest times of a way and back, of this span and the one before.
    shortest: [Duration; 2],
    span_began: Duration,
    pace: Pace,
}

/// What a line showed of itself.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Look {
    /// Whether packets were lost on the way since the last look.
    pub(crate) has_lost: bool,
    /// How the client should be told.
    pub(crate) telling: Telling,
}

/// How long a peer may take to read what is queued for it before the end: all of it over a megabit a second.
const ENDS_WITHIN: Duration = Duration::from_secs(9);

/// How long the shortest time of a way and back counts.
const SPAN: Duration = Duration::from_secs(20);

impl Link {
    /// A link and the frames that are to be written to the control stream.
    pub(crate) fn new(session: Session, stranger: OwnedSemaphorePermit) -> (Self, mpsc::Receiver<Outgoing>) {
        let (control, outgoing) = mpsc::channel(CONTROL_QUEUE);
        let keyframes = Arc::new(Semaphore::new(KEYFRAME_BYTES));
        let link = Self {
            session,
            control,
            control_room: Arc::new(Semaphore::new(CONTROL_BYTES)),
            keyframes,
            dropped: AtomicU64::new(0),
            is_in: Arc::default(),
            stranger: Some(stranger),
            is_over: false,
            lost: 0,
            shortest: [Duration::MAX; 2],
            span_began: Duration::ZERO,
            pace: Pace::default(),
        };
        (link, outgoing)
    }

    /// Notes that the room has let the peer in, so that its datagrams are heard and another may knock.
    pub(crate) fn let_in(&mut self) {
        self.stranger = None;
        self.is_in.store(true, Ordering::Relaxed);
    }

    /// Notes that the room has done with the peer: what it still says is not heard.
    pub(crate) const fn end(&mut self) {
        self.is_over = true;
    }

    /// Whether the room has done with the peer.
    pub(crate) const fn is_over(&self) -> bool {
        self.is_over
    }

    /// Whether it was let in, for whoever reads the connection.
    pub(crate) fn is_in(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.is_in)
    }

    /// Where the peer is.
    pub(crate) fn address(&self) -> IpAddr {
        self.session.remote_address().ip()
    }

    /// Datagrams that could not be sent.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    /// Looks at the line, now and then.
    pub(crate) fn look(&mut self, now: Duration) -> Look {
        let path = quinn::Connection::stats(&self.session).path;
        if now.saturating_sub(self.span_began) > SPAN {
            self.shortest = [path.rtt, self.shortest[0]];
            self.span_began = now;
        }
        self.shortest[0] = self.shortest[0].min(path.rtt);
        self.pace.handle(path.rtt, self.shortest[0].min(self.shortest[1]), now);
        let has_lost = path.lost_packets > self.lost;
        self.lost = path.lost_packets;
        Look { has_lost, telling: self.pace.telling() }
    }

    /// The longest datagram that the path takes now.
    pub(crate) fn datagram_bytes(&self) -> usize {
        self.session.max_datagram_size()
    }

    /// Sends now or never. What finds the buffer full is dropped and counted, and so is what is longer than the path takes, which
    /// may have shrunk.
    pub(crate) fn send_datagram(&self, bytes: Bytes) {
        let room = quinn::Connection::datagram_send_buffer_space(&self.session);
        // what is longer than the path takes is an error too
        if bytes.len() > room || self.session.send_datagram(bytes).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Queues a frame; false when the peer takes nothing in.
    pub(crate) fn send_control(&self, frame: Vec<u8>) -> bool {
        let Ok(room) = Arc::clone(&self.control_room).try_acquire_many_owned(frame.len() as u32) else { return false };
        self.queue(Outgoing::Frame(frame, room))
    }

    /// Ends the connection once the queued frames are through, or the peer has not read them for too long; false when the queue is full.
    pub(crate) fn finish(&self) -> bool {
        let session = self.session.clone();
        tokio::spawn(async move {
            if tokio::time::timeout(ENDS_WITHIN, session.closed()).await.is_err() {
                session.close(0, b"goodbye");
            }
        });
        self.queue(Outgoing::Finish)
    }

    /// False when the queue is full. Whoever has gone is not too slow, and is about to be reported as gone.
    fn queue(&self, next: Outgoing) -> bool {
        !matches!(self.control.try_send(next), Err(TrySendError::Full(_)))
    }

    /// Sends a keyframe behind everything else; while too many are under way it is dropped, and asked for again.
    pub(crate) fn send_keyframe(&self, bytes: Vec<u8>) {
        let room = bytes.len().min(KEYFRAME_BYTES) as u32;
        let Ok(permit) = Arc::clone(&self.keyframes).try_acquire_many_owned(room) else { return };
        let session = self.session.clone();
        tokio::spawn(async move {
            let _permit = permit;
            let sent = async {
                let mut stream = session.open_uni().await?;
                stream.set_priority(-1)?;
                stream.write_all(&bytes).await?;
                stream.finish()?;
                stream.stopped().await?;
                Ok::<(), Box<dyn std::error::Error + Send + Sync>>(())
            };
            if let Err(error) = sent.await {
                tracing::debug!(%error, "a keyframe did not get through");
            }
        });
    }

    /// Ends the connection at once.
    pub(crate) fn drop_connection(&self) {
        self.session.close(1, b"too slow");
    }

    /// Resolves when the connection has ended.
    pub(crate) async fn closed(&self) {
        self.session.closed().await;
    }
}
