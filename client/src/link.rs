//! A link that says all there is to know to join: where, with which code, at which wheel.
//!
//! Owns how it is written and read; opens nothing.
//! Invariant: a link that was written reads back as the same target.

use std::fmt;
use std::str::FromStr;

use pottery_shared::protocol::{JoinCode, JoinCodeError, TokenError};

use crate::Target;

/// What a link begins with.
const SCHEME: &str = "pottery://";

/// A target as a link: `pottery://192.168.1.20:4747/K7QM3XPD9FTR2HWN8CVB4GJM`, with `?wheel=2` for another wheel than the first, and
/// `?teacher=` and the token for who teaches.
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
    /// The teacher's token is none.
    #[error("the link's token cannot be: {0}")]
    Token(#[from] TokenError),
    /// Something else is asked for than a wheel.
    #[error(
        "'{0}' in the link says nothing: after the code there may be ?wheel= and a number from 1, and &teacher= and a token"
    )]
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
        let Target { address, code, wheel, teacher, .. } = &self.0;
        write!(f, "{SCHEME}{address}/{}", code.to_string().replace('-', ""))?;
        let wheel = (*wheel != 1).then(|| format!("wheel={wheel}"));
        let teacher = teacher.map(|token| format!("teacher={}", token.to_string().replace('-', "")));
        for (at, part) in wheel.into_iter().chain(teacher).enumerate() {
            write!(f, "{}{part}", if at == 0 { '?' } else { '&' })?;
        }
        Ok(())
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
        let mut target = Target::new(address.to_owned(), code, 1);
        for part in query.split('&').filter(|part| !part.is_empty()) {
            if let Some(token) = part.strip_prefix("teacher=") {
                target.teacher = Some(token.parse()?);
                continue;
            }
            let number = part.strip_prefix("wheel=").and_then(|number| number.parse().ok()).filter(|wheel| *wheel > 0);
            target.wheel = number.ok_or_else(|| LinkError::Query(part.to_owned()))?;
        }
        Ok(Self(target))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use pottery_shared::protocol::TeacherToken;

    #[test]
    fn what_is_written_is_read_again() {
        for wheel in [1, 2, 250] {
            for address in ["192.168.1.20:4747", "[2001:db8::1]:4747", "studio.example"] {
                let code = JoinCode::new([1, 2, 3, 4, 5], &[7; 32]);
                let mut link = Link(Target::new(address.to_owned(), code, wheel));
                assert_eq!(link.to_string().parse::<Link>(), Ok(link.clone()));
                link.0.teacher = Some(TeacherToken([0xa5; 32]));
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
            ("pottery://studio.example/K7QM3XPD?teacher=K7QM", "52"),
        ] {
            let said = text.parse::<Link>().expect_err(text).to_string();
            assert!(said.contains(word), "{text}: {said}");
        }
    }
}
