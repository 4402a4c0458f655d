//! A client's samples: consecutive ticks of one tool in runs, in few bits.
//!
//! Owns the order of their bits; knows nothing of what tools there are. What is left of long numbers is said in their lowest bits,
//! which the server puts beside its own: a datagram goes every ten milliseconds, and half of it was what stands before the samples.
//! Invariant: what is decoded from an encoding is what went in; other bytes give some samples or an error, and take no more
//! memory than the message's limit allows.

use alloc::vec::Vec;

use bincode::de::Decoder as MessageDecoder;
use bincode::enc::Encoder as MessageEncoder;
use bincode::error::{DecodeError, EncodeError};
use bincode::{Decode, Encode};

use crate::coding::{BitModel, Decoder, Encoder, Movement, StepModel, Symbols};

/// A tool and how it is turned.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Encode, Decode)]
pub enum ShapeWire {
    /// A sphere.
    Sphere {
        /// Its radius, µm.
        radius_um: u16,
    },
    /// A convex tool of the rack.
    Convex {
        /// Its number there.
        shape: u8,
        /// Yaw, pitch and roll as seen from where it stands, 2¹⁶ a turn.
        orientation: [i16; 3],
    },
}

/// Consecutive ticks of one tool.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Run {
    /// The lowest 16 bits of the first sample's tick.
    pub first_tick: u16,
    /// The tool, turned as it is at the first sample.
    pub tool: ShapeWire,
    /// Whether it works inside of the pot.
    pub inside: bool,
    /// First position, in steps of 10 µm, within ±[`Run::PLACE_MAX`].
    pub start: [i32; 3],
    /// Movement from tick to tick after it, in the same steps; [`Run::STEPS_MAX`] at most.
    pub steps: Vec<[i16; 3]>,
    /// Turning of a convex tool from tick to tick beside each step, 2¹⁶ a turn; none for one that is held as it is.
    pub turns: Vec<[i16; 3]>,
}

/// A client's newest samples and those that may have been lost.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Inputs {
    /// The lowest 16 bits of the first sample's number in the client's stream of samples.
    pub first: u16,
    /// The samples; numbers run on from run to run.
    pub runs: Vec<Run>,
    /// Whether the hand has made no other sample since and rests, so that nobody waits for one.
    pub rests: bool,
}

impl Run {
    /// Furthest position along an axis.
    pub const PLACE_MAX: i32 = (1 << (Self::PLACE_BITS - 1)) - 1;
    /// Most steps.
    pub const STEPS_MAX: usize = (1 << Self::COUNT_BITS) - 1;
    const PLACE_BITS: u32 = 18;
    const COUNT_BITS: u32 = 10;
}

/// What is learned within a datagram.
struct Models {
    /// Whether there is a run, and whether there is another.
    is_more: [BitModel; 2],
    steps: StepModel,
    turns: StepModel,
}

/// Codes a number in so many bits, or returns the one that was coded.
fn raw(symbols: &mut impl Symbols, given: Option<u32>, bits: u32) -> u32 {
    symbols.raw(given.unwrap_or(0) & ((1 << bits) - 1), bits)
}

fn flag(symbols: &mut impl Symbols, given: Option<bool>) -> bool {
    raw(symbols, given.map(u32::from), 1) == 1
}

/// The number that has so many bits with a sign.
const fn with_sign(bits: u32, count: u32) -> i32 {
    ((bits << (u32::BITS - count)) as i32) >> (u32::BITS - count)
}

impl Models {
    const fn new() -> Self {
        Self {
            is_more: [BitModel::zero_in_4096(256), BitModel::zero_in_4096(3840)],
            steps: StepModel::of_places(),
            turns: StepModel::of_angles(),
        }
    }

    fn tool(symbols: &mut impl Symbols, given: Option<ShapeWire>) -> ShapeWire {
        let (radius, held) = match given {
            Some(ShapeWire::Convex { shape, orientation }) => (None, Some((shape, orientation))),
            Some(ShapeWire::Sphere { radius_um }) => (Some(u32::from(radius_um)), None),
            None => (None, None),
        };
        if flag(symbols, given.map(|_| held.is_some())) {
            let shape = raw(symbols, held.map(|(shape, _)| shape.into()), 8) as u8;
            let angle = |about: usize| raw(symbols, held.map(|(_, turned)| u32::from(turned[about] as u16)), 16) as i16;
            return ShapeWire::Convex { shape, orientation: [0, 1, 2].map(angle) };
        }
        ShapeWire::Sphere { radius_um: raw(symbols, radius, 16) as u16 }
    }

    fn run(
        &mut self,
        symbols: &mut impl Symbols,
        given: Option<&Run>,
        claim: &mut impl FnMut(usize) -> Result<(), DecodeError>,
    ) -> Result<Run, DecodeError> {
        let first_tick = raw(symbols, given.map(|run| run.first_tick.into()), 16) as u16;
        let tool = Self::tool(symbols, given.map(|run| run.tool));
        let inside = flag(symbols, given.map(|run| run.inside));
        let mut start = [0; 3];
        for (axis, along) in start.iter_mut().enumerate() {
            let place = raw(symbols, given.map(|run| run.start[axis] as u32), Run::PLACE_BITS);
            *along = with_sign(place, Run::PLACE_BITS);
        }
        let count = raw(symbols, given.map(|run| run.steps.len() as u32), Run::COUNT_BITS) as usize;
        let is_convex = matches!(tool, ShapeWire::Convex { .. });
        let turns = is_convex && flag(symbols, given.map(|run| !run.turns.is_empty()));
        claim(count * size_of::<[i16; 3]>() * (1 + usize::from(turns)))?;
        let mut run = Run {
            first_tick,
            tool,
            inside,
            start,
            steps: Vec::with_capacity(count),
            turns: Vec::with_capacity(if turns { count } else { 0 }),
        };
        let (mut moves, mut turning) = (Movement::default(), Movement::default());
        let wide = |steps: &[[i16; 3]], at: usize| steps.get(at).map_or([0; 3], |step| step.map(i32::from));
        for at in 0..count {
            let step = moves.step(symbols, &mut self.steps, given.map_or([0; 3], |run| wide(&run.steps, at)));
            run.steps.push(step.map(|along| along as i16));
            if turns {
                let turn = turning.step(symbols, &mut self.turns, given.map_or([0; 3], |run| wide(&run.turns, at)));
                run.turns.push(turn.map(|about| about as i16));
            }
            if symbols.is_exhausted() {
                return Err(DecodeError::Other("more samples than bits"));
            }
        }
        Ok(run)
    }
}

impl Inputs {
    /// Both directions: codes what is given, or returns what was coded; memory is claimed before it is taken.
    fn code(
        symbols: &mut impl Symbols,
        given: Option<&Self>,
        mut claim: impl FnMut(usize) -> Result<(), DecodeError>,
    ) -> Result<Self, DecodeError> {
        let mut models = Models::new();
        let first = raw(symbols, given.map(|inputs| inputs.first.into()), 16) as u16;
        let rests = flag(symbols, given.map(|inputs| inputs.rests));
        let mut coded = Self { first, runs: Vec::new(), rests };
        loop {
            let run = given.and_then(|inputs| inputs.runs.get(coded.runs.len()));
            let is_more = &mut models.is_more[usize::from(!coded.runs.is_empty())];
            if !symbols.bit(is_more, run.is_some()) {
                return Ok(coded);
            }
            claim(size_of::<Run>())?;
            let run = models.run(symbols, run, &mut claim)?;
            coded.runs.push(run);
        }
    }
}

impl Encode for Inputs {
    fn encode<E: MessageEncoder>(&self, encoder: &mut E) -> Result<(), EncodeError> {
        let mut bytes = Vec::new();
        let mut symbols = Encoder::new(&mut bytes);
        Self::code(&mut symbols, Some(self), |_| Ok(())).map_err(|_| EncodeError::Other("no inputs"))?;
        symbols.finish();
        bytes.encode(encoder)
    }
}

impl<Context> Decode<Context> for Inputs {
    fn decode<D: MessageDecoder<Context = Context>>(decoder: &mut D) -> Result<Self, DecodeError> {
        let bytes = Vec::<u8>::decode(decoder)?;
        let mut symbols = Decoder::new(&bytes);
        let inputs = Self::code(&mut symbols, None, |bytes| decoder.claim_bytes_read(bytes))?;
        if symbols.is_exhausted() || symbols.has_rest() {
            return Err(DecodeError::Other("no inputs"));
        }
        Ok(inputs)
    }
}

bincode::impl_borrow_decode!(Inputs);
