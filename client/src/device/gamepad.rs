//! A gamepad: the left stick moves the tool, the trigger pushes it in, and the motors hum with the force.
//!
//! Owns the way from sticks to a place; where pads come from is [`Pads`]. Verified against a scripted pad in the tests, and
//! against what Linux says of one; not yet tried on hardware.
//! Invariant: the place moves no faster than [`SPEED_M_S`] along an axis and never leaves [`REACH_M`].

#[cfg(target_os = "linux")]
mod linux;

use std::fmt::Debug;
use std::time::{Duration, Instant};

use glam::{Vec2, Vec3};
use pottery_shared::units::Seconds;

use super::choice::with_others;
use super::{DeviceFault, Driver, Pace, Port, Reading, Reported};
#[cfg(target_os = "linux")]
pub use linux::SystemPads;

pub(super) const DEVICE: &str = "gamepad";
/// Middle of the workspace in the pad's frame (x right, y up, z towards the person), m.
pub const MIDDLE_M: Vec3 = Vec3::ZERO;
/// Farthest from the middle, m.
pub const REACH_M: f32 = 0.12;
/// Speed at a stick's end, and the trigger's, m/s.
pub const SPEED_M_S: f32 = 0.15;
/// What the trigger pushes, pulled all the way, m.
pub const PUSH_M: f32 = 0.020;
/// Where the tool rests before the pot, m towards the person: some millimetres from the untouched wall.
const REST_M: f32 = -0.022;
/// Stick deflections that count as none.
const DEAD: f32 = 0.12;
/// Force at which the motors hum their loudest, N.
const LOUDEST_N: f32 = 3.3;
/// Slip at which the light motor hums half as loud as it does at last, and below which there is none, m/s: places are rounded to 10 µm,
/// which looks like 10 mm/s.
const HALF_LIGHT_M_S: f32 = 0.2;
const STILL_M_S: f32 = 0.02;
/// Time between two changes of the hum, and changes too small to make.
const HUM_EVERY: Duration = Duration::from_millis(40);
const HUM_STEP: f32 = 0.02;
/// A hum that lasts is told again after this, since a pad's motors end by themselves.
const HUM_AGAIN: Duration = Duration::from_secs(5);

/// What a pad shows: sticks −1 to 1 with right and up positive, trigger 0 to 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sticks {
    /// Moves the tool to the side and up and down.
    pub left: Vec2,
    /// Up takes the place of rest towards the pot, down away from it.
    pub right: Vec2,
    /// Pushes the tool in.
    pub trigger: f32,
    /// Buttons that are down: bit n is button n.
    pub buttons: u32,
}

/// An opened pad.
pub trait Pad: Send + Debug {
    /// What it shows now, without waiting.
    ///
    /// # Errors
    /// [`DeviceFault`] when it has gone.
    fn sticks(&mut self) -> Result<Sticks, DeviceFault>;

    /// Whether it has motors.
    fn has_motors(&self) -> bool;

    /// Lets the heavy and the light motor hum, 0 to 1; a pad without motors does nothing.
    ///
    /// # Errors
    /// [`DeviceFault`] when it has gone.
    fn hum(&mut self, heavy: f32, light: f32) -> Result<(), DeviceFault>;
}

/// Where pads are plugged in.
pub trait Pads: Send + 'static {
    /// Their names.
    fn names(&mut self) -> Vec<String>;

    /// Opens the n-th.
    ///
    /// # Errors
    /// [`DeviceFault`] with what to do.
    fn open(&mut self, number: usize) -> Result<Box<dyn Pad>, DeviceFault>;
}

/// The driver.
#[derive(Debug)]
pub struct GamepadDriver<P> {
    pads: P,
    number: usize,
}

impl<P: Pads> GamepadDriver<P> {
    /// A driver for the n-th pad, from 0.
    #[must_use]
    pub const fn new(pads: P, number: usize) -> Self {
        Self { pads, number }
    }

    /// Which pad would be used, and how to choose another.
    ///
    /// # Errors
    /// [`DeviceFault`] when there is none, or not this many.
    pub fn probe(&mut self) -> Result<String, DeviceFault> {
        let names = self.names()?;
        let others = names.iter().enumerate().filter(|(number, _)| *number != self.number);
        let others: Vec<_> = others.map(|(number, name)| format!("gamepad:number={number} ({name})")).collect();
        Ok(with_others(names[self.number].clone(), &others))
    }

    /// Names of the pads that are there, of which this is one.
    fn names(&mut self) -> Result<Vec<String>, DeviceFault> {
        let names = self.pads.names();
        if self.number >= names.len() {
            return Err(DeviceFault::NotFound {
                device: DEVICE,
                reason: match names.len() {
                    0 => "no input device has a gamepad's sticks and buttons, or none that you may read".into(),
                    count => format!("there is no number {} among {count}, counted from 0", self.number),
                },
                remedy: "plug it in; on Linux you may have to be in the group `input`".into(),
            });
        }
        Ok(names)
    }
}

impl<P: Pads> Driver for GamepadDriver<P> {
    fn serve(&mut self, port: &mut Port) -> Result<(), DeviceFault> {
        let names = self.names()?;
        let mut pad = self.pads.open(self.number)?;
        let name = &names[self.number];
        let about = if pad.has_motors() { name.clone() } else { format!("{name}, without motors") };
        port.found(about, Reported::default());
        let mut place = Place::default();
        let mut hum = Hum::default();
        let mut pace = Pace::new();
        let mut last = Instant::now();
        while !port.is_closing() {
            let now = Instant::now();
            let sticks = pad.sticks()?;
            place.follow(sticks, (now - last).as_secs_f32());
            last = now;
            port.publish(Reading { position_m: place.tool_m(), velocity_m_s: None, buttons: sticks.buttons });
            hum.follow(pad.as_mut(), port.force_n().length(), port.slip_m_s(), now)?;
            pace.wait();
        }
        pad.hum(0.0, 0.0)
    }

    /// A hum pushes no hand.
    fn delay(&self) -> Seconds {
        Seconds(0.0)
    }
}

/// Where the tool is, by what the sticks did.
#[derive(Clone, Copy, Debug)]
struct Place {
    rest_m: Vec3,
    pushed_m: f32,
}

impl Default for Place {
    fn default() -> Self {
        Self { rest_m: Vec3::new(0.0, 0.0, REST_M), pushed_m: 0.0 }
    }
}

/// What a deflection stands for: nothing near the middle, then finer than it looks.
fn deflection(shown: f32) -> f32 {
    if shown.is_nan() {
        return 0.0;
    }
    let beyond = ((shown.abs() - DEAD) / (1.0 - DEAD)).clamp(0.0, 1.0);
    (beyond * beyond).copysign(shown)
}

impl Place {
    fn follow(&mut self, sticks: Sticks, seconds: f32) {
        // after a stall the tool does not make up for it
        let step_m = SPEED_M_S * seconds.clamp(0.0, 0.02);
        let towards = Vec3::new(deflection(sticks.left.x), deflection(sticks.left.y), -deflection(sticks.right.y));
        self.rest_m = (self.rest_m + towards * step_m).clamp(Vec3::splat(-REACH_M), Vec3::splat(REACH_M));
        let trigger = if sticks.trigger.is_nan() { 0.0 } else { sticks.trigger.clamp(0.0, 1.0) };
        self.pushed_m += (trigger * PUSH_M - self.pushed_m).clamp(-step_m, step_m);
    }

    fn tool_m(&self) -> Vec3 {
        Vec3::new(self.rest_m.x, self.rest_m.y, (self.rest_m.z - self.pushed_m).max(-REACH_M))
    }
}

/// What the motors do.
#[derive(Clone, Copy, Debug, Default)]
struct Hum {
    heavy: f32,
    light: f32,
    looked: Option<Instant>,
    told: Option<Instant>,
}

impl Hum {
    /// The heavy motor follows the force, and the light one how fast the clay goes by under it.
    fn follow(&mut self, pad: &mut dyn Pad, force_n: f32, slip_m_s: f32, now: Instant) -> Result<(), DeviceFault> {
        if self.looked.is_some_and(|looked| now - looked < HUM_EVERY) {
            return Ok(());
        }
        self.looked = Some(now);
        let heavy = (force_n / LOUDEST_N).min(1.0);
        let light = if slip_m_s > STILL_M_S { heavy.sqrt() * slip_m_s / (slip_m_s + HALF_LIGHT_M_S) } else { 0.0 };
        let is_news = (heavy - self.heavy).abs() > HUM_STEP
            || (light - self.light).abs() > HUM_STEP
            || (heavy == 0.0) != (self.heavy == 0.0)
            || (light == 0.0) != (self.light == 0.0)
            || (heavy > 0.0 && self.told.is_none_or(|told| now - told > HUM_AGAIN));
        if is_news {
            pad.hum(heavy, light)?;
            (self.heavy, self.light, self.told) = (heavy, light, Some(now));
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tool_keeps_its_speed_and_its_reach_whatever_the_sticks_say() {
        let mut place = Place::default();
        let wild = [f32::NAN, f32::INFINITY, -5.0, 0.0, 1.0];
        for step in 0..20_000 {
            let of = |n: usize| wild[(step / 700 + n) % wild.len()];
            let before = place.tool_m();
            let sticks =
                Sticks { left: Vec2::new(of(0), of(1)), right: Vec2::new(of(2), of(3)), trigger: of(4), buttons: 0 };
            place.follow(sticks, 1e-3);
            let moved = (place.tool_m() - before).abs();
            // rest and push move at once along z; rounding of an f32 at 0.1 m
            assert!(moved.x.max(moved.y) <= SPEED_M_S * 1.0001e-3 && moved.z <= 2.0001e-3 * SPEED_M_S, "{moved}");
            assert!(place.tool_m().abs().max_element() <= REACH_M);
        }
    }

    #[test]
    fn stick_at_rest_moves_nothing_and_a_stall_is_not_made_up_for() {
        let mut place = Place::default();
        place.follow(Sticks { left: Vec2::splat(0.9 * DEAD), ..Sticks::default() }, 1.0);
        assert_eq!(place.tool_m(), Vec3::new(0.0, 0.0, REST_M));
        place.follow(Sticks { left: Vec2::X, ..Sticks::default() }, 10.0);
        assert!(place.tool_m().x <= SPEED_M_S * 0.0201);
    }
}
