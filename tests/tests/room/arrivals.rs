//! A class that comes at once: keyframes are made for all of them together, and everybody gets the clay there is.
//!
//! A room and its people in one process over virtual time, on a line that loses nothing but takes its time.
//! Invariant under test: whoever comes holds the author's clay soon, from a keyframe of a moment ago or not.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use pottery_client::stroke::Stroke;
use pottery_shared::clay::{Material, MethodKind, PotSpec};
use pottery_shared::protocol::{self, FrameReader, KEYFRAME_MAX, Keyframe};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{Client, Watcher};
use pottery_shared::snapshot::Detail;
use pottery_shared::units::{Rpm, Tick};
use pottery_tests::load::hand::Path as HandPath;

const CODE: &str = "CLAY";
/// How long a message is under way, ms.
const DELAY_MS: u64 = 15;

enum Person {
    Works(Box<Client>),
    Watches(Box<Watcher>),
}

struct Class {
    room: Room,
    people: BTreeMap<PeerId, Person>,
    /// By when they come.
    parcels: BTreeMap<(u64, u64), (PeerId, Lane)>,
    sent: u64,
    path: HandPath,
    /// The versions of keyframes, by whom they were for.
    keyframes: BTreeMap<bool, Vec<u32>>,
}

fn bare(framed: &[u8]) -> Vec<u8> {
    let mut reader = FrameReader::default();
    reader.push(framed);
    reader.next_frame().unwrap().unwrap()
}

impl Class {
    /// With one potter, number 0, who presses all the time.
    fn new() -> Self {
        let room = Room::new(RoomConfig {
            code: CODE.into(),
            wheels: 1,
            people_max: 200,
            pot: PotSpec::default(),
            method: MethodKind::Plastic,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        });
        let stroke = Stroke::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("../data/strokes/waist.csv")).unwrap();
        let mut class = Self {
            room: room.unwrap(),
            people: BTreeMap::new(),
            parcels: BTreeMap::new(),
            sent: 0,
            path: HandPath::new(Arc::new(stroke), 5),
            keyframes: BTreeMap::new(),
        };
        class.come(0, true, true, 0);
        class
    }

    fn come(&mut self, number: u64, works: bool, retells: bool, now: u64) {
        let peer = PeerId(number);
        let greeting = if works { Client::greeting(CODE, 1, retells) } else { Watcher::greeting(CODE, 10_000_000) };
        self.room.handle_control(peer, &bare(&greeting));
        let answer = loop {
            match self.room.poll_transmit().unwrap() {
                transmit if transmit.to != peer => self.post(transmit.to, transmit.lane, now),
                transmit => break transmit.lane,
            }
        };
        let Lane::Control(frame) = answer else { panic!() };
        let person = if works {
            Person::Works(Box::new(Client::open(&bare(&frame), now, Duration::ZERO).unwrap()))
        } else {
            let mut watcher = Watcher::open(&bare(&frame), Duration::ZERO).unwrap();
            watcher.watch(1, Detail::SPECTATOR, Duration::from_millis(now));
            Person::Watches(Box::new(watcher))
        };
        self.people.insert(peer, person);
    }

    fn post(&mut self, to: PeerId, lane: Lane, now: u64) {
        if let Lane::Keyframe(bytes) = &lane {
            let keyframe = protocol::decode::<KEYFRAME_MAX, Keyframe>(bytes).unwrap();
            self.keyframes.entry(keyframe.sight.is_some()).or_default().push(keyframe.version);
        }
        self.sent += 1;
        self.parcels.insert((now + DELAY_MS, self.sent), (to, lane));
    }

    fn pass(&mut self, now: u64) {
        let time = Duration::from_millis(now);
        while let Some(entry) = self.parcels.first_entry().filter(|entry| entry.key().0 <= now) {
            let (to, lane) = entry.remove();
            match (self.people.get_mut(&to).unwrap(), lane) {
                (Person::Works(client), Lane::Datagram(bytes)) => assert!(client.handle_datagram(&bytes, time)),
                (Person::Works(client), Lane::Keyframe(bytes)) => assert!(client.handle_keyframe(&bytes, time)),
                (Person::Works(client), Lane::Control(frame)) => client.handle_control(&bare(&frame)).unwrap(),
                (Person::Watches(watcher), Lane::Datagram(bytes)) => assert!(watcher.handle_datagram(&bytes, time)),
                (Person::Watches(watcher), Lane::Keyframe(bytes)) => assert!(watcher.handle_keyframe(&bytes, time)),
                (Person::Watches(watcher), Lane::Control(frame)) => watcher.handle_control(&bare(&frame)).unwrap(),
                (_, Lane::Close) => panic!("somebody was sent away"),
            }
        }
        for (&peer, person) in &mut self.people {
            match person {
                Person::Works(client) => {
                    if peer.0 == 0
                        && let Some(sample) = self.path.sample(now, Tick(0).offset(now as i64 + client.tick_offset()))
                    {
                        client.handle_sample(sample);
                    }
                    client.rebase();
                    while let Some(datagram) = client.poll_datagram(time) {
                        self.room.handle_datagram(peer, &datagram);
                    }
                    while let Some(frame) = client.poll_control() {
                        self.room.handle_control(peer, &bare(&frame));
                    }
                }
                Person::Watches(watcher) => {
                    watcher.handle_time(time);
                    while let Some(frame) = watcher.poll_control() {
                        self.room.handle_control(peer, &bare(&frame));
                    }
                }
            }
        }
        self.room.advance(Tick(now));
        while let Some(transmit) = self.room.poll_transmit() {
            self.post(transmit.to, transmit.lane, now);
        }
    }
}

#[test]
fn class_that_comes_at_once_shares_its_keyframes_and_has_the_clay() {
    let mut class = Class::new();
    (1..2000).for_each(|now| class.pass(now));
    class.keyframes.clear();
    for now in 2000..2400 {
        // a hundred in 400 ms: a third takes transcripts, a third deltas, a third looks on
        if now % 4 == 0 {
            let number = (now - 2000) / 4 + 1;
            class.come(number, number % 3 != 0, number % 3 == 1, now);
        }
        class.pass(now);
    }
    (2400..3500).for_each(|now| class.pass(now));
    for (sights, versions) in &class.keyframes {
        let distinct: BTreeSet<_> = versions.iter().collect();
        assert!(versions.len() >= 33, "sights {sights}: {} keyframes", versions.len());
        // one in a quarter of a second for each way of getting on, where each newcomer had one of their own
        assert!(distinct.len() <= 8, "sights {sights}: {distinct:?}");
    }
    let digest = class.room.digest(0).unwrap();
    let mut views = BTreeSet::new();
    for (peer, person) in &class.people {
        match person {
            Person::Works(client) => {
                assert_eq!(client.mismatches(), 0, "{peer:?}");
                // what is on its way is not there yet; nothing older is held than that
                let behind = class.room.now().0 - DELAY_MS;
                assert!(client.is_settled() || peer.0 == 0, "{peer:?} at {behind}");
            }
            Person::Watches(watcher) => {
                assert_eq!(watcher.mismatches(), 0, "{peer:?}");
                views.insert(watcher.sight(1).unwrap().digest());
            }
        }
    }
    // the stroke goes on, so that only those who have the same messages can be compared
    assert_eq!(views.len(), 1, "those who look on do not see the same");
    let works = class.people.values().filter_map(|person| match person {
        Person::Works(client) => Some(client.replica().digest()),
        Person::Watches(_) => None,
    });
    let held: BTreeSet<u64> = works.collect();
    assert_eq!(held.len(), 1, "those who work do not have the same clay, of which the room's is {digest:x}");
}
