//! The window on a session that is replayed: pot, tools and time, and nothing that presses.
//!
//! Owns the place in time and the view; the clay is the session's.
//! Invariant: nothing is drawn while nothing changes.

use std::time::{Duration, Instant};

use egui::{Align2, RichText};
use glam::Vec2;
use pottery_client::render::{Camera, Deflection, Scene, ToolView};
use pottery_shared::clay::{Surface, Window as Elements};
use pottery_shared::snapshot::Touched;
use pottery_shared::units::Tick;
use winit::application::ApplicationHandler;
use winit::event::{ElementState, MouseButton, MouseScrollDelta, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, NamedKey};
use winit::window::WindowId;

use super::app::colour;
use super::frame;
use super::overlay::{self, Call, Overlay};
use super::stage::{Pace, Picture, Stage};
use crate::replaying::{Session, seconds};
use crate::words::Words;

/// Time between looks at whether there is something to draw.
const FRAME_IDLE: Duration = Duration::from_millis(500);
/// What a key goes back or on by, s.
const LEAP_S: f64 = 5.0;
/// What stands in the line of the slider and at its ends, points.
const BESIDE_SLIDER: f32 = 190.0;
/// Ticks after which a resting tool is no longer shown, as at the wheel.
const TOOL_SHOWN_TICKS: i64 = 500;

/// The window's state.
pub(super) struct Player {
    session: Session,
    words: Words,
    proxy: EventLoopProxy<Call>,
    stage: Option<Stage>,
    overlay: Option<Overlay>,
    camera: Camera,
    /// How far the wall has given way under the tools.
    deflection: Deflection,
    is_playing: bool,
    /// When the tick was what it is, for the time since.
    stood: (Instant, Tick),
    /// Where the person wants to be, s.
    wish_s: Option<f64>,
    drawn: Option<Tick>,
    last_frame: Instant,
    is_dirty: bool,
    /// The next picture shows nothing new, only more sharply.
    only_sharpens: bool,
    is_turning_view: bool,
    cursor: Vec2,
    failure: Option<anyhow::Error>,
}

impl Player {
    pub(super) fn new(session: Session, words: Words, proxy: EventLoopProxy<Call>) -> Self {
        let camera = Camera::on(session.playback.replay().pot());
        let now = Instant::now();
        Self {
            stood: (now, session.playback.tick()),
            session,
            words,
            proxy,
            stage: None,
            overlay: None,
            camera,
            deflection: Deflection::default(),
            is_playing: true,
            wish_s: None,
            drawn: None,
            last_frame: now,
            is_dirty: true,
            only_sharpens: false,
            is_turning_view: false,
            cursor: Vec2::ZERO,
            failure: None,
        }
    }

    /// What went wrong.
    pub(super) fn finish(self) -> Option<anyhow::Error> {
        self.failure
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> anyhow::Result<()> {
        let (stage, overlay) = overlay::open(event_loop, self.proxy.clone(), "Pottery studio: replay", |window| {
            let pot = self.session.playback.replay().pot();
            Stage::new(window, event_loop.owned_display_handle(), None, pot)
        })?;
        self.overlay = Some(overlay);
        self.stage = Some(stage);
        Ok(())
    }

    /// Lets time pass, or goes where the person wants to be.
    fn go(&mut self) -> anyhow::Result<()> {
        let (since, from) = self.stood;
        let to = match self.wish_s.take() {
            Some(at_s) => {
                let to = self.session.tick_at(at_s.max(0.0));
                self.session.playback.seek(to)?;
                self.stood = (Instant::now(), to);
                to
            }
            None if self.is_playing => {
                let to = from.offset(since.elapsed().as_millis() as i64).min(self.session.span.1);
                self.session.playback.advance(to)?;
                to
            }
            None => return Ok(()),
        };
        self.is_playing &= to < self.session.span.1;
        Ok(())
    }

    fn play(&mut self, is_playing: bool) {
        self.is_playing = is_playing;
        self.stood = (Instant::now(), self.session.playback.tick());
        if is_playing && self.session.playback.tick() >= self.session.span.1 {
            self.wish_s = Some(0.0);
        }
    }

    fn tools(&self) -> Vec<ToolView> {
        let (playback, replay) = (&self.session.playback, self.session.playback.replay());
        let shown = replay.people().filter_map(|(client, sample)| {
            let sample = sample.filter(|sample| playback.tick().since(sample.tick) < TOOL_SHOWN_TICKS)?;
            let centre_m = sample.centre.point_m();
            let turn = sample.orientation.at(centre_m);
            let (tool, side, colour) = (sample.tool, sample.side, colour(client));
            Some(ToolView { tool, turn, centre_m, colour, touching: false, side, clay_m: None })
        });
        shown.collect()
    }

    fn draw(&mut self) -> anyhow::Result<()> {
        self.go()?;
        self.last_frame = Instant::now();
        let tools = self.tools();
        let (Some(stage), Some(overlay)) = (&mut self.stage, &mut self.overlay) else { return Ok(()) };
        if stage.is_lost() {
            stage.renew(self.session.playback.replay().pot(), overlay.letters())?;
        }
        let words = &self.words;
        let (playback, replay) = (&self.session.playback, self.session.playback.replay());
        if self.drawn.replace(playback.tick()) != Some(playback.tick()) {
            stage.upload(replay.pot(), &everything(replay.pot().surfaces()));
        }
        let (mut at_s, length_s) = (self.session.at_s(), seconds(self.session.span.1, self.session.span));
        let was_at_s = at_s;
        let mut is_playing = self.is_playing;
        let compared = match replay.comparison().first_unlike {
            None => words.say_with("replay-equal", &[("snapshots", &replay.comparison().snapshots.to_string())]),
            Some(tick) => {
                let at = words.number(seconds(tick, self.session.span), 3);
                words.say_with("replay-unlike", &[("seconds", &at)])
            }
        };
        let shapes = overlay.lay_out(&stage.window, |ui| {
            let window = egui::Window::new("time").title_bar(false).resizable(false);
            window.anchor(Align2::CENTER_BOTTOM, [0.0, -12.0]).show(ui.ctx(), |ui| {
                ui.horizontal(|ui| {
                    let switch = words.say(if is_playing { "replay-pause" } else { "replay-play" });
                    is_playing ^= ui.button(switch).clicked();
                    // beside it stand the switch and the seconds
                    let room = ui.ctx().content_rect().width() - BESIDE_SLIDER;
                    ui.spacing_mut().slider_width = room.clamp(60.0, 480.0);
                    let slider = egui::Slider::new(&mut at_s, 0.0..=length_s).suffix(" s");
                    let slider = slider.custom_formatter(|value, _| words.number(value, 1));
                    ui.add(slider.custom_parser(Words::parse));
                });
                ui.label(RichText::new(&compared).small());
                let leap = words.number(LEAP_S, 0);
                ui.label(RichText::new(words.say_with("replay-keys", &[("seconds", &leap)])).small());
            });
        });
        let (phase, rack) = (replay.conditions().phase(playback.tick()), replay.rack());
        let deflection = &mut self.deflection;
        deflection.follow(replay.pot(), (replay.conditions(), playback.tick()), &rack, &tools);
        let (camera, deflection) = (self.camera, Some(&*deflection));
        let scene = Scene { camera, phase, tools: &tools, rack: &rack, deflection, ..Scene::default() };
        let pace = if self.only_sharpens { Pace::Still } else { Pace::Moving };
        self.is_dirty = !stage.draw(&Picture::Pot(&scene), shapes, pace)?;
        if is_playing != self.is_playing {
            self.play(is_playing);
        }
        // the slider shows tenths and gives back what it was given until somebody moves it
        if (at_s - was_at_s).abs() > 0.05 {
            self.wish_s = Some(at_s);
        }
        Ok(())
    }

    fn key(&mut self, event_loop: &ActiveEventLoop, key: &Key, is_repeated: bool) {
        match key.as_ref() {
            Key::Named(NamedKey::Escape) => event_loop.exit(),
            Key::Named(NamedKey::Space) if !is_repeated => self.play(!self.is_playing),
            Key::Named(NamedKey::ArrowLeft) => self.wish_s = Some(self.session.at_s() - LEAP_S),
            Key::Named(NamedKey::ArrowRight) => self.wish_s = Some(self.session.at_s() + LEAP_S),
            Key::Named(NamedKey::Home) => self.wish_s = Some(0.0),
            Key::Character("r" | "R") => self.camera = Camera::on(self.session.playback.replay().pot()),
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

/// Every element: what a replay changed is not asked for.
fn everything(surfaces: &[Surface]) -> Touched {
    let mut touched = Touched::none(surfaces.iter().map(Surface::shape));
    for (number, surface) in surfaces.iter().enumerate() {
        let (columns, rows) = (surface.shape().columns(), surface.shape().rows());
        touched.add_window(number, Elements { first_column: 0, columns, first_row: 0, rows });
    }
    touched
}

impl ApplicationHandler<Call> for Player {
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
                if event.state == ElementState::Pressed && !is_panels =>
            {
                self.key(event_loop, &event.logical_key, event.repeat);
            }
            WindowEvent::CursorMoved { position, .. } => self.moved(Vec2::new(position.x as f32, position.y as f32)),
            WindowEvent::MouseInput { state, button: MouseButton::Left | MouseButton::Right, .. } => {
                self.is_turning_view = state == ElementState::Pressed && !is_panels;
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
        let Some(stage) = &self.stage else { return };
        let frame = frame(stage.gpu());
        let is_moving = self.is_dirty
            || stage.is_lost()
            || self.is_playing
            || self.wish_s.is_some()
            || self.overlay.as_ref().is_some_and(Overlay::is_moving);
        let due = if is_moving { frame } else { FRAME_IDLE };
        let since = self.last_frame.elapsed();
        // at rest one picture more, with every pixel
        if since >= due && (is_moving || stage.is_coarse()) {
            self.only_sharpens = !is_moving;
            stage.window.request_redraw();
        }
        let wait = if since >= due { frame } else { frame.min(due - since) };
        event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + wait));
    }
}
