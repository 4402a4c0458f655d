//! A run that goes on: whether memory grows and ticks come late, in real time or in time that costs nothing.
//!
//! Owns the line through memory over time; a run in real time is `run`'s, a room in virtual time `virtual_room`'s.
//! Invariant: in virtual time nothing waits and everything repeats from its seed.

use pottery_client::stroke::StrokeError;
use pottery_shared::room::Alone;
use serde::Serialize;

use super::host;
use super::plan::Plan;
use super::result::RunResult;
use super::virtual_room::VirtualRoom;

/// A straight line through memory over time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Slope {
    /// MB an hour.
    pub mb_per_h: f64,
    /// Its standard error, MB an hour.
    pub error_mb_per_h: f64,
    /// From the first point to the last, h.
    pub hours: f64,
}

impl Slope {
    /// Through `(s, MB)`, by least squares.
    #[must_use]
    pub fn through(points: &[(f64, f64)]) -> Self {
        let count = points.len() as f64;
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return Self::default() };
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (mean_x, mean_y) = (mean(|point| point.0), mean(|point| point.1));
        let spread: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
        if spread == 0.0 || points.len() < 3 {
            return Self::default();
        }
        let slope = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / spread;
        let rest: f64 = points.iter().map(|(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2)).sum();
        let error = (rest / (count - 2.0) / spread).sqrt();
        let hours = (last.0 - first.0) / 3600.0;
        Self { mb_per_h: slope * 3600.0, error_mb_per_h: error * 3600.0, hours }
    }

    /// What it grew by beyond twice the line's own error, MB.
    #[must_use]
    pub fn growth_mb(&self) -> f64 {
        ((self.mb_per_h - 2.0 * self.error_mb_per_h) * self.hours).max(0.0)
    }
}

/// Of the server's memory in the measured part of a run, without its first fifth, in which clay is worked for the first time.
#[must_use]
pub fn of_run(result: &RunResult) -> Slope {
    let measured = result.seconds.iter().filter(|second| second.is_measured);
    let points: Vec<_> = measured.filter_map(|second| Some((second.at_s, second.server_memory_mb?))).collect();
    Slope::through(&points[points.len() / 5..])
}

/// What came of a soak in virtual time.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Virtual {
    /// Time that passed in the room, s.
    pub passed_s: f64,
    /// Time that it took, s.
    pub took_s: f64,
    /// Memory of this process.
    pub memory: Slope,
    /// Snapshots that potters held in the end.
    pub snapshots: u64,
    /// Whether everybody held the newest.
    pub is_current: bool,
    /// Samples refused.
    pub refused: u64,
}

/// Goes through so many seconds of a plan's potters in virtual time, at wheels of one room, on a line that loses nothing.
///
/// # Errors
/// [`StrokeError`] when a stroke cannot be read.
///
/// # Panics
/// When a room does not let in whom it should.
pub fn in_virtual_time(plan: &Plan, seconds: u64) -> Result<Virtual, StrokeError> {
    let mut room = VirtualRoom::open(plan)?;
    let begun = std::time::Instant::now();
    let mut memory = Vec::new();
    for millisecond in 1..=seconds * 1000 {
        room.pass(millisecond, &Alone, |_| {});
        // the first fifth works the clay for the first time
        let is_late_enough = millisecond > seconds * 200;
        if is_late_enough && millisecond.is_multiple_of((seconds * 10).max(1)) {
            memory.extend(host::usage(std::process::id()).map(|usage| (millisecond as f64 * 1e-3, usage.memory_mb)));
        }
    }
    Ok(Virtual {
        passed_s: seconds as f64,
        took_s: begun.elapsed().as_secs_f64(),
        memory: Slope::through(&memory),
        snapshots: room.snapshots(),
        is_current: room.is_current(),
        refused: room.refused(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_through_points_has_their_slope_and_no_error() {
        let points: Vec<_> = (0..10).map(|second| (f64::from(second) * 360.0, 5.0 + f64::from(second))).collect();
        let slope = Slope::through(&points);
        assert!((slope.mb_per_h - 10.0).abs() < 1e-9 && slope.error_mb_per_h < 1e-9, "{slope:?}");
        assert!((slope.growth_mb() - 9.0).abs() < 1e-9);
    }

    #[test]
    fn memory_that_only_shakes_does_not_grow() {
        let points: Vec<_> = (0..100).map(|second| (f64::from(second), f64::from(second % 2))).collect();
        assert!(Slope::through(&points).growth_mb() < 0.1, "{:?}", Slope::through(&points));
    }
}
