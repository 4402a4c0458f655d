//! A real UDP forwarder between clients on this machine and a server that loses, delays and reorders packets.
//!
//! Owns sockets and a task for each direction of each client; what happens to a packet is the line's.
//! Invariant: each client reaches the server from a port of its own, so that the server can tell them apart.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::io;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::net::UdpSocket;
use tokio::task::JoinSet;
use tokio::time::Instant;

use super::dice::Dice;
use super::line::{Line, LineCounts, Quality};

/// Largest packet taken in.
const PACKET_BYTES: usize = 2048;

/// A running forwarder; it ends when it is dropped.
#[derive(Debug)]
pub struct Proxy {
    address: SocketAddr,
    counts: Arc<Mutex<Counts>>,
    /// Everything that runs ends with it.
    _forwarding: JoinSet<()>,
}

/// Up and down.
type Counts = (LineCounts, LineCounts);

impl Proxy {
    /// Forwards what reaches a free port of this machine to `server`, over lines of that quality both ways.
    ///
    /// # Errors
    /// What the system says about the socket.
    pub async fn start(server: SocketAddr, quality: Quality, seed: u64) -> io::Result<Self> {
        let socket = UdpSocket::bind("127.0.0.1:0").await?;
        let address = socket.local_addr()?;
        let counts = Arc::new(Mutex::new(Counts::default()));
        let mut forwarding = JoinSet::new();
        let forwarder = Forwarder {
            socket: Arc::new(socket),
            server,
            quality,
            dice: Dice::new(seed),
            began: Instant::now(),
            counts: Arc::clone(&counts),
        };
        forwarding.spawn(async move {
            if let Err(error) = forwarder.run().await {
                tracing::error!(%error, "the proxy has ended");
            }
        });
        Ok(Self { address, counts, _forwarding: forwarding })
    }

    /// Where clients find the server.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// What happened so far, up and down.
    #[must_use]
    pub fn counts(&self) -> (LineCounts, LineCounts) {
        *self.counts.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct Forwarder {
    socket: Arc<UdpSocket>,
    server: SocketAddr,
    quality: Quality,
    dice: Dice,
    began: Instant,
    counts: Arc<Mutex<Counts>>,
}

impl Forwarder {
    async fn run(mut self) -> io::Result<()> {
        let mut upstreams: BTreeMap<SocketAddr, (Arc<UdpSocket>, Line)> = BTreeMap::new();
        // ends with this future, so with the proxy
        let mut tasks = JoinSet::new();
        let mut packet = [0; PACKET_BYTES];
        loop {
            let (length, client) = self.socket.recv_from(&mut packet).await?;
            let (upstream, line) = match upstreams.entry(client) {
                Entry::Occupied(known) => known.into_mut(),
                Entry::Vacant(new) => {
                    let upstream = Arc::new(UdpSocket::bind(any_of_its_kind(self.server)).await?);
                    upstream.connect(self.server).await?;
                    let up = Line::new(self.quality, self.dice.split());
                    let down = Line::new(self.quality, self.dice.split());
                    tasks.spawn(self.bring_down(Arc::clone(&upstream), client, down));
                    new.insert((upstream, up))
                }
            };
            let before = *line.counts();
            for due in line.carry(self.began.elapsed(), length) {
                let (upstream, bytes, at) = (Arc::clone(upstream), packet[..length].to_vec(), self.began + due);
                tasks.spawn(async move {
                    tokio::time::sleep_until(at).await;
                    // the server may be gone
                    drop(upstream.send(&bytes).await);
                });
            }
            note(&mut self.counts.lock().unwrap_or_else(PoisonError::into_inner).0, &before, line.counts());
            while tasks.try_join_next().is_some() {}
        }
    }

    fn bring_down(
        &self,
        upstream: Arc<UdpSocket>,
        client: SocketAddr,
        mut line: Line,
    ) -> impl Future<Output = ()> + Send + use<> {
        let (socket, began, counts) = (Arc::clone(&self.socket), self.began, Arc::clone(&self.counts));
        async move {
            let mut tasks = JoinSet::new();
            let mut packet = [0; PACKET_BYTES];
            loop {
                let Ok(length) = upstream.recv(&mut packet).await else {
                    // a server that is gone answers with an error for each packet sent to it
                    tokio::time::sleep(Duration::from_millis(1)).await;
                    continue;
                };
                let before = *line.counts();
                for due in line.carry(began.elapsed(), length) {
                    let (socket, bytes, at) = (Arc::clone(&socket), packet[..length].to_vec(), began + due);
                    tasks.spawn(async move {
                        tokio::time::sleep_until(at).await;
                        // the client may be gone
                        drop(socket.send_to(&bytes, client).await);
                    });
                }
                note(&mut counts.lock().unwrap_or_else(PoisonError::into_inner).1, &before, line.counts());
                while tasks.try_join_next().is_some() {}
            }
        }
    }
}

/// Any port on every network of the kind that an address is of.
fn any_of_its_kind(server: SocketAddr) -> SocketAddr {
    match server {
        SocketAddr::V4(_) => (Ipv4Addr::UNSPECIFIED, 0).into(),
        SocketAddr::V6(_) => (Ipv6Addr::UNSPECIFIED, 0).into(),
    }
}

/// Adds what a line has counted since `before`.
const fn note(sum: &mut LineCounts, before: &LineCounts, after: &LineCounts) {
    sum.packets += after.packets - before.packets;
    sum.bytes += after.bytes - before.bytes;
    sum.lost += after.lost - before.lost;
    sum.overflowed += after.overflowed - before.overflowed;
    sum.doubled += after.doubled - before.doubled;
}
