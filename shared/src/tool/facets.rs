//! A closed surface of triangles: corners joined, sides paired, found to be whole.
//!
//! Knows nothing of convexity or size. Integer and exact comparisons only, apart from the joining of corners.
//! Invariant: every side of a facet that exists has exactly one other, which runs the opposite way.

use alloc::vec::Vec;

use glam::Vec3;

use super::ConvexError;
use crate::units::Metres;

/// One side a → b of a facet a, b, c, seen by who enters the facet through it.
#[derive(Clone, Copy, Debug)]
pub(super) struct Link {
    /// Number of the corner c.
    pub(super) apex: u16,
    /// Number of the corner a.
    pub(super) origin: u16,
    /// The sides of the neighbours across the two others, as entered there: a → c and c → b.
    pub(super) onward: [u16; 2],
}

/// The side after `side` in its facet; three sides of one facet follow each other.
pub(super) const fn after(side: u16) -> u16 {
    if side % 3 == 2 { side - 2 } else { side + 1 }
}

/// How many surfaces there are that have no side in common.
pub(super) fn solids(links: &[Link]) -> usize {
    let mut is_seen = alloc::vec![false; links.len() / 3];
    let mut waiting = Vec::new();
    let mut found = 0;
    for first in 0..is_seen.len() {
        found += usize::from(!is_seen[first]);
        waiting.push(first);
        while let Some(facet) = waiting.pop() {
            if !core::mem::replace(&mut is_seen[facet], true) {
                waiting.extend(beside(links, facet));
            }
        }
    }
    found
}

/// The neighbours of a facet.
pub(super) fn beside(links: &[Link], facet: usize) -> [usize; 3] {
    let ([first, second], [third, _]) = (links[3 * facet].onward, links[3 * facet + 1].onward);
    [first, second, third].map(|side| usize::from(side / 3))
}

/// Corners and facets of a mesh, facets by the numbers of their corners.
pub(super) struct Facets {
    pub(super) corners_m: Vec<Vec3>,
    pub(super) facets: Vec<[u16; 3]>,
}

impl Facets {
    /// Corners nearer than this are one: far above what `f32` and six digits in a file leave, far below any tool.
    const JOIN_M: f32 = 1e-6;

    /// Joins equal corners and leaves out facets that thereby lose their area.
    ///
    /// The number of triangles is checked before: three corners each have to fit in 16 bits.
    pub(super) fn join(triangles_m: &[[Vec3; 3]]) -> Self {
        let all: Vec<Vec3> = triangles_m.iter().flatten().copied().collect();
        // along a line that no common plane is upright on, so that few corners share a place on it
        let along_m = |corner: Vec3| 0.61 * corner.x + 0.53 * corner.y + 0.59 * corner.z;
        let mut order: Vec<usize> = (0..all.len()).collect();
        order.sort_by(|&a, &b| along_m(all[a]).total_cmp(&along_m(all[b])).then(a.cmp(&b)));
        let mut number = alloc::vec![0_u16; all.len()];
        let mut corners_m: Vec<Vec3> = Vec::new();
        let mut first_near = 0;
        for &at in &order {
            let place = all[at];
            let passed = |corner: &Vec3| along_m(*corner) < along_m(place) - 2.0 * Self::JOIN_M;
            while corners_m.get(first_near).is_some_and(passed) {
                first_near += 1;
            }
            let near = |corner: &Vec3| (*corner - place).abs().max_element() <= Self::JOIN_M;
            let known = corners_m[first_near..].iter().position(near).map(|found| found + first_near);
            number[at] = known.unwrap_or(corners_m.len()) as u16;
            if known.is_none() {
                corners_m.push(place);
            }
        }
        let facets = number.chunks_exact(3).map(|three| [three[0], three[1], three[2]]);
        let facets = facets.filter(|[a, b, c]| a != b && b != c && c != a).collect();
        Self { corners_m, facets }
    }

    /// Pairs the sides.
    ///
    /// # Errors
    /// [`ConvexError::Open`], [`ConvexError::Twisted`] or [`ConvexError::Crowded`] at the first side that does not have
    /// one partner in the opposite direction.
    pub(super) fn links(&self) -> Result<Vec<Link>, ConvexError> {
        let side = |number: usize| {
            let (facet, which) = (self.facets[number / 3], number % 3);
            (facet[which], facet[(which + 1) % 3])
        };
        let sides = 3 * self.facets.len();
        let mut order: Vec<u16> = (0..sides).map(|number| number as u16).collect();
        order.sort_by_key(|&number| side(usize::from(number)));
        let place_mm =
            |corner: u16| self.corners_m[usize::from(corner)].to_array().map(|along_m| Metres(along_m).told_mm());
        let alike = |key: (u16, u16)| {
            let first = order.partition_point(|&number| side(usize::from(number)) < key);
            let end = order.partition_point(|&number| side(usize::from(number)) <= key);
            &order[first..end]
        };
        let mut twins = Vec::with_capacity(sides);
        for number in 0..sides {
            let (from, to) = side(number);
            let (from_mm, to_mm) = (place_mm(from), place_mm(to));
            match (alike((from, to)).len(), alike((to, from))) {
                (1, &[twin]) => twins.push(twin),
                (1, []) => return Err(ConvexError::Open { from_mm, to_mm }),
                (2, []) => return Err(ConvexError::Twisted { from_mm, to_mm }),
                (same, other) => {
                    return Err(ConvexError::Crowded { facets: same + other.len(), from_mm, to_mm });
                }
            }
        }
        Ok((0..sides as u16)
            .map(|number| {
                let (second, third) = (after(number), after(after(number)));
                Link {
                    apex: side(usize::from(third)).0,
                    origin: side(usize::from(number)).0,
                    onward: [twins[usize::from(third)], twins[usize::from(second)]],
                }
            })
            .collect())
    }
}
