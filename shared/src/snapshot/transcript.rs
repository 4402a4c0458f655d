//! What was pressed between two snapshots, sub-step by sub-step, so that others can press it again.
//!
//! Owns the order of its symbols and the prediction of a hand's way; presses nothing itself.
//! Invariant: what [`Transcript::decode`] makes of [`Transcript::encode`]'s bytes is what went in.
//!
//! A hand goes on as it went, and its steps are coded as movements are. Who presses in a sub-step is mostly who pressed in the
//! one before.

use alloc::vec::Vec;

use crate::coding::{BitModel, Decoder, Encoder, Magnitude, Movement, Signed, StepModel, Symbols};
use crate::tool::{Orientation, Position, Shape, Side, Sphere, Tool, ToolSample};
use crate::units::Tick;

/// A sample as it was pressed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pressed {
    /// Whose: the number given in the welcome.
    pub client: u16,
    /// The sample.
    pub sample: ToolSample,
    /// The sample of the same hand from which the tool came, if it [follows](ToolSample::follows) it.
    pub before: Option<ToolSample>,
}

/// Everything that was pressed since the last snapshot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Transcript {
    pressed: Vec<Pressed>,
    /// Where each sub-step ends in `pressed`.
    ends: Vec<usize>,
}

impl Transcript {
    /// Most sub-steps: those of a snapshot's period, with all that a tick may catch up on.
    pub const SUB_STEPS_MAX: usize = 256;
    /// Most samples in it: a full class at one wheel.
    pub const PRESSED_MAX: usize = 4096;

    /// Adds a sub-step; false, and nothing is added, when it would be too long.
    pub fn add(&mut self, pressed: impl IntoIterator<Item = Pressed>) -> bool {
        let start = self.pressed.len();
        self.pressed.extend(pressed);
        // the order within a sub-step means nothing, and ascending numbers are short
        self.pressed[start..].sort_unstable_by_key(|pressed| pressed.client);
        let fits = self.ends.len() < Self::SUB_STEPS_MAX && self.pressed.len() <= Self::PRESSED_MAX;
        if fits {
            self.ends.push(self.pressed.len());
        } else {
            self.pressed.truncate(start);
        }
        fits
    }

    /// Forgets everything.
    pub fn clear(&mut self) {
        self.pressed.clear();
        self.ends.clear();
    }

    /// The sub-steps in their order.
    pub fn sub_steps(&self) -> impl Iterator<Item = &[Pressed]> {
        let starts = core::iter::once(0).chain(self.ends.iter().copied());
        starts.zip(&self.ends).map(|(start, &end)| &self.pressed[start..end])
    }

    /// One of its sub-steps, and how many samples come before it.
    #[must_use]
    pub fn sub_step(&self, number: usize) -> Option<(usize, &[Pressed])> {
        let end = *self.ends.get(number)?;
        let start = number.checked_sub(1).map_or(0, |before| self.ends[before]);
        Some((start, &self.pressed[start..end]))
    }

    /// How many samples are in it.
    #[must_use]
    pub fn pressed(&self) -> usize {
        self.pressed.len()
    }

    /// Its bytes; `since` is the tick of the snapshot before.
    #[must_use]
    pub fn encode(&self, since: Tick) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut encoder = Encoder::new(&mut bytes);
        let mut models = Models::new(since);
        for step in self.sub_steps() {
            encoder.bit(&mut models.more, true);
            models.hands(&mut encoder, step);
            for pressed in step {
                models.pressed(&mut encoder, pressed.client, Some(pressed));
            }
        }
        encoder.bit(&mut models.more, false);
        encoder.finish();
        bytes
    }

    /// What was encoded; `None` when the bytes are no transcript.
    #[must_use]
    pub fn decode(bytes: &[u8], since: Tick) -> Option<Self> {
        let mut decoder = Decoder::new(bytes);
        let mut models = Models::new(since);
        let mut transcript = Self::default();
        while decoder.bit(&mut models.more, false) {
            models.hands(&mut decoder, &[]);
            let hands = models.present.len();
            if decoder.is_exhausted() || transcript.pressed.len() + hands > Self::PRESSED_MAX {
                return None;
            }
            for at in 0..hands {
                let client = models.present[at];
                transcript.pressed.push(models.pressed(&mut decoder, client, None)?);
            }
            transcript.ends.push(transcript.pressed.len());
            if transcript.ends.len() > Self::SUB_STEPS_MAX {
                return None;
            }
        }
        (!decoder.is_exhausted() && !decoder.has_rest()).then_some(transcript)
    }
}

/// A hand as the transcript last told of it.
#[derive(Clone, Copy, Debug)]
struct Known {
    client: u16,
    last: ToolSample,
    moves: Movement,
    turns: Movement,
}

/// The learned state of one transcript, for both directions.
#[derive(Debug)]
struct Models {
    since: Tick,
    /// Who presses in the sub-step, in ascending order.
    present: Vec<u16>,
    known: Vec<Known>,
    more: BitModel,
    same_hands: BitModel,
    hands: Magnitude,
    client: Magnitude,
    goes_on: BitModel,
    ticks: Signed,
    turns: StepModel,
    came: BitModel,
    steps: StepModel,
    back: Signed,
    place: Signed,
}

impl Models {
    fn new(since: Tick) -> Self {
        Self {
            since,
            present: Vec::new(),
            known: Vec::new(),
            more: BitModel::zero_in_4096(256),
            same_hands: BitModel::zero_in_4096(512),
            hands: Magnitude::new(),
            client: Magnitude::new(),
            goes_on: BitModel::zero_in_4096(512),
            ticks: Signed::new(),
            turns: StepModel::of_angles(),
            came: BitModel::EVEN,
            steps: StepModel::of_places(),
            back: Signed::new(),
            place: Signed::new(),
        }
    }

    /// Goes on from who pressed in the sub-step before to who presses in the next one.
    fn hands(&mut self, symbols: &mut impl Symbols, given: &[Pressed]) {
        let are_others = !given.iter().map(|pressed| &pressed.client).eq(&self.present);
        if !symbols.bit(&mut self.same_hands, are_others) {
            return;
        }
        self.present.clear();
        let count = self.hands.code(symbols, given.len() as u32).min(Transcript::PRESSED_MAX as u32 + 1);
        let mut next = 0_u16;
        for at in 0..count as usize {
            let gap = given.get(at).map_or(0, |pressed| u32::from(pressed.client.wrapping_sub(next)));
            let client = next.wrapping_add(self.client.code(symbols, gap) as u16);
            self.present.push(client);
            next = client.wrapping_add(1);
        }
    }

    /// One sample; `None` when decoding something that is none.
    fn pressed(&mut self, symbols: &mut impl Symbols, client: u16, given: Option<&Pressed>) -> Option<Pressed> {
        let at = self.known.iter().position(|known| known.client == client);
        if let Some(at) = at {
            let known = self.known[at];
            if !symbols.bit(&mut self.goes_on, given.is_some_and(|given| !known.goes_on_to(given))) {
                return self.next(symbols, at, given);
            }
        }
        let pressed = self.anew(symbols, client, given)?;
        let (moves, turns) = pressed.before.map_or_else(Default::default, |before| {
            (
                Movement::after(way(before.centre, pressed.sample.centre)),
                Movement::after(turned(before.orientation, pressed.sample.orientation)),
            )
        });
        let known = Known { client, last: pressed.sample, moves, turns };
        match at {
            Some(at) => self.known[at] = known,
            None => self.known.push(known),
        }
        Some(pressed)
    }

    /// The sample of a hand that goes on as it went: the next tick, with what it had in it.
    fn next(&mut self, symbols: &mut impl Symbols, at: usize, given: Option<&Pressed>) -> Option<Pressed> {
        let known = &mut self.known[at];
        let before = known.last;
        let moved = given.map_or([0; 3], |given| way(before.centre, given.sample.centre));
        let moved = known.moves.step(symbols, &mut self.steps, moved);
        let centre = core::array::from_fn(|axis| before.centre.0[axis].wrapping_add(moved[axis]));
        let mut orientation = before.orientation;
        if matches!(before.tool, Tool::Convex(_)) {
            let by = given.map_or([0; 3], |given| turned(before.orientation, given.sample.orientation));
            let by = known.turns.step(symbols, &mut self.turns, by);
            for (angle, by) in orientation.0.iter_mut().zip(by) {
                *angle = angle.wrapping_add(by as i16);
            }
        }
        let tick = Tick(before.tick.0.checked_add(1)?);
        let sample = ToolSample { tick, centre: Position(centre), orientation, ..before };
        known.last = sample;
        let sound = sample.centre.is_within_reach() && sample.follows(&before);
        sound.then_some(Pressed { client: known.client, sample, before: Some(before) })
    }

    /// A sample of which nothing is known.
    fn anew(&mut self, symbols: &mut impl Symbols, client: u16, given: Option<&Pressed>) -> Option<Pressed> {
        let ticks = given.map_or(0, |given| given.sample.tick.since(self.since)) as i32;
        let tick = self.since.0.checked_add_signed(i64::from(self.ticks.code(symbols, ticks)))?;
        let (tool, orientation) = held(symbols, given)?;
        let side = given.is_some_and(|given| given.sample.side == Side::Inside);
        let side = if symbols.raw(u32::from(side), 1) == 1 { Side::Inside } else { Side::Outside };
        let mut centre = [0; 3];
        for (axis, along) in centre.iter_mut().enumerate() {
            *along = self.place.code(symbols, given.map_or(0, |given| given.sample.centre.0[axis]));
        }
        let sample = ToolSample { tick: Tick(tick), tool, orientation, centre: Position(centre), side };
        let came_from = given.and_then(|given| given.before);
        let mut before = None;
        if symbols.bit(&mut self.came, came_from.is_some()) {
            let ticks = came_from.map_or(0, |from| sample.tick.since(from.tick)) as u32;
            let tick = Tick(tick.checked_sub(u64::from(symbols.raw(ticks, 3)))?);
            let mut from = sample;
            for (axis, along) in from.centre.0.iter_mut().enumerate() {
                let back = came_from.map_or(0, |came_from| came_from.centre.0[axis].wrapping_sub(*along));
                *along = along.wrapping_add(self.back.code(symbols, back));
            }
            let came_from_orientation = came_from.map_or(orientation, |from| from.orientation);
            if matches!(tool, Tool::Convex(_)) {
                from.orientation = angles(symbols, came_from_orientation);
            }
            before = Some(ToolSample { tick, ..from });
        }
        let sound = sample.centre.is_within_reach()
            && before.is_none_or(|before| before.centre.is_within_reach() && sample.follows(&before));
        sound.then_some(Pressed { client, sample, before })
    }
}

impl Known {
    /// Whether a sample comes straight after the last one, with the same tool in the hand.
    fn goes_on_to(&self, pressed: &Pressed) -> bool {
        pressed.before == Some(self.last) && pressed.sample.tick == self.last.tick.next()
    }
}

/// The tool in a hand and how it is turned; `None` when decoding a sphere that cannot be.
fn held(symbols: &mut impl Symbols, given: Option<&Pressed>) -> Option<(Tool, Orientation)> {
    let tool = given.map_or_else(Tool::default, |given| given.sample.tool);
    let orientation = given.map_or_else(Orientation::default, |given| given.sample.orientation);
    let is_convex = symbols.raw(u32::from(tool.sphere().is_none()), 1) == 1;
    if is_convex {
        let number = if let Tool::Convex(Shape(number)) = tool { number } else { 0 };
        let shape = Shape(symbols.raw(u32::from(number), 8) as u8);
        return Some((Tool::Convex(shape), angles(symbols, orientation)));
    }
    let radius_um = tool.sphere().map_or(0, Sphere::micrometres);
    let sphere = Sphere::of_micrometres(symbols.raw(u32::from(radius_um), 16) as u16)?;
    Some((sphere.into(), Orientation::default()))
}

fn angles(symbols: &mut impl Symbols, orientation: Orientation) -> Orientation {
    Orientation(orientation.0.map(|angle| symbols.raw(u32::from(angle as u16), 16) as u16 as i16))
}

/// The way from one place to another, in steps.
fn way(from: Position, to: Position) -> [i32; 3] {
    core::array::from_fn(|axis| to.0[axis].wrapping_sub(from.0[axis]))
}

/// By how much a tool has turned, the shorter way round.
fn turned(from: Orientation, to: Orientation) -> [i32; 3] {
    core::array::from_fn(|about| to.0[about].wrapping_sub(from.0[about]).into())
}
