//! The hand's thread as it runs: its rhythm, what it may not do between two ticks, and what the system grants it.

#![expect(clippy::unwrap_used, reason = "a test fails by panicking")]

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::boundary::boundary;
use pottery_client::device::Device;
use pottery_client::{Claim, Core, Granted, HapticLoop, LoopRate, Pacing, Priority};
use pottery_shared::clay::{Conditions, Pot, PotSpec};
use pottery_shared::haptics::DeviceSpecs;
use pottery_shared::prediction::{Field, Patch};
use pottery_shared::tool::{Tool, rack};
use pottery_shared::units::Tick;
use pottery_tests::allocations::{Counting, requests_so_far};
use proptest::prelude::*;

#[global_allocator]
static ALLOCATOR: Counting = Counting;

proptest! {
    #[test]
    fn a_missed_deadline_is_counted_and_never_made_up_for(
        begin_us in 0_u64..10_000,
        // how much too late the thread wakes up, and how long its work takes; most of the time neither is much
        stalls_us in prop::collection::vec((prop_oneof![0_u64..900, 0_u64..40_000], prop_oneof![0_u64..90, 0_u64..40_000]), 1..300),
        thousands in 1_u64..=10,
    ) {
        let rate: LoopRate = (thousands * 1000).to_string().parse().unwrap();
        let mut now = Duration::from_micros(begin_us);
        let mut pacing = Pacing::after(now, rate);
        let (first, mut done) = (pacing.turn(), 0);
        for (late_us, work_us) in stalls_us {
            let (late, work) = (Duration::from_micros(late_us), Duration::from_micros(work_us));
            let (turn, missed) = (pacing.turn(), pacing.missed());
            // there is always a deadline ahead to wait for, the next one: two turns never follow without a wait
            prop_assert!(pacing.deadline() > now && pacing.deadline() <= now + rate.period() + Duration::from_nanos(1));
            prop_assert_eq!(pacing.is_tick(), turn % thousands == 0);
            done += u64::from(pacing.is_tick());
            now = pacing.deadline() + late;
            prop_assert_eq!(pacing.lateness(now), late);
            now += work;
            pacing.done(now);
            prop_assert!(pacing.turn() > turn);
            if late + work + Duration::from_nanos(1) < rate.period() {
                prop_assert_eq!((pacing.turn(), pacing.missed()), (turn + 1, missed));
            }
            // the deadline of every tick was either kept or missed
            let ticks = (pacing.turn() - 1) / thousands - (first - 1) / thousands;
            prop_assert_eq!(done + pacing.missed(), ticks);
        }
    }
}

/// Ticks at which the device below looks round: what comes before is the thread's beginning.
const FIRST_LOOK: u64 = 20;
const LAST_LOOK: u64 = 420;

/// What a device saw of the thread that asks it.
#[derive(Debug, Default)]
struct Seen {
    asked: AtomicU64,
    /// Requests to the allocator between the two looks.
    requests: AtomicU64,
    /// Times that the thread gave up its core by itself between the two looks.
    waits: AtomicU64,
}

/// A device that presses, and looks round in the thread that asks it.
struct Witness(Arc<Seen>);

impl Device for Witness {
    fn position(&mut self, seconds: f64) -> Option<Vec3> {
        let asked = self.0.asked.fetch_add(1, Ordering::Relaxed);
        if asked == FIRST_LOOK {
            self.0.waits.store(waits_so_far(), Ordering::Relaxed);
            self.0.requests.store(requests_so_far(), Ordering::Relaxed);
        } else if asked == LAST_LOOK {
            let requests = requests_so_far() - self.0.requests.load(Ordering::Relaxed);
            self.0.requests.store(requests, Ordering::Relaxed);
            let waits = waits_so_far() - self.0.waits.load(Ordering::Relaxed);
            self.0.waits.store(waits, Ordering::Relaxed);
        }
        Some(Vec3::new(0.069, 0.0, 0.1 + 0.03 * (seconds * 2.0).sin() as f32))
    }

    fn tool(&self) -> Tool {
        Tool::default()
    }

    fn set_force(&mut self, _: Vec3) {}

    fn specs(&self) -> DeviceSpecs {
        DeviceSpecs::OMNI
    }
}

/// How often this thread gave up its core by itself so far; zero where the system does not say.
fn waits_so_far() -> u64 {
    own_status("voluntary_ctxt_switches:").map_or(0, |count| count.parse().unwrap())
}

/// A line of what the system knows of this thread.
fn own_status(name: &str) -> Option<String> {
    let status = std::fs::read_to_string("/proc/thread-self/status").ok()?;
    status.lines().find_map(|line| line.strip_prefix(name)).map(|value| value.trim().to_owned())
}

#[test]
fn between_two_ticks_the_thread_sleeps_once_and_allocates_nothing() {
    let field = Field::new(Pot::new(PotSpec::default()).unwrap(), Tick(0));
    let (side, mut net) = boundary(&Patch { field, conditions: Conditions::default(), rack: rack::standard() });
    let seen = Arc::new(Seen::default());
    let witness = Box::new(Witness(Arc::clone(&seen)));
    let hand = std::thread::spawn(move || HapticLoop::new(witness, side).run(Instant::now()));
    let (mut sent, mut published) = (0, 0);
    while seen.asked.load(Ordering::Relaxed) <= LAST_LOOK {
        while let Some(sample) = net.next_sample() {
            sent += 1;
            // clay comes in meanwhile, as from a server
            if sent % 40 == 0 {
                let field = Field::new(Pot::new(PotSpec::default()).unwrap(), sample.tick);
                net.publish(|patch| patch.field = field);
                published += 1;
            }
        }
        std::thread::sleep(Duration::from_millis(1));
    }
    drop(net);
    let report = hand.join().unwrap();
    assert!(report.ticks > LAST_LOOK && published > 3, "{} ticks, {published} patches", report.ticks);
    assert_eq!(seen.requests.load(Ordering::Relaxed), 0, "requests to the allocator");
    // a tick without a wait left, after a stall, gives up nothing
    assert!(seen.waits.load(Ordering::Relaxed) <= LAST_LOOK - FIRST_LOOK, "{seen:?}");
}

/// What a thread of its own gets, with its scheduling class and cores as the system has them.
fn stake(claim: Claim) -> (Granted, Option<u64>, Option<String>) {
    std::thread::spawn(move || {
        let granted = claim.stake();
        let fields = std::fs::read_to_string("/proc/thread-self/stat").ok();
        // the 41st field, counted behind the name in brackets, which is the second
        let class = fields.and_then(|fields| fields.rsplit_once(')')?.1.split_whitespace().nth(38)?.parse().ok());
        (granted, class, own_status("Cpus_allowed_list:"))
    })
    .join()
    .unwrap()
}

#[test]
fn who_claims_nothing_stays_as_the_others() {
    let (granted, class, _) = stake(Claim::default());
    assert_eq!(granted, Granted { priority: Priority::Ordinary, core: None, rate: LoopRate::default() });
    assert!(class.is_none_or(|class| class == 0), "{class:?}");
}

#[test]
fn priority_is_granted_or_refused_in_a_sentence() {
    let (granted, class, _) = stake(Claim { is_raised: true, ..Claim::default() });
    match &granted.priority {
        // SCHED_FIFO is 1
        Priority::RealTime => assert!(class.is_none_or(|class| class == 1), "{class:?}"),
        Priority::Refused { reason } => assert!(!reason.is_empty() && class.is_none_or(|class| class == 0)),
        Priority::Ordinary => panic!("it was claimed"),
    }
    let refused = Priority::Refused { reason: "Operation not permitted".into() };
    assert!(refused.to_string().contains("refuses real time (Operation not permitted)"), "{refused}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_thread_stays_on_the_core_it_is_put_on() {
    let allowed = own_status("Cpus_allowed_list:").unwrap();
    let first = allowed.split(['-', ',']).next().unwrap();
    let core: Core = first.parse().unwrap();
    let (granted, _, cores) = stake(Claim { core: Some(core), ..Claim::default() });
    assert_eq!((granted.core, cores.as_deref()), (Some(core), Some(first)));
    assert!(granted.to_string().ends_with(&format!("on core {first}")), "{granted}");
}

#[cfg(target_os = "linux")]
#[test]
fn a_core_that_is_not_there_is_refused_with_those_that_are() {
    let error = "100000".parse::<Core>().unwrap_err().to_string();
    let allowed = own_status("Cpus_allowed_list:").unwrap();
    let first = allowed.split(['-', ',']).next().unwrap();
    assert!(error.contains("core 100000") && error.contains(&format!("choose one of {first}")), "{error}");
    for text in ["-1", "two", "", "1.5"] {
        assert!(text.parse::<Core>().unwrap_err().to_string().contains("counted from 0"), "{text}");
    }
}
