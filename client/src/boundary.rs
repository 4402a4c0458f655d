//! The boundary between the 1 kHz thread and everything else.
//!
//! A ring of samples out, a triple buffer of clay in, and a handful of atomics: nobody ever waits for the other side.
//! Invariant: no type of this module that the 1 kHz thread touches takes a lock or allocates.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU32, AtomicU64, Ordering};

use glam::Vec3;
use pottery_shared::haptics::{Fault, Guidance, Guided};
use pottery_shared::prediction::Patch;
use pottery_shared::tool::{Orientation, Shape, Side, Sphere, Tool, ToolSample};
use pottery_shared::units::Tick;

use crate::sound::Rub;

/// Samples the ring holds: the network may stall for four seconds.
const RING_SAMPLES: usize = 4096;
/// News of a teacher's hand that the other ring holds: a second of them.
const RING_NEWS: usize = 128;

/// Marks a convex tool among the numbers of what is held.
const CONVEX: u32 = 1 << 16;

/// What the hand hears of a teacher, or of being one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum GuideNews {
    /// A teacher guides it, otherwise than before, or no longer.
    Guided(Option<Guidance>),
    /// It leads a student's hand, or no longer.
    Leads(bool),
    /// The teacher's tool was somewhere, m, at a tick.
    Teacher(Tick, Vec3),
    /// Which tool that is, and how it is turned.
    TeachersGrip(Tool, Orientation),
}

/// What both sides may read at any time; each field is written by one side only.
#[derive(Debug, Default)]
pub struct Status {
    /// What to add to a local tick to get the tick to stamp; written by the network's side.
    tick_offset: AtomicI64,
    /// How often a connection took the place of another, whose ticks tell nothing of this one's; written by the network's side.
    sessions: AtomicU32,
    /// The tool is to be lifted; written by the owner.
    lifted: AtomicBool,
    /// The room takes no presses; written by the network's side.
    held: AtomicBool,
    /// The person wants no force; written by the owner.
    force_off: AtomicBool,
    /// The student wants no guidance, until the next begins; written by the owner.
    unguided: AtomicBool,
    /// The tool points and presses nothing; written by the owner.
    pointing: AtomicBool,
    /// Force on the hand, N, as bits; written by the 1 kHz thread, as all that follows.
    force_n: AtomicU32,
    elements: AtomicU32,
    /// How the tool rubs the clay: N, m/s and wetness, as bits.
    rub: [AtomicU32; 3],
    fault: AtomicU32,
    /// The tool's centre, m, as bits; not a number while there is no tool in hand.
    tool_m: [AtomicU32; 3],
    /// Which tool that is, and how it is turned: see [`Status::note_grip`].
    grip: AtomicU32,
    turned: AtomicU64,
    /// It works inside of the pot.
    inside: AtomicBool,
    /// The teacher's tool as it is felt, m, as bits; not a number while there is none.
    teacher_m: [AtomicU32; 3],
    /// How the hand is guided: m, from 0 to 1, N and s, as bits; not a number while it is not.
    guided: [AtomicU32; 4],
    ticks: AtomicU64,
    late_ticks: AtomicU64,
    lost_samples: AtomicU64,
}

/// How a hand is guided, as it is shown; its figures may be a tick apart.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GuidedFigures {
    /// How far the device is from the teacher's tool, m.
    pub error_m: f32,
    /// How much help is left while being led, 0 to 1.
    pub assistance: f32,
    /// The force of guidance, N.
    pub force_n: f32,
    /// How old the teacher's place is, s.
    pub late_s: f32,
}

impl Status {
    /// What to add to a local tick to get the tick to stamp.
    #[must_use]
    pub fn tick_offset(&self) -> i64 {
        self.tick_offset.load(Ordering::Relaxed)
    }

    pub(crate) fn set_tick_offset(&self, offset: i64) {
        self.tick_offset.store(offset, Ordering::Relaxed);
    }

    /// Says that ticks are another server's from now on.
    pub(crate) fn begin_session(&self) {
        self.sessions.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn sessions(&self) -> u32 {
        self.sessions.load(Ordering::Relaxed)
    }

    pub(crate) fn is_lifted(&self) -> bool {
        self.lifted.load(Ordering::Relaxed) || self.held.load(Ordering::Relaxed)
    }

    pub(crate) fn hold(&self, held: bool) {
        self.held.store(held, Ordering::Relaxed);
    }

    /// Whether the room takes no presses, so that the tool is lifted.
    #[must_use]
    pub fn is_held(&self) -> bool {
        self.held.load(Ordering::Relaxed)
    }

    /// Lifts the tool off the clay, or lets it down again.
    pub fn lift(&self, lifted: bool) {
        self.lifted.store(lifted, Ordering::Relaxed);
    }

    /// Takes the force away from the next tick on, or gives it back; the tool stays in the hand either way.
    pub fn switch_force_off(&self, off: bool) {
        self.force_off.store(off, Ordering::Relaxed);
    }

    /// Whether the person wants no force.
    #[must_use]
    pub fn is_force_off(&self) -> bool {
        self.force_off.load(Ordering::Relaxed)
    }

    /// Ends being guided in the next tick, whatever the network does; the next order to guide begins anew.
    pub fn end_guidance(&self) {
        self.unguided.store(true, Ordering::Relaxed);
    }

    pub(crate) fn is_unguided(&self) -> bool {
        self.unguided.load(Ordering::Relaxed)
    }

    pub(crate) fn begin_guidance(&self) {
        self.unguided.store(false, Ordering::Relaxed);
    }

    /// Points with the tool from now on, without pressing, or presses again.
    pub fn point(&self, points: bool) {
        self.pointing.store(points, Ordering::Relaxed);
    }

    /// Whether the tool points and presses nothing.
    #[must_use]
    pub fn is_pointing(&self) -> bool {
        self.pointing.load(Ordering::Relaxed)
    }

    pub(crate) fn note_guided(&self, guided: Option<Guided>) {
        let teacher_m = guided.and_then(|guided| guided.teacher_m).unwrap_or(Vec3::NAN);
        for (stored, along) in self.teacher_m.iter().zip(teacher_m.to_array()) {
            stored.store(along.to_bits(), Ordering::Relaxed);
        }
        let figures =
            guided.map_or([f32::NAN; 4], |guided| [guided.error_m, guided.assistance, guided.force_n, guided.late.0]);
        for (stored, figure) in self.guided.iter().zip(figures) {
            stored.store(figure.to_bits(), Ordering::Relaxed);
        }
    }

    /// Where the teacher's tool is felt and drawn, m, while one guides this hand.
    #[must_use]
    pub fn teacher_m(&self) -> Option<Vec3> {
        let along = |axis: usize| f32::from_bits(self.teacher_m[axis].load(Ordering::Relaxed));
        let at_m = Vec3::new(along(0), along(1), along(2));
        at_m.is_finite().then_some(at_m)
    }

    /// How the hand is guided, while it is.
    #[must_use]
    pub fn guided(&self) -> Option<GuidedFigures> {
        let [error_m, assistance, force_n, late_s] =
            [0, 1, 2, 3].map(|figure| f32::from_bits(self.guided[figure].load(Ordering::Relaxed)));
        (!error_m.is_nan()).then_some(GuidedFigures { error_m, assistance, force_n, late_s })
    }

    pub(crate) fn note_tick(&self, force_n: f32, elements: u32, fault: Option<Fault>) {
        self.force_n.store(force_n.to_bits(), Ordering::Relaxed);
        self.elements.store(elements, Ordering::Relaxed);
        let fault = match fault {
            None => 0,
            Some(Fault::Position) => 1,
            Some(Fault::Jump) => 2,
            Some(Fault::Force) => 3,
            Some(Fault::Specs) => 4,
        };
        self.fault.store(fault, Ordering::Relaxed);
        self.ticks.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn note_rub(&self, rub: Rub) {
        for (stored, value) in self.rub.iter().zip([rub.force_n, rub.slip_m_s, rub.wetness]) {
            stored.store(value.to_bits(), Ordering::Relaxed);
        }
    }

    /// How the tool rubs the clay, whether its force is given or not; its figures may be a tick apart.
    #[must_use]
    pub fn rub(&self) -> Rub {
        let [force_n, slip_m_s, wetness] =
            [0, 1, 2].map(|figure| f32::from_bits(self.rub[figure].load(Ordering::Relaxed)));
        Rub { force_n, slip_m_s, wetness }
    }

    pub(crate) fn note_tool(&self, centre_m: Option<Vec3>) {
        for (stored, along) in self.tool_m.iter().zip(centre_m.unwrap_or(Vec3::NAN).to_array()) {
            stored.store(along.to_bits(), Ordering::Relaxed);
        }
    }

    /// Where the tool in hand is, m, for drawing: its coordinates may be a tick apart.
    #[must_use]
    pub fn tool_m(&self) -> Option<Vec3> {
        let along = |axis: usize| f32::from_bits(self.tool_m[axis].load(Ordering::Relaxed));
        let centre_m = Vec3::new(along(0), along(1), along(2));
        centre_m.is_finite().then_some(centre_m)
    }

    /// Notes which tool is in the hand: the radius of a sphere in µm, or 2¹⁶ and the number of a convex one; and its three angles.
    pub(crate) fn note_grip(&self, tool: Tool, orientation: Orientation) {
        let held = match tool {
            Tool::Sphere(sphere) => u32::from(sphere.micrometres()),
            Tool::Convex(Shape(shape)) => CONVEX | u32::from(shape),
        };
        let [yaw, pitch, roll] = orientation.0.map(|angle| u64::from(angle.cast_unsigned()));
        self.grip.store(held, Ordering::Relaxed);
        self.turned.store(yaw << 32 | pitch << 16 | roll, Ordering::Relaxed);
    }

    /// The tool in hand and how it is turned; both may be a tick apart.
    #[must_use]
    pub fn grip(&self) -> Option<(Tool, Orientation)> {
        let (held, turned) = (self.grip.load(Ordering::Relaxed), self.turned.load(Ordering::Relaxed));
        let tool = match held & CONVEX {
            0 => Sphere::of_micrometres(held as u16)?.into(),
            _ => Tool::Convex(Shape(held as u8)),
        };
        Some((tool, Orientation([32, 16, 0].map(|bits| ((turned >> bits) as u16).cast_signed()))))
    }

    pub(crate) fn note_side(&self, side: Side) {
        self.inside.store(side == Side::Inside, Ordering::Relaxed);
    }

    /// On which side of the wall the tool works.
    #[must_use]
    pub fn side(&self) -> Side {
        if self.inside.load(Ordering::Relaxed) { Side::Inside } else { Side::Outside }
    }

    pub(crate) fn note_late(&self) {
        self.late_ticks.fetch_add(1, Ordering::Relaxed);
    }

    pub(crate) fn note_lost_sample(&self) {
        self.lost_samples.fetch_add(1, Ordering::Relaxed);
    }

    /// Force on the hand, N.
    #[must_use]
    pub fn force_n(&self) -> f32 {
        f32::from_bits(self.force_n.load(Ordering::Relaxed))
    }

    /// Elements of clay in contact.
    #[must_use]
    pub fn elements(&self) -> u32 {
        self.elements.load(Ordering::Relaxed)
    }

    /// The fault that keeps the force off.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        match self.fault.load(Ordering::Relaxed) {
            0 => None,
            1 => Some(Fault::Position),
            2 => Some(Fault::Jump),
            3 => Some(Fault::Force),
            _ => Some(Fault::Specs),
        }
    }

    /// Ticks done.
    #[must_use]
    pub fn ticks(&self) -> u64 {
        self.ticks.load(Ordering::Relaxed)
    }

    /// Ticks that began late.
    #[must_use]
    pub fn late_ticks(&self) -> u64 {
        self.late_ticks.load(Ordering::Relaxed)
    }

    /// Samples that found the ring full.
    #[must_use]
    pub fn lost_samples(&self) -> u64 {
        self.lost_samples.load(Ordering::Relaxed)
    }
}

/// The 1 kHz thread's end.
#[derive(Debug)]
pub struct HandSide {
    pub(crate) samples: rtrb::Producer<ToolSample>,
    pub(crate) patches: triple_buffer::Output<Patch>,
    pub(crate) guide: rtrb::Consumer<GuideNews>,
    pub(crate) status: Arc<Status>,
}

/// The network's end.
#[derive(Debug)]
pub struct NetSide {
    samples: rtrb::Consumer<ToolSample>,
    patches: triple_buffer::Input<Patch>,
    guide: rtrb::Producer<GuideNews>,
    status: Arc<Status>,
}

impl NetSide {
    /// The oldest sample of the hand that was not fetched yet.
    pub fn next_sample(&mut self) -> Option<ToolSample> {
        self.samples.pop().ok()
    }

    /// Gives the hand the clay that `write` makes of an older patch; clay that the hand has not come to is replaced.
    pub fn publish(&mut self, write: impl FnOnce(&mut Patch)) {
        write(self.patches.input_buffer_mut());
        self.patches.publish();
    }

    /// Tells the hand of a teacher; false when it has not listened for a second, and what is told is lost.
    pub fn tell(&mut self, news: GuideNews) -> bool {
        if matches!(news, GuideNews::Guided(Some(_))) {
            self.status.begin_guidance();
        }
        self.guide.push(news).is_ok()
    }

    /// What both sides may read.
    #[must_use]
    pub fn status(&self) -> &Status {
        &self.status
    }
}

/// Both ends over the clay as it is now.
#[must_use]
pub fn boundary(patch: &Patch) -> (HandSide, NetSide) {
    let (producer, consumer) = rtrb::RingBuffer::new(RING_SAMPLES);
    let (input, output) = triple_buffer::TripleBuffer::new(patch).split();
    let (tells, guide) = rtrb::RingBuffer::new(RING_NEWS);
    let status = Arc::new(Status::default());
    status.note_guided(None);
    (
        HandSide { samples: producer, patches: output, guide, status: Arc::clone(&status) },
        NetSide { samples: consumer, patches: input, guide: tells, status },
    )
}
