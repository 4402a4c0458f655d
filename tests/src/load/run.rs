//! One run: people come, work, settle and compare their clay, while every second is read.
//!
//! Owns the order of things and the judgement at the end; what people do is theirs.
//! Invariant: a run that ends without an error has a verdict, and `Invalid` outranks all that is said of the server.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use pottery_client::JoinError;
use pottery_client::stroke::{Stroke, StrokeError};
use pottery_shared::protocol::JoinCode;
use tokio::runtime::Handle;
use tokio::sync::watch;
use tokio::task::JoinSet;
use tokio::time::Instant;

use super::bystander::Bystander;
use super::cores::{Apart, Kept};
use super::figures::{Quantiles, Recorder, Tally};
use super::follower::{Ledger, Subject};
use super::host::{self, Host, HostError, Told, Usage};
use super::person::{Outcome, Person, Stage, Studio};
use super::plan::{Plan, PlanError};
use super::result::{Diverged, HostFacts, RunResult, SCHEMA, Second, ServerFigures, Verdict, late_ticks_alone};
use super::schedule::Punctuality;
use super::stop::Stop;
use super::strangers::{StrangerFigures, Strangers};
use super::threshold::Threshold;
use crate::printed::remark;

/// People who share a socket.
const PEOPLE_A_SOCKET: u32 = 16;
/// Time after which a run in which somebody could not come in, and nobody has, is given up, s; where the server itself has said no, at once.
const HOPES_S: f64 = 10.0;
/// Time in which the last presses are confirmed.
const SETTLE_WITHIN: Duration = Duration::from_secs(5);
/// Time in which everybody compares their clay, and more for every person.
const COMPARE_WITHIN: Duration = Duration::from_secs(15);
const COMPARE_EACH: Duration = Duration::from_millis(20);

/// Which server.
#[derive(Clone, Debug)]
pub enum Against {
    /// One of our own, a process beside this one.
    Spawned {
        /// Its program.
        program: PathBuf,
        /// Its threads; as many as it has cores when absent.
        threads: Option<u8>,
        /// Which cores are its own; it and the generator share all when absent.
        apart: Option<Box<Apart>>,
    },
    /// One that runs already.
    Running {
        /// Where.
        address: String,
        /// What lets people in.
        code: JoinCode,
    },
}

/// How a run is gone through.
#[derive(Clone, Debug)]
pub struct Options {
    /// Which server.
    pub against: Against,
    /// How late the generator may be.
    pub punctuality: Punctuality,
    /// What the run has to keep to.
    pub thresholds: Vec<Threshold>,
    /// Whether it ends with the first threshold that is broken.
    pub aborts: bool,
    /// Threads of the generator.
    pub threads: usize,
    /// Whether every second is told.
    pub is_told: bool,
    /// What ends it before its time.
    pub stop: Stop,
}

impl Options {
    /// How the machine's cores are shared out, when they are.
    fn apart(&self) -> Option<&Apart> {
        match &self.against {
            Against::Spawned { apart, .. } => apart.as_deref(),
            Against::Running { .. } => None,
        }
    }
}

/// Why there was no run.
#[derive(Debug, thiserror::Error)]
pub enum RunError {
    /// A plan that cannot be had.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// No server.
    #[error(transparent)]
    Host(#[from] HostError),
    /// No socket.
    #[error(transparent)]
    Network(#[from] JoinError),
    /// No strokes.
    #[error(transparent)]
    Stroke(#[from] StrokeError),
    /// No threads.
    #[error("the system gives no threads: {0}")]
    Threads(std::io::Error),
    /// No cores of its own.
    #[error("the system does not keep a process to a core ({0}): leave --server-cores out")]
    Cores(std::io::Error),
    /// Interrupted by a person.
    #[error("interrupted")]
    Interrupted {
        /// What was measured until then, where something was.
        so_far: Option<Box<RunResult>>,
    },
    /// Nobody came in.
    #[error("nobody could come in: {reasons}")]
    Nobody {
        /// What they were told.
        reasons: String,
    },
    /// The server that was started went away.
    #[error("the server that was started is gone")]
    Gone,
}

/// Goes through a plan.
///
/// # Errors
/// [`RunError`] when it could not be gone through at all.
pub fn run(plan: Plan, options: &Options) -> Result<RunResult, RunError> {
    let plan = plan.checked()?;
    let load_before = host::machine().2;
    let apart = options.apart();
    let spawned = match &options.against {
        Against::Spawned { program, threads, .. } => {
            let _kept = keep(apart, Apart::keep_to_server)?;
            Some(Host::spawn(program, *threads, &plan)?)
        }
        Against::Running { .. } => None,
    };
    let _kept = keep(apart, Apart::keep_to_generator)?;
    if let Some(host) = &spawned {
        remark(format_args!("server      {} (process {})", host.address, host.process()));
    }
    let runtime = || {
        let mut builder = tokio::runtime::Builder::new_multi_thread();
        builder.worker_threads(options.threads).enable_all().build().map_err(RunError::Threads)
    };
    // who presses keeps a schedule: hundreds who read what has come at once are not to stand before it in a queue
    let (eyes, hands) = (runtime()?, runtime()?);
    let result = eyes.block_on(work(plan, options, spawned.as_ref(), load_before, hands.handle()));
    hands.shutdown_timeout(Duration::from_secs(1));
    eyes.shutdown_timeout(Duration::from_secs(1));
    result
}

/// Sockets for so many people, served by the threads that `on` names.
fn sockets(people: u32, on: &Handle) -> Result<Vec<quinn::Endpoint>, RunError> {
    let _on = on.enter();
    let sockets = people.div_ceil(PEOPLE_A_SOCKET).max(1);
    Ok((0..sockets).map(|_| pottery_client::endpoint()).collect::<Result<_, _>>()?)
}

fn keep(apart: Option<&Apart>, side: impl FnOnce(&Apart) -> std::io::Result<Kept>) -> Result<Option<Kept>, RunError> {
    apart.map(side).transpose().map_err(RunError::Cores)
}

fn strokes() -> Result<Vec<Arc<Stroke>>, StrokeError> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/strokes");
    let read = |name: &str| Stroke::read(folder.join(name).with_extension("csv")).map(Arc::new);
    ["waist", "neck", "foot", "evaluation"].into_iter().map(read).collect()
}

async fn work(
    plan: Plan,
    options: &Options,
    spawned: Option<&Host>,
    load_before: String,
    hands: &Handle,
) -> Result<RunResult, RunError> {
    let (address, code) = match &options.against {
        Against::Running { address, code } => (address.clone(), code.clone()),
        Against::Spawned { .. } => {
            spawned.map(|host| (host.address.to_string(), host.code.clone())).ok_or(RunError::Gone)?
        }
    };
    let eyes = Handle::current();
    let endpoints = [sockets(plan.potters, hands)?, sockets(plan.spectators, &eyes)?];
    let studio = Arc::new(Studio {
        plan,
        address,
        code,
        epoch: Instant::now(),
        punctuality: options.punctuality,
        recorder: Recorder::default(),
        ledger: Ledger::default(),
        strokes: strokes()?,
        endpoints,
        settled: AtomicU32::new(0),
    });
    let (stage, told) = watch::channel(Stage::Work);
    let mut people = JoinSet::new();
    for number in 0..studio.plan.people() {
        let person = Person::new(&studio, number, told.clone());
        let threads = if person.presses() { hands } else { &eyes };
        people.spawn_on(person.live(), threads);
    }
    let mut watched = Watched::new(&studio, options, spawned, load_before);
    let outcomes = tokio::select! {
        // whoever has said so before this run began as well
        biased;
        () = options.stop.come() => return Err(RunError::Interrupted { so_far: watched.so_far() }),
        outcomes = watched.go_through(&stage, &mut people) => outcomes?,
    };
    stage.send_replace(Stage::Leave);
    people.abort_all();
    while people.join_next().await.is_some() {}
    for endpoint in studio.endpoints.iter().flatten() {
        endpoint.close(0_u32.into(), b"goodbye");
    }
    Ok(watched.judge(outcomes))
}

async fn settle(studio: &Studio) {
    let deadline = Instant::now() + SETTLE_WITHIN;
    while studio.settled.load(Ordering::Relaxed) < studio.plan.potters && Instant::now() < deadline {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    // the last snapshot reaches those who settled first as well
    tokio::time::sleep(Duration::from_millis(300)).await;
}

async fn compare(studio: &Studio, people: &mut JoinSet<Option<Outcome>>) -> Vec<Outcome> {
    let deadline = Instant::now() + COMPARE_WITHIN + COMPARE_EACH * studio.plan.people();
    let mut outcomes = Vec::new();
    while let Ok(Some(ended)) = tokio::time::timeout_at(deadline, people.join_next()).await {
        outcomes.extend(ended.ok().flatten());
    }
    outcomes
}

/// What is read while people work.
struct Watched<'a> {
    studio: &'a Arc<Studio>,
    options: &'a Options,
    spawned: Option<&'a Host>,
    /// Since the beginning of the measured time.
    total: Tally,
    result: RunResult,
    server_before: Option<(Usage, Told)>,
    generator_before: Option<Usage>,
    bystander: Option<Bystander>,
    last: (Option<Usage>, Option<Usage>),
    /// What the server had told a second ago, and how often the bystander had been late.
    last_told: Option<Told>,
    last_bystander: u64,
    /// The age of clay before strangers came and since, and they.
    ages: [Tally; 2],
    strangers: Option<(Strangers, f64)>,
}

impl<'a> Watched<'a> {
    fn new(studio: &'a Arc<Studio>, options: &'a Options, spawned: Option<&'a Host>, load_before: String) -> Self {
        let (processor, cores, _) = host::machine();
        let system = format!("{} {}", std::env::consts::OS, std::env::consts::ARCH);
        let server_cores = options.apart().map(Apart::servers);
        let is_release = !cfg!(debug_assertions);
        let host = HostFacts { processor, cores, server_cores, load_before, system, is_release };
        let none = Quantiles::default();
        let result = RunResult {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            protocol: pottery_shared::protocol::VERSION,
            host,
            plan: studio.plan.clone(),
            verdict: Verdict::Pass,
            said: Vec::new(),
            measured_s: 0.0,
            join_ms: none,
            input_delta_ms: none,
            input_delta_uncorrected_ms: none,
            delta_age_ms: none,
            correction_mm: none,
            schedule_lag_ms: none,
            look_lag_ms: none,
            sends: 0,
            dropped_sends: 0,
            held_back: 0,
            datagrams: 0,
            down_bytes: 0,
            up_bytes: 0,
            up_lost_percent: 0.0,
            asked: 0,
            reconnects: 0,
            broken: 0,
            failed_joins: 0,
            outside: 0,
            is_interrupted: false,
            unlike: 0,
            compared: 0,
            untold: Vec::new(),
            diverged: Vec::new(),
            server: None,
            server_cpu_percent: None,
            server_memory_mb: None,
            generator_cpu_percent: None,
            generator_memory_mb: None,
            bystander_late: 0,
            strangers: None,
            seconds: Vec::new(),
        };
        let (total, last, ages) = (Tally::default(), (None, None), Default::default());
        let (server_before, generator_before) = (None, None);
        let (strangers, bystander) = (None, None);
        Self {
            studio,
            options,
            spawned,
            total,
            result,
            server_before,
            generator_before,
            last,
            last_told: None,
            last_bystander: 0,
            ages,
            strangers,
            bystander,
        }
    }

    /// Lets people work, settle and compare their clay.
    async fn go_through(
        &mut self,
        stage: &watch::Sender<Stage>,
        people: &mut JoinSet<Option<Outcome>>,
    ) -> Result<Vec<Outcome>, RunError> {
        self.watch().await?;
        stage.send_replace(Stage::Settle);
        settle(self.studio).await;
        stage.send_replace(Stage::Compare);
        Ok(compare(self.studio, people).await)
    }

    /// What an interrupted run has measured, which nothing is judged by.
    fn so_far(mut self) -> Option<Box<RunResult>> {
        if self.result.measured_s <= 0.0 {
            return None;
        }
        self.summarise();
        let measured_s = self.result.measured_s;
        (self.result.verdict, self.result.is_interrupted) = (Verdict::Invalid, true);
        self.result.said.insert(
            0,
            format!("this run was interrupted after {measured_s:.0} s of its measured time, and no clay was compared"),
        );
        Some(Box::new(self.result))
    }

    /// Reads every second until the time is over, or a threshold is broken and that ends the run.
    async fn watch(&mut self) -> Result<(), RunError> {
        let plan = &self.studio.plan;
        let (begins_s, ends_s) = (plan.ramp_s + plan.warmup_s, plan.total_s());
        let mut at_s = 0.0;
        (self.last, self.last_told) = self.used();
        while at_s < ends_s {
            // a whole second, or what is left to the next border
            let border_s = if at_s < begins_s { begins_s } else { ends_s };
            let until_s = (at_s + 1.0).min(if border_s - at_s < 1.5 { border_s } else { f64::MAX });
            tokio::time::sleep_until(self.studio.epoch + Duration::from_secs_f64(until_s)).await;
            let is_measured = at_s >= begins_s;
            if is_measured && self.generator_before.is_none() {
                self.generator_before = self.last.1;
                // a server tells once a second, and may not yet have told of its first
                self.server_before = self.last.0.map(|usage| (usage, self.last_told.clone().unwrap_or_default()));
                // it stands on whatever core is free, as what waits for a slow machine does
                let _kept = keep(self.options.apart(), Apart::keep_to_none)?;
                self.bystander = Some(Bystander::stand().map_err(RunError::Threads)?);
            }
            let is_besieged = self.strangers.is_some();
            self.let_strangers_come(at_s)?;
            let tally = self.studio.recorder.take();
            if is_measured {
                self.ages[usize::from(is_besieged)].add(&tally);
            }
            if !is_measured {
                // people come before the measured time, and their joins are of interest all the same
                self.total.add_joins(&tally);
            }
            if (at_s >= HOPES_S || self.studio.recorder.is_answered())
                && self.total.join_us.is_empty()
                && tally.join_us.is_empty()
                && let Some(reasons) = self.studio.recorder.refusals()
            {
                return Err(RunError::Nobody { reasons });
            }
            self.read(&tally, at_s, until_s, is_measured);
            if is_measured {
                self.total.add(&tally);
                self.result.measured_s = until_s - begins_s;
                if self.options.aborts && self.breaks() {
                    self.result.said.push(format!("aborted after {:.0} s", self.result.measured_s));
                    break;
                }
            }
            at_s = until_s;
        }
        let refusals = self.studio.recorder.refusals();
        if self.studio.plan.people() > 0 && self.total.join_us.is_empty() {
            let reasons = refusals.unwrap_or_else(|| match &self.options.against {
                Against::Running { address, .. } => {
                    format!("nothing answers at {address}; is a server there, and is the port right?")
                }
                Against::Spawned { .. } => "the server that was started answers nothing".into(),
            });
            return Err(RunError::Nobody { reasons });
        }
        self.summarise();
        let (outside, people) = (self.result.outside, self.studio.plan.people());
        self.result.said.extend(refusals.map(|reasons| match outside {
            0 => format!("somebody could not come in: {reasons}"),
            _ => format!(
                "{outside} of {people} people never came in, and the figures are of the others alone: {reasons}"
            ),
        }));
        Ok(())
    }

    /// Lets strangers knock from half of the measured time on.
    fn let_strangers_come(&mut self, at_s: f64) -> Result<(), RunError> {
        let plan = &self.studio.plan;
        let is_time = at_s >= plan.ramp_s + plan.warmup_s + 0.5 * plan.duration_s;
        if plan.strangers_per_s > 0 && is_time && self.strangers.is_none() {
            let address = self.studio.address.clone();
            let strangers = Strangers::come(address, plan.strangers_per_s).map_err(RunError::Threads)?;
            self.strangers = Some((strangers, at_s));
        }
        Ok(())
    }

    /// Whether a threshold that can be judged already is broken.
    fn breaks(&mut self) -> bool {
        self.summarise();
        let (thresholds, result) = (&self.options.thresholds, &self.result);
        thresholds.iter().any(|threshold| threshold.value(result).is_some() && !threshold.holds(result))
    }

    fn summarise(&mut self) {
        self.result.take_in(&self.total);
        self.result.outside = self.studio.recorder.outside();
        let measured_s = self.result.measured_s;
        if let Some((strangers, since_s)) = &self.strangers {
            let plan = &self.studio.plan;
            let knocked_s = measured_s + plan.ramp_s + plan.warmup_s - since_s;
            let [quiet_age_ms, besieged_age_ms] = self.ages.each_ref().map(|ages| Quantiles::of(&ages.age_us, 1e-3));
            let per_s = |count: u64| count as f64 / knocked_s.max(1.0);
            let [knocks_per_s, answered_per_s] = [strangers.knocks(), strangers.answered()].map(per_s);
            let figures = StrangerFigures { knocks_per_s, answered_per_s, quiet_age_ms, besieged_age_ms };
            self.result.strangers = Some(figures);
        }
        let percent = |now: Option<Usage>, before: Option<Usage>| {
            now.zip(before).map(|(now, before)| 100.0 * (now.cpu_s - before.cpu_s) / measured_s)
        };
        let (server, generator) = self.last;
        self.result.server_cpu_percent = percent(server, self.server_before.as_ref().map(|(usage, _)| *usage));
        self.result.generator_cpu_percent = percent(generator, self.generator_before);
        self.result.server_memory_mb = server.map(|usage| usage.memory_mb);
        self.result.generator_memory_mb = generator.map(|usage| usage.memory_mb);
        self.result.bystander_late = self.bystander.as_ref().map_or(0, Bystander::late);
        if let (Some((_, before)), Some(now)) = (&self.server_before, self.spawned.and_then(Host::told)) {
            self.result.server = Some(ServerFigures {
                wake_ms: Quantiles::of(&now.wakes_since(before), 1e-3),
                late_ticks: now.late - before.late,
                late_ticks_alone: late_ticks_alone(&self.result.seconds),
                datagrams: now.datagrams - before.datagrams,
                dropped_datagrams: now.dropped_datagrams - before.dropped_datagrams,
                resyncs: now.resyncs - before.resyncs,
                refused_samples: now.refused_samples - before.refused_samples,
                unheard: now.unheard - before.unheard,
            });
        }
    }

    /// What server and generator have used, and what the server has told.
    fn used(&self) -> ((Option<Usage>, Option<Usage>), Option<Told>) {
        let server = self.spawned.and_then(|host| host::usage(host.process()));
        ((server, host::usage(std::process::id())), self.spawned.and_then(Host::told))
    }

    fn read(&mut self, tally: &Tally, at_s: f64, until_s: f64, is_measured: bool) {
        let ((server, generator), told) = self.used();
        let late_before = self.last_told.as_ref().map_or(0, |before| before.late);
        let bystander_late = self.bystander.as_ref().map_or(0, Bystander::late);
        let length_s = until_s - at_s;
        let percent = |now: Option<Usage>, before: Option<Usage>| {
            now.zip(before).map(|(now, before)| 100.0 * (now.cpu_s - before.cpu_s) / length_s)
        };
        let ms = |histogram: &hdrhistogram::Histogram<u64>, at| histogram.value_at_quantile(at) as f64 * 1e-3;
        let second = Second {
            at_s: until_s,
            is_measured,
            people: self.studio.recorder.people(),
            input_delta_p50_ms: ms(&tally.input_delta_us, 0.5),
            input_delta_p99_ms: ms(&tally.input_delta_us, 0.99),
            delta_age_p99_ms: ms(&tally.age_us, 0.99),
            schedule_lag_p99_ms: ms(&tally.lag_us, 0.99),
            down_kbit_s: tally.down_bytes as f64 * 8e-3 / length_s,
            up_kbit_s: tally.up_bytes as f64 * 8e-3 / length_s,
            server_cpu_percent: percent(server, self.last.0),
            server_memory_mb: server.map(|usage| usage.memory_mb),
            generator_cpu_percent: percent(generator, self.last.1),
            joins: tally.join_us.len(),
            late_ticks: told.as_ref().map(|told| told.late - late_before),
            bystander_late: bystander_late - self.last_bystander,
        };
        self.last = (server, generator);
        (self.last_told, self.last_bystander) = (told, bystander_late);
        if self.options.is_told {
            self.tell(&second);
        }
        self.result.seconds.push(second);
    }

    fn tell(&self, second: &Second) {
        if self.result.seconds.len().is_multiple_of(20) {
            remark(format_args!(
                "{:>9} {:>7} {:>9} {:>9} {:>8} {:>7} {:>9} {:>8} {:>8} {:>8}",
                "", "people", "input p50", "p99 ms", "age p99", "lag p99", "down kb/s", "srv cpu", "srv MB", "gen cpu"
            ));
        }
        let percent = |value: Option<f64>| value.map_or_else(|| "-".into(), |value| format!("{value:.0} %"));
        let total_s = self.studio.plan.total_s();
        remark(format_args!(
            "{:>3.0}% {:>4.0}s{} {:>6} {:>9.1} {:>9.1} {:>8.1} {:>7.1} {:>9.0} {:>8} {:>8.0} {:>8}",
            100.0 * second.at_s / total_s,
            second.at_s,
            if second.is_measured { ' ' } else { '*' },
            second.people,
            second.input_delta_p50_ms,
            second.input_delta_p99_ms,
            second.delta_age_p99_ms,
            second.schedule_lag_p99_ms,
            second.down_kbit_s,
            percent(second.server_cpu_percent),
            second.server_memory_mb.unwrap_or_default(),
            percent(second.generator_cpu_percent),
        ));
    }

    fn judge(mut self, outcomes: Vec<Outcome>) -> RunResult {
        self.result.compared = outcomes.len() as u32;
        self.result.diverged = diverged(&outcomes);
        self.result.untold = untold(self.studio.plan.people(), &outcomes);
        let broken: Vec<_> =
            self.options.thresholds.iter().filter(|threshold| !threshold.holds(&self.result)).collect();
        let is_borne = broken.is_empty() && self.result.outside == 0;
        let mut verdict = if is_borne { Verdict::Pass } else { Verdict::Breach };
        for threshold in broken {
            let value = threshold.value(&self.result);
            let value = value.map_or_else(|| "not measured".into(), |value| format!("{value:.3}"));
            self.result.said.push(format!("threshold {threshold} is broken: {value}"));
        }
        if !self.result.diverged.is_empty() || !self.result.untold.is_empty() || self.result.unlike > 0 {
            verdict = Verdict::Diverged;
            self.result.said.push(format!(
                "of {} people {} do not hold the server's clay and {} could not tell what they hold; {} messages were unlike others'",
                self.studio.plan.people(),
                self.result.diverged.len(),
                self.result.untold.len(),
                self.result.unlike
            ));
            self.result.said.extend(self.result.diverged.first().map(|diverged| diverged.said.clone()));
            self.result.said.extend(untold_said(&self.result.untold));
        }
        let p99 = |histogram: &hdrhistogram::Histogram<u64>| Duration::from_micros(histogram.value_at_quantile(0.99));
        let lags = [&self.total.lag_us, &self.total.look_lag_us].map(p99);
        let fault = self.options.punctuality.fault(lags, self.total.sends, self.total.dropped_sends);
        if let Some(fault) = fault {
            verdict = Verdict::Invalid;
            self.result.said.insert(0, format!("this run is invalid and says nothing of the server: {fault}"));
        }
        self.result.verdict = verdict;
        self.result
    }
}

/// Everybody whose clay is not what the server told.
fn diverged(outcomes: &[Outcome]) -> Vec<Diverged> {
    let mut found = Vec::new();
    let mut newest: BTreeMap<Subject, (u32, u64)> = BTreeMap::new();
    for outcome in outcomes {
        let known = *newest.entry(outcome.subject).or_insert((outcome.version, outcome.told));
        let is_same = known == (outcome.version, outcome.told) && outcome.digest == outcome.told;
        if !is_same {
            found.push(Diverged { said: format!("{outcome:?}; others at version {} with {:x}", known.0, known.1) });
        }
    }
    found
}

/// The numbers of those who could not tell their clay: whose connection was lost, or was not answered any more.
fn untold(people: u32, outcomes: &[Outcome]) -> Vec<u32> {
    let there: std::collections::BTreeSet<_> = outcomes.iter().map(|outcome| outcome.number).collect();
    (0..people).filter(|number| !there.contains(number)).collect()
}

/// Who they were, in a sentence; none where everybody could.
fn untold_said(untold: &[u32]) -> Option<String> {
    const NAMED: usize = 8;
    let named: Vec<_> = untold.iter().take(NAMED).map(u32::to_string).collect();
    let more = if untold.len() > NAMED { " and others" } else { "" };
    (!named.is_empty()).then(|| {
        format!(
            "who could not tell had lost the connection, or was not answered: {}{more}, counted from 0",
            named.join(", ")
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn clay_of_another_digest_or_nobody_at_all_is_found() {
        let outcome = |number, digest| Outcome { number, subject: (1, None), version: 4, digest, told: 7 };
        assert_eq!(diverged(&[outcome(0, 7), outcome(1, 7)]), []);
        assert_eq!(diverged(&[outcome(0, 7), outcome(1, 8)]).len(), 1);
        assert_eq!(untold(3, &[outcome(0, 7), outcome(2, 8)]), [1]);
        assert_eq!(untold_said(&[]), None);
        assert!(untold_said(&[1, 5]).unwrap().contains("answered: 1, 5, counted"), "{:?}", untold_said(&[1, 5]));
    }
}
