//! What a subscriber costs the server, beside a bare quinn program that sends the same datagrams and knows no pottery.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench subscribers -- [subscribers]`, after
//! `cargo build --release -p pottery-server`. Ours and the bare one take turns, three times, each a process of its own under
//! the same readers; below them the system's own limit: one datagram a call, and sixteen a call, to one address (GSO) and to sixteen (`sendmmsg`).
//! With `-- limit [subscribers]` each has a core of its own and more and more subscribers, or fewer and fewer, to where what they get is older
//! than 20 ms (p99) in three tries, between which the other has its turn.

use std::io::{BufRead, BufReader};
use std::net::{Ipv4Addr, SocketAddr, UdpSocket};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use hdrhistogram::Histogram;
use pottery_client::{Streams, Target, client_config, endpoint, join};
use pottery_server::{Certificate, bind};
use pottery_shared::protocol::{Body, DATAGRAM_MEMORY_MAX, JoinCode, Pulse, decode};
use pottery_shared::session::Client;
use pottery_tests::load::bare::{self, SNAPSHOT, STAMP_BYTES};
use pottery_tests::load::cores::Apart;
use pottery_tests::load::host::{Host, usage};
use pottery_tests::load::plan::Plan;
use pottery_tests::load::run::{Against, Options, run};
use pottery_tests::load::schedule::Punctuality;
use pottery_tests::load::stop::Stop;
use tokio::task::JoinSet;

/// Says to this program that it is the bare server, and with how many bytes a datagram.
const BARE: &str = "POTTERY_BARE_BYTES";
const WARM_UP: Duration = Duration::from_secs(2);
const MEASURED: Duration = Duration::from_secs(6);
const TURNS: usize = 3;

type Fault = Box<dyn std::error::Error + Send + Sync>;

/// What a server cost.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// % of a core.
    cpu_percent: f64,
    /// Datagrams a second that arrived.
    datagrams_per_s: f64,
    /// UDP payload of one.
    bytes: f64,
    /// From when it was due to its arrival, p99.
    age_ms: f64,
    /// Processor time of those who read, % of a core.
    readers_percent: f64,
}

impl Cost {
    fn us_a_datagram(&self) -> f64 {
        self.cpu_percent * 1e4 / self.datagrams_per_s
    }

    /// Whether so many were served in time.
    fn is_held(&self, subscribers: u32) -> bool {
        self.age_ms <= OLD_MS && self.datagrams_per_s * SNAPSHOT.as_secs_f64() > 0.98 * f64::from(subscribers)
    }

    fn print(&self, name: &str, subscribers: u32) {
        println!(
            "{name:<7}{subscribers:>5} subscribers {:>8.0} datagrams/s of {:>4.0} B {:>6.1} % of a core {:>6.2} µs a datagram, readers {:>5.1} %, age p99 {:>6.1} ms",
            self.datagrams_per_s,
            self.bytes,
            self.cpu_percent,
            self.us_a_datagram(),
            self.readers_percent,
            self.age_ms
        );
    }
}

fn main() -> Result<(), Fault> {
    if let Ok(bytes) = std::env::var(BARE) {
        return runtime()?.block_on(serve(bytes.parse()?));
    }
    let number = std::env::args().filter_map(|argument| argument.parse().ok()).next();
    if std::env::args().any(|argument| argument == "limit") {
        return limits(number.unwrap_or(400));
    }
    let subscribers = number.unwrap_or(400);
    let (mut ours, mut bare) = (Vec::new(), Vec::new());
    for _ in 0..TURNS {
        let one = studio(subscribers, None)?;
        let other = plain(subscribers, one.bytes, None)?;
        one.print("studio", subscribers);
        other.print("bare", subscribers);
        ours.push(one.us_a_datagram());
        bare.push(other.us_a_datagram());
    }
    let (ours, bare) = (median(ours), median(bare));
    println!("studio {ours:.2} µs a datagram, bare quinn {bare:.2} µs: bare/studio = {:.2}", bare / ours);
    for segments in [1, 16] {
        println!("system: {:.2} µs a datagram of 300 B with {segments} a call", raw(segments)?);
    }
    #[cfg(target_os = "linux")]
    println!("system: {:.2} µs a datagram of 300 B with 16 a call, each to another address", raw_to_many(16)?);
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load averages at the end: {}", load.trim());
    Ok(())
}

/// How much more is tried next, and what age ends it.
const MORE: f64 = 1.06;
const OLD_MS: f64 = 20.0;

/// How often so many are tried before they count as too many: a machine that others use is slow for half a minute now and then.
const TRIES: u32 = 3;

/// How many subscribers each holds on a core of its own, by turns, so that an hour in which the machine is slow is both's.
fn limits(first: u32) -> Result<(), Fault> {
    let apart = Apart::new(1)?;
    let mut bytes = None;
    let mut searches = [Search::default(); 2];
    while searches.iter().any(|search| !search.is_over) {
        if !searches[0].is_over {
            let subscribers = searches[0].subscribers(first);
            let cost = studio(subscribers, Some(apart))?;
            bytes.get_or_insert(cost.bytes);
            cost.print("studio", subscribers);
            searches[0].note(cost.is_held(subscribers));
        }
        if !searches[1].is_over {
            let subscribers = searches[1].subscribers(first);
            let cost = plain(subscribers, bytes.ok_or("the studio comes first")?, Some(apart))?;
            cost.print("bare", subscribers);
            searches[1].note(cost.is_held(subscribers));
        }
    }
    let [ours, bare] = searches.map(|search| if search.is_held { search.subscribers(first) } else { 0 });
    println!(
        "within {OLD_MS} ms: studio {ours}, bare quinn {bare}: studio/bare = {:.2}",
        f64::from(ours) / f64::from(bare)
    );
    Ok(())
}

/// The search for the most that a server holds: up as long as they are held, or else down until they are.
#[derive(Clone, Copy, Debug, Default)]
struct Search {
    /// Steps from the first try on, each [`MORE`] times as many.
    step: i32,
    /// Tries of so many in which they were not held.
    missed: u32,
    is_held: bool,
    is_over: bool,
}

impl Search {
    /// A fifth of the first try; who holds no more is out of order.
    const DOWN_MAX: i32 = -28;

    fn subscribers(&self, first: u32) -> u32 {
        (f64::from(first) * MORE.powi(self.step)) as u32
    }

    /// Takes in whether so many were held in a try.
    const fn note(&mut self, is_held: bool) {
        self.missed = if is_held { 0 } else { self.missed + 1 };
        if is_held || self.missed == TRIES {
            self.missed = 0;
            self.go_on(is_held);
        }
    }

    /// Goes on to more or to fewer.
    const fn go_on(&mut self, is_held: bool) {
        match (is_held, self.is_held) {
            // it came down to here
            (true, false) if self.step < 0 => (self.is_held, self.is_over) = (true, true),
            (true, _) => (self.step, self.is_held) = (self.step + 1, true),
            (false, true) => (self.step, self.is_over) = (self.step - 1, true),
            (false, false) => (self.step, self.is_over) = (self.step - 1, self.step - 1 < Self::DOWN_MAX),
        }
    }
}

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

/// A thread for each core that the calling one may use.
fn threads() -> usize {
    std::thread::available_parallelism().map_or(1, std::num::NonZero::get)
}

fn runtime() -> std::io::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread().worker_threads(threads()).enable_all().build()
}

/// The studio's server with one potter who presses all the time, and everybody else at the wheel with their hands in their lap.
fn studio(subscribers: u32, apart: Option<Apart>) -> Result<Cost, Fault> {
    let kept = apart.map(|apart| apart.keep_to_server()).transpose()?;
    let program = std::env::current_exe()?;
    let program = program.ancestors().nth(2).ok_or("no folder of builds")?.join("pottery-server");
    let host = Host::spawn(&program, None, &Plan { potters: 1, spectators: subscribers, ..Plan::default() })?;
    drop(kept);
    let _kept = apart.map(|apart| apart.keep_to_generator()).transpose()?;
    let target = Target::new(host.address.to_string(), host.code.clone(), 1);
    runtime()?.block_on(read(host.process(), subscribers, Arc::new(Server::Studio(target))))
}

/// Somebody who presses from now on, for the warm-up and what is measured.
fn press(target: &Target) -> Result<(), Fault> {
    let plan = Plan {
        potters: 1,
        spectators: 0,
        full_potters: 0,
        ramp_s: 0.0,
        warmup_s: WARM_UP.as_secs_f64(),
        duration_s: MEASURED.as_secs_f64(),
        ..Plan::default()
    };
    let options = Options {
        against: Against::Running { address: target.address.clone(), code: target.code.clone() },
        punctuality: Punctuality::default(),
        thresholds: Vec::new(),
        aborts: false,
        threads: 1,
        is_told: false,
        stop: Stop::caught()?,
    };
    let sends = run(plan, &options)?.sends;
    if sends == 0 { Err("nobody pressed".into()) } else { Ok(()) }
}

/// What quinn puts round a datagram is not its sender's.
const ROUND_BYTES: f64 = 29.0;

/// The bare server in a process of its own, and readers here.
fn plain(subscribers: u32, bytes: f64, apart: Option<Apart>) -> Result<Cost, Fault> {
    let kept = apart.map(|apart| apart.keep_to_server()).transpose()?;
    let mut child = Command::new(std::env::current_exe()?)
        .env(BARE, ((bytes - ROUND_BYTES) as usize).max(STAMP_BYTES).to_string())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()?;
    drop(kept);
    let _kept = apart.map(|apart| apart.keep_to_generator()).transpose()?;
    let measured = (|| {
        let mut line = String::new();
        BufReader::new(child.stdout.take().ok_or("no output")?).read_line(&mut line)?;
        let address: SocketAddr = line.trim().parse()?;
        runtime()?.block_on(read(child.id(), subscribers, Arc::new(Server::Bare(address))))
    })();
    child.kill()?;
    child.wait()?;
    measured
}

/// Which server the readers come to.
enum Server {
    Studio(Target),
    Bare(SocketAddr),
}

impl Server {
    /// Comes in; the streams, where there are any, are open as long as somebody holds them.
    async fn come(&self, endpoint: &quinn::Endpoint) -> Result<(quinn::Connection, Option<Streams>), Fault> {
        match self {
            Self::Studio(target) => {
                let greeting = Client::greeting(target.code.room(), target.wheel, true);
                let (joined, ()) = join(endpoint, target, &greeting, |_, _| Ok(())).await?;
                Ok((quinn::Connection::clone(&joined.connection), Some(joined.streams)))
            }
            Self::Bare(address) => {
                let code: JoinCode = "K7QM-3XPD".parse()?;
                let to = SocketAddr::new(Ipv4Addr::LOCALHOST.to_ipv6_mapped().into(), address.port());
                Ok((endpoint.connect_with(client_config(&code)?, to, "pottery-studio")?.await?, None))
            }
        }
    }

    /// Of when a datagram is, µs by the server's own clock; nothing where it brings nothing: a room in which nobody moves takes its time.
    fn stamp_us(&self, datagram: &[u8]) -> Option<i64> {
        match self {
            Self::Studio(_) => {
                let Body { tick, fragments, .. } = decode::<DATAGRAM_MEMORY_MAX, Pulse>(datagram).ok()?.body;
                (!fragments.is_empty()).then_some(tick as i64 * 1000)
            }
            Self::Bare(_) => Some(i64::from_le_bytes(*datagram.first_chunk()?) / 1000),
        }
    }
}

/// What the readers counted.
struct Heard {
    counts: AtomicBool,
    since: Instant,
    /// Smallest difference between when something came and its stamp, and shortest way and back, µs.
    earliest_us: AtomicI64,
    round_trip_us: AtomicI64,
    /// Datagrams, their bytes and how old they were.
    counted: Mutex<(u64, u64, Histogram<u64>)>,
}

impl Heard {
    /// How old something is, µs: over the youngest that came to anybody, and half of the shortest way and back.
    fn age_us(&self, stamp_us: i64) -> u64 {
        let difference = self.since.elapsed().as_micros() as i64 - stamp_us;
        let earliest = self.earliest_us.fetch_min(difference, Ordering::Relaxed).min(difference);
        (difference - earliest + self.round_trip_us.load(Ordering::Relaxed) / 2) as u64
    }
}

/// Readers who do nothing but take in what comes, the same for both servers.
async fn read(process: u32, subscribers: u32, server: Arc<Server>) -> Result<Cost, Fault> {
    let heard = Arc::new(Heard {
        counts: AtomicBool::new(false),
        since: Instant::now(),
        earliest_us: AtomicI64::new(i64::MAX),
        round_trip_us: AtomicI64::new(i64::MAX),
        counted: Mutex::new((0, 0, Histogram::new_with_max(60_000_000, 3)?)),
    });
    let (mut endpoints, mut connections, mut streams, mut readers) =
        (Vec::new(), Vec::new(), Vec::new(), JoinSet::new());
    for number in 0..subscribers {
        if number % 16 == 0 {
            endpoints.push(endpoint()?);
        }
        let (connection, kept) = server.come(endpoints.last().ok_or("no socket")?).await?;
        heard.round_trip_us.fetch_min(connection.rtt().as_micros() as i64, Ordering::Relaxed);
        streams.extend(kept);
        connections.push(connection.clone());
        readers.spawn(hear(connection, Arc::clone(&server), Arc::clone(&heard)));
    }
    let pressing = match &*server {
        Server::Studio(target) => {
            let target = target.clone();
            Some(tokio::task::spawn_blocking(move || press(&target)))
        }
        Server::Bare(_) => None,
    };
    tokio::time::sleep(WARM_UP).await;
    let processor_s = || -> Result<(f64, f64), Fault> {
        let [server, own] = [process, std::process::id()].map(|process| usage(process).map(|usage| usage.cpu_s));
        Ok((server.ok_or("no processor times")?, own.ok_or("no processor times")?))
    };
    let (before, begun) = (processor_s()?, Instant::now());
    heard.counts.store(true, Ordering::Relaxed);
    tokio::time::sleep(MEASURED).await;
    heard.counts.store(false, Ordering::Relaxed);
    let (after, passed_s) = (processor_s()?, begun.elapsed().as_secs_f64());
    if let Some(pressing) = pressing {
        pressing.await??;
    }
    for connection in connections {
        connection.close(0_u32.into(), b"");
    }
    readers.join_all().await;
    let (datagrams, bytes, age_us) = &*heard.counted.lock().unwrap_or_else(PoisonError::into_inner);
    Ok(Cost {
        cpu_percent: 100.0 * (after.0 - before.0) / passed_s,
        datagrams_per_s: *datagrams as f64 / passed_s,
        bytes: *bytes as f64 / *datagrams as f64 + ROUND_BYTES,
        age_ms: age_us.value_at_quantile(0.99) as f64 * 1e-3,
        readers_percent: 100.0 * (after.1 - before.1) / passed_s,
    })
}

/// Takes in what comes to one connection, until it ends.
async fn hear(connection: quinn::Connection, server: Arc<Server>, heard: Arc<Heard>) {
    while let Ok(datagram) = connection.read_datagram().await {
        let age_us = server.stamp_us(&datagram).map(|stamp_us| heard.age_us(stamp_us));
        if heard.counts.load(Ordering::Relaxed) {
            let (datagrams, bytes, ages_us) = &mut *heard.counted.lock().unwrap_or_else(PoisonError::into_inner);
            (*datagrams, *bytes) = (*datagrams + 1, *bytes + datagram.len() as u64);
            age_us.into_iter().for_each(|age_us| ages_us.saturating_record(age_us));
        }
    }
}

/// The bare server with so many bytes a datagram; never ends.
async fn serve(bytes: usize) -> Result<(), Fault> {
    let endpoint = pottery_server::endpoint(bind(SocketAddr::from(([127, 0, 0, 1], 0)))?, Certificate::fresh()?)?;
    println!("{}", endpoint.local_addr()?);
    bare::serve(endpoint, bytes, &AtomicU64::new(0)).await;
    Ok(())
}

/// Bytes of a datagram, calls that are timed, and addresses that are sent to, through the system alone.
const RAW_BYTES: usize = 300;
const RAW_CALLS: usize = 40_000;
const RAW_ADDRESSES: usize = 64;

/// Who sends, and who is sent to and does not read.
fn sockets() -> std::io::Result<(UdpSocket, Vec<UdpSocket>, Vec<SocketAddr>)> {
    let receivers = (0..RAW_ADDRESSES).map(|_| UdpSocket::bind("127.0.0.1:0")).collect::<Result<Vec<_>, _>>()?;
    let destinations = receivers.iter().map(UdpSocket::local_addr).collect::<Result<_, _>>()?;
    Ok((UdpSocket::bind("127.0.0.1:0")?, receivers, destinations))
}

/// Time of a datagram through the system alone, µs, with so many in a call.
fn raw(segments: usize) -> std::io::Result<f64> {
    let (sender, _receivers, destinations) = sockets()?;
    let state = quinn_udp::UdpSocketState::new((&sender).into())?;
    let segments = segments.min(state.max_gso_segments());
    let contents = vec![7; RAW_BYTES * segments];
    let begun = Instant::now();
    for call in 0..RAW_CALLS {
        let transmit = quinn_udp::Transmit {
            destination: destinations[call % RAW_ADDRESSES],
            ecn: None,
            contents: &contents,
            segment_size: (segments > 1).then_some(RAW_BYTES),
            src_ip: None,
        };
        state.send((&sender).into(), &transmit)?;
    }
    Ok(begun.elapsed().as_secs_f64() * 1e6 / (RAW_CALLS * segments) as f64)
}

/// The same with each datagram of a call to another address: what one call for many subscribers could save.
#[cfg(target_os = "linux")]
fn raw_to_many(messages: usize) -> std::io::Result<f64> {
    use rustix::net::addr::SocketAddrArg as _;
    use rustix::net::{MMsgHdr, SendAncillaryBuffer, SendFlags, sendmmsg};
    let (sender, _receivers, destinations) = sockets()?;
    let contents = [7; RAW_BYTES];
    let parts = [std::io::IoSlice::new(&contents)];
    let addresses: Vec<_> = destinations.iter().map(|destination| destination.as_any()).collect();
    let mut controls: Vec<_> = addresses.iter().map(|_| SendAncillaryBuffer::default()).collect();
    let mut headers: Vec<_> = addresses
        .iter()
        .zip(&mut controls)
        .map(|(address, control)| MMsgHdr::new_with_addr(address, &parts, control))
        .collect();
    let (begun, mut sent) = (Instant::now(), 0);
    for call in 0..RAW_CALLS {
        let first = call * messages % RAW_ADDRESSES;
        sent += sendmmsg(&sender, &mut headers[first..first + messages], SendFlags::empty())?;
    }
    Ok(begun.elapsed().as_secs_f64() * 1e6 / sent as f64)
}
