//! Guidance as it travels: checked where it arrives, and what a client was told of it.
//!
//! Owns the conversions and the client's own state of being guided or guiding; what is felt is the hand's affair.
//! Invariant: what is accepted of a peer is a way of guiding, a place within reach, a tool that can be, or a profile that a pot can have.

use super::welcome::remote_tool;
use super::{RemoteTool, runs};
use crate::clay::Target;
use crate::haptics::{Guidance, GuidanceMode};
use crate::protocol::{GuidanceEnd, GuidanceWire, HandWire, LeadWire, NoGuidance, Notice, TargetWire, ToolWire};
use crate::tool::{Position, Side};
use crate::units::Tick;

/// Step in which a profile's radii travel, m: a quarter of a metre fits into sixteen bits.
const RADIUS_STEP_M: f32 = 4e-6;

/// A way of guiding as it is sent: strengths are rounded to a percent.
#[must_use]
pub fn guidance_wire(guidance: Guidance) -> GuidanceWire {
    GuidanceWire { mode: guidance.mode().number(), strength: libm::roundf(guidance.strength() * 100.0) as u8 }
}

/// What was sent, if there is such a way.
#[must_use]
pub fn guidance_of(wire: GuidanceWire) -> Option<Guidance> {
    let mode = GuidanceMode::from_number(wire.mode).filter(|_| wire.strength <= 100)?;
    Some(Guidance::new(mode, f32::from(wire.strength) / 100.0))
}

/// A profile as it is sent.
#[must_use]
pub fn target_wire(target: &Target) -> TargetWire {
    let steps = |radius_m: &f32| libm::roundf(radius_m / RADIUS_STEP_M) as u16;
    TargetWire { height_m: target.height_m(), radii: target.radii_m().iter().map(steps).collect() }
}

/// What was sent, if a pot can have it.
#[must_use]
pub fn target_of(wire: &TargetWire) -> Option<Target> {
    let radii: [u16; Target::POINTS] = wire.radii.as_slice().try_into().ok()?;
    Target::new(wire.height_m, radii.map(|steps| f32::from(steps) * RADIUS_STEP_M))
}

/// A hand that guides, as it was heard of.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuidingHand {
    /// When it was there.
    pub tick: Tick,
    /// Whose, which tool, and where.
    pub tool: RemoteTool,
    /// The force that it feels, N.
    pub force_n: f32,
    /// Whether it draws a line on the student's pot.
    pub draws: bool,
}

/// A hand as it is told of.
#[must_use]
pub fn hand_wire(hand: &GuidingHand) -> HandWire {
    let RemoteTool { tool, orientation, centre: Position(centre), .. } = hand.tool;
    let tool = runs::shape_of(tool, orientation);
    let force_mn = libm::roundf(hand.force_n * 1e3) as u16;
    let inside = hand.tool.side == Side::Inside;
    HandWire { tick: hand.tick.0, centre, tool, force_mn, draws: hand.draws, inside }
}

/// Ticks of a room that has been open for thousands of years: there is none.
const TICK_MAX: u64 = 1 << 48;

/// A hand of a client as it is told on; none for a tool or a time that cannot be, or a place that is out of reach.
#[must_use]
pub fn hand_of(client: u16, wire: &HandWire) -> Option<GuidingHand> {
    if wire.tick > TICK_MAX {
        return None;
    }
    let HandWire { centre, tool, draws: touching, inside, .. } = *wire;
    // it is shown and presses nothing
    let tool = remote_tool(&ToolWire { client, centre, tool, touching, inside })?;
    let force_n = f32::from(wire.force_mn) * 1e-3;
    Some(GuidingHand { tick: Tick(wire.tick), tool, force_n, draws: wire.draws })
}

/// Something of guidance that a client was told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GuidanceEvent {
    /// Somebody guides somebody, one of both is this client.
    Begun(GuidancePair),
    /// And no longer.
    Ended(GuidanceEnd),
    /// What this client asked for is not done.
    Refused(NoGuidance),
    /// There is another target, or none any more.
    Target,
}

/// Who guides whom.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuidancePair {
    /// The number of the teacher.
    pub teacher: u16,
    /// The number of the student.
    pub student: u16,
    /// How.
    pub guidance: Guidance,
}

/// Guidance as one client knows it.
#[derive(Clone, Debug, Default)]
pub struct GuidanceView {
    pair: Option<GuidancePair>,
    target: Option<Target>,
    /// The newest place of the hand that guides this client.
    hand: Option<GuidingHand>,
}

impl GuidanceView {
    /// Takes in a notice; says what it tells of guidance, if anything.
    pub(super) fn handle(&mut self, notice: &Notice) -> Option<GuidanceEvent> {
        match notice {
            Notice::Guidance(LeadWire { teacher, student, guidance }) => {
                let pair = GuidancePair { teacher: *teacher, student: *student, guidance: guidance_of(*guidance)? };
                if self.pair.is_none_or(|known| known.teacher != pair.teacher || known.student != pair.student) {
                    self.hand = None;
                }
                self.pair = Some(pair);
                Some(GuidanceEvent::Begun(pair))
            }
            Notice::GuidanceEnded(why) => {
                (self.pair, self.hand) = (None, None);
                Some(GuidanceEvent::Ended(*why))
            }
            Notice::NoGuidance(reason) => Some(GuidanceEvent::Refused(*reason)),
            Notice::Target(target) => {
                self.target = target.as_ref().and_then(target_of);
                Some(GuidanceEvent::Target)
            }
            _ => None,
        }
    }

    /// Takes in the hand that guides this client, with a pulse; true when it is news.
    pub(super) fn hear(&mut self, wire: &HandWire) -> bool {
        let Some(pair) = self.pair else { return false };
        let heard = hand_of(pair.teacher, wire);
        let is_news = heard.is_some_and(|heard| self.hand.is_none_or(|known| heard.tick > known.tick));
        if is_news {
            self.hand = heard;
        }
        is_news
    }

    /// Who guides whom, if one of both is this client.
    #[must_use]
    pub const fn pair(&self) -> Option<&GuidancePair> {
        self.pair.as_ref()
    }

    /// The newest place of the hand that guides this client.
    #[must_use]
    pub const fn hand(&self) -> Option<&GuidingHand> {
        self.hand.as_ref()
    }

    /// What the pot is to become.
    #[must_use]
    pub const fn target(&self) -> Option<&Target> {
        self.target.as_ref()
    }
}
