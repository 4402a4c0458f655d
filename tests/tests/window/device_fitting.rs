//! A device that is fitted to the hand: by a window's side of it, and in a real window, from the key to the next start.

use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::{
    Axes, Calibration, Device, DeviceFault, DrivenDevice, Driver, Fit, MIDDLE_ROOM_M, Pace, Port, Reading, Reported,
    pointer,
};
use pottery_shared::haptics::DeviceSpecs;
use pottery_tests::display::{Controls, Display, SIZE};
use pottery_tests::twin::HandSession;
use pottery_tests::twin::haply::HaplyTwin;

/// How long anything takes at most; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);

/// A device that is where a test has put it; where that is no place, it is pulled out.
#[derive(Clone, Default)]
struct Moved(Arc<Mutex<Vec3>>);

impl Moved {
    fn to(&self, position_m: Vec3) {
        *self.0.lock().expect("no other thread has failed") = position_m;
    }
}

impl Driver for Moved {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        port.found("moved".into(), Reported::default());
        let mut pace = Pace::new();
        while !port.is_closing() {
            let position_m = *self.0.lock().expect("no other thread has failed");
            if position_m.is_nan() {
                return Err(DeviceFault::Gone { device: "moved device", reason: "it was pulled out".into() });
            }
            port.publish(Reading { position_m, velocity_m_s: None, buttons: 2 });
            pace.wait();
        }
        Ok(())
    }
}

/// A place in the room in the frame of a device whose y is up.
fn y_up(x_m: f32, y_m: f32, z_m: f32) -> Vec3 {
    Vec3::new(x_m, z_m, -y_m)
}

#[test]
fn a_device_that_goes_while_it_is_fitted_has_no_place_until_it_is_back() {
    let device = Moved::default();
    device.to(y_up(0.03, 0.05, 0.02));
    let mut session = HandSession::new(device.clone(), Calibration::new(Axes::YUp, Vec3::ZERO), DeviceSpecs::OMNI);
    session.monitor().set_fitting(true);
    session.until("its place is told", |session| session.monitor().place_m().is_some());
    device.to(Vec3::NAN);
    session.until("no place is told", |session| session.monitor().place_m().is_none());
    device.to(y_up(0.03, 0.05, 0.02));
    session.until("its place is told again", |session| session.monitor().place_m().is_some());
}

#[test]
fn while_a_hand_is_measured_it_has_no_tool_and_no_force_and_then_the_tool_that_it_was_given() {
    let device = Moved::default();
    device.to(y_up(0.065, 0.0, 0.1));
    let middle = y_up(MIDDLE_ROOM_M.x, MIDDLE_ROOM_M.y, MIDDLE_ROOM_M.z);
    let mut session = HandSession::new(device.clone(), Calibration::new(Axes::YUp, middle), DeviceSpecs::OMNI);
    session.until("the clay pushes", |session| session.force_n() > 0.3);
    assert_eq!((session.monitor().place_m(), session.monitor().is_pressed()), (None, false));

    session.monitor().set_fitting(true);
    (0..2).for_each(|_| session.tick());
    assert_eq!((session.force_n(), session.fault()), (0.0, None));
    // wherever it goes
    for rest_m in [Vec3::new(0.060, 0.0, 0.1), Vec3::new(0.03, 0.05, 0.02)] {
        device.to(y_up(rest_m.x, rest_m.y, rest_m.z));
        session.until("its place is told", |session| session.monitor().place_m() == Some(rest_m));
        assert_eq!((session.force_n(), session.monitor().is_pressed()), (0.0, true));
    }

    let fit = Fit { middle_m: Vec3::new(0.03, 0.05, 0.02), scale: 2.0 };
    session.monitor().fit_to(fit);
    session.monitor().fit_to(Fit { scale: f32::NAN, ..fit });
    session.monitor().set_fitting(false);
    session.until("the hand rests before the pot", |session| session.tool_m() == Some(MIDDLE_ROOM_M));
    assert_eq!((session.monitor().place_m(), session.monitor().fit()), (None, fit));
    device.to(y_up(0.03, 0.05, 0.01));
    session.until("the tool goes twice as far", |session| {
        session.tool_m().is_some_and(|tool_m| tool_m.distance(MIDDLE_ROOM_M - Vec3::Z * 0.02) < 1e-6)
    });
    // and is felt there
    device.to(y_up(0.03, 0.066, 0.02));
    session.until("the clay pushes again", |session| session.force_n() > 0.1);
}

#[test]
fn what_a_device_can_render_is_told_anew_for_another_scale_and_a_scale_of_which_it_can_make_nothing_is_left() {
    let device = Moved::default();
    let weak = DeviceSpecs { stiffness_max_n_m: 4.0, ..DeviceSpecs::OMNI };
    let mut opened =
        DrivenDevice::open(device.clone(), Calibration::new(Axes::ZUp, Vec3::ZERO), weak, pointer().1).unwrap();
    let monitor = opened.monitor();
    let begin = Instant::now();
    let mut until = |what: &str, holds: &dyn Fn(&DrivenDevice) -> bool| {
        while !holds(&opened) {
            assert!(begin.elapsed() < PATIENCE, "{what}: {:?}", opened.specs());
            std::thread::sleep(Duration::from_millis(1));
            let place = opened.position(begin.elapsed().as_secs_f64());
            assert!(
                !(opened.is_another() && place.is_some()),
                "{what}: it has a place in the tick in which it changes"
            );
        }
        opened.setup(0.2).specs.stiffness_max_n_m
    };
    until("it is in hand", &|device| device.specs().stiffness_max_n_m == 4.0);
    monitor.fit_to(Fit { middle_m: Vec3::ZERO, scale: 2.0 });
    assert_eq!(until("it is as soft as the room is large", &|device| device.specs().stiffness_max_n_m < 4.0), 2.0);
    // no device has less than 1 N/m
    let middle_m = Vec3::new(0.01, 0.02, 0.03);
    monitor.fit_to(Fit { middle_m, scale: 8.0 });
    device.to(middle_m);
    let deadline = Instant::now() + PATIENCE;
    while opened.position(begin.elapsed().as_secs_f64()) != Some(MIDDLE_ROOM_M) {
        assert!(Instant::now() < deadline, "the middle is not where the hand rests");
        std::thread::sleep(Duration::from_millis(1));
    }
    assert_eq!(opened.specs().stiffness_max_n_m, 2.0);
}

/// Waits until something that is said begins so.
fn until(controls: &Controls<'_>, said: &str) {
    let deadline = Instant::now() + PATIENCE;
    while controls.find(said).is_none() {
        assert!(Instant::now() < deadline, "{said:?} is not said: {:#?}", controls.all());
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Longer than from a reply of the device to a hand that has taken it in.
const SEEN: Duration = Duration::from_millis(700);

/// Holds the device somewhere until many replies have said so.
fn hold_at(twin: &HaplyTwin, place_m: Vec3) {
    twin.hold_at(place_m);
    let before = twin.with(|state| state.messages);
    let deadline = Instant::now() + PATIENCE;
    while twin.with(|state| state.messages) < before + 50 {
        assert!(Instant::now() < deadline, "the device is no longer asked where it is");
        std::thread::sleep(Duration::from_millis(10));
    }
    std::thread::sleep(SEEN);
}

/// Holds it somewhere until the card's picture of what the hand reaches shows it.
fn hold_until_drawn(twin: &HaplyTwin, display: &Display, place_m: Vec3) {
    let card = || {
        let pixels = display.pixels();
        let rows = pixels.chunks_exact(SIZE.0 * 3).take(SIZE.1 - 70).skip(SIZE.1 / 2);
        rows.flat_map(|row| row[(SIZE.0 - 300) * 3..(SIZE.0 - 20) * 3].to_vec()).collect::<Vec<u8>>()
    };
    let before = card();
    hold_at(twin, place_m);
    let deadline = Instant::now() + PATIENCE;
    while card() == before {
        assert!(Instant::now() < deadline, "the card does not follow the hand");
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn in_a_window_two_steps_fit_a_device_to_the_hand_and_it_is_so_at_the_next_start() {
    let display = Display::new();
    let twin = HaplyTwin::start(Vec3::new(0.0, 0.0, 0.1));
    let device = format!("inverse3:address={}", twin.address());
    let arguments = ["--listen", "127.0.0.1:0", "--mute", "--device", &device];
    let (mut studio, controls) = display.studio_with_controls(&arguments);
    let key = |name: &str| display.run("xdotool", &["key", name]);
    let rest_m = Vec3::new(0.02, -0.15, 0.18);

    until(&controls, "Fit the device to your hand (C)");
    key("c");
    until(&controls, "1 of 2");
    hold_at(&twin, rest_m);
    key("c");
    until(&controls, "2 of 2");
    // 50 mm up and 40 mm down
    hold_until_drawn(&twin, &display, rest_m + Vec3::new(0.03, 0.01, 0.05));
    hold_until_drawn(&twin, &display, rest_m - Vec3::new(0.03, 0.01, 0.04));
    assert_eq!(twin.force_n(), Vec3::ZERO);
    twin.with(|state| state.button_b = true);
    until(&controls, "Does it suit?");
    twin.with(|state| state.button_b = false);
    until(&controls, "Keep it");
    key("c");
    until(&controls, "Fit the device to your hand (C)");
    let deadline = Instant::now() + PATIENCE;
    let kept = loop {
        let kept = std::fs::read_to_string(display.preferences()).expect("it was written before the window opened");
        if kept.contains("[fits.inverse3]") {
            break kept;
        }
        assert!(Instant::now() < deadline, "{kept}");
        std::thread::sleep(Duration::from_millis(50));
    };
    assert!(kept.contains("middle_mm = [20.0, -150.0, 180.0]") && kept.contains("scale = 2.5"), "{kept}");

    // what was begun and left changes nothing
    key("c");
    until(&controls, "1 of 2");
    controls.press("As it was before");
    until(&controls, "Fit the device to your hand (C)");
    key("Escape");
    studio.wait().expect("the studio ends");

    twin.hold_at(rest_m);
    let (mut studio, _controls) = display.studio_with_controls(&arguments);
    std::thread::sleep(SEEN);
    // 35 mm in the room, 7 mm into the clay
    hold_at(&twin, rest_m + Vec3::Y * 0.014);
    let deadline = Instant::now() + PATIENCE;
    while twin.force_n().y > -0.1 {
        assert!(Instant::now() < deadline, "the clay is not where it was fitted to be: {} N", twin.force_n());
        std::thread::sleep(Duration::from_millis(50));
    }
    assert_eq!(std::fs::read_to_string(display.preferences()).expect("it is there"), kept);
    key("Escape");
    studio.wait().expect("the studio ends");
}
