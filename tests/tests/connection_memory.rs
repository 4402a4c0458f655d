//! What one connection can make the server hold: no more than it says, whatever the peer does.
//!
//! Server and peers are in one thread, over a network in memory and virtual time, with an allocator that counts: the same session is held with
//! a hostile peer and without.
//! Invariant under test: the hostile one makes no more difference than [`CONNECTION_BYTES_MAX`], and nobody else notices.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;
use std::time::Duration;

use glam::Vec3;
use pottery_client::client_config;
use pottery_client::device::Device;
use pottery_client::view::Link;
use pottery_client::{HapticLoop, Seat};
use pottery_server::{CONNECTION_BYTES_MAX, ServerConfig};
use pottery_shared::haptics::{DeviceSpecs, Setup, Stages};
use pottery_shared::protocol::{self, Inputs, POT_PIECE, Request, Run, ShapeWire, Upload};
use pottery_shared::session::Client;
use pottery_shared::tool::Tool;
use pottery_tests::allocations::{Counting, held_bytes};
use pottery_tests::line::Quality;
use pottery_tests::network::Network;
use pottery_tests::simulation::{Joined, SERVER, Simulation, in_virtual_time, ms};
use quinn::VarInt;
use tokio::time::{Instant, sleep};

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// As long as a silent connection is kept, and a little more.
const LASTS: Duration = Duration::from_secs(12);

/// Of a pot on the wheel's grid, two bytes an element.
const POT_BYTES: usize = 2 * 360 * 400;

/// What a peer does once it is in. None of them ever reads a stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Malice {
    /// Is not there at all.
    Absent,
    /// Sends samples as people do.
    Works,
    /// Says what makes no sense, a thousand times a second.
    Babbles,
    /// Sends samples of the next second without an end, and every one again.
    Floods,
    /// Asks for the whole pot again and again.
    Asks,
    /// Begins a long frame and never ends it.
    Stammers,
    /// Brings pots, and never the last piece of one.
    Brings,
    /// Is never heard of again, so that nothing is acknowledged.
    FallsSilent,
}

/// A hand that presses round and round.
struct Presser(f32);

impl Device for Presser {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        let time = seconds as f32;
        let (distance_m, height_m) = (0.0705 - 0.0015 * (time * 2.0).sin(), 0.1 + 0.04 * (time + self.0).sin());
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

/// A peer that has come in, with as little memory of its own as QUIC lets it have.
struct Hostile {
    malice: Malice,
    connection: quinn::Connection,
    send: quinn::SendStream,
    _receive: quinn::RecvStream,
    endpoint: quinn::Endpoint,
    sent: u32,
    /// Pieces of pots that were begun to be sent, and what of the last one is to be sent yet.
    pieces: usize,
    unsent: Vec<u8>,
}

impl Hostile {
    async fn join(studio: &Simulation, malice: Malice) -> Self {
        let endpoint = studio.endpoint(9, Quality::LAN, Quality::LAN).unwrap();
        let mut config = client_config(studio.server.code()).unwrap();
        let mut transport = quinn::TransportConfig::default();
        transport
            .stream_receive_window(VarInt::from_u32(2048))
            .receive_window(VarInt::from_u32(4096))
            .send_window(64 * 1024)
            .datagram_receive_buffer_size(Some(4096))
            .datagram_send_buffer_size(16 * 1024)
            .keep_alive_interval(Some(Duration::from_secs(2)));
        config.transport_config(Arc::new(transport));
        let connecting = endpoint.connect_with(config, SERVER.into(), "pottery-studio").unwrap();
        let connection = connecting.await.unwrap();
        let (mut send, receive) = connection.open_bi().await.unwrap();
        send.write_all(&Client::greeting(studio.server.code().room(), 1, false)).await.unwrap();
        if malice == Malice::Stammers {
            send.write_all(&(protocol::CONTROL_MAX as u16).to_le_bytes()).await.unwrap();
        }
        Self { malice, connection, send, _receive: receive, endpoint, sent: 0, pieces: 0, unsent: Vec::new() }
    }

    /// What it does in a millisecond.
    async fn act(&mut self, network: &Network, tick: u64) {
        self.sent += 1;
        match self.malice {
            Malice::Absent => {}
            Malice::Babbles => {
                for length in [1, 200, 1100] {
                    drop(self.connection.send_datagram(vec![0xa5; length].into()));
                }
            }
            Malice::Works | Malice::Floods => {
                let floods = self.malice == Malice::Floods;
                let number = self.sent - 1;
                // people say their last samples again
                let again = if floods { 0 } else { number.min(40) };
                let (ahead, samples, first, times) =
                    if floods { (1_000, 401, 30 * number, 4) } else { (20, again + 1, number - again, 1) };
                let run = Run {
                    first_tick: (tick + ahead - u64::from(again)) as u16,
                    tool: ShapeWire::Sphere { radius_um: 12_000 },
                    inside: false,
                    start: [20_000, 0, 10_000],
                    steps: vec![[0; 3]; samples as usize - 1],
                    turns: Vec::new(),
                };
                let inputs = Inputs { first: first as u16, runs: vec![run], rests: true };
                let upload = protocol::encode(&Upload { inputs, hand: None, again: None });
                for _ in 0..times {
                    drop(self.connection.send_datagram(upload.clone().into()));
                }
            }
            Malice::Asks => {
                let frame = protocol::frame(&protocol::encode(&Request::Resync { have: 0 }));
                drop(tokio::time::timeout(ms(1), self.send.write_all(&frame)).await);
            }
            Malice::Brings => {
                if self.unsent.is_empty() {
                    let piece = self.pieces % (POT_BYTES / POT_PIECE);
                    let request = Request::Pot { held: 0, piece: piece as u16, bytes: vec![1; POT_PIECE] };
                    self.unsent = protocol::frame(&protocol::encode(&request));
                    self.pieces += 1;
                }
                if let Ok(Ok(sent)) = tokio::time::timeout(ms(1), self.send.write(&self.unsent)).await {
                    self.unsent.drain(..sent);
                }
            }
            Malice::Stammers => drop(tokio::time::timeout(ms(1), self.send.write_all(&[7])).await),
            Malice::FallsSilent => network.cut(self.endpoint.local_addr().unwrap(), true),
        }
    }
}

/// Most bytes that were held at a time by everybody.
fn most_held(malice: Malice) -> i64 {
    let before = held_bytes();
    in_virtual_time(async {
        let studio = Simulation::open(3, ServerConfig::default()).unwrap();
        let mut people = Vec::new();
        for number in 0..2 {
            let target = studio.target(1);
            let Joined { endpoint, seat, .. } = studio.join(number, Quality::LAN, Quality::LAN, &target).await.unwrap();
            let Seat { view, commands, epoch, worker, hand, .. } = seat;
            let hand = HapticLoop::new(Box::new(Presser(f32::from(number) * 2.0)), hand);
            people.push((endpoint, view, commands, epoch, tokio::spawn(worker.run()), hand));
        }
        let mut hostile = match malice {
            Malice::Absent => None,
            _ => Some(Hostile::join(&studio, malice).await),
        };
        let mut most = 0;
        let begun = Instant::now();
        while begun.elapsed() < LASTS {
            sleep(ms(1)).await;
            for (.., epoch, _, hand) in &mut people {
                hand.tick(epoch.elapsed().as_millis() as u64);
            }
            if let Some(hostile) = &mut hostile {
                hostile.act(&studio.network, studio.opened.elapsed().as_millis() as u64).await;
            }
            most = most.max(held_bytes() - before);
        }
        // nobody else notices
        for (_, view, _, _, worker, _) in &people {
            let view = view.lock();
            assert!(view.link == Link::Open && !worker.is_finished(), "{malice:?}: {:?}", view.link);
            assert!(view.round_trip < ms(20), "{malice:?}: {:?}", view.round_trip);
        }
        studio.server.stop().await;
        most
    })
}

#[test]
fn no_peer_makes_the_server_hold_more_than_it_says() {
    let [alone, with_a_hand] = [Malice::Absent, Malice::Works].map(most_held);
    for malice in [Malice::Babbles, Malice::Floods, Malice::Asks, Malice::Stammers, Malice::Brings, Malice::FallsSilent]
    {
        // for a third hand a wheel sets room aside, which is in memory as far as it is pressed with; and samples that flood are a hand's, too
        let without = if malice == Malice::Floods { with_a_hand } else { alone };
        let more = most_held(malice) - without;
        let most = CONNECTION_BYTES_MAX + if malice == Malice::Brings { 2 * POT_BYTES } else { 0 };
        println!("{malice:?}: {:.0} kB more than without it, of {:.0} kB", more as f64 * 1e-3, most as f64 * 1e-3);
        // its own end of the line is among them: 90 kB of buffers and what QUIC holds there
        assert!(more < most as i64, "{malice:?}: {more} bytes");
    }
}
