//! Hollow pots pressed from outside and from inside to depths that the finite elements know a force at: when a wall folds, how much it
//! softens then, and the clay at it; and how far the inner wall goes with a dent outside.
//!
//! Owns the list of files and what of a curve is compared; surfaces are [`super::dents`]'.
//! Invariant: a curve is read once, on its first way in.

use glam::Vec3;
use pottery_shared::clay::{GridShape, Material, PlasticCsem, PlasticLaw, Pot, Press, SubStep, Support};
use pottery_shared::tool::{Side, Sphere};
use pottery_shared::units::Tick;

use super::dents::{KnownDent, STOPS_WITHIN_MM};
use super::{FitError, Fitted, STEPS_IN, counted, misfits, simplex};
use crate::chart::cases::{BASE, Scene};
use crate::dent::{Dent, DentError};
use crate::reference::ForceCurve;

/// Travels that are compared, mm, of presses up to 2 and 4 mm.
const TO_2_MM: &[f32] = &[0.5, 1.0, 2.0];
const TO_4_MM: &[f32] = &[0.5, 1.0, 2.0, 3.0, 4.0];
/// Steps in which a ball comes in from inside, and after which it rests.
const INSIDE_STEPS_IN: u32 = 60;
const INSIDE_STEPS: u32 = 300;

struct File {
    scene: Scene,
    side: Side,
    depths_mm: &'static [f32],
    force: &'static str,
    /// For how many others its forces count in a fit.
    weight: f64,
}

macro_rules! file {
    ($name:literal, $side:ident, $scene:expr, $depths_mm:expr) => {
        File {
            scene: Scene { name: $name, ..$scene },
            side: Side::$side,
            depths_mm: $depths_mm,
            force: include_str!(concat!("../../data/fem/", $name, "_depth_force.csv")),
            weight: 1.0,
        }
    };
}

const FILES: &[File] = &[
    // the reference's own, whose wall is 5 % stiffer than the same pot's below, and which the law is to be as near to as to that
    File {
        scene: Scene { name: "A", ..BASE },
        side: Side::Outside,
        depths_mm: TO_2_MM,
        force: include_str!("../../data/reference/A_depth_force.csv"),
        weight: 4.0,
    },
    file!("hollow_base", Outside, BASE, TO_4_MM),
    file!("hollow_base_d6", Outside, BASE, &[6.0]),
    file!("hollow_ball20", Outside, Scene { tool_mm: 20.0, ..BASE }, TO_2_MM),
    file!("hollow_e1y15", Outside, Scene { youngs_mpa: 1.0, yield_kpa: 15.0, ..BASE }, TO_2_MM),
    file!("hollow_r40w6", Outside, Scene { pot_mm: [40.0, 6.0], ..BASE }, TO_2_MM),
    file!("hollow_wall12", Outside, Scene { pot_mm: [60.0, 12.0], ..BASE }, TO_2_MM),
    file!("inside_ball12", Inside, BASE, TO_4_MM),
    file!("inside_ball20", Inside, Scene { tool_mm: 20.0, ..BASE }, TO_4_MM),
    file!("inside_ball20_d6", Inside, Scene { tool_mm: 20.0, ..BASE }, &[6.0]),
    file!("inside_ball20_y20", Inside, Scene { tool_mm: 20.0, yield_kpa: 20.0, ..BASE }, &[4.0]),
    file!("inside_ball30", Inside, Scene { tool_mm: 30.0, ..BASE }, TO_4_MM),
    file!("inside_ball40", Inside, Scene { tool_mm: 40.0, ..BASE }, TO_4_MM),
];

const HELD_OUT: &[File] = &[
    file!("held_hollow_ball20", Outside, Scene { tool_mm: 20.0, ..BASE }, &[4.0]),
    file!("held_hollow_ball8", Outside, Scene { tool_mm: 8.0, ..BASE }, &[2.0]),
    file!("held_hollow_r50w5_ball16", Outside, Scene { pot_mm: [50.0, 5.0], tool_mm: 16.0, ..BASE }, &[1.0, 2.0]),
    file!("held_inside_ball30_d6", Inside, Scene { tool_mm: 30.0, ..BASE }, &[6.0]),
    file!("held_inside_ball40_d6", Inside, Scene { tool_mm: 40.0, ..BASE }, &[6.0]),
    file!("held_hollow_ball20_y80", Outside, Scene { tool_mm: 20.0, yield_kpa: 80.0, ..BASE }, &[4.0]),
    file!("held_inside_ball20_y80", Inside, Scene { tool_mm: 20.0, yield_kpa: 80.0, ..BASE }, &[4.0]),
];

/// Yield stress of clay that does not yield under any of the balls, kPa.
const ELASTIC_KPA: f32 = 1000.0;

const ELASTIC: &[File] = &[
    file!("hollow_ball20_elastic", Outside, Scene { tool_mm: 20.0, yield_kpa: ELASTIC_KPA, ..BASE }, &[4.0]),
    file!("hollow_ball40_elastic", Outside, Scene { tool_mm: 40.0, yield_kpa: ELASTIC_KPA, ..BASE }, &[4.0]),
    file!("inside_ball12_elastic", Inside, Scene { yield_kpa: ELASTIC_KPA, ..BASE }, &[4.0]),
    file!("inside_ball20_elastic", Inside, Scene { tool_mm: 20.0, yield_kpa: ELASTIC_KPA, ..BASE }, &[4.0]),
    file!("inside_ball40_elastic", Inside, Scene { tool_mm: 40.0, yield_kpa: ELASTIC_KPA, ..BASE }, &[6.0]),
];

/// A hollow pot pressed to a depth, and what force that takes.
#[derive(Clone, Copy, Debug)]
pub struct KnownForce {
    /// The case.
    pub name: &'static str,
    /// The press.
    pub dent: Dent,
    /// From where it is made.
    pub side: Side,
    /// The reference's force at that depth, and its largest, N.
    pub force_n: f64,
    /// See `force_n`.
    pub largest_force_n: f64,
    /// For how many others it counts in a fit.
    pub weight: f64,
}

/// Every finite-element force on a hollow wall that the law is fitted to, to be found again on a grid.
///
/// # Errors
/// [`FitError`] when a file is damaged or knows no force at its travel.
pub fn finite_elements(grid: GridShape) -> Result<Vec<KnownForce>, FitError> {
    read(FILES, grid)
}

/// Those that nothing is fitted to.
///
/// # Errors
/// As [`finite_elements`].
pub fn held_out(grid: GridShape) -> Result<Vec<KnownForce>, FitError> {
    read(HELD_OUT, grid)
}

/// Those of walls that never yield: how a wall bends alone. Nothing is fitted to them.
///
/// # Errors
/// As [`finite_elements`].
pub fn elastic(grid: GridShape) -> Result<Vec<KnownForce>, FitError> {
    read(ELASTIC, grid)
}

fn read(files: &[File], grid: GridShape) -> Result<Vec<KnownForce>, FitError> {
    let mut known = Vec::new();
    for &File { ref scene, side, depths_mm, force, weight } in files {
        let file = format!("{}_depth_force.csv", scene.name);
        let curve = ForceCurve::parse(force).map_err(|source| FitError::Reference { file: file.clone(), source })?;
        for &depth_mm in depths_mm {
            let reached = curve.first_at_n(f64::from(depth_mm) - STOPS_WITHIN_MM);
            let force_n = reached.ok_or_else(|| FitError::Force { file: file.clone(), depth_mm })?;
            let mut dent = scene.dent(grid, depth_mm, false);
            (dent.pot.support, dent.pot.keeps_volume) = (Support::Hollow, false);
            let largest_force_n = curve.largest_n();
            known.push(KnownForce { name: scene.name, dent, side, force_n, largest_force_n, weight });
        }
    }
    Ok(known)
}

/// Error of a law's force over the largest of the same curve, press by press; positive is too hard.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn errors(law: PlasticLaw, known: &[KnownForce]) -> Result<Vec<f64>, FitError> {
    known.iter().map(|known| Ok((known.borne_n(law)? - known.force_n) / known.largest_force_n)).collect()
}

impl KnownForce {
    /// Travel, mm.
    #[must_use]
    pub fn depth_mm(&self) -> f32 {
        self.dent.depth.as_mm()
    }

    /// Radial force on the ball when it has come to rest, N.
    ///
    /// # Errors
    /// [`FitError::Dent`] for figures that make no sense.
    pub fn borne_n(&self, law: PlasticLaw) -> Result<f64, FitError> {
        let method = PlasticCsem { law };
        let force_n = match self.side {
            Side::Outside => self.dent.press_with(method, STEPS_IN)?.contact().force_n.x,
            Side::Inside => -inside(&self.dent, method)?.x,
        };
        Ok(force_n.into())
    }
}

/// Force on a ball that is pressed into a wall from inside and has come to rest, N.
fn inside(dent: &Dent, method: PlasticCsem) -> Result<Vec3, DentError> {
    let Dent { pot, strength, tool, depth, .. } = *dent;
    let (mut substep, mut pot) = (SubStep::for_spheres(pot.shape), Pot::new(pot)?);
    let (wall_m, middle_m) = (pot.spec().radius.0 - pot.spec().wall.0, 0.5 * pot.spec().height.0);
    let tool = Sphere::new(tool)?;
    let response = Material { viscosity: Material::VISCOSITY_MIN, ..Material::default() }.response(Tick::PERIOD);
    let mut force_n = Vec3::ZERO;
    for number in 1..=INSIDE_STEPS {
        let deep_m = depth.0 * (number as f32 / INSIDE_STEPS_IN as f32).min(1.0);
        let at_m = Vec3::new(wall_m - tool.radius().0 + deep_m, 0.0, middle_m);
        let press = Press { side: Side::Inside, response, strength, ..Press::held(tool, at_m) };
        force_n = substep.advance(&mut pot, &[press], method, |_, _| {})[0].force_n;
    }
    Ok(force_n)
}

/// Constants of a hollow wall, in this order.
pub const HOLLOW: [&str; 4] = ["wall_wider", "wall_wider_from", "wall_softer", "wall_weaker"];

/// The constants of a hollow wall.
#[must_use]
pub fn hollow(law: &PlasticLaw) -> [f64; 4] {
    [law.wall_wider, law.wall_wider_from, law.wall_softer, law.wall_weaker].map(f64::from)
}

/// Root mean square of what the errors of a law's forces count, large ones more, and the mean over dents of hollow walls of the root mean squares of both surfaces,
/// over the travel.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn score(law: PlasticLaw, forces: &[KnownForce], dents: &[KnownDent]) -> Result<f64, FitError> {
    let errors = errors(law, forces)?;
    let misfits = misfits(law, dents)?;
    let surfaces = misfits.iter().map(|misfit| misfit.loaded + misfit.permanent).sum::<f64>() / misfits.len() as f64;
    let (squares, weights) = errors.iter().zip(forces).fold((0.0, 0.0), |(squares, weights), (error, known)| {
        (squares + known.weight * counted(*error).powi(2), weights + known.weight)
    });
    Ok((squares / weights).sqrt() + surfaces)
}

/// Fits these constants, with all else of `start` held.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn fit(
    start: PlasticLaw,
    forces: &[KnownForce],
    dents: &[KnownDent],
    iterations: u32,
    tell: impl FnMut(u32, f64),
) -> Result<Fitted, FitError> {
    let law = |at: [f64; 4]| {
        let [wall_wider, wall_wider_from, wall_softer, wall_weaker] = at.map(|value| value.max(0.0) as f32);
        PlasticLaw { wall_wider, wall_wider_from, wall_softer, wall_weaker, ..start }
    };
    let found = simplex::descend(hollow(&start), iterations, |at| score(law(at), forces, dents), tell)?;
    Ok(Fitted { law: law(found.at), score: found.value })
}

/// Constants of how a wall's other skin goes along and of how the wall stays folded, in this order.
pub const FOLLOWING: [&str; 3] = ["wall_follows", "wall_follows_from", "wall_stays"];

/// The constants of how a wall's other skin goes along and of how the wall stays folded.
#[must_use]
pub fn following(law: &PlasticLaw) -> [f64; 3] {
    [law.wall_follows, law.wall_follows_from, law.wall_stays].map(f64::from)
}

/// By how much farther inwards than in the finite elements the inner wall has gone behind each dent, over the travel.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn behind(law: PlasticLaw, dents: &[KnownDent]) -> Result<Vec<f64>, FitError> {
    dents
        .iter()
        .map(|known| {
            let pressed = known.dent.press_with(PlasticCsem { law }, STEPS_IN)?;
            Ok((known.behind_mm - pressed.behind_mm()) / f64::from(known.dent.depth.as_mm()))
        })
        .collect()
}

/// Fits how a wall's other skin goes along and how the wall stays folded, with all else of `start` held, by the root mean square of [`behind`]
/// and of the misfits of the pots' permanent shapes.
///
/// # Errors
/// [`FitError::Dent`] for figures that make no sense.
pub fn fit_following(
    start: PlasticLaw,
    dents: &[KnownDent],
    iterations: u32,
    tell: impl FnMut(u32, f64),
) -> Result<Fitted, FitError> {
    let law = |at: [f64; 3]| {
        let [wall_follows, wall_follows_from, wall_stays] = at.map(|value| value.max(0.0) as f32);
        PlasticLaw { wall_follows, wall_follows_from, wall_stays, ..start }
    };
    let score = |at| -> Result<f64, FitError> {
        let mut off = behind(law(at), dents)?;
        off.extend(misfits(law(at), dents)?.iter().map(|misfit| misfit.permanent));
        Ok((off.iter().map(|off| off * off).sum::<f64>() / off.len() as f64).sqrt())
    };
    let found = simplex::descend(following(&start), iterations, score, tell)?;
    Ok(Fitted { law: law(found.at), score: found.value })
}
