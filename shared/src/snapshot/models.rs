//! What is learned of a chain: how likely every symbol is in its context, and the weights by which an element is foretold.
//!
//! Knows neither tiles nor the order of symbols. Integers only, so that both ends learn the same.
//! Invariant: coding and decoding the same symbols leaves both ends' models in the same state.

use wide::{i16x8, i32x4, i32x8};

use super::coder::{BitModel, Symbols};
use super::magnitude::Magnitude;
use super::motion::PARTS;

/// Contexts of how far elements near by were from what was foretold of them.
const LEVELS: usize = 12;
/// Contexts of where between two quanta the foretold value lies.
const FRACTIONS: usize = 4;
/// Contexts of what is foretold of an element and what became of the one before it.
const KINDS: usize = 8;
const SIGN_LEVELS: usize = 7;
/// Magnitudes that are counted in contexts of their own.
const COUNTED: usize = 8;
/// Contexts of a strip: what is foretold of it, and its neighbours.
const STRIPS: usize = 6 * 3 * 2;

/// Levels of mean misses up to 63 quanta; the last is that of all larger ones.
const LEVEL: [u8; 64] = {
    let mut levels = [0; 64];
    let mut miss = 0;
    while miss < levels.len() {
        levels[miss] = match miss {
            0..=4 => miss as u8,
            5..=6 => 5,
            7..=9 => 6,
            10..=14 => 7,
            15..=21 => 8,
            22..=35 => 9,
            36..=60 => 10,
            _ => 11,
        };
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

/// What is known of an element before its difference is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outlook {
    /// What the last delta and the hints foretell, in parts of a quantum, and half a quantum more.
    pub(super) near: i32,
    /// How far neighbours' predictions were off, in parts of a quantum, as far as [`LEVEL`] goes.
    pub(super) miss: u32,
    /// Context among those of its level.
    pub(super) place: u32,
}

impl Outlook {
    /// As it is in [`Outlook::near`].
    #[inline(always)]
    pub(super) const fn near(predicted: i32) -> i32 {
        predicted + PARTS / 2
    }

    /// Of neighbours' misses, weighted to a sum of eight.
    #[inline(always)]
    pub(super) fn miss(misses: u32) -> u32 {
        ((misses + 4) / 8).min(LEVEL.len() as u32 - 1)
    }

    /// Of a `kind`: one where the last delta foretells anything, and four more where the element before it, round the pot, changed.
    #[inline(always)]
    pub(super) fn place(near: i32, kind: u32) -> u32 {
        // how far from the middle between two quanta
        let fraction = ((near & 7) - 4).unsigned_abs().min(FRACTIONS as u32 - 1);
        let is_nothing = (near as u32) < PARTS as u32;
        let is_little = (near.wrapping_add(2 * PARTS) as u32) < 5 * PARTS as u32;
        fraction * KINDS as u32 + if is_nothing { kind } else { (kind & 4) + 3 - is_little as u32 }
    }
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
        for (weight, hint) in self.0.iter_mut().zip(hints) {
            let [a, b, c, d] = hint.dot(steps).to_array();
            let learned = i32::from(*weight) + ((a + b + c + d + 0x8000) >> 16);
            *weight = learned.clamp((-2 * Self::ONE).into(), (2 * Self::ONE).into()) as i16;
        }
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
    hit: [BitModel; LEVELS * FRACTIONS * KINDS],
    sign: [BitModel; SIGN_LEVELS * FRACTIONS],
    longer: [[BitModel; COUNTED]; LEVELS],
    rest: Magnitude,
}

impl Models {
    pub(super) const fn new() -> Self {
        Self {
            weights: [Weights::new(); PACES],
            band: [BitModel::EVEN; 2],
            tile: [BitModel::EVEN; 8],
            strip: [BitModel::EVEN; STRIPS],
            hit: [BitModel::EVEN; LEVELS * FRACTIONS * KINDS],
            sign: [BitModel::EVEN; SIGN_LEVELS * FRACTIONS],
            longer: [[BitModel::EVEN; COUNTED]; LEVELS],
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

    /// The difference of one element, and whether it was foretold right.
    #[inline(always)]
    pub(super) fn element(&mut self, symbols: &mut impl Symbols, outlook: &Outlook, difference: i16) -> (i16, bool) {
        let (nearest, is_above) = (outlook.near >> 3, outlook.near & 4 != 0);
        let (level, place) = (usize::from(LEVEL[outlook.miss as usize]), outlook.place as usize);
        let off = difference.wrapping_sub(nearest as i16);
        if !symbols.bit(&mut self.hit[level * FRACTIONS * KINDS + place], off != 0) {
            return (nearest as i16, true);
        }
        let sign = &mut self.sign[level.min(SIGN_LEVELS - 1) * FRACTIONS + place / KINDS];
        let is_up = symbols.side(sign, (off > 0) != is_above) != is_above;
        let size = self.magnitude(symbols, level, u32::from(off.unsigned_abs()).wrapping_sub(1)) + 1;
        let off = if is_up { size as i16 } else { (size as i16).wrapping_neg() };
        ((nearest as i16).wrapping_add(off), false)
    }

    /// A number from zero up: counted as far as contexts go.
    #[inline(always)]
    fn magnitude(&mut self, symbols: &mut impl Symbols, level: usize, value: u32) -> u32 {
        for (count, longer) in (0..).zip(&mut self.longer[level]) {
            if !symbols.bit(longer, value > count) {
                return count;
            }
        }
        COUNTED as u32 + self.rest.code(symbols, value.wrapping_sub(COUNTED as u32))
    }

    /// Codes everything learned, so that another can go on from there.
    pub(super) fn code_state(&mut self, symbols: &mut impl Symbols) {
        for weights in &mut self.weights {
            weights.code_state(symbols);
        }
        let is_new = &mut BitModel::EVEN.clone();
        let [prefix, first_suffix] = self.rest.models();
        let parts: [&mut [BitModel]; 8] = [
            &mut self.band,
            &mut self.tile,
            &mut self.strip,
            &mut self.hit,
            &mut self.sign,
            self.longer.as_flattened_mut(),
            prefix,
            first_suffix,
        ];
        for model in parts.into_iter().flatten() {
            if symbols.bit(is_new, *model == BitModel::EVEN) {
                *model = BitModel::EVEN;
            } else {
                model.code_state(symbols);
            }
        }
    }
}
