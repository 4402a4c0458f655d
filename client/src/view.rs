//! What there is to see: the predicted clay, everybody's tools, and how the connection stands.
//!
//! Written by the worker, read by whoever draws; neither is the 1 kHz thread, so a lock may stand between them.
//! Invariant: `changed` holds every tile in which the picture changed since the drawer last cleared it.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use pottery_shared::clay::{Conditions, Pot, Surface};
use pottery_shared::protocol::{NoOrder, NoStep, StepsWire};
use pottery_shared::session::{ClassView, Client, RemoteTool};
use pottery_shared::snapshot::Touched;
use pottery_shared::tool::{ConvexTool, Shape};

use crate::fade::Fade;
use crate::guiding::GuidanceShown;
use crate::stroke::StrokeRecorder;

/// How the connection stands.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Link {
    /// It works.
    Open,
    /// It is being made anew; the sentence says how it broke.
    ComingBack(String),
    /// The studio asks a teacher to let this client in again.
    Waiting,
    /// The studio has closed.
    Closed,
    /// It broke; the sentence says how.
    Lost(String),
}

/// A picture's worth of what a client knows.
#[derive(Clone, Debug)]
pub struct View {
    /// The client's number in the room.
    pub number: u16,
    /// The predicted clay.
    pub pot: Pot,
    /// The clay to draw: predicted, with corrections that fade in.
    pub picture: Fade,
    /// False while one who waits for the wheel's clay has an untouched pot in its place.
    pub is_whole: bool,
    /// Tiles of the picture to draw anew.
    pub changed: Touched,
    /// The convex tools of the wheel, by their number.
    pub rack: Arc<[ConvexTool]>,
    /// The number of the tool that this client brought last, or the sentence that says why it has none.
    pub brought: Option<Result<Shape, String>>,
    /// What can be undone and redone.
    pub steps: StepsWire,
    /// Why the last step back or forth was none, until somebody has taken it.
    pub no_step: Option<NoStep>,
    /// Who is here, and what a teacher may know beside.
    pub class: ClassView,
    /// Why the last order was not done, until somebody has taken it.
    pub no_order: Option<NoOrder>,
    /// Who guides whom, and what is shown of it.
    pub guidance: GuidanceShown,
    /// Everybody's tools on their ways, the client's own included.
    pub tools: Vec<RemoteTool>,
    /// Wheel, material and method.
    pub conditions: Conditions,
    /// What to add to a local tick to get the tick to stamp.
    pub tick_offset: i64,
    /// Measured round trip.
    pub round_trip: Duration,
    /// Time since anything came from the server, which tells of a wheel several times a second.
    pub silence: Duration,
    /// SHA-256 of the certificate that the server showed.
    pub fingerprint: Option<[u8; 32]>,
    /// How the connection stands.
    pub link: Link,
    /// What was recorded of the own stroke, every half minute or, of a long one, each time a twentieth more was, until somebody has taken it.
    pub recording: Option<StrokeRecorder>,
    /// Digest of the confirmed clay.
    pub digest: u64,
    /// Every own press is confirmed and the newest known clay is held.
    pub settled: bool,
}

/// A view that worker and drawer share.
#[derive(Clone, Debug)]
pub struct SharedView(Arc<Mutex<View>>);

impl SharedView {
    pub(crate) fn new(session: &Client) -> Self {
        let pot = session.predicted().clone();
        let changed = Touched::none(pot.surfaces().iter().map(Surface::shape));
        Self(Arc::new(Mutex::new(View {
            number: session.number(),
            changed,
            picture: Fade::new(&pot),
            pot,
            is_whole: false,
            rack: session.rack(),
            brought: None,
            steps: *session.steps(),
            no_step: None,
            class: session.class().clone(),
            no_order: None,
            guidance: GuidanceShown::default(),
            tools: Vec::new(),
            conditions: session.conditions().clone(),
            tick_offset: session.tick_offset(),
            round_trip: Duration::ZERO,
            silence: Duration::ZERO,
            recording: None,
            fingerprint: None,
            link: Link::Open,
            digest: session.replica().digest(),
            settled: true,
        })))
    }

    /// The view, locked; hold it no longer than a copy takes.
    pub fn lock(&self) -> MutexGuard<'_, View> {
        // a view is whole between any two of its fields, so a panic elsewhere leaves nothing half done
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
