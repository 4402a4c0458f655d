//! An adaptive range coder of bits and of symbols of sixteen kinds.
//!
//! Codes with learned probabilities; what is coded is the affair of `sweep` and `models`. The scheme is the one described
//! by Martin (1979); a range of sixteen bits lets a processor compare a code with sixteen bounds at once.
//! Invariant: the decoder given the encoder's bytes and the same sequence of models returns the same symbols; given any
//! other bytes it returns some and never reads past the end.

use alloc::vec::Vec;

use super::adaptive::{BitModel, KindModel};

/// Most zero bytes that the encoder leaves out at the end.
const ZEROS_BEHIND_END: usize = 4;
/// Bits of a range, of which the highest is always set.
const RANGE_BITS: u32 = 16;
/// Bits that are written, or read, at once.
const WORD_BITS: u32 = 32;

/// Both directions of the coder, so that the order of symbols is written once.
pub(crate) trait Symbols {
    /// Whether what is coded is given, and not yet to be found out.
    const IS_GIVEN: bool;

    /// Codes `bit`, or ignores it and returns the bit that was coded.
    fn bit(&mut self, model: &mut BitModel, bit: bool) -> bool;
    /// The same for a symbol below [`KindModel::KINDS`].
    fn kind(&mut self, model: &mut KindModel, kind: usize) -> usize;
    /// The same for the lowest `count` bits of `value`, evenly distributed.
    fn raw(&mut self, value: u32, count: u32) -> u32;
    /// Whether more was asked for than there is.
    fn is_exhausted(&self) -> bool;
}

/// Writes symbols. What it counts with is all its own, so that a processor can keep it in registers.
#[derive(Debug)]
pub(crate) struct Encoder<'a> {
    bytes: &'a mut Vec<u8>,
    /// Where the range begins; above the bits that wait, what the bytes written are still to be raised by.
    low: u64,
    range: u32,
    /// Bits of `low` above those of the range.
    waiting: u32,
}

impl<'a> Encoder<'a> {
    /// Writes behind what `bytes` hold, which are to be none.
    pub(crate) fn new(bytes: &'a mut Vec<u8>) -> Self {
        debug_assert!(bytes.is_empty());
        bytes.reserve(1024);
        Self { bytes, low: 0, range: u16::MAX.into(), waiting: 0 }
    }

    /// Goes on in a part of the range.
    #[inline(always)]
    fn narrow(&mut self, from: u32, width: u32) {
        let shift = width.leading_zeros() - (u32::BITS - RANGE_BITS);
        self.low = (self.low + u64::from(from)) << shift;
        self.range = width << shift;
        self.waiting += shift;
        if self.waiting >= WORD_BITS {
            self.write_word();
        }
    }

    #[inline(always)]
    fn write_word(&mut self) {
        self.waiting -= WORD_BITS;
        let place = RANGE_BITS + self.waiting;
        let word = self.low >> place;
        if word >> WORD_BITS != 0 {
            raise(self.bytes);
        }
        self.bytes.extend_from_slice(&(word as u32).to_be_bytes());
        self.low &= (1 << place) - 1;
    }

    /// Writes what is left.
    pub(crate) fn finish(mut self) {
        // of all numbers above the least that say the same, the one with most zeros at its end
        for zeros in (0..=RANGE_BITS).rev() {
            let rounded = (self.low | ((1 << zeros) - 1)).wrapping_add(1) & !((1 << zeros) - 1);
            if rounded - self.low < u64::from(self.range) {
                self.low = rounded;
                break;
            }
        }
        let bytes = (RANGE_BITS + self.waiting).div_ceil(8);
        self.low <<= 8 * bytes - (RANGE_BITS + self.waiting);
        if self.low >> (8 * bytes) != 0 {
            raise(self.bytes);
        }
        self.bytes.extend((0..bytes).rev().map(|at| (self.low >> (8 * at)) as u8));
        // the decoder reads zeros behind the end
        for _ in 0..ZEROS_BEHIND_END {
            if self.bytes.last() == Some(&0) {
                self.bytes.pop();
            }
        }
    }
}

/// Adds one to a number of which these are the bytes, the highest first; it has room for it.
#[inline(never)]
fn raise(bytes: &mut [u8]) {
    for byte in bytes.iter_mut().rev() {
        *byte = byte.wrapping_add(1);
        if *byte != 0 {
            return;
        }
    }
}

impl Symbols for Encoder<'_> {
    const IS_GIVEN: bool = true;

    #[inline(always)]
    fn bit(&mut self, model: &mut BitModel, bit: bool) -> bool {
        let bound = model.bound(self.range);
        let one = u32::from(bit).wrapping_neg();
        self.narrow(bound & one, bound ^ ((bound ^ (self.range - bound)) & one));
        model.learn(bit);
        bit
    }

    #[inline(always)]
    fn kind(&mut self, model: &mut KindModel, kind: usize) -> usize {
        let (from, end) = model.part(self.range, kind);
        self.narrow(from, end - from);
        model.learn(kind);
        kind
    }

    #[inline(always)]
    fn raw(&mut self, value: u32, count: u32) -> u32 {
        for at in (0..count).rev() {
            let (bound, one) = (self.range >> 1, (value >> at & 1).wrapping_neg());
            self.narrow(bound & one, bound);
        }
        value
    }

    #[inline(always)]
    fn is_exhausted(&self) -> bool {
        false
    }
}

/// Reads symbols.
#[derive(Debug)]
pub(crate) struct Decoder<'a> {
    bytes: &'a [u8],
    /// Bytes that were taken, those behind the end with them.
    at: usize,
    /// What is compared with the range, in the highest bits, and what comes after it.
    window: u64,
    range: u32,
    /// Bits in `window` behind those that are compared.
    held: u32,
}

impl<'a> Decoder<'a> {
    pub(crate) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self { bytes, at: 0, window: 0, range: u16::MAX.into(), held: 0 };
        decoder.window = u64::from(decoder.word()) << WORD_BITS;
        decoder.held = WORD_BITS - RANGE_BITS;
        decoder
    }

    #[inline(always)]
    fn word(&mut self) -> u32 {
        let word = match self.bytes.get(self.at..).and_then(<[u8]>::first_chunk) {
            Some(&four) => u32::from_be_bytes(four),
            None => last_word(self.bytes, self.at),
        };
        self.at += 4;
        word
    }

    /// Bytes that symbols have asked for.
    const fn asked(&self) -> usize {
        self.at - (self.held / 8) as usize
    }

    /// Whether bytes are left that no symbol has asked for.
    pub(crate) const fn has_rest(&self) -> bool {
        self.asked() < self.bytes.len()
    }

    /// What is compared with bounds.
    #[inline(always)]
    const fn code(&self) -> u32 {
        (self.window >> (u64::BITS - RANGE_BITS)) as u32
    }

    /// Goes on in a part of the range.
    #[inline(always)]
    fn narrow(&mut self, from: u32, width: u32) {
        let shift = width.leading_zeros() - (u32::BITS - RANGE_BITS);
        self.window = (self.window - (u64::from(from) << (u64::BITS - RANGE_BITS))) << shift;
        self.range = width << shift;
        self.held = self.held.wrapping_sub(shift);
        // no part is so small that more than these were needed
        if self.held < RANGE_BITS {
            self.window |= u64::from(self.word()) << (RANGE_BITS - self.held);
            self.held += WORD_BITS;
        }
    }
}

/// Four bytes of which some are behind the end.
#[cold]
fn last_word(bytes: &[u8], from: usize) -> u32 {
    let byte = |at: usize| bytes.get(from + at).copied().unwrap_or(0);
    u32::from_be_bytes(core::array::from_fn(byte))
}

impl Symbols for Decoder<'_> {
    const IS_GIVEN: bool = false;

    #[inline(always)]
    fn bit(&mut self, model: &mut BitModel, _: bool) -> bool {
        let bound = model.bound(self.range);
        let bit = self.code() >= bound;
        let one = u32::from(bit).wrapping_neg();
        self.narrow(bound & one, bound ^ ((bound ^ (self.range - bound)) & one));
        model.learn(bit);
        bit
    }

    #[inline(always)]
    fn kind(&mut self, model: &mut KindModel, _: usize) -> usize {
        let (kind, from, end) = model.find(self.range, self.code());
        self.narrow(from, end - from);
        model.learn(kind);
        kind
    }

    #[inline(always)]
    fn raw(&mut self, _: u32, count: u32) -> u32 {
        let mut value = 0;
        for _ in 0..count {
            let bound = self.range >> 1;
            let bit = u32::from(self.code() >= bound);
            self.narrow(bound & bit.wrapping_neg(), bound);
            value = value << 1 | bit;
        }
        value
    }

    #[inline(always)]
    fn is_exhausted(&self) -> bool {
        self.asked() > self.bytes.len() + ZEROS_BEHIND_END
    }
}
