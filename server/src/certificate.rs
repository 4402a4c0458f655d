//! The server's own certificate: self-signed, known by its fingerprint.
//!
//! Knows no files: a fresh key each start, so that a code of yesterday opens nothing today.
//! Invariant: the fingerprint is that of the certificate served.

use rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};

use crate::ServerError;

/// A key and its certificate.
#[derive(Debug)]
pub struct Certificate {
    der: CertificateDer<'static>,
    key: PrivateKeyDer<'static>,
}

impl Certificate {
    /// A fresh self-signed P-256 certificate.
    ///
    /// # Errors
    /// [`ServerError::Certificate`] when the system gives no randomness.
    pub fn fresh() -> Result<Self, ServerError> {
        let made = rcgen::generate_simple_self_signed([String::from("pottery-studio")])
            .map_err(|error| ServerError::Certificate { reason: error.to_string() })?;
        let key = PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(made.signing_key.serialize_der()));
        Ok(Self { der: made.cert.into(), key })
    }

    /// SHA-256 of the certificate.
    ///
    /// # Panics
    /// Never: a SHA-256 has 32 bytes.
    #[must_use]
    pub fn sha256(&self) -> [u8; 32] {
        let digest = ring::digest::digest(&ring::digest::SHA256, &self.der);
        digest.as_ref().try_into().expect("a SHA-256 has 32 bytes")
    }

    /// The TLS configuration that serves it under the studio's protocol name.
    pub(crate) fn into_tls(self) -> Result<rustls::ServerConfig, ServerError> {
        let provider = std::sync::Arc::new(rustls::crypto::ring::default_provider());
        let mut tls = rustls::ServerConfig::builder_with_provider(provider)
            .with_protocol_versions(&[&rustls::version::TLS13])
            .and_then(|builder| builder.with_no_client_auth().with_single_cert(vec![self.der], self.key))
            .map_err(|error| ServerError::Certificate { reason: error.to_string() })?;
        tls.alpn_protocols = vec![pottery_shared::protocol::ALPN.to_vec()];
        Ok(tls)
    }
}
