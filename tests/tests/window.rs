//! The studio's window as a person finds it again: what is liked is kept, shown, and never lost.
//!
//! A real window on a virtual display, driven by keys.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::process::Child;
use std::time::{Duration, Instant};

use pottery_tests::display::{Display, SIZE};

/// How long the program takes at most to do what it was asked for; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);

/// Opens a studio that fills the display.
fn open(display: &Display) -> Child {
    let studio = display.studio(&["--listen", "127.0.0.1:0"]);
    let window = display.window(&[]);
    let (width, height) = (SIZE.0.to_string(), SIZE.1.to_string());
    display.run("xdotool", &["windowsize", "--sync", &window, &width, &height]);
    display.run("xdotool", &["windowmove", "--sync", &window, "0", "0", "windowfocus", &window]);
    studio
}

fn close(display: &Display, mut studio: Child) {
    display.run("xdotool", &["key", "Escape"]);
    let deadline = Instant::now() + PATIENCE;
    while studio.try_wait().unwrap().is_none() {
        assert!(Instant::now() < deadline, "the studio does not close");
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(studio.wait().unwrap().success());
}

/// Mean red, green and blue of a rectangle: left, top, width, height.
fn colour(pixels: &[u8], [left, top, width, height]: [usize; 4]) -> [f64; 3] {
    let mut sum = [0.0; 3];
    for y in top..top + height {
        for x in left..left + width {
            for (sum, value) in sum.iter_mut().zip(&pixels[(y * SIZE.0 + x) * 3..]) {
                *sum += f64::from(*value);
            }
        }
    }
    sum.map(|sum| sum / (width * height) as f64)
}

/// Looks until the picture is as wanted.
fn until(display: &Display, what: &str, is_so: impl Fn(&[u8]) -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so(&display.pixels()) {
        assert!(Instant::now() < deadline, "{what} is not seen");
        std::thread::sleep(Duration::from_millis(200));
    }
}

/// The middle of the pot, which stands in what the panel leaves free.
const POT: [usize; 4] = [600, 300, 80, 80];
/// A part of the panel without words, at its right edge.
const PANEL: [usize; 4] = [16, 400, 4, 20];

#[test]
fn a_glaze_is_seen_and_still_there_the_next_time() {
    let display = Display::new();
    let studio = open(&display);
    // clay is red, and celadon is green
    until(&display, "clay", |pixels| {
        let [red, green, blue] = colour(pixels, POT);
        red > green + 30.0 && green > blue
    });
    display.run("xdotool", &["key", "--delay", "100", "l", "l"]);
    let is_celadon = |pixels: &[u8]| {
        let [red, green, blue] = colour(pixels, POT);
        green > red + 10.0 && green > blue + 5.0
    };
    until(&display, "celadon", is_celadon);
    close(&display, studio);
    let kept = fs::read_to_string(display.preferences()).unwrap();
    assert!(kept.contains("finish = \"celadon\"") && kept.contains("knows_lesson = true"), "{kept}");
    let studio = open(&display);
    until(&display, "the celadon of before", is_celadon);
    close(&display, studio);
}

#[test]
fn a_light_panel_is_light_and_a_file_that_is_not_understood_is_left_alone() {
    let display = Display::new();
    fs::write(display.preferences(), "knows_lesson = true\ntheme = \"light\"\n").unwrap();
    let studio = open(&display);
    until(&display, "a light panel", |pixels| colour(pixels, PANEL).iter().all(|value| *value > 200.0));
    close(&display, studio);

    let typed = "knows_lesson = true\nthem = \"light\"\n";
    fs::write(display.preferences(), typed).unwrap();
    let studio = open(&display);
    until(&display, "a dark panel", |pixels| colour(pixels, PANEL).iter().all(|value| *value < 60.0));
    display.run("xdotool", &["key", "l"]);
    close(&display, studio);
    assert_eq!(fs::read_to_string(display.preferences()).unwrap(), typed);
}

#[test]
fn a_newcomer_is_shown_the_lesson_until_it_is_skipped() {
    /// Within the lesson's window, on its button.
    const SKIP: (usize, usize) = (705, 650);
    let display = Display::of_newcomer();
    let studio = open(&display);
    let is_lesson =
        |pixels: &[u8]| colour(pixels, [SKIP.0 + 60, SKIP.1 - 4, 200, 10]).iter().all(|value| *value < 45.0);
    until(&display, "the lesson", is_lesson);
    display.run("xdotool", &["mousemove", &SKIP.0.to_string(), &SKIP.1.to_string()]);
    std::thread::sleep(Duration::from_millis(500));
    display.run("xdotool", &["click", "1"]);
    until(&display, "the wheel without a lesson", |pixels| !is_lesson(pixels));
    close(&display, studio);
    assert!(fs::read_to_string(display.preferences()).unwrap().contains("knows_lesson = true"));
}
