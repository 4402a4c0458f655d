//! The improved Circular Sector Element Method as its words say, beside the reading of them that the studio offers.
//!
//! Lee and Choi, section II B, with `c_l` = 0.5/mm. Owns the hulls; contact, push and force are the original's. Nothing is
//! done to make it fast.
//! Invariant: a hull moves no element that collides, and every other element of it once.

use pottery_shared::clay::{Contact, Footprint, GridShape, Method, OriginalCsem, Pot, Press, Surface, Window};

use crate::dent::{Dent, DentError, Dented, Pressing};

/// Coefficient of propagation c_l, 1/m.
const PROPAGATION_PER_M: f32 = 500.0;
/// The propagation ends where it falls below this share of ΔS_r.
const THRESHOLD: f32 = 0.05;

/// Each boundary element of the contact moves the elements of hull n = 1, 2, … round it by
/// `l = ΔS_r/((c_l·u_θ·s_r·n)² + 1)`, u_θ the angle between columns and s_r the element's radius.
///
/// Where `ImprovedCsem` reads otherwise:
/// - hulls are square on the grid, n elements each way, whatever these measure upwards;
/// - what collides is left out of them, since the tool moves it already;
/// - every hull of every boundary element is walked by itself, and its l found anew.
///
/// Colliding elements thus stay where the tool is while those beside them sink by the sum of all hulls, which the finer the
/// grid the more of them reach: dents grow with the resolution.
#[derive(Clone, Copy, Debug, Default)]
pub struct LiteralCsem;

/// l/ΔS_r on hull n of an element whose columns are `arc_m` apart.
#[must_use]
pub fn share(arc_m: f32, n: u32) -> f32 {
    let scaled = PROPAGATION_PER_M * arc_m * n as f32;
    1.0 / (scaled * scaled + 1.0)
}

/// Hulls before l falls below the threshold, for columns `arc_m` apart.
#[must_use]
pub fn hulls(arc_m: f32) -> u32 {
    ((1.0 / THRESHOLD - 1.0).sqrt() / (PROPAGATION_PER_M * arc_m)) as u32
}

impl Method for LiteralCsem {
    fn press(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        let surface = pot.met_from(press.side);
        let contact = OriginalCsem.press(pot, press, footprint);
        if contact.elements == 0 {
            return contact;
        }
        let (shape, window) = (surface.shape(), footprint.window());
        let touched: Vec<f32> = (0..window.columns).flat_map(|local| footprint.span(local).1.to_vec()).collect();
        let patch = Patch { shape, window, pushes_m: &touched };
        let least_arc_m = shape.column_angle_rad() * patch.least_radius_m(surface);
        let reach = hulls(least_arc_m).min((shape.columns() - 1) / 2);
        footprint.reset(window.grown(shape, reach, reach));
        for (column, row, push_m) in patch.elements() {
            *element(footprint, shape, column, row).expect("the grown window holds the first") += push_m;
        }
        for (column, row, push_m) in patch.elements().filter(|&(column, row, _)| patch.is_boundary(column, row)) {
            let arc_m = shape.column_angle_rad() * surface.column_m(shape.wrap(column))[row as usize];
            for n in 1..=hulls(arc_m).min(reach) {
                let moved_m = push_m * share(arc_m, n);
                hull(i64::from(n), |aside, up| {
                    let (column, row) = (column + aside, row + up);
                    if patch.push_m(column, row) == 0.0
                        && let Some(delta_m) = element(footprint, shape, column, row)
                    {
                        *delta_m += moved_m;
                    }
                });
            }
        }
        contact
    }
}

/// Tells the 8·n places of square hull n.
fn hull(n: i64, mut tell: impl FnMut(i64, i64)) {
    for along in -n..n {
        tell(along, -n);
        tell(n, along);
        tell(-along, n);
        tell(-n, -along);
    }
}

/// The displacement of an element, where the footprint holds it.
fn element(footprint: &mut Footprint, shape: GridShape, column: i64, row: i64) -> Option<&mut f32> {
    let window = footprint.window();
    let local = window.local_column(shape, shape.wrap(column))?;
    let row = usize::try_from(row - i64::from(window.first_row)).ok()?;
    footprint.column_mut(local).get_mut(row)
}

/// What the tool pushes, `[columns][rows]` of a window.
struct Patch<'a> {
    shape: GridShape,
    window: Window,
    pushes_m: &'a [f32],
}

impl Patch<'_> {
    /// The push of an element by column and row of the grid, m; zero where the tool does not touch.
    fn push_m(&self, column: i64, row: i64) -> f32 {
        let Window { first_row, rows, .. } = self.window;
        let Some(local) = self.window.local_column(self.shape, self.shape.wrap(column)) else { return 0.0 };
        if !(i64::from(first_row)..i64::from(first_row + rows)).contains(&row) {
            return 0.0;
        }
        self.pushes_m[(local * rows) as usize + (row - i64::from(first_row)) as usize]
    }

    /// Column, row and push of the touched elements.
    fn elements(&self) -> impl Iterator<Item = (i64, i64, f32)> {
        let Window { first_column, first_row, rows, .. } = self.window;
        let touched = self.pushes_m.iter().enumerate().filter(|&(_, &push_m)| push_m != 0.0);
        touched.map(move |(number, &push_m)| {
            let (local, row) = (number as u32 / rows, number as u32 % rows);
            (i64::from(first_column + local), i64::from(first_row + row), push_m)
        })
    }

    /// Whether one of the four neighbours of an element on the clay is untouched.
    fn is_boundary(&self, column: i64, row: i64) -> bool {
        [(-1, 0), (1, 0), (0, -1), (0, 1)].into_iter().any(|(aside, up)| {
            (0..i64::from(self.shape.rows())).contains(&(row + up)) && self.push_m(column + aside, row + up) == 0.0
        })
    }

    fn least_radius_m(&self, surface: &Surface) -> f32 {
        let radii_m = self.elements().map(|(column, row, _)| surface.column_m(self.shape.wrap(column))[row as usize]);
        radii_m.fold(f32::MAX, f32::min)
    }
}

/// One step of a tool at an angle, a depth and a height, as [`Pressing::step`] has it.
pub fn step(pressing: &mut Pressing, angle_rad: f32, depth_m: f32, z_m: f32, turning: i8) -> f32 {
    pressing.step_with(LiteralCsem, angle_rad, depth_m, z_m, turning)
}

/// The dent that it makes.
///
/// # Errors
/// [`DentError`] for figures that make no sense.
pub fn press(dent: &Dent) -> Result<Dented, DentError> {
    dent.press_by(step)
}
