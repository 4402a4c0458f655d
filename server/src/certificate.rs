//! The server's own certificate: self-signed, known by its fingerprint.
//!
//! Kept in the data folder, where there is one, so that whoever trusted it once knows it again; else fresh at each start.
//! Invariant: the fingerprint is that of the certificate served, and nobody but the server's user may read the key.

use std::fs::{self, OpenOptions};
use std::io::{ErrorKind, Write};
use std::path::Path;

use pottery_files::whole_file::write_whole;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};

use crate::ServerError;

/// The files in the data folder.
const KEY: &str = "server-key.der";
const CERTIFICATE: &str = "server-certificate.der";

/// A key and its certificate.
#[derive(Debug)]
pub struct Certificate {
    der: CertificateDer<'static>,
    key: PrivateKeyDer<'static>,
}

impl Certificate {
    /// A fresh self-signed Ed25519 certificate: all of its signatures are of one length, so that a network in memory carries the same bytes at
    /// the same times whatever the key is.
    ///
    /// # Errors
    /// [`ServerError::Certificate`] when the system gives no randomness.
    pub fn fresh() -> Result<Self, ServerError> {
        let refused = |error: rcgen::Error| ServerError::Certificate { reason: error.to_string() };
        let pair = rcgen::KeyPair::generate_for(&rcgen::PKCS_ED25519).map_err(refused)?;
        let certificate = rcgen::CertificateParams::new([String::from("pottery-studio")])
            .and_then(|parameters| parameters.self_signed(&pair))
            .map_err(refused)?;
        let key = PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(pair.serialize_der()));
        Ok(Self { der: certificate.into(), key })
    }

    /// The one that a folder keeps, or a fresh one that is kept there from now on. A folder that takes nothing is said, and the
    /// lesson goes on.
    ///
    /// # Errors
    /// [`ServerError::Certificate`] when the system gives no randomness, or what is kept cannot be read.
    pub fn kept_in(folder: &Path) -> Result<Self, ServerError> {
        let (key, certificate) = (folder.join(KEY), folder.join(CERTIFICATE));
        let unreadable = |path: &Path, error: &dyn std::fmt::Display| ServerError::Certificate {
            reason: format!(
                "{} cannot be read ({error}); take {KEY} and {CERTIFICATE} away, and everybody will be asked to trust a new key",
                path.display()
            ),
        };
        match (fs::read(&key), fs::read(&certificate)) {
            (Ok(key), Ok(der)) => {
                let key = PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(key));
                return Ok(Self { der: der.into(), key });
            }
            (Err(error), _) if error.kind() != ErrorKind::NotFound => return Err(unreadable(&key, &error)),
            (_, Err(error)) if error.kind() != ErrorKind::NotFound => return Err(unreadable(&certificate, &error)),
            _ => {}
        }
        let fresh = Self::fresh()?;
        if let Err(reason) = fresh.keep(folder, &key, &certificate) {
            tracing::warn!("the server's key is good for this run only, and will be another at the next: {reason}");
        }
        Ok(fresh)
    }

    fn keep(&self, folder: &Path, key: &Path, certificate: &Path) -> Result<(), String> {
        let mut options = OpenOptions::new();
        options.write(true).create(true).truncate(true);
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
        // an empty file of its own first, whose permissions stay
        fs::create_dir_all(folder).and_then(|()| options.open(key)).map_err(|error| error.to_string())?;
        write_whole(key, |file| file.write_all(self.key.secret_der())).map_err(|error| error.to_string())?;
        write_whole(certificate, |file| file.write_all(&self.der)).map_err(|error| error.to_string())
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
