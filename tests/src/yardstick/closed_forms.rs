//! Cases with an answer on paper.
//!
//! Owns the formulas and where they come from; computes nothing that a yardstick computes.
//! Invariant: millimetres, newtons and megapascals throughout; a deflection is positive along its load.

/// Modulus of flat contact with a rigid body: `E* = E/(1 − ν²)`, MPa.
#[must_use]
pub fn contact_modulus_mpa(youngs_mpa: f64, poisson: f64) -> f64 {
    youngs_mpa / (1.0 - poisson * poisson)
}

/// Force on a rigid sphere pressed into an elastic half-space, N: `F = 4/3·E*·√R·δ^1.5`.
///
/// Hertz 1881; Johnson, Contact Mechanics, 1985, section 4.2.
#[must_use]
pub fn hertz_n(contact_modulus_mpa: f64, sphere_mm: f64, depth_mm: f64) -> f64 {
    4.0 / 3.0 * contact_modulus_mpa * sphere_mm.sqrt() * depth_mm.powf(1.5)
}

/// Deflection of an elastic half-space beside a point load, mm: `u_z = P(1 − ν²)/(πEr) = P/(πE*r)`.
///
/// Boussinesq 1885; Johnson 1985, section 3.2.
#[must_use]
pub fn boussinesq_mm(load_n: f64, contact_modulus_mpa: f64, distance_mm: f64) -> f64 {
    load_n / (std::f64::consts::PI * contact_modulus_mpa * distance_mm)
}

/// Change of a thin ring's diameter between two opposed loads, mm, positive along them:
/// `ΔD = (π/4 − 2/π)·P·R³/(E·I)`, which is `0.1488·P·R³/(E·I)`, with `I` in mm⁴.
///
/// Roark's Formulas for Stress and Strain, table 9.2, case 1.
#[must_use]
pub fn ring_mm(load_n: f64, radius_mm: f64, youngs_mpa: f64, inertia_mm4: f64) -> f64 {
    use std::f64::consts::PI;
    (PI / 4.0 - 2.0 / PI) * load_n * radius_mm.powi(3) / (youngs_mpa * inertia_mm4)
}

/// Deflection of a long thin tube under a load all round, in N for each mm of circumference:
/// `w = P·R²·β/(2Et)`, `β⁴ = 3(1 − ν²)/(R²t²)`.
///
/// Timoshenko and Woinowsky-Krieger, Theory of Plates and Shells, 1959, section 115.
#[must_use]
pub fn ring_load_mm(load_n_per_mm: f64, radius_mm: f64, wall_mm: f64, youngs_mpa: f64, poisson: f64) -> f64 {
    let decay = (3.0 * (1.0 - poisson * poisson)).powf(0.25) / (radius_mm * wall_mm).sqrt();
    load_n_per_mm * radius_mm * radius_mm * decay / (2.0 * youngs_mpa * wall_mm)
}

/// Inward displacement at a radius of a thick tube under a pressure outside, free at its ends, mm:
/// `u = p·b²/(E(b² − a²))·((1 − ν)r + (1 + ν)a²/r)`.
///
/// Lamé and Clapeyron 1831; Timoshenko and Goodier, Theory of Elasticity, 1970, section 28.
#[must_use]
pub fn lame_mm(pressure_mpa: f64, [inner_mm, outer_mm]: [f64; 2], youngs_mpa: f64, poisson: f64, at_mm: f64) -> f64 {
    let outer = outer_mm * outer_mm;
    let share = pressure_mpa * outer / (youngs_mpa * (outer - inner_mm * inner_mm));
    share * ((1.0 - poisson) * at_mm + (1.0 + poisson) * inner_mm * inner_mm / at_mm)
}

/// Share of an edge's displacement that a membrane on springs keeps at a distance: `exp(−s/λ)`, `λ = √(T/k)`, with the
/// tension T in N/mm and the springs' stiffness k in MPa/mm.
#[must_use]
pub fn membrane_share(distance_mm: f64, tension_n_per_mm: f64, stiffness_mpa_per_mm: f64) -> f64 {
    (-distance_mm / (tension_n_per_mm / stiffness_mpa_per_mm).sqrt()).exp()
}

/// Deflection of a layer's surface, deep in a wide load, for each MPa, mm: `(1 − ν²)·t/E` on a base without friction
/// under a load that varies along one direction only.
#[must_use]
pub fn wide_load_mm_per_mpa(wall_mm: f64, contact_modulus_mpa: f64) -> f64 {
    wall_mm / contact_modulus_mpa
}

/// A point load of 1 N half-way up a shell of 50 mm radius, 6 mm wall and 120 mm height with diaphragms at its ends,
/// E = 1 MPa, ν = 0.45: angles from the load, degrees, and inward deflections at its height, mm.
///
/// Sum of the double Fourier series of Sanders's shell (400 × 300 terms), a calculation apart from [`super::shell`].
pub const SHELL_POINT_LOAD: [(f64, f64); 6] =
    [(0.0, 1.3143), (10.0, 1.0470), (20.0, 0.6135), (45.0, -0.2251), (90.0, -0.2565), (180.0, 0.0802)];

/// Deflection under one of two opposed loads of 1 on a cylinder of radius 300, wall 3 and length 600 with diaphragms at
/// its ends, E = 3·10⁶, ν = 0.3.
///
/// Belytschko et al., Stress projection for membrane and shear locking in shell finite elements, 1985.
pub const PINCHED_CYLINDER: f64 = 1.8248e-5;
