//! A haptic device in a simulated hand, as the loop sees it: sampled, quantised, held and late.
//!
//! Owns the mechanics between two samples; knows no clay and no chain.
//! Invariant: force acts for whole hundreds of microseconds, so that a loop of 10 kHz has a step of its own.

use std::collections::VecDeque;

use glam::{DVec3, Vec3};

/// Step of the mechanics, s.
const STEP_S: f64 = 1e-4;

/// How a device is held: device and hand together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grip {
    /// What it is called.
    pub name: &'static str,
    /// Mass, kg.
    pub mass_kg: f64,
    /// Damping, N·s/m.
    pub damping_ns_m: f64,
    /// Stiffness towards where the hand means to be, N/m.
    pub stiffness_n_m: f64,
}

impl Grip {
    /// A pen held by its end.
    pub const LIGHT: Self = Self { name: "light", mass_kg: 0.12, damping_ns_m: 1.5, stiffness_n_m: 100.0 };
    /// The hand of the literature.
    pub const STANDARD: Self = Self { name: "standard", mass_kg: 0.195, damping_ns_m: 4.1, stiffness_n_m: 300.0 };
    /// A fist.
    pub const FIRM: Self = Self { name: "firm", mass_kg: 0.35, damping_ns_m: 9.0, stiffness_n_m: 1000.0 };
    /// From the lightest to the firmest.
    pub const ALL: [Self; 3] = [Self::LIGHT, Self::STANDARD, Self::FIRM];
}

/// Device and hand.
#[derive(Clone, Debug)]
pub struct Mechanism {
    grip: Grip,
    resolution_m: f64,
    position_m: DVec3,
    velocity_m_s: DVec3,
    /// Forces on their way to the motors, one a step of the mechanics.
    coming_n: VecDeque<DVec3>,
    acting_n: DVec3,
}

impl Mechanism {
    /// A device at rest, which reports places in steps of `resolution_m` (0: exactly) and gives forces `delay_s` late.
    #[must_use]
    pub fn at_rest(grip: Grip, at_m: Vec3, resolution_m: f64, delay_s: f64) -> Self {
        let late = (delay_s / STEP_S).round() as usize;
        Self {
            grip,
            resolution_m,
            position_m: at_m.as_dvec3(),
            velocity_m_s: DVec3::ZERO,
            coming_n: VecDeque::from(vec![DVec3::ZERO; late]),
            acting_n: DVec3::ZERO,
        }
    }

    /// What the device reports, m.
    #[must_use]
    pub fn reported_m(&self) -> Vec3 {
        if self.resolution_m == 0.0 {
            return self.position_m.as_vec3();
        }
        ((self.position_m / self.resolution_m).round() * self.resolution_m).as_vec3()
    }

    /// Where it is, m, and how fast, m/s.
    #[must_use]
    pub const fn motion(&self) -> (DVec3, DVec3) {
        (self.position_m, self.velocity_m_s)
    }

    /// Lets `dt_s` pass under a force that the loop has set, N, while the hand means to be at `meant_m`, and returns the work that
    /// the force did on the hand, J.
    ///
    /// `m·a = k·(x₀ − x) − b·v + F`, semi-implicit in steps of 0.1 ms, b taken at the end of the step.
    pub fn pass(&mut self, force_n: Vec3, meant_m: Vec3, dt_s: f64) -> f64 {
        let Grip { mass_kg, damping_ns_m, stiffness_n_m, .. } = self.grip;
        let mut work_j = 0.0;
        for _ in 0..(dt_s / STEP_S).round() as usize {
            self.coming_n.push_back(force_n.as_dvec3());
            self.acting_n = self.coming_n.pop_front().unwrap_or(DVec3::ZERO);
            let pull = (meant_m.as_dvec3() - self.position_m) * stiffness_n_m + self.acting_n;
            self.velocity_m_s =
                (self.velocity_m_s + pull * (STEP_S / mass_kg)) / (1.0 + damping_ns_m * STEP_S / mass_kg);
            let moved_m = self.velocity_m_s * STEP_S;
            self.position_m += moved_m;
            work_j += self.acting_n.dot(moved_m);
        }
        work_j
    }
}
