//! The renderer against what it claims: its shaders, its transform, its uploads and its pictures.
//!
//! Draws with whatever adapter there is, in software where there is no other; without any, every test here that
//! draws fails and names the package to install.
#![expect(clippy::unwrap_used, reason = "an error here is a failed test")]

use std::path::Path;

use glam::{Quat, Vec2, Vec3};
use pottery_client::render::{
    Camera, Gpu, MODULES, PotRenderer, RenderError, Scene, Sharpness, ToolView, picture, picture_rgba, probe_skin,
};
use pottery_shared::clay::{GridShape, Phase, Pot, PotSpec, Skin, Window};
use pottery_shared::tool::{ConvexTool, Shape, Side, Tool, rack};

fn gpu() -> Gpu {
    Gpu::headless().unwrap_or_else(|error| panic!("{error}"))
}

/// r = r₀ + a cos 3θ + b sin kz: a pot with slopes both ways, known everywhere.
mod analytic {
    pub(super) const MEAN_M: f64 = 0.060;
    pub(super) const LOBES_M: f64 = 0.006;
    pub(super) const WAVES_M: f64 = 0.002;
    /// Two waves in 50 mm.
    pub(super) const WAVE_NUMBER: f64 = 2.0 * std::f64::consts::TAU / 0.050;

    pub(super) fn radius_m(angle: f64, z: f64) -> f64 {
        MEAN_M + LOBES_M * (3.0 * angle).cos() + WAVES_M * (WAVE_NUMBER * z).sin()
    }

    /// dr/dθ and dr/dz.
    pub(super) fn slopes(angle: f64, z: f64) -> (f64, f64) {
        (-3.0 * LOBES_M * (3.0 * angle).sin(), WAVES_M * WAVE_NUMBER * (WAVE_NUMBER * z).cos())
    }
}

/// The outward normal r e_r − (dr/dθ) e_θ − r (dr/dz) e_z of the analytic surface, `inset_m` in; any length.
fn analytic_normal(angle: f64, z: f64, inset_m: f64) -> [f64; 3] {
    let radius = analytic::radius_m(angle, z) - inset_m;
    let (around, upwards) = analytic::slopes(angle, z);
    let (sin, cos) = angle.sin_cos();
    [radius * cos + around * sin, radius * sin - around * cos, -radius * upwards]
}

fn length([x, y, z]: [f64; 3]) -> f64 {
    (x * x + y * y + z * z).sqrt()
}

/// The angle between two directions; the arc tangent keeps its precision where it is small, unlike the arc cosine.
fn angle_between_deg(one: [f64; 3], other: [f64; 3]) -> f64 {
    let along: f64 = one.iter().zip(&other).map(|(one, other)| one * other).sum();
    let part = |i: usize, j: usize| one[i] * other[j] - one[j] * other[i];
    length([part(1, 2), part(2, 0), part(0, 1)]).atan2(along).to_degrees()
}

fn shaped_pot(shape: GridShape, radius_m: impl Fn(f64, f64) -> f64) -> Pot {
    let mut pot = Pot::new(PotSpec { shape, ..PotSpec::default() }).unwrap();
    for surface in pot.surfaces_mut() {
        for column in 0..shape.columns() {
            for row in 0..shape.rows() {
                let angle = f64::from(column) * std::f64::consts::TAU / f64::from(shape.columns());
                let z = f64::from(row) * f64::from(surface.height_m()) / f64::from(shape.rows() - 1);
                surface.set_radius(column, row, radius_m(angle, z) as f32);
            }
        }
    }
    pot
}

fn grooved_pot() -> Pot {
    shaped_pot(GridShape::PAPER, |angle, z| 0.055 + 0.0012 * (z * 900.0 - angle).sin())
}

#[test]
fn every_shader_module_is_valid_wgsl() {
    for module in MODULES {
        let parsed = naga::front::wgsl::parse_str(module.wgsl)
            .unwrap_or_else(|error| panic!("{}: {}", module.name, error.emit_to_string(module.wgsl)));
        // no capability beyond the core ones: WebGL2 has no others
        naga::valid::Validator::new(naga::valid::ValidationFlags::all(), naga::valid::Capabilities::empty())
            .validate(&parsed)
            .unwrap_or_else(|error| panic!("{}: {}", module.name, error.emit_to_string(module.wgsl)));
    }
}

#[test]
fn every_shader_file_of_the_client_belongs_to_a_module() {
    let mut folders = vec![Path::new(env!("CARGO_MANIFEST_DIR")).join("../../client/src")];
    let mut files = 0;
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|extension| extension == "wgsl") {
                let text = std::fs::read_to_string(&path).unwrap();
                assert!(MODULES.iter().any(|module| module.wgsl.contains(&text)), "{} is not used", path.display());
                files += 1;
            }
        }
    }
    assert!(files > 0, "no shader was found");
}

/// Largest distance (m) and largest angle (degrees) of a skin's vertices from the analytic surface.
fn largest_errors(gpu: &Gpu, pot: &Pot, skin: Skin) -> (f64, f64) {
    let surface = &pot.surfaces()[skin.surface];
    let shape = surface.shape();
    let vertices = probe_skin(gpu, pot, skin).unwrap();
    assert_eq!(vertices.len(), shape.elements());
    let (mut distance_m, mut angle_deg) = (0.0_f64, 0.0_f64);
    for (index, vertex) in vertices.iter().enumerate() {
        let (column, row) = (index / shape.rows() as usize, index % shape.rows() as usize);
        let angle = column as f64 * std::f64::consts::TAU / f64::from(shape.columns());
        let z = row as f64 * f64::from(surface.height_m()) / f64::from(shape.rows() - 1);
        let radius = analytic::radius_m(angle, z) - f64::from(skin.inset_m);
        let position = [radius * angle.cos(), radius * angle.sin(), z];
        let measured = vertex.position_m.to_array().map(f64::from);
        distance_m = distance_m.max(length([0, 1, 2].map(|axis| measured[axis] - position[axis])));
        let facing = if skin.faces_outwards { 1.0 } else { -1.0 };
        let normal = analytic_normal(angle, z, f64::from(skin.inset_m)).map(|part| part * facing);
        angle_deg = angle_deg.max(angle_between_deg(vertex.normal.to_array().map(f64::from), normal));
    }
    (distance_m, angle_deg)
}

#[test]
fn vertices_and_normals_are_those_of_the_analytic_surface() {
    let gpu = gpu();
    let pot = shaped_pot(GridShape::PAPER, analytic::radius_m);
    let finer = shaped_pot(GridShape::new(720, 799).unwrap(), analytic::radius_m);
    for skin in pot.skins() {
        let (distance_m, paper_deg) = largest_errors(&gpu, &pot, skin);
        let (_, finer_deg) = largest_errors(&gpu, &finer, skin);
        println!("{skin:?}: {distance_m:.2e} m, {paper_deg:.4} and {finer_deg:.4} degrees");
        // f32 radius, cosine and height: a few roundings of 2⁻²⁴ times 200 mm
        assert!(distance_m < 0.1e-6, "{skin:?}: {distance_m} m");
        // differences miss h²/6 · r‴ of the slope inside and h²/3 · r‴ at foot and rim: with r‴ = b k³ and
        // h = 0.5 mm that is 0.0027, or 0.15°; what they miss round the pot is a twentieth of it
        assert!(paper_deg < 0.16, "{skin:?}: {paper_deg} degrees");
        // half the spacing both ways leaves a quarter; off 4 by the next order of the series and the roundings of r
        let ratio = paper_deg / finer_deg;
        assert!((3.4..4.6).contains(&ratio), "{skin:?}: {paper_deg} degrees become {finer_deg}");
    }
}

#[test]
fn uploading_a_window_brings_exactly_that_window() {
    let gpu = gpu();
    let mut expected = Pot::new(PotSpec::default()).unwrap();
    let after = shaped_pot(GridShape::PAPER, |angle, z| 0.05 + 0.004 * (5.0 * angle).sin() + 0.03 * z);
    let mut renderer = PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &expected);
    let windows = [
        Window { first_column: 350, columns: 25, first_row: 100, rows: 40 },
        Window { first_column: 20, columns: 1, first_row: 399, rows: 1 },
        Window { first_column: 359, columns: 1, first_row: 0, rows: 400 },
        Window { first_column: 200, columns: 360, first_row: 7, rows: 3 },
        Window::default(),
    ];
    for window in windows {
        expected.copy_window(&after, 0, window);
        // the renderer sees the whole new pot, yet may take the window alone
        renderer.upload(&after, 0, window);
        assert!(renderer.radii_on_device(0).unwrap() == expected.surfaces()[0].radii_m(), "after {window:?}");
    }
    renderer.upload_all(&after);
    assert!(renderer.radii_on_device(0).unwrap() == after.surfaces()[0].radii_m());
}

const WIDTH: u32 = 320;
const HEIGHT: u32 = 240;
const ASPECT: f32 = WIDTH as f32 / HEIGHT as f32;

type Pixels = Vec<[u8; 4]>;

fn drawn(renderer: &mut PotRenderer, scene: &Scene<'_>) -> Pixels {
    bytemuck::pod_collect_to_vec(&renderer.pixels(scene, WIDTH, HEIGHT).unwrap())
}

/// The pixel in which a point of the room is shown.
fn pixel(pixels: &[[u8; 4]], camera: &Camera, point_m: Vec3) -> [u8; 4] {
    let ndc = camera.ndc(point_m, ASPECT).expect("in front of the camera");
    let (x, y) = ((ndc.x + 1.0) * 0.5 * WIDTH as f32, (1.0 - ndc.y) * 0.5 * HEIGHT as f32);
    pixels[y as usize * WIDTH as usize + x as usize]
}

/// Clay is the only thing in the studio that is much redder than blue.
fn is_clay([red, _, blue, _]: [u8; 4]) -> bool {
    i32::from(red) > i32::from(blue) + 24
}

/// Mean difference of two pictures, in steps of 255.
fn mean_difference(one: &[[u8; 4]], other: &[[u8; 4]]) -> f64 {
    let differences = one.iter().flatten().zip(other.iter().flatten()).map(|(one, other)| one.abs_diff(*other));
    differences.map(f64::from).sum::<f64>() / one.len() as f64 / 3.0
}

#[test]
fn a_picture_shows_clay_within_the_outline_and_none_beside_it() {
    let pot = grooved_pot();
    let scene = Scene::default();
    let pixels = bytemuck::pod_collect_to_vec(&picture_rgba(&gpu(), &pot, &scene, WIDTH, HEIGHT).unwrap());
    for z in [0.03, 0.08, 0.13, 0.18] {
        // the camera stands at −y: the outline lies at ±x
        for x in [-0.050, -0.02, 0.02, 0.050] {
            let wall = Vec3::new(x, -(0.055_f32.powi(2) - x * x).sqrt(), z);
            assert!(is_clay(pixel(&pixels, &scene.camera, wall)), "no clay at {wall}");
        }
        for x in [-0.064, 0.064] {
            assert!(!is_clay(pixel(&pixels, &scene.camera, Vec3::new(x, 0.0, z))), "clay at x = {x}, z = {z}");
        }
    }
    // through the opening, the far inner wall
    assert!(is_clay(pixel(&pixels, &scene.camera, Vec3::new(0.0, 0.045, 0.185))));
    assert!(pixels.iter().all(|pixel| pixel[3] == 255));
}

#[test]
fn grooves_show_in_the_light_at_every_stride() {
    let gpu = gpu();
    let scene = Scene { camera: Camera { distance_m: 0.3, ..Camera::default() }, ..Scene::default() };
    let format = wgpu::TextureFormat::Rgba8UnormSrgb;
    let mut smooth = PotRenderer::new(&gpu, format, 1, &Pot::new(PotSpec::default()).unwrap());
    let mut grooved = PotRenderer::new(&gpu, format, 1, &grooved_pot());
    let contrast = |pixels: &[[u8; 4]]| {
        // up the middle of the wall, brightness from pixel to pixel
        let column = (HEIGHT / 3..HEIGHT * 3 / 4).map(|y| pixels[(y * WIDTH + WIDTH / 2) as usize][0]);
        column.clone().zip(column.skip(1)).map(|(low, high)| f64::from(low.abs_diff(high))).sum::<f64>()
    };
    for vertex_px in [0.0, 6.0] {
        smooth.set_vertex_px(vertex_px);
        grooved.set_vertex_px(vertex_px);
        let (smooth, grooved) = (contrast(&drawn(&mut smooth, &scene)), contrast(&drawn(&mut grooved, &scene)));
        assert!(grooved > 5.0 * smooth, "vertices {vertex_px} px apart: {grooved} against {smooth}");
    }
}

#[test]
fn a_coarse_mesh_looks_like_the_full_one() {
    let gpu = gpu();
    let mut renderer = PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &grooved_pot());
    let scene = Scene::default();
    renderer.set_vertex_px(0.0);
    let full = drawn(&mut renderer, &scene);
    renderer.set_vertex_px(PotRenderer::VERTEX_PX_SOFTWARE);
    let coarse = drawn(&mut renderer, &scene);
    // what differs is the outline, by fractions of a pixel; flat shading of that mesh would differ by several steps
    let difference = mean_difference(&full, &coarse);
    assert!(difference > 0.0 && difference < 0.7, "{difference} steps of 255");
}

/// Farthest, in pixels, that clay of one picture is from clay of the other, up to `within`; none when it is farther.
fn outlines_apart(one: &[[u8; 4]], other: &[[u8; 4]], width: usize, within: i32) -> Option<i32> {
    let height = one.len() / width;
    let masks = [one, other].map(|pixels| pixels.iter().map(|pixel| is_clay(*pixel)).collect::<Vec<_>>());
    let mut apart = 0;
    for (own, others) in [(&masks[0], &masks[1]), (&masks[1], &masks[0])] {
        for at in (0..own.len()).filter(|at| own[*at] && !others[*at]) {
            let (x, y) = ((at % width) as i32, (at / width) as i32);
            let is_near = |far: i32| {
                (-far..=far).flat_map(|right| (-far..=far).map(move |down| (x + right, y + down))).any(|(x, y)| {
                    (0..width as i32).contains(&x)
                        && (0..height as i32).contains(&y)
                        && others[y as usize * width + x as usize]
                })
            };
            apart = apart.max((1..=within).find(|far| is_near(*far))?);
        }
    }
    Some(apart)
}

#[test]
fn what_is_left_out_moves_the_outline_by_no_more_than_half_a_pixel() {
    // drawn six times as large as it is meant, so that half a pixel is three
    const LARGER: f32 = 6.0;
    let size = (1680_usize, 1080_u32);
    let gpu = gpu();
    let thrown = shaped_pot(GridShape::PAPER, |_, z| 0.055 + 0.0003 * (z * 1200.0).sin());
    let turned =
        shaped_pot(GridShape::PAPER, |angle, z| 0.055 + 0.004 * (2.0 * angle).cos() + 0.005 * (z * 60.0).sin());
    let cut = shaped_pot(GridShape::PAPER, |_, z| if (0.09..0.10).contains(&z) { 0.050 } else { 0.058 });
    let near = Camera { distance_m: 0.42, ..Camera::default() };
    let profile = Camera { elevation_rad: 0.0, ..Camera::default() };
    let mut unbound = Vec::new();
    for (name, pot) in [("thrown", thrown), ("grooved", grooved_pot()), ("turned", turned), ("cut", cut)] {
        let mut renderer = PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &pot);
        for camera in [Camera::default(), near, profile] {
            // fired and dull, so that no light makes clay look like something else
            let scene = Scene { camera, wetness: 0.0, ..Scene::default() };
            let mut picture = |vertex_px: f32, outline_px: f32| -> Pixels {
                renderer.set_vertex_px(LARGER * vertex_px);
                renderer.set_outline_px(LARGER * outline_px);
                bytemuck::pod_collect_to_vec(&renderer.pixels(&scene, size.0 as u32, size.1).unwrap())
            };
            let full = picture(0.0, 0.0);
            let coarse = picture(PotRenderer::VERTEX_PX_SOFTWARE, PotRenderer::OUTLINE_PX);
            let coarsest = picture(PotRenderer::VERTEX_PX_SOFTWARE, f32::INFINITY);
            let apart = outlines_apart(&full, &coarse, size.0, 12);
            let without = outlines_apart(&full, &coarsest, size.0, 60);
            println!(
                "{name}, {:.2} m away: {apart:?} of six a pixel; {without:?} without the bound",
                camera.distance_m
            );
            // three and the one that an edge falls into
            assert!(apart.is_some_and(|apart| apart <= 4), "{name}: {apart:?} sixths of a pixel");
            unbound.push(without);
        }
    }
    assert!(unbound.iter().any(|apart| apart.is_none_or(|apart| apart > 6)), "the bound bounds nothing: {unbound:?}");
}

#[test]
fn plain_and_srgb_targets_show_the_same_picture() {
    let gpu = gpu();
    let pot = grooved_pot();
    let scene = Scene::default();
    let [srgb, plain] = [wgpu::TextureFormat::Rgba8UnormSrgb, wgpu::TextureFormat::Rgba8Unorm]
        .map(|format| drawn(&mut PotRenderer::new(&gpu, format, 1, &pot), &scene));
    let largest = srgb.iter().flatten().zip(plain.iter().flatten()).map(|(one, other)| one.abs_diff(*other)).max();
    // both round once, from curves of their own
    assert!(largest <= Some(2), "{largest:?} steps of 255");
}

#[test]
fn the_picture_follows_an_upload_of_the_changed_window() {
    let gpu = gpu();
    let mut pot = Pot::new(PotSpec::default()).unwrap();
    let mut renderer = PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &pot);
    let scene = Scene { phase: Phase(0xC000_0000), ..Scene::default() };
    let untouched = drawn(&mut renderer, &scene);
    // a dent across the seam, which this phase turns towards the camera at −y
    let window = Window { first_column: 350, columns: 21, first_row: 180, rows: 40 };
    for column in window.grid_columns(GridShape::PAPER) {
        for row in 180..220 {
            pot.surfaces_mut()[0].set_radius(column, row, 0.052);
        }
    }
    renderer.upload(&pot, 0, window);
    let dented = drawn(&mut renderer, &scene);
    assert!(mean_difference(&untouched, &dented) > 0.02);
    let anew = drawn(&mut PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &pot), &scene);
    assert!(dented == anew, "light or shape outside the window were left behind");
}

#[test]
fn a_pot_that_grew_is_drawn_as_if_anew() {
    let gpu = gpu();
    let mut pot = Pot::new(PotSpec::default()).unwrap();
    let mut renderer = PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &pot);
    let scene = Scene::default();
    let untouched = drawn(&mut renderer, &scene);
    let waist = Window { first_column: 0, columns: 360, first_row: 100, rows: 200 };
    for column in waist.grid_columns(GridShape::PAPER) {
        for row in 100..300 {
            pot.surfaces_mut()[0].set_radius(column, row, 0.054);
        }
    }
    let height_m = pot.surfaces()[0].height_m();
    pot.settle(std::iter::once((0, waist)));
    // half of the pot encloses 0.9² of what it did
    assert!(pot.surfaces()[0].height_m() > 1.09 * height_m);
    renderer.upload(&pot, 0, waist);
    let grown = drawn(&mut renderer, &scene);
    assert!(mean_difference(&untouched, &grown) > 0.5);
    let anew = drawn(&mut PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &pot), &scene);
    assert!(grown == anew, "height or light of the lower pot were left behind");
}

#[test]
fn a_renderer_fits_pots_of_its_grid_alone() {
    let gpu = gpu();
    let spec = PotSpec { shape: GridShape::new(180, 200).unwrap(), ..PotSpec::default() };
    let pot = Pot::new(spec).unwrap();
    let renderer = PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &pot);
    let finer = PotSpec { shape: GridShape::new(360, 400).unwrap(), ..spec };
    let fits = |spec| renderer.fits(&Pot::new(spec).unwrap());
    assert!(fits(spec) && !fits(finer));
}

#[test]
fn the_wheel_head_is_seen_turning() {
    let gpu = gpu();
    let mut renderer =
        PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &Pot::new(PotSpec::default()).unwrap());
    let still = drawn(&mut renderer, &Scene::default());
    let half_turn = drawn(&mut renderer, &Scene { phase: Phase(1 << 31), ..Scene::default() });
    let quarter_turn = drawn(&mut renderer, &Scene { phase: Phase(1 << 30), ..Scene::default() });
    for turned in [half_turn, quarter_turn] {
        let changed = still.iter().zip(&turned).filter(|(one, other)| one[0].abs_diff(other[0]) > 20).count();
        assert!(changed > 40, "{changed} pixels tell the turn");
    }
}

#[test]
fn tools_show_in_their_colour_where_they_are() {
    let ball = ToolView {
        tool: Tool::default(),
        turn: Quat::IDENTITY,
        centre_m: Vec3::new(-0.11, -0.03, 0.10),
        colour: [0.0, 0.6, 0.1],
        touching: false,
        side: Side::default(),
        clay_m: None,
    };
    let tools = [
        ball,
        ToolView { centre_m: Vec3::new(0.11, -0.03, 0.10), colour: [0.1, 0.1, 0.8], touching: true, ..ball },
        ToolView { centre_m: Vec3::NAN, colour: [1.0; 3], touching: true, ..ball },
        // it is in no rack
        ToolView { tool: Tool::Convex(Shape(4)), colour: [1.0; 3], ..ball },
    ];
    let scene = Scene { tools: &tools, ..Scene::default() };
    let pixels = picture_rgba(&gpu(), &Pot::new(PotSpec::default()).unwrap(), &scene, WIDTH, HEIGHT).unwrap();
    let pixels: Pixels = bytemuck::pod_collect_to_vec(&pixels);
    let [red, green, blue, _] = pixel(&pixels, &scene.camera, tools[0].centre_m);
    assert!(green > red && green > blue);
    let [red, green, blue, _] = pixel(&pixels, &scene.camera, tools[1].centre_m);
    assert!(blue > red && blue > green);
}

#[test]
fn a_tool_of_facets_shows_as_it_is_held() {
    // with its flat side to the viewer a rib covers half a disc of 50 mm radius, and a line with its edge to them
    let scene_of = |tools: &[ToolView], rack: &[ConvexTool]| {
        let camera = Camera { azimuth_rad: 0.0, elevation_rad: 0.0, ..Camera::default() };
        let scene = Scene { tools, rack, camera, ..Scene::default() };
        let pot = Pot::new(PotSpec::default()).unwrap();
        let pixels: Pixels = bytemuck::pod_collect_to_vec(&picture_rgba(&gpu(), &pot, &scene, WIDTH, HEIGHT).unwrap());
        pixels
    };
    let rack = rack::standard();
    let bare = scene_of(&[], &rack);
    let covered = |shapes: &[(Shape, f32)]| {
        let views: Vec<_> = shapes
            .iter()
            .map(|&(shape, yaw)| ToolView {
                tool: Tool::Convex(shape),
                turn: Quat::from_rotation_z(yaw),
                centre_m: Vec3::new(0.1, 0.0, 0.1),
                colour: [0.0, 0.9, 0.1],
                touching: true,
                side: Side::default(),
                clay_m: None,
            })
            .collect();
        let drawn = scene_of(&views, &rack);
        let is_green =
            |pixel: &[u8; 4]| pixel[1] > pixel[0].saturating_add(20) && pixel[1] > pixel[2].saturating_add(20);
        bare.iter().zip(&drawn).filter(|(bare, drawn)| !is_green(bare) && is_green(drawn)).count()
    };
    let (edge, flat) = (covered(&[(Shape::RIB, 0.0)]), covered(&[(Shape::RIB, std::f32::consts::FRAC_PI_2)]));
    // half a disc of 3,927 mm² against 100 mm × 4 mm
    assert!(flat > 5 * edge && edge > 50, "{flat} pixels flat, {edge} with its edge");
    // several at once, whatever their order
    let both = covered(&[(Shape::RIB, std::f32::consts::FRAC_PI_2), (Shape::KNUCKLE, 0.0), (Shape::RIB, 0.0)]);
    assert!(both >= flat, "{both} pixels of three tools, {flat} of one");
}

#[test]
fn a_picture_is_a_png_of_its_size_and_no_size_is_an_error() {
    let (gpu, pot) = (gpu(), Pot::new(PotSpec::default()).unwrap());
    let file = picture(&gpu, &pot, &Scene::default(), 64, 48).unwrap();
    let mut reader = png::Decoder::new(std::io::Cursor::new(file)).read_info().unwrap();
    let mut pixels = vec![0; reader.output_buffer_size().unwrap()];
    let info = reader.next_frame(&mut pixels).unwrap();
    assert_eq!((info.width, info.height, info.color_type), (64, 48, png::ColorType::Rgba));
    for (width, height) in [(0, 48), (64, 0), (u32::MAX, 48)] {
        assert!(matches!(picture(&gpu, &pot, &Scene::default(), width, height), Err(RenderError::Size { .. })));
    }
}

#[test]
fn drawing_into_no_size_and_changing_sizes_are_harmless() {
    let gpu = gpu();
    let format = wgpu::TextureFormat::Rgba8UnormSrgb;
    let mut renderer = PotRenderer::new(&gpu, format, 4, &Pot::new(PotSpec::default()).unwrap());
    let target = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: None,
        size: wgpu::Extent3d { width: 8, height: 8, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    for size in [(0, 0), (0, 8), (8, 0), (8, 8)] {
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.draw(&mut encoder, &view, size, &Scene::default());
        gpu.queue().submit([encoder.finish()]);
    }
    for (width, height) in [(1, 1), (200, 3), (3, 200)] {
        let pixels = renderer.pixels(&Scene::default(), width, height).unwrap();
        assert_eq!(pixels.len() as u32, width * height * 4);
    }
}

#[test]
fn a_ray_passes_through_the_point_that_is_shown_there() {
    for aspect in [0.5, 1.0, 16.0 / 9.0] {
        for (azimuth_rad, elevation_rad, aside_ndc) in
            [(-1.57, 0.45, 0.0), (0.3, -0.2, 0.3), (2.5, 1.5, -0.6), (0.0, 9.0, 1.0)]
        {
            let camera = Camera { azimuth_rad, elevation_rad, aside_ndc, ..Camera::default() };
            let shown = camera.ndc(camera.target_m, aspect).unwrap();
            assert!(shown.distance(Vec2::X * aside_ndc) < 1e-6, "{camera:?} shows its target at {shown}");
            for point_m in [Vec3::new(0.03, -0.02, 0.1), Vec3::new(-0.06, 0.05, 0.2), Vec3::ZERO] {
                let ndc = camera.ndc(point_m, aspect).unwrap();
                let (origin_m, direction) = camera.ray(ndc, aspect);
                let miss_m = (point_m - origin_m).cross(direction).length();
                // f32 over half a metre of distance
                assert!(miss_m < 2e-6, "{camera:?} misses {point_m} by {miss_m} m");
            }
        }
    }
    assert_eq!(Camera::default().ray(Vec2::ZERO, 1.5).0, Camera::default().eye_m());
}

#[test]
fn a_pot_that_is_cut_shows_its_wall_as_thick_as_it_is() {
    let (gpu, pot) = (gpu(), Pot::new(PotSpec::default()).unwrap());
    let apart = |one: [u8; 4], other: [u8; 4]| (0..4).map(|of| one[of].abs_diff(other[of])).max().unwrap();
    for (azimuth_rad, turned) in [(0.0_f32, 0), (-1.2, 0), (2.0, 1 << 30), (3.1, 3 << 29)] {
        let camera = Camera { azimuth_rad, elevation_rad: 0.0, ..Camera::default() };
        let [whole, cut] = [false, true].map(|is_cut| -> Pixels {
            let scene = Scene { camera, phase: Phase(turned), is_cut, ..Scene::default() };
            bytemuck::pod_collect_to_vec(&picture_rgba(&gpu, &pot, &scene, WIDTH, HEIGHT).unwrap())
        });
        // on the plane through the axis that faces the camera, so far to the right of the axis
        let (sin, cos) = azimuth_rad.sin_cos();
        let at = |picture: &Pixels, aside_m: f32, z_m: f32| {
            pixel(picture, &camera, Vec3::new(-sin * aside_m, cos * aside_m, z_m))
        };
        for side in [-1.0, 1.0] {
            let [inner, middle] = [0.049, 0.056].map(|aside_m| at(&cut, side * aside_m, 0.1));
            assert!(apart(inner, middle) > 12, "{azimuth_rad}: the wall {middle:?} is not told from {inner:?} within");
            // the face is flat: across the wall it is of one colour but for the strokes of the wire
            for aside_m in [0.053, 0.0545, 0.0575, 0.059] {
                let face = at(&cut, side * aside_m, 0.1);
                assert!(apart(face, middle) < 12, "{azimuth_rad}: {face:?} at {aside_m} m and {middle:?}");
            }
            // the floor is as thick as the wall
            let [under, over] = [0.004, 0.02].map(|z_m| at(&cut, side * 0.02, z_m));
            assert!(apart(under, over) > 8, "{azimuth_rad}: floor {under:?}, {over:?} above it");
            // what is beside the pot stays as it was
            assert_eq!(at(&whole, side * 0.075, 0.15), at(&cut, side * 0.075, 0.15));
        }
        let clay = whole.iter().filter(|pixel| is_clay(**pixel)).count();
        let changed = whole.iter().zip(&cut).filter(|(whole, cut)| apart(**whole, **cut) > 12).count();
        assert!(
            changed > clay / 2,
            "{azimuth_rad}: of {clay} pixels of clay {changed} changed: the nearer half is there"
        );
    }
}

#[test]
fn a_picture_of_fewer_pixels_is_the_same_picture_less_sharp() {
    let gpu = gpu();
    let pot = grooved_pot();
    let mut renderer = PotRenderer::new(&gpu, wgpu::TextureFormat::Rgba8UnormSrgb, 1, &pot);
    let mut drawn = |share: f32| -> Pixels {
        renderer.set_share(share);
        bytemuck::pod_collect_to_vec(&renderer.pixels(&Scene::default(), WIDTH, HEIGHT).unwrap())
    };
    let whole = drawn(1.0);
    let differences = [0.9, 0.7, 0.5].map(|share| mean_difference(&whole, &drawn(share)));
    // what differs are edges and grooves, more of them the fewer pixels there are, and never the whole
    assert!(differences.is_sorted() && differences[0] > 0.0 && differences[2] < 6.0, "{differences:?}");
    assert!(mean_difference(&whole, &drawn(1.0)) == 0.0);
}

#[test]
fn sharpness_falls_until_pictures_are_quick_enough_and_stays_there() {
    // what a picture costs is its pixels; a machine that takes so many ms for all of them
    let settled = |whole_ms: f32| {
        let mut sharpness = Sharpness::default();
        let shares: Vec<f32> = (0..400)
            .map(|_| {
                sharpness.note(whole_ms * sharpness.share().powi(2));
                sharpness.share()
            })
            .collect();
        assert!(shares[200..].iter().all(|share| *share == shares[399]), "{whole_ms} ms: {shares:?}");
        shares[399]
    };
    for whole_ms in [1.0, 15.0, 22.0] {
        assert_eq!(settled(whole_ms), 1.0, "{whole_ms} ms");
    }
    for whole_ms in [25.0, 36.0, 60.0, 80.0] {
        let share = settled(whole_ms);
        let taken_ms = whole_ms * share * share;
        assert!(taken_ms < Sharpness::LONGEST_MS && taken_ms > 0.6 * Sharpness::LONGEST_MS, "{whole_ms}: {share}");
    }
    assert_eq!(settled(1e4), Sharpness::LEAST);
    // a machine that becomes free again, and figures that are none
    let mut sharpness = Sharpness::default();
    for taken_ms in [200.0, f32::NAN, f32::INFINITY].into_iter().cycle().take(300) {
        sharpness.note(taken_ms);
    }
    assert_eq!(sharpness.share(), Sharpness::LEAST);
    for _ in 0..100 {
        sharpness.note(2.0);
    }
    assert_eq!(sharpness.share(), 1.0);
}
