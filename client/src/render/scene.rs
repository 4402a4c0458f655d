//! What is to be seen besides the clay itself.
//!
//! Plain data; knows no device.

use glam::{Quat, Vec3};
use pottery_shared::clay::Phase;
use pottery_shared::tool::{ConvexTool, Side, Tool};

use super::{Camera, Deflection, Finish, Water};

/// One picture's worth of the studio.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// Where it is seen from.
    pub camera: Camera,
    /// The wheel's angle; pot and wheel head turn with it.
    pub phase: Phase,
    /// The tools of everybody at this wheel; at most [`Scene::TOOLS_MAX`] are shown.
    pub tools: &'a [ToolView],
    /// The convex tools that [`ToolView::tool`] names. One that has been shown stays under its number in later scenes.
    pub rack: &'a [ConvexTool],
    /// How the clay looks where it is wet: from 0, leather-hard, to 1, under a film of water.
    pub wetness: f32,
    /// Where it is wet and where it has dried; none for wet all over.
    pub water: Option<&'a Water>,
    /// How far its wall has given way under the tools; none for a wall that stands as its radii say.
    pub deflection: Option<&'a Deflection>,
    /// What the pot is shown as.
    pub finish: Finish,
    /// Whether the half of the pot that is nearer to the camera is cut away, to the column, so that its wall shows.
    pub is_cut: bool,
}

impl Scene<'_> {
    /// Most tools in one picture: what a person can still tell apart, and three kilobytes of uniforms.
    pub const TOOLS_MAX: usize = 64;
}

impl Default for Scene<'_> {
    /// Wet clay at rest, nobody at the wheel.
    fn default() -> Self {
        Self {
            camera: Camera::default(),
            phase: Phase::default(),
            tools: &[],
            rack: &[],
            wetness: 0.8,
            water: None,
            deflection: None,
            finish: Finish::default(),
            is_cut: false,
        }
    }
}

/// A tool as it is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToolView {
    /// Which; a convex one that is not in the scene's rack is not shown.
    pub tool: Tool,
    /// How it is turned in the room.
    pub turn: Quat,
    /// Centre in the room, m.
    pub centre_m: Vec3,
    /// Its person's colour, linear RGB from 0 to 1.
    pub colour: [f32; 3],
    /// Whether it presses into clay.
    pub touching: bool,
    /// On which side of the wall it works.
    pub side: Side,
    /// From its centre to the nearest clay, m, for the ring on the clay that tells how far it is; none shows no ring.
    pub clay_m: Option<f32>,
}
