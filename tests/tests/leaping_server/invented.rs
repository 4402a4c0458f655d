//! Whatever is well formed, said between honest words.
//!
//! The words are drawn at random near the honest ones, or anywhere.
//! Invariant under test: the honest words are taken up again, whatever was said between them.

use std::sync::LazyLock;

use pottery_shared::protocol::{
    self, Body, Fragment, FragmentOf, HandWire, Keyframe, Pulse, PulseHead, ShapeWire, Sight, WheelWire,
};
use pottery_shared::room::PeerId;
use pottery_shared::session::WAITING_BYTES_MAX;
use pottery_tests::allocations::held_bytes;
use proptest::prelude::*;

use super::{LOOKERS, POTTERS, Said, World, hand, tool, wrong_tiles};

/// A number near an honest one, or any.
fn near(honest: u64) -> impl Strategy<Value = u64> {
    prop_oneof![
        4 => (-5_i64..6).prop_map(move |off| honest.saturating_add_signed(off)),
        2 => (-2_000_i64..2_000).prop_map(move |off| honest.saturating_add_signed(off)),
        1 => any::<u64>(),
        1 => prop_oneof![Just(0), Just(u64::MAX), Just(u64::from(u32::MAX)), Just(1 << 48)],
    ]
}

/// What a server may say that is well formed, beside what it says honestly: numbers as far from the honest ones as they may be.
#[derive(Clone, Debug)]
struct Invented {
    at_ms: u64,
    tick: u64,
    latest: u64,
    acknowledged: u64,
    slack: Option<i16>,
    digest: Option<u64>,
    hand_tick: Option<u64>,
    pieces: Vec<(u64, bool, u16, u16, Vec<u8>)>,
    /// A keyframe instead, from that version on.
    keyframe: Option<u64>,
}

const ORIGIN: u64 = 1 << 20;

fn invented() -> impl Strategy<Value = Invented> {
    let pieces = (near(ORIGIN), any::<bool>(), 0..40_u16, 0..1100_u16, proptest::collection::vec(any::<u8>(), 0..60));
    let words = (near(ORIGIN), near(ORIGIN), near(ORIGIN));
    let head = (any::<Option<i16>>(), any::<Option<u64>>(), proptest::option::of(near(ORIGIN)));
    let rest = (proptest::collection::vec(pieces, 0..4), proptest::option::weighted(0.3, near(ORIGIN)));
    (600..1300_u64, words, head, rest).prop_map(|(at_ms, words, head, (pieces, keyframe))| {
        let ((tick, latest, acknowledged), (slack, digest, hand_tick)) = (words, head);
        Invented { at_ms, tick, latest, acknowledged, slack, digest, hand_tick, pieces, keyframe }
    })
}

/// An invented number as it is told beside an honest one.
fn beside(honest: u64, invented: u64) -> u64 {
    if invented.abs_diff(ORIGIN) <= 2_000 {
        honest.saturating_add_signed(invented as i64 - ORIGIN as i64)
    } else {
        invented
    }
}

impl Invented {
    fn tell(&self, world: &mut World, peer: u64, now: u64) {
        let (head, name, honest) = match peer {
            0..POTTERS => {
                let Some(Pulse { head, body }) = world.potters[peer as usize].last.clone() else { return };
                (Some(head), None, body)
            }
            _ => {
                let last = world.lookers[(peer - POTTERS) as usize].last.clone();
                let Some(Sight { name, body, .. }) = last else { return };
                (None, Some(name), body)
            }
        };
        let acknowledged =
            head.as_ref().map_or(0, |head| beside(u64::from(head.acknowledged), self.acknowledged) as u32);
        let (tick, latest) = (beside(honest.tick, self.tick), beside(u64::from(honest.latest), self.latest) as u32);
        if let Some(since) = self.keyframe {
            let since = beside(u64::from(honest.latest), since) as u32;
            let (bytes, goes_on, mended) = (wrong_tiles(), false, 0);
            let keyframe = Keyframe { version: latest, since, tick, acknowledged, sight: name, mended, goes_on, bytes };
            return world.hear(PeerId(peer), Said::Keyframe(protocol::encode(&keyframe)), now);
        }
        let fragment = |(version, is_delta, index, count, bytes): &(u64, bool, u16, u16, Vec<u8>)| Fragment {
            version: beside(u64::from(honest.latest), *version) as u32,
            of: if *is_delta { FragmentOf::Delta } else { FragmentOf::Transcript },
            index: *index,
            count: *count,
            bytes: bytes.clone(),
        };
        let fragments = self.pieces.iter().map(fragment).collect();
        let body = Body { tick, latest, digest: self.digest, tools: Some(vec![tool()]), fragments };
        let lie = match (head, name) {
            (Some(_), _) => {
                let centre = [9000, 0, 9000];
                let shape = ShapeWire::Sphere { radius_um: 12_000 };
                let hand = |tick| HandWire {
                    tick: beside(honest.tick, tick),
                    centre,
                    tool: shape,
                    force_mn: 0,
                    draws: false,
                    inside: false,
                };
                let head = PulseHead { acknowledged, slack: self.slack, teacher: self.hand_tick.map(hand) };
                protocol::encode(&Pulse { head, body })
            }
            (None, Some(name)) => {
                let turning = WheelWire { from: tick, phase: 7, rate: 1 << 20 };
                protocol::encode(&Sight { name, turning: Some(turning), body })
            }
            (None, None) => return,
        };
        world.hear(PeerId(peer), Said::Datagram(lie), now);
    }
}

/// When a world ends in which anything is said, and what it takes then if nothing false was.
const ENDS_MS: u64 = 4500;
static HONEST_BYTES: LazyLock<i64> = LazyLock::new(|| {
    let before = held_bytes();
    let mut world = World::new();
    for now in 0..ENDS_MS {
        world.step(now, |person, now| hand(person, now, 1300));
    }
    held_bytes() - before
});

proptest! {
    #![proptest_config(ProptestConfig { cases: 16, failure_persistence: None, ..ProptestConfig::default() })]

    /// Whatever is said between honest words, the honest ones are taken up again.
    #[test]
    fn whatever_a_server_says_between_honest_words_its_clay_is_held_again(
        peer in 0..POTTERS + LOOKERS.len() as u64,
        mut lies in proptest::collection::vec(invented(), 1..25),
    ) {
        lies.sort_by_key(|lie| lie.at_ms);
        // before the world, since it is measured by another
        let honest_bytes = *HONEST_BYTES;
        let before = held_bytes();
        let mut world = World::new();
        let mut next = lies.iter().peekable();
        for now in 0..ENDS_MS {
            world.step(now, |person, now| hand(person, now, 1300));
            while let Some(lie) = next.next_if(|lie| lie.at_ms == now) {
                lie.tell(&mut world, peer, now);
            }
        }
        world.assert_same("invented");
        let more = held_bytes() - before - honest_bytes;
        prop_assert!(more < WAITING_BYTES_MAX as i64, "{} B more", more);
        for other in (0..5).filter(|other| *other != peer) {
            prop_assert_eq!(world.unsound(other), 0, "{} noticed what {} was told", other, peer);
        }
    }
}

/// Clay that was made wrong three times, the third time as the server's clock leaps: no fault of the one who looks on, who takes deltas from then on.
#[test]
fn who_presses_again_on_wrong_clay_thrice_takes_deltas_of_the_same_clay() {
    let lie = |at_ms, tick, since| Invented {
        at_ms,
        tick,
        latest: ORIGIN,
        acknowledged: ORIGIN,
        slack: None,
        digest: None,
        hand_tick: None,
        pieces: Vec::new(),
        keyframe: Some(since),
    };
    let lies = [lie(600, ORIGIN, ORIGIN), lie(619, ORIGIN + 1, ORIGIN - 1), lie(919, u64::from(u32::MAX), ORIGIN)];
    let mut world = World::new();
    for now in 0..ENDS_MS {
        world.step(now, |person, now| hand(person, now, 1300));
        lies.iter().filter(|lie| lie.at_ms == now).for_each(|lie| lie.tell(&mut world, POTTERS, now));
    }
    assert!(!world.lookers[0].watcher.as_ref().unwrap().keeps_up());
    world.assert_same("wrong thrice");
}
