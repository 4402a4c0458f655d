//! Looks at tools at a wall that gives way, until it stands still under them.
//!
//! Owns which contacts are found, and when anew; what clay opposes to them is `plastic`'s law, where the wall comes to rest `joint`'s.
//! Invariant: what is left of a contact does not depend on where it was found.

use super::contact::{Column, Contacts};
use super::ellipse::Step;
use super::faceted::Cutter;
use super::joint::{Joint, Standing};
use super::lanes::{Simd, SimdBase, apart, root, splat, sum};
use super::plastic::{At, Spot, outwards};
use super::rays::Glance;
use super::series::{Braced, GivenWay, Hinge, Seen};
use super::window::Scratch;
use super::{Footprint, Part, PlasticCsem, Pot, Press, Strength, WallBending};
use crate::tool::Tool;

/// What of its pressure a tool's force is where a wall gives way to it wholly, and where not at all: one that is spread over more than 31° to
/// both sides does not bend it as a load in one place does, and over 65° it presses a third as much into an oval (`sin 2φ/2φ`).
const ONE_SIDED: f32 = 0.95;
const HELD: f32 = 0.8;

impl PlasticCsem {
    /// Lets a wall with nothing behind it give way under the tool alone; nothing where it touches none.
    #[inline(always)]
    pub(super) fn bend<S: Simd>(
        &self,
        simd: S,
        pot: &Pot,
        press: &Press,
        bending: &WallBending,
        scratch: &mut Scratch,
    ) -> Option<Braced> {
        let Scratch { contacts, joint, cutter, .. } = scratch;
        let (mut braced, pressed) = (None, Pressed { pot, bending, press });
        let mut look = |way: &GivenWay| self.look(simd, &pressed, way, contacts, &mut braced, cutter.as_deref_mut());
        let mut first = Some(look(&GivenWay::default())?);
        let only = Standing::of(0, press, pot);
        joint.settle(bending, core::iter::once(only), |_, way| first.take().or_else(|| look(way)));
        braced
    }

    /// Finds how far presses bend a wall together; see [`Method::brace`](super::Method::brace).
    #[inline(always)]
    pub(super) fn brace_with<S: Simd>(
        &self,
        simd: S,
        pot: &Pot,
        presses: &[Part],
        footprints: &mut [Footprint],
        joint: &mut Joint,
        mut cutter: Option<&mut Cutter>,
    ) {
        let Some(bending) = pot.bending() else { return };
        footprints.iter_mut().for_each(|footprint| footprint.scratch.braced = None);
        let sound = presses.iter().enumerate().filter(|(_, (_, press))| press.is_sound());
        let tools = sound.map(|(number, (_, press))| Standing::of(number, press, pot));
        let look = |number: usize, way: &GivenWay| {
            let Scratch { contacts, braced, .. } = &mut footprints[number].scratch;
            let pressed = Pressed { pot, bending, press: &presses[number].1 };
            self.look(simd, &pressed, way, contacts, braced, cutter.as_deref_mut())
        };
        joint.settle(bending, tools, look);
        for footprint in footprints {
            let braced = &mut footprint.scratch.braced;
            *braced = braced.filter(|braced| braced.touched);
        }
    }

    /// Looks at a tool where the wall has given way; nothing where it does not touch it.
    ///
    /// A wide contact is first looked at along few rays, and then found where the wall has gone to.
    #[inline(never)]
    fn look<S: Simd>(
        &self,
        simd: S,
        pressed: &Pressed<'_>,
        way: &GivenWay,
        contacts: &mut Contacts,
        braced: &mut Option<Braced>,
        mut cutter: Option<&mut Cutter>,
    ) -> Option<Seen> {
        simd.vectorize(
            #[inline(always)]
            || {
                let &Pressed { pot, press, .. } = pressed;
                let surface = pot.met_from(press.side);
                if braced.is_none() {
                    let (behind_m, cutter) = (surface.inset_m(press.side), cutter.as_deref_mut());
                    if let Some(Glance { step, angle_rad }) = contacts.glance(simd, surface, press, behind_m, cutter) {
                        // nowhere near where it will be found
                        *braced = Some(Braced { found_m: f32::INFINITY, way: *way, touched: true });
                        let seen = self.seen(simd, pressed, &step, contacts, way)?;
                        return Some(Seen { angle_rad, ..seen });
                    }
                }
                if braced.is_none_or(|braced| braced.is_beyond(way)) {
                    let found_m = Braced::found_for(way);
                    find(simd, pot, press, found_m, contacts, cutter);
                    let touched = braced.is_some_and(|braced| braced.touched);
                    *braced = Some(Braced { found_m, way: *way, touched });
                }
                let braced = braced.as_mut()?;
                braced.way = *way;
                if !contacts.found_unbent().0 {
                    return None;
                }
                braced.touched = true;
                let way = braced.way();
                contacts.leave(simd, &way);
                let seen = self.seen(simd, pressed, &Step::of(surface), contacts, &way)?;
                Some(Seen { deepest_m: seen.deepest_m + braced.found_m, ..seen })
            },
        )
    }

    /// What is seen of contacts at a wall that has given way by so much more than where they were found, m; nothing where none is left.
    #[inline(always)]
    fn seen<S: Simd>(
        &self,
        simd: S,
        pressed: &Pressed<'_>,
        step: &Step,
        contacts: &Contacts,
        way: &GivenWay,
    ) -> Option<Seen> {
        let &Pressed { pot, bending, press } = pressed;
        let at = At { surface: pot.met_from(press.side), press, step: *step };
        let Strength { yield_pa, youngs_pa } = press.strength;
        let met = self.meet(simd, &at, contacts, way)?;
        let Borne { carried, all, half_rad } = borne(simd, press, &met.spot, contacts);
        let ellipse = &met.spot.ellipse;
        let hinge = Hinge {
            share: self.law.wall_softer,
            fold_m2: bending.fold_m2(yield_pa / youngs_pa),
            stays: self.law.wall_stays.into(),
        };
        Some(Seen {
            load_m2: carried * (met.pressure_pa * step.element_rad_m) / youngs_pa,
            deepest_m: contacts.found_unbent().1,
            angle_rad: contacts.angle_rad,
            z_m: press.centre_m.z + ellipse.above_m,
            patch_m: ellipse.mean_half_m(),
            one_sided: ((carried / all - HELD) / (ONE_SIDED - HELD)).clamp(0.0, 1.0),
            wider: self.law.folds_from(half_rad * ellipse.radius_m / bending.length_m()),
            hinge,
            fold_m: hinge.fold_m2 * bending.fold_compliance(press.centre_m.z),
        })
    }
}

/// A press on a wall that bends.
struct Pressed<'a> {
    pot: &'a Pot,
    bending: &'a WallBending,
    press: &'a Press,
}

/// Finds what a tool touches of clay that has gone from it by so much, m, or that was pushed against it.
#[inline(always)]
pub(super) fn find<S: Simd>(
    simd: S,
    pot: &Pot,
    press: &Press,
    gone_m: f32,
    contacts: &mut Contacts,
    cutter: Option<&mut Cutter>,
) {
    let surface = pot.met_from(press.side);
    let behind_m = surface.inset_m(press.side) - gone_m.max(0.0);
    let press = &if gone_m < 0.0 { press.nearer(-gone_m) } else { *press };
    apart(
        simd,
        #[inline(always)]
        || contacts.gather::<S, true>(simd, surface, press, behind_m, cutter),
    );
    if contacts.elements == 0 && matches!(press.tool, Tool::Sphere(_)) {
        contacts.gather_nearest(simd, surface, press, behind_m);
    }
}

/// How a contact is borne.
struct Borne {
    /// Sums of share·area·(the normal's part along the tool's own ray, away from the clay) and of share·area, over the area of an element at
    /// radius 1.
    carried: f32,
    all: f32,
    /// Half of what a paraboloid spans of the pot's turn that goes into the clay as widely as the tool does, rad: its edge, where the tool goes in by
    /// nothing, tells nothing, wherever elements or rays lie there.
    half_rad: f32,
}

#[inline(always)]
fn borne<S: Simd>(simd: S, press: &Press, spot: &Spot, contacts: &Contacts) -> Borne {
    let (zero, one) = (splat(simd, 0.0), splat(simd, 1.0));
    let [mut x, mut y, mut all, mut deep, mut away, mut away2] = [zero; 6];
    let bed = spot.bed();
    let outwards = outwards(press.side);
    for stretch in contacts.stretches() {
        let &Column { angle_rad, share, cos, sin, .. } = stretch.column;
        let [mut ahead_sum, mut aside_sum, mut deep_sum] = [zero; 3];
        for (chunk, above) in stretch.iter() {
            let (above, radius) = (above.on(simd), chunk.radius_m.on(simd));
            let depth = chunk.penetration_m.on(simd);
            let (elastic, shape) = bed.depth_m(radius * angle_rad, above);
            let carried = (depth / elastic).min(one) * shape * (radius - depth * outwards);
            ahead_sum += carried;
            aside_sum += carried * chunk.aside.on(simd);
            deep_sum += depth;
        }
        let [ahead_sum, aside_sum, deep_sum] = [ahead_sum * share, aside_sum * share, deep_sum * share];
        all += ahead_sum;
        deep += deep_sum;
        let by_angle = deep_sum * angle_rad;
        away += by_angle;
        away2 += by_angle * angle_rad;
        let aside = aside_sum * outwards;
        x += ahead_sum * cos - aside * sin;
        y += ahead_sum * sin + aside * cos;
    }
    let (sin, cos) = libm::sincosf(contacts.angle_rad);
    let deep = sum(deep);
    let [mean, second] = [away, away2].map(|lanes| sum(lanes) / deep);
    Borne { carried: sum(x) * cos + sum(y) * sin, all: sum(all), half_rad: root(6.0 * (second - mean * mean).max(0.0)) }
}
