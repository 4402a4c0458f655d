//! The session's figures: `session.json` and the summary for people.
//!
//! Owns the schema; measures nothing itself. Histograms of all potters are added up, so that a percentile is one of all
//! their ticks.
//! Invariant: the file and the summary are made from the same numbers.

use pottery_client::{PotterReport, WatchReport};
use pottery_server::Standing;
use pottery_shared::clay::Material;
use pottery_shared::snapshot::Detail;
use pottery_shared::units::Tick;
use serde::Serialize;

type Histogram = hdrhistogram::Histogram<u64>;

/// `session.json`, schema 1.
#[derive(Debug, Serialize)]
pub(crate) struct SessionReport {
    schema: u32,
    elements: usize,
    seconds: f64,
    potters: usize,
    clay: Clay,
    haptic: Haptic,
    network: Network,
    watching: Vec<Watching>,
    prediction_error_mm: Spread,
    digest: Digests,
    pressed_volume_mm3: f64,
    server: ServerFigures,
}

/// What the clay was made of at the end, as the first client knew it.
#[derive(Debug, Serialize)]
struct Clay {
    wetness: f64,
    yield_kpa: f64,
    youngs_mpa: f64,
    viscosity_ms: f64,
}

#[derive(Debug, Serialize)]
struct Haptic {
    /// What the system granted the first hand's thread.
    priority: String,
    ticks: u64,
    late_ticks: u64,
    missed_ticks: u64,
    period_us: Percentiles,
    step_us: Percentiles,
    force_n: Force,
}

#[derive(Debug, Serialize)]
struct Percentiles {
    p50: f64,
    p99: f64,
    p999: f64,
    max: f64,
}

#[derive(Debug, Serialize)]
struct Force {
    p50: f64,
    max: f64,
}

#[derive(Debug, Serialize)]
struct Network {
    down_bytes_per_s_per_client: f64,
    up_bytes_per_s_per_client: f64,
    rtt_ms: Spread,
    mismatches: u64,
    mended_tiles: u64,
    repeats: u64,
    resyncs: u64,
    retold_snapshots: u64,
    delta_snapshots: u64,
    malformed: u64,
    implausible: u64,
    unsent_datagrams: u64,
}

/// One who looked on.
#[derive(Debug, Serialize)]
struct Watching {
    detail: &'static str,
    down_bytes_per_s: f64,
    up_bytes_per_s: f64,
    mismatches: u64,
    mended_tiles: u64,
    retold: u64,
    asked: u64,
    malformed: u64,
    implausible: u64,
}

#[derive(Debug, Serialize)]
struct Spread {
    p50: f64,
    p99: f64,
    max: f64,
}

#[derive(Debug, Serialize)]
struct Digests {
    server: String,
    clients: Vec<String>,
}

#[derive(Debug, Serialize)]
struct ServerFigures {
    ticks: u64,
    late: u64,
    dropped_datagrams: u64,
    refused_samples: RefusedSamples,
}

#[derive(Debug, Serialize)]
struct RefusedSamples {
    malformed: u64,
    out_of_workspace: u64,
    too_fast: u64,
    from_the_past: u64,
    from_the_future: u64,
    flood: u64,
    requests: u64,
}

fn merged<'a>(mut parts: impl Iterator<Item = &'a Histogram>) -> Histogram {
    let mut sum = parts.next().cloned().unwrap_or_else(|| Histogram::new(3).expect("three digits are valid"));
    for part in parts {
        sum.add(part).expect("all potters' histograms have the same bounds");
    }
    sum
}

fn percentiles(histogram: &Histogram, scale: f64) -> Percentiles {
    let at = |quantile| histogram.value_at_quantile(quantile) as f64 * scale;
    Percentiles { p50: at(0.5), p99: at(0.99), p999: at(0.999), max: histogram.max() as f64 * scale }
}

fn spread(histogram: &Histogram, scale: f64) -> Spread {
    let at = |quantile| histogram.value_at_quantile(quantile) as f64 * scale;
    Spread { p50: at(0.5), p99: at(0.99), max: histogram.max() as f64 * scale }
}

/// A material in the units of the file, to four decimals.
fn clay(material: Material) -> Clay {
    let rounded = |value: f32| (f64::from(value) * 1e4).round() / 1e4;
    Clay {
        wetness: rounded(material.wetness().liquidity_index()),
        yield_kpa: rounded(material.strength.yield_pa * 1e-3),
        youngs_mpa: rounded(material.strength.youngs_pa * 1e-6),
        viscosity_ms: rounded(material.viscosity.0 * 1e3),
    }
}

fn watching((detail, report): &(Detail, WatchReport)) -> Watching {
    let rate = |bytes: u64| (bytes as f64 / report.duration.as_secs_f64()).round();
    Watching {
        detail: match detail {
            detail if detail.shows_tools() => "spectator",
            _ => "gallery",
        },
        down_bytes_per_s: rate(report.down_bytes),
        up_bytes_per_s: rate(report.up_bytes),
        mismatches: report.mismatches,
        mended_tiles: report.mended_tiles,
        retold: report.retold,
        asked: report.asked,
        malformed: report.malformed,
        implausible: report.implausible.total(),
    }
}

fn hexadecimal(digest: u64) -> String {
    format!("{digest:016x}")
}

impl SessionReport {
    /// Adds up what potters and server measured.
    pub(crate) fn new(
        seconds: f64,
        reports: &[PotterReport],
        watched: &[(Detail, WatchReport)],
        server: &Standing,
    ) -> Self {
        let haptic = || reports.iter().filter_map(|report| report.haptic.as_ref());
        let network = || reports.iter().map(|report| &report.network);
        let rate = |bytes: fn(&pottery_client::NetworkReport) -> u64| {
            network().map(|part| bytes(part) as f64 / part.duration.as_secs_f64()).sum::<f64>() / reports.len() as f64
        };
        let force = merged(haptic().map(|part| &part.force_mn));
        let refusals = &server.counts.refusals;
        let pressed_m3 = server.pots[0].pressed_m3();
        Self {
            schema: 1,
            elements: server.pots[0].spec().shape.elements(),
            seconds,
            potters: reports.len(),
            clay: clay(reports[0].view.conditions.material.at(Tick(server.ticks))),
            haptic: Haptic {
                priority: reports[0].granted.to_string(),
                ticks: haptic().map(|part| part.ticks).sum(),
                late_ticks: haptic().map(|part| part.late_ticks).sum(),
                missed_ticks: haptic().map(|part| part.missed_ticks).sum(),
                period_us: percentiles(&merged(haptic().map(|part| &part.period_ns)), 1e-3),
                step_us: percentiles(&merged(haptic().map(|part| &part.step_ns)), 1e-3),
                force_n: Force { p50: force.value_at_quantile(0.5) as f64 * 1e-3, max: force.max() as f64 * 1e-3 },
            },
            network: Network {
                down_bytes_per_s_per_client: rate(|part| part.down_bytes).round(),
                up_bytes_per_s_per_client: rate(|part| part.up_bytes).round(),
                rtt_ms: spread(&merged(network().map(|part| &part.round_trip_us)), 1e-3),
                mismatches: network().map(|part| part.mismatches + part.steps.unlike).sum(),
                mended_tiles: network().map(|part| part.mends.tiles).sum(),
                retold_snapshots: network().map(|part| part.steps.retold).sum(),
                delta_snapshots: network().map(|part| part.steps.deltas).sum(),
                repeats: network().map(|part| part.repeats).sum(),
                resyncs: network().map(|part| part.resyncs).sum(),
                malformed: network().map(|part| part.malformed).sum(),
                implausible: network().map(|part| part.implausible.total()).sum(),
                unsent_datagrams: network().map(|part| part.unsent).sum(),
            },
            watching: watched.iter().map(watching).collect(),
            prediction_error_mm: spread(&merged(network().map(|part| &part.correction_nm)), 1e-6),
            digest: Digests {
                server: hexadecimal(server.digests[0]),
                clients: reports.iter().map(|report| hexadecimal(report.view.digest)).collect(),
            },
            pressed_volume_mm3: (pressed_m3 * 1e9).round(),
            server: ServerFigures {
                ticks: server.ticks,
                late: server.late,
                dropped_datagrams: server.dropped_datagrams,
                refused_samples: RefusedSamples {
                    malformed: refusals.malformed,
                    out_of_workspace: refusals.out_of_workspace,
                    too_fast: refusals.too_fast,
                    from_the_past: refusals.from_the_past,
                    from_the_future: refusals.from_the_future,
                    flood: refusals.flood,
                    requests: refusals.requests,
                },
            },
        }
    }

    /// The clients whose clay is not the server's, numbered from 1.
    pub(crate) fn diverged(&self) -> Vec<usize> {
        let differs = |digest: &String| *digest != self.digest.server;
        (1..).zip(&self.digest.clients).filter(|(_, digest)| differs(digest)).map(|(number, _)| number).collect()
    }

    /// A short summary for people.
    pub(crate) fn summary(&self) -> String {
        let Haptic { priority, ticks, late_ticks, period_us, step_us, force_n, .. } = &self.haptic;
        let network = &self.network;
        let error = &self.prediction_error_mm;
        let clay = &self.clay;
        let agreement = match self.diverged().as_slice() {
            [] => format!("all {} clients hold the server's clay ({})", self.potters, self.digest.server),
            numbers => format!("clients {numbers:?} do NOT hold the server's clay"),
        };
        let watching: String = self
            .watching
            .iter()
            .map(|one| format!("watching   as {}: down {:.1} kB/s\n", one.detail, one.down_bytes_per_s * 1e-3))
            .collect();
        format!(
            "potters    {} for {:.1} s on {} elements, {:.1} cm³ pressed away\n\
             clay       wetness {:.2}: yields at {:.1} kPa, E {:.2} MPa, gives way in {:.0} ms\n\
             hand       {ticks} ticks, {:.2} % late; period p50 {:.0} µs, p99 {:.0} µs; \
             a tick's work p50 {:.0} µs, p99 {:.0} µs\n\
             thread     {priority}\n\
             force      p50 {:.2} N, max {:.2} N\n\
             network    down {:.1} kB/s, up {:.1} kB/s a client; round trip p50 {:.2} ms\n\
             {watching}prediction p50 {:.4} mm, p99 {:.4} mm, max {:.4} mm off under own tools\n\
             agreement  {agreement}",
            self.potters,
            self.seconds,
            self.elements,
            self.pressed_volume_mm3 * 1e-3,
            clay.wetness,
            clay.yield_kpa,
            clay.youngs_mpa,
            clay.viscosity_ms,
            *late_ticks as f64 * 100.0 / (*ticks).max(1) as f64,
            period_us.p50,
            period_us.p99,
            step_us.p50,
            step_us.p99,
            force_n.p50,
            force_n.max,
            network.down_bytes_per_s_per_client * 1e-3,
            network.up_bytes_per_s_per_client * 1e-3,
            network.rtt_ms.p50,
            error.p50,
            error.p99,
            error.max,
        )
    }
}
