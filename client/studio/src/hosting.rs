//! The embedded server: the same as the stand-alone one, on a runtime of its own.
//!
//! Invariant: dropping the studio stops it, and a start that came to nothing leaves no session file behind.

use std::fs;
use std::io::ErrorKind;
use std::net::{IpAddr, SocketAddr, UdpSocket};
use std::path::{Path, PathBuf};

use anyhow::{Context, ensure};
use pottery_client::Target;
use pottery_server::{Server, ServerConfig, ServerError, Standing, StoreError, last_pot};
use tokio::runtime::Runtime;

/// Windows of one person that host at the same time and put by what is pressed.
const SPARES_MAX: u32 = 16;

/// A server that lives as long as this value.
#[derive(Debug)]
pub(crate) struct Studio {
    runtime: Runtime,
    server: Option<Server>,
    /// Where it puts by what is pressed.
    spare: Option<PathBuf>,
    /// The session file that was begun, until it is worth keeping.
    begun: Option<PathBuf>,
}

impl Studio {
    pub(crate) fn open(config: ServerConfig) -> anyhow::Result<Self> {
        let runtime = runtime("server")?;
        // one that is there, which may be a link that leads nowhere, is refused and stays
        let begun = config.record.clone().filter(|path| path.symlink_metadata().is_err());
        let spare = config.spare.clone();
        match runtime.block_on(async { Server::start(config) }) {
            Ok(server) => Ok(Self { runtime, server: Some(server), spare, begun }),
            Err(error) => {
                if let Some(path) = &begun {
                    take_away(path);
                }
                Err(error.into())
            }
        }
    }

    /// Opens it for a window: what is pressed is put by in this person's folder for data, for whoever leaves without saving.
    pub(crate) fn open_for_window(config: &ServerConfig) -> anyhow::Result<Self> {
        let Some(folder) = dirs::data_dir().map(|folder| folder.join("pottery-studio")) else {
            return Self::open(config.clone());
        };
        for spare in (1..=SPARES_MAX).map(|number| folder.join(format!("unsaved-{number}"))) {
            let opened = Self::open(ServerConfig { spare: Some(spare), ..config.clone() });
            let why = match opened.as_ref().map_err(|error| error.downcast_ref::<ServerError>()) {
                // by another window
                Err(Some(ServerError::Store(StoreError::Taken { .. }))) => continue,
                Err(Some(ServerError::Store(StoreError::Folder { path, source }))) => {
                    format!("the folder {} cannot be used ({source})", path.display())
                }
                Err(Some(ServerError::Store(StoreError::NoFolder { path }))) => {
                    format!("{} is a file and no folder", path.display())
                }
                _ => return opened,
            };
            note!("what is pressed is not put by: {why}");
            break;
        }
        Self::open(config.clone())
    }

    /// The pot that was pressed and left in a window before.
    pub(crate) fn last_pot(&self) -> Option<PathBuf> {
        self.spare.as_ref().map(|spare| last_pot(spare, 0)).filter(|path| path.exists())
    }

    /// Somebody is at the wheel: the session file stays, whatever comes.
    pub(crate) fn keep_session(&mut self) {
        self.begun = None;
    }

    /// Stops it.
    ///
    /// # Errors
    /// When not everything was kept that was to be.
    pub(crate) fn close(mut self) -> anyhow::Result<()> {
        let server = self.server.take().expect("the server is taken only when the studio is closed or dropped");
        let losses = self.runtime.block_on(server.stop());
        ensure!(losses.is_none(), "{losses}");
        if let Some(path) = self.last_pot() {
            say!("the pot that was pressed last is kept:  {}", path.display());
        }
        Ok(())
    }

    fn server(&self) -> &Server {
        self.server.as_ref().expect("the server is taken only when the studio is closed or dropped")
    }

    /// How to join from this machine.
    pub(crate) fn target(&self) -> Target {
        let port = self.server().address().port();
        let ip = match self.server().address().ip() {
            ip if ip.is_unspecified() => IpAddr::from([127, 0, 0, 1]),
            ip => ip,
        };
        Target::new(SocketAddr::new(ip, port).to_string(), self.server().code().clone(), 1)
    }

    /// The same for whoever hosts, who teaches.
    pub(crate) fn teachers_target(&self) -> Target {
        Target { teacher: self.server().teacher_token().copied(), ..self.target() }
    }

    /// The address that people on the same network type.
    pub(crate) fn public_address(&self) -> SocketAddr {
        let address = self.server().address();
        if address.ip().is_unspecified() { SocketAddr::new(own_ip(), address.port()) } else { address }
    }

    pub(crate) fn standing(&self) -> anyhow::Result<Standing> {
        Ok(self.runtime.block_on(self.server().standing())?)
    }
}

impl Drop for Studio {
    fn drop(&mut self) {
        if let Some(server) = self.server.take() {
            self.runtime.block_on(server.stop());
        }
        if let Some(path) = &self.begun {
            take_away(path);
        }
    }
}

/// Takes a file away of a start that came to nothing, if it came to the file.
fn take_away(path: &Path) {
    if let Err(error) = fs::remove_file(path)
        && error.kind() != ErrorKind::NotFound
    {
        note!("{} is left behind: {error}", path.display());
    }
}

/// A runtime with one thread of that name: server and network have one each, so that neither waits for the other.
pub(crate) fn runtime(name: &'static str) -> anyhow::Result<Runtime> {
    tokio::runtime::Builder::new_multi_thread()
        .worker_threads(1)
        .thread_name(name)
        .enable_all()
        .build()
        .with_context(|| format!("no thread for the {name}"))
}

/// The address of the network that leads out of this machine; loopback when there is none. Sends nothing.
fn own_ip() -> IpAddr {
    let found = UdpSocket::bind(("0.0.0.0", 0)).and_then(|socket| {
        // connecting a UDP socket only chooses a route; the address is one reserved for documentation
        socket.connect(("192.0.2.1", 9))?;
        socket.local_addr()
    });
    found.map_or(IpAddr::from([127, 0, 0, 1]), |address| address.ip())
}
