//! The driver for HDAPI against a C library that exports the same functions: opening, units, forces, and what can go wrong.
//!
//! This is verification of the protocol as its public headers have it; no Omni and no Touch was at hand.

#![cfg(unix)]
#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::openhaptics::{MIDDLE_M, OpenHapticsDriver, OpenHapticsSettings};
use pottery_client::device::{Axes, Calibration, Device, DrivenDevice, Limits, MIDDLE_ROOM_M, Pointer, pointer};
use pottery_shared::haptics::{DeviceSpecs, Fault};
use pottery_tests::twin::HandSession;
use pottery_tests::twin::hdapi::{HdapiTwin, Trouble};

const FREE: Vec3 = Vec3::ZERO;
/// Where the hand means to be: some centimetres into the pot.
const PRESSED: Vec3 = Vec3::new(0.0, 0.0, -0.036);

fn calibration() -> Calibration {
    Calibration::new(Axes::YUp, MIDDLE_M)
}

fn driver(twin: &HdapiTwin, name: Option<&str>) -> OpenHapticsDriver {
    let (name, library) = (name.map(str::to_owned), Some(twin.file().to_owned()));
    OpenHapticsDriver::new(OpenHapticsSettings { name, library })
}

fn device(twin: &HdapiTwin) -> DrivenDevice {
    DrivenDevice::open(driver(twin, None), calibration(), DeviceSpecs::OMNI, pointer().1).unwrap()
}

fn session(twin: &HdapiTwin) -> HandSession {
    HandSession::new(driver(twin, None), calibration(), DeviceSpecs::OMNI)
}

fn press(session: &mut HandSession, twin: &HdapiTwin) {
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    for step in 1..=200 {
        twin.set(Trouble::None, FREE.lerp(PRESSED, step as f32 / 200.0), 0);
        session.tick();
    }
    session.until("the clay pushes", |session| session.force_n() > 0.1 && twin.look().sent_n.length() > 0.1);
}

/// Asks a device each few milliseconds until something holds.
fn until(device: &mut DrivenDevice, mut holds: impl FnMut(&mut DrivenDevice, Option<Vec3>) -> bool) {
    let begin = Instant::now();
    loop {
        let place = device.position(begin.elapsed().as_secs_f64());
        if holds(device, place) {
            return;
        }
        assert!(begin.elapsed() < Duration::from_secs(30), "{place:?}, {:?}", device.monitor().notice());
        std::thread::sleep(Duration::from_millis(2));
    }
}

#[test]
fn millimetres_become_metres_on_the_rooms_axes() {
    let twin = HdapiTwin::compile();
    let mut device = device(&twin);
    assert_eq!(device.monitor().about().unwrap(), "PHANTOM Omni (twin)");
    for (moved, room) in
        [(Vec3::X * 0.05, Vec3::X * 0.05), (Vec3::Y * 0.05, Vec3::Z * 0.05), (Vec3::Z * 0.05, Vec3::NEG_Y * 0.05)]
    {
        twin.set(Trouble::None, moved, 0b10);
        // the stylus comes to rest where the hand is: to a hundredth of a millimetre
        until(&mut device, |device, place| {
            place.is_some_and(|place| place.distance(MIDDLE_ROOM_M + room) < 1e-5)
                && device.velocity().is_some_and(|velocity| velocity.length() < 1e-3)
        });
        assert_eq!(device.buttons(), 0b10);
    }
    twin.set(Trouble::None, Vec3::X * -0.05, 0);
    // on its way to the left, 100 mm away
    until(&mut device, |device, _| device.velocity().is_some_and(|velocity| velocity.x < -0.1 && velocity.x > -2.0));
}

#[test]
fn reported_limits_stand_in_the_place_of_what_is_known_of_the_kind() {
    let twin = HdapiTwin::compile();
    let specs = device(&twin).specs();
    assert_eq!((specs.peak_force_n, specs.continuous_force_n), (3.0, Some(0.8)));
    // 0.5 N/mm and 0.003 N s/mm
    assert!((specs.stiffness_max_n_m - 500.0).abs() < 1e-3 && (specs.damping_max_ns_m - 3.0).abs() < 1e-5, "{specs:?}");
    // 160 mm wide, 120 mm high and 70 mm deep
    assert!((specs.workspace_radius_m - 0.035).abs() < 1e-6, "{specs:?}");
    let halved = Calibration::new(Axes::YUp, MIDDLE_M).scaled(2.0).unwrap();
    let scaled = DrivenDevice::open(driver(&twin, None), halved, DeviceSpecs::OMNI, pointer().1).unwrap();
    assert!((scaled.specs().stiffness_max_n_m - 250.0).abs() < 1e-3);
    assert!((scaled.specs().workspace_radius_m - 0.07).abs() < 1e-6);
    drop(scaled);
    // one that ends before it begins is not believed, and the rest is
    twin.set(Trouble::OddWorkspace, FREE, 0);
    let specs = device(&twin).specs();
    assert_eq!((specs.workspace_radius_m, specs.peak_force_n), (DeviceSpecs::OMNI.workspace_radius_m, 3.0));
}

#[test]
fn force_of_the_room_moves_the_stylus_and_none_is_left_behind() {
    let twin = HdapiTwin::compile();
    let mut device = device(&twin);
    until(&mut device, |device, _| {
        device.set_force(Vec3::new(0.0, 0.0, 1.0));
        let stylus = twin.look();
        // 5 mm for a newton, upwards, which is y
        stylus.sent_n.as_vec3() == Vec3::Y && (stylus.at_mm.y - 5.0).abs() < 0.05
    });
    until(&mut device, |device, _| {
        device.set_force(Vec3::new(100.0, 0.0, 0.0));
        (twin.look().sent_n.length() - 3.0).abs() < 1e-5
    });
    device.close();
    let stylus = twin.look();
    assert!(stylus.sent_n.length() == 0.0 && !stylus.is_open && !stylus.runs, "{stylus:?}");
}

#[test]
fn clay_holds_the_stylus_back() {
    let twin = HdapiTwin::compile();
    let mut session = session(&twin);
    press(&mut session, &twin);
    let stylus = twin.look();
    assert!(stylus.sent_n.z > 0.0 && stylus.at_mm.z > f64::from(PRESSED.z) * 1e3, "{stylus:?}");
}

/// Has the library fail in mid-press, in so many ticks at most, and looks whether the stylus is without force as well.
fn fails(trouble: Trouble, most_ticks: u32, said: &str) {
    let twin = HdapiTwin::compile();
    let mut session = session(&twin);
    let press = |session: &mut HandSession| press(session, &twin);
    session.loses_force(most_ticks, said, press, |is_wrong| {
        let (trouble, hand_m) = if is_wrong { (trouble, PRESSED) } else { (Trouble::None, FREE) };
        if !is_wrong {
            // it rests for as long as something is wrong
            let begin = Instant::now();
            while twin.look().sent_n.length() > 0.0 {
                assert!(begin.elapsed() < Duration::from_secs(30), "{trouble:?}: {:?}", twin.look());
                std::thread::sleep(Duration::from_millis(1));
            }
        }
        twin.set(trouble, hand_m, 0);
    });
}

#[test]
fn device_that_fails_in_mid_press_has_no_force_within_two_ticks_and_comes_back() {
    for (trouble, said) in [
        (Trouble::Unplugged, "plug it in again"),
        (Trouble::ErrorsWithoutEnd, "plug it in again"),
        (Trouble::OddErrors, "unknown"),
    ] {
        fails(trouble, 2, said);
    }
}

#[test]
fn library_that_calls_late_or_not_at_all_loses_its_force_when_three_calls_are_due() {
    // one may have come just before, and a call may be under way: 1 + 3 + 2 + 1 ms of the loop's rhythm
    for (trouble, said) in
        [(Trouble::Frozen, "not answered"), (Trouble::VeryLate, "not answered"), (Trouble::Late, "late")]
    {
        fails(trouble, 7, said);
    }
}

#[test]
fn library_without_a_function_is_one_sentence_that_names_it_and_the_mouse_works() {
    for function in ["hdGetError", "hdUnschedule", "hdSetDoublev"] {
        let twin = HdapiTwin::without(function);
        let (mut window, mouse) = pointer();
        let mut session = HandSession::beside(mouse, driver(&twin, None), calibration(), DeviceSpecs::OMNI);
        session.until("it is said", |session| session.notice().is_some_and(|said| said.contains(function)));
        let said = session.notice().unwrap();
        assert!(said.contains("install OpenHaptics") && !said.contains('\n'), "{said}");
        window.write(Pointer { target_m: Some(MIDDLE_ROOM_M), ..Pointer::default() });
        session.until("the mouse has the tool", |session| session.tool_m().is_some());
    }
}

#[test]
fn of_two_styli_the_one_that_is_named_is_felt_and_the_other_left_alone() {
    let twin = HdapiTwin::compile();
    let mut session = HandSession::new(driver(&twin, Some("Left Device")), calibration(), DeviceSpecs::OMNI);
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    // the default one goes where it likes
    for step in 1..=200 {
        twin.set_one(0, Trouble::None, Vec3::X * 0.05, 0b1);
        twin.set_one(1, Trouble::None, FREE.lerp(PRESSED, step as f32 / 200.0), 0b10);
        session.tick();
    }
    session.until("the clay pushes", |session| session.force_n() > 0.1 && twin.look_at(1).sent_n.length() > 0.1);
    let (default, left) = (twin.look(), twin.look_at(1));
    assert!(!default.is_open && default.frames == 0 && default.sent_n.length() == 0.0, "{default:?}");
    assert!(left.is_open && left.sent_n.z > 0.0, "{left:?}");
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    assert!(session.tool_m().unwrap().x.abs() < 0.01, "{:?}", session.tool_m());
    let chosen = driver(&twin, None).probe().unwrap();
    assert!(chosen.contains("set as default") && chosen.contains("openhaptics:name="), "{chosen}");
}

#[test]
fn place_that_is_no_number_is_a_fault_that_passes() {
    let twin = HdapiTwin::compile();
    let mut session = session(&twin);
    press(&mut session, &twin);
    twin.set(Trouble::NotANumber, PRESSED, 0);
    session.until("it is noticed", |session| session.fault() == Some(Fault::Position) && session.force_n() == 0.0);
    session.until("the device has no force", |_| twin.look().sent_n.length() == 0.0);
    twin.set(Trouble::None, FREE, 0);
    session.until("it passes", |session| session.fault().is_none());
}

#[test]
fn warm_motors_rest_and_when_they_are_cool_the_sentence_goes_away_and_the_force_comes_by_the_ramp() {
    let twin = HdapiTwin::compile();
    let mut session = session(&twin);
    press(&mut session, &twin);
    twin.set(Trouble::Warm, PRESSED, 0);
    session.until("it is said", |session| session.notice().is_some_and(|notice| notice.contains("warm")));
    session.until("a warm device still has a place", |session| session.tool_m().is_some());
    session.until("nothing is given to it", |session| session.force_n() == 0.0 && twin.look().sent_n.length() == 0.0);
    twin.set(Trouble::None, PRESSED, 0);
    let (mut ticks, mut sent_n, begin) = (0_u16, 0.0, Instant::now());
    while sent_n < 0.3 {
        assert!(begin.elapsed() < Duration::from_secs(30), "{sent_n} N are sent to a cool device");
        session.tick();
        ticks += u16::from(session.force_n() > 0.0);
        sent_n = twin.look().sent_n.length();
        // 100 N/s
        assert!(sent_n <= 0.1 * f64::from(ticks) + 1e-3, "{sent_n} N after {ticks} ticks with a force");
    }
    session.until("it is over", |session| session.notice().is_none() && twin.look().sent_n.length() > 0.0);
}

#[test]
fn device_that_reports_no_force_leaves_the_hand_to_the_mouse_until_a_sound_one_is_plugged_in() {
    let twin = HdapiTwin::compile();
    twin.set(Trouble::ZeroLimits, PRESSED, 0);
    let (mut window, mouse) = pointer();
    let mut session = HandSession::beside(mouse, driver(&twin, None), calibration(), DeviceSpecs::OMNI);
    let said = session.notice().unwrap();
    assert!(said.contains("peak force (N) = 0") && said.contains("specs=") && !said.contains('\n'), "{said}");
    session.pass(Duration::from_millis(100));
    assert_eq!((session.tool_m(), session.fault()), (None, None));
    let asked = |target_m| Pointer { target_m, ..Pointer::default() };
    window.write(asked(Some(MIDDLE_ROOM_M)));
    session.until("the mouse has the tool", |session| session.tool_m().is_some());
    window.write(asked(Some(MIDDLE_ROOM_M + Vec3::Y * 0.036)));
    session.until("the clay pushes", |session| session.force_n() > 0.1);
    assert!(twin.look().frames > 0 && twin.look().sent_n.length() == 0.0, "{:?}", twin.look());
    window.write(asked(None));
    // it is pulled out, and another is plugged in
    twin.set(Trouble::Unplugged, FREE, 0);
    session.until("it has gone", |session| session.notice().is_some_and(|said| said.contains("plug it in")));
    twin.set(Trouble::None, FREE, 0);
    session.until("it is there", |session| session.tool_m().is_some() && session.notice().is_none());
    press(&mut session, &twin);
    let begin = Instant::now();
    while begin.elapsed() < Duration::from_millis(200) {
        session.tick();
        // 3 N by its own word, where its kind has 3.3
        assert!(session.force_n() <= 3.0 * (1.0 + 1e-6), "{} N", session.force_n());
    }
    // and the other way round
    twin.set(Trouble::Unplugged, FREE, 0);
    session.until("that has gone", |session| session.notice().is_some_and(|said| said.contains("plug it in")));
    twin.set(Trouble::ZeroLimits, PRESSED, 0);
    session.until("it is refused", |session| session.notice().is_some_and(|said| said.contains("peak force")));
    session.pass(Duration::from_millis(100));
    assert!(session.tool_m().is_none() && twin.look().sent_n.length() == 0.0);
}

#[test]
fn who_names_the_kind_has_its_figures_for_those_that_make_no_sense() {
    let twin = HdapiTwin::compile();
    twin.set(Trouble::ZeroLimits, FREE, 0);
    let limits = Limits::from(DeviceSpecs::OMNI).named();
    let device = DrivenDevice::open(driver(&twin, None), calibration(), limits, pointer().1).unwrap();
    assert_eq!(device.monitor().notice(), None);
    assert_eq!(device.specs().peak_force_n, DeviceSpecs::OMNI.peak_force_n);
    // what makes sense is believed
    assert!((device.specs().stiffness_max_n_m - 500.0).abs() < 1e-3);
}

#[test]
fn library_or_device_that_is_not_there_is_one_sentence() {
    let library = Some("/no/such/libHD.so".into());
    let missing = OpenHapticsDriver::new(OpenHapticsSettings { name: None, library }).probe().unwrap_err().to_string();
    assert!(missing.contains("OpenHaptics") && missing.contains("openhaptics:lib="), "{missing}");
    let twin = HdapiTwin::compile();
    let other = driver(&twin, Some("Third Device")).probe().unwrap_err().to_string();
    assert!(other.contains("0x0300"), "{other}");
    assert!(driver(&twin, Some("Left Device")).probe().is_ok());
}

#[test]
fn device_in_use_elsewhere_is_said_to_be() {
    let twin = HdapiTwin::compile();
    let first = device(&twin);
    let second = driver(&twin, None).probe().unwrap_err().to_string();
    assert!(second.contains("another program"), "{second}");
    drop(first);
}
