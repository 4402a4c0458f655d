//! How much memory one connection can make the server hold, whatever its peer does.
//!
//! Owns the bounds; who keeps to them are `transport`, `link` and the core's own queues.
//! Invariant: everything that a connection can make grow has its bound here, and [`CONNECTION_BYTES_MAX`] is their sum.

use pottery_shared::protocol::CONTROL_MAX;
use pottery_shared::room::SIGHTS_MAX;
use pottery_shared::session::InputQueue;
use pottery_shared::tool::ToolSample;

/// Bytes of streams that have come and were not read yet: of one, and of all.
pub(crate) const STREAM_RECEIVED: usize = 64 * 1024;
pub(crate) const STREAMS_RECEIVED: usize = 128 * 1024;
/// Bytes of streams that were sent and that the peer has not acknowledged. A keyframe that is longer waits for the rest.
pub(crate) const STREAMS_SENT: usize = 256 * 1024;
/// Datagrams that have come and were not read yet: a second of samples.
pub(crate) const DATAGRAMS_RECEIVED: usize = 64 * 1024;
/// Datagrams that wait to be sent: a few pulses, since what waits longer is stale.
pub(crate) const DATAGRAMS_SENT: usize = 16 * 1024;
/// Control frames that may wait for a slow peer: all tools that can be brought to a wheel, told at once, and as much again.
pub const CONTROL_QUEUE: usize = 256;
/// Bytes of those frames.
pub const CONTROL_BYTES: usize = 1024 * 1024;
/// Bytes of keyframes that may be under way to one peer: two of a pot that was worked all over, or those of a gallery.
pub const KEYFRAME_BYTES: usize = 128 * 1024;
/// A frame that is being read, and what has come behind it.
const FRAME_READ: usize = 2 * (CONTROL_MAX + 4096);
/// Samples that wait for their tick, of whoever works; a queue that grows is twice as long for a moment.
const SAMPLES: usize = 2 * InputQueue::LENGTH_MAX * size_of::<(u32, ToolSample)>();
/// What is said of the tiles of each sight that is shown otherwise than it should be, of whoever looks on.
const SIGHTS: usize = SIGHTS_MAX * CONTROL_MAX;
/// What QUIC, TLS and the tasks hold of a connection beside: 60 to 80 kB were counted.
const CONNECTION: usize = 256 * 1024;

/// Connections that may be there without having been let in, beyond as many as the room takes people: whoever knocks while so many do
/// waits outside. Each is gone after 25 s, unless it is let in.
pub(crate) const STRANGERS: usize = 256;

/// Most bytes that one connection can make the server hold: 3.5 MB.
///
/// A wheel whose grid is so fine that its keyframe is longer than 128 kB makes that one keyframe more, at most
/// [`pottery_shared::protocol::KEYFRAME_MAX`]. What is told to all, and what a wheel remembers of its clay, is held once and not for each connection.
/// Whoever works is a hand at a wheel: for each of those that press at once beyond the second it sets aside 128 bytes an element, which are in memory as
/// far as they are pressed with. Of pots that a hand brings, one that is coming and one that waits for its turn are held beside, two bytes an element and
/// skin each.
pub const CONNECTION_BYTES_MAX: usize = STREAMS_RECEIVED
    + STREAMS_SENT
    + DATAGRAMS_RECEIVED
    + DATAGRAMS_SENT
    + CONTROL_BYTES
    + KEYFRAME_BYTES
    + FRAME_READ
    // nobody works and looks on over one connection
    + if SAMPLES > SIGHTS { SAMPLES } else { SIGHTS }
    + CONNECTION;
