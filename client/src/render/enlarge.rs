//! A picture drawn smaller than it is shown, and brought to its size.
//!
//! Owns the smaller picture and the way to the larger one; knows no scene.
//! Invariant: what is drawn smaller keeps its proportions to the pixel.

use super::shader;

/// The smaller picture and what brings it to its size.
#[derive(Debug)]
pub(super) struct Enlarger {
    pipeline: wgpu::RenderPipeline,
    sampler: wgpu::Sampler,
    format: wgpu::TextureFormat,
    smaller: Option<Smaller>,
}

#[derive(Debug)]
struct Smaller {
    size: (u32, u32),
    view: wgpu::TextureView,
    group: wgpu::BindGroup,
}

impl Enlarger {
    pub(super) fn new(device: &wgpu::Device, format: wgpu::TextureFormat) -> Self {
        let module = shader::ENLARGE.compile(device);
        let pipeline = device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some("enlarge"),
            layout: None,
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some("sheet_vertex"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: &[],
            },
            primitive: wgpu::PrimitiveState::default(),
            depth_stencil: None,
            multisample: wgpu::MultisampleState::default(),
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some("sheet_fragment"),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(format.into())],
            }),
            multiview_mask: None,
            cache: None,
        });
        let sampler = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("between pixels"),
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self { pipeline, sampler, format, smaller: None }
    }

    /// What to draw into, of so many pixels.
    pub(super) fn target(&mut self, device: &wgpu::Device, size: (u32, u32)) -> wgpu::TextureView {
        if self.smaller.as_ref().is_none_or(|smaller| smaller.size != size) {
            self.smaller = Some(self.new_smaller(device, size));
        }
        self.smaller.as_ref().expect("made just above").view.clone()
    }

    /// Brings what was drawn to all of `target`.
    pub(super) fn enlarge(&self, encoder: &mut wgpu::CommandEncoder, target: &wgpu::TextureView) {
        let Some(smaller) = &self.smaller else { return };
        let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
            label: Some("enlarge"),
            color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                view: target,
                depth_slice: None,
                resolve_target: None,
                ops: wgpu::Operations { load: wgpu::LoadOp::Clear(wgpu::Color::BLACK), store: wgpu::StoreOp::Store },
            })],
            ..Default::default()
        });
        pass.set_pipeline(&self.pipeline);
        pass.set_bind_group(0, &smaller.group, &[]);
        pass.draw(0..3, 0..1);
    }

    fn new_smaller(&self, device: &wgpu::Device, size: (u32, u32)) -> Smaller {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("smaller picture"),
            size: wgpu::Extent3d { width: size.0, height: size.1, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: self.format,
            usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("smaller picture"),
            layout: &self.pipeline.get_bind_group_layout(0),
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(&view) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(&self.sampler) },
            ],
        });
        Smaller { size, view, group }
    }
}
