//! A room with light hands at its wheels in virtual time, on a line that loses nothing and takes no time.
//!
//! Owns the room and its people; how much time passes, and who does the wheels, is the caller's.
//! Invariant: nothing waits, and everything repeats from its seed.

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use pottery_client::stroke::{Stroke, StrokeError};
use pottery_shared::clay::{Material, MethodKind, PotSpec};
use pottery_shared::protocol::{self, CONTROL_MAX, DATAGRAM_MEMORY_MAX, FrameReader, KEYFRAME_MAX, Notice, Pulse};
use pottery_shared::room::{Crew, Lane, PeerId, Room, RoomConfig, Transmit};
use pottery_shared::session::Client;
use pottery_shared::units::{Rpm, Tick};

use super::follower::{Follower, Ledger};
use super::hand::{Hand, Path as HandPath};
use super::plan::Plan;

/// The potters of a plan at the wheels of one room.
pub struct VirtualRoom {
    room: Room,
    seats: Vec<Seat>,
    ledger: Ledger,
    burst_s: Option<f64>,
}

/// Somebody at a wheel in virtual time.
struct Seat {
    hand: Hand,
    path: HandPath,
    follower: Follower,
}

impl VirtualRoom {
    /// Opens it and lets in everybody.
    ///
    /// # Errors
    /// [`StrokeError`] when a stroke cannot be read.
    ///
    /// # Panics
    /// When a room does not let in whom it should.
    pub fn open(plan: &Plan) -> Result<Self, StrokeError> {
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
        Ok(Self { room, seats, ledger, burst_s: plan.burst_s })
    }

    /// Lets a millisecond pass, whose wheels `crew` does; `sees` is shown all that is sent, in its order. Says how long the room's
    /// own part took.
    pub fn pass(&mut self, millisecond: u64, crew: &impl Crew, mut sees: impl FnMut(&Transmit)) -> Duration {
        let now = Duration::from_millis(millisecond);
        for (number, seat) in (0..).zip(&mut self.seats) {
            seat.work(&mut self.room, PeerId(number), millisecond, now, self.burst_s);
        }
        let begun = Instant::now();
        self.room.advance_by(Tick(millisecond), crew);
        let took = begun.elapsed();
        while let Some(transmit) = self.room.poll_transmit() {
            sees(&transmit);
            self.seats[transmit.to.0 as usize].hear(transmit.lane, now, &self.ledger);
        }
        took
    }

    /// Snapshots that all hold together.
    #[must_use]
    pub fn snapshots(&self) -> u64 {
        self.seats.iter().map(|seat| u64::from(seat.follower.held())).sum()
    }

    /// Whether everybody holds the newest.
    #[must_use]
    pub fn is_current(&self) -> bool {
        self.seats.iter().all(|seat| seat.follower.is_current())
    }

    /// Samples that the room has refused.
    #[must_use]
    pub fn refused(&self) -> u64 {
        self.room.counts().refusals.total()
    }

    /// Digest of every wheel's newest snapshot.
    #[must_use]
    pub fn digests(&self) -> Vec<u64> {
        (0..self.room.wheels()).filter_map(|wheel| self.room.digest(wheel)).collect()
    }
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
