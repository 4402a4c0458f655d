//! The pot as a file that other programs read: solids, pictures and a drawing.
//!
//! Owns the list of formats, the choice among them by a file's ending, and the sentences when it cannot be written; each
//! format is in a module of its own. Millimetres, as slicers and CAD programs expect, but where a format knows metres
//! alone; the core's metres end here.
//! Invariant: every solid is the same closed one, each edge between two facets, with normals out of the clay.

mod glb;
mod mesh;
mod obj;
mod ply;
mod profile;
mod stl;
mod three_mf;

use std::io::{self, Write};
use std::path::{Path, PathBuf};

use pottery_shared::clay::Pot;

use crate::render::{self, Camera, Gpu, GpuError, RenderError, Scene};
use crate::whole_file::{WriteError, write_whole};

pub use mesh::SolidMesh;

/// Size of a picture, pixels.
const PICTURE: (u32, u32) = (1280, 960);
/// Side of a turntable, pixels.
const TURNTABLE: u16 = 480;

/// What a pot can be written as.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// Binary STL: facets with their normals, mm.
    Stl,
    /// 3MF: a mesh that names its unit, mm; normals follow from the order of corners.
    ThreeMf,
    /// OBJ: text with a normal for each corner, mm.
    Obj,
    /// Binary PLY with a normal for each corner, mm.
    Ply,
    /// glTF in one binary file: metres and y upwards, as the format wants it.
    Glb,
    /// SVG: the section through the axis, mm, in true size.
    Svg,
    /// PNG: a picture.
    Png,
    /// GIF: one turn on the wheel.
    Gif,
}

/// Why a pot was not exported; what stood under the name still stands there.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The ending says no format; choose one of them.
    #[error(
        "{path} does not say in what form to write: let it end in .stl, .3mf, .obj, .ply, .glb, .svg, .png or .gif"
    )]
    Ending {
        /// The file that was asked for.
        path: PathBuf,
    },
    /// There is nothing to draw a picture with.
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// The picture was not drawn.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// The file was not written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

impl Format {
    /// Every format.
    pub const ALL: [Self; 8] =
        [Self::Stl, Self::ThreeMf, Self::Obj, Self::Ply, Self::Glb, Self::Svg, Self::Png, Self::Gif];

    /// The ending of its files, without the point.
    #[must_use]
    pub const fn ending(self) -> &'static str {
        match self {
            Self::Stl => "stl",
            Self::ThreeMf => "3mf",
            Self::Obj => "obj",
            Self::Ply => "ply",
            Self::Glb => "glb",
            Self::Svg => "svg",
            Self::Png => "png",
            Self::Gif => "gif",
        }
    }

    /// The format that a file's ending says, in capitals or not.
    ///
    /// # Errors
    /// [`ExportError::Ending`] when it says none.
    ///
    /// ```
    /// use pottery_client::export::Format;
    /// assert_eq!(Format::of("bowl.STL".as_ref())?, Format::Stl);
    /// assert!(Format::of("bowl.doc".as_ref()).is_err());
    /// # Ok::<(), pottery_client::export::ExportError>(())
    /// ```
    pub fn of(path: &Path) -> Result<Self, ExportError> {
        let ending = path.extension().unwrap_or_default();
        Self::ALL
            .into_iter()
            .find(|format| ending.eq_ignore_ascii_case(format.ending()))
            .ok_or_else(|| ExportError::Ending { path: path.to_path_buf() })
    }
}

/// Writes a pot in the form that the file's ending says, whole or not at all.
///
/// Pictures need a graphics driver; they are drawn on a device of their own, so that this may run beside a window.
///
/// # Errors
/// [`ExportError`]; what stood under the name is then untouched.
pub fn export(pot: &Pot, path: &Path) -> Result<(), ExportError> {
    let bytes = match Format::of(path)? {
        Format::Stl => return Ok(write_whole(path, |out| stl::write(&SolidMesh::of(pot), out))?),
        Format::ThreeMf => return Ok(write_whole(path, |out| three_mf::write(&SolidMesh::of(pot), out))?),
        Format::Obj => return Ok(write_whole(path, |out| obj::write(&SolidMesh::of(pot), out))?),
        Format::Ply => return Ok(write_whole(path, |out| ply::write(&SolidMesh::of(pot), out))?),
        Format::Glb => return Ok(write_whole(path, |out| glb::write(&SolidMesh::of(pot), out))?),
        Format::Svg => profile::drawing(pot).into_bytes(),
        Format::Png => {
            let scene = Scene { camera: Camera::on(pot), ..Scene::default() };
            render::picture(&Gpu::headless()?, pot, &scene, PICTURE.0, PICTURE.1)?
        }
        Format::Gif => render::turntable(&Gpu::headless()?, pot, TURNTABLE)?,
    };
    Ok(write_whole(path, |out| out.write_all(&bytes))?)
}

/// Writes the clay of `pot` as a closed solid in binary STL, mm, foot on z = 0.
///
/// Every element of the outer surface is a corner; 144,000 elements make about 28 MB.
///
/// # Errors
/// Whatever `out` answers; what has been written until then is no valid file.
///
/// ```
/// use pottery_client::export::write_stl;
/// use pottery_shared::clay::{GridShape, Pot, PotSpec};
///
/// let pot = Pot::new(PotSpec { shape: GridShape::new(32, 16)?, ..PotSpec::default() })?;
/// let mut file = Vec::new();
/// write_stl(&pot, &mut file)?;
/// let facets = u32::from_le_bytes([file[80], file[81], file[82], file[83]]);
/// assert_eq!(file.len(), 84 + 50 * facets as usize);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_stl(pot: &Pot, out: &mut impl io::Write) -> io::Result<()> {
    stl::write(&SolidMesh::of(pot), out)
}
