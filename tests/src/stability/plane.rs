//! The plane of stiffness and delay: how stiff a wall each way of rendering renders without trembling.
//!
//! Owns the wall, the search for the bound and the bounds by theory.
//! Invariant: what is called stable is stable at every lower stiffness that was tried as well.

use std::sync::OnceLock;

use glam::Vec3;
use pottery_shared::clay::MethodKind;
use pottery_shared::haptics::{Coupling, DeviceSpecs, Haptics, Setup, Stages, Touch};
use pottery_shared::tool::Position;
use pottery_shared::units::Seconds;

use super::mechanism::{Grip, Mechanism};
use crate::chart::csv::{Cell, Row};
use crate::failures::METHODS;

/// Period of the loop, s.
const PERIOD_S: f64 = 1e-3;
/// How deep behind the wall's surface the hand means to be, times its stiffness: what it presses with, N.
const PUSH_N: f64 = 2.0;
/// Stiffness of what stands for clay behind a coupling, N/m: the elastic stiffness of clay under a fingertip.
const CLAY_N_M: f32 = 48_000.0;
/// Ratio between two stiffnesses that are tried.
const RATIO: f64 = 1.05;
/// Stiffnesses between which the bound is looked for, N/m.
const RANGE_N_M: (f64, f64) = (20.0, 30_000.0);

/// Delays of the whole plane, s.
pub const PLANE_DELAYS_S: [f64; 9] = [0.0, 1e-3, 2e-3, 3e-3, 5e-3, 7e-3, 10e-3, 15e-3, 20e-3];

/// A point of the edge of what is stable.
#[derive(Clone, Copy, Debug)]
pub struct PlanePoint {
    /// Whose force is rendered.
    pub method: MethodKind,
    /// Who holds the device.
    pub grip: Grip,
    /// Delay beyond the loop's own period, s.
    pub delay_s: f64,
    /// Largest stable stiffness, N/m.
    pub stable_n_m: f64,
}

impl Row for PlanePoint {
    const COLUMNS: &'static [&'static str] = &["method", "hand", "delay_ms", "stable_n_m", "theory_n_m"];

    fn cells(&self) -> Vec<Cell> {
        let method = METHODS.iter().find(|(method, _)| *method == self.method).map_or("", |(_, name)| name);
        let theory_n_m = bound_n_m(&self.grip, self.delay_s);
        let figures = [self.delay_s * 1e3, self.stable_n_m, theory_n_m].map(Cell::from);
        [method.into(), self.grip.name.into()].into_iter().chain(figures).collect()
    }
}

/// The edge of every method in every hand, at so many delays, s.
#[must_use]
pub fn measure_plane(delays_s: &[f64]) -> Vec<PlanePoint> {
    let mut points = Vec::new();
    for (method, _) in METHODS {
        for grip in Grip::ALL {
            let point = |delay_s| {
                let stable_n_m = stable_stiffness_n_m(method, grip, delay_s);
                PlanePoint { method, grip, delay_s, stable_n_m }
            };
            points.extend(delays_s.iter().copied().map(point));
        }
    }
    points
}

/// A stage of ours that can be left out, to see what it is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, clap::ValueEnum)]
pub enum Stage {
    /// The device presses the clay itself, and feels the clay's own force.
    Proxy,
    /// Clay that goes by drags at nothing.
    Drag,
    /// Nothing keeps the loop from giving back more energy than it took.
    Passivity,
    /// Corrected clay is felt at once.
    Correction,
    /// The force is whole at once after a pause.
    Ramp,
}

/// Ours as it is studied in this run of a program.
static STUDIED: OnceLock<Stages> = OnceLock::new();

/// Leaves stages of ours out, in all that this program runs from now on.
///
/// # Panics
/// When something was run before, or it is called again.
pub fn leave_out(stages: &[Stage]) {
    let mut studied = Stages::WHOLE;
    for stage in stages {
        *match stage {
            Stage::Proxy => &mut studied.proxy,
            Stage::Drag => &mut studied.drag,
            Stage::Passivity => &mut studied.passivity,
            Stage::Correction => &mut studied.correction,
            Stage::Ramp => &mut studied.ramp,
        } = false;
    }
    assert!(STUDIED.set(studied).is_ok(), "one chain is studied in a run");
}

/// How a method's force is rendered for this purpose: as it was published, and ours through the whole chain, or what is studied of it.
#[must_use]
pub(super) fn stages(method: MethodKind) -> Stages {
    match method {
        MethodKind::Original => Stages::ORIGINAL,
        MethodKind::Improved => Stages::EXACT,
        MethodKind::Plastic => *STUDIED.get_or_init(|| Stages::WHOLE),
    }
}

/// Largest stiffness that theory allows for a hand: `b/(T/2 + t_d)`, N/m.
#[must_use]
pub fn bound_n_m(grip: &Grip, delay_s: f64) -> f64 {
    f64::from(Coupling::stiffness_limit(grip.damping_ns_m as f32, Seconds(PERIOD_S as f32), Seconds(delay_s as f32)))
}

/// Largest stiffness, N/m, below which a hand that presses a wall comes to rest.
#[must_use]
pub fn stable_stiffness_n_m(method: MethodKind, grip: Grip, delay_s: f64) -> f64 {
    let (mut stiffness, highest) = RANGE_N_M;
    let mut stable = 0.0;
    while stiffness <= highest && comes_to_rest(method, grip, delay_s, stiffness as f32) {
        stable = stiffness;
        stiffness *= RATIO;
    }
    stable
}

/// Whether a hand that presses a wall of that stiffness keeps still within four steps of its encoder in the end.
fn comes_to_rest(method: MethodKind, grip: Grip, delay_s: f64, stiffness_n_m: f32) -> bool {
    // a device that bears whatever is asked for: it is the loop that is tried, not the motors
    let specs = DeviceSpecs { peak_force_n: 100.0, continuous_force_n: None, ..DeviceSpecs::OMNI };
    let has_proxy = stages(method).proxy;
    let coupling = has_proxy.then_some(Coupling { stiffness_n_m, damping_ns_m: 0.0 });
    let wall_n_m = if has_proxy { CLAY_N_M.max(10.0 * stiffness_n_m) } else { stiffness_n_m };
    let delay = Seconds(delay_s as f32);
    let setup = Setup { stages: stages(method), felt_share: 1.0, coupling, delay, ..Setup::for_device(specs, 1.0) };
    let mut chain = Haptics::new(setup);
    let resolution_m = f64::from(specs.resolution_m);
    let mut hand = Mechanism::at_rest(grip, Vec3::X * 5e-3, resolution_m, delay_s);
    let meant_m = Vec3::X * (-PUSH_N / grip.stiffness_n_m) as f32;
    let (mut least, mut most) = (f64::MAX, f64::MIN);
    for tick in 0..3000 {
        let pressed = chain.accept(Some(hand.reported_m()), None, Seconds(PERIOD_S as f32));
        let force_n = pressed.map_or(Vec3::ZERO, |centre| chain.render(&wall(centre, wall_n_m)));
        hand.pass(force_n, meant_m, PERIOD_S);
        let at_m = hand.motion().0.x;
        if at_m.abs() > 0.2 {
            return false;
        }
        if tick >= 2500 {
            (least, most) = (least.min(at_m), most.max(at_m));
        }
    }
    most - least <= 4.0 * resolution_m
}

/// An elastic wall at x = 0.
fn wall(centre: Position, stiffness_n_m: f32) -> Touch {
    let penetration_m = (-centre.point_m().x).max(0.0);
    Touch { centre, force_n: Vec3::X * (penetration_m * stiffness_n_m), penetration_m, held_n: 0.0, wet: None }
}
