//! Free-form deformation on a lattice round the pot, pulled by the points of its surface.
//!
//! Sederberg and Parry, Free-form deformation of solid geometric models, 1986, with the direct manipulation of Hsu, Hughes
//! and Kaufman, 1992. Owns the lattice; knows no material, so that it has neither a force nor a support nor a release: a
//! dent stays as it was drawn, whatever stands behind the wall.
//! Invariant: a lattice whose control points rest moves nothing; the weights of a point add up to one.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::{Scene, median_ns};
use crate::dent::{Dent, DentError, Dented};
use crate::linear::Cholesky;

/// Control points within the tool's radius and damping of the pseudo-inverse: of 36 pairs from 1.5 to 5 and from 10⁻⁶ to
/// 10⁻¹ the one that meets the reference best, but for one with half as many control points again. Without damping the control
/// points that only the edge of the tool sees go metres away.
const CONTROL_POINTS_PER_TOOL: f64 = 4.0;
const DAMPING: f64 = 0.1;
/// Updates that are timed.
const UPDATES: u32 = 21;

/// A control point's column, row and layer.
type ControlPoint = [usize; 3];

/// Control points over angle, height and radius: uniform cubic B-splines round the pot, where they close, and along it;
/// Bernstein polynomials of degree 1 through its wall.
#[derive(Clone, Debug)]
pub struct Lattice {
    radii_mm: [f64; 2],
    height_mm: f64,
    around: usize,
    up: usize,
    /// `[around][up + 3][2]`: how far each has moved in angle (rad), height and radius (mm).
    moved: Vec<[f64; 3]>,
}

/// The four cubic B-splines at a place between two knots.
fn splines(share: f64) -> [f64; 4] {
    let rest = 1.0 - share;
    [
        rest.powi(3) / 6.0,
        (3.0 * share.powi(3) - 6.0 * share * share + 4.0) / 6.0,
        (3.0 * rest.powi(3) - 6.0 * rest * rest + 4.0) / 6.0,
        share.powi(3) / 6.0,
    ]
}

impl Lattice {
    /// A lattice at rest with `around` control points on each circle and `up` spans from foot to rim.
    ///
    /// # Panics
    /// With fewer than four control points round the pot, since a point needs four different ones, or without a span.
    #[must_use]
    pub fn new(radii_mm: [f64; 2], height_mm: f64, around: usize, up: usize) -> Self {
        assert!(around >= 4 && up >= 1);
        Self { radii_mm, height_mm, around, up, moved: vec![[0.0; 3]; around * (up + 3) * 2] }
    }

    /// Where a control point rests: angle, height and radius.
    #[must_use]
    pub fn rest(&self, [column, row, layer]: ControlPoint) -> [f64; 3] {
        let z_mm = (row as f64 - 1.0) * self.height_mm / self.up as f64;
        [column as f64 * TAU / self.around as f64, z_mm, self.radii_mm[layer]]
    }

    /// All control points.
    pub fn control_points(&self) -> impl Iterator<Item = ControlPoint> + use<> {
        let (around, rows) = (self.around, self.up + 3);
        (0..around).flat_map(move |column| (0..rows).flat_map(move |row| [[column, row, 0], [column, row, 1]]))
    }

    fn index(&self, [column, row, layer]: ControlPoint) -> usize {
        (column * (self.up + 3) + row) * 2 + layer
    }

    /// Moves a control point by an angle, a height and a radius.
    pub fn shift(&mut self, point: ControlPoint, by: [f64; 3]) {
        let index = self.index(point);
        self.moved[index] = std::array::from_fn(|axis| self.moved[index][axis] + by[axis]);
    }

    /// The control points that move a point, and how much.
    ///
    /// `B_i(θ)·B_j(z)·b_k(r)`: 4 × 4 × 2 of them, less those without weight.
    pub fn weights(&self, [angle_rad, z_mm, r_mm]: [f64; 3]) -> impl Iterator<Item = (ControlPoint, f64)> + use<> {
        let around = self.around;
        let across = angle_rad.rem_euclid(TAU) / TAU * around as f64;
        let column = (across as usize).min(around - 1);
        let high = (z_mm / self.height_mm * self.up as f64).clamp(0.0, self.up as f64);
        let row = (high as usize).min(self.up - 1);
        let (columns, rows) = (splines(across - column as f64), splines(high - row as f64));
        let through = (r_mm - self.radii_mm[0]) / (self.radii_mm[1] - self.radii_mm[0]);
        let layers = [1.0 - through, through];
        (0..32).filter_map(move |number| {
            let (i, j, k) = (number / 8, number / 2 % 4, number % 2);
            let weight = columns[i] * rows[j] * layers[k];
            // the spline that starts a span stands one control point before it
            (weight != 0.0).then_some(([(column + i + around - 1) % around, row + j, k], weight))
        })
    }

    /// Where a point goes.
    #[must_use]
    pub fn deform(&self, point: [f64; 3]) -> [f64; 3] {
        self.weights(point).fold(point, |sum, (control, weight)| {
            let moved = self.moved[self.index(control)];
            std::array::from_fn(|axis| sum[axis] + weight * moved[axis])
        })
    }

    /// Moves the control points by the least amount that moves points by what is asked, or that misses it least where
    /// more is asked than they can do: `ΔP = B⁺ΔQ` (Hsu, Hughes and Kaufman 1992).
    ///
    /// The pseudo-inverse is `(BᵀB + εI)⁻¹Bᵀ` for ε → 0; `damping` is ε as a share of the largest entry of `BᵀB`.
    /// Returns the control points that moved.
    pub fn pull(&mut self, asked: &[([f64; 3], [f64; 3])], damping: f64) -> Vec<ControlPoint> {
        let mut numbers = BTreeMap::new();
        let rows: Vec<Vec<(usize, f64)>> = asked
            .iter()
            .map(|(point, _)| {
                let numbered = self.weights(*point).map(|(control, weight)| {
                    let next = numbers.len();
                    (*numbers.entry(control).or_insert(next), weight)
                });
                numbered.collect()
            })
            .collect();
        let unknowns = numbers.len();
        let mut normal = vec![0.0; unknowns * unknowns];
        let mut right = vec![vec![0.0; unknowns]; 3];
        for (row, (_, by)) in rows.iter().zip(asked) {
            for &(first, weight) in row {
                for &(second, other) in row {
                    normal[first * unknowns + second] += weight * other;
                }
                (0..3).for_each(|axis| right[axis][first] += weight * by[axis]);
            }
        }
        let largest = (0..unknowns).map(|number| normal[number * unknowns + number]).fold(0.0, f64::max);
        let entry = |row: usize, column: usize| {
            normal[row * unknowns + column] + if row == column { damping * largest } else { 0.0 }
        };
        let factor = Cholesky::new(unknowns, unknowns.saturating_sub(1), entry);
        let factor = factor.expect("damped normal equations are positive definite");
        right.iter_mut().for_each(|values| factor.solve(values));
        for (&control, &number) in &numbers {
            self.shift(control, std::array::from_fn(|axis| right[axis][number]));
        }
        numbers.into_keys().collect()
    }
}

/// Presses: the points of the surface that the tool reaches are pulled on to its near side, and every element that a moved
/// control point moves is evaluated anew.
///
/// The force is 0, since the method has none.
///
/// # Errors
/// [`DentError`] for figures that make no sense.
pub fn press(dent: &Dent) -> Result<Dented, DentError> {
    press_on(dent, CONTROL_POINTS_PER_TOOL, DAMPING)
}

/// The same on a lattice of another fineness: control points within the tool's radius.
///
/// # Errors
/// [`DentError`] for figures that make no sense.
pub fn press_on(dent: &Dent, control_points_per_tool: f64, damping: f64) -> Result<Dented, DentError> {
    let scene = Scene::of(dent)?;
    let spacing_mm = scene.tool_mm / control_points_per_tool;
    let spans = |length_mm: f64, least: usize| ((length_mm / spacing_mm).round() as usize).max(least);
    let radii_mm = [scene.radius_mm - scene.wall_mm, scene.radius_mm];
    let rest = Lattice::new(radii_mm, scene.height_mm, spans(TAU * scene.radius_mm, 8), spans(scene.height_mm, 4));
    let reached = scene.reached();
    let mut radial_mm = vec![0.0; scene.shape.elements()];
    let step_ns = median_ns(UPDATES, |_| {
        let mut lattice = rest.clone();
        let asked: Vec<_> = reached
            .iter()
            .map(|&(_, row, angle)| {
                let z_mm = row as f64 * scene.row_mm();
                let depth_mm = scene.penetration_mm(scene.depth_mm, angle, z_mm);
                ([angle, z_mm, scene.radius_mm], [0.0, 0.0, -depth_mm])
            })
            .collect();
        let moved = lattice.pull(&asked, damping);
        draw(&scene, &lattice, &moved, &mut radial_mm);
    });
    Ok(scene.dented(&radial_mm, dent.release, 0.0, step_ns))
}

/// Evaluates the elements within two spans of a moved control point, beyond which its splines end.
fn draw(scene: &Scene, lattice: &Lattice, moved: &[ControlPoint], radial_mm: &mut [f64]) {
    let signed = |angle: f64| if angle > 0.5 * TAU { angle - TAU } else { angle };
    let (mut angles, mut heights) = ([f64::INFINITY, f64::NEG_INFINITY], [f64::INFINITY, f64::NEG_INFINITY]);
    for &control in moved {
        let [angle, z_mm, _] = lattice.rest(control);
        angles = [angles[0].min(signed(angle)), angles[1].max(signed(angle))];
        heights = [heights[0].min(z_mm), heights[1].max(z_mm)];
    }
    let spans = [2.0 * TAU / lattice.around as f64, 2.0 * lattice.height_mm / lattice.up as f64];
    let range = |[low, high]: [f64; 2], span: f64, step: f64| {
        (((low - span) / step).ceil() as i64)..=(((high + span) / step).floor() as i64)
    };
    let rows = range(heights, spans[1], scene.row_mm());
    let rows = (*rows.start()).max(0)..=(*rows.end()).min(scene.rows() as i64 - 1);
    let half = scene.columns() as i64 / 2;
    let columns = range(angles, spans[0], scene.column_rad());
    for column in (*columns.start()).max(1 - half)..=(*columns.end()).min(half) {
        let first = scene.shape.wrap(column) as usize * scene.rows();
        for row in rows.clone() {
            let point = [column as f64 * scene.column_rad(), row as f64 * scene.row_mm(), scene.radius_mm];
            radial_mm[first + row as usize] = lattice.deform(point)[2] - scene.radius_mm;
        }
    }
}
