//! Every input that the fuzzers kept, given to the readers again.

use crate::readers::{MOST_MEMORY, READERS};
use crate::support::*;

/// The inputs that were kept for a target, and those that once broke it.
fn kept(target: &str) -> Vec<PathBuf> {
    let fuzz = root("fuzz");
    let mut inputs = Vec::new();
    for place in ["corpus", "regressions"] {
        let Ok(entries) = fs::read_dir(fuzz.join(place).join(target)) else {
            continue;
        };
        inputs.extend(entries.map(|entry| entry.expect("an entry").path()));
    }
    inputs.sort();
    inputs
}

#[test]
fn every_reader_withstands_every_kept_input_within_its_memory() {
    for (target, read) in READERS {
        let inputs = kept(target);
        assert!(!inputs.is_empty(), "nothing was kept for {target}");
        let mut accepted = 0;
        for path in inputs {
            let input = fs::read(&path).expect("a readable input");
            let mut sound = false;
            let taken = allocation_counter::measure(|| sound = read(&input));
            accepted += usize::from(sound);
            let (path, taken) = (path.display(), taken.bytes_max);
            assert!(taken < MOST_MEMORY, "{path} takes {taken} bytes");
        }
        assert!(accepted > 0, "{target} accepts none of its inputs");
    }
}

/// What the program itself writes, every reader takes: else the fuzzers would begin before a closed door.
#[test]
fn every_seed_is_accepted() {
    for (target, name, input) in crate::readers::seeds::all() {
        let mut readers = READERS.into_iter();
        let (_, read) = readers.find(|reader| reader.0 == target).expect("a reader");
        assert!(read(&input), "{target} refuses {name}");
    }
}

#[test]
#[ignore = "writes into fuzz/corpus"]
fn the_seeds_are_written() {
    let corpus = root("fuzz/corpus");
    for (target, name, input) in crate::readers::seeds::all() {
        let folder = corpus.join(target);
        fs::create_dir_all(&folder).expect("a writable folder");
        fs::write(folder.join(name), input).expect("a writable folder");
    }
}
