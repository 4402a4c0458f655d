//! Those who look on: what each of them watches, and what fits into the bytes that each may get.
//!
//! Owns budgets and priorities; the clay comes from the benches' views, made once for everybody.
//! Invariant: over any time, one gets no more than its budget for that time, a quarter of a second's more, and one message; the tools that
//! people brought, with which a close look begins, come on top.

use alloc::collections::BTreeMap;
use alloc::vec::Vec;

use bytes::Bytes;

use super::bench::{Bench, Seen};
use super::pieces::bodies;
use super::{Outbox, PeerId};
use crate::protocol::{self, Body, DetailWire, Keyframe, NewsOf, NewsWire, Notice, Request, Sight, SightName};
use crate::room::{Lane, Transmit};
use crate::session::{Allowance, Peer};
use crate::snapshot::{Detail, SnapshotClock, Version};
use crate::units::Tick;

/// What a mended sight costs in plain requests: it is encoded for one alone.
const MEND_COST: i64 = 4;
/// Most sights of one who watches.
pub const SIGHTS_MAX: usize = 64;
/// Ticks after which a sight says that nothing has happened, and its digest.
const BEAT_TICKS: i64 = 1000;
/// Bytes that UDP, IP and QUIC put round a message.
const WRAPPING_BYTES: i64 = 57;

/// Its share of the bytes against those of other sights, when there are too few for all.
const fn weight(detail: Detail) -> i64 {
    if detail.fold() < 4 { 4 / detail.fold() as i64 } else { 1 }
}

/// What somebody may still be sent.
#[derive(Clone, Copy, Debug)]
struct Budget {
    bytes_per_s: i64,
    /// Thousandths of a byte; a debt when negative.
    left: i64,
    at: Tick,
}

impl Budget {
    const fn new(bytes_per_s: u32, now: Tick) -> Self {
        Self { bytes_per_s: bytes_per_s as i64, left: bytes_per_s as i64 * 250, at: now }
    }

    fn refill(&mut self, now: Tick) {
        let passed = now.since(self.at).clamp(0, 1000);
        self.left = (self.left + passed * self.bytes_per_s).min(self.bytes_per_s * 250);
        self.at = now;
    }

    const fn spend(&mut self, bytes: i64) {
        self.left -= bytes * 1000;
    }
}

/// One wheel in one viewer's eyes.
#[derive(Clone, Debug)]
struct Shown {
    /// What it was sent up to; `None` when it needs a keyframe of the whole pot.
    from: Option<Version>,
    beat_at: Tick,
    /// Has not been sent a keyframe yet, so that an older one is news as well.
    is_new: bool,
    /// Bytes it has had, divided by its weight: who had least is next.
    had: i64,
    /// Has just asked for what it misses.
    has_asked: bool,
    /// The version at which it says that it holds something else, and what every tile is like.
    differs: Option<(Version, Vec<u8>)>,
}

#[derive(Debug)]
struct Viewer {
    allowance: Allowance,
    budget: Budget,
    sights: BTreeMap<(usize, Detail), Shown>,
    /// What the last one served had had: who wanted nothing for a while has saved nothing up.
    level: i64,
}

/// Everybody who looks on.
#[derive(Debug, Default)]
pub(super) struct Audience {
    viewers: BTreeMap<PeerId, Viewer>,
    /// For those who come.
    wholes: Wholes,
    /// Requests beyond what a person makes, or for what there is not.
    refused: u64,
    mends: u64,
    mended_tiles: u64,
}

/// The newest keyframe of each whole sight.
type Wholes = BTreeMap<(usize, Detail), (Version, Vec<u8>)>;

/// Messages that are the same for all who were sent as much.
type Made<T> = BTreeMap<(usize, Detail, Version, bool), T>;

impl Audience {
    pub(super) fn len(&self) -> usize {
        self.viewers.len()
    }

    pub(super) const fn refused(&self) -> u64 {
        self.refused
    }

    /// Requests to find and mend what differs, and tiles that had differed and were sent for it.
    pub(super) const fn mends(&self) -> (u64, u64) {
        (self.mends, self.mended_tiles)
    }

    pub(super) fn let_in(&mut self, peer: PeerId, bytes_per_s: u32, now: Tick) {
        let (allowance, budget) = (Allowance::default(), Budget::new(bytes_per_s, now));
        let viewer = Viewer { allowance, budget, sights: BTreeMap::new(), level: 0 };
        self.viewers.insert(peer, viewer);
    }

    /// Takes in a request; one for what there is not is counted and not answered.
    pub(super) fn answer(
        &mut self,
        peer: PeerId,
        request: Request,
        benches: &mut [Bench],
        now: Tick,
        outbox: &mut Outbox,
    ) {
        let Some(viewer) = self.viewers.get_mut(&peer) else { return };
        let (sight, wants) = match request {
            Request::Watch { sight, have } => (sight, Wants::On(have)),
            Request::MendSight { sight, have, tiles } => (sight, Wants::Mended(Version(have), tiles)),
            Request::Unwatch { sight } => (sight, Wants::Nothing),
            _ => {
                self.refused += 1;
                return;
            }
        };
        let place = usize::from(sight.wheel).wrapping_sub(1);
        let is_of = |detail: &Detail| benches.get(place).is_some_and(|bench| detail.is_of(bench.pot().spec().shape));
        let Some(detail) = Detail::try_from(sight.detail).ok().filter(is_of) else {
            self.refused += 1;
            return;
        };
        let key = (place, detail);
        let is_shown = viewer.sights.contains_key(&key);
        let (has_room, cost) = match &wants {
            Wants::On(_) => (is_shown || viewer.sights.len() < SIGHTS_MAX, 1),
            Wants::Mended(..) => (is_shown, MEND_COST),
            // who asks for less is not to be left with more
            Wants::Nothing => (true, i64::from(!is_shown)),
        };
        if !has_room || !viewer.allowance.grant(now, cost) {
            self.refused += 1;
            return;
        }
        match wants {
            Wants::On(have) => {
                if !is_shown && !benches[place].open_view(detail, now) {
                    self.refused += 1;
                    let notice = Peer::notice(&Notice::NoSight(sight));
                    outbox.push_back(Transmit { to: peer, lane: Lane::Control(notice) });
                    return;
                }
                if !is_shown && detail.shows_tools() {
                    let standing = benches[place].standing().map(|news| news_frame(place, news));
                    outbox.extend(standing.map(|frame| Transmit { to: peer, lane: Lane::Control(frame) }));
                }
                let shown = viewer.sights.entry(key).or_insert_with(|| Shown::new(now));
                shown.from = (have > 0 && is_shown).then_some(Version(have));
                (shown.beat_at, shown.has_asked) = (now, true);
            }
            Wants::Mended(have, tiles) => {
                self.mends += 1;
                if let Some(shown) = viewer.sights.get_mut(&key) {
                    (shown.differs, shown.has_asked) = (Some((have, tiles)), true);
                }
            }
            Wants::Nothing => {
                viewer.sights.remove(&key);
                self.close_unwatched(key, benches);
            }
        }
    }

    pub(super) fn leave(&mut self, peer: PeerId, benches: &mut [Bench]) {
        for (key, _) in self.viewers.remove(&peer).map(|viewer| viewer.sights).unwrap_or_default() {
            self.close_unwatched(key, benches);
        }
    }

    fn close_unwatched(&mut self, key: (usize, Detail), benches: &mut [Bench]) {
        if !self.viewers.values().any(|viewer| viewer.sights.contains_key(&key)) {
            benches[key.0].close_view(key.1);
            self.wholes.remove(&key);
        }
    }

    /// Publishes what those who look on see of the wheels of which a snapshot is taken at this tick, and sends what is due and fits to those
    /// whose turn it is.
    pub(super) fn serve(&mut self, benches: &mut [Bench], now: Tick, outbox: &mut Outbox) {
        if self.viewers.is_empty() {
            return;
        }
        let is_turn = |place| SnapshotClock::of_wheel(place).is_due(now);
        for (place, bench) in benches.iter_mut().enumerate().filter(|(place, _)| is_turn(*place)) {
            bench.publish_views(now, |detail| is_due(place, detail, now));
            for news in bench.take_news(outbox) {
                let frame = news_frame(place, news);
                let is_for = |viewer: &Viewer| viewer.sights.keys().any(|(at, of)| *at == place && of.shows_tools());
                let lookers = self.viewers.iter().filter(|(_, viewer)| is_for(viewer));
                outbox.extend(lookers.map(|(&to, _)| Transmit { to, lane: Lane::Control(frame.clone()) }));
            }
        }
        let (mut made, mut keyframes) = (Made::new(), Made::new());
        for (&peer, viewer) in &mut self.viewers {
            // all wheels share what a viewer can take, so that their turns are one: that of the first
            if !viewer.sights.first_key_value().is_some_and(|(&(place, _), _)| is_turn(place)) {
                continue;
            }
            viewer.budget.refill(now);
            let mut order: Vec<_> = viewer
                .sights
                .iter()
                .filter(|((place, detail), shown)| is_wanted(&benches[*place], *place, *detail, shown, now))
                .map(|(&key, shown)| (shown.had.max(viewer.level), key))
                .collect();
            order.sort_unstable();
            for (had, key) in order {
                if viewer.budget.left <= 0 {
                    break;
                }
                let (Some(shown), bench) = (viewer.sights.get_mut(&key), &benches[key.0]) else { continue };
                let mut send = |lane| outbox.push_back(Transmit { to: peer, lane });
                let (mut bytes, mended) = mend(bench, key, shown, &mut send);
                self.mended_tiles += u64::from(mended);
                bytes += show(bench, key, shown, now, (&mut made, &mut keyframes, &mut self.wholes), send);
                viewer.budget.spend(bytes);
                viewer.level = had;
                shown.had = had + bytes / weight(key.1);
            }
        }
    }
}

/// What somebody asks for of a sight.
enum Wants {
    /// What leads on from a version.
    On(u32),
    /// What differs from what is held at a version.
    Mended(Version, Vec<u8>),
    Nothing,
}

impl Shown {
    const fn new(now: Tick) -> Self {
        Self { from: None, beat_at: now, is_new: true, had: 0, has_asked: true, differs: None }
    }
}

/// A frame that tells those who look on closely what everybody at a wheel was told.
fn news_frame(place: usize, (told, of): (u32, NewsOf)) -> Vec<u8> {
    Peer::notice(&Notice::News(NewsWire { wheel: place as u16 + 1, told, of }))
}

/// Whether a view is published with the snapshot at a tick; wheels take turns.
fn is_due(place: usize, detail: Detail, now: Tick) -> bool {
    (SnapshotClock::of_wheel(place).count(now) + place as u64).is_multiple_of(detail.every())
}

fn is_wanted(bench: &Bench, place: usize, detail: Detail, shown: &Shown, now: Tick) -> bool {
    let Some(seen) = bench.seen(detail) else { return false };
    let has_tools = detail.shows_tools() && bench.has_tools(now);
    let is_due = is_due(place, detail, now);
    // the author goes on more often than those who look on are told
    let is_news = shown.from != Some(seen.latest()) && (is_due || shown.has_asked || !detail.is_retold());
    is_news || shown.differs.is_some() || (has_tools && is_due) || now >= shown.beat_at
}

/// Answers who holds something else than it should; says how many bytes that took, and how many tiles differed.
fn mend(bench: &Bench, (place, detail): (usize, Detail), shown: &mut Shown, mut send: impl FnMut(Lane)) -> (i64, u16) {
    let (Some((have, tiles)), Some(seen)) = (shown.differs.take(), bench.seen(detail)) else { return (0, 0) };
    let is_known = have > Version(0) && have <= seen.latest();
    let Some((bytes, mended)) = is_known.then(|| seen.mend(have, &tiles)).flatten() else {
        // what cannot be compared is sent whole
        shown.from = None;
        return (0, 0);
    };
    let keyframe = keyframe(seen, (place, detail), have, mended, bytes);
    shown.from = Some(seen.latest());
    let bytes = wrapped(&keyframe);
    send(Lane::Keyframe(keyframe));
    (bytes, mended)
}

fn keyframe(seen: Seen<'_>, key: (usize, Detail), since: Version, mended: u16, bytes: Vec<u8>) -> Vec<u8> {
    protocol::encode(&Keyframe {
        version: seen.latest().0,
        since: since.0,
        tick: seen.tick().0,
        acknowledged: 0,
        sight: Some(name_of(key)),
        mended,
        goes_on: seen.goes_on(),
        bytes,
    })
}

fn name_of((place, detail): (usize, Detail)) -> SightName {
    SightName { wheel: place as u16 + 1, detail: DetailWire::from(detail) }
}

/// Bytes of a keyframe on the line.
const fn wrapped(keyframe: &[u8]) -> i64 {
    keyframe.len() as i64 + WRAPPING_BYTES * (1 + keyframe.len() as i64 / 1200)
}

/// Sends one sight; says how many bytes that took.
fn show(
    bench: &Bench,
    (place, detail): (usize, Detail),
    shown: &mut Shown,
    now: Tick,
    (made, keyframes, wholes): (&mut Made<Vec<Bytes>>, &mut Made<Vec<u8>>, &mut Wholes),
    mut send: impl FnMut(Lane),
) -> i64 {
    let Some(seen) = bench.seen(detail) else { return 0 };
    let is_beat = now >= shown.beat_at;
    shown.has_asked = false;
    let mut bytes = 0;
    let mut from = shown.from.filter(|from| *from <= seen.latest());
    if from.is_none_or(|from| seen.ways_from(from).is_none()) {
        let since = from.unwrap_or_default();
        let encoded = || keyframe(seen, (place, detail), since, 0, seen.keyframe(since));
        let is_new = core::mem::take(&mut shown.is_new);
        let (version, keyframe) = if since == Version(0) {
            // many come at once, and what has happened since a keyframe was made costs less than another
            let serves = |version: Version| version == seen.latest() || (is_new && seen.ways_from(version).is_some());
            let whole = wholes.entry((place, detail)).or_insert_with(|| (seen.latest(), encoded()));
            if !serves(whole.0) {
                *whole = (seen.latest(), encoded());
            }
            (whole.0, &whole.1)
        } else {
            let made = keyframes.entry((place, detail, since, false)).or_insert_with(encoded);
            (seen.latest(), &*made)
        };
        bytes += wrapped(keyframe);
        send(Lane::Keyframe(keyframe.clone()));
        from = Some(version);
    }
    let from = from.unwrap_or_default();
    let datagrams = made.entry((place, detail, from, is_beat)).or_insert_with(|| {
        let first = Body {
            tick: seen.tick().0,
            latest: seen.latest().0,
            digest: is_beat.then(|| seen.digest()),
            tools: Some(if detail.shows_tools() { bench.tools(now) } else { Vec::new() }),
            fragments: Vec::new(),
        };
        let bodies = bodies(&first, seen.ways_from(from).into_iter().flatten(), protocol::DATAGRAM_MAX);
        let sights = bodies.into_iter().enumerate().map(|(number, body)| {
            // who presses again was told how the wheel turns
            let turning = (number == 0 && !detail.is_retold()).then(|| bench.turning(now));
            Bytes::from(protocol::encode(&Sight { name: name_of((place, detail)), turning, body }))
        });
        sights.collect()
    });
    for datagram in datagrams {
        bytes += datagram.len() as i64 + WRAPPING_BYTES;
        send(Lane::Datagram(datagram.clone()));
    }
    if is_beat {
        shown.beat_at = now.offset(BEAT_TICKS);
    }
    shown.from = Some(seen.latest());
    bytes
}
