//! What a coder learns of the symbols in one context: how likely each is.
//!
//! Owns probabilities and how they are learned; codes nothing itself. Integers only, so that both ends learn the same.
//! Invariant: every symbol stays possible, in any range of the coder.

use wide::{i8x16, i16x16, u16x8};

use super::coder::Symbols;
use super::magnitude::Magnitude;

/// Learned probability that a bit is zero, in 2⁻¹⁶.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct BitModel {
    zero: u16,
    /// Bits seen, as far as they change how fast it learns.
    seen: u8,
}

impl BitModel {
    pub(crate) const EVEN: Self = Self { zero: 1 << 15, seen: 0 };
    /// It learns by 2⁻¹ from the first bit, by 2⁻² from the second and so on down to this.
    const SLOWEST: u8 = 6;
    /// Where learning by 2⁻⁶ comes to rest: both bits stay possible.
    const LEAST: u16 = 63;

    /// Starts from a known share of zeros.
    pub(crate) const fn zero_in_4096(zero: u16) -> Self {
        Self { zero: zero << 4, seen: 1 }
    }

    /// Learns without a branch.
    #[inline(always)]
    pub(crate) const fn learn(&mut self, bit: bool) {
        if self.seen < Self::SLOWEST {
            self.seen += 1;
        }
        // the share of the other bit becomes less
        let other = (bit as u32).wrapping_sub(1) & 0xffff;
        let share = self.zero as u32 ^ other;
        self.zero = ((share - (share >> self.seen)) ^ other) as u16;
    }

    /// Part of a `range` of sixteen bits that stands for a zero.
    #[inline(always)]
    pub(crate) const fn bound(self, range: u32) -> u32 {
        (range * self.zero as u32) >> 16
    }

    /// Codes what it has learned, so that another can go on from there; `is_slowest` learns whether models have seen all that matters.
    pub(crate) fn code_state(&mut self, symbols: &mut impl Symbols, is_slowest: &mut Self) {
        let zero = symbols.raw(u32::from(self.zero), 16) as u16;
        self.zero = zero.clamp(Self::LEAST, u16::MAX - Self::LEAST);
        if symbols.bit(is_slowest, self.seen == Self::SLOWEST) {
            self.seen = Self::SLOWEST;
        } else {
            self.seen = (symbols.raw(u32::from(self.seen), 3) as u8).min(Self::SLOWEST);
        }
    }
}

/// Learned probabilities of sixteen symbols that exclude one another.
///
/// Kept as sums, so that a processor finds a symbol by comparing with all of them at once, and learns one by moving all: those
/// from its own on towards one, those before it towards zero.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(C, align(16))]
pub(crate) struct KindModel {
    /// Symbols seen and four more, as far as they change how fast it learns.
    seen: u32,
    /// Nothing in the last: where the sums begin.
    before: [u16; 6],
    /// Probability of each symbol and all before it, in 2⁻¹⁶; of the last, as much as there is room for.
    sums: [u16; Self::KINDS],
}

impl KindModel {
    /// Symbols.
    pub(crate) const KINDS: usize = 16;
    /// Part of any range that each symbol has at least.
    const LEAST: u32 = 4;
    const FIRST_SEEN: u32 = 4;
    /// It learns by 2⁻⁸ from there on.
    const MOST_SEEN: u32 = 256;
    /// Lanes from a symbol's own on, read from so many places before the middle.
    const FROM: [u16; 2 * Self::KINDS] = {
        let mut lanes = [0; 2 * Self::KINDS];
        let mut at = Self::KINDS;
        while at < lanes.len() {
            lanes[at] = u16::MAX;
            at += 1;
        }
        lanes
    };
    /// What each symbol and those before it have at least.
    const LEASTS: [u16x8; 2] = {
        let mut leasts = [[0; 8]; 2];
        let mut at = 0;
        while at < Self::KINDS {
            leasts[at / 8][at % 8] = Self::LEAST as u16 * (at as u16 + 1);
            at += 1;
        }
        [u16x8::new(leasts[0]), u16x8::new(leasts[1])]
    };

    /// All are as likely.
    pub(crate) const fn even() -> Self {
        let mut sums = [u16::MAX; Self::KINDS];
        let mut at = 0;
        while at < Self::KINDS - 1 {
            sums[at] = (at as u16 + 1) << 12;
            at += 1;
        }
        Self { seen: Self::FIRST_SEEN, before: [0; 6], sums }
    }

    #[inline(always)]
    fn halves(&self) -> [u16x8; 2] {
        let (halves, _) = self.sums.as_chunks();
        [u16x8::new(halves[0]), u16x8::new(halves[1])]
    }

    /// Where the part of a `range` that stands for a symbol begins and ends.
    #[inline(always)]
    pub(crate) fn part(&self, range: u32, kind: usize) -> (u32, u32) {
        let shared = range - Self::KINDS as u32 * Self::LEAST;
        let bound = |sum: u16, symbols: usize| ((shared * u32::from(sum)) >> 16) + Self::LEAST * symbols as u32;
        let sum_before = if kind == 0 { 0 } else { self.sums[kind - 1] };
        (bound(sum_before, kind), bound(self.sums[kind], kind + 1))
    }

    /// The symbol for which a `code` within a `range` stands, and where its part begins and ends.
    #[inline(always)]
    pub(crate) fn find(&self, range: u32, code: u32) -> (usize, u32, u32) {
        let shared = u16x8::splat((range - Self::KINDS as u32 * Self::LEAST) as u16);
        let code = u16x8::splat(code as u16);
        let [low, high] = self.halves();
        let low = low.mul_keep_high(shared) + Self::LEASTS[0];
        let high = high.mul_keep_high(shared) + Self::LEASTS[1];
        let passed = |bounds: u16x8| bounds.saturating_sub(code).simd_eq(u16x8::ZERO).cast_signed();
        let mut lanes = [0; Self::KINDS];
        lanes[..8].copy_from_slice(passed(low).as_array());
        lanes[8..].copy_from_slice(passed(high).as_array());
        // the last bound is that of the range, or bytes are no delta
        let kind = (i8x16::from_i16x16_saturate(i16x16::new(lanes)).to_bitmask() & 0x7fff).count_ones() as usize;
        let mut ends = [0; Self::KINDS + 1];
        ends[1..9].copy_from_slice(low.as_array());
        ends[9..].copy_from_slice(high.as_array());
        (kind, ends[kind].into(), ends[kind + 1].into())
    }

    #[inline(always)]
    pub(crate) fn learn(&mut self, kind: usize) {
        let from: &[u16; Self::KINDS] =
            Self::FROM[Self::KINDS - kind..].first_chunk().expect("there are as many lanes behind the middle");
        let (from, _) = from.as_chunks();
        let rate = u32::BITS - 1 - self.seen.leading_zeros();
        let [low, high] = [0, 1].map(|half| {
            // what the symbol is not becomes less
            let from = u16x8::new(from[half]);
            let other = self.halves()[half] ^ from;
            other.saturating_sub(other.unbounded_shr_scalar(rate) + u16x8::splat(1)) ^ from
        });
        self.sums[..8].copy_from_slice(low.as_array());
        self.sums[8..].copy_from_slice(high.as_array());
        self.seen = (self.seen + 1).min(Self::MOST_SEEN);
    }

    /// Codes what it has learned, as [`BitModel::code_state`]; `steps` learn how likely symbols are.
    pub(crate) fn code_state(
        &mut self,
        symbols: &mut impl Symbols,
        is_slowest: &mut BitModel,
        steps: &mut [Magnitude; Self::KINDS - 1],
    ) {
        if symbols.bit(is_slowest, self.seen == Self::MOST_SEEN) {
            self.seen = Self::MOST_SEEN;
        } else {
            let more = symbols.raw(self.seen.wrapping_sub(Self::FIRST_SEEN), 8);
            self.seen = (Self::FIRST_SEEN + more).min(Self::MOST_SEEN);
        }
        let mut before = 0;
        for (sum, step) in self.sums.iter_mut().zip(steps) {
            let more = step.code(symbols, u32::from(*sum).wrapping_sub(before));
            before = (before + more).min(u16::MAX.into());
            *sum = before as u16;
        }
    }
}
