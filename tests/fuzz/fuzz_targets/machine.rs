#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| isostep_tests::fuzz::machine::run(bytes));
