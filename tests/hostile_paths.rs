//! Every path that a verb takes, given as what is no file: each ends soon, with one sentence and an exit code of its own, and
//! changes nothing outside.

use std::os::unix::fs::{PermissionsExt, symlink};

use crate::support::*;

/// Verbs with `@` where a path stands: files and folders that are read, then those that are written.
const READ: [&str; 48] = [
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
    "report bisect a --good b --record r --repository @ -- true",
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

/// Exit code and what was said; a long job is asked to end.
fn ended(arguments: &[String], folder: &Path, is_long: bool) -> (Option<i32>, String) {
    let (mut began, mut asked) = (Instant::now(), !is_long);
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
        if began.elapsed() > LONGEST && !asked {
            send(&child, "TERM");
            (began, asked) = (Instant::now(), true);
        }
        if began.elapsed() > LONGEST {
            child.kill().expect("it ends");
            child.wait().expect("a status");
            break None;
        }
        std::thread::sleep(Duration::from_millis(2));
    };
    assert!(memory < LARGEST, "{arguments:?}: {memory} kB");
    (code, text_of(folder.join("said")))
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
            let (code, said) = ended(&arguments, &inner, may_work(verb, kind));
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
        let is_named_file = options.iter().any(|of| verb.contains(of));
        let of_folder = ["figures", "reproduce", "bench", "baseline save"];
        match kind {
            "zeros" | "locked" | "holes" | "a\n\u{1b}[31mname" => is_named_file,
            "folder" => of_folder.iter().any(|of| verb.contains(of)),
            _ => false,
        }
    });
}

/// A verb, a folder that it reads or writes into, names in it (one that ends in `.gz` stands instead of the plain one), and the
/// exit codes that are right when something hostile stands at one of them; 0 where it is replaced, or never looked at.
const INSIDE: &str = "
    compare run run --out o ⇒ run ⇒ scene.json run.json SHA256SUMS initial.csv bodies.csv.gz contacts.csv history.csv.gz trace.csv.gz yade.log ⇒ 2
    report vtk run --out o ⇒ run ⇒ run.json initial.csv.gz contacts.csv.gz trace.csv ⇒ 2
    report archive run --out o ⇒ run ⇒ scene.json initial.csv.gz yade.log engine.log ⇒ 2
    run --engine native --out o --from-state run scene.json ⇒ run ⇒ run.json bodies.csv ⇒ 2
    study status two ⇒ two ⇒ plan.json plan.json.gz records records/shard-1-of-1.jsonl ⇒ 0 2
    study run two --quiet ⇒ two ⇒ plan.json records records/shard-1-of-1.jsonl records/shard-9-of-9.jsonl ⇒ 0 2 75
    study merge two ⇒ two ⇒ plan.json.gz records records/shard-1-of-1.jsonl rows.jsonl rows.csv merged.json ⇒ 0 2 3 75
    study report two ⇒ two ⇒ plan.json rows.jsonl rows.jsonl.gz merged.json records/shard-1-of-1.jsonl report.json report.html figures ⇒ 0 2 3 75
    study compare two two --out o ⇒ two ⇒ plan.json.gz rows.jsonl rows.jsonl.gz merged.json ⇒ 2 3
    study claims two --out o ⇒ two ⇒ plan.json rows.jsonl.gz merged.json ⇒ 2 3
    study figures --campaign two --out o ⇒ two ⇒ plan.json rows.jsonl.gz merged.json ⇒ 2 3
    study slurm --tasks 2 two ⇒ two ⇒ plan.json slurm slurm/array.sh slurm/merge.sh ⇒ 0 2 75
    study plan campaign --members 3 --out o --reuse two scene.json ⇒ two ⇒ plan.json.gz records records/shard-1-of-1.jsonl ⇒ 0 2
    report baseline list --store kept ⇒ kept ⇒ name.json ⇒ 2
    report baseline diff record.json name --store kept ⇒ kept ⇒ name.json ⇒ 2
    report baseline save record.json name --replace --store kept ⇒ kept ⇒ name.json ⇒ 0 75
    report history --store kept --out o ⇒ kept ⇒ name.json ⇒ 2
    reproduce --recorded --quiet --out o --with two ⇒ two ⇒ report.json claims.json ⇒ 2 75
    reproduce --recorded --quiet --out out ⇒ out ⇒ .crossgrain.lock yade-recorded yade-recorded/run.json native run.json report.html figures ⇒ 2 75
    bench --quick --quiet --out out ⇒ out ⇒ .crossgrain.lock bed-5000.json bed-5000.csv ⇒ 2 75
    stability --quick --quiet --out out ⇒ out ⇒ report.json ⇒ 2 75
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

/// Each file and folder inside the folders that a verb reads or writes, replaced by each kind.
#[test]
fn whatever_stands_inside_a_folder_every_verb_ends_soon_and_changes_nothing_outside() {
    let place = &folder_with(&tiny_scene());
    ends(place, 0, "run scene.json --engine native --out run");
    ends(
        place,
        0,
        "study plan campaign scene.json --members 2 --out two",
    );
    for verb in ["run two --quiet", "merge two", "report two"] {
        ends(place, 0, &format!("study {verb}"));
    }
    fs::copy(place.join("two/report.json"), place.join("record.json")).expect("a record");
    ends(
        place,
        0,
        "report baseline save record.json name --store kept",
    );
    fs::create_dir_all(place.join("out/yade-recorded")).expect("ours");
    fs::create_dir(place.join("outside")).expect("ours");
    let bomb = bomb();
    let mut wrong = Vec::new();
    for [verb, folder, names, codes] in rows(INSIDE) {
        let codes: Vec<i32> = codes
            .words()
            .iter()
            .map(|code| code.parse().expect("a code"))
            .collect();
        for name in names.words() {
            let packed = name.strip_suffix(".gz");
            for kind in KINDS_INSIDE.into_iter().chain(packed.map(|_| "bomb")) {
                let inner = place.join("inner");
                let copy = "mkdir inner && cp -r scene.json record.json kept run two out inner";
                assert_eq!(bash(place, copy, &[]).0, 0);
                fs::write(place.join("secret"), SECRET).expect("written");
                let at = inner.join(folder).join(name);
                let remove = "rm -rf \"$1\" \"$2\"; mkdir -p \"$(dirname \"$1\")\"";
                let plain = inner.join(folder).join(packed.unwrap_or(name));
                let paths = [&at, &plain].map(|path| path.to_str().expect("text").to_owned());
                assert_eq!(bash(place, remove, &[&paths[0], &paths[1]]).0, 0);
                match kind {
                    "bomb" => fs::write(&at, &bomb).expect("written"),
                    "link to a folder" => symlink(place.join("outside"), &at).expect("made"),
                    "link out" => symlink(place.join("secret"), &at).expect("made"),
                    "300 GB" => fs::File::create(&at)
                        .and_then(|file| file.set_len(300 << 30))
                        .expect("made"),
                    _ => make(kind, &at),
                }
                let arguments: Vec<String> = verb.words().iter().map(|&of| of.to_owned()).collect();
                let (code, said) = ended(&arguments, &inner, codes.contains(&75));
                let mut find = |what: &str| {
                    wrong.push(format!("{verb}, {folder}/{name}, {kind}: {what}: {said}"));
                };
                match code {
                    None => find("it never ended"),
                    Some(code) if !codes.contains(&code) => find(&format!("exit code {code}")),
                    Some(_) if said.lines().count() > 8 => find("more than a sentence"),
                    Some(_) => {}
                }
                if said.contains("panicked") || said.contains("unexpected argument") {
                    find("a panic, or not understood");
                }
                if text_of(place.join("secret")) != SECRET
                    || !there(&place.join("outside")).is_empty()
                {
                    find("something outside is changed");
                }
                if said.contains("a secret") {
                    find("the secret is told");
                }
                assert_eq!(
                    bash(place, "chmod -R u+rwX inner; rm -rf inner outside/*", &[]).0,
                    0
                );
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
