//! The room's wheels on several cores, from when one no longer has time enough for all of them.
//!
//! Owns the threads and the judgement of when they help; what is done is the room's.
//! Invariant: a tick is whole before the next begins, and with one core or little to do there is no thread but the caller's.

use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use pottery_shared::room::{Crew, Room};
use pottery_shared::units::Tick;
use rayon_core::{ThreadPool, ThreadPoolBuilder};

/// Time after which it is judged anew.
const JUDGED_EVERY: Duration = Duration::from_millis(250);
/// Share of one core that the ticks of all wheels take above which others help, and below which they no longer do. What is sent
/// after a tick takes the caller about as long again.
const HELPED_ABOVE: f32 = 0.35;
const ALONE_BELOW: f32 = 0.25;

/// Whoever does the ticks.
#[derive(Debug)]
pub(crate) struct Workers {
    /// Cores that the server may use.
    cores: usize,
    /// Made when it is first needed.
    helpers: Option<Helpers>,
    is_helped: bool,
    judged_at: Duration,
    worked: Duration,
}

impl Workers {
    /// For a server that may use so many cores.
    pub(crate) const fn on(cores: usize) -> Self {
        Self { cores, helpers: None, is_helped: false, judged_at: Duration::ZERO, worked: Duration::ZERO }
    }

    /// Does every tick up to and with `to`; `now` is time since the start.
    pub(crate) fn advance(&mut self, room: &mut Room, to: Tick, now: Duration) {
        let worked = match self.helpers.as_ref().filter(|_| self.is_helped) {
            Some(helpers) => {
                room.advance_by(to, helpers);
                helpers.take_worked()
            }
            None => {
                let begun = Instant::now();
                room.advance(to);
                begun.elapsed()
            }
        };
        self.judge(worked, now);
    }

    /// Takes in how long all hands together had to work.
    fn judge(&mut self, worked: Duration, now: Duration) {
        self.worked += worked;
        let passed = now.saturating_sub(self.judged_at);
        if passed < JUDGED_EVERY {
            return;
        }
        let share = self.worked.as_secs_f32() / passed.as_secs_f32();
        (self.judged_at, self.worked) = (now, Duration::ZERO);
        let is_helped = share > if self.is_helped { ALONE_BELOW } else { HELPED_ABOVE };
        if is_helped && self.helpers.is_none() {
            self.helpers = Helpers::new(self.cores.saturating_sub(1));
            // what the system does not give once is not asked for again
            self.cores = if self.helpers.is_some() { self.cores } else { 1 };
        }
        if is_helped != self.is_helped && self.helpers.is_some() {
            self.is_helped = is_helped;
            tracing::debug!(is_helped, share, "the wheels are spread over the cores anew");
        }
    }
}

/// Threads that do wheels beside the caller's own.
#[derive(Debug)]
pub struct Helpers {
    pool: ThreadPool,
    /// What all hands together worked since it was last asked, ns.
    worked_ns: AtomicU64,
}

impl Helpers {
    /// So many of them; none when that is 0 or the system gives no threads.
    #[must_use]
    pub fn new(threads: usize) -> Option<Self> {
        if threads == 0 {
            return None;
        }
        let pool =
            ThreadPoolBuilder::new().num_threads(threads).thread_name(|number| format!("wheels-{number}")).build();
        pool.inspect_err(|error| tracing::warn!("one core does all wheels: {error}"))
            .ok()
            .map(|pool| Self { pool, worked_ns: AtomicU64::new(0) })
    }

    fn take_worked(&self) -> Duration {
        Duration::from_nanos(self.worked_ns.swap(0, Ordering::Relaxed))
    }
}

impl Crew for Helpers {
    fn each<T: Send>(&self, work: impl ExactSizeIterator<Item = T> + Send, each: impl Fn(T) + Sync) {
        let helpers = self.pool.current_num_threads().min(work.len().saturating_sub(1));
        let pieces = Mutex::new(work);
        let next = || pieces.lock().unwrap_or_else(PoisonError::into_inner).next();
        let go_on = || {
            let begun = Instant::now();
            while let Some(piece) = next() {
                each(piece);
            }
            self.worked_ns.fetch_add(begun.elapsed().as_nanos() as u64, Ordering::Relaxed);
        };
        self.pool.in_place_scope(|scope| {
            for _ in 0..helpers {
                scope.spawn(|_| go_on());
            }
            go_on();
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    #[test]
    fn every_piece_of_work_is_done_once() {
        let helpers = Helpers::new(3).expect("the system gives threads");
        for pieces in [0, 1, 2, 7, 500] {
            let mut work = vec![0; pieces];
            helpers.each(work.iter_mut(), |piece| *piece += 1);
            assert_eq!(work, vec![1; pieces]);
        }
    }

    #[test]
    fn others_help_while_one_has_too_much_to_do() {
        let mut workers = Workers::on(2);
        let mut judge = |share_percent: u64, from: u64| {
            for at in (from..from + 500).step_by(10) {
                workers.judge(Duration::from_micros(share_percent * 100), ms(at));
            }
            workers.is_helped
        };
        assert!(!judge(30, 0));
        assert!(judge(60, 500));
        assert!(judge(30, 1000), "it does not change with every breath");
        assert!(!judge(20, 1500));
    }

    #[test]
    fn nobody_helps_on_one_core() {
        let mut workers = Workers::on(1);
        (0..1000).step_by(10).for_each(|at| workers.judge(ms(9), ms(at)));
        assert!(!workers.is_helped && workers.helpers.is_none());
    }
}
