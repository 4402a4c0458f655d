//! Wide tools inside a hollow pot, which are looked at along few rays before the wall has given way to them.
//!
//! What they meet must not show it: neither in what a hand feels as it goes deeper or as clay turns under it, nor beside a grid that is so coarse
//! that all of its elements are looked at.
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;

use glam::{Quat, Vec2};
use pottery_shared::clay::{Contact, GridShape, MethodKind, Pot, PotSpec, Press, SubStep, Support};
use pottery_shared::tool::{ConvexTool, Shape, Side, Sphere, Tool, rack};
use pottery_shared::units::Metres;
use proptest::prelude::*;

/// Radius of the inner skin, mm.
const INSIDE_MM: f32 = 52.0;

/// A tool inside of a pot that yields to nothing, so that only the wall gives way.
struct Inside {
    pot: Pot,
    substep: SubStep,
    tool: Tool,
}

impl Inside {
    fn ball(radius_mm: f32, shape: GridShape) -> Self {
        Self::with(Tool::Sphere(Sphere::new(Metres::from_mm(radius_mm)).unwrap()), Arc::from([]), shape)
    }

    fn faceted(tool: ConvexTool, shape: GridShape) -> Self {
        Self::with(Tool::Convex(Shape(0)), Arc::from([tool]), shape)
    }

    fn with(tool: Tool, rack: Arc<[ConvexTool]>, shape: GridShape) -> Self {
        let pot = Pot::new(PotSpec { shape, support: Support::Hollow, ..PotSpec::default() }).unwrap();
        Self { pot, substep: SubStep::with_rack(shape, rack), tool }
    }

    /// What is felt, N, and how many elements are touched, with the tool so far from the axis, at an angle and a height.
    fn felt(&mut self, distance_mm: f32, angle_rad: f32, z_mm: f32) -> (f32, u32) {
        let place_mm = (Vec2::from_angle(angle_rad) * distance_mm).extend(z_mm);
        // a rib presses with its straight edge upright, a hair tilted
        let orientation = Quat::from_rotation_z(angle_rad) * Quat::from_xyzw(0.02, 0.03, -0.7, 0.7);
        let press = Press { side: Side::Inside, orientation, response: 0.0, ..Press::held(self.tool, place_mm * 1e-3) };
        let contact = self.substep.advance(&mut self.pot, &[press], MethodKind::Plastic, |_, _| {})[0];
        (contact.force_n.length(), contact.elements)
    }

    /// Distance from the axis at which it first touches, mm.
    fn touches_mm(&mut self) -> f32 {
        let (mut free_mm, mut touching_mm) = (0.0, INSIDE_MM);
        for _ in 0..30 {
            let middle_mm = 0.5 * (free_mm + touching_mm);
            let touched = self.felt(middle_mm, 0.0, 100.0).1;
            if touched == 0 { free_mm = middle_mm } else { touching_mm = middle_mm }
        }
        free_mm
    }
}

#[test]
fn ball_that_fills_the_pot_is_felt_evenly_the_deeper_it_goes() {
    let fine = GridShape::new(720, 800).unwrap();
    // from 4 to 6 mm a twentieth is 0.115 and 0.08 N more of the finite elements' balls of 40 and 30 mm
    for (radius_mm, shape, within_n) in
        [(40.0, GridShape::PAPER, 0.16), (30.0, GridShape::PAPER, 0.13), (40.0, fine, 0.16)]
    {
        let mut inside = Inside::ball(radius_mm, shape);
        let forces_n: Vec<f32> = (40..120)
            .map(|step| inside.felt(INSIDE_MM - radius_mm + 0.05 * step as f32, 0.0004 * step as f32, 100.0).0)
            .collect();
        let steps_n: Vec<f32> = forces_n.windows(2).map(|pair| pair[1] - pair[0]).collect();
        let most_n = steps_n.iter().copied().fold(0.0, f32::max);
        let least_n = steps_n.iter().copied().fold(0.0, f32::min);
        let leap_n = steps_n.windows(2).map(|pair| (pair[1] - pair[0]).abs()).fold(0.0, f32::max);
        println!(
            "{radius_mm} mm: {:.2} to {:.2} N, a twentieth of a millimetre is {least_n:.3} to {most_n:.3} N more, by {leap_n:.3} N from one to the next",
            forces_n[0], forces_n[79]
        );
        assert!(forces_n[79] > 1.5 * forces_n[0]);
        assert!(most_n < within_n && least_n > -0.02 && leap_n < 0.1);
    }
}

#[test]
fn wide_tools_feel_nothing_of_the_clay_that_turns_under_them() {
    let ball = Inside::faceted(rack::ball(3, Metres::from_mm(30.0)).unwrap(), GridShape::PAPER);
    for (mut inside, depth_mm) in
        [(ball, 8.0), (Inside::ball(25.0, GridShape::PAPER), 8.0), (Inside::ball(38.0, GridShape::PAPER), 6.0)]
    {
        let distance_mm = inside.touches_mm() + depth_mm;
        let forces_n: Vec<f32> =
            (0..200).map(|step| inside.felt(distance_mm, 0.0007 * step as f32, 100.0 + 0.01 * step as f32).0).collect();
        let [least_n, most_n] = [f32::min, f32::max].map(|of| forces_n.iter().copied().reduce(of).unwrap());
        println!("{:?}: {least_n:.3} to {most_n:.3} N", inside.tool);
        assert!(most_n - least_n < 0.01 * most_n);
    }
}

#[test]
fn wide_tools_are_felt_as_on_a_grid_whose_elements_are_all_looked_at() {
    // the second has a column less than are worth a ray
    let shapes = [256, 255].map(|columns| GridShape::new(columns, 400).unwrap());
    let tools: [(&str, &dyn Fn(GridShape) -> Inside); 5] = [
        ("25 mm", &|shape| Inside::ball(25.0, shape)),
        ("38 mm", &|shape| Inside::ball(38.0, shape)),
        ("ball of facets", &|shape| Inside::faceted(rack::ball(3, Metres::from_mm(30.0)).unwrap(), shape)),
        ("rib", &|shape| Inside::faceted(rack::rib().unwrap(), shape)),
        ("blade", &|shape| Inside::faceted(rack::blade().unwrap(), shape)),
    ];
    for (name, inside) in tools {
        for depth_mm in [4.0, 8.0] {
            let forces_n = shapes.map(|shape| {
                let mut inside = inside(shape);
                let distance_mm = inside.touches_mm() + depth_mm;
                // over an element, since a flat edge touches more or fewer of them
                (0..40).map(|step| inside.felt(distance_mm, 0.0007 * step as f32, 100.0).0).sum::<f32>() / 40.0
            });
            let error = forces_n[0] / forces_n[1] - 1.0;
            println!("{name}, {depth_mm} mm: {forces_n:.3?} N, {:.2} %", 100.0 * error);
            assert!(error.abs() < 0.01);
        }
    }
}

#[test]
fn what_wide_tools_meet_does_not_depend_on_the_grid_that_there_is_room_for() {
    // a column less than are worth a ray, and room for more
    let shape = GridShape::new(255, 400).unwrap();
    let mut own = Inside::ball(38.0, shape);
    let mut roomy = Inside { substep: SubStep::for_grid(GridShape::PAPER), ..Inside::ball(38.0, shape) };
    for step in 0..40 {
        let at = (INSIDE_MM - 38.0 + 0.15 * step as f32, 0.0007 * step as f32, 100.0);
        let [own, roomy] = [&mut own, &mut roomy].map(|inside| inside.felt(at.0, at.1, at.2));
        assert_eq!(own, roomy, "{at:?}");
    }
}

/// A tool anywhere in a pot or at its wall, now and then where nothing is or beyond foot and rim: a ball, or a rib or blade held in any way.
fn anywhere() -> impl Strategy<Value = Press> {
    let place = (5.0_f32..40.0, -2.0_f32..12.0, -3.2_f32..3.2, -20.0_f32..220.0);
    let held = (0_u8..4, prop::array::uniform4(-1.0_f32..1.0), 0.0_f32..1.0, prop::bool::weighted(0.2));
    (place, held).prop_map(|((radius_mm, depth_mm, angle_rad, z_mm), (which, [x, y, z, w], response, is_outside))| {
        let tool = match which {
            0 | 1 => Tool::Convex(Shape(which)),
            _ => Tool::Sphere(Sphere::new(Metres::from_mm(radius_mm)).unwrap()),
        };
        let (side, distance_mm) = if is_outside {
            (Side::Outside, 60.0 + radius_mm - depth_mm)
        } else {
            (Side::Inside, INSIDE_MM - radius_mm + depth_mm)
        };
        let place_mm = (Vec2::from_angle(angle_rad) * distance_mm).extend(z_mm);
        let orientation = Quat::from_xyzw(x, y, z, w + 1.1);
        Press { side, orientation, response, ..Press::held(tool, place_mm * 1e-3) }
    })
}

/// The pot after four steps of the same presses, of those alone that met something in the first place, and what was met in the last step.
fn pressed(presses: &[Press]) -> ([u64; 2], Vec<Contact>) {
    // as fine as it takes for rays
    let shape = GridShape::new(256, 256).unwrap();
    let rack: Arc<[ConvexTool]> = Arc::from([rack::rib().unwrap(), rack::blade().unwrap()]);
    let [mut all, mut met] = [0, 1]
        .map(|_| Inside::with(Tool::default(), Arc::clone(&rack), shape))
        .map(|inside| (inside.pot, inside.substep));
    let mut contacts = Vec::new();
    for _ in 0..4 {
        contacts = all.1.advance(&mut all.0, presses, MethodKind::Plastic, |_, _| {}).to_vec();
        let those = presses.iter().zip(all.1.met()).filter(|(_, met)| **met);
        let those: Vec<Press> = those.map(|(press, _)| *press).collect();
        met.1.advance(&mut met.0, &those, MethodKind::Plastic, |_, _| {});
    }
    ([all.0.digest(), met.0.digest()], contacts)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(64))]

    #[test]
    fn wide_tools_in_any_order_and_without_those_that_meet_nothing_leave_the_same_pot(
        presses in prop::collection::vec(anywhere(), 1..=3),
    ) {
        let ([digest, met], contacts) = pressed(&presses);
        prop_assert_eq!(digest, met);
        for contact in &contacts {
            let sink = contact.sink.unwrap_or_default();
            let numbers = [contact.force_n.length(), contact.held_n, contact.penetration_m, sink.load_m2, sink.hinge_m];
            prop_assert!(numbers.iter().all(|number| number.is_finite()), "{contact:?}");
        }
        let back: Vec<Press> = presses.iter().rev().copied().collect();
        let ([other, _], found) = pressed(&back);
        prop_assert_eq!(digest, other);
        prop_assert!(contacts.iter().eq(found.iter().rev()));
    }
}
