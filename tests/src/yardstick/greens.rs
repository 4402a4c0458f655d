//! Elastostatic Green's functions, precomputed, with a contact solve.
//!
//! James and Pai, ArtDefo: accurate real time deformable objects, 1999, and A unified treatment of elastostatic contact
//! simulation for real time haptics, 2001. Owns the functions of the pot's outer
//! wall (an elastic layer on a rigid core without friction, or the layer added to a thin shell) and the contact of a rigid
//! sphere with them. Everything is elastic: nothing stays when the tool has gone.
//! Invariant: what a force at one element does to another is what the same force there does to the first.

use std::f64::consts::{FRAC_PI_2, PI};

use pottery_shared::clay::{GridShape, Support};

use super::closed_forms::contact_modulus_mpa;
use super::shell::{Compliance, End, Shell};
use super::{POISSON, Scene, median_ns};
use crate::dent::{Dent, DentError, Dented};
use crate::linear::Cholesky;

/// Steps in which the tool comes in; each starts from the last one's contact.
const UPDATES: u32 = 12;
/// Harmonics of the shell and its elements from foot to rim: with twice as many of both the deflection under a load
/// changes by less than a hundredth.
const HARMONICS: usize = 40;
const SHELL_ELEMENTS: usize = 80;
/// Distance up to which the layer's response is held, in wall thicknesses.
const REACH_PER_WALL: f64 = 6.0;
/// Solves after which a contact that still changes is taken as it is.
const SOLVES_MAX: usize = 60;
/// How far an element may stand above the body, mm: rounding.
const RAISED_MM: f64 = 1e-9;

/// What lies under the layer.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Base {
    /// The layer has no end: a half-space.
    Deep,
    /// A rigid core, on which the layer slides.
    Core,
    /// Air; what the layer's bending does is left to a shell of this radius, mm.
    Air {
        /// Radius of its middle surface.
        radius_mm: f64,
    },
}

/// An elastic layer, flat as far as a dent sees it.
#[derive(Clone, Copy, Debug)]
pub struct Layer {
    /// Thickness, mm.
    pub wall_mm: f64,
    /// Young's modulus, MPa.
    pub youngs_mpa: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// What lies under it.
    pub base: Base,
}

impl Layer {
    /// How much less than a half-space the layer gives way to a wave of pressure `p̂·J₀(kr)`, as a share of the half-space's
    /// `2p̂/(E*k)`, less one.
    ///
    /// With `a = kt`: on the core `(cosh 2a − 1)/(sinh 2a + 2a)` (Johnson 1985, section 5.8). With both faces free the half
    /// sum of the same for a core in mid-wall and of its antisymmetric twin,
    /// `½·[(cosh a − 1)/(sinh a + a) + (cosh a + 1)/(sinh a − a)]`, less the `6/a³` of a thin plate that the shell holds, and
    /// times the square of the share of the load that bending carries (see `bending_share`).
    fn share(&self, k: f64) -> f64 {
        let a = k * self.wall_mm;
        match self.base {
            Base::Deep => 0.0,
            // both sides in exponentials that do not overflow
            Base::Core => {
                let e = (-2.0 * a).exp();
                (1.0 - e).powi(2) / (1.0 - e * e + 4.0 * a * e) - 1.0
            }
            Base::Air { radius_mm } => {
                let e = (-a).exp();
                let squeezed = (1.0 - e).powi(2) / (1.0 - e * e + 2.0 * a * e);
                let bent = if a < 0.1 {
                    // the difference below would be lost in rounding
                    2.4 / a + 0.115_714 * a
                } else {
                    (1.0 + e).powi(2) / (1.0 - e * e - 2.0 * a * e) - 12.0 / a.powi(3)
                };
                let stiffness = 12.0 * (1.0 - self.poisson * self.poisson) / (radius_mm * self.wall_mm).powi(2);
                0.5 * (squeezed + bent) * bending_share(k, stiffness) - 1.0
            }
        }
    }

    /// Deflection at distances 0, `step`, 2·`step`, … from a point load, less a half-space's, mm/N:
    /// `1/(πE*)·∫ (share)·J₀(kr) dk`, by Simpson's rule.
    fn correction(&self, distances: usize, step_mm: f64) -> Vec<f64> {
        let far_mm = (distances as f64 * step_mm).max(self.wall_mm);
        let last = 60.0 / self.wall_mm;
        // forty points in a wave of the Bessel function, an even number in all
        let points = (last * far_mm / (2.0 * PI) * 40.0).ceil() as usize * 2;
        let width = last / points as f64;
        let shares: Vec<f64> = (0..=points).map(|number| self.share((number as f64).max(1e-3) * width)).collect();
        let scale = width / (3.0 * PI * contact_modulus_mpa(self.youngs_mpa, self.poisson));
        let at = |distance_mm: f64| {
            let terms = shares.iter().enumerate().map(|(number, share)| {
                let weight = match number {
                    0 => 1.0,
                    number if number == points => 1.0,
                    number if number % 2 == 1 => 4.0,
                    _ => 2.0,
                };
                weight * share * libm::j0(number as f64 * width * distance_mm)
            });
            scale * terms.sum::<f64>()
        };
        (0..distances).map(|number| at(number as f64 * step_mm)).collect()
    }

    /// Green's function of the layer: deflection of elements under a unit force spread evenly over one of them.
    ///
    /// Half-space: Love 1929 for a rectangle; the layer's correction, which is smooth, at the distance of the middles.
    #[must_use]
    pub fn table(&self, sides_mm: [f64; 2], [columns, rows]: [usize; 2]) -> LocalTable {
        let step_mm = self.wall_mm / 16.0;
        let far_mm = (columns as f64 * sides_mm[0]).hypot(rows as f64 * sides_mm[1]);
        let correction = match self.base {
            Base::Deep => vec![0.0; 2],
            _ => self.correction((far_mm / step_mm) as usize + 2, step_mm),
        };
        let modulus = contact_modulus_mpa(self.youngs_mpa, self.poisson);
        let mut entries_mm = Vec::with_capacity(columns * rows);
        for column in 0..columns {
            for row in 0..rows {
                let (x, y) = (column as f64 * sides_mm[0], row as f64 * sides_mm[1]);
                let place = x.hypot(y) / step_mm;
                let lower = (place as usize).min(correction.len() - 2);
                let between = if self.base == Base::Deep { 0.0 } else { place - lower as f64 };
                let smooth = correction[lower] * (1.0 - between) + correction[lower + 1] * between;
                entries_mm.push(love_mm_per_mpa([x, y], sides_mm, modulus) / (sides_mm[0] * sides_mm[1]) + smooth);
            }
        }
        LocalTable { columns, rows, entries_mm }
    }
}

/// Square of the share of a wave's load that a shell carries by bending, mean over the wave's directions φ:
/// `s = 1/(1 + (κ/k)⁴·cos⁴φ)`, with `κ⁴ = Et/(R²D)`; the rest goes through the wall as hoop tension and asks no shear of it.
///
/// From the equation of a shallow cylindrical shell (Donnell 1933).
fn bending_share(k: f64, stiffness: f64) -> f64 {
    let directions = 64;
    let square = |number: usize| {
        let angle = (number as f64 + 0.5) / directions as f64 * FRAC_PI_2;
        (1.0 + stiffness / k.powi(4) * angle.cos().powi(4)).powi(-2)
    };
    (0..directions).map(square).sum::<f64>() / directions as f64
}

/// Deflection of a half-space at a place from the middle of a rectangle under 1 MPa, mm.
fn love_mm_per_mpa([x, y]: [f64; 2], sides_mm: [f64; 2], modulus_mpa: f64) -> f64 {
    let term = |along: f64, across: f64| if along == 0.0 { 0.0 } else { along * (across / along.abs()).asinh() };
    let corner = |x: f64, y: f64| term(x, y) + term(y, x);
    let (left, right) = (x - 0.5 * sides_mm[0], x + 0.5 * sides_mm[0]);
    let (below, above) = (y - 0.5 * sides_mm[1], y + 0.5 * sides_mm[1]);
    (corner(right, above) - corner(left, above) - corner(right, below) + corner(left, below)) / (PI * modulus_mpa)
}

/// A layer's response over the distance in columns and rows; nothing beyond its end.
#[derive(Clone, Debug)]
pub struct LocalTable {
    columns: usize,
    rows: usize,
    /// `[columns][rows]`, mm/N.
    entries_mm: Vec<f64>,
}

impl LocalTable {
    /// Deflection of an element so many columns and rows from a unit force, mm/N.
    #[must_use]
    pub fn at_mm(&self, columns: usize, rows: usize) -> f64 {
        if columns < self.columns && rows < self.rows { self.entries_mm[columns * self.rows + rows] } else { 0.0 }
    }
}

/// Forces between a rigid body and elements that deflect under each other's forces.
#[derive(Clone, Debug)]
pub struct Contact {
    /// `[elements][elements]`, mm/N.
    compliance: Vec<f64>,
    touching: Vec<bool>,
    forces_n: Vec<f64>,
}

impl Contact {
    /// Nothing touches yet.
    #[must_use]
    pub fn new(elements: usize, compliance_mm: impl Fn(usize, usize) -> f64) -> Self {
        let entries = (0..elements * elements).map(|index| compliance_mm(index / elements, index % elements));
        Self { compliance: entries.collect(), touching: vec![false; elements], forces_n: vec![0.0; elements] }
    }

    /// Forces, N.
    #[must_use]
    pub fn forces_n(&self) -> &[f64] {
        &self.forces_n
    }

    /// Finds the forces, none of which pulls, under which no element stands above the body: `u = Σ G·f ≥ p`, `f ≥ 0`,
    /// `f·(u − p) = 0` with the penetration p of the untouched surface.
    ///
    /// Solves the touching elements' own equations (James and Pai's capacitance matrix), lets go those that would pull,
    /// takes up those that would stand above the body, and so on from the last contact.
    pub fn press(&mut self, penetration_mm: &[f64]) {
        let elements = self.touching.len();
        assert_eq!(penetration_mm.len(), elements);
        for (touching, depth) in self.touching.iter_mut().zip(penetration_mm) {
            *touching &= *depth > 0.0;
        }
        if !self.touching.contains(&true) {
            self.touching.iter_mut().zip(penetration_mm).for_each(|(touching, depth)| *touching = *depth > 0.0);
        }
        for _ in 0..SOLVES_MAX {
            let active: Vec<usize> = (0..elements).filter(|element| self.touching[*element]).collect();
            let entry = |row: usize, column: usize| self.compliance[active[row] * elements + active[column]];
            let factor = Cholesky::new(active.len(), active.len().saturating_sub(1), entry);
            let factor = factor.expect("elastic compliance is positive definite");
            let mut solved: Vec<f64> = active.iter().map(|element| penetration_mm[*element]).collect();
            factor.solve(&mut solved);
            self.forces_n.fill(0.0);
            active.iter().zip(&solved).for_each(|(element, force)| self.forces_n[*element] = force.max(0.0));
            let pulling = active.iter().zip(&solved).filter(|(_, force)| **force < 0.0);
            let mut changed = 0;
            pulling.for_each(|(element, _)| (self.touching[*element], changed) = (false, changed + 1));
            for (element, depth) in penetration_mm.iter().enumerate() {
                if changed == 0 && !self.touching[element] && *depth > 0.0 {
                    let row = &self.compliance[element * elements..][..elements];
                    let moved: f64 = active.iter().zip(&solved).map(|(other, force)| row[*other] * force).sum();
                    self.touching[element] = moved < depth - RAISED_MM;
                }
            }
            if changed == 0 && active.len() == self.touching.iter().filter(|touching| **touching).count() {
                break;
            }
        }
    }
}

/// What has been computed of a wall before the tool comes.
struct Wall {
    local: LocalTable,
    shell: Option<Compliance>,
}

impl Wall {
    fn of(scene: &Scene, support: Support) -> Self {
        let radius_mm = scene.radius_mm - 0.5 * scene.wall_mm;
        let base = if support == Support::Backed { Base::Core } else { Base::Air { radius_mm } };
        let layer = Layer { wall_mm: scene.wall_mm, youngs_mpa: scene.youngs_mpa, poisson: POISSON, base };
        let sides_mm = [scene.column_rad() * scene.radius_mm, scene.row_mm()];
        let reach_mm = REACH_PER_WALL * scene.wall_mm;
        let columns = ((reach_mm / sides_mm[0]) as usize + 1).min(scene.columns() / 2);
        let local = layer.table(sides_mm, [columns, (reach_mm / sides_mm[1]) as usize + 1]);
        let shell = Shell {
            radius_mm,
            wall_mm: scene.wall_mm,
            height_mm: scene.height_mm,
            youngs_mpa: scene.youngs_mpa,
            poisson: POISSON,
            ends: [End::Clamped, End::Free],
        };
        let shell = (support == Support::Hollow)
            .then(|| shell.compliance(HARMONICS, SHELL_ELEMENTS).expect("the clamped foot holds the shell"));
        Self { local, shell }
    }

    /// Contact of the elements that the tool can reach.
    fn contact(&self, scene: &Scene, reached: &[(i64, usize, f64)]) -> Contact {
        // a shell's response depends on the heights of both elements and on the columns between them
        let columns = reached.iter().map(|(column, ..)| column.unsigned_abs() as usize).max().unwrap_or(0) * 2 + 1;
        let first_row = reached.iter().map(|(_, row, _)| *row).min().unwrap_or(0);
        let rows = reached.iter().map(|(_, row, _)| *row).max().unwrap_or(0) + 1 - first_row;
        let bent: Vec<f64> = self.shell.as_ref().map_or_else(Vec::new, |shell| {
            let z_mm = |row: usize| (first_row + row) as f64 * scene.row_mm();
            (0..columns * rows * rows)
                .map(|index| {
                    let angle = (index / (rows * rows)) as f64 * scene.column_rad();
                    shell.at_mm(angle, z_mm(index / rows % rows), z_mm(index % rows))
                })
                .collect()
        });
        Contact::new(reached.len(), |one, other| {
            let ((column, row, _), (other_column, other_row, _)) = (reached[one], reached[other]);
            let apart = (column - other_column).unsigned_abs() as usize;
            let shell = bent.get((apart * rows + row - first_row) * rows + other_row - first_row);
            self.local.at_mm(apart, row.abs_diff(other_row)) + shell.copied().unwrap_or(0.0)
        })
    }

    /// Displacement of every element under forces on some, mm, outwards.
    fn draw(&self, scene: &Scene, reached: &[(i64, usize, f64)], forces_n: &[f64], radial_mm: &mut [f64]) {
        radial_mm.fill(0.0);
        if let Some(shell) = &self.shell {
            bend(scene, shell, reached, forces_n, radial_mm);
        }
        let rows = scene.rows();
        for (&(column, row, _), &force) in reached.iter().zip(forces_n).filter(|(_, force)| **force > 0.0) {
            for apart in 0..self.local.columns as i64 {
                let response = &self.local.entries_mm[apart as usize * self.local.rows..][..self.local.rows];
                // a column and its mirror image, which are one where the force stands
                for other in [column - apart, column + apart].into_iter().skip(usize::from(apart == 0)) {
                    let values = &mut radial_mm[scene.shape.wrap(other) as usize * rows..][..rows];
                    for (value, share) in values[row..].iter_mut().zip(response) {
                        *value -= share * force;
                    }
                    for (value, share) in values[..row].iter_mut().rev().zip(&response[1..]) {
                        *value -= share * force;
                    }
                }
            }
        }
    }
}

/// Adds the shell's deflection: per harmonic the forces' shares at its nodes, and of those the deflections round the pot.
fn bend(scene: &Scene, shell: &Compliance, reached: &[(i64, usize, f64)], forces_n: &[f64], radial_mm: &mut [f64]) {
    let (nodes, harmonics) = (shell.nodes(), shell.harmonics());
    let mut amplitudes_mm = vec![0.0; harmonics * nodes];
    for (harmonic, amplitudes) in amplitudes_mm.chunks_exact_mut(nodes).enumerate() {
        let mut loads_n = vec![0.0; nodes];
        for (&(_, row, angle), force) in reached.iter().zip(forces_n) {
            // the forces are the same on both sides of the tool, so that no sine is left
            let (lower, up) = shell.between(row as f64 * scene.row_mm());
            let share = force * (harmonic as f64 * angle).cos();
            loads_n[lower] += share * (1.0 - up);
            loads_n[lower + 1] += share * up;
        }
        for (node, load) in loads_n.iter().enumerate().filter(|(_, load)| **load != 0.0) {
            amplitudes.iter_mut().zip(shell.row(harmonic, node)).for_each(|(sum, moved)| *sum += moved * load);
        }
    }
    let places: Vec<(usize, f64)> = (0..scene.rows()).map(|row| shell.between(row as f64 * scene.row_mm())).collect();
    let mut at_nodes_mm = vec![0.0; nodes];
    for column in 0..=scene.columns() / 2 {
        at_nodes_mm.fill(0.0);
        for (harmonic, amplitudes) in amplitudes_mm.chunks_exact(nodes).enumerate() {
            let cosine = (harmonic as f64 * column as f64 * scene.column_rad()).cos();
            at_nodes_mm.iter_mut().zip(amplitudes).for_each(|(sum, amplitude)| *sum += amplitude * cosine);
        }
        let mirrored = (scene.columns() - column) % scene.columns();
        for side in [column, mirrored].into_iter().take(if mirrored == column { 1 } else { 2 }) {
            let values = &mut radial_mm[side * scene.rows()..][..scene.rows()];
            for (value, &(lower, up)) in values.iter_mut().zip(&places) {
                *value -= at_nodes_mm[lower] * (1.0 - up) + at_nodes_mm[lower + 1] * up;
            }
        }
    }
}

/// Presses an elastic wall.
///
/// Green's functions and the compliance of all elements that the tool will reach are computed beforehand; the step is one
/// of twelve equal ones: contact solved from the last one's, every element moved. Contact is solved on at most 360 × 400
/// elements, whose surface is drawn on a finer grid by interpolation, which the step's time leaves out.
///
/// # Errors
/// [`DentError`] for figures that make no sense.
pub fn press(dent: &Dent) -> Result<Dented, DentError> {
    let asked = Scene::of(dent)?;
    let paper = GridShape::PAPER;
    let coarse = GridShape::new(asked.shape.columns().min(paper.columns()), asked.shape.rows().min(paper.rows()));
    let scene = Scene { shape: coarse.map_err(pottery_shared::clay::PotError::from)?, ..asked };
    let reached = scene.reached();
    let wall = Wall::of(&scene, dent.pot.support);
    let mut contact = wall.contact(&scene, &reached);
    let mut radial_mm = vec![0.0; scene.shape.elements()];
    let step_ns = median_ns(UPDATES, |number| {
        let depth_mm = scene.depth_mm * f64::from(number) / f64::from(UPDATES);
        let penetrate =
            |&(_, row, angle): &(i64, usize, f64)| scene.penetration_mm(depth_mm, angle, row as f64 * scene.row_mm());
        contact.press(&reached.iter().map(penetrate).collect::<Vec<_>>());
        wall.draw(&scene, &reached, contact.forces_n(), &mut radial_mm);
    });
    let force_n = reached.iter().zip(contact.forces_n()).map(|((.., angle), force)| force * angle.cos()).sum();
    if dent.release {
        radial_mm.fill(0.0);
    }
    let dented = scene.dented(&radial_mm, dent.release, force_n, step_ns);
    if scene.shape == asked.shape {
        return Ok(dented);
    }
    let finer = (0..asked.columns()).flat_map(|column| {
        let angle = column as f64 * asked.column_rad();
        let dented = &dented;
        (0..asked.rows()).map(move |row| dented.radial_mm_at(angle, row as f64 * asked.row_mm()))
    });
    Ok(asked.dented(&finer.collect::<Vec<_>>(), dent.release, force_n, step_ns))
}
