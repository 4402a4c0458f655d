//! A hand with a driven device at a pot, ticked by a test: what a studio has, without network and window.
//!
//! Invariant: whatever is waited for comes within [`PATIENCE`] or the test fails with what it waited for.

use std::sync::Arc;
use std::time::{Duration, Instant};

use glam::Vec3;
use pottery_client::HapticLoop;
use pottery_client::boundary::{NetSide, boundary};
use pottery_client::device::{Calibration, DrivenDevice, Driver, Limits, Monitor, PointerDevice, pointer};
use pottery_shared::clay::{Conditions, Pot, PotSpec};
use pottery_shared::haptics::Fault;
use pottery_shared::prediction::{Field, Patch};
use pottery_shared::tool::rack;
use pottery_shared::units::Tick;

/// Far more than anything takes, even on a busy machine.
const PATIENCE: Duration = Duration::from_secs(30);

/// How often something may go wrong more slowly than it should, since the machine was busy.
const TRIES: usize = 20;

/// A device at work on an untouched pot.
#[derive(Debug)]
pub struct HandSession {
    hand: HapticLoop,
    net: NetSide,
    monitor: Arc<Monitor>,
    epoch: Instant,
    local: u64,
}

impl HandSession {
    /// Opens the device and puts it in a hand at a pot that stands still.
    ///
    /// # Panics
    /// When there is no thread or no pot to be had.
    #[must_use]
    pub fn new(driver: impl Driver, calibration: Calibration, limits: impl Into<Limits>) -> Self {
        Self::beside(pointer().1, driver, calibration, limits)
    }

    /// The same with a mouse beside it that the test moves.
    ///
    /// # Panics
    /// When there is no thread or no pot to be had.
    #[must_use]
    pub fn beside(
        mouse: PointerDevice,
        driver: impl Driver,
        calibration: Calibration,
        limits: impl Into<Limits>,
    ) -> Self {
        let device = DrivenDevice::open(driver, calibration, limits, mouse).expect("a thread for the driver");
        let monitor = device.monitor();
        let field = Field::new(Pot::new(PotSpec::default()).expect("the default pot"), Tick(0));
        let (side, net) = boundary(&Patch { field, conditions: Conditions::default(), rack: rack::standard() });
        Self { hand: HapticLoop::new(Box::new(device), side), net, monitor, epoch: Instant::now(), local: 0 }
    }

    /// Lets the hand tick in its rhythm until something holds.
    ///
    /// # Panics
    /// With `what`, and what the device says, when that does not come about.
    pub fn until(&mut self, what: &str, mut holds: impl FnMut(&Self) -> bool) {
        let begin = Instant::now();
        while !holds(self) {
            assert!(begin.elapsed() < PATIENCE, "not within {PATIENCE:?}: {what}; the device says {:?}", self.notice());
            self.tick();
        }
    }

    /// Lets the hand tick for some time.
    pub fn pass(&mut self, time: Duration) {
        let begin = Instant::now();
        while begin.elapsed() < time {
            self.tick();
        }
    }

    /// Has something go wrong in mid-press until tool and force were gone within so many ticks, each time sees that it is said in one
    /// sentence with `said` in it and that all is well when it was mended. A busy machine may hold up the driver: that is one of several tries.
    ///
    /// # Panics
    /// When that does not come about, or takes more ticks every time.
    pub fn loses_force(
        &mut self,
        most_ticks: u32,
        said: &str,
        mut press: impl FnMut(&mut Self),
        mut goes: impl FnMut(bool),
    ) {
        let mut needed = Vec::new();
        while needed.iter().all(|ticks| *ticks > most_ticks) {
            assert!(
                needed.len() < TRIES,
                "{needed:?} ticks until there was no force, and no more than {most_ticks} do"
            );
            press(self);
            assert!(self.force_n() > 0.0 && self.tool_m().is_some(), "nothing is pressed");
            goes(true);
            let mut ticks = 0;
            self.until("tool and force are gone", |session| {
                let has_gone = session.force_n() == 0.0 && session.tool_m().is_none();
                ticks += u32::from(!has_gone);
                has_gone
            });
            needed.push(ticks);
            self.until("it is said", |session| session.notice().is_some_and(|notice| notice.contains(said)));
            assert!(self.notice().is_none_or(|notice| !notice.contains('\n')), "{:?}", self.notice());
            goes(false);
            self.until("it is back", |session| session.tool_m().is_some() && session.notice().is_none());
        }
    }

    /// One tick, due a millisecond after the last or later.
    pub fn tick(&mut self) {
        std::thread::sleep(Duration::from_millis(1));
        self.local = (self.epoch.elapsed().as_millis() as u64).max(self.local + 1);
        self.hand.tick(self.local);
        while self.net.next_sample().is_some() {}
    }

    /// One tick at once, as if a millisecond had passed.
    pub fn hurry(&mut self) {
        self.local += 1;
        self.hand.tick(self.local);
        while self.net.next_sample().is_some() {}
    }

    /// Force on the hand as the loop has it, N.
    #[must_use]
    pub fn force_n(&self) -> f32 {
        self.net.status().force_n()
    }

    /// Where the tool is, m.
    #[must_use]
    pub fn tool_m(&self) -> Option<Vec3> {
        self.net.status().tool_m()
    }

    /// What keeps the force off.
    #[must_use]
    pub fn fault(&self) -> Option<Fault> {
        self.net.status().fault()
    }

    /// The sentence in the window.
    #[must_use]
    pub fn notice(&self) -> Option<String> {
        self.monitor.notice()
    }

    /// What the window knows of the device.
    #[must_use]
    pub fn monitor(&self) -> &Monitor {
        &self.monitor
    }
}
