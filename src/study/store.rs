//! The rows of a study on the disk: a file a shard, a line a row, each line with a check of itself. Files only grow.
//!
//! A line is `CHECK NUMBER {json}` with CHECK the first 64 bits of SHA-256 over the plan's digest, the row's number and
//! the JSON. What is not such a line – the last one of a process that was killed, or of a full disk – is not believed,
//! stands for nothing and is left as it is; the next writer begins a new line after it.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use sha2::{Digest, Sha256};

use super::shard::Shard;
use crate::files::{FileError, failed, listed, locked, regular, short_hex};
use crate::workers::asked_to_end;

/// A campaign's row is about 20 kB; a longer line is none.
pub const LONGEST_LINE: u64 = 4_000_000;

/// As many damaged lines are named; those after them are left out.
const MOST_DAMAGED: usize = 10_000;

fn check(plan: &str, number: u64, json: &str) -> String {
    short_hex(Sha256::new_with_prefix(format!("{plan} {number} {json}")))
}

/// The line of a row, without its end.
pub fn line(plan: &str, number: u64, json: &str) -> String {
    format!("{} {number} {json}", check(plan, number, json))
}

/// Number and JSON of a line, if it is a whole row of this plan.
fn believed<'a>(plan: &str, line: &'a str) -> Option<(u64, &'a str)> {
    let (sum, rest) = line.split_once(' ')?;
    let (number, json) = rest.split_once(' ')?;
    let number = number.parse().ok()?;
    (check(plan, number, json) == sum).then_some((number, json))
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
    pub fn open(folder: &Path, shard: Shard) -> Result<Self, FileError> {
        let name = format!("{RECORDS}/shard-{}-of-{}.jsonl", shard.index, shard.shards);
        let (path, file) = (folder.join(&name), locked((folder, &name))?);
        let length = file.metadata().map_err(failed("find", &path))?.len();
        let torn = length > 0 && {
            let mut last = [0];
            let read = file.read_exact_at(&mut last, length - 1);
            read.map_err(failed("read", &path))?;
            last != *b"\n"
        };
        Ok(Writer { path, file, torn })
    }

    /// Adds a row; when this returns, it is on the disk.
    pub fn add(&mut self, plan: &str, number: u64, json: &str) -> Result<(), FileError> {
        let mut text = line(plan, number, json);
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

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Place {
    /// Which of [`Index::files`].
    pub file: u32,
    /// Where its JSON begins, bytes.
    pub offset: u64,
    /// Bytes of its JSON.
    pub length: u32,
}

#[derive(Debug, Default)]
pub struct Index {
    folder: PathBuf,
    /// By name.
    pub files: Vec<PathBuf>,
    pub rows: Vec<u64>,
    /// By number; of several lines of a row, the first that was found.
    pub places: BTreeMap<u64, Place>,
    /// Further lines of rows, which must say the same.
    pub repeated: Vec<(u64, Place)>,
    /// File and line, from 1, of what is not believed.
    pub damaged: Vec<(PathBuf, u64)>,
}

impl Index {
    /// Reads all record files of a study with so many rows.
    pub fn read(folder: &Path, plan: &str, count: u64) -> Result<Self, FileError> {
        let mut index = Index {
            folder: folder.to_owned(),
            ..Index::default()
        };
        let files = listed((folder, RECORDS), MOST_FILES)?.into_iter();
        let files = files.map(|file| file.path);
        let files = files.filter(|path| path.extension().is_some_and(|end| end == "jsonl"));
        index.files = files.collect();
        for file in 0..index.files.len() {
            index.add_file(file, plan, count)?;
        }
        Ok(index)
    }

    fn add_file(&mut self, file: usize, plan: &str, count: u64) -> Result<(), FileError> {
        let path = self.files[file].clone();
        let mut reader = BufReader::with_capacity(1 << 16, self.open(file)?);
        // A line a row, and room for what others have left.
        let limit = (count + 64).saturating_mul(LONGEST_LINE);
        if reader
            .get_ref()
            .metadata()
            .is_ok_and(|metadata| metadata.len() > limit)
        {
            return Err(FileError::TooLarge { path, limit });
        }
        let (mut offset, mut at, mut found) = (0, 0, 0);
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
            if asked_to_end() {
                return Err(FileError::Ended { path });
            }
            at += 1;
            let whole = line.pop_if(|last| *last == b'\n').is_some();
            let row = std::str::from_utf8(&line)
                .ok()
                .filter(|_| whole)
                .and_then(|text| believed(plan, text).map(|(number, json)| (number, json.len())))
                .filter(|(number, _)| (1..=count).contains(number));
            match row {
                Some((number, length)) => {
                    found += 1;
                    let place = Place {
                        file: file as u32,
                        offset: offset + (line.len() - length) as u64,
                        length: length as u32,
                    };
                    match self.places.entry(number) {
                        Entry::Occupied(_) => self.repeated.push((number, place)),
                        Entry::Vacant(free) => drop(free.insert(place)),
                    }
                }
                // A new line after a torn one.
                None if line.is_empty() => {}
                None if self.damaged.len() >= MOST_DAMAGED => {}
                None => self.damaged.push((path.clone(), at)),
            }
            offset += read as u64;
        }
        self.rows.push(found);
        Ok(())
    }

    pub fn path(&self, place: &Place) -> &Path {
        &self.files[place.file as usize]
    }

    fn open(&self, file: usize) -> Result<File, FileError> {
        let name = self.files[file].file_name();
        let name = name.expect("a listed file has a name");
        let name = format!("{RECORDS}/{}", name.to_string_lossy());
        regular((&self.folder, &name))
    }
}

/// Reads rows that an index has found.
#[derive(Debug)]
pub struct Reader<'a> {
    index: &'a Index,
    open: BTreeMap<u32, File>,
}

const MOST_OPEN: usize = 256;

impl<'a> Reader<'a> {
    pub fn new(index: &'a Index) -> Self {
        Reader {
            index,
            open: BTreeMap::new(),
        }
    }

    pub fn json(&mut self, place: &Place) -> Result<String, FileError> {
        let path = self.index.path(place);
        if self.open.len() >= MOST_OPEN {
            self.open.clear();
        }
        let file = match self.open.entry(place.file) {
            Entry::Occupied(open) => open.into_mut(),
            Entry::Vacant(free) => free.insert(self.index.open(place.file as usize)?),
        };
        let mut bytes = vec![0; place.length as usize];
        let read = file.read_exact_at(&mut bytes, place.offset);
        read.map_err(failed("read", path))?;
        let path = path.to_owned();
        String::from_utf8(bytes).map_err(|_| FileError::NotText { path })
    }
}

/// The folder of the files.
pub const RECORDS: &str = "records";
/// As many entries of it are looked at.
const MOST_FILES: usize = 1_000_000;
