//! libFuzzer's way into `bodies::copies`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pottery_fuzz::bodies::copies(bytes));
