//! PHANToM Omni, Touch and their relatives, through the vendor's library.
//!
//! Owns the callback in the vendor's 1 kHz thread and the watch over it. Verified against a small C library in the tests
//! that exports the same functions; not yet tried on hardware. The vendor's own limits on velocity, impulse and ramp stay on.
//! Invariant: units are turned here and nowhere else (mm, mm/s and N/mm to m, m/s and N/m), and the callback neither
//! allocates nor waits.

mod hdapi;

use std::ffi::{CString, c_void};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};

use super::{DeviceFault, Driver, Port, Reading, Reported, SILENCE};
use hdapi::Api;

const DEVICE: &str = "OpenHaptics device";
/// Middle of the workspace in the device's frame (x right, y up, z towards the person), m: where its maker puts the origin.
pub const MIDDLE_M: Vec3 = Vec3::ZERO;
/// Millimetres of HDAPI in a metre.
const MM: f64 = 1e-3;
/// Time without force after the library complained about the force, and the same in its frames.
const REST: Duration = Duration::from_secs(1);
const REST_FRAMES: u32 = 1000;
/// How often the driver's thread looks after the callback.
const LOOK: Duration = Duration::from_millis(5);

/// Which device, and where the library is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct OpenHapticsSettings {
    /// The device's name in the vendor's settings; its default one without.
    pub name: Option<String>,
    /// The library's file, where it is not found by its name.
    pub library: Option<PathBuf>,
}

/// The driver.
#[derive(Debug, Default)]
pub struct OpenHapticsDriver {
    settings: OpenHapticsSettings,
    api: Option<Arc<Api>>,
}

impl OpenHapticsDriver {
    /// A driver for a device of the vendor's.
    #[must_use]
    pub const fn new(settings: OpenHapticsSettings) -> Self {
        Self { settings, api: None }
    }

    /// Opens the device for a moment and says which it is, and how to choose another: the library does not say whether there are.
    ///
    /// # Errors
    /// [`DeviceFault`] when there is no library or no device.
    pub fn probe(&mut self) -> Result<String, DeviceFault> {
        let (api, device) = self.open()?;
        let model = api.model();
        api.close(device);
        let which = self.settings.name.as_deref().unwrap_or("the one set as default");
        Ok(format!("{model}, {which}; another with --device openhaptics:name=NAME, as the vendor's program has it"))
    }

    fn open(&mut self) -> Result<(Arc<Api>, u32), DeviceFault> {
        let api = match &self.api {
            Some(api) => Arc::clone(api),
            None => Arc::new(Api::load(self.settings.library.as_deref())?),
        };
        self.api = Some(Arc::clone(&api));
        let name = self.settings.name.clone().map(CString::new).transpose().map_err(|_| DeviceFault::Unusable {
            device: DEVICE,
            reason: "its name has a zero in it".into(),
            remedy: "use the name that the vendor's settings show".into(),
        })?;
        let device = api.open(name.as_ref()).map_err(|code| DeviceFault::NotFound {
            device: DEVICE,
            reason: format!("the vendor's library answers {code:#06x} ({})", meaning(code)),
            remedy: "check its cable and power, and set it up with the vendor's program".into(),
        })?;
        Ok((api, device))
    }
}

/// An error code of the library in words.
const fn meaning(code: u32) -> &'static str {
    match code {
        0 => "no error, and no device",
        0x0100..=0x01ff => "it was called wrongly",
        0x0200 => "its motors are warm",
        0x0201..=0x02ff => "it was asked for more force or speed than is safe",
        0x0301 => "another program uses it",
        0x0302 | 0x0303 => "it cannot be reached",
        0x0300..=0x03ff => "it has failed",
        0x0600 => "there is no licence for it",
        _ => "unknown",
    }
}

impl Driver for OpenHapticsDriver {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        let (api, device) = self.open()?;
        port.found(api.model(), reported(&api));
        let served = serve(&api, device, port);
        api.close(device);
        served
    }
}

/// What the device says of itself; a question that the library does not know leaves what is known of the kind.
fn reported(api: &Api) -> Reported {
    let ask = |what, unit: f64| {
        let [value, ..] = api.three(what);
        (api.error() == 0 && value.is_finite()).then_some((value * unit) as f32)
    };
    let [x0, y0, z0, x1, y1, z1, ..] = api.numbers(hdapi::USABLE_WORKSPACE);
    let half_m = DVec3::new(x1 - x0, y1 - y0, z1 - z0) * (0.5 * MM);
    // nothing depends on it so much that a device would be refused for it
    let is_sound = api.error() == 0 && half_m.is_finite() && (1e-3..=1.0).contains(&half_m.min_element());
    Reported {
        workspace_radius_m: is_sound.then_some(half_m.min_element() as f32),
        peak_force_n: ask(hdapi::NOMINAL_MAX_FORCE, 1.0),
        continuous_force_n: ask(hdapi::NOMINAL_MAX_CONTINUOUS_FORCE, 1.0),
        stiffness_max_n_m: ask(hdapi::NOMINAL_MAX_STIFFNESS, 1.0 / MM),
        damping_max_ns_m: ask(hdapi::NOMINAL_MAX_DAMPING, 1.0 / MM),
    }
}

/// What the callback works with; it is the callback's alone while it is scheduled.
struct Frame<'a> {
    api: &'a Api,
    device: u32,
    port: &'a mut Port,
    /// The last error, for the driver's thread.
    error: &'a AtomicU32,
    /// Frames that still have to pass without force.
    rest: u32,
}

/// Runs the callback in the vendor's thread and looks after it.
fn serve(api: &Api, device: u32, port: &mut Port) -> Result<(), DeviceFault> {
    let error = AtomicU32::new(0);
    let watch = port.watch();
    let mut frame = Box::new(Frame { api, device, port, error: &error, rest: 0 });
    let data = std::ptr::from_mut(frame.as_mut()).cast::<c_void>();
    // SAFETY: the frame lives until after `stop` below and is not touched in between; what it borrows lives longer.
    let handle = unsafe { api.start(call, data) }.map_err(|code| DeviceFault::Unusable {
        device: DEVICE,
        reason: format!("its 1 kHz thread does not start: {code:#06x} ({})", meaning(code)),
        remedy: "end other programs that use it".into(),
    })?;
    let (mut done, mut heard, mut rests_until) = (watch.exchanges(), Instant::now(), None);
    let outcome = loop {
        std::thread::sleep(LOOK);
        let now = watch.exchanges();
        if now != done {
            (done, heard) = (now, Instant::now());
        }
        let code = error.swap(0, Ordering::Relaxed);
        if watch.is_closing() {
            break Ok(());
        }
        if is_about_force(code) {
            rests_until = Some(Instant::now() + REST);
            watch.notify(Some(format!("the device rests for a second without force: {}", meaning(code))));
        } else if code != 0 {
            break Err(DeviceFault::Gone { device: DEVICE, reason: format!("{code:#06x}, {}", meaning(code)) });
        }
        if rests_until.is_some_and(|end| Instant::now() > end) {
            rests_until = None;
            watch.notify(None);
        }
        if heard.elapsed() > SILENCE {
            break Err(DeviceFault::Silent { device: DEVICE, ms: SILENCE.as_millis() as u64 });
        }
    };
    api.stop(handle);
    // the callback is over; the device may still hold its last force
    api.begin_frame(device);
    api.set_force([0.0; 3]);
    api.end_frame(device);
    api.forget_errors();
    outcome
}

/// Whether the library only complains about what it was asked to render.
const fn is_about_force(code: u32) -> bool {
    matches!(code, 0x0200..=0x02ff)
}

/// What HDAPI calls in its thread.
unsafe extern "system" fn call(data: *mut c_void) -> u32 {
    // SAFETY: the data is the frame that was scheduled with this callback, which nobody else touches until it is stopped.
    let frame = unsafe { &mut *data.cast::<Frame<'_>>() };
    frame.pass();
    hdapi::CONTINUE
}

impl Frame<'_> {
    fn pass(&mut self) {
        self.api.begin_frame(self.device);
        let position_m = DVec3::from_array(self.api.three(hdapi::CURRENT_POSITION)) * MM;
        let velocity_m_s = DVec3::from_array(self.api.three(hdapi::CURRENT_VELOCITY)) * MM;
        let buttons = self.api.buttons();
        self.rest = self.rest.saturating_sub(1);
        let force_n = if self.rest == 0 { self.port.force_n() } else { Vec3::ZERO };
        self.api.set_force(force_n.as_dvec3().to_array());
        self.api.end_frame(self.device);
        let code = self.api.error();
        if code != 0 {
            if !is_about_force(code) {
                // the driver's thread looks after it later than the hand's next tick
                self.port.withdraw();
            }
            self.rest = REST_FRAMES;
            self.error.store(code, Ordering::Relaxed);
            self.api.forget_errors();
        }
        if code == 0 || is_about_force(code) {
            self.port.rest(self.rest > 0);
            self.port.publish(Reading {
                position_m: position_m.as_vec3(),
                velocity_m_s: Some(velocity_m_s.as_vec3()),
                buttons,
            });
        }
    }
}
