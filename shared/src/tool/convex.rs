//! A convex tool of flat facets: checked once, when it is made, and never again.
//!
//! Owns the corners, the facets' neighbourhood and their normals; where the tool is held and what it cuts is
//! `section.rs`.
//! Invariant: a tool that exists is closed, turned outwards, convex to within [`ConvexTool::BULGE_MAX`], and within the
//! allowed sizes.

use alloc::vec::Vec;
use core::fmt;

use glam::{DVec3, Vec3, Vec4};

use super::facets::{Facets, Link, after, beside, solids};
use super::ray::{Plane, planes};
use super::ridges::Ridges;
use crate::lanes::root;
use crate::units::Metres;

/// Why triangles do not make a convex tool.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum ConvexError {
    /// A coordinate is not a number or endless; write the mesh again.
    #[error("triangle {triangle} has a coordinate that is not a finite number: write the mesh again")]
    NotANumber {
        /// Number of the triangle, from 0.
        triangle: usize,
    },
    /// A solid has at least four triangles.
    #[error("{triangles} triangles enclose nothing: a tool needs from {min} to {max}")]
    TooFew {
        /// How many there are.
        triangles: usize,
        /// Fewest allowed.
        min: usize,
        /// Most allowed.
        max: usize,
    },
    /// More triangles than a tool may have, of which whoever reads a file counts no more than one; simplify the mesh.
    #[error("more than {max} triangles are too many: a tool has from {min} to {max}; simplify the mesh")]
    TooMany {
        /// How many there are.
        triangles: usize,
        /// Fewest allowed.
        min: usize,
        /// Most allowed.
        max: usize,
    },
    /// The tool is too small or too large; scale it, or look whether its file is in millimetres.
    #[error("the tool reaches {radius_mm} mm from its centre: it must be from {min_mm} to {max_mm} mm; check its unit")]
    Size {
        /// Largest distance of a corner from the centre, mm.
        radius_mm: f32,
        /// Smallest allowed, mm.
        min_mm: f32,
        /// Largest allowed, mm.
        max_mm: f32,
    },
    /// A side has no neighbour: there is a hole; close it.
    #[error("the mesh is open at the side from {from_mm:?} to {to_mm:?} mm: close the hole")]
    Open {
        /// One end of the side, mm.
        from_mm: [f32; 3],
        /// The other end, mm.
        to_mm: [f32; 3],
    },
    /// Two neighbours run along their side the same way: one of them is turned; turn it back.
    #[error(
        "two triangles at the side from {from_mm:?} to {to_mm:?} mm face opposite ways: make all of them face outwards"
    )]
    Twisted {
        /// One end of the side, mm.
        from_mm: [f32; 3],
        /// The other end, mm.
        to_mm: [f32; 3],
    },
    /// More than two triangles meet at a side; leave one solid only.
    #[error("{facets} triangles meet at the side from {from_mm:?} to {to_mm:?} mm: a single solid has two")]
    Crowded {
        /// How many meet.
        facets: usize,
        /// One end of the side, mm.
        from_mm: [f32; 3],
        /// The other end, mm.
        to_mm: [f32; 3],
    },
    /// Surfaces that have no side in common; leave one.
    #[error("the mesh holds {solids} solids: a tool is a single one, so leave the others out")]
    Several {
        /// How many there are.
        solids: usize,
    },
    /// All triangles face inwards; turn them.
    #[error("the mesh is inside out (its volume is {volume_mm3} mm³): turn every triangle round")]
    InsideOut {
        /// The volume as the triangles enclose it, negative, mm³.
        volume_mm3: f32,
    },
    /// The tool is flat; give it thickness.
    #[error("the tool is {thickness_mm} mm thick: it must be at least {min_mm} mm")]
    Thin {
        /// Least distance between a facet's plane and the corner farthest behind it, mm.
        thickness_mm: f32,
        /// Smallest allowed, mm.
        min_mm: f32,
    },
    /// Something stands out beyond a facet's plane; take the convex hull.
    #[error(
        "the mesh is not convex: the corner at {corner_mm:?} mm stands {bulge_mm} mm out of the plane of a triangle, \
         {max_mm} mm are allowed; use the convex hull of the mesh, or several tools"
    )]
    NotConvex {
        /// The corner, mm.
        corner_mm: [f32; 3],
        /// How far it stands out, mm.
        bulge_mm: f32,
        /// Farthest allowed, mm.
        max_mm: f32,
    },
}

/// A convex tool: rib, blade, knuckle, loop, or what a file holds.
///
/// Its place is said by its centre of volume, as a sphere's is by its centre, and it turns about it. The origin of a
/// file is wherever its author began to draw, up to metres away, where the least turn would swing the tool.
#[derive(Clone)]
pub struct ConvexTool {
    /// Corners from the centre, m, with 0 in the last lane.
    corners_m: Vec<Vec4>,
    links: Vec<Link>,
    normals: Vec<Vec3>,
    steps: Vec<[u32; 4]>,
    planes: Vec<Plane>,
    /// A side that begins at the corner farthest in the direction of each [`cell`].
    outermost: Vec<u16>,
    centre_m: Vec3,
    radius: Metres,
    volume_m3: f32,
    bluntness: Metres,
    ridges: Ridges,
}

/// Cells on an edge of the cube of directions.
const CELLS: usize = 8;
/// A facet is a sliver, too narrow to have a direction, below this height, m.
const SLIVER_M: f64 = 1e-6;

impl ConvexTool {
    /// Fewest triangles: a tetrahedron.
    pub const TRIANGLES_MIN: usize = 4;
    /// Most triangles: a sphere subdivided five times, 20·4⁵; three times as many sides still have 16-bit numbers.
    pub const TRIANGLES_MAX: usize = 20_480;
    /// Least reach from the centre, that of the smallest sphere.
    pub const RADIUS_MIN: Metres = super::Sphere::RADIUS_MIN;
    /// Largest reach from the centre: a paddle of 30 cm.
    pub const RADIUS_MAX: Metres = Metres::from_mm(150.0);
    /// Least thickness: below it every section is thinner than the rows of the finest grid are apart.
    pub const THICKNESS_MIN: Metres = Metres::from_mm(0.1);
    /// Farthest a corner may stand out of a facet's plane: about the 2⁻¹⁸ m to which clay is rounded where it is sent, and
    /// what six digits in a file leave of a plane.
    pub const BULGE_MAX: Metres = Metres::from_mm(0.005);

    /// A tool whose surface is `triangles_m`, corners in m, counter-clockwise seen from outside.
    ///
    /// Corners nearer than 1 µm are joined, and triangles that lose their area thereby are left out.
    ///
    /// # Errors
    /// The first [`ConvexError`] that is found.
    ///
    /// ```
    /// use glam::Vec3;
    /// use pottery_shared::tool::ConvexTool;
    ///
    /// let [o, x, y, z] = [Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z].map(|corner| corner * 0.01);
    /// let tool = ConvexTool::new(&[[o, y, x], [o, x, z], [o, z, y], [x, y, z]])?;
    /// // a corner of a cube: a sixth of its volume, and its centre a quarter of the way in
    /// assert!((tool.volume_m3() - 1e-6 / 6.0).abs() < 1e-12);
    /// assert!(tool.centre_m().distance(Vec3::splat(0.0025)) < 1e-8);
    /// # Ok::<(), pottery_shared::tool::ConvexError>(())
    /// ```
    pub fn new(triangles_m: &[[Vec3; 3]]) -> Result<Self, ConvexError> {
        check_count_and_numbers(triangles_m)?;
        // no corner is farther from the centre than 2√3 of it, and one is as far
        let half_extent_m = half_extent_m(triangles_m);
        check_size(half_extent_m, 0.25)?;
        let mesh = Facets::join(triangles_m);
        if mesh.facets.len() < Self::TRIANGLES_MIN {
            let (triangles, min, max) = (mesh.facets.len(), Self::TRIANGLES_MIN, Self::TRIANGLES_MAX);
            return Err(ConvexError::TooFew { triangles, min, max });
        }
        let links = mesh.links()?;
        let solids = solids(&links);
        if solids > 1 {
            return Err(ConvexError::Several { solids });
        }
        let (volume_m3, centre_m) = volume_and_centre(&mesh);
        let volume_mm3 = (volume_m3 * 1e9) as f32;
        if volume_m3 < 0.0 {
            return Err(ConvexError::InsideOut { volume_mm3 });
        }
        let normals = normals(&mesh, &links).ok_or(thin(Metres(0.0)))?;
        check_planes(&mesh, &normals)?;
        let corners_m: Vec<Vec4> = mesh.corners_m.iter().map(|corner| (*corner - centre_m).extend(0.0)).collect();
        let reach_m = |corner: &Vec4| root(corner.x * corner.x + corner.y * corner.y + corner.z * corner.z);
        let radius = Metres(corners_m.iter().map(reach_m).fold(0.0, f32::max));
        check_size(radius.0, 1.0)?;
        let bluntness = Metres((3.0 * volume_m3 / area_m2(&mesh)) as f32);
        let (volume_m3, outermost) = (volume_m3 as f32, Vec::new());
        let first_m = |facet: &[u16; 3]| corners_m[usize::from(facet[0])].truncate().as_dvec3();
        let distances_m = mesh.facets.iter().zip(&normals);
        let distances_m = distances_m.map(|(facet, normal)| normal.as_dvec3().dot(first_m(facet)) as f32);
        let planes = planes(&normals, distances_m);
        let step = |link: &Link| {
            let [x, y, z, _] = corners_m[usize::from(link.apex)].to_array().map(f32::to_bits);
            [x, y, z, u32::from(link.onward[0]) | u32::from(link.onward[1]) << 16]
        };
        let steps = links.iter().map(step).collect();
        let ridges = Ridges::default();
        let mut tool = Self {
            corners_m,
            links,
            normals,
            steps,
            planes,
            outermost,
            centre_m,
            radius,
            volume_m3,
            bluntness,
            ridges,
        };
        tool.outermost = tool.find_outermost();
        tool.ridges = Ridges::of(&tool);
        Ok(tool)
    }

    /// Its triangles from its centre, m, counter-clockwise seen from outside.
    pub fn triangles_m(&self) -> impl ExactSizeIterator<Item = [Vec3; 3]> {
        self.links.chunks_exact(3).map(|sides| {
            // the apex of a facet's first side is its third corner
            [sides[1].apex, sides[2].apex, sides[0].apex].map(|corner| self.corners_m[usize::from(corner)].truncate())
        })
    }

    /// Outward unit normal of every triangle, in the order of [`ConvexTool::triangles_m`].
    #[must_use]
    pub fn normals(&self) -> &[Vec3] {
        &self.normals
    }

    /// Its centre of volume in the coordinates in which its triangles were given, m.
    #[must_use]
    pub const fn centre_m(&self) -> Vec3 {
        self.centre_m
    }

    /// Largest distance of a corner from the centre.
    #[must_use]
    pub const fn radius(&self) -> Metres {
        self.radius
    }

    /// Its volume, m³.
    #[must_use]
    pub const fn volume_m3(&self) -> f32 {
        self.volume_m3
    }

    /// Radius of the sphere with as much volume to its surface, 3·V/A: small for what is thin.
    #[must_use]
    pub const fn bluntness(&self) -> Metres {
        self.bluntness
    }

    /// The planes of its triangles, and that of none.
    pub(super) fn planes(&self) -> &[Plane] {
        &self.planes
    }

    /// Its edges, if one of them is sharp.
    pub(super) const fn ridges(&self) -> &Ridges {
        &self.ridges
    }

    /// How many sides its triangles have.
    pub(super) const fn sides(&self) -> usize {
        self.links.len()
    }

    /// Of every side bits of its facet's apex, from the centre, m, and the two sides that lead onward from it, 16 bits each:
    /// what a walk needs at once.
    pub(super) fn steps(&self) -> &[[u32; 4]] {
        &self.steps
    }

    /// Corners from the centre, m, with 0 in the last lane.
    pub(super) fn corners_m(&self) -> &[Vec4] {
        &self.corners_m
    }

    pub(super) fn link(&self, side: u16) -> &Link {
        &self.links[usize::from(side)]
    }

    /// Where a side begins.
    pub(super) fn origin(&self, side: u16) -> u16 {
        self.link(side).origin
    }

    /// Where a side ends.
    pub(super) fn end(&self, side: u16) -> u16 {
        self.link(after(side)).origin
    }

    /// The same side from its other end.
    pub(super) fn twin(&self, side: u16) -> u16 {
        self.link(after(side)).onward[0]
    }

    /// A side that begins at the corner farthest along `direction`, or near it.
    pub(super) fn outermost(&self, direction: Vec3) -> u16 {
        self.climb(self.outermost[cell(direction)], direction)
    }

    /// From where `side` begins, up along `direction` to the farthest corner.
    ///
    /// On a convex solid a corner that is farther than its neighbours is the farthest of all.
    pub(super) fn climb(&self, mut side: u16, direction: Vec3) -> u16 {
        let along = |corner: u16| {
            let corner = self.corners_m[usize::from(corner)];
            corner.x * direction.x + corner.y * direction.y + corner.z * direction.z
        };
        let mut farthest = along(self.origin(side));
        loop {
            let (first, mut next) = (side, None);
            loop {
                let link = self.link(side);
                let reached = along(link.apex);
                if reached > farthest {
                    (farthest, next) = (reached, Some(link.onward[1]));
                }
                side = link.onward[0];
                if side == first {
                    break;
                }
            }
            match next {
                Some(higher) => side = higher,
                None => return side,
            }
        }
    }

    fn find_outermost(&self) -> Vec<u16> {
        let mut side = 0;
        let mut found = Vec::with_capacity(6 * CELLS * CELLS);
        for number in 0..6 * CELLS * CELLS {
            side = self.climb(side, middle_of(number));
            found.push(side);
        }
        found
    }
}

impl fmt::Debug for ConvexTool {
    /// The measures: corners by the thousand say nothing.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("ConvexTool")
            .field("triangles", &self.normals.len())
            .field("radius", &self.radius)
            .field("volume_m3", &self.volume_m3)
            .finish_non_exhaustive()
    }
}

/// The cell of the cube of directions that a direction goes through.
fn cell(direction: Vec3) -> usize {
    let size = direction.abs();
    let (face, along, across) = if size.x >= size.y && size.x >= size.z {
        (0, direction.x, [direction.y, direction.z])
    } else if size.y >= size.z {
        (2, direction.y, [direction.z, direction.x])
    } else {
        (4, direction.z, [direction.x, direction.y])
    };
    // a direction of no length takes any cell: a cast ends at the ends of its type, and not a number becomes 0
    let [first, second] = across.map(|part| ((part / along.abs() + 1.0) * (CELLS as f32 / 2.0)) as usize);
    ((face + usize::from(along < 0.0)) * CELLS + first.min(CELLS - 1)) * CELLS + second.min(CELLS - 1)
}

/// The middle of a cell, of any length.
fn middle_of(cell: usize) -> Vec3 {
    let [first, second] = [cell / CELLS % CELLS, cell % CELLS].map(|at| (2 * at + 1) as f32 / CELLS as f32 - 1.0);
    let face = cell / (CELLS * CELLS);
    let along = if face.is_multiple_of(2) { 1.0 } else { -1.0 };
    match face / 2 {
        0 => Vec3::new(along, first, second),
        1 => Vec3::new(second, along, first),
        _ => Vec3::new(first, second, along),
    }
}

fn check_count_and_numbers(triangles_m: &[[Vec3; 3]]) -> Result<(), ConvexError> {
    let (triangles, min, max) = (triangles_m.len(), ConvexTool::TRIANGLES_MIN, ConvexTool::TRIANGLES_MAX);
    if triangles > max {
        return Err(ConvexError::TooMany { triangles, min, max });
    }
    let broken = triangles_m.iter().position(|triangle| !triangle.iter().all(|corner| corner.is_finite()));
    if let Some(triangle) = broken {
        return Err(ConvexError::NotANumber { triangle });
    }
    if triangles < min { Err(ConvexError::TooFew { triangles, min, max }) } else { Ok(()) }
}

/// Half the longest edge of the box round the triangles, m.
fn half_extent_m(triangles_m: &[[Vec3; 3]]) -> f32 {
    let all = || triangles_m.iter().flatten().copied();
    let (low, high) = (all().fold(Vec3::MAX, Vec3::min), all().fold(Vec3::MIN, Vec3::max));
    (high * 0.5 - low * 0.5).max_element()
}

/// Whether a distance from the centre is allowed, the least one with a share of leeway.
fn check_size(radius_m: f32, leeway: f32) -> Result<(), ConvexError> {
    let (min, max) = (ConvexTool::RADIUS_MIN, ConvexTool::RADIUS_MAX);
    if radius_m >= min.0 * leeway && radius_m <= max.0 {
        Ok(())
    } else {
        Err(ConvexError::Size { radius_mm: Metres(radius_m).told_mm(), min_mm: min.as_mm(), max_mm: max.as_mm() })
    }
}

fn thin(thickness: Metres) -> ConvexError {
    ConvexError::Thin { thickness_mm: thickness.told_mm(), min_mm: ConvexTool::THICKNESS_MIN.as_mm() }
}

/// Divergence theorem, over the tetrahedra from one corner of the mesh: `V = Σ a·(b × c)/6`, centre `Σ V_i(a+b+c)/4 / V`.
fn volume_and_centre(mesh: &Facets) -> (f64, Vec3) {
    let apex = mesh.corners_m[0].as_dvec3();
    let (mut six_volumes, mut weighted) = (0.0, DVec3::ZERO);
    for facet in &mesh.facets {
        let [a, b, c] = facet.map(|corner| mesh.corners_m[usize::from(corner)].as_dvec3() - apex);
        let six_volume = a.dot(b.cross(c));
        six_volumes += six_volume;
        weighted += six_volume * (a + b + c);
    }
    let centre = if six_volumes == 0.0 { apex } else { apex + weighted / (4.0 * six_volumes) };
    (six_volumes / 6.0, centre.as_vec3())
}

fn area_m2(mesh: &Facets) -> f64 {
    let area = |facet: &[u16; 3]| {
        let [a, b, c] = facet.map(|corner| mesh.corners_m[usize::from(corner)].as_dvec3());
        0.5 * libm::sqrt((b - a).cross(c - a).length_squared())
    };
    mesh.facets.iter().map(area).sum()
}

/// Outward unit normals; a sliver takes that of a neighbour. None when all are slivers.
fn normals(mesh: &Facets, links: &[Link]) -> Option<Vec<Vec3>> {
    let normal = |facet: &[u16; 3]| {
        let [a, b, c] = facet.map(|corner| mesh.corners_m[usize::from(corner)].as_dvec3());
        let sides = [b - a, c - b, a - c];
        let longest = sides.iter().map(|side| side.length_squared()).fold(0.0, f64::max);
        let twice_area = sides[0].cross(sides[1]);
        let size = libm::sqrt(twice_area.length_squared());
        (size > SLIVER_M * libm::sqrt(longest)).then(|| (twice_area / size).as_vec3())
    };
    let mut found: Vec<Option<Vec3>> = mesh.facets.iter().map(normal).collect();
    // a sliver among slivers has to wait for them
    while found.contains(&None) {
        let before = found.clone();
        for (facet, normal) in found.iter_mut().enumerate() {
            *normal = normal.or(beside(links, facet).into_iter().find_map(|facet| before[facet]));
        }
        if found == before {
            return None;
        }
    }
    found.into_iter().collect()
}

/// Every corner against every facet's plane: none may stand out, and one has to lie well behind.
fn check_planes(mesh: &Facets, normals: &[Vec3]) -> Result<(), ConvexError> {
    let mut thickness_m = f32::MAX;
    let (mut bulge_m, mut bulging) = (0.0, 0);
    for (facet, normal) in mesh.facets.iter().zip(normals) {
        let on_it = mesh.corners_m[usize::from(facet[0])];
        let (mut lowest, mut highest, mut at) = (0.0_f32, 0.0, 0);
        for (corner, place) in mesh.corners_m.iter().enumerate() {
            let out = normal.dot(*place - on_it);
            lowest = lowest.min(out);
            if out > highest {
                (highest, at) = (out, corner);
            }
        }
        thickness_m = thickness_m.min(-lowest);
        if highest > bulge_m {
            (bulge_m, bulging) = (highest, at);
        }
    }
    if bulge_m > ConvexTool::BULGE_MAX.0 {
        let corner_mm = mesh.corners_m[bulging].to_array().map(|along_m| Metres(along_m).told_mm());
        let (bulge_mm, max_mm) = (Metres(bulge_m).told_mm(), ConvexTool::BULGE_MAX.told_mm());
        return Err(ConvexError::NotConvex { corner_mm, bulge_mm, max_mm });
    }
    if thickness_m < ConvexTool::THICKNESS_MIN.0 { Err(thin(Metres(thickness_m))) } else { Ok(()) }
}
