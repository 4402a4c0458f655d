//! The graphics device, with or without a window.
//!
//! Owns the choice of adapter and what is asked of it; draws nothing.
//! Invariant: no more is asked of a device than WebGL2 offers, except larger textures where it has them.

use std::sync::{Arc, OnceLock};
use std::thread::JoinHandle;

/// An opened graphics device.
#[derive(Clone, Debug)]
pub struct Gpu {
    adapter: wgpu::Adapter,
    device: wgpu::Device,
    queue: wgpu::Queue,
    name: String,
    is_software: bool,
    /// Why it draws no more.
    lost: Arc<OnceLock<String>>,
}

/// Why no graphics device can be used.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// Nothing on this machine can draw, not even in software; install a driver.
    #[error(
        "no graphics adapter was found, not even a software one: install a driver, on Debian `apt install \
         mesa-vulkan-drivers` ({source})"
    )]
    NoAdapter {
        /// What was looked for.
        source: wgpu::RequestAdapterError,
    },
    /// The adapter offers less than WebGL2; use another one (`WGPU_ADAPTER_NAME`) or a newer driver.
    #[error("the graphics adapter {adapter} cannot be opened: {source}")]
    NoDevice {
        /// Name of the adapter.
        adapter: String,
        /// What it answered.
        source: wgpu::RequestDeviceError,
    },
}

/// A graphics device that is opened while something else goes on, for a window that is not there yet.
///
/// Loading a driver takes tens of milliseconds, which is what asking to join a studio takes too.
#[derive(Debug)]
pub struct GpuAhead(JoinHandle<Option<(wgpu::Instance, Gpu)>>);

impl GpuAhead {
    /// Begins to open it.
    ///
    /// # Errors
    /// When the system has no thread to spare.
    pub fn begin() -> std::io::Result<Self> {
        std::thread::Builder::new().name("graphics".into()).spawn(Self::open).map(Self)
    }

    /// The device and a surface of `window` that it can show pictures on; none when a device has to be chosen in sight of the window.
    pub fn on_window(
        self,
        window: impl Into<wgpu::SurfaceTarget<'static>>,
    ) -> Option<(wgpu::Instance, wgpu::Surface<'static>, Gpu)> {
        // a driver that fails is asked again in sight of the window, where a person is told
        let (instance, gpu) = self.0.join().ok().flatten()?;
        let surface = instance.create_surface(window).ok()?;
        gpu.adapter().is_surface_supported(&surface).then_some((instance, surface, gpu))
    }

    fn open() -> Option<(wgpu::Instance, Gpu)> {
        let descriptor = |backends: wgpu::Backends| {
            let usual = Gpu::instance_descriptor();
            wgpu::InstanceDescriptor { backends: usual.backends & backends, ..usual }
        };
        // OpenGL wants to know the display before anything else
        let primary = wgpu::Instance::new(descriptor(wgpu::Backends::PRIMARY));
        let gpu = pollster::block_on(Gpu::open(&primary, None, false)).ok()?;
        let is_card = |adapter: &wgpu::Adapter| adapter.get_info().device_type != wgpu::DeviceType::Cpu;
        // a card that only OpenGL reaches is better than the processor
        let has_other = || {
            // what a driver misses here concerns nobody
            let flags = wgpu::InstanceFlags::empty();
            let other = wgpu::Instance::new(wgpu::InstanceDescriptor { flags, ..descriptor(wgpu::Backends::GL) });
            let adapters = pollster::block_on(other.enumerate_adapters(wgpu::Backends::GL));
            adapters.iter().any(is_card)
        };
        (!gpu.is_software() || !has_other()).then_some((primary, gpu))
    }
}

impl Gpu {
    /// How to make an instance: backends from `WGPU_BACKEND` when it is set, checks in debug builds.
    #[must_use]
    pub fn instance_descriptor() -> wgpu::InstanceDescriptor {
        let mut descriptor = wgpu::InstanceDescriptor::new_without_display_handle();
        // DEBUG as well would make Debian's older SPIRV-Tools report an error that is none
        descriptor.flags =
            if cfg!(debug_assertions) { wgpu::InstanceFlags::VALIDATION } else { wgpu::InstanceFlags::empty() };
        descriptor.with_env()
    }

    /// Opens the best adapter, without a window.
    ///
    /// # Errors
    /// [`GpuError`] when there is none or it cannot be opened.
    pub fn headless() -> Result<Self, GpuError> {
        // OpenGL, which looks for a display and says as an error that there is none, is asked only where it has something better
        GpuAhead::open().map_or_else(
            || {
                let instance = wgpu::Instance::new(Self::instance_descriptor());
                pollster::block_on(Self::open(&instance, None, false))
            },
            |(_, gpu)| Ok(gpu),
        )
    }

    /// Opens every adapter that there is, without a window; those that refuse are left out.
    #[must_use]
    pub fn every() -> Vec<Self> {
        let instance = wgpu::Instance::new(Self::instance_descriptor());
        let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::PRIMARY));
        adapters.into_iter().filter_map(|adapter| pollster::block_on(Self::on(adapter)).ok()).collect()
    }

    /// Opens the best adapter that can show pictures on `surface`.
    ///
    /// # Errors
    /// [`GpuError`] when there is none or it cannot be opened.
    pub fn for_surface(instance: &wgpu::Instance, surface: &wgpu::Surface<'_>) -> Result<Self, GpuError> {
        pollster::block_on(Self::open(instance, Some(surface), false))
    }

    /// Opens one that draws with the processor and can show pictures on `surface`.
    ///
    /// # Errors
    /// [`GpuError`] when there is none or it cannot be opened.
    pub fn software_for_surface(instance: &wgpu::Instance, surface: &wgpu::Surface<'_>) -> Result<Self, GpuError> {
        pollster::block_on(Self::open(instance, Some(surface), true))
    }

    async fn open(
        instance: &wgpu::Instance,
        surface: Option<&wgpu::Surface<'_>>,
        force_fallback_adapter: bool,
    ) -> Result<Self, GpuError> {
        let options = wgpu::RequestAdapterOptions {
            power_preference: wgpu::PowerPreference::HighPerformance,
            compatible_surface: surface,
            force_fallback_adapter,
            ..Default::default()
        };
        let adapter = instance.request_adapter(&options).await.map_err(|source| GpuError::NoAdapter { source })?;
        Self::on(adapter).await
    }

    async fn on(adapter: wgpu::Adapter) -> Result<Self, GpuError> {
        let info = adapter.get_info();
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("pottery"),
            required_limits: wgpu::Limits::downlevel_webgl2_defaults().using_resolution(adapter.limits()),
            ..Default::default()
        };
        let (device, queue) = adapter
            .request_device(&descriptor)
            .await
            .map_err(|source| GpuError::NoDevice { adapter: info.name.clone(), source })?;
        let is_software = info.device_type == wgpu::DeviceType::Cpu;
        let name = format!("{} ({})", info.name, info.backend);
        let lost = Arc::new(OnceLock::new());
        let noted = Arc::clone(&lost);
        device.set_device_lost_callback(move |reason, said| {
            noted.get_or_init(|| if said.is_empty() { format!("{reason:?}") } else { said });
        });
        let noted = Arc::clone(&lost);
        device.on_uncaptured_error(Arc::new(move |error: wgpu::Error| match error {
            // what is asked of a device that is gone cannot be right
            _ if noted.get().is_some() => {}
            wgpu::Error::Validation { .. } if cfg!(debug_assertions) => panic!("{error}"),
            error => drop(noted.set(error.to_string())),
        }));
        Ok(Self { adapter, device, queue, name, is_software, lost })
    }

    /// Why it draws no more, once it was lost: its driver has ended, its card is gone, or its memory is full. Another has to be opened.
    #[must_use]
    pub fn lost(&self) -> Option<&str> {
        self.lost.get().map(String::as_str)
    }

    /// The adapter, for asking what a surface can do on it.
    #[must_use]
    pub const fn adapter(&self) -> &wgpu::Adapter {
        &self.adapter
    }

    /// The device.
    #[must_use]
    pub const fn device(&self) -> &wgpu::Device {
        &self.device
    }

    /// Its queue.
    #[must_use]
    pub const fn queue(&self) -> &wgpu::Queue {
        &self.queue
    }

    /// The adapter's name as its driver gives it, and the interface it is reached through.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether the processor draws: pictures are then made coarser where it hardly shows.
    #[must_use]
    pub const fn is_software(&self) -> bool {
        self.is_software
    }
}
