//! A haptic device in a simulated hand that means to follow a stroke and is pushed back by the clay.
//!
//! Owns the mechanics of hand and device and the time that a force takes to come; knows no clay.
//! Invariant: the state stays finite for any finite force, and nothing is allocated once it is made.

use std::sync::Arc;

use glam::Vec3;
use pottery_shared::haptics::{DeviceSpecs, Setup};
use pottery_shared::tool::{Orientation, Tool};
use pottery_shared::units::Seconds;

use super::Device;
use crate::stroke::Stroke;

/// Mass, damping and stiffness of a hand that holds a device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HandModel {
    /// Mass of hand and device, kg.
    pub mass_kg: f32,
    /// Damping, N·s/m.
    pub damping_n_s_per_m: f32,
    /// Stiffness towards where it means to be, N/m.
    pub stiffness_n_per_m: f32,
    /// Resolution of the device's encoders, m; zero for exact ones.
    pub resolution_m: f32,
}

impl Default for HandModel {
    /// The standard hand (0.195 kg, 4.1 N·s/m, 300 N/m) on a PHANToM Omni (0.055 mm).
    fn default() -> Self {
        Self { mass_kg: 0.195, damping_n_s_per_m: 4.1, stiffness_n_per_m: 300.0, resolution_m: 0.055e-3 }
    }
}

/// A hand that follows a stroke as a person does.
#[derive(Debug)]
pub struct SimulatedDevice {
    stroke: Arc<Stroke>,
    hand: HandModel,
    specs: DeviceSpecs,
    delay: Seconds,
    state: Option<State>,
    asked_s: f64,
    way: Way,
}

/// Forces on their way to the hand, and the one that has come.
#[derive(Debug)]
struct Way {
    /// When each was given, s; a ring of which `begin` is the oldest on its way and `end` where the next goes.
    given: [(f64, Vec3); Self::ROOM],
    begin: usize,
    end: usize,
    force_n: Vec3,
}

impl Way {
    /// More than are given in the longest delay at the fastest loop.
    const ROOM: usize = 256;

    const fn new() -> Self {
        Self { given: [(0.0, Vec3::ZERO); Self::ROOM], begin: 0, end: 0, force_n: Vec3::ZERO }
    }

    const fn give(&mut self, at_s: f64, force_n: Vec3) {
        if self.end - self.begin == Self::ROOM {
            self.begin += 1;
        }
        self.given[self.end % Self::ROOM] = (at_s, force_n);
        self.end += 1;
    }

    /// The last that was given at a time or before.
    fn come(&mut self, by_s: f64) -> Vec3 {
        while self.begin < self.end && self.given[self.begin % Self::ROOM].0 <= by_s {
            self.force_n = self.given[self.begin % Self::ROOM].1;
            self.begin += 1;
        }
        self.force_n
    }
}

#[derive(Clone, Copy, Debug)]
struct State {
    seconds: f64,
    position_m: Vec3,
    velocity_m_s: Vec3,
}

impl SimulatedDevice {
    /// Longest delay of a force, s.
    pub const DELAY_MAX: Seconds = Seconds(20e-3);

    /// A hand of the given kind on a PHANToM Omni that means to follow `stroke`.
    #[must_use]
    pub const fn new(stroke: Arc<Stroke>, hand: HandModel) -> Self {
        let (specs, delay) = (DeviceSpecs::OMNI, Seconds(0.0));
        Self { stroke, hand, specs, delay, state: None, asked_s: 0.0, way: Way::new() }
    }

    /// The same hand on another device, whose force comes so much later, at most [`SimulatedDevice::DELAY_MAX`].
    #[must_use]
    pub fn on(self, specs: DeviceSpecs, delay: Seconds) -> Self {
        Self { specs, delay: Seconds(delay.0.clamp(0.0, Self::DELAY_MAX.0)), ..self }
    }
}

impl Device for SimulatedDevice {
    /// `m·a = k·(x₀ − x) + b·(v₀ − v) + F`, stepped semi-implicitly in steps of at most a millisecond.
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        self.asked_s = seconds;
        let Some(meant) = self.stroke.at(seconds) else {
            self.state = None;
            return None;
        };
        let still = State { seconds, position_m: meant, velocity_m_s: Vec3::ZERO };
        let mut state = self.state.unwrap_or(still);
        let passed = (seconds - state.seconds).clamp(0.0, 0.1);
        let steps = (passed / 1e-3).ceil().max(1.0);
        let dt = (passed / steps) as f32;
        let meant_velocity = self.stroke.at(seconds - 1e-3).map_or(Vec3::ZERO, |before| (meant - before) / 1e-3);
        let since_s = seconds - passed - f64::from(self.delay.0);
        for step in 0..steps as u32 {
            // half a microsecond more, so that a force is not missed by the last bit of a time
            let force_n = self.way.come(since_s + f64::from(step) * f64::from(dt) + 5e-7);
            let pull = (meant - state.position_m) * self.hand.stiffness_n_per_m;
            let drag = (meant_velocity - state.velocity_m_s) * self.hand.damping_n_s_per_m;
            state.velocity_m_s += (pull + drag + force_n) / self.hand.mass_kg * dt;
            state.position_m += state.velocity_m_s * dt;
        }
        state.seconds = seconds;
        self.state = Some(state);
        let resolution = self.hand.resolution_m;
        let is_exact = resolution <= 0.0;
        Some(if is_exact { state.position_m } else { (state.position_m / resolution).round() * resolution })
    }

    fn tool(&self) -> Tool {
        self.stroke.tool_at(self.state.map_or_else(|| self.stroke.start(), |state| state.seconds))
    }

    /// As the stroke means it: the hand gives way to a force, and there is no torque.
    fn orientation(&self) -> Orientation {
        self.state.map_or_else(Orientation::default, |state| self.stroke.orientation_at(state.seconds))
    }

    fn set_force(&mut self, force_n: Vec3) {
        self.way.give(self.asked_s, force_n);
    }

    fn specs(&self) -> DeviceSpecs {
        self.specs
    }

    fn setup(&self, share_of_small: f32) -> Setup {
        Setup { delay: self.delay, ..Setup::for_device(self.specs, share_of_small) }
    }
}
