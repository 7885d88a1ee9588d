//! libFuzzer on `readers::eos`.
#![no_main]
#[path = "../readers.rs"]
mod readers;
libfuzzer_sys::fuzz_target!(|bytes: &[u8]| readers::eos(bytes));
