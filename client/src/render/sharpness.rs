//! How many pixels a picture may have where the processor draws them.
//!
//! Pure: is told how long pictures took, and knows no device and no clock.
//! Invariant: the share stays within [`Sharpness::LEAST`] and 1.

/// Share of the picture's width and height that is drawn, steered by what pictures cost.
///
/// Where the processor draws, nearly all of a picture's time goes into its pixels. So the share falls by a step when
/// pictures take longer than they may, and rises by one when they would still be quick enough with it: between the two
/// nothing changes, so that the picture does not flicker between sharp and blurred.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sharpness {
    share: f32,
    /// Running mean, ms.
    taken_ms: f32,
    /// Pictures since the last change.
    pictures: u32,
}

impl Default for Sharpness {
    fn default() -> Self {
        Self { share: 1.0, taken_ms: 0.0, pictures: 0 }
    }
}

impl Sharpness {
    /// Least share: below it grooves are no longer seen.
    pub const LEAST: f32 = 0.5;
    /// Longest that a picture may take, ms: with it 30 a second leave a third of the time to the hand and the network.
    pub const LONGEST_MS: f32 = 22.0;
    /// What one step makes of the share.
    const STEP: f32 = 0.84;
    /// A rise is made when its picture would take no more than this part of the longest.
    const EASY: f32 = 0.8;
    /// Weight of a picture in the running mean, and pictures between two changes.
    const WEIGHT: f32 = 0.25;
    const PATIENCE: u32 = 8;

    /// Share of width and height to draw.
    #[must_use]
    pub const fn share(&self) -> f32 {
        self.share
    }

    /// Takes note of a picture that took so long, ms.
    pub fn note(&mut self, taken_ms: f32) {
        if !taken_ms.is_finite() {
            return;
        }
        let weight = if self.pictures == 0 { 1.0 } else { Self::WEIGHT };
        self.taken_ms += (taken_ms - self.taken_ms) * weight;
        self.pictures += 1;
        if self.pictures < Self::PATIENCE {
            return;
        }
        let rise = (self.share / Self::STEP).min(1.0);
        let after_rise_ms = self.taken_ms * (rise / self.share).powi(2);
        let share = if self.taken_ms > Self::LONGEST_MS {
            (self.share * Self::STEP).max(Self::LEAST)
        } else if after_rise_ms < Self::EASY * Self::LONGEST_MS {
            rise
        } else {
            self.share
        };
        if share != self.share {
            *self = Self { share, ..Self::default() };
        }
    }
}
