//! The gamepad's driver against a scripted pad: where the sticks take the tool, what the motors do, and pulling it out.
//!
//! No gamepad was at hand: how Linux names a pad's sticks and motors is left to the `evdev` crate and not tested here.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::{Arc, Mutex};
use std::time::Duration;

use glam::{Vec2, Vec3};
use pottery_client::device::gamepad::{GamepadDriver, MIDDLE_M, Pad, Pads, Sticks};
use pottery_client::device::{Axes, Calibration, DeviceFault, MIDDLE_ROOM_M};
use pottery_shared::haptics::DeviceSpecs;
use pottery_tests::twin::HandSession;

/// A pad in the test's hands; clones are the same one.
#[derive(Clone, Debug, Default)]
struct Scripted(Arc<Mutex<State>>);

#[derive(Debug, Default)]
struct State {
    unplugged: bool,
    has_no_motors: bool,
    sticks: Sticks,
    hum: (f32, f32),
}

impl Scripted {
    fn show(&self, sticks: Sticks) {
        self.0.lock().unwrap().sticks = sticks;
    }

    fn hum(&self) -> (f32, f32) {
        self.0.lock().unwrap().hum
    }
}

impl Pads for Scripted {
    fn names(&mut self) -> Vec<String> {
        if self.0.lock().unwrap().unplugged { Vec::new() } else { vec!["scripted pad".into()] }
    }

    fn open(&mut self, _: usize) -> Result<Box<dyn Pad>, DeviceFault> {
        Ok(Box::new(self.clone()))
    }
}

impl Pad for Scripted {
    fn sticks(&mut self) -> Result<Sticks, DeviceFault> {
        let state = self.0.lock().unwrap();
        if state.unplugged {
            return Err(DeviceFault::Gone { device: "gamepad", reason: "pulled out".into() });
        }
        Ok(state.sticks)
    }

    fn has_motors(&self) -> bool {
        !self.0.lock().unwrap().has_no_motors
    }

    fn hum(&mut self, heavy: f32, light: f32) -> Result<(), DeviceFault> {
        self.0.lock().unwrap().hum = (heavy, light);
        Ok(())
    }
}

fn session(pad: &Scripted) -> HandSession {
    let calibration = Calibration::new(Axes::YUp, MIDDLE_M);
    HandSession::new(GamepadDriver::new(pad.clone(), 0), calibration, DeviceSpecs::MOUSE)
}

const PULLED: Sticks = Sticks { left: Vec2::ZERO, right: Vec2::ZERO, trigger: 1.0, buttons: 0 };

#[test]
fn a_pad_without_motors_says_so() {
    let about = |has_no_motors| {
        let pad = Scripted::default();
        pad.0.lock().unwrap().has_no_motors = has_no_motors;
        let mut session = session(&pad);
        session.until("the pad is found", |session| session.monitor().about().is_some());
        session.monitor().about().unwrap()
    };
    assert_eq!(about(false), "scripted pad");
    assert_eq!(about(true), "scripted pad, without motors");
}

#[test]
fn sticks_move_the_tool_to_the_side_and_up_and_towards_the_pot() {
    for (sticks, room) in [
        (Sticks { left: Vec2::X, ..Sticks::default() }, Vec3::X),
        (Sticks { left: Vec2::Y, ..Sticks::default() }, Vec3::Z),
        (Sticks { right: Vec2::NEG_Y, ..Sticks::default() }, Vec3::NEG_Y),
    ] {
        let pad = Scripted::default();
        let mut session = session(&pad);
        session.until("the tool is in hand", |session| session.tool_m().is_some_and(|tool| tool != Vec3::ZERO));
        let from = session.tool_m().unwrap();
        assert!(from.distance(MIDDLE_ROOM_M) < 0.03, "{from}");
        pad.show(sticks);
        session.until("it has gone 20 mm", |session| (session.tool_m().unwrap() - from).dot(room) > 0.02);
        let moved = session.tool_m().unwrap() - from;
        // positions are rounded to 10 µm
        assert!(moved.reject_from(room).length() < 3e-5, "{moved}");
    }
}

#[test]
fn trigger_presses_and_the_motors_follow_the_force() {
    let pad = Scripted::default();
    let mut session = session(&pad);
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    assert_eq!(pad.hum(), (0.0, 0.0));
    pad.show(PULLED);
    session.until("the clay pushes and the pad hums", |session| session.force_n() > 0.2 && pad.hum().0 > 0.03);
    // the pot stands still: only a tool that goes along it rubs
    session.until("the light motor rests", |_| pad.hum().1 == 0.0 && pad.hum().0 > 0.03);
    pad.show(Sticks { left: Vec2::Y, ..PULLED });
    session.until("it hums with the slip", |_| pad.hum().1 > 0.03);
    pad.show(Sticks::default());
    session.until("it is quiet", |session| session.force_n() == 0.0 && pad.hum() == (0.0, 0.0));
}

#[test]
fn pad_pulled_out_in_mid_press_leaves_the_session_and_comes_back() {
    let pad = Scripted::default();
    let mut session = session(&pad);
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    pad.show(PULLED);
    session.until("the clay pushes", |session| session.force_n() > 0.1);
    pad.0.lock().unwrap().unplugged = true;
    session.until("the force is off", |session| session.force_n() == 0.0 && session.tool_m().is_none());
    session.until("it is said", |session| session.notice().is_some_and(|said| said.contains("plug it in")));
    pad.show(Sticks::default());
    pad.0.lock().unwrap().unplugged = false;
    session.until("it is back", |session| session.tool_m().is_some() && session.notice().is_none());
    drop(session);
    assert_eq!(pad.hum(), (0.0, 0.0), "left humming");
}

#[test]
fn sticks_that_are_no_numbers_move_nothing() {
    let pad = Scripted::default();
    let mut session = session(&pad);
    session.until("the tool is in hand", |session| session.tool_m().is_some_and(|tool| tool != Vec3::ZERO));
    let before = session.tool_m();
    pad.show(Sticks { left: Vec2::NAN, right: Vec2::NAN, trigger: f32::NAN, buttons: 0 });
    session.pass(Duration::from_millis(100));
    assert_eq!(session.tool_m(), before);
    assert_eq!(session.fault(), None);
}
