//! The shaders' texts, put together.
//!
//! WGSL has no include: a module is its files in order. Every module is checked in the tests.

/// A complete shader module.
#[derive(Clone, Copy, Debug)]
pub struct ShaderText {
    /// What it is called in error messages.
    pub name: &'static str,
    /// Its WGSL.
    pub wgsl: &'static str,
}

impl ShaderText {
    /// Compiles it.
    pub(super) fn compile(self, device: &wgpu::Device) -> wgpu::ShaderModule {
        device.create_shader_module(wgpu::ShaderModuleDescriptor {
            label: Some(self.name),
            source: wgpu::ShaderSource::Wgsl(self.wgsl.into()),
        })
    }
}

macro_rules! module {
    ($name:literal: $($file:literal),+) => {
        ShaderText { name: $name, wgsl: concat!($(include_str!($file)),+) }
    };
}

pub(super) const RELIEF: ShaderText = module!("relief": "transform.wgsl", "relief.wgsl");
pub(super) const PROBE: ShaderText = module!("probe": "transform.wgsl", "probe.wgsl");
pub(super) const CLAY: ShaderText =
    module!("clay": "transform.wgsl", "deflection.wgsl", "frame.wgsl", "light.wgsl", "body.wgsl", "clay.wgsl");
pub(super) const RIM: ShaderText =
    module!("rim": "transform.wgsl", "deflection.wgsl", "frame.wgsl", "light.wgsl", "body.wgsl", "rim.wgsl");
pub(super) const TOOL: ShaderText = module!("tool": "frame.wgsl", "light.wgsl", "tool.wgsl");
pub(super) const SCENERY: ShaderText = module!("scenery": "frame.wgsl", "light.wgsl", "body.wgsl", "scenery.wgsl");
pub(super) const ENLARGE: ShaderText = module!("enlarge": "enlarge.wgsl");

pub(super) const GALLERY: ShaderText =
    module!("gallery": "transform.wgsl", "frame.wgsl", "light.wgsl", "body.wgsl", "gallery.wgsl");

/// Every module that the renderer compiles.
pub const MODULES: [ShaderText; 8] = [RELIEF, PROBE, CLAY, RIM, TOOL, SCENERY, ENLARGE, GALLERY];
