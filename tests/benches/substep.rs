//! Time of one sub-step and of what surrounds it, by method and tool.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench substep`.

use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;
use pottery_shared::clay::{Material, MethodKind, Phase, Pot, PotSpec, Press, SubStep, Surface, Wheel};
use pottery_shared::snapshot::{Author, Moment, Touched};
use pottery_shared::tool::Sphere;
use pottery_shared::units::{Metres, Rpm, Seconds, Tick};

const STEPS: usize = 2000;

fn median(mut samples: Vec<f64>) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

fn main() {
    println!("method    tool_mm depth_mm elements step_us_p50 publish_us_p50 bytes_p50");
    for method in [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic] {
        for (tool_mm, depth_mm) in [(6.0, 1.0), (12.0, 2.0), (12.0, 4.0), (30.0, 6.0)] {
            run(method, tool_mm, depth_mm);
        }
    }
}

fn run(method: MethodKind, tool_mm: f32, depth_mm: f32) {
    let mut pot = Pot::new(PotSpec::default()).expect("the default pot can be made");
    let mut author = Author::new(&mut pot);
    let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
    let mut substep = SubStep::for_grid(pot.spec().shape);
    let tool = Sphere::new(Metres::from_mm(tool_mm)).expect("the tool is in range");
    // the tool goes round the pot as on a wheel that turns the other way
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(-60.0)));
    let response = Material::default().response(Seconds(1e-3));
    let (mut steps, mut publishes, mut bytes, mut elements) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for step in 0..STEPS {
        let turn = step as f32 * 1e-3 * std::f32::consts::TAU;
        let distance = (60.0 + tool_mm - depth_mm) * 1e-3;
        let centre_m = Vec3::new(distance * turn.cos(), distance * turn.sin(), 0.05 + step as f32 * 5e-5);
        let press = Press { turning: 1, response, ..Press::held(tool, centre_m) };
        let begin = Instant::now();
        let contacts =
            substep.advance(&mut pot, &[press], method, |surface, window| touched.add_window(surface, window));
        steps.push(begin.elapsed().as_secs_f64() * 1e6);
        elements = black_box(contacts[0].elements);
        if step % 17 == 0 {
            let tick = Tick(step as u64);
            let now = Moment { tick, phase: wheel.phase(tick) };
            let begin = Instant::now();
            let delta = author.publish(&mut pot, &mut touched, now);
            publishes.push(begin.elapsed().as_secs_f64() * 1e6);
            bytes.push(delta.map_or(0.0, |delta| delta.bytes.len() as f64));
        }
    }
    println!(
        "{:<9} {tool_mm:>7} {depth_mm:>8} {elements:>8} {:>11.1} {:>14.0} {:>9.0}",
        format!("{method:?}"),
        median(steps),
        median(publishes),
        median(bytes)
    );
}
