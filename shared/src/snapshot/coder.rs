//! An adaptive binary range coder.
//!
//! Codes bits with learned probabilities; what the bits mean is the affair of `sweep` and `models`. The scheme is the one described
//! by Martin (1979) with the carry propagation of LZMA.
//! Invariant: the decoder given the encoder's bytes and the same sequence of models returns the same bits; given any
//! other bytes it returns some bits and never reads past the end.

use alloc::vec::Vec;

const PROBABILITY_BITS: u32 = 15;
const RENORMALISE_BELOW: u32 = 1 << 24;
/// Most zero bytes that the encoder leaves out at the end.
const ZEROS_BEHIND_END: usize = 4;

/// Learned probability that a bit is zero, in 2⁻¹⁶.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct BitModel {
    zero: u16,
    /// Bits seen, as far as they change how fast it learns.
    seen: u8,
}

impl BitModel {
    pub(super) const EVEN: Self = Self { zero: 1 << 15, seen: 0 };
    /// It learns by 2⁻¹ from the first bit, by 2⁻² from the second and so on down to this.
    const SLOWEST: u8 = 6;
    /// Where learning by 2⁻⁶ comes to rest: both bits stay possible.
    const LEAST: u16 = 63;

    /// Starts from a known share of zeros.
    pub(super) const fn zero_in_4096(zero: u16) -> Self {
        Self { zero: zero << 4, seen: 1 }
    }

    #[inline(always)]
    const fn learn(&mut self, bit: bool) {
        if self.seen < Self::SLOWEST {
            self.seen += 1;
        }
        let zero = self.zero as u32;
        self.zero = if bit { zero - (zero >> self.seen) } else { zero + ((zero ^ 0xffff) >> self.seen) } as u16;
    }

    /// As [`BitModel::learn`], without a branch.
    #[inline(always)]
    const fn learn_side(&mut self, bit: bool) {
        if self.seen < Self::SLOWEST {
            self.seen += 1;
        }
        // the share of the other bit becomes less
        let other = (bit as u32).wrapping_sub(1) & 0xffff;
        let share = self.zero as u32 ^ other;
        self.zero = ((share - (share >> self.seen)) ^ other) as u16;
    }

    /// Share of `range` that stands for a zero.
    #[inline(always)]
    const fn bound(self, range: u32) -> u32 {
        (range >> PROBABILITY_BITS) * (self.zero as u32 >> 1)
    }

    /// Codes what it has learned, so that another can go on from there.
    pub(super) fn code_state(&mut self, symbols: &mut impl Symbols) {
        let zero = symbols.raw(u32::from(self.zero), 16) as u16;
        self.zero = zero.clamp(Self::LEAST, u16::MAX - Self::LEAST);
        self.seen = (symbols.raw(u32::from(self.seen), 3) as u8).min(Self::SLOWEST);
    }
}

/// Both directions of the coder, so that the order of symbols is written once.
pub(super) trait Symbols {
    /// Whether what is coded is given, and not yet to be found out.
    const IS_GIVEN: bool;

    /// Codes `bit`, or ignores it and returns the bit that was coded.
    fn bit(&mut self, model: &mut BitModel, bit: bool) -> bool;
    /// The same of a bit on which nothing hangs and which nobody can guess: without a branch.
    fn side(&mut self, model: &mut BitModel, bit: bool) -> bool;
    /// The same for the lowest `count` bits of `value`, evenly distributed.
    fn raw(&mut self, value: u32, count: u32) -> u32;
    /// Whether more was asked for than there is.
    fn is_exhausted(&self) -> bool;
}

/// Writes bits. What it counts with is all its own, so that a processor can keep it in registers.
#[derive(Debug)]
pub(super) struct Encoder<'a> {
    bytes: &'a mut Vec<u8>,
    /// Where the range begins; above its 32 bits, what the bytes written are still to be raised by.
    low: u64,
    range: u32,
}

impl<'a> Encoder<'a> {
    /// Writes behind what `bytes` hold, which are to be none.
    pub(super) fn new(bytes: &'a mut Vec<u8>) -> Self {
        debug_assert!(bytes.is_empty());
        bytes.reserve(1024);
        Self { bytes, low: 0, range: u32::MAX }
    }

    #[inline(always)]
    fn normalise(&mut self) {
        while self.range < RENORMALISE_BELOW {
            self.range <<= 8;
            self.shift();
        }
    }

    #[inline(always)]
    fn shift(&mut self) {
        if self.low >> 32 != 0 {
            raise(self.bytes);
        }
        self.bytes.push((self.low >> 24) as u8);
        self.low = (self.low & 0x00ff_ffff) << 8;
    }

    /// Writes what is left.
    pub(super) fn finish(mut self) {
        // of all numbers that say the same, the one with most zeros at its end
        for zeros in (0..RENORMALISE_BELOW.ilog2() + 8).rev() {
            let rounded = (self.low | ((1 << zeros) - 1)).wrapping_add(1) & !((1 << zeros) - 1);
            if rounded - self.low < u64::from(self.range) {
                self.low = rounded;
                break;
            }
        }
        for _ in 0..4 {
            self.shift();
        }
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
        if bit {
            self.low += u64::from(bound);
            self.range -= bound;
        } else {
            self.range = bound;
        }
        model.learn(bit);
        self.normalise();
        bit
    }

    #[inline(always)]
    fn side(&mut self, model: &mut BitModel, bit: bool) -> bool {
        let bound = model.bound(self.range);
        let one = u32::from(bit).wrapping_neg();
        self.low += u64::from(bound & one);
        self.range = (bound ^ one).wrapping_add(self.range & one).wrapping_sub(one);
        model.learn_side(bit);
        self.normalise();
        bit
    }

    #[inline(always)]
    fn raw(&mut self, value: u32, count: u32) -> u32 {
        for at in (0..count).rev() {
            self.range >>= 1;
            if value >> at & 1 == 1 {
                self.low += u64::from(self.range);
            }
            self.normalise();
        }
        value
    }

    #[inline(always)]
    fn is_exhausted(&self) -> bool {
        false
    }
}

/// Reads bits.
#[derive(Debug)]
pub(super) struct Decoder<'a> {
    bytes: &'a [u8],
    at: usize,
    code: u32,
    range: u32,
}

impl<'a> Decoder<'a> {
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let mut decoder = Self { bytes, at: 0, code: 0, range: u32::MAX };
        for _ in 0..4 {
            decoder.code = decoder.code << 8 | decoder.next_byte();
        }
        decoder
    }

    #[inline(always)]
    fn next_byte(&mut self) -> u32 {
        let byte = self.bytes.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        u32::from(byte)
    }

    /// Whether bytes are left that no symbol has asked for.
    pub(super) const fn has_rest(&self) -> bool {
        self.at < self.bytes.len()
    }

    #[inline(always)]
    fn normalise(&mut self) {
        while self.range < RENORMALISE_BELOW {
            self.range <<= 8;
            self.code = self.code << 8 | self.next_byte();
        }
    }
}

impl Symbols for Decoder<'_> {
    const IS_GIVEN: bool = false;

    #[inline(always)]
    fn bit(&mut self, model: &mut BitModel, _: bool) -> bool {
        let bound = model.bound(self.range);
        let bit = self.code >= bound;
        if bit {
            self.code -= bound;
            self.range -= bound;
        } else {
            self.range = bound;
        }
        model.learn(bit);
        self.normalise();
        bit
    }

    #[inline(always)]
    fn side(&mut self, model: &mut BitModel, _: bool) -> bool {
        let bound = model.bound(self.range);
        let bit = self.code >= bound;
        let one = u32::from(bit).wrapping_neg();
        self.code -= bound & one;
        self.range = (bound ^ one).wrapping_add(self.range & one).wrapping_sub(one);
        model.learn_side(bit);
        self.normalise();
        bit
    }

    #[inline(always)]
    fn raw(&mut self, _: u32, count: u32) -> u32 {
        let mut value = 0;
        for _ in 0..count {
            self.range >>= 1;
            let bit = self.code >= self.range;
            if bit {
                self.code -= self.range;
            }
            value = value << 1 | u32::from(bit);
            self.normalise();
        }
        value
    }

    #[inline(always)]
    fn is_exhausted(&self) -> bool {
        self.at > self.bytes.len() + ZEROS_BEHIND_END
    }
}
