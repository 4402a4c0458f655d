//! A stroke that was recorded to be shown: the path of a hand, with the force that it felt.
//!
//! Owns what is kept of it; holds no clock.
//! Invariant: what is played lies on the recorded path, and is at most [`Demonstration::LENGTH_MAX_S`] long.

use pottery_shared::session::{GuidingHand, RemoteTool};
use pottery_shared::tool::{Position, Side, Tool};
use pottery_shared::units::{Rpm, Tick};

use crate::stroke::{Stroke, StrokeRecorder};

/// A recorded hand.
///
/// ```
/// use pottery_client::guiding::Demonstration;
/// use pottery_client::stroke::Stroke;
/// use pottery_shared::units::Tick;
///
/// let stroke = Stroke::parse("t_s,x_mm,y_mm,z_mm\n1,90,0,50\n3,70,0,50\n")?;
/// let shown = Demonstration::of(&stroke);
/// let halfway = shown.at(1.0, 7, Tick(5)).ok_or("it is there")?;
/// assert!((halfway.tool.centre.point_m().x - 0.080).abs() < 1e-5);
/// assert_eq!((shown.length_s(), shown.at(2.1, 7, Tick(6))), (2.0, None));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Demonstration {
    path: StrokeRecorder,
    /// From when on which force was felt, N, whether a line was drawn, and on which side of the wall.
    felt: Vec<(f64, f32, bool, Side)>,
    /// When the hand was heard of last.
    last_s: Option<f64>,
}

impl Default for Demonstration {
    fn default() -> Self {
        Self { path: StrokeRecorder::new(Tool::default(), Rpm(0.0)), felt: Vec::new(), last_s: None }
    }
}

impl Demonstration {
    /// Longest that is recorded, s.
    pub const LENGTH_MAX_S: f64 = 600.0;
    /// A hand of which nothing is heard for longer was away, s.
    const GAP_S: f64 = 0.1;

    /// A stroke from a file, of which nobody knows the force.
    #[must_use]
    pub fn of(stroke: &Stroke) -> Self {
        Self { path: StrokeRecorder::going_on(stroke.clone()), felt: Vec::new(), last_s: Some(stroke.end()) }
    }

    /// Takes in where the hand is, `seconds` after it began; what no stroke can hold is left out.
    pub(super) fn push(&mut self, seconds: f64, hand: &GuidingHand) {
        if seconds > Self::LENGTH_MAX_S || self.last_s.is_some_and(|last_s| seconds <= last_s) {
            return;
        }
        if self.last_s.is_some_and(|last_s| seconds - last_s > Self::GAP_S) {
            self.path.lift();
        }
        self.path.hold(hand.tool.tool);
        let (centre_m, orientation) = (hand.tool.centre.point_m(), hand.tool.orientation);
        let taken = self.path.push(seconds, centre_m, orientation).or_else(|_| {
            // taken away and brought back elsewhere
            self.path.lift();
            self.path.push(seconds, centre_m, orientation)
        });
        if taken.is_ok() {
            self.last_s = Some(seconds);
            self.felt.push((seconds, hand.force_n, hand.draws, hand.tool.side));
        }
    }

    /// Whether nothing was recorded.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.path.is_empty()
    }

    /// Seconds from the first place to the last.
    #[must_use]
    pub fn length_s(&self) -> f64 {
        self.path.stroke().duration()
    }

    /// The hand as it was so many seconds after the first place, shown by `client` at `tick`; none while it was lifted.
    #[must_use]
    pub fn at(&self, seconds: f64, client: u16, tick: Tick) -> Option<GuidingHand> {
        let stroke = self.path.stroke();
        let at_s = stroke.start() + seconds;
        let centre = Position::nearest(stroke.at(at_s)?)?;
        let later = self.felt.partition_point(|(from_s, ..)| *from_s <= at_s);
        let felt = later.checked_sub(1).map(|at| self.felt[at]);
        let (force_n, draws, side) =
            felt.map_or_else(Default::default, |(_, force_n, draws, side)| (force_n, draws, side));
        let (tool, orientation) = (stroke.tool_at(at_s), stroke.orientation_at(at_s));
        let tool = RemoteTool { client, tool, orientation, centre, touching: force_n > 0.0, side };
        Some(GuidingHand { tick, tool, force_n, draws })
    }
}
