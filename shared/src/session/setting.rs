//! What is told to everybody at a wheel, as those know it who look on closely.
//!
//! Owns settings, tools and their count; presses nothing by itself.
//! Invariant: it stands as at the server after the notice of the number `told`, or nothing was heard of it yet.

use alloc::sync::Arc;

use super::welcome::conditions_under;
use super::{tool_of, with_one_more};
use crate::clay::{Conditions, GridShape, MethodKind, SubStep};
use crate::protocol::NewsOf;
use crate::tool::{ConvexTool, rack};
use crate::units::Tick;

/// What governs the clay of one wheel.
#[derive(Debug)]
pub(super) struct Setting {
    pub(super) told: u32,
    pub(super) conditions: Conditions,
    /// Presses again, and holds the rack.
    pub(super) substep: SubStep,
}

/// Takes in what was told as number `told` of a wheel with a grid of that shape; false when it makes no sense. What was known
/// already is not looked at, and neither is what comes of a wheel of which nothing was heard yet.
pub(super) fn hear(
    setting: &mut Option<Setting>,
    (told, news): (u32, NewsOf),
    (method, shape): (MethodKind, GridShape),
) -> bool {
    if let NewsOf::Standing { wheel, clay } = &news {
        let conditions = conditions_under(method, wheel, clay);
        let substep = setting.take().map_or_else(|| SubStep::for_grid(shape), |setting| setting.substep);
        let setting = setting.insert(Setting { told, conditions, substep });
        setting.substep.swap_rack(&mut rack::standard());
        return true;
    }
    let Some(setting) = setting else { return true };
    match told.wrapping_sub(setting.told) as i32 {
        ..=0 => return true,
        1 => setting.told = told,
        _ => return false,
    }
    match news {
        NewsOf::Standing { .. } => true,
        NewsOf::Wheel { from, rate } => {
            setting.conditions.wheel.schedule(Tick(from), rate);
            true
        }
        NewsOf::Clay { from, clay } => {
            setting.conditions.material.set(Tick(from), clay.into());
            true
        }
        NewsOf::Tool { shape, mesh } => {
            let rack = setting.substep.rack();
            let (true, Ok(tool)) = (usize::from(shape) == rack.len(), tool_of(&mesh)) else { return false };
            let mut rack = with_one_more(&rack, tool);
            setting.substep.swap_rack(&mut rack);
            true
        }
    }
}

impl Setting {
    /// The convex tools of the wheel, by their number.
    pub(super) fn rack(&self) -> Arc<[ConvexTool]> {
        self.substep.rack()
    }
}
