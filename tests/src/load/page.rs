//! A run as one page that needs nothing else: tables and charts drawn in it.
//!
//! Owns HTML and SVG; the figures are the result's.
//! Invariant: the page names no address outside of itself, and whatever text comes in is escaped.

use std::fmt::Write;

use super::knee::{Climb, Step};
use super::law::Law;
use super::result::{RunResult, Second};
use super::threshold::WITH_QUANTILES;

const WIDTH: f64 = 720.0;
const HEIGHT: f64 = 220.0;
const LEFT: f64 = 56.0;
const BOTTOM: f64 = 34.0;
const TOP: f64 = 14.0;
const COLOURS: [&str; 4] = ["#1f6f8b", "#c8553d", "#588b49", "#8f6bb3"];

/// One line of a chart.
#[derive(Clone, Debug)]
pub struct Line<'a> {
    /// What it shows.
    pub name: &'a str,
    /// `(x, y)`.
    pub points: Vec<(f64, f64)>,
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The next larger of 1, 2, 5, 10 … so that an axis has round numbers.
fn round_up(value: f64) -> f64 {
    let power = 10_f64.powf(value.max(1e-9).log10().floor());
    [1.0, 2.0, 5.0, 10.0].into_iter().map(|factor| factor * power).find(|round| *round >= value).unwrap_or(value)
}

/// A chart as SVG, with marks at some places on the x axis.
#[must_use]
pub fn chart(title: &str, x_name: &str, lines: &[Line<'_>], marks: &[(f64, &str)]) -> String {
    let points = || lines.iter().flat_map(|line| line.points.iter().copied());
    let x_max = points().map(|(x, _)| x).fold(1e-9, f64::max);
    let y_max = round_up(points().map(|(_, y)| y).fold(1e-6, f64::max));
    let at_x = |x: f64| LEFT + x / x_max * (WIDTH - LEFT - 12.0);
    let at_y = |y: f64| HEIGHT - BOTTOM - y / y_max * (HEIGHT - BOTTOM - TOP);
    let mut svg = format!(
        "<figure><figcaption>{}</figcaption><svg viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" aria-label=\"{}\">",
        escaped(title),
        escaped(title)
    );
    let mut push = |text: std::fmt::Arguments<'_>| svg.write_fmt(text).expect("a string takes everything");
    for part in 0..=4 {
        let (y, x) = (y_max * f64::from(part) / 4.0, x_max * f64::from(part) / 4.0);
        push(format_args!(
            "<line x1=\"{LEFT}\" x2=\"{}\" y1=\"{1:.1}\" y2=\"{1:.1}\" class=\"grid\"/><text x=\"{2}\" y=\"{3:.1}\" \
             class=\"y\">{y}</text><text x=\"{4:.1}\" y=\"{5}\" class=\"x\">{x:.0}</text>",
            WIDTH - 12.0,
            at_y(y),
            LEFT - 6.0,
            at_y(y) + 4.0,
            at_x(x),
            HEIGHT - BOTTOM + 14.0
        ));
    }
    push(format_args!("<text x=\"{}\" y=\"{}\" class=\"x\">{}</text>", WIDTH / 2.0, HEIGHT - 4.0, escaped(x_name)));
    for (x, name) in marks {
        push(format_args!(
            "<line x1=\"{0:.1}\" x2=\"{0:.1}\" y1=\"{TOP}\" y2=\"{1}\" class=\"mark\"/><text x=\"{0:.1}\" y=\"{2}\" \
             class=\"x\">{3}</text>",
            at_x(*x),
            HEIGHT - BOTTOM,
            TOP - 3.0,
            escaped(name)
        ));
    }
    for (line, colour) in lines.iter().zip(COLOURS.iter().cycle()) {
        push(format_args!("<polyline fill=\"none\" stroke=\"{colour}\" stroke-width=\"1.6\" points=\""));
        for (x, y) in &line.points {
            push(format_args!("{:.1},{:.1} ", at_x(*x), at_y(*y)));
        }
        push(format_args!("\"/>"));
    }
    push(format_args!("</svg><p>"));
    for (line, colour) in lines.iter().zip(COLOURS.iter().cycle()) {
        push(format_args!("<span style=\"color:{colour}\">&#9632;</span> {} &nbsp; ", escaped(line.name)));
    }
    push(format_args!("</p></figure>"));
    svg
}

fn page(title: &str, body: &str) -> String {
    format!(
        "<!doctype html><html lang=\"en\"><head><meta charset=\"utf-8\"><title>{title}</title><style>\
         body{{font:15px/1.45 system-ui,sans-serif;max-width:760px;margin:2rem auto;padding:0 1rem;color:#222}}\
         table{{border-collapse:collapse;width:100%}}td,th{{padding:.2rem .5rem;text-align:right;border-bottom:1px solid #ddd}}\
         td:first-child,th:first-child{{text-align:left}}figure{{margin:1.5rem 0}}svg{{width:100%;height:auto}}\
         .grid{{stroke:#e3e3e3}}.mark{{stroke:#c00;stroke-dasharray:4 3}}text{{font-size:11px;fill:#555}}\
         .y{{text-anchor:end}}.x{{text-anchor:middle}}pre{{overflow:auto;background:#f6f6f6;padding:.7rem}}\
         .pass{{color:#2b7a3d}}.fail{{color:#b3261e}}</style></head><body>{body}</body></html>",
        title = escaped(title)
    )
}

fn figures(result: &RunResult) -> String {
    let mut table = String::from("<table><tr><th></th>");
    for name in ["p50", "p90", "p95", "p99", "p99.9", "max", "count"] {
        table.push_str(&format!("<th>{name}</th>"));
    }
    table.push_str("</tr>");
    for name in WITH_QUANTILES {
        let Some(of) = result.quantiles(name).filter(|of| of.count > 0) else { continue };
        table.push_str(&format!("<tr><td>{name}</td>"));
        for value in [of.p50, of.p90, of.p95, of.p99, of.p999, of.max] {
            table.push_str(&format!("<td>{value:.2}</td>"));
        }
        table.push_str(&format!("<td>{}</td></tr>", of.count));
    }
    table + "</table>"
}

fn verdict(result: &RunResult) -> String {
    let class = if result.verdict.code() == 0 { "pass" } else { "fail" };
    let said: String = result.said.iter().map(|said| format!("<li>{}</li>", escaped(said))).collect();
    format!("<p class=\"{class}\"><strong>{}</strong></p><ul>{said}</ul>", result.verdict.name())
}

fn about(result: &RunResult) -> String {
    let (plan, host) = (&result.plan, &result.host);
    format!(
        "<p>{} – {} potters and {} who look on at {} wheels for {:.0} s, seed {}. {} ({} cores, load before {}), server and \
         generator {}, {}, {} build, protocol {}.</p>",
        escaped(&plan.name),
        plan.potters,
        plan.spectators,
        plan.used(),
        result.measured_s,
        plan.seed,
        escaped(&host.processor),
        host.cores,
        escaped(&host.load_before),
        host.shared_out(),
        escaped(&host.system),
        if host.is_release { "release" } else { "debug" },
        result.protocol
    )
}

/// The page of a run.
#[must_use]
pub fn of_run(result: &RunResult) -> String {
    let over = |name, value: fn(&Second) -> f64| Line {
        name,
        points: result.seconds.iter().map(|second| (second.at_s, value(second))).collect(),
    };
    let begins_s = result.plan.ramp_s + result.plan.warmup_s;
    let marks = [(begins_s, "measured from here")];
    let seconds = "seconds";
    let body = format!(
        "<h1>Load test</h1>{}{}{}{}{}{}{}{}<h2>All figures</h2><pre>{}</pre>",
        about(result),
        verdict(result),
        figures(result),
        chart(
            "From due input to clay, and age of clay, ms",
            seconds,
            &[
                over("input p50", |second| second.input_delta_p50_ms),
                over("input p99", |second| second.input_delta_p99_ms),
                over("age p99", |second| second.delta_age_p99_ms),
                over("generator's lag p99", |second| second.schedule_lag_p99_ms),
            ],
            &marks
        ),
        chart(
            "Processor, % of a core",
            seconds,
            &[
                over("server", |second| second.server_cpu_percent.unwrap_or_default()),
                over("generator", |second| second.generator_cpu_percent.unwrap_or_default()),
            ],
            &marks
        ),
        chart(
            "Network, kbit/s",
            seconds,
            &[over("from the server", |second| second.down_kbit_s), over("to the server", |second| second.up_kbit_s)],
            &marks
        ),
        chart(
            "People, and memory of the server in MB",
            seconds,
            &[
                over("people", |second| second.people as f64),
                over("memory", |second| second.server_memory_mb.unwrap_or_default()),
            ],
            &marks
        ),
        chart(
            "Times late by more than a snapshot's period",
            seconds,
            &[
                over("server", |second| second.late_ticks.unwrap_or_default() as f64),
                over("a thread with nothing to do", |second| second.bystander_late as f64),
            ],
            &marks
        ),
        escaped(&result.table())
    );
    page("Load test", &body)
}

/// The page of a climb to the knee.
#[must_use]
pub fn of_climb(climb: &Climb) -> String {
    let over = |name, value: fn(&Step) -> f64| Line {
        name,
        points: climb.steps.iter().map(|step| (f64::from(step.people), value(step))).collect(),
    };
    let marks: Vec<_> = climb.knee.map(|knee| (f64::from(knee), "knee")).into_iter().collect();
    let body = format!(
        "<h1>Where it breaks</h1>{}<p>{}</p>{}{}<pre>{}</pre>",
        climb.first.as_ref().map(about).unwrap_or_default(),
        escaped(&climb.sentence()),
        chart(
            "99th percentiles, ms",
            &climb.raises,
            &[over("input to clay", |step| step.input_delta_p99_ms), over("age of clay", |step| step.delta_age_p99_ms)],
            &marks
        ),
        chart(
            "Processor of the server, % of a core",
            &climb.raises,
            &[over("server", |step| step.server_cpu_percent)],
            &marks
        ),
        escaped(&climb.table())
    );
    page("Where it breaks", &body)
}

/// The page of a law.
#[must_use]
pub fn of_law(law: &Law) -> String {
    let of = |cost: usize| {
        let mut points: Vec<_> =
            law.loads.iter().map(|load| (law.fits[cost].of_load(&load.counts), load.costs[cost])).collect();
        points.sort_by(|left, right| left.0.total_cmp(&right.0));
        points
    };
    let against = |name, cost| {
        let told = of(cost).iter().map(|&(told, _)| (told, told)).collect();
        chart(
            name,
            "by the law",
            &[Line { name: "measured", points: of(cost) }, Line { name: "by the law", points: told }],
            &[],
        )
    };
    let body = format!(
        "<h1>What each costs</h1>{}<p>{}</p>{}{}<pre>{}</pre>",
        law.first.as_ref().map(about).unwrap_or_default(),
        escaped(&law.sentence()),
        against("Processor of the server, % of a core", 0),
        against("Memory of the server, MB", 1),
        escaped(&law.table())
    );
    page("What each costs", &body)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn axes_end_at_round_numbers() {
        assert_eq!([0.7, 1.0, 1.4, 3.0, 70.0].map(round_up), [1.0, 1.0, 2.0, 5.0, 100.0]);
    }

    #[test]
    fn text_cannot_leave_its_place() {
        let line = Line { name: "<script>", points: vec![(0.0, 1.0), (1.0, 2.0)] };
        let svg = chart("a & b", "\"x\"", &[line], &[(0.5, "<")]);
        assert!(svg.contains("a &amp; b") && svg.contains("&lt;script&gt;") && !svg.contains("<script"));
    }
}
