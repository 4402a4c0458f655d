//! The mouse's tool on its way to where the pointer asks for it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{Vec2, Vec3};
use pottery_client::device::{Device, Pointer, pointer};
use pottery_shared::tool::Orientation;
use proptest::prelude::*;

/// Where the tool is each millisecond from one place to another.
fn way(from: Vec3, to: Vec3, orientation: Orientation) -> (Vec<Vec3>, Orientation) {
    let (mut asked, mut device) = pointer();
    asked.write(Pointer { target_m: Some(from), ..Pointer::default() });
    let mut places = vec![device.position(0.0).unwrap()];
    asked.write(Pointer { target_m: Some(to), orientation, ..Pointer::default() });
    places.extend((1..3_000).map(|tick| device.position(f64::from(tick) * 1e-3).unwrap()));
    (places, device.orientation())
}

fn place() -> impl Strategy<Value = Vec3> {
    (0.0_f32..0.2, -3.2_f32..3.2, 0.0_f32..0.25)
        .prop_map(|(out_m, angle_rad, z_m)| (Vec2::from_angle(angle_rad) * out_m).extend(z_m))
}

proptest! {
    #[test]
    fn tool_goes_round_a_pot_and_not_through_it(from in place(), to in place(), turn in any::<[i16; 3]>()) {
        let (places, orientation) = way(from, to, Orientation(turn));
        let nearest_m = from.truncate().length().min(to.truncate().length());
        for pair in places.windows(2) {
            prop_assert!(pair[1].truncate().length() > nearest_m - 1e-6, "{} on the way from {from} to {to}", pair[1]);
            // 0.8 m/s, and rounding
            prop_assert!(pair[1].distance(pair[0]) < 0.8e-3 + 1e-6, "{} to {}", pair[0], pair[1]);
        }
        prop_assert!(places.last().unwrap().distance(to) < 1e-5, "{:?} for {to}", places.last());
        prop_assert_eq!(orientation, Orientation(turn));
    }
}

#[test]
fn pointer_that_comes_back_does_not_drag_the_tool_from_where_it_left() {
    let (mut asked, mut device) = pointer();
    let place = |x| Pointer { target_m: Some(Vec3::new(x, 0.0, 0.1)), ..Pointer::default() };
    asked.write(place(0.1));
    assert_eq!(device.position(0.0), place(0.1).target_m);
    asked.write(Pointer::default());
    assert_eq!(device.position(0.01), None);
    asked.write(place(-0.1));
    assert_eq!(device.position(0.02), place(-0.1).target_m);
}
