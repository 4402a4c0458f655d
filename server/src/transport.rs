//! The QUIC endpoint of the server.
//!
//! Owns sockets' and connections' settings, with the reason for each; knows no room.
//! Invariant: memory a peer can make the transport hold is bounded (`bounds`).

use std::io::ErrorKind;
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use quinn::{IdleTimeout, TransportConfig, VarInt};
use socket2::{Domain, Protocol, Socket, Type};

use crate::{Certificate, ServerError, bounds};

/// Socket buffer asked for: a second of a class's samples, should the tick be late.
const RECEIVE_BUFFER_BYTES: usize = 4 << 20;

/// Reads an address to listen on or to connect to: an IP address with its port.
///
/// # Errors
/// A sentence that says how one is written.
pub fn address(text: &str) -> Result<SocketAddr, String> {
    text.parse().map_err(|_| "give an IP address and a port, such as 127.0.0.1:5000 or [::]:4747".into())
}

/// A UDP socket on `address` with a large receive buffer.
///
/// # Errors
/// [`ServerError::Bind`] when the address cannot be had.
pub fn bind(address: SocketAddr) -> Result<std::net::UdpSocket, ServerError> {
    let bound = |address: SocketAddr| -> std::io::Result<std::net::UdpSocket> {
        let socket = Socket::new(Domain::for_address(address), Type::DGRAM, Some(Protocol::UDP))?;
        if address.is_ipv6() {
            socket.set_only_v6(false)?;
        }
        // what the system grants is enough for a small class, so a refusal is no error
        if let Err(error) = socket.set_recv_buffer_size(RECEIVE_BUFFER_BYTES) {
            tracing::debug!(%error, "receive buffer stays at the system's size");
        }
        socket.bind(&address.into())?;
        Ok(socket.into())
    };
    bound(address)
        .or_else(|error| match error.kind() {
            // a system without IPv6 still has all its IPv4 networks
            ErrorKind::Unsupported | ErrorKind::AddrNotAvailable if address == on_all_networks(address.port()) => {
                bound(SocketAddr::from((Ipv4Addr::UNSPECIFIED, address.port())))
            }
            _ => Err(error),
        })
        .map_err(|source| ServerError::Bind { address, source })
}

/// Every network of both kinds.
fn on_all_networks(port: u16) -> SocketAddr {
    SocketAddr::from((Ipv6Addr::UNSPECIFIED, port))
}

/// An endpoint that serves `certificate` on `socket`.
///
/// Call it within a tokio runtime.
///
/// # Errors
/// [`ServerError::Certificate`] or [`ServerError::Endpoint`].
pub fn endpoint(socket: std::net::UdpSocket, certificate: Certificate) -> Result<quinn::Endpoint, ServerError> {
    let config = server_config(certificate)?;
    let runtime = Arc::new(quinn::TokioRuntime);
    sending_together(socket, runtime.as_ref())
        .and_then(|socket| {
            quinn::Endpoint::new_with_abstract_socket(quinn::EndpointConfig::default(), Some(config), socket, runtime)
        })
        .map_err(|source| ServerError::Endpoint { source })
}

/// The socket in quinn's hands; where the system takes datagrams to many addresses in one call, they are given to it so.
fn sending_together(
    socket: std::net::UdpSocket,
    runtime: &dyn quinn::Runtime,
) -> std::io::Result<Arc<dyn quinn::AsyncUdpSocket>> {
    #[cfg(target_os = "linux")]
    {
        let many = socket.try_clone()?;
        Ok(Arc::new(crate::batching::Batching::new(runtime.wrap_udp_socket(socket)?, many)))
    }
    #[cfg(not(target_os = "linux"))]
    runtime.wrap_udp_socket(socket)
}

/// The QUIC configuration of the server, also for endpoints on other sockets than the system's.
///
/// # Errors
/// [`ServerError::Certificate`].
pub fn server_config(certificate: Certificate) -> Result<quinn::ServerConfig, ServerError> {
    let tls = quinn::crypto::rustls::QuicServerConfig::try_from(certificate.into_tls()?)
        .map_err(|error| ServerError::Certificate { reason: error.to_string() })?;
    let mut transport = TransportConfig::default();
    transport
        // one control stream from each client, and none without being asked
        .max_concurrent_bidi_streams(VarInt::from_u32(1))
        .max_concurrent_uni_streams(VarInt::from_u32(0))
        .stream_receive_window(VarInt::from_u32(bounds::STREAM_RECEIVED as u32))
        .receive_window(VarInt::from_u32(bounds::STREAMS_RECEIVED as u32))
        .send_window(bounds::STREAMS_SENT as u64)
        .datagram_receive_buffer_size(Some(bounds::DATAGRAMS_RECEIVED))
        .datagram_send_buffer_size(bounds::DATAGRAMS_SENT)
        // Cubic takes each loss for a queue: over two continents with 1 % of loss it starved the clay, and after a
        // partition of 3 s it took 6 s to recover where this takes 2. Whatever is lost, this one's window stays at four packets
        // or more, where Cubic's falls to two: a pulse and what is said again with it, so that a line that loses much is still
        // told what happened, and the pace is the application's to choose
        .congestion_controller_factory(Arc::new(quinn::congestion::BbrConfig::default()))
        // reordering is no loss
        .packet_threshold(16)
        .time_threshold(2.0)
        .max_idle_timeout(Some(IdleTimeout::from(VarInt::from_u32(10_000))))
        .keep_alive_interval(Some(Duration::from_secs(3)))
        // a handshake of which something is lost is tried again after three times this, as at the client's end
        .initial_rtt(Duration::from_millis(100));
    let mut config = quinn::ServerConfig::with_crypto(Arc::new(tls));
    config.transport_config(Arc::new(transport)).max_incoming(256);
    Ok(config)
}
