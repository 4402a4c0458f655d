//! The chart's pictures.
//!
//! Owns what each picture shows and where it stands on the sheet; figures come measured, places from [`super::panel`].
//! Invariant: a method has the same colour and mark in every picture, and the reference is always black.

use egui::{Align2, Rect, Vec2, pos2};

use super::canvas::{Canvas, FRAME, INK};
use super::cases::{BASE, CaseFigures, Support};
use super::convergence::{ConvergenceFigures, Varied};
use super::entrant::ENTRANTS;
use super::panel::{Axis, Labels, Look, Panel, Sign, legend};
use super::{ChartError, Figures, force, helix, lathe};
use crate::reference::Profile;

const WIDTH: usize = 1400;
const HEIGHT: usize = 900;
const MARGIN: f32 = 20.0;

type Draw = fn(&Figures) -> Result<Canvas, ChartError>;

/// Every picture and its file.
pub(super) const ALL: [(&str, Draw); 9] = [
    ("methods.png", |figures| Ok(methods(figures))),
    ("cases.png", |figures| Ok(cases(figures))),
    ("profiles.png", |figures| profiles(figures, Support::Backed)),
    ("profiles-hollow.png", |figures| profiles(figures, Support::Hollow)),
    ("profiles-finger.png", |figures| profiles(figures, Support::Finger)),
    ("force.png", forces),
    ("convergence.png", |figures| Ok(convergence(figures))),
    ("helix.png", |figures| Ok(thread(figures))),
    ("lathe.png", |figures| Ok(lathe::picture(figures))),
];

/// A sheet with its heading, a legend and a line of small print; returns the room that is left.
pub(super) fn sheet(heading: &str, entries: &[(Sign, String)], small: &str) -> (Canvas, Rect) {
    let canvas = Canvas::new(WIDTH, HEIGHT);
    let width = WIDTH as f32 - 2.0 * MARGIN;
    let heading = canvas.text(pos2(MARGIN, MARGIN - 4.0), Align2::LEFT_TOP, heading, 26.0, INK);
    let top = legend(&canvas, pos2(MARGIN, heading.max.y + 20.0), width, entries);
    let size = canvas.paragraph_size(width, small, 15.0);
    let bottom = HEIGHT as f32 - 12.0 - size.y;
    canvas.paragraph(pos2(MARGIN, bottom), width, small, 15.0);
    (canvas, Rect::from_min_max(pos2(MARGIN - 8.0, top), pos2(WIDTH as f32 - MARGIN, bottom - 6.0)))
}

/// Legend of the rows of the table that have figures.
fn rows(present: impl Fn(usize) -> bool) -> Vec<(Sign, String)> {
    let shown = ENTRANTS.iter().enumerate().filter(|(row, _)| present(*row));
    shown.map(|(row, entrant)| (Sign::Marked(Look::of_row(row)), entrant.title.to_owned())).collect()
}

/// A part of a rectangle that is cut into columns and rows.
pub(super) fn cell(within: Rect, (column, columns): (usize, usize), (row, rows): (usize, usize)) -> Rect {
    let size = Vec2::new(within.width() / columns as f32, within.height() / rows as f32);
    Rect::from_min_size(within.min + Vec2::new(size.x * column as f32, size.y * row as f32), size)
}

fn methods(figures: &Figures) -> Canvas {
    let points = &figures.methods;
    let mut entries = rows(|row| points.iter().any(|point| point.row == row));
    entries.push((Sign::Line(FRAME), "thin line: from the median to p99, of the methods".to_owned()));
    let (canvas, room) = sheet(
        "Time of a step against error: to the left and down is better",
        &entries,
        &format!(
            "Error: RMS difference to the finite-element dent that stays, backed wall, mean of 1 and 2 mm travel of a 12 mm \
             sphere; whoever keeps no dent has 13.9 %. Time: the sphere goes round once a second, 2 mm deep, through fresh \
             clay; yardsticks are pressed in. Numbers: columns × rows of the grid. {}",
            figures.machine.sentence()
        ),
    );
    let longest = |point: &super::speed::MethodFigures| point.times.map_or(point.p50_us, |times| times.p99_us);
    let x = Axis::log("time of a step, µs", points.iter().flat_map(|point| [point.p50_us, longest(point)]));
    let y = Axis::log("RMS error of the dent, % of its depth", points.iter().map(|point| point.permanent * 100.0));
    let panel = Panel::new(&canvas, room, "", x, y);
    let mut labels = Labels::new(&panel);
    for (row, _) in ENTRANTS.iter().enumerate() {
        let own: Vec<_> = points.iter().filter(|point| point.row == row).collect();
        let line: Vec<[f64; 2]> = own.iter().map(|point| [point.p50_us, point.permanent * 100.0]).collect();
        let look = Look::of_row(row);
        for point in &own {
            let height = point.permanent * 100.0;
            let tail = [[point.p50_us, height], [longest(point), height]];
            panel.line(&tail, look.colour.gamma_multiply(0.6), 1.5);
            labels.spare_line(&panel.places(&tail));
        }
        panel.line(&line, look.colour, 2.5);
        panel.marks(&line, look);
        labels.spare_line(&panel.places(&line));
        labels.spare_marks(panel.places(&line));
    }
    for point in points {
        for at in panel.places(&[[point.p50_us, point.permanent * 100.0]]) {
            let text = format!("{} × {}", point.grid.columns(), point.grid.rows());
            labels.write(at, &text, Look::of_row(point.row).colour);
        }
    }
    canvas
}

fn cases(figures: &Figures) -> Canvas {
    let all = &figures.cases;
    let (canvas, room) = sheet(
        "Error of every reference case: to the left is better",
        &rows(|row| all.iter().any(|figures| figures.row == row)),
        "RMS difference to the finite-element dent over 30 mm × 30 mm, over the travel. Base: 12 mm sphere, pot of \
         60 mm radius and 8 mm wall, E = 2 MPa, yield 40 kPa. A mark at 0.1 % may be below it.",
    );
    for (column, (heading, release)) in [("under the tool", false), ("what stays", true)].into_iter().enumerate() {
        let own: Vec<_> = all.iter().filter(|figures| figures.case.release == release).collect();
        let mut titles: Vec<String> = Vec::new();
        for figures in &own {
            let title = figures.case.title();
            if !titles.contains(&title) {
                titles.push(title);
            }
        }
        let x = Axis::log("RMS error, % of the depth", [0.15, 70.0]);
        let panel = Panel::new(&canvas, cell(room, (column, 2), (0, 1)), heading, x, Axis::names(titles.clone()));
        for figures in own.iter().rev() {
            let place = titles.iter().position(|title| *title == figures.case.title()).unwrap_or(0);
            panel.marks(&[[(figures.error * 100.0).clamp(0.1, 100.0), place as f64]], Look::of_row(figures.row));
        }
    }
    canvas
}

/// One of the two ways along which a dent is cut.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Cut {
    Height,
    Round,
}

fn profiles(figures: &Figures, support: Support) -> Result<Canvas, ChartError> {
    let own: Vec<&CaseFigures> = figures
        .cases
        .iter()
        .filter(|figures| figures.case.support == support && figures.case.scene == BASE && figures.case.depth_mm <= 2)
        .collect();
    let mut cases: Vec<_> = own.iter().map(|figures| figures.case).collect();
    cases.dedup_by_key(|case| (case.depth_mm, case.release));
    let shown = own.first().map_or(0, |first| own.iter().filter(|figures| figures.row == first.row).count());
    cases.truncate(shown);
    let mut entries = vec![(Sign::Dots(INK), "finite elements".to_owned())];
    let lines = rows(|row| own.iter().any(|figures| figures.row == row));
    entries.extend(lines.into_iter().map(|(sign, text)| match sign {
        Sign::Marked(look) => (Sign::Line(look.colour), text),
        other => (other, text),
    }));
    let (what, small) = described(support);
    let (canvas, room) = sheet(&format!("Dents of a 12 mm sphere in {what}"), &entries, small);
    for (column, case) in cases.iter().enumerate() {
        let reference = case.reference()?;
        for (line, cut) in [Cut::Height, Cut::Round].into_iter().enumerate() {
            let depth_mm = f64::from(case.depth_mm);
            let y = Axis::linear("radial displacement, mm", -1.15 * depth_mm, 0.3 * depth_mm);
            let title = if cut == Cut::Height { "height above the tool, mm" } else { "angle from the tool, degrees" };
            let (from, to) = stretch(cut, support);
            let dots = if support == Support::Hollow { 90 } else { 40 };
            let x = Axis::linear(title, from, to);
            let heading = format!("{} mm, {}", case.depth_mm, case.state());
            let part = cell(room, (column, cases.len()), (line, 2));
            let panel = Panel::new(&canvas, part, if line == 0 { &heading } else { "" }, x, y);
            let along = |count: u32, radial_mm: &dyn Fn(f64, f64) -> f64| -> Vec<[f64; 2]> {
                let figures = (0..=count).map(|part| from + (to - from) * f64::from(part) / f64::from(count));
                figures.map(|at| [at, cut_mm(cut, at, radial_mm)]).collect()
            };
            // the first row of the table last, on top
            for figures in own
                .iter()
                .rev()
                .filter(|figures| figures.case.depth_mm == case.depth_mm && figures.case.release == case.release)
            {
                let points = along(400, &|angle, z_mm| figures.dented.radial_mm_at(angle, z_mm));
                panel.line(&points, Look::of_row(figures.row).colour, 2.2);
            }
            panel.dots(&along(dots, &|angle, z_mm| Profile::radial_mm(&reference, angle, z_mm)), INK);
        }
    }
    Ok(canvas)
}

/// The wall and what the reader should know of the comparison.
const fn described(support: Support) -> (&'static str, &'static str) {
    match support {
        Support::Backed => (
            "a wall that is backed from inside",
            "Upper row: cut along the pot's height. Lower row: cut round the pot. The reference is converged to about 1.5 %.",
        ),
        Support::Hollow => (
            "a hollow pot",
            "Upper row: cut along the pot's height. Lower row: cut round half the pot. Here three quarters of the travel is the \
             wall bending; a method that knows no support shows its backed dent. The reference's permanent dent is converged \
             to about 20 % only.",
        ),
        Support::Finger => (
            "a wall held by a finger inside",
            "Upper row: cut along the pot's height. Lower row: cut round the pot. The finger is a rigid sphere of 15 mm opposite \
             the tool; a method that knows no support shows its backed dent.",
        ),
    }
}

/// From where to where a cut goes, mm or degrees.
fn stretch(cut: Cut, support: Support) -> (f64, f64) {
    match (cut, support) {
        (Cut::Height, Support::Hollow) => (-60.0, 60.0),
        (Cut::Height, _) => (-20.0, 20.0),
        (Cut::Round, Support::Hollow) => (0.0, 180.0),
        (Cut::Round, _) => (-20.0, 20.0),
    }
}

/// Displacement at a place of a cut through the tool, mm.
fn cut_mm(cut: Cut, at: f64, radial_mm: &dyn Fn(f64, f64) -> f64) -> f64 {
    // the reference presses at half of 200 mm
    match cut {
        Cut::Height => radial_mm(0.0, 100.0 + at),
        Cut::Round => radial_mm(at.to_radians(), 100.0),
    }
}

fn forces(figures: &Figures) -> Result<Canvas, ChartError> {
    let all = &figures.forces;
    let mut entries = vec![(Sign::Line(INK), "finite elements".to_owned())];
    entries.extend(rows(|row| all.iter().any(|force| force.row == row)));
    entries.push((Sign::Dashed(FRAME), "dashed: while the tool comes in at 6.7 mm/s".to_owned()));
    let (canvas, room) = sheet(
        "Force on a 12 mm sphere over its travel",
        &entries,
        "Marks: the tool has stood still for 1.5 s. Clay goes on carrying it; the published methods let it sink until nothing \
         pushes back, and free-form deformation has no force: all three lie on 0. What is elastic only leaves the picture. Past 1 mm the backed reference dips, because there it was let \
         go and pressed anew. Hollow: those that know that.",
    );
    for (column, support) in force::SUPPORTS.into_iter().enumerate() {
        let curve = force::reference(support == Support::Hollow)?;
        let y = Axis::linear("radial force, N", -0.05 * curve.largest_n(), 1.5 * curve.largest_n());
        let part = cell(room, (column, force::SUPPORTS.len()), (0, 1));
        let x = Axis::linear("travel of the tool, mm", 0.0, 2.1);
        let panel = Panel::new(&canvas, part, support.name(), x, y);
        let travels = (0..=100).map(|part| f64::from(part) * 0.02);
        let reference: Vec<[f64; 2]> = travels.filter_map(|travel| Some([travel, curve.first_at_n(travel)?])).collect();
        panel.line(&reference, INK, 2.5);
        for (row, _) in ENTRANTS.iter().enumerate().rev() {
            let own: Vec<_> = all.iter().filter(|force| force.row == row && force.support == support).collect();
            let look = Look::of_row(row);
            let moving: Vec<[f64; 2]> =
                own.iter().filter_map(|force| Some([force.travel_mm, force.moving_n?])).collect();
            let resting: Vec<[f64; 2]> = own.iter().map(|force| [force.travel_mm, force.resting_n]).collect();
            panel.dashed(&moving, look.colour, 2.0);
            panel.line(&resting, look.colour, 2.5);
            panel.marks(&resting, look);
        }
    }
    Ok(canvas)
}

fn convergence(figures: &Figures) -> Canvas {
    let all = &figures.convergence;
    let (canvas, room) = sheet(
        "What finer steps and finer elements change in a dent of 2 mm",
        &rows(|row| all.iter().any(|figures| figures.row == row && figures.change > 0.0)),
        "Change: RMS difference to the same method's finest, which is not on the picture. Yardsticks that keep no dent are left out.",
    );
    let shown = |varied: Varied| -> Vec<(usize, [f64; 2])> {
        let own: Vec<_> = all.iter().filter(|figures| figures.varied == varied).collect();
        let count = |figures: &ConvergenceFigures| match varied {
            Varied::Steps => figures.steps_in,
            Varied::Grid => figures.grid.columns(),
        };
        let finest = |row: usize| own.iter().filter(|figures| figures.row == row).map(|figures| count(figures)).max();
        let coarser = own.iter().filter(|figures| figures.change > 0.0 && finest(figures.row) != Some(count(figures)));
        coarser.map(|figures| (figures.row, [f64::from(count(figures)), figures.change * 100.0])).collect()
    };
    let panels = [
        ("in more steps", "steps of the same 0.3 s until the tool is in", shown(Varied::Steps)),
        ("on finer grids", "columns of the grid (rows in proportion)", shown(Varied::Grid)),
    ];
    let changes: Vec<f64> = panels.iter().flat_map(|(.., points)| points.iter().map(|(_, point)| point[1])).collect();
    for (column, (heading, title, points)) in panels.iter().enumerate() {
        let x = Axis::log(title, points.iter().map(|(_, point)| point[0]));
        let y = Axis::log("RMS change, % of the depth", changes.iter().copied().chain([1.0]));
        let panel = Panel::new(&canvas, cell(room, (column, 2), (0, 1)), heading, x, y);
        panel.dashed(&[[1e-9, 1.0], [1e9, 1.0]], FRAME, 1.5);
        for (row, _) in ENTRANTS.iter().enumerate().rev() {
            let line: Vec<[f64; 2]> = points.iter().filter(|(of, _)| *of == row).map(|(_, point)| *point).collect();
            panel.line(&line, Look::of_row(row).colour, 2.5);
            panel.marks(&line, Look::of_row(row));
        }
    }
    canvas
}

fn thread(figures: &Figures) -> Canvas {
    let all = &figures.helix;
    let mut entries = vec![(Sign::Line(INK), "cusp theory, 44.7 % · (P/2a)²; depth of the tool".to_owned())];
    entries.extend(rows(|row| all.iter().any(|figures| figures.row == row)));
    let (canvas, room) = sheet(
        "Tool along a turning wheel: what is left of a thread",
        &entries,
        "P: feed of the tool in one turn. 2a: length of its contact, 13.3 mm for a 12 mm sphere 2 mm deep. Below 1 % (dashed) the \
         pot is a profile over its height, and one turn says all. The wheel turns slowly, so that clay comes to rest under \
         the tool; the improved method digs on at every pass and every step.",
    );
    let pitches = || all.iter().map(|figures| figures.pitch_over_contact);
    let x = || Axis::log("pitch over length of contact, P/2a", pitches());
    let heights = all.iter().flat_map(|figures| [figures.cusps * 100.0, figures.theory() * 100.0]);
    let y = Axis::log("RMS height above the groove's bottom, % of depth", heights);
    let panels = [
        Panel::new(&canvas, cell(room, (0, 2), (0, 1)), "height of the thread", x(), y),
        Panel::new(
            &canvas,
            cell(room, (1, 2), (0, 1)),
            "depth of the groove",
            x(),
            Axis::log(
                "mean depth, mm",
                all.iter().map(|figures| figures.mean_depth_mm).chain([helix::DEPTH_MM.into()]),
            ),
        ),
    ];
    let theory: Vec<[f64; 2]> = (5..=110).map(|part| f64::from(part) * 0.01).map(|p| [p, 44.7 * p * p]).collect();
    panels[0].line(&theory, INK, 2.0);
    panels[0].dashed(&[[1e-9, 1.0], [1e9, 1.0]], FRAME, 1.5);
    panels[1].line(&[[1e-9, helix::DEPTH_MM.into()], [1e9, helix::DEPTH_MM.into()]], INK, 2.0);
    for (row, _) in ENTRANTS.iter().enumerate().rev() {
        let own = || all.iter().filter(|figures| figures.row == row);
        let cusps: Vec<_> = own().map(|figures| [figures.pitch_over_contact, figures.cusps * 100.0]).collect();
        let depths: Vec<_> = own().map(|figures| [figures.pitch_over_contact, figures.mean_depth_mm]).collect();
        for (panel, line) in panels.iter().zip([cusps, depths]) {
            panel.line(&line, Look::of_row(row).colour, 2.5);
            panel.marks(&line, Look::of_row(row));
        }
    }
    canvas
}
