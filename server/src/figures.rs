//! What a running server tells of itself: how long its ticks take, how many came late, what went out.
//!
//! Counts and nothing else; who asks, and in which form it is served, is for others.
//! Invariant: every figure counts from the start on and never goes back, so that whoever reads two of them has what was between.

use std::fmt::Write;
use std::time::Duration;

use hdrhistogram::Histogram;
use pottery_shared::room::RoomCounts;

use crate::InputCounts;
use crate::store::StoreCounts;

/// What a server has counted since its start.
#[derive(Clone, Debug)]
pub struct Figures {
    /// Ticks done.
    pub ticks: u64,
    /// People who are in.
    pub people: usize,
    /// Times the room woke up later than it was to by more than nearly a snapshot's period (15 ms): it is to every 1 ms at work, every 12 in quiet.
    pub late: u64,
    /// Time from one wake-up of the room to the end of its work, µs: every due tick with all that is sent after it.
    pub wake_us: Histogram<u64>,
    /// Datagrams handed to connections.
    pub datagrams: u64,
    /// Their bytes, without what UDP, IP and QUIC put round them.
    pub datagram_bytes: u64,
    /// Datagrams that a connection could not take at once.
    pub dropped_datagrams: u64,
    /// People who work at each wheel.
    pub people_at: Vec<usize>,
    /// Connections not taken, since their address knocks too often.
    pub turned_away: u64,
    /// What was too much of what addresses sent.
    pub input: InputCounts,
    /// What the data folder took.
    pub store: StoreCounts,
    /// What the room counted.
    pub counts: RoomCounts,
}

/// Longest work that is told apart, µs; what takes longer counts as this.
const LONGEST_US: u64 = 60_000_000;

impl Default for Figures {
    fn default() -> Self {
        Self {
            ticks: 0,
            people: 0,
            late: 0,
            wake_us: Histogram::new_with_bounds(1, LONGEST_US, 2).expect("these bounds are valid"),
            datagrams: 0,
            datagram_bytes: 0,
            dropped_datagrams: 0,
            people_at: Vec::new(),
            turned_away: 0,
            input: InputCounts::default(),
            store: StoreCounts::default(),
            counts: RoomCounts::default(),
        }
    }
}

impl Figures {
    /// Notes how long a wake-up's work took.
    pub(crate) fn note_wake(&mut self, took: Duration) {
        self.wake_us.saturating_record(took.as_micros().max(1) as u64);
    }

    /// Notes a datagram that is handed to a connection.
    pub(crate) const fn note_datagram(&mut self, bytes: usize) {
        self.datagrams += 1;
        self.datagram_bytes += bytes as u64;
    }

    /// All of it as one line of JSON. `wake_us` is a list of `[µs, wake-ups that took so long]`, to within 1 %.
    ///
    /// ```
    /// let line = pottery_server::Figures::default().to_json_line();
    /// assert!(line.starts_with("{\"ticks\":0,") && line.ends_with("\"wake_us\":[]}"));
    /// ```
    #[must_use]
    pub fn to_json_line(&self) -> String {
        let RoomCounts { joined, refused, repeats, resyncs, refusals, .. } = self.counts;
        let mut line = format!(
            "{{\"ticks\":{},\"people\":{},\"late\":{},\"datagrams\":{},\"datagram_bytes\":{},\"dropped_datagrams\":{},\
             \"joined\":{joined},\"refused\":{refused},\"repeats\":{repeats},\"resyncs\":{resyncs},\
             \"refused_samples\":{},\"unheard\":{},\"held\":{},\"wake_us\":[",
            self.ticks,
            self.people,
            self.late,
            self.datagrams,
            self.datagram_bytes,
            self.dropped_datagrams,
            refusals.total(),
            self.input.unheard,
            self.input.held,
        );
        for (at, bucket) in self.wake_us.iter_recorded().enumerate() {
            let comma = if at == 0 { "" } else { "," };
            write!(line, "{comma}[{},{}]", bucket.value_iterated_to(), bucket.count_at_value())
                .expect("a string takes everything");
        }
        line.push_str("]}");
        line
    }
}
