//! The embedded server: the same as the stand-alone one, on a runtime of its own.
//!
//! Invariant: dropping the studio stops it.

use std::net::{IpAddr, SocketAddr, UdpSocket};

use anyhow::Context;
use pottery_client::Target;
use pottery_server::{Server, ServerConfig, Standing};
use tokio::runtime::Runtime;

/// A server that lives as long as this value.
#[derive(Debug)]
pub(crate) struct Studio {
    runtime: Runtime,
    server: Option<Server>,
}

impl Studio {
    pub(crate) fn open(config: ServerConfig) -> anyhow::Result<Self> {
        let runtime = runtime("server")?;
        let server = runtime.block_on(async { Server::start(config) })?;
        Ok(Self { runtime, server: Some(server) })
    }

    fn server(&self) -> &Server {
        self.server.as_ref().expect("the server is taken only when the studio is dropped")
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
