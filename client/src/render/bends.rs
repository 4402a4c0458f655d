//! How much a surface bends from element to element, and so by how much a coarser mesh misses it.
//!
//! Owns three figures a column; knows no camera and no device.
//! Invariant: no point of a coarser mesh is farther from the mesh of all elements than [`Bends::missed_m`] says, wherever it begins.

use pottery_shared::clay::{GridShape, Surface, Window};

use super::mesh::Stride;

/// Largest second differences of the radii, along a column, from column to column, and mixed, and the largest radius, m.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Bend {
    along: f32,
    across: f32,
    mixed: f32,
    radius: f32,
}

impl Bend {
    fn or_more(self, other: Self) -> Self {
        Self {
            along: self.along.max(other.along),
            across: self.across.max(other.across),
            mixed: self.mixed.max(other.mixed),
            radius: self.radius.max(other.radius),
        }
    }
}

/// The bends of one surface.
#[derive(Debug)]
pub(super) struct Bends {
    shape: GridShape,
    columns: Vec<Bend>,
    most: Bend,
}

impl Bends {
    pub(super) fn new(shape: GridShape) -> Self {
        Self { shape, columns: vec![Bend::default(); shape.columns() as usize], most: Bend::default() }
    }

    /// Looks again at what changed of the surface.
    pub(super) fn note(&mut self, surface: &Surface, window: Window) {
        let columns = self.shape.columns();
        if window.columns == 0 || window.rows == 0 {
            return;
        }
        // each column is compared with both beside it
        for aside in 0..(window.columns + 2).min(columns) {
            let column = (window.first_column + columns - 1 + aside) % columns;
            self.columns[column as usize] = of_column(surface, column);
        }
        self.most = self.columns.iter().copied().fold(Bend::default(), Bend::or_more);
    }

    /// The largest radius, m.
    pub(super) const fn widest_m(&self) -> f32 {
        self.most.radius
    }

    /// Farthest that the mesh of a stride is from the mesh of all elements, m.
    ///
    /// `e ≤ a²·B_θ/8 + b²·B_z/8 + a·b·B_θz/4 + r·(1 − cos(a·Δθ/2))`: `a` columns and `b` rows between vertices, `B` the largest second
    /// differences over one element (m), `r` the largest radius (m), `Δθ` the angle of a column. The first three are what linear
    /// interpolation in a right triangle misses of a function, the last is the height of the arc over its chord.
    pub(super) fn missed_m(&self, stride: Stride) -> f32 {
        if stride == Stride::FULL {
            return 0.0;
        }
        let Bend { along, across, mixed, radius } = self.most;
        let (columns, rows) = (stride.columns as f32, stride.rows as f32);
        let between = |vertices: f32| if vertices > 1.0 { vertices * vertices / 8.0 } else { 0.0 };
        let arc = match stride.columns {
            1 => 0.0,
            _ => 1.0 - (0.5 * columns * self.shape.column_angle_rad()).cos(),
        };
        between(columns) * across + between(rows) * along + 0.25 * columns * rows * mixed + radius * arc
    }
}

fn of_column(surface: &Surface, column: u32) -> Bend {
    let columns = surface.shape().columns();
    let left = surface.column_m((column + columns - 1) % columns);
    let own = surface.column_m(column);
    let right = surface.column_m((column + 1) % columns);
    let mut bend = Bend::default();
    for three in own.windows(3) {
        bend.along = bend.along.max((three[0] - 2.0 * three[1] + three[2]).abs());
    }
    for ((left, own), right) in left.iter().zip(own).zip(right) {
        bend.across = bend.across.max((left - 2.0 * own + right).abs());
        bend.radius = bend.radius.max(*own);
    }
    for (own, right) in own.windows(2).zip(right.windows(2)) {
        bend.mixed = bend.mixed.max((right[1] - right[0] - own[1] + own[0]).abs());
    }
    bend
}

#[cfg(test)]
mod tests {
    use super::*;
    use pottery_shared::clay::{Pot, PotSpec};

    /// A pot with lobes, waves and a step round it.
    fn pot(shape: GridShape) -> Pot {
        let mut pot = Pot::new(PotSpec { shape, ..PotSpec::default() }).expect("the usual pot can be made");
        for column in 0..shape.columns() {
            for row in 0..shape.rows() {
                let turn = column as f32 / shape.columns() as f32 * std::f32::consts::TAU;
                let lobes = 0.004 * (3.0 * turn + 0.05 * row as f32).cos() + 0.001 * (0.4 * row as f32).sin();
                let step = if row > shape.rows() / 2 { 0.0004 } else { 0.0 };
                pot.surfaces_mut()[0].set_radius(column, row, 0.055 + lobes + step);
            }
        }
        pot
    }

    /// Farthest, in radius, of the elements within the triangles of a coarser mesh that begins at a row; as the mesh has them.
    fn really_missed_m(surface: &Surface, stride: Stride, first_row: u32) -> f32 {
        let (columns, rows) = (surface.shape().columns(), surface.shape().rows());
        let radius = |column: u32, row: u32| surface.column_m(column % columns)[row as usize];
        let mut most = 0.0_f32;
        for left in (0..columns).step_by(stride.columns as usize) {
            for low in (first_row..rows - 1).step_by(stride.rows as usize) {
                let (right, high) = ((left + stride.columns).min(columns), (low + stride.rows).min(rows - 1));
                for column in left..=right {
                    for row in low..=high {
                        let u = (column - left) as f32 / (right - left) as f32;
                        let v = (row - low) as f32 / (high - low) as f32;
                        let [ll, lh, rl, rh] =
                            [(left, low), (left, high), (right, low), (right, high)].map(|(c, r)| radius(c, r));
                        let mesh = if v <= u {
                            ll + u * (rl - ll) + v * (rh - rl)
                        } else {
                            ll + v * (lh - ll) + u * (rh - lh)
                        };
                        most = most.max((mesh - radius(column, row)).abs());
                    }
                }
            }
        }
        most
    }

    #[test]
    fn no_mesh_misses_more_than_is_said_wherever_it_begins_and_none_is_said_to_miss_many_times_as_much() {
        let shape = GridShape::new(96, 131).expect("a grid");
        let pot = pot(shape);
        let surface = &pot.surfaces()[0];
        let mut bends = Bends::new(shape);
        bends.note(surface, Window { first_column: 0, columns: 96, first_row: 0, rows: 131 });
        for (columns, rows) in [(1, 2), (2, 1), (2, 2), (4, 2), (2, 4), (8, 4), (4, 8)] {
            let stride = Stride { columns, rows };
            // in radius alone, without the arc
            let arc = 1.0 - (0.5 * columns as f32 * shape.column_angle_rad()).cos();
            let said_m = bends.missed_m(stride) - if columns > 1 { bends.widest_m() * arc } else { 0.0 };
            for first_row in [0, 1, 7] {
                let missed_m = really_missed_m(surface, stride, first_row);
                // a rounding or two of radii of 60 mm
                assert!(missed_m <= said_m + 2e-8, "{columns} × {rows} from {first_row}: {missed_m} > {said_m}");
                // the step is one bend among smooth ones: of four rows it can spoil two
                assert!(said_m < 6.0 * missed_m, "{columns} × {rows} from {first_row}: {missed_m} of {said_m}");
            }
        }
        assert_eq!(bends.missed_m(Stride::FULL), 0.0);
    }

    #[test]
    fn what_is_looked_at_anew_where_it_changed_is_what_is_found_in_all_of_it() {
        let shape = GridShape::new(40, 30).expect("a grid");
        let (smooth, bent) = (Pot::new(PotSpec { shape, ..PotSpec::default() }).expect("a pot"), pot(shape));
        let whole = Window { first_column: 0, columns: 40, first_row: 0, rows: 30 };
        let stride = Stride { columns: 4, rows: 4 };
        let mut bends = Bends::new(shape);
        bends.note(&smooth.surfaces()[0], whole);
        let untouched_m = bends.missed_m(stride);
        for window in [Window { first_column: 38, columns: 5, ..whole }, Window { columns: 0, ..whole }] {
            let mut changed = smooth.clone();
            for column in [38, 39, 0, 1, 2] {
                for row in 0..30 {
                    let radius_m = bent.surfaces()[0].column_m(column)[row as usize];
                    changed.surfaces_mut()[0].set_radius(column, row, radius_m);
                }
            }
            bends.note(&changed.surfaces()[0], window);
            let mut anew = Bends::new(shape);
            anew.note(&changed.surfaces()[0], whole);
            assert_eq!(bends.missed_m(stride), anew.missed_m(stride));
            assert!(bends.missed_m(stride) > untouched_m);
        }
    }
}
