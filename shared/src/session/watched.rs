//! One wheel as somebody sees it who only looks on: its replica, and what is asked for to keep it whole.
//!
//! Holds no clock; the connection and the other wheels are the watcher's.
//! Invariant: from a difference on until clay has come that mends it, no snapshot is gone to.

use alloc::vec::Vec;
use core::time::Duration;

use super::RemoteTool;
use super::assembly::{Assembly, Step, Traveller};
use super::course::{Course, Implausible, Word};
use super::mending::{MendCounts, Mending};
use super::retelling::press_again;
use super::setting::Setting;
use super::welcome::remote_tool;
use crate::clay::{Phase, Pot, PotSpec, Surface, Wheel};
use crate::protocol::{Body, Keyframe, Request, Sight, SightName};
use crate::snapshot::{Detail, Replica, SnapshotError, TileLayout, Touched, Version};
use crate::units::Tick;

/// Time without getting on after which what is missing is asked for: longer than packets overtake each other.
const ASK_AFTER: Duration = Duration::from_millis(60);
/// Time beside the round trip after which it is asked for again.
pub(super) const ASK_AGAIN_AFTER: Duration = Duration::from_millis(300);
/// Times that it is asked for what leads on; after that, for the whole pot.
const ASK_ON_MAX: u32 = 2;

/// One wheel as it is seen.
#[derive(Debug)]
pub struct Watched {
    name: SightName,
    detail: Detail,
    replica: Replica,
    assembly: Assembly,
    course: Course,
    /// Whether the first keyframe has come.
    is_whole: bool,
    /// When it did.
    whole_at: Duration,
    tick: Tick,
    wheel: Wheel,
    tools: Vec<RemoteTool>,
    news: Touched,
    /// When to ask for what is missing, and how often it was asked for.
    ask: Option<(Duration, u32)>,
    mending: Mending,
    counts: WatchCounts,
}

/// What was counted of one sight.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct WatchCounts {
    pub(super) mismatches: u64,
    pub(super) asked: u64,
    pub(super) mended: MendCounts,
    /// Snapshots that it came to by pressing again, and of those with other clay than the author's.
    pub(super) retold: u64,
    pub(super) unlike: u64,
    pub(super) implausible: Implausible,
}

impl core::ops::AddAssign for WatchCounts {
    fn add_assign(&mut self, other: Self) {
        self.mismatches += other.mismatches;
        self.asked += other.asked;
        self.mended += other.mended;
        self.retold += other.retold;
        self.unlike += other.unlike;
        self.implausible += other.implausible;
    }
}

impl Watched {
    pub(super) fn new(name: SightName, detail: Detail, pot: &Pot, patience: Duration) -> Option<Self> {
        let shape = detail.grid_of(pot.spec().shape);
        let pot = Pot::new(PotSpec { shape, ..*pot.spec() }).ok()?;
        let news = Touched::none(pot.surfaces().iter().map(Surface::shape));
        Some(Self {
            name,
            detail,
            replica: Replica::with_quantum(pot, detail.quantum()),
            assembly: Assembly::default(),
            course: Course::default(),
            is_whole: false,
            whole_at: Duration::ZERO,
            tick: Tick(0),
            wheel: Wheel::default(),
            tools: Vec::new(),
            news,
            ask: Some((patience, 0)),
            mending: Mending::default(),
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

    /// The snapshot that is held, of this sight's own chain.
    #[must_use]
    pub const fn version(&self) -> Version {
        self.replica.version()
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

    pub(super) fn handle(&mut self, sight: Sight, now: Duration) -> bool {
        let Sight { turning, body, .. } = sight;
        let tick = Tick(body.tick);
        if !self.hear((tick, Version(body.latest)), now, true) {
            return false;
        }
        // a time that was believed wrongly is over when the server's is another
        if tick >= self.tick.min(self.course.tick()) {
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

    /// Takes in what every message says of the server's time and the snapshots of this sight; false when that cannot be true.
    fn hear(&mut self, (tick, latest): (Tick, Version), now: Duration, prompt: bool) -> bool {
        let word = self.course.hear(tick, latest, now.as_millis() as u64, prompt);
        if matches!(word, Word::Back | Word::Leapt) {
            self.assembly.go_back(latest);
            if self.replica.version() > latest {
                // what is held never was; only the whole pot leads away from there
                self.replica.distrust();
                (self.is_whole, self.ask) = (false, Some((now, ASK_ON_MAX)));
            }
        }
        word != Word::Refused
    }

    /// What was counted, with what was mended and refused.
    pub(super) fn counts(&self) -> WatchCounts {
        WatchCounts { mended: *self.mending.counts(), implausible: *self.course.refused(), ..self.counts }
    }

    /// When what is missing is asked for again.
    pub(super) fn patience(&self) -> Duration {
        self.ask.map_or(Duration::ZERO, |(at, _)| at)
    }

    pub(super) const fn name(&self) -> SightName {
        self.name
    }

    /// Whether the first keyframe has come.
    pub(super) const fn is_whole(&self) -> bool {
        self.is_whole
    }

    /// Whether it can take the place of one that shows the clay of a tick. One that is told by what was pressed is of the last press; where
    /// nobody presses it never becomes as new as that, and is as good once it has had time to hear of more.
    pub(super) fn has_come(&self, shown: Tick, now: Duration, round_trip: Duration) -> bool {
        let has_heard_all = || !self.is_behind() && now >= self.whole_at + round_trip + ASK_AGAIN_AFTER;
        self.is_whole && (self.tick >= shown || has_heard_all())
    }

    /// Whether newer clay is known of than is held, or what is held is otherwise than it should be.
    pub(super) fn is_behind(&self) -> bool {
        self.course.latest() > self.replica.version() || self.mending.is_waiting()
    }

    /// Takes in how the wheel turns, unless that comes with the clay.
    pub(super) fn turn(&mut self, wheel: &Wheel) {
        if self.detail.is_retold() {
            self.wheel = wheel.clone();
        }
    }

    /// Takes in a keyframe of it; false when it made no sense.
    pub(super) fn handle_keyframe(&mut self, keyframe: &Keyframe, now: Duration) -> bool {
        let (version, since) = (Version(keyframe.version), Version(keyframe.since));
        if !self.hear((Tick(keyframe.tick), version), now, false) {
            return false;
        }
        if version < self.replica.version() {
            return true;
        }
        let Keyframe { bytes, goes_on, .. } = keyframe;
        match self.replica.apply_keyframe(version, since, bytes, *goes_on, &mut self.news) {
            Ok(()) => {
                if !self.is_whole {
                    (self.is_whole, self.whole_at) = (true, now);
                }
                self.ask = None;
                self.mending.handle_keyframe(keyframe.mended);
                self.tick = self.tick.max(Tick(keyframe.tick)).min(self.course.tick());
            }
            // it leads on from what was lost as well; that is asked for
            Err(SnapshotError::NotNext { .. }) => {}
            Err(_) => return false,
        }
        self.assembly.forget(self.replica.version());
        true
    }

    /// Applies what is whole; what has to be asked for now, if anything has.
    pub(super) fn catch_up(
        &mut self,
        setting: Option<&mut Setting>,
        now: Duration,
        round_trip: Duration,
    ) -> Option<Request> {
        let request = self.go_on(setting, now, round_trip);
        self.counts.asked += u64::from(request.is_some());
        request
    }

    fn go_on(&mut self, setting: Option<&mut Setting>, now: Duration, round_trip: Duration) -> Option<Request> {
        // who presses again has to know under what
        if self.mending.is_waiting() || (setting.is_none() && self.detail.is_retold()) {
            return None;
        }
        let held = self.replica.version();
        let (mut is_wrong, mut is_unlike) = (false, false);
        let traveller = self.traveller(setting.as_deref());
        if let Some((version, _)) = self.assembly.reachable(held, traveller) {
            let mut setting = setting;
            while !is_wrong && !is_unlike && self.replica.version() < version {
                match self.step(traveller, setting.as_deref_mut()) {
                    Ok(is_alike) => is_unlike = !is_alike,
                    Err(_) => is_wrong = true,
                }
            }
            self.assembly.forget(self.replica.version());
        }
        if self.is_whole
            && !is_wrong
            && let Some(digest) = self.assembly.take_digest(self.replica.version())
        {
            if digest == self.replica.digest() {
                self.mending.handle_match();
            } else {
                self.counts.mismatches += 1;
                is_unlike = true;
            }
        }
        if is_wrong {
            self.ask = Some((now + ASK_AGAIN_AFTER, ASK_ON_MAX));
            return Some(self.request_from(0));
        }
        if is_unlike {
            return Some(self.mend(now, round_trip));
        }
        if self.replica.version() > held || (self.is_whole && self.course.latest() <= self.replica.version()) {
            self.ask = None;
        }
        None
    }

    /// Goes one snapshot on; says whether the clay is then the author's, as far as can be seen.
    fn step(&mut self, traveller: Traveller, setting: Option<&mut Setting>) -> Result<bool, SnapshotError> {
        let next = self.replica.version().next();
        match (self.assembly.take(next, traveller), setting) {
            (Some(Step::Delta(bytes)), _) => self.replica.apply_delta(next, &bytes, &mut self.news).map(|()| true),
            (Some(Step::Retelling(told, near)), Some(setting)) => {
                let under = (&setting.conditions, &mut setting.substep);
                let is_alike = press_again(&mut self.replica, &told, near, under, &mut self.news)?;
                self.counts.retold += 1;
                self.counts.unlike += u64::from(!is_alike);
                Ok(is_alike)
            }
            _ => Err(SnapshotError::NotNext { delta: next, held: self.replica.version() }),
        }
    }

    /// Stands still until what differs has come; what to ask for.
    fn mend(&mut self, now: Duration, round_trip: Duration) -> Request {
        self.mending_request(|mending, replica| Some(mending.begin(replica, now, round_trip)))
            .unwrap_or_else(|| self.request_from(0))
    }

    fn mending_request(&mut self, ask: impl FnOnce(&mut Mending, &Replica) -> Option<Request>) -> Option<Request> {
        Some(match ask(&mut self.mending, &self.replica)? {
            Request::Mend { have, tiles } => Request::MendSight { sight: self.name, have, tiles },
            _ => self.request_from(0),
        })
    }

    const fn request_from(&self, have: u32) -> Request {
        Request::Watch { sight: self.name, have }
    }

    /// What to ask for, if it is time.
    pub(super) fn due(&mut self, now: Duration, round_trip: Duration) -> Option<Request> {
        let request = self.look_whether_due(now, round_trip);
        self.counts.asked += u64::from(request.is_some());
        request
    }

    fn look_whether_due(&mut self, now: Duration, round_trip: Duration) -> Option<Request> {
        if self.mending.is_waiting() {
            return self.mending_request(|mending, replica| mending.due(replica, now, round_trip));
        }
        if self.is_whole && !self.is_behind() {
            return None;
        }
        let (at, times) = *self.ask.get_or_insert((now + ASK_AFTER, 0));
        if now < at {
            return None;
        }
        self.ask = Some((now + round_trip + ASK_AGAIN_AFTER, times + 1));
        let leads_on = self.is_whole && times < ASK_ON_MAX;
        Some(self.request_from(if leads_on { self.replica.version().0 } else { 0 }))
    }

    fn traveller(&self, setting: Option<&Setting>) -> Traveller {
        let takes_deltas = !self.detail.is_retold() && self.replica.takes_deltas();
        Traveller { told: setting.map_or(0, |setting| setting.told), takes_deltas }
    }

    /// Another sight of the same wheel was shown before: every tile may be otherwise.
    pub(super) fn note_all_changed(&mut self) {
        for (surface, clay) in self.replica.pot().surfaces().iter().enumerate() {
            for tile in 0..TileLayout::new(clay.shape()).tiles() {
                self.news.add(surface, tile);
            }
        }
    }
}
