//! The improved Circular Sector Element Method (Lee and Choi): the original with local propagation.
//!
//! Owns the propagation over square hulls; contact and force are the original's.
//! Invariant: the work of a press is bounded by its contact's boundary times the reach of the kernel.

use super::lanes::{LANES, Simd, SimdBase, f32x8, hypot, root, splat, with_vectors};
use super::window::Boundary;
use super::{Contact, Footprint, Method, Pot, Press, Surface, Window, original};

/// Coefficient of propagation c_l, 1/m. The paper gives no number. At 1 a millimetre the neighbour of an element of the
/// default pot moves by half as much, and an edge is smooth over 4 mm; a wider kernel costs with the square of its reach.
const PROPAGATION_PER_M: f32 = 1000.0;
/// The propagation ends where it falls below this share of ΔS_r.
const THRESHOLD: f32 = 0.05;

/// The improved CSEM: each boundary element of the contact moves its neighbours on square hulls by
/// `l = ΔS_r / ((c_l·δ)² + 1)`. Lee and Choi, section II B.
///
/// Readings of what the paper leaves open:
/// - boundary: a touched element with an untouched 4-neighbour;
/// - ΔS_r: this step's push of the boundary element;
/// - δ: true metres on both axes, `max(|Δθ|·s_r, |Δz|)`, so that hulls are square on the clay, not on the grid;
/// - accumulated: a sum, in which hulls also move colliding elements (the other reading grows without end);
/// - threshold: relative to ΔS_r, so that slow pressing propagates as far as fast pressing.
#[derive(Clone, Copy, Debug, Default)]
pub struct ImprovedCsem;

/// δ at which the kernel falls below the threshold, m.
fn reach_m() -> f32 {
    root(1.0 / THRESHOLD - 1.0) / PROPAGATION_PER_M
}

/// l/ΔS_r at distance δ.
fn kernel(distance_m: f32) -> f32 {
    let scaled = PROPAGATION_PER_M * distance_m;
    1.0 / (scaled * scaled + 1.0)
}

impl Method for ImprovedCsem {
    fn press(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        let surface = pot.met_from(press.side);
        let shape = surface.shape();
        let reach_m = reach_m();
        let halo_rows = (reach_m / surface.row_height_m()) as u32;
        let smallest_arc = shape.column_angle_rad() * surface.bounds_m().0;
        let tool_m = footprint.scratch.reach_m(press.tool);
        let nearest = (hypot(press.centre_m.x, press.centre_m.y) - tool_m) * 0.5;
        let halo_arc = (shape.column_angle_rad() * nearest).max(smallest_arc);
        let halo_columns = ((reach_m / halo_arc) as u32).min(shape.columns() / 2);
        // one at least, or neighbours that are farther away than the kernel reaches would not be seen to be untouched
        let margin = (halo_columns.max(1), halo_rows.max(1));
        let contact = original::touch(surface, press, margin, footprint);
        if contact.elements == 0 {
            return contact;
        }
        let mut scratch = core::mem::take(&mut footprint.scratch);
        scratch.boundary.clear();
        gather_boundary(surface, scratch.contacts.window, footprint, &mut scratch.boundary);
        scratch.row_kernel.clear();
        scratch.row_kernel.resize(LANES, 0.0);
        scratch.row_kernel.extend((0..=2 * halo_rows).map(|row| {
            let distance_m = row.abs_diff(halo_rows) as f32 * surface.row_height_m();
            kernel(distance_m)
        }));
        scratch.row_kernel.resize(scratch.row_kernel.len() + LANES, 0.0);
        let hulls = Hulls { reach_m, columns: halo_columns, rows: halo_rows, row_kernel: &scratch.row_kernel };
        with_vectors!(scratch.vectors, simd => hulls.propagate_all(simd, surface, &scratch.boundary, footprint));
        footprint.scratch = scratch;
        contact
    }
}

/// Lists the touched elements, all of which lie in `met`, that have an untouched 4-neighbour; beyond foot and rim, and beyond the footprint's
/// window, there is none.
fn gather_boundary(surface: &Surface, met: Window, footprint: &Footprint, boundary: &mut alloc::vec::Vec<Boundary>) {
    let window = footprint.window();
    let whole_ring = window.columns == surface.shape().columns();
    let untouched = |local: i64, row: usize| {
        let local = if whole_ring { local.rem_euclid(i64::from(window.columns)) } else { local };
        (0..i64::from(window.columns)).contains(&local) && footprint.column(local as u32)[row] == 0.0
    };
    let met_rows = (met.first_row - window.first_row) as usize..(met.end_row() - window.first_row) as usize;
    for (local, column) in window.grid_columns(surface.shape()).enumerate() {
        if met.local_column(surface.shape(), column).is_none() {
            continue;
        }
        let (deltas, local) = (footprint.column(local as u32), local as i64);
        let eights = met_rows.clone().step_by(LANES).zip(deltas[met_rows.clone()].chunks(LANES));
        let touched = eights.filter(|(_, pushes_m)| pushes_m.iter().any(|push_m| *push_m != 0.0));
        for (row, &push_m) in touched.flat_map(|(first, pushes_m)| (first..).zip(pushes_m)) {
            if push_m == 0.0 {
                continue;
            }
            let open = (row > 0 && deltas[row - 1] == 0.0)
                || (row + 1 < deltas.len() && deltas[row + 1] == 0.0)
                || untouched(local - 1, row)
                || untouched(local + 1, row);
            if open {
                let radius_m = surface.column_m(column)[window.first_row as usize + row];
                boundary.push(Boundary { local_column: local as u32, row: row as u32, push_m, radius_m });
            }
        }
    }
}

/// The hulls round an element, as far as any of a press goes.
struct Hulls<'a> {
    reach_m: f32,
    columns: u32,
    rows: u32,
    /// l/ΔS_r from the lowest row to the highest, with [`LANES`] zeros before and after it.
    row_kernel: &'a [f32],
}

impl Hulls<'_> {
    #[inline(always)]
    fn propagate_all<S: Simd>(&self, simd: S, surface: &Surface, boundary: &[Boundary], footprint: &mut Footprint) {
        for element in boundary {
            self.propagate(simd, surface, element, footprint);
        }
    }

    /// Adds the hulls of one boundary element to the footprint, itself left out.
    ///
    /// On square hulls `l(max(δ_θ, δ_z)) = min(l(δ_θ), l(δ_z))`, since l falls with δ: so a column is one pass of `min`
    /// over the kernel of the rows, in whole eights, to whose other rows nothing is added.
    #[inline(always)]
    fn propagate<S: Simd>(&self, simd: S, surface: &Surface, element: &Boundary, footprint: &mut Footprint) {
        let window = footprint.window();
        let whole_ring = window.columns == surface.shape().columns();
        let arc_m = surface.shape().column_angle_rad() * element.radius_m;
        let reach_columns = ((self.reach_m / arc_m) as u32).min(self.columns);
        let first = element.row.saturating_sub(self.rows) as usize / LANES;
        let end = ((element.row + self.rows + 1).min(window.rows) as usize).div_ceil(LANES);
        let start = LANES + self.rows as usize + first * LANES - element.row as usize;
        let (rows, _) = self.row_kernel[start..].as_chunks::<LANES>();
        for step in -i64::from(reach_columns)..=i64::from(reach_columns) {
            let mut local = i64::from(element.local_column) + step;
            if whole_ring {
                local = local.rem_euclid(i64::from(window.columns));
            } else if !(0..i64::from(window.columns)).contains(&local) {
                continue;
            }
            let aside = splat(simd, kernel(step.unsigned_abs() as f32 * arc_m));
            for (delta, along) in footprint.column_eights_mut(local as u32)[first..end].iter_mut().zip(rows) {
                let share = aside.min(f32x8::load_array_ref(simd, along));
                *delta = (f32x8::load_array_ref(simd, delta) + share * element.push_m).to_array();
            }
        }
        // the element's own push is the contact's, not the propagation's
        footprint.column_mut(element.local_column)[element.row as usize] -= element.push_m;
    }
}
