//! The map of a wall's deflection on the device.
//!
//! Owns its texture; how far the wall has given way is [`Deflection`]'s to say.
//! Invariant: it is sent again only when its picture changes, and not at all while nothing gives way.

use super::Deflection;

/// The texture, and what it holds.
#[derive(Debug)]
pub(super) struct DeflectionMap {
    texture: wgpu::Texture,
    pub(super) view: wgpu::TextureView,
    /// Of the deflection that it shows.
    shown: Option<u64>,
}

impl DeflectionMap {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("deflection"),
            // as the radii lie: a row of the texture is a column of the pot
            size: wgpu::Extent3d {
                width: Deflection::ROWS as u32,
                height: Deflection::COLUMNS as u32,
                depth_or_array_layers: 1,
            },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::Rgba32Float,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Self { texture, view, shown: None }
    }

    /// Brings the texture up to date.
    pub(super) fn show(&mut self, queue: &wgpu::Queue, deflection: Option<&Deflection>) {
        let Some(deflection) = deflection.filter(|deflection| deflection.is_any()) else { return };
        if self.shown.replace(deflection.stamp()) == Some(deflection.stamp()) {
            return;
        }
        let texels = deflection.texels();
        let bytes_per_row = (Deflection::ROWS * size_of_val(&texels[0])) as u32;
        queue.write_texture(
            self.texture.as_image_copy(),
            bytemuck::cast_slice(texels),
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(bytes_per_row), rows_per_image: None },
            self.texture.size(),
        );
    }
}
