//! Thinning of a tool that is finer than people can share.
//!
//! Owns the choice of corners; what is left is a tool like any other.
//! Invariant: the corners that are left are the tool's own, apart from one scale for all of them.

use std::cmp::Ordering;

use glam::{DVec3, Vec3};
use pottery_shared::tool::ConvexTool;
use pottery_shared::units::Metres;

/// A tool with fewer triangles than another, and how far it is from that.
#[derive(Clone, Debug)]
pub struct Thinned {
    /// The tool.
    pub tool: ConvexTool,
    /// Largest distance, in the direction of one of its facets, between it and the other.
    pub apart: Metres,
}

impl Thinned {
    /// The same tool with no more than so many triangles.
    ///
    /// A hull grows from four far corners, always by the one that stands out farthest, as in quickhull (Barber, Dobkin and Huhdanpaa
    /// 1996), until there is no room for another or none stands out. It lies inside of the tool, and is scaled about its centre to
    /// the tool's volume, so that it lies as much outside as inside: a ball's mean depth stays a ball's. What is thin would become
    /// longer by that than it was: no corner moves by more than half of what the hull was off.
    ///
    /// `None` for fewer than four triangles, or where what is left is no tool: simplify the mesh elsewhere.
    #[must_use]
    pub fn of(tool: &ConvexTool, triangles: usize) -> Option<Self> {
        if triangles < ConvexTool::TRIANGLES_MIN {
            return None;
        }
        let mut corners: Vec<DVec3> = tool.triangles_m().flatten().map(Vec3::as_dvec3).collect();
        // a corner is told with each of its triangles
        corners.sort_by(|one, other| one.to_array().partial_cmp(&other.to_array()).unwrap_or(Ordering::Equal));
        corners.dedup();
        let mut hull = Hull::begin(&corners)?;
        while hull.facets.len() + 2 <= triangles && hull.grow() {}
        let facets = hull.facets.iter().map(|facet| facet.corners.map(|corner| corners[corner].as_vec3()));
        let inscribed: Vec<_> = facets.collect();
        let inside = ConvexTool::new(&inscribed).ok()?;
        let most = 1.0 + 0.5 * apart_m(&inscribed, &corners) / inside.radius().0;
        let (centre_m, scale) = (inside.centre_m(), (tool.volume_m3() / inside.volume_m3()).cbrt().min(most));
        let scaled = |corner: Vec3| centre_m + (corner - centre_m) * scale;
        let facets: Vec<_> = inscribed.into_iter().map(|facet| facet.map(scaled)).collect();
        let apart = Metres(apart_m(&facets, &corners));
        ConvexTool::new(&facets).ok().map(|tool| Self { tool, apart })
    }
}

/// Largest distance between a facet and where the corners end in its direction, m.
fn apart_m(facets: &[[Vec3; 3]], corners: &[DVec3]) -> f32 {
    let apart_m = facets.iter().filter_map(|facet| {
        let Plane { normal, offset } = Plane::through(facet.map(Vec3::as_dvec3))?;
        let end = corners.iter().map(|corner| normal.dot(*corner)).fold(f64::MIN, f64::max);
        Some((end - offset).abs())
    });
    apart_m.fold(0.0, f64::max) as f32
}

/// A plane, by its unit normal and how far along it lies, m.
#[derive(Clone, Copy)]
struct Plane {
    normal: DVec3,
    offset: f64,
}

impl Plane {
    /// Through three corners, outwards where they go counter-clockwise; none through a line.
    fn through([a, b, c]: [DVec3; 3]) -> Option<Self> {
        let normal = (b - a).cross(c - a).try_normalize()?;
        Some(Self { normal, offset: normal.dot(a) })
    }

    fn height_m(&self, corner: DVec3) -> f64 {
        self.normal.dot(corner) - self.offset
    }
}

struct Facet {
    corners: [usize; 3],
    /// That of a neighbour, for a sliver.
    plane: Plane,
    /// Corners that stand out of it and belong to no other facet, the farthest last, and how far that is.
    outside: Vec<usize>,
    farthest: Rank,
}

/// How far a corner stands out, µm, and how far it lies from the tool's centre, m: of those that stand out alike, which lie in a plane or on
/// a line, the one farthest from there is at an end.
type Rank = (i64, f64);

fn rank(height_m: f64, corner: DVec3) -> Rank {
    ((height_m * 1e6).round() as i64, corner.length_squared())
}

fn order(one: &Rank, other: &Rank) -> Ordering {
    one.0.cmp(&other.0).then(one.1.total_cmp(&other.1))
}

/// A convex hull of some of the corners.
struct Hull<'a> {
    all: &'a [DVec3],
    facets: Vec<Facet>,
}

impl<'a> Hull<'a> {
    /// A corner that stands out by less need not be taken in, m: ten times what corners are rounded by, a fiftieth of what a tool may bulge.
    const LEVEL_M: f64 = 1e-7;
    /// What one that is taken in sees stands farther below it, m: corners are exact, and heights above a facet to a thirtieth of this. By a
    /// sliver that it sees and that is kept, a long tool would bulge.
    const SEEN_M: f64 = 1e-15;

    /// The hull of four corners far from each other.
    fn begin(all: &'a [DVec3]) -> Option<Self> {
        let farthest = |height_m: &dyn Fn(DVec3) -> f64| {
            let rank_of = |at: usize| rank(height_m(all[at]), all[at]);
            (0..all.len()).max_by(|one, other| order(&rank_of(*one), &rank_of(*other)))
        };
        let a = farthest(&|corner| corner.length())?;
        let b = farthest(&|corner| corner.distance(all[a]))?;
        let along = (all[b] - all[a]).try_normalize()?;
        let c = farthest(&|corner| (corner - all[a]).reject_from_normalized(along).length())?;
        let plane = Plane::through([a, b, c].map(|corner| all[corner]))?;
        let d = farthest(&|corner| plane.height_m(corner).abs())?;
        let [a, b] = if plane.height_m(all[d]) > 0.0 { [b, a] } else { [a, b] };
        let mut hull = Self { all, facets: Vec::new() };
        for corners in [[a, b, c], [a, d, b], [b, d, c], [c, d, a]] {
            hull.add(corners, plane);
        }
        hull.share_out((0..all.len()).collect());
        (plane.height_m(all[d]).abs() > Self::LEVEL_M).then_some(hull)
    }

    fn add(&mut self, corners: [usize; 3], of_neighbour: Plane) {
        let plane = Plane::through(corners.map(|corner| self.all[corner])).unwrap_or(of_neighbour);
        self.facets.push(Facet { corners, plane, outside: Vec::new(), farthest: (0, 0.0) });
    }

    /// Gives corners to the facets of which they stand out farthest; what stands out of none lies inside.
    fn share_out(&mut self, corners: Vec<usize>) {
        for corner in corners {
            let at = self.all[corner];
            let heights_m = self.facets.iter_mut().map(|facet| (facet.plane.height_m(at), facet));
            let Some((height_m, facet)) = heights_m.max_by(|one, other| one.0.total_cmp(&other.0)) else { continue };
            if height_m <= Self::LEVEL_M {
                continue;
            }
            let found = rank(height_m, at);
            match facet.outside.last_mut() {
                Some(last) if order(&found, &facet.farthest).is_lt() => {
                    let farthest = std::mem::replace(last, corner);
                    facet.outside.push(farthest);
                }
                _ => {
                    facet.farthest = found;
                    facet.outside.push(corner);
                }
            }
        }
    }

    /// Takes in the corner that stands out farthest; false when none does.
    fn grow(&mut self) -> bool {
        let with_some = self.facets.iter_mut().filter(|facet| !facet.outside.is_empty());
        let farthest = with_some.max_by(|one, other| order(&one.farthest, &other.farthest));
        let Some(corner) = farthest.and_then(|facet| facet.outside.pop()) else { return false };
        let at = self.all[corner];
        let is_seen = |facet: &mut Facet| facet.plane.height_m(at) > Self::SEEN_M;
        let seen: Vec<Facet> = self.facets.extract_if(.., is_seen).collect();
        let sides = |facet: &Facet| {
            let ([a, b, c], plane) = (facet.corners, facet.plane);
            [(a, b, plane), (b, c, plane), (c, a, plane)]
        };
        let sides: Vec<_> = seen.iter().flat_map(sides).collect();
        // seen from there, the hull ends at sides that only one of its facets has
        for &(from, to, plane) in &sides {
            if !sides.iter().any(|&(begin, end, _)| (begin, end) == (to, from)) {
                self.add([from, to, corner], plane);
            }
        }
        self.share_out(seen.into_iter().flat_map(|facet| facet.outside).collect());
        true
    }
}
