//! The rules of the house, held against its files.

mod architecture;
mod fuzz_corpora;
mod tick_source;
mod words;
