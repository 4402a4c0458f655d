//! Triangles with colours and a texture, turned into pixels.
//!
//! What a graphics card would do, without one: pictures of figures have to be drawn on any machine.
//! Invariant: two triangles with a common edge never both cover a pixel on it, and never leave it out.

use egui::Color32;
use egui::epaint::{Mesh, Vertex};

/// Parts of a pixel to which corners are rounded, so that edges are exact.
const PARTS: f32 = 256.0;

/// An image of opaque or see-through colours, row by row from the top.
#[derive(Clone, Debug)]
pub(super) struct Pixels {
    pub(super) width: usize,
    pub(super) height: usize,
    pub(super) colours: Vec<Color32>,
}

impl Pixels {
    /// An image of one colour.
    pub(super) fn filled(width: usize, height: usize, colour: Color32) -> Self {
        Self { width, height, colours: vec![colour; width * height] }
    }

    /// Lays every triangle of a mesh over the image, within a rectangle of it.
    pub(super) fn draw(&mut self, mesh: &Mesh, texture: &Self, clip: egui::Rect) {
        for corners in mesh.indices.chunks_exact(3) {
            let corner = |at: usize| mesh.vertices[corners[at] as usize];
            self.triangle([corner(0), corner(1), corner(2)], texture, clip);
        }
    }

    fn triangle(&mut self, mut corners: [Vertex; 3], texture: &Self, clip: egui::Rect) {
        let mut points = corners.map(|corner| part_of(corner.pos));
        let mut area = edge(points[0], points[1], points[2]);
        if area == 0 {
            return;
        }
        if area < 0 {
            corners.swap(1, 2);
            points.swap(1, 2);
            area = -area;
        }
        let side = |low: f32, high: f32, least: f32, most: f32| {
            low.max(least).floor() as usize..high.min(most).ceil() as usize
        };
        let least = |of: fn(&Vertex) -> f32| corners.iter().map(of).fold(f32::INFINITY, f32::min);
        let most = |of: fn(&Vertex) -> f32| corners.iter().map(of).fold(f32::NEG_INFINITY, f32::max);
        let columns =
            side(least(|c| c.pos.x), most(|c| c.pos.x), clip.min.x.max(0.0), clip.max.x.min(self.width as f32));
        let rows = side(least(|c| c.pos.y), most(|c| c.pos.y), clip.min.y.max(0.0), clip.max.y.min(self.height as f32));
        for row in rows {
            for column in columns.clone() {
                let at = part_of(egui::pos2(column as f32 + 0.5, row as f32 + 0.5));
                let shares = [(1, 2), (2, 0), (0, 1)].map(|(from, to)| covered(points[from], points[to], at));
                if let [Some(first), Some(second), Some(third)] = shares {
                    let shares = [first, second, third].map(|share| share as f32 / area as f32);
                    let pixel = &mut self.colours[row * self.width + column];
                    *pixel = over(*pixel, colour(&corners, shares, texture));
                }
            }
        }
    }

    /// Colour at a place of the unit square, between the four nearest pixels.
    fn sample(&self, u: f32, v: f32) -> [f32; 4] {
        let place = |share: f32, side: usize| {
            let along = (share * side as f32 - 0.5).clamp(0.0, (side - 1) as f32);
            let low = along.floor() as usize;
            (low, (low + 1).min(side - 1), along - along.floor())
        };
        let (left, right, across) = place(u, self.width);
        let (top, bottom, down) = place(v, self.height);
        let at = |row: usize, column: usize| self.colours[row * self.width + column].to_array().map(f32::from);
        let between = |row: usize| {
            let (near, far) = (at(row, left), at(row, right));
            std::array::from_fn::<f32, 4, _>(|of| near[of] + (far[of] - near[of]) * across)
        };
        let (above, below) = (between(top), between(bottom));
        std::array::from_fn(|of| above[of] + (below[of] - above[of]) * down)
    }
}

/// A corner in parts of a pixel.
fn part_of(at: egui::Pos2) -> (i64, i64) {
    ((at.x * PARTS).round() as i64, (at.y * PARTS).round() as i64)
}

/// Twice the area of a triangle, positive when its corners go clockwise on the screen.
const fn edge(from: (i64, i64), to: (i64, i64), at: (i64, i64)) -> i64 {
    (to.0 - from.0) * (at.1 - from.1) - (to.1 - from.1) * (at.0 - from.0)
}

/// How far inside an edge a place lies; a place on the edge counts on the left and upper sides alone.
const fn covered(from: (i64, i64), to: (i64, i64), at: (i64, i64)) -> Option<i64> {
    let inside = edge(from, to, at);
    let upper_left = to.1 < from.1 || (to.1 == from.1 && to.0 > from.0);
    if inside > 0 || (inside == 0 && upper_left) { Some(inside) } else { None }
}

/// Colour of a triangle at the shares of its corners.
fn colour(corners: &[Vertex; 3], shares: [f32; 3], texture: &Pixels) -> Color32 {
    let mixed = |of: &dyn Fn(&Vertex) -> f32| -> f32 {
        corners.iter().zip(shares).map(|(corner, share)| of(corner) * share).sum()
    };
    let texel = texture.sample(mixed(&|corner| corner.uv.x), mixed(&|corner| corner.uv.y));
    let [red, green, blue, opacity] = std::array::from_fn(|of| {
        (mixed(&|corner| f32::from(corner.color.to_array()[of])) * texel[of] / 255.0).round() as u8
    });
    Color32::from_rgba_premultiplied(red, green, blue, opacity)
}

/// A colour laid over another, both multiplied by their opacity.
fn over(below: Color32, above: Color32) -> Color32 {
    let kept = f32::from(255 - above.a()) / 255.0;
    let (below, above) = (below.to_array(), above.to_array());
    let [red, green, blue, opacity] =
        std::array::from_fn(|of| (f32::from(above[of]) + f32::from(below[of]) * kept).round().min(255.0) as u8);
    Color32::from_rgba_premultiplied(red, green, blue, opacity)
}
