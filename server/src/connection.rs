//! Connections: accepted, read into events, written from their queues.
//!
//! Knows no room: turns the bytes of streams into frames and hands them on.
//! One type, `web_transport_quinn::Session`, carries every connection: today native QUIC, later browsers as well.
//! Invariant: a connection that ends, however it does, is reported as gone.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pottery_shared::protocol::{self, FrameReader};
use pottery_shared::room::PeerId;
use tokio::sync::{OwnedSemaphorePermit, Semaphore, mpsc};
use web_transport_quinn::{RecvStream, SendStream, Session};

use crate::bounds::STRANGERS;
use crate::doorkeeper::SharedDoorkeeper;
use crate::event::Event;
use crate::input::{Kind, Share};
use crate::link::{Link, Outgoing};

/// A peer that has opened no stream by then did not mean to join: over 400 ms there and back with a tenth lost, one in two hundred takes nine seconds
/// to come in.
const STREAM_WITHIN: Duration = Duration::from_secs(10);
/// Nor did one that has not greeted on it.
const GREETING_WITHIN: Duration = Duration::from_secs(5);
/// Time in which a peer takes in the last frames.
const GOODBYE_WITHIN: Duration = Duration::from_millis(800);

/// Accepts connections until the endpoint closes, for a room that takes so many people.
pub(crate) async fn accept(
    endpoint: quinn::Endpoint,
    people_max: u16,
    events: mpsc::Sender<Event>,
    doorkeeper: SharedDoorkeeper,
) {
    let mut next = 0;
    let strangers_max = usize::from(people_max) + STRANGERS;
    // a place for each who has not been let in, from wherever they come
    let strangers = Arc::new(Semaphore::new(strangers_max));
    while let Some(incoming) = endpoint.accept().await {
        let address = incoming.remote_address().ip();
        let is_crowded = strangers.available_permits() < strangers_max / 2;
        if (is_crowded || doorkeeper.is_doubtful(address)) && incoming.may_retry() {
            // a token proves the address, at the price of a round trip
            drop(incoming.retry());
            continue;
        }
        let Ok(stranger) = Arc::clone(&strangers).try_acquire_owned() else {
            doorkeeper.note_crowd();
            incoming.ignore();
            continue;
        };
        if !doorkeeper.may_come(address) {
            // who means it knocks again by itself, and comes in when its turn has come
            incoming.ignore();
            continue;
        }
        next += 1;
        let peer = PeerId(next);
        let events = events.clone();
        let doorkeeper = doorkeeper.clone();
        tokio::spawn(async move {
            let connection = match incoming.await {
                Ok(connection) => connection,
                Err(error) => return tracing::debug!(%error, "a handshake did not end well"),
            };
            let remote = connection.remote_address();
            let session = Session::raw(connection);
            tracing::debug!(%remote, peer = peer.0, "connected");
            serve(peer, session, stranger, &events, &doorkeeper).await;
            tracing::debug!(peer = peer.0, "disconnected");
            // the room may have closed already
            drop(events.send(Event::Gone(peer)).await);
        });
    }
}

/// Reads one connection until it ends.
async fn serve(
    peer: PeerId,
    session: Session,
    stranger: OwnedSemaphorePermit,
    events: &mpsc::Sender<Event>,
    doorkeeper: &SharedDoorkeeper,
) {
    let Ok(Ok((send, receive))) = tokio::time::timeout(STREAM_WITHIN, session.accept_bi()).await else {
        return session.close(protocol::CLOSED_UNHEARD, b"no greeting");
    };
    let (link, outgoing) = Link::new(session.clone(), stranger);
    let is_in = link.is_in();
    let [datagrams, requests] = Kind::ALL.map(|kind| Share::new(doorkeeper, kind));
    if events.send(Event::Connected(peer, Box::new(link))).await.is_err() {
        return;
    }
    let writing = tokio::spawn(write_control(session.clone(), send, outgoing));
    tokio::select! {
        // in this order, so that a run can be repeated from a seed
        biased;
        () = read_control(peer, &session, receive, requests, events) => {
            // the peer is through or speaks nonsense; what is queued for it still goes out
            drop(events.send(Event::Gone(peer)).await);
            if tokio::time::timeout(GOODBYE_WITHIN, session.closed()).await.is_err() {
                session.close(3, b"the control stream has ended");
            }
        }
        () = read_datagrams(peer, &session, &is_in, datagrams, events, doorkeeper) => {}
    }
    writing.abort();
}

/// Reads requests; one that is too much for the connection's address waits, and QUIC keeps the peer from sending many more.
async fn read_control(
    peer: PeerId,
    session: &Session,
    mut stream: RecvStream,
    mut share: Share,
    events: &mpsc::Sender<Event>,
) {
    let mut reader = FrameReader::default();
    let greeting = tokio::time::timeout(GREETING_WITHIN, next_frame(peer, &mut stream, &mut reader));
    let Ok(mut next) = greeting.await else { return tracing::debug!(peer = peer.0, "no greeting") };
    while let Some(frame) = next {
        share.wait(frame.len(), || session.remote_address().ip()).await;
        if events.send(Event::Control(peer, frame)).await.is_err() {
            return;
        }
        next = next_frame(peer, &mut stream, &mut reader).await;
    }
}

/// The next frame of a control stream; none when it has ended or makes no sense.
async fn next_frame(peer: PeerId, stream: &mut RecvStream, reader: &mut FrameReader) -> Option<Vec<u8>> {
    let mut piece = [0; 4096];
    loop {
        match reader.next_frame() {
            Ok(Some(frame)) => return Some(frame),
            Ok(None) => {}
            Err(error) => {
                tracing::debug!(%error, peer = peer.0, "a control stream makes no sense");
                return None;
            }
        }
        let length = stream.read(&mut piece).await.ok()??;
        reader.push(&piece[..length]);
    }
}

/// Reads datagrams; those of who is not in, and those that are too much for the connection's address, are not heard, and who sends
/// far too many of them is let go and comes back as slowly as one who guesses codes.
async fn read_datagrams(
    peer: PeerId,
    session: &Session,
    is_in: &AtomicBool,
    mut share: Share,
    events: &mpsc::Sender<Event>,
    doorkeeper: &SharedDoorkeeper,
) {
    let address = || session.remote_address().ip();
    while let Ok(bytes) = session.read_datagram().await {
        if is_in.load(Ordering::Relaxed) && share.hears(bytes.len(), address) {
            if events.send(Event::Datagram(peer, bytes)).await.is_err() {
                return;
            }
        } else if !share.bears_it() {
            tracing::info!(peer = peer.0, "a peer that sends far too much is let go");
            doorkeeper.note_wrong_code(address());
            return session.close(4, b"too much");
        }
    }
}

async fn write_control(session: Session, mut stream: SendStream, mut outgoing: mpsc::Receiver<Outgoing>) {
    while let Some(Outgoing::Frame(frame, _room)) = outgoing.recv().await {
        if stream.write_all(&frame).await.is_err() {
            return session.close(3, b"the control stream has ended");
        }
    }
    // the peer closes when it has read to the end; if it does not, it is closed
    if stream.finish().is_ok() && tokio::time::timeout(GOODBYE_WITHIN, stream.stopped()).await.is_ok() {
        tracing::trace!("the goodbye was heard");
    }
    session.close(0, b"goodbye");
}
