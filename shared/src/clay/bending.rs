//! How the wall of a hollow pot bends as a whole under a tool.
//!
//! Owns the shell: its stiffness, its answers to loads at evenly spaced heights, and what is read between them. Knows no tool
//! and no clay but Poisson's ratio; everything is per pascal of Young's modulus.
//! Invariant: pure arithmetic on three measures of the pot, so that a pot bends the same, bit for bit, everywhere; what a load
//! at one height does at another is what it does the other way round (Maxwell and Betti).

use super::lanes::{hypot, root};
use alloc::vec::Vec;
use core::f64::consts::PI;

/// Poisson's ratio of wet clay.
pub(super) const POISSON: f32 = 0.45;

/// Harmonics round the pot: 0 breathes, 1 leans, 2 and more make it oval. What the rest adds under a load follows from the
/// last of them.
const HARMONICS: usize = 13;
/// Elements from foot to rim, and the nodes between them.
const ELEMENTS: usize = 40;
const NODES: usize = ELEMENTS + 1;
/// Unknowns of a node: axial, circumferential and radial displacement and their slopes along the axis.
const UNKNOWNS: usize = 6;
/// The radial one.
const RADIAL: usize = 2;
/// Unknowns before one that its equation knows of.
const BAND: usize = 2 * UNKNOWNS - 1;
/// Length ℓ within which the wall gives way to a load as a plate does, over √(R·t), and the one that its curvature under
/// the load goes by: both from shells of radii 37 to 57.5 mm and walls of 5 to 12 mm, loaded on discs of 2 to 10 mm.
const PLATE_REACH: f32 = 4.5;
const CURVED_REACH: f32 = 3.05;
/// Length within which a wall that yields folds to a cone, over √(R·t): from the finite-element pot pressed in by 4 mm, half of a
/// wall that yields a third more than an elastic one would give way.
const FOLD_REACH: f32 = 1.65;
/// How steep the cone may be as which a wall stays folded: a steeper one would be deeper than a wide tool. Three times as steep as after the deepest
/// presses that finite elements know.
const FOLD_STEEPEST: f32 = 0.3;

/// A wall with nothing behind it: a thin cylindrical shell, fixed at the foot and free at the rim.
///
/// Along the axis it is made of 40 elements of cubic interpolation, round it of the harmonics `u, w ∝ cos nθ`, `v ∝ sin nθ`,
/// n = 0…12, with the strains of Sanders (1959) on the middle surface, R its radius:
/// - `ε_x = u'`, `ε_θ = (nv + w)/R`, `γ = v' − nu/R`;
/// - `κ_x = −w''`, `κ_θ = (nv + n²w)/R²`, `2κ_xθ = (2nw' + 3v'/2)/R + nu/(2R²)`.
///
/// The energy `½∫∫ K·(ε_x² + ε_θ² + 2νε_xε_θ + ½(1 − ν)γ²) + D·(the same of κ)`, with `K = Et/(1 − ν²)` and `D = Kt²/12`, gives
/// one banded system a harmonic; a point load F is `F·(1/2π + Σ cos nθ/π)` round the pot. ν = 0.45.
///
/// A load on a disc of radius a sinks less than a point load, by a plate's `F·a²/(16πD)·(ln(ℓ/a) + ¼)`
/// (Timoshenko and Woinowsky-Krieger 1959), `ℓ = 4.5·√(R·t)`.
///
/// The bottom is taken as part of the wheel head. `tests/tests/clay/bending.rs` holds the wall to another solver, to a long ring and to
/// the finite-element reference.
#[derive(Clone, Debug)]
pub struct WallBending {
    /// What it follows from, m.
    radius_m: f32,
    wall_m: f32,
    height_m: f32,
    /// Under the load, of all harmonics and the rest beyond them, for every node, 1/m.
    under_load: [f32; NODES],
    /// `[harmonics][node of the load][node]`, 1/m.
    answers: Vec<f32>,
}

/// Pots of the same measures bend alike.
impl PartialEq for WallBending {
    fn eq(&self, other: &Self) -> bool {
        (self.radius_m, self.wall_m, self.height_m) == (other.radius_m, other.wall_m, other.height_m)
    }
}

impl WallBending {
    /// Of an untouched cylinder with an outer radius, a wall and a height.
    #[must_use]
    pub fn new(radius_m: f32, wall_m: f32, height_m: f32) -> Self {
        let shell = Shell {
            radius_m: f64::from(radius_m) - 0.5 * f64::from(wall_m),
            wall_m: f64::from(wall_m),
            step_m: f64::from(height_m) / ELEMENTS as f64,
        };
        let mut answers = alloc::vec![0.0; HARMONICS * NODES * NODES];
        let mut under_load = [0.0; NODES];
        for (harmonic, square) in answers.chunks_exact_mut(NODES * NODES).enumerate() {
            let factor = Factor::of(&shell, harmonic);
            for load in 1..NODES {
                let moved = factor.under_load(load);
                for (node, moved_m) in (load..NODES).zip(moved) {
                    square[load * NODES + node] = moved_m as f32;
                    square[node * NODES + load] = moved_m as f32;
                }
            }
            // of a plate each falls with n³, so that those left out are a multiple of the last one
            let share = if harmonic + 1 < HARMONICS { 1.0 } else { 1.0 + left_out(harmonic as f32) };
            (0..NODES).for_each(|node| under_load[node] += share * square[node * NODES + node]);
        }
        Self { radius_m, wall_m, height_m, under_load, answers }
    }

    /// How far the wall gives way under a load at a height that is spread over a disc of radius `patch_m`: deflection times
    /// Young's modulus over force, 1/m (m·Pa/N).
    ///
    /// Zero at the foot.
    #[must_use]
    pub fn compliance(&self, z_m: f32, patch_m: f32) -> f32 {
        let place = self.place(z_m);
        let point: f32 = place.weights.iter().zip(&self.under_load[place.first..]).map(|(share, at)| share * at).sum();
        (point - self.plate().patch(0.0, patch_m)).max(0.0)
    }

    /// How far the wall gives way at one place, an angle and a height, under a load at another that is spread over a disc of radius
    /// `patch_m`, as in [`WallBending::compliance`], 1/m: the same the other way round.
    #[must_use]
    pub fn between(&self, at: [f32; 2], load: [f32; 2], patch_m: f32) -> f32 {
        let [there, here] = [at, load].map(|[_, z_m]| self.place(z_m));
        let away_rad = nearest_turn(at[0] - load[0]);
        let cosine = libm::cosf(away_rad);
        let (mut before, mut now) = (cosine, 1.0);
        let (mut all, mut last) = (0.0, 0.0);
        for square in self.answers.chunks_exact(NODES * NODES) {
            last = 0.0;
            for (weight, row) in here.weights.iter().zip(square[here.first * NODES..].chunks_exact(NODES)) {
                let moved: f32 =
                    there.weights.iter().zip(&row[there.first..]).map(|(share, moved)| share * moved).sum();
                last += weight * moved;
            }
            all += last * now;
            (before, now) = (now, 2.0 * cosine * now - before);
        }
        // those that are left out fall off round the pot as a plate's do
        let harmonic = HARMONICS as f32 - 1.0;
        let waves = (harmonic + 0.5) * away_rad.abs();
        all += last * left_out(harmonic) * (1.0 + waves) * libm::expf(-waves);
        let distance_m = hypot(away_rad * self.middle_m(), at[1] - load[1]);
        all - self.plate().patch(distance_m, patch_m)
    }

    /// The share of a load at one place by which a wall folds at another: a cone.
    #[must_use]
    pub fn folding(&self, at: [f32; 2], load: [f32; 2]) -> f32 {
        self.plate().fold(self.distance_m(at, load))
    }

    /// How far two places, each an angle and a height, are from each other along the untouched wall, m.
    pub(super) fn distance_m(&self, one: [f32; 2], other: [f32; 2]) -> f32 {
        hypot(nearest_turn(one[0] - other[0]) * self.middle_m(), one[1] - other[1])
    }

    /// How far it may stay folded, m.
    pub(super) fn folds_most_m(&self) -> f32 {
        FOLD_STEEPEST * FOLD_REACH * self.length_m()
    }

    /// Thickness with which it was made, m.
    pub(super) const fn wall_m(&self) -> f32 {
        self.wall_m
    }

    /// Length within which a shell bends, m: `√(R·t)`.
    pub(super) fn length_m(&self) -> f32 {
        root(self.middle_m() * self.wall_m)
    }

    /// Radius of the middle surface, m.
    fn middle_m(&self) -> f32 {
        self.radius_m - 0.5 * self.wall_m
    }

    /// How much less the wall gives way at the edge of such a disc than in its middle, over the square of its radius: as in
    /// [`WallBending::compliance`], 1/m³.
    ///
    /// A plate's `(ln(ℓ/a) − ½ − 1/12)/(8πD)` with `ℓ = 3.05·√(R·t)`, the paraboloid with the mean of the plate's own surface.
    #[must_use]
    pub fn bow(&self, patch_m: f32) -> f32 {
        let plate = self.plate();
        let reach = CURVED_REACH / PLATE_REACH * plate.reach_m / patch_m;
        (libm::logf(reach) - 0.5 - 1.0 / 12.0).max(0.0) / plate.eight_pi_rigidity()
    }

    /// Compliance by which a wall is near to folding at a height, for a point: at half its height or there, whichever is more. The foot
    /// holds the wall beside it, which does not fold before it gives way.
    #[must_use]
    pub fn fold_compliance(&self, z_m: f32) -> f32 {
        self.compliance(z_m, 0.0).max(self.compliance(0.5 * self.height_m, 0.0))
    }

    /// Load at which a plate as thick as the wall folds about it, a force over Young's modulus, m², for clay that yields at a share
    /// of Young's modulus.
    ///
    /// `2π·σ_y·t²/(4·E)`: 2π times the moment that a strip bears (Hopkins and Prager 1953).
    #[must_use]
    pub fn fold_m2(&self, yields_at: f32) -> f32 {
        0.5 * core::f32::consts::PI * yields_at * self.wall_m * self.wall_m
    }

    /// The whole wall's deflection under a load at an angle and a height on a disc of radius `patch_m`, elastic but for a cone of
    /// depth `hinge_m` where it folds; the load is a force over Young's modulus, m².
    #[must_use]
    pub fn under(&self, load_m2: f32, hinge_m: f32, angle_rad: f32, z_m: f32, patch_m: f32) -> Bend {
        let place = self.place(z_m);
        let mut shares = [[0.0; NODES]; HARMONICS];
        for (shares, square) in shares.iter_mut().zip(self.answers.chunks_exact(NODES * NODES)) {
            for (weight, row) in place.weights.iter().zip(square[place.first * NODES..].chunks_exact(NODES)) {
                shares.iter_mut().zip(row).for_each(|(share, moved)| *share += load_m2 * weight * moved);
            }
        }
        let (plate, radius_m, height_m) = (self.plate(), self.middle_m(), self.height_m);
        Bend { load_m2, hinge_m, angle_rad, z_m, patch_m, radius_m, height_m, plate, shares }
    }

    fn place(&self, z_m: f32) -> Place {
        Place::of(z_m, self.height_m)
    }

    fn plate(&self) -> Plate {
        let wall_m = self.wall_m;
        Plate {
            rigidity_m3: wall_m * wall_m * wall_m / (12.0 * (1.0 - POISSON * POISSON)),
            reach_m: PLATE_REACH * self.length_m(),
        }
    }
}

/// Deflection of the whole wall under one load.
#[derive(Clone, Debug)]
pub struct Bend {
    load_m2: f32,
    hinge_m: f32,
    angle_rad: f32,
    z_m: f32,
    patch_m: f32,
    radius_m: f32,
    height_m: f32,
    plate: Plate,
    /// `[harmonics][nodes]`, m.
    shares: [[f32; NODES]; HARMONICS],
}

impl Bend {
    /// Deflection in the direction of the load at a place of the pot, m.
    #[must_use]
    pub fn at_m(&self, angle_rad: f32, z_m: f32) -> f32 {
        let place = Place::of(z_m, self.height_m);
        let away_rad = angle_rad - self.angle_rad;
        let cosine = libm::cosf(away_rad);
        // cos nθ from the two before it
        let (mut before, mut now) = (cosine, 1.0);
        let mut all = 0.0;
        for shares in &self.shares {
            let share: f32 =
                place.weights.iter().zip(&shares[place.first..]).map(|(weight, share)| weight * share).sum();
            all += share * now;
            (before, now) = (now, 2.0 * cosine * now - before);
        }
        let distance_m = hypot(nearest_turn(away_rad) * self.radius_m, z_m - self.z_m);
        all + self.about_m(distance_m)
    }

    /// Adds the deflections at evenly spaced angles and heights, from the foot to `height_m`, to others, `[columns][rows]`, m: what
    /// [`Bend::at_m`] says of each, in a fraction of the time.
    pub fn add_to(&self, all_m: &mut [f32], rows: usize, height_m: f32) {
        let columns = all_m.len() / rows.max(1);
        let column_rad = core::f32::consts::TAU / columns as f32;
        let row_m = height_m / rows.saturating_sub(1).max(1) as f32;
        let ends_m = self.plate.ends_m();
        for (number, column_m) in all_m.chunks_exact_mut(rows.max(1)).enumerate() {
            let away_rad = nearest_turn(number as f32 * column_rad - self.angle_rad);
            let nodes_m = self.column_m(libm::cosf(away_rad));
            let aside_m = away_rad * self.radius_m;
            for (row, all_m) in column_m.iter_mut().enumerate() {
                let z_m = row as f32 * row_m;
                let place = Place::of(z_m, self.height_m);
                let shell_m: f32 =
                    place.weights.iter().zip(&nodes_m[place.first..]).map(|(weight, node_m)| weight * node_m).sum();
                let up_m = z_m - self.z_m;
                let distance_m = root(aside_m * aside_m + up_m * up_m);
                let near_m = if distance_m < ends_m { self.about_m(distance_m) } else { 0.0 };
                *all_m += shell_m + near_m;
            }
        }
    }

    /// What the harmonics add up to in the nodes of a column, the cosine of whose angle from the load it is, m.
    fn column_m(&self, cosine: f32) -> [f32; NODES] {
        let mut nodes_m = [0.0; NODES];
        let (mut before, mut now) = (cosine, 1.0);
        for shares in &self.shares {
            nodes_m.iter_mut().zip(shares).for_each(|(node_m, share)| *node_m += share * now);
            (before, now) = (now, 2.0 * cosine * now - before);
        }
        nodes_m
    }

    /// What a load that is spread, and a fold, change about it, m: nothing farther off than [`Plate::ends_m`].
    fn about_m(&self, distance_m: f32) -> f32 {
        self.hinge_m * self.plate.fold(distance_m) - self.load_m2 * self.plate.patch(distance_m, self.patch_m)
    }
}

/// The same angle within half a turn of zero.
pub(super) fn nearest_turn(angle_rad: f32) -> f32 {
    angle_rad - core::f32::consts::TAU * libm::roundf(angle_rad / core::f32::consts::TAU)
}

/// The flat plate that the wall is close to a load.
#[derive(Clone, Copy, Debug)]
struct Plate {
    /// Bending stiffness over Young's modulus, m³.
    rigidity_m3: f32,
    reach_m: f32,
}

impl Plate {
    /// How much less the plate gives way at a distance when the load is spread over a disc, 1/m.
    ///
    /// A point load's deflection is `r²·ln(r/ℓ)/(8πD)`; a disc's is that and `(a²/2)·(ln(r/ℓ) + 1)/(8πD)` outside and
    /// `(r⁴/(8a²) + r²·(L + ½) + a²·(L/2 − ⅛))/(8πD)` inside, `L = ln(a/ℓ)`. A disc wider than `ℓ/e`, beyond which a shell is no plate, counts as
    /// one of that radius: with a larger one less than nothing would be left of what the shell gives way by.
    fn patch(&self, distance_m: f32, patch_m: f32) -> f32 {
        if patch_m <= 0.0 {
            return 0.0;
        }
        let patch_m = patch_m.min(self.widest_m());
        let (distance2, patch2) = (distance_m * distance_m, patch_m * patch_m);
        let part = |of_m: f32| libm::logf(of_m / self.reach_m).min(-1.0);
        let more = if distance_m > patch_m {
            0.5 * patch2 * (part(distance_m) + 1.0)
        } else {
            let edge = part(patch_m);
            let point = if distance_m > 0.0 { distance2 * part(distance_m) } else { 0.0 };
            distance2 * distance2 / (8.0 * patch2) + distance2 * (edge + 0.5) + patch2 * (0.5 * edge - 0.125) - point
        };
        -more / self.eight_pi_rigidity()
    }

    /// Radius up to which a disc that is loaded is one on a plate, m: `ℓ/e`.
    fn widest_m(&self) -> f32 {
        self.reach_m / core::f32::consts::E
    }

    /// Distance beyond which neither a load on a disc nor a fold shows, m: that radius and the cone's end.
    fn ends_m(&self) -> f32 {
        self.widest_m().max(FOLD_REACH / PLATE_REACH * self.reach_m)
    }

    /// The cone to which it folds under a load at a distance.
    fn fold(&self, distance_m: f32) -> f32 {
        (1.0 - distance_m / (FOLD_REACH / PLATE_REACH * self.reach_m)).max(0.0)
    }

    fn eight_pi_rigidity(&self) -> f32 {
        8.0 * core::f32::consts::PI * self.rigidity_m3
    }
}

/// The nodes about a height and their shares: a cubic through four of them.
struct Place {
    first: usize,
    weights: [f32; 4],
}

impl Place {
    fn of(z_m: f32, height_m: f32) -> Self {
        let place = (z_m / height_m * ELEMENTS as f32).clamp(0.0, ELEMENTS as f32);
        let first = (place as usize).saturating_sub(1).min(NODES - 4);
        let x = place - first as f32;
        let [a, b, c, d] = [x, x - 1.0, x - 2.0, x - 3.0];
        Self { first, weights: [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0] }
    }
}

/// `Σ (last/n)³` over the harmonics n after the last one.
fn left_out(last: f32) -> f32 {
    let next = last + 0.5;
    last * last * last / (2.0 * next * next)
}

/// Stiffness of an element or part of it: rows and columns are the lower node's unknowns and the upper node's.
type Element = [[f64; 2 * UNKNOWNS]; 2 * UNKNOWNS];

/// Measures of the shell, m.
struct Shell {
    /// Of the middle surface.
    radius_m: f64,
    wall_m: f64,
    /// Height of an element.
    step_m: f64,
}

impl Shell {
    /// Coordinates and weights of Gauss's rule of four points on 0 to 1.
    const GAUSS: [(f64, f64); 4] = [
        (0.069_431_844_202_973_71, 0.173_927_422_568_726_93),
        (0.330_009_478_207_571_87, 0.326_072_577_431_273_07),
        (0.669_990_521_792_428_1, 0.326_072_577_431_273_07),
        (0.930_568_155_797_026_3, 0.173_927_422_568_726_93),
    ];

    /// Hermite's four cubics at x of an element: value, slope and second derivative of each. The first two belong to the
    /// lower node's value and slope, the others to the upper node's.
    fn cubics(&self, x: f64) -> [[f64; 3]; 4] {
        let (h, y) = (self.step_m, 1.0 - x);
        let lean = 6.0 * x * y / h;
        let bend = 6.0 * (1.0 - 2.0 * x) / (h * h);
        [
            [y * y * (1.0 + 2.0 * x), -lean, -bend],
            [h * x * y * y, y * (1.0 - 3.0 * x), (6.0 * x - 4.0) / h],
            [x * x * (1.0 + 2.0 * y), lean, bend],
            [-h * x * x * y, x * (3.0 * x - 2.0), (6.0 * x - 2.0) / h],
        ]
    }

    /// `[ε_x, ε_θ, γ, κ_x, κ_θ, 2κ_xθ]` that each unknown makes at x of an element, see [`WallBending`].
    fn strains(&self, n: f64, x: f64) -> [[f64; 6]; 2 * UNKNOWNS] {
        let r = self.radius_m;
        let mut strains = [[0.0; 6]; 2 * UNKNOWNS];
        for (unknowns, [value, slope, bend]) in strains.chunks_exact_mut(3).zip(self.cubics(x)) {
            // values of both nodes stand before their slopes: three unknowns a cubic
            unknowns[0] = [slope, 0.0, -n * value / r, 0.0, 0.0, 0.5 * n * value / (r * r)];
            unknowns[1] = [0.0, n * value / r, slope, 0.0, n * value / (r * r), 1.5 * slope / r];
            unknowns[2] = [0.0, value / r, 0.0, -bend, n * n * value / (r * r), 2.0 * n * slope / r];
        }
        strains
    }

    /// Stiffness of an element for one harmonic and E = 1, m: the energy's second derivatives.
    fn element(&self, harmonic: usize) -> Element {
        let poisson = f64::from(POISSON);
        let round = PI * self.radius_m * if harmonic == 0 { 2.0 } else { 1.0 };
        let stretch = self.wall_m / (1.0 - poisson * poisson) * round * self.step_m;
        let bend = stretch * self.wall_m * self.wall_m / 12.0;
        let mut stiffness = [[0.0; 2 * UNKNOWNS]; 2 * UNKNOWNS];
        for (x, weight) in Self::GAUSS {
            let strains = self.strains(harmonic as f64, x);
            for (row, one) in stiffness.iter_mut().zip(&strains) {
                let stress = |along: f64, hoop: f64, twist: f64| {
                    [along + poisson * hoop, hoop + poisson * along, 0.5 * (1.0 - poisson) * twist]
                };
                let ([a, b, c], [d, e, f]) = (stress(one[0], one[1], one[2]), stress(one[3], one[4], one[5]));
                for (entry, other) in row.iter_mut().zip(&strains) {
                    let stretched = a * other[0] + b * other[1] + c * other[2];
                    let bent = d * other[3] + e * other[4] + f * other[5];
                    *entry += weight * (stretch * stretched + bend * bent);
                }
            }
        }
        stiffness
    }
}

/// Stiffness K of the shell for one harmonic as `L·D·Lᵀ`.
struct Factor {
    /// Row i holds the entries of L for the columns i − 11 to i − 1 and 1/D.
    rows: Vec<[f64; BAND + 1]>,
}

impl Factor {
    fn of(shell: &Shell, harmonic: usize) -> Self {
        let mut rows = Self::assembled(&shell.element(harmonic), harmonic);
        for row in 0..rows.len() {
            let (done, rest) = rows.split_at_mut(row);
            let current = &mut rest[0];
            let first = row.saturating_sub(BAND);
            // entries first hold L·D, then L
            for column in first..row {
                let other = &done[column];
                let shared = first.max(column.saturating_sub(BAND));
                let sum: f64 = (shared..column).map(|k| current[k + BAND - row] * other[k + BAND - column]).sum();
                current[column + BAND - row] -= sum;
            }
            let mut pivot = current[BAND];
            for column in first..row {
                let scaled = current[column + BAND - row] * done[column][BAND];
                pivot -= scaled * current[column + BAND - row];
                current[column + BAND - row] = scaled;
            }
            assert!(pivot > 0.0, "a shell whose foot is held has a stiffness");
            current[BAND] = 1.0 / pivot;
        }
        Self { rows }
    }

    /// The lower band of K: the elements beneath and above each node, and 1 for what is held.
    fn assembled(element: &Element, harmonic: usize) -> Vec<[f64; BAND + 1]> {
        let entry = |row: usize, column: usize| {
            if held(row, harmonic) || held(column, harmonic) {
                return if row == column { 1.0 } else { 0.0 };
            }
            let (upper, lower) = (row / UNKNOWNS, column / UNKNOWNS);
            let (i, j) = (row % UNKNOWNS, column % UNKNOWNS);
            if lower + 1 == upper {
                return element[i + UNKNOWNS][j];
            }
            let beneath = if upper > 0 { element[i + UNKNOWNS][j + UNKNOWNS] } else { 0.0 };
            beneath + if upper < ELEMENTS { element[i][j] } else { 0.0 }
        };
        (0..NODES * UNKNOWNS)
            .map(|row| {
                let mut band = [0.0; BAND + 1];
                let first = (row / UNKNOWNS).saturating_sub(1) * UNKNOWNS;
                (first.max(row.saturating_sub(BAND))..=row)
                    .for_each(|column| band[column + BAND - row] = entry(row, column));
                band
            })
            .collect()
    }

    /// Radial displacement of the loaded node and of those above it, under a load of one.
    fn under_load(&self, node: usize) -> impl Iterator<Item = f64> {
        let first = node * UNKNOWNS + RADIAL;
        let mut moved = [0.0; NODES * UNKNOWNS];
        moved[first] = 1.0;
        for row in first + 1..moved.len() {
            let from = first.max(row.saturating_sub(BAND));
            let entries = &self.rows[row][from + BAND - row..BAND];
            let sum: f64 = entries.iter().zip(&moved[from..row]).map(|(entry, value)| entry * value).sum();
            moved[row] = -sum;
        }
        for row in (first..moved.len()).rev() {
            moved[row] *= self.rows[row][BAND];
        }
        for row in (first + 1..moved.len()).rev() {
            let value = moved[row];
            let from = first.max(row.saturating_sub(BAND));
            let entries = &self.rows[row][from + BAND - row..BAND];
            moved[from..row].iter_mut().zip(entries).for_each(|(before, entry)| *before -= entry * value);
        }
        (first..NODES * UNKNOWNS).step_by(UNKNOWNS).map(move |row| moved[row])
    }
}

/// Whether an unknown stays zero: the foot's displacements and its slope, and what turns when nothing waves.
fn held(unknown: usize, harmonic: usize) -> bool {
    let foot = unknown < UNKNOWNS && [0, 1, RADIAL, 3 + RADIAL].contains(&unknown);
    foot || (harmonic == 0 && unknown % 3 == 1)
}
