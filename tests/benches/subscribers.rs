//! What a subscriber costs the server, beside a bare quinn program that sends the same datagrams and knows no pottery.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench subscribers -- [subscribers]`, after
//! `cargo build --release -p pottery-server`. Ours and the bare one take turns, three times, each a process of its own under
//! the same readers; below them the system's own limit: one datagram a call, and sixteen a call, to one address (GSO) and to sixteen (`sendmmsg`).
//! With `-- limit [subscribers]` each has a core of its own and more and more subscribers, until what they get is older than 20 ms (p99).

use std::io::{BufRead, BufReader};
use std::net::{SocketAddr, UdpSocket};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use bytes::{Buf as _, BufMut as _, Bytes, BytesMut};
use hdrhistogram::Histogram;
use pottery_client::{client_config, endpoint};
use pottery_server::{Certificate, bind};
use pottery_shared::protocol::JoinCode;
use pottery_tests::load::cores::Apart;
use pottery_tests::load::host::usage;
use pottery_tests::load::plan::{Plan, Sight};
use pottery_tests::load::run::{Against, Options, run};
use pottery_tests::load::schedule::Punctuality;

/// Says to this program that it is the bare server, and with how many bytes a datagram.
const BARE: &str = "POTTERY_BARE_BYTES";
const SNAPSHOT: Duration = Duration::from_nanos(16_666_667);
const MEASURED: Duration = Duration::from_secs(6);
const TURNS: usize = 3;

type Fault = Box<dyn std::error::Error>;

/// What a server cost.
#[derive(Clone, Copy, Debug)]
struct Cost {
    /// % of a core.
    cpu_percent: f64,
    /// Datagrams a second that arrived.
    datagrams_per_s: f64,
    /// UDP payload of one.
    bytes: f64,
    /// From the tick that it is of to its arrival, p99.
    age_ms: f64,
    /// Processor time of those who read, % of a core.
    readers_percent: f64,
}

impl Cost {
    fn us_a_datagram(&self) -> f64 {
        self.cpu_percent * 1e4 / self.datagrams_per_s
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
const MORE: f64 = 1.12;
const OLD_MS: f64 = 20.0;

/// How many subscribers each holds on a core of its own, by turns, so that an hour in which the machine is slow is both's.
fn limits(first: u32) -> Result<(), Fault> {
    let apart = Apart::new(1)?;
    let (mut held, mut next, mut bytes) = ([0; 2], first, None);
    let mut climb = [true; 2];
    while climb.contains(&true) {
        if climb[0] {
            climb[0] = holds("studio", next, || {
                let cost = studio(next, Some(apart))?;
                bytes.get_or_insert(cost.bytes);
                Ok(cost)
            })?;
        }
        let bytes = bytes.ok_or("the studio comes first")?;
        climb[1] = climb[1] && holds("bare", next, || plain(next, bytes, Some(apart)))?;
        for (held, _) in held.iter_mut().zip(climb).filter(|(_, climbs)| *climbs) {
            *held = next;
        }
        next = (f64::from(next) * MORE) as u32;
    }
    let [ours, bare] = held;
    println!(
        "within {OLD_MS} ms: studio {ours}, bare quinn {bare}: studio/bare = {:.2}",
        f64::from(ours) / f64::from(bare)
    );
    Ok(())
}

/// Whether so many are served in time in one run of two.
fn holds(name: &str, subscribers: u32, mut cost: impl FnMut() -> Result<Cost, Fault>) -> Result<bool, Fault> {
    for _ in 0..2 {
        let cost = cost()?;
        cost.print(name, subscribers);
        if cost.age_ms <= OLD_MS && cost.datagrams_per_s * SNAPSHOT.as_secs_f64() > 0.98 * f64::from(subscribers) {
            return Ok(true);
        }
    }
    Ok(false)
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

/// The studio's server with one potter, and everybody else at the wheel with their hands in their lap.
fn studio(subscribers: u32, apart: Option<Apart>) -> Result<Cost, Fault> {
    let plan = Plan {
        potters: 1,
        spectators: subscribers,
        sight: Sight::Full,
        full_potters: 0,
        ramp_s: 6.0,
        warmup_s: 2.0,
        duration_s: MEASURED.as_secs_f64(),
        ..Plan::default()
    };
    let program = std::env::current_exe()?
        .ancestors()
        .nth(2)
        .map(|folder| folder.join("pottery-server"))
        .ok_or("no folder of builds")?;
    let options = Options {
        against: Against::Spawned { program, threads: None, apart: apart.map(Box::new) },
        punctuality: Punctuality::default(),
        thresholds: Vec::new(),
        aborts: false,
        threads: threads() - apart.map_or(0, |apart| apart.servers()),
        is_told: false,
    };
    let result = run(plan, &options)?;
    Ok(Cost {
        cpu_percent: result.server_cpu_percent.ok_or("the system does not tell processor times")?,
        datagrams_per_s: result.datagrams as f64 / result.measured_s,
        bytes: result.down_bytes as f64 / result.datagrams as f64,
        age_ms: result.delta_age_ms.p99,
        readers_percent: result.generator_cpu_percent.ok_or("the system does not tell processor times")?,
    })
}

/// What quinn puts round a datagram is not its sender's.
const ROUND_BYTES: f64 = 29.0;
/// When it was due, ns since 1970: the first of a bare datagram's bytes.
const STAMP_BYTES: usize = 8;

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
        runtime()?.block_on(read(child.id(), address, subscribers))
    })();
    child.kill()?;
    child.wait()?;
    measured
}

fn since_1970() -> Duration {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default()
}

/// What the readers of one connection counted.
struct Heard {
    datagrams: u64,
    bytes: u64,
    age_us: Histogram<u64>,
}

async fn read(server: u32, address: SocketAddr, subscribers: u32) -> Result<Cost, Fault> {
    let code: JoinCode = "K7QM-3XPD".parse()?;
    let to = SocketAddr::new(std::net::Ipv4Addr::LOCALHOST.to_ipv6_mapped().into(), address.port());
    let counts = Arc::new(AtomicBool::new(false));
    let (mut endpoints, mut readers) = (Vec::new(), Vec::new());
    for number in 0..subscribers {
        if number % 16 == 0 {
            endpoints.push(endpoint()?);
        }
        let own = endpoints.last().ok_or("no socket")?;
        let connection = own.connect_with(client_config(&code)?, to, "pottery-studio")?.await?;
        readers.push((connection.clone(), tokio::spawn(hear(connection, Arc::clone(&counts)))));
    }
    tokio::time::sleep(Duration::from_secs(1)).await;
    let processor_s = || -> Result<(f64, f64), Fault> {
        let [server, own] = [server, std::process::id()].map(|process| usage(process).map(|usage| usage.cpu_s));
        Ok((server.ok_or("no processor times")?, own.ok_or("no processor times")?))
    };
    let (before, begun) = (processor_s()?, Instant::now());
    counts.store(true, Ordering::Relaxed);
    tokio::time::sleep(MEASURED).await;
    counts.store(false, Ordering::Relaxed);
    let (after, passed_s) = (processor_s()?, begun.elapsed().as_secs_f64());
    let mut all = Heard { datagrams: 0, bytes: 0, age_us: Histogram::new(3)? };
    for (connection, reader) in readers {
        connection.close(0_u32.into(), b"");
        let heard = reader.await??;
        (all.datagrams, all.bytes) = (all.datagrams + heard.datagrams, all.bytes + heard.bytes);
        all.age_us.add(&heard.age_us)?;
    }
    Ok(Cost {
        cpu_percent: 100.0 * (after.0 - before.0) / passed_s,
        datagrams_per_s: all.datagrams as f64 / passed_s,
        bytes: all.bytes as f64 / all.datagrams as f64 + ROUND_BYTES,
        age_ms: all.age_us.value_at_quantile(0.99) as f64 * 1e-3,
        readers_percent: 100.0 * (after.1 - before.1) / passed_s,
    })
}

/// Takes in what comes while it `counts`, until the connection ends.
async fn hear(connection: quinn::Connection, counts: Arc<AtomicBool>) -> Result<Heard, hdrhistogram::CreationError> {
    let mut heard = Heard { datagrams: 0, bytes: 0, age_us: Histogram::new_with_max(60_000_000, 3)? };
    while let Ok(mut datagram) = connection.read_datagram().await {
        if counts.load(Ordering::Relaxed) && datagram.len() >= STAMP_BYTES {
            (heard.datagrams, heard.bytes) = (heard.datagrams + 1, heard.bytes + datagram.len() as u64);
            let age = since_1970().saturating_sub(Duration::from_nanos(datagram.get_u64_le()));
            heard.age_us.saturating_record(age.as_micros() as u64);
        }
    }
    Ok(heard)
}

/// Sends everybody the same bytes sixty times a second, with the studio's transport.
async fn serve(bytes: usize) -> Result<(), Fault> {
    let endpoint = pottery_server::endpoint(bind(SocketAddr::from(([127, 0, 0, 1], 0)))?, Certificate::fresh()?)?;
    println!("{}", endpoint.local_addr()?);
    let (came, mut coming) = tokio::sync::mpsc::channel(1024);
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
    loop {
        tokio::select! {
            due = tick.tick() => {
                let payload = stamped(since_1970().saturating_sub(due.elapsed()), bytes);
                subscribers.retain(|subscriber| subscriber.send_datagram(payload.clone()).is_ok());
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
