//! A student at a window whom a teacher guides: what is seen of the teacher, and the key that ends it.
//!
//! A real window on a virtual display, a real server, and a teacher without a window.

use std::net::SocketAddr;
use std::process::Child;
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::{Pointer, pointer};
use pottery_client::guiding::GuideCommand;
use pottery_client::{Command, Potter, PotterOptions, Target, endpoint};
use pottery_server::{Server, ServerConfig};
use pottery_shared::clay::{Form, PotSpec, Target as Profile};
use pottery_shared::haptics::{Guidance, GuidanceMode};
use pottery_shared::protocol::GuidanceEnd;
use pottery_tests::display::{Display, SIZE};

/// How long anything takes at most; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);

/// Waits until something is so.
async fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}");
        tokio::time::sleep(Duration::from_millis(100)).await;
    }
}

/// How far the panel reaches from the left, pixels; names in it have the colours of who bears them, whatever those are.
const PANEL: usize = 280;

/// Pixels of the display right of the panel that are of a kind.
fn count(display: &Display, is_one: impl Fn([i32; 3]) -> bool) -> usize {
    let pixels = display.pixels();
    let rows = pixels.as_chunks::<3>().0.chunks_exact(SIZE.0);
    rows.flat_map(|row| &row[PANEL..]).filter(|rgb| is_one(rgb.map(i32::from))).count()
}

/// The blue of a pot that is wanted, which lets shine through what is behind, and the yellow of a teacher's line.
fn is_wanted([red, green, blue]: [i32; 3]) -> bool {
    blue > 150 && blue - red > 50 && green > red + 20
}

fn is_line([red, green, blue]: [i32; 3]) -> bool {
    red > 250 && (green - 216).abs() < 6 && (blue - 64).abs() < 10
}

fn open(display: &Display, server: &Server) -> Child {
    let (address, code) = (server.address().to_string(), server.code().to_string());
    let studio = display.studio(&["join", &address, "--code", &code]);
    let window = display.window(&[]);
    let (width, height) = (SIZE.0.to_string(), SIZE.1.to_string());
    display.run("xdotool", &["windowsize", "--sync", &window, &width, &height]);
    display.run("xdotool", &["windowmove", "--sync", &window, "0", "0", "windowfocus", &window]);
    studio
}

#[test]
fn a_student_sees_what_a_teacher_draws_and_wants_and_is_free_with_one_key() {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
    runtime.block_on(async {
        let config = ServerConfig { listen: SocketAddr::from(([127, 0, 0, 1], 0)), ..ServerConfig::default() };
        let server = Server::start(config).unwrap();
        let target = Target::new(server.address().to_string(), server.code().clone(), 1);
        let target = Target { teacher: server.teacher_token().copied(), ..target };
        let (mut hand, device) = pointer();
        let own = endpoint().unwrap();
        let teacher = Potter::join(&own, &target, Box::new(device), PotterOptions::default()).await.unwrap();
        let display = Display::new();
        let mut studio = open(&display, &server);
        let others = || {
            let view = teacher.view().lock();
            view.class.people().map(|person| person.client).find(|client| *client != view.number)
        };
        until("the student is there", || others().is_some()).await;
        let student = others().unwrap();
        let untouched = teacher.view().lock().pot.digest();
        until("the window is drawn", || {
            count(&display, |[red, green, blue]| red > green + 30 && green > blue) > 10_000
        })
        .await;
        assert!(count(&display, is_wanted) < 50 && count(&display, is_line) < 50, "neither is there before");

        let ask = |command| assert!(teacher.command(Command::Guide(command)));
        let bottle = Profile::of(&Form::Bottle.pot(PotSpec::default()).unwrap());
        ask(GuideCommand::Target(Some(Box::new(bottle))));
        until("the pot that is wanted is seen", || count(&display, is_wanted) > 500).await;

        ask(GuideCommand::Guide { student, guidance: Guidance::new(GuidanceMode::Point, 1.0) });
        let is_guiding = || teacher.view().lock().guidance.pair.is_some();
        until("the teacher guides", is_guiding).await;
        // her tool is before the pot, and hides a part of it
        let clay = || count(&display, |[red, green, blue]| red > blue + 24 && red > green + 10);
        let before = clay();
        hand.write(Pointer { target_m: Some(Vec3::new(0.0, -0.1, 0.1)), ..Pointer::default() });
        until("the teacher's tool is seen", || clay() + 700 < before).await;
        for step in 0..150_u8 {
            // along the side of the pot that the student sees, a little into the clay
            let (sin, cos) = (-std::f32::consts::FRAC_PI_2 + 0.004 * (f32::from(step) - 75.0)).sin_cos();
            let target_m = Some(Vec3::new(0.068 * cos, 0.068 * sin, 0.1 + 0.0003 * f32::from(step)));
            hand.write(Pointer { target_m, ..Pointer::default() });
            tokio::time::sleep(Duration::from_millis(10)).await;
        }
        until("the teacher's line is seen", || count(&display, is_line) > 100).await;

        display.run("xdotool", &["key", "j"]);
        until("the student is free", || teacher.view().lock().guidance.ended == Some(GuidanceEnd::Student)).await;
        until("the line is gone", || count(&display, is_line) < 50).await;
        // her tool is still where it pointed, and in the clay
        tokio::time::sleep(Duration::from_millis(500)).await;
        assert_eq!(
            teacher.view().lock().pot.digest(),
            untouched,
            "who pointed presses once the tool was out of the clay"
        );
        display.run("xdotool", &["key", "Escape"]);
        until("the window closes", || studio.try_wait().unwrap().is_some()).await;
        drop(teacher.leave().await.unwrap());
        server.stop().await;
    });
}
