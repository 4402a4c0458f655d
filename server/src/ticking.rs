//! The task that owns the room: lets time pass, takes in what arrived, hands out what is to be sent.
//!
//! Never waits for a peer: what a connection cannot take at once is dropped (datagrams) or ends it (control).
//! Invariant: ticks done = milliseconds since the start, at every wake-up.

use std::collections::BTreeMap;
use std::ops::Bound::{Excluded, Unbounded};
use std::time::Duration;

use pottery_files::pot_file::PotFile;
use pottery_shared::protocol::DATAGRAM_MAX;
use pottery_shared::room::{Lane, PeerId, Room};
use pottery_shared::units::Tick;
use tokio::sync::mpsc;
use tokio::time::{Instant, MissedTickBehavior};

use crate::class_register::ClassRegister;
use crate::crew::Workers;
use crate::doorkeeper::SharedDoorkeeper;
use crate::event::Event;
use crate::lesson::Lesson;
use crate::link::{Link, Look};
use crate::recording::Recorder;
use crate::store::{self, Mark, Store};
use crate::{Figures, InputCounts, Losses, Standing};

/// How often the room is advanced; each time by all milliseconds that have passed. With every tick, so that no snapshot waits for it.
const WAKE_EVERY: Duration = Duration::from_millis(1);
/// The same while nobody has said anything for a while, and while nobody is connected.
const QUIET_EVERY: Duration = Duration::from_millis(12);
const REST_EVERY: Duration = Duration::from_millis(50);
/// How long it has waited then without hearing anything: a hand that moves says something every ten milliseconds.
const QUIET_AFTER: Duration = Duration::from_millis(20);
/// A wake-up that comes later than it was due by more than this is counted: the oldest of its ticks, at work, is then late by more than
/// a snapshot's period.
const LATE: Duration = Duration::from_millis(15);
/// Ticks between two looks at what a line loses and takes, at addresses, and at pots that are to be kept.
const LOOK_EVERY: u64 = store::LOOK_EVERY.as_millis() as u64;
/// Time between two looks at which addresses may be forgotten.
const FORGET_EVERY: Duration = Duration::from_secs(10);
/// Least time between two sentences about addresses that send too much.
const SAY_EVERY: Duration = Duration::from_secs(60);
/// Bytes of a datagram up to which it need not be asked what the path takes now, beside the look that is taken anyway: what does not
/// fit into one of the shortest path's is cut into pieces of which one is longer.
const ANY_PATH: usize = DATAGRAM_MAX / 2;
/// Events taken in before time is looked at again.
const EVENTS_AT_ONCE: usize = 256;

/// The room and its connections.
#[derive(Debug)]
pub(crate) struct Ticking {
    room: Room,
    events: mpsc::Receiver<Event>,
    links: BTreeMap<PeerId, Box<Link>>,
    workers: Workers,
    started: Instant,
    figures: Figures,
    /// The tick of the next look at addresses and pots.
    look_at: u64,
    /// Whose line was looked at last, and the hundredths of a look that are due beside whole ones.
    looked_at: PeerId,
    looks: u64,
    /// Datagrams dropped for people who have left.
    dropped: u64,
    recorder: Option<Recorder>,
    store: Option<Store>,
    class_register: Option<ClassRegister>,
    losses: Losses,
    doorkeeper: SharedDoorkeeper,
    forget_at: Duration,
    /// What was said of addresses that send too much, and when there may be more to say.
    said: InputCounts,
    say_at: Duration,
}

impl Ticking {
    pub(crate) fn new(
        room: Room,
        events: mpsc::Receiver<Event>,
        recorder: Option<Recorder>,
        (store, class_register): (Option<Store>, Option<ClassRegister>),
        doorkeeper: SharedDoorkeeper,
    ) -> Self {
        Self {
            room,
            events,
            links: BTreeMap::new(),
            workers: Workers::on(tokio::runtime::Handle::current().metrics().num_workers()),
            started: Instant::now(),
            figures: Figures::default(),
            look_at: 0,
            looked_at: PeerId(0),
            looks: 0,
            dropped: 0,
            recorder,
            store,
            class_register,
            losses: Losses::default(),
            doorkeeper,
            forget_at: Duration::ZERO,
            said: InputCounts::default(),
            say_at: Duration::ZERO,
        }
    }

    /// Runs until it is told to stop or nobody can tell it anything any more; what it could not keep.
    pub(crate) async fn run(mut self) -> Losses {
        let mut wake = tokio::time::interval(WAKE_EVERY);
        wake.set_missed_tick_behavior(MissedTickBehavior::Skip);
        let mut arrived = Vec::with_capacity(EVENTS_AT_ONCE);
        // how long it has waited for news; its own work is no quiet, however long it takes
        let (mut every, mut waited) = (WAKE_EVERY, Duration::ZERO);
        loop {
            let waits_from = Instant::now();
            tokio::select! {
                // time before news, always, so that a run can be repeated from a seed
                biased;
                due = wake.tick() => {
                    let begun = Instant::now();
                    waited += begun - waits_from;
                    self.note_lateness(begun - due);
                    self.advance();
                    self.transmit();
                    self.figures.note_wake(begun.elapsed());
                }
                count = self.events.recv_many(&mut arrived, EVENTS_AT_ONCE) => {
                    if count == 0 {
                        return self.losses;
                    }
                    waited = Duration::ZERO;
                    if every > WAKE_EVERY {
                        // whoever comes finds the room at today's tick
                        self.advance();
                    }
                }
            }
            for event in arrived.drain(..) {
                if !self.handle(event) {
                    self.room.close();
                    self.transmit();
                    self.end_recording().await;
                    self.end_store().await;
                    if let Some(class_register) = self.class_register.take() {
                        class_register.end().await;
                    }
                    let losses = self.losses;
                    self.say_goodbye().await;
                    return losses;
                }
            }
            self.transmit();
            let before = every;
            every = match waited > QUIET_AFTER {
                _ if self.links.is_empty() => REST_EVERY,
                true => QUIET_EVERY,
                false => WAKE_EVERY,
            };
            if every > WAKE_EVERY || before > WAKE_EVERY {
                wake.reset_after(every);
            }
        }
    }

    /// Counts a wake-up that came too long after it was due.
    fn note_lateness(&mut self, by: Duration) {
        if by > LATE && !self.links.is_empty() {
            self.figures.late += 1;
            tracing::debug!(?by, "the tick fell behind");
        }
    }

    fn advance(&mut self) {
        let now = self.started.elapsed();
        let due = now.as_millis() as u64;
        self.look_at_lines((due + 1).saturating_sub(self.room.now().0), now);
        if due >= self.look_at {
            self.look_at = due + LOOK_EVERY;
            self.keep_pots();
            if let Some(class_register) = &mut self.class_register {
                class_register.follow(&self.room);
            }
            self.look_at_addresses(now);
        }
        self.workers.advance(&mut self.room, Tick(due), self.started.elapsed());
        if self.recorder.as_mut().is_some_and(|recorder| !recorder.take(&mut self.room)) {
            self.recorder = None;
            // what nobody takes over would pile up
            self.room.end_journal();
            self.losses.has_broken_recording = true;
        }
    }

    /// Looks at the next lines, some with each of the ticks that are to be done: all of them at once would keep a snapshot waiting.
    fn look_at_lines(&mut self, ticks: u64, now: Duration) {
        self.looks += ticks * self.links.len() as u64;
        let count = (self.looks / LOOK_EVERY) as usize;
        self.looks %= LOOK_EVERY;
        for _ in 0..count.min(self.links.len()) {
            let mut after = self.links.range((Excluded(self.looked_at), Unbounded)).chain(&self.links);
            let Some(&peer) = after.next().map(|(peer, _)| peer) else { return };
            let Some(link) = self.links.get_mut(&peer) else { return };
            let Look { has_lost, telling } = link.look(now);
            if has_lost {
                self.room.handle_loss(peer);
            }
            self.room.set_telling(peer, telling);
            self.room.set_datagram_bytes(peer, link.datagram_bytes());
            self.looked_at = peer;
        }
    }

    /// Looks at the next pots that are to be kept.
    fn keep_pots(&mut self) {
        let (room, Some(store)) = (&self.room, &mut self.store) else { return };
        let is_left = |wheel| room.people_at(wheel) == 0 || room.is_closed(wheel);
        store.look(self.started.elapsed(), |wheel| mark(room, wheel), is_left, |wheel| pot_file(room, wheel));
    }

    /// Forgets addresses from which nothing came for a while, and says that one sends too much, now and then; never which.
    fn look_at_addresses(&mut self, now: Duration) {
        if now >= self.forget_at {
            self.forget_at = now + FORGET_EVERY;
            self.doorkeeper.forget_idle();
        }
        let counts = self.doorkeeper.counts();
        if counts != self.said && now >= self.say_at {
            self.say_at = now + SAY_EVERY;
            let InputCounts { unheard, held } = std::mem::replace(&mut self.said, counts);
            let (datagrams, requests) = (counts.unheard - unheard, counts.held - held);
            tracing::warn!(datagrams, requests, "an address sends more than its people may: too much is not heard");
        }
    }

    async fn end_store(&mut self) {
        let Some(store) = self.store.take() else { return };
        let room = &self.room;
        for trouble in store.finish(|wheel| mark(room, wheel), |wheel| pot_file(room, wheel)).await {
            tracing::error!("a pot is not kept: {trouble}");
            self.losses.pots += 1;
        }
    }

    /// Tells the doorkeeper who had a wrong code.
    fn note_wrong_codes(&mut self) {
        while let Some(peer) = self.room.poll_wrong_code() {
            if let Some(link) = self.links.get(&peer) {
                self.doorkeeper.note_wrong_code(link.address());
            }
        }
    }

    /// Everybody was told and nothing is pressed any more, so that waiting for the disk delays nobody.
    async fn end_recording(&mut self) {
        let Some(recorder) = self.recorder.take() else { return };
        let last = recorder.last(&mut self.room);
        let is_whole = tokio::task::spawn_blocking(move || last.write()).await.unwrap_or_else(|error| {
            tracing::error!(%error, "the recording did not end well");
            false
        });
        self.losses.has_broken_recording |= !is_whole;
    }

    /// False when the server is to stop.
    fn handle(&mut self, event: Event) -> bool {
        match event {
            Event::Connected(peer, link) => {
                self.links.insert(peer, link);
            }
            Event::Control(peer, frame) => {
                // one that was refused greets only once
                if self.links.get(&peer).is_none_or(|link| link.is_over()) {
                    return true;
                }
                self.room.handle_control(peer, &frame);
                self.note_wrong_codes();
                if let Some(link) = self.links.get_mut(&peer) {
                    if self.room.is_in(peer) { link.let_in() } else { link.end() }
                }
            }
            Event::Datagram(peer, bytes) => self.room.handle_datagram(peer, &bytes),
            Event::Gone(peer) => self.forget(peer),
            Event::Standing(answer) => {
                // whoever asked may have given up
                drop(answer.send(self.standing()));
            }
            Event::Figures(answer) => drop(answer.send(self.figures())),
            Event::Lesson(answer) => drop(answer.send(Lesson::of(&self.room))),
            Event::Order(token, order, answer) => {
                let outcome = self.room.order_from_outside(&token, &order);
                drop(answer.send(outcome.map(|()| self.room.code().to_owned())));
            }
            Event::Stop => return false,
        }
        true
    }

    /// Lets a peer go, and keeps what was counted of its line.
    fn forget(&mut self, peer: PeerId) {
        self.dropped += self.links.remove(&peer).map_or(0, |link| link.dropped());
        self.room.handle_gone(peer);
    }

    fn standing(&self) -> Standing {
        let wheels = 0..self.room.wheels();
        Standing {
            ticks: self.room.now().0,
            people: self.room.people(),
            digests: wheels.clone().filter_map(|wheel| self.room.digest(wheel)).collect(),
            pots: wheels.filter_map(|wheel| self.room.pot(wheel).cloned()).collect(),
            counts: self.room.counts(),
            late: self.figures.late,
            dropped_datagrams: self.dropped_datagrams(),
        }
    }

    fn figures(&self) -> Figures {
        Figures {
            ticks: self.room.now().0,
            people: self.room.people(),
            dropped_datagrams: self.dropped_datagrams(),
            people_at: (0..self.room.wheels()).map(|wheel| self.room.people_at(wheel)).collect(),
            turned_away: self.doorkeeper.turned_away(),
            input: self.doorkeeper.counts(),
            store: self.store.as_ref().map_or_else(Default::default, Store::counts),
            counts: self.room.counts(),
            ..self.figures.clone()
        }
    }

    fn dropped_datagrams(&self) -> u64 {
        self.dropped + self.links.values().map(|link| link.dropped()).sum::<u64>()
    }

    fn transmit(&mut self) {
        while let Some(transmit) = self.room.poll_transmit() {
            let Some(link) = self.links.get(&transmit.to) else { continue };
            let keeps_up = match transmit.lane {
                Lane::Datagram(bytes) => {
                    self.figures.note_datagram(bytes.len());
                    if bytes.len() > ANY_PATH {
                        // it may have shrunk or grown since the last pulse
                        self.room.set_datagram_bytes(transmit.to, link.datagram_bytes());
                    }
                    link.send_datagram(bytes);
                    true
                }
                Lane::Keyframe(bytes) => {
                    link.send_keyframe(bytes);
                    true
                }
                Lane::Control(bytes) => link.send_control(bytes),
                Lane::Close => link.finish(),
            };
            if !keeps_up {
                tracing::info!(peer = transmit.to.0, "a peer that does not keep up is let go");
                link.drop_connection();
                self.forget(transmit.to);
            }
        }
    }

    /// Waits, for a bounded time, until every control stream is through.
    async fn say_goodbye(self) {
        let all = async {
            for (_, link) in self.links {
                link.closed().await;
            }
        };
        if tokio::time::timeout(Duration::from_secs(1), all).await.is_err() {
            tracing::debug!("some peers did not hear the goodbye");
        }
    }
}

/// When all settings that were asked for have come: whoever saw a change has seen it kept.
const SETTLED: Tick = Tick(u64::MAX);

/// What tells whether a wheel's file is still true.
pub(crate) fn mark(room: &Room, wheel: usize) -> Option<Mark> {
    Some((room.digest(wheel)?, room.conditions(wheel)?.material.at(SETTLED)))
}

/// The pot of a wheel as it is kept.
fn pot_file(room: &Room, wheel: usize) -> Option<PotFile> {
    Some(PotFile::of(room.pot(wheel)?, room.conditions(wheel)?, SETTLED))
}
