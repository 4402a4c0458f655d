//! Looking on, working at that wheel and looking on again in one window: the pot is there in every picture.
//!
//! A real server and a real window on a virtual display.

use std::net::SocketAddr;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use pottery_client::Target;
use pottery_server::{Server, ServerConfig};
use pottery_tests::display::{Controls, Display, SIZE};

/// Around the middle of the picture, where a pot stands however much of the window a panel covers.
const MIDDLE: [usize; 4] = [400, 250, 350, 250];

/// The last of two on the second page of those that are looked on at together.
const WHEEL: u16 = 62;

fn clay(pixels: &[u8]) -> usize {
    let [left, top, width, height] = MIDDLE;
    let at = (top..top + height).flat_map(|y| (left..left + width).map(move |x| (y * SIZE.0 + x) * 3));
    at.filter(|&at| i32::from(pixels[at]) > i32::from(pixels[at + 2]) + 24).count()
}

/// Is set with the value's end, also when a test fails: the thread that waits for it would keep the test from ending.
struct SetAtEnd<'a>(&'a AtomicBool);

impl Drop for SetAtEnd<'_> {
    fn drop(&mut self) {
        self.0.store(true, Ordering::Relaxed);
    }
}

fn until(what: &str, window: &Controls<'_>, is_so: impl Fn(&Controls<'_>) -> bool) {
    let deadline = Instant::now() + Duration::from_secs(60);
    while !is_so(window) {
        assert!(Instant::now() < deadline, "{what}: {:#?}", window.all());
        std::thread::sleep(Duration::from_millis(50));
    }
}

#[test]
fn a_visitor_works_at_the_wheel_that_is_looked_at_and_looks_on_again_and_the_pot_never_blinks() {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let listen = SocketAddr::from(([127, 0, 0, 1], 0));
    let config = ServerConfig { listen, wheels: WHEEL, ..ServerConfig::default() };
    let server = runtime.block_on(async { Server::start(config) }).unwrap();
    let target = Target::new(server.address().to_string(), server.code().clone(), WHEEL);
    let people = || runtime.block_on(server.standing()).unwrap().people;

    let display = Display::new();
    let (address, code, wheel) = (target.address.clone(), target.code.to_string(), WHEEL.to_string());
    let arguments = ["join", &address, "--code", &code, "--watch", "spectator", "--wheel", &wheel, "--mute"];
    let (mut studio, window) = display.studio_with_controls(&arguments);
    until("a wheel is seen", &window, |window| window.find("Work at this wheel").is_some());
    until("a pot is seen", &window, |_| clay(&display.pixels()) > 5000);

    // the display is looked at all the while
    let is_over = AtomicBool::new(false);
    let (least, looks) = std::thread::scope(|scope| {
        let looking = scope.spawn(|| {
            let (mut least, mut looks) = (usize::MAX, 0);
            while !is_over.load(Ordering::Relaxed) {
                (least, looks) = (least.min(clay(&display.pixels())), looks + 1);
            }
            (least, looks)
        });
        let watched = SetAtEnd(&is_over);
        for _ in 0..2 {
            window.press("Work at this wheel");
            until("the panel of who works", &window, |window| window.find("Look on instead").is_some());
            until("one person is left", &window, |_| people() == 1);
            window.press("Look on instead");
            until("the button of who looks on", &window, |window| window.find("Work at this wheel").is_some());
            until("one person is left", &window, |_| people() == 1);
        }
        drop(watched);
        looking.join().unwrap()
    });
    println!("at least {least} pixels of clay in {looks} pictures");
    assert!(least > 4000 && looks > 20, "{least} in {looks}");
    display.run("xdotool", &["key", "Escape"]);
    let deadline = Instant::now() + Duration::from_secs(60);
    let status = loop {
        if let Some(status) = studio.try_wait().unwrap() {
            break status;
        }
        if Instant::now() > deadline {
            studio.kill().unwrap();
        }
        display.run("xdotool", &["key", "Escape"]);
        std::thread::sleep(Duration::from_millis(300));
    };
    assert!(status.success());
    runtime.block_on(server.stop());
}

#[test]
fn a_force_that_is_off_is_off_for_who_looks_on_and_comes_back() {
    let runtime = tokio::runtime::Runtime::new().unwrap();
    let listen = SocketAddr::from(([127, 0, 0, 1], 0));
    let server = runtime.block_on(async { Server::start(ServerConfig { listen, ..ServerConfig::default() }) }).unwrap();
    let (address, code) = (server.address().to_string(), server.code().to_string());
    let display = Display::new();
    let arguments = ["join", &address, "--code", &code, "--watch", "spectator", "--mute"];
    let (mut studio, window) = display.studio_with_controls(&arguments);
    until("a wheel is seen", &window, |window| window.find("Work at this wheel").is_some());
    window.press("Work at this wheel");
    until("the panel of who works", &window, |window| window.find("Look on instead").is_some());
    assert_eq!(window.says("the force is off"), None);
    display.run("xdotool", &["key", "Return"]);
    until("that the force is off", &window, |window| window.says("the force is off").is_some());
    window.press("Look on instead");
    until("the button of who looks on", &window, |window| window.find("Work at this wheel").is_some());
    window.press("Work at this wheel");
    until("the panel of who works", &window, |window| window.find("Look on instead").is_some());
    until("that the force is still off", &window, |window| window.says("the force is off").is_some());
    studio.kill().unwrap();
    studio.wait().unwrap();
    runtime.block_on(server.stop());
}
