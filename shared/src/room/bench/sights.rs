//! The wheel as those see it who only look on: chains of less detail, or the author's own.
//!
//! Owns which details are shown and what those who look on closely have to be told; who gets what, and when, is for `audience` to say.
//! Invariant: what is shown costs nothing while nobody looks at it.

use alloc::collections::VecDeque;
use alloc::vec::Vec;

use super::pulses::{Way, lead_on};
use super::{Bench, Outbox};
use crate::protocol::{ClayWire, Fragment, NewsOf, WheelWire};
use crate::room::view::View;
use crate::snapshot::{Author, Detail, Moment, Version};
use crate::units::Tick;

/// Chains at once that have no name of their own; each takes up to 2 MB and is made as often as it says.
const UNNAMED_MAX: usize = 4;

/// What is shown of one wheel.
#[derive(Debug, Default)]
pub(super) struct Sights {
    /// Chains of their own: at most one for each detail with a name, and [`UNNAMED_MAX`] others.
    views: Vec<(Detail, View)>,
    /// Above the last version of every chain that ended.
    ended: Version,
    /// Whether somebody presses again what is pressed here.
    is_retold: bool,
    /// What everybody was told since those who look on closely were, with the number of each.
    news: Vec<(u32, NewsOf)>,
}

impl Sights {
    pub(super) const fn is_retold(&self) -> bool {
        self.is_retold
    }

    fn is_close(&self) -> bool {
        self.is_retold || self.views.iter().any(|(detail, _)| detail.shows_tools())
    }

    fn has_room_for(&self, detail: Detail) -> bool {
        let is_named = |detail: Detail| Detail::PRESETS.contains(&detail);
        is_named(detail) || self.views.iter().filter(|(detail, _)| !is_named(*detail)).count() < UNNAMED_MAX
    }
}

/// One detail of a wheel that somebody looks at.
#[derive(Clone, Copy, Debug)]
pub(in crate::room) enum Seen<'a> {
    /// A chain of its own.
    Apart(&'a View),
    /// The author's, told by what was pressed.
    Retold { author: &'a Author, ways: &'a VecDeque<Way>, tick: Tick },
}

impl<'a> Seen<'a> {
    pub(in crate::room) const fn latest(self) -> Version {
        match self {
            Self::Apart(view) => view.latest(),
            Self::Retold { author, .. } => author.latest(),
        }
    }

    pub(in crate::room) const fn tick(self) -> Tick {
        match self {
            Self::Apart(view) => view.tick(),
            Self::Retold { tick, .. } => tick,
        }
    }

    pub(in crate::room) fn digest(self) -> u64 {
        match self {
            Self::Apart(view) => view.digest(),
            Self::Retold { author, .. } => author.digest(),
        }
    }

    /// Whether keyframes bring what deltas build upon.
    pub(in crate::room) const fn goes_on(self) -> bool {
        matches!(self, Self::Apart(_))
    }

    /// The pieces that lead on from a version, when they are few and kept.
    pub(in crate::room) fn ways_from(self, from: Version) -> Option<Vec<&'a Fragment>> {
        match self {
            Self::Apart(view) => Some(view.ways_from(from)?.collect()),
            Self::Retold { author, ways, .. } => {
                let is_told = from == author.latest() || lead_on(ways, from, true);
                let newer = || ways.iter().filter(|way| way.version > from);
                is_told.then(|| newer().flat_map(|way| way.fragments(true)).collect())
            }
        }
    }

    pub(in crate::room) fn keyframe(self, have: Version) -> Vec<u8> {
        match self {
            Self::Apart(view) => view.keyframe(have),
            Self::Retold { author, .. } => author.keyframe(have, false),
        }
    }

    pub(in crate::room) fn mend(self, have: Version, tiles: &[u8]) -> Option<(Vec<u8>, u16)> {
        match self {
            Self::Apart(view) => view.mend(have, tiles),
            Self::Retold { author, .. } => author.mend(have, tiles, false),
        }
    }
}

impl Bench {
    /// Begins to show the wheel at a detail, unless it is shown already; false when it is shown in as many ways as it can be.
    pub(in crate::room) fn open_view(&mut self, detail: Detail, now: Tick) -> bool {
        if detail.is_retold() {
            self.sights.is_retold = true;
            return true;
        }
        if let Some((_, view)) = self.sights.views.iter_mut().find(|(of, _)| *of == detail) {
            view.note_newcomer();
            return true;
        }
        let has_room = self.sights.has_room_for(detail);
        if has_room {
            let now = Moment { tick: now, phase: self.conditions.phase(now) };
            let view = View::after(self.sights.ended, &self.author, detail, now);
            self.sights.views.push((detail, view));
        }
        has_room
    }

    /// Shows it no longer.
    pub(in crate::room) fn close_view(&mut self, detail: Detail) {
        if detail.is_retold() {
            self.sights.is_retold = false;
        }
        let Sights { views, ended, .. } = &mut self.sights;
        for (_, view) in views.extract_if(.., |(of, _)| *of == detail) {
            *ended = view.latest().next().max(*ended);
        }
        if !self.sights.is_close() {
            self.sights.news.clear();
        }
    }

    /// The wheel at a detail, if anybody looks at it.
    pub(in crate::room) fn seen(&self, detail: Detail) -> Option<Seen<'_>> {
        if detail.is_retold() {
            let retold = Seen::Retold { author: &self.author, ways: &self.ways, tick: self.snapshot_tick };
            return self.sights.is_retold.then_some(retold);
        }
        self.sights.views.iter().find(|(of, _)| *of == detail).map(|(_, view)| Seen::Apart(view))
    }

    /// Takes a snapshot for those details of which `is_due` says so, and for those that somebody new looks at.
    pub(in crate::room) fn publish_views(&mut self, now: Tick, is_due: impl Fn(Detail) -> bool) {
        let now = Moment { tick: now, phase: self.conditions.phase(now) };
        let views = self.sights.views.iter_mut();
        for (_, view) in views.filter(|(detail, view)| view.has_newcomer() || is_due(*detail)) {
            view.publish(&self.author, now);
        }
    }

    /// How everything stands, for who begins to look on closely, and the number of the last notice that it makes up for; then the tools
    /// that people brought.
    pub(in crate::room) fn standing(&self) -> impl Iterator<Item = (u32, NewsOf)> + '_ {
        let told = self.told_before_tools();
        let standing = NewsOf::Standing { wheel: self.turnings(), clay: self.clays() };
        let tools = self.brought.iter().map(|(shape, mesh)| NewsOf::Tool { shape: *shape, mesh: mesh.clone() });
        (0..).zip(core::iter::once(standing).chain(tools)).map(move |(number, news)| (told.wrapping_add(number), news))
    }

    /// Keeps what was just told to everybody for those who look on closely.
    pub(super) fn note_news(&mut self, news: &NewsOf) {
        if self.sights.is_close() {
            self.sights.news.push((self.told, news.clone()));
        }
    }

    /// What everybody was told since this was last asked. Where nobody works, nobody is visited to tell of settings; that is done here.
    pub(in crate::room) fn take_news(&mut self, outbox: &mut Outbox) -> Vec<(u32, NewsOf)> {
        if !self.has_work() {
            self.tell_settings(outbox);
        }
        core::mem::take(&mut self.sights.news)
    }

    pub(super) fn turnings(&self) -> Vec<WheelWire> {
        let segments = self.conditions.wheel.segments();
        segments.map(|(from, phase, rate)| WheelWire { from: from.0, phase: phase.0, rate }).collect()
    }

    pub(super) fn clays(&self) -> Vec<(u64, ClayWire)> {
        self.conditions.material.entries().map(|(from, clay)| (from.0, clay.into())).collect()
    }

    /// Notices told to everybody before those of the tools that were brought, which follow a welcome and count as told.
    pub(super) const fn told_before_tools(&self) -> u32 {
        self.told.wrapping_sub(self.brought.len() as u32)
    }
}
