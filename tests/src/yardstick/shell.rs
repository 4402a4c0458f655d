//! A thin cylindrical shell under radial loads: how the wall of a hollow pot bends.
//!
//! Owns Sanders's strains for one harmonic round the axis and elements of cubic interpolation along it; knows no clay and
//! no contact.
//! Invariant: a response is symmetric: the deflection at one height under a load at another is the same the other way
//! round (Maxwell and Betti).

use crate::linear::Cholesky;

/// Unknowns of a node: axial, circumferential and radial displacement and their slopes along the axis.
const UNKNOWNS: usize = 6;
/// Coordinates and weights of Gauss's rule of four points on 0 to 1.
const GAUSS: [(f64, f64); 4] = [
    (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
    (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
    (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
    (0.930_568_155_797_026_2, 0.173_927_422_568_726_93),
];

/// How an end of the shell is held.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum End {
    /// Not at all.
    Free,
    /// By a membrane that keeps it round and lets it tilt and move along the axis.
    Diaphragm,
    /// Fixed in place and slope.
    Clamped,
}

/// A cylindrical shell.
#[derive(Clone, Copy, Debug)]
pub struct Shell {
    /// Radius of the middle surface, mm.
    pub radius_mm: f64,
    /// Thickness, mm.
    pub wall_mm: f64,
    /// Height, mm.
    pub height_mm: f64,
    /// Young's modulus, MPa.
    pub youngs_mpa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Foot and rim.
    pub ends: [End; 2],
}

/// The shell can move as a whole: hold an end, or choose a harmonic above 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("nothing holds the shell against harmonic {harmonic}: clamp an end or use harmonics from 2 on")]
pub struct Loose {
    /// Number of waves round the axis.
    pub harmonic: usize,
}

/// Radial deflections of the harmonics 0, 1, 2, … under unit loads at evenly spaced nodes.
#[derive(Clone, Debug)]
pub struct Compliance {
    nodes: usize,
    spacing_mm: f64,
    /// `[harmonics][nodes][nodes]`, mm/N.
    entries: Vec<f64>,
}

/// Strains (axial, hoop, shear, and the changes of curvature alike) of one node's unknowns at one point of an element.
type Strains = [[f64; 2 * UNKNOWNS]; 6];

impl Shell {
    /// Sanders's strains of the harmonic `n` at `x` of an element of `step` mm (Sanders 1959): with u and w as cos nθ and v
    /// as sin nθ,
    ///
    /// `ε_x = u'`, `ε_θ = (nv + w)/R`, `γ = v' − nu/R`, `κ_x = −w''`, `κ_θ = (nv + n²w)/R²`,
    /// `2κ_xθ = 2nw'/R + 3v'/(2R) + nu/(2R²)`.
    fn strains(&self, n: f64, x: f64, step: f64) -> Strains {
        let radius = self.radius_mm;
        let value = [
            1.0 + x * x * (2.0 * x - 3.0),
            step * x * (1.0 - x) * (1.0 - x),
            x * x * (3.0 - 2.0 * x),
            step * x * x * (x - 1.0),
        ];
        let slope =
            [6.0 * x * (x - 1.0) / step, 1.0 + x * (3.0 * x - 4.0), 6.0 * x * (1.0 - x) / step, x * (3.0 * x - 2.0)];
        let bend = [
            (12.0 * x - 6.0) / (step * step),
            (6.0 * x - 4.0) / step,
            (6.0 - 12.0 * x) / (step * step),
            (6.0 * x - 2.0) / step,
        ];
        let mut strains = [[0.0; 2 * UNKNOWNS]; 6];
        for shape in 0..4 {
            let (u, v, w) = (3 * shape, 3 * shape + 1, 3 * shape + 2);
            strains[0][u] = slope[shape];
            strains[1][v] = n * value[shape] / radius;
            strains[1][w] = value[shape] / radius;
            strains[2][u] = -n * value[shape] / radius;
            strains[2][v] = slope[shape];
            strains[3][w] = -bend[shape];
            strains[4][v] = n * value[shape] / (radius * radius);
            strains[4][w] = n * n * value[shape] / (radius * radius);
            strains[5][u] = 0.5 * n * value[shape] / (radius * radius);
            strains[5][v] = 1.5 * slope[shape] / radius;
            strains[5][w] = 2.0 * n * slope[shape] / radius;
        }
        strains
    }

    /// Stiffness of an element, N/mm: `∫ Bᵀ C B` over the element and once round.
    fn element(&self, harmonic: usize, step: f64) -> [[f64; 2 * UNKNOWNS]; 2 * UNKNOWNS] {
        let stretch = self.youngs_mpa * self.wall_mm / (1.0 - self.poisson * self.poisson);
        let shear = 0.5 * (1.0 - self.poisson);
        let round = self.radius_mm * std::f64::consts::PI * if harmonic == 0 { 2.0 } else { 1.0 };
        let mut stiffness = [[0.0; 2 * UNKNOWNS]; 2 * UNKNOWNS];
        for (x, weight) in GAUSS {
            let strains = self.strains(harmonic as f64, x, step);
            for (first, rigidity) in [(0, stretch), (3, stretch * self.wall_mm * self.wall_mm / 12.0)] {
                let [along, hoop, twist] = [&strains[first], &strains[first + 1], &strains[first + 2]];
                let scale = weight * step * round * rigidity;
                for row in 0..2 * UNKNOWNS {
                    let along_stress = along[row] + self.poisson * hoop[row];
                    let hoop_stress = hoop[row] + self.poisson * along[row];
                    for column in 0..2 * UNKNOWNS {
                        stiffness[row][column] += scale
                            * (along_stress * along[column]
                                + hoop_stress * hoop[column]
                                + shear * twist[row] * twist[column]);
                    }
                }
            }
        }
        stiffness
    }

    /// Which unknowns are held at zero.
    fn held(&self, harmonic: usize, nodes: usize) -> Vec<bool> {
        let mut held = vec![false; UNKNOWNS * nodes];
        for (end, first) in self.ends.iter().zip([0, UNKNOWNS * (nodes - 1)]) {
            let which: &[usize] = match end {
                End::Free => &[],
                End::Diaphragm => &[1, 2],
                End::Clamped => &[0, 1, 2, 5],
            };
            which.iter().for_each(|unknown| held[first + unknown] = true);
        }
        if harmonic == 0 {
            // without waves nothing turns, and the height at which the shell hangs means nothing
            (0..nodes).for_each(|node| (held[UNKNOWNS * node + 1], held[UNKNOWNS * node + 4]) = (true, true));
            held[0] |= self.ends.iter().all(|end| *end != End::Clamped);
        }
        held
    }

    /// Responses of the harmonics below `harmonics` on `elements` elements of equal height.
    ///
    /// # Errors
    /// [`Loose`] when the ends leave the shell free to move as a whole.
    pub fn compliance(&self, harmonics: usize, elements: usize) -> Result<Compliance, Loose> {
        let mut all =
            Compliance { nodes: elements + 1, spacing_mm: self.height_mm / elements as f64, entries: Vec::new() };
        for harmonic in 0..harmonics {
            all.entries.extend(self.harmonic(harmonic, elements)?.entries);
        }
        Ok(all)
    }

    /// Responses of one harmonic, which the answer holds as its harmonic 0.
    ///
    /// # Errors
    /// [`Loose`] when the ends leave the shell free to move as a whole.
    pub fn harmonic(&self, harmonic: usize, elements: usize) -> Result<Compliance, Loose> {
        let (nodes, spacing_mm) = (elements + 1, self.height_mm / elements as f64);
        let element = self.element(harmonic, spacing_mm);
        let held = self.held(harmonic, nodes);
        let entry = |row: usize, column: usize| {
            if held[row] || held[column] {
                return if row == column { 1.0 } else { 0.0 };
            }
            // the elements that hold both unknowns: the one below and the one above their node
            let (upper, lower) = (row / UNKNOWNS, column / UNKNOWNS);
            let below = upper.checked_sub(1).filter(|below| *below <= lower);
            let above = Some(upper).filter(|above| *above <= lower && *above < elements);
            let numbers = [below, above].into_iter().flatten();
            numbers.map(|number| element[row - UNKNOWNS * number][column - UNKNOWNS * number]).sum()
        };
        let factor = Cholesky::new(UNKNOWNS * nodes, 2 * UNKNOWNS - 1, entry).ok_or(Loose { harmonic })?;
        let mut entries = Vec::with_capacity(nodes * nodes);
        for node in 0..nodes {
            let mut moved = vec![0.0; UNKNOWNS * nodes];
            let loaded = UNKNOWNS * node + 2;
            moved[loaded] = if held[loaded] { 0.0 } else { 1.0 };
            factor.solve(&mut moved);
            entries.extend(moved.iter().skip(2).step_by(UNKNOWNS));
        }
        Ok(Compliance { nodes, spacing_mm, entries })
    }
}

impl Compliance {
    /// Number of nodes from foot to rim.
    #[must_use]
    pub const fn nodes(&self) -> usize {
        self.nodes
    }

    /// Number of harmonics.
    #[must_use]
    pub fn harmonics(&self) -> usize {
        self.entries.len() / (self.nodes * self.nodes)
    }

    /// Deflections of all nodes in a harmonic under a unit load at a node, mm/N; the load is a point load's share, so that
    /// the deflections of all harmonics times cos nθ add up to a point load's.
    #[must_use]
    pub fn row(&self, harmonic: usize, node: usize) -> &[f64] {
        &self.entries[(harmonic * self.nodes + node) * self.nodes..][..self.nodes]
    }

    /// The two nodes beside a height, as the lower one and the share of the upper one.
    #[must_use]
    pub fn between(&self, z_mm: f64) -> (usize, f64) {
        let place = (z_mm / self.spacing_mm).clamp(0.0, (self.nodes - 1) as f64);
        let lower = (place as usize).min(self.nodes - 2);
        (lower, place - lower as f64)
    }

    /// Deflection at an angle from a unit point load and at a height, under a load at another height, mm/N.
    #[must_use]
    pub fn at_mm(&self, angle_rad: f64, z_mm: f64, load_z_mm: f64) -> f64 {
        let ((low, up), (load_low, load_up)) = (self.between(z_mm), self.between(load_z_mm));
        (0..self.harmonics())
            .map(|harmonic| {
                let (first, second) = (self.row(harmonic, load_low), self.row(harmonic, load_low + 1));
                let at = |node: usize| first[node] * (1.0 - load_up) + second[node] * load_up;
                (at(low) * (1.0 - up) + at(low + 1) * up) * (harmonic as f64 * angle_rad).cos()
            })
            .sum()
    }
}
