//! What a subscriber costs the server, beside a bare quinn program that sends the same datagrams and knows no pottery.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench subscribers -- [subscribers]`, after
//! `cargo build --release -p pottery-server`. Ours and the bare one take turns, three times, each a process of its own under
//! the same readers; below them the system's own limit: one datagram a call, and sixteen a call, to one address (GSO) and to sixteen (`sendmmsg`).

use std::io::{BufRead, BufReader};
use std::net::{SocketAddr, UdpSocket};
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use bytes::Bytes;
use pottery_client::{client_config, endpoint};
use pottery_server::{Certificate, bind};
use pottery_shared::protocol::JoinCode;
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
}

impl Cost {
    fn us_a_datagram(&self) -> f64 {
        self.cpu_percent * 1e4 / self.datagrams_per_s
    }
}

fn main() -> Result<(), Fault> {
    if let Ok(bytes) = std::env::var(BARE) {
        return runtime()?.block_on(serve(bytes.parse()?));
    }
    let subscribers = std::env::args().filter_map(|argument| argument.parse().ok()).next().unwrap_or(400);
    let (mut ours, mut bare) = (Vec::new(), Vec::new());
    for turn in 1..=TURNS {
        let one = studio(subscribers)?;
        // what quinn puts round a datagram is not its sender's
        let other = plain(subscribers, (one.bytes as usize).saturating_sub(29))?;
        for (name, cost) in [("studio", one), ("bare", other)] {
            println!(
                "turn {turn} {name:<7}{subscribers:>5} subscribers {:>8.0} datagrams/s of {:>4.0} B {:>6.1} % of a core {:>6.2} µs a datagram",
                cost.datagrams_per_s,
                cost.bytes,
                cost.cpu_percent,
                cost.us_a_datagram()
            );
        }
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

fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn runtime() -> std::io::Result<tokio::runtime::Runtime> {
    tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build()
}

/// The studio's server with one potter, and everybody else at the wheel with their hands in their lap.
fn studio(subscribers: u32) -> Result<Cost, Fault> {
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
        against: Against::Spawned { program, threads: None, apart: None },
        punctuality: Punctuality::default(),
        thresholds: Vec::new(),
        aborts: false,
        threads: 2,
        is_told: false,
    };
    let result = run(plan, &options)?;
    Ok(Cost {
        cpu_percent: result.server_cpu_percent.ok_or("the system does not tell processor times")?,
        datagrams_per_s: result.datagrams as f64 / result.measured_s,
        bytes: result.down_bytes as f64 / result.datagrams as f64,
    })
}

/// The bare server in a process of its own, and readers here.
fn plain(subscribers: u32, bytes: usize) -> Result<Cost, Fault> {
    let mut child = Command::new(std::env::current_exe()?)
        .env(BARE, bytes.to_string())
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .spawn()?;
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

async fn read(server: u32, address: SocketAddr, subscribers: u32) -> Result<Cost, Fault> {
    let (count, total) = (Arc::new(AtomicU64::new(0)), Arc::new(AtomicU64::new(0)));
    let code: JoinCode = "K7QM-3XPD".parse()?;
    let mut endpoints = Vec::new();
    let to = SocketAddr::new(std::net::Ipv4Addr::LOCALHOST.to_ipv6_mapped().into(), address.port());
    for number in 0..subscribers {
        if number % 16 == 0 {
            endpoints.push(endpoint()?);
        }
        let own = endpoints.last().ok_or("no socket")?;
        let connection = own.connect_with(client_config(&code)?, to, "pottery-studio")?.await?;
        let (count, total) = (Arc::clone(&count), Arc::clone(&total));
        tokio::spawn(async move {
            while let Ok(datagram) = connection.read_datagram().await {
                count.fetch_add(1, Ordering::Relaxed);
                total.fetch_add(datagram.len() as u64, Ordering::Relaxed);
            }
        });
    }
    tokio::time::sleep(Duration::from_secs(1)).await;
    let before =
        (usage(server).ok_or("no processor times")?, count.load(Ordering::Relaxed), total.load(Ordering::Relaxed));
    let begun = Instant::now();
    tokio::time::sleep(MEASURED).await;
    let passed_s = begun.elapsed().as_secs_f64();
    let after =
        (usage(server).ok_or("no processor times")?, count.load(Ordering::Relaxed), total.load(Ordering::Relaxed));
    let datagrams = (after.1 - before.1) as f64;
    Ok(Cost {
        cpu_percent: 100.0 * (after.0.cpu_s - before.0.cpu_s) / passed_s,
        datagrams_per_s: datagrams / passed_s,
        bytes: (after.2 - before.2) as f64 / datagrams + 29.0,
    })
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
    let payload = Bytes::from(vec![7; bytes]);
    let mut subscribers: Vec<quinn::Connection> = Vec::new();
    let mut tick = tokio::time::interval(SNAPSHOT);
    loop {
        tokio::select! {
            _ = tick.tick() => subscribers.retain(|subscriber| subscriber.send_datagram(payload.clone()).is_ok()),
            Some(subscriber) = coming.recv() => subscribers.push(subscriber),
        }
    }
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
