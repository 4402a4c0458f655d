//! Datagrams to many addresses in one call of the system.
//!
//! Owns the socket below quinn and what waits there; who is told what is decided above, and nothing is held back on purpose: what
//! waits goes out as soon as the thread has nothing more urgent to do, or when it is a whole batch.
//! Invariant: what one thread gives leaves in the order in which it was given, and nothing that was taken is dropped before the system has it.

use std::cell::RefCell;
use std::io::{self, ErrorKind, IoSlice, IoSliceMut};
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::ops::Range;
use std::os::fd::AsRawFd;
use std::pin::Pin;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll};
use std::{fmt, iter};

use nix::cmsg_space;
use nix::libc::{in_addr, in_pktinfo, in6_addr, in6_pktinfo};
use nix::sys::socket::{ControlMessage, MsgFlags, MultiHeaders, SockaddrStorage, sendmmsg};
use quinn::udp::{EcnCodepoint, RecvMeta, Transmit};
use quinn::{AsyncUdpSocket, UdpPoller};
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::task::JoinHandle;

/// Datagrams of one call: so many that the call's own time is small beside theirs, and so few that the first does not wait long for the last.
const BATCH: usize = 32;

/// A socket of quinn's that joins what it is given to send.
pub(crate) struct Batching {
    sending: Arc<Sending>,
    /// Send what is not yet a whole batch.
    rests: Vec<JoinHandle<()>>,
}

struct Sending {
    /// Quinn's own, for all that cannot be joined.
    single: Arc<dyn AsyncUdpSocket>,
    /// The same socket, for whole batches.
    many: UdpSocket,
    /// One for each thread that runs tasks, so that none waits for another's call.
    batches: Vec<Batch>,
}

/// What the tasks of a thread have given.
#[derive(Default)]
struct Batch {
    waiting: Mutex<Waiting>,
    begun: Notify,
}

/// Datagrams that have something in common and were not sent yet.
#[derive(Default)]
struct Waiting {
    bytes: Vec<u8>,
    datagrams: Vec<(SocketAddr, Range<usize>)>,
    /// How many of them are sent.
    sent: usize,
    alike: Option<Alike>,
}

/// What datagrams of one call have in common.
#[derive(Clone, Copy, PartialEq, Eq)]
struct Alike {
    is_ipv4: bool,
    ecn: Option<EcnCodepoint>,
    from: Option<IpAddr>,
}

impl Batching {
    /// Joins what is sent on `single`, which is `many` in quinn's hands. Call it within a tokio runtime.
    pub(crate) fn new(single: Arc<dyn AsyncUdpSocket>, many: UdpSocket) -> Self {
        let threads = Handle::current().metrics().num_workers();
        let batches = iter::repeat_with(Batch::default).take(threads).collect();
        let sending = Arc::new(Sending { single, many, batches });
        let rests = (0..threads).map(|number| tokio::spawn(Arc::clone(&sending).send_rests(number))).collect();
        Self { sending, rests }
    }
}

impl Drop for Batching {
    fn drop(&mut self) {
        for rest in &self.rests {
            rest.abort();
        }
        // the last words of a studio that closes
        for batch in &self.sending.batches {
            if let Err(error) = batch.waiting().send(&self.sending) {
                tracing::debug!(%error, "the last datagrams are not sent");
            }
        }
    }
}

impl fmt::Debug for Batching {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Batching").field("socket", &self.sending.single).finish_non_exhaustive()
    }
}

impl AsyncUdpSocket for Batching {
    fn create_io_poller(self: Arc<Self>) -> Pin<Box<dyn UdpPoller>> {
        Arc::clone(&self.sending.single).create_io_poller()
    }

    fn try_send(&self, transmit: &Transmit<'_>) -> io::Result<()> {
        let batch = self.sending.batch();
        let mut waiting = batch.waiting();
        let is_one = transmit.segment_size.is_none_or(|bytes| bytes >= transmit.contents.len());
        let alike = Alike::of(transmit);
        if !is_one || waiting.datagrams.len() == BATCH || waiting.alike.is_some_and(|other| other != alike) {
            waiting.send(&self.sending)?;
        }
        if !is_one {
            return self.sending.single.try_send(transmit);
        }
        waiting.take_in(transmit, alike);
        match waiting.datagrams.len() {
            1 => batch.begun.notify_one(),
            // what would not go now does with the next one, or when the socket is ready
            BATCH => drop(waiting.send(&self.sending)),
            _ => {}
        }
        Ok(())
    }

    fn poll_recv(
        &self,
        cx: &mut Context<'_>,
        bufs: &mut [IoSliceMut<'_>],
        meta: &mut [RecvMeta],
    ) -> Poll<io::Result<usize>> {
        self.sending.single.poll_recv(cx, bufs, meta)
    }

    fn local_addr(&self) -> io::Result<SocketAddr> {
        self.sending.single.local_addr()
    }

    fn max_transmit_segments(&self) -> usize {
        self.sending.single.max_transmit_segments()
    }

    fn max_receive_segments(&self) -> usize {
        self.sending.single.max_receive_segments()
    }

    fn may_fragment(&self) -> bool {
        self.sending.single.may_fragment()
    }
}

/// Threads that have sent something.
static THREADS: AtomicUsize = AtomicUsize::new(0);

thread_local! {
    static THREAD: usize = THREADS.fetch_add(1, Ordering::Relaxed);
}

impl Sending {
    /// That of the thread which asks.
    fn batch(&self) -> &Batch {
        &self.batches[THREAD.with(|thread| thread % self.batches.len())]
    }

    /// Sends, for ever, what of a batch is not whole when its thread has done what else it had to do.
    async fn send_rests(self: Arc<Self>, number: usize) {
        let batch = &self.batches[number];
        let mut poller = Arc::clone(&self.single).create_io_poller();
        loop {
            batch.begun.notified().await;
            // who was woken together goes on first
            tokio::task::yield_now().await;
            while let Err(error) = { batch.waiting().send(&self) } {
                if std::future::poll_fn(|cx| poller.as_mut().poll_writable(cx)).await.is_err() {
                    tracing::debug!(%error, "the socket is closed");
                    return;
                }
            }
        }
    }
}

impl Batch {
    fn waiting(&self) -> MutexGuard<'_, Waiting> {
        // whole between any two calls
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Waiting {
    fn take_in(&mut self, transmit: &Transmit<'_>, alike: Alike) {
        let begin = self.bytes.len();
        self.bytes.extend_from_slice(transmit.contents);
        self.datagrams.push((transmit.destination, begin..self.bytes.len()));
        self.alike = Some(alike);
    }

    /// Sends all that waits.
    ///
    /// # Errors
    /// [`ErrorKind::WouldBlock`] when the system takes no more for now; the rest goes on waiting, and quinn's own poller tells when
    /// to try again.
    fn send(&mut self, socket: &Sending) -> io::Result<()> {
        let Some(alike) = self.alike else { return Ok(()) };
        while self.sent < self.datagrams.len() {
            let sent = alike.send(&socket.many, &self.datagrams[self.sent..], &self.bytes).unwrap_or_default();
            self.sent += sent;
            if sent > 0 {
                continue;
            }
            // why the first was not taken is for quinn's own socket to find out: it knows what to do about each system
            let (destination, bytes) = self.datagrams[self.sent].clone();
            let contents = &self.bytes[bytes];
            let transmit = Transmit { destination, ecn: alike.ecn, contents, segment_size: None, src_ip: alike.from };
            match socket.single.try_send(&transmit) {
                Err(error) if error.kind() == ErrorKind::WouldBlock => return Err(error),
                Err(error) => tracing::debug!(%error, "a datagram cannot be sent"),
                Ok(()) => {}
            }
            self.sent += 1;
        }
        self.bytes.clear();
        self.datagrams.clear();
        (self.sent, self.alike) = (0, None);
        Ok(())
    }
}

/// The system's own lists of what is to be sent, and whether an address of IPv4, of IPv6 or none is in their control messages.
type Headers = (Option<bool>, MultiHeaders<SockaddrStorage>);

thread_local! {
    /// They hold pointers, so that each thread has its own.
    static HEADERS: RefCell<Option<Headers>> = const { RefCell::new(None) };
}

impl Alike {
    fn of(transmit: &Transmit<'_>) -> Self {
        let is_ipv4 = match transmit.destination.ip() {
            IpAddr::V4(_) => true,
            IpAddr::V6(address) => address.to_ipv4_mapped().is_some(),
        };
        Self { is_ipv4, ecn: transmit.ecn, from: transmit.src_ip }
    }

    /// Sends the first [`BATCH`] datagrams in one call; how many the system took.
    fn send(&self, socket: &UdpSocket, datagrams: &[(SocketAddr, Range<usize>)], bytes: &[u8]) -> nix::Result<usize> {
        let datagrams = &datagrams[..datagrams.len().min(BATCH)];
        let mark = self.ecn.map_or(0, |ecn| ecn as u8);
        let wide_mark = i32::from(mark);
        let marked = if self.is_ipv4 { ControlMessage::Ipv4Tos(&mark) } else { ControlMessage::Ipv6TClass(&wide_mark) };
        let mut from_ipv4 =
            in_pktinfo { ipi_ifindex: 0, ipi_spec_dst: in_addr { s_addr: 0 }, ipi_addr: in_addr { s_addr: 0 } };
        let mut from_ipv6 = in6_pktinfo { ipi6_addr: in6_addr { s6_addr: [0; 16] }, ipi6_ifindex: 0 };
        let from = self.from.map(|address| match address {
            IpAddr::V4(address) => {
                from_ipv4.ipi_spec_dst.s_addr = u32::from_ne_bytes(address.octets());
                ControlMessage::Ipv4PacketInfo(&from_ipv4)
            }
            IpAddr::V6(address) => {
                from_ipv6.ipi6_addr.s6_addr = address.octets();
                ControlMessage::Ipv6PacketInfo(&from_ipv6)
            }
        });
        let control = [marked, from.unwrap_or(marked)];
        let control = if from.is_some() { &control[..] } else { &control[..1] };
        let mut parts = [[IoSlice::new(&[])]; BATCH];
        let mut addresses = [const { None }; BATCH];
        for (((destination, range), part), address) in datagrams.iter().zip(&mut parts).zip(&mut addresses) {
            *part = [IoSlice::new(&bytes[range.clone()])];
            *address = Some(SockaddrStorage::from(*destination));
        }
        HEADERS.with_borrow_mut(|headers| {
            let kind = self.from.map(|address| address.is_ipv4());
            let (_, headers) = match headers {
                Some(made) if made.0 == kind => made,
                _ => {
                    let space = match kind {
                        None => cmsg_space!(i32),
                        Some(true) => cmsg_space!(i32, in_pktinfo),
                        Some(false) => cmsg_space!(i32, in6_pktinfo),
                    };
                    headers.insert((kind, MultiHeaders::preallocate(BATCH, Some(space))))
                }
            };
            let parts = &parts[..datagrams.len()];
            let sent = sendmmsg(socket.as_raw_fd(), headers, parts, addresses, control, MsgFlags::empty())?;
            Ok(sent.count())
        })
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, Ipv6Addr};
    use std::time::Duration;

    use quinn::{Runtime as _, TokioRuntime};

    use super::*;

    fn batching(address: &str) -> (Batching, u16) {
        let socket = UdpSocket::bind(address).unwrap();
        let (port, many) = (socket.local_addr().unwrap().port(), socket.try_clone().unwrap());
        (Batching::new(TokioRuntime.wrap_udp_socket(socket).unwrap(), many), port)
    }

    fn to(destination: SocketAddr, contents: &[u8]) -> Transmit<'_> {
        Transmit { destination, ecn: Some(EcnCodepoint::Ect0), contents, segment_size: None, src_ip: None }
    }

    /// Sends, and waits as quinn does where the socket is not ready.
    async fn send(batching: &Batching, transmit: &Transmit<'_>) {
        let mut poller = Arc::clone(&batching.sending.single).create_io_poller();
        while let Err(error) = batching.try_send(transmit) {
            assert_eq!(error.kind(), ErrorKind::WouldBlock);
            std::future::poll_fn(|cx| poller.as_mut().poll_writable(cx)).await.unwrap();
        }
    }

    fn receiver() -> (UdpSocket, SocketAddr) {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket.set_nonblocking(true).unwrap();
        let address = socket.local_addr().unwrap();
        (socket, address)
    }

    /// The first bytes of all datagrams that have come.
    fn come(socket: &UdpSocket) -> Vec<u8> {
        let mut bytes = [0; 8];
        iter::from_fn(|| socket.recv(&mut bytes).ok().map(|_| bytes[0])).collect()
    }

    #[tokio::test]
    async fn a_batch_goes_at_once_and_the_rest_when_nothing_else_is_to_be_done() {
        let (batching, _) = batching("127.0.0.1:0");
        let receivers: Vec<_> = (0..BATCH + 8).map(|_| receiver()).collect();
        for (number, (_, address)) in receivers.iter().enumerate() {
            batching.try_send(&to(*address, &[number as u8])).unwrap();
        }
        let come_by = || receivers.iter().flat_map(|(socket, _)| come(socket)).collect::<Vec<_>>();
        assert_eq!(come_by(), (0..BATCH as u8).collect::<Vec<_>>(), "a whole batch");
        tokio::time::sleep(Duration::from_millis(20)).await;
        assert_eq!(come_by(), (BATCH as u8..BATCH as u8 + 8).collect::<Vec<_>>(), "the rest");
    }

    #[tokio::test]
    async fn order_is_kept_also_round_what_cannot_be_joined() {
        let (batching, _) = batching("127.0.0.1:0");
        let (socket, address) = receiver();
        for number in 0..10 {
            send(&batching, &to(address, &[number])).await;
        }
        // two in one, cut apart by the system
        send(&batching, &Transmit { segment_size: Some(1), ..to(address, &[10, 11]) }).await;
        for number in 12..20 {
            let ecn = (number % 2 == 0).then_some(EcnCodepoint::Ect0);
            send(&batching, &Transmit { ecn, ..to(address, &[number]) }).await;
        }
        drop(batching);
        assert_eq!(come(&socket), (0..20).collect::<Vec<_>>(), "also what waited when it was dropped");
    }

    #[tokio::test]
    async fn what_quinn_says_of_a_datagram_is_kept() {
        let (batching, port) = batching("[::]:0");
        let receivers = [
            ("127.0.0.1:0", IpAddr::from(Ipv4Addr::new(127, 0, 0, 2))),
            ("[::1]:0", IpAddr::from(Ipv6Addr::LOCALHOST)),
        ];
        for (address, from) in receivers {
            let receiver = TokioRuntime.wrap_udp_socket(UdpSocket::bind(address).unwrap()).unwrap();
            let destination = match receiver.local_addr().unwrap() {
                SocketAddr::V4(address) => SocketAddr::from((address.ip().to_ipv6_mapped(), address.port())),
                address => address,
            };
            for ecn in [Some(EcnCodepoint::Ect0), None] {
                send(&batching, &Transmit { ecn, src_ip: Some(from), ..to(destination, b"x") }).await;
                let mut meta = [RecvMeta::default()];
                let mut bytes = [0; 8];
                let received =
                    std::future::poll_fn(|cx| receiver.poll_recv(cx, &mut [IoSliceMut::new(&mut bytes)], &mut meta));
                let received = tokio::time::timeout(Duration::from_secs(10), received).await.unwrap();
                assert_eq!(received.unwrap(), 1);
                assert_eq!((meta[0].addr, meta[0].ecn), (SocketAddr::from((from, port)), ecn));
            }
        }
    }

    /// A socket that takes nothing three times before each datagram.
    #[derive(Debug, Default)]
    struct Slow {
        refused: Mutex<u32>,
        taken: Mutex<Vec<u8>>,
    }

    #[derive(Debug)]
    struct Ready;

    impl UdpPoller for Ready {
        fn poll_writable(self: Pin<&mut Self>, _: &mut Context<'_>) -> Poll<io::Result<()>> {
            Poll::Ready(Ok(()))
        }
    }

    impl AsyncUdpSocket for Slow {
        fn create_io_poller(self: Arc<Self>) -> Pin<Box<dyn UdpPoller>> {
            Box::pin(Ready)
        }

        fn try_send(&self, transmit: &Transmit<'_>) -> io::Result<()> {
            let mut refused = self.refused.lock().unwrap();
            *refused = (*refused + 1) % 4;
            if *refused > 0 {
                return Err(ErrorKind::WouldBlock.into());
            }
            self.taken.lock().unwrap().push(transmit.contents[0]);
            Ok(())
        }

        fn poll_recv(
            &self,
            _: &mut Context<'_>,
            _: &mut [IoSliceMut<'_>],
            _: &mut [RecvMeta],
        ) -> Poll<io::Result<usize>> {
            Poll::Pending
        }

        fn local_addr(&self) -> io::Result<SocketAddr> {
            Ok(SocketAddr::from(([127, 0, 0, 1], 1)))
        }
    }

    #[tokio::test]
    async fn what_the_system_does_not_take_waits_and_goes_in_order() {
        let slow = Arc::new(Slow::default());
        // to an address that this socket cannot send to, so that each is left to the other
        let batching = Batching::new(Arc::clone(&slow) as _, UdpSocket::bind("127.0.0.1:0").unwrap());
        let address = SocketAddr::from((Ipv6Addr::LOCALHOST, 1));
        let mut given = 0;
        let mut is_refused = false;
        while given < 3 * BATCH as u8 {
            match batching.try_send(&to(address, &[given])) {
                Ok(()) => given += 1,
                Err(error) => {
                    assert_eq!(error.kind(), ErrorKind::WouldBlock);
                    is_refused = true;
                    tokio::task::yield_now().await;
                }
            }
        }
        assert!(is_refused, "more than a batch was kept");
        tokio::time::sleep(Duration::from_millis(20)).await;
        assert_eq!(*slow.taken.lock().unwrap(), (0..given).collect::<Vec<_>>());
    }
}
