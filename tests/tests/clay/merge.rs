//! Presses of one sub-step: their order, their number and who makes them cannot be felt in the clay, and no tool, however
//! misplaced, brings a radius out of its bounds.
//!
//! Everything is compared bit for bit: a tolerance here would be a difference between server and client.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::f32::consts::{PI, TAU};

use glam::Vec3;
use pottery_shared::clay::{Contact, Footprint, GridShape, Method, MethodKind, Pot, PotSpec, Press, SubStep, Window};
use pottery_shared::tool::{Shape, Side, Sphere, Tool, rack};
use pottery_shared::units::Metres;
use proptest::prelude::*;

const RADIUS_MM: f32 = 60.0;
const METHODS: [MethodKind; 3] = [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic];

/// The default pot on a grid coarse enough to be pressed thousands of times.
fn pot() -> Pot {
    Pot::new(PotSpec { shape: GridShape::new(90, 100).unwrap(), ..PotSpec::default() }).unwrap()
}

fn sphere(radius_mm: f32) -> Sphere {
    Sphere::new(Metres::from_mm(radius_mm)).unwrap()
}

/// A sphere pressed `depth_mm` into the untouched wall.
fn press(radius_mm: f32, depth_mm: f32, angle_rad: f32, z_mm: f32, response: f32) -> Press {
    let distance_mm = RADIUS_MM + radius_mm - depth_mm;
    let centre_mm = Vec3::new(distance_mm * angle_rad.cos(), distance_mm * angle_rad.sin(), z_mm);
    Press { turning: 1, response, ..Press::held(sphere(radius_mm), centre_mm * 1e-3) }
}

/// A press within reach of every other one of the same `angle_rad` and `z_mm`.
fn press_near(angle_rad: f32, z_mm: f32) -> impl Strategy<Value = Press> {
    (5.0_f32..25.0, 0.5_f32..6.0, -0.08_f32..0.08, -5.0_f32..5.0, 0.01_f32..1.0).prop_map(
        move |(radius_mm, depth_mm, aside_rad, above_mm, response)| {
            press(radius_mm, depth_mm, angle_rad + aside_rad, z_mm + above_mm, response)
        },
    )
}

/// Two to five presses at one place, which is anywhere on the pot, the seam included.
fn overlapping() -> impl Strategy<Value = Vec<Press>> {
    let place = (prop_oneof![-PI..PI, Just(0.0), Just(PI)], 0.0_f32..200.0);
    place.prop_flat_map(|(angle_rad, z_mm)| prop::collection::vec(press_near(angle_rad, z_mm), 2..=5))
}

/// Any window of the default grid's, the empty ones and those over the seam included.
fn any_window() -> impl Strategy<Value = Window> {
    let shape = pot().spec().shape;
    (0..shape.columns(), 0..shape.rows()).prop_flat_map(move |(first_column, first_row)| {
        (0..=shape.columns(), 0..=shape.rows() - first_row).prop_map(move |(columns, rows)| Window {
            first_column,
            columns,
            first_row,
            rows,
        })
    })
}

/// The pot after three sub-steps of the same presses, and the contacts of the last.
fn pressed(presses: &[Press], method: MethodKind) -> (Pot, Vec<Contact>) {
    let mut pot = pot();
    let mut substep = SubStep::for_grid(pot.spec().shape);
    let mut contacts = Vec::new();
    for _ in 0..3 {
        contacts = substep.advance(&mut pot, presses, method, |_, _| {}).to_vec();
    }
    (pot, contacts)
}

/// Calls `visit` with every order of the numbers below `count` (Heap's algorithm).
fn every_order(count: usize, visit: &mut impl FnMut(&[usize])) {
    fn permute(fixed: usize, order: &mut [usize], visit: &mut impl FnMut(&[usize])) {
        if fixed <= 1 {
            return visit(order);
        }
        for at in 0..fixed {
            permute(fixed - 1, order, visit);
            let other = if fixed.is_multiple_of(2) { at } else { 0 };
            order.swap(other, fixed - 1);
        }
    }
    let mut order: Vec<_> = (0..count).collect();
    permute(count, &mut order, visit);
}

fn assert_within_bounds(pot: &Pot, what: &str) {
    let surface = &pot.surfaces()[0];
    let (low, high) = surface.bounds_m();
    for (at, radius) in surface.radii_m().iter().enumerate() {
        // false for what is not a number as well
        assert!((low..=high).contains(radius), "{what}: element {at} has radius {radius} m");
    }
}

#[test]
fn every_order_is_visited_once() {
    let mut orders = BTreeSet::new();
    let mut visits = 0;
    every_order(5, &mut |order| {
        orders.insert(order.to_vec());
        visits += 1;
    });
    assert_eq!((orders.len(), visits), (120, 120));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn order_of_presses_cannot_be_felt_in_the_clay(presses in overlapping()) {
        for method in METHODS {
            let (expected, contacts) = pressed(&presses, method);
            prop_assert!(expected != pot(), "nothing was pressed");
            every_order(presses.len(), &mut |order| {
                let reordered: Vec<_> = order.iter().map(|&number| presses[number]).collect();
                let (found, found_contacts) = pressed(&reordered, method);
                assert!(found.digest() == expected.digest() && found == expected, "{method:?}, order {order:?}");
                for (&number, contact) in order.iter().zip(found_contacts) {
                    assert_eq!(contact, contacts[number], "{method:?}, order {order:?}, press {number}");
                }
            });
        }
    }
}

/// Any tool of the rack, or a sphere, held near a place outside or inside, on its way from somewhere or not.
fn any_press() -> impl Strategy<Value = Press> {
    let place = (prop_oneof![-PI..PI, Just(0.0), Just(PI)], 0.0_f32..200.0);
    let near = place.prop_flat_map(|(angle_rad, z_mm)| press_near(angle_rad, z_mm));
    let shapes = rack::standard().len() as u8;
    let way = prop_oneof![Just(None), (-0.5_f32..0.5, -0.5_f32..0.5).prop_map(Some)];
    (near, 0..=shapes, any::<bool>(), way).prop_map(move |(press, shape, is_inside, way)| {
        let tool = if shape == shapes { press.tool } else { Tool::Convex(Shape(shape)) };
        let side = if is_inside { Side::Inside } else { Side::Outside };
        // into the wall from its other side
        let centre_m = if is_inside { press.centre_m * Vec3::new(0.7, 0.7, 1.0) } else { press.centre_m };
        let from_m = way.map(|(aside_mm, up_mm)| centre_m + Vec3::new(aside_mm, 0.0, up_mm) * 1e-3);
        Press { tool, side, centre_m, from_m, ..press }
    })
}

proptest! {
    /// Of columns that are whole eights and of others.
    #[test]
    fn only_press_moves_clay_as_it_does_beside_itself_and_is_felt_as_it_presses(
        press in any_press(),
        rows in prop_oneof![Just(96), Just(100)],
    ) {
        let shape = GridShape::new(90, rows).unwrap();
        for method in METHODS {
            let [mut alone, mut twice] = [(); 2].map(|()| Pot::new(PotSpec { shape, ..PotSpec::default() }).unwrap());
            let [mut one, mut other] = [(); 2].map(|()| SubStep::for_grid(shape));
            for _ in 0..3 {
                let felt = one.feel(&alone, &press, method);
                let [mut windows, mut other_windows] = [const { Vec::new() }; 2];
                let contact = one.advance(&mut alone, &[press], method, |_, window| windows.push(window))[0];
                let contacts = other.advance(&mut twice, &[press; 2], method, |_, window| other_windows.push(window));
                prop_assert_eq!(contacts, [contact; 2], "{:?}", method);
                // what presses in parts is told of the last of them, which may find nothing where those before have left none
                let is_last_none = press.from_m.is_some() && contact.elements == 0 && windows.len() == 1;
                let is_in_parts = windows.len() > 1 || (is_last_none && one.feel(&alone, &press, method).elements == 0);
                prop_assert!(is_in_parts || felt == contact, "{method:?}: {felt:?} felt, {contact:?} pressed");
                windows.dedup();
                other_windows.dedup();
                prop_assert_eq!(windows, other_windows, "{:?}", method);
                prop_assert!(alone == twice, "{method:?}");
            }
        }
    }
}

proptest! {
    #[test]
    fn press_made_twice_is_felt_once(presses in overlapping(), again in prop::collection::vec(0_usize..5, 1..4)) {
        for method in METHODS {
            let mut more = presses.clone();
            more.extend(again.iter().map(|number| presses[number % presses.len()]));
            prop_assert!(pressed(&more, method).0 == pressed(&presses, method).0, "{method:?}");
        }
    }

    #[test]
    fn single_press_made_twice_is_felt_once(press in press_near(0.0, 100.0)) {
        for method in METHODS {
            let (alone, contacts) = pressed(&[press], method);
            let (twice, contacts_twice) = pressed(&[press, press], method);
            prop_assert!(alone == twice, "{method:?}");
            prop_assert_eq!(contacts_twice, [contacts[0]; 2]);
        }
    }

    #[test]
    fn presses_far_apart_do_not_know_of_each_other(
        near in press_near(0.0, 100.0),
        // a tool of 25 mm with its propagation reaches less than 0.9 rad to either side
        far in (1.9_f32..TAU - 1.9).prop_flat_map(|angle_rad| press_near(angle_rad, 100.0)),
    ) {
        for method in METHODS {
            let mut apart = pot();
            let mut substep = SubStep::for_grid(apart.spec().shape);
            for _ in 0..3 {
                for press in [near, far] {
                    substep.advance(&mut apart, &[press], method, |_, _| {});
                }
            }
            prop_assert!(pressed(&[near, far], method).0 == apart, "{method:?}");
        }
    }

    #[test]
    fn merged_clay_moves_by_the_strongest_pushes_of_the_presses_alone(presses in overlapping()) {
        for method in METHODS {
            let mut together = pot();
            let mut substep = SubStep::for_grid(together.spec().shape);
            let before = together.surfaces()[0].radii_m().to_vec();
            let (low_m, high_m) = together.surfaces()[0].bounds_m();
            // what each asks for by itself, asked of the method and not of the sub-step
            let (mut inward_m, mut outward_m) = (vec![0.0_f32; before.len()], vec![0.0_f32; before.len()]);
            let rows = together.spec().shape.rows() as usize;
            for press in &presses {
                let mut footprint = Footprint::for_grid(together.spec().shape);
                method.press(&together, press, &mut footprint);
                let window = footprint.window();
                for (local, column) in (0..).zip(window.grid_columns(together.spec().shape)) {
                    let (span, deltas_m) = footprint.span(local);
                    for (row, &delta_m) in span.zip(deltas_m) {
                        let at = column as usize * rows + window.first_row as usize + row;
                        inward_m[at] = inward_m[at].min(delta_m);
                        outward_m[at] = outward_m[at].max(delta_m);
                    }
                }
            }
            substep.advance(&mut together, &presses, method, |_, _| {});
            for (at, &found_m) in together.surfaces()[0].radii_m().iter().enumerate() {
                let expected_m = (before[at] + (inward_m[at] + outward_m[at])).clamp(low_m, high_m);
                prop_assert_eq!(found_m.to_bits(), expected_m.to_bits(), "{:?}, element {}", method, at);
            }
        }
    }

    #[test]
    fn windows_meet_where_they_share_an_element(one in any_window(), other in any_window()) {
        let shape = pot().spec().shape;
        let elements = |window: Window| -> BTreeSet<(u32, u32)> {
            let rows = window.first_row..window.end_row();
            window.grid_columns(shape).flat_map(|column| rows.clone().map(move |row| (column, row))).collect()
        };
        prop_assert_eq!(one.meets(other, shape), !elements(one).is_disjoint(&elements(other)));
    }

    #[test]
    fn press_beside_one_in_the_air_is_the_press_alone(
        touching in press_near(PI, 20.0),
        angle_rad in -PI..PI,
        air_mm in 0.1_f32..100.0,
    ) {
        let air = press(10.0, -air_mm, angle_rad, 100.0, 1.0);
        for method in METHODS {
            let (alone, contacts) = pressed(&[touching], method);
            for both in [[touching, air], [air, touching]] {
                let (merged, merged_contacts) = pressed(&both, method);
                prop_assert!(merged == alone, "{method:?}");
                prop_assert!(merged_contacts.contains(&contacts[0]) && merged_contacts.contains(&Contact::default()));
            }
        }
    }

    #[test]
    fn whatever_is_pressed_radii_stay_within_bounds(
        presses in prop::collection::vec((prop::array::uniform3(prop::num::f32::ANY), 0.5_f32..40.0), 1..4),
    ) {
        let presses: Vec<_> = presses
            .into_iter()
            .map(|(centre, radius_mm)| Press { turning: -1, response: 1.0, ..Press::held(sphere(radius_mm), Vec3::from_array(centre)) })
            .collect();
        for method in METHODS {
            let (pot, contacts) = pressed(&presses, method);
            assert_within_bounds(&pot, &format!("{method:?}"));
            for contact in contacts {
                prop_assert!(contact.force_n.is_finite() && contact.penetration_m.is_finite(), "{contact:?}");
            }
        }
    }
}

#[test]
fn tool_in_an_odd_place_leaves_the_radii_within_bounds() {
    let small = PotSpec { radius: Metres::from_mm(15.0), wall: Metres::from_mm(1.0), ..*pot().spec() };
    let odd = [
        ("on the axis", [0.0, 0.0, 100.0]),
        ("on the axis at the foot", [0.0, 0.0, 0.0]),
        ("on the axis at the rim", [-0.0, 0.0, 200.0]),
        ("a hair beside the axis", [1e-36, -1e-36, 100.0]),
        ("over the rim", [60.0, 0.0, 210.0]),
        ("under the foot", [0.0, -60.0, -10.0]),
        ("in the wall", [-60.0, 1e-7, 50.0]),
    ];
    for method in METHODS {
        for (place, centre_mm) in odd {
            // the largest tool is bigger than the second pot
            for (spec, radius_mm) in [(*pot().spec(), 12.0), (*pot().spec(), 40.0), (small, 0.5), (small, 40.0)] {
                let what = format!("{method:?}, {place}, radius {radius_mm} mm");
                let mut pot = Pot::new(spec).unwrap();
                let mut substep = SubStep::for_grid(spec.shape);
                let centre_m = Vec3::from_array(centre_mm) * 1e-3;
                let press = Press { turning: 1, response: 1.0, ..Press::held(sphere(radius_mm), centre_m) };
                for _ in 0..20 {
                    let contact = substep.advance(&mut pot, &[press, press], method, |_, _| {})[0];
                    assert!(contact.force_n.is_finite(), "{what}: {contact:?}");
                }
                assert_within_bounds(&pot, &what);
            }
        }
    }
}

#[test]
fn tool_that_is_nowhere_touches_nothing() {
    let nowhere = [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, f32::MAX, f32::MIN, 1e20];
    for method in METHODS {
        for (axis, value) in (0..3).flat_map(|axis| nowhere.map(|value| (axis, value))) {
            let mut press = press(12.0, 3.0, 0.0, 100.0, 1.0);
            press.centre_m[axis] = value;
            let (pressed_pot, contacts) = pressed(&[press], method);
            assert_eq!(contacts, [Contact::default()], "{method:?}: {}", press.centre_m);
            assert!(pressed_pot == pot(), "{method:?}: {}", press.centre_m);
        }
    }
}

#[test]
fn response_that_is_no_number_moves_no_clay() {
    for method in METHODS {
        let (found, _) = pressed(&[press(12.0, 3.0, 0.0, 100.0, f32::NAN)], method);
        assert!(found == pot(), "{method:?}");
    }
}
