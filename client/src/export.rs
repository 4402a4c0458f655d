//! The pot as a file that other programs read: binary STL.
//!
//! Millimetres, as slicers and CAD programs expect; the core's metres end here.
//! Invariant: every facet written has the unit normal of its own corners, pointing out of the clay.

use std::io;

use pottery_shared::clay::{self, Pot, closed_solid};
use pottery_shared::units::Metres;
use stl_io::{Normal, Triangle, Vertex};

/// Writes the clay of `pot` as a closed solid in binary STL, mm, foot on z = 0.
///
/// Every element of the outer surface is a corner; 144,000 elements make about 28 MB. A facet of which two corners
/// fall together encloses nothing and is left out; the solid stays closed, since both its remaining edges are one.
///
/// # Errors
/// Whatever `out` answers; what has been written until then is no valid file.
///
/// ```
/// use pottery_client::export::write_stl;
/// use pottery_shared::clay::{GridShape, Pot, PotSpec};
///
/// let pot = Pot::new(PotSpec { shape: GridShape::new(32, 16)?, ..PotSpec::default() })?;
/// let mut file = Vec::new();
/// write_stl(&pot, &mut file)?;
/// let facets = u32::from_le_bytes([file[80], file[81], file[82], file[83]]);
/// assert_eq!(file.len(), 84 + 50 * facets as usize);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_stl(pot: &Pot, out: &mut impl io::Write) -> io::Result<()> {
    let facets: Vec<Triangle> = closed_solid(pot, 1).into_iter().filter_map(facet).collect();
    stl_io::write_stl(out, facets.iter())
}

/// One facet in mm, or nothing when two of its corners fall together.
fn facet(corners_m: clay::Triangle) -> Option<Triangle> {
    let corners_mm = corners_m.map(|corner| corner.to_array().map(|length_m| Metres(length_m).as_mm()));
    let [a, b, c] = corners_mm;
    if a == b || b == c || c == a {
        return None;
    }
    Some(Triangle { normal: Normal::new(unit_normal(a, b, c)), vertices: corners_mm.map(Vertex::new) })
}

/// Unit vector of (b − a) × (c − a), in f64, since the f32 product of two nearly parallel edges points anywhere.
///
/// Zero for corners in a line, which in STL leaves the choice to the reader.
fn unit_normal(a: [f32; 3], b: [f32; 3], c: [f32; 3]) -> [f32; 3] {
    let edge = |to: [f32; 3]| [0, 1, 2].map(|axis| f64::from(to[axis]) - f64::from(a[axis]));
    let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
    let normal = [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx];
    let length = normal.iter().map(|part| part * part).sum::<f64>().sqrt();
    if length > 0.0 { normal.map(|part| (part / length) as f32) } else { [0.0; 3] }
}
