//! Water on the clay: who sees the same hands sees the same water, it dries as it is said to, and it shows in the picture.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use glam::{Quat, Vec3};
use pottery_client::render::{Camera, Gpu, Scene, ToolView, Water, picture_rgba};
use pottery_shared::clay::{Conditions, Material, Pot, PotSpec, Preset, Wheel};
use pottery_shared::tool::{Side, Tool};
use pottery_shared::units::{Rpm, Tick};

const HEIGHT_M: f32 = 0.2;
/// A hand in front of the pot, half way up.
const HAND: (Vec3, f32) = (Vec3::new(0.06, 0.0, 0.1), 0.012);

fn turning(rpm: f32) -> Conditions {
    let wheel = Wheel::starting_at(Tick(0), pottery_shared::clay::Phase(0), Wheel::rate_of(Rpm(rpm)));
    Conditions { wheel, ..Conditions::default() }
}

/// Dry all over, at tick 0.
fn dry(conditions: &Conditions) -> Water {
    let mut water = Water::default();
    // the wheel stands at the same angle after whole turns: a minute at whole rounds a minute
    water.pass(Tick(0), conditions, HEIGHT_M, []);
    water.pass(Tick(1_200_000), conditions, HEIGHT_M, []);
    water
}

#[test]
fn water_dries_to_a_share_of_e_in_its_time_constant() {
    let still = turning(0.0);
    let mut water = Water::default();
    water.pass(Tick(7), &still, HEIGHT_M, []);
    assert_eq!(water.at(1.0, 0.5), 1.0);
    let ticks = (Water::DRYING_S * 1000.0) as u64;
    let mut often = water.clone();
    water.pass(Tick(7 + ticks), &still, HEIGHT_M, []);
    for part in 1..=1000 {
        often.pass(Tick(7 + ticks * part / 1000), &still, HEIGHT_M, []);
    }
    let expected = (-1.0_f32).exp();
    // a thousand roundings of f32
    for water in [&water, &often] {
        assert!((water.at(1.0, 0.5) - expected).abs() < 1e-4, "{}", water.at(1.0, 0.5));
    }
}

#[test]
fn a_hand_wets_what_passes_it_and_nothing_else_however_often_one_looks() {
    let conditions = turning(60.0);
    for looks in [1_u64, 7, 50] {
        let mut water = dry(&conditions);
        // a quarter of a turn, in so many pictures
        water.pass(Tick(1_200_000), &conditions, HEIGHT_M, [HAND]);
        for look in 1..=looks {
            water.pass(Tick(1_200_000 + 250 * look / looks), &conditions, HEIGHT_M, [HAND]);
        }
        let quarter = std::f32::consts::FRAC_PI_2;
        for (angle, is_wet) in
            [(0.0, true), (-0.5 * quarter, true), (-0.95 * quarter, true), (0.5, false), (-2.2, false)]
        {
            let found = water.at(angle, 0.5);
            // what was wetted first has dried for a quarter of a second
            assert!(if is_wet { found > 0.99 } else { found < 0.01 }, "{looks} looks: {found} at {angle}");
        }
        // 16 mm of 200 up and down
        assert!(water.at(0.0, 0.7) < 0.01 && water.at(0.0, 0.3) < 0.01);
    }
}

#[test]
fn two_who_came_at_different_times_see_the_same_after_a_while() {
    let conditions = turning(80.0);
    let (mut first, mut second) = (dry(&conditions), Water::default());
    let start = 1_200_000;
    second.pass(Tick(start), &conditions, HEIGHT_M, []);
    for tick in (start..start + 200_000).step_by(33) {
        // up and down the wall, and away from it now and then
        let at_m = Vec3::new(0.06, 0.0, 0.1 + 0.06 * (tick as f32 * 0.001).sin());
        let hands = (tick % 7_000 < 4_000).then_some((at_m, 0.012));
        first.pass(Tick(tick), &conditions, HEIGHT_M, hands);
        second.pass(Tick(tick), &conditions, HEIGHT_M, hands);
    }
    let mut most = 0.0_f32;
    for at in 0..400 {
        let (angle, up) = (at as f32 * 0.05, (at % 37) as f32 / 37.0);
        most = most.max((first.at(angle, up) - second.at(angle, up)).abs());
    }
    // exp(−200/50) is 0.018
    assert!(most < 0.02, "{most}");
}

#[test]
fn clay_that_is_made_wetter_is_sponged_and_clay_that_is_made_drier_is_not() {
    let mut conditions = turning(0.0);
    let mut water = dry(&conditions);
    let start = Tick(1_200_000);
    let of = |preset: Preset| Material::from_wetness(preset.wetness());
    conditions.material.set(start.offset(1000), of(Preset::Stiff));
    water.pass(start.offset(1500), &conditions, HEIGHT_M, []);
    assert!(water.at(2.0, 0.9) < 0.01);
    conditions.material.set(start.offset(2000), of(Preset::Soft));
    water.pass(start.offset(1999), &conditions, HEIGHT_M, []);
    assert!(water.at(2.0, 0.9) < 0.01, "before its tick");
    water.pass(start.offset(2000), &conditions, HEIGHT_M, []);
    assert_eq!(water.at(2.0, 0.9), 1.0);
}

#[test]
fn no_figure_of_a_hand_makes_water_that_is_none() {
    let conditions = turning(300.0);
    let mut water = Water::default();
    for (at_m, radius_m) in [
        (Vec3::NAN, 0.01),
        (Vec3::ZERO, 0.0),
        (Vec3::splat(1e30), 0.01),
        (Vec3::new(0.0, 0.0, f32::INFINITY), 0.01),
        (Vec3::new(1e-20, 0.0, 0.1), 0.3),
    ] {
        water.pass(Tick(1000), &conditions, HEIGHT_M, [(at_m, radius_m)]);
        // a clock that goes back
        water.pass(Tick(10), &conditions, 0.0, [(at_m, radius_m)]);
    }
    assert!((0..100).all(|at| (0.0..=1.0).contains(&water.at(at as f32, at as f32 / 50.0 - 0.5))));
}

/// Red, green and blue of the pixel in which a point is shown.
fn seen(pixels: &[u8], camera: &Camera, point_m: Vec3) -> [f64; 3] {
    let ndc = camera.ndc(point_m, 4.0 / 3.0).unwrap();
    let (x, y) = (((ndc.x + 1.0) * 160.0) as usize, ((1.0 - ndc.y) * 120.0) as usize);
    // the mean of five by five, since clay is streaked
    let mut sum = [0.0; 3];
    for at in (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| (y * 320 + x) * 4)) {
        for (sum, value) in sum.iter_mut().zip(&pixels[at..]) {
            *sum += f64::from(*value) / 25.0;
        }
    }
    sum
}

#[test]
fn what_has_dried_is_paler_than_what_a_hand_has_wetted() {
    let gpu = Gpu::headless().unwrap();
    let pot = Pot::new(PotSpec::default()).unwrap();
    let conditions = turning(0.0);
    let mut water = dry(&conditions);
    // the camera stands at −y
    let hand = Vec3::new(0.0, -0.07, 0.12);
    water.pass(Tick(1_200_000), &conditions, HEIGHT_M, [(hand, 0.012)]);
    let scene = Scene { water: Some(&water), ..Scene::default() };
    let pixels = picture_rgba(&gpu, &pot, &scene, 320, 240).unwrap();
    let at = |z_m: f32| seen(&pixels, &scene.camera, Vec3::new(0.0, -0.06, z_m));
    let (wet, dry) = (at(0.12), at(0.06));
    assert!((0..3).all(|of| dry[of] > wet[of] + 15.0), "wet {wet:?}, dry {dry:?}");
    // and without a map it is wet all over
    let all_wet = picture_rgba(&gpu, &pot, &Scene::default(), 320, 240).unwrap();
    let below = seen(&all_wet, &scene.camera, Vec3::new(0.0, -0.06, 0.06));
    assert!((0..3).all(|of| dry[of] > below[of] + 15.0), "wet {below:?}, dry {dry:?}");
}

#[test]
fn a_ring_tells_how_far_a_tool_is_and_a_seam_that_it_touches() {
    let gpu = Gpu::headless().unwrap();
    let pot = Pot::new(PotSpec::default()).unwrap();
    let camera = Camera::default();
    let radius_m = Tool::default().sphere().unwrap().radius().0;
    let drawn = |gap_m: f32, touching: bool, is_told: bool| {
        let clay_m = is_told.then_some(radius_m + gap_m);
        let centre_m = Vec3::new(0.0, -0.06 - radius_m - gap_m, 0.1);
        let colour = [0.0, 0.9, 0.1];
        let (tool, turn, side) = (Tool::default(), Quat::IDENTITY, Side::default());
        let tool = ToolView { tool, turn, centre_m, colour, touching, side, clay_m };
        picture_rgba(&gpu, &pot, &Scene { camera, tools: &[tool], ..Scene::default() }, 320, 240).unwrap()
    };
    // pixels of the clay that the tool itself does not cover and that are the colour of its person
    let marked = |with: &[u8], without: &[u8]| {
        let is_marked =
            |(with, without): &(&[u8], &[u8])| i32::from(with[1]) > i32::from(without[1]) + 15 && with[1] > with[0];
        with.chunks(4).zip(without.chunks(4)).filter(is_marked).count()
    };
    let rings = [0.010, 0.025, 0.045].map(|gap_m| marked(&drawn(gap_m, false, true), &drawn(gap_m, false, false)));
    assert!(rings[0] > 10 && rings[1] > rings[0] && rings[2] > 0, "{rings:?}");
    // far away there is none
    assert_eq!(marked(&drawn(0.07, false, true), &drawn(0.07, false, false)), 0);
    let seam = marked(&drawn(-0.002, true, false), &drawn(-0.002, false, false));
    assert!(seam > 10, "{seam} pixels tell the contact");
}
