//! The histogram of a measured hand as a drawing in SVG.
//!
//! Owns the sheet and its axes.
//! Invariant: every row of the table has its place, and what is empty has no bar.

use std::fmt::Write as _;

use pottery_client::Pacing;

use super::figures::{Figures, LAST_US, ROW_US};

/// Where the drawing stands on its sheet, and the sheet.
const LEFT: f64 = 70.0;
const TOP: f64 = 70.0;
const WIDTH: f64 = 804.0;
const HEIGHT: f64 = 320.0;
const SHEET: (f64, f64) = (910.0, 450.0);
/// Blue and vermilion, which people with any kind of colour blindness tell apart (Okabe and Ito 2008).
const PERIOD: &str = "#0072b2";
const WORK: &str = "#d55e00";

/// Bars of both times over a logarithmic scale of counts, with the border beyond which a tick is late.
pub(super) fn histogram(figures: &Figures) -> String {
    let rows = figures.rows();
    let most = rows.iter().map(|row| row.1.max(row.2)).max().unwrap_or(1).max(10) as f64;
    let decades = most.log10().ceil();
    let x = |us: u64| LEFT + WIDTH * us as f64 / (LAST_US + ROW_US) as f64;
    let y = |count: f64| TOP + HEIGHT * (1.0 - (0.5 + count.log10()) / (0.5 + decades)).min(1.0);
    let bottom = TOP + HEIGHT;
    let mut text = format!(
        r##"<?xml version="1.0" encoding="UTF-8"?>
<svg xmlns="http://www.w3.org/2000/svg" width="{}" height="{}" viewBox="0 0 {0} {1}" font-family="sans-serif" font-size="13" fill="#202020">
<rect width="100%" height="100%" fill="#ffffff"/>
<text x="{LEFT}" y="26" font-size="16">{} ticks beside {}: {:.3} % late by more than 200 µs</text>
<text x="{LEFT}" y="48"><tspan fill="{PERIOD}">from tick to tick</tspan> and <tspan fill="{WORK}">work of a tick</tspan>; {}</text>
"##,
        SHEET.0,
        SHEET.1,
        figures.ticks,
        figures.beside,
        figures.late_share() * 1e2,
        figures.granted.split(';').next().unwrap_or_default(),
    );
    let mut draw = |line: String| writeln!(text, "{line}").expect("a text in memory can be written");
    for decade in 0..=decades as u32 {
        let at = y(10_f64.powi(decade as i32));
        draw(format!(r##"<path d="M{LEFT} {at:.1}h{WIDTH}" stroke="#e2e2e2"/>"##));
        draw(format!(
            r##"<text x="{:.1}" y="{:.1}" text-anchor="end">{}</text>"##,
            LEFT - 8.0,
            at + 4.0,
            10_u64.pow(decade)
        ));
    }
    for us in (0..=LAST_US).step_by(200) {
        draw(format!(r##"<text x="{:.1}" y="{:.1}" text-anchor="middle">{us}</text>"##, x(us), bottom + 20.0));
    }
    let middle = LEFT + 0.5 * WIDTH;
    draw(format!(
        r##"<text x="{middle}" y="{}" text-anchor="middle">µs; the last bar is all that is longer</text>"##,
        bottom + 44.0
    ));
    for (colour, periods) in [(PERIOD, true), (WORK, false)] {
        for &(from_us, period, work) in &rows {
            let count = if periods { period } else { work };
            if count > 0 {
                let (at, width) = (x(from_us), x(ROW_US) - LEFT);
                let top = y(count as f64);
                let height = bottom - top;
                draw(format!(
                    r##"<rect x="{at:.2}" y="{top:.2}" width="{width:.2}" height="{height:.2}" fill="{colour}" fill-opacity="0.8"/>"##
                ));
            }
        }
    }
    let late = x((figures.period + Pacing::LATE).as_micros() as u64);
    draw(format!(r##"<path d="M{late:.1} {TOP}V{bottom}" stroke="#202020" stroke-dasharray="5 4"/>"##));
    draw(format!(r##"<path d="M{LEFT} {bottom}h{WIDTH}" stroke="#202020"/>"##));
    text.push_str("</svg>\n");
    text
}
