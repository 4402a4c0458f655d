//! libFuzzer's way into `bodies::server`.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| pottery_fuzz::bodies::server(bytes));
