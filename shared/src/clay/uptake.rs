//! Where the displacements of a press go: into a footprint, to be merged with others', or into the clay at once.
//!
//! Owns how eight elements take them up; what they are is the method's affair.
//! Invariant: clay is the same to the bit on both ways.

use core::ops::Range;

use super::lanes::{LANES, Simd, SimdBase, f32x8, splat};
use super::{Footprint, Surface, Window};

/// What takes up the displacements of a press, column by column of a window.
pub(super) trait Uptake<S: Simd> {
    /// What takes up those of eight elements.
    type Taker: Taker<S>;

    /// Begins with a window.
    fn begin(&mut self, window: Window);

    /// Eights of the window's column `local`, every one of which is to be taken up, and what takes them.
    fn column(&mut self, local: usize, eights: Range<usize>) -> (&mut [[f32; LANES]], &mut Self::Taker);
}

/// What takes up displacements eight by eight.
pub(super) trait Taker<S: Simd> {
    /// Takes up those of eight elements, m.
    fn take(&mut self, lanes: &mut [f32; LANES], push_m: f32x8<S>);

    /// The same of elements none of which is pushed the other way.
    fn raise<const INWARDS: bool>(&mut self, lanes: &mut [f32; LANES], push_m: f32x8<S>);
}

/// Displacements are noted.
pub(super) struct Noted<'a>(&'a mut Footprint, Note);

impl<'a> Noted<'a> {
    pub(super) const fn in_footprint(footprint: &'a mut Footprint) -> Self {
        Self(footprint, Note)
    }
}

/// Notes displacements.
pub(super) struct Note;

impl<S: Simd> Uptake<S> for Noted<'_> {
    type Taker = Note;

    #[inline(always)]
    fn begin(&mut self, window: Window) {
        self.0.lay(window);
    }

    #[inline(always)]
    fn column(&mut self, local: usize, eights: Range<usize>) -> (&mut [[f32; LANES]], &mut Note) {
        (self.0.narrow(local, eights), &mut self.1)
    }
}

impl<S: Simd> Taker<S> for Note {
    #[inline(always)]
    fn take(&mut self, lanes: &mut [f32; LANES], push_m: f32x8<S>) {
        *lanes = push_m.to_array();
    }

    #[inline(always)]
    fn raise<const INWARDS: bool>(&mut self, lanes: &mut [f32; LANES], push_m: f32x8<S>) {
        *lanes = push_m.to_array();
    }
}

/// Clay is moved at once, on a grid whose columns are whole eights.
pub(super) struct Moved<'a, S: Simd> {
    surface: &'a mut Surface,
    window: Window,
    bounds: Mover<S>,
}

/// Moves radii within bounds by pushes that are numbers.
pub(super) struct Mover<S: Simd> {
    low_m: f32x8<S>,
    high_m: f32x8<S>,
    /// Of all that were moved.
    narrowest_m: f32x8<S>,
    widest_m: f32x8<S>,
}

impl<S: Simd> Mover<S> {
    /// One that keeps the bounds of a surface.
    #[inline(always)]
    pub(super) fn of(simd: S, surface: &Surface) -> Self {
        let (low_m, high_m) = surface.bounds_m();
        let (low_m, high_m) = (splat(simd, low_m), splat(simd, high_m));
        Self { low_m, high_m, narrowest_m: high_m, widest_m: low_m }
    }

    /// What radii become, m.
    #[inline(always)]
    fn moved(&mut self, radius_m: f32x8<S>, push_m: f32x8<S>) -> f32x8<S> {
        let kept_m = (radius_m + push_m).max(self.low_m).min(self.high_m);
        (self.narrowest_m, self.widest_m) = (self.narrowest_m.min(kept_m), self.widest_m.max(kept_m));
        kept_m
    }

    /// The narrowest and the widest that there were, m.
    #[inline(always)]
    pub(super) fn span_m(&self) -> (f32, f32) {
        let (narrowest_m, widest_m) = (self.narrowest_m.to_array(), self.widest_m.to_array());
        (narrowest_m.into_iter().fold(f32::MAX, f32::min), widest_m.into_iter().fold(f32::MIN, f32::max))
    }
}

impl<'a, S: Simd> Moved<'a, S> {
    #[inline(always)]
    pub(super) fn on(simd: S, surface: &'a mut Surface) -> Self {
        let bounds = Mover::of(simd, surface);
        Self { surface, window: Window::default(), bounds }
    }
}

impl<S: Simd> Drop for Moved<'_, S> {
    #[inline(always)]
    fn drop(&mut self) {
        let (narrowest_m, widest_m) = self.bounds.span_m();
        self.surface.note_span(narrowest_m, widest_m);
    }
}

impl<S: Simd> Uptake<S> for Moved<'_, S> {
    type Taker = Mover<S>;

    #[inline(always)]
    fn begin(&mut self, window: Window) {
        self.window = window;
    }

    #[inline(always)]
    fn column(&mut self, local: usize, eights: Range<usize>) -> (&mut [[f32; LANES]], &mut Mover<S>) {
        let columns = self.surface.shape().columns();
        let column = self.window.first_column + local as u32;
        let column = if column < columns { column } else { column - columns };
        let first_row = self.window.first_row + (eights.start * LANES) as u32;
        let radii_m = self.surface.run_mut(column, first_row, eights.len() * LANES);
        (radii_m.as_chunks_mut().0, &mut self.bounds)
    }
}

impl<S: Simd> Taker<S> for Mover<S> {
    #[inline(always)]
    fn take(&mut self, lanes: &mut [f32; LANES], push_m: f32x8<S>) {
        *lanes = self.moved(f32x8::load_array_ref(push_m.simd, lanes), push_m).to_array();
    }

    #[inline(always)]
    fn raise<const INWARDS: bool>(&mut self, lanes: &mut [f32; LANES], push_m: f32x8<S>) {
        let reached_m = f32x8::load_array_ref(push_m.simd, lanes) + push_m;
        *lanes = if INWARDS {
            let kept_m = reached_m.max(self.low_m);
            self.narrowest_m = self.narrowest_m.min(kept_m);
            kept_m
        } else {
            let kept_m = reached_m.min(self.high_m);
            self.widest_m = self.widest_m.max(kept_m);
            kept_m
        }
        .to_array();
    }
}
