//! Bricks anew: nodes of a wall that a drawn tool has carried along go back to their lines, and stresses stay with the clay.
//!
//! A tool that bites deep pushes clay before it until the bricks there fold, and spreads those in its groove until it stands
//! between their corners and the uppermost is a film. So the mesh is made anew before that (rezoning of an updated Lagrangian calculation; Benson 1992). Owns the
//! new places and what is read between the old ones; the motion is [`super::body`]'s.
//! Invariant: a node stays on a line of the old mesh, stresses between old ones never leave the yield surface, which is convex, and
//! there is as much clay as before.

use super::body::{Body, gather};
use super::element::{self, CORNERS};
use super::lanes::WIDTH;

/// Where integration points lie in a brick from 0 to 1.
const NEAR: f64 = 0.211_324_865_405_187_1;
/// Looks for a place on a line.
const LOOKS: usize = 8;

/// Where the nodes of a wall's mesh belong: to the angle of their column, and on the section of the wall there in proportion to
/// its length, so that a ridge has as many as it had before it rose; and through the wall evenly.
#[derive(Clone, Debug)]
pub struct Lines {
    /// Angle of each column before any load (rad).
    angles: Vec<f64>,
    /// Share of the height below each row, and of the wall beneath each layer, before any load.
    shares: [Vec<f64>; 2],
}

/// The directions of the mesh along which nodes go back: the others are up and through.
const ALONG: usize = 0;
const AXES: [usize; 3] = [ALONG, 1, 2];

impl Lines {
    /// Of a wall as it was before any load.
    pub fn of(body: &Body) -> Self {
        let mesh = &body.mesh;
        let [columns, rows, layers] = mesh.counts;
        let z_m = |row| mesh.nodes[mesh.node(0, row, 0)][2];
        let up = (0..rows).map(|row| (z_m(row) - z_m(0)) / (z_m(rows - 1) - z_m(0))).collect();
        let through = (0..layers).map(|layer| layer as f64 / (layers - 1) as f64).collect();
        Self {
            angles: (0..columns).map(|column| polar(mesh.nodes[mesh.node(column, 0, 0)])[0]).collect(),
            shares: [up, through],
        }
    }

    /// How many bricks the farthest node is from where it belongs.
    pub fn astray(&self, body: &Body) -> f64 {
        AXES.into_iter().map(|axis| self.astray_by(body, axis)).fold(0.0, f64::max)
    }

    fn astray_by(&self, body: &Body, axis: usize) -> f64 {
        let mut farthest = 0.0_f64;
        for first in lines_along(body, axis) {
            for (number, at) in self.belong(axis, &places(body, axis, first)).into_iter().enumerate() {
                farthest = farthest.max((at - number as f64).abs());
            }
        }
        farthest
    }

    /// Where on a line of places each of its nodes belongs, counted in nodes.
    fn belong(&self, axis: usize, places: &[[f64; 3]]) -> Vec<f64> {
        let last = places.len() - 1;
        if axis == ALONG {
            let on = |column| {
                if column == 0 || column == last { column as f64 } else { on_line(places, column, self.angles[column]) }
            };
            return (0..=last).map(on).collect();
        }
        let mut lengths_m = vec![0.0];
        for pair in places.windows(2) {
            lengths_m.push(lengths_m[lengths_m.len() - 1] + (pair[1][1] - pair[0][1]).hypot(pair[1][2] - pair[0][2]));
        }
        let on = |share: f64| {
            let wanted_m = share * lengths_m[last];
            let above = lengths_m.partition_point(|length_m| *length_m <= wanted_m).clamp(1, last);
            let (low_m, high_m) = (lengths_m[above - 1], lengths_m[above]);
            (above - 1) as f64 + (wanted_m - low_m) / (high_m - low_m)
        };
        self.shares[axis - 1].iter().map(|share| on(*share)).collect()
    }

    /// Brings nodes back that are farther astray than so many bricks, and reads places, velocities and stresses where they come to
    /// lie. Good to a brick or so; what is held stays where it is.
    pub fn rezone(&self, body: &mut Body, bricks: f64) {
        for axis in AXES {
            if self.astray_by(body, axis) > bricks {
                self.rezone_by(body, axis);
            }
        }
    }

    fn rezone_by(&self, body: &mut Body, axis: usize) {
        let stresses = Stresses::of(body);
        let mut offsets = vec![0.0; body.position.len()];
        for first in lines_along(body, axis) {
            let places = places(body, axis, first);
            let velocities = read(body, axis, first, |node| body.velocity[node]);
            for (number, at) in self.belong(axis, &places).into_iter().enumerate() {
                let node = node_on(body, axis, first, number);
                if body.free[node] == [0.0; 3] || at == number as f64 {
                    continue;
                }
                let [angle, z_m, radius_m] = between(&places, at);
                let (sin, cos) = angle.sin_cos();
                offsets[node] = at - number as f64;
                body.position[node] = [radius_m * cos, radius_m * sin, z_m];
                body.velocity[node] = between(&velocities, at);
            }
        }
        stresses.moved(body, axis, &offsets).give(body, &offsets);
    }
}

/// Angle, height and radius.
fn polar(at: [f64; 3]) -> [f64; 3] {
    [at[1].atan2(at[0]), at[2], at[0].hypot(at[1])]
}

/// The first node of every line along an axis.
fn lines_along(body: &Body, axis: usize) -> Vec<[usize; 3]> {
    let [one, other] = [(axis + 1) % 3, (axis + 2) % 3];
    let node = |(i, j): (usize, usize)| {
        let mut first = [0; 3];
        (first[one], first[other]) = (i, j);
        first
    };
    let counts = body.mesh.counts;
    (0..counts[one]).flat_map(|i| (0..counts[other]).map(move |j| (i, j))).map(node).collect()
}

/// A node by its number on the line along an axis through another one.
fn node_on(body: &Body, axis: usize, mut place: [usize; 3], number: usize) -> usize {
    place[axis] = number;
    body.mesh.node(place[0], place[1], place[2])
}

fn read(body: &Body, axis: usize, first: [usize; 3], of: impl Fn(usize) -> [f64; 3]) -> Vec<[f64; 3]> {
    (0..body.mesh.counts[axis]).map(|number| of(node_on(body, axis, first, number))).collect()
}

fn places(body: &Body, axis: usize, first: [usize; 3]) -> Vec<[f64; 3]> {
    read(body, axis, first, |node| polar(body.position[node]))
}

/// Where on a line an angle is, in columns, near a column.
fn on_line(places: &[[f64; 3]], column: usize, angle: f64) -> f64 {
    let per_column = 0.5 * (places[column + 1][0] - places[column - 1][0]);
    let mut at = column as f64;
    for _ in 0..LOOKS {
        at += (angle - between(places, at)[0]) / per_column;
    }
    at
}

/// Between the values of a line, by a cubic (Catmull and Rom 1974).
fn between(values: &[[f64; 3]], at: f64) -> [f64; 3] {
    let first = (at.max(0.0) as usize).min(values.len() - 2);
    let t = (at - first as f64).clamp(0.0, 1.0);
    let (s, r) = (t * t, 1.0 - t);
    let shares = [-0.5 * t * r * r, 1.0 - 2.5 * s + 1.5 * s * t, t * (0.5 + 2.0 * t - 1.5 * s), -0.5 * s * r];
    let mut out = [0.0; 3];
    for (step, share) in shares.into_iter().enumerate() {
        let value = values[(first + step).saturating_sub(1).min(values.len() - 1)];
        (0..3).for_each(|axis| out[axis] += share * value[axis]);
    }
    out
}

/// Deviators at the integration points and mean stresses of the bricks, brick by brick.
struct Stresses {
    /// Bricks along the three directions.
    counts: [usize; 3],
    deviators: Vec<[[f64; 5]; CORNERS]>,
    means: Vec<f64>,
}

impl Stresses {
    /// Mean stresses are those of the places now: what is remembered is those of the step before, and volume would be lost.
    fn of(body: &Body) -> Self {
        let counts = body.mesh.counts.map(|nodes| nodes - 1);
        let (mut deviators, mut means) = (Vec::new(), Vec::new());
        let bulk_pa = body.material.bulk_pa();
        for (memory, corners) in body.memory.iter().zip(&body.corners) {
            let volume = element::volume(&gather(&body.position, corners, 1.0));
            for lane in 0..WIDTH {
                deviators.push(memory.deviator.map(|deviator| deviator.map(|part| part.0[lane])));
                means.push(bulk_pa * (volume.0[lane] / memory.volume_m3.0[lane]).ln());
            }
        }
        Self { counts, deviators, means }
    }

    /// Read where nodes have been moved by offsets along the lines of an axis, in bricks.
    fn moved(&self, body: &Body, axis: usize, offsets: &[f64]) -> Self {
        let [_, rows, layers] = self.counts;
        let mut new = Self { counts: self.counts, deviators: Vec::new(), means: Vec::new() };
        for (brick, nodes) in body.mesh.bricks.iter().enumerate() {
            // as `Mesh::grid` counts them
            let place = [brick / (rows * layers), brick % rows, brick / rows % layers];
            let brick_at = |number: usize| {
                let mut at = place;
                at[axis] = number;
                (at[0] * layers + at[2]) * rows + at[1]
            };
            let shifted = |parts: [f64; 3]| {
                let share = |corner: usize, axis: usize| {
                    if corner >> axis & 1 == 1 { parts[axis] } else { 1.0 - parts[axis] }
                };
                let weight = |corner: usize| share(corner, 0) * share(corner, 1) * share(corner, 2);
                let offset: f64 = (0..CORNERS).map(|corner| weight(corner) * offsets[nodes[corner] as usize]).sum();
                place[axis] as f64 + parts[axis] + offset
            };
            let (low, share) = cell(shifted([0.5; 3]) - 0.5, self.counts[axis]);
            new.means.push(self.means[brick_at(low)] * (1.0 - share) + self.means[brick_at(low + 1)] * share);
            new.deviators.push(std::array::from_fn(|point| {
                let parts = [0, 1, 2].map(|axis| if point >> axis & 1 == 1 { 1.0 - NEAR } else { NEAR });
                let (low, share) = point_cell(shifted(parts), self.counts[axis]);
                // points of the line, which differ in the bit of the axis alone
                let [low, high] =
                    [low, low + 1].map(|at| &self.deviators[brick_at(at / 2)][point & !(1 << axis) | (at & 1) << axis]);
                std::array::from_fn(|part| low[part] * (1.0 - share) + high[part] * share)
            }));
        }
        new
    }

    /// Writes itself into a body at its new places: volumes without load are such that mean stresses are what they were told to be,
    /// but for what surfaces cut off between nodes, which goes to the bricks by how far their nodes were moved.
    fn give(&self, body: &mut Body, offsets: &[f64]) {
        let (bricks, bulk_pa) = (body.mesh.bricks.len(), body.material.bulk_pa());
        let mut free_m3 = vec![0.0; bricks];
        let (mut before_m3, mut after_m3, mut all) = (0.0, 0.0, 0.0);
        let moved = |nodes: &[u32; CORNERS]| nodes.iter().map(|node| offsets[*node as usize].abs()).sum::<f64>();
        for (batch, (memory, corners)) in body.memory.iter().zip(&body.corners).enumerate() {
            let volume = element::volume(&gather(&body.position, corners, 1.0));
            for lane in 0..WIDTH.min(bricks - batch * WIDTH) {
                let brick = batch * WIDTH + lane;
                free_m3[brick] = volume.0[lane] * (-self.means[brick] / bulk_pa).exp();
                before_m3 += memory.volume_m3.0[lane];
                after_m3 += free_m3[brick];
                all += free_m3[brick] * moved(&body.mesh.bricks[brick]);
            }
        }
        let lost = (before_m3 - after_m3) / all;
        body.mass_kg.fill(0.0);
        for (free_m3, nodes) in free_m3.iter_mut().zip(&body.mesh.bricks) {
            *free_m3 *= 1.0 + lost * moved(nodes);
            for &node in nodes {
                body.mass_kg[node as usize] += body.material.density_kg_m3 * *free_m3 / CORNERS as f64;
            }
        }
        for (batch, memory) in body.memory.iter_mut().enumerate() {
            for lane in 0..WIDTH {
                // lanes beyond the last brick repeat it
                let brick = (batch * WIDTH + lane).min(bricks - 1);
                (memory.mean_stress.0[lane], memory.volume_m3.0[lane]) = (self.means[brick], free_m3[brick]);
                for (deviator, new) in memory.deviator.iter_mut().zip(&self.deviators[brick]) {
                    (0..5).for_each(|part| deviator[part].0[lane] = new[part]);
                }
            }
        }
    }
}

/// The lower of two neighbours among `count` and the share of the upper one, at the nearest end for what lies beyond.
fn cell(at: f64, count: usize) -> (usize, f64) {
    let low = (at.max(0.0) as usize).min(count - 2);
    (low, (at - low as f64).clamp(0.0, 1.0))
}

/// The same among the integration points of a line of bricks, two in each.
fn point_cell(at: f64, bricks: usize) -> (usize, f64) {
    let at = at.clamp(NEAR, bricks as f64 - NEAR);
    let whole = at.floor();
    let (part, first) = (at - whole, 2 * whole as usize);
    if part < NEAR {
        (first - 1, (part + NEAR) / (2.0 * NEAR))
    } else if part < 1.0 - NEAR {
        (first, (part - NEAR) / (1.0 - 2.0 * NEAR))
    } else {
        ((first + 1).min(2 * bricks - 2), (part - 1.0 + NEAR) / (2.0 * NEAR))
    }
}
