//! What the server's words say about pot, settings and tools, as the core has them.
//!
//! Converts and checks; keeps nothing.
//! Invariant: what is converted is a pot, settings and places that there can be.

use super::{RemoteTool, runs};
use crate::clay::{Conditions, GridShape, Material, Method, MethodKind, Phase, Pot, PotSpec, Schedule, Support, Wheel};
use crate::protocol::{ClayWire, PotWire, ToolWire, Welcome, WheelWire};
use crate::tool::{Position, Side};
use crate::units::{Metres, Tick};

/// The untouched pot that a message describes.
pub(super) fn pot_of(pot: &PotWire, method: u8) -> Result<Pot, crate::clay::PotError> {
    Pot::new(PotSpec {
        shape: GridShape::new(pot.columns, pot.rows)?,
        height: Metres(pot.height_m),
        radius: Metres(pot.radius_m),
        wall: Metres(pot.wall_m),
        keeps_volume: MethodKind::from_number(method).keeps_volume(),
        support: Support::from_number(pot.support),
    })
}

pub(super) fn conditions_of(welcome: &Welcome) -> Conditions {
    conditions_under(MethodKind::from_number(welcome.method), &welcome.wheel, &welcome.clay)
}

/// Wheel and clay as a list of changes of each has them, earliest first.
pub(super) fn conditions_under(method: MethodKind, wheel: &[WheelWire], clay: &[(u64, ClayWire)]) -> Conditions {
    let mut conditions = Conditions { method, ..Conditions::default() };
    let mut segments = wheel.iter();
    if let Some(WheelWire { from, phase, rate }) = segments.next() {
        conditions.wheel = Wheel::starting_at(Tick(*from), Phase(*phase), *rate);
    }
    for segment in segments {
        conditions.wheel.schedule(Tick(segment.from), segment.rate);
    }
    let mut entries = clay.iter().map(|&(from, clay)| (Tick(from), Material::from(clay)));
    if let Some((_, material)) = entries.next() {
        conditions.material = Schedule::new(material);
    }
    for (from, material) in entries {
        conditions.material.set(from, material);
    }
    conditions
}

pub(super) fn remote_tool(tool: &ToolWire) -> Option<RemoteTool> {
    let ToolWire { client, touching, inside, .. } = *tool;
    let side = if inside { Side::Inside } else { Side::Outside };
    let centre = Position(tool.centre);
    let (tool, orientation) = runs::tool_of(tool.tool)?;
    centre.is_within_reach().then_some(RemoteTool { client, tool, orientation, centre, touching, side })
}
