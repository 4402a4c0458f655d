//! Clay that is made again, beside the clay that people work at, without the strokes that are undone.
//!
//! Owns a pot and how far in the log it is; does a bounded part of the work at a time.
//! Invariant: what it makes depends on what is pressed again alone, and not on how the work was cut.

use alloc::vec::Vec;

use super::log::{Log, Setting, Span};
use super::marks::{Marks, Place};
use super::strokes::Strokes;
use crate::clay::{Conditions, Pot, SubStep, Surface};
use crate::snapshot::{Touched, dequantise, quantise};
use crate::tool::ToolSample;

/// A pot on its way from a kept clay to now.
#[derive(Debug)]
pub(super) struct Remake {
    pot: Pot,
    conditions: Conditions,
    /// Tiles pressed since the last snapshot on the way.
    unrounded: Touched,
    /// Tiles pressed since the newest mark.
    since_mark: Touched,
    span: u64,
    sub_step: usize,
    settings: usize,
    /// The span that it goes through, when that is packed.
    unpacked: Option<Span>,
}

/// What a part of the work came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Work {
    /// Samples pressed again.
    pub(super) pressed: u32,
    /// Whether a snapshot on the way was come to, at which clay may be kept.
    pub(super) is_at_snapshot: bool,
}

impl Remake {
    /// What laying clay on the whole wheel costs in samples.
    const PUT_COST: u32 = 8;

    /// A pot as it was kept at the beginning of a span.
    pub(super) fn starting_from(pot: Pot, conditions: Conditions, span: u64) -> Self {
        let unrounded = Touched::none(pot.surfaces().iter().map(Surface::shape));
        let since_mark = unrounded.clone();
        Self { pot, conditions, unrounded, since_mark, span, sub_step: 0, settings: 0, unpacked: None }
    }

    /// The pot as it is so far.
    pub(super) const fn pot(&self) -> &Pot {
        &self.pot
    }

    /// The pot, and in which tiles it differs from the newest mark at most.
    pub(super) fn finish(self) -> (Pot, Touched) {
        (self.pot, self.since_mark)
    }

    /// Keeps the clay as it is at a snapshot on the way.
    pub(super) fn keep(&mut self, place: Place, marks: &mut Marks) {
        marks.keep(place, &self.pot, &mut self.since_mark, &self.conditions);
    }

    /// The span that it goes through.
    pub(super) const fn span(&self) -> u64 {
        self.span
    }

    /// Whether nothing of what was pressed so far is left to be done.
    pub(super) fn is_done(&self, log: &Log) -> bool {
        self.span == log.open_number() && log.open().transcript.sub_step(self.sub_step).is_none()
    }

    /// Presses again until so many samples are pressed, a snapshot is come to, or nothing is left.
    pub(super) fn go_on(&mut self, log: &Log, strokes: &Strokes, substep: &mut SubStep, samples: u32) -> Work {
        let mut work = Work::default();
        let mut presses = Vec::new();
        while work.pressed < samples {
            let is_open = self.span == log.open_number();
            if !is_open && self.unpacked.is_none() {
                self.unpacked = log.span(self.span);
            }
            let span = if is_open { log.open() } else { self.unpacked.as_ref().unwrap_or(log.open()) };
            for setting in &span.settings[self.settings..] {
                setting.apply(&mut self.conditions);
                if let Setting::Put(client, tick, clay, _) = setting
                    && !strokes.is_put_left_out(*client, *tick)
                {
                    clay.lay_on(&mut self.pot, &mut self.unrounded);
                    work.pressed += Self::PUT_COST;
                }
            }
            self.settings = span.settings.len();
            let Some(sub_step) = span.sub_step(self.sub_step) else {
                if is_open {
                    break;
                }
                work.pressed += 1;
                work.is_at_snapshot = log.ends_in_snapshot(self.span);
                (self.span, self.sub_step, self.settings, self.unpacked) = (self.span + 1, 0, 0, None);
                if work.is_at_snapshot {
                    self.round();
                    break;
                }
                continue;
            };
            presses.clear();
            let mut any_meets = false;
            for (told, met) in sub_step {
                let is_left_out = |sample: &ToolSample| strokes.is_left_out(told.client, sample.tick);
                if is_left_out(&told.sample) {
                    continue;
                }
                let before = told.before.filter(|before| !is_left_out(before));
                let press = self.conditions.press(&told.sample, before.as_ref());
                any_meets |= met;
                // what met nothing when it was held there does nothing now
                presses.push(if met { press } else { press.in_air() });
            }
            self.sub_step += 1;
            // looking at what is left out costs as well
            work.pressed += presses.len().max(1) as u32;
            if any_meets {
                let unrounded = &mut self.unrounded;
                substep.advance(&mut self.pot, &presses, self.conditions.method, |surface, window| {
                    unrounded.add_window(surface, window);
                });
            }
        }
        work
    }

    /// Takes in that the log's open span, of which nothing was left to be done, ended in a snapshot.
    pub(super) fn meet_snapshot(&mut self, log: &Log) {
        if self.span != log.open_number() {
            (self.span, self.sub_step, self.settings) = (log.open_number(), 0, 0);
        }
        self.round();
    }

    /// Rounds the clay as a snapshot does.
    fn round(&mut self) {
        for (surface, _, window) in self.unrounded.iter() {
            let clay = &mut self.pot.surfaces_mut()[surface];
            clay.change_window(window, |radius_m| dequantise(quantise(radius_m)));
        }
        self.pot.settle(self.unrounded.iter().map(|(surface, _, window)| (surface, window)));
        self.since_mark.add_all(&self.unrounded);
        self.unrounded.clear();
    }
}
