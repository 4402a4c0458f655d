//! Eight numbers worked on at once, with the widest vectors that the processor has.
//!
//! Owns how eight lanes are kept, read and summed; what is done with them is the methods'. A pass over the clay is written once, for
//! any vectors, and compiled for each kind; all of it has to be `#[inline(always)]`, or what is called would be compiled for the
//! narrowest.
//! Invariant: the lanes and the order of their sums are the same whatever the processor offers, and no product is joined with a
//! sum, so that results are the same bits.

pub(super) use fearless_simd::prelude::*;
pub(super) use fearless_simd::{Level, f32x8, i32x8, mask32x8, u32x8};

/// Elements worked on at once.
pub(super) const LANES: usize = 8;

/// Vectors in which the clay is worked on; its result is the same with any.
#[derive(Clone, Copy, Debug)]
pub struct Vectors(pub(crate) Level);

impl Default for Vectors {
    /// The widest that this processor has.
    fn default() -> Self {
        Self(Level::try_detect().unwrap_or(Level::baseline()))
    }
}

impl Vectors {
    /// Those that every processor of its kind has, for comparison.
    #[must_use]
    pub const fn baseline() -> Self {
        Self(Level::baseline())
    }
}

/// Runs a pass with a machine's [`Vectors`].
///
/// With those of sixteen numbers, of which ours fill a half, a step takes longer: they are left out.
macro_rules! with_vectors {
    ($vectors:expr, $simd:ident => $pass:expr) => {{
        let level = $vectors.0;
        #[cfg(any(target_arch = "x86", target_arch = "x86_64"))]
        if let Some($simd) = level.as_avx2() {
            fearless_simd::Simd::vectorize($simd, #[inline(always)] || $pass)
        } else if let Some($simd) = level.as_sse2() {
            fearless_simd::Simd::vectorize($simd, #[inline(always)] || $pass)
        } else {
            unreachable!("every processor of this kind has the narrowest vectors")
        }
        #[cfg(not(any(target_arch = "x86", target_arch = "x86_64")))]
        fearless_simd::dispatch!(level, $simd => $pass)
    }};
}
pub(crate) use with_vectors;

/// A part of a pass that is a function of its own, so that its figures find room in the registers.
#[inline(never)]
pub(super) fn apart<S: Simd, R>(simd: S, part: impl FnOnce() -> R) -> R {
    simd.vectorize(part)
}

/// Eight numbers at rest.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(super) struct Eight(pub(super) [f32; LANES]);

impl Eight {
    pub(super) const ZERO: Self = Self([0.0; LANES]);

    /// The numbers, to be worked on.
    #[inline(always)]
    pub(super) fn on<S: Simd>(&self, simd: S) -> f32x8<S> {
        f32x8::load_array_ref(simd, &self.0)
    }
}

impl<S: Simd> From<f32x8<S>> for Eight {
    #[inline(always)]
    fn from(lanes: f32x8<S>) -> Self {
        Self(lanes.to_array())
    }
}

/// The same number eight times.
#[inline(always)]
pub(super) fn splat<S: Simd>(simd: S, value: f32) -> f32x8<S> {
    f32x8::splat(simd, value)
}

/// `lanes` where `there`, zero elsewhere.
#[inline(always)]
pub(super) fn only<S: Simd>(there: mask32x8<S>, lanes: f32x8<S>) -> f32x8<S> {
    let there: u32x8<S> = there.to_vector().bitcast();
    f32x8::from_bits(lanes.to_bits() & there)
}

/// Which lanes are greater than zero.
#[inline(always)]
pub(super) fn positive<S: Simd>(lanes: f32x8<S>) -> mask32x8<S> {
    lanes.simd_gt(splat(lanes.simd, 0.0))
}

/// `from`, and one more from lane to lane.
#[inline(always)]
pub(super) fn counted<S: Simd>(simd: S, from: f32) -> f32x8<S> {
    f32x8::load_array_ref(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) + from
}

/// Up to eight values, the rest zero.
#[inline(always)]
pub(super) fn load<S: Simd>(simd: S, values: &[f32]) -> f32x8<S> {
    let mut lanes = [0.0; LANES];
    lanes[..values.len()].copy_from_slice(values);
    f32x8::load_array_ref(simd, &lanes)
}

/// The sum of all lanes, in one order everywhere.
#[inline(always)]
pub(super) fn sum<S: Simd>(lanes: f32x8<S>) -> f32 {
    let [a, b, c, d, e, f, g, h] = lanes.to_array();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// The square root of a number, for code among vectors.
///
/// The same as libm's, which is an instruction without vectors: where they are wider than 16 bytes, a processor stops for it.
#[inline(always)]
pub(super) fn root(square: f32) -> f32 {
    wide::f32x4::splat(square).sqrt().to_array()[0]
}
