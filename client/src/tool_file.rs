//! Tools from files: a closed triangle mesh in STL or OBJ.
//!
//! Owns the formats and their limits; whether a mesh makes a tool is decided by [`ConvexTool::new`].
//! Invariant: no more is read than [`FILE_BYTES_MAX`], and no more triangles kept than a tool may have and one.

mod obj;
mod stl;
mod thin;

use std::fs::File;
use std::io::{self, Read};
use std::path::{Path, PathBuf};

use glam::Vec3;
use pottery_shared::tool::{ConvexError, ConvexTool};
use pottery_shared::units::Metres;

pub use thin::Thinned;

/// Largest file, bytes: eight times what text needs for the most triangles a tool may have.
pub const FILE_BYTES_MAX: u64 = 48 << 20;
/// The unit of files that say none, as both formats do: what slicers and CAD programs take it for.
pub const USUAL_UNIT: Metres = Metres::from_mm(1.0);

/// A file that makes no tool, and why.
#[derive(Debug, thiserror::Error)]
#[error("cannot make a tool of {}: {fault}", path.display())]
pub struct ToolFileError {
    /// The file.
    pub path: PathBuf,
    /// What is wrong with it.
    #[source]
    pub fault: ToolFileFault,
}

/// Why a file makes no tool.
#[derive(Debug, thiserror::Error)]
pub enum ToolFileFault {
    /// The file cannot be read; look at its name and who may read it.
    #[error("it cannot be read ({0}); check its name and that you may read it")]
    Unreadable(#[from] io::Error),
    /// The file is larger than any tool; simplify the mesh.
    #[error("it is larger than {max} bytes; simplify the mesh")]
    TooLarge {
        /// Most bytes allowed.
        max: u64,
    },
    /// The name ends in neither .stl nor .obj; export one of them.
    #[error("its name ends in neither .stl nor .obj; export the mesh as one of them")]
    Format,
    /// The text breaks the rules of its format; export the mesh again.
    #[error("line {line} {problem}; export the mesh again")]
    Line {
        /// Number of the line, from 1.
        line: usize,
        /// What is wrong there.
        problem: LineProblem,
    },
    /// The file holds fewer triangles than it announces; copy or export it again.
    #[error("it announces {triangles} triangles, which take {needed} bytes, and has {bytes}; copy or export it again")]
    CutShort {
        /// Triangles announced.
        triangles: u32,
        /// Bytes that they take.
        needed: u64,
        /// Bytes that are there.
        bytes: u64,
    },
    /// There is nothing in the file; export the mesh again.
    #[error("there is nothing in it; export the mesh again")]
    Empty,
    /// Not what an STL file looks like, or not all of it; export the mesh again.
    #[error("it is no STL file, or its end is missing; export the mesh again")]
    Stl,
    /// More than one body; export one.
    #[error("it holds more than one solid; export a single one")]
    SeveralSolids,
    /// The mesh makes no tool.
    #[error(transparent)]
    Mesh(#[from] ConvexError),
}

/// What is wrong with a line of an OBJ file, or of an STL file in text.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LineProblem {
    /// `v` needs three numbers.
    #[error("has a corner without three numbers")]
    Corner,
    /// `vertex` and `facet normal` need three finite numbers.
    #[error("has a corner or a normal without three finite numbers")]
    Numbers,
    /// `f` needs three corners or more.
    #[error("has a face of fewer than three corners")]
    Face,
    /// A corner is named by a whole number, counted from 1, or backwards from −1.
    #[error("names corner {number}, of {corners} so far")]
    Number {
        /// The number given; 0 for what is none.
        number: i64,
        /// How many corners there are.
        corners: usize,
    },
    /// More corners than the triangles of a tool have.
    #[error("has one corner more than the {max} that a tool may have")]
    TooManyCorners {
        /// Most corners.
        max: usize,
    },
}

/// Reads a tool from a `.stl` (binary or text) or `.obj` file, in which a length of 1 means `unit`.
///
/// ```no_run
/// use std::path::Path;
///
/// use pottery_client::tool_file::{USUAL_UNIT, read_tool};
///
/// let rib = read_tool(Path::new("rib.stl"), USUAL_UNIT)?;
/// println!("reaches {} mm from its centre", rib.radius().as_mm());
/// # Ok::<(), pottery_client::tool_file::ToolFileError>(())
/// ```
///
/// # Errors
/// [`ToolFileError`] naming the file, what is wrong with it and what to do.
pub fn read_tool(path: &Path, unit: Metres) -> Result<ConvexTool, ToolFileError> {
    tool_of(path, unit).map_err(|fault| ToolFileError { path: path.to_owned(), fault })
}

fn tool_of(path: &Path, unit: Metres) -> Result<ConvexTool, ToolFileFault> {
    let ending = path.extension().map(|ending| ending.to_ascii_lowercase()).unwrap_or_default();
    let triangles = if ending == "stl" {
        stl::triangles(contents(path)?)
    } else if ending == "obj" {
        obj::triangles(&contents(path)?)
    } else {
        Err(ToolFileFault::Format)
    }?;
    let in_metres = |corner: [f32; 3]| Vec3::from_array(corner) * unit.0;
    let triangles: Vec<_> = triangles.into_iter().map(|triangle| triangle.map(in_metres)).collect();
    Ok(ConvexTool::new(&triangles)?)
}

fn contents(path: &Path) -> Result<Vec<u8>, ToolFileFault> {
    let mut bytes = Vec::new();
    // a length that is told before may be wrong: a pipe has none
    File::open(path)?.take(FILE_BYTES_MAX + 1).read_to_end(&mut bytes)?;
    if bytes.len() as u64 > FILE_BYTES_MAX {
        return Err(ToolFileFault::TooLarge { max: FILE_BYTES_MAX });
    }
    if bytes.is_empty() { Err(ToolFileFault::Empty) } else { Ok(bytes) }
}

/// Triangles as they stand in a file, in its unit.
type Triangles = Vec<[[f32; 3]; 3]>;

/// Whether one triangle more would be kept: one too many is, to be told about.
fn has_room(triangles: &Triangles) -> bool {
    triangles.len() <= ConvexTool::TRIANGLES_MAX
}
