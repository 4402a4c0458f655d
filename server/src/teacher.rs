//! The teacher's token: made once, shown once, and kept as a hash.
//!
//! Owns the file that holds the hash; who may do what with the token is the room's affair.
//! Invariant: the token itself is never written anywhere.

use std::fs;
use std::io::{ErrorKind, Write as _};
use std::path::Path;

use data_encoding::{HEXLOWER, HEXLOWER_PERMISSIVE};
use pottery_files::whole_file::write_whole;
use pottery_shared::protocol::TeacherToken;
use pottery_shared::room::{TokenHash, token_hash};

use crate::ServerError;
use crate::server::random;

/// The file in the data folder.
const FILE: &str = "teacher-token.sha256";

/// A hash, and the token while it is new.
#[derive(Debug)]
pub(crate) struct Teacher {
    hash: TokenHash,
    token: Option<TeacherToken>,
}

impl Teacher {
    /// The token whose hash a folder keeps, or a new one where there is none or it is `renewed`; without a folder it is good for
    /// this run. A folder that takes nothing is said, and the lesson goes on.
    ///
    /// # Errors
    /// [`ServerError::Teacher`] when what is kept is no hash.
    pub(crate) fn of(folder: Option<&Path>, renewed: bool) -> Result<Self, ServerError> {
        let path = folder.map(|folder| folder.join(FILE));
        if let Some(path) = path.as_deref().filter(|_| !renewed) {
            let refused = |reason: String| ServerError::Teacher { path: path.to_path_buf(), reason };
            match fs::read_to_string(path) {
                Ok(text) => {
                    let bytes = HEXLOWER_PERMISSIVE.decode(text.trim().as_bytes()).ok();
                    let hash = bytes.and_then(|bytes| bytes.try_into().ok());
                    let hash = hash.ok_or_else(|| refused("it has not 64 hexadecimal digits".into()))?;
                    return Ok(Self { hash, token: None });
                }
                Err(error) if error.kind() == ErrorKind::NotFound => {}
                Err(error) => return Err(refused(error.to_string())),
            }
        }
        let token = TeacherToken(random()?);
        let hash = token_hash(&token.0);
        if let Some(path) = path
            && let Err(error) = write_whole(&path, |file| writeln!(file, "{}", HEXLOWER.encode(&hash)))
        {
            tracing::warn!("the teacher's token is good for this run only: {error}");
        }
        Ok(Self { hash, token: Some(token) })
    }

    pub(crate) const fn hash(&self) -> &TokenHash {
        &self.hash
    }

    /// The token, at the start at which it was made.
    pub(crate) const fn token(&self) -> Option<&TeacherToken> {
        self.token.as_ref()
    }
}
