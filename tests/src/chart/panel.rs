//! One diagram: two axes with their units, lines, marks, and labels that keep clear of one another.
//!
//! Owns the way from a figure to a place on the sheet; knows no clay.
//! Invariant: a figure that has no place (not finite, or nothing on a logarithmic axis) is left out, never moved.

use egui::{Align2, Color32, Pos2, Rect, Stroke, Vec2, pos2};

use super::canvas::{Canvas, FAINT, FRAME, INK, MARKS, Mark, PALETTE};

const TICK_SIZE: f32 = 15.0;
const TITLE_SIZE: f32 = 17.0;
const LABEL_SIZE: f32 = 14.0;

/// How figures are laid along an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Scale {
    Linear,
    Log,
}

/// An axis: what it shows, in which unit, and from where to where.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    pub(super) title: String,
    pub(super) scale: Scale,
    pub(super) from: f64,
    pub(super) to: f64,
    /// Names of 0, 1 and so on, which are written instead of figures.
    names: Vec<String>,
}

impl Axis {
    /// A linear axis over a fixed stretch.
    pub(super) fn linear(title: &str, from: f64, to: f64) -> Self {
        Self { title: title.to_owned(), scale: Scale::Linear, from, to, names: Vec::new() }
    }

    /// An axis of names, the first at the top or on the right.
    pub(super) fn names(names: Vec<String>) -> Self {
        let ends = (names.len() as f64 - 0.5, -0.5);
        Self { names, ..Self::linear("", ends.0, ends.1) }
    }

    /// A logarithmic axis round all figures above zero, with room at both ends.
    pub(super) fn log(title: &str, figures: impl IntoIterator<Item = f64>) -> Self {
        let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
        for figure in figures.into_iter().filter(|figure| figure.is_finite() && *figure > 0.0) {
            (low, high) = (low.min(figure), high.max(figure));
        }
        let (from, to) = if high > 0.0 { (low / 1.6, high * 1.6) } else { (0.1, 10.0) };
        Self { title: title.to_owned(), scale: Scale::Log, from, to, names: Vec::new() }
    }

    /// Where a figure stands between the ends, 0 to 1 within them.
    fn share(&self, figure: f64) -> Option<f64> {
        let share = match self.scale {
            Scale::Linear => (figure - self.from) / (self.to - self.from),
            Scale::Log => (figure / self.from).ln() / (self.to / self.from).ln(),
        };
        share.is_finite().then_some(share)
    }

    /// Figures beside which something is written, and what.
    fn ticks(&self) -> Vec<(f64, String)> {
        if self.names.is_empty() {
            self.figures().into_iter().map(|figure| (figure, written(figure))).collect()
        } else {
            self.names.iter().enumerate().map(|(place, name)| (place as f64, name.clone())).collect()
        }
    }

    fn figures(&self) -> Vec<f64> {
        let step = |least: f64| {
            let power = 10_f64.powf(least.log10().floor());
            [1.0, 2.0, 5.0, 10.0].map(|of| of * power).into_iter().find(|step| *step >= least).unwrap_or(least)
        };
        match self.scale {
            Scale::Linear => {
                let step = step((self.to - self.from) / 7.0);
                let (first, last) = ((self.from / step).ceil() as i64, (self.to / step + 1e-9).floor() as i64);
                (first..=last).map(|number| number as f64 * step).collect()
            }
            Scale::Log => {
                let steps: &[f64] = if self.to / self.from > 2000.0 { &[1.0] } else { &[1.0, 2.0, 5.0] };
                let decades = self.from.log10().floor() as i32..=self.to.log10().ceil() as i32;
                let all = decades.flat_map(|decade| steps.iter().map(move |step| step * 10_f64.powi(decade)));
                all.filter(|tick| *tick >= self.from * 0.999 && *tick <= self.to * 1.001).collect()
            }
        }
    }
}

/// A figure as people write it, without digits that say nothing.
fn written(figure: f64) -> String {
    if figure != 0.0 && (figure.abs() >= 1e6 || figure.abs() < 1e-3) {
        return format!("{figure:.0e}");
    }
    let text = format!("{figure:.4}");
    let text = text.trim_end_matches('0').trim_end_matches('.');
    if text == "-0" { "0".to_owned() } else { text.replace('-', "−") }
}

/// What a line or a mark looks like.
#[derive(Clone, Copy, Debug)]
pub(super) struct Look {
    pub(super) colour: Color32,
    pub(super) mark: Mark,
}

impl Look {
    /// The look of a row of the table of methods.
    pub(super) const fn of_row(row: usize) -> Self {
        // beyond the palette a colour comes again with another mark
        Self { colour: PALETTE[row % PALETTE.len()], mark: MARKS[(row + row / PALETTE.len()) % MARKS.len()] }
    }
}

/// A diagram on a sheet.
pub(super) struct Panel<'a> {
    canvas: &'a Canvas,
    frame: Rect,
    x: Axis,
    y: Axis,
}

impl<'a> Panel<'a> {
    /// Draws the axes of a diagram within a part of the sheet.
    pub(super) fn new(canvas: &'a Canvas, within: Rect, heading: &str, x: Axis, y: Axis) -> Self {
        let top = if heading.is_empty() { 8.0 } else { 30.0 };
        let widths = y.ticks().into_iter().map(|(_, text)| canvas.size_of(&text, TICK_SIZE).x);
        let left = widths.fold(40.0, f32::max) + if y.title.is_empty() { 16.0 } else { 38.0 };
        let frame = Rect::from_min_max(within.min + Vec2::new(left, top), within.max - Vec2::new(14.0, 58.0));
        let panel = Self { canvas, frame, x, y };
        if !heading.is_empty() {
            canvas.text(pos2(frame.center().x, frame.min.y - 6.0), Align2::CENTER_BOTTOM, heading, TITLE_SIZE, INK);
        }
        let faint = Stroke::new(1.0, FAINT);
        for (tick, text) in panel.x.ticks() {
            let Some(at) = panel.place_x(tick) else { continue };
            canvas.line(vec![pos2(at, frame.min.y), pos2(at, frame.max.y)], faint, canvas.sheet());
            canvas.text(pos2(at, frame.max.y + 5.0), Align2::CENTER_TOP, &text, TICK_SIZE, INK);
        }
        for (tick, text) in panel.y.ticks() {
            let Some(at) = panel.place_y(tick) else { continue };
            canvas.line(vec![pos2(frame.min.x, at), pos2(frame.max.x, at)], faint, canvas.sheet());
            canvas.text(pos2(frame.min.x - 7.0, at), Align2::RIGHT_CENTER, &text, TICK_SIZE, INK);
        }
        canvas.frame(frame);
        let below = pos2(frame.center().x, frame.max.y + 28.0);
        canvas.text(below, Align2::CENTER_TOP, &panel.x.title, TITLE_SIZE, INK);
        canvas.upright(pos2(within.min.x + 14.0, frame.center().y), &panel.y.title, TITLE_SIZE);
        panel
    }

    fn place_x(&self, figure: f64) -> Option<f32> {
        Some(self.frame.min.x + self.x.share(figure)? as f32 * self.frame.width())
    }

    fn place_y(&self, figure: f64) -> Option<f32> {
        Some(self.frame.max.y - self.y.share(figure)? as f32 * self.frame.height())
    }

    /// Where a pair of figures stands; nothing when it has no place within the axes.
    fn place(&self, [x, y]: [f64; 2]) -> Option<Pos2> {
        let at = pos2(self.place_x(x)?, self.place_y(y)?);
        self.frame.expand(1.0).contains(at).then_some(at)
    }

    /// Places of a line, also beyond the frame, where it is cut.
    pub(super) fn places(&self, points: &[[f64; 2]]) -> Vec<Pos2> {
        let place = |point: &[f64; 2]| Some(pos2(self.place_x(point[0])?, self.place_y(point[1])?));
        points.iter().filter_map(place).collect()
    }

    /// A line through pairs of figures.
    pub(super) fn line(&self, points: &[[f64; 2]], colour: Color32, width: f32) {
        let places = self.places(points);
        if places.len() > 1 {
            self.canvas.line(places, Stroke::new(width, colour), self.frame);
        }
    }

    /// The same, dashed.
    pub(super) fn dashed(&self, points: &[[f64; 2]], colour: Color32, width: f32) {
        self.canvas.dashed(&self.places(points), Stroke::new(width, colour), self.frame);
    }

    /// A mark at each pair of figures.
    pub(super) fn marks(&self, points: &[[f64; 2]], look: Look) {
        for at in points.iter().filter_map(|point| self.place(*point)) {
            self.canvas.mark(look.mark, at, look.colour);
        }
    }

    /// Small dots, for figures that stand close together.
    pub(super) fn dots(&self, points: &[[f64; 2]], colour: Color32) {
        for at in points.iter().filter_map(|point| self.place(*point)) {
            self.canvas.dot(at, colour);
        }
    }
}

/// Labels beside points, none of which covers another.
pub(super) struct Labels<'a> {
    canvas: &'a Canvas,
    within: Rect,
    taken: Vec<Rect>,
}

impl<'a> Labels<'a> {
    /// Labels within a diagram.
    pub(super) const fn new(panel: &Panel<'a>) -> Self {
        Self { canvas: panel.canvas, within: panel.frame, taken: Vec::new() }
    }

    /// Keeps clear of marks.
    pub(super) fn spare_marks(&mut self, places: impl IntoIterator<Item = Pos2>) {
        self.taken.extend(places.into_iter().map(|at| Rect::from_center_size(at, Vec2::splat(15.0))));
    }

    /// Keeps clear of a line.
    pub(super) fn spare_line(&mut self, places: &[Pos2]) {
        for pair in places.windows(2) {
            let along = pair[1] - pair[0];
            let parts = (along.length() / 5.0).ceil().max(1.0);
            let place = |part: usize| pair[0] + along * (part as f32 / parts);
            self.taken.extend((0..=parts as usize).map(|part| Rect::from_center_size(place(part), Vec2::splat(4.0))));
        }
    }

    /// Writes a label as near a point as there is room, with a thin line to it when that is not beside it; leaves it out
    /// when there is none.
    pub(super) fn write(&mut self, at: Pos2, text: &str, colour: Color32) {
        let size = self.canvas.size_of(text, LABEL_SIZE);
        for away in [12.0, 20.0, 32.0, 46.0, 62.0] {
            for direction in [90, 270, 0, 180, 45, 135, 225, 315, 20, 160, 200, 340] {
                let (sin, cos) = f32::to_radians(direction as f32).sin_cos();
                let towards = Vec2::new(cos, sin);
                let middle = at + towards * away + Vec2::new(cos * size.x, sin * size.y) * 0.5;
                let rect = Rect::from_center_size(middle, size);
                let free = !self.taken.iter().any(|taken| taken.intersects(rect));
                if free && self.within.contains_rect(rect) {
                    if away > 20.0 {
                        let tip = vec![at + towards * 8.0, at + towards * away];
                        self.canvas.line(tip, Stroke::new(1.0, FRAME), self.within);
                    }
                    self.canvas.text(middle, Align2::CENTER_CENTER, text, LABEL_SIZE, legible(colour));
                    self.taken.push(rect.expand(2.0));
                    return;
                }
            }
        }
    }
}

/// A colour dark enough for words on white.
fn legible(colour: Color32) -> Color32 {
    let [red, green, blue, _] = colour.to_array().map(|part| (f32::from(part) * 0.75) as u8);
    Color32::from_rgb(red, green, blue)
}

/// What a legend says of a line.
pub(super) enum Sign {
    /// A mark on a line.
    Marked(Look),
    /// A line alone.
    Line(Color32),
    /// A dashed line.
    Dashed(Color32),
    /// Dots.
    Dots(Color32),
}

/// Writes signs and their meaning in rows below a place, as many to a row as there is room; returns where they end.
pub(super) fn legend(canvas: &Canvas, from: Pos2, width: f32, entries: &[(Sign, String)]) -> f32 {
    let (mut x, mut y) = (from.x, from.y);
    for (sign, text) in entries {
        let size = canvas.size_of(text, TITLE_SIZE);
        if x > from.x && x + 44.0 + size.x > from.x + width {
            (x, y) = (from.x, y + 26.0);
        }
        let ends = vec![pos2(x, y), pos2(x + 34.0, y)];
        let middle = pos2(x + 17.0, y);
        match sign {
            Sign::Marked(look) => {
                canvas.line(ends, Stroke::new(2.5, look.colour), canvas.sheet());
                canvas.mark(look.mark, middle, look.colour);
            }
            Sign::Line(colour) => canvas.line(ends, Stroke::new(2.5, *colour), canvas.sheet()),
            Sign::Dashed(colour) => canvas.dashed(&ends, Stroke::new(2.5, *colour), canvas.sheet()),
            Sign::Dots(colour) => [4.0, 17.0, 30.0].into_iter().for_each(|at| canvas.dot(pos2(x + at, y), *colour)),
        }
        canvas.text(pos2(x + 42.0, y), Align2::LEFT_CENTER, text, TITLE_SIZE, INK);
        x += 42.0 + size.x + 30.0;
    }
    y + 16.0
}
