//! The pictures of the network: what is felt wrongly, what a byte shows, and what codecs take.
//!
//! Owns the sheets; the figures come measured.
//! Invariant: a loss, a rate and a session keep their colour over a whole sheet.

use super::codecs::{CodecFigures, Scheme};
use super::prediction::{Overlap, PredictionFigures};
use super::subscription::SubscriptionFigures;
use crate::chart::ChartError;
use crate::chart::panel::{Axis, Labels, Look, Panel, Sign};
use crate::chart::pictures::{cell, sheet};

/// What each figure has, in the order in which it comes first.
fn distinct<T: PartialEq>(all: impl Iterator<Item = T>) -> Vec<T> {
    let mut found = Vec::new();
    for one in all {
        if !found.contains(&one) {
            found.push(one);
        }
    }
    found
}

/// Error under the tool over way and back, a diagram for each overlap.
pub(super) fn prediction(figures: &[PredictionFigures]) -> Result<Vec<u8>, ChartError> {
    let losses = distinct(figures.iter().map(|figures| figures.case.loss_percent));
    let mut entries = Vec::new();
    for (row, loss) in losses.iter().enumerate() {
        entries.push((Sign::Marked(Look::of_row(row)), format!("{loss} % lost: p99")));
        entries.push((Sign::Dashed(Look::of_row(row).colour), "median".to_owned()));
        entries.push((Sign::Dots(Look::of_row(row).colour), "largest".to_owned()));
    }
    let (canvas, room) = sheet(
        "How far the clay under a hand is from the room's: lower is better",
        &entries,
        "Largest error under the tool at each snapshot, against the clay that the room had at the same tick, or once it had pressed what came \
         later: two hands with our clay, a wheel at 60 rpm, the studio's own client and server. Apart: the other tool is 60 mm above. Near: \
         16 mm above and a quarter of a turn away. Overlapping: at the same height and 15 mm away. Losses come in bursts of 40 ms. Alone nothing is \
         off, whatever is lost.",
    );
    let overlaps: Vec<Overlap> = distinct(figures.iter().map(|figures| figures.case.overlap));
    let most = figures.iter().map(|figures| figures.worst_mm[2]).fold(0.05, f64::max) * 1.1;
    for (column, overlap) in overlaps.iter().enumerate() {
        let x = Axis::log("way and back, ms", figures.iter().map(|figures| f64::from(figures.case.round_trip_ms)));
        let y = Axis::linear(if column == 0 { "error under the tool, mm" } else { "" }, 0.0, most);
        let panel = Panel::new(&canvas, cell(room, (column, overlaps.len()), (0, 1)), overlap.title(), x, y);
        for (row, loss) in losses.iter().enumerate() {
            let own = || figures.iter().filter(|of| of.case.overlap == *overlap && of.case.loss_percent == *loss);
            let line = |which: usize| -> Vec<[f64; 2]> {
                own().map(|figures| [f64::from(figures.case.round_trip_ms), figures.worst_mm[which]]).collect()
            };
            panel.dashed(&line(0), Look::of_row(row).colour, 2.0);
            panel.line(&line(1), Look::of_row(row).colour, 2.5);
            panel.marks(&line(1), Look::of_row(row));
            panel.dots(&line(2), Look::of_row(row).colour);
        }
    }
    canvas.into_png().map_err(|source| ChartError::Picture { name: "prediction.png", source })
}

/// Error against bytes, a line for each rate and a row of diagrams for each session.
pub(super) fn subscription(figures: &[SubscriptionFigures]) -> Result<Vec<u8>, ChartError> {
    let rates = distinct(figures.iter().map(|figures| figures.rate_hz));
    let entries = rates.iter().enumerate();
    let entries: Vec<_> =
        entries.map(|(row, rate)| (Sign::Marked(Look::of_row(row)), format!("{rate:.0} times a second"))).collect();
    let sessions = distinct(figures.iter().map(|figures| figures.session.as_str()));
    let (canvas, room) = sheet(
        "What a byte shows of the clay: to the left and down is better",
        &entries,
        &format!(
            "Recorded sessions on a wheel at 60 rpm: {}; 360 × 400 elements. Off: what a viewer sees against the room's clay, at all \
             times and over all elements that are ever pressed; on a line without delay or loss. Numbers at the marks: the quantum, µm. The room \
             itself rounds to 3.8 µm.",
            sessions.join("; ")
        ),
    );
    let panels = sessions.iter().enumerate().flat_map(|(row, session)| [(row, *session, 0), (row, *session, 1)]);
    for (row, session, which) in panels {
        let x = Axis::log("bytes a second", figures.iter().map(|figures| figures.bytes_per_s));
        let off = || figures.iter().map(|figures| figures.error_um[which]);
        let (heading, y) = match which {
            0 => ("root of the mean square", Axis::log("off, µm", off())),
            _ => ("largest", Axis::linear("", 0.0, off().fold(1.0, f64::max) * 1.1)),
        };
        let own = || figures.iter().filter(|figures| figures.session == session);
        let within = cell(room, (which, 2), (row, sessions.len()));
        let panel = Panel::new(&canvas, within, &format!("{session}: {heading}"), x, y);
        let mut labels = Labels::new(&panel);
        let lines: Vec<Vec<[f64; 2]>> = rates
            .iter()
            .map(|rate| {
                let own = own().filter(|figures| figures.rate_hz == *rate);
                own.map(|figures| [figures.bytes_per_s, figures.error_um[which]]).collect()
            })
            .collect();
        for (row, line) in lines.iter().enumerate() {
            panel.line(line, Look::of_row(row).colour, 2.5);
            panel.marks(line, Look::of_row(row));
            labels.spare_line(&panel.places(line));
            labels.spare_marks(panel.places(line));
        }
        for (row, rate) in rates.iter().enumerate() {
            for figures in own().filter(|figures| figures.rate_hz == *rate) {
                for at in panel.places(&[[figures.bytes_per_s, figures.error_um[which]]]) {
                    labels.write(at, &format!("{:.0}", figures.quantum_um), Look::of_row(row).colour);
                }
            }
        }
    }
    canvas.into_png().map_err(|source| ChartError::Picture { name: "subscription.png", source })
}

/// Bytes a snapshot, a row for each scheme.
pub(super) fn codecs(figures: &[CodecFigures]) -> Result<Vec<u8>, ChartError> {
    let sessions = distinct(figures.iter().map(|figures| figures.session.as_str()));
    let entries = sessions.iter().enumerate();
    let entries: Vec<_> = entries.map(|(row, name)| (Sign::Marked(Look::of_row(row)), (*name).to_owned())).collect();
    let (canvas, room) = sheet(
        "What a snapshot takes in several codecs: to the left is better",
        &entries,
        "Recorded sessions, 360 × 400 elements, 60 snapshots a second to 3.8 µm; the mean of those in which anything changed. Entropies are bounds: \
         what a coder would take that knew beforehand how often each symbol occurs.",
    );
    let names: Vec<String> = Scheme::ALL.iter().map(|scheme| scheme.title().to_owned()).collect();
    let x = Axis::log("bytes a snapshot", figures.iter().map(|figures| figures.bytes));
    let panel = Panel::new(&canvas, room, "", x, Axis::names(names));
    for (row, session) in sessions.iter().enumerate() {
        let own = figures.iter().filter(|figures| figures.session == *session);
        let place = |scheme: Scheme| Scheme::ALL.iter().position(|other| *other == scheme).unwrap_or_default();
        let points: Vec<_> = own.map(|figures| [figures.bytes, place(figures.scheme) as f64]).collect();
        panel.marks(&points, Look::of_row(row));
    }
    canvas.into_png().map_err(|source| ChartError::Picture { name: "codecs.png", source })
}
