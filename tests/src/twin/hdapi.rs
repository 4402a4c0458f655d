//! The stand-in for the vendor's library: compiles `hdapi.c` and moves the styli behind it.
//!
//! Invariant: tests in one process share no stylus.

use std::path::{Path, PathBuf};

use glam::{DVec3, Vec3};
use libloading::Library;

use super::compiled;

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
    /// The callback is called every 30 ms.
    Late = 6,
    /// The callback is called every 200 ms.
    VeryLate = 7,
    /// The library always has one more error.
    ErrorsWithoutEnd = 8,
    /// And it is one that nobody knows.
    OddErrors = 9,
    /// The device says that its workspace ends before it begins.
    OddWorkspace = 10,
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
        Self::compile_with(&[])
    }

    /// The same without one of its functions.
    ///
    /// # Panics
    /// Without a C compiler, with what to install.
    #[must_use]
    pub fn without(function: &str) -> Self {
        Self::compile_with(&[&format!("-D{function}=another_{function}")])
    }

    fn compile_with(flags: &[&str]) -> Self {
        let file = compiled::library("hdapi.c", flags);
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
        self.set_one(0, trouble, hand_m, buttons);
    }

    /// The same of stylus 0, the default one, or 1.
    ///
    /// # Panics
    /// When the library is another one.
    pub fn set_one(&self, stylus: i32, trouble: Trouble, hand_m: Vec3, buttons: i32) {
        assert!((0..2).contains(&stylus), "there are two");
        let mm = (hand_m.as_dvec3() * 1e3).to_array();
        // SAFETY: the function has this type in `hdapi.c`, knows the stylus and reads three numbers.
        unsafe {
            let set = self.library.get::<unsafe extern "C" fn(i32, i32, *const f64, i32)>(b"twin_set\0");
            set.expect("twin_set of hdapi.c")(stylus, trouble as i32, mm.as_ptr(), buttons);
        }
    }

    /// Looks at the stylus.
    ///
    /// # Panics
    /// When the library is another one.
    #[must_use]
    pub fn look(&self) -> Stylus {
        self.look_at(0)
    }

    /// Looks at stylus 0 or 1.
    ///
    /// # Panics
    /// When the library is another one.
    #[must_use]
    pub fn look_at(&self, stylus: i32) -> Stylus {
        assert!((0..2).contains(&stylus), "there are two");
        let (mut at, mut sent, mut state) = ([0.0; 3], [0.0; 3], [0; 3]);
        // SAFETY: the function has this type in `hdapi.c`, knows the stylus and writes three numbers to each.
        unsafe {
            let look = self.library.get::<unsafe extern "C" fn(i32, *mut f64, *mut f64, *mut i32)>(b"twin_look\0");
            look.expect("twin_look of hdapi.c")(stylus, at.as_mut_ptr(), sent.as_mut_ptr(), state.as_mut_ptr());
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
