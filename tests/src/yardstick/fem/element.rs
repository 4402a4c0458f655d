//! The eight-node brick: strain from motion, stress from strain, force from stress, for a batch of elements.
//!
//! Full integration (2×2×2) of the stress deviator and one mean dilatation an element (B-bar: Hughes 1980), so
//! that nearly incompressible and plastic flow does not lock. Updated Lagrangian with the Jaumann rate; perfect J2
//! plasticity by radial return (Wilkins 1964). Owns no mesh and no time.
//! Invariant: the deviator at every point lies inside or on the yield surface.

use super::lanes::{Lanes, WIDTH};
use std::array::from_fn;

/// Corners of a brick; corner `c` lies at `(±1, ±1, ±1)` by bits 0, 1 and 2 of `c`.
pub const CORNERS: usize = 8;

/// A vector in each lane.
pub type Vector = [Lanes; 3];

/// The clay: an elastic, perfectly plastic solid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Material {
    /// Young's modulus (Pa).
    pub young_pa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Yield stress in tension (Pa).
    pub yield_pa: f64,
    /// Density (kg/m³); only inertia depends on it.
    pub density_kg_m3: f64,
}

impl Material {
    /// Shear modulus (Pa), `E / (2 (1 + ν))`.
    pub fn shear_pa(&self) -> f64 {
        self.young_pa / (2.0 * (1.0 + self.poisson))
    }

    /// Bulk modulus (Pa), `E / (3 (1 − 2ν))`.
    pub fn bulk_pa(&self) -> f64 {
        self.young_pa / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// Speed of a pressure wave (m/s), `√((K + 4G/3) / ρ)`.
    pub fn wave_m_s(&self) -> f64 {
        ((self.bulk_pa() + 4.0 / 3.0 * self.shear_pa()) / self.density_kg_m3).sqrt()
    }
}

/// What a batch of elements remembers.
#[derive(Clone, Debug)]
pub struct Memory {
    /// Stress deviator at each integration point: xx, yy, xy, xz, yz (Pa).
    pub deviator: [[Lanes; 5]; CORNERS],
    /// Volume before any load (m³).
    pub volume_m3: Lanes,
    /// Volumetric part of the stress now (Pa, tension positive).
    pub mean_stress: Lanes,
}

const NEAR: f64 = 0.788_675_134_594_812_9; // (1 + 1/√3) / 2
const FAR: f64 = 0.211_324_865_405_187_1;

/// Corner at bits `first` and `second` of the two directions other than `direction`, with bit `direction` zero.
#[inline(always)]
const fn edge(direction: usize, pair: usize) -> usize {
    let (first, second) = (pair & 1, pair >> 1);
    match direction {
        0 => (first << 1) | (second << 2),
        1 => first | (second << 2),
        _ => first | (second << 1),
    }
}

/// Index into the four edges of `direction` of integration point `point`.
#[inline(always)]
const fn pair_of(direction: usize, point: usize) -> usize {
    match direction {
        0 => (point >> 1) & 3,
        1 => (point & 1) | ((point >> 2) << 1),
        _ => point & 3,
    }
}

/// Bilinear interpolation from edges to integration points; its own adjoint.
#[inline(always)]
fn spread([a, b, c, d]: [f64; 4]) -> [f64; 4] {
    let (ab, ba) = (a * NEAR + b * FAR, a * FAR + b * NEAR);
    let (cd, dc) = (c * NEAR + d * FAR, c * FAR + d * NEAR);
    [ab * NEAR + cd * FAR, ba * NEAR + dc * FAR, ab * FAR + cd * NEAR, ba * FAR + dc * NEAR]
}

/// Derivatives along the three parent directions: `[direction][pair]`, a pair being two points that share them.
type Slopes = [[Vector; 4]; 3];

#[inline(always)]
fn slopes_along<const DIRECTION: usize>(corners: &[Vector; CORNERS], out: &mut [Vector; 4]) {
    for axis in 0..3 {
        for lane in 0..WIDTH {
            let edges = from_fn(|pair| {
                let low = edge(DIRECTION, pair);
                0.5 * (corners[low | (1 << DIRECTION)][axis].0[lane] - corners[low][axis].0[lane])
            });
            let [a, b, c, d] = spread(edges);
            out[0][axis].0[lane] = a;
            out[1][axis].0[lane] = b;
            out[2][axis].0[lane] = c;
            out[3][axis].0[lane] = d;
        }
    }
}

#[inline]
fn slopes(corners: &[Vector; CORNERS], out: &mut Slopes) {
    slopes_along::<0>(corners, &mut out[0]);
    slopes_along::<1>(corners, &mut out[1]);
    slopes_along::<2>(corners, &mut out[2]);
}

#[inline(always)]
fn at(vector: &Vector, lane: usize) -> [f64; 3] {
    [vector[0].0[lane], vector[1].0[lane], vector[2].0[lane]]
}

#[inline(always)]
pub(super) fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

#[inline(always)]
pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline]
fn add_volume(slopes: &Slopes, point: usize, volume: &mut Lanes) {
    let [a, b, c] = from_fn(|direction| &slopes[direction][pair_of(direction, point)]);
    for lane in 0..WIDTH {
        volume.0[lane] += dot(at(a, lane), cross(at(b, lane), at(c, lane)));
    }
}

/// Volume of each element (m³).
pub fn volume(position: &[Vector; CORNERS]) -> Lanes {
    let mut x = [[[Lanes::ZERO; 3]; 4]; 3];
    slopes(position, &mut x);
    let mut total = Lanes::ZERO;
    for point in 0..CORNERS {
        add_volume(&x, point, &mut total);
    }
    total
}

/// Deviator after the increment of motion with gradient `l`: Jaumann rotation, elastic step, radial return.
#[inline(always)]
fn flow([xx, yy, xy, xz, yz]: [f64; 5], l: [[f64; 3]; 3], twice_shear: f64, yield_squared: f64) -> [f64; 5] {
    let third = (l[0][0] + l[1][1] + l[2][2]) * (1.0 / 3.0);
    let (a, b, c) = ((l[0][1] - l[1][0]) * 0.5, (l[0][2] - l[2][0]) * 0.5, (l[1][2] - l[2][1]) * 0.5);
    let zz = -(xx + yy);
    let shear = 0.5 * twice_shear;
    let xx_next = xx + 2.0 * (a * xy + b * xz) + twice_shear * (l[0][0] - third);
    let yy_next = yy + 2.0 * (c * yz - a * xy) + twice_shear * (l[1][1] - third);
    let xy_next = xy + a * (yy - xx) + b * yz + c * xz + shear * (l[0][1] + l[1][0]);
    let xz_next = xz + b * (zz - xx) + a * yz - c * xy + shear * (l[0][2] + l[2][0]);
    let yz_next = yz + c * (zz - yy) - a * xz - b * xy + shear * (l[1][2] + l[2][1]);
    let mises_squared = 3.0
        * (xx_next * xx_next
            + yy_next * yy_next
            + xx_next * yy_next
            + xy_next * xy_next
            + xz_next * xz_next
            + yz_next * yz_next);
    let limit = if mises_squared > yield_squared { mises_squared } else { yield_squared };
    let scale = (yield_squared / limit).sqrt();
    [xx_next * scale, yy_next * scale, xy_next * scale, xz_next * scale, yz_next * scale]
}

/// The two directions that lie in the wall.
const IN_PLANE: [usize; 2] = [0, 1];
/// The direction through the wall.
const THROUGH: usize = 2;

/// Shear through the wall at the points of a batch: `[in-plane direction][point]`.
struct Transverse {
    /// What the strain of each point lacks to its mean along the direction.
    gap: [[Lanes; CORNERS]; 2],
    /// Stress, contravariant, times the determinant.
    stress: [[Lanes; CORNERS]; 2],
}

/// What the transverse shear strain of each point lacks to its mean over the in-plane direction: `[in-plane][point]`.
///
/// A brick that bends shears spuriously, in proportion to the distance from its middle (parasitic shear); the mean is
/// free of it (Dvorkin and Bathe 1984). Covariant: `γ = x,ξ·u,ζ + x,ζ·u,ξ`.
#[inline]
fn shear_gap(x: &Slopes, u: &Slopes, gap: &mut [[Lanes; CORNERS]; 2]) {
    for direction in IN_PLANE {
        let mut shear = [Lanes::ZERO; CORNERS];
        for (point, shear) in shear.iter_mut().enumerate() {
            let (along, through) = (pair_of(direction, point), pair_of(THROUGH, point));
            let (xa, xt) = (&x[direction][along], &x[THROUGH][through]);
            let (ua, ut) = (&u[direction][along], &u[THROUGH][through]);
            for lane in 0..WIDTH {
                shear.0[lane] = dot(at(xa, lane), at(ut, lane)) + dot(at(xt, lane), at(ua, lane));
            }
        }
        half_differences(direction, &shear, &mut gap[direction]);
    }
}

/// Mean over the direction less the value, at each point.
#[inline(always)]
fn half_differences(direction: usize, values: &[Lanes; CORNERS], out: &mut [Lanes; CORNERS]) {
    for point in 0..CORNERS {
        let other = &values[point ^ (1 << direction)];
        for lane in 0..WIDTH {
            out[point].0[lane] = 0.5 * (other.0[lane] - values[point].0[lane]);
        }
    }
}

/// Adjoint of [`shear_gap`]: the pull of the transverse shear stress moves to its mean.
#[inline]
fn add_shear_pull(x: &Slopes, stress: &[[Lanes; CORNERS]; 2], pull: &mut Slopes) {
    for direction in IN_PLANE {
        let mut gap = [Lanes::ZERO; CORNERS];
        half_differences(direction, &stress[direction], &mut gap);
        for (point, gap) in gap.iter().enumerate() {
            let (along, through) = (pair_of(direction, point), pair_of(THROUGH, point));
            for axis in 0..3 {
                let (xa, xt) = (&x[direction][along][axis], &x[THROUGH][through][axis]);
                for lane in 0..WIDTH {
                    pull[direction][along][axis].0[lane] += gap.0[lane] * xt.0[lane];
                    pull[THROUGH][through][axis].0[lane] += gap.0[lane] * xa.0[lane];
                }
            }
        }
    }
}

/// One integration point of a batch: its stress, what that pulls along the three parent directions, and its transverse
/// shear stresses (contravariant, times the determinant).
#[inline]
fn advance_point(
    (x, u): (&Slopes, &Slopes),
    point: usize,
    mean: &Lanes,
    [twice_shear, yield_squared]: [f64; 2],
    deviator: &mut [Lanes; 5],
    transverse: &mut Transverse,
    pull: &mut Slopes,
) {
    let pairs: [usize; 3] = from_fn(|direction| pair_of(direction, point));
    let [xa, xb, xc] = from_fn(|direction| &x[direction][pairs[direction]]);
    let [ua, ub, uc] = from_fn(|direction| &u[direction][pairs[direction]]);
    let [pa, pb, pc] = pull;
    let (pa, pb, pc) = (&mut pa[pairs[0]], &mut pb[pairs[1]], &mut pc[pairs[2]]);
    let [s0, s1, s2, s3, s4] = deviator;
    let (gap_a, gap_b) = (&transverse.gap[0][point], &transverse.gap[1][point]);
    let [shear_a, shear_b] = &mut transverse.stress;
    let (shear_a, shear_b) = (&mut shear_a[point], &mut shear_b[point]);
    for lane in 0..WIDTH {
        let (a, b, c) = (at(xa, lane), at(xb, lane), at(xc, lane));
        let areas = [cross(b, c), cross(c, a), cross(a, b)];
        let inverse = 1.0 / dot(a, areas[0]);
        let moved = [at(ua, lane), at(ub, lane), at(uc, lane)];
        let (half_a, half_b) = (0.5 * inverse * gap_a.0[lane], 0.5 * inverse * gap_b.0[lane]);
        // the missing shear as columns along each parent direction
        let lack: [[f64; 3]; 3] = [
            from_fn(|i| half_a * areas[2][i]),
            from_fn(|i| half_b * areas[2][i]),
            from_fn(|i| half_a * areas[0][i] + half_b * areas[1][i]),
        ];
        let gradient = from_fn(|i| {
            from_fn(|j| {
                let part = |direction: usize| (moved[direction][i] + lack[direction][i]) * areas[direction][j];
                inverse * (part(0) + part(1) + part(2))
            })
        });
        let old = [s0.0[lane], s1.0[lane], s2.0[lane], s3.0[lane], s4.0[lane]];
        let [xx, yy, xy, xz, yz] = flow(old, gradient, twice_shear, yield_squared);
        (s0.0[lane], s1.0[lane], s2.0[lane], s3.0[lane], s4.0[lane]) = (xx, yy, xy, xz, yz);
        let mean = mean.0[lane];
        let stress = [[xx + mean, xy, xz], [xy, yy + mean, yz], [xz, yz, mean - xx - yy]];
        let pulls: [[f64; 3]; 3] = from_fn(|direction| from_fn(|i| dot(stress[i], areas[direction])));
        // the deviator alone: the mean stress works on the volume, which the assumed shear leaves as it is
        let through = [0, 1, 2].map(|i| pulls[2][i] - mean * areas[2][i]);
        shear_a.0[lane] = inverse * dot(through, areas[0]);
        shear_b.0[lane] = inverse * dot(through, areas[1]);
        for i in 0..3 {
            pa[i].0[lane] += pulls[0][i];
            pb[i].0[lane] += pulls[1][i];
            pc[i].0[lane] += pulls[2][i];
        }
    }
}

#[inline(always)]
fn share_out<const DIRECTION: usize>(pull: &[Vector; 4], force: &mut [Vector; CORNERS]) {
    for axis in 0..3 {
        for lane in 0..WIDTH {
            let edges = spread(from_fn(|pair| pull[pair][axis].0[lane]));
            for (pair, value) in edges.into_iter().enumerate() {
                let low = edge(DIRECTION, pair);
                force[low][axis].0[lane] += 0.5 * value;
                force[low | (1 << DIRECTION)][axis].0[lane] -= 0.5 * value;
            }
        }
    }
}

/// Advances a batch by the motion `moved` (m) that ended at `position` (m); returns the corner forces (N) with
/// which the elements pull on their nodes.
///
/// Per point `s ← return(s + 2G·dev D + W·s − s·W)`, per element `p = K·ln(V/V₀)`; force
/// `f = −∫(s + p·1)·∇N dV`. The gradient is taken at the end of the step: a relative error of the strain of one
/// step, some 1e-4.
#[inline]
pub fn advance(
    memory: &mut Memory,
    position: &[Vector; CORNERS],
    moved: &[Vector; CORNERS],
    material: &Material,
    assumed_shear: bool,
) -> [Vector; CORNERS] {
    let zero = [[[Lanes::ZERO; 3]; 4]; 3];
    let (mut x, mut u, mut pull) = (zero, zero, zero);
    slopes(position, &mut x);
    slopes(moved, &mut u);
    let mut volume = Lanes::ZERO;
    for point in 0..CORNERS {
        add_volume(&x, point, &mut volume);
    }
    let mut mean = Lanes::ZERO;
    let bulk = material.bulk_pa();
    for lane in 0..WIDTH {
        // the logarithm by the area tangent: to 1e-12 for the few percent a clay is compressed
        let (now, was) = (volume.0[lane], memory.volume_m3.0[lane]);
        let t = (now - was) / (now + was);
        let squared = t * t;
        mean.0[lane] = 2.0 * bulk * t * (1.0 + squared * (1.0 / 3.0 + squared * (0.2 + squared * (1.0 / 7.0))));
    }
    memory.mean_stress = mean;
    let limits = [2.0 * material.shear_pa(), material.yield_pa * material.yield_pa];
    let none = [[Lanes::ZERO; CORNERS]; 2];
    let mut transverse = Transverse { gap: none, stress: none };
    if assumed_shear {
        shear_gap(&x, &u, &mut transverse.gap);
    }
    for (point, deviator) in memory.deviator.iter_mut().enumerate() {
        advance_point((&x, &u), point, &mean, limits, deviator, &mut transverse, &mut pull);
    }
    if assumed_shear {
        add_shear_pull(&x, &transverse.stress, &mut pull);
    }
    let mut force = [[Lanes::ZERO; 3]; CORNERS];
    share_out::<0>(&pull[0], &mut force);
    share_out::<1>(&pull[1], &mut force);
    share_out::<2>(&pull[2], &mut force);
    force
}
