//! Server and clients as they are shipped, over real sockets of this machine.
//!
//! Real time, real 1 kHz threads, so it claims nothing about timing but bounds that a busy machine keeps.
//! Invariant under test: whoever may join works with everybody else; whoever may not is told why in one sentence.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::net::{SocketAddr, UdpSocket};
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::ScriptedDevice;
use pottery_client::stroke::Stroke;
use pottery_client::view::Link;
use pottery_client::{JoinError, Onlooker, Potter, PotterOptions, Target, client_config, endpoint};
use pottery_server::{Server, ServerConfig, ServerError, Standing};
use pottery_shared::clay::Pot;
use pottery_shared::protocol::{self, FrameReader, Greeting, Hello, JoinCode, Notice, Pass, Purpose, Refusal, Request};
use pottery_shared::session::{Client, ClientError};
use pottery_shared::snapshot::{Detail, PotRecord, QUANTUM_M};
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};
use pottery_tests::line::Quality;
use pottery_tests::proxy::Proxy;
use tokio::time::{sleep, timeout};

const PATIENCE: Duration = Duration::from_secs(10);

const fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

fn config() -> ServerConfig {
    ServerConfig { listen: SocketAddr::from(([127, 0, 0, 1], 0)), ..ServerConfig::default() }
}

fn target(server: &Server, wheel: u16) -> Target {
    Target::new(server.address().to_string(), server.code().clone(), wheel)
}

/// A stroke of the folder, three times as fast and from its first touch on, so that it presses at once.
fn stroke(name: &str) -> Arc<Stroke> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/strokes").join(name).with_extension("csv");
    let text = std::fs::read_to_string(path).unwrap();
    let is_row = |line: &&str| line.starts_with(|first: char| first.is_ascii_digit());
    let mut fast: Vec<_> = text.lines().filter(|line| !is_row(line)).map(str::to_owned).collect();
    for row in text.lines().filter(is_row) {
        let (time, place) = row.split_once(',').unwrap();
        let time = time.parse::<f64>().unwrap() - 0.6;
        if time >= 0.0 {
            fast.push(format!("{:.4},{place}", time / 3.0));
        }
    }
    Arc::new(Stroke::parse(&fast.join("\n")).unwrap())
}

async fn join(target: &Target, name: &str) -> (quinn::Endpoint, Potter) {
    let own = endpoint().unwrap();
    let device = Box::new(ScriptedDevice::new(stroke(name)));
    let potter = Potter::join(&own, target, device, PotterOptions::default()).await.unwrap();
    (own, potter)
}

/// The error of a join that must not work, and how long it took.
async fn refusal(target: &Target) -> (JoinError, Duration) {
    let own = endpoint().unwrap();
    let began = Instant::now();
    let device = Box::new(ScriptedDevice::new(stroke("waist")));
    let error = Potter::join(&own, target, device, PotterOptions::default()).await.unwrap_err();
    println!("{error}");
    (error, began.elapsed())
}

/// A sentence for a person: one line, of some length, and no debugging output.
fn assert_is_a_sentence(text: &str) {
    assert!((20..240).contains(&text.len()), "{text}");
    assert!(!text.contains(['\n', '{', '}']) && !text.contains("Error"), "{text}");
}

/// Waits until a condition on the server holds.
async fn standing_when(server: &Server, what: &str, holds: impl Fn(&Standing) -> bool) -> Standing {
    let began = Instant::now();
    loop {
        let standing = server.standing().await.unwrap();
        if holds(&standing) {
            return standing;
        }
        assert!(began.elapsed() < PATIENCE, "{what}: {:?}, {} people", standing.counts, standing.people);
        sleep(ms(10)).await;
    }
}

/// Waits until everybody is settled on the server's clay.
async fn assert_same_clay(server: &Server, wheel: usize, potters: &[&Potter]) {
    for potter in potters {
        assert!(potter.settle(PATIENCE).await, "not settled: {:?}", potter.view().lock().link);
    }
    standing_when(server, "the same clay everywhere", |standing| {
        potters.iter().all(|potter| {
            let view = potter.view().lock();
            view.digest == standing.digests[wheel] && view.pot.digest() == standing.pots[wheel].digest()
        })
    })
    .await;
}

fn less_mm3(before: &Pot, after: &Pot) -> f64 {
    (after.pressed_m3() - before.pressed_m3()) * 1e9
}

/// What was pressed out of the untouched pot, but for its rounding to the snapshot's steps.
fn pressed_mm3(standing: &Standing, wheel: usize) -> f64 {
    let pot = &standing.pots[wheel];
    less_mm3(&Pot::new(*pot.spec()).unwrap(), pot)
}

async fn leave(people: Vec<(quinn::Endpoint, Potter)>) {
    for (own, potter) in people {
        let began = Instant::now();
        // whoever has only just come may be gone before the own thread has begun
        while potter.status().ticks() == 0 {
            assert!(began.elapsed() < PATIENCE, "the hand does not tick");
            sleep(ms(5)).await;
        }
        let report = potter.leave().await.unwrap();
        assert_eq!((report.network.mismatches, report.network.malformed), (0, 0));
        assert!(report.haptic.unwrap().ticks > 0);
        own.close(0_u32.into(), b"goodbye");
        own.wait_idle().await;
    }
}

/// The largest difference between two pots of one grid, m.
fn worst_m(one: &Pot, other: &Pot) -> f32 {
    let radii = |pot: &Pot| pot.surfaces()[0].radii_m().to_vec();
    radii(one).iter().zip(&radii(other)).map(|(one, other)| (one - other).abs()).fold(0.0, f32::max)
}

#[tokio::test(flavor = "multi_thread")]
async fn who_looks_on_sees_what_is_made_from_near_and_far() {
    let server = Server::start(ServerConfig { wheels: 2, ..config() }).unwrap();
    let own = endpoint().unwrap();
    let looker = Onlooker::join(&own, &target(&server, 1), 100_000).await.unwrap();
    looker.look(|watcher, now| {
        assert_eq!(watcher.wheels(), 2);
        watcher.watch(1, Detail::GALLERY, now);
        watcher.watch(2, Detail::GALLERY, now);
    });
    let potter = join(&target(&server, 1), "waist").await;
    standing_when(&server, "something is pressed", |standing| pressed_mm3(standing, 0) > 200.0).await;
    looker.look(|watcher, now| watcher.watch(1, Detail::SPECTATOR, now));
    assert_same_clay(&server, 0, &[&potter.1]).await;
    let standing = server.standing().await.unwrap();
    let began = Instant::now();
    let allowed_m = 0.5 * Detail::SPECTATOR.quantum().metres() + QUANTUM_M;
    let sees = || {
        looker.look(|watcher, _| {
            let near = watcher.sight(1).filter(|sight| sight.detail() == Detail::SPECTATOR);
            near.is_some_and(|sight| worst_m(sight.pot(), &standing.pots[0]) <= allowed_m)
        })
    };
    while !sees() {
        assert!(began.elapsed() < PATIENCE, "the spectator does not see the potter's clay");
        sleep(ms(20)).await;
    }
    looker.look(|watcher, _| assert_eq!(watcher.sight(2).unwrap().detail(), Detail::GALLERY));
    leave(vec![potter]).await;
    let report = looker.leave().await.unwrap();
    assert_eq!((report.mismatches, report.malformed, report.link), (0, 0, Link::Closed));
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread")]
async fn whoever_gets_another_address_in_mid_stroke_keeps_seat_and_session() {
    let server = Server::start(config()).unwrap();
    let potter = join(&target(&server, 1), "waist").await;
    let (before, number) = (potter.0.local_addr().unwrap(), potter.1.view().lock().number);
    let pressed = |standing: &Standing| pressed_mm3(standing, 0);
    let pressed_before = pressed(&standing_when(&server, "something is pressed", |now| pressed(now) > 200.0).await);
    // from one network to another: the old socket is gone
    potter.0.rebind(UdpSocket::bind((before.ip(), 0)).unwrap()).unwrap();
    assert_ne!(potter.0.local_addr().unwrap().port(), before.port());
    standing_when(&server, "more is pressed", |now| pressed(now) > pressed_before + 200.0).await;
    assert_same_clay(&server, 0, &[&potter.1]).await;
    let standing = server.standing().await.unwrap();
    assert_eq!((standing.people, potter.1.view().lock().number), (1, number));
    leave(vec![potter]).await;
    server.stop().await;
}

/// A client without any of the client library's good manners.
struct RawClient {
    _endpoint: quinn::Endpoint,
    connection: quinn::Connection,
    send: quinn::SendStream,
    receive: quinn::RecvStream,
    reader: FrameReader,
}

impl RawClient {
    async fn connect(server: &Server, config: quinn::ClientConfig) -> Self {
        let own = quinn::Endpoint::client("127.0.0.1:0".parse().unwrap()).unwrap();
        let connection = own.connect_with(config, server.address(), "pottery-studio").unwrap().await.unwrap();
        let (send, receive) = connection.open_bi().await.unwrap();
        Self { _endpoint: own, connection, send, receive, reader: FrameReader::default() }
    }

    async fn joined(server: &Server, wheel: u16) -> (Self, Client) {
        let mut raw = Self::connect(server, client_config(server.code()).unwrap()).await;
        raw.send.write_all(&Client::greeting(server.code().room(), wheel, true)).await.unwrap();
        let welcome = raw.frame().await.unwrap();
        let client = Client::open(&welcome, 0, raw.connection.rtt()).unwrap();
        (raw, client)
    }

    /// The next frame; `None` when the server has ended the stream.
    async fn frame(&mut self) -> Option<Vec<u8>> {
        let mut piece = [0; 4096];
        loop {
            if let Some(frame) = self.reader.next_frame().unwrap() {
                return Some(frame);
            }
            let read = timeout(PATIENCE, self.receive.read(&mut piece)).await.expect("the server says something");
            self.reader.push(&piece[..read.ok()??]);
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn two_potters_end_with_the_servers_clay_and_a_late_one_gets_it() {
    let server = Server::start(config()).unwrap();
    // one with fingertips, one with a rib that sways
    let mut people = vec![join(&target(&server, 1), "waist").await, join(&target(&server, 1), "rib").await];
    sleep(ms(1500)).await;
    standing_when(&server, "two press", |standing| pressed_mm3(standing, 0) > 1_000.0).await;
    people.push(join(&target(&server, 1), "foot").await);
    let potters: Vec<_> = people.iter().map(|(_, potter)| potter).collect();
    assert_same_clay(&server, 0, &potters).await;
    let standing = server.standing().await.unwrap();
    assert!(pressed_mm3(&standing, 0) > 1_000.0, "{} mm³", pressed_mm3(&standing, 0));
    assert_eq!((standing.people, standing.counts.joined), (3, 3));
    leave(people).await;
    standing_when(&server, "everybody has left", |standing| standing.people == 0).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn who_may_not_come_in_is_told_why() {
    let server = Server::start(config()).unwrap();
    let right = target(&server, 1);

    let mut fingerprint = [0; 32];
    fingerprint[..JoinCode::PRINT_BYTES].copy_from_slice(server.code().print().unwrap());
    let code = JoinCode::new([7; 5], &fingerprint);
    let (error, _) = refusal(&Target { code, ..right.clone() }).await;
    assert!(matches!(error, JoinError::Session(ClientError::Refused(Refusal::Code))), "{error:?}");
    assert_is_a_sentence(&error.to_string());

    let (error, _) = refusal(&Target { wheel: 3, ..right.clone() }).await;
    let unknown = Refusal::Wheel { wheel: 3, wheels: 1 };
    assert!(matches!(&error, JoinError::Session(ClientError::Refused(refusal)) if *refusal == unknown), "{error:?}");
    assert_is_a_sentence(&error.to_string());

    let (error, _) = refusal(&Target { wheel: 0, ..right.clone() }).await;
    assert!(matches!(error, JoinError::Session(ClientError::Refused(Refusal::Wheel { .. }))), "{error:?}");

    let code = server.code().clone().on_server(&[9; 32]);
    let (error, _) = refusal(&Target { code, ..right.clone() }).await;
    assert!(matches!(error, JoinError::WrongServer { .. }), "{error:?}");
    assert_is_a_sentence(&error.to_string());

    assert_eq!(server.standing().await.unwrap().people, 0);
    let code = server.code().room().parse().unwrap();
    let (own, potter) = join(&Target { code, ..right }, "neck").await;
    assert_eq!(potter.view().lock().link, Link::Open, "a code without a fingerprint is enough");
    leave(vec![(own, potter)]).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_full_studio_says_so() {
    let server = Server::start(ServerConfig { people_max: 1, ..config() }).unwrap();
    let first = join(&target(&server, 1), "waist").await;
    let (error, _) = refusal(&target(&server, 1)).await;
    assert!(matches!(error, JoinError::Session(ClientError::Refused(Refusal::Full { people: 1 }))), "{error:?}");
    assert_is_a_sentence(&error.to_string());
    leave(vec![first]).await;
    standing_when(&server, "the seat is free", |standing| standing.people == 0).await;
    leave(vec![join(&target(&server, 1), "waist").await]).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn another_version_and_no_version_are_refused_politely() {
    let server = Server::start(config()).unwrap();
    let hello = protocol::encode(&Hello {
        code: server.code().room().to_owned(),
        wheel: 1,
        purpose: Purpose::Works { retells: true },
        pass: Pass::None,
    });
    let version = (protocol::VERSION + 1).to_le_bytes();
    let newer = protocol::encode(&Greeting { magic: Greeting::MAGIC, version, hello });
    let expected = Refusal::Version { server: protocol::VERSION, client: protocol::VERSION + 1 };
    for (greeting, expected) in [(newer, expected), (b"GET / HTTP/1.1".to_vec(), Refusal::Greeting)] {
        let mut raw = RawClient::connect(&server, client_config(server.code()).unwrap()).await;
        raw.send.write_all(&protocol::frame(&greeting)).await.unwrap();
        let answer = raw.frame().await.unwrap();
        let notice: Notice = protocol::decode::<{ protocol::CONTROL_MAX }, _>(&answer).unwrap();
        assert_eq!(notice, Notice::Refused(expected.clone()));
        assert_is_a_sentence(&expected.to_string());
        assert_eq!(raw.frame().await, None, "nothing follows a refusal");
        timeout(ms(2000), raw.connection.closed()).await.expect("the server closes the connection");
    }
    assert_eq!(server.standing().await.unwrap().counts.refused, 2);
    server.stop().await;
}

/// A client's TLS for another protocol than the studio's.
fn other_protocol() -> quinn::ClientConfig {
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let mut tls = rustls::ClientConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&rustls::version::TLS13])
        .unwrap()
        .with_root_certificates(rustls::RootCertStore::empty())
        .with_no_client_auth();
    tls.alpn_protocols = vec![b"h3".to_vec()];
    quinn::ClientConfig::new(Arc::new(quinn::crypto::rustls::QuicClientConfig::try_from(tls).unwrap()))
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn another_protocol_on_either_end_is_recognised() {
    let server = Server::start(config()).unwrap();
    let own = quinn::Endpoint::client("127.0.0.1:0".parse().unwrap()).unwrap();
    let error = own.connect_with(other_protocol(), server.address(), "pottery-studio").unwrap().await.unwrap_err();
    // 120 is TLS's no_application_protocol
    assert!(error.to_string().contains("120"), "{error}");
    server.stop().await;

    let made = rcgen::generate_simple_self_signed([String::from("web")]).unwrap();
    let key = rustls::pki_types::PrivatePkcs8KeyDer::from(made.signing_key.serialize_der());
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let mut tls = rustls::ServerConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&rustls::version::TLS13])
        .unwrap()
        .with_no_client_auth()
        .with_single_cert(vec![made.cert.into()], key.into())
        .unwrap();
    tls.alpn_protocols = vec![b"h3".to_vec()];
    let tls = quinn::crypto::rustls::QuicServerConfig::try_from(tls).unwrap();
    let web = quinn::Endpoint::server(quinn::ServerConfig::with_crypto(Arc::new(tls)), "127.0.0.1:0".parse().unwrap());
    let web = web.unwrap();
    let address = web.local_addr().unwrap().to_string();
    let accepting = tokio::spawn(async move {
        while let Some(incoming) = web.accept().await {
            drop(incoming.await);
        }
    });
    let (error, _) = refusal(&Target::new(address, "K7QM3XPD".parse().unwrap(), 1)).await;
    assert!(matches!(error, JoinError::NotAStudio { .. }), "{error:?}");
    assert_is_a_sentence(&error.to_string());
    accepting.abort();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn where_nobody_listens_the_answer_comes_in_time() {
    let closed = UdpSocket::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let code: JoinCode = "K7QM3XPD".parse().unwrap();
    let (error, waited) = refusal(&Target::new(closed.to_string(), code.clone(), 1)).await;
    assert!(matches!(error, JoinError::Unreachable { .. }), "{error:?}");
    assert!(waited < ms(6500), "{waited:?}");
    assert_is_a_sentence(&error.to_string());
    for address in ["127.0.0.1:99999", "[::1:4747", "studio 4", ""] {
        let (error, waited) = refusal(&Target::new(address.into(), code.clone(), 1)).await;
        assert!(matches!(error, JoinError::Address { .. }), "{address}: {error:?}");
        assert!(waited < ms(6500), "{address}: {waited:?}");
        assert_is_a_sentence(&error.to_string());
    }
    let (error, _) = refusal(&Target::new("127.0.0.1:99999".into(), code, 1)).await;
    assert!(error.to_string().contains("a port is a number up to 65535"), "{error}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_stopping_server_tells_everybody_and_frees_its_port() {
    let server = Server::start(config()).unwrap();
    let address = server.address();
    let taken = Server::start(ServerConfig { listen: address, ..config() }).unwrap_err();
    println!("{taken}");
    assert!(matches!(taken, ServerError::Bind { .. }), "{taken:?}");
    assert_is_a_sentence(&taken.to_string());

    let people = [join(&target(&server, 1), "waist").await, join(&target(&server, 1), "foot").await];
    let began = Instant::now();
    let stopping = tokio::spawn(server.stop());
    for (_, potter) in &people {
        while potter.view().lock().link != Link::Closed {
            assert!(began.elapsed() < ms(1000), "{:?}", potter.view().lock().link);
            sleep(ms(5)).await;
        }
    }
    timeout(ms(4000), stopping).await.expect("a server stops within its bounds").unwrap();
    let again = Server::start(ServerConfig { listen: address, ..config() }).unwrap();
    assert_eq!(again.address(), address);
    again.stop().await;
    for (_, potter) in people {
        potter.leave().await.unwrap();
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_vanishes_leaves_what_it_had_sent_and_the_others_go_on() {
    let server = Server::start(config()).unwrap();
    let watcher = join(&target(&server, 1), "neck").await;
    watcher.1.status().lift(true);
    let (raw, mut client) = RawClient::joined(&server, 1).await;
    // 300 samples for ticks that are still to come, late enough that a busy machine has gone by then
    let untouched = server.standing().await.unwrap();
    let first = untouched.ticks + 900;
    for number in 0..300 {
        let depth = 0.004 * (number as f32 / 300.0);
        let centre = Position::nearest(Vec3::new(0.072 - depth, 0.0, 0.1)).unwrap();
        assert!(client.handle_sample(ToolSample {
            tick: Tick(first + number),
            tool: Tool::default(),
            orientation: Orientation::default(),
            centre,
            side: Side::Outside
        }));
    }
    let mut sent = 0;
    while let Some(bytes) = client.poll_datagram(Duration::ZERO) {
        raw.connection.send_datagram(bytes.into()).unwrap();
        sent += 1;
    }
    // a connection that is closed forgets what has not left yet
    let began = Instant::now();
    while raw.connection.stats().frame_tx.datagram < sent {
        assert!(began.elapsed() < PATIENCE, "of {sent} datagrams not all have left");
        sleep(ms(10)).await;
    }
    sleep(ms(100)).await;
    raw.connection.close(7_u32.into(), b"");
    let gone = standing_when(&server, "the vanished one is gone", |standing| standing.people == 1).await;
    assert!(gone.ticks < first, "the test was too slow to show anything: tick {}", gone.ticks);
    assert_eq!(gone.digests, untouched.digests);
    let pressed = standing_when(&server, "its samples are pressed", |standing| standing.ticks > first + 320).await;
    assert_eq!(pressed.counts.refusals.total(), 0, "{:?}", pressed.counts);
    // the same samples on an own pot, where nobody else pressed
    let own_mm3 = less_mm3(client.replica().pot(), client.predicted());
    let pressed_mm3 = less_mm3(&untouched.pots[0], &pressed.pots[0]);
    println!("pressed {pressed_mm3} mm³, on its own {own_mm3} mm³");
    // the server rounds each snapshot up to its steps, by less than a hundredth of such a groove
    assert!((pressed_mm3 - own_mm3).abs() < 0.01 * own_mm3, "{pressed_mm3} mm³ of {own_mm3} mm³");
    assert_same_clay(&server, 0, &[&watcher.1]).await;
    leave(vec![watcher]).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn garbage_is_counted_and_disturbs_nobody() {
    let server = Server::start(config()).unwrap();
    let people = vec![join(&target(&server, 1), "waist").await, join(&target(&server, 1), "foot").await];
    let mut dice = pottery_tests::dice::Dice::new(5);
    let mut garbage = |length: usize| -> Vec<u8> { (0..length).map(|_| dice.roll() as u8).collect() };

    // no QUIC at all, of every size that UDP knows
    let stray = UdpSocket::bind("127.0.0.1:0").unwrap();
    for length in [0, 1, 20, 1200, 1472, 9000, 65_507] {
        stray.send_to(&garbage(length), server.address()).unwrap();
    }
    // QUIC, but no samples; and larger than any datagram of the protocol
    let (raw, _) = RawClient::joined(&server, 1).await;
    let largest = raw.connection.max_datagram_size().unwrap();
    for length in [1, 17, 500, 1150, largest] {
        // begins as no message does: a number of 16 bytes
        let mut bytes = garbage(length);
        bytes[0] = 255;
        raw.connection.send_datagram(bytes.into()).unwrap();
    }
    let counted =
        standing_when(&server, "garbage is counted", |standing| standing.counts.refusals.malformed == 5).await;
    assert_eq!((counted.people, counted.counts.refused), (3, 0));

    // a frame that is no request, and one that is longer than any
    let (mut talker, _) = RawClient::joined(&server, 1).await;
    talker.send.write_all(&protocol::frame(&[255; 40])).await.unwrap();
    timeout(PATIENCE, talker.connection.closed()).await.expect("who talks nonsense is let go");
    let (mut shouter, _) = RawClient::joined(&server, 1).await;
    shouter.send.write_all(&[255; 5000]).await.unwrap();
    timeout(PATIENCE, shouter.connection.closed()).await.expect("who shouts is let go");
    let counted = standing_when(&server, "both are gone", |standing| standing.people == 3).await;
    assert_eq!(counted.counts.refused, 1);

    sleep(ms(800)).await;
    standing_when(&server, "the others press", |standing| pressed_mm3(standing, 0) > 100.0).await;
    let potters: Vec<_> = people.iter().map(|(_, potter)| potter).collect();
    assert_same_clay(&server, 0, &potters).await;
    assert!(pressed_mm3(&server.standing().await.unwrap(), 0) > 100.0);
    leave(people).await;
    server.stop().await;
}

/// People who ask for what no one of them may ask for alone.
const ASKERS: usize = 11;

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_client_that_reads_nothing_is_let_go_and_the_others_hear_everything() {
    let server = Server::start(config()).unwrap();
    let first = join(&target(&server, 1), "waist").await;
    let mut narrow = client_config(server.code()).unwrap();
    let mut transport = quinn::TransportConfig::default();
    transport.stream_receive_window(512_u32.into());
    narrow.transport_config(Arc::new(transport));
    let mut deaf = RawClient::connect(&server, narrow).await;
    deaf.send.write_all(&Client::greeting(server.code().room(), 1, true)).await.unwrap();
    standing_when(&server, "the deaf one is in", |standing| standing.people == 2).await;
    // a notice every 10 ms goes to all; 512 bytes and 256 frames later the deaf one's queue is full. Nobody may ask for
    // all that alone.
    let mut askers = Vec::new();
    for _ in 0..ASKERS {
        askers.push(RawClient::joined(&server, 1).await.0);
    }
    for number in 0..420_u16 {
        let rpm = 60.0 + f32::from(number % 20);
        let asker = &mut askers[usize::from(number) % ASKERS];
        asker.send.write_all(&protocol::frame(&protocol::encode(&Request::WheelSpeed { rpm }))).await.unwrap();
        sleep(ms(11)).await;
    }
    for asker in &mut askers {
        for _ in 0..300 {
            assert!(asker.frame().await.is_some());
        }
    }
    standing_when(&server, "the deaf one is let go", |standing| standing.people == 1 + ASKERS).await;
    timeout(PATIENCE, deaf.connection.closed()).await.expect("its connection is closed");
    assert_same_clay(&server, 0, &[&first.1]).await;
    leave(vec![first]).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn wheels_of_one_studio_are_independent() {
    let server = Server::start(ServerConfig { wheels: 3, wheel_speed: Rpm(20.0), ..config() }).unwrap();
    let untouched = server.standing().await.unwrap().digests;
    let people = vec![join(&target(&server, 1), "waist").await, join(&target(&server, 2), "foot").await];
    sleep(ms(1500)).await;
    standing_when(&server, "both wheels are pressed at", |standing| {
        standing.digests[0] != untouched[0] && standing.digests[1] != untouched[1]
    })
    .await;
    assert_same_clay(&server, 0, &[&people[0].1]).await;
    assert_same_clay(&server, 1, &[&people[1].1]).await;
    let standing = server.standing().await.unwrap();
    assert_ne!(standing.digests[0], untouched[0]);
    assert_ne!(standing.digests[1], untouched[1]);
    assert_ne!(standing.digests[0], standing.digests[1]);
    assert_eq!(standing.digests[2], untouched[2]);
    leave(people).await;
    server.stop().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn clay_is_the_same_behind_a_lossy_reordering_proxy() {
    for (seed, quality) in [(1, Quality::HOME), (2, Quality::AWFUL)] {
        let server = Server::start(config()).unwrap();
        let proxy = Proxy::start(server.address(), quality, seed).await.unwrap();
        let through = Target { address: proxy.address().to_string(), ..target(&server, 1) };
        // one behind the proxy, one beside it
        let people = vec![join(&through, "waist").await, join(&target(&server, 1), "evaluation").await];
        sleep(ms(3000)).await;
        // how much is sent in a while depends on the machine; pulses, and word that they came, go on when the strokes are over
        let began = Instant::now();
        loop {
            let (up, down) = proxy.counts();
            if up.packets > 100 && down.packets > 100 && up.lost + down.lost > 0 {
                break;
            }
            assert!(began.elapsed() < PATIENCE, "seed {seed}: too little passes: {up:?}, {down:?}");
            sleep(ms(10)).await;
        }
        standing_when(&server, "something is pressed", |standing| pressed_mm3(standing, 0) > 1_000.0).await;
        let potters: Vec<_> = people.iter().map(|(_, potter)| potter).collect();
        assert_same_clay(&server, 0, &potters).await;
        let standing = server.standing().await.unwrap();
        let (up, down) = proxy.counts();
        println!("seed {seed}: {} mm³, up {up:?}, down {down:?}", pressed_mm3(&standing, 0));
        assert!(pressed_mm3(&standing, 0) > 1_000.0, "seed {seed}");
        assert!(up.packets > 100 && down.packets > 100 && up.lost + down.lost > 0, "seed {seed}: {up:?}, {down:?}");
        leave(people).await;
        server.stop().await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn wheel_that_goes_on_with_a_pot_shows_it_to_everybody() {
    let mut saved = Pot::new(config().pot).unwrap();
    for column in 0..360 {
        for row in 100..140 {
            saved.surfaces_mut()[0].set_radius(column, row, 0.05 + 1e-5 * column as f32);
        }
    }
    let record = Arc::new(PotRecord::of(&saved));
    let server = Server::start(ServerConfig { opened: Some(Arc::clone(&record)), ..config() }).unwrap();
    let target = target(&server, 1);
    let (pot, digest) = (record.pot(), server.standing().await.unwrap().digests[0]);
    // one after the other, so that the second comes late
    let mut potters = Vec::new();
    for _ in 0..2 {
        let own = endpoint().unwrap();
        let device = Box::new(pottery_client::device::pointer().1);
        let potter = Potter::join(&own, &target, device, PotterOptions::default()).await.unwrap();
        let shown = timeout(PATIENCE, async {
            while potter.view().lock().digest != digest {
                sleep(ms(10)).await;
            }
        });
        shown.await.expect("the pot arrives");
        assert!(potter.view().lock().pot == pot, "what is seen is the pot that was saved");
        potters.push((own, potter));
    }
    for (_own, potter) in potters {
        potter.leave().await.unwrap();
    }
    assert!(server.standing().await.unwrap().pots[0] == pot);
    server.stop().await;
}
