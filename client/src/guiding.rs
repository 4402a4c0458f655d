//! A person's part in guiding and being guided: what is asked for, what is heard, and what hand and window are told of it.
//!
//! Owns the demonstration and what is drawn on a student's pot; what is felt is the hand's, who may guide is the room's.
//! Invariant: whatever ends guidance, hand and window hear of it, and nothing of it is left.

mod demonstration;

use std::sync::Arc;
use std::time::Duration;

use glam::Vec3;
use pottery_shared::clay::Target;
use pottery_shared::haptics::{Guidance, GuidanceMode};
use pottery_shared::protocol::{GuidanceEnd, NoGuidance, Request};
use pottery_shared::session::{
    Client, GuidanceEvent, GuidancePair, GuidingHand, RemoteTool, guidance_wire, target_wire,
};
use pottery_shared::tool::{Orientation, Position, Side, Tool};
use pottery_shared::units::Tick;

use crate::boundary::{GuideNews, NetSide};
use crate::view::SharedView;

pub use demonstration::Demonstration;

/// Most places of lines that are drawn on a pot; the oldest go.
const LINE_PLACES_MAX: usize = 8192;
/// Places farther apart in time are not joined, ticks.
const LINE_GAP: i64 = 100;
/// Slowest and fastest that a demonstration is played, over its own time.
pub const SPEEDS: (f64, f64) = (0.25, 1.0);

/// What a person asks for.
#[derive(Clone, Debug)]
pub enum GuideCommand {
    /// Guide the hand of a student, by their number, or in another way than before.
    Guide {
        /// The student.
        student: u16,
        /// How.
        guidance: Guidance,
    },
    /// Let go, of the student or of the teacher: the own hand is free at once.
    End,
    /// What everybody's pot is to become, or nothing any more.
    Target(Option<Box<Target>>),
    /// Record the own hand from now on, in place of what was recorded before.
    Record,
    /// Keep what was recorded so far.
    Keep,
    /// Show what was recorded instead of the own hand, so many times as fast as it was made, from a quarter to once.
    Play(f64),
    /// Show the own hand again.
    Halt,
    /// Wipe away what was drawn on the pot.
    Wipe,
}

/// A place of a line that a teacher has drawn on a pot.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LinePlace {
    /// Centre of the tool, in the pot's frame, m.
    pub at_m: Vec3,
    /// Which face of the wall it is on.
    pub side: Side,
    /// Whether the line begins here.
    pub begins: bool,
    /// When it was drawn.
    pub tick: Tick,
}

/// What a window shows of guidance.
#[derive(Clone, Debug, Default)]
pub struct GuidanceShown {
    /// Who guides whom, while the own hand is one of both.
    pub pair: Option<GuidancePair>,
    /// Why it ended, until somebody has taken it.
    pub ended: Option<GuidanceEnd>,
    /// Why what was asked for is not done, until somebody has taken it.
    pub refused: Option<NoGuidance>,
    /// The teacher's hand as it was heard of last; a teacher's own demonstration while it is played.
    pub hand: Option<GuidingHand>,
    /// What was drawn on the pot.
    pub lines: Vec<LinePlace>,
    /// What the pot is to become.
    pub target: Option<Target>,
    /// Whether the own hand is being recorded.
    pub is_recording: bool,
    /// Length of what was recorded, s.
    pub recorded_s: f64,
    /// How far it was shown, s, while it is.
    pub played_s: Option<f64>,
}

/// The worker's part.
#[derive(Debug, Default)]
pub(crate) struct Guiding {
    recording: Option<(Duration, Demonstration)>,
    kept: Option<Arc<Demonstration>>,
    playing: Option<Playing>,
    /// The tool pointed and presses again once it is out of the clay.
    lifts_first: bool,
    /// What the hand was told of the teacher's grip.
    told_grip: Option<(Tool, Orientation)>,
}

#[derive(Debug)]
struct Playing {
    what: Arc<Demonstration>,
    speed: f64,
    began: Duration,
}

impl Playing {
    /// Where in the demonstration it is.
    fn at_s(&self, now: Duration) -> f64 {
        now.saturating_sub(self.began).as_secs_f64() * self.speed
    }
}

impl Guiding {
    /// Does what a person asks for.
    pub(crate) fn command(&mut self, command: GuideCommand, session: &mut Client, view: &SharedView, now: Duration) {
        match command {
            GuideCommand::Guide { student, guidance } => {
                session.request(&Request::Guide { student, guidance: guidance_wire(guidance) });
            }
            GuideCommand::End => session.request(&Request::EndGuidance),
            GuideCommand::Target(target) => session.request(&Request::Target(target.as_deref().map(target_wire))),
            GuideCommand::Record => {
                self.playing = None;
                self.recording = Some((now, Demonstration::default()));
            }
            GuideCommand::Keep => self.keep(),
            GuideCommand::Play(speed) => {
                self.keep();
                let speed = if speed.is_nan() { SPEEDS.1 } else { speed.clamp(SPEEDS.0, SPEEDS.1) };
                self.playing = self.kept.clone().map(|what| Playing { what, speed, began: now });
            }
            GuideCommand::Halt => self.playing = None,
            GuideCommand::Wipe => view.lock().guidance.lines.clear(),
        }
    }

    fn keep(&mut self) {
        if let Some((_, demonstration)) = self.recording.take().filter(|(_, made)| !made.is_empty()) {
            self.kept = Some(Arc::new(demonstration));
        }
    }

    /// Takes in what was told of guidance.
    pub(crate) fn hear(&mut self, event: GuidanceEvent, session: &Client, side: &mut NetSide, view: &SharedView) {
        match event {
            GuidanceEvent::Begun(pair) if pair.student == session.number() => {
                self.tell(side, GuideNews::Guided(Some(pair.guidance)));
                let mut view = view.lock();
                if view.guidance.pair.is_none_or(|known| known.teacher != pair.teacher) {
                    view.guidance.lines.clear();
                }
                (view.guidance.pair, view.guidance.ended) = (Some(pair), None);
            }
            GuidanceEvent::Begun(pair) => {
                let is_felt = pair.guidance.mode() != GuidanceMode::Point;
                self.tell(side, GuideNews::Leads(is_felt));
                side.status().point(!is_felt || sits_beside(session, pair.student));
                self.lifts_first = false;
                let mut view = view.lock();
                (view.guidance.pair, view.guidance.ended) = (Some(pair), None);
            }
            GuidanceEvent::Ended(why) => {
                // before the pair is gone, so that whoever looks knows whose end it is
                view.lock().guidance.ended = Some(why);
                self.forget(side, view);
            }
            GuidanceEvent::Refused(reason) => view.lock().guidance.refused = Some(reason),
            GuidanceEvent::Target => view.lock().guidance.target = session.guidance().target().cloned(),
        }
    }

    /// Forgets that anybody is guided, since it has ended, or the connection has.
    pub(crate) fn forget(&mut self, side: &mut NetSide, view: &SharedView) {
        (self.playing, self.told_grip) = (None, None);
        // should the ring be full, the hand lets go all the same
        side.status().end_guidance();
        self.tell(side, GuideNews::Guided(None));
        self.tell(side, GuideNews::Leads(false));
        // a tool that points in the clay is not to press it now
        self.lifts_first = side.status().is_pointing();
        let mut view = view.lock();
        (view.guidance.pair, view.guidance.hand) = (None, None);
        view.guidance.lines.clear();
    }

    fn tell(&self, side: &mut NetSide, news: GuideNews) {
        if !side.tell(news) {
            tracing::debug!(?news, "the hand does not listen");
        }
    }

    /// Hands the teacher's newest place on to the student's hand and window.
    pub(crate) fn hear_hand(&mut self, session: &Client, side: &mut NetSide, view: &SharedView) {
        let Some(hand) = session.guidance().hand() else { return };
        let grip = (hand.tool.tool, hand.tool.orientation);
        if self.told_grip.replace(grip) != Some(grip) {
            self.tell(side, GuideNews::TeachersGrip(grip.0, grip.1));
        }
        self.tell(side, GuideNews::Teacher(hand.tick, hand.tool.centre.point_m()));
        let mut view = view.lock();
        view.guidance.hand = Some(*hand);
        draw(&mut view.guidance.lines, hand, session);
    }

    /// Records the own hand, and shows it, or what was recorded, to the student whom it guides.
    pub(crate) fn pass(&mut self, session: &mut Client, side: &NetSide, view: &SharedView, now: Duration) {
        let tick = Tick(0).offset(now.as_millis() as i64 + session.tick_offset());
        let own = own_hand(session.number(), side, tick);
        if self.lifts_first && own.is_none_or(|own| !own.tool.touching) {
            self.lifts_first = false;
            side.status().point(false);
        }
        if let (Some((began, recording)), Some(hand)) = (&mut self.recording, &own) {
            if recording.is_empty() {
                *began = now;
            }
            recording.push((now - *began).as_secs_f64(), hand);
        }
        self.playing.take_if(|playing| playing.at_s(now) > playing.what.length_s());
        let played = self.playing.as_ref().map(|playing| (playing, playing.at_s(now)));
        let leads = session.guidance().pair().is_some_and(|pair| pair.teacher == session.number());
        let shown = match played {
            Some((playing, at_s)) => playing.what.at(at_s, session.number(), tick),
            None => own,
        };
        {
            let mut view = view.lock();
            let guidance = &mut view.guidance;
            guidance.is_recording = self.recording.is_some();
            let recorded = self.recording.as_ref().map(|(_, made)| made.length_s());
            guidance.recorded_s = recorded.or(self.kept.as_ref().map(|kept| kept.length_s())).unwrap_or_default();
            guidance.played_s = played.map(|(_, at_s)| at_s);
            if leads {
                guidance.hand = shown.filter(|_| played.is_some());
                if let Some(hand) = &shown {
                    draw(&mut guidance.lines, hand, session);
                }
            }
        }
        if let Some(shown) = shown.filter(|_| leads) {
            session.show_hand(&shown);
        }
    }
}

/// Whether a student works at the same wheel.
fn sits_beside(session: &Client, student: u16) -> bool {
    let own = session.class().place().map(|place| place.wheel);
    let other = session.class().people().find(|person| person.client == student).map(|person| person.wheel);
    // who is not known is told of to those at the same wheel first
    other.is_none() || own == other
}

/// Where the own hand is, while it holds a tool.
fn own_hand(client: u16, side: &NetSide, tick: Tick) -> Option<GuidingHand> {
    let status = side.status();
    let centre = Position::nearest(status.tool_m()?)?;
    let (tool, orientation) = status.grip()?;
    let touching = status.elements() > 0;
    let draws = touching && status.is_pointing();
    let tool = RemoteTool { client, tool, orientation, centre, touching, side: status.side() };
    Some(GuidingHand { tick, tool, force_n: status.force_n(), draws })
}

/// Goes on with the line on the pot, if the hand draws one.
fn draw(lines: &mut Vec<LinePlace>, hand: &GuidingHand, session: &Client) {
    if !hand.draws {
        return;
    }
    let at_m = session.conditions().phase(hand.tick).pot_from_room(hand.tool.centre.point_m());
    let side = hand.tool.side;
    // over the rim no line goes on
    let begins = lines.last().is_none_or(|last| hand.tick.since(last.tick) > LINE_GAP || last.side != side);
    if lines.len() == LINE_PLACES_MAX {
        lines.drain(..LINE_PLACES_MAX / 8);
    }
    lines.push(LinePlace { at_m, side, begins, tick: hand.tick });
}
