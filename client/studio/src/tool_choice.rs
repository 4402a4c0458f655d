//! The tool in hand when a session begins, as the command line asks for it.
//!
//! Owns its flags; opens nothing but the tool's file.
//! Invariant: a tool that is to be brought can be shared with everybody at a wheel.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Context;
use clap::{Args, ValueEnum};
use pottery_client::stroke::Stroke;
use pottery_client::tool_file::{Thinned, USUAL_UNIT, read_tool};
use pottery_shared::session::{BROUGHT_TRIANGLES_MAX, mesh_of};
use pottery_shared::tool::{ConvexTool, Shape, Tool, rack};

use crate::window::{Holding, TOOL_MM};

#[derive(Args, Clone, Debug)]
pub(crate) struct ToolFlags {
    /// Tool in hand at first; headless, of every potter that has no stroke file [default: sphere, or the tool's file]
    #[arg(long, value_enum)]
    tool: Option<ToolName>,
    /// Radius of the sphere, 2 to 35 mm
    #[arg(long, value_name = "MM", value_parser = tool_mm)]
    tool_radius: Option<f32>,
    /// Bring a tool to the wheel for everybody: a closed convex mesh, .stl or .obj, in mm
    #[arg(long, value_name = "FILE")]
    tool_file: Option<PathBuf>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum ToolName {
    /// A fingertip, or a larger ball
    Sphere,
    /// Half a disc of 100 × 50 mm: its straight edge smooths and straightens
    Rib,
    /// A knife of 150 mm
    Blade,
    /// A bent finger's
    Knuckle,
    /// The end of a trimming loop, 30 mm wide
    Loop,
}

impl ToolName {
    const fn shape(self) -> Option<Shape> {
        match self {
            Self::Sphere => None,
            Self::Rib => Some(Shape::RIB),
            Self::Blade => Some(Shape::BLADE),
            Self::Knuckle => Some(Shape::KNUCKLE),
            Self::Loop => Some(Shape::LOOP),
        }
    }
}

/// What is in hand when a session begins.
#[derive(Clone, Debug)]
pub(crate) struct ToolChoice {
    pub(crate) holding: Holding,
    /// A tool to bring to the wheel.
    pub(crate) brought: Option<Arc<ConvexTool>>,
    /// Whether it is to be taken in hand when it hangs there.
    pub(crate) takes_brought: bool,
    /// Whether the command line says how large a sphere is.
    pub(crate) is_sized: bool,
    /// Whether it says anything of tools.
    is_said: bool,
}

fn tool_mm(text: &str) -> Result<f32, String> {
    let (min, max) = TOOL_MM;
    match text.parse::<f32>() {
        Ok(radius_mm) if (min..=max).contains(&radius_mm) => Ok(radius_mm),
        _ => Err(format!("choose a number of millimetres from {min} to {max}")),
    }
}

/// A tool as thin as can be shared, which is said where it was not.
fn to_share(tool: ConvexTool, path: &Path) -> ConvexTool {
    let triangles = tool.normals().len();
    let thinned = (triangles > BROUGHT_TRIANGLES_MAX).then(|| Thinned::of(&tool, BROUGHT_TRIANGLES_MAX)).flatten();
    let Some(Thinned { tool: thinner, apart }) = thinned else { return tool };
    note!(
        "{} has {triangles} triangles, too many to be shared; it comes with {}, no farther from the file's solid than {:.3} mm",
        path.display(),
        thinner.normals().len(),
        apart.as_mm(),
    );
    thinner
}

impl ToolFlags {
    pub(crate) fn choice(&self) -> anyhow::Result<ToolChoice> {
        let read = |path: &PathBuf| {
            let tool = to_share(read_tool(path, USUAL_UNIT)?, path);
            // said now, and not when it has come to the wheel
            mesh_of(&tool).with_context(|| format!("cannot bring {}", path.display()))?;
            Ok::<_, anyhow::Error>(Arc::new(tool))
        };
        let mut holding = Holding { shape: self.tool.and_then(ToolName::shape), ..Holding::default() };
        holding.sphere_mm = self.tool_radius.unwrap_or(holding.sphere_mm);
        Ok(ToolChoice {
            holding,
            brought: self.tool_file.as_ref().map(read).transpose()?,
            takes_brought: self.tool_file.is_some() && self.tool.is_none(),
            is_sized: self.tool_radius.is_some(),
            is_said: self.tool.is_some() || self.tool_radius.is_some() || self.tool_file.is_some(),
        })
    }
}

impl ToolChoice {
    /// Whether a sphere is in hand.
    pub(crate) const fn is_sphere(&self) -> bool {
        self.holding.shape.is_none() && !self.takes_brought
    }

    /// A stroke of this studio's, made with the tool that was asked for instead of its own: as deep in the same clay.
    pub(crate) fn stroke(&self, stroke: Stroke) -> anyhow::Result<Stroke> {
        if !self.is_said {
            return Ok(stroke);
        }
        let brought = self.brought.iter().map(|tool| (**tool).clone());
        let rack: Vec<_> = rack::standard().iter().cloned().chain(brought).collect();
        let mut holding = self.holding.clone();
        if self.takes_brought {
            holding.shape = Some(Shape(Shape::NAMED.len() as u8));
        }
        let inwards_m = holding.inwards_m(&rack);
        let own_m = |tool: Tool| {
            let own = Holding { shape: tool.shape(), ..Holding::default() };
            tool.sphere().map_or_else(|| own.inwards_m(&rack), |sphere| sphere.radius().0)
        };
        Ok(stroke.with_tool(holding.tool(&rack), |tool| inwards_m - own_m(tool))?)
    }
}
