//! Corrections in the picture: what the server says otherwise does not jump, it fades in.
//!
//! Owns what is drawn beside what is predicted; the hand never sees it. Holds no clock.
//! Invariant: what is drawn is what is predicted plus an error that only shrinks between two corrections; where the error is
//! gone the two are equal to the bit.
//!
//! Every correction, others' clay included, leaves an error of old less new. It goes by `exp(−t/τ)` with τ = 30 ms, so that a
//! twenty-eighth of it is left after 100 ms. What the own hand presses is drawn at once.

use std::time::Duration;

use pottery_shared::clay::{Pot, Surface, Window};
use pottery_shared::snapshot::Touched;

/// Time in which an error falls to 1/e.
const FADE: Duration = Duration::from_millis(30);
/// Errors are made smaller no oftener than this: what a screen shows.
const STEP: Duration = Duration::from_millis(12);
/// Error that nobody sees: half of the step in which clay travels.
const UNSEEN_M: f32 = 1.9e-6;

/// The clay as it is drawn.
#[derive(Clone, Debug)]
pub struct Fade {
    drawn: Pot,
    /// Drawn less predicted, `[surface]`.
    errors: Vec<Errors>,
    /// Tiles in which there is an error.
    fading: Touched,
    stepped_at: Duration,
}

/// Errors of one surface, m, `[columns][rows]`.
#[derive(Clone, Debug)]
struct Errors {
    rows: usize,
    metres: Vec<f32>,
}

impl Errors {
    /// The errors of one column of a window.
    fn column_mut(&mut self, column: u32, window: Window) -> &mut [f32] {
        let first = column as usize * self.rows + window.first_row as usize;
        &mut self.metres[first..first + window.rows as usize]
    }
}

impl Fade {
    /// Draws a pot as it is.
    #[must_use]
    pub fn new(pot: &Pot) -> Self {
        let shapes = || pot.surfaces().iter().map(Surface::shape);
        let errors = |shape: pottery_shared::clay::GridShape| Errors {
            rows: shape.rows() as usize,
            metres: vec![0.0; shape.elements()],
        };
        Self {
            drawn: pot.clone(),
            errors: shapes().map(errors).collect(),
            fading: Touched::none(shapes()),
            stepped_at: Duration::ZERO,
        }
    }

    /// The clay to draw.
    #[must_use]
    pub const fn drawn(&self) -> &Pot {
        &self.drawn
    }

    /// Takes in that the predicted clay was corrected in these tiles, which stay as they are for now.
    pub fn correct(&mut self, predicted: &Pot, tiles: &Touched) {
        for (surface, tile, window) in tiles.iter() {
            let (old, new) = (&self.drawn.surfaces()[surface], &predicted.surfaces()[surface]);
            let rows = window.first_row as usize..window.end_row() as usize;
            let mut any = false;
            for column in window.first_column..window.first_column + window.columns {
                let both = old.column_m(column)[rows.clone()].iter().zip(&new.column_m(column)[rows.clone()]);
                for (error, (old, new)) in self.errors[surface].column_mut(column, window).iter_mut().zip(both) {
                    *error = seen(old - new);
                    any |= *error != 0.0;
                }
            }
            if any {
                self.fading.add(surface, tile);
            }
        }
    }

    /// Draws the tiles that changed and those that fade, and adds all of them to `changed`.
    pub fn draw(&mut self, predicted: &Pot, news: &Touched, now: Duration, changed: &mut Touched) {
        let mut tiles = news.clone();
        let passed = now.saturating_sub(self.stepped_at);
        if passed >= STEP {
            self.stepped_at = now;
            tiles.add_all(&self.fading);
            self.shrink((-passed.as_secs_f32() / FADE.as_secs_f32()).exp());
        }
        for (surface, _, window) in tiles.iter() {
            self.drawn.copy_window(predicted, surface, window);
            let clay = &mut self.drawn.surfaces_mut()[surface];
            for column in window.first_column..window.first_column + window.columns {
                let errors = self.errors[surface].column_mut(column, window);
                for (row, error) in (window.first_row..).zip(&*errors).filter(|(_, error)| **error != 0.0) {
                    clay.set_radius(column, row, clay.column_m(column)[row as usize] + error);
                }
            }
        }
        changed.add_all(&tiles);
    }

    fn shrink(&mut self, share: f32) {
        let emptied = self.fading.emptied();
        let before = std::mem::replace(&mut self.fading, emptied);
        for (surface, tile, window) in before.iter() {
            let mut any = false;
            for column in window.first_column..window.first_column + window.columns {
                for error in self.errors[surface].column_mut(column, window) {
                    *error = seen(*error * share);
                    any |= *error != 0.0;
                }
            }
            if any {
                self.fading.add(surface, tile);
            }
        }
    }
}

/// An error that can be seen, or none.
fn seen(error_m: f32) -> f32 {
    if error_m.abs() > UNSEEN_M { error_m } else { 0.0 }
}
