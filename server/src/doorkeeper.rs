//! Who may knock how often: arrivals are counted by the address they come from, and wrong codes count as many.
//!
//! [`Doorkeeper`] is pure and takes time as an argument; what the tasks share reads the clock for it. Nothing of it is ever written
//! down.
//! Invariant: what it remembers is bounded, and who has done nothing for a while is not remembered at all.

use std::collections::BTreeMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use serde::{Deserialize, Serialize};
use tokio::time::Instant;

/// How many arrivals an address may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Arrivals {
    /// At once: a school behind one address.
    pub burst: u32,
    /// And each second after that.
    pub per_s: u32,
    /// What a wrong code costs in arrivals.
    pub wrong_code_costs: u32,
    /// Whether this machine itself may knock as often as it likes.
    pub exempts_loopback: bool,
}

impl Default for Arrivals {
    /// Three hundred at once and thirty a second; who guesses codes has eleven guesses and then less than one a second, at which a code of
    /// 40 bits takes thirty thousand years.
    fn default() -> Self {
        Self { burst: 300, per_s: 30, wrong_code_costs: 32, exempts_loopback: true }
    }
}

/// Most addresses remembered at one time.
const DOORS_MAX: usize = 4096;

/// An address as a household has it: all of IPv4, the network's half of IPv6.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Household(u128);

impl Household {
    fn of(address: IpAddr) -> Self {
        match address {
            IpAddr::V4(address) => Self(address.to_ipv6_mapped().to_bits()),
            IpAddr::V6(address) if address.to_ipv4_mapped().is_some() => Self(address.to_bits()),
            IpAddr::V6(address) => Self(address.to_bits() & !u128::from(u64::MAX)),
        }
    }
}

fn is_loopback(address: IpAddr) -> bool {
    match address {
        IpAddr::V4(address) => address.is_loopback(),
        IpAddr::V6(address) => {
            address == Ipv6Addr::LOCALHOST || address.to_ipv4_mapped().is_some_and(|address| address.is_loopback())
        }
    }
}

/// What an address has left, and when that was so.
#[derive(Clone, Copy, Debug)]
struct Door {
    left: f64,
    at: Duration,
}

/// The memory of who knocked.
#[derive(Debug)]
pub(crate) struct Doorkeeper {
    arrivals: Arrivals,
    doors: BTreeMap<Household, Door>,
    turned_away: u64,
}

impl Doorkeeper {
    pub(crate) const fn new(arrivals: Arrivals) -> Self {
        Self { arrivals, doors: BTreeMap::new(), turned_away: 0 }
    }

    /// Whether somebody who knocks may come in; `now` is the time since any beginning.
    pub(crate) fn may_come(&mut self, address: IpAddr, now: Duration) -> bool {
        let may_come = self.door(address, now).is_none_or(|door| {
            let has_one = door.left >= 1.0;
            door.left -= f64::from(u8::from(has_one));
            has_one
        });
        self.turned_away += u64::from(!may_come);
        may_come
    }

    /// Whether an address has used more than half of what it may: who knocks from there has to show that it is theirs, or somebody
    /// who borrows an address could spend what its owner needs.
    pub(crate) fn is_doubtful(&self, address: IpAddr, now: Duration) -> bool {
        let door = self.doors.get(&Household::of(address));
        door.is_some_and(|door| left(door, &self.arrivals, now) < 0.5 * f64::from(self.arrivals.burst))
    }

    /// Notes that somebody from there had a wrong code.
    pub(crate) fn note_wrong_code(&mut self, address: IpAddr, now: Duration) {
        let cost = f64::from(self.arrivals.wrong_code_costs);
        if let Some(door) = self.door(address, now) {
            // owed, so that guesses which knocked together wait as long as those that did not; but never for minutes
            door.left = (door.left - cost).max(-2.0 * cost);
        }
    }

    /// How many were turned away so far.
    pub(crate) const fn turned_away(&self) -> u64 {
        self.turned_away
    }

    /// What an address has left by now; none where nobody counts.
    fn door(&mut self, address: IpAddr, now: Duration) -> Option<&mut Door> {
        if self.arrivals.exempts_loopback && is_loopback(address) {
            return None;
        }
        let household = Household::of(address);
        if !self.doors.contains_key(&household) && self.doors.len() >= DOORS_MAX {
            self.forget(now);
        }
        let full = f64::from(self.arrivals.burst);
        let door = self.doors.entry(household).or_insert(Door { left: full, at: now });
        *door = Door { left: left(door, &self.arrivals, now), at: now };
        Some(door)
    }

    /// Forgets whoever has as much left as a newcomer; when that frees nothing, whoever has most.
    fn forget(&mut self, now: Duration) {
        let (arrivals, full) = (self.arrivals, f64::from(self.arrivals.burst));
        self.doors.retain(|_, door| left(door, &arrivals, now) < full);
        if self.doors.len() >= DOORS_MAX {
            let most = self
                .doors
                .iter()
                .max_by(|(_, one), (_, other)| left(one, &arrivals, now).total_cmp(&left(other, &arrivals, now)));
            if let Some(&household) = most.map(|(household, _)| household) {
                self.doors.remove(&household);
            }
        }
    }
}

/// The one doorkeeper of a server, for whoever lets people in and whoever reads their codes.
#[derive(Clone, Debug)]
pub(crate) struct SharedDoorkeeper {
    keeper: Arc<Mutex<Doorkeeper>>,
    since: Instant,
}

impl SharedDoorkeeper {
    pub(crate) fn new(arrivals: Arrivals) -> Self {
        Self { keeper: Arc::new(Mutex::new(Doorkeeper::new(arrivals))), since: Instant::now() }
    }

    fn keeper(&self) -> MutexGuard<'_, Doorkeeper> {
        // whoever panicked while counting has at worst counted one too few
        self.keeper.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// [`Doorkeeper::may_come`], now.
    pub(crate) fn may_come(&self, address: IpAddr) -> bool {
        self.keeper().may_come(address, self.since.elapsed())
    }

    /// [`Doorkeeper::is_doubtful`], now.
    pub(crate) fn is_doubtful(&self, address: IpAddr) -> bool {
        self.keeper().is_doubtful(address, self.since.elapsed())
    }

    /// [`Doorkeeper::note_wrong_code`], now.
    pub(crate) fn note_wrong_code(&self, address: IpAddr) {
        self.keeper().note_wrong_code(address, self.since.elapsed());
    }

    /// [`Doorkeeper::turned_away`].
    pub(crate) fn turned_away(&self) -> u64 {
        self.keeper().turned_away()
    }
}

/// What is left at a door by now.
fn left(door: &Door, arrivals: &Arrivals, now: Duration) -> f64 {
    let since_s = now.saturating_sub(door.at).as_secs_f64();
    (door.left + since_s * f64::from(arrivals.per_s)).min(f64::from(arrivals.burst))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    const SCHOOL: IpAddr = IpAddr::V4(Ipv4Addr::new(203, 0, 113, 7));

    fn at(seconds: f64) -> Duration {
        Duration::from_secs_f64(seconds)
    }

    #[test]
    fn a_school_behind_one_address_comes_in_at_once() {
        let mut keeper = Doorkeeper::new(Arrivals::default());
        assert!((0..300).all(|_| keeper.may_come(SCHOOL, at(1.0))));
        assert!(!keeper.may_come(SCHOOL, at(1.0)));
        assert_eq!(keeper.turned_away(), 1);
        let later = (0..60).filter(|_| keeper.may_come(SCHOOL, at(2.0))).count();
        assert_eq!(later, 30, "and thirty a second after that");
    }

    #[test]
    fn who_guesses_codes_soon_may_not_and_nobody_else_is_the_worse_for_it() {
        let mut keeper = Doorkeeper::new(Arrivals::default());
        let mut guesses = 0;
        // a thousand knocks a second for a minute, each with a wrong code
        for knock in 0..60_000 {
            let now = at(f64::from(knock) * 1e-3);
            if keeper.may_come(SCHOOL, now) {
                keeper.note_wrong_code(SCHOOL, now);
                guesses += 1;
            }
        }
        // ten at once, and then one whenever 33 arrivals' time has passed
        assert!((60..=70).contains(&guesses), "{guesses}");
        assert!(keeper.may_come(IpAddr::V4(Ipv4Addr::new(203, 0, 113, 8)), at(60.0)));
    }

    #[test]
    fn a_household_has_one_door_whatever_address_it_takes() {
        let arrivals = Arrivals { burst: 2, per_s: 1, ..Arrivals::default() };
        let mut keeper = Doorkeeper::new(arrivals);
        let of = |last| IpAddr::V6(Ipv6Addr::new(0x2001, 0xdb8, 0, 1, 0, 0, 0, last));
        let mapped = IpAddr::V6(Ipv4Addr::new(203, 0, 113, 7).to_ipv6_mapped());
        assert!(keeper.may_come(of(1), at(0.0)) && keeper.may_come(of(2), at(0.0)) && !keeper.may_come(of(3), at(0.0)));
        assert!(
            keeper.may_come(SCHOOL, at(0.0)) && keeper.may_come(mapped, at(0.0)) && !keeper.may_come(SCHOOL, at(0.0))
        );
    }

    #[test]
    fn memory_is_bounded_and_the_guessers_are_remembered_longest() {
        let arrivals = Arrivals { burst: 10, per_s: 0, wrong_code_costs: 10, exempts_loopback: true };
        let mut keeper = Doorkeeper::new(arrivals);
        assert!(keeper.may_come(SCHOOL, at(0.0)));
        keeper.note_wrong_code(SCHOOL, at(0.0));
        for number in 0..20_000_u32 {
            assert!(keeper.may_come(IpAddr::V4(Ipv4Addr::from_bits(0x0A00_0000 + number)), at(1.0)));
        }
        assert!(keeper.doors.len() <= DOORS_MAX, "{}", keeper.doors.len());
        assert!(!keeper.may_come(SCHOOL, at(2.0)));
    }

    #[test]
    fn this_machine_is_not_counted_unless_asked_for() {
        let local = IpAddr::V4(Ipv4Addr::LOCALHOST);
        let mut keeper = Doorkeeper::new(Arrivals { burst: 1, ..Arrivals::default() });
        assert!((0..100).all(|_| keeper.may_come(local, at(0.0))));
        let mut keeper = Doorkeeper::new(Arrivals { burst: 1, exempts_loopback: false, ..Arrivals::default() });
        assert!(keeper.may_come(local, at(0.0)) && !keeper.may_come(local, at(0.0)));
    }
}
