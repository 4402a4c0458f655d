//! The studio's own method: elastic up to yield, plastic beyond, and the displaced clay returned as a rim.
//!
//! Owns the law of the clay under a tool; the collision is shared with the published methods.
//! Invariant: a tool held still sinks no deeper than where the clay carries it, and no element inside the contact rises.

use glam::Vec3;

use super::contact::{turned, visit_touched};
use super::window::Push;
use super::{Contact, Footprint, Method, Press, Surface, Window};

/// Indentation pressure over yield stress, H = 2.4·σ_y: force over contact area in the finite-element reference at 1 and
/// 2 mm (95 and 96 kPa at σ_y = 40 kPa); Tabor 1951 gives 2.8 for a half-space, and a thin backed layer carries less.
const HARDNESS_OVER_YIELD: f32 = 2.4;
/// Poisson's ratio of wet clay.
const POISSON: f32 = 0.45;
/// Share of the displaced volume that comes back as a rim at once.
const RIM_SHARE: f32 = 0.35;
/// Width of the rim's crest and its outer end, in q² (the squared distance over that of the dent's edge).
const RIM_WIDTH: f32 = 0.8;
const RIM_END: f32 = 5.0;
/// Least share of the sphere's normal along the radius: where it grazes the clay its pressure has no defined place.
const STEEPEST: f32 = 0.2;

/// Elastic-plastic clay with a rim.
///
/// With p the penetration, A an element's area, E* = E/(1 − ν²), a = √(ΣA/π) the contact's radius and t the clay's
/// thickness behind the surface:
/// - springs back: `δ_y = (H/E*)·√(a·t)`, the elastic depth under the pressure H on a layer about as thick as the
///   contact is wide;
/// - yields: `Δr = −(1 − exp(−dt/τ))·(p − δ_y)⁺`;
/// - force: the pressure `H·min(p, δ_y)/δ_y` along the sphere's normal, so that it saturates as clay does;
/// - rim: `+β·ΔV·κ(q²)/(π·a_θ·a_z·I)` for 1 < q² < Q, `κ = (Q − q²)/(1 + ((q² − 1)/w)²)`, U = Q − 1,
///   `I = U·w·atan(U/w) − (w²/2)·ln(1 + U²/w²)`, with the dent's half axes a_θ, a_z from the second moments of the
///   volume ΔV that yields (a paraboloid of half axis a has the variance a²/6). The rest of ΔV goes into the pot as a
///   whole and is not drawn.
///
/// No wall bending: the clay is taken as backed. Fitted to one sphere on one pot; `tests/tests/reference.rs` holds it
/// to the finite-element dents.
#[derive(Clone, Copy, Debug, Default)]
pub struct PlasticCsem;

impl Method for PlasticCsem {
    fn press(&self, surface: &Surface, press: &Press, footprint: &mut Footprint) -> Contact {
        let mut pushes = core::mem::take(&mut footprint.scratch.pushes);
        pushes.clear();
        let element_rad_m = surface.shape().column_angle_rad() * surface.row_height_m();
        let mut area_m2 = 0.0;
        let mut deepest_m = 0.0_f32;
        let hardness_pa = HARDNESS_OVER_YIELD * press.strength.yield_pa;
        let steepest_m = STEEPEST * press.tool.radius().0;
        let angle_rad = visit_touched(surface, press, |touched, to_centre_m| {
            let element_m2 = touched.radius_m * element_rad_m;
            area_m2 += element_m2;
            deepest_m = deepest_m.max(touched.penetration_m);
            pushes.push(Push {
                column: touched.column,
                row: touched.row,
                depth_m: touched.penetration_m,
                area_m2: element_m2,
                arc_m: touched.radius_m * touched.angle_rad,
                above_m: touched.above_m,
                normal: to_centre_m / to_centre_m.x.max(steepest_m),
            });
        });
        if pushes.is_empty() {
            footprint.reset(Window::default());
            footprint.scratch.pushes = pushes;
            return Contact::default();
        }
        let youngs_reduced_pa = press.strength.youngs_pa / (1.0 - POISSON * POISSON);
        let contact_radius_m = libm::sqrtf(area_m2 / core::f32::consts::PI);
        let elastic_m = hardness_pa / youngs_reduced_pa * libm::sqrtf(contact_radius_m * surface.thickness_m());
        let mut carried_m2 = Vec3::ZERO;
        for push in &mut pushes {
            carried_m2 += push.normal * (push.area_m2 * (push.depth_m / elastic_m).min(1.0));
            push.depth_m = press.response * (push.depth_m - elastic_m).max(0.0);
        }
        let elements = pushes.len() as u32;
        write(surface, press, angle_rad, &pushes, footprint);
        footprint.scratch.pushes = pushes;
        Contact { force_n: turned(carried_m2 * hardness_pa, angle_rad), elements, penetration_m: deepest_m }
    }
}

/// The dent that yields in this step, as an ellipse about its own centre.
struct Dent {
    volume_m3: f32,
    arc_m: f32,
    above_m: f32,
    half_arc_m: f32,
    half_height_m: f32,
}

impl Dent {
    fn of(pushes: &[Push], arc_step_m: f32, row_height_m: f32) -> Option<Self> {
        let mut volume_m3 = 0.0;
        let (mut arc, mut above, mut arc2, mut above2) = (0.0, 0.0, 0.0, 0.0);
        for push in pushes {
            let volume = push.depth_m * push.area_m2;
            volume_m3 += volume;
            arc += volume * push.arc_m;
            above += volume * push.above_m;
            arc2 += volume * push.arc_m * push.arc_m;
            above2 += volume * push.above_m * push.above_m;
        }
        if volume_m3 <= 0.0 {
            return None;
        }
        let (arc_m, above_m) = (arc / volume_m3, above / volume_m3);
        // an element is as wide as it is, however few of them yield
        let half = |second: f32, mean: f32, step: f32| {
            libm::sqrtf(6.0 * (second / volume_m3 - mean * mean).max(0.0) + step * step)
        };
        Some(Self {
            volume_m3,
            arc_m,
            above_m,
            half_arc_m: half(arc2, arc_m, arc_step_m),
            half_height_m: half(above2, above_m, row_height_m),
        })
    }
}

/// Lays the footprint over dent and rim, and fills it.
fn write(surface: &Surface, press: &Press, angle_rad: f32, pushes: &[Push], footprint: &mut Footprint) {
    footprint.reset(Window::default());
    let shape = surface.shape();
    let Some(first) = pushes.first() else { return };
    let radius_m = first.area_m2 / (shape.column_angle_rad() * surface.row_height_m());
    let arc_step_m = shape.column_angle_rad() * radius_m;
    let Some(dent) = Dent::of(pushes, arc_step_m, surface.row_height_m()) else { return };
    let end = libm::sqrtf(RIM_END);
    let centre_rad = angle_rad + dent.arc_m / radius_m;
    let centre_z = press.centre_m.z + dent.above_m;
    let half_columns = libm::ceilf(end * dent.half_arc_m / arc_step_m) as u32 + 1;
    let reach_m = end * dent.half_height_m;
    let row = |z_m: f32| libm::floorf(z_m / surface.row_height_m()) as i64;
    let column = libm::roundf(centre_rad / shape.column_angle_rad()) as i64;
    let window = Window::around(shape, column, half_columns, row(centre_z - reach_m), row(centre_z + reach_m) + 1);
    footprint.reset(window);
    let crest_m =
        RIM_SHARE * dent.volume_m3 / (core::f32::consts::PI * dent.half_arc_m * dent.half_height_m * rim_area());
    for (local, column) in window.grid_columns(shape).enumerate() {
        // columns from the dent's centre, the short way round
        let mut away_rad = column as f32 * shape.column_angle_rad() - centre_rad;
        away_rad -= core::f32::consts::TAU * libm::roundf(away_rad / core::f32::consts::TAU);
        let arc = away_rad * radius_m / dent.half_arc_m;
        for (row, delta) in (window.first_row..).zip(footprint.column_mut(local as u32)) {
            let height = (surface.row_z_m(row) - centre_z) / dent.half_height_m;
            let q2 = arc * arc + height * height;
            if q2 > 1.0 && q2 < RIM_END {
                let beyond = (q2 - 1.0) / RIM_WIDTH;
                *delta = crest_m * (RIM_END - q2) / (1.0 + beyond * beyond);
            }
        }
    }
    for push in pushes {
        let inside = push.row.checked_sub(window.first_row).filter(|row| *row < window.rows);
        if let (Some(local), Some(row)) = (window.local_column(shape, push.column), inside) {
            footprint.column_mut(local)[row as usize] = -push.depth_m;
        }
    }
}

/// ∫ κ over 1 < q² < Q, per π·a_θ·a_z.
fn rim_area() -> f32 {
    let (end, width) = (RIM_END - 1.0, RIM_WIDTH);
    end * width * libm::atanf(end / width) - 0.5 * width * width * libm::logf(1.0 + end * end / (width * width))
}
