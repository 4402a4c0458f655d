//! The stored cases by name, and their making: what `tests/data/fem` holds.
//!
//! Owns the list and what of each result is kept; writes through the caller, so it touches no file itself.
//! Invariant: a case is made from its name alone.

use super::element::Material;
use super::press::{Case, Diverged, Pace, Press, Side, Support, Wall};
use super::stroke::{self, Drawing};
use super::tables::forces_to_csv;

/// What a name stands for.
#[derive(Clone, Debug, PartialEq)]
pub enum Kind {
    /// A ball pressed into a still wall.
    Press(Case),
    /// A ball drawn along the wall.
    Draw(Drawing),
}

/// A file of a case.
#[derive(Clone, Debug, PartialEq)]
pub struct File {
    /// Its name.
    pub name: String,
    /// Its text.
    pub text: String,
}

/// No tables came of it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MakeError {
    /// The name is not in [`all`].
    #[error("no case is called {name}; `all` lists them")]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// The calculation blew up.
    #[error(transparent)]
    Diverged(#[from] Diverged),
}

/// Arc and height on either side of the tool that are kept (m).
const KEPT_M: f64 = 0.020;
/// Height of the first stroke (m).
const STROKES_AT_M: f64 = 0.040;
/// Digits kept behind the point of a millimetre.
const DIGITS: usize = 4;

const CLAY: Material = Material { young_pa: 2e6, poisson: 0.45, yield_pa: 40e3, density_kg_m3: 2000.0 };
const WALL: Wall = Wall {
    radius_m: 0.060,
    wall_m: 0.008,
    height_m: 0.200,
    layers: 6,
    fine_m: 0.004 / 3.0,
    fine_until_m: 0.0175,
    growth: 1.25,
    coarse_m: 0.012,
};
/// Quick enough for a wall on a mandrel, whose slowest motion takes a millisecond.
const BACKED_PACE: Pace =
    Pace { load_s_m: 15.0, rest_s: 0.012, moving_drag_per_s: 100.0, resting_drag_per_s: 400.0, courant: 0.88 };
/// A hollow wall swings at some 10 Hz.
const HOLLOW_PACE: Pace =
    Pace { load_s_m: 100.0, rest_s: 0.07, moving_drag_per_s: 15.0, resting_drag_per_s: 90.0, courant: 0.88 };

fn backed(depths_mm: &[f64]) -> Case {
    Case {
        wall: WALL,
        at_m: 0.1,
        ball_m: 0.012,
        side: Side::Outside,
        support: Support::Backed,
        material: CLAY,
        assumed_shear: false,
        depths_m: depths_mm.iter().map(|depth_mm| 1e-3 * depth_mm).collect(),
        pace: BACKED_PACE,
    }
}

fn hollow(depths_mm: &[f64], load_s_m: f64) -> Case {
    Case {
        wall: Wall { coarse_m: 0.008, ..WALL },
        support: Support::Hollow,
        assumed_shear: true,
        pace: Pace { load_s_m, ..HOLLOW_PACE },
        ..backed(depths_mm)
    }
}

/// A ball inside, on bricks as large as its contact allows.
fn inside(depths_mm: &[f64], ball_mm: f64, layers: usize, [fine_mm, fine_until_mm]: [f64; 2]) -> Case {
    let case = of_ball(hollow(depths_mm, 100.0), ball_mm, fine_mm, fine_until_mm);
    Case { side: Side::Inside, wall: Wall { layers, ..case.wall }, ..case }
}

fn of_clay(case: Case, young_mpa: f64, yield_kpa: f64) -> Case {
    Case { material: Material { young_pa: 1e6 * young_mpa, yield_pa: 1e3 * yield_kpa, ..CLAY }, ..case }
}

/// From outside, on the bricks of a press from inside.
fn outside(case: Case) -> Case {
    Case { side: Side::Outside, ..case }
}

/// Of clay that never yields.
fn elastic(case: Case) -> Case {
    of_clay(case, 2.0, 1000.0)
}

fn of_wall(case: Case, radius_mm: f64, wall_mm: f64, layers: usize) -> Case {
    Case { wall: Wall { radius_m: 1e-3 * radius_mm, wall_m: 1e-3 * wall_mm, layers, ..case.wall }, ..case }
}

fn of_ball(case: Case, ball_mm: f64, fine_mm: f64, fine_until_mm: f64) -> Case {
    let wall = Wall { fine_m: 1e-3 * fine_mm, fine_until_m: 1e-3 * fine_until_mm, ..case.wall };
    Case { ball_m: 1e-3 * ball_mm, wall, ..case }
}

/// On bricks of 8 mm over `layers`, as many as there are through the wall.
fn drawn(ball_mm: f64, layers: usize, strokes_mm: &[[f64; 2]]) -> Drawing {
    Drawing {
        wall: Wall { height_m: 0.080, growth: 1.3, layers, fine_m: WALL.wall_m / layers as f64, ..WALL },
        ball_m: 1e-3 * ball_mm,
        strokes: strokes_mm.iter().map(|[depth_mm, up_mm]| [1e-3 * depth_mm, STROKES_AT_M + 1e-3 * up_mm]).collect(),
        length_m: 0.060,
        margin_m: 0.025,
        speed_m_s: 0.6,
        material: CLAY,
        pace: Pace { load_s_m: 10.0, rest_s: 0.010, courant: 0.8, ..BACKED_PACE },
    }
}

/// Every stored case.
pub fn all() -> Vec<(&'static str, Kind)> {
    let fine = 4.0 / 3.0;
    let presses = [
        ("backed_base", backed(&[1.0, 2.0, 4.0])),
        ("backed_ball8", of_ball(backed(&[1.0, 2.0, 4.0]), 8.0, 1.0, 14.0)),
        ("backed_ball20", of_ball(backed(&[1.0, 2.0, 4.0]), 20.0, fine, 22.0)),
        ("backed_r40w6", of_wall(backed(&[1.0, 2.0, 4.0]), 40.0, 6.0, 6)),
        ("backed_e1y15", of_clay(backed(&[1.0, 2.0, 4.0]), 1.0, 15.0)),
        ("backed_e5y40", of_clay(backed(&[1.0, 2.0, 4.0]), 5.0, 40.0)),
        ("backed_e2y80", of_clay(backed(&[1.0, 2.0, 4.0]), 2.0, 80.0)),
        ("backed_wall12", of_wall(backed(&[2.0, 4.0]), 60.0, 12.0, 8)),
        ("backed_wall5", of_wall(backed(&[2.0]), 60.0, 5.0, 5)),
        ("loose_base", Case { support: Support::Loose, ..backed(&[1.0, 2.0]) }),
        ("hollow_base", hollow(&[1.0, 2.0, 4.0], 100.0)),
        ("hollow_base_d6", of_ball(hollow(&[6.0], 100.0), 12.0, fine, 20.0)),
        ("hollow_ball20", of_ball(hollow(&[2.0], 70.0), 20.0, fine, 22.0)),
        ("hollow_r40w6", of_wall(hollow(&[2.0], 70.0), 40.0, 6.0, 6)),
        ("hollow_e1y15", of_clay(hollow(&[2.0], 70.0), 1.0, 15.0)),
        ("hollow_wall12", of_wall(hollow(&[2.0], 70.0), 60.0, 12.0, 8)),
        ("inside_ball12", inside(&[1.0, 2.0, 4.0], 12.0, 6, [fine, 17.5])),
        ("inside_ball20", inside(&[1.0, 2.0, 4.0], 20.0, 6, [fine, 20.0])),
        ("inside_ball20_d6", inside(&[6.0], 20.0, 6, [fine, 22.0])),
        ("inside_ball20_y20", of_clay(inside(&[4.0], 20.0, 6, [fine, 20.0]), 2.0, 20.0)),
        ("inside_ball30", inside(&[1.0, 2.0, 4.0], 30.0, 5, [1.6, 28.0])),
        ("inside_ball40", inside(&[1.0, 2.0, 4.0], 40.0, 4, [2.0, 36.0])),
        ("inside_ball12_elastic", elastic(inside(&[4.0], 12.0, 6, [fine, 20.0]))),
        ("inside_ball20_elastic", elastic(inside(&[4.0], 20.0, 5, [1.6, 24.0]))),
        ("inside_ball40_elastic", elastic(inside(&[6.0], 40.0, 4, [2.0, 38.0]))),
        ("hollow_ball20_elastic", outside(elastic(inside(&[4.0], 20.0, 5, [1.6, 24.0])))),
        ("hollow_ball40_elastic", outside(elastic(inside(&[4.0], 40.0, 4, [2.0, 30.0])))),
    ];
    // no constant of the studio's clay was fitted to these
    let held_out = [
        ("held_ball10", of_ball(backed(&[1.0, 2.0, 4.0]), 10.0, 1.1, 16.0)),
        ("held_ball16", of_ball(backed(&[1.0, 2.0, 4.0]), 16.0, fine, 19.0)),
        ("held_wall6_ball20", of_ball(of_wall(backed(&[2.0, 4.0]), 60.0, 6.0, 5), 20.0, fine, 22.0)),
        ("held_r40w6_ball16", of_ball(of_wall(backed(&[2.0, 4.0]), 40.0, 6.0, 5), 16.0, fine, 19.0)),
        ("held_r80w10", of_wall(backed(&[1.0, 2.0, 4.0]), 80.0, 10.0, 7)),
        ("held_e05y10_ball18", of_clay(of_ball(backed(&[1.0, 2.0, 4.0]), 18.0, fine, 20.0), 0.5, 10.0)),
        (
            "held_e35y40_r70w7_ball14",
            of_clay(of_ball(of_wall(backed(&[1.0, 2.0, 4.0]), 70.0, 7.0, 6), 14.0, 1.2, 17.0), 3.5, 40.0),
        ),
        ("held_hollow_ball20", of_ball(hollow(&[2.0, 4.0], 100.0), 20.0, fine, 24.0)),
        ("held_inside_ball20_y80", of_clay(inside(&[4.0], 20.0, 5, [1.6, 24.0]), 2.0, 80.0)),
        ("held_hollow_ball20_y80", outside(of_clay(inside(&[4.0], 20.0, 5, [1.6, 24.0]), 2.0, 80.0))),
        ("held_inside_ball30_d6", inside(&[6.0], 30.0, 5, [1.6, 30.0])),
        ("held_inside_ball40_d6", inside(&[6.0], 40.0, 4, [2.0, 38.0])),
        ("held_hollow_ball8", of_ball(hollow(&[2.0], 70.0), 8.0, 1.0, 14.0)),
        ("held_hollow_r50w5_ball16", of_ball(of_wall(hollow(&[1.0, 2.0], 70.0), 50.0, 5.0, 5), 16.0, fine, 19.0)),
    ];
    let drawings = [
        ("stroke_d1f4", drawn(12.0, 8, &[[1.0, 0.0], [1.0, 4.0]])),
        ("stroke_ball16_d1f4", drawn(16.0, 8, &[[1.0, 0.0], [1.0, 4.0]])),
        ("stroke_ball20_d1f4", drawn(20.0, 8, &[[1.0, 0.0], [1.0, 4.0]])),
        // a deep bite of a small ball folds finer bricks
        ("stroke_d2", drawn(12.0, 7, &[[2.0, 0.0]])),
        ("stroke_ball16_d2", drawn(16.0, 7, &[[2.0, 0.0]])),
        ("stroke_ball20_d2", drawn(20.0, 8, &[[2.0, 0.0]])),
    ];
    let presses = presses.into_iter().chain(held_out).map(|(name, case)| (name, Kind::Press(case)));
    presses.chain(drawings.into_iter().map(|(name, case)| (name, Kind::Draw(case)))).collect()
}

/// Makes a case and hands over each file as soon as it is complete: profiles of what lies within 20 mm of the tool, and
/// the forces. Takes from a minute to an hour.
///
/// # Errors
/// [`MakeError::Unknown`] for a name that is not listed, [`MakeError::Diverged`] when the calculation blew up.
pub fn make(name: &str, mut write: impl FnMut(File)) -> Result<(), MakeError> {
    let (_, kind) = all()
        .into_iter()
        .find(|(known, _)| *known == name)
        .ok_or_else(|| MakeError::Unknown { name: name.to_owned() })?;
    match kind {
        Kind::Press(case) => make_press(name, case, &mut write),
        Kind::Draw(case) => make_drawing(name, &case, &mut write),
    }
}

fn make_press(name: &str, case: Case, write: &mut impl FnMut(File)) -> Result<(), MakeError> {
    let mut press = Press::new(case);
    press.run(|depth_m, loaded, press| {
        let (state, depth_mm) = (if loaded { 'L' } else { 'U' }, (1e6 * depth_m).round() * 1e-3);
        let case = &press.case;
        let near = [0.0, KEPT_M / case.wall.radius_m];
        let text = press.profile().window(near, heights_mm(case.at_m, case.at_m)).to_csv(DIGITS);
        write(File { name: format!("{name}_d{depth_mm}{state}_profile.csv"), text });
    })?;
    write(File { name: format!("{name}_depth_force.csv"), text: forces_to_csv(&press.rows) });
    Ok(())
}

/// Of a drawing, the groove is kept where its strokes neither begin nor end.
fn make_drawing(name: &str, case: &Drawing, write: &mut impl FnMut(File)) -> Result<(), MakeError> {
    let mut forces =
        String::from("strokes,radial_N,tangential_N,axial_N,held_radial_N,held_tangential_N,held_axial_N\n");
    let arc = |arc_m: f64| arc_m / case.wall.radius_m;
    stroke::run(case, |stroke| {
        let heights_mm = heights_mm(case.strokes[0][1], case.strokes[stroke.number - 1][1]);
        let groove = stroke.unloaded.window([arc(0.4 * case.length_m), arc(0.7 * case.length_m)], heights_mm);
        write(File { name: format!("{name}_s{}U_profile.csv", stroke.number), text: groove.to_csv(DIGITS) });
        forces.push_str(&stroke.number.to_string());
        for part in stroke.moving_n.iter().chain(&stroke.held_n) {
            forces.push_str(&format!(",{part:.4}"));
        }
        forces.push('\n');
    })?;
    write(File { name: format!("{name}_force.csv"), text: forces });
    Ok(())
}

/// Heights that are kept, for a tool that goes from one height (m) to another.
fn heights_mm(from_m: f64, to_m: f64) -> [f64; 2] {
    [1e3 * (from_m - KEPT_M), 1e3 * (to_m + KEPT_M)]
}
