//! A hand that follows a stroke exactly, whatever it feels.
//!
//! Invariant: the same stroke gives the same positions at the same seconds.

use std::sync::Arc;

use glam::Vec3;
use pottery_shared::haptics::{DeviceSpecs, Setup, Stages};
use pottery_shared::tool::{Orientation, Tool};

use super::Device;
use crate::stroke::Stroke;

/// Plays a stroke once.
#[derive(Debug)]
pub struct ScriptedDevice {
    stroke: Arc<Stroke>,
    asked_s: f64,
}

impl ScriptedDevice {
    /// A hand that will play `stroke`.
    #[must_use]
    pub const fn new(stroke: Arc<Stroke>) -> Self {
        Self { stroke, asked_s: 0.0 }
    }
}

impl Device for ScriptedDevice {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        self.asked_s = seconds;
        self.stroke.at(seconds)
    }

    fn tool(&self) -> Tool {
        self.stroke.tool_at(self.asked_s)
    }

    fn orientation(&self) -> Orientation {
        self.stroke.orientation_at(self.asked_s)
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }

    /// Presses exactly where the stroke says.
    fn setup(&self, share_of_small: f32) -> Setup {
        Setup { stages: Stages::EXACT, ..Setup::for_device(self.specs(), share_of_small) }
    }
}
