//! How it is said what went wrong: one sentence of an error and of those that it came from.
//!
//! Owns how they are joined; the words are the errors' own, and where they are said is the programs' affair.
//! Invariant: nothing is said twice.

use std::error::Error;
use std::io;

/// An error and its sources in one sentence, from what could not be done to why.
///
/// Some errors name their source in words of their own: what has been said is left out, and what a source says better is left to it. What a
/// system says of files and addresses that anybody may mistype is said in our words.
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
/// let missing = std::fs::read("/nowhere/lead.pot").map_err(Fault::from).unwrap_err();
/// assert_eq!(sentence(&missing), "lead.pot cannot be read: there is no such file or folder");
/// ```
#[must_use]
pub fn sentence(error: &(dyn Error + 'static)) -> String {
    let mut said = String::new();
    for part in chain(error) {
        let part = part.to_string();
        if part.contains(&said) {
            said = part;
        } else if !said.contains(&part) {
            said = format!("{said}: {part}");
        }
    }
    for error in chain(error) {
        let system = error.downcast_ref::<io::Error>();
        if let Some((theirs, ours)) = system.and_then(|error| Some((error.to_string(), words(error)?))) {
            said = said.replace(&theirs, ours);
        }
    }
    said
}

/// What a reader of text says in several lines, in one, with the line of the text that it is about, where it tells how far it came.
///
/// ```
/// use pottery_files::sentence::of_line;
///
/// let text = "wheels = 3\ncolumns = -5\n";
/// assert_eq!(of_line(text, Some(21), "choose\na number"), "line 2, columns = -5: choose a number");
/// assert_eq!(of_line(text, None, "no keys"), "no keys");
/// let said = of_line("lobby = 3", Some(8), "invalid type: integer `3`, expected a boolean");
/// assert_eq!(said, "line 1, lobby = 3: write true or false");
/// let said = of_line("wheel = 3", Some(0), "unknown field `wheel`, expected one of `wheels`, `rows`");
/// assert_eq!(said, "line 1, wheel = 3: there is no 'wheel' here; did you mean 'wheels'?");
/// ```
#[must_use]
pub fn of_line(text: &str, came_to: Option<usize>, said: &str) -> String {
    let said = instead(&said.trim_end().replace('\n', " "));
    let Some(before) = came_to.and_then(|byte| text.get(..byte)) else { return said };
    let line = before.matches('\n').count();
    let written = text.lines().nth(line).unwrap_or_default().trim();
    format!("line {}, {written}: {said}", line + 1)
}

fn chain<'a>(error: &'a (dyn Error + 'static)) -> impl Iterator<Item = &'a (dyn Error + 'static)> {
    core::iter::successors(Some(error), |&error| error.source())
}

/// What to write in the place of what a reader does not take, where its words name the kinds of a programming language.
///
/// ```
/// use pottery_files::sentence::instead;
///
/// assert_eq!(instead("invalid value: integer `-1`, expected u32"), "write a whole number of 0 or more");
/// let said = instead("invalid type: string \"a\", expected f64 at line 2 column 7");
/// assert_eq!(said, "write a number, such as 2.5, at line 2 column 7");
/// assert_eq!(instead("unknown variant `de`, expected `english` or `german`"), "there is no 'de' here, but english, german");
/// assert_eq!(instead("duplicate key"), "duplicate key");
/// ```
#[must_use]
pub fn instead(said: &str) -> String {
    if said.starts_with("string values must be quoted") {
        return "write a number, true or false, or words in quotes".into();
    }
    let unknown = said.strip_prefix("unknown field `").or_else(|| said.strip_prefix("unknown variant `"));
    if let Some((name, known)) = unknown.and_then(|rest| rest.split_once("`, expected ")) {
        let known: Vec<&str> = known.split('`').skip(1).step_by(2).collect();
        let like = known.iter().map(|known| (strsim::jaro_winkler(name, known), known));
        return match like.max_by(|one, other| one.0.total_cmp(&other.0)) {
            Some((likeness, known)) if likeness > 0.85 => format!("there is no '{name}' here; did you mean '{known}'?"),
            _ => format!("there is no '{name}' here, but {}", known.join(", ")),
        };
    }
    let expected = said.strip_prefix("invalid ").and_then(|rest| rest.rsplit_once(", expected "));
    let (kind, place) = expected.map_or((None, ""), |(_, kind)| {
        let (kind, place) = kind.split_at(kind.find(" at line ").unwrap_or(kind.len()));
        (Some(kind), place)
    });
    let instead = match kind {
        Some("a boolean") => "write true or false",
        Some("u8" | "u16" | "u32" | "u64" | "usize") => "write a whole number of 0 or more",
        Some("f32" | "f64") => "write a number, such as 2.5",
        Some("a string" | "path string") => "write it in quotes",
        Some("any valid TOML value") => "write a smaller number",
        Some(kind) if kind.starts_with("struct ") || kind == "a map" => {
            "write it as a table, with its name in brackets on a line of its own"
        }
        _ => return said.to_owned(),
    };
    if place.is_empty() { instead.to_owned() } else { format!("{instead},{place}") }
}

/// What is wrong with a file or an address, where that can be said better than the system does.
fn words(error: &io::Error) -> Option<&'static str> {
    // the library's own words, of a file that is read as text
    if error.kind() == io::ErrorKind::InvalidData && error.to_string().ends_with("valid UTF-8") {
        return Some("it holds no text");
    }
    error.raw_os_error()?;
    Some(match error.kind() {
        io::ErrorKind::NotFound => "there is no such file or folder",
        io::ErrorKind::PermissionDenied => "permission denied",
        io::ErrorKind::IsADirectory => "that is a folder",
        io::ErrorKind::NotADirectory => "what stands before its name is no folder",
        io::ErrorKind::AlreadyExists => "something else of that name stands there",
        io::ErrorKind::StorageFull => "the disk is full",
        io::ErrorKind::QuotaExceeded => "this account has used up its part of the disk",
        io::ErrorKind::FileTooLarge => "it is larger than a file may be there",
        io::ErrorKind::ReadOnlyFilesystem => "the disk can only be read",
        io::ErrorKind::AddrInUse => "another program listens there",
        io::ErrorKind::AddrNotAvailable => "this machine has no such address",
        _ => return None,
    })
}
