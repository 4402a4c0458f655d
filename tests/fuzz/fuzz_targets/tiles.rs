//! libFuzzer's way into `bodies::tiles`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pottery_fuzz::bodies::tiles(bytes));
