//! libFuzzer's way into `bodies::client`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pottery_fuzz::bodies::client(bytes));
