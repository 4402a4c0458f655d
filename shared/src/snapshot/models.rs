//! What is learned of a chain: how likely every symbol is in its context, and the weights by which an element is foretold.
//!
//! Knows neither tiles nor the order of symbols. Integers only, so that both ends learn the same.
//! Invariant: coding and decoding the same symbols leaves both ends' models in the same state.

use wide::{i16x8, i32x4, i32x8};

use super::motion::PARTS;
use crate::coding::{BitModel, KindModel, Magnitude, Symbols};

/// Contexts of how far elements near by were from what was foretold of them.
const LEVELS: usize = 12;
/// Contexts of where between two quanta the foretold value lies.
const FRACTIONS: usize = 4;
/// Contexts of what is foretold of an element and what became of the one before it.
const KINDS: usize = 8;
/// How far off an element is, either way, for one symbol to say it; more is told apart.
const NEAR: i32 = KindModel::KINDS as i32 / 2;
/// Contexts of a strip: what is foretold of it, and its neighbours.
const STRIPS: usize = 6 * 3 * 2;

/// Where the contexts of a level begin, for mean misses up to 63 quanta; the last is that of all larger ones.
const LEVEL: [u16; 64] = {
    let mut levels = [0; 64];
    let mut miss = 0;
    while miss < levels.len() {
        levels[miss] = match miss {
            0..=4 => miss as u16,
            5..=6 => 5,
            7..=9 => 6,
            10..=14 => 7,
            15..=21 => 8,
            22..=35 => 9,
            36..=60 => 10,
            _ => 11,
        } * (FRACTIONS * KINDS) as u16;
        miss += 1;
    }
    levels
};

/// How many kinds of strips there are, by how fast they are foretold to move.
pub(super) const PACES: usize = 4;
/// Elements of a strip, which are worked on at once.
pub(super) const STRIP: usize = 8;
/// What a strip is foretold from beside the last delta: of its elements, or of those beside them, one above another.
pub(super) type Hints = [i16x8; 8];

/// What is known of an element before its difference is: what the last delta and the hints foretell, in parts of a quantum.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outlook {
    predicted: i32,
}

impl Outlook {
    #[inline(always)]
    pub(super) const fn new(predicted: i32) -> Self {
        Self { predicted }
    }

    /// In quanta.
    #[inline(always)]
    const fn nearest(self) -> i16 {
        ((self.predicted + PARTS / 2) >> 3) as i16
    }

    /// All bits where what was foretold lies below what is nearest to it, else none.
    #[inline(always)]
    const fn mirror(self) -> i32 {
        ((self.predicted + PARTS / 2) >> 2 & 1) - 1
    }

    /// How far a difference is from what is nearest to what was foretold; towards that where it is more than nothing.
    #[inline(always)]
    pub(super) const fn off(self, difference: i16) -> i32 {
        (difference.wrapping_sub(self.nearest()) as i32 ^ self.mirror()) - self.mirror()
    }

    /// The difference that is so far.
    #[inline(always)]
    pub(super) const fn difference(self, off: i32) -> i16 {
        self.nearest().wrapping_add(((off ^ self.mirror()) - self.mirror()) as i16)
    }

    /// Context among those of its level; of a `kind`: one where the last delta foretells anything, and four more where the element
    /// before it, round the pot, changed.
    #[inline(always)]
    pub(super) const fn place(self, kind: u32) -> u32 {
        let near = self.predicted + PARTS / 2;
        let fraction = (near ^ self.mirror()) as u32 & (FRACTIONS as u32 - 1);
        let is_nothing = ((near as u32) < PARTS as u32) as u32;
        let is_much = ((near + 2 * PARTS) as u32 >= 5 * PARTS as u32) as u32;
        // no branch: nobody can guess
        let amount = (kind & 1 & is_nothing.wrapping_neg()) | ((2 + is_much) & is_nothing.wrapping_sub(1));
        fraction * KINDS as u32 + (kind & 4) + amount
    }
}

/// Contexts from where those of a level begin, for neighbours' misses weighted to a sum of eight, in parts of a quantum.
#[inline(always)]
pub(super) fn level(misses: u32) -> u32 {
    LEVEL[(((misses + 4) / 8) as usize).min(LEVEL.len() - 1)].into()
}

/// Weights of the hints, learned as they are used.
///
/// `p = m + Σ wᵢ·hᵢ`: m what the turned delta foretells, h the hints; after each strip, with the errors e of its elements,
/// `wᵢ += µ·Σ e·hᵢ / ⟨Σ h²⟩`, the normalised least mean squares of Widrow and Hoff (1960) with the mean over the strip for a divisor, rounded up
/// to a power of two. What a strip teaches is used from the next one on, so that a processor can work on its elements at once.
#[derive(Clone, Copy, Debug)]
pub(super) struct Weights([i16; 8]);

impl Weights {
    /// A weight of one.
    const ONE: i16 = 1 << 13;
    /// µ in 2⁻¹⁶.
    const STEP: i16 = 6000;
    /// Errors larger than this teach no more than this.
    const ERROR_MAX: i16 = 256;
    /// Two quanta apart, eight times: what keeps small hints from teaching much.
    const NOISE: u32 = 64 * STRIP as u32;

    /// As they come to stand on most strokes.
    const fn new() -> Self {
        Self([
            Self::ONE * 3 / 10,
            -Self::ONE / 16,
            Self::ONE / 6,
            -Self::ONE / 4,
            -Self::ONE / 8,
            Self::ONE / 16,
            Self::ONE * 3 / 8,
            Self::ONE / 2,
        ])
    }

    /// What all hints but the last say of each element, and the weight of the last: products of both with 2¹³.
    #[inline(always)]
    pub(super) fn sums(&self, hints: &[i16x8; 7]) -> ([i32; STRIP], i32) {
        let mut sums = i32x8::splat(0);
        for (hint, &weight) in hints.iter().zip(&self.0) {
            sums += hint.widening_mul(i16x8::splat(weight));
        }
        (sums.to_array(), i32::from(self.0[7]))
    }

    /// Takes in by how many parts of a quantum elements were foretold wrong; those that were foretold right say 0.
    #[inline(always)]
    pub(super) fn learn(&mut self, hints: &Hints, errors: i16x8) {
        let energy = hints.iter().fold(i32x4::splat(0), |sum, hint| sum + hint.dot(*hint)).to_array();
        let energy = energy.iter().fold(Self::NOISE, |sum, &part| sum + part as u32);
        // ten bits at least
        let bits = u32::BITS - energy.leading_zeros();
        let errors = errors.min(i16x8::splat(Self::ERROR_MAX)).max(i16x8::splat(-Self::ERROR_MAX));
        let steps = errors.widening_mul(i16x8::splat(Self::STEP)) << 6 >> (bits - 10) as i32;
        let steps = i16x8::from_i32x8_saturate(steps).max(i16x8::splat(-0x7fff));
        // of each hint a sum over the elements, four hints at once
        let sums = |hints: &[i16x8]| -> i32x4 {
            let [a, b, c, d] = i32x4::transpose(core::array::from_fn(|at| hints[at].dot(steps)));
            (a + b) + (c + d)
        };
        let (low, high) = (sums(&hints[..4]).to_array(), sums(&hints[4..]).to_array());
        let sums = i32x8::new([low[0], low[1], low[2], low[3], high[0], high[1], high[2], high[3]]);
        let learned = i32x8::from_i16x8(i16x8::new(self.0)) + ((sums + i32x8::splat(0x8000)) >> 16);
        let most = i16x8::splat(2 * Self::ONE);
        self.0 = i16x8::from_i32x8_saturate(learned).min(most).max(i16x8::splat(-2 * Self::ONE)).to_array();
    }

    fn code_state(&mut self, symbols: &mut impl Symbols) {
        for weight in &mut self.0 {
            *weight = (symbols.raw(*weight as u16 as u32, 16) as i16).clamp(-2 * Self::ONE, 2 * Self::ONE);
        }
    }
}

/// The learned state of a chain.
#[derive(Clone, Debug)]
pub(super) struct Models {
    /// Those of strips that are foretold to move more and more.
    pub(super) weights: [Weights; PACES],
    /// Whether a band of tiles holds a changed one, by whether one was foretold.
    pub(super) band: [BitModel; 2],
    /// Whether a tile changed, by whether that was foretold and by its neighbours.
    pub(super) tile: [BitModel; 8],
    strip: [BitModel; STRIPS],
    /// Whether an element is off what is nearest to what was foretold.
    is_off: [BitModel; LEVELS * FRACTIONS * KINDS],
    /// How far it then is.
    off: [KindModel; LEVELS * FRACTIONS],
    /// What is farther still.
    rest: Magnitude,
}

impl Models {
    pub(super) const fn new() -> Self {
        Self {
            weights: [Weights::new(); PACES],
            band: [BitModel::EVEN; 2],
            tile: [BitModel::EVEN; 8],
            strip: [BitModel::EVEN; STRIPS],
            is_off: [BitModel::EVEN; LEVELS * FRACTIONS * KINDS],
            off: [KindModel::even(); LEVELS * FRACTIONS],
            rest: Magnitude::new(),
        }
    }

    /// Whether anything changed in a strip: `foretold` elements of it should, `before` elements of the strip before it did,
    /// and the element below it.
    #[inline(always)]
    pub(super) fn strip(
        &mut self,
        symbols: &mut impl Symbols,
        any: bool,
        foretold: usize,
        before: usize,
        below: bool,
    ) -> bool {
        let context = (foretold.min(5) * 3 + before.div_ceil(3).min(2)) * 2 + usize::from(below);
        symbols.bit(&mut self.strip[context], any)
    }

    /// How far an element is off, as [`Outlook::off`], in a context of [`level`] and [`Outlook::place`].
    #[inline(always)]
    pub(super) fn off(&mut self, symbols: &mut impl Symbols, context: u32, off: i32) -> i32 {
        if !symbols.bit(&mut self.is_off[context as usize], off != 0) {
            return 0;
        }
        // none of them says nothing
        let kind = off.clamp(-NEAR, NEAR) + NEAR - i32::from(off > 0);
        let kind = symbols.kind(&mut self.off[context as usize / KINDS], kind as usize) as i32;
        let coded = kind - NEAR + i32::from(kind >= NEAR);
        if coded.abs() < NEAR {
            return coded;
        }
        let more = self.rest.code(symbols, off.unsigned_abs().wrapping_sub(NEAR as u32)) as i32;
        if coded < 0 { coded - more } else { coded + more }
    }

    /// Codes everything learned, so that another can go on from there.
    pub(super) fn code_state(&mut self, symbols: &mut impl Symbols) {
        for weights in &mut self.weights {
            weights.code_state(symbols);
        }
        let (is_new, is_slowest) = (&mut BitModel::EVEN.clone(), &mut BitModel::EVEN.clone());
        let [prefix, first_suffix] = self.rest.models();
        let parts: [&mut [BitModel]; 6] =
            [&mut self.band, &mut self.tile, &mut self.strip, &mut self.is_off, prefix, first_suffix];
        for model in parts.into_iter().flatten() {
            if symbols.bit(is_new, *model == BitModel::EVEN) {
                *model = BitModel::EVEN;
            } else {
                model.code_state(symbols, is_slowest);
            }
        }
        let (is_new, is_slowest) = (&mut BitModel::EVEN.clone(), &mut BitModel::EVEN.clone());
        let mut steps = [const { Magnitude::new() }; KindModel::KINDS - 1];
        for model in &mut self.off {
            if symbols.bit(is_new, *model == KindModel::even()) {
                *model = KindModel::even();
            } else {
                model.code_state(symbols, is_slowest, &mut steps);
            }
        }
    }
}
