//! The client's end of a connection: from the greeting to the clay that is held and predicted.
//!
//! Owns the replica, the predictor, the lead and what is still to be sent.
//! Invariant: after [`Client::rebase`], prediction stands on the newest confirmed clay that is whole.

mod incoming;

use alloc::collections::VecDeque;
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::time::Duration;

use super::assembly::Assembly;
use super::course::{Course, Implausible};
use super::effort::Effort;
use super::lead::Lead;
use super::mending::{MendCounts, Mending};
use super::redundancy::Redundancy;
use super::retelling::UNLIKE_MAX;
use super::welcome::{conditions_of, pot_of};
use super::{
    BringError, ClassView, ClientError, ClientEvent, GuidanceView, GuidingHand, PutError, RemoteTool, StepCounts,
    greeting, hand_wire, mesh_of, putting, runs, tool_of, with_one_more,
};
use crate::clay::{Conditions, Form, Pot, SubStep};
use crate::prediction::{Patch, Predictor};
use crate::protocol::{self, HandWire, Hello, Inputs, MeshWire, Notice, Pass, Purpose, Request, StepsWire, Upload};
use crate::snapshot::{PotRecord, Replica, SnapshotClock, Touched};
use crate::tool::{ConvexTool, Shape, ToolSample};
use crate::units::Tick;

/// Bytes that a datagram keeps free for the own hand.
const HAND_BYTES_MAX: usize = 48;

/// A client that was let in.
#[derive(Debug)]
pub struct Client {
    number: u16,
    conditions: Conditions,
    replica: Replica,
    predictor: Predictor,
    lead: Lead,
    course: Course,
    redundancy: Redundancy,
    assembly: Assembly,
    tools: Vec<RemoteTool>,
    tools_tick: Tick,
    steps: StepsWire,
    /// Tiles in which the replica changed since the last rebase.
    news: Touched,
    /// The tick of the replica's clay, when prediction does not stand on it yet.
    confirmed: Option<Tick>,
    /// Tiles in which the predicted clay changed since the caller last asked.
    changed: Touched,
    control: VecDeque<Vec<u8>>,
    events: VecDeque<ClientEvent>,
    /// Number of the first own sample never sent.
    unsent: u32,
    acknowledged: u32,
    /// Number of the first own sample that the server has not taken yet, by its newest word.
    awaited: u32,
    progress_at: Duration,
    repeated_at: Duration,
    /// When samples were sent, and when some of them were new.
    sent_at: Duration,
    news_sent_at: Duration,
    /// When it last asked to be told again.
    asked_at: Duration,
    round_trip: Duration,
    behind: Option<incoming::Behind>,
    mismatches: u64,
    mending: Mending,
    repeats: u64,
    resyncs: u64,
    /// The tool that was brought last.
    brought: Option<MeshWire>,
    /// Presses again what others tell.
    substep: SubStep,
    retells: bool,
    effort: Effort,
    /// Notices heard, those before the welcome included.
    told: u32,
    counts: StepCounts,
    class: ClassView,
    guidance: GuidanceView,
    /// Where the own hand is, while it guides another, until it was sent.
    hand: Option<HandWire>,
}

impl Client {
    /// Silence about own samples after which everything unacknowledged is sent again.
    const REPEAT_AFTER: Duration = Duration::from_millis(150);
    /// How much longer than a round trip an answer may take until everything is said again another time.
    const REPEAT_MORE: Duration = Duration::from_millis(50);
    /// How long, and how often, a hand's last samples are said again when no others follow that would carry them: a burst of losses
    /// ends, and who waits for an answer waits a way and back.
    const LAST_FOR: Duration = Duration::from_millis(100);
    const LAST_EVERY: Duration = Duration::from_millis(10);
    /// Time between two datagrams that say nothing else than that.
    const AGAIN_EVERY: Duration = Duration::from_millis(20);

    /// The first frame to send. A client that `retells` gets what was pressed and presses it again, which takes a tenth of
    /// the bytes that changed tiles do, and time.
    #[must_use]
    pub fn greeting(code: &str, wheel: u16, retells: bool) -> Vec<u8> {
        let purpose = Purpose::Works { retells };
        greeting(&Hello { code: String::from(code), wheel, purpose, pass: Pass::None })
    }

    /// The session that the server's first frame opens.
    ///
    /// `local` is the client's own count of ticks now, `round_trip` the measured one; both set the first lead.
    ///
    /// # Errors
    /// [`ClientError`] when the server refuses or cannot be understood.
    pub fn open(answer: &[u8], local: u64, round_trip: Duration) -> Result<Self, ClientError> {
        let welcome = match protocol::decode::<{ protocol::CONTROL_MAX }, Notice>(answer)? {
            Notice::Welcome(welcome) => welcome,
            Notice::Refused(refusal) => return Err(refusal.into()),
            Notice::Waiting => return Err(ClientError::Waiting),
            _ => return Err(protocol::ProtocolError::Malformed { bytes: answer.len() }.into()),
        };
        let pot = pot_of(&welcome.pot, welcome.method).map_err(|error| ClientError::Pot(alloc::format!("{error}")))?;
        let substep = SubStep::for_grid(pot.spec().shape);
        let replica = Replica::new(pot);
        // a room that has been open for thousands of years is none
        if welcome.now > 1 << 48 {
            return Err(protocol::ProtocolError::Malformed { bytes: answer.len() }.into());
        }
        let now = Tick(welcome.now);
        let clock = SnapshotClock::with_ahead(welcome.ahead);
        let clock = clock.ok_or(protocol::ProtocolError::Malformed { bytes: answer.len() })?;
        let changed = Touched::none(replica.pot().surfaces().iter().map(crate::clay::Surface::shape));
        let ahead = round_trip.as_millis() as u64 + 25;
        Ok(Self {
            number: welcome.client,
            conditions: conditions_of(&welcome),
            predictor: Predictor::new(&replica, now, clock),
            replica,
            lead: Lead::new(local, now, ahead),
            course: Course::since(now, local),
            redundancy: Redundancy::default(),
            assembly: Assembly::default(),
            tools: Vec::new(),
            tools_tick: Tick(0),
            steps: StepsWire::default(),
            news: changed.clone(),
            confirmed: None,
            changed,
            control: VecDeque::new(),
            events: VecDeque::new(),
            unsent: 0,
            acknowledged: 0,
            awaited: 0,
            progress_at: Duration::ZERO,
            repeated_at: Duration::ZERO,
            sent_at: Duration::ZERO,
            asked_at: Duration::ZERO,
            news_sent_at: Duration::ZERO,
            round_trip,
            behind: None,
            mismatches: 0,
            mending: Mending::default(),
            repeats: 0,
            resyncs: 0,
            brought: None,
            substep,
            retells: true,
            effort: Effort::default(),
            told: welcome.told,
            counts: StepCounts::default(),
            class: ClassView::default(),
            guidance: GuidanceView::default(),
            hand: None,
        })
    }

    /// Its number in the room.
    #[must_use]
    pub const fn number(&self) -> u16 {
        self.number
    }

    /// What it knows of the lesson.
    #[must_use]
    pub const fn class(&self) -> &ClassView {
        &self.class
    }

    /// What it knows of hands that guide, and of what the pot is to become.
    #[must_use]
    pub const fn guidance(&self) -> &GuidanceView {
        &self.guidance
    }

    /// Says with the next datagram where the own hand is, which guides another.
    pub fn show_hand(&mut self, hand: &GuidingHand) {
        self.hand = Some(hand_wire(hand));
    }

    /// The confirmed clay.
    #[must_use]
    pub const fn replica(&self) -> &Replica {
        &self.replica
    }

    /// Brings a patch up to the predicted clay, with what it is predicted under.
    pub fn patch_into(&self, patch: &mut Patch) {
        patch.field.copy_from(self.predictor.field());
        patch.conditions.clone_from(&self.conditions);
        patch.rack = self.predictor.rack();
    }

    /// A patch of its own.
    #[must_use]
    pub fn patch(&self) -> Patch {
        let (field, conditions) = (self.predictor.field().clone(), self.conditions.clone());
        Patch { field, conditions, rack: self.rack() }
    }

    /// The predicted clay.
    #[must_use]
    pub const fn predicted(&self) -> &Pot {
        self.predictor.field().pot()
    }

    /// Wheel, material and method.
    #[must_use]
    pub const fn conditions(&self) -> &Conditions {
        &self.conditions
    }

    /// The convex tools of the wheel, by their number.
    #[must_use]
    pub fn rack(&self) -> Arc<[ConvexTool]> {
        self.predictor.rack()
    }

    /// What to add to a local tick to get the tick to stamp.
    #[must_use]
    pub const fn tick_offset(&self) -> i64 {
        self.lead.offset()
    }

    /// Everybody's tools, the client's own included.
    #[must_use]
    pub fn tools(&self) -> &[RemoteTool] {
        &self.tools
    }

    /// The tick of which [`Client::tools`] tells.
    #[must_use]
    pub const fn tools_tick(&self) -> Tick {
        self.tools_tick
    }

    /// Digests that did not match; each was mended.
    #[must_use]
    pub const fn mismatches(&self) -> u64 {
        self.mismatches
    }

    /// How clay that differed was mended.
    #[must_use]
    pub const fn mend_counts(&self) -> &MendCounts {
        self.mending.counts()
    }

    /// What the server said that cannot be true, and was refused.
    #[must_use]
    pub const fn implausible(&self) -> &Implausible {
        self.course.refused()
    }

    /// How the replica came to its snapshots.
    #[must_use]
    pub const fn step_counts(&self) -> &StepCounts {
        &self.counts
    }

    /// Whether it asks for what was pressed, and presses it again.
    #[must_use]
    pub const fn retells(&self) -> bool {
        self.retells
    }

    /// Asks for what was pressed, or for the tiles that changed, from now on; what is under way is taken in either way.
    pub fn retell(&mut self, retells: bool) {
        if self.retells != retells {
            self.retells = retells;
            self.request(&Request::Retell { retells });
            if !retells {
                // deltas build upon deltas
                self.resync(self.replica.version());
            }
        }
    }

    /// Takes in how long the caller's last [`Client::handle_datagram`] took: a client that spends more than a third of its
    /// time there asks for deltas, and tries again after half a minute.
    pub fn handle_effort(&mut self, spent: Duration, now: Duration) {
        if let Some(retells) = self.effort.handle(spent, now)
            && self.counts.unlike < UNLIKE_MAX
        {
            self.retell(retells);
        }
    }

    /// How often it asked to be told again what was lost.
    #[must_use]
    pub const fn repeats(&self) -> u64 {
        self.repeats
    }

    /// How often it asked for a keyframe.
    #[must_use]
    pub const fn resyncs(&self) -> u64 {
        self.resyncs
    }

    /// Whether every own sample has been confirmed, the newest known snapshot is held and prediction stands on it.
    #[must_use]
    pub fn is_settled(&self) -> bool {
        let is_latest = !self.mending.is_waiting() && self.course.latest() <= self.replica.version();
        !self.needs_rebase() && self.predictor.pending().is_empty() && is_latest
    }

    /// Moves the tiles in which the predicted clay changed since the last call into `changed`.
    pub fn take_changed(&mut self, changed: &mut Touched) {
        changed.add_all(&self.changed);
        self.changed.clear();
    }

    /// Takes in one of the client's own samples; false when it was dropped, since it would not count, is not later than the
    /// last one, or too many are unacknowledged.
    pub fn handle_sample(&mut self, sample: ToolSample) -> bool {
        let can_take = self.class.may_press() && self.predictor.can_take(&sample);
        if can_take {
            self.predictor.handle_sample(sample, &self.conditions, &mut self.changed);
        }
        can_take
    }

    /// Takes in a control frame.
    ///
    /// # Errors
    /// [`ClientError`] when it makes no sense; the connection is then useless.
    pub fn handle_control(&mut self, frame: &[u8]) -> Result<(), ClientError> {
        match protocol::decode::<{ protocol::CONTROL_MAX }, Notice>(frame)? {
            Notice::Wheel { from, rate } => {
                self.told = self.told.wrapping_add(1);
                self.conditions.wheel.schedule(Tick(from), rate);
                self.events.push_back(ClientEvent::Conditions);
            }
            Notice::Clay { from, clay } => {
                self.told = self.told.wrapping_add(1);
                self.conditions.material.set(Tick(from), clay.into());
                self.events.push_back(ClientEvent::Conditions);
            }
            Notice::Tool { shape, mesh } => self.hang(shape, &mesh)?,
            Notice::NoTool(reason) => {
                self.brought = None;
                self.events.push_back(ClientEvent::NotBrought(reason));
            }
            Notice::Steps(steps) => {
                self.steps = steps;
                self.events.push_back(ClientEvent::Steps);
            }
            Notice::NoStep(reason) => self.events.push_back(ClientEvent::NoStep(reason)),
            Notice::Closing => self.events.push_back(ClientEvent::Closing),
            Notice::Refused(refusal) => return Err(refusal.into()),
            Notice::Welcome(_) | Notice::Audience(_) | Notice::Waiting => {
                return Err(protocol::ProtocolError::Malformed { bytes: frame.len() }.into());
            }
            notice => match self.guidance.handle(&notice) {
                Some(event) => self.events.push_back(ClientEvent::Guidance(event)),
                None => self.events.extend(self.class.handle(notice).map(ClientEvent::Class)),
            },
        }
        Ok(())
    }

    /// Hangs a tool in the rack under the next number; one that hangs there already is only told of once more.
    fn hang(&mut self, shape: u8, mesh: &MeshWire) -> Result<(), ClientError> {
        let rack = self.predictor.rack();
        if usize::from(shape) > rack.len() {
            return Err(protocol::ProtocolError::Malformed { bytes: mesh.facets.len() }.into());
        }
        if usize::from(shape) == rack.len() {
            let tool = tool_of(mesh).map_err(|fault| ClientError::Tool { shape, fault })?;
            let mut rack = with_one_more(&rack, tool);
            self.predictor.set_rack(Arc::clone(&rack));
            self.substep.swap_rack(&mut rack);
            self.told = self.told.wrapping_add(1);
            self.events.push_back(ClientEvent::Rack);
        }
        if self.brought.as_ref() == Some(mesh) {
            self.brought = None;
            self.events.push_back(ClientEvent::Brought(Shape(shape)));
        }
        Ok(())
    }

    /// Asks the server to hang a tool in the wheel's rack; [`ClientEvent::Brought`] or [`ClientEvent::NotBrought`] answers.
    ///
    /// # Errors
    /// [`BringError`] when it cannot be shared; nothing is asked then.
    pub fn bring(&mut self, tool: &ConvexTool) -> Result<(), BringError> {
        let mesh = mesh_of(tool)?;
        self.brought = Some(mesh.clone());
        self.request(&Request::Tool { mesh });
        Ok(())
    }

    /// What can be undone and redone, as last heard of.
    #[must_use]
    pub const fn steps(&self) -> &StepsWire {
        &self.steps
    }

    /// Asks for the newest own stroke to be undone, with all that was pressed of it so far; [`ClientEvent::Steps`] or
    /// [`ClientEvent::NoStep`] answers.
    pub fn undo(&mut self) {
        let held = self.predictor.last_tick().0;
        self.request(&Request::Undo { held });
    }

    /// Asks for what was undone last to be redone.
    pub fn redo(&mut self) {
        let held = self.predictor.last_tick().0;
        self.request(&Request::Redo { held });
    }

    /// Asks for new clay for everybody, in a form or as the wheel began; it can be undone as a stroke.
    pub fn begin_anew(&mut self, form: Option<Form>) {
        let held = self.predictor.last_tick().0;
        self.request(&Request::NewPot { held, form: form.map_or(0, Form::number) });
    }

    /// Asks for a pot to be put on the wheel for everybody; it can be undone as a stroke.
    ///
    /// # Errors
    /// [`PutError`] when it would be another pot there; nothing is asked then.
    pub fn put(&mut self, record: &PotRecord) -> Result<(), PutError> {
        let fitted = putting::fitted(record, self.predicted().spec())?;
        let held = self.predictor.last_tick().0;
        putting::requests(&fitted, held).for_each(|request| self.request(&request));
        Ok(())
    }

    /// Whether clay was confirmed on which prediction does not stand yet.
    #[must_use]
    pub const fn needs_rebase(&self) -> bool {
        self.confirmed.is_some()
    }

    /// Puts prediction on the newest confirmed clay: the costly part of a confirmation, its time chosen by the caller.
    pub fn rebase(&mut self) {
        let Some(tick) = self.confirmed.take() else { return };
        let correction = self.predictor.handle_confirmed(
            &self.replica,
            tick,
            self.acknowledged,
            &self.conditions,
            &self.news,
            &mut self.changed,
        );
        self.news.clear();
        self.events.push_back(ClientEvent::Confirmed(correction));
    }

    /// Asks the server for something.
    pub fn request(&mut self, request: &Request) {
        self.control.push_back(protocol::frame(&protocol::encode(request)));
    }

    /// The next control frame to send.
    pub fn poll_control(&mut self) -> Option<Vec<u8>> {
        self.control.pop_front()
    }

    /// The next thing that happened.
    pub fn poll_event(&mut self) -> Option<ClientEvent> {
        self.events.pop_front()
    }

    /// The next datagram of samples to send; ask again until there is none.
    pub fn poll_datagram(&mut self, now: Duration) -> Option<Vec<u8>> {
        // a hand makes a thousand samples a second
        let rests = self.unsent == self.predictor.next_sequence() && now > self.news_sent_at;
        let inputs = self.poll_inputs(now, rests);
        let (hand, again) = (self.hand.take(), self.again(now));
        let asks = again.is_some() && now.saturating_sub(self.asked_at) >= Self::AGAIN_EVERY;
        let nothing =
            || (hand.is_some() || asks).then(|| Inputs { first: self.unsent as u16, runs: Vec::new(), rests });
        let inputs = inputs.or_else(nothing)?;
        if again.is_some() {
            self.asked_at = now;
        }
        Some(protocol::encode(&Upload { inputs, hand, again }))
    }

    fn poll_inputs(&mut self, now: Duration, rests: bool) -> Option<Inputs> {
        let pending = self.predictor.pending();
        let (oldest, newest) = (pending.front()?.sequence, pending.back()?.sequence);
        // an answer to what was said again takes a round trip
        let is_silent = now.saturating_sub(self.progress_at) >= Self::REPEAT_AFTER
            && now.saturating_sub(self.repeated_at) >= Self::REPEAT_AFTER.max(self.round_trip + Self::REPEAT_MORE);
        let anything_unsent = (newest.wrapping_sub(self.unsent) as i32) >= 0;
        if anything_unsent {
            self.news_sent_at = now;
        }
        let is_last = now.saturating_sub(self.news_sent_at) <= Self::LAST_FOR
            && now.saturating_sub(self.sent_at) >= Self::LAST_EVERY;
        let mut again = 0;
        let mut start = if is_silent {
            self.repeated_at = now;
            self.redundancy.handle_silence(now);
            // the server waits for what is missing, so all that follows was in vain too
            self.unsent = oldest;
            if (oldest.wrapping_sub(self.awaited) as i32) > 0 {
                // it said once that it had them, and they are gone here: it is to go on without them
                return Some(runs::nothing(self.awaited, oldest.wrapping_sub(self.awaited)));
            }
            oldest
        } else if anything_unsent {
            let behind_oldest = (self.unsent.wrapping_sub(oldest) as i32).max(0) as u32;
            again = self.redundancy.samples(now).min(behind_oldest);
            if behind_oldest == 0 { oldest } else { self.unsent.wrapping_sub(again) }
        } else if is_last {
            oldest
        } else {
            return None;
        };
        self.sent_at = now;
        let packed = loop {
            let skip = start.wrapping_sub(oldest) as usize;
            let packed = runs::pack(pending.iter().skip(skip), protocol::DATAGRAM_MAX - 16 - HAND_BYTES_MAX);
            if again == 0 || packed.bytes <= Redundancy::BYTES {
                break packed;
            }
            let fewer = again.div_ceil(8);
            again -= fewer;
            start = start.wrapping_add(fewer);
        };
        let mut inputs = packed.inputs;
        let end = start.wrapping_add(packed.count);
        inputs.rests = rests && end == newest.wrapping_add(1);
        if (end.wrapping_sub(self.unsent) as i32) > 0 {
            self.unsent = end;
        }
        Some(inputs)
    }
}
