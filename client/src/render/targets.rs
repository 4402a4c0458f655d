//! What a picture is drawn into besides itself: the depth, and the samples of each pixel.
//!
//! Owns both for one size at a time; knows no scene.
//! Invariant: what is not the picture is not kept beyond a pass.

use super::pipelines::DEPTH_FORMAT;

/// Depth and samples for one size.
#[derive(Debug, Default)]
pub(super) struct Targets {
    made: Option<Made>,
}

#[derive(Debug)]
struct Made {
    size: (u32, u32),
    depth: wgpu::TextureView,
    /// The samples of each pixel, when there are several.
    samples: Option<wgpu::TextureView>,
}

impl Targets {
    /// Begins a pass over all of `target`, of that format and size, with so many samples a pixel.
    pub(super) fn begin<'a>(
        &mut self,
        device: &wgpu::Device,
        encoder: &'a mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        (format, sample_count, size): (wgpu::TextureFormat, u32, (u32, u32)),
    ) -> wgpu::RenderPass<'a> {
        if self.made.as_ref().is_none_or(|made| made.size != size) {
            self.made = Some(Made::new(device, format, sample_count, size));
        }
        let made = self.made.as_ref().expect("made just above");
        let (view, resolve_target) = match &made.samples {
            Some(samples) => (samples, Some(target)),
            None => (target, None),
        };
        encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("studio"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view,
                depth_slice: None,
                resolve_target,
                ops: wgpu::Operations {
                    // the backdrop covers what nothing else does
                    load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                    store: if resolve_target.is_some() { wgpu::StoreOp::Discard } else { wgpu::StoreOp::Store },
                },
            })],
            depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                view: &made.depth,
                depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                stencil_ops: None,
            }),
            ..Default::default()
        })
    }
}

impl Made {
    fn new(device: &wgpu::Device, format: wgpu::TextureFormat, sample_count: u32, size: (u32, u32)) -> Self {
        let view = |label, format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some(label),
                size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        Self { size, depth: view("depth", DEPTH_FORMAT), samples: (sample_count > 1).then(|| view("samples", format)) }
    }
}
