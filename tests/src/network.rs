//! A network in memory: sockets for QUIC endpoints, joined by lines with a seed, over tokio's paused time.
//!
//! Owns which packet arrives where and when; never looks into one. Delivery has the resolution of tokio's timer, 1 ms.
//! Invariant: with paused time, packets of the same sizes at the same times meet the same fates.

use std::collections::BTreeMap;
use std::fmt;
use std::io::{self, IoSliceMut};
use std::net::SocketAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, Waker};

use quinn::udp::{RecvMeta, Transmit};
use quinn::{AsyncUdpSocket, EndpointConfig, TokioRuntime, UdpPoller};
use tokio::time::{Instant, Sleep};

use crate::dice::Dice;
use crate::line::{Line, LineCounts, Quality};

/// Largest packet that comes through at first: an access line with a tunnel in it.
const MTU_BYTES: usize = 1400;

/// The network; clones are handles on the same one.
#[derive(Clone, Debug)]
pub struct Network(Arc<Mutex<Wires>>);

#[derive(Debug)]
struct Wires {
    began: Instant,
    dice: Dice,
    mtu_bytes: usize,
    sent: u64,
    inboxes: BTreeMap<SocketAddr, Inbox>,
    /// Line of a client to the middle of the network, up and down; who has none is in the middle.
    lines: BTreeMap<SocketAddr, (Line, Line)>,
    /// Under which address others see a socket, when it is not its own.
    seen_as: BTreeMap<SocketAddr, SocketAddr>,
}

#[derive(Debug, Default)]
struct Inbox {
    /// By time of arrival, then by order of sending.
    packets: BTreeMap<(Instant, u64), Packet>,
    waker: Option<Waker>,
}

#[derive(Clone, Debug)]
struct Packet {
    from: SocketAddr,
    bytes: Vec<u8>,
}

impl Network {
    /// An empty network; call it within a runtime with paused time.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        Self(Arc::new(Mutex::new(Wires {
            began: Instant::now(),
            dice: Dice::new(seed),
            mtu_bytes: MTU_BYTES,
            sent: 0,
            inboxes: BTreeMap::new(),
            lines: BTreeMap::new(),
            seen_as: BTreeMap::new(),
        })))
    }

    fn wires(&self) -> MutexGuard<'_, Wires> {
        // wires are whole between any two packets, so a panic elsewhere leaves nothing half done
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Joins `address` to the middle by lines of that quality, one each way.
    pub fn connect(&self, address: SocketAddr, up: Quality, down: Quality) {
        let mut wires = self.wires();
        let lines = (Line::new(up, wires.dice.split()), Line::new(down, wires.dice.split()));
        wires.lines.insert(address, lines);
    }

    /// Lets only packets of so many bytes through from now on.
    pub fn narrow(&self, mtu_bytes: usize) {
        self.wires().mtu_bytes = mtu_bytes;
    }

    /// Cuts both lines of `address`, or mends them.
    pub fn cut(&self, address: SocketAddr, is_cut: bool) {
        if let Some((up, down)) = self.wires().lines.get_mut(&address) {
            up.cut(is_cut);
            down.cut(is_cut);
        }
    }

    /// From now on others see the socket at `address` under another, `seen_as`, and find it there alone: what a router does that has
    /// forgotten a connection, or a phone that leaves one network for the next.
    pub fn readdress(&self, address: SocketAddr, seen_as: SocketAddr) {
        self.wires().seen_as.insert(address, seen_as);
    }

    /// What happened on all lines, up and down.
    #[must_use]
    pub fn counts(&self) -> (LineCounts, LineCounts) {
        let mut sums = (LineCounts::default(), LineCounts::default());
        for (up, down) in self.wires().lines.values() {
            sums.0.add(up.counts());
            sums.1.add(down.counts());
        }
        sums
    }

    /// What happened on the lines of `address`, up and down.
    #[must_use]
    pub fn counts_of(&self, address: SocketAddr) -> Option<(LineCounts, LineCounts)> {
        self.wires().lines.get(&address).map(|(up, down)| (*up.counts(), *down.counts()))
    }

    /// A QUIC endpoint at `address`, with dice of its own from the network's.
    ///
    /// # Errors
    /// What quinn says.
    pub fn endpoint(&self, address: SocketAddr, server: Option<quinn::ServerConfig>) -> io::Result<quinn::Endpoint> {
        let mut seed = [0; 32];
        {
            let mut wires = self.wires();
            wires.inboxes.insert(address, Inbox::default());
            for eight in seed.chunks_exact_mut(8) {
                eight.copy_from_slice(&wires.dice.roll().to_le_bytes());
            }
        }
        let mut config = EndpointConfig::default();
        config.rng_seed(Some(seed));
        let socket = Socket { network: self.clone(), address, alarm: Mutex::new(None) };
        quinn::Endpoint::new_with_abstract_socket(config, server, Arc::new(socket), Arc::new(TokioRuntime))
    }
}

impl Wires {
    /// The socket that is found at an address; nobody is at one that was left.
    fn behind(&self, address: SocketAddr) -> Option<SocketAddr> {
        let moved = self.seen_as.iter().find(|(_, seen_as)| **seen_as == address);
        moved.map(|(own, _)| *own).or_else(|| (!self.seen_as.contains_key(&address)).then_some(address))
    }

    fn post(&mut self, from: SocketAddr, to: SocketAddr, bytes: &[u8]) {
        let Some(to) = self.behind(to).filter(|to| bytes.len() <= self.mtu_bytes && self.inboxes.contains_key(to))
        else {
            return;
        };
        let seen_as = self.seen_as.get(&from).copied().unwrap_or(from);
        let now = self.began.elapsed();
        let in_the_middle: Vec<_> = match self.lines.get_mut(&from) {
            Some((up, _)) => up.carry(now, bytes.len()).collect(),
            None => vec![now],
        };
        for passed in in_the_middle {
            let arrivals: Vec<_> = match self.lines.get_mut(&to) {
                Some((_, down)) => down.carry(passed, bytes.len()).collect(),
                None => vec![passed],
            };
            for arrival in arrivals {
                self.sent += 1;
                let Some(inbox) = self.inboxes.get_mut(&to) else { continue };
                inbox
                    .packets
                    .insert((self.began + arrival, self.sent), Packet { from: seen_as, bytes: bytes.to_vec() });
                if let Some(waker) = inbox.waker.take() {
                    waker.wake();
                }
            }
        }
    }
}

/// A socket of the network.
struct Socket {
    network: Network,
    address: SocketAddr,
    /// Wakes the reader when the next packet is due.
    alarm: Mutex<Option<Pin<Box<Sleep>>>>,
}

impl fmt::Debug for Socket {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Socket").field("address", &self.address).finish_non_exhaustive()
    }
}

impl AsyncUdpSocket for Socket {
    fn create_io_poller(self: Arc<Self>) -> Pin<Box<dyn UdpPoller>> {
        Box::pin(AlwaysWritable)
    }

    fn try_send(&self, transmit: &Transmit) -> io::Result<()> {
        self.network.wires().post(self.address, transmit.destination, transmit.contents);
        Ok(())
    }

    fn poll_recv(
        &self,
        cx: &mut Context,
        bufs: &mut [IoSliceMut<'_>],
        meta: &mut [RecvMeta],
    ) -> Poll<io::Result<usize>> {
        let mut wires = self.network.wires();
        let Some(inbox) = wires.inboxes.get_mut(&self.address) else { return Poll::Pending };
        loop {
            let mut count = 0;
            while let Some(entry) = inbox.packets.first_entry()
                && entry.key().0 <= Instant::now()
                && count < bufs.len()
            {
                let packet = entry.remove();
                let length = packet.bytes.len();
                bufs[count][..length].copy_from_slice(&packet.bytes);
                meta[count] = RecvMeta { addr: packet.from, len: length, stride: length, ecn: None, dst_ip: None };
                count += 1;
            }
            if count > 0 {
                return Poll::Ready(Ok(count));
            }
            inbox.waker = Some(cx.waker().clone());
            let Some(((due, _), _)) = inbox.packets.first_key_value() else { return Poll::Pending };
            let mut alarm = self.alarm.lock().unwrap_or_else(PoisonError::into_inner);
            let alarm = alarm.get_or_insert_with(|| Box::pin(tokio::time::sleep_until(*due)));
            alarm.as_mut().reset(*due);
            if alarm.as_mut().poll(cx).is_pending() {
                return Poll::Pending;
            }
        }
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        Ok(self.address)
    }

    fn may_fragment(&self) -> bool {
        // too large ones are dropped, as on a real socket that must not fragment
        false
    }
}

/// Sending never waits: the queues are in the lines.
#[derive(Debug)]
struct AlwaysWritable;

impl UdpPoller for AlwaysWritable {
    fn poll_writable(self: Pin<&mut Self>, _: &mut Context) -> Poll<io::Result<()>> {
        Poll::Ready(Ok(()))
    }
}
