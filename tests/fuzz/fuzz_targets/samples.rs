//! libFuzzer's way into `bodies::samples`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pottery_fuzz::bodies::samples(bytes));
