//! Draws a pot, its wheel and the tools at it.
//!
//! Owns everything on the device that belongs to one pot. The caller says what changed (`upload`) and what to show
//! (`draw`); nothing is drawn unasked.
//! Invariant: only the rectangles handed to `upload` travel to the device.

use pottery_shared::clay::{GridShape, Pot, Skin, Surface, Window};
use pottery_shared::snapshot::Touched;

use super::bends::Bends;
use super::deflection_map::DeflectionMap;
use super::enlarge::Enlarger;
use super::frame::{self, FrameUniform, Outline, SkinUniform, first_row};
use super::grid::GridTextures;
use super::mesh::{Meshes, Stride, mesh_columns};
use super::pipelines::{Layouts, Pipelines};
use super::readback::{self, RenderError, texels};
use super::solid::Solids;
use super::targets::Targets;
use super::water_map::WaterMap;
use super::{Deflection, Gpu, Scene, ToolView};

/// Vertices of the shapes that the shaders make up, as `scenery.wgsl`, `tool.wgsl` and `rim.wgsl` count them.
const HEAD_VERTICES: u32 = 3 * 128 * 6;
const PAN_VERTICES: u32 = 6 * 128 * 6;
const BALL_VERTICES: u32 = 40 * 20 * 6;
const LIP_STEPS: u32 = 8;
const LIP_VERTICES: u32 = LIP_STEPS * 6;
const SEGMENT_VERTICES: u32 = 6;
const FLOOR_VERTICES: u32 = 3;

/// A skin of the pot on the device.
#[derive(Debug)]
struct SkinDrawing {
    skin: Skin,
    shape: GridShape,
    row_height_m: f32,
    first_row: u32,
    uniform: wgpu::Buffer,
    group: wgpu::BindGroup,
}

/// Which strips of a ring of strips are drawn: so many from one on, round the seam as well.
#[derive(Clone, Copy, Debug)]
struct Kept {
    first: u32,
    count: u32,
    ring: u32,
}

impl Kept {
    const fn whole(ring: u32) -> Self {
        Self { first: 0, count: ring, ring }
    }

    /// The half behind the plane through the axis that faces the camera.
    fn half(ring: u32, scene: &Scene<'_>) -> Self {
        let turns = (f64::from(scene.camera.azimuth_rad) - scene.phase.radians()) / std::f64::consts::TAU + 0.25;
        let first = (turns.rem_euclid(1.0) * f64::from(ring)).round() as u32 % ring;
        Self { first, count: ring.div_ceil(2), ring }
    }

    /// As ranges that do not cross the seam.
    fn strips(self) -> [std::ops::Range<u32>; 2] {
        let end = self.first + self.count;
        [self.first..end.min(self.ring), 0..end.saturating_sub(self.ring)]
    }

    /// The strip that it begins with, and the one that follows its last.
    const fn edges(self) -> [u32; 2] {
        [self.first, (self.first + self.count) % self.ring]
    }
}

/// Draws one pot.
#[derive(Debug)]
pub struct PotRenderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    format: wgpu::TextureFormat,
    sample_count: u32,
    vertex_px: f32,
    outline_px: f32,
    pipelines: Pipelines,
    frame: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    water: WaterMap,
    deflection: DeflectionMap,
    /// Of the surfaces that a skin follows, which come first; what lies behind them is not drawn.
    grids: Vec<GridTextures>,
    /// How much each of them bends.
    bends: Vec<Bends>,
    skins: Vec<SkinDrawing>,
    meshes: Meshes,
    solids: Solids,
    outline: Outline,
    share: f32,
    enlarger: Enlarger,
    targets: Targets,
}

impl PotRenderer {
    /// Largest distance on screen between neighbouring vertices on a graphics card, pixels.
    pub const VERTEX_PX: f32 = 1.5;
    /// The same when the processor draws, where vertices cost most; the light still sees every element.
    pub const VERTEX_PX_SOFTWARE: f32 = 6.0;
    /// Farthest that the outline of what is drawn may lie from that of all elements, pixels.
    pub const OUTLINE_PX: f32 = 0.5;
    /// The same while something moves and the processor draws: at the edge of a dent, triangles smaller than a pixel take more than half of its time.
    pub const OUTLINE_PX_MOVING_SOFTWARE: f32 = 2.0;

    /// A renderer of `pot` into pictures of `color_format` with `samples` samples a pixel (1 or 4).
    ///
    /// The format may be an sRGB one or a plain one; in both cases the picture is meant for an sRGB screen.
    ///
    /// # Panics
    /// When the device cannot draw into that format with that many samples.
    #[must_use]
    pub fn new(gpu: &Gpu, color_format: wgpu::TextureFormat, samples: u32, pot: &Pot) -> Self {
        let device = gpu.device().clone();
        let layouts = Layouts::new(&device);
        let pipelines = Pipelines::new(&device, &layouts, color_format, samples);
        let frame = uniform_buffer::<FrameUniform>(&device, "frame");
        let water = WaterMap::new(&device);
        let deflection = DeflectionMap::new(&device);
        let frame_group = layouts.bind_frame(&device, &frame, &water, &deflection);
        let grids: Vec<_> = drawn(pot).iter().map(|surface| GridTextures::new(&device, &layouts, surface)).collect();
        let skins = pot.skins().into_iter().map(|skin| {
            let uniform = uniform_buffer::<SkinUniform>(&device, "skin");
            let group = layouts.bind_skin(&device, &uniform, grids[skin.surface].radii_view());
            let surface = &pot.surfaces()[skin.surface];
            let (shape, row_height_m) = (surface.shape(), surface.row_height_m());
            SkinDrawing { skin, shape, row_height_m, first_row: first_row(pot, skin), uniform, group }
        });
        let skins = skins.collect();
        let mut renderer = Self {
            queue: gpu.queue().clone(),
            format: color_format,
            sample_count: samples,
            vertex_px: if gpu.is_software() { Self::VERTEX_PX_SOFTWARE } else { Self::VERTEX_PX },
            pipelines,
            outline_px: Self::OUTLINE_PX,
            frame,
            frame_group,
            water,
            deflection,
            bends: drawn(pot).iter().map(|surface| Bends::new(surface.shape())).collect(),
            grids,
            skins,
            meshes: Meshes::default(),
            solids: Solids::default(),
            outline: Outline::of(pot),
            share: 1.0,
            enlarger: Enlarger::new(&device, color_format),
            targets: Targets::default(),
            device,
        };
        renderer.upload_all(pot);
        renderer
    }

    /// Sets the largest distance on screen between neighbouring vertices, pixels; 0 draws every element.
    ///
    /// The stride is the largest power of two that keeps to it where the pot is nearest, and to [`Self::set_outline_px`]. Columns may
    /// lie twice as far apart as rows.
    pub fn set_vertex_px(&mut self, vertex_px: f32) {
        self.vertex_px = vertex_px;
    }

    /// Sets by how much the outline may be off for vertices that are left out, pixels of what is drawn; [`Self::OUTLINE_PX`] at first.
    pub fn set_outline_px(&mut self, outline_px: f32) {
        self.outline_px = outline_px;
    }

    /// Sets the share of width and height that is drawn, above 0 up to 1; what is smaller is enlarged to the picture.
    pub fn set_share(&mut self, share: f32) {
        self.share = share.clamp(0.05, 1.0);
    }

    /// Whether a pot has the surfaces of the one that it was made for, with their grids.
    #[must_use]
    pub fn fits(&self, pot: &Pot) -> bool {
        self.grids.iter().map(GridTextures::shape).eq(drawn(pot).iter().map(Surface::shape))
    }

    /// Sends the radii of one window of one surface to the device, and nothing else; nothing of a surface that no skin follows.
    ///
    /// # Panics
    /// When the pot has other surfaces than the one the renderer was made for, or the window lies outside.
    pub fn upload(&mut self, pot: &Pot, surface: usize, window: Window) {
        if surface >= self.grids.len() {
            return;
        }
        self.grids[surface].upload(&self.queue, &pot.surfaces()[surface], window);
        self.bends[surface].note(&pot.surfaces()[surface], window);
        self.note_heights(pot);
    }

    /// Sends every tile in which `pot` changed.
    pub fn upload_changed(&mut self, pot: &Pot, changed: &Touched) {
        for surface in 0..self.grids.len() {
            for rectangle in changed.rectangles(surface) {
                self.upload(pot, surface, rectangle);
            }
        }
    }

    /// Sends all radii to the device.
    ///
    /// # Panics
    /// When the pot has other surfaces than the one the renderer was made for.
    pub fn upload_all(&mut self, pot: &Pot) {
        assert_eq!(drawn(pot).len(), self.grids.len());
        for ((grid, bends), surface) in self.grids.iter_mut().zip(&mut self.bends).zip(drawn(pot)) {
            let whole = grid.whole();
            grid.upload(&self.queue, surface, whole);
            bends.note(surface, whole);
        }
        self.note_heights(pot);
    }

    fn note_heights(&mut self, pot: &Pot) {
        self.outline = Outline::of(pot);
        for drawing in &mut self.skins {
            drawing.row_height_m = pot.surfaces()[drawing.skin.surface].row_height_m();
        }
    }

    /// The radii of one surface as they lie on the device, `[columns][rows]`, m.
    ///
    /// # Errors
    /// [`RenderError`] when the device was lost.
    ///
    /// # Panics
    /// When there is no such surface, or no skin follows it.
    pub fn radii_on_device(&self, surface: usize) -> Result<Vec<f32>, RenderError> {
        let bytes = texels(&self.device, &self.queue, self.grids[surface].radii(), size_of::<f32>() as u32)?;
        Ok(bytemuck::pod_collect_to_vec(&bytes))
    }

    /// Draws the scene over all of `target`, which is of the renderer's format and `size` (width, height) pixels.
    ///
    /// The commands refer to state that the next `draw` overwrites: submit them before drawing again.
    /// A size of zero draws nothing.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        size: (u32, u32),
        scene: &Scene<'_>,
    ) {
        let (width, height) = size;
        if width == 0 || height == 0 {
            return;
        }
        let drawn = [width, height].map(|side| ((side as f32 * self.share).round() as u32).clamp(1, side));
        if drawn == [width, height] {
            self.draw_whole(encoder, target, size, scene);
        } else {
            let smaller = self.enlarger.target(&self.device, drawn.into());
            self.draw_whole(encoder, &smaller, drawn.into(), scene);
            self.enlarger.enlarge(encoder, target);
        }
    }

    fn draw_whole(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        size: (u32, u32),
        scene: &Scene<'_>,
    ) {
        let (width, height) = size;
        let aspect = width as f32 / height as f32;
        self.solids.complete(&self.device, scene.rack);
        let tools = frame::shown(scene);
        let frame = FrameUniform::new(scene, &tools, &self.outline, aspect, !self.format.is_srgb());
        self.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
        self.water.show(&self.queue, scene.water);
        self.deflection.show(&self.queue, scene.deflection);
        let meshes = self.choose_meshes(scene, aspect, height);
        for grid in &mut self.grids {
            grid.refresh(encoder, &self.pipelines);
        }
        let kind = (self.format, self.sample_count, size);
        let mut pass = self.targets.begin(&self.device, encoder, target, kind);
        pass.set_bind_group(0, &self.frame_group, &[]);
        self.draw_clay(&mut pass, &meshes, scene);
        self.draw_tools(&mut pass, &tools);
        pass.set_pipeline(&self.pipelines.head);
        pass.draw(0..HEAD_VERTICES, 0..1);
        pass.set_pipeline(&self.pipelines.pan);
        pass.draw(HEAD_VERTICES..HEAD_VERTICES + PAN_VERTICES, 0..1);
        pass.set_pipeline(&self.pipelines.backdrop);
        pass.draw(0..3, 0..1);
    }

    /// Draws the scene aside and brings its pixels back, row by row from the top, in the renderer's own format.
    ///
    /// # Errors
    /// [`RenderError::Size`] when a side is zero or longer than the device allows; otherwise when the device was lost.
    pub fn pixels(&mut self, scene: &Scene<'_>, width: u32, height: u32) -> Result<Vec<u8>, RenderError> {
        let (device, queue, format) = (self.device.clone(), self.queue.clone(), self.format);
        readback::pixels((&device, &queue), format, (width, height), |encoder, view| {
            self.draw(encoder, view, (width, height), scene);
        })
    }

    /// Chooses every skin's stride for the view, tells the shaders, and returns the stride and the mesh's number.
    fn choose_meshes(&mut self, scene: &Scene<'_>, aspect: f32, height_px: u32) -> Vec<(Stride, usize)> {
        let eye_m = scene.camera.eye_m();
        let widest_m = self.bends.iter().map(Bends::widest_m).fold(0.0, f32::max);
        let nearest_m = (eye_m.distance(eye_m.with_z(0.0).clamp_length_max(widest_m))).max(0.02);
        let px_per_m = 0.5 * height_px as f32 / (scene.camera.half_height(aspect) * nearest_m);
        let (vertex_px, outline_px) = (self.vertex_px, self.outline_px);
        let mut chosen = Vec::with_capacity(self.skins.len());
        for drawing in &self.skins {
            let column_m = drawing.shape.column_angle_rad() * widest_m;
            let row_m = drawing.row_height_m;
            let missed_m = |stride| self.bends[drawing.skin.surface].missed_m(stride);
            let stride = Stride::for_screen(px_per_m, [column_m, row_m], vertex_px, outline_px, missed_m);
            let uniform = SkinUniform::new(drawing.shape, row_m, drawing.skin, drawing.first_row, stride)
                .deflecting(scene.deflection.is_some_and(Deflection::is_any));
            self.queue.write_buffer(&drawing.uniform, 0, bytemuck::bytes_of(&uniform));
            chosen.push((stride, self.meshes.find(&self.device, drawing.shape, drawing.first_row, stride)));
        }
        chosen
    }

    fn draw_clay(&self, pass: &mut wgpu::RenderPass<'_>, meshes: &[(Stride, usize)], scene: &Scene<'_>) {
        let kept = |drawing: &SkinDrawing, stride: Stride| {
            let ring = mesh_columns(drawing.shape, stride) - 1;
            if scene.is_cut { Kept::half(ring, scene) } else { Kept::whole(ring) }
        };
        for (drawing, &(stride, mesh)) in self.skins.iter().zip(meshes) {
            let kept = kept(drawing, stride);
            let mesh = self.meshes.mesh(mesh);
            let outwards = drawing.skin.faces_outwards;
            pass.set_pipeline(if outwards { &self.pipelines.outer_wall } else { &self.pipelines.inner_wall });
            pass.set_bind_group(1, &drawing.group, &[]);
            pass.set_bind_group(2, self.grids[drawing.skin.surface].relief(), &[]);
            pass.set_index_buffer(mesh.indices.slice(..), wgpu::IndexFormat::Uint32);
            let strip = mesh.index_count / (mesh_columns(drawing.shape, stride) - 1);
            for strips in kept.strips() {
                pass.draw_indexed(strips.start * strip..strips.end * strip, 0, 0..1);
            }
        }
        // the outermost and the innermost skin meet at the rim; the latter holds the floor
        let faced =
            |outwards: bool| self.skins.iter().zip(meshes).filter(move |(of, _)| of.skin.faces_outwards == outwards);
        if let (Some((outer, &(outer_stride, _))), Some((inner, &(inner_stride, _)))) =
            (faced(true).next(), faced(false).next_back())
        {
            pass.set_pipeline(&self.pipelines.lip);
            pass.set_bind_group(1, &outer.group, &[]);
            pass.set_bind_group(2, &inner.group, &[]);
            let outer_kept = kept(outer, outer_stride);
            for strips in outer_kept.strips() {
                pass.draw(strips.start * LIP_VERTICES..strips.end * LIP_VERTICES, 0..1);
            }
            if scene.is_cut {
                pass.set_pipeline(&self.pipelines.section);
                let segments = (outer.shape.rows() - 2) / outer_stride.rows + 1 + LIP_STEPS;
                for edge in outer_kept.edges() {
                    let column = edge * outer_stride.columns;
                    pass.draw(0..segments * SEGMENT_VERTICES, column..column + 1);
                }
            }
            pass.set_pipeline(&self.pipelines.floor);
            pass.set_bind_group(1, &inner.group, &[]);
            for strips in kept(inner, inner_stride).strips() {
                pass.draw(strips.start * FLOOR_VERTICES..strips.end * FLOOR_VERTICES, 0..1);
            }
        }
    }

    /// Draws the tools as the frame has them: spheres first, then shape by shape.
    fn draw_tools(&self, pass: &mut wgpu::RenderPass<'_>, tools: &[&ToolView]) {
        let mut first = 0;
        for alike in tools.chunk_by(|one, next| one.tool.shape() == next.tool.shape()) {
            let instances = first..first + alike.len() as u32;
            first = instances.end;
            match alike[0].tool.shape() {
                None => {
                    pass.set_pipeline(&self.pipelines.ball);
                    pass.draw(0..BALL_VERTICES, instances);
                }
                Some(shape) => {
                    let Some(solid) = self.solids.tool(shape) else { continue };
                    pass.set_pipeline(&self.pipelines.facets);
                    pass.set_vertex_buffer(0, solid.corners.slice(..));
                    pass.draw(0..solid.count, instances);
                }
            }
        }
    }
}

/// The surfaces that a skin follows: the first of them.
fn drawn(pot: &Pot) -> &[Surface] {
    &pot.surfaces()[..pot.spec().skins()]
}

/// A uniform buffer for one `T`.
pub(super) fn uniform_buffer<T>(device: &wgpu::Device, label: &str) -> wgpu::Buffer {
    device.create_buffer(&wgpu::BufferDescriptor {
        label: Some(label),
        size: size_of::<T>() as u64,
        usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        mapped_at_creation: false,
    })
}
