//! Which elements of a skin become vertices, and the triangles between them.
//!
//! Owns the stride rule and the index buffers; the vertices themselves follow from their index in the shader.
//! Invariant: the first column closes the ring as a vertex of its own, and the last row is always a vertex.

use pottery_shared::clay::GridShape;
use wgpu::util::DeviceExt;

/// Every n-th column and row of a grid is a vertex.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Stride {
    pub(super) columns: u32,
    pub(super) rows: u32,
}

impl Stride {
    /// All of them.
    pub(super) const FULL: Self = Self { columns: 1, rows: 1 };
    /// Widest stride over rows, and of columns twice as wide: what may be left out is for the outline to say.
    const ROWS_MAX: u32 = 16;
    /// Columns may lie this much further apart than rows: a chord of 4° leaves a circle of 60 mm by 37 µm only,
    /// while grooves run round the pot and show in its outline row by row.
    const COLUMN_SHARE: f32 = 2.0;

    /// The largest stride, of powers of two, whose vertices lie at most `vertex_px` apart on a screen that shows a
    /// metre as `px_per_m`, and whose mesh misses the surface by no more than `missed_max_px`; of two as large, the one that
    /// keeps more rows. `missed_m` says what a stride misses.
    pub(super) fn for_screen(
        px_per_m: f32,
        [column_m, row_m]: [f32; 2],
        vertex_px: f32,
        missed_max_px: f32,
        missed_m: impl Fn(Self) -> f32,
    ) -> Self {
        let widest = |element_m: f32, limit_px: f32, max: u32| {
            let mut stride = 1;
            while stride < max && 2.0 * stride as f32 * element_m * px_per_m <= limit_px {
                stride *= 2;
            }
            stride
        };
        let columns = widest(column_m, Self::COLUMN_SHARE * vertex_px, 2 * Self::ROWS_MAX);
        let rows = widest(row_m, vertex_px, Self::ROWS_MAX);
        let powers = |most: u32| (0..=most.ilog2()).map(|power| 1 << power);
        powers(columns)
            .flat_map(|columns| powers(rows).map(move |rows| Self { columns, rows }))
            .filter(|stride| missed_m(*stride) * px_per_m <= missed_max_px)
            .max_by_key(|stride| (stride.columns * stride.rows, stride.columns))
            .unwrap_or(Self::FULL)
    }
}

/// Triangles over one skin at one stride.
#[derive(Debug)]
pub(super) struct Mesh {
    shape: GridShape,
    first_row: u32,
    stride: Stride,
    pub(super) indices: wgpu::Buffer,
    pub(super) index_count: u32,
}

/// The meshes made so far.
#[derive(Debug, Default)]
pub(super) struct Meshes {
    meshes: Vec<Mesh>,
}

impl Meshes {
    /// Number in here of the mesh over rows `first_row..` of a grid; makes it when it is new.
    pub(super) fn find(&mut self, device: &wgpu::Device, shape: GridShape, first_row: u32, stride: Stride) -> usize {
        let known = |mesh: &Mesh| mesh.shape == shape && mesh.first_row == first_row && mesh.stride == stride;
        self.meshes.iter().position(known).unwrap_or_else(|| {
            let triangles = triangles(shape, first_row, stride);
            let indices = device.create_buffer_init(&wgpu::util::BufferInitDescriptor {
                label: Some("skin mesh"),
                contents: bytemuck::cast_slice(&triangles),
                usage: wgpu::BufferUsages::INDEX,
            });
            self.meshes.push(Mesh { shape, first_row, stride, indices, index_count: triangles.len() as u32 });
            self.meshes.len() - 1
        })
    }

    pub(super) fn mesh(&self, number: usize) -> &Mesh {
        &self.meshes[number]
    }
}

/// Vertices of a skin along one column.
pub(super) const fn mesh_rows(shape: GridShape, first_row: u32, stride: Stride) -> u32 {
    (shape.rows() - 1 - first_row).div_ceil(stride.rows) + 1
}

/// Vertices of a skin round the pot, the first counted again at the end.
pub(super) const fn mesh_columns(shape: GridShape, stride: Stride) -> u32 {
    shape.columns().div_ceil(stride.columns) + 1
}

/// Counter-clockwise as seen from outside.
fn triangles(shape: GridShape, first_row: u32, stride: Stride) -> Vec<u32> {
    let rows = mesh_rows(shape, first_row, stride);
    let columns = mesh_columns(shape, stride);
    let mut indices = Vec::with_capacity((columns as usize - 1) * (rows as usize - 1) * 6);
    for column in 0..columns - 1 {
        for row in 0..rows - 1 {
            let (left, right) = (column * rows + row, (column + 1) * rows + row);
            indices.extend_from_slice(&[left, right, right + 1, left, right + 1, left + 1]);
        }
    }
    indices
}
