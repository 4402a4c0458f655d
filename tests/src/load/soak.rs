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
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Slope {
    /// MB an hour.
    pub mb_per_h: f64,
    /// Its standard error, MB an hour.
    pub error_mb_per_h: f64,
    /// From the first point to the last, h.
    pub hours: f64,
}

impl Slope {
    /// Longest time whose points count as one: memory goes up and down with the minute in which clay is worked again, and points
    /// that follow each other tell little more than one of them.
    const TOGETHER_S: f64 = 60.0;
    /// Least number of such times, where the points reach so far.
    const TIMES: f64 = 8.0;

    /// Through `(s, MB)`, by least squares through the means of a minute each, or of an eighth where there are fewer than eight
    /// minutes: so the error is that of the line, and not that of the points about it. None through fewer than three, which say nothing.
    #[must_use]
    pub fn through(points: &[(f64, f64)]) -> Option<Self> {
        let (first, last) = (points.first()?, points.last()?);
        let length_s = last.0 - first.0;
        let together_s = Self::TOGETHER_S.min(length_s / Self::TIMES);
        let of_time = |point: &(f64, f64)| ((point.0 - first.0) / together_s) as u64;
        let means: Vec<_> = points.chunk_by(|one, next| of_time(one) == of_time(next)).map(mean).collect();
        let (mean_x, mean_y) = mean(&means);
        let spread: f64 = means.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
        if spread == 0.0 || means.len() < 3 {
            return None;
        }
        let slope = means.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / spread;
        let rest: f64 = means.iter().map(|(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2)).sum();
        let error = (rest / (means.len() as f64 - 2.0) / spread).sqrt();
        Some(Self { mb_per_h: slope * 3600.0, error_mb_per_h: error * 3600.0, hours: length_s / 3600.0 })
    }

    /// What it grew by beyond twice the line's own error, MB.
    #[must_use]
    pub fn growth_mb(&self) -> f64 {
        ((self.mb_per_h - 2.0 * self.error_mb_per_h) * self.hours).max(0.0)
    }

    /// What memory did, in words; that it was not measured is no growth of nothing.
    #[must_use]
    pub fn told(slope: Option<&Self>) -> String {
        slope.map_or_else(
            || "not measured".to_owned(),
            |slope| {
                let (grown_mb, error) = (slope.growth_mb(), slope.error_mb_per_h);
                format!("{:+.2} ± {error:.2} MB/h, grown by {grown_mb:.2} MB beyond the error", slope.mb_per_h)
            },
        )
    }

    /// Whether memory is known to have grown by no more than `most_mb`.
    #[must_use]
    pub fn is_within(slope: Option<&Self>, most_mb: f64) -> bool {
        slope.is_some_and(|slope| slope.growth_mb() <= most_mb)
    }
}

/// The middle of some points.
fn mean(points: &[(f64, f64)]) -> (f64, f64) {
    let of = |coordinate: fn(&(f64, f64)) -> f64| points.iter().map(coordinate).sum::<f64>() / points.len() as f64;
    (of(|point| point.0), of(|point| point.1))
}

/// Of the server's memory in the measured part of a run, without its first fifth, in which clay is worked for the first time; none of a
/// server whose process is not known, or whose system does not tell.
#[must_use]
pub fn of_run(result: &RunResult) -> Option<Slope> {
    let measured = result.seconds.iter().filter(|second| second.is_measured);
    let points: Vec<_> = measured.filter_map(|second| Some((second.at_s, second.server_memory_mb?))).collect();
    Slope::through(&points[points.len() / 5..])
}

/// What came of a soak in virtual time.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Virtual {
    /// Time that passed in the room after the plan's warm-up, s.
    pub passed_s: f64,
    /// Time that it took, s.
    pub took_s: f64,
    /// Memory of this process, where the system tells.
    pub memory: Option<Slope>,
    /// Snapshots that potters held in the end.
    pub snapshots: u64,
    /// Whether everybody held the newest.
    pub is_current: bool,
    /// Samples refused.
    pub refused: u64,
}

/// Goes through the warm-up of a plan's potters and so many seconds after it in virtual time, at wheels of one room, on a line that
/// loses nothing. As in real time the line goes through memory after the warm-up and the first fifth of what follows.
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
    let warmup_ms = (plan.warmup_s * 1000.0) as u64;
    for millisecond in 1..=warmup_ms + seconds * 1000 {
        room.pass(millisecond, &Alone, |_| {});
        let is_late_enough = millisecond > warmup_ms + seconds * 200;
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
        let slope = Slope::through(&points).unwrap();
        assert!((slope.mb_per_h - 10.0).abs() < 1e-9 && slope.error_mb_per_h < 1e-9, "{slope:?}");
        assert!((slope.growth_mb() - 9.0).abs() < 1e-9);
    }

    #[test]
    fn memory_that_comes_and_goes_with_the_minute_does_not_grow() {
        // measured from anywhere in a minute to anywhere in another
        for (begins, ends) in [(0, 480), (17, 500), (40, 650), (59, 540)] {
            let points: Vec<_> =
                (begins..ends).map(|second| (f64::from(second), f64::from(second % 60) * 0.01)).collect();
            let slope = Slope::through(&points).unwrap();
            assert!(slope.mb_per_h.abs() <= 2.0 * slope.error_mb_per_h, "{begins} to {ends}: {slope:?}");
            let growing: Vec<_> = points.iter().map(|(s, mb)| (*s, mb + s * 6.0 / 3600.0)).collect();
            let slope = Slope::through(&growing).unwrap();
            assert!(slope.growth_mb() > 0.3, "{begins} to {ends}: {slope:?}");
        }
    }

    #[test]
    fn memory_that_only_shakes_does_not_grow() {
        let points: Vec<_> = (0..100).map(|second| (f64::from(second), f64::from(second % 2))).collect();
        let slope = Slope::through(&points).unwrap();
        assert!(slope.growth_mb() < 0.1, "{slope:?}");
    }

    #[test]
    fn no_line_goes_through_nothing_and_none_is_taken_for_an_even_one() {
        for points in [&[][..], &[(1.0, 5.0)], &[(1.0, 5.0), (2.0, 5.0)]] {
            assert_eq!(Slope::through(points), None);
        }
        assert!(!Slope::is_within(None, 1e9));
        assert_eq!(Slope::told(None), "not measured");
    }
}
