//! Ellipses on the clay: a contact or a dent as its second moments have it.
//!
//! Knows no law of the clay; sums run lane by lane in one order everywhere.
//! Invariant: an ellipse is no smaller than an element.

use super::Surface;
use super::lanes::{Simd, f32x8, root, splat, sum};

/// Sizes of an element.
#[derive(Clone, Copy, Debug)]
pub(super) struct Step {
    /// Angle between columns, rad, and height between rows, m.
    pub(super) column_rad: f32,
    pub(super) row_m: f32,
    /// Area of an element over its radius, m.
    pub(super) element_rad_m: f32,
}

impl Step {
    pub(super) fn of(surface: &Surface) -> Self {
        Self::new(surface.shape().column_angle_rad(), surface.row_height_m())
    }

    pub(super) const fn new(column_rad: f32, row_m: f32) -> Self {
        Self { column_rad, row_m, element_rad_m: column_rad * row_m }
    }
}

/// An ellipse on the clay, along its arc and its height.
#[derive(Clone, Copy, Debug)]
pub(super) struct Ellipse {
    /// What is spread over it: of a contact its area, m², of a dent its volume, m³, negative when it goes towards the axis.
    pub(super) content: f32,
    /// Mean radius of the clay there, m.
    pub(super) radius_m: f32,
    /// Its centre from the tool's, m.
    pub(super) arc_m: f32,
    pub(super) above_m: f32,
    /// Its half axes, m.
    pub(super) half_arc_m: f32,
    pub(super) half_height_m: f32,
}

/// Sums over elements of a weight, and of it times place and square of the place.
///
/// Within a column the arc is the radius times one angle, which is brought in where the column ends.
pub(super) struct Moments<S: Simd> {
    all: f32x8<S>,
    radius: f32x8<S>,
    arc: f32x8<S>,
    above: f32x8<S>,
    arc2: f32x8<S>,
    above2: f32x8<S>,
    /// Of the column at hand: times radius and its square.
    column_radius: f32x8<S>,
    column_radius2: f32x8<S>,
}

impl<S: Simd> Moments<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        let zero = splat(simd, 0.0);
        Self {
            all: zero,
            radius: zero,
            arc: zero,
            above: zero,
            arc2: zero,
            above2: zero,
            column_radius: zero,
            column_radius2: zero,
        }
    }

    /// Adds elements of a column by weight, radius and height.
    #[inline(always)]
    pub(super) fn add(&mut self, weight: f32x8<S>, radius: f32x8<S>, above: f32x8<S>) {
        self.all += weight;
        let (by_radius, by_height) = (weight * radius, weight * above);
        self.column_radius += by_radius;
        self.column_radius2 += by_radius * radius;
        self.above += by_height;
        self.above2 += by_height * above;
    }

    /// Ends a column at an angle from the tool, rad.
    #[inline(always)]
    pub(super) fn end_column(&mut self, angle_rad: f32) {
        let (radius, radius2) = (self.column_radius, self.column_radius2);
        self.radius += radius;
        self.arc += radius * angle_rad;
        self.arc2 += radius2 * (angle_rad * angle_rad);
        let zero = splat(self.all.simd, 0.0);
        (self.column_radius, self.column_radius2) = (zero, zero);
    }

    /// The ellipse with these moments; `None` when nothing weighs.
    ///
    /// `spread` is the square of the half axis over the variance: 4 for an even ellipse, 6 for a paraboloid.
    #[inline(always)]
    pub(super) fn ellipse(&self, spread: f32, step: &Step) -> Option<Ellipse> {
        let all = sum(self.all);
        if all == 0.0 {
            return None;
        }
        let [radius, arc, above, arc2, above2] =
            [self.radius, self.arc, self.above, self.arc2, self.above2].map(|lanes| sum(lanes) / all);
        // an element is as wide as it is, however few of them there are
        let half =
            |second: f32, mean: f32, step: f32| root(spread * ((second - mean * mean).max(0.0) + step * step / 6.0));
        Some(Ellipse {
            content: all * step.element_rad_m,
            radius_m: radius,
            arc_m: arc,
            above_m: above,
            half_arc_m: half(arc2, arc, step.column_rad * radius),
            half_height_m: half(above2, above, step.row_m),
        })
    }
}

impl Ellipse {
    /// Its area over that of another.
    pub(super) fn area_over(&self, other: &Self) -> f32 {
        self.half_arc_m * self.half_height_m / (other.half_arc_m * other.half_height_m)
    }

    /// The same content over an area no larger than that of another.
    pub(super) fn within(self, other: &Self) -> Self {
        let shorter = root((1.0 / self.area_over(other)).min(1.0));
        Self { half_arc_m: self.half_arc_m * shorter, half_height_m: self.half_height_m * shorter, ..self }
    }

    /// Radius of the circle of the same area, m.
    pub(super) fn mean_half_m(&self) -> f32 {
        root(self.half_arc_m * self.half_height_m)
    }
}
