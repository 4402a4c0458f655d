//! A code for how something moves along three axes from tick to tick, in whole steps.
//!
//! Owns the prediction of a step and the bits of what it missed; what moves is for others to know.
//! Invariant: what is decoded from an encoding is what went in; of other bytes come some steps, within bounds.
//!
//! A hand goes on as it went, and where it is is only told to a step, so that its velocity is known best from several ticks:
//! it is smoothed, at first as their mean. What is left is mostly nothing, and less often so where the velocity stands near the
//! middle between two steps: then it is mostly the other one of both. Each axis knows of itself how wrong it was.

use super::adaptive::BitModel;
use super::coder::Symbols;
use super::magnitude::Magnitude;

/// Contexts by how wrong the last steps were foreseen.
const CONTEXTS: usize = 6;
/// Share of steps that are foreseen in each, of 4096, until there is more to go by.
const FORESEEN: [u16; CONTEXTS] = [3277, 2458, 2048, 1638, 1024, 410];
/// Share of misses towards the nearer of the two other steps, where the velocity stands nearer to it than a quarter of a step.
const TOWARDS: u16 = 3072;
/// Share of the news in a velocity, as a power of two, and in how it changes.
const NEWS: u32 = 2;
const NEWS_OF_CHANGE: u32 = 3;
/// Parts of a step in which a velocity is kept.
const UNIT: i32 = 64;
/// Largest velocity, and change of one, so that none is too large to count with: a million steps.
const VELOCITY_MAX: i32 = UNIT << 20;

/// A number with a sign, coded as zero flag, sign and magnitude.
#[derive(Debug)]
pub(crate) struct Signed {
    zero: BitModel,
    sign: BitModel,
    magnitude: Magnitude,
}

impl Signed {
    pub(crate) const fn new() -> Self {
        Self { zero: BitModel::EVEN, sign: BitModel::EVEN, magnitude: Magnitude::new() }
    }

    pub(crate) fn code(&mut self, symbols: &mut impl Symbols, value: i32) -> i32 {
        if !symbols.bit(&mut self.zero, value != 0) {
            return 0;
        }
        let negative = symbols.bit(&mut self.sign, value < 0);
        signed(negative, beyond_one(symbols, &mut self.magnitude, value))
    }
}

/// How far a number is from zero, of one that is not zero.
fn beyond_one(symbols: &mut impl Symbols, magnitude: &mut Magnitude, value: i32) -> i32 {
    magnitude.code(symbols, value.unsigned_abs().saturating_sub(1)).min(1 << 19) as i32 + 1
}

const fn signed(negative: bool, magnitude: i32) -> i32 {
    if negative { -magnitude } else { magnitude }
}

/// What a coder has learned of steps.
#[derive(Debug)]
pub(crate) struct StepModel {
    /// Whether the velocity is foretold to go on changing as it did.
    bends: bool,
    /// By how wrong the last steps were, and whether the velocity stands near the middle between two.
    foreseen: [[BitModel; 2]; CONTEXTS],
    towards: [BitModel; 2],
    magnitude: [Magnitude; CONTEXTS],
}

impl StepModel {
    /// Of a hand's place.
    pub(crate) const fn of_places() -> Self {
        Self::new(false)
    }

    /// Of a tool's angles, which change their pace sooner, measured in the steps in which they are told.
    pub(crate) const fn of_angles() -> Self {
        Self::new(true)
    }

    const fn new(bends: bool) -> Self {
        let mut foreseen = [[BitModel::EVEN; 2]; CONTEXTS];
        let mut context = 0;
        while context < CONTEXTS {
            foreseen[context] = [BitModel::zero_in_4096(FORESEEN[context]); 2];
            context += 1;
        }
        Self {
            bends,
            foreseen,
            towards: [BitModel::EVEN, BitModel::zero_in_4096(TOWARDS)],
            magnitude: [const { Magnitude::new() }; CONTEXTS],
        }
    }
}

/// How something has moved so far.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Movement {
    axes: [Axis; 3],
    /// Steps seen, as far as they change how fast the velocity follows.
    seen: u32,
}

#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    /// What is foretold of the next step, in 64ths of a step a tick.
    velocity: i32,
    /// How it changes from tick to tick.
    change: i32,
    /// How wrong the last steps were, in steps.
    wrong: u32,
}

impl Movement {
    /// One of which a step is known.
    pub(crate) fn after(step: [i32; 3]) -> Self {
        let mut movement = Self::default();
        movement.learn(step, [0; 3], false);
        movement
    }

    /// Codes the next step, or ignores it and returns the one that was coded.
    pub(crate) fn step(&mut self, symbols: &mut impl Symbols, model: &mut StepModel, step: [i32; 3]) -> [i32; 3] {
        let (mut coded, mut missed) = ([0; 3], [0; 3]);
        for (at, axis) in self.axes.iter().enumerate() {
            let raised = axis.velocity + UNIT / 2;
            let (foreseen, part) = (raised.div_euclid(UNIT), raised.rem_euclid(UNIT));
            // in the lower half the step below is nearer than the one above
            let (is_lower, is_edge) = (part < UNIT / 2, !(UNIT / 4..3 * UNIT / 4).contains(&part));
            let context = ((u32::BITS - axis.wrong.leading_zeros()) as usize).min(CONTEXTS - 1);
            let miss = step[at].wrapping_sub(foreseen);
            let mut found = 0;
            if symbols.bit(&mut model.foreseen[context][usize::from(is_edge)], miss != 0) {
                let away = symbols.bit(&mut model.towards[usize::from(is_edge)], (miss < 0) != is_lower);
                found = signed(away != is_lower, beyond_one(symbols, &mut model.magnitude[context], miss));
            }
            missed[at] = found;
            coded[at] = foreseen + found;
        }
        self.learn(coded, missed, model.bends);
        coded
    }

    fn learn(&mut self, step: [i32; 3], missed: [i32; 3], bends: bool) {
        // the mean of the first, as far as halves and quarters go
        let shift = NEWS.min(self.seen.div_ceil(2));
        for ((axis, step), missed) in self.axes.iter_mut().zip(step).zip(missed) {
            let moved = step.saturating_mul(UNIT).clamp(-VELOCITY_MAX, VELOCITY_MAX);
            let news = moved - axis.velocity;
            if bends && self.seen > 0 {
                axis.change = (axis.change + (news >> NEWS_OF_CHANGE)).clamp(-VELOCITY_MAX, VELOCITY_MAX);
            }
            let velocity = axis.velocity + (news >> shift) + axis.change;
            axis.velocity = velocity.clamp(-VELOCITY_MAX, VELOCITY_MAX);
            axis.wrong = (axis.wrong + 2 * missed.unsigned_abs()).div_ceil(2);
        }
        self.seen = (self.seen + 1).min(8);
    }
}
