//! What a haptic device can render, and what is known of the devices people own.
//!
//! Owns the limits, their bounds and the table of presets; knows no driver.
//! Invariant: specs that were checked are finite, positive where zero would make no sense, and in order of size.

use crate::tool::Position;

/// What a device can render, and what it is as a mechanism.
///
/// Public fields, so that a driver fills in what its device reports; [`DeviceSpecs::checked`] says whether they make sense.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeviceSpecs {
    /// Largest force it gives for a short time, N.
    pub peak_force_n: f32,
    /// Largest force it gives for as long as one likes, N, if that is known.
    pub continuous_force_n: Option<f32>,
    /// Largest stiffness that its maker or a library recommends to render, N/m.
    pub stiffness_max_n_m: f32,
    /// Largest damping that is recommended to render, N·s/m.
    pub damping_max_ns_m: f32,
    /// Radius of the sphere in which it moves freely, m.
    pub workspace_radius_m: f32,
    /// Its own mass, as felt at the tip, kg.
    pub mass_kg: f32,
    /// Its own damping b, as felt at the tip without a hand on it, N·s/m.
    pub damping_ns_m: f32,
    /// Smallest step in which it reports its position, m; zero for one that is as good as exact.
    pub resolution_m: f32,
}

/// A device reports what it cannot be.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the device reports {field} = {value}, which makes no sense (allowed: {min} to {max})")]
pub struct SpecsError {
    /// Name of the quantity, with its unit.
    pub field: &'static str,
    /// What was reported.
    pub value: f32,
    /// Least allowed.
    pub min: f32,
    /// Largest allowed.
    pub max: f32,
}

/// Specs by name, and where they come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DevicePreset {
    /// Name, as people write it.
    pub name: &'static str,
    /// The specs.
    pub specs: DeviceSpecs,
    /// Where the figures come from.
    pub source: &'static str,
}

impl DeviceSpecs {
    /// A PHANToM Omni, on which the forces of the clay were chosen.
    pub const OMNI: Self = PRESETS[0].specs;
    /// A mouse, which gives no force: limits by which the drawn tool lags the pointer.
    pub const MOUSE: Self = PRESETS[7].specs;

    /// The same, if every figure is one that a device can have.
    ///
    /// # Errors
    /// [`SpecsError`] for the first that is not a number, zero where that means no device, or out of any device's range.
    pub fn checked(self) -> Result<Self, SpecsError> {
        let reach = Position::REACH.0;
        for (field, value, min, max) in [
            ("peak force (N)", self.peak_force_n, 0.01, 1000.0),
            ("continuous force (N)", self.continuous_force_n.unwrap_or(self.peak_force_n), 0.01, self.peak_force_n),
            ("stiffness (N/m)", self.stiffness_max_n_m, 1.0, 1e6),
            ("damping (N s/m)", self.damping_max_ns_m, 0.0, 1000.0),
            ("workspace radius (m)", self.workspace_radius_m, 1e-3, reach),
            ("mass (kg)", self.mass_kg, 1e-3, 100.0),
            ("own damping (N s/m)", self.damping_ns_m, 0.0, 1000.0),
            ("resolution (m)", self.resolution_m, 0.0, 0.01),
        ] {
            if !(min..=max).contains(&value) {
                return Err(SpecsError { field, value, min, max });
            }
        }
        Ok(self)
    }

    /// The preset of a name.
    ///
    /// ```
    /// use pottery_shared::haptics::DeviceSpecs;
    /// assert_eq!(DeviceSpecs::preset("touch").unwrap().specs.peak_force_n, 3.3);
    /// assert!(DeviceSpecs::preset("broom").is_none());
    /// ```
    #[must_use]
    pub fn preset(name: &str) -> Option<&'static DevicePreset> {
        PRESETS.iter().find(|preset| preset.name == name)
    }
}

impl Default for DeviceSpecs {
    /// A PHANToM Omni.
    fn default() -> Self {
        Self::OMNI
    }
}

/// Force, stiffness, damping and workspace that CHAI3D recommends, in N, N/m, N·s/m and m, then what the mechanism is.
const fn specs(recommended: [f32; 4], mass_kg: f32, damping_ns_m: f32, resolution_m: f32) -> DeviceSpecs {
    let [peak_force_n, stiffness_max_n_m, damping_max_ns_m, workspace_radius_m] = recommended;
    DeviceSpecs {
        peak_force_n,
        continuous_force_n: None,
        stiffness_max_n_m,
        damping_max_ns_m,
        workspace_radius_m,
        mass_kg,
        damping_ns_m,
        resolution_m,
    }
}

/// Every preset.
///
/// Peak force, recommended stiffness and damping and workspace are those that CHAI3D's drivers recommend, not the makers'
/// data sheets. Mass, own damping and resolution without a source of their own are assumptions to begin with: a driver
/// that can ask its device does.
pub const PRESETS: [DevicePreset; 8] = [
    DevicePreset {
        name: "omni",
        specs: DeviceSpecs { continuous_force_n: Some(0.88), ..specs([3.3, 700.0, 5.0, 0.100], 0.075, 0.3, 55e-6) },
        source: "limits: CHAI3D; 0.88 N and 0.055 mm: the maker's data sheet, not looked up again; mass, damping: assumed",
    },
    DevicePreset {
        name: "touch",
        specs: DeviceSpecs { continuous_force_n: Some(0.88), ..specs([3.3, 400.0, 4.0, 0.075], 0.075, 0.3, 55e-6) },
        source: "limits: CHAI3D; the rest as the Omni's, which it succeeded",
    },
    DevicePreset {
        name: "desktop",
        specs: specs([7.9, 1000.0, 5.0, 0.100], 0.075, 0.3, 55e-6),
        source: "limits: CHAI3D; the rest assumed to be the Omni's",
    },
    DevicePreset {
        name: "falcon",
        specs: specs([8.0, 3000.0, 20.0, 0.040], 0.15, 1.0, 63.5e-6),
        source: "limits: CHAI3D; resolution: 400 dots an inch, the maker's; mass, damping: assumed",
    },
    DevicePreset {
        name: "omega.3",
        specs: specs([12.0, 5000.0, 30.0, 0.075], 0.2, 1.0, 10e-6),
        source: "limits: CHAI3D; mass, damping, resolution: assumed",
    },
    DevicePreset {
        name: "delta.3",
        specs: specs([20.0, 5000.0, 30.0, 0.150], 0.25, 1.0, 20e-6),
        source: "limits: CHAI3D; mass, damping, resolution: assumed",
    },
    DevicePreset {
        name: "lambda.7",
        specs: specs([12.0, 8000.0, 30.0, 0.112], 0.25, 1.0, 10e-6),
        source: "limits: CHAI3D; mass, damping, resolution: assumed",
    },
    DevicePreset {
        name: "mouse",
        specs: specs([3.3, 700.0, 5.0, 0.300], 0.1, 4.0, 0.0),
        source: "no device: the limits of the Omni's, so that the drawn tool lags the pointer by millimetres",
    },
];
