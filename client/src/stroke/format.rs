//! The stroke file's text: settings, header, rows, and an empty line where the tool was lifted.
//!
//! Owns the only place that knows the layout of a line.
//! Invariant: what [`write()`] writes, [`parse`] reads back as the same samples.

use std::io;

use glam::Vec3;
use pottery_shared::clay::Wheel;
use pottery_shared::tool::Sphere;
use pottery_shared::units::{Metres, Rpm};

use super::{Sample, Stroke, StrokeError};

const COLUMNS: [&str; 4] = ["t_s", "x_mm", "y_mm", "z_mm"];
const TOOL_RADIUS: &str = "tool_radius_mm";
const WHEEL_SPEED: &str = "wheel_rpm";

/// Reads a stroke; spreadsheets' byte-order mark, line ends and spaces round a field are no offence.
pub(super) fn parse(text: &str) -> Result<Stroke, StrokeError> {
    let mut settings = Settings::default();
    let mut header = false;
    let mut after_lift = false;
    let mut stroke = Stroke::empty(Sphere::default(), Stroke::WHEEL_SPEED);
    for (line, content) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let content = content.trim();
        if let Some(comment) = content.strip_prefix('#') {
            settings.take(line, comment)?;
        } else if content.is_empty() {
            // before the first row nothing is held that could be lifted
            after_lift = !stroke.samples.is_empty();
        } else if !header {
            if !content.split(',').map(str::trim).eq(COLUMNS) {
                return Err(StrokeError::Header { line, found: content.to_owned() });
            }
            header = true;
        } else {
            let sample = Sample { after_lift, ..row(line, content)? };
            stroke.push(sample).map_err(|source| StrokeError::Sample { line, source })?;
            after_lift = false;
        }
    }
    if stroke.samples.is_empty() {
        return Err(StrokeError::Empty);
    }
    stroke.tool = settings.tool.unwrap_or(stroke.tool);
    stroke.wheel_speed = settings.wheel_speed.unwrap_or(stroke.wheel_speed);
    Ok(stroke)
}

/// What the comments say about tool and wheel.
#[derive(Default)]
struct Settings {
    tool: Option<Sphere>,
    wheel_speed: Option<Rpm>,
}

impl Settings {
    fn take(&mut self, line: usize, comment: &str) -> Result<(), StrokeError> {
        let Some((name, value)) = comment.split_once(':') else { return Ok(()) };
        match name.trim() {
            TOOL_RADIUS => {
                let radius = Metres::from_mm(number(line, TOOL_RADIUS, value)? as f32);
                let tool = Sphere::new(radius).map_err(|source| StrokeError::Tool { line, source })?;
                set_once(&mut self.tool, tool, line, TOOL_RADIUS)
            }
            WHEEL_SPEED => {
                let rpm = number(line, WHEEL_SPEED, value)? as f32;
                let max_rpm = Wheel::RPM_MAX.0;
                if rpm.abs() > max_rpm {
                    return Err(StrokeError::WheelSpeed { line, rpm, max_rpm });
                }
                set_once(&mut self.wheel_speed, Rpm(rpm), line, WHEEL_SPEED)
            }
            _ => Ok(()),
        }
    }
}

fn set_once<T>(slot: &mut Option<T>, value: T, line: usize, field: &'static str) -> Result<(), StrokeError> {
    match slot.replace(value) {
        None => Ok(()),
        Some(_) => Err(StrokeError::Repeated { line, field }),
    }
}

fn row(line: usize, content: &str) -> Result<Sample, StrokeError> {
    let fields: Vec<&str> = content.split(',').collect();
    let &[time, x, y, z] = fields.as_slice() else {
        return Err(StrokeError::Columns { line, found: fields.len() });
    };
    let length = |field, text| Ok::<_, StrokeError>((number(line, field, text)? * 1e-3) as f32);
    Ok(Sample {
        time_s: number(line, COLUMNS[0], time)?,
        centre_m: Vec3::new(length(COLUMNS[1], x)?, length(COLUMNS[2], y)?, length(COLUMNS[3], z)?),
        after_lift: false,
    })
}

fn number(line: usize, field: &'static str, text: &str) -> Result<f64, StrokeError> {
    let text = text.trim();
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() => Ok(value),
        _ => Err(StrokeError::Number { line, field, text: text.to_owned() }),
    }
}

/// The sample as the file can hold it: whole microseconds and whole micrometres.
pub(super) fn rounded(sample: Sample) -> Sample {
    let micro = |value: f64| (value * 1e6).round() / 1e6;
    let centre_m = sample.centre_m.to_array().map(|length_m| micro(f64::from(length_m)) as f32);
    Sample { time_s: micro(sample.time_s), centre_m: Vec3::from_array(centre_m), ..sample }
}

/// Writes settings, header and rows.
pub(super) fn write(stroke: &Stroke, out: &mut impl io::Write) -> io::Result<()> {
    writeln!(out, "# {TOOL_RADIUS}: {:.3}", stroke.tool.radius().as_mm())?;
    writeln!(out, "# {WHEEL_SPEED}: {:.3}", stroke.wheel_speed.0)?;
    writeln!(out, "{}", COLUMNS.join(","))?;
    for sample in &stroke.samples {
        if sample.after_lift {
            writeln!(out)?;
        }
        let [x, y, z] = sample.centre_m.to_array().map(|length_m| f64::from(length_m) * 1e3);
        writeln!(out, "{:.6},{x:.3},{y:.3},{z:.3}", sample.time_s)?;
    }
    out.flush()
}
