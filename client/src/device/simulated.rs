//! A haptic device in a simulated hand that means to follow a stroke and is pushed back by the clay.
//!
//! Owns the mechanics of hand and device; knows no clay.
//! Invariant: the state stays finite for any finite force.

use std::sync::Arc;

use glam::Vec3;
use pottery_shared::haptics::DeviceSpecs;
use pottery_shared::tool::{Orientation, Tool};

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
    /// Resolution of the device's encoders, m.
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
    state: Option<State>,
    force_n: Vec3,
}

#[derive(Clone, Copy, Debug)]
struct State {
    seconds: f64,
    position_m: Vec3,
    velocity_m_s: Vec3,
}

impl SimulatedDevice {
    /// A hand of the given kind that means to follow `stroke`.
    #[must_use]
    pub const fn new(stroke: Arc<Stroke>, hand: HandModel) -> Self {
        Self { stroke, hand, state: None, force_n: Vec3::ZERO }
    }
}

impl Device for SimulatedDevice {
    /// `m·a = k·(x₀ − x) + b·(v₀ − v) + F`, stepped semi-implicitly in steps of at most a millisecond.
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
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
        for _ in 0..steps as u32 {
            let pull = (meant - state.position_m) * self.hand.stiffness_n_per_m;
            let drag = (meant_velocity - state.velocity_m_s) * self.hand.damping_n_s_per_m;
            state.velocity_m_s += (pull + drag + self.force_n) / self.hand.mass_kg * dt;
            state.position_m += state.velocity_m_s * dt;
        }
        state.seconds = seconds;
        self.state = Some(state);
        let resolution = self.hand.resolution_m;
        Some((state.position_m / resolution).round() * resolution)
    }

    fn tool(&self) -> Tool {
        self.stroke.tool_at(self.state.map_or_else(|| self.stroke.start(), |state| state.seconds))
    }

    /// As the stroke means it: the hand gives way to a force, and there is no torque.
    fn orientation(&self) -> Orientation {
        self.state.map_or_else(Orientation::default, |state| self.stroke.orientation_at(state.seconds))
    }

    fn set_force(&mut self, force_n: Vec3) {
        self.force_n = force_n;
    }

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }
}
