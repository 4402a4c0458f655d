//! What a device can render: what is known of its kind, what it says of itself, and what the person wants of it.
//!
//! Owns how the three go together; knows no driver.
//! Invariant: what comes out are figures that a device can have, with no more force or stiffness than the person wants.

use pottery_shared::haptics::{DeviceSpecs, SpecsError};

/// What a device says of itself, as far as it does.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Reported {
    /// Largest force, N.
    pub peak_force_n: Option<f32>,
    /// Largest force for as long as one likes, N.
    pub continuous_force_n: Option<f32>,
    /// Largest stiffness, N/m.
    pub stiffness_max_n_m: Option<f32>,
    /// Largest damping, N·s/m.
    pub damping_max_ns_m: Option<f32>,
    /// Radius of the sphere in which it moves freely, m.
    pub workspace_radius_m: Option<f32>,
}

impl Reported {
    /// What is known of the kind of device, with what this one says of itself in its place.
    #[must_use]
    pub fn over(self, kind: DeviceSpecs) -> DeviceSpecs {
        let peak_force_n = self.peak_force_n.unwrap_or(kind.peak_force_n);
        // a peak below what was known for the kind limits this too; what is no number stays none
        let below_peak = |force_n| if force_n > peak_force_n { peak_force_n } else { force_n };
        DeviceSpecs {
            peak_force_n,
            continuous_force_n: self.continuous_force_n.or(kind.continuous_force_n).map(below_peak),
            stiffness_max_n_m: self.stiffness_max_n_m.unwrap_or(kind.stiffness_max_n_m),
            damping_max_ns_m: self.damping_max_ns_m.unwrap_or(kind.damping_max_ns_m),
            workspace_radius_m: self.workspace_radius_m.unwrap_or(kind.workspace_radius_m),
            ..kind
        }
    }

    /// The figures that a device of a kind can have, each looked at by itself.
    fn sound(self, kind: DeviceSpecs) -> Self {
        let none = Self::default();
        let kept = |figure: Option<f32>, alone: Self| figure.filter(|_| alone.over(kind).checked().is_ok());
        Self {
            peak_force_n: kept(self.peak_force_n, Self { peak_force_n: self.peak_force_n, ..none }),
            continuous_force_n: kept(
                self.continuous_force_n,
                Self { continuous_force_n: self.continuous_force_n, ..none },
            ),
            stiffness_max_n_m: kept(self.stiffness_max_n_m, Self { stiffness_max_n_m: self.stiffness_max_n_m, ..none }),
            damping_max_ns_m: kept(self.damping_max_ns_m, Self { damping_max_ns_m: self.damping_max_ns_m, ..none }),
            workspace_radius_m: kept(
                self.workspace_radius_m,
                Self { workspace_radius_m: self.workspace_radius_m, ..none },
            ),
        }
    }
}

/// What is known of a device before it is there, and what the person wants of it; in the device's frame.
///
/// ```
/// use pottery_client::device::{Limits, Reported};
/// use pottery_shared::haptics::DeviceSpecs;
///
/// let dead = Reported { peak_force_n: Some(0.0), ..Reported::default() };
/// let omni = Limits::from(DeviceSpecs::OMNI);
/// assert!(omni.of(dead).is_err());
/// // who names the kind has its figure where the device's own makes no sense, and no other
/// let weak = Reported { stiffness_max_n_m: Some(200.0), ..dead };
/// let specs = omni.named().at_most([Some(1.0), None]).of(weak)?;
/// assert_eq!((specs.peak_force_n, specs.stiffness_max_n_m), (1.0, 200.0));
/// # Ok::<(), pottery_shared::haptics::SpecsError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Limits {
    kind: DeviceSpecs,
    is_named: bool,
    wanted: [Option<f32>; 2],
}

impl From<DeviceSpecs> for Limits {
    /// Those of a kind, as far as the device says nothing of itself.
    fn from(kind: DeviceSpecs) -> Self {
        Self { kind, is_named: false, wanted: [None; 2] }
    }
}

impl Limits {
    /// The person has said which kind it is: its figures stand in for those that the device reports and that make no sense.
    #[must_use]
    pub const fn named(self) -> Self {
        Self { is_named: true, ..self }
    }

    /// The person wants no more force or stiffness than this, N and N/m.
    #[must_use]
    pub const fn at_most(self, wanted: [Option<f32>; 2]) -> Self {
        Self { wanted, ..self }
    }

    /// What a device that reports this can render.
    ///
    /// # Errors
    /// [`SpecsError`] when the device reports what none can have: it is not to be used.
    pub fn of(&self, reported: Reported) -> Result<DeviceSpecs, SpecsError> {
        let reported = if self.is_named { reported.sound(self.kind) } else { reported };
        let mut specs = reported.over(self.kind).checked()?;
        let [peak_n, stiffness_n_m] = self.wanted.map(|most| most.unwrap_or(f32::INFINITY));
        specs.peak_force_n = specs.peak_force_n.min(peak_n);
        specs.stiffness_max_n_m = specs.stiffness_max_n_m.min(stiffness_n_m);
        specs.continuous_force_n = specs.continuous_force_n.map(|force_n| force_n.min(specs.peak_force_n));
        specs.checked()
    }
}
