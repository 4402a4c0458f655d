//! Tools that people bring to a wheel, between the core and the wire, for both ends.
//!
//! The one conversion, so that no end takes a mesh that another would not. A tool's number is its place in the rack: the
//! server gives it and tells everybody, in order, before anybody can press with it.
//! Invariant: the same mesh makes the same tool at every end, bit for bit.

use alloc::collections::BTreeMap;
use alloc::sync::Arc;
use alloc::vec::Vec;

use glam::Vec3;

use crate::protocol::MeshWire;
use crate::tool::{ConvexError, ConvexTool};

/// Most tools that are brought to one wheel.
pub const BROUGHT_MAX: usize = 12;
/// Most triangles of a tool that is brought: a ball of so many presses in two to three spheres' time a step, one of four times as many in
/// three to four.
pub const BROUGHT_TRIANGLES_MAX: usize = 1280;

/// Why a tool cannot be brought to a wheel.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum BringError {
    /// More triangles than everybody at the wheel could press with in time; simplify the mesh.
    #[error("a tool of {triangles} triangles is too fine to be shared: simplify its mesh to {max} or fewer")]
    TooFine {
        /// How many there are.
        triangles: usize,
        /// Most allowed.
        max: usize,
    },
    /// A triangle names a corner that is not there; only a broken program sends that.
    #[error("triangle {triangle} names corner {corner} of {corners}")]
    Corner {
        /// Number of the triangle, from 0.
        triangle: usize,
        /// Number of the corner.
        corner: u16,
        /// How many corners there are.
        corners: usize,
    },
    /// More corners than a closed surface of so many triangles has; only a broken program sends that.
    #[error("{corners} corners are more than the {max} of a closed surface of {triangles} triangles")]
    Loose {
        /// How many corners there are.
        corners: usize,
        /// Most allowed.
        max: usize,
        /// How many triangles there are.
        triangles: usize,
    },
    /// The mesh makes no tool.
    #[error(transparent)]
    Mesh(#[from] ConvexError),
}

/// A tool as it travels, its corners from its centre.
///
/// # Errors
/// [`BringError`] when it is too fine, or when what travels would not make a tool again.
pub fn mesh_of(tool: &ConvexTool) -> Result<MeshWire, BringError> {
    check_count(tool.triangles_m().len())?;
    let mut mesh = MeshWire { corners_m: Vec::new(), facets: Vec::new() };
    let mut known = BTreeMap::new();
    for triangle in tool.triangles_m() {
        let facet = triangle.map(|corner| {
            *known.entry(corner.to_array().map(f32::to_bits)).or_insert_with(|| {
                mesh.corners_m.push(corner.to_array());
                (mesh.corners_m.len() - 1) as u16
            })
        });
        mesh.facets.push(facet);
    }
    tool_of(&mesh)?;
    Ok(mesh)
}

/// The tool that a mesh makes.
///
/// # Errors
/// [`BringError`] when it makes none.
pub fn tool_of(mesh: &MeshWire) -> Result<ConvexTool, BringError> {
    check_count(mesh.facets.len())?;
    let mut triangles_m = Vec::with_capacity(mesh.facets.len());
    for (triangle, facet) in mesh.facets.iter().enumerate() {
        let mut corners_m = [Vec3::ZERO; 3];
        for (corner_m, &corner) in corners_m.iter_mut().zip(facet) {
            let corners = mesh.corners_m.len();
            let found = mesh.corners_m.get(usize::from(corner));
            *corner_m = Vec3::from_array(*found.ok_or(BringError::Corner { triangle, corner, corners })?);
        }
        triangles_m.push(corners_m);
    }
    let tool = ConvexTool::new(&triangles_m)?;
    // by Euler's formula: with more, what is told of a tool could be longer than a frame
    let (corners, triangles) = (mesh.corners_m.len(), mesh.facets.len());
    let max = triangles / 2 + 2;
    if corners > max { Err(BringError::Loose { corners, max, triangles }) } else { Ok(tool) }
}

fn check_count(triangles: usize) -> Result<(), BringError> {
    let max = BROUGHT_TRIANGLES_MAX;
    if triangles > max { Err(BringError::TooFine { triangles, max }) } else { Ok(()) }
}

/// A rack with one tool more.
pub(crate) fn with_one_more(rack: &[ConvexTool], tool: ConvexTool) -> Arc<[ConvexTool]> {
    rack.iter().cloned().chain([tool]).collect()
}
