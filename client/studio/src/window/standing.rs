//! How far the pots of many wheels are from what they are to become, for who looks on at them.
//!
//! Owns what each was compared with and when; what the room told a teacher goes before what is seen from here.
//! Invariant: a wheel is compared no more than four times a second, and not at all while neither its clay nor the target is another.

use std::time::{Duration, Instant};

use egui::{Painter, Rect, pos2, vec2};
use pottery_shared::clay::{Deviation, Pot, Target};
use pottery_shared::protocol::{Nickname, PersonWire, Role};
use pottery_shared::session::Progress;

use super::panel::{nickname, profiles};
use crate::words::Words;

/// Time between two looks at one pot.
const COMPARE_EVERY: Duration = Duration::from_millis(250);
/// Share of a part of the window that the picture takes, either way, and its largest side, points.
const SHARE: f32 = 0.30;
const PICTURE_MAX: f32 = 110.0;

/// One wheel's pot beside the target, and who works at it.
#[derive(Debug, Default)]
pub(super) struct Standing {
    names: Vec<Nickname>,
    progress: Option<Progress>,
    compared_at: Option<Instant>,
    is_stale: bool,
}

impl Standing {
    /// Clay or target are others than they were.
    pub(super) fn note_change(&mut self) {
        self.is_stale = true;
    }

    /// Takes in who works at the wheel, as far as that is known here; whether that is news.
    pub(super) fn hear<'a>(&mut self, wheel: u16, people: impl Iterator<Item = &'a PersonWire>) -> bool {
        let works = |person: &&PersonWire| person.wheel == wheel && person.works && person.role == Role::Student;
        let names: Vec<_> = people.filter(works).map(|person| person.name).collect();
        let is_news = names != self.names;
        self.names = names;
        is_news
    }

    /// Compares the pot with what it is to become, when it is time; whether there is news.
    pub(super) fn compare(&mut self, target: Option<&Target>, told: Option<&Progress>, pot: &Pot) -> bool {
        let Some(target) = target else { return self.progress.take().is_some() };
        if let Some(told) = told {
            let is_news = self.progress.as_ref() != Some(told);
            if is_news {
                self.progress = Some(told.clone());
            }
            return is_news;
        }
        let is_due = self.compared_at.is_none_or(|at| at.elapsed() >= COMPARE_EVERY);
        if !is_due || !(self.is_stale || self.progress.is_none()) {
            return false;
        }
        (self.compared_at, self.is_stale) = (Some(Instant::now()), false);
        self.progress = Some(Progress { is: Target::of(pot), deviation: target.deviation(pot) });
        true
    }

    /// What stands under the wheel: its number, who works there, and how far it is.
    pub(super) fn said(&self, words: &Words, wheel: u16) -> String {
        let mut said = words.say_with("wheel-number", &[("number", &wheel.to_string())]);
        if !self.names.is_empty() {
            let names: Vec<_> = self.names.iter().map(|name| nickname(words, *name)).collect();
            said = format!("{said} · {}", names.join(", "));
        }
        if let Some(Progress { deviation: Deviation { rms_m, most_m, .. }, .. }) = &self.progress {
            let mm = |metres: f32| words.number(f64::from(metres) * 1e3, 1);
            let off = words.say_with("tile-progress", &[("rms", &mm(*rms_m)), ("most", &mm(*most_m))]);
            said = format!("{said}\n{off}");
        }
        said
    }

    /// Paints its profile over the one that is wanted, in the upper right corner of its part of the window.
    pub(super) fn paint(&self, painter: &Painter, part: Rect, target: Option<&Target>) {
        let side = (SHARE * part.width().min(part.height())).min(PICTURE_MAX);
        let corner = pos2(part.max.x - side - 6.0, part.min.y + 6.0);
        self.paint_in(painter, Rect::from_min_size(corner, vec2(side, side)), target);
    }

    /// The same, in a place of its own.
    pub(super) fn paint_in(&self, painter: &Painter, within: Rect, target: Option<&Target>) {
        if let (Some(progress), Some(target)) = (&self.progress, target) {
            profiles::paint(painter, within, target, &progress.is);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pottery_shared::clay::{Form, PotSpec};

    #[test]
    fn a_pot_is_compared_when_clay_or_target_change_and_what_a_teacher_was_told_goes_before() {
        let pot = |form: Form| form.pot(PotSpec::default()).expect("the usual clay takes every form");
        let (bowl, bottle) = (pot(Form::Bowl), pot(Form::Bottle));
        let target = Target::of(&bottle);
        let mut standing = Standing::default();
        assert!(!standing.compare(None, None, &bowl), "nothing is wanted");
        assert!(standing.compare(Some(&target), None, &bowl));
        let off = standing.progress.clone().expect("it was compared").deviation;
        assert_eq!(off, target.deviation(&bowl));
        // another pot that nobody has spoken of is not looked at
        standing.compared_at = None;
        assert!(!standing.compare(Some(&target), None, &bottle));
        standing.note_change();
        assert!(standing.compare(Some(&target), None, &bottle));
        assert!(standing.progress.clone().expect("it was compared").deviation.rms_m < 5e-5);
        // and not again within a quarter of a second
        standing.note_change();
        assert!(!standing.compare(Some(&target), None, &bowl));
        let told = Progress { is: Target::of(&bowl), deviation: target.deviation(&bowl) };
        assert!(standing.compare(Some(&target), Some(&told), &bottle));
        assert!(!standing.compare(Some(&target), Some(&told), &bottle), "that is known");
        assert!(standing.compare(None, None, &bottle) && standing.progress.is_none());
    }
}
