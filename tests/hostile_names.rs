//! Names of files and folders that a shell, an interpreter or a terminal would obey, given to the real program: they stay
//! names.

use std::ffi::{OsStr, OsString};
use std::os::unix::ffi::{OsStrExt, OsStringExt};

use crate::support::*;

/// What a name must not do is make the file `owned`.
pub fn names() -> Vec<OsString> {
    let mut names: Vec<OsString> = [
        "two words",
        "it's \"so\"",
        "$(touch owned)",
        "`touch owned`; touch owned & touch owned | touch owned",
        "100% %s \\n ~ * ? [a] {b,c}",
        "..\\..",
        "'''+open('owned','w').write('')+'''",
        "${HOME}#!$0",
        "--help",
        "-rf",
        "two\nlines",
        "\u{1b}]0;title\u{7}\u{1b}[31mred",
        "größe-\u{202e}-日本",
    ]
    .map(OsString::from)
    .into();
    names.push(OsString::from_vec(b"not \xff\xfe text".to_vec()));
    names.push("long".repeat(60).into());
    names
}

/// What the program does with a line of words and names of any bytes after them.
fn named(folder: &Path, line: &str, names: &[&OsStr]) -> Output {
    let mut program = cli(folder);
    program.args(line.words()).args(names);
    let output = program.env_remove("CROSSGRAIN_YADE").output();
    output.expect("the program starts")
}

/// What a program told: nobody has obeyed a name, and no name has reached the terminal as it is.
pub fn harmless(place: &Path, output: &Output) -> (i32, String, String) {
    let (code, out, errors) = told(output);
    for text in [&out, &errors] {
        let obeyed = |letter: char| letter.is_control() && letter != '\n' && letter != '\t';
        assert!(!text.contains(obeyed), "a terminal would obey {text:?}");
    }
    for path in below(place) {
        assert_ne!(path.file_name(), Some(OsStr::new("owned")), "{path:?}");
    }
    (code, out, errors)
}

/// A scene of two grains, twenty steps of which take no time.
pub fn two_grains() -> Scene {
    let mut scene = tiny_scene();
    scene.particles.count = 2;
    scene
}

/// `--OPTION=NAME`, which takes a name that begins with a dash.
fn option(option: &str, name: &OsStr) -> OsString {
    let mut option = OsString::from(option);
    option.push(name);
    option
}

/// A folder that goes away, in it one of this name, in it a scene.
fn place_named(name: &OsStr) -> (Place, PathBuf) {
    let top = new_folder();
    let place = top.join(name);
    fs::create_dir(&place).expect("a name that the file system takes");
    write_scene(&two_grains(), &place.join("scene.json"));
    (top, place)
}

#[test]
fn run_folders_of_any_name_are_written_compared_and_exported() {
    for name in names() {
        let (top, place) = place_named(&name);
        let tell = |line: &str, names: &[&OsStr]| {
            let (code, _, errors) = harmless(&top, &named(&place, line, names));
            assert_eq!(code, 0, "{name:?}, {line}: {errors}");
        };
        let out = option("--out=", &name);
        tell("run scene.json --engine native --steps 20", &[&out]);
        // A name may begin with a dash.
        let run = Path::new(".").join(&name);
        let run = run.as_os_str();
        tell("compare", &[run, run]);
        tell("report vtk --out vtk", &[run]);
        tell("report archive --out run.tar.gz", &[run]);
        assert!(place.join(&name).join("run.json").is_file());
    }
}

/// What does not fit is said before anything is run.
#[test]
fn a_name_that_is_too_long_is_refused_at_once() {
    let (top, place) = place_named(OsStr::new("place"));
    let out = format!("--out={}", "x".repeat(300));
    for verb in [
        "run scene.json --engine native",
        "report vtk run",
        "study plan campaign scene.json --members 2",
    ] {
        tells(&place, 2, &format!("{verb} {out}"), ["name too long"]);
    }
    assert_eq!(there(&place).len(), 1);
    harmless(&top, &crossgrain("paper numbers", &place));
}

#[test]
fn engines_of_any_name_are_started_without_a_shell() {
    let toy = text_of(adapter_path("toy.py"));
    for name in names() {
        let (top, place) = place_named(&name);
        write_scene(&narrow_scene(0.05), &place.join("scene.json"));
        let path = program(&place, &name, &toy);
        let engine = option("--engine=exec:", path.as_os_str());
        let run = "run scene.json --steps 5 --out out";
        let (code, _, errors) = harmless(&top, &named(&place, run, &[&engine]));
        // A name that is no text cannot be written into `run.json`, and is refused.
        let wanted = if name.to_str().is_some() { 0 } else { 2 };
        assert_eq!(code, wanted, "{name:?}: {errors}");
        assert_eq!(place.join("out/run.json").is_file(), wanted == 0);
    }
}

/// YADE's job is in a folder below that of the output, and in one of `TMPDIR` besides.
#[test]
fn a_yade_of_any_name_gets_its_job_in_a_folder_of_any_name() {
    for name in names() {
        let (top, place) = place_named(&name);
        let does = "frames(fine + fine, [frame(0), frame(10), end(10)])";
        let path = crate::yade_driver::yade(&place, &name, does);
        // Another name of the same kind, since the program has the first one.
        let out = OsString::from_vec([name.as_bytes(), b"2"].concat());
        let mut program = cli(&place);
        program.args("run scene.json --engine yade --steps 10 --yade".words());
        program.args([path.as_os_str(), &option("--out=", &out)]);
        let output = program.env("TMPDIR", &place).output();
        told_by_yade(&name, &top, &output.expect("the program starts"));
    }
}

/// It works everywhere but in a folder whose name is no text, which is said.
fn told_by_yade(name: &OsStr, top: &Path, output: &Output) {
    let (code, _, errors) = harmless(top, output);
    if name.to_str().is_some() {
        assert_eq!(code, 0, "{name:?}: {errors}");
    } else {
        assert_eq!(code, 2, "{name:?}: {errors}");
        has(&errors, ["is not UTF-8 text"]);
    }
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn the_real_yade_works_in_a_folder_of_any_name() {
    for name in names() {
        let (top, place) = place_named(&name);
        let (run, out) = (
            "run scene.json --engine yade --steps 5",
            option("--out=", &name),
        );
        told_by_yade(&name, &top, &named(&place, run, &[&out]));
    }
}

#[test]
fn baselines_have_plain_names_and_stores_any() {
    let record = &root("fuzz/corpus/record/reproduce");
    let record = record.as_os_str();
    for name in names() {
        let (top, place) = place_named(&name);
        let save = |names: &[&OsStr]| {
            let saved = named(&place, "report baseline save", names);
            harmless(&top, &saved)
        };
        let before = there(&place);
        let (code, _, errors) = save(&[OsStr::new("--"), record, &name]);
        // Letters and dashes alone may be a name, however long up to a limit.
        let plain = name == "-rf" || name == "--help";
        assert_eq!(code, if plain { 0 } else { 2 }, "{name:?}: {errors}");
        assert!(plain || there(&place) == before);
        let store = option("--store=", &name);
        let (code, _, errors) = save(&[record, OsStr::new("main"), &store]);
        assert_eq!(code, 0, "{name:?}: {errors}");
        assert!(place.join(&name).join("main.json").is_file());
    }
}

#[test]
fn a_baseline_is_never_outside_its_store() {
    let (_top, place) = place_named(OsStr::new("place"));
    let record = root("fuzz/corpus/record/reproduce");
    let (record, long) = (record.to_string_lossy(), "x".repeat(101));
    for name in ["../out", "/tmp/x", "a/b", ".", "..", ".hidden", "", &long] {
        let save = ["report", "baseline", "save", &record, name];
        tells(&place, 2, &save, ["is no name for a baseline"]);
    }
    assert_eq!(there(&place).len(), 1);
}
