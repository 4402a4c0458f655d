//! Collision of a sphere with the circular sector elements, and the contact force of the original CSEM.
//!
//! The collision is shared by all methods, the force by both published ones.
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

/// An element that the tool presses, seen from the pot's axis with the tool at angle zero.
pub(super) struct Touched {
    /// Its column and row in the grid.
    pub(super) column: u32,
    pub(super) row: u32,
    /// Angle Δθ from the tool to the element, rad, with its sine and cosine.
    pub(super) angle_rad: f32,
    sin: f32,
    cos: f32,
    /// Height above the tool's centre, m.
    pub(super) above_m: f32,
    /// Radius of the element, m.
    pub(super) radius_m: f32,
    /// s₁, the radius at which the tool's near side meets the element's ray, and the ray's middle within the tool, m.
    near_m: f32,
    middle_m: f32,
    /// r − s₁, m, positive.
    pub(super) penetration_m: f32,
}

impl Touched {
    /// From the point of the tool's surface that presses the element to the tool's centre, m: length R.
    fn to_centre_m(&self, axis_distance_m: f32) -> Vec3 {
        Vec3::new(axis_distance_m - self.near_m * self.cos, -self.near_m * self.sin, -self.above_m)
    }
}

/// Tells `visit` of every element that the tool presses, column by column.
///
/// With the tool (radius R) at (d, φ, H_z) and an element (r, θ, z), Δθ = θ − φ:
/// `b = d·cosΔθ`, `c = d² − R² + (H_z − z)²`, `s₁,₂ = b ∓ √(b² − c)`, penetration `p = r − s₁`.
fn for_each_touched(surface: &Surface, press: &Press, reach: &Reach, mut visit: impl FnMut(&Touched)) {
    let shape = surface.shape();
    let radius = press.tool.radius().0;
    let row_height_m = surface.row_height_m();
    let (distance, tool_z) = (reach.axis_distance_m, press.centre_m.z);
    let first_row = reach.window.first_row;
    for column in reach.window.grid_columns(shape) {
        let angle_rad = nearest_turn(column as f32 * shape.column_angle_rad() - reach.angle_rad);
        let (sin, cos) = libm::sincosf(angle_rad);
        let (middle_m, aside) = (distance * cos, distance * sin);
        let reach_squared = radius * radius - aside * aside;
        if reach_squared <= 0.0 {
            continue;
        }
        let radii = &surface.column_m(column)[first_row as usize..][..reach.window.rows as usize];
        for (row, &radius_m) in (first_row..).zip(radii) {
            let above_m = row as f32 * row_height_m - tool_z;
            let discriminant = reach_squared - above_m * above_m;
            if discriminant <= 0.0 {
                continue;
            }
            // r ≤ s₁ without the root: the sphere lies outside of the element
            let beyond = middle_m - radius_m;
            if beyond >= 0.0 && beyond * beyond >= discriminant {
                continue;
            }
            let half_chord = libm::sqrtf(discriminant);
            let near_m = (middle_m - half_chord).max(0.0);
            let penetration_m = radius_m - near_m;
            if penetration_m <= 0.0 || middle_m + half_chord <= 0.0 {
                continue;
            }
            visit(&Touched { column, row, angle_rad, sin, cos, above_m, radius_m, near_m, middle_m, penetration_m });
        }
    }
}

/// The same angle within half a turn of zero.
fn nearest_turn(angle_rad: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    match angle_rad {
        beyond if beyond > PI => beyond - TAU,
        before if before < -PI => before + TAU,
        within => within,
    }
}

/// Finds the touched elements, writes `−response · p` for each and returns the original CSEM's force.
///
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
    let mut sums = Sums::default();
    for_each_touched(surface, press, &reach, |touched| {
        let Some(local) = grown.local_column(shape, touched.column) else { return };
        let penetration = touched.penetration_m;
        footprint.column_mut(local)[(touched.row - grown.first_row) as usize] = -press.response * penetration;
        sums.elements += 1;
        sums.deepest = sums.deepest.max(penetration);
        if reach.axis_distance_m > touched.radius_m {
            sums.point += touched.to_centre_m(reach.axis_distance_m) * (penetration / radius);
        } else {
            let middle = Touched { near_m: touched.middle_m, ..*touched };
            let out = middle.to_centre_m(reach.axis_distance_m);
            sums.line += out;
            sums.line_deepest = sums.line_deepest.max(radius - out.length());
        }
    });
    if sums.elements == 0 {
        footprint.reset(Window::default());
        return Contact::default();
    }
    sums.contact(surface, press, reach.angle_rad)
}

/// Tells `visit` of every element that the tool presses and of the way from it to the tool's centre, m, both with the
/// tool at angle zero; returns the tool's angle, rad.
pub(super) fn visit_touched(surface: &Surface, press: &Press, mut visit: impl FnMut(&Touched, Vec3)) -> f32 {
    let reach = reach(surface, press);
    for_each_touched(surface, press, &reach, |touched| visit(touched, touched.to_centre_m(reach.axis_distance_m)));
    reach.angle_rad
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
        Contact {
            force_n: turned(point + line + Vec3::new(0.0, drag, 0.0), angle_rad),
            elements: self.elements,
            penetration_m: self.deepest,
        }
    }
}

/// A vector given with the tool at angle zero, with the tool at its own angle.
pub(super) fn turned(vector: Vec3, angle_rad: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(angle_rad);
    Vec3::new(vector.x * cos - vector.y * sin, vector.x * sin + vector.y * cos, vector.z)
}
