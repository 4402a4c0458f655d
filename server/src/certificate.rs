//! The server's own certificate: self-signed, known by its fingerprint.
//!
//! Kept in the data folder, where there is one, so that whoever trusted it once knows it again; else fresh at each start.
//! Invariant: the fingerprint is that of the certificate served, and nobody but the server's user may read the key.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::Path;

use pottery_files::whole_file::write_whole;
use rustls::crypto::ring::sign::any_supported_type;
use rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};

use crate::ServerError;
use crate::folder::write_private;

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
    /// [`ServerError::Certificate`] when the system gives no randomness, [`ServerError::Key`] when what is kept cannot be used.
    pub fn kept_in(folder: &Path) -> Result<Self, ServerError> {
        let (key, certificate) = (folder.join(KEY), folder.join(CERTIFICATE));
        let unusable = |path: &Path, reason: String| ServerError::Key { path: path.to_path_buf(), reason };
        let read = |path: &Path| match fs::read(path) {
            Ok(bytes) => Ok(Some(bytes)),
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(unusable(path, error.to_string())),
        };
        match (read(&key)?, read(&certificate)?) {
            (Some(bytes), Some(der)) => {
                let kept = Self { der: der.into(), key: PrivateKeyDer::Pkcs8(PrivatePkcs8KeyDer::from(bytes)) };
                any_supported_type(&kept.key).map_err(|error| unusable(&key, error.to_string()))?;
                kept.tls().map_err(|error| unusable(&certificate, error.to_string()))?;
                Ok(kept)
            }
            (Some(_), None) => Err(unusable(&certificate, format!("it is missing, and {KEY} is there"))),
            (None, Some(_)) => Err(unusable(&key, format!("it is missing, and {CERTIFICATE} is there"))),
            (None, None) => {
                let fresh = Self::fresh()?;
                if let Err(reason) = fresh.keep(folder, &key, &certificate) {
                    tracing::warn!(
                        "the server's key is good for this run only, and will be another at the next: {reason}"
                    );
                    // neither without the other, and a file that is not there need not go
                    for path in [key, certificate] {
                        drop(fs::remove_file(path));
                    }
                }
                Ok(fresh)
            }
        }
    }

    fn keep(&self, folder: &Path, key: &Path, certificate: &Path) -> Result<(), String> {
        fs::create_dir_all(folder).map_err(|error| error.to_string())?;
        write_private(key, self.key.secret_der())?;
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
        self.tls().map_err(|error| ServerError::Certificate { reason: error.to_string() })
    }

    fn tls(&self) -> Result<rustls::ServerConfig, rustls::Error> {
        let provider = std::sync::Arc::new(rustls::crypto::ring::default_provider());
        let mut tls = rustls::ServerConfig::builder_with_provider(provider)
            .with_protocol_versions(&[&rustls::version::TLS13])?
            .with_no_client_auth()
            .with_single_cert(vec![self.der.clone()], self.key.clone_key())?;
        tls.alpn_protocols = vec![pottery_shared::protocol::ALPN.to_vec()];
        Ok(tls)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_that_is_damaged_or_alone_is_named_and_left_as_it_is() {
        let folder = std::env::temp_dir().join(format!("pottery-key-{}", std::process::id()));
        let kept = Certificate::kept_in(&folder).expect("a new folder can be made");
        let same = Certificate::kept_in(&folder).expect("it was written a moment ago");
        assert_eq!(kept.sha256(), same.sha256());
        for (name, other) in [(KEY, CERTIFICATE), (CERTIFICATE, KEY)] {
            let path = folder.join(name);
            let whole = fs::read(&path).expect("it is kept");
            let refused = || {
                let said = Certificate::kept_in(&folder).expect_err("it cannot be used").to_string();
                assert!(said.contains(&*path.to_string_lossy()) && said.contains("trust a new key"), "{said}");
            };
            for damaged in [&b""[..], b"otter", &whole[..whole.len() / 2]] {
                fs::write(&path, damaged).expect("there is room");
                refused();
                assert_eq!(fs::read(&path).expect("it is there"), damaged);
            }
            fs::remove_file(&path).expect("it is there");
            refused();
            assert!(!path.exists() && folder.join(other).exists());
            fs::write(&path, whole).expect("there is room");
        }
        let foreign = Certificate::fresh().expect("there is randomness");
        fs::write(folder.join(CERTIFICATE), &foreign.der).expect("there is room");
        let said = Certificate::kept_in(&folder).expect_err("they do not belong to each other").to_string();
        assert!(said.contains(CERTIFICATE), "{said}");
        fs::remove_dir_all(folder).expect("what was made can be removed");
    }
}
