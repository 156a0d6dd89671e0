//! The folder of a study: running a shard, status, merging and reading what was merged, for every kind.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use crate::checks::record::{self, Found};
use crate::checks::{Check, Outcome, verdict};
use crate::engine::EngineError;
use crate::engine::ProgramError::{NotStarted, Refused, Unsupported};
use crate::files::{
    Aside, FileError, Place as At, Stream, failed, new_folder, read_text, remove_folder,
    remove_litter, work_folder, write_whole,
};
use crate::progress::Display;
use crate::study::plan::{Plan, Program};
use crate::study::realization::Engines;
use crate::study::shard::Shard;
use crate::study::store::{Index, LONGEST_LINE, Place, Reader, Writer};
use crate::study::{Judged, Outline, Report, Study, StudyError};
use crate::tables::csv_line;
use crate::workers::{self, asked_to_end, lock};
use serde::{Deserialize, Serialize};
use serde_json::json;
use sha2::{Digest, Sha256};

/// The rows of a merged study, a line of JSON each, in the order of their numbers; it may be packed (`rows.jsonl.gz`).
pub const ROWS: &str = "rows.jsonl";
/// The numbers of all rows as a table, where the study has cells.
pub const TABLE: &str = "rows.csv";
/// See [`Summary`]; written last.
pub const SUMMARY: &str = "merged.json";

/// What one process is to do.
#[derive(Debug)]
pub struct Job<'a> {
    pub shard: Shard,
    pub threads: usize,
    /// How engines that are other programs are started.
    pub engines: &'a Engines,
}

/// What it did.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Done {
    pub wanted: u64,
    /// How many of them had been written before.
    pub before: u64,
    pub complete: bool,
    /// File and line of what is not believed.
    pub damaged: Vec<(PathBuf, u64)>,
}

#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Status {
    /// See [`Study::KIND`].
    pub kind: String,
    pub rows: u64,
    /// Those that are written, or merged.
    pub finished: u64,
    /// Rows that are written more than once, as two processes with different shards leave them.
    pub repeated: u64,
    pub files: Vec<(String, u64)>,
    /// File and line of what is not believed.
    pub damaged: Vec<(String, u64)>,
    pub missing: String,
    pub merged: bool,
}

/// `merged.json`: what was merged.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Summary {
    pub plan: String,
    pub rows: u64,
    /// Engine and version, where one engine made all rows.
    pub engine: String,
    pub endings: BTreeMap<String, u64>,
    /// SHA-256 of `rows.jsonl`.
    pub sha256: String,
}

impl Summary {
    /// As it is on the disk.
    pub fn text(&self) -> String {
        serde_json::to_string_pretty(self).expect("a summary is JSON") + "\n"
    }
}

/// How many rows are of which engine and ended how.
#[derive(Default)]
struct Outlines {
    engines: BTreeMap<String, u64>,
    endings: BTreeMap<String, u64>,
}

impl Outlines {
    fn count(&mut self, outline: &Outline) {
        if let Some(engine) = &outline.engine {
            *self.engines.entry(engine.clone()).or_default() += 1;
        }
        *self.endings.entry(outline.ending.to_owned()).or_default() += 1;
    }

    /// Engine and version, where one made all rows; rows of several are of no one result.
    fn engine(&self) -> Result<String, StudyError> {
        if self.engines.len() > 1 {
            let engines = self.engines.iter();
            let engines = engines.map(|(name, count)| format!("{name}: {count}"));
            return Err(StudyError::Contradiction(format!(
                "rows were made by different engines ({}): merge what one engine made",
                engines.collect::<Vec<String>>().join(", ")
            )));
        }
        Ok(self.engines.keys().next().cloned().unwrap_or_default())
    }
}

/// A merged study with all of its rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Merged<S: Study> {
    pub plan: Plan<S>,
    /// What came of it in short.
    pub summary: Summary,
    pub rows: Vec<S::Row>,
}

/// A study's folder: `plan.json`, which never changes, `records/`, which only grows, and, once it is merged, `rows.jsonl`,
/// `rows.csv` and `merged.json`.
#[derive(Debug)]
pub struct StudyFolder<S> {
    path: PathBuf,
    pub plan: Plan<S>,
    digest: String,
}

/// What every study's folder can do, whatever its kind.
pub trait AnyStudy {
    fn count(&self) -> u64;
    fn program(&self) -> Option<&Program>;
    fn check_program(&self) -> Result<(), StudyError>;
    /// Makes the rows of the shard that are missing, each written down when it is finished.
    fn run(&self, job: &Job<'_>, display: &Display) -> Result<Done, StudyError>;
    /// Reads every row that is written.
    fn status(&self) -> Result<Status, StudyError>;
    /// Merges a complete study into `rows.jsonl`, `rows.csv` and, last of all, `merged.json`, whose bytes depend on the
    /// plan alone.
    fn merge(&self) -> Result<Summary, StudyError>;
    /// What is written and shown of the rows that are there.
    fn judge(&self) -> Result<Report, StudyError>;
}

impl<S: Study> StudyFolder<S> {
    pub fn open(path: &Path) -> Result<Self, StudyError> {
        let plan = Plan::<S>::read(path)?;
        Ok(StudyFolder {
            digest: plan.digest(),
            path: path.to_owned(),
            plan,
        })
    }

    /// Whether something of this name is there.
    fn has(&self, name: &str) -> bool {
        At::from((&self.path, name)).is_taken()
    }

    fn lines(&self, name: &str) -> Result<Lines, FileError> {
        remove_litter(&self.path);
        Ok(Lines(Aside::of((&self.path, name))?, self.path.join(name)))
    }

    fn index(&self) -> Result<Index, FileError> {
        Index::read(&self.path, &self.digest, self.plan.study.count())
    }

    fn missing(&self, index: &Index) -> Vec<u64> {
        (1..=self.plan.study.count())
            .filter(|number| !index.places.contains_key(number))
            .collect()
    }

    /// Hands over every row that is there with its number, one at a time, since a million do not fit into memory: the
    /// merged ones, or else those that are written so far. What was handed over counts only if this ends well.
    pub fn each(&self, mut take: impl FnMut(u64, S::Row)) -> Result<(), StudyError> {
        if self.has(SUMMARY) {
            return self.each_merged(take).map(drop);
        }
        let index = self.index()?;
        let mut reader = Reader::new(&index);
        self.check_repeated(&index, &mut reader)?;
        let mut outlines = Outlines::default();
        for (number, place) in &index.places {
            let row = self.parse(*number, &reader.json(place)?)?;
            outlines.count(&self.plan.study.outline(&row));
            take(*number, row);
        }
        outlines.engine().map(drop)
    }

    /// All of [`StudyFolder::each`].
    pub fn rows(&self) -> Result<Vec<S::Row>, StudyError> {
        let mut rows = Vec::new();
        self.each(|_, row| rows.push(row))?;
        Ok(rows)
    }

    pub fn merged(self) -> Result<Merged<S>, StudyError> {
        let mut rows = Vec::new();
        let summary = self.each_merged(|_, row| rows.push(row))?;
        Ok(Merged {
            plan: self.plan,
            summary,
            rows,
        })
    }

    /// Every row of a merged study, checked against summary and plan.
    fn each_merged(&self, mut take: impl FnMut(u64, S::Row)) -> Result<Summary, StudyError> {
        let damaged = |reason: String| {
            let path = self.path.display();
            StudyError::Usage(format!(
                "the merged rows of {path} are damaged: {reason}; put back what was there, or let `crossgrain study merge` write \
                 them anew from the records"
            ))
        };
        if !self.has(SUMMARY) {
            let path = self.path.clone();
            return Err(StudyError::NotMerged { path });
        }
        let text = read_text((&self.path, SUMMARY), 1_000_000)?;
        let summary: Summary =
            serde_json::from_str(&text).map_err(|error| damaged(format!("{SUMMARY}: {error}")))?;
        if summary.plan != self.digest {
            return Err(damaged(format!("{SUMMARY} is of another plan")));
        }
        let names = [ROWS.to_owned(), format!("{ROWS}.gz")];
        let name = names.iter().find(|name| self.has(name));
        let name = name.ok_or_else(|| damaged(format!("{ROWS} is not there")))?;
        let path = &self.path.join(name);
        let longest = self.count().saturating_mul(LONGEST_LINE);
        let mut lines = BufReader::new(Stream::open((&self.path, name), longest)?);
        let (mut read, mut hash, mut line) = (0, Sha256::new(), String::new());
        let mut outlines = Outlines::default();
        loop {
            line.clear();
            let mut bounded = (&mut lines).take(LONGEST_LINE);
            let bytes = bounded.read_line(&mut line);
            if bytes.map_err(failed("read", path))? == 0 {
                break;
            }
            if asked_to_end() {
                return Err(FileError::Ended { path: path.clone() }.into());
            }
            hash.update(line.as_bytes());
            read += 1;
            let wrong = |why| damaged(format!("line {read} of {ROWS}: {why}"));
            let row = self.row(read, &line).map_err(wrong)?;
            outlines.count(&self.plan.study.outline(&row));
            take(read, row);
        }
        if hex(hash.clone()) != summary.sha256 || read != self.plan.study.count() {
            return Err(damaged(format!("{ROWS} is not what {SUMMARY} says")));
        }
        if text != self.summary(outlines, hash)?.text() {
            let why = format!("{SUMMARY} says something else than {ROWS}");
            return Err(damaged(why));
        }
        Ok(summary)
    }

    /// Of rows that have this digest.
    fn summary(&self, outlines: Outlines, hash: Sha256) -> Result<Summary, StudyError> {
        Ok(Summary {
            plan: self.digest.clone(),
            rows: self.plan.study.count(),
            engine: outlines.engine()?,
            endings: outlines.endings,
            sha256: hex(hash),
        })
    }

    fn row(&self, number: u64, json: &str) -> Result<S::Row, String> {
        let row = serde_json::from_str(json).map_err(|error| error.to_string())?;
        match self.plan.study.belongs(number, &row) {
            true => Ok(row),
            false => Err("it is of another row".to_owned()),
        }
    }

    fn parse(&self, number: u64, json: &str) -> Result<S::Row, StudyError> {
        self.row(number, json).map_err(|why| {
            let reason = format!("what is written of row {number} is none: {why}");
            StudyError::not_a_study(&self.path, reason)
        })
    }

    /// Rows that are written twice must say the same.
    fn check_repeated(&self, index: &Index, reader: &mut Reader<'_>) -> Result<(), StudyError> {
        for (number, place) in &index.repeated {
            let first = &index.places[number];
            let rows = [reader.json(first)?, reader.json(place)?];
            let parse = |json: &String| self.parse(*number, json);
            if rows[0] != rows[1] && !S::same(&parse(&rows[0])?, &parse(&rows[1])?) {
                return Err(StudyError::Contradiction(format!(
                    "row {number} is written twice and differently, in {} and {}: an engine whose bits depend on more than \
                     the plan, or a file that was changed; find out which, and take the wrong file away",
                    index.path(first).display(),
                    index.path(place).display()
                )));
            }
        }
        Ok(())
    }

    /// Copies what another study of the same kind and made with the same program has of this one's rows; how many.
    pub fn reuse(&self, from: &Path) -> Result<u64, StudyError> {
        let other = StudyFolder::<S>::open(from)?;
        other.check_program()?;
        if other.plan.program != self.plan.program {
            return Err(StudyError::other_engine(from));
        }
        let index = other.index()?;
        let study = &other.plan.study;
        let known = index.places.iter();
        let known = known.map(|(number, place)| (study.identity(*number), place));
        let known: BTreeMap<String, &Place> = known.collect();
        let mut reader = Reader::new(&index);
        other.check_repeated(&index, &mut reader)?;
        let mut writer = Writer::open(&self.path, Shard::WHOLE)?;
        let (mut reused, mut outlines) = (0, Outlines::default());
        for number in 1..=self.count() {
            if let Some(place) = known.get(&self.plan.study.identity(number)) {
                let json = reader.json(place)?;
                outlines.count(&self.plan.study.outline(&self.parse(number, &json)?));
                writer.add(&self.digest, number, &json)?;
                reused += 1;
            }
        }
        outlines.engine()?;
        Ok(reused)
    }
}

impl<S: Study> AnyStudy for StudyFolder<S> {
    fn count(&self) -> u64 {
        self.plan.study.count()
    }

    fn program(&self) -> Option<&Program> {
        self.plan.program.as_ref()
    }

    fn check_program(&self) -> Result<(), StudyError> {
        self.plan.check_program(&self.path)
    }

    fn run(&self, job: &Job<'_>, display: &Display) -> Result<Done, StudyError> {
        self.check_program()?;
        if let Some(planned) = &self.plan.program
            && job.engines.external.as_ref().map(|engine| &engine.digest) != Some(&planned.digest)
        {
            return Err(StudyError::other_engine(&planned.path));
        }
        // Before the rows are read: nothing can be added to this file afterwards by anyone else.
        let writer = Writer::open(&self.path, job.shard)?;
        let index = self.index()?;
        for (path, line) in &index.damaged {
            let path = path.display();
            display.line(&format!(
                "{path} line {line} is no whole row and is not believed; the row is made again"
            ));
        }
        let own = || job.shard.rows(self.count());
        let missing = || own().filter(|number| !index.places.contains_key(number));
        let (wanted, left) = (own().count() as u64, missing().count() as u64);
        let before = wanted - left;
        let made = AtomicU64::new(0);
        if left > 0 {
            let (place, began) = (work_folder()?, Instant::now());
            let (writer, broken) = (Mutex::new(writer), Mutex::default());
            let progress = || {
                let made = made.load(Ordering::Relaxed);
                let hours = began.elapsed().as_secs_f64() / 3600.0;
                (made, format!("{:.0} an hour", made as f64 / hours))
            };
            let task = display.task(&format!("rows, shard {}", job.shard));
            let ended = workers::each(missing(), job.threads, |number| {
                if let Some(json) = self.json_of(number, job.engines, place.path(), &broken)? {
                    lock(&writer).add(&self.digest, number, &json)?;
                    made.fetch_add(1, Ordering::Relaxed);
                    let (made, speed) = progress();
                    task.share(
                        made as f64 / left as f64,
                        &format!("{made} of {left}, {speed}"),
                    );
                }
                Ok::<(), StudyError>(())
            });
            let (made, speed) = progress();
            task.done(&format!("{made} of {left} written down, {speed},"));
            let finished = before + made;
            ended?;
            if asked_to_end() && finished < wanted {
                return Err(StudyError::Interrupted { finished, wanted });
            }
            let broken = std::mem::take(&mut *lock(&broken));
            if let Some(first) = broken.first {
                return Err(StudyError::EnginesFailed {
                    finished,
                    rows: in_words(broken.rows),
                    first,
                });
            }
        }
        Ok(Done {
            wanted,
            before,
            complete: index.places.len() as u64 + made.into_inner() == self.count(),
            damaged: index.damaged,
        })
    }

    fn status(&self) -> Result<Status, StudyError> {
        let index = self.index()?;
        let name = |path: &Path| {
            let name = path.file_name().expect("a listed file has a name");
            name.to_string_lossy().into_owned()
        };
        let files = index.files.iter().zip(&index.rows);
        let damaged = index.damaged.iter();
        // Merged rows count without the records that they came from.
        let merged = self.has(SUMMARY);
        let (finished, missing) = match merged {
            true => (self.count(), Vec::new()),
            false => (index.places.len() as u64, self.missing(&index)),
        };
        Ok(Status {
            kind: S::KIND.to_owned(),
            rows: self.count(),
            finished,
            repeated: index.repeated.len() as u64,
            files: files.map(|(path, rows)| (name(path), *rows)).collect(),
            damaged: damaged.map(|(path, line)| (name(path), *line)).collect(),
            missing: in_words(missing),
            merged,
        })
    }

    fn merge(&self) -> Result<Summary, StudyError> {
        let index = self.index()?;
        let missing = self.missing(&index);
        if !missing.is_empty() {
            return Err(StudyError::Incomplete {
                missing: missing.len() as u64,
                wanted: self.count(),
                rows: in_words(missing),
            });
        }
        let mut reader = Reader::new(&index);
        self.check_repeated(&index, &mut reader)?;
        let outline = |reader: &mut Reader<'_>, number: u64, place: &Place| {
            let json = reader.json(place)?;
            let outline = self.plan.study.outline(&self.parse(number, &json)?);
            Ok::<(String, Outline), StudyError>((json, outline))
        };
        // Columns must be known before the first row; rows that failed have fewer.
        let mut columns: Vec<String> = Vec::new();
        let mut places: BTreeMap<String, usize> = BTreeMap::new();
        for (number, place) in &index.places {
            for (column, _) in outline(&mut reader, *number, place)?.1.cells {
                places.entry(column).or_insert_with_key(|column| {
                    columns.push(column.clone());
                    columns.len() - 1
                });
            }
        }
        let (mut outlines, mut hash) = (Outlines::default(), Sha256::new());
        let (mut rows, mut table) = (self.lines(ROWS)?, self.lines(TABLE)?);
        table.write(&csv_line(&columns))?;
        for (number, place) in &index.places {
            let (json, outline) = outline(&mut reader, *number, place)?;
            outlines.count(&outline);
            let line = json + "\n";
            hash.update(&line);
            rows.write(&line)?;
            let mut cells = vec![String::new(); columns.len()];
            for (column, value) in outline.cells {
                cells[places[&column]] = value;
            }
            table.write(&csv_line(&cells))?;
        }
        let summary = self.summary(outlines, hash)?;
        rows.0.into_place()?;
        if !columns.is_empty() {
            table.0.into_place()?;
        }
        write_whole((&self.path, SUMMARY), summary.text().as_bytes())?;
        Ok(summary)
    }

    fn judge(&self) -> Result<Report, StudyError> {
        let status = self.status()?;
        let Judged {
            mut own,
            measured,
            mut document,
        } = S::judge(self)?;
        let outcome = Outcome::pass_or_skip(status.finished == status.rows);
        let found = format!("{} of {} rows", status.finished, status.rows);
        let id = format!("{}/rows", S::KIND);
        let check = Check::of_words(id, "no row is missing", outcome, &found);
        document.checks.insert(0, check.required());
        document.verdict = verdict(&document.checks);
        own["crossgrain"] = env!("CARGO_PKG_VERSION").into();
        own["command"] = "crossgrain study report DIR".into();
        own["plan"] = self.digest.clone().into();
        own["made_with"] = json!(self.plan.made_with);
        let found = Found {
            checks: document.checks.clone(),
            measured,
            ..Found::default()
        };
        // Nothing in it depends on the machine.
        let (text, record) = record::write(S::KIND, &own, String::new(), found)?;
        Ok(Report {
            text,
            record,
            document,
        })
    }
}

/// What failed in a run.
#[derive(Default)]
struct Broken {
    rows: Vec<u64>,
    first: Option<String>,
    /// Engines that are not there, by name.
    unavailable: Vec<&'static str>,
}

impl<S: Study> StudyFolder<S> {
    /// Makes a row, with a folder of its own in `place`; none where its engine fails, or is known to be not there.
    fn json_of(
        &self,
        number: u64,
        engines: &Engines,
        place: &Path,
        broken: &Mutex<Broken>,
    ) -> Result<Option<String>, StudyError> {
        let study = &self.plan.study;
        let runner = study.runner(number);
        if lock(broken).unavailable.contains(&runner.name()) {
            lock(broken).rows.push(number);
            return Ok(None);
        }
        let work = place.join(number.to_string());
        let elsewhere = !runner.is_native();
        if elsewhere {
            new_folder(&work)?;
        }
        let made = study.run(number, engines, &work);
        if elsewhere {
            // The tables of a run are large, and nobody looks at them again; what stays goes with the folder.
            let _ = remove_folder(&work);
        }
        let row = match made {
            Ok(row) => row,
            Err(_) if asked_to_end() => return Ok(None),
            Err(EngineError::Program(error)) => {
                // No other row can be made in this engine either.
                let unavailable = error.is_missing() || matches!(error, NotStarted { .. });
                // Another row may fare better, and this one another time.
                let is_of_row =
                    error.is_failure() || matches!(error, Refused(_) | Unsupported { .. });
                if !unavailable && !is_of_row {
                    return Err(EngineError::Program(error).into());
                }
                let mut broken = lock(broken);
                if unavailable {
                    broken.unavailable.push(runner.name());
                }
                broken.rows.push(number);
                broken.first.get_or_insert(error.to_string());
                return Ok(None);
            }
            Err(error) => return Err(error.into()),
        };
        let json = serde_json::to_string(&row).map_err(|error| {
            let reason = format!("row {number} cannot be written as JSON: {error}");
            StudyError::not_a_study(&self.path, reason)
        });
        json.map(Some)
    }
}

/// Numbers for people: the first few in order, and how many more.
fn in_words(mut numbers: Vec<u64>) -> String {
    const SHOWN: usize = 8;
    numbers.sort_unstable();
    let shown: Vec<String> = numbers.iter().take(SHOWN).map(u64::to_string).collect();
    let mut text = shown.join(", ");
    if numbers.len() > SHOWN {
        text += &format!(" and {} more", numbers.len() - SHOWN);
    }
    text
}

fn hex(hash: Sha256) -> String {
    grains::tables::hex(&hash.finalize())
}

/// A file of lines that is written aside, of any size.
struct Lines(Aside, PathBuf);

impl Lines {
    fn write(&mut self, text: &str) -> Result<(), FileError> {
        let written = self.0.write_all(text.as_bytes());
        written.map_err(failed("write", &self.1))
    }
}
