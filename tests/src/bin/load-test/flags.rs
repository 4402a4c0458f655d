//! The command line of `load-test`.
//!
//! Owns flags, their words and what they make of a scenario; starts nothing.
//! Invariant: a flag outranks the scenario's file, and the file the defaults.

use std::fs::OpenOptions;
use std::net::IpAddr;
use std::path::PathBuf;
use std::time::Duration;

use clap::{Args, Parser, Subcommand};
use pottery_client::Target;
use pottery_files::flags::number_from;
use pottery_files::sentence::sentence;
use pottery_server::ServerConfig;
use pottery_shared::protocol::JoinCode;
use pottery_tests::load::cores::Apart;
use pottery_tests::load::host::server_program;
use pottery_tests::load::knee::{Raises, Way};
use pottery_tests::load::law;
use pottery_tests::load::plan::{Plan, Sight};
use pottery_tests::load::run::{Against, Options};
use pottery_tests::load::schedule::Punctuality;
use pottery_tests::load::stop::Stop;
use pottery_tests::load::threshold::Threshold;

const TEACHES: &str = "\
Examples:
  load-test --spawn --potters 8 --wheels 4 --duration 20
      eight people press at four wheels of a server that is started for it
  load-test --spawn --scenario lesson --threshold 'input_delta_ms:p99<120' --html lesson.html
      a class of 24; the page shows every second
  load-test --spawn --server-cores 1 --wheels 24 --potters 24 --spectators 696
      a school on one core, and who plays it on the others
  load-test --server 127.0.0.1:4747 --code K7QM-3XPD --spectators 100
      a server that runs already
  load-test knee --spawn --potters 1 --sight full --raise spectators --from 100 --to 2000 --threshold 'delta_age_ms:p99<20'
      how many subscribers there may be
  load-test law --spawn --server-cores 1
      what a wheel, a potter and whoever looks on cost this machine
  load-test soak --spawn --scenario soak --duration 600
      whether memory grows and ticks come late

Scenarios: class-arrives, lesson, one-wheel, exhibition, join-storm, slow-readers, flapping, strangers, soak, smoke; or a TOML
or JSON file with the same entries as those in tests/data/load/.

How to read it: inputs are due every 10 ms whatever the server does, and input_delta_ms runs from the moment at which one
was due to the clay that holds it. The uncorrected figure runs from when it was sent. If the generator is late itself
(schedule_lag_ms of those who press, look_lag_ms of those who look on), the run is invalid: it says nothing of the server.
A star marks seconds that are left out of the figures.

Exit codes: 0 every threshold holds, 99 one is broken or somebody never came in, 98 the run is invalid (a knee or a law also
where it was interrupted), 97 somebody's clay is not the server's or could not be told, 2 a flag makes no sense, 1 anything
else. Of knee: 0 some load held, whatever broke beyond it, 99 none did. Of soak: 99 also where memory grew, or could not be measured.";

/// Puts a pottery server under load and says how it bears it: real QUIC, real strokes, no window and no hand's thread.
#[derive(Debug, Parser)]
#[command(name = "load-test", version, after_help = TEACHES)]
#[command(allow_negative_numbers = true, args_conflicts_with_subcommands = true)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Option<Command>,
    #[command(flatten)]
    pub(crate) run: RunFlags,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    /// Raise the load until a threshold breaks, and draw it; a run that is invalid ends it, with exit code 98
    #[command(allow_negative_numbers = true)]
    Knee(KneeFlags),
    /// Go through twelve loads, and say what each wheel, potter and looker-on costs the server
    #[command(allow_negative_numbers = true)]
    Law(LawFlags),
    /// Go on for long, and look whether the server's memory grows
    #[command(allow_negative_numbers = true)]
    Soak(SoakFlags),
}

#[derive(Clone, Debug, Args)]
pub(crate) struct RunFlags {
    /// Start a server of its own on this machine, so that its processor time and memory can be read
    #[arg(long, conflicts_with_all = ["server", "code"])]
    spawn: bool,
    /// The server's program [default: pottery-server beside this program]
    #[arg(long, value_name = "FILE", requires = "spawn", conflicts_with = "server")]
    program: Option<PathBuf>,
    /// Keep a spawned server to so many of this machine's cores and everybody else to the others, so that neither waits for the other
    #[arg(long, value_name = "COUNT", requires = "spawn", conflicts_with = "server", value_parser = number_from(1_usize, 1024))]
    server_cores: Option<usize>,
    /// Threads of the server [default: as many as it has cores]
    #[arg(long, value_name = "COUNT", requires = "spawn", conflicts_with = "server", value_parser = number_from(1_u8, 64))]
    server_threads: Option<u8>,
    /// A server that runs already
    #[arg(long, value_name = "ADDRESS", requires = "code")]
    server: Option<String>,
    /// Its join code
    #[arg(long)]
    code: Option<JoinCode>,
    /// Allow a server that is not on this machine; ask its owner first
    #[arg(long)]
    beyond_loopback: bool,
    /// A scenario by name, or a TOML or JSON file
    #[arg(long, value_name = "NAME|FILE")]
    scenario: Option<String>,
    /// Wheels of a spawned server, or those that a running one has; people are spread over them
    #[arg(long, value_parser = number_from(1, ServerConfig::WHEELS_MAX))]
    wheels: Option<u16>,
    /// Wheels that people sit at, when not all
    #[arg(long, value_parser = number_from(1, ServerConfig::WHEELS_MAX))]
    used_wheels: Option<u16>,
    /// People who press
    #[arg(long, value_parser = number_from(0, Plan::POTTERS_MAX))]
    potters: Option<u32>,
    /// People who look on
    #[arg(long, value_parser = number_from(0, Plan::PEOPLE_MAX))]
    spectators: Option<u32>,
    /// What those get: full (as a potter, 60 a second), spectator (30) or gallery (5); or figures of your own, as
    /// quantum=8,fold=2,every=6: radii in so many times 3.8 µm, so many elements taken together each way, one of so many snapshots; with
    /// rows=4-9 those rows of tiles alone, with tools everybody's tools as well
    #[arg(long, value_name = "SIGHT")]
    sight: Option<Sight>,
    /// Potters who hold and predict the clay, so that corrections are measured; each costs the generator a tenth of a core or more
    #[arg(long, value_parser = number_from(0, Plan::FULL_POTTERS_MAX))]
    full_potters: Option<u32>,
    /// Seconds over which people come
    #[arg(long, value_name = "SECONDS", value_parser = number_from(0.0, Plan::PREPARATION_MAX_S))]
    ramp: Option<f64>,
    /// Seconds after that which are left out of the figures
    #[arg(long, value_name = "SECONDS", value_parser = number_from(0.0, Plan::PREPARATION_MAX_S))]
    warmup: Option<f64>,
    /// Seconds that are measured
    #[arg(long, value_name = "SECONDS", value_parser = number_from(1.0, Plan::DURATION_MAX_S))]
    duration: Option<f64>,
    /// Wrong codes a second that strangers try in the second half, all from one address
    #[arg(long, value_name = "PER_SECOND", conflicts_with = "beyond_loopback", value_parser = number_from(0, Plan::STRANGERS_MAX))]
    strangers: Option<u32>,
    /// Seed of every roll of the dice
    #[arg(long, value_parser = number_from(0, u64::MAX))]
    seed: Option<u64>,
    /// What the run has to keep to, like input_delta_ms:p99<120; may be given again
    #[arg(long, value_name = "FIGURE:QUANTILE<BOUND")]
    threshold: Vec<Threshold>,
    /// End with the first threshold that is broken
    #[arg(long)]
    abort_on_fail: bool,
    /// How late the generator may send at the 99th percentile before the run is invalid; who looks on may be 17 ms late
    #[arg(long, value_name = "MS", default_value_t = 5.0, value_parser = number_from(0.0001, 60_000.0))]
    lag_max_ms: f64,
    /// Threads of the generator for those who press, and as many for those who look on
    #[arg(long, default_value_t = 1, value_parser = number_from(1_u8, 64))]
    threads: u8,
    /// Write all figures, with every second, as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json: Option<PathBuf>,
    /// Write a page with charts
    #[arg(long, value_name = "FILE")]
    pub(crate) html: Option<PathBuf>,
    /// No table while it runs
    #[arg(long)]
    quiet: bool,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct KneeFlags {
    #[command(flatten)]
    pub(crate) run: RunFlags,
    /// Who becomes more
    #[arg(long, default_value = "spectators")]
    raise: Raises,
    /// The first load
    #[arg(long, default_value_t = 50, value_parser = number_from(1, Plan::PEOPLE_MAX))]
    from: u32,
    /// The largest that is tried
    #[arg(long, default_value_t = 2000, value_parser = number_from(1, Plan::PEOPLE_MAX))]
    to: u32,
    /// From one load to the next, above 1
    #[arg(long, default_value_t = 1.5, value_parser = number_from(1.001, 100.0))]
    factor: f64,
    /// Times that the way between the last that held and the first that broke is halved
    #[arg(long, default_value_t = 2, value_parser = number_from(0_u32, 32))]
    halvings: u32,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct LawFlags {
    #[command(flatten)]
    pub(crate) run: RunFlags,
    /// Times that every load is gone through
    #[arg(long, default_value_t = 2, value_parser = number_from(1_u32, 100))]
    turns: u32,
    /// Most people who look on
    #[arg(long, default_value_t = 400, value_parser = number_from(4_u32, 4000))]
    most: u32,
}

#[derive(Clone, Debug, Args)]
pub(crate) struct SoakFlags {
    #[command(flatten)]
    pub(crate) run: RunFlags,
    /// So many seconds of a room in virtual time instead, after the warm-up, as fast as the machine goes
    #[arg(long, value_name = "SECONDS", value_parser = number_from(1, Plan::DURATION_MAX_S as u64))]
    pub(crate) virtual_s: Option<u64>,
    /// How much memory may grow beyond twice the error of the line through it, MB
    #[arg(long, value_name = "MB", default_value_t = 1.0, value_parser = number_from(0.0, 1e6))]
    pub(crate) growth_max_mb: f64,
}

impl RunFlags {
    /// The scenario with what flags say in its place.
    pub(crate) fn plan(&self) -> Result<Plan, Box<dyn std::error::Error>> {
        self.plan_of(self.scenario.as_deref())
    }

    fn plan_of(&self, scenario: Option<&str>) -> Result<Plan, Box<dyn std::error::Error>> {
        let mut plan = scenario.map(Plan::read).transpose()?.unwrap_or_default();
        plan.wheels = self.wheels.unwrap_or(plan.wheels);
        plan.used_wheels = self.used_wheels.or(plan.used_wheels);
        plan.potters = self.potters.unwrap_or(plan.potters);
        plan.spectators = self.spectators.unwrap_or(plan.spectators);
        plan.sight = self.sight.unwrap_or(plan.sight);
        plan.full_potters = self.full_potters.unwrap_or(plan.full_potters);
        plan.ramp_s = self.ramp.unwrap_or(plan.ramp_s);
        plan.warmup_s = self.warmup.unwrap_or(plan.warmup_s);
        plan.duration_s = self.duration.unwrap_or(plan.duration_s);
        plan.strangers_per_s = self.strangers.unwrap_or(plan.strangers_per_s);
        plan.seed = self.seed.unwrap_or(plan.seed);
        if let Some(full) = self.full_potters.filter(|full| *full > plan.potters) {
            return Err(
                format!("--full-potters {full} are more than all {} who press: raise --potters", plan.potters).into()
            );
        }
        Ok(plan.checked()?)
    }

    /// Whether its files can be written, which is better known before a run than after it.
    pub(crate) fn check_files(&self) -> Result<(), Box<dyn std::error::Error>> {
        for path in [&self.json, &self.html].into_iter().flatten() {
            let is_new = !path.exists();
            let opened = OpenOptions::new().append(true).create(true).open(path);
            let closed = opened.and_then(|_| if is_new { std::fs::remove_file(path) } else { Ok(()) });
            closed.map_err(|error| format!("{} cannot be written: {}", path.display(), sentence(&error)))?;
        }
        Ok(())
    }

    /// How the run is gone through, once its files can be written.
    pub(crate) fn options(&self) -> Result<Options, Box<dyn std::error::Error>> {
        self.check_files()?;
        Ok(Options {
            against: self.against()?,
            punctuality: Punctuality { lag_max: Duration::from_secs_f64(self.lag_max_ms * 1e-3) },
            thresholds: self.threshold.clone(),
            aborts: self.abort_on_fail,
            threads: usize::from(self.threads),
            is_told: !self.quiet,
            stop: Stop::caught()?,
        })
    }

    fn against(&self) -> Result<Against, Box<dyn std::error::Error>> {
        match (&self.server, &self.code) {
            (Some(address), Some(code)) => {
                check_address(address, code)?;
                if !self.beyond_loopback && !is_loopback(address) {
                    return Err(format!(
                        "{address} is not on this machine: a load test may keep others from their work, so ask first and \
                         say --beyond-loopback"
                    )
                    .into());
                }
                if !is_loopback(address) && self.plan()?.strangers_per_s > 0 {
                    return Err(format!(
                        "strangers knock at servers on this machine alone, and {address} is not on it: choose another scenario, or \
                         --strangers 0"
                    )
                    .into());
                }
                Ok(Against::Running { address: address.clone(), code: code.clone() })
            }
            _ if self.spawn => {
                let program = self.program.clone().map_or_else(server_program, Ok)?;
                let apart = self.server_cores.map(Apart::new).transpose()?.map(Box::new);
                Ok(Against::Spawned { program, threads: self.server_threads, apart })
            }
            _ => Err("say which server: --spawn starts one, --server ADDRESS --code CODE names one; --help tells more"
                .into()),
        }
    }
}

/// Whether an address leads anywhere, which is better known before a run than after it.
fn check_address(address: &str, code: &JoinCode) -> Result<(), Box<dyn std::error::Error>> {
    let target = Target::new(address.to_owned(), code.clone(), 1);
    let looking = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    looking.block_on(target.resolved())?;
    Ok(())
}

/// Whether an address as typed names this machine.
fn is_loopback(address: &str) -> bool {
    let host = address.rsplit_once(':').filter(|(host, _)| !host.contains(':') || host.ends_with(']'));
    let host = host.map_or(address, |(host, _)| host).trim_matches(['[', ']']);
    host == "localhost" || host.parse::<IpAddr>().is_ok_and(|ip| ip.is_loopback())
}

impl KneeFlags {
    pub(crate) fn way(&self) -> Result<Way, Box<dyn std::error::Error>> {
        let &Self { raise, from, to, factor, halvings, .. } = self;
        if self.run.threshold.is_empty() {
            return Err(
                "a knee is where a threshold breaks: say which with --threshold, as in delta_age_ms:p99<20".into()
            );
        }
        if from > to {
            return Err(format!("--from {from} is above --to {to}: choose one that is not").into());
        }
        Ok(Way { raises: raise, from, to, factor, halvings })
    }
}

impl LawFlags {
    /// How long each load takes, and nothing else: who comes is what the law is about.
    pub(crate) fn plan(&self) -> Result<Plan, Box<dyn std::error::Error>> {
        let run = &self.run;
        let of_its_own = [
            ("--scenario", run.scenario.is_some()),
            ("--wheels", run.wheels.is_some()),
            ("--used-wheels", run.used_wheels.is_some()),
            ("--potters", run.potters.is_some()),
            ("--spectators", run.spectators.is_some()),
            ("--sight", run.sight.is_some()),
            ("--full-potters", run.full_potters.is_some()),
            ("--strangers", run.strangers.is_some()),
            ("--threshold", !run.threshold.is_empty()),
            ("--server", run.server.is_some()),
        ];
        if let Some(flag) = first_given(&of_its_own) {
            return Err(format!("the law chooses its own loads, and starts its own server: leave {flag} out").into());
        }
        let plan = Plan {
            full_potters: 0,
            ramp_s: run.ramp.unwrap_or(4.0),
            warmup_s: run.warmup.unwrap_or(2.0),
            duration_s: run.duration.unwrap_or(7.0),
            seed: run.seed.unwrap_or(1),
            ..Plan::default()
        };
        Ok(plan.checked()?)
    }

    pub(crate) const fn way(&self) -> law::Way {
        law::Way { turns: self.turns, most: self.most }
    }
}

/// The first flag that was given.
fn first_given(flags: &[(&'static str, bool)]) -> Option<&'static str> {
    flags.iter().find(|(_, is_given)| *is_given).map(|(flag, _)| *flag)
}

impl SoakFlags {
    /// The scenario `soak` unless another is named.
    pub(crate) fn plan(&self) -> Result<Plan, Box<dyn std::error::Error>> {
        let run = &self.run;
        let of_a_server = [
            ("--spawn", run.spawn),
            ("--server", run.server.is_some()),
            ("--threshold", !run.threshold.is_empty()),
            ("--abort-on-fail", run.abort_on_fail),
            ("--duration", run.duration.is_some()),
            ("--html", run.html.is_some()),
        ];
        if let Some(flag) = first_given(&of_a_server).filter(|_| self.virtual_s.is_some()) {
            return Err(
                format!("a room in virtual time has no server, no seconds and no page: leave {flag} out").into()
            );
        }
        self.run.plan_of(self.run.scenario.as_deref().or(Some("soak")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_this_machine_is_this_machine() {
        for here in ["127.0.0.1:4747", "[::1]:4747", "::1", "localhost:5", "127.8.0.1"] {
            assert!(is_loopback(here), "{here}");
        }
        for there in ["192.168.1.20:4747", "studio.example:4747", "[2001:db8::1]:4747", "localhost.example:1"] {
            assert!(!is_loopback(there), "{there}");
        }
    }
}
