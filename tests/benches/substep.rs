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
use pottery_tests::yardstick::literal::LiteralCsem;

const STEPS: usize = 4000;
/// Times that the same steps are done: they are the same work each time, so that what differs is the machine's doing.
const RUNS: usize = 5;
/// Grid, tool and depth: a fingertip, the standard case, three hundred and a thousand elements in contact, a fist, the finest grid.
const CASES: [([u32; 2], f32, f32); 6] = [
    ([360, 400], 6.0, 1.0),
    ([360, 400], 12.0, 2.0),
    ([360, 400], 12.0, 2.6),
    ([360, 400], 25.0, 4.5),
    ([360, 400], 30.0, 6.0),
    ([1440, 1600], 12.0, 2.0),
];

/// The same for first steps: a few, three hundred and a thousand elements.
const FIRST: [([u32; 2], f32, f32); 3] = [([360, 400], 6.0, 1.0), ([360, 400], 12.0, 1.3), ([360, 400], 25.0, 2.2)];
const FIRST_STEPS: usize = 500;

fn main() {
    println!(
        "Times in µs, ns_touched in ns: of a step with the vectors of this machine, with the narrowest, of what a tool feels that moves nothing, and of a snapshot."
    );
    println!(
        "p50, p99 and p99.9 are of all steps of {RUNS} runs. own_p99.9 takes of each step the median of the runs, which leaves out what"
    );
    println!(
        "interrupted one of them; loop_p99.9 is a loop as long as p50 that only counts, and so nothing but interruptions."
    );
    println!(
        "method   grid      tool_mm depth_mm elements touched    p50    p99  p99.9 own_p99.9 loop_p99.9  ns_touched  narrow_p50 feel_p50 publish_p50 bytes_p50"
    );
    for method in [MethodKind::Original, MethodKind::Improved, MethodKind::Plastic] {
        for case in CASES {
            run(method, case);
        }
    }
    println!(
        "\nTimes in µs, p50, of a first step on untouched clay, where all methods touch the same elements; literal is the improved one to the letter."
    );
    println!("grid      tool_mm depth_mm elements original improved literal plastic literal/plastic");
    for case in FIRST {
        first_steps(case);
    }
}

/// Times each method's first step in turn.
fn first_steps(([columns, rows], tool_mm, depth_mm): ([u32; 2], f32, f32)) {
    let shape = GridShape::new(columns, rows).expect("the grid is in range");
    let untouched = Pot::new(PotSpec { shape, ..PotSpec::default() }).expect("the pot can be made");
    let mut pot = untouched.clone();
    let mut substep = SubStep::for_spheres(shape);
    let tool = Sphere::new(Metres::from_mm(tool_mm)).expect("the tool is in range");
    let mut times_us = [const { Vec::new() }; 4];
    let mut elements = 0;
    for step in 0..FIRST_STEPS {
        let (sin, cos) = (step as f32).sin_cos();
        let distance_m = (60.0 + tool_mm - depth_mm) * 1e-3;
        let presses = [Press::held(tool, Vec3::new(distance_m * cos, distance_m * sin, 0.1))];
        for (method, times_us) in times_us.iter_mut().enumerate() {
            pot.copy_from(&untouched);
            let begin = Instant::now();
            let contacts = match method {
                0 => substep.advance(&mut pot, &presses, MethodKind::Original, |_, _| {}),
                1 => substep.advance(&mut pot, &presses, MethodKind::Improved, |_, _| {}),
                2 => substep.advance(&mut pot, &presses, LiteralCsem, |_, _| {}),
                _ => substep.advance(&mut pot, &presses, MethodKind::Plastic, |_, _| {}),
            };
            elements = black_box(contacts[0].elements);
            times_us.push(begin.elapsed().as_secs_f64() * 1e6);
        }
    }
    let [original, improved, literal, plastic] = times_us.map(|times_us| quantile(&sorted(times_us.into_iter()), 0.5));
    println!(
        "{:<9} {tool_mm:>7} {depth_mm:>8} {elements:>8} {original:>8.1} {improved:>8.1} {literal:>7.1} {plastic:>7.1} {:>15.1}",
        format!("{columns}x{rows}"),
        literal / plastic,
    );
}

fn run(method: MethodKind, case: ([u32; 2], f32, f32)) {
    let ([columns, rows], tool_mm, depth_mm) = case;
    let runs: Vec<Measured> = (0..RUNS).map(|_| steps(method, case, Vectors::default())).collect();
    let all_us = sorted(runs.iter().flat_map(|run| run.steps_us.iter().copied()));
    let own_us = sorted((0..STEPS).map(|step| quantile(&sorted(runs.iter().map(|run| run.steps_us[step])), 0.5)));
    let narrow_us = sorted(steps(method, case, Vectors::baseline()).steps_us.into_iter());
    let loop_us = counting(quantile(&all_us, 0.5));
    let Measured { feels_us, publishes_us, bytes, elements, touched, .. } = &runs[0];
    let step_us = quantile(&all_us, 0.5);
    println!(
        "{:<8} {:<9} {tool_mm:>7} {depth_mm:>8} {elements:>8} {touched:>7} {step_us:>6.1} {:>6.1} {:>6.1} {:>9.1} {:>10.1} {:>11.2} {:>11.1} {:>8.1} {:>11.0} {:>9.0}",
        format!("{method:?}"),
        format!("{columns}x{rows}"),
        quantile(&all_us, 0.99),
        quantile(&all_us, 0.999),
        quantile(&own_us, 0.999),
        quantile(&loop_us, 0.999),
        step_us * 1e3 / f64::from(*touched),
        quantile(&narrow_us, 0.5),
        quantile(feels_us, 0.5),
        quantile(publishes_us, 0.5),
        quantile(bytes, 0.5),
    );
}

/// Times of as many loops that do nothing but count, each about as long as asked for, µs.
fn counting(long_us: f64) -> Vec<f64> {
    let timed = |counts: u64| {
        let begin = Instant::now();
        let mut sum = 0_u64;
        for count in 0..counts {
            sum = black_box(sum + count);
        }
        begin.elapsed().as_secs_f64() * 1e6
    };
    let many_us = quantile(&sorted((0..101).map(|_| timed(100_000))), 0.5);
    let counts = (long_us / many_us * 1e5) as u64;
    sorted((0..STEPS * RUNS).map(|_| timed(counts)))
}

fn sorted(figures: impl Iterator<Item = f64>) -> Vec<f64> {
    let mut figures: Vec<f64> = figures.collect();
    figures.sort_by(f64::total_cmp);
    figures
}

/// What was measured: the steps in their order, the rest sorted.
struct Measured {
    steps_us: Vec<f64>,
    feels_us: Vec<f64>,
    publishes_us: Vec<f64>,
    bytes: Vec<f64>,
    elements: u32,
    /// Elements of the windows that the last step wrote to, those beyond the contact that it moves with it included.
    touched: u32,
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
    let [mut steps_us, mut feels_us, mut publishes_us, mut bytes] = [const { Vec::new() }; 4];
    let mut elements = 0;
    let mut written = 0;
    for step in 0..STEPS {
        let turn = step as f32 * 1e-3 * std::f32::consts::TAU;
        let distance = (60.0 + tool_mm - depth_mm) * 1e-3;
        let centre_m = Vec3::new(distance * turn.cos(), distance * turn.sin(), 0.05 + step as f32 * 2.5e-5);
        let press = Press { turning: 1, response, ..Press::held(tool, centre_m) };
        written = 0;
        let begin = Instant::now();
        let contacts = substep.advance(&mut pot, &[press], method, |surface, window| {
            touched.add_window(surface, window);
            written += window.columns * window.rows;
        });
        steps_us.push(begin.elapsed().as_secs_f64() * 1e6);
        elements = black_box(contacts[0].elements);
        if step % 17 == 0 {
            let begin = Instant::now();
            black_box(substep.feel(&pot, &press, method));
            feels_us.push(begin.elapsed().as_secs_f64() * 1e6);
            let tick = Tick(step as u64);
            let now = Moment { tick, phase: wheel.phase(tick) };
            let begin = Instant::now();
            let delta = author.publish(&mut pot, &mut touched, now);
            publishes_us.push(begin.elapsed().as_secs_f64() * 1e6);
            bytes.push(delta.map_or(0.0, |delta| delta.bytes.len() as f64));
        }
    }
    for measured in [&mut feels_us, &mut publishes_us, &mut bytes] {
        measured.sort_by(f64::total_cmp);
    }
    Measured { steps_us, feels_us, publishes_us, bytes, elements, touched: written }
}
