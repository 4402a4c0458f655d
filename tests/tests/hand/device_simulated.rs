//! The simulated hand by its parameters: each is found again in how the hand moves under a force that the test gives.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;

use glam::Vec3;
use pottery_client::device::{Device, DeviceChoice, pointer};
use pottery_client::stroke::Stroke;
use pottery_shared::haptics::{DeviceSpecs, Haptics};

const FORCE: Vec3 = Vec3::new(0.0, 1.0, 0.0);

/// A hand that means to stay where it is.
fn hand(parameters: &str) -> Box<dyn Device> {
    let stroke = Stroke::parse("t_s,x_mm,y_mm,z_mm\n0,90,0,50\n10,90,0,50\n").unwrap();
    let choice: DeviceChoice = format!("simulated:{parameters}").parse().unwrap();
    choice.open(pointer().1, &Arc::new(stroke)).unwrap().device
}

/// How far it has gone at each millisecond along a newton that pushes from the first on, m.
fn pushed(parameters: &str, ticks: u32) -> Vec<f64> {
    pushed_every(1e-3, parameters, ticks)
}

/// The same at each tick of some seconds.
fn pushed_every(tick_s: f64, parameters: &str, ticks: u32) -> Vec<f64> {
    let mut hand = hand(parameters);
    let mut gone = Vec::new();
    for tick in 0..ticks {
        gone.push(f64::from(hand.position(f64::from(tick) * tick_s).unwrap().y));
        hand.set_force(FORCE);
    }
    gone
}

#[test]
fn mass_is_how_slowly_a_free_hand_begins_to_move() {
    for mass_kg in [0.1, 2.0] {
        let gone = pushed(&format!("mass={mass_kg},damping=0,stiffness=1,resolution_mm=0.001"), 101);
        // ½·F/m·t², a tick of 1 ms more of it, since the speed is stepped before the place; the spring takes less than 5 % of 0.1 kg's
        let wanted_m = 0.5 / mass_kg * 0.1 * 0.101;
        assert!((gone[100] / wanted_m - 1.0).abs() < 0.06, "{mass_kg} kg: {} m, not {wanted_m} m", gone[100]);
    }
}

#[test]
fn damping_is_how_fast_a_pushed_hand_goes_at_last() {
    for damping_ns_m in [5.0, 20.0] {
        let gone = pushed(&format!("mass=0.05,damping={damping_ns_m},stiffness=1,resolution_mm=0.001"), 201);
        // F/b, of which the spring of 1 N/m takes 4 % on 40 mm
        let speed_m_s = (gone[200] - gone[100]) / 0.1;
        assert!((speed_m_s * damping_ns_m - 1.0).abs() < 0.05, "{damping_ns_m} N s/m: {speed_m_s} m/s");
    }
}

#[test]
fn stiffness_is_how_far_a_pushed_hand_gives_way() {
    for stiffness_n_m in [100.0, 1000.0] {
        let gone = pushed(&format!("damping=20,stiffness={stiffness_n_m},resolution_mm=0.001"), 3000);
        // half a step of the encoders, and what an f32 at 90 mm rounds to
        assert!((gone[2999] - 1.0 / stiffness_n_m).abs() < 0.6e-6, "{stiffness_n_m} N/m: {} m", gone[2999]);
    }
}

#[test]
fn delay_is_how_much_later_the_same_comes_and_the_chain_is_tuned_to_it() {
    let usual = "resolution_mm=0.001";
    // a tick that is exact in binary, so that all of them are stepped alike
    let tick_s = 1.0 / 1024.0;
    let at_once = pushed_every(tick_s, usual, 200);
    assert!(at_once[1] > 0.0);
    for delay in [1_u16, 5, 20] {
        let delay_ms = f64::from(delay) * tick_s * 1e3;
        let late = pushed_every(tick_s, &format!("{usual},delay={delay_ms}"), 200);
        let ticks = usize::from(delay);
        assert!(late[..=ticks].iter().all(|gone| *gone == 0.0), "{delay} ticks: {:?}", &late[..=ticks]);
        assert_eq!(late[ticks..], at_once[..200 - ticks], "{delay} ticks");
        let setup = hand(&format!("delay={delay}")).setup(0.2);
        assert!((setup.delay.0 - f32::from(delay) * 1e-3).abs() < 1e-6);
        let coupling = Haptics::new(setup).coupling();
        let needed = coupling.stiffness_n_m * (0.5e-3 + setup.delay.0) + coupling.damping_ns_m;
        assert!(setup.specs.damping_ns_m + 1.0 > needed, "{delay} ms: {coupling:?}");
    }
}

#[test]
fn specs_are_those_of_the_device_that_is_named_and_peak_is_less() {
    assert_eq!(hand("").specs(), DeviceSpecs::OMNI);
    let falcon = DeviceSpecs::preset("falcon").unwrap().specs;
    assert_eq!(hand("specs=falcon").specs(), falcon);
    assert_eq!(hand("specs=falcon,peak=2").specs(), DeviceSpecs { peak_force_n: 2.0, ..falcon });
    // its encoders are the device's too, and a mouse has none
    for (name, step_m) in [("falcon", 63.5e-6), ("omega.3", 10e-6)] {
        let gone = pushed(&format!("specs={name}"), 100);
        let is_whole = |gone: &f64| (gone / step_m - (gone / step_m).round()).abs() < 1e-3;
        assert!(gone.iter().all(is_whole) && gone[99] > 2.0 * step_m, "{name}");
    }
    assert!(pushed("specs=mouse", 100)[99] > 0.0);
}
