//! Devices by name, as people write them: `NAME` or `NAME:KEY=VALUE,…`; and which of them are there.
//!
//! Owns names, parameters and defaults; a device itself is its module's.
//! Invariant: whatever was parsed can be opened; a device that is not there opens as well and says why it waits.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::str::FromStr;
use std::sync::Arc;

use pottery_shared::haptics::{DeviceSpecs, PRESETS, SpecsError};
use pottery_shared::units::Seconds;

use super::{
    Axes, Calibration, Device, DrivenDevice, Driver, Fit, HandModel, Limits, Monitor, PointerDevice, Reported,
    ScriptedDevice, SimulatedDevice,
};
use crate::stroke::{Stroke, StrokeError};

/// A device that somebody chose, with its parameters.
///
/// ```
/// use pottery_client::device::DeviceChoice;
///
/// let choice: DeviceChoice = "simulated:stiffness=500,resolution_mm=0.02".parse()?;
/// assert_eq!(choice.name(), "simulated");
/// let refused = "simulated:colour=red".parse::<DeviceChoice>().unwrap_err().to_string();
/// assert!(refused.contains("colour") && refused.contains("stiffness"));
/// # Ok::<(), pottery_client::device::ChoiceError>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct DeviceChoice {
    kind: Kind,
    limits: Limits,
    /// As it was asked for, and as a person has fitted it before.
    scale: Option<f32>,
    fit: Option<Fit>,
}

#[derive(Clone, Debug, PartialEq)]
enum Kind {
    Mouse,
    #[cfg(feature = "gamepad")]
    Gamepad(usize),
    #[cfg(feature = "inverse3")]
    Inverse3(super::inverse3::Inverse3Settings),
    #[cfg(feature = "openhaptics")]
    OpenHaptics(super::openhaptics::OpenHapticsSettings),
    #[cfg(feature = "falcon")]
    Falcon(super::falcon::FalconSettings),
    Simulated(Simulated),
    Replay(Arc<Stroke>),
}

/// A simulated hand, its device and what it follows.
#[derive(Clone, Debug, PartialEq)]
struct Simulated {
    hand: HandModel,
    specs: DeviceSpecs,
    delay: Seconds,
    stroke: Option<Arc<Stroke>>,
}

/// Why a device cannot be chosen so.
#[derive(Debug, thiserror::Error)]
pub enum ChoiceError {
    /// Nobody knows the name; choose a known one.
    #[error("there is no device {name:?}: choose one of {}", NAMES.join(", "))]
    Unknown {
        /// What was asked for.
        name: String,
    },
    /// The program was built without it; build it with the feature.
    #[error("this program was built without {device}: build it with --features {device}")]
    NotBuilt {
        /// Which device, and the feature's name.
        device: &'static str,
    },
    /// A parameter has no value; write one.
    #[error("{part:?} is no parameter: write KEY=VALUE and commas between them")]
    Form {
        /// What stands there.
        part: String,
    },
    /// The device has no such parameter; use those it has.
    #[error("{device} has no parameter {key:?}: it knows {known}")]
    Parameter {
        /// Which device.
        device: String,
        /// The key that was given.
        key: String,
        /// Those that it has.
        known: String,
    },
    /// A value cannot be used; choose another.
    #[error("{key}={value} cannot be used: choose {allowed}")]
    Value {
        /// The parameter.
        key: String,
        /// What was given.
        value: String,
        /// What may be.
        allowed: String,
    },
    /// A parameter is missing; give it.
    #[error("{device} needs {key}={what}")]
    Missing {
        /// Which device.
        device: &'static str,
        /// The parameter.
        key: &'static str,
        /// What it stands for.
        what: &'static str,
    },
    /// The device cannot be of that kind; name another.
    #[error(transparent)]
    Specs(#[from] SpecsError),
    /// The stroke cannot be read.
    #[error(transparent)]
    Stroke(#[from] StrokeError),
}

/// Every device's name.
const NAMES: [&str; 7] = ["mouse", "gamepad", "inverse3", "openhaptics", "falcon", "simulated", "replay"];

/// Why there is no gamepad elsewhere.
#[cfg(all(feature = "gamepad", not(target_os = "linux")))]
const LINUX_ALONE: &str = "gamepads are read on Linux alone so far: hold the mouse, or a haptic device";

/// What was found, and how to choose another one of its kind: `others` are written after `--device`.
#[cfg(any(feature = "gamepad", feature = "inverse3", feature = "falcon"))]
pub(super) fn with_others(found: String, others: &[String]) -> String {
    match others.len() {
        0 => found,
        count => format!("{found} (of {}: another with --device {})", count + 1, others.join(" or ")),
    }
}

/// What stands behind a name, when it was looked for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Survey {
    /// The device's name.
    pub name: &'static str,
    /// What was found, or in a sentence why nothing.
    pub found: Result<String, String>,
}

/// How a person is told of the force.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feel {
    /// The device pushes the hand.
    Force,
    /// It hums with the force, and the drawn tool stays behind by force over stiffness.
    Hum,
    /// The drawn tool stays behind, and nothing else.
    Lag,
    /// Nobody holds it.
    Nobody,
}

/// A device in hand.
pub struct OpenedDevice {
    /// For the hand.
    pub device: Box<dyn Device>,
    /// For the window, if the device has a driver.
    pub monitor: Option<Arc<Monitor>>,
}

impl std::fmt::Debug for OpenedDevice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("OpenedDevice").field("monitor", &self.monitor).finish_non_exhaustive()
    }
}

/// Looks for every device.
#[must_use]
pub fn survey() -> Vec<Survey> {
    NAMES.into_iter().map(|name| Survey { name, found: look_for(name) }).collect()
}

fn look_for(name: &'static str) -> Result<String, String> {
    match name {
        "mouse" => Ok("the window's pointer, or a finger on its screen".into()),
        #[cfg(all(feature = "gamepad", target_os = "linux"))]
        "gamepad" => {
            super::gamepad::GamepadDriver::new(super::gamepad::SystemPads, 0).probe().map_err(|fault| fault.to_string())
        }
        #[cfg(all(feature = "gamepad", not(target_os = "linux")))]
        "gamepad" => Err(LINUX_ALONE.into()),
        #[cfg(feature = "inverse3")]
        "inverse3" => super::inverse3::Inverse3Driver::default().probe().map_err(|fault| fault.to_string()),
        #[cfg(feature = "openhaptics")]
        "openhaptics" => super::openhaptics::OpenHapticsDriver::default().probe().map_err(|fault| fault.to_string()),
        #[cfg(feature = "falcon")]
        "falcon" => {
            let settings = super::falcon::FalconSettings::default();
            let probed = super::falcon::FalconDriver::new(super::falcon::UsbBus, settings).probe();
            probed.map_err(|fault| fault.to_string())
        }
        "simulated" => Ok(format!(
            "a hand of mass, spring and damper that follows a stroke and is pushed back by a device: specs={}, delay=MS",
            PRESETS.map(|preset| preset.name).join("|")
        )),
        "replay" => Ok("a recorded stroke: replay:file=FILE".into()),
        _ => Err(ChoiceError::NotBuilt { device: name }.to_string()),
    }
}

impl Default for DeviceChoice {
    /// The mouse.
    fn default() -> Self {
        Self { kind: Kind::Mouse, limits: DeviceSpecs::MOUSE.into(), scale: None, fit: None }
    }
}

impl DeviceChoice {
    /// Its name.
    #[must_use]
    pub const fn name(&self) -> &'static str {
        match self.kind {
            Kind::Mouse => "mouse",
            #[cfg(feature = "gamepad")]
            Kind::Gamepad(_) => "gamepad",
            #[cfg(feature = "inverse3")]
            Kind::Inverse3(_) => "inverse3",
            #[cfg(feature = "openhaptics")]
            Kind::OpenHaptics(_) => "openhaptics",
            #[cfg(feature = "falcon")]
            Kind::Falcon(_) => "falcon",
            Kind::Simulated(_) => "simulated",
            Kind::Replay(_) => "replay",
        }
    }

    /// How a person is told of the force, once it is there.
    #[must_use]
    pub const fn feel(&self) -> Feel {
        match self.kind {
            Kind::Mouse => Feel::Lag,
            #[cfg(feature = "gamepad")]
            Kind::Gamepad(_) => Feel::Hum,
            Kind::Simulated(..) | Kind::Replay(_) => Feel::Nobody,
            #[cfg(any(feature = "inverse3", feature = "openhaptics", feature = "falcon"))]
            _ => Feel::Force,
        }
    }

    /// As a person has fitted it before, if it has a driver; a scale that was asked for stays.
    #[must_use]
    pub fn fitted(self, fit: Option<Fit>) -> Self {
        Self { fit, ..self }
    }

    /// Takes the device in hand: `pointer` is the mouse, and brings the tool to the others; `stroke` is what a simulated
    /// hand follows when it was given none.
    ///
    /// # Errors
    /// What the system says when it has no thread for a driver. A device that is not there is no error: it is waited for.
    pub fn open(&self, pointer: PointerDevice, stroke: &Arc<Stroke>) -> std::io::Result<OpenedDevice> {
        let plain = |device: Box<dyn Device>| Ok(OpenedDevice { device, monitor: None });
        match &self.kind {
            Kind::Mouse => plain(Box::new(pointer)),
            Kind::Simulated(Simulated { hand, specs, delay, stroke: own }) => {
                let stroke = Arc::clone(own.as_ref().unwrap_or(stroke));
                plain(Box::new(SimulatedDevice::new(stroke, *hand).on(*specs, *delay)))
            }
            Kind::Replay(stroke) => plain(Box::new(ScriptedDevice::new(Arc::clone(stroke)))),
            #[cfg(all(feature = "gamepad", target_os = "linux"))]
            Kind::Gamepad(number) => {
                let driver = super::gamepad::GamepadDriver::new(super::gamepad::SystemPads, *number);
                self.drive(driver, Axes::YUp, super::gamepad::MIDDLE_M, pointer)
            }
            #[cfg(all(feature = "gamepad", not(target_os = "linux")))]
            Kind::Gamepad(_) => Err(std::io::Error::other(LINUX_ALONE)),
            #[cfg(feature = "inverse3")]
            Kind::Inverse3(settings) => {
                let driver = super::inverse3::Inverse3Driver::new(settings.clone());
                self.drive(driver, Axes::ZUp, super::inverse3::MIDDLE_M, pointer)
            }
            #[cfg(feature = "openhaptics")]
            Kind::OpenHaptics(settings) => {
                let driver = super::openhaptics::OpenHapticsDriver::new(settings.clone());
                self.drive(driver, Axes::YUp, super::openhaptics::MIDDLE_M, pointer)
            }
            #[cfg(feature = "falcon")]
            Kind::Falcon(settings) => {
                let driver = super::falcon::FalconDriver::new(super::falcon::UsbBus, settings.clone());
                self.drive(driver, Axes::YUp, super::falcon::MIDDLE_M.as_vec3(), pointer)
            }
        }
    }

    #[cfg_attr(
        not(any(feature = "gamepad", feature = "inverse3", feature = "openhaptics", feature = "falcon")),
        expect(dead_code, reason = "no device with a driver was built in")
    )]
    fn drive(
        &self,
        driver: impl Driver,
        axes: Axes,
        middle_m: glam::Vec3,
        pointer: PointerDevice,
    ) -> std::io::Result<OpenedDevice> {
        let usual = Calibration::new(axes, middle_m);
        let fitted = self.fit.map_or(usual, |fit| usual.fitted(fit));
        let calibration = self.scale.map_or(Ok(fitted), |scale| fitted.scaled(scale)).map_err(std::io::Error::other)?;
        let device = DrivenDevice::open(driver, calibration, self.limits, pointer)?;
        let monitor = Some(device.monitor());
        Ok(OpenedDevice { device: Box::new(device), monitor })
    }
}

/// Parameters that were given and not yet asked for.
struct Parameters {
    device: String,
    given: BTreeMap<String, String>,
    asked: Vec<&'static str>,
}

impl Parameters {
    fn text(&mut self, key: &'static str) -> Option<String> {
        self.asked.push(key);
        self.given.remove(key)
    }

    fn number(&mut self, key: &'static str, least: f32, most: f32) -> Result<Option<f32>, ChoiceError> {
        let Some(value) = self.text(key) else { return Ok(None) };
        match value.parse::<f32>() {
            Ok(number) if (least..=most).contains(&number) => Ok(Some(number)),
            _ => {
                Err(ChoiceError::Value { key: key.into(), value, allowed: format!("a number from {least} to {most}") })
            }
        }
    }

    /// Which one of several, from 0.
    #[cfg(any(feature = "gamepad", feature = "falcon"))]
    fn count(&mut self, key: &'static str) -> Result<usize, ChoiceError> {
        let Some(value) = self.text(key) else { return Ok(0) };
        let allowed = "a whole number from 0".to_owned();
        value.parse().map_err(|_| ChoiceError::Value { key: key.into(), value, allowed })
    }

    #[cfg(any(feature = "openhaptics", feature = "falcon"))]
    fn file(&mut self, key: &'static str) -> Option<PathBuf> {
        self.text(key).map(PathBuf::from)
    }

    fn stroke(&mut self, key: &'static str) -> Result<Option<Arc<Stroke>>, ChoiceError> {
        let Some(file) = self.text(key).map(PathBuf::from) else { return Ok(None) };
        Ok(Some(Arc::new(Stroke::read(file)?)))
    }

    /// A preset's limits by name, or the usual ones.
    fn limits(&mut self, usual: &'static str) -> Result<Limits, ChoiceError> {
        let named = self.text("specs");
        let is_named = named.is_some();
        let name = named.unwrap_or_else(|| usual.to_owned());
        let limits = DeviceSpecs::preset(&name).map(|preset| Limits::from(preset.specs));
        limits.map(|limits| if is_named { limits.named() } else { limits }).ok_or_else(|| ChoiceError::Value {
            key: "specs".into(),
            value: name,
            allowed: format!("one of {}", PRESETS.map(|preset| preset.name).join(", ")),
        })
    }

    /// Complains about what nobody asked for.
    fn end(self) -> Result<(), ChoiceError> {
        let Self { device, given, asked } = self;
        match given.into_keys().next() {
            None => Ok(()),
            Some(key) => {
                let known = if asked.is_empty() { "none".into() } else { asked.join(", ") };
                Err(ChoiceError::Parameter { device, key, known })
            }
        }
    }
}

impl FromStr for DeviceChoice {
    type Err = ChoiceError;

    fn from_str(text: &str) -> Result<Self, ChoiceError> {
        let (name, rest) = text.split_once(':').unwrap_or((text, ""));
        let mut given = BTreeMap::new();
        for part in rest.split(',').filter(|part| !part.is_empty()) {
            let (key, value) = part.split_once('=').ok_or_else(|| ChoiceError::Form { part: part.to_owned() })?;
            given.insert(key.trim().to_owned(), value.trim().to_owned());
        }
        let mut parameters = Parameters { device: name.to_owned(), given, asked: Vec::new() };
        let choice = Self::from_parameters(name, &mut parameters)?;
        parameters.end()?;
        Ok(choice)
    }
}

impl DeviceChoice {
    fn from_parameters(name: &str, given: &mut Parameters) -> Result<Self, ChoiceError> {
        let (kind, usual) = match name {
            "mouse" => return Ok(Self::default()),
            "replay" => {
                let stroke = given.stroke("file")?.ok_or(ChoiceError::Missing {
                    device: "replay",
                    key: "file",
                    what: "FILE",
                })?;
                return Ok(Self { kind: Kind::Replay(stroke), ..Self::default() });
            }
            "simulated" => return Ok(Self { kind: simulated(given)?, ..Self::default() }),
            "gamepad" => (gamepad(given)?, "mouse"),
            "inverse3" => (inverse3(given)?, "touch"),
            "openhaptics" => (openhaptics(given)?, "touch"),
            "falcon" => (falcon(given)?, "falcon"),
            _ => return Err(ChoiceError::Unknown { name: name.to_owned() }),
        };
        let limits = given.limits(usual)?;
        let limits = limits.at_most([given.number("peak", 0.01, 100.0)?, given.number("stiffness", 1.0, 1e5)?]);
        let scale = given.number("scale", Calibration::SCALE_MIN, Calibration::SCALE_MAX)?;
        Ok(Self { kind, limits, scale, fit: None })
    }
}

fn simulated(given: &mut Parameters) -> Result<Kind, ChoiceError> {
    let usual = HandModel::default();
    let limits = given.limits("omni")?.at_most([given.number("peak", 0.01, 100.0)?, None]);
    let specs = limits.of(Reported::default())?;
    let delay_ms = given.number("delay", 0.0, SimulatedDevice::DELAY_MAX.0 * 1e3)?.unwrap_or(0.0);
    let hand = HandModel {
        mass_kg: given.number("mass", 0.01, 10.0)?.unwrap_or(usual.mass_kg),
        damping_n_s_per_m: given.number("damping", 0.0, 100.0)?.unwrap_or(usual.damping_n_s_per_m),
        stiffness_n_per_m: given.number("stiffness", 1.0, 5000.0)?.unwrap_or(usual.stiffness_n_per_m),
        resolution_m: given.number("resolution_mm", 0.001, 1.0)?.map_or(specs.resolution_m, |mm| mm * 1e-3),
    };
    let stroke = given.stroke("file")?;
    Ok(Kind::Simulated(Simulated { hand, specs, delay: Seconds(delay_ms * 1e-3), stroke }))
}

#[cfg(feature = "gamepad")]
fn gamepad(given: &mut Parameters) -> Result<Kind, ChoiceError> {
    Ok(Kind::Gamepad(given.count("number")?))
}

#[cfg(not(feature = "gamepad"))]
fn gamepad(_: &mut Parameters) -> Result<Kind, ChoiceError> {
    Err(ChoiceError::NotBuilt { device: "gamepad" })
}

#[cfg(feature = "inverse3")]
fn inverse3(given: &mut Parameters) -> Result<Kind, ChoiceError> {
    let mut settings = super::inverse3::Inverse3Settings { device_id: given.text("id"), ..Default::default() };
    if let Some(address) = given.text("address") {
        settings.address = address;
    }
    Ok(Kind::Inverse3(settings))
}

#[cfg(not(feature = "inverse3"))]
fn inverse3(_: &mut Parameters) -> Result<Kind, ChoiceError> {
    Err(ChoiceError::NotBuilt { device: "inverse3" })
}

#[cfg(feature = "openhaptics")]
fn openhaptics(given: &mut Parameters) -> Result<Kind, ChoiceError> {
    let (name, library) = (given.text("name"), given.file("lib"));
    Ok(Kind::OpenHaptics(super::openhaptics::OpenHapticsSettings { name, library }))
}

#[cfg(not(feature = "openhaptics"))]
fn openhaptics(_: &mut Parameters) -> Result<Kind, ChoiceError> {
    Err(ChoiceError::NotBuilt { device: "openhaptics" })
}

#[cfg(feature = "falcon")]
fn falcon(given: &mut Parameters) -> Result<Kind, ChoiceError> {
    let (number, firmware) = (given.count("number")?, given.file("firmware"));
    Ok(Kind::Falcon(super::falcon::FalconSettings { number, firmware }))
}

#[cfg(not(feature = "falcon"))]
fn falcon(_: &mut Parameters) -> Result<Kind, ChoiceError> {
    Err(ChoiceError::NotBuilt { device: "falcon" })
}
