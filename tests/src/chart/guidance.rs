//! The picture of guidance: what each way of guiding leaves of a student's error.
//!
//! Owns the sheet; the figures come measured.
//! Invariant: a hand has one colour in both parts of the sheet.

use super::panel::{Axis, Look, Panel, Sign};
use super::pictures::{cell, sheet};
use super::{ChartError, csv};
use crate::stability::{Grip, GuidanceFigures, WAYS};

const PICTURE: &str = "guidance.png";

/// The table and the picture: names and bytes.
///
/// # Errors
/// [`ChartError::Picture`] when the picture cannot be packed.
pub fn files(figures: &[GuidanceFigures]) -> Result<[(&'static str, Vec<u8>); 2], ChartError> {
    Ok([("guidance.csv", csv::text(figures).into()), (PICTURE, picture(figures)?)])
}

fn picture(figures: &[GuidanceFigures]) -> Result<Vec<u8>, ChartError> {
    let hand = |row: usize| Sign::Marked(Look::of_row(row));
    let entries: Vec<_> = Grip::ALL.iter().enumerate().map(|(row, grip)| (hand(row), grip.name.to_owned())).collect();
    let (canvas, room) = sheet(
        "How far a guided student's tool is from the teacher's: to the left is nearer",
        &entries,
        "Root of the mean square over 10 s, from the teacher's tool as it is shown to the student, some 190 ms late: each line takes 50 to \
         90 ms and loses 5 %. The student means to be where it was shown 150 ms ago, 4 mm wrong. What the tool is off by is what is pressed; \
         noise and repulsion are for practice and are meant to make it harder.",
    );
    let most = figures.iter().map(|row| row.learnt.tool_rms_mm).fold(1.0, f64::max) * 1.05;
    let names: Vec<_> = WAYS.iter().map(|(name, _)| (*name).to_owned()).collect();
    for (column, (heading, on_clay)) in [("in the air", false), ("on clay", true)].into_iter().enumerate() {
        let x = Axis::linear("tool from the teacher's, RMS, mm", 0.0, most);
        let panel = Panel::new(&canvas, cell(room, (column, 2), (0, 1)), heading, x, Axis::names(names.clone()));
        for (row, grip) in Grip::ALL.iter().enumerate() {
            let own = figures.iter().filter(|figure| figure.grip == *grip && figure.on_clay == on_clay);
            let place = |figure: &GuidanceFigures| names.iter().position(|name| name == figure.way).unwrap_or_default();
            let points: Vec<_> = own.map(|figure| [figure.learnt.tool_rms_mm, place(figure) as f64]).collect();
            panel.marks(&points, Look::of_row(row));
        }
    }
    canvas.into_png().map_err(|source| ChartError::Picture { name: PICTURE, source })
}
