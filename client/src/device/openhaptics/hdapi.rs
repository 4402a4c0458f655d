//! The vendor's HDAPI, loaded while the program runs: none of it is needed to build, and none comes with this program.
//!
//! Owns every unsafe line of the driver but the callback. Types and numbers are those of the public headers, version 3.0.
//! Invariant: a function is called only while its library is loaded, from the thread that HDAPI allows it on.

use std::ffi::{CStr, CString, c_char, c_ulong, c_void};
use std::path::{Path, PathBuf};

use libloading::Library;

use super::DEVICE;
use crate::device::DeviceFault;

pub(super) const FORCE_OUTPUT: u32 = 0x4000;
pub(super) const CURRENT_BUTTONS: u32 = 0x2000;
pub(super) const CURRENT_POSITION: u32 = 0x2050;
pub(super) const CURRENT_VELOCITY: u32 = 0x2051;
pub(super) const CURRENT_FORCE: u32 = 0x2700;
pub(super) const MODEL_TYPE: u32 = 0x2501;
/// Least x, y and z, then the largest.
pub(super) const USABLE_WORKSPACE: u32 = 0x2551;
pub(super) const NOMINAL_MAX_STIFFNESS: u32 = 0x2602;
pub(super) const NOMINAL_MAX_FORCE: u32 = 0x2603;
pub(super) const NOMINAL_MAX_CONTINUOUS_FORCE: u32 = 0x2604;
pub(super) const NOMINAL_MAX_DAMPING: u32 = 0x2609;
const INVALID_HANDLE: u32 = u32::MAX;
/// Between the least and the greatest priority.
const PRIORITY: u16 = u16::MAX / 2;
/// What a callback answers to be called again.
pub(super) const CONTINUE: u32 = 1;

/// What went wrong last in a thread; code 0 is nothing.
#[repr(C)]
#[derive(Clone, Copy, Debug)]
pub(super) struct ErrorInfo {
    pub(super) code: u32,
    internal: i32,
    device: u32,
}

/// Called by HDAPI's own thread, 1000 times a second.
pub(super) type Callback = unsafe extern "system" fn(*mut c_void) -> u32;

/// The library and its functions.
#[derive(Debug)]
pub(super) struct Api {
    init_device: unsafe extern "system" fn(*const c_char) -> u32,
    disable_device: unsafe extern "system" fn(u32),
    enable: unsafe extern "system" fn(u32),
    schedule: unsafe extern "system" fn(Callback, *mut c_void, u16) -> c_ulong,
    unschedule: unsafe extern "system" fn(c_ulong),
    start_scheduler: unsafe extern "system" fn(),
    stop_scheduler: unsafe extern "system" fn(),
    begin_frame: unsafe extern "system" fn(u32),
    end_frame: unsafe extern "system" fn(u32),
    get_doubles: unsafe extern "system" fn(u32, *mut f64),
    get_integers: unsafe extern "system" fn(u32, *mut i32),
    set_doubles: unsafe extern "system" fn(u32, *const f64),
    get_string: unsafe extern "system" fn(u32) -> *const c_char,
    get_error: unsafe extern "system" fn() -> ErrorInfo,
    /// Last, so that it goes after everything that points into it.
    _library: Library,
}

/// The names under which the vendor installs it.
const NAMES: &[&str] = if cfg!(windows) { &["hd.dll"] } else { &["libHD.so", "libHD.so.3.4", "libHD.so.3.0"] };

impl Api {
    /// Loads the library: the named file, or the vendor's where it installs it.
    pub(super) fn load(file: Option<&Path>) -> Result<Self, DeviceFault> {
        let candidates: Vec<PathBuf> = match file {
            Some(file) => vec![file.to_owned()],
            None => NAMES.iter().map(PathBuf::from).collect(),
        };
        let mut reason = String::new();
        for candidate in &candidates {
            // SAFETY: loading runs the library's own initialisers. It is the vendor's driver or a file that the person named;
            // both are trusted as any program that the person starts.
            match unsafe { Library::new(candidate) } {
                Ok(library) => return Self::resolve(library, candidate),
                Err(error) if reason.is_empty() => reason = error.to_string(),
                Err(_) => {}
            }
        }
        Err(DeviceFault::NotFound {
            device: DEVICE,
            reason: format!("the vendor's library cannot be loaded ({reason})"),
            remedy: "install OpenHaptics and the device's driver, or name the library: --device openhaptics:lib=FILE"
                .into(),
        })
    }

    fn resolve(library: Library, file: &Path) -> Result<Self, DeviceFault> {
        /// A function of the library under its C name.
        macro_rules! function {
            ($name:literal) => {
                // SAFETY: the type is the one that the public header gives the function of this name, and the pointer is kept
                // in the same value as the library.
                *unsafe { library.get(concat!($name, "\0").as_bytes()) }.map_err(|error| DeviceFault::Unusable {
                    device: DEVICE,
                    reason: format!("{} has no {} ({error})", file.display(), $name),
                    remedy: "install OpenHaptics 3.0 or later".into(),
                })?
            };
        }
        Ok(Self {
            init_device: function!("hdInitDevice"),
            disable_device: function!("hdDisableDevice"),
            enable: function!("hdEnable"),
            schedule: function!("hdScheduleAsynchronous"),
            unschedule: function!("hdUnschedule"),
            start_scheduler: function!("hdStartScheduler"),
            stop_scheduler: function!("hdStopScheduler"),
            begin_frame: function!("hdBeginFrame"),
            end_frame: function!("hdEndFrame"),
            get_doubles: function!("hdGetDoublev"),
            get_integers: function!("hdGetIntegerv"),
            set_doubles: function!("hdSetDoublev"),
            get_string: function!("hdGetString"),
            get_error: function!("hdGetError"),
            _library: library,
        })
    }

    /// Opens a device by its name in the vendor's settings, the default one without a name, and lets it give force.
    pub(super) fn open(&self, name: Option<&CString>) -> Result<u32, u32> {
        self.forget_errors();
        let name = name.map_or(std::ptr::null(), |name| name.as_ptr());
        // SAFETY: the name is null, which is the default device, or ends in a zero and outlives the call.
        let device = unsafe { (self.init_device)(name) };
        match self.error() {
            0 if device != INVALID_HANDLE => {}
            code => {
                // opened with an error it would be in use for whoever tries next
                if device != INVALID_HANDLE {
                    self.close(device);
                }
                return Err(code);
            }
        }
        // SAFETY: a device was opened and is current in this thread.
        unsafe { (self.enable)(FORCE_OUTPUT) };
        match self.error() {
            0 => Ok(device),
            code => {
                self.close(device);
                Err(code)
            }
        }
    }

    /// Lets a device go.
    pub(super) fn close(&self, device: u32) {
        // SAFETY: the handle came from `hdInitDevice`; an old one is an error that HDAPI notes, nothing worse.
        unsafe { (self.disable_device)(device) };
        self.forget_errors();
    }

    /// Has `callback` called with `data` in HDAPI's own thread from now on.
    ///
    /// # Safety
    /// What `data` points at stays there and belongs to the callback until [`Api::stop`] has returned.
    pub(super) unsafe fn start(&self, callback: Callback, data: *mut c_void) -> Result<c_ulong, u32> {
        // SAFETY: the callback has the type that HDAPI calls, and the caller promises for the data.
        let handle = unsafe { (self.schedule)(callback, data, PRIORITY) };
        // SAFETY: takes nothing.
        unsafe { (self.start_scheduler)() };
        match self.error() {
            0 => Ok(handle),
            code => {
                self.stop(handle);
                Err(code)
            }
        }
    }

    /// Ends the calls; when it returns no callback is running.
    pub(super) fn stop(&self, handle: c_ulong) {
        // SAFETY: both wait for a callback that runs, and note an error for a handle that they do not know.
        unsafe {
            (self.stop_scheduler)();
            (self.unschedule)(handle);
        }
        self.forget_errors();
    }

    /// Begins a frame of a device, in which its state stands still.
    pub(super) fn begin_frame(&self, device: u32) {
        // SAFETY: takes a handle; an old one is an error that HDAPI notes.
        unsafe { (self.begin_frame)(device) };
    }

    /// Ends it and sends the force.
    pub(super) fn end_frame(&self, device: u32) {
        // SAFETY: as for `begin_frame`.
        unsafe { (self.end_frame)(device) };
    }

    /// Three numbers of the current device.
    pub(super) fn three(&self, what: u32) -> [f64; 3] {
        let [x, y, z, ..] = self.numbers(what);
        [x, y, z]
    }

    /// What the library answers to a question about the current device, and no numbers after that.
    pub(super) fn numbers(&self, what: u32) -> [f64; 16] {
        let mut values = [f64::NAN; 16];
        // SAFETY: there is room for sixteen numbers, the most that HDAPI has for any question.
        unsafe { (self.get_doubles)(what, values.as_mut_ptr()) };
        values
    }

    /// The buttons of the current device.
    pub(super) fn buttons(&self) -> u32 {
        let mut values = [0_i32; 16];
        // SAFETY: there is room for sixteen numbers, the most that HDAPI has for any question.
        unsafe { (self.get_integers)(CURRENT_BUTTONS, values.as_mut_ptr()) };
        values[0] as u32
    }

    /// Sets the force of the current device, N.
    pub(super) fn set_force(&self, force_n: [f64; 3]) {
        // SAFETY: HDAPI reads three numbers for a force.
        unsafe { (self.set_doubles)(CURRENT_FORCE, force_n.as_ptr()) };
    }

    /// What the current device is called.
    pub(super) fn model(&self) -> String {
        // SAFETY: HDAPI answers with null or a string of its own that ends in a zero and is copied at once.
        let model = unsafe {
            let text = (self.get_string)(MODEL_TYPE);
            (!text.is_null()).then(|| CStr::from_ptr(text).to_string_lossy().into_owned())
        };
        self.forget_errors();
        model.unwrap_or_else(|| DEVICE.to_owned())
    }

    /// The code of the oldest error that was not yet asked for, 0 when there is none.
    pub(super) fn error(&self) -> u32 {
        // SAFETY: takes nothing and returns a plain value.
        unsafe { (self.get_error)() }.code
    }

    /// Takes the errors away that concern nobody.
    pub(super) fn forget_errors(&self) {
        // the stack is finite; a library that always has one more is not waited for
        for _ in 0..32 {
            if self.error() == 0 {
                break;
            }
        }
    }
}
