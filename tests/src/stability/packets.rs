//! Packets that are none: cut short, longer than they were, changed on their way or made up, between a room and those who press in it.
//!
//! Owns who gets them and when. Room, clients and their codec are the studio's own, with nothing between them but 20 ms: a line's own faults are
//! [`super::lines`]'.
//! Invariant: who is let go, or hears what is no message on the stream, comes back with a greeting and nothing else.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{Material, Method, MethodKind, PotSpec};
use pottery_shared::protocol::{self, DATAGRAM_MEMORY_MAX, KEYFRAME_MAX, Keyframe, Pulse, Request};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::Client;
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};

use crate::dice::Dice;

/// Way of a packet, ms.
const WAY_MS: u64 = 20;
/// Until when people press, until when packets are damaged, and when all is looked at, ms: two seconds of quiet for whoever has to come back, or
/// to be mended.
const PRESSED_MS: u64 = 3000;
const DAMAGED_MS: u64 = 3500;
const LOOKED_AT_MS: u64 = 5500;
/// Of the dice.
const SEEDS: std::ops::RangeInclusive<u64> = 1..=10;
/// Fewer damaged packets of all seeds say nothing.
const LEAST: u64 = 500;

/// What is wrong with packets.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Odd {
    /// Before a packet comes a part of it, or the whole with something behind it, both ways.
    Cut,
    /// A third at the wheel sends their own changed, or noise.
    Stranger,
    /// What the room tells of clay comes changed, or noise in its place: nobody but a room with a fault sends that, since QUIC lets nobody else
    /// change it. Its word on versions, time and what it has heard is taken as its word.
    Changed,
}

enum Parcel {
    Datagram(Vec<u8>),
    Control(Vec<u8>),
    Keyframe(Vec<u8>),
    Close,
}

struct Person {
    peer: PeerId,
    client: Option<Client>,
}

struct Studio {
    odd: Odd,
    dice: Dice,
    room: Room,
    people: Vec<Person>,
    /// On their way to the room and from it, by time of arrival and order.
    up: BTreeMap<(u64, u64), (PeerId, Parcel)>,
    down: BTreeMap<(u64, u64), (PeerId, Parcel)>,
    sent: u64,
    greeted: u64,
    damaged: u64,
    /// Cut ones of which nobody said that they are no message.
    taken: u64,
}

/// Packets taken for what they are not, and people whose pot is not the room's to the bit in the end, of all seeds; infinite when that says nothing,
/// since hardly a packet was damaged, or nobody pressed.
pub(super) fn fooled(method: MethodKind, odd: Odd) -> f64 {
    let (mut fooled, mut damaged) = (0, 0);
    for seed in SEEDS {
        let mut studio = Studio::open(method, odd, seed);
        let untouched = studio.room.digest(0);
        (0..LOOKED_AT_MS).for_each(|now| studio.step(now));
        let held = studio.room.pot(0).map(|pot| (studio.room.digest(0), pot.digest()));
        if held.is_none() || studio.room.digest(0) == untouched {
            return f64::INFINITY;
        }
        let pots = |client: &Client| (Some(client.replica().digest()), client.predicted().digest());
        let others = studio.people.iter().filter(|person| person.client.as_ref().map(pots) != held);
        fooled += studio.taken + others.count() as u64;
        damaged += studio.damaged;
    }
    if damaged < LEAST { f64::INFINITY } else { fooled as f64 }
}

impl Studio {
    fn open(method: MethodKind, odd: Odd, seed: u64) -> Self {
        let config = RoomConfig {
            code: "CLAY".into(),
            wheels: 1,
            // a seat is kept for a while for whoever is gone
            people_max: 1000,
            pot: PotSpec { keeps_volume: method.keeps_volume(), ..PotSpec::default() },
            method,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        };
        let people = if odd == Odd::Stranger { 3 } else { 2 };
        let mut studio = Self {
            odd,
            dice: Dice::new(seed),
            room: Room::new(config).expect("a pot of the suite"),
            people: (0..people).map(|number| Person { peer: PeerId(number), client: None }).collect(),
            up: BTreeMap::new(),
            down: BTreeMap::new(),
            sent: 0,
            greeted: 0,
            damaged: 0,
            taken: 0,
        };
        for person in 0..studio.people.len() {
            studio.greet(person, 0);
        }
        studio
    }

    /// Begins anew, as somebody whom the room does not know.
    fn greet(&mut self, person: usize, now: u64) {
        self.greeted += 1;
        let peer = PeerId(self.greeted);
        self.people[person] = Person { peer, client: None };
        // one presses again what was pressed, the other takes the tiles that changed
        let greeting = Client::greeting("CLAY", 1, person.is_multiple_of(2));
        self.post_up(now, peer, Parcel::Control(greeting));
    }

    fn leave_and_greet(&mut self, person: usize, now: u64) {
        self.room.handle_gone(self.people[person].peer);
        self.greet(person, now);
    }

    fn post_up(&mut self, now: u64, peer: PeerId, parcel: Parcel) {
        self.sent += 1;
        self.up.insert((now + WAY_MS, self.sent), (peer, parcel));
    }

    fn step(&mut self, now: u64) {
        self.room.advance(Tick(now));
        while let Some(entry) = self.up.first_entry().filter(|entry| entry.key().0 <= now) {
            let (peer, parcel) = entry.remove();
            self.reach_room(peer, parcel, now);
        }
        while let Some(transmit) = self.room.poll_transmit() {
            let parcel = match transmit.lane {
                Lane::Datagram(bytes) => Parcel::Datagram(bytes.into()),
                Lane::Control(bytes) => Parcel::Control(bytes),
                Lane::Keyframe(bytes) => Parcel::Keyframe(bytes),
                Lane::Close => Parcel::Close,
            };
            self.sent += 1;
            self.down.insert((now + WAY_MS, self.sent), (transmit.to, parcel));
        }
        while let Some(entry) = self.down.first_entry().filter(|entry| entry.key().0 <= now) {
            let (peer, parcel) = entry.remove();
            // what was on its way to somebody who has left comes to nobody
            if let Some(person) = self.people.iter().position(|person| person.peer == peer) {
                self.reach_person(person, parcel, now);
            }
        }
        for person in 0..self.people.len() {
            self.press(person, now);
        }
    }

    /// A person's own tick, and what they send.
    fn press(&mut self, person: usize, now: u64) {
        let Person { peer, client: Some(client) } = &mut self.people[person] else { return };
        if now % 100 == 7 && now < PRESSED_MS {
            client.request(&Request::WheelSpeed { rpm: 60.0 + (now / 100 % 20) as f32 });
        }
        if now < PRESSED_MS {
            let tick = Tick(0).offset(now as i64 + client.tick_offset());
            let centre = Position::nearest(meant_m(person, now)).expect("a place at the wheel");
            let (tool, orientation) = (Tool::default(), Orientation::default());
            client.handle_sample(ToolSample { tick, tool, orientation, centre, side: Side::Outside });
        }
        client.rebase();
        let mut said: Vec<_> = std::iter::from_fn(|| client.poll_control()).map(Parcel::Control).collect();
        if now % 10 == person as u64 {
            let time = Duration::from_millis(now);
            said.extend(std::iter::from_fn(|| client.poll_datagram(time)).map(Parcel::Datagram));
        }
        let peer = *peer;
        said.into_iter().for_each(|parcel| self.post_up(now, peer, parcel));
    }

    /// Whether a packet of the people is to be damaged.
    fn is_hit(&mut self, chance: f64, now: u64) -> bool {
        let is_hit = now < DAMAGED_MS && self.dice.chance(chance);
        self.damaged += u64::from(is_hit);
        is_hit
    }

    fn reach_room(&mut self, peer: PeerId, parcel: Parcel, now: u64) {
        let is_strange = self.odd == Odd::Stranger && self.people[2].peer == peer;
        match parcel {
            Parcel::Datagram(bytes) => {
                if self.odd == Odd::Cut && self.room.is_in(peer) && self.is_hit(0.5, now) {
                    let said = self.room.counts().refusals.malformed;
                    self.room.handle_datagram(peer, &cut(&bytes, &mut self.dice));
                    self.taken += u64::from(self.room.counts().refusals.malformed == said);
                } else if is_strange && self.is_hit(0.7, now) {
                    self.room.handle_datagram(peer, &changed(&bytes, &mut self.dice));
                }
                self.room.handle_datagram(peer, &bytes);
            }
            // two bytes of length go before a frame, and are the stream's own
            Parcel::Control(bytes) if bytes.len() > 2 => {
                if self.odd == Odd::Cut && self.is_hit(0.2, now) {
                    let refused = self.room.counts().refused;
                    self.room.handle_control(peer, &cut(&bytes[2..], &mut self.dice));
                    self.taken += u64::from(self.room.counts().refused == refused);
                } else if is_strange && self.is_hit(0.7, now) {
                    self.room.handle_control(peer, &changed(&bytes[2..], &mut self.dice));
                } else {
                    self.room.handle_control(peer, &bytes[2..]);
                }
            }
            Parcel::Control(_) | Parcel::Keyframe(_) | Parcel::Close => {}
        }
    }

    /// What comes to a person before a packet, or in its place; nothing where it is left as it is.
    fn damaged_on_the_way(&mut self, parcel: &Parcel, now: u64) -> Option<Vec<u8>> {
        let (chance, bytes) = match (self.odd, parcel) {
            (Odd::Cut, Parcel::Datagram(bytes) | Parcel::Keyframe(bytes)) => (0.5, &bytes[..]),
            (Odd::Cut, Parcel::Control(bytes)) => (0.1, bytes.get(2..)?),
            (Odd::Changed, Parcel::Datagram(bytes) | Parcel::Keyframe(bytes)) => (0.2, &bytes[..]),
            _ => return None,
        };
        if now >= DAMAGED_MS || !self.dice.chance(chance) {
            return None;
        }
        let dice = &mut self.dice;
        let odd = match (self.odd, parcel) {
            (Odd::Cut, _) => cut(bytes, dice),
            _ if dice.chance(0.2) => noise(bytes.len(), dice),
            (_, Parcel::Keyframe(_)) => {
                let mut keyframe: Keyframe = protocol::decode::<KEYFRAME_MAX, _>(bytes).ok()?;
                keyframe.bytes = changed(&keyframe.bytes, dice);
                protocol::encode(&keyframe)
            }
            _ => {
                let mut pulse: Pulse = protocol::decode::<DATAGRAM_MEMORY_MAX, _>(bytes).ok()?;
                let fragment = pulse.body.fragments.first_mut()?;
                fragment.bytes = changed(&fragment.bytes, dice);
                protocol::encode(&pulse)
            }
        };
        self.damaged += 1;
        Some(odd)
    }

    fn reach_person(&mut self, person: usize, parcel: Parcel, now: u64) {
        let time = Duration::from_millis(now);
        let is_cut = self.odd == Odd::Cut;
        let odd = self.damaged_on_the_way(&parcel, now);
        let Person { client, .. } = &mut self.people[person];
        let mut is_lost = false;
        match (parcel, client) {
            (Parcel::Datagram(bytes), Some(client)) => {
                let is_whole = odd.is_none_or(|odd| {
                    self.taken += u64::from(client.handle_datagram(&odd, time) && is_cut);
                    is_cut
                });
                if is_whole {
                    client.handle_datagram(&bytes, time);
                }
            }
            (Parcel::Keyframe(bytes), Some(client)) => {
                let is_whole = odd.is_none_or(|odd| {
                    self.taken += u64::from(client.handle_keyframe(&odd, time) && is_cut);
                    is_cut
                });
                if is_whole {
                    client.handle_keyframe(&bytes, time);
                }
            }
            (Parcel::Control(bytes), client) if bytes.len() > 2 => {
                let is_hit = odd.is_some();
                let frame = odd.unwrap_or_else(|| bytes[2..].to_vec());
                let heard = match client {
                    Some(client) => client.handle_control(&frame),
                    None => Client::open(&frame, now, Duration::from_millis(2 * WAY_MS))
                        .map(|opened| *client = Some(opened)),
                };
                self.taken += u64::from(is_hit && heard.is_ok());
                is_lost = heard.is_err();
            }
            (Parcel::Close, _) => is_lost = true,
            _ => {}
        }
        if is_lost {
            self.leave_and_greet(person, now);
        }
    }
}

/// Where a person's tool is: in and out, up and down, and round the pot that turns.
fn meant_m(person: usize, now: u64) -> Vec3 {
    let (seconds, angle) = (now as f64 * 1e-3, person as f64 * 2.2);
    let distance_m = 0.072 - 0.002 * (TAU * 0.4 * seconds).sin();
    let height_m = 0.1 + 0.03 * (seconds + person as f64).sin();
    Vec3::new((distance_m * angle.cos()) as f32, (distance_m * angle.sin()) as f32, height_m as f32)
}

/// A part of a packet from its beginning on, or all of it and up to eight bytes more.
fn cut(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    if bytes.is_empty() || dice.chance(0.5) {
        let behind = (0..1 + dice.roll() % 8).map(|_| dice.roll() as u8);
        return bytes.iter().copied().chain(behind).collect();
    }
    bytes[..dice.roll() as usize % bytes.len()].to_vec()
}

/// Bytes of which up to eight bits are others, or noise that is as long.
fn changed(bytes: &[u8], dice: &mut Dice) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    if bytes.is_empty() || dice.chance(0.2) {
        return noise(bytes.len().max(1), dice);
    }
    for _ in 0..1 + dice.roll() % 8 {
        let at = dice.roll() as usize % bytes.len();
        bytes[at] ^= 1 << (dice.roll() % 8);
    }
    bytes
}

fn noise(length: usize, dice: &mut Dice) -> Vec<u8> {
    (0..length).map(|_| dice.roll() as u8).collect()
}
