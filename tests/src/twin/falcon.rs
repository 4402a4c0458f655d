//! A scripted Falcon: boot loader, firmware, homing and packets behind the driver's USB trait.
//!
//! Written from libnifalcon's public source, as the driver is, but from the device's side.
//! Invariant: its motors hold what the last packet said, and nothing before its firmware runs.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use glam::{DVec3, Vec3};
use pottery_client::device::DeviceFault;
use pottery_client::device::falcon::{Bus, MIDDLE_M, Usb, UsbFault, angles_rad, counts_at};

/// What the Falcon does wrong.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Trouble {
    /// Nothing.
    #[default]
    None,
    /// It answers nothing at all.
    Silent,
    /// It answers with other letters.
    Noise,
    /// It reports encoders that no leg can have.
    Impossible,
    /// It changes one byte of the firmware's echo.
    WrongEcho,
    /// It answers so many milliseconds late.
    Late(u64),
}

/// What a Falcon is, behind its cable.
#[derive(Debug)]
pub struct State {
    /// Whether it is on the bus.
    pub plugged: bool,
    /// What it does wrong.
    pub trouble: Trouble,
    /// Firmware that it runs with.
    pub firmware: Vec<u8>,
    /// Whether that is loaded.
    pub runs: bool,
    /// Packets with the order to home that it still needs.
    pub homes_after: u32,
    /// Where its grip is, m.
    pub grip_m: DVec3,
    /// Buttons that are down.
    pub buttons: u8,
    /// What the motors were told last.
    pub motors: [i16; 3],
    /// The lights that were on last, and whether it was told to home.
    pub flags: u8,
    /// Largest number that a motor was given before it was homed.
    pub unhomed_motor_max: i16,
    /// Requests to the line, number and value.
    pub requests: Vec<(u8, u16)>,
    loaded: Vec<u8>,
    takes_firmware: bool,
    received: Vec<u8>,
    sends: VecDeque<u8>,
    opened: u32,
}

/// A Falcon that a test holds in its hand; clones are the same one.
#[derive(Clone, Debug)]
pub struct FalconTwin {
    state: Arc<Mutex<State>>,
}

impl Default for FalconTwin {
    /// Firmware loaded and homed.
    fn default() -> Self {
        let state = State {
            plugged: true,
            trouble: Trouble::None,
            firmware: Vec::new(),
            runs: true,
            homes_after: 0,
            grip_m: MIDDLE_M,
            buttons: 0,
            motors: [0; 3],
            flags: 0,
            unhomed_motor_max: 0,
            requests: Vec::new(),
            loaded: Vec::new(),
            takes_firmware: false,
            received: Vec::new(),
            sends: VecDeque::new(),
            opened: 0,
        };
        Self { state: Arc::new(Mutex::new(state)) }
    }
}

impl FalconTwin {
    /// Looks at it, or changes it.
    pub fn with<T>(&self, look: impl FnOnce(&mut State) -> T) -> T {
        look(&mut self.state.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Moves the grip, m in the device's frame.
    pub fn hold_at(&self, grip_m: Vec3) {
        self.with(|state| state.grip_m = grip_m.as_dvec3());
    }

    /// What the motors were told last.
    #[must_use]
    pub fn motors(&self) -> [i16; 3] {
        self.with(|state| state.motors)
    }

    /// Pulls the cable: what it runs is lost with its power, the motors stand still.
    pub fn unplug(&self) {
        self.with(|state| {
            state.plugged = false;
            state.motors = [0; 3];
        });
    }

    /// Puts the cable back.
    pub fn plug(&self) {
        self.with(|state| state.plugged = true);
    }
}

impl State {
    /// Takes a byte as the line is set: boot loader or firmware.
    fn take(&mut self, byte: u8) {
        let divisor = self.requests.iter().rev().find(|(number, _)| *number == 3).map(|(_, value)| *value);
        match divisor {
            Some(0x4138) => {
                self.received.push(byte);
                if self.received.ends_with(&[0x0a, 0x43, 0x0d]) {
                    self.received.clear();
                    self.runs = false;
                    self.loaded.clear();
                    self.sends.extend([0x0a, 0x44, 0x2c, 0x0d]);
                }
            }
            Some(0x15) if !self.takes_firmware => {
                self.takes_firmware = byte == 0x41;
                self.sends.push_back(byte);
            }
            Some(0x15) => {
                self.loaded.push(byte);
                let is_wrong = self.trouble == Trouble::WrongEcho && self.loaded.len() == 100;
                self.sends.push_back(if is_wrong { !byte } else { byte });
                self.runs = self.loaded == self.firmware;
            }
            _ if self.runs => {
                self.received.push(byte);
                if byte == b'>' {
                    let received = std::mem::take(&mut self.received);
                    self.obey(&received);
                }
            }
            _ => {}
        }
    }

    /// Does what a packet says and answers it.
    fn obey(&mut self, packet: &[u8]) {
        if packet.len() != 16 || packet[0] != b'<' {
            return;
        }
        let nibble = |at: usize| u16::from(packet[at].wrapping_sub(b'A') & 0xf);
        let number = |at: usize| (0..4).map(|n| nibble(at + n) << (4 * n)).sum::<u16>() as i16;
        self.motors = [number(1), number(5), number(9)];
        self.flags = packet[13] - b'A';
        if self.flags & 1 == 1 {
            self.homes_after = self.homes_after.saturating_sub(1);
        }
        let is_homed = self.homes_after == 0;
        if !is_homed {
            let most = self.motors.iter().map(|motor| motor.saturating_abs()).max();
            self.unhomed_motor_max = self.unhomed_motor_max.max(most.unwrap_or_default());
        }
        match self.trouble {
            Trouble::Silent => {}
            Trouble::Noise => self.sends.extend(b"[QQQQRRRRSSSSTU]"),
            Trouble::Impossible => self.answer([i16::MAX; 3], is_homed),
            Trouble::None | Trouble::WrongEcho | Trouble::Late(_) => {
                let angles = angles_rad(self.grip_m).expect("the test holds the grip within reach");
                self.answer(angles.map(counts_at), is_homed);
            }
        }
    }

    fn answer(&mut self, encoders: [i16; 3], is_homed: bool) {
        self.sends.push_back(b'<');
        for encoder in encoders {
            self.sends.extend((0..4).map(|n| b'A' + ((encoder as u16 >> (4 * n)) & 0xf) as u8));
        }
        let homed = if is_homed { 0x70 } else { 0 };
        self.sends.extend([b'A' + (homed | self.buttons), b'A', b'>']);
    }
}

impl FalconTwin {
    fn connect(&self) -> Box<dyn Usb> {
        let connection = self.with(|state| {
            (state.takes_firmware, state.opened) = (false, state.opened + 1);
            state.received.clear();
            state.sends.clear();
            state.opened
        });
        Box::new(Cable { twin: self.clone(), connection })
    }
}

/// The Falcons on a bus, numbered as they are plugged in.
#[derive(Clone, Debug)]
pub struct FalconBus(Vec<FalconTwin>);

impl From<&FalconTwin> for FalconBus {
    fn from(only: &FalconTwin) -> Self {
        Self(vec![only.clone()])
    }
}

impl FalconBus {
    /// Several.
    #[must_use]
    pub fn of(falcons: &[FalconTwin]) -> Self {
        Self(falcons.to_vec())
    }

    fn plugged(&self) -> impl Iterator<Item = &FalconTwin> {
        self.0.iter().filter(|falcon| falcon.with(|state| state.plugged))
    }
}

impl Bus for FalconBus {
    fn count(&mut self) -> Result<usize, DeviceFault> {
        Ok(self.plugged().count())
    }

    fn open(&mut self, number: usize) -> Result<Box<dyn Usb>, DeviceFault> {
        let gone =
            || DeviceFault::Gone { device: "Falcon", reason: "the driver did not look how many there are".into() };
        Ok(self.plugged().nth(number).ok_or_else(gone)?.connect())
    }
}

/// One opening of it; a cable that was pulled stays dead.
#[derive(Debug)]
struct Cable {
    twin: FalconTwin,
    connection: u32,
}

impl Cable {
    fn state<T>(&self, look: impl FnOnce(&mut State) -> T) -> Result<T, UsbFault> {
        let connection = self.connection;
        self.twin.with(|state| (state.plugged && state.opened == connection).then(|| look(state)).ok_or(UsbFault::Gone))
    }
}

impl Usb for Cable {
    fn request(&mut self, number: u8, value: u16) -> Result<(), UsbFault> {
        self.state(|state| state.requests.push((number, value)))
    }

    fn write(&mut self, bytes: &[u8]) -> Result<(), UsbFault> {
        self.state(|state| bytes.iter().for_each(|byte| state.take(*byte)))
    }

    fn read(&mut self, into: &mut [u8; 64], patience: Duration) -> Result<usize, UsbFault> {
        let fetch = |state: &mut State| {
            let count = state.sends.len().min(62);
            state.sends.drain(..count).zip(&mut into[2..]).for_each(|(byte, to)| *to = byte);
            count
        };
        if let Trouble::Late(ms) = self.state(|state| state.trouble)? {
            let wait = Duration::from_millis(ms);
            std::thread::sleep(wait.min(patience));
            if wait > patience {
                return Ok(0);
            }
        }
        let count = self.state(fetch)?;
        // the two modem bytes, which come with every packet and without one when the latency timer ends
        into[..2].copy_from_slice(&[0x01, 0x60]);
        if count == 0 {
            std::thread::sleep(patience.min(Duration::from_millis(1)));
        }
        Ok(count + 2)
    }
}
