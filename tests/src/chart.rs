//! The accuracy chart: every method and yardstick held against the references, in figures, files and pictures.
//!
//! Owns which measurements there are and in which order they run. A new method is a row of [`entrant::ENTRANTS`] and
//! nothing else.
//! Invariant: what is timed runs alone, and methods that are compared take turns within one run.

mod canvas;
pub mod cases;
pub mod closed_forms;
pub mod convergence;
pub mod csv;
pub mod entrant;
pub mod extent;
pub mod force;
pub mod guidance;
pub mod helix;
mod index;
pub mod lathe;
pub mod machine;
pub mod network;
mod panel;
mod pictures;
pub mod progress;
mod raster;
pub mod speed;
pub mod stability;
pub mod table1;
pub mod transform;
pub mod volume;

use std::path::{Path, PathBuf};

use crate::dent::DentError;
use crate::reference::BadProfile;
use cases::CaseFigures;
use entrant::ENTRANTS;
use extent::Extent;
use machine::Machine;
use progress::Progress;

/// Why a chart cannot be made.
#[derive(Debug, thiserror::Error)]
pub enum ChartError {
    /// A press makes no sense.
    #[error(transparent)]
    Dent(#[from] DentError),
    /// A reference file is damaged; take it anew from the repository.
    #[error("a reference file cannot be read: {0}")]
    Reference(#[from] BadProfile),
    /// A picture cannot be packed.
    #[error("the picture {name} cannot be packed: {source}")]
    Picture {
        /// Its file.
        name: &'static str,
        /// Why.
        source: png::EncodingError,
    },
    /// A file or the folder cannot be written; choose another folder.
    #[error("{} cannot be written: {source}; choose another folder", path.display())]
    Write {
        /// Which.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
}

/// Everything that is measured.
#[derive(Clone, Debug)]
pub struct Figures {
    /// How much was measured.
    pub extent: Extent,
    /// On what.
    pub machine: Machine,
    /// Time a step and error, by grid.
    pub methods: Vec<speed::MethodFigures>,
    /// Each reference case.
    pub cases: Vec<CaseFigures>,
    /// Force over travel.
    pub forces: Vec<force::ForceFigures>,
    /// Laws that can be written down.
    pub closed_forms: Vec<closed_forms::ClosedFormFigures>,
    /// Other steps, other grids.
    pub convergence: Vec<convergence::ConvergenceFigures>,
    /// What becomes of the clay that is pushed away.
    pub volume: Vec<volume::VolumeFigures>,
    /// A tool that goes along a turning wheel.
    pub helix: Vec<helix::HelixFigures>,
    /// A fast wheel as a profile.
    pub lathe: Vec<lathe::LatheFigures>,
    /// The paper's table, from this machine.
    pub table1: Vec<table1::Table1Figures>,
}

/// Measures everything.
///
/// # Errors
/// [`ChartError`] when a press makes no sense, a reference is damaged or a yardstick gives up.
pub fn measure(extent: Extent, machine: Machine, progress: &mut Progress<'_>) -> Result<Figures, ChartError> {
    progress.expect(extent.pieces(ENTRANTS));
    let timed = speed::time(&extent, progress)?;
    let table1 = table1::measure(&extent, progress)?;
    let errors = speed::errors(&extent, progress)?;
    let mut convergence = convergence::over_steps(&extent, progress)?;
    convergence.extend(errors.iter().map(convergence::ConvergenceFigures::of_grid));
    let methods = speed::joined(&timed, &errors);
    let cases = cases::measure(&extent, progress)?;
    let forces = force::measure(&extent, progress)?;
    let closed_forms = closed_forms::measure(&extent, progress)?;
    let volume = volume::measure(&extent, progress)?;
    let helix = helix::measure(&extent, progress)?;
    let lathe = lathe::measure(&extent, progress)?;
    Ok(Figures { extent, machine, methods, cases, forces, closed_forms, convergence, volume, helix, lathe, table1 })
}

/// Every file of the chart: its name and its bytes.
///
/// # Errors
/// [`ChartError`] when a reference is damaged or a picture cannot be packed.
pub fn files(figures: &Figures) -> Result<Vec<(&'static str, Vec<u8>)>, ChartError> {
    let mut files: Vec<(&'static str, Vec<u8>)> = vec![
        ("methods.csv", csv::text(&figures.methods).into()),
        ("cases.csv", csv::text(&figures.cases).into()),
        ("force.csv", csv::text(&figures.forces).into()),
        ("closed-forms.csv", csv::text(&figures.closed_forms).into()),
        ("convergence.csv", csv::text(&figures.convergence).into()),
        ("volume.csv", csv::text(&figures.volume).into()),
        ("helix.csv", csv::text(&figures.helix).into()),
        ("lathe.csv", csv::text(&figures.lathe).into()),
        ("table1.csv", csv::text(&figures.table1).into()),
        ("table1.md", table1::page(&figures.table1, &figures.machine).into()),
        ("machine.json", figures.machine.json().into()),
        ("index.md", index::page(figures).into()),
    ];
    for (name, draw) in pictures::ALL {
        let bytes = draw(figures)?.into_png().map_err(|source| ChartError::Picture { name, source })?;
        files.push((name, bytes));
    }
    Ok(files)
}

/// Writes every file of the chart into a folder, which is made when it is not there; returns their names.
///
/// # Errors
/// [`ChartError`] as for [`files`], or when one cannot be written.
pub fn write(figures: &Figures, folder: &Path) -> Result<Vec<&'static str>, ChartError> {
    std::fs::create_dir_all(folder).map_err(|source| ChartError::Write { path: folder.to_owned(), source })?;
    let files = files(figures)?;
    for (name, bytes) in &files {
        let path = folder.join(name);
        std::fs::write(&path, bytes).map_err(|source| ChartError::Write { path, source })?;
    }
    Ok(files.into_iter().map(|(name, _)| name).collect())
}
