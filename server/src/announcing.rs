//! The server says on the local network that it is there (mDNS, RFC 6762 and 6763), so that nobody has to type an address.
//!
//! Owns what is said: the class's name, the port, wheels and version. Neither code nor certificate: who wants in asks a person.
//! Invariant: a network that takes no announcement is no reason not to open.

use std::net::SocketAddr;
use std::time::Duration;

use mdns_sd::{ServiceDaemon, ServiceInfo};
use pottery_shared::protocol::{Nickname, VERSION};

/// The kind of service.
const KIND: &str = "_pottery._udp.local.";
/// Longest name of an instance, bytes: a label of DNS (RFC 1035, section 2.3.4).
const LABEL_BYTES: usize = 63;
/// How long a goodbye may take.
const GOODBYE_WITHIN: Duration = Duration::from_millis(500);

/// What goes on saying it.
pub(crate) struct Announcement {
    daemon: ServiceDaemon,
    name: String,
}

impl std::fmt::Debug for Announcement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Announcement").field("name", &self.name).finish_non_exhaustive()
    }
}

/// The name of a class that was given none: a word that its certificate chooses.
pub(crate) fn usual_name(fingerprint: &[u8; 32]) -> String {
    Nickname(u16::from(fingerprint[0]) % 64).to_string()
}

/// The name of an instance: as much of the class's as a label takes, which is told whole beside it. Two classes of one name are told apart
/// by their ports, and by the machine where that is not enough.
fn instance(class: &str, port: u16) -> String {
    let port = format!(" {port}");
    let end = class.floor_char_boundary(LABEL_BYTES - port.len());
    format!("{}{port}", &class[..end])
}

impl Announcement {
    /// Begins to say it, where others can hear it.
    pub(crate) fn begin(class: &str, address: SocketAddr, wheels: u16) -> Option<Self> {
        if address.ip().is_loopback() {
            return None;
        }
        match Self::register(class, address, wheels) {
            Ok(announcement) => Some(announcement),
            Err(error) => {
                tracing::info!("nobody finds this studio by itself ({error}); its address works as ever");
                None
            }
        }
    }

    fn register(class: &str, address: SocketAddr, wheels: u16) -> Result<Self, mdns_sd::Error> {
        let daemon = ServiceDaemon::new()?;
        let instance = instance(class, address.port());
        let host = format!("pottery-{:08x}.local.", std::process::id());
        let told = [("class", class), ("wheels", &wheels.to_string()), ("version", &VERSION.to_string())];
        let own = if address.ip().is_unspecified() { String::new() } else { address.ip().to_string() };
        let mut info = ServiceInfo::new(KIND, &instance, &host, own, address.port(), &told[..])?;
        if address.ip().is_unspecified() {
            info = info.enable_addr_auto();
        }
        let name = info.get_fullname().to_owned();
        daemon.register(info)?;
        Ok(Self { daemon, name })
    }

    /// Says that it is gone.
    pub(crate) fn end(self) {
        if let Ok(done) = self.daemon.unregister(&self.name)
            && done.recv_timeout(GOODBYE_WITHIN).is_err()
        {
            tracing::debug!("the goodbye was not sent in time");
        }
        if let Err(error) = self.daemon.shutdown() {
            tracing::debug!(%error, "the announcement did not end well");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ServerConfig;

    #[test]
    fn every_class_has_a_label() {
        assert_eq!(instance("Töpfern", 4747), "Töpfern 4747");
        for sign in ["a", "ж", "陶", "🏺"] {
            let name = instance(&sign.repeat(ServerConfig::CLASS_MAX), u16::MAX);
            assert!(name.len() <= LABEL_BYTES && name.starts_with(sign) && name.ends_with(" 65535"), "{name}");
            // no sign is left out that has room
            assert!(
                name.len() + sign.len() > LABEL_BYTES || name.chars().count() == ServerConfig::CLASS_MAX + 6,
                "{name}"
            );
        }
    }
}
