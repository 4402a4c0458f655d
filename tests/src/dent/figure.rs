//! What the figures of a dent may be, and why one is refused.
//!
//! Owns names, units and sentences; which range a figure has is said where it is used.
//! Invariant: a figure is refused with what it was, what it may be, and both in the unit in which it is asked for.

use std::fmt;

use pottery_shared::clay::{GridError, PotError};
use pottery_shared::tool::{Sphere, ToolError};
use pottery_shared::units::Metres;

/// What a bound that was worked out may be off by rounding, over the bound.
pub(super) const HAIR: f32 = 1e-6;

/// A figure of a dent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Figure {
    /// Height of the pot, m.
    PotHeight,
    /// Outer radius of the pot, m.
    PotRadius,
    /// Thickness of its wall, m.
    Wall,
    /// Radius of the tool, m.
    ToolRadius,
    /// Radius of the ball inside, m.
    FingerRadius,
    /// Travel of the tool, m.
    Depth,
    /// Young's modulus, Pa.
    Youngs,
    /// Yield stress, Pa.
    Yield,
    /// Speed of the wheel, turns a minute.
    Speed,
    /// Turns of the wheel.
    Turns,
    /// Way along the axis, m a turn.
    Feed,
}

impl Figure {
    /// What it is called, with its article.
    const fn name(self) -> &'static str {
        match self {
            Self::PotHeight => "a pot height",
            Self::PotRadius => "a pot radius",
            Self::Wall => "a wall",
            Self::ToolRadius => "a tool radius",
            Self::FingerRadius => "a finger radius",
            Self::Depth => "a depth",
            Self::Youngs => "a Young's modulus",
            Self::Yield => "a yield stress",
            Self::Speed => "a turning speed",
            Self::Turns => "a number of turns",
            Self::Feed => "a feed",
        }
    }

    /// What it is counted in, with a space before it; nothing for turns, which are in the name.
    const fn unit(self) -> &'static str {
        match self {
            Self::Youngs => " MPa",
            Self::Yield => " kPa",
            Self::Speed => " rpm",
            Self::Turns => "",
            Self::Feed => " mm a turn",
            _ => " mm",
        }
    }

    /// How many of those the SI unit is.
    const fn scale(self) -> f32 {
        match self {
            Self::Youngs => 1e-6,
            Self::Yield => 1e-3,
            Self::Speed | Self::Turns => 1.0,
            _ => 1e3,
        }
    }

    /// Checks a value; `why` says where the range comes from, unless it is the figure's own.
    ///
    /// # Errors
    /// [`DentError::Figure`] for what is out of range or not a number.
    pub(super) fn within(self, value: f32, range: Range, why: &'static str) -> Result<(), DentError> {
        if range.holds(value) {
            return Ok(());
        }
        let scale = self.scale();
        Err(DentError::Figure { figure: self, value: value * scale, range: range.times(scale), why })
    }
}

/// What a figure may be.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Range {
    /// From the least to the most, with both.
    Closed(f32, f32),
    /// Above zero, and at most this.
    UpTo(f32),
}

impl Range {
    fn holds(self, value: f32) -> bool {
        match self {
            Self::Closed(least, most) => (least..=most).contains(&value),
            Self::UpTo(most) => value > 0.0 && value <= most,
        }
    }

    fn times(self, scale: f32) -> Self {
        match self {
            Self::Closed(least, most) => Self::Closed(least * scale, most * scale),
            Self::UpTo(most) => Self::UpTo(most * scale),
        }
    }
}

impl fmt::Display for Range {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Self::Closed(least, most) => write!(to, "from {} to {}", Rounded(least), Rounded(most)),
            Self::UpTo(most) => write!(to, "above 0 and at most {}", Rounded(most)),
        }
    }
}

/// Why a dent cannot be made.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum DentError {
    /// The grid does not fit; choose another.
    #[error(transparent)]
    Grid(#[from] GridError),
    /// A figure is not a number or out of range; choose one within it.
    #[error(
        "{} of {}{unit} cannot be used: choose one {range}{unit}{}{why}",
        figure.name(), Rounded(*value), if why.is_empty() { "" } else { ", " }, unit = figure.unit()
    )]
    Figure {
        /// Which.
        figure: Figure,
        /// What was given, in the unit in which it is asked for.
        value: f32,
        /// What can be used, in the same unit.
        range: Range,
        /// Where the range comes from; empty when it is the figure's own.
        why: &'static str,
    },
    /// A ball was to be held inside of a wall that is as thin as a wall gets; choose a thicker one.
    #[error(
        "a wall of {} mm leaves nothing to press against a finger: choose one as thick as the depth and {} mm more",
        Rounded(*wall_mm), Rounded(*least_mm)
    )]
    ThinWall {
        /// Thickness of the wall, mm.
        wall_mm: f32,
        /// What is left of any wall, mm.
        least_mm: f32,
    },
    /// A ball was to be held where there is a core; choose a hollow pot, or no ball.
    #[error("a finger inside needs a hollow pot: a backed pot has no inside")]
    NoInside,
    /// A ball was to be held in a wall that a method takes as backed; choose our method, or no ball.
    #[error("only our method knows of a finger inside: the others take every wall as backed")]
    FingerIsUnknown,
    /// The tool was to go to its depth in no step at all; choose a number above 0.
    #[error("a press in no steps cannot be made: choose at least 1")]
    NoSteps,
}

impl From<PotError> for DentError {
    fn from(error: PotError) -> Self {
        let (field, value_mm, min_mm, max_mm) = match error {
            PotError::Grid(error) => return Self::Grid(error),
            PotError::Measure { field, value_mm, min_mm, max_mm } => (field, value_mm, min_mm, max_mm),
        };
        let (figure, why) = match field {
            "height" => (Figure::PotHeight, ""),
            "radius" => (Figure::PotRadius, ""),
            _ => (Figure::Wall, "half of the pot's radius"),
        };
        Self::Figure { figure, value: value_mm, range: Range::Closed(min_mm, max_mm), why }
    }
}

impl From<ToolError> for DentError {
    fn from(error: ToolError) -> Self {
        let ToolError::Radius { radius_mm, min_mm, max_mm } = error;
        Self::Figure { figure: Figure::ToolRadius, value: radius_mm, range: Range::Closed(min_mm, max_mm), why: "" }
    }
}

/// A ball no larger than `room`, for which `why` gives the reason.
///
/// # Errors
/// [`DentError::Figure`] for a radius that no ball has, or that is larger than the room.
pub(super) fn sphere(figure: Figure, radius: Metres, room: Metres, why: &'static str) -> Result<Sphere, DentError> {
    let why = if room.0 < Sphere::RADIUS_MAX.0 { why } else { "" };
    // a hair more, so that what fits exactly is not lost to rounding
    let most_m = Sphere::RADIUS_MAX.0.min(room.0 * (1.0 + HAIR));
    figure.within(radius.0, Range::Closed(Sphere::RADIUS_MIN.0, most_m), why)?;
    Ok(Sphere::new(radius)?)
}

/// A figure as people read it: with at most three decimals, and by powers of ten where that says nothing.
#[derive(Clone, Copy, Debug)]
pub struct Rounded(pub f32);

impl fmt::Display for Rounded {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        let value = self.0;
        let (digits, power) = if value == 0.0 || !value.is_finite() || (1e-3..1e7).contains(&value.abs()) {
            // of a large one no more than it tells
            let places = (6.0 - value.abs().max(1.0).log10().floor()).min(3.0) as usize;
            (format!("{value:.places$}"), None)
        } else {
            let text = format!("{value:.3e}");
            text.split_once('e').map_or((text.clone(), None), |(digits, power)| (digits.into(), Some(power.to_owned())))
        };
        let digits = if digits.contains('.') { digits.trim_end_matches('0').trim_end_matches('.') } else { &digits };
        match power {
            Some(power) => write!(to, "{digits}e{power}"),
            None => write!(to, "{digits}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn figures_are_read_without_the_noise_of_their_rounding() {
        let cases = [
            (30.000_002, "30"),
            (7.500_000_5, "7.5"),
            (52.1, "52.1"),
            (0.0, "0"),
            (-1.0, "-1"),
            (1e-9, "1e-9"),
            (1.234_567e-8, "1.235e-8"),
            (1_000_000_060.0, "1e9"),
            (1_000_000.06, "1000000"),
            (100_000.01, "100000"),
            (f32::INFINITY, "inf"),
            (f32::NAN, "NaN"),
        ];
        for (value, text) in cases {
            assert_eq!(Rounded(value).to_string(), text);
        }
    }
}
