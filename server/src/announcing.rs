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
        // two classes of one name are told apart by their ports, and by the machine where that is not enough
        let instance = format!("{class} {}", address.port());
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
