//! Undo and redo of one's own strokes at a wheel at which others work.
//!
//! Several people, over virtual time and a wire that loses; what the room tells of itself is pressed again by the test, without the
//! strokes that are undone.
//! Invariant under test: the clay is what it would be if nobody had pressed what is undone, and everybody holds it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

mod bounds;

use std::collections::{BTreeMap, BTreeSet};
use std::io::Cursor;
use std::time::Duration;

use glam::Vec3;
use pottery_server::recording::{Playback, Recording, RecordingWriter};
use pottery_shared::clay::{Form, GridShape, Material, MethodKind, PotSpec};
use pottery_shared::protocol::{FrameReader, NoStep, POT_PIECE, Request};
use pottery_shared::room::{Entry, Happening, Lane, PeerId, Replay, Room, RoomConfig};
use pottery_shared::session::{Client, ClientEvent, PutError, Watcher, fitted};
use pottery_shared::snapshot::{Detail, PotRecord};
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample};
use pottery_shared::units::{Metres, Rpm, Tick};
use pottery_tests::dice::Dice;

/// Ticks off the clay after which the next touch is another stroke.
const GAP: i64 = 200;
/// Samples pressed again in a tick while nobody presses beside.
const AGAIN_A_TICK: u64 = 8;

/// What is on its way.
enum Parcel {
    Up(Vec<u8>),
    Asked(Vec<u8>),
    Down(Vec<u8>),
    Told(Vec<u8>),
    Keyframe(Vec<u8>),
}

/// Somebody at the wheel or one who looks on.
enum Person {
    Coming,
    Potter(Box<Client>),
    Looker(Box<Watcher>),
}

struct World {
    room: Room,
    people: BTreeMap<PeerId, Person>,
    parcels: BTreeMap<(u64, u64), (PeerId, Parcel)>,
    sent: u64,
    dice: Dice,
    loss: f64,
    now: u64,
    entries: Vec<Entry>,
    answers: Vec<(PeerId, NoStep)>,
    /// Most samples pressed again in one tick.
    again_max: u64,
    keyframes: u64,
}

fn bare(framed: &[u8]) -> Vec<u8> {
    let mut reader = FrameReader::default();
    reader.push(framed);
    reader.next_frame().unwrap().unwrap()
}

impl World {
    fn new(method: MethodKind, (columns, rows): (u32, u32), loss: f64, seed: u64) -> Self {
        let shape = GridShape::new(columns, rows).unwrap();
        Self::of(PotSpec { shape, ..PotSpec::default() }, method, loss, seed)
    }

    fn of(pot: PotSpec, method: MethodKind, loss: f64, seed: u64) -> Self {
        let mut room = Room::new(RoomConfig {
            code: "CLAY".into(),
            wheels: 1,
            people_max: 16,
            pot,
            method,
            wheel_speed: Rpm(60.0),
            clay: Material::default(),
        })
        .unwrap();
        room.keep_journal();
        Self {
            room,
            people: BTreeMap::new(),
            parcels: BTreeMap::new(),
            sent: 0,
            dice: Dice::new(seed),
            loss,
            now: 0,
            entries: Vec::new(),
            answers: Vec::new(),
            again_max: 0,
            keyframes: 0,
        }
    }

    fn post(&mut self, peer: PeerId, parcel: Parcel) {
        let is_datagram = matches!(parcel, Parcel::Up(_) | Parcel::Down(_));
        if is_datagram && self.dice.chance(self.loss) {
            return;
        }
        let jitter_ms = if is_datagram && self.loss > 0.0 { self.dice.roll() % 20 } else { 0 };
        self.sent += 1;
        self.parcels.insert((self.now + 15 + jitter_ms, self.sent), (peer, parcel));
    }

    /// Every second potter takes the tiles that changed, the others press again what was pressed.
    fn come(&mut self, person: u64) -> PeerId {
        let peer = PeerId(person);
        self.people.insert(peer, Person::Coming);
        self.post(peer, Parcel::Asked(Client::greeting("CLAY", 1, person.is_multiple_of(2))));
        peer
    }

    fn look_on(&mut self, person: u64) -> PeerId {
        let peer = PeerId(person);
        self.people.insert(peer, Person::Coming);
        self.post(peer, Parcel::Asked(Watcher::greeting("CLAY", 10_000_000)));
        peer
    }

    fn potter(&mut self, person: u64) -> &mut Client {
        let Some(Person::Potter(client)) = self.people.get_mut(&PeerId(person)) else {
            panic!("{person} is no potter")
        };
        client
    }

    fn potters(&self) -> impl Iterator<Item = (&PeerId, &Client)> {
        self.people.iter().filter_map(|(peer, person)| match person {
            Person::Potter(client) => Some((peer, &**client)),
            _ => None,
        })
    }

    fn step(&mut self, hand: impl Fn(u64, u64) -> Option<Vec3>) {
        let before = self.room.counts().remade;
        self.room.advance(Tick(self.now));
        self.again_max = self.again_max.max(self.room.counts().remade - before);
        self.entries.extend(std::iter::from_fn(|| self.room.poll_journal()));
        while let Some(transmit) = self.room.poll_transmit() {
            let parcel = match transmit.lane {
                Lane::Datagram(bytes) => Parcel::Down(bytes.into()),
                Lane::Control(framed) => Parcel::Told(bare(&framed)),
                Lane::Keyframe(bytes) => Parcel::Keyframe(bytes),
                Lane::Close => continue,
            };
            self.keyframes += u64::from(matches!(parcel, Parcel::Keyframe(_)));
            self.post(transmit.to, parcel);
        }
        while let Some(entry) = self.parcels.first_entry().filter(|entry| entry.key().0 <= self.now) {
            let (peer, parcel) = entry.remove();
            self.deliver(peer, parcel);
        }
        let time = Duration::from_millis(self.now);
        let mut outgoing = Vec::new();
        for (&peer, person) in &mut self.people {
            let mut frames = Vec::new();
            match person {
                Person::Coming => {}
                Person::Potter(client) => {
                    let tick = Tick(0).offset(self.now as i64 + client.tick_offset());
                    if let Some(point) = hand(peer.0, self.now) {
                        let centre = Position::nearest(point).unwrap();
                        let (tool, orientation) = (Tool::default(), Orientation::default());
                        client.handle_sample(ToolSample { tick, tool, orientation, centre, side: Side::Outside });
                    }
                    client.rebase();
                    while let Some(event) = client.poll_event() {
                        if let ClientEvent::NoStep(reason) = event {
                            self.answers.push((peer, reason));
                        }
                    }
                    frames.extend(std::iter::from_fn(|| client.poll_control()));
                    if self.now % 10 == peer.0 % 10 {
                        outgoing
                            .extend(std::iter::from_fn(|| client.poll_datagram(time)).map(|up| (peer, Parcel::Up(up))));
                    }
                }
                Person::Looker(watcher) => {
                    watcher.handle_time(time);
                    frames.extend(std::iter::from_fn(|| watcher.poll_control()));
                }
            }
            outgoing.extend(frames.into_iter().map(|frame| (peer, Parcel::Asked(frame))));
        }
        for (peer, parcel) in outgoing {
            self.post(peer, parcel);
        }
        self.now += 1;
    }

    fn deliver(&mut self, peer: PeerId, parcel: Parcel) {
        let time = Duration::from_millis(self.now);
        let person = self.people.get_mut(&peer).unwrap();
        match (parcel, &mut *person) {
            (Parcel::Up(bytes), _) => self.room.handle_datagram(peer, &bytes),
            (Parcel::Asked(framed), _) => self.room.handle_control(peer, &bare(&framed)),
            (Parcel::Told(frame), Person::Coming) => {
                let round_trip = Duration::from_millis(50);
                *person = match Client::open(&frame, self.now, round_trip) {
                    Ok(client) => Person::Potter(Box::new(client)),
                    Err(_) => Person::Looker(Box::new(Watcher::open(&frame, round_trip).unwrap())),
                };
            }
            (Parcel::Told(frame), Person::Potter(client)) => client.handle_control(&frame).unwrap(),
            (Parcel::Told(frame), Person::Looker(watcher)) => watcher.handle_control(&frame).unwrap(),
            (Parcel::Down(bytes), Person::Potter(client)) => assert!(client.handle_datagram(&bytes, time)),
            (Parcel::Down(bytes), Person::Looker(watcher)) => assert!(watcher.handle_datagram(&bytes, time)),
            (Parcel::Keyframe(bytes), Person::Potter(client)) => assert!(client.handle_keyframe(&bytes, time)),
            (Parcel::Keyframe(bytes), Person::Looker(watcher)) => assert!(watcher.handle_keyframe(&bytes, time)),
            (Parcel::Down(_) | Parcel::Keyframe(_), Person::Coming) => {}
        }
    }

    fn run(&mut self, to: u64, hand: impl Fn(u64, u64) -> Option<Vec3>) {
        while self.now < to {
            self.step(&hand);
        }
    }

    fn digest(&self) -> u64 {
        self.room.digest(0).unwrap()
    }

    fn assert_settled(&self, case: &str) {
        for (peer, client) in self.potters() {
            assert!(client.is_settled(), "{case}: {peer:?} holds {:?}", client.replica().version());
            assert!(!client.steps().is_remaking, "{case}: {peer:?} waits");
            assert_eq!(client.replica().digest(), self.digest(), "{case}: {peer:?}");
            assert_eq!(client.predicted().digest(), self.room.pot(0).unwrap().digest(), "{case}: {peer:?}");
            assert_eq!((client.mismatches(), client.step_counts().unlike), (0, 0), "{case}: {peer:?}");
        }
    }

    /// Plays what was told from a session file: every digest is what it was.
    fn assert_recorded(&self) {
        let mut writer = RecordingWriter::begin(Vec::new(), 1).unwrap();
        writer.write(&self.entries).unwrap();
        let bytes = writer.finish(self.room.now()).unwrap();
        let recording = Recording::open(Cursor::new(&bytes)).unwrap();
        let mut playback = Playback::begin(recording, 0).unwrap();
        playback.advance(Tick(self.now)).unwrap();
        let comparison = playback.replay().comparison();
        assert!(comparison.snapshots > 50 && comparison.first_unlike.is_none(), "{comparison:?}");
        assert_eq!(playback.replay().pot(), self.room.pot(0).unwrap());
        let replaced = self.entries.iter().filter(|entry| matches!(entry.what, Happening::Replaced(_))).count();
        println!("{} entries, {replaced} times replaced, in {} bytes", self.entries.len(), bytes.len());
    }

    /// What a wheel holds on which all happened that was told, but for the samples that are left out.
    fn digest_without(&self, is_left_out: impl Fn(u16, Tick) -> bool) -> u64 {
        let mut entries = self.entries.iter();
        let Some(Entry { tick, what: Happening::State(state), .. }) = entries.next() else { panic!("no state") };
        let mut replay = Replay::starting_from(*tick, state).unwrap();
        for entry in entries {
            let what = match &entry.what {
                Happening::Replaced(_) | Happening::State(_) => continue,
                Happening::Pressed(pressed) => {
                    let kept = pressed.iter().filter(|(client, sample)| !is_left_out(*client, sample.tick));
                    Happening::Pressed(kept.copied().collect())
                }
                other => other.clone(),
            };
            replay.take(entry.tick, &what).unwrap();
        }
        replay.digest()
    }

    /// The ticks of everybody's strokes as they were pressed: the client, and first and last tick.
    fn strokes(&self, cuts: &BTreeSet<(u16, Tick)>) -> BTreeMap<u16, Vec<(Tick, Tick)>> {
        let mut strokes: BTreeMap<u16, Vec<(Tick, Tick)>> = BTreeMap::new();
        for entry in &self.entries {
            let Happening::Pressed(pressed) = &entry.what else { continue };
            for (client, sample) in pressed {
                let of = strokes.entry(*client).or_default();
                match of.last_mut().filter(|(_, last)| {
                    let is_cut = cuts.range((*client, *last)..(*client, sample.tick)).next().is_some();
                    sample.tick.since(*last) <= GAP && !is_cut
                }) {
                    Some((_, last)) => *last = sample.tick,
                    None => of.push((sample.tick, sample.tick)),
                }
            }
        }
        strokes
    }
}

/// Each person in a band of their own, whose flanks overlap; every stroke deeper than all before it, so that it meets clay
/// whichever of them are undone.
fn band(person: u64, now: u64, stroke: u64) -> Vec3 {
    let time = now as f32 * 1e-3;
    let distance = 0.0708 - 0.0004 * stroke as f32;
    let angle = person as f32 * 2.1 + 0.2 * time.sin();
    Vec3::new(distance * angle.cos(), distance * angle.sin(), 0.07 + 0.014 * person as f32)
}

/// Strokes of six tenths of a second, a second apart, each person's a little later.
fn in_turns(person: u64, now: u64) -> Option<Vec3> {
    let at = now.checked_sub(300 + 130 * person)?;
    (at % 1000 < 600 && at < 4000).then(|| band(person, now, at / 1000))
}

#[test]
fn an_undone_stroke_leaves_the_clay_that_there_would_be_without_it() {
    for (method, loss, seed) in
        [(MethodKind::Plastic, 0.0, 1), (MethodKind::Plastic, 0.08, 2), (MethodKind::Improved, 0.08, 3)]
    {
        let mut world = World::new(method, (120, 100), loss, seed);
        for person in 0..3 {
            world.come(person);
        }
        world.run(5500, in_turns);
        world.assert_settled("pressed");
        let all = world.digest();
        assert_eq!(world.digest_without(|_, _| false), all);
        // the first potter's third stroke, under what the others pressed beside it
        world.potter(0).undo();
        world.run(5600, in_turns);
        world.potter(0).undo();
        world.run(8500, in_turns);
        world.assert_settled("undone");
        let number = world.potter(0).number();
        let strokes = &world.strokes(&BTreeSet::new())[&number];
        assert_eq!(strokes.len(), 4, "{strokes:?}");
        let (from, to) = (strokes[2].0, strokes[3].1);
        let without = world.digest_without(|client, tick| client == number && (from..=to).contains(&tick));
        assert_eq!(world.digest(), without, "{method:?}, seed {seed}");
        assert_ne!(all, without);
        assert_eq!((world.potter(0).steps().back, world.potter(0).steps().forth), (2, 2));
        // and back again
        world.potter(0).redo();
        world.potter(0).redo();
        world.run(11_500, in_turns);
        world.assert_settled("redone");
        assert_eq!(world.digest(), all, "{method:?}, seed {seed}");
        assert!(world.again_max <= AGAIN_A_TICK + 3, "{} samples in one tick", world.again_max);
        assert!(world.answers.is_empty());
        world.assert_recorded();
    }
}

/// What somebody has done, as they themselves know it.
#[derive(Default)]
struct Memory {
    /// Strokes by their number, that are not undone and that can be redone.
    done: Vec<usize>,
    undone: Vec<usize>,
    /// Every one that was ever left out for good.
    dropped: BTreeSet<usize>,
    strokes: usize,
}

#[test]
fn random_steps_of_random_people_leave_the_strokes_that_are_not_undone() {
    for seed in 0..6 {
        let mut world = World::new(MethodKind::Plastic, (96, 80), if seed % 2 == 0 { 0.0 } else { 0.05 }, seed);
        for person in 0..3 {
            world.come(person);
        }
        let mut dice = Dice::new(seed + 100);
        let mut memories: [Memory; 3] = Default::default();
        // until when each works or rests, and whether it works
        let mut turns = [(300_u64, false); 3];
        while world.now < 7000 {
            let now = world.now;
            for person in 0..3 {
                let (until, works) = &mut turns[person];
                let memory = &mut memories[person];
                if now == *until {
                    *works = !*works && now < 6000;
                    *until = now + if *works { 100 + dice.roll() % 500 } else { 260 + dice.roll() % 500 };
                    if *works {
                        memory.done.push(memory.strokes);
                        memory.strokes += 1;
                        let dropped = std::mem::take(&mut memory.undone);
                        memory.dropped.extend(dropped);
                    }
                } else if now > 600 && !*works && *until > now + 130 && now < 6500 && dice.chance(0.004) {
                    let client = world.potter(person as u64);
                    if dice.chance(0.6) {
                        client.undo();
                        memory.undone.extend(memory.done.pop());
                    } else {
                        client.redo();
                        memory.done.extend(memory.undone.pop());
                    }
                }
            }
            let strokes = [0, 1, 2].map(|person: usize| memories[person].strokes as u64);
            world.step(|person, now| {
                let (_, works) = turns[person as usize];
                works.then(|| band(person, now, strokes[person as usize]))
            });
        }
        world.run(10_000, |_, _| None);
        world.assert_settled(&format!("seed {seed}"));
        let strokes = world.strokes(&BTreeSet::new());
        let mut left_out = BTreeSet::new();
        let mut steps = 0;
        for (person, memory) in (0..).zip(&memories) {
            let number = world.potter(person).number();
            assert_eq!(strokes[&number].len(), memory.strokes, "seed {seed}: {person}");
            for &stroke in memory.undone.iter().chain(&memory.dropped) {
                left_out.insert((number, strokes[&number][stroke]));
                steps += 1;
            }
            let told = *world.potter(person).steps();
            let known = (memory.done.len(), memory.undone.len());
            assert_eq!((usize::from(told.back), usize::from(told.forth)), known, "seed {seed}: {person}");
        }
        let without = world.digest_without(|client, tick| {
            left_out.iter().any(|&(of, (from, to))| of == client && (from..=to).contains(&tick))
        });
        assert_eq!(world.digest(), without, "seed {seed}");
        assert!(steps >= 2, "seed {seed}: only {steps} strokes are undone");
    }
}

#[test]
fn clay_made_again_catches_up_with_those_who_go_on_pressing() {
    let mut world = World::new(MethodKind::Plastic, (120, 100), 0.03, 12);
    for person in 0..3 {
        world.come(person);
    }
    // the first makes one stroke; the others press all the time, each time round a little deeper
    let hand = |person: u64, now: u64| {
        let works = if person == 0 { (300..900).contains(&now) } else { (300..10_000).contains(&now) };
        works.then(|| band(person, now, now / 2000))
    };
    world.run(6500, hand);
    world.potter(0).undo();
    // on its way, and at the next snapshot
    world.run(6600, hand);
    assert!(world.potter(1).steps().is_remaking, "the others are told as well");
    let pressed_by_then = 2 * 6600_u64.saturating_sub(300);
    let mut ticks = 0;
    while world.potter(1).steps().is_remaking {
        world.step(hand);
        ticks += 1;
        assert!(ticks < 4000, "it never catches up");
    }
    // eight a tick more than is pressed meanwhile
    assert!(ticks <= pressed_by_then / AGAIN_A_TICK + 200, "{ticks} ticks for {pressed_by_then} samples");
    assert!(world.again_max <= AGAIN_A_TICK + 2 * 8 + 3, "{} samples in one tick", world.again_max);
    println!("{pressed_by_then} samples of two hands made again in {ticks} ticks, at most {} in one", world.again_max);
    world.run(12_000, hand);
    world.assert_settled("caught up");
    let number = world.potter(0).number();
    assert_eq!(world.digest(), world.digest_without(|client, _| client == number));
}

#[test]
fn a_stroke_is_undone_up_to_where_the_tool_was_when_it_was_asked_for() {
    let mut world = World::new(MethodKind::Plastic, (120, 100), 0.05, 9);
    for person in 0..2 {
        world.come(person);
    }
    let hand = |person: u64, now: u64| (300..1500).contains(&now).then(|| band(person, now, now / 500));
    world.run(1000, hand);
    let (number, cut) = {
        let client = world.potter(0);
        client.undo();
        (client.number(), Tick(0).offset(999 + client.tick_offset()))
    };
    world.run(4000, hand);
    world.assert_settled("cut");
    let strokes = &world.strokes(&BTreeSet::from([(number, cut)]))[&number];
    assert_eq!(strokes.len(), 2, "{strokes:?}");
    let without = world.digest_without(|client, tick| client == number && tick <= cut);
    assert_eq!(world.digest(), without);
    // what was pressed on is a stroke of its own, and there is nothing behind it
    assert_eq!((world.potter(0).steps().back, world.potter(0).steps().forth), (1, 0));
    world.potter(0).undo();
    world.potter(0).undo();
    world.potter(1).redo();
    world.run(6000, hand);
    world.assert_settled("nothing left");
    assert_eq!(world.digest(), world.digest_without(|client, _| client == number));
    assert_eq!(world.answers, [(PeerId(0), NoStep::NothingBack), (PeerId(1), NoStep::NothingForth)]);
}

#[test]
fn those_who_look_on_and_those_who_come_later_get_the_clay_that_was_made_again() {
    let mut world = World::new(MethodKind::Plastic, (120, 100), 0.03, 4);
    for person in 0..2 {
        world.come(person);
    }
    let (near, far) = (world.look_on(10), world.look_on(11));
    world.run(100, in_turns);
    let watch = |world: &mut World, peer: PeerId, detail: Detail| {
        let time = Duration::from_millis(world.now);
        let Some(Person::Looker(watcher)) = world.people.get_mut(&peer) else { panic!("{peer:?} does not look on") };
        watcher.watch(1, detail, time);
    };
    watch(&mut world, near, Detail::SPECTATOR);
    watch(&mut world, far, Detail::GALLERY);
    world.run(5500, in_turns);
    for person in [0, 1, 0] {
        world.potter(person).undo();
    }
    world.run(8000, in_turns);
    world.come(3);
    let (nearer, farther) = (world.look_on(12), world.look_on(13));
    world.run(8100, in_turns);
    watch(&mut world, nearer, Detail::SPECTATOR);
    watch(&mut world, farther, Detail::GALLERY);
    world.run(10_500, in_turns);
    world.assert_settled("all");
    let sight = |peer: PeerId| {
        let Some(Person::Looker(watcher)) = world.people.get(&peer) else { panic!("{peer:?} does not look on") };
        assert_eq!((watcher.is_behind(), watcher.mismatches()), (false, 0), "{peer:?}");
        watcher.sight(1).unwrap().digest()
    };
    assert_eq!(sight(near), sight(nearer));
    assert_eq!(sight(far), sight(farther));
    assert_ne!(sight(near), sight(far));
}

#[test]
fn a_new_pot_of_a_form_is_the_same_clay_and_can_be_taken_back() {
    let mut world = World::new(MethodKind::Plastic, (120, 100), 0.03, 22);
    for person in 0..2 {
        world.come(person);
    }
    world.run(1500, in_turns);
    world.run(2300, |_, _| None);
    world.assert_settled("pressed");
    for form in [Form::Bowl, Form::Bottle, Form::Ball, Form::Cylinder] {
        let before = world.digest();
        world.potter(1).begin_anew(Some(form));
        world.run(world.now + 400, |_, _| None);
        world.assert_settled(form.name());
        let pot = world.room.pot(0).unwrap();
        // what anybody would make of the wheel's clay, rounded as snapshots are
        let made = PotRecord::of(&form.of_clay_of(*pot.spec()).unwrap()).pot();
        assert_eq!(PotRecord::of(pot), PotRecord::of(&made), "{form:?}");
        assert_eq!(pot.surfaces()[0].height_m(), made.surfaces()[0].height_m(), "{form:?}");
        world.potter(1).undo();
        world.run(world.now + 600, |_, _| None);
        world.assert_settled("taken back");
        assert_eq!(world.digest(), before, "{form:?}");
    }
    world.assert_recorded();
}

#[test]
fn a_pot_that_somebody_brings_is_put_for_everybody_and_can_be_taken_back() {
    let mut world = World::new(MethodKind::Plastic, (120, 100), 0.03, 23);
    for person in 0..2 {
        world.come(person);
    }
    world.run(1500, in_turns);
    world.run(2300, |_, _| None);
    world.assert_settled("pressed");
    let (before, spec) = (world.digest(), *world.room.pot(0).unwrap().spec());
    // of this grid and of a finer one: two pieces each on this wheel
    for shape in [spec.shape, GridShape::new(240, 200).unwrap()] {
        let bottle = PotRecord::of(&Form::Bottle.of_clay_of(PotSpec { shape, ..spec }).unwrap());
        world.potter(1).put(&bottle).unwrap();
        world.run(world.now + 400, |_, _| None);
        world.assert_settled("put");
        let put = world.room.pot(0).unwrap();
        assert_eq!(PotRecord::of(put), fitted(&bottle, &spec).unwrap(), "{shape:?}");
        // within a thousandth, which another grid makes of a curved wall
        let (high_m, there_m) = (bottle.pot().surfaces()[0].height_m(), put.surfaces()[0].height_m());
        assert!((high_m / there_m - 1.0).abs() < 1e-3, "{high_m} {there_m}");
        world.potter(1).undo();
        world.run(world.now + 600, |_, _| None);
        world.assert_settled("taken back");
        assert_eq!(world.digest(), before, "{shape:?}");
    }
    world.assert_recorded();
}

#[test]
fn what_is_no_pot_of_the_wheel_is_told_and_changes_nothing() {
    let mut world = World::new(MethodKind::Plastic, (120, 100), 0.0, 24);
    world.come(0);
    world.run(1500, in_turns);
    world.run(2300, |_, _| None);
    let (before, spec) = (world.digest(), *world.room.pot(0).unwrap().spec());
    let planes = PotRecord::of(&Form::Bowl.of_clay_of(spec).unwrap()).planes();
    let (first, last) = planes.split_at(POT_PIECE);
    // out of turn, cut short, too long, of radii that no pot has, and after all of it a whole one
    let attempts: [&[(u16, &[u8])]; 6] = [
        &[(1, last)],
        &[(0, first), (1, &last[1..])],
        &[(0, &first[1..]), (1, last)],
        &[(0, first), (1, &[last, last].concat())],
        &[(0, &[255; POT_PIECE]), (1, last)],
        &[(0, first), (0, first), (7, last), (1, last)],
    ];
    for (number, pieces) in attempts.into_iter().enumerate() {
        for &(piece, bytes) in pieces {
            world.potter(0).request(&Request::Pot { held: 0, piece, bytes: bytes.to_vec() });
        }
        world.run(world.now + 1500, |_, _| None);
        assert_eq!(world.answers, vec![(PeerId(0), NoStep::NoPot); number + 1], "attempt {number}");
        assert_eq!(world.digest(), before, "attempt {number}");
    }
    let higher = PotSpec { height: Metres(0.25), ..spec };
    let other = PotRecord::of(&Form::Bowl.of_clay_of(higher).unwrap());
    let said = world.potter(0).put(&other).unwrap_err().to_string();
    assert!(said.contains("mm high") && said.contains("--open"), "{said}");
    let thin = PotRecord::of(&Form::Bowl.of_clay_of(PotSpec { wall: Metres(0.004), ..spec }).unwrap());
    assert!(matches!(world.potter(0).put(&thin), Err(PutError::Clay { their_wall_mm: 4.0, .. })));
}

#[test]
fn a_form_into_which_the_clay_does_not_go_is_told_and_changes_nothing() {
    let (height, radius) = (Metres::from_mm(600.0), Metres::from_mm(150.0));
    let shape = GridShape::new(120, 100).unwrap();
    let mut world = World::of(PotSpec { shape, height, radius, ..PotSpec::default() }, MethodKind::Plastic, 0.0, 25);
    world.come(0);
    world.run(1500, |_, _| None);
    let before = world.digest();
    // a bowl of so much clay would be 264 mm wide, where 200 are allowed, and a bottle is 189 mm
    world.potter(0).begin_anew(Some(Form::Bowl));
    world.run(world.now + 600, |_, _| None);
    assert_eq!(world.answers, [(PeerId(0), NoStep::NoPot)]);
    assert_eq!(world.digest(), before);
    world.potter(0).begin_anew(Some(Form::Bottle));
    world.run(world.now + 600, |_, _| None);
    assert_eq!(world.answers.len(), 1);
    assert_ne!(world.digest(), before);
}

#[test]
fn a_new_pot_is_a_step_as_any_other() {
    let mut world = World::new(MethodKind::Plastic, (120, 100), 0.03, 21);
    for person in 0..3 {
        world.come(person);
    }
    world.run(100, in_turns);
    let untouched = world.digest();
    world.run(2250, in_turns);
    // two steps at once: the new pot comes while the clay of the first is made again
    world.potter(0).undo();
    world.potter(2).begin_anew(None);
    world.run(6500, in_turns);
    world.assert_settled("new");
    let is_new = |what: &Happening| matches!(what, Happening::Snapshot { digest } if *digest == untouched);
    let put = world.entries.iter().rfind(|entry| is_new(&entry.what)).unwrap().tick;
    let new = world.digest();
    assert_eq!(new, world.digest_without(|_, tick| tick <= put), "what was pressed since alone");
    let (first, third) = (world.potter(0).number(), world.potter(2).number());
    let strokes = world.strokes(&BTreeSet::new());
    let undone = *strokes[&first].iter().rfind(|(_, last)| *last < put).unwrap();
    // taken back, everything is there again, but for what the first potter had undone
    let steps = 1 + strokes[&third].iter().filter(|(first, _)| *first > put).count();
    assert!(steps > 2, "{strokes:?} since {put:?}");
    for _ in 0..steps {
        world.potter(2).undo();
    }
    world.run(9000, in_turns);
    world.assert_settled("taken back");
    let without = world.digest_without(|client, tick| {
        (client == first && (undone.0..=undone.1).contains(&tick)) || (client == third && tick > put)
    });
    assert_eq!(world.digest(), without);
    for _ in 0..steps {
        world.potter(2).redo();
    }
    world.run(12_000, in_turns);
    world.assert_settled("and again");
    assert_eq!(world.digest(), new);
    world.assert_recorded();
}
