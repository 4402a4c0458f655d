//! The section through the axis as SVG: the clay, its outer and inner wall, and a scale, in true size.
//!
//! Owns the sheet; where the walls lie is read from the pot's skins.
//! Invariant: one unit of the drawing is one millimetre.

use std::fmt::Write;

use pottery_shared::clay::{Pot, floor_row};
use pottery_shared::units::Metres;

/// Room about the drawing, and below it for the scale, mm.
const MARGIN_MM: f32 = 10.0;
const SCALE_MM: f32 = 14.0;
/// Length of the scale and of its parts, mm.
const BAR_MM: f32 = 50.0;
const PART_MM: f32 = 10.0;

/// A place on the sheet: to the right of the axis and above the wheel head, mm.
type Place = [f32; 2];

/// Both walls at one angle, from the foot or the floor up.
struct Side {
    outer: Vec<Place>,
    inner: Vec<Place>,
}

impl Side {
    /// How thick the wall is over the floor, row by row, mm.
    fn walls_mm(&self) -> impl Iterator<Item = f32> {
        let beside = self.outer.iter().rev().zip(self.inner.iter().rev());
        beside.map(|([outer_mm, _], [inner_mm, _])| (outer_mm - inner_mm).abs())
    }
}

/// The walls in one column, on the side of the axis that `sign` says.
fn side(pot: &Pot, column: u32, sign: f32) -> Side {
    let floor = floor_row(pot);
    let [outer, inner] = pot.skins().map(|skin| {
        let surface = &pot.surfaces()[skin.surface];
        let first = if skin.faces_outwards { 0 } else { floor };
        let place = |row: u32| {
            let radius_m = surface.column_m(column)[row as usize] - skin.inset_m;
            [sign * Metres(radius_m).as_mm(), Metres(surface.row_z_m(row)).as_mm()]
        };
        (first..surface.shape().rows()).map(place).collect()
    });
    Side { outer, inner }
}

/// Places as a path; the sheet's y runs downwards from the rim.
fn path<'a>(places: impl Iterator<Item = &'a Place>, height_mm: f32) -> String {
    let mut text = String::new();
    for (at, [x, z]) in places.enumerate() {
        let step = if at == 0 { 'M' } else { 'L' };
        write!(text, "{step}{x:.3} {:.3}", height_mm - z).expect("a text in memory can be written");
    }
    text
}

/// The drawing of the section at the angle of the first column.
pub(super) fn drawing(pot: &Pot) -> String {
    let columns = pot.spec().shape.columns();
    let (right, left) = (side(pot, 0, 1.0), side(pot, columns / 2, -1.0));
    let height_mm = Metres(pot.surfaces()[0].height_m()).as_mm();
    let widest_mm = [&right, &left].iter().flat_map(|side| &side.outer).map(|[x, _]| x.abs()).fold(0.0, f32::max);
    let walls_mm = [&right, &left].into_iter().flat_map(Side::walls_mm);
    let (thinnest_mm, thickest_mm) =
        walls_mm.fold((f32::INFINITY, 0.0_f32), |(least, most), wall_mm| (least.min(wall_mm), most.max(wall_mm)));
    let (half_mm, below_mm) = (widest_mm.max(0.5 * BAR_MM) + MARGIN_MM, height_mm + SCALE_MM + MARGIN_MM);
    let (width, height) = (2.0 * half_mm, below_mm + MARGIN_MM);
    let clay = left.outer.iter().chain(left.inner.iter().rev()).chain(&right.inner).chain(right.outer.iter().rev());
    let clay = path(clay, height_mm);
    // from rim to rim, over the foot and over the floor
    let outer = path(left.outer.iter().rev().chain(&right.outer), height_mm);
    let inner = path(left.inner.iter().rev().chain(&right.inner), height_mm);
    let title = format!(
        "Section of a pot, {height_mm:.1} mm high, {:.1} mm wide at most, wall {thinnest_mm:.1} to {thickest_mm:.1} mm",
        2.0 * widest_mm
    );
    let scale = scale(height_mm + SCALE_MM);
    format!(
        r##"<?xml version="1.0" encoding="UTF-8"?>
<svg xmlns="http://www.w3.org/2000/svg" width="{width:.3}mm" height="{height:.3}mm" viewBox="{:.3} {:.3} {width:.3} {height:.3}">
<title>{title}</title>
<rect x="{:.3}" y="{:.3}" width="{width:.3}" height="{height:.3}" fill="#ffffff"/>
<path id="clay" d="{clay}Z" fill="#d8b49a" stroke="none"/>
<path id="outer" d="{outer}" fill="none" stroke="#3a2a20" stroke-width="0.35"/>
<path id="inner" d="{inner}" fill="none" stroke="#3a2a20" stroke-width="0.35"/>
<path id="axis" d="M0 {:.3}L0 {:.3}" fill="none" stroke="#808080" stroke-width="0.2" stroke-dasharray="6 1.5 1 1.5"/>
{scale}</svg>
"##,
        -half_mm,
        -MARGIN_MM,
        -half_mm,
        -MARGIN_MM,
        -0.5 * MARGIN_MM,
        height_mm + 0.5 * MARGIN_MM,
    )
}

/// A bar with a mark every centimetre and its length in words, whose top is at `top_mm`.
fn scale(top_mm: f32) -> String {
    let mut text = String::from("<g id=\"scale\">\n");
    let parts = (BAR_MM / PART_MM) as u32;
    for part in 0..parts {
        let fill = if part % 2 == 0 { "#202020" } else { "#ffffff" };
        let x = -0.5 * BAR_MM + part as f32 * PART_MM;
        writeln!(
            text,
            r##"<rect x="{x}" y="{top_mm:.3}" width="{PART_MM}" height="1.5" fill="{fill}" stroke="#202020" stroke-width="0.2"/>"##
        )
        .expect("a text in memory can be written");
    }
    writeln!(
        text,
        r##"<text x="0" y="{:.3}" font-family="sans-serif" font-size="4" text-anchor="middle" fill="#202020">{BAR_MM} mm</text>"##,
        top_mm + 6.5
    )
    .expect("a text in memory can be written");
    text.push_str("</g>\n");
    text
}
