//! Samples as they travel: consecutive ticks of one tool in runs of small steps.
//!
//! The one place that turns samples into wire runs and back.
//! Invariant: what `unpack` makes of `pack`'s runs is what went in.

use alloc::vec::Vec;

use crate::prediction::Pending;
use crate::protocol::{Inputs, Run};
use crate::tool::{Position, Side, Sphere, ToolSample};
use crate::units::{Metres, Tick};

/// Most bytes of a packed sample: three zigzag varints of 16 bits.
const STEP_BYTES_MAX: usize = 9;
/// Most bytes of a run's head.
const RUN_BYTES_MAX: usize = 32;

/// A tool's radius in micrometres, as it travels.
pub(super) fn radius_um(tool: Sphere) -> u16 {
    libm::roundf(tool.radius().0 * 1e6) as u16
}

/// The tool of a radius in micrometres, if there is one.
pub(super) fn tool_of_um(radius_um: u16) -> Option<Sphere> {
    Sphere::new(Metres(f32::from(radius_um) * 1e-6)).ok()
}

/// Packs samples with consecutive numbers into at most about `bytes_max` bytes; says how many fitted.
pub(super) fn pack<'a>(samples: impl Iterator<Item = &'a Pending>, bytes_max: usize) -> (Inputs, u32) {
    let mut inputs = Inputs { first: 0, runs: Vec::new() };
    let mut last: Option<ToolSample> = None;
    let (mut bytes, mut count) = (8, 0);
    for Pending { sequence, sample } in samples {
        if count == 0 {
            inputs.first = *sequence;
        }
        let step = last.and_then(|last| step_between(&last, sample));
        bytes += if step.is_some() { STEP_BYTES_MAX } else { RUN_BYTES_MAX };
        if bytes > bytes_max && count > 0 {
            break;
        }
        match (step, inputs.runs.last_mut()) {
            (Some(step), Some(run)) => {
                run.steps.push(step);
                // most steps need one byte a coordinate
                bytes -= step.iter().filter(|along| along.unsigned_abs() <= 125).count() * 2;
            }
            _ => inputs.runs.push(Run {
                first_tick: sample.tick.0,
                tool_radius_um: radius_um(sample.tool),
                inside: sample.side == Side::Inside,
                start: sample.centre.0,
                steps: Vec::new(),
            }),
        }
        last = Some(*sample);
        count += 1;
    }
    (inputs, count)
}

fn step_between(last: &ToolSample, next: &ToolSample) -> Option<[i16; 3]> {
    if next.tick != last.tick.next() || next.tool != last.tool || next.side != last.side {
        return None;
    }
    let mut step = [0_i16; 3];
    for (along, (to, from)) in step.iter_mut().zip(next.centre.0.iter().zip(last.centre.0)) {
        *along = i16::try_from(to.checked_sub(from)?).ok()?;
    }
    Some(step)
}

/// The samples of a datagram with their numbers; `None` for one that makes no sense (no such tool or place).
pub(super) fn unpack(inputs: &Inputs) -> impl Iterator<Item = (u32, Option<ToolSample>)> + '_ {
    let samples = inputs.runs.iter().flat_map(|run| {
        let tool = tool_of_um(run.tool_radius_um);
        let side = if run.inside { Side::Inside } else { Side::Outside };
        let mut at = Some(run.start);
        core::iter::once([0; 3]).chain(run.steps.iter().copied()).enumerate().map(move |(number, step)| {
            at = at.and_then(|at| add(at, step));
            let centre = at.map(Position).filter(|centre| centre.is_within_reach())?;
            let tick = Tick(run.first_tick.checked_add(number as u64)?);
            Some(ToolSample { tick, tool: tool?, centre, side })
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
