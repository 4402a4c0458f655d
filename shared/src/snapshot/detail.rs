//! How much of a wheel a subscription shows: how fine, how often, and which part of its height.
//!
//! Owns what can be asked for and its bounds, and what a picture needs; publishes nothing.
//! Invariant: every detail there is can be said on the wire, in one way.

use super::grid::Quantum;
use super::tiles::TileLayout;
use crate::clay::GridShape;
use crate::protocol::DetailWire;
use crate::units::Metres;

/// Rows of tiles of a sight's own grid that are shown, counted from the foot.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Band {
    first: u8,
    end: u8,
}

impl Band {
    /// All rows, however many there are.
    pub const WHOLE: Self = Self { first: 0, end: u8::MAX };

    /// From row `first` to the row before `end`, or to the rim with 255; `None` when that is no row.
    #[must_use]
    pub const fn new(first: u8, end: u8) -> Option<Self> {
        if first < end { Some(Self { first, end }) } else { None }
    }

    /// The fewest rows of a grid that hold a part of its height, from 0 at the foot to 1 at the rim; [`Self::WHOLE`] where those are all.
    #[must_use]
    pub fn over(part: core::ops::Range<f32>, shape: GridShape) -> Self {
        let rows = TileLayout::new(shape).tile_rows();
        // the cast cuts off and saturates
        let row = |share: f32| ((share.clamp(0.0, 1.0) * rows as f32) as u32).min(rows - 1);
        let (first, end) = (row(part.start), row(part.end) + 1);
        match (u8::try_from(first), u8::try_from(end)) {
            (Ok(first), Ok(end)) if (first > 0 || u32::from(end) < rows) && first < end => Self { first, end },
            _ => Self::WHOLE,
        }
    }

    /// Whether it holds a row of tiles.
    pub(super) const fn holds(self, tile_row: u32) -> bool {
        self.first as u32 <= tile_row && (tile_row < self.end as u32 || self.end == u8::MAX)
    }

    /// Whether a grid has all those rows.
    fn is_of(self, shape: GridShape) -> bool {
        let rows = TileLayout::new(shape).tile_rows();
        u32::from(self.first) < rows && (u32::from(self.end) <= rows || self.end == u8::MAX)
    }
}

/// Why there is no such detail.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DetailError {
    /// A figure out of range; choose another.
    #[error("a {field} of {value} cannot be shown: choose a number from {least} to {most}")]
    Range {
        /// Which figure.
        field: &'static str,
        /// What was asked for.
        value: u16,
        /// The least there is.
        least: u16,
        /// The most there is.
        most: u16,
    },
    /// No row of tiles; say the first, and one above the last.
    #[error("rows {first} to {end} are none: the second is one above the last that is shown")]
    Rows {
        /// The first.
        first: u8,
        /// One above the last.
        end: u8,
    },
    /// Has a name of its own; say that.
    #[error("what was asked for has a shorter name")]
    Named,
}

/// How much of a wheel somebody sees who does not work at it.
///
/// ```
/// use pottery_shared::snapshot::{Detail, Quantum};
///
/// let rough = Detail::new(Quantum::of_steps(8), 2, 6)?;
/// assert_eq!((rough.fold(), rough.shows_tools()), (2, false));
/// assert!(Detail::new(Quantum::of_steps(8), 9, 6).unwrap_err().to_string().contains("1 to 8"));
/// # Ok::<(), pottery_shared::snapshot::DetailError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Detail {
    quantum: Quantum,
    fold: u8,
    every: u8,
    band: Band,
    shows_tools: bool,
    is_retold: bool,
}

impl Detail {
    /// Most elements that are taken together, each way.
    pub const FOLD_MAX: u8 = 8;
    /// Most of the author's snapshots of which it has one: it is told at least once a second.
    pub const EVERY_MAX: u8 = 60;

    /// Who looks on at one wheel: every element, thirty times a second, to 11 µm.
    pub const SPECTATOR: Self =
        Self { quantum: Quantum::SPECTATOR, fold: 1, every: 2, band: Band::WHOLE, shows_tools: true, is_retold: false };
    /// One of many wheels in small pictures: elements four times as large each way, five times a second, to 61 µm.
    pub const GALLERY: Self = Self::of_pictures(4);
    /// Who looks on at one wheel and keeps up with pressing again what is pressed there: the author's clay itself, thirty times a
    /// second, for about half of the spectator's bytes.
    pub const RETOLD: Self = Self { quantum: Quantum::FINEST, is_retold: true, ..Self::SPECTATOR };
    /// Those with a name on the wire.
    pub const PRESETS: [Self; 3] = [Self::SPECTATOR, Self::GALLERY, Self::RETOLD];

    /// One without tools, of the whole pot: with elements of `fold` of the author's each way, and with one snapshot of `every` so many.
    ///
    /// # Errors
    /// [`DetailError::Range`] for a fold above [`Self::FOLD_MAX`] or rarer than every [`Self::EVERY_MAX`]; none may be 0.
    pub fn new(quantum: Quantum, fold: u8, every: u8) -> Result<Self, DetailError> {
        for (field, value, most) in [("fold", fold, Self::FOLD_MAX), ("number of snapshots", every, Self::EVERY_MAX)] {
            if !(1..=most).contains(&value) {
                return Err(DetailError::Range { field, value: value.into(), least: 1, most: most.into() });
            }
        }
        Ok(Self { quantum, fold, every, shows_tools: false, ..Self::SPECTATOR })
    }

    /// The same with everybody's tools.
    #[must_use]
    pub const fn with_tools(self) -> Self {
        Self { shows_tools: true, ..self }
    }

    /// The same, of a part of the pot. Rows outside come once, with the first keyframe, and stay as they then were. What is pressed
    /// again is pressed wherever it is, so that [`Self::RETOLD`] stays whole.
    #[must_use]
    pub const fn in_band(self, band: Band) -> Self {
        Self { band: if self.is_retold { Band::WHOLE } else { band }, ..self }
    }

    /// What a small picture needs on which one pixel is `pixel` of clay, of a pot with elements as high as `element`.
    ///
    /// The coarsest of 1, 2, 4 and 8 elements taken together that are no higher than a pixel, so that no mark is drawn more than half a
    /// pixel from where it is, or the finest there is. Four of the finest steps to each of them, so that a step leans as little in all;
    /// and a twentieth of a second to each, in which a hand that presses 5 mm in a second gets half as far as one is high.
    #[must_use]
    pub fn for_picture(pixel: Metres, element: Metres) -> Self {
        let fits = |fold: &u8| f32::from(*fold) * element.0 <= pixel.0;
        Self::of_pictures([8, 4, 2].into_iter().find(fits).unwrap_or(1))
    }

    const fn of_pictures(fold: u8) -> Self {
        let quantum = Quantum::of_steps(4 * fold as u16);
        Self { quantum, fold, every: 3 * fold, band: Band::WHOLE, shows_tools: false, is_retold: false }
    }

    /// The one of those with a name that serves in its place: there is always room for it.
    #[must_use]
    pub const fn preset(self) -> Self {
        match (self.is_retold, self.shows_tools) {
            (true, _) => Self::RETOLD,
            (false, true) => Self::SPECTATOR,
            (false, false) => Self::GALLERY,
        }
    }

    /// How fine its radii are.
    #[must_use]
    pub const fn quantum(self) -> Quantum {
        self.quantum
    }

    /// Elements of the author's that are one of its own, each way.
    #[must_use]
    pub const fn fold(self) -> u32 {
        self.fold as u32
    }

    /// It is published with every so many of the author's snapshots.
    #[must_use]
    pub const fn every(self) -> u64 {
        self.every as u64
    }

    /// Which rows of tiles it shows.
    #[must_use]
    pub const fn band(self) -> Band {
        self.band
    }

    /// Whether it shows tools, and so tells of those that people bring.
    #[must_use]
    pub const fn shows_tools(self) -> bool {
        self.shows_tools
    }

    /// Whether what was pressed is told, to be pressed again.
    #[must_use]
    pub const fn is_retold(self) -> bool {
        self.is_retold
    }

    /// Its grid, where the author's is `shape`: as coarse as it says, as far as a grid may be.
    #[must_use]
    pub fn grid_of(self, shape: GridShape) -> GridShape {
        let (columns, rows) = (shape.columns() / self.fold(), shape.rows() / self.fold());
        GridShape::new(columns.max(8), rows.max(4)).unwrap_or(shape)
    }

    /// Whether a wheel whose grid is `shape` has all rows that it names.
    #[must_use]
    pub fn is_of(self, shape: GridShape) -> bool {
        self.band.is_of(self.grid_of(shape))
    }
}

impl From<Detail> for DetailWire {
    fn from(detail: Detail) -> Self {
        match detail {
            Detail::SPECTATOR => Self::Spectator,
            Detail::GALLERY => Self::Gallery,
            Detail { is_retold: true, .. } => Self::Retold,
            Detail { quantum, fold, every, band: Band { first, end }, shows_tools, .. } => {
                Self::Own { quantum: quantum.steps(), fold, every, first, end, tools: shows_tools }
            }
        }
    }
}

impl TryFrom<DetailWire> for Detail {
    type Error = DetailError;

    fn try_from(wire: DetailWire) -> Result<Self, DetailError> {
        let detail = match wire {
            DetailWire::Spectator => Self::SPECTATOR,
            DetailWire::Gallery => Self::GALLERY,
            DetailWire::Retold => Self::RETOLD,
            DetailWire::Own { quantum: value, fold, every, first, end, tools } => {
                let quantum = Quantum::of_steps(value);
                if quantum.steps() != value {
                    let most = Quantum::STEPS_MAX;
                    return Err(DetailError::Range { field: "quantum", value, least: 1, most });
                }
                let band = Band::new(first, end).ok_or(DetailError::Rows { first, end })?;
                Self { shows_tools: tools, ..Self::new(quantum, fold, every)?.in_band(band) }
            }
        };
        if DetailWire::from(detail) == wire { Ok(detail) } else { Err(DetailError::Named) }
    }
}
