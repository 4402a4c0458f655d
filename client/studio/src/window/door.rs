//! The window of somebody whom a teacher has not let in yet: what is waited for, and what came of it.
//!
//! Owns the window until there is clay to show in it; the way in is the visit's.
//! Invariant: whoever is not let in reads why before the window closes.

use std::time::{Duration, Instant};

use egui::{Align2, RichText};
use pottery_client::render::{Camera, GalleryScene, GpuAhead, Scene};
use pottery_client::sentence;
use pottery_shared::clay::{Pot, PotSpec};
use winit::application::ApplicationHandler;
use winit::event::{ElementState, WindowEvent};
use winit::event_loop::{ActiveEventLoop, ControlFlow, EventLoopProxy};
use winit::keyboard::{Key, NamedKey};
use winit::window::WindowId;

use super::frame;
use super::overlay::{self, Call, Overlay};
use super::panel::{dress, show_line};
use super::stage::{Pace, Picture, Seen, Stage};
use crate::preferences::{Keeper, Preferences};
use crate::words::Words;

/// Time between looks at whether there is something to draw, and whether the door has opened.
const LOOK_EVERY: Duration = Duration::from_millis(100);
/// What stands over the window.
const TITLE: &str = "Pottery studio: waiting";

/// The window's state.
pub(super) struct Door {
    words: Words,
    liking: Preferences,
    proxy: EventLoopProxy<Call>,
    /// Until the window is there.
    graphics: Option<GpuAhead>,
    stage: Option<Stage>,
    overlay: Option<Overlay>,
    /// Why one is not let in.
    refusal: Option<anyhow::Error>,
    is_dirty: bool,
    failure: Option<anyhow::Error>,
}

impl Door {
    pub(super) fn new(keeper: &Keeper, graphics: Option<GpuAhead>, proxy: EventLoopProxy<Call>) -> Self {
        Self {
            words: keeper.words(),
            liking: keeper.liking().clone(),
            proxy,
            graphics,
            stage: None,
            overlay: None,
            refusal: None,
            is_dirty: true,
            failure: None,
        }
    }

    /// Says why one is not let in.
    pub(super) fn refuse(&mut self, why: anyhow::Error) {
        self.refusal = Some(why);
        self.is_dirty = true;
    }

    /// The window, for what there is to see behind the door.
    pub(super) fn give_up(self) -> Option<Seen> {
        let seen = self.stage.zip(self.overlay);
        seen.map(|(stage, overlay)| Seen { stage, overlay, camera: Camera::default() })
    }

    /// What went wrong: with the window, or on the way in.
    pub(super) fn finish(self) -> Option<anyhow::Error> {
        self.failure.or(self.refusal)
    }

    fn open(&mut self, event_loop: &ActiveEventLoop) -> anyhow::Result<()> {
        let (graphics, pot) = (self.graphics.take(), untouched());
        let (mut stage, overlay) = overlay::open(event_loop, self.proxy.clone(), TITLE, |window| {
            Stage::new(window, event_loop.owned_display_handle(), graphics, &pot)
        })?;
        stage.show_gallery(&pot, 0);
        (self.stage, self.overlay) = (Some(stage), Some(overlay));
        Ok(())
    }

    fn draw(&mut self) -> anyhow::Result<()> {
        let (Some(stage), Some(overlay)) = (&mut self.stage, &mut self.overlay) else { return Ok(()) };
        if stage.is_lost() {
            let pot = untouched();
            stage.renew(&pot, overlay.letters())?;
            stage.show_gallery(&pot, 0);
        }
        let (words, liking) = (&self.words, &self.liking);
        let said = self.refusal.as_ref().map_or_else(|| words.say("waits-at-door"), |why| sentence(why.as_ref()));
        overlay.enlarge(&stage.window, f32::from(liking.text_percent) / 100.0);
        let shapes = overlay.lay_out(&stage.window, |ui| {
            let context = ui.ctx();
            dress(context, liking);
            let notice = egui::Window::new("notice").title_bar(false).resizable(false);
            notice.anchor(Align2::CENTER_CENTER, [0.0, 0.0]).show(context, |ui| {
                ui.label(RichText::new(said.as_str()).strong());
            });
            show_line(context, Align2::LEFT_TOP, &words.say("door-keys"));
        });
        let scene = GalleryScene { camera: Camera::default(), wheels: &[], wetness: Scene::default().wetness };
        self.is_dirty = !stage.draw(&Picture::Gallery(&scene), shapes, Pace::Lasting)?;
        Ok(())
    }
}

/// A pot by which a stage may be made.
fn untouched() -> Pot {
    Pot::new(PotSpec::default()).expect("the usual pot can be made")
}

impl ApplicationHandler<Call> for Door {
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
                if event.state == ElementState::Pressed
                    && !is_panels
                    && event.logical_key == Key::Named(NamedKey::Escape) =>
            {
                event_loop.exit();
            }
            _ => {}
        }
    }

    fn about_to_wait(&mut self, event_loop: &ActiveEventLoop) {
        let Some(stage) = &self.stage else { return };
        let is_moving = self.is_dirty || stage.is_lost() || self.overlay.as_ref().is_some_and(Overlay::is_moving);
        if is_moving {
            stage.window.request_redraw();
        }
        let wait = if is_moving { frame(stage.gpu()) } else { LOOK_EVERY };
        event_loop.set_control_flow(ControlFlow::WaitUntil(Instant::now() + wait));
    }
}
