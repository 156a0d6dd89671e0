//! Ledgers. The first byte says of which job.

use std::path::Path;

use crossgrain::files::FileError;
use crossgrain::study::sensitivity::push::Watched;
use crossgrain::study::sensitivity::row::Row;
use crossgrain::study::tradeoff::ledger::{Entry, Ledger};
use crossgrain::study::tradeoff::member::Member;

use super::parts;

/// What a ledger believes it believes again, and what is added to it stays.
pub fn read(input: &[u8]) -> bool {
    let Some((kind, bytes)) = input.split_first() else {
        return false;
    };
    let folder = parts::folder();
    parts::put(folder.path(), "ledger.jsonl", bytes);
    let path = folder.path().join("ledger.jsonl");
    match kind {
        b'm' => of::<Member>(&path),
        b'r' => of::<Row>(&path),
        b'w' => of::<Watched>(&path),
        _ => false,
    }
}

fn of<T: Entry + PartialEq + std::fmt::Debug>(path: &Path) -> bool {
    match Ledger::<T>::open(path) {
        Ok(ledger) => drop(ledger),
        Err(FileError::NotText { .. }) => return false,
        Err(error) => panic!("{error}"),
    }
    let text = std::fs::read_to_string(path).expect("a ledger is text");
    let mut ledger = Ledger::<T>::open(path).expect("what was opened once");
    let mut kept = Vec::new();
    for line in text.lines() {
        let entry: T = serde_json::from_str(line).expect("only what is believed stays");
        kept.push((entry.digest().to_owned(), entry.realization(), line));
    }
    let Some((digest, realization, line)) = kept.last().cloned() else {
        return false;
    };
    let last: T = serde_json::from_str(line).expect("as before");
    assert_eq!(ledger.member(&digest, realization), Some(&last));
    ledger.add(last).expect("a writable folder");
    drop(ledger);
    let again = Ledger::<T>::open(path).expect("what was written");
    let last: T = serde_json::from_str(line).expect("as before");
    assert_eq!(again.member(&digest, realization), Some(&last));
    let longer = std::fs::read_to_string(path).expect("a ledger is text");
    assert_eq!(longer.lines().count(), kept.len() + 1);
    true
}
