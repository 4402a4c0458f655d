//! Time of one sub-step and of what surrounds it, by method and tool.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench substep`.

use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;
use pottery_shared::clay::{
    GridShape, Material, MethodKind, Phase, Pot, PotSpec, Press, SubStep, Surface, Vectors, Wheel,
};
use pottery_shared::snapshot::{Author, Moment, Touched};
use pottery_shared::tool::Sphere;
use pottery_shared::units::{Metres, Rpm, Seconds, Tick};

const STEPS: usize = 4000;
/// Grid, tool and depth: a fingertip, the standard case, three hundred and a thousand elements in contact, a fist, the finest grid.
const CASES: [([u32; 2], f32, f32); 6] = [
    ([360, 400], 6.0, 1.0),
    ([360, 400], 12.0, 2.0),
    ([360, 400], 12.0, 2.6),
    ([360, 400], 25.0, 4.5),
    ([360, 400], 30.0, 6.0),
    ([1440, 1600], 12.0, 2.0),
];

fn main() {
    println!("Times in µs: of a step with the vectors of this machine, with the narrowest, and of a snapshot.");
    println!("method   grid      tool_mm depth_mm elements    p50    p99  p99.9  narrow_p50 publish_p50 bytes_p50");
    for method in [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic] {
        for case in CASES {
            run(method, case);
        }
    }
}

fn run(method: MethodKind, case: ([u32; 2], f32, f32)) {
    let ([columns, rows], tool_mm, depth_mm) = case;
    let widest = steps(method, case, Vectors::default());
    let narrow = steps(method, case, Vectors::baseline());
    println!(
        "{:<8} {:<9} {tool_mm:>7} {depth_mm:>8} {:>8} {:>6.1} {:>6.1} {:>6.1} {:>11.1} {:>11.0} {:>9.0}",
        format!("{method:?}"),
        format!("{columns}x{rows}"),
        widest.elements,
        quantile(&widest.steps_us, 0.5),
        quantile(&widest.steps_us, 0.99),
        quantile(&widest.steps_us, 0.999),
        quantile(&narrow.steps_us, 0.5),
        quantile(&widest.publishes_us, 0.5),
        quantile(&widest.bytes, 0.5),
    );
}

/// What was measured, sorted.
struct Measured {
    steps_us: Vec<f64>,
    publishes_us: Vec<f64>,
    bytes: Vec<f64>,
    elements: u32,
}

fn quantile(sorted: &[f64], share: f64) -> f64 {
    sorted[((sorted.len() - 1) as f64 * share) as usize]
}

fn steps(method: MethodKind, ([columns, rows], tool_mm, depth_mm): ([u32; 2], f32, f32), vectors: Vectors) -> Measured {
    let shape = GridShape::new(columns, rows).expect("the grid is in range");
    let mut pot = Pot::new(PotSpec { shape, ..PotSpec::default() }).expect("the pot can be made");
    let mut author = Author::new(&mut pot);
    let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
    let mut substep = SubStep::for_grid(shape).using(vectors);
    let tool = Sphere::new(Metres::from_mm(tool_mm)).expect("the tool is in range");
    // the tool goes round the pot as on a wheel that turns the other way
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(-60.0)));
    let response = Material::default().response(Seconds(1e-3));
    let (mut steps_us, mut publishes_us, mut bytes, mut elements) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for step in 0..STEPS {
        let turn = step as f32 * 1e-3 * std::f32::consts::TAU;
        let distance = (60.0 + tool_mm - depth_mm) * 1e-3;
        let centre_m = Vec3::new(distance * turn.cos(), distance * turn.sin(), 0.05 + step as f32 * 2.5e-5);
        let press = Press { turning: 1, response, ..Press::held(tool, centre_m) };
        let begin = Instant::now();
        let contacts =
            substep.advance(&mut pot, &[press], method, |surface, window| touched.add_window(surface, window));
        steps_us.push(begin.elapsed().as_secs_f64() * 1e6);
        elements = black_box(contacts[0].elements);
        if step % 17 == 0 {
            let tick = Tick(step as u64);
            let now = Moment { tick, phase: wheel.phase(tick) };
            let begin = Instant::now();
            let delta = author.publish(&mut pot, &mut touched, now);
            publishes_us.push(begin.elapsed().as_secs_f64() * 1e6);
            bytes.push(delta.map_or(0.0, |delta| delta.bytes.len() as f64));
        }
    }
    for measured in [&mut steps_us, &mut publishes_us, &mut bytes] {
        measured.sort_by(f64::total_cmp);
    }
    Measured { steps_us, publishes_us, bytes, elements }
}
