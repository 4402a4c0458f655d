//! The stand-in for the vendor's library: compiles `hdapi.c` and moves the stylus behind it.
//!
//! Invariant: a test that cannot compile says which compiler to install; each twin is a library file of its own, so that
//! tests in one process share no stylus.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::{DVec3, Vec3};
use libloading::Library;

/// What the library does wrong; the numbers are those of `hdapi.c`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Trouble {
    /// Nothing.
    None = 0,
    /// The device is not there.
    Unplugged = 1,
    /// A coordinate is not a number.
    NotANumber = 2,
    /// The callback is no longer called.
    Frozen = 3,
    /// The motors are warm.
    Warm = 4,
    /// The device says that it gives no force.
    ZeroLimits = 5,
}

/// A compiled library with a stylus.
#[derive(Debug)]
pub struct HdapiTwin {
    file: PathBuf,
    library: Library,
}

/// What can be seen of the stylus.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stylus {
    /// Where it is, mm.
    pub at_mm: DVec3,
    /// The force of the last frame, N.
    pub sent_n: DVec3,
    /// Whether it is opened.
    pub is_open: bool,
    /// Frames so far.
    pub frames: u32,
    /// Whether the library's thread runs.
    pub runs: bool,
}

impl HdapiTwin {
    /// Compiles the library and loads it, for the test's own use; the driver loads it by its name.
    ///
    /// # Panics
    /// Without a C compiler, with what to install.
    #[must_use]
    pub fn compile() -> Self {
        static COUNT: AtomicU32 = AtomicU32::new(0);
        let number = COUNT.fetch_add(1, Ordering::Relaxed);
        let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src/twin/hdapi.c");
        let file = std::env::temp_dir().join(format!("hdapi-twin-{}-{number}.so", std::process::id()));
        let arguments = ["-shared", "-fPIC", "-O1", "-o"];
        let compiled = Command::new("cc").args(arguments).arg(&file).arg(&source).args(["-lpthread", "-lm"]).output();
        let compiled = compiled.unwrap_or_else(|error| {
            panic!(
                "the stand-in for HDAPI needs a C compiler named cc: {error} (Debian: apt-get install gcc libc6-dev)"
            )
        });
        assert!(compiled.status.success(), "{}", String::from_utf8_lossy(&compiled.stderr));
        // SAFETY: the library was compiled from the source beside this file; it has no initialisers.
        let library = unsafe { Library::new(&file) }.expect("the library that was just compiled");
        Self { file, library }
    }

    /// The library's file.
    #[must_use]
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// Moves the hand that holds the stylus, m, and says what is wrong and which buttons are down.
    ///
    /// # Panics
    /// When the library is another one.
    pub fn set(&self, trouble: Trouble, hand_m: Vec3, buttons: i32) {
        let mm = (hand_m.as_dvec3() * 1e3).to_array();
        // SAFETY: the function has this type in `hdapi.c`, and reads three numbers.
        unsafe {
            let set = self.library.get::<unsafe extern "C" fn(i32, *const f64, i32)>(b"twin_set\0");
            set.expect("twin_set of hdapi.c")(trouble as i32, mm.as_ptr(), buttons);
        }
    }

    /// Looks at the stylus.
    ///
    /// # Panics
    /// When the library is another one.
    #[must_use]
    pub fn look(&self) -> Stylus {
        let (mut at, mut sent, mut state) = ([0.0; 3], [0.0; 3], [0; 3]);
        // SAFETY: the function has this type in `hdapi.c`, and writes three numbers to each.
        unsafe {
            let look = self.library.get::<unsafe extern "C" fn(*mut f64, *mut f64, *mut i32)>(b"twin_look\0");
            look.expect("twin_look of hdapi.c")(at.as_mut_ptr(), sent.as_mut_ptr(), state.as_mut_ptr());
        }
        let [is_open, frames, runs] = state;
        Stylus {
            at_mm: DVec3::from_array(at),
            sent_n: DVec3::from_array(sent),
            is_open: is_open != 0,
            frames: frames.unsigned_abs(),
            runs: runs != 0,
        }
    }
}

impl Drop for HdapiTwin {
    fn drop(&mut self) {
        drop(std::fs::remove_file(&self.file));
    }
}
