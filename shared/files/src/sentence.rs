//! How it is said what went wrong: one sentence of an error and of those that it came from.
//!
//! Owns how they are joined; the words are the errors' own, and where they are said is the programs' affair.
//! Invariant: nothing is said twice.

use std::error::Error;

/// An error and its sources in one sentence, from what could not be done to why.
///
/// Some errors name their source in words of their own: what has been said is left out, and what a source says better is left to it.
///
/// ```
/// use pottery_files::sentence::sentence;
///
/// #[derive(Debug, thiserror::Error)]
/// enum Fault {
///     #[error("lead.pot cannot be read: {0}")]
///     Read(#[from] std::io::Error),
/// }
///
/// let fault = Fault::from(std::io::Error::other("the disk is gone"));
/// assert_eq!(sentence(&fault), "lead.pot cannot be read: the disk is gone");
/// ```
#[must_use]
pub fn sentence(error: &(dyn Error + 'static)) -> String {
    let mut said = String::new();
    for part in core::iter::successors(Some(error), |&error| error.source()) {
        let part = part.to_string();
        if part.contains(&said) {
            said = part;
        } else if !said.contains(&part) {
            said = format!("{said}: {part}");
        }
    }
    said
}
