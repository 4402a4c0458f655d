//! Several tools at one wall that bends: each finds it where all of them together have bent it to.
//!
//! Owns the balance between the tools' loads; what the clay opposes to each is told by who asks.
//! Invariant: the same tools make the same steps to the same answer, in whatever order they are given, and never more than
//! [`LOOKS_MAX`] looks at each contact.

use alloc::vec::Vec;
use core::cmp::Ordering;

use glam::Vec3;

use super::series::{GivenWay, Hinge, Seen};
use super::{Pot, Press, WallBending};
use crate::tool::Side;

/// Looks at each contact, at most. A wall alone takes five on the mean, one between two tools seven or eight; one in five hundred of those has not
/// come to rest within these.
const LOOKS_MAX: u32 = 24;
/// Difference between what the wall bears and what is on it at which both are taken as one, over the largest of the loads; it bounds the
/// error of the force.
const CLOSE: f64 = 1.0 / 400.0;
/// Share by which a contact's radius may then differ from the one that the wall has bowed under, and how the clay is held from how it will be: two loads may be as one by
/// chance.
const ALIKE: f32 = 0.02;
/// Newton's steps of one balance, at most, and halvings of one of them.
const STEPS_MAX: u32 = 24;
const HALVINGS_MAX: u32 = 8;
/// What of a balance may be left, over the deepest tool's depth.
const LEFT: f64 = 1e-5;

/// Most by which a wall bows within a contact, over what is left of the tool's depth: under a long tool it takes the tool's shape, or the tool
/// would stand on its ends. A bound at every place and not of the whole, so that a balance has no more than one contact to end at.
const BOW_MAX: f64 = 0.5;

/// What may be left of a depth where others push the wall against a tool, over the deepest's depth.
const PUSHED: f64 = 4.0;

/// Power with which a load is taken to rise with what is left of the depth before two looks have told, and the least and the most it is
/// taken for. Clay that has taken the tool's shape bears nearly as much whatever is left; what is left of a wall between two tools touches all of them at
/// once.
const POWER: f64 = 4.0 / 3.0;
const POWERS: [f64; 2] = [0.1, 4.0];
/// What a tool is taken to bear where nothing was seen of what it should, over that.
const MISSED: f64 = 0.1;
/// Power of the thickness with which a shell gives way less: from 1.8 to 2.5 for pots of 40 to 90 mm and walls of 8 to 2 mm by our own shell
/// ([`WallBending::compliance`]), 2.2 nearly everywhere. For two places each has half of it.
const STIFFER: f32 = 2.2;
/// A load that is missed to the other side comes to rest by itself where it is missed by less than this share of what it was missed by before, and by
/// less than that share of the largest load.
const SWINGS: f64 = 0.25;
const FAR: f64 = 0.05;
/// Least share of the way to what a balance says that is gone: with less a tool stands still while others still swing.
const SHARE_MIN: f64 = 0.05;
/// Looks that are nearer to each other than this share tell no power.
const NEAR: f64 = 1e-3;

/// Where a tool stands.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Standing {
    /// Its number among those that ask.
    number: usize,
    /// 1 for a tool that presses towards the axis, −1 for one that presses away from it.
    sign: f64,
    /// Of its contact's middle, once it touches.
    angle_rad: f32,
    z_m: f32,
    /// How thick the wall is there, over how thick it was made.
    thickness: f32,
    /// How far it stays folded away from the tool, and may at most, m.
    folded_m: f64,
    folds_most_m: f64,
}

impl Standing {
    /// Of a press with a number.
    pub(super) fn of(number: usize, press: &Press, pot: &Pot) -> Self {
        let sign = match press.side {
            Side::Outside => 1.0,
            Side::Inside => -1.0,
        };
        let Vec3 { x, y, z: z_m } = press.centre_m;
        let angle_rad = libm::atan2f(y, x);
        let folded_m = sign * f64::from(pot.folded_m(angle_rad, z_m));
        let folds_most_m = pot.bending().map_or(0.0, WallBending::folds_most_m).into();
        Self { number, sign, angle_rad, z_m, thickness: pot.thickness_about(angle_rad, z_m), folded_m, folds_most_m }
    }

    fn place(&self) -> [f32; 2] {
        [self.angle_rad, self.z_m]
    }
}

/// A tool at the wall.
#[derive(Clone, Copy, Debug, Default)]
struct At {
    standing: Standing,
    patch_m: f32,
    /// See [`Joint::spread_m`].
    spread_m: f32,
    one_sided: f32,
    /// See [`Seen::wider`], of the first look at which it touches: of the contact that is left later a wall would fold the later the less it has
    /// given way, which has two ends.
    wider: f32,
    /// By how much more one place gives way to another's load than where the wall is as thick as it was made: the product of both.
    softer: f64,
    /// See [`Seen::deepest_m`]; none while it has never touched.
    deepest_m: Option<f64>,
    /// When the wall yields under it, see [`Seen`], and how it does at its place under all of them.
    hinge: Hinge,
    wall: Hinge,
    fold_m: f32,
    /// What was left at the last look, m, and borne, m²; the power with which the load rises with what is left.
    known: [f64; 2],
    power: f64,
    /// How firmly it presses, over the last look, less than nothing where it does not touch: of powers of this are what is left of its depth,
    /// m, and its load over Young's modulus, m², with their slopes.
    firmly: f64,
    most_firmly: f64,
    left_m: [f64; 2],
    load_m2: f64,
    slope_m2: f64,
    /// By how much too deep it is then, m; by how much more it bears than the wall does that has given way so far, as an elastic wall's depth, m; and
    /// the part of a change of the first that is one of the second.
    over_m: f64,
    excess_m: f64,
    elastic: f64,
    /// How far the wall gives way under it, m, and its share of what one that does not yield would not.
    given_m: f64,
    hinge_m: f64,
    /// See [`GivenWay::folds_by_m`].
    folds_by_m: f64,
    /// How far it had given way at the last look and the load under which it folded, by how much more the tool bore there than it should have, m², and the
    /// share of the way to what the balance says that is gone: half as much wherever that turns round and does not come to rest by itself.
    looked_m: f64,
    looked_net_m2: f64,
    missed_m2: f64,
    share: f64,
    /// See [`GivenWay::layer_per_m`].
    layer_per_m: f32,
    /// The compliance by which the wall folds there, 1/m, and the load under which it does, m², in the tool's direction.
    own_per_m: f64,
    net_m2: f64,
}

impl At {
    /// Takes in what was seen where the wall had given way as the balance said.
    fn take(&mut self, seen: &Seen) {
        let (deepest_m, load_m2) = (f64::from(seen.deepest_m), f64::from(seen.load_m2));
        (self.standing.angle_rad, self.standing.z_m) = (seen.angle_rad, seen.z_m);
        self.patch_m = seen.patch_m;
        if self.deepest_m.is_none() {
            // of the wall as it was: one that has given way is touched on one side in the end, whatever held the tool
            (self.one_sided, self.wider) = (seen.one_sided, seen.wider);
        }
        // as a plate folds
        let firmer = self.wider * self.standing.thickness * self.standing.thickness;
        self.hinge = Hinge { fold_m2: seen.hinge.fold_m2 * firmer, ..seen.hinge };
        self.fold_m = seen.fold_m * firmer * (self.softer * self.softer) as f32;
        let left_m = deepest_m - self.given_m;
        if load_m2 > 0.0 && left_m > 0.0 {
            self.deepest_m = Some(deepest_m);
            let [left_before_m, before_m2] = core::mem::replace(&mut self.known, [left_m, load_m2]);
            let nearer = left_m / left_before_m;
            if before_m2 > 0.0 && (nearer - 1.0).abs() > NEAR {
                let power = libm::log(load_m2 / before_m2) / libm::log(nearer);
                self.power = power.clamp(POWERS[0], POWERS[1]);
            }
        }
        self.load_m2 = load_m2;
    }

    /// Takes in that nothing was borne there: where something should have been, it is much less.
    fn miss(&mut self) {
        if self.load_m2 > 0.0 {
            self.known = [self.left_m[0], MISSED * self.load_m2];
        }
        self.load_m2 = 0.0;
    }

    /// Powers of firmness: neither falls with it as it nears nothing, so that Newton's steps come to an end.
    fn powers(&self) -> [f64; 2] {
        if self.power < 1.0 { [1.0 / self.power, 1.0] } else { [1.0, self.power] }
    }

    /// Such a power of firmness, or the inverse of one.
    fn raised(firmly: f64, power: f64) -> f64 {
        // one of the two always is
        if power == 1.0 { firmly } else { libm::pow(firmly, power) }
    }

    /// Begins where the last look was, and where the balance led to none yet with what would be left if the wall bore the tool alone; never will
    /// more than so much be left, m.
    fn begin(&mut self, most_m: f64) {
        let (Some(deepest_m), [known_m, known_m2]) = (self.deepest_m, self.known) else { return };
        let [of_left, of_load] = self.powers();
        self.most_firmly = Self::raised(most_m / known_m, 1.0 / of_left);
        if self.missed_m2 != 0.0 {
            self.firmly = 1.0;
            return;
        }
        self.firmly = Self::raised(deepest_m.max(0.0) / known_m, 1.0 / of_left);
        if self.own_per_m > 0.0 {
            let borne_m2 = self.wall.load_m2((deepest_m.max(0.0) / self.own_per_m) as f32);
            self.firmly = self.firmly.min(Self::raised(f64::from(borne_m2) / known_m2, 1.0 / of_load));
        }
    }

    /// What is left and borne at a firmness.
    fn press(&mut self, firmly: f64) {
        let [known_m, known_m2] = self.known;
        if !firmly.is_finite() {
            return;
        }
        let firmly = firmly.min(self.most_firmly);
        self.firmly = firmly;
        if firmly <= 0.0 {
            // it comes off
            (self.left_m, self.load_m2, self.slope_m2) = ([known_m * firmly, known_m], 0.0, 0.0);
            return;
        }
        let [of_left, of_load] = self.powers();
        let left_m = known_m * Self::raised(firmly, of_left);
        self.left_m = [left_m, of_left * left_m / firmly];
        self.load_m2 = known_m2 * Self::raised(firmly, of_load);
        self.slope_m2 = of_load * self.load_m2 / firmly;
    }

    /// Goes to a look its share of the way to where the balance says that the wall gives way, and how much it folds there.
    fn approach(&mut self) {
        self.given_m = self.looked_m + self.share * (self.given_m - self.looked_m);
        self.net_m2 = self.looked_net_m2 + self.share * (self.net_m2 - self.looked_net_m2);
        (self.looked_m, self.looked_net_m2) = (self.given_m, self.net_m2);
    }

    /// How far the wall stays folded towards where something is, towards the axis or away from it, m.
    fn folded_as(&self, towards_m: f64) -> f64 {
        let folded_m = self.standing.sign * self.standing.folded_m;
        if folded_m * towards_m > 0.0 { folded_m } else { 0.0 }
    }

    /// How the wall gives way under it, to be looked at.
    fn way(&self, bending: &WallBending) -> GivenWay {
        let (net_m2, softer) = (self.net_m2 as f32, (self.softer * self.softer) as f32);
        let local_m = self.own_per_m as f32 * net_m2 * (1.0 + self.wall.softer(net_m2));
        GivenWay {
            depth_m: self.given_m as f32,
            bow_per_m: (net_m2 * softer * bending.bow(self.patch_m)).max(0.0),
            bow_most_m: (BOW_MAX * (self.deepest_m.unwrap_or(0.0) - self.given_m)).max(0.0) as f32,
            load_m2: self.load_m2 as f32,
            softer,
            hinge_m: self.hinge_m as f32,
            layer_per_m: self.layer_per_m,
            folds: Hinge { fold_m2: self.fold_m, ..self.wall }.folds_at(local_m),
            folds_away: net_m2 > 0.0,
            folds_by_m: self.folds_by_m as f32,
        }
    }
}

/// Room for the balance, kept so that no step allocates.
#[derive(Clone, Debug, Default)]
pub(super) struct Joint {
    tools: Vec<At>,
    /// How far the wall gives way at one tool's place under another's load, 1/m, and the share of that load by which it folds there.
    between_per_m: Vec<f64>,
    folding: Vec<f64>,
    /// How near another is to a tool along the wall, `[tools][tools]`: `(1 − (d/t)²)²`, and nothing where it is farther than the wall is thick there.
    near: Vec<f32>,
    /// Newton's matrix with its right-hand side, `[tools][tools + 1]`.
    system: Vec<f64>,
    /// How firmly the tools pressed before a step, and where the balance was best.
    before: Vec<f64>,
    best: Vec<f64>,
}

impl Joint {
    /// Room for so many tools.
    pub(super) fn with_room(tools: usize) -> Self {
        Self {
            tools: Vec::with_capacity(tools),
            between_per_m: Vec::with_capacity(tools * tools),
            folding: Vec::with_capacity(tools * tools),
            near: Vec::with_capacity(tools * tools),
            system: Vec::with_capacity(tools * (tools + 1)),
            before: Vec::with_capacity(tools),
            best: Vec::with_capacity(tools),
        }
    }

    /// Lets tools bend the wall together. `look` tells what one of them meets at a wall that has given way under it, by less than nothing where
    /// others push it against the tool; nothing where it does not touch.
    ///
    /// With the depth `p_i` of a tool at the unbent wall, its load `L_i` over Young's modulus, `s_i` its direction and `c_ij` the wall's
    /// answer at one to a load on another, it finds `L_i = a_i·(p_i − w_i)^m_i` and
    /// `w_i = s_i·(Σ c_ij·s_j·L_j + C_i·α·N_i·(N_i/P_i)⁵)`: a wall folds under `N_i = Σ k_ij·s_j·L_j`, k the cone to which it folds, and where it
    /// stays folded that way already, the last term is less by so much, as far as there is any of it. C and P are the means of what they are under each
    /// tool alone, by what of its load is borne there, and the discs that load the wall are [`Joint::spread_m`]: two at one place find it at one place, or what they squeeze would be there twice or not at all.
    /// `a_i` is what the last look told and `m_i` what the last two did, and the balance is found by Newton's method, until the looks say what the
    /// balance does. Its steps are taken for the load that a wall bears which has given way so far: for how far it gives way under a load, they lead orders of
    /// magnitude beyond where it folds, and come back by a sixth at a time. Where the wall is `x` times as thick as it was made, c goes by `x^−1.1` of either place and P by x².
    pub(super) fn settle(
        &mut self,
        bending: &WallBending,
        tools: impl Iterator<Item = Standing>,
        mut look: impl FnMut(usize, &GivenWay) -> Option<Seen>,
    ) {
        self.tools.clear();
        self.tools.extend(tools.map(|standing| At {
            softer: libm::powf(standing.thickness, -0.5 * STIFFER).into(),
            standing,
            power: POWER,
            share: 1.0,
            fold_m: f32::MAX,
            one_sided: 1.0,
            wider: 1.0,
            ..At::default()
        }));
        for tool in &mut self.tools {
            let seen = look(tool.standing.number, &GivenWay::default()).filter(|seen| seen.load_m2 > 0.0);
            if let Some(seen) = seen {
                tool.take(&seen);
            }
        }
        // an order of their own, so that no sum goes by that in which they were given
        let key = |At { load_m2, standing: Standing { sign, angle_rad, z_m, .. }, .. }: &At| {
            [*load_m2, *sign, f64::from(*angle_rad), f64::from(*z_m)]
        };
        self.tools.sort_unstable_by(|one, other| {
            let pairs = key(one).into_iter().zip(key(other));
            pairs.map(|(one, other)| one.total_cmp(&other)).find(|order| order.is_ne()).unwrap_or(Ordering::Equal)
        });
        for _ in 1..LOOKS_MAX {
            self.answers(bending);
            self.balance();
            let mut is_found = true;
            for number in 0..self.tools.len() {
                let now = self.layer_per_m(bending, number);
                let tool = &mut self.tools[number];
                tool.layer_per_m += tool.share as f32 * (now - tool.layer_per_m);
                is_found &= (tool.layer_per_m - now).abs() <= ALIKE * now;
            }
            let most_m2 = self.tools.iter().map(|tool| tool.load_m2).fold(0.0, f64::max);
            for tool in &mut self.tools {
                tool.approach();
                let way = tool.way(bending);
                let (borne_m2, patch_m) = (tool.load_m2, tool.patch_m);
                match look(tool.standing.number, &way).filter(|seen| seen.load_m2 > 0.0) {
                    Some(seen) => tool.take(&seen),
                    None => tool.miss(),
                }
                let missed_m2 = tool.load_m2 - borne_m2;
                if missed_m2 * tool.missed_m2 >= 0.0 {
                    tool.share = (1.5 * tool.share).min(1.0);
                } else if missed_m2.abs() > SWINGS * tool.missed_m2.abs() || missed_m2.abs() > FAR * most_m2 {
                    tool.share = f64::max(0.5 * tool.share, SHARE_MIN);
                }
                tool.missed_m2 = missed_m2;
                is_found &= missed_m2.abs() <= CLOSE * most_m2 && (tool.patch_m - patch_m).abs() <= ALIKE * patch_m;
            }
            if is_found {
                break;
            }
        }
    }

    /// Looks up how near the tools are to each other.
    fn neighbours(&mut self, bending: &WallBending) {
        let Self { tools, near, .. } = self;
        near.clear();
        for (row, one) in tools.iter().enumerate() {
            let thick_m = bending.wall_m() * one.standing.thickness;
            for (column, other) in tools.iter().enumerate() {
                if row == column {
                    near.push(1.0);
                    continue;
                }
                let away = bending.distance_m(one.standing.place(), other.standing.place()) / thick_m;
                let part = (1.0 - away * away).max(0.0);
                near.push(part * part);
            }
        }
    }

    /// The tools with how near each is to one of them.
    fn about(&self, number: usize) -> impl Iterator<Item = (&At, f32)> {
        let count = self.tools.len();
        self.tools.iter().zip(self.near[number * count..][..count].iter().copied())
    }

    /// How the clay between a tool and those against it is held, see [`GivenWay::layer_per_m`]: what is near it does, by so much of its load as it is near.
    fn layer_per_m(&self, bending: &WallBending, number: usize) -> f32 {
        let one = &self.tools[number];
        let against = self.about(number).filter(|(other, _)| other.standing.sign != one.standing.sign);
        let held_m2: f64 = against.map(|(other, near)| f64::from(near) * other.load_m2).sum();
        let share = if held_m2 < one.load_m2 { (held_m2 / one.load_m2) as f32 } else { f32::from(held_m2 > 0.0) };
        share / (0.5 * bending.wall_m() * one.standing.thickness)
    }

    /// Radius of the disc on which a tool and those near it load the wall, m: the mean of their contacts', by their loads. Between two that
    /// squeeze it, each on a disc of its own, it would bend by more than what of them is left in the clay.
    fn spread_m(&self, number: usize) -> f32 {
        let one = &self.tools[number];
        let (mut off, mut all_m2) = (0.0, 0.0);
        for (other, near) in self.about(number) {
            let load_m2 = near * other.load_m2 as f32;
            all_m2 += load_m2;
            off += load_m2 * (other.patch_m - one.patch_m);
        }
        if all_m2 > 0.0 { one.patch_m + off / all_m2 } else { one.patch_m }
    }

    /// Looks up how the wall answers between all of them.
    fn answers(&mut self, bending: &WallBending) {
        self.neighbours(bending);
        for number in 0..self.tools.len() {
            self.tools[number].spread_m = self.spread_m(number);
        }
        let Self { tools, between_per_m, folding, .. } = self;
        between_per_m.clear();
        folding.clear();
        for (row, one) in tools.iter().enumerate() {
            for (column, other) in tools.iter().enumerate() {
                let [at, from] = [one, other].map(|tool| tool.standing.place());
                let patch_m = one.spread_m.max(other.spread_m);
                let per_m = if row == column {
                    bending.compliance(one.standing.z_m, patch_m)
                } else {
                    bending.between(at, from, patch_m)
                };
                // what holds a tool from several sides bends nothing, and keeps it from nothing that others bend
                let bends = other.one_sided * other.one_sided;
                between_per_m.push(f64::from(bends * per_m) * (one.softer * other.softer));
                folding.push(if row == column { 1.0 } else { f64::from(bending.folding(at, from)) });
            }
        }
        self.folds();
    }

    /// How the wall folds at the place of each: see [`Joint::settle`].
    fn folds(&mut self) {
        let Self { tools, between_per_m, folding, .. } = self;
        let count = tools.len();
        for number in 0..count {
            let alone = |tool: usize| {
                let Hinge { share, fold_m2, stays } = tools[tool].hinge;
                [between_per_m[tool * (count + 1)], share.into(), fold_m2.into(), stays]
            };
            let own = alone(number);
            let (mut off, mut all_m2) = ([0.0; 4], 0.0);
            for (other, cone) in folding[number * count..][..count].iter().enumerate() {
                let load_m2 = cone * tools[other].load_m2;
                all_m2 += load_m2;
                off.iter_mut()
                    .zip(alone(other))
                    .zip(own)
                    .for_each(|((off, other), own)| *off += load_m2 * (other - own));
            }
            let share = if all_m2 > 0.0 { 1.0 / all_m2 } else { 0.0 };
            let [per_m, softer, fold_m2, stays] = core::array::from_fn(|at| own[at] + share * off[at]);
            let tool = &mut tools[number];
            tool.own_per_m = per_m;
            tool.wall = Hinge { share: softer as f32, fold_m2: fold_m2 as f32, stays };
        }
    }

    /// Finds the loads that the wall bears, and how far it gives way to them.
    fn balance(&mut self) {
        let count = self.tools.len();
        let most_m = self.tools.iter().filter_map(|tool| tool.deepest_m).fold(0.0, f64::max);
        for tool in &mut self.tools {
            tool.begin(PUSHED * most_m);
            tool.press(tool.firmly);
        }
        let (mut left, mut excess) = self.put_on();
        let mut least = f64::INFINITY;
        for _ in 0..STEPS_MAX {
            if left <= LEFT * most_m {
                return;
            }
            self.fill_system();
            solve(&mut self.system, count);
            self.before.clear();
            self.before.extend(self.tools.iter().map(|tool| tool.firmly));
            if left < least {
                least = left;
                self.best.clone_from(&self.before);
            }
            let (excess_before, mut share) = (excess, 1.0);
            for _ in 0..=HALVINGS_MAX {
                let steps = self.system.chunks_exact(count + 1);
                for ((tool, before), row) in self.tools.iter_mut().zip(&self.before).zip(steps) {
                    tool.press(before - share * row[count]);
                }
                (left, excess) = self.put_on();
                if excess < excess_before * (1.0 - 0.1 * share) {
                    break;
                }
                share *= 0.5;
            }
        }
        // a step may lead away, since the way to a balance is not always downhill
        if left > least {
            self.tools.iter_mut().zip(&self.best).for_each(|(tool, best)| tool.press(*best));
            self.put_on();
        }
    }

    /// Lets what is left of the depths load the wall; the most by which a depth is then not what it should be, m, and a load, as an elastic wall's depth.
    fn put_on(&mut self) -> (f64, f64) {
        let Self { tools, between_per_m, folding, .. } = self;
        let count = tools.len();
        let (mut most_m, mut excess_m) = (0.0, 0.0);
        for number in 0..count {
            let [per_m, cone] = [&*between_per_m, &*folding].map(|square| &square[number * count..][..count]);
            let (mut bent_m, mut net_m2, mut all_m2) = (0.0, 0.0, 0.0);
            for ((other, per_m), cone) in tools.iter().zip(per_m).zip(cone) {
                bent_m += per_m * other.standing.sign * other.load_m2;
                net_m2 += cone * other.standing.sign * other.load_m2;
                all_m2 += cone * other.load_m2;
            }
            let tool = &mut tools[number];
            let own_m = tool.own_per_m * net_m2;
            let hinge_m = own_m * f64::from(tool.wall.softer(net_m2 as f32));
            let folded_m = tool.folded_as(hinge_m);
            // what stays of it is in the radii
            let more_m = hinge_m - folded_m.clamp(-hinge_m.abs(), hinge_m.abs());
            tool.net_m2 = tool.standing.sign * net_m2;
            tool.given_m = tool.standing.sign * (bent_m + more_m);
            let share = if all_m2 > 0.0 { tool.standing.sign * tool.load_m2 / all_m2 } else { 0.0 };
            tool.hinge_m = share * more_m;
            let folds_most_m = tool.standing.folds_most_m;
            let left_m = (tool.wall.stays * hinge_m).clamp(-folds_most_m, folds_most_m) - folded_m;
            tool.folds_by_m = if left_m * hinge_m > 0.0 { share * left_m } else { 0.0 };
            if let Some(deepest_m) = tool.deepest_m {
                tool.over_m = tool.left_m[0] + tool.given_m - deepest_m;
                (tool.excess_m, tool.elastic) = (tool.over_m, 1.0);
                let own_per_m = tool.own_per_m;
                if own_per_m > 0.0 {
                    let elastic_m = tool.standing.sign * (deepest_m - tool.left_m[0]) - bent_m + own_m;
                    let unfolded_m2 = (elastic_m / own_per_m) as f32;
                    let folded_m = tool.folded_as(elastic_m);
                    let bears_m2 = tool.wall.load_m2(((elastic_m + folded_m) / own_per_m) as f32);
                    // no farther than it stays folded it gives way as a wall that does not fold
                    let folds = bears_m2.abs() < unfolded_m2.abs();
                    let bears_m2 = if folds { bears_m2 } else { unfolded_m2 };
                    tool.excess_m = tool.standing.sign * (own_m - own_per_m * f64::from(bears_m2));
                    tool.elastic = if folds { 1.0 / (1.0 + 7.0 * f64::from(tool.wall.softer(bears_m2))) } else { 1.0 };
                }
                (most_m, excess_m) = (f64::max(most_m, tool.over_m.abs()), f64::max(excess_m, tool.excess_m.abs()));
            }
        }
        (most_m, excess_m)
    }

    /// Writes down Newton's step.
    fn fill_system(&mut self) {
        let Self { tools, between_per_m, folding, system, .. } = self;
        let count = tools.len();
        system.clear();
        for (row, one) in tools.iter().enumerate() {
            let folds_per_m = one.own_per_m * (1.0 - one.elastic);
            for (column, other) in tools.iter().enumerate() {
                let at = row * count + column;
                // one that has never touched bears nothing and is moved by nobody
                let is_own = row == column;
                system.push(match one.deepest_m {
                    Some(_) => {
                        let moved = one.elastic * between_per_m[at] + folds_per_m * folding[at];
                        let given = one.standing.sign * other.standing.sign * moved * other.slope_m2;
                        if is_own { one.elastic * one.left_m[1] + given } else { given }
                    }
                    None if is_own => 1.0,
                    None => 0.0,
                });
            }
            system.push(one.excess_m);
        }
    }
}

/// Solves `count` equations by elimination: the last column becomes the answer. The largest of a column is taken first.
fn solve(system: &mut [f64], count: usize) {
    let wide = count + 1;
    for step in 0..count {
        let largest = (step..count)
            .max_by(|one, other| system[one * wide + step].abs().total_cmp(&system[other * wide + step].abs()))
            .unwrap_or(step);
        (step..wide).for_each(|column| system.swap(step * wide + column, largest * wide + column));
        for row in 0..count {
            let part = system[row * wide + step] / system[step * wide + step];
            if row == step || part == 0.0 {
                continue;
            }
            for column in step..wide {
                system[row * wide + column] -= part * system[step * wide + column];
            }
        }
    }
    for row in 0..count {
        system[row * wide + count] /= system[row * wide + row];
    }
}
