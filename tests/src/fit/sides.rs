//! Balls pressed on coarse grids and on the finest one: clay knows no grid, so the force has to be the same.
//!
//! Owns the presses and where on the grid they lie; what a sum over columns leaves out at the sides of a contact is fitted to them.
//! Invariant: the clay has come to rest when the forces are compared, so that they are linear in the constants.

use pottery_shared::clay::{GridShape, PlasticCsem, PlasticLaw};
use pottery_shared::units::Seconds;

use super::{FitError, Fitted};
use crate::chart::cases::{BASE, Scene};
use crate::dent::{Dent, DentError, Pressing};
use crate::linear::Cholesky;

/// Steps in which a ball comes in, and for which it then stands still, and how long one is.
const STEPS_IN: u32 = 300;
const STEPS_STILL: u32 = 1500;
const STEP: Seconds = Seconds(1e-3);
/// Columns and rows of the grids that are fitted, and of the finest.
pub const GRIDS: [[u32; 2]; 3] = [[240, 300], [360, 400], [480, 400]];
const FINEST: [u32; 2] = [1440, 1600];
/// Where between two columns a ball lies, in columns, and how far above a row, m.
const ASIDE: [f32; 5] = [0.0, 0.125, 0.25, 0.375, 0.5];
const ABOVE_M: f32 = 0.13e-3;
/// Fewest columns across a contact that is fitted, since narrower ones hardly have sides.
const COLUMNS_MIN: f32 = 5.0;

/// Balls, mm, and how deep they go, mm, that are fitted.
pub const FITTED: [(f32, &[f32]); 4] = [
    (8.0, &[0.5, 0.7, 0.9, 1.2, 1.7, 2.3, 3.0]),
    (12.0, &[0.5, 0.7, 0.9, 1.0, 1.15, 1.3, 1.7, 2.0, 2.6, 3.3, 4.0]),
    (20.0, &[0.4, 0.5, 0.65, 0.8, 1.0, 1.3, 2.0, 3.0, 4.0]),
    (35.0, &[0.3, 0.5, 0.8, 1.3, 2.0, 3.0]),
];
/// The same of those that are held out.
pub const HELD_OUT: [(f32, &[f32]); 3] = [
    (10.0, &[0.5, 0.6, 0.8, 1.1, 1.5, 2.2]),
    (16.0, &[0.5, 0.75, 1.0, 1.6, 2.4, 3.6]),
    (26.0, &[0.4, 0.7, 1.1, 1.9, 3.0]),
];

/// The constants, in the order in which they are fitted.
pub const SIDES: [&str; 4] = ["side_grazed", "side_by_part", "side_by_cube", "side_by_ramp"];

/// Those of a law.
#[must_use]
pub fn sides(law: &PlasticLaw) -> [f64; 4] {
    [law.side_grazed, law.side_by_part, law.side_by_cube, law.side_by_ramp].map(f64::from)
}

fn law_of(constants: [f64; 4], held: &PlasticLaw) -> PlasticLaw {
    let [side_grazed, side_by_part, side_by_cube, side_by_ramp] = constants.map(|value| value as f32);
    PlasticLaw { side_grazed, side_by_part, side_by_cube, side_by_ramp, ..*held }
}

/// A ball on a grid.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Radius of the ball and how deep it goes, mm.
    pub press_mm: [f32; 2],
    /// Columns and rows.
    pub grid: [u32; 2],
    /// Force as a sum, and what each constant of one adds to it, N.
    sum_n: f64,
    adds_n: [f64; 4],
    /// Force on the finest grid as a sum, N.
    pub finest_n: f64,
}

impl Known {
    /// By how much the force of a law is more than on the finest grid, over that.
    #[must_use]
    pub fn error(&self, constants: [f64; 4]) -> f64 {
        let added: f64 = constants.iter().zip(self.adds_n).map(|(constant, adds_n)| constant * adds_n).sum();
        (self.sum_n + added) / self.finest_n - 1.0
    }
}

/// Presses balls on every grid.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn presses(balls: &[(f32, &[f32])], law: PlasticLaw) -> Result<Vec<Known>, FitError> {
    let mut all = Vec::new();
    for &(tool_mm, depths_mm) in balls {
        for &depth_mm in depths_mm {
            let press_mm = [tool_mm, depth_mm];
            let [finest_n, ..] = forces_n(law, press_mm, FINEST, 0.0)?;
            for grid in GRIDS {
                if dent(press_mm, grid)?.columns_across().is_none_or(|columns| columns < COLUMNS_MIN) {
                    continue;
                }
                for aside in ASIDE {
                    let [sum_n, with_n @ ..] = forces_n(law, press_mm, grid, aside)?;
                    let adds_n = with_n.map(|with_n| with_n - sum_n);
                    all.push(Known { press_mm, grid, sum_n, adds_n, finest_n });
                }
            }
        }
    }
    Ok(all)
}

fn dent([tool_mm, depth_mm]: [f32; 2], [columns, rows]: [u32; 2]) -> Result<Dent, FitError> {
    let shape = GridShape::new(columns, rows).map_err(DentError::from)?;
    Ok(Scene { tool_mm, ..BASE }.dent(shape, depth_mm, false))
}

/// The force on a ball as a sum over columns, and with each constant one, N.
fn forces_n(law: PlasticLaw, press_mm: [f32; 2], grid: [u32; 2], aside: f32) -> Result<[f64; 5], FitError> {
    let dent = dent(press_mm, grid)?;
    let mut pressing = Pressing::new(dent, STEP)?;
    let (angle_rad, z_m) = (aside * dent.pot.shape.column_angle_rad(), 0.5 * dent.pot.height.0 + ABOVE_M);
    let mut step = |constants, share: f32| {
        let method = PlasticCsem { law: law_of(constants, &law) };
        f64::from(pressing.step_with(method, angle_rad, dent.depth.0 * share, z_m, 0))
    };
    for number in 1..=STEPS_IN + STEPS_STILL {
        step([0.0; 4], (number as f32 / STEPS_IN as f32).min(1.0));
    }
    let one = |constant: usize| std::array::from_fn(|other| if other + 1 == constant { 1.0 } else { 0.0 });
    Ok(std::array::from_fn(|constant| step(one(constant), 1.0)))
}

/// Root mean square of the errors of some presses.
#[must_use]
pub fn score(known: &[Known], constants: [f64; 4]) -> f64 {
    (known.iter().map(|known| known.error(constants).powi(2)).sum::<f64>() / known.len().max(1) as f64).sqrt()
}

/// Fits the four constants by least squares of the errors, with all else of `start` held; the same law where the presses do not tell them apart.
#[must_use]
pub fn fit(start: PlasticLaw, known: &[Known]) -> Fitted {
    let adds = |known: &Known, constant: usize| known.adds_n[constant] / known.finest_n;
    let normal =
        Cholesky::new(4, 3, |row, column| known.iter().map(|known| adds(known, row) * adds(known, column)).sum());
    let mut found: [f64; 4] = std::array::from_fn(|constant| {
        -known.iter().map(|known| adds(known, constant) * known.error([0.0; 4])).sum::<f64>()
    });
    match normal {
        Some(normal) => normal.solve(&mut found),
        None => found = sides(&start),
    }
    let law = law_of(found, &start);
    Fitted { law, score: score(known, sides(&law)) }
}
