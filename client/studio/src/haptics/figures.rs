//! The figures of a measured hand: words for people and a table for programs.
//!
//! Owns the classes of times; measures nothing itself.
//! Invariant: words, table and picture are made from the same numbers.

use std::fmt::{self, Write as _};
use std::time::Duration;

use pottery_client::{IdleLoop, LoopRate, Pacing};

use super::Outcome;

type Histogram = hdrhistogram::Histogram<u64>;

/// Width of a row of the table, µs, and where the last row begins, which has everything beyond.
pub(super) const ROW_US: u64 = 10;
pub(super) const LAST_US: u64 = 2_000;
/// Borders of the classes that are shown to people, µs where a turn takes a millisecond.
const CLASSES_US: [u64; 12] = [0, 500, 800, 900, 950, 990, 1_010, 1_050, 1_100, 1_200, 2_000, 1_000_000];
/// Longest bar, signs.
const BAR: f64 = 40.0;

/// What was measured, ready to be said.
pub(super) struct Figures {
    /// What the hand was measured beside.
    pub(super) beside: &'static str,
    /// What its thread was granted.
    pub(super) granted: String,
    /// How often its loop goes round, and the length of a turn.
    rate: LoopRate,
    /// Part of a wait that it spun in the end.
    spun: Duration,
    pub(super) period: Duration,
    pub(super) ticks: u64,
    /// Ticks that began too late, and deadlines that went by.
    late: u64,
    missed: u64,
    /// What a loop with nothing to do kept on the same machine.
    idle: IdleLoop,
    /// Time from tick to tick and time of a tick's work, ns.
    period_ns: Histogram,
    work_ns: Histogram,
    /// Largest force, N.
    force_max_n: f64,
    /// Share of the looks at which the hand touched clay, and how many elements in the middle of them.
    touching: f64,
    elements: u32,
    /// Pictures a second, and what drew them.
    pictures: Option<(f64, String)>,
}

impl Figures {
    pub(super) fn new(outcome: &Outcome, beside: &'static str, idle: IdleLoop) -> Self {
        let report = &outcome.report;
        let mut elements: Vec<u32> = outcome.looks.elements.iter().copied().filter(|&count| count > 0).collect();
        elements.sort_unstable();
        let seconds = (report.ticks + report.missed_ticks) as f64 * Pacing::PERIOD.as_secs_f64();
        Self {
            beside,
            granted: outcome.granted.to_string(),
            rate: outcome.granted.rate,
            spun: report.spun,
            period: outcome.granted.rate.period(),
            ticks: report.ticks,
            late: report.late_ticks,
            missed: report.missed_ticks,
            idle,
            period_ns: report.period_ns.clone(),
            work_ns: report.step_ns.clone(),
            force_max_n: report.force_mn.max() as f64 * 1e-3,
            touching: elements.len() as f64 / outcome.looks.elements.len().max(1) as f64,
            elements: elements.get(elements.len() / 2).copied().unwrap_or(0),
            pictures: outcome.pictures.as_ref().map(|(count, on)| (*count as f64 / seconds, on.clone())),
        }
    }

    /// Share of the ticks that began too late.
    pub(super) fn late_share(&self) -> f64 {
        self.late as f64 / self.ticks.max(1) as f64
    }

    /// How many periods and how many ticks' work lie in each row: its beginning in µs, periods, works.
    pub(super) fn rows(&self) -> Vec<(u64, u64, u64)> {
        let rows = (0..=LAST_US / ROW_US).map(|row| row * ROW_US);
        rows.map(|from_us| {
            let to_us = if from_us == LAST_US { u64::MAX / 1_000 } else { from_us + ROW_US };
            (from_us, between(&self.period_ns, from_us, to_us), between(&self.work_ns, from_us, to_us))
        })
        .collect()
    }

    /// The rows as comma-separated values.
    pub(super) fn csv(&self) -> String {
        let mut text = String::from("from_us,to_us,periods,works\n");
        for (from_us, periods, works) in self.rows() {
            let to_us = if from_us == LAST_US { "inf".to_owned() } else { (from_us + ROW_US).to_string() };
            writeln!(text, "{from_us},{to_us},{periods},{works}").expect("a text in memory can be written");
        }
        text
    }
}

/// How many values are from one time on and below another.
fn between(histogram: &Histogram, from_us: u64, to_us: u64) -> u64 {
    let below = |us: u64| match us.saturating_mul(1_000) {
        0 => 0,
        ns => histogram
            .iter_recorded()
            .take_while(|value| value.value_iterated_to() < ns)
            .map(|value| value.count_at_value())
            .sum(),
    };
    below(to_us) - below(from_us)
}

/// p50, p99, p99.9 and the largest, µs.
fn spread(histogram: &Histogram) -> String {
    let at = |quantile| histogram.value_at_quantile(quantile) as f64 * 1e-3;
    let max_us = histogram.max() as f64 * 1e-3;
    format!("p50 {:.1} µs, p99 {:.1} µs, p99.9 {:.1} µs, max {max_us:.1} µs", at(0.5), at(0.99), at(0.999))
}

impl fmt::Display for Figures {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(f, "beside     {}", self.beside)?;
        if let Some((rate, adapter)) = &self.pictures {
            writeln!(f, "pictures   {rate:.0} a second on {adapter}")?;
        }
        writeln!(f, "thread     {}", self.granted)?;
        writeln!(f, "loop       {}", self.rate)?;
        writeln!(f, "wait       asleep, but for the last {} µs", self.spun.as_micros())?;
        writeln!(f, "ticks      {}, {} deadlines missed", self.ticks, self.missed)?;
        writeln!(f, "late       {} by more than 200 µs: {:.3} %", self.late, self.late_share() * 1e2)?;
        writeln!(
            f,
            "machine    a loop with nothing to do is late in {:.3} %, {} deadlines missed of {}",
            self.idle.late_share() * 1e2,
            self.idle.missed,
            self.idle.ticks + self.idle.missed
        )?;
        writeln!(f, "period     {}", spread(&self.period_ns))?;
        writeln!(f, "work       {}", spread(&self.work_ns))?;
        writeln!(
            f,
            "contact    {:.0} % of the time, {} elements, up to {:.2} N",
            self.touching * 1e2,
            self.elements,
            self.force_max_n
        )?;
        let periods = self.period_ns.len().max(2) as f64;
        let turns = (Pacing::PERIOD.as_nanos() / self.period.as_nanos().max(1)) as u64;
        for border in CLASSES_US.windows(2) {
            let is_last = border[1] == 1_000_000;
            let border = [border[0] / turns, if is_last { border[1] } else { border[1] / turns }];
            let count = between(&self.period_ns, border[0], border[1]);
            // by its logarithm, so that one in ten thousand is seen
            let signs = if count == 0 { 0.0 } else { 1.0 + (BAR - 1.0) * (count as f64).ln() / periods.ln() };
            let name = if is_last {
                format!("{:>5} µs and longer", border[0])
            } else {
                format!("{:>5} to {:>4} µs   ", border[0], border[1])
            };
            writeln!(f, "{name}  {:<40} {count}", "#".repeat(signs as usize))?;
        }
        Ok(())
    }
}
