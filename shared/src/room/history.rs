//! What can be undone at a wheel: everything pressed in the last minutes, whose stroke it was, and clay kept on the way.
//!
//! Owns strokes, log and marks, and the clay that is made again; the clay that people work at stays the bench's. Nothing is
//! overwritten: an undone stroke stays in the log.
//! Invariant: clay made again is what pressing the log makes without the strokes that are undone, bit for bit.

mod log;
mod marks;
mod recall;
mod remake;
mod strokes;

use self::log::Log;
pub(super) use self::log::Setting;
use self::marks::{Marks, Place};
use self::recall::Recall;
use self::remake::Remake;
use self::strokes::Strokes;
use crate::clay::{Conditions, Form, Pot, SubStep, Surface};
use crate::protocol::NoStep;
use crate::snapshot::{KeptClay, Pressed, Touched};
use crate::units::Tick;

/// A step of one person through what they did.
#[derive(Clone, Debug)]
pub(super) enum Step {
    /// Undo the newest stroke.
    Back,
    /// Redo the one that was undone last.
    Forth,
    /// Put other clay on the wheel.
    Anew(Anew),
}

/// Clay that somebody wants on the wheel.
#[derive(Clone, Debug)]
pub(super) enum Anew {
    /// New clay of a form, or that with which the wheel began.
    Form(Option<Form>),
    /// This.
    Clay(KeptClay),
}

/// The history of one wheel.
#[derive(Debug)]
pub(super) struct History {
    strokes: Strokes,
    log: Log,
    /// None holds anything of what is undone.
    marks: Marks,
    /// Tiles that changed since the newest mark, while nothing is made again.
    since_mark: Touched,
    remake: Option<Remake>,
    /// Clay of an earlier time, on its way.
    recall: Option<Recall>,
    /// The clay with which the wheel began, and who wants other clay at the next snapshot, and which.
    first: KeptClay,
    anew: Option<(u16, Anew)>,
    /// Whether other clay was put there since what is made again was begun: a second one waits, since nothing is forgotten meanwhile.
    has_put: bool,
    /// Where the clay has to be made again from, once what is being made is done.
    again_from: Option<u64>,
    /// Samples pressed again so far.
    remade: u64,
}

impl History {
    /// Samples after which clay is kept although somebody is at it.
    const MARK_EVERY: u64 = 2000;

    /// The history of a wheel on which a pot was just put.
    pub(super) fn beginning_with(pot: &Pot, conditions: &Conditions, now: Tick) -> Self {
        let marks = Marks::beginning_with(pot, conditions, now);
        Self {
            strokes: Strokes::default(),
            log: Log::new(),
            first: marks.newest().clay.clone(),
            anew: None,
            has_put: false,
            recall: None,
            marks,
            since_mark: Touched::none(pot.surfaces().iter().map(Surface::shape)),
            remake: None,
            again_from: None,
            remade: 0,
        }
    }

    /// Notes what was pressed in a sub-step: each sample, and whether it met clay.
    pub(super) fn note(&mut self, sub_step: &mut [(Pressed, bool)]) {
        // as a transcript keeps them
        sub_step.sort_unstable_by_key(|(pressed, _)| pressed.client);
        self.log.note(sub_step);
        let span = self.log.open_number();
        for (pressed, _) in sub_step.iter().filter(|(_, met)| *met) {
            self.strokes.note(pressed.client, pressed.sample.tick, span);
        }
    }

    /// Notes a change of the settings, which are then as given.
    pub(super) fn set(&mut self, setting: Setting, now: &Conditions) {
        self.log.set(setting, now);
    }

    /// Whether a sample belongs to a stroke that is undone already, and is not to be pressed.
    pub(super) fn is_undone(&self, client: u16, tick: Tick) -> bool {
        self.strokes.is_undone(client, tick)
    }

    /// How many strokes of a hand can be undone, and how many redone.
    pub(super) fn counts(&self, client: u16) -> (usize, usize) {
        self.strokes.counts(client)
    }

    /// Whether clay is being made again.
    pub(super) const fn is_remaking(&self) -> bool {
        self.remake.is_some()
    }

    /// Samples pressed again so far.
    pub(super) const fn remade(&self) -> u64 {
        self.remade
    }

    /// Bytes that are kept.
    pub(super) fn bytes(&self) -> usize {
        self.log.bytes() + self.marks.bytes()
    }

    /// Undoes or redoes a stroke of a hand that has held its tool up to a tick; `pot` is the wheel's.
    ///
    /// # Errors
    /// [`NoStep`] when there is none, or the wheel's clay does not go into the form that is asked for.
    pub(super) fn step(&mut self, step: Step, client: u16, held: Tick, pot: &Pot) -> Result<(), NoStep> {
        let span = match step {
            Step::Back if self.anew.as_ref().is_some_and(|(who, _)| *who == client) => {
                // not there yet
                self.anew = None;
                return Ok(());
            }
            Step::Back if self.recall.as_ref().is_some_and(|recall| recall.is_of(client)) => {
                self.recall = None;
                return Ok(());
            }
            Step::Back => self.strokes.undo(client, held)?,
            Step::Forth => self.strokes.redo(client)?,
            Step::Anew(Anew::Form(Some(form))) if form.check_clay_of(pot).is_err() => return Err(NoStep::NoPot),
            Step::Anew(anew) => {
                self.anew = Some((client, anew));
                return Ok(());
            }
        };
        if let Some(recall) = &mut self.recall {
            // what it was made of may be undone now
            recall.restart();
        }
        match &self.remake {
            Some(remake) if remake.span() >= span => {
                // what is being made is shown first, so that steps without end keep nobody from theirs
                self.again_from = Some(self.again_from.map_or(span, |from| from.min(span)));
            }
            Some(_) => self.strokes.leave_out_from(span),
            None => self.begin(span, pot),
        }
        Ok(())
    }

    /// Begins to make clay again, from the newest mark in which nothing of a span is.
    fn begin(&mut self, span: u64, pot: &Pot) {
        self.strokes.leave_out_from(0);
        self.marks.drop_behind(span);
        let mark = self.marks.newest();
        let mut pot = pot.clone();
        mark.clay.lay_on(&mut pot, &mut self.since_mark);
        self.has_put = false;
        self.remake = Some(Remake::starting_from(pot, mark.conditions.clone(), mark.place.span));
    }

    /// Presses so many samples again, and no more than those of a sub-step beyond; `pot` is the wheel's.
    pub(super) fn go_on(&mut self, substep: &mut SubStep, pot: &Pot, samples: u32, now: Tick) {
        let Some(remake) = &mut self.remake else { return self.recall_on(substep, pot, samples) };
        let mut left = samples;
        while left > 0 {
            let work = remake.go_on(&self.log, &self.strokes, substep, left);
            left = left.saturating_sub(work.pressed);
            self.remade += u64::from(work.pressed);
            if !work.is_at_snapshot {
                return;
            }
            let span = remake.span();
            // when it was come to first: what is made again is as old as it was
            let tick = self.log.since(span).unwrap_or(now);
            let place = Place { span, pressed: self.log.pressed_before(span), tick };
            if place.pressed - self.marks.newest().place.pressed >= Self::MARK_EVERY {
                remake.keep(place, &mut self.marks);
            }
        }
    }

    /// Ends what was pressed since the last snapshot; returns the clay that is to take the place of the wheel's `pot`: what was
    /// made again if it has come to here, or what somebody puts there.
    pub(super) fn end_span(&mut self, tick: Tick, pot: &Pot) -> Option<Pot> {
        let remade = self.take_remade(tick);
        let has_room = !(self.has_put && self.is_remaking());
        let Some((client, anew)) = self.anew.take_if(|_| has_room) else { return remade };
        self.has_put = true;
        let mut pot = remade.unwrap_or_else(|| pot.clone());
        let new = match anew {
            Anew::Clay(clay) => clay,
            Anew::Form(form) => {
                // that the clay goes into the form was seen to when it was asked for
                let formed = form.and_then(|form| form.of_clay_of(*pot.spec()).ok());
                formed.map_or_else(|| self.first.clone(), |formed| KeptClay::of(&formed))
            }
        };
        let span = self.log.put(Setting::Put(client, tick, new.clone(), new.unshared_bytes(&self.first)), tick);
        self.strokes.note_put(client, tick, span);
        new.lay_on(&mut pot, &mut self.since_mark);
        Some(pot)
    }

    /// Ends the log's span; returns the clay that was made again if it has come to here.
    fn take_remade(&mut self, tick: Tick) -> Option<Pot> {
        let is_done = self.remake.as_ref().is_some_and(|remake| remake.is_done(&self.log));
        self.log.close(tick, true);
        let mut remake = self.remake.take_if(|_| is_done)?;
        remake.meet_snapshot(&self.log);
        let (pot, since_mark) = remake.finish();
        self.since_mark = since_mark;
        // steps without end may follow, and none of them forgets anything
        self.forget(tick);
        if let Some(span) = self.again_from.take() {
            self.begin(span, &pot);
        }
        Some(pot)
    }

    /// Notes which tiles changed up to a snapshot.
    pub(super) fn note_touched(&mut self, touched: &Touched) {
        self.since_mark.add_all(touched);
    }

    /// Takes in that a snapshot was taken: keeps its clay if it is time, and forgets what is too old or too much.
    pub(super) fn note_snapshot(&mut self, pot: &Pot, conditions: &Conditions, now: Tick) {
        if self.is_remaking() || self.recall.is_some() {
            return;
        }
        let span = self.log.open_number();
        let place = Place { span, pressed: self.log.pressed_before(span), tick: now };
        let since = place.pressed - self.marks.newest().place.pressed;
        if since >= Self::MARK_EVERY || (since > 0 && self.strokes.are_over(now)) {
            self.marks.keep(place, pot, &mut self.since_mark, conditions);
            self.forget(now);
        }
    }

    /// Whether something was pressed that no kept clay has yet.
    pub(super) fn has_unkept(&self) -> bool {
        let pressed = self.log.pressed_before(self.log.open_number());
        self.log.open().transcript.pressed() > 0 || pressed > self.marks.newest().place.pressed
    }

    /// Takes in that time has passed, also where nobody is: forgets what is too old.
    pub(super) fn note_time(&mut self, now: Tick) {
        if !self.is_remaking() && self.recall.is_none() {
            self.forget(now);
        }
    }

    /// Forgets what is too old or too much.
    fn forget(&mut self, now: Tick) {
        while let Some(first) = self.marks.forget(now, self.log.bytes()) {
            self.log.forget_before(first);
            self.strokes.forget_before(first);
        }
    }
}
