//! What wet clay does to a tool that slides along it.
//!
//! Owns the law of friction and its step; how fast the clay goes by is told.
//! Invariant: the drag never pushes the tool along, and never exceeds what the clay's own shear strength bears.

use glam::Vec3;

use crate::clay::Material;
use crate::units::Seconds;

/// The clay along which a tool slides.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wet {
    /// How fast the clay under the tool moves in the room, m/s.
    pub clay_velocity_m_s: Vec3,
    /// Area of the contact, m².
    pub area_m2: f32,
    /// What the clay is made of, which tells how wet it is.
    pub material: Material,
}

/// Friction along clay, as felt: `min(F₀ + c·v, F_max)` against the slip, v the slip's speed.
///
/// With LI the clay's liquidity index from 0 to 1, N the force across the contact, A its area:
/// - `F₀ = (1 − LI)·μ·N`: Coulomb where tool and clay touch, which the wetter they are is on the smaller a part of the area. μ = 0.2 is
///   chosen from within the 8° to 15° at which clays slide on smooth solids once they have slid far;
/// - `c = LI·A·η/h`: a film of slip elsewhere, of viscosity `η = (9.27/(1 + LI))^3.3` mPa·s (Locat and Demers 1988, for a film that is
///   wetter than the clay by its plasticity index) and thickness h = 0.2 mm, chosen;
/// - `F_max = A·s_u`, `s_u = σ_y/√3` the clay's undrained strength: beyond it the clay shears and not the film.
///
/// Throwing clay drags with about 0.15 of what presses, stiff clay with 0.18, slip with 0.03 and the more the faster it goes by.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Drag {
    still_n: f32,
    per_speed_ns_m: f32,
    most_n: f32,
}

impl Drag {
    const FRICTION: f32 = 0.2;
    const FILM_M: f32 = 0.2e-3;

    /// The drag at a force across the contact, N, all of it times the share that is felt.
    pub(super) fn of(wet: &Wet, across_n: f32, felt_share: f32) -> Self {
        let liquidity = wet.material.wetness().liquidity_index();
        let film_pa_s = 1e-3 * libm::powf(9.27 / (1.0 + liquidity), 3.3);
        let strength_pa = wet.material.strength.yield_pa / libm::sqrtf(3.0);
        Self {
            still_n: (1.0 - liquidity) * Self::FRICTION * across_n * felt_share,
            per_speed_ns_m: liquidity * wet.area_m2 * film_pa_s / Self::FILM_M * felt_share,
            most_n: wet.area_m2 * strength_pa * felt_share,
        }
    }

    /// How far a tool slips that is pulled by a spring of stiffness K whose other end is `reach_m` away, m, within dt.
    ///
    /// One implicit Euler step of `K·(q − u) = F(u/dt)` (Kikuuwe, Takesue, Sano, Mochiyama and Fujimoto 2006), so that it sticks while
    /// the spring pulls less than F₀ and trembles at no stiffness and no step.
    pub(super) fn slip_m(&self, reach_m: Vec3, stiffness_n_m: f32, dt: Seconds) -> Vec3 {
        let reach = reach_m.length();
        let pull_n = stiffness_n_m * reach;
        let still_n = self.still_n.min(self.most_n);
        if pull_n <= still_n {
            return Vec3::ZERO;
        }
        let by_film = (pull_n - still_n) / (stiffness_n_m + self.per_speed_ns_m / dt.0);
        let by_shear = (pull_n - self.most_n) / stiffness_n_m;
        reach_m * (by_film.max(by_shear) / reach)
    }
}
