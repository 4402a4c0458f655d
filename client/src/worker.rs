//! The task between network and hand: moves samples out, clay in, and keeps the view.
//!
//! Owns the connection after the welcome. Prediction is the session's; this task only feeds it and hands on.
//! Invariant: own samples reach the session in the order of their making, before any clay that came later.

mod coming_back;

use std::sync::Arc;
use std::time::Duration;

use hdrhistogram::Histogram;
use pottery_shared::clay::{Form, Material};
use pottery_shared::protocol::{DATAGRAM_MAX, Order, Request};
use pottery_shared::session::{Client, ClientError, ClientEvent, Implausible, MendCounts, StepCounts};
use pottery_shared::snapshot::PotRecord;
use pottery_shared::tool::{ConvexTool, ToolSample};
use pottery_shared::units::{Rpm, Tick};
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior};
use web_transport_quinn::Session;

use crate::HapticLoop;
use crate::boundary::NetSide;
use crate::connection::Joined;
use crate::guiding::{GuideCommand, Guiding};
use crate::potter::PotterOptions;
use crate::remote_hands::RemoteHands;
use crate::streams::{Arrival, Streams, closed_or_lost};
use crate::stroke::StrokeRecorder;
use crate::view::{Link, SharedView};
use crate::way_back::WayBack;

/// How often samples are fetched from the hand.
const FETCH_EVERY: Duration = Duration::from_millis(5);
/// Fetches between two datagrams of samples.
const FETCHES_PER_SEND: u32 = 2;
/// Fetches between two looks at the round trip.
const FETCHES_PER_LOOK: u32 = 20;
/// Fetches without a sample after which the hand rests, and only those are left that samples are sent with.
const FETCHES_OF_REST: u32 = 10;
/// A rebase is followed by at least this many times its own length without one.
const REBASE_REST: u32 = 4;
/// Ticks without a sample after which a tool that is then elsewhere was away.
const GAP_TICKS: i64 = 100;
/// How often what was recorded is told, so that it can be kept, and the share of its length that has to be new: all of it is written each time.
const TELL_RECORDING_EVERY: Duration = Duration::from_secs(30);
const TELL_RECORDING_SHARE: f64 = 0.05;
/// Time in which the last presses are confirmed before leaving.
const SETTLE_WITHIN: Duration = Duration::from_secs(2);

/// What a person asks of the worker.
#[derive(Clone, Debug)]
pub enum Command {
    /// Turn the wheel at this speed.
    WheelSpeed(Rpm),
    /// Make the wheel's clay another.
    Clay(Material),
    /// Bring a tool to the wheel; the view says what came of it.
    Bring(Arc<ConvexTool>),
    /// Undo the own newest stroke; the view says what came of it.
    Undo,
    /// Redo what was undone last.
    Redo,
    /// Put new clay on the wheel, in a form or as it began; can be undone as a stroke.
    NewPot(Option<Form>),
    /// Put that pot on the wheel; can be undone as a stroke. The log says when it is none of this wheel's, which
    /// [`pottery_shared::session::fitted`] tells beforehand.
    Put(Arc<PotRecord>),
    /// What a teacher orders; the view says when it was not done.
    Order(Order),
    /// Something about guiding, or being guided; the view says what came of it.
    Guide(GuideCommand),
    /// Leave once everything pressed is confirmed.
    Leave,
}

/// What the worker measured.
#[derive(Clone, Debug)]
pub struct NetworkReport {
    /// Time since the welcome.
    pub duration: Duration,
    /// Bytes received, UDP payload.
    pub down_bytes: u64,
    /// Bytes sent, UDP payload.
    pub up_bytes: u64,
    /// Round trips, µs.
    pub round_trip_us: Histogram<u64>,
    /// Corrections under the own tool, nm, one for each snapshot.
    pub correction_nm: Histogram<u64>,
    /// Digests that did not match.
    pub mismatches: u64,
    /// How clay that differed was mended.
    pub mends: MendCounts,
    /// How often it asked to be told again what was lost.
    pub repeats: u64,
    /// How often it asked for a keyframe.
    pub resyncs: u64,
    /// How the confirmed clay came.
    pub steps: StepCounts,
    /// Datagrams and keyframes that made no sense or could not be true.
    pub malformed: u64,
    /// What could not be true of them.
    pub implausible: Implausible,
    /// Datagrams that the connection did not take; what was in them was said again.
    pub unsent: u64,
    /// The stroke that was recorded, if one was asked for.
    pub recording: Option<StrokeRecorder>,
}

/// Why the predicted clay changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Change {
    /// The own hand pressed.
    Own,
    /// The server said otherwise, or others pressed.
    Corrected,
}

/// The task's state.
#[derive(Debug)]
pub struct Worker {
    connection: Session,
    session: Client,
    side: NetSide,
    view: SharedView,
    hands: RemoteHands,
    guiding: Guiding,
    commands: mpsc::Receiver<Command>,
    epoch: Instant,
    joined_at: Instant,
    outgoing: mpsc::Sender<Vec<u8>>,
    arriving: mpsc::Receiver<Arrival>,
    report: NetworkReport,
    /// When anything came last.
    heard_at: Instant,
    /// Not before then is prediction put on new clay.
    rebase_after: Instant,
    way_back: WayBack,
    /// Whether view and hand still have the clay of the connection before, until this one's is whole.
    is_coming: bool,
    /// Since when the person has been leaving.
    leaving: Option<Instant>,
    records: bool,
    /// A tick, and when it was in the recording, s.
    recorded_from: Option<(Tick, f64)>,
    last_recorded: Option<ToolSample>,
    /// When what was recorded was last told.
    told_recording_at: Instant,
}

/// Whether the tool was away between two samples: of one that rests few are sent, and the last right before it moves.
fn was_away(before: &ToolSample, after: &ToolSample) -> bool {
    let ticks = after.tick.since(before.tick);
    let is_still = ToolSample { tick: after.tick, ..*before } == *after;
    ticks > if is_still { HapticLoop::SHOWN_TICKS } else { GAP_TICKS }
}

impl Worker {
    /// Takes over a welcomed connection; local tick n is due n milliseconds after the epoch.
    pub(crate) fn new(
        (joined, session, epoch): (Joined, Client, Instant),
        side: NetSide,
        view: SharedView,
        commands: mpsc::Receiver<Command>,
        way_back: WayBack,
        PotterOptions { record: records, waits: is_coming, .. }: PotterOptions,
    ) -> Self {
        side.status().hold(is_coming);
        view.lock().is_whole = !is_coming;
        let Joined { connection, streams: Streams { outgoing, arriving }, .. } = joined;
        side.status().set_tick_offset(session.tick_offset());
        let histogram = |highest| Histogram::new_with_bounds(1, highest, 3).expect("these bounds are valid");
        let report = NetworkReport {
            duration: Duration::ZERO,
            down_bytes: 0,
            up_bytes: 0,
            round_trip_us: histogram(60_000_000),
            correction_nm: histogram(1_000_000_000),
            mismatches: 0,
            mends: MendCounts::default(),
            repeats: 0,
            resyncs: 0,
            steps: StepCounts::default(),
            malformed: 0,
            implausible: Implausible::default(),
            unsent: 0,
            recording: None,
        };
        Self {
            connection,
            session,
            side,
            view,
            hands: RemoteHands::default(),
            guiding: Guiding::default(),
            commands,
            epoch,
            joined_at: Instant::now(),
            outgoing,
            arriving,
            report,
            heard_at: Instant::now(),
            rebase_after: Instant::now(),
            way_back,
            is_coming,
            leaving: None,
            records,
            recorded_from: None,
            last_recorded: None,
            told_recording_at: Instant::now(),
        }
    }

    /// Works until the person leaves or the connection ends for good.
    pub async fn run(mut self) -> NetworkReport {
        loop {
            let link = self.work().await;
            if let Err(link) = self.come_back(link).await {
                return self.finish(link);
            }
        }
    }

    /// Works until the connection ends; says how.
    async fn work(&mut self) -> Link {
        let mut fetch = tokio::time::interval(FETCH_EVERY);
        fetch.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let (mut fetches, mut empty) = (0_u32, 0_u32);
        loop {
            tokio::select! {
                // the rarest first, so that nothing starves, and always in this order, so that a run repeats from its seed
                biased;
                _ = fetch.tick() => {
                    fetches = fetches.wrapping_add(1);
                    empty = if self.fetch_samples() { 0 } else { empty.saturating_add(1) };
                    if fetches.is_multiple_of(FETCHES_PER_LOOK) {
                        self.report.round_trip_us.saturating_record(self.connection.rtt().as_micros() as u64);
                    }
                    if fetches.is_multiple_of(FETCHES_PER_SEND) {
                        let now = self.epoch.elapsed();
                        self.guiding.pass(&mut self.session, &self.side, &self.view, now);
                        self.send_samples();
                        if empty >= FETCHES_OF_REST {
                            fetches = fetches.wrapping_add(FETCHES_PER_SEND - 1);
                            fetch.reset_after(FETCH_EVERY * FETCHES_PER_SEND);
                        }
                    }
                }
                datagram = self.connection.read_datagram() => match datagram {
                    Ok(bytes) => {
                        self.fetch_samples();
                        let begin = Instant::now();
                        self.heard_at = begin;
                        let sound = self.session.handle_datagram(&bytes, self.epoch.elapsed());
                        self.session.handle_effort(begin.elapsed(), self.epoch.elapsed());
                        self.report.malformed += u64::from(!sound);
                    }
                    Err(error) => break closed_or_lost(&error),
                },
                Some(arrival) = self.arriving.recv() => {
                    self.heard_at = Instant::now();
                    match arrival {
                        Arrival::Frame(frame) => if let Err(error) = self.session.handle_control(&frame) {
                            break Link::Lost(error.to_string());
                        },
                        Arrival::Keyframe(bytes) => {
                            self.fetch_samples();
                            let sound = self.session.handle_keyframe(&bytes, self.epoch.elapsed());
                            self.report.malformed += u64::from(!sound);
                        }
                        Arrival::StreamEnded => break Link::Closed,
                    }
                }
                command = self.commands.recv(), if self.leaving.is_none() => match command {
                    Some(Command::WheelSpeed(Rpm(rpm))) => self.session.request(&Request::WheelSpeed { rpm }),
                    Some(Command::Clay(material)) => self.session.request(&Request::Clay { clay: material.into() }),
                    Some(Command::Bring(tool)) => if let Err(error) = self.session.bring(&tool) {
                        self.view.lock().brought = Some(Err(error.to_string()));
                    },
                    Some(Command::Undo) => self.session.undo(),
                    Some(Command::Redo) => self.session.redo(),
                    Some(Command::NewPot(form)) => self.session.begin_anew(form),
                    Some(Command::Put(record)) => if let Err(error) = self.session.put(&record) {
                        tracing::warn!(%error, "the pot was not put on the wheel");
                    },
                    Some(Command::Guide(command)) => {
                        self.guiding.command(command, &mut self.session, &self.view, self.epoch.elapsed());
                    }
                    Some(Command::Order(order)) => self.session.request(&Request::Order(order)),
                    Some(Command::Leave) | None => {
                        self.leaving.get_or_insert(Instant::now());
                    }
                },
            }
            self.rebase();
            if let Err(link) = self.hand_on() {
                break link;
            }
            if self.leaving.is_some_and(|since| self.session.is_settled() || since.elapsed() > SETTLE_WITHIN) {
                break self.say_goodbye().await;
            }
        }
    }

    /// Puts prediction on the clay that was confirmed, unless that took too much of the time lately: a machine that cannot
    /// keep up corrects less often instead of falling behind.
    fn rebase(&mut self) {
        let begin = Instant::now();
        if self.session.needs_rebase() && begin >= self.rebase_after {
            // what the own hand pressed is drawn at once, what is corrected fades in
            self.draw(Change::Own);
            self.session.rebase();
            self.draw(Change::Corrected);
            self.rebase_after = begin + begin.elapsed() * REBASE_REST;
        }
    }

    /// Takes no notice of what the hand made so far.
    fn throw_samples_away(&mut self) {
        while self.side.next_sample().is_some() {}
    }

    /// Whether there was one that counts.
    fn fetch_samples(&mut self) -> bool {
        if self.is_coming {
            // it was made on other clay, and by the clock of the connection before
            self.throw_samples_away();
            return false;
        }
        let mut is_any = false;
        while let Some(sample) = self.side.next_sample() {
            self.session.handle_sample(sample);
            self.record(sample);
            is_any = true;
        }
        if is_any {
            self.tell_recording();
        }
        is_any
    }

    fn record(&mut self, sample: ToolSample) {
        if !self.records {
            return;
        }
        let recording = self.report.recording.get_or_insert_with(|| {
            // the file holds one speed: that which it begins with
            StrokeRecorder::new(sample.tool, self.session.conditions().wheel.speed(sample.tick))
        });
        recording.hold(sample.tool);
        // a server that was started anew counts from the beginning
        if self.last_recorded.is_some_and(|last| sample.tick.since(last.tick) < -GAP_TICKS) {
            recording.lift();
            self.recorded_from = Some((sample.tick, recording.stroke().end() + GAP_TICKS as f64 * 1e-3));
        }
        let (from, from_s) = *self.recorded_from.get_or_insert((sample.tick, 0.0));
        // a tool that was away is lifted in the file as well
        if self.last_recorded.is_some_and(|last| was_away(&last, &sample)) {
            recording.lift();
        }
        let seconds = from_s + sample.tick.since(from) as f64 * 1e-3;
        let centre_m = sample.centre.point_m();
        let recorded = recording.push(seconds, centre_m, sample.orientation).or_else(|_| {
            // a tool taken away and brought back elsewhere
            recording.lift();
            recording.push(seconds, centre_m, sample.orientation)
        });
        match recorded {
            Ok(()) => self.last_recorded = Some(sample),
            Err(error) => tracing::warn!(%error, "a sample could not be recorded"),
        }
    }

    /// Tells what was recorded, when that is due.
    fn tell_recording(&mut self) {
        let Some(recording) = &self.report.recording else { return };
        let share = Duration::from_secs_f64(recording.stroke().end() * TELL_RECORDING_SHARE);
        if self.told_recording_at.elapsed() >= TELL_RECORDING_EVERY.max(share) {
            self.view.lock().recording = Some(recording.clone());
            self.told_recording_at = Instant::now();
        }
    }

    fn send_samples(&mut self) {
        let now = self.epoch.elapsed();
        // a full buffer would drop the oldest, which is what the server waits for
        while self.connection.datagram_send_buffer_space() >= DATAGRAM_MAX
            && let Some(bytes) = self.session.poll_datagram(now)
        {
            if let Err(error) = self.connection.send_datagram(bytes.into()) {
                // what is lost is repeated
                self.report.unsent += 1;
                tracing::trace!(%error, "a datagram was not sent");
            }
        }
    }

    /// Hands on what the session has for server, hand and view; how the connection ends when the control stream is closed or the session can no
    /// longer be gone on with.
    fn hand_on(&mut self) -> Result<(), Link> {
        // what there is no room for waits in the session: a large pot on a narrow line holds nothing else up
        while self.outgoing.capacity() > 0
            && let Some(frame) = self.session.poll_control()
        {
            if self.outgoing.try_send(frame).is_err() {
                return Err(Link::Closed);
            }
        }
        let mut is_corrected = false;
        while let Some(event) = self.session.poll_event() {
            match event {
                ClientEvent::Confirmed(correction) => {
                    is_corrected |= correction.anywhere.0 > 0.0;
                    if let Some(metres) = correction.under_own_tool {
                        self.report.correction_nm.saturating_record((f64::from(metres.0) * 1e9) as u64);
                    }
                }
                ClientEvent::Conditions | ClientEvent::Beside => is_corrected = true,
                ClientEvent::Rack => {
                    // the hand learns of it with the clay
                    is_corrected = true;
                    self.view.lock().rack = self.session.rack();
                }
                ClientEvent::Brought(shape) => self.view.lock().brought = Some(Ok(shape)),
                ClientEvent::NotBrought(reason) => self.view.lock().brought = Some(Err(reason.to_string())),
                ClientEvent::Steps => self.view.lock().steps = *self.session.steps(),
                ClientEvent::NoStep(reason) => self.view.lock().no_step = Some(reason),
                ClientEvent::Class(event) => self.hear_of_class(event),
                ClientEvent::Guidance(event) => self.guiding.hear(event, &self.session, &mut self.side, &self.view),
                ClientEvent::Hand => self.guiding.hear_hand(&self.session, &mut self.side, &self.view),
                ClientEvent::Leapt => return Err(Link::Lost(ClientError::Leapt.to_string())),
                ClientEvent::Closing => tracing::info!("the studio closes"),
            }
        }
        self.side.status().set_tick_offset(self.session.tick_offset());
        if self.is_coming && !self.arrive() {
            return Ok(());
        }
        if is_corrected {
            self.side.publish(|patch| self.session.patch_into(patch));
        }
        self.show();
        Ok(())
    }

    /// Brings the view's clay up to the predicted one.
    fn draw(&mut self, change: Change) {
        if self.is_coming {
            return;
        }
        let now = self.epoch.elapsed();
        let mut view = self.view.lock();
        let view = &mut *view;
        let mut news = view.changed.emptied();
        self.session.take_changed(&mut news);
        for (surface, _, window) in news.iter() {
            view.pot.copy_window(self.session.predicted(), surface, window);
        }
        if change == Change::Corrected {
            view.picture.correct(&view.pot, &news);
        }
        view.picture.draw(&view.pot, &news, now, &mut view.changed);
    }

    fn show(&mut self) {
        self.draw(Change::Own);
        let now = self.epoch.elapsed();
        self.hands.hear(self.session.tools(), self.session.tools_tick(), now);
        let mut view = self.view.lock();
        let view = &mut *view;
        self.hands.draw(now, &mut view.tools);
        if view.conditions != *self.session.conditions() {
            view.conditions.clone_from(self.session.conditions());
        }
        view.tick_offset = self.session.tick_offset();
        (view.round_trip, view.silence) = (self.connection.rtt(), self.heard_at.elapsed());
        view.digest = self.session.replica().digest();
        view.settled = self.session.is_settled();
    }

    async fn say_goodbye(&mut self) -> Link {
        self.session.request(&Request::Leave);
        if self.hand_on().is_err() {
            tracing::debug!("the control stream is closed");
        }
        let goodbye = async {
            while let Some(frame) = self.session.poll_control()
                && self.outgoing.send(frame).await.is_ok()
            {}
            self.connection.closed().await
        };
        if tokio::time::timeout(Duration::from_secs(1), goodbye).await.is_err() {
            tracing::debug!("the server did not confirm the goodbye");
        }
        Link::Closed
    }

    fn finish(mut self, link: Link) -> NetworkReport {
        self.connection.close(0, b"goodbye");
        self.guiding.forget(&mut self.side, &self.view);
        self.view.lock().link = link;
        self.report.duration = self.joined_at.elapsed();
        self.add_counts();
        self.report
    }

    /// Adds what this connection counted to the report.
    fn add_counts(&mut self) {
        let stats = quinn::Connection::stats(&self.connection);
        let (session, report) = (&self.session, &mut self.report);
        let (mends, steps) = (session.mend_counts(), session.step_counts());
        report.mismatches += session.mismatches();
        report.implausible += *session.implausible();
        report.mends.asked += mends.asked;
        report.mends.whole += mends.whole;
        report.mends.tiles += mends.tiles;
        report.repeats += session.repeats();
        report.resyncs += session.resyncs();
        report.steps.retold += steps.retold;
        report.steps.deltas += steps.deltas;
        report.steps.unlike += steps.unlike;
        report.down_bytes += stats.udp_rx.bytes;
        report.up_bytes += stats.udp_tx.bytes;
    }
}

#[cfg(test)]
mod tests {
    use pottery_shared::tool::{Orientation, Position, Side, Tool};
    use pottery_shared::units::Tick;

    use super::*;

    #[test]
    fn a_tool_that_rests_is_not_away_and_one_that_comes_back_elsewhere_was() {
        let (tool, orientation, side) = (Tool::default(), Orientation::default(), Side::default());
        let at = |tick, x| ToolSample { tick: Tick(tick), tool, orientation, centre: Position([x, 0, 0]), side };
        let resting = at(1000, 70);
        // as a loop that does one tick of four sends it, and the first that moves
        for (before, after) in [(resting, at(1253, 70)), (at(1253, 70), at(1290, 70)), (at(1290, 70), at(1291, 71))] {
            assert!(!was_away(&before, &after), "{before:?}, {after:?}");
        }
        assert!(was_away(&resting, &at(1101, 71)));
        assert!(was_away(&resting, &at(1501, 70)));
    }
}
