//! The client's end of a connection that only looks on: any number of wheels, each at the detail that was asked for.
//!
//! Owns a replica of each sight; predicts nothing, since nobody here presses. Holds no clock and no socket.
//! Invariant: while the detail of a wheel changes, the sight there was stays until the new one is whole and as new.

use alloc::collections::{BTreeMap, VecDeque};
use alloc::string::String;
use alloc::sync::Arc;
use alloc::vec::Vec;
use core::time::Duration;

use super::course::Implausible;
use super::effort::Effort;
use super::mending::MendCounts;
use super::retelling::UNLIKE_MAX;
use super::setting::{self, Setting};
use super::watched::{ASK_AGAIN_AFTER, WatchCounts, Watched};
use super::welcome::pot_of;
use super::{ClassView, ClientError, greeting, target_of};
use crate::clay::{MethodKind, Pot, PotSpec, Target};
use crate::protocol::{self, Hello, Keyframe, NewsWire, Notice, Pass, Purpose, Request, Sight, SightName};
use crate::snapshot::Detail;
use crate::tool::ConvexTool;
use crate::units::Tick;

/// What there is of one wheel.
#[derive(Debug, Default)]
struct Place {
    shown: Option<Watched>,
    /// At another detail, not yet whole.
    coming: Option<Watched>,
    /// What another connection showed, until there is something of this one.
    past: Option<Watched>,
    /// What everybody there was told, for who looks closely.
    setting: Option<Setting>,
}

impl Place {
    fn sights(&mut self) -> impl Iterator<Item = &mut Watched> {
        self.shown.iter_mut().chain(&mut self.coming)
    }

    /// Those who press again know how the wheel turns from what they were told.
    fn turn(&mut self) {
        let Some(setting) = &self.setting else { return };
        for sight in self.shown.iter_mut().chain(&mut self.coming) {
            sight.turn(&setting.conditions.wheel);
        }
    }
}

/// A client that looks on.
#[derive(Debug)]
pub struct Watcher {
    pot: Pot,
    method: MethodKind,
    wheels: u16,
    round_trip: Duration,
    places: BTreeMap<u16, Place>,
    control: VecDeque<Vec<u8>>,
    /// Of sights that are no longer watched.
    before: WatchCounts,
    class: ClassView,
    /// What the pots are to become.
    target: Option<Target>,
    is_closing: bool,
    effort: Effort,
    /// Whether it keeps up with pressing again what is pressed where it looks.
    keeps_up: bool,
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
            method: MethodKind::from_number(audience.method),
            wheels: audience.wheels,
            round_trip,
            places: BTreeMap::new(),
            control: VecDeque::new(),
            before: WatchCounts::default(),
            class: ClassView::default(),
            target: None,
            is_closing: false,
            effort: Effort::default(),
            keeps_up: true,
        })
    }

    /// What the pots of the studio are made of.
    #[must_use]
    pub const fn pot_spec(&self) -> &PotSpec {
        self.pot.spec()
    }

    /// Wheels of which a sight is on its way in the place of another.
    #[must_use]
    pub fn changing(&self) -> usize {
        self.places.values().filter(|place| place.coming.is_some() && place.shown.is_some()).count()
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

    /// What the pots are to become, if anything.
    #[must_use]
    pub const fn target(&self) -> Option<&Target> {
        self.target.as_ref()
    }

    /// Whether the server has said that it stops.
    #[must_use]
    pub const fn is_closing(&self) -> bool {
        self.is_closing
    }

    /// Goes on where the session of another connection ended: what that looked at is asked for anew, and shown as it was until it
    /// has come. That session sees nothing afterwards.
    ///
    /// # Errors
    /// [`ClientError::Otherwise`] when the studio has other pots or wheels now; nothing was taken then.
    pub fn go_on_from(&mut self, before: &mut Self, now: Duration) -> Result<(), ClientError> {
        if (*before.pot.spec(), before.method, before.wheels) != (*self.pot.spec(), self.method, self.wheels) {
            return Err(ClientError::Otherwise);
        }
        (self.before, self.keeps_up) = (before.counts(), before.keeps_up);
        for (wheel, Place { shown, coming, past, .. }) in core::mem::take(&mut before.places) {
            let details = [&coming, &shown, &past].map(|sight| sight.as_ref().map(Watched::detail));
            let Some(detail) = details.into_iter().flatten().next() else { continue };
            self.places.entry(wheel).or_default().past = shown.or(past);
            self.watch(wheel, detail, now);
        }
        Ok(())
    }

    /// Begins to watch a wheel, or watches it at another detail from now on: what there is of it is shown until the new sight
    /// is whole. Who does not keep up with [`Detail::RETOLD`] gets [`Detail::SPECTATOR`], until it is tried again; where the wheel is
    /// shown in as many ways as it can be, [`Detail::preset`] takes the place of one without a name.
    pub fn watch(&mut self, wheel: u16, detail: Detail, now: Duration) {
        let detail = if detail.is_retold() && !self.keeps_up { Detail::SPECTATOR } else { detail };
        self.turn_to(wheel, detail, now + self.round_trip + ASK_AGAIN_AFTER);
    }

    fn turn_to(&mut self, wheel: u16, detail: Detail, patience: Duration) {
        let place = self.places.entry(wheel).or_default();
        if place.coming.as_ref().is_some_and(|coming| coming.detail() == detail) {
            return;
        }
        let given_up = place.coming.take();
        let is_shown = place.shown.as_ref().is_some_and(|shown| shown.detail() == detail);
        let name = SightName { wheel, detail: detail.into() };
        if !is_shown {
            place.coming = Watched::new(name, detail, &self.pot, patience);
            place.turn();
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

    /// Takes in how long the caller's last [`Watcher::handle_datagram`] took: who spends more than a third of its time there
    /// gets deltas where it presses again, and tries that again after half a minute.
    pub fn handle_effort(&mut self, spent: Duration, now: Duration) {
        if let Some(keeps_up) = self.effort.handle(spent, now) {
            self.set_keeps_up(keeps_up && self.counts().unlike < UNLIKE_MAX, now);
        }
    }

    /// Whether it presses again what is pressed where it looks closely.
    #[must_use]
    pub const fn keeps_up(&self) -> bool {
        self.keeps_up
    }

    fn set_keeps_up(&mut self, keeps_up: bool, now: Duration) {
        if self.keeps_up == keeps_up {
            return;
        }
        let detail = if keeps_up { Detail::SPECTATOR } else { Detail::RETOLD };
        let is_meant = |place: &Place| {
            let newest = place.coming.as_ref().or(place.shown.as_ref());
            newest.is_some_and(|sight| sight.detail() == detail)
        };
        let meant: Vec<u16> =
            self.places.iter().filter(|(_, place)| is_meant(place)).map(|(&wheel, _)| wheel).collect();
        self.keeps_up = keeps_up;
        for wheel in meant {
            self.watch(wheel, Detail::RETOLD, now);
        }
    }

    /// A sight that was asked for is not to be had: the one with a name that serves in its place always is.
    fn do_without(&mut self, sight: SightName) {
        let Some(place) = self.places.get_mut(&sight.wheel) else { return };
        let Some(refused) = place.coming.take_if(|coming| coming.name() == sight) else { return };
        self.before += refused.counts();
        let preset = refused.detail().preset();
        if preset != refused.detail() {
            self.turn_to(sight.wheel, preset, refused.patience());
        }
    }

    fn give_up(&mut self, sight: &Watched) {
        self.before += sight.counts();
        self.request(&Request::Unwatch { sight: sight.name() });
    }

    /// A wheel as it is seen, once there is something to see.
    #[must_use]
    pub fn sight(&self, wheel: u16) -> Option<&Watched> {
        let place = self.places.get(&wheel)?;
        place.shown.as_ref().or(place.past.as_ref())
    }

    /// The same, to take what changed.
    pub fn sight_mut(&mut self, wheel: u16) -> Option<&mut Watched> {
        let place = self.places.get_mut(&wheel)?;
        place.shown.as_mut().or(place.past.as_mut())
    }

    /// The newest tick of which anything was heard on this connection.
    #[must_use]
    pub fn tick(&self) -> Option<Tick> {
        self.places.values().filter_map(|place| place.shown.as_ref()).map(Watched::tick).max()
    }

    /// The convex tools of a wheel that is looked at closely, by their number; none before they were told of.
    #[must_use]
    pub fn rack(&self, wheel: u16) -> Option<Arc<[ConvexTool]>> {
        self.places.get(&wheel)?.setting.as_ref().map(Setting::rack)
    }

    /// Whether a sight is on its way that is not shown yet, or newer clay is known of than is held.
    #[must_use]
    pub fn is_behind(&self) -> bool {
        self.places.values().any(|place| place.coming.is_some() || place.shown.as_ref().is_none_or(Watched::is_behind))
    }

    fn counts(&self) -> WatchCounts {
        let mut sum = self.before;
        for sight in self.places.values().flat_map(|place| place.shown.iter().chain(&place.coming)) {
            sum += sight.counts();
        }
        sum
    }

    /// Digests that did not match; each was mended.
    #[must_use]
    pub fn mismatches(&self) -> u64 {
        self.counts().mismatches
    }

    /// How clay that differed was mended.
    #[must_use]
    pub fn mend_counts(&self) -> MendCounts {
        self.counts().mended
    }

    /// What the server said that cannot be true, and was refused.
    #[must_use]
    pub fn implausible(&self) -> Implausible {
        self.counts().implausible
    }

    /// Snapshots that it came to by pressing again what was pressed.
    #[must_use]
    pub fn retold(&self) -> u64 {
        self.counts().retold
    }

    /// How often it asked for what was missing.
    #[must_use]
    pub fn asked(&self) -> u64 {
        self.counts().asked
    }

    fn find(&mut self, name: SightName) -> Option<&mut Watched> {
        self.places.get_mut(&name.wheel)?.sights().find(|sight| sight.name() == name)
    }

    /// Takes in a control frame.
    ///
    /// # Errors
    /// [`ClientError`] when it makes no sense; the connection is then useless.
    pub fn handle_control(&mut self, frame: &[u8]) -> Result<(), ClientError> {
        match protocol::decode::<{ protocol::CONTROL_MAX }, Notice>(frame)? {
            Notice::Closing => self.is_closing = true,
            Notice::Refused(refusal) => return Err(refusal.into()),
            Notice::NoSight(sight) => self.do_without(sight),
            Notice::Target(target) => self.target = target.as_ref().and_then(target_of),
            Notice::News(NewsWire { wheel, told, of }) => {
                // what is no longer looked at may still be told of
                let Some(place) = self.places.get_mut(&wheel) else { return Ok(()) };
                let shape = self.pot.spec().shape;
                if !setting::hear(&mut place.setting, (told, of), (self.method, shape)) {
                    return Err(protocol::ProtocolError::Malformed { bytes: frame.len() }.into());
                }
                place.turn();
            }
            // whoever looks on has no hand to be guided or to guide with
            Notice::Guidance(_) | Notice::GuidanceEnded(_) | Notice::NoGuidance(_) => {}
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
        let place = self.places.get_mut(&name.wheel);
        // until the one that comes is as new, what is shown stands still, or it would always be newer by what the line is uneven by
        let stands_still = place.is_some_and(|place| {
            let is_shown = place.shown.as_ref().is_some_and(|shown| shown.name() == name);
            is_shown && place.coming.as_ref().is_some_and(Watched::is_whole)
        });
        let Some(watched) = self.find(name).filter(|_| !stands_still) else { return true };
        let is_sound = watched.handle(sight, now);
        self.catch_up(name, now);
        is_sound
    }

    /// Takes in a keyframe stream; false when it made no sense and was dropped.
    pub fn handle_keyframe(&mut self, bytes: &[u8], now: Duration) -> bool {
        let Ok(keyframe) = protocol::decode::<{ protocol::KEYFRAME_MAX }, Keyframe>(bytes) else { return false };
        let Some(name) = keyframe.sight else { return false };
        let Some(watched) = self.find(name) else { return true };
        if !watched.handle_keyframe(&keyframe, now) {
            return false;
        }
        self.catch_up(name, now);
        true
    }

    fn catch_up(&mut self, name: SightName, now: Duration) {
        let round_trip = self.round_trip;
        let Some(place) = self.places.get_mut(&name.wheel) else { return };
        let Place { shown, coming, setting, .. } = place;
        let watched = shown.iter_mut().chain(coming.iter_mut()).find(|sight| sight.name() == name);
        let Some(watched) = watched else { return };
        let request = watched.catch_up(setting.as_mut(), now, round_trip);
        let is_unlike = request.is_some() && watched.counts().unlike > 0;
        if let Some(request) = request {
            self.request(&request);
        }
        self.change_over(name.wheel, now);
        if is_unlike && self.counts().unlike >= UNLIKE_MAX {
            self.set_keeps_up(false, now);
        }
    }

    /// Shows what comes in place of what was shown, once it can.
    fn change_over(&mut self, wheel: u16, now: Duration) {
        let round_trip = self.round_trip;
        let Some(Place { shown, coming, past, .. }) = self.places.get_mut(&wheel) else { return };
        let shown_tick = shown.as_ref().map_or(Tick(0), Watched::tick);
        let gone = coming.take_if(|coming| coming.has_come(shown_tick, now, round_trip)).and_then(|mut come| {
            come.note_all_changed();
            *past = None;
            shown.replace(come)
        });
        if let Some(gone) = gone {
            self.give_up(&gone);
        }
    }

    fn request(&mut self, request: &Request) {
        self.control.push_back(protocol::frame(&protocol::encode(request)));
    }

    /// Asks for what is missing, if it is time; call it now and then.
    pub fn handle_time(&mut self, now: Duration) {
        let round_trip = self.round_trip;
        // what everybody was told may be all that a retelling waited for
        let waiting = self.places.values_mut().flat_map(Place::sights).filter(|sight| sight.is_behind());
        for name in waiting.map(|sight| sight.name()).collect::<Vec<_>>() {
            self.catch_up(name, now);
        }
        for wheel in self.places.keys().copied().collect::<Vec<_>>() {
            self.change_over(wheel, now);
        }
        let mut requests = Vec::new();
        for sight in self.places.values_mut().flat_map(Place::sights) {
            if let Some(request) = sight.due(now, round_trip) {
                requests.push(request);
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
