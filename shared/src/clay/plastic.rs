//! The studio's own method: elastic up to yield, plastic beyond, and the displaced clay returned as a rim.
//!
//! Owns the law of the clay under a tool; the collision is shared with the published methods.
//! Invariant: a tool held still sinks no deeper than where the clay carries it, and no element inside the contact rises.

use core::f32::consts::{PI, TAU};

use glam::Vec3;
use wide::f32x8;

use super::contact::{Contacts, LANES, sum};
use super::window::Scratch;
use super::{Contact, Footprint, Method, Press, Sink, Surface, Window};
use crate::tool::Side;

/// Poisson's ratio of wet clay.
const POISSON: f32 = 0.45;
/// Least part of the tool's radius that counts as half chord: where a sphere grazes clay, its slope has no end.
const STEEPEST: f32 = 0.2;

/// Least slope that the law has been seen with: a flat of one element has none.
const SLOPE_MIN: f32 = 0.02;
/// Pressure at which clay begins to flow under a blunt tool, over its yield stress: 1.1, Johnson 1985.
const HARDNESS_MIN: f32 = 1.1;

/// The constants of the law, all without unit.
///
/// Fitted to finite-element dents of a backed wall by `accuracy-chart fit`: spheres of 8, 12 and 20 mm, 1 to 4 mm deep, pots of
/// 40 and 60 mm, walls of 5 to 12 mm, E/σ_y from 25 to 125.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlasticLaw {
    /// Indentation pressure over yield stress at E*/σ_y = 60 and a slope of ½; Tabor 1951 has 2.8 for a half-space.
    pub hardness: f32,
    /// Its rise with ln(E*/σ_y) and with the logarithm of the slope at the contact's edge, as in Johnson's model of an
    /// expanding cavity (1970), where both are ⅔.
    pub hardness_by_stiffness: f32,
    /// See `hardness_by_stiffness`.
    pub hardness_by_slope: f32,
    /// Elastic depth over that of an even pressure on a layer.
    pub recovery: f32,
    /// Strain over yield strain at which 1 − 1/e of the displaced volume has come back as a rim.
    pub rim_strain: f32,
    /// Width w of the rim's crest, in q².
    pub rim_width: f32,
    /// Outer end Q of the rim, in q².
    pub rim_end: f32,
}

impl PlasticLaw {
    /// What `accuracy-chart fit` found.
    pub const FITTED: Self = Self {
        hardness: 2.295,
        hardness_by_stiffness: 0.355,
        hardness_by_slope: 0.109,
        recovery: 1.101,
        rim_strain: 136.4,
        rim_width: 0.530,
        rim_end: 7.87,
    };
}

impl Default for PlasticLaw {
    fn default() -> Self {
        Self::FITTED
    }
}

/// Elastic-plastic clay with a rim.
///
/// With p the penetration, A the area of an element, a = √(a_θ·a_z) the radius of the contact, whose half axes follow from
/// its second moments, s the tool's slope at its edge (a/R for a sphere), t the clay's thickness behind the surface,
/// E* = E/(1 − ν²) and X = s·E*/σ_y the strain over the yield strain:
/// - pressure: `H = σ_y·(h + h₁·ln(E*/(60·σ_y)) + h₂·ln(2s))`;
/// - springs back: `e(q²) = c·e₀·(1 − 0.35·q² − 0.14·q⁶)`, `e₀ = (H/E*)·2a/(1 + 0.62·a/t + 0.38·(a/t)²)`, the elastic depth under
///   an even pressure on a layer that slides on a rigid base ([`Sink`] tells it outside of the contact too);
/// - yields: `Δr = −(1 − exp(−dt/τ))·(p − e)⁺`;
/// - force: the pressure `H·min(p/e, 1)` along the tool's normal, so that it saturates as clay does. While nothing yields it
///   is within 2 % of Hertz's `4/3·E*·√R·δ^1.5`;
/// - rim: `+β·ΔV·κ(q²)/(π·a_θ·a_z·I)` for 1 < q² < Q, `κ = (Q − q²)/(1 + ((q² − 1)/w)²)`, U = Q − 1,
///   `I = U·w·atan(U/w) − (w²/2)·ln(1 + U²/w²)`, with the half axes a_θ, a_z of the volume ΔV that yields (a paraboloid of half
///   axis a has the variance a²/6). Of a dent of volume V, `1 − exp(−X/X₀)` has come back in the end; since V grows with X⁴, it
///   is `β = 1 − exp(−X/X₀)·(1 − X/(4·X₀))` of what yields now. The rest is booked to the pot's height.
///
/// No wall bending: the clay is taken as backed. `tests/tests/reference.rs` holds it to the finite-element dents.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlasticCsem {
    /// Its constants.
    pub law: PlasticLaw,
}

impl Method for PlasticCsem {
    fn press(&self, surface: &Surface, press: &Press, footprint: &mut Footprint) -> Contact {
        let mut scratch = core::mem::take(&mut footprint.scratch);
        let contact = self.press_with(surface, press, footprint, &mut scratch);
        footprint.scratch = scratch;
        contact
    }

    fn keeps_volume(&self) -> bool {
        true
    }
}

impl PlasticCsem {
    fn press_with(
        &self,
        surface: &Surface,
        press: &Press,
        footprint: &mut Footprint,
        scratch: &mut Scratch,
    ) -> Contact {
        let behind_m = match press.side {
            Side::Outside => 0.0,
            Side::Inside => surface.thickness_m(),
        };
        scratch.contacts.gather(surface, press, behind_m);
        footprint.reset(Window::default());
        if scratch.contacts.elements == 0 {
            return Contact::default();
        }
        let step = Step::of(surface);
        let (spot, slope) = Ellipse::of_contact(&scratch.contacts, &step, STEEPEST * press.tool.radius().0);
        let youngs_reduced_pa = press.strength.youngs_pa / (1.0 - POISSON * POISSON);
        let stiffness = youngs_reduced_pa / press.strength.yield_pa;
        let hardness_pa = press.strength.yield_pa * self.hardness(stiffness, slope);
        let elastic_m = self.law.recovery * hardness_pa / youngs_reduced_pa
            * layer_depth_m(libm::sqrtf(spot.half_arc_m * spot.half_height_m), surface.thickness_m());
        let (carried, carrying, dent) = yields(press, &spot, elastic_m, scratch);
        if let Some(dent) = Ellipse::of_dent(&dent, &step) {
            let share = self.rim_share(stiffness * slope);
            self.write(surface, press, &dent, share, &step, scratch, footprint);
        }
        let contacts = &scratch.contacts;
        Contact {
            force_n: carried * (hardness_pa * step.element_rad_m),
            elements: contacts.elements,
            penetration_m: contacts.deepest_m,
            sink: Some(Sink {
                angle_rad: contacts.angle_rad + spot.arc_m / spot.radius_m,
                z_m: press.centre_m.z + spot.above_m,
                radius_m: spot.radius_m,
                half_arc_m: spot.half_arc_m,
                half_height_m: spot.half_height_m,
                depth_m: elastic_m * carrying * step.element_rad_m / spot.volume_m3,
            }),
        }
    }

    /// H/σ_y for E*/σ_y and the tool's slope at the edge of the contact.
    fn hardness(&self, stiffness: f32, slope: f32) -> f32 {
        let law = &self.law;
        let hardness = law.hardness
            + law.hardness_by_stiffness * libm::logf(stiffness / 60.0)
            + law.hardness_by_slope * libm::logf(2.0 * slope.max(SLOPE_MIN));
        hardness.max(HARDNESS_MIN)
    }

    /// Share of what yields now that comes back as a rim.
    fn rim_share(&self, strain: f32) -> f32 {
        let part = strain / self.law.rim_strain;
        (1.0 - libm::expf(-part) * (1.0 - 0.25 * part)).clamp(0.0, 1.0)
    }

    /// Lays the footprint over dent and rim, and fills it.
    fn write(
        &self,
        surface: &Surface,
        press: &Press,
        dent: &Ellipse,
        share: f32,
        step: &Step,
        scratch: &mut Scratch,
        footprint: &mut Footprint,
    ) {
        let shape = surface.shape();
        let end = libm::sqrtf(self.law.rim_end);
        let radius_m = dent.radius_m;
        let centre_rad = scratch.contacts.angle_rad + dent.arc_m / radius_m;
        let centre_z = press.centre_m.z + dent.above_m;
        let reach_m = end * dent.half_height_m;
        let row = |z_m: f32| libm::floorf(z_m / step.row_m) as i64;
        let column = libm::roundf(centre_rad / step.column_rad) as i64;
        let (mut first_row, mut last_row) = (row(centre_z - reach_m), row(centre_z + reach_m) + 1);
        let mut reach_rad = end * dent.half_arc_m / radius_m;
        for chunk in &scratch.contacts.chunks {
            first_row = first_row.min(i64::from(chunk.row));
            last_row = last_row.max(i64::from(chunk.row) + LANES as i64 - 1);
            reach_rad = reach_rad.max((chunk.angle_rad - dent.arc_m / radius_m).abs());
        }
        let half_columns = libm::ceilf(reach_rad / step.column_rad) as u32 + 1;
        let window = Window::around(shape, column, half_columns, first_row, last_row).aligned(shape, LANES as u32);
        footprint.reset(window);
        let crest_m = share * dent.volume_m3 / (PI * dent.half_arc_m * dent.half_height_m * self.rim_area());
        let outwards = match press.side {
            Side::Outside => 1.0,
            Side::Inside => -1.0,
        };
        self.fill_squares(window, surface, centre_z, dent.half_height_m, &mut scratch.row_squares);
        for (local, column) in window.grid_columns(shape).enumerate() {
            let away_rad = column as f32 * step.column_rad - centre_rad;
            // the short way round
            let arc = (away_rad - TAU * libm::roundf(away_rad / TAU)) * radius_m / dent.half_arc_m;
            let rest = self.law.rim_end - arc * arc;
            if rest > 0.0 {
                let reach_m = libm::sqrtf(rest) * dent.half_height_m;
                let chunk = |z_m: f32| ((z_m / step.row_m) as u32).saturating_sub(window.first_row) as usize / LANES;
                let from = chunk(centre_z - reach_m);
                let to = (chunk(centre_z + reach_m) + 1).min(scratch.row_squares.len());
                let column = &mut footprint.column_mut(local as u32)[from * LANES..];
                self.raise(crest_m * outwards, arc * arc, &scratch.row_squares[from..to], column);
            }
        }
        for (chunk, &push) in scratch.contacts.chunks.iter().zip(&scratch.pushes_m) {
            footprint.write(shape, chunk, push * -outwards);
        }
    }

    fn fill_squares(
        &self,
        window: Window,
        surface: &Surface,
        centre_z: f32,
        half_height_m: f32,
        squares: &mut alloc::vec::Vec<f32x8>,
    ) {
        squares.clear();
        let lanes = f32x8::new([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        for row in (window.first_row..window.end_row()).step_by(LANES) {
            let above = ((f32x8::splat(row as f32) + lanes) * surface.row_height_m() - centre_z) / half_height_m;
            squares.push(above * above);
        }
    }

    /// Adds one column of the rim: `κ = (Q − q²)/(1 + ((q² − 1)/w)²)` times the crest for 1 < q² < Q.
    fn raise(&self, crest_m: f32, arc_squared: f32, row_squares: &[f32x8], column: &mut [f32]) {
        let end = f32x8::splat(self.law.rim_end);
        let width = 1.0 / self.law.rim_width;
        let raised = |row_squared: f32x8| {
            let q2 = row_squared + arc_squared;
            let beyond = (q2 - 1.0) * width;
            let rim = q2.simd_gt(f32x8::ONE) & q2.simd_lt(end);
            ((end - q2) * crest_m / (beyond * beyond + 1.0)) & rim
        };
        let (column, last) = column.as_chunks_mut::<LANES>();
        for (lanes, &row_squared) in column.iter_mut().zip(row_squares) {
            *lanes = raised(row_squared).to_array();
        }
        if let Some(&row_squared) = row_squares.get(column.len()) {
            last.copy_from_slice(&raised(row_squared).to_array()[..last.len()]);
        }
    }

    /// ∫ κ over 1 < q² < Q, per π·a_θ·a_z.
    fn rim_area(&self) -> f32 {
        let (end, width) = (self.law.rim_end - 1.0, self.law.rim_width);
        end * width * libm::atanf(end / width) - 0.5 * width * width * libm::logf(1.0 + end * end / (width * width))
    }
}

/// Sizes of an element.
struct Step {
    column_rad: f32,
    row_m: f32,
    /// Area of an element over its radius, m.
    element_rad_m: f32,
}

impl Step {
    fn of(surface: &Surface) -> Self {
        let (column_rad, row_m) = (surface.shape().column_angle_rad(), surface.row_height_m());
        Self { column_rad, row_m, element_rad_m: column_rad * row_m }
    }
}

/// An ellipse on the clay, along its arc and its height.
struct Ellipse {
    /// What is spread over it: of a contact its area, m², of a dent its volume, m³.
    volume_m3: f32,
    /// Mean radius of the clay there, m.
    radius_m: f32,
    /// Its centre from the tool's, m.
    arc_m: f32,
    above_m: f32,
    half_arc_m: f32,
    half_height_m: f32,
}

/// Sums over elements of a weight, and of it times place and square of the place.
#[derive(Default)]
struct Moments {
    all: f32x8,
    radius: f32x8,
    arc: f32x8,
    above: f32x8,
    arc2: f32x8,
    above2: f32x8,
}

impl Moments {
    fn add(&mut self, weight: f32x8, radius: f32x8, arc: f32x8, above: f32x8) {
        self.all += weight;
        self.radius += weight * radius;
        let (by_arc, by_height) = (weight * arc, weight * above);
        self.arc += by_arc;
        self.above += by_height;
        self.arc2 += by_arc * arc;
        self.above2 += by_height * above;
    }

    /// `spread` is the square of the half axis over the variance: 4 for an even ellipse, 6 for a paraboloid.
    fn ellipse(&self, spread: f32, step: &Step) -> Option<Ellipse> {
        let all = sum(self.all);
        if all <= 0.0 {
            return None;
        }
        let [radius, arc, above, arc2, above2] =
            [self.radius, self.arc, self.above, self.arc2, self.above2].map(|lanes| sum(lanes) / all);
        // an element is as wide as it is, however few of them there are
        let half = |second: f32, mean: f32, step: f32| {
            libm::sqrtf(spread * ((second - mean * mean).max(0.0) + step * step / 6.0))
        };
        Some(Ellipse {
            volume_m3: all * step.element_rad_m,
            radius_m: radius,
            arc_m: arc,
            above_m: above,
            half_arc_m: half(arc2, arc, step.column_rad * radius),
            half_height_m: half(above2, above, step.row_m),
        })
    }
}

impl Ellipse {
    /// The contact, and the tool's slope at its edge: `√(2·mean slope²)`, which is a/R for a sphere.
    fn of_contact(contacts: &Contacts, step: &Step, steepest_m: f32) -> (Self, f32) {
        let mut moments = Moments::default();
        let mut slopes = f32x8::ZERO;
        for chunk in &contacts.chunks {
            let touched = chunk.touched();
            let weight = chunk.radius_m & touched;
            let above = chunk.above_m & touched;
            let half_chord = chunk.half_chord_m.fast_max(f32x8::splat(steepest_m));
            slopes += weight * (above * above + chunk.aside_m * chunk.aside_m) / (half_chord * half_chord);
            moments.add(weight, chunk.radius_m, chunk.radius_m * chunk.angle_rad, above);
        }
        let slope = libm::sqrtf(2.0 * sum(slopes) / sum(moments.all));
        (moments.ellipse(4.0, step).expect("a contact has touched elements"), slope)
    }

    fn of_dent(moments: &Moments, step: &Step) -> Option<Self> {
        moments.ellipse(6.0, step)
    }
}

/// Elastic depth under the middle of an even pressure p on a disc of radius a, over p/E*, on a layer of thickness t that
/// slides on a rigid base, m.
///
/// `2a/(1 + 0.62·a/t + 0.38·(a/t)²)`: within 2 % of the integral `2a·∫ J₁(ka)/k·(cosh 2kt − 1)/(sinh 2kt + 2kt) dk` for a/t
/// up to 1.3; for a thick layer it is Boussinesq's 2a.
fn layer_depth_m(radius_m: f32, thickness_m: f32) -> f32 {
    let ratio = radius_m / thickness_m;
    2.0 * radius_m / (1.0 + ratio * (0.62 + 0.38 * ratio))
}

/// Splits what a tool presses into what springs back and what yields, which goes to `scratch.pushes_m`.
///
/// Returns the sum of share·area·normal over the elements, over the area of an element at radius 1, and the moments of
/// the volume that yields.
fn yields(press: &Press, spot: &Ellipse, elastic_m: f32, scratch: &mut Scratch) -> (Vec3, f32, Moments) {
    let mut dent = Moments::default();
    let [mut x, mut y, mut z, mut all] = [f32x8::ZERO; 4];
    let steepest = f32x8::splat(STEEPEST * press.tool.radius().0);
    let outwards = match press.side {
        Side::Outside => 1.0,
        Side::Inside => -1.0,
    };
    scratch.pushes_m.clear();
    for chunk in &scratch.contacts.chunks {
        let touched = chunk.touched();
        let above = chunk.above_m & touched;
        let arc = chunk.radius_m * chunk.angle_rad;
        let elastic = recovery(spot, arc, above) * elastic_m;
        let push = (chunk.penetration_m - elastic).fast_max(f32x8::ZERO) * press.response;
        let carried = (chunk.penetration_m / elastic).fast_min(f32x8::ONE) * chunk.radius_m;
        all += carried;
        let slope = carried / chunk.half_chord_m.fast_max(steepest);
        let (radial, aside) = (carried * outwards, slope * chunk.aside_m);
        x += radial * chunk.cos - aside * chunk.sin;
        y += radial * chunk.sin + aside * chunk.cos;
        z -= slope * above;
        dent.add(push * chunk.radius_m, chunk.radius_m, arc, above);
        scratch.pushes_m.push(push);
    }
    (Vec3::new(sum(x), sum(y), sum(z)), sum(all), dent)
}

/// Elastic depth at a place of the contact over that in its middle.
fn recovery(spot: &Ellipse, arc: f32x8, above: f32x8) -> f32x8 {
    let (across, up) =
        ((arc - spot.arc_m) * (1.0 / spot.half_arc_m), (above - spot.above_m) * (1.0 / spot.half_height_m));
    let q2 = (across * across + up * up).fast_min(f32x8::ONE);
    f32x8::ONE - q2 * (q2 * q2 * 0.14 + 0.35)
}
