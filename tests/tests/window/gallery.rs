//! Many wheels in one picture: each shows its own pot in its own place, whatever is beside it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::Vec2;
use pottery_client::render::{Camera, GalleryRenderer, GalleryScene, Gpu, WheelView};
use pottery_shared::clay::{Form, GridShape, Phase, Pot, PotSpec, Surface};
use pottery_shared::snapshot::Touched;

const FORMAT: wgpu::TextureFormat = wgpu::TextureFormat::Rgba8UnormSrgb;
const WIDTH: usize = 480;
const HEIGHT: usize = 360;

fn spec() -> PotSpec {
    PotSpec { shape: GridShape::new(90, 100).unwrap(), ..PotSpec::default() }
}

/// Far enough away that a wheel stays within its part.
fn camera() -> Camera {
    Camera { distance_m: 0.9, ..Camera::default() }
}

/// Four beside each other, and so many rows.
fn places(wheels: usize) -> Vec<WheelView> {
    let rows = wheels.div_ceil(4);
    let half = Vec2::new(0.25, 1.0 / rows as f32);
    (0..wheels)
        .map(|wheel| {
            let (column, row) = ((wheel % 4) as f32, (wheel / 4) as f32);
            let middle = Vec2::new(-0.75 + 0.5 * column, 1.0 - half.y - 2.0 * half.y * row);
            WheelView { phase: Phase(wheel as u32 * 377_000_000), middle, half }
        })
        .collect()
}

fn drawn(gpu: &Gpu, pots: &[Pot], wheels: &[WheelView]) -> Vec<[u8; 4]> {
    let mut renderer = GalleryRenderer::new(gpu, FORMAT, 1, &Pot::new(spec()).unwrap(), pots.len());
    for (wheel, pot) in pots.iter().enumerate() {
        renderer.upload(wheel, pot);
    }
    let scene = GalleryScene { camera: camera(), wheels, wetness: 0.8 };
    bytemuck::pod_collect_to_vec(&renderer.pixels(&scene, WIDTH as u32, HEIGHT as u32).unwrap())
}

/// The pixels of one wheel's part.
fn part(pixels: &[[u8; 4]], view: &WheelView) -> Vec<[u8; 4]> {
    let across = |x: f32| ((x + 1.0) * 0.5 * WIDTH as f32).round() as usize;
    let down = |y: f32| ((1.0 - y) * 0.5 * HEIGHT as f32).round() as usize;
    let columns = across(view.middle.x - view.half.x)..across(view.middle.x + view.half.x);
    let rows = down(view.middle.y + view.half.y)..down(view.middle.y - view.half.y);
    rows.flat_map(|row| pixels[row * WIDTH..][columns.clone()].to_vec()).collect()
}

fn clay(pixels: &[[u8; 4]]) -> usize {
    pixels.iter().filter(|pixel| i32::from(pixel[0]) > i32::from(pixel[2]) + 24).count()
}

#[test]
fn every_wheel_shows_its_own_pot_in_its_own_place() {
    let gpu = Gpu::headless().unwrap_or_else(|error| panic!("{error}"));
    let forms: Vec<Pot> = Form::ALL.iter().map(|form| form.of_clay_of(spec()).unwrap()).collect();
    let pots: Vec<Pot> = (0..12).map(|wheel| forms[wheel % 4].clone()).collect();
    let views = places(12);
    let pixels = drawn(&gpu, &pots, &views);
    // a picture of the same four rows of other pots: only what was exchanged differs
    let mut exchanged = pots.clone();
    exchanged.swap(1, 6);
    let others = drawn(&gpu, &exchanged, &views);
    for (wheel, view) in views.iter().enumerate() {
        let (before, after) = (part(&pixels, view), part(&others, view));
        assert!(clay(&before) > 400, "wheel {wheel}: {} pixels of clay", clay(&before));
        assert_eq!(before == after, ![1, 6].contains(&wheel), "wheel {wheel}");
    }
    // forms are told apart by how much of the picture they cover
    let mut covered: Vec<usize> = views[..4].iter().map(|view| clay(&part(&pixels, view))).collect();
    covered.sort_unstable();
    assert!(covered.windows(2).all(|two| two[1] > two[0] + 20), "{covered:?}");
}

#[test]
fn a_class_larger_than_a_page_is_drawn_whole_and_changed_tiles_change_one_pot() {
    let gpu = Gpu::headless().unwrap_or_else(|error| panic!("{error}"));
    let pot = Pot::new(spec()).unwrap();
    let wheels = 300;
    let views: Vec<WheelView> = (0..wheels)
        .map(|wheel| {
            let half = Vec2::splat(1.0 / 18.0);
            let middle = Vec2::new((wheel % 18) as f32 - 8.5, 8.5 - (wheel / 18) as f32) * 2.0 * half;
            WheelView { phase: Phase(0), middle, half }
        })
        .collect();
    let mut renderer = GalleryRenderer::new(&gpu, FORMAT, 1, &pot, wheels);
    assert_eq!(renderer.wheels(), wheels);
    let picture = |renderer: &mut GalleryRenderer| -> Vec<[u8; 4]> {
        let scene = GalleryScene { camera: camera(), wheels: &views, wetness: 0.8 };
        bytemuck::pod_collect_to_vec(&renderer.pixels(&scene, WIDTH as u32, HEIGHT as u32).unwrap())
    };
    let before = picture(&mut renderer);
    for (wheel, view) in views.iter().enumerate() {
        assert!(clay(&part(&before, view)) > 20, "wheel {wheel}");
    }
    let mut pressed = pot.clone();
    let mut changed = Touched::none(pot.surfaces().iter().map(Surface::shape));
    for column in 0..90 {
        for row in 30..70 {
            pressed.surfaces_mut()[0].set_radius(column, row, 0.045);
        }
    }
    changed.add_window(0, pottery_shared::clay::Window { first_column: 0, columns: 90, first_row: 30, rows: 40 });
    renderer.upload_changed(271, &pressed, &changed);
    let after = picture(&mut renderer);
    for (wheel, view) in views.iter().enumerate() {
        assert_eq!(part(&before, view) != part(&after, view), wheel == 271, "wheel {wheel}");
    }
}

#[test]
fn a_pot_that_comes_on_another_grid_is_drawn_as_its_means_are() {
    let gpu = Gpu::headless().unwrap_or_else(|error| panic!("{error}"));
    let fine = PotSpec { shape: GridShape::PAPER, ..spec() };
    let (mut coarse, mut fine) = (Pot::new(spec()).unwrap(), Pot::new(fine).unwrap());
    for (column, row) in (0..90).flat_map(|column| (0..100).map(move |row| (column, row))) {
        let radius_m = 0.05 + 0.001 * ((column / 5 + row / 7) % 9) as f32;
        coarse.surfaces_mut()[0].set_radius(column, row, radius_m);
        for under in 0..16 {
            // on either side of the mean
            let aside_m = if under % 2 == 0 { 2e-3 } else { -2e-3 };
            fine.surfaces_mut()[0].set_radius(4 * column + under / 4, 4 * row + under % 4, radius_m + aside_m);
        }
    }
    let views = places(4);
    let untouched = || Pot::new(spec()).unwrap();
    let picture = |pot: &Pot| drawn(&gpu, &[pot.clone(), untouched(), untouched(), untouched()], &views);
    let (expected, seen, before) = (picture(&coarse), picture(&fine), picture(&untouched()));
    // means of 32-bit numbers are off by less than any pixel shows
    let unlike = |one: &[[u8; 4]], other: &[[u8; 4]]| {
        let far =
            |(one, other): (&[u8; 4], &[u8; 4])| one.iter().zip(other).any(|(one, other)| one.abs_diff(*other) > 2);
        one.iter().zip(other).filter(|pair| far(*pair)).count()
    };
    assert!(unlike(&expected, &before) > 1000);
    assert!(unlike(&expected, &seen) < 5, "{} pixels", unlike(&expected, &seen));
}

#[test]
fn no_wheel_and_no_size_are_harmless() {
    let gpu = Gpu::headless().unwrap_or_else(|error| panic!("{error}"));
    let pot = Pot::new(spec()).unwrap();
    let mut renderer = GalleryRenderer::new(&gpu, FORMAT, 4, &pot, 0);
    let scene = GalleryScene { camera: Camera::default(), wheels: &[], wetness: 0.8 };
    assert_eq!(renderer.pixels(&scene, 3, 2).unwrap().len(), 24);
    assert!(renderer.pixels(&scene, 0, 2).is_err());
    // more places than wheels
    let views = places(4);
    let scene = GalleryScene { wheels: &views, ..scene };
    assert_eq!(renderer.pixels(&scene, 3, 2).unwrap().len(), 24);
}
