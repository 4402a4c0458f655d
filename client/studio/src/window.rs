//! The window: a pot on a turning wheel, a tool that follows the pointer, and what one needs to know.
//!
//! Owns the order of opening (display, studio, wheel, window) and of leaving; the parts are in its modules.
//! Invariant: whoever leaves has everything pressed confirmed and the recording written.

mod app;
mod closeness;
mod depth;
mod door;
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

use anyhow::{Context, ensure};
use pottery_client::render::{Gpu, GpuAhead};
use pottery_client::{Endpoint, PotterReport, Target};
use pottery_server::stop_signal;
use pottery_shared::snapshot::Detail;
use tokio::runtime::Runtime;
use winit::error::EventLoopError;
use winit::event_loop::EventLoop;

use crate::arguments::{Place, WatchSession, WindowSession};
use crate::endings;
use crate::hosting::{self, Studio};
use crate::preferences::{Keeper, Preferences};
use crate::record;
use crate::replaying::Session;
pub(crate) use app::begin_timing;
use app::{App, Begin};
use door::Door;
use files::Files;
pub(crate) use holding::{Holding, TOOL_MM};
use looker::Looker;
use overlay::Call;
use panel::Invitation;
use player::Player;
use visit::{Asking, Came, Here, Means, Seated, Visit, Way, knock};

/// Time between pictures on a graphics card, and when the processor draws and has a hand to serve as well.
pub(crate) fn frame(gpu: &Gpu) -> Duration {
    Duration::from_millis(if gpu.is_software() { 33 } else { 16 })
}

/// Samples a pixel.
pub(crate) fn samples(gpu: &Gpu) -> u32 {
    if gpu.is_software() { 1 } else { 4 }
}

/// Time in which a studio hears that nobody waits at its door any more.
const GOODBYE_WITHIN: Duration = Duration::from_secs(1);

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
    let (endpoint, came) = runtime.block_on(async {
        let endpoint = pottery_client::endpoint()?;
        app::time_join();
        let (session, target, own, asking) = (session.clone(), target.clone(), endpoint.clone(), Asking::default());
        let asked = asking.clone();
        let way = async move {
            let seated = Seated::at(&own, &target, &session, false, &asked).await?;
            // who has waited is shown the wheel's clay and no other
            if asked.is_told() { seated.whole().await } else { Ok(seated) }
        };
        anyhow::Ok((endpoint, knock(way, &asking).await?))
    })?;
    if let Some(studio) = &mut studio {
        studio.keep_session();
    }
    let (keeper, window) = (Keeper::open(Preferences::file()), event_loop.create_proxy());
    let means = means(session, None, (&runtime, endpoint, target), &event_loop);
    let begun = match came {
        Came::In(seated) => {
            let keeping = seated.begin(session);
            let last = studio.as_ref().and_then(Studio::last_pot);
            let (held, files) = (seated.held(session), Files::new(session.opened.as_deref(), last));
            // who hosts, or records, stays at the wheel
            let is_visitor = studio.is_none() && session.record.is_none();
            let begin = Begin { held, invitation, files, keeper, graphics, proxy: window };
            let app = App::new(seated.potter, seated.asked, begin, &session.tool).for_visitor(is_visitor);
            Visit::new(Here::Working(Box::new(app)), means).keeping(keeping)
        }
        Came::ToDoor(way) => {
            let door = Door::new(&keeper, graphics, window);
            Visit::new(Here::AtDoor(Box::new(door)), means).on_way(Way::ToWork(way))
        }
    };
    let (report, stayed) = visit(event_loop, begun, &runtime);
    drop(proxy);
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
    let (endpoint, came) = runtime.block_on(async {
        let endpoint = pottery_client::endpoint()?;
        let (target, own, asking) = (through.clone(), endpoint.clone(), Asking::default());
        let asked = asking.clone();
        let way = async move { visit::look_on(&own, &target, &asked).await };
        anyhow::Ok((endpoint, knock(way, &asking).await?))
    })?;
    let (keeper, window) = (Keeper::open(Preferences::file()), event_loop.create_proxy());
    note_trouble(&keeper);
    let means = means(working, Some(*detail), (&runtime, endpoint, through), &event_loop);
    let begun = match came {
        Came::In(onlooker) => {
            let first = means.first_look(&onlooker)?;
            let looker = Looker::new(onlooker, first, &keeper, graphics, window).with_seats();
            Visit::new(Here::Looking(Box::new(looker)), means)
        }
        Came::ToDoor(way) => {
            let door = Door::new(&keeper, graphics, window);
            Visit::new(Here::AtDoor(Box::new(door)), means).on_way(Way::ToLook(way))
        }
    };
    let (_, stayed) = visit(event_loop, begun, &runtime);
    drop(proxy);
    stayed.map(|()| Ended::ByPerson)
}

fn means(
    session: &WindowSession,
    detail: Option<Detail>,
    (runtime, endpoint, target): (&Runtime, Endpoint, Target),
    event_loop: &EventLoop<Call>,
) -> Means {
    Means {
        runtime: runtime.handle().clone(),
        endpoint,
        session: session.clone(),
        target,
        proxy: event_loop.create_proxy(),
        detail,
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
    let endpoint = visit.endpoint().clone();
    let ran = event_loop.run_app(&mut visit).context("the window failed");
    let (left, failure) = match visit.finish() {
        Here::AtDoor(door) => {
            // who has not got in is no longer waited for
            let gone = async { tokio::time::timeout(GOODBYE_WITHIN, endpoint.wait_idle()).await };
            if runtime.block_on(gone).is_err() {
                tracing::debug!("the studio did not hear that nobody waits");
            }
            (Ok(None), door.finish())
        }
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
