//! Samples as they travel: consecutive ticks of one tool in runs of small steps.
//!
//! The one place that turns samples into wire runs and back.
//! Invariant: what `unpack` makes of `pack`'s runs is what went in.

use alloc::vec::Vec;

use crate::prediction::Pending;
use crate::protocol::{self, Inputs, Run, ShapeWire};
use crate::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample};
use crate::units::Tick;

/// Most samples in one message.
const SAMPLES_MAX: u32 = 1024;

/// The tool of a sample as it travels.
pub(super) fn shape_of(tool: Tool, orientation: Orientation) -> ShapeWire {
    match tool {
        Tool::Sphere(sphere) => ShapeWire::Sphere { radius_um: sphere.micrometres() },
        Tool::Convex(Shape(shape)) => ShapeWire::Convex { shape, orientation: orientation.0 },
    }
}

/// The tool that travelled, if there is such a one; which convex ones there are the rack knows.
pub(super) fn tool_of(wire: ShapeWire) -> Option<(Tool, Orientation)> {
    match wire {
        ShapeWire::Sphere { radius_um } => {
            let sphere = Sphere::of_micrometres(radius_um)?;
            Some((sphere.into(), Orientation::default()))
        }
        ShapeWire::Convex { shape, orientation } => Some((Tool::Convex(Shape(shape)), Orientation(orientation))),
    }
}

/// What lies between two samples of a run.
#[derive(Clone, Copy)]
struct Step {
    moved: [i16; 3],
    turned: [i16; 3],
}

/// Samples with consecutive numbers, made into a message.
#[derive(Clone, Debug)]
pub struct Packed {
    /// The message.
    pub inputs: Inputs,
    /// How many of the samples are in it.
    pub count: u32,
    /// Bytes that it takes.
    pub bytes: usize,
}

/// Packs as many of the samples, from the first on, as fit into about `bytes_max` bytes; of no more than 1024.
#[must_use]
pub fn pack<'a>(samples: impl Iterator<Item = &'a Pending> + Clone, bytes_max: usize) -> Packed {
    let mut most = SAMPLES_MAX;
    loop {
        let (inputs, count) = runs_of(samples.clone().take(most as usize));
        let bytes = protocol::encode(&inputs).len();
        if bytes <= bytes_max || count <= 1 {
            return Packed { inputs, count, bytes };
        }
        // what each takes is known by now, and a little more is left out
        most = (count * bytes_max as u32 / bytes as u32).min(count - 1) * 15 / 16;
        most = most.max(1);
    }
}

/// All of the samples in runs, and how many they are.
fn runs_of<'a>(samples: impl Iterator<Item = &'a Pending>) -> (Inputs, u32) {
    let mut inputs = Inputs { first: 0, runs: Vec::new(), rests: false };
    let mut last: Option<ToolSample> = None;
    let mut count = 0;
    for Pending { sequence, sample } in samples {
        if count == 0 {
            inputs.first = *sequence as u16;
        }
        count += 1;
        let before = last.replace(*sample);
        let step = before.and_then(|before| step_between(&before, sample));
        if let (Some(step), Some(run)) = (step, inputs.runs.last_mut()) {
            // a run is of a tool that is held as it is or of one that turns
            let turns = !run.turns.is_empty() || step.turned != [0; 3];
            if run.turns.len() == run.steps.len() || step.turned == [0; 3] {
                run.steps.push(step.moved);
                if turns {
                    run.turns.push(step.turned);
                }
                continue;
            }
        }
        inputs.runs.push(Run {
            first_tick: sample.tick.0 as u16,
            tool: shape_of(sample.tool, sample.orientation),
            inside: sample.side == Side::Inside,
            start: sample.centre.0,
            steps: Vec::new(),
            turns: Vec::new(),
        });
    }
    (inputs, count)
}

/// As many samples as a message may stand for that are none: the server counts and refuses them, and goes on with the next number.
pub(super) fn nothing(first: u32, count: u32) -> Inputs {
    let steps = alloc::vec![[0; 3]; count.clamp(1, SAMPLES_MAX) as usize - 1];
    let tool = ShapeWire::Sphere { radius_um: 0 };
    let run = Run { first_tick: 0, tool, inside: false, start: [0; 3], steps, turns: Vec::new() };
    Inputs { first: first as u16, runs: alloc::vec![run], rests: false }
}

fn step_between(last: &ToolSample, next: &ToolSample) -> Option<Step> {
    if next.tick != last.tick.next() || next.tool != last.tool || next.side != last.side {
        return None;
    }
    let mut moved = [0_i16; 3];
    for (along, (to, from)) in moved.iter_mut().zip(next.centre.0.iter().zip(last.centre.0)) {
        *along = i16::try_from(to.checked_sub(from)?).ok()?;
    }
    let mut turned = [0_i16; 3];
    if let Tool::Convex(_) = next.tool {
        for (about, (to, from)) in turned.iter_mut().zip(next.orientation.0.iter().zip(last.orientation.0)) {
            *about = to.wrapping_sub(from);
        }
    }
    Some(Step { moved, turned })
}

/// The number nearest to another of which these are the lowest 16 bits.
pub(super) const fn number_near(next: u32, lowest: u16) -> u32 {
    next.wrapping_add(lowest.wrapping_sub(next as u16) as i16 as u32)
}

/// The samples of a datagram with their numbers, near the `next` one that is waited for and around `now`; `None` for one that
/// makes no sense (no such tool, place or turn).
pub(super) fn unpack(inputs: &Inputs, next: u32, now: Tick) -> impl Iterator<Item = (u32, Option<ToolSample>)> + '_ {
    let samples = inputs.runs.iter().flat_map(move |run| {
        let held = tool_of(run.tool);
        let side = if run.inside { Side::Inside } else { Side::Outside };
        let first_tick = now.nearest(run.first_tick);
        let mut at = Some(run.start);
        let mut orientation = held.map_or_else(Orientation::default, |(_, orientation)| orientation);
        let turns = core::iter::once([0; 3]).chain(run.turns.iter().copied()).chain(core::iter::repeat([0; 3]));
        let steps = core::iter::once([0; 3]).chain(run.steps.iter().copied());
        steps.zip(turns).enumerate().map(move |(number, (step, turn))| {
            at = at.and_then(|at| add(at, step));
            for (angle, by) in orientation.0.iter_mut().zip(turn) {
                *angle = angle.wrapping_add(by);
            }
            let centre = at.map(Position).filter(|centre| centre.is_within_reach())?;
            let tick = Tick(first_tick.0.checked_add(number as u64)?);
            let (tool, _) = held?;
            Some(ToolSample { tick, tool, orientation, centre, side })
        })
    });
    // numbers wrap, and a range that starts at the last one would overflow
    let first = number_near(next, inputs.first);
    samples.enumerate().map(move |(at, sample)| (first.wrapping_add(at as u32), sample))
}

fn add(at: [i32; 3], step: [i16; 3]) -> Option<[i32; 3]> {
    Some([
        at[0].checked_add(i32::from(step[0]))?,
        at[1].checked_add(i32::from(step[1]))?,
        at[2].checked_add(i32::from(step[2]))?,
    ])
}
