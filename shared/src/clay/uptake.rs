//! Where the displacements of a press go: into a footprint, to be merged with others', or into the clay at once.
//!
//! Owns how eight elements take them up, and how a surface hears how narrow and wide it has become; what they are is the method's affair.
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
    #[inline(always)]
    fn raise<const INWARDS: bool>(&mut self, lanes: &mut [f32; LANES], push_m: f32x8<S>) {
        self.take(lanes, push_m);
    }
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
    span: Span<S>,
}

impl<S: Simd> Mover<S> {
    /// One that keeps the bounds of a surface.
    #[inline(always)]
    pub(super) fn of(simd: S, surface: &Surface) -> Self {
        let (low_m, high_m) = surface.bounds_m();
        Self { low_m: splat(simd, low_m), high_m: splat(simd, high_m), span: Span::none(simd) }
    }

    /// What radii become, m.
    #[inline(always)]
    fn moved(&mut self, radius_m: f32x8<S>, push_m: f32x8<S>) -> f32x8<S> {
        let kept_m = (radius_m + push_m).max(self.low_m).min(self.high_m);
        self.span.add(kept_m);
        kept_m
    }

    /// Tells the surface how narrow and how wide it has become.
    #[inline(always)]
    pub(super) fn note(&self, surface: &mut Surface) {
        self.span.note(surface);
    }
}

/// The narrowest and the widest radii that a surface was given, eight by eight, m.
#[derive(Clone, Copy)]
pub(super) struct Span<S: Simd> {
    narrowest_m: f32x8<S>,
    widest_m: f32x8<S>,
}

impl<S: Simd> Span<S> {
    /// That of no radius.
    #[inline(always)]
    pub(super) fn none(simd: S) -> Self {
        Self { narrowest_m: splat(simd, f32::MAX), widest_m: splat(simd, 0.0) }
    }

    #[inline(always)]
    fn add(&mut self, radii_m: f32x8<S>) {
        (self.narrowest_m, self.widest_m) = (self.narrowest_m.min(radii_m), self.widest_m.max(radii_m));
    }

    /// Gives elements above one another eight radii from one of them on, or as many as there are.
    #[inline(always)]
    pub(super) fn put(&mut self, elements_m: &mut [f32], at: usize, radii_m: f32x8<S>) {
        let simd = radii_m.simd;
        match elements_m[at..].first_chunk_mut::<LANES>() {
            Some(eight) => {
                self.add(radii_m);
                *eight = radii_m.to_array();
            }
            None => {
                let last_m = &mut elements_m[at..];
                for (last_m, radius_m) in last_m.iter_mut().zip(radii_m.to_array()) {
                    *last_m = radius_m;
                    self.add(splat(simd, radius_m));
                }
            }
        }
    }

    /// Tells the surface.
    #[inline(always)]
    pub(super) fn note(&self, surface: &mut Surface) {
        let (narrowest_m, widest_m) = (self.narrowest_m.to_array(), self.widest_m.to_array());
        surface.note_span(narrowest_m.into_iter().fold(f32::MAX, f32::min), widest_m.into_iter().fold(0.0, f32::max));
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
        self.bounds.note(self.surface);
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
            self.span.narrowest_m = self.span.narrowest_m.min(kept_m);
            kept_m
        } else {
            let kept_m = reached_m.min(self.high_m);
            self.span.widest_m = self.span.widest_m.max(kept_m);
            kept_m
        }
        .to_array();
    }
}
