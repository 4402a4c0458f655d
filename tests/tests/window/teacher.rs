//! A teacher at a window: every button of the lesson is clicked on, and the server does what it says.
//!
//! A real window on a virtual display, a real server, a student and a second teacher without windows, who tells what the server says.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::net::SocketAddr;
use std::time::{Duration, Instant};

use pottery_client::device::pointer;
use pottery_client::guiding::GuideCommand;
use pottery_client::view::{Link, View};
use pottery_client::{Command, JoinError, Potter, PotterOptions, Target, endpoint};
use pottery_server::{Server, ServerConfig};
use pottery_shared::haptics::{Guidance, GuidanceMode};
use pottery_shared::protocol::{ClassWire, GuidanceEnd, Presence, Refusal, WheelInfo};
use pottery_shared::session::ClientError;
use pottery_shared::units::{Rpm, Tick};
use pottery_tests::display::Display;

/// How long anything takes at most; reached only when something is wrong.
const PATIENCE: Duration = Duration::from_secs(60);

/// Somebody without a window, whose hand rests.
async fn sit(target: &Target) -> Result<(quinn::Endpoint, Potter), JoinError> {
    let own = endpoint().unwrap();
    let (_, device) = pointer();
    let potter = Potter::join(&own, target, Box::new(device), PotterOptions::default()).await?;
    Ok((own, potter))
}

async fn until(potter: &Potter, what: &str, is_so: impl Fn(&View) -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so(&potter.view().lock()) {
        assert!(Instant::now() < deadline, "{what}: {:?}", potter.view().lock().class);
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

fn class(view: &View, is_so: impl Fn(&ClassWire) -> bool) -> bool {
    view.class.class().is_some_and(is_so)
}

fn wheels(view: &View, is_so: fn(&WheelInfo) -> bool, expected: [bool; 2]) -> bool {
    class(view, |class| class.wheels.iter().map(is_so).eq(expected))
}

async fn clay(server: &Server, what: &str, is_so: impl Fn(&[u64]) -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so(&server.standing().await.unwrap().digests) {
        assert!(Instant::now() < deadline, "{what}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

fn refusal<T>(outcome: Result<T, JoinError>) -> Option<Refusal> {
    match outcome {
        Err(JoinError::Session(ClientError::Refused(refusal))) => Some(refusal),
        _ => None,
    }
}

#[test]
fn every_button_of_the_lesson_does_at_the_server_what_it_says() {
    let runtime = tokio::runtime::Builder::new_multi_thread().worker_threads(2).enable_all().build().unwrap();
    runtime.block_on(async {
        let listen = SocketAddr::from(([127, 0, 0, 1], 0));
        // a wheel that stands still is drawn no more often than something changes
        let config = ServerConfig { listen, wheels: 2, wheel_speed: Rpm(0.0), ..ServerConfig::default() };
        let server = Server::start(config).unwrap();
        let at = |wheel| Target::new(server.address().to_string(), server.code().clone(), wheel);
        let token = *server.teacher_token().unwrap();
        let (_own, witness) = sit(&Target { teacher: Some(token), ..at(2) }).await.unwrap();
        let (_own, student) = sit(&at(1)).await.unwrap();

        let display = Display::new();
        let (address, code, token) = (server.address().to_string(), server.code().to_string(), token.to_string());
        let arguments = ["join", &address, "--code", &code, "--teacher-token", &token, "--wheel", "1", "--mute"];
        let (mut studio, window) = display.studio_with_controls(&arguments);
        until(&witness, "the window's teacher is there", |view| view.class.people().count() == 3).await;
        window.press("The lesson");

        window.press("Freeze");
        until(&witness, "all wheels are frozen", |view| wheels(view, |info| info.is_frozen, [true; 2])).await;
        until(&student, "the student is told", |view| !view.class.may_press()).await;
        window.press("Thaw");
        until(&witness, "no wheel is frozen", |view| wheels(view, |info| info.is_frozen, [false; 2])).await;
        window.open("all wheels");
        window.press("wheel 2");
        window.press("Freeze");
        until(&witness, "wheel 2 alone is frozen", |view| wheels(view, |info| info.is_frozen, [false, true])).await;
        window.press("Thaw");
        until(&witness, "wheel 2 has thawed", |view| wheels(view, |info| info.is_frozen, [false; 2])).await;

        // the window's own wheel is set, and another one like it
        let rpm = |view: &View| view.conditions.wheel.speed(Tick(u64::MAX >> 1)).0.round();
        assert!(rpm(&witness.view().lock()) != 120.0, "it is so already");
        window.press("trim");
        window.press("As mine");
        until(&witness, "wheel 2 turns as the window's", |view| rpm(view) == 120.0).await;
        for potter in [&witness, &student] {
            assert!(potter.command(Command::WheelSpeed(Rpm(0.0))));
            until(potter, "the wheel stands still again", |view| rpm(view) == 0.0).await;
        }

        window.press("Close");
        until(&witness, "wheel 2 is closed", |view| wheels(view, |info| info.is_open, [true, false])).await;
        assert_eq!(refusal(sit(&at(2)).await), Some(Refusal::WheelClosed { wheel: 2 }));
        window.press("Open");
        until(&witness, "wheel 2 is open", |view| wheels(view, |info| info.is_open, [true; 2])).await;

        let before = server.standing().await.unwrap().digests;
        assert_eq!(before[0], before[1], "nobody has pressed");
        window.open("Same pot");
        window.press("bowl");
        clay(&server, "a bowl at wheel 2", |now| now[0] == before[0] && now[1] != before[1]).await;
        window.open("wheel 2");
        window.press("all wheels");
        window.open("Same pot");
        window.press("as on wheel 2");
        clay(&server, "everybody has the same bowl", |now| now[0] == now[1] && now[1] != before[1]).await;
        window.press("Take that back");
        clay(&server, "the first wheel has its pot again", |now| now[0] == before[0]).await;

        window.open("…");
        window.press("to wheel 2");
        let sits = |wheel| move |view: &View| view.class.place().is_some_and(|place| place.wheel == wheel);
        until(&student, "the student sits at wheel 2", sits(2)).await;
        until(&student, "and is connected", |view| view.link == Link::Open).await;

        window.open("choose a student");
        let name = student.view().lock().class.place().unwrap().name;
        window.press(&name.to_string());
        window.press("guide (N)");
        let led = |mode| move |view: &View| view.guidance.pair.is_some_and(|pair| pair.guidance.mode() == mode);
        until(&student, "the student is led", led(GuidanceMode::Lead)).await;
        window.press("let go (J)");
        let ended = |view: &View| view.guidance.pair.is_none() && view.guidance.ended == Some(GuidanceEnd::Teacher);
        until(&student, "the student is free", ended).await;
        window.press("take over (J)");
        let taken_over = |view: &View| view.guidance.pair.is_some_and(|pair| pair.guidance == Guidance::TAKE_OVER);
        until(&student, "the student's tool is taken over", taken_over).await;
        // which the student can always end
        assert!(student.command(Command::Guide(GuideCommand::End)));
        until(&student, "the student is free again", |view| view.guidance.pair.is_none()).await;

        window.open("what the pot is to become");
        window.press("bottle");
        until(&student, "the student knows what the pot is to become", |view| view.guidance.target.is_some()).await;
        let wanted = student.view().lock().guidance.target.clone().unwrap();
        let deadline = Instant::now() + PATIENCE;
        while window.says("wheel 2, ").is_none() {
            assert!(Instant::now() < deadline, "the table is not there: {:#?}", window.all());
            tokio::time::sleep(Duration::from_millis(100)).await;
        }
        for (form, rms_mm) in [("cylinder", 1.0..f64::INFINITY), ("bottle", 0.0..0.06)] {
            window.open("Same pot");
            window.choose(form);
            let deadline = Instant::now() + PATIENCE;
            loop {
                let is_mm = 1e3 * f64::from(wanted.deviation(&server.standing().await.unwrap().pots[1]).rms_m);
                let said = format!("wheel 2, {name}: off by {is_mm:.1} mm RMS");
                if window.says(&said).is_some() && rms_mm.contains(&is_mm) {
                    break println!("{said}");
                }
                assert!(Instant::now() < deadline, "{said}: {:#?}", window.all());
                tokio::time::sleep(Duration::from_millis(100)).await;
            }
        }

        // what a teacher gave everybody half a minute ago comes back
        let bottle = server.standing().await.unwrap().digests[1];
        tokio::time::sleep(Duration::from_secs(30)).await;
        window.open("Same pot");
        window.choose("ball");
        clay(&server, "a ball at wheel 2", |now| now[1] != bottle).await;
        window.open("Back");
        window.press("by 30 s");
        clay(&server, "the bottle of half a minute ago", |now| now[1] == bottle).await;

        window.press("lobby");
        until(&witness, "there is a lobby", |view| class(view, |class| class.has_lobby)).await;
        let waits = |count| {
            move |view: &View| {
                view.class.people().filter(|person| person.presence == Presence::Waiting).count() == count
            }
        };
        let knock = || {
            let there = at(1);
            tokio::spawn(async move { sit(&there).await })
        };
        let coming = knock();
        until(&witness, "somebody waits at the door", waits(1)).await;
        window.press("let in");
        let (_own, admitted) = coming.await.unwrap().unwrap();
        until(&witness, "nobody waits any more", waits(0)).await;
        let coming = knock();
        until(&witness, "somebody else waits", waits(1)).await;
        window.press("send away");
        assert_eq!(refusal(coming.await.unwrap()), Some(Refusal::NotAdmitted));
        let coming = [knock(), knock()];
        until(&witness, "two wait", waits(2)).await;
        window.press("Let all in");
        for coming in coming {
            drop(coming.await.unwrap().unwrap().1.leave().await.unwrap());
        }
        drop(admitted.leave().await.unwrap());
        window.press("lobby");
        until(&witness, "the lobby is closed", |view| class(view, |class| !class.has_lobby)).await;

        window.press("locked");
        until(&witness, "the door is locked", |view| class(view, |class| class.is_locked)).await;
        assert_eq!(refusal(sit(&at(1)).await), Some(Refusal::Locked));
        window.press("locked");
        until(&witness, "the door is open", |view| class(view, |class| !class.is_locked)).await;
        window.press("New code");
        until(&witness, "there is another code", |view| class(view, |class| class.code != server.code().room())).await;
        assert_eq!(refusal(sit(&at(1)).await), Some(Refusal::CodeGone));

        window.press("End the lesson");
        window.press("Send everybody home?");
        until(&student, "the student is sent home", |view| view.link == Link::Closed).await;
        assert!(matches!(witness.view().lock().link, Link::Open), "a teacher stays");
        display.run("xdotool", &["mousemove", "700", "20", "key", "Escape"]);
        let deadline = Instant::now() + PATIENCE;
        while studio.try_wait().unwrap().is_none() {
            assert!(Instant::now() < deadline, "the window does not close");
            tokio::time::sleep(Duration::from_millis(50)).await;
        }
        drop((student.leave().await.unwrap(), witness.leave().await.unwrap()));
        server.stop().await;
    });
}
