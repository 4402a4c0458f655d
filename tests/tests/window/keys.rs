//! Keys of a real window on a virtual display: what Esc closes before it leaves, and what a key does that is held down.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::process::Child;
use std::thread;
use std::time::{Duration, Instant};

use pottery_client::pot_file::PotFile;
use pottery_client::stroke::Stroke;
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

#[test]
fn clay_is_pressed_with_keys_alone() {
    let home = folder("window-by-keys");
    let recording = home.join("stroke.csv");
    let display = Display::new();
    let arguments = ["--listen", "127.0.0.1:0", "--mute", "--record", recording.to_str().unwrap()];
    let (mut studio, controls) = display.studio_with_controls(&arguments);
    // a pointer over the panel has no say in it; what it clicks on is so already
    controls.press("outside");
    let press = |key: &str, times: usize| {
        let keys: Vec<&str> = std::iter::repeat_n(key, times).collect();
        display.run("xdotool", &[&["key", "--delay", "60"], &keys[..]].concat());
    };
    press("shift+Up", 1);
    press("w", 12);
    press("shift+Right", 20);
    press("s", 12);
    display.run("xdotool", &["key", "Escape"]);
    ends(&mut studio);
    let stroke = Stroke::read(&recording).unwrap();
    let way: Vec<_> = (0..20_000).filter_map(|tick| stroke.at(f64::from(tick) * 1e-3)).collect();
    let away_mm = |at: &glam::Vec3| at.truncate().length() * 1e3;
    let nearest = way.iter().map(away_mm).fold(f32::INFINITY, f32::min);
    // the usual pot has 60 mm and the usual ball 12; it goes no farther than 40 mm
    assert!((40.0..70.0).contains(&nearest), "{nearest} mm from the axis at least");
    let (first, last) = (way.first().unwrap(), way.last().unwrap());
    assert!(away_mm(first) > 72.0 && away_mm(last) > 72.0, "{first} {last}");
    let aside_mm = first.truncate().distance(last.truncate()) * 1e3;
    assert!(aside_mm > 10.0, "{aside_mm} mm");
    fs::remove_dir_all(home).unwrap();
}
