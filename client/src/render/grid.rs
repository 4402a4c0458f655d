//! One surface of the pot on the device: its radii, and the relief map that follows from them.
//!
//! Owns the two textures and which part of the relief is out of date; knows no skin and no camera.
//! Invariant: after [`GridTextures::refresh`] the relief map belongs to the radii that were uploaded last.

use pottery_shared::clay::{GridShape, Skin, Surface, Window};
use wgpu::util::DeviceExt;

use super::frame::SkinUniform;
use super::mesh::Stride;
use super::pipelines::{Layouts, Pipelines, RELIEF_FORMAT};

/// Radii and relief of one surface.
#[derive(Debug)]
pub(super) struct GridTextures {
    shape: GridShape,
    radii: wgpu::Texture,
    radii_view: wgpu::TextureView,
    relief_view: wgpu::TextureView,
    /// Radii for the relief pass.
    source: wgpu::BindGroup,
    /// Relief and its filter for the walls.
    relief: wgpu::BindGroup,
    uniform_buffer: wgpu::Buffer,
    /// Distance between rows for which the relief was drawn, m.
    row_height_m: f32,
    reach: (u32, u32),
    stale: Vec<Window>,
}

impl GridTextures {
    /// Windows remembered before the whole relief is drawn again instead.
    const STALE_MAX: usize = 64;
    /// Growth of the pot from which on the light has to be reckoned anew: a thousandth of a slope is not seen.
    const GROWTH_SEEN: f32 = 1e-3;

    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, surface: &Surface) -> Self {
        let shape = surface.shape();
        let texture = |label, format, usage| {
            device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                // memory order is [columns][rows]: a row of the texture is a column of the pot
                size: wgpu::Extent3d { width: shape.rows(), height: shape.columns(), depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::TEXTURE_BINDING | usage,
                view_formats: &[],
            })
        };
        let radii = texture(
            "radii",
            wgpu::TextureFormat::R32Float,
            wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::COPY_SRC,
        );
        let relief = texture("relief", RELIEF_FORMAT, wgpu::TextureUsages::RENDER_ATTACHMENT);
        let radii_view = radii.create_view(&wgpu::TextureViewDescriptor::default());
        let relief_view = relief.create_view(&wgpu::TextureViewDescriptor::default());

        let skin = Skin { surface: 0, inset_m: 0.0, faces_outwards: true };
        let uniform = SkinUniform::new(shape, surface.row_height_m(), skin, 0, Stride::FULL);
        let uniform_buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("relief source"),
            contents: bytemuck::bytes_of(&uniform),
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
        });
        let filter = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("relief filter"),
            address_mode_u: wgpu::AddressMode::ClampToEdge,
            // columns close round the pot
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        let row_height_m = surface.row_height_m();
        let source = layouts.bind_skin(device, &uniform_buffer, &radii_view);
        let relief = layouts.bind_relief(device, &relief_view, &filter);
        let whole = Window { first_column: 0, columns: shape.columns(), first_row: 0, rows: shape.rows() };
        Self {
            shape,
            radii,
            radii_view,
            relief_view,
            source,
            relief,
            uniform_buffer,
            row_height_m,
            reach: uniform.reach(),
            stale: vec![whole],
        }
    }

    pub(super) const fn shape(&self) -> GridShape {
        self.shape
    }

    pub(super) const fn radii(&self) -> &wgpu::Texture {
        &self.radii
    }

    pub(super) const fn radii_view(&self) -> &wgpu::TextureView {
        &self.radii_view
    }

    pub(super) const fn relief(&self) -> &wgpu::BindGroup {
        &self.relief
    }

    /// Every element.
    pub(super) const fn whole(&self) -> Window {
        Window { first_column: 0, columns: self.shape.columns(), first_row: 0, rows: self.shape.rows() }
    }

    /// Sends the radii of `window`, and nothing else, to the device: one rectangle, or two when it crosses the seam.
    pub(super) fn upload(&mut self, queue: &wgpu::Queue, surface: &Surface, window: Window) {
        assert_eq!(surface.shape(), self.shape);
        assert!(window.first_column < self.shape.columns() && window.columns <= self.shape.columns());
        assert!(window.first_row + window.rows <= self.shape.rows());
        if (surface.row_height_m() / self.row_height_m - 1.0).abs() > Self::GROWTH_SEEN {
            // slopes are less steep on a higher pot
            self.row_height_m = surface.row_height_m();
            let skin = Skin { surface: 0, inset_m: 0.0, faces_outwards: true };
            let uniform = SkinUniform::new(self.shape, self.row_height_m, skin, 0, Stride::FULL);
            queue.write_buffer(&self.uniform_buffer, 0, bytemuck::bytes_of(&uniform));
            self.stale.push(self.whole());
        }
        for (first_column, columns) in parts(self.shape, window) {
            let start = first_column as usize * self.shape.rows() as usize + window.first_row as usize;
            queue.write_texture(
                wgpu::TexelCopyTextureInfo {
                    texture: &self.radii,
                    mip_level: 0,
                    origin: wgpu::Origin3d { x: window.first_row, y: first_column, z: 0 },
                    aspect: wgpu::TextureAspect::All,
                },
                bytemuck::cast_slice(&surface.radii_m()[start..]),
                wgpu::TexelCopyBufferLayout {
                    offset: 0,
                    bytes_per_row: Some(self.shape.rows() * size_of::<f32>() as u32),
                    rows_per_image: None,
                },
                wgpu::Extent3d { width: window.rows, height: columns, depth_or_array_layers: 1 },
            );
        }
        if !window.is_empty() {
            let (columns, rows) = self.reach;
            self.stale.push(window.grown(self.shape, columns, rows));
        }
        if self.stale.len() > Self::STALE_MAX {
            self.stale.clear();
            self.stale.push(self.whole());
        }
    }

    /// Draws the relief again where radii changed.
    pub(super) fn refresh(&mut self, encoder: &mut wgpu::CommandEncoder, pipelines: &Pipelines) {
        if self.stale.is_empty() {
            return;
        }
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("relief"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: &self.relief_view,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&pipelines.relief);
        pass.set_bind_group(1, &self.source, &[]);
        for window in self.stale.drain(..) {
            for (first_column, columns) in parts(self.shape, window) {
                pass.set_scissor_rect(window.first_row, first_column, window.rows, columns);
                pass.draw(0..3, 0..1);
            }
        }
    }
}

/// The column ranges of a window (first, number), cut where it crosses the seam; none when it is empty.
pub(super) fn parts(shape: GridShape, window: Window) -> impl Iterator<Item = (u32, u32)> {
    let before_seam = window.columns.min(shape.columns() - window.first_column);
    let both = [(window.first_column, before_seam), (0, window.columns - before_seam)];
    both.into_iter().filter(move |&(_, columns)| columns > 0 && window.rows > 0)
}
