//! What runs beside a hand that is measured: pictures as often and as large as in a window.
//!
//! Owns its thread; shows what it draws to nobody.
//! Invariant: it draws no oftener than a window does.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::Instant;

use anyhow::Context;
use pottery_client::render::{Gpu, PotRenderer, Scene, Sharpness};
use pottery_shared::clay::{Phase, Pot};

use crate::window;

/// Size of the pictures: that of the window as it opens.
const SIZE: (u32, u32) = (1280, 800);

/// A thread that draws.
pub(super) struct Pictures {
    is_over: Arc<AtomicBool>,
    adapter: String,
    thread: JoinHandle<anyhow::Result<u64>>,
}

impl Pictures {
    /// Draws `pot` from now on; `look` brings the renderer up to date and says how far the wheel has turned.
    pub(super) fn start(
        pot: Pot,
        look: impl FnMut(&mut PotRenderer) -> Phase + Send + 'static,
    ) -> anyhow::Result<Self> {
        let gpu = Gpu::headless().context("there is nothing to draw with; leave --renderer out")?;
        let is_over = Arc::new(AtomicBool::new(false));
        let adapter = gpu.name().to_owned();
        let flag = Arc::clone(&is_over);
        let thread =
            std::thread::Builder::new().name("pictures".into()).spawn(move || draw(&gpu, &pot, &flag, look))?;
        Ok(Self { is_over, adapter, thread })
    }

    /// Ends it and says how many pictures there were, and what drew them.
    pub(super) fn stop(self) -> anyhow::Result<(u64, String)> {
        self.is_over.store(true, Ordering::Relaxed);
        let pictures = self.thread.join().ok().context("the renderer's thread did not end well")??;
        Ok((pictures, self.adapter))
    }
}

fn draw(
    gpu: &Gpu,
    pot: &Pot,
    is_over: &AtomicBool,
    mut look: impl FnMut(&mut PotRenderer) -> Phase,
) -> anyhow::Result<u64> {
    let format = wgpu::TextureFormat::Rgba8Unorm;
    let mut renderer = PotRenderer::new(gpu, format, window::samples(gpu), pot);
    let target = gpu.device().create_texture(&wgpu::TextureDescriptor {
        label: Some("picture"),
        size: wgpu::Extent3d { width: SIZE.0, height: SIZE.1, depth_or_array_layers: 1 },
        mip_level_count: 1,
        sample_count: 1,
        dimension: wgpu::TextureDimension::D2,
        format,
        usage: wgpu::TextureUsages::RENDER_ATTACHMENT,
        view_formats: &[],
    });
    let view = target.create_view(&wgpu::TextureViewDescriptor::default());
    let (mut pictures, mut sharpness) = (0, Sharpness::default());
    while !is_over.load(Ordering::Relaxed) {
        let begin = Instant::now();
        let phase = look(&mut renderer);
        let mut encoder = gpu.device().create_command_encoder(&wgpu::CommandEncoderDescriptor::default());
        renderer.draw(&mut encoder, &view, SIZE, &Scene { phase, ..Scene::default() });
        gpu.queue().submit([encoder.finish()]);
        let submitted = Instant::now();
        gpu.device().poll(wgpu::PollType::wait_indefinitely())?;
        if gpu.is_software() {
            sharpness.note(submitted.elapsed().as_secs_f32() * 1e3);
            renderer.set_share(sharpness.share());
        }
        pictures += 1;
        std::thread::sleep(window::frame(gpu).saturating_sub(begin.elapsed()));
    }
    Ok(pictures)
}
