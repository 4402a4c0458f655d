//! The proxy: what presses the clay in the device's stead.
//!
//! Owns its place and how it follows; knows the clay by its answers only.
//! Invariant: it is pulled into the clay by no more than the device's peak force, however far the device is.

use glam::Vec3;

use super::Coupling;
use super::drag::{Drag, Wet};
use crate::tool::Position;
use crate::units::Seconds;

/// What the clay answered to the press of a tick, in the room's frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Touch {
    /// Where the tool was pressed.
    pub centre: Position,
    /// Force of the clay on the tool, N, before scaling.
    pub force_n: Vec3,
    /// Largest penetration, m.
    pub penetration_m: f32,
    /// See [`Contact::held_n`](crate::clay::Contact::held_n).
    pub held_n: f32,
    /// The clay along which it slides; `None` where the method brings its own drag or there is none.
    pub wet: Option<Wet>,
}

/// A massless tool on the coupling.
///
/// Its balance, clay against coupling, is found by one Newton step a tick along the contact's normal,
/// `Δ = (s·F + K·(x_d − x))·n/(K + k)`, where k = 2·s·F/p is the slope of a contact whose area grows with its depth p and more than that of one
/// that saturates: an overestimate slows the step, an underestimate would throw the tool out of the clay. At an edge, where a contact
/// grows faster than that, k is what the last tick's place and force say. Across the
/// normal it slides as [`Drag`] lets it, and where clay holds it on all sides, as in a narrow opening, by `K/(K + k')` of that, with k' the slope
/// of that hold: else it is thrown from one side to the other tick by tick. Whatever the clay does under it, it gathers speed no faster than `v' = 50 m/s² + 300 v/s`, anew where it turns round, until
/// it is free and where the device is: without that it is thrown within a tick where a contact is lost or met at an edge, and the
/// hand is knocked.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Proxy {
    /// Where it is meant to be, and where it was pressed, to the step in which places travel.
    at_m: Option<Vec3>,
    pressed_m: Vec3,
    /// Force felt there, its direction when there was one last, and the contact's stiffness, all scaled.
    felt_n: Vec3,
    normal: Vec3,
    stiffness_n_m: f32,
    /// What opposes its going aside, scaled.
    across_n_m: f32,
    /// How fast it goes, m/s, and whether it is where the device is, with nothing between them.
    velocity_m_s: Vec3,
    joined: bool,
    drag: Drag,
    clay_velocity_m_s: Vec3,
}

impl Proxy {
    /// Least penetration that a stiffness is reckoned from, m: a tenth of the step in which places travel.
    const SHALLOW_M: f32 = 1e-6;
    /// Shorter ways say nothing of how fast a contact grows, m: of the order of a step of an encoder.
    const TOLD_M: f32 = 50e-6;
    /// How fast it gathers speed at rest, m/s², and by how many times its speed a second more.
    const GATHERS_M_S2: f32 = 50.0;
    const GATHERS_PER_S: f32 = 300.0;
    /// Share of the coupling's stiffness below which a contact is none; slip of water has ten times as much.
    const LEFT: f32 = 0.02;

    pub(super) const fn at_m(&self) -> Option<Vec3> {
        self.at_m
    }

    /// The direction in which the clay last pushed.
    pub(super) const fn normal(&self) -> Vec3 {
        self.normal
    }

    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Whether nothing holds it back: it touches nothing, and what is left of a contact that was lost is little.
    pub(super) fn is_free(&self, coupling: &Coupling) -> bool {
        self.at_m.is_none() || self.stiffness_n_m < Self::LEFT * coupling.stiffness_n_m
    }

    /// Follows a device for dt.
    pub(super) fn follow(&mut self, device_m: Vec3, coupling: &Coupling, peak_n: f32, dt: Seconds) -> Vec3 {
        let stiffness = coupling.stiffness_n_m;
        let free = self.is_free(coupling);
        let to_m = if free {
            device_m
        } else {
            let reach_m = (device_m - self.pressed_m).clamp_length_max(peak_n / stiffness);
            let into = (self.felt_n + reach_m * stiffness).dot(self.normal) / (stiffness + self.stiffness_n_m);
            let along = |vector: Vec3| vector - self.normal * vector.dot(self.normal);
            let carried_m = along(self.clay_velocity_m_s * dt.0);
            let slip_m = self.drag.slip_m(along(reach_m) - carried_m, stiffness, dt);
            self.pressed_m + self.normal * into + carried_m + slip_m * (stiffness / (stiffness + self.across_n_m))
        };
        let from_m = self.at_m.unwrap_or(to_m);
        // who turns round begins anew
        let speed_m_s = self.velocity_m_s.dot((to_m - from_m).normalize_or_zero()).max(0.0);
        let gathered_m = (speed_m_s + (Self::GATHERS_M_S2 + speed_m_s * Self::GATHERS_PER_S) * dt.0) * dt.0;
        let comes = free && self.joined || to_m.distance(from_m) <= gathered_m;
        let at_m = if comes { to_m } else { from_m + (to_m - from_m).clamp_length_max(gathered_m) };
        self.velocity_m_s = (at_m - from_m) / dt.0;
        self.joined = free && comes;
        self.at_m = Some(at_m);
        at_m
    }

    /// Takes the clay's answer.
    pub(super) fn meet(&mut self, touch: &Touch, felt_share: f32) {
        let step_m = Position::STEP.0;
        let (before_m, before_n) = (self.pressed_m, self.felt_n);
        self.pressed_m = touch.centre.point_m();
        // stopped on its way: there it is
        if self.at_m.is_none_or(|at_m| (at_m - self.pressed_m).abs().max_element() > 0.6 * step_m) {
            (self.at_m, self.velocity_m_s) = (Some(self.pressed_m), Vec3::ZERO);
        }
        self.felt_n = touch.force_n * felt_share;
        let force_n = self.felt_n.length();
        // half of the last at least, so that a contact that was grazed or lost for a tick does not let go at once
        self.stiffness_n_m *= 0.5;
        self.across_n_m *= 0.5;
        if force_n > 0.0 {
            self.normal = self.felt_n / force_n;
            let slope_n_m = |force_n: f32| 2.0 * force_n / touch.penetration_m.max(Self::SHALLOW_M);
            // on one side it grows, on the other it goes
            self.across_n_m = self.across_n_m.max(2.0 * slope_n_m(touch.held_n * felt_share));
            // at an edge it grows faster than with its depth, and what it was a tick ago says how fast
            let deeper_m = (before_m - self.pressed_m).dot(self.normal);
            let edge_n_m = if before_n != Vec3::ZERO && deeper_m.abs() > Self::TOLD_M {
                (self.felt_n - before_n).dot(self.normal) / deeper_m
            } else {
                0.0
            };
            self.stiffness_n_m = self.stiffness_n_m.max(slope_n_m(force_n)).max(edge_n_m);
        }
        let slides = touch.wet.filter(|_| force_n > 0.0);
        self.drag = slides.map_or_else(Drag::default, |wet| Drag::of(&wet, touch.force_n.length(), felt_share));
        self.clay_velocity_m_s = slides.map_or(Vec3::ZERO, |wet| wet.clay_velocity_m_s);
    }
}
