//! Gamepads as Linux shows them, from the kernel's events to where the tool goes, and the motors from the force to what the kernel is told.
//!
//! Each test runs itself anew in a process that has pads of `tests/src/twin/evdev.c` in `/dev/input`: no hardware, no root, and the
//! program's own way to a pad, its crate included.

#![cfg(target_os = "linux")]

use std::process::Command;
use std::time::Duration;

use glam::{Vec2, Vec3};
use pottery_client::device::gamepad::{GamepadDriver, MIDDLE_M, Pad, Pads, Sticks, SystemPads};
use pottery_client::device::{Axes, Calibration};
use pottery_shared::haptics::DeviceSpecs;
use pottery_tests::programs::program;
use pottery_tests::twin::HandSession;
use pottery_tests::twin::evdev::{
    ABS_GAS, ABS_RX, ABS_RY, ABS_RZ, ABS_X, ABS_Y, ABS_Z, Axis, BTN_SOUTH, BTN_TR2, BTN_WEST, EV_ABS, EV_KEY, EV_SYN,
    EvdevTwin, SYN_DROPPED, SYN_REPORT,
};

fn opened(number: usize) -> Box<dyn Pad> {
    SystemPads.open(number).expect("it is plugged in")
}

fn shown(pad: &mut dyn Pad) -> Sticks {
    pad.sticks().expect("it is plugged in")
}

fn session(number: usize) -> HandSession {
    HandSession::new(GamepadDriver::new(SystemPads, number), Calibration::new(Axes::YUp, MIDDLE_M), DeviceSpecs::MOUSE)
}

/// Whether the tool is in hand and not only on its way there.
fn is_held(session: &HandSession) -> bool {
    session.tool_m().is_some_and(|tool_m| tool_m != Vec3::ZERO)
}

/// A stick in its middle, as it is where a byte says it.
const MIDDLE: Axis = Axis { value: 128, ends: (0, 255), flat: 15 };
const RELEASED: Axis = Axis { value: 0, ends: (0, 255), flat: 0 };

#[test]
fn sticks_trigger_and_buttons_are_what_the_kernel_says() {
    let test = "sticks_trigger_and_buttons_are_what_the_kernel_says";
    let Some(twin) = EvdevTwin::of(test, &["pad"]) else { return };
    let mut pad = opened(0);
    assert_eq!(shown(pad.as_mut()), Sticks::default());
    // where they are counts from the beginning, and not only when they move
    twin.say(0, EV_ABS, ABS_X, 32767, true);
    assert_eq!(shown(opened(0).as_mut()).left, Vec2::X);
    twin.say(0, EV_ABS, ABS_X, 0, true);
    // right and down are the kernel's positive, right and up ours
    for (code, value, expected) in [
        (ABS_X, 32767, Sticks { left: Vec2::X, ..Sticks::default() }),
        (ABS_X, -32768, Sticks { left: Vec2::NEG_X, ..Sticks::default() }),
        (ABS_Y, 32767, Sticks { left: Vec2::NEG_Y, ..Sticks::default() }),
        (ABS_RX, 32767, Sticks { right: Vec2::X, ..Sticks::default() }),
        (ABS_RY, -32768, Sticks { right: Vec2::Y, ..Sticks::default() }),
        (ABS_RZ, 255, Sticks { trigger: 1.0, ..Sticks::default() }),
        (ABS_RZ, 51, Sticks { trigger: 0.2, ..Sticks::default() }),
        // the left one does nothing, and what lies beyond the range is its end
        (ABS_Z, 255, Sticks::default()),
        (ABS_X, 70_000, Sticks { left: Vec2::X, ..Sticks::default() }),
    ] {
        twin.moves(0, EV_ABS, code, value);
        let found = shown(pad.as_mut());
        assert!((found.left - expected.left).length() < 1e-6, "{code} = {value}: {found:?}");
        assert!((found.right - expected.right).length() < 1e-6, "{code} = {value}: {found:?}");
        assert!((found.trigger - expected.trigger).abs() < 1e-6, "{code} = {value}: {found:?}");
        twin.moves(0, EV_ABS, code, 0);
    }
    twin.moves(0, EV_KEY, BTN_SOUTH, 1);
    twin.moves(0, EV_KEY, BTN_WEST, 1);
    assert_eq!(shown(pad.as_mut()).buttons, 0b1001);
    twin.moves(0, EV_KEY, BTN_SOUTH, 0);
    assert_eq!(shown(pad.as_mut()).buttons, 0b1000);
}

#[test]
fn a_stick_that_rests_off_its_middle_shows_nothing_within_what_the_kernel_allows_it() {
    let test = "a_stick_that_rests_off_its_middle_shows_nothing_within_what_the_kernel_allows_it";
    let Some(twin) = EvdevTwin::of(test, &["pad"]) else { return };
    twin.have(0, ABS_X, Some(Axis { value: 7900, ends: (-32768, 32767), flat: 8000 }));
    // one that has one end is none
    twin.have(0, ABS_Y, Some(Axis { value: 5, ends: (5, 5), flat: 0 }));
    let mut pad = opened(0);
    assert_eq!(shown(pad.as_mut()), Sticks::default());
    twin.moves(0, EV_ABS, ABS_Y, 17);
    twin.moves(0, EV_ABS, ABS_X, -7900);
    assert_eq!(shown(pad.as_mut()), Sticks::default());
    twin.moves(0, EV_ABS, ABS_X, 8100);
    let found = shown(pad.as_mut());
    assert!((found.left.x - 0.247).abs() < 1e-3 && found.left.y == 0.0, "{found:?}");
    drop(pad);
    twin.moves(0, EV_ABS, ABS_X, 7900);
    let mut session = session(0);
    session.until("the tool is in hand", is_held);
    let rests = session.tool_m();
    session.pass(Duration::from_millis(200));
    session.until("the tool is in hand", is_held);
    assert_eq!(session.tool_m(), rests, "it drifts");
}

#[test]
fn right_stick_and_trigger_are_found_whatever_axes_a_driver_has_for_them() {
    let test = "right_stick_and_trigger_are_found_whatever_axes_a_driver_has_for_them";
    let Some(twin) = EvdevTwin::of(test, &["pad"]) else { return };
    let none = [ABS_Z, ABS_RX, ABS_RY, ABS_RZ].map(|code| (code, None));
    let with = |axes: &[(u16, Axis)]| {
        none.iter().for_each(|(code, axis)| twin.have(0, *code, *axis));
        twin.have(0, ABS_GAS, None);
        axes.iter().for_each(|(code, axis)| twin.have(0, *code, Some(*axis)));
        let mut pad = opened(0);
        // at rest nothing pushes the tool into the clay
        assert_eq!(shown(pad.as_mut()), Sticks::default(), "{axes:?}");
        pad
    };
    // a stick on Z and RZ: beside triggers of their own, beside none, and beside those that rest at their ends
    let sticks = [(ABS_Z, MIDDLE), (ABS_RZ, MIDDLE)];
    for (others, trigger) in [
        (vec![(ABS_GAS, RELEASED)], (EV_ABS, ABS_GAS, 255)),
        (vec![], (EV_KEY, BTN_TR2, 1)),
        (vec![(ABS_RX, RELEASED), (ABS_RY, RELEASED)], (EV_ABS, ABS_RY, 255)),
    ] {
        let mut pad = with(&[&sticks[..], &others].concat());
        twin.moves(0, EV_ABS, ABS_RZ, 0);
        assert_eq!(shown(pad.as_mut()), Sticks { right: Vec2::Y, ..Sticks::default() }, "{others:?}");
        twin.moves(0, EV_ABS, ABS_RZ, 128);
        let (kind, code, value) = trigger;
        twin.moves(0, kind, code, value);
        assert_eq!(shown(pad.as_mut()), Sticks { trigger: 1.0, ..Sticks::default() }, "{others:?}");
        twin.moves(0, kind, code, 0);
    }
    // neither, and a trigger without a second stick
    with(&[]);
    let mut pad = with(&[(ABS_RZ, RELEASED)]);
    twin.moves(0, EV_ABS, ABS_RZ, 255);
    assert_eq!(shown(pad.as_mut()), Sticks { trigger: 1.0, ..Sticks::default() });
}

#[test]
fn what_was_lost_on_the_way_is_asked_for_anew() {
    let Some(twin) = EvdevTwin::of("what_was_lost_on_the_way_is_asked_for_anew", &["pad"]) else { return };
    let mut pad = opened(0);
    twin.moves(0, EV_ABS, ABS_X, 32767);
    twin.moves(0, EV_KEY, BTN_SOUTH, 1);
    assert_eq!(shown(pad.as_mut()), Sticks { left: Vec2::X, buttons: 1, ..Sticks::default() });
    // the stick is let go and the button as well, and nobody hears of it but by what was lost
    twin.say(0, EV_ABS, ABS_X, 0, true);
    twin.say(0, EV_KEY, BTN_SOUTH, 0, true);
    twin.say(0, EV_ABS, ABS_RZ, 255, true);
    assert_eq!(shown(pad.as_mut()).left, Vec2::X);
    twin.say(0, EV_SYN, SYN_DROPPED, 0, false);
    // what is heard of a report after that is old
    twin.say(0, EV_ABS, ABS_RY, -32768, false);
    twin.say(0, EV_ABS, ABS_RY, 0, true);
    twin.say(0, EV_SYN, SYN_REPORT, 0, false);
    assert_eq!(shown(pad.as_mut()), Sticks { trigger: 1.0, ..Sticks::default() });
    twin.moves(0, EV_ABS, ABS_X, -32768);
    assert_eq!(shown(pad.as_mut()), Sticks { left: Vec2::NEG_X, trigger: 1.0, ..Sticks::default() });
}

#[test]
fn motors_are_told_how_strong_and_stop_by_themselves() {
    let Some(twin) = EvdevTwin::of("motors_are_told_how_strong_and_stop_by_themselves", &["pad"]) else { return };
    let mut pad = opened(0);
    assert!(pad.has_motors());
    pad.hum(0.5, 2.0).expect("it is plugged in");
    let told = twin.motors(0);
    assert_eq!((told.heavy, told.light, told.plays, told.uploads), (32767, 65535, true, 1));
    assert!((1000..=60_000).contains(&told.length_ms), "{told:?}");
    pad.hum(0.0, f32::NAN).expect("it is plugged in");
    let told = twin.motors(0);
    assert_eq!((told.heavy, told.light, told.uploads, told.is_erased), (0, 0, 2, false));
    drop(pad);
    assert!(twin.motors(0).is_erased && !twin.motors(0).plays, "left humming");
    // one that may not be written to is still a pad
    twin.plug(0, true, true, true);
    let mut pad = opened(0);
    pad.hum(1.0, 1.0).expect("a pad that may be read");
    assert!(!pad.has_motors() && twin.motors(0).uploads == 2);
    twin.moves(0, EV_ABS, ABS_X, 32767);
    assert_eq!(shown(pad.as_mut()).left, Vec2::X);
    twin.plug(0, true, false, false);
    assert!(!opened(0).has_motors());
}

#[test]
fn a_press_hums_and_a_pad_that_is_pulled_out_in_its_midst_comes_back() {
    let test = "a_press_hums_and_a_pad_that_is_pulled_out_in_its_midst_comes_back";
    let Some(twin) = EvdevTwin::of(test, &["pad"]) else { return };
    let mut session = session(0);
    for _ in 0..2 {
        session.until("the tool is in hand", |session| session.tool_m().is_some());
        twin.moves(0, EV_ABS, ABS_RZ, 255);
        session.until("the clay pushes and the pad hums", |session| {
            session.force_n() > 0.2 && twin.motors(0).heavy > 2000 && twin.motors(0).plays
        });
        twin.plug(0, false, true, false);
        session.until("the force is off", |session| session.force_n() == 0.0 && session.tool_m().is_none());
        session.until("it is said", |session| session.notice().is_some_and(|said| said.contains("plug it in")));
        twin.say(0, EV_ABS, ABS_RZ, 0, true);
        twin.plug(0, true, true, false);
        session.until("it is back", |session| session.tool_m().is_some() && session.notice().is_none());
    }
    twin.moves(0, EV_ABS, ABS_RZ, 255);
    session.until("it hums", |_| twin.motors(0).heavy > 2000 && twin.motors(0).plays);
    drop(session);
    assert!(twin.motors(0).is_erased && !twin.motors(0).plays, "left humming");
}

#[test]
fn of_two_pads_the_one_that_is_chosen_is_held_and_the_studio_says_how_to_choose_the_other() {
    let test = "of_two_pads_the_one_that_is_chosen_is_held_and_the_studio_says_how_to_choose_the_other";
    let Some(twin) = EvdevTwin::of(test, &["first pad", "second pad"]) else { return };
    let mut session = session(1);
    session.until("the tool is in hand", is_held);
    assert_eq!(session.monitor().about().as_deref(), Some("second pad"));
    let rests = session.tool_m();
    twin.moves(0, EV_ABS, ABS_X, 32767);
    session.pass(Duration::from_millis(100));
    session.until("the tool is in hand", is_held);
    assert_eq!(session.tool_m(), rests, "the other pad moves it");
    twin.moves(1, EV_ABS, ABS_X, 32767);
    session.until("its own moves it", |session| session.tool_m() != rests);
    let listed = Command::new(program("pottery-studio")).arg("devices").output().expect("the studio was built");
    let listed = String::from_utf8_lossy(&listed.stdout).into_owned();
    let line = listed.lines().find(|line| line.starts_with("gamepad")).unwrap_or_default();
    assert!(
        line.ends_with("there      first pad (of 2: another with --device gamepad:number=1 (second pad))"),
        "{line}"
    );
    let missing = GamepadDriver::new(SystemPads, 2).probe().expect_err("there are two").to_string();
    assert!(missing.contains("no number 2 among 2") && !missing.contains('\n'), "{missing}");
}
