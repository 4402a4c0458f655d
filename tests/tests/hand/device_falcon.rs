//! The Falcon's driver against a scripted Falcon: firmware, homing, places, forces, and what can go wrong on the way.
//!
//! This is verification of the protocol as its public sources have it; no Falcon was at hand.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};
use pottery_client::device::falcon::{FalconDriver, FalconSettings, MIDDLE_M, torques_nm};
use pottery_client::device::{Axes, Calibration, Device, DrivenDevice, MIDDLE_ROOM_M, pointer};
use pottery_shared::haptics::DeviceSpecs;
use pottery_tests::twin::HandSession;
use pottery_tests::twin::falcon::{FalconBus, FalconTwin, Trouble};

fn calibration() -> Calibration {
    Calibration::new(Axes::YUp, MIDDLE_M.as_vec3())
}

fn kind() -> DeviceSpecs {
    DeviceSpecs::preset("falcon").unwrap().specs
}

fn session(twin: &FalconTwin, settings: FalconSettings) -> HandSession {
    HandSession::new(FalconDriver::new(FalconBus::from(twin), settings), calibration(), kind())
}

fn device(twin: &FalconTwin) -> DrivenDevice {
    let driver = FalconDriver::new(FalconBus::from(twin), FalconSettings::default());
    DrivenDevice::open(driver, calibration(), kind(), pointer().1).unwrap()
}

/// A place before the pot, and one with the tool some millimetres in its wall.
const FREE: Vec3 = Vec3::new(0.0, 0.0, 0.125);
const PRESSED: Vec3 = Vec3::new(0.0, 0.0, 0.125 - 0.034);

/// Moves the grip as a hand does, slower than what counts as a jump.
fn move_to(session: &mut HandSession, twin: &FalconTwin, from: Vec3, to: Vec3) {
    for step in 1..=100 {
        twin.hold_at(from.lerp(to, step as f32 / 100.0));
        session.tick();
        session.tick();
    }
}

/// Brings the grip into the clay until the motors push back.
fn press(session: &mut HandSession, twin: &FalconTwin) {
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    move_to(session, twin, FREE, PRESSED);
    session.until("the motors push", |_| twin.motors() != [0; 3]);
}

#[test]
fn grip_is_where_the_room_has_it() {
    let twin = FalconTwin::default();
    let mut device = device(&twin);
    // right, up and towards the person are x, z and -y of the room
    for (moved, room) in [
        (Vec3::new(0.02, 0.0, 0.0), Vec3::new(0.02, 0.0, 0.0)),
        (Vec3::new(0.0, 0.02, 0.0), Vec3::new(0.0, 0.0, 0.02)),
        (Vec3::new(0.0, 0.0, 0.02), Vec3::new(0.0, -0.02, 0.0)),
    ] {
        twin.hold_at(FREE + moved);
        let begin = Instant::now();
        let expected = MIDDLE_ROOM_M + room;
        loop {
            std::thread::sleep(Duration::from_millis(5));
            let found = device.position(begin.elapsed().as_secs_f64());
            // the encoders' steps are 0.036 degrees, some 0.05 mm at the grip
            if found.is_some_and(|found| found.distance(expected) < 1e-4) {
                break;
            }
            assert!(begin.elapsed() < Duration::from_secs(20), "{found:?} instead of {expected}");
        }
    }
    twin.with(|state| state.buttons = 0b101);
    let begin = Instant::now();
    while device.buttons() != 0b101 {
        std::thread::sleep(Duration::from_millis(5));
        device.position(begin.elapsed().as_secs_f64());
        assert!(begin.elapsed() < Duration::from_secs(20), "no buttons");
    }
}

#[test]
fn force_of_the_room_is_torque_of_the_legs() {
    let twin = FalconTwin::default();
    let mut device = device(&twin);
    let begin = Instant::now();
    // up in the room is y of the device
    let expected = torques_nm(MIDDLE_M, DVec3::new(0.0, 2.0, 0.0)).unwrap().map(|torque| -10_000.0 * torque);
    loop {
        std::thread::sleep(Duration::from_millis(2));
        device.position(begin.elapsed().as_secs_f64());
        device.set_force(Vec3::new(0.0, 0.0, 2.0));
        let motors = twin.motors();
        // the grip stands where the encoders' whole counts put it, not quite in the middle: within a per cent of the largest
        if motors.iter().zip(expected).all(|(&motor, expected)| (f64::from(motor) - expected).abs() < 12.0) {
            break;
        }
        assert!(begin.elapsed() < Duration::from_secs(20), "{motors:?} instead of {expected:?}");
    }
    device.close();
    assert_eq!(twin.motors(), [0; 3], "left with force");
}

#[test]
fn clay_pushes_the_grip_and_letting_go_takes_the_force_away() {
    let twin = FalconTwin::default();
    let mut session = session(&twin, FalconSettings::default());
    press(&mut session, &twin);
    let motors = twin.motors().map(f64::from);
    // towards the person, z: work of the torques in the direction of the force is positive
    let towards = torques_nm(PRESSED.as_dvec3(), DVec3::Z).unwrap().map(|torque| -torque);
    assert!(DVec3::from_array(motors).dot(DVec3::from_array(towards)) > 0.0, "{motors:?}");
    move_to(&mut session, &twin, PRESSED, FREE);
    session.until("the motors rest", |session| twin.motors() == [0; 3] && session.notice().is_none());
}

#[test]
fn falcon_without_firmware_gets_the_users_file_and_is_homed_before_any_force() {
    let firmware: Vec<u8> = (0..1000_u32).map(|byte| (byte * 7 + byte / 256) as u8).collect();
    let file = std::env::temp_dir().join(format!("falcon-firmware-{}", std::process::id()));
    std::fs::write(&file, &firmware).unwrap();
    let twin = FalconTwin::default();
    twin.with(|state| {
        state.firmware.clone_from(&firmware);
        (state.runs, state.homes_after) = (false, u32::MAX);
    });
    twin.hold_at(PRESSED);
    let settings = FalconSettings { firmware: Some(file.clone()), ..FalconSettings::default() };
    let mut session = session(&twin, settings);
    session.until("it asks to be homed", |session| session.notice().is_some_and(|said| said.contains("pull its grip")));
    session.pass(Duration::from_millis(200));
    assert_eq!(session.tool_m(), None, "a place without a zero");
    let (order, requests) = twin.with(|state| (state.flags, state.requests.clone()));
    assert_eq!(order, 0x8 | 0x1, "red, and homing");
    assert!(requests.contains(&(9, 16)) && requests.contains(&(3, 0x4138)) && requests.contains(&(3, 0x15)));
    assert_eq!(requests.iter().rfind(|(number, _)| *number == 9), Some(&(9, 1)));
    twin.with(|state| state.homes_after = 5);
    session.until("the tool is in hand", |session| session.tool_m().is_some() && session.notice().is_none());
    assert_eq!(twin.with(|state| state.unhomed_motor_max), 0, "a motor moved before its zero was known");
    std::fs::remove_file(file).unwrap();
}

#[test]
fn firmware_that_is_not_there_or_not_echoed_is_one_sentence() {
    let twin = FalconTwin::default();
    twin.with(|state| (state.runs, state.firmware, state.trouble) = (false, vec![1; 200], Trouble::WrongEcho));
    let mut no_file = session(&twin, FalconSettings::default());
    no_file
        .until("it asks for a file", |session| session.notice().is_some_and(|said| said.contains("falcon:firmware=")));
    drop(no_file);
    let file = std::env::temp_dir().join(format!("falcon-echo-{}", std::process::id()));
    std::fs::write(&file, [1; 200]).unwrap();
    let settings = FalconSettings { firmware: Some(file.clone()), ..FalconSettings::default() };
    let mut wrong = session(&twin, settings);
    wrong.until("it names the byte", |session| session.notice().is_some_and(|said| said.contains("byte 99")));
    wrong.tick();
    assert_eq!(wrong.tool_m(), None);
    twin.with(|state| state.trouble = Trouble::None);
    wrong.until("it works in the end", |session| session.tool_m().is_some() && session.notice().is_none());
    std::fs::remove_file(file).unwrap();
}

/// Has a Falcon go wrong in mid-press, in so many ticks at most, and looks whether its motors rest.
fn fails(most_ticks: u32, said: &str, mut goes: impl FnMut(&FalconTwin, bool)) {
    let twin = FalconTwin::default();
    let mut session = session(&twin, FalconSettings::default());
    let press = |session: &mut HandSession| {
        press(session, &twin);
        session.until("the clay is felt", |session| session.force_n() > 0.1 && session.tool_m().is_some());
    };
    session.loses_force(most_ticks, said, press, |is_wrong| {
        if !is_wrong {
            let begin = Instant::now();
            while twin.motors() != [0; 3] {
                assert!(begin.elapsed() < Duration::from_secs(20), "{said}: the motors go on: {:?}", twin.motors());
                std::thread::sleep(Duration::from_millis(1));
            }
            twin.hold_at(FREE);
        }
        goes(&twin, is_wrong);
    });
}

#[test]
fn falcon_pulled_out_in_mid_press_has_no_force_within_two_ticks_and_comes_back() {
    fails(2, "plug it in", |twin, is_out| if is_out { twin.unplug() } else { twin.plug() });
}

#[test]
fn falcon_that_breaks_its_protocol_loses_its_force_and_is_heard_again_afterwards() {
    // a leg that cannot be is known at once; bytes that are no packet are when nothing else comes: one exchange before, three that are
    // due and two ticks; so is one that answers late
    for (trouble, most_ticks, said) in [
        (Trouble::Impossible, 2, "encoders"),
        (Trouble::Noise, 7, "packets"),
        (Trouble::Silent, 7, "not answered"),
        (Trouble::Late(200), 7, "not answered"),
        (Trouble::Late(30), 7, "late again and again"),
    ] {
        fails(most_ticks, said, |twin, is_wrong| {
            twin.with(|state| state.trouble = if is_wrong { trouble } else { Trouble::None });
        });
    }
}

#[test]
fn of_two_falcons_the_one_of_that_number_is_felt_and_the_other_left_alone() {
    let twins = [FalconTwin::default(), FalconTwin::default()];
    let driver = |number| {
        let settings = FalconSettings { number, ..FalconSettings::default() };
        FalconDriver::new(FalconBus::of(&twins), settings)
    };
    assert_eq!(driver(1).probe().unwrap(), "Novint Falcon 1 (of 2: another with --device falcon:number=0)");
    let missing = driver(2).probe().unwrap_err().to_string();
    assert!(missing.contains("no number 2 among 2") && !missing.contains('\n'), "{missing}");
    let mut session = HandSession::new(driver(1), calibration(), kind());
    twins[0].hold_at(FREE + Vec3::X * 0.03);
    press(&mut session, &twins[1]);
    assert_eq!(session.monitor().about().as_deref(), Some("Novint Falcon 1 of 2"));
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    assert!(session.tool_m().unwrap().x.abs() < 0.005, "{:?}", session.tool_m());
    assert_eq!((twins[0].motors(), twins[0].with(|state| state.requests.len())), ([0; 3], 0));
    // the other one is pulled out, and what is in the hand stays; pulled out as well, it is of no number until both are back
    twins[0].unplug();
    session.pass(Duration::from_millis(100));
    session.until("it is still felt", |session| session.notice().is_none() && twins[1].motors() != [0; 3]);
    twins[1].unplug();
    session.until("none is there", |session| session.notice().is_some_and(|said| said.contains("nothing on USB")));
    twins[1].hold_at(FREE);
    twins[1].plug();
    session.until("it is said", |session| session.notice().is_some_and(|said| said.contains("no number 1 among 1")));
    assert_eq!(session.tool_m(), None);
    twins[0].plug();
    session.until("it is back", |session| session.tool_m().is_some() && session.notice().is_none());
}

#[test]
fn hand_that_stops_ticking_leaves_no_force_behind() {
    let twin = FalconTwin::default();
    let mut session = session(&twin, FalconSettings::default());
    press(&mut session, &twin);
    let begin = Instant::now();
    while twin.motors() != [0; 3] {
        assert!(begin.elapsed() < Duration::from_secs(20), "the motors go on: {:?}", twin.motors());
        std::thread::sleep(Duration::from_millis(5));
    }
}
