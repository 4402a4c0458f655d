//! What a window shows of the force: bar, device, rates and how it is felt; and the key that ends it.
//!
//! A real window on a virtual display; a simulated hand that presses, or a mouse that rests.

use std::time::{Duration, Instant};

use pottery_tests::display::{Controls, Display};

/// How long anything takes at most; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);
/// How long a force that is off is looked at.
const OFF: Duration = Duration::from_secs(2);

/// Waits until something is said that is so.
fn until(controls: &Controls<'_>, what: &str, is_so: impl Fn(&str) -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !controls.all().iter().any(|control| is_so(&control.name)) {
        assert!(Instant::now() < deadline, "{what}: {:#?}", controls.all());
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// The force that the bar shows, N.
fn force_n(controls: &Controls<'_>) -> Option<f32> {
    controls.all().iter().find_map(|control| control.name.strip_suffix(" N")?.parse().ok())
}

#[test]
fn the_force_of_a_hand_is_shown_and_ends_with_one_key_while_the_session_goes_on() {
    let display = Display::new();
    let device = display.hand_that_goes_on();
    let (mut studio, controls) =
        display.studio_with_controls(&["--listen", "127.0.0.1:0", "--mute", "--device", &device]);
    let key = |name: &str| display.run("xdotool", &["key", name]);
    let presses = || force_n(&controls).is_some_and(|force_n| force_n > 0.3);
    let deadline = Instant::now() + PATIENCE;
    while !presses() {
        assert!(Instant::now() < deadline, "nothing is felt: {:#?}", controls.all());
        std::thread::sleep(Duration::from_millis(50));
    }
    until(&controls, "it is not said that nobody holds it", |said| said == "nobody holds this tool: it goes by itself");
    // the rate is the one that is measured: real time, so of a loop that is kept from its ticks too
    until(&controls, "the hand's rate is not shown", |said| {
        let (_, rate) = said.split_once("simulated, hand ").unwrap_or_default();
        let measured = rate.split_once(" kHz").and_then(|(rate, _)| rate.parse::<f32>().ok());
        rate.contains('.') && measured.is_some_and(|khz| (0.3..=1.05).contains(&khz))
    });

    key("Return");
    until(&controls, "the force is not said to be off", |said| said.starts_with("the force is off"));
    // what was drawn before the key came may be read once
    let deadline = Instant::now() + PATIENCE;
    while force_n(&controls) != Some(0.0) {
        assert!(Instant::now() < deadline, "a force that is off is shown: {:#?}", controls.all());
        std::thread::sleep(Duration::from_millis(50));
    }
    let looked = Instant::now();
    while looked.elapsed() < OFF {
        std::thread::sleep(Duration::from_millis(50));
        assert_eq!(force_n(&controls), Some(0.0));
    }
    assert!(studio.try_wait().expect("it can be asked").is_none(), "the session goes on");
    key("Return");
    until(&controls, "the force does not come back", |said| said.starts_with("No force at once"));
    let deadline = Instant::now() + PATIENCE;
    while !presses() {
        assert!(Instant::now() < deadline, "nothing is felt any more: {:#?}", controls.all());
        std::thread::sleep(Duration::from_millis(50));
    }

    // the bar stays when everything else is folded away
    key("p");
    let deadline = Instant::now() + PATIENCE;
    while controls.find("No force at once").is_some() {
        assert!(Instant::now() < deadline, "the controls are not folded: {:#?}", controls.all());
        std::thread::sleep(Duration::from_millis(50));
    }
    assert!(force_n(&controls).is_some(), "{:#?}", controls.all());
    key("Escape");
    studio.wait().expect("the studio ends");
}

#[test]
fn a_device_that_is_not_there_is_said_so_while_the_force_is_off_too_and_the_mouse_lags() {
    let display = Display::new();
    // nobody answers at the port where the service would be
    let device = "inverse3:address=127.0.0.1:9";
    let (mut studio, controls) =
        display.studio_with_controls(&["--listen", "127.0.0.1:0", "--mute", "--device", device]);
    until(&controls, "the lag is not said", |said| said == "the drawn tool stays behind by the force");
    let is_missed = |said: &str| said.starts_with("no Haply Inverse3 was found") && said.contains("127.0.0.1:9");
    until(&controls, "the device's sentence is not there", is_missed);
    display.run("xdotool", &["key", "Return"]);
    until(&controls, "Enter does nothing", |said| said.starts_with("Give force again"));
    until(&controls, "the device's sentence is gone", is_missed);
    display.run("xdotool", &["key", "Escape"]);
    studio.wait().expect("the studio ends");
}
