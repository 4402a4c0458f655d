//! The chain of snapshots: what the author publishes is what the replica holds, bit for bit, and bytes that say anything
//! else either change nothing or leave sound clay.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::Vec3;
use pottery_shared::clay::{
    Conditions, GridShape, MethodKind, Phase, Pot, PotSpec, Press, SubStep, Surface, Wheel, Window,
};
use pottery_shared::snapshot::{
    Author, Band, Delta, Detail, Moment, QUANTUM_M, Quantum, Replica, SnapshotClock, SnapshotError, TILE_SIDE, Tier,
    TileLayout, Touched, Version,
};
use pottery_shared::tool::{Orientation, Position, Side, Sphere, Tool, ToolSample};
use pottery_shared::units::{Metres, Rpm, Tick};
use proptest::prelude::*;

/// No side is a multiple of a tile's.
fn small_spec() -> PotSpec {
    PotSpec { shape: GridShape::new(72, 61).unwrap(), ..PotSpec::default() }
}

fn no_tiles(pot: &Pot) -> Touched {
    Touched::none(pot.surfaces().iter().map(Surface::shape))
}

/// The authoritative side: clay, and the chain of its snapshots.
struct Origin {
    pot: Pot,
    author: Author,
    touched: Touched,
    substep: SubStep,
    deltas: Vec<Delta>,
    /// What is taken for the tick of the next snapshot.
    now: Moment,
}

impl Origin {
    fn new(spec: PotSpec) -> Self {
        let mut pot = Pot::new(spec).unwrap();
        let author = Author::new(&mut pot);
        let touched = no_tiles(&pot);
        Self {
            pot,
            author,
            touched,
            substep: SubStep::for_grid(spec.shape),
            deltas: Vec::new(),
            now: Moment::default(),
        }
    }

    fn press(&mut self, presses: &[Press], method: MethodKind) {
        let touched = &mut self.touched;
        self.substep.advance(&mut self.pot, presses, method, |surface, window| touched.add_window(surface, window));
    }

    /// Publishes; the number of bytes, 0 when nothing changed.
    fn publish(&mut self) -> usize {
        // a wheel at 60 rpm
        let tick = self.now.tick.offset(17);
        self.now = Moment { tick, phase: Phase(self.now.phase.0.wrapping_add(17 * 4_294_967)) };
        let delta = self.author.publish(&mut self.pot, &mut self.touched, self.now);
        let bytes = delta.as_ref().map_or(0, |delta| delta.bytes.len());
        self.deltas.extend(delta);
        bytes
    }

    fn replica(&self) -> Replica {
        Replica::new(Pot::new(*self.pot.spec()).unwrap())
    }

    /// A replica that has taken the deltas up to a version.
    fn replica_at(&self, version: usize) -> Replica {
        let mut replica = self.replica();
        for delta in &self.deltas[..version] {
            replica.apply_delta(delta.version, &delta.bytes, &mut no_tiles(&self.pot)).unwrap();
        }
        replica
    }
}

/// A press anywhere at the pot, some of them to the bottom of what clay allows.
fn press() -> impl Strategy<Value = Press> {
    let place = (30.0_f32..100.0, -3.2_f32..3.2, -20.0_f32..220.0);
    (place, 0.5_f32..40.0, 0.001_f32..1.0).prop_map(|((distance_mm, angle_rad, z_mm), radius_mm, response)| Press {
        turning: 1,
        response,
        ..Press::held(
            Sphere::new(Metres::from_mm(radius_mm)).unwrap(),
            Vec3::new(distance_mm * angle_rad.cos(), distance_mm * angle_rad.sin(), z_mm) * 1e-3,
        )
    })
}

/// Presses of consecutive sub-steps, with a snapshot after each group.
fn groups(snapshots: impl Into<prop::collection::SizeRange>) -> impl Strategy<Value = Vec<Vec<Vec<Press>>>> {
    let step = prop::collection::vec(press(), 1..4);
    prop::collection::vec(prop::collection::vec(step, 1..5), snapshots)
}

fn method() -> impl Strategy<Value = MethodKind> {
    prop_oneof![Just(MethodKind::Original), Just(MethodKind::Improved), Just(MethodKind::Plastic)]
}

fn origin_of(groups: &[Vec<Vec<Press>>], method: MethodKind) -> Origin {
    let mut origin = Origin::new(small_spec());
    for group in groups {
        for presses in group {
            origin.press(presses, method);
        }
        origin.publish();
    }
    origin
}

/// What a replica may be after any bytes: within its bounds, and no number that is none.
fn assert_sound(replica: &Replica) {
    let surface = &replica.pot().surfaces()[0];
    let (low, high) = surface.bounds_m();
    assert!(surface.radii_m().iter().all(|radius| (low..=high).contains(radius)));
}

proptest! {
    #[test]
    fn replica_holds_the_authors_clay_after_every_snapshot(groups in groups(1..8), method in method()) {
        let mut origin = Origin::new(small_spec());
        let mut replica = origin.replica();
        prop_assert_eq!(replica.digest(), origin.author.digest());
        prop_assert!(replica.pot() == &origin.pot, "the untouched pots differ");
        for group in groups {
            for presses in &group {
                origin.press(presses, method);
            }
            let pressed = origin.touched.clone();
            let before = replica.pot().clone();
            if origin.publish() == 0 {
                prop_assert!(before == origin.pot, "a change was not published");
                continue;
            }
            let delta = origin.deltas.last().unwrap();
            let mut news = no_tiles(&origin.pot);
            replica.apply_delta(delta.version, &delta.bytes, &mut news).unwrap();
            prop_assert_eq!(replica.version(), origin.author.latest());
            prop_assert_eq!(replica.digest(), origin.author.digest());
            prop_assert!(replica.pot() == &origin.pot, "same digest, other clay");
            // the news are the tiles in which the clay changed, no more and no less
            let named: Vec<_> = news.iter().collect();
            for (surface, _, window) in pressed.iter() {
                let is_named = named.iter().any(|&(other, _, found)| (surface, window) == (other, found));
                let mut patched = before.clone();
                patched.copy_window(replica.pot(), surface, window);
                prop_assert_eq!(patched.digest() != before.digest(), is_named, "{:?}", window);
            }
        }
        prop_assert!(origin.touched.is_empty());
    }

    #[test]
    fn delta_out_of_order_is_refused_and_changes_nothing(groups in groups(2..6), method in method(), twice in any::<bool>()) {
        let origin = origin_of(&groups, method);
        for held in 0..=origin.deltas.len() {
            let mut replica = origin.replica_at(held);
            let digest = replica.digest();
            for delta in &origin.deltas {
                if delta.version == replica.version().next() {
                    continue;
                }
                for _ in 0..=u8::from(twice) {
                    let mut news = no_tiles(&origin.pot);
                    let refused = replica.apply_delta(delta.version, &delta.bytes, &mut news);
                    let not_next = SnapshotError::NotNext { delta: delta.version, held: replica.version() };
                    prop_assert_eq!(refused, Err(not_next));
                    prop_assert!(news.is_empty());
                }
            }
            prop_assert_eq!((replica.version().0 as usize, replica.digest()), (held, digest));
        }
    }

    #[test]
    fn a_coarser_chain_is_off_by_half_of_its_quantum_and_its_other_rows_stay_as_they_first_were(
        groups in groups(1..5), method in method(), steps in 1_u16..40, (first, rows) in (0_u8..4, 1_u8..3)
    ) {
        let mut origin = Origin::new(small_spec());
        let quantum = Quantum::of_steps(steps);
        let band = Band::new(first, first + rows).unwrap();
        let mut tier = Tier::new(&origin.author, Detail::new(quantum, 1, 1).unwrap().in_band(band));
        let pot = || Pot::new(*origin.pot.spec()).unwrap();
        let mut replica = Replica::with_quantum(pot(), quantum);
        let mut at_first = None;
        for group in &groups {
            for presses in group {
                origin.press(presses, method);
            }
            origin.publish();
            if let Some(delta) = tier.publish(&origin.author, origin.now) {
                replica.apply_delta(delta.version, &delta.bytes, &mut no_tiles(&origin.pot)).unwrap();
            }
            at_first.get_or_insert_with(|| origin.pot.clone());
            prop_assert_eq!((replica.version(), replica.digest()), (tier.latest(), tier.digest()));
        }
        let at_first = at_first.unwrap();
        let layout = TileLayout::new(origin.pot.spec().shape);
        for tile in 0..layout.tiles() {
            let window = layout.window(tile);
            for column in window.first_column..window.first_column + window.columns {
                for row in window.first_row as usize..(window.first_row + window.rows) as usize {
                    let at = |pot: &Pot| pot.surfaces()[0].column_m(column)[row];
                    let is_shown = (first..first + rows).contains(&((window.first_row / TILE_SIDE) as u8));
                    let own = if is_shown { at(&origin.pot) } else { at(&at_first) };
                    // and what the untouched pot's radius is off by in a coarse step
                    prop_assert!((at(replica.pot()) - own).abs() <= 0.5 * quantum.metres() + QUANTUM_M, "tile {}", tile);
                }
            }
        }
    }

    #[test]
    fn keyframe_from_any_version_brings_a_replica_up_to_date(groups in groups(1..6), method in method()) {
        let origin = origin_of(&groups, method);
        let latest = origin.author.latest();
        for have in 0..=latest.0 {
            let keyframe = origin.author.keyframe(Version(have), true);
            for held in 0..=latest.0 {
                let mut replica = origin.replica_at(held as usize);
                let digest = replica.digest();
                let applied = replica.apply_keyframe(latest, Version(have), &keyframe, true, &mut no_tiles(&origin.pot));
                if held < have {
                    let not_next = SnapshotError::NotNext { delta: Version(have), held: Version(held) };
                    prop_assert_eq!(applied, Err(not_next));
                    prop_assert_eq!(replica.digest(), digest);
                } else {
                    prop_assert_eq!(applied, Ok(()));
                    prop_assert_eq!(replica.version(), latest);
                    prop_assert_eq!(replica.digest(), origin.author.digest());
                    prop_assert!(replica.pot() == &origin.pot, "from {} with {}", have, held);
                }
            }
        }
    }

    #[test]
    fn whole_keyframe_mends_any_clay(groups in groups(1..4), damage in prop::collection::vec(any::<u8>(), 1..200)) {
        let origin = origin_of(&groups, MethodKind::Improved);
        let mut replica = origin.replica();
        // whatever these bytes make of it
        let made = replica.apply_delta(Version(1), &damage, &mut no_tiles(&origin.pot)).is_ok();
        prop_assert_eq!(replica.version(), Version(u32::from(made)));
        let latest = origin.author.latest().max(Version(1));
        let keyframe = origin.author.keyframe(Version(0), true);
        replica.apply_keyframe(latest, Version(0), &keyframe, true, &mut no_tiles(&origin.pot)).unwrap();
        prop_assert_eq!(replica.digest(), origin.author.digest());
        prop_assert!(replica.pot() == &origin.pot);
    }

    #[test]
    fn older_keyframe_changes_nothing(groups in groups(2..5)) {
        let origin = origin_of(&groups, MethodKind::Original);
        let latest = origin.author.latest();
        prop_assume!(latest > Version(1));
        let old = origin_of(&groups[..1], MethodKind::Original).author.keyframe(Version(0), true);
        let mut replica = origin.replica_at(latest.0 as usize);
        let mut news = no_tiles(&origin.pot);
        prop_assert_eq!(replica.apply_keyframe(Version(1), Version(0), &old, true, &mut news), Ok(()));
        prop_assert!(news.is_empty() && replica.version() == latest && replica.pot() == &origin.pot);
    }

    #[test]
    fn creep_below_half_a_quantum_is_dropped_on_both_sides(response in 1e-6_f32..1e-4) {
        let mut origin = Origin::new(small_spec());
        // pressed 10 mm deep at most: a push of at most 1 µm, where half a quantum is 1.9 µm
        let centre_m = Vec3::new(0.062, 0.0, 0.1);
        let tool = Sphere::new(Metres::from_mm(12.0)).unwrap();
        let before = origin.pot.clone();
        origin.press(&[Press { turning: 0, response, ..Press::held(tool, centre_m) }], MethodKind::Original);
        prop_assert!(before != origin.pot, "nothing was pressed");
        prop_assert_eq!(origin.publish(), 0);
        prop_assert!(before == origin.pot, "the author keeps what the replicas do not have");
    }
}

/// Takes `bytes` as a delta and as a keyframe of every kind: each either changes nothing or leaves sound clay.
fn assert_survives(origin: &Origin, held: usize, bytes: &[u8]) {
    let next = Version(held as u32 + 1);
    type Apply<'a> = &'a dyn Fn(&mut Replica, &mut Touched) -> Result<(), SnapshotError>;
    let ways: [Apply; 3] = [
        &|replica, news| replica.apply_delta(next, bytes, news),
        &|replica, news| replica.apply_keyframe(next, Version(0), bytes, true, news),
        &|replica, news| replica.apply_keyframe(next, Version(held as u32), bytes, false, news),
    ];
    for apply in ways {
        let mut replica = origin.replica_at(held);
        let before = (replica.version(), replica.digest(), replica.pot().digest());
        let mut news = no_tiles(&origin.pot);
        if apply(&mut replica, &mut news).is_err() {
            assert_eq!((replica.version(), replica.digest(), replica.pot().digest()), before);
            assert!(news.is_empty());
        }
        assert_sound(&replica);
    }
}

proptest! {
    #[test]
    fn bytes_of_chance_leave_sound_clay(
        groups in groups(1..2),
        bytes in prop::collection::vec(any::<u8>(), 0..3000),
    ) {
        let origin = origin_of(&groups, MethodKind::Original);
        assert_survives(&origin, origin.deltas.len(), &bytes);
    }

    #[test]
    fn damaged_messages_leave_sound_clay(
        groups in groups(1..3),
        cut in any::<prop::sample::Index>(),
        flips in prop::collection::vec((any::<prop::sample::Index>(), 0_u8..8), 1..6),
        behind in prop::collection::vec(any::<u8>(), 1..6),
    ) {
        let origin = origin_of(&groups, MethodKind::Improved);
        prop_assume!(!origin.deltas.is_empty());
        let delta = origin.deltas.last().unwrap().bytes.clone();
        for sound in [delta, origin.author.keyframe(Version(0), true)] {
            let held = origin.deltas.len() - 1;
            assert_survives(&origin, held, &sound[..cut.index(sound.len())]);
            assert_survives(&origin, held, &[&sound[..], &behind].concat());
            let mut flipped = sound.clone();
            for &(at, bit) in &flips {
                flipped[at.index(sound.len())] ^= 1 << bit;
            }
            assert_survives(&origin, held, &flipped);
        }
    }

    #[test]
    fn bytes_behind_the_end_are_refused(groups in groups(1..3), behind in prop::collection::vec(1_u8.., 1..6)) {
        let origin = origin_of(&groups, MethodKind::Improved);
        prop_assume!(!origin.deltas.is_empty());
        let delta = origin.deltas.last().unwrap();
        let mut replica = origin.replica_at(origin.deltas.len() - 1);
        // four zeros at the end are left out, and may as well be there
        let longer = [&delta.bytes[..], &[0; 4], &behind].concat();
        let refused = replica.apply_delta(delta.version, &longer, &mut no_tiles(&origin.pot));
        prop_assert_eq!(refused, Err(SnapshotError::Malformed { bytes: longer.len() }));
    }
}

#[test]
fn every_truncation_of_a_delta_leaves_sound_clay() {
    let mut origin = Origin::new(small_spec());
    let tool = Sphere::new(Metres::from_mm(12.0)).unwrap();
    origin.press(
        &[Press { turning: 1, response: 0.3, ..Press::held(tool, Vec3::new(0.07, 0.0, 0.1)) }],
        MethodKind::Improved,
    );
    assert!(origin.publish() > 20);
    let bytes = &origin.deltas[0].bytes;
    for length in 0..bytes.len() {
        assert_survives(&origin, 0, &bytes[..length]);
    }
}

/// Two seconds of steady pressing on the default pot: bytes of a snapshot in the mean and at most, and of the keyframe.
fn bytes_a_snapshot(tools: usize, method: MethodKind) -> (f64, usize, usize) {
    let mut origin = Origin::new(PotSpec::default());
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0)));
    let conditions = Conditions { wheel, method, ..Conditions::default() };
    let mut sizes = Vec::new();
    for tick in (1..2000).map(Tick) {
        let seconds = tick.0 as f32 * 1e-3;
        let presses: Vec<_> = (0..tools)
            .map(|tool| {
                let angle = tool as f32 * std::f32::consts::TAU / tools as f32;
                let distance = 0.071 - 0.001 * seconds;
                let z = 0.06 + 0.03 * tool as f32 + 0.01 * seconds;
                let centre = Position::nearest(Vec3::new(distance * angle.cos(), distance * angle.sin(), z)).unwrap();
                let (tool, orientation) = (Tool::default(), Orientation::default());
                conditions.press(&ToolSample { tick, tool, orientation, centre, side: Side::Outside }, None)
            })
            .collect();
        origin.press(&presses, method);
        if SnapshotClock::default().is_due(tick) {
            sizes.push(origin.publish());
        }
    }
    let mean = sizes.iter().sum::<usize>() as f64 / sizes.len() as f64;
    (mean, sizes.into_iter().max().unwrap(), origin.author.keyframe(Version(0), true).len())
}

/// Largest mean, largest single snapshot and largest keyframe, bytes: measured when the codec was made, and a third more.
const GATES: [(usize, MethodKind, (f64, usize, usize)); 4] = [
    (1, MethodKind::Original, (207.0, 297, 5740)),
    (1, MethodKind::Improved, (377.0, 501, 9650)),
    (4, MethodKind::Original, (812.0, 1183, 22_900)),
    (4, MethodKind::Improved, (1488.0, 1965, 36_800)),
];

#[test]
fn snapshots_stay_small() {
    let mut broken = Vec::new();
    for (tools, method, gate) in GATES {
        let (mean, most, keyframe) = bytes_a_snapshot(tools, method);
        println!("{tools} tools, {method:?}: {mean:.0} B a snapshot, {most} B at most, keyframe {keyframe} B");
        if mean > gate.0 || most > gate.1 || keyframe > gate.2 {
            broken.push(format!("{tools} tools, {method:?}: {mean:.0} B, {most} B, {keyframe} B; allowed {gate:?}"));
        }
    }
    assert!(broken.is_empty(), "{broken:#?}");
}

/// A pot of our clay that four tools have pressed all over for eight seconds, so deep at the most.
fn pressed_all_over(depth_mm: f32) -> Origin {
    let mut origin = Origin::new(PotSpec { keeps_volume: true, ..PotSpec::default() });
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0)));
    let conditions = Conditions { wheel, method: MethodKind::Plastic, ..Conditions::default() };
    let mut last = [None; 4];
    for tick in (1..8000).map(Tick) {
        let seconds = tick.0 as f32 * 1e-3;
        let presses: Vec<_> = last
            .iter_mut()
            .enumerate()
            .map(|(tool, last)| {
                // each over a quarter of the height and again
                let angle = tool as f32 * std::f32::consts::FRAC_PI_2;
                let distance = 0.0735 - depth_mm * 1e-3 - 0.0015 * (2.0 * seconds + tool as f32).sin().abs();
                let z = 0.2 * (tool as f32 + 0.5 - 0.5 * (0.8 * seconds).cos()) / 4.0;
                let tremor = 5e-5 * (57.0 * seconds + tool as f32).sin();
                let centre = Vec3::new(distance * angle.cos() + tremor, distance * angle.sin(), z - tremor);
                let centre = Position::nearest(centre).unwrap();
                let (tool, orientation) = (Tool::default(), Orientation::default());
                let sample = ToolSample { tick, tool, orientation, centre, side: Side::Outside };
                let press = conditions.press(&sample, last.as_ref());
                *last = Some(sample);
                press
            })
            .collect();
        origin.press(&presses, MethodKind::Plastic);
        if SnapshotClock::default().is_due(tick) {
            origin.publish();
        }
    }
    origin
}

/// The longest keyframe of a pot of 360 by 400 elements, bytes: what the project has set itself, as deep as hands press. Deeper it is more:
/// measured, and a twentieth.
const KEYFRAMES: [(f32, usize); 2] = [(2.5, 60_000), (4.0, 77_000)];

#[test]
fn a_keyframe_of_a_pot_that_four_tools_pressed_all_over_is_as_short_as_was_set_as_deep_as_hands_press() {
    for (depth_mm, most) in KEYFRAMES {
        let origin = pressed_all_over(depth_mm);
        let untouched = Pot::new(*origin.pot.spec()).unwrap();
        let [now, then] = [&origin.pot, &untouched].map(|pot| pot.surfaces()[0].radii_m());
        let changed = now.iter().zip(then).filter(|(now, then)| now != then).count();
        let [whole, alone] = [true, false].map(|goes_on| origin.author.keyframe(Version(0), goes_on));
        let what = format!("{depth_mm} mm: {changed} of {} elements changed, {} B", now.len(), whole.len());
        println!("{what}, {} B without what was learned", alone.len());
        assert!(changed * 10 > now.len() * 9, "{what}");
        assert!(whole.len() <= most, "{what}, allowed {most}");
        let mut replica = origin.replica();
        let latest = origin.author.latest();
        replica.apply_keyframe(latest, Version(0), &whole, true, &mut no_tiles(&origin.pot)).unwrap();
        assert_eq!(replica.digest(), origin.author.digest(), "{what}");
    }
}

proptest! {
    #[test]
    fn a_window_touches_the_tiles_of_its_elements_and_no_others(
        (columns, rows) in (17_u32..100, 17_u32..70),
        (first_column, wide) in (0_u32..1000, 0_u32..1000),
        (first_row, high) in (0_u32..1000, 0_u32..1000),
    ) {
        let shape = GridShape::new(columns, rows).unwrap();
        let first_row = first_row % rows;
        let window = Window {
            first_column: first_column % columns,
            columns: wide % (columns + 1),
            first_row,
            rows: high % (rows - first_row + 1),
        };
        let mut touched = Touched::none(std::iter::once(shape));
        touched.add_window(0, window);
        let layout = TileLayout::new(shape);
        for tile in 0..layout.tiles() {
            prop_assert_eq!(touched.holds(0, tile), window.meets(layout.window(tile), shape), "tile {}", tile);
        }
    }
}
