//! A visit to somebody else's studio: working at a wheel and looking on, in one window and by turns.
//!
//! Owns who of both has the window, and the way from one to the other; what either does there is its own.
//! Invariant: what was seen last is seen until the other holds clay that is whole, and whoever comes first is let in before the other leaves.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, bail};
use pottery_client::device::{Monitor, OpenedDevice, Pointer, pointer};
use pottery_client::sound::Sound;
use pottery_client::{Claim, Endpoint, Onlooker, Potter, PotterOptions, Target, sentence};
use pottery_shared::snapshot::Detail;
use tokio::runtime::Handle;
use tokio::task::JoinHandle;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::window::WindowId;

use super::app::{App, Begin, Held, Rates};
use super::files::Files;
use super::looker::{First, Looker};
use super::overlay::Call;
use crate::arguments::WindowSession;
use crate::preferences::{Keeper, Preferences};

/// What somebody who looks on in a window may be sent for long: a class of sixty wheels, or one that many work at.
const WATCH_BYTES_PER_S: u32 = 256_000;
/// Time in which the first clay is there, and in which everything pressed is confirmed.
const WITHIN: Duration = Duration::from_secs(10);
const SETTLE_WITHIN: Duration = Duration::from_secs(2);
/// Time between two looks whether it is.
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// A place at a wheel with a device in hand.
pub(super) struct Seated {
    pub(super) potter: Potter,
    pub(super) asked: triple_buffer::Input<Pointer>,
    monitor: Option<Arc<Monitor>>,
    peak_n: f32,
}

impl Seated {
    /// Takes a place at the target's wheel, with the session's device, and without its force where that is off. The tool stays lifted until
    /// the wheel's clay is there.
    pub(super) async fn at(
        endpoint: &Endpoint,
        target: &Target,
        session: &WindowSession,
        is_force_off: bool,
    ) -> anyhow::Result<Self> {
        let (asked, mouse) = pointer();
        let fit = Keeper::open(Preferences::file()).liking().fit(session.device.name());
        let chosen = session.device.clone().fitted(fit);
        let OpenedDevice { device, monitor } =
            chosen.open(mouse, &session.stroke).context("no thread for the device")?;
        let peak_n = device.specs().peak_force_n;
        let claim = Claim { is_raised: true, core: session.core, rate: session.rate };
        let options = PotterOptions { record: session.record.is_some(), claim, waits: true, is_force_off };
        let potter = Potter::join(endpoint, target, device, options).await?;
        Ok(Self { potter, asked, monitor, peak_n })
    }

    /// What is in the hand, as a window shows it, and the sound that it makes.
    pub(super) fn held(&self, session: &WindowSession) -> Held {
        let status = Arc::clone(self.potter.status());
        let sound = Sound::start(session.is_muted, move || status.rub());
        Held {
            name: session.device.name(),
            feel: session.device.feel(),
            peak_n: self.peak_n,
            monitor: self.monitor.clone(),
            sound,
            is_muted: session.is_muted,
            rates: Rates::new(Instant::now()),
        }
    }

    async fn whole(self) -> anyhow::Result<Self> {
        let deadline = Instant::now() + WITHIN;
        while !self.potter.view().lock().is_whole {
            if Instant::now() > deadline {
                self.potter.leave().await?;
                bail!("the wheel's clay did not come within {} s", WITHIN.as_secs());
            }
            tokio::time::sleep(LOOK_EVERY).await;
        }
        Ok(self)
    }
}

/// Looks on at the target's studio.
pub(super) async fn look_on(endpoint: &Endpoint, target: &Target) -> anyhow::Result<Onlooker> {
    Ok(Onlooker::join(endpoint, target, WATCH_BYTES_PER_S).await?)
}

/// The same, from the wheel at which one works, once that is seen there.
async fn look_on_from(endpoint: Endpoint, target: Target) -> anyhow::Result<Onlooker> {
    let looker = look_on(&endpoint, &target).await?;
    looker.look(|watcher, now| watcher.watch(target.wheel, Detail::RETOLD, now));
    let deadline = Instant::now() + WITHIN;
    while looker.look(|watcher, _| watcher.sight(target.wheel).is_none()) {
        if Instant::now() > deadline {
            looker.leave().await?;
            bail!("nothing was to be seen of the wheel within {} s", WITHIN.as_secs());
        }
        tokio::time::sleep(LOOK_EVERY).await;
    }
    Ok(looker)
}

/// What both need.
pub(super) struct Means {
    pub(super) runtime: Handle,
    pub(super) endpoint: Endpoint,
    pub(super) session: WindowSession,
    /// The studio, and the wheel that is worked at or was last.
    pub(super) target: Target,
    pub(super) proxy: EventLoopProxy<Call>,
    /// Set when somebody wants the program to end from outside.
    pub(super) interrupted: Arc<AtomicBool>,
}

/// Who has the window.
pub(super) enum Here {
    Looking(Box<Looker>),
    Working(Box<App>),
    /// In between two lines of this file, and at the end.
    Nobody,
}

enum Way {
    ToWork(JoinHandle<anyhow::Result<Seated>>),
    ToLook(JoinHandle<anyhow::Result<Onlooker>>),
}

/// The window of a visit.
pub(super) struct Visit {
    pub(super) here: Here,
    way: Option<Way>,
    /// Whether the person had switched the force off when last at work.
    is_force_off: bool,
    means: Means,
}

impl Visit {
    pub(super) const fn new(here: Here, means: Means) -> Self {
        Self { here, way: None, is_force_off: false, means }
    }

    /// Who has the window at the end.
    pub(super) fn finish(self) -> Here {
        self.here
    }

    fn handler(&mut self) -> Option<&mut dyn ApplicationHandler<Call>> {
        match &mut self.here {
            Here::Looking(looker) => Some(looker.as_mut()),
            Here::Working(app) => Some(app.as_mut()),
            Here::Nobody => None,
        }
    }

    /// Sets out where the person wants to go, and goes there once everything is there.
    fn cross(&mut self) {
        match self.way.take() {
            None => self.way = self.set_out(),
            Some(Way::ToWork(way)) if way.is_finished() => {
                let came = self.means.runtime.block_on(way).map_err(Into::into).flatten();
                match came {
                    Ok(seated) => self.work(seated),
                    Err(error) => self.stay(&error),
                }
            }
            Some(Way::ToLook(way)) if way.is_finished() => {
                let came = self.means.runtime.block_on(way).map_err(Into::into).flatten();
                match came {
                    Ok(onlooker) => self.look(onlooker),
                    Err(error) => self.stay(&error),
                }
            }
            way => self.way = way,
        }
    }

    fn set_out(&mut self) -> Option<Way> {
        let Means { runtime, endpoint, session, target, .. } = &mut self.means;
        match &mut self.here {
            Here::Looking(looker) => {
                target.wheel = looker.take_seat_wish()?;
                let (endpoint, target, session) = (endpoint.clone(), target.clone(), session.clone());
                let is_off = self.is_force_off;
                let sit = async move { Seated::at(&endpoint, &target, &session, is_off).await?.whole().await };
                Some(Way::ToWork(runtime.spawn(sit)))
            }
            Here::Working(app) => {
                if !app.wants_to_look_on() {
                    return None;
                }
                let (endpoint, target, view) = (endpoint.clone(), target.clone(), app.lift());
                Some(Way::ToLook(runtime.spawn(async move {
                    let deadline = Instant::now() + SETTLE_WITHIN;
                    while !view.lock().settled && Instant::now() < deadline {
                        tokio::time::sleep(LOOK_EVERY).await;
                    }
                    look_on_from(endpoint, target).await
                })))
            }
            Here::Nobody => None,
        }
    }

    /// Stays where one is, since the way led nowhere.
    fn stay(&mut self, error: &anyhow::Error) {
        match &mut self.here {
            Here::Looking(looker) => looker.say(sentence(error.as_ref())),
            Here::Working(app) => app.stay(sentence(error.as_ref())),
            Here::Nobody => {}
        }
    }

    fn work(&mut self, seated: Seated) {
        let Here::Looking(looker) = std::mem::replace(&mut self.here, Here::Nobody) else { return };
        let (onlooker, seen) = looker.give_up();
        let Means { session, proxy, .. } = &self.means;
        let begin = Begin {
            held: seated.held(session),
            invitation: None,
            files: Files::new(None, None),
            keeper: Keeper::open(Preferences::file()),
            graphics: None,
            proxy: proxy.clone(),
        };
        let mut app = App::new(seated.potter, seated.asked, begin, &session.tool);
        app.go_on(seen);
        self.here = Here::Working(Box::new(app));
        self.leave(onlooker.leave());
    }

    fn look(&mut self, onlooker: Onlooker) {
        let Here::Working(app) = std::mem::replace(&mut self.here, Here::Nobody) else { return };
        let (potter, seen) = app.give_up();
        self.is_force_off = potter.status().is_force_off();
        let keeper = Keeper::open(Preferences::file());
        let wheel = self.means.target.wheel;
        let first = First::Wheel(wheel);
        let mut looker = Looker::new(onlooker, first, &keeper, None, self.means.proxy.clone()).with_seats();
        looker.go_on(wheel, seen);
        self.here = Here::Looking(Box::new(looker));
        self.leave(potter.leave());
    }

    /// Says goodbye beside what is done next.
    fn leave<T>(&self, leaving: impl Future<Output = Result<T, pottery_client::JoinError>> + Send + 'static) {
        self.means.runtime.spawn(async move {
            if let Err(error) = leaving.await {
                tracing::warn!(%error, "what was left did not end well");
            }
        });
    }
}

impl ApplicationHandler<Call> for Visit {
    fn user_event(&mut self, event_loop: &ActiveEventLoop, call: Call) {
        if let Some(handler) = self.handler() {
            handler.user_event(event_loop, call);
        }
    }

    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if let Some(handler) = self.handler() {
            handler.resumed(event_loop);
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, window: WindowId, event: WindowEvent) {
        if let Some(handler) = self.handler() {
            handler.window_event(event_loop, window, event);
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        if self.means.interrupted.load(Ordering::Relaxed) {
            event_loop.exit();
        }
        self.cross();
        if let Some(handler) = self.handler() {
            handler.about_to_wait(event_loop);
        }
    }
}
