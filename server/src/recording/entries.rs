//! What happened, as the bytes of a block: small numbers for what goes on as it went.
//!
//! Owns numbers of variable length and the coding of hands; whether what is told can have happened is the replay's affair.
//! Invariant: what is read from written bytes is what was written; other bytes give some entries or nothing.

use std::collections::BTreeMap;
use std::sync::Arc;

use pottery_shared::clay::{Material, Strength};
use pottery_shared::protocol::MeshWire;
use pottery_shared::room::Happening;
use pottery_shared::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample};
use pottery_shared::units::{Seconds, Tick};

use super::format::TICK_MAX;

const CAME: u8 = 1;
const LEFT: u8 = 2;
const WHEEL: u8 = 3;
const CLAY: u8 = 4;
const TOOL: u8 = 5;
const PRESSED: u8 = 6;
const SNAPSHOT: u8 = 7;
const REPLACED: u8 = 8;

/// A hand that is told of for the first time in a block, or does something else than before.
const ANEW: u8 = 0;
/// The next tick of the same tool, turned as before.
const GOES_ON: u8 = 1;
/// The next tick of the same tool, turned.
const TURNS_ON: u8 = 2;

/// Appends an unsigned number, seven bits a byte, lowest first.
pub(super) fn put_number(out: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

/// Appends a signed number d as 2d, or −2d − 1 when it is negative.
pub(super) fn put_signed(out: &mut Vec<u8>, number: i64) {
    put_number(out, ((number << 1) ^ (number >> 63)) as u64);
}

pub(super) fn put_clay(out: &mut Vec<u8>, clay: &Material) {
    let numbers = [clay.viscosity.0, clay.strength.youngs_pa, clay.strength.yield_pa];
    out.extend(numbers.into_iter().flat_map(f32::to_le_bytes));
}

pub(super) fn put_mesh(out: &mut Vec<u8>, mesh: &MeshWire) {
    put_number(out, mesh.corners_m.len() as u64);
    out.extend(mesh.corners_m.iter().flatten().flat_map(|along| along.to_le_bytes()));
    put_number(out, mesh.facets.len() as u64);
    out.extend(mesh.facets.iter().flatten().flat_map(|corner| corner.to_le_bytes()));
}

/// Appends a sample of which nothing is known but a tick near it.
pub(super) fn put_sample(out: &mut Vec<u8>, near: Tick, sample: &ToolSample) {
    put_signed(out, sample.tick.since(near));
    out.push(u8::from(sample.side == Side::Inside));
    match sample.tool {
        Tool::Sphere(sphere) => {
            out.push(0);
            out.extend(sphere.micrometres().to_le_bytes());
        }
        Tool::Convex(Shape(shape)) => {
            out.extend([1, shape]);
            out.extend(sample.orientation.0.iter().flat_map(|angle| angle.to_le_bytes()));
        }
    }
    for along in sample.centre.0 {
        put_signed(out, along.into());
    }
}

/// Appends a tile: each radius as what it is more than the one before.
pub(super) fn put_tile(out: &mut Vec<u8>, surface: u8, tile: u32, steps: &[u16]) {
    out.push(surface);
    put_number(out, tile.into());
    put_number(out, steps.len() as u64);
    let mut before = 0;
    for &step in steps {
        put_signed(out, i64::from(step) - i64::from(before));
        before = step;
    }
}

/// A hand as the block last told of it.
#[derive(Clone, Copy, Debug)]
struct Hand {
    last: ToolSample,
    /// Along each axis, in steps a tick.
    velocity: [i32; 3],
}

impl Hand {
    const fn at(sample: ToolSample) -> Self {
        Self { last: sample, velocity: [0; 3] }
    }

    fn goes_on_to(&self, sample: &ToolSample) -> bool {
        sample.tick == self.last.tick.next() && sample.tool == self.last.tool && sample.side == self.last.side
    }

    /// Where it is expected next along an axis.
    const fn expected(&self, axis: usize) -> i32 {
        self.last.centre.0[axis].wrapping_add(self.velocity[axis])
    }

    fn move_to(&mut self, sample: ToolSample) {
        for (velocity, (to, from)) in self.velocity.iter_mut().zip(sample.centre.0.iter().zip(self.last.centre.0)) {
            *velocity = to.wrapping_sub(from);
        }
        self.last = sample;
    }
}

/// Writes the entries of one block.
#[derive(Debug)]
pub(super) struct EntryWriter {
    out: Vec<u8>,
    tick: Tick,
    hands: BTreeMap<u16, Hand>,
}

impl EntryWriter {
    pub(super) const fn starting_at(first: Tick) -> Self {
        Self { out: Vec::new(), tick: first, hands: BTreeMap::new() }
    }

    pub(super) const fn len(&self) -> usize {
        self.out.len()
    }

    pub(super) fn into_bytes(self) -> Vec<u8> {
        self.out
    }

    /// Appends an entry; how everything stands has a block of its own and is not for here.
    pub(super) fn put(&mut self, tick: Tick, what: &Happening) {
        put_number(&mut self.out, tick.0 - self.tick.0);
        self.tick = tick;
        let out = &mut self.out;
        match what {
            Happening::State(_) => unreachable!("a state has a block of its own"),
            Happening::Came { client } => {
                out.push(CAME);
                put_number(out, (*client).into());
            }
            Happening::Left { client } => {
                out.push(LEFT);
                put_number(out, (*client).into());
            }
            Happening::Wheel { from, rate } => {
                out.push(WHEEL);
                put_signed(out, from.since(tick));
                put_signed(out, (*rate).into());
            }
            Happening::Clay { from, clay } => {
                out.push(CLAY);
                put_signed(out, from.since(tick));
                put_clay(out, clay);
            }
            Happening::Tool { shape, mesh } => {
                out.extend([TOOL, *shape]);
                put_mesh(out, mesh);
            }
            Happening::Pressed(pressed) => {
                out.push(PRESSED);
                put_number(out, pressed.len() as u64);
                for (client, sample) in pressed {
                    self.put_hand(*client, sample);
                }
            }
            Happening::Snapshot { digest } => {
                out.push(SNAPSHOT);
                out.extend(digest.to_le_bytes());
            }
            Happening::Replaced(tiles) => {
                out.push(REPLACED);
                put_number(out, tiles.len() as u64);
                for (surface, tile, steps) in tiles {
                    put_tile(out, *surface, *tile, steps);
                }
            }
        }
    }

    fn put_hand(&mut self, client: u16, sample: &ToolSample) {
        let out = &mut self.out;
        put_number(out, client.into());
        match self.hands.get_mut(&client).filter(|hand| hand.goes_on_to(sample)) {
            None => {
                out.push(ANEW);
                put_sample(out, self.tick, sample);
                self.hands.insert(client, Hand::at(*sample));
            }
            Some(hand) => {
                let is_convex = sample.tool.shape().is_some();
                let turns = is_convex && sample.orientation != hand.last.orientation;
                out.push(if turns { TURNS_ON } else { GOES_ON });
                for axis in 0..3 {
                    put_signed(out, sample.centre.0[axis].wrapping_sub(hand.expected(axis)).into());
                }
                for (to, from) in sample.orientation.0.iter().zip(hand.last.orientation.0).filter(|_| turns) {
                    put_signed(out, to.wrapping_sub(from).into());
                }
                hand.move_to(*sample);
            }
        }
    }
}

/// Bytes that are read from the front; whatever is not there is `None`.
#[derive(Debug)]
pub(super) struct Bytes<'a>(pub(super) &'a [u8]);

impl Bytes<'_> {
    pub(super) fn array<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*first)
    }

    pub(super) fn u8(&mut self) -> Option<u8> {
        self.array().map(|[byte]| byte)
    }

    pub(super) fn f32(&mut self) -> Option<f32> {
        self.array().map(f32::from_le_bytes)
    }

    pub(super) fn number(&mut self) -> Option<u64> {
        let mut number = 0_u64;
        for shift in (0..64).step_by(7) {
            let byte = self.u8()?;
            let bits = u64::from(byte & 0x7f);
            if bits << shift >> shift != bits {
                return None;
            }
            number |= bits << shift;
            if byte < 0x80 {
                return Some(number);
            }
        }
        None
    }

    pub(super) fn signed(&mut self) -> Option<i64> {
        let number = self.number()?;
        Some((number >> 1) as i64 ^ -((number & 1) as i64))
    }

    /// A count of things that take so many bytes each at least, so that a claim is no larger than what is there.
    pub(super) fn count(&mut self, bytes_each: usize) -> Option<usize> {
        let count = usize::try_from(self.number()?).ok()?;
        (count <= self.0.len() / bytes_each).then_some(count)
    }

    pub(super) fn client(&mut self) -> Option<u16> {
        u16::try_from(self.number()?).ok()
    }

    /// A tick, told from another one.
    pub(super) fn tick(&mut self, near: Tick) -> Option<Tick> {
        near.0.checked_add_signed(self.signed()?).filter(|tick| *tick <= TICK_MAX).map(Tick)
    }

    pub(super) fn clay(&mut self) -> Option<Material> {
        let viscosity = Seconds(self.f32()?);
        Material::new(viscosity, Strength { youngs_pa: self.f32()?, yield_pa: self.f32()? }).ok()
    }

    pub(super) fn mesh(&mut self) -> Option<MeshWire> {
        let mut mesh = MeshWire { corners_m: Vec::new(), facets: Vec::new() };
        for _ in 0..self.count(12)? {
            mesh.corners_m.push([self.f32()?, self.f32()?, self.f32()?]);
        }
        for _ in 0..self.count(6)? {
            let mut corner = || self.array().map(u16::from_le_bytes);
            mesh.facets.push([corner()?, corner()?, corner()?]);
        }
        Some(mesh)
    }

    pub(super) fn tile(&mut self) -> Option<(u8, u32, Arc<[u16]>)> {
        let (surface, tile) = (self.u8()?, u32::try_from(self.number()?).ok()?);
        let mut steps = Vec::new();
        let mut step = 0_i64;
        for _ in 0..self.count(1)? {
            step = step.checked_add(self.signed()?)?;
            steps.push(u16::try_from(step).ok()?);
        }
        Some((surface, tile, steps.into()))
    }

    pub(super) fn sample(&mut self, near: Tick) -> Option<ToolSample> {
        let tick = self.tick(near)?;
        let side = match self.u8()? {
            0 => Side::Outside,
            1 => Side::Inside,
            _ => return None,
        };
        let mut orientation = Orientation::default();
        let tool = match self.u8()? {
            0 => Sphere::of_micrometres(u16::from_le_bytes(self.array()?))?.into(),
            1 => {
                let shape = Shape(self.u8()?);
                for angle in &mut orientation.0 {
                    *angle = i16::from_le_bytes(self.array()?);
                }
                Tool::Convex(shape)
            }
            _ => return None,
        };
        let mut centre = [0; 3];
        for along in &mut centre {
            *along = i32::try_from(self.signed()?).ok()?;
        }
        let centre = Some(Position(centre)).filter(|centre| centre.is_within_reach())?;
        Some(ToolSample { tick, tool, orientation, centre, side })
    }
}

/// Reads the entries of a block between two ticks; `None` when the bytes are none.
pub(super) fn read_entries(bytes: &[u8], first: Tick, last: Tick) -> Option<Vec<(Tick, Happening)>> {
    let mut reader = EntryReader { bytes: Bytes(bytes), tick: first, hands: BTreeMap::new() };
    let mut entries = Vec::new();
    while !reader.bytes.0.is_empty() {
        let what = reader.next_entry()?;
        entries.push((reader.tick, what));
    }
    (reader.tick <= last).then_some(entries)
}

#[derive(Debug)]
struct EntryReader<'a> {
    bytes: Bytes<'a>,
    tick: Tick,
    hands: BTreeMap<u16, Hand>,
}

impl EntryReader<'_> {
    fn next_entry(&mut self) -> Option<Happening> {
        let bytes = &mut self.bytes;
        self.tick = Tick(self.tick.0.checked_add(bytes.number()?).filter(|tick| *tick <= TICK_MAX)?);
        Some(match bytes.u8()? {
            CAME => Happening::Came { client: bytes.client()? },
            LEFT => Happening::Left { client: bytes.client()? },
            WHEEL => Happening::Wheel { from: bytes.tick(self.tick)?, rate: i32::try_from(bytes.signed()?).ok()? },
            CLAY => Happening::Clay { from: bytes.tick(self.tick)?, clay: bytes.clay()? },
            TOOL => Happening::Tool { shape: bytes.u8()?, mesh: bytes.mesh()? },
            PRESSED => {
                // a hand, what it does, and a place
                let count = bytes.count(5)?;
                Happening::Pressed((0..count).map(|_| self.hand()).collect::<Option<_>>()?)
            }
            SNAPSHOT => Happening::Snapshot { digest: u64::from_le_bytes(bytes.array()?) },
            REPLACED => {
                // surface, tile, and how many radii
                let count = bytes.count(3)?;
                Happening::Replaced((0..count).map(|_| bytes.tile()).collect::<Option<_>>()?)
            }
            _ => return None,
        })
    }

    fn hand(&mut self) -> Option<(u16, ToolSample)> {
        let bytes = &mut self.bytes;
        let client = bytes.client()?;
        let how = bytes.u8()?;
        if how == ANEW {
            let sample = bytes.sample(self.tick)?;
            self.hands.insert(client, Hand::at(sample));
            return Some((client, sample));
        }
        let hand = self.hands.get_mut(&client)?;
        let mut sample = ToolSample { tick: hand.last.tick.next(), ..hand.last };
        for (axis, along) in sample.centre.0.iter_mut().enumerate() {
            *along = hand.expected(axis).wrapping_add(i32::try_from(bytes.signed()?).ok()?);
        }
        match (how, sample.tool) {
            (GOES_ON, _) => {}
            (TURNS_ON, Tool::Convex(_)) => {
                for angle in &mut sample.orientation.0 {
                    *angle = angle.wrapping_add(i16::try_from(bytes.signed()?).ok()?);
                }
            }
            _ => return None,
        }
        if sample.tick.0 > TICK_MAX || !sample.centre.is_within_reach() {
            return None;
        }
        hand.move_to(sample);
        Some((client, sample))
    }
}
