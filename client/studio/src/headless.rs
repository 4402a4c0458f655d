//! A studio without a window: scripted potters over real QUIC, and files of what they made.
//!
//! Invariant: it ends in success only when every client holds the server's clay.

use std::fs;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use indicatif::{ProgressBar, ProgressStyle};
use pottery_client::device::{Device, DeviceChoice, HandModel, ScriptedDevice, SimulatedDevice, pointer};
use pottery_client::pot_file::PotFile;
use pottery_client::render::{self, Gpu, Scene};
use pottery_client::stroke::Stroke;
use pottery_client::view::Link;
use pottery_client::whole_file::write_whole;
use pottery_client::{Claim, Command, Onlooker, Potter, PotterOptions, PotterReport, WatchReport, export};
use pottery_server::stop_signal;
use pottery_shared::clay::Pot;
use pottery_shared::snapshot::Detail;
use pottery_shared::tool::ConvexTool;
use pottery_shared::units::Tick;

use crate::arguments::HeadlessSession;
use crate::endings;
use crate::headless_choice::HandKind;
use crate::hosting::{self, Studio};
use crate::record;
use crate::report::SessionReport;

/// How long the last presses may take to reach everybody.
const QUIET: Duration = Duration::from_secs(5);
/// Hands, with their predictions, that a core serves in time.
const POTTERS_PER_CORE: usize = 2;
/// What somebody who looks on may take for long: as much as a pot that many work at.
const WATCH_BYTES_PER_S: u32 = 64_000;
/// Size of the picture.
const PICTURE: (u32, u32) = (1280, 960);

/// Lets the potters work and writes what came of it.
pub(crate) fn run(session: &HeadlessSession) -> anyhow::Result<()> {
    fs::create_dir_all(&session.out)
        .with_context(|| format!("the folder {} cannot be made; choose another with --out", session.out.display()))?;
    if session.strokes.len() > POTTERS_PER_CORE * cores() {
        note!(
            "{} hands at 1 kHz are more than {} cores can serve in time; the figures will show it",
            session.strokes.len(),
            cores()
        );
    }
    let mut studio = Studio::open(session.server.clone())?;
    let runtime = hosting::runtime("network")?;
    let Measured { seconds, mut reports, watched, is_behind } = runtime.block_on(work(session, &mut studio))?;
    let standing = studio.standing()?;
    let report = SessionReport::new(seconds, &reports, &watched, &standing);
    let recording = reports[0].network.recording.take();
    let saved = PotFile::of(&standing.pots[0], &reports[0].view.conditions, Tick(standing.ticks));
    endings::all([
        write(&report, &standing.pots[0], &saved, &session.out),
        session.record.as_ref().map_or(Ok(()), |path| record::write(recording, path)),
        studio.close(),
        agreement(&report, is_behind),
    ])
}

/// Writes what came of it, and says so.
fn write(report: &SessionReport, pot: &Pot, saved: &PotFile, out: &Path) -> anyhow::Result<()> {
    write_whole(&out.join("session.json"), |file| Ok(serde_json::to_writer_pretty(file, report)?))?;
    saved.write(&out.join("pot.pot"))?;
    write_whole(&out.join("pot.stl"), |file| export::write_stl(pot, file))?;
    let picture = picture(pot, out)?;
    say!("{}", report.summary());
    say!("written    session.json, pot.pot, pot.stl{} in {}", if picture { ", pot.png" } else { "" }, out.display());
    Ok(())
}

/// Whether every client holds the server's clay, and nobody who looked on was still behind.
fn agreement(report: &SessionReport, is_behind: bool) -> anyhow::Result<()> {
    let diverged = report.diverged();
    if !diverged.is_empty() {
        bail!("the clay of clients {diverged:?} differs from the server's after {} s of quiet", QUIET.as_secs());
    }
    ensure!(!is_behind, "who looks on has not got the clay within {} s of quiet", QUIET.as_secs());
    Ok(())
}

/// What potters and those who looked on measured.
struct Measured {
    /// How long they worked.
    seconds: f64,
    reports: Vec<PotterReport>,
    watched: Vec<(Detail, WatchReport)>,
    /// Whether somebody who looked on had not got the clay in the end.
    is_behind: bool,
}

async fn work(session: &HeadlessSession, studio: &mut Studio) -> anyhow::Result<Measured> {
    let (target, _proxy) = match &session.network {
        Some(network) => network.before(studio.target()).await.map(|(target, proxy)| (target, Some(proxy)))?,
        None => (studio.target(), None),
    };
    let mut endpoints = Vec::new();
    let mut potters = Vec::new();
    for (number, stroke) in session.strokes.iter().enumerate() {
        // an endpoint each, as people on machines of their own have
        let endpoint = pottery_client::endpoint()?;
        let device: Box<dyn Device> = match (&session.device, session.hand) {
            (Some(device), _) if number == 0 => open(device, stroke)?,
            (_, HandKind::Scripted) => Box::new(ScriptedDevice::new(stroke.clone())),
            (_, HandKind::Simulated) => Box::new(SimulatedDevice::new(stroke.clone(), HandModel::default())),
        };
        // hands that outnumber the cores would keep everything else from them
        let claim = Claim {
            is_raised: session.strokes.len() < cores(),
            core: session.core.filter(|_| number == 0),
            rate: session.rate,
        };
        let record = number == 0 && session.record.is_some();
        let options = PotterOptions { record, claim, ..PotterOptions::default() };
        let potter = Potter::join(&endpoint, &target, device, options).await?;
        if let Some(tool) = session.brought.as_ref().filter(|_| number == 0) {
            bring(&potter, Arc::clone(tool)).await?;
        }
        potters.push(potter);
        endpoints.push(endpoint);
    }
    let _keeping = session.record.as_deref().map(|path| {
        let view = potters[0].view().clone();
        record::Keeping::begin(path, move || view.lock().recording.take())
    });
    let mut lookers = Vec::new();
    for &detail in &session.watch {
        let endpoint = pottery_client::endpoint()?;
        let looker = Onlooker::join(&endpoint, &target, WATCH_BYTES_PER_S).await?;
        looker.look(|watcher, now| watcher.watch(target.wheel, detail, now));
        lookers.push((detail, looker));
        endpoints.push(endpoint);
    }
    studio.keep_session();
    let seconds = watch(session.seconds, &potters).await?;
    let mut all_settled = true;
    for potter in &potters {
        all_settled &= potter.settle(QUIET).await;
    }
    if !all_settled {
        note!("not every press was confirmed within {} s", QUIET.as_secs());
    }
    // the last snapshot reaches those who settled first as well
    tokio::time::sleep(Duration::from_millis(300)).await;
    let (mut watched, mut is_behind) = (Vec::new(), false);
    for (detail, looker) in lookers {
        is_behind |= looker.look(|watcher, _| watcher.is_behind());
        watched.push((detail, looker.leave().await?));
    }
    let mut reports = Vec::new();
    for potter in potters {
        reports.push(potter.leave().await?);
    }
    for endpoint in endpoints {
        endpoint.close(0_u32.into(), b"goodbye");
        endpoint.wait_idle().await;
    }
    Ok(Measured { seconds, reports, watched, is_behind })
}

fn cores() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Takes a device in hand and says once whether it is there.
fn open(device: &DeviceChoice, stroke: &Arc<Stroke>) -> anyhow::Result<Box<dyn Device>> {
    let opened = device.open(pointer().1, stroke).context("no thread for the device")?;
    if let Some(monitor) = opened.monitor {
        match (monitor.about(), monitor.notice()) {
            (_, Some(notice)) => note!("{notice}"),
            (about, None) => say!("device     {}", about.as_deref().unwrap_or(device.name())),
        }
    }
    Ok(opened.device)
}

/// Brings a tool to the wheel and waits until it hangs in the rack.
async fn bring(potter: &Potter, tool: Arc<ConvexTool>) -> anyhow::Result<()> {
    let deadline = tokio::time::Instant::now() + QUIET;
    let mut is_heard = potter.command(Command::Bring(tool));
    while is_heard && tokio::time::Instant::now() < deadline {
        // a guard within the match would be held while the arms ask again
        let brought = potter.view().lock().brought.take();
        match brought {
            Some(Ok(_)) => return Ok(()),
            Some(Err(reason)) => bail!(reason),
            None => is_heard = potter.view().lock().link == Link::Open,
        }
        tokio::time::sleep(Duration::from_millis(10)).await;
    }
    bail!("the tool has not come to the wheel within {} s", QUIET.as_secs())
}

/// Shows the passing time and who is touching, until the session's seconds are over or it is interrupted; how long that was, s.
async fn watch(seconds: f64, potters: &[Potter]) -> anyhow::Result<f64> {
    let stopped = stop_signal().context("the system lets nobody interrupt the session")?;
    tokio::pin!(stopped);
    let bar = ProgressBar::new((seconds * 10.0).round() as u64);
    let style = ProgressStyle::with_template("{bar:32.green} {msg}").unwrap_or_else(|_| ProgressStyle::default_bar());
    bar.set_style(style);
    let started = tokio::time::Instant::now();
    let mut worked = seconds;
    while started.elapsed().as_secs_f64() < seconds {
        let touching = potters.iter().filter(|potter| potter.status().elements() > 0).count();
        let passed = started.elapsed().as_secs_f64();
        bar.set_position((passed * 10.0) as u64);
        bar.set_message(format!(
            "{passed:.1} of {seconds:.1} s, {touching} of {} potters touch the clay",
            potters.len()
        ));
        tokio::select! {
            () = tokio::time::sleep(Duration::from_millis(100)) => {}
            _ = &mut stopped => {
                // to the millisecond, as long as a tick
                worked = (started.elapsed().as_secs_f64() * 1e3).round() / 1e3;
                bar.println("interrupted: what was made so far is written");
                break;
            }
        }
    }
    bar.finish_and_clear();
    Ok(worked)
}

/// Draws the pot; without a graphics driver it says so and goes on.
fn picture(pot: &Pot, folder: &Path) -> anyhow::Result<bool> {
    let gpu = match Gpu::headless() {
        Ok(gpu) => gpu,
        Err(error) => {
            note!("no picture was drawn: {error}");
            return Ok(false);
        }
    };
    let png = render::picture(&gpu, pot, &Scene::default(), PICTURE.0, PICTURE.1)?;
    write_whole(&folder.join("pot.png"), |file| file.write_all(&png))?;
    Ok(true)
}
