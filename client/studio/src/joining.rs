//! Which studio to join when no address was typed: what announces itself on the local network.
//!
//! Owns the choice and how the list is shown; listening is the client library's.
//! Invariant: a studio is chosen only when there is no other and its code was given.

use std::time::Duration;

use anyhow::bail;
use pottery_client::{Found, find};

/// How long it listens: those who are there answer within a second.
const LISTENS_FOR: Duration = Duration::from_secs(3);

/// Where to go.
#[derive(Debug)]
pub(crate) enum Where {
    /// There.
    At(String),
    /// The person chooses among these.
    Among(Vec<Found>),
}

/// The address that was typed, or that of the only studio there is when its code was given.
pub(crate) fn look(typed: Option<&str>, has_code: bool) -> anyhow::Result<Where> {
    if let Some(typed) = typed {
        return Ok(Where::At(typed.to_owned()));
    }
    let found = find(LISTENS_FOR)?;
    if found.is_empty() {
        bail!("no studio announces itself on this network; join with the address that its host shows");
    }
    match found.as_slice() {
        [only] if has_code => Ok(Where::At(only.address.to_string())),
        _ => Ok(Where::Among(found)),
    }
}

/// Shows what was found, one in a line.
pub(crate) fn tell(found: &[Found]) {
    for Found { class, address, wheels, is_of_this_version } in found {
        let wheels = match wheels {
            None => String::new(),
            Some(1) => "1 wheel".into(),
            Some(many) => format!("{many} wheels"),
        };
        let version = if *is_of_this_version { "" } else { "  (another version of the studio)" };
        say!("{class:<24} {:<28} {wheels:<10}{version}", address.to_string());
    }
    say!("join one with:  pottery-studio join ADDRESS --code CODE");
}
