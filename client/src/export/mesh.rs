//! The closed solid as corners and facets, which every solid format is written from.
//!
//! Invariant: every corner stands once, so that facets which touch share it by number, and no facet has two equal corners.

use std::collections::HashMap;

use pottery_shared::clay::{Pot, closed_solid};
use pottery_shared::units::Metres;

/// Corners, their normals, and facets between them.
#[derive(Clone, Debug, PartialEq)]
pub struct SolidMesh {
    corners_mm: Vec<[f32; 3]>,
    normals: Vec<[f32; 3]>,
    facets: Vec<[u32; 3]>,
}

impl SolidMesh {
    /// The clay of a pot as a closed solid, mm, foot on z = 0.
    ///
    /// A facet of which two corners fall together encloses nothing and is left out; the solid stays closed, since both its
    /// remaining edges are one.
    #[must_use]
    pub fn of(pot: &Pot) -> Self {
        let triangles = closed_solid(pot, 1);
        let mut corners_mm = Vec::with_capacity(triangles.len() / 2);
        let mut numbers = HashMap::with_capacity(triangles.len() / 2);
        let mut facets = Vec::with_capacity(triangles.len());
        for triangle in triangles {
            let facet = triangle.map(|corner| {
                // + 0.0 makes one zero of both
                let corner_mm = corner.to_array().map(|length_m| Metres(length_m).as_mm() + 0.0);
                *numbers.entry(corner_mm.map(f32::to_bits)).or_insert_with(|| {
                    corners_mm.push(corner_mm);
                    u32::try_from(corners_mm.len() - 1).expect("the largest grid has 4 million elements")
                })
            });
            let [a, b, c] = facet;
            if a != b && b != c && c != a {
                facets.push(facet);
            }
        }
        let normals = corner_normals(&corners_mm, &facets);
        Self { corners_mm, normals, facets }
    }

    /// Places of the corners, mm, z upwards.
    #[must_use]
    pub fn corners_mm(&self) -> &[[f32; 3]] {
        &self.corners_mm
    }

    /// Normals of the corners, out of the clay and of length one: the mean of the facets about them by area.
    #[must_use]
    pub fn normals(&self) -> &[[f32; 3]] {
        &self.normals
    }

    /// Corners of each facet, anticlockwise as seen from outside.
    #[must_use]
    pub fn facets(&self) -> &[[u32; 3]] {
        &self.facets
    }

    /// Places of a facet's corners, mm.
    pub(super) fn places_mm(&self, facet: [u32; 3]) -> [[f32; 3]; 3] {
        facet.map(|corner| self.corners_mm[corner as usize])
    }
}

fn corner_normals(corners_mm: &[[f32; 3]], facets: &[[u32; 3]]) -> Vec<[f32; 3]> {
    let mut sums = vec![[0.0_f64; 3]; corners_mm.len()];
    for facet in facets {
        let upright = upright(facet.map(|corner| corners_mm[corner as usize]));
        for &corner in facet {
            for (sum, part) in sums[corner as usize].iter_mut().zip(upright) {
                *sum += part;
            }
        }
    }
    sums.into_iter().map(|sum| of_length_one(sum).unwrap_or([0.0, 0.0, 1.0])).collect()
}

/// (b − a) × (c − a), in f64, since the f32 product of two nearly parallel edges points anywhere.
fn upright([a, b, c]: [[f32; 3]; 3]) -> [f64; 3] {
    let edge = |to: [f32; 3]| [0, 1, 2].map(|axis| f64::from(to[axis]) - f64::from(a[axis]));
    let ([ux, uy, uz], [vx, vy, vz]) = (edge(b), edge(c));
    [uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx]
}

fn of_length_one(vector: [f64; 3]) -> Option<[f32; 3]> {
    let length = vector.iter().map(|part| part * part).sum::<f64>().sqrt();
    (length > 0.0).then(|| vector.map(|part| (part / length) as f32))
}

/// Normal of a facet, of length one; zero for corners in a line, which leaves the choice to the reader.
pub(super) fn facet_normal(corners_mm: [[f32; 3]; 3]) -> [f32; 3] {
    of_length_one(upright(corners_mm)).unwrap_or([0.0; 3])
}
