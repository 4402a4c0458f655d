//! What the clay of one wheel costs on its way: a snapshot's change, what was pressed, and a keyframe, written and read.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench codec`. One hand that never rests, for ten seconds at
//! 60 rpm, as deep as a hand of 3.3 N comes and then deeper, at the depths of `tests/tests/room/payload.rs`; each snapshot is written and read in turn, and rounded by a second author that tells nobody, so that what the
//! codec takes is told apart from what the clay takes.

use std::time::Instant;

use glam::Vec3;
use pottery_shared::clay::{Conditions, Method, MethodKind, Phase, Pot, PotSpec, SubStep, Surface, Wheel};
use pottery_shared::snapshot::{Author, Moment, Pressed, Replica, SnapshotClock, Touched, Transcript, Version};
use pottery_shared::tool::{Orientation, Position, Side, Tool, ToolSample};
use pottery_shared::units::{Rpm, Tick};

type Fault = Box<dyn std::error::Error>;

const TICKS: u64 = 10_000;
/// Snapshots before which nothing is counted: models learn.
const WARM: usize = 60;

/// Figures of one kind, sorted when they are told.
struct Figures {
    name: &'static str,
    unit: &'static str,
    values: Vec<f64>,
}

impl Figures {
    const fn new(name: &'static str, unit: &'static str) -> Self {
        Self { name, unit, values: Vec::new() }
    }

    fn tell(&mut self) {
        self.values.drain(..WARM.min(self.values.len() / 4));
        self.values.sort_by(f64::total_cmp);
        let at = |share: f64| self.values[((self.values.len() - 1) as f64 * share) as usize];
        let mean = self.values.iter().sum::<f64>() / self.values.len() as f64;
        let (name, unit) = (self.name, self.unit);
        println!(
            "{name:<44} least {:>8.1} p50 {:>8.1} p99 {:>8.1} mean {mean:>8.1} {unit}",
            self.values[0],
            at(0.5),
            at(0.99)
        );
    }
}

fn us(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e6
}

/// A hand that strokes up and down, 1.5 mm deeper at one time than at another.
fn hand(tick: u64, depth_mm: f32) -> Option<ToolSample> {
    let time = tick as f32 * 1e-3;
    let distance = 0.0735 - depth_mm * 1e-3 - 0.0015 * (time * 2.0).sin().abs();
    let centre = Position::nearest(Vec3::new(distance, 0.0, 0.1 + 0.04 * time.sin()))?;
    let (tool, orientation) = (Tool::default(), Orientation::default());
    Some(ToolSample { tick: Tick(tick), tool, orientation, centre, side: Side::Outside })
}

fn main() -> Result<(), Fault> {
    for (depth_mm, name) in [(2.5, "as deep as hands press"), (4.0, "deep")] {
        println!("one tool, {name}: {depth_mm} mm at the most");
        strokes(depth_mm)?;
    }
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load averages at the end: {}", load.trim());
    Ok(())
}

fn strokes(depth_mm: f32) -> Result<(), Fault> {
    let method = MethodKind::default();
    let spec = PotSpec { keeps_volume: method.keeps_volume(), ..PotSpec::default() };
    let mut pot = Pot::new(spec)?;
    let mut author = Author::new(&mut pot);
    let mut silent = author.clone();
    let mut replica = Replica::new(Pot::new(spec)?);
    let no_tiles = || Touched::none(pot.surfaces().iter().map(Surface::shape));
    let (mut touched, mut news) = (no_tiles(), no_tiles());
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(60.0)));
    let conditions = Conditions { wheel, method, ..Conditions::default() };
    let mut step = SubStep::for_grid(spec.shape);
    let (mut transcript, mut before, mut since) = (Transcript::default(), None, Tick(0));
    let mut rounded = Figures::new("rounding a snapshot, told to nobody", "µs");
    let mut written = Figures::new("rounding and writing it", "µs");
    let mut read = Figures::new("reading and applying it", "µs");
    let mut writing = Figures::new("writing it, without rounding", "µs");
    let mut codec = Figures::new("writing and reading, without rounding", "µs");
    let mut bytes = Figures::new("bytes of it", "B");
    let mut changed = Figures::new("elements that changed", "");
    let mut held = vec![Vec::new(); pot.surfaces().len()];
    let mut told = Figures::new("writing and reading what was pressed", "µs");
    let mut told_bytes = Figures::new("bytes of that", "B");
    for tick in 1..=TICKS {
        let sample = hand(tick, depth_mm).ok_or("a place out of reach")?;
        let press = conditions.press(&sample, before.as_ref());
        step.advance(&mut pot, &[press], method, |surface, window| touched.add_window(surface, window));
        transcript.add([Pressed { client: 0, sample, before }]);
        before = Some(sample);
        let now = Moment { tick: Tick(tick), phase: conditions.phase(Tick(tick)) };
        if !SnapshotClock::default().is_due(now.tick) {
            continue;
        }
        let (mut twin, mut twins) = (pot.clone(), touched.clone());
        let begun = Instant::now();
        silent.publish_untold(&mut twin, &mut twins, now);
        let rounding_us = us(begun);
        let begun = Instant::now();
        let delta = author.publish(&mut pot, &mut touched, now).ok_or("nothing has changed")?;
        let writing_us = us(begun);
        let begun = Instant::now();
        replica.apply_delta(delta.version, &delta.bytes, &mut news)?;
        let reading_us = us(begun);
        news.clear();
        changed.values.push(differing(replica.pot(), &mut held) as f64);
        let begun = Instant::now();
        let words = transcript.encode(since);
        let heard = Transcript::decode(&words, since).ok_or("no transcript")?;
        told.values.push(us(begun));
        if heard != transcript || replica.digest() != author.digest() {
            return Err("what was read is not what was written".into());
        }
        transcript.clear();
        since = now.tick;
        rounded.values.push(rounding_us);
        written.values.push(writing_us);
        read.values.push(reading_us);
        writing.values.push(writing_us - rounding_us);
        codec.values.push(writing_us + reading_us - rounding_us);
        bytes.values.push(delta.bytes.len() as f64);
        told_bytes.values.push(words.len() as f64);
    }
    let clay = [&mut rounded, &mut written, &mut writing, &mut read, &mut codec, &mut bytes, &mut changed];
    for figures in clay.into_iter().chain([&mut told, &mut told_bytes]) {
        figures.tell();
    }
    keyframes(&author, spec)
}

/// Elements that are not what they were, which are then as they are.
fn differing(pot: &Pot, held: &mut [Vec<f32>]) -> usize {
    let mut count = 0;
    for (surface, held) in pot.surfaces().iter().zip(held) {
        held.resize(surface.radii_m().len(), 0.0);
        for (is, was) in surface.radii_m().iter().zip(held.iter_mut()) {
            count += usize::from(is.to_bits() != was.to_bits());
            *was = *is;
        }
    }
    count
}

/// The whole pot for who joins, with what deltas build upon.
fn keyframes(author: &Author, spec: PotSpec) -> Result<(), Fault> {
    let mut written = Figures::new("writing a keyframe of the whole pot", "µs");
    let mut read = Figures::new("reading and applying it", "µs");
    let mut bytes = Figures::new("bytes of it", "B");
    for _ in 0..50 {
        let begun = Instant::now();
        let keyframe = author.keyframe(Version(0), true);
        written.values.push(us(begun));
        let mut replica = Replica::new(Pot::new(spec)?);
        let mut news = Touched::none(replica.pot().surfaces().iter().map(Surface::shape));
        let begun = Instant::now();
        replica.apply_keyframe(author.latest(), Version(0), &keyframe, true, &mut news)?;
        read.values.push(us(begun));
        bytes.values.push(keyframe.len() as f64);
        if replica.digest() != author.digest() {
            return Err("what was read is not what was written".into());
        }
    }
    for figures in [&mut written, &mut read, &mut bytes] {
        figures.tell();
    }
    Ok(())
}
