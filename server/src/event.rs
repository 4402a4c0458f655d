//! What reaches the task that owns the room.
//!
//! Invariant: of one peer, `Connected` comes first and `Gone` last.

use pottery_shared::protocol::{NoOrder, Order, TeacherToken};
use pottery_shared::room::PeerId;
use tokio::sync::oneshot;

use crate::lesson::Lesson;
use crate::link::Link;
use crate::{Figures, Standing};

/// What reaches the room.
#[derive(Debug)]
pub(crate) enum Event {
    /// A connection has opened its control stream.
    Connected(PeerId, Box<Link>),
    /// A control frame.
    Control(PeerId, Vec<u8>),
    /// A datagram.
    Datagram(PeerId, bytes::Bytes),
    /// A connection has ended.
    Gone(PeerId),
    /// Somebody asks how things stand.
    Standing(oneshot::Sender<Standing>),
    /// Somebody asks what was counted.
    Figures(oneshot::Sender<Figures>),
    /// Somebody asks how the lesson stands.
    Lesson(oneshot::Sender<Lesson>),
    /// Somebody at the operators' port orders, and is told the code as it then is.
    Order(TeacherToken, Order, oneshot::Sender<Result<String, NoOrder>>),
    /// Close.
    Stop,
}
