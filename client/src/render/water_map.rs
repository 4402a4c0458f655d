//! The map of the water on the device.
//!
//! Owns its texture; what is wet is [`Water`]'s to say.
//! Invariant: it is sent again only when its picture changes.

use super::Water;

/// The texture, and what it holds.
#[derive(Debug)]
pub(super) struct WaterMap {
    texture: wgpu::Texture,
    pub(super) view: wgpu::TextureView,
    pub(super) filter: wgpu::Sampler,
    /// Of the water that it shows; none for wet all over.
    shown: Option<u64>,
    is_sent: bool,
}

impl WaterMap {
    pub(super) fn new(device: &wgpu::Device) -> Self {
        let texture = device.create_texture(&wgpu::TextureDescriptor {
            label: Some("water"),
            // as the radii lie: a row of the texture is a column of the pot
            size: wgpu::Extent3d { width: Water::ROWS as u32, height: Water::COLUMNS as u32, depth_or_array_layers: 1 },
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D2,
            format: wgpu::TextureFormat::R8Unorm,
            usage: wgpu::TextureUsages::TEXTURE_BINDING | wgpu::TextureUsages::COPY_DST,
            view_formats: &[],
        });
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        let filter = device.create_sampler(&wgpu::SamplerDescriptor {
            label: Some("water"),
            // rows end at foot and rim, columns go round
            address_mode_u: wgpu::AddressMode::ClampToEdge,
            address_mode_v: wgpu::AddressMode::Repeat,
            mag_filter: wgpu::FilterMode::Linear,
            min_filter: wgpu::FilterMode::Linear,
            ..Default::default()
        });
        Self { texture, view, filter, shown: None, is_sent: false }
    }

    /// Brings the texture up to date.
    pub(super) fn show(&mut self, queue: &wgpu::Queue, water: Option<&Water>) {
        let stamp = water.map(Water::stamp);
        if self.is_sent && stamp == self.shown {
            return;
        }
        (self.shown, self.is_sent) = (stamp, true);
        let texels = water.map_or_else(|| vec![255; Water::COLUMNS * Water::ROWS], Water::texels);
        queue.write_texture(
            self.texture.as_image_copy(),
            &texels,
            wgpu::TexelCopyBufferLayout { offset: 0, bytes_per_row: Some(Water::ROWS as u32), rows_per_image: None },
            self.texture.size(),
        );
    }
}
