//! How often a server asks for memory for each datagram that it sends, beside a bare quinn program that sends the same datagrams.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench allocations -- [subscribers]`. Both servers are in this
//! process, one after the other, on threads of their own; what those ask for is counted, whatever the subscribers and the potter do.

use std::net::SocketAddr;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;

use pottery_client::{Target, client_config, endpoint, join};
use pottery_server::{Certificate, Server, ServerConfig, bind};
use pottery_shared::protocol::JoinCode;
use pottery_shared::session::Client;
use pottery_tests::allocations::{Counting, asked_by_marked, mark_this_thread};
use pottery_tests::load::bare::{STAMP_BYTES, serve};
use pottery_tests::load::plan::Plan;
use pottery_tests::load::run::{Against, Options, run};
use pottery_tests::load::schedule::Punctuality;
use pottery_tests::load::stop::Stop;
use tokio::runtime::{Builder, Runtime};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

const WARM_UP: Duration = Duration::from_secs(3);
const MEASURED: Duration = Duration::from_secs(6);
const TURNS: usize = 3;

type Fault = Box<dyn std::error::Error + Send + Sync>;

/// What was counted of a server so far.
#[derive(Clone, Copy, Debug)]
struct Count {
    datagrams: u64,
    datagram_bytes: u64,
    allocations: u64,
    allocated_bytes: u64,
}

impl Count {
    fn now(datagrams: u64, datagram_bytes: u64) -> Self {
        let (allocations, allocated_bytes) = asked_by_marked();
        Self { datagrams, datagram_bytes, allocations, allocated_bytes }
    }

    fn print_since(&self, before: &Self, name: &str) {
        let datagrams = (self.datagrams - before.datagrams) as f64;
        println!(
            "{name:<7}{datagrams:>7} datagrams of {:>4.0} B: {:>5.2} allocations and {:>5.0} bytes for each",
            (self.datagram_bytes - before.datagram_bytes) as f64 / datagrams,
            (self.allocations - before.allocations) as f64 / datagrams,
            (self.allocated_bytes - before.allocated_bytes) as f64 / datagrams,
        );
    }
}

fn main() -> Result<(), Fault> {
    let subscribers = std::env::args().find_map(|argument| argument.parse().ok()).unwrap_or(100);
    for _ in 0..TURNS {
        let bytes = studio(subscribers)?;
        bare(subscribers, bytes.max(STAMP_BYTES))?;
    }
    Ok(())
}

/// Threads of which it is counted what they ask for, or not.
fn threads(is_counted: bool) -> std::io::Result<Runtime> {
    let begins = move || {
        if is_counted {
            mark_this_thread();
        }
    };
    Builder::new_multi_thread().worker_threads(2).on_thread_start(begins).enable_all().build()
}

/// The studio with one potter who presses all the time; how long a datagram is.
fn studio(subscribers: usize) -> Result<usize, Fault> {
    let (counted, others) = (threads(true)?, threads(false)?);
    let config = ServerConfig {
        listen: SocketAddr::from(([127, 0, 0, 1], 0)),
        is_announced: false,
        people_max: subscribers as u16 + 1,
        ..ServerConfig::default()
    };
    let server = counted.block_on(async { Server::start(config) })?;
    let target = Target::new(server.address().to_string(), server.code().clone(), 1);
    let people = others.block_on(async {
        let own = endpoint()?;
        let mut people = Vec::new();
        for _ in 0..subscribers {
            let greeting = Client::greeting(target.code.room(), target.wheel, true);
            let (joined, ()) = join(&own, &target, &greeting, |_, _| Ok(())).await?;
            others.spawn(hear(quinn::Connection::clone(&joined.connection)));
            people.push(joined);
        }
        Ok::<_, Fault>(people)
    })?;
    let pressing = others.spawn_blocking(move || press(&target).map_err(|error| error.to_string()));
    let count = async || -> Result<Count, Fault> {
        let figures = server.figures().await?;
        Ok(Count::now(figures.datagrams, figures.datagram_bytes))
    };
    let (before, after) = others.block_on(async {
        tokio::time::sleep(WARM_UP).await;
        let before = count().await?;
        tokio::time::sleep(MEASURED).await;
        let after = count().await?;
        pressing.await??;
        Ok::<_, Fault>((before, after))
    })?;
    after.print_since(&before, "studio");
    drop(people);
    counted.block_on(server.stop());
    Ok(((after.datagram_bytes - before.datagram_bytes) / (after.datagrams - before.datagrams)) as usize)
}

/// Somebody who presses for the warm-up and what is measured.
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

/// The bare server, with datagrams of so many bytes.
fn bare(subscribers: usize, bytes: usize) -> Result<(), Fault> {
    let (counted, others) = (threads(true)?, threads(false)?);
    let sent = Arc::new(AtomicU64::new(0));
    let address = counted.block_on(async {
        let endpoint = pottery_server::endpoint(bind(SocketAddr::from(([127, 0, 0, 1], 0)))?, Certificate::fresh()?)?;
        let (address, sent) = (endpoint.local_addr()?, Arc::clone(&sent));
        tokio::spawn(async move { serve(endpoint, bytes, &sent).await });
        Ok::<_, Fault>(address)
    })?;
    let code: JoinCode = "K7QM-3XPD".parse()?;
    let _people = others.block_on(async {
        let own = quinn::Endpoint::client(SocketAddr::from(([127, 0, 0, 1], 0)))?;
        let mut people = Vec::new();
        for _ in 0..subscribers {
            let connection = own.connect_with(client_config(&code)?, address, "pottery-studio")?.await?;
            others.spawn(hear(connection.clone()));
            people.push(connection);
        }
        Ok::<_, Fault>(people)
    })?;
    let count = || {
        let datagrams = sent.load(Ordering::Relaxed);
        Count::now(datagrams, datagrams * bytes as u64)
    };
    std::thread::sleep(WARM_UP);
    let before = count();
    std::thread::sleep(MEASURED);
    count().print_since(&before, "bare");
    Ok(())
}

/// Takes in what comes to one connection, until it ends.
async fn hear(connection: quinn::Connection) {
    while connection.read_datagram().await.is_ok() {}
}
