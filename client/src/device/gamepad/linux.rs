//! Gamepads as Linux shows them in `/dev/input`, in pure Rust: no libudev.
//!
//! Events say that something moved; what it came to is asked of the kernel, so that none can be missed. The crate's own copy of a pad's state
//! knows neither the ends of an axis nor where it is before it moves.
//! Invariant: nothing here waits for a pad; one that is pulled out becomes a fault at the next look.

use std::io::ErrorKind;
use std::path::Path;

use evdev::{
    AbsInfo, AbsoluteAxisCode, AttributeSet, FFEffect, FFEffectCode, FFEffectData, FFEffectKind, FFReplay, FFTrigger,
    KeyCode,
};
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

/// A stick or trigger whose value lies no farther from its least than this, as a share of its range, rests at its end.
const END: f32 = 0.1;

/// The pads that may be read, in the order of their numbers in `/dev/input`.
fn pads() -> Vec<evdev::Device> {
    let is_pad = |device: &evdev::Device| {
        device.supported_keys().is_some_and(|keys| keys.contains(KeyCode::BTN_SOUTH))
            && device
                .supported_absolute_axes()
                .is_some_and(|axes| axes.contains(AbsoluteAxisCode::ABS_X) && axes.contains(AbsoluteAxisCode::ABS_Y))
    };
    let number = |path: &Path| -> Option<u32> { path.file_name()?.to_str()?.strip_prefix("event")?.parse().ok() };
    let mut found: Vec<_> = evdev::enumerate().filter(|(_, device)| is_pad(device)).collect();
    found.sort_by_key(|(path, _)| number(path));
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
        let shown = Shown::of(&device).map_err(|error| gone(&error.to_string()))?;
        let layout = Layout::of(&shown);
        Ok(Box::new(Opened { device, layout, shown, has_motors: motors, hum: None }))
    }
}

fn gone(reason: &str) -> DeviceFault {
    DeviceFault::Gone { device: DEVICE, reason: reason.to_owned() }
}

/// Which axes are the right stick and its trigger: pads differ in that, and so do drivers for the same pad.
#[derive(Clone, Copy, Debug)]
struct Layout {
    right: Option<[AbsoluteAxisCode; 2]>,
    trigger: Option<AbsoluteAxisCode>,
}

impl Layout {
    /// The kernel's own drivers have the stick on RX and RY and the trigger on RZ. Many pads without one have it on Z and RZ, with the triggers
    /// on GAS and BRAKE, on RX and RY, or as buttons. A trigger that nobody pulls rests at its end, and a stick in its middle.
    fn of(shown: &Shown) -> Self {
        let has = |axis| shown.range(axis).is_some();
        let pair = |pair: [AbsoluteAxisCode; 2]| Some(pair).filter(|pair| pair.iter().all(|axis| has(*axis)));
        let usual = pair([AbsoluteAxisCode::ABS_RX, AbsoluteAxisCode::ABS_RY]);
        let other = pair([AbsoluteAxisCode::ABS_Z, AbsoluteAxisCode::ABS_RZ]);
        let rest_at_end = |pair: [AbsoluteAxisCode; 2]| {
            pair.iter().all(|axis| shown.range(*axis).is_some_and(|range| range.share() < END))
        };
        let right = match (usual, other) {
            (Some(usual), Some(other)) if rest_at_end(usual) && !rest_at_end(other) => Some(other),
            (usual, other) => usual.or(other),
        };
        let is_free = |axis: &AbsoluteAxisCode| has(*axis) && right.is_none_or(|stick| !stick.contains(axis));
        let triggers = [AbsoluteAxisCode::ABS_GAS, AbsoluteAxisCode::ABS_RZ, AbsoluteAxisCode::ABS_RY];
        Self { right, trigger: triggers.into_iter().find(is_free) }
    }
}

/// What a pad shows: its axes that have two ends, and the keys that are down.
#[derive(Debug)]
struct Shown {
    axes: Vec<(AbsoluteAxisCode, Range)>,
    keys: AttributeSet<KeyCode>,
}

impl Shown {
    /// Asks the kernel.
    fn of(device: &evdev::Device) -> std::io::Result<Self> {
        let ranges = device.get_absinfo()?.map(|(axis, info)| (axis, Range::of(info)));
        Ok(Self { axes: ranges.filter(|(_, range)| range.most > range.least).collect(), keys: device.get_key_state()? })
    }

    fn range(&self, axis: AbsoluteAxisCode) -> Option<Range> {
        self.axes.iter().find(|(code, _)| *code == axis).map(|(_, range)| *range)
    }
}

/// An axis as the kernel shows it.
#[derive(Clone, Copy, Debug)]
struct Range {
    value: f32,
    least: f32,
    most: f32,
    /// How far from the middle it may rest.
    flat: f32,
}

impl Range {
    fn of(info: AbsInfo) -> Self {
        Self {
            value: info.value() as f32,
            least: info.minimum() as f32,
            most: info.maximum() as f32,
            flat: info.flat() as f32,
        }
    }

    /// From 0 at its least to 1 at its most.
    fn share(self) -> f32 {
        ((self.value - self.least) / (self.most - self.least)).clamp(0.0, 1.0)
    }

    /// From −1 to 1, and nothing where it may rest.
    fn deflection(self) -> f32 {
        let from_middle = self.value - (self.least + self.most) / 2.0;
        if from_middle.abs() <= self.flat { 0.0 } else { 2.0 * self.share() - 1.0 }
    }
}

#[derive(Debug)]
struct Opened {
    device: evdev::Device,
    layout: Layout,
    shown: Shown,
    has_motors: bool,
    hum: Option<FFEffect>,
}

impl Pad for Opened {
    fn sticks(&mut self) -> Result<Sticks, DeviceFault> {
        let heard = self.device.fetch_events().map(|events| events.for_each(drop));
        match heard.and_then(|()| Shown::of(&self.device)) {
            Ok(shown) => self.shown = shown,
            Err(error) if error.kind() == ErrorKind::WouldBlock => {}
            Err(error) => return Err(gone(&error.to_string())),
        }
        let along = |axis| self.shown.range(axis).map_or(0.0, Range::deflection);
        let stick = |[x, y]: [AbsoluteAxisCode; 2]| Vec2::new(along(x), -along(y));
        let is_down = |key| self.shown.keys.contains(key);
        let pulled = self.layout.trigger.and_then(|axis| self.shown.range(axis)).map(Range::share);
        Ok(Sticks {
            left: stick([AbsoluteAxisCode::ABS_X, AbsoluteAxisCode::ABS_Y]),
            right: self.layout.right.map_or(Vec2::ZERO, stick),
            trigger: pulled.unwrap_or_else(|| f32::from(u8::from(is_down(KeyCode::BTN_TR2)))),
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
