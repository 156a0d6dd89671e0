//! What the fuzzers do with an input, a module a reader. The fuzz targets call it with inputs that libFuzzer makes up, and
//! `tests/fuzz_corpus.rs`, which takes in these same files, with the inputs that were kept.
//!
//! Each function gives its input to a reader and panics where the reader breaks a promise: what is accepted reads back to
//! the same value once it is written, and nothing panics. It tells whether the input was accepted.

pub mod baseline;
pub mod campaign;
pub mod exec;
pub mod parts;
pub mod plan;
pub mod record;
pub mod rows;
pub mod run_folder;
pub mod scene;
pub mod seeds;
pub mod small;
pub mod studies;
pub mod tables;
pub mod yade;

/// A reader: gives it an input and tells whether it was accepted.
pub type Reader = fn(&[u8]) -> bool;

/// Every reader under the name of its fuzz target and its folder of kept inputs.
pub const READERS: [(&str, Reader); 11] = [
    ("baseline", baseline::read),
    ("campaign", campaign::read),
    ("exec", exec::read),
    ("plan", plan::read),
    ("record", record::read),
    ("rows", rows::read),
    ("run_folder", run_folder::read),
    ("scene", scene::read),
    ("studies", studies::read),
    ("tables", tables::read),
    ("yade", yade::read),
];

/// The most memory that an input may take at once, bytes.
pub const MOST_MEMORY: u64 = 1 << 28;
