//! A server over a network in memory, and the people who join it there.
//!
//! Owns how they are set up; who does what, and when, is the scenario's.
//! Invariant: all of it runs in virtual time and repeats from its seed.

use std::io;
use std::net::SocketAddr;
use std::sync::Arc;
use std::time::Duration;

use pottery_client::{JoinError, PotterOptions, Seat, Target};
use pottery_server::{Certificate, Server, ServerConfig, ServerError, server_config};
use tokio::time::Instant;

use crate::line::{BurstLoss, Quality};
use crate::network::Network;

/// Where the server is.
pub const SERVER: ([u8; 4], u16) = ([10, 0, 0, 1], 4747);

/// So many milliseconds.
#[must_use]
pub const fn ms(milliseconds: u64) -> Duration {
    Duration::from_millis(milliseconds)
}

/// 100 ± 40 ms each way and 5 % of the packets lost, most of them in bursts of a tenth of a second.
pub const BURSTS: Quality = Quality {
    latency: ms(60),
    jitter: ms(80),
    loss: BurstLoss { every: ms(1000), lasts: ms(100), in_burst: 0.5, otherwise: 0.005 },
    duplicates: 0.0,
    rate: None,
};

/// Runs to the end in virtual time: as fast as the machine can, and never waiting.
///
/// # Panics
/// When the system gives no runtime.
pub fn in_virtual_time<T>(scenario: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().start_paused(true).build();
    runtime.expect("a runtime of one thread needs nothing of the system").block_on(scenario)
}

/// Why a simulation cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum SimulationError {
    /// The network in memory gave no endpoint.
    #[error("the network in memory gives no endpoint: {0}")]
    Endpoint(#[from] io::Error),
    /// The server cannot be started; the message says what is in the way.
    #[error("the server cannot be started: {0}")]
    Server(#[from] ServerError),
}

/// A server and its network.
#[derive(Debug)]
pub struct Simulation {
    /// The network, with a line to everybody who has joined.
    pub network: Network,
    /// The server.
    pub server: Server,
    /// The server's tick 0.
    pub opened: Instant,
}

/// Somebody who has joined.
pub struct Joined {
    /// Whose line it is.
    pub address: SocketAddr,
    /// The client's end of the network.
    pub endpoint: quinn::Endpoint,
    /// The seat.
    pub seat: Seat,
}

impl Simulation {
    /// A server that has just been opened.
    ///
    /// # Errors
    /// [`SimulationError`].
    pub fn open(seed: u64, config: ServerConfig) -> Result<Self, SimulationError> {
        Self::open_over(seed, None, config)
    }

    /// The same, with another transport than the server's own, where there is one.
    ///
    /// # Errors
    /// [`SimulationError`].
    pub fn open_over(
        seed: u64,
        transport: Option<quinn::TransportConfig>,
        config: ServerConfig,
    ) -> Result<Self, SimulationError> {
        let network = Network::new(seed);
        let certificate = Certificate::fresh()?;
        let fingerprint = certificate.sha256();
        let mut quic = server_config(certificate)?;
        if let Some(transport) = transport {
            quic.transport_config(Arc::new(transport));
        }
        let endpoint = network.endpoint(SERVER.into(), Some(quic))?;
        let server = Server::start_on(endpoint, &fingerprint, config)?;
        Ok(Self { network, server, opened: Instant::now() })
    }

    /// Where a person of that number is.
    #[must_use]
    pub fn address_of(number: u8) -> SocketAddr {
        SocketAddr::from(([10, 0, 1, number], 40_000))
    }

    /// An endpoint for a person, over lines of their own.
    ///
    /// # Errors
    /// What quinn says.
    pub fn endpoint(&self, number: u8, up: Quality, down: Quality) -> io::Result<quinn::Endpoint> {
        let address = Self::address_of(number);
        self.network.connect(address, up, down);
        self.network.endpoint(address, None)
    }

    /// Where a person finds a wheel, from 1.
    #[must_use]
    pub fn target(&self, wheel: u16) -> Target {
        Target::new(SocketAddr::from(SERVER).to_string(), self.server.code().clone(), wheel)
    }

    /// Lets a person join a wheel over lines of their own.
    ///
    /// # Errors
    /// [`JoinError`].
    pub async fn join(&self, number: u8, up: Quality, down: Quality, target: &Target) -> Result<Joined, JoinError> {
        let endpoint = self.endpoint(number, up, down);
        let endpoint = endpoint.map_err(|error| JoinError::Network { reason: error.to_string() })?;
        let seat = Seat::take(&endpoint, target, PotterOptions::default()).await?;
        Ok(Joined { address: Self::address_of(number), endpoint, seat })
    }
}
