//! The picture of stiffness and delay: where each way of rendering is stable, and what theory allows.
//!
//! Owns the sheet; the points come measured.
//! Invariant: a method has one colour in all parts of the sheet, and theory is dashed and black.

use egui::Color32;

use super::canvas::INK;
use super::panel::{Axis, Look, Panel, Sign};
use super::pictures::{cell, sheet};
use super::{ChartError, csv};
use crate::failures::METHODS;
use crate::stability::{Grip, PlanePoint, bound_n_m};

const PICTURE: &str = "stability-plane.png";

/// Delays at which the bound by theory is drawn, ms.
const DRAWN: usize = 120;

/// The plane as a table and as a picture: names and bytes.
///
/// # Errors
/// [`ChartError::Picture`] when the picture cannot be packed.
pub fn files(plane: &[PlanePoint]) -> Result<[(&'static str, Vec<u8>); 2], ChartError> {
    let table = csv::text(plane).into();
    Ok([("stability-plane.csv", table), (PICTURE, picture(plane)?)])
}

fn picture(plane: &[PlanePoint]) -> Result<Vec<u8>, ChartError> {
    let look = |row: usize| Look::of_row(row);
    let mut entries: Vec<(Sign, String)> =
        METHODS.iter().enumerate().map(|(row, (_, name))| (Sign::Marked(look(row)), (*name).to_owned())).collect();
    entries.push((Sign::Dashed(INK), "theory: (b + B)/(T/2 + t_d), b the hand's damping, B = 0".to_owned()));
    let (canvas, room) = sheet(
        "Stiffness that a hand feels without trembling: below a line is stable, higher is better",
        &entries,
        "What is compared is how force is rendered: all press the same linear wall, and how their own clay holds a hand is in \
         stability-clay.csv. A hand presses the wall with 2 N for 3 s, in a loop of 1 kHz with an encoder of 0.055 mm; stable is who then keeps within \
         four steps of it. The original's force goes through its filter of 10 Hz, the improved's is felt as it is, ours is a coupling \
         of that stiffness to clay ten times as stiff, with the passivity controller, which adds damping of its own: so that ours may lie \
         above the bound for the hand alone.",
    );
    let delays = plane.iter().map(|point| point.delay_s * 1e3).fold(0.0, f64::max);
    for (column, grip) in Grip::ALL.iter().enumerate() {
        let x = Axis::linear("delay beyond the loop's own, ms", 0.0, delays);
        let all = plane.iter().map(|point| point.stable_n_m * 1e-3);
        let y = Axis::log(if column == 0 { "stable stiffness, N/mm" } else { "" }, all);
        let Grip { name, mass_kg, damping_ns_m, stiffness_n_m } = grip;
        let heading = format!("{name}: {mass_kg} kg, {damping_ns_m} N·s/m, {stiffness_n_m} N/m");
        let panel = Panel::new(&canvas, cell(room, (column, Grip::ALL.len()), (0, 1)), &heading, x, y);
        let bound = (0..=DRAWN).map(|at| delays * at as f64 / DRAWN as f64);
        let bound: Vec<_> = bound.map(|delay_ms| [delay_ms, bound_n_m(grip, delay_ms * 1e-3) * 1e-3]).collect();
        panel.dashed(&bound, Color32::BLACK, 2.0);
        for (row, (method, _)) in METHODS.iter().enumerate() {
            let own = plane.iter().filter(|point| point.method == *method && point.grip.name == *name);
            let points: Vec<_> = own.map(|point| [point.delay_s * 1e3, point.stable_n_m * 1e-3]).collect();
            panel.line(&points, look(row).colour, 2.5);
            panel.marks(&points, look(row));
        }
    }
    canvas.into_png().map_err(|source| ChartError::Picture { name: PICTURE, source })
}
