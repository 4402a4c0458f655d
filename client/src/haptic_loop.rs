//! One tick of the hand, and the real-time thread that makes 1000 of them a second.
//!
//! The tick takes no lock, allocates nothing and never panics; deadlines are absolute, a missed one is counted and never
//! made up for. Knows no network: clay comes and samples go over the boundary.
//! Invariant: on any fault the force is zero within the tick.

use std::time::{Duration, Instant};

use glam::Vec3;
use hdrhistogram::Histogram;
use pottery_shared::clay::{Contact, MethodKind};
use pottery_shared::haptics::{Haptics, Touch, Wet};
use pottery_shared::prediction::Hand;
use pottery_shared::tool::{Position, Tool, ToolSample};
use pottery_shared::units::{Seconds, Tick};

use crate::boundary::HandSide;
use crate::device::Device;

/// Length of a tick.
const PERIOD: Duration = Duration::from_millis(1);
/// Part of the wait that is spun, since sleep wakes up late by about this much: by its timer slack of 50 µs and the
/// scheduler's own time, or by the latter alone where the slack can be had away.
const SPIN: Duration = Duration::from_micros(if cfg!(target_os = "linux") { 60 } else { 120 });
/// A tick that begins later than this after its deadline is late.
const LATE: Duration = Duration::from_micros(200);
/// Own samples replayed on a patch in one tick, besides the tick's own.
const CATCH_UP_BUDGET: usize = 4;

/// Everything one hand needs in its thread.
pub struct HapticLoop {
    device: Box<dyn Device>,
    hand: Hand,
    haptics: Haptics,
    side: HandSide,
    catching_up: bool,
    last_stamp: Option<Tick>,
    last_local: u64,
    felt: Felt,
    force_mn: Histogram<u64>,
}

impl std::fmt::Debug for HapticLoop {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("HapticLoop").field("side", &self.side).finish_non_exhaustive()
    }
}

/// What the hand feels in a tick.
#[derive(Clone, Copy, Debug, Default)]
struct Felt {
    force_n: Vec3,
    elements: u32,
}

/// What the thread measured.
#[derive(Clone, Debug)]
pub struct HapticReport {
    /// Ticks done.
    pub ticks: u64,
    /// Ticks that began more than 200 µs after their deadline.
    pub late_ticks: u64,
    /// Deadlines passed over since a tick began more than a period late.
    pub missed_ticks: u64,
    /// Samples lost because the ring was full.
    pub lost_samples: u64,
    /// Time from one tick's begin to the next one's, ns.
    pub period_ns: Histogram<u64>,
    /// Time a tick took, ns.
    pub step_ns: Histogram<u64>,
    /// Force on the hand while it touched clay, mN.
    pub force_mn: Histogram<u64>,
}

fn histogram(highest: u64) -> Histogram<u64> {
    Histogram::new_with_bounds(1, highest, 3).expect("three digits over this range are valid bounds")
}

impl HapticLoop {
    /// A hand with `device` on its side of the boundary.
    #[must_use]
    pub fn new(device: Box<dyn Device>, mut side: HandSide) -> Self {
        let hand = Hand::new(side.patches.read().clone());
        let haptics = Haptics::new(device.setup(hand.method().felt_share()));
        Self {
            device,
            hand,
            haptics,
            side,
            catching_up: false,
            last_stamp: None,
            last_local: 0,
            felt: Felt::default(),
            force_mn: histogram(1_000_000),
        }
    }

    /// The hand and its clay.
    #[must_use]
    pub const fn hand(&self) -> &Hand {
        &self.hand
    }

    /// Does the tick of local number `local`: sample, follow, press, force, send; then a few steps towards the newest patch.
    pub fn tick(&mut self, local: u64) {
        let dt = Seconds(local.saturating_sub(self.last_local).max(1) as f32 * Tick::PERIOD.0);
        self.last_local = local;
        let reported = self.device.position(local as f64 * 1e-3).filter(|_| !self.side.status.is_lifted());
        // a tool that is still on its way to this hand is not in it
        let tool = self.device.tool();
        let reported = reported.filter(|_| self.hand.holds(tool));
        let stamp = Tick(0).offset(local as i64 + self.side.status.tick_offset());
        match self.haptics.accept(reported, self.device.velocity(), dt) {
            Some(centre) if self.last_stamp.is_none_or(|last| stamp > last) => {
                self.last_stamp = Some(stamp);
                self.felt = self.press(stamp, tool, centre);
            }
            // the lead went back by a tick: what was felt then is felt on
            Some(_) => {}
            None => {
                self.hand.put_down();
                self.felt = Felt::default();
            }
        }
        self.device.set_force(self.felt.force_n);
        self.side.status.note_tool(self.haptics.tool_m().or(reported));
        let newtons = self.felt.force_n.length();
        if self.felt.elements > 0 {
            self.force_mn.saturating_record((newtons * 1e3) as u64);
        }
        self.side.status.note_tick(newtons, self.felt.elements, self.haptics.fault());
        self.catch_up();
    }

    /// Sends a sample on its way and presses it; one that cannot be sent is not pressed either.
    fn press(&mut self, tick: Tick, tool: Tool, centre: Position) -> Felt {
        let side = self.hand.side(tick, tool, centre);
        let has_proxy = self.haptics.stages().proxy;
        let centre = if has_proxy { self.hand.stopped_at_clay(tick, tool, side, centre) } else { centre };
        let sample = ToolSample { tick, tool, orientation: self.device.orientation(), centre, side };
        if self.side.samples.push(sample).is_err() {
            self.side.status.note_lost_sample();
            self.haptics.rest();
            return Felt::default();
        }
        let Contact { force_n, elements, penetration_m, .. } = self.hand.press(&sample);
        let wet = (self.hand.method() == MethodKind::Plastic).then(|| {
            let (clay_velocity_m_s, element_m2, material) = self.hand.ground(&sample);
            Wet { clay_velocity_m_s, area_m2: element_m2 * elements as f32, material }
        });
        let force_n = self.haptics.render(&Touch { centre, force_n, penetration_m, wet });
        Felt { force_n, elements }
    }

    fn catch_up(&mut self) {
        if !self.catching_up {
            self.catching_up = self.side.patches.update();
        }
        if self.catching_up && self.hand.catch_up(self.side.patches.output_buffer_mut(), CATCH_UP_BUDGET) {
            self.catching_up = false;
            if self.hand.is_corrected_since(self.side.patches.output_buffer_mut()) {
                self.haptics.clay_corrected();
            }
        }
    }

    /// Ticks until the network's side is gone; local tick n is due n milliseconds after `epoch`.
    #[must_use]
    pub fn run(mut self, epoch: Instant) -> HapticReport {
        let mut period_ns = histogram(1_000_000_000);
        let mut step_ns = histogram(1_000_000_000);
        let mut missed_ticks = 0;
        let mut previous: Option<Instant> = None;
        sharpen_timers();
        let mut local = ticks_since(epoch) + 1;
        while !self.side.samples.is_abandoned() {
            let deadline = epoch + PERIOD * u32::try_from(local).unwrap_or(u32::MAX);
            wait_until(deadline);
            let begin = Instant::now();
            if begin.saturating_duration_since(deadline) > LATE {
                self.side.status.note_late();
            }
            if let Some(previous) = previous.replace(begin) {
                period_ns.saturating_record(begin.saturating_duration_since(previous).as_nanos() as u64);
            }
            self.tick(local);
            step_ns.saturating_record(begin.elapsed().as_nanos() as u64);
            let due = ticks_since(epoch);
            missed_ticks += due.saturating_sub(local);
            local = due.max(local) + 1;
        }
        self.device.close();
        HapticReport {
            ticks: self.side.status.ticks(),
            late_ticks: self.side.status.late_ticks(),
            missed_ticks,
            lost_samples: self.side.status.lost_samples(),
            period_ns,
            step_ns,
            force_mn: self.force_mn,
        }
    }
}

/// Has this thread woken up when it asks to be, and not up to 50 µs later together with others.
fn sharpen_timers() {
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::thread::set_current_timer_slack(std::num::NonZeroU64::new(1)) {
        tracing::debug!(%error, "the timer slack stays as it is");
    }
}

/// Whole local ticks that have passed.
pub(crate) fn ticks_since(epoch: Instant) -> u64 {
    epoch.elapsed().as_millis() as u64
}

/// Sleeps for most of the wait and spins for the rest.
fn wait_until(deadline: Instant) {
    let left = deadline.saturating_duration_since(Instant::now());
    if left > SPIN {
        std::thread::sleep(left - SPIN);
    }
    while Instant::now() < deadline {
        std::hint::spin_loop();
    }
}
