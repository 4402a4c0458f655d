//! Convex tools on the device: the corners of their facets, each with its facet's normal.
//!
//! Knows no place and no person: which tool stands where is the frame's affair.
//! Invariant: a tool is sent once; a rack only becomes longer.

use bytemuck::{Pod, Zeroable};
use pottery_shared::tool::{ConvexTool, Shape};
use wgpu::util::DeviceExt;

/// A corner of a facet as `facet_vertex` of `tool.wgsl` takes it.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
struct Corner {
    from_centre_m: [f32; 3],
    normal: [f32; 3],
}

/// How corners lie in their buffer.
pub(super) const CORNERS: wgpu::VertexBufferLayout<'static> = wgpu::VertexBufferLayout {
    array_stride: size_of::<Corner>() as u64,
    step_mode: wgpu::VertexStepMode::Vertex,
    attributes: &wgpu::vertex_attr_array![0 => Float32x3, 1 => Float32x3],
};

/// One tool's corners.
#[derive(Debug)]
pub(super) struct Solid {
    pub(super) corners: wgpu::Buffer,
    pub(super) count: u32,
}

/// The tools of a rack.
#[derive(Debug, Default)]
pub(super) struct Solids(Vec<Solid>);

impl Solids {
    /// Sends the tools that are not there yet.
    pub(super) fn complete(&mut self, device: &wgpu::Device, rack: &[ConvexTool]) {
        for tool in rack.iter().skip(self.0.len()) {
            let facets = tool.triangles_m().zip(tool.normals());
            let corners: Vec<Corner> = facets
                .flat_map(|(triangle, normal)| {
                    triangle.map(|corner| Corner { from_centre_m: corner.to_array(), normal: normal.to_array() })
                })
                .collect();
            let buffer = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("tool"),
                contents: bytemuck::cast_slice(&corners),
                usage: wgpu::BufferUsages::VERTEX,
            });
            self.0.push(Solid { corners: buffer, count: corners.len() as u32 });
        }
    }

    /// A tool, if it is there.
    pub(super) fn tool(&self, shape: Shape) -> Option<&Solid> {
        self.0.get(usize::from(shape.0))
    }
}
