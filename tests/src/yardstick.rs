//! Methods of other authors that the studio's own clay is measured against; none of them is part of the product.
//!
//! Owns the scene that all share: where the tool stands, what is read of the surface afterwards. Each method has a file,
//! and the closed forms that it is checked against stand in [`closed_forms`].
//! A yardstick presses straight in: it has no turning wheel, so that a dent's `round` is not followed.
//! [`fem`] stands apart: it is no method for a studio but the slow truth from which dents to fit come.
//! Invariant: every method reads the same [`Dent`] and is measured by the same rules as the methods of the studio.

pub mod closed_forms;
pub mod fem;
pub mod free_form;
pub mod greens;
pub mod literal;
pub mod long_elements;
pub mod shell;

use std::time::Instant;

use pottery_shared::clay::GridShape;
use pottery_shared::units::Seconds;

use crate::dent::{Dent, DentError, Dented, Pressing};

/// Poisson's ratio of wet clay, as in the reference.
pub const POISSON: f64 = 0.45;

/// A sphere before a cylinder, in millimetres, newtons and megapascals.
#[derive(Clone, Copy, Debug)]
struct Scene {
    shape: GridShape,
    radius_mm: f64,
    wall_mm: f64,
    height_mm: f64,
    tool_mm: f64,
    depth_mm: f64,
    youngs_mpa: f64,
}

impl Scene {
    fn of(dent: &Dent) -> Result<Self, DentError> {
        // refuses what the studio's own methods refuse
        Pressing::new(*dent, Seconds(1e-3))?;
        Ok(Self {
            shape: dent.pot.shape,
            radius_mm: f64::from(dent.pot.radius.as_mm()),
            wall_mm: f64::from(dent.pot.wall.as_mm()),
            height_mm: f64::from(dent.pot.height.as_mm()),
            tool_mm: f64::from(dent.tool.as_mm()),
            depth_mm: f64::from(dent.depth.as_mm()),
            youngs_mpa: f64::from(dent.strength.youngs_pa) * 1e-6,
        })
    }

    fn columns(&self) -> usize {
        self.shape.columns() as usize
    }

    fn rows(&self) -> usize {
        self.shape.rows() as usize
    }

    fn column_rad(&self) -> f64 {
        std::f64::consts::TAU / f64::from(self.shape.columns())
    }

    fn row_mm(&self) -> f64 {
        self.height_mm / f64::from(self.shape.rows() - 1)
    }

    /// How deep the untouched surface stands within the tool, mm, when the tool has come in by `depth_mm`; negative
    /// infinity beside the tool.
    fn penetration_mm(&self, depth_mm: f64, angle_rad: f64, z_mm: f64) -> f64 {
        let distance = self.radius_mm + self.tool_mm - depth_mm;
        let (aside, up) = (distance * angle_rad.sin(), z_mm - 0.5 * self.height_mm);
        let rest = self.tool_mm * self.tool_mm - aside * aside - up * up;
        let along = distance * angle_rad.cos();
        if rest > 0.0 && along > 0.0 { self.radius_mm - along + rest.sqrt() } else { f64::NEG_INFINITY }
    }

    /// The elements that the tool reaches at its full depth: signed column, row and angle from the tool, rad.
    fn reached(&self) -> Vec<(i64, usize, f64)> {
        let half = self.columns() as i64 / 2;
        let elements = (-half..=half).flat_map(|column| (0..self.rows()).map(move |row| (column, row)));
        elements
            .map(|(column, row)| (column, row, column as f64 * self.column_rad()))
            .filter(|&(_, row, angle)| self.penetration_mm(self.depth_mm, angle, row as f64 * self.row_mm()) > 0.0)
            .collect()
    }

    /// What is read of a surface whose elements have moved outwards by `radial_mm`, `[columns][rows]`.
    ///
    /// While the tool is in, no element is seen above its near side: the same rule as for the studio's methods.
    fn dented(&self, radial_mm: &[f64], release: bool, force_n: f64, step_ns: f64) -> Dented {
        let area = self.column_rad() * self.row_mm();
        let (mut volume_in_mm3, mut volume_out_mm3) = (0.0, 0.0);
        let mut seen_mm = Vec::with_capacity(radial_mm.len());
        for (column, values) in radial_mm.chunks_exact(self.rows()).enumerate() {
            let angle = column as f64 * self.column_rad();
            for (row, &moved) in values.iter().enumerate() {
                let under_tool = -self.penetration_mm(self.depth_mm, angle, row as f64 * self.row_mm());
                let seen = if release { moved } else { moved.min(under_tool) };
                let volume = (self.radius_mm + 0.5 * seen) * seen * area;
                if volume < 0.0 {
                    volume_in_mm3 -= volume;
                } else {
                    volume_out_mm3 += volume;
                }
                seen_mm.push(seen as f32);
            }
        }
        Dented {
            shape: self.shape,
            row_height_mm: self.row_mm() as f32,
            radial_mm: seen_mm,
            force_n: force_n as f32,
            finger_n: None,
            touched: self.reached().len() as u32,
            volume_in_mm3,
            volume_out_mm3,
            grows_mm: None,
            behind_mm: None,
            step_ns,
            profile_steps: (0, 0),
        }
    }
}

/// Median time of an update over some of them, ns; an update is told its number, from 1.
fn median_ns(updates: u32, mut update: impl FnMut(u32)) -> f64 {
    let mut times_ns: Vec<f64> = (1..=updates)
        .map(|number| {
            let begin = Instant::now();
            update(number);
            begin.elapsed().as_nanos() as f64
        })
        .collect();
    times_ns.sort_by(f64::total_cmp);
    times_ns[times_ns.len() / 2]
}
