//! The QUIC endpoint of a client, and whom it trusts.
//!
//! A server shows a self-signed certificate; it is known by the fingerprint in the join code.
//! Invariant: the handshake's signature is always checked, so a copied certificate without its key opens nothing.

use std::net::{Ipv6Addr, SocketAddr};
use std::sync::Arc;
use std::time::Duration;

use pottery_shared::protocol::JoinCode;
use quinn::crypto::rustls::QuicClientConfig;
use quinn::{IdleTimeout, TransportConfig, VarInt};
use rustls::client::danger::{HandshakeSignatureValid, ServerCertVerified, ServerCertVerifier};
use rustls::crypto::CryptoProvider;
use rustls::pki_types::{CertificateDer, ServerName, UnixTime};
use rustls::{CertificateError, DigitallySignedStruct, SignatureScheme};

use crate::JoinError;

/// What a way and back is taken to be before it is known: a handshake of which something is lost is tried again after three
/// of them, where the default waits for a second and then for two, which a person takes for a studio that is not there.
const INITIAL_RTT: Duration = Duration::from_millis(100);

/// Name under which servers are addressed in the handshake; the fingerprint is what counts.
pub(crate) const SERVER_NAME: &str = "pottery-studio";

/// Round trips that are believed before one was measured: quinn's own is the longest.
const ROUND_TRIPS: (Duration, Duration) = (Duration::from_millis(20), Duration::from_millis(333));

/// An endpoint on any free port, for addresses of both kinds where the system has both.
///
/// Call it within a tokio runtime.
///
/// # Errors
/// [`JoinError::Network`] when the system gives no socket.
pub fn endpoint() -> Result<quinn::Endpoint, JoinError> {
    quinn::Endpoint::client(SocketAddr::from((Ipv6Addr::UNSPECIFIED, 0)))
        .or_else(|_| quinn::Endpoint::client(SocketAddr::from(([0, 0, 0, 0], 0))))
        .map_err(|source| JoinError::Network { reason: source.to_string() })
}

/// The QUIC configuration that trusts the server of `code`, or any when the code names none.
///
/// # Errors
/// [`JoinError::Network`] when the cryptography is not to be had.
pub fn client_config(code: &JoinCode) -> Result<quinn::ClientConfig, JoinError> {
    config_for(code, None, None)
}

/// The same; a code that names no server trusts the one that is `known`, where there is one, and what gets no answer is sent
/// again as soon as an earlier round trip suggests.
pub(crate) fn config_for(
    code: &JoinCode,
    known: Option<[u8; 32]>,
    round_trip: Option<Duration>,
) -> Result<quinn::ClientConfig, JoinError> {
    let network = |reason: String| JoinError::Network { reason };
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let print = code.print().map(|print| print.to_vec()).or_else(|| known.map(|known| known.to_vec()));
    let verifier = Arc::new(Fingerprint { print, provider: Arc::clone(&provider) });
    let mut tls = rustls::ClientConfig::builder_with_provider(provider)
        .with_protocol_versions(&[&rustls::version::TLS13])
        .map_err(|error| network(error.to_string()))?
        .dangerous()
        .with_custom_certificate_verifier(verifier)
        .with_no_client_auth();
    tls.alpn_protocols = vec![pottery_shared::protocol::ALPN.to_vec()];
    let crypto = QuicClientConfig::try_from(tls).map_err(|error| network(error.to_string()))?;
    let mut transport = TransportConfig::default();
    transport
        .max_concurrent_bidi_streams(VarInt::from_u32(0))
        // keyframes, one after the other
        .max_concurrent_uni_streams(VarInt::from_u32(4))
        .datagram_receive_buffer_size(Some(256 * 1024))
        // what waits longer is repeated in the next datagram anyway
        .datagram_send_buffer_size(4 * 1024)
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
        .initial_rtt(INITIAL_RTT);
    if let Some(round_trip) = round_trip {
        transport.initial_rtt(round_trip.clamp(ROUND_TRIPS.0, ROUND_TRIPS.1));
    }
    let mut config = quinn::ClientConfig::new(Arc::new(crypto));
    config.transport_config(Arc::new(transport));
    Ok(config)
}

/// SHA-256 of the certificate that the other end showed.
pub(crate) fn fingerprint_of(connection: &quinn::Connection) -> Option<[u8; 32]> {
    let shown = connection.peer_identity()?.downcast::<Vec<CertificateDer<'static>>>().ok()?;
    ring::digest::digest(&ring::digest::SHA256, shown.first()?).as_ref().try_into().ok()
}

/// Trusts the certificate whose SHA-256 begins with these bytes.
#[derive(Debug)]
struct Fingerprint {
    print: Option<Vec<u8>>,
    provider: Arc<CryptoProvider>,
}

impl ServerCertVerifier for Fingerprint {
    fn verify_server_cert(
        &self,
        end_entity: &CertificateDer<'_>,
        _: &[CertificateDer<'_>],
        _: &ServerName<'_>,
        _: &[u8],
        _: UnixTime,
    ) -> Result<ServerCertVerified, rustls::Error> {
        let digest = ring::digest::digest(&ring::digest::SHA256, end_entity);
        match &self.print {
            Some(print) if !digest.as_ref().starts_with(print) => {
                Err(rustls::Error::InvalidCertificate(CertificateError::ApplicationVerificationFailure))
            }
            _ => Ok(ServerCertVerified::assertion()),
        }
    }

    fn verify_tls12_signature(
        &self,
        _: &[u8],
        _: &CertificateDer<'_>,
        _: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        Err(rustls::Error::General("QUIC has no TLS 1.2".into()))
    }

    fn verify_tls13_signature(
        &self,
        message: &[u8],
        certificate: &CertificateDer<'_>,
        signature: &DigitallySignedStruct,
    ) -> Result<HandshakeSignatureValid, rustls::Error> {
        let algorithms = &self.provider.signature_verification_algorithms;
        rustls::crypto::verify_tls13_signature(message, certificate, signature, algorithms)
    }

    fn supported_verify_schemes(&self) -> Vec<SignatureScheme> {
        self.provider.signature_verification_algorithms.supported_schemes()
    }
}
