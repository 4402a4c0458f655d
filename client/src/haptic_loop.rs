//! One tick of the hand, the turns between two of them, and the real-time thread that makes 1000 ticks a second.
//!
//! The tick takes no lock, allocates nothing and never panics; when it is due is `pacing`'s. Knows no network: clay comes
//! and samples go over the boundary.
//! Invariant: on any fault the force is zero within the tick.

use std::time::{Duration, Instant};

use glam::Vec3;
use hdrhistogram::Histogram;
use pottery_shared::clay::{Contact, MethodKind};
use pottery_shared::haptics::{Haptics, Setup, Touch, Wet};
use pottery_shared::prediction::Hand;
use pottery_shared::tool::{Orientation, Position, Tool, ToolSample};
use pottery_shared::units::{Seconds, Tick};

use crate::boundary::{GuideNews, HandSide};
use crate::device::Device;
use crate::pacing::{LoopRate, Pacing, Spin, wait_for};
use crate::sound::Rub;

/// Ticks in which a tool in the air has not moved, nor the clay, before that counts as nothing to be felt.
const STILL_TICKS: u32 = 500;
/// Ticks between two samples of a tool that rests so: half of those after which a wheel shows it to nobody any more.
const RESTING_TICKS: i64 = 250;
/// Longest time that the histograms tell apart, ns: a second.
const NS_MAX: u64 = 1_000_000_000;
/// Own samples replayed on a patch in one tick, besides the tick's own.
const CATCH_UP_BUDGET: usize = 4;
/// News of a teacher taken in in one turn: they come some sixty times a second.
const NEWS_BUDGET: usize = 8;

/// A tool, and how it is turned.
type Grip = (Tool, Orientation);

/// Everything one hand needs in its thread.
pub struct HapticLoop {
    device: Box<dyn Device>,
    hand: Hand,
    haptics: Haptics,
    rate: LoopRate,
    spin: Spin,
    side: HandSide,
    catching_up: bool,
    last_stamp: Option<Tick>,
    /// Of which connection that is, counted as [`crate::boundary::Status`] does.
    sessions: u32,
    /// The teacher's tool and how it is turned, as last heard of.
    teachers_grip: Option<Grip>,
    /// The local tick in which the last sample was pressed, and where, while a tool is in the hand.
    last_pressed: Option<(u64, Position)>,
    /// The last turn, counted at the loop's rate.
    last_turn: u64,
    /// Whether no tool was in the hand in the last turn, so that there is nothing to be felt.
    is_empty: bool,
    /// Ticks for which the tool has been where it is, in the air, while the clay stood still.
    still_ticks: u32,
    /// The sample that was sent last, while a tool is in the hand, and what a tool that rests would have sent since.
    sent: Option<ToolSample>,
    withheld: Option<ToolSample>,
    felt: Felt,
    force_mn: Histogram<u64>,
}

impl std::fmt::Debug for HapticLoop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HapticLoop").field("side", &self.side).finish_non_exhaustive()
    }
}

/// What the hand feels in a tick.
#[derive(Clone, Copy, Debug, Default)]
struct Felt {
    force_n: Vec3,
    elements: u32,
    rub: Rub,
}

/// What the thread measured.
#[derive(Clone, Debug)]
pub struct HapticReport {
    /// Ticks done.
    pub ticks: u64,
    /// Ticks that began more than [`Pacing::LATE`] after their deadline.
    pub late_ticks: u64,
    /// Deadlines that went by while a tick was still at work.
    pub missed_ticks: u64,
    /// Samples lost because the ring was full.
    pub lost_samples: u64,
    /// Part of a wait that was spun at the end, since sleep ends late on this machine.
    pub spun: Duration,
    /// Time from one tick's begin to the next one's, ns.
    pub period_ns: Histogram<u64>,
    /// Time a tick took, ns.
    pub step_ns: Histogram<u64>,
    /// Force on the hand while it touched clay, mN.
    pub force_mn: Histogram<u64>,
}

fn histogram(highest: u64) -> Histogram<u64> {
    Histogram::new_with_bounds(1, highest, 3).expect("three digits over this range are valid bounds")
}

impl HapticLoop {
    /// Ticks of which one is done while there is nothing to be felt: a tool that comes is in the hand long before it is at the clay, and as far
    /// apart samples still make one stroke. A hand that starts from rest with an acceleration a comes no deeper before it is felt than
    /// ½·a·(4·T)² = 2·v·T, with a tick T and its speed v by then, which is what a contact may jump by at any time.
    pub const IDLE_TICKS: u64 = 4;

    /// Ticks after which a tool whose samples tell the same place has not rested there, but was away: a wheel shows it to nobody any more.
    pub(crate) const SHOWN_TICKS: i64 = 2 * RESTING_TICKS;

    /// A hand with `device` on its side of the boundary.
    #[must_use]
    pub fn new(device: Box<dyn Device>, mut side: HandSide) -> Self {
        let hand = Hand::new(side.patches.read().clone());
        let haptics = Haptics::new(device.setup(hand.method().felt_share()));
        Self {
            device,
            hand,
            haptics,
            rate: LoopRate::default(),
            spin: Spin::default(),
            side,
            catching_up: false,
            last_stamp: None,
            sessions: 0,
            teachers_grip: None,
            last_pressed: None,
            last_turn: 0,
            is_empty: false,
            still_ticks: 0,
            sent: None,
            withheld: None,
            felt: Felt::default(),
            force_mn: histogram(1_000_000),
        }
    }

    /// The same at another rate: the ticks, the samples and the clay stay as they are, and between two ticks the force follows the
    /// device as well.
    #[must_use]
    pub fn at(mut self, rate: LoopRate) -> Self {
        self.rate = rate;
        self.haptics = Haptics::new(self.setup());
        self
    }

    /// How the chain is set up for the device that is there now.
    fn setup(&self) -> Setup {
        let period = Seconds(self.rate.period().as_secs_f32());
        Setup { period, ..self.device.setup(self.hand.method().felt_share()) }
    }

    /// The hand and its clay.
    #[must_use]
    pub const fn hand(&self) -> &Hand {
        &self.hand
    }

    /// Does the tick of local number `local`: sample, follow, press, force, send; then a few steps towards the newest patch.
    pub fn tick(&mut self, local: u64) {
        let (reported, grip, dt) = self.read(local * self.rate.turns_a_tick());
        let sessions = self.side.status.sessions();
        if std::mem::replace(&mut self.sessions, sessions) != sessions {
            self.last_stamp = None;
            self.hand.begin_session();
        }
        let stamp = Tick(0).offset(local as i64 + self.side.status.tick_offset());
        self.follow_teacher(stamp, dt);
        match (self.haptics.accept(reported, self.device.velocity(), dt), self.last_stamp) {
            // the lead went back by a tick, whose sample is made already: the hand feels on, as between two ticks
            (Some(centre), Some(last)) if stamp <= last => {
                self.felt.force_n = self.feel(last.offset(1), grip, centre).0;
            }
            (Some(centre), _) => {
                self.last_stamp = Some(stamp);
                self.felt = match self.side.status.is_pointing() {
                    true => self.point(stamp, grip, centre),
                    false => self.press(stamp, grip, centre, local),
                };
            }
            (None, _) => self.let_go(),
        }
        self.side.status.note_rub(self.felt.rub);
        self.give();
        self.side.status.note_tool(self.haptics.tool_m().or(reported));
        self.side.status.note_grip(grip.0, grip.1);
        self.side.status.note_side(self.hand.worked_side().unwrap_or_default());
        let newtons = self.felt.force_n.length();
        if self.felt.elements > 0 {
            self.force_mn.saturating_record((newtons * 1e3) as u64);
        }
        self.side.status.note_tick(newtons, self.felt.elements, self.haptics.fault());
        self.side.status.note_guided(self.haptics.guided());
        self.catch_up();
    }

    /// Takes in what is heard of a teacher; who has ended guidance does not wait for anybody to agree.
    fn follow_teacher(&mut self, stamp: Tick, dt: Seconds) {
        for _ in 0..NEWS_BUDGET {
            match self.side.guide.pop() {
                Ok(GuideNews::Guided(guidance)) => self.haptics.guide(guidance),
                Ok(GuideNews::Leads(leads)) => self.haptics.lead(leads),
                Ok(GuideNews::Teacher(tick, at_m)) => self.haptics.hear_teacher(tick, at_m),
                Ok(GuideNews::TeachersGrip(tool, orientation)) => self.teachers_grip = Some((tool, orientation)),
                Err(_) => break,
            }
        }
        if self.side.status.is_unguided() && self.haptics.guided().is_some() {
            self.haptics.guide(None);
        }
        self.haptics.follow_teacher(stamp, dt);
    }

    /// Does a turn of the loop, counted at its rate: a tick, or what lies between two.
    pub fn turn(&mut self, turn: u64) {
        let turns = self.rate.turns_a_tick();
        if turn.is_multiple_of(turns) { self.tick(turn / turns) } else { self.between(turn) }
    }

    /// Reads the device between two ticks and gives the force of the clay as it is.
    fn between(&mut self, turn: u64) {
        let (reported, grip, dt) = self.read(turn);
        if let Some(last) = self.last_stamp {
            self.follow_teacher(last, dt);
        }
        match (self.haptics.accept(reported, self.device.velocity(), dt), self.last_stamp) {
            // nothing was pressed yet, and nothing is felt
            (Some(_), None) => {}
            (Some(centre), Some(last)) => self.felt.force_n = self.feel(last.offset(1), grip, centre).0,
            (None, _) => self.let_go(),
        }
        self.give();
    }

    /// What the device reports, unless the tool is to be lifted; the grip, and the time since the last turn.
    fn read(&mut self, turn: u64) -> (Option<Vec3>, Grip, Seconds) {
        let period_s = self.rate.period().as_secs_f64();
        let dt = Seconds((turn.saturating_sub(self.last_turn).max(1) as f64 * period_s) as f32);
        self.last_turn = turn;
        let turns = self.rate.turns_a_tick() as f64;
        let reported = self.device.position(turn as f64 / turns * 1e-3).filter(|_| !self.side.status.is_lifted());
        if self.device.is_another() {
            self.haptics.set_up(self.setup());
        }
        // a tool that is still on its way to this hand is not in it
        let grip = self.grip();
        let reported = reported.filter(|_| self.hand.holds(grip.0));
        self.is_empty = reported.is_none();
        (reported, grip, dt)
    }

    /// What is pressed with: the own tool, or that of a teacher who has taken over.
    fn grip(&self) -> Grip {
        let own = (self.device.tool(), self.device.orientation());
        let teachers = self.teachers_grip.filter(|(tool, _)| self.haptics.is_taken_over() && self.hand.holds(*tool));
        teachers.unwrap_or(own)
    }

    fn let_go(&mut self) {
        self.hand.put_down();
        self.felt = Felt::default();
        self.put_away();
    }

    /// Forgets where the tool was, which is not there any more.
    const fn put_away(&mut self) {
        (self.last_pressed, self.still_ticks) = (None, 0);
        (self.sent, self.withheld) = (None, None);
    }

    /// Gives the force, unless the person wants none or the device gives none.
    fn give(&mut self) {
        if self.side.status.is_force_off() || self.device.rests() {
            self.haptics.withhold();
            self.felt.force_n = Vec3::ZERO;
            self.felt.rub = Rub::default();
        }
        self.device.set_rub(self.felt.rub);
        self.device.set_force(self.felt.force_n);
    }

    /// The sample that a place makes.
    fn sample(&mut self, tick: Tick, (tool, orientation): Grip, centre: Position) -> ToolSample {
        let side = self.hand.side(tick, tool, centre);
        let has_proxy = self.haptics.stages().proxy;
        let sample = ToolSample { tick, tool, orientation, centre, side };
        let centre = if has_proxy { self.hand.stopped_at_clay(&sample) } else { centre };
        ToolSample { centre, ..sample }
    }

    /// What is felt of the clay by a tool that presses nothing.
    fn point(&mut self, tick: Tick, grip: Grip, centre: Position) -> Felt {
        self.put_away();
        let (force_n, elements) = self.feel(tick, grip, centre);
        Felt { force_n, elements, rub: Rub::default() }
    }

    /// The force between two ticks, and the elements touched.
    fn feel(&mut self, tick: Tick, grip: Grip, centre: Position) -> (Vec3, u32) {
        let sample = self.sample(tick, grip, centre);
        let Contact { force_n, elements, penetration_m, held_n, .. } = self.hand.feel(&sample);
        let (wet, _) = self.wet(&sample, elements);
        (self.haptics.render(&Touch { centre: sample.centre, force_n, penetration_m, held_n, wet }), elements)
    }

    /// What goes by under the tool and wets it, where the method knows wetness; and how fast, m/s.
    fn wet(&self, sample: &ToolSample, elements: u32) -> (Option<Wet>, Wet) {
        let (clay_velocity_m_s, element_m2, material) = self.hand.ground(sample);
        let wet = Wet { clay_velocity_m_s, area_m2: element_m2 * elements as f32, material };
        (Some(wet).filter(|_| self.hand.method() == MethodKind::Plastic), wet)
    }

    /// Sends a sample on its way and presses it; nothing when it cannot be sent.
    fn send(&mut self, sample: &ToolSample) -> Option<Contact> {
        if self.side.samples.push(*sample).is_err() {
            self.side.status.note_lost_sample();
            return None;
        }
        self.sent = Some(*sample);
        Some(self.hand.press(sample))
    }

    /// What a sample meets, which is sent and pressed. Of a tool that rests, few are: the last of the others goes out before
    /// the first that tells something else, which so goes on from there.
    fn meet(&mut self, sample: &ToolSample) -> Option<Contact> {
        let is_news = |sent: &ToolSample| ToolSample { tick: sent.tick, ..*sample } != *sent;
        if let Some(sent) = self.sent.filter(|sent| self.still_ticks >= STILL_TICKS && !is_news(sent)) {
            if sample.tick.since(sent.tick) < RESTING_TICKS {
                let contact = self.hand.feel(sample);
                if contact.elements == 0 {
                    self.withheld = Some(*sample);
                    return Some(contact);
                }
            } else {
                // this one says the same
                self.withheld = None;
            }
        }
        if let Some(withheld) = self.withheld.take() {
            self.send(&withheld)?;
        }
        self.send(sample)
    }

    /// Sends the sample of a local tick on its way and presses it; one that cannot be sent is not pressed either.
    fn press(&mut self, tick: Tick, grip: Grip, centre: Position, local: u64) -> Felt {
        let sample = self.sample(tick, grip, centre);
        let centre = sample.centre;
        let Some(Contact { force_n, elements, penetration_m, held_n, .. }) = self.meet(&sample) else {
            self.haptics.rest();
            return Felt::default();
        };
        let (wet, Wet { clay_velocity_m_s, material, .. }) = self.wet(&sample, elements);
        let force_n = self.haptics.render(&Touch { centre, force_n, penetration_m, held_n, wet });
        let last = self.last_pressed.replace((local, centre));
        let (before, was_at) = last.unwrap_or((local, centre));
        let is_still = elements == 0 && last.is_some() && was_at == centre && clay_velocity_m_s == Vec3::ZERO;
        self.still_ticks = if is_still { self.still_ticks.saturating_add(1) } else { 0 };
        let rub = if elements > 0 {
            let since_s = local.saturating_sub(before).max(1) as f32 * Tick::PERIOD.0;
            let tool_velocity_m_s = (centre.point_m() - was_at.point_m()) / since_s;
            let slip_m_s = clay_velocity_m_s.distance(tool_velocity_m_s);
            Rub { force_n: force_n.length(), slip_m_s, wetness: material.wetness().liquidity_index() }
        } else {
            Rub::default()
        };
        Felt { force_n, elements, rub }
    }

    fn catch_up(&mut self) {
        if !self.catching_up {
            self.catching_up = self.side.patches.update();
        }
        if self.catching_up && self.hand.catch_up(self.side.patches.output_buffer_mut(), CATCH_UP_BUDGET) {
            self.catching_up = false;
            if self.hand.is_corrected_since(self.side.patches.output_buffer_mut()) {
                self.haptics.clay_corrected();
            }
        }
    }

    /// Ticks until the network's side is gone; local tick n is due n milliseconds after `epoch`.
    #[must_use]
    pub fn run(mut self, epoch: Instant) -> HapticReport {
        let mut measured = Measured { period_ns: histogram(NS_MAX), step_ns: histogram(NS_MAX), previous: None };
        let mut pacing = Pacing::after(epoch.elapsed(), self.rate);
        while !self.side.samples.is_abandoned() {
            self.keep(epoch, &mut pacing, &mut measured);
        }
        self.device.close();
        HapticReport {
            ticks: self.side.status.ticks(),
            late_ticks: self.side.status.late_ticks(),
            missed_ticks: pacing.missed(),
            lost_samples: self.side.status.lost_samples(),
            spun: self.spin.part(),
            period_ns: measured.period_ns,
            step_ns: measured.step_ns,
            force_mn: self.force_mn,
        }
    }

    /// Waits for the next deadline and keeps it.
    fn keep(&mut self, epoch: Instant, pacing: &mut Pacing, measured: &mut Measured) {
        let deadline = epoch + pacing.deadline();
        if self.is_idle() {
            wait_for(deadline)
        } else {
            self.spin.wait_until(deadline)
        }
        let begin = Instant::now();
        if pacing.is_tick() && pacing.lateness(begin.saturating_duration_since(epoch)) > Pacing::LATE {
            self.side.status.note_late();
        }
        if let Some(previous) = measured.previous.replace(begin) {
            let period = begin.saturating_duration_since(previous);
            measured.period_ns.saturating_record(period.as_nanos() as u64);
        }
        self.turn(pacing.turn());
        measured.step_ns.saturating_record(begin.elapsed().as_nanos() as u64);
        pacing.done(epoch.elapsed());
        if self.is_idle() {
            pacing.rest(Self::IDLE_TICKS);
        }
    }

    /// Whether there is nothing to be felt, and will be nothing in the next ticks: no tool in the hand, or one that has been held still in the air
    /// for a while before clay that stands still as well. Then [`HapticLoop::run`] does one tick of [`HapticLoop::IDLE_TICKS`].
    #[must_use]
    pub const fn is_idle(&self) -> bool {
        self.is_empty || self.still_ticks >= STILL_TICKS
    }
}

/// What is measured as the ticks go by.
struct Measured {
    period_ns: Histogram<u64>,
    step_ns: Histogram<u64>,
    /// When the last tick began.
    previous: Option<Instant>,
}

#[cfg(test)]
mod tests {
    use pottery_shared::clay::{Conditions, Pot, PotSpec};
    use pottery_shared::prediction::{Field, Patch};
    use pottery_shared::tool::rack;

    use super::*;
    use crate::boundary::boundary;
    use crate::device::pointer;

    #[test]
    fn a_hand_presses_on_at_a_server_that_counts_from_less() {
        let field = Field::new(Pot::new(PotSpec::default()).unwrap(), Tick(0));
        let (side, mut net) = boundary(&Patch { field, conditions: Conditions::default(), rack: rack::standard() });
        let (mut asked, device) = pointer();
        let mut hand = HapticLoop::new(Box::new(device), side);
        let target_m = Some(Vec3::new(0.0705, 0.0, 0.1));
        asked.write(crate::device::Pointer { target_m, ..Default::default() });
        let stamps = |hand: &mut HapticLoop, locals: std::ops::Range<u64>, net: &mut crate::boundary::NetSide| {
            locals.for_each(|local| hand.tick(local));
            let sent: Vec<_> = std::iter::from_fn(|| net.next_sample()).map(|sample| sample.tick.0).collect();
            (sent.first().copied(), sent.last().copied())
        };
        net.status().set_tick_offset(3_600_000);
        assert_eq!(stamps(&mut hand, 1..100, &mut net).1, Some(3_600_099));
        // a lead that goes back within a session sends no tick twice
        net.status().set_tick_offset(3_599_998);
        assert_eq!(stamps(&mut hand, 100..110, &mut net).0, Some(3_600_100));
        net.status().begin_session();
        net.status().set_tick_offset(50);
        assert_eq!(stamps(&mut hand, 110..120, &mut net), (Some(160), Some(169)));
        // nothing of before is pressed on the clay that comes: what was later there would keep what is pressed now from it
        net.publish(|patch| patch.field = Field::new(Pot::new(PotSpec::default()).unwrap(), Tick(169)));
        assert_eq!(stamps(&mut hand, 120..140, &mut net), (Some(170), Some(189)));
        assert_eq!(hand.hand().field().through(), Tick(189));
    }
}
