//! Pots that are put on a wheel at which people work: the same clay on that wheel's grid, in pieces for the wire.
//!
//! Owns what may be put where, for both ends; where a pot comes from is the program's affair.
//! Invariant: a pot that fits stands on the wheel as it stood where it was made, to a hundredth of its height.

use alloc::vec::Vec;

use crate::clay::{Pot, PotSpec};
use crate::protocol::{POT_PIECE, Request};
use crate::snapshot::{PotRecord, RecordError};
use crate::units::Metres;

/// Share of its height by which a pot may stand otherwise on a wheel than where it was made: what going to another grid makes of it is a
/// thousandth, and a hundredth is hardly seen.
const HEIGHT_SHARE_MAX: f32 = 0.01;

/// Why a pot cannot be put on a wheel.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum PutError {
    /// It is of another amount of clay, or of another wall; begin a studio with it.
    #[error(
        "this pot is {theirs_mm:.0} mm high with a wall of {their_wall_mm:.1} mm, and of this wheel's clay it would be {ours_mm:.0} mm \
         with {our_wall_mm:.1} mm: open it on a wheel of its own with --open"
    )]
    Clay {
        /// Its height, mm.
        theirs_mm: f32,
        /// The height that it would have here, mm.
        ours_mm: f32,
        /// Its wall, mm.
        their_wall_mm: f32,
        /// The wheel's wall, mm.
        our_wall_mm: f32,
    },
    /// Its radii are none of this wheel's; begin a studio with it.
    #[error("this pot does not fit on this wheel, so open it on a wheel of its own with --open: {0}")]
    Record(#[from] RecordError),
}

/// A pot as it would stand on a wheel of another specification: its clay on that grid.
///
/// ```
/// use pottery_shared::clay::{Form, GridShape, PotSpec};
/// use pottery_shared::session::fitted;
/// use pottery_shared::snapshot::PotRecord;
/// use pottery_shared::units::Metres;
///
/// let wheel = PotSpec { keeps_volume: true, ..PotSpec::default() };
/// let finer = PotSpec { shape: GridShape::new(720, 800)?, ..wheel };
/// let bowl = PotRecord::of(&Form::Bowl.of_clay_of(finer)?);
/// assert_eq!(fitted(&bowl, &wheel)?.spec().shape, wheel.shape);
/// let thinner = PotSpec { wall: Metres::from_mm(4.0), ..wheel };
/// assert!(fitted(&bowl, &thinner).is_err());
/// # Ok::<(), Box<dyn core::error::Error>>(())
/// ```
///
/// # Errors
/// [`PutError`] when it would be another pot there.
pub fn fitted(record: &PotRecord, wheel: &PotSpec) -> Result<PotRecord, PutError> {
    if record.spec() == wheel {
        return Ok(record.clone());
    }
    let theirs = record.pot();
    let fitted = match theirs.spec().shape == wheel.shape {
        true => record.made_as(*wheel)?,
        false => PotRecord::of(&theirs.resampled(wheel.shape)).made_as(*wheel)?,
    };
    let height = |pot: &Pot| pot.surfaces()[0].height_m();
    let (theirs_m, ours_m) = (height(&theirs), height(&fitted.pot()));
    let is_as_high = (ours_m - theirs_m).abs() <= HEIGHT_SHARE_MAX * theirs_m;
    if !is_as_high || record.spec().wall != wheel.wall {
        let mm = |length_m: f32| Metres(length_m).told_mm();
        let walls_mm = [record.spec().wall, wheel.wall].map(Metres::told_mm);
        let (theirs_mm, ours_mm) = (mm(theirs_m), mm(ours_m));
        return Err(PutError::Clay { theirs_mm, ours_mm, their_wall_mm: walls_mm[0], our_wall_mm: walls_mm[1] });
    }
    Ok(fitted)
}

/// The requests that put a pot on the wheel, in order, by somebody whose newest sample is of a tick.
pub(super) fn requests(record: &PotRecord, held: u64) -> impl Iterator<Item = Request> {
    let pieces: Vec<Vec<u8>> = record.planes().chunks(POT_PIECE).map(<[u8]>::to_vec).collect();
    (0..).zip(pieces).map(move |(piece, bytes)| Request::Pot { held, piece, bytes })
}
