//! What the vertex stage makes of a skin, read back.
//!
//! Runs the very transform that draws, on the very device that draws: a driver that gets it wrong shows here.

use glam::Vec3;
use pottery_shared::clay::{Pot, Skin};
use wgpu::util::DeviceExt;

use super::frame::SkinUniform;
use super::grid::GridTextures;
use super::mesh::Stride;
use super::pipelines::{Layouts, Pipelines};
use super::readback::texels;
use super::{Gpu, RenderError};

/// Position and normal of one element, pot frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProbedVertex {
    /// Where it stands, m.
    pub position_m: Vec3,
    /// Away from the clay, of length one.
    pub normal: Vec3,
}

/// What the vertex stage computes for every element of a skin, `[columns][rows]`, all rows.
///
/// # Errors
/// [`RenderError`] when the device was lost.
///
/// # Panics
/// When the pot has no such surface.
pub fn probe_skin(gpu: &Gpu, pot: &Pot, skin: Skin) -> Result<Vec<ProbedVertex>, RenderError> {
    let (device, queue) = (gpu.device(), gpu.queue());
    let surface = &pot.surfaces()[skin.surface];
    let shape = surface.shape();
    let layouts = Layouts::new(device);
    let pipeline = Pipelines::probe(device, &layouts);
    let mut grid = GridTextures::new(device, &layouts, surface);
    let whole = grid.whole();
    grid.upload(queue, surface, whole);
    let uniform = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
        label: Some("probed skin"),
        contents: bytemuck::bytes_of(&SkinUniform::new(shape, surface.row_height_m(), skin, 0, Stride::FULL)),
        usage: wgpu::BufferUsages::UNIFORM,
    });
    let group = layouts.bind_skin(device, &uniform, grid.radii_view());

    let targets = ["positions", "normals"].map(|label| {
        device.create_texture(&wgpu::TextureDescriptor {
            label: Some(label),
            size: wgpu::Extent3d { width: shape.rows(), height: shape.columns(), depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Uint,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
            view_formats: &[],
        })
    });
    let views = [0, 1].map(|at: usize| targets[at].create_view(&wgpu::TextureViewDescriptor::default()));
    let attachments = [0, 1].map(|at: usize| {
        Some(wgpu::RenderPassColorAttachment {
            view: &views[at],
            depth_slice: None,
            resolve_target: None,
            ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::TRANSPARENT), store: wgpu::StoreOp::Store },
        })
    });
    let mut encoder = device.create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("probe") });
    {
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("probe"),
            color_attachments: &attachments,
            ..Default::default()
        });
        pass.set_pipeline(&pipeline);
        pass.set_bind_group(1, &group, &[]);
        pass.draw(0..shape.elements() as u32, 0..1);
    }
    queue.submit([encoder.finish()]);
    let [positions, normals] = &targets;
    let positions: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&texels(device, queue, positions, 16)?);
    let normals: Vec<[f32; 4]> = bytemuck::pod_collect_to_vec(&texels(device, queue, normals, 16)?);
    let vertices = positions.iter().zip(&normals).map(|(position, normal)| ProbedVertex {
        position_m: Vec3::new(position[0], position[1], position[2]),
        normal: Vec3::new(normal[0], normal[1], normal[2]),
    });
    Ok(vertices.collect())
}
