//! Collision of a convex tool of flat facets with the elements: the same chunks as a sphere's, and the way each facet faces.
//!
//! Owns the convex tools of a sub-step and the memory one is cut in; what a touch does to the clay is the methods'.
//! Invariant: what is found depends on tool, pose and radii alone, and every touched element stands in exactly one chunk.

use alloc::sync::Arc;

use glam::{Mat3, Vec3};

use super::contact::{Column, Contacts, Ground, Tally, nearest_turn};
use super::lanes::{Eight, LANES, Simd, SimdBase, SimdFloat, columns, f32x8, load, root, splat};
use super::window::Scratch;
use super::{GridShape, Press, Window};
use crate::tool::{ConvexTool, Eights, Pose, STEEPEST, Sections, Shape, Side, Sides, Tool};

/// The convex tools that presses name, and the memory in which one of them is cut.
#[derive(Clone, Debug)]
pub(super) struct Cutter {
    pub(super) rack: Arc<[ConvexTool]>,
    pub(super) sections: Sections,
}

impl Cutter {
    pub(super) fn new(rack: Arc<[ConvexTool]>, shape: GridShape) -> Self {
        let room = || Sections::for_lattice(shape.columns(), shape.rows());
        Self { sections: if rack.is_empty() { Sections::default() } else { room() }, rack }
    }

    pub(super) const fn rack(&self) -> &Arc<[ConvexTool]> {
        &self.rack
    }

    pub(super) const fn rack_mut(&mut self) -> &mut Arc<[ConvexTool]> {
        &mut self.rack
    }

    pub(super) fn tool(&self, shape: Shape) -> Option<&ConvexTool> {
        self.rack.get(usize::from(shape.0))
    }
}

impl Scratch {
    /// How far a tool reaches from its centre, m; nothing for one that is not there.
    pub(super) fn reach_m(&self, tool: Tool) -> f32 {
        match tool {
            Tool::Sphere(sphere) => sphere.radius().0,
            Tool::Convex(shape) => {
                self.cutter.as_deref().and_then(|cutter| cutter.tool(shape)).map_or(0.0, |tool| tool.radius().0)
            }
        }
    }
}

/// A section and the facets of the side that presses, seen along its column's ray.
pub(super) struct Face<'a> {
    pub(super) section: &'a Eights<'a>,
    /// Their bits.
    pub(super) normals: &'a [[u32; 4]],
    /// Directions in the tool's own coordinates: against the ray, against what lies across it, and down.
    pub(super) axes: [Vec3; 3],
    pub(super) outwards: f32,
    pub(super) behind_m: f32,
}

/// Where a section is pressed: the column, what of it the tool covers, the angle of the ray along which it was cut from the tool's centre, rad,
/// and its direction.
#[derive(Clone, Copy)]
pub(super) struct Place {
    pub(super) column: u32,
    pub(super) share: f32,
    pub(super) angle_rad: f32,
    pub(super) direction: [f32; 2],
}

impl Contacts {
    /// Finds the elements that a convex tool touches, `behind_m` inside of the ground's radii, none of which is wider than the reach, m, or narrower
    /// when it is inside.
    ///
    /// The ray of an element (r, θ, z) is in the tool from s₁ to s₂: from outside the penetration is `p = r − s₁`, from inside
    /// `p = s₂ − r`, as for a sphere.
    #[inline(always)]
    pub(super) fn gather_facets<S: Simd, const LEANS: bool, G: Ground>(
        &mut self,
        simd: S,
        ground: &mut G,
        press: &Press,
        shape: Shape,
        [behind_m, reach_m]: [f32; 2],
        cutter: &mut Cutter,
    ) {
        let Cutter { rack, sections } = cutter;
        let Some(tool) = rack.get(usize::from(shape.0)) else { return };
        let pose = Pose { centre_m: press.centre_m, orientation: press.orientation };
        let Some(turn) = pose.turn() else { return };
        let (sides, reach_m, outwards) = met(press.side, reach_m);
        let lattice = ground.lattice();
        sections.cut_with(simd, tool, &pose, &lattice, reach_m, sides);
        let extent = sections.extent();
        if extent.columns == 0 || extent.rows == 0 {
            return;
        }
        let crate::tool::Extent { first_column, columns, first_row, rows } = extent;
        self.window = Window { first_column, columns, first_row, rows }.aligned(lattice.rows, LANES as u32);
        self.stand(press, tool);
        self.fill_heights(simd, lattice.rows, lattice.row_height_m, press.centre_m.z);
        let mut tally = Tally::new(simd);
        for section in sections.eights() {
            let column = section.column;
            let direction = ground.lattice().directions[column as usize].to_array();
            let angle_rad = nearest_turn(column as f32 * ground.column_rad() - self.angle_rad);
            let axes = axes(&turn, direction);
            let face = Face { section: &section, normals: tool.facing(), axes, outwards, behind_m };
            let place = Place { column, share: 1.0, angle_rad, direction };
            self.gather_section::<S, LEANS, G>(simd, ground, press, &face, &place, &mut tally);
        }
        self.take(&tally);
    }

    /// Notes where a tool stands, and how far it reaches.
    pub(super) fn stand(&mut self, press: &Press, tool: &ConvexTool) {
        let Vec3 { x, y, .. } = press.centre_m;
        self.tool_m = tool.radius().0;
        self.distance_m = root(x * x + y * y);
        self.angle_rad = libm::atan2f(y, x);
    }

    #[inline(always)]
    pub(super) fn gather_section<S: Simd, const LEANS: bool, G: Ground>(
        &mut self,
        simd: S,
        ground: &mut G,
        press: &Press,
        face: &Face<'_>,
        place: &Place,
        tally: &mut Tally<S>,
    ) {
        let Face { section, outwards, behind_m, .. } = *face;
        let Place { column, share, angle_rad, direction: [cos, sin] } = *place;
        let (along_m, aside_m) =
            (press.centre_m.x * cos + press.centre_m.y * sin, press.centre_m.y * cos - press.centre_m.x * sin);
        let Eights { first_row, radii_m: edges_m, facets, .. } = *section;
        let first = (first_row - self.window.first_row) / LANES as u32;
        let chunks = first..first + edges_m.len() as u32;
        let rows = first_row..first_row + (edges_m.len() * LANES) as u32;
        let (whole_m, last_m) = ground.radii_m(column, rows).as_chunks::<LANES>();
        let mut at = Column::new(column, self.window, chunks, angle_rad, [cos, sin], [along_m, aside_m]);
        at.share = share;
        let kept = self.add_column(
            at,
            #[inline(always)]
            |number, chunk| {
                let radius_m = match whole_m.get(number) {
                    Some(lanes) => f32x8::load_array_ref(simd, lanes),
                    None => load(simd, last_m),
                };
                // beyond the tool no clay is touched
                let edge_m = f32x8::load_array_ref(simd, &edges_m[number]);
                let penetration_m = ((radius_m - behind_m - edge_m) * outwards).max(splat(simd, 0.0));
                (chunk.penetration_m, chunk.radius_m) = (penetration_m.into(), radius_m.into());
                penetration_m
            },
            tally,
        );
        let Some(kept) = kept else { return };
        let facets = &facets[((kept.first_row - first_row) / LANES as u32) as usize..];
        if LEANS {
            for (chunk, facets) in self.chunks_of(&kept).iter_mut().zip(facets) {
                let [along, aside, up] = face.facing(simd, facets);
                let steep = splat(simd, 1.0) / along.abs().max(splat(simd, STEEPEST));
                (chunk.aside, chunk.up) = ((aside * steep).into(), (-up * steep).into());
            }
        } else {
            for (facing, facets) in self.facing_of(&kept).iter_mut().zip(facets) {
                *facing = face.facing(simd, facets).map(Eight::from);
            }
        }
    }
}

impl Face<'_> {
    /// Which way the clay pushes: against the normals, along the ray, across it and up.
    #[inline(always)]
    fn facing<S: Simd>(&self, simd: S, facets: &[u16; LANES]) -> [f32x8<S>; 3] {
        // one way for one facet and for many: whether a chunk has one alone is hard to foresee
        let [x, y, z, _] = columns(
            simd,
            #[inline(always)]
            |lane| self.normals[usize::from(facets[lane])],
        );
        let [x, y, z] = [f32x8::from_bits(x), f32x8::from_bits(y), f32x8::from_bits(z)];
        // written out: mapped, it would be a function of its own
        let [ray, across, up] = self.axes;
        [x * ray.x + y * ray.y + z * ray.z, x * across.x + y * across.y + z * across.z, x * up.x + y * up.y + z * up.z]
    }
}

/// Which side of a tool meets clay from a side of a wall, how far it is looked for, m, and which way it presses.
pub(super) const fn met(side: Side, reach_m: f32) -> (Sides, f32, f32) {
    match side {
        Side::Outside => (Sides::Near, reach_m, 1.0),
        Side::Inside => (Sides::Far, reach_m.max(0.0), -1.0),
    }
}

/// The opposites of a column's ray, the direction across it and the way up, as a turned tool sees them.
pub(super) fn axes(turn: &Mat3, [cos, sin]: [f32; 2]) -> [Vec3; 3] {
    let columns = [turn.x_axis, turn.y_axis, turn.z_axis];
    let [along, across] = [(-cos, -sin), (sin, -cos)].map(|(x, y)| columns.map(|axis| axis.x * x + axis.y * y));
    [along, across, columns.map(|axis| -axis.z)].map(Vec3::from_array)
}
