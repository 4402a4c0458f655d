//! What a picture costs: vertices made by the processor, as the paper's original system did, against the studio's shader.
//!
//! Owns the pictures that are timed: a pot of which a 60th of a second's pressing has changed, seen as in the window.
//! Invariant: the ways of drawing take turns picture by picture, so that a disturbance of the machine meets all of them.

use std::fmt::Write;
use std::time::Instant;

use pottery_client::render::{Camera, Gpu, PotRenderer, Scene, Sharpness};
use pottery_shared::clay::{GridShape, MethodKind, Pot, Surface};
use pottery_shared::snapshot::Touched;

use super::canvas::INK;
use super::csv::{self, Cell, Row};
use super::machine::Machine;
use super::panel::{Axis, Look, Panel, Sign};
use super::pictures::{cell, sheet};
use super::speed::{Times, Walk};
use super::{ChartError, table1};
use crate::transform::{CpuTransform, PlainDrawing};

/// Columns and rows: 18,000 to 2.3 million elements.
const GRIDS: [(u32, u32); 5] = [(90, 200), (180, 400), (360, 400), (720, 800), (1440, 1600)];
/// Number of those that are drawn when time is short.
const GRIDS_QUICK: usize = 3;
/// Size of the pictures, pixels.
const SIZE: (u32, u32) = (1280, 720);
/// A picture on which nothing is to be seen: what is left of its time is the way of the vertices.
const SPECK: (u32, u32) = (1, 1);
/// Steps of the clay between two pictures.
const STEPS_A_PICTURE: u32 = 17;
/// Pictures that are drawn of each kind: so many elements' worth, but no fewer and no more.
const ELEMENTS: usize = 20_000_000;
const PICTURES: std::ops::RangeInclusive<usize> = 5..=60;
/// Pictures after which the studio has found how sharp they may be.
const SETTLING: usize = 48;
/// As far apart as vertices may be at most: hardly any.
const SPARSE_PX: f32 = 1e9;
const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;

/// The grids that are drawn.
#[must_use]
pub fn grids(quick: bool) -> Vec<GridShape> {
    let count = if quick { GRIDS_QUICK } else { GRIDS.len() };
    GRIDS[..count].iter().filter_map(|&(columns, rows)| GridShape::new(columns, rows).ok()).collect()
}

/// A way of drawing.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Way {
    /// The processor makes every vertex of the outer wall anew and sends it; one plain light.
    Processor,
    /// The studio: what changed is sent, the vertex shader makes every vertex of both walls.
    EveryElement,
    /// The studio as it comes: as many vertices as are to be seen, and where the processor draws, as many pixels as it is quick
    /// enough for.
    AsSeen,
}

impl Way {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Processor, Self::EveryElement, Self::AsSeen];

    /// In words.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Processor => "processor, as the original",
            Self::EveryElement => "ours, every element",
            Self::AsSeen => "ours, as seen",
        }
    }
}

/// Times of one way on one grid and adapter.
#[derive(Clone, Debug)]
pub struct TransformFigures {
    /// The adapter's name.
    pub adapter: String,
    /// The grid of the outer wall.
    pub grid: GridShape,
    /// How it was drawn.
    pub way: Way,
    /// Median of the time to make positions and normals, ms.
    pub transformation_ms: f64,
    /// The whole picture, until the device has finished it.
    pub total: Times,
}

/// Draws a pot on an adapter in every way, while it is pressed.
///
/// # Errors
/// [`ChartError`] when the pot cannot be made.
pub fn measure(gpu: &Gpu, grid: GridShape, quick: bool) -> Result<Vec<TransformFigures>, ChartError> {
    let mut walk = Walk::new(MethodKind::Plastic, grid)?;
    let pot = walk.pressing.pot().clone();
    let shapes = || pot.surfaces().iter().map(Surface::shape);
    let pictures = (ELEMENTS / grid.elements()).clamp(*PICTURES.start(), *PICTURES.end()) / if quick { 4 } else { 1 };
    let mut ways = [processor(gpu, grid), studio(gpu, &pot, Some(0.0)), studio(gpu, &pot, None)];
    let mut figures = ways.each_ref().map(|_| (Vec::new(), Vec::new()));
    for _ in 0..SETTLING {
        ways[2](walk.pressing.pot(), &Touched::none(shapes()));
    }
    // the first picture makes what is kept
    for picture in 0..pictures.max(2) + 1 {
        let mut touched = Touched::none(shapes());
        for _ in 0..STEPS_A_PICTURE {
            walk.step(|surface, window| touched.add_window(surface, window));
        }
        for (way, (transformation, total)) in ways.iter_mut().zip(&mut figures) {
            let [transformed, drawn] = way(walk.pressing.pot(), &touched);
            if picture > 0 {
                transformation.push(transformed);
                total.push(drawn);
            }
        }
    }
    let timed = Way::ALL.into_iter().zip(figures);
    Ok(timed
        .map(|(way, (transformation, total))| TransformFigures {
            adapter: gpu.name().to_owned(),
            grid,
            way,
            transformation_ms: Times::of(transformation).p50_us * 1e-3,
            total: Times::of(total),
        })
        .collect())
}

/// Draws a pot of which something changed; returns the times of transformation and of the whole, ns.
type Draw = Box<dyn FnMut(&Pot, &Touched) -> [f64; 2]>;

fn processor(gpu: &Gpu, grid: GridShape) -> Draw {
    let (gpu, mut transform, drawing) = (gpu.clone(), CpuTransform::new(grid), PlainDrawing::new(gpu, grid, SIZE));
    let clip_from_pot = Camera::default().view_projection(SIZE.0 as f32 / SIZE.1 as f32);
    Box::new(move |pot, _| {
        let begin = Instant::now();
        let vertices = transform.transform(pot);
        let transformed = begin.elapsed();
        drawing.draw(&gpu, vertices, clip_from_pot);
        finish(&gpu);
        [transformed, begin.elapsed()].map(|time| time.as_nanos() as f64)
    })
}

/// The studio's own renderer; its transformation is what a picture of one pixel takes with the changes sent and all vertices
/// made, less what it takes with neither.
fn studio(gpu: &Gpu, pot: &Pot, vertex_px: Option<f32>) -> Draw {
    let gpu = gpu.clone();
    let renderer = |vertex_px: Option<f32>| {
        let mut renderer = PotRenderer::new(&gpu, FORMAT, 1, pot);
        if let Some(vertex_px) = vertex_px {
            renderer.set_vertex_px(vertex_px);
        }
        renderer
    };
    let (mut whole, mut sparse) = (renderer(vertex_px), renderer(Some(SPARSE_PX)));
    // its stride is that of the large picture, which a picture of one pixel would not choose by itself
    let smaller = speck_to_sheet();
    let as_seen_px = if gpu.is_software() { PotRenderer::VERTEX_PX_SOFTWARE } else { PotRenderer::VERTEX_PX };
    let mut speck = renderer(vertex_px.or(Some(smaller * as_seen_px)));
    speck.set_outline_px(smaller * PotRenderer::OUTLINE_PX);
    // the studio as it comes, where the processor draws
    let mut sharpness = (vertex_px.is_none() && gpu.is_software()).then(Sharpness::default);
    let (sheet, dot) = (target(&gpu, SIZE), target(&gpu, SPECK));
    Box::new(move |pot, touched| {
        let timed = |renderer: &mut PotRenderer, target: &wgpu::TextureView, size, sends: bool| {
            let begin = Instant::now();
            if sends {
                renderer.upload_changed(pot, touched);
            }
            let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            renderer.draw(&mut encoder, target, size, &Scene::default());
            gpu.queue().submit([encoder.finish()]);
            finish(&gpu);
            begin.elapsed().as_nanos() as f64
        };
        let nothing = timed(&mut sparse, &dot, SPECK, false);
        let transformed = timed(&mut speck, &dot, SPECK, true) - nothing;
        let drawn = timed(&mut whole, &sheet, SIZE, true);
        if let Some(sharpness) = &mut sharpness {
            sharpness.note(drawn as f32 * 1e-6);
            whole.set_share(sharpness.share());
        }
        [transformed.max(0.0), drawn]
    })
}

/// By how much smaller a picture of one pixel's height shows things than the large one.
fn speck_to_sheet() -> f32 {
    // a square picture has a wider angle of view
    let camera = Camera::default();
    let narrower = camera.half_height(SIZE.0 as f32 / SIZE.1 as f32) / camera.half_height(1.0);
    narrower * SPECK.1 as f32 / SIZE.1 as f32
}

fn target(gpu: &Gpu, (width, height): (u32, u32)) -> wgpu::TextureView {
    let texture = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("timed picture"),
        size: wgpu::Extent3d { width, height, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format: FORMAT,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    texture.create_view(&wgpu::TextureViewDescriptor::default())
}

/// Waits until the device has done everything.
fn finish(gpu: &Gpu) {
    gpu.device().poll(wgpu::PollType::wait_indefinitely()).expect("the device is there while it is measured");
}

impl Row for TransformFigures {
    const COLUMNS: &'static [&'static str] = &[
        "adapter",
        "columns",
        "rows",
        "elements",
        "way",
        "transformation_p50_ms",
        "total_p50_ms",
        "total_p99_ms",
        "pictures_a_second_hz",
        "pictures",
    ];

    fn cells(&self) -> Vec<Cell> {
        vec![
            self.adapter.replace(',', ";").as_str().into(),
            self.grid.columns().into(),
            self.grid.rows().into(),
            Cell::Count(self.grid.elements() as u64),
            self.way.title().replace(',', ":").as_str().into(),
            self.transformation_ms.into(),
            (self.total.p50_us * 1e-3).into(),
            (self.total.p99_us * 1e-3).into(),
            (1e6 / self.total.p50_us).into(),
            self.total.steps.into(),
        ]
    }
}

/// Every file: name and bytes.
///
/// # Errors
/// [`ChartError::Picture`] when the picture cannot be packed.
pub fn files(figures: &[TransformFigures], machine: &Machine) -> Result<Vec<(&'static str, Vec<u8>)>, ChartError> {
    Ok(vec![
        ("transform.csv", csv::text(figures).into()),
        ("transform.md", page(figures, machine).into()),
        (PICTURE, picture(figures, machine)?),
    ])
}

/// The table, with the paper's beside it.
#[must_use]
pub fn page(figures: &[TransformFigures], machine: &Machine) -> String {
    let mut page = String::from("# From radii to a picture\n\n");
    let here = format!("A pot that is being pressed, 1280 × 720, on {}. Medians, ms.\n\n", machine.sentence());
    page.push_str(&here);
    page.push_str("| adapter | grid | way | transformation | whole picture | p99 | pictures a second |\n|---|---|---|---|---|---|---|\n");
    for TransformFigures { adapter, grid, way, transformation_ms, total } in figures {
        let row = writeln!(
            page,
            "| {adapter} | {} × {} | {} | {transformation_ms:.3} | {:.3} | {:.3} | {:.0} |",
            grid.columns(),
            grid.rows(),
            way.title(),
            total.p50_us * 1e-3,
            total.p99_us * 1e-3,
            1e6 / total.p50_us
        );
        row.expect("writing to a string does not fail");
    }
    page.push_str("\nAs published for 144,000 elements (Pentium 4 at 3.2 GHz, GeForce 8800 GTS), the pressing itself included, mean:\n\n");
    page.push_str("| | transformation | total | pictures a second |\n|---|---|---|---|\n");
    for (title, [transformation_ms, total_ms], hz) in table1::published() {
        let row = writeln!(page, "| {title} | {transformation_ms} | {total_ms} | {hz} |");
        row.expect("writing to a string does not fail");
    }
    page.push_str(NOTES);
    page
}

/// What has to be known to read the table.
const NOTES: &str = "
- The processor's way transforms the outer wall alone, in one thread, and draws it in one plain light; ours draws both walls,
  rim, floor, wheel and pan with the whole light of the studio. So ours has more to do in the whole picture.
- Ours: *transformation* is the time in which what changed is sent, its slopes are made and the vertices are, measured as a picture
  of one pixel less one with neither, until the device has finished. Where the processor draws, that is its time as well.
- Ours *as seen* draws as many vertices as can be told apart, so that no outline is off by more than half a pixel, and where the processor draws, as many pixels as it can in 22 ms,
  enlarged to the picture.
- The device is waited for after each picture; a studio does not wait, so that on a graphics card it draws more a second.
";

const PICTURE: &str = "transform.png";

fn picture(figures: &[TransformFigures], machine: &Machine) -> Result<Vec<u8>, ChartError> {
    let mut entries: Vec<(Sign, String)> = Vec::new();
    for (row, way) in Way::ALL.into_iter().enumerate() {
        entries.push((Sign::Marked(Look::of_row(row)), format!("{}: whole picture", way.title())));
        entries.push((Sign::Dashed(Look::of_row(row).colour), "its transformation".to_owned()));
    }
    entries.push((Sign::Dots(INK), "the paper's Table I: totals above, transformations below".to_owned()));
    let (canvas, room) = sheet(
        "From radii to a picture of 1280 × 720: lower is better",
        &entries,
        &format!(
            "The processor makes the outer wall's vertices alone and draws them plainly; ours makes those of both walls and draws the \
             whole studio. {}",
            machine.sentence()
        ),
    );
    let mut adapters: Vec<&str> = figures.iter().map(|of| of.adapter.as_str()).collect();
    adapters.dedup();
    let published = table1::published();
    let times = figures.iter().flat_map(|of| [of.transformation_ms, of.total.p50_us * 1e-3]);
    let all: Vec<f64> = times.chain(published.iter().flat_map(|(_, times, _)| *times)).collect();
    for (column, adapter) in adapters.iter().enumerate() {
        let x = Axis::log("elements of the outer wall", figures.iter().map(|of| of.grid.elements() as f64));
        let y = Axis::log(if column == 0 { "time, ms" } else { "" }, all.iter().copied());
        let panel = Panel::new(&canvas, cell(room, (column, adapters.len()), (0, 1)), adapter, x, y);
        for (row, way) in Way::ALL.into_iter().enumerate() {
            let own = || figures.iter().filter(|of| of.adapter == *adapter && of.way == way);
            let line = |of: &dyn Fn(&TransformFigures) -> f64| -> Vec<[f64; 2]> {
                own().map(|figures| [figures.grid.elements() as f64, of(figures)]).collect()
            };
            let total = line(&|of| of.total.p50_us * 1e-3);
            panel.line(&total, Look::of_row(row).colour, 2.5);
            panel.marks(&total, Look::of_row(row));
            panel.dashed(&line(&|of| of.transformation_ms), Look::of_row(row).colour, 2.0);
        }
        let paper = published.iter().flat_map(|(_, times, _)| times.map(|ms| [GridShape::PAPER.elements() as f64, ms]));
        panel.dots(&paper.collect::<Vec<_>>(), INK);
    }
    canvas.into_png().map_err(|source| ChartError::Picture { name: PICTURE, source })
}
