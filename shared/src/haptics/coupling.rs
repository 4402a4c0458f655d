//! The spring and damper between device and proxy, and how stiff they may be.
//!
//! Owns the tuning from a device's specs.
//! Invariant: a tuned coupling keeps b > K·(T/2 + t_d) + |B| for the device in the lightest hand.

use super::DeviceSpecs;
use crate::units::Seconds;

/// A virtual coupling (Colgate, Stanley and Brown 1995): what the hand feels instead of the clay itself.
///
/// Clay under a fingertip is 48 N/mm stiff and would be rendered past what any sampled loop is stable at. Behind a coupling
/// the hand never feels more than the coupling's stiffness, however hard the clay is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coupling {
    /// Stiffness K, N/m.
    pub stiffness_n_m: f32,
    /// Damping B, N·s/m.
    pub damping_ns_m: f32,
}

impl Coupling {
    /// Damping that even a light hand adds to the device's own, N·s/m. Chosen: a quarter of the standard hand's 4.1.
    pub(super) const HAND_NS_M: f32 = 1.0;
    /// Share of the theoretical bound that is used.
    const SHARE: f32 = 0.8;

    /// The coupling for a device in a loop of period T with a delay t_d beyond it.
    ///
    /// `K = min(recommended, 0.8·b/(T/2 + t_d))` with b the device's own damping and that of a light hand, and
    /// `B = min(recommended, ½·(b − K·(T/2 + t_d)))`, so that `b > K·(T/2 + t_d) + |B|`: Colgate and Schenkel 1997, with the delay as in
    /// Hulin, Albu-Schäffer and Hirzinger 2014.
    #[must_use]
    pub fn tuned(specs: &DeviceSpecs, period: Seconds, delay: Seconds) -> Self {
        let b = specs.damping_ns_m + Self::HAND_NS_M;
        let stiffness_n_m = specs.stiffness_max_n_m.min(Self::SHARE * Self::stiffness_limit(b, period, delay));
        let left = b - stiffness_n_m * (0.5 * period.0 + delay.0);
        Self { stiffness_n_m, damping_ns_m: specs.damping_max_ns_m.min(0.5 * left) }
    }

    /// Largest stiffness, N/m, that is stable with a damping b, N·s/m: `K = b/(T/2 + t_d)`. Where b is what device, hand and the rendered damper have
    /// together, that is the bound of Hulin, Albu-Schäffer and Hirzinger; [`Coupling::tuned`] counts device and hand alone, and the damper against them, as
    /// Colgate and Schenkel do, who ask for passivity.
    ///
    /// ```
    /// use pottery_shared::haptics::Coupling;
    /// use pottery_shared::units::Seconds;
    /// let standard_hand = Coupling::stiffness_limit(4.1, Seconds(1e-3), Seconds(0.0));
    /// assert!((standard_hand - 8200.0).abs() < 1.0);
    /// ```
    #[must_use]
    pub fn stiffness_limit(damping_ns_m: f32, period: Seconds, delay: Seconds) -> f32 {
        damping_ns_m / (0.5 * period.0 + delay.0)
    }
}
