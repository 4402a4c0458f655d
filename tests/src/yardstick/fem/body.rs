//! A body in motion: explicit central differences over the bricks, with rigid frictionless obstacles.
//!
//! Owns positions, velocities, stresses and the step of time; a caller owns the path of the obstacles.
//! Invariant: after a step no guarded node lies inside an obstacle.

use super::element::{self, CORNERS, Material, Memory, Vector, cross, dot};
use super::lanes::{Lanes, WIDTH};
use super::mesh::Mesh;

/// Something rigid and lubricated that nodes may not enter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Obstacle {
    /// A ball; everything inside is forbidden.
    Ball {
        /// Centre (m).
        centre_m: [f64; 3],
        /// Radius (m).
        radius_m: f64,
    },
    /// A mandrel round the z axis; everything inside its radius (m) is forbidden.
    Mandrel(f64),
    /// A mandrel round the z axis from which the wall cannot lift: its nodes stay at this radius (m).
    Film(f64),
}

impl Obstacle {
    /// Nearest allowed place when `point` is inside.
    #[inline]
    fn push_out(&self, point: [f64; 3]) -> Option<[f64; 3]> {
        match *self {
            Self::Ball { centre_m, radius_m } => {
                let d = [point[0] - centre_m[0], point[1] - centre_m[1], point[2] - centre_m[2]];
                let squared = d[0] * d[0] + d[1] * d[1] + d[2] * d[2];
                (squared < radius_m * radius_m).then(|| {
                    let scale = radius_m / squared.sqrt();
                    [centre_m[0] + d[0] * scale, centre_m[1] + d[1] * scale, centre_m[2] + d[2] * scale]
                })
            }
            Self::Mandrel(radius_m) | Self::Film(radius_m) => {
                let squared = point[0] * point[0] + point[1] * point[1];
                (squared < radius_m * radius_m || matches!(self, Self::Film(_))).then(|| {
                    let scale = radius_m / squared.sqrt();
                    [point[0] * scale, point[1] * scale, point[2]]
                })
            }
        }
    }
}

/// Steps after which the step of time is chosen again.
const STEPS_BETWEEN_CHECKS: u32 = 50;

/// An elastic-plastic body on a mesh.
#[derive(Clone, Debug)]
pub struct Body {
    /// The mesh before any load.
    pub mesh: Mesh,
    /// What it is made of.
    pub material: Material,
    /// Node positions now (m).
    pub position: Vec<[f64; 3]>,
    /// Node velocities, half a step behind the positions (m/s).
    pub velocity: Vec<[f64; 3]>,
    /// Lumped masses (kg).
    pub mass_kg: Vec<f64>,
    /// External force on each node (N).
    pub load_n: Vec<[f64; 3]>,
    /// `free[node][axis]`: 1 where the node may move, 0 where it is held (its velocity is then left as set).
    pub free: Vec<[f64; 3]>,
    /// Elastic and plastic force on each node in the last step (N).
    pub force_n: Vec<[f64; 3]>,
    /// Drag on every mass, as a rate (1/s).
    pub drag_per_s: f64,
    /// Whether the shear through the wall is taken at the middle of each brick.
    pub assumed_shear: bool,
    /// Step of time (s); follows the thinnest brick.
    pub step_s: f64,
    courant: f64,
    until_check: u32,
    pub(super) memory: Vec<Memory>,
    pub(super) corners: Vec<[[u32; CORNERS]; WIDTH]>,
}

impl Body {
    /// A body at rest without stress. `courant` is the step over the time a pressure wave takes through the thinnest
    /// brick; up to 0.9 is stable on nearly rectangular bricks.
    pub fn new(mesh: Mesh, material: Material, courant: f64) -> Self {
        let corners: Vec<[[u32; CORNERS]; WIDTH]> = mesh
            .bricks
            .chunks(WIDTH)
            .map(|chunk| std::array::from_fn(|lane| chunk[lane.min(chunk.len() - 1)]))
            .collect();
        let count = mesh.nodes.len();
        let mut mass_kg = vec![0.0; count];
        let mut memory = Vec::with_capacity(corners.len());
        let mut left = mesh.bricks.len();
        for batch in &corners {
            let volume = element::volume(&gather(&mesh.nodes, batch, 1.0));
            for (nodes, volume_m3) in batch.iter().zip(volume.0).take(left) {
                for &node in nodes {
                    mass_kg[node as usize] += material.density_kg_m3 * volume_m3 / CORNERS as f64;
                }
            }
            left = left.saturating_sub(WIDTH);
            memory.push(Memory { deviator: [[Lanes::ZERO; 5]; CORNERS], volume_m3: volume, mean_stress: Lanes::ZERO });
        }
        let thinnest = thinnest_m(&mesh.bricks, &mesh.nodes);
        Self {
            position: mesh.nodes.clone(),
            velocity: vec![[0.0; 3]; count],
            mass_kg,
            load_n: vec![[0.0; 3]; count],
            free: vec![[1.0; 3]; count],
            force_n: vec![[0.0; 3]; count],
            drag_per_s: 0.0,
            step_s: courant * thinnest / material.wave_m_s(),
            assumed_shear: true,
            courant,
            until_check: STEPS_BETWEEN_CHECKS,
            memory,
            corners,
            mesh,
            material,
        }
    }

    /// Stress (Pa) at integration point `point` of brick `brick`: xx, yy, zz, xy, xz, yz.
    pub fn stress(&self, brick: usize, point: usize) -> [f64; 6] {
        let memory = &self.memory[brick / WIDTH];
        let lane = brick % WIDTH;
        let [xx, yy, xy, xz, yz] = memory.deviator[point].map(|part| part.0[lane]);
        let mean = memory.mean_stress.0[lane];
        [xx + mean, yy + mean, mean - xx - yy, xy, xz, yz]
    }

    /// Kinetic energy (J).
    pub fn kinetic_j(&self) -> f64 {
        self.velocity.iter().zip(&self.mass_kg).map(|(v, m)| 0.5 * m * (v[0] * v[0] + v[1] * v[1] + v[2] * v[2])).sum()
    }

    fn update_forces(&mut self) {
        self.force_n.copy_from_slice(&self.load_n);
        for batch in 0..self.corners.len() {
            self.advance_batch(batch);
        }
    }

    fn advance_batch(&mut self, batch: usize) {
        let corners = &self.corners[batch];
        let position = gather(&self.position, corners, 1.0);
        let moved = gather(&self.velocity, corners, self.step_s);
        let pull = element::advance(&mut self.memory[batch], &position, &moved, &self.material, self.assumed_shear);
        let lanes = (self.mesh.bricks.len() - batch * WIDTH).min(WIDTH);
        for (lane, nodes) in corners.iter().enumerate().take(lanes) {
            for (corner, &node) in nodes.iter().enumerate() {
                let force = &mut self.force_n[node as usize];
                for axis in 0..3 {
                    force[axis] += pull[corner][axis].0[lane];
                }
            }
        }
    }

    /// One step of time. Each obstacle guards the nodes listed with it, at its place at the end of the step; `reactions`
    /// receives the force (N) on each obstacle.
    pub fn step(&mut self, obstacles: &[(Obstacle, &[u32])], reactions: &mut [[f64; 3]]) {
        if self.until_check == 0 {
            self.until_check = STEPS_BETWEEN_CHECKS;
            let thinnest = thinnest_m(&self.mesh.bricks, &self.position);
            self.step_s = self.courant * thinnest / self.material.wave_m_s();
        }
        self.until_check -= 1;
        self.update_forces();
        let dt = self.step_s;
        let (keep, gain) = (1.0 - 0.5 * self.drag_per_s * dt, 1.0 / (1.0 + 0.5 * self.drag_per_s * dt));
        for node in 0..self.position.len() {
            let rate = dt / self.mass_kg[node];
            for axis in 0..3 {
                let old = self.velocity[node][axis];
                let new = (old * keep + self.force_n[node][axis] * rate) * gain;
                let free = self.free[node][axis];
                self.velocity[node][axis] = if free == 0.0 { old } else { new };
                self.position[node][axis] += self.velocity[node][axis] * dt;
            }
        }
        for ((obstacle, nodes), reaction) in obstacles.iter().zip(reactions) {
            *reaction = [0.0; 3];
            for &node in *nodes {
                let node = node as usize;
                let point = self.position[node];
                if let Some(outside) = obstacle.push_out(point) {
                    for axis in 0..3 {
                        let kick = (outside[axis] - point[axis]) / dt;
                        self.velocity[node][axis] += kick;
                        reaction[axis] -= self.mass_kg[node] * kick / dt;
                    }
                    self.position[node] = outside;
                }
            }
        }
    }
}

/// Shortest distance between opposite faces over all bricks: volume over area at each centre (m).
fn thinnest_m(bricks: &[[u32; CORNERS]], nodes: &[[f64; 3]]) -> f64 {
    let mut thinnest_squared = f64::INFINITY;
    for brick in bricks {
        let mut span = [[0.0; 3]; 3];
        for (corner, &node) in brick.iter().enumerate() {
            for (direction, span) in span.iter_mut().enumerate() {
                let sign = if (corner >> direction) & 1 == 1 { 0.25 } else { -0.25 };
                (0..3).for_each(|axis| span[axis] += sign * nodes[node as usize][axis]);
            }
        }
        let [a, b, c] = span;
        let areas = [cross(b, c), cross(c, a), cross(a, b)];
        let volume = dot(a, areas[0]);
        let largest = areas.iter().map(|area| dot(*area, *area)).fold(0.0, f64::max);
        thinnest_squared = thinnest_squared.min(volume * volume / largest);
    }
    thinnest_squared.sqrt()
}

#[inline(always)]
pub(super) fn gather(values: &[[f64; 3]], batch: &[[u32; CORNERS]; WIDTH], factor: f64) -> [Vector; CORNERS] {
    let mut out = [[Lanes::ZERO; 3]; CORNERS];
    for lane in 0..WIDTH {
        for corner in 0..CORNERS {
            let value = values[batch[lane][corner] as usize];
            for axis in 0..3 {
                out[corner][axis].0[lane] = value[axis] * factor;
            }
        }
    }
    out
}
