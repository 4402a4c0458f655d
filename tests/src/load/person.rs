//! Somebody who comes, presses or looks on, and at the end says what clay they hold.
//!
//! Owns one connection and its task. Light people hold no clay; full ones hold and predict it as the studio's client does.
//! Invariant: what a person sends is due by the schedule alone; an answer that does not come delays nothing.

use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};
use std::time::Duration;

use pottery_client::rehearsal::dice::Dice;
use pottery_client::stroke::Stroke;
use pottery_client::{Arrival, Joined, Target, join};
use pottery_shared::protocol::{
    self, CONTROL_MAX, DATAGRAM_MAX, DATAGRAM_MEMORY_MAX, KEYFRAME_MAX, Keyframe, Notice, Pulse, Request,
};
use pottery_shared::session::{Client, ClientError, ClientEvent, Watcher};
use pottery_shared::units::Tick;
use tokio::sync::watch;
use tokio::time::Instant;

use super::figures::Recorder;
use super::follower::{Follower, Ledger, Subject};
use super::hand::{Hand, Path, SEND_EVERY};
use super::plan::{Plan, Sight};
use super::schedule::{Punctuality, Schedule};

/// How often somebody who only looks on looks whether to ask for something.
const LOOK_EVERY: Duration = Duration::from_millis(200);
/// Time after which somebody who could not come in, or was sent away, tries again.
const COME_AGAIN_AFTER: Duration = Duration::from_millis(500);
/// Time between two readings of a connection's bytes.
const READ_EVERY: Duration = Duration::from_millis(500);
/// Time in which a keyframe that was asked for at the end comes.
const KEYFRAME_WITHIN: Duration = Duration::from_secs(2);
/// What somebody who looks on may take for long, bytes a second: as much as a pot that many work at.
const WATCH_BYTES_PER_S: u32 = 64_000;
/// A slow reader reads for so long, and then reads nothing for as long.
const SLOW_FOR: Duration = Duration::from_secs(2);

/// What everybody does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Come and work.
    Work,
    /// Press nothing more.
    Settle,
    /// Compare the clay.
    Compare,
    /// Leave.
    Leave,
}

/// What everybody shares.
#[derive(Debug)]
pub struct Studio {
    /// What the run is to be.
    pub plan: Plan,
    /// Where the server is.
    pub address: String,
    /// What lets people in.
    pub code: protocol::JoinCode,
    /// When the run began.
    pub epoch: Instant,
    /// How late a send may be.
    pub punctuality: Punctuality,
    /// Where everybody counts.
    pub recorder: Recorder,
    /// What everybody got.
    pub ledger: Ledger,
    /// What hands do.
    pub strokes: Vec<Arc<Stroke>>,
    /// Sockets of those who press and of those who look on, each shared by some people.
    pub endpoints: [Vec<quinn::Endpoint>; 2],
    /// Potters whose last press is confirmed, after the work.
    pub settled: AtomicU32,
}

/// The clay that somebody holds at the end.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Outcome {
    /// Who.
    pub number: u32,
    /// Of which wheel, at which detail.
    pub subject: Subject,
    /// The version.
    pub version: u32,
    /// The digest of the clay that this person got.
    pub digest: u64,
    /// The digest that the server told for that version.
    pub told: u64,
}

/// Somebody.
#[derive(Debug)]
pub struct Person {
    studio: Arc<Studio>,
    number: u32,
    subject: Subject,
    presses: bool,
    is_full: bool,
    is_slow: bool,
    path: Option<Path>,
    /// When the connection breaks next, and how often it does.
    flaps: Option<Schedule>,
    storms: Option<Schedule>,
    stage: watch::Receiver<Stage>,
}

/// How a stay ended.
enum Ended {
    Compared(Outcome),
    /// On purpose, to come again.
    Broke,
    /// By the network or the server.
    Lost,
    Left,
}

/// One stay: a connection and what is held of it.
struct Stay {
    joined: Joined,
    answer: Vec<u8>,
    follower: Follower,
    hand: Option<Hand>,
    full: Option<Box<Client>>,
    schedule: Schedule,
    /// The next millisecond of the run to make a sample of.
    next_sample: u64,
    read_at: Duration,
    bytes: (u64, u64, u64, u64),
    has_settled: bool,
    /// When the whole pot was asked for at the end.
    asked_at: Option<Duration>,
    rebase_after: Duration,
}

impl Person {
    /// Person `number` of the run.
    #[must_use]
    pub fn new(studio: &Arc<Studio>, number: u32, stage: watch::Receiver<Stage>) -> Self {
        let plan = &studio.plan;
        let mut dice = Dice::new(plan.seed ^ (u64::from(number) << 20)).split();
        let presses = number < plan.potters;
        let among = if presses { number } else { number - plan.potters };
        let wheel = (among % u32::from(plan.used())) as u16 + 1;
        let detail = match plan.sight {
            _ if presses => None,
            Sight::Full => None,
            Sight::At(detail) => Some(detail),
        };
        let path = presses.then(|| {
            let stroke = &studio.strokes[number as usize % studio.strokes.len()];
            Path::new(Arc::clone(stroke), dice.roll())
        });
        let (after_ramp, every) = (Duration::from_secs_f64(plan.ramp_s), Duration::from_secs_f64(plan.flap_every_s));
        let flaps = dice
            .chance(plan.flapping_share)
            .then(|| Schedule::new(after_ramp + every.mul_f64(dice.share().max(0.2)), every));
        let storms =
            plan.storm_every_s.map(Duration::from_secs_f64).map(|every| Schedule::new(after_ramp + every, every));
        let is_slow = !presses && dice.chance(plan.slow_share);
        let is_full = presses && number < plan.full_potters;
        let subject = (wheel, detail);
        Self { studio: Arc::clone(studio), number, subject, presses, is_full, is_slow, path, flaps, storms, stage }
    }

    /// Whether it presses, and does not only look on.
    #[must_use]
    pub const fn presses(&self) -> bool {
        self.presses
    }

    fn now(&self) -> Duration {
        self.studio.epoch.elapsed()
    }

    fn count(&self, change: impl FnOnce(&mut super::figures::Tally)) {
        self.studio.recorder.count(self.number as usize, change);
    }

    /// Comes when it is due, stays and comes again until the run is over; tells the clay held at the end.
    pub async fn live(mut self) -> Option<Outcome> {
        let plan = &self.studio.plan;
        let share = f64::from(self.number) / f64::from(plan.people().max(1));
        // who is not let in tries again, and is still due since then
        let mut due = Duration::from_secs_f64(plan.ramp_s * share);
        let mut tried_at = due;
        let (mut has_been_in, mut is_outside) = (false, false);
        loop {
            let deadline = self.studio.epoch + tried_at;
            tokio::select! {
                () = tokio::time::sleep_until(deadline) => {}
                () = at_stage(&mut self.stage, Stage::Leave) => return None,
            }
            let Some(stay) = self.come(due).await else {
                self.count(|tally| tally.failed_joins += 1);
                if !has_been_in && !is_outside {
                    is_outside = true;
                    self.studio.recorder.stand_outside(1);
                }
                tried_at = self.now() + COME_AGAIN_AFTER;
                continue;
            };
            has_been_in = true;
            if std::mem::take(&mut is_outside) {
                self.studio.recorder.stand_outside(-1);
            }
            self.studio.recorder.come(1);
            let ended = self.stay(stay).await;
            self.studio.recorder.come(-1);
            match ended {
                Ended::Compared(outcome) => return Some(outcome),
                Ended::Left => return None,
                Ended::Broke => {
                    self.count(|tally| tally.reconnects += 1);
                    due = self.now();
                }
                Ended::Lost => {
                    self.count(|tally| tally.broken += 1);
                    due = self.now() + COME_AGAIN_AFTER;
                }
            }
            tried_at = due;
        }
    }

    /// Joins; the time it takes runs from the moment at which it was due.
    async fn come(&self, due: Duration) -> Option<Stay> {
        let studio = &self.studio;
        let target = Target::new(studio.address.clone(), studio.code.clone(), self.subject.0);
        let greeting = match self.subject.1 {
            None => Client::greeting(studio.code.room(), self.subject.0, true),
            Some(_) => Watcher::greeting(studio.code.room(), WATCH_BYTES_PER_S),
        };
        let [hands, eyes] = &studio.endpoints;
        let endpoints = if self.presses { hands } else { eyes };
        let endpoint = &endpoints[self.number as usize % endpoints.len()];
        let opened = join(endpoint, &target, &greeting, |answer, round_trip| {
            let now = match protocol::decode::<CONTROL_MAX, Notice>(answer)? {
                Notice::Welcome(welcome) => welcome.now,
                Notice::Audience(audience) => audience.now,
                Notice::Refused(refusal) => return Err(refusal.into()),
                _ => return Err(protocol::ProtocolError::Malformed { bytes: answer.len() }.into()),
            };
            let local = self.now().as_millis() as u64;
            let full = self.is_full.then(|| Client::open(answer, local, round_trip).map(Box::new)).transpose()?;
            Ok::<_, ClientError>((answer.to_vec(), Tick(now), round_trip, full))
        });
        let (joined, (answer, server, round_trip, full)) = match opened.await {
            Ok(opened) => opened,
            Err(error) => {
                studio.recorder.refuse(error.to_string(), error.is_answer());
                return None;
            }
        };
        let now = self.now();
        studio.recorder.note_round_trip(round_trip);
        self.count(|tally| tally.join_us.saturating_record((now - due).as_micros() as u64));
        let period = if self.presses { SEND_EVERY } else { LOOK_EVERY };
        // people are not in step with each other
        let phase = period.mul_f64(f64::from(self.number % 16) / 16.0);
        let local = now.as_millis() as u64;
        let mut stay = Stay {
            joined,
            answer,
            follower: Follower::new(self.subject, round_trip, now),
            hand: self.presses.then(|| Hand::new(local, server, round_trip)),
            full,
            schedule: Schedule::new(now + phase, period),
            next_sample: local + 1,
            read_at: now + READ_EVERY,
            bytes: (0, 0, 0, 0),
            has_settled: !self.presses,
            asked_at: None,
            rebase_after: now,
        };
        if self.subject.1.is_some() {
            let request = stay.follower.whole_pot();
            stay.send(&request).await;
        }
        Some(stay)
    }

    async fn stay(&mut self, mut stay: Stay) -> Ended {
        let wake = tokio::time::sleep_until(self.studio.epoch + stay.schedule.deadline());
        tokio::pin!(wake);
        let ended = loop {
            let is_reading = !self.is_slow || (self.now().as_millis() / SLOW_FOR.as_millis()).is_multiple_of(2);
            tokio::select! {
                // the schedule before what arrives, always
                biased;
                () = &mut wake => {
                    if let Some(ended) = self.on_time(&mut stay).await {
                        break ended;
                    }
                    wake.as_mut().reset(self.studio.epoch + stay.schedule.deadline());
                }
                datagram = stay.joined.connection.read_datagram(), if is_reading => match datagram {
                    Ok(bytes) => self.on_datagram(&mut stay, &bytes).await,
                    Err(_) => break Ended::Lost,
                },
                Some(arrival) = stay.joined.streams.arriving.recv(), if is_reading => match arrival {
                    Arrival::Frame(frame) => if let Some(full) = &mut stay.full && full.handle_control(&frame).is_err() {
                        break Ended::Lost;
                    },
                    Arrival::Keyframe(bytes) => if let Some(outcome) = self.on_keyframe(&mut stay, &bytes) {
                        break Ended::Compared(outcome);
                    },
                    Arrival::StreamEnded => break Ended::Lost,
                },
            }
        };
        self.read_bytes(&mut stay);
        if matches!(ended, Ended::Compared(_) | Ended::Left) {
            stay.send(&Request::Leave).await;
        }
        stay.joined.connection.close(0, b"goodbye");
        ended
    }

    /// Whatever is due by the schedule.
    async fn on_time(&mut self, stay: &mut Stay) -> Option<Ended> {
        let stage = *self.stage.borrow();
        let now = self.now();
        while let Some(due) = stay.schedule.next_due(now) {
            if self.presses {
                self.press(stay, due, stage);
            } else {
                self.count(|tally| tally.look_lag_us.saturating_record((now - due).as_micros() as u64));
            }
        }
        if stay.hand.as_ref().is_some_and(Hand::is_settled) && stage >= Stage::Settle && !stay.has_settled {
            stay.has_settled = true;
            self.studio.settled.fetch_add(1, Ordering::Relaxed);
        }
        if now >= stay.read_at {
            stay.read_at = now + READ_EVERY;
            self.read_bytes(stay);
        }
        self.ask(stay, now).await;
        match stage {
            Stage::Work => {
                let mut breaks = false;
                for schedule in [&mut self.flaps, &mut self.storms].into_iter().flatten() {
                    while schedule.next_due(now).is_some() {
                        breaks = true;
                    }
                }
                breaks.then_some(Ended::Broke)
            }
            Stage::Settle => None,
            Stage::Compare => self.compare(stay, now).await.map(Ended::Compared),
            Stage::Leave => Some(Ended::Left),
        }
    }

    /// One send of the schedule: the samples up to its moment, in a datagram.
    fn press(&mut self, stay: &mut Stay, due: Duration, stage: Stage) {
        let now = self.now();
        let lag = now - due;
        let (hand, Some(path)) = (&mut stay.hand, &mut self.path) else { return };
        let Some(hand) = hand else { return };
        let until = due.as_millis() as u64;
        let works = stage == Stage::Work
            && self.studio.plan.burst_s.is_none_or(|burst_s| ((due.as_secs_f64() / burst_s) as u64).is_multiple_of(2));
        for local in stay.next_sample..=until {
            let tick = match &stay.full {
                Some(full) => Tick(0).offset(local as i64 + full.tick_offset()),
                None => hand.tick(local),
            };
            if works && let Some(sample) = path.sample(local, tick) {
                hand.take(sample);
                if let Some(full) = &mut stay.full {
                    full.handle_sample(sample);
                }
            }
        }
        stay.next_sample = stay.next_sample.max(until + 1);
        let is_dropped = self.studio.punctuality.is_dropped(lag);
        hand.mark(due, now);
        let mut held_back = 0;
        if !is_dropped {
            while let Some(bytes) = match &mut stay.full {
                _ if stay.joined.connection.datagram_send_buffer_space() < DATAGRAM_MAX => {
                    held_back = 1;
                    None
                }
                Some(full) => full.poll_datagram(now),
                None => hand.poll_datagram(now),
            } {
                // what is lost is repeated
                drop(stay.joined.connection.send_datagram(bytes.into()));
            }
        }
        self.studio.recorder.count(self.number as usize, |tally| {
            tally.lag_us.saturating_record(lag.as_micros() as u64);
            tally.sends += 1;
            tally.dropped_sends += u64::from(is_dropped);
            tally.held_back += held_back;
        });
    }

    async fn on_datagram(&self, stay: &mut Stay, bytes: &[u8]) {
        let now = self.now();
        let (body, head) = match self.subject.1 {
            None => match protocol::decode::<DATAGRAM_MEMORY_MAX, Pulse>(bytes) {
                Ok(pulse) => (pulse.body, Some(pulse.head)),
                Err(_) => return self.count(|tally| tally.unlike += 1),
            },
            Some(_) => match protocol::decode::<DATAGRAM_MEMORY_MAX, protocol::Sight>(bytes) {
                Ok(sight) => (sight.body, None),
                Err(_) => return self.count(|tally| tally.unlike += 1),
            },
        };
        let acknowledged = head.as_ref().map_or(0, |head| head.acknowledged);
        if let (Some(hand), Some(slack)) = (&mut stay.hand, head.and_then(|head| head.slack)) {
            hand.handle_slack(slack, acknowledged, now);
        }
        let whole = stay.follower.handle(body, acknowledged, &self.studio.ledger);
        self.count(|tally| {
            tally.datagrams += 1;
            if let Some(whole) = whole {
                if whole.is_new {
                    tally.age_us.saturating_record(self.studio.recorder.age_us(now, whole.tick));
                }
                if let Some(hand) = &mut stay.hand {
                    hand.confirm(whole.acknowledged, now, |answered| {
                        tally.input_delta_us.saturating_record(answered.since_due.as_micros() as u64);
                        tally.input_delta_sent_us.saturating_record(answered.since_sent.as_micros() as u64);
                    });
                }
            }
        });
        if let Some(full) = &mut stay.full {
            full.handle_datagram(bytes, now);
            full.handle_effort(self.now() - now, now);
            self.rebase(full, &mut stay.rebase_after);
        }
        self.ask(stay, now).await;
    }

    /// Puts a full potter's prediction on new clay, no more of the time than the studio's client does.
    fn rebase(&self, full: &mut Client, after: &mut Duration) {
        let begun = self.now();
        if full.needs_rebase() && begun >= *after {
            full.rebase();
            *after = begun + (self.now() - begun) * 4;
        }
        while let Some(event) = full.poll_event() {
            if let ClientEvent::Confirmed(correction) = event
                && let Some(metres) = correction.under_own_tool
            {
                self.count(|tally| tally.correction_nm.saturating_record((f64::from(metres.0) * 1e9) as u64));
            }
        }
    }

    async fn ask(&self, stay: &mut Stay, now: Duration) {
        let mut frames = Vec::new();
        match &mut stay.full {
            Some(full) => frames.extend(std::iter::from_fn(|| full.poll_control())),
            None => frames.extend(stay.follower.poll_request(now).map(|request| frame_of(&request))),
        }
        let (asked, unlike) = stay.follower.take_counts();
        if asked + unlike > 0 {
            self.count(|tally| {
                tally.asked += asked;
                tally.unlike += unlike;
            });
        }
        for frame in frames {
            stay.send_frame(frame).await;
        }
    }

    /// Takes in a keyframe; at the end it says what clay this person has.
    fn on_keyframe(&self, stay: &mut Stay, bytes: &[u8]) -> Option<Outcome> {
        let now = self.now();
        let Ok(keyframe) = protocol::decode::<KEYFRAME_MAX, Keyframe>(bytes) else {
            self.count(|tally| tally.unlike += 1);
            return None;
        };
        let whole = stay.follower.handle_keyframe(&keyframe, &self.studio.ledger);
        if let (Some(hand), Some(whole)) = (&mut stay.hand, whole) {
            hand.confirm(whole.acknowledged, now, |_| {});
        }
        if let Some(full) = &mut stay.full {
            full.handle_keyframe(bytes, now);
            return None;
        }
        stay.asked_at.filter(|_| keyframe.since == 0)?;
        let (version, told) = stay.follower.told_digest().filter(|(version, _)| *version == keyframe.version)?;
        let digest =
            self.studio.ledger.digest(self.subject, &keyframe, || decoded(&stay.answer, self.subject, bytes))?;
        Some(Outcome { number: self.number, subject: self.subject, version, digest, told })
    }

    /// At the end: who holds clay tells its digest, who does not asks for the whole pot.
    async fn compare(&self, stay: &mut Stay, now: Duration) -> Option<Outcome> {
        let (version, told) = stay.follower.told_digest()?;
        if let Some(full) = &stay.full {
            let held = full.replica();
            return (held.version().0 == version).then(|| Outcome {
                number: self.number,
                subject: self.subject,
                version,
                digest: held.digest(),
                told,
            });
        }
        if stay.asked_at.is_none_or(|asked_at| now > asked_at + KEYFRAME_WITHIN) {
            stay.asked_at = Some(now);
            let request = stay.follower.whole_pot();
            stay.send(&request).await;
        }
        None
    }

    fn read_bytes(&self, stay: &mut Stay) {
        let stats = quinn::Connection::stats(&stay.joined.connection);
        let read = (stats.udp_rx.bytes, stats.udp_tx.bytes, stats.path.sent_packets, stats.path.lost_packets);
        let before = std::mem::replace(&mut stay.bytes, read);
        self.count(|tally| {
            tally.down_bytes += read.0 - before.0;
            tally.up_bytes += read.1 - before.1;
            tally.up_packets += read.2 - before.2;
            // one that came after all is not lost any more
            tally.up_lost += read.3.saturating_sub(before.3);
        });
    }
}

impl Stay {
    async fn send(&mut self, request: &Request) {
        self.send_frame(frame_of(request)).await;
    }

    async fn send_frame(&mut self, frame: Vec<u8>) {
        if self.joined.streams.outgoing.send(frame).await.is_err() {
            tracing::debug!("the control stream is closed");
        }
    }
}

fn frame_of(request: &Request) -> Vec<u8> {
    protocol::frame(&protocol::encode(request))
}

/// The digest of the clay that a keyframe of the whole pot makes, with the sessions that the studio's clients have.
fn decoded(answer: &[u8], (wheel, detail): Subject, keyframe: &[u8]) -> Option<u64> {
    let keyframe = protocol::decode::<KEYFRAME_MAX, Keyframe>(keyframe).ok()?;
    // as long after the answer as it says, and of samples that this client made: others it does not believe
    let now = Duration::from_millis(keyframe.tick);
    let keyframe = &protocol::encode(&Keyframe { acknowledged: 0, ..keyframe });
    match detail {
        None => {
            let mut client = Client::open(answer, 0, Duration::ZERO).ok()?;
            client.handle_keyframe(keyframe, now).then(|| client.replica().digest())
        }
        Some(detail) => {
            let mut watcher = Watcher::open(answer, Duration::ZERO).ok()?;
            watcher.watch(wheel, detail, Duration::ZERO);
            watcher.handle_keyframe(keyframe, now);
            watcher.sight(wheel).map(pottery_shared::session::Watched::digest)
        }
    }
}

async fn at_stage(stage: &mut watch::Receiver<Stage>, wanted: Stage) {
    // whoever says it may be gone with the run
    drop(stage.wait_for(|stage| *stage >= wanted).await);
}
