//! Laws that can be written down, and what each method makes of them.
//!
//! With R the sphere's radius, r the pot's, `R_e = R·r/(R + r)` and δ the travel, the sphere cuts the cylinder in an ellipse
//! of half axes √(2Rδ) and √(2R_e·δ).
//! Invariant: every figure is a ratio of what is measured to what the law says.

use std::f64::consts::PI;

use super::ChartError;
use super::cases::{Support, reference_dent};
use super::csv::{Cell, Row};
use super::entrant::{ENTRANTS, Entrant};
use super::extent::Extent;
use super::progress::Progress;
use crate::dent::Dent;

/// Yield stress of clay that stays elastic, Pa: four times the pressure under the sphere at 0.5 mm.
const UNYIELDING_PA: f32 = 1e6;
/// Poisson's ratio of the reference's clay.
const POISSON: f64 = 0.45;

/// A law and the range in which the ratio of what is measured to it should lie.
#[derive(Clone, Copy, Debug)]
pub struct Law {
    /// Its name in files.
    pub name: &'static str,
    /// Least and largest ratio expected.
    pub expected: [f64; 2],
    ratio: fn(&Entrant, &Extent) -> Result<f64, ChartError>,
}

/// Every law.
pub const LAWS: &[Law] = &[
    // the ellipse is exact to first order in δ/R, which is 8 % at 1 mm; a layer that is wide against its thickness t gives way by F·t/M in
    // all besides, M = E·(1 − ν)/((1 + ν)·(1 − 2ν)): 6.2 mm³ under the reference's 5.9 N, 18 % of the ellipse's 34.4, part of it under the tool; the
    // reference itself has 39.8 mm³, 1.16
    Law { name: "volume of the loaded dent over pi d2 sqrt(R Re)", expected: [0.95, 1.23], ratio: volume },
    // Tabor 1951: 2.8 for a half-space; 2.1 to 3 for layers
    Law { name: "indentation pressure over yield stress", expected: [2.1, 3.0], ratio: pressure },
    // a layer of 8 mm under a contact of 2.4 mm is up to about 1.6 times stiffer than a half-space
    Law { name: "elastic force over Hertz's", expected: [1.0, 1.6], ratio: hertz },
];

/// √(R·R_e), m.
fn mean_radius_m(dent: &Dent) -> f64 {
    let (tool, pot) = (f64::from(dent.tool.0), f64::from(dent.pot.radius.0));
    (tool * tool * pot / (tool + pot)).sqrt()
}

/// V = π·δ²·√(R·R_e), at 1 mm.
fn volume(entrant: &Entrant, extent: &Extent) -> Result<f64, ChartError> {
    let dent = reference_dent(extent.case_grid, 1.0, false);
    let law_m3 = PI * f64::from(dent.depth.0).powi(2) * mean_radius_m(&dent);
    Ok(entrant.dent(&dent, Support::Backed)?.volume_in_mm3 * 1e-9 / law_m3)
}

/// F over the area 2π·√(R·R_e)·δ, over σ_y, at 2 mm.
fn pressure(entrant: &Entrant, extent: &Extent) -> Result<f64, ChartError> {
    let dent = reference_dent(extent.case_grid, 2.0, false);
    let area_m2 = 2.0 * PI * mean_radius_m(&dent) * f64::from(dent.depth.0);
    Ok(f64::from(entrant.dent(&dent, Support::Backed)?.force_n) / area_m2 / f64::from(dent.strength.yield_pa))
}

/// F = 4/3·E/(1 − ν²)·√R·δ^1.5 with √(R·R_e) for R, at 0.5 mm in clay that does not yield.
fn hertz(entrant: &Entrant, extent: &Extent) -> Result<f64, ChartError> {
    let mut dent = reference_dent(extent.case_grid, 0.5, false);
    dent.strength.yield_pa = UNYIELDING_PA;
    let reduced_pa = f64::from(dent.strength.youngs_pa) / (1.0 - POISSON * POISSON);
    let law_n = 4.0 / 3.0 * reduced_pa * mean_radius_m(&dent).sqrt() * f64::from(dent.depth.0).powf(1.5);
    Ok(f64::from(entrant.dent(&dent, Support::Backed)?.force_n) / law_n)
}

/// What a row of the table makes of a law.
#[derive(Clone, Copy, Debug)]
pub struct ClosedFormFigures {
    /// Row of the table of methods.
    pub row: usize,
    /// The law.
    pub law: Law,
    /// What is measured over what the law says.
    pub ratio: f64,
}

/// Holds every row of the table against every law.
///
/// # Errors
/// [`ChartError`] as for a single dent.
pub fn measure(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<ClosedFormFigures>, ChartError> {
    let mut figures = Vec::new();
    for (row, entrant) in ENTRANTS.iter().enumerate().filter(|(_, entrant)| extent.asks(entrant)) {
        progress.begin(&format!("{}: closed forms", entrant.title));
        for law in LAWS {
            figures.push(ClosedFormFigures { row, law: *law, ratio: (law.ratio)(entrant, extent)? });
        }
    }
    Ok(figures)
}

impl Row for ClosedFormFigures {
    const COLUMNS: &'static [&'static str] =
        &["method", "law", "measured_over_law_ratio", "expected_least_ratio", "expected_most_ratio", "within"];

    fn cells(&self) -> Vec<Cell> {
        let [least, most] = self.law.expected;
        vec![
            ENTRANTS[self.row].name.into(),
            self.law.name.into(),
            self.ratio.into(),
            least.into(),
            most.into(),
            (least..=most).contains(&self.ratio).into(),
        ]
    }
}
