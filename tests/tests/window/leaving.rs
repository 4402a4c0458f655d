//! A host's window that is closed while its pot is in no file.
//!
//! A real window on a virtual display, and a mouse that presses.

use std::fs;
use std::time::{Duration, Instant};

use pottery_client::pot_file::PotFile;
use pottery_shared::clay::{Conditions, Pot, PotSpec};
use pottery_shared::units::Tick;
use pottery_tests::display::{Controls, Display};
use pottery_tests::programs::folder;

/// How long anything takes at most; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);

fn until(what: &str, is_so: impl Fn() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn is_said(controls: &Controls<'_>, begin: &str) -> bool {
    controls.all().iter().any(|control| control.name.starts_with(begin))
}

#[test]
fn a_pot_that_is_in_no_file_is_left_when_that_was_said_and_a_saved_one_at_once() {
    let out = folder("window-leaving");
    let path = out.join("mine.pot");
    let cylinder = Pot::new(PotSpec::default()).unwrap();
    PotFile::of(&cylinder, &Conditions::default(), Tick(0)).write(&path).unwrap();
    for is_saved in [false, true] {
        let display = Display::new();
        let open = ["--listen", "127.0.0.1:0", "--mute", "--open", path.to_str().unwrap()];
        let (mut studio, controls) = display.studio_with_controls(&open);
        let window = display.window(&[]);
        display.run("xdotool", &["windowsize", "--sync", &window, "1000", "700"]);
        display.run("xdotool", &["windowmove", "--sync", &window, "0", "0", "windowfocus", &window]);
        let is_touched = || is_said(&controls, "touching the clay");
        display.run("xdotool", &["mousemove", "640", "380"]);
        until("the panel is not there", || is_said(&controls, "not touching"));
        display.run("xdotool", &["mousedown", "1"]);
        until("the clay is not touched", is_touched);
        std::thread::sleep(Duration::from_secs(1));
        display.run("xdotool", &["mouseup", "1", "mousemove", "640", "20"]);
        until("the clay is still touched", || !is_touched());
        let opened = PotFile::read(&path).unwrap();
        if is_saved {
            display.run("xdotool", &["key", "ctrl+s"]);
            until("the pot is not saved", || PotFile::read(&path).is_ok_and(|now| now.pot() != opened.pot()));
            until("nothing is said of it", || is_said(&controls, "written"));
        } else {
            display.run("xdotool", &["key", "Escape"]);
            until("nobody is asked", || is_said(&controls, "this pot is not saved"));
            assert!(studio.try_wait().unwrap().is_none(), "it is gone");
        }
        display.run("xdotool", &["key", "Escape"]);
        assert!(studio.wait().unwrap().success());
        assert_eq!(PotFile::read(&path).unwrap().pot() != opened.pot(), is_saved);
    }
    fs::remove_dir_all(out).unwrap();
}
