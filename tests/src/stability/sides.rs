//! On which side of the wall a tool works: what the loop itself decides over the rim, in a pinch and at an opening that is too narrow.
//!
//! Owns the ways that hands go; nobody is told a side.
//! Invariant: whoever is on the other side of the wall a tick later, and not above the rim, has gone through it.

use glam::Vec3;
use pottery_shared::clay::{MethodKind, Pot, Support};
use pottery_shared::tool::{Sphere, Tool};
use pottery_shared::units::Metres;

use super::bench::{Bench, Felt, Scene};
use super::jolts;
use super::mechanism::Grip;
use super::online::{Holder, Session, hold};
use crate::failures::larger;
use crate::line::Quality;
use crate::simulation::BURSTS;

/// How fast a hand means to go, m/s.
const SPEED_M_S: f64 = 0.1;
/// A place on a way: distance from the axis and height, mm.
type Place = [f64; 2];

/// Into the pot and out again, high over the rim, with a press on either side.
const OVER: &[Place] = &[
    [80.0, 150.0],
    [68.0, 150.0],
    [80.0, 150.0],
    [80.0, 225.0],
    [30.0, 225.0],
    [30.0, 150.0],
    [44.0, 150.0],
    [30.0, 150.0],
    [30.0, 225.0],
    [80.0, 225.0],
    [80.0, 150.0],
    [68.0, 150.0],
];
/// The same so low that the tool meets the rim from outside, and from inside on the way back.
const GRAZING: &[Place] = &[[80.0, 209.0], [30.0, 209.0], [30.0, 225.0], [20.0, 225.0], [20.0, 209.0], [80.0, 209.0]];
/// Down into an opening, and about in it.
const DOWN: &[Place] = &[[0.0, 245.0], [0.0, 225.0], [6.0, 225.0], [-6.0, 222.0], [0.0, 245.0]];

/// To the wall from either side, of those who pinch it.
const OUTSIDE: &[Place] = &[[80.0, 150.0], [64.0, 150.0]];
const INSIDE: &[Place] = &[[30.0, 225.0], [30.0, 150.0], [48.0, 150.0]];

/// What came of a way.
#[derive(Clone, Copy, Debug, Default)]
struct Gone {
    /// Largest change of force in a tick over K·v·T.
    kick: f64,
    /// How often the tool was on the other side of the wall's middle a tick later, below the rim; infinite when clay is out of its bounds.
    through: f64,
}

impl Gone {
    fn worst(all: impl Iterator<Item = Self>) -> Self {
        all.fold(Self::default(), |worst, one| Self {
            kick: larger(worst.kick, one.kick),
            through: larger(worst.through, one.through),
        })
    }
}

/// Where somebody is on a way, at a second, m; at its end they stay.
fn on_the_way(places: &[Place], angle_rad: f64, seconds: f64) -> Vec3 {
    let mut left_mm = seconds * SPEED_M_S * 1e3;
    let mut at = places[0];
    for pair in places.windows(2) {
        let [from, to] = [pair[0], pair[1]];
        let length_mm = (to[0] - from[0]).hypot(to[1] - from[1]);
        let share = (left_mm / length_mm).min(1.0);
        at = [from[0] + (to[0] - from[0]) * share, from[1] + (to[1] - from[1]) * share];
        if left_mm < length_mm {
            break;
        }
        left_mm -= length_mm;
    }
    let [distance_mm, z_mm] = at;
    Vec3::new((distance_mm * angle_rad.cos()) as f32, (distance_mm * angle_rad.sin()) as f32, z_mm as f32) * 1e-3
}

/// Seconds that a way takes, and one to come to rest.
fn length_s(places: &[Place]) -> f64 {
    let length = places.windows(2).map(|pair| (pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]));
    length.sum::<f64>() * 1e-3 / SPEED_M_S + 1.0
}

/// What a hand felt on its way, and the clay after it.
fn gone(method: MethodKind, felt: &[Felt], pot: &Pot) -> Gone {
    let stiffness_n_m = f64::from(jolts::stiffness_n_m(method, 0.2));
    let fastest_m_s = felt.iter().map(|felt| felt.speed_m_s).fold(SPEED_M_S, larger);
    let surface = &pot.surfaces()[0];
    let is_below = |felt: &Felt| felt.tool_m.is_some_and(|tool_m| tool_m.z < surface.height_m());
    let mut gone = Gone::default();
    for pair in felt.windows(2) {
        let [before, now] = [&pair[0], &pair[1]];
        let change_n = f64::from(now.force_n.distance(before.force_n));
        gone.kick = larger(gone.kick, change_n / (stiffness_n_m * fastest_m_s * 1e-3));
        let is_through = is_below(before) && is_below(now) && before.stood != now.stood;
        gone.through += f64::from(u8::from(is_through));
    }
    // the wall is as thick everywhere as its radii are within their bounds
    let (low_m, high_m) = surface.bounds_m();
    let is_whole = surface.radii_m().iter().all(|radius_m| (low_m..=high_m).contains(radius_m));
    if is_whole && surface.thickness_m() == pot.spec().wall.0 { gone } else { Gone { through: f64::INFINITY, ..gone } }
}

/// Goes a way with a hollow pot, in every hand.
fn walk(method: MethodKind, places: &[Place], radius_mm: f32, is_narrow: bool) -> Gone {
    let scene = Scene { support: Support::Hollow, is_narrow, ..Scene::of(method) };
    let sphere = Sphere::new(Metres::from_mm(radius_mm)).expect("a tool of the suite");
    let ticks = (length_s(places) * 1e3) as u32;
    Gone::worst(Grip::ALL.into_iter().map(|grip| {
        let mut bench = Bench::with(&scene, Tool::from(sphere));
        let felt = bench.hold(grip, ticks, |seconds| on_the_way(places, 0.0, seconds));
        gone(method, &felt, bench.clay())
    }))
}

fn over(method: MethodKind) -> Gone {
    Gone::worst([OVER, GRAZING].into_iter().map(|places| walk(method, places, 12.0, false)))
}

fn down(method: MethodKind) -> Gone {
    walk(method, DOWN, 40.0, true)
}

/// Two hands on one hollow wall, one of which comes over the rim.
fn pinch(method: MethodKind) -> Gone {
    let scene = Scene { support: Support::Hollow, ..Scene::of(method) };
    let session = Session { scene, line: Quality::LAN, seed: 3, seconds: 4 };
    let holders = [OUTSIDE, INSIDE].map(|places| Holder::new(Grip::FIRM, |seconds| on_the_way(places, 0.0, seconds)));
    let held = hold(&session, &holders);
    Gone::worst(held.felt.iter().map(|felt| gone(method, felt, &held.pot)))
}

/// Largest change of force in a tick over K·v·T on the way over the rim, high and low.
pub(super) fn kick_over_the_rim(method: MethodKind) -> f64 {
    over(method).kick
}

/// The same for a tool of 40 mm at an opening of 26 mm.
pub(super) fn kick_at_an_opening(method: MethodKind) -> f64 {
    down(method).kick
}

/// The same for two firm hands that pinch a wall.
pub(super) fn kick_in_a_pinch(method: MethodKind) -> f64 {
    pinch(method).kick
}

/// How fast either of two hands is shaken that press a wall from both sides with 1.5 N, a hundred milliseconds away from each other, in the last
/// second of eight, mm/s.
pub(super) fn shaken_in_a_pinch(method: MethodKind) -> f64 {
    let scene = Scene { support: Support::Hollow, ..Scene::of(method) };
    let session = Session { scene, line: BURSTS, seed: 3, seconds: 8 };
    let shaken = Grip::ALL.map(|grip| {
        let pushes_mm = 1.5e3 / grip.stiffness_n_m;
        let ways = [[[80.0, 150.0], [72.0 - pushes_mm, 150.0]], [[32.0, 150.0], [40.0 + pushes_mm, 150.0]]];
        let holders = ways.map(|places| Holder::new(grip, move |seconds| on_the_way(&places, 0.0, seconds)));
        let held = hold(&session, &holders);
        let last = held.felt.iter().flat_map(|felt| felt.iter().rev().take(1000));
        last.map(|felt| felt.speed_m_s).fold(0.0, larger) * 1e3
    });
    shaken.into_iter().fold(0.0, larger)
}

/// Sides changed through the wall on any of these ways.
pub(super) fn through_the_wall(method: MethodKind) -> f64 {
    Gone::worst([over, down, pinch].into_iter().map(|way| way(method))).through
}
