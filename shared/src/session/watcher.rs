//! The client's end of a connection that only looks on: any number of wheels, each at the detail that was asked for.
//!
//! Owns a replica of each sight; predicts nothing, since nobody here presses. Holds no clock and no socket.
//! Invariant: while the detail of a wheel changes, the sight there was goes on until the new one is whole.

use alloc::collections::{BTreeMap, VecDeque};
use alloc::string::String;
use alloc::vec::Vec;
use core::time::Duration;

use super::assembly::{Assembly, Step, Traveller};
use super::welcome::{pot_of, remote_tool};
use super::{ClassView, ClientError, RemoteTool, greeting};
use crate::clay::{Phase, Pot, PotSpec, Surface, Wheel};
use crate::protocol::{self, Body, Hello, Keyframe, Notice, Pass, Purpose, Request, Sight, SightName};
use crate::snapshot::{Detail, Replica, SnapshotError, Touched, Version};
use crate::units::Tick;

/// Time without getting on after which what is missing is asked for: longer than packets overtake each other.
const ASK_AFTER: Duration = Duration::from_millis(60);
/// Time beside the round trip after which it is asked for again.
const ASK_AGAIN_AFTER: Duration = Duration::from_millis(300);
/// Times that it is asked for what leads on; after that, for the whole pot.
const ASK_ON_MAX: u32 = 2;

/// One wheel as it is seen.
#[derive(Debug)]
pub struct Watched {
    name: SightName,
    detail: Detail,
    replica: Replica,
    assembly: Assembly,
    /// Whether the first keyframe has come.
    is_whole: bool,
    tick: Tick,
    wheel: Wheel,
    tools: Vec<RemoteTool>,
    news: Touched,
    /// When to ask for what is missing, and how often it was asked for.
    ask: Option<(Duration, u32)>,
    counts: WatchCounts,
}

/// What was counted of one sight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct WatchCounts {
    mismatches: u64,
    asked: u64,
}

impl Watched {
    fn new(name: SightName, detail: Detail, pot: &Pot, patience: Duration) -> Option<Self> {
        let shape = detail.grid_of(pot.spec().shape);
        let pot = Pot::new(PotSpec { shape, ..*pot.spec() }).ok()?;
        let news = Touched::none(pot.surfaces().iter().map(Surface::shape));
        Some(Self {
            name,
            detail,
            replica: Replica::with_quantum(pot, detail.quantum()),
            assembly: Assembly::default(),
            is_whole: false,
            tick: Tick(0),
            wheel: Wheel::default(),
            tools: Vec::new(),
            news,
            ask: Some((patience, 0)),
            counts: WatchCounts::default(),
        })
    }

    /// How much of the wheel it is.
    #[must_use]
    pub const fn detail(&self) -> Detail {
        self.detail
    }

    /// The clay, on the grid of the detail.
    #[must_use]
    pub const fn pot(&self) -> &Pot {
        self.replica.pot()
    }

    /// Digest of the clay as it was sent.
    #[must_use]
    pub fn digest(&self) -> u64 {
        self.replica.digest()
    }

    /// The tick of which the clay was last heard.
    #[must_use]
    pub const fn tick(&self) -> Tick {
        self.tick
    }

    /// How the wheel turns.
    #[must_use]
    pub const fn wheel(&self) -> &Wheel {
        &self.wheel
    }

    /// Everybody's tools.
    #[must_use]
    pub fn tools(&self) -> &[RemoteTool] {
        &self.tools
    }

    /// Moves the tiles in which the clay changed since the last call into `changed`, which is of the same grid.
    pub fn take_changed(&mut self, changed: &mut Touched) {
        changed.add_all(&self.news);
        self.news.clear();
    }

    fn handle(&mut self, sight: Sight) -> bool {
        let Sight { turning, body, .. } = sight;
        let tick = Tick(body.tick);
        if tick >= self.tick {
            self.tick = tick;
            if let Some(turning) = turning {
                self.wheel = Wheel::starting_at(Tick(turning.from), Phase(turning.phase), turning.rate);
            }
            if let Some(tools) = &body.tools {
                self.tools = tools.iter().filter_map(remote_tool).collect();
            }
        }
        self.assembly.handle(Body { tools: None, ..body }, 0, self.replica.version())
    }

    /// Applies what is whole; true when something has to be asked for now.
    fn catch_up(&mut self, now: Duration) -> Option<u32> {
        let held = self.replica.version();
        let mut is_wrong = false;
        if let Some((version, _)) = self.assembly.reachable(held, self.traveller()) {
            while !is_wrong && self.replica.version() < version {
                is_wrong = self.step().is_err();
            }
            self.assembly.forget(self.replica.version());
        }
        if self.is_whole
            && let Some(digest) = self.assembly.take_digest(self.replica.version())
            && digest != self.replica.digest()
        {
            self.counts.mismatches += 1;
            is_wrong = true;
        }
        if is_wrong {
            self.ask = Some((now + ASK_AGAIN_AFTER, ASK_ON_MAX));
            return Some(0);
        }
        if self.replica.version() > held || (self.is_whole && self.assembly.latest() <= self.replica.version()) {
            self.ask = None;
        }
        None
    }

    fn step(&mut self) -> Result<(), SnapshotError> {
        let next = self.replica.version().next();
        match self.assembly.take(next, self.traveller()) {
            Some(Step::Delta(bytes)) => self.replica.apply_delta(next, &bytes, &mut self.news),
            _ => Err(SnapshotError::NotNext { delta: next, held: self.replica.version() }),
        }
    }

    /// The version to be asked on from, if it is time.
    fn due(&mut self, now: Duration, round_trip: Duration) -> Option<u32> {
        let is_behind = !self.is_whole || self.assembly.latest() > self.replica.version();
        if !is_behind {
            return None;
        }
        let (at, times) = *self.ask.get_or_insert((now + ASK_AFTER, 0));
        if now < at {
            return None;
        }
        self.ask = Some((now + round_trip + ASK_AGAIN_AFTER, times + 1));
        Some(if self.is_whole && times < ASK_ON_MAX { self.replica.version().0 } else { 0 })
    }

    const fn traveller(&self) -> Traveller {
        Traveller { told: 0, takes_deltas: self.replica.takes_deltas() }
    }
}

/// What there is of one wheel.
#[derive(Debug, Default)]
struct Place {
    shown: Option<Watched>,
    /// At another detail, not yet whole.
    coming: Option<Watched>,
}

/// A client that looks on.
#[derive(Debug)]
pub struct Watcher {
    pot: Pot,
    wheels: u16,
    round_trip: Duration,
    places: BTreeMap<u16, Place>,
    control: VecDeque<Vec<u8>>,
    /// Of sights that are no longer watched.
    before: WatchCounts,
    class: ClassView,
    is_closing: bool,
}

impl Watcher {
    /// The first frame to send, by one who wants no more than so many bytes a second for long.
    #[must_use]
    pub fn greeting(code: &str, bytes_per_s: u32) -> Vec<u8> {
        let purpose = Purpose::Watches { bytes_per_s };
        greeting(&Hello { code: String::from(code), wheel: 0, purpose, pass: Pass::None })
    }

    /// The session that the server's first frame opens.
    ///
    /// # Errors
    /// [`ClientError`] when the server refuses or cannot be understood.
    pub fn open(answer: &[u8], round_trip: Duration) -> Result<Self, ClientError> {
        let audience = match protocol::decode::<{ protocol::CONTROL_MAX }, Notice>(answer)? {
            Notice::Audience(audience) => audience,
            Notice::Refused(refusal) => return Err(refusal.into()),
            Notice::Waiting => return Err(ClientError::Waiting),
            _ => return Err(protocol::ProtocolError::Malformed { bytes: answer.len() }.into()),
        };
        let pot =
            pot_of(&audience.pot, audience.method).map_err(|error| ClientError::Pot(alloc::format!("{error}")))?;
        Ok(Self {
            pot,
            wheels: audience.wheels,
            round_trip,
            places: BTreeMap::new(),
            control: VecDeque::new(),
            before: WatchCounts::default(),
            class: ClassView::default(),
            is_closing: false,
        })
    }

    /// Number of wheels; they are numbered from 1.
    #[must_use]
    pub const fn wheels(&self) -> u16 {
        self.wheels
    }

    /// What it knows of the lesson.
    #[must_use]
    pub const fn class(&self) -> &ClassView {
        &self.class
    }

    /// Whether the server has said that it stops.
    #[must_use]
    pub const fn is_closing(&self) -> bool {
        self.is_closing
    }

    /// Begins to watch a wheel, or watches it at another detail from now on: what there is of it is shown until the new sight
    /// is whole.
    pub fn watch(&mut self, wheel: u16, detail: Detail, now: Duration) {
        let place = self.places.entry(wheel).or_default();
        if place.coming.as_ref().is_some_and(|coming| coming.detail == detail) {
            return;
        }
        let given_up = place.coming.take();
        let is_shown = place.shown.as_ref().is_some_and(|shown| shown.detail == detail);
        let name = SightName { wheel, detail: detail.number() };
        if !is_shown {
            place.coming = Watched::new(name, detail, &self.pot, now + self.round_trip + ASK_AGAIN_AFTER);
            self.request(&Request::Watch { sight: name, have: 0 });
        }
        if let Some(given_up) = given_up {
            self.give_up(&given_up);
        }
    }

    /// Watches a wheel no longer.
    pub fn unwatch(&mut self, wheel: u16) {
        let place = self.places.remove(&wheel).unwrap_or_default();
        for sight in [place.shown, place.coming].into_iter().flatten() {
            self.give_up(&sight);
        }
    }

    fn give_up(&mut self, sight: &Watched) {
        self.before.mismatches += sight.counts.mismatches;
        self.before.asked += sight.counts.asked;
        self.request(&Request::Unwatch { sight: sight.name });
    }

    /// A wheel as it is seen, once there is something to see.
    #[must_use]
    pub fn sight(&self, wheel: u16) -> Option<&Watched> {
        self.places.get(&wheel)?.shown.as_ref()
    }

    /// The same, to take what changed.
    pub fn sight_mut(&mut self, wheel: u16) -> Option<&mut Watched> {
        self.places.get_mut(&wheel)?.shown.as_mut()
    }

    /// Whether a sight is on its way that is not shown yet, or newer clay is known of than is held.
    #[must_use]
    pub fn is_behind(&self) -> bool {
        self.places.values().any(|place| {
            let lags = |sight: &Watched| sight.assembly.latest() > sight.replica.version();
            place.coming.is_some() || place.shown.as_ref().is_none_or(lags)
        })
    }

    /// Digests that did not match; each was mended by asking for the whole pot.
    #[must_use]
    pub fn mismatches(&self) -> u64 {
        self.before.mismatches + self.all().map(|sight| sight.counts.mismatches).sum::<u64>()
    }

    /// How often it asked for what was missing.
    #[must_use]
    pub fn asked(&self) -> u64 {
        self.before.asked + self.all().map(|sight| sight.counts.asked).sum::<u64>()
    }

    fn all(&self) -> impl Iterator<Item = &Watched> {
        self.places.values().flat_map(|place| place.shown.iter().chain(&place.coming))
    }

    fn find(&mut self, name: SightName) -> Option<&mut Watched> {
        let place = self.places.get_mut(&name.wheel)?;
        [&mut place.shown, &mut place.coming].into_iter().flatten().find(|sight| sight.name == name)
    }

    /// Takes in a control frame.
    ///
    /// # Errors
    /// [`ClientError`] when it makes no sense; the connection is then useless.
    pub fn handle_control(&mut self, frame: &[u8]) -> Result<(), ClientError> {
        match protocol::decode::<{ protocol::CONTROL_MAX }, Notice>(frame)? {
            Notice::Closing => self.is_closing = true,
            Notice::Refused(refusal) => return Err(refusal.into()),
            notice => {
                let known = self.class.handle(notice);
                known.ok_or(protocol::ProtocolError::Malformed { bytes: frame.len() })?;
            }
        }
        Ok(())
    }

    /// Takes in a datagram; false when it made no sense and was dropped. One of a sight that is no longer watched is not
    /// looked at.
    pub fn handle_datagram(&mut self, bytes: &[u8], now: Duration) -> bool {
        let Ok(sight) = protocol::decode::<{ protocol::DATAGRAM_MEMORY_MAX }, Sight>(bytes) else { return false };
        let name = sight.name;
        let Some(watched) = self.find(name) else { return true };
        let is_sound = watched.handle(sight);
        self.catch_up(name, now);
        is_sound
    }

    /// Takes in a keyframe stream; false when it made no sense and was dropped.
    pub fn handle_keyframe(&mut self, bytes: &[u8], now: Duration) -> bool {
        let Ok(keyframe) = protocol::decode::<{ protocol::KEYFRAME_MAX }, Keyframe>(bytes) else { return false };
        let Some(name) = keyframe.sight else { return false };
        let Some(watched) = self.find(name) else { return true };
        let (version, since) = (Version(keyframe.version), Version(keyframe.since));
        if version < watched.replica.version() {
            return true;
        }
        let Keyframe { bytes, goes_on, .. } = &keyframe;
        match watched.replica.apply_keyframe(version, since, bytes, *goes_on, &mut watched.news) {
            Ok(()) => {
                watched.is_whole = true;
                watched.ask = None;
                watched.tick = watched.tick.max(Tick(keyframe.tick));
            }
            // it leads on from what was lost as well; that is asked for
            Err(SnapshotError::NotNext { .. }) => {}
            Err(_) => return false,
        }
        watched.assembly.forget(watched.replica.version());
        self.catch_up(name, now);
        true
    }

    fn catch_up(&mut self, name: SightName, now: Duration) {
        let Some(watched) = self.find(name) else { return };
        if let Some(have) = watched.catch_up(now) {
            watched.counts.asked += 1;
            self.request(&Request::Watch { sight: name, have });
        }
        let Some(place) = self.places.get_mut(&name.wheel) else { return };
        if let Some(come) = place.coming.take_if(|coming| coming.is_whole)
            && let Some(gone) = place.shown.replace(come)
        {
            self.give_up(&gone);
        }
    }

    fn request(&mut self, request: &Request) {
        self.control.push_back(protocol::frame(&protocol::encode(request)));
    }

    /// Asks for what is missing, if it is time; call it now and then.
    pub fn handle_time(&mut self, now: Duration) {
        let round_trip = self.round_trip;
        let mut requests = Vec::new();
        for sight in self.places.values_mut().flat_map(|place| place.shown.iter_mut().chain(&mut place.coming)) {
            if let Some(have) = sight.due(now, round_trip) {
                sight.counts.asked += 1;
                requests.push(Request::Watch { sight: sight.name, have });
            }
        }
        for request in requests {
            self.request(&request);
        }
    }

    /// Says goodbye.
    pub fn leave(&mut self) {
        self.request(&Request::Leave);
    }

    /// The next control frame to send.
    pub fn poll_control(&mut self) -> Option<Vec<u8>> {
        self.control.pop_front()
    }
}
