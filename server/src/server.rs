//! A running server: start it, ask it, stop it.
//!
//! Owns the endpoint and the tasks; the room itself lives in the ticking task.
//! Invariant: after `stop` everybody was told, the tasks have ended and the port is free.

use std::io::ErrorKind;
use std::net::SocketAddr;
use std::path::PathBuf;
use std::time::Duration;

use pottery_shared::clay::Pot;
use pottery_shared::protocol::{JoinCode, TeacherToken};
use pottery_shared::room::{DoorConfig, RoomCounts};
use tokio::sync::{mpsc, oneshot};
use tokio::task::JoinHandle;

use crate::announcing::{Announcement, usual_name};
use crate::class_register::{ClassRegister, Left};
use crate::doorkeeper::SharedDoorkeeper;
use crate::event::Event;
use crate::folder::Folder;
use crate::recording::Recorder;
use crate::store::StoreError;
use crate::teacher::Teacher;
use crate::ticking::Ticking;
use crate::{Certificate, ConfigError, Figures, Losses, ServerConfig, connection, opening, operation, transport};

/// What helps where an address cannot be listened on.
const fn remedy(kind: ErrorKind) -> &'static str {
    match kind {
        ErrorKind::AddrInUse => "is another studio running? choose another port with --listen",
        ErrorKind::AddrNotAvailable => "give --listen an address of this machine, or [::] for all of them",
        ErrorKind::PermissionDenied => "choose a port above 1023 with --listen",
        _ => "choose another address with --listen",
    }
}

/// Why a server does not run.
#[derive(Debug, thiserror::Error)]
pub enum ServerError {
    /// The address cannot be had.
    #[error("cannot listen on {address} ({source}); {}", remedy(source.kind()))]
    Bind {
        /// Where.
        address: SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
    /// The endpoint cannot be made.
    #[error("the network cannot be used: {source}")]
    Endpoint {
        /// What the system said.
        source: std::io::Error,
    },
    /// The certificate cannot be made.
    #[error("no certificate could be made: {reason}")]
    Certificate {
        /// What the library said.
        reason: String,
    },
    /// The kept key or its certificate cannot be used.
    #[error(
        "{path} cannot be used ({reason}): put back what was there, or take server-key.der and server-certificate.der away, and everybody \
         will be asked to trust a new key"
    )]
    Key {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The session file cannot be begun.
    #[error(
        "the recording {path} cannot be begun ({source}): choose a file that does not exist yet, where one can be written"
    )]
    Recording {
        /// Which file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// The port for operators cannot be had.
    #[error("operators cannot be answered at {address} ({source}): choose another port with --operate")]
    Operate {
        /// Where.
        address: SocketAddr,
        /// What the system said.
        source: std::io::Error,
    },
    /// What is kept of the teacher's token is not.
    #[error("{path} is no hash of a teacher's token ({reason}): take the file away, or start with --new-teacher-token")]
    Teacher {
        /// Which file.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// The data folder cannot be used.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// The configuration makes no sense.
    #[error(transparent)]
    Config(#[from] ConfigError),
    /// The server has stopped.
    #[error("the server has stopped")]
    Stopped,
}

/// How a server stands at a moment.
#[derive(Clone, Debug)]
pub struct Standing {
    /// Ticks done.
    pub ticks: u64,
    /// People who are in.
    pub people: usize,
    /// Digest of each wheel's newest snapshot.
    pub digests: Vec<u64>,
    /// The clay on each wheel.
    pub pots: Vec<Pot>,
    /// What the room counted.
    pub counts: RoomCounts,
    /// Datagrams that a connection could not take at once.
    pub dropped_datagrams: u64,
    /// Times the room woke up later than it was to by more than 15 ms.
    pub late: u64,
}

/// A handle on a running server.
#[derive(Debug)]
pub struct Server {
    address: SocketAddr,
    code: JoinCode,
    teacher: Teacher,
    endpoint: quinn::Endpoint,
    events: mpsc::Sender<Event>,
    accepting: JoinHandle<()>,
    ticking: JoinHandle<Losses>,
    operating: Option<JoinHandle<()>>,
    operated_at: Option<SocketAddr>,
    announcement: Option<Announcement>,
}

impl Server {
    /// Listens and opens the room.
    ///
    /// # Errors
    /// [`ServerError`] saying what is in the way.
    pub fn start(config: ServerConfig) -> Result<Self, ServerError> {
        let config = config.checked()?;
        let folder = Self::folder(&config)?;
        let certificate = config.folder().map_or_else(Certificate::fresh, Certificate::kept_in)?;
        let fingerprint = certificate.sha256();
        let endpoint = transport::endpoint(transport::bind(config.listen)?, certificate)?;
        let (is_announced, wheels) = (config.is_announced, config.wheels);
        let class = config.class.clone().unwrap_or_else(|| usual_name(&fingerprint));
        let mut server = Self::open(endpoint, &fingerprint, config, folder)?;
        if is_announced {
            server.announcement = Announcement::begin(&class, server.address, wheels);
        }
        Ok(server)
    }

    /// Opens the room on an endpoint that exists already and serves the certificate of that fingerprint.
    ///
    /// # Errors
    /// [`ServerError`] saying what is in the way.
    pub fn start_on(
        endpoint: quinn::Endpoint,
        fingerprint: &[u8; 32],
        config: ServerConfig,
    ) -> Result<Self, ServerError> {
        let folder = Self::folder(&config)?;
        Self::open(endpoint, fingerprint, config, folder)
    }

    /// Holds the folder that pots go to, if they go to one.
    fn folder(config: &ServerConfig) -> Result<Option<Folder>, StoreError> {
        config.folder().map(Folder::hold).transpose()
    }

    fn open(
        endpoint: quinn::Endpoint,
        fingerprint: &[u8; 32],
        config: ServerConfig,
        folder: Option<Folder>,
    ) -> Result<Self, ServerError> {
        let address = endpoint.local_addr().map_err(|source| ServerError::Endpoint { source })?;
        let operating = config.operate.map(operation::listen).transpose()?;
        let operated_at = operating.as_ref().and_then(|listener| listener.local_addr().ok());
        let data = config.data.as_deref();
        let left = Left::of(&config);
        let code = match config.code.clone().or_else(|| left.as_ref()?.code()) {
            Some(code) => code.on_server(fingerprint),
            None => JoinCode::new(random()?, fingerprint),
        };
        let (mut room, store) = opening::open(&config, &code, folder)?;
        let code_ticks = config.code_hours.map(|hours| (hours * 3_600_000.0) as u64);
        let teacher = Teacher::of(data, config.renews_teacher)?;
        room.keep_doors(DoorConfig {
            secret: Some(random()?),
            teacher: Some(*teacher.hash()),
            code_ticks,
            has_lobby: config.has_lobby,
        });
        if let Some(left) = left {
            left.hand_over(&mut room, code_ticks);
        }
        let recorder = config
            .record
            .map(|path| Recorder::begin(&path, &mut room).map_err(|source| ServerError::Recording { path, source }))
            .transpose()?;
        let class_register = data.map(|folder| ClassRegister::begin(folder, &room));
        // bounded, so that a flood waits in the transport, which drops the oldest datagrams
        let (events, received) = mpsc::channel(1024);
        let doorkeeper = SharedDoorkeeper::new(config.arrivals, config.input);
        let ticking =
            tokio::spawn(Ticking::new(room, received, recorder, (store, class_register), doorkeeper.clone()).run());
        let accepting =
            tokio::spawn(connection::accept(endpoint.clone(), config.people_max, events.clone(), doorkeeper));
        let operating =
            operating.map(|listener| tokio::spawn(operation::serve(listener, events.clone(), *fingerprint)));
        tracing::info!(%address, wheels = config.wheels, "the studio is open");
        Ok(Self {
            address,
            code,
            teacher,
            endpoint,
            events,
            accepting,
            ticking,
            operating,
            operated_at,
            announcement: None,
        })
    }

    /// Where it listens.
    #[must_use]
    pub const fn address(&self) -> SocketAddr {
        self.address
    }

    /// Where operators on this machine ask how it is.
    #[must_use]
    pub const fn operated_at(&self) -> Option<SocketAddr> {
        self.operated_at
    }

    /// The code that lets people in at first; a teacher may change it.
    #[must_use]
    pub const fn code(&self) -> &JoinCode {
        &self.code
    }

    /// With what somebody teaches here, when it was made at this start: it is not kept, and not to be had later.
    #[must_use]
    pub const fn teacher_token(&self) -> Option<&TeacherToken> {
        self.teacher.token()
    }

    /// How it stands.
    ///
    /// # Errors
    /// [`ServerError::Stopped`] when it no longer runs.
    pub async fn standing(&self) -> Result<Standing, ServerError> {
        let (answer, answered) = oneshot::channel();
        self.events.send(Event::Standing(answer)).await.map_err(|_| ServerError::Stopped)?;
        answered.await.map_err(|_| ServerError::Stopped)
    }

    /// What it has counted since its start; unlike [`Server::standing`] it copies no clay, so that it may be asked often.
    ///
    /// # Errors
    /// [`ServerError::Stopped`] when it no longer runs.
    pub async fn figures(&self) -> Result<Figures, ServerError> {
        let (answer, answered) = oneshot::channel();
        self.events.send(Event::Figures(answer)).await.map_err(|_| ServerError::Stopped)?;
        answered.await.map_err(|_| ServerError::Stopped)
    }

    /// Waits until the room's task has ended by itself, which it does with a fault alone; [`Server::stop`] then says so.
    pub async fn ended(&self) {
        self.events.closed().await;
    }

    /// Tells everybody, waits until they heard it, and frees the port; what could not be kept, of which the log says why.
    pub async fn stop(mut self) -> Losses {
        if let Some(announcement) = self.announcement.take()
            && tokio::task::spawn_blocking(|| announcement.end()).await.is_err()
        {
            tracing::debug!("the announcement did not end well");
        }
        self.accepting.abort();
        if let Some(operating) = &self.operating {
            operating.abort();
        }
        // one that has ended hears nothing and says how it ended all the same
        drop(self.events.send(Event::Stop).await);
        let losses = self.ticking.await.unwrap_or_else(|error| {
            tracing::error!(%error, "the ticking task did not end well");
            Losses { has_failed: true, ..Losses::default() }
        });
        self.endpoint.close(0_u32.into(), b"the studio closes");
        if tokio::time::timeout(Duration::from_secs(2), self.endpoint.wait_idle()).await.is_err() {
            tracing::debug!("some peers did not confirm the end");
        }
        drop(self.endpoint);
        if tokio::time::timeout(Duration::from_secs(1), port_is_free(self.address)).await.is_err() {
            tracing::info!(address = %self.address, "the port is still taken");
        }
        tracing::info!("the studio is closed");
        losses
    }
}

/// Resolves once nothing listens there: quinn's driver lets go of the socket some time after the endpoint is dropped.
async fn port_is_free(address: SocketAddr) {
    let is_taken = |error: std::io::Error| error.kind() == std::io::ErrorKind::AddrInUse;
    while std::net::UdpSocket::bind(address).is_err_and(is_taken) {
        tokio::time::sleep(Duration::from_millis(1)).await;
    }
}

/// Bits that nobody can foretell.
///
/// # Errors
/// [`ServerError::Certificate`] when the system has none.
pub(crate) fn random<const N: usize>() -> Result<[u8; N], ServerError> {
    use ring::rand::{SecureRandom, SystemRandom};
    let mut random = [0_u8; N];
    SystemRandom::new()
        .fill(&mut random)
        .map_err(|_| ServerError::Certificate { reason: "the system gives no randomness".into() })?;
    Ok(random)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_room_that_ends_by_itself_is_noticed_and_told() {
        let listen = SocketAddr::from(([127, 0, 0, 1], 0));
        let server =
            Server::start(ServerConfig { listen, ..ServerConfig::default() }).expect("this machine has a port");
        assert!(tokio::time::timeout(Duration::from_millis(20), server.ended()).await.is_err(), "it runs");
        // as a fault in it would
        server.ticking.abort();
        server.ended().await;
        let losses = server.stop().await;
        assert!(losses.has_failed, "{losses:?}");
    }
}
