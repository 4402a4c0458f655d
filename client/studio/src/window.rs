//! The window: a pot on a turning wheel, a tool that follows the pointer, and what one needs to know.
//!
//! Owns the order of opening (display, studio, wheel, window) and of leaving; the parts are in its modules.
//! Invariant: whoever leaves has everything pressed confirmed and the recording written.

mod app;
mod depth;
mod files;
mod fingers;
mod fitting;
mod ghost;
mod hand;
mod holding;
mod labels;
mod lesson;
mod looker;
mod overlay;
mod panel;
mod player;
mod stage;
mod standing;
mod tiles;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use pottery_client::device::{OpenedDevice, pointer};
use pottery_client::render::{Gpu, GpuAhead};
use pottery_client::sound::Sound;
use pottery_client::{Claim, Onlooker, Potter, PotterOptions, Priority};
use pottery_shared::snapshot::Detail;
use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

use crate::arguments::{Place, WatchSession, WindowSession};
use crate::hosting::{self, Studio};
use crate::known;
use crate::preferences::{Keeper, Preferences};
use crate::record;
use crate::replaying::Session;
pub(crate) use app::begin_timing;
use app::{App, Begin, Held, Rates};
use files::Files;
pub(crate) use holding::{Holding, TOOL_MM};
use looker::Looker;
use overlay::Call;
use panel::Invitation;
use player::Player;

/// What somebody who looks on in a window may be sent for long: a class of sixty wheels, or one that many work at.
const WATCH_BYTES_PER_S: u32 = 256_000;

/// Time between pictures on a graphics card, and when the processor draws and has a hand to serve as well.
pub(crate) fn frame(gpu: &Gpu) -> Duration {
    Duration::from_millis(if gpu.is_software() { 33 } else { 16 })
}

/// Samples a pixel.
pub(crate) fn samples(gpu: &Gpu) -> u32 {
    if gpu.is_software() { 1 } else { 4 }
}

/// How a session in a window ended.
#[derive(Debug)]
pub(crate) enum Ended {
    /// The person closed it.
    ByPerson,
    /// There is nothing to open a window on.
    NoDisplay(String),
}

/// What the system said: an error of its own begins with the line of a library's source, which tells a person nothing.
fn reason(error: &EventLoopError) -> String {
    let text = error.to_string();
    let said = match error {
        EventLoopError::Os(_) => {
            text.split_once(".rs:").and_then(|(_, rest)| rest.split_once(": ")).map(|(_, said)| said)
        }
        _ => None,
    };
    said.unwrap_or(&text).trim_end_matches('.').to_owned()
}

/// Opens the window and stays until it is closed.
pub(crate) fn run(session: &WindowSession) -> anyhow::Result<Ended> {
    let event_loop = match EventLoop::<Call>::with_user_event().build() {
        Ok(event_loop) => event_loop,
        Err(error) => return Ok(Ended::NoDisplay(reason(&error))),
    };
    // without it the device is opened when the window is
    let graphics = GpuAhead::begin().ok();
    let studio = match &session.place {
        Place::Hosted(config) => Some(Studio::open((**config).clone())?),
        Place::Joined(_) => None,
    };
    let (target, invitation) = match (&session.place, &studio) {
        (Place::Joined(target), _) => (target.clone(), None),
        (Place::Hosted(_), Some(studio)) => {
            let target = studio.teachers_target();
            let invitation = Invitation::new(studio.public_address(), &target.code);
            (target, Some(invitation))
        }
        (Place::Hosted(_), None) => unreachable!("a hosted place has its studio"),
    };
    if let Some(invitation) = &invitation {
        say!("others join with:  {}", invitation.command());
    }
    let runtime = hosting::runtime("network")?;
    let (asked, mouse) = pointer();
    let keeper = Keeper::open(Preferences::file());
    let chosen = session.device.clone().fitted(keeper.liking().fit(session.device.name()));
    let OpenedDevice { device, monitor } = chosen.open(mouse, &session.stroke).context("no thread for the device")?;
    let peak_n = device.specs().peak_force_n;
    let (target, proxy) = match &session.network {
        Some(network) => runtime.block_on(network.before(target)).map(|(target, proxy)| (target, Some(proxy)))?,
        None => (target, None),
    };
    let potter = runtime.block_on(async {
        let endpoint = pottery_client::endpoint()?;
        let claim = Claim { is_raised: true, core: session.core, rate: session.rate };
        let options = PotterOptions { record: session.record.is_some(), claim };
        app::time_join();
        Potter::join(&endpoint, &target, device, options).await
    })?;
    if let Place::Joined(target) = &session.place {
        known::note(target, potter.view().lock().fingerprint);
    }
    if let Priority::Refused { .. } = potter.granted().priority {
        say!("note: the hand's thread has {}", potter.granted());
    }
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    runtime.spawn(async move {
        if tokio::signal::ctrl_c().await.is_ok() {
            flag.store(true, Ordering::Relaxed);
        }
    });
    let status = Arc::clone(potter.status());
    let sound = Sound::start(session.is_muted, move || status.rub());
    let (name, feel) = (session.device.name(), session.device.feel());
    let (is_muted, rates) = (session.is_muted, Rates::new(Instant::now()));
    let held = Held { name, feel, peak_n, monitor, sound, is_muted, rates };
    let files = Files::new(session.opened.as_deref());
    let begin = Begin { held, invitation, files, keeper, graphics, proxy: event_loop.create_proxy(), interrupted };
    let mut app = App::new(potter, asked, begin, &session.tool);
    event_loop.run_app(&mut app).context("the window failed")?;
    let (potter, failure) = app.finish();
    let mut report = runtime.block_on(potter.leave())?;
    drop(proxy);
    if let Some(path) = &session.record {
        record::write(report.network.recording.take(), path)?;
    }
    match failure {
        Some(failure) => Err(failure),
        None => Ok(Ended::ByPerson),
    }
}

/// Opens a window on a studio to look on, and stays until it is closed.
pub(crate) fn watch(session: &WatchSession) -> anyhow::Result<Ended> {
    let event_loop = match EventLoop::<Call>::with_user_event().build() {
        Ok(event_loop) => event_loop,
        Err(error) => return Ok(Ended::NoDisplay(reason(&error))),
    };
    let graphics = GpuAhead::begin().ok();
    let runtime = hosting::runtime("network")?;
    let onlooker = runtime.block_on(async {
        let endpoint = pottery_client::endpoint()?;
        Onlooker::join(&endpoint, &session.target, WATCH_BYTES_PER_S).await
    })?;
    known::note(&session.target, onlooker.fingerprint());
    let alone = match session.detail {
        Detail::Spectator | Detail::Retold => Some(session.target.wheel),
        Detail::Gallery => None,
    };
    let wheels = onlooker.look(|watcher, _| watcher.wheels());
    if let Some(wheel) = alone.filter(|wheel| !(1..=wheels).contains(wheel)) {
        bail!("there is no wheel {wheel} in this studio; its wheels are numbered from 1, and it has {wheels}");
    }
    let keeper = Keeper::open(Preferences::file());
    let mut looker = Looker::new(onlooker, alone, &keeper, graphics, event_loop.create_proxy());
    event_loop.run_app(&mut looker).context("the window failed")?;
    let (onlooker, failure) = looker.finish();
    runtime.block_on(onlooker.leave())?;
    failure.map_or(Ok(Ended::ByPerson), Err)
}

/// Opens a window on a session that is replayed and stays until it is closed.
pub(crate) fn replay(session: Session) -> anyhow::Result<Ended> {
    let event_loop = match EventLoop::<Call>::with_user_event().build() {
        Ok(event_loop) => event_loop,
        Err(error) => return Ok(Ended::NoDisplay(reason(&error))),
    };
    let keeper = Keeper::open(Preferences::file());
    let mut player = Player::new(session, keeper.words(), event_loop.create_proxy());
    event_loop.run_app(&mut player).context("the window failed")?;
    player.finish().map_or(Ok(Ended::ByPerson), Err)
}
