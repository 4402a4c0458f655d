//! A run that goes on: whether memory grows and ticks come late, in real time or in time that costs nothing.
//!
//! Owns the line through memory over time, and a room in virtual time; a run in real time is `run`'s.
//! Invariant: in virtual time nothing waits and everything repeats from its seed.

use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use pottery_client::stroke::{Stroke, StrokeError};
use pottery_shared::clay::{Material, MethodKind, PotSpec};
use pottery_shared::protocol::{self, CONTROL_MAX, DATAGRAM_MEMORY_MAX, FrameReader, KEYFRAME_MAX, Notice, Pulse};
use pottery_shared::room::{Lane, PeerId, Room, RoomConfig, Transmit};
use pottery_shared::session::Client;
use pottery_shared::units::{Rpm, Tick};
use serde::Serialize;

use super::follower::{Follower, Ledger};
use super::hand::{Hand, Path as HandPath};
use super::host;
use super::plan::Plan;
use super::result::RunResult;

/// A straight line through memory over time.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Slope {
    /// MB an hour.
    pub mb_per_h: f64,
    /// Its standard error, MB an hour.
    pub error_mb_per_h: f64,
    /// From the first point to the last, h.
    pub hours: f64,
}

impl Slope {
    /// Through `(s, MB)`, by least squares.
    #[must_use]
    pub fn through(points: &[(f64, f64)]) -> Self {
        let count = points.len() as f64;
        let (Some(first), Some(last)) = (points.first(), points.last()) else { return Self::default() };
        let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
        let (mean_x, mean_y) = (mean(|point| point.0), mean(|point| point.1));
        let spread: f64 = points.iter().map(|(x, _)| (x - mean_x).powi(2)).sum();
        if spread == 0.0 || points.len() < 3 {
            return Self::default();
        }
        let slope = points.iter().map(|(x, y)| (x - mean_x) * (y - mean_y)).sum::<f64>() / spread;
        let rest: f64 = points.iter().map(|(x, y)| (y - mean_y - slope * (x - mean_x)).powi(2)).sum();
        let error = (rest / (count - 2.0) / spread).sqrt();
        let hours = (last.0 - first.0) / 3600.0;
        Self { mb_per_h: slope * 3600.0, error_mb_per_h: error * 3600.0, hours }
    }

    /// What it grew by beyond twice the line's own error, MB.
    #[must_use]
    pub fn growth_mb(&self) -> f64 {
        ((self.mb_per_h - 2.0 * self.error_mb_per_h) * self.hours).max(0.0)
    }
}

/// Of the server's memory in the measured part of a run, without its first fifth, in which clay is worked for the first time.
#[must_use]
pub fn of_run(result: &RunResult) -> Slope {
    let measured = result.seconds.iter().filter(|second| second.is_measured);
    let points: Vec<_> = measured.filter_map(|second| Some((second.at_s, second.server_memory_mb?))).collect();
    Slope::through(&points[points.len() / 5..])
}

/// What came of a soak in virtual time.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Virtual {
    /// Time that passed in the room, s.
    pub passed_s: f64,
    /// Time that it took, s.
    pub took_s: f64,
    /// Memory of this process.
    pub memory: Slope,
    /// Snapshots that potters held in the end.
    pub snapshots: u64,
    /// Whether everybody held the newest.
    pub is_current: bool,
    /// Samples refused.
    pub refused: u64,
}

/// Somebody at a wheel in virtual time.
struct Seat {
    hand: Hand,
    path: HandPath,
    follower: Follower,
}

/// Goes through so many seconds of a plan's potters in virtual time, at wheels of one room, on a line that loses nothing.
///
/// # Errors
/// [`StrokeError`] when a stroke cannot be read.
///
/// # Panics
/// When a room does not let in whom it should.
pub fn in_virtual_time(plan: &Plan, seconds: u64) -> Result<Virtual, StrokeError> {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("data/strokes/waist.csv");
    let stroke = Arc::new(Stroke::read(file)?);
    let mut room = Room::new(RoomConfig {
        code: "SOAK".into(),
        wheels: plan.wheels,
        people_max: 512,
        pot: PotSpec::default(),
        method: MethodKind::default(),
        wheel_speed: Rpm(60.0),
        clay: Material::default(),
    })
    .expect("the paper's pot can be made");
    let mut unheard = Vec::new();
    let mut seats: Vec<_> =
        (0..plan.potters).map(|number| seat(&mut room, plan, number, &stroke, &mut unheard)).collect();
    let ledger = Ledger::default();
    for Transmit { to, lane } in unheard {
        seats[to.0 as usize].hear(lane, Duration::ZERO, &ledger);
    }
    let begun = std::time::Instant::now();
    let mut memory = Vec::new();
    for millisecond in 1..=seconds * 1000 {
        let now = Duration::from_millis(millisecond);
        for (number, seat) in (0..).zip(&mut seats) {
            seat.work(&mut room, PeerId(number), millisecond, now, plan.burst_s);
        }
        room.advance(Tick(millisecond));
        while let Some(transmit) = room.poll_transmit() {
            seats[transmit.to.0 as usize].hear(transmit.lane, now, &ledger);
        }
        // the first fifth works the clay for the first time
        let is_late_enough = millisecond > seconds * 200;
        if is_late_enough && millisecond.is_multiple_of((seconds * 10).max(1)) {
            memory.extend(host::usage(std::process::id()).map(|usage| (now.as_secs_f64(), usage.memory_mb)));
        }
    }
    Ok(Virtual {
        passed_s: seconds as f64,
        took_s: begun.elapsed().as_secs_f64(),
        memory: Slope::through(&memory),
        snapshots: seats.iter().map(|seat| u64::from(seat.follower.held())).sum(),
        is_current: seats.iter().all(|seat| seat.follower.is_current()),
        refused: room.counts().refusals.total(),
    })
}

/// Somebody who is let in; what the room says beside that goes to `unheard`.
fn seat(room: &mut Room, plan: &Plan, number: u32, stroke: &Arc<Stroke>, unheard: &mut Vec<Transmit>) -> Seat {
    let wheel = (number % u32::from(plan.used())) as u16 + 1;
    let peer = PeerId(u64::from(number));
    room.handle_control(peer, &bare(&Client::greeting("SOAK", wheel, true)));
    let welcome = loop {
        let transmit = room.poll_transmit().expect("a room lets in whom it expects");
        if transmit.to == peer
            && let Lane::Control(frame) = &transmit.lane
            && let Ok(Notice::Welcome(welcome)) = protocol::decode::<CONTROL_MAX, Notice>(&bare(frame))
        {
            break welcome;
        }
        unheard.push(transmit);
    };
    Seat {
        hand: Hand::new(0, Tick(welcome.now), Duration::ZERO),
        path: HandPath::new(Arc::clone(stroke), plan.seed + u64::from(number)),
        follower: Follower::new((wheel, None), Duration::ZERO, Duration::ZERO),
    }
}

impl Seat {
    fn work(&mut self, room: &mut Room, peer: PeerId, millisecond: u64, now: Duration, burst_s: Option<f64>) {
        let works = burst_s.is_none_or(|burst_s| ((now.as_secs_f64() / burst_s) as u64).is_multiple_of(2));
        if works && let Some(sample) = self.path.sample(millisecond, self.hand.tick(millisecond)) {
            self.hand.take(sample);
        }
        if millisecond.is_multiple_of(10) {
            while let Some(bytes) = self.hand.poll_datagram(now) {
                room.handle_datagram(peer, &bytes);
            }
            if let Some(request) = self.follower.poll_request(now) {
                room.handle_control(peer, &protocol::encode(&request));
            }
        }
    }

    fn hear(&mut self, lane: Lane, now: Duration, ledger: &Ledger) {
        let whole = match lane {
            Lane::Datagram(bytes) => {
                let pulse: Pulse =
                    protocol::decode::<DATAGRAM_MEMORY_MAX, _>(&bytes).expect("a room sends what can be read");
                if let Some(slack) = pulse.head.slack {
                    self.hand.handle_slack(slack, pulse.head.acknowledged, now);
                }
                self.follower.handle(pulse.body, pulse.head.acknowledged, ledger)
            }
            Lane::Keyframe(bytes) => {
                let keyframe = protocol::decode::<KEYFRAME_MAX, _>(&bytes).expect("a room sends what can be read");
                self.follower.handle_keyframe(&keyframe, ledger)
            }
            Lane::Control(_) | Lane::Close => None,
        };
        if let Some(whole) = whole {
            self.hand.confirm(whole.acknowledged, now, |_| {});
        }
    }
}

/// What a frame holds.
fn bare(framed: &[u8]) -> Vec<u8> {
    let mut reader = FrameReader::default();
    reader.push(framed);
    reader.next_frame().ok().flatten().expect("a whole frame was made")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn line_through_points_has_their_slope_and_no_error() {
        let points: Vec<_> = (0..10).map(|second| (f64::from(second) * 360.0, 5.0 + f64::from(second))).collect();
        let slope = Slope::through(&points);
        assert!((slope.mb_per_h - 10.0).abs() < 1e-9 && slope.error_mb_per_h < 1e-9, "{slope:?}");
        assert!((slope.growth_mb() - 9.0).abs() < 1e-9);
    }

    #[test]
    fn memory_that_only_shakes_does_not_grow() {
        let points: Vec<_> = (0..100).map(|second| (f64::from(second), f64::from(second % 2))).collect();
        assert!(Slope::through(&points).growth_mb() < 0.1, "{:?}", Slope::through(&points));
    }
}
