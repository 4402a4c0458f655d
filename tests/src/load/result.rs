//! What came of a run, as it is written to JSON.
//!
//! Owns the schema; measures nothing.
//! Invariant: [`SCHEMA`] is raised with every change that an older reader would misread.

use serde::{Deserialize, Serialize};

use super::figures::{Quantiles, Tally};
use super::plan::Plan;
use super::strangers::StrangerFigures;

/// Version of the file's form.
pub const SCHEMA: u32 = 1;

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Verdict {
    /// Every threshold holds and everybody has the same clay.
    Pass,
    /// A threshold is broken, or somebody was turned away until the measured time was over.
    Breach,
    /// The generator did not keep its schedule, so that the figures say nothing of the server; or the run was interrupted.
    Invalid,
    /// Somebody's clay is not the server's.
    Diverged,
}

impl Verdict {
    /// In a word.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Pass => "pass",
            Self::Breach => "breach",
            Self::Invalid => "invalid",
            Self::Diverged => "diverged",
        }
    }

    /// The program's exit code.
    #[must_use]
    pub const fn code(self) -> u8 {
        match self {
            Self::Pass => 0,
            Self::Breach => 99,
            Self::Invalid => 98,
            Self::Diverged => 97,
        }
    }
}

/// One second of a run.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Second {
    /// Since the beginning, s.
    pub at_s: f64,
    /// Whether it is in the figures.
    pub is_measured: bool,
    /// People who were in.
    pub people: i64,
    /// From due input to clay, ms.
    pub input_delta_p50_ms: f64,
    /// See `input_delta_p50_ms`.
    pub input_delta_p99_ms: f64,
    /// Age of clay, ms.
    pub delta_age_p99_ms: f64,
    /// How late sends began, ms.
    pub schedule_lag_p99_ms: f64,
    /// Bits a second from the server, kbit/s.
    pub down_kbit_s: f64,
    /// To the server, kbit/s.
    pub up_kbit_s: f64,
    /// Processor time of the server, % of a core.
    pub server_cpu_percent: Option<f64>,
    /// Memory of the server, MB.
    pub server_memory_mb: Option<f64>,
    /// Processor time of the generator, % of a core.
    pub generator_cpu_percent: Option<f64>,
    /// Joins that took place.
    pub joins: u64,
    /// [`ServerFigures::late_ticks`] that a spawned server told of in this second.
    #[serde(default)]
    pub late_ticks: Option<u64>,
    /// [`RunResult::bystander_late`] of this second.
    #[serde(default)]
    pub bystander_late: u64,
}

/// Where it was measured.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct HostFacts {
    /// The processor.
    pub processor: String,
    /// Cores that the generator may use.
    pub cores: usize,
    /// Cores that were the server's alone; absent when both used the same.
    #[serde(default)]
    pub server_cores: Option<usize>,
    /// Load averages before the run.
    pub load_before: String,
    /// Operating system and architecture.
    pub system: String,
    /// Whether both were compiled with optimisation.
    pub is_release: bool,
}

impl HostFacts {
    /// How the two sides had the machine, in words.
    #[must_use]
    pub fn shared_out(&self) -> String {
        match self.server_cores {
            Some(servers) => format!("cores of their own, {servers} and {}", self.cores),
            None => "on the same cores".to_owned(),
        }
    }
}

/// The server's side of the measured time.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ServerFigures {
    /// Length of a wake-up's work, ms.
    pub wake_ms: Quantiles,
    /// Times the room woke up later than it was to by more than a snapshot's period.
    pub late_ticks: u64,
    /// Those of them that were late while a thread with nothing to do was not, in that second and those beside it: what no machine that stood
    /// still explains.
    #[serde(default)]
    pub late_ticks_alone: u64,
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
}

/// Somebody whose clay is not everybody's.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Diverged {
    /// Who, and what is wrong.
    pub said: String,
}

/// What came of a run.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct RunResult {
    /// [`SCHEMA`].
    pub schema: u32,
    /// The program's version.
    pub version: String,
    /// The wire protocol's version.
    pub protocol: u16,
    /// Where it was measured.
    pub host: HostFacts,
    /// What was asked for.
    pub plan: Plan,
    /// How it ended.
    pub verdict: Verdict,
    /// Why, in sentences.
    pub said: Vec<String>,
    /// Measured time, s.
    pub measured_s: f64,
    /// From the moment at which a join was due to the welcome, however often it had to be tried; those before the measured time count as well.
    pub join_ms: Quantiles,
    /// From the moment at which an input was due to the clay that carries it.
    pub input_delta_ms: Quantiles,
    /// From the moment at which it was sent.
    pub input_delta_uncorrected_ms: Quantiles,
    /// Age of clay when it is whole.
    pub delta_age_ms: Quantiles,
    /// Corrections under the own tool, of full potters.
    pub correction_mm: Quantiles,
    /// How late sends began.
    pub schedule_lag_ms: Quantiles,
    /// How late those who only look on did what they do by the clock: so late they may read what came as well.
    #[serde(default)]
    pub look_lag_ms: Quantiles,
    /// Sends that were due, and of those the ones left out.
    pub sends: u64,
    /// See `sends`.
    pub dropped_sends: u64,
    /// Sends that found the connection's buffer full and waited for the next.
    pub held_back: u64,
    /// Datagrams from the server.
    pub datagrams: u64,
    /// UDP payload from the server, bytes.
    pub down_bytes: u64,
    /// UDP payload to the server, bytes.
    pub up_bytes: u64,
    /// Share of the packets to the server that were lost, %.
    pub up_lost_percent: f64,
    /// Requests for what was missing.
    pub asked: u64,
    /// Connections that broke on purpose and came again.
    pub reconnects: u64,
    /// Connections that broke otherwise.
    pub broken: u64,
    /// Tries to join that did not succeed, before the measured time as well.
    pub failed_joins: u64,
    /// People who were turned away and never in until the measured time was over: the figures are of the others alone.
    #[serde(default)]
    pub outside: u32,
    /// Whether somebody ended it before its time; nobody's clay was compared then.
    #[serde(default)]
    pub is_interrupted: bool,
    /// Messages that made no sense or said other than to others.
    pub unlike: u64,
    /// People whose clay was compared with the server's at the end.
    pub compared: u32,
    /// Those who differ.
    pub diverged: Vec<Diverged>,
    /// The numbers of those who could not tell what they hold.
    #[serde(default)]
    pub untold: Vec<u32>,
    /// What a spawned server counted.
    pub server: Option<ServerFigures>,
    /// Processor time of a spawned server, % of a core.
    pub server_cpu_percent: Option<f64>,
    /// Its memory at the end of the measured time, MB.
    pub server_memory_mb: Option<f64>,
    /// Processor time of the generator, % of a core.
    pub generator_cpu_percent: Option<f64>,
    /// Its memory, MB.
    pub generator_memory_mb: Option<f64>,
    /// Times that a thread with nothing to do, beside the generator, fell behind by more than a snapshot's period: the machine's part of
    /// [`ServerFigures::late_ticks`].
    #[serde(default)]
    pub bystander_late: u64,
    /// What strangers did, where any came.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub strangers: Option<StrangerFigures>,
    /// Second by second, warm-up included.
    pub seconds: Vec<Second>,
}

/// [`ServerFigures::late_ticks_alone`] of a run with these seconds.
#[must_use]
pub fn late_ticks_alone(seconds: &[Second]) -> u64 {
    let measured: Vec<_> = seconds.iter().filter(|second| second.is_measured).collect();
    // what the server tells of a second may be read in the next
    let is_alone = |at: usize| {
        let beside = &measured[at.saturating_sub(1)..measured.len().min(at + 2)];
        beside.iter().all(|second| second.bystander_late == 0)
    };
    let alone = measured.iter().enumerate().filter(|(at, _)| is_alone(*at));
    alone.filter_map(|(_, second)| second.late_ticks).sum()
}

impl RunResult {
    /// The clients' figures of a tally.
    pub fn take_in(&mut self, tally: &Tally) {
        self.join_ms = Quantiles::of(&tally.join_us, 1e-3);
        self.input_delta_ms = Quantiles::of(&tally.input_delta_us, 1e-3);
        self.input_delta_uncorrected_ms = Quantiles::of(&tally.input_delta_sent_us, 1e-3);
        self.delta_age_ms = Quantiles::of(&tally.age_us, 1e-3);
        self.correction_mm = Quantiles::of(&tally.correction_nm, 1e-6);
        self.schedule_lag_ms = Quantiles::of(&tally.lag_us, 1e-3);
        self.look_lag_ms = Quantiles::of(&tally.look_lag_us, 1e-3);
        (self.sends, self.dropped_sends, self.held_back) = (tally.sends, tally.dropped_sends, tally.held_back);
        (self.datagrams, self.down_bytes, self.up_bytes) = (tally.datagrams, tally.down_bytes, tally.up_bytes);
        self.up_lost_percent = 100.0 * tally.up_lost as f64 / tally.up_packets.max(1) as f64;
        (self.asked, self.reconnects, self.broken) = (tally.asked, tally.reconnects, tally.broken);
        (self.failed_joins, self.unlike) = (tally.failed_joins, tally.unlike);
    }

    /// A figure with quantiles by its name.
    #[must_use]
    pub fn quantiles(&self, name: &str) -> Option<Quantiles> {
        Some(match name {
            "join_ms" => self.join_ms,
            "input_delta_ms" => self.input_delta_ms,
            "input_delta_uncorrected_ms" => self.input_delta_uncorrected_ms,
            "delta_age_ms" => self.delta_age_ms,
            "correction_mm" => self.correction_mm,
            "schedule_lag_ms" => self.schedule_lag_ms,
            "look_lag_ms" => self.look_lag_ms,
            "server_wake_ms" => self.server.as_ref()?.wake_ms,
            _ => return None,
        })
    }

    /// A figure of one number by its name.
    #[must_use]
    pub fn plain(&self, name: &str) -> Option<f64> {
        Some(match name {
            "server_late_ticks" => self.server.as_ref()?.late_ticks as f64,
            "server_late_ticks_alone" => self.server.as_ref()?.late_ticks_alone as f64,
            "server_dropped_datagrams" => self.server.as_ref()?.dropped_datagrams as f64,
            "server_unheard" => self.server.as_ref()?.unheard as f64,
            "server_us_per_datagram" => self.server_us_per_datagram()?,
            "server_room_percent" => self.room_percent()?,
            "server_cpu_percent" => self.server_cpu_percent?,
            "server_memory_mb" => self.server_memory_mb?,
            "up_lost_percent" => self.up_lost_percent,
            "failed_joins" => self.failed_joins as f64,
            "broken" => self.broken as f64,
            "asked" => self.asked as f64,
            "unlike" => self.unlike as f64,
            "strangers_age_ratio" => self.strangers.as_ref()?.age_ratio(),
            _ => return None,
        })
    }

    /// Processor time of a spawned server for each datagram that came of it, µs.
    #[must_use]
    pub fn server_us_per_datagram(&self) -> Option<f64> {
        let us = self.server_cpu_percent? * 1e4 * self.measured_s;
        (self.datagrams > 0).then(|| us / self.datagrams as f64)
    }

    /// Share of the time in which the one task that owns the room was at work, %: what no second core takes over.
    #[must_use]
    pub fn room_percent(&self) -> Option<f64> {
        let wakes = self.server.as_ref()?.wake_ms;
        (self.measured_s > 0.0).then(|| wakes.mean * wakes.count as f64 * 0.1 / self.measured_s)
    }

    /// A table for a person.
    #[must_use]
    pub fn table(&self) -> String {
        let mut table = format!(
            "{:<28}{:>9}{:>9}{:>9}{:>9}{:>9}{:>9}{:>10}\n",
            "", "p50", "p90", "p95", "p99", "p99.9", "max", "count"
        );
        for name in super::threshold::WITH_QUANTILES {
            let Some(of) = self.quantiles(name).filter(|of| of.count > 0) else { continue };
            let digits = if name == "correction_mm" { 4 } else { 2 };
            let row = [of.p50, of.p90, of.p95, of.p99, of.p999, of.max].map(|value| format!("{value:>9.digits$}"));
            table.push_str(&format!("{name:<28}{}{:>10}\n", row.concat(), of.count));
        }
        let per_s = |bytes: u64| bytes as f64 * 8e-3 / self.measured_s.max(1e-9);
        table.push_str(&format!(
            "{:<28}{:.0} kbit/s from the server, {:.0} kbit/s to it, {:.2} % of packets to it lost, {} asked again\n",
            "network",
            per_s(self.down_bytes),
            per_s(self.up_bytes),
            self.up_lost_percent,
            self.asked
        ));
        table.push_str(&format!(
            "{:<28}{} came again on purpose, {} broke, {} joins failed\n",
            "connections", self.reconnects, self.broken, self.failed_joins
        ));
        let percent = |value: Option<f64>| value.map_or_else(|| "?".into(), |value| format!("{value:.1} %"));
        let mb = |value: Option<f64>| value.map_or_else(|| "?".into(), |value| format!("{value:.0} MB"));
        table.push_str(&format!(
            "{:<28}server {} of a core, {}; generator {}, {}; {}; a thread with nothing to do was late {} times\n",
            "machine",
            percent(self.server_cpu_percent),
            mb(self.server_memory_mb),
            percent(self.generator_cpu_percent),
            mb(self.generator_memory_mb),
            self.host.shared_out(),
            self.bystander_late
        ));
        if let Some(server) = &self.server {
            table.push_str(&format!(
                "{:<28}{} late ticks, {} of them alone, {} datagrams, {} of them dropped, {} keyframes asked for, {} samples refused, {} datagrams not heard\n",
                "server",
                server.late_ticks,
                server.late_ticks_alone,
                server.datagrams,
                server.dropped_datagrams,
                server.resyncs,
                server.refused_samples,
                server.unheard
            ));
        }
        if let (Some(us), Some(room)) = (self.server_us_per_datagram(), self.room_percent()) {
            table.push_str(&format!(
                "{:<28}{us:.2} us of processor time a datagram; the room's one task at work {room:.1} % of the time\n",
                "cost"
            ));
        }
        if let Some(strangers) = &self.strangers {
            table.push_str(&format!(
                "{:<28}{:.0} wrong codes a second, {:.0} of them answered; p99 age of clay {:.2} ms before and {:.2} ms under them, {:.2} times\n",
                "strangers",
                strangers.knocks_per_s,
                strangers.answered_per_s,
                strangers.quiet_age_ms.p99,
                strangers.besieged_age_ms.p99,
                strangers.age_ratio()
            ));
        }
        table.push_str(&format!(
            "{:<28}{} compared, {} differ, {} could not tell; {} sends, {} left out, {} held back\n",
            "clay and schedule",
            self.compared,
            self.diverged.len(),
            self.untold.len(),
            self.sends,
            self.dropped_sends,
            self.held_back
        ));
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn late_ticks_are_a_servers_own_where_the_bystander_was_in_time() {
        let second = |late_ticks, bystander_late, is_measured| Second {
            late_ticks: Some(late_ticks),
            bystander_late,
            is_measured,
            ..Second::default()
        };
        let before = [second(9, 0, false)];
        let quiet = [second(1, 0, true), second(0, 0, true)];
        let stalled = [second(4, 0, true), second(3, 2, true), second(5, 0, true)];
        assert_eq!(late_ticks_alone(&[&before[..], &quiet, &stalled, &quiet].concat()), 2);
        assert_eq!(late_ticks_alone(&[]), 0);
    }
}
