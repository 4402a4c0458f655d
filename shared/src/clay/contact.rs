//! Collision of a sphere with the circular sector elements, and the contact force of the original CSEM.
//!
//! Shared by both published methods, which differ only in what they do with the result.
//! Invariant: only the elements that the sphere can reach are visited.

use glam::Vec3;

use super::{Contact, Footprint, Press, Surface, Window};

/// The original gives its constants for a pot of 50 units height; forces scale with penetration in those units.
const UNITS_PER_HEIGHT: f32 = 50.0;
/// Point-contact stiffness over all elements, N a unit: k_p = 504 / N with N the number of elements of the model.
const POINT_STIFFNESS: f32 = 504.0;
/// Line-contact stiffness, N a unit of the largest penetration.
const LINE_STIFFNESS: f32 = 0.6;
/// Drag of the turning clay, N a unit of the largest penetration.
const ROTATION_STIFFNESS: f32 = 0.35;

/// Where the tool stands in the pot's cylindrical coordinates.
struct Reach {
    axis_distance_m: f32,
    angle_rad: f32,
    window: Window,
}

/// The elements a sphere can touch: rows |z − H_z| ≤ R and columns |θ − φ| ≤ asin(R/d), all columns once it holds
/// the axis. (The original used R/d, which leaves out grazed columns when the tool is near the axis.)
///
/// None when the tool stands at no finite distance: comparisons with NaN would let every element pass.
fn reach(surface: &Surface, press: &Press) -> Reach {
    let shape = surface.shape();
    let centre = press.centre_m;
    let radius = press.tool.radius().0;
    let axis_distance_m = libm::sqrtf(centre.x * centre.x + centre.y * centre.y);
    let angle_rad = libm::atan2f(centre.y, centre.x);
    let first_row = libm::ceilf((centre.z - radius) / surface.row_height_m());
    let last_row = libm::floorf((centre.z + radius) / surface.row_height_m());
    let column = libm::roundf(angle_rad / shape.column_angle_rad());
    let half_columns = if axis_distance_m > radius {
        libm::ceilf(libm::asinf(radius / axis_distance_m) / shape.column_angle_rad()) as u32
    } else {
        shape.columns()
    };
    let window = if axis_distance_m.is_finite() && centre.z.is_finite() {
        Window::around(shape, column as i64, half_columns, first_row as i64, last_row as i64)
    } else {
        Window::default()
    };
    Reach { axis_distance_m, angle_rad, window }
}

/// Finds the touched elements, writes `−response · p` for each and returns the original CSEM's force.
///
/// With the tool (radius R) at (d, φ, H_z) and an element (r, θ, z), Δθ = θ − φ:
/// `b = d·cosΔθ`, `c = d² − R² + (H_z − z)²`, `s₁,₂ = b ∓ √(b² − c)`, penetration `p = r − s₁`.
/// Point contact (d > r): `F = Σ k_p·p·unit(H − P₁)`. Line contact (d ≤ r): `F = 0.6·max(R − |H − (P₁+P₂)/2|)` along
/// `Σ(2H − P₁ − P₂)`. A turning wheel adds `0.35·max p` along its tangent. Lee, Han and Choi 2008, as
/// reconstructed; which of the two contacts holds is decided element by element.
///
/// The footprint is laid over the touched window grown by `margin` columns and rows; empty when nothing is touched.
pub(super) fn touch(surface: &Surface, press: &Press, margin: (u32, u32), footprint: &mut Footprint) -> Contact {
    let shape = surface.shape();
    let reach = reach(surface, press);
    let grown = reach.window.grown(shape, margin.0, margin.1);
    footprint.reset(grown);
    let radius = press.tool.radius().0;
    let row_height_m = surface.row_height_m();
    let (distance, tool_z) = (reach.axis_distance_m, press.centre_m.z);
    let mut sums = Sums::default();
    for column in reach.window.grid_columns(shape) {
        let delta_angle = column as f32 * shape.column_angle_rad() - reach.angle_rad;
        let (sin, cos) = libm::sincosf(delta_angle);
        let (along, aside) = (distance * cos, distance * sin);
        let reach_squared = radius * radius - aside * aside;
        if reach_squared <= 0.0 {
            continue;
        }
        let radii = &surface.column_m(column)[reach.window.first_row as usize..][..reach.window.rows as usize];
        let Some(local) = grown.local_column(shape, column) else {
            continue;
        };
        let first = (reach.window.first_row - grown.first_row) as usize;
        let deltas = &mut footprint.column_mut(local)[first..][..radii.len()];
        for (row, (&element_r, delta)) in radii.iter().zip(deltas).enumerate() {
            let below = (reach.window.first_row + row as u32) as f32 * row_height_m - tool_z;
            let discriminant = reach_squared - below * below;
            if discriminant <= 0.0 {
                continue;
            }
            // r ≤ s₁ without the root: the sphere lies outside of the element
            let beyond = along - element_r;
            if beyond >= 0.0 && beyond * beyond >= discriminant {
                continue;
            }
            let half_chord = libm::sqrtf(discriminant);
            let near = (along - half_chord).max(0.0);
            let penetration = element_r - near;
            if penetration <= 0.0 || along + half_chord <= 0.0 {
                continue;
            }
            *delta = -press.response * penetration;
            sums.elements += 1;
            sums.deepest = sums.deepest.max(penetration);
            if distance > element_r {
                let out = Vec3::new(distance - near * cos, -near * sin, -below);
                sums.point += out * (penetration / radius);
            } else {
                let out = Vec3::new(distance - along * cos, -along * sin, -below);
                sums.line += out;
                sums.line_deepest = sums.line_deepest.max(radius - out.length());
            }
        }
    }
    if sums.elements == 0 {
        footprint.reset(Window::default());
        return Contact::default();
    }
    sums.contact(surface, press, reach.angle_rad)
}

/// What is gathered over the touched elements, in the frame whose x axis points from the pot's axis to the tool.
#[derive(Default)]
struct Sums {
    elements: u32,
    deepest: f32,
    point: Vec3,
    line: Vec3,
    line_deepest: f32,
}

impl Sums {
    fn contact(&self, surface: &Surface, press: &Press, angle_rad: f32) -> Contact {
        let units = UNITS_PER_HEIGHT / surface.height_m();
        let point = self.point * (POINT_STIFFNESS * units / surface.shape().elements() as f32);
        let line = self.line.normalize_or_zero() * (LINE_STIFFNESS * units * self.line_deepest);
        let drag = ROTATION_STIFFNESS * units * self.deepest * f32::from(press.turning);
        let (sin, cos) = libm::sincosf(angle_rad);
        let local = point + line + Vec3::new(0.0, drag, 0.0);
        Contact {
            force_n: Vec3::new(local.x * cos - local.y * sin, local.x * sin + local.y * cos, local.z),
            elements: self.elements,
            penetration_m: self.deepest,
        }
    }
}
