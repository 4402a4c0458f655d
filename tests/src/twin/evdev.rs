//! The stand-in for the kernel's side of gamepads: compiles `evdev.c`, runs a test anew with it before the C library, and moves the
//! pads behind it.
//!
//! Invariant: only the process that the test was run in anew has the pads.

use std::path::PathBuf;

use libloading::Library;

use super::compiled;
use crate::programs;

/// Where the library lies, and the folder with the pads' names: set for the process that has them.
const LIBRARY: &str = "EVDEV_TWIN_LIBRARY";
const FOLDER: &str = "EVDEV_TWIN";

/// Kinds of events and what moves, as the kernel numbers them.
pub const EV_SYN: u16 = 0x00;
/// A button.
pub const EV_KEY: u16 = 0x01;
/// An axis.
pub const EV_ABS: u16 = 0x03;
/// All that was said before belongs together.
pub const SYN_REPORT: u16 = 0;
/// Events were lost.
pub const SYN_DROPPED: u16 = 3;

/// Axes: left stick, then what the kernel's own drivers have for right stick and triggers.
pub const ABS_X: u16 = 0x00;
/// Left stick, down.
pub const ABS_Y: u16 = 0x01;
/// Left trigger, or a second stick.
pub const ABS_Z: u16 = 0x02;
/// Right stick, or a trigger.
pub const ABS_RX: u16 = 0x03;
/// Right stick, down, or a trigger.
pub const ABS_RY: u16 = 0x04;
/// Right trigger, or a second stick, down.
pub const ABS_RZ: u16 = 0x05;
/// Right trigger of a pad that was made for a telephone.
pub const ABS_GAS: u16 = 0x09;
/// The lower button.
pub const BTN_SOUTH: u16 = 0x130;
/// The left button.
pub const BTN_WEST: u16 = 0x134;
/// The right trigger of a pad whose triggers are buttons.
pub const BTN_TR2: u16 = 0x139;

/// An axis as the kernel shows it.
#[derive(Clone, Copy, Debug)]
pub struct Axis {
    /// Where it is.
    pub value: i32,
    /// Its ends.
    pub ends: (i32, i32),
    /// How far from the middle it may rest.
    pub flat: i32,
}

/// What was done to a pad's motors.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Motors {
    /// Strength of the heavy one, of 65535.
    pub heavy: i32,
    /// Strength of the light one.
    pub light: i32,
    /// How long they hum by themselves, ms.
    pub length_ms: i32,
    /// Whether they do.
    pub plays: bool,
    /// Times that they were told.
    pub uploads: i32,
    /// Whether the effect was taken away.
    pub is_erased: bool,
}

/// The pads of this process.
#[derive(Debug)]
pub struct EvdevTwin {
    library: Library,
    folder: PathBuf,
}

impl EvdevTwin {
    /// The pads, in the process that has them; in any other, runs the test of that name in one that does, where `names` are
    /// plugged in as `/dev/input/event0` and so on, and is none.
    ///
    /// # Panics
    /// When the test fails there, with what it said.
    #[must_use]
    pub fn of(test: &str, names: &[&str]) -> Option<Self> {
        if let (Some(file), Some(folder)) = (std::env::var_os(LIBRARY), std::env::var_os(FOLDER)) {
            // SAFETY: the library is the one that this process was begun with.
            let library = unsafe { Library::new(file) }.expect("the library that was preloaded");
            return Some(Self { library, folder: folder.into() });
        }
        let (file, folder) = (compiled::library("evdev.c", &[]), programs::folder(&format!("pads-{test}")));
        for (number, name) in names.iter().enumerate() {
            std::fs::write(folder.join(format!("event{number}")), name).expect("an own folder can be written");
        }
        let variables = [("LD_PRELOAD", &file), (LIBRARY, &file), (FOLDER, &folder)];
        programs::anew(test, &variables.map(|(name, path)| (name, Some(path.as_os_str()))));
        std::fs::remove_file(file).expect("the library was there");
        std::fs::remove_dir_all(folder).expect("the folder was there");
        None
    }

    /// Plugs a pad in or pulls it out, gives it motors or none, lets it be written to or not.
    ///
    /// # Panics
    /// When the library is another one.
    pub fn plug(&self, pad: i32, is_in: bool, has_motors: bool, is_read_only: bool) {
        // a pad that is out is not in the folder either
        let (path, away) = (self.folder.join(format!("event{pad}")), self.folder.join(format!("out{pad}")));
        let (from, to) = if is_in { (&away, &path) } else { (&path, &away) };
        if from.exists() {
            std::fs::rename(from, to).expect("an own folder can be written");
        }
        // SAFETY: the function has this type in `evdev.c`.
        unsafe {
            let plug = self.library.get::<unsafe extern "C" fn(i32, i32, i32, i32)>(b"twin_pad\0");
            plug.expect("twin_pad of evdev.c")(pad, i32::from(!is_in), i32::from(has_motors), i32::from(is_read_only));
        }
    }

    /// Gives a pad an axis, or takes it away.
    ///
    /// # Panics
    /// When the library is another one.
    pub fn have(&self, pad: i32, code: u16, axis: Option<Axis>) {
        let at = axis.map(|Axis { value, ends: (least, most), flat }| [value, least, most, flat]);
        // SAFETY: the function has this type in `evdev.c`, and reads four numbers or takes a null.
        unsafe {
            let have = self.library.get::<unsafe extern "C" fn(i32, i32, *const i32)>(b"twin_axis\0");
            let at = at.as_ref().map_or(std::ptr::null(), |at| at.as_ptr());
            have.expect("twin_axis of evdev.c")(pad, code.into(), at);
        }
    }

    /// Something moves on a pad, and is said; or is lost on the way.
    ///
    /// # Panics
    /// When the library is another one.
    pub fn say(&self, pad: i32, kind: u16, code: u16, value: i32, is_lost: bool) {
        // SAFETY: the function has this type in `evdev.c`.
        unsafe {
            let say = self.library.get::<unsafe extern "C" fn(i32, i32, i32, i32, i32)>(b"twin_event\0");
            say.expect("twin_event of evdev.c")(pad, kind.into(), code.into(), value, i32::from(is_lost));
        }
    }

    /// Something moves on a pad and is all that does.
    pub fn moves(&self, pad: i32, kind: u16, code: u16, value: i32) {
        self.say(pad, kind, code, value, false);
        self.say(pad, EV_SYN, SYN_REPORT, 0, false);
    }

    /// What its motors do.
    ///
    /// # Panics
    /// When the library is another one.
    #[must_use]
    pub fn motors(&self, pad: i32) -> Motors {
        let mut to = [0; 6];
        // SAFETY: the function has this type in `evdev.c`, and writes six numbers.
        unsafe {
            let look = self.library.get::<unsafe extern "C" fn(i32, *mut i32)>(b"twin_motors\0");
            look.expect("twin_motors of evdev.c")(pad, to.as_mut_ptr());
        }
        let [heavy, light, length_ms, plays, uploads, is_erased] = to;
        Motors { heavy, light, length_ms, plays: plays != 0, uploads, is_erased: is_erased != 0 }
    }
}
