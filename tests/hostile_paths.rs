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
