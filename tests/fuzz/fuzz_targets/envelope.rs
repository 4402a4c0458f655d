//! libFuzzer's way into `bodies::envelope`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pottery_fuzz::bodies::envelope(bytes));
