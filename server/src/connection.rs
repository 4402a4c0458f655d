//! Connections: accepted, read into events, written from bounded queues.
//!
//! Knows no room: turns bytes of streams into frames and hands them on.
//! One type, `web_transport_quinn::Session`, carries every connection: today native QUIC, later browsers as well.
//! Invariant: whatever a peer does, it holds at most one queue of [`CONTROL_QUEUE`] frames and [`KEYFRAMES_MAX`]
//! keyframes.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bytes::Bytes;
use pottery_shared::protocol::FrameReader;
use pottery_shared::room::PeerId;
use tokio::sync::{Semaphore, mpsc};
use web_transport_quinn::{RecvStream, SendStream, Session};

use crate::ticking::Event;

/// Control frames that may wait for a slow peer.
const CONTROL_QUEUE: usize = 256;
/// Keyframes that may be under way to one peer.
const KEYFRAMES_MAX: usize = 2;
/// A peer that has said nothing by then did not mean to join.
const GREETING_WITHIN: Duration = Duration::from_secs(5);
/// Time in which a peer takes in the last frames.
const GOODBYE_WITHIN: Duration = Duration::from_millis(800);

enum Outgoing {
    Frame(Vec<u8>),
    Finish,
}

/// The room's side of a connection.
#[derive(Debug)]
pub(crate) struct Link {
    session: Session,
    control: mpsc::Sender<Outgoing>,
    keyframes: Arc<Semaphore>,
    dropped: AtomicU64,
}

impl std::fmt::Debug for Outgoing {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Frame(bytes) => write!(f, "Frame({} bytes)", bytes.len()),
            Self::Finish => f.write_str("Finish"),
        }
    }
}

impl Link {
    /// Sends now or never; an oversized one is dropped and counted, since the path has shrunk.
    pub(crate) fn send_datagram(&self, bytes: Bytes) -> bool {
        if bytes.len() > self.session.max_datagram_size() || self.session.send_datagram(bytes).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
        true
    }

    /// Queues a frame; false when the peer takes nothing in.
    pub(crate) fn send_control(&self, frame: Vec<u8>) -> bool {
        self.control.try_send(Outgoing::Frame(frame)).is_ok()
    }

    /// Ends the connection once the queued frames are through; false when the queue is full.
    pub(crate) fn finish(&self) -> bool {
        self.control.try_send(Outgoing::Finish).is_ok()
    }

    /// Sends a keyframe behind everything else; while too many are under way it is dropped, and asked for again.
    pub(crate) fn send_keyframe(&self, bytes: Vec<u8>) -> bool {
        let Ok(permit) = Arc::clone(&self.keyframes).try_acquire_owned() else { return true };
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
        true
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

/// Accepts connections until the endpoint closes.
pub(crate) async fn accept(endpoint: quinn::Endpoint, events: mpsc::Sender<Event>) {
    let mut next = 0;
    while let Some(incoming) = endpoint.accept().await {
        next += 1;
        let peer = PeerId(next);
        let events = events.clone();
        tokio::spawn(async move {
            let connection = match incoming.await {
                Ok(connection) => connection,
                Err(error) => return tracing::debug!(%error, "a handshake did not end well"),
            };
            let remote = connection.remote_address();
            let session = Session::raw(connection);
            tracing::debug!(%remote, peer = peer.0, "connected");
            serve(peer, session, &events).await;
            tracing::debug!(peer = peer.0, "disconnected");
            // the room may have closed already
            drop(events.send(Event::Gone(peer)).await);
        });
    }
}

/// Reads one connection until it ends.
async fn serve(peer: PeerId, session: Session, events: &mpsc::Sender<Event>) {
    let Ok(Ok((send, receive))) = tokio::time::timeout(GREETING_WITHIN, session.accept_bi()).await else {
        return session.close(2, b"no greeting");
    };
    let (control, outgoing) = mpsc::channel(CONTROL_QUEUE);
    let link = Link {
        session: session.clone(),
        control,
        keyframes: Arc::new(Semaphore::new(KEYFRAMES_MAX)),
        dropped: AtomicU64::new(0),
    };
    if events.send(Event::Connected(peer, Box::new(link))).await.is_err() {
        return;
    }
    let writing = tokio::spawn(write_control(session.clone(), send, outgoing));
    tokio::select! {
        // in this order, so that a run can be repeated from a seed
        biased;
        () = read_control(peer, receive, events) => {
            // the peer is through or speaks nonsense; what is queued for it still goes out
            drop(events.send(Event::Gone(peer)).await);
            if tokio::time::timeout(GOODBYE_WITHIN, session.closed()).await.is_err() {
                session.close(3, b"the control stream has ended");
            }
        }
        () = read_datagrams(peer, &session, events) => {}
    }
    writing.abort();
}

async fn read_control(peer: PeerId, mut stream: RecvStream, events: &mpsc::Sender<Event>) {
    let mut reader = FrameReader::default();
    let mut piece = [0; 4096];
    while let Ok(Some(length)) = stream.read(&mut piece).await {
        reader.push(&piece[..length]);
        loop {
            match reader.next_frame() {
                Ok(Some(frame)) => {
                    if events.send(Event::Control(peer, frame)).await.is_err() {
                        return;
                    }
                }
                Ok(None) => break,
                Err(error) => return tracing::debug!(%error, peer = peer.0, "a control stream makes no sense"),
            }
        }
    }
}

async fn read_datagrams(peer: PeerId, session: &Session, events: &mpsc::Sender<Event>) {
    while let Ok(bytes) = session.read_datagram().await {
        if events.send(Event::Datagram(peer, bytes)).await.is_err() {
            return;
        }
    }
}

async fn write_control(session: Session, mut stream: SendStream, mut outgoing: mpsc::Receiver<Outgoing>) {
    while let Some(Outgoing::Frame(frame)) = outgoing.recv().await {
        if stream.write_all(&frame).await.is_err() {
            return;
        }
    }
    // the peer closes when it has read to the end; if it does not, it is closed
    if stream.finish().is_ok() && tokio::time::timeout(GOODBYE_WITHIN, stream.stopped()).await.is_ok() {
        tracing::trace!("the goodbye was heard");
    }
    session.close(0, b"goodbye");
}
