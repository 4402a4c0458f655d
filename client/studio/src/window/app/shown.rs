//! The tools of a wheel as a window drew them last, and whether a picture now would show them elsewhere.
//!
//! Owns what counts as elsewhere; draws nothing.
//! Invariant: a tool that creeps is drawn anew once it is [`SEEN_M`] from where it was drawn, however slowly it went.

use glam::Vec3;
use pottery_client::view::View;
use pottery_shared::session::RemoteTool;

/// A way that no picture shows, m: less than a pixel where the view is closest, and more than a resting hand's numbers tremble by.
const SEEN_M: f32 = 5e-6;

/// Tools as they were drawn.
#[derive(Debug, Default)]
pub(in crate::window) struct Shown {
    /// Where the own one was, m.
    pub(in crate::window) own_m: Option<Vec3>,
    others: Vec<RemoteTool>,
    /// The hand of a teacher, wherever its pot is.
    ghost: Option<RemoteTool>,
}

impl Shown {
    /// Notes that tools are drawn as they are now, the own one at a place of the room.
    pub(in crate::window) fn note(&mut self, own_m: Option<Vec3>, view: &View) {
        self.own_m = own_m;
        self.others.clear();
        self.others.extend(others(view));
        self.ghost = ghost(view);
    }

    /// Whether one would be drawn elsewhere now, or otherwise.
    pub(in crate::window) fn is_elsewhere(&self, own_m: Option<Vec3>, view: &View) -> bool {
        let is_own = match (self.own_m, own_m) {
            (Some(drawn_m), Some(own_m)) => drawn_m.distance_squared(own_m) > SEEN_M * SEEN_M,
            (drawn_m, own_m) => drawn_m.is_some() != own_m.is_some(),
        };
        is_own || self.ghost != ghost(view) || !self.others.iter().copied().eq(others(view))
    }
}

fn others(view: &View) -> impl Iterator<Item = RemoteTool> {
    view.tools.iter().copied().filter(|tool| tool.client != view.number)
}

fn ghost(view: &View) -> Option<RemoteTool> {
    view.guidance.hand.map(|hand| hand.tool)
}
