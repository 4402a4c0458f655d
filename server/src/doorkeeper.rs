//! What is counted by address: who may knock how often, where wrong codes count as many, and what its people may send beyond their shares.
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

use crate::bucket::{Bucket, Rate};
use crate::config::written::{MOST, whole};
use crate::input::{Input, Kind, Meter};

/// How many arrivals an address may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Arrivals {
    /// At once: a school behind one address.
    #[serde(deserialize_with = "whole::<_, _, 1, MOST>")]
    pub burst: u32,
    /// And each second after that.
    #[serde(deserialize_with = "whole::<_, _, 1, MOST>")]
    pub per_s: u32,
    /// What a wrong code costs in arrivals.
    #[serde(deserialize_with = "whole::<_, _, 0, MOST>")]
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

impl Arrivals {
    fn rate(&self) -> Rate {
        Rate { burst: f64::from(self.burst), per_s: f64::from(self.per_s) }
    }
}

/// Most addresses remembered at one time: half a megabyte, or one with what the map keeps free.
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

/// What an address may still do.
#[derive(Clone, Copy, Debug)]
struct Door {
    arrivals: Bucket,
    /// What its people may send beyond their shares, datagrams and requests.
    spare: [Meter; 2],
}

/// What was not heard, or not at once, since an address sent too much.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InputCounts {
    /// Datagrams that were not heard.
    pub unheard: u64,
    /// Requests that had to wait.
    pub held: u64,
}

/// The memory of who knocked and who sent too much.
#[derive(Debug)]
pub(crate) struct Doorkeeper {
    arrivals: Arrivals,
    input: Input,
    doors: BTreeMap<Household, Door>,
    turned_away: u64,
    counts: InputCounts,
}

impl Doorkeeper {
    pub(crate) const fn new(arrivals: Arrivals, input: Input) -> Self {
        let counts = InputCounts { unheard: 0, held: 0 };
        Self { arrivals, input, doors: BTreeMap::new(), turned_away: 0, counts }
    }

    /// Whether somebody who knocks may come in; `now` is the time since any beginning.
    pub(crate) fn may_come(&mut self, address: IpAddr, now: Duration) -> bool {
        let rate = self.arrivals.rate();
        let may_come = self.is_exempt(address) || self.door(address, now).arrivals.take(1.0, rate, now);
        self.turned_away += u64::from(!may_come);
        may_come
    }

    /// Notes that somebody could not come in, since too many others were about to.
    pub(crate) const fn note_crowd(&mut self) {
        self.turned_away += 1;
    }

    /// Whether an address has used more than half of what it may: who knocks from there has to show that it is theirs, or somebody
    /// who borrows an address could spend what its owner needs.
    pub(crate) fn is_doubtful(&self, address: IpAddr, now: Duration) -> bool {
        let (door, rate) = (self.doors.get(&Household::of(address)), self.arrivals.rate());
        door.is_some_and(|door| door.arrivals.left(rate, now) < 0.5 * rate.burst)
    }

    /// Notes that somebody from there had a wrong code, or sent so much that it was let go.
    pub(crate) fn note_wrong_code(&mut self, address: IpAddr, now: Duration) {
        let (cost, rate) = (f64::from(self.arrivals.wrong_code_costs), self.arrivals.rate());
        if !self.is_exempt(address) {
            // owed, so that guesses which knocked together wait as long as those that did not; but never for minutes
            self.door(address, now).arrivals.charge(cost, 2.0 * cost, rate, now);
        }
    }

    /// How many were turned away so far.
    pub(crate) const fn turned_away(&self) -> u64 {
        self.turned_away
    }

    /// Whether an address has so many bytes to spare for one of its people, who has used up the own share; they are taken then.
    pub(crate) fn lends(&mut self, address: IpAddr, kind: Kind, bytes: usize, now: Duration) -> bool {
        let spare = self.input.spare(kind);
        self.door(address, now).spare[kind as usize].take(bytes, &spare, now)
    }

    /// Notes that a datagram is not heard, or that a request has to wait.
    pub(crate) const fn note_too_much(&mut self, kind: Kind) {
        match kind {
            Kind::Datagram => self.counts.unheard += 1,
            Kind::Request => self.counts.held += 1,
        }
    }

    /// What was too much so far.
    pub(crate) const fn counts(&self) -> InputCounts {
        self.counts
    }

    /// Forgets every address that may do as much as one that was never heard of.
    pub(crate) fn forget_idle(&mut self, now: Duration) {
        let (rate, spare) = (self.arrivals.rate(), Kind::ALL.map(|kind| self.input.spare(kind)));
        self.doors.retain(|_, door| {
            let owes_arrivals = door.arrivals.left(rate, now) < rate.burst;
            owes_arrivals
                || Kind::ALL.iter().any(|&kind| !door.spare[kind as usize].is_full(&spare[kind as usize], now))
        });
    }

    /// Whether nobody counts how often somebody knocks.
    fn is_exempt(&self, address: IpAddr) -> bool {
        self.arrivals.exempts_loopback && is_loopback(address)
    }

    fn door(&mut self, address: IpAddr, now: Duration) -> &mut Door {
        let household = Household::of(address);
        if self.doors.len() >= DOORS_MAX && !self.doors.contains_key(&household) {
            self.make_room(now);
        }
        let (rate, input) = (self.arrivals.rate(), &self.input);
        self.doors.entry(household).or_insert_with(|| Door {
            arrivals: Bucket::full(rate, now),
            spare: Kind::ALL.map(|kind| Meter::full(&input.spare(kind), now)),
        })
    }

    /// Forgets who is idle; when nobody is, whoever may knock most often.
    fn make_room(&mut self, now: Duration) {
        self.forget_idle(now);
        if self.doors.len() >= DOORS_MAX {
            let rate = self.arrivals.rate();
            let left = |door: &Door| door.arrivals.left(rate, now);
            let most = self.doors.iter().max_by(|(_, one), (_, other)| left(one).total_cmp(&left(other)));
            if let Some(&household) = most.map(|(household, _)| household) {
                self.doors.remove(&household);
            }
        }
    }
}

/// The one doorkeeper of a server, for whoever lets people in, reads their codes and hears what they send.
#[derive(Clone, Debug)]
pub(crate) struct SharedDoorkeeper {
    keeper: Arc<Mutex<Doorkeeper>>,
    since: Instant,
}

impl SharedDoorkeeper {
    pub(crate) fn new(arrivals: Arrivals, input: Input) -> Self {
        Self { keeper: Arc::new(Mutex::new(Doorkeeper::new(arrivals, input))), since: Instant::now() }
    }

    /// The time since its beginning.
    pub(crate) fn now(&self) -> Duration {
        self.since.elapsed()
    }

    /// How much people may send.
    pub(crate) fn input(&self) -> Input {
        self.keeper().input
    }

    fn keeper(&self) -> MutexGuard<'_, Doorkeeper> {
        // whoever panicked while counting has at worst counted one too few
        self.keeper.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// [`Doorkeeper::may_come`], now.
    pub(crate) fn may_come(&self, address: IpAddr) -> bool {
        self.keeper().may_come(address, self.now())
    }

    /// [`Doorkeeper::is_doubtful`], now.
    pub(crate) fn is_doubtful(&self, address: IpAddr) -> bool {
        self.keeper().is_doubtful(address, self.now())
    }

    /// [`Doorkeeper::note_wrong_code`], now.
    pub(crate) fn note_wrong_code(&self, address: IpAddr) {
        self.keeper().note_wrong_code(address, self.now());
    }

    /// [`Doorkeeper::note_crowd`].
    pub(crate) fn note_crowd(&self) {
        self.keeper().note_crowd();
    }

    /// [`Doorkeeper::turned_away`].
    pub(crate) fn turned_away(&self) -> u64 {
        self.keeper().turned_away()
    }

    /// [`Doorkeeper::lends`].
    pub(crate) fn lends(&self, address: IpAddr, kind: Kind, bytes: usize, now: Duration) -> bool {
        self.keeper().lends(address, kind, bytes, now)
    }

    /// [`Doorkeeper::note_too_much`].
    pub(crate) fn note_too_much(&self, kind: Kind) {
        self.keeper().note_too_much(kind);
    }

    /// [`Doorkeeper::counts`].
    pub(crate) fn counts(&self) -> InputCounts {
        self.keeper().counts()
    }

    /// [`Doorkeeper::forget_idle`], now.
    pub(crate) fn forget_idle(&self) {
        self.keeper().forget_idle(self.now());
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::net::Ipv4Addr;

    const SCHOOL: IpAddr = IpAddr::V4(Ipv4Addr::new(203, 0, 113, 7));

    fn at(seconds: f64) -> Duration {
        Duration::from_secs_f64(seconds)
    }

    fn keeper_of(arrivals: Arrivals) -> Doorkeeper {
        Doorkeeper::new(arrivals, Input::default())
    }

    #[test]
    fn a_school_behind_one_address_comes_in_at_once() {
        let mut keeper = keeper_of(Arrivals::default());
        assert!((0..300).all(|_| keeper.may_come(SCHOOL, at(1.0))));
        assert!(!keeper.may_come(SCHOOL, at(1.0)));
        assert_eq!(keeper.turned_away(), 1);
        let later = (0..60).filter(|_| keeper.may_come(SCHOOL, at(2.0))).count();
        assert_eq!(later, 30, "and thirty a second after that");
    }

    #[test]
    fn who_guesses_codes_soon_may_not_and_nobody_else_is_the_worse_for_it() {
        let mut keeper = keeper_of(Arrivals::default());
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
        let mut keeper = keeper_of(arrivals);
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
        let mut keeper = keeper_of(arrivals);
        assert!(keeper.may_come(SCHOOL, at(0.0)));
        keeper.note_wrong_code(SCHOOL, at(0.0));
        for number in 0..20_000_u32 {
            assert!(keeper.may_come(IpAddr::V4(Ipv4Addr::from_bits(0x0A00_0000 + number)), at(1.0)));
        }
        assert!(keeper.doors.len() <= DOORS_MAX, "{}", keeper.doors.len());
        assert!(!keeper.may_come(SCHOOL, at(2.0)));
        // as much as is said of it
        assert!(DOORS_MAX * size_of::<(Household, Door)>() <= 800_000, "{}", size_of::<(Household, Door)>());
    }

    #[test]
    fn an_address_that_is_idle_is_forgotten_within_a_minute() {
        let mut keeper = keeper_of(Arrivals::default());
        while keeper.may_come(SCHOOL, at(1.0)) {
            keeper.note_wrong_code(SCHOOL, at(1.0));
        }
        let other = IpAddr::V4(Ipv4Addr::new(203, 0, 113, 8));
        while keeper.lends(other, Kind::Request, 20_000, at(1.0)) {}
        keeper.forget_idle(at(3.0));
        assert_eq!(keeper.doors.len(), 2, "who owes something is remembered");
        keeper.forget_idle(at(40.0));
        assert_eq!(keeper.doors.len(), 0);
    }

    #[test]
    fn this_machine_is_not_counted_unless_asked_for() {
        let local = IpAddr::V4(Ipv4Addr::LOCALHOST);
        let mut keeper = keeper_of(Arrivals { burst: 1, ..Arrivals::default() });
        assert!((0..100).all(|_| keeper.may_come(local, at(0.0))));
        let mut keeper = keeper_of(Arrivals { burst: 1, exempts_loopback: false, ..Arrivals::default() });
        assert!(keeper.may_come(local, at(0.0)) && !keeper.may_come(local, at(0.0)));
    }
}
