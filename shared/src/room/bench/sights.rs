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

/// What is shown of one wheel.
#[derive(Debug, Default)]
pub(super) struct Sights {
    /// Chains of their own, by the number of the detail, with the last version of the one before.
    views: [(Option<View>, Version); Detail::ALL.len()],
    /// Whether somebody presses again what is pressed here.
    is_retold: bool,
    /// What everybody was told since those who look on closely were, with the number of each.
    news: Vec<(u32, NewsOf)>,
}

impl Sights {
    pub(super) const fn is_retold(&self) -> bool {
        self.is_retold
    }

    const fn is_close(&self) -> bool {
        self.is_retold || self.views[Detail::Spectator.number() as usize].0.is_some()
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
    /// Begins to show the wheel at a detail, unless it is shown already.
    pub(in crate::room) fn open_view(&mut self, detail: Detail, now: Tick) {
        if detail == Detail::Retold {
            self.sights.is_retold = true;
            return;
        }
        let now = Moment { tick: now, phase: self.conditions.phase(now) };
        let (view, before) = &mut self.sights.views[usize::from(detail.number())];
        view.get_or_insert_with(|| View::after(*before, &self.author, detail, now));
    }

    /// Shows it no longer.
    pub(in crate::room) fn close_view(&mut self, detail: Detail) {
        if detail == Detail::Retold {
            self.sights.is_retold = false;
        }
        let (view, before) = &mut self.sights.views[usize::from(detail.number())];
        if let Some(view) = view.take() {
            *before = view.latest().next();
        }
        if !self.sights.is_close() {
            self.sights.news.clear();
        }
    }

    /// The wheel at a detail, if anybody looks at it.
    pub(in crate::room) fn seen(&self, detail: Detail) -> Option<Seen<'_>> {
        if detail == Detail::Retold {
            let retold = Seen::Retold { author: &self.author, ways: &self.ways, tick: self.snapshot_tick };
            return self.sights.is_retold.then_some(retold);
        }
        self.sights.views[usize::from(detail.number())].0.as_ref().map(Seen::Apart)
    }

    /// Takes a snapshot for those details of which `is_due` says so.
    pub(in crate::room) fn publish_views(&mut self, now: Tick, is_due: impl Fn(Detail) -> bool) {
        let now = Moment { tick: now, phase: self.conditions.phase(now) };
        for detail in Detail::ALL.into_iter().filter(|detail| is_due(*detail)) {
            if let (Some(view), _) = &mut self.sights.views[usize::from(detail.number())] {
                view.publish(&self.author, now);
            }
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
