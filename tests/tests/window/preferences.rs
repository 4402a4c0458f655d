//! The studio's window as a person finds it again: what is liked is kept, shown, and never lost.
//!
//! A real window on a virtual display, driven by keys.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::io::Read;
use std::process::Child;
use std::time::{Duration, Instant};

use pottery_client::Link;
use pottery_client::pot_file::PotFile;
use pottery_shared::clay::{Conditions, Pot, PotSpec};
use pottery_shared::snapshot::PotRecord;
use pottery_shared::units::Tick;
use pottery_tests::display::{Display, SIZE};
use pottery_tests::programs::folder;

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
    // dark beside the button, as an empty display is too, and light letters on it
    let is_lesson = |pixels: &[u8]| {
        let is_dark = colour(pixels, [SKIP.0 + 60, SKIP.1 - 4, 200, 10]).iter().all(|value| *value < 45.0);
        let is_lit = |x: usize| colour(pixels, [x, SKIP.1 - 6, 1, 12]).iter().any(|value| *value > 80.0);
        is_dark && (SKIP.0 - 16..SKIP.0 + 16).any(is_lit)
    };
    until(&display, "the lesson", is_lesson);
    display.run("xdotool", &["mousemove", &SKIP.0.to_string(), &SKIP.1.to_string()]);
    std::thread::sleep(Duration::from_millis(500));
    display.run("xdotool", &["click", "1"]);
    until(&display, "the wheel without a lesson", |pixels| !is_lesson(pixels));
    close(&display, studio);
    assert!(fs::read_to_string(display.preferences()).unwrap().contains("knows_lesson = true"));
}

#[test]
fn a_key_that_is_down_when_the_window_comes_to_the_front_was_another_ones() {
    let display = Display::new();
    let mut studio = open(&display);
    let window = display.window(&[]);
    until(&display, "clay", |pixels| {
        let [red, _, blue] = colour(pixels, POT);
        red > blue + 30.0
    });
    for _ in 0..3 {
        display.leave_windows();
        display.run("xdotool", &["keydown", "Escape", "windowfocus", &window, "sleep", "0.3", "keyup", "Escape"]);
    }
    std::thread::sleep(Duration::from_millis(700));
    assert!(studio.try_wait().unwrap().is_none(), "it closed");
    close(&display, studio);
}

#[test]
fn without_a_graphics_driver_a_window_is_one_sentence_with_what_to_install() {
    let display = Display::new();
    let none = ["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].map(|variable| (variable, "/nonexistent.json"));
    let none = [("WGPU_BACKEND", "vulkan"), none[0], none[1]];
    let studio = display.studio_that_logs(&["--listen", "127.0.0.1:0", "--mute"], "off", &none);
    let output = studio.wait_with_output().unwrap();
    let said = String::from_utf8_lossy(&output.stderr).into_owned();
    let own: Vec<_> = said.lines().filter(|line| line.starts_with("pottery-studio: ")).collect();
    assert!(!output.status.success() && own.len() == 1 && own[0].contains("mesa-vulkan-drivers"), "{said}");
    assert!(!said.contains("panicked"), "{said}");
}

#[cfg(target_os = "linux")]
#[test]
fn what_cannot_be_written_is_said_in_the_panel_and_nothing_is_lost() {
    let (display, folder) = (Display::new(), folder("unwritten-window"));
    let pot = folder.join("own.pot");
    PotFile::of(&Pot::new(PotSpec::default()).unwrap(), &Conditions::default(), Tick(0)).write(&pot).unwrap();
    let kept = fs::read(&pot).unwrap();
    let arguments = ["--listen", "127.0.0.1:0", "--mute", "--open", pot.to_str().unwrap()];
    let (studio, window) = display.studio_with_controls(&arguments);
    let until_said = |what: &str| {
        let deadline = Instant::now() + PATIENCE;
        while !window.all().iter().any(|control| control.name.contains(what)) {
            assert!(Instant::now() < deadline, "'{what}' is not said: {:#?}", window.all());
            std::thread::sleep(Duration::from_millis(100));
        }
    };
    // a full disk stands where the pot and the solid are to go
    let aside = folder.join("aside.pot");
    for (key, name) in [("ctrl+s", "own.pot"), ("ctrl+e", "own.stl")] {
        let place = folder.join(name);
        if place.exists() {
            fs::rename(&place, &aside).unwrap();
        }
        std::os::unix::fs::symlink("/dev/full", &place).unwrap();
        display.run("xdotool", &["key", key]);
        if name == "own.stl" {
            // there is something of that name, which was not written here
            until_said("is there already");
            display.run("xdotool", &["key", key]);
        }
        until_said("the disk is full");
        fs::remove_file(&place).unwrap();
    }
    // and with room again it is saved: the wheel has what it had
    display.run("xdotool", &["key", "ctrl+s"]);
    until_said("written: ");
    assert_eq!(PotFile::read(&pot).unwrap().pot(), PotFile::read(&aside).unwrap().pot());
    assert!(fs::read(&aside).unwrap() == kept);
    // a pot from the future is refused in the same place
    let mut future = kept;
    future[8..12].copy_from_slice(&3_u32.to_le_bytes());
    fs::write(&pot, &future).unwrap();
    display.run("xdotool", &["key", "ctrl+o"]);
    until_said("newer");
    close(&display, studio);
    fs::remove_dir_all(folder).unwrap();
}

/// How many pixels right of the panel are clay, and in which share of its rows the pot is as wide as in the middle one.
fn clay(pixels: &[u8]) -> (usize, f64) {
    let is_clay = |x: usize, y: usize| {
        let at = (y * SIZE.0 + x) * 3;
        i32::from(pixels[at]) > i32::from(pixels[at + 2]) + 24
    };
    let rows: Vec<usize> = (0..640).map(|y| (290..SIZE.0).filter(|x| is_clay(*x, y)).count()).collect();
    // the mark on the wheel head is as red in some places: it is narrower than the pot
    let mut filled: Vec<usize> = rows.iter().copied().filter(|count| *count > 60).collect();
    filled.sort_unstable();
    let wide = filled.get(filled.len() / 2).copied().unwrap_or(1);
    let even = filled.iter().filter(|count| count.abs_diff(wide) <= wide / 50).count();
    (rows.iter().sum(), even as f64 / filled.len().max(1) as f64)
}

#[test]
fn a_pot_that_is_left_without_saving_is_put_on_the_wheel_by_a_button_the_next_time() {
    let display = Display::new();
    let left = display.data().join("unsaved-1").join("wheel-1-last.pot");
    let new = Pot::new(PotSpec::default()).unwrap();
    let arguments = ["--listen", "127.0.0.1:0", "--mute"];
    let (studio, window) = display.studio_with_controls(&arguments);
    assert!(window.find("The pot of last time").is_none(), "there is none yet");
    until(&display, "clay", |pixels| clay(pixels).0 > 20_000);
    display.run("xdotool", &["mousemove", "640", "340", "mousedown", "1", "sleep", "2", "mouseup", "1"]);
    close(&display, studio);
    let pressed = PotFile::read(&left).unwrap().pot().clone();
    assert!(pressed != PotRecord::of(&new), "nothing was pressed");

    // who looks and leaves again has lost nothing
    let (studio, window) = display.studio_with_controls(&arguments);
    until(&display, "clay", |pixels| clay(pixels).0 > 20_000);
    assert!(window.find("The pot of last time").is_some(), "{:#?}", window.all());
    close(&display, studio);
    assert_eq!(*PotFile::read(&left).unwrap().pot(), pressed);

    let (studio, window) = display.studio_with_controls(&arguments);
    window.press("The pot of last time");
    let deadline = Instant::now() + PATIENCE;
    while !window.all().iter().any(|control| control.name.contains("is put on the wheel")) {
        assert!(Instant::now() < deadline, "it is not put on the wheel: {:#?}", window.all());
        std::thread::sleep(Duration::from_millis(50));
    }
    // it is on the wheel, and so it is left once more
    fs::remove_file(&left).unwrap();
    close(&display, studio);
    assert_eq!(*PotFile::read(&left).unwrap().pot(), pressed);
}

#[test]
fn a_window_opens_where_what_is_pressed_cannot_be_put_by_and_says_so() {
    let display = Display::new();
    fs::write(display.data().join("unsaved-1"), "what somebody has there").unwrap();
    let mut studio = open(&display);
    let mut said = studio.stderr.take().unwrap();
    close(&display, studio);
    let mut text = String::new();
    said.read_to_string(&mut text).unwrap();
    assert!(text.contains("what is pressed is not put by: ") && text.contains("is a file and no folder"), "{text}");
}

#[test]
fn what_a_camera_reads_is_the_link_to_the_studio() {
    let display = Display::new();
    let (studio, window) = display.studio_with_controls(&["--listen", "127.0.0.1:0", "--mute"]);
    window.press("Code for a camera");
    // a reader that another project wrote looks at the whole window
    let read = |pixels: &[u8]| {
        let luma = |x: usize, y: usize| pixels[(y * SIZE.0 + x) * 3 + 1];
        let mut picture = rqrr::PreparedImage::prepare_from_greyscale(SIZE.0, SIZE.1, luma);
        let codes = picture.detect_grids();
        codes.first().and_then(|code| code.decode().ok()).map(|(_, text)| text)
    };
    until(&display, "a code that can be read", |pixels| read(pixels).is_some());
    let link: Link = read(&display.pixels()).unwrap().parse().unwrap();
    let address = format!("address  {}", link.0.address);
    assert_eq!(window.says("address  "), Some(address));
    assert!(window.says(&link.0.code.to_string()).is_some(), "{} is not shown", link.0.code);
    close(&display, studio);
}

/// The clay that is seen once nothing of it changes any more: a picture may be on its way for as long as others draw.
fn stays(display: &Display) -> (usize, f64) {
    let deadline = Instant::now() + PATIENCE;
    let (mut seen, mut times) = (clay(&display.pixels()), 0);
    while times < 3 {
        assert!(Instant::now() < deadline, "the clay that is seen goes on changing");
        std::thread::sleep(Duration::from_millis(400));
        let now = clay(&display.pixels());
        (seen, times) = (now, if now.0 == seen.0 { times + 1 } else { 0 });
    }
    seen
}

#[test]
fn keys_bring_the_view_closer_and_farther_and_show_the_pot_from_the_side_and_from_above() {
    let display = Display::new();
    let studio = open(&display);
    until(&display, "clay", |pixels| clay(pixels).0 > 20_000);
    display.run("xdotool", &["mousemove", "140", "672", "key", "space"]);
    let key = |key: &str, what: &str, is_so: &dyn Fn((usize, f64)) -> bool| {
        display.run("xdotool", &["key", "--delay", "60", key, key, key]);
        until(&display, what, |pixels| is_so(clay(pixels)));
        let seen = stays(&display);
        println!("{what}: {} pixels, {:.2} of the rows as wide", seen.0, seen.1);
        seen
    };
    let first = key("1", "the view as at first", &|_| true);
    key("Prior", "a pot that is closer", &|(pixels, _)| pixels as f64 > 1.4 * first.0 as f64);
    key("1", "the view as at first", &|(pixels, _)| pixels.abs_diff(first.0) < first.0 / 50);
    key("Next", "a pot that is farther away", &|(pixels, _)| (pixels as f64) < 0.7 * first.0 as f64);
    key("1", "the view as at first", &|(pixels, _)| pixels.abs_diff(first.0) < first.0 / 50);
    // upright and even from the side, without the perspective of a look from above
    assert!(first.1 < 0.6, "{first:?}");
    key("2", "the pot from the side", &|(_, even)| even > 0.7);
    key("3", "the pot from above", &|(pixels, even)| even < 0.6 && (pixels as f64) < 0.65 * first.0 as f64);
    close(&display, studio);
}
