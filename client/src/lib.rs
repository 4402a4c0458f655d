//! The pottery client library.
//!
//! Knows no window and no command line: those are the studio's.

pub mod render;
