//! The session file: what several people did at a wheel makes the same clay again, wherever one begins, and bytes that are no
//! session are refused with a sentence.
//!
//! Invariant under test: a file that is cut or bent anywhere never makes other clay than the room had.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::io::Cursor;
use std::time::Duration;

use glam::Vec3;
use pottery_server::recording::{Playback, Recording, RecordingError, RecordingWriter};
use pottery_shared::clay::{GridShape, Material, MethodKind, PotSpec, Preset, Support};
use pottery_shared::protocol::{FrameReader, Request};
use pottery_shared::room::{Entry, Happening, Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::Client;
use pottery_shared::snapshot::PotRecord;
use pottery_shared::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample, rack};
use pottery_shared::units::{Metres, Rpm, Tick};
use pottery_tests::dice::Dice;

fn config(method: MethodKind, columns: u32, rows: u32) -> RoomConfig {
    RoomConfig {
        code: "CLAY".into(),
        wheels: 2,
        people_max: 8,
        pot: PotSpec { shape: GridShape::new(columns, rows).unwrap(), support: Support::Hollow, ..PotSpec::default() },
        method,
        wheel_speed: Rpm(60.0),
        clay: Material::default(),
    }
}

/// A room that is recorded, and people whose datagrams are lost and overtake each other on the way up.
struct Studio {
    room: Room,
    writer: RecordingWriter<Vec<u8>>,
    people: BTreeMap<PeerId, Client>,
    /// Datagrams on their way, by the time of arrival.
    up: BTreeMap<(u64, u64), (PeerId, Vec<u8>)>,
    dice: Dice,
    sent: u64,
    now: u64,
    /// Of each tick, the digest of each wheel's clay as it stands.
    stood: Vec<[u64; 2]>,
    entries: Vec<Entry>,
}

impl Studio {
    fn open(mut room: Room) -> Self {
        room.keep_journal();
        Self {
            room,
            writer: RecordingWriter::begin(Vec::new(), 2).unwrap(),
            people: BTreeMap::new(),
            up: BTreeMap::new(),
            dice: Dice::new(11),
            sent: 0,
            now: 0,
            stood: Vec::new(),
            entries: Vec::new(),
        }
    }

    fn control(&mut self, peer: PeerId, framed: &[u8]) {
        let mut reader = FrameReader::default();
        reader.push(framed);
        self.room.handle_control(peer, &reader.next_frame().unwrap().unwrap());
    }

    fn join(&mut self, person: u64, wheel: u16) {
        let peer = PeerId(person);
        self.control(peer, &Client::greeting("CLAY", wheel, person.is_multiple_of(2)));
        self.deliver();
    }

    fn ask(&mut self, person: u64, request: &Request) {
        self.people.get_mut(&PeerId(person)).unwrap().request(request);
    }

    fn deliver(&mut self) {
        let time = Duration::from_millis(self.now);
        while let Some(transmit) = self.room.poll_transmit() {
            match (transmit.lane, self.people.get_mut(&transmit.to)) {
                (Lane::Control(framed), client) => {
                    let mut reader = FrameReader::default();
                    reader.push(&framed);
                    let frame = reader.next_frame().unwrap().unwrap();
                    match client {
                        Some(client) => client.handle_control(&frame).unwrap(),
                        None => {
                            let client = Client::open(&frame, self.now, Duration::from_millis(60)).unwrap();
                            self.people.insert(transmit.to, client);
                        }
                    }
                }
                (Lane::Datagram(bytes), Some(client)) => assert!(client.handle_datagram(&bytes, time)),
                (Lane::Keyframe(bytes), Some(client)) => assert!(client.handle_keyframe(&bytes, time)),
                (Lane::Close | Lane::Datagram(_) | Lane::Keyframe(_), _) => {}
            }
        }
    }

    fn step(&mut self, held: impl Fn(u64, u64) -> Option<(Tool, Vec3)>) {
        let time = Duration::from_millis(self.now);
        self.room.advance(Tick(self.now));
        self.deliver();
        while let Some(entry) = self.up.first_entry().filter(|entry| entry.key().0 <= self.now) {
            let (peer, bytes) = entry.remove();
            self.room.handle_datagram(peer, &bytes);
        }
        let peers: Vec<_> = self.people.keys().copied().collect();
        for peer in peers {
            let client = self.people.get_mut(&peer).unwrap();
            let tick = Tick(0).offset(self.now as i64 + client.tick_offset());
            if let Some((tool, place)) = held(peer.0, self.now) {
                let orientation = match tool {
                    Tool::Sphere(_) => Orientation::default(),
                    Tool::Convex(_) => Orientation::nearest([0.3, 0.1, self.now as f32 * 2e-3]).unwrap(),
                };
                let (centre, side) = (Position::nearest(place).unwrap(), Side::Outside);
                client.handle_sample(ToolSample { tick, tool, orientation, centre, side });
            }
            client.rebase();
            let frames: Vec<_> = std::iter::from_fn(|| client.poll_control()).collect();
            let datagrams: Vec<_> = std::iter::from_fn(|| client.poll_datagram(time)).collect();
            for framed in frames {
                self.control(peer, &framed);
            }
            for bytes in datagrams.into_iter().filter(|_| self.now % 8 == peer.0) {
                if !self.dice.chance(0.1) {
                    self.sent += 1;
                    let late = 20 + self.dice.roll() % 40;
                    self.up.insert((self.now + late, self.sent), (peer, bytes));
                }
            }
        }
        self.stood.push([0, 1].map(|wheel| self.room.pot(wheel).unwrap().digest()));
        self.entries.extend(std::iter::from_fn(|| self.room.poll_journal()));
        self.now += 1;
        if self.now.is_multiple_of(500) {
            self.writer.write(&std::mem::take(&mut self.entries)).unwrap();
        }
    }

    fn close(mut self) -> (Vec<u8>, Vec<[u64; 2]>, Room) {
        self.room.close();
        self.entries.extend(std::iter::from_fn(|| self.room.poll_journal()));
        self.writer.write(&self.entries).unwrap();
        (self.writer.finish(self.room.now()).unwrap(), self.stood, self.room)
    }
}

/// Three people round the pot, each with tools of their own, and a fourth at the other wheel.
fn held(person: u64, now: u64) -> Option<(Tool, Vec3)> {
    if now < 200 || now % 1500 > 1300 {
        return None;
    }
    let time = now as f32 * 1e-3;
    let angle = person as f32 * 1.7;
    let distance = 0.071 - 0.004 * (time * 3.0 + person as f32).sin().max(0.0);
    let place = Vec3::new(distance * angle.cos(), distance * angle.sin(), 0.1 + 0.03 * (time + person as f32).sin());
    let sphere = Sphere::new(Metres::from_mm(10.0 + (now / 1500 % 20) as f32)).unwrap();
    let tool = match (person, now / 1500) {
        (1, 1) => Tool::Convex(Shape::RIB),
        (2, 2) => Tool::Convex(Shape(Shape::NAMED.len() as u8)),
        _ => sphere.into(),
    };
    Some((tool, place))
}

/// A session of several people: tools of all kinds, one brought, settings changed and taken back, somebody who leaves and
/// comes again.
fn session(mut room: Room, ticks: u64) -> (Vec<u8>, Vec<[u64; 2]>, Room) {
    room.advance(Tick(0));
    let mut studio = Studio::open(room);
    for now in 0..ticks {
        match now {
            5 => (0..3).for_each(|person| studio.join(person, 1)),
            40 => studio.join(3, 2),
            400 => studio
                .people
                .get_mut(&PeerId(2))
                .unwrap()
                .bring(&rack::ball(1, Metres::from_mm(11.0)).unwrap())
                .unwrap(),
            700 => studio.ask(0, &Request::WheelSpeed { rpm: 140.0 }),
            // taken back before it holds
            760 => studio.ask(1, &Request::WheelSpeed { rpm: 60.0 }),
            1100 => studio.ask(0, &Request::Clay { clay: Material::from_wetness(Preset::Slip.wetness()).into() }),
            1600 => studio.ask(1, &Request::Clay { clay: Material::default().into() }),
            1900 => studio.ask(3, &Request::WheelSpeed { rpm: -33.0 }),
            2100 => {
                studio.room.handle_gone(PeerId(0));
                studio.people.remove(&PeerId(0));
            }
            2600 => studio.join(8, 1),
            _ => {}
        }
        studio.step(held);
    }
    studio.close()
}

fn played(bytes: &[u8], wheel: u16) -> Playback<Cursor<&[u8]>> {
    Playback::begin(Recording::open(Cursor::new(bytes)).unwrap(), wheel).unwrap()
}

#[test]
fn session_replays_to_the_same_clay_at_every_tick_with_every_method() {
    for method in [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic] {
        let (bytes, stood, room) = session(Room::new(config(method, 90, 100)).unwrap(), 3600);
        let recording = Recording::open(Cursor::new(&bytes)).unwrap();
        assert!(recording.is_whole() && recording.wheels() == 2);
        for wheel in 0..2 {
            let mut playback = played(&bytes, wheel);
            for (tick, digests) in (0..).zip(&stood) {
                playback.advance(Tick(tick)).unwrap();
                assert_eq!(playback.replay().pot().digest(), digests[usize::from(wheel)], "{method:?}, tick {tick}");
            }
            let (replay, at) = (playback.replay(), usize::from(wheel));
            let comparison = replay.comparison();
            assert!(comparison.snapshots > 100 && comparison.first_unlike.is_none(), "{method:?}: {comparison:?}");
            assert_eq!(Some(replay.digest()), room.digest(at));
            assert_eq!(replay.pot(), room.pot(at).unwrap());
            assert_ne!(stood[0][at], stood[3599][at], "nothing was pressed at wheel {wheel}");
        }
        println!("{method:?}: {} bytes for 3.6 s of four people", bytes.len());
    }
}

/// Goes to so many ticks of a session, each clay's as it was then, and from one end to the other.
fn seek(support: Support, ticks: u64, seeks: u32) {
    let config = config(MethodKind::Plastic, 48, 40);
    let config = RoomConfig { pot: PotSpec { support, ..config.pot }, ..config };
    let (bytes, stood, _) = session(Room::new(config).unwrap(), ticks);
    let mut dice = Dice::new(3);
    let mut playback = played(&bytes, 0);
    for _ in 0..seeks {
        let at = dice.roll() % ticks;
        playback.seek(Tick(at)).unwrap();
        assert_eq!(playback.replay().pot().digest(), stood[at as usize][0], "tick {at}");
        assert_eq!(playback.replay().comparison().first_unlike, None);
        assert_eq!(playback.tick(), Tick(at));
    }
    playback.seek(Tick(0)).unwrap();
    assert_eq!(playback.replay().pot().digest(), stood[0][0]);
    playback.seek(Tick(1 << 40)).unwrap();
    assert_eq!(playback.replay().pot().digest(), stood.last().unwrap()[0]);
}

#[test]
fn seeking_is_playing_through() {
    // there is a state every half minute: forwards over some, and backwards
    seek(Support::Backed, 40_000, 24);
}

#[test]
fn seeking_in_a_hollow_pot_is_playing_through() {
    // shorter, since tools that are deep in a wall of few elements take a hundred times as long
    seek(Support::Hollow, 3600, 4);
}

#[test]
fn a_wall_that_has_folded_is_told_anew_with_its_folds() {
    let mut studio = Studio::open(Room::new(config(MethodKind::Plastic, 48, 40)).unwrap());
    let (ball, place) = (Sphere::new(Metres::from_mm(12.0)).unwrap(), Vec3::new(0.066, 0.0, 0.1));
    // half a minute after the first state there is another
    for now in 0..31_000 {
        if now == 5 {
            studio.join(0, 1);
        }
        studio.step(|_, now| (200..1000).contains(&(now % 10_000)).then_some((ball.into(), place)));
    }
    let (bytes, stood, room) = studio.close();
    assert!(room.pot(0).unwrap().folded_m(0.0, 0.1) > 1e-4, "{} m", room.pot(0).unwrap().folded_m(0.0, 0.1));
    let mut playback = played(&bytes, 0);
    playback.advance(room.now()).unwrap();
    assert_eq!(playback.replay().comparison().first_unlike, None);
    for at in [30_990, 500, 30_500] {
        playback.seek(Tick(at)).unwrap();
        assert_eq!(playback.replay().pot().digest(), stood[at as usize][0], "tick {at}");
    }
}

#[test]
fn nobody_is_at_a_wheel_once_the_studio_was_closed() {
    let (bytes, stood, room) = session(Room::new(config(MethodKind::Plastic, 48, 40)).unwrap(), 3600);
    for (wheel, people) in [(0, 3), (1, 1)] {
        let mut playback = played(&bytes, wheel);
        playback.advance(Tick(stood.len() as u64 - 1)).unwrap();
        assert_eq!(playback.replay().people().count(), people, "wheel {wheel}");
        playback.advance(room.now()).unwrap();
        assert_eq!(playback.replay().people().count(), 0, "wheel {wheel}");
    }
}

#[test]
fn journal_that_nobody_asks_for_any_more_keeps_nothing() {
    let mut studio = Studio::open(Room::new(config(MethodKind::Plastic, 48, 40)).unwrap());
    studio.join(1, 1);
    (0..400).for_each(|_| studio.step(held));
    assert!(!studio.entries.is_empty());
    studio.entries.clear();
    studio.room.end_journal();
    (0..600).for_each(|_| studio.step(held));
    assert_ne!(studio.stood[999], studio.stood[399], "nothing was pressed after it");
    assert!(studio.entries.is_empty());
}

#[test]
fn session_that_goes_on_with_a_pot_begins_with_it() {
    let (_, _, room) = session(Room::new(config(MethodKind::Plastic, 48, 40)).unwrap(), 1200);
    let record = PotRecord::of(room.pot(0).unwrap());
    let room = Room::starting_from(config(MethodKind::Plastic, 48, 40), &record).unwrap();
    let (bytes, stood, _) = session(room, 1500);
    let mut playback = played(&bytes, 0);
    assert_eq!(PotRecord::of(playback.replay().pot()), record);
    playback.advance(Tick(1499)).unwrap();
    assert_eq!(playback.replay().pot().digest(), stood[1499][0]);
}

#[test]
fn session_of_the_largest_hollow_pot_can_be_read() {
    let mut room = Room::new(config(MethodKind::Plastic, 2048, 2048)).unwrap();
    room.keep_journal();
    let first: Vec<_> = std::iter::from_fn(|| room.poll_journal()).filter(|entry| entry.wheel == 0).collect();
    assert!(matches!(&first[..], [Entry { what: Happening::State(_), .. }]), "{} entries", first.len());
    let mut writer = RecordingWriter::begin(Vec::new(), 1).unwrap();
    writer.write(&first).unwrap();
    let bytes = writer.finish(room.now()).unwrap();
    assert_eq!(played(&bytes, 0).replay().pot(), room.pot(0).unwrap());
}

#[test]
fn who_was_killed_leaves_what_was_written() {
    let (bytes, stood, _) = session(Room::new(config(MethodKind::Plastic, 24, 20)).unwrap(), 2500);
    let whole = played(&bytes, 0).recording().span(0).unwrap();
    let mut reached = Tick(0);
    let mut lengths: Vec<usize> = (0..bytes.len()).step_by(37).collect();
    lengths.extend(bytes.len() - 60..bytes.len());
    for length in lengths {
        let cut = &bytes[..length];
        let recording = match Recording::open(Cursor::new(cut)) {
            Ok(recording) => recording,
            // within the head of the file
            Err(error) => {
                assert!(matches!(error, RecordingError::NotASession) && length < 36, "{length}: {error}");
                continue;
            }
        };
        assert!(!recording.is_whole(), "{length}");
        let mut playback = match Playback::begin(recording, 0) {
            Ok(playback) => playback,
            Err(error) => {
                assert!(matches!(error, RecordingError::Empty { wheel: 1 }), "{length}: {error}");
                assert_eq!(reached, Tick(0));
                continue;
            }
        };
        let (_, last) = playback.recording().span(0).unwrap();
        assert!(last >= reached && last <= whole.1);
        reached = last;
        playback.advance(last).unwrap();
        // it was closed after the last tick, and nobody presses who leaves
        let newest = (last.0 as usize).min(stood.len() - 1);
        assert_eq!(playback.replay().pot().digest(), stood[newest][0], "{length} bytes");
        assert_eq!(playback.replay().comparison().first_unlike, None);
    }
    // half a second is written at once
    assert!(reached >= Tick(2490), "{reached}");
}

#[test]
fn no_bent_byte_makes_other_clay() {
    let (bytes, _, _) = session(Room::new(config(MethodKind::Plastic, 24, 20)).unwrap(), 1200);
    for at in 0..bytes.len() {
        for bit in [0, 3, 7] {
            let mut bent = bytes.clone();
            bent[at] ^= 1 << bit;
            let error = Recording::open(Cursor::new(&bent)).map(drop).unwrap_err();
            let text = error.to_string();
            assert!((10..200).contains(&text.len()) && !text.contains(['\n', '{']), "{text}");
        }
    }
    let longer = [bytes.as_slice(), b"x"].concat();
    assert!(matches!(
        Recording::open(Cursor::new(&longer)).unwrap_err(),
        RecordingError::Meaningless { what: "rest", .. }
    ));
}

#[test]
fn files_of_others_are_refused_with_the_reason() {
    let (bytes, _, _) = session(Room::new(config(MethodKind::Plastic, 24, 20)).unwrap(), 300);
    let open = |bytes: &[u8]| Recording::open(Cursor::new(bytes)).map(drop).unwrap_err();
    assert!(matches!(open(b""), RecordingError::NotASession));
    assert!(matches!(open(b"\x89POT\r\n\x1a\n and more of the kind"), RecordingError::NotASession));
    let mut later = bytes.clone();
    later[8] = 7;
    assert!(matches!(open(&later), RecordingError::FromTheFuture { version: 7, newest: 3 }));
    let nowhere = Playback::begin(Recording::open(Cursor::new(&bytes)).unwrap(), 2).map(drop).unwrap_err();
    assert!(matches!(nowhere, RecordingError::Wheel { wheel: 3, wheels: 2 }));
    // a block that was taken out whole
    let first = 36 + 40 + u32::from_le_bytes(bytes[44..48].try_into().unwrap()) as usize;
    let without = [&bytes[..36], &bytes[first..]].concat();
    assert!(matches!(open(&without), RecordingError::Meaningless { what: "number", .. }));
}

#[test]
fn other_clay_is_found_at_the_first_snapshot() {
    // on a core, where a millisecond leaves its mark
    let mut config = config(MethodKind::Plastic, 48, 40);
    config.pot.support = Support::Backed;
    let mut studio = Studio::open(Room::new(config).unwrap());
    studio.join(0, 1);
    studio.join(1, 1);
    // short of what is written at once
    for _ in 0..499 {
        studio.step(held);
    }
    let mut entries = studio.entries;
    // a hand that was 3 mm deeper, once
    let at = entries.iter().position(|entry| entry.tick > Tick(300) && matches!(entry.what, Happening::Pressed(_)));
    assert!(at.is_some(), "{} entries", entries.len());
    let Happening::Pressed(pressed) = &mut entries[at.unwrap()].what else { panic!() };
    pressed.iter_mut().for_each(|(_, sample)| sample.centre.0[0] -= 300 * sample.centre.0[0].signum());
    let bent_at = entries[at.unwrap()].tick;
    let mut writer = RecordingWriter::begin(Vec::new(), 2).unwrap();
    writer.write(&entries).unwrap();
    let bytes = writer.finish(Tick(499)).unwrap();
    let mut playback = played(&bytes, 0);
    playback.advance(Tick(499)).unwrap();
    let unlike = playback.replay().comparison().first_unlike.unwrap();
    assert!(unlike >= bent_at && unlike.since(bent_at) <= 17, "bent at {bent_at}, found at {unlike}");
}

#[test]
fn file_of_version_1_is_read_for_good() {
    let bytes = include_bytes!("../../data/sessions/version-1.session");
    let recording = Recording::open(Cursor::new(&bytes[..])).unwrap();
    assert!(recording.is_whole() && recording.wheels() == 2 && recording.writer() == "pottery-0.1.0");
    let (first, last) = recording.span(0).unwrap();
    let mut playback = Playback::begin(recording, 0).unwrap();
    let mut places = Vec::new();
    for tick in first.0..=last.0 {
        playback.advance(Tick(tick)).unwrap();
        places.extend(
            playback.replay().people().filter_map(|(client, sample)| Some((client, sample?.centre, sample?.tool))),
        );
    }
    // one hand that was held still; what clay comes of it is the affair of the studio that presses it
    let fingertip = Tool::Sphere(Sphere::new(Metres::from_mm(12.0)).unwrap());
    assert!(places.len() > 1000 && places.iter().all(|place| *place == (1, Position([6900, 0, 4000]), fingertip)));
    assert_eq!(playback.replay().comparison().snapshots, 111);
    assert_eq!(playback.replay().people().count(), 0, "it left");
}
