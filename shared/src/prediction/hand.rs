//! The clay beside the device, pressed at 1 kHz.
//!
//! Allocates nothing and waits for nothing. A correction arrives as a whole [`Patch`] of somewhat older clay; the hand
//! replays its own latest samples on it, a few each tick, while it goes on feeling the clay it has, and changes over
//! once the patch has caught up. So the work of a tick is bounded whatever the network does.
//! Invariant: `recent` holds the hand's latest samples in ascending order of tick.

use alloc::sync::Arc;

use glam::Vec3;

use crate::clay::{Conditions, Contact, GridShape, Material, MethodKind, SubStep};
use crate::tool::{ConvexTool, Position, Side, Tool, ToolSample};
use crate::units::Tick;

use super::{Field, ground};

/// Clay as the predictor last knew it, handed to the device's thread.
#[derive(Clone, Debug)]
pub struct Patch {
    /// The clay and how far it goes.
    pub field: Field,
    /// Wheel, material and method.
    pub conditions: Conditions,
    /// The convex tools that may be pressed with; they only become more.
    pub rack: Arc<[ConvexTool]>,
}

/// Samples the hand can replay: a quarter of a second.
const RECENT: usize = 256;

/// The clay that the hand feels.
#[derive(Debug)]
pub struct Hand {
    field: Field,
    conditions: Conditions,
    substep: SubStep,
    /// A ring; `recorded` counts all samples put in since the session began.
    recent: [Option<ToolSample>; RECENT],
    recorded: usize,
    /// On which side of the wall the tool works, while there is one.
    side: Option<Side>,
    /// With which tool it stood where last, since it was taken up.
    stood: Option<(Tool, Side, Position)>,
}

impl Hand {
    /// A hand on the given clay.
    #[must_use]
    pub fn new(patch: Patch) -> Self {
        let largest = patch.field.pot().surfaces().iter().map(crate::clay::Surface::shape).max_by_key(|s| s.elements());
        let shape = largest.unwrap_or(GridShape::PAPER);
        let presses = if patch.field.bends() { 1 + Field::BESIDE_MAX } else { 1 };
        let substep = SubStep::with_rack(shape, patch.rack).with_room(shape, presses);
        Self {
            field: patch.field,
            conditions: patch.conditions,
            substep,
            recent: [None; RECENT],
            recorded: 0,
            side: None,
            stood: None,
        }
    }

    /// The clay it feels.
    #[must_use]
    pub const fn field(&self) -> &Field {
        &self.field
    }

    /// The method by which the clay answers.
    #[must_use]
    pub const fn method(&self) -> MethodKind {
        self.conditions.method
    }

    /// The side of the wall on which the tool works at a place of the room: where it first stood, until it went over the
    /// rim.
    pub fn side(&mut self, tick: Tick, tool: Tool, centre: Position) -> Side {
        let at_m = self.conditions.phase(tick).pot_from_room(centre.point_m());
        let reach_m = self.reach_m(tool);
        let pot = self.field.pot();
        let kept = self.side.filter(|_| !pot.is_above_rim(at_m - Vec3::Z * reach_m));
        *self.side.insert(kept.unwrap_or_else(|| pot.side_of(at_m)))
    }

    /// The side on which the tool worked last, while there is one.
    #[must_use]
    pub const fn worked_side(&self) -> Option<Side> {
        self.side
    }

    /// Whether it can press with a tool: any sphere, and the convex ones that have come to it.
    #[must_use]
    pub fn holds(&self, tool: Tool) -> bool {
        self.substep.reach(tool).is_some()
    }

    /// Forgets where and on which side the tool was, since there is none.
    pub const fn put_down(&mut self) {
        (self.side, self.stood) = (None, None);
    }

    /// Forgets what was pressed, for clay of a server that knows nothing of it and may count from less.
    pub fn begin_session(&mut self) {
        self.recent.fill(None);
        self.recorded = 0;
    }

    /// Where a tool on its way to `to` first meets clay, or that place itself: a fast tool is stopped at the clay, so that no
    /// wall is passed within a tick. How far a convex tool reaches depends on how it is turned: it is asked what it would feel.
    #[must_use]
    pub fn stopped_at_clay(&mut self, sample: &ToolSample) -> Position {
        let ToolSample { tick, tool, side, centre: to, .. } = *sample;
        let stood = self.stood.replace((tool, side, to)).filter(|stood| (stood.0, stood.1) == (tool, side));
        let Some((_, _, from)) = stood else { return to };
        let at = |share| Position::nearest(from.point_m().lerp(to.point_m(), share)).unwrap_or(to);
        let share = match tool.sphere() {
            Some(sphere) => {
                let [from_m, to_m] = [from, to].map(|place| self.conditions.phase(tick).pot_from_room(place.point_m()));
                let way = ground::Way { from_m, to_m, radius_m: sphere.radius().0, side };
                way.free_share(self.field.pot())
            }
            None => ground::free_share(from.point_m().distance(to.point_m()), ground::FACETS_LOOK_M, |share| {
                self.feel(&ToolSample { centre: at(share), ..*sample }).elements > 0
            }),
        };
        if share >= 1.0 {
            return to;
        }
        let stopped = at(share);
        self.stood = Some((tool, side, stopped));
        stopped
    }

    /// How fast the clay under a tool goes by in the room, m/s, the area of one of its elements, m², and what it is made of.
    #[must_use]
    pub fn ground(&self, sample: &ToolSample) -> (Vec3, f32, Material) {
        let (tick, at_m) = (sample.tick, sample.centre.point_m());
        let surface = &self.field.pot().surfaces()[0];
        let velocity_m_s = Vec3::Z.cross(at_m) * self.conditions.wheel.rate_rad_s(tick);
        let element_m2 = ground::element_m2(surface, at_m, self.reach_m(sample.tool), sample.side);
        (velocity_m_s, element_m2, self.conditions.material.at(tick))
    }

    /// Whether the clay that was felt until `patch` was taken over is another under the tool than that which is felt now, or held by others
    /// elsewhere.
    #[must_use]
    pub fn is_corrected_since(&self, patch: &Patch) -> bool {
        let Some(last) = self.last() else { return false };
        let at_m = self.conditions.phase(last.tick).pot_from_room(last.centre.point_m());
        self.conditions != patch.conditions
            || self.field.beside() != patch.field.beside()
            || ground::differs(self.field.pot(), patch.field.pot(), at_m, self.reach_m(last.tool))
    }

    /// How far a tool reaches from its centre, m.
    fn reach_m(&self, tool: Tool) -> f32 {
        self.substep.reach(tool).map_or(0.0, |reach| reach.0)
    }

    fn last(&self) -> Option<&ToolSample> {
        self.recent[self.recorded.checked_sub(1)? % RECENT].as_ref()
    }

    /// Presses one sample; the contact's force is in the room's frame.
    pub fn press(&mut self, sample: &ToolSample) -> Contact {
        let mut contact = self.field.press(sample, &self.conditions, &mut self.substep, None);
        contact.force_n = self.conditions.phase(sample.tick).room_from_pot(contact.force_n);
        self.recent[self.recorded % RECENT] = Some(*sample);
        self.recorded += 1;
        contact
    }

    /// What the clay opposes to a sample between two ticks, room's frame; it is moved by none of them.
    pub fn feel(&mut self, sample: &ToolSample) -> Contact {
        let mut contact = self.field.feel(sample, &self.conditions, &mut self.substep);
        contact.force_n = self.conditions.phase(sample.tick).room_from_pot(contact.force_n);
        contact
    }

    /// Replays up to `budget` of the latest samples on `patch`; true once it has caught up and was taken over.
    ///
    /// The clay felt until then is left in `patch`.
    pub fn catch_up(&mut self, patch: &mut Patch, budget: usize) -> bool {
        let through = patch.field.through();
        let oldest = self.recorded.saturating_sub(RECENT);
        let missing = (oldest..self.recorded)
            .filter_map(|at| self.recent[at % RECENT].as_ref())
            .filter(|sample| sample.tick > through);
        for (done, sample) in missing.enumerate() {
            if done == budget {
                return false;
            }
            patch.field.press(sample, &patch.conditions, &mut self.substep, None);
        }
        core::mem::swap(&mut self.field, &mut patch.field);
        core::mem::swap(&mut self.conditions, &mut patch.conditions);
        self.substep.swap_rack(&mut patch.rack);
        true
    }
}
