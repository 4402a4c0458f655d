//! A pot that turns once round, as a GIF that repeats.
//!
//! Owns the number of pictures and their colours; the light stands still and the pot turns, as on a wheel.
//! Invariant: all pictures share one palette, so that nothing flickers.

use color_quant::NeuQuant;
use pottery_shared::clay::{Phase, Pot};

use super::{Camera, Gpu, PotRenderer, RenderError, Scene};

const SAMPLES: u32 = 4;
/// Pictures of a turn, and for how long each is shown, in hundredths of a second: a turn in 2.9 s.
const PICTURES: u32 = 36;
const SHOWN_CS: u16 = 8;
/// Pictures from which the palette is learned.
const LEARNED_FROM: u32 = 4;
/// Every n-th pixel is learned from: the best that is still quick, by the maker's scale of 1 to 30.
const LEARNING_STEP: i32 = 10;
const COLOURS: usize = 256;

/// The pot on its wheel, turning once, as the bytes of a GIF of `side_px` square.
///
/// # Errors
/// [`RenderError::Size`] when the side is zero or longer than device or format allow; otherwise when the device was lost.
pub fn turntable(gpu: &Gpu, pot: &Pot, side_px: u16) -> Result<Vec<u8>, RenderError> {
    let mut renderer = PotRenderer::new(gpu, wgpu::TextureFormat::Rgba8UnormSrgb, SAMPLES, pot);
    let camera = Camera::on(pot);
    let mut picture = |number: u32| {
        let turn = u64::from(number) * (1 << 32) / u64::from(PICTURES);
        let scene = Scene { camera, phase: Phase(turn as u32), ..Scene::default() };
        renderer.pixels(&scene, side_px.into(), side_px.into())
    };
    let mut pictures = Vec::new();
    for number in 0..PICTURES {
        pictures.push(picture(number)?);
    }
    let learned: Vec<u8> = pictures.iter().step_by((PICTURES / LEARNED_FROM) as usize).flatten().copied().collect();
    let mut palette = Palette::of(&learned);
    let mut file = Vec::new();
    let mut encoder = gif::Encoder::new(&mut file, side_px, side_px, &palette.colours.color_map_rgb())?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    for pixels in pictures {
        let indices: Vec<u8> = pixels.as_chunks::<4>().0.iter().map(|&pixel| palette.index(pixel)).collect();
        let mut frame = gif::Frame::from_indexed_pixels(side_px, side_px, indices, None);
        frame.delay = SHOWN_CS;
        encoder.write_frame(&frame)?;
    }
    drop(encoder);
    Ok(file)
}

/// The colours of all pictures, with what was looked up already.
struct Palette {
    colours: NeuQuant,
    /// By the upper six bits of red, green and blue.
    found: Vec<Option<u8>>,
}

impl Palette {
    fn of(pixels: &[u8]) -> Self {
        Self { colours: NeuQuant::new(LEARNING_STEP, COLOURS, pixels), found: vec![None; 1 << 18] }
    }

    fn index(&mut self, pixel: [u8; 4]) -> u8 {
        let [red, green, blue, _] = pixel.map(|part| usize::from(part >> 2));
        *self.found[red << 12 | green << 6 | blue].get_or_insert_with(|| self.colours.index_of(&pixel) as u8)
    }
}
