//! A server that knows no pottery: what quinn itself takes for the datagrams that a studio sends.
//!
//! Has the studio's transport and pulse, and sends everybody the same bytes.
//! Invariant: nothing is made for each subscriber that the studio does not make.

use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use bytes::{BufMut as _, Bytes, BytesMut};
use tokio::sync::mpsc;

/// Time between two datagrams, as between two snapshots.
pub const SNAPSHOT: Duration = Duration::from_nanos(16_666_667);
/// When it was due, ns since the server began: the first of a datagram's bytes, and the shortest datagram.
pub const STAMP_BYTES: usize = 8;

/// Sends whoever comes to `endpoint` so many bytes sixty times a second, and counts them in `sent`; never ends.
pub async fn serve(endpoint: quinn::Endpoint, bytes: usize, sent: &AtomicU64) {
    let (came, mut coming) = mpsc::channel(1024);
    tokio::spawn(async move {
        while let Some(incoming) = endpoint.accept().await {
            if let Ok(connection) = incoming.await
                && came.send(connection).await.is_err()
            {
                return;
            }
        }
    });
    let mut subscribers: Vec<quinn::Connection> = Vec::new();
    let mut tick = tokio::time::interval(SNAPSHOT);
    let began = tokio::time::Instant::now();
    loop {
        tokio::select! {
            due = tick.tick() => {
                let payload = stamped(due - began, bytes);
                subscribers.retain(|subscriber| subscriber.send_datagram(payload.clone()).is_ok());
                sent.fetch_add(subscribers.len() as u64, Ordering::Relaxed);
            }
            Some(subscriber) = coming.recv() => subscribers.push(subscriber),
        }
    }
}

/// A datagram of so many bytes that says when it was due.
fn stamped(due: Duration, bytes: usize) -> Bytes {
    let mut datagram = BytesMut::with_capacity(bytes);
    datagram.put_u64_le(due.as_nanos() as u64);
    datagram.resize(bytes, 7);
    datagram.freeze()
}
