//! A visit to somebody else's studio: waiting at its door, working at a wheel and looking on, in one window and by turns.
//!
//! Owns who of them has the window, and the way from one to the other; what each does there is its own.
//! Invariant: what was seen last is seen until the other holds clay that is whole, and whoever comes first is let in before the other leaves.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Context, bail, ensure};
use pottery_client::device::{Monitor, OpenedDevice, Pointer, pointer};
use pottery_client::sound::Sound;
use pottery_client::{Claim, Endpoint, Onlooker, Potter, PotterOptions, Priority, Target, sentence};
use pottery_shared::snapshot::Detail;
use tokio::runtime::Handle;
use tokio::sync::Notify;
use tokio::task::JoinHandle;
use winit::application::ApplicationHandler;
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::window::WindowId;

use super::app::{App, Begin, Held, Rates};
use super::door::Door;
use super::files::Files;
use super::looker::{First, Looker};
use super::overlay::Call;
use crate::arguments::{Place, WindowSession};
use crate::known;
use crate::preferences::{Keeper, Preferences};
use crate::record::Keeping;

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
    /// the wheel's clay is there. `asking` is told when a teacher is asked to let one in.
    pub(super) async fn at(
        endpoint: &Endpoint,
        target: &Target,
        session: &WindowSession,
        is_force_off: bool,
        asking: &Asking,
    ) -> anyhow::Result<Self> {
        let (asked, mouse) = pointer();
        let fit = Keeper::open(Preferences::file()).liking().fit(session.device.name());
        let chosen = session.device.clone().fitted(fit);
        let OpenedDevice { device, monitor } =
            chosen.open(mouse, &session.stroke).context("no thread for the device")?;
        let peak_n = device.specs().peak_force_n;
        let claim = Claim { is_raised: true, core: session.core, rate: session.rate };
        let options = PotterOptions { record: session.record.is_some(), claim, waits: true, is_force_off };
        let potter = Potter::join_asking(endpoint, target, device, options, || asking.tell()).await?;
        Ok(Self { potter, asked, monitor, peak_n })
    }

    /// Says and keeps what there is to say and to keep of a session that begins here, its recording as it grows.
    pub(super) fn begin(&self, session: &WindowSession) -> Option<Keeping> {
        if let Place::Joined(target) = &session.place {
            known::note(target, self.potter.view().lock().fingerprint);
        }
        if let Priority::Refused { .. } = self.potter.granted().priority {
            say!("note: the hand's thread has {}", self.potter.granted());
        }
        session.record.as_deref().map(|path| {
            let view = self.potter.view().clone();
            Keeping::begin(path, move || view.lock().recording.take())
        })
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

    /// The same once the wheel's clay is there.
    pub(super) async fn whole(self) -> anyhow::Result<Self> {
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

/// Tells whoever has the window that a teacher is asked to let one in.
#[derive(Clone, Debug, Default)]
pub(super) struct Asking {
    told: Arc<Notify>,
    is_told: Arc<AtomicBool>,
}

impl Asking {
    fn tell(&self) {
        self.is_told.store(true, Ordering::Relaxed);
        self.told.notify_one();
    }

    /// Whether that was told.
    pub(super) fn is_told(&self) -> bool {
        self.is_told.load(Ordering::Relaxed)
    }
}

/// How one came to a door.
pub(super) enum Came<T> {
    /// In at once.
    In(T),
    /// To where a teacher is asked.
    ToDoor(JoinHandle<anyhow::Result<T>>),
}

/// Goes a way until it is gone, or a teacher is asked to let one in.
pub(super) async fn knock<T: Send + 'static>(
    way: impl Future<Output = anyhow::Result<T>> + Send + 'static,
    asking: &Asking,
) -> anyhow::Result<Came<T>> {
    let mut way = tokio::spawn(way);
    tokio::select! {
        came = &mut way => Ok(Came::In(came??)),
        () = asking.told.notified() => Ok(Came::ToDoor(way)),
    }
}

/// Looks on at the target's studio. `asking` is told when a teacher is asked to let one in.
pub(super) async fn look_on(endpoint: &Endpoint, target: &Target, asking: &Asking) -> anyhow::Result<Onlooker> {
    Ok(Onlooker::join_asking(endpoint, target, WATCH_BYTES_PER_S, || asking.tell()).await?)
}

/// The same, from the wheel at which one works, once that is seen there.
async fn look_on_from(endpoint: Endpoint, target: Target) -> anyhow::Result<Onlooker> {
    let looker = look_on(&endpoint, &target, &Asking::default()).await?;
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
    /// How closely who only looks on was to be told of one wheel.
    pub(super) detail: Option<Detail>,
    /// Set when somebody wants the program to end from outside.
    pub(super) interrupted: Arc<AtomicBool>,
}

impl Means {
    /// What somebody who came to look on looks at first.
    pub(super) fn first_look(&self, onlooker: &Onlooker) -> anyhow::Result<First> {
        if let Place::Joined(target) = &self.session.place {
            known::note(target, onlooker.fingerprint());
        }
        let (wheel, wheels) = (self.target.wheel, onlooker.look(|watcher, _| watcher.wheels()));
        let Some(detail) = self.detail.filter(|detail| detail.shows_tools()) else { return Ok(First::Page) };
        ensure!(
            (1..=wheels).contains(&wheel),
            "there is no wheel {wheel} in this studio; its wheels are numbered from 1, and it has {wheels}"
        );
        Ok(First::Only(wheel, detail))
    }
}

/// Who has the window.
pub(super) enum Here {
    AtDoor(Box<Door>),
    Looking(Box<Looker>),
    Working(Box<App>),
    /// In between two lines of this file, and at the end.
    Nobody,
}

pub(super) enum Way {
    ToWork(JoinHandle<anyhow::Result<Seated>>),
    ToLook(JoinHandle<anyhow::Result<Onlooker>>),
}

/// The window of a visit.
pub(super) struct Visit {
    pub(super) here: Here,
    way: Option<Way>,
    /// Whether a teacher is asked on the way from looking on to a wheel.
    asking: Asking,
    /// Writes what is recorded, as it grows.
    keeping: Option<Keeping>,
    /// Whether the person had switched the force off when last at work.
    is_force_off: bool,
    means: Means,
}

impl Visit {
    pub(super) fn new(here: Here, means: Means) -> Self {
        Self { here, way: None, asking: Asking::default(), keeping: None, is_force_off: false, means }
    }

    /// The same, on the way in already.
    pub(super) fn on_way(self, way: Way) -> Self {
        Self { way: Some(way), ..self }
    }

    /// The same, with what is recorded written as it grows.
    pub(super) fn keeping(self, keeping: Option<Keeping>) -> Self {
        Self { keeping, ..self }
    }

    /// Who has the window at the end; whoever is on a way turns back.
    pub(super) fn finish(self) -> Here {
        match self.way {
            Some(Way::ToWork(way)) => way.abort(),
            Some(Way::ToLook(way)) => way.abort(),
            None => {}
        }
        self.here
    }

    /// Whence all of the visit's connections go.
    pub(super) const fn endpoint(&self) -> &Endpoint {
        &self.means.endpoint
    }

    fn handler(&mut self) -> Option<&mut dyn ApplicationHandler<Call>> {
        match &mut self.here {
            Here::AtDoor(door) => Some(door.as_mut()),
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
                    Err(error) => self.stay(error),
                }
            }
            Some(Way::ToLook(way)) if way.is_finished() => {
                let came = self.means.runtime.block_on(way).map_err(Into::into).flatten();
                match came {
                    Ok(onlooker) => self.look(onlooker),
                    Err(error) => self.stay(error),
                }
            }
            way => {
                if let (Here::Looking(looker), true) = (&mut self.here, self.asking.is_told()) {
                    looker.note_asking();
                }
                self.way = way;
            }
        }
    }

    fn set_out(&mut self) -> Option<Way> {
        let Means { runtime, endpoint, session, target, .. } = &mut self.means;
        match &mut self.here {
            Here::Looking(looker) => {
                target.wheel = looker.take_seat_wish()?;
                let (endpoint, target, session) = (endpoint.clone(), target.clone(), session.clone());
                let (is_off, asking) = (self.is_force_off, Asking::default());
                self.asking = asking.clone();
                let sit = async move { Seated::at(&endpoint, &target, &session, is_off, &asking).await?.whole().await };
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
            Here::AtDoor(_) | Here::Nobody => None,
        }
    }

    /// Stays where one is, since the way led nowhere.
    fn stay(&mut self, error: anyhow::Error) {
        match &mut self.here {
            Here::AtDoor(door) => door.refuse(error),
            Here::Looking(looker) => looker.say(sentence(error.as_ref())),
            Here::Working(app) => app.stay(sentence(error.as_ref())),
            Here::Nobody => {}
        }
    }

    fn work(&mut self, seated: Seated) {
        let Means { session, proxy, .. } = &self.means;
        let (seen, onlooker, opened) = match std::mem::replace(&mut self.here, Here::Nobody) {
            Here::AtDoor(door) => {
                self.keeping = seated.begin(session);
                (door.give_up(), None, session.opened.as_deref())
            }
            Here::Looking(looker) => {
                let (onlooker, seen) = looker.give_up();
                (seen, Some(onlooker), None)
            }
            here => {
                self.here = here;
                return;
            }
        };
        let begin = Begin {
            held: seated.held(session),
            invitation: None,
            files: Files::new(opened, None),
            keeper: Keeper::open(Preferences::file()),
            graphics: None,
            proxy: proxy.clone(),
        };
        let mut app = App::new(seated.potter, seated.asked, begin, &session.tool).for_visitor(session.record.is_none());
        app.go_on(seen);
        self.here = Here::Working(Box::new(app));
        if let Some(onlooker) = onlooker {
            self.leave(onlooker.leave());
        }
    }

    fn look(&mut self, onlooker: Onlooker) {
        let keeper = Keeper::open(Preferences::file());
        let proxy = self.means.proxy.clone();
        match std::mem::replace(&mut self.here, Here::Nobody) {
            Here::AtDoor(mut door) => match self.means.first_look(&onlooker) {
                Ok(first) => {
                    let mut looker = Looker::new(onlooker, first, &keeper, None, proxy).with_seats();
                    looker.begin_in(door.give_up());
                    self.here = Here::Looking(Box::new(looker));
                }
                Err(error) => {
                    door.refuse(error);
                    self.here = Here::AtDoor(door);
                    self.leave(onlooker.leave());
                }
            },
            Here::Working(app) => {
                let (potter, seen) = app.give_up();
                self.is_force_off = potter.status().is_force_off();
                let wheel = self.means.target.wheel;
                let mut looker = Looker::new(onlooker, First::Wheel(wheel), &keeper, None, proxy).with_seats();
                looker.go_on(wheel, seen);
                self.here = Here::Looking(Box::new(looker));
                self.leave(potter.leave());
            }
            here => self.here = here,
        }
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
