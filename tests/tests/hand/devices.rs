//! Devices by name: what can be asked for, what is said when it cannot be had, and a session with one from start to end.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeSet;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::{
    Axes, Calibration, Device, DeviceChoice, DeviceFault, DrivenDevice, Driver, Limits, MIDDLE_ROOM_M, Pace, Pointer,
    Port, Reading, Reported, inverse3, pointer,
};
use pottery_client::stroke::Stroke;
use pottery_shared::haptics::{DeviceSpecs, Haptics, Setup};
use pottery_shared::units::Seconds;
use pottery_tests::programs::{folder, program};
use pottery_tests::twin::HandSession;
use pottery_tests::twin::haply::HaplyTwin;

fn stroke() -> Arc<Stroke> {
    Arc::new(Stroke::parse("t_s,x_mm,y_mm,z_mm\n0,90,0,50\n1,70,0,50\n").unwrap())
}

fn opened(text: &str) -> Box<dyn Device> {
    text.parse::<DeviceChoice>().unwrap().open(pointer().1, &stroke()).unwrap().device
}

#[test]
fn every_device_can_be_named_and_nonsense_is_refused_with_what_may_be() {
    for name in ["mouse", "gamepad", "inverse3", "openhaptics", "falcon", "simulated"] {
        assert_eq!(name.parse::<DeviceChoice>().unwrap().name(), name);
    }
    for (text, said) in [
        ("broom", "mouse, gamepad, inverse3, openhaptics, falcon, simulated, replay"),
        ("", "choose one of"),
        ("mouse:left=1", "knows none"),
        ("falcon:colour=red", "firmware"),
        ("falcon:number=-1", "whole number"),
        ("falcon:firmware", "KEY=VALUE"),
        ("falcon:scale=0", "from 0.1 to 10"),
        ("falcon:scale=nan", "from 0.1 to 10"),
        ("falcon:specs=broom", "omega.3"),
        ("openhaptics:peak=0", "from 0.01"),
        ("simulated:mass=0", "from 0.01"),
        ("simulated:delay=21", "from 0 to 20"),
        ("simulated:delay=-1", "from 0 to 20"),
        ("simulated:specs=broom", "omega.3"),
        ("simulated:peak=0", "from 0.01"),
        ("replay", "file=FILE"),
        ("replay:file=no-such.csv", "no-such.csv"),
    ] {
        let refused = text.parse::<DeviceChoice>().unwrap_err().to_string();
        assert!(refused.contains(said) && !refused.contains('\n'), "{text}: {refused}");
    }
}

#[test]
fn parameters_reach_the_device() {
    // nothing listens there: the device is waited for, with what is known of its kind
    let limits = |text: &str| opened(&format!("inverse3:address=127.0.0.1:9,{text}")).specs();
    let touch = DeviceSpecs::preset("touch").unwrap().specs;
    assert_eq!(limits("id=049D"), touch);
    assert_eq!(limits("peak=1.5,stiffness=200").peak_force_n, 1.5);
    assert_eq!(limits("peak=1.5,stiffness=200").stiffness_max_n_m, 200.0);
    // a person may want less than the device can, not more
    assert_eq!(limits("peak=50").peak_force_n, touch.peak_force_n);
    let scaled = limits("scale=2,stiffness=200");
    assert_eq!((scaled.stiffness_max_n_m, scaled.workspace_radius_m), (100.0, 2.0 * touch.workspace_radius_m));
    let mut steps = BTreeSet::new();
    let mut simulated = opened("simulated:resolution_mm=0.5");
    for tick in 0..500 {
        let place_m = simulated.position(f64::from(tick) * 1e-3).unwrap();
        steps.insert((place_m.x * 2000.0).round() as i32);
        assert!((place_m.x * 2000.0 - (place_m.x * 2000.0).round()).abs() < 1e-3, "{place_m}");
    }
    assert!(steps.len() > 5, "{steps:?}");
}

#[test]
fn a_device_with_a_driver_says_how_late_its_force_comes_and_the_coupling_is_tuned_to_it() {
    // none of them is there, which is no matter for what it would be
    for (choice, delay_ms) in [
        ("gamepad:number=99", 0.0),
        ("openhaptics:lib=/nonexistent,specs=omni", 2.0),
        ("inverse3:address=127.0.0.1:1", 2.5),
        ("falcon:number=99", 3.0),
    ] {
        let setup = opened(choice).setup(0.2);
        assert!((setup.delay.0 * 1e3 - delay_ms).abs() < 1e-4, "{choice}: {:?}", setup.delay);
        let (specs, coupling) = (setup.specs, Haptics::new(setup).coupling());
        // Colgate and Schenkel with delay, for the device in a hand that damps by 1 N·s/m
        let needed = coupling.stiffness_n_m * (0.5e-3 + setup.delay.0) + coupling.damping_ns_m;
        assert!(specs.damping_ns_m + 1.0 > needed, "{choice}: {coupling:?}");
        let in_no_time = Haptics::new(Setup { delay: Seconds(0.0), ..setup }).coupling();
        assert_eq!(coupling == in_no_time, delay_ms == 0.0, "{choice}: {coupling:?}");
    }
}

/// A device that is held in the wall until it is pulled out, and knows when it was.
#[derive(Clone, Debug, Default)]
struct Fickle {
    is_out: Arc<AtomicBool>,
    has_gone: Arc<AtomicBool>,
}

impl Driver for Fickle {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        port.found("fickle".into(), Reported::default());
        let mut pace = Pace::new();
        while !port.is_closing() {
            let is_out = self.is_out.load(Ordering::Relaxed);
            self.has_gone.store(is_out, Ordering::Release);
            if is_out {
                return Err(DeviceFault::Gone { device: "fickle device", reason: "it was pulled out".into() });
            }
            port.publish(Reading { position_m: Vec3::new(0.067, 0.0, 0.1), velocity_m_s: None, buttons: 0 });
            pace.wait();
        }
        Ok(())
    }
}

#[test]
fn a_device_that_goes_in_mid_press_has_no_force_within_two_ticks_of_its_fault() {
    let device = Fickle::default();
    // the device's frame is the room's
    let calibration = Calibration::new(Axes::ZUp, MIDDLE_ROOM_M);
    let mut session = HandSession::new(device.clone(), calibration, DeviceSpecs::OMNI);
    let press = |session: &mut HandSession| {
        session.until("the clay pushes", |session| session.force_n() > 0.1 && session.tool_m().is_some());
    };
    session.loses_force(2, "pulled out", press, |is_out| {
        device.is_out.store(is_out, Ordering::Relaxed);
        // the fault, from which on ticks are counted; the sentence comes later
        while is_out && !device.has_gone.load(Ordering::Acquire) {
            std::thread::yield_now();
        }
    });
}

/// A device that says of itself what the test wants and is held where the test wants, m in the room; `None` while it is out.
type Plug = Arc<Mutex<Option<(Reported, Vec3)>>>;

struct Plugged(Plug);

impl Driver for Plugged {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        let gone = || DeviceFault::Gone { device: "scripted device", reason: "it was pulled out".into() };
        let look = |plug: &Plug| plug.lock().unwrap().ok_or_else(gone);
        port.found("scripted".into(), look(&self.0)?.0);
        let mut pace = Pace::new();
        while !port.is_closing() {
            let (_, position_m) = look(&self.0)?;
            port.publish(Reading { position_m, velocity_m_s: None, buttons: 0 });
            pace.wait();
        }
        Ok(())
    }
}

const AIR_M: Vec3 = Vec3::new(0.095, 0.0, 0.1);
const CLAY_M: Vec3 = Vec3::new(0.065, 0.0, 0.1);

fn reported(peak_n: f32, stiffness_n_m: f32) -> Reported {
    Reported { peak_force_n: Some(peak_n), stiffness_max_n_m: Some(stiffness_n_m), ..Reported::default() }
}

#[test]
fn each_device_that_is_plugged_in_has_its_own_limits_and_the_chain_is_tuned_to_them() {
    let plug: Plug = Arc::default();
    let calibration = Calibration::new(Axes::ZUp, MIDDLE_ROOM_M).scaled(2.0).unwrap();
    let (mut window, mouse) = pointer();
    window.write(Pointer { target_m: Some(AIR_M), ..Pointer::default() });
    let mut device = DrivenDevice::open(Plugged(Arc::clone(&plug)), calibration, DeviceSpecs::OMNI, mouse).unwrap();
    let begin = Instant::now();
    let mut until = |what: &str, holds: &dyn Fn(&DrivenDevice) -> bool| {
        let mut changes = 0;
        while !holds(&device) {
            assert!(begin.elapsed() < Duration::from_secs(30), "{what}: {:?}", device.specs());
            std::thread::sleep(Duration::from_millis(1));
            let place = device.position(begin.elapsed().as_secs_f64());
            let changed = device.is_another();
            // whose limits change has no place for a tick
            assert!(!(changed && place.is_some()), "{what}");
            changes += u32::from(changed);
        }
        (changes, device.setup(0.2))
    };
    let (_, mouses) = until("the mouse works", &|device| device.specs() == DeviceSpecs::MOUSE);
    // none of its own, and more of the clay
    assert!(mouses.delay.0 == 0.0 && mouses.yields_m_n > 0.0, "{mouses:?}");
    for (peak_n, stiffness_n_m) in [(0.5, 100.0), (2.0, 300.0)] {
        *plug.lock().unwrap() = Some((reported(peak_n, stiffness_n_m), MIDDLE_ROOM_M));
        // the tool goes twice as far as the hand, so that a newton a metre is half of one
        let is_it = |device: &DrivenDevice| device.specs().stiffness_max_n_m == stiffness_n_m / 2.0;
        let (changes, setup) = until("it is in hand", &is_it);
        assert!(changes > 0 && setup.specs.peak_force_n == peak_n, "{setup:?}");
        let coupling = Haptics::new(setup).coupling();
        assert!(coupling.stiffness_n_m <= stiffness_n_m / 2.0, "{coupling:?}");
        *plug.lock().unwrap() = None;
        until("the mouse works again", &|device| device.specs() == DeviceSpecs::MOUSE);
    }
}

#[test]
fn force_keeps_to_the_peak_of_the_device_that_is_there_and_begins_at_nothing() {
    let plug: Plug = Arc::default();
    let calibration = Calibration::new(Axes::ZUp, MIDDLE_ROOM_M);
    let mut session = HandSession::new(Plugged(Arc::clone(&plug)), calibration, DeviceSpecs::OMNI);
    // each deeper than the last, which has pressed the clay to where it was
    for (peak_n, wanted_n, deeper_m) in [(0.2, 0.18, 0.0), (3.0, 0.3, 4e-3), (0.2, 0.18, 8e-3)] {
        *plug.lock().unwrap() = Some((reported(peak_n, 700.0), CLAY_M - Vec3::X * deeper_m));
        let (mut most_n, mut first_n) = (0.0_f32, None);
        session.until("the clay pushes as hard as the device may, or harder than the last one might", |session| {
            let force_n = session.force_n();
            most_n = most_n.max(force_n);
            first_n = first_n.or(Some(force_n).filter(|force_n| *force_n > 0.0));
            assert!(force_n <= peak_n * (1.0 + 1e-6), "{force_n} N of {peak_n} N");
            force_n > wanted_n
        });
        // 100 N/s
        assert!(first_n.unwrap() < 0.1001, "{first_n:?} N of {most_n} N");
        *plug.lock().unwrap() = None;
        session.until("it has gone", |session| session.force_n() == 0.0 && session.notice().is_some());
    }
}

#[test]
fn limits_that_make_no_sense_are_refused_whichever_they_are() {
    let limits = Limits::from(DeviceSpecs::OMNI).at_most([Some(1.0), Some(100.0)]);
    for odd in [0.0, -1.0, f32::NAN, f32::INFINITY] {
        let none = Reported::default();
        for (figure, reported) in [
            ("peak", Reported { peak_force_n: Some(odd), ..none }),
            ("continuous", Reported { continuous_force_n: Some(odd), ..none }),
            ("stiffness", Reported { stiffness_max_n_m: Some(odd), ..none }),
            ("damping", Reported { damping_max_ns_m: Some(odd), ..none }),
        ] {
            // no damping is damping enough, and no force for long is more than the peak
            let makes_sense = (figure == "damping" && odd == 0.0) || (figure == "continuous" && odd == f32::INFINITY);
            assert_eq!(limits.of(reported).is_ok(), makes_sense, "{figure} = {odd}");
            // the person's wish holds whatever stands in
            let named = limits.named().of(reported).unwrap();
            assert_eq!((named.peak_force_n, named.stiffness_max_n_m), (1.0, 100.0), "{figure} = {odd}");
        }
    }
}

#[test]
fn replay_follows_its_file() {
    let out = folder("device-replay");
    let file = out.join("mine.csv");
    std::fs::write(&file, "t_s,x_mm,y_mm,z_mm\n0,90,0,50\n1,70,0,50\n").unwrap();
    let mut replay = opened(&format!("replay:file={}", file.display()));
    assert_eq!(replay.position(0.5), Some(Vec3::new(0.080, 0.0, 0.050)));
    assert_eq!(replay.position(1.5), None);
    std::fs::remove_dir_all(out).unwrap();
}

fn studio(arguments: &[&str]) -> Output {
    Command::new(program("pottery-studio")).args(arguments).output().unwrap()
}

#[test]
fn studio_lists_every_device_on_a_line_and_says_why_one_is_not_there() {
    let output = studio(&["devices"]);
    let text = String::from_utf8(output.stdout).unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines: Vec<&str> = text.lines().collect();
    let names = ["mouse", "gamepad", "inverse3", "openhaptics", "falcon", "simulated", "replay"];
    assert_eq!(lines.len(), names.len(), "{text}");
    for (line, name) in lines.iter().zip(names) {
        let said = line.strip_prefix(name).unwrap().trim_start();
        let why = said.strip_prefix("not there").or_else(|| said.strip_prefix("there")).unwrap().trim_start();
        assert!(why.len() > 10, "{line}");
    }
}

#[test]
fn studio_refuses_a_device_that_nobody_knows_and_a_mouse_without_a_window() {
    let output = studio(&["--device", "broom"]);
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("openhaptics"));
    let output = studio(&["--headless", "--device", "mouse"]);
    assert!(!output.status.success());
    assert!(String::from_utf8_lossy(&output.stderr).contains("window"));
}

#[test]
fn session_with_a_device_presses_clay_and_outlives_it() {
    let out = folder("device-session");
    let twin = HaplyTwin::start(inverse3::MIDDLE_M);
    let device = format!("inverse3:address={}", twin.address());
    let mut studio = Command::new(program("pottery-studio"))
        .args(["--headless", "--potters", "1", "--seconds", "8", "--device", &device, "--out"])
        .arg(&out)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    while twin.with(|state| state.messages) < 200 {
        assert!(studio.try_wait().unwrap().is_none(), "the studio ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    for step in 1..=200 {
        twin.hold_at(inverse3::MIDDLE_M + Vec3::Y * 0.034 * step as f32 / 200.0);
        std::thread::sleep(Duration::from_millis(2));
    }
    while twin.force_n() == Vec3::ZERO {
        assert!(studio.try_wait().unwrap().is_none(), "no force before the studio ended");
        std::thread::sleep(Duration::from_millis(5));
    }
    // the clay gives way in a time constant of 120 ms; then it is pulled out in mid press
    std::thread::sleep(Duration::from_secs(1));
    drop(twin);
    let output = studio.wait_with_output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    assert!(String::from_utf8_lossy(&output.stdout).contains("Haply Inverse3 04BA"));
    let session: serde_json::Value = serde_json::from_slice(&std::fs::read(out.join("session.json")).unwrap()).unwrap();
    assert!(session["pressed_volume_mm3"].as_f64().unwrap() > 10.0, "{session}");
    std::fs::remove_dir_all(out).unwrap();
}
