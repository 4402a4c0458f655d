//! What is drawn on: the window's surface, the pot's renderer and the panel's painter.
//!
//! Owns the graphics device; knows no people and no network.
//! Invariant: the surface is configured to the window's size whenever that is not zero, and a lost device costs a picture, not the window.

use std::hash::{Hash, Hasher};
use std::sync::Arc;
use std::time::{Duration, Instant};

use anyhow::{Context, anyhow, bail};
use pottery_client::render::{Camera, GalleryRenderer, GalleryScene, Gpu, GpuAhead, PotRenderer, Scene, Sharpness};
use pottery_shared::clay::Pot;
use pottery_shared::snapshot::Touched;
use wgpu::CurrentSurfaceTexture;
use winit::event_loop::OwnedDisplayHandle;
use winit::window::Window;

use super::overlay::Overlay;

/// Time after a loss in which another one is taken for the same fault.
const AGAIN: Duration = Duration::from_secs(20);

impl PanelShapes {
    /// A figure that is another when what is to be seen is another; textures that change are seen.
    pub(super) fn digest(&self) -> u64 {
        let mut hasher = std::hash::DefaultHasher::new();
        (self.primitives.len(), self.textures.set.len()).hash(&mut hasher);
        for primitive in &self.primitives {
            if let egui::epaint::Primitive::Mesh(mesh) = &primitive.primitive {
                for vertex in &mesh.vertices {
                    (vertex.pos.x.to_bits(), vertex.pos.y.to_bits()).hash(&mut hasher);
                    (vertex.uv.x.to_bits(), vertex.uv.y.to_bits(), vertex.color).hash(&mut hasher);
                }
            }
        }
        hasher.finish()
    }
}

/// What draws the clay.
pub(super) enum Painter {
    Pot(Box<PotRenderer>),
    Gallery(Box<GalleryRenderer>),
}

/// What is drawn of it; one of the other kind than the painter draws nothing.
pub(super) enum Picture<'a> {
    Pot(&'a Scene<'a>),
    Gallery(&'a GalleryScene<'a>),
}

/// Whether the next picture will be another.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Pace {
    /// It will: so this one has to be quick.
    Moving,
    /// It may, and none takes its place where it is not: quick, with the outline of one that stays.
    Lasting,
    /// It stays for a while: so it may take its time, and has every pixel of the window.
    Still,
}

impl Painter {
    fn draw(
        &mut self,
        encoder: &mut wgpu::CommandEncoder,
        target: &wgpu::TextureView,
        size: (u32, u32),
        picture: &Picture<'_>,
    ) {
        match (self, picture) {
            (Self::Pot(pot), Picture::Pot(scene)) => pot.draw(encoder, target, size, scene),
            (Self::Gallery(gallery), Picture::Gallery(scene)) => gallery.draw(encoder, target, size, scene),
            _ => {}
        }
    }
}

/// A window with what was drawn in it last, as one part of the program hands it to another.
pub(super) struct Seen {
    pub(super) stage: Stage,
    pub(super) overlay: Overlay,
    pub(super) camera: Camera,
}

/// Surface, device and painters of one window.
pub(super) struct Stage {
    pub(super) window: Arc<Window>,
    display: OwnedDisplayHandle,
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    configuration: wgpu::SurfaceConfiguration,
    gpu: Gpu,
    painter: Painter,
    sharpness: Sharpness,
    /// Whether the last picture had fewer pixels than the window, or a coarser outline than one that stays.
    is_coarse: bool,
    panel: egui_wgpu::Renderer,
    /// When devices were lost, of late.
    losses: Vec<Instant>,
    /// Pictures so far, and those after which the device is lost on purpose.
    pictures: u64,
    loses_after: Vec<u64>,
}

/// A surface of a window, and a device that can draw on it.
struct Opened {
    instance: wgpu::Instance,
    surface: wgpu::Surface<'static>,
    gpu: Gpu,
    configuration: wgpu::SurfaceConfiguration,
}

impl Opened {
    /// With a device that was opened ahead, where it can draw on that window.
    fn ahead(window: &Arc<Window>, display: &OwnedDisplayHandle, ahead: Option<GpuAhead>) -> anyhow::Result<Self> {
        match ahead.and_then(|ahead| ahead.on_window(Arc::clone(window))) {
            Some((instance, surface, gpu)) => Self::configured(window, instance, surface, gpu),
            None => Self::new(window, display, false),
        }
    }

    fn new(window: &Arc<Window>, display: &OwnedDisplayHandle, is_software: bool) -> anyhow::Result<Self> {
        let instance = wgpu::Instance::new(Gpu::instance_descriptor().with_display_handle(Box::new(display.clone())));
        let surface = instance.create_surface(Arc::clone(window)).map_err(|error| {
            anyhow!(
                "nothing on this machine can draw in a window: install a graphics driver, on Debian `apt install mesa-vulkan-drivers` ({error})"
            )
        })?;
        let open = if is_software { Gpu::software_for_surface } else { Gpu::for_surface };
        let gpu = open(&instance, &surface)?;
        Self::configured(window, instance, surface, gpu)
    }

    fn configured(
        window: &Window,
        instance: wgpu::Instance,
        surface: wgpu::Surface<'static>,
        gpu: Gpu,
    ) -> anyhow::Result<Self> {
        let size = window.inner_size();
        let mut configuration = surface
            .get_default_config(gpu.adapter(), size.width.max(1), size.height.max(1))
            .context("the graphics adapter cannot show pictures in this window")?;
        let formats = surface.get_capabilities(gpu.adapter()).formats;
        // the panel blends in the screen's own space, as its authors recommend
        if let Some(plain) = formats.iter().find(|format| !format.is_srgb()) {
            configuration.format = *plain;
        }
        configuration.present_mode = wgpu::PresentMode::AutoVsync;
        configuration.desired_maximum_frame_latency = 1;
        Ok(Self { instance, surface, gpu, configuration })
    }

    fn painter(&self, pot: &Pot) -> Painter {
        let samples = super::samples(&self.gpu);
        Painter::Pot(Box::new(PotRenderer::new(&self.gpu, self.configuration.format, samples, pot)))
    }

    fn panel(&self) -> egui_wgpu::Renderer {
        let options = egui_wgpu::RendererOptions::default();
        egui_wgpu::Renderer::new(self.gpu.device(), self.configuration.format, options)
    }
}

/// The panel's shapes for one picture.
pub(super) struct PanelShapes {
    pub(super) primitives: Vec<egui::ClippedPrimitive>,
    pub(super) textures: egui::TexturesDelta,
    pub(super) pixels_per_point: f32,
}

/// What there is to draw into.
enum Next {
    Now(wgpu::SurfaceTexture),
    /// Nothing, and soon again.
    Later,
    /// Nothing while the window is hidden.
    Hidden,
}

impl Stage {
    /// Draws `pot` in `window`, with the device that was opened `ahead` where there is one.
    pub(super) fn new(
        window: Arc<Window>,
        display: OwnedDisplayHandle,
        ahead: Option<GpuAhead>,
        pot: &Pot,
    ) -> anyhow::Result<Self> {
        let opened = Opened::ahead(&window, &display, ahead)?;
        opened.surface.configure(opened.gpu.device(), &opened.configuration);
        let (painter, panel) = (opened.painter(pot), opened.panel());
        let Opened { instance, surface, gpu, configuration } = opened;
        let sharpness = Sharpness::default();
        // for the tests, which cannot unplug a card
        let asked = std::env::var("POTTERY_LOSE_DEVICE_AFTER").ok().filter(|_| cfg!(debug_assertions));
        let loses_after = asked.iter().flat_map(|asked| asked.split(',')).filter_map(|number| number.parse().ok());
        Ok(Self {
            window,
            display,
            instance,
            surface,
            configuration,
            gpu,
            painter,
            sharpness,
            is_coarse: false,
            panel,
            losses: Vec::new(),
            pictures: 0,
            loses_after: loses_after.collect(),
        })
    }

    /// Whether the device draws no more, so that [`Stage::renew`] has to follow.
    pub(super) fn is_lost(&self) -> bool {
        if let Err(error) = self.gpu.device().poll(wgpu::PollType::Poll) {
            tracing::debug!(%error, "the device does not answer");
        }
        self.gpu.lost().is_some()
    }

    /// Opens another device in the place of a lost one, for `pot` and a panel with those `letters`: the best that there is, or the processor where
    /// that was lost a moment ago.
    ///
    /// Fails with a sentence where there is none, or where even that is lost again.
    pub(super) fn renew(&mut self, pot: &Pot, letters: egui::epaint::ImageDelta) -> anyhow::Result<()> {
        let reason = self.gpu.lost().unwrap_or_default().to_owned();
        self.losses.retain(|at| at.elapsed() < AGAIN);
        self.losses.push(Instant::now());
        let opened = match self.losses.len() {
            1 => Opened::new(&self.window, &self.display, false),
            2 => Opened::new(&self.window, &self.display, true),
            _ => bail!("the graphics device was lost again and again, so that nothing can be drawn: {reason}"),
        };
        let opened = opened.with_context(|| format!("the graphics device was lost ({reason})"))?;
        tracing::warn!("the graphics device was lost ({reason}), and {} draws on", opened.gpu.name());
        self.painter = opened.painter(pot);
        self.panel = opened.panel();
        self.sharpness = Sharpness::default();
        // what the window had of the old device goes before the new one is configured
        let Opened { instance, surface, gpu, configuration } = opened;
        (self.surface, self.instance, self.gpu, self.configuration) = (surface, instance, gpu, configuration);
        self.surface.configure(self.gpu.device(), &self.configuration);
        self.panel.update_texture(self.gpu.device(), self.gpu.queue(), egui::TextureId::default(), &letters);
        Ok(())
    }

    pub(super) fn gpu(&self) -> &Gpu {
        &self.gpu
    }

    /// Width over height.
    pub(super) fn aspect(&self) -> f32 {
        self.configuration.width as f32 / self.configuration.height.max(1) as f32
    }

    pub(super) fn resize(&mut self, width: u32, height: u32) {
        if width > 0 && height > 0 {
            self.configuration.width = width;
            self.configuration.height = height;
            self.surface.configure(self.gpu.device(), &self.configuration);
        }
    }

    /// Whether the last picture had fewer pixels than the window or a coarser outline, so that one that stays should take its place.
    pub(super) const fn is_coarse(&self) -> bool {
        self.is_coarse
    }

    /// Sends the clay that changed to the device; all of it where the pot that is drawn has another grid.
    pub(super) fn upload(&mut self, pot: &Pot, changed: &Touched) {
        match &mut self.painter {
            Painter::Pot(painter) if painter.fits(pot) => painter.upload_changed(pot, changed),
            Painter::Pot(_) => self.show_pot(pot),
            Painter::Gallery(_) => {}
        }
    }

    /// Draws that pot from now on.
    pub(super) fn show_pot(&mut self, pot: &Pot) {
        let renderer = PotRenderer::new(&self.gpu, self.configuration.format, super::samples(&self.gpu), pot);
        self.painter = Painter::Pot(Box::new(renderer));
        self.sharpness = Sharpness::default();
    }

    /// Draws so many wheels with pots such as that from now on.
    pub(super) fn show_gallery(&mut self, pot: &Pot, wheels: usize) {
        let (format, samples) = (self.configuration.format, super::samples(&self.gpu));
        self.painter = Painter::Gallery(Box::new(GalleryRenderer::new(&self.gpu, format, samples, pot, wheels)));
    }

    /// What draws many wheels, while it does.
    pub(super) fn gallery(&mut self) -> Option<&mut GalleryRenderer> {
        match &mut self.painter {
            Painter::Gallery(gallery) => Some(gallery),
            Painter::Pot(_) => None,
        }
    }

    /// Takes care of shapes that need not be drawn, since what is to be seen of them is there already.
    #[expect(clippy::iter_over_hash_type, reason = "the painter's textures are independent of each other")]
    pub(super) fn leave(&mut self, mut shapes: PanelShapes) {
        for (id, deltas) in &shapes.textures.set {
            for delta in deltas {
                self.panel.update_texture(self.gpu.device(), self.gpu.queue(), *id, delta);
            }
        }
        for id in &shapes.textures.free {
            self.panel.free_texture(id);
        }
        shapes.textures.clear();
    }

    /// Draws one picture and says whether it is seen; one that could not be drawn now is the caller's to draw again.
    #[expect(clippy::iter_over_hash_type, reason = "the painter's textures are independent of each other")]
    pub(super) fn draw(&mut self, picture: &Picture<'_>, mut shapes: PanelShapes, pace: Pace) -> anyhow::Result<bool> {
        for (id, deltas) in &shapes.textures.set {
            for delta in deltas {
                self.panel.update_texture(self.gpu.device(), self.gpu.queue(), *id, delta);
            }
        }
        let free: Vec<_> = shapes.textures.free.iter().copied().collect();
        // all is taken care of, whether a picture comes of it or not
        shapes.textures.clear();
        if self.is_lost() {
            return Ok(false);
        }
        let next = self.next_texture()?;
        // nobody sees what is behind another window, and the system says when it comes forward
        let is_seen = !matches!(next, Next::Later);
        if let Next::Now(texture) = next {
            let view = texture.texture.create_view(&wgpu::TextureViewDescriptor::default());
            let size = (texture.texture.width(), texture.texture.height());
            let share = if pace == Pace::Still { 1.0 } else { self.sharpness.share() };
            let is_hasty = pace == Pace::Moving && self.gpu.is_software();
            if let Painter::Pot(painter) = &mut self.painter {
                painter.set_share(share);
                painter.set_outline_px(if is_hasty {
                    PotRenderer::OUTLINE_PX_MOVING_SOFTWARE
                } else {
                    PotRenderer::OUTLINE_PX
                });
                self.is_coarse = is_hasty || share < 1.0;
            }
            let mut encoder = self.gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
            self.painter.draw(&mut encoder, &view, size, picture);
            let descriptor = egui_wgpu::ScreenDescriptor {
                size_in_pixels: [size.0, size.1],
                pixels_per_point: shapes.pixels_per_point,
            };
            let (device, queue) = (self.gpu.device(), self.gpu.queue());
            let mut buffers = self.panel.update_buffers(device, queue, &mut encoder, &shapes.primitives, &descriptor);
            {
                let pass = encoder.begin_render_pass(&wgpu::RenderPassDescriptor {
                    label: Some("panel"),
                    color_attachments: &[Some(wgpu::RenderPassColorAttachment {
                        view: &view,
                        depth_slice: None,
                        resolve_target: None,
                        ops: wgpu::Operations { load: wgpu::LoadOp::Load, store: wgpu::StoreOp::Store },
                    })],
                    ..Default::default()
                });
                self.panel.render(&mut pass.forget_lifetime(), &shapes.primitives, &descriptor);
            }
            buffers.push(encoder.finish());
            let submitted = Instant::now();
            queue.submit(buffers);
            if self.gpu.is_software() {
                // it is this processor that would go on drawing in the background; a device that is lost says so by itself
                if let Err(error) = device.poll(wgpu::PollType::wait_indefinitely()) {
                    tracing::debug!(%error, "no waiting for a picture");
                }
                if pace != Pace::Still {
                    self.sharpness.note(submitted.elapsed().as_secs_f32() * 1e3);
                }
            }
            self.window.pre_present_notify();
            queue.present(texture);
            self.pictures += 1;
            if self.loses_after.contains(&self.pictures) {
                self.gpu.device().destroy();
            }
        }
        for id in &free {
            self.panel.free_texture(id);
        }
        Ok(is_seen)
    }

    fn next_texture(&mut self) -> anyhow::Result<Next> {
        match self.surface.get_current_texture() {
            CurrentSurfaceTexture::Success(texture) | CurrentSurfaceTexture::Suboptimal(texture) => {
                Ok(Next::Now(texture))
            }
            CurrentSurfaceTexture::Occluded => Ok(Next::Hidden),
            CurrentSurfaceTexture::Timeout => Ok(Next::Later),
            CurrentSurfaceTexture::Outdated | CurrentSurfaceTexture::Validation => {
                self.surface.configure(self.gpu.device(), &self.configuration);
                Ok(Next::Later)
            }
            CurrentSurfaceTexture::Lost => {
                self.surface = self
                    .instance
                    .create_surface(Arc::clone(&self.window))
                    .context("the window can no longer be drawn on")?;
                self.surface.configure(self.gpu.device(), &self.configuration);
                Ok(Next::Later)
            }
        }
    }
}
