//! The Novint Falcon, over USB and without its maker's driver.
//!
//! Owns the order of things: firmware, homing, then an exchange a millisecond. Verified against a scripted Falcon in the
//! tests, which keeps the protocol as libnifalcon's public source has it; not yet tried on hardware.
//! Invariant: no motor is given a voltage before all three legs know their zero, nor after anything has gone wrong.

mod boot;
mod bus;
mod kinematics;
mod packet;
mod usb;

use std::path::PathBuf;
use std::time::{Duration, Instant};

use glam::{DVec3, Vec3};
use pottery_shared::units::Seconds;

use super::choice::with_others;
use super::{DeviceFault, Driver, Pace, Port, ROUND, Reading, Reported, SILENCE};
pub use boot::FIRMWARE_BYTES_MAX;
pub use bus::UsbBus;
pub use kinematics::{MIDDLE_M, angle_rad, angles_rad, counts_at, place_m, torques_nm};
pub use packet::{Answer, Light, MOTOR_MAX, Order, PACKET_BYTES, Packets};
pub use usb::{Bus, FALCON, Usb, UsbFault};

const DEVICE: &str = "Novint Falcon";
/// A motor's number for a newton metre at its leg (libnifalcon's `getForces`), and the way it turns.
const MOTOR_PER_NM: f64 = -10_000.0;
/// Bytes without a packet among them after which it is no Falcon that answers.
const NOISE_BYTES_MAX: usize = 256;
/// How long running firmware may take to answer a first packet.
const FIRST_ANSWER: Duration = Duration::from_millis(200);

/// Which Falcon, and the firmware for one that has none.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct FalconSettings {
    /// Which, if there are several, from 0.
    pub number: usize,
    /// The user's own firmware file.
    pub firmware: Option<PathBuf>,
}

/// The driver.
#[derive(Debug)]
pub struct FalconDriver<B> {
    bus: B,
    settings: FalconSettings,
}

fn gone(fault: UsbFault) -> DeviceFault {
    DeviceFault::Gone { device: DEVICE, reason: fault.to_string() }
}

impl<B: Bus> FalconDriver<B> {
    /// A driver for a Falcon on `bus`.
    #[must_use]
    pub const fn new(bus: B, settings: FalconSettings) -> Self {
        Self { bus, settings }
    }

    /// Which Falcon would be used, and how to choose another.
    ///
    /// # Errors
    /// [`DeviceFault`] when there is none, or not this many.
    pub fn probe(&mut self) -> Result<String, DeviceFault> {
        let (count, own) = (self.count()?, self.settings.number);
        let others: Vec<_> =
            (0..count).filter(|number| *number != own).map(|number| format!("falcon:number={number}")).collect();
        let found = if count > 1 { format!("{DEVICE} {own}") } else { DEVICE.to_owned() };
        Ok(with_others(found, &others))
    }

    /// How many are there, of which this is one.
    fn count(&mut self) -> Result<usize, DeviceFault> {
        let number = self.settings.number;
        match self.bus.count()? {
            0 => Err(DeviceFault::NotFound {
                device: DEVICE,
                reason: format!("nothing on USB is {:04x}:{:04x}", FALCON.0, FALCON.1),
                remedy: "plug in its cable and its power".into(),
            }),
            count if number >= count => Err(DeviceFault::NotFound {
                device: DEVICE,
                reason: format!("there is no number {number} among {count}, counted from 0"),
                remedy: "plug it in, or choose another: --device falcon:number=0".into(),
            }),
            count => Ok(count),
        }
    }

    fn firmware(&self) -> Result<Vec<u8>, DeviceFault> {
        let unusable =
            |reason: String, remedy: &str| DeviceFault::Unusable { device: DEVICE, reason, remedy: remedy.into() };
        let Some(path) = &self.settings.firmware else {
            let remedy = "give the file that came with its driver: --device falcon:firmware=FILE";
            return Err(unusable("it does not answer, and may have lost its firmware with its power".into(), remedy));
        };
        let remedy = "give the firmware file that came with its driver";
        let firmware = std::fs::read(path)
            .map_err(|error| unusable(format!("{} cannot be read: {error}", path.display()), remedy))?;
        if firmware.is_empty() || firmware.len() > FIRMWARE_BYTES_MAX {
            let reason = format!("{} has {} bytes and is no firmware", path.display(), firmware.len());
            return Err(unusable(reason, remedy));
        }
        Ok(firmware)
    }
}

impl<B: Bus> Driver for FalconDriver<B> {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        let count = self.count()?;
        let mut link = Link::new(self.bus.open(self.settings.number)?);
        boot::set_normal(link.usb.as_mut()).map_err(gone)?;
        let rest = Order { motors: [0; 3], light: Light::Red, homing: true };
        match link.exchange(rest, FIRST_ANSWER) {
            Ok(_) => {}
            Err(fault @ DeviceFault::Protocol { .. }) if self.settings.firmware.is_none() => return Err(fault),
            Err(_) => {
                let firmware = self.firmware()?;
                boot::load(link.usb.as_mut(), &firmware)?;
                link.packets.clear();
                link.exchange(rest, FIRST_ANSWER)?;
            }
        }
        let which = if count > 1 { format!("{DEVICE} {} of {count}", self.settings.number) } else { DEVICE.to_owned() };
        port.found(which, Reported::default());
        let served = link.serve(port);
        // the last word to a Falcon that still listens
        if let Err(fault) = link.usb.write(&Order { light: Light::Blue, homing: false, ..rest }.bytes()) {
            tracing::debug!(%fault, "the Falcon did not hear the end");
        }
        served
    }

    /// The answer to an order lies in the chip's buffer for a millisecond, its shortest latency.
    fn delay(&self) -> Seconds {
        Seconds(ROUND.0 + 1e-3)
    }
}

/// An opened Falcon with its firmware running.
#[derive(Debug)]
struct Link {
    usb: Box<dyn Usb>,
    packets: Packets,
    noise_bytes: usize,
    grip_m: DVec3,
}

impl Link {
    fn new(usb: Box<dyn Usb>) -> Self {
        Self { usb, packets: Packets::default(), noise_bytes: 0, grip_m: MIDDLE_M }
    }

    /// Sends an order and waits for an answer; of several that have come, the newest counts.
    fn exchange(&mut self, order: Order, patience: Duration) -> Result<Answer, DeviceFault> {
        self.usb.write(&order.bytes()).map_err(gone)?;
        let begin = Instant::now();
        let mut packet = [0; 64];
        loop {
            let left = patience.saturating_sub(begin.elapsed());
            if left.is_zero() {
                return Err(self.unanswered(patience));
            }
            let read = self.usb.read(&mut packet, left).map_err(gone)?;
            self.packets.take(packet.get(2..read).unwrap_or_default());
            let mut newest = None;
            while let Some(next) = self.packets.poll() {
                match next {
                    Ok(answer) => (newest, self.noise_bytes) = (Some(answer), 0),
                    Err(bytes) => self.noise_bytes += bytes,
                }
            }
            if self.noise_bytes > NOISE_BYTES_MAX {
                return Err(self.unanswered(patience));
            }
            if let Some(answer) = newest {
                return Ok(answer);
            }
        }
    }

    /// What to say when no packet has come.
    fn unanswered(&self, patience: Duration) -> DeviceFault {
        match self.noise_bytes {
            0 => DeviceFault::Silent { device: DEVICE, ms: patience.as_millis() as u64 },
            bytes => DeviceFault::Protocol {
                device: DEVICE,
                expected: "packets of 16 bytes",
                found: format!("{bytes} bytes that are none"),
            },
        }
    }

    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        let mut pace = Pace::new();
        let mut is_homed = false;
        let mut said_to_home = false;
        while !port.is_closing() {
            let order = if is_homed {
                Order { motors: motors(self.grip_m, port.force_n()), light: Light::Green, homing: false }
            } else {
                Order { motors: [0; 3], light: Light::Red, homing: true }
            };
            let answer = self.exchange(order, SILENCE)?;
            is_homed = answer.is_homed;
            if is_homed {
                let angles = answer.encoders.map(angle_rad);
                self.grip_m = place_m(angles, self.grip_m).ok_or_else(|| DeviceFault::Protocol {
                    device: DEVICE,
                    expected: "encoders in its reach",
                    found: format!("{:?} counts", answer.encoders),
                })?;
                port.publish(Reading {
                    position_m: self.grip_m.as_vec3(),
                    velocity_m_s: None,
                    buttons: u32::from(answer.buttons),
                });
            } else {
                port.withdraw();
            }
            if said_to_home == is_homed {
                said_to_home = !is_homed;
                port.notify(said_to_home.then(|| HOME_IT.to_owned()));
            }
            pace.wait();
        }
        Ok(())
    }
}

/// What a person has to do to a Falcon that was just switched on.
const HOME_IT: &str = "the Falcon does not know its zero yet: pull its grip out all the way and push it in";

/// The motors' numbers for a force at the grip, N; too much is given less of, in the same direction.
fn motors(grip_m: DVec3, force_n: Vec3) -> [i16; 3] {
    let Some(torques_nm) = torques_nm(grip_m, force_n.as_dvec3()) else { return [0; 3] };
    let wanted = DVec3::from_array(torques_nm) * MOTOR_PER_NM;
    let most = wanted.abs().max_element();
    let share = if most > f64::from(MOTOR_MAX) { f64::from(MOTOR_MAX) / most } else { 1.0 };
    (wanted * share).to_array().map(|number| number.round() as i16)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn too_much_force_keeps_its_direction() {
        let (weak, strong) =
            (motors(MIDDLE_M, Vec3::new(0.1, 0.2, -0.1)), motors(MIDDLE_M, Vec3::new(10.0, 20.0, -10.0)));
        let (weak, strong) = (weak.map(f64::from), strong.map(f64::from));
        assert!(strong.iter().any(|number| number.abs() == f64::from(MOTOR_MAX)), "{strong:?}");
        let cosine = DVec3::from_array(weak).normalize().dot(DVec3::from_array(strong).normalize());
        // weak numbers are rounded to whole ones, of some hundred
        assert!(cosine > 0.9999, "{weak:?} and {strong:?}");
    }
}
