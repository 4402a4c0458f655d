//! The way back to a studio after the line broke: who one is, the server knows by the token that it gave.
//!
//! Owns the tries and their patience, for who works and for who looks on; the session that comes of it is the caller's.
//! Invariant: it leads to the server that was joined, never to one with another key.

use std::pin::pin;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use pottery_shared::protocol::{Hello, Pass, Purpose, ResumeToken};
use pottery_shared::session::{ClassView, ClientError, greeting};
use tokio::sync::mpsc;
use tokio::time::{Instant, sleep, timeout};

use crate::connection::{self, Joined, Target};
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
    purpose: Purpose,
    resume: Option<ResumeToken>,
    /// Whether the server said that it should.
    is_called: bool,
    came_at: Instant,
    short_stays: u32,
}

impl WayBack {
    /// To a studio that was joined for that purpose and showed the key of that hash.
    pub(crate) fn new(
        endpoint: quinn::Endpoint,
        target: &Target,
        purpose: Purpose,
        fingerprint: Option<[u8; 32]>,
    ) -> Self {
        let target = Target { known: target.known.or(fingerprint), ..target.clone() };
        Self { endpoint, target, purpose, resume: None, is_called: false, came_at: Instant::now(), short_stays: 0 }
    }

    /// Takes in with what one comes back, and to which wheel, as far as that was told.
    pub(crate) fn note_place(&mut self, class: &ClassView) {
        self.resume = class.resume().copied().or(self.resume);
        // a server that has begun anew knows nobody, and seats people where they say
        if let Some(place) = class.place().filter(|place| place.wheel > 0) {
            self.target.wheel = place.wheel;
        }
    }

    /// Takes in that the server asked for it.
    pub(crate) const fn note_call(&mut self) {
        self.is_called = true;
    }

    /// Takes in that one is back.
    pub(crate) fn note_return(&mut self) {
        self.came_at = Instant::now();
    }

    /// After a connection ended so: why one comes back, with what to show, or how it stands when that cannot be.
    pub(crate) fn begin(&mut self, link: Link) -> Result<(String, ResumeToken), Link> {
        let is_called = std::mem::take(&mut self.is_called);
        let reason = match link {
            Link::Lost(reason) => reason,
            Link::Closed if is_called => String::from("the place that the teacher gave you could not be taken"),
            other => return Err(other),
        };
        let Some(resume) = self.resume else { return Err(Link::Lost(reason)) };
        let is_short = self.came_at.elapsed() < STAY_AT_LEAST && !is_called;
        self.short_stays = if is_short { self.short_stays + 1 } else { 0 };
        if self.short_stays >= SHORT_STAYS_MAX { Err(Link::Lost(reason)) } else { Ok((reason, resume)) }
    }

    /// Knocks until somebody opens, for at most a minute; `open` makes a session of the answer. A teacher who is asked may take longer; `tell` is told of that,
    /// and of its end.
    ///
    /// How it stands when nobody does, or when one is refused.
    pub(crate) async fn knock<S>(
        &self,
        (reason, resume): (String, ResumeToken),
        round_trip: Duration,
        open: impl Fn(&[u8], Duration) -> Result<S, ClientError>,
        tell: impl Fn(Link),
    ) -> Result<(Joined, S), Link> {
        let greeting = greet(&self.target, self.purpose, self.target.pass_back(resume));
        let (mut began, mut tries) = (Instant::now(), 0);
        while began.elapsed() < TRIES_FOR {
            tries += 1;
            let patience = 6 * round_trip + if tries % SLOW_EVERY == 0 { SLOW_TRY_FOR } else { TRY_FOR };
            let is_heard = AtomicBool::new(false);
            let hears = || {
                is_heard.store(true, Ordering::Relaxed);
                tell(Link::Waiting);
            };
            let asked =
                connection::join_asking(&self.endpoint, &self.target, Some(round_trip), &greeting, &open, hears);
            let mut asked = pin!(asked);
            let answered = match timeout(patience, &mut asked).await {
                Err(_) if is_heard.load(Ordering::Relaxed) => Ok(asked.await),
                answered => answered,
            };
            match answered {
                Ok(Ok(joined)) => return Ok(joined),
                Ok(Err(error)) if error.is_answer() => return Err(Link::Lost(error.to_string())),
                Ok(Err(error)) => tracing::debug!(%error, "not back yet"),
                Err(_) => tracing::debug!("nobody answers yet"),
            }
            if is_heard.load(Ordering::Relaxed) {
                // it was there a moment ago
                began = Instant::now();
                tell(Link::ComingBack(reason.clone()));
            }
            sleep(TRY_EVERY).await;
        }
        Err(Link::Lost(reason))
    }
}

/// The first frame to a studio.
pub(crate) fn greet(target: &Target, purpose: Purpose, pass: Pass) -> Vec<u8> {
    let wheel = if matches!(purpose, Purpose::Works { .. }) { target.wheel } else { 0 };
    greeting(&Hello { code: target.code.room().to_owned(), wheel, purpose, pass })
}

/// Hears the frames that were said before the end, until one is not `taken`: that a connection has ended may be known before its
/// last frame was read.
pub(crate) async fn hear_the_rest(arriving: &mut mpsc::Receiver<Arrival>, mut taken: impl FnMut(&[u8]) -> bool) {
    while let Ok(Some(arrival)) = timeout(LAST_WORDS_WITHIN, arriving.recv()).await {
        match arrival {
            Arrival::Frame(frame) if taken(&frame) => {}
            Arrival::Keyframe(_) => {}
            Arrival::Frame(_) | Arrival::StreamEnded => break,
        }
    }
}
