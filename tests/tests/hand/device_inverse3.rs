//! The Inverse3's driver against a service of its kind: the conversation, places, forces, and what can go wrong.
//!
//! This is verification of the protocol as its public sources have it; no Inverse3 was at hand.

use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::inverse3::{Inverse3Driver, Inverse3Settings, MIDDLE_M};
use pottery_client::device::{Axes, Calibration, Device, DrivenDevice, MIDDLE_ROOM_M, pointer};
use pottery_shared::haptics::DeviceSpecs;
use pottery_tests::twin::HandSession;
use pottery_tests::twin::haply::{HaplyTwin, Trouble};

const FREE: Vec3 = MIDDLE_M;
/// 34 mm away from the person: the tool some millimetres in the wall.
const PRESSED: Vec3 = Vec3::new(MIDDLE_M.x, MIDDLE_M.y + 0.034, MIDDLE_M.z);

fn calibration() -> Calibration {
    Calibration::new(Axes::ZUp, MIDDLE_M)
}

fn driver(twin: &HaplyTwin, device_id: Option<&str>) -> Inverse3Driver {
    let device_id = device_id.map(str::to_owned);
    Inverse3Driver::new(Inverse3Settings { address: twin.address().to_string(), device_id })
}

fn session(twin: &HaplyTwin) -> HandSession {
    HandSession::new(driver(twin, None), calibration(), DeviceSpecs::OMNI)
}

fn press(session: &mut HandSession, twin: &HaplyTwin) {
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    for step in 1..=100 {
        twin.hold_at(FREE.lerp(PRESSED, step as f32 / 100.0));
        session.tick();
        session.tick();
    }
    session.until("the clay pushes", |_| twin.force_n() != Vec3::ZERO);
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
fn places_velocities_buttons_and_forces_keep_units_and_axes() {
    let twin = HaplyTwin::start(FREE);
    let mut device = DrivenDevice::open(driver(&twin, None), calibration(), DeviceSpecs::OMNI, pointer().1).unwrap();
    assert!(device.monitor().about().unwrap().contains("04BA"));
    for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
        twin.with(|state| (state.cursor_m, state.velocity_m_s) = (FREE + axis * 0.03, axis * 0.2));
        // Haply's axes are the room's
        until(&mut device, |device, place| {
            place.is_some_and(|place| place.distance(MIDDLE_ROOM_M + axis * 0.03) < 1e-6)
                && device.velocity().is_some_and(|velocity| velocity.distance(axis * 0.2) < 1e-6)
        });
        until(&mut device, |device, _| {
            device.set_force(axis * 1.5);
            twin.force_n() == axis * 1.5
        });
    }
    twin.with(|state| state.button_b = true);
    until(&mut device, |device, _| device.buttons() == 0b10);
    assert_eq!(twin.with(|state| state.first["session"]["configure"]["profile"]["name"].clone()), "pottery-studio");
    assert_eq!(twin.with(|state| state.addressed.clone()), "04BA");
    device.close();
    assert_eq!(twin.force_n(), Vec3::ZERO, "left with force");
}

#[test]
fn service_that_was_set_to_other_axes_is_asked_for_the_devices_own() {
    for basis in ["XZY", "X-YZ", "ZXY"] {
        let twin = HaplyTwin::start(FREE);
        twin.with(|state| {
            state.basis = basis.into();
            state.mount = serde_json::json!({ "rotation": { "w": 0.0, "z": 1.0 } });
        });
        let mut device =
            DrivenDevice::open(driver(&twin, None), calibration(), DeviceSpecs::OMNI, pointer().1).unwrap();
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            twin.hold_at(FREE + axis * 0.03);
            until(&mut device, |device, place| {
                device.set_force(axis * 1.5);
                place.is_some_and(|place| place.distance(MIDDLE_ROOM_M + axis * 0.03) < 1e-6)
                    && twin.force_n() == axis * 1.5
            });
        }
    }
}

#[test]
fn service_that_keeps_to_other_axes_or_another_mount_is_not_used_until_it_gives_them_up() {
    let turned = serde_json::json!({ "rotation": { "w": 0.0, "z": 1.0 } });
    for (basis, mount, said) in [("XZY", serde_json::json!({}), "axes as XZY"), ("+X+Y+Z", turned, "preset `defaults`")]
    {
        let twin = HaplyTwin::start(FREE);
        twin.with(|state| (state.basis, state.mount, state.is_stubborn) = (basis.into(), mount, true));
        let mut session = session(&twin);
        session.until("it is said", |session| session.notice().is_some_and(|notice| notice.contains(said)));
        session.pass(Duration::from_millis(100));
        assert_eq!((session.tool_m(), session.fault()), (None, None));
        assert!(!session.notice().unwrap().contains('\n') && twin.force_n() == Vec3::ZERO);
        twin.with(|state| state.is_stubborn = false);
        press(&mut session, &twin);
        assert_eq!(session.notice(), None);
    }
}

#[test]
fn workspace_that_somebody_moves_turns_or_scales_in_mid_press_takes_the_force_away() {
    for transform in [
        serde_json::json!({ "position": { "z": 0.05 } }),
        serde_json::json!({ "rotation": { "w": 0.0, "z": 1.0 } }),
        serde_json::json!({ "scale": { "x": 2.0, "y": 2.0, "z": 2.0 } }),
    ] {
        let twin = HaplyTwin::start(FREE);
        let mut session = session(&twin);
        press(&mut session, &twin);
        twin.with(|state| state.transform = transform);
        session.until("the force is off", |session| session.force_n() == 0.0 && session.tool_m().is_none());
        session.until("it is said", |session| session.notice().is_some_and(|notice| notice.contains("transform")));
        session.until("the device has none", |_| twin.force_n() == Vec3::ZERO);
        twin.with(|state| state.transform = serde_json::json!({}));
        session.until("it is back", |session| session.force_n() > 0.1 && session.notice().is_none());
    }
}

#[test]
fn it_goes_on_sending_when_there_is_no_force() {
    let twin = HaplyTwin::start(FREE);
    let mut session = session(&twin);
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    let before = twin.with(|state| state.messages);
    session.until("a hundred messages more", |_| twin.with(|state| state.messages) > before + 100);
    assert_eq!(twin.force_n(), Vec3::ZERO);
}

#[test]
fn clay_pushes_the_cursor_towards_the_person() {
    let twin = HaplyTwin::start(FREE);
    let mut session = session(&twin);
    press(&mut session, &twin);
    let force_n = twin.force_n();
    assert!(force_n.y < 0.0 && force_n.y.abs() > 0.9 * force_n.length(), "{force_n}");
    assert!(force_n.length() <= DeviceSpecs::OMNI.peak_force_n * 1.001, "{force_n}");
}

#[test]
fn service_that_breaks_its_rules_loses_the_device_until_it_keeps_them() {
    for (trouble, said) in [
        (Trouble::Silent, "not answered"),
        (Trouble::Late(200), "not answered"),
        (Trouble::Twice, "one reply"),
        (Trouble::Garbage, "JSON"),
        (Trouble::Stateless, "cursor_position"),
        (Trouble::NotANumber, "JSON"),
        (Trouble::Powerless, "power"),
    ] {
        let twin = HaplyTwin::start(FREE);
        let mut session = session(&twin);
        press(&mut session, &twin);
        twin.with(|state| state.trouble = trouble);
        session.until("the force is off", |session| session.force_n() == 0.0 && session.tool_m().is_none());
        session.until("it is said", |session| session.notice().is_some_and(|notice| notice.contains(said)));
        session.until("the device has none", |_| twin.force_n() == Vec3::ZERO);
        twin.with(|state| state.trouble = Trouble::None);
        twin.hold_at(FREE);
        session.until("it is back", |session| session.tool_m().is_some() && session.notice().is_none());
    }
}

/// Presses until the clay pushes and lets the service do something late, again and again until it is felt as none.
fn late(session: &mut HandSession, twin: &HaplyTwin, trouble: Trouble) {
    press(session, twin);
    session.until("the clay is felt", |session| session.force_n() > 0.1);
    let mut ticks = 0;
    session.until("there is no force", |session| {
        if ticks % 200 == 0 {
            twin.with(|state| state.trouble = trouble);
        }
        ticks += 1;
        session.force_n() == 0.0
    });
    assert_eq!(session.tool_m(), None);
}

#[test]
fn one_late_answer_takes_the_force_away_without_a_word_and_it_fades_in_again() {
    for late_ms in [10, 30] {
        let twin = HaplyTwin::start(FREE);
        let mut session = session(&twin);
        late(&mut session, &twin, Trouble::LateOnce(late_ms));
        let mut before_n = 0.0;
        session.until("the clay is felt again", |session| {
            let force_n = session.force_n();
            // 100 N/s, until it is as large as wanted
            assert!(force_n - before_n < 0.1001 || before_n > 0.1, "{before_n} N, then {force_n} N");
            before_n = force_n;
            assert_eq!(session.notice(), None);
            force_n > 0.1
        });
    }
}

#[test]
fn service_that_always_answers_ten_milliseconds_late_is_a_slow_one_and_felt_as_one() {
    let twin = HaplyTwin::start(FREE);
    let mut session = session(&twin);
    late(&mut session, &twin, Trouble::Late(10));
    let ten = Duration::from_millis(10);
    let interval = |session: &HandSession| session.monitor().interval().unwrap_or_default();
    session.until("it is in hand", |session| session.tool_m().is_some() && interval(session) >= ten);
    assert_eq!(session.notice(), None);
    twin.with(|state| state.trouble = Trouble::None);
    session.until("it is a fast one", |session| session.tool_m().is_some() && interval(session) < ten / 2);
}

#[test]
fn service_that_always_answers_thirty_milliseconds_late_gives_no_force_until_it_answers_in_time() {
    let twin = HaplyTwin::start(FREE);
    let mut session = session(&twin);
    late(&mut session, &twin, Trouble::Late(30));
    session.until("it is said", |session| {
        assert_eq!((session.force_n(), session.tool_m()), (0.0, None));
        session.notice().is_some_and(|said| said.contains("late again and again"))
    });
    session.until("the device has none", |_| twin.force_n() == Vec3::ZERO);
    twin.with(|state| state.trouble = Trouble::None);
    session.until("it is back", |session| session.force_n() > 0.1 && session.notice().is_none());
}

#[test]
fn service_that_is_stopped_in_mid_press_may_be_started_again() {
    let twin = HaplyTwin::start(FREE);
    let address = twin.address();
    let mut session = session(&twin);
    press(&mut session, &twin);
    drop(twin);
    session.until("the force is off", |session| session.force_n() == 0.0 && session.tool_m().is_none());
    session.until("it is said", |session| session.notice().is_some());
    let twin = HaplyTwin::listen(address, FREE);
    session.until("it is back", |session| session.tool_m().is_some() && session.notice().is_none());
    press(&mut session, &twin);
}

#[test]
fn device_pulled_out_of_the_service_is_gone_and_comes_back() {
    let twin = HaplyTwin::start(FREE);
    let mut session = session(&twin);
    press(&mut session, &twin);
    let devices = twin.with(|state| std::mem::take(&mut state.devices));
    session.until("the force is off", |session| session.force_n() == 0.0 && session.tool_m().is_none());
    session.until("it is said", |session| session.notice().is_some_and(|said| said.contains("plug")));
    twin.hold_at(FREE);
    twin.with(|state| state.devices = devices);
    session.until("it is back", |session| session.tool_m().is_some() && session.notice().is_none());
}

#[test]
fn of_two_devices_the_first_is_taken_or_the_one_that_is_named() {
    let twin = HaplyTwin::start(FREE);
    twin.with(|state| state.devices = vec!["04BA".into(), "049D".into()]);
    let found = driver(&twin, None).probe().unwrap();
    assert_eq!(found, "Haply Inverse3 04BA (of 2: another with --device inverse3:id=049D)");
    let mut named = HandSession::new(driver(&twin, Some("049D")), calibration(), DeviceSpecs::OMNI);
    named.until("the tool is in hand", |session| session.tool_m().is_some());
    assert_eq!(twin.with(|state| state.addressed.clone()), "049D");
    let missing = driver(&twin, Some("FFFF")).probe().unwrap_err().to_string();
    assert!(missing.contains("049D") && missing.contains("FFFF"), "{missing}");
}

#[test]
fn without_a_service_the_sentence_says_what_to_start() {
    let twin = HaplyTwin::start(FREE);
    let driver = driver(&twin, None);
    drop(twin);
    let said = driver.probe().unwrap_err().to_string();
    assert!(said.contains("Haply Inverse Service") && said.contains("127.0.0.1"), "{said}");
}

#[test]
fn jump_of_five_centimetres_is_a_fault_that_passes() {
    let twin = HaplyTwin::start(FREE);
    let mut session = session(&twin);
    press(&mut session, &twin);
    twin.hold_at(PRESSED + Vec3::Z * 0.05);
    session.until("the jump is noticed", |session| session.fault().is_some());
    assert_eq!(session.force_n(), 0.0);
    session.until("the tool is in hand again", |session| session.fault().is_none());
}
