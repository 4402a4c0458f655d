//! What a network does to a pot that several people press: when all hold the same clay again, and whether anything was lost.
//!
//! Owns the lines and who presses over them; sessions are played by [`super::online`].
//! Invariant: a line's rows say how much of what they allow is the network's own, and why.

use std::f64::consts::TAU;
use std::sync::OnceLock;

use glam::Vec3;
use pottery_shared::clay::MethodKind;
use pottery_shared::snapshot::SnapshotClock;

use super::bench::Scene;
use super::mechanism::Grip;
use super::online::{Held, Holder, Session, hold};
use crate::failures::{METHODS, larger};
use crate::line::{BurstLoss, Quality};
use crate::simulation::{BURSTS, ms};

/// Every packet twice, and most of them overtaken.
const TANGLED: Quality =
    Quality { jitter: ms(60), duplicates: 1.0, loss: BurstLoss::NONE, rate: None, ..Quality::HOME };
/// Of the lines' dice.
const SEEDS: [u64; 2] = [1, 2];

/// A line with people on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Over {
    Lan,
    SchoolWifi,
    Home,
    Intercontinental,
    Awful,
    Bursts,
    Tangled,
    /// Of somebody who comes while two press.
    LateJoin,
}

impl Over {
    const ALL: [Self; 8] = [
        Self::Lan,
        Self::SchoolWifi,
        Self::Home,
        Self::Intercontinental,
        Self::Awful,
        Self::Bursts,
        Self::Tangled,
        Self::LateJoin,
    ];

    const fn quality(self) -> Quality {
        match self {
            Self::Lan => Quality::LAN,
            Self::SchoolWifi => Quality::SCHOOL_WIFI,
            Self::Home | Self::LateJoin => Quality::HOME,
            Self::Intercontinental => Quality::INTERCONTINENTAL,
            Self::Awful => Quality::AWFUL,
            Self::Bursts => BURSTS,
            Self::Tangled => TANGLED,
        }
    }

    /// Mean time there and back.
    fn round_trip_s(self) -> f64 {
        let Quality { latency, jitter, .. } = self.quality();
        (latency * 2 + jitter).as_secs_f64()
    }
}

/// What came of a line with all its dice.
#[derive(Clone, Copy, Debug)]
struct Played {
    /// Time from the last sample of a hand, and from its press in the room, until all held the same clay, s; infinite when they never did.
    hand_s: f64,
    room_s: f64,
    lost: u64,
}

/// Every line with a method, played once.
fn played(method: MethodKind) -> &'static [Played] {
    static PLAYED: [OnceLock<Vec<Played>>; METHODS.len()] = [const { OnceLock::new() }; METHODS.len()];
    let row = METHODS.iter().position(|(known, _)| *known == method).unwrap_or_default();
    PLAYED[row].get_or_init(|| Over::ALL.map(|over| play(method, over)).into())
}

fn play(method: MethodKind, over: Over) -> Played {
    let joins_s = (over == Over::LateJoin).then_some(1);
    let mut worst = Played { hand_s: 0.0, room_s: 0.0, lost: 0 };
    for held in SEEDS.map(|seed| press(method, over.quality(), seed, joins_s)) {
        let [hand_s, room_s] = held.settled.map_or([f64::INFINITY; 2], |passed| passed.map(|time| time.as_secs_f64()));
        worst.hand_s = worst.hand_s.max(hand_s);
        worst.room_s = worst.room_s.max(room_s);
        worst.lost += held.lost;
    }
    worst
}

fn of(method: MethodKind, over: Over) -> Played {
    played(method)[over as usize]
}

/// Time from the last press in the room until all hold the same clay, ms.
pub(super) fn quiet_ms(method: MethodKind, over: Over) -> f64 {
    of(method, over).room_s * 1e3
}

/// The same beyond the room's own beat, in round trips.
pub(super) fn quiet_round_trips(method: MethodKind, over: Over) -> f64 {
    let beat_s = 1.0 / SnapshotClock::PER_SECOND as f64;
    (of(method, over).room_s - beat_s).max(0.0) / over.round_trip_s()
}

/// The same from the hand's last sample on, where a round trip is long and no more than a packet in twenty is lost: most of them.
pub(super) fn round_trips_of_the_hand(method: MethodKind) -> f64 {
    let long = [Over::Intercontinental, Over::Bursts];
    long.map(|over| of(method, over).hand_s / over.round_trip_s()).into_iter().fold(0.0, larger)
}

/// Samples that were made and not pressed, on all lines.
pub(super) fn lost(method: MethodKind) -> f64 {
    played(method).iter().map(|played| played.lost).sum::<u64>() as f64
}

/// Two hands press along a pot that turns, for two seconds, and meet; a third comes later where it is said when, s.
fn press(method: MethodKind, line: Quality, seed: u64, joins_s: Option<u16>) -> Held {
    let scene = Scene { rpm: 60.0, ..Scene::of(method) };
    let holder = |number: u8, grip: Grip| {
        Holder::new(grip, move |seconds| {
            let angle = f64::from(number) * 2.2;
            let depth_m = 2.5 / grip.stiffness_n_m;
            let distance_m = 0.074 - (depth_m + 2e-3) * (TAU * 0.4 * seconds).sin().abs();
            let height_m = 0.1 + 0.03 * (seconds + f64::from(number)).sin();
            Vec3::new((distance_m * angle.cos()) as f32, (distance_m * angle.sin()) as f32, height_m as f32)
        })
    };
    let mut holders = vec![holder(0, Grip::STANDARD), holder(1, Grip::FIRM)];
    holders.extend(joins_s.map(|from_s| Holder { from_s, ..holder(2, Grip::LIGHT) }));
    hold(&Session { scene, line, seed, seconds: 2 }, &holders)
}
