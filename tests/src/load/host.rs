//! The server under load: its process when it is ours, and what processes have used.
//!
//! Owns the child and its lines; reads `/proc` where there is one.
//! Invariant: a server that was started here ends with its handle.

use std::io::{BufRead, BufReader};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, sync_channel};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use hdrhistogram::Histogram;
use pottery_shared::protocol::JoinCode;
use serde::Deserialize;

use super::plan::Plan;

/// Why there is no server.
#[derive(Debug, thiserror::Error)]
pub enum HostError {
    /// It does not start.
    #[error(
        "the server {program} cannot be started ({source}): cargo build --release -p pottery-server builds it, and --program names another"
    )]
    Start {
        /// Which program.
        program: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// It ended before it listened.
    #[error("the server {program} ended before it listened: {said}")]
    Silent {
        /// Which program.
        program: PathBuf,
        /// What it said.
        said: String,
    },
}

/// One line of a server's figures; see `pottery_server::Figures::to_json_line`.
#[derive(Clone, Debug, Default, Deserialize)]
pub struct Told {
    /// Ticks done.
    pub ticks: u64,
    /// Times the tick fell behind.
    pub late: u64,
    /// Datagrams handed to connections.
    pub datagrams: u64,
    /// Datagrams that a connection could not take at once.
    pub dropped_datagrams: u64,
    /// Requests for keyframes.
    pub resyncs: u64,
    /// Samples refused.
    pub refused_samples: u64,
    /// Datagrams that were not heard, since their address sent too much.
    #[serde(default)]
    pub unheard: u64,
    /// `[µs, wake-ups]`.
    pub wake_us: Vec<(u64, u64)>,
}

impl Told {
    /// How long wake-ups took after `before`, µs.
    ///
    /// # Panics
    /// Never: the bounds are valid.
    #[must_use]
    pub fn wakes_since(&self, before: &Self) -> Histogram<u64> {
        let mut wakes = Histogram::new_with_bounds(1, 60_000_000, 3).expect("these bounds are valid");
        let mut earlier = before.wake_us.iter().peekable();
        for &(us, count) in &self.wake_us {
            while earlier.next_if(|(at, _)| *at < us).is_some() {}
            let known = earlier.next_if(|(at, _)| *at == us).map_or(0, |(_, count)| *count);
            wakes.saturating_record_n(us.max(1), count.saturating_sub(known));
        }
        wakes
    }
}

/// A server's process.
#[derive(Debug)]
pub struct Host {
    child: Child,
    /// Where it listens.
    pub address: SocketAddr,
    /// What lets people in.
    pub code: JoinCode,
    told: Arc<Mutex<Option<Told>>>,
}

impl Host {
    /// Starts a server for a plan on this machine's loopback; where strangers come, one that counts who knocks from this machine as
    /// it would others, and lets all of its people in at once. It has so many `threads`, or one a core.
    ///
    /// # Errors
    /// [`HostError`].
    pub fn spawn(program: &Path, threads: Option<u8>, plan: &Plan) -> Result<Self, HostError> {
        let people = plan.people().max(1);
        let mut command = Command::new(program);
        command.args(["--listen", "127.0.0.1:0", "--figures", "1"]).args([
            "--wheels",
            &plan.wheels.to_string(),
            "--people",
            &people.to_string(),
        ]);
        if let Some(threads) = threads {
            command.env("TOKIO_WORKER_THREADS", threads.to_string());
        }
        // a file, which is read before the server says where it is
        let strict = std::env::temp_dir().join(format!("pottery-load-test-{}.toml", std::process::id()));
        if plan.strangers_per_s > 0 {
            let arrivals = format!("[arrivals]\nexempts_loopback = false\nburst = {}\n", people.max(300));
            let start = |source| HostError::Start { program: program.to_owned(), source };
            std::fs::write(&strict, arrivals).map_err(start)?;
            command.arg("--config").arg(&strict);
        }
        let spawned = Self::started(program, &mut command);
        if plan.strangers_per_s > 0 {
            // nobody reads it any more
            drop(std::fs::remove_file(&strict));
        }
        spawned
    }

    fn started(program: &Path, command: &mut Command) -> Result<Self, HostError> {
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::inherit())
            .spawn()
            .map_err(|source| HostError::Start { program: program.to_owned(), source })?;
        let (said, lines) = sync_channel(16);
        let told = Arc::new(Mutex::new(None));
        if let Some(output) = child.stdout.take() {
            let told = Arc::clone(&told);
            std::thread::spawn(move || {
                for line in BufReader::new(output).lines().map_while(Result::ok) {
                    match serde_json::from_str::<Told>(&line) {
                        Ok(figures) => *told.lock().unwrap_or_else(PoisonError::into_inner) = Some(figures),
                        // nobody listens any more once it has begun
                        Err(_) => drop(said.try_send(line)),
                    }
                }
            });
        }
        match greeted(&lines) {
            Ok((address, code)) => Ok(Self { child, address, code, told }),
            Err(said) => {
                end(&mut child);
                Err(HostError::Silent { program: program.to_owned(), said })
            }
        }
    }

    /// Number of its process.
    #[must_use]
    pub fn process(&self) -> u32 {
        self.child.id()
    }

    /// The newest figures it has told.
    #[must_use]
    pub fn told(&self) -> Option<Told> {
        self.told.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl Drop for Host {
    fn drop(&mut self) {
        end(&mut self.child);
    }
}

fn end(child: &mut Child) {
    // it may have ended by itself
    drop(child.kill());
    drop(child.wait());
}

fn greeted(lines: &Receiver<String>) -> Result<(SocketAddr, JoinCode), String> {
    let mut said = Vec::new();
    let (mut address, mut code) = (None, None);
    while let Ok(line) = lines.recv_timeout(Duration::from_secs(20)) {
        address = address.or(line.strip_prefix("listening on ").and_then(|rest| rest.trim().parse().ok()));
        code = code.or(line.strip_prefix("join code").and_then(|rest| rest.trim().parse().ok()));
        if let (Some(address), Some(code)) = (address, &code) {
            return Ok((address, JoinCode::clone(code)));
        }
        said.push(line);
    }
    Err(if said.is_empty() { "it did not say where it listens".to_owned() } else { said.join("; ") })
}

/// The server beside this program.
///
/// # Errors
/// What the system says when it does not know where this program is.
pub fn server_program() -> std::io::Result<PathBuf> {
    Ok(std::env::current_exe()?.with_file_name(format!("pottery-server{}", std::env::consts::EXE_SUFFIX)))
}

/// What a process has used.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Usage {
    /// Time on processors, s.
    pub cpu_s: f64,
    /// Memory in use, MB.
    pub memory_mb: f64,
}

/// What a process has used; `None` where the system does not tell.
#[must_use]
pub fn usage(process: u32) -> Option<Usage> {
    let stat = std::fs::read_to_string(format!("/proc/{process}/stat")).ok()?;
    // the name in brackets may hold anything
    let fields: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
    let ticks: f64 = fields.get(11)?.parse::<f64>().ok()? + fields.get(12)?.parse::<f64>().ok()?;
    let status = std::fs::read_to_string(format!("/proc/{process}/status")).ok()?;
    let resident = status.lines().find_map(|line| line.strip_prefix("VmRSS:"))?;
    let kilobytes: f64 = resident.split_whitespace().next()?.parse().ok()?;
    // Linux counts in hundredths of a second for whoever reads it, on every processor of today
    Some(Usage { cpu_s: ticks / 100.0, memory_mb: kilobytes / 1024.0 })
}

/// What a machine says of itself.
#[must_use]
pub fn machine() -> (String, usize, String) {
    let info = std::fs::read_to_string("/proc/cpuinfo").unwrap_or_default();
    let model = info.lines().find_map(|line| line.strip_prefix("model name")).unwrap_or(": unknown");
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    let load = load.split_whitespace().take(3).collect::<Vec<_>>().join(" ");
    (model.trim_start_matches(['\t', ' ', ':']).to_owned(), cores, load)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_server_counts_later_leaves_out_what_it_counted_before() {
        let before = Told { wake_us: vec![(10, 3), (30, 1)], ..Told::default() };
        let after = Told { wake_us: vec![(10, 5), (20, 2), (30, 1), (40, 1)], ..Told::default() };
        let wakes = after.wakes_since(&before);
        assert_eq!(wakes.len(), 5);
        assert_eq!([wakes.count_at(10), wakes.count_at(20), wakes.count_at(30), wakes.count_at(40)], [2, 2, 0, 1]);
    }
}
