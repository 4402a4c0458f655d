//! Wavefront OBJ, mm; the format has no unit, so the first line says it.
//!
//! Invariant: corner and normal have the same number.

use std::io;

use super::SolidMesh;

pub(super) fn write(mesh: &SolidMesh, out: &mut impl io::Write) -> io::Result<()> {
    writeln!(out, "# a pot of the pottery studio; millimetres, z upwards")?;
    writeln!(out, "o pot")?;
    for [x, y, z] in mesh.corners_mm() {
        writeln!(out, "v {x} {y} {z}")?;
    }
    for [x, y, z] in mesh.normals() {
        // a ten-thousandth is 0.006°
        writeln!(out, "vn {x:.4} {y:.4} {z:.4}")?;
    }
    for facet in mesh.facets() {
        // numbers begin at 1
        let [a, b, c] = facet.map(|corner| corner + 1);
        writeln!(out, "f {a}//{a} {b}//{b} {c}//{c}")?;
    }
    Ok(())
}
