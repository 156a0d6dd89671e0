//! The machine under any study: a second kind beside campaigns, whose rows are made by hand, and what would be lost or
//! mixed up elsewhere.

use std::cell::Cell;
use std::sync::atomic::{AtomicU64, Ordering};

use serde::{Deserialize, Serialize};

use crossgrain::document::Document;
use crossgrain::engine::{EngineError, ProgramError};
use crossgrain::files::file_digest;
use crossgrain::study::folder::{AnyStudy, Done, Job, StudyFolder};
use crossgrain::study::realization::{Engines, Runner};
use crossgrain::study::{Judged, Outline, Study, StudyError, create};
use crossgrain::study::{plan::Plan, shard::Shard, store::RECORDS};

use crate::support::*;

/// Squares; a task that is a multiple of `breaks` fails.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Squares {
    count: u64,
    breaks: Option<u64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Square {
    task: u64,
    square: u64,
    /// Another one each time.
    took: u64,
}

/// Rows made in this process.
static MADE: AtomicU64 = AtomicU64::new(0);

impl Study for Squares {
    const KIND: &'static str = "squares";
    type Row = Square;

    fn count(&self) -> u64 {
        self.count
    }

    fn check(&self) -> Result<(), String> {
        Ok(())
    }

    fn runner(&self, _: u64) -> Runner {
        Runner::Native
    }

    fn identity(&self, task: u64) -> String {
        task.to_string()
    }

    fn run(&self, task: u64, _: &Engines, _: &Path) -> Result<Square, EngineError> {
        if self
            .breaks
            .is_some_and(|breaks| task.is_multiple_of(breaks))
        {
            let (status, log) = (format!("task {task}"), String::new());
            return Err(ProgramError::Crashed { status, log }.into());
        }
        let (square, took) = (task * task, MADE.fetch_add(1, Ordering::Relaxed));
        Ok(Square { task, square, took })
    }

    fn belongs(&self, task: u64, row: &Square) -> bool {
        row.task == task
    }

    fn same(first: &Square, second: &Square) -> bool {
        first.square == second.square
    }

    fn outline(&self, row: &Square) -> Outline {
        Outline {
            engine: None,
            ending: "squared",
            cells: vec![("square".to_owned(), row.square.to_string())],
        }
    }

    fn judge(folder: &StudyFolder<Self>) -> Result<Judged, StudyError> {
        let sum = Cell::new(0);
        folder.each(|_, row| sum.set(sum.get() + row.square))?;
        Ok(Judged {
            own: json!({"sum": sum.get()}),
            measured: Vec::new(),
            document: Document {
                title: "Squares".to_owned(),
                verdict: crossgrain::checks::Outcome::Skipped,
                answer: format!("The sum is {}.", sum.get()),
                sections: Vec::new(),
                checks: Vec::new(),
            },
        })
    }
}

fn run(folder: &Path, shard: Shard) -> Result<Done, StudyError> {
    let (threads, engines) = (3, &Engines::default());
    let job = Job {
        shard,
        threads,
        engines,
    };
    StudyFolder::<Squares>::open(folder)?.run(&job, &Display::new(true))
}

fn new(count: u64, breaks: Option<u64>) -> (Place, PathBuf) {
    let place = new_folder();
    let path = place.join("s");
    create(&path, Squares { count, breaks }, None, None).expect("a new study");
    (place, path)
}

/// The sums of a study that is shared out, repeated, merged and judged are right although no two rows have the same time.
#[test]
fn a_study_of_another_kind_has_all_that_campaigns_have() {
    let (_place, path) = new(10, None);
    run(&path, Shard::new(2, 3).expect("a shard")).expect("three rows");
    let open = || StudyFolder::<Squares>::open(&path).expect("a study");
    let half = open().judge().expect("what is there");
    assert_eq!(half.document.answer, "The sum is 93.");
    assert_eq!(half.record.checks[0].id, "squares/rows");
    assert_eq!(half.record.verdict, crossgrain::checks::Outcome::Skipped);
    let early = open().merge();
    assert!(matches!(
        early,
        Err(StudyError::Incomplete { missing: 7, .. })
    ));
    let done = run(&path, Shard::WHOLE).expect("the rest");
    assert_eq!((done.wanted, done.before, done.complete), (10, 3, true));
    // The same rows by another process, with other times.
    let rows = path.join(RECORDS).join("shard-1-of-1.jsonl");
    let kept = fs::read(&rows).expect("records");
    fs::remove_file(&rows).expect("ours");
    run(&path, Shard::new(1, 2).expect("a shard")).expect("again");
    fs::write(&rows, kept).expect("writable");
    assert!(open().status().expect("a status").repeated > 0);
    let summary = open().merge().expect("all are the same");
    assert_eq!(summary.rows, 10);
    let squared = BTreeMap::from([("squared".to_owned(), 10)]);
    assert_eq!(summary.endings, squared);
    let table = text_of(path.join("rows.csv"));
    assert!(table.starts_with("square\n1\n4\n9\n"), "{table}");
    let whole = open().judge().expect("all");
    assert_eq!(whole.document.answer, "The sum is 385.");
    assert_eq!(whole.record.verdict, crossgrain::checks::Outcome::Pass);
    assert!(whole.text.contains(grains::SOURCE_DIGEST));
}

/// A torn line, a line of an older format and rubbish stay where they are, byte for byte, and their rows are made anew.
#[test]
fn lines_that_cannot_be_read_are_kept() {
    let (_place, path) = new(6, None);
    run(&path, Shard::WHOLE).expect("six rows");
    let file = path.join(RECORDS).join("shard-1-of-1.jsonl");
    let text = text_of(&file);
    let lines: Vec<&str> = text.lines().collect();
    let older = lines[1].replacen("\"took\"", "\"time\"", 1);
    let torn = &lines[5][..lines[5].len() - 9];
    let damaged = format!("{}\n{older}\nrubbish\n{}\n{torn}", lines[0], lines[2]);
    fs::write(&file, &damaged).expect("writable");
    let done = run(&path, Shard::WHOLE).expect("the others again");
    let done = (done.before, done.damaged.len(), done.complete);
    assert_eq!(done, (2, 3, true));
    let after = text_of(&file);
    assert!(after.starts_with(&format!("{damaged}\n")), "{after}");
    let merged = StudyFolder::<Squares>::open(&path).and_then(|study| study.merge());
    assert_eq!(merged.expect("merged").rows, 6);
}

#[test]
fn rows_of_another_source_are_never_mixed_in() {
    let (place, path) = new(4, None);
    run(&path, Shard::WHOLE).expect("four rows");
    let mut older = Plan::<Squares>::read(&path).expect("a plan");
    older.made_with.source = "0".repeat(64);
    let other = place.join("older");
    older.write(&other).expect("a new folder");
    let [from, to] = [&path, &other].map(|folder| folder.join(RECORDS).join("shard-1-of-1.jsonl"));
    fs::copy(from, to).expect("room");
    let ran = run(&other, Shard::WHOLE);
    assert!(matches!(ran, Err(StudyError::OtherProgram { .. })));
    let status = StudyFolder::<Squares>::open(&other).and_then(|study| study.status());
    let status = status.expect("a status");
    assert_eq!((status.finished, status.damaged.len()), (0, 4));
    let larger = place.join("larger");
    let reused = larger_plan(&larger, &other);
    assert!(matches!(reused, Err(StudyError::OtherProgram { .. })));
    assert!(!larger.exists(), "a plan that was refused leaves nothing");
}

/// Nine squares in a new folder, with what is made of them already.
fn larger_plan(folder: &Path, made: &Path) -> Result<u64, StudyError> {
    let (count, breaks) = (9, None);
    create(folder, Squares { count, breaks }, None, Some(made))
}

#[test]
fn a_larger_plan_goes_on_where_a_smaller_one_ended() {
    let (place, path) = new(4, None);
    run(&path, Shard::new(1, 2).expect("a shard")).expect("two rows");
    let larger = place.join("larger");
    let reused = larger_plan(&larger, &path);
    assert_eq!(reused.expect("a new study"), 2);
    let done = run(&larger, Shard::WHOLE).expect("the rest");
    assert_eq!((done.wanted, done.before), (9, 2));
}

#[test]
fn other_rows_go_on_where_an_engine_fails() {
    let (_place, path) = new(9, Some(4));
    for _ in 0..2 {
        let ran = run(&path, Shard::WHOLE);
        let Err(StudyError::EnginesFailed {
            finished,
            rows,
            first,
        }) = ran
        else {
            panic!("two rows fail");
        };
        assert_eq!((finished, rows.as_str()), (7, "4, 8"));
        has(&first, ["ended with task"]);
    }
}

#[test]
fn an_external_engine_is_the_one_that_was_planned() {
    let mut scene = tiny_scene();
    scene.settle.max_steps = 20;
    scene.settle.check_every = 20;
    let at = &folder_with(&scene);
    let toy = text_of(adapter_path("toy.py"));
    // It pours to the most steps, and this bed never comes to the punch.
    let parts = "\"walls\", \"cases\", \"punch\", \"stop_rules\"";
    let pours = toy
        .replace("\"walls\", \"cases\"", parts)
        .replace("job[\"until_step\"])", "job[\"settle\"][\"max_steps\"])")
        .replace("steps_done", "max_steps");
    let engine = program(at, "engine", &pours);
    let plan = "study plan campaign scene.json --members 2 --engine exec:engine --out c";
    ends(at, 0, plan);
    ends(at, 0, "study run c --shard 1/2");
    fs::write(&engine, pours.clone() + "\n# another one\n").expect("writable");
    let (_, errors) = ends(at, 2, "study run c");
    has(&errors, ["is not the program that was planned"]);
    // The right one somewhere else.
    program(at, "moved", &pours);
    let (said, _) = ends(at, 0, "study run c --engine exec:moved");
    has(&said, ["merged 2 rows"]);
    assert!(said.ends_with("report: c/report.html\n"), "{said}");
    // Replaced while it runs: nobody knows which one made the run. Removed meanwhile: it is the one that was there.
    let job = "    steps = run(sys.argv[2])\n";
    let replaces = format!("{job}    open(__file__, \"a\").write(\"#\")\n");
    program(at, "replaced", &changed_toy(job, &replaces));
    let errors = run_in(at, 4, "exec:replaced", &["--steps", "2"], "one");
    has(&errors, ["was replaced while it ran"]);
    let removes = replaces.replace("open(__file__, \"a\").write(\"#\")", "os.remove(__file__)");
    let removed = program(at, "removed", &changed_toy(job, &removes));
    let digest = file_digest(&removed).expect("a file");
    ran_in(at, "exec:removed", &["--steps", "2"], "two");
    assert!(!removed.exists());
    let record = text_of(at.join("two/run.json"));
    has(&record, [&digest]);
}

/// A pipe among the records would make a reader wait for ever.
#[test]
fn a_pipe_among_the_records_is_refused() {
    let (_place, path) = new(3, None);
    a_pipe(&path.join(RECORDS), "shard-1-of-2.jsonl");
    let error = run(&path, Shard::WHOLE).expect_err("a pipe");
    has(&error.to_string(), ["is not a regular file"]);
}
