//! Connections: accepted, read into events, written from their queues.
//!
//! Knows no room: turns the bytes of streams into frames and hands them on.
//! One type, `web_transport_quinn::Session`, carries every connection: today native QUIC, later browsers as well.
//! Invariant: a connection that ends, however it does, is reported as gone.

use std::time::Duration;

use pottery_shared::protocol::FrameReader;
use pottery_shared::room::PeerId;
use tokio::sync::mpsc;
use web_transport_quinn::{RecvStream, SendStream, Session};

use crate::doorkeeper::SharedDoorkeeper;
use crate::event::Event;
use crate::link::{Link, Outgoing};

/// A peer that has said nothing by then did not mean to join.
const GREETING_WITHIN: Duration = Duration::from_secs(5);
/// Time in which a peer takes in the last frames.
const GOODBYE_WITHIN: Duration = Duration::from_millis(800);

/// Accepts connections until the endpoint closes.
pub(crate) async fn accept(endpoint: quinn::Endpoint, events: mpsc::Sender<Event>, doorkeeper: SharedDoorkeeper) {
    let mut next = 0;
    while let Some(incoming) = endpoint.accept().await {
        let address = incoming.remote_address().ip();
        if doorkeeper.is_doubtful(address) && incoming.may_retry() {
            // a token proves the address, at the price of a round trip
            drop(incoming.retry());
            continue;
        }
        if !doorkeeper.may_come(address) {
            // who means it knocks again by itself, and comes in when its turn has come
            incoming.ignore();
            continue;
        }
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
    let (link, outgoing) = Link::new(session.clone());
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
    while let Some(Outgoing::Frame(frame, _room)) = outgoing.recv().await {
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
