//! What studio and server both do beyond the core: the pot file, how a file is written so that nothing is lost, and how it is said what went wrong,
//! with flags as well.
//!
//! Owns formats and their sentences; when something is kept or said, and where, is the programs' affair.
//! Invariant: a file is written whole or not at all.

pub mod flags;
pub mod pot_file;
pub mod sentence;
pub mod whole_file;
