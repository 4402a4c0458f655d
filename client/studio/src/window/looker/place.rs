//! A wheel that is looked on at, as it was seen last.
//!
//! Owns what has changed since it was drawn; the clay is the onlooker's.
//! Invariant: a tile that changed is kept until it is sent, and tiles are of the grid that is seen.

use glam::Vec2;
use pottery_client::render::{ToolView, WheelView};
use pottery_shared::clay::{GridShape, Phase, Pot, Surface};
use pottery_shared::session::{RemoteTool, Watched};
use pottery_shared::snapshot::{Detail, Touched};
use pottery_shared::units::Tick;

use crate::window::app::colour;
use crate::window::stage::Stage;
use crate::window::standing::Standing;
use crate::window::tiles::Tiles;

/// One wheel of the page as it was last looked at.
pub(super) struct Place {
    pub(super) wheel: u16,
    /// What was asked for, for its small picture.
    pub(super) asked: Detail,
    /// Tiles that were not yet sent, and the grid that they are of.
    pub(super) changed: Touched,
    shape: Option<GridShape>,
    /// Whether its pot was sent to the device.
    pub(super) is_sent: bool,
    pub(super) phase: Phase,
    pub(super) tools: Vec<RemoteTool>,
    /// How far it is from what it is to become.
    pub(super) standing: Standing,
}

impl Place {
    pub(super) fn new(wheel: u16, asked: Detail) -> Self {
        let changed = Touched::none(std::iter::empty());
        let (phase, standing) = (Phase::default(), Standing::default());
        Self { wheel, asked, changed, shape: None, is_sent: false, phase, tools: Vec::new(), standing }
    }

    /// Takes in a sight as it is now; whether its picture changes.
    pub(super) fn take_in(&mut self, sight: &mut Watched, now: Tick) -> bool {
        let shapes = || sight.pot().surfaces().iter().map(Surface::shape);
        if self.shape != shapes().next() {
            (self.changed, self.shape) = (Touched::none(shapes()), shapes().next());
        }
        sight.take_changed(&mut self.changed);
        let phase = sight.wheel().phase(now);
        let is_news = !self.changed.is_empty() || phase != self.phase || sight.tools() != self.tools;
        self.phase = phase;
        self.tools.clear();
        self.tools.extend_from_slice(sight.tools());
        is_news
    }

    /// Sends what changed of its pot to the painter of all of them; whether anything was sent.
    pub(super) fn send(&mut self, stage: &mut Stage, number: usize, pot: &Pot) -> bool {
        let Some(gallery) = stage.gallery() else { return false };
        let is_sent = std::mem::replace(&mut self.is_sent, true);
        let is_news = !is_sent || !self.changed.is_empty();
        match is_news {
            true if is_sent && gallery.fits(pot.spec()) => gallery.upload_changed(number, pot, &self.changed),
            true => gallery.upload(number, pot),
            false => {}
        }
        self.changed.clear();
        is_news
    }

    pub(super) fn view(&self, tiles: &Tiles, number: usize) -> WheelView {
        let (middle, half) = tiles.place(number);
        // a wheel that has not come yet has no size
        let half = if self.is_sent { half } else { Vec2::ZERO };
        WheelView { phase: self.phase, middle, half }
    }
}

/// Somebody else's tool, to be drawn.
pub(in crate::window) fn tool_view(tool: &RemoteTool) -> ToolView {
    let centre_m = tool.centre.point_m();
    ToolView {
        tool: tool.tool,
        turn: tool.orientation.at(centre_m),
        centre_m,
        colour: colour(tool.client),
        touching: tool.touching,
        side: tool.side,
        clay_m: None,
    }
}
