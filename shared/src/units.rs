//! Newtypes for the quantities that a bare number could be mistaken for.
//!
//! SI throughout: metres, seconds, newtons. Millimetres appear only in files and on the screen.
//! Invariant: lengths that people and files give and want are converted here. Factors stand elsewhere only where the wire has units of its own
//! (µm, mN), where errors tell of a mesh, and where the wheel counts turns.

use core::fmt;

/// One sub-step of the authoritative timeline, counted from the opening of the room.
///
/// A tick lasts [`Tick::PERIOD`]. Client and server speak of the same tick when they write the same number.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Tick(pub u64);

impl Tick {
    /// Ticks in one second.
    pub const PER_SECOND: u64 = 1000;
    /// Length of one tick.
    pub const PERIOD: Seconds = Seconds(1.0 / Self::PER_SECOND as f32);

    /// The tick that follows this one.
    ///
    /// ```
    /// use pottery_shared::units::Tick;
    /// assert_eq!(Tick(7).next(), Tick(8));
    /// ```
    #[must_use]
    pub const fn next(self) -> Self {
        Self(self.0 + 1)
    }

    /// This tick moved by a signed number of ticks; stops at zero.
    #[must_use]
    pub const fn offset(self, ticks: i64) -> Self {
        Self(self.0.saturating_add_signed(ticks))
    }

    /// The tick nearest to this one with the given lowest 16 bits.
    ///
    /// ```
    /// use pottery_shared::units::Tick;
    /// assert_eq!(Tick(0x2_0003).nearest(0xfffe), Tick(0x1_fffe));
    /// ```
    #[must_use]
    pub const fn nearest(self, lowest: u16) -> Self {
        self.offset(lowest.wrapping_sub(self.0 as u16) as i16 as i64)
    }

    /// Signed number of ticks from `earlier` to this one; ends at the ends of `i64`.
    ///
    /// ```
    /// use pottery_shared::units::Tick;
    /// assert_eq!(Tick(3).since(Tick(5)), -2);
    /// assert_eq!(Tick(u64::MAX).since(Tick(5)), i64::MAX);
    /// ```
    #[must_use]
    pub const fn since(self, earlier: Self) -> i64 {
        match self.0.checked_signed_diff(earlier.0) {
            Some(ticks) => ticks,
            None if self.0 > earlier.0 => i64::MAX,
            None => i64::MIN,
        }
    }
}

impl fmt::Display for Tick {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "tick {}", self.0)
    }
}

/// A length in metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Metres(pub f32);

impl Metres {
    /// A length given in millimetres, as files and people give it.
    #[must_use]
    pub const fn from_mm(mm: f32) -> Self {
        Self(mm * 1e-3)
    }

    /// The length in millimetres, as files and people want it.
    #[must_use]
    pub const fn as_mm(self) -> f32 {
        self.0 * 1e3
    }

    /// The length in millimetres, to the micrometre: as sentences tell it, without the digits that binary adds and nobody typed.
    ///
    /// ```
    /// use pottery_shared::units::Metres;
    /// let length = Metres::from_mm(1.1);
    /// assert_eq!((length.as_mm(), length.told_mm()), (1.1000001, 1.1));
    /// ```
    #[must_use]
    pub fn told_mm(self) -> f32 {
        libm::roundf(self.0 * 1e6) / 1e3
    }
}

/// A duration in seconds.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Seconds(pub f32);

/// Turning speed in turns a minute, positive when the wheel turns from x towards y.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub struct Rpm(pub f32);
