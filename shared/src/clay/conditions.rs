//! What turns a tool's sample into a press: the wheel, the material and the method, each at its tick.
//!
//! The one conversion from the room to the pot, for server, prediction and haptics alike.
//! Invariant: the same sample under the same conditions is the same press, bit for bit.

use glam::Quat;

use super::{Material, MethodKind, Phase, Press, Schedule, Wheel};
use crate::tool::{Tool, ToolSample};
use crate::units::{Seconds, Tick};

/// Everything about a wheel that is not clay.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Conditions {
    /// The wheel's turning.
    pub wheel: Wheel,
    /// How the clay answers, over time.
    pub material: Schedule<Material>,
    /// The method that deforms it.
    pub method: MethodKind,
}

impl Conditions {
    /// The press that a sample makes, in the pot's frame at the sample's own tick; `before` is the sample that was pressed
    /// before it with the same tool, if there is one. Clay yields for a tick, also where up to three were left out between them: a hand leaves
    /// them out in the air, or where its machine stalls, and comes to the clay in the last of them (`first_contact_of_a_hand_that_rested…` in
    /// `tests/tests/haptic_loop.rs`: for all of them, 0.8 % of the elements came out a step of 4 µm apart).
    #[must_use]
    pub fn press(&self, sample: &ToolSample, before: Option<&ToolSample>) -> Press {
        let before = before.filter(|before| sample.follows(before));
        let ticks = before.map_or(1, |before| sample.tick.since(before.tick));
        let material = self.material.at(sample.tick);
        let centre_m = self.phase(sample.tick).pot_from_room(sample.centre.point_m());
        Press {
            tool: sample.tool,
            orientation: match sample.tool {
                Tool::Sphere(_) => Quat::IDENTITY,
                Tool::Convex(_) => sample.orientation.at(centre_m),
            },
            centre_m,
            from_m: before.map(|before| self.phase(before.tick).pot_from_room(before.centre.point_m())),
            dt: Seconds(Tick::PERIOD.0 * ticks as f32),
            side: sample.side,
            turning: self.wheel.rate(sample.tick).signum() as i8,
            response: material.response(Tick::PERIOD),
            strength: material.strength,
        }
    }

    /// The wheel's phase at a tick.
    #[must_use]
    pub fn phase(&self, tick: Tick) -> Phase {
        self.wheel.phase(tick)
    }
}
