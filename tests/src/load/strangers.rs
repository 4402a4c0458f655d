//! Strangers who try codes: from one address, with a wrong code each time, so often a second.
//!
//! Owns a thread, sockets and their count; what the class meanwhile gets is counted by its people.
//! Invariant: a knock is due by the clock alone; strangers who fall behind are fewer, and the count says so.

use std::net::{IpAddr, Ipv4Addr, SocketAddr};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::JoinHandle;
use std::time::Duration;

use pottery_client::{JoinError, Target, join};
use pottery_shared::protocol::JoinCode;
use pottery_shared::session::Client;
use serde::{Deserialize, Serialize};
use tokio::task::JoinSet;
use tokio::time::Instant;

use super::figures::Quantiles;

/// Their address: this machine's too, and not the one that its people come from.
const ADDRESS: Ipv4Addr = Ipv4Addr::new(127, 0, 0, 2);
/// How often some of them knock.
const EVERY: Duration = Duration::from_millis(5);
/// How long one waits for an answer, and how many wait at one time.
const PATIENCE: Duration = Duration::from_millis(500);
const WAITING_MAX: usize = 1024;
/// The code that they try: one room in 2⁴⁰ has it.
const WRONG: [u8; 5] = [0; 5];

/// What strangers did and what the class noticed of it.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct StrangerFigures {
    /// Knocks with a wrong code, a second.
    pub knocks_per_s: f64,
    /// Those of them, a second, that the server answered; it lets most wait, which is not seen from outside.
    #[serde(default)]
    pub answered_per_s: f64,
    /// Age of the class's clay while nobody knocked, ms, and while they did.
    pub quiet_age_ms: Quantiles,
    /// See `quiet_age_ms`.
    pub besieged_age_ms: Quantiles,
}

impl StrangerFigures {
    /// The 99th percentile of the clay's age while they knocked, over that in quiet.
    #[must_use]
    pub fn age_ratio(&self) -> f64 {
        self.besieged_age_ms.p99 / self.quiet_age_ms.p99.max(f64::MIN_POSITIVE)
    }
}

/// Strangers at work; they leave with the value.
#[derive(Debug)]
pub struct Strangers {
    knocks: Arc<AtomicU64>,
    answered: Arc<AtomicU64>,
    leaves: Arc<AtomicBool>,
    thread: Option<JoinHandle<()>>,
}

impl Strangers {
    /// So many knocks a second at a server on this machine, from a thread of their own.
    ///
    /// # Errors
    /// When the system gives no thread.
    pub fn come(address: String, per_s: u32) -> std::io::Result<Self> {
        let [knocks, answered] = [(); 2].map(|()| Arc::new(AtomicU64::new(0)));
        let leaves = Arc::new(AtomicBool::new(false));
        let (counted, told) = ((Arc::clone(&knocks), Arc::clone(&answered)), Arc::clone(&leaves));
        let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
        let thread = std::thread::Builder::new().name("strangers".into()).spawn(move || {
            runtime.block_on(knock(&address, per_s, (&counted.0, &counted.1), &told));
            runtime.shutdown_background();
        })?;
        Ok(Self { knocks, answered, leaves, thread: Some(thread) })
    }

    /// Knocks so far.
    #[must_use]
    pub fn knocks(&self) -> u64 {
        self.knocks.load(Ordering::Relaxed)
    }

    /// Those of them that the server answered.
    #[must_use]
    pub fn answered(&self) -> u64 {
        self.answered.load(Ordering::Relaxed)
    }
}

impl Drop for Strangers {
    fn drop(&mut self) {
        self.leaves.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take() {
            // one that panicked has said so
            drop(thread.join());
        }
    }
}

async fn knock(address: &str, per_s: u32, (knocks, answered): (&AtomicU64, &Arc<AtomicU64>), leaves: &AtomicBool) {
    let from = SocketAddr::new(IpAddr::V4(ADDRESS), 0);
    let endpoint = quinn::Endpoint::client(from).or_else(|_| quinn::Endpoint::client(([127, 0, 0, 1], 0).into()));
    let Ok(endpoint) = endpoint else { return };
    let Ok(wrong) = JoinCode::room_of(WRONG).parse::<JoinCode>() else { return };
    let target = Arc::new(Target::new(address.to_owned(), wrong, 1));
    let begun = Instant::now();
    let mut waiting = JoinSet::new();
    let mut every = tokio::time::interval(EVERY);
    while !leaves.load(Ordering::Relaxed) {
        every.tick().await;
        while waiting.try_join_next().is_some() {}
        let due = (begun.elapsed().as_secs_f64() * f64::from(per_s)) as u64;
        while knocks.load(Ordering::Relaxed) < due && waiting.len() < WAITING_MAX {
            let (endpoint, target, answered) = (endpoint.clone(), Arc::clone(&target), Arc::clone(answered));
            waiting.spawn(async move {
                let greeting = Client::greeting(target.code.room(), 1, true);
                let asked = join(&endpoint, &target, &greeting, |_, _| Ok(()));
                // whatever it is told; what its code is good for is known
                if let Ok(Ok(_) | Err(JoinError::Session(_))) = tokio::time::timeout(PATIENCE, asked).await {
                    answered.fetch_add(1, Ordering::Relaxed);
                }
            });
            knocks.fetch_add(1, Ordering::Relaxed);
        }
    }
    waiting.abort_all();
}
