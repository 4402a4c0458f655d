//! The window of somebody who looks on: all wheels at a glance, or one of them closely, and nothing that presses.
//!
//! Owns the view, which wheel is looked at and how closely; the clay is the onlooker's.
//! Invariant: nothing is drawn while nothing changes, the wheel that is clicked on is the one that is shown, and what was seen of a wheel is
//! seen until there is more.

mod place;

use std::sync::Arc;
use std::time::{Duration, Instant};

use egui::{Align2, RichText};
use glam::Vec2;
use pottery_client::Onlooker;
use pottery_client::render::{Camera, Deflection, GalleryScene, GpuAhead, Scene, ToolView, WheelView};
use pottery_client::view::Link;
use pottery_shared::clay::{Conditions, Pot, PotSpec, Target};
use pottery_shared::session::Watched;
use pottery_shared::snapshot::Detail;
use pottery_shared::tool::{ConvexTool, rack};
use pottery_shared::units::Tick;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, NamedKey};
use winit::window::WindowId;

use self::place::Place;
pub(super) use self::place::tool_view;
use super::closeness::{self, Asked};
use super::frame;
use super::ghost;
use super::overlay::{self, Call, Overlay};
use super::panel::{dress, show_line};
use super::stage::{Pace, Picture, Seen, Stage};
use super::tiles::Tiles;
use crate::preferences::{Keeper, Preferences};
use crate::words::Words;

/// Time between looks at whether there is something to draw.
const FRAME_IDLE: Duration = Duration::from_millis(500);
/// Size of the picture of one wheel's profile, points.
const PICTURE: egui::Vec2 = egui::vec2(220.0, 110.0);
/// Wheels on one page, and of how many of them another detail may be on its way: fewer than a server shows to one person, together and with
/// one that is looked at closely.
const PAGE: u16 = 60;
const CHANGING_MAX: usize = 3;
/// Time between two such requests: a server takes twenty a second.
const CHANGE_EVERY: Duration = Duration::from_millis(66);
/// What stands over the window.
const TITLE: &str = "Pottery studio: looking on";
/// Size of the window before there is one, pixels.
const WINDOW: (u32, u32) = (1280, 800);

/// The way to a place at the wheel that is looked at.
#[derive(Default)]
struct Seat {
    is_offered: bool,
    is_wanted: bool,
    is_coming: bool,
    is_asking: bool,
    refusal: Option<String>,
}

/// What is looked at first.
#[derive(Clone, Copy)]
pub(super) enum First {
    /// All wheels.
    Page,
    /// The wheel from which one comes, of which there is a sight already; all of them later on.
    Wheel(u16),
    /// Nothing but this wheel, ever.
    Only(u16, Detail),
}

/// The window's state.
pub(super) struct Looker {
    onlooker: Onlooker,
    words: Words,
    liking: Preferences,
    proxy: EventLoopProxy<Call>,
    /// Until the window is there.
    graphics: Option<GpuAhead>,
    stage: Option<Stage>,
    overlay: Option<Overlay>,
    camera: Camera,
    rack: Arc<[ConvexTool]>,
    /// How far the wall that is closely looked at has given way.
    deflection: Deflection,
    /// What the studio's pots are made of.
    spec: PotSpec,
    /// What the page's pictures and the close look need, and when the last picture's was asked for.
    pictures: Asked,
    closely: Asked,
    asked_at: Instant,
    /// What the close look was to be, by the command line.
    close_detail: Detail,
    /// Number of wheels, and the first of the page.
    wheels: u16,
    first: u16,
    places: Vec<Place>,
    /// What all pots are to become.
    target: Option<Target>,
    /// The wheel that is looked at closely, whether it is the only one that ever is, and whether its pot is the painter's.
    close: Option<u16>,
    is_alone: bool,
    is_close_shown: bool,
    /// Whether the view is one of that pot.
    is_framed: bool,
    /// The person wants to see this wheel closely, or all of them again.
    wish: Option<Option<u16>>,
    /// Whether one may work at a wheel from here, wants to, is on the way there, has to wait for a teacher, and why it led nowhere.
    seat: Seat,
    /// By how much the server's ticks are ahead of the own milliseconds, as the quickest word had it, of this connection.
    started: Instant,
    ahead: Option<i64>,
    link: Link,
    /// Whether nothing was heard on this connection yet, which may be to a server that has counted anew.
    is_anew: bool,
    last_frame: Instant,
    is_dirty: bool,
    is_turning_view: bool,
    cursor: Vec2,
    failure: Option<anyhow::Error>,
}

impl Looker {
    /// Looks on, without a window yet.
    pub(super) fn new(
        onlooker: Onlooker,
        first: First,
        keeper: &Keeper,
        graphics: Option<GpuAhead>,
        proxy: EventLoopProxy<Call>,
    ) -> Self {
        let (wheels, spec) = onlooker.look(|watcher, _| (watcher.wheels(), *watcher.pot_spec()));
        let (close, close_detail) = match first {
            First::Page => (None, Detail::RETOLD),
            First::Wheel(wheel) => (Some(wheel), Detail::RETOLD),
            First::Only(wheel, detail) => (Some(wheel), detail),
        };
        let now = Instant::now();
        let mut looker = Self {
            onlooker,
            words: keeper.words(),
            liking: keeper.liking().clone(),
            proxy,
            graphics,
            stage: None,
            overlay: None,
            camera: Camera::default(),
            rack: rack::standard(),
            deflection: Deflection::default(),
            spec,
            pictures: Asked::new(Detail::GALLERY),
            closely: Asked::new(close_detail),
            asked_at: now,
            close_detail,
            wheels,
            // of the page on which it is
            first: 1 + close.map_or(0, |wheel| (wheel - 1) / PAGE * PAGE),
            places: Vec::new(),
            target: None,
            close,
            is_alone: matches!(first, First::Only(..)),
            is_close_shown: false,
            is_framed: false,
            wish: None,
            seat: Seat::default(),
            started: now,
            ahead: None,
            link: Link::Open,
            is_anew: true,
            last_frame: now,
            is_dirty: true,
            is_turning_view: false,
            cursor: Vec2::ZERO,
            failure: None,
        };
        match first {
            First::Only(wheel, detail) => {
                looker.places = vec![Place::new(wheel, Detail::GALLERY)];
                looker.onlooker.look(|watcher, now| watcher.watch(wheel, detail, now));
            }
            First::Page | First::Wheel(_) => looker.turn_page(0),
        }
        looker
    }

    /// The onlooker, to leave with, and what went wrong.
    pub(super) fn finish(self) -> (Onlooker, Option<anyhow::Error>) {
        (self.onlooker, self.failure)
    }

    /// The same, for who may work at the wheels as well.
    pub(super) fn with_seats(mut self) -> Self {
        self.seat.is_offered = true;
        self
    }

    /// The wheel at which the person wants to work, said once.
    pub(super) fn take_seat_wish(&mut self) -> Option<u16> {
        let wheel = self.close.filter(|_| std::mem::take(&mut self.seat.is_wanted))?;
        (self.seat.is_coming, self.seat.is_asking, self.seat.refusal) = (true, false, None);
        self.is_dirty = true;
        Some(wheel)
    }

    /// Says that a teacher is asked.
    pub(super) fn note_asking(&mut self) {
        self.is_dirty |= !std::mem::replace(&mut self.seat.is_asking, true);
    }

    /// Looks on after all, and says why.
    pub(super) fn say(&mut self, reason: String) {
        (self.seat.is_coming, self.seat.refusal) = (false, Some(reason));
        self.is_dirty = true;
    }

    /// Takes over a window that showed no wheel yet.
    pub(super) fn begin_in(&mut self, seen: Option<Seen>) {
        let Some(Seen { mut stage, overlay, .. }) = seen else { return };
        stage.window.set_title(TITLE);
        stage.show_gallery(&self.untouched(self.pictures.detail()), self.places.len());
        (self.stage, self.overlay) = (Some(stage), Some(overlay));
    }

    /// Takes over a window that showed a wheel of which there is a sight already.
    pub(super) fn go_on(&mut self, wheel: u16, seen: Option<Seen>) {
        let Some(Seen { mut stage, overlay, camera }) = seen else { return };
        stage.window.set_title(TITLE);
        self.go(Some(wheel));
        let camera_before = camera;
        self.onlooker.look(|watcher, _| {
            if let Some(sight) = watcher.sight(wheel) {
                stage.show_pot(sight.pot());
            }
        });
        (self.stage, self.overlay, self.camera) = (Some(stage), Some(overlay), camera_before);
        (self.is_close_shown, self.is_framed) = (true, true);
    }

    /// The onlooker, to leave with, and the window.
    pub(super) fn give_up(self) -> (Onlooker, Option<Seen>) {
        let seen = self.stage.zip(self.overlay);
        (self.onlooker, seen.map(|(stage, overlay)| Seen { stage, overlay, camera: self.camera }))
    }

    /// Shows other wheels, so many pages on.
    fn turn_page(&mut self, by: i32) {
        let last = (self.wheels.saturating_sub(1)) / PAGE;
        let page = (i32::from((self.first - 1) / PAGE) + by).clamp(0, i32::from(last)) as u16;
        self.first = 1 + page * PAGE;
        let shown = self.first..=self.wheels.min(self.first + PAGE - 1);
        self.camera = page_camera();
        let pictures = self.picture_detail(shown.clone().count());
        self.pictures = Asked::new(pictures);
        self.onlooker.look(|watcher, now| {
            for place in self.places.iter().filter(|place| !shown.contains(&place.wheel)) {
                watcher.unwatch(place.wheel);
            }
            // a small picture of the wheel that is looked at closely would take the place of the close look
            for wheel in shown.clone().filter(|wheel| Some(*wheel) != self.close) {
                watcher.watch(wheel, pictures, now);
            }
        });
        self.places = shown.map(|wheel| Place::new(wheel, pictures)).collect();
        self.show_all();
    }

    /// Draws the page from now on, wheel by wheel as they come.
    fn show_all(&mut self) {
        (self.close, self.is_close_shown) = (None, false);
        for place in &mut self.places {
            place.is_sent = false;
        }
        self.show_pictures();
        self.camera = page_camera();
        self.is_dirty = true;
    }

    /// Draws small pictures of what is there of each wheel.
    fn show_pictures(&mut self) {
        let pot = self.untouched(self.pictures.detail());
        for place in &mut self.places {
            place.is_sent = false;
        }
        if let Some(stage) = &mut self.stage {
            stage.show_gallery(&pot, self.places.len());
        }
    }

    /// What the small pictures of so many wheels can show; where the processor draws, as on half as many pixels.
    fn picture_detail(&self, wheels: usize) -> Detail {
        let size = self.stage.as_ref().map_or(WINDOW, |stage| stage.window.inner_size().into());
        let (width, height) = (size.0.max(1) as f32, size.1.max(1) as f32);
        let (_, half) = Tiles::of(wheels, width / height).place(0);
        let coarseness = if self.stage.as_ref().is_some_and(|stage| !stage.gpu().is_software()) { 1.0 } else { 2.0 };
        closeness::of_picture(&self.camera, &self.spec, half.y * height, half.x / half.y * width / height, coarseness)
    }

    /// Asks for other details where the pictures' size or the close view has come to show more or less.
    fn ask_for_detail(&mut self) {
        let now = Instant::now();
        match self.close {
            Some(wheel) if self.is_close_shown => {
                let wanted = self.onlooker.look(|watcher, _| match watcher.keeps_up() {
                    true if self.close_detail.is_retold() => Detail::RETOLD,
                    _ => self.part_in_view(watcher.sight(wheel)),
                });
                if self.closely.wants(wanted, now) {
                    self.onlooker.look(|watcher, now| watcher.watch(wheel, wanted, now));
                }
            }
            Some(_) => {}
            None => {
                if self.pictures.wants(self.picture_detail(self.places.len()), now) {
                    self.show_pictures();
                    self.is_dirty = true;
                }
                let wanted = self.pictures.detail();
                let place = self.places.iter_mut().find(|place| place.asked != wanted);
                let Some(place) = place.filter(|_| self.asked_at.elapsed() >= CHANGE_EVERY) else { return };
                let is_asked = self.onlooker.look(|watcher, now| {
                    let has_room = watcher.changing() < CHANGING_MAX;
                    if has_room {
                        watcher.watch(place.wheel, wanted, now);
                    }
                    has_room
                });
                if is_asked {
                    (place.asked, self.asked_at) = (wanted, now);
                }
            }
        }
    }

    /// What a close look takes that is told by deltas: the rows that are in view.
    fn part_in_view(&self, sight: Option<&Watched>) -> Detail {
        let detail = if self.close_detail.is_retold() { Detail::SPECTATOR } else { self.close_detail };
        let (Some(sight), Some(stage)) = (sight, &self.stage) else { return detail };
        let size = stage.window.inner_size();
        let aspect = size.width.max(1) as f32 / size.height.max(1) as f32;
        let grid = detail.grid_of(self.spec.shape);
        detail.in_band(closeness::band_in(&self.camera, &sight.pot().surfaces()[0], aspect, grid))
    }

    /// The studio's pot before anybody touched it, as a detail has it.
    fn untouched(&self, detail: Detail) -> Pot {
        let spec = PotSpec { shape: detail.grid_of(self.spec.shape), ..self.spec };
        Pot::new(spec).expect("a studio's pot can be made on a coarser grid")
    }

    fn go(&mut self, wish: Option<u16>) {
        match wish {
            Some(wheel) => {
                let detail = self.close_detail;
                self.closely = Asked::new(detail);
                self.onlooker.look(|watcher, now| watcher.watch(wheel, detail, now));
                (self.close, self.is_close_shown, self.is_framed) = (Some(wheel), false, false);
            }
            None => {
                if let Some(wheel) = self.close.take() {
                    let pictures = self.pictures.detail();
                    self.onlooker.look(|watcher, now| watcher.watch(wheel, pictures, now));
                    for place in self.places.iter_mut().filter(|place| place.wheel == wheel) {
                        place.asked = pictures;
                    }
                }
                self.show_all();
            }
        }
        self.is_dirty = true;
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> anyhow::Result<()> {
        let (graphics, pot) = (self.graphics.take(), self.untouched(self.pictures.detail()));
        let (mut stage, overlay) = overlay::open(event_loop, self.proxy.clone(), TITLE, |window| {
            Stage::new(window, event_loop.owned_display_handle(), graphics, &pot)
        })?;
        stage.show_gallery(&pot, self.places.len());
        (self.stage, self.overlay) = (Some(stage), Some(overlay));
        Ok(())
    }

    /// Takes in what there is of every wheel; what has changed is drawn next.
    fn look(&mut self) {
        let link = self.onlooker.link();
        self.is_anew |= link != Link::Open;
        self.is_dirty |= self.link != link;
        self.link = link;
        let Some(stage) = &mut self.stage else { return };
        let passed = self.started.elapsed().as_millis() as i64;
        let (places, close) = (&mut self.places, self.close);
        let (is_close_shown, rack, deflection) = (&mut self.is_close_shown, &mut self.rack, &mut self.deflection);
        let (ahead, is_anew, target) = (&mut self.ahead, &mut self.is_anew, &mut self.target);
        let mut is_news = false;
        let (camera, is_framed) = (&mut self.camera, &mut self.is_framed);
        self.onlooker.look(|watcher, _| {
            if let Some(heard) = watcher.tick().map(|tick| tick.0 as i64 - passed) {
                *ahead = Some(heard).max(ahead.filter(|_| !*is_anew));
                *is_anew = false;
            }
            // tools that people bring hang in the rack of their wheel
            if let Some(known) = close.and_then(|wheel| watcher.rack(wheel))
                && !Arc::ptr_eq(&known, rack)
            {
                (*rack, is_news) = (known, true);
            }
            let now = Tick(ahead.map_or(0, |ahead| passed + ahead).max(0) as u64);
            let is_other = target.as_ref() != watcher.target();
            if is_other {
                *target = watcher.target().cloned();
            }
            for (number, place) in places.iter_mut().enumerate() {
                is_news |= place.standing.hear(place.wheel, watcher.class().people());
                let told = watcher.class().progress().get(&place.wheel).cloned();
                let Some(sight) = watcher.sight_mut(place.wheel) else { continue };
                is_news |= place.take_in(sight, now);
                if is_other || !place.changed.is_empty() {
                    place.standing.note_change();
                }
                is_news |= place.standing.compare(target.as_ref(), told.as_ref(), sight.pot());
                let is_closely = sight.detail().shows_tools();
                if close == Some(place.wheel) && is_closely {
                    if !*is_close_shown {
                        stage.show_pot(sight.pot());
                        // who looked at it before another device drew it looks at it as before
                        if !*is_framed {
                            *camera = Camera::on(sight.pot());
                        }
                        (*is_close_shown, *is_framed, is_news) = (true, true, true);
                    }
                    stage.upload(sight.pot(), &place.changed);
                    place.changed.clear();
                    // how wet the clay is, who looks on is not told: the wall gives way by as much, since what is firmer yields later
                    let conditions = Conditions { wheel: sight.wheel().clone(), ..Conditions::default() };
                    let touching: Vec<_> = place.tools.iter().filter(|tool| tool.touching).map(tool_view).collect();
                    deflection.follow(sight.pot(), (&conditions, now), rack, &touching);
                } else {
                    is_news |= place.send(stage, number, sight.pot());
                }
            }
        });
        self.is_dirty |= is_news;
    }

    /// Another device in the place of one that was lost; everything is shown to it anew.
    fn renew_stage(&mut self) -> anyhow::Result<()> {
        let pot = self.untouched(self.pictures.detail());
        let (Some(stage), Some(overlay)) = (&mut self.stage, &self.overlay) else { return Ok(()) };
        if stage.is_lost() {
            stage.renew(&pot, overlay.letters())?;
            self.is_close_shown = false;
            if self.close.is_none() {
                self.show_all();
            }
        }
        Ok(())
    }

    fn draw(&mut self) -> anyhow::Result<()> {
        self.last_frame = Instant::now();
        if let Some(wish) = self.wish.take() {
            self.go(wish);
        }
        self.renew_stage()?;
        self.look();
        let (Some(stage), Some(overlay)) = (&mut self.stage, &mut self.overlay) else { return Ok(()) };
        let size = stage.window.inner_size();
        let tiles = Tiles::of(self.places.len(), size.width.max(1) as f32 / size.height.max(1) as f32);
        let (words, places, link) = (&self.words, &self.places, &self.link);
        let (target, camera) = (self.target.as_ref(), &self.camera);
        let (close, is_alone) = (self.close.filter(|_| self.is_close_shown), self.is_alone);
        let has_more = self.wheels > PAGE;
        let is_waiting = places.iter().all(|place| !place.is_sent) && close.is_none();
        let (mut wish, liking, seat) = (None, &self.liking, &mut self.seat);
        overlay.enlarge(&stage.window, f32::from(liking.text_percent) / 100.0);
        let shapes = overlay.lay_out(&stage.window, |ui| {
            let context = ui.ctx();
            dress(context, liking);
            match close {
                Some(wheel) => {
                    if let Some(target) = target {
                        ghost::show_target(context, camera, target);
                    }
                    let place = places.iter().find(|place| place.wheel == wheel);
                    wish = wish.or(place.and_then(|place| show_close(context, words, place, target, is_alone, seat)));
                }
                None => {
                    let said = |number: usize| places[number].standing.said(words, places[number].wheel);
                    let paint = |number: usize, painter: &egui::Painter, part| {
                        places[number].standing.paint(painter, part, target);
                    };
                    wish = wish.or(tiles.show(context, said, paint).map(|number| Some(places[number].wheel)));
                    let keys = words.say(if has_more { "page-keys-more" } else { "page-keys" });
                    show_line(context, Align2::LEFT_TOP, &keys);
                }
            }
            let said = match link {
                Link::Open if seat.is_coming && seat.is_asking => Some(words.say("waits-at-door")),
                Link::Open if seat.is_coming => Some(words.say("taking-place")),
                Link::Open => seat.refusal.clone().or_else(|| is_waiting.then(|| words.say("waiting-for-wheels"))),
                Link::ComingBack(_) => Some(words.say("looking-again")),
                Link::Waiting => Some(words.say("waiting")),
                Link::Closed => Some(words.say("closed")),
                Link::Lost(reason) => Some(reason.clone()),
            };
            if let Some(said) = said {
                egui::Window::new("notice").title_bar(false).anchor(Align2::CENTER_TOP, [0.0, 24.0]).show(
                    context,
                    |ui| {
                        ui.label(RichText::new(said).strong());
                    },
                );
            }
        });
        self.wish = wish;
        let is_seen = match close.and_then(|wheel| self.places.iter().find(|place| place.wheel == wheel)) {
            Some(place) => {
                let tools: Vec<ToolView> = place.tools.iter().map(tool_view).collect();
                let rack = &self.rack;
                let (camera, phase, deflection) = (self.camera, place.phase, Some(&self.deflection));
                let scene = Scene { camera, phase, tools: &tools, rack, deflection, ..Scene::default() };
                stage.draw(&Picture::Pot(&scene), shapes, Pace::Lasting)?
            }
            None => {
                let sent: Vec<WheelView> =
                    self.places.iter().enumerate().map(|(at, place)| place.view(&tiles, at)).collect();
                let wheels = if is_waiting { &[] } else { &sent[..] };
                let scene = GalleryScene { camera: self.camera, wheels, wetness: Scene::default().wetness };
                stage.draw(&Picture::Gallery(&scene), shapes, Pace::Lasting)?
            }
        };
        self.is_dirty = self.wish.is_some() || !is_seen;
        Ok(())
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, key: &Key) {
        match key.as_ref() {
            Key::Named(NamedKey::Escape) if self.close.is_some() && !self.is_alone => self.wish = Some(None),
            Key::Named(NamedKey::Escape) => event_loop.exit(),
            Key::Named(NamedKey::PageDown) if self.close.is_none() => self.turn_page(1),
            Key::Named(NamedKey::PageUp) if self.close.is_none() => self.turn_page(-1),
            Key::Named(NamedKey::ArrowLeft) => self.camera.azimuth_rad -= 0.1,
            Key::Named(NamedKey::ArrowRight) => self.camera.azimuth_rad += 0.1,
            _ => {}
        }
    }

    fn moved(&mut self, to: Vec2) {
        let by = to - self.cursor;
        self.cursor = to;
        if self.is_turning_view {
            self.camera.turn(by);
        }
    }
}

/// Where the wheels of a page are seen from.
fn page_camera() -> Camera {
    Camera { distance_m: 1.25 * Camera::default().distance_m, ..Camera::default() }
}

/// What stands over one wheel; the way back, if the person wants it.
fn show_close(
    context: &egui::Context,
    words: &Words,
    place: &Place,
    target: Option<&Target>,
    is_alone: bool,
    seat: &mut Seat,
) -> Option<Option<u16>> {
    let mut wish = None;
    let window = egui::Window::new("wheel").title_bar(false).resizable(false).anchor(Align2::LEFT_TOP, [12.0, 12.0]);
    window.show(context, |ui| {
        ui.label(RichText::new(place.standing.said(words, place.wheel)).strong());
        if target.is_some() {
            let (response, painter) = ui.allocate_painter(PICTURE, egui::Sense::hover());
            place.standing.paint_in(&painter, response.rect, target);
        }
        if seat.is_offered && !seat.is_coming && ui.button(words.say("work-here")).clicked() {
            seat.is_wanted = true;
        }
        if !is_alone && ui.button(words.say("all-wheels")).clicked() {
            wish = Some(None);
        }
        ui.label(RichText::new(words.say(if is_alone { "close-keys-alone" } else { "close-keys" })).small());
    });
    wish
}

impl ApplicationHandler<Call> for Looker {
    fn user_event(&mut self, _: &ActiveEventLoop, call: Call) {
        if let Some(overlay) = &mut self.overlay {
            overlay.take_call(call);
            self.is_dirty = true;
        }
    }

    fn resumed(&mut self, event_loop: &ActiveEventLoop) {
        if self.stage.is_none()
            && let Err(error) = self.open(event_loop)
        {
            self.failure = Some(error);
            event_loop.exit();
        }
    }

    fn window_event(&mut self, event_loop: &ActiveEventLoop, _: WindowId, event: WindowEvent) {
        let is_panels = overlay::take_event(self.stage.as_mut(), self.overlay.as_mut(), &event);
        self.is_dirty |= !matches!(event, WindowEvent::RedrawRequested);
        match event {
            WindowEvent::CloseRequested => event_loop.exit(),
            WindowEvent::RedrawRequested => {
                if let Err(error) = self.draw() {
                    self.failure = Some(error);
                    event_loop.exit();
                }
            }
            WindowEvent::KeyboardInput { event, is_synthetic: false, .. }
                // Esc leads back once, not further while it is held down
                if event.state == ElementState::Pressed
                    && !is_panels
                    && !(event.repeat && event.logical_key == Key::Named(NamedKey::Escape)) =>
            {
                self.key(event_loop, &event.logical_key);
            }
            WindowEvent::CursorMoved { position, .. } => self.moved(Vec2::new(position.x as f32, position.y as f32)),
            WindowEvent::MouseInput { state, button: MouseButton::Left | MouseButton::Right, .. } => {
                let is_one = self.close.is_some() && !is_panels;
                self.is_turning_view = state == ElementState::Pressed && is_one;
            }
            WindowEvent::MouseWheel { delta, .. } if !is_panels => {
                let lines = match delta {
                    MouseScrollDelta::LineDelta(_, lines) => lines,
                    MouseScrollDelta::PixelDelta(pixels) => pixels.y as f32 / 40.0,
                };
                self.camera.distance_m = (self.camera.distance_m * 0.9_f32.powf(lines)).clamp(0.25, 4.0);
            }
            WindowEvent::Focused(false) => self.is_turning_view = false,
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        self.ask_for_detail();
        self.look();
        let Some(stage) = &self.stage else { return };
        let frame = frame(stage.gpu());
        let is_moving = self.is_dirty
            || stage.is_lost()
            || self.wish.is_some()
            || self.overlay.as_ref().is_some_and(Overlay::is_moving);
        let due = if is_moving { frame } else { FRAME_IDLE };
        let since = self.last_frame.elapsed();
        // who waits for wheels is told when they come or the studio has closed
        if since >= due {
            stage.window.request_redraw();
        }
        let wait = if since >= due { frame } else { frame.min(due - since) };
        event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + wait));
    }
}
