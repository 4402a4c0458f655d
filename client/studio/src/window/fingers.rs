//! What fingers on the screen mean: one holds the tool, two turn the view and bring it closer.
//!
//! Pure: is told of touches in pixels and answers with what is asked for; knows no camera and no hand.
//! Invariant: a tool that one finger holds is lifted when a second comes, and held again only after all have gone.

use glam::Vec2;
use winit::event::TouchPhase;

/// What a touch asks for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Asked {
    /// Nothing.
    Nothing,
    /// The tool is to be there, and pressed in while it is held.
    Tool {
        /// Where, pixels.
        at: Vec2,
        /// Whether the finger is still there.
        is_held: bool,
    },
    /// The view turns by so many pixels and comes so many times closer.
    View {
        /// Right and down.
        by: Vec2,
        /// Above 1 for closer.
        closer: f32,
    },
}

/// The fingers that are on the screen, in the order of their coming.
#[derive(Debug, Default)]
pub(super) struct Fingers {
    down: Vec<(u64, Vec2)>,
    /// There were two since the screen was last free.
    is_view: bool,
}

impl Fingers {
    /// Least distance of two fingers, pixels: nearer they are one to the screen.
    const APART_MIN: f32 = 16.0;

    /// Takes in a touch; one that begins over a panel is the panel's.
    pub(super) fn take(&mut self, id: u64, phase: TouchPhase, at: Vec2, is_panels: bool) -> Asked {
        let known = self.down.iter().position(|(finger, _)| *finger == id);
        let before = self.pair();
        match (phase, known) {
            (TouchPhase::Started, None) if !is_panels => self.down.push((id, at)),
            (TouchPhase::Started | TouchPhase::Moved, Some(number)) => self.down[number].1 = at,
            (TouchPhase::Ended | TouchPhase::Cancelled, Some(number)) => {
                self.down.remove(number);
                let was_view = self.is_view;
                self.is_view &= !self.down.is_empty();
                return if was_view { Asked::Nothing } else { Asked::Tool { at, is_held: false } };
            }
            _ => return Asked::Nothing,
        }
        let Some([one, other]) = self.pair() else {
            return if self.is_view { Asked::Nothing } else { Asked::Tool { at, is_held: true } };
        };
        if !std::mem::replace(&mut self.is_view, true) {
            return Asked::Tool { at: one, is_held: false };
        }
        let Some([one_before, other_before]) = before else { return Asked::Nothing };
        let apart = |one: Vec2, other: Vec2| one.distance(other).max(Self::APART_MIN);
        Asked::View {
            by: 0.5 * (one + other - one_before - other_before),
            closer: apart(one, other) / apart(one_before, other_before),
        }
    }

    /// Where the first two are.
    fn pair(&self) -> Option<[Vec2; 2]> {
        match self.down.as_slice() {
            [(_, one), (_, other), ..] => Some([*one, *other]),
            _ => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use TouchPhase::{Cancelled, Ended, Moved, Started};

    const fn at(x: f32, y: f32) -> Vec2 {
        Vec2::new(x, y)
    }

    #[test]
    fn one_finger_holds_the_tool_until_it_goes_wherever_that_is() {
        let mut fingers = Fingers::default();
        assert_eq!(fingers.take(7, Started, at(10.0, 20.0), false), Asked::Tool { at: at(10.0, 20.0), is_held: true });
        assert_eq!(fingers.take(7, Moved, at(30.0, 20.0), false), Asked::Tool { at: at(30.0, 20.0), is_held: true });
        // over a panel as well, or the tool would stay in the clay
        for end in [Ended, Cancelled] {
            fingers.take(7, Started, at(10.0, 20.0), false);
            assert_eq!(fingers.take(7, end, at(5.0, 5.0), true), Asked::Tool { at: at(5.0, 5.0), is_held: false });
        }
        assert_eq!(fingers.take(8, Started, at(5.0, 5.0), true), Asked::Nothing, "the panel's");
        assert_eq!(fingers.take(8, Moved, at(90.0, 5.0), false), Asked::Nothing);
        assert_eq!(fingers.take(8, Ended, at(90.0, 5.0), false), Asked::Nothing);
    }

    #[test]
    fn a_second_finger_lifts_the_tool_and_two_turn_and_pinch_the_view() {
        let mut fingers = Fingers::default();
        fingers.take(1, Started, at(100.0, 100.0), false);
        let lifted = Asked::Tool { at: at(100.0, 100.0), is_held: false };
        assert_eq!(fingers.take(2, Started, at(200.0, 100.0), false), lifted);
        // one moves away from the other: half of its way turns, twice as far apart is twice as close
        let view = Asked::View { by: at(50.0, 0.0), closer: 2.0 };
        assert_eq!(fingers.take(2, Moved, at(300.0, 100.0), false), view);
        // both upwards
        assert_eq!(fingers.take(1, Moved, at(100.0, 80.0), false), {
            let closer = at(200.0, 20.0).length() / 200.0;
            Asked::View { by: at(0.0, -10.0), closer }
        });
        assert_eq!(fingers.take(3, Started, at(500.0, 500.0), false), Asked::View { by: Vec2::ZERO, closer: 1.0 });
        fingers.take(3, Ended, at(500.0, 500.0), false);
        // one stays: it does not press where it happens to be
        assert_eq!(fingers.take(1, Ended, at(100.0, 80.0), false), Asked::Nothing);
        assert_eq!(fingers.take(2, Moved, at(310.0, 100.0), false), Asked::Nothing);
        assert_eq!(fingers.take(2, Ended, at(310.0, 100.0), false), Asked::Nothing);
        assert_eq!(fingers.take(4, Started, at(1.0, 2.0), false), Asked::Tool { at: at(1.0, 2.0), is_held: true });
    }

    #[test]
    fn fingers_that_meet_neither_fly_off_nor_divide_by_nothing() {
        let mut fingers = Fingers::default();
        fingers.take(1, Started, at(100.0, 100.0), false);
        fingers.take(2, Started, at(100.0, 100.0), false);
        assert_eq!(fingers.take(2, Moved, at(108.0, 100.0), false), Asked::View { by: at(4.0, 0.0), closer: 1.0 });
    }
}
