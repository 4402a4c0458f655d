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

/// Radius of the finger inside.
pub const FINGER: Metres = Metres(0.015);

/// Pot, sphere and clay of a case.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// What differs from the first one, in a word or two.
    pub name: &'static str,
    /// Outer radius and wall of the pot, which is 200 mm high, mm.
    pub pot_mm: [f32; 2],
    /// Radius of the sphere, mm.
    pub tool_mm: f32,
    /// Young's modulus, MPa.
    pub youngs_mpa: f32,
    /// Yield stress, kPa.
    pub yield_kpa: f32,
}

/// The scene of the first reference.
pub const BASE: Scene = Scene { name: "base", pot_mm: [60.0, 8.0], tool_mm: 12.0, youngs_mpa: 2.0, yield_kpa: 40.0 };

impl Scene {
    /// A press of it to a depth.
    #[must_use]
    pub fn dent(&self, grid: GridShape, depth_mm: f32, release: bool) -> Dent {
        let Self { pot_mm: [radius_mm, wall_mm], tool_mm, youngs_mpa, yield_kpa, .. } = *self;
        let base = reference_dent(grid, depth_mm, release);
        Dent {
            pot: PotSpec { radius: Metres::from_mm(radius_mm), wall: Metres::from_mm(wall_mm), ..base.pot },
            strength: Strength { youngs_pa: youngs_mpa * 1e6, yield_pa: yield_kpa * 1e3 },
            tool: Metres::from_mm(tool_mm),
            ..base
        }
    }
}

/// One dent of the reference.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// Pot, sphere and clay.
    pub scene: Scene,
    /// What holds the wall.
    pub support: Support,
    /// Travel of the sphere from first touch, mm.
    pub depth_mm: u32,
    /// Whether the sphere was taken away before the surface was read.
    pub release: bool,
    text: &'static str,
}

macro_rules! case {
    ($scene:expr, $support:ident, $depth_mm:literal, $release:literal, $file:literal) => {
        Case {
            scene: $scene,
            support: Support::$support,
            depth_mm: $depth_mm,
            release: $release,
            text: include_str!(concat!("../../data/", $file, "_profile.csv")),
        }
    };
}

/// Every dent of the reference.
pub const CASES: &[Case] = &[
    case!(BASE, Backed, 1, false, "reference/B_d1L"),
    case!(BASE, Backed, 1, true, "reference/B_d1U"),
    case!(BASE, Backed, 2, false, "reference/B_d2L"),
    case!(BASE, Backed, 2, true, "reference/B_d2U"),
    case!(BASE, Hollow, 1, false, "reference/A_d1L"),
    case!(BASE, Hollow, 1, true, "reference/A_d1U"),
    case!(BASE, Hollow, 2, false, "reference/A_d2L"),
    case!(BASE, Hollow, 2, true, "reference/A_d2U"),
    case!(BASE, Finger, 1, false, "reference/F_d1L"),
    case!(BASE, Finger, 1, true, "reference/F_d1U"),
];

/// The surface of the reference's first scene, 1 or 2 mm deep.
///
/// # Panics
/// Where the reference has no such dent.
#[must_use]
pub fn reference_profile(support: Support, depth_mm: u32, release: bool) -> Profile {
    let stands = |case: &&Case| {
        case.scene == BASE && case.support == support && case.depth_mm == depth_mm && case.release == release
    };
    let case = CASES.iter().find(stands).expect("the reference holds this dent");
    case.reference().expect("the file is whole, as `chart::cases` shows each time it is drawn")
}

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
        finger: None,
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
        self.scene.dent(grid, self.depth_mm as f32, self.release)
    }

    /// Whether it is one of the four by which methods are compared: the base scene with its wall backed.
    #[must_use]
    pub fn is_base(&self) -> bool {
        self.scene == BASE && self.support == Support::Backed && self.depth_mm <= 2
    }

    /// What it is, in a few words.
    #[must_use]
    pub fn title(&self) -> String {
        format!("{}, {}, {} mm", self.support.name(), self.scene.name, self.depth_mm)
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
        "scene",
        "pot_radius_mm",
        "wall_mm",
        "tool_radius_mm",
        "youngs_mpa",
        "yield_kpa",
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
            self.case.scene.name.into(),
            f64::from(self.case.scene.pot_mm[0]).into(),
            f64::from(self.case.scene.pot_mm[1]).into(),
            f64::from(self.case.scene.tool_mm).into(),
            f64::from(self.case.scene.youngs_mpa).into(),
            f64::from(self.case.scene.yield_kpa).into(),
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
            progress.begin(&format!("{}: {}, {}", entrant.title, case.title(), case.state()));
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
