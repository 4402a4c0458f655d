//! The stroke file's text: settings, header, rows, an empty line where the tool was lifted, its name where another is taken.
//!
//! Owns the only place that knows the layout of a line.
//! Invariant: what [`write()`] writes, [`parse`] reads back as the same samples.

use std::io;

use glam::Vec3;
use pottery_shared::clay::Wheel;
use pottery_shared::tool::{Orientation, Shape, Sphere, Tool};
use pottery_shared::units::{Metres, Rpm};

use super::{Sample, Stroke, StrokeError};

/// The last three are left out where nothing turns.
const COLUMNS: [&str; 7] = ["t_s", "x_mm", "y_mm", "z_mm", "yaw_deg", "pitch_deg", "roll_deg"];
const COLUMNS_UPRIGHT: usize = 4;
const TOOL: &str = "tool";
const TOOL_RADIUS: &str = "tool_radius_mm";
const WHEEL_SPEED: &str = "wheel_rpm";

/// Reads a stroke; spreadsheets' byte-order mark, line ends and spaces round a field are no offence.
pub(super) fn parse(text: &str) -> Result<Stroke, StrokeError> {
    let mut settings = Settings::default();
    let mut columns = None;
    let mut after_lift = false;
    let mut stroke = Stroke::empty(Stroke::WHEEL_SPEED);
    let mut tool = Tool::default();
    for (line, content) in (1..).zip(text.trim_start_matches('\u{feff}').lines()) {
        let content = content.trim();
        if let Some(comment) = content.strip_prefix('#') {
            settings.take(line, comment)?;
        } else if content.is_empty() {
            // before the first row nothing is held that could be lifted
            after_lift = !stroke.samples.is_empty();
        } else if let Some(columns) = columns {
            tool = settings.tool.take().unwrap_or(tool);
            let sample = Sample { tool, after_lift, ..row(line, content, columns)? };
            stroke.push(sample).map_err(|source| StrokeError::Sample { line, source })?;
            after_lift = false;
        } else {
            let is_header = |columns: &usize| content.split(',').map(str::trim).eq(COLUMNS[..*columns].iter().copied());
            columns = [COLUMNS_UPRIGHT, COLUMNS.len()].into_iter().find(is_header);
            if columns.is_none() {
                return Err(StrokeError::Header { line, found: content.to_owned() });
            }
        }
    }
    if stroke.samples.is_empty() {
        return Err(StrokeError::Empty);
    }
    stroke.wheel_speed = settings.wheel_speed.unwrap_or(stroke.wheel_speed);
    Ok(stroke)
}

/// What the comments say about tool and wheel.
#[derive(Default)]
struct Settings {
    /// That of the rows to come, until the first of them.
    tool: Option<Tool>,
    wheel_speed: Option<Rpm>,
}

impl Settings {
    fn take(&mut self, line: usize, comment: &str) -> Result<(), StrokeError> {
        let Some((name, value)) = comment.split_once(':') else { return Ok(()) };
        match name.trim() {
            TOOL_RADIUS => {
                let radius = Metres::from_mm(number(line, TOOL_RADIUS, value)? as f32);
                let tool = Sphere::new(radius).map_err(|source| StrokeError::Tool { line, source })?;
                set_once(&mut self.tool, tool.into(), line, TOOL_RADIUS)
            }
            TOOL => {
                let name = value.trim();
                let shape = Shape::named(name).or_else(|| name.parse().ok().map(Shape));
                let shape = shape.ok_or_else(|| StrokeError::Shape { line, name: name.to_owned() })?;
                set_once(&mut self.tool, Tool::Convex(shape), line, TOOL)
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

fn row(line: usize, content: &str, columns: usize) -> Result<Sample, StrokeError> {
    let mut values = [0.0; COLUMNS.len()];
    let found = content.split(',').count();
    if found != columns {
        return Err(StrokeError::Columns { line, found, expected: columns });
    }
    for ((value, field), text) in values.iter_mut().zip(COLUMNS).zip(content.split(',')) {
        *value = number(line, field, text)?;
    }
    let [time_s, x_mm, y_mm, z_mm, angles_deg @ ..] = values;
    // whole turns more say nothing
    let angles_rad = angles_deg.map(|degrees| (degrees % 360.0).to_radians() as f32);
    Ok(Sample {
        time_s,
        tool: Tool::default(),
        centre_m: Vec3::from_array([x_mm, y_mm, z_mm].map(|length_mm| (length_mm * 1e-3) as f32)),
        orientation: Orientation::nearest(angles_rad).unwrap_or_default(),
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
    let mut tool = stroke.tool_at(stroke.start());
    write_tool(tool, out)?;
    writeln!(out, "# {WHEEL_SPEED}: {:.3}", stroke.wheel_speed.0)?;
    let turns = stroke.samples.iter().any(|sample| sample.orientation != Orientation::default());
    let columns = if turns { COLUMNS.len() } else { COLUMNS_UPRIGHT };
    writeln!(out, "{}", COLUMNS[..columns].join(","))?;
    for sample in &stroke.samples {
        if sample.after_lift {
            writeln!(out)?;
        }
        if sample.tool != tool {
            tool = sample.tool;
            write_tool(tool, out)?;
        }
        let [x, y, z] = sample.centre_m.to_array().map(|length_m| f64::from(length_m) * 1e3);
        write!(out, "{:.6},{x:.3},{y:.3},{z:.3}", sample.time_s)?;
        if turns {
            // a step is 0.0055°, so that three decimals keep it
            let [yaw, pitch, roll] = sample.orientation.angles_rad().map(f32::to_degrees);
            write!(out, ",{yaw:.3},{pitch:.3},{roll:.3}")?;
        }
        writeln!(out)?;
    }
    out.flush()
}

fn write_tool(tool: Tool, out: &mut impl io::Write) -> io::Result<()> {
    match tool {
        Tool::Sphere(sphere) => writeln!(out, "# {TOOL_RADIUS}: {:.3}", sphere.radius().as_mm()),
        Tool::Convex(shape) => match shape.name() {
            Some(name) => writeln!(out, "# {TOOL}: {name}"),
            None => writeln!(out, "# {TOOL}: {}", shape.0),
        },
    }
}
