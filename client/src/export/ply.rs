//! Binary PLY, little-endian, mm; the format has no unit, so a comment says it.
//!
//! Invariant: the counts in the head are those of what follows.

use std::io;

use super::SolidMesh;

pub(super) fn write(mesh: &SolidMesh, out: &mut impl io::Write) -> io::Result<()> {
    write!(
        out,
        "ply\nformat binary_little_endian 1.0\ncomment a pot of the pottery studio; millimetres, z upwards\n\
         element vertex {}\nproperty float x\nproperty float y\nproperty float z\n\
         property float nx\nproperty float ny\nproperty float nz\n\
         element face {}\nproperty list uchar int vertex_indices\nend_header\n",
        mesh.corners_mm().len(),
        mesh.facets().len()
    )?;
    for (corner, normal) in mesh.corners_mm().iter().zip(mesh.normals()) {
        for number in corner.iter().chain(normal) {
            out.write_all(&number.to_le_bytes())?;
        }
    }
    for facet in mesh.facets() {
        out.write_all(&[3])?;
        for corner in facet {
            out.write_all(&corner.to_le_bytes())?;
        }
    }
    Ok(())
}
