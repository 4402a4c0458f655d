//! How much is heard of people: a share for each who is in, and what all of an address may send beside.
//!
//! Owns the rule and its figures; what an address has to spare is kept by the doorkeeper, since addresses are.
//! Invariant: whoever keeps to the own share is heard, whoever else sends too much from the same address.

use std::net::IpAddr;
use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::bucket::{Bucket, Rate};
use crate::config::written::{MOST, whole};
use crate::doorkeeper::SharedDoorkeeper;

/// How much people may send, for long; what that makes in [`Input::AT_ONCE_S`] may come at once.
///
/// An address with n people in is heard to (n + `spare_people`) times that, and no more of them are in than the room has
/// places, whatever else is connected from there.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[serde(default, deny_unknown_fields)]
pub struct Input {
    /// Datagrams a second of each person.
    #[serde(deserialize_with = "whole::<_, _, { Input::DATAGRAMS_PER_S_LEAST }, MOST>")]
    pub datagrams_per_s: u32,
    /// Their bytes.
    #[serde(deserialize_with = "whole::<_, _, { Input::BYTES_PER_S_LEAST }, MOST>")]
    pub datagram_bytes_per_s: u32,
    /// Requests a second of each person.
    #[serde(deserialize_with = "whole::<_, _, 1, MOST>")]
    pub requests_per_s: u32,
    /// Their bytes.
    #[serde(deserialize_with = "whole::<_, _, { Input::BYTES_PER_S_LEAST }, MOST>")]
    pub request_bytes_per_s: u32,
    /// What all of an address share beyond that, in people.
    #[serde(deserialize_with = "whole::<_, _, 0, MOST>")]
    pub spare_people: u32,
}

impl Default for Input {
    /// Twice the hundred datagrams that a potter sends a second, seven times the 36 kbit/s that those of one who never rests have and twice
    /// what was sent over the worst line that is simulated, QUIC's own bytes included (15.9 kB/s); two and a half times the requests that
    /// are answered, and a wheel's pot in four seconds. For each address ten people more.
    fn default() -> Self {
        Self {
            datagrams_per_s: 200,
            datagram_bytes_per_s: 32 * 1024,
            requests_per_s: 50,
            request_bytes_per_s: 64 * 1024,
            spare_people: 10,
        }
    }
}

impl Input {
    /// Of how many shares one connection may send what is not heard, before it is let go.
    pub const PATIENCE: u32 = 10;
    /// Seconds of a share that may come at once: as much as a line that stood still has waiting.
    pub const AT_ONCE_S: u32 = 4;
    /// Datagrams a second that a potter sends, less than which is no share.
    pub const DATAGRAMS_PER_S_LEAST: u32 = 100;
    /// Bytes a second below which not even a single datagram or request of the greatest length fits.
    pub const BYTES_PER_S_LEAST: u32 = 8 * 1024;

    /// Whether people can work with it.
    #[must_use]
    pub(crate) const fn is_enough(&self) -> bool {
        self.datagrams_per_s >= Self::DATAGRAMS_PER_S_LEAST
            && self.datagram_bytes_per_s >= Self::BYTES_PER_S_LEAST
            && self.requests_per_s >= 1
            && self.request_bytes_per_s >= Self::BYTES_PER_S_LEAST
    }

    /// What one person may send.
    pub(crate) fn share(&self, kind: Kind) -> Rates {
        self.of_people(kind, 1.0)
    }

    /// What one connection may send in vain.
    fn patience(&self, kind: Kind) -> Rate {
        self.of_people(kind, f64::from(Self::PATIENCE)).messages
    }

    /// What an address may send beyond its people's shares.
    pub(crate) fn spare(&self, kind: Kind) -> Rates {
        self.of_people(kind, f64::from(self.spare_people))
    }

    fn of_people(&self, kind: Kind, people: f64) -> Rates {
        let (messages_per_s, bytes_per_s) = match kind {
            Kind::Datagram => (self.datagrams_per_s, self.datagram_bytes_per_s),
            Kind::Request => (self.requests_per_s, self.request_bytes_per_s),
        };
        let rate = |per_s: u32| {
            let per_s = people * f64::from(per_s);
            Rate { burst: f64::from(Self::AT_ONCE_S) * per_s, per_s }
        };
        Rates { messages: rate(messages_per_s), bytes: rate(bytes_per_s) }
    }
}

/// What is counted apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Samples: one that is too much is not heard, as if the line had lost it.
    Datagram,
    /// Frames of the control stream: one that is too much waits, and with it the stream.
    Request,
}

impl Kind {
    pub(crate) const ALL: [Self; 2] = [Self::Datagram, Self::Request];
}

/// Messages and their bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Rates {
    messages: Rate,
    bytes: Rate,
}

/// Messages and bytes that may still come.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Meter {
    messages: Bucket,
    bytes: Bucket,
}

impl Meter {
    /// One of which nothing was used.
    pub(crate) const fn full(rates: &Rates, now: Duration) -> Self {
        Self { messages: Bucket::full(rates.messages, now), bytes: Bucket::full(rates.bytes, now) }
    }

    /// Takes a message of so many bytes, or nothing when it is too much.
    pub(crate) fn take(&mut self, bytes: usize, rates: &Rates, now: Duration) -> bool {
        let bytes = bytes as f64;
        let has_bytes = self.bytes.left(rates.bytes, now) >= bytes;
        has_bytes && self.messages.take(1.0, rates.messages, now) && self.bytes.take(bytes, rates.bytes, now)
    }

    /// How long it takes until a message of so many bytes may come.
    pub(crate) fn until(&self, bytes: usize, rates: &Rates, now: Duration) -> Duration {
        let messages = self.messages.until(1.0, rates.messages, now);
        messages.max(self.bytes.until(bytes as f64, rates.bytes, now))
    }

    /// Whether as much may come as to one that was never used.
    pub(crate) fn is_full(&self, rates: &Rates, now: Duration) -> bool {
        let is_full = |bucket: &Bucket, rate: Rate| bucket.left(rate, now) >= rate.burst;
        is_full(&self.messages, rates.messages) && is_full(&self.bytes, rates.bytes)
    }
}

/// What one connection may send of a kind. It goes with the connection to another address, and borrows where that is.
#[derive(Debug)]
pub(crate) struct Share {
    doorkeeper: SharedDoorkeeper,
    kind: Kind,
    rates: Rates,
    own: Meter,
    /// What may still come in vain.
    patience: Bucket,
    patience_rate: Rate,
}

impl Share {
    /// The share of somebody whose address is the doorkeeper's to watch.
    pub(crate) fn new(doorkeeper: &SharedDoorkeeper, kind: Kind) -> Self {
        let (input, now) = (doorkeeper.input(), doorkeeper.now());
        let (rates, patience_rate) = (input.share(kind), input.patience(kind));
        let (own, patience) = (Meter::full(&rates, now), Bucket::full(patience_rate, now));
        Self { doorkeeper: doorkeeper.clone(), kind, rates, own, patience, patience_rate }
    }

    /// Whether a message of so many bytes is heard. One that is not is counted.
    pub(crate) fn hears(&mut self, bytes: usize, address: impl Fn() -> IpAddr) -> bool {
        let is_heard = self.has(bytes, self.doorkeeper.now(), address);
        if !is_heard {
            self.doorkeeper.note_too_much(self.kind);
        }
        is_heard
    }

    /// Whether somebody may go on after a message that was not heard: to take such messages in costs time, too.
    pub(crate) fn bears_it(&mut self) -> bool {
        self.patience.take(1.0, self.patience_rate, self.doorkeeper.now())
    }

    /// Waits until a message of so many bytes is heard. One that waits is counted.
    pub(crate) async fn wait(&mut self, bytes: usize, address: impl Fn() -> IpAddr) {
        let mut is_heard = self.hears(bytes, &address);
        while !is_heard {
            // a millisecond at least, as the timer has it
            let until = self.own.until(bytes, &self.rates, self.doorkeeper.now()).max(Duration::from_millis(1));
            tokio::time::sleep(until).await;
            is_heard = self.has(bytes, self.doorkeeper.now(), &address);
        }
    }

    /// Takes a message from the own share or, when that is used up, from what the address has to spare. Whoever keeps to the share
    /// asks nobody and waits for nobody.
    fn has(&mut self, bytes: usize, now: Duration, address: impl Fn() -> IpAddr) -> bool {
        self.own.take(bytes, &self.rates, now) || self.doorkeeper.lends(address(), self.kind, bytes, now)
    }
}

#[cfg(test)]
mod tests {
    use std::net::{Ipv4Addr, Ipv6Addr};

    use super::*;
    use crate::Arrivals;

    const SCHOOL: IpAddr = IpAddr::V4(Ipv4Addr::new(203, 0, 113, 7));
    const HOME: IpAddr = IpAddr::V4(Ipv4Addr::new(203, 0, 113, 8));
    /// Thirty people at each of twenty-four wheels.
    const WHOLE_SCHOOL: usize = 24 * 30;
    /// Milliseconds between two datagrams of a potter, and the bytes of one on a line that loses much: twice what was seen.
    const SEND_EVERY_MS: u64 = 10;
    const HONEST_BYTES: usize = 300;

    fn ms(milliseconds: u64) -> Duration {
        Duration::from_millis(milliseconds)
    }

    fn door() -> SharedDoorkeeper {
        SharedDoorkeeper::new(Arrivals::default(), Input::default())
    }

    fn shares(door: &SharedDoorkeeper, kind: Kind, people: usize) -> Vec<Share> {
        (0..people)
            .map(|_| Share { own: Meter::full(&door.input().share(kind), ms(0)), ..Share::new(door, kind) })
            .collect()
    }

    /// How many of so many messages a millisecond from each are heard within a time.
    fn heard_of_flood(shares: &mut [Share], address: IpAddr, per_ms: usize, bytes: usize, lasts_ms: u64) -> usize {
        let mut heard = 0;
        for now in 0..lasts_ms {
            for share in shares.iter_mut() {
                heard += (0..per_ms).filter(|_| share.has(bytes, ms(now), || address)).count();
            }
        }
        heard
    }

    #[test]
    fn a_whole_school_behind_one_address_is_heard_and_borrows_nothing() {
        let door = door();
        let mut school = shares(&door, Kind::Datagram, WHOLE_SCHOOL);
        for now in (0..30_000).step_by(SEND_EVERY_MS as usize) {
            // for three seconds the school's line stands still, and then all that waited comes at once
            let waited = match now {
                10_000..13_000 => continue,
                13_000 => 3_000 / SEND_EVERY_MS,
                _ => 1,
            };
            for share in &mut school {
                assert!((0..waited).all(|_| share.has(HONEST_BYTES, ms(now), || unreachable!("nobody borrows"))));
            }
        }
        // and twenty requests a second of each, forty at once first, as many as are answered
        for share in &mut shares(&door, Kind::Request, WHOLE_SCHOOL) {
            assert!((0..40).all(|_| share.has(40, ms(0), || unreachable!("nobody borrows"))));
            for now in (0..30_000).step_by(50) {
                assert!(share.has(40, ms(now), || unreachable!("nobody borrows")));
            }
        }
    }

    #[test]
    fn a_flood_from_one_address_is_cut_to_its_people_and_ten_more() {
        let (seconds, people) = (10, 8);
        let input = Input::default();
        for kind in Kind::ALL {
            let (messages_per_s, bytes_per_s) = match kind {
                Kind::Datagram => (input.datagrams_per_s, input.datagram_bytes_per_s),
                Kind::Request => (input.requests_per_s, input.request_bytes_per_s),
            };
            let bound = |per_s: u32| (people + input.spare_people) * per_s * (seconds + Input::AT_ONCE_S);
            for bytes in [20, 4_000] {
                let most = bound(messages_per_s).min(bound(bytes_per_s) / bytes);
                let door = door();
                let mut flood = shares(&door, kind, people as usize);
                let heard = heard_of_flood(&mut flood, SCHOOL, 4, bytes as usize, u64::from(seconds) * 1000);
                let is_cut = heard <= most as usize && heard >= most as usize * 99 / 100;
                assert!(is_cut, "{kind:?} of {bytes} bytes: {heard} of {most}");
            }
        }
    }

    #[test]
    fn who_keeps_to_the_share_is_heard_beside_somebody_who_floods_from_the_same_address() {
        let door = door();
        let mut flood = shares(&door, Kind::Datagram, 4);
        let mut honest = shares(&door, Kind::Datagram, 1);
        for second in 0..20 {
            for now in (second * 1_000..(second + 1) * 1_000).step_by(SEND_EVERY_MS as usize) {
                for share in &mut flood {
                    while share.has(20, ms(now), || SCHOOL) {}
                }
                assert!(honest[0].has(HONEST_BYTES, ms(now), || SCHOOL), "at {now} ms");
            }
        }
    }

    #[test]
    fn another_address_has_its_own_to_spare_and_one_half_of_ipv6_has_one() {
        let door = door();
        let mut flood = shares(&door, Kind::Datagram, 1);
        let used_up = |share: &mut Share, address: IpAddr| {
            let mut heard = 0;
            while share.has(20, ms(0), || address) {
                heard += 1;
            }
            heard
        };
        assert_eq!(used_up(&mut flood[0], SCHOOL), 800 + 8_000);
        // the own share went with it, the address's did not
        assert_eq!(used_up(&mut flood[0], HOME), 8_000);
        assert_eq!(used_up(&mut flood[0], SCHOOL), 0);
        let of = |net, last| IpAddr::V6(Ipv6Addr::new(0x2001, 0xdb8, 0, net, 0, 0, 0, last));
        assert_eq!(used_up(&mut flood[0], of(1, 1)), 8_000);
        assert_eq!((used_up(&mut flood[0], of(1, 2)), used_up(&mut flood[0], of(2, 1))), (0, 8_000));
    }

    #[test]
    fn whoever_waits_for_a_turn_is_told_how_long() {
        let rates = Input::default().share(Kind::Request);
        let mut meter = Meter::full(&rates, ms(0));
        assert!((0..200).all(|_| meter.take(100, &rates, ms(0))));
        assert!(!meter.take(100, &rates, ms(0)), "fifty a second, and four seconds' at once");
        let until = meter.until(100, &rates, ms(0));
        assert!(until <= ms(20) && meter.take(100, &rates, ms(20)), "{until:?}");
        // the longest frame there is fits into the least share
        let least = Input { request_bytes_per_s: Input::BYTES_PER_S_LEAST, ..Input::default() }.share(Kind::Request);
        assert!(Meter::full(&least, ms(0)).take(pottery_shared::protocol::CONTROL_MAX, &least, ms(0)));
    }
}
