//! Studios on the local network, as they announce themselves (mDNS, RFC 6762 and 6763).
//!
//! Owns the listening and the choice among a studio's addresses; joins nothing.
//! Invariant: what was heard is shown as it was said and believed in nothing else: whom to trust, the code or a person says.

use std::collections::BTreeMap;
use std::net::{IpAddr, SocketAddr};
use std::time::{Duration, Instant};

use mdns_sd::{ResolvedService, ServiceDaemon, ServiceEvent};
use pottery_shared::protocol::VERSION;

/// The kind of service.
const KIND: &str = "_pottery._udp.local.";
/// Longest name that is shown.
const NAME_MAX: usize = 60;

/// A studio that announces itself.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Found {
    /// What its host calls it.
    pub class: String,
    /// Where it is.
    pub address: SocketAddr,
    /// How many wheels it has, if it says so.
    pub wheels: Option<u16>,
    /// Whether it speaks this program's version of the protocol.
    pub is_of_this_version: bool,
}

/// Why nothing can be found.
#[derive(Debug, thiserror::Error)]
#[error("this machine cannot look for studios ({reason}); join with the address that the host shows")]
pub struct FindError {
    reason: String,
}

/// Listens for so long; returns who announced themselves, by name.
///
/// # Errors
/// [`FindError`] when the system does not let anybody listen.
pub fn find(patience: Duration) -> Result<Vec<Found>, FindError> {
    let no_ears = |error: mdns_sd::Error| FindError { reason: error.to_string() };
    let daemon = ServiceDaemon::new().map_err(no_ears)?;
    let heard = daemon.browse(KIND).map_err(no_ears)?;
    let (began, mut found) = (Instant::now(), BTreeMap::new());
    while let Some(left) = patience.checked_sub(began.elapsed()) {
        match heard.recv_timeout(left) {
            Ok(ServiceEvent::ServiceResolved(service)) => {
                if let Some(studio) = studio(&service) {
                    found.insert(service.fullname.clone(), studio);
                }
            }
            Ok(ServiceEvent::ServiceRemoved(_, name)) => drop(found.remove(&name)),
            Ok(_) => {}
            Err(_) => break,
        }
    }
    if let Err(error) = daemon.shutdown() {
        tracing::debug!(%error, "the listening did not end well");
    }
    let mut found: Vec<_> = found.into_values().collect();
    found.sort_by(|one, other| (&one.class, one.address).cmp(&(&other.class, other.address)));
    Ok(found)
}

fn studio(service: &ResolvedService) -> Option<Found> {
    let told = |key: &str| service.txt_properties.get_property_val_str(key);
    let addresses = service.addresses.iter().map(mdns_sd::ScopedIp::to_ip_addr);
    let ip = addresses.min_by_key(|ip| (rank(*ip), *ip))?;
    let class: String = told("class").unwrap_or("?").chars().filter(|sign| !sign.is_control()).take(NAME_MAX).collect();
    Some(Found {
        class,
        address: SocketAddr::new(ip, service.port),
        wheels: told("wheels").and_then(|wheels| wheels.parse().ok()),
        is_of_this_version: told("version").and_then(|version| version.parse().ok()) == Some(VERSION),
    })
}

/// Which address to show: what people can read out first, and one that needs no interface's name.
const fn rank(ip: IpAddr) -> u8 {
    match ip {
        IpAddr::V4(ip) if ip.is_loopback() => 3,
        IpAddr::V4(ip) if ip.is_link_local() => 2,
        IpAddr::V4(_) => 0,
        IpAddr::V6(ip) if ip.is_loopback() || ip.is_unicast_link_local() => 4,
        IpAddr::V6(_) => 1,
    }
}
