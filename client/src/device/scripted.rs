//! A hand that follows a stroke exactly, whatever it feels.
//!
//! Invariant: the same stroke gives the same positions at the same seconds.

use std::sync::Arc;

use glam::Vec3;
use pottery_shared::haptics::DeviceSpecs;
use pottery_shared::tool::Sphere;

use super::Device;
use crate::stroke::Stroke;

/// Plays a stroke once.
#[derive(Debug)]
pub struct ScriptedDevice {
    stroke: Arc<Stroke>,
}

impl ScriptedDevice {
    /// A hand that will play `stroke`.
    #[must_use]
    pub const fn new(stroke: Arc<Stroke>) -> Self {
        Self { stroke }
    }
}

impl Device for ScriptedDevice {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        self.stroke.at(seconds)
    }

    fn tool(&self) -> Sphere {
        self.stroke.tool()
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }
}
