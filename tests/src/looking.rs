//! A room, potters and those who look on, in one process over virtual time and a wire that loses.
//!
//! Owns the wire, what it took and how far what is seen is from what was made; which wheels at which detail is for a test to say.
//! Invariant: potters hear everything at once, so that whatever is wrong is wrong with those who look on.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{Material, MethodKind, Pot, PotSpec};
use pottery_shared::protocol::{self, FrameReader};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{Client, Watcher};
use pottery_shared::snapshot::{Detail, QUANTUM_M};
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};

use crate::dice::Dice;

const CODE: &str = "CLAY";
/// How deep a hand comes for its measure that has more force than most, mm.
pub const DEEP_MM: f32 = 4.0;

/// Somebody who looks on, and what that took.
#[derive(Debug)]
pub struct Looker {
    /// The session, once the room has answered.
    pub watcher: Option<Watcher>,
    /// Bytes of datagrams.
    pub datagram_bytes: u64,
    /// Bytes of keyframes.
    pub keyframe_bytes: u64,
    /// Bytes on the line, with what UDP, IP and QUIC put round them, for each second.
    pub line_bytes: u64,
}

/// What is on its way to one who looks on.
#[derive(Debug)]
enum Parcel {
    Frame(Vec<u8>),
    Datagram(Vec<u8>),
    Keyframe(Vec<u8>),
}

/// A room, its potters and those who look on.
#[derive(Debug)]
pub struct World {
    /// The room.
    pub room: Room,
    potters: BTreeMap<PeerId, Client>,
    /// Those who look on.
    pub lookers: BTreeMap<PeerId, Looker>,
    parcels: BTreeMap<(u64, u64), (PeerId, Parcel)>,
    sent: u64,
    dice: Dice,
    delay_ms: u64,
    loss: f64,
    /// What everybody holds.
    pub tool: Tool,
    /// How deep it comes at the most, mm.
    pub depth_mm: f32,
}

impl World {
    /// A potter at each wheel, who hears everything at once; who looks on hears so much later, and less.
    ///
    /// # Panics
    /// When the room says what its own clients do not understand, as all of this does.
    #[must_use]
    pub fn new(wheels: u16, delay_ms: u64, loss: f64) -> Self {
        Self::of(MethodKind::Plastic, wheels, delay_ms, loss)
    }

    /// The same with another clay.
    ///
    /// # Panics
    /// As [`Self::new`].
    #[must_use]
    pub fn of(method: MethodKind, wheels: u16, delay_ms: u64, loss: f64) -> Self {
        let room = Room::new(RoomConfig {
            code: CODE.into(),
            wheels,
            people_max: 64,
            pot: PotSpec::default(),
            method,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        });
        let mut world = Self {
            room: room.expect("a studio understands itself"),
            potters: BTreeMap::new(),
            lookers: BTreeMap::new(),
            parcels: BTreeMap::new(),
            sent: 0,
            dice: Dice::new(1),
            delay_ms,
            loss,
            tool: Tool::default(),
            depth_mm: DEEP_MM,
        };
        for wheel in 1..=wheels {
            let peer = PeerId(u64::from(wheel));
            world.room.handle_control(peer, &bare(&Client::greeting(CODE, wheel, true)));
            let Some(Lane::Control(welcome)) = world.room.poll_transmit().map(|transmit| transmit.lane) else {
                panic!()
            };
            let mut potter = Client::open(&bare(&welcome), 0, Duration::ZERO).expect("a studio understands itself");
            while let Some(transmit) = world.room.poll_transmit() {
                let Lane::Control(frame) = transmit.lane else { panic!() };
                potter.handle_control(&bare(&frame)).expect("a studio understands itself");
            }
            world.potters.insert(peer, potter);
        }
        world
    }

    /// Somebody comes to look on, for so many bytes a second.
    pub fn look_on(&mut self, number: u64, bytes_per_s: u32) -> PeerId {
        let peer = PeerId(100 + number);
        self.room.handle_control(peer, &bare(&Watcher::greeting(CODE, bytes_per_s)));
        self.lookers.insert(peer, Looker { watcher: None, datagram_bytes: 0, keyframe_bytes: 0, line_bytes: 0 });
        // the answer is on its way
        self.transmit(0);
        peer
    }

    /// The session of one who looks on.
    ///
    /// # Panics
    /// When the room has not answered yet.
    pub fn watcher(&mut self, peer: PeerId) -> &mut Watcher {
        self.lookers
            .get_mut(&peer)
            .expect("a studio understands itself")
            .watcher
            .as_mut()
            .expect("a studio understands itself")
    }

    /// The session of the potter at a wheel.
    ///
    /// # Panics
    /// When there is no such wheel.
    pub fn potter(&mut self, number: u64) -> &mut Client {
        self.potters.get_mut(&PeerId(number)).expect("a studio understands itself")
    }

    /// The potter at a wheel goes home.
    pub fn go(&mut self, number: u64) {
        self.potters.remove(&PeerId(number));
        self.room.handle_gone(PeerId(number));
    }

    fn transmit(&mut self, now: u64) {
        while let Some(transmit) = self.room.poll_transmit() {
            let peer = transmit.to;
            if let Some(potter) = self.potters.get_mut(&peer) {
                let time = Duration::from_millis(now);
                match transmit.lane {
                    Lane::Datagram(bytes) => assert!(potter.handle_datagram(&bytes, time)),
                    Lane::Keyframe(bytes) => assert!(potter.handle_keyframe(&bytes, time)),
                    Lane::Control(frame) => potter.handle_control(&bare(&frame)).expect("a studio understands itself"),
                    Lane::Close => panic!("a potter was sent away"),
                }
                potter.rebase();
                continue;
            }
            let looker = self.lookers.get_mut(&peer).expect("a studio understands itself");
            let parcel = match transmit.lane {
                Lane::Datagram(bytes) => {
                    assert!(bytes.len() <= protocol::DATAGRAM_MAX, "{} bytes", bytes.len());
                    looker.datagram_bytes += bytes.len() as u64;
                    looker.line_bytes += bytes.len() as u64 + 57;
                    if self.dice.chance(self.loss) {
                        continue;
                    }
                    Parcel::Datagram(bytes.into())
                }
                Lane::Keyframe(bytes) => {
                    looker.keyframe_bytes += bytes.len() as u64;
                    looker.line_bytes += bytes.len() as u64 + 57 * (1 + bytes.len() as u64 / 1200);
                    Parcel::Keyframe(bytes)
                }
                Lane::Control(frame) => Parcel::Frame(bare(&frame)),
                Lane::Close => continue,
            };
            // a stream keeps its order
            let is_stream = matches!(parcel, Parcel::Frame(_));
            let jitter = if self.loss > 0.0 && !is_stream { (self.dice.share() * 30.0) as u64 } else { 0 };
            self.sent += 1;
            self.parcels.insert((now + self.delay_ms + jitter, self.sent), (peer, parcel));
        }
    }

    /// One millisecond.
    ///
    /// # Panics
    /// When anybody says what is not understood.
    pub fn step(&mut self, now: u64, is_pressing: bool) {
        let time = Duration::from_millis(now);
        for (&PeerId(number), potter) in &mut self.potters {
            if is_pressing && let Some(centre) = hand(number, now, self.depth_mm) {
                let tick = Tick(0).offset(now as i64 + potter.tick_offset());
                let (tool, orientation) = (self.tool, Orientation::default());
                potter.handle_sample(ToolSample { tick, tool, orientation, centre, side: Side::Outside });
            }
            while now.is_multiple_of(10)
                && let Some(bytes) = potter.poll_datagram(time)
            {
                self.room.handle_datagram(PeerId(number), &bytes);
            }
            while let Some(frame) = potter.poll_control() {
                self.room.handle_control(PeerId(number), &bare(&frame));
            }
        }
        self.room.advance(Tick(now));
        self.transmit(now);
        while let Some(entry) = self.parcels.first_entry()
            && entry.key().0 <= now
        {
            let (peer, parcel) = entry.remove();
            let looker = self.lookers.get_mut(&peer).expect("a studio understands itself");
            match (&mut looker.watcher, parcel) {
                (None, Parcel::Frame(frame)) => {
                    let round_trip = Duration::from_millis(2 * self.delay_ms);
                    looker.watcher = Some(Watcher::open(&frame, round_trip).expect("a studio understands itself"));
                }
                (Some(watcher), Parcel::Frame(frame)) => {
                    watcher.handle_control(&frame).expect("a studio understands itself")
                }
                (Some(watcher), Parcel::Datagram(bytes)) => assert!(watcher.handle_datagram(&bytes, time)),
                (Some(watcher), Parcel::Keyframe(bytes)) => assert!(watcher.handle_keyframe(&bytes, time)),
                (None, _) => panic!("something came before the answer"),
            }
        }
        for (&peer, looker) in &mut self.lookers {
            let Some(watcher) = &mut looker.watcher else { continue };
            watcher.handle_time(time);
            while let Some(frame) = watcher.poll_control() {
                self.room.handle_control(peer, &bare(&frame));
            }
        }
    }
}

/// A frame without its length.
fn bare(framed: &[u8]) -> Vec<u8> {
    let mut reader = FrameReader::default();
    reader.push(framed);
    reader.next_frame().expect("a studio understands itself").expect("a studio understands itself")
}

/// A hand that strokes up and down, at each wheel another way, 1.5 mm deeper at one time than at another, and trembles a twentieth of a
/// millimetre nine times a second.
fn hand(number: u64, now: u64, depth_mm: f32) -> Option<Position> {
    let time = now as f32 * 1e-3;
    let tremor = 5e-5 * Vec3::new((57.0 * time).sin(), (61.0 * time).cos(), (53.0 * time).sin());
    let distance = 0.0735 - depth_mm * 1e-3 - 0.0015 * (time * 2.0 + number as f32).sin().abs();
    Position::nearest(Vec3::new(distance, 0.0, 0.1 + 0.04 * (time + number as f32).sin()) + tremor)
}

/// The largest difference of a sight from the mean of the elements under each of its own, m.
#[must_use]
pub fn worst_m(seen: &Pot, made: &Pot) -> f32 {
    worst_in_m(seen, made, 0..seen.spec().shape.rows())
}

/// The same in some rows of the sight.
#[must_use]
pub fn worst_in_m(seen: &Pot, made: &Pot, rows: Range<u32>) -> f32 {
    let (coarse, fine) = (seen.spec().shape, made.spec().shape);
    let fold = (fine.columns() / coarse.columns(), fine.rows() / coarse.rows());
    let mut worst = 0.0_f32;
    for column in 0..coarse.columns() {
        for row in rows.clone() {
            let mut sum = 0.0;
            for under in 0..fold.0 {
                let rows = (row * fold.1) as usize..((row + 1) * fold.1) as usize;
                let radii = &made.surfaces()[0].column_m(column * fold.0 + under)[rows];
                sum += radii.iter().map(|&radius| f64::from(radius)).sum::<f64>();
            }
            let mean = (sum / f64::from(fold.0 * fold.1)) as f32;
            worst = worst.max((seen.surfaces()[0].column_m(column)[row as usize] - mean).abs());
        }
    }
    worst
}

/// Half of the quantum, and what the mean and the untouched radius are rounded by.
#[must_use]
pub fn allowed_m(detail: Detail) -> f32 {
    0.5 * detail.quantum().metres() + QUANTUM_M
}
