//! Binary STL, mm.
//!
//! Invariant: every facet has the unit normal of its own corners.

use std::io;

use stl_io::{Normal, Triangle, Vertex};

use super::SolidMesh;
use super::mesh::facet_normal;

pub(super) fn write(mesh: &SolidMesh, out: &mut impl io::Write) -> io::Result<()> {
    let facet = |&facet: &[u32; 3]| {
        let corners_mm = mesh.places_mm(facet);
        Triangle { normal: Normal::new(facet_normal(corners_mm)), vertices: corners_mm.map(Vertex::new) }
    };
    let facets: Vec<_> = mesh.facets().iter().map(facet).collect();
    stl_io::write_stl(out, facets.iter())
}
