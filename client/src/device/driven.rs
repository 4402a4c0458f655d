//! A device whose driver may wait: the driver has a thread of its own and meets the 1 kHz tick over two triple buffers.
//!
//! Owns the thread, the watch over both sides' silence and the sentence for the window; knows no protocol.
//! Invariant: the tick's side neither waits, locks nor allocates, and a driver sees no force but zero when the tick is
//! silent, the device is closing or the limits that it reports were refused.

use std::sync::atomic::{AtomicBool, AtomicU32, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_shared::haptics::{DeviceSpecs, Haptics, Setup};
use pottery_shared::tool::{Orientation, Tool};
use pottery_shared::units::{Seconds, Tick};

use super::rhythm::{LONGEST_S, Rhythm, late_after_s};
use super::{Calibration, Device, DeviceFault, Fit, Limits, PointerDevice, Reported};
use crate::sound::Rub;

/// Time without a reading, or without a force, after which the other side counts as gone. Rare stalls of a
/// desktop system take up to 30 ms. Force and tool are taken away sooner, as soon as a reading is late by the device's own rhythm.
pub const SILENCE: Duration = Duration::from_millis(Haptics::SILENCE_TICKS as u64);
/// Time between two tries to open a device that is not there.
const RETRY: Duration = Duration::from_millis(500);
/// How long opening waits for the first reading, so that the loop knows what the device reports of itself.
const FIRST_READING: Duration = Duration::from_secs(2);

/// How long readings may come out of time before it is said and the mouse works: more than a judgement of the slowest device takes.
const UNSTEADY: Duration = Duration::from_secs(1);

/// Longest way of a reading through the tick and of its force to the next exchange: a period of each.
pub const ROUND: Seconds = Seconds(2.0 * Tick::PERIOD.0);

/// Share of a turn that is still missing which a tick makes: a time constant of 20 ms.
const TURN_SHARE: f32 = 0.05;

/// What a driver reads, in the device's own frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reading {
    /// Where it is, m.
    pub position_m: Vec3,
    /// How fast it is, m/s, if the device says so.
    pub velocity_m_s: Option<Vec3>,
    /// Buttons that are down: bit n is button n.
    pub buttons: u32,
}

/// What the tick gives a driver.
#[derive(Clone, Copy, Debug, Default)]
struct Given {
    /// In the device's frame.
    force_n: Vec3,
    slip_m_s: f32,
}

/// What the driver's side tells the tick.
#[derive(Clone, Copy, Debug)]
struct Report {
    /// The newest reading, while there is one and the device may be used.
    reading: Option<Reading>,
    /// What the device can render that was found last, in its own frame.
    specs: DeviceSpecs,
    /// How many were found so far.
    found: u32,
    /// How often readings come, s, and whether they come in time.
    interval_s: f32,
    is_steady: bool,
    /// Whether the driver rests and gives no force.
    rests: bool,
}

/// The side of a device that may wait.
pub trait Driver: Send + 'static {
    /// Opens the device and exchanges forces for readings until the port is closing, leaving it without force.
    ///
    /// It is called again after a while when it fails: that is how a device is plugged in again.
    ///
    /// # Errors
    /// A [`DeviceFault`] with a sentence for the person.
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault>;

    /// Longest time from where the device is to the force that answers it, which stability has to reckon with.
    ///
    /// A reading waits for the next tick, and the force for the next exchange: [`ROUND`], and what the way to the device takes. Two
    /// clocks of 1 kHz drift so slowly past each other that the worst lasts for seconds. What a device takes longer for a reading than a
    /// tick is reckoned with besides. Zero for a device whose force moves no hand.
    fn delay(&self) -> Seconds {
        ROUND
    }
}

/// The fit that the tick is to work with next, and the last that was given to it.
#[derive(Debug)]
struct Fits {
    next: triple_buffer::Input<Fit>,
    last: Fit,
}

/// What the window knows of a device, and asks of it.
#[derive(Debug)]
pub struct Monitor {
    notice: Mutex<Option<String>>,
    about: Mutex<Option<String>>,
    /// Why the device that was found is not used.
    refused: Mutex<Option<String>>,
    /// No reading came for [`SILENCE`]; written by the tick.
    is_silent: AtomicBool,
    /// Readings have been coming out of time for [`UNSTEADY`].
    is_unsteady: AtomicBool,
    /// Time from one reading to the next, µs; zero while it is not known.
    interval_us: AtomicU32,
    is_closing: AtomicBool,
    fits: Mutex<Fits>,
    /// The device is being fitted to the hand, so that it has no tool; then, where it is, m as bits, and whether a button is down.
    is_fitting: AtomicBool,
    place_m: [AtomicU32; 3],
    is_pressed: AtomicBool,
    exchanges: AtomicU64,
}

/// What a lock guards stays readable: each is one value, written whole.
fn locked<T>(mutex: &Mutex<T>) -> std::sync::MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Monitor {
    fn new(fits: Fits) -> Self {
        Self {
            notice: Mutex::default(),
            about: Mutex::default(),
            refused: Mutex::default(),
            is_silent: AtomicBool::default(),
            is_unsteady: AtomicBool::default(),
            interval_us: AtomicU32::default(),
            is_closing: AtomicBool::default(),
            fits: Mutex::new(fits),
            is_fitting: AtomicBool::default(),
            place_m: [const { AtomicU32::new(f32::NAN.to_bits()) }; 3],
            is_pressed: AtomicBool::default(),
            exchanges: AtomicU64::default(),
        }
    }

    /// The sentence that the person must see, if any.
    #[must_use]
    pub fn notice(&self) -> Option<String> {
        let said = locked(&self.notice).clone().or_else(|| locked(&self.refused).clone());
        let is_silent = self.is_silent.load(Ordering::Relaxed);
        let is_unsteady = self.is_unsteady.load(Ordering::Relaxed);
        let unheard = match (is_silent, is_unsteady) {
            (true, _) => Some("the device sends nothing: its force is off until it does, and the mouse works"),
            (false, true) => Some(
                "the device answers late again and again: its force is off until it answers in time, and the mouse works",
            ),
            (false, false) => None,
        };
        said.or_else(|| unheard.map(str::to_owned))
    }

    /// Time from one reading to the next, once it is known; that of a tick for a device that is faster.
    #[must_use]
    pub fn interval(&self) -> Option<Duration> {
        let us = self.interval_us.load(Ordering::Relaxed);
        (us > 0).then(|| Duration::from_micros(us.into()))
    }

    /// Which device it is, once it has been found: for the status line.
    #[must_use]
    pub fn about(&self) -> Option<String> {
        locked(&self.about).clone()
    }

    /// Exchanges with the device so far: for its rate.
    #[must_use]
    pub fn exchanges(&self) -> u64 {
        self.exchanges.load(Ordering::Relaxed)
    }

    /// How the device is fitted to the hand.
    #[must_use]
    pub fn fit(&self) -> Fit {
        locked(&self.fits).last
    }

    /// Fits it so from the next tick on; a fit that makes no sense changes nothing.
    pub fn fit_to(&self, fit: Fit) {
        if let Some(fit) = fit.sound() {
            let mut fits = locked(&self.fits);
            fits.last = fit;
            fits.next.write(fit);
        }
    }

    /// Takes the tool from the device, and with it the force, and lets [`Monitor::place_m`] follow it; or gives the tool back.
    pub fn set_fitting(&self, is_fitting: bool) {
        self.lose_place();
        self.is_fitting.store(is_fitting, Ordering::Relaxed);
    }

    /// Where the device is while it is being fitted, m as [`Fit::middle_m`]; coordinates may be a tick apart.
    #[must_use]
    pub fn place_m(&self) -> Option<Vec3> {
        let place_m = self.place_m.each_ref().map(|along| f32::from_bits(along.load(Ordering::Relaxed)));
        Some(Vec3::from_array(place_m)).filter(|place_m| place_m.is_finite())
    }

    /// Whether a button of it is down while it is being fitted.
    #[must_use]
    pub fn is_pressed(&self) -> bool {
        self.is_pressed.load(Ordering::Relaxed)
    }

    /// Says that it is not known where the device is: where it was is no place to fit it to. What its buttons did last stays, so that one
    /// that is held down is not pressed anew when the device is back.
    fn lose_place(&self) {
        self.place_m.iter().for_each(|along| along.store(f32::NAN.to_bits(), Ordering::Relaxed));
    }

    /// True while the device is being fitted, which then hears where it is.
    fn follow(&self, place_m: Vec3, buttons: u32) -> bool {
        let is_fitting = self.is_fitting.load(Ordering::Relaxed);
        if is_fitting {
            for (stored, along) in self.place_m.iter().zip(place_m.to_array()) {
                stored.store(along.to_bits(), Ordering::Relaxed);
            }
            self.is_pressed.store(buttons != 0, Ordering::Relaxed);
        }
        is_fitting
    }

    fn say(&self, notice: Option<String>) {
        *locked(&self.notice) = notice;
    }
}

/// The driver's end.
#[derive(Debug)]
pub struct Port {
    reports: triple_buffer::Input<Report>,
    given: triple_buffer::Output<Given>,
    monitor: Arc<Monitor>,
    given_at: Instant,
    calibration: Calibration,
    limits: Limits,
    /// What was told last.
    report: Report,
    /// Largest force that may be given, N: zero while the device is not to be used.
    peak_n: f32,
    /// Whether the device's force moves a hand, so that it must not come late.
    moves_hand: bool,
    rhythm: Rhythm,
    /// When the last reading was handed over, and since when they come out of time; for a device that was just found, always.
    published_at: Option<Instant>,
    unsteady_since: Option<Instant>,
    was_steady: bool,
}

impl Port {
    /// Says which device was found and what it reports of itself. It is used from now on, unless its limits make no sense: then
    /// the person is told so, and it is served without force and without a place.
    pub fn found(&mut self, about: String, reported: Reported) {
        let is_sound = |specs: &DeviceSpecs| self.calibration.specs_in_room(*specs).checked().map(|_| *specs);
        let specs = self.limits.of(reported).and_then(|specs| is_sound(&specs));
        let refused = specs.err().map(|error| {
            format!("{error}: its force is off and the mouse works; to use a kind's limits, name it, as in specs=omni")
        });
        self.peak_n = specs.map_or(0.0, |specs| specs.peak_force_n);
        self.report = Report {
            reading: None,
            specs: specs.unwrap_or(self.report.specs),
            found: self.report.found.wrapping_add(1),
            is_steady: false,
            rests: false,
            ..self.report
        };
        (self.rhythm, self.published_at, self.unsteady_since, self.was_steady) = (Rhythm::default(), None, None, false);
        self.monitor.is_unsteady.store(false, Ordering::Relaxed);
        self.monitor.interval_us.store(0, Ordering::Relaxed);
        self.reports.write(self.report);
        *locked(&self.monitor.refused) = refused;
        self.monitor.say(None);
        // last: whoever waits for the device waits for this
        *locked(&self.monitor.about) = Some(about);
    }

    /// Says what the person should know or do, while the device is being served.
    pub fn notify(&self, sentence: Option<String>) {
        self.monitor.say(sentence);
    }

    /// Says whether the device rests and gives no force, though it has a place. The tick hears of it with the next reading, and what it gives
    /// after it heard that this is over begins at nothing.
    pub const fn rest(&mut self, rests: bool) {
        self.report.rests = rests;
    }

    /// Hands a reading to the tick. The first of a device only show how often they come.
    pub fn publish(&mut self, reading: Reading) {
        let is_used = self.keep_time() && self.peak_n > 0.0;
        self.report.reading = Some(reading).filter(|_| is_used);
        self.reports.write(self.report);
        self.monitor.exchanges.fetch_add(1, Ordering::Relaxed);
    }

    /// Learns how often readings come, and says whether the device has the hand: from when they come in time until they have come out of
    /// time for long.
    fn keep_time(&mut self) -> bool {
        let now = Instant::now();
        if let Some(before) = self.published_at.replace(now) {
            self.rhythm.hear((now - before).as_secs_f32());
        }
        if self.rhythm.is_steady() {
            self.monitor.interval_us.store((self.rhythm.interval_s() * 1e6).round() as u32, Ordering::Relaxed);
        }
        if !self.moves_hand {
            // it is late when it is silent
            (self.report.interval_s, self.report.is_steady) = (LONGEST_S, true);
            return true;
        }
        (self.report.interval_s, self.report.is_steady) = (self.rhythm.interval_s(), self.rhythm.is_steady());
        if self.rhythm.is_steady() {
            (self.unsteady_since, self.was_steady) = (None, true);
        }
        let is_unsteady = !self.rhythm.is_steady() && now - *self.unsteady_since.get_or_insert(now) > UNSTEADY;
        self.was_steady &= !is_unsteady;
        self.monitor.is_unsteady.store(is_unsteady, Ordering::Relaxed);
        self.was_steady
    }

    /// Tells the tick that there is no position to be had.
    pub fn withdraw(&mut self) {
        // a pause on purpose is no late reading
        (self.published_at, self.unsteady_since) = (None, None);
        self.monitor.is_unsteady.store(false, Ordering::Relaxed);
        self.report.reading = None;
        self.reports.write(self.report);
    }

    /// The force to give now, N in the device's frame: zero when the tick has been silent for [`SILENCE`].
    pub fn force_n(&mut self) -> Vec3 {
        let force_n = self.newest().force_n;
        if force_n.is_finite() { force_n.clamp_length_max(self.peak_n) } else { Vec3::ZERO }
    }

    /// How fast the clay goes by under the tool that presses it, m/s: for a device that hums. Zero when the force is.
    pub fn slip_m_s(&mut self) -> f32 {
        self.newest().slip_m_s
    }

    /// What was given last, or nothing when that was too long ago.
    fn newest(&mut self) -> Given {
        if self.given.update() {
            self.given_at = Instant::now();
        }
        if self.is_closing() || self.given_at.elapsed() > SILENCE {
            return Given::default();
        }
        *self.given.output_buffer()
    }

    /// Whether the device is to be left.
    #[must_use]
    pub fn is_closing(&self) -> bool {
        self.monitor.is_closing.load(Ordering::Relaxed)
    }

    /// For a driver whose port is at work in another thread.
    #[must_use]
    pub fn watch(&self) -> Watch {
        Watch { monitor: Arc::clone(&self.monitor) }
    }
}

/// What a driver's thread may do while another one has the port.
#[derive(Clone, Debug)]
pub struct Watch {
    monitor: Arc<Monitor>,
}

impl Watch {
    /// See [`Port::is_closing`].
    #[must_use]
    pub fn is_closing(&self) -> bool {
        self.monitor.is_closing.load(Ordering::Relaxed)
    }

    /// See [`Port::notify`].
    pub fn notify(&self, sentence: Option<String>) {
        self.monitor.say(sentence);
    }

    /// Readings handed over so far.
    #[must_use]
    pub fn exchanges(&self) -> u64 {
        self.monitor.exchanges()
    }
}

/// Keeps to a rhythm of one exchange a millisecond, without making up for lost time.
#[derive(Debug)]
pub struct Pace {
    next: Instant,
}

impl Pace {
    const PERIOD: Duration = Duration::from_millis(1);

    /// A rhythm that begins now.
    #[must_use]
    pub fn new() -> Self {
        Self { next: Instant::now() + Self::PERIOD }
    }

    /// Waits for the next beat.
    pub fn wait(&mut self) {
        let now = Instant::now();
        if let Some(left) = self.next.checked_duration_since(now) {
            std::thread::sleep(left);
            self.next += Self::PERIOD;
        } else {
            self.next = now + Self::PERIOD;
        }
    }
}

impl Default for Pace {
    fn default() -> Self {
        Self::new()
    }
}

/// A device with a driver's thread behind it; while it has no reading the pointer works in its place.
#[derive(Debug)]
pub struct DrivenDevice {
    reports: triple_buffer::Output<Report>,
    given: triple_buffer::Input<Given>,
    slip_m_s: f32,
    monitor: Arc<Monitor>,
    thread: Option<JoinHandle<()>>,
    calibration: Calibration,
    fits: triple_buffer::Output<Fit>,
    /// What the device can render, in its own frame, and which of those found it is.
    specs: DeviceSpecs,
    found: u32,
    interval_s: f32,
    delay: Seconds,
    pointer: PointerDevice,
    /// Whether the pointer works in the device's place, and whether that or the device became another since it was asked.
    is_pointer: bool,
    is_another: bool,
    rests: bool,
    /// The reading in use, and when the last one came, s.
    last: Option<Reading>,
    heard_s: f64,
    turned: Orientation,
}

impl DrivenDevice {
    /// Starts the driver and waits for a first reading, for at most two seconds.
    ///
    /// `limits` is what is known of this kind of device; what it reports of itself each time it is found stands in its place.
    /// `pointer` brings the tool, and works while the device is not there.
    ///
    /// # Errors
    /// What the system says when it has no thread, or what is wrong with a kind that no device can be of.
    pub fn open(
        driver: impl Driver,
        calibration: Calibration,
        limits: impl Into<Limits>,
        pointer: PointerDevice,
    ) -> std::io::Result<Self> {
        let limits = limits.into();
        let kind = limits.of(Reported::default()).map_err(std::io::Error::other)?;
        let interval_s = Rhythm::default().interval_s();
        let report = Report { reading: None, specs: kind, found: 0, interval_s, is_steady: false, rests: false };
        let (reports_in, mut reports) = triple_buffer::TripleBuffer::new(&report).split();
        let (given, given_out) = triple_buffer::TripleBuffer::new(&Given::default()).split();
        let (next, fits) = triple_buffer::TripleBuffer::new(&calibration.fit()).split();
        let monitor = Arc::new(Monitor::new(Fits { next, last: calibration.fit() }));
        let delay = driver.delay();
        let port = Port {
            reports: reports_in,
            given: given_out,
            monitor: Arc::clone(&monitor),
            given_at: Instant::now(),
            calibration,
            limits,
            report,
            peak_n: 0.0,
            moves_hand: delay.0 > 0.0,
            rhythm: Rhythm::default(),
            published_at: None,
            unsteady_since: None,
            was_steady: false,
        };
        let thread = std::thread::Builder::new().name("device".into()).spawn(move || supervise(driver, port))?;
        let begin = Instant::now();
        while begin.elapsed() < FIRST_READING && monitor.about().is_none() && monitor.notice().is_none() {
            std::thread::sleep(Duration::from_millis(1));
        }
        let &Report { specs, found, .. } = reports.read();
        let (thread, turned) = (Some(thread), Orientation::default());
        Ok(Self {
            reports,
            given,
            slip_m_s: 0.0,
            monitor,
            thread,
            calibration,
            fits,
            specs,
            found,
            interval_s,
            delay,
            pointer,
            is_pointer: false,
            is_another: false,
            rests: false,
            last: None,
            heard_s: f64::NEG_INFINITY,
            turned,
        })
    }

    /// What the window may look at.
    #[must_use]
    pub fn monitor(&self) -> Arc<Monitor> {
        Arc::clone(&self.monitor)
    }

    /// Works with another fit from now on, if there is one; what the device can render is then another in the room.
    fn take_fit(&mut self) -> bool {
        if !self.fits.update() {
            return false;
        }
        let fit = *self.fits.output_buffer();
        let fitted = self.calibration.fitted(fit);
        let is_sound = fitted.specs_in_room(self.specs).checked().is_ok();
        // a scale at which the device would be none stays as it was, and the middle is moved alone
        let scale = if is_sound { fit.scale } else { self.calibration.fit().scale };
        self.calibration = fitted.fitted(Fit { scale, ..fit });
        self.is_another = true;
        true
    }

    fn end(&mut self) {
        self.given.write(Given::default());
        self.monitor.is_closing.store(true, Ordering::Relaxed);
        if let Some(thread) = self.thread.take()
            && thread.join().is_err()
        {
            tracing::error!("the device's driver did not end well");
        }
    }
}

/// Serves the device again and again until it is left.
fn supervise(mut driver: impl Driver, mut port: Port) {
    while !port.is_closing() {
        let Err(fault) = driver.serve(&mut port) else { break };
        port.withdraw();
        port.notify(Some(fault.to_string()));
        let failed = Instant::now();
        while failed.elapsed() < RETRY && !port.is_closing() {
            std::thread::sleep(Duration::from_millis(10));
        }
    }
    port.withdraw();
}

impl Device for DrivenDevice {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        let pointed_m = self.pointer.position(seconds);
        // these devices do not turn their tool: keys do
        self.turned = self.turned.towards(self.pointer.asked().orientation, TURN_SHARE);
        if self.reports.update() {
            self.heard_s = seconds;
        }
        let &Report { reading, specs, found, interval_s, is_steady, rests } = self.reports.output_buffer();
        let waited_s = seconds - self.heard_s;
        let is_silent = reading.is_some() && waited_s > SILENCE.as_secs_f64();
        self.monitor.is_silent.store(is_silent, Ordering::Relaxed);
        let is_pointer = reading.is_none() || is_silent;
        self.rests = rests && !is_pointer;
        let is_in_time = is_steady && waited_s <= late_after_s(interval_s).into();
        self.last = reading.filter(|_| !is_pointer && is_in_time);
        let has_changed_hands = is_pointer != self.is_pointer || found != self.found || interval_s != self.interval_s;
        if has_changed_hands {
            (self.is_pointer, self.is_another) = (is_pointer, true);
            (self.specs, self.found, self.interval_s) = (specs, found, interval_s);
        }
        if is_pointer {
            self.monitor.lose_place();
            // a tick without a tool between two that are in different places
            return pointed_m.filter(|_| !has_changed_hands);
        }
        // who answers late has no tool until it answers in time
        let reading = self.last?;
        let has_another_fit = self.take_fit();
        if self.monitor.follow(self.calibration.turned(reading.position_m), reading.buttons) {
            return None;
        }
        (!has_changed_hands && !has_another_fit).then(|| self.calibration.place(reading.position_m))
    }

    fn velocity(&self) -> Option<Vec3> {
        self.last.and_then(|reading| reading.velocity_m_s).map(|velocity_m_s| self.calibration.velocity(velocity_m_s))
    }

    fn buttons(&self) -> u32 {
        self.last.map_or(0, |reading| reading.buttons)
    }

    fn tool(&self) -> Tool {
        self.pointer.tool()
    }

    fn orientation(&self) -> Orientation {
        self.turned
    }

    fn set_rub(&mut self, rub: Rub) {
        self.slip_m_s = rub.slip_m_s;
    }

    fn set_force(&mut self, force_n: Vec3) {
        // the pointer's force is not the device's
        self.given.write(if self.last.is_some() {
            Given { force_n: self.calibration.force_to_device(force_n), slip_m_s: self.slip_m_s }
        } else {
            Given::default()
        });
    }

    /// The pointer's own while it works in the device's place.
    fn specs(&self) -> DeviceSpecs {
        if self.is_pointer { self.pointer.specs() } else { self.calibration.specs_in_room(self.specs) }
    }

    fn is_another(&mut self) -> bool {
        std::mem::take(&mut self.is_another)
    }

    fn rests(&self) -> bool {
        self.rests
    }

    /// Tuned to the time that a force takes to come: a device that answers every four milliseconds keeps a reading, and a force, for so much
    /// longer than [`ROUND`] has it.
    fn setup(&self, share_of_small: f32) -> Setup {
        if self.is_pointer {
            return self.pointer.setup(share_of_small);
        }
        let longer_s = self.interval_s - Tick::PERIOD.0;
        let delay = if self.delay.0 > 0.0 { Seconds(self.delay.0 + 2.0 * longer_s) } else { self.delay };
        Setup { delay, ..Setup::for_device(self.specs(), share_of_small) }
    }

    fn close(&mut self) {
        self.end();
    }
}

impl Drop for DrivenDevice {
    fn drop(&mut self) {
        self.end();
    }
}
