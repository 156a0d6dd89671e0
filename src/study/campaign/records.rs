//! The records of a campaign: a file a shard, a line a member, each line with a check of itself. Files only grow.
//!
//! A line is `CHECK MEMBER {json}` with CHECK the first 64 bits of SHA-256 over the plan's digest, the member's number
//! and the JSON. What is not such a line – the last one of a process that was killed, or of a full disk – is not
//! believed and stands for nothing; the next writer begins a new line after it.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::{File, OpenOptions, TryLockError};
use std::io::{BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::CampaignError;
use super::member::Member;
use super::shard::Shard;
use crate::files::{FileError, failed, short_hex};

/// A record is about 20 kB; a longer line is none.
const LONGEST_LINE: u64 = 4_000_000;

/// The check of a record.
fn check(plan: &str, member: u64, json: &str) -> String {
    let mut hash = Sha256::new();
    for part in [plan, " ", &member.to_string(), " ", json] {
        hash.update(part.as_bytes());
    }
    short_hex(hash)
}

/// The line of a member, without its end.
pub fn line(plan: &str, member: &Member) -> String {
    let json = serde_json::to_string(member).unwrap_or_default();
    let number = member.member;
    format!("{} {number} {json}", check(plan, number, &json))
}

/// Member and JSON of a line, if it is a whole record of this plan.
fn believed<'a>(plan: &str, line: &'a str) -> Option<(u64, &'a str)> {
    let (sum, rest) = line.split_once(' ')?;
    let (member, json) = rest.split_once(' ')?;
    let member = member.parse().ok()?;
    (check(plan, member, json) == sum).then_some((member, json))
}

/// The file of a shard, open for adding to it. No other process can open it as long as this value lives.
#[derive(Debug)]
pub struct Writer {
    path: PathBuf,
    file: File,
    /// The last line has no end: what follows must not be added to it.
    torn: bool,
}

impl Writer {
    /// Opens or begins the file of a shard.
    pub fn open(folder: &Path, shard: Shard) -> Result<Self, CampaignError> {
        let path =
            records_folder(folder).join(format!("shard-{}-of-{}.jsonl", shard.index, shard.of));
        let mut file = OpenOptions::new()
            .create(true)
            .read(true)
            .append(true)
            .open(&path)
            .map_err(failed("open for writing", &path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => return Err(CampaignError::Busy { path }),
            Err(TryLockError::Error(error)) => return Err(failed("lock", &path)(error).into()),
        }
        let length = file.metadata().map_err(failed("find", &path))?.len();
        let torn = length > 0 && {
            let mut last = [0];
            file.seek(SeekFrom::Start(length - 1))
                .and_then(|_| file.read_exact(&mut last))
                .map_err(failed("read", &path))?;
            last != *b"\n"
        };
        Ok(Writer { path, file, torn })
    }

    /// Adds a member; when this returns, it is on the disk.
    pub fn add(&mut self, plan: &str, member: &Member) -> Result<(), FileError> {
        let mut text = line(plan, member);
        text.push('\n');
        if self.torn {
            text.insert(0, '\n');
        }
        // Until all of it is written.
        self.torn = true;
        self.file
            .write_all(text.as_bytes())
            .and_then(|()| self.file.sync_data())
            .map_err(failed("write", &self.path))?;
        self.torn = false;
        Ok(())
    }
}

/// Where a believed record is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Which of [`Index::files`].
    pub file: u32,
    /// Where its JSON begins, bytes.
    pub offset: u64,
    /// Bytes of its JSON.
    pub length: u32,
}

/// A line that is no record.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Damaged {
    /// The file.
    pub path: PathBuf,
    /// From 1.
    pub line: u64,
}

/// Every believed record of a campaign.
#[derive(Debug, Default)]
pub struct Index {
    /// By name.
    pub files: Vec<PathBuf>,
    /// Records of each file.
    pub records: Vec<u64>,
    /// By member; of several records of a member, the first that was found.
    pub places: BTreeMap<u64, Place>,
    /// Further records of members, which must be the same.
    pub repeated: Vec<(u64, Place)>,
    /// What is not believed.
    pub damaged: Vec<Damaged>,
}

impl Index {
    /// Reads all record files of a campaign with so many members.
    pub fn read(folder: &Path, plan: &str, members: u64) -> Result<Self, FileError> {
        let records = records_folder(folder);
        let mut index = Index::default();
        let entries = match std::fs::read_dir(&records) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(index),
            Err(error) => return Err(failed("read", &records)(error)),
        };
        for entry in entries {
            let path = entry.map_err(failed("read", &records))?.path();
            if path.extension().is_some_and(|end| end == "jsonl") {
                index.files.push(path);
            }
        }
        index.files.sort();
        for file in 0..index.files.len() {
            index.add_file(file, plan, members)?;
        }
        Ok(index)
    }

    fn add_file(&mut self, file: usize, plan: &str, members: u64) -> Result<(), FileError> {
        let path = self.files[file].clone();
        let mut reader =
            BufReader::with_capacity(1 << 16, File::open(&path).map_err(failed("open", &path))?);
        let (mut offset, mut number, mut found) = (0, 0, 0);
        let mut line = Vec::new();
        loop {
            line.clear();
            let mut bounded = (&mut reader).take(LONGEST_LINE);
            let read = bounded
                .read_until(b'\n', &mut line)
                .map_err(failed("read", &path))?;
            if read == 0 {
                break;
            }
            number += 1;
            let whole = line.pop_if(|last| *last == b'\n').is_some();
            let record = std::str::from_utf8(&line)
                .ok()
                .filter(|_| whole)
                .and_then(|text| believed(plan, text).map(|(member, json)| (member, json.len())))
                .filter(|(member, _)| (1..=members).contains(member));
            match record {
                Some((member, length)) => {
                    found += 1;
                    let place = Place {
                        file: file as u32,
                        offset: offset + (line.len() - length) as u64,
                        length: length as u32,
                    };
                    match self.places.entry(member) {
                        Entry::Occupied(_) => self.repeated.push((member, place)),
                        Entry::Vacant(free) => drop(free.insert(place)),
                    }
                }
                // A new line after a torn one.
                None if line.is_empty() => {}
                None => self.damaged.push(Damaged {
                    path: path.clone(),
                    line: number,
                }),
            }
            offset += read as u64;
        }
        self.records.push(found);
        Ok(())
    }

    /// The path of a record's file.
    pub fn path(&self, place: &Place) -> &Path {
        &self.files[place.file as usize]
    }
}

/// Reads records that an index has found.
#[derive(Debug)]
pub struct Reader<'a> {
    index: &'a Index,
    open: BTreeMap<u32, File>,
}

/// As many files as are held open.
const MOST_OPEN: usize = 256;

impl<'a> Reader<'a> {
    /// Of this index.
    pub fn new(index: &'a Index) -> Self {
        Reader {
            index,
            open: BTreeMap::new(),
        }
    }

    /// The JSON of a record.
    pub fn json(&mut self, place: &Place) -> Result<String, FileError> {
        let path = self.index.path(place);
        if self.open.len() >= MOST_OPEN {
            self.open.clear();
        }
        let file = match self.open.entry(place.file) {
            Entry::Occupied(open) => open.into_mut(),
            Entry::Vacant(free) => free.insert(File::open(path).map_err(failed("open", path))?),
        };
        let mut bytes = vec![0; place.length as usize];
        file.seek(SeekFrom::Start(place.offset))
            .and_then(|_| file.read_exact(&mut bytes))
            .map_err(failed("read", path))?;
        String::from_utf8(bytes).map_err(|_| FileError::NotText {
            path: path.to_owned(),
        })
    }
}

/// Where the record files are.
pub fn records_folder(folder: &Path) -> PathBuf {
    folder.join("records")
}
