//! One sub-step of the clay: every press evaluated against the same field, then merged symmetrically.
//!
//! Owns the scratch memory, so that a step allocates nothing once it has seen its number of presses.
//! Invariant: the result depends neither on the order of the presses nor on who makes them.

use alloc::boxed::Box;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::cmp::Ordering;

use glam::{Quat, Vec3};

use super::bending::nearest_turn;
use super::faceted::Cutter;
use super::folds::Fold;
use super::lanes::{LANES, Simd, SimdBase, f32x8, hypot, numbers, root, with_vectors};
use super::wall::Wall;
use super::{Contact, Footprint, GridShape, Material, Method, Pot, Strength, Surface, Vectors, Window};
use crate::tool::{ConvexTool, Pose, Side, Tool, rack};
use crate::units::{Metres, Seconds, Tick};

/// A tool held at one place for one sub-step, in the pot's frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press {
    /// The tool; a convex one is among those of the [`SubStep`].
    pub tool: Tool,
    /// How a convex tool is turned; of any length but zero.
    pub orientation: Quat,
    /// Its centre on the pot, m.
    pub centre_m: Vec3,
    /// Where it came from in this step, m, when it is known; what lies between is pressed too.
    pub from_m: Option<Vec3>,
    /// How long it took.
    pub dt: Seconds,
    /// On which side of the wall it works.
    pub side: Side,
    /// Which way the clay turns under it: −1, 0 or 1.
    pub turning: i8,
    /// Share of the penetration that yields in this step, from [`super::Material::response`].
    pub response: f32,
    /// How strong the clay is, for the methods that ask.
    pub strength: Strength,
}

impl Press {
    /// Most parts of one press: a hand at its fastest with a sphere of 1 mm.
    pub const PARTS_MAX: u32 = 16;
    /// Highest ridge between two parts: what a fingertip does not feel on wet clay.
    const RIDGE_M: f32 = 15e-6;
    /// Deepest that clay yields at once: what rises then stands beside a contact of that size, where it is pressed down again as that grows. A ball of
    /// 12 mm that goes 0.2 mm in a step into clay without a rate was borne by 2.7 % less.
    const YIELDS_M: f32 = 0.04e-3;

    /// A tool held outside of a still pot of the default clay for one tick.
    #[must_use]
    pub fn held(tool: impl Into<Tool>, centre_m: Vec3) -> Self {
        let material = Material::default();
        Self {
            tool: tool.into(),
            orientation: Quat::IDENTITY,
            centre_m,
            from_m: None,
            dt: Tick::PERIOD,
            side: Side::Outside,
            turning: 0,
            response: material.response(Tick::PERIOD),
            strength: material.strength,
        }
    }

    /// The same way where there is no clay: it presses nothing, and still shares the parts of its sub-step out.
    #[must_use]
    pub const fn in_air(self) -> Self {
        Self { dt: Seconds(-1.0), ..self }
    }

    /// Whether it is one that a tool on clay can make: at a place, with a share of what is there, in a material there is.
    pub(super) fn is_sound(&self) -> bool {
        self.centre_m.is_finite()
            && self.dt.0 >= 0.0
            && (0.0..=1.0).contains(&self.response)
            && self.strength.is_sound()
    }

    /// The same as a wall meets it that was moved against it by so much, m.
    pub(super) fn nearer(&self, by_m: f32) -> Self {
        let by_m = match self.side {
            Side::Outside => -by_m,
            Side::Inside => by_m,
        };
        let moved = |at: Vec3| {
            let times = 1.0 + by_m / hypot(at.x, at.y).max(by_m.abs());
            Vec3::new(at.x * times, at.y * times, at.z)
        };
        Self { centre_m: moved(self.centre_m), from_m: self.from_m.map(moved), ..*self }
    }

    /// Parts into which its way is cut. Each is at most a third of the tool's radius R, so that the grooves of a small contact
    /// overlap, and at most √(8·s·R) long, so that the ridge between two of them is no higher than s. In each it goes no deeper than
    /// `y/response`, so that no more than y yields.
    fn parts(&self, cutter: Option<&Cutter>) -> u32 {
        let Some(from_m) = self.from_m else { return 1 };
        let radius_m = match self.tool {
            Tool::Sphere(sphere) => sphere.radius().0,
            Tool::Convex(shape) => match cutter.and_then(|cutter| cutter.tool(shape)) {
                Some(tool) => tool.bluntness().0,
                None => return 1,
            },
        };
        let longest_m = (radius_m / 3.0).min(root(8.0 * Self::RIDGE_M * radius_m));
        let way_m = self.centre_m.distance(from_m);
        let mut parts = way_m / longest_m;
        // it goes no deeper than it goes, so that a tick on a wheel asks no further
        if self.response * way_m > Self::YIELDS_M {
            let [begin_m, end_m] = [from_m, self.centre_m].map(|at| hypot(at.x, at.y));
            let deeper_m = match self.side {
                Side::Outside => begin_m - end_m,
                Side::Inside => end_m - begin_m,
            };
            parts = parts.max(self.response * deeper_m / Self::YIELDS_M);
        }
        let parts = libm::ceilf(parts);
        if parts.is_finite() { (parts as u32).clamp(1, Self::PARTS_MAX) } else { 1 }
    }

    /// The press at the end of part `number` of `parts`, counted from 1, with its share of the time: the tool goes round the
    /// axis, as clay under a still tool does.
    fn part(&self, number: u32, parts: u32) -> Self {
        if parts == 1 {
            return *self;
        }
        let response = 1.0 - libm::powf(1.0 - self.response, 1.0 / parts as f32);
        let (Some(from_m), true) = (self.from_m, number < parts) else { return Self { response, ..*self } };
        let share = number as f32 / parts as f32;
        let polar = |at: Vec3| (hypot(at.x, at.y), libm::atan2f(at.y, at.x));
        let ((near, begin), (far, end)) = (polar(from_m), polar(self.centre_m));
        let turn = nearest_turn(end - begin);
        let distance = near + (far - near) * share;
        let (sin, cos) = libm::sincosf(begin + turn * share);
        let z = from_m.z + (self.centre_m.z - from_m.z) * share;
        let orientation = match self.tool {
            Tool::Sphere(_) => self.orientation,
            Tool::Convex(_) => Pose::about_z(self.orientation, f64::from(turn * (share - 1.0))),
        };
        // the way so far, in the time that it took
        let dt = Seconds(self.dt.0 * share);
        Self { centre_m: Vec3::new(distance * cos, distance * sin, z), dt, orientation, response, ..*self }
    }
}

/// A press, or a part of one, with the number of the press among those of a sub-step.
pub type Part = (usize, Press);

/// Scratch memory and result of one sub-step.
///
/// A Jacobi step: with Δᵢ the displacement that press i asks for on its own, an element moves by
/// `min(0, minᵢ Δᵢ) + max(0, maxᵢ Δᵢ)`, the strongest push inwards and the strongest outwards. Minimum and maximum are
/// commutative, associative and idempotent also in floating point, so order and identity cannot matter.
#[derive(Clone, Debug, Default)]
pub struct SubStep {
    footprints: Vec<Footprint>,
    vectors: Vectors,
    contacts: Vec<Contact>,
    /// Of each press of the last step, whether it met clay on any part of its way.
    met: Vec<bool>,
    /// The parts that are pressed at once, each with the number of its press, and after them those that only stand at the wall meanwhile.
    parts: Vec<Part>,
    cutter: Option<Box<Cutter>>,
    /// Merged pushes of the surface at hand, `[columns][rows]`, m; all zero between sub-steps.
    inward_m: Vec<f32>,
    outward_m: Vec<f32>,
    /// The same on the inner skin of a wall.
    inner_m: [Vec<f32>; 2],
    /// Of each press, whether its window on the surface at hand meets another's.
    together: Vec<bool>,
    folds: Vec<Fold>,
}

impl SubStep {
    /// Scratch for presses on grids of up to `shape`; the first use with more presses than ever before allocates.
    #[must_use]
    pub fn for_grid(shape: GridShape) -> Self {
        Self::with_rack(shape, rack::standard())
    }

    /// The same with other convex tools than [`rack::standard`]'s.
    #[must_use]
    pub fn with_rack(shape: GridShape, rack: Arc<[ConvexTool]>) -> Self {
        Self {
            footprints: alloc::vec![Footprint::for_grid(shape)],
            vectors: Vectors::default(),
            contacts: Vec::with_capacity(1),
            met: Vec::with_capacity(1),
            parts: Vec::with_capacity(1),
            cutter: Some(Box::new(Cutter::new(rack, shape))),
            inward_m: alloc::vec![0.0; shape.elements()],
            outward_m: alloc::vec![0.0; shape.elements()],
            inner_m: [const { Vec::new() }; 2],
            together: Vec::with_capacity(1),
            folds: Vec::with_capacity(1),
        }
    }

    /// The same for presses with spheres alone: without convex tools, and without the megabytes that they are cut in until one is swapped in.
    #[must_use]
    pub fn for_spheres(shape: GridShape) -> Self {
        Self::with_rack(shape, Arc::from([]))
    }

    /// The same with other vectors than the widest there are, which changes how long it takes and nothing else.
    #[must_use]
    pub fn using(mut self, vectors: Vectors) -> Self {
        self.vectors = vectors;
        self.footprints = self.footprints.into_iter().map(|footprint| footprint.using(vectors)).collect();
        self
    }

    /// The same with room for so many presses at once on a grid, so that they allocate nothing.
    #[must_use]
    pub fn with_room(mut self, shape: GridShape, presses: usize) -> Self {
        self.make_room(shape, presses);
        self.parts.reserve(presses);
        self
    }

    /// The convex tools that presses may name, by their number.
    #[must_use]
    pub fn tools(&self) -> &[ConvexTool] {
        self.cutter.as_deref().map_or(&[], |cutter| cutter.rack())
    }

    /// The same, to be shared.
    #[must_use]
    pub fn rack(&self) -> Arc<[ConvexTool]> {
        self.cutter.as_deref().map_or_else(|| Arc::from([]), |cutter| Arc::clone(cutter.rack()))
    }

    /// Changes its convex tools for others, without allocating; what it held is in `rack` afterwards.
    pub fn swap_rack(&mut self, rack: &mut Arc<[ConvexTool]>) {
        if let Some(cutter) = &mut self.cutter {
            core::mem::swap(cutter.rack_mut(), rack);
        }
    }

    /// How far a tool reaches from its centre; `None` for a convex one that it does not hold.
    #[must_use]
    pub fn reach(&self, tool: Tool) -> Option<Metres> {
        match tool {
            Tool::Sphere(sphere) => Some(sphere.radius()),
            Tool::Convex(shape) => self.tools().get(usize::from(shape.0)).map(ConvexTool::radius),
        }
    }

    /// Advances `pot` by one step under `presses` and tells `touched` of every window that changed.
    ///
    /// `touched` is called with the number of the surface and a window of it. Returns one contact a press, in order. A tool
    /// that has moved far goes in parts, at most [`Press::PARTS_MAX`], among which those of the others are spread; its contact
    /// is that of the last.
    pub fn advance(
        &mut self,
        pot: &mut Pot,
        presses: &[Press],
        method: impl Method,
        touched: impl FnMut(usize, Window),
    ) -> &[Contact] {
        self.advance_beside(pot, presses, &[], method, touched)
    }

    /// The same while others, who press nothing here, hold against the wall as well where it bends.
    pub fn advance_beside(
        &mut self,
        pot: &mut Pot,
        presses: &[Press],
        beside: &[Press],
        method: impl Method,
        mut touched: impl FnMut(usize, Window),
    ) -> &[Contact] {
        self.contacts.clear();
        self.contacts.resize(presses.len(), Contact::default());
        self.met.clear();
        self.met.resize(presses.len(), false);
        let rounds = presses.iter().map(|press| press.parts(self.cutter.as_deref())).max().unwrap_or(1);
        let mut now = core::mem::take(&mut self.parts);
        let bends = pot.bending().is_some();
        for round in 1..=rounds {
            now.clear();
            let parts = |press: &Press| press.parts(self.cutter.as_deref());
            let is_due = |parts: u32| round * parts / rounds > (round - 1) * parts / rounds;
            for (number, press) in presses.iter().enumerate() {
                let parts = parts(press);
                if is_due(parts) {
                    now.push((number, press.part(round * parts / rounds, parts)));
                }
            }
            let due = now.len();
            if bends {
                for (number, press) in presses.iter().enumerate() {
                    let parts = parts(press);
                    if !is_due(parts) {
                        // where it is going to
                        now.push((number, press.part(round * parts / rounds + 1, parts)));
                    }
                }
                now.extend(beside.iter().map(|press| (usize::MAX, *press)));
            }
            self.advance_once(pot, &now, due, &method, &mut touched);
        }
        self.parts = now;
        &self.contacts
    }

    /// Of each press of the last step, in order, whether it met clay on any part of its way; its contact tells of the last part.
    #[must_use]
    pub fn met(&self) -> &[bool] {
        &self.met
    }

    /// What `pot` opposes to a tool where a press ends, without being moved by it.
    pub fn feel(&mut self, pot: &Pot, press: &Press, method: impl Method) -> Contact {
        self.feel_beside(pot, press, &[], method)
    }

    /// The same while others hold against the wall as well where it bends.
    pub fn feel_beside(&mut self, pot: &Pot, press: &Press, beside: &[Press], method: impl Method) -> Contact {
        if !press.is_sound() {
            return Contact::default();
        }
        let mut all = core::mem::take(&mut self.parts);
        all.clear();
        all.push((usize::MAX, *press));
        all.extend(beside.iter().map(|press| (usize::MAX, *press)));
        self.make_room(pot.spec().shape, all.len());
        self.brace(pot, &all, 1, &method);
        let contact = self.evaluate(press, 0, |footprint| method.feel(pot, press, footprint));
        self.parts = all;
        contact
    }

    /// What `pot` opposes to tools that stand at it at once, without being moved by them: one contact a press, in order.
    pub fn feel_together(&mut self, pot: &Pot, presses: &[Press], method: impl Method) -> &[Contact] {
        let mut all = core::mem::take(&mut self.parts);
        all.clear();
        all.extend(presses.iter().map(|press| (usize::MAX, *press)));
        self.contacts.clear();
        self.contacts.resize(presses.len(), Contact::default());
        self.make_room(pot.spec().shape, all.len());
        self.brace(pot, &all, all.len(), &method);
        for (at, press) in presses.iter().enumerate() {
            self.contacts[at] = self.evaluate(press, at, |footprint| method.feel(pot, press, footprint));
        }
        self.parts = all;
        &self.contacts
    }

    fn advance_once(
        &mut self,
        pot: &mut Pot,
        all: &[Part],
        due: usize,
        method: &impl Method,
        touched: &mut impl FnMut(usize, Window),
    ) {
        let presses = &all[..due];
        self.make_room(pot.spec().shape, all.len());
        self.brace(pot, all, due, method);
        let is_whole = (pot.spec().shape.rows() as usize).is_multiple_of(LANES);
        let is_alone = presses.len() == 1 && pot.spec().skins() == 1 && is_whole;
        for (at, (of, press)) in presses.iter().enumerate() {
            let contact = self.evaluate(press, at, |footprint| {
                if is_alone { method.displace(pot, press, footprint) } else { method.press(pot, press, footprint) }
            });
            self.met[*of] |= contact.elements > 0 || !self.footprints[at].window().is_empty();
            self.contacts[*of] = contact;
        }
        if !is_alone {
            self.displace(pot.surfaces_mut(), presses);
        }
        for footprint in &self.footprints[..due] {
            if !footprint.window().is_empty() {
                (0..pot.spec().skins()).for_each(|surface| touched(surface, footprint.window()));
            }
        }
        self.fold(pot, due, touched);
    }

    /// Folds a wall as the footprints of presses say, in an order of their own, so that it does not go by that in which they were given.
    fn fold(&mut self, pot: &mut Pot, due: usize, touched: &mut impl FnMut(usize, Window)) {
        let Self { footprints, folds, vectors, .. } = self;
        folds.clear();
        folds.extend(footprints[..due].iter().filter_map(|footprint| footprint.fold));
        let key = |fold: &Fold| [fold.inwards_m, fold.angle_rad, fold.z_m];
        folds.sort_unstable_by(|one, other| {
            let pairs = key(one).into_iter().zip(key(other));
            pairs.map(|(one, other)| one.total_cmp(&other)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        });
        folds.iter().for_each(|fold| pot.fold(*vectors, fold, &mut *touched));
    }

    /// Moves the clay by the footprints of presses.
    fn displace(&mut self, surfaces: &mut [Surface], presses: &[Part]) {
        match (surfaces, presses) {
            ([outer, inner, ..], [(_, press)]) => {
                let (mut wall, alone) = (Wall { outer, inner }, &self.footprints[0]);
                with_vectors!(self.vectors, simd => wall.push_alone(simd, alone, press.side));
            }
            ([outer, inner, ..], presses) => self.push(&mut Wall { outer, inner }, presses),
            (skins, presses) => self.merge(&mut skins[0], presses.len()),
        }
    }

    /// Moves both skins of a wall by the strongest pushes on each.
    fn push(&mut self, wall: &mut Wall<'_>, presses: &[Part]) {
        let shape = wall.outer.shape();
        let elements = shape.elements();
        let Self { footprints, vectors, inward_m, outward_m, inner_m, .. } = self;
        let footprints = &footprints[..presses.len()];
        let [back_m, out_m] = inner_m;
        for pushes_m in [&mut *inward_m, outward_m, back_m, out_m] {
            pushes_m.resize(elements.max(pushes_m.len()), 0.0);
        }
        with_vectors!(vectors, simd => {
            for (footprint, (_, press)) in footprints.iter().zip(presses) {
                let shares = match press.side {
                    Side::Outside => [1.0, footprint.follows],
                    Side::Inside => [footprint.follows, 1.0],
                };
                add_up(simd, shape, (footprint, shares[0]), inward_m, outward_m);
                add_up(simd, shape, (footprint, shares[1]), back_m, out_m);
            }
            // an element of two footprints is moved with the first of them
            for footprint in footprints {
                wall.push(simd, footprint, [inward_m, outward_m, back_m, out_m]);
            }
        });
    }

    /// Footprints for so many presses.
    fn make_room(&mut self, shape: GridShape, presses: usize) {
        while self.footprints.len() < presses {
            self.footprints.push(Footprint::for_grid(shape).using(self.vectors));
        }
    }

    /// Lets all that stand at a wall which bends bend it together, before the first `due` of them are pressed.
    fn brace(&mut self, pot: &Pot, all: &[Part], due: usize, method: &impl Method) {
        if all.len() < 2 || pot.bending().is_none() {
            return;
        }
        let footprints = &mut self.footprints[..all.len()];
        core::mem::swap(&mut footprints[0].scratch.cutter, &mut self.cutter);
        method.brace(pot, all, footprints);
        core::mem::swap(&mut footprints[0].scratch.cutter, &mut self.cutter);
        for ((of, _), footprint) in all.iter().zip(&mut *footprints) {
            // what the others met follows from it, so that it cannot be left out when they are pressed again
            if let Some(met) = self.met.get_mut(*of) {
                *met |= footprint.scratch.braced.is_some();
            }
        }
        footprints[due..].iter_mut().for_each(|footprint| footprint.scratch.braced = None);
    }

    /// Evaluates a press with the footprint of its place, as a method does.
    fn evaluate(&mut self, press: &Press, at: usize, how: impl FnOnce(&mut Footprint) -> Contact) -> Contact {
        let footprint = &mut self.footprints[at];
        // the one place that keeps out what is no press: past it, everything is finite
        if !press.is_sound() {
            footprint.reset(Window::default());
            return Contact::default();
        }
        core::mem::swap(&mut footprint.scratch.cutter, &mut self.cutter);
        let contact = how(footprint);
        core::mem::swap(&mut footprint.scratch.cutter, &mut self.cutter);
        contact
    }

    /// Displaces `surface` by the footprints of so many presses: by those that meet no other as they are, by the others merged.
    fn merge(&mut self, surface: &mut Surface, presses: usize) {
        let shape = surface.shape();
        let Self { footprints, vectors, inward_m, outward_m, together, .. } = self;
        let footprints = &mut footprints[..presses];
        let elements = shape.elements().max(inward_m.len());
        inward_m.resize(elements, 0.0);
        outward_m.resize(elements, 0.0);
        together.clear();
        together.extend(footprints.iter().enumerate().map(|(at, footprint)| {
            let others = footprints[..at].iter().chain(&footprints[at + 1..]);
            others.into_iter().any(|other| footprint.window().meets(other.window(), shape))
        }));
        with_vectors!(vectors, simd => {
            for (footprint, _) in footprints.iter().zip(&*together).filter(|(_, meets)| **meets) {
                add_up(simd, shape, (footprint, 1.0), inward_m, outward_m);
            }
            for (footprint, meets) in footprints.iter_mut().zip(&*together) {
                if *meets {
                    take_out(simd, shape, footprint, inward_m, outward_m);
                }
                // an element of two footprints is moved with the first of them
                surface.displace(footprint);
            }
        });
    }
}

/// Adds a share of a footprint to the strongest pushes so far, `[columns][rows]` of the whole grid.
#[inline(always)]
fn add_up<S: Simd>(
    simd: S,
    shape: GridShape,
    (footprint, share): (&Footprint, f32),
    inward_m: &mut [f32],
    outward_m: &mut [f32],
) {
    let window = footprint.window();
    for (local, column) in (0..).zip(window.grid_columns(shape)) {
        let (span, deltas_m) = footprint.span(local);
        let start = first_of(shape, window, column) + span.start;
        let (inward_m, outward_m) =
            (&mut inward_m[start..][..deltas_m.len()], &mut outward_m[start..][..deltas_m.len()]);
        let (deltas, last_deltas) = deltas_m.as_chunks::<LANES>();
        let (inward, last_inward) = inward_m.as_chunks_mut::<LANES>();
        let (outward, last_outward) = outward_m.as_chunks_mut::<LANES>();
        for ((delta, inward), outward) in deltas.iter().zip(inward).zip(outward) {
            // as beside the eights: what is not a number pushes nothing
            let delta = numbers(f32x8::load_array_ref(simd, delta)) * share;
            *inward = f32x8::load_array_ref(simd, inward).min(delta).to_array();
            *outward = f32x8::load_array_ref(simd, outward).max(delta).to_array();
        }
        for ((delta, inward), outward) in last_deltas.iter().zip(last_inward).zip(last_outward) {
            *inward = inward.min(*delta * share);
            *outward = outward.max(*delta * share);
        }
    }
}

/// Gives a footprint the merged pushes of its elements, and clears them, so that an overlapping one finds them done.
#[inline(always)]
fn take_out<S: Simd>(
    simd: S,
    shape: GridShape,
    footprint: &mut Footprint,
    inward_m: &mut [f32],
    outward_m: &mut [f32],
) {
    let window = footprint.window();
    for (local, column) in (0..).zip(window.grid_columns(shape)) {
        let (span, deltas_m) = footprint.span_mut(local);
        let start = first_of(shape, window, column) + span.start;
        let (inward_m, outward_m) =
            (&mut inward_m[start..][..deltas_m.len()], &mut outward_m[start..][..deltas_m.len()]);
        let (deltas, last_deltas) = deltas_m.as_chunks_mut::<LANES>();
        let (inward, last_inward) = inward_m.as_chunks::<LANES>();
        let (outward, last_outward) = outward_m.as_chunks::<LANES>();
        for ((delta, inward), outward) in deltas.iter_mut().zip(inward).zip(outward) {
            let merged = f32x8::load_array_ref(simd, inward) + f32x8::load_array_ref(simd, outward);
            *delta = merged.to_array();
        }
        for ((delta, inward), outward) in last_deltas.iter_mut().zip(last_inward).zip(last_outward) {
            *delta = inward + outward;
        }
        inward_m.fill(0.0);
        outward_m.fill(0.0);
    }
}

/// Where a column of a window begins in a whole grid.
const fn first_of(shape: GridShape, window: Window, column: u32) -> usize {
    column as usize * shape.rows() as usize + window.first_row as usize
}
