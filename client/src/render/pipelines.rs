//! How the shaders are joined to their inputs and targets.
//!
//! Owns the bind group layouts and every pipeline; knows no pot.
//! Group 0 is the frame, group 1 a skin with its radii, group 2 the relief or the skin on the other side of the rim.

use super::deflection_map::DeflectionMap;
use super::shader::{self, ShaderText};
use super::solid;
use super::water_map::WaterMap;

/// Format of the relief map: filtered by WebGL2 as well, a slope of 1 to 0.1 %.
pub(super) const RELIEF_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba16Float;
/// Format of the depth buffer.
pub(super) const DEPTH_FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What the bind groups look like.
#[derive(Debug)]
pub(super) struct Layouts {
    frame: wgpu::BindGroupLayout,
    skin: wgpu::BindGroupLayout,
    relief: wgpu::BindGroupLayout,
    gallery: wgpu::BindGroupLayout,
}

impl Layouts {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let both = wgpu::ShaderStages::VERTEX_FRAGMENT;
        let layout = |label, entries: &[wgpu::BindGroupLayoutEntry]| {
            device.create_bind_group_layout(&wgpu::BindGroupLayoutDescriptor { label: Some(label), entries })
        };
        let filterable = |filterable| wgpu::TextureSampleType::Float { filterable };
        Self {
            frame: layout(
                "frame",
                &[
                    uniform(0, both),
                    texture(1, wgpu::ShaderStages::FRAGMENT, filterable(true)),
                    filter(2, wgpu::ShaderStages::FRAGMENT),
                    texture(3, both, filterable(false)),
                ],
            ),
            gallery: layout("gallery", &[uniform(0, both)]),
            skin: layout("skin", &[uniform(0, both), texture(1, both, filterable(false))]),
            relief: layout(
                "relief",
                &[texture(0, wgpu::ShaderStages::FRAGMENT, filterable(true)), filter(1, wgpu::ShaderStages::FRAGMENT)],
            ),
        }
    }

    pub(super) fn bind_frame(
        &self,
        device: &wgpu::Device,
        uniform: &wgpu::Buffer,
        water: &WaterMap,
        deflection: &DeflectionMap,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("frame"),
            layout: &self.frame,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(&water.view) },
                wgpu::BindGroupEntry { binding: 2, resource: wgpu::BindingResource::Sampler(&water.filter) },
                wgpu::BindGroupEntry { binding: 3, resource: wgpu::BindingResource::TextureView(&deflection.view) },
            ],
        })
    }

    pub(super) fn bind_gallery(&self, device: &wgpu::Device, uniform: &wgpu::Buffer) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("gallery"),
            layout: &self.gallery,
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        })
    }

    pub(super) fn bind_skin(
        &self,
        device: &wgpu::Device,
        uniform: &wgpu::Buffer,
        radii: &wgpu::TextureView,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("skin"),
            layout: &self.skin,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::TextureView(radii) },
            ],
        })
    }

    pub(super) fn bind_relief(
        &self,
        device: &wgpu::Device,
        relief: &wgpu::TextureView,
        filter: &wgpu::Sampler,
    ) -> wgpu::BindGroup {
        device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("relief"),
            layout: &self.relief,
            entries: &[
                wgpu::BindGroupEntry { binding: 0, resource: wgpu::BindingResource::TextureView(relief) },
                wgpu::BindGroupEntry { binding: 1, resource: wgpu::BindingResource::Sampler(filter) },
            ],
        })
    }
}

const fn uniform(binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Buffer {
            ty: wgpu::BufferBindingType::Uniform,
            has_dynamic_offset: false,
            min_binding_size: None,
        },
        count: None,
    }
}

const fn filter(binding: u32, visibility: wgpu::ShaderStages) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Sampler(wgpu::SamplerBindingType::Filtering),
        count: None,
    }
}

const fn texture(
    binding: u32,
    visibility: wgpu::ShaderStages,
    sample_type: wgpu::TextureSampleType,
) -> wgpu::BindGroupLayoutEntry {
    wgpu::BindGroupLayoutEntry {
        binding,
        visibility,
        ty: wgpu::BindingType::Texture {
            sample_type,
            view_dimension: wgpu::TextureViewDimension::D2,
            multisampled: false,
        },
        count: None,
    }
}

/// What tells one pipeline from another.
#[derive(Clone, Copy)]
struct Drawing<'a> {
    shader: ShaderText,
    vertex: &'a str,
    fragment: &'a str,
    groups: &'a [Option<&'a wgpu::BindGroupLayout>],
    topology: wgpu::PrimitiveTopology,
    cull: Option<wgpu::Face>,
    targets: &'a [wgpu::TextureFormat],
    depth: bool,
    samples: u32,
    buffers: &'a [Option<wgpu::VertexBufferLayout<'a>>],
}

impl Drawing<'_> {
    /// All of those side by side: a driver takes milliseconds for each, and one core.
    fn pipelines<const N: usize>(drawings: [Self; N], device: &wgpu::Device) -> [wgpu::RenderPipeline; N] {
        std::thread::scope(|scope| {
            let made = drawings.map(|drawing| scope.spawn(move || drawing.pipeline(device)));
            made.map(|made| made.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)))
        })
    }

    fn pipeline(&self, device: &wgpu::Device) -> wgpu::RenderPipeline {
        let module = self.shader.compile(device);
        let layout = device.create_pipeline_layout(&wgpu::PipelineLayoutDescriptor {
            label: Some(self.shader.name),
            bind_group_layouts: self.groups,
            immediate_size: 0,
        });
        let targets: Vec<_> = self.targets.iter().map(|&format| Some(wgpu::ColorTargetState::from(format))).collect();
        device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
            label: Some(self.vertex),
            layout: Some(&layout),
            vertex: wgpu::VertexState {
                module: &module,
                entry_point: Some(self.vertex),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                buffers: self.buffers,
            },
            primitive: wgpu::PrimitiveState { topology: self.topology, cull_mode: self.cull, ..Default::default() },
            depth_stencil: self.depth.then(|| wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(true),
                // the backdrop lies at the far end of the depth range, where the buffer was cleared to
                depth_compare: Some(wgpu::CompareFunction::LessEqual),
                stencil: wgpu::StencilState::default(),
                bias: wgpu::DepthBiasState::default(),
            }),
            multisample: wgpu::MultisampleState { count: self.samples, ..Default::default() },
            fragment: Some(wgpu::FragmentState {
                module: &module,
                entry_point: Some(self.fragment),
                compilation_options: wgpu::PipelineCompilationOptions::default(),
                targets: &targets,
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

/// Every pipeline that a picture takes.
#[derive(Debug)]
pub(super) struct Pipelines {
    pub(super) relief: wgpu::RenderPipeline,
    pub(super) outer_wall: wgpu::RenderPipeline,
    pub(super) inner_wall: wgpu::RenderPipeline,
    pub(super) lip: wgpu::RenderPipeline,
    pub(super) floor: wgpu::RenderPipeline,
    pub(super) section: wgpu::RenderPipeline,
    pub(super) ball: wgpu::RenderPipeline,
    pub(super) facets: wgpu::RenderPipeline,
    pub(super) head: wgpu::RenderPipeline,
    pub(super) pan: wgpu::RenderPipeline,
    pub(super) backdrop: wgpu::RenderPipeline,
}

impl Pipelines {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, format: wgpu::TextureFormat, samples: u32) -> Self {
        let clay = [Some(&layouts.frame), Some(&layouts.skin), Some(&layouts.relief)];
        let rim = [Some(&layouts.frame), Some(&layouts.skin), Some(&layouts.skin)];
        let skin = [None, Some(&layouts.skin)];
        let (pot, room) = (&rim[..2], &rim[..1]);
        let draw = |shader, vertex, fragment, groups, cull| Drawing {
            shader,
            vertex,
            fragment,
            groups,
            topology: wgpu::PrimitiveTopology::TriangleList,
            cull,
            targets: std::slice::from_ref(&format),
            depth: true,
            samples,
            buffers: &[],
        };
        let (back, front) = (Some(wgpu::Face::Back), Some(wgpu::Face::Front));
        let wall = |cull| draw(shader::CLAY, "wall_vertex", "wall_fragment", &clay, cull);
        let flat = Drawing {
            targets: &[RELIEF_FORMAT],
            depth: false,
            samples: 1,
            ..draw(shader::RELIEF, "relief_vertex", "relief_fragment", &skin, None)
        };
        let cornered = Drawing {
            buffers: &[Some(solid::CORNERS)],
            ..draw(shader::TOOL, "facet_vertex", "facet_fragment", room, back)
        };
        let drawings = [
            flat,
            wall(back),
            wall(front),
            draw(shader::RIM, "lip_vertex", "lip_fragment", &rim, back),
            draw(shader::RIM, "floor_vertex", "floor_fragment", pot, back),
            draw(shader::RIM, "section_vertex", "section_fragment", &rim, None),
            draw(shader::TOOL, "ball_vertex", "ball_fragment", room, back),
            cornered,
            draw(shader::SCENERY, "lathe_vertex", "head_fragment", room, None),
            draw(shader::SCENERY, "lathe_vertex", "pan_fragment", room, None),
            draw(shader::SCENERY, "backdrop_vertex", "backdrop_fragment", room, None),
        ];
        let [relief, outer_wall, inner_wall, lip, floor, section, ball, facets, head, pan, backdrop] =
            Drawing::pipelines(drawings, device);
        Self { relief, outer_wall, inner_wall, lip, floor, section, ball, facets, head, pan, backdrop }
    }

    /// The pipeline that reads back what the vertex stage computes.
    pub(super) fn probe(device: &wgpu::Device, layouts: &Layouts) -> wgpu::RenderPipeline {
        Drawing {
            shader: shader::PROBE,
            vertex: "probe_vertex",
            fragment: "probe_fragment",
            groups: &[None, Some(&layouts.skin)],
            topology: wgpu::PrimitiveTopology::PointList,
            cull: None,
            targets: &[wgpu::TextureFormat::Rgba32Uint; 2],
            depth: false,
            samples: 1,
            buffers: &[],
        }
        .pipeline(device)
    }
}

/// What a picture of many wheels takes.
#[derive(Debug)]
pub(super) struct GalleryPipelines {
    /// Walls, rims, floors and wheel heads of all of them.
    pub(super) wheels: wgpu::RenderPipeline,
    pub(super) backdrop: wgpu::RenderPipeline,
}

impl GalleryPipelines {
    pub(super) fn new(device: &wgpu::Device, layouts: &Layouts, format: wgpu::TextureFormat, samples: u32) -> Self {
        let groups = [Some(&layouts.frame), Some(&layouts.skin), Some(&layouts.gallery)];
        let draw = |shader, vertex, fragment, groups: &[_], cull| {
            Drawing {
                shader,
                vertex,
                fragment,
                groups,
                topology: wgpu::PrimitiveTopology::TriangleList,
                cull,
                targets: &[format],
                depth: true,
                samples,
                buffers: &[],
            }
            .pipeline(device)
        };
        let back = Some(wgpu::Face::Back);
        Self {
            wheels: draw(shader::GALLERY, "wheel_vertex", "wheel_fragment", &groups, back),
            backdrop: draw(shader::SCENERY, "backdrop_vertex", "backdrop_fragment", &groups[..1], None),
        }
    }
}
