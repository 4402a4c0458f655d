//! The first five minutes at the wheel: four steps, each over once it was done.
//!
//! Owns what counts as done; what is said is in the words.
//! Invariant: a step is over by what the person did, never by time alone, and the lesson can be left at any moment.

use egui::{Align2, RichText};
use pottery_shared::tool::Side;

use crate::words::Words;

/// Slowest wheel on which clay is centred, and fastest on which a wall is pulled, rpm.
const CENTRE_RPM: f32 = 150.0;
const PULL_RPM: f32 = 120.0;
/// How long the tool is to be on the clay, s.
const CENTRE_S: f32 = 3.0;
const OPEN_S: f32 = 2.0;
const SHAPE_S: f32 = 4.0;
/// How far the tool is to go up along the wall, m.
const PULL_M: f32 = 0.08;
/// A pull that has gone down by as much begins again, m.
const DOWN_M: f32 = 0.01;

/// What is seen of the person at a moment.
#[derive(Clone, Copy, Debug)]
pub(super) struct Seen {
    pub(super) rpm: f32,
    pub(super) is_touching: bool,
    pub(super) side: Side,
    /// Height of the tool, m.
    pub(super) height_m: f32,
}

/// From which width of the window on the steps are shown before somebody asks for them, points.
const OPEN_FROM: f32 = 600.0;

/// The names of the steps, for the words.
const STEPS: [&str; 4] = ["lesson-centre", "lesson-open", "lesson-pull", "lesson-shape"];

/// How far somebody is in the lesson.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Lesson {
    step: usize,
    /// Share of the step that is done.
    share: f32,
    /// Where a pull began, m.
    from_m: Option<f32>,
}

impl Lesson {
    /// Takes in what was seen for a time; says whether the picture of it changes.
    pub(super) fn pass(&mut self, seconds: f32, seen: &Seen) -> bool {
        let before = *self;
        let over = |time_s: f32| seconds / time_s;
        let (is_outside, is_touching) = (seen.side == Side::Outside, seen.is_touching);
        match self.step {
            0 if is_touching && is_outside && seen.rpm >= CENTRE_RPM => self.share += over(CENTRE_S),
            1 if is_touching && !is_outside => self.share += over(OPEN_S),
            2 if is_touching && seen.rpm > 0.0 && seen.rpm <= PULL_RPM => {
                let from_m = self.from_m.get_or_insert(seen.height_m);
                let risen_m = seen.height_m - *from_m;
                if risen_m < self.share * PULL_M - DOWN_M {
                    (*from_m, self.share) = (seen.height_m, 0.0);
                } else {
                    self.share = self.share.max(risen_m / PULL_M);
                }
            }
            2 => (self.from_m, self.share) = (None, 0.0),
            3 if is_touching => self.share += over(SHAPE_S),
            _ => {}
        }
        if self.share >= 1.0 {
            *self = Self { step: self.step + 1, ..Self::default() };
        }
        *self != before
    }

    /// Lays the step out; true when the person leaves.
    pub(super) fn show(self, context: &egui::Context, words: &Words) -> bool {
        let mut leaves = false;
        let window = egui::Window::new(words.say("lesson")).id(egui::Id::unique("lesson")).resizable(false);
        let room = context.content_rect().size();
        // in a narrower one it would lie over the controls
        let window = window.default_open(room.x >= OPEN_FROM);
        window.anchor(Align2::RIGHT_BOTTOM, [-12.0, -34.0]).default_width(300.0).show(context, |ui| {
            ui.set_width((room.x - 40.0).clamp(0.0, 300.0));
            if let Some(name) = STEPS.get(self.step) {
                let (step, steps) = ((self.step + 1).to_string(), STEPS.len().to_string());
                let title =
                    words.say_with("lesson-step", &[("step", &step), ("steps", &steps), ("name", &words.say(name))]);
                ui.label(RichText::new(title).strong());
                ui.label(words.say(&format!("{name}-how")));
                ui.add(egui::ProgressBar::new(self.share));
                leaves = ui.button(words.say("lesson-skip")).clicked();
            } else {
                ui.label(words.say("lesson-done"));
                leaves = ui.button(words.say("lesson-close")).clicked();
            }
        });
        leaves
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const IDLE: Seen = Seen { rpm: 60.0, is_touching: false, side: Side::Outside, height_m: 0.0 };

    fn passes(lesson: &mut Lesson, seconds: f32, seen: impl Fn(f32) -> Seen) {
        for tick in 0..(seconds * 30.0) as u32 {
            lesson.pass(1.0 / 30.0, &seen(tick as f32 / 30.0));
        }
    }

    #[test]
    fn each_step_is_over_once_it_was_done_and_not_before() {
        let mut lesson = Lesson::default();
        passes(&mut lesson, 60.0, |_| IDLE);
        // too slow a wheel does not centre
        passes(&mut lesson, 10.0, |_| Seen { is_touching: true, ..IDLE });
        assert_eq!(lesson, Lesson::default());
        passes(&mut lesson, 3.2, |_| Seen { rpm: 200.0, is_touching: true, ..IDLE });
        assert_eq!(lesson.step, 1);
        passes(&mut lesson, 5.0, |_| Seen { is_touching: true, ..IDLE });
        assert_eq!(lesson.step, 1, "pressing outside opens nothing");
        passes(&mut lesson, 2.2, |_| Seen { is_touching: true, side: Side::Inside, ..IDLE });
        assert_eq!(lesson.step, 2);
        let pulling = |time_s: f32| Seen { rpm: 80.0, is_touching: true, height_m: 0.02 * time_s, ..IDLE };
        passes(&mut lesson, 3.0, pulling);
        assert!(lesson.step == 2 && lesson.share > 0.6, "{lesson:?}");
        passes(&mut lesson, 0.1, |_| IDLE);
        assert_eq!(lesson.share, 0.0, "a pull that is let go begins again");
        passes(&mut lesson, 4.2, pulling);
        assert_eq!(lesson.step, 3);
        passes(&mut lesson, 4.2, |_| Seen { is_touching: true, ..IDLE });
        assert_eq!(lesson.step, STEPS.len());
    }

    #[test]
    fn nothing_is_drawn_anew_for_who_does_nothing() {
        assert!(!Lesson::default().pass(0.1, &IDLE));
        assert!(Lesson::default().pass(0.1, &Seen { rpm: 200.0, is_touching: true, ..IDLE }));
    }
}
