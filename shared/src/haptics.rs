//! From what the clay answers to what the hand feels, one tick at a time.
//!
//! Knows no network, no clock and no device; reads the clay's answer, never changes clay. The stages in their order, forces in N,
//! places in m, room's frame throughout:
//!
//! | stage | what it does | source |
//! |---|---|---|
//! | check | a place that is no number, out of reach or a jump: no force until 100 ticks were sound | chosen |
//! | steps | the device is taken to be where it was within half a step of its encoders | chosen |
//! | velocity | from places, if the device measures none, 2 ms late ([`VelocityEstimate`]) | chosen |
//! | proxy | what presses the clay; one Newton step a tick towards balance | Ruspini, Kolarov and Khatib 1997 |
//! | clay | the caller presses the proxy and says what the clay answered ([`Touch`]) | `clay` |
//! | scale | `s·F`, so that a small device works clay that needs more ([`Setup::felt_share`]) | chosen: 3.3 N against the 17 N of a deep dent |
//! | drag | friction along wet clay, by slip ([`Wet`]) | Kikuuwe and others 2006; Locat and Demers 1988 |
//! | coupling | `K·(x_p − x_d) + B·(v_p − v_d)` ([`Coupling`]) | Colgate, Stanley and Brown 1995; Colgate and Schenkel 1997 |
//! | correction | what corrected clay changes comes at 2 to 20 N/s: in 20 ms, with a step of the encoders, no more than a hand tells apart | force limen of 7 to 10 % |
//! | guidance | a teacher's hand on this one ([`Guidance`]) | Emken, Benitez and Reinkensmeyer 2007; Lee and Choi 2010 |
//! | passivity | observer and controller, with the delay accounted for; what it damped by goes at 50 N/s | Hannaford and Ryu 2002 |
//! | ramp | for 0.1 s after a pause, and until it is there, the force comes at 100 N/s | chosen |
//! | limit | no longer than the device's peak, direction kept | the device |
//!
//! Invariant: the force it returns is finite and no longer than the device's limit, whatever came in.

mod coupling;
mod drag;
mod ease;
mod gate;
mod given;
mod guidance;
mod passivity;
mod proxy;
mod specs;
mod velocity;

use glam::Vec3;

use crate::tool::Position;
use crate::units::{Seconds, Tick};
pub use coupling::Coupling;
pub use drag::Wet;
pub use gate::Fault;
pub use guidance::{Guidance, GuidanceMode, Guided};
pub use proxy::Touch;
pub use specs::{DevicePreset, DeviceSpecs, PRESETS, SpecsError};
pub use velocity::VelocityEstimate;

use ease::{Correction, Ramp};
use gate::Gate;
use guidance::Guide;
use passivity::Passivity;
use proxy::Proxy;

/// Which stages are on; check, steps, velocity, scale, limit and gate always are. What each is for shows
/// `accuracy-chart stability --without`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stages {
    /// A proxy on a coupling presses the clay; without it the device does, and feels the clay itself.
    pub proxy: bool,
    /// The proxy is dragged along by clay that goes by.
    pub drag: bool,
    /// A teacher's hand is felt.
    pub guidance: bool,
    /// Passivity observer and controller.
    pub passivity: bool,
    /// Corrected clay is blended in.
    pub correction: bool,
    /// The force comes slowly after a pause.
    pub ramp: bool,
    /// A low-pass on the force at so many Hz, as the original program had; for study only, since it costs stable stiffness.
    pub low_pass_hz: Option<f32>,
}

impl Stages {
    /// All of them, as the studio runs.
    pub const WHOLE: Self = Self {
        proxy: true,
        drag: true,
        guidance: true,
        passivity: true,
        correction: true,
        ramp: true,
        low_pass_hz: None,
    };
    /// None: the tool is pressed exactly where the device says and the clay's own force is felt.
    pub const EXACT: Self = Self {
        proxy: false,
        drag: false,
        guidance: false,
        passivity: false,
        correction: false,
        ramp: false,
        low_pass_hz: None,
    };
    /// As the original program rendered: the method's force through a filter of 10 Hz.
    pub const ORIGINAL: Self = Self { low_pass_hz: Some(10.0), ..Self::EXACT };
}

/// What the chain is set up for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setup {
    /// What the device can render.
    pub specs: DeviceSpecs,
    /// Which stages are on.
    pub stages: Stages,
    /// Force to feel for each newton of the clay's.
    pub felt_share: f32,
    /// The coupling; tuned from the specs when there is none.
    pub coupling: Option<Coupling>,
    /// Delay between a place and the force that answers it, beyond the loop's own period.
    pub delay: Seconds,
    /// The loop's period, for which the coupling is tuned.
    pub period: Seconds,
    /// How far the tool gives way to a teacher's force, m/N, in a hand that feels none: zero for a device that gives it.
    pub yields_m_n: f32,
}

impl Setup {
    /// The whole chain for a device, with the method's share for a small device (see [`crate::clay::MethodKind::felt_share`]).
    ///
    /// `s = min(1, share·peak/3.3 N)`: a device that gives more force feels more of the clay's, so that all of them press
    /// equally deep.
    #[must_use]
    pub fn for_device(specs: DeviceSpecs, share_of_small: f32) -> Self {
        let felt_share = (share_of_small * specs.peak_force_n / DeviceSpecs::OMNI.peak_force_n).min(1.0);
        let (stages, delay, period) = (Stages::WHOLE, Seconds(0.0), Tick::PERIOD);
        Self { specs, stages, felt_share, coupling: None, delay, period, yields_m_n: 0.0 }
    }
}

/// The chain between device and clay.
#[derive(Clone, Copy, Debug)]
pub struct Haptics {
    specs: Result<DeviceSpecs, SpecsError>,
    stages: Stages,
    felt_share: f32,
    coupling: Coupling,
    delay: Seconds,
    gate: Gate,
    proxy: Proxy,
    guide: Guide,
    passivity: Passivity,
    correction: Correction,
    ramp: Ramp,
    filtered_n: Vec3,
    device: Motion,
    /// Where the tool is meant to be: where the device is, unless a teacher holds it as well.
    goal_m: Vec3,
    followed: VelocityEstimate,
    dt: Seconds,
}

/// How the device moved in the tick.
#[derive(Clone, Copy, Debug, Default)]
struct Motion {
    at_m: Option<Vec3>,
    steady_m: Option<Vec3>,
    moved_m: Vec3,
    /// As the device measures it, or as estimated; and as estimated anyway.
    velocity_m_s: Vec3,
    estimated_m_s: Vec3,
    estimate: VelocityEstimate,
}

impl Haptics {
    /// Farthest that counts as a movement within a millisecond, m: 5 m/s.
    pub const JUMP_M: f32 = Gate::SPEED_MAX_M_S * Tick::PERIOD.0;
    /// Ticks in which a driver that hears of no force takes it for gone, and gives none until it hears of one again.
    pub const SILENCE_TICKS: u16 = 50;
    /// Sound ticks after which a fault is over.
    pub const RECOVERY_TICKS: u32 = Gate::RECOVERY_TICKS;

    /// The chain for a device; the force stays off when its specs make no sense.
    #[must_use]
    pub fn new(setup: Setup) -> Self {
        let Setup { specs, stages, felt_share, coupling, delay, period, yields_m_n } = setup;
        let coupling = coupling.unwrap_or_else(|| Coupling::tuned(&specs, period, delay));
        Self {
            specs: specs.checked(),
            stages,
            felt_share,
            coupling,
            delay,
            gate: Gate::default(),
            proxy: Proxy::default(),
            guide: Guide::new(&specs, &coupling, (period, delay), yields_m_n),
            passivity: Passivity::default(),
            correction: Correction::beside_steps_of(coupling.stiffness_n_m * specs.resolution_m),
            ramp: Ramp::default(),
            filtered_n: Vec3::ZERO,
            device: Motion::default(),
            goal_m: Vec3::ZERO,
            followed: VelocityEstimate::default(),
            dt: Tick::PERIOD,
        }
    }

    /// Goes on with another device: the chain is tuned to it and begins at rest, so that the force comes by the ramp. Guidance and a fault
    /// last.
    pub fn set_up(&mut self, setup: Setup) {
        let Self { gate, mut guide, .. } = *self;
        let fresh = Self::new(setup);
        guide.tune(&fresh.guide);
        *self = Self { gate, guide, ..fresh };
        self.rest();
    }

    /// The fault that keeps the force off, if any.
    #[must_use]
    pub const fn fault(&self) -> Option<Fault> {
        if self.specs.is_err() { Some(Fault::Specs) } else { self.gate.fault() }
    }

    /// Which stages are on.
    #[must_use]
    pub const fn stages(&self) -> Stages {
        self.stages
    }

    /// The coupling in use.
    #[must_use]
    pub const fn coupling(&self) -> Coupling {
        self.coupling
    }

    /// Takes what the device reported, m and m/s, `dt` after its last report, and says where to press; `None` when there is nothing
    /// to press with in this tick.
    pub fn accept(&mut self, reported_m: Option<Vec3>, velocity_m_s: Option<Vec3>, dt: Seconds) -> Option<Position> {
        self.dt = if dt.0 > 0.0 { dt } else { Tick::PERIOD };
        let device_m = self.gate.check(reported_m, self.dt);
        let (Some(device_m), Ok(specs)) = (device_m, self.specs) else {
            self.rest();
            return None;
        };
        self.device.follow(device_m, specs.resolution_m, velocity_m_s, self.dt);
        if self.guide.lifts() {
            self.proxy.forget();
            self.withhold();
            return None;
        }
        let goal_m = self.guide.goal(device_m, self.dt, self.delay);
        self.goal_m = goal_m;
        let at_m = if self.stages.proxy {
            self.proxy.follow(goal_m, &self.coupling, specs.peak_force_n, self.dt)
        } else {
            goal_m
        };
        Position::nearest(at_m)
    }

    /// Begins to be guided by a teacher, goes on in another way, or ends; without the stage nothing comes of it.
    pub fn guide(&mut self, guidance: Option<Guidance>) {
        self.guide.order(guidance.filter(|_| self.stages.guidance));
        if guidance.is_none() {
            // what it owes for guidance is not to be felt afterwards
            self.passivity.forget();
        }
    }

    /// Says that this hand leads another, or no longer: it then feels the damper that pays for what the other feels.
    pub const fn lead(&mut self, leads: bool) {
        self.guide.lead(leads && self.stages.guidance);
    }

    /// Takes in where the teacher's tool was at a tick, m; late, lost and in any order, and whatever is no place is left out.
    pub fn hear_teacher(&mut self, tick: Tick, at_m: Vec3) {
        self.guide.hear(tick, at_m);
    }

    /// Goes on to the hand's own tick `now`, `dt` after the last turn, before [`Haptics::accept`].
    pub fn follow_teacher(&mut self, now: Tick, dt: Seconds) {
        self.guide.pass(now, dt);
    }

    /// How this hand is guided, while it is.
    #[must_use]
    pub fn guided(&self) -> Option<Guided> {
        self.guide.guided()
    }

    /// Whether the tool is pressed where the teacher's is, and nowhere else: it is then the teacher's tool that presses.
    #[must_use]
    pub fn is_taken_over(&self) -> bool {
        self.guide.is_taken_over()
    }

    /// Where the tool is that presses the clay, m: what is to be drawn. `None` while there is none.
    #[must_use]
    pub fn tool_m(&self) -> Option<Vec3> {
        if self.stages.proxy { self.proxy.at_m() } else { self.device.at_m }
    }

    /// Says that the clay under the tool was corrected since the last tick.
    pub const fn clay_corrected(&mut self) {
        if self.stages.correction {
            self.correction.begin();
        }
    }

    /// The force to give to the device for what the clay answered; zero while a fault lasts.
    pub fn render(&mut self, touch: &Touch) -> Vec3 {
        if !(touch.force_n.is_finite() && touch.penetration_m.is_finite()) {
            self.gate.fail(Fault::Force);
        }
        let (Ok(specs), None, Some(_)) = (self.specs, self.gate.fault(), self.device.at_m) else {
            self.rest();
            return Vec3::ZERO;
        };
        let coupled_n = self.coupled(touch).clamp_length_max(specs.peak_force_n);
        let mut clay_n = self.filter(coupled_n);
        if self.stages.correction {
            let moved_n = self.device.moved_m * self.coupling.stiffness_n_m;
            clay_n = self.correction.blend(clay_n, self.proxy.normal(), moved_n, self.dt);
        }
        let mut force_n = self.guide.felt(clay_n, self.device.estimated_m_s, self.dt);
        let model_n = force_n + (coupled_n - clay_n) * self.guide.own_share();
        if self.stages.passivity {
            let damping = (specs.damping_ns_m, specs.damping_max_ns_m);
            force_n += self.passivity.control(model_n, self.device.estimated_m_s, (self.dt, self.delay), damping);
        }
        if self.stages.ramp {
            force_n = self.ramp.ease(force_n, self.dt);
        }
        force_n = force_n.clamp_length_max(specs.peak_force_n);
        self.passivity.note(force_n);
        force_n
    }

    /// The coupling's force, or the clay's own where there is no proxy.
    fn coupled(&mut self, touch: &Touch) -> Vec3 {
        if !self.stages.proxy {
            return touch.force_n * self.felt_share;
        }
        let wet = touch.wet.filter(|_| self.stages.drag);
        self.proxy.meet(&Touch { wet, ..*touch }, self.felt_share);
        let goal_m = self.goal_m;
        let at_m = self.proxy.at_m().unwrap_or(goal_m);
        let goal_m_s = self.guide.goal_velocity(self.device.velocity_m_s);
        let velocity_m_s = self.followed.follow(at_m, self.dt) - goal_m_s;
        let Coupling { stiffness_n_m, damping_ns_m } = self.coupling;
        let is_touching = touch.force_n != Vec3::ZERO;
        if !is_touching && self.proxy.is_free(&self.coupling) {
            // stopped before clay that it does not touch: there is nothing to feel
            return Vec3::ZERO;
        }
        (at_m - goal_m) * stiffness_n_m + velocity_m_s * if is_touching { damping_ns_m } else { 0.0 }
    }

    fn filter(&mut self, force_n: Vec3) -> Vec3 {
        let Some(cut_hz) = self.stages.low_pass_hz else { return force_n };
        let share = 1.0 - libm::expf(-core::f32::consts::TAU * cut_hz * self.dt.0);
        self.filtered_n += (force_n - self.filtered_n) * share;
        self.filtered_n
    }

    /// Notes that the force was not given, since the person wants none: the proxy goes on working the clay, and the force comes back
    /// by the ramp.
    pub fn withhold(&mut self) {
        self.guide.rest();
        self.passivity.forget();
        self.correction.forget();
        self.ramp.forget();
        self.filtered_n = Vec3::ZERO;
    }

    /// Lets go of everything, since there is no tool or a fault.
    pub fn rest(&mut self) {
        self.device = Motion::default();
        self.followed.forget();
        self.proxy.forget();
        self.withhold();
    }
}

/// Whether a hand goes so fast: what is no number, and faster than a place is heard of, is the device's mistake.
fn is_a_hands(velocity_m_s: &Vec3) -> bool {
    velocity_m_s.length() <= Gate::SPEED_MAX_M_S
}

impl Motion {
    /// Goes where the device is. How fast is reckoned from where it is to within half a step of its encoders: one that rests
    /// between two of them reports both in turn, which is no movement.
    fn follow(&mut self, at_m: Vec3, step_m: f32, measured_m_s: Option<Vec3>, dt: Seconds) {
        let before_m = self.at_m.replace(at_m).unwrap_or(at_m);
        self.moved_m = at_m - before_m;
        let half = Vec3::splat(0.5 * step_m);
        self.steady_m = self.steady_m.unwrap_or(at_m).clamp(at_m - half, at_m + half).into();
        let at_m = self.steady_m.unwrap_or(at_m);
        self.estimated_m_s = self.estimate.follow(at_m, dt);
        self.velocity_m_s = measured_m_s.filter(is_a_hands).unwrap_or(self.estimated_m_s);
    }
}
