//! How a server's time and its snapshots go on, and which of its words cannot be true.
//!
//! The line proves who speaks, and not that it is so: a server with a fault may leap. Holds no clock; the own count of ticks is an argument.
//! Invariant: a single word that is false is refused, or forgotten after three true ones or as soon as time has come to it.
//!
//! A word is as old as its way was long, so that the server's time is never before its newest word, and quickest ones tell it best. What is said of a
//! later tick counts more, and between two ticks there are no more snapshots than time and late samples make. What does not agree with that is
//! refused. A server that says the same of it thrice has leapt indeed, or its welcome was late beyond measure: it is followed.

use super::{InputQueue, Lead};
use crate::snapshot::{SnapshotClock, Version};
use crate::units::Tick;

/// What was refused of a server's words, since it cannot be true.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Implausible {
    /// Words of a time to which the server cannot have come, or from which it went on.
    pub ticks: u64,
    /// Words of snapshots that there cannot be yet, or cannot be any longer.
    pub versions: u64,
    /// Words that acknowledge samples which were never made.
    pub acknowledged: u64,
}

impl Implausible {
    /// All of them.
    #[must_use]
    pub const fn total(&self) -> u64 {
        self.ticks + self.versions + self.acknowledged
    }
}

impl core::ops::AddAssign for Implausible {
    fn add_assign(&mut self, other: Self) {
        let Self { ticks, versions, acknowledged } = other;
        self.ticks += ticks;
        self.versions += versions;
        self.acknowledged += acknowledged;
    }
}

/// What to make of a word.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Word {
    /// It can be true.
    Sound,
    /// It is, and newer snapshots were told of than there are: they are to be forgotten.
    Back,
    /// It is: the server's time is another, so that what was stamped with the one before is worth nothing.
    Leapt,
    /// It cannot be true.
    Refused,
}

/// The newest word.
#[derive(Clone, Copy, Debug)]
struct Stand {
    tick: Tick,
    latest: Version,
}

/// How a word agrees with a stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Fit {
    Newer,
    /// It takes back what was said of an earlier tick.
    Back,
    /// Overtaken on the way.
    Older,
    /// Older than what is overtaken on a line: it says nothing new, and where such words go on the clock was set back.
    Late,
    Ahead,
    Versions,
}

impl Stand {
    fn fit(&self, word: &Self) -> Fit {
        let passed = word.tick.since(self.tick);
        let most = |ticks: i64| u64::from(self.latest.0) + snapshots_in(ticks as u64);
        match passed {
            ..0 if word.latest > self.latest => Fit::Versions,
            ..0 if passed < -Course::REORDERED_MAX => Fit::Late,
            ..0 => Fit::Older,
            _ if u64::from(word.latest.0) > most(passed + InputQueue::PAST_MAX) => Fit::Versions,
            // of one tick there may be several snapshots
            0 if word.latest < self.latest => Fit::Older,
            _ if word.latest < self.latest => Fit::Back,
            _ => Fit::Newer,
        }
    }
}

/// Most snapshots in so many ticks.
const fn snapshots_in(ticks: u64) -> u64 {
    ticks * SnapshotClock::PER_SECOND / Tick::PER_SECOND + 1
}

/// How far the server's time is ahead of the own count of ticks.
#[derive(Clone, Copy, Debug)]
struct Clock {
    /// As the welcome told it.
    welcome: i64,
    /// As the quickest word since told it, and the own tick then.
    quickest: i64,
    local: u64,
    /// Whether nothing else told it yet: a welcome that was lost and sent again is as late as a line may be silent.
    by_welcome: bool,
}

/// Where words that do not agree with what is known lead, and how many there were in a row.
#[derive(Clone, Copy, Debug)]
struct Doubt {
    stand: Stand,
    ahead: i64,
    times: u32,
    /// The own tick of the first.
    since: u64,
}

/// What is known of a server's time and snapshots.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Course {
    stand: Option<Stand>,
    /// Known where a welcome told the time.
    clock: Option<Clock>,
    doubt: Option<Doubt>,
    refused: Implausible,
}

impl Course {
    /// By how many ticks a word may be quicker than all before it: a line does not become so much shorter at once.
    pub(super) const QUICKER_MAX: i64 = 250;
    /// Ticks by which a word may be overtaken on the way.
    const REORDERED_MAX: i64 = 1000;
    /// Ticks in which clocks may drift apart by one more.
    const DRIFT_TICKS: u64 = 1000;
    /// Words in a row, each of a later tick, that are believed against what was known.
    const TIMES: u32 = 3;
    /// Ticks for which they go on where they are merely late: whoever stood still for a second, server or client, has as much to read of
    /// what was overtaken by a keyframe, or by what a full buffer let through, and reads it in a few milliseconds.
    const LATE_FOR: u64 = 1000;
    /// A room that has been open for thousands of years is none.
    const TICK_MAX: u64 = 1 << 48;

    /// The course of a server that was at `server` when it said so, which came at the own tick `local`.
    pub(super) const fn since(server: Tick, local: u64) -> Self {
        let welcome = server.0 as i64 - local as i64;
        let stand = Some(Stand { tick: Tick(0), latest: Version(0) });
        let clock = Some(Clock { welcome, quickest: welcome, local, by_welcome: true });
        Self { stand, clock, doubt: None, refused: Implausible { ticks: 0, versions: 0, acknowledged: 0 } }
    }

    /// The newest tick that is believed.
    pub(super) fn tick(&self) -> Tick {
        self.stand.map_or(Tick(0), |stand| stand.tick)
    }

    /// The newest snapshot that there is.
    pub(super) fn latest(&self) -> Version {
        self.stand.map_or(Version(0), |stand| stand.latest)
    }

    pub(super) const fn refused(&self) -> &Implausible {
        &self.refused
    }

    pub(super) const fn refuse_acknowledged(&mut self) {
        self.refused.acknowledged += 1;
    }

    /// Takes in that the server was at `tick`, and `latest` then its latest snapshot, which came at the own tick `local`. What is not `prompt` may
    /// come late by any time.
    pub(super) fn hear(&mut self, tick: Tick, latest: Version, local: u64, prompt: bool) -> Word {
        if tick.0 > Self::TICK_MAX {
            self.refused.ticks += 1;
            return Word::Refused;
        }
        let word = Stand { tick, latest };
        let ahead = tick.0 as i64 - local as i64;
        let Some(stand) = self.stand else {
            self.stand = Some(word);
            return Word::Sound;
        };
        let fit = if self.is_too_quick(ahead, local) { Fit::Ahead } else { stand.fit(&word) };
        match fit {
            Fit::Newer | Fit::Back => {
                self.believe(word, ahead, local, prompt);
                if fit == Fit::Newer {
                    return Word::Sound;
                }
                self.refused.versions += 1;
                Word::Back
            }
            Fit::Older => Word::Sound,
            Fit::Late if !prompt => Word::Sound,
            Fit::Late => {
                // nothing is read that late of a connection that may be silent for less
                let lasts = if tick.since(stand.tick) < -Lead::AWAY_MAX { 0 } else { Self::LATE_FOR };
                self.doubt(word, ahead, local, lasts).unwrap_or(Word::Sound)
            }
            Fit::Ahead | Fit::Versions => {
                let faults = if fit == Fit::Ahead { &mut self.refused.ticks } else { &mut self.refused.versions };
                *faults += 1;
                let followed = if prompt { self.doubt(word, ahead, local, 0) } else { None };
                followed.unwrap_or(Word::Refused)
            }
        }
    }

    fn is_too_quick(&self, ahead: i64, local: u64) -> bool {
        self.clock.is_some_and(|clock| {
            let drift = local.saturating_sub(clock.local) / Self::DRIFT_TICKS;
            let most = if clock.by_welcome { Lead::AWAY_MAX } else { Self::QUICKER_MAX };
            ahead - clock.quickest > most + drift as i64
        })
    }

    fn believe(&mut self, word: Stand, ahead: i64, local: u64, prompt: bool) {
        (self.stand, self.doubt) = (Some(word), None);
        let Some(clock) = &mut self.clock else { return };
        clock.by_welcome &= !prompt;
        if ahead > clock.quickest {
            (clock.quickest, clock.local) = (ahead, local);
        }
    }

    /// Takes in a word that speaks against what is known; what to make of it when it is the third, and they went on for so many ticks.
    fn doubt(&mut self, word: Stand, ahead: i64, local: u64, lasts: u64) -> Option<Word> {
        let before = self.doubt.filter(|doubt| {
            let fit = doubt.stand.fit(&word);
            (ahead - doubt.ahead).abs() <= Self::QUICKER_MAX && matches!(fit, Fit::Newer | Fit::Older)
        });
        let doubt = match before {
            // pieces of one pulse are one word
            Some(before) if word.tick > before.stand.tick => {
                Doubt { stand: word, ahead, times: before.times + 1, ..before }
            }
            Some(before) => before,
            None => Doubt { stand: word, ahead, times: 1, since: local },
        };
        if doubt.times < Self::TIMES || local.saturating_sub(doubt.since) < lasts {
            self.doubt = Some(doubt);
            return None;
        }
        let (known, is_earlier) = (self.latest(), word.tick < self.tick());
        (self.stand, self.doubt) = (Some(word), None);
        let away = self.clock.as_mut().map_or(0, |clock| {
            (clock.quickest, clock.local, clock.by_welcome) = (ahead, local, false);
            (ahead - clock.welcome).abs()
        });
        Some(if is_earlier || away > Lead::AWAY_MAX {
            Word::Leapt
        } else if word.latest < known {
            Word::Back
        } else {
            Word::Sound
        })
    }
}

#[cfg(test)]
mod tests {
    use alloc::vec::Vec;

    use super::*;

    /// A course of a server that is 5000 ticks ahead, after so many honest words.
    fn heard(words: u64) -> Course {
        let mut course = Course::since(Tick(5_000), 0);
        (1..=words).for_each(|word| assert_eq!(honest(&mut course, word), Word::Sound));
        course
    }

    /// The honest word of that number: every 17 ticks, with a snapshot each, and up to 10 ticks late.
    fn honest(course: &mut Course, word: u64) -> Word {
        course.hear(Tick(5_000 + 17 * word), Version(word as u32), 17 * word + word % 11, true)
    }

    #[test]
    fn one_false_word_moves_nothing_and_the_honest_ones_go_on() {
        let lies = [
            (u64::MAX, 100),
            (5_000 + 1_700 + 5_000, 100),
            (5_000 + 1_700 + 300, 5_000),
            (5_000 + 1_717, u32::MAX),
            (5_000 + 1_600, 101),
        ];
        for (tick, latest) in lies {
            let mut course = heard(100);
            assert_eq!(course.hear(Tick(tick), Version(latest), 1_701, true), Word::Refused, "{tick}, {latest}");
            assert_eq!((course.tick(), course.latest(), course.refused().total()), (Tick(6_700), Version(100), 1));
            assert_eq!(honest(&mut course, 101), Word::Sound);
        }
    }

    #[test]
    fn what_is_believed_wrongly_is_taken_back_when_time_has_come_to_it() {
        let mut course = heard(100);
        assert_eq!(course.hear(Tick(6_700 + 240), Version(300), 1_701, true), Word::Sound);
        // until then, honest words are of an earlier time and tell of nothing newer
        for word in 101..=114 {
            assert_eq!((honest(&mut course, word), course.latest()), (Word::Sound, Version(300)), "{word}");
        }
        assert_eq!((honest(&mut course, 115), course.latest()), (Word::Back, Version(115)));
        assert_eq!((honest(&mut course, 116), course.refused().versions), (Word::Sound, 1));
    }

    #[test]
    fn a_clock_that_is_another_is_followed_after_three_words() {
        // what a laptop slept
        let mut course = heard(100);
        let words = (1..=4).map(|word| course.hear(Tick(9_700 + 17 * word), Version(100), 1_700 + 17 * word, true));
        assert_eq!(words.collect::<Vec<_>>(), [Word::Refused, Word::Refused, Word::Sound, Word::Sound]);
        // a server that began anew a short time ago, where what was overtaken might have come first, or long ago, or that is farther ahead than any
        // silence explains
        let begins = [(170_000, Word::Sound, 60), (160_000, Word::Sound, 3), (175_000 + 13_000, Word::Refused, 3)];
        for (begins, meanwhile, third) in begins {
            let mut course = heard(10_000);
            for word in 1..=third + 1 {
                let passed = 17 * u64::from(word);
                let expected =
                    if word < third { meanwhile } else { [Word::Leapt, Word::Sound][(word - third) as usize] };
                let heard = course.hear(Tick(begins + passed), Version(word), 170_000 + passed, true);
                assert_eq!(heard, expected, "{begins}, {word}");
            }
            assert_eq!(course.latest(), Version(third + 1));
        }
    }

    #[test]
    fn what_a_newer_word_has_overtaken_by_more_than_a_second_is_no_other_clock() {
        let mut course = heard(100);
        // whoever stood still reads everything at once, and the newest first
        assert_eq!(course.hear(Tick(5_000 + 17 * 200), Version(200), 3_400, false), Word::Sound);
        for word in 101..200 {
            let local = 3_400 + 3 * (word - 100);
            assert_eq!(course.hear(Tick(5_000 + 17 * word), Version(word as u32), local, true), Word::Sound, "{word}");
        }
        assert_eq!((honest(&mut course, 218), course.latest()), (Word::Sound, Version(218)));
        assert_eq!(course.refused(), &Implausible::default());
    }

    #[test]
    fn a_welcome_may_be_late_and_the_first_word_is_believed_for_it() {
        let mut course = Course::since(Tick(5_000), 0);
        assert_eq!(course.hear(Tick(4_990), Version(3), 15, false), Word::Sound);
        assert_eq!(course.hear(Tick(6_900), Version(9), 17, true), Word::Sound);
        assert_eq!(course.hear(Tick(7_190), Version(9), 34, true), Word::Refused);
        assert_eq!(course.hear(Tick(6_917), Version(9), 34, true), Word::Sound);
    }

    #[test]
    fn where_no_welcome_told_the_time_a_false_one_is_over_after_three_words() {
        let mut course = Course::default();
        let mut say = |tick, latest| course.hear(Tick(tick), Version(latest), 0, true);
        // a wheel at which nobody is tells an old time, and then its own
        assert_eq!([say(70, 7), say(70, 7), say(3_600_000, 8)], [Word::Sound; 3]);
        assert_eq!([say(1 << 40, 1 << 30), say(3_600_017, 9)], [Word::Sound; 2]);
        assert_eq!([say(3_600_034, 10), say(3_600_050, 11)], [Word::Sound, Word::Leapt]);
        assert_eq!((course.tick(), course.latest()), (Tick(3_600_050), Version(11)));
    }

    #[test]
    fn one_pulse_in_many_pieces_is_said_once() {
        let mut course = heard(100);
        for _ in 0..20 {
            assert_eq!(course.hear(Tick(90_000), Version(100), 1_701, true), Word::Refused);
        }
        assert_eq!(honest(&mut course, 101), Word::Sound);
    }

    #[test]
    fn a_long_silence_a_slow_line_and_clocks_that_drift_are_believed() {
        let mut course = heard(100);
        // late by as much as is waited for, and then everything at once
        for word in 101..=700 {
            assert_eq!(course.hear(Tick(5_000 + 17 * word), Version(word as u32), 11_900 + word, true), Word::Sound);
        }
        // an hour later, with a clock of 500 parts in a million
        let word = Tick(5_000 + 3_600_000 + 1_800);
        assert_eq!(course.hear(word, Version(210_000), 3_600_000, true), Word::Sound);
        // a hand whose line was cut for ten seconds, all of whose samples are pressed at once
        assert_eq!(course.hear(word.offset(17), Version(210_590), 3_600_017, true), Word::Sound);
        // and what came behind everything else
        assert_eq!(course.hear(Tick(9_000), Version(300), 3_600_034, false), Word::Sound);
        assert_eq!(course.refused(), &Implausible::default());
    }
}
