//! Looking on: each detail holds what the potters made, as finely as it should and for no more bytes than it may.
//!
//! A room, its potters and those who look on, in one process over virtual time and a wire that loses.
//! Invariant under test: what is shown of a wheel is whole, whatever the wire does and however often the detail changes.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::collections::BTreeMap;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::{GridShape, Material, MethodKind, Pot, PotSpec, Surface, Wetness, Window};
use pottery_shared::protocol::{self, FrameReader, Inputs, Keyframe, Request, SightName, Upload};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig};
use pottery_shared::session::{Client, MendCounts, Watched, Watcher};
use pottery_shared::snapshot::{Author, Detail, Moment, QUANTUM_M, Tier, TileLayout, Touched, Version};
use pottery_shared::tool::{Orientation, Position, Shape, Side, Tool, ToolSample, rack};
use pottery_shared::units::{Metres, Rpm, Tick};
use pottery_tests::dice::Dice;

const CODE: &str = "CLAY";
/// Enough for everything.
const PLENTY: u32 = 10_000_000;
/// As deep as a hand with 3.3 N comes, and what it is measured with that is deeper, mm.
const HANDS_MM: f32 = 2.5;
const DEEP_MM: f32 = 4.0;

#[derive(Debug)]
struct Looker {
    watcher: Option<Watcher>,
    datagram_bytes: u64,
    keyframe_bytes: u64,
    /// Bytes on the line, with what UDP, IP and QUIC put round them, for each second.
    line_bytes: u64,
}

/// What is on its way to one who looks on.
enum Parcel {
    Frame(Vec<u8>),
    Datagram(Vec<u8>),
    Keyframe(Vec<u8>),
}

struct World {
    room: Room,
    potters: BTreeMap<PeerId, Client>,
    lookers: BTreeMap<PeerId, Looker>,
    parcels: BTreeMap<(u64, u64), (PeerId, Parcel)>,
    sent: u64,
    dice: Dice,
    delay_ms: u64,
    loss: f64,
    /// What everybody holds, and how deep it comes at the most.
    tool: Tool,
    depth_mm: f32,
}

impl World {
    /// A potter at each wheel, who hears everything at once.
    fn new(wheels: u16, delay_ms: u64, loss: f64) -> Self {
        Self::of(MethodKind::Plastic, wheels, delay_ms, loss)
    }

    fn of(method: MethodKind, wheels: u16, delay_ms: u64, loss: f64) -> Self {
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
            room: room.unwrap(),
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
            let mut potter = Client::open(&bare(&welcome), 0, Duration::ZERO).unwrap();
            while let Some(transmit) = world.room.poll_transmit() {
                let Lane::Control(frame) = transmit.lane else { panic!() };
                potter.handle_control(&bare(&frame)).unwrap();
            }
            world.potters.insert(peer, potter);
        }
        world
    }

    fn look_on(&mut self, number: u64, bytes_per_s: u32) -> PeerId {
        let peer = PeerId(100 + number);
        self.room.handle_control(peer, &bare(&Watcher::greeting(CODE, bytes_per_s)));
        self.lookers.insert(peer, Looker { watcher: None, datagram_bytes: 0, keyframe_bytes: 0, line_bytes: 0 });
        // the answer is on its way
        self.transmit(0);
        peer
    }

    fn watcher(&mut self, peer: PeerId) -> &mut Watcher {
        self.lookers.get_mut(&peer).unwrap().watcher.as_mut().unwrap()
    }

    fn potter(&mut self, number: u64) -> &mut Client {
        self.potters.get_mut(&PeerId(number)).unwrap()
    }

    fn transmit(&mut self, now: u64) {
        while let Some(transmit) = self.room.poll_transmit() {
            let peer = transmit.to;
            if let Some(potter) = self.potters.get_mut(&peer) {
                let time = Duration::from_millis(now);
                match transmit.lane {
                    Lane::Datagram(bytes) => assert!(potter.handle_datagram(&bytes, time)),
                    Lane::Keyframe(bytes) => assert!(potter.handle_keyframe(&bytes, time)),
                    Lane::Control(frame) => potter.handle_control(&bare(&frame)).unwrap(),
                    Lane::Close => panic!("a potter was sent away"),
                }
                potter.rebase();
                continue;
            }
            let looker = self.lookers.get_mut(&peer).unwrap();
            let parcel = match transmit.lane {
                Lane::Datagram(bytes) => {
                    assert!(bytes.len() <= protocol::DATAGRAM_MAX, "{} bytes", bytes.len());
                    looker.datagram_bytes += bytes.len() as u64;
                    looker.line_bytes += bytes.len() as u64 + 57;
                    if self.dice.chance(self.loss) {
                        continue;
                    }
                    Parcel::Datagram(bytes)
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
    fn step(&mut self, now: u64, is_pressing: bool) {
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
            let looker = self.lookers.get_mut(&peer).unwrap();
            match (&mut looker.watcher, parcel) {
                (None, Parcel::Frame(frame)) => {
                    let round_trip = Duration::from_millis(2 * self.delay_ms);
                    looker.watcher = Some(Watcher::open(&frame, round_trip).unwrap());
                }
                (Some(watcher), Parcel::Frame(frame)) => watcher.handle_control(&frame).unwrap(),
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
    reader.next_frame().unwrap().unwrap()
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
fn worst_m(seen: &Pot, made: &Pot) -> f32 {
    let (coarse, fine) = (seen.spec().shape, made.spec().shape);
    let fold = (fine.columns() / coarse.columns(), fine.rows() / coarse.rows());
    let mut worst = 0.0_f32;
    for column in 0..coarse.columns() {
        for row in 0..coarse.rows() {
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
fn allowed_m(detail: Detail) -> f32 {
    0.5 * detail.quantum().metres() + QUANTUM_M
}

#[test]
fn every_detail_holds_what_was_made_after_loss_and_reorder() {
    let mut world = World::new(2, 30, 0.1);
    let peer = world.look_on(0, PLENTY);
    let late = world.look_on(1, PLENTY);
    let retold = world.look_on(2, PLENTY);
    for now in 1..4000 {
        world.step(now, now < 2500);
        if now == 100 {
            world.watcher(peer).watch(1, Detail::Spectator, Duration::from_millis(now));
            world.watcher(peer).watch(2, Detail::Gallery, Duration::from_millis(now));
        }
        if now == 600 {
            world.watcher(retold).watch(1, Detail::Retold, Duration::from_millis(now));
            world.watcher(retold).watch(2, Detail::Retold, Duration::from_millis(now));
        }
        if now == 2000 {
            world.watcher(late).watch(2, Detail::Spectator, Duration::from_millis(now));
        }
        // who presses again what others press has to press it under the same settings
        match now {
            1000 => world.potter(1).request(&Request::WheelSpeed { rpm: 100.0 }),
            1300 => {
                world.potter(2).request(&Request::Clay { clay: Material::from_wetness(Wetness::nearest(0.9)).into() })
            }
            _ => {}
        }
    }
    for (peer, wheel, detail) in [
        (peer, 1, Detail::Spectator),
        (peer, 2, Detail::Gallery),
        (late, 2, Detail::Spectator),
        (retold, 1, Detail::Retold),
        (retold, 2, Detail::Retold),
    ] {
        let made = world.room.pot(usize::from(wheel) - 1).unwrap().clone();
        assert!(made.pressed_m3() * 1e9 > 300.0);
        let watcher = world.watcher(peer);
        assert!(!watcher.is_behind() && watcher.mismatches() == 0, "{detail:?} of {wheel}");
        let seen = watcher.sight(wheel).unwrap();
        assert_eq!(seen.detail(), detail);
        assert_eq!(seen.pot().spec().shape, detail.grid_of(GridShape::PAPER));
        let worst = worst_m(seen.pot(), &made);
        println!("{detail:?} of {wheel}: {:.1} µm off, {} times asked", worst * 1e6, watcher.asked());
        assert!(worst <= allowed_m(detail), "{detail:?} of {wheel}: {worst} m");
        if detail == Detail::Retold {
            assert_eq!(seen.digest(), world.room.digest(usize::from(wheel) - 1).unwrap(), "{wheel}");
        }
    }
    assert!(world.watcher(peer).asked() > 0, "nothing was lost");
    // most of the snapshots of two seconds at two wheels, where a tenth of what told of them was lost
    let watcher = world.watcher(retold);
    assert!(watcher.retold() > 120 && watcher.keeps_up(), "{} retold", watcher.retold());
    assert_eq!(world.room.counts().refusals.total(), 0);
}

#[test]
fn changing_the_detail_leaves_no_gap_and_no_torn_pot() {
    let mut world = World::new(1, 40, 0.0);
    let peer = world.look_on(0, PLENTY);
    // what the potter had made at each tick of a snapshot
    let mut made: BTreeMap<u64, Pot> = BTreeMap::new();
    let (mut last_tick, mut changes, mut looked, mut shown) = (Tick(0), 0, 0, None);
    for now in 1..3000 {
        world.step(now, true);
        if pottery_shared::snapshot::SnapshotClock::default().is_due(Tick(now)) {
            made.insert(now, world.room.pot(0).unwrap().clone());
            made.retain(|tick, _| tick + 400 > now);
        }
        if now >= 100 && now.is_multiple_of(150) {
            // now and then it changes its mind before the sight has come
            let detail = Detail::ALL[(now / 150 % 3) as usize];
            world.watcher(peer).watch(1, detail, Duration::from_millis(now));
            if now.is_multiple_of(600) {
                world.watcher(peer).watch(1, Detail::ALL[(now / 150 + 1) as usize % 3], Duration::from_millis(now));
                world.watcher(peer).watch(1, detail, Duration::from_millis(now));
            }
        }
        let Some(watcher) = world.lookers[&peer].watcher.as_ref() else { continue };
        let Some(seen) = watcher.sight(1) else {
            assert_eq!(shown, None, "a gap at {now}");
            continue;
        };
        changes += u32::from(shown.is_some_and(|shown| shown != seen.detail()));
        shown = Some(seen.detail());
        assert!(seen.tick() >= last_tick, "{:?} after {last_tick:?}", seen.tick());
        last_tick = seen.tick();
        if now.is_multiple_of(7)
            && let Some(made) = made.get(&seen.tick().0)
        {
            let worst = worst_m(seen.pot(), made);
            assert!(worst <= allowed_m(seen.detail()), "{worst} m off at {now}, {:?}", seen.detail());
            looked += 1;
        }
    }
    println!("{changes} changes, looked {looked} times");
    assert!(changes >= 15 && looked > 200, "{changes} changes, looked {looked} times");
    assert_eq!(world.watcher(peer).mismatches(), 0);
    // and what is no longer watched is no longer sent
    world.watcher(peer).unwatch(1);
    for now in 3000..3100 {
        world.step(now, true);
    }
    let sent = world.lookers[&peer].line_bytes;
    for now in 3100..4200 {
        world.step(now, true);
    }
    assert_eq!(world.lookers[&peer].line_bytes, sent);
}

#[test]
fn a_budget_is_kept_and_starves_no_wheel() {
    // about two thirds of what four wheels would take
    const BUDGET: u32 = 12_000;
    let mut world = World::new(4, 10, 0.0);
    let peer = world.look_on(0, BUDGET);
    let mut lag_ms = [0_u64; 5];
    let mut most = 0_i64;
    for now in 1..8000 {
        world.step(now, now < 6000);
        if now == 100 {
            for wheel in 1..=4 {
                let detail = if wheel == 2 { Detail::Spectator } else { Detail::Gallery };
                world.watcher(peer).watch(wheel, detail, Duration::from_millis(now));
            }
        }
        most = most.max(world.lookers[&peer].line_bytes as i64 - i64::from(BUDGET) * now as i64 / 1000);
        if (2000..6000).contains(&now) {
            for wheel in 1..=4 {
                let seen = world.watcher(peer).sight(wheel).unwrap();
                lag_ms[usize::from(wheel)] = lag_ms[usize::from(wheel)].max(now - seen.tick().0);
            }
        }
    }
    let looker = &world.lookers[&peer];
    println!(
        "most over the budget {most} B, lags {:?} ms, datagrams {} B, keyframes {} B",
        &lag_ms[1..],
        looker.datagram_bytes,
        looker.keyframe_bytes
    );
    // a quarter of a second, and the longest message: a keyframe
    assert!(most <= i64::from(BUDGET) / 4 + 12_000, "{most} B over the budget");
    // pictures of the others take less than their share and are late by no more than a message's bytes take
    assert!([1, 3, 4].iter().all(|&wheel: &usize| lag_ms[wheel] < 1500), "{lag_ms:?}");
    assert!(!world.watcher(peer).is_behind() && world.watcher(peer).mismatches() == 0);
    for wheel in 1..=4 {
        let made = world.room.pot(usize::from(wheel) - 1).unwrap().clone();
        let seen = world.watcher(peer).sight(wheel).unwrap();
        assert!(worst_m(seen.pot(), &made) <= allowed_m(seen.detail()), "wheel {wheel}");
    }
}

/// Payload of a detail for one tool that never rests and comes so deep, kbit/s, and of its keyframe after four seconds, B.
fn kbit_per_s(detail: Detail, method: MethodKind, depth_mm: f32) -> (f64, u64) {
    let mut world = World::of(method, 1, 5, 0.0);
    world.depth_mm = depth_mm;
    let peer = world.look_on(0, PLENTY);
    let mut begun = 0;
    for now in 1..=4100 {
        world.step(now, true);
        match now {
            50 => world.watcher(peer).watch(1, detail, Duration::from_millis(now)),
            1100 => begun = world.lookers[&peer].datagram_bytes,
            _ => {}
        }
    }
    let bytes = world.lookers[&peer].datagram_bytes - begun;
    let late = world.look_on(1, PLENTY);
    for now in 4101..4200 {
        world.step(now, false);
        if now == 4120 {
            world.watcher(late).watch(1, detail, Duration::from_millis(now));
        }
    }
    (bytes as f64 * 8.0 / 3000.0, world.lookers[&late].keyframe_bytes)
}

/// Most kbit/s of payload for one tool: who looks on closely may take 65, whatever the clay and the way of telling, as deep as hands press.
/// Deeper, of the studio's own clay more changes, since a rim rises beside the tool, and deltas are what is fallen back to: measured,
/// and an eighth more.
const GATES: [(Detail, MethodKind, f32, f64); 9] = [
    (Detail::Retold, MethodKind::Plastic, HANDS_MM, 65.0),
    (Detail::Spectator, MethodKind::Plastic, HANDS_MM, 65.0),
    (Detail::Gallery, MethodKind::Plastic, HANDS_MM, 5.4),
    (Detail::Retold, MethodKind::Improved, DEEP_MM, 65.0),
    (Detail::Retold, MethodKind::Plastic, DEEP_MM, 65.0),
    (Detail::Spectator, MethodKind::Improved, DEEP_MM, 65.0),
    (Detail::Spectator, MethodKind::Plastic, DEEP_MM, 110.0),
    (Detail::Gallery, MethodKind::Improved, DEEP_MM, 4.5),
    (Detail::Gallery, MethodKind::Plastic, DEEP_MM, 5.4),
];

#[test]
fn looking_on_costs_little() {
    let mut broken = Vec::new();
    for (detail, method, depth_mm, most_kbit_per_s) in GATES {
        let (kbit_per_s, keyframe_bytes) = kbit_per_s(detail, method, depth_mm);
        let what = format!("{detail:?}, {method:?}, {depth_mm} mm deep: {kbit_per_s:.1} kbit/s for one tool");
        println!("{what}, keyframe {keyframe_bytes} B");
        assert!(keyframe_bytes > 0);
        if kbit_per_s > most_kbit_per_s {
            broken.push(format!("{what}, allowed {most_kbit_per_s}"));
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

#[test]
fn who_does_not_keep_up_gets_deltas_without_a_gap_and_tries_again() {
    let mut world = World::new(1, 20, 0.0);
    let peer = world.look_on(0, PLENTY);
    let mut seen = Vec::new();
    for now in 1..34_000 {
        world.step(now, now < 4000);
        let time = Duration::from_millis(now);
        if now == 100 {
            world.watcher(peer).watch(1, Detail::Retold, time);
        }
        // half of all time goes into pressing again, until it no longer has to
        let Some(watcher) = &mut world.lookers.get_mut(&peer).unwrap().watcher else { continue };
        let spent = if watcher.keeps_up() && now < 4000 { Duration::from_micros(500) } else { Duration::ZERO };
        watcher.handle_effort(spent, time);
        let shown = watcher.sight(1).map(Watched::detail);
        if seen.last() != Some(&shown) {
            seen.push(shown);
        }
    }
    assert_eq!(seen, [None, Some(Detail::Retold), Some(Detail::Spectator), Some(Detail::Retold)]);
    let (made, watcher) = (world.room.digest(0).unwrap(), world.watcher(peer));
    assert_eq!((watcher.sight(1).unwrap().digest(), watcher.mismatches()), (made, 0));
}

#[test]
fn who_looks_closely_hears_of_tools_that_are_brought_and_presses_with_them() {
    let mut world = World::new(1, 20, 0.0);
    let brought = rack::ball(2, Metres::from_mm(9.0)).unwrap();
    let (early, late) = (world.look_on(0, PLENTY), world.look_on(1, PLENTY));
    for now in 1..2500 {
        let time = Duration::from_millis(now);
        match now {
            100 => world.watcher(early).watch(1, Detail::Retold, time),
            300 => world.potter(1).bring(&brought).unwrap(),
            700 => world.tool = Tool::Convex(Shape(rack::standard().len() as u8)),
            900 => world.watcher(late).watch(1, Detail::Retold, time),
            _ => {}
        }
        world.step(now, now < 2000);
    }
    let held = world.potter(1).rack();
    for peer in [early, late] {
        let made = world.room.digest(0).unwrap();
        let watcher = world.watcher(peer);
        let rack = watcher.rack(1).unwrap();
        assert_eq!(rack.len(), rack::standard().len() + 1);
        assert!(rack.last().unwrap().triangles_m().eq(held.last().unwrap().triangles_m()));
        assert_eq!((watcher.sight(1).unwrap().digest(), watcher.mismatches()), (made, 0));
        assert!(watcher.retold() > 30, "{}", watcher.retold());
    }
}

/// A keyframe of some tiles that somebody has pressed otherwise.
fn wrong_tiles(detail: Detail, tiles: &[u32]) -> Vec<u8> {
    let mut pot = Pot::new(PotSpec::default()).unwrap();
    let mut author = Author::new(&mut pot);
    let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
    let mut tier = Tier::new(&author, detail.quantum(), detail.fold(), |_| true);
    let fold = detail.fold();
    for &tile in tiles {
        let Window { first_column, first_row, .. } = TileLayout::new(detail.grid_of(GridShape::PAPER)).window(tile);
        let window =
            Window { first_column: first_column * fold, columns: fold, first_row: first_row * fold, rows: fold };
        for column in window.first_column..window.first_column + fold {
            for row in window.first_row..window.first_row + fold {
                pot.surfaces_mut()[0].set_radius(column, row, 0.05);
            }
        }
        touched.add_window(0, window);
    }
    author.publish(&mut pot, &mut touched, Moment::default()).unwrap();
    if detail == Detail::Retold {
        return author.keyframe(Version(0), false);
    }
    tier.publish(&author, Moment::default()).unwrap();
    tier.keyframe(Version(0))
}

#[test]
fn tiles_that_went_wrong_where_one_looks_on_come_alone_and_are_counted_on_both_sides() {
    for detail in Detail::ALL {
        let mut world = World::new(1, 20, 0.0);
        let peer = world.look_on(0, PLENTY);
        for now in 1..4000 {
            world.step(now, now < 1500);
            let time = Duration::from_millis(now);
            if now == 100 {
                world.watcher(peer).watch(1, detail, time);
            }
            if now == 2000 {
                // what a server with a fault would send, under the version that is held
                let sight = Some(SightName { wheel: 1, detail: detail.number() });
                let (bytes, goes_on) = (wrong_tiles(detail, &[1, 7, 21]), detail != Detail::Retold);
                let watcher = world.watcher(peer);
                let version = watcher.sight(1).unwrap().version().0;
                let (since, tick, acknowledged, mended) = (1, now, 0, 0);
                let keyframe = Keyframe { version, since, tick, acknowledged, sight, mended, goes_on, bytes };
                assert!(watcher.handle_keyframe(&protocol::encode(&keyframe), time), "{detail:?}");
            }
        }
        let made = world.room.pot(0).unwrap().clone();
        let watcher = world.watcher(peer);
        let expected = MendCounts { asked: 1, whole: 0, tiles: 3 };
        assert_eq!((watcher.mend_counts(), watcher.mismatches()), (expected, 1), "{detail:?}");
        assert!(!watcher.is_behind(), "{detail:?}");
        let worst = worst_m(watcher.sight(1).unwrap().pot(), &made);
        assert!(worst <= allowed_m(detail), "{detail:?}: {worst} m");
        let counts = world.room.counts();
        assert_eq!((counts.mends, counts.mended_tiles, counts.refusals.total()), (1, 3, 0), "{detail:?}");
    }
}

#[test]
fn who_looks_on_cannot_press_and_asks_in_vain_for_what_there_is_not() {
    let mut world = World::new(1, 0, 0.0);
    let peer = world.look_on(0, PLENTY);
    world.step(1, false);
    let digest = world.room.digest(0);
    let ask = |world: &mut World, request: &Request| world.room.handle_control(peer, &protocol::encode(request));
    let sight = |wheel, detail| SightName { wheel, detail };
    for name in [sight(0, 0), sight(2, 0), sight(1, 9), sight(u16::MAX, 0)] {
        ask(&mut world, &Request::Watch { sight: name, have: 0 });
        ask(&mut world, &Request::Unwatch { sight: name });
    }
    ask(&mut world, &Request::WheelSpeed { rpm: 3.0 });
    assert_eq!((world.room.counts().refusals.requests, world.room.counts().forbidden), (8, 1));
    let inputs = protocol::encode(&Upload {
        inputs: Inputs { first: 0, runs: Vec::new(), rests: true },
        hand: None,
        again: None,
    });
    world.room.handle_datagram(peer, &inputs);
    // a version that never was is answered with the whole pot
    ask(&mut world, &Request::Watch { sight: sight(1, 0), have: 7_000 });
    let before = world.lookers[&peer].keyframe_bytes;
    for now in 2..100 {
        world.step(now, false);
    }
    assert!(world.lookers[&peer].keyframe_bytes > before);
    // many questions at once are too many
    for _ in 0..200 {
        ask(&mut world, &Request::Watch { sight: sight(1, 1), have: 0 });
    }
    assert!(world.room.counts().refusals.requests > 150);
    assert_eq!(world.room.digest(0), digest);
    assert_eq!(world.room.people(), 2);
    // who is gone is forgotten
    world.room.handle_gone(peer);
    assert_eq!(world.room.people(), 1);
}
