//! What a viewer sees of the room's clay for its bytes, at other quanta and rates.
//!
//! Owns the comparison; the chains are the studio's own. Nothing is lost and nothing late here: what is off comes of quantum and rate alone.
//! Invariant: every chain follows the same session.

use pottery_shared::clay::{Pot, Surface};
use pottery_shared::snapshot::{Author, Detail, Quantum, Replica, SnapshotClock, Tier, TileLayout, Touched};
use pottery_shared::units::Tick;

use super::NetworkError;
use super::session::Clay;
use crate::chart::csv::{Cell, Row};

/// Ticks between two looks at what is seen: no multiple of a snapshot's period, so that every age of the clay is met.
const LOOK_EVERY: u64 = 7;

/// What a subscription costs and shows.
#[derive(Clone, Debug, PartialEq)]
pub struct SubscriptionFigures {
    /// Of which session.
    pub session: String,
    /// How fine its radii are, µm.
    pub quantum_um: f64,
    /// How often it is told, Hz.
    pub rate_hz: f64,
    /// What it takes while hands press, bytes a second, without what carries it.
    pub bytes_per_s: f64,
    /// How far what is seen is from the room's clay, over all elements that are ever pressed and all times, µm: root of the mean
    /// square, and the largest.
    pub error_um: [f64; 2],
}

/// A chain and who follows it.
struct Viewer {
    detail: Detail,
    tier: Tier,
    replica: Replica,
    bytes: u64,
    squares: f64,
    largest_m: f32,
}

/// Goes through a session with every detail.
///
/// # Errors
/// [`NetworkError`].
pub(super) fn measure(
    name: &str,
    clay: &mut Clay,
    details: &[Detail],
) -> Result<Vec<SubscriptionFigures>, NetworkError> {
    let spec = *clay.pot().spec();
    let untouched = || Pot::new(spec).expect("the session's own specification");
    let mut follower = Follower::new(untouched());
    let viewer = |detail: &Detail| {
        let tier = Tier::new(&follower.author, *detail);
        let replica = Replica::with_quantum(untouched(), detail.quantum());
        Viewer { detail: *detail, tier, replica, bytes: 0, squares: 0.0, largest_m: 0.0 }
    };
    let mut viewers: Vec<Viewer> = details.iter().map(viewer).collect();
    let (first, last) = clay.span();
    let is_pressed = pressed(&untouched(), clay, last)?;
    let mut again = clay.again()?;
    let mut news = Touched::none(untouched().surfaces().iter().map(Surface::shape));
    let (mut begun, mut ended) = (None, first);
    let mut looks = 0_u64;
    for tick in (first.0..=last.0).map(Tick) {
        again.at(tick)?;
        if SnapshotClock::default().is_due(tick) {
            if follower.follow(again.pot(), again.moment(tick)).is_some() {
                begun = begun.or(Some(tick));
                ended = tick;
            }
            let number = SnapshotClock::default().count(tick);
            for viewer in viewers.iter_mut().filter(|viewer| number.is_multiple_of(viewer.detail.every())) {
                let Some(delta) = viewer.tier.publish(&follower.author, again.moment(tick)) else { continue };
                viewer.bytes += delta.bytes.len() as u64;
                if viewer.replica.apply_delta(delta.version, &delta.bytes, &mut news).is_err() {
                    return Err(NetworkError::Unlike { name: name.to_owned(), tick: tick.0 });
                }
            }
        }
        if begun.is_some() && tick.0.is_multiple_of(LOOK_EVERY) {
            looks += 1;
            for viewer in &mut viewers {
                viewer.look(again.pot(), &is_pressed);
            }
        }
    }
    // what nobody does takes nothing
    let seconds = ended.since(begun.unwrap_or(first)).max(1) as f64 * 1e-3;
    let elements = is_pressed.iter().filter(|is| **is).count() as f64 * looks as f64;
    let figures = |viewer: &Viewer| SubscriptionFigures {
        session: name.to_owned(),
        quantum_um: f64::from(viewer.detail.quantum().metres()) * 1e6,
        rate_hz: SnapshotClock::PER_SECOND as f64 / viewer.detail.every() as f64,
        bytes_per_s: viewer.bytes as f64 / seconds,
        error_um: [(viewer.squares / elements).sqrt() * 1e6, f64::from(viewer.largest_m) * 1e6],
    };
    Ok(viewers.iter().map(figures).collect())
}

/// Which elements of the outer surface a session ever presses.
fn pressed(untouched: &Pot, clay: &mut Clay, last: Tick) -> Result<Vec<bool>, NetworkError> {
    let before = untouched.surfaces()[0].radii_m().to_vec();
    let mut is_pressed = vec![false; before.len()];
    let first = clay.span().0;
    // a tenth of a second is too short to press in and be filled again
    for tick in (first.0..last.0).step_by(100).chain([last.0]).map(Tick) {
        let now = clay.at(tick)?.surfaces()[0].radii_m();
        for ((is_pressed, now), before) in is_pressed.iter_mut().zip(now).zip(&before) {
            *is_pressed |= (now - before).abs() > Quantum::FINEST.metres();
        }
    }
    Ok(is_pressed)
}

impl Viewer {
    fn look(&mut self, room: &Pot, is_pressed: &[bool]) {
        let (seen, room) = (self.replica.pot().surfaces()[0].radii_m(), room.surfaces()[0].radii_m());
        let (mut squares, mut largest_m) = (0.0_f64, self.largest_m);
        for ((seen, room), _) in seen.iter().zip(room).zip(is_pressed).filter(|(_, is_pressed)| **is_pressed) {
            let off_m = (seen - room).abs();
            largest_m = largest_m.max(off_m);
            squares += f64::from(off_m) * f64::from(off_m);
        }
        self.squares += squares;
        self.largest_m = largest_m;
    }
}

/// An author whose clay is that of a recording.
pub(super) struct Follower {
    pub(super) author: Author,
    pot: Pot,
    all: Touched,
}

impl Follower {
    /// An author of the untouched pot.
    pub(super) fn new(mut pot: Pot) -> Self {
        let author = Author::new(&mut pot);
        let mut all = Touched::none(pot.surfaces().iter().map(Surface::shape));
        for (surface, shape) in pot.surfaces().iter().map(Surface::shape).enumerate() {
            (0..TileLayout::new(shape).tiles()).for_each(|tile| all.add(surface, tile));
        }
        Self { author, pot, all }
    }

    /// Publishes the clay as it is; the bytes of its delta, if anything changed.
    pub(super) fn follow(&mut self, pot: &Pot, now: pottery_shared::snapshot::Moment) -> Option<Vec<u8>> {
        self.pot.copy_from(pot);
        let mut touched = self.all.clone();
        self.author.publish(&mut self.pot, &mut touched, now).map(|delta| delta.bytes)
    }
}

impl Row for SubscriptionFigures {
    const COLUMNS: &'static [&'static str] =
        &["session", "quantum_um", "rate_hz", "bytes_per_s", "kbit_per_s", "error_rms_um", "error_max_um"];

    fn cells(&self) -> Vec<Cell> {
        let [rms_um, most_um] = self.error_um;
        vec![
            self.session.as_str().into(),
            self.quantum_um.into(),
            self.rate_hz.into(),
            self.bytes_per_s.into(),
            (self.bytes_per_s * 8e-3).into(),
            rms_um.into(),
            most_um.into(),
        ]
    }
}
