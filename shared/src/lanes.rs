//! Eight numbers worked on at once, with the widest vectors that the processor has.
//!
//! Owns how eight lanes are kept, read and summed; what is done with them is clay's and tools'. A pass is written once, for
//! any vectors, and compiled for each kind; all of it has to be `#[inline(always)]`, or what is called would be compiled for the
//! narrowest.
//! Invariant: the lanes and the order of their sums are the same whatever the processor offers, and no product is joined with a
//! sum, so that results are the same bits.

pub(crate) use fearless_simd::prelude::*;
pub(crate) use fearless_simd::{Level, f32x8, i32x8, mask32x8, u32x4, u32x8};

/// Elements worked on at once.
pub(crate) const LANES: usize = 8;

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
pub(crate) fn apart<S: Simd, R>(simd: S, part: impl FnOnce() -> R) -> R {
    simd.vectorize(part)
}

/// Eight numbers at rest.
#[derive(Clone, Copy, Debug, Default)]
#[repr(C, align(32))]
pub(crate) struct Eight(pub(crate) [f32; LANES]);

impl Eight {
    pub(crate) const ZERO: Self = Self([0.0; LANES]);

    /// The numbers, to be worked on.
    #[inline(always)]
    pub(crate) fn on<S: Simd>(&self, simd: S) -> f32x8<S> {
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
pub(crate) fn splat<S: Simd>(simd: S, value: f32) -> f32x8<S> {
    f32x8::splat(simd, value)
}

/// `lanes` where `there`, zero elsewhere.
#[inline(always)]
pub(crate) fn only<S: Simd>(there: mask32x8<S>, lanes: f32x8<S>) -> f32x8<S> {
    let there: u32x8<S> = there.to_vector().bitcast();
    f32x8::from_bits(lanes.to_bits() & there)
}

/// `lanes` where they are numbers, zero elsewhere: what is not a number is equal to nothing.
#[inline(always)]
pub(crate) fn numbers<S: Simd>(lanes: f32x8<S>) -> f32x8<S> {
    only(lanes.simd_eq(lanes), lanes)
}

/// Which lanes are greater than zero.
#[inline(always)]
pub(crate) fn positive<S: Simd>(lanes: f32x8<S>) -> mask32x8<S> {
    lanes.simd_gt(splat(lanes.simd, 0.0))
}

/// `from`, and one more from lane to lane.
#[inline(always)]
pub(crate) fn counted<S: Simd>(simd: S, from: f32) -> f32x8<S> {
    f32x8::load_array_ref(simd, &[0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]) + from
}

/// Up to eight values, the rest zero.
#[inline(always)]
pub(crate) fn load<S: Simd>(simd: S, values: &[f32]) -> f32x8<S> {
    let mut lanes = [0.0; LANES];
    lanes[..values.len()].copy_from_slice(values);
    f32x8::load_array_ref(simd, &lanes)
}

/// Eight of some values from one of them on, or the last ones and zeros.
#[inline(always)]
pub(crate) fn eight<S: Simd>(simd: S, values: &[f32], at: usize) -> f32x8<S> {
    match values[at..].first_chunk::<LANES>() {
        Some(eight) => f32x8::load_array_ref(simd, eight),
        None => load(simd, &values[at..]),
    }
}

/// Eight rows of four numbers' bits, given one by one, as columns.
#[inline(always)]
pub(crate) fn columns<S: Simd>(simd: S, mut row: impl FnMut(usize) -> [u32; 4]) -> [u32x8<S>; 4] {
    // written out: mapped, they would be functions of their own
    let [x, y, z, w] = four_columns(simd, [row(0), row(1), row(2), row(3)]);
    let [others_x, others_y, others_z, others_w] = four_columns(simd, [row(4), row(5), row(6), row(7)]);
    [x.combine(others_x), y.combine(others_y), z.combine(others_z), w.combine(others_w)]
}

#[inline(always)]
fn four_columns<S: Simd>(simd: S, [a, b, c, d]: [[u32; 4]; 4]) -> [u32x4<S>; 4] {
    let (a, b) = (u32x4::load_array(simd, a), u32x4::load_array(simd, b));
    let (c, d) = (u32x4::load_array(simd, c), u32x4::load_array(simd, d));
    let (first, second) = (a.zip_low(c), b.zip_low(d));
    let (third, fourth) = (a.zip_high(c), b.zip_high(d));
    [first.zip_low(second), first.zip_high(second), third.zip_low(fourth), third.zip_high(fourth)]
}

/// The sum of all lanes, in one order everywhere.
#[inline(always)]
pub(crate) fn sum<S: Simd>(lanes: f32x8<S>) -> f32 {
    let [a, b, c, d, e, f, g, h] = lanes.to_array();
    ((a + e) + (c + g)) + ((b + f) + (d + h))
}

/// The square root of a number, for code among vectors.
///
/// The same as libm's, which is an instruction without vectors: where they are wider than 16 bytes, a processor stops for it.
#[inline(always)]
pub(crate) fn root(square: f32) -> f32 {
    wide::f32x4::splat(square).sqrt().to_array()[0]
}

/// The length of a vector of two numbers, for code among vectors: a call, before which they are put away, and no root among them.
#[inline(never)]
pub(crate) fn hypot(x: f32, y: f32) -> f32 {
    libm::hypotf(x, y)
}
