//! What a tool on clay sounds like: noise through a filter, both led by force, slip and wetness.
//!
//! Knows no sound card and no clock; the same voice makes the same samples of the same rubbing.
//! Invariant: no sample is beyond ±1, none is farther than [`STEP_MAX`] from the one before, and what rests is silent.

use super::{RATE_HZ, Rub};

/// Farthest from one sample to the next: what a loud tone of 2 kHz needs. A step beyond it would be heard as a click.
pub const STEP_MAX: f32 = 0.2;

/// Time in which the voice comes to what it is led to, s: too short to be waited for, too long to click.
const EASE_S: f32 = 0.01;
/// Force at which half of the loudness is reached, N.
const HALF_LOUD_N: f32 = 2.0;
/// Slip at which half of it is, m/s: slow rubbing is heard.
const HALF_LOUD_M_S: f32 = 0.06;
/// Slip at which the middle of the noise is half as high as it gets, m/s.
const HALF_HIGH_M_S: f32 = 0.5;
/// Middle of the noise, Hz: of very slow rubbing, and how much higher it gets on dry clay.
const LOWEST_HZ: f32 = 180.0;
const RANGE_HZ: f32 = 7_000.0;
/// Share of that range which the wettest clay leaves: a film of water takes the hiss.
const WET_RANGE: f32 = 0.2;
/// Share of the loudness which it leaves.
const WET_LOUDNESS: f32 = 0.5;
/// Width of the noise over its middle: on dry and on the wettest clay.
const DRY_WIDTH: f32 = 1.4;
const WET_WIDTH: f32 = 0.8;
/// How fast grains of dry clay come and go, Hz, and how much they change the loudness: by a half either way, as their noise is small.
const GRAINS_HZ: f32 = 25.0;
const GRAINS_SHARE: f32 = 20.0;
/// Loudness of all of it.
const LOUDNESS: f32 = 1.2;
/// Quieter is silence.
const SILENCE: f32 = 1e-5;

/// What the voice is led to.
#[derive(Clone, Copy, Debug, Default)]
struct Timbre {
    loudness: f32,
    /// `tan(π·f/rate)` of the middle, and the width over the middle.
    middle: f32,
    width: f32,
    grains: f32,
}

impl Timbre {
    /// Loudness `F/(F + 2 N)·v/(v + 0.06 m/s)`, middle `180 Hz + 7 kHz·v/(v + 0.5 m/s)`, less of both the wetter. All chosen by ear's
    /// rules and not measured: louder with force, higher with speed, duller and smoother when wet.
    fn of(rub: Rub) -> Self {
        let Rub { force_n, slip_m_s, wetness } = rub;
        if !(force_n > 0.0 && slip_m_s > 0.0 && force_n.is_finite() && slip_m_s.is_finite()) {
            return Self { loudness: 0.0, middle: 0.0, width: DRY_WIDTH, grains: 0.0 };
        }
        let wet = if wetness.is_nan() { 0.0 } else { wetness.clamp(0.0, 1.0) };
        let mixed = |dry: f32, soaked: f32| dry + (soaked - dry) * wet;
        let loudness = force_n / (force_n + HALF_LOUD_N) * slip_m_s / (slip_m_s + HALF_LOUD_M_S);
        let high = slip_m_s / (slip_m_s + HALF_HIGH_M_S);
        let middle_hz = LOWEST_HZ + RANGE_HZ * high * mixed(1.0, WET_RANGE);
        Self {
            loudness: LOUDNESS * loudness * mixed(1.0, WET_LOUDNESS),
            middle: (std::f32::consts::PI * middle_hz / RATE_HZ as f32).tan(),
            width: mixed(DRY_WIDTH, WET_WIDTH),
            grains: 1.0 - wet,
        }
    }

    /// Goes a share of the way to another.
    fn approach(&mut self, to: &Self, share: f32) {
        self.loudness += (to.loudness - self.loudness) * share;
        self.width += (to.width - self.width) * share;
        self.grains += (to.grains - self.grains) * share;
        // what fades away keeps its pitch
        if to.loudness > 0.0 {
            self.middle += (to.middle - self.middle) * share;
        }
        if to.loudness == 0.0 && self.loudness < SILENCE {
            self.loudness = 0.0;
        }
    }
}

/// A voice in the middle of its noise.
///
/// ```
/// use pottery_client::sound::{Rub, Voice};
///
/// let mut samples = [0.0; 4800];
/// Voice::default().fill(Rub { force_n: 2.0, slip_m_s: 0.3, wetness: 0.3 }, &mut samples);
/// assert!(samples.iter().any(|sample| sample.abs() > 0.05));
/// Voice::default().fill(Rub::default(), &mut samples);
/// assert!(samples.iter().all(|sample| *sample == 0.0));
/// ```
#[derive(Clone, Debug)]
pub struct Voice {
    seed: u32,
    timbre: Timbre,
    /// The filter's two integrators.
    band: f32,
    low: f32,
    /// The grains' own low-pass.
    grains: f32,
    last: f32,
}

impl Default for Voice {
    fn default() -> Self {
        let timbre = Timbre { width: DRY_WIDTH, ..Timbre::default() };
        Self { seed: 0x9E37_79B9, timbre, band: 0.0, low: 0.0, grains: 0.0, last: 0.0 }
    }
}

impl Voice {
    /// Goes on with the tool rubbing like that, at [`RATE_HZ`].
    pub fn fill(&mut self, rub: Rub, samples: &mut [f32]) {
        let to = Timbre::of(rub);
        let share = 1.0 - (-1.0 / (EASE_S * RATE_HZ as f32)).exp();
        let grain_share = 1.0 - (-std::f32::consts::TAU * GRAINS_HZ / RATE_HZ as f32).exp();
        for sample in samples {
            self.timbre.approach(&to, share);
            let (white, grain) = (self.noise(), self.noise());
            let band = self.filtered(white);
            self.grains += (grain - self.grains) * grain_share;
            let rough = (1.0 + self.timbre.grains * GRAINS_SHARE * self.grains).max(0.0);
            let wanted = self.timbre.loudness * band * rough;
            // bent towards the limit and never over it
            let bent = wanted / (1.0 + wanted.abs());
            self.last += (bent - self.last).clamp(-STEP_MAX, STEP_MAX);
            *sample = self.last;
        }
    }

    /// White noise, −1 to 1: Marsaglia's xorshift (2003).
    fn noise(&mut self) -> f32 {
        self.seed ^= self.seed << 13;
        self.seed ^= self.seed >> 17;
        self.seed ^= self.seed << 5;
        self.seed as i32 as f32 / -(i32::MIN as f32)
    }

    /// The band of a state-variable filter by the trapezoidal rule, which stays stable however its middle moves (Zavalishin 2012).
    fn filtered(&mut self, input: f32) -> f32 {
        let Timbre { middle, width, .. } = self.timbre;
        let share = 1.0 / (1.0 + middle * (middle + width));
        let band = share * (self.band + middle * (input - self.low));
        let low = self.low + middle * band;
        self.band = 2.0 * band - self.band;
        self.low = 2.0 * low - self.low;
        // as loud whatever the width
        width * band
    }
}
