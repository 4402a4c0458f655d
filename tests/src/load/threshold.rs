//! What a run has to keep to.
//!
//! Owns the form `figure:quantile<bound` and the comparison; the figures are the result's.
//! Invariant: a threshold on a figure that a run does not have is a breach, not a pass.

use std::fmt;
use std::str::FromStr;

use super::result::RunResult;

/// A bound on one figure.
///
/// ```
/// use pottery_tests::load::threshold::Threshold;
///
/// let threshold: Threshold = "input_delta_ms:p99<120".parse().unwrap();
/// assert_eq!(threshold.to_string(), "input_delta_ms:p99<120");
/// let wrong = "input_delta_ms<120".parse::<Threshold>().unwrap_err();
/// assert!(wrong.to_string().contains("input_delta_ms:p99"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Threshold {
    figure: String,
    quantile: Option<String>,
    relation: Relation,
    bound: f64,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Relation {
    Less,
    AtMost,
    More,
    AtLeast,
}

impl Relation {
    const ALL: [(&'static str, Self); 4] =
        [("<=", Self::AtMost), (">=", Self::AtLeast), ("<", Self::Less), (">", Self::More)];
}

/// Why a threshold makes no sense.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ThresholdError {
    /// Not of the form.
    #[error("{text:?} is no threshold: write one like input_delta_ms:p99<120 or server_cpu_percent<80")]
    Form {
        /// What was given.
        text: String,
    },
    /// A bound below every figure.
    #[error("a figure is never less than nothing: give {text:?} a bound of 0 or more")]
    Negative {
        /// What was given.
        text: String,
    },
    /// No such figure.
    #[error("there is no figure {figure:?}: choose {known}")]
    Figure {
        /// What was given.
        figure: String,
        /// Those there are.
        known: String,
    },
}

/// Figures that have quantiles.
pub const WITH_QUANTILES: [&str; 8] = [
    "join_ms",
    "input_delta_ms",
    "input_delta_uncorrected_ms",
    "delta_age_ms",
    "correction_mm",
    "schedule_lag_ms",
    "look_lag_ms",
    "server_wake_ms",
];
/// Figures that are one number.
pub const PLAIN: [&str; 14] = [
    "strangers_age_ratio",
    "server_late_ticks",
    "server_late_ticks_alone",
    "server_cpu_percent",
    "server_memory_mb",
    "up_lost_percent",
    "failed_joins",
    "broken",
    "asked",
    "server_dropped_datagrams",
    "server_unheard",
    "server_us_per_datagram",
    "server_room_percent",
    "unlike",
];
const QUANTILES: [&str; 8] = ["count", "mean", "p50", "p90", "p95", "p99", "p999", "max"];

impl FromStr for Threshold {
    type Err = ThresholdError;

    fn from_str(text: &str) -> Result<Self, Self::Err> {
        let form = || ThresholdError::Form { text: text.to_owned() };
        let found = Relation::ALL.iter().find_map(|(sign, relation)| Some((text.split_once(sign)?, *relation)));
        let ((left, right), relation) = found.ok_or_else(form)?;
        let bound = right.trim().parse::<f64>().ok().filter(|bound| bound.is_finite()).ok_or_else(form)?;
        if bound < 0.0 {
            return Err(ThresholdError::Negative { text: text.to_owned() });
        }
        let (figure, quantile) = match left.trim().split_once(':') {
            Some((figure, quantile)) => (figure.trim(), Some(quantile.trim().to_owned())),
            None => (left.trim(), None),
        };
        let is_known = match &quantile {
            Some(quantile) => WITH_QUANTILES.contains(&figure) && QUANTILES.contains(&quantile.as_str()),
            None => PLAIN.contains(&figure),
        };
        if !is_known {
            let with: Vec<_> = WITH_QUANTILES.iter().map(|figure| format!("{figure}:p99")).collect();
            let known = format!("{} (or {}), {}", with.join(", "), QUANTILES.join(", "), PLAIN.join(", "));
            return Err(ThresholdError::Figure { figure: left.trim().to_owned(), known });
        }
        Ok(Self { figure: figure.to_owned(), quantile, relation, bound })
    }
}

impl fmt::Display for Threshold {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.figure)?;
        if let Some(quantile) = &self.quantile {
            write!(f, ":{quantile}")?;
        }
        let sign = Relation::ALL.iter().find(|(_, relation)| *relation == self.relation).map_or("", |(sign, _)| sign);
        write!(f, "{sign}{}", self.bound)
    }
}

impl Threshold {
    /// The figure that it bounds, if the run has it.
    #[must_use]
    pub fn value(&self, result: &RunResult) -> Option<f64> {
        match &self.quantile {
            Some(quantile) => result.quantiles(&self.figure).filter(|of| of.count > 0)?.named(quantile),
            None => result.plain(&self.figure),
        }
    }

    /// Whether a run keeps to it.
    #[must_use]
    pub fn holds(&self, result: &RunResult) -> bool {
        self.value(result).is_some_and(|value| match self.relation {
            Relation::Less => value < self.bound,
            Relation::AtMost => value <= self.bound,
            Relation::More => value > self.bound,
            Relation::AtLeast => value >= self.bound,
        })
    }
}
