//! What lies over the picture: the panel's state, what the window tells it, and who reads it aloud.
//!
//! Owns egui and its ties to the window and to AccessKit; knows no pot. What a screen reader is told of goes to the log as well, at trace
//! level (`RUST_LOG=pottery_studio::window::overlay=trace`): what each control is and says, and where it lies.
//! Invariant: screen readers are told of every control that is drawn, and cost nothing where there is none.

use std::sync::Arc;

use anyhow::Context as _;
use egui_winit::accesskit_winit::{self, WindowEvent as AccessEvent};
use winit::event::WindowEvent;
use winit::event_loop::{ActiveEventLoop, EventLoopProxy};
use winit::window::{Window, WindowAttributes};

use super::stage::{PanelShapes, Stage};

/// What comes to a window besides its own events: what a screen reader wants.
pub(super) type Call = accesskit_winit::Event;

/// The panel's side of a window.
pub(super) struct Overlay {
    context: egui::Context,
    input: egui_winit::State,
    /// Pixels a point of the screen, as it was last told, and what the person likes letters to be enlarged by.
    scale: f64,
    enlarged: f32,
    /// The controls as the log was told of them last; none where nobody reads it.
    logged: Option<String>,
}

/// Opens a window with what is drawn on it and what lies over it; `stage` makes the former.
pub(super) fn open(
    event_loop: &ActiveEventLoop,
    proxy: EventLoopProxy<Call>,
    title: &str,
    stage: impl FnOnce(Arc<Window>) -> anyhow::Result<Stage>,
) -> anyhow::Result<(Stage, Overlay)> {
    // shown once a screen reader can ask what is in it
    let attributes = WindowAttributes::default()
        .with_title(title)
        .with_visible(false)
        .with_inner_size(winit::dpi::LogicalSize::new(1280, 800))
        .with_min_inner_size(winit::dpi::LogicalSize::new(480, 360));
    let window = Arc::new(event_loop.create_window(attributes).context("the system opens no window")?);
    let context = egui::Context::default();
    let (root, scale) = (egui::ViewportId::ROOT, window.scale_factor());
    let mut input = egui_winit::State::new(context.clone(), root, &window, Some(scale as f32), window.theme(), None);
    input.init_accesskit(event_loop, &window, proxy);
    window.set_visible(true);
    let stage = stage(window)?;
    input.set_max_texture_side(stage.gpu().device().limits().max_texture_dimension_2d as usize);
    let logged = tracing::enabled!(tracing::Level::TRACE).then(|| {
        context.enable_accesskit();
        String::new()
    });
    Ok((stage, Overlay { context, input, scale, enlarged: 1.0, logged }))
}

/// Takes of an event what is the same for every window: its size, and what the panel makes of it; true when it is the panel's alone.
pub(super) fn take_event(stage: Option<&mut Stage>, overlay: Option<&mut Overlay>, event: &WindowEvent) -> bool {
    let (Some(stage), Some(overlay)) = (stage, overlay) else { return false };
    let is_panels = overlay.take(&stage.window, event);
    if let WindowEvent::Resized(size) = event {
        stage.resize(size.width, size.height);
    }
    is_panels
}

impl Overlay {
    /// Tells the panel of an event; true when it is the panel's alone.
    fn take(&mut self, window: &Window, event: &WindowEvent) -> bool {
        if let WindowEvent::ScaleFactorChanged { scale_factor, .. } = event {
            self.scale = *scale_factor;
            self.zoom(window);
        }
        self.input.on_window_event(window, event).consumed
    }

    /// Enlarges what is written, and all with it, from the next picture on.
    pub(super) fn enlarge(&mut self, window: &Window, by: f32) {
        self.enlarged = by;
        self.zoom(window);
    }

    /// Where another screen took the place of the one before, X11's window has that one's scale still, and egui asks the window.
    fn zoom(&self, window: &Window) {
        self.context.set_zoom_factor(self.enlarged * (self.scale / window.scale_factor()) as f32);
    }

    /// Takes in what a screen reader wants.
    pub(super) fn take_call(&mut self, call: Call) {
        match call.window_event {
            AccessEvent::InitialTreeRequested => self.context.enable_accesskit(),
            AccessEvent::ActionRequested(request) => self.input.on_accesskit_action_request(request),
            AccessEvent::AccessibilityDeactivated if self.logged.is_none() => self.context.disable_accesskit(),
            AccessEvent::AccessibilityDeactivated => {}
        }
    }

    /// Lays the panel out as it is to be drawn next.
    pub(super) fn lay_out(&mut self, window: &Window, panel: impl FnMut(&mut egui::Ui)) -> PanelShapes {
        let output = self.context.run_ui(self.input.take_egui_input(window), panel);
        if let (Some(logged), Some(update)) = (&mut self.logged, &output.platform_output.accesskit_update) {
            let pointer = self.context.pointer_latest_pos().unwrap_or_default() * output.pixels_per_point;
            let is_last = output.viewport_output.values().all(|viewport| !viewport.repaint_delay.is_zero());
            let controls = controls(update, f64::from(output.pixels_per_point));
            let ends = if is_last { "rests" } else { "moves" };
            let controls = format!("{ends} {:.0},{:.0} ¦ {controls}", pointer.x, pointer.y);
            if *logged != controls {
                tracing::trace!("panel {controls}");
                *logged = controls;
            }
        }
        self.input.handle_platform_output(window, output.platform_output);
        PanelShapes {
            primitives: self.context.tessellate(output.shapes, output.pixels_per_point),
            textures: output.textures_delta,
            pixels_per_point: output.pixels_per_point,
        }
    }

    /// All letters as they are drawn, for a painter that has none yet; those of a panel that was laid out before.
    pub(super) fn letters(&self) -> egui::epaint::ImageDelta {
        let image = self.context.fonts(|fonts| fonts.image());
        egui::epaint::ImageDelta::full(image, egui::TextureOptions::LINEAR)
    }

    /// Whether the panel is not done with what it shows.
    pub(super) fn is_moving(&self) -> bool {
        self.context.has_requested_repaint()
    }

    /// Whether something is being typed into it.
    pub(super) fn has_keyboard(&self) -> bool {
        self.context.egui_wants_keyboard_input()
    }

    /// Whether a menu is open, which Esc closes.
    pub(super) fn has_menu(&self) -> bool {
        egui::Popup::is_any_open(&self.context)
    }

    /// Whether the pointer is the panel's.
    pub(super) fn has_pointer(&self) -> bool {
        self.context.egui_wants_pointer_input()
    }

    /// Whether a button or a finger is down.
    pub(super) fn is_held(&self) -> bool {
        self.context.input(|input| input.pointer.any_down())
    }
}

/// Every control that says something: its role, what it says, and left, top, width and height, pixels of the window.
fn controls(update: &egui::accesskit::TreeUpdate, pixels_per_point: f64) -> String {
    let said = update.nodes.iter().filter_map(|(_, node)| {
        let (name, bounds) = (node.label().or(node.value())?, node.bounds()?);
        let [left, top, width, height] =
            [bounds.x0, bounds.y0, bounds.width(), bounds.height()].map(|points| (points * pixels_per_point).round());
        Some(format!("{:?} {name} @{left},{top},{width},{height}", node.role()))
    });
    said.collect::<Vec<_>>().join(" ¦ ")
}
