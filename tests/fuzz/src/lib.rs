//! What strangers may send, and what has to hold whatever it is.
//!
//! The bodies are ordinary functions of bytes: libFuzzer calls them through `fuzz_targets/`, and `tests/tests/house/fuzz_corpora.rs`
//! compiles the same file and replays `corpus/` on any toolchain.

pub mod bodies;
