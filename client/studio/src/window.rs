//! The window: a pot on a turning wheel, a tool that follows the pointer, and what one needs to know.
//!
//! Owns the order of opening (display, studio, wheel, window) and of leaving; the parts are in its modules.
//! Invariant: whoever leaves has everything pressed confirmed and the recording written.

mod app;
mod closeness;
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
mod visit;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use anyhow::{Context, bail, ensure};
use pottery_client::render::{Gpu, GpuAhead};
use pottery_client::{Endpoint, PotterReport, Priority, Target};
use pottery_server::stop_signal;
use tokio::runtime::Runtime;
use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

use crate::arguments::{Place, WatchSession, WindowSession};
use crate::endings;
use crate::hosting::{self, Studio};
use crate::known;
use crate::preferences::{Keeper, Preferences};
use crate::record;
use crate::replaying::Session;
pub(crate) use app::begin_timing;
use app::{App, Begin};
use files::Files;
pub(crate) use holding::{Holding, TOOL_MM};
use looker::{First, Looker};
use overlay::Call;
use panel::Invitation;
use player::Player;
use visit::{Here, Means, Seated, Visit};

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
    ensure!(
        session.unfollowed.is_empty(),
        "nobody in a window follows {}: leave that out, or let scripted potters work with --headless",
        session.unfollowed.join(", ")
    );
    // without it the device is opened when the window is
    let graphics = GpuAhead::begin().ok();
    let mut studio = match &session.place {
        Place::Hosted(config) => Some(Studio::open_for_window(config)?),
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
    let (target, proxy) = match &session.network {
        Some(network) => runtime.block_on(network.before(target)).map(|(target, proxy)| (target, Some(proxy)))?,
        None => (target, None),
    };
    let (endpoint, seated) = runtime.block_on(async {
        let endpoint = pottery_client::endpoint()?;
        app::time_join();
        let seated = Seated::at(&endpoint, &target, session, false).await?;
        anyhow::Ok((endpoint, seated))
    })?;
    if let Some(studio) = &mut studio {
        studio.keep_session();
    }
    let potter = &seated.potter;
    if let Place::Joined(target) = &session.place {
        known::note(target, potter.view().lock().fingerprint);
    }
    if let Priority::Refused { .. } = potter.granted().priority {
        say!("note: the hand's thread has {}", potter.granted());
    }
    let last = studio.as_ref().and_then(Studio::last_pot);
    let (files, keeper) = (Files::new(session.opened.as_deref(), last), Keeper::open(Preferences::file()));
    let keeping = session.record.as_deref().map(|path| {
        let view = potter.view().clone();
        record::Keeping::begin(path, move || view.lock().recording.take())
    });
    // who hosts, or records, stays at the wheel
    let is_visitor = studio.is_none() && session.record.is_none();
    let means = means(session, (&runtime, endpoint, target), &event_loop);
    let held = seated.held(session);
    let begin = Begin { held, invitation, files, keeper, graphics, proxy: event_loop.create_proxy() };
    let app = App::new(seated.potter, seated.asked, begin, &session.tool).for_visitor(is_visitor);
    let (report, stayed) = visit(event_loop, Visit::new(Here::Working(Box::new(app)), means), &runtime);
    drop((proxy, keeping));
    let recorded = match (&session.record, report) {
        (Some(path), Some(mut report)) => record::write(report.network.recording.take(), path),
        _ => Ok(()),
    };
    let closed = studio.map_or(Ok(()), Studio::close);
    endings::all([stayed, recorded, closed]).map(|()| Ended::ByPerson)
}

/// Opens a window on a studio to look on, and stays until it is closed.
pub(crate) fn watch(session: &WatchSession) -> anyhow::Result<Ended> {
    let event_loop = match EventLoop::<Call>::with_user_event().build() {
        Ok(event_loop) => event_loop,
        Err(error) => return Ok(Ended::NoDisplay(reason(&error))),
    };
    let graphics = GpuAhead::begin().ok();
    let runtime = hosting::runtime("network")?;
    let WatchSession { working, target, detail } = session;
    let (through, proxy) = match &working.network {
        Some(network) => runtime.block_on(network.before(target.clone())).map(|(at, proxy)| (at, Some(proxy)))?,
        None => (target.clone(), None),
    };
    let (endpoint, onlooker) = runtime.block_on(async {
        let endpoint = pottery_client::endpoint()?;
        let onlooker = visit::look_on(&endpoint, &through).await?;
        anyhow::Ok((endpoint, onlooker))
    })?;
    known::note(target, onlooker.fingerprint());
    let alone = detail.shows_tools().then_some(target.wheel);
    let wheels = onlooker.look(|watcher, _| watcher.wheels());
    if let Some(wheel) = alone.filter(|wheel| !(1..=wheels).contains(wheel)) {
        bail!("there is no wheel {wheel} in this studio; its wheels are numbered from 1, and it has {wheels}");
    }
    let means = means(working, (&runtime, endpoint, through), &event_loop);
    let first = alone.map_or(First::Page, |wheel| First::Only(wheel, *detail));
    let keeper = Keeper::open(Preferences::file());
    note_trouble(&keeper);
    let looker = Looker::new(onlooker, first, &keeper, graphics, event_loop.create_proxy()).with_seats();
    let (_, stayed) = visit(event_loop, Visit::new(Here::Looking(Box::new(looker)), means), &runtime);
    drop(proxy);
    stayed.map(|()| Ended::ByPerson)
}

fn means(
    session: &WindowSession,
    (runtime, endpoint, target): (&Runtime, Endpoint, Target),
    event_loop: &EventLoop<Call>,
) -> Means {
    Means {
        runtime: runtime.handle().clone(),
        endpoint,
        session: session.clone(),
        target,
        proxy: event_loop.create_proxy(),
        interrupted: interruption(runtime),
    }
}

/// Set once somebody wants the program to end from outside.
fn interruption(runtime: &Runtime) -> Arc<AtomicBool> {
    let interrupted = Arc::new(AtomicBool::new(false));
    let flag = Arc::clone(&interrupted);
    runtime.spawn(async move {
        if let Ok(stopped) = stop_signal()
            && stopped.await.is_ok()
        {
            flag.store(true, Ordering::Relaxed);
        }
    });
    interrupted
}

/// Stays until the window is closed; what a stay gave who is at a wheel then, as far as it did, and what went wrong.
fn visit(
    event_loop: EventLoop<Call>,
    mut visit: Visit,
    runtime: &Runtime,
) -> (Option<PotterReport>, anyhow::Result<()>) {
    let ran = event_loop.run_app(&mut visit).context("the window failed");
    let (left, failure) = match visit.finish() {
        Here::Working(app) => {
            let (potter, failure) = app.finish();
            (runtime.block_on(potter.leave()).map(Some), failure)
        }
        Here::Looking(looker) => {
            let (onlooker, failure) = looker.finish();
            (runtime.block_on(onlooker.leave()).map(|_| None), failure)
        }
        Here::Nobody => (Ok(None), None),
    };
    let (report, left) = left.map_or_else(|error| (None, Err(error.into())), |report| (report, Ok(())));
    (report, endings::all([ran, failure.map_or(Ok(()), Err), left]))
}

/// Opens a window on a session that is replayed and stays until it is closed.
pub(crate) fn replay(session: Session) -> anyhow::Result<Ended> {
    let event_loop = match EventLoop::<Call>::with_user_event().build() {
        Ok(event_loop) => event_loop,
        Err(error) => return Ok(Ended::NoDisplay(reason(&error))),
    };
    let keeper = Keeper::open(Preferences::file());
    note_trouble(&keeper);
    let mut player = Player::new(session, keeper.words(), event_loop.create_proxy());
    event_loop.run_app(&mut player).context("the window failed")?;
    player.finish().map_or(Ok(Ended::ByPerson), Err)
}

/// Says what is in the way of a person's preferences, where no panel does.
fn note_trouble(keeper: &Keeper) {
    if let Some(trouble) = keeper.trouble(&keeper.words()) {
        note!("{trouble}");
    }
}
