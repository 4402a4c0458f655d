//! A teacher's hand on a student's: what it draws the student's tool to, where a tool is pressed that both hold, and with which force.
//!
//! A stage of the haptic chain, between correction and passivity; knows no clay, no network and nobody's rights. The teacher's
//! places come as they were heard of, late and with gaps ([`Playout`]).
//! Invariant: its force is finite and no longer than [`Guide::FORCE_SHARE`] of what the device gives, it is zero in the tick in which
//! guidance ends, and what it does on the hand is paid for ([`Tank`]).

mod around;
mod noise;
mod playout;
mod tank;

use glam::Vec3;

use super::given::Given;
use super::{Coupling, DeviceSpecs, VelocityEstimate};
use crate::units::{Seconds, Tick};
use around::Around;
use noise::Noise;
use playout::Playout;
use tank::Tank;

/// What a teacher's hand does with a student's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum GuidanceMode {
    /// It is seen and not felt.
    #[default]
    Point,
    /// It draws the student's tool to itself (a virtual fixture), less the better the student follows.
    Lead,
    /// The tool is pressed between both hands: at `α·teacher + (1 − α)·student`, round the wheel's axis. With α = 1 the teacher has
    /// taken over.
    Share,
    /// A force of random direction disturbs the student, who practises against it.
    Noise,
    /// The student's own error is driven farther.
    Repel,
}

impl GuidanceMode {
    /// Every one.
    pub const ALL: [Self; 5] = [Self::Point, Self::Lead, Self::Share, Self::Noise, Self::Repel];

    /// Its number, as it is sent.
    #[must_use]
    pub const fn number(self) -> u8 {
        self as u8
    }

    /// The one of a number.
    #[must_use]
    pub fn from_number(number: u8) -> Option<Self> {
        Self::ALL.get(usize::from(number)).copied()
    }

    /// What it is called.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Point => "point",
            Self::Lead => "lead",
            Self::Share => "share",
            Self::Noise => "noise",
            Self::Repel => "repel",
        }
    }
}

/// How a student is guided.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Guidance {
    mode: GuidanceMode,
    strength: f32,
}

impl Guidance {
    /// The teacher has taken over.
    pub const TAKE_OVER: Self = Self { mode: GuidanceMode::Share, strength: 1.0 };

    /// Guidance of a strength from 0 to 1, the α of [`GuidanceMode::Share`]; what is no number is 0.
    #[must_use]
    pub const fn new(mode: GuidanceMode, strength: f32) -> Self {
        let strength = if strength.is_nan() { 0.0 } else { strength.clamp(0.0, 1.0) };
        Self { mode, strength }
    }

    /// In which way.
    #[must_use]
    pub const fn mode(self) -> GuidanceMode {
        self.mode
    }

    /// How strongly, 0 to 1.
    #[must_use]
    pub const fn strength(self) -> f32 {
        self.strength
    }

    /// Share of the pressed place that is the teacher's, α.
    fn share(self) -> f32 {
        if self.mode == GuidanceMode::Share { self.strength } else { 0.0 }
    }
}

/// How a hand is being guided, to be shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guided {
    /// Where the teacher's tool is felt, m; none while nothing is heard of it.
    pub teacher_m: Option<Vec3>,
    /// How far from it the student's device is, m.
    pub error_m: f32,
    /// How much help is left of [`GuidanceMode::Lead`], 0 to 1.
    pub assistance: f32,
    /// The force by which the student is guided, N.
    pub force_n: f32,
    /// What is left to pay it with, J.
    pub stored_j: f32,
    /// How old the teacher's place is that is felt.
    pub late: Seconds,
}

/// The stage.
///
/// `F = γ·g·sat(K·e + B·(v_T − v_D))` with `e` from the device to the teacher's tool, round the axis and not through the pot,
/// `sat(F) = F/√(1 + (F/F_max)²)`, g the strength, and γ what the [`Tank`] has left. `K = min(0.4·K_device, 0.15·b/(T/2 + t_d),
/// 0.8·l/(T/2 + t_d))` with l what the coupling has left of b, and B no more than half of what both have: together they keep within the
/// bound of [`Coupling::tuned`].
///
/// While leading, g is multiplied with the assistance a, which is given as needed: `a ← f·a + (1 − f)·w(|e|)`, `f = 1 − dt/τ`, τ = 2 s.
/// That is the error-based law with a forgetting factor of Emken, Benitez and Reinkensmeyer 2007, used for haptic guidance by
/// Marchal-Crespo and Reinkensmeyer 2008; as theirs, w leaves out the error that everybody makes: it is 0 within 1 mm, 1 from 5 mm on
/// and even between.
///
/// To practise, Lee and Choi 2010 found a noise-like force better for what is retained than guidance that fades, and than a repulsive
/// one: [`GuidanceMode::Noise`] and [`GuidanceMode::Repel`], `F = −γ·g·sat(K_r·e)`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Guide {
    order: Option<Guidance>,
    /// This hand is the one that leads.
    leads: bool,
    limits: Limits,
    playout: Playout,
    tank: Tank,
    given: Given,
    noise: Noise,
    teacher: Teacher,
    /// How needed the assistance is.
    assistance: f32,
    /// α as it is now.
    share: f32,
    /// Where the device was, and where the tool was meant to be.
    device_m: Option<Vec3>,
    goal: Goal,
    force_n: Vec3,
    /// How long the tool is still lifted, s.
    lifted_s: f32,
}

/// What the device and its loop bear.
#[derive(Clone, Copy, Debug)]
struct Limits {
    force_n: f32,
    stiffness_n_m: f32,
    damping_ns_m: f32,
    leading_ns_m: f32,
    /// How far the tool gives way to the force, m/N, since the hand feels none.
    yields_m_n: f32,
}

/// Where the teacher's tool is felt, and how fast it goes.
#[derive(Clone, Copy, Debug, Default)]
struct Teacher {
    at_m: Option<Vec3>,
    velocity: VelocityEstimate,
    velocity_m_s: Vec3,
}

/// Where a tool is meant to be that two hands hold.
#[derive(Clone, Copy, Debug, Default)]
struct Goal {
    at_m: Vec3,
    velocity: VelocityEstimate,
    velocity_m_s: Vec3,
    /// What the clay gave there, N.
    force_n: Vec3,
}

impl Guide {
    /// Largest force of guidance, as a share of the device's peak; no more than it gives for as long as one likes, either.
    const FORCE_SHARE: f32 = 0.25;
    /// Fastest change of its force, N/s: all of an Omni's in 40 ms.
    const RATE_N_S: f32 = 20.0;
    /// Time constant with which help is forgotten, s, and errors that need none of it and all of it, m.
    const NEED_S: f32 = 2.0;
    const NO_NEED_M: f32 = 1e-3;
    const FULL_NEED_M: f32 = 5e-3;
    /// How long α takes from 0 to 1, s.
    const GLIDE_S: f32 = 0.4;
    /// How long the tool is away when its place ceases to be another's, s: longer than samples are joined for.
    const LIFT_S: f32 = 0.1;
    /// Stiffness by which errors are driven farther, N/m: less than the lightest hand's, which could not hold against more.
    const REPEL_N_M: f32 = 60.0;
    /// Share of the largest force that disturbs at most.
    const NOISE_SHARE: f32 = 0.8;

    /// The stage for a device whose coupling is tuned.
    pub(super) fn new(
        specs: &DeviceSpecs,
        coupling: &Coupling,
        (period, delay): (Seconds, Seconds),
        yields_m_n: f32,
    ) -> Self {
        let late_s = 0.5 * period.0 + delay.0;
        let b = specs.damping_ns_m + Coupling::HAND_NS_M;
        let left_ns_m = (b - coupling.stiffness_n_m * late_s - coupling.damping_ns_m).max(0.0);
        let bound_ns_m = (0.15 * b).min(0.8 * left_ns_m);
        let stiffness_n_m = (0.4 * specs.stiffness_max_n_m).min(Coupling::stiffness_limit(bound_ns_m, period, delay));
        let left_ns_m = left_ns_m - stiffness_n_m * late_s;
        let lasting_n = specs.continuous_force_n.unwrap_or(specs.peak_force_n);
        let limits = Limits {
            force_n: (Self::FORCE_SHARE * specs.peak_force_n).min(lasting_n),
            stiffness_n_m,
            damping_ns_m: (0.5 * left_ns_m).min(specs.damping_max_ns_m),
            leading_ns_m: Tank::LEADING_NS_M.min(0.8 * specs.damping_max_ns_m),
            yields_m_n,
        };
        Self {
            order: None,
            leads: false,
            limits,
            playout: Playout::default(),
            tank: Tank::default(),
            given: Given::default(),
            noise: Noise::default(),
            teacher: Teacher::default(),
            assistance: 1.0,
            share: 0.0,
            device_m: None,
            goal: Goal::default(),
            force_n: Vec3::ZERO,
            lifted_s: 0.0,
        }
    }

    /// Goes on with the device that another stage was made for.
    pub(super) const fn tune(&mut self, other: &Self) {
        self.limits = other.limits;
    }

    /// Begins to be guided, goes on otherwise, or ends: then the force is zero at once, and a tool that was in two hands is lifted
    /// for a moment, so that it is not drawn through the clay to where the student's hand is.
    pub(super) fn order(&mut self, order: Option<Guidance>) {
        let lifted_s = if order.is_none() && self.share > 0.0 { Self::LIFT_S } else { self.lifted_s };
        match (self.order, order) {
            (Some(_), Some(_)) => self.order = order,
            _ => {
                let (specs, leads) = (self.limits, self.leads);
                *self = Self { order, limits: specs, leads, lifted_s, ..*self };
                self.playout = Playout::default();
                self.tank = Tank::default();
                self.teacher = Teacher::default();
                self.assistance = 1.0;
                self.share = 0.0;
                self.rest();
            }
        }
    }

    /// Says that this hand leads another, or no longer.
    pub(super) const fn lead(&mut self, leads: bool) {
        self.leads = leads;
    }

    /// Takes in where the teacher's tool was at a tick.
    pub(super) fn hear(&mut self, tick: Tick, at_m: Vec3) {
        if self.order.is_some()
            && let Some((way_m, time)) = self.playout.hear(tick, at_m)
        {
            self.tank.pay_in(way_m, time);
        }
    }

    /// Goes on to the hand's tick `now`.
    pub(super) fn pass(&mut self, now: Tick, dt: Seconds) {
        let at_m = self.order.and_then(|_| self.playout.at(now));
        if let Some(at_m) = at_m {
            self.teacher.velocity_m_s = self.teacher.velocity.follow(at_m, dt);
        } else {
            if self.teacher.at_m.is_some() && self.share > 0.0 {
                // who is not heard of any more has let go
                self.lifted_s = Self::LIFT_S;
                self.share = 0.0;
            }
            self.teacher = Teacher::default();
        }
        self.teacher.at_m = at_m;
        self.lifted_s = (self.lifted_s - dt.0).max(0.0);
    }

    /// Whether the tool is lifted for a moment.
    pub(super) fn lifts(&self) -> bool {
        self.lifted_s > 0.0
    }

    /// Where the tool is meant to be while the device is at `device_m`; takes what was done on the hand since the last turn out of
    /// the account.
    pub(super) fn goal(&mut self, device_m: Vec3, dt: Seconds, delay: Seconds) -> Vec3 {
        let Some(order) = self.order else { return device_m };
        let moved_m = device_m - self.device_m.replace(device_m).unwrap_or(device_m);
        self.tank.add(-self.given.acted(dt, delay).dot(moved_m));
        let Some(teacher_m) = self.teacher.at_m else {
            self.goal.at_m = device_m;
            return device_m;
        };
        let most = dt.0 / Self::GLIDE_S;
        self.share += (order.share() - self.share).clamp(-most, most);
        if self.share == 0.0 {
            self.goal.at_m = device_m + self.force_n * self.limits.yields_m_n;
            return self.goal.at_m;
        }
        let goal_m = Around { from_m: device_m, to_m: teacher_m }.between(self.share);
        // what the teacher's part of the movement does at the clay is felt by the student: it is paid for as the rest
        let (own_m, all_m) = (moved_m * (1.0 - self.share), goal_m - self.goal.at_m);
        self.tank.add(self.goal.force_n.dot(all_m - own_m));
        self.goal.velocity_m_s = self.goal.velocity.follow(goal_m, dt);
        self.goal.at_m = goal_m;
        goal_m
    }

    /// How fast the place goes at which the tool is meant to be, m/s, for a device that goes at `device_m_s`.
    pub(super) fn goal_velocity(&self, device_m_s: Vec3) -> Vec3 {
        if self.share > 0.0 { self.goal.velocity_m_s } else { device_m_s }
    }

    /// What the hand feels of a force at the place where the tool is meant to be, and the guidance itself, N.
    pub(super) fn felt(&mut self, clay_n: Vec3, device_m_s: Vec3, dt: Seconds) -> Vec3 {
        let paid = self.tank.share();
        let clay_n = if self.share > 0.0 { clay_n * paid } else { clay_n };
        self.goal.force_n = clay_n;
        let (Some(device_m), Some(teacher_m)) = (self.device_m, self.teacher.at_m) else {
            return clay_n + self.given_for(Vec3::ZERO, device_m_s, dt);
        };
        let around = Around { from_m: device_m, to_m: teacher_m };
        let felt_n = if self.share > 0.0 { around.felt(clay_n, self.share) } else { clay_n };
        let wanted_n = self.wanted(around.error_m(), device_m_s, dt);
        felt_n + self.given_for(wanted_n, device_m_s, dt)
    }

    /// The force that is wanted, N.
    fn wanted(&mut self, error_m: Vec3, device_m_s: Vec3, dt: Seconds) -> Vec3 {
        let Some(Guidance { mode, strength }) = self.order else { return Vec3::ZERO };
        let needed = (error_m.length() - Self::NO_NEED_M) / (Self::FULL_NEED_M - Self::NO_NEED_M);
        self.assistance += (needed.clamp(0.0, 1.0) - self.assistance) * (dt.0 / Self::NEED_S).min(1.0);
        let Limits { force_n, stiffness_n_m, damping_ns_m, .. } = self.limits;
        let drawn_n = error_m * stiffness_n_m + (self.teacher.velocity_m_s - device_m_s) * damping_ns_m;
        strength
            * match mode {
                GuidanceMode::Point => Vec3::ZERO,
                GuidanceMode::Lead => saturated(drawn_n, force_n) * self.assistance,
                GuidanceMode::Share => saturated(drawn_n, force_n),
                GuidanceMode::Noise => self.noise.pass(dt) * (Self::NOISE_SHARE * force_n),
                GuidanceMode::Repel => -saturated(error_m * Self::REPEL_N_M, force_n),
            }
    }

    /// The force that is given for one that is wanted, N; who leads feels a damper.
    fn given_for(&mut self, wanted_n: Vec3, device_m_s: Vec3, dt: Seconds) -> Vec3 {
        if self.order.is_none() {
            let damped_n = device_m_s * -self.limits.leading_ns_m;
            return if self.leads { damped_n.clamp_length_max(self.limits.force_n) } else { Vec3::ZERO };
        }
        // what is paid in comes in pieces, which are not to be felt; what runs out does so at once
        let paid = self.tank.share();
        let change_n = (wanted_n * paid - self.force_n).clamp_length_max(Self::RATE_N_S * dt.0);
        self.force_n = (self.force_n + change_n).clamp_length_max(self.limits.force_n * paid);
        self.given.note(self.force_n);
        self.force_n
    }

    /// Whether the tool is pressed where the teacher's is, and nowhere else.
    pub(super) fn is_taken_over(&self) -> bool {
        self.teacher.at_m.is_some() && self.share >= 1.0
    }

    /// Share of the clay's force that the hand feels.
    pub(super) fn own_share(&self) -> f32 {
        1.0 - self.share
    }

    /// How the hand is guided, while it is.
    pub(super) fn guided(&self) -> Option<Guided> {
        self.order?;
        let apart_m = self.device_m.zip(self.teacher.at_m).map_or(0.0, |(device_m, at_m)| device_m.distance(at_m));
        Some(Guided {
            teacher_m: self.teacher.at_m,
            error_m: apart_m,
            assistance: self.assistance,
            force_n: self.force_n.length(),
            stored_j: self.tank.stored_j(),
            late: Seconds(self.playout.lag().unwrap_or(0.0) * Tick::PERIOD.0),
        })
    }

    /// Lets go of the force, since there is no tool or a fault; guidance goes on with the next one.
    pub(super) fn rest(&mut self) {
        self.device_m = None;
        self.force_n = Vec3::ZERO;
        self.given = Given::default();
        self.goal = Goal::default();
    }
}

/// The same force, but for its length, which comes near `most_n` and never to it.
fn saturated(force_n: Vec3, most_n: f32) -> Vec3 {
    let over = force_n.length_squared() / (most_n * most_n);
    if over.is_finite() { force_n / libm::sqrtf(1.0 + over) } else { Vec3::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::haptics::PRESETS;

    #[test]
    fn coupling_and_guidance_together_keep_within_what_device_and_hand_damp() {
        for preset in &PRESETS {
            for delay in [0.0, 1e-3, 5e-3, 20e-3].map(Seconds) {
                let (specs, period) = (&preset.specs, Tick::PERIOD);
                let coupling = Coupling::tuned(specs, period, delay);
                let Limits { stiffness_n_m, damping_ns_m, .. } =
                    Guide::new(specs, &coupling, (period, delay), 0.0).limits;
                let late_s = 0.5 * period.0 + delay.0;
                let asks_ns_m =
                    (coupling.stiffness_n_m + stiffness_n_m) * late_s + coupling.damping_ns_m + damping_ns_m;
                let has_ns_m = specs.damping_ns_m + Coupling::HAND_NS_M;
                assert!(stiffness_n_m > 0.0 && damping_ns_m >= 0.0, "{}, {delay:?}", preset.name);
                assert!(asks_ns_m < has_ns_m, "{}, {delay:?}: {asks_ns_m} of {has_ns_m} N·s/m", preset.name);
            }
        }
    }
}
