//! A connection's streams, each read or written by a task of its own.
//!
//! Owns queues and tasks; what the frames and keyframes say is for whoever holds the queues.
//! Invariant: every task ends with the connection, or when the queues are gone.

use pottery_shared::protocol::{FrameReader, KEYFRAME_MAX};
use tokio::sync::mpsc;
use web_transport_quinn::{RecvStream, SendStream, Session};

use crate::view::Link;

/// What came on a stream.
#[derive(Debug)]
pub enum Arrival {
    /// A control frame.
    Frame(Vec<u8>),
    /// A whole keyframe.
    Keyframe(Vec<u8>),
    /// There will be no more frames.
    StreamEnded,
}

/// The ends of the queues to and from the streams.
#[derive(Debug)]
pub struct Streams {
    /// Frames for the control stream.
    pub outgoing: mpsc::Sender<Vec<u8>>,
    /// What came.
    pub arriving: mpsc::Receiver<Arrival>,
}

impl Streams {
    /// Sets tasks to the streams of a connection; `frames` holds what was read beyond the first frame.
    pub(crate) fn new(
        connection: &Session,
        control_out: SendStream,
        control_in: RecvStream,
        frames: FrameReader,
    ) -> Self {
        let (arrived, arriving) = mpsc::channel(64);
        let (outgoing, to_write) = mpsc::channel(64);
        tokio::spawn(read_control(control_in, frames, arrived.clone()));
        tokio::spawn(read_keyframes(connection.clone(), arrived));
        tokio::spawn(write_control(control_out, to_write));
        Self { outgoing, arriving }
    }
}

async fn read_control(mut stream: RecvStream, mut frames: FrameReader, arrived: mpsc::Sender<Arrival>) {
    let mut piece = [0; 4096];
    loop {
        match frames.next_frame() {
            Ok(Some(frame)) => {
                if arrived.send(Arrival::Frame(frame)).await.is_err() {
                    return;
                }
                continue;
            }
            Ok(None) => {}
            Err(error) => {
                tracing::warn!(%error, "the control stream makes no sense");
                break;
            }
        }
        match stream.read(&mut piece).await {
            Ok(Some(length)) => frames.push(&piece[..length]),
            Ok(None) | Err(_) => break,
        }
    }
    // nobody listens any more when the worker has ended first
    drop(arrived.send(Arrival::StreamEnded).await);
}

async fn read_keyframes(connection: Session, arrived: mpsc::Sender<Arrival>) {
    while let Ok(mut stream) = connection.accept_uni().await {
        match stream.read_to_end(KEYFRAME_MAX).await {
            Ok(bytes) => {
                if arrived.send(Arrival::Keyframe(bytes)).await.is_err() {
                    return;
                }
            }
            Err(error) => tracing::debug!(%error, "a keyframe did not arrive whole"),
        }
    }
}

async fn write_control(mut stream: SendStream, mut to_write: mpsc::Receiver<Vec<u8>>) {
    while let Some(frame) = to_write.recv().await {
        if stream.write_all(&frame).await.is_err() {
            return;
        }
    }
}

/// How a connection stands whose reading ended with an error.
pub(crate) fn closed_or_lost(error: &web_transport_quinn::SessionError) -> Link {
    use quinn::ConnectionError as E;
    use web_transport_quinn::{SessionError, WebTransportError};
    match error {
        // a goodbye carries no code
        SessionError::WebTransportError(WebTransportError::Closed(0, _))
        | SessionError::ConnectionError(E::ApplicationClosed(_) | E::LocallyClosed) => Link::Closed,
        SessionError::WebTransportError(WebTransportError::Closed(_, reason)) => {
            Link::Lost(format!("the studio has ended the connection: {reason}"))
        }
        SessionError::ConnectionError(E::TimedOut) => {
            Link::Lost("the studio has not answered for 10 seconds; the connection is lost".into())
        }
        other => Link::Lost(format!("the connection is lost: {other}")),
    }
}
