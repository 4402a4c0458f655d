//! Many wheels in one picture: a class at a glance.
//!
//! Owns the radii of all pots, one below the other in a texture, and how the wheels share the picture; which pots there are and how
//! they turn is told to it. All of them are drawn in one pass, every page of them in one call, an instance each.
//! Invariant: a wheel's pot is drawn from its own radii alone, in its own part of the picture.

use bytemuck::{Pod, Zeroable};
use glam::Vec2;
use pottery_shared::clay::{GridShape, Phase, Pot, PotSpec, Skin, Window};
use pottery_shared::snapshot::Touched;
use wgpu::util::DeviceExt;

use super::deflection_map::DeflectionMap;
use super::frame::{FrameUniform, Outline, SkinUniform, first_row};
use super::grid::parts;
use super::mesh::Stride;
use super::pipelines::{GalleryPipelines, Layouts};
use super::readback::{self, RenderError};
use super::renderer::uniform_buffer;
use super::targets::Targets;
use super::water_map::WaterMap;
use super::{Camera, Gpu, Scene};

/// As `gallery.wgsl` has them.
const PLACES: usize = 256;
const HEAD_STEPS: u32 = 4;

/// A wheel as a gallery shows it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WheelView {
    /// The wheel's angle.
    pub phase: Phase,
    /// Middle of its part of the picture, −1 to 1, x to the right and y upwards.
    pub middle: Vec2,
    /// Half the size of that part, in the same measure.
    pub half: Vec2,
}

/// One picture's worth of a gallery.
#[derive(Clone, Copy, Debug)]
pub struct GalleryScene<'a> {
    /// Where each of the wheels is seen from.
    pub camera: Camera,
    /// The wheels, in the order in which their pots were uploaded.
    pub wheels: &'a [WheelView],
    /// As [`Scene::wetness`].
    pub wetness: f32,
}

/// `struct Place` of `gallery.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct PlaceUniform {
    middle: [f32; 2],
    half: [f32; 2],
    wheel: [f32; 2],
    row_height_m: f32,
    padding: f32,
}

/// `struct Gallery` of `gallery.wgsl`.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct GalleryUniform {
    place: [PlaceUniform; PLACES],
}

/// As many wheels as a texture and a uniform hold.
#[derive(Debug)]
struct Page {
    radii: wgpu::Texture,
    skin_group: wgpu::BindGroup,
    uniform: wgpu::Buffer,
    gallery_group: wgpu::BindGroup,
    row_heights_m: Vec<f32>,
}

/// Draws many pots of one grid.
#[derive(Debug)]
pub struct GalleryRenderer {
    device: wgpu::Device,
    queue: wgpu::Queue,
    format: wgpu::TextureFormat,
    sample_count: u32,
    shape: GridShape,
    /// How many surfaces a pot has.
    surfaces: u32,
    outline: Outline,
    pipelines: GalleryPipelines,
    frame: wgpu::Buffer,
    frame_group: wgpu::BindGroup,
    pages: Vec<Page>,
    a_page: usize,
    indices: wgpu::Buffer,
    index_count: u32,
    targets: Targets,
}

impl GalleryRenderer {
    /// A renderer of so many wheels with pots as `pot` is made, into pictures as [`super::PotRenderer::new`] has them.
    ///
    /// # Panics
    /// When the device cannot draw into that format with that many samples.
    #[must_use]
    pub fn new(gpu: &Gpu, format: wgpu::TextureFormat, samples: u32, pot: &Pot, wheels: usize) -> Self {
        let device = gpu.device().clone();
        let layouts = Layouts::new(&device);
        let frame = uniform_buffer::<FrameUniform>(&device, "frame");
        let mut water = WaterMap::new(&device);
        water.show(gpu.queue(), None);
        let frame_group = layouts.bind_frame(&device, &frame, &water, &DeflectionMap::new(&device));
        let skin = inner_skin(pot);
        let (shape, surfaces) = (pot.spec().shape, pot.spec().skins() as u32);
        let first_row = first_row(pot, skin);
        let longest = device.limits().max_texture_dimension_2d;
        let a_page = (longest / (shape.columns() * surfaces)).clamp(1, PLACES as u32) as usize;
        let counts = (0..wheels).step_by(a_page).map(|first| (wheels - first).min(a_page));
        let pages = counts.map(|count| Page::new(&device, &layouts, pot, count)).collect();
        let triangles = triangles(shape, first_row);
        let indices = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("wheel mesh"),
            contents: bytemuck::cast_slice(&triangles),
            usage: wgpu::BufferUsages::INDEX,
        });
        let mut renderer = Self {
            queue: gpu.queue().clone(),
            format,
            sample_count: samples,
            shape,
            surfaces,
            outline: Outline::of(pot),
            pipelines: GalleryPipelines::new(&device, &layouts, format, samples),
            frame,
            frame_group,
            pages,
            a_page,
            indices,
            index_count: triangles.len() as u32,
            targets: Targets::default(),
            device,
        };
        for wheel in 0..wheels {
            renderer.upload(wheel, pot);
        }
        renderer
    }

    /// How many wheels there are.
    #[must_use]
    pub fn wheels(&self) -> usize {
        self.pages.iter().map(|page| page.row_heights_m.len()).sum()
    }

    /// Whether pots are of the grid and wall that it draws.
    #[must_use]
    pub fn fits(&self, spec: &PotSpec) -> bool {
        spec.shape == self.shape && spec.skins() == self.surfaces as usize
    }

    /// Sends all radii of a wheel's pot to the device; of one with another grid, until it comes with this one, the means of its elements
    /// under each, or the one above.
    ///
    /// # Panics
    /// When there is no such wheel.
    pub fn upload(&mut self, wheel: usize, pot: &Pot) {
        let whole = Window { first_column: 0, columns: self.shape.columns(), first_row: 0, rows: self.shape.rows() };
        let skins = pot.skins();
        for (number, skin) in (0..self.surfaces).zip(skins) {
            if self.fits(pot.spec()) {
                self.upload_window(wheel, pot, number, whole);
            } else {
                self.upload_means(wheel, pot, (number, skin), whole);
            }
        }
    }

    /// The means of a skin's elements under each of the grid that is drawn.
    fn upload_means(&mut self, wheel: usize, pot: &Pot, (number, skin): (u32, Skin), whole: Window) {
        let surface = &pot.surfaces()[skin.surface];
        let (old, rows) = (surface.shape(), self.shape.rows());
        let under = |at: u32, of: u32, old: u32| {
            (at * old / of) as usize..((at + 1) * old / of).max(at * old / of + 1) as usize
        };
        let mut radii_m = Vec::with_capacity(self.shape.elements());
        for column in 0..self.shape.columns() {
            let columns = under(column, self.shape.columns(), old.columns());
            for row in 0..rows {
                let part = under(row, rows, old.rows());
                let count = (columns.len() * part.len()) as f32;
                let all = columns.clone().flat_map(|column| &surface.column_m(column as u32)[part.clone()]);
                radii_m.push(all.sum::<f32>() / count - skin.inset_m);
            }
        }
        let row_height_m = surface.height_m() / (rows - 1) as f32;
        self.write(wheel, number, row_height_m, whole, &radii_m);
    }

    /// Sends every tile in which a wheel's pot changed.
    ///
    /// # Panics
    /// When there is no such wheel, or the pot is of another grid.
    pub fn upload_changed(&mut self, wheel: usize, pot: &Pot, changed: &Touched) {
        for surface in 0..self.surfaces {
            for window in changed.rectangles(surface as usize) {
                self.upload_window(wheel, pot, surface, window);
            }
        }
    }

    fn upload_window(&mut self, wheel: usize, pot: &Pot, number: u32, window: Window) {
        let surface = &pot.surfaces()[number as usize];
        assert_eq!(surface.shape(), self.shape);
        self.write(wheel, number, surface.row_height_m(), window, surface.radii_m());
    }

    /// Sends a window of all radii of a wheel's surface.
    fn write(&mut self, wheel: usize, surface: u32, row_height_m: f32, window: Window, radii_m: &[f32]) {
        let (page, place) = (&mut self.pages[wheel / self.a_page], wheel % self.a_page);
        page.row_heights_m[place] = row_height_m;
        page.write(&self.queue, (place as u32 * self.surfaces + surface, self.shape), window, radii_m);
    }

    /// Draws the wheels over all of `target`, as [`super::PotRenderer::draw`] does; those that the scene leaves out are not drawn.
    pub fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        size: (u32, u32),
        scene: &GalleryScene<'_>,
    ) {
        let (width, height) = size;
        if width == 0 || height == 0 {
            return;
        }
        let aspect = width as f32 / height as f32;
        // every part of the picture is a picture of the same shape
        let part = scene.wheels.first().map_or(1.0, |wheel| wheel.half.x / wheel.half.y.max(1e-6));
        let alone = Scene { camera: scene.camera, wetness: scene.wetness, ..Scene::default() };
        let frame = FrameUniform::new(&alone, &[], &self.outline, aspect * part, !self.format.is_srgb());
        self.queue.write_buffer(&self.frame, 0, bytemuck::bytes_of(&frame));
        for (wheels, page) in scene.wheels.chunks(self.a_page).zip(&self.pages) {
            page.tell(&self.queue, wheels);
        }
        let kind = (self.format, self.sample_count, size);
        let mut pass = self.targets.begin(&self.device, encoder, target, kind);
        pass.set_bind_group(0, &self.frame_group, &[]);
        pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
        pass.set_pipeline(&self.pipelines.wheels);
        for (wheels, page) in scene.wheels.chunks(self.a_page).zip(&self.pages) {
            pass.set_bind_group(1, &page.skin_group, &[]);
            pass.set_bind_group(2, &page.gallery_group, &[]);
            pass.draw_indexed(0..self.index_count, 0, 0..wheels.len().min(page.row_heights_m.len()) as u32);
        }
        pass.set_pipeline(&self.pipelines.backdrop);
        pass.draw(0..3, 0..1);
    }

    /// Draws the wheels aside and brings the pixels back, row by row from the top, in the renderer's own format.
    ///
    /// # Errors
    /// [`RenderError::Size`] when a side is zero or longer than the device allows; otherwise when the device was lost.
    pub fn pixels(&mut self, scene: &GalleryScene<'_>, width: u32, height: u32) -> Result<Vec<u8>, RenderError> {
        let (device, queue, format) = (self.device.clone(), self.queue.clone(), self.format);
        readback::pixels((&device, &queue), format, (width, height), |encoder, view| {
            self.draw(encoder, view, (width, height), scene);
        })
    }
}

impl Page {
    fn new(device: &wgpu::Device, layouts: &Layouts, pot: &Pot, wheels: usize) -> Self {
        let skin = inner_skin(pot);
        let surface = &pot.surfaces()[skin.surface];
        let shape = surface.shape();
        let radii = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("radii of many"),
            size: wgpu::Extent3d {
                width: shape.rows(),
                height: shape.columns() * (pot.spec().skins() * wheels) as u32,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = radii.create_view(&wgpu::TextureViewDescriptor::default());
        // its radii stand behind those of the surfaces before it
        let behind = skin.surface as u32 * shape.columns();
        let skin_uniform = SkinUniform::new(shape, surface.row_height_m(), skin, first_row(pot, skin), Stride::FULL)
            .beginning_at(behind);
        let skin_buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("inner walls"),
            contents: bytemuck::bytes_of(&skin_uniform),
            usage: wgpu::BufferUsages::UNIFORM,
        });
        let uniform = uniform_buffer::<GalleryUniform>(device, "gallery");
        Self {
            radii,
            skin_group: layouts.bind_skin(device, &skin_buffer, &view),
            gallery_group: layouts.bind_gallery(device, &uniform),
            uniform,
            row_heights_m: vec![surface.row_height_m(); wheels],
        }
    }

    /// Sends a window of all radii of the grid in a place.
    fn write(&self, queue: &wgpu::Queue, (place, shape): (u32, GridShape), window: Window, radii_m: &[f32]) {
        let rows = shape.rows();
        for (first_column, columns) in parts(shape, window) {
            let start = first_column as usize * rows as usize + window.first_row as usize;
            let y = place * shape.columns() + first_column;
            queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &self.radii,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: window.first_row, y, z: 0 },
                    aspect: wgpu::TextureAspect::All,
                },
                bytemuck::cast_slice(&radii_m[start..]),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(rows * size_of::<f32>() as u32),
                    rows_per_image: None,
                },
                wgpu::Extent3d { width: window.rows, height: columns, depth_or_array_layers: 1 },
            );
        }
    }

    /// Tells the shader where the wheels are.
    fn tell(&self, queue: &wgpu::Queue, wheels: &[WheelView]) {
        let mut told = GalleryUniform::zeroed();
        for (number, (view, &row_height_m)) in wheels.iter().zip(&self.row_heights_m).enumerate() {
            let (sin, cos) = view.phase.radians().sin_cos();
            let (middle, half) = (view.middle.to_array(), view.half.to_array());
            told.place[number] =
                PlaceUniform { middle, half, wheel: [cos as f32, sin as f32], row_height_m, padding: 0.0 };
        }
        queue.write_buffer(&self.uniform, 0, bytemuck::bytes_of(&told));
    }
}

/// The innermost wall.
fn inner_skin(pot: &Pot) -> Skin {
    let [_, inner] = pot.skins();
    inner
}

/// Wheel head, outer wall from the foot up, inner wall from the rim down and the floor: columns side by side, seen from outside
/// counter-clockwise.
fn triangles(shape: GridShape, first_row: u32) -> Vec<u32> {
    let steps = HEAD_STEPS + 2 * shape.rows() - first_row + 1;
    let mut indices = Vec::new();
    for column in 0..shape.columns() {
        for step in (0..steps - 1).filter(|step| *step != HEAD_STEPS - 1) {
            let (left, right) = (column * steps + step, (column + 1) * steps + step);
            indices.extend_from_slice(&[left, right, right + 1, left, right + 1, left + 1]);
        }
    }
    indices
}
