//! What was pressed, told again: the transcript is read as it was written, bytes that say anything else are refused or press
//! sound samples, and who presses it again holds the author's clay.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::Vec3;
use pottery_shared::clay::{Conditions, GridShape, MethodKind, Pot, PotSpec, SubStep, Surface, Wheel};
use pottery_shared::snapshot::{
    Author, Moment, Pressed, Replica, SnapshotClock, SnapshotError, Touched, Transcript, Version,
};
use pottery_shared::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};
use proptest::prelude::*;

/// A hand that strokes up and down the pot, the second one opposite the first.
fn hand(client: u16, tick: u64) -> ToolSample {
    let seconds = tick as f32 * 1e-3;
    let along = 60.0 + 71.0 * if client == 1 { 0.0 } else { 1.0 };
    let depth = 70.0 - 2.0 * (seconds * 1.3).sin().abs();
    let angle = if client == 1 { 0.0 } else { core::f32::consts::PI };
    let at_mm = Vec3::new(depth * angle.cos(), depth * angle.sin(), along + 40.0 * (seconds * 0.9).sin());
    let tool = if client == 2 { Tool::Convex(Shape::RIB) } else { Sphere::default().into() };
    let orientation = Orientation([if client == 2 { (tick * 3) as i16 } else { 0 }; 3]);
    let centre = Position::nearest(at_mm * 1e-3).unwrap();
    ToolSample { tick: Tick(tick), tool, orientation, centre, side: Side::Outside }
}

/// Both ends of a wheel, and what is told between them.
struct Wheelside {
    conditions: Conditions,
    pot: Pot,
    author: Author,
    touched: Touched,
    substep: SubStep,
    transcript: Transcript,
    last: [Option<ToolSample>; 2],
}

fn no_tiles(pot: &Pot) -> Touched {
    Touched::none(pot.surfaces().iter().map(Surface::shape))
}

impl Wheelside {
    fn new(spec: PotSpec) -> Self {
        let mut pot = Pot::new(spec).unwrap();
        let wheel = Wheel::starting_at(Tick(0), Default::default(), Wheel::rate_of(Rpm(90.0)));
        Self {
            conditions: Conditions { wheel, method: MethodKind::Plastic, ..Conditions::default() },
            author: Author::new(&mut pot),
            touched: no_tiles(&pot),
            pot,
            substep: SubStep::for_grid(spec.shape),
            transcript: Transcript::default(),
            last: [None; 2],
        }
    }

    fn press(&mut self, samples: &[(u16, ToolSample)]) {
        let told: Vec<Pressed> = samples
            .iter()
            .map(|&(client, sample)| {
                let last = self.last[usize::from(client) - 1].replace(sample);
                Pressed { client, sample, before: last.filter(|last| sample.follows(last)) }
            })
            .collect();
        let presses: Vec<_> =
            told.iter().map(|told| self.conditions.press(&told.sample, told.before.as_ref())).collect();
        let touched = &mut self.touched;
        self.substep.advance(&mut self.pot, &presses, self.conditions.method, |surface, window| {
            touched.add_window(surface, window);
        });
        assert!(self.transcript.add(told));
    }
}

/// What two hands press in `ticks`; every third sample of the second one is late by a tick and pressed with the next.
fn session(ticks: u64, mut at_snapshot: impl FnMut(&mut Wheelside, Tick)) {
    let spec = PotSpec { shape: GridShape::new(180, 200).unwrap(), ..PotSpec::default() };
    let mut side = Wheelside::new(spec);
    let mut late = None;
    for tick in 1..=ticks {
        let mut now = vec![(1, hand(1, tick))];
        if let Some(sample) = late.take() {
            side.press(&[(2, sample)]);
        }
        if tick.is_multiple_of(3) {
            late = Some(hand(2, tick));
        } else {
            now.push((2, hand(2, tick)));
        }
        side.press(&now);
        if SnapshotClock::default().is_due(Tick(tick)) {
            at_snapshot(&mut side, Tick(tick));
            side.transcript.clear();
        }
    }
}

#[test]
fn pressed_again_it_is_the_author_s_clay() {
    let mut replica: Option<Replica> = None;
    let (mut substep, mut since, mut told_bytes, mut delta_bytes, mut snapshots) =
        (SubStep::for_grid(GridShape::new(180, 200).unwrap()), Tick(0), 0, 0, 0);
    session(700, |side, tick| {
        let replica = replica.get_or_insert_with(|| Replica::new(Pot::new(*side.pot.spec()).unwrap()));
        let bytes = side.transcript.encode(since);
        let transcript = Transcript::decode(&bytes, since).unwrap();
        assert_eq!(transcript, side.transcript);
        let now = Moment { tick, phase: side.conditions.phase(tick) };
        let delta = side.author.publish(&mut side.pot, &mut side.touched, now).unwrap();
        let mut touched = no_tiles(&side.pot);
        // now and then it goes over to deltas, to which a keyframe leads
        match snapshots % 5 {
            3 => {
                let refused = replica.apply_delta(delta.version, &delta.bytes, &mut touched);
                assert_eq!(refused, Err(SnapshotError::Unlearned { delta: delta.version }));
                let have = replica.version();
                let keyframe = side.author.keyframe(have, true);
                replica.apply_keyframe(delta.version, have, &keyframe, true, &mut touched).unwrap();
            }
            4 => replica.apply_delta(delta.version, &delta.bytes, &mut touched).unwrap(),
            _ => {
                let conditions = &side.conditions;
                replica.retell(delta.version, &transcript, conditions, &mut substep, &mut touched).unwrap();
            }
        }
        assert_eq!(replica.digest(), side.author.digest(), "after {tick}");
        assert_eq!(replica.pot(), &side.pot, "after {tick}");
        assert!(!touched.is_empty());
        (told_bytes, delta_bytes, snapshots) =
            (told_bytes + bytes.len(), delta_bytes + delta.bytes.len(), snapshots + 1);
        since = tick;
    });
    let (told, deltas) = (told_bytes / snapshots, delta_bytes / snapshots);
    println!("two hands, bytes a snapshot: told {told}, as tiles that changed {deltas}");
    // a sample a tick and hand, three axes at about a bit each, and two heads
    assert!(told < 100, "{told}");
    assert!(told * 4 < deltas, "{told} against {deltas}");
}

#[test]
fn a_version_that_does_not_follow_is_refused() {
    let pot = Pot::new(PotSpec { shape: GridShape::new(72, 61).unwrap(), ..PotSpec::default() }).unwrap();
    let (mut touched, mut substep) = (no_tiles(&pot), SubStep::for_grid(pot.spec().shape));
    let mut replica = Replica::new(pot);
    let digest = replica.digest();
    let (nothing, conditions) = (Transcript::default(), Conditions::default());
    let refused = replica.retell(Version(2), &nothing, &conditions, &mut substep, &mut touched);
    assert_eq!(refused, Err(SnapshotError::NotNext { delta: Version(2), held: Version(0) }));
    assert_eq!(replica.digest(), digest);
}

#[test]
fn too_long_a_transcript_says_so_and_stays_as_it_was() {
    let mut transcript = Transcript::default();
    let told = |tick| Pressed { client: 1, sample: hand(1, tick), before: None };
    for tick in 0..Transcript::SUB_STEPS_MAX as u64 {
        assert!(transcript.add([told(tick)]));
    }
    let before = transcript.clone();
    assert!(!transcript.add([told(9999)]));
    assert_eq!(transcript, before);
    assert_eq!(Transcript::decode(&transcript.encode(Tick(0)), Tick(0)), Some(transcript));
}

fn sample() -> impl Strategy<Value = ToolSample> {
    let place = prop::array::uniform3(-100_000_i32..=100_000);
    let tool = prop_oneof![
        (500_u16..=40_000).prop_map(|um| Tool::Sphere(Sphere::of_micrometres(um).unwrap())),
        (0_u8..4).prop_map(|number| Tool::Convex(Shape(number))),
    ];
    (1000_u64..3000, tool, prop::array::uniform3(any::<i16>()), place, any::<bool>()).prop_map(
        |(tick, tool, orientation, centre, inside)| ToolSample {
            tick: Tick(tick),
            tool,
            // of a sphere nothing is told
            orientation: if tool.sphere().is_some() { Orientation::default() } else { Orientation(orientation) },
            centre: Position(centre),
            side: if inside { Side::Inside } else { Side::Outside },
        },
    )
}

/// Sub-steps of anything: hands that jump, change tools and come late, and some that go on.
fn transcript() -> impl Strategy<Value = Transcript> {
    let step = prop::collection::vec((any::<u16>(), sample(), any::<bool>()), 0..4);
    prop::collection::vec((step, any::<bool>()), 0..12).prop_map(|steps| {
        let mut transcript = Transcript::default();
        let mut last: Vec<Pressed> = Vec::new();
        for (step, goes_on) in steps {
            let mut now: Vec<Pressed> = Vec::new();
            if goes_on {
                now.extend(last.iter().map(|pressed| {
                    let before = pressed.sample;
                    let sample = ToolSample { tick: before.tick.next(), ..before };
                    Pressed { sample, before: Some(before), ..*pressed }
                }));
            } else {
                for (client, sample, came) in step {
                    if now.iter().all(|pressed| pressed.client != client) {
                        let before = ToolSample { tick: sample.tick.offset(-2), ..sample };
                        now.push(Pressed { client, sample, before: came.then_some(before) });
                    }
                }
            }
            assert!(transcript.add(now.iter().copied()));
            last = now;
        }
        transcript
    })
}

proptest! {
    #[test]
    fn what_is_written_is_read(transcript in transcript(), since in 900_u64..3100) {
        let bytes = transcript.encode(Tick(since));
        prop_assert_eq!(Transcript::decode(&bytes, Tick(since)), Some(transcript));
    }

    #[test]
    fn other_bytes_are_refused_or_sound(
        transcript in transcript(),
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
        cut in any::<prop::sample::Index>(),
    ) {
        let mut bytes = transcript.encode(Tick(1000));
        bytes.push(0x55);
        for (at, value) in changes {
            let at = at.index(bytes.len());
            bytes[at] = value;
        }
        bytes.truncate(cut.index(bytes.len()) + 1);
        if let Some(read) = Transcript::decode(&bytes, Tick(1000)) {
            for pressed in read.sub_steps().flatten() {
                prop_assert!(pressed.sample.centre.is_within_reach());
                prop_assert!(pressed.before.is_none_or(|before| pressed.sample.follows(&before)));
            }
        }
    }

    #[test]
    fn any_bytes_end(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let read = Transcript::decode(&bytes, Tick(0));
        prop_assert!(read.is_none_or(|read| read.sub_steps().count() <= Transcript::SUB_STEPS_MAX));
    }
}
