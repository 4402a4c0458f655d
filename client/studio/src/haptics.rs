//! `pottery-studio haptics`: what the hand's thread is granted here, and how well it keeps its thousand ticks a second.
//!
//! Owns the choice of what runs beside the hand; figures and files are `figures`' and `picture`'s.
//! Invariant: what is measured is the studio's own loop, device chain and clay, in a thread set up as a session's.

mod beside;
mod figures;
mod picture;

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::Context;
use pottery_client::boundary::{Status, boundary};
use pottery_client::device::{Device, HandModel, SimulatedDevice};
use pottery_client::stroke::Stroke;
use pottery_client::whole_file::write_whole;
use pottery_client::{Claim, Granted, HapticLoop, HapticReport, IdleLoop, Potter, PotterOptions};
use pottery_server::ServerConfig;
use pottery_shared::clay::{Conditions, Phase, Pot, PotSpec, Wheel};
use pottery_shared::prediction::{Field, Patch};
use pottery_shared::tool::rack;
use pottery_shared::units::{Rpm, Tick};

use crate::hosting::{self, Studio};
use beside::Pictures;
use figures::Figures;

/// Speed of the wheel.
const RPM: Rpm = Rpm(60.0);
/// Time between two looks at what the hand does.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// What to measure.
#[derive(Clone, Debug)]
pub(crate) struct Bench {
    pub(crate) seconds: f64,
    pub(crate) out: PathBuf,
    /// The hand is at the wheel of a server, over loopback.
    pub(crate) has_server: bool,
    /// Pictures are drawn meanwhile, as in a window.
    pub(crate) has_renderer: bool,
    pub(crate) claim: Claim,
}

/// What came of it.
struct Outcome {
    report: HapticReport,
    granted: Granted,
    looks: Looks,
    /// Pictures drawn, and on what.
    pictures: Option<(u64, String)>,
}

/// How often the hand was looked at, and how many elements it touched at those looks.
#[derive(Debug, Default)]
struct Looks {
    elements: Vec<u32>,
}

impl Looks {
    fn take(&mut self, status: &Status) {
        self.elements.push(status.elements());
    }
}

/// Says what the system grants a hand's thread.
pub(crate) fn tell(claim: Claim) -> anyhow::Result<()> {
    let granted = std::thread::spawn(move || claim.stake()).join().ok().context("the thread did not end well")?;
    say!("a hand's thread has {granted}");
    say!("how well it keeps its thousand ticks a second: pottery-studio haptics --bench");
    Ok(())
}

/// Measures, prints the figures and writes `haptics.csv` and `haptics.svg`.
pub(crate) fn run(bench: &Bench) -> anyhow::Result<()> {
    fs::create_dir_all(&bench.out)
        .with_context(|| format!("the folder {} cannot be made; choose another with --out", bench.out.display()))?;
    let beside = match (bench.has_server, bench.has_renderer) {
        (false, false) => "nothing",
        (true, false) => "a server",
        (false, true) => "a renderer",
        (true, true) => "a server and a renderer",
    };
    note!("measuring for {} s, with {beside} beside the hand, and as long a loop with nothing to do", bench.seconds);
    let device = Box::new(SimulatedDevice::new(Arc::new(stroke(bench.seconds)?), HandModel::default()));
    // half before and half after, so that what changes meanwhile is in both
    let before = idle(bench)?;
    let outcome = if bench.has_server { at_a_server(bench, device)? } else { alone(bench, device)? };
    let figures = Figures::new(&outcome, beside, before.with(idle(bench)?));
    write_whole(&bench.out.join("haptics.csv"), |file| file.write_all(figures.csv().as_bytes()))?;
    write_whole(&bench.out.join("haptics.svg"), |file| file.write_all(picture::histogram(&figures).as_bytes()))?;
    say!("{}", figures.to_string().trim_end_matches('\n'));
    say!("written    haptics.csv, haptics.svg in {}", bench.out.display());
    Ok(())
}

/// A loop with nothing to do and nothing beside it, for half of the time, on a thread set up as the hand's.
fn idle(bench: &Bench) -> anyhow::Result<IdleLoop> {
    let (claim, time) = (bench.claim, Duration::from_secs_f64(bench.seconds / 2.0));
    let keeping = std::thread::spawn(move || {
        let _granted = claim.stake();
        IdleLoop::keep(claim.rate, time)
    });
    keeping.join().ok().context("the thread did not end well")
}

/// What the hand means to do: up and down the wall, into the clay and out of it, a little deeper as the wall gives way.
fn stroke(seconds: f64) -> anyhow::Result<Stroke> {
    /// Radius of the fingertip, mm, and of the untouched wall.
    const TOOL_MM: f64 = 12.0;
    const WALL_MM: f64 = 60.0;
    /// How deep the hand means to be, at least and at most; and how much deeper at the end, mm.
    const DEPTH_MM: (f64, f64) = (-2.0, 10.0);
    const DEEPER_MM: f64 = 10.0;
    const STEP_S: f64 = 0.02;
    use std::fmt::Write as _;
    let mut text = format!("# tool_radius_mm: {TOOL_MM}\nt_s,x_mm,y_mm,z_mm\n");
    // the hand is taken away after what is measured
    let steps = ((seconds + 10.0) / STEP_S).ceil() as u64;
    for step in 0..=steps {
        let time_s = step as f64 * STEP_S;
        let share = 0.5 - 0.5 * (time_s * std::f64::consts::TAU / 2.3).cos();
        let depth_mm = DEPTH_MM.0 + (DEPTH_MM.1 - DEPTH_MM.0) * share + DEEPER_MM * (time_s / seconds).min(1.0);
        let height_mm = 100.0 + 60.0 * (time_s * std::f64::consts::TAU / 7.0).sin();
        writeln!(text, "{time_s:.2},{:.4},0,{height_mm:.4}", WALL_MM + TOOL_MM - depth_mm)?;
    }
    Ok(Stroke::parse(&text)?)
}

/// A hand on its own clay, whose samples nobody waits for.
fn alone(bench: &Bench, device: Box<dyn Device>) -> anyhow::Result<Outcome> {
    let pot = Pot::new(PotSpec::default())?;
    let wheel = Wheel::starting_at(Tick(0), Phase(0), Wheel::rate_of(RPM));
    let conditions = Conditions { wheel, ..Conditions::default() };
    let patch =
        Patch { field: Field::new(pot.clone(), Tick(0)), conditions: conditions.clone(), rack: rack::standard() };
    let (side, mut net) = boundary(&patch);
    let begin = Instant::now();
    let pictures = bench.has_renderer.then(|| {
        let phase = move || conditions.phase(Tick(begin.elapsed().as_millis() as u64));
        Pictures::start(pot, move |_| phase())
    });
    let pictures = pictures.transpose()?;
    let claim = bench.claim;
    let hand = std::thread::Builder::new().name("haptic".into()).spawn(move || {
        let granted = claim.stake();
        (HapticLoop::new(device, side).at(claim.rate).run(Instant::now()), granted)
    })?;
    let mut looks = Looks::default();
    while begin.elapsed().as_secs_f64() < bench.seconds {
        std::thread::sleep(LOOK_EVERY);
        while net.next_sample().is_some() {}
        looks.take(net.status());
    }
    drop(net);
    let (report, granted) = hand.join().ok().context("the hand's thread did not end well")?;
    let pictures = pictures.map(Pictures::stop).transpose()?;
    Ok(Outcome { report, granted, looks, pictures })
}

/// A hand at the wheel of a server in this program, over loopback.
fn at_a_server(bench: &Bench, device: Box<dyn Device>) -> anyhow::Result<Outcome> {
    let listen = std::net::SocketAddr::from(([127, 0, 0, 1], 0));
    let studio = Studio::open(ServerConfig { listen, wheel_speed: RPM, ..ServerConfig::default() })?;
    let runtime = hosting::runtime("network")?;
    let target = studio.target();
    let endpoint = runtime.block_on(async { pottery_client::endpoint() })?;
    let options = PotterOptions { claim: bench.claim, ..PotterOptions::default() };
    let potter = Arc::new(runtime.block_on(Potter::join(&endpoint, &target, device, options))?);
    let pictures = bench.has_renderer.then(|| {
        let pot = potter.view().lock().pot.clone();
        let potter = Arc::clone(&potter);
        Pictures::start(pot, move |renderer| {
            let mut view = potter.view().lock();
            let view = &mut *view;
            renderer.upload_changed(view.picture.drawn(), &view.changed);
            view.changed.clear();
            view.conditions.phase(potter.tick())
        })
    });
    let pictures = pictures.transpose()?;
    let mut looks = Looks::default();
    let begin = Instant::now();
    while begin.elapsed().as_secs_f64() < bench.seconds {
        std::thread::sleep(LOOK_EVERY);
        looks.take(potter.status());
    }
    let pictures = pictures.map(Pictures::stop).transpose()?;
    let potter = Arc::into_inner(potter).context("the renderer has ended")?;
    let left = runtime.block_on(potter.leave())?;
    let report = left.haptic.context("the hand's thread did not end well")?;
    Ok(Outcome { report, granted: left.granted, looks, pictures })
}
