//! The stroke file: where a tool was at which time, as comma-separated text.
//!
//! Owns the format, both ways; knows no clay and no clock. `tests/data/strokes/README.md` describes it for people.
//! Invariant: times ascend strictly, and every sample keeps the bounds of [`SampleError`]; a stroke has at least one.

mod format;
mod recorder;

use std::path::{Path, PathBuf};
use std::{fs, io};

use glam::Vec3;
use pottery_shared::tool::{Orientation, Tool, ToolError};
use pottery_shared::units::Rpm;

pub use recorder::StrokeRecorder;

/// Latest time a sample may have, s: one day.
const TIME_MAX_S: f64 = 86_400.0;
/// Farthest a tool may be from the foot of the pot, m.
const DISTANCE_MAX_M: f64 = 1.0;
/// Fastest a tool may move between two samples, m/s: a quick hand.
const SPEED_MAX_M_S: f64 = 5.0;

/// The path of a hand over the wheel, with the tools and the turning speed it was made with.
///
/// Times are seconds from the start of the file, places are the tool's centre in the room's frame: z up along the
/// wheel's axis, the foot of the pot at z = 0.
///
/// ```
/// use pottery_client::stroke::Stroke;
/// use pottery_shared::tool::{Shape, Tool};
///
/// let stroke = Stroke::parse("# tool: rib\nt_s,x_mm,y_mm,z_mm\n0,90,0,50\n0.5,70,0,50\n")?;
/// assert_eq!(stroke.tool_at(0.25), Tool::Convex(Shape::RIB));
/// let halfway = stroke.at(0.25).ok_or("the tool is there")?;
/// assert!((halfway.x - 0.080).abs() < 1e-6);
/// assert_eq!(stroke.at(0.6), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Stroke {
    wheel_speed: Rpm,
    samples: Vec<Sample>,
}

/// The tool at one time.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Sample {
    time_s: f64,
    tool: Tool,
    centre_m: Vec3,
    orientation: Orientation,
    /// The tool was lifted before this sample, so that nothing lies between it and the one before.
    after_lift: bool,
}

/// Why a sample cannot follow those before it.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SampleError {
    /// The time is not a number or out of range; count seconds from the start of the stroke.
    #[error("a time of {time_s} s cannot be used: count seconds from the start, from 0 to {max_s}")]
    Time {
        /// The time given, s.
        time_s: f64,
        /// Latest time, s.
        max_s: f64,
    },
    /// The time does not come after the one before; sort the samples and leave out repeated ones.
    #[error("{time_s} s does not come after {before_s} s: let the time grow from row to row")]
    NotLater {
        /// The time given, s.
        time_s: f64,
        /// The time of the sample before, s.
        before_s: f64,
    },
    /// The place is not a number or too far away; give mm in the room's frame.
    #[error(
        "the tool is {distance_mm:.1} mm from the foot of the pot, farther than {max_mm} mm: give millimetres, with the \
         wheel's axis at x = y = 0"
    )]
    TooFar {
        /// Distance from the origin, mm.
        distance_mm: f64,
        /// Largest distance, mm.
        max_mm: f64,
    },
    /// The tool would move faster than a hand; take more samples, or lift the tool in between.
    #[error(
        "the tool moves at {speed_m_s:.2} m/s, faster than {max_m_s} m/s: check units and times, or part the rows by \
         an empty line if the tool was away"
    )]
    TooFast {
        /// Speed between the sample before and this one, m/s.
        speed_m_s: f64,
        /// Largest speed, m/s.
        max_m_s: f64,
    },
}

/// What is in the way of a file.
fn unread(source: &io::Error) -> String {
    if source.kind() == io::ErrorKind::InvalidData {
        return "it is no text; choose a file of comma-separated lines, such as --record writes".into();
    }
    source.to_string()
}

/// Why a stroke cannot be read.
#[derive(Debug, thiserror::Error)]
pub enum StrokeError {
    /// The file cannot be opened or is no text; check its name.
    #[error("cannot read the stroke {}: {}", path.display(), unread(source))]
    File {
        /// The file.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A row stands where the header should; write the header first.
    #[error(
        "line {line}: expected the header `t_s,x_mm,y_mm,z_mm` before the first row, with `,yaw_deg,pitch_deg,roll_deg` \
         if the tool turns; found {found:?}"
    )]
    Header {
        /// Number of the line, from 1.
        line: usize,
        /// What stands there.
        found: String,
    },
    /// There is no header, or no row under it; write at least one row.
    #[error("the stroke is empty: write the header `t_s,x_mm,y_mm,z_mm` and at least one row under it")]
    Empty,
    /// A row has too few or too many columns; give those of the header.
    #[error("line {line}: found {found} columns, expected {expected} separated by commas, as in the header")]
    Columns {
        /// Number of the line, from 1.
        line: usize,
        /// Number of columns found.
        found: usize,
        /// Number of columns in the header.
        expected: usize,
    },
    /// A field is not a finite number; write it in digits with a decimal point.
    #[error("line {line}: {field} is {text:?}, expected a finite number such as -12.5")]
    Number {
        /// Number of the line, from 1.
        line: usize,
        /// Name of the column or of the setting.
        field: &'static str,
        /// What stands there.
        text: String,
    },
    /// A setting is given a second time, or a second tool before the first has a row; keep one.
    #[error("line {line}: {field} was given before: keep one of the two")]
    Repeated {
        /// Number of the line, from 1.
        line: usize,
        /// Name of the setting.
        field: &'static str,
    },
    /// The tool cannot be made; choose another radius.
    #[error("line {line}: {source}")]
    Tool {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with it.
        source: ToolError,
    },
    /// No tool is called that; choose one that hangs on the wall.
    #[error(
        "line {line}: there is no tool {name:?}: choose rib, blade, knuckle or loop, the number of a tool brought along \
         (from 4), or tool_radius_mm for a sphere"
    )]
    Shape {
        /// Number of the line, from 1.
        line: usize,
        /// What stands there.
        name: String,
    },
    /// The wheel cannot turn that fast; choose a lower speed.
    #[error("line {line}: the wheel cannot turn at {rpm} rpm: choose from -{max_rpm} to {max_rpm}")]
    WheelSpeed {
        /// Number of the line, from 1.
        line: usize,
        /// The speed asked for.
        rpm: f32,
        /// Largest speed either way.
        max_rpm: f32,
    },
    /// A row cannot follow those before it.
    #[error("line {line}: {source}")]
    Sample {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong with it.
        source: SampleError,
    },
}

impl Stroke {
    /// Turning speed of the wheel when a file names none.
    pub const WHEEL_SPEED: Rpm = Rpm(30.0);

    const fn empty(wheel_speed: Rpm) -> Self {
        Self { wheel_speed, samples: Vec::new() }
    }

    /// Reads a stroke from text.
    ///
    /// # Errors
    /// A [`StrokeError`] naming the first line that cannot be used and what to do about it.
    pub fn parse(text: &str) -> Result<Self, StrokeError> {
        format::parse(text)
    }

    /// Reads a stroke from a file.
    ///
    /// # Errors
    /// [`StrokeError::File`] when the file cannot be read, else as [`Stroke::parse`].
    pub fn read(path: impl AsRef<Path>) -> Result<Self, StrokeError> {
        let path = path.as_ref();
        let text = fs::read_to_string(path).map_err(|source| StrokeError::File { path: path.to_owned(), source })?;
        Self::parse(&text)
    }

    /// Centre of the tool at a time, m in the room's frame; straight between two samples.
    ///
    /// Nothing before the first and after the last sample, and nothing while the tool is lifted.
    #[must_use]
    pub fn at(&self, seconds: f64) -> Option<Vec3> {
        let (before, after, share) = self.around(seconds)?;
        Some(before.centre_m.lerp(after.centre_m, share))
    }

    /// How the tool is turned at a time, each angle the short way between two samples; as it hangs when there is none.
    #[must_use]
    pub fn orientation_at(&self, seconds: f64) -> Orientation {
        self.around(seconds).map_or_else(Orientation::default, |(before, after, share)| {
            before.orientation.towards(after.orientation, share)
        })
    }

    /// The samples before and after a time, and the share of the way between them.
    fn around(&self, seconds: f64) -> Option<(&Sample, &Sample, f32)> {
        let later = self.samples.partition_point(|sample| sample.time_s <= seconds);
        let before = self.samples.get(later.checked_sub(1)?)?;
        if before.time_s == seconds {
            return Some((before, before, 0.0));
        }
        let after = self.samples.get(later).filter(|after| !after.after_lift)?;
        let share = (seconds - before.time_s) / (after.time_s - before.time_s);
        Some((before, after, share as f32))
    }

    /// Time of the first sample, s.
    #[must_use]
    pub fn start(&self) -> f64 {
        self.samples.first().map_or(0.0, |first| first.time_s)
    }

    /// Time of the last sample, s.
    #[must_use]
    pub fn end(&self) -> f64 {
        self.samples.last().map_or(0.0, |last| last.time_s)
    }

    /// Seconds from the first sample to the last.
    #[must_use]
    pub fn duration(&self) -> f64 {
        self.end() - self.start()
    }

    /// The tool in the hand at a time: the last one taken up, and before the first sample the first.
    #[must_use]
    pub fn tool_at(&self, seconds: f64) -> Tool {
        let later = self.samples.partition_point(|sample| sample.time_s <= seconds);
        self.samples.get(later.saturating_sub(1)).map_or_else(Tool::default, |sample| sample.tool)
    }

    /// Every tool that is taken up, in the order of time.
    pub fn tools(&self) -> impl Iterator<Item = Tool> {
        self.samples.chunk_by(|one, other| one.tool == other.tool).map(|held| held[0].tool)
    }

    /// The same path with one tool throughout, its centre farther from the axis by `by_m` of the tool that it stands in for,
    /// or nearer, but not beyond the axis.
    ///
    /// # Errors
    /// [`SampleError`] when a sample would then be out of bounds.
    pub fn with_tool(&self, tool: Tool, by_m: impl Fn(Tool) -> f32) -> Result<Self, SampleError> {
        let mut stroke = Self::empty(self.wheel_speed);
        for sample in &self.samples {
            let out = sample.centre_m.with_z(0.0);
            let centre_m = sample.centre_m + out.normalize_or_zero() * by_m(sample.tool).max(-out.length());
            stroke.push(Sample { centre_m, tool, ..*sample })?;
        }
        Ok(stroke)
    }

    /// Turning speed of the wheel it was made on.
    #[must_use]
    pub const fn wheel_speed(&self) -> Rpm {
        self.wheel_speed
    }

    /// Takes in the next sample once it keeps every bound; one tool is lifted before another is taken up.
    fn push(&mut self, mut sample: Sample) -> Result<(), SampleError> {
        let time_s = sample.time_s;
        sample.after_lift |= self.samples.last().is_some_and(|before| before.tool != sample.tool);
        if !(0.0..=TIME_MAX_S).contains(&time_s) {
            return Err(SampleError::Time { time_s, max_s: TIME_MAX_S });
        }
        let distance_m = f64::from(sample.centre_m.length());
        if distance_m.is_nan() || distance_m > DISTANCE_MAX_M {
            return Err(SampleError::TooFar { distance_mm: distance_m * 1e3, max_mm: DISTANCE_MAX_M * 1e3 });
        }
        if let Some(before) = self.samples.last() {
            if time_s <= before.time_s {
                return Err(SampleError::NotLater { time_s, before_s: before.time_s });
            }
            let way_m = f64::from(sample.centre_m.distance(before.centre_m));
            let speed_m_s = way_m / (time_s - before.time_s);
            if !sample.after_lift && speed_m_s > SPEED_MAX_M_S {
                return Err(SampleError::TooFast { speed_m_s, max_m_s: SPEED_MAX_M_S });
            }
        }
        self.samples.push(sample);
        Ok(())
    }
}
