//! Coming back: to the own seat when the line broke, to another one when the teacher says so.
//!
//! Owns the tries and their patience; who one is, the server knows by the token that it gave.
//! Invariant: meanwhile the tool is lifted, and what the hand made is not pressed afterwards.

use std::time::Duration;

use pottery_shared::protocol::{Hello, Pass, Purpose, ResumeToken};
use pottery_shared::session::{ClassEvent, Client, ClientError, ClientEvent, greeting};
use pottery_shared::snapshot::TileLayout;
use tokio::time::{Instant, sleep, timeout};

use super::{Command, Worker};
use crate::connection::{self, JoinError, Joined, Target};
use crate::streams::Arrival;
use crate::view::Link;

/// Time between two tries.
const TRY_EVERY: Duration = Duration::from_millis(100);
/// Time for one, beside six round trips: what was sent into a dead line is sent anew ever more rarely.
const TRY_FOR: Duration = Duration::from_millis(300);
/// Every so manieth try may take longer: the line may have become slow.
const SLOW_EVERY: u32 = 4;
const SLOW_TRY_FOR: Duration = Duration::from_millis(1500);
/// Time in which the last frame of a connection is read.
const LAST_WORDS_WITHIN: Duration = Duration::from_millis(200);
/// Time after which it gives up.
const TRIES_FOR: Duration = Duration::from_secs(60);
/// A stay shorter than this was none.
const STAY_AT_LEAST: Duration = Duration::from_secs(2);
/// Stays in a row that were none, after which it gives up.
const SHORT_STAYS_MAX: u32 = 5;

/// What somebody needs to come back.
#[derive(Debug)]
pub(crate) struct WayBack {
    endpoint: quinn::Endpoint,
    target: Target,
    /// Local tick n is due n milliseconds after it.
    pub(super) epoch: Instant,
    resume: Option<ResumeToken>,
    /// Whether the server said that it should.
    is_called: bool,
    came_at: Instant,
    short_stays: u32,
}

impl WayBack {
    pub(crate) fn new(endpoint: quinn::Endpoint, target: Target, epoch: Instant) -> Self {
        Self { endpoint, target, epoch, resume: None, is_called: false, came_at: Instant::now(), short_stays: 0 }
    }

    /// Asks to be let in again.
    async fn knock(&self, resume: ResumeToken, round_trip: Duration) -> Result<(Joined, Client), JoinError> {
        let (Target { code, wheel, .. }, epoch) = (&self.target, self.epoch);
        let hello = Hello {
            code: code.room().to_owned(),
            wheel: *wheel,
            purpose: Purpose::Works { retells: true },
            pass: Pass::Resume(resume),
        };
        let open = |answer: &[u8], measured| Client::open(answer, epoch.elapsed().as_millis() as u64, measured);
        connection::join_again(&self.endpoint, &self.target, Some(round_trip), &greeting(&hello), open).await
    }
}

impl Worker {
    /// Takes in what was told of the lesson.
    pub(super) fn hear_of_class(&mut self, event: ClassEvent) {
        let class = self.session.class();
        let mut view = self.view.lock();
        match event {
            ClassEvent::Place => {
                self.way_back.resume = class.resume().copied().or(self.way_back.resume);
                self.side.status().hold(!class.may_press());
            }
            ClassEvent::Come => {
                self.way_back.is_called = true;
                self.side.status().hold(true);
            }
            ClassEvent::NoOrder(reason) => view.no_order = Some(reason),
            ClassEvent::People | ClassEvent::Class => {}
        }
        view.class.clone_from(class);
    }

    /// Comes back after the connection ended so; how it stands when that cannot be.
    pub(super) async fn come_back(&mut self, link: Link) -> Result<(), Link> {
        self.hear_the_rest().await;
        let is_called = std::mem::take(&mut self.way_back.is_called);
        let reason = match link {
            Link::Lost(reason) => reason,
            Link::Closed if is_called => String::from("the place that the teacher gave you could not be taken"),
            other => return Err(other),
        };
        let Some(resume) = self.way_back.resume else { return Err(Link::Lost(reason)) };
        if self.way_back.came_at.elapsed() < STAY_AT_LEAST && !is_called {
            self.way_back.short_stays += 1;
        } else {
            self.way_back.short_stays = 0;
        }
        if self.way_back.short_stays >= SHORT_STAYS_MAX {
            return Err(Link::Lost(reason));
        }
        self.side.status().hold(true);
        self.view.lock().link = Link::ComingBack(reason.clone());
        let round_trip = self.connection.rtt();
        let (began, mut tries) = (Instant::now(), 0);
        while began.elapsed() < TRIES_FOR {
            tries += 1;
            let patience = 6 * round_trip + if tries % SLOW_EVERY == 0 { SLOW_TRY_FOR } else { TRY_FOR };
            match timeout(patience, self.way_back.knock(resume, round_trip)).await {
                Ok(Ok((joined, session))) => return self.sit_down(joined, session),
                // it was refused: more tries would be refused as well
                Ok(Err(JoinError::Session(ClientError::Refused(refusal)))) => {
                    return Err(Link::Lost(refusal.to_string()));
                }
                Ok(Err(error)) => tracing::debug!(%error, "not back yet"),
                Err(_) => tracing::debug!("nobody answers yet"),
            }
            tokio::select! {
                () = sleep(TRY_EVERY) => {}
                command = self.commands.recv() => if matches!(command, Some(Command::Leave) | None) {
                    return Err(Link::Closed);
                },
            }
        }
        Err(Link::Lost(reason))
    }

    /// Hears what was said before the end: that a connection has ended may be known before its last frame was read.
    async fn hear_the_rest(&mut self) {
        while let Ok(Some(arrival)) = timeout(LAST_WORDS_WITHIN, self.arriving.recv()).await {
            match arrival {
                Arrival::Frame(frame) if self.session.handle_control(&frame).is_ok() => {}
                Arrival::Keyframe(_) => {}
                Arrival::Frame(_) | Arrival::StreamEnded => break,
            }
        }
        while let Some(event) = self.session.poll_event() {
            if let ClientEvent::Class(event) = event {
                self.hear_of_class(event);
            }
        }
    }

    /// Goes on with a new connection, at the wheel that it leads to.
    fn sit_down(&mut self, joined: Joined, session: Client) -> Result<(), Link> {
        let before = self.session.predicted().spec().shape;
        if session.predicted().spec().shape != before {
            joined.connection.close(0, b"");
            return Err(Link::Lost("the studio has pots of another grid now: join it anew".into()));
        }
        // what was made meanwhile was made on other clay
        while self.side.next_sample().is_some() {}
        self.add_counts();
        (self.connection, self.outgoing) = (joined.connection, joined.streams.outgoing);
        self.arriving = joined.streams.arriving;
        self.session = session;
        self.guiding.forget(&mut self.side, &self.view);
        self.way_back.came_at = Instant::now();
        self.side.status().set_tick_offset(self.session.tick_offset());
        self.side.publish(|patch| self.session.patch_into(patch));
        let mut view = self.view.lock();
        let view = &mut *view;
        let mut all = view.changed.emptied();
        for (number, surface) in self.session.predicted().surfaces().iter().enumerate() {
            for tile in 0..TileLayout::new(surface.shape()).tiles() {
                all.add(number, tile);
            }
        }
        for (surface, _, window) in all.iter() {
            view.pot.copy_window(self.session.predicted(), surface, window);
        }
        view.picture.correct(&view.pot, &all);
        view.picture.draw(&view.pot, &all, self.epoch.elapsed(), &mut view.changed);
        view.number = self.session.number();
        view.rack = self.session.rack();
        view.link = Link::Open;
        Ok(())
    }
}
