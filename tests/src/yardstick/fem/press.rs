//! A pot's wall pressed by a ball: the cases against which the clay is fitted.
//!
//! Owns a case's geometry and the path of the ball; the physics is in [`super::body`].
//! Invariant: every withdrawal ends with the ball clear of the clay.

use super::body::{Body, Obstacle};
use super::element::Material;
use super::mesh::{Mesh, even, graded};
use super::tables::{Profile, Row, sides};
use std::f64::consts::PI;

/// What stands behind the wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Support {
    /// Nothing.
    Hollow,
    /// A lubricated mandrel that holds the wall at its radius: the clay slides on it and cannot lift off.
    Backed,
    /// A lubricated mandrel that the wall may leave.
    Loose,
    /// A fixed, frictionless ball opposite the tool.
    Finger {
        /// Its radius (m).
        radius_m: f64,
    },
}

/// Where the tool is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Side {
    /// Outside of the pot.
    Outside,
    /// Inside of it, where nothing else may be.
    Inside,
}

/// A wall and its mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wall {
    /// Outer radius (m).
    pub radius_m: f64,
    /// Thickness (m).
    pub wall_m: f64,
    /// Height (m); the base is clamped, the top free.
    pub height_m: f64,
    /// Bricks through the wall.
    pub layers: usize,
    /// Edge of a brick under the tool (m).
    pub fine_m: f64,
    /// How far from the tool's path that edge reaches (m).
    pub fine_until_m: f64,
    /// Growth of the edges beyond, a brick.
    pub growth: f64,
    /// Largest edge (m).
    pub coarse_m: f64,
}

/// How the calculation runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// Time of loading for a metre of travel (s/m); withdrawal takes 0.7 of it.
    pub load_s_m: f64,
    /// Time held at each depth and after each withdrawal (s).
    pub rest_s: f64,
    /// Drag while the tool moves (1/s).
    pub moving_drag_per_s: f64,
    /// Drag while it stands still (1/s).
    pub resting_drag_per_s: f64,
    /// Step of time over the time a pressure wave takes through the thinnest brick.
    pub courant: f64,
}

/// A pot and a ball.
#[derive(Clone, Debug, PartialEq)]
pub struct Case {
    /// The wall.
    pub wall: Wall,
    /// Height of the ball's centre (m).
    pub at_m: f64,
    /// The ball's radius (m).
    pub ball_m: f64,
    /// Where it is.
    pub side: Side,
    /// Behind the wall.
    pub support: Support,
    /// The clay.
    pub material: Material,
    /// Whether the shear through the wall is assumed constant along each brick; see [`Body::assumed_shear`].
    pub assumed_shear: bool,
    /// Travels to press to, one after the other, each followed by a withdrawal (m).
    pub depths_m: Vec<f64>,
    /// How the calculation runs.
    pub pace: Pace,
}

/// The calculation blew up.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the wall lost its shape after {time_s} s at {courant} of the stable step; choose a smaller share")]
pub struct Diverged {
    /// Time from the first touch (s).
    pub time_s: f64,
    /// Step of time over the time a pressure wave takes through the thinnest brick.
    pub courant: f64,
}

/// Where the tool waits outside the clay, as a travel (m).
pub(super) const CLEAR_M: f64 = -0.0002;
/// Share of the time of loading that a withdrawal takes.
pub(super) const WITHDRAWAL: f64 = 0.7;

/// A case in progress.
#[derive(Clone, Debug)]
pub struct Press {
    /// The case.
    pub case: Case,
    /// The wall.
    pub body: Body,
    /// Rows so far.
    pub rows: Vec<Row>,
    /// Nodes that the tool meets, and those of the other side.
    met: Vec<u32>,
    others: Vec<u32>,
    tip: usize,
    time_s: f64,
}

impl Press {
    /// The wall before the first touch: a half model, mirrored about the plane of the tool.
    pub fn new(case: Case) -> Self {
        let wall = &case.wall;
        let line = |end_m: f64| graded(end_m, wall.fine_m, wall.fine_until_m, wall.growth, wall.coarse_m);
        let angles: Vec<f64> = line(PI * wall.radius_m).iter().map(|arc_m| arc_m / wall.radius_m).collect();
        let below = line(case.at_m);
        let mut heights_m: Vec<f64> = below.iter().rev().map(|down_m| case.at_m - down_m).collect();
        heights_m.extend(line(wall.height_m - case.at_m).iter().skip(1).map(|up_m| case.at_m + up_m));
        let radii_m = even(wall.radius_m - wall.wall_m, wall.radius_m, wall.layers);
        let mesh = Mesh::wall(&angles, &heights_m, &radii_m);
        let is_inside = case.side == Side::Inside;
        let tip = mesh.node(0, below.len() - 1, if is_inside { 0 } else { wall.layers });
        let mut body = Body::new(mesh, case.material, case.pace.courant);
        body.assumed_shear = case.assumed_shear;
        let [columns, rows, layers] = body.mesh.counts;
        for layer in 0..layers {
            for row in 0..rows {
                for column in [0, columns - 1] {
                    body.free[body.mesh.node(column, row, layer)][1] = 0.0;
                }
            }
            for column in 0..columns {
                body.free[body.mesh.node(column, 0, layer)] = [0.0; 3];
            }
        }
        let (outer, inner) = sides(&body.mesh);
        let (met, others) = if is_inside { (inner, outer) } else { (outer, inner) };
        Self { case, body, rows: Vec::new(), met, others, tip, time_s: 0.0 }
    }

    /// Radius of the side that the tool meets, before any load, and the sense of what goes out of the clay there.
    fn met_m(&self) -> (f64, f64) {
        let wall = &self.case.wall;
        match self.case.side {
            Side::Outside => (wall.radius_m, 1.0),
            Side::Inside => (wall.radius_m - wall.wall_m, -1.0),
        }
    }

    fn ball(&self, depth_m: f64) -> Obstacle {
        let (radius_m, (met_m, out)) = (self.case.ball_m, self.met_m());
        Obstacle::Ball { centre_m: [met_m + out * (radius_m - depth_m), 0.0, self.case.at_m], radius_m }
    }

    fn behind(&self) -> Option<Obstacle> {
        let inside_m = self.case.wall.radius_m - self.case.wall.wall_m;
        match self.case.support {
            Support::Hollow => None,
            Support::Backed => Some(Obstacle::Film(inside_m)),
            Support::Loose => Some(Obstacle::Mandrel(inside_m)),
            Support::Finger { radius_m } => {
                Some(Obstacle::Ball { centre_m: [inside_m - radius_m, 0.0, self.case.at_m], radius_m })
            }
        }
    }

    /// Moves the ball from one travel to another along a smooth ramp, or holds it where both are equal.
    fn carry(&mut self, from_m: f64, to_m: f64, time_s: f64, records: usize) -> Result<(), Diverged> {
        let pace = self.case.pace;
        self.body.drag_per_s = if from_m == to_m { pace.resting_drag_per_s } else { pace.moving_drag_per_s };
        let behind = self.behind();
        let every_s = time_s / records.max(1) as f64;
        let (mut elapsed_s, mut next_s, mut recorded_m) = (0.0, every_s, from_m);
        let (mut sum_n, mut count) = (0.0, 0.0);
        let mut reactions = [[0.0; 3]; 2];
        while elapsed_s < time_s {
            elapsed_s += self.body.step_s;
            let depth_m = from_m + (to_m - from_m) * ramp((elapsed_s / time_s).min(1.0));
            let ball = (self.ball(depth_m), self.met.as_slice());
            match behind {
                Some(behind) => self.body.step(&[ball, (behind, &self.others)], &mut reactions),
                None => self.body.step(&[ball], &mut reactions[..1]),
            }
            self.time_s += self.body.step_s;
            // the mirrored half carries as much again
            sum_n += 2.0 * self.met_m().1 * reactions[0][0];
            count += 1.0;
            if elapsed_s >= next_s.min(time_s) {
                next_s += every_s;
                self.record(0.5 * (depth_m + recorded_m), sum_n / count)?;
                (sum_n, count, recorded_m) = (0.0, 0.0, depth_m);
            }
        }
        Ok(())
    }

    fn record(&mut self, depth_m: f64, force_n: f64) -> Result<(), Diverged> {
        let place = self.body.position[self.tip];
        let (met_m, out) = self.met_m();
        let tip_m = out * (place[0].hypot(place[1]) - met_m);
        let kinetic_j = 2.0 * self.body.kinetic_j();
        if !(force_n.is_finite() && kinetic_j.is_finite()) {
            return Err(Diverged { time_s: self.time_s, courant: self.case.pace.courant });
        }
        self.rows.push(Row { depth_m, force_n, time_s: self.time_s, tip_m, kinetic_j });
        Ok(())
    }

    /// Runs the whole case; `seen` is given each travel (m) and whether the tool is still in, with the wall as it is then.
    ///
    /// # Errors
    /// [`Diverged`] when a force or an energy is not finite.
    pub fn run(&mut self, mut seen: impl FnMut(f64, bool, &Self)) -> Result<(), Diverged> {
        let Pace { load_s_m, rest_s, .. } = self.case.pace;
        let mut start_m = 0.0;
        for depth_m in self.case.depths_m.clone() {
            self.carry(start_m, depth_m, load_s_m * (depth_m - start_m), 60)?;
            self.carry(depth_m, depth_m, rest_s, 4)?;
            seen(depth_m, true, self);
            self.carry(depth_m, CLEAR_M, WITHDRAWAL * load_s_m * (depth_m - CLEAR_M), 60)?;
            self.carry(CLEAR_M, CLEAR_M, rest_s, 4)?;
            seen(depth_m, false, self);
            // half-way back to what stays: nothing is touched there
            start_m = -0.5 * self.rows.last().map_or(0.0, |row| row.tip_m);
            self.carry(CLEAR_M, start_m, 0.3 * load_s_m * start_m.abs(), 1)?;
        }
        Ok(())
    }

    /// The outer surface now.
    pub fn profile(&self) -> Profile {
        Profile::of(&self.body)
    }
}

/// From 0 to 1 along half a cosine.
pub(super) fn ramp(phase: f64) -> f64 {
    0.5 - 0.5 * (PI * phase).cos()
}
