//! A picture of a pot without a window.
//!
//! Owns nothing between calls; every element is drawn, with four samples a pixel.

use pottery_shared::clay::Pot;

use super::readback::texels;
use super::{Gpu, PotRenderer, RenderError, Scene};

const SAMPLES: u32 = 4;

/// The scene as sRGB pixels, red, green, blue, opacity, row by row from the top.
///
/// # Errors
/// [`RenderError::Size`] when a side is zero or longer than the device allows; otherwise when the device was lost.
pub fn picture_rgba(
    gpu: &Gpu,
    pot: &Pot,
    scene: &Scene<'_>,
    width: u32,
    height: u32,
) -> Result<Vec<u8>, RenderError> {
    let max = gpu.device().limits().max_texture_dimension_2d;
    if width == 0 || height == 0 || width > max || height > max {
        return Err(RenderError::Size { width, height, max });
    }
    let format = wgpu::TextureFormat::Rgba8UnormSrgb;
    let target = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT | wgpu::TextureUsages::COPY_SRC,
        view_formats: &[],
    });
    let mut renderer = PotRenderer::new(gpu, format, SAMPLES, pot);
    renderer.set_vertex_px(0.0);
    let mut encoder =
        gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor { label: Some("picture") });
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    renderer.draw(&mut encoder, &view, (width, height), scene);
    gpu.queue().submit([encoder.finish()]);
    texels(gpu.device(), gpu.queue(), &target, 4)
}

/// The scene as a PNG file's bytes.
///
/// # Errors
/// As [`picture_rgba`], or when the pixels cannot be packed.
pub fn picture(gpu: &Gpu, pot: &Pot, scene: &Scene<'_>, width: u32, height: u32) -> Result<Vec<u8>, RenderError> {
    let pixels = picture_rgba(gpu, pot, scene, width, height)?;
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&pixels)?;
    writer.finish()?;
    Ok(file)
}
