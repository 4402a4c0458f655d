//! What becomes of a device's force when its readings do not come: how soon it goes, and that a slow device is not taken for a late one.
//!
//! Invariant: a machine that is busy may make a test try again, and never pass.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::{
    Axes, Calibration, Device, DeviceFault, DrivenDevice, Driver, MIDDLE_ROOM_M, Port, ROUND, Reading, Reported,
    SILENCE, pointer,
};
use pottery_shared::haptics::{DeviceSpecs, Fault, Haptics};
use pottery_tests::twin::HandSession;

/// A device that is held in the wall and sends a reading every so many milliseconds, until it freezes.
#[derive(Clone, Debug, Default)]
struct Metronome {
    every_ms: Arc<AtomicU64>,
    is_to_freeze: Arc<AtomicBool>,
    is_frozen: Arc<AtomicBool>,
    /// Held 20 mm higher.
    elsewhere: Arc<AtomicBool>,
}

impl Metronome {
    fn every(ms: u64) -> Self {
        let metronome = Self::default();
        metronome.every_ms.store(ms, Ordering::Relaxed);
        metronome
    }

    fn freeze(&self) {
        self.is_to_freeze.store(true, Ordering::Relaxed);
        while !self.is_frozen.load(Ordering::Relaxed) {
            std::thread::yield_now();
        }
    }

    fn thaw(&self) {
        self.is_to_freeze.store(false, Ordering::Relaxed);
    }
}

impl Driver for Metronome {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        port.found("metronome".into(), Reported::default());
        let mut next = Instant::now();
        while !port.is_closing() {
            let freezes = self.is_to_freeze.load(Ordering::Relaxed);
            self.is_frozen.store(freezes, Ordering::Relaxed);
            if !freezes {
                let up_m = if self.elsewhere.load(Ordering::Relaxed) { 0.02 } else { 0.0 };
                let position_m = Vec3::new(0.067, 0.0, 0.1 + up_m);
                port.publish(Reading { position_m, velocity_m_s: None, buttons: 0 });
            }
            let period = Duration::from_millis(self.every_ms.load(Ordering::Relaxed));
            next = (next + period).max(Instant::now());
            std::thread::sleep(next.saturating_duration_since(Instant::now()));
        }
        Ok(())
    }
}

fn calibration() -> Calibration {
    // the device's frame is the room's
    Calibration::new(Axes::ZUp, MIDDLE_ROOM_M)
}

#[test]
fn frozen_device_has_no_force_two_ticks_after_its_next_reading_was_due_three_times() {
    for every_ms in [1, 4, 10] {
        let device = Metronome::every(every_ms);
        let mut session = HandSession::new(device.clone(), calibration(), DeviceSpecs::OMNI);
        let mut tries = 0;
        loop {
            session.until("the clay pushes", |session| session.force_n() > 0.1);
            device.freeze();
            let interval_ms = session.monitor().interval().unwrap().as_secs_f32() * 1e3;
            let mut ticks = 0_u16;
            while session.force_n() > 0.0 {
                session.hurry();
                ticks += 1;
                // the first may bring a last reading; then three intervals, and two ticks
                assert!(f32::from(ticks) <= 1.0 + 3.0 * interval_ms + 2.0 + 1.0, "{ticks} ticks at {interval_ms} ms");
            }
            assert_eq!((session.tool_m(), session.notice()), (None, None), "{ticks} ticks at {interval_ms} ms");
            // the last reading may have come an interval before; on a machine that was busy just then longer, which shows nothing
            let was_in_time = f32::from(ticks) > 2.0 * interval_ms;
            while session.notice().is_none() {
                session.hurry();
                ticks += 1;
                assert!(ticks < 60 && session.force_n() == 0.0, "{ticks} ticks");
            }
            let heard_ms = f32::from(ticks) + interval_ms + 2.0;
            assert!(!was_in_time || heard_ms > SILENCE.as_secs_f32() * 1e3, "a word after {ticks} ticks");
            device.thaw();
            let mut first_n = 0.0;
            session.until("it is felt again", |session| {
                first_n = if first_n > 0.0 { first_n } else { session.force_n() };
                first_n > 0.0
            });
            // 100 N/s
            assert!(first_n < 0.1001, "{first_n} N");
            tries += 1;
            assert!(tries < 20, "the force goes before a reading is late at {interval_ms} ms");
            if was_in_time {
                break;
            }
        }
    }
}

#[test]
fn reading_that_stands_still_is_a_hand_at_rest_and_one_that_goes_on_elsewhere_has_jumped() {
    // a frozen encoder cannot be told from a hand that rests between two steps: the force stays what the clay gives, which gives way
    let device = Metronome::every(1);
    let mut session = HandSession::new(device.clone(), calibration(), DeviceSpecs::OMNI);
    session.until("the clay pushes", |session| session.force_n() > 0.1 && session.force_n() < 3.3);
    let mut felt_n = Vec::new();
    while felt_n.len() < 2000 {
        session.tick();
        // where a busy machine holds the device up there is no tool
        if session.tool_m().is_some() && session.force_n() > 0.0 {
            felt_n.push(session.force_n());
        }
        assert_eq!(session.fault(), None);
    }
    // once the ramp is over the clay gives way, and the force with it; nothing that a hand could tell is added
    let most_n = |felt_n: &[f32]| felt_n.iter().copied().fold(0.0, f32::max);
    let (first_n, later_n) = (most_n(&felt_n[..1000]), most_n(&felt_n[1000..]));
    assert!(later_n > 0.1 && later_n <= first_n * 1.07, "{first_n} N, then {later_n} N");
    device.elsewhere.store(true, Ordering::Relaxed);
    session.until("it has jumped", |session| session.fault() == Some(Fault::Jump));
    assert_eq!((session.force_n(), session.tool_m().is_some()), (0.0, true));
    session.until("that is over", |session| session.fault().is_none() && session.force_n() > 0.1);
}

#[test]
fn slow_device_keeps_its_tool_and_its_force() {
    for every_ms in [4, 10] {
        let mut session = HandSession::new(Metronome::every(every_ms), calibration(), DeviceSpecs::OMNI);
        session.until("the clay pushes", |session| session.force_n() > 0.1);
        let mut unbroken = 0;
        session.until("half a second without a gap", |session| {
            unbroken = if session.tool_m().is_some() && session.force_n() > 0.0 { unbroken + 1 } else { 0 };
            unbroken > 500
        });
    }
}

#[test]
fn coupling_is_tuned_to_how_often_a_device_answers_and_too_seldom_is_not_at_all() {
    let metronome = Metronome::every(10);
    let mut device = DrivenDevice::open(metronome.clone(), calibration(), DeviceSpecs::OMNI, pointer().1).unwrap();
    let begin = Instant::now();
    let mut until = |what: &str, holds: &dyn Fn(&DrivenDevice, bool) -> bool| loop {
        let is_held = device.position(begin.elapsed().as_secs_f64()).is_some();
        if holds(&device, is_held) {
            return (device.setup(0.2), device.monitor());
        }
        assert!(begin.elapsed() < Duration::from_secs(30), "{what}: {:?}", device.monitor());
        std::thread::sleep(Duration::from_millis(1));
    };
    let (setup, monitor) = until("it is in hand", &|_, is_held| is_held);
    let longer_s = monitor.interval().unwrap().as_secs_f32() - 1e-3;
    // a reading is kept so much longer, and so is a force; the interval is known to a microsecond
    assert!(longer_s > 8e-3 && (setup.delay.0 - ROUND.0 - 2.0 * longer_s).abs() < 3e-6, "{setup:?}");
    let coupling = Haptics::new(setup).coupling();
    let needed = coupling.stiffness_n_m * (0.5e-3 + setup.delay.0) + coupling.damping_ns_m;
    assert!(setup.specs.damping_ns_m + 1.0 > needed, "{coupling:?}");
    metronome.every_ms.store(30, Ordering::Relaxed);
    let is_mouse = |device: &DrivenDevice, _| device.specs() == DeviceSpecs::MOUSE;
    // a busy machine may be silent in between
    let is_late =
        |device: &DrivenDevice| device.monitor().notice().is_some_and(|said| said.contains("late again and again"));
    let (_, monitor) = until("the mouse works", &is_mouse);
    assert!(monitor.notice().unwrap().contains("the mouse works"));
    until("it is late and the mouse works", &|device, is_held| is_mouse(device, is_held) && is_late(device));
    metronome.every_ms.store(1, Ordering::Relaxed);
    let (setup, monitor) = until("it is in hand again", &|device, is_held| is_held && !is_mouse(device, is_held));
    assert!(setup.delay.0 < ROUND.0 + 16e-3 && monitor.notice().is_none(), "{setup:?}");
}
