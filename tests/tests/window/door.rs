//! Who is not let in yet has a window that says so, works or looks on in it once a teacher opens, and reads it when one does not.
//!
//! A real server and real windows on a virtual display, and a teacher without one.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::net::SocketAddr;
use std::process::Child;
use std::time::{Duration, Instant};

use pottery_client::device::pointer;
use pottery_client::stroke::Stroke;
use pottery_client::{Command, Potter, PotterOptions, Target, endpoint};
use pottery_server::{Server, ServerConfig};
use pottery_shared::protocol::{Order, Presence};
use pottery_tests::display::{Controls, Display};

const PATIENCE: Duration = Duration::from_secs(60);
/// A line on which nothing is said any more is given up after ten seconds; who says goodbye is not waited for so long.
const GOODBYE_WITHIN: Duration = Duration::from_secs(8);
const WAITS: &str = "waiting for the teacher to let you in";

/// The numbers of those who wait at the door.
fn waiting(teacher: &Potter) -> Vec<u16> {
    let view = teacher.view().lock();
    view.class.people().filter(|person| person.presence == Presence::Waiting).map(|person| person.client).collect()
}

fn until_somebody_waits(teacher: &Potter) -> u16 {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let [client] = waiting(teacher)[..] {
            return client;
        }
        assert!(Instant::now() < deadline, "nobody comes to the door");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn until_nobody_waits(teacher: &Potter) {
    let deadline = Instant::now() + GOODBYE_WITHIN;
    while !waiting(teacher).is_empty() {
        assert!(Instant::now() < deadline, "somebody waits still");
        std::thread::sleep(Duration::from_millis(50));
    }
}

fn until_said(window: &Controls<'_>, what: &str) {
    let deadline = Instant::now() + PATIENCE;
    while window.says(what).is_none() {
        assert!(Instant::now() < deadline, "'{what}' is not said: {:#?}", window.all());
        std::thread::sleep(Duration::from_millis(50));
    }
}

/// Whether a window that is left with Esc ends well.
fn leaves(display: &Display, studio: &mut Child) -> bool {
    let deadline = Instant::now() + PATIENCE;
    loop {
        if let Some(status) = studio.try_wait().unwrap() {
            return status.success();
        }
        assert!(Instant::now() < deadline, "the window does not close");
        display.run("xdotool", &["key", "Escape"]);
        std::thread::sleep(Duration::from_millis(300));
    }
}

#[test]
fn who_waits_at_a_door_has_a_window_that_says_so_and_goes_on_in_it_once_let_in() {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let listen = SocketAddr::from(([127, 0, 0, 1], 0));
    let config = ServerConfig { listen, wheels: 2, has_lobby: true, ..ServerConfig::default() };
    let server = runtime.block_on(async { Server::start(config) }).unwrap();
    let own = runtime.block_on(async { endpoint() }).unwrap();
    let target = Target {
        teacher: server.teacher_token().copied(),
        ..Target::new(server.address().to_string(), server.code().clone(), 1)
    };
    let (_, device) = pointer();
    let teacher = runtime.block_on(Potter::join(&own, &target, Box::new(device), PotterOptions::default())).unwrap();
    let answer = |client, is_let_in| {
        assert!(teacher.command(Command::Order(Order::Admit { client, is_admitted: is_let_in })));
    };

    let (address, code) = (server.address().to_string(), server.code().to_string());
    let join = ["join", &address, "--code", &code, "--wheel", "2", "--mute"];
    let display = Display::new();
    let recording = pottery_tests::programs::folder("door").join("stroke.csv");
    let (mut works, window) =
        display.studio_with_controls(&[&join[..], &["--record", recording.to_str().unwrap()]].concat());
    let client = until_somebody_waits(&teacher);
    until_said(&window, WAITS);
    answer(client, true);
    until_said(&window, "wheel, rpm");
    assert_eq!(window.says(WAITS), None);
    assert!(window.find("Look on instead").is_none(), "who records stays at the wheel");
    let at_wheel =
        |wheel| teacher.view().lock().class.people().any(|person| person.client == client && person.wheel == wheel);
    assert!(at_wheel(2), "{:?}", teacher.view().lock().class);
    // a tool in hand, long enough for it to be recorded
    display.run("xdotool", &["mousemove", "625", "320", "sleep", "1"]);
    assert!(leaves(&display, &mut works));
    Stroke::read(&recording).unwrap();

    let (mut looks, window) = display.studio_with_controls(&[&join[..], &["--watch", "gallery"]].concat());
    let client = until_somebody_waits(&teacher);
    until_said(&window, WAITS);
    answer(client, true);
    until_said(&window, "click");
    assert!(leaves(&display, &mut looks));

    // who goes is not waited for
    let (mut goes, window) = display.studio_with_controls(&join);
    until_somebody_waits(&teacher);
    until_said(&window, WAITS);
    assert!(leaves(&display, &mut goes));
    until_nobody_waits(&teacher);

    let (mut refused, window) = display.studio_with_controls(&join);
    let client = until_somebody_waits(&teacher);
    until_said(&window, WAITS);
    answer(client, false);
    until_said(&window, "the teacher");
    assert!(!leaves(&display, &mut refused), "who was sent away has not worked");

    // nor has who waited at a studio that closed
    let (mut left, window) = display.studio_with_controls(&join);
    until_somebody_waits(&teacher);
    until_said(&window, WAITS);
    drop(runtime.block_on(teacher.leave()).unwrap());
    runtime.block_on(server.stop());
    until_said(&window, "the studio at");
    assert!(!leaves(&display, &mut left));
}
