//! The finite-element cases, and how far each method is from them.
//!
//! Owns the list of reference files and the press that each stands for.
//! Invariant: a case is always the reference's own pot, sphere and clay; only the method and the grid are free.

use pottery_shared::clay::{GridShape, MethodKind, PotSpec, Strength};
use pottery_shared::units::Metres;

use super::ChartError;
use super::csv::{Cell, Row};
use super::entrant::ENTRANTS;
use super::extent::Extent;
use super::progress::Progress;
use crate::dent::{Dent, Dented};
use crate::reference::Profile;

/// What holds the wall from inside.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Support {
    /// A lubricated rigid mandrel.
    Backed,
    /// Nothing.
    Hollow,
    /// A rigid sphere of 15 mm opposite the tool.
    Finger,
}

impl Support {
    /// Its name in files.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Backed => "backed",
            Self::Hollow => "hollow",
            Self::Finger => "finger",
        }
    }
}

/// One dent of the reference.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// What holds the wall.
    pub support: Support,
    /// Travel of the sphere from first touch, mm.
    pub depth_mm: u32,
    /// Whether the sphere was taken away before the surface was read.
    pub release: bool,
    text: &'static str,
}

macro_rules! case {
    ($support:ident, $depth_mm:literal, $release:literal, $file:literal) => {
        Case {
            support: Support::$support,
            depth_mm: $depth_mm,
            release: $release,
            text: include_str!(concat!("../../data/reference/", $file, "_profile.csv")),
        }
    };
}

/// Every dent of the reference.
pub const CASES: &[Case] = &[
    case!(Backed, 1, false, "B_d1L"),
    case!(Backed, 1, true, "B_d1U"),
    case!(Backed, 2, false, "B_d2L"),
    case!(Backed, 2, true, "B_d2U"),
    case!(Hollow, 1, false, "A_d1L"),
    case!(Hollow, 1, true, "A_d1U"),
    case!(Hollow, 2, false, "A_d2L"),
    case!(Hollow, 2, true, "A_d2U"),
    case!(Finger, 1, false, "F_d1L"),
    case!(Finger, 1, true, "F_d1U"),
];

/// The reference's pot, sphere and clay, pressed to a depth on a grid.
///
/// Outer radius 60 mm, wall 8 mm, height 200 mm; sphere of 12 mm; E = 2 MPa, yield stress 40 kPa.
#[must_use]
pub fn reference_dent(grid: GridShape, depth_mm: f32, release: bool) -> Dent {
    Dent {
        method: MethodKind::default(),
        pot: PotSpec { shape: grid, ..PotSpec::default() },
        strength: Strength::default(),
        tool: Metres::from_mm(12.0),
        depth: Metres::from_mm(depth_mm),
        release,
        round: None,
    }
}

impl Case {
    /// The reference's surface.
    ///
    /// # Errors
    /// [`ChartError::Reference`] when the file is damaged.
    pub fn reference(&self) -> Result<Profile, ChartError> {
        Ok(Profile::parse(self.text)?)
    }

    /// The press that it stands for.
    #[must_use]
    pub fn dent(&self, grid: GridShape) -> Dent {
        reference_dent(grid, self.depth_mm as f32, self.release)
    }

    /// Whether the tool is in or out, in one word.
    #[must_use]
    pub const fn state(&self) -> &'static str {
        if self.release { "unloaded" } else { "loaded" }
    }
}

/// How a method meets a case.
#[derive(Clone, Debug)]
pub struct CaseFigures {
    /// Row of the table of methods.
    pub row: usize,
    /// The case.
    pub case: Case,
    /// The surface.
    pub dented: Dented,
    /// Root mean square of the difference over 30 mm × 30 mm about the dent, over the travel.
    pub error: f64,
    /// Radial displacement under the tool, mm: the method's and the reference's.
    pub tip_mm: [f64; 2],
    /// Highest radial displacement within 30 mm above the dent, mm: the method's and the reference's.
    pub rim_mm: [f64; 2],
}

impl Row for CaseFigures {
    const COLUMNS: &'static [&'static str] = &[
        "method",
        "support",
        "support_known",
        "depth_mm",
        "state",
        "columns",
        "rows",
        "rms_error_mm",
        "rms_error_percent_of_depth",
        "tip_mm",
        "reference_tip_mm",
        "rim_mm",
        "reference_rim_mm",
    ];

    fn cells(&self) -> Vec<Cell> {
        let entrant = &ENTRANTS[self.row];
        vec![
            entrant.name.into(),
            self.case.support.name().into(),
            entrant.supports.contains(&self.case.support).into(),
            self.case.depth_mm.into(),
            self.case.state().into(),
            self.dented.shape.columns().into(),
            self.dented.shape.rows().into(),
            (self.error * f64::from(self.case.depth_mm)).into(),
            (self.error * 100.0).into(),
            self.tip_mm[0].into(),
            self.tip_mm[1].into(),
            self.rim_mm[0].into(),
            self.rim_mm[1].into(),
        ]
    }
}

/// Presses every case with every row of the table that is asked for it.
///
/// # Errors
/// [`ChartError`] as for a single dent.
pub fn measure(extent: &Extent, progress: &mut Progress<'_>) -> Result<Vec<CaseFigures>, ChartError> {
    let mut figures = Vec::new();
    for (row, entrant) in ENTRANTS.iter().enumerate().filter(|(_, entrant)| extent.asks(entrant)) {
        for case in CASES.iter().filter(|case| entrant.stands_on(case.support)) {
            let name = case.support.name();
            progress.begin(&format!("{}: {name}, {} mm, {}", entrant.title, case.depth_mm, case.state()));
            let dent = case.dent(extent.case_grid);
            let (dented, reference) = (entrant.dent(&dent, case.support)?, case.reference()?);
            let error = dented.error(&reference, &dent);
            let middle_mm = f64::from(dent.pot.height.as_mm()) * 0.5;
            let rim = |radial_mm: &dyn Fn(f64) -> f64| {
                (0..=120).map(|part| radial_mm(middle_mm + f64::from(part) * 0.25)).fold(f64::NEG_INFINITY, f64::max)
            };
            let ours = |z_mm: f64| dented.radial_mm_at(0.0, z_mm);
            let theirs = |z_mm: f64| reference.radial_mm(0.0, z_mm);
            let (tip_mm, rim_mm) = ([ours(middle_mm), theirs(middle_mm)], [rim(&ours), rim(&theirs)]);
            figures.push(CaseFigures { row, case: *case, dented, error, tip_mm, rim_mm });
        }
    }
    Ok(figures)
}
