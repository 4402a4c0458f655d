//! Keys of a real window on a virtual display: what Esc closes before it leaves, and what a key does that is held down.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::process::Child;
use std::thread;
use std::time::{Duration, Instant};

use pottery_client::pot_file::PotFile;
use pottery_tests::display::{Controls, Display};
use pottery_tests::programs::folder;

/// How long anything takes at most; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);

fn until(what: &str, controls: &Controls<'_>, is_so: impl Fn(&Controls<'_>) -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so(controls) {
        assert!(Instant::now() < deadline, "{what}: {:#?}", controls.all());
        thread::sleep(Duration::from_millis(50));
    }
}

/// The studio ends, and well.
fn ends(studio: &mut Child) {
    let deadline = Instant::now() + PATIENCE;
    let status = loop {
        if let Some(status) = studio.try_wait().unwrap() {
            break status;
        }
        assert!(Instant::now() < deadline, "the studio does not end");
        thread::sleep(Duration::from_millis(20));
    };
    assert!(status.success(), "{status}");
}

#[test]
fn escape_closes_a_menu_and_the_keys_and_only_then_leaves() {
    let display = Display::new();
    let (mut studio, controls) = display.studio_with_controls(&["--listen", "127.0.0.1:0", "--mute"]);
    let press = |key: &str| display.run("xdotool", &["key", key]);
    controls.open("New pot");
    until("the menu of new pots", &controls, |controls| controls.find("bottle").is_some());
    press("Escape");
    until("no menu", &controls, |controls| controls.find("bottle").is_none());
    press("h");
    until("the keys", &controls, |controls| controls.says("these keys").is_some());
    press("Escape");
    until("no keys", &controls, |controls| controls.says("these keys").is_none());
    assert_eq!(studio.try_wait().unwrap(), None, "Esc with something open left the studio");
    press("Escape");
    ends(&mut studio);
}

#[test]
fn a_key_that_is_held_down_replaces_no_file() {
    let home = folder("window-held");
    let pot = home.join("pot.pot");
    let display = Display::new();
    let variables = [("HOME", home.to_str().unwrap())];
    let (mut studio, controls) = display.studio_with_controls_in(&["--listen", "127.0.0.1:0", "--mute"], &variables);
    // the name is of a file that was not there when the studio began
    until("the button", &controls, |controls| controls.find("Save").is_some());
    fs::write(&pot, "precious").unwrap();
    // longer than it takes until a key comes again, some forty times
    display.run("xdotool", &["keydown", "ctrl", "keydown", "s", "sleep", "2", "keyup", "s", "keyup", "ctrl"]);
    until("the question", &controls, |controls| {
        controls.all().iter().any(|control| control.name.contains("ask once more"))
    });
    assert_eq!(fs::read(&pot).unwrap(), b"precious");
    display.run("xdotool", &["key", "ctrl+s"]);
    until("the pot is written", &controls, |controls| controls.says("written").is_some());
    PotFile::read(&pot).unwrap();
    display.run("xdotool", &["key", "Escape"]);
    ends(&mut studio);
    fs::remove_dir_all(home).unwrap();
}
