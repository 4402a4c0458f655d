//! How many people a server takes: the load is raised until a threshold breaks.
//!
//! Owns the climb; each step is a run.
//! Invariant: the knee is a load that was measured and held, and a step that the generator spoilt proves nothing.

use serde::{Deserialize, Serialize};

use super::plan::Plan;
use super::result::{RunResult, Verdict};
use super::run::{Options, RunError, run};
use crate::printed::remark;

/// What is raised.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Raises {
    /// Those who look on.
    Spectators,
    /// Those who press.
    Potters,
}

/// One load that was tried.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Step {
    /// How many of those who are raised.
    pub people: u32,
    /// From due input to clay.
    pub input_delta_p99_ms: f64,
    /// Age of clay.
    pub delta_age_p99_ms: f64,
    /// How late sends were.
    pub schedule_lag_p99_ms: f64,
    /// Processor time of the server, % of a core.
    pub server_cpu_percent: f64,
    /// Memory of the server, MB.
    pub server_memory_mb: f64,
    /// From the server, kbit/s.
    pub down_kbit_s: f64,
    /// How it ended.
    pub verdict: Verdict,
}

/// A climb.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Climb {
    /// What was raised.
    pub raises: String,
    /// Every load, in ascending order.
    pub steps: Vec<Step>,
    /// The largest load that held.
    pub knee: Option<u32>,
    /// The smallest that did not, and why.
    pub broke: Option<(u32, String)>,
    /// The load at which the climb ended because its run says nothing of how many there may be, how it ended, and why.
    pub spoilt: Option<(u32, Verdict, String)>,
    /// The first run, for what it says of the machine.
    pub first: Option<RunResult>,
}

/// How to climb.
#[derive(Clone, Copy, Debug)]
pub struct Way {
    /// What is raised.
    pub raises: Raises,
    /// The first load.
    pub from: u32,
    /// The largest that is tried.
    pub to: u32,
    /// From one load to the next.
    pub factor: f64,
    /// Times that the way between the last that held and the first that did not is halved.
    pub halvings: u32,
}

/// Climbs, until a threshold breaks, a run is invalid or interrupted, or somebody's clay is not the server's.
///
/// # Errors
/// [`RunError`] when a run could not be gone through.
pub fn climb(plan: &Plan, way: Way, options: &Options) -> Result<Climb, RunError> {
    let raises = match way.raises {
        Raises::Spectators => "people who look on",
        Raises::Potters => "people who press",
    };
    let mut climb =
        Climb { raises: raises.into(), steps: Vec::new(), knee: None, broke: None, spoilt: None, first: None };
    let mut people = way.from;
    while climb.broke.is_none() && climb.spoilt.is_none() {
        climb.try_load(plan, way.raises, people, options)?;
        if people >= way.to {
            break;
        }
        people = ((f64::from(people) * way.factor).ceil() as u32).max(people + 1).min(way.to);
    }
    for _ in 0..way.halvings {
        let (Some(knee), Some((broke, _)), None) = (climb.knee, &climb.broke, &climb.spoilt) else { break };
        let middle = knee.midpoint(*broke);
        if middle == knee {
            break;
        }
        climb.try_load(plan, way.raises, middle, options)?;
    }
    climb.steps.sort_by_key(|step| step.people);
    Ok(climb)
}

impl Climb {
    fn try_load(&mut self, plan: &Plan, raises: Raises, people: u32, options: &Options) -> Result<(), RunError> {
        let mut plan = plan.clone();
        match raises {
            Raises::Spectators => plan.spectators = people,
            Raises::Potters => plan.potters = people,
        }
        let result = match run(plan, options) {
            // what was gone through before says what it says
            Err(RunError::Interrupted { .. }) if !self.steps.is_empty() => {
                self.spoilt = Some((people, Verdict::Invalid, "it was interrupted".into()));
                return Ok(());
            }
            result => result?,
        };
        let step = Step {
            people,
            input_delta_p99_ms: result.input_delta_ms.p99,
            delta_age_p99_ms: result.delta_age_ms.p99,
            schedule_lag_p99_ms: result.schedule_lag_ms.p99,
            server_cpu_percent: result.server_cpu_percent.unwrap_or_default(),
            server_memory_mb: result.server_memory_mb.unwrap_or_default(),
            down_kbit_s: result.down_bytes as f64 * 8e-3 / result.measured_s,
            verdict: result.verdict,
        };
        remark(step.row());
        match result.verdict {
            Verdict::Pass => self.knee = Some(self.knee.map_or(people, |knee| knee.max(people))),
            Verdict::Breach => self.broke = Some((people, result.said.join("; "))),
            verdict => self.spoilt = Some((people, verdict, result.said.join("; "))),
        }
        self.steps.push(step);
        self.first.get_or_insert(result);
        Ok(())
    }

    /// How it ended: as the run that spoilt it, with a knee, or without one.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let without = if self.knee.is_some() { Verdict::Pass } else { Verdict::Breach };
        self.spoilt.as_ref().map_or(without, |(_, verdict, _)| *verdict)
    }

    /// What came of it.
    #[must_use]
    pub fn sentence(&self) -> String {
        let held = self.knee.map_or_else(|| "No load held".into(), |knee| format!("{knee} {} held", self.raises));
        if let Some((people, _, why)) = &self.spoilt {
            return format!("{held}; with {people} the climb ended: {why}.");
        }
        match &self.broke {
            Some((people, why)) => format!("{held}; {people} did not: {why}."),
            None => format!("{held}; nothing broke."),
        }
    }

    /// A table for a person.
    #[must_use]
    pub fn table(&self) -> String {
        let rows: Vec<_> = self.steps.iter().map(Step::row).collect();
        format!(
            "{:>7} {:>11} {:>11} {:>9} {:>9} {:>8} {:>10}\n{}\n",
            "people",
            "input p99",
            "age p99",
            "lag p99",
            "srv cpu",
            "srv MB",
            "down kb/s",
            rows.join("\n")
        )
    }
}

impl Step {
    fn row(&self) -> String {
        format!(
            "{:>7} {:>8.1} ms {:>8.1} ms {:>6.1} ms {:>7.1} % {:>8.0} {:>10.0}  {}",
            self.people,
            self.input_delta_p99_ms,
            self.delta_age_p99_ms,
            self.schedule_lag_p99_ms,
            self.server_cpu_percent,
            self.server_memory_mb,
            self.down_kbit_s,
            self.verdict.name()
        )
    }
}
