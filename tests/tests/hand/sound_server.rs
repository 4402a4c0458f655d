//! What a sound server gets of the clay, and what is said where there is none: the way to it is read from variables, so that each test
//! runs in a process that has its own.
//!
//! The server is `tests/src/twin/pulse.rs`, whatever this machine has.

#![cfg(target_os = "linux")]

use std::os::unix::net::UnixListener;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use pottery_client::sound::{RATE_HZ, Rub, Sound, SoundError};
use pottery_tests::programs::{anew, folder, is_anew};
use pottery_tests::twin::pulse::{PulseTwin, Trouble};

const PATIENCE: Duration = Duration::from_secs(60);
const USUAL: Rub = Rub { force_n: 1.5, slip_m_s: 0.3, wetness: 0.27 };
/// What is loud enough to be heard, of full scale.
const HEARD: f32 = 0.01;

fn until(what: &str, mut is_so: impl FnMut() -> bool) {
    let deadline = Instant::now() + PATIENCE;
    while !is_so() {
        assert!(Instant::now() < deadline, "{what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Waits until the server hears nothing but zeros, and sees that it stays so for half a second of samples.
fn is_silent(server: &PulseTwin) {
    until("it is not silent", || server.loudest() == Some(0.0));
    let enough = server.samples() + u64::from(RATE_HZ) / 2;
    until("no samples come", || {
        assert_eq!(server.loudest(), Some(0.0), "it is heard again");
        server.samples() > enough
    });
}

fn is_heard(server: &PulseTwin) {
    until("nothing is heard", || server.loudest().is_some_and(|loudest| loudest > HEARD));
}

/// Runs the test anew where the server would be at a path, and says which that is in the process that it runs in.
fn where_the_server_is(test: &str) -> Option<PathBuf> {
    if is_anew() {
        let server = std::env::var("PULSE_SERVER").expect("it was set");
        return Some(server.strip_prefix("unix:").expect("it is a path").into());
    }
    let out = folder(&format!("sound-{test}"));
    let server = format!("unix:{}", out.join("native").display());
    anew(test, &[("PULSE_SERVER", Some(server.as_ref())), ("PULSE_RUNTIME_PATH", None), ("XDG_RUNTIME_DIR", None)]);
    std::fs::remove_dir_all(out).expect("the folder was there");
    None
}

#[test]
fn what_rubs_the_clay_is_heard_until_it_is_muted() {
    let Some(path) = where_the_server_is("what_rubs_the_clay_is_heard_until_it_is_muted") else { return };
    let server = PulseTwin::listen(&path, Trouble::None);
    let sound = Sound::start(false, || USUAL);
    is_heard(&server);
    assert!(sound.is_played() && sound.trouble().is_none());
    for _ in 0..2 {
        sound.mute(true);
        is_silent(&server);
        sound.mute(false);
        is_heard(&server);
    }
    drop(sound);
    let muted = Sound::start(true, || USUAL);
    until("the first ends", || server.loudest() == Some(0.0));
    is_silent(&server);
    muted.mute(false);
    is_heard(&server);
}

#[test]
fn a_sound_server_that_goes_is_told_and_the_next_one_is_heard() {
    let Some(path) = where_the_server_is("a_sound_server_that_goes_is_told_and_the_next_one_is_heard") else { return };
    let server = PulseTwin::listen(&path, Trouble::None);
    let sound = Sound::start(false, || USUAL);
    is_heard(&server);
    drop(server);
    std::fs::remove_file(&path).expect("a socket was there");
    until("nobody notices that it is gone", || sound.trouble().is_some());
    let server = PulseTwin::listen(&path, Trouble::None);
    is_heard(&server);
    assert!(sound.is_played() && sound.trouble().is_none());
}

#[test]
fn without_a_server_it_is_silent_and_one_sentence_says_why() {
    let Some(path) = where_the_server_is("without_a_server_it_is_silent_and_one_sentence_says_why") else { return };
    let says_why = |what: &str| {
        let sound = Sound::start(false, || USUAL);
        until(what, || sound.trouble().is_some());
        let trouble = sound.trouble().expect("it was just there");
        assert!(matches!(trouble, SoundError::NoServer { .. }) && !sound.is_played(), "{what}: {trouble}");
        let said = trouble.to_string();
        assert!(said.contains("start PulseAudio or PipeWire") && !said.contains('\n'), "{what}: {said}");
        sound.mute(true);
    };
    says_why("there is no socket");
    drop(UnixListener::bind(&path));
    says_why("nobody listens");
    for trouble in [Trouble::HangsUp, Trouble::Denies] {
        std::fs::remove_file(&path).expect("a socket was there");
        let server = PulseTwin::listen(&path, trouble);
        says_why(&format!("{trouble:?}"));
        assert_eq!(server.samples(), 0);
    }
}
