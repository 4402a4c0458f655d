//! Gamepads as Linux shows them in `/dev/input`, in pure Rust: no libudev.
//!
//! Invariant: nothing here waits for a pad; one that is pulled out becomes a fault at the next look.

use std::io::ErrorKind;

use evdev::{AbsoluteAxisCode, FFEffect, FFEffectCode, FFEffectData, FFEffectKind, FFReplay, FFTrigger, KeyCode};
use glam::Vec2;

use super::{DEVICE, Pad, Pads, Sticks};
use crate::device::DeviceFault;

/// The pads of this machine.
#[derive(Clone, Copy, Debug, Default)]
pub struct SystemPads;

/// Buttons in the order of their bits.
const BUTTONS: [KeyCode; 4] = [KeyCode::BTN_SOUTH, KeyCode::BTN_EAST, KeyCode::BTN_NORTH, KeyCode::BTN_WEST];
/// How long a hum goes on by itself, ms.
const HUM_MS: u16 = 10_000;

fn pads() -> Vec<evdev::Device> {
    let is_pad = |device: &evdev::Device| {
        device.supported_keys().is_some_and(|keys| keys.contains(KeyCode::BTN_SOUTH))
            && device
                .supported_absolute_axes()
                .is_some_and(|axes| axes.contains(AbsoluteAxisCode::ABS_X) && axes.contains(AbsoluteAxisCode::ABS_Y))
    };
    let mut found: Vec<_> = evdev::enumerate().filter(|(_, device)| is_pad(device)).collect();
    found.sort_by(|(one, _), (other, _)| one.cmp(other));
    found.into_iter().map(|(_, device)| device).collect()
}

impl Pads for SystemPads {
    fn names(&mut self) -> Vec<String> {
        pads().iter().map(|pad| pad.name().unwrap_or("gamepad without a name").to_owned()).collect()
    }

    fn open(&mut self, number: usize) -> Result<Box<dyn Pad>, DeviceFault> {
        let device = pads().into_iter().nth(number).ok_or_else(|| gone("it is no longer there"))?;
        device.set_nonblocking(true).map_err(|error| gone(&error.to_string()))?;
        let motors = device.supported_ff().is_some_and(|effects| effects.contains(FFEffectCode::FF_RUMBLE));
        Ok(Box::new(Opened { device, has_motors: motors, hum: None }))
    }
}

fn gone(reason: &str) -> DeviceFault {
    DeviceFault::Gone { device: DEVICE, reason: reason.to_owned() }
}

#[derive(Debug)]
struct Opened {
    device: evdev::Device,
    has_motors: bool,
    hum: Option<FFEffect>,
}

impl Opened {
    /// An axis as a share of its range, −1 to 1, if the pad has it.
    fn axis(&self, code: AbsoluteAxisCode) -> Option<f32> {
        if !self.device.supported_absolute_axes().is_some_and(|axes| axes.contains(code)) {
            return None;
        }
        let axis = self.device.cached_state().abs_vals()?.get(usize::from(code.0))?;
        let (least, most) = (axis.minimum as f32, axis.maximum as f32);
        (most > least).then(|| (axis.value as f32 - least) / (most - least) * 2.0 - 1.0)
    }
}

impl Pad for Opened {
    fn sticks(&mut self) -> Result<Sticks, DeviceFault> {
        match self.device.fetch_events() {
            // what they say is in the device's state as well
            Ok(events) => events.for_each(drop),
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => return Err(gone(&error.to_string())),
        }
        let stick = |pad: &Self, x, y| Vec2::new(pad.axis(x).unwrap_or(0.0), -pad.axis(y).unwrap_or(0.0));
        let keys = self.device.cached_state().key_vals();
        let is_down = |key| keys.is_some_and(|keys| keys.contains(key));
        let pulled = self.axis(AbsoluteAxisCode::ABS_RZ).or_else(|| self.axis(AbsoluteAxisCode::ABS_GAS));
        Ok(Sticks {
            left: stick(self, AbsoluteAxisCode::ABS_X, AbsoluteAxisCode::ABS_Y),
            right: stick(self, AbsoluteAxisCode::ABS_RX, AbsoluteAxisCode::ABS_RY),
            trigger: pulled.map_or(f32::from(u8::from(is_down(KeyCode::BTN_TR2))), |pulled| (pulled + 1.0) / 2.0),
            buttons: (0..).zip(BUTTONS).map(|(bit, key)| u32::from(is_down(key)) << bit).sum(),
        })
    }

    fn has_motors(&self) -> bool {
        self.has_motors
    }

    fn hum(&mut self, heavy: f32, light: f32) -> Result<(), DeviceFault> {
        if !self.has_motors {
            return Ok(());
        }
        let strength = |share: f32| (share.clamp(0.0, 1.0) * f32::from(u16::MAX)) as u16;
        let data = FFEffectData {
            direction: 0,
            trigger: FFTrigger { button: 0, interval: 0 },
            replay: FFReplay { length: HUM_MS, delay: 0 },
            kind: FFEffectKind::Rumble { strong_magnitude: strength(heavy), weak_magnitude: strength(light) },
        };
        let told = match &mut self.hum {
            Some(hum) => hum.update(data).and_then(|()| hum.play(1)),
            None => self.device.upload_ff_effect(data).and_then(|mut hum| {
                let told = hum.play(1);
                self.hum = Some(hum);
                told
            }),
        };
        if let Err(error) = told {
            // a pad that may be read and not written to is still a pad
            tracing::debug!(%error, "the gamepad does not hum");
            self.has_motors = false;
        }
        Ok(())
    }
}
