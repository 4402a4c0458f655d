//! The gamepad's driver against a scripted pad: where the sticks take the tool, what the motors do, and pulling it out.
//!
//! No gamepad was at hand. How Linux names a pad's sticks and motors is `device_gamepad_linux.rs`'s.

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

/// The pads that are plugged in, with their names.
struct Shelf(Vec<(&'static str, Scripted)>);

impl Shelf {
    fn plugged(&self) -> impl Iterator<Item = &(&'static str, Scripted)> {
        self.0.iter().filter(|(_, pad)| !pad.0.lock().unwrap().unplugged)
    }
}

impl Pads for Shelf {
    fn names(&mut self) -> Vec<String> {
        self.plugged().map(|(name, _)| (*name).to_owned()).collect()
    }

    fn open(&mut self, number: usize) -> Result<Box<dyn Pad>, DeviceFault> {
        let gone =
            || DeviceFault::Gone { device: "gamepad", reason: "the driver did not look how many there are".into() };
        Ok(Box::new(self.plugged().nth(number).ok_or_else(gone)?.1.clone()))
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
    let shelf = Shelf(vec![("scripted pad", pad.clone())]);
    HandSession::new(GamepadDriver::new(shelf, 0), calibration, DeviceSpecs::MOUSE)
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
fn of_two_pads_the_one_of_that_number_hums_and_the_other_is_left_alone() {
    let pads = [Scripted::default(), Scripted::default()];
    let driver = |number| {
        let shelf = Shelf(["one", "two"].into_iter().zip(pads.clone()).collect());
        GamepadDriver::new(shelf, number)
    };
    assert_eq!(driver(0).probe().unwrap(), "one (of 2: another with --device gamepad:number=1 (two))");
    assert_eq!(driver(1).probe().unwrap(), "two (of 2: another with --device gamepad:number=0 (one))");
    let missing = driver(2).probe().unwrap_err().to_string();
    assert!(missing.contains("no number 2 among 2") && !missing.contains('\n'), "{missing}");
    let mut session = HandSession::new(driver(1), Calibration::new(Axes::YUp, MIDDLE_M), DeviceSpecs::MOUSE);
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    assert_eq!(session.monitor().about().as_deref(), Some("two"));
    pads[0].show(Sticks { left: Vec2::X, ..PULLED });
    pads[1].show(PULLED);
    session.until("the clay pushes and the pad hums", |session| session.force_n() > 0.2 && pads[1].hum().0 > 0.03);
    assert_eq!(pads[0].hum(), (0.0, 0.0));
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    assert!(session.tool_m().unwrap().x.abs() < 1e-3, "{:?}", session.tool_m());
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
        // where a busy machine holds the driver up there is no tool for a while
        session.until("it has gone 20 mm", |session| {
            session.tool_m().is_some_and(|tool_m| (tool_m - from).dot(room) > 0.02)
        });
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
fn pad_pulled_out_in_mid_press_loses_its_force_within_two_ticks_and_comes_back() {
    let pad = Scripted::default();
    let mut session = session(&pad);
    let press = |session: &mut HandSession| {
        pad.show(PULLED);
        session.until("the clay pushes", |session| session.force_n() > 0.1 && session.tool_m().is_some());
    };
    session.loses_force(2, "plug it in", press, |is_out| {
        if !is_out {
            pad.show(Sticks::default());
        }
        pad.0.lock().unwrap().unplugged = is_out;
    });
    press(&mut session);
    session.until("it hums", |_| pad.hum().0 > 0.03);
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
    session.until("the tool is in hand", |session| session.tool_m().is_some());
    assert_eq!(session.tool_m(), before);
    assert_eq!(session.fault(), None);
}
