//! What the same changes take in our codec, in simpler ones, and at least.
//!
//! Owns the simpler ones. All of them tell the same snapshots of the same session, 60 a second, and lose nothing.
//! Invariant: what is counted can be read back, each snapshot from itself and the one before.

use std::collections::BTreeMap;

use pottery_shared::clay::{Pot, Surface};
use pottery_shared::snapshot::{Ledger, Replica, SnapshotClock, TileLayout, Touched, quantise};
use pottery_shared::units::Tick;

use super::NetworkError;
use super::session::Clay;
use super::subscription::Follower;
use crate::chart::csv::{Cell, Row};

/// Levels of zstd: the quickest, and one beyond which it hardly gets smaller.
const LEVELS: [i32; 2] = [1, 19];

/// How a snapshot's changes can be told.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Scheme {
    /// Every changed cell: its number and its new radius, seven bits a byte.
    Cells,
    /// Every changed tile whole: differences to the snapshot before, seven bits a byte.
    Tiles,
    /// The same through zstd at its quickest.
    TilesZstd1,
    /// The same through zstd at level 19.
    TilesZstd19,
    /// At least for tiles: the entropy of order 0 of their differences, as often as each occurs in the whole session.
    TilesEntropy,
    /// Our codec.
    Ours,
    /// At least for our codec's contexts: their conditional entropy, see [`Ledger`].
    OursEntropy,
}

impl Scheme {
    /// All of them.
    pub const ALL: [Self; 7] = [
        Self::Cells,
        Self::Tiles,
        Self::TilesZstd1,
        Self::TilesZstd19,
        Self::TilesEntropy,
        Self::Ours,
        Self::OursEntropy,
    ];

    /// In a few words.
    #[must_use]
    pub const fn title(self) -> &'static str {
        match self {
            Self::Cells => "list of changed cells",
            Self::Tiles => "changed tiles",
            Self::TilesZstd1 => "tiles and zstd 1",
            Self::TilesZstd19 => "tiles and zstd 19",
            Self::TilesEntropy => "tiles: entropy of order 0",
            Self::Ours => "our codec",
            Self::OursEntropy => "our contexts' entropy",
        }
    }
}

/// What a scheme takes of a session.
#[derive(Clone, Debug, PartialEq)]
pub struct CodecFigures {
    /// Of which session.
    pub session: String,
    /// Which scheme.
    pub scheme: Scheme,
    /// Bytes a snapshot in which anything changed, in the mean.
    pub bytes: f64,
    /// Cells that changed in one, in the mean.
    pub cells: f64,
    /// Snapshots in which anything changed.
    pub snapshots: u64,
}

/// Sums over a session.
#[derive(Default)]
struct Sums {
    bytes: BTreeMap<Scheme, f64>,
    cells: u64,
    snapshots: u64,
    /// How often each difference occurs in a changed tile.
    differences: BTreeMap<i32, u64>,
    /// Bytes that say which tiles changed.
    names: u64,
}

/// Goes through a session with every scheme.
///
/// # Errors
/// [`NetworkError`].
pub(super) fn measure(name: &str, clay: &mut Clay) -> Result<Vec<CodecFigures>, NetworkError> {
    let untouched = Pot::new(*clay.pot().spec()).expect("the session's own specification");
    let mut follower = Follower::new(untouched.clone());
    let mut ledger = Ledger::new(&untouched);
    let mut replica = Replica::new(untouched.clone());
    let layouts: Vec<_> = untouched.surfaces().iter().map(Surface::shape).map(TileLayout::new).collect();
    let steps = |surface: &Surface| -> Vec<u16> { surface.radii_m().iter().copied().map(quantise).collect() };
    let steps = |pot: &Pot| -> Vec<Vec<u16>> { pot.surfaces().iter().map(steps).collect() };
    let mut before = steps(&untouched);
    let mut news = Touched::none(untouched.surfaces().iter().map(Surface::shape));
    let mut sums = Sums::default();
    let (first, last) = clay.span();
    for tick in (first.0..=last.0).map(Tick).filter(|tick| SnapshotClock::default().is_due(*tick)) {
        clay.at(tick)?;
        let now = steps(clay.pot());
        let Some(bytes) = follower.follow(clay.pot(), clay.moment(tick)) else { continue };
        let is_read = ledger.read(&bytes)
            && replica.apply_delta(follower.author.latest(), &bytes, &mut news).is_ok()
            && replica.pot().surfaces().iter().map(Surface::radii_m).eq(clay
                .pot()
                .surfaces()
                .iter()
                .map(Surface::radii_m));
        if !is_read {
            return Err(NetworkError::Unlike { name: name.to_owned(), tick: tick.0 });
        }
        sums.note(&layouts, &before, &now);
        sums.add(Scheme::Ours, bytes.len());
        before = now;
    }
    sums.bytes.insert(Scheme::OursEntropy, ledger.entropy_bits() / 8.0);
    sums.bytes.insert(Scheme::TilesEntropy, sums.names as f64 + entropy_bits(sums.differences.values()) / 8.0);
    let snapshots = sums.snapshots.max(1) as f64;
    let figures = |scheme| CodecFigures {
        session: name.to_owned(),
        scheme,
        bytes: sums.bytes.get(&scheme).copied().unwrap_or_default() / snapshots,
        cells: sums.cells as f64 / snapshots,
        snapshots: sums.snapshots,
    };
    Ok(Scheme::ALL.into_iter().map(figures).collect())
}

impl Sums {
    fn add(&mut self, scheme: Scheme, bytes: usize) {
        *self.bytes.entry(scheme).or_default() += bytes as f64;
    }

    /// Tells a snapshot in the simpler schemes: the cells and tiles of one surface after another's.
    fn note(&mut self, layouts: &[TileLayout], before: &[Vec<u16>], now: &[Vec<u16>]) {
        let (mut cells, mut tiles) = (Vec::new(), Vec::new());
        let both = before.iter().flatten().zip(now.iter().flatten());
        for (at, (_, now)) in (0..).zip(both).filter(|(_, (before, now))| before != now) {
            put(&mut cells, at);
            put(&mut cells, u32::from(*now));
            self.cells += 1;
        }
        let (mut first, mut last) = (0, 0);
        for (layout, (before, now)) in layouts.iter().zip(before.iter().zip(now)) {
            self.note_tiles(layout, (before, now), &mut tiles, first, &mut last);
            first += layout.tiles();
        }
        self.snapshots += 1;
        self.add(Scheme::Cells, cells.len());
        self.add(Scheme::Tiles, tiles.len());
        for (scheme, level) in [Scheme::TilesZstd1, Scheme::TilesZstd19].into_iter().zip(LEVELS) {
            let packed = zstd::bulk::compress(&tiles, level).expect("what is in memory can be packed");
            self.add(scheme, packed.len());
        }
    }

    /// Appends the changed tiles of a surface, which are numbered from `first` on; `last` is the number that was told last.
    fn note_tiles(
        &mut self,
        layout: &TileLayout,
        (before, now): (&[u16], &[u16]),
        tiles: &mut Vec<u8>,
        first: u32,
        last: &mut u32,
    ) {
        let rows = layout.shape().rows() as usize;
        for tile in 0..layout.tiles() {
            let window = layout.window(tile);
            let place = |column: u32| column as usize * rows + window.first_row as usize;
            let columns = window.first_column..window.first_column + window.columns;
            let height = window.rows as usize;
            if columns.clone().all(|column| now[place(column)..][..height] == before[place(column)..][..height]) {
                continue;
            }
            let named = tiles.len();
            put(tiles, first + tile - *last);
            self.names += (tiles.len() - named) as u64;
            *last = first + tile;
            for column in columns {
                for at in place(column)..place(column) + height {
                    let difference = i32::from(now[at]) - i32::from(before[at]);
                    *self.differences.entry(difference).or_default() += 1;
                    put(tiles, ((difference << 1) ^ (difference >> 31)) as u32);
                }
            }
        }
    }
}

/// `Σ n·log₂(N/n)`.
fn entropy_bits<'a>(counts: impl Iterator<Item = &'a u64> + Clone) -> f64 {
    let all = counts.clone().sum::<u64>() as f64;
    counts.map(|&count| count as f64 * (all / count as f64).log2()).sum()
}

/// Appends a number, seven bits a byte.
fn put(out: &mut Vec<u8>, mut number: u32) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

impl Row for CodecFigures {
    const COLUMNS: &'static [&'static str] =
        &["session", "scheme", "bytes_a_snapshot", "kbit_per_s", "changed_cells", "snapshots"];

    fn cells(&self) -> Vec<Cell> {
        vec![
            self.session.as_str().into(),
            self.scheme.title().into(),
            self.bytes.into(),
            (self.bytes * 8e-3 * SnapshotClock::PER_SECOND as f64).into(),
            self.cells.into(),
            Cell::Count(self.snapshots),
        ]
    }
}
