//! Meshes of bricks: cylinder walls and blocks on tensor grids.
//!
//! Owns node positions and connections; knows no material and no load.
//! Invariant: every brick is right-handed, so its volume is positive.

use super::element::CORNERS;

/// Nodes and bricks of a body.
#[derive(Clone, Debug)]
pub struct Mesh {
    /// Positions (m) before any load.
    pub nodes: Vec<[f64; 3]>,
    /// Corners of each brick, in the order of [`super::element`].
    pub bricks: Vec<[u32; CORNERS]>,
    /// Number of nodes along the three directions of the grid.
    pub counts: [usize; 3],
}

impl Mesh {
    /// Node at a place on the grid.
    pub fn node(&self, first: usize, second: usize, third: usize) -> usize {
        (first * self.counts[1] + second) * self.counts[2] + third
    }

    /// A body on the grid `axes`, each point carried into space by `place`.
    pub fn grid(axes: [&[f64]; 3], place: impl Fn([f64; 3]) -> [f64; 3]) -> Self {
        let counts = axes.map(<[f64]>::len);
        let mut nodes = Vec::with_capacity(counts.iter().product());
        for &a in axes[0] {
            for &b in axes[1] {
                for &c in axes[2] {
                    nodes.push(place([a, b, c]));
                }
            }
        }
        let mut mesh = Self { nodes, bricks: Vec::new(), counts };
        for i in 0..counts[0] - 1 {
            for k in 0..counts[2] - 1 {
                for j in 0..counts[1] - 1 {
                    mesh.bricks.push(std::array::from_fn(|corner| {
                        mesh.node(i + (corner & 1), j + ((corner >> 1) & 1), k + (corner >> 2)) as u32
                    }));
                }
            }
        }
        mesh
    }

    /// A cylinder's wall: angles (rad), heights (m) and radii (m), inner to outer.
    pub fn wall(angles: &[f64], heights_m: &[f64], radii_m: &[f64]) -> Self {
        Self::grid([angles, heights_m, radii_m], |[angle, height, radius]| {
            [radius * angle.cos(), radius * angle.sin(), height]
        })
    }

    /// A block on the given coordinates (m).
    pub fn block(x_m: &[f64], y_m: &[f64], z_m: &[f64]) -> Self {
        Self::grid([x_m, y_m, z_m], |point| point)
    }
}

/// `count + 1` evenly spaced numbers from `from` to `to`.
pub fn even(from: f64, to: f64, count: usize) -> Vec<f64> {
    (0..=count).map(|step| from + (to - from) * step as f64 / count as f64).collect()
}

/// A half-line from 0 to `end`: spacing `fine` up to `until`, then growing by `ratio` a step up to `coarse`; the growing
/// part is stretched to end exactly.
pub fn graded(end: f64, fine: f64, until: f64, ratio: f64, coarse: f64) -> Vec<f64> {
    let steps = ((until.min(end)) / fine).round().max(1.0) as usize;
    let mut points: Vec<f64> = (0..=steps).map(|step| fine * step as f64).collect();
    let start = fine * steps as f64;
    if start >= end - 0.5 * fine {
        return points.iter().map(|point| point * end / start).collect();
    }
    let (mut sizes, mut size, mut reach) = (Vec::new(), fine, start);
    while reach < end {
        size = (size * ratio).min(coarse);
        sizes.push(size);
        reach += size;
    }
    let stretch = (end - start) / (reach - start);
    let mut at = start;
    for size in sizes {
        at += size * stretch;
        points.push(at);
    }
    points
}
