//! The studio's own method: elastic up to yield, plastic beyond, and the displaced clay returned as a rim.
//!
//! Owns the law of the clay under a tool; the collision is shared with the published methods, the rim's shape is `rim`'s.
//! Invariant: a tool held still sinks no deeper than where the clay carries it, and no element that yields rises.

use glam::Vec3;

use super::bending::POISSON;
use super::contact::{Column, Contacts};
use super::ellipse::{Ellipse, Moments, Step};
use super::folds::Fold;
use super::lanes::{Simd, SimdBase, apart, f32x8, hypot, root, splat, sum, with_vectors};
use super::law::{PlasticLaw, SLOPE_MIN, layer_depth_m};
use super::looks::find;
use super::rim::{Rim, RimShape};
use super::series::GivenWay;
use super::sides::Sides;
use super::uptake::{Moved, Noted, Uptake};
use super::window::{Push, Scratch};
use super::{Contact, Footprint, GridShape, Method, Part, Pot, Press, Sink, Strength, Support, Surface, Window};
use crate::tool::Side;

/// Penetration from which on an element counts wholly for the shape of a contact, m: less for less, so that none counts or not
/// by a hair. It is the step in which places travel.
const EDGE_M: f32 = 1e-5;
/// Area of the ellipse of a dent that is as deep everywhere, over that of its contact: 6/4, since its moments are taken for a paraboloid's.
const AREA_EVEN: f32 = 1.5;

/// Elastic-plastic clay with a rim.
///
/// With p the penetration, A the area of an element, a = √(a_θ·a_z) the radius of the contact, whose half axes follow from
/// its second moments, s the tool's slope at its edge (a/R for a small sphere), r the clay's radius, t its thickness behind the
/// surface, E* = E/(1 − ν²) and X = s·E*/σ_y the strain over the yield strain:
/// - pressure: `H = σ_y·(h − h_s·s² − h_t·a/t)·X/(X + X₁)`, at least 1.1·σ_y: an elastic contact, whose pressure is as s·E*, in
///   series with one that flows wholly (Tabor 1951), which a steep tool and a thin layer lower;
/// - springs back: `e(q²) = c·e₀·(1 − n·q² − m·q⁶)`, `e₀ = (H/E*)·2a/(1 + 0.62·a/t + 0.38·(a/t)²)`, the elastic depth under
///   an even pressure on a layer that slides on a rigid base ([`Sink`] tells it outside of the contact too). Where the clay flows
///   down to that base it gives way more evenly: `n = 0.35 − n_t·(a/t − ½)⁺`;
/// - yields: `Δr = −(1 − exp(−dt/τ))·(p − e)⁺`;
/// - force: the pressure `H/μ·min(p, e)/(c·e₀)` along the tool's normal, so that it saturates as clay does, with the mean H
///   where all yields, however fast (μ is the mean of `e(q²)/(c·e₀)`). While nothing yields it is 3 % above Hertz's
///   `4/3·E*·√R·δ^1.5`. On a core, what a sum over columns leaves out at a contact's sides is brought in (`clay::sides`);
/// - rim: `+β·ΔV·κ(q²)/(π·a_θ·a_z·(Q − 1)/3)` for 1 < q² < Q, `κ = ((Q − q²)/(Q − 1))²`, with the half axes a_θ, a_z of the volume ΔV
///   that yields (a paraboloid of half axis a has the variance a²/6), both made shorter where that ellipse is larger than the contact.
///   Of what yields now it is `β = β₀·(1 − exp(−X/X₀))`; a dent that grows presses its own rim down again,
///   which yields too. A tool that is ahead of the clay finds none to press down, and raises `1 − 0.5·η` of it: η is what is still to yield
///   over what a ball has under it, as far as it lies like the ball and not evenly. In the finite elements as much stands within 20 mm of a dent as `1 − exp(−X/117)` of what it holds; what of it is
///   far and low, most of all on thin walls, is left out. The rest is booked to the pot's height. It rises more to both
///   sides along the arc, where the pot curves away, than along the height: by `1 ± α·q²`, `α = α₀·a/(r·s)`, which is α₀·R/r;
/// - sliding: under a tool that moves along the clay faster than a hand trembles, from 15 mm/s on and wholly (σ = 1) from
///   40 mm/s, clay springs back at the flanks of the groove more than at its bottom, `e·(1 − σ·(1 − k)·(1 − v²))`, v the distance
///   aside over the half axis. Strain counts 1 + 4.8·σ times for the rim, of which less rises in the end, 0.49 for 0.59, and whose crest is sharper, `κ` to the second
///   power. The deeper the bite, the more steeply the rim stands: it is `1 + 3.2·σ·d²` times narrower in q², with `d = s·b/t`,
///   b the shorter half axis of the contact, and no more than the 0.5 of the deepest strokes that are known. Where the contact leans to
///   one side of the tool's path by a share o of its half axis, as beside a groove, the clay is open: `0.75·o` of what else
///   would not rise does, and the pressure is less by 0.3·o. Clay before a steep tool has somewhere to go: with
///   `g = (s² − 0.35)⁺` the pressure is less by `0.26·σ·g/(g + 0.1)`, which ends, since a slope leaps where a tool grazes an edge. It heaps up there:
///   what of the force is against the motion is 0.33·σ greater;
/// - a wall with nothing behind it bends in series: p is then what is left of the tool's depth after the wall has given way by
///   `w = C·F/E·(1 + α·(F/F₀)⁵)` (see [`super::WallBending`]; `F₀ = 2π·σ_y·t²/4·(1 + 1.78·(d − 0.425)⁺)`, at which a plate folds, and later under a
///   tool that reaches d times √(R·t) to either side along the arc into the wall as it was, up to d = 1.1; and where the foot holds it), and e is c times a half-space's, `c·(H/E*)·2a·(1 − 0.25·q² − 0.113·q⁶)` with the mean 0.847, since
///   the clay's back is free. Bending strains the clay by itself: H is `1 + 0.49·f/(1 + f/1.4)` times less, `f = (F/F₀)⁵`. Of
///   what w is more than an elastic wall's, `C·F/E·α·(F/F₀)⁵`, 0.59 stays: a fold, which goes into the radii of both skins as a cone of 1.2·√(R·t) (`clay::folds`). As far as
///   a wall has folded at a place, w is less there, but never less than an elastic wall's. The rest springs back. Tools at one wall bend it together: w is then the sum of what all of them do to it at the place of each, and it
///   folds there by the sum of their forces within the cone to which it folds, at the mean of what F₀ is under each alone (`clay::joint`). Clay between a tool and one on the other side that takes up a
///   share b of its load is as on a core in the middle of the wall: a/t stands for `2·b·a/t`. With what yields the wall's other skin goes along by
///   `1.63·(F/F₀ − 0.409)`, from nothing to all of it.
///
/// `tests/tests/clay/reference.rs`, `tests/tests/clay/hollow.rs` and `tests/tests/clay/pinch.rs` hold it to the finite-element dents.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PlasticCsem {
    /// Its constants.
    pub law: PlasticLaw,
}

impl Method for PlasticCsem {
    fn press(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        let mut scratch = core::mem::take(&mut footprint.scratch);
        footprint.reset(Window::default());
        let contact = with_vectors!(scratch.vectors, simd => {
            let answer = self.answer(simd, pot, press, &mut scratch);
            if let Some(rim) = &answer.rim {
                let surface = pot.met_from(press.side);
                lay(simd, rim, (surface.shape(), Step::of(surface)), &mut scratch, Noted::in_footprint(footprint));
            }
            answer.contact_of(footprint)
        });
        footprint.scratch = scratch;
        contact
    }

    fn displace(&self, pot: &mut Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        footprint.reset(Window::default());
        with_vectors!(footprint.scratch.vectors, simd => {
            let scratch = &mut footprint.scratch;
            let answer = self.answer(simd, pot, press, scratch);
            if let Some(rim) = &answer.rim {
                let surface = &mut pot.surfaces_mut()[0];
                let on = (surface.shape(), Step::of(surface));
                let window = lay(simd, rim, on, scratch, Moved::on(simd, surface));
                footprint.lay(window);
            }
            answer.contact_of(footprint)
        })
    }

    fn feel(&self, pot: &Pot, press: &Press, footprint: &mut Footprint) -> Contact {
        let scratch = &mut footprint.scratch;
        with_vectors!(scratch.vectors, simd => self.answer(simd, pot, press, scratch)).contact
    }

    fn brace(&self, pot: &Pot, presses: &[Part], footprints: &mut [Footprint]) {
        let Some(first) = footprints.first_mut() else { return };
        let (mut joint, vectors) = (core::mem::take(&mut first.scratch.joint), first.scratch.vectors);
        let mut cutter = first.scratch.cutter.take();
        with_vectors!(vectors, simd => self.brace_with(simd, pot, presses, footprints, &mut joint, cutter.as_deref_mut()));
        let scratch = &mut footprints[0].scratch;
        (scratch.joint, scratch.cutter) = (joint, cutter);
    }

    fn keeps_volume(&self) -> bool {
        true
    }
}

impl PlasticCsem {
    /// What a press meets and what of the clay is to move; the contacts and what yields of them are in the scratch afterwards.
    #[inline(always)]
    fn answer<S: Simd>(&self, simd: S, pot: &Pot, press: &Press, scratch: &mut Scratch) -> Answer {
        let surface = pot.met_from(press.side);
        let step = Step::of(surface);
        let at = At { surface, press, step };
        let braced = match (scratch.braced.take(), pot.bending()) {
            (None, Some(bending)) => self.bend(simd, pot, press, bending, scratch),
            (braced, _) => braced,
        };
        let way = match braced {
            // as it was looked at last
            Some(braced) => braced.way(),
            None if pot.bending().is_some() => return Answer::default(),
            None => {
                find(simd, pot, press, 0.0, &mut scratch.contacts, scratch.cutter.as_deref_mut());
                GivenWay::default()
            }
        };
        if scratch.contacts.elements == 0 {
            return Answer::default();
        }
        let contacts = &scratch.contacts;
        let met = self.meet(simd, &at, contacts, &way);
        let Some(met) = met else { return Answer::default() };
        let ramp = met.ramp(&step);
        let Met { spot, pressure_pa, strain, slope, around, rim_width } = met;
        let Spot { ellipse, slide, open, .. } = spot;
        let carried = apart(
            simd,
            #[inline(always)]
            || yields(simd, press, &spot, contacts, &mut scratch.pushes),
        );
        let rim = carried.dent.ellipse(6.0, &step).map(|dent| {
            let ahead = (1.0 - slide.share) * ahead(&dent, &ellipse, slope, press.response);
            let dent = dent.within(&ellipse);
            let volume_m3 = -self.law.rim_share(strain, slide.share, open) * self.law.left_of_rim(ahead) * dent.content;
            let shape = RimShape::new(slide, outwards(press.side) * around, rim_width);
            Rim { dent, volume_m3, shape, tool_z_m: press.centre_m.z }
        });
        let normals = carried.normals + slide.heap(carried.normals, contacts.angle_rad) * self.law.slide_heap;
        // where a wall bends, three quarters of the way are its own, and what a sum leaves out hardly tells
        let whole = match surface.support() {
            Support::Backed => carried.sides.whole(&self.law, carried.all, ramp),
            Support::Hollow => 1.0,
        };
        let newtons = pressure_pa * step.element_rad_m * whole;
        let level = hypot(carried.normals.x, carried.normals.y);
        let contact = Contact {
            force_n: normals * newtons,
            held_n: (carried.all - level).max(0.0) * newtons,
            elements: contacts.elements,
            penetration_m: contacts.deepest_m,
            sink: Some(Sink {
                angle_rad: contacts.angle_rad + ellipse.arc_m / ellipse.radius_m,
                z_m: press.centre_m.z + ellipse.above_m,
                radius_m: ellipse.radius_m,
                half_arc_m: ellipse.half_arc_m,
                half_height_m: ellipse.half_height_m,
                depth_m: spot.elastic_m * spot.bottom * carried.all / spot.mean() * step.element_rad_m
                    / ellipse.content,
                support: surface.support(),
                bowl: spot.bowl,
                width: self.law.sink_width(spot.layer),
                load_m2: outwards(press.side) * way.load_m2,
                softer: way.softer,
                hinge_m: outwards(press.side) * way.hinge_m,
            }),
        };
        Answer {
            contact,
            rim,
            follows: if way.folds_away { self.law.follows(way.folds) } else { 0.0 },
            fold: Fold::of(press, way.folds_by_m),
        }
    }

    /// What the clay opposes to penetrations; `None` where none is left.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, at: &At<'_>, contacts: &Contacts, way: &GivenWay) -> Option<Met> {
        let (ellipse, slope) = apart(
            simd,
            #[inline(always)]
            || contact_ellipse(simd, contacts, &at.step),
        )?;
        let slide = Slide::of(at.press, &ellipse);
        let behind = Behind {
            support: at.surface.support(),
            thickness_m: at.surface.thickness_m(),
            layer_per_m: way.layer_per_m,
            folds: way.folds,
        };
        Some(self.met(ellipse, slope, slide, at.press.strength, behind))
    }

    /// What clay opposes to a contact under which the tool has a slope at its edge.
    pub(super) fn met(&self, ellipse: Ellipse, slope: f32, slide: Slide, strength: Strength, behind: Behind) -> Met {
        let Behind { support, thickness_m, layer_per_m, folds } = behind;
        let law = &self.law;
        let youngs_reduced_pa = strength.youngs_pa / (1.0 - POISSON * POISSON);
        let slope_min = slope.max(SLOPE_MIN);
        let strain = youngs_reduced_pa / strength.yield_pa * slope_min;
        let half_m = ellipse.mean_half_m();
        // a free layer is within a sixth of a half-space, and squeezes nothing out; its bending as a plate is the shell's
        let layer = match support {
            Support::Backed => half_m / thickness_m,
            Support::Hollow => half_m * layer_per_m,
        };
        let hardness_pa = strength.yield_pa * law.hardness(strain, slope, layer) * law.unfolded(folds);
        let spot = Spot {
            elastic_m: law.recovery * hardness_pa / youngs_reduced_pa * layer_depth_m(half_m, layer),
            bowl: law.bowl(support, layer),
            layer,
            open: slide.open(&ellipse),
            bottom: 1.0 - slide.share * (1.0 - law.slide_bottom),
            slide,
            ellipse,
        };
        let pressure_pa = hardness_pa / spot.mean() * law.bears(spot.slide.share, slope, spot.open);
        let across_m = spot.ellipse.half_arc_m.min(spot.ellipse.half_height_m);
        Met {
            pressure_pa,
            strain,
            slope: slope_min,
            around: law.around(half_m / spot.ellipse.radius_m, slope),
            rim_width: law.rim_width(slide.share, slope, across_m / thickness_m),
            spot,
        }
    }
}

/// What clay answers to a press.
#[derive(Default)]
struct Answer {
    contact: Contact,
    /// What rises about what yields, which is among the pushes of the scratch.
    rim: Option<Rim>,
    /// See [`Footprint::follows`].
    follows: f32,
    /// See [`Footprint::fold`].
    fold: Option<Fold>,
}

impl Answer {
    /// Gives a footprint how a wall goes along; the contact.
    fn contact_of(self, footprint: &mut Footprint) -> Contact {
        (footprint.follows, footprint.fold) = (self.follows, self.fold);
        self.contact
    }
}

/// Lays a rim and what yields within it.
#[inline(always)]
fn lay<S: Simd>(simd: S, rim: &Rim, on: (GridShape, Step), scratch: &mut Scratch, uptake: impl Uptake<S>) -> Window {
    let Scratch { contacts, pushes, rim: room, .. } = scratch;
    apart(
        simd,
        #[inline(always)]
        || rim.lay(simd, on, contacts, pushes, room, uptake),
    )
}

/// What stands behind a contact.
#[derive(Clone, Copy, Debug)]
pub(super) struct Behind {
    pub(super) support: Support,
    pub(super) thickness_m: f32,
    /// See [`GivenWay::layer_per_m`]; zero where the wall does not bend.
    pub(super) layer_per_m: f32,
    /// See [`GivenWay::folds`]; zero where the wall does not bend.
    pub(super) folds: f32,
}

/// A press on a surface, and the size of its elements.
#[derive(Clone, Copy)]
pub(super) struct At<'a> {
    pub(super) surface: &'a Surface,
    pub(super) press: &'a Press,
    pub(super) step: Step,
}

/// How much of a press is sliding, and where to.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Slide {
    /// Direction along the arc and up, as long as the share.
    pub(super) along: f32,
    pub(super) up: f32,
    pub(super) share: f32,
}

impl Slide {
    /// Speed along the clay at which sliding begins, m/s, and by how much more it is whole. Places travel in steps of 10 µm: one that stands
    /// still may go aside and up by one each in a tick, at 14 mm/s.
    const BEGIN_M_S: f32 = 0.015;
    const WHOLE_M_S: f32 = 0.025;

    fn of(press: &Press, spot: &Ellipse) -> Self {
        let Some(from_m) = press.from_m else { return Self::default() };
        let to_m = press.centre_m;
        let distance_m2 = to_m.x * to_m.x + to_m.y * to_m.y;
        // the sine of a small angle, at the clay
        let along_m = (from_m.x * to_m.y - from_m.y * to_m.x) / distance_m2.max(1e-12) * spot.radius_m;
        let up_m = to_m.z - from_m.z;
        let moved_m = hypot(along_m, up_m);
        // from nowhere is not from somewhere along the clay
        if moved_m < 1e-7 || !moved_m.is_finite() {
            return Self::default();
        }
        let (along, up) = (along_m / moved_m, up_m / moved_m);
        let share = Self::share(moved_m / press.dt.0);
        Self { along: along * share, up: up * share, share }
    }

    /// The part of a force on the tool that is against its motion along the clay at its own angle, rad, by the share of
    /// sliding: clay heaps up before a tool that slides.
    fn heap(&self, force: Vec3, angle_rad: f32) -> Vec3 {
        if self.share <= 0.0 {
            return Vec3::ZERO;
        }
        let (sin, cos) = libm::sincosf(angle_rad);
        let along = Vec3::new(-sin * self.along, cos * self.along, self.up);
        along * (force.dot(along).min(0.0) / self.share)
    }

    /// How far the contact's middle lies aside of the tool's path, over its half axis: beside a groove the clay is open. No
    /// more than a half, since a tool of facets may touch far from its middle.
    fn open(&self, spot: &Ellipse) -> f32 {
        let aside_m = spot.above_m * self.along - spot.arc_m * self.up;
        (aside_m.abs() / spot.mean_half_m()).min(0.5)
    }

    /// Share of sliding of a tool at a speed along the clay, m/s.
    pub(super) fn share(speed_m_s: f32) -> f32 {
        ((speed_m_s - Self::BEGIN_M_S) / Self::WHOLE_M_S).clamp(0.0, 1.0)
    }
}

/// How far a tool is ahead of the clay that yields under it: 0 where clay keeps up with it, 1 where a ball is in before any has yielded.
///
/// What is still to yield, over what a ball of slope s and half axis a has under it, `s·a/4` on the mean; as far as it lies like the ball and not
/// evenly, as under a flat tool and under one that clay keeps up with.
fn ahead(dent: &Ellipse, contact: &Ellipse, slope: f32, response: f32) -> f32 {
    let under_m3 = 0.25 * slope * contact.mean_half_m() * contact.content;
    let left = (dent.content.abs() / (response * under_m3)).min(1.0);
    left * ((AREA_EVEN - dent.area_over(contact)) / (AREA_EVEN - 1.0)).clamp(0.0, 1.0)
}

/// Away from the axis for a tool outside, towards it for one inside.
pub(super) const fn outwards(side: Side) -> f32 {
    match side {
        Side::Outside => 1.0,
        Side::Inside => -1.0,
    }
}

/// The contact, and the tool's slope at its edge: `√(2·mean slope²)`, which is a/R for a sphere.
#[inline(always)]
fn contact_ellipse<S: Simd>(simd: S, contacts: &Contacts, step: &Step) -> Option<(Ellipse, f32)> {
    let mut moments = Moments::new(simd);
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let mut slopes = zero;
    for stretch in contacts.stretches() {
        let share = stretch.column.share;
        for (chunk, above) in stretch.iter() {
            let (above, radius) = (above.on(simd), chunk.radius_m.on(simd));
            let touched = (chunk.penetration_m.on(simd) * (1.0 / EDGE_M)).max(zero).min(one);
            let weight = touched * radius * share;
            let (aside, up) = (chunk.aside.on(simd), chunk.up.on(simd));
            slopes += weight * (up * up + aside * aside);
            moments.add(weight, radius, above);
        }
        moments.end_column(stretch.column.angle_rad);
    }
    let ellipse = moments.ellipse(4.0, step)?;
    let slope = root(2.0 * sum(slopes) * step.element_rad_m / ellipse.content);
    Some((ellipse, slope))
}

/// A contact and how the clay gives way in it.
pub(super) struct Spot {
    pub(super) ellipse: Ellipse,
    /// Depth to which clay springs back in the middle, m, and how it falls from there: see [`Sink`].
    elastic_m: f32,
    bowl: [f32; 2],
    /// The contact's radius over the clay's thickness; zero where nothing is behind it.
    layer: f32,
    pub(super) slide: Slide,
    /// How much of the elastic depth is left at the bottom of a groove.
    bottom: f32,
    /// See [`Slide::open`].
    pub(super) open: f32,
}

/// What the clay opposes to a tool.
pub(super) struct Met {
    pub(super) spot: Spot,
    /// Pressure in the middle where all of the contact yields, Pa: the mean over the spot's mean.
    pub(super) pressure_pa: f32,
    /// X, strain over yield strain.
    pub(super) strain: f32,
    /// s, no less than the law has been seen with.
    pub(super) slope: f32,
    /// By how much more the rim rises along the arc than along the height, for a tool outside.
    pub(super) around: f32,
    /// Width of the rim, in q².
    pub(super) rim_width: f32,
}

impl Met {
    /// Width over which pressure rises at the contact's edge along the arc, over that of a column, for a tool outside: the elastic depth there over the
    /// angle at which tool and clay part, of which the clay's curvature is a share.
    fn ramp(&self, step: &Step) -> f32 {
        let Spot { elastic_m, bowl: [near, edge], ellipse, .. } = &self.spot;
        let parts = self.slope + ellipse.half_arc_m / ellipse.radius_m;
        elastic_m * (1.0 - near - edge) / (parts * step.column_rad * ellipse.radius_m)
    }
}

impl Spot {
    /// Mean elastic depth over the contact, over that in the middle.
    fn mean(&self) -> f32 {
        let [near, edge] = self.bowl;
        1.0 - 0.5 * near - 0.25 * edge
    }

    /// The elastic depth, made ready for many places.
    pub(super) fn bed(&self) -> Bed {
        let ellipse = &self.ellipse;
        let Slide { along, up, share } = self.slide;
        let [near, edge] = self.bowl;
        let half_m = hypot(up * ellipse.half_arc_m, along * ellipse.half_height_m).max(f32::MIN_POSITIVE);
        Bed {
            across_per_m: 1.0 / ellipse.half_arc_m,
            across: ellipse.arc_m / ellipse.half_arc_m,
            up_per_m: 1.0 / ellipse.half_height_m,
            up: ellipse.above_m / ellipse.half_height_m,
            near,
            edge,
            middle_m: self.elastic_m,
            slides: share > 0.0,
            sliding: (1.0 - self.bottom) * self.elastic_m,
            aside: [along * ellipse.half_height_m / half_m, up * ellipse.half_arc_m / half_m],
        }
    }
}

/// Elastic depths over a contact: see [`Spot`].
#[derive(Clone, Copy)]
pub(super) struct Bed {
    /// From a place to half axes from the middle: `across_per_m·arc − across`, and the same up.
    across_per_m: f32,
    across: f32,
    up_per_m: f32,
    up: f32,
    near: f32,
    edge: f32,
    middle_m: f32,
    /// Whether the tool slides, and the part of the depth, m, that then goes with the square of the distance aside: `aside[0]`
    /// times half axes up less `aside[1]` times half axes across.
    slides: bool,
    sliding: f32,
    aside: [f32; 2],
}

impl Bed {
    /// Elastic depth at a place, m, and its share of what it would be if all of the contact gave way as its middle does.
    #[inline(always)]
    pub(super) fn depth_m<S: Simd>(&self, arc: f32x8<S>, above: f32x8<S>) -> (f32x8<S>, f32x8<S>) {
        let one = splat(arc.simd, 1.0);
        let (across, up) = (arc * self.across_per_m - self.across, above * self.up_per_m - self.up);
        let q2 = (across * across + up * up).min(one);
        let shape = one - q2 * (q2 * q2 * self.edge + self.near);
        if !self.slides {
            return (shape * self.middle_m, shape);
        }
        let aside = up * self.aside[0] - across * self.aside[1];
        let left = (aside * aside).min(one) * self.sliding + (self.middle_m - self.sliding);
        (shape * left, shape)
    }
}

/// What a contact carries and what of it yields.
struct Carried<S: Simd> {
    /// Sums over the elements of share·area and of share·area·normal, over the area of an element at radius 1.
    all: f32,
    normals: Vec3,
    sides: Sides<S>,
    /// Of the volume that yields, negative where it goes towards the axis.
    dent: Moments<S>,
}

/// Splits what a tool presses into what springs back and what yields, which goes to the first of `pushes`.
#[inline(always)]
fn yields<S: Simd>(
    simd: S,
    press: &Press,
    spot: &Spot,
    contacts: &Contacts,
    pushes: &mut alloc::vec::Vec<Push>,
) -> Carried<S> {
    let mut dent = Moments::new(simd);
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let [mut x, mut y, mut z, mut all] = [zero; 4];
    let mut sides = Sides::new(simd);
    let bed = spot.bed();
    let outwards = outwards(press.side);
    if pushes.len() < contacts.found() {
        pushes.resize(contacts.found(), Push::NONE);
    }
    let mut rest = pushes.as_mut_slice();
    for stretch in contacts.stretches() {
        let &Column { angle_rad, share, cos, sin, .. } = stretch.column;
        let response = -outwards * press.response * share;
        let (pushes, others) = core::mem::take(&mut rest).split_at_mut(stretch.chunks.len());
        rest = others;
        let [mut ahead_sum, mut aside_sum] = [zero; 2];
        // three short loops: while the quotient of a long one is awaited, too little of the next round fits into a processor
        for ((chunk, above), push) in stretch.iter().zip(&mut *pushes) {
            let (elastic, shape) = bed.depth_m(chunk.radius_m.on(simd) * angle_rad, above.on(simd));
            // until the next loop has made of them what they are
            (push.delta_m, push.rising) = (elastic.into(), shape.into());
        }
        for (chunk, push) in stretch.chunks.iter().zip(&mut *pushes) {
            let (depth, radius) = (chunk.penetration_m.on(simd), chunk.radius_m.on(simd));
            let (elastic, shape) = (push.delta_m.on(simd), push.rising.on(simd));
            let part = depth / elastic;
            // the pressure acts where the tool is, which covers less clay the nearer it is to the axis
            // what is pressed on bears no more than what rests: clay knows no rate but the one at which it yields
            let carried = part.min(one) * shape * (radius - depth * outwards) * share;
            let rising = (one - part).max(zero) * share + (1.0 - share);
            let delta = (depth - elastic).max(zero) * response;
            *push = Push { delta_m: delta.into(), rising: rising.into(), carried: carried.into() };
        }
        for ((chunk, above), push) in stretch.iter().zip(&*pushes) {
            let (carried, radius) = (push.carried.on(simd), chunk.radius_m.on(simd));
            ahead_sum += carried;
            aside_sum += carried * chunk.aside.on(simd);
            z -= carried * chunk.up.on(simd);
            dent.add(push.delta_m.on(simd) * radius, radius, above.on(simd));
        }
        dent.end_column(angle_rad);
        sides.add(ahead_sum, share);
        all += ahead_sum;
        x += ahead_sum * (outwards * cos) - aside_sum * sin;
        y += ahead_sum * (outwards * sin) + aside_sum * cos;
    }
    Carried { all: sum(all), normals: Vec3::new(sum(x), sum(y), sum(z)), sides, dent }
}
