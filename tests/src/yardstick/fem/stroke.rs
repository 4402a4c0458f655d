//! A ball drawn along a backed wall, stroke beside stroke: what a tool does to a place on a turning pot, turn by turn.
//!
//! Owns the path and what is read of each stroke. The helix of a feed is so flat that a stroke keeps its height; the wall
//! is a sector whose ends are held some walls' thickness beyond the strokes.
//! Invariant: a stroke begins and ends with the ball clear of the clay.

use super::body::{Body, Obstacle};
use super::element::Material;
use super::mesh::{Mesh, even, graded};
use super::press::{CLEAR_M, Diverged, Pace, WITHDRAWAL, Wall, ramp};
use super::rezone::Lines;
use super::tables::{Profile, sides};

/// A wall on a lubricated mandrel and the strokes of a ball along it.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// The wall; its fine mesh reaches beyond all strokes and along the whole sector.
    pub wall: Wall,
    /// The ball's radius (m).
    pub ball_m: f64,
    /// Travel from the untouched surface (m) and height (m) of each stroke, one after the other.
    pub strokes: Vec<[f64; 2]>,
    /// Arc of each stroke (m); it begins at the angle 0.
    pub length_m: f64,
    /// Arc beyond both ends of the strokes (m).
    pub margin_m: f64,
    /// Speed along the surface (m/s); `ρv²` is what inertia adds to the clay's hardness.
    pub speed_m_s: f64,
    /// The clay.
    pub material: Material,
    /// How the calculation runs.
    pub pace: Pace,
}

impl Drawing {
    /// Whether the wall is only what lies above the path, mirrored below it: a single stroke has equal sides.
    const fn is_mirrored(&self) -> bool {
        self.strokes.len() == 1
    }
}

/// Force on the ball (N): radial, positive outwards; tangential, negative against its motion; axial, positive upwards.
pub type Forces = [f64; 3];

/// What a stroke leaves.
#[derive(Clone, Debug)]
pub struct Stroke {
    /// Its number, from 1.
    pub number: usize,
    /// Surface after the ball has left.
    pub unloaded: Profile,
    /// Mean force over the second half of the stroke.
    pub moving_n: Forces,
    /// Force with the ball at rest at the end.
    pub held_n: Forces,
}

/// Stretch of path over which the tool gathers or loses its speed (m).
const START_M: f64 = 0.006;

/// Steps between two looks at how far nodes have gone astray, and how many bricks that may be.
const STEPS_BETWEEN_LOOKS: u32 = 10;
const ASTRAY: f64 = 0.3;

struct Run {
    case: Drawing,
    body: Body,
    lines: Lines,
    until_look: u32,
    outer: Vec<u32>,
    inner: Vec<u32>,
    arc_m: f64,
    height_m: f64,
    time_s: f64,
}

impl Run {
    fn new(case: &Drawing) -> Self {
        let wall = &case.wall;
        let lowest_m = case.strokes.iter().map(|stroke| stroke[1]).fold(f64::INFINITY, f64::min);
        let highest_m = case.strokes.iter().map(|stroke| stroke[1]).fold(0.0, f64::max);
        let line = |end_m: f64, until_m: f64| graded(end_m, wall.fine_m, until_m, wall.growth, wall.coarse_m);
        let is_mirrored = case.is_mirrored();
        let below = if is_mirrored { vec![0.0] } else { line(lowest_m, wall.fine_until_m) };
        let mut heights_m: Vec<f64> = below.iter().rev().map(|down_m| lowest_m - down_m).collect();
        let above = line(wall.height_m - lowest_m, wall.fine_until_m + highest_m - lowest_m);
        heights_m.extend(above.iter().skip(1).map(|up_m| lowest_m + up_m));
        let spans = ((case.length_m + 2.0 * case.margin_m) / wall.fine_m).round() as usize;
        let ends_rad = [-case.margin_m / wall.radius_m, (case.length_m + case.margin_m) / wall.radius_m];
        let radii_m = even(wall.radius_m - wall.wall_m, wall.radius_m, wall.layers);
        let mesh = Mesh::wall(&even(ends_rad[0], ends_rad[1], spans), &heights_m, &radii_m);
        let mut body = Body::new(mesh, case.material, case.pace.courant);
        body.assumed_shear = false;
        let [columns, rows, layers] = body.mesh.counts;
        for column in 0..columns {
            for row in (0..rows).filter(|row| *row == 0 || column == 0 || column == columns - 1) {
                let is_end = column == 0 || column == columns - 1;
                let free = if is_mirrored && !is_end { [1.0, 1.0, 0.0] } else { [0.0; 3] };
                for layer in 0..layers {
                    body.free[body.mesh.node(column, row, layer)] = free;
                }
            }
        }
        let (outer, inner) = sides(&body.mesh);
        let lines = Lines::of(&body);
        Self { lines, until_look: 0, case: case.clone(), body, outer, inner, arc_m: 0.0, height_m: 0.0, time_s: 0.0 }
    }

    fn step(&mut self, depth_m: f64) -> Forces {
        let Wall { radius_m, wall_m, .. } = self.case.wall;
        let reach_m = radius_m + self.case.ball_m - depth_m;
        let (sin, cos) = (self.arc_m / radius_m).sin_cos();
        let ball =
            Obstacle::Ball { centre_m: [reach_m * cos, reach_m * sin, self.height_m], radius_m: self.case.ball_m };
        let mut reactions = [[0.0; 3]; 2];
        self.body.step(&[(ball, &self.outer), (Obstacle::Film(radius_m - wall_m), &self.inner)], &mut reactions);
        self.time_s += self.body.step_s;
        // without it a deep bite folds the mesh, and one of 1 mm carries the bottom of its groove along
        if self.until_look == 0 {
            self.lines.rezone(&mut self.body, ASTRAY);
        }
        self.until_look = self.until_look.checked_sub(1).unwrap_or(STEPS_BETWEEN_LOOKS - 1);
        let [x, y, z] = reactions[0];
        let force = [x * cos + y * sin, y * cos - x * sin, z];
        // the mirrored half carries as much again, and is pushed down by as much as the other is pushed up
        if self.case.is_mirrored() { [2.0 * force[0], 2.0 * force[1], 0.0] } else { force }
    }

    /// Moves the ball in or out where it stands, or holds it; returns the mean force over the last quarter of the time.
    fn plunge(&mut self, from_m: f64, to_m: f64, time_s: f64) -> Forces {
        let pace = self.case.pace;
        self.body.drag_per_s = if from_m == to_m { pace.resting_drag_per_s } else { pace.moving_drag_per_s };
        let (mut elapsed_s, mut mean) = (0.0, Mean::default());
        while elapsed_s < time_s {
            elapsed_s += self.body.step_s;
            let force = self.step(from_m + (to_m - from_m) * ramp((elapsed_s / time_s).min(1.0)));
            if elapsed_s > 0.75 * time_s {
                mean.add(force);
            }
        }
        mean.value()
    }

    /// Draws the ball along the whole stroke and stops; returns the mean force over its second half.
    fn draw(&mut self, depth_m: f64) -> Forces {
        self.body.drag_per_s = self.case.pace.moving_drag_per_s;
        let Drawing { length_m, speed_m_s: top_m_s, .. } = self.case;
        let gain_m_s2 = top_m_s * top_m_s / (2.0 * START_M);
        let mut mean = Mean::default();
        let mut speed_m_s = 0.0;
        self.arc_m = 0.0;
        while self.arc_m < length_m {
            let (left_m, dt) = (length_m - self.arc_m, self.body.step_s);
            // a hundredth of the speed at the end, so that it is reached
            let braking_m_s = (2.0 * gain_m_s2 * left_m).sqrt().max(0.01 * top_m_s);
            speed_m_s = (speed_m_s + gain_m_s2 * dt).min(top_m_s).min(braking_m_s);
            self.arc_m += (speed_m_s * dt).min(left_m);
            let force = self.step(depth_m);
            if (START_M..0.5 * length_m).contains(&left_m) {
                mean.add(force);
            }
        }
        mean.value()
    }

    /// The outer surface now, to both sides of the path.
    fn surface(&self) -> Profile {
        let surface = Profile::of(&self.body);
        if self.case.is_mirrored() { surface.with_mirror(1e3 * self.height_m) } else { surface }
    }

    fn stroke(&mut self, number: usize, [depth_m, height_m]: [f64; 2]) -> Result<Stroke, Diverged> {
        let pace = self.case.pace;
        (self.arc_m, self.height_m) = (0.0, height_m);
        self.plunge(CLEAR_M, depth_m, pace.load_s_m * (depth_m - CLEAR_M));
        let moving_n = self.draw(depth_m);
        let held_n = self.plunge(depth_m, depth_m, pace.rest_s);
        // a body that is lost is touched by nothing, so that its forces may be finite
        if !self.body.kinetic_j().is_finite() || !moving_n.iter().chain(&held_n).all(|part| part.is_finite()) {
            return Err(Diverged { time_s: self.time_s, courant: pace.courant });
        }
        self.plunge(depth_m, CLEAR_M, WITHDRAWAL * pace.load_s_m * (depth_m - CLEAR_M));
        self.plunge(CLEAR_M, CLEAR_M, pace.rest_s);
        Ok(Stroke { number, unloaded: self.surface(), moving_n, held_n })
    }
}

/// Makes all strokes and reports each as it ends.
///
/// # Errors
/// [`Diverged`] when a force is not finite.
pub fn run(case: &Drawing, mut seen: impl FnMut(&Stroke)) -> Result<(), Diverged> {
    let mut run = Run::new(case);
    for (before, &stroke) in case.strokes.iter().enumerate() {
        seen(&run.stroke(before + 1, stroke)?);
    }
    Ok(())
}

/// A mean that grows.
#[derive(Clone, Copy, Debug, Default)]
struct Mean {
    sum: Forces,
    count: f64,
}

impl Mean {
    fn add(&mut self, force: Forces) {
        (0..3).for_each(|axis| self.sum[axis] += force[axis]);
        self.count += 1.0;
    }

    fn value(&self) -> Forces {
        self.sum.map(|part| part / self.count.max(1.0))
    }
}
