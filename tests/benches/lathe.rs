//! Time of a tick of a fast wheel: the full grid beside the profile.
//!
//! Measures, asserts nothing. Run it with `cargo bench -p pottery-tests --bench lathe`. Grid and profile take turns, a turn of
//! the wheel at a time. Whoever looks on, and every hand that predicts, sees a grid: so the last columns say how long it takes to write the
//! profile to the grid, and what is left of the saving when that is done for every snapshot.

use std::f32::consts::TAU;
use std::hint::black_box;
use std::time::Instant;

use glam::Vec3;
use pottery_shared::clay::{ErrorBound, Lathe, MethodKind, PlasticCsem, Pot, PotSpec, Press, SubStep};
use pottery_shared::tool::Sphere;
use pottery_shared::units::{Metres, Tick};

/// Turns in which the profile is waited for, and that are timed.
const TURNS_BEFORE: u32 = 60;
const TURNS: u32 = 40;
/// Ticks from one snapshot to the next, at 60 a second.
const TICKS_A_SNAPSHOT: f64 = 50.0 / 3.0;
/// Feed in a turn over the length of contact.
const PITCH: f32 = 0.05;

struct Stroke {
    rpm: f32,
    tool_m: f32,
    depth_m: f32,
}

impl Stroke {
    fn tick_rad(&self) -> f32 {
        self.rpm / 60.0 * TAU * Tick::PERIOD.0
    }

    fn ticks_a_turn(&self) -> u32 {
        (TAU / self.tick_rad()) as u32
    }

    fn press(&self, tick: u32) -> Press {
        let feed_m = PITCH * 2.0 * (2.0 * self.tool_m * self.depth_m - self.depth_m * self.depth_m).sqrt();
        let fed_turns = (tick as f32 * self.tick_rad() / TAU - TURNS_BEFORE as f32).max(0.0);
        let distance_m = 0.06 + self.tool_m - self.depth_m;
        let at = |tick: u32| {
            let (sin, cos) = (tick as f32 * self.tick_rad()).sin_cos();
            Vec3::new(distance_m * cos, distance_m * sin, 0.07 + feed_m * fed_turns)
        };
        let tool = Sphere::new(Metres(self.tool_m)).expect("the tool is in range");
        Press { from_m: tick.checked_sub(1).map(at), turning: -1, ..Press::held(tool, at(tick)) }
    }
}

fn median(samples: &mut [f64]) -> f64 {
    samples.sort_by(f64::total_cmp);
    samples[samples.len() / 2]
}

fn main() {
    println!(
        "  rpm tool_mm depth_mm grid_ns_a_tick profile_ns_a_tick ratio write_us shown_ratio  (360 x 400 elements, medians over {TURNS} turns)"
    );
    for rpm in [60.0, 120.0, 300.0] {
        for (tool_mm, depth_mm) in [(8.0, 1.0), (12.0, 0.5), (12.0, 2.0), (20.0, 3.0)] {
            run(&Stroke { rpm, tool_m: tool_mm * 1e-3, depth_m: depth_mm * 1e-3 });
        }
    }
}

fn run(stroke: &Stroke) {
    let [mut full, mut profiled] = [(); 2].map(|()| Pot::new(PotSpec::default()).expect("the default pot can be made"));
    let mut substep = SubStep::for_grid(full.spec().shape);
    let mut lathe = Lathe::new(&profiled.surfaces()[0], ErrorBound::default(), PlasticCsem::default());
    let turn = stroke.ticks_a_turn();
    let (mut grid_ns, mut profile_ns, mut writes_ns) = (Vec::new(), Vec::new(), Vec::new());
    for number in 0..TURNS_BEFORE + TURNS {
        let presses: Vec<Press> = (number * turn..(number + 1) * turn).map(|tick| stroke.press(tick)).collect();
        let begin = Instant::now();
        for press in &presses {
            black_box(substep.advance(&mut full, &[*press], MethodKind::Plastic, |_, _| ()));
        }
        let full_ns = begin.elapsed().as_nanos() as f64 / presses.len() as f64;
        let begin = Instant::now();
        let mut on_grid = 0;
        for press in &presses {
            let surface = &mut profiled.surfaces_mut()[0];
            if black_box(lathe.advance(surface, press, stroke.tick_rad(), |_| ())).is_none() {
                substep.advance(&mut profiled, &[*press], MethodKind::Plastic, |_, _| ());
                on_grid += 1;
            }
        }
        if number >= TURNS_BEFORE && on_grid == 0 {
            grid_ns.push(full_ns);
            profile_ns.push(begin.elapsed().as_nanos() as f64 / presses.len() as f64);
            let (mut written, mut left) = (profiled.clone(), lathe.clone());
            let begin = Instant::now();
            left.leave(&mut written.surfaces_mut()[0], |_| ());
            writes_ns.push(begin.elapsed().as_nanos() as f64);
            black_box(&written);
        }
    }
    let (tool_mm, depth_mm) = (stroke.tool_m * 1e3, stroke.depth_m * 1e3);
    if grid_ns.is_empty() {
        println!("{:>5} {tool_mm:>7.0} {depth_mm:>8.1} never a profile", stroke.rpm);
        return;
    }
    let (grid_ns, profile_ns, write_ns) = (median(&mut grid_ns), median(&mut profile_ns), median(&mut writes_ns));
    let (ratio, shown_ratio) = (grid_ns / profile_ns, grid_ns / (profile_ns + write_ns / TICKS_A_SNAPSHOT));
    println!(
        "{:>5} {tool_mm:>7.0} {depth_mm:>8.1} {grid_ns:>14.0} {profile_ns:>17.0} {ratio:>5.0} {:>8.1} {shown_ratio:>11.2}",
        stroke.rpm,
        write_ns / 1e3,
    );
}
