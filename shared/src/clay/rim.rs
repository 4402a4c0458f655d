//! The rim that rises beside a dent: its shape, where it lies, and how it is laid over the clay.
//!
//! Owns the footprint of a press of the studio's own method; what yields is told by `plastic`.
//! Invariant: no element that the tool touches rises.

use core::f32::consts::{PI, TAU};

use wide::f32x8;

use super::contact::{Contacts, LANES};
use super::ellipse::{Ellipse, Step};
use super::plastic::{PlasticLaw, Slide};
use super::{Footprint, Surface, Window};

/// A rim about an ellipse.
///
/// `κ(q²) = (Q − q²)/(1 + ((q² − 1)/w)²)` for 1 < q² < Q, up to which it rises where the tool does not touch, `∫ κ = π·a_θ·a_z·I` with U = Q − 1 and
/// `I = U·w·atan(U/w) − (w²/2)·ln(1 + U²/w²)`. Under a sliding tool it is weighted by `1 + x`, between 0 and 2, x the
/// distance in the direction of sliding over the half axis times the share of sliding: clay rises before the tool and not in its groove.
pub(super) struct Rim<'a> {
    pub(super) dent: &'a Ellipse,
    /// Volume that rises, m³; negative where the rim of an inner dent grows towards the axis.
    pub(super) volume_m3: f32,
    /// How much of the press is sliding, and where to.
    pub(super) slide: Slide,
    /// Height of the tool's centre, m.
    pub(super) tool_z_m: f32,
}

impl Rim<'_> {
    /// Where the rim begins, in q²: it rises from here to q² = 1, so that no element is raised or not by a hair.
    pub(super) const BEGIN: f32 = 0.75;

    /// Lays the footprint over rim and contact, and fills it with the rim; what the tool touches stays zero.
    pub(super) fn lay(
        &self,
        surface: &Surface,
        contacts: &Contacts,
        law: &PlasticLaw,
        rows: &mut alloc::vec::Vec<f32x8>,
        footprint: &mut Footprint,
    ) {
        let step = Step::of(surface);
        let dent = self.dent;
        let dent_rad = dent.arc_m / dent.radius_m;
        let (centre_rad, centre_z) = (contacts.angle_rad + dent_rad, self.tool_z_m + dent.above_m);
        let window = self.window(surface, contacts, law, centre_rad, centre_z);
        footprint.reset(window);
        rows.clear();
        let lanes = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        let (per_row, first) = (step.row_m / dent.half_height_m, centre_z / dent.half_height_m);
        for row in (window.first_row..window.end_row()).step_by(LANES) {
            rows.push((lanes + row as f32) * per_row - first);
        }
        let crest_m = self.volume_m3 / (PI * dent.half_arc_m * dent.half_height_m * area(law));
        for (local, column) in window.grid_columns(surface.shape()).enumerate() {
            let away_rad = column as f32 * step.column_rad - centre_rad;
            // the short way round
            let arc = (away_rad - TAU * libm::roundf(away_rad / TAU)) * dent.radius_m / dent.half_arc_m;
            let rest = law.rim_end - arc * arc;
            if rest <= 0.0 {
                continue;
            }
            let reach_m = libm::sqrtf(rest) * dent.half_height_m;
            let chunk = |z_m: f32| ((z_m / step.row_m) as u32).saturating_sub(window.first_row) as usize / LANES;
            let (from, to) = (chunk(centre_z - reach_m), (chunk(centre_z + reach_m) + 1).min(rows.len()));
            let column = &mut footprint.column_mut(local as u32)[from * LANES..];
            self.raise(crest_m, arc, law, &rows[from..to], column);
        }
    }

    /// Every element within the rim's outer end or in the contact.
    fn window(
        &self,
        surface: &Surface,
        contacts: &Contacts,
        law: &PlasticLaw,
        centre_rad: f32,
        centre_z: f32,
    ) -> Window {
        let (step, dent) = (Step::of(surface), self.dent);
        let end = libm::sqrtf(law.rim_end);
        let reach_m = end * dent.half_height_m;
        let row = |z_m: f32| libm::floorf(z_m / step.row_m) as i64;
        let (mut first_row, mut last_row) = (row(centre_z - reach_m), row(centre_z + reach_m) + 1);
        let mut reach_rad = end * dent.half_arc_m / dent.radius_m;
        for chunk in &contacts.chunks {
            first_row = first_row.min(i64::from(chunk.row));
            last_row = last_row.max(i64::from(chunk.row) + LANES as i64 - 1);
            reach_rad = reach_rad.max((chunk.angle_rad - dent.arc_m / dent.radius_m).abs());
        }
        let column = libm::roundf(centre_rad / step.column_rad) as i64;
        let half_columns = libm::ceilf(reach_rad / step.column_rad) as u32 + 1;
        Window::around(surface.shape(), column, half_columns, first_row, last_row)
            .aligned(surface.shape(), LANES as u32)
    }

    /// Adds one column of the rim, `arc` half axes aside of its middle, at `rows` half axes above it.
    fn raise(&self, crest_m: f32, arc: f32, law: &PlasticLaw, rows: &[f32x8], column: &mut [f32]) {
        let end = f32x8::splat(law.rim_end);
        let narrow = 1.0 / law.rim_width;
        let Slide { along, up, .. } = self.slide;
        let raised = |row: f32x8| {
            let q2 = row * row + arc * arc;
            let beyond = (q2 - 1.0) * narrow;
            let within = ((q2 - Self::BEGIN) * (1.0 / (1.0 - Self::BEGIN))).fast_max(f32x8::ZERO).fast_min(f32x8::ONE);
            let ahead = (row * up + (1.0 + along * arc)).fast_max(f32x8::ZERO).fast_min(f32x8::splat(2.0));
            (end - q2).fast_max(f32x8::ZERO) * within * ahead * crest_m / (beyond * beyond + 1.0)
        };
        let (column, last) = column.as_chunks_mut::<LANES>();
        for (lanes, &row) in column.iter_mut().zip(rows) {
            *lanes = raised(row).to_array();
        }
        if let Some(&row) = rows.get(column.len()) {
            last.copy_from_slice(&raised(row).to_array()[..last.len()]);
        }
    }
}

/// The I of [`Rim`].
pub(super) fn area(law: &PlasticLaw) -> f32 {
    let (end, width) = (law.rim_end - 1.0, law.rim_width);
    end * width * libm::atanf(end / width) - 0.5 * width * width * libm::logf(1.0 + end * end / (width * width))
}
