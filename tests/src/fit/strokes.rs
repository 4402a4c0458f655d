//! A ball drawn along a backed wall, stroke beside stroke, as the finite elements draw it: what a turn of the wheel does.
//!
//! Owns the strokes and what is read of them. The constants of a sliding tool are fitted to them; what a still tool meets is
//! held against them unfitted.
//! Invariant: a stroke has the reference's path and length. The reference's clay knows no rate, so this one gives way while the
//! tool goes 0.6 mm, however fast.

use glam::Vec2;
use pottery_shared::clay::{GridShape, Method};
use pottery_shared::units::Seconds;

use super::FitError;
use crate::chart::cases::{BASE, Scene};
use crate::dent::Pressing;
use crate::reference::{BadProfile, Profile};

/// Length of a stroke, the part of it over which forces are averaged, and where its groove is read, m.
const LENGTH_M: f32 = 0.060;
const STEADY_M: f32 = 0.030;
const READ_AT_M: f64 = 0.033;
/// A step, s, and turns a minute of a pot on which a tool slides wholly.
const STEP: Seconds = Seconds(1e-3);
const RPM: f32 = 48.0;
/// Steps in which the tool comes in, and in which it stands.
const STEPS_IN: u32 = 100;
const STEPS_STILL: u32 = 50;
/// Height of the first stroke on the reference's sector, and on the pot, mm.
const FIRST_AT_MM: f64 = 40.0;
const POT_AT_MM: f64 = 100.0;
/// How far the groove is compared to both sides, mm.
const ASIDE_MM: f64 = 15.0;

/// One stroke of a drawing.
#[derive(Clone, Copy, Debug)]
struct Stroke {
    depth_mm: f32,
    /// How much higher than the first.
    up_mm: f32,
    groove: &'static str,
}

/// Strokes of one ball, one after the other in the same clay.
#[derive(Clone, Copy, Debug)]
struct Drawing {
    name: &'static str,
    tool_mm: f32,
    strokes: &'static [Stroke],
    forces: &'static str,
}

macro_rules! drawing {
    ($name:literal, $tool_mm:literal, $($number:literal: $depth_mm:literal $up_mm:literal),*) => {
        Drawing {
            name: $name,
            tool_mm: $tool_mm,
            strokes: &[$(Stroke {
                depth_mm: $depth_mm,
                up_mm: $up_mm,
                groove: include_str!(concat!("../../data/fem/", $name, "_s", $number, "U_profile.csv")),
            }),*],
            forces: include_str!(concat!("../../data/fem/", $name, "_force.csv")),
        }
    };
}

const DRAWINGS: &[Drawing] = &[
    drawing!("stroke_d1f4", 12.0, 1: 1.0 0.0, 2: 1.0 4.0),
    drawing!("stroke_ball20_d1f4", 20.0, 1: 1.0 0.0, 2: 1.0 4.0),
    drawing!("stroke_d2", 12.0, 1: 2.0 0.0),
    drawing!("stroke_ball20_d2", 20.0, 1: 2.0 0.0),
];

/// Drawings that nothing is fitted to.
const HELD_OUT: &[Drawing] =
    &[drawing!("stroke_ball16_d1f4", 16.0, 1: 1.0 0.0, 2: 1.0 4.0), drawing!("stroke_ball16_d2", 16.0, 1: 2.0 0.0)];

/// What a method makes of a stroke.
#[derive(Clone, Copy, Debug)]
pub struct StrokeFigures {
    /// The drawing, and the number of the stroke in it, from 1.
    pub name: &'static str,
    /// See `name`.
    pub number: usize,
    /// Root mean square of the difference of the grooves over 15 mm to both sides of the tool's path, over its depth.
    pub groove: f64,
    /// Deepest and highest place of the groove, mm: the method's and the reference's.
    pub lowest_mm: [f64; 2],
    /// See `lowest_mm`.
    pub highest_mm: [f64; 2],
    /// Mean force on the tool outwards, and along its motion, N: the method's.
    pub force_n: [f64; 2],
    /// The reference's.
    pub reference_force_n: [f64; 2],
}

/// Draws with a method what is fitted to.
///
/// # Errors
/// [`FitError`] when a file is damaged or the pot cannot be made.
pub fn draw(method: impl Method + Copy, grid: GridShape) -> Result<Vec<StrokeFigures>, FitError> {
    draw_at(RPM, method, grid)
}

/// The same on a pot that turns so many times a minute.
///
/// # Errors
/// [`FitError`] when a file is damaged or the pot cannot be made.
pub fn draw_at(rpm: f32, method: impl Method + Copy, grid: GridShape) -> Result<Vec<StrokeFigures>, FitError> {
    draw_all(DRAWINGS, rpm, method, grid)
}

/// Draws with a method what is held out of every fit.
///
/// # Errors
/// [`FitError`] when a file is damaged or the pot cannot be made.
pub fn draw_held_out(method: impl Method + Copy, grid: GridShape) -> Result<Vec<StrokeFigures>, FitError> {
    draw_all(HELD_OUT, RPM, method, grid)
}

fn draw_all(
    drawings: &[Drawing],
    rpm: f32,
    method: impl Method + Copy,
    grid: GridShape,
) -> Result<Vec<StrokeFigures>, FitError> {
    let way_m = rpm / 60.0 * STEP.0 * std::f32::consts::TAU * BASE.pot_mm[0] * 1e-3;
    let mut figures = Vec::new();
    for drawing in drawings {
        let mut pressing = drawing.untouched(grid)?;
        for (before, stroke) in drawing.strokes.iter().enumerate() {
            let number = before + 1;
            let file = || format!("{}_s{number}U_profile.csv", drawing.name);
            let groove =
                Profile::parse(stroke.groove).map_err(|source| FitError::Reference { file: file(), source })?;
            let force_n = stroke.make(&mut pressing, way_m, method);
            let (groove, [lowest_mm, highest_mm]) = stroke.compare(&pressing, &groove);
            let reference_force_n = drawing.force_n(number)?;
            let name = drawing.name;
            figures.push(StrokeFigures { name, number, groove, lowest_mm, highest_mm, force_n, reference_force_n });
        }
    }
    Ok(figures)
}

impl StrokeFigures {
    /// Weight of the force: a groove may be off by 6 % and a force by 5.
    const FORCE: f64 = 1.2;

    /// Error of the radial force over the reference's; positive is too hard.
    #[must_use]
    pub fn force(&self) -> f64 {
        self.force_n[0] / self.reference_force_n[0] - 1.0
    }

    /// What counts of it in a fit: the worse of both.
    #[must_use]
    pub fn score(&self) -> f64 {
        self.groove.max(Self::FORCE * self.force().abs())
    }
}

impl Drawing {
    fn untouched(&self, grid: GridShape) -> Result<Pressing, FitError> {
        let mut dent = Scene { tool_mm: self.tool_mm, ..BASE }.dent(grid, 1.0, true);
        dent.pot.keeps_volume = false;
        Ok(Pressing::new(dent, STEP)?)
    }

    /// Radial and tangential force of a stroke, from the columns after its number.
    fn force_n(&self, number: usize) -> Result<[f64; 2], FitError> {
        let row = self.forces.lines().nth(number).unwrap_or_default();
        let mut values = row.split(',').skip(1).map_while(|value| value.trim().parse().ok());
        match (values.next(), values.next()) {
            (Some(radial_n), Some(along_n)) => Ok([radial_n, along_n]),
            _ => Err(FitError::Reference {
                file: format!("{}_force.csv", self.name),
                source: BadProfile { line: number + 1 },
            }),
        }
    }
}

impl Stroke {
    /// Comes in at the angle 0, is drawn by about so much a step and leaves; returns the mean force outwards and along, N.
    fn make(&self, pressing: &mut Pressing, way_m: f32, method: impl Method + Copy) -> [f64; 2] {
        let radius_m = BASE.pot_mm[0] * 1e-3;
        let (depth_m, z_m) = (self.depth_mm * 1e-3, (POT_AT_MM as f32 + self.up_mm) * 1e-3);
        pressing.lift();
        for number in 1..=STEPS_IN + STEPS_STILL {
            let share = (number as f32 / STEPS_IN as f32).min(1.0);
            pressing.step_with(method, 0.0, depth_m * share, z_m, 1);
        }
        let steps = (LENGTH_M / way_m).round() as u32;
        let (mut sum, mut count) = ([0.0; 2], 0.0);
        for number in 1..=steps {
            let angle_rad = LENGTH_M / radius_m * number as f32 / steps as f32;
            let radial_n = pressing.step_with(method, angle_rad, depth_m, z_m, 1);
            if number as f32 / steps as f32 * LENGTH_M > LENGTH_M - STEADY_M {
                let along = Vec2::from_angle(angle_rad).perp().extend(0.0);
                sum[0] += f64::from(radial_n);
                sum[1] += f64::from(pressing.contact().force_n.dot(along));
                count += 1.0;
            }
        }
        pressing.lift();
        sum.map(|sum| sum / count)
    }

    /// Root mean square of the difference of the grooves over the depth, and their lowest and highest places, mm.
    ///
    /// They are compared at the points of the reference, which are up to 3 mm apart where the groove is deepest; each
    /// counts for half the way to its neighbours.
    fn compare(&self, pressing: &Pressing, groove: &Profile) -> (f64, [[f64; 2]; 2]) {
        let angle_rad = READ_AT_M / f64::from(BASE.pot_mm[0] * 1e-3);
        let ours_mm = pressing.radial_mm(true);
        let (points, up_mm) = (groove.across_mm(angle_rad), f64::from(self.up_mm));
        let (mut lowest_mm, mut highest_mm, mut sum, mut width) = ([0.0_f64; 2], [0.0_f64; 2], 0.0, 0.0);
        for around in points.windows(3) {
            let [z_mm, theirs_mm] = around[1];
            if (z_mm - FIRST_AT_MM - up_mm).abs() > ASIDE_MM {
                continue;
            }
            let ours_mm = ours_mm(angle_rad, POT_AT_MM + z_mm - FIRST_AT_MM);
            let weight = 0.5 * (around[2][0] - around[0][0]);
            sum += weight * (ours_mm - theirs_mm).powi(2);
            width += weight;
            for (number, value) in [ours_mm, theirs_mm].into_iter().enumerate() {
                lowest_mm[number] = lowest_mm[number].min(value);
                highest_mm[number] = highest_mm[number].max(value);
            }
        }
        ((sum / width).sqrt() / f64::from(self.depth_mm), [lowest_mm, highest_mm])
    }
}
