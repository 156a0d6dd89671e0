//! Every path that a verb takes, given as what is no file: each ends soon, with one sentence and an exit code of its own, and
//! changes nothing outside.

use std::os::unix::fs::{PermissionsExt, symlink};
use std::sync::Mutex;

use crossgrain::workers;

use crate::support::*;

/// Verbs with `@` where a path stands: files and folders that are read, then those that are written.
const READ: [&str; 47] = [
    "scene check @",
    "scene model @",
    "scene parameters --engine native @",
    "scene parameters --engine yade --yade @ scene.json",
    "run --engine native --out o @",
    "run --engine exec:@ --out o scene.json",
    "run --engine yade --yade @ --out o scene.json",
    "run --engine native --out o --from-state @ scene.json",
    "compare @ run",
    "compare run @",
    "reproduce --quiet --out o --scene @",
    "reproduce --quiet --out o --with @",
    "reproduce --quiet --out o --baseline name --store @",
    "engine check exec:@",
    "engine check yade --yade @",
    "engine table exec:@",
    "verify --engine exec:@",
    "study plan campaign --members 2 --out o @",
    "study plan campaign --members 2 --out o --engine exec:@ scene.json",
    "study plan campaign --members 2 --out o --reuse @ scene.json",
    "study plan tradeoff --quick --out o --engine exec:@",
    "study plan tradeoff --quick --out o --reuse @",
    "study plan search --out o --after @",
    "study plan search --out o --reuse @",
    "study plan candidates --quick --out o --search @",
    "study plan candidates --quick --out o --reuse @",
    "study plan stability --quick --out o --engine exec:@",
    "study run @",
    "study status @",
    "study merge @",
    "study slurm --tasks 2 @",
    "study report @",
    "study compare @ two",
    "study compare two @",
    "study claims @",
    "study claims two --beside @",
    "study figures --campaign @ --out o",
    "stability --quick --engine exec:@",
    "bench --quick --out o --engine exec:@",
    "report checks @",
    "report explain compare --record @",
    "report history --store @",
    "report history --store kept --repository @",
    "report baseline save @ name --store o",
    "report baseline diff @ name --store kept",
    "report baseline diff record.json name --store @",
    "report baseline list --store @",
];
const WRITTEN: [&str; 25] = [
    "run --engine native --steps 100 --out @ scene.json",
    "study plan campaign --members 2 --out @ scene.json",
    "study plan tradeoff --quick --out @",
    "study plan candidates --quick --choices --out @",
    "study plan search --beds 2 --out @",
    "study plan stability --quick --out @",
    "study compare two two --out @",
    "study claims two --out @",
    "study figures --out @",
    "reproduce --recorded --quiet --out @",
    "stability --quick --quiet --out @",
    "bench --quick --quiet --out @",
    "paper numbers --out @",
    "paper continuum --out @",
    "report history --store kept --out @",
    "report baseline save record.json name --store @",
    "report vtk run --out @",
    "report archive run --out @",
    "report checks record.json --junit @",
    "report checks record.json --csv @",
    "report checks record.json --summary @",
    "compare run run --out @",
    "compare run run --junit @",
    "compare run run --csv @",
    "compare run run --summary @",
];

/// What stands at the path.
const KINDS: [&str; 9] = [
    "pipe",
    "zeros",
    "full",
    "folder",
    "link out",
    "link to itself",
    "locked",
    "holes",
    "a\n\u{1b}[31mname",
];
/// Of the file outside, which a link leads to.
const SECRET: &str = "a secret\n";
/// The longest that anything takes, and the most memory, kB.
const LONGEST: Duration = Duration::from_secs(5);
const LARGEST: u64 = 500_000;

fn make(kind: &str, at: &Path) {
    let made = match kind {
        "pipe" => Command::new("mkfifo").arg(at).status().map(drop),
        "zeros" => symlink("/dev/zero", at),
        "full" => symlink("/dev/full", at),
        "folder" => fs::create_dir(at),
        "link out" => symlink("../secret", at),
        "link to itself" => symlink(at.file_name().expect("a name"), at),
        "holes" => fs::File::create(at).and_then(|file| file.set_len(5 << 30)),
        _ => fs::write(at, "no JSON").and_then(|()| {
            let mode = if kind == "locked" { 0 } else { 0o755 };
            fs::set_permissions(at, fs::Permissions::from_mode(mode))
        }),
    };
    made.expect("it is made");
}

/// Exit code, whether it was asked to end, after so long, and what was said.
fn ended(
    arguments: &[String],
    folder: &Path,
    asked_after: Option<Duration>,
) -> (Option<i32>, bool, String) {
    let (mut began, mut asked) = (Instant::now(), false);
    let said = fs::File::create(folder.join("said")).expect("a file");
    let mut program = cli(folder);
    program
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(said);
    let mut child = program.args(arguments).spawn().expect("it starts");
    let mut memory = 0;
    let code = loop {
        memory = memory.max(peak_memory(child.id()));
        if let Some(status) = child.try_wait().expect("a status") {
            break status.code();
        }
        let waits = asked_after.filter(|_| !asked);
        if began.elapsed() > waits.unwrap_or(LONGEST) {
            if waits.is_none() {
                child.kill().expect("it ends");
                child.wait().expect("a status");
                break None;
            }
            send(&child, "TERM");
            (began, asked) = (Instant::now(), true);
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    assert!(memory < LARGEST, "{arguments:?}: {memory} kB");
    (code, asked, text_of(folder.join("said")))
}

/// Fails with all that is wrong with how these verbs end; where one `may_work`, it may.
fn walk(verbs: &[&str], may_work: impl Fn(&str, &str) -> bool) {
    let place = &folder_with(&tiny_scene());
    ends(place, 0, "run scene.json --engine native --out run");
    let command = "study plan campaign scene.json --members 2 --out two";
    ends(place, 0, command);
    ends(place, 0, "study run two --quiet");
    let record = place.join("two/report.json");
    fs::copy(record, place.join("record.json")).expect("a record");
    let save = "report baseline save record.json name --store kept";
    ends(place, 0, save);
    let mut wrong = Vec::new();
    for verb in verbs {
        for kind in KINDS {
            let inner = place.join("inner");
            let copy = "mkdir inner && cp -r scene.json record.json kept run two inner";
            assert_eq!(bash(place, copy, &[]).0, 0);
            fs::write(place.join("secret"), SECRET).expect("written");
            let name = if kind.contains('\n') { kind } else { "bad" };
            make(kind, &inner.join(name));
            let arguments = verb.split(' ').map(|word| word.replace('@', name));
            let arguments: Vec<String> = arguments.collect();
            let asked_after = may_work(verb, kind).then_some(LONGEST);
            let (code, _, said) = ended(&arguments, &inner, asked_after);
            let mut find = |what: &str| wrong.push(format!("{verb}, {kind}: {what}: {said}"));
            match code {
                None => find("it never ended"),
                Some(0) if may_work(verb, kind) => {}
                Some(2 | 3 | 4 | 75) if said.lines().count() < 8 && !said.contains('\u{1b}') => {}
                Some(code) => find(&format!("exit code {code}")),
            }
            if said.contains("panicked") {
                find("a panic");
            }
            // A verb that is written wrongly here would prove nothing.
            if said.contains("unexpected argument") || said.contains("required arguments") {
                find("it was not understood");
            }
            if text_of(place.join("secret")) != SECRET {
                find("the secret is changed");
            }
            if said.contains("a secret") {
                find("the secret is told");
            }
            let _ = fs::set_permissions(inner.join("bad"), fs::Permissions::from_mode(0o755));
            fs::remove_dir_all(&inner).expect("removed");
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn whatever_is_read_every_verb_ends_soon_with_a_sentence() {
    // A locked file is open to root, and an empty folder holds no baselines.
    let empty = |verb: &str, kind: &str| verb.contains("list") && kind == "folder";
    walk(&READ, empty);
}

#[test]
fn whatever_is_written_to_nothing_else_is_changed() {
    walk(&WRITTEN, |verb, kind| {
        let options = ["--junit", "--csv", "--summary"];
        let is_named_file = options.iter().any(|option| verb.contains(option));
        let of_folder = ["figures", "reproduce", "bench", "baseline save"];
        match kind {
            "zeros" | "locked" | "holes" | "a\n\u{1b}[31mname" => is_named_file,
            "folder" => of_folder.iter().any(|named| verb.contains(named)),
            _ => false,
        }
    });
}

/// A verb, a folder that it reads or writes into, names in it (one that ends in `.gz` stands instead of the plain one), and the exit
/// code that is right when something hostile stands at one of them, for all kinds and then for single ones.
const INSIDE: &str = "
    compare run run --out o ⇒ run ⇒ scene.json run.json SHA256SUMS initial.csv bodies.csv.gz contacts.csv history.csv.gz trace.csv.gz yade.log ⇒ 2
    report vtk run --out o ⇒ run ⇒ run.json initial.csv.gz contacts.csv.gz trace.csv ⇒ 2
    report archive run --out o ⇒ run ⇒ scene.json initial.csv.gz yade.log engine.log ⇒ 2
    report run run --out o ⇒ run ⇒ run.json bodies.csv history.csv.gz ⇒ 2
    run --engine native --out o --from-state run scene.json ⇒ run ⇒ run.json bodies.csv ⇒ 2
    study status two ⇒ two ⇒ plan.json plan.json.gz ⇒ 2
    study status two ⇒ two ⇒ records ⇒ 2 folder=0
    study status two ⇒ two ⇒ records/shard-1-of-1.jsonl ⇒ 2 locked=0
    study run two --quiet ⇒ two ⇒ plan.json ⇒ 2
    study run two --quiet ⇒ two ⇒ records ⇒ 2 folder=0
    study run two --quiet ⇒ two ⇒ records/shard-1-of-1.jsonl records/shard-9-of-9.jsonl ⇒ 2 locked=0
    study merge two ⇒ two ⇒ plan.json.gz ⇒ 2
    study merge two ⇒ two ⇒ records ⇒ 2 folder=3
    study merge two ⇒ two ⇒ records/shard-1-of-1.jsonl ⇒ 2 locked=3
    study merge two ⇒ two ⇒ rows.jsonl rows.csv merged.json ⇒ 0 folder=2
    study report two ⇒ two ⇒ plan.json rows.jsonl rows.jsonl.gz merged.json ⇒ 2
    study report two ⇒ two ⇒ records/shard-1-of-1.jsonl ⇒ 2 locked=0
    study report two ⇒ two ⇒ report.json report.html ⇒ 0 folder=2
    study report two ⇒ two ⇒ figures ⇒ 2 folder=0
    study compare two two --out o ⇒ two ⇒ plan.json.gz rows.jsonl rows.jsonl.gz merged.json ⇒ 2
    study claims two --out o ⇒ two ⇒ plan.json rows.jsonl.gz merged.json ⇒ 2
    study figures --campaign two --out o ⇒ two ⇒ plan.json rows.jsonl.gz merged.json ⇒ 2
    study slurm --tasks 2 two ⇒ two ⇒ plan.json ⇒ 2
    study slurm --tasks 2 two ⇒ two ⇒ slurm ⇒ 2 folder=0
    study slurm --tasks 2 two ⇒ two ⇒ slurm/array.sh slurm/merge.sh ⇒ 0 folder=2
    study plan campaign --members 3 --out o --reuse two scene.json ⇒ two ⇒ plan.json.gz ⇒ 2
    study plan campaign --members 3 --out o --reuse two scene.json ⇒ two ⇒ records ⇒ 2 folder=0
    study plan campaign --members 3 --out o --reuse two scene.json ⇒ two ⇒ records/shard-1-of-1.jsonl ⇒ 2 locked=0
    report baseline list --store kept ⇒ kept ⇒ name.json ⇒ 2
    report baseline diff record.json name --store kept ⇒ kept ⇒ name.json ⇒ 2
    report baseline save record.json name --replace --store kept ⇒ kept ⇒ name.json ⇒ 0 folder=2
    report history --store kept --out o ⇒ kept ⇒ name.json ⇒ 2
    reproduce --recorded --quiet --out o --with two ⇒ two ⇒ report.json claims.json ⇒ 2
";

/// The same of verbs that take long: they are asked to end.
const INSIDE_OF_LONG: &str = "
    reproduce --recorded --quiet --out out ⇒ out ⇒ .crossgrain.lock yade-recorded yade-recorded/run.json native run.json report.html figures
    bench --quick --quiet --out out ⇒ out ⇒ .crossgrain.lock bed-5000.json bed-5000.csv
    stability --quick --quiet --out out ⇒ out ⇒ report.json
";

/// What stands inside.
const KINDS_INSIDE: [&str; 8] = [
    "pipe",
    "zeros",
    "link out",
    "link to a folder",
    "link to itself",
    "folder",
    "locked",
    "300 GB",
];

/// A packed file of 3 GB in 3 MB, of short lines that begin like JSON.
fn bomb() -> Vec<u8> {
    let packed = |text: &str| crate::readers::parts::packed(text.as_bytes());
    let million = packed(&"[],\n".repeat(1 << 20));
    [packed("{\"x\":[\n"), million.repeat(700)].concat()
}

/// A verb with something hostile inside a folder.
struct Inside {
    verb: &'static str,
    folder: &'static str,
    name: &'static str,
    kind: &'static str,
    /// The exit codes that are right; 75 is too once it was asked to end.
    codes: Vec<i32>,
}

impl Inside {
    fn kinds(name: &str) -> impl Iterator<Item = &'static str> {
        let bomb = name.ends_with(".gz").then_some("bomb");
        KINDS_INSIDE.into_iter().chain(bomb)
    }

    fn all() -> Vec<Self> {
        let mut all = Vec::new();
        for [verb, folder, names, codes] in rows(INSIDE) {
            let of_kind = |kind: &str| {
                let mut codes = codes.words().into_iter();
                let code = codes.next().expect("a code");
                let own = codes.find_map(|code| code.strip_prefix(kind)?.strip_prefix('='));
                own.unwrap_or(code).parse().expect("a code")
            };
            for name in names.words() {
                all.extend(Inside::kinds(name).map(|kind| {
                    let mut codes = vec![of_kind(kind)];
                    // A locked file is open to root alone.
                    codes.extend((kind == "locked").then_some(2));
                    Inside {
                        verb,
                        folder,
                        name,
                        kind,
                        codes,
                    }
                }));
            }
        }
        all
    }

    /// What is found before anything is computed, and what was replaced at the end.
    fn of_long_verbs() -> Vec<Self> {
        let mut all = Vec::new();
        for [verb, folder, names] in rows(INSIDE_OF_LONG) {
            for name in names.words() {
                all.extend(Inside::kinds(name).map(|kind| Inside {
                    verb,
                    folder,
                    name,
                    kind,
                    codes: vec![0, 2],
                }));
            }
        }
        all
    }

    /// All that is wrong with how it ends among copies of these files.
    fn wrong(&self, files: &Path, bomb: &[u8], asked_after: Duration) -> Option<String> {
        let place = &new_folder();
        fs::write(place.join("secret"), SECRET).expect("written");
        fs::create_dir(place.join("outside")).expect("ours");
        let at = format!("inner/{}/{}", self.folder, self.name);
        let plain = at.strip_suffix(".gz").unwrap_or(&at).to_owned();
        let copy = "cp -r \"$3\" inner && rm -rf \"$1\" \"$2\" && mkdir -p \"$(dirname \"$1\")\"";
        let files = files.to_str().expect("text").to_owned();
        assert_eq!(bash(place, copy, &[&at, &plain, &files]).0, 0);
        let at = &place.join(at);
        match self.kind {
            "bomb" => fs::write(at, bomb).expect("written"),
            "link to a folder" => symlink(place.join("outside"), at).expect("made"),
            "link out" => symlink(place.join("secret"), at).expect("made"),
            "300 GB" => fs::File::create(at)
                .and_then(|file| file.set_len(300 << 30))
                .expect("made"),
            kind => make(kind, at),
        }
        let arguments: Vec<String> = self
            .verb
            .words()
            .iter()
            .map(|&word| word.to_owned())
            .collect();
        let (code, asked, said) = ended(&arguments, &place.join("inner"), Some(asked_after));
        let mut wrong = Vec::new();
        match code {
            None => wrong.push("it never ended".to_owned()),
            Some(75) if asked => {}
            Some(code) if !self.codes.contains(&code) => wrong.push(format!("exit code {code}")),
            Some(_) => {}
        }
        let mut refute = |is: bool, what: &str| wrong.extend(is.then(|| what.to_owned()));
        refute(said.lines().count() > 8, "more than a sentence");
        refute(said.contains("panicked"), "a panic");
        refute(said.contains("unexpected argument"), "not understood");
        refute(said.contains("a secret"), "the secret is told");
        let is_changed = text_of(place.join("secret")) != SECRET;
        refute(is_changed, "the secret is changed");
        let is_filled = !there(&place.join("outside")).is_empty();
        refute(is_filled, "something outside is made");
        let unlock = "chmod -R u+rwX inner";
        assert_eq!(bash(place, unlock, &[]).0, 0);
        let Inside {
            verb,
            folder,
            name,
            kind,
            ..
        } = self;
        let wrong = wrong.join(", ");
        (!wrong.is_empty()).then(|| format!("{verb}, {folder}/{name}, {kind}: {wrong}: {said}"))
    }
}

/// Each of these files and folders replaced by each kind; a verb is asked to end after so long.
fn walk_inside(cases: Vec<Inside>, asked_after: Duration) {
    let place = &folder_with(&tiny_scene());
    ends(place, 0, "run scene.json --engine native --out run");
    let plan = "study plan campaign scene.json --members 2 --out two";
    ends(place, 0, plan);
    for verb in ["run two --quiet", "merge two", "report two"] {
        ends(place, 0, &format!("study {verb}"));
    }
    fs::copy(place.join("two/report.json"), place.join("record.json")).expect("a record");
    let save = "report baseline save record.json name --store kept";
    ends(place, 0, save);
    fs::create_dir_all(place.join("out/yade-recorded")).expect("ours");
    let (bomb, found) = (bomb(), Mutex::new(Vec::new()));
    let count = cases.len();
    let done = workers::each(cases.into_iter(), 4, |case| {
        let wrong = case.wrong(place, &bomb, asked_after);
        workers::lock(&found).push(wrong);
        Ok::<(), ()>(())
    });
    let found = found.into_inner().expect("no panic");
    assert!(done.is_ok() && found.len() == count);
    let wrong: Vec<String> = found.into_iter().flatten().collect();
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn whatever_stands_inside_a_folder_every_verb_ends_soon_and_changes_nothing_outside() {
    walk_inside(Inside::all(), LONGEST);
}

#[test]
fn whatever_stands_inside_a_folder_long_jobs_end_when_they_are_asked() {
    let mut cases = Inside::of_long_verbs();
    cases.retain(|case| ["link out", "folder"].contains(&case.kind));
    walk_inside(cases, Duration::from_secs(1));
}

/// Every thirtieth each time; all of them, which takes half an hour, with `CROSSGRAIN_ALL=1 cargo test --release long_jobs_end_well`.
#[test]
fn whatever_stands_inside_a_folder_long_jobs_end_well() {
    let mut cases = Inside::of_long_verbs();
    if std::env::var_os("CROSSGRAIN_ALL").is_none() {
        cases = cases.into_iter().step_by(30).collect();
    }
    walk_inside(cases, Duration::from_secs(60));
}
