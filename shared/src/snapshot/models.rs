//! What is learned of a chain: how likely every symbol is in its context, and the weights by which an element is foretold.
//!
//! Knows neither tiles nor the order of symbols. Integers only, so that both ends learn the same.
//! Invariant: coding and decoding the same symbols leaves both ends' models in the same state.

use wide::i16x8;

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

/// What is known of an element before its difference is.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outlook {
    /// What the last delta foretells, in parts of a quantum.
    pub(super) foretold: i32,
    /// Misses of the four neighbours that are known and four slopes of what is foretold, in parts of a quantum.
    pub(super) hints: i16x8,
    /// How far neighbours' predictions were off, weighted to a sum of eight, in parts of a quantum.
    pub(super) misses: u32,
    /// Whether the element before it, round the pot, changed.
    pub(super) after_change: bool,
}

/// Weights of the hints, learned as they are used.
///
/// `p = m + Σ wᵢ·hᵢ`: m what the turned delta foretells, h the hints; after each element, with its error e,
/// `wᵢ += µ·e·hᵢ / Σ h²`, the normalised least mean squares of Widrow and Hoff (1960). The divisor is rounded up to a power
/// of two. What an element teaches is used from the next but one on, so that a processor can work on both at once.
#[derive(Clone, Copy, Debug)]
struct Weights {
    now: i16x8,
    /// What the last element taught.
    lesson: i16x8,
}

impl Weights {
    /// A weight of one.
    const ONE: i16 = 1 << 13;
    /// µ in 2⁻¹⁶.
    const STEP: i32 = 6000;
    /// Errors larger than this teach no more than this.
    const ERROR_MAX: i32 = 256;
    /// Two quanta apart: what keeps small hints from teaching much.
    const NOISE: u32 = 64;

    /// As they come to stand on most strokes.
    const fn new() -> Self {
        let now = i16x8::new([
            Self::ONE * 3 / 10,
            -Self::ONE / 16,
            Self::ONE / 6,
            -Self::ONE / 4,
            -Self::ONE / 8,
            Self::ONE / 16,
            Self::ONE * 3 / 8,
            Self::ONE / 2,
        ]);
        Self { now, lesson: i16x8::new([0; 8]) }
    }

    fn sum(self, hints: i16x8) -> i32 {
        self.now.dot(hints).reduce_add() >> 13
    }

    fn learn(&mut self, hints: i16x8, error: i32) {
        let energy = hints.dot(hints).reduce_add() as u32 + Self::NOISE;
        let bits = u32::BITS - energy.leading_zeros();
        let error = i64::from(error.clamp(-Self::ERROR_MAX, Self::ERROR_MAX) * Self::STEP);
        let step = (error << 13 >> bits).clamp(-0x7fff, 0x7fff) as i16;
        let step = i16x8::splat(step);
        let most = i16x8::splat(2 * Self::ONE);
        let weights: i16x8 = self.now + self.lesson;
        self.now = weights.min(most).max(-most);
        // hint times step over 2¹⁶, rounded to the nearest
        self.lesson = hints.mul_keep_high(step) - ((hints * step) >> 15);
    }

    fn code_state(&mut self, symbols: &mut impl Symbols) {
        let mut part = |part: i16x8, most: i16| {
            i16x8::new(part.to_array().map(|value| (symbols.raw(value as u16 as u32, 16) as i16).clamp(-most, most)))
        };
        self.now = part(self.now, 2 * Self::ONE);
        self.lesson = part(self.lesson, Self::ONE);
    }
}

/// The learned state of a chain.
#[derive(Clone, Debug)]
pub(super) struct Models {
    weights: Weights,
    /// Whether a band of tiles holds a changed one, by whether one was foretold.
    pub(super) band: [BitModel; 2],
    /// Whether a tile changed, by whether that was foretold and by its neighbours.
    pub(super) tile: [BitModel; 8],
    strip: [BitModel; STRIPS],
    hit: [BitModel; LEVELS * FRACTIONS * KINDS],
    sign: [BitModel; SIGN_LEVELS * FRACTIONS],
    longer: [BitModel; LEVELS * COUNTED],
    rest: Magnitude,
}

impl Models {
    pub(super) const fn new() -> Self {
        Self {
            weights: Weights::new(),
            band: [BitModel::EVEN; 2],
            tile: [BitModel::EVEN; 8],
            strip: [BitModel::EVEN; STRIPS],
            hit: [BitModel::EVEN; LEVELS * FRACTIONS * KINDS],
            sign: [BitModel::EVEN; SIGN_LEVELS * FRACTIONS],
            longer: [BitModel::EVEN; LEVELS * COUNTED],
            rest: Magnitude::new(),
        }
    }

    /// Whether anything changed in a strip: `foretold` elements of it should, `before` elements of the strip before it did,
    /// and the element below it.
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

    /// The difference of one element, and by how many parts of a quantum it was foretold wrong.
    #[inline]
    pub(super) fn element(&mut self, symbols: &mut impl Symbols, outlook: &Outlook, difference: i16) -> (i16, i32) {
        let predicted = outlook.foretold + self.weights.sum(outlook.hints);
        let nearest = (predicted + PARTS / 2) >> 3;
        // −4 to 3: how far above the nearest quantum
        let above = predicted - nearest * PARTS;
        let fraction = (above.unsigned_abs() as usize).min(FRACTIONS - 1);
        let level = usize::from(LEVEL[((outlook.misses + 4) / 8).min(63) as usize]);
        let kind = match (nearest.unsigned_abs(), outlook.foretold) {
            (0, 0) => 0,
            (0, _) => 1,
            (1..=2, _) => 2,
            _ => 3,
        } + 4 * usize::from(outlook.after_change);
        let off = difference.wrapping_sub(nearest as i16);
        let off = if symbols.bit(&mut self.hit[(level * FRACTIONS + fraction) * KINDS + kind], off != 0) {
            let is_towards = (off > 0) == (above >= 0);
            let sign = &mut self.sign[level.min(SIGN_LEVELS - 1) * FRACTIONS + fraction];
            let is_up = symbols.bit(sign, !is_towards) != (above >= 0);
            let size = self.magnitude(symbols, level, u32::from(off.unsigned_abs()).wrapping_sub(1)) + 1;
            if is_up { size as i16 } else { (size as i16).wrapping_neg() }
        } else {
            0
        };
        let difference = (nearest as i16).wrapping_add(off);
        let error = i32::from(difference) * PARTS - predicted;
        if off != 0 {
            self.weights.learn(outlook.hints, error);
        }
        (difference, error)
    }

    /// A number from zero up: counted as far as contexts go.
    fn magnitude(&mut self, symbols: &mut impl Symbols, level: usize, value: u32) -> u32 {
        for count in 0..COUNTED as u32 {
            if !symbols.bit(&mut self.longer[level * COUNTED + count as usize], value > count) {
                return count;
            }
        }
        COUNTED as u32 + self.rest.code(symbols, value.wrapping_sub(COUNTED as u32))
    }

    /// Codes everything learned, so that another can go on from there.
    pub(super) fn code_state(&mut self, symbols: &mut impl Symbols) {
        self.weights.code_state(symbols);
        let is_new = &mut BitModel::EVEN.clone();
        let [prefix, first_suffix] = self.rest.models();
        let parts: [&mut [BitModel]; 8] = [
            &mut self.band,
            &mut self.tile,
            &mut self.strip,
            &mut self.hit,
            &mut self.sign,
            &mut self.longer,
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
