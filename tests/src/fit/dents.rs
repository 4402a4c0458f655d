//! The dents that a law is fitted to and those that it is held against: finite-element ones of backed and hollow walls, or a law's own.
//!
//! Owns the lists of files and the raster on which surfaces are compared.
//! Invariant: a dent's surfaces are read on the raster once; a fit only presses.

use pottery_shared::clay::{GridShape, PlasticCsem, PlasticLaw, Support};

use super::{FitError, STEPS_IN};
use crate::chart::cases::{BASE, Scene};
use crate::dent::{Dent, DentError, Pressing};
use crate::reference::{ForceCurve, Profile};

/// Half a side of the raster, in cells, and a cell, mm: 15 mm of arc and height to all sides of the tool.
const CELLS: i32 = 30;
const CELL_MM: f64 = 0.5;
/// A ball is taken to be there within so much of its travel, mm: some only pass by, and come to the next stop.
pub(super) const STOPS_WITHIN_MM: f64 = 0.011;

/// A dent and what it is known to be like.
#[derive(Clone, Debug)]
pub struct KnownDent {
    /// Its press.
    pub name: &'static str,
    /// The same, to be made.
    pub dent: Dent,
    /// Radial displacement on the raster, mm, with the tool in and when it has left.
    loaded_mm: Vec<f64>,
    permanent_mm: Vec<f64>,
    /// Radial displacement of the inner wall behind the tool's middle when it has left, mm.
    pub behind_mm: f64,
    /// Force on the tool when it reaches its depth, and the largest of the whole press, N.
    pub force_n: f64,
    /// See `force_n`.
    pub largest_force_n: f64,
}

struct Files {
    scene: Scene,
    force: &'static str,
    /// Travel, mm, and the surfaces loaded and unloaded.
    depths: &'static [(f32, &'static str, &'static str)],
}

macro_rules! files {
    ($name:literal, $scene:expr, $($depth:literal)*) => {
        Files {
            scene: Scene { name: $name, ..$scene },
            force: include_str!(concat!("../../data/fem/", $name, "_depth_force.csv")),
            depths: &[$((
                $depth as f32,
                include_str!(concat!("../../data/fem/", $name, "_d", $depth, "L_profile.csv")),
                include_str!(concat!("../../data/fem/", $name, "_d", $depth, "U_profile.csv")),
            )),*],
        }
    };
}

const FILES: &[Files] = &[
    files!("backed_base", BASE, 1 2 4),
    files!("backed_ball8", Scene { tool_mm: 8.0, ..BASE }, 1 2 4),
    files!("backed_ball20", Scene { tool_mm: 20.0, ..BASE }, 1 2 4),
    files!("backed_r40w6", Scene { pot_mm: [40.0, 6.0], ..BASE }, 1 2 4),
    files!("backed_wall5", Scene { pot_mm: [60.0, 5.0], ..BASE }, 2),
    files!("backed_wall12", Scene { pot_mm: [60.0, 12.0], ..BASE }, 2 4),
    files!("backed_e1y15", Scene { youngs_mpa: 1.0, yield_kpa: 15.0, ..BASE }, 1 2 4),
    files!("backed_e2y80", Scene { yield_kpa: 80.0, ..BASE }, 1 2 4),
    files!("backed_e5y40", Scene { youngs_mpa: 5.0, ..BASE }, 1 2 4),
];

const HELD_OUT: &[Files] = &[
    files!("held_ball10", Scene { tool_mm: 10.0, ..BASE }, 1 2 4),
    files!("held_ball16", Scene { tool_mm: 16.0, ..BASE }, 1 2 4),
    files!("held_wall6_ball20", Scene { pot_mm: [60.0, 6.0], tool_mm: 20.0, ..BASE }, 2 4),
    files!("held_r40w6_ball16", Scene { pot_mm: [40.0, 6.0], tool_mm: 16.0, ..BASE }, 2 4),
    files!("held_r80w10", Scene { pot_mm: [80.0, 10.0], ..BASE }, 1 2 4),
    files!("held_e05y10_ball18", Scene { tool_mm: 18.0, youngs_mpa: 0.5, yield_kpa: 10.0, ..BASE }, 1 2 4),
    files!(
        "held_e35y40_r70w7_ball14",
        Scene { pot_mm: [70.0, 7.0], tool_mm: 14.0, youngs_mpa: 3.5, ..BASE },
        1 2 4
    ),
];

const HOLLOW: &[Files] = &[
    files!("hollow_base", BASE, 1 2 4),
    files!("hollow_ball20", Scene { tool_mm: 20.0, ..BASE }, 2),
    files!("hollow_e1y15", Scene { youngs_mpa: 1.0, yield_kpa: 15.0, ..BASE }, 2),
    files!("hollow_r40w6", Scene { pot_mm: [40.0, 6.0], ..BASE }, 2),
    files!("hollow_wall12", Scene { pot_mm: [60.0, 12.0], ..BASE }, 2),
];

const HOLLOW_HELD_OUT: &[Files] = &[
    files!("held_hollow_ball8", Scene { tool_mm: 8.0, ..BASE }, 2),
    files!("held_hollow_r50w5_ball16", Scene { pot_mm: [50.0, 5.0], tool_mm: 16.0, ..BASE }, 1 2),
];

/// Every finite-element dent of a backed wall that the law is fitted to, to be made again on a grid.
///
/// # Errors
/// [`FitError`] when a file is damaged or knows no force at its travel.
pub fn finite_elements(grid: GridShape) -> Result<Vec<KnownDent>, FitError> {
    read(FILES, Support::Backed, grid)
}

/// Those that nothing is fitted to: other balls, pots, walls and clays.
///
/// # Errors
/// As [`finite_elements`].
pub fn held_out(grid: GridShape) -> Result<Vec<KnownDent>, FitError> {
    read(HELD_OUT, Support::Backed, grid)
}

/// Every finite-element dent of a hollow wall that the law's wall is fitted to.
///
/// # Errors
/// As [`finite_elements`].
pub fn hollow(grid: GridShape) -> Result<Vec<KnownDent>, FitError> {
    read(HOLLOW, Support::Hollow, grid)
}

/// Those that nothing is fitted to.
///
/// # Errors
/// As [`finite_elements`].
pub fn hollow_held_out(grid: GridShape) -> Result<Vec<KnownDent>, FitError> {
    read(HOLLOW_HELD_OUT, Support::Hollow, grid)
}

fn read(files: &[Files], support: Support, grid: GridShape) -> Result<Vec<KnownDent>, FitError> {
    let mut known = Vec::new();
    for Files { scene, force, depths } in files {
        let file = format!("{}_depth_force.csv", scene.name);
        let curve = ForceCurve::parse(force).map_err(|source| FitError::Reference { file: file.clone(), source })?;
        for &(depth_mm, loaded, unloaded) in *depths {
            let profile = |state: char, text| {
                let file = || format!("{}_d{depth_mm}{state}_profile.csv", scene.name);
                Profile::parse(text).map_err(|source| FitError::Reference { file: file(), source })
            };
            let dent = pressed(scene, support, grid, depth_mm);
            let (loaded, unloaded) = (profile('L', loaded)?, profile('U', unloaded)?);
            let middle_mm = 0.5 * f64::from(dent.pot.height.as_mm());
            let inner_mm = f64::from(dent.pot.radius.as_mm() - dent.pot.wall.as_mm());
            let reached = curve.first_at_n(f64::from(depth_mm) - STOPS_WITHIN_MM);
            known.push(KnownDent {
                name: scene.name,
                loaded_mm: raster(&dent, |angle, z_mm| loaded.radial_mm(angle, z_mm)),
                permanent_mm: raster(&dent, |angle, z_mm| unloaded.radial_mm(angle, z_mm)),
                behind_mm: unloaded.inner_mm(0.0, middle_mm) - inner_mm,
                force_n: reached.ok_or_else(|| FitError::Force { file: file.clone(), depth_mm })?,
                largest_force_n: curve.largest_n(),
                dent,
            });
        }
    }
    Ok(known)
}

/// A press whose pot keeps its height, as the reference's does.
fn pressed(scene: &Scene, support: Support, grid: GridShape, depth_mm: f32) -> Dent {
    let mut dent = scene.dent(grid, depth_mm, true);
    (dent.pot.support, dent.pot.keeps_volume) = (support, false);
    dent
}

/// Values over the raster about the tool.
fn raster(dent: &Dent, at: impl Fn(f64, f64) -> f64) -> Vec<f64> {
    let (radius_mm, middle_mm) = (f64::from(dent.pot.radius.as_mm()), 0.5 * f64::from(dent.pot.height.as_mm()));
    let lines = || (-CELLS..=CELLS).map(|cell| f64::from(cell) * CELL_MM);
    let mut values = Vec::with_capacity((2 * CELLS as usize + 1).pow(2));
    for across_mm in lines() {
        values.extend(lines().map(|up_mm| at(across_mm / radius_mm, middle_mm + up_mm)));
    }
    values
}

impl KnownDent {
    /// A dent as a law makes it: what a fit has to find back.
    ///
    /// # Errors
    /// [`DentError`] for figures that make no sense.
    pub fn of_law(law: PlasticLaw, scene: &Scene, grid: GridShape, depth_mm: f32) -> Result<Self, DentError> {
        let dent = pressed(scene, Support::Backed, grid, depth_mm);
        let pressed = dent.press_with(PlasticCsem { law }, STEPS_IN)?;
        let force_n = pressed.contact().force_n.x.into();
        Ok(Self {
            name: scene.name,
            loaded_mm: raster(&dent, pressed.radial_mm(false)),
            permanent_mm: raster(&dent, pressed.radial_mm(true)),
            behind_mm: pressed.behind_mm(),
            force_n,
            largest_force_n: force_n,
            dent,
        })
    }

    /// Root mean square of the difference to a press over the raster, over the travel.
    pub(super) fn difference(&self, pressed: &Pressing, release: bool) -> f64 {
        let known_mm = if release { &self.permanent_mm } else { &self.loaded_mm };
        let pressed_mm = raster(&self.dent, pressed.radial_mm(release));
        let squares = known_mm.iter().zip(&pressed_mm).map(|(known, pressed)| (known - pressed).powi(2));
        (squares.sum::<f64>() / known_mm.len() as f64).sqrt() / f64::from(self.dent.depth.as_mm())
    }
}
