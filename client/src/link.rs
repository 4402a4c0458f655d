//! A link that says all there is to know to join: where, with which code, at which wheel.
//!
//! Owns how it is written and read; opens nothing.
//! Invariant: a link that was written reads back as the same target.

use std::fmt;
use std::str::FromStr;

use pottery_shared::protocol::{JoinCode, JoinCodeError};

use crate::Target;

/// What a link begins with.
const SCHEME: &str = "pottery://";

/// A target as a link: `pottery://192.168.1.20:4747/K7QM3XPD9FTR2HWN8CVB4GJM`, with `?wheel=2` for another wheel than the first.
///
/// ```
/// use pottery_client::Link;
///
/// let link: Link = "pottery://192.168.1.20:4747/k7qm-3xpd?wheel=2".parse()?;
/// assert_eq!((link.0.address.as_str(), link.0.wheel), ("192.168.1.20:4747", 2));
/// assert_eq!(link.to_string(), "pottery://192.168.1.20:4747/K7QM3XPD?wheel=2");
/// # Ok::<(), pottery_client::LinkError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Link(pub Target);

/// Why a text is no link to a studio.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// It begins otherwise.
    #[error("a link to a studio begins with {SCHEME}")]
    Scheme,
    /// There is no address, or no code after it.
    #[error("a link to a studio has an address and, after a stroke, its code: {SCHEME}192.168.1.20:4747/K7QM3XPD")]
    Parts,
    /// The code is none.
    #[error("the link's code cannot be: {0}")]
    Code(#[from] JoinCodeError),
    /// Something else is asked for than a wheel.
    #[error("'{0}' in the link says nothing: after the code there may be ?wheel= and a number from 1")]
    Query(String),
}

impl Link {
    /// Whether a text is meant to be one.
    #[must_use]
    pub fn is_meant(text: &str) -> bool {
        text.trim().starts_with(SCHEME)
    }
}

impl fmt::Display for Link {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Target { address, code, wheel } = &self.0;
        write!(f, "{SCHEME}{address}/{}", code.to_string().replace('-', ""))?;
        if *wheel == 1 { Ok(()) } else { write!(f, "?wheel={wheel}") }
    }
}

impl FromStr for Link {
    type Err = LinkError;

    fn from_str(text: &str) -> Result<Self, LinkError> {
        let rest = text.trim().strip_prefix(SCHEME).ok_or(LinkError::Scheme)?;
        let (address, rest) = rest.split_once('/').ok_or(LinkError::Parts)?;
        let (code, query) = rest.split_once('?').unwrap_or((rest, ""));
        if address.is_empty() || code.is_empty() {
            return Err(LinkError::Parts);
        }
        let code: JoinCode = code.parse()?;
        let wheel = match query {
            "" => 1,
            _ => query
                .strip_prefix("wheel=")
                .and_then(|number| number.parse().ok())
                .filter(|wheel| *wheel > 0)
                .ok_or_else(|| LinkError::Query(query.to_owned()))?,
        };
        Ok(Self(Target { address: address.to_owned(), code, wheel }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        for wheel in [1, 2, 250] {
            for address in ["192.168.1.20:4747", "[2001:db8::1]:4747", "studio.example"] {
                let code = JoinCode::new([1, 2, 3, 4, 5], &[7; 32]);
                let link = Link(Target { address: address.to_owned(), code, wheel });
                assert_eq!(link.to_string().parse::<Link>(), Ok(link));
            }
        }
    }

    #[test]
    fn what_is_no_link_is_told_why() {
        for (text, word) in [
            ("https://studio.example/K7QM3XPD", "pottery://"),
            ("pottery://studio.example", "address"),
            ("pottery:///K7QM3XPD", "address"),
            ("pottery://studio.example/", "address"),
            ("pottery://studio.example/K7QM", "8 or 24"),
            ("pottery://studio.example/K7QM3XPD?wheel=0", "wheel=0"),
            ("pottery://studio.example/K7QM3XPD?room=2", "room=2"),
        ] {
            let said = text.parse::<Link>().expect_err(text).to_string();
            assert!(said.contains(word), "{text}: {said}");
        }
    }
}
