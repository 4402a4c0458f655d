//! What the person holds: which tool, how large a sphere, and how a tool of facets is turned.
//!
//! Pure: knows no window and no network. The rack is the wheel's.
//! Invariant: angles stay within half a turn either way, and the size within [`TOOL_MM`].

use pottery_shared::tool::{ConvexTool, Orientation, Shape, Sphere, Tool};
use pottery_shared::units::Metres;

/// Smallest and largest sphere that is offered, mm.
pub(crate) const TOOL_MM: (f32, f32) = (2.0, 35.0);
/// Yaw, pitch and roll, by the messages of what people call them, and how far they go either way, degrees.
pub(super) const ANGLES: [(&str, f32); 3] = [("angle-turn", 180.0), ("angle-lean", 90.0), ("angle-roll", 180.0)];
/// How far the lower end of a tool of facets may go below the foot, m.
const BELOW_FOOT_M: f32 = 0.005;
/// How far its lower end may be lifted over the rim, m.
const OVER_RIM_M: f32 = 0.01;

/// A tool in the hand.
#[derive(Clone, Debug)]
pub(crate) struct Holding {
    /// A tool of the rack; none for the sphere.
    pub(crate) shape: Option<Shape>,
    /// Radius of the sphere, mm.
    pub(crate) sphere_mm: f32,
    /// Yaw, pitch and roll of a tool of facets, degrees.
    pub(crate) angles_deg: [f32; 3],
}

impl Default for Holding {
    fn default() -> Self {
        Self { shape: None, sphere_mm: Sphere::default().radius().as_mm(), angles_deg: [0.0; 3] }
    }
}

/// How far a held tool reaches from its centre, m, and where its centre may be.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reach {
    /// Towards the axis, and away from it.
    pub(super) inwards_m: f32,
    pub(super) outwards_m: f32,
    /// The stretch of clay beside it that it must pass, downwards and upwards.
    pub(super) below_m: f32,
    pub(super) above_m: f32,
    /// Its lowest point below the centre.
    pub(super) under_m: f32,
    /// Lowest height of the centre, and the highest above the rim.
    pub(super) lowest_m: f32,
    pub(super) over_rim_m: f32,
}

impl Holding {
    /// The tool; a sphere while the rack lacks what was asked for.
    pub(crate) fn tool(&self, rack: &[ConvexTool]) -> Tool {
        match self.shape.filter(|shape| usize::from(shape.0) < rack.len()) {
            Some(shape) => Tool::Convex(shape),
            None => Sphere::new(Metres::from_mm(self.sphere_mm)).unwrap_or_default().into(),
        }
    }

    /// How it is turned.
    pub(super) fn orientation(&self) -> Orientation {
        Orientation::nearest(self.angles_deg.map(f32::to_radians)).unwrap_or_default()
    }

    /// Takes the next tool of sphere and rack.
    pub(super) fn take_next(&mut self, rack: &[ConvexTool]) {
        let next = self.shape.map_or(0, |shape| shape.0 + 1);
        self.shape = (usize::from(next) < rack.len()).then_some(Shape(next));
    }

    /// Makes the sphere larger or smaller.
    pub(super) fn grow(&mut self, by_mm: f32) {
        if self.shape.is_none() {
            self.sphere_mm = (self.sphere_mm + by_mm).clamp(TOOL_MM.0, TOOL_MM.1);
        }
    }

    /// Turns a tool of facets; angle 0 is the yaw, 1 the pitch, 2 the roll.
    pub(super) fn turn(&mut self, angle: usize, by_deg: f32) {
        if self.shape.is_some() {
            let most_deg = ANGLES[angle].1;
            let turned = self.angles_deg[angle] + by_deg;
            let wrapped = turned - 360.0 * (turned / 360.0).round();
            self.angles_deg[angle] = wrapped.clamp(-most_deg, most_deg);
        }
    }

    /// How far it reaches towards the axis, m.
    pub(crate) fn inwards_m(&self, rack: &[ConvexTool]) -> f32 {
        self.reach(rack).inwards_m
    }

    /// How far it reaches as it is held.
    pub(super) fn reach(&self, rack: &[ConvexTool]) -> Reach {
        match self.tool(rack) {
            Tool::Sphere(sphere) => {
                let radius_m = sphere.radius().0;
                Reach {
                    inwards_m: radius_m,
                    outwards_m: radius_m,
                    below_m: 0.5 * radius_m,
                    above_m: 0.5 * radius_m,
                    under_m: radius_m,
                    lowest_m: -0.5 * radius_m,
                    over_rim_m: 2.0 * radius_m,
                }
            }
            Tool::Convex(shape) => {
                let turn = self.orientation().at(glam::Vec3::X);
                let corners = rack[usize::from(shape.0)].triangles_m().flatten().map(|corner| turn * corner);
                let (low, high) = corners.fold((glam::Vec3::ZERO, glam::Vec3::ZERO), |(low, high), corner| {
                    (low.min(corner), high.max(corner))
                });
                Reach {
                    inwards_m: -low.x,
                    outwards_m: high.x,
                    below_m: -low.z,
                    above_m: high.z,
                    under_m: -low.z,
                    lowest_m: -low.z - BELOW_FOOT_M,
                    over_rim_m: OVER_RIM_M - low.z,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pottery_shared::tool::rack;

    #[test]
    fn every_tool_of_the_rack_comes_round() {
        let (mut holding, rack) = (Holding::default(), rack::standard());
        let mut names = Vec::new();
        for _ in 0..=rack.len() {
            names.push(holding.shape.map_or(Some("sphere"), Shape::name).unwrap_or("no. "));
            holding.take_next(&rack);
        }
        assert_eq!((names.join(" ").as_str(), holding.shape), ("sphere rib blade knuckle loop", None));
    }

    #[test]
    fn a_turned_rib_reaches_as_far_as_it_is_wide_there() {
        let rack = rack::standard();
        let mut holding = Holding { shape: Some(Shape::RIB), ..Holding::default() };
        let upright = holding.reach(&rack);
        // the straight edge is 4·50/3π mm from the centre of volume, less what the bevel takes, and 100 mm long
        assert!((upright.inwards_m - 0.0212).abs() < 5e-4, "{upright:?}");
        assert!((upright.below_m + upright.above_m - 0.1).abs() < 1e-6, "{upright:?}");
        holding.turn(0, 90.0);
        // seen from its flat side it is 4 mm thick
        assert!((holding.reach(&rack).inwards_m - 0.002).abs() < 1e-5);
        for _ in 0..3 {
            holding.turn(0, 90.0);
        }
        assert!(holding.angles_deg[0].abs() < 1e-3, "{:?}", holding.angles_deg);
    }
}
