//! The account of energy from which a teacher's guidance is paid.
//!
//! Owns what is in it; what is paid with it is `guidance`'s.
//! Invariant: it never holds more than [`Tank::MOST_J`], and who asks for its share is told 0 once it is empty.

use crate::units::Seconds;

/// An energy tank (Franken, Stramigioli, Misra, Secchi and Macchelli 2011; Duindam and Stramigioli 2004), which keeps passive what
/// is felt of somebody far away, whatever the network between does.
///
/// Into it goes what the teacher's hand gives: while she leads she moves against a damper of b = 4 N·s/m, of which her device lets
/// her feel as much as it renders, and of her way only what was heard of counts: `b·Δx²/Δt` for every two places, which is no more
/// than `∫b·v²·dt` of any way between them, whatever was lost. Out of it goes all work that guidance does on the student's hand; what
/// the student does against guidance goes in. It begins empty: a hand is fetched with what the teacher has given on her way there.
///
/// So `work done on the student ≤ work that the teacher has done`, however late anything comes: teacher's device, network and student's
/// device together are a passive two-port, `∫(F_T·v_T − F_S·v_S)·dt ≥ 0` from the beginning on, which is what a passivity observer of
/// teleoperation counts (Ryu, Kwon and Hannaford 2004; over delays Artigas, Ryu and Preusche 2010).
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Tank {
    stored_j: f32,
}

impl Tank {
    /// Damper against which the teacher moves, N·s/m.
    pub(super) const LEADING_NS_M: f32 = 4.0;
    /// More than this is not kept, J: what is paid in today is not for pushing tomorrow.
    const MOST_J: f32 = 0.06;
    /// Below this, guidance fades with what is left, J: what may be on its way to a device that is 5 ms late.
    const LOW_J: f32 = 0.004;
    /// A teacher's tool that went faster was taken elsewhere, and nothing is paid for that, m/s.
    const SPEED_MAX_M_S: f32 = 0.4;

    /// Takes in that the teacher's tool went so far in such a time.
    pub(super) fn pay_in(&mut self, way_m: f32, time: Seconds) {
        if time.0 > 0.0 && way_m <= Self::SPEED_MAX_M_S * time.0 {
            self.add(Self::LEADING_NS_M * way_m * way_m / time.0);
        }
    }

    /// Takes in energy; a negative one is taken out.
    pub(super) fn add(&mut self, energy_j: f32) {
        self.stored_j = (self.stored_j + energy_j).min(Self::MOST_J);
    }

    /// Share of what is wanted that can be paid for, 0 to 1.
    pub(super) fn share(&self) -> f32 {
        (self.stored_j / Self::LOW_J).clamp(0.0, 1.0)
    }

    /// What is in it, J; below zero by what was on its way to the device when it ran empty.
    pub(super) const fn stored_j(&self) -> f32 {
        self.stored_j
    }
}
