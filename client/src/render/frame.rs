//! What the shaders are told: the frame and the skins, byte for byte as the WGSL declares them.
//!
//! Knows no device.

use bytemuck::{Pod, Zeroable};
use pottery_shared::clay::{GridShape, Pot, Skin, Surface};
use pottery_shared::tool::Tool;

use super::finish::FinishUniform;
use super::mesh::Stride;
use super::scene::{Scene, ToolView};

/// Heights at which the pot's outline is known to the light.
pub(super) const OUTLINE: usize = 8;
/// Half the width over which a hollow is looked for, m: a fingertip's groove.
const HOLLOW_REACH_M: f32 = 0.0025;
/// Radius of an opening that shades nothing, m.
const CUT_OPEN_M: f32 = 10.0;
/// Radius at which that reach is counted in columns, m.
const USUAL_RADIUS_M: f32 = 0.06;

/// `struct Tool` of `frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct ToolUniform {
    centre_m: [f32; 3],
    radius_m: f32,
    colour: [f32; 3],
    /// 1 while it touches; less than 0 while it does not: minus the distance from its centre to the clay, m; 0 when that is not told.
    touching: f32,
    turn: [f32; 4],
}

/// The tools of a scene that can be shown, spheres first and then each shape of the rack by itself.
pub(super) fn shown<'a>(scene: &Scene<'a>) -> Vec<&'a ToolView> {
    let is_known = |tool: Tool| tool.shape().is_none_or(|shape| usize::from(shape.0) < scene.rack.len());
    let can_be_shown = |view: &&ToolView| view.centre_m.is_finite() && view.turn.is_finite() && is_known(view.tool);
    let mut shown: Vec<_> = scene.tools.iter().filter(can_be_shown).take(Scene::TOOLS_MAX).collect();
    shown.sort_by_key(|view| view.tool.shape().map(|shape| shape.0));
    shown
}

/// Radius of a sphere, and of one with the volume of a tool of facets, as whose the light sees it; m.
fn radius_m(scene: &Scene<'_>, tool: Tool) -> f32 {
    match tool {
        Tool::Sphere(sphere) => sphere.radius().0,
        Tool::Convex(shape) => {
            let volume_m3 = scene.rack.get(usize::from(shape.0)).map_or(0.0, |tool| tool.volume_m3());
            (volume_m3 * 0.75 / std::f32::consts::PI).cbrt()
        }
    }
}

/// `struct Frame` of `frame.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct FrameUniform {
    clip_from_room: [f32; 16],
    camera_m: [f32; 3],
    wetness: f32,
    wheel: [f32; 2],
    encodes: f32,
    aspect: f32,
    pot_height_m: f32,
    rim_inner_m: f32,
    foot_m: f32,
    tools: u32,
    outline_m: [f32; OUTLINE],
    finish: FinishUniform,
    tool: [ToolUniform; Scene::TOOLS_MAX],
}

/// `struct Skin` of `transform.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub(super) struct SkinUniform {
    columns: u32,
    rows: u32,
    first_row: u32,
    column_stride: u32,
    row_stride: u32,
    facing: f32,
    inset_m: f32,
    row_height_m: f32,
    reach_columns: u32,
    reach_rows: u32,
    first_column: u32,
    deflects: u32,
}

impl SkinUniform {
    pub(super) fn new(shape: GridShape, row_height_m: f32, skin: Skin, first_row: u32, stride: Stride) -> Self {
        let reach = |element_m: f32| (HOLLOW_REACH_M / element_m).round().clamp(1.0, 64.0) as u32;
        Self {
            columns: shape.columns(),
            rows: shape.rows(),
            first_row,
            column_stride: stride.columns,
            row_stride: stride.rows,
            facing: if skin.faces_outwards { 1.0 } else { -1.0 },
            inset_m: skin.inset_m,
            row_height_m,
            reach_columns: reach(shape.column_angle_rad() * USUAL_RADIUS_M).min(shape.columns() / 4),
            reach_rows: reach(row_height_m).min(shape.rows() - 1),
            first_column: 0,
            deflects: 0,
        }
    }

    /// The same for radii that stand behind others in their texture.
    pub(super) const fn beginning_at(self, first_column: u32) -> Self {
        Self { first_column, ..self }
    }

    /// The same for a wall that is drawn as it has given way.
    pub(super) fn deflecting(self, deflects: bool) -> Self {
        Self { deflects: u32::from(deflects), ..self }
    }

    /// Elements (columns, rows) round a changed one whose light changes with it.
    pub(super) const fn reach(&self) -> (u32, u32) {
        (self.reach_columns, self.reach_rows)
    }
}

/// The first row that belongs to a skin: an inner wall starts where the floor lies.
pub(super) fn first_row(pot: &Pot, skin: Skin) -> u32 {
    let surface = &pot.surfaces()[skin.surface];
    let rows = surface.shape().rows();
    if skin.faces_outwards {
        return 0;
    }
    let floor_m = pot.spec().wall.0;
    (0..rows).find(|&row| surface.row_z_m(row) >= floor_m).unwrap_or(1).clamp(1, rows - 2)
}

/// The pot as the light knows it: a body of revolution.
#[derive(Clone, Copy, Debug)]
pub(super) struct Outline {
    height_m: f32,
    radii_m: [f32; OUTLINE],
    foot_m: f32,
    rim_inner_m: f32,
}

impl Outline {
    /// Columns that the mean radius is taken over.
    const COLUMNS: u32 = 48;

    pub(super) fn of(pot: &Pot) -> Self {
        let skins = pot.skins();
        let outer = &pot.surfaces()[skins[0].surface];
        let inner = skins.iter().rev().find(|skin| !skin.faces_outwards).unwrap_or(&skins[0]);
        let rows = outer.shape().rows();
        let mut radii_m = [0.0; OUTLINE];
        for (at, radius_m) in radii_m.iter_mut().enumerate() {
            *radius_m = Self::mean_m(outer, (at as u32 + 1) * (rows - 1) / OUTLINE as u32);
        }
        let inner_surface = &pot.surfaces()[inner.surface];
        Self {
            height_m: outer.height_m(),
            radii_m,
            foot_m: Self::mean_m(outer, 0),
            rim_inner_m: (Self::mean_m(inner_surface, inner_surface.shape().rows() - 1) - inner.inset_m).max(1e-3),
        }
    }

    fn mean_m(surface: &Surface, row: u32) -> f32 {
        let columns = surface.shape().columns();
        let step = columns.div_ceil(Self::COLUMNS);
        let radii = (0..columns).step_by(step as usize).map(|column| surface.column_m(column)[row as usize]);
        let count = radii.len() as f32;
        radii.sum::<f32>() / count
    }
}

impl FrameUniform {
    /// `tools`: those of [`shown`]; `encodes`: whether the shader has to apply the sRGB curve, because the target does not.
    pub(super) fn new(scene: &Scene<'_>, tools: &[&ToolView], outline: &Outline, aspect: f32, encodes: bool) -> Self {
        let (sin, cos) = scene.phase.radians().sin_cos();
        let mut tool = [ToolUniform::zeroed(); Scene::TOOLS_MAX];
        for (slot, view) in tool.iter_mut().zip(tools) {
            *slot = ToolUniform {
                centre_m: view.centre_m.to_array(),
                radius_m: radius_m(scene, view.tool).max(1e-5),
                colour: view.colour,
                touching: match (view.touching, view.clay_m) {
                    (true, _) => 1.0,
                    (false, clay_m) => -clay_m.filter(|clay_m| clay_m.is_finite()).unwrap_or(0.0).max(0.0),
                },
                turn: view.turn.normalize().to_array(),
            };
        }
        Self {
            clip_from_room: scene.camera.view_projection(aspect).to_cols_array(),
            camera_m: scene.camera.eye_m().to_array(),
            wetness: scene.wetness.clamp(0.0, 1.0),
            wheel: [cos as f32, sin as f32],
            encodes: f32::from(u8::from(encodes)),
            aspect,
            pot_height_m: outline.height_m,
            // light falls freely into a pot that is cut open
            rim_inner_m: if scene.is_cut { CUT_OPEN_M } else { outline.rim_inner_m },
            foot_m: outline.foot_m,
            tools: tools.len().min(Scene::TOOLS_MAX) as u32,
            outline_m: outline.radii_m,
            finish: scene.finish.uniform(),
            tool,
        }
    }
}
