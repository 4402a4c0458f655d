//! The mouse's tool on its way to where the pointer asks for it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{Vec2, Vec3};
use pottery_client::HapticLoop;
use pottery_client::boundary::boundary;
use pottery_client::device::{Device, Pointer, pointer};
use pottery_client::sound::Rub;
use pottery_shared::clay::{Conditions, Material, Phase, Pot, PotSpec, Preset, Schedule, Wheel};
use pottery_shared::haptics::{Coupling, DeviceSpecs};
use pottery_shared::prediction::{Field, Patch};
use pottery_shared::tool::{Orientation, rack};
use pottery_shared::units::{Rpm, Seconds, Tick};
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

/// What a mouse that means to be `depth_m` in clay on a wheel at 60 rpm has after a third of a second: how far the drawn tool stays behind, m, the
/// force, N, and how it rubs.
fn pressed(preset: Preset, depth_m: f32) -> (f32, f32, Rub) {
    let conditions = Conditions {
        wheel: Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0))),
        material: Schedule::new(Material::from_wetness(preset.wetness())),
        ..Conditions::default()
    };
    let field = Field::new(Pot::new(PotSpec::default()).unwrap(), Tick(0));
    let (side, net) = boundary(&Patch { field, conditions, rack: rack::standard() });
    let (mut asked, device) = pointer();
    let mut hand = HapticLoop::new(Box::new(device), side);
    // a sphere of 12 mm touches the wall of 60 mm here
    let place = |depth_m: f32| Vec3::new(0.072 - depth_m, 0.0, 0.1);
    for tick in 1..=600 {
        let meant_m = place(if tick < 300 { -0.005 } else { depth_m });
        asked.write(Pointer { target_m: Some(meant_m), ..Pointer::default() });
        hand.tick(tick);
    }
    let status = net.status();
    (status.tool_m().unwrap().x - place(depth_m).x, status.force_n(), status.rub())
}

#[test]
fn drawn_tool_stays_behind_the_pointer_by_force_over_stiffness_and_tells_hard_clay_from_soft() {
    let stiffness_n_m = Coupling::tuned(&DeviceSpecs::MOUSE, Tick::PERIOD, Seconds(0.0)).stiffness_n_m;
    let all = Preset::ALL.map(|preset| (preset.name(), pressed(preset, 0.002)));
    for (preset, (behind_m, force_n, _)) in all {
        assert!(force_n > 0.05 && force_n < DeviceSpecs::MOUSE.peak_force_n, "{preset}: {force_n} N");
        let lag_m = force_n / stiffness_n_m;
        // places travel in steps of 10 µm, and clay that gives way is on its way still
        assert!((behind_m - lag_m).abs() < 0.05 * lag_m + 2e-5, "{preset}: {behind_m} m behind for {lag_m}");
    }
    for pair in all.windows(2) {
        let [(harder, hard), (softer, soft)] = [pair[0], pair[1]];
        assert!(hard.0 > 1.15 * soft.0, "{harder} {} m, {softer} {} m", hard.0, soft.0);
        assert!(
            hard.2.wetness < soft.2.wetness && hard.2.slip_m_s > 0.1,
            "{harder} {:?}, {softer} {:?}",
            hard.2,
            soft.2
        );
    }
    // a pointer in the air is where the tool is
    let (behind_m, force_n, rub) = pressed(Preset::Throwing, -0.004);
    assert!(behind_m.abs() < 1e-5 && force_n == 0.0 && rub.force_n == 0.0, "{behind_m} {force_n} {rub:?}");
}
