//! Time of one sub-step at a wall with nothing behind it, alone and with others at it, beside that of clay on a core.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench wall`.

use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;
use pottery_shared::clay::{GridShape, MethodKind, Phase, Pot, PotSpec, Press, SubStep, Support, Surface, Wheel};
use pottery_shared::snapshot::{Author, Moment, Touched};
use pottery_shared::tool::{Side, Sphere};
use pottery_shared::units::{Metres, Rpm, Tick};

const STEPS: usize = 4000;
/// How deep tools are, and how deep a wall folds under them, mm.
const DEPTH_MM: f32 = 1.5;
const FOLDING_MM: f32 = 4.0;

/// Who is at the wall: tools that press, and whether the others only hold against it, as a hand reckons with them.
struct Case {
    name: &'static str,
    support: Support,
    tools: &'static [Side],
    only_first: bool,
    depth_mm: f32,
}

const fn hollow(name: &'static str, tools: &'static [Side], only_first: bool) -> Case {
    Case { name, support: Support::Hollow, tools, only_first, depth_mm: DEPTH_MM }
}

const CASES: [Case; 8] = [
    Case { support: Support::Backed, ..hollow("on a core, one", &[Side::Outside], false) },
    hollow("a wall, one", &[Side::Outside], false),
    Case { depth_mm: FOLDING_MM, ..hollow("that folds, one", &[Side::Outside], false) },
    Case { depth_mm: FOLDING_MM, ..hollow("that folds, inside", &[Side::Inside], false) },
    hollow("squeezed by two", &[Side::Outside, Side::Inside], false),
    hollow("squeezed by three", &[Side::Outside, Side::Inside, Side::Outside], false),
    hollow("a hand, one beside", &[Side::Outside, Side::Inside], true),
    hollow("a hand, two beside", &[Side::Outside, Side::Inside, Side::Outside], true),
];

fn main() {
    println!(
        "Times in µs of a step and of a snapshot, 360 x 400 elements; balls of 12 mm outside and 15 mm inside, {DEPTH_MM} mm deep, {FOLDING_MM} where a wall folds."
    );
    println!(
        "{:<20}{:>8}{:>8}{:>8}{:>10}{:>10}{:>12}{:>10}",
        "", "p50", "p99", "p99.9", "elements", "publish", "bytes p50", "wall mm"
    );
    CASES.iter().for_each(run);
}

fn quantile(figures: &mut [f64], share: f64) -> f64 {
    figures.sort_by(f64::total_cmp);
    figures[((figures.len() - 1) as f64 * share) as usize]
}

/// A tool on its way round the pot and up, the first ones opposite each other, the third ahead.
fn press(number: usize, side: Side, depth_mm: f32, step: usize) -> Press {
    let turn = step as f32 * 1e-3 * std::f32::consts::TAU + 0.3 * (number / 2) as f32;
    let (tool_mm, distance_mm) = match side {
        Side::Outside => (12.0, 60.0 + 12.0 - depth_mm),
        Side::Inside => (15.0, 52.0 - 15.0 + depth_mm),
    };
    let (distance_m, z_m) = (distance_mm * 1e-3, 0.05 + step as f32 * 2.5e-5);
    let tool = Sphere::new(Metres::from_mm(tool_mm)).expect("the tool is in range");
    let centre_m = Vec3::new(distance_m * turn.cos(), distance_m * turn.sin(), z_m);
    Press { side, turning: 1, ..Press::held(tool, centre_m) }
}

fn run(case: &Case) {
    let spec = PotSpec { shape: GridShape::PAPER, support: case.support, ..PotSpec::default() };
    let mut pot = Pot::new(spec).expect("the pot can be made");
    let mut author = Author::new(&mut pot);
    let mut touched = Touched::none(pot.surfaces().iter().map(Surface::shape));
    let mut substep = SubStep::for_grid(spec.shape);
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(Rpm(-60.0)));
    let (mut steps_us, mut publishes_us, mut bytes, mut elements) = (Vec::new(), Vec::new(), Vec::new(), 0);
    for step in 0..STEPS {
        let held = |(number, side): (usize, &Side)| press(number, *side, case.depth_mm, step);
        let all: Vec<_> = case.tools.iter().enumerate().map(held).collect();
        let (presses, beside) = all.split_at(if case.only_first { 1 } else { all.len() });
        let begin = Instant::now();
        let contacts = substep.advance_beside(&mut pot, presses, beside, MethodKind::Plastic, |surface, window| {
            touched.add_window(surface, window);
        });
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
    let [outside, inside] = [Side::Outside, Side::Inside].map(|side| {
        let surface = pot.met_from(side);
        surface.radii_m().iter().map(|radius_m| f64::from(radius_m - surface.inset_m(side))).collect::<Vec<_>>()
    });
    let thinnest_m = outside.iter().zip(&inside).map(|(outer_m, inner_m)| outer_m - inner_m).fold(1.0, f64::min);
    println!(
        "{:<20}{:>8.1}{:>8.1}{:>8.1}{elements:>10}{:>10.1}{:>12.0}{:>10.2}",
        case.name,
        quantile(&mut steps_us, 0.5),
        quantile(&mut steps_us, 0.99),
        quantile(&mut steps_us, 0.999),
        quantile(&mut publishes_us, 0.5),
        quantile(&mut bytes, 0.5),
        thinnest_m * 1e3,
    );
}
