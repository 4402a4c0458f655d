//! The wheel's angle as a pure function of the tick.
//!
//! Integer phase only: two differently rounded angles would put the same press on different elements.
//! Invariant: a new speed changes the phase of no tick before it, back to the oldest change that is kept.

use alloc::vec::Vec;

use glam::Vec3;

use crate::units::{Rpm, Tick};

/// A part of a turn: 2³² steps make a whole one, and overflow is the wrap.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Phase(pub u32);

impl Phase {
    /// The angle in radians, in `0..2π`.
    #[must_use]
    pub fn radians(self) -> f64 {
        f64::from(self.0) * (core::f64::consts::TAU / 4_294_967_296.0)
    }

    /// Where a point of the room stands on a pot turned by this phase (rotation by −phase about z).
    ///
    /// Every conversion into the pot's frame goes through here, on server and client.
    #[must_use]
    pub fn pot_from_room(self, point_m: Vec3) -> Vec3 {
        let (sin, cos) = libm::sincos(self.radians());
        let (x, y) = (f64::from(point_m.x), f64::from(point_m.y));
        Vec3::new((x * cos + y * sin) as f32, (y * cos - x * sin) as f32, point_m.z)
    }

    /// A direction on the pot seen in the room (rotation by +phase about z).
    #[must_use]
    pub fn room_from_pot(self, vector: Vec3) -> Vec3 {
        let (sin, cos) = libm::sincos(self.radians());
        let (x, y) = (f64::from(vector.x), f64::from(vector.y));
        Vec3::new((x * cos - y * sin) as f32, (x * sin + y * cos) as f32, vector.z)
    }
}

/// The time since which the wheel turns at one speed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Segment {
    from: Tick,
    phase: Phase,
    /// Phase steps a tick.
    rate: i32,
}

/// The wheel: its phase at any tick, and the speed changes that are scheduled.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Wheel {
    /// Ascending in `from`, never empty; the first also answers for every earlier tick.
    segments: Vec<Segment>,
}

impl Default for Wheel {
    fn default() -> Self {
        Self::starting_at(Tick(0), Phase(0), 0)
    }
}

impl Wheel {
    /// Fastest turning either way.
    pub const RPM_MAX: Rpm = Rpm(400.0);
    /// Most speed changes kept; older ones are forgotten first. The room makes 20 a second at most and takes samples of
    /// the last ten.
    const SEGMENTS_MAX: usize = 256;
    const STEPS_PER_TICK_PER_RPM: f64 = 4_294_967_296.0 / (60.0 * Tick::PER_SECOND as f64);

    /// A wheel that stands at `phase` at tick `from` and turns by `rate` phase steps a tick.
    #[must_use]
    pub fn starting_at(from: Tick, phase: Phase, rate: i32) -> Self {
        Self { segments: alloc::vec![Segment { from, phase, rate }] }
    }

    /// Phase steps a tick for a turning speed, limited to [`Wheel::RPM_MAX`]; not a number counts as standing still.
    #[must_use]
    pub fn rate_of(speed: Rpm) -> i32 {
        let rpm = if speed.0.is_nan() { 0.0 } else { speed.0.clamp(-Self::RPM_MAX.0, Self::RPM_MAX.0) };
        libm::round(f64::from(rpm) * Self::STEPS_PER_TICK_PER_RPM) as i32
    }

    fn segment(&self, tick: Tick) -> Segment {
        let later = self.segments.partition_point(|segment| segment.from <= tick);
        self.segments[later.saturating_sub(1)]
    }

    /// The phase at a tick.
    ///
    /// `phase(t) = phase(t₀) + rate·(t − t₀)` modulo one turn, t₀ the last speed change.
    #[must_use]
    pub fn phase(&self, tick: Tick) -> Phase {
        let segment = self.segment(tick);
        let ticks = tick.0.wrapping_sub(segment.from.0) as u32;
        Phase(segment.phase.0.wrapping_add((segment.rate as u32).wrapping_mul(ticks)))
    }

    /// Phase steps a tick at a tick.
    #[must_use]
    pub fn rate(&self, tick: Tick) -> i32 {
        self.segment(tick).rate
    }

    /// The turning speed at a tick.
    #[must_use]
    pub fn speed(&self, tick: Tick) -> Rpm {
        Rpm((f64::from(self.rate(tick)) / Self::STEPS_PER_TICK_PER_RPM) as f32)
    }

    /// The turning speed at a tick, rad/s.
    #[must_use]
    pub fn rate_rad_s(&self, tick: Tick) -> f32 {
        (f64::from(self.rate(tick)) * (core::f64::consts::TAU / 4_294_967_296.0) * Tick::PER_SECOND as f64) as f32
    }

    /// Every stretch of even turning that is known: first tick, phase at it and rate, earliest first.
    pub fn segments(&self) -> impl Iterator<Item = (Tick, Phase, i32)> + '_ {
        self.segments.iter().map(|segment| (segment.from, segment.phase, segment.rate))
    }

    /// Turns at `rate` from tick `from` on; whatever was scheduled later than that is dropped.
    pub fn schedule(&mut self, from: Tick, rate: i32) {
        let phase = self.phase(from);
        let keep = self.segments.partition_point(|segment| segment.from < from);
        self.segments.truncate(keep);
        if self.segments.len() == Self::SEGMENTS_MAX {
            self.segments.remove(0);
        }
        self.segments.push(Segment { from, phase, rate });
    }
}
