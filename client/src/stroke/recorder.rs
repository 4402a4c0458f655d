//! Recording of a stroke: samples in, stroke file out.
//!
//! Holds no clock; the caller says when each sample was.
//! Invariant: once a sample has been taken, what is written can be read again, and gives the same path to 1 µm and 1 µs with the same
//! tools.

use std::io;

use glam::Vec3;
use pottery_shared::clay::Wheel;
use pottery_shared::tool::{Orientation, Tool};
use pottery_shared::units::Rpm;

use super::{Sample, SampleError, Stroke, format};

/// A stroke that grows sample by sample.
///
/// ```
/// use glam::Vec3;
/// use pottery_client::stroke::{Stroke, StrokeRecorder};
/// use pottery_shared::tool::{Orientation, Tool};
/// use pottery_shared::units::Rpm;
///
/// let upright = Orientation::default();
/// let mut recorder = StrokeRecorder::new(Tool::default(), Rpm(20.0));
/// recorder.push(0.00, Vec3::new(0.080, 0.0, 0.1), upright)?;
/// recorder.push(0.01, Vec3::new(0.079, 0.0, 0.1), upright)?;
/// recorder.lift();
/// recorder.push(2.00, Vec3::new(0.080, 0.0, 0.1), upright)?;
/// let mut file = Vec::new();
/// recorder.write_to(&mut file)?;
/// let stroke = Stroke::parse(&String::from_utf8(file)?)?;
/// assert_eq!(stroke.at(1.0), None);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct StrokeRecorder {
    stroke: Stroke,
    tool: Tool,
    lifted: bool,
}

impl StrokeRecorder {
    /// Starts a stroke with `tool` on a wheel that turns at `wheel_speed`, limited as the wheel itself limits it.
    #[must_use]
    pub fn new(tool: Tool, wheel_speed: Rpm) -> Self {
        let max = Wheel::RPM_MAX.0;
        let rpm = if wheel_speed.0.is_nan() { 0.0 } else { wheel_speed.0.clamp(-max, max) };
        Self { stroke: Stroke::empty(Rpm(rpm)), tool, lifted: false }
    }

    /// Goes on with a stroke that there is, after a lift.
    #[must_use]
    pub fn going_on(stroke: Stroke) -> Self {
        let tool = stroke.tool_at(stroke.end());
        Self { stroke, tool, lifted: true }
    }

    /// What was recorded so far.
    #[must_use]
    pub const fn stroke(&self) -> &Stroke {
        &self.stroke
    }

    /// Appends where the tool's centre was, m in the room's frame, and how it was turned, `time_s` seconds after the
    /// recording began.
    ///
    /// # Errors
    /// [`SampleError`] when the file could not hold the sample; the recording stays as it was. After
    /// [`SampleError::TooFast`], [`StrokeRecorder::lift`] and the same sample again bridge the jump.
    pub fn push(&mut self, time_s: f64, centre_m: Vec3, orientation: Orientation) -> Result<(), SampleError> {
        let after_lift = self.lifted && !self.stroke.samples.is_empty();
        self.stroke.push(format::rounded(Sample { time_s, tool: self.tool, centre_m, orientation, after_lift }))?;
        self.lifted = false;
        Ok(())
    }

    /// Notes which tool is in the hand from the next sample on; another than before is a lift as well.
    pub const fn hold(&mut self, tool: Tool) {
        self.tool = tool;
    }

    /// Notes that the tool is away until the next sample.
    pub const fn lift(&mut self) {
        self.lifted = true;
    }

    /// Whether nothing has been recorded yet.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.stroke.samples.is_empty()
    }

    /// Writes the recording as a stroke file; before the first sample that is a header without rows.
    ///
    /// # Errors
    /// Whatever `out` answers.
    pub fn write_to(&self, mut out: impl io::Write) -> io::Result<()> {
        format::write(&self.stroke, &mut out)
    }
}
