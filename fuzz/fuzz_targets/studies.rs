#![no_main]

mod common;

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    crossgrain_fuzz::studies::read(input);
});
