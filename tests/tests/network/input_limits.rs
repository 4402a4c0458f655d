//! How much is heard of an address: all of a school, and of who floods no more than the server says.
//!
//! A school in virtual time over lines that lose; floods over real sockets of this machine, which has more than one address.
//! Invariant under test: whoever keeps to the own share is heard, whoever else sends how much.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::io::{Read, Write};
use std::net::{Ipv4Addr, SocketAddr};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::device::{Device, ScriptedDevice};
use pottery_client::stroke::Stroke;
use pottery_client::{HapticLoop, Potter, PotterOptions, Seat, Target, client_config};
use pottery_server::{Input, InputCounts, Server, ServerConfig};
use pottery_shared::haptics::{DeviceSpecs, Setup, Stages};
use pottery_shared::protocol::{self, FrameReader, NoOrder, Notice, Order, Request};
use pottery_shared::session::Client;
use pottery_shared::tool::Tool;
use pottery_tests::line::Quality;
use pottery_tests::simulation::{SERVER, Simulation, in_virtual_time, ms};

const PATIENCE: Duration = Duration::from_secs(30);

/// A hand that presses round and round, fast enough that its samples are long.
struct Presser(f32);

impl Device for Presser {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        let time = seconds as f32;
        let (distance_m, height_m) = (0.0705 - 0.0015 * (time * 9.0).sin(), 0.1 + 0.06 * (time * 5.0 + self.0).sin());
        Some(Vec3::new(distance_m * self.0.cos(), distance_m * self.0.sin(), height_m))
    }

    fn tool(&self) -> Tool {
        Tool::default()
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }

    fn setup(&self, share_of_small: f32) -> Setup {
        Setup { stages: Stages::EXACT, ..Setup::for_device(self.specs(), share_of_small) }
    }
}

/// Thirty people of the client's own behind one address, over the worst lines that are simulated; how many datagrams and bytes the
/// busiest sent a second.
fn a_class_over(quality: Quality, seconds: u64) -> (f64, f64, InputCounts) {
    const PEOPLE: u16 = 30;
    in_virtual_time(async {
        let studio = Simulation::open(11, ServerConfig { wheels: 10, ..ServerConfig::default() }).unwrap();
        let mut people = Vec::new();
        for number in 0..PEOPLE {
            let address = SocketAddr::from(([10, 0, 2, 1], 40_000 + number));
            studio.network.connect(address, quality, quality);
            let endpoint = studio.network.endpoint(address, None).unwrap();
            let seat = Seat::take(&endpoint, &studio.target(number / 3 + 1), PotterOptions::default()).await.unwrap();
            let Seat { epoch, worker, hand, commands, .. } = seat;
            let hand = HapticLoop::new(Box::new(Presser(f32::from(number))), hand);
            people.push((endpoint, commands, address, epoch, tokio::spawn(worker.run()), hand));
        }
        let sent = |address| studio.network.counts_of(address).unwrap().0;
        let before: Vec<_> = people.iter().map(|(_, _, address, ..)| sent(*address)).collect();
        let begun = tokio::time::Instant::now();
        while begun.elapsed() < ms(seconds * 1000) {
            tokio::time::sleep(ms(1)).await;
            for (.., epoch, _, hand) in &mut people {
                hand.tick(epoch.elapsed().as_millis() as u64);
            }
        }
        let rates = people.iter().zip(before).map(|((_, _, address, ..), before)| {
            let now = sent(*address);
            ((now.packets - before.packets) as f64 / seconds as f64, (now.bytes - before.bytes) as f64 / seconds as f64)
        });
        let (packets, bytes) = rates.fold((0.0_f64, 0.0_f64), |most, rate| (most.0.max(rate.0), most.1.max(rate.1)));
        let counts = studio.server.figures().await.unwrap().input;
        assert!(people.iter().all(|(.., worker, _)| !worker.is_finished()), "somebody was let go");
        studio.server.stop().await;
        (packets, bytes, counts)
    })
}

#[test]
fn a_class_behind_one_address_is_heard_over_the_worst_line() {
    let (packets, bytes, counts) = a_class_over(Quality::AWFUL, 4);
    println!("the busiest of thirty sent {packets:.0} packets and {:.1} kB a second", bytes * 1e-3);
    assert_eq!(counts, InputCounts::default());
    assert!(packets > 90.0, "they pressed: {packets} packets a second");
    // so the figure by which shares are made is one that is seen
    assert!(bytes < 0.6 * f64::from(Input::default().datagram_bytes_per_s), "{bytes}");
}

#[test]
fn who_connects_and_does_not_greet_is_not_heard_and_let_go() {
    in_virtual_time(async {
        let studio = Simulation::open(12, ServerConfig::default()).unwrap();
        let endpoint = studio.endpoint(1, Quality::LAN, Quality::LAN).unwrap();
        let config = client_config(studio.server.code()).unwrap();
        let connection = endpoint.connect_with(config, SERVER.into(), "pottery-studio").unwrap().await.unwrap();
        let (mut send, _receive) = connection.open_bi().await.unwrap();
        // the beginning of a frame, and after that only signs of life
        send.write_all(&[7]).await.unwrap();
        let begun = tokio::time::Instant::now();
        for _ in 0..400 {
            connection.send_datagram(bytes::Bytes::from_static(&[0xa5; 20])).unwrap();
            tokio::time::sleep(ms(10)).await;
        }
        assert!(connection.close_reason().is_none(), "too early: {:?}", connection.close_reason());
        tokio::time::timeout(ms(6_000), connection.closed()).await.unwrap();
        assert!(begun.elapsed() > ms(4_900), "{:?}", begun.elapsed());
        let standing = studio.server.standing().await.unwrap();
        assert_eq!((standing.people, standing.counts.refusals.malformed), (0, 0));
        studio.server.stop().await;
    });
}

/// What the server said in its log.
static LOG: Mutex<Vec<u8>> = Mutex::new(Vec::new());

struct Log;

impl Write for Log {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        LOG.lock().unwrap_or_else(PoisonError::into_inner).write(bytes)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        Ok(())
    }
}

fn logged() -> String {
    String::from_utf8(LOG.lock().unwrap_or_else(PoisonError::into_inner).clone()).unwrap()
}

/// What is sent without an end: datagrams that are none, or orders that only a teacher may give, each of which is answered when it is heard.
#[derive(Clone, Copy, PartialEq, Eq)]
enum Sends {
    Datagrams,
    Requests,
}

/// Somebody who came in to do that.
struct Flooder {
    connection: quinn::Connection,
    _endpoint: quinn::Endpoint,
    answered: Arc<AtomicU64>,
}

impl Flooder {
    async fn join(server: &Server, from: Ipv4Addr) -> (Self, quinn::SendStream) {
        let endpoint = quinn::Endpoint::client((from, 0).into()).unwrap();
        let config = client_config(server.code()).unwrap();
        let connection = endpoint.connect_with(config, server.address(), "pottery-studio").unwrap().await.unwrap();
        let (mut send, mut receive) = connection.open_bi().await.unwrap();
        send.write_all(&Client::greeting(server.code().room(), 2, true)).await.unwrap();
        let answered = Arc::new(AtomicU64::new(0));
        let (count, mut reader, mut piece) = (Arc::clone(&answered), FrameReader::default(), [0; 4096]);
        let (welcome, welcomed) = tokio::sync::oneshot::channel();
        tokio::spawn(async move {
            let mut welcome = Some(welcome);
            while let Ok(Some(read)) = receive.read(&mut piece).await {
                reader.push(&piece[..read]);
                while let Some(frame) = reader.next_frame().unwrap() {
                    if let Some(welcome) = welcome.take() {
                        welcome.send(()).unwrap();
                    }
                    let notice = protocol::decode::<{ protocol::CONTROL_MAX }, Notice>(&frame);
                    count.fetch_add(u64::from(notice == Ok(Notice::NoOrder(NoOrder::NotTeacher))), Ordering::Relaxed);
                }
            }
        });
        tokio::time::timeout(PATIENCE, welcomed).await.unwrap().unwrap();
        (Self { connection, _endpoint: endpoint, answered }, send)
    }

    fn begin(&self, mut send: quinn::SendStream, sends: Sends) {
        let connection = self.connection.clone();
        let lock = Request::Order(Order::Lock { is_locked: true });
        let frames = protocol::frame(&protocol::encode(&lock)).repeat(100);
        tokio::spawn(async move {
            match sends {
                Sends::Datagrams => {
                    while connection.send_datagram_wait(bytes::Bytes::from_static(&[0xa5; 20])).await.is_ok() {}
                }
                Sends::Requests => while send.write_all(&frames).await.is_ok() {},
            }
        });
    }
}

fn metric(server: &Server, name: &str) -> u64 {
    let mut stream = std::net::TcpStream::connect(server.operated_at().unwrap()).unwrap();
    stream.write_all(b"GET /metrics HTTP/1.1\r\nhost: pottery\r\n\r\n").unwrap();
    let mut page = String::new();
    stream.read_to_string(&mut page).unwrap();
    let line = page.lines().find(|line| line.split(' ').next() == Some(name));
    line.unwrap_or_else(|| panic!("{name} in {page}")).rsplit(' ').next().unwrap().parse().unwrap()
}

#[cfg(target_os = "linux")]
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_flood_from_one_address_is_cut_to_what_is_said_and_nobody_else_notices() {
    let log = tracing_subscriber::fmt().with_ansi(false).with_writer(|| Log);
    log.with_max_level(tracing::Level::INFO).init();
    let (each, spare) = (3, 2);
    let input = Input { spare_people: spare, ..Input::default() };
    let local = Some(SocketAddr::from(([127, 0, 0, 1], 0)));
    let listen = SocketAddr::from(([127, 0, 0, 1], 0));
    let server =
        Server::start(ServerConfig { listen, wheels: 2, input, operate: local, ..ServerConfig::default() }).unwrap();
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/strokes/waist.csv");
    let device = Box::new(ScriptedDevice::new(Arc::new(Stroke::read(&path).unwrap())));
    let own = quinn::Endpoint::client(([127, 0, 0, 2], 0).into()).unwrap();
    let target = Target::new(server.address().to_string(), server.code().clone(), 1);
    let untouched = server.standing().await.unwrap().digests[0];

    let begun = Instant::now();
    let mut flood = Vec::new();
    for number in 0..2 * each {
        let (flooder, send) = Flooder::join(&server, Ipv4Addr::new(127, 0, 0, 3)).await;
        flooder.begin(send, if number < each { Sends::Datagrams } else { Sends::Requests });
        flood.push(flooder);
    }
    let potter = Potter::join(&own, &target, device, PotterOptions::default()).await.unwrap();
    // whoever sends datagrams is let go in the end, whoever sends requests is kept waiting, and the potter's stroke comes to the clay
    let says = ["an address sends more than its people may", "a peer that sends far too much is let go"];
    while begun.elapsed() < Duration::from_secs(4)
        || server.standing().await.unwrap().people > each as usize + 1
        || server.standing().await.unwrap().digests[0] == untouched
        || metric(&server, "pottery_requests_held_total") == 0
        || says.iter().any(|sentence| !logged().contains(sentence))
    {
        assert!(begun.elapsed() < PATIENCE, "too little is sent, or nothing pressed, or not all said: {}", logged());
        tokio::time::sleep(ms(50)).await;
    }
    assert!(
        metric(&server, "pottery_datagrams_unheard_total") > 0 && metric(&server, "pottery_requests_held_total") > 0
    );
    let answered: u64 = flood.iter().map(|flooder| flooder.answered.load(Ordering::Relaxed)).sum();
    let heard = server.standing().await.unwrap().counts.refusals.malformed;
    // three people's, and what the address has to spare, over the time until it was asked for
    let seconds = begun.elapsed().as_secs_f64() + f64::from(Input::AT_ONCE_S);
    let most = |per_s: u32| (f64::from(each + spare) * f64::from(per_s) * seconds) as u64;
    let (most_datagrams, most_requests) = (most(input.datagrams_per_s), most(input.requests_per_s));
    println!("heard {heard} datagrams of at most {most_datagrams}, {answered} requests of at most {most_requests}");
    println!("{:?}", server.figures().await.unwrap().input);
    assert!(heard > 0 && heard <= most_datagrams && answered > 0 && answered <= most_requests);

    // the potter's clay is the server's while they still send
    assert!(potter.settle(PATIENCE).await, "not settled: {:?}", potter.view().lock().link);
    let pressed = server.standing().await.unwrap();
    assert_eq!(potter.view().lock().digest, pressed.digests[0]);
    assert_ne!(pressed.digests[0], untouched, "something was pressed");
    let log = logged();
    assert!(!log.contains("127.0.0.3") && !log.contains("127.0.0.2"), "{log}");
    potter.leave().await.unwrap();
    server.stop().await;
}
