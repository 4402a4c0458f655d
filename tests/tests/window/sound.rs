//! The sound of a window: heard while a hand presses, silenced and brought back by a key, and off from the beginning with a flag.
//!
//! A real window on a virtual display with a simulated hand in it; the sound server is `tests/src/twin/pulse.rs`, whatever this machine has.

#![cfg(target_os = "linux")]

use std::process::Child;
use std::time::{Duration, Instant};

use pottery_client::sound::RATE_HZ;
use pottery_tests::display::{Controls, Display};
use pottery_tests::programs::folder;
use pottery_tests::twin::pulse::{PulseTwin, Trouble};

/// How long anything takes at most; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);
/// What is loud enough to be heard, of full scale.
const HEARD: f32 = 0.01;

fn until(what: &str, controls: &Controls<'_>, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}: {:#?}", controls.all());
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// Whether the hand presses with more than it takes to be heard.
fn presses(controls: &Controls<'_>) -> bool {
    let force_n = |name: &str| name.strip_suffix(" N")?.parse::<f32>().ok();
    controls.all().iter().filter_map(|control| force_n(&control.name)).any(|force_n| force_n > 0.3)
}

/// Waits until the server gets nothing but zeros, and sees that it stays so for a second of samples in which the hand presses.
fn is_silent(server: &PulseTwin, controls: &Controls<'_>) {
    until("it is not silent", controls, || server.loudest() == Some(0.0));
    let enough = server.samples() + u64::from(RATE_HZ);
    let mut has_pressed = false;
    until("nothing is pressed, or no samples come", controls, || {
        assert_eq!(server.loudest(), Some(0.0), "it is heard again");
        has_pressed |= presses(controls);
        has_pressed && server.samples() > enough
    });
}

/// Turns the wheel, since what hardly goes by under a tool is hardly heard.
fn turn_the_wheel(display: &Display, controls: &Controls<'_>) {
    until("nothing is pressed", controls, || presses(controls));
    for _ in 0..6 {
        display.run("xdotool", &["key", "Up"]);
    }
}

fn is_heard(server: &PulseTwin, controls: &Controls<'_>) {
    until("nothing is heard", controls, || server.loudest().is_some_and(|loudest| loudest > HEARD));
}

fn close(display: &Display, mut studio: Child) {
    display.run("xdotool", &["key", "Escape"]);
    studio.wait().expect("the studio ends");
}

#[test]
fn clay_is_heard_in_a_window_until_a_key_silences_it_and_again_with_the_same_key() {
    let display = Display::new();
    let out = folder("window-sound");
    let path = out.join("native");
    let server = PulseTwin::listen(&path, Trouble::None);
    let at = format!("unix:{}", path.display());
    let device = display.hand_that_goes_on();
    let arguments = ["--listen", "127.0.0.1:0", "--device", &device];
    let (studio, controls) = display.studio_with_controls_in(&arguments, &[("PULSE_SERVER", &at)]);
    turn_the_wheel(&display, &controls);
    is_heard(&server, &controls);
    for _ in 0..2 {
        display.run("xdotool", &["key", "m"]);
        is_silent(&server, &controls);
        display.run("xdotool", &["key", "m"]);
        is_heard(&server, &controls);
    }
    close(&display, studio);
    std::fs::remove_dir_all(out).expect("the folder was there");
}

#[test]
fn a_window_with_the_flag_is_silent_from_the_beginning_until_the_key_lets_it_be_heard() {
    let display = Display::new();
    let out = folder("window-mute");
    let path = out.join("native");
    let server = PulseTwin::listen(&path, Trouble::None);
    let at = format!("unix:{}", path.display());
    let device = display.hand_that_goes_on();
    let arguments = ["--listen", "127.0.0.1:0", "--device", &device, "--mute"];
    let (studio, controls) = display.studio_with_controls_in(&arguments, &[("PULSE_SERVER", &at)]);
    until("nothing is pressed", &controls, || {
        assert!(server.loudest().is_none_or(|loudest| loudest == 0.0), "it is heard before anybody said so");
        presses(&controls) && server.loudest().is_some()
    });
    turn_the_wheel(&display, &controls);
    is_silent(&server, &controls);
    display.run("xdotool", &["key", "m"]);
    is_heard(&server, &controls);
    close(&display, studio);
    // the flag is for this time, and is not remembered
    let (studio, controls) = display.studio_with_controls_in(&arguments[..4], &[("PULSE_SERVER", &at)]);
    turn_the_wheel(&display, &controls);
    is_heard(&server, &controls);
    close(&display, studio);
    std::fs::remove_dir_all(out).expect("the folder was there");
}
