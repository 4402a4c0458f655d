//! Who looks on and is cut off: back by itself, at the same studio, with what was made meanwhile.
//!
//! The client's own onlooker and the server over a network in memory and virtual time.
//! Invariant under test: what is seen stays to be seen, and is never of another server than the one that was joined.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::fs;
use std::net::SocketAddr;
use std::time::Duration;

use pottery_client::view::Link;
use pottery_client::{Command, Onlooker, PotterOptions, Seat, Target};
use pottery_server::{Certificate, Server, ServerConfig, server_config};
use pottery_shared::clay::Form;
use pottery_shared::snapshot::Detail;
use pottery_tests::line::Quality;
use pottery_tests::network::Network;
use pottery_tests::programs::folder;
use pottery_tests::simulation::{in_virtual_time, ms};
use tokio::time::{Instant, sleep};

use crate::crossing::Sitting;

const SERVER: &str = "10.0.0.1:4747";
const LOOKER: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 1, 1)), 40_000);
const POTTER: SocketAddr = SocketAddr::new(std::net::IpAddr::V4(std::net::Ipv4Addr::new(10, 0, 1, 2)), 40_000);
const PLENTY: u32 = 1_000_000;

/// A server at the one address, whose code says nothing of its key.
fn open(network: &Network, certificate: Certificate, config: ServerConfig) -> Server {
    let fingerprint = certificate.sha256();
    let endpoint = network.endpoint(SERVER.parse().unwrap(), Some(server_config(certificate).unwrap())).unwrap();
    let code = Some("K7QM-3XPD".parse().unwrap());
    Server::start_on(endpoint, &fingerprint, ServerConfig { code, ..config }).unwrap()
}

async fn look(network: &Network) -> Onlooker {
    network.connect(LOOKER, Quality::HOME, Quality::HOME);
    let own = network.endpoint(LOOKER, None).unwrap();
    let target = Target::new(SERVER.into(), "K7QM-3XPD".parse().unwrap(), 1);
    let looker = Onlooker::join(&own, &target, PLENTY).await.unwrap();
    looker.look(|watcher, now| {
        watcher.watch(1, Detail::RETOLD, now);
        watcher.watch(2, Detail::GALLERY, now);
    });
    looker
}

/// Digest of wheel 1 as it is seen.
fn seen(looker: &Onlooker) -> Option<u64> {
    looker.look(|watcher, _| watcher.sight(1).map(pottery_shared::session::Watched::digest))
}

fn number(looker: &Onlooker) -> Option<u16> {
    looker.look(|watcher, _| watcher.class().place().map(|place| place.client))
}

async fn until(what: &str, patience: Duration, mut is_so: impl FnMut() -> bool) -> Duration {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < patience, "{what}");
        sleep(ms(5)).await;
    }
    began.elapsed()
}

#[test]
fn who_looks_on_and_was_cut_off_sees_within_a_second_what_was_made_meanwhile() {
    in_virtual_time(async {
        for (seed, cut_ms) in [(1, 2_000), (2, 10_500), (3, 25_300)] {
            let network = Network::new(seed);
            let server =
                open(&network, Certificate::fresh().unwrap(), ServerConfig { wheels: 2, ..ServerConfig::default() });
            let looker = look(&network).await;
            until("both wheels are seen", ms(2_000), || {
                looker.look(|watcher, _| watcher.sight(1).is_some() && watcher.sight(2).is_some())
            })
            .await;
            until("it is told its place", ms(1_000), || number(&looker).is_some()).await;
            let (before, who) = (seen(&looker), number(&looker));
            let own = network.endpoint(POTTER, None).unwrap();
            let target = Target::new(SERVER.into(), server.code().clone(), 1);
            let Seat { worker, commands, hand: _hand, .. } =
                Seat::take(&own, &target, PotterOptions::default()).await.unwrap();
            let potter = tokio::spawn(worker.run());
            network.cut(LOOKER, true);
            commands.send(Command::NewPot(Some(Form::Bowl))).await.unwrap();
            sleep(ms(cut_ms)).await;
            let is_lost = cut_ms > 10_000;
            assert_eq!(matches!(looker.link(), Link::ComingBack(_)), is_lost, "{:?}", looker.link());
            assert_eq!(seen(&looker), before, "what was seen is seen no more");
            network.cut(LOOKER, false);
            let mended_at = Instant::now();
            let made = loop {
                let standing = server.standing().await.unwrap();
                let made = standing.digests[0];
                if looker.link() == Link::Open && seen(&looker) == Some(made) && standing.people == 2 {
                    break made;
                }
                // a line that was silent is asked after twice as long as before
                let patience = if is_lost { ms(1_000) } else { ms(2_500) };
                assert!(mended_at.elapsed() < patience, "seed {seed}: {:?}", looker.link());
                sleep(ms(5)).await;
            };
            println!("seed {seed}, {cut_ms} ms cut: seen {:?} after it was mended", mended_at.elapsed());
            assert_ne!(Some(made), before);
            until("it is told its place", ms(1_000), || number(&looker).is_some()).await;
            assert_eq!(number(&looker), who, "it came back as somebody else");
            commands.send(Command::Leave).await.unwrap();
            potter.await.unwrap();
            let report = looker.leave().await.unwrap();
            assert_eq!((report.mismatches, report.malformed, report.link), (0, 0, Link::Closed));
            server.stop().await;
        }
    });
}

#[test]
fn another_server_at_the_same_address_is_not_looked_at_and_the_same_one_begun_anew_is() {
    in_virtual_time(async {
        for (is_same, wheels) in [(true, 2_u16), (false, 2), (true, 3)] {
            let network = Network::new(4);
            let config = ServerConfig { wheels: 2, ..ServerConfig::default() };
            let kept = folder("looking-again");
            let server = open(&network, Certificate::kept_in(&kept).unwrap(), config.clone());
            let looker = look(&network).await;
            until("the wheel is seen", ms(2_000), || seen(&looker).is_some()).await;
            network.cut(LOOKER, true);
            server.stop().await;
            let key = if is_same { Certificate::kept_in(&kept) } else { Certificate::fresh() };
            let server = open(&network, key.unwrap(), ServerConfig { wheels, ..config });
            sleep(ms(11_000)).await;
            assert!(matches!(looker.link(), Link::ComingBack(_)), "{:?}", looker.link());
            network.cut(LOOKER, false);
            until("it is said", ms(2_000), || !matches!(looker.link(), Link::ComingBack(_))).await;
            println!("same key {is_same}, {wheels} wheels: {:?}", looker.link());
            match looker.link() {
                Link::Open => {
                    assert!(is_same && wheels == 2);
                    until("the wheel is seen again", ms(2_000), || {
                        looker.look(|watcher, _| watcher.tick().is_some() && !watcher.is_behind())
                    })
                    .await;
                }
                Link::Lost(said) if is_same => assert!(wheels == 3 && said.contains("join it anew"), "{said}"),
                Link::Lost(said) => assert!(said.contains("--trust-new-key"), "{said}"),
                other => panic!("{other:?}"),
            }
            assert!(seen(&looker).is_some(), "what was seen is seen no more");
            let report = looker.leave().await.unwrap();
            assert_eq!((report.mismatches, report.malformed), (0, 0));
            server.stop().await;
            fs::remove_dir_all(kept).unwrap();
        }
    });
}

#[test]
fn a_recording_goes_on_when_the_server_was_begun_anew() {
    in_virtual_time(async {
        let network = Network::new(5);
        let kept = folder("recording-again");
        let server = open(&network, Certificate::kept_in(&kept).unwrap(), ServerConfig::default());
        network.connect(POTTER, Quality::LAN, Quality::LAN);
        let own = network.endpoint(POTTER, None).unwrap();
        let target = Target::new(SERVER.into(), server.code().clone(), 1);
        let seat = Sitting::with(&own, &target, PotterOptions { record: true, ..PotterOptions::default() }).await;
        let first = until("it presses", ms(9_000), || seat.pressed_mm3() > 50.0).await;
        network.cut(POTTER, true);
        server.stop().await;
        let server = open(&network, Certificate::kept_in(&kept).unwrap(), ServerConfig::default());
        let away = until("the line is lost", ms(30_000), || matches!(seat.view.lock().link, Link::ComingBack(_))).await;
        network.cut(POTTER, false);
        until("it is back", ms(10_000), || seat.view.lock().link == Link::Open).await;
        until("its clay is there", ms(5_000), || seat.view.lock().is_whole).await;
        let again = ms(2_000);
        sleep(again).await;
        let recording = seat.leave().await.recording.unwrap();
        let recorded_s = recording.stroke().end();
        println!("{first:?} before, away for {away:?}, {again:?} afterwards: {recorded_s:.2} s are recorded");
        // the hand goes on while nobody answers
        let least_s = (first + away + again).as_secs_f64() - 0.5;
        assert!(recorded_s > least_s && recorded_s < least_s + 4.0, "{recorded_s} s of {least_s}");
        server.stop().await;
        fs::remove_dir_all(kept).unwrap();
    });
}
