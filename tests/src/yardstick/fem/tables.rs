//! What a calculation leaves on paper: the outer surface and the force over the travel, as comma-separated text.
//!
//! Owns the columns and their units; computes nothing but displacements.
//! Invariant: columns and units are those of the reference in `tests/data/reference`.

use super::body::Body;
use super::mesh::Mesh;
use std::f64::consts::{PI, TAU};
use std::fmt::Write as _;

/// One row of the force table.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Travel from first touch (m).
    pub depth_m: f64,
    /// Radial force on the whole ball, averaged over the row's time (N).
    pub force_n: f64,
    /// Time (s).
    pub time_s: f64,
    /// Radial displacement of the surface under the ball, out of the clay (m).
    pub tip_m: f64,
    /// Kinetic energy of the whole wall (J).
    pub kinetic_j: f64,
}

/// The force table, without the energies: travel (mm), force (N), time (s), radial displacement at the tip (mm).
pub fn forces_to_csv(rows: &[Row]) -> String {
    let mut text = String::from("depth_mm,force_N,t_s,u_r_tip_mm\n");
    for row in rows {
        let line = format!("{:.5},{:.5},{:.5},{:.5}", 1e3 * row.depth_m, row.force_n, row.time_s, 1e3 * row.tip_m);
        text.push_str(&line);
        text.push('\n');
    }
    text
}

/// Outer surface of a wall, a row a node, heights outermost: deformed angle (rad) and height (mm), radial displacement
/// (mm), angle and height before any load, inner radius (mm).
#[derive(Clone, Debug, PartialEq)]
pub struct Profile(pub Vec<[f64; 6]>);

impl Profile {
    /// The surface of a wall made by [`Mesh::wall`].
    pub fn of(body: &Body) -> Self {
        let [columns, rows, layers] = body.mesh.counts;
        let mut out = Vec::with_capacity(columns * rows);
        for row in 0..rows {
            for column in 0..columns {
                let node = body.mesh.node(column, row, layers - 1);
                let (now, was) = (body.position[node], body.mesh.nodes[node]);
                let back = body.position[body.mesh.node(column, row, 0)];
                let angle = was[1].atan2(was[0]);
                let turned = (now[1].atan2(now[0]) - angle + PI).rem_euclid(TAU) - PI;
                let moved = now[0].hypot(now[1]) - was[0].hypot(was[1]);
                let inner = back[0].hypot(back[1]);
                out.push([angle + turned, 1e3 * now[2], 1e3 * moved, angle, 1e3 * was[2], 1e3 * inner]);
            }
        }
        Self(out)
    }

    /// Rows whose undeformed angle (rad, round the circle) and height (mm) lie between two values, ends included.
    #[must_use]
    pub fn window(&self, [from, to]: [f64; 2], [low_mm, high_mm]: [f64; 2]) -> Self {
        const SLACK: f64 = 1e-6;
        let near = |row: &&[f64; 6]| {
            (row[3] - from + SLACK).rem_euclid(TAU) <= to - from + 2.0 * SLACK
                && (low_mm - SLACK..=high_mm + SLACK).contains(&row[4])
        };
        Self(self.0.iter().filter(near).copied().collect())
    }

    /// With what lies above a height (mm) mirrored below it; nothing lies below it yet.
    #[must_use]
    pub fn with_mirror(&self, height_mm: f64) -> Self {
        let columns = self.0.iter().take_while(|row| row[4] == self.0[0][4]).count();
        let below = self.0.chunks(columns).skip(1).rev().flatten();
        let mirrored = below.map(|&[angle, z_mm, moved, angle0, z0_mm, inner]| {
            [angle, 2.0 * height_mm - z_mm, moved, angle0, 2.0 * height_mm - z0_mm, inner]
        });
        Self(mirrored.chain(self.0.iter().copied()).collect())
    }

    /// As comma-separated text below one line of names; `digits` behind the point.
    pub fn to_csv(&self, digits: usize) -> String {
        let mut text = String::from("theta_rad(deformed),z_mm(deformed),u_r_mm,theta0,z0,r_inner_mm\n");
        for [angle, height, moved, angle0, height0, inner] in &self.0 {
            // writing to a string cannot fail
            _ = writeln!(
                text,
                "{angle:.5},{height:.digits$},{moved:.digits$},{angle0:.5},{height0:.digits$},{inner:.digits$}"
            );
        }
        text
    }
}

/// Nodes of the outer and of the inner surface of a wall.
pub fn sides(mesh: &Mesh) -> (Vec<u32>, Vec<u32>) {
    let [columns, rows, layers] = mesh.counts;
    let places = || (0..columns).flat_map(move |column| (0..rows).map(move |row| (column, row)));
    let side = |layer: usize| places().map(|(column, row)| mesh.node(column, row, layer) as u32).collect();
    (side(layers - 1), side(0))
}
