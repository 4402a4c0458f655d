//! Collision of a convex tool of flat facets with the elements: the same chunks as a sphere's, and the way each facet faces.
//!
//! Owns the convex tools of a sub-step and the memory one is cut in; what a touch does to the clay is the methods'.
//! Invariant: what is found depends on tool, pose and radii alone, and every touched element stands in exactly one chunk.

use alloc::sync::Arc;

use glam::Vec3;

use super::contact::{Column, Contacts, Ground, Tally, nearest_turn};
use super::lanes::{Eight, LANES, Simd, SimdBase, f32x8, load, root, splat};
use super::window::Scratch;
use super::{GridShape, Press, Window};
use crate::tool::{ConvexTool, Eights, Pose, Ray, Sections, Shape, Side, Sides, Tool};

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

/// Where a section is pressed: the column, what of it the tool covers, and the angle of the ray along which it was cut from the tool's centre,
/// rad, and its direction.
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
        let (sides, reach_m) = met(press.side, reach_m);
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
            let ray = Ray::new(tool, &turn, press.centre_m, direction, (sides, section.bound_m));
            let place = Place { column, share: 1.0, angle_rad, direction };
            self.gather_section::<S, LEANS, G>(simd, ground, (&section, &ray), &place, behind_m, &mut tally);
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

    /// Finds the elements of a column that a section touches, `behind_m` inside of the ground's radii, as seen along a ray.
    #[inline(always)]
    pub(super) fn gather_section<S: Simd, const LEANS: bool, G: Ground>(
        &mut self,
        simd: S,
        ground: &mut G,
        (section, ray): (&Eights<'_>, &Ray<'_>),
        place: &Place,
        behind_m: f32,
        tally: &mut Tally<S>,
    ) {
        let Place { column, share, angle_rad, direction } = *place;
        let Eights { first_row, facets, .. } = *section;
        let first = (first_row - self.window.first_row) / LANES as u32;
        let chunks = first..first + facets.len() as u32;
        let rows = first_row..first_row + (facets.len() * LANES) as u32;
        let (whole_m, last_m) = ground.radii_m(column, rows).as_chunks::<LANES>();
        let centre_m = ray.centre_m();
        let mut at = Column::new(column, self.window, chunks, angle_rad, direction, centre_m);
        at.share = share;
        let (centre_m, outwards) = (centre_m[0] + behind_m, ray.outwards());
        let kept = self.add_column(
            at,
            #[inline(always)]
            |number, above_m, chunk| {
                let radius_m = match whole_m.get(number) {
                    Some(lanes) => f32x8::load_array_ref(simd, lanes),
                    None => load(simd, last_m),
                };
                let met = ray.meet(simd, &facets[number], above_m.on(simd));
                // beyond the tool no clay is touched
                let penetration_m = ((radius_m - centre_m) * outwards + met.beyond_m).max(splat(simd, 0.0));
                (chunk.penetration_m, chunk.radius_m) = (penetration_m.into(), radius_m.into());
                if LEANS {
                    let [_, aside, up] = met.facing;
                    (chunk.aside, chunk.up) = ((aside * met.steep).into(), (-up * met.steep).into());
                }
                penetration_m
            },
            tally,
        );
        let Some(kept) = kept else { return };
        if LEANS {
            return;
        }
        let facets = &facets[((kept.first_row - first_row) / LANES as u32) as usize..];
        for (facing, facets) in self.facing_of(&kept).iter_mut().zip(facets) {
            *facing = ray.facing(simd, facets).0.map(Eight::from);
        }
    }
}

/// Which side of a tool meets clay from a side of a wall, and how far it is looked for, m.
pub(super) const fn met(side: Side, reach_m: f32) -> (Sides, f32) {
    match side {
        Side::Outside => (Sides::Near, reach_m),
        Side::Inside => (Sides::Far, reach_m.max(0.0)),
    }
}
