//! The picture of the studio: the pot, its wheel and the tools at it.
//!
//! Owns the graphics device, the textures that hold the radii and every shader. Knows no window, no clock and no
//! network: what to show arrives as a [`Pot`](pottery_shared::clay::Pot) and a [`Scene`].
//! Invariant: what the shaders turn into points of the pot is the radius grid, less what a hollow wall gives way while tools are at it,
//! and nothing else; no vertex of clay lies in a buffer.
//!
//! The world is the room: metres, z up along the wheel's axis, the foot of the pot at z = 0.
//! Everything works within WebGL2's limits: no storage buffer, no compute, no feature asked for.

mod bends;
mod camera;
mod deflection;
mod deflection_map;
mod enlarge;
mod finish;
mod frame;
mod gallery;
mod gpu;
mod grid;
mod mesh;
mod picture;
mod pipelines;
mod probe;
mod readback;
mod renderer;
mod scene;
mod shader;
mod sharpness;
mod solid;
mod targets;
mod turntable;
mod water;
mod water_map;

pub use camera::Camera;
pub use deflection::Deflection;
pub use finish::Finish;
pub use gallery::{GalleryRenderer, GalleryScene, WheelView};
pub use gpu::{Gpu, GpuAhead, GpuError};
pub use picture::{picture, picture_rgba};
pub use probe::{ProbedVertex, probe_skin};
pub use readback::RenderError;
pub use renderer::PotRenderer;
pub use scene::{Scene, ToolView};
pub use shader::{MODULES, ShaderText};
pub use sharpness::Sharpness;
pub use turntable::turntable;
pub use water::{Water, WetHand};
