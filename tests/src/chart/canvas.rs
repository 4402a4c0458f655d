//! A sheet on which lines, marks and words are drawn, and the PNG file that it becomes.
//!
//! Owns the font, the palette and the pixels; knows no figures.
//! Invariant: the same drawing gives the same file on every machine: nothing asks a display or a graphics card.

use std::sync::Arc;

use egui::epaint::{Primitive, TextShape};
use egui::{
    Align2, Color32, Context, FontId, Galley, ImageData, LayerId, Painter, Pos2, RawInput, Rect, Shape, Stroke,
    TextureId, Vec2, pos2,
};

use super::raster::Pixels;

/// Colours that people with any kind of colour blindness tell apart (Okabe and Ito 2008), the strongest first.
pub(super) const PALETTE: [Color32; 7] = [
    Color32::from_rgb(0x00, 0x72, 0xB2),
    Color32::from_rgb(0xD5, 0x5E, 0x00),
    Color32::from_rgb(0x00, 0x9E, 0x73),
    Color32::from_rgb(0xCC, 0x79, 0xA7),
    Color32::from_rgb(0xE6, 0x9F, 0x00),
    Color32::from_rgb(0x56, 0xB4, 0xE9),
    Color32::from_rgb(0x7A, 0x5C, 0x3E),
];
/// Colours of words, of the frame, of the lines behind the figures and of the sheet.
pub(super) const INK: Color32 = Color32::from_rgb(0x20, 0x20, 0x20);
pub(super) const FRAME: Color32 = Color32::from_rgb(0x70, 0x70, 0x70);
pub(super) const FAINT: Color32 = Color32::from_rgb(0xE2, 0xE2, 0xE2);
pub(super) const PAPER: Color32 = Color32::WHITE;

/// Shape of a mark, so that colour is never the only difference.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Mark {
    Disc,
    Square,
    Triangle,
    Diamond,
    Cross,
    Ring,
    Wedge,
}

/// Marks in the order of [`PALETTE`].
pub(super) const MARKS: [Mark; 7] =
    [Mark::Disc, Mark::Square, Mark::Triangle, Mark::Diamond, Mark::Cross, Mark::Ring, Mark::Wedge];

/// A white sheet.
pub(super) struct Canvas {
    context: Context,
    painter: Painter,
    size: (usize, usize),
}

impl Canvas {
    /// A sheet of so many pixels.
    pub(super) fn new(width: usize, height: usize) -> Self {
        let context = Context::default();
        let rect = Rect::from_min_size(Pos2::ZERO, Vec2::new(width as f32, height as f32));
        context.begin_pass(RawInput { screen_rect: Some(rect), ..RawInput::default() });
        let painter = context.layer_painter(LayerId::background()).with_clip_rect(rect);
        Self { context, painter, size: (width, height) }
    }

    /// The whole sheet.
    pub(super) fn sheet(&self) -> Rect {
        self.painter.clip_rect()
    }

    fn laid_out(&self, text: &str, size: f32) -> Arc<Galley> {
        self.painter.layout_no_wrap(text.to_owned(), FontId::proportional(size), INK)
    }

    /// Room that words take.
    pub(super) fn size_of(&self, text: &str, size: f32) -> Vec2 {
        self.laid_out(text, size).size()
    }

    /// Words at a place; returns where they stand.
    pub(super) fn text(&self, at: Pos2, anchor: Align2, text: &str, size: f32, colour: Color32) -> Rect {
        self.painter.text(at, anchor, text, FontId::proportional(size), colour)
    }

    /// Words that read upwards, their middle at a place.
    pub(super) fn upright(&self, middle: Pos2, text: &str, size: f32) {
        let galley = self.laid_out(text, size);
        let corner = middle + Vec2::new(-galley.size().y, galley.size().x) * 0.5;
        self.painter.add(TextShape::new(corner, galley, INK).with_angle(-std::f32::consts::FRAC_PI_2));
    }

    fn broken(&self, width: f32, text: &str, size: f32) -> Arc<Galley> {
        self.painter.layout(text.to_owned(), FontId::proportional(size), INK, width)
    }

    /// Room that words take within a width.
    pub(super) fn paragraph_size(&self, width: f32, text: &str, size: f32) -> Vec2 {
        self.broken(width, text, size).size()
    }

    /// Words over several lines within a width.
    pub(super) fn paragraph(&self, at: Pos2, width: f32, text: &str, size: f32) {
        self.painter.galley(at, self.broken(width, text, size), INK);
    }

    /// A line through places, within a rectangle.
    pub(super) fn line(&self, points: Vec<Pos2>, stroke: Stroke, within: Rect) {
        self.painter.with_clip_rect(within).line(points, stroke);
    }

    /// A dashed line through places, within a rectangle.
    pub(super) fn dashed(&self, points: &[Pos2], stroke: Stroke, within: Rect) {
        self.painter.with_clip_rect(within).extend(Shape::dashed_line(points, stroke, 9.0, 6.0));
    }

    /// A frame without a filling.
    pub(super) fn frame(&self, rect: Rect) {
        self.painter.rect_stroke(rect, 0.0, Stroke::new(1.0, FRAME), egui::StrokeKind::Middle);
    }

    /// A mark with a white seam, so that lines behind it end visibly.
    pub(super) fn mark(&self, mark: Mark, at: Pos2, colour: Color32) {
        let seam = Stroke::new(1.2, PAPER);
        let corners = |corners: &[(f32, f32)]| -> Vec<Pos2> {
            corners.iter().map(|&(right, down)| pos2(at.x + right, at.y + down)).collect()
        };
        match mark {
            Mark::Disc => self.painter.circle(at, 6.5, colour, seam),
            Mark::Ring => self.painter.circle(at, 5.5, PAPER, Stroke::new(2.5, colour)),
            Mark::Cross => {
                self.painter.line_segment([at - Vec2::splat(5.0), at + Vec2::splat(5.0)], Stroke::new(3.0, colour));
                self.painter
                    .line_segment([at + Vec2::new(-5.0, 5.0), at + Vec2::new(5.0, -5.0)], Stroke::new(3.0, colour))
            }
            Mark::Square => self.polygon(corners(&[(-6.0, -6.0), (6.0, -6.0), (6.0, 6.0), (-6.0, 6.0)]), colour, seam),
            Mark::Triangle => self.polygon(corners(&[(0.0, -8.0), (7.5, 6.0), (-7.5, 6.0)]), colour, seam),
            Mark::Wedge => self.polygon(corners(&[(0.0, 8.0), (-7.5, -6.0), (7.5, -6.0)]), colour, seam),
            Mark::Diamond => self.polygon(corners(&[(0.0, -8.5), (8.5, 0.0), (0.0, 8.5), (-8.5, 0.0)]), colour, seam),
        };
    }

    /// A small dot.
    pub(super) fn dot(&self, at: Pos2, colour: Color32) {
        self.painter.circle_filled(at, 2.2, colour);
    }

    fn polygon(&self, corners: Vec<Pos2>, colour: Color32, seam: Stroke) -> egui::layers::ShapeIdx {
        self.painter.add(Shape::convex_polygon(corners, colour, seam))
    }

    /// The drawing as a PNG file's bytes.
    pub(super) fn into_png(self) -> Result<Vec<u8>, png::EncodingError> {
        let mut output = self.context.end_pass();
        let mut atlas = Pixels::filled(1, 1, Color32::WHITE);
        for delta in output.textures_delta.set.get(&TextureId::default()).into_iter().flatten() {
            let ImageData::Color(image) = &delta.image;
            // there was one pass, so the font's texture comes whole
            if delta.pos.is_none() {
                atlas = Pixels { width: image.width(), height: image.height(), colours: image.pixels.clone() };
            }
        }
        output.textures_delta.clear();
        let (width, height) = self.size;
        let mut pixels = Pixels::filled(width, height, PAPER);
        for clipped in self.context.tessellate(output.shapes, output.pixels_per_point) {
            if let Primitive::Mesh(mesh) = &clipped.primitive {
                pixels.draw(mesh, &atlas, clipped.clip_rect);
            }
        }
        let bytes: Vec<u8> = pixels.colours.iter().flat_map(|colour| [colour.r(), colour.g(), colour.b()]).collect();
        let mut file = Vec::new();
        let mut encoder = png::Encoder::new(&mut file, width as u32, height as u32);
        encoder.set_color(png::ColorType::Rgb);
        encoder.set_depth(png::BitDepth::Eight);
        encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
        encoder.set_compression(png::Compression::High);
        let mut writer = encoder.write_header()?;
        writer.write_image_data(&bytes)?;
        writer.finish()?;
        Ok(file)
    }
}
