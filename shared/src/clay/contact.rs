//! Collision of a tool with the circular sector elements: which are touched, and how deep.
//!
//! Shared by all methods; what a touch does to the clay is theirs. Tools of facets are cut in `faceted`, a sphere's columns in `ball`.
//! Invariant: only rows and columns within the tool's reach are visited, and every touched element stands in exactly
//! one chunk.

use alloc::vec::Vec;
use core::ops::{Range, RangeFrom};

use glam::Vec3;

use super::ball::Ball;
use super::faceted::Cutter;
use super::lanes::{
    Eight, LANES, Select, Simd, SimdBase, SimdCvtTruncate, SimdFloat, SimdMask, counted, f32x8, i32x8, mask32x8, only,
    positive, root, splat, sum,
};
use super::rays::Rays;
use super::series::GivenWay;
use super::unbent::Unbent;
use super::{GridShape, Press, Support, Surface, Window};
use crate::tool::{Lattice, Side, Tool};

/// Height above the tool that stands for rows beyond the rim, m: farther than any tool reaches, and its square is finite.
const BEYOND_M: f32 = 1e6;

/// Eight neighbouring elements of a column.
#[derive(Clone, Copy, Debug)]
pub(super) struct Chunk {
    /// Depth p of the tool in the clay, m; zero where it does not touch.
    pub(super) penetration_m: Eight,
    /// Radius r of the elements, m.
    pub(super) radius_m: Eight,
    /// How the tool leans against the ray, across it and up: these parts of its normal over that along the ray, which counts as
    /// [`crate::tool::STEEPEST`] at least. Finite everywhere; only where it was asked for.
    pub(super) aside: Eight,
    pub(super) up: Eight,
}

impl Chunk {
    pub(super) const NONE: Self =
        Self { penetration_m: Eight::ZERO, radius_m: Eight::ZERO, aside: Eight::ZERO, up: Eight::ZERO };

    /// Where the tool touches.
    #[inline(always)]
    pub(super) fn touched<S: Simd>(&self, simd: S) -> mask32x8<S> {
        positive(self.penetration_m.on(simd))
    }
}

/// A column of which the tool touches something, and where its chunks lie: one beside the other from the first that is touched
/// to the last.
#[derive(Clone, Copy, Debug)]
pub(super) struct Column {
    /// Column in the grid, and row of the first lane: a multiple of [`LANES`].
    pub(super) column: u32,
    pub(super) first_row: u32,
    /// Angle from the tool to the column, rad.
    pub(super) angle_rad: f32,
    /// What of the column is looked at along that ray, from 0 to 1: see `covering`.
    pub(super) share: f32,
    /// Direction of the ray along which the tool is looked at.
    pub(super) cos: f32,
    pub(super) sin: f32,
    /// The tool's centre along the ray and across it, m.
    pub(super) along_m: f32,
    pub(super) aside_m: f32,
    /// Where its chunks stand, from the first to before the last; until they are found, how many are to be looked at.
    chunks: [u32; 2],
    /// Where the heights of its rows begin.
    heights: u32,
}

impl Column {
    /// A column of which some of a window's chunks are to be looked at: its angle from the tool, rad, the direction of its ray, and
    /// the tool's centre along and across it, m.
    pub(super) fn new(
        column: u32,
        window: Window,
        chunks: Range<u32>,
        angle_rad: f32,
        [cos, sin]: [f32; 2],
        [along_m, aside_m]: [f32; 2],
    ) -> Self {
        Self {
            column,
            first_row: window.first_row + chunks.start * LANES as u32,
            angle_rad,
            share: 1.0,
            cos,
            sin,
            along_m,
            aside_m,
            chunks: [0, chunks.end - chunks.start],
            heights: chunks.start,
        }
    }

    /// Where its chunks stand.
    pub(super) fn chunks(&self) -> Range<usize> {
        self.chunks[0] as usize..self.chunks[1] as usize
    }

    /// Where the heights of its chunks stand, and of those above.
    pub(super) fn heights(&self) -> RangeFrom<usize> {
        self.heights as usize..
    }

    /// The same column with some of its chunks alone, by their numbers from its first on, which stand at a place.
    pub(super) fn with_chunks(self, numbers: Range<u32>, at: u32) -> Self {
        let first_row = self.first_row + numbers.start * LANES as u32;
        let chunks = [at + numbers.start, at + numbers.end];
        Self { first_row, heights: self.heights + numbers.start, chunks, ..self }
    }

    /// The row after its last lane; beyond the rim when the grid ends within the last chunk.
    pub(super) fn end_row(&self) -> u32 {
        self.first_row + (self.chunks[1] - self.chunks[0]) * LANES as u32
    }
}

/// What is known of a column's contact.
#[derive(Clone, Copy)]
pub(super) struct Stretch<'a> {
    pub(super) column: &'a Column,
    pub(super) chunks: &'a [Chunk],
    /// Heights above the tool's centre, m: [`BEYOND_M`] beyond the rim.
    pub(super) above_m: &'a [Eight],
    /// See [`Contacts::facing`].
    pub(super) facing: &'a [[Eight; 3]],
}

impl<'a> Stretch<'a> {
    /// Chunks and their heights, foot to rim.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&'a Chunk, &'a Eight)> + use<'a> {
        self.chunks.iter().zip(self.above_m)
    }
}

/// The touched elements of one press.
#[derive(Clone, Debug, Default)]
pub(super) struct Contacts {
    columns: Vec<Column>,
    chunks: Chunks,
    /// Distance of the tool from the axis, m, and its angle, rad.
    pub(super) distance_m: f32,
    pub(super) angle_rad: f32,
    /// Number of touched elements, and the window that holds them.
    pub(super) elements: u32,
    pub(super) window: Window,
    /// Largest penetration, m.
    pub(super) deepest_m: f32,
    /// How far the tool reaches from its centre, m.
    pub(super) tool_m: f32,
    /// Whether the tool is one of facets, and then, unless it was asked how they lean, which way the clay pushes in chunks that are
    /// touched, along the ray, across it and up.
    is_faceted: bool,
    has_facing: bool,
    facing: Vec<[Eight; 3]>,
    /// Heights of the window's rows above the tool's centre, m.
    above_m: Vec<Eight>,
    /// As they were found, once a wall has given way.
    unbent: Unbent,
    pub(super) rays: Rays,
}

/// Room for chunks, of which the first few are in use; some belong to no column.
#[derive(Clone, Debug, Default)]
pub(super) struct Chunks {
    room: Vec<Chunk>,
    used: usize,
}

impl Chunks {
    /// Keeps the chunks that are found in a column, by their numbers from foot to rim, up to the last that is touched; the column
    /// with those from the first that is touched on, if one is. `found` writes a chunk and tells its penetrations, m.
    ///
    /// They are written in place: a call that could make room would cost more than what is found.
    #[inline(always)]
    pub(super) fn keep<S: Simd>(
        &mut self,
        column: &Column,
        mut found: impl FnMut(usize, &mut Chunk) -> f32x8<S>,
        tally: &mut Tally<S>,
    ) -> Option<Column> {
        let count = column.chunks().len();
        if self.room.len() < self.used + count {
            self.room.resize(self.used + count, Chunk::NONE);
        }
        let (mut first, mut end) = (usize::MAX, 0);
        for (number, room) in self.room[self.used..][..count].iter_mut().enumerate() {
            if tally.add(found(number, room), column.share) {
                first = first.min(number);
                end = number + 1;
            }
        }
        if end == 0 {
            return None;
        }
        let kept = column.with_chunks(first as u32..end as u32, self.used as u32);
        self.used += end;
        Some(kept)
    }
}

/// What is counted while elements are found.
pub(super) struct Tally<S: Simd> {
    /// Touched elements, lane by lane: whole numbers, which `f32` holds, but for those of which shares are.
    pub(super) elements: f32x8<S>,
    deepest_m: f32x8<S>,
}

impl<S: Simd> Tally<S> {
    #[inline(always)]
    pub(super) fn new(simd: S) -> Self {
        Self { elements: splat(simd, 0.0), deepest_m: splat(simd, 0.0) }
    }

    /// Whether any of eight penetrations touches.
    #[inline(always)]
    pub(super) fn add(&mut self, penetration_m: f32x8<S>, share: f32) -> bool {
        let touched = positive(penetration_m);
        self.elements += only(touched, splat(penetration_m.simd, share));
        self.deepest_m = self.deepest_m.max(penetration_m);
        touched.any_true()
    }
}

impl Contacts {
    /// Room for any press on `shape`.
    pub(super) fn with_room(shape: GridShape) -> Self {
        let chunks = shape.columns() as usize * (shape.rows() as usize).div_ceil(LANES);
        Self {
            columns: Vec::with_capacity(shape.columns() as usize),
            chunks: Chunks { room: Vec::with_capacity(chunks), used: 0 },
            above_m: Vec::with_capacity(shape.rows() as usize / LANES + 1),
            facing: Vec::with_capacity(chunks),
            unbent: Unbent::with_room(shape.columns() as usize, chunks),
            rays: Rays::with_room(shape),
            ..Self::default()
        }
    }

    /// The columns that are touched, with what is known of them, in order round the pot.
    pub(super) fn stretches(&self) -> impl Iterator<Item = Stretch<'_>> {
        self.columns.iter().map(|column| Stretch {
            column,
            chunks: &self.chunks.room[column.chunks()],
            above_m: &self.above_m[column.heights()],
            facing: if self.has_facing { &self.facing[column.chunks()] } else { &[] },
        })
    }

    /// How many chunks there are.
    pub(super) const fn found(&self) -> usize {
        self.chunks.used
    }

    /// The columns that are touched, in order round the pot.
    pub(super) fn columns(&self) -> &[Column] {
        &self.columns
    }

    /// Whether the tool is one of facets.
    pub(super) const fn is_faceted(&self) -> bool {
        self.is_faceted
    }

    /// Whether anything was found, and the largest penetration, m, before a wall gave way.
    pub(super) fn found_unbent(&self) -> (bool, f32) {
        if self.unbent.is_empty() {
            (!self.columns.is_empty(), self.deepest_m)
        } else {
            (true, self.unbent.deepest_m())
        }
    }

    /// Leaves of what was found what is still touched where a wall has given way, as often as it is asked how.
    #[inline(always)]
    pub(super) fn leave<S: Simd>(&mut self, simd: S, way: &GivenWay) {
        let chunks = &mut self.chunks.room[..self.chunks.used];
        if self.unbent.is_empty() {
            self.unbent.keep(simd, &self.columns, chunks);
            if way.depth_m <= 0.0 {
                return;
            }
        }
        let tally = self.unbent.leave(simd, way, &mut self.columns, chunks, &self.above_m);
        self.take(&tally);
    }

    #[inline(always)]
    pub(super) fn take<S: Simd>(&mut self, tally: &Tally<S>) {
        self.elements = libm::ceilf(sum(tally.elements)) as u32;
        self.deepest_m = tally.deepest_m.to_array().into_iter().fold(0.0, f32::max);
    }

    /// Adds a column of chunks, if any of them is touched, and gives those that it keeps; before they are found, its range says how
    /// many there are. `found` writes a chunk, by its number and its heights above the tool's centre, and tells its penetrations, m.
    #[inline(always)]
    pub(super) fn add_column<S: Simd>(
        &mut self,
        column: Column,
        mut found: impl FnMut(usize, &Eight, &mut Chunk) -> f32x8<S>,
        tally: &mut Tally<S>,
    ) -> Option<Column> {
        let Self { columns, chunks, above_m, .. } = self;
        let above_m = &above_m[column.heights()];
        let kept = chunks.keep(
            &column,
            #[inline(always)]
            |number, chunk| found(number, &above_m[number], chunk),
            tally,
        )?;
        columns.push(kept);
        Some(kept)
    }

    /// Where it stands which way the clay pushes in the chunks of a column: see [`Contacts::facing`].
    #[inline(always)]
    pub(super) fn facing_of(&mut self, column: &Column) -> &mut [[Eight; 3]] {
        let chunks = column.chunks();
        if self.facing.len() < chunks.end {
            self.facing.resize(chunks.end, [Eight::ZERO; 3]);
        }
        &mut self.facing[chunks]
    }

    /// Forgets what was found before something else is.
    pub(super) fn begin<const LEANS: bool>(&mut self, press: &Press) {
        self.columns.clear();
        self.chunks.used = 0;
        self.above_m.clear();
        self.unbent.clear();
        self.is_faceted = matches!(press.tool, Tool::Convex(_));
        self.has_facing = self.is_faceted && !LEANS;
        (self.elements, self.deepest_m, self.window) = (0, 0.0, Window::default());
    }

    /// Finds the elements that `press` touches, `behind_m` inside of the surface's radii; of a convex tool those that one of
    /// `cutter`'s does. How the tool leans is found with `LEANS` alone.
    #[inline(always)]
    pub(super) fn gather<S: Simd, const LEANS: bool>(
        &mut self,
        simd: S,
        surface: &Surface,
        press: &Press,
        behind_m: f32,
        cutter: Option<&mut Cutter>,
    ) {
        self.begin::<LEANS>(press);
        match (press.tool, cutter) {
            (Tool::Sphere(sphere), _) => {
                self.tool_m = sphere.radius().0;
                self.gather_sphere::<S, LEANS>(simd, surface, press, behind_m);
            }
            (Tool::Convex(shape), Some(cutter)) => {
                // a hair more, since two that know another widest radius, or another narrowest one, must find the same
                let reach_m = match press.side {
                    Side::Outside => surface.widest_m() + 1e-6,
                    Side::Inside => surface.narrowest_m() - behind_m - 1e-6,
                };
                // the published methods press whole columns, and what is left of a contact at a wall that gives way is not known yet
                let is_narrow = LEANS && surface.support() == Support::Backed;
                if !is_narrow || !self.gather_narrow(simd, surface, press, shape, [behind_m, reach_m], cutter) {
                    self.gather_facets::<S, LEANS, _>(simd, &mut &*surface, press, shape, [behind_m, reach_m], cutter);
                }
            }
            (Tool::Convex(_), None) => {}
        }
    }

    /// With a sphere (radius R) at H and an element (r, θ, z), `b = H·(cosθ, sinθ)`, `a` the tool's distance from the ray's
    /// plane, `h = √(R² − a² − (z − H_z)²)` half the ray's length in the sphere: the ray meets the sphere at `s₁,₂ = b ∓ h`.
    /// From outside the penetration is `p = r − s₁`, at most r; from inside `p = s₂ − r`.
    #[inline(always)]
    fn gather_sphere<S: Simd, const LEANS: bool>(&mut self, simd: S, surface: &Surface, press: &Press, behind_m: f32) {
        let reach = Reach::of(surface, press.centre_m, self.tool_m);
        (self.distance_m, self.angle_rad, self.window) = (reach.distance_m, reach.angle_rad, reach.window);
        let window = reach.window;
        if window.is_empty() {
            return;
        }
        self.fill_heights(simd, surface.shape().rows(), surface.row_height_m(), press.centre_m.z);
        self.list_columns(simd, surface, press, behind_m, &reach);
        let Self { columns, chunks, above_m, tool_m, .. } = self;
        let mut tally = Tally::new(simd);
        let ball = Ball { tool_m: *tool_m, side: press.side, behind_m };
        let mut touched = 0;
        for number in 0..columns.len() {
            let column = columns[number];
            let radii_m = &surface.column_m(column.column)[column.first_row as usize..];
            if let Some(kept) = ball.find::<S, LEANS>(&column, radii_m, &above_m[column.heights()], chunks, &mut tally)
            {
                columns[touched] = kept;
                touched += 1;
            }
        }
        columns.truncate(touched);
        self.take(&tally);
    }

    /// Adds a column of a sphere's, if it touches any of the chunks that are to be looked at; their radii, m.
    #[inline(always)]
    pub(super) fn add_ball<S: Simd>(&mut self, ball: &Ball, column: &Column, radii_m: &[f32], tally: &mut Tally<S>) {
        let Self { columns, chunks, above_m, .. } = self;
        columns.extend(ball.find::<S, true>(column, radii_m, &above_m[column.heights()], chunks, tally));
    }

    /// Lists the columns that a sphere may touch and the chunks that are to be looked at.
    ///
    /// It is a pass of its own, so that what is looked at does not wait for where it stands.
    #[inline(always)]
    fn list_columns<S: Simd>(&mut self, simd: S, surface: &Surface, press: &Press, behind_m: f32, reach: &Reach) {
        let (shape, window, centre, tool_m) = (surface.shape(), reach.window, press.centre_m, self.tool_m);
        let column_rad = shape.column_angle_rad();
        let rows_per_m = 1.0 / surface.row_height_m();
        let half_columns = (window.columns / 2) as i32;
        let (zero, lowest) = (splat(simd, 0.0), window.first_row as f32);
        let chunks = i32x8::splat(simd, window.rows.div_ceil(LANES as u32) as i32);
        let (ring, lanes) =
            (i32x8::splat(simd, shape.columns() as i32), i32x8::load_array(simd, [0, 1, 2, 3, 4, 5, 6, 7]));
        // no clay is wider or narrower, so that rows farther up or down cannot be met; a hair more, since two that know another widest
        // radius, or another narrowest one, must find the same
        let (outwards, last_m) = match press.side {
            Side::Outside => (1.0, surface.widest_m() + 1e-6),
            Side::Inside => (-1.0, surface.narrowest_m() - behind_m - 1e-6),
        };
        for local in (0..window.columns).step_by(LANES) {
            let columns = lanes + (window.first_column + local) as i32;
            let columns = columns.simd_lt(ring).select(columns, columns - ring).min(ring - 1);
            let [cos, sin] = directions(simd, surface, columns);
            let along_m = cos * centre.x + sin * centre.y;
            let aside_m = cos * centre.y - sin * centre.x;
            let apart_m = ((along_m - last_m) * outwards).max(zero);
            let half_chord_m2 = splat(simd, tool_m * tool_m) - aside_m * aside_m - apart_m * apart_m;
            let half_m = half_chord_m2.max(zero).sqrt();
            // a row more on both sides
            let chunk = |row: f32x8<S>| i32x8::truncate_from(row.max(zero) * (1.0 / LANES as f32)).min(chunks);
            let first = chunk((splat(simd, centre.z) - half_m) * rows_per_m - (lowest + 1.0));
            let end = chunk((half_m + centre.z) * rows_per_m + (1.0 + LANES as f32 - lowest)).max(first);
            let angles_rad = if window.columns == shape.columns() {
                let turned = |column: i32| nearest_turn(column as f32 * column_rad - reach.angle_rad);
                columns.to_array().map(turned)
            } else {
                let off = counted(simd, (local as i32 - half_columns) as f32);
                (off * column_rad - reach.off_column_rad).to_array()
            };
            let (columns, first, end) = (columns.to_array(), first.to_array(), end.to_array());
            let [cos, sin, along_m, aside_m] = [cos, sin, along_m, aside_m].map(|lanes| lanes.to_array());
            let half_chord_m2 = half_chord_m2.to_array();
            for lane in 0..LANES.min((window.columns - local) as usize) {
                // the tool passes the column by, or what there is of its rows
                if half_chord_m2[lane] <= 0.0 || first[lane] == end[lane] {
                    continue;
                }
                let chunks = first[lane] as u32..end[lane] as u32;
                let (direction, centre) = ([cos[lane], sin[lane]], [along_m[lane], aside_m[lane]]);
                self.columns.push(Column::new(
                    columns[lane] as u32,
                    window,
                    chunks,
                    angles_rad[lane],
                    direction,
                    centre,
                ));
            }
        }
    }

    /// Finds the element nearest to a tool that is smaller than an element and presses between the middles of all: it is
    /// touched by as much as the tool reaches beyond its radius.
    #[inline(always)]
    pub(super) fn gather_nearest<S: Simd>(&mut self, simd: S, surface: &Surface, press: &Press, behind_m: f32) {
        let tool_m = self.tool_m;
        let reach = Reach::of(surface, press.centre_m, tool_m);
        let column_rad = surface.shape().column_angle_rad();
        if tool_m > surface.row_height_m().max(column_rad * reach.distance_m) {
            return;
        }
        let row = libm::roundf(press.centre_m.z / surface.row_height_m());
        if row < 0.0 || row >= surface.shape().rows() as f32 {
            return;
        }
        let column = surface.shape().wrap(libm::roundf(reach.angle_rad / column_rad) as i64);
        let radius_m = surface.column_m(column)[row as usize];
        let penetration_m = match press.side {
            Side::Outside => (radius_m - reach.distance_m + tool_m).min(radius_m),
            Side::Inside => reach.distance_m + tool_m - (radius_m - behind_m),
        };
        if penetration_m <= 0.0 || penetration_m > 2.0 * tool_m {
            return;
        }
        let first_row = row as u32 / LANES as u32 * LANES as u32;
        let only = |value: f32, elsewhere: f32| {
            let mut lanes = [elsewhere; LANES];
            lanes[row as usize % LANES] = value;
            Eight(lanes)
        };
        let [cos, sin] = surface.direction(column);
        self.window = Window { first_column: column, columns: 1, first_row, rows: LANES as u32 };
        self.window.rows = self.window.rows.min(surface.shape().rows() - first_row);
        // rows that were looked at before are none of this one's
        self.above_m.clear();
        self.above_m.push(only(0.0, BEYOND_M));
        // its middle is straight ahead
        let chunk = Chunk { penetration_m: only(penetration_m, 0.0), radius_m: only(radius_m, 0.0), ..Chunk::NONE };
        let at = Column::new(column, self.window, 0..1, -reach.off_column_rad, [cos, sin], [reach.distance_m, 0.0]);
        let mut tally = Tally::new(simd);
        self.add_column(
            at,
            #[inline(always)]
            |_, _, room| {
                *room = chunk;
                chunk.penetration_m.on(simd)
            },
            &mut tally,
        );
        self.take(&tally);
    }

    /// Fills in the heights of the window's rows above a tool at a height, m.
    #[inline(always)]
    pub(super) fn fill_heights<S: Simd>(&mut self, simd: S, rows: u32, row_height_m: f32, tool_z: f32) {
        for row in (self.window.first_row..self.window.end_row()).step_by(LANES) {
            let numbers = counted(simd, row as f32);
            let above = numbers * row_height_m - tool_z;
            let within = numbers.simd_lt(splat(simd, rows as f32));
            self.above_m.push(within.select(above, splat(simd, BEYOND_M)).into());
        }
    }
}

/// Clay as a tool meets it: columns round the axis, and rows on them.
pub(super) trait Ground {
    fn lattice(&self) -> Lattice<'_>;
    /// Angle between columns, rad.
    fn column_rad(&self) -> f32;
    /// Radii of some rows of a column, and whatever is above them, m.
    fn radii_m(&mut self, column: u32, rows: Range<u32>) -> &[f32];
}

impl Ground for &Surface {
    fn lattice(&self) -> Lattice<'_> {
        Surface::lattice(self)
    }

    fn column_rad(&self) -> f32 {
        self.shape().column_angle_rad()
    }

    #[inline(always)]
    fn radii_m(&mut self, column: u32, rows: Range<u32>) -> &[f32] {
        &self.column_m(column)[rows.start as usize..]
    }
}

/// Cosines and sines of eight columns' angles.
#[inline(always)]
fn directions<S: Simd>(simd: S, surface: &Surface, columns: i32x8<S>) -> [f32x8<S>; 2] {
    let columns = columns.to_array();
    let turned: [[f32; 2]; LANES] = match surface.directions_from(columns[0] as u32) {
        Some(there) if columns[LANES - 1] > columns[0] => there.map(|direction| direction.to_array()),
        _ => columns.map(|column| surface.direction(column as u32)),
    };
    [0, 1].map(|axis| f32x8::load_array(simd, turned.map(|direction| direction[axis])))
}

/// Where the tool stands in the pot's cylindrical coordinates.
struct Reach {
    distance_m: f32,
    angle_rad: f32,
    /// The tool's angle beyond its nearest column, rad.
    off_column_rad: f32,
    window: Window,
}

impl Reach {
    /// The elements a sphere can touch: rows |z − H_z| ≤ R, from a multiple of [`LANES`] on, and columns
    /// |θ − φ| ≤ asin(R/d), all columns once it holds the axis. (The original used R/d, which leaves out grazed columns when
    /// the tool is near the axis.)
    ///
    /// The window is empty when the tool stands at no finite distance: comparisons with NaN would let every element pass.
    fn of(surface: &Surface, centre: Vec3, radius: f32) -> Self {
        let shape = surface.shape();
        let distance_m = root(centre.x * centre.x + centre.y * centre.y);
        let angle_rad = libm::atan2f(centre.y, centre.x);
        let first_row = libm::ceilf((centre.z - radius) / surface.row_height_m());
        let last_row = libm::floorf((centre.z + radius) / surface.row_height_m());
        let column = libm::roundf(angle_rad / shape.column_angle_rad());
        let half_columns = if distance_m > radius {
            libm::ceilf(libm::asinf(radius / distance_m) / shape.column_angle_rad()) as u32
        } else {
            shape.columns()
        };
        let window = if distance_m.is_finite() && centre.z.is_finite() {
            Window::around(shape, column as i64, half_columns, first_row as i64, last_row as i64)
                .aligned(shape.rows(), LANES as u32)
        } else {
            Window::default()
        };
        let off_column_rad = angle_rad - column * shape.column_angle_rad();
        Self { distance_m, angle_rad, off_column_rad, window }
    }
}

/// The same angle within half a turn of zero, of one that is no more than a turn and a half from it.
pub(super) fn nearest_turn(angle_rad: f32) -> f32 {
    use core::f32::consts::{PI, TAU};
    match angle_rad {
        beyond if beyond > PI => beyond - TAU,
        before if before < -PI => before + TAU,
        within => within,
    }
}

/// A vector given with the tool at angle zero, with the tool at its own angle.
pub(super) fn turned(vector: Vec3, angle_rad: f32) -> Vec3 {
    let (sin, cos) = libm::sincosf(angle_rad);
    Vec3::new(vector.x * cos - vector.y * sin, vector.x * sin + vector.y * cos, vector.z)
}
