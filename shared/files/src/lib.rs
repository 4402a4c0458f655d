//! What studio and server both keep on disk: the pot file, and how a file is written so that nothing is lost.
//!
//! Owns formats and their sentences; when something is kept, and where, is the programs' affair.
//! Invariant: a file is written whole or not at all.

pub mod pot_file;
pub mod whole_file;
