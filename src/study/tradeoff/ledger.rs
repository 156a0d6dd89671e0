//! The members that are finished, a line of JSON each, so that an interrupted job goes on where it was.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::files::{FileError, failed, read_text, write_whole};

/// Ten thousand members are about 10 MB.
const LARGEST: u64 = 1_000_000_000;

/// What a line holds.
pub trait Entry: Serialize + DeserializeOwned {
    /// Digest of what was run.
    fn digest(&self) -> &str;
    /// Which cloud.
    fn realization(&self) -> u64;
}

/// The file of a job's finished members, such as `members.jsonl`.
#[derive(Debug)]
pub struct Ledger<T> {
    path: PathBuf,
    file: File,
    /// By digest and realization.
    finished: BTreeMap<(String, u64), T>,
}

impl<T: Entry> Ledger<T> {
    /// Opens or begins the ledger. A line that is not a whole member – the last one of a job that was killed – is
    /// not believed and is taken out.
    pub fn open(path: &Path) -> Result<Self, FileError> {
        let mut finished = BTreeMap::new();
        if path.exists() {
            let text = read_text(path, LARGEST)?;
            let mut kept = String::new();
            for line in text.lines() {
                if let Ok(member) = serde_json::from_str::<T>(line) {
                    kept += line;
                    kept += "\n";
                    finished.insert(key(&member), member);
                }
            }
            if kept != text {
                write_whole(path, kept.as_bytes())?;
            }
        }
        let file = OpenOptions::new()
            .create(true)
            .append(true)
            .open(path)
            .map_err(failed("open", path))?;
        Ok(Ledger {
            path: path.to_owned(),
            file,
            finished,
        })
    }

    /// The member of this digest and realization, if it is finished.
    pub fn member(&self, digest: &str, realization: u64) -> Option<&T> {
        self.finished.get(&(digest.to_owned(), realization))
    }

    /// Writes a member down.
    pub fn add(&mut self, member: T) -> Result<(), FileError> {
        let mut line = serde_json::to_string(&member).unwrap_or_default();
        line.push('\n');
        let written = self.file.write_all(line.as_bytes());
        written.map_err(failed("write", &self.path))?;
        self.finished.insert(key(&member), member);
        Ok(())
    }
}

fn key<T: Entry>(member: &T) -> (String, u64) {
    (member.digest().to_owned(), member.realization())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::study::tradeoff::member::{Cost, Ending, Member};

    fn member(realization: u64) -> Member {
        Member {
            method: "abc".to_owned(),
            realization,
            ending: Ending::Failed("a reason".to_owned()),
            cost: Cost::default(),
            measured: [("a".to_owned(), 0.1 + 0.2)].into_iter().collect(),
        }
    }

    #[test]
    fn a_half_written_last_line_is_not_believed() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("members.jsonl");
        let mut ledger: Ledger<Member> = Ledger::open(&path).expect("a new ledger");
        for realization in 1..=3 {
            ledger.add(member(realization)).expect("written");
        }
        drop(ledger);
        let text = std::fs::read_to_string(&path).expect("readable");
        std::fs::write(&path, &text[..text.len() - 9]).expect("cut");
        let mut ledger: Ledger<Member> = Ledger::open(&path).expect("opened again");
        assert_eq!(ledger.member("abc", 2), Some(&member(2)));
        assert_eq!(ledger.member("abc", 3), None);
        ledger.add(member(3)).expect("written");
        drop(ledger);
        let again = std::fs::read_to_string(&path).expect("readable");
        assert_eq!(again, text);
    }
}
