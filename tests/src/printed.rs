//! What programs print.
//!
//! Owns nothing; what is written goes to the standard output and the standard error.
//! Invariant: whoever reads no further ends no program, and whatever else goes wrong is an error that says so.

use std::fmt::Display;
use std::io::{self, ErrorKind, Write};

use pottery_files::sentence::sentence;

/// The standard output, for `writeln!`.
///
/// Once its reader has closed it, as `head` does, what is written is dropped: a program goes on to its files and its own exit
/// code. Everything else that goes wrong, as on a full disk, is an error.
#[derive(Clone, Copy, Debug)]
pub struct Printed;

impl Write for Printed {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        passed(io::stdout().write(bytes), bytes.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        passed(io::stdout().flush(), ())
    }
}

/// Tells how a program is getting on, or why it ends, on the standard error; dropped when nobody reads that any more.
pub fn remark(line: impl Display) {
    drop(writeln!(io::stderr(), "{line}"));
}

/// The result, or `dropped` when nobody reads any more.
fn passed<T>(result: io::Result<T>, dropped: T) -> io::Result<T> {
    match result {
        Err(error) if error.kind() == ErrorKind::BrokenPipe => Ok(dropped),
        Err(error) => Err(io::Error::new(error.kind(), format!("the figures cannot be printed: {}", sentence(&error)))),
        done => done,
    }
}
