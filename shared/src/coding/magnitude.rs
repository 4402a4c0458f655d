//! A code for numbers from zero up that learns how long they are.
//!
//! Owns their bits; what they count is for others to know.
//! Invariant: what is decoded is below 2²⁰, whatever the bytes.

use super::adaptive::BitModel;
use super::coder::Symbols;

/// Prefix lengths of the Exp-Golomb code.
const PREFIXES: usize = 20;

/// Adaptive Exp-Golomb code of a number from zero up.
#[derive(Clone, Debug)]
pub(crate) struct Magnitude {
    prefix: [BitModel; PREFIXES],
    first_suffix: [BitModel; PREFIXES],
}

impl Magnitude {
    pub(crate) const fn new() -> Self {
        Self { prefix: [BitModel::EVEN; PREFIXES], first_suffix: [BitModel::EVEN; PREFIXES] }
    }

    #[inline(always)]
    pub(crate) fn code(&mut self, symbols: &mut impl Symbols, value: u32) -> u32 {
        let bits = u32::BITS - (value.wrapping_add(1) | 1).leading_zeros() - 1;
        let mut length = 0;
        while (length as usize) < PREFIXES - 1 && symbols.bit(&mut self.prefix[length as usize], bits > length) {
            length += 1;
        }
        if length == 0 {
            return 0;
        }
        let suffix = value.wrapping_add(1).wrapping_sub(1 << length);
        let first = symbols.bit(&mut self.first_suffix[length as usize], suffix >> (length - 1) & 1 == 1);
        let rest = symbols.raw(suffix & ((1 << (length - 1)) - 1), length - 1);
        (1 << length) - 1 + (u32::from(first) << (length - 1)) + rest
    }

    /// Everything it has learned.
    pub(crate) fn models(&mut self) -> [&mut [BitModel]; 2] {
        [&mut self.prefix, &mut self.first_suffix]
    }
}
