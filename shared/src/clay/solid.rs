//! The pot as a closed solid of triangles.
//!
//! Owns the topology (outer wall, rim, inner wall, floor, underside); file formats are elsewhere.
//! Invariant: every edge belongs to exactly two triangles that pass it in opposite directions.

use alloc::vec::Vec;

use glam::Vec3;

use super::Pot;

/// A triangle with its corners counter-clockwise as seen from outside, m.
pub type Triangle = [Vec3; 3];

/// The pot as triangles that enclose its clay: outer wall, rim, inner wall, floor and underside.
///
/// `stride` keeps every n-th column and row (the last row always); 1 keeps all. At least three columns are kept, since
/// fewer enclose nothing.
/// The floor lies one wall thickness above the wheel head, on the first kept row at or above it.
///
/// # Panics
/// When `stride` is zero.
#[must_use]
pub fn closed_solid(pot: &Pot, stride: u32) -> Vec<Triangle> {
    assert!(stride > 0);
    let [outer, inner] = pot.skins();
    let surface = &pot.surfaces()[outer.surface];
    let shape = surface.shape();
    let column_stride = stride.min(shape.columns() / 3);
    let columns: Vec<u32> = (0..shape.columns()).step_by(column_stride as usize).collect();
    let mut rows: Vec<u32> = (0..shape.rows()).step_by(stride as usize).collect();
    if rows.last() != Some(&(shape.rows() - 1)) {
        rows.push(shape.rows() - 1);
    }
    let floor = floor_among(pot, &rows);

    let point = |skin: super::Skin, column: u32, row: u32| {
        let (sin, cos) = libm::sincosf(column as f32 * shape.column_angle_rad());
        let radius = pot.surfaces()[skin.surface].column_m(column)[row as usize] - skin.inset_m;
        Vec3::new(radius * cos, radius * sin, surface.row_z_m(row))
    };
    let mut triangles = Vec::with_capacity(columns.len() * rows.len() * 4);
    let mut quad = |corners: [Vec3; 4]| {
        let [a, b, c, d] = corners;
        triangles.push([a, b, c]);
        triangles.push([a, c, d]);
    };
    let top = rows[rows.len() - 1];
    for (at, &left) in columns.iter().enumerate() {
        let right = columns[(at + 1) % columns.len()];
        for pair in rows.windows(2) {
            let (low, high) = (pair[0], pair[1]);
            quad([
                point(outer, left, low),
                point(outer, right, low),
                point(outer, right, high),
                point(outer, left, high),
            ]);
        }
        for pair in rows[floor..].windows(2) {
            let (low, high) = (pair[0], pair[1]);
            quad([
                point(inner, right, low),
                point(inner, left, low),
                point(inner, left, high),
                point(inner, right, high),
            ]);
        }
        quad([point(outer, left, top), point(outer, right, top), point(inner, right, top), point(inner, left, top)]);
    }
    let floor_centre = Vec3::new(0.0, 0.0, surface.row_z_m(rows[floor]));
    for (at, &left) in columns.iter().enumerate() {
        let right = columns[(at + 1) % columns.len()];
        triangles.push([floor_centre, point(inner, left, rows[floor]), point(inner, right, rows[floor])]);
        triangles.push([Vec3::ZERO, point(outer, right, 0), point(outer, left, 0)]);
    }
    triangles
}

/// The row on which the floor of the hollow lies in a solid that keeps every row.
///
/// The last row in a pot whose wall is thicker than it is high: there is no hollow.
#[must_use]
pub fn floor_row(pot: &Pot) -> u32 {
    let rows: Vec<u32> = (0..pot.spec().shape.rows()).collect();
    rows[floor_among(pot, &rows)]
}

/// Where among the kept rows the floor lies: on the first at or above the wall's thickness.
fn floor_among(pot: &Pot, rows: &[u32]) -> usize {
    let surface = &pot.surfaces()[pot.skins()[0].surface];
    let is_above = |&row: &u32| surface.row_z_m(row) >= pot.spec().wall.0;
    // a wall thicker than the pot is high leaves no hollow: the floor is the rim
    rows.iter().position(is_above).unwrap_or(rows.len() - 1).max(1)
}
