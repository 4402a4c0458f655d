//! What the bits of a delta mean: which tiles changed, and by how much.
//!
//! Owns the order of symbols, their contexts and the predictor, once for both directions; knows no versions.
//! Invariant: coding and decoding the same symbols leaves both models in the same state.
//!
//! A message is a list of tiles (gaps between their numbers), each followed by the differences of its elements to the
//! values both ends hold, column by column. A difference is predicted by the median edge detector (MED, as in LOCO-I)
//! from its neighbours in the tile and coded as zero flag, sign and Exp-Golomb magnitude, in a context of the
//! neighbours' activity.

use alloc::vec::Vec;

use super::coder::{BitModel, Decoder, Encoder};

const CONTEXTS: usize = 8;
/// Prefix lengths of the Exp-Golomb code: 17 covers any difference of 16-bit values after prediction.
const PREFIXES: usize = 20;

/// Both directions of the coder, so that the order of symbols is written once.
pub(super) trait Symbols {
    /// Codes `bit`, or ignores it and returns the bit that was coded.
    fn bit(&mut self, model: &mut BitModel, bit: bool) -> bool;
    /// The same for evenly distributed bits.
    fn raw(&mut self, value: u32, count: u32) -> u32;
}

impl Symbols for Encoder {
    fn bit(&mut self, model: &mut BitModel, bit: bool) -> bool {
        self.bit(model, bit);
        bit
    }
    fn raw(&mut self, value: u32, count: u32) -> u32 {
        self.raw(value, count);
        value
    }
}

impl Symbols for Decoder<'_> {
    fn bit(&mut self, model: &mut BitModel, _: bool) -> bool {
        self.bit(model)
    }
    fn raw(&mut self, _: u32, count: u32) -> u32 {
        self.raw(count)
    }
}

/// The learned state of one message.
#[derive(Debug)]
pub(super) struct Models {
    more_tiles: BitModel,
    gap: Magnitude,
    zero: [BitModel; CONTEXTS],
    sign: [BitModel; 3],
    magnitude: [Magnitude; CONTEXTS],
}

impl Models {
    pub(super) const fn new() -> Self {
        Self {
            more_tiles: BitModel::zero_in_4096(256),
            gap: Magnitude::new(),
            zero: [
                BitModel::zero_in_4096(3900),
                BitModel::zero_in_4096(2700),
                BitModel::EVEN,
                BitModel::zero_in_4096(1300),
                BitModel::zero_in_4096(700),
                BitModel::zero_in_4096(400),
                BitModel::zero_in_4096(200),
                BitModel::zero_in_4096(100),
            ],
            sign: [BitModel::EVEN; 3],
            magnitude: [const { Magnitude::new() }; CONTEXTS],
        }
    }

    /// Whether another tile follows, and how many tiles are passed over before it.
    pub(super) fn tile_gap(&mut self, symbols: &mut impl Symbols, gap: Option<u32>) -> Option<u32> {
        if symbols.bit(&mut self.more_tiles, gap.is_some()) {
            Some(self.gap.code(symbols, gap.unwrap_or(0)))
        } else {
            None
        }
    }

    /// The differences of one tile, `[columns][rows]`; `differences` is read or filled.
    pub(super) fn tile(&mut self, symbols: &mut impl Symbols, rows: usize, differences: &mut [i32]) {
        for at in 0..differences.len() {
            let below = if at % rows > 0 { differences[at - 1] } else { 0 };
            let left = if at >= rows { differences[at - rows] } else { below };
            let corner = if at >= rows && at % rows > 0 { differences[at - rows - 1] } else { left };
            let below = if at % rows > 0 { below } else { left };
            let predicted = median_edge(left, below, corner);
            let activity = (left - corner).unsigned_abs() + (below - corner).unsigned_abs() + u32::from(predicted != 0);
            let context = ((u32::BITS - activity.leading_zeros()) as usize).min(CONTEXTS - 1);
            let error = self.signed(symbols, context, predicted.signum(), differences[at].wrapping_sub(predicted));
            differences[at] = predicted.wrapping_add(error);
        }
    }

    fn signed(&mut self, symbols: &mut impl Symbols, context: usize, trend: i32, value: i32) -> i32 {
        if !symbols.bit(&mut self.zero[context], value != 0) {
            return 0;
        }
        let negative = symbols.bit(&mut self.sign[(trend + 1) as usize], value < 0);
        let magnitude = self.magnitude[context].code(symbols, value.unsigned_abs().saturating_sub(1)).min(1 << 18);
        let magnitude = magnitude as i32 + 1;
        if negative { -magnitude } else { magnitude }
    }
}

/// Median edge detector: the median of `a`, `b` and `a + b − c`.
fn median_edge(a: i32, b: i32, c: i32) -> i32 {
    let (low, high) = (a.min(b), a.max(b));
    a.wrapping_add(b).wrapping_sub(c).clamp(low, high)
}

/// Adaptive Exp-Golomb code of a number from zero up.
#[derive(Debug)]
pub(super) struct Magnitude {
    prefix: [BitModel; PREFIXES],
    first_suffix: [BitModel; PREFIXES],
}

impl Magnitude {
    pub(super) const fn new() -> Self {
        Self { prefix: [BitModel::EVEN; PREFIXES], first_suffix: [BitModel::EVEN; PREFIXES] }
    }

    pub(super) fn code(&mut self, symbols: &mut impl Symbols, value: u32) -> u32 {
        let bits = u32::BITS - (value + 1).leading_zeros() - 1;
        let mut length = 0;
        while (length as usize) < PREFIXES - 1 && symbols.bit(&mut self.prefix[length as usize], bits > length) {
            length += 1;
        }
        if length == 0 {
            return 0;
        }
        let suffix = (value + 1).wrapping_sub(1 << length);
        let first = symbols.bit(&mut self.first_suffix[length as usize], suffix >> (length - 1) & 1 == 1);
        let rest = symbols.raw(suffix & ((1 << (length - 1)) - 1), length - 1);
        (1 << length) - 1 + (u32::from(first) << (length - 1)) + rest
    }
}

/// Differences of one tile, reused between tiles.
pub(super) type Differences = Vec<i32>;
