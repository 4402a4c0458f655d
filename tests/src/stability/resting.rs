//! Clay itself in the loop: whether a hand that presses it comes to rest, and what is left for it to hold on to.
//!
//! Owns the table of methods, hands and delays with each method's own clay; the plane beside it has a linear wall.
//! Invariant: the loop and the clay are the studio's own, and nothing but method, hand and delay differs between two points.

use glam::Vec3;
use pottery_shared::clay::MethodKind;
use pottery_shared::haptics::{Coupling, DeviceSpecs};
use pottery_shared::units::{Seconds, Tick};

use super::bench::{Bench, Scene};
use super::mechanism::Grip;
use super::plane::bound_n_m;
use crate::chart::csv::{Cell, Row};
use crate::failures::{METHODS, larger, smaller};

/// Delays of the table, s.
const DELAYS_S: [f64; 4] = [0.0, 1e-3, 2e-3, 5e-3];
/// What the hand means to press with, N, as in the plane.
pub(super) const PUSH_N: f64 = 2.0;
/// Ticks for which it holds on, and from which on it is looked at.
const HELD: u32 = 3000;
pub(super) const LOOKED_AT: usize = 2500;
/// Who trembles by no more is at rest, m: four steps of the encoder, as in the plane.
pub(super) const STILL_M: f64 = 4.0 * DeviceSpecs::OMNI.resolution_m as f64;
/// How far from the clay it begins, m.
const AIR_M: f64 = 2e-3;

/// What becomes of a hand on clay.
#[derive(Clone, Copy, Debug)]
pub struct RestPoint {
    /// Whose clay it is, and whose force is rendered.
    pub method: MethodKind,
    /// Who holds the device.
    pub grip: Grip,
    /// Delay beyond the loop's own period, s.
    pub delay_s: f64,
    /// How far the device trembles in the last half second about its steady way, m.
    pub trembles_m: f64,
    /// Mean force over mean depth in that time, N/m: what there is to hold on to.
    pub felt_n_m: f64,
}

impl RestPoint {
    /// Whether it keeps still within four steps of the encoder.
    #[must_use]
    pub fn is_at_rest(&self) -> bool {
        self.trembles_m <= STILL_M
    }
}

impl Row for RestPoint {
    const COLUMNS: &'static [&'static str] =
        &["method", "hand", "delay_ms", "at_rest", "trembles_um", "felt_n_m", "theory_n_m"];

    fn cells(&self) -> Vec<Cell> {
        let method = METHODS.iter().find(|(method, _)| *method == self.method).map_or("", |(_, name)| name);
        vec![
            method.into(),
            self.grip.name.into(),
            (self.delay_s * 1e3).into(),
            self.is_at_rest().into(),
            (self.trembles_m * 1e6).into(),
            self.felt_n_m.into(),
            bound_n_m(&self.grip, self.delay_s).into(),
        ]
    }
}

/// Every method in every hand at every delay.
#[must_use]
pub fn measure_rest() -> Vec<RestPoint> {
    METHODS.iter().flat_map(|(method, _)| of_method(*method)).collect()
}

fn of_method(method: MethodKind) -> impl Iterator<Item = RestPoint> {
    Grip::ALL.into_iter().flat_map(move |grip| DELAYS_S.map(|delay_s| rest(method, grip, delay_s)))
}

/// A hand that means to press with so many newtons, a quarter of a second on the way.
pub(super) fn pressing(grip: Grip, push_n: f64) -> impl Fn(f64) -> Vec3 {
    let depth_m = push_n / grip.stiffness_n_m;
    move |seconds| {
        let way_m = (depth_m + AIR_M) * (4.0 * seconds).min(1.0);
        Bench::TOUCHING_M - Vec3::X * (way_m - AIR_M) as f32
    }
}

fn rest(method: MethodKind, grip: Grip, delay_s: f64) -> RestPoint {
    let felt = Bench::new(&Scene { delay_s, ..Scene::of(method) }).hold(grip, HELD, pressing(grip, PUSH_N));
    let last = &felt[LOOKED_AT..];
    let depths: Vec<f64> = last.iter().map(|felt| f64::from(Bench::TOUCHING_M.x) - felt.at_m.x).collect();
    let force_n = last.iter().map(|felt| f64::from(felt.force_n.x)).sum::<f64>() / last.len() as f64;
    let depth_m = depths.iter().sum::<f64>() / depths.len() as f64;
    RestPoint { method, grip, delay_s, trembles_m: about_a_line(&depths), felt_n_m: force_n / depth_m.max(1e-6) }
}

/// Most less least, about the straight line that fits best: a hand that sinks evenly does not tremble.
pub(super) fn about_a_line(depths: &[f64]) -> f64 {
    let middle = (depths.len() - 1) as f64 / 2.0;
    let mean = depths.iter().sum::<f64>() / depths.len() as f64;
    let from_middle = |at: usize| at as f64 - middle;
    let rise: f64 = depths.iter().enumerate().map(|(at, depth)| from_middle(at) * (depth - mean)).sum();
    let run: f64 = (0..depths.len()).map(|at| from_middle(at) * from_middle(at)).sum();
    let off = depths.iter().enumerate().map(|(at, depth)| depth - mean - rise / run * from_middle(at));
    let (least, most) = off.fold((f64::MAX, f64::MIN), |(least, most), off| (least.min(off), most.max(off)));
    most - least
}

/// Farthest that any hand trembles on the clay at any of the delays, mm.
pub(super) fn trembles(method: MethodKind) -> f64 {
    of_method(method).map(|point| point.trembles_m).fold(0.0, larger) * 1e3
}

/// Least stiffness that any hand feels at any of the delays, over that of the coupling for the delay.
pub(super) fn firmness(method: MethodKind) -> f64 {
    let coupling_n_m =
        |delay_s: f64| Coupling::tuned(&DeviceSpecs::OMNI, Tick::PERIOD, Seconds(delay_s as f32)).stiffness_n_m;
    let shares = of_method(method).map(|point| point.felt_n_m / f64::from(coupling_n_m(point.delay_s)));
    shares.fold(f64::INFINITY, smaller)
}
