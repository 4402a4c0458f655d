//! Clay that went wrong at a client: found by digests, mended tile by tile, counted on both sides.
//!
//! What makes it wrong is a keyframe of another pot under the versions of this one, as a server with a fault would send it.
//! Invariant under test: whatever a replica holds, it holds the author's clay again soon, and no more than what differs is sent for it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{Material, MethodKind, Pot, PotSpec, Surface, Window};
use pottery_shared::protocol::{self, FrameReader, KEYFRAME_MAX, Keyframe, Request, frame};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{Client, MendCounts};
use pottery_shared::snapshot::{Author, Moment, Replica, TileLayout, Touched, Version};
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};

/// Way of a datagram or frame, and of a keyframe, which comes behind everything else.
const WAY_MS: u64 = 20;
const KEYFRAME_WAY_MS: u64 = 70;

fn bump(pot: &mut Pot, tile: u32, touched: &mut Touched, by_m: f32) {
    let Window { first_column, first_row, .. } = TileLayout::new(pot.surfaces()[0].shape()).window(tile);
    let radius_m = pot.surfaces()[0].column_m(first_column)[first_row as usize];
    pot.surfaces_mut()[0].set_radius(first_column, first_row, radius_m + by_m);
    touched.add(0, tile);
}

fn no_tiles(pot: &Pot) -> Touched {
    Touched::none(pot.surfaces().iter().map(Surface::shape))
}

/// Tiles of an untouched pot, each with one element that is not.
fn wrong_tiles(tiles: &[u32]) -> Vec<u8> {
    let mut pot = Pot::new(PotSpec::default()).unwrap();
    let mut author = Author::new(&mut pot);
    let mut touched = no_tiles(&pot);
    for &tile in tiles {
        bump(&mut pot, tile, &mut touched, -0.001);
    }
    author.publish(&mut pot, &mut touched, Moment::default()).unwrap();
    author.keyframe(Version(0), false)
}

#[test]
fn a_mend_leads_on_and_names_what_differs_beside() {
    let mut pot = Pot::new(PotSpec::default()).unwrap();
    let mut author = Author::new(&mut pot);
    let mut replica = Replica::new(Pot::new(PotSpec::default()).unwrap());
    let mut touched = no_tiles(&pot);
    let mut seen = no_tiles(&pot);
    for tile in 0..40 {
        bump(&mut pot, 7 * tile, &mut touched, -0.002);
        let delta = author.publish(&mut pot, &mut touched, Moment::default()).unwrap();
        replica.apply_delta(delta.version, &delta.bytes, &mut seen).unwrap();
    }
    let have = replica.version();
    let nothing = author.mend(have, &replica.tile_digests(), false).unwrap();
    assert_eq!(nothing.1, 0);
    replica.apply_keyframe(have, have, &wrong_tiles(&[3, 14, 500]), false, &mut seen).unwrap();
    let told = replica.tile_digests();
    // the author goes on: one tile that had gone wrong as well, and one that had not
    for tile in [14, 200] {
        bump(&mut pot, tile, &mut touched, -0.001);
    }
    let delta = author.publish(&mut pot, &mut touched, Moment::default()).unwrap();
    let (bytes, mended) = author.mend(have, &told, true).unwrap();
    assert_eq!(mended, 2, "3 and 500 differ, 14 comes anyway");
    let mut changed = no_tiles(&pot);
    replica.apply_keyframe(author.latest(), have, &bytes, true, &mut changed).unwrap();
    assert_eq!(changed.iter().map(|(_, tile, _)| tile).collect::<Vec<_>>(), [3, 14, 200, 500]);
    assert_eq!((replica.version(), replica.digest()), (delta.version, author.digest()));
    let whole = author.keyframe(Version(0), true).len();
    println!("{} B, nothing but what deltas build upon {} B, the whole pot {whole} B", bytes.len(), nothing.0.len());
    assert_eq!(author.mend(have, &told[1..], true), None);
    assert_eq!(author.mend(have, &[told.clone(), vec![0; 2]].concat(), true), None);
}

enum Parcel {
    Datagram(Vec<u8>),
    Control(Vec<u8>),
    Keyframe(Vec<u8>),
}

/// A room and two people: the first presses again what was pressed, the second takes deltas.
struct World {
    room: Room,
    clients: Vec<(Option<Client>, FrameReader)>,
    to_room: BTreeMap<(u64, u64), (PeerId, Parcel)>,
    to_client: BTreeMap<(u64, u64), (PeerId, Parcel)>,
    sent: u64,
    keyframes: Vec<(PeerId, Keyframe)>,
    /// Keyframes that do not come through.
    lost: usize,
}

impl World {
    fn new() -> Self {
        let room = Room::new(RoomConfig {
            code: "CLAY".into(),
            wheels: 1,
            people_max: 8,
            pot: PotSpec::default(),
            method: MethodKind::Plastic,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        });
        let mut world = Self {
            room: room.unwrap(),
            clients: Vec::new(),
            to_room: BTreeMap::new(),
            to_client: BTreeMap::new(),
            sent: 0,
            keyframes: Vec::new(),
            lost: 0,
        };
        for person in 0..2 {
            world.clients.push((None, FrameReader::default()));
            let greeting = Client::greeting("CLAY", 1, person == 0);
            world.to_room.insert((WAY_MS, person), (PeerId(person), Parcel::Control(greeting)));
        }
        world
    }

    fn client(&mut self, person: usize) -> &mut Client {
        self.clients[person].0.as_mut().unwrap()
    }

    fn step(&mut self, now: u64, hand: impl Fn(u64, u64) -> Option<Vec3>) {
        let time = Duration::from_millis(now);
        self.room.advance(Tick(now));
        while let Some(transmit) = self.room.poll_transmit() {
            self.sent += 1;
            let (way, parcel) = match transmit.lane {
                Lane::Datagram(bytes) => (WAY_MS, Parcel::Datagram(bytes.into())),
                Lane::Control(bytes) => (WAY_MS, Parcel::Control(bytes)),
                Lane::Keyframe(bytes) => {
                    self.keyframes.push((transmit.to, protocol::decode::<KEYFRAME_MAX, _>(&bytes).unwrap()));
                    if self.lost > 0 {
                        self.lost -= 1;
                        continue;
                    }
                    (KEYFRAME_WAY_MS, Parcel::Keyframe(bytes))
                }
                Lane::Close => panic!("nobody is let go"),
            };
            self.to_client.insert((now + way, self.sent), (transmit.to, parcel));
        }
        while let Some(entry) = self.to_room.first_entry().filter(|entry| entry.key().0 <= now) {
            match entry.remove() {
                (peer, Parcel::Datagram(bytes)) => self.room.handle_datagram(peer, &bytes),
                (peer, Parcel::Control(bytes)) => self.room.handle_control(peer, &bytes[2..]),
                (_, Parcel::Keyframe(_)) => {}
            }
        }
        while let Some(entry) = self.to_client.first_entry().filter(|entry| entry.key().0 <= now) {
            let (peer, parcel) = entry.remove();
            let (client, reader) = &mut self.clients[peer.0 as usize];
            match (parcel, client) {
                (Parcel::Datagram(bytes), Some(client)) => assert!(client.handle_datagram(&bytes, time)),
                (Parcel::Keyframe(bytes), Some(client)) => assert!(client.handle_keyframe(&bytes, time)),
                (Parcel::Control(bytes), Some(client)) => client.handle_control(&bytes[2..]).unwrap(),
                (Parcel::Control(bytes), client) => {
                    reader.push(&bytes);
                    let welcome = reader.next_frame().unwrap().unwrap();
                    *client = Some(Client::open(&welcome, now, Duration::from_millis(2 * WAY_MS)).unwrap());
                }
                _ => {}
            }
        }
        for (peer, (client, _)) in (0..).zip(&mut self.clients) {
            let Some(client) = client else { continue };
            let tick = Tick(0).offset(now as i64 + client.tick_offset());
            if let Some(point) = hand(peer, now) {
                let centre = Position::nearest(point).unwrap();
                let (tool, orientation) = (Tool::default(), Orientation::default());
                client.handle_sample(ToolSample { tick, tool, orientation, centre, side: Side::Outside });
            }
            client.rebase();
            let datagrams: Vec<_> = if now % 10 == peer {
                std::iter::from_fn(|| client.poll_datagram(time)).map(Parcel::Datagram).collect()
            } else {
                Vec::new()
            };
            let frames = std::iter::from_fn(|| client.poll_control()).map(Parcel::Control);
            for parcel in frames.chain(datagrams) {
                self.sent += 1;
                self.to_room.insert((now + WAY_MS, self.sent), (PeerId(peer), parcel));
            }
        }
    }

    /// What a server with a fault would send a person: tiles of another pot, under the version that the person holds.
    fn spoil(&mut self, person: usize, tiles: &[u32], time: Duration) {
        let version = self.client(person).replica().version().0;
        // the time that it has heard of: clay as old as that speaks against nothing
        let (tick, acknowledged) = (self.client(person).tools_tick().0, 0);
        let bytes = wrong_tiles(tiles);
        let keyframe =
            Keyframe { version, since: 1, tick, acknowledged, sight: None, mended: 0, goes_on: false, bytes };
        assert!(version > 1 && self.client(person).handle_keyframe(&protocol::encode(&keyframe), time));
    }

    fn assert_same(&mut self) {
        let digest = self.room.digest(0).unwrap();
        let pot = self.room.pot(0).unwrap().digest();
        for person in 0..2 {
            let client = self.client(person);
            assert_eq!((client.replica().digest(), client.predicted().digest()), (digest, pot), "person {person}");
            assert!(client.is_settled(), "person {person}");
        }
    }
}

/// Two people opposite each other, as long as `until`.
fn hand(person: u64, now: u64, until: u64) -> Option<Vec3> {
    if !(400..until).contains(&now) {
        return None;
    }
    let time = (now - 400) as f32 * 1e-3;
    let angle = person as f32 * 3.0;
    let distance = 0.0705 - 0.002 * (time * 2.0).sin().max(0.0);
    let height = 0.06 + 0.03 * (time + person as f32).sin();
    Some(Vec3::new(distance * angle.cos(), distance * angle.sin(), height))
}

#[test]
fn tiles_that_went_wrong_come_alone_and_are_counted_on_both_sides() {
    for person in 0..2 {
        let mut world = World::new();
        for now in 0..3000 {
            world.step(now, |person, now| hand(person, now, 2600));
        }
        world.assert_same();
        let before = world.keyframes.len();
        world.spoil(person, &[5, 260, 400], Duration::from_millis(3000));
        for now in 3000..3800 {
            world.step(now, |_, _| None);
        }
        world.assert_same();
        let expected = MendCounts { asked: 1, whole: 0, tiles: 3 };
        assert_eq!((*world.client(person).mend_counts(), world.client(person).mismatches()), (expected, 1));
        let counts = world.room.counts();
        assert_eq!((counts.mends, counts.mended_tiles, counts.resyncs), (1, 3, 0));
        let [(to, keyframe)] = &world.keyframes[before..] else { panic!("more than one keyframe") };
        let (to, keyframe) = (*to, keyframe.clone());
        assert_eq!((to.0, keyframe.mended, keyframe.since), (person as u64, 3, keyframe.version));
        // the whole pot with what deltas build upon; who retells needs nothing of that
        let whole = whole_pot_bytes(&mut world);
        println!("person {person}: {} B for three tiles, {whole} B for the whole pot", keyframe.bytes.len());
        assert!(keyframe.bytes.len() * 4 < whole, "{} B", keyframe.bytes.len());
    }
}

/// Bytes of a keyframe from the untouched pot on.
fn whole_pot_bytes(world: &mut World) -> usize {
    let before = world.keyframes.len();
    let request = frame(&protocol::encode(&Request::Resync { have: 0 }));
    world.room.handle_control(PeerId(0), &request[2..]);
    world.step(3800, |_, _| None);
    world.keyframes[before].1.bytes.len()
}

#[test]
fn clay_that_goes_wrong_under_the_hands_comes_right_while_they_press() {
    for person in 0..2 {
        let mut world = World::new();
        for now in 0..4400 {
            if now == 1700 {
                // the tiles that both are at, and neighbours that they come to
                world.spoil(
                    person,
                    &(4..9).flat_map(|row| [row, 25 * 6 + row, 25 * 12 + row]).collect::<Vec<_>>(),
                    Duration::from_millis(now),
                );
            }
            // the first answer does not come through
            if now == 1690 {
                world.lost = 1;
            }
            world.step(now, |person, now| hand(person, now, 3900));
            if now == 3800 {
                let counts = *world.client(person).mend_counts();
                assert!(counts.tiles > 0, "person {person}: nothing is mended after two seconds, {counts:?}");
            }
        }
        world.assert_same();
        let counts = *world.client(person).mend_counts();
        println!("person {person}: {counts:?}, {:?}", world.room.counts());
        assert!((1..=4).contains(&counts.asked) && counts.whole <= 1, "person {person}: {counts:?}");
        assert_eq!(world.client(1 - person).mend_counts(), &MendCounts::default());
    }
}

#[test]
fn a_list_of_other_tiles_or_of_a_version_that_never_was_is_answered_with_the_whole_pot() {
    let mut world = World::new();
    for now in 0..1200 {
        world.step(now, |person, now| hand(person, now, 1000));
    }
    let latest = world.client(0).replica().version().0;
    let tiles = world.client(0).replica().tile_digests();
    let mends = [
        (latest, tiles[2..].to_vec()),
        (latest, [tiles.clone(), vec![1]].concat()),
        (latest, Vec::new()),
        (latest + 1, tiles.clone()),
        (u32::MAX, tiles.clone()),
        (0, tiles),
    ];
    for (have, tiles) in mends {
        let before = world.keyframes.len();
        let request = protocol::encode(&Request::Mend { have, tiles });
        world.room.handle_control(PeerId(0), &request);
        world.step(1200, |_, _| None);
        let [(_, keyframe)] = &world.keyframes[before..] else { panic!("no answer to {have}") };
        assert_eq!((keyframe.since, keyframe.mended), (0, 0), "{have}");
    }
    assert_eq!(world.room.counts().mended_tiles, 0);
}

/// Two answers that lead to the same clay fill a narrow line twice, and the next ones are asked for twice then.
#[test]
fn an_answer_on_its_way_answers_whoever_holds_more_by_then_as_well() {
    let mut world = World::new();
    for now in 0..1200 {
        world.step(now, |person, now| hand(person, now, 5000));
    }
    let first = world.client(1).replica().version().0;
    let answers = |world: &mut World, have: u32| {
        let before = world.keyframes.len();
        world.room.handle_control(PeerId(1), &protocol::encode(&Request::Resync { have }));
        while let Some(transmit) = world.room.poll_transmit() {
            if let Lane::Keyframe(bytes) = transmit.lane {
                world.keyframes.push((transmit.to, protocol::decode::<KEYFRAME_MAX, _>(&bytes).unwrap()));
            }
        }
        world.keyframes[before..].iter().map(|(_, keyframe)| keyframe.since).collect::<Vec<_>>()
    };
    assert_eq!(answers(&mut world, first - 10), [first - 10]);
    for have in [first - 10, first - 9, first] {
        assert_eq!(answers(&mut world, have), [0_u32; 0], "{have} leads there as well");
    }
    assert_eq!(answers(&mut world, first - 11), [first - 11], "what is older is not answered by it");
    for now in 1200..1300 {
        world.step(now, |person, now| hand(person, now, 5000));
    }
    let later = world.client(1).replica().version().0;
    assert!(later > first + 2, "{later} after {first}");
    assert_eq!(answers(&mut world, later), [later], "nor is what is newer");
    for now in 1300..1700 {
        world.step(now, |person, now| hand(person, now, 5000));
    }
    assert_eq!(answers(&mut world, later), [later], "it was lost, as it seems");
}
