//! The transform on the processor: every position and normal anew for each picture, as the original system made them.
//!
//! Owns the vertices, their buffer and a plain way of drawing them; the studio's own transform is its vertex shader.
//! Invariant: after [`CpuTransform::transform`] vertex `column·rows + row` is element `[column][row]` of the pot's outer wall.

use glam::{Mat4, Vec3};
use pottery_client::render::Gpu;
use pottery_shared::clay::{GridShape, Pot, Surface};
use wgpu::util::DeviceExt;

const COLOUR: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
const DEPTH: wgpu::TextureFormat = wgpu::TextureFormat::Depth32Float;

/// What travels to the device for each element.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct Vertex {
    /// Where it stands in the pot's frame, m.
    pub position_m: [f32; 3],
    /// Away from the clay, of length one.
    pub normal: [f32; 3],
}

/// Transforms on the processor.
#[derive(Debug)]
pub struct CpuTransform {
    shape: GridShape,
    /// Cosine and sine of every column, so that no element costs a trigonometric function.
    columns: Vec<[f32; 2]>,
    vertices: Vec<Vertex>,
}

impl CpuTransform {
    /// For pots with such a grid.
    #[must_use]
    pub fn new(shape: GridShape) -> Self {
        let angle_rad = f64::from(shape.column_angle_rad());
        let column = |number| {
            let (sin, cos) = (f64::from(number) * angle_rad).sin_cos();
            [cos as f32, sin as f32]
        };
        Self {
            shape,
            columns: (0..shape.columns()).map(column).collect(),
            vertices: vec![Vertex::default(); shape.elements()],
        }
    }

    /// Positions and normals of every element of a pot's outer wall.
    ///
    /// `P = (r·cos θ, r·sin θ, z)`, `N ∝ r·e_r − ∂r/∂θ·e_θ − r·∂r/∂z·e_z`, with differences to both neighbours, to one at
    /// rim and foot.
    ///
    /// # Panics
    /// When the pot has another grid.
    pub fn transform(&mut self, pot: &Pot) -> &[Vertex] {
        let surface = &pot.surfaces()[pot.skins()[0].surface];
        assert_eq!(surface.shape(), self.shape);
        let rows = self.shape.rows() as usize;
        let columns = self.columns.len();
        let of = |column: usize| &surface.radii_m()[column * rows..(column + 1) * rows];
        let across = 0.5 / self.shape.column_angle_rad();
        for (column, ([cos, sin], vertices)) in
            self.columns.iter().zip(self.vertices.chunks_exact_mut(rows)).enumerate()
        {
            let (left, own, right) = (of((column + columns - 1) % columns), of(column), of((column + 1) % columns));
            transform_column(surface, [*cos, *sin], [left, own, right], across, vertices);
        }
        &self.vertices
    }
}

fn transform_column(
    surface: &Surface,
    [cos, sin]: [f32; 2],
    [left, own, right]: [&[f32]; 3],
    across: f32,
    vertices: &mut [Vertex],
) {
    let row_m = surface.row_height_m();
    let last = own.len() - 1;
    for (row, vertex) in vertices.iter_mut().enumerate() {
        let (below, above) = (row.saturating_sub(1), (row + 1).min(last));
        let radius_m = own[row];
        let by_angle = (right[row] - left[row]) * across;
        let by_height = (own[above] - own[below]) / ((above - below) as f32 * row_m);
        let [out, along, up] = [radius_m, -by_angle, -radius_m * by_height];
        let scale = 1.0 / (out * out + along * along + up * up).sqrt();
        let [out, along, up] = [out * scale, along * scale, up * scale];
        *vertex = Vertex {
            position_m: [radius_m * cos, radius_m * sin, row as f32 * row_m],
            normal: [out * cos - along * sin, out * sin + along * cos, up],
        };
    }
}

/// Draws what the processor transformed: the outer wall, in one light, and nothing else.
#[derive(Debug)]
pub struct PlainDrawing {
    pipeline: wgpu::RenderPipeline,
    group: wgpu::BindGroup,
    uniform: wgpu::Buffer,
    vertices: wgpu::Buffer,
    indices: wgpu::Buffer,
    index_count: u32,
    colour: wgpu::TextureView,
    depth: wgpu::TextureView,
}

impl PlainDrawing {
    /// For grids of such a shape and pictures of a size.
    #[must_use]
    pub fn new(gpu: &Gpu, shape: GridShape, (width, height): (u32, u32)) -> Self {
        let device = gpu.device();
        let view = |format| {
            let texture = device.create_texture(&wgpu::TextureDescriptor {
                label: Some("plain picture"),
                size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
                mip_level_count: 1,
                sample_count: 1,
                dimension: wgpu::TextureDimension::D2,
                format,
                usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
                view_formats: &[],
            });
            texture.create_view(&wgpu::TextureViewDescriptor::default())
        };
        let uniform = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("plain frame"),
            size: size_of::<[f32; 16]>() as u64,
            usage: wgpu::BufferUsages::UNIFORM | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let vertices = device.create_buffer(&wgpu::BufferDescriptor {
            label: Some("transformed vertices"),
            size: (shape.elements() * size_of::<Vertex>()) as u64,
            usage: wgpu::BufferUsages::VERTEX | wgpu::BufferUsages::COPY_DST,
            mapped_at_creation: false,
        });
        let triangles = triangles(shape);
        let indices = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
            label: Some("plain triangles"),
            contents: bytemuck::cast_slice(&triangles),
            usage: wgpu::BufferUsages::INDEX,
        });
        let pipeline = pipeline(device);
        let group = device.create_bind_group(&wgpu::BindGroupDescriptor {
            label: Some("plain frame"),
            layout: &pipeline.get_bind_group_layout(0),
            entries: &[wgpu::BindGroupEntry { binding: 0, resource: uniform.as_entire_binding() }],
        });
        let index_count = triangles.len() as u32;
        Self { pipeline, group, uniform, vertices, indices, index_count, colour: view(COLOUR), depth: view(DEPTH) }
    }

    /// Sends the vertices to the device and draws them; the commands are on their way when it returns.
    pub fn draw(&self, gpu: &Gpu, vertices: &[Vertex], clip_from_pot: Mat4) {
        gpu.queue().write_buffer(&self.uniform, 0, bytemuck::cast_slice(&clip_from_pot.to_cols_array()));
        gpu.queue().write_buffer(&self.vertices, 0, bytemuck::cast_slice(vertices));
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        {
            let mut pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                label: Some("plain"),
                color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                    view: &self.colour,
                    depth_slice: None,
                    resolve_target: None,
                    ops: wgpu::Operations {
                        load: wgpu::LoadOp::Clear(wgpu::Color::BLACK),
                        store: wgpu::StoreOp::Store,
                    },
                })],
                depth_stencil_attachment: Some(wgpu::RenderPassDepthStencilAttachment {
                    view: &self.depth,
                    depth_ops: Some(wgpu::Operations { load: wgpu::LoadOp::Clear(1.0), store: wgpu::StoreOp::Discard }),
                    stencil_ops: None,
                }),
                ..Default::default()
            });
            pass.set_pipeline(&self.pipeline);
            pass.set_bind_group(0, &self.group, &[]);
            pass.set_vertex_buffer(0, self.vertices.slice(..));
            pass.set_index_buffer(self.indices.slice(..), wgpu::IndexFormat::Uint32);
            pass.draw_indexed(0..self.index_count, 0, 0..1);
        }
        gpu.queue().submit([encoder.finish()]);
    }
}

/// Two triangles between four neighbours, round the seam as well.
fn triangles(shape: GridShape) -> Vec<u32> {
    let (columns, rows) = (shape.columns(), shape.rows());
    let mut indices = Vec::with_capacity(columns as usize * (rows as usize - 1) * 6);
    for column in 0..columns {
        let next = (column + 1) % columns;
        for row in 0..rows - 1 {
            let (left, right) = (column * rows + row, next * rows + row);
            indices.extend_from_slice(&[left, right, right + 1, left, right + 1, left + 1]);
        }
    }
    indices
}

fn pipeline(device: &wgpu::Device) -> wgpu::RenderPipeline {
    let module = device.create_shader_module(wgpu::include_wgsl!("transform.wgsl"));
    device.create_render_pipeline(&wgpu::RenderPipelineDescriptor {
        label: Some("plain"),
        layout: None,
        vertex: wgpu::VertexState {
            module: &module,
            entry_point: Some("vertex"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            buffers: &[Some(wgpu::VertexBufferLayout {
                array_stride: size_of::<Vertex>() as u64,
                step_mode: wgpu::VertexStepMode::Vertex,
                attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
            })],
        },
        primitive: wgpu::PrimitiveState { cull_mode: Some(wgpu::Face::Back), ..Default::default() },
        depth_stencil: Some(wgpu::DepthStencilState {
            format: DEPTH,
            depth_write_enabled: Some(true),
            depth_compare: Some(wgpu::CompareFunction::Less),
            stencil: wgpu::StencilState::default(),
            bias: wgpu::DepthBiasState::default(),
        }),
        multisample: wgpu::MultisampleState::default(),
        fragment: Some(wgpu::FragmentState {
            module: &module,
            entry_point: Some("fragment"),
            compilation_options: wgpu::PipelineCompilationOptions::default(),
            targets: &[Some(COLOUR.into())],
        }),
        multiview_mask: None,
        cache: None,
    })
}

impl Vertex {
    /// Where it stands, m.
    #[must_use]
    pub fn position(&self) -> Vec3 {
        Vec3::from_array(self.position_m)
    }

    /// Away from the clay.
    #[must_use]
    pub fn outwards(&self) -> Vec3 {
        Vec3::from_array(self.normal)
    }
}
