//! Samples as they travel: consecutive ticks of one tool in runs of small steps.
//!
//! The one place that turns samples into wire runs and back.
//! Invariant: what `unpack` makes of `pack`'s runs is what went in.

use alloc::vec::Vec;

use crate::prediction::Pending;
use crate::protocol::{Inputs, Run, ShapeWire, Steps};
use crate::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample};
use crate::units::Tick;

/// Most bits of a run's head: tick, tool with its orientation, side, place, and of steps and turns a length, the length of their
/// bytes, three parameters and the rest of a byte.
const RUN_BITS_MAX: usize = 8 * 56;

/// Samples that are none in one message, each of three bits.
const NOTHING_MAX: u32 = 1024;

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

/// Packs samples with consecutive numbers into a message of at most about `bytes_max` bytes; says how many fitted.
#[must_use]
pub fn pack<'a>(samples: impl Iterator<Item = &'a Pending>, bytes_max: usize) -> (Inputs, u32) {
    let mut inputs = Inputs { first: 0, runs: Vec::new(), rests: false };
    let mut last: Option<ToolSample> = None;
    let (mut bits, mut count) = (64, 0);
    for Pending { sequence, sample } in samples {
        if count == 0 {
            inputs.first = *sequence;
        }
        let step = last.and_then(|last| step_between(&last, sample));
        // a run is of a tool that is held as it is or of one that turns
        let step = step.filter(|step| {
            inputs.runs.last().is_some_and(|run| run.turns.len() == run.steps.len() || step.turned == [0; 3])
        });
        let turns = step
            .is_some_and(|step| step.turned != [0; 3] || inputs.runs.last().is_some_and(|run| !run.turns.is_empty()));
        bits += match (step, inputs.runs.last()) {
            (Some(step), Some(run)) => {
                let behind = |steps: &Steps, now| Steps::bits_max(steps.last().copied().unwrap_or_default(), now);
                behind(&run.steps, step.moved) + if turns { behind(&run.turns, step.turned) } else { 0 }
            }
            _ => RUN_BITS_MAX,
        };
        if bits > bytes_max * 8 && count > 0 {
            break;
        }
        match (step, inputs.runs.last_mut()) {
            (Some(step), Some(run)) => {
                run.steps.push(step.moved);
                if turns {
                    run.turns.push(step.turned);
                }
            }
            _ => inputs.runs.push(Run {
                first_tick: sample.tick.0,
                tool: shape_of(sample.tool, sample.orientation),
                inside: sample.side == Side::Inside,
                start: sample.centre.0,
                steps: Steps::default(),
                turns: Steps::default(),
            }),
        }
        last = Some(*sample);
        count += 1;
    }
    (inputs, count)
}

/// As many samples as a message may stand for that are none: the server counts and refuses them, and goes on with the next number.
pub(super) fn nothing(first: u32, count: u32) -> Inputs {
    let steps = alloc::vec![[0; 3]; count.clamp(1, NOTHING_MAX) as usize - 1];
    let tool = ShapeWire::Sphere { radius_um: 0 };
    let run =
        Run { first_tick: 0, tool, inside: false, start: [0; 3], steps: Steps::from(steps), turns: Steps::default() };
    Inputs { first, runs: alloc::vec![run], rests: false }
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

/// The samples of a datagram with their numbers; `None` for one that makes no sense (no such tool, place or turn).
pub(super) fn unpack(inputs: &Inputs) -> impl Iterator<Item = (u32, Option<ToolSample>)> + '_ {
    let samples = inputs.runs.iter().flat_map(|run| {
        let held = tool_of(run.tool).filter(|(tool, _)| {
            run.turns.is_empty() || (tool.sphere().is_none() && run.turns.len() == run.steps.len())
        });
        let side = if run.inside { Side::Inside } else { Side::Outside };
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
            let tick = Tick(run.first_tick.checked_add(number as u64)?);
            let (tool, _) = held?;
            Some(ToolSample { tick, tool, orientation, centre, side })
        })
    });
    // numbers wrap, and a range that starts at the last one would overflow
    samples.enumerate().map(|(at, sample)| (inputs.first.wrapping_add(at as u32), sample))
}

fn add(at: [i32; 3], step: [i16; 3]) -> Option<[i32; 3]> {
    Some([
        at[0].checked_add(i32::from(step[0]))?,
        at[1].checked_add(i32::from(step[1]))?,
        at[2].checked_add(i32::from(step[2]))?,
    ])
}
