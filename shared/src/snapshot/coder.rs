//! An adaptive binary range coder.
//!
//! Codes bits with learned probabilities; what the bits mean is `residual`'s affair. The scheme is the one described
//! by Martin (1979) with the carry propagation of LZMA.
//! Invariant: the decoder given the encoder's bytes and the same sequence of models returns the same bits; given any
//! other bytes it returns some bits and never reads past the end.

use alloc::vec::Vec;

const PROBABILITY_BITS: u32 = 12;
const RENORMALISE_BELOW: u32 = 1 << 24;
/// Most zero bytes that the encoder leaves out at the end.
const ZEROS_BEHIND_END: usize = 4;

/// Learned probability that a bit is zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct BitModel {
    zero: u16,
    seen: u8,
}

impl BitModel {
    pub(super) const EVEN: Self = Self::zero_in_4096(2048);

    /// Starts from a known share of zeros.
    pub(super) const fn zero_in_4096(zero: u16) -> Self {
        Self { zero, seen: 0 }
    }

    /// Moves towards the bit seen: fast at first, then by 1/32.
    const fn learn(&mut self, bit: bool) {
        let shift = if self.seen < 3 { self.seen as u32 + 2 } else { 5 };
        self.seen = self.seen.saturating_add(1);
        if bit {
            self.zero -= self.zero >> shift;
        } else {
            self.zero += ((1 << PROBABILITY_BITS) - self.zero) >> shift;
        }
        // both bits must stay possible
        if self.zero < 16 {
            self.zero = 16;
        } else if self.zero > 4080 {
            self.zero = 4080;
        }
    }
}

/// Writes bits.
#[derive(Debug)]
pub(super) struct Encoder {
    bytes: Vec<u8>,
    low: u64,
    range: u32,
    /// The last byte not yet written, and how many 0xff follow it: a carry may still reach them.
    held: Option<u8>,
    held_full: usize,
}

impl Encoder {
    pub(super) const fn new() -> Self {
        Self { bytes: Vec::new(), low: 0, range: u32::MAX, held: None, held_full: 0 }
    }

    pub(super) fn bit(&mut self, model: &mut BitModel, bit: bool) {
        let bound = (self.range >> PROBABILITY_BITS) * u32::from(model.zero);
        if bit {
            self.low += u64::from(bound);
            self.range -= bound;
        } else {
            self.range = bound;
        }
        model.learn(bit);
        self.normalise();
    }

    /// The lowest `count` bits of `value`, highest first, taken as evenly distributed.
    pub(super) fn raw(&mut self, value: u32, count: u32) {
        for at in (0..count).rev() {
            self.range >>= 1;
            if value >> at & 1 == 1 {
                self.low += u64::from(self.range);
            }
            self.normalise();
        }
    }

    fn normalise(&mut self) {
        while self.range < RENORMALISE_BELOW {
            self.range <<= 8;
            self.shift();
        }
    }

    fn shift(&mut self) {
        let carry = (self.low >> 32) as u8;
        let top = (self.low >> 24) as u8;
        if carry == 1 || top != 0xff {
            if let Some(held) = self.held {
                self.bytes.push(held.wrapping_add(carry));
            }
            self.bytes.extend(core::iter::repeat_n(0xff_u8.wrapping_add(carry), self.held_full));
            self.held_full = 0;
            self.held = Some(top);
        } else {
            self.held_full += 1;
        }
        self.low = (self.low & 0x00ff_ffff) << 8;
    }

    pub(super) fn finish(mut self) -> Vec<u8> {
        for _ in 0..5 {
            self.shift();
        }
        // the decoder reads zeros behind the end
        for _ in 0..ZEROS_BEHIND_END {
            if self.bytes.last() == Some(&0) {
                self.bytes.pop();
            }
        }
        self.bytes
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

    fn next_byte(&mut self) -> u32 {
        let byte = self.bytes.get(self.at).copied().unwrap_or(0);
        self.at += 1;
        u32::from(byte)
    }

    /// Whether more was read than the encoder can have written.
    pub(super) const fn is_exhausted(&self) -> bool {
        self.at > self.bytes.len() + ZEROS_BEHIND_END
    }

    /// Whether bytes are left that no symbol has asked for.
    pub(super) const fn has_rest(&self) -> bool {
        self.at < self.bytes.len()
    }

    pub(super) fn bit(&mut self, model: &mut BitModel) -> bool {
        let bound = (self.range >> PROBABILITY_BITS) * u32::from(model.zero);
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

    pub(super) fn raw(&mut self, count: u32) -> u32 {
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

    fn normalise(&mut self) {
        while self.range < RENORMALISE_BELOW {
            self.range <<= 8;
            self.code = self.code << 8 | self.next_byte();
        }
    }
}
