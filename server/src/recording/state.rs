//! How everything at a wheel stands, as the bytes of a block.
//!
//! Owns the order of the fields; radii are the record's own planes ([`PotRecord::planes`]).
//! Invariant: what is read from written bytes is what was written; other bytes give a state that a wheel can be in, or nothing.

use pottery_shared::clay::{Conditions, GridShape, Material, MethodKind, Phase, PotSpec, Schedule, Support, Wheel};
use pottery_shared::room::WheelState;
use pottery_shared::snapshot::PotRecord;
use pottery_shared::tool::ToolSample;
use pottery_shared::units::{Metres, Tick};

use super::entries::{Bytes, put_clay, put_mesh, put_number, put_sample, put_signed, put_tile};
use super::format::VERSION_FOLDS;

/// The bytes of a state at a tick.
pub(super) fn write(tick: Tick, state: &WheelState) -> Vec<u8> {
    let mut out = Vec::new();
    let spec = state.pot.spec();
    out.extend(spec.shape.columns().to_le_bytes());
    out.extend(spec.shape.rows().to_le_bytes());
    out.extend([spec.height.0, spec.radius.0, spec.wall.0].into_iter().flat_map(f32::to_le_bytes));
    out.extend([u8::from(spec.keeps_volume), spec.support.number(), state.conditions.method.number(), 0]);
    write_conditions(&mut out, tick, &state.conditions);
    put_number(&mut out, state.brought.len() as u64);
    for (shape, mesh) in &state.brought {
        out.push(*shape);
        put_mesh(&mut out, mesh);
    }
    put_number(&mut out, state.people.len() as u64);
    for (client, sample) in &state.people {
        put_number(&mut out, (*client).into());
        out.push(sample.is_some().into());
        if let Some(sample) = sample {
            put_sample(&mut out, tick, sample);
        }
    }
    put_number(&mut out, state.folds.len() as u64);
    for (surface, tile, steps) in &state.folds {
        put_tile(&mut out, *surface, *tile, steps);
    }
    out.extend(state.pot.planes());
    out
}

fn write_conditions(out: &mut Vec<u8>, tick: Tick, conditions: &Conditions) {
    put_number(out, conditions.wheel.segments().count() as u64);
    for (number, (from, phase, rate)) in conditions.wheel.segments().enumerate() {
        put_signed(out, from.since(tick));
        put_signed(out, rate.into());
        if number == 0 {
            out.extend(phase.0.to_le_bytes());
        }
    }
    let materials: Vec<_> = conditions.material.entries().collect();
    put_number(out, materials.len() as u64);
    for (from, clay) in materials {
        put_signed(out, from.since(tick));
        put_clay(out, &clay);
    }
}

/// The state in the bytes of a block of that tick, in a file of that version.
pub(super) fn read(version: u32, tick: Tick, bytes: &[u8]) -> Option<WheelState> {
    let mut bytes = Bytes(bytes);
    let [columns, rows] = [u32::from_le_bytes(bytes.array()?), u32::from_le_bytes(bytes.array()?)];
    let shape = GridShape::new(columns, rows).ok()?;
    let [height, radius, wall] = [Metres(bytes.f32()?), Metres(bytes.f32()?), Metres(bytes.f32()?)];
    let keeps_volume = match bytes.u8()? {
        0 => false,
        1 => true,
        _ => return None,
    };
    let [support, method, 0] = bytes.array()? else { return None };
    let support = Some(Support::from_number(support)).filter(|known| known.number() == support)?;
    let method = Some(MethodKind::from_number(method)).filter(|known| known.number() == method)?;
    let spec = PotSpec { shape, height, radius, wall, keeps_volume, support };
    let conditions = Conditions { wheel: wheel(&mut bytes, tick)?, material: material(&mut bytes, tick)?, method };
    let brought = (0..bytes.count(3)?).map(|_| Some((bytes.u8()?, bytes.mesh()?))).collect::<Option<_>>()?;
    let people = people(&mut bytes, tick)?;
    let tiles = if version >= VERSION_FOLDS { bytes.count(3)? } else { 0 };
    let folds = (0..tiles).map(|_| bytes.tile()).collect::<Option<_>>()?;
    let pot = PotRecord::of_planes(spec, bytes.0).ok()?;
    Some(WheelState { pot, folds, conditions, brought, people })
}

fn wheel(bytes: &mut Bytes<'_>, tick: Tick) -> Option<Wheel> {
    let fastest = Wheel::rate_of(Wheel::RPM_MAX);
    let mut wheel: Option<Wheel> = None;
    for _ in 0..bytes.count(2)? {
        let from = bytes.tick(tick)?;
        let rate = i32::try_from(bytes.signed()?).ok().filter(|rate| rate.unsigned_abs() <= fastest.unsigned_abs())?;
        match &mut wheel {
            None => wheel = Some(Wheel::starting_at(from, Phase(u32::from_le_bytes(bytes.array()?)), rate)),
            Some(wheel) => wheel.schedule(from, rate),
        }
    }
    wheel
}

fn material(bytes: &mut Bytes<'_>, tick: Tick) -> Option<Schedule<Material>> {
    let mut schedule: Option<Schedule<_>> = None;
    for _ in 0..bytes.count(13)? {
        let (from, clay) = (bytes.tick(tick)?, bytes.clay()?);
        match &mut schedule {
            None => schedule = Some(Schedule::new(clay)),
            Some(schedule) => schedule.set(from, clay),
        }
    }
    schedule
}

fn people(bytes: &mut Bytes<'_>, tick: Tick) -> Option<Vec<(u16, Option<ToolSample>)>> {
    (0..bytes.count(2)?)
        .map(|_| {
            let client = bytes.client()?;
            let sample = match bytes.u8()? {
                0 => None,
                1 => Some(bytes.sample(tick)?),
                _ => return None,
            };
            Some((client, sample))
        })
        .collect()
}
