//! A picture of a pot without a window.
//!
//! Owns nothing between calls; every element is drawn, with four samples a pixel.

use pottery_shared::clay::Pot;

use super::{Gpu, PotRenderer, RenderError, Scene};

const SAMPLES: u32 = 4;

/// The scene as sRGB pixels, red, green, blue, opacity, row by row from the top.
///
/// # Errors
/// [`RenderError::Size`] when a side is zero or longer than the device allows; otherwise when the device was lost.
pub fn picture_rgba(gpu: &Gpu, pot: &Pot, scene: &Scene<'_>, width: u32, height: u32) -> Result<Vec<u8>, RenderError> {
    let mut renderer = PotRenderer::new(gpu, wgpu::TextureFormat::Rgba8UnormSrgb, SAMPLES, pot);
    renderer.set_vertex_px(0.0);
    renderer.pixels(scene, width, height)
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
