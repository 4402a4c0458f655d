//! Long elements: springs through the wall, side by side, over one pressure and under one skin.
//!
//! Costa and Balaniuk, LEM: an approach for real time physically based soft tissue simulation, 2001. Owns the elements and
//! their rest under a load and behind an obstacle. Everything is elastic: nothing stays when the tool has gone. The method
//! knows no bending: of a hollow pot it drops the pressure, since nothing closes the volume behind the wall.
//! Invariant: of closed elements the volume is kept to rounding after every relaxation.

use pottery_shared::clay::Support;

use super::{POISSON, Scene, median_ns};
use crate::dent::{Dent, DentError, Dented};

/// Steps in which the tool comes in; each starts from the last one's rest.
const UPDATES: u32 = 40;
/// Largest change of an element in the last sweep, mm.
const RESTED_MM: f64 = 1e-5;
/// Sweeps after which an element counts as resting anyway.
const SWEEPS_MAX: u32 = 2000;

/// Elements of equal size in columns, which close, and rows, which end; displacements are positive outwards.
#[derive(Clone, Debug)]
pub struct LongElements {
    columns: usize,
    rows: usize,
    sides_mm: [f64; 2],
    /// Stiffness of a spring over its area, MPa/mm: Young's modulus over its length.
    stiffness: f64,
    /// Pull of a neighbour that stands 1 mm higher, MPa, across columns and along rows: `T/h²`.
    pulls: [f64; 2],
    closed: bool,
    /// Pressure from outside, positive outwards, `[columns][rows]`, MPa.
    pub load_mpa: Vec<f64>,
    /// Highest place of each element, `[columns][rows]`, mm.
    pub obstacle_mm: Vec<f64>,
    /// `[columns][rows]`, mm.
    moved_mm: Vec<f64>,
    pressure_mpa: f64,
    /// Columns and rows outside which nothing but the pressure acts.
    window: [std::ops::Range<usize>; 2],
}

impl LongElements {
    /// Elements at rest; `sides_mm` along columns' and rows' direction, stiffness in MPa/mm, tension in N/mm; of `closed`
    /// elements the volume is kept.
    #[must_use]
    pub fn new([columns, rows]: [usize; 2], sides_mm: [f64; 2], [stiffness, tension]: [f64; 2], closed: bool) -> Self {
        let count = columns * rows;
        Self {
            columns,
            rows,
            sides_mm,
            stiffness,
            pulls: sides_mm.map(|side| tension / (side * side)),
            closed,
            load_mpa: vec![0.0; count],
            obstacle_mm: vec![f64::INFINITY; count],
            moved_mm: vec![0.0; count],
            pressure_mpa: 0.0,
            window: [0..columns, 0..rows],
        }
    }

    /// Displacements, `[columns][rows]`, mm.
    #[must_use]
    pub fn moved_mm(&self) -> &[f64] {
        &self.moved_mm
    }

    /// Pressure common to all elements, MPa.
    #[must_use]
    pub const fn pressure_mpa(&self) -> f64 {
        self.pressure_mpa
    }

    /// Sum of what the elements have moved, mm³.
    #[must_use]
    pub fn volume_mm3(&self) -> f64 {
        self.moved_mm.iter().sum::<f64>() * self.sides_mm[0] * self.sides_mm[1]
    }

    /// Pull of the four neighbours on an element that has not moved, MPa. At foot and rim an element is its own neighbour,
    /// so that the skin ends level.
    #[inline]
    fn pull(&self, [left, own, right]: [usize; 3], row: usize) -> f64 {
        let (below, above) = (row.saturating_sub(1), (row + 1).min(self.rows - 1));
        let at = &self.moved_mm;
        self.pulls[0] * (at[left + row] + at[right + row]) + self.pulls[1] * (at[own + below] + at[own + above])
    }

    /// Where a column and its two neighbours begin.
    const fn beside(&self, column: usize) -> [usize; 3] {
        let (left, right) = ((column + self.columns - 1) % self.columns, (column + 1) % self.columns);
        [left * self.rows, column * self.rows, right * self.rows]
    }

    /// Moves every second element, like the black squares of a board, towards its rest; returns the largest change and
    /// how many elements lie on the obstacle.
    fn sweep(&mut self, colour: usize, factor: f64) -> (f64, usize) {
        let (mut change, mut touching) = (0.0_f64, 0_usize);
        let share = 1.0 / (self.stiffness + 2.0 * (self.pulls[0] + self.pulls[1]));
        for column in self.window[0].clone() {
            let beside = self.beside(column);
            let first = self.window[1].start + (self.window[1].start + column + colour) % 2;
            for row in (first..self.window[1].end).step_by(2) {
                let index = beside[1] + row;
                let before = self.moved_mm[index];
                let rest = (self.pull(beside, row) + self.pressure_mpa + self.load_mpa[index]) * share;
                let limit = self.obstacle_mm[index];
                let after = (before + factor * (rest - before)).min(limit);
                touching += usize::from(after == limit);
                self.moved_mm[index] = after;
                change = change.max((after - before).abs());
            }
        }
        (change, touching)
    }

    /// Lets the elements come to rest: for each either `k·x − T∇²x = P + load` holds, or it lies on the obstacle, which
    /// pushes it inwards.
    ///
    /// Successive over-relaxation with the best factor for the springs (Young 1971), projected on to the obstacle; after a
    /// sweep the pressure is set so that the volume is kept.
    pub fn rest(&mut self) {
        let spread = 2.0 * (self.pulls[0] + self.pulls[1]);
        let radius = spread / (spread + self.stiffness);
        let factor = 2.0 / (1.0 + (1.0 - radius * radius).sqrt());
        for _ in 0..SWEEPS_MAX {
            let [black, white] = [0, 1].map(|colour| self.sweep(colour, factor));
            let mut change = black.0.max(white.0);
            if self.closed {
                change = change.max(self.keep_volume(black.1 + white.1));
            }
            if change < RESTED_MM {
                break;
            }
        }
    }

    /// Raises the pressure by what the elements have lost of their volume and moves those that are free to; returns how
    /// far.
    fn keep_volume(&mut self, touching: usize) -> f64 {
        let free = self.moved_mm.len() - touching;
        let window_sum: f64 = self.windowed().map(|(index, _)| self.moved_mm[index]).sum();
        let outside = self.moved_mm.len() - self.window[0].len() * self.window[1].len();
        let sum = window_sum + outside as f64 * self.pressure_mpa / self.stiffness;
        let rise_mm = if free == 0 { 0.0 } else { -sum / free as f64 };
        self.pressure_mpa += rise_mm * self.stiffness;
        for (index, _) in self.windowed() {
            if self.moved_mm[index] != self.obstacle_mm[index] {
                self.moved_mm[index] += rise_mm;
            }
        }
        rise_mm.abs()
    }

    /// Index of the elements in the window, with column and row.
    fn windowed(&self) -> impl Iterator<Item = (usize, [usize; 2])> + use<> {
        let (rows, [across, along]) = (self.rows, self.window.clone());
        across.flat_map(move |column| along.clone().map(move |row| (column * rows + row, [column, row])))
    }

    /// Force of the elements on the obstacle that each lies on, N.
    fn pushes(&self, column: usize, row: usize) -> f64 {
        let index = column * self.rows + row;
        if self.moved_mm[index] != self.obstacle_mm[index] {
            return 0.0;
        }
        let loss = self.stiffness + 2.0 * (self.pulls[0] + self.pulls[1]);
        let outwards_mpa = self.pressure_mpa + self.load_mpa[index] + self.pull(self.beside(column), row);
        (outwards_mpa - loss * self.moved_mm[index]) * self.sides_mm[0] * self.sides_mm[1]
    }

    /// Gives the elements outside the window the displacement that the pressure alone asks for.
    fn fill(&mut self) {
        let rest_mm = self.pressure_mpa / self.stiffness;
        for column in 0..self.columns {
            for row in 0..self.rows {
                if !(self.window[0].contains(&column) && self.window[1].contains(&row)) {
                    self.moved_mm[column * self.rows + row] = rest_mm;
                }
            }
        }
    }
}

/// Presses an elastic wall: springs of Young's modulus over the wall, the skin's tension `T = G·t/3` of a layer whose
/// displacement falls linearly to its base (Vlasov and Leont'ev 1966), neither of them fitted.
///
/// The step is one of forty equal ones from the last rest.
///
/// # Errors
/// [`DentError`] for figures that make no sense.
pub fn press(dent: &Dent) -> Result<Dented, DentError> {
    let scene = Scene::of(dent)?;
    let sides_mm = [scene.column_rad() * scene.radius_mm, scene.row_mm()];
    let shear_mpa = scene.youngs_mpa / (2.0 * (1.0 + POISSON));
    let (stiffness, tension) = (scene.youngs_mpa / scene.wall_mm, shear_mpa * scene.wall_mm / 3.0);
    let shape = [scene.columns(), scene.rows()];
    let mut elements = LongElements::new(shape, sides_mm, [stiffness, tension], dent.pot.support == Support::Backed);
    // turned by half a turn, so that the window need not close over the seam
    let half = scene.columns() / 2;
    let angle = |column: usize| (column as f64 - half as f64) * scene.column_rad();
    let reach_mm = scene.reached().iter().fold([0.0_f64; 2], |reach, &(_, row, angle)| {
        let z_mm = row as f64 * scene.row_mm() - 0.5 * scene.height_mm;
        [reach[0].max(angle.abs() * scene.radius_mm), reach[1].max(z_mm.abs())]
    });
    // where the skin carries less than a three-thousandth of the dent
    let margin_mm = 8.0 * (tension / stiffness).sqrt();
    let range = |middle: f64, reach: f64, side: f64, count: usize| {
        let reach = ((reach + margin_mm) / side).ceil();
        ((middle - reach).max(0.0) as usize)..((middle + reach) as usize + 2).min(count)
    };
    elements.window = [
        range(half as f64, reach_mm[0], sides_mm[0], shape[0]),
        range(0.5 * (shape[1] - 1) as f64, reach_mm[1], sides_mm[1], shape[1]),
    ];
    let step_ns = median_ns(UPDATES, |number| {
        let depth_mm = scene.depth_mm * f64::from(number) / f64::from(UPDATES);
        for (index, [column, row]) in elements.windowed() {
            let z_mm = row as f64 * scene.row_mm();
            elements.obstacle_mm[index] = -scene.penetration_mm(depth_mm, angle(column), z_mm);
        }
        elements.rest();
    });
    elements.fill();
    let pushes = elements.windowed().map(|(_, [column, row])| elements.pushes(column, row) * angle(column).cos());
    let force_n = pushes.sum();
    if dent.release {
        elements.moved_mm.fill(0.0);
    }
    let mut radial_mm = elements.moved_mm;
    radial_mm.rotate_left(half * scene.rows());
    Ok(scene.dented(&radial_mm, dent.release, force_n, step_ns))
}
