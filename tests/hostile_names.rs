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

/// The program with arguments of any bytes.
pub fn crossgrain_os<A: AsRef<OsStr>>(arguments: &[A], folder: &Path) -> Output {
    let mut program = cli(folder);
    program.args(arguments).env_remove("CROSSGRAIN_YADE");
    program.output().expect("the program starts")
}

/// Nobody has obeyed a name, and no name has reached the terminal as it is.
pub fn nothing_obeyed(place: &Path, output: &Output) {
    for text in [&output.stdout, &output.stderr] {
        let text = String::from_utf8_lossy(text);
        let obeyed = |of: char| of.is_control() && of != '\n' && of != '\t';
        assert!(!text.contains(obeyed), "a terminal would obey {text:?}");
    }
    for path in below(place) {
        assert_ne!(path.file_name(), Some(OsStr::new("owned")), "{path:?}");
    }
}

/// A scene of two grains, twenty steps of which take no time.
pub fn two_grains() -> Scene {
    let mut scene = tiny_scene();
    scene.particles.count = 2;
    scene
}

fn words(line: &str) -> Vec<OsString> {
    line.split(' ').map(OsString::from).collect()
}

/// `--out=NAME`, which takes a name that begins with a dash.
fn out(name: &OsStr) -> OsString {
    let mut option = OsString::from("--out=");
    option.push(name);
    option
}

/// `./NAME`, for the same reason.
fn beside(name: &OsStr) -> PathBuf {
    Path::new(".").join(name)
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
        let tell = |arguments: &[OsString]| {
            let output = crossgrain_os(arguments, &place);
            nothing_obeyed(&top, &output);
            let (code, _, errors) = told(&output);
            assert_eq!(code, 0, "{name:?}, {arguments:?}: {errors}");
        };
        let native = words("run scene.json --engine native --steps 20");
        tell(&[native, vec![out(&name)]].concat());
        let run = beside(&name).into_os_string();
        tell(&[words("compare"), vec![run.clone(), run.clone()]].concat());
        tell(&[words("report vtk --out vtk"), vec![run.clone()]].concat());
        tell(&[words("report archive --out run.tar.gz"), vec![run]].concat());
        assert!(place.join(&name).join("run.json").is_file());
    }
}

/// What does not fit is said before anything is run.
#[test]
fn a_name_that_is_too_long_is_refused_at_once() {
    let (top, place) = place_named(OsStr::new("place"));
    let long = "x".repeat(300);
    for verb in [
        "run scene.json --engine native",
        "report vtk run",
        "study plan campaign scene.json --members 2",
    ] {
        let arguments = [words(verb), vec![out(OsStr::new(&long))]].concat();
        let output = crossgrain_os(&arguments, &place);
        let (code, _, errors) = told(&output);
        assert_eq!(code, 2, "{verb:?}: {errors}");
        has(&errors, ["name too long"]);
    }
    assert_eq!(fs::read_dir(&place).expect("a folder").count(), 1);
    nothing_obeyed(&top, &crossgrain_os(&["paper", "numbers"], &place));
}

#[test]
fn engines_of_any_name_are_started_without_a_shell() {
    let toy = text_of(adapter_path("toy.py"));
    for name in names() {
        let (top, place) = place_named(&name);
        write_scene(&narrow_scene(0.05), &place.join("scene.json"));
        let path = program(&place, &name, &toy);
        let mut engine = OsString::from("--engine=exec:");
        engine.push(&path);
        let arguments = [words("run scene.json --steps 5 --out out"), vec![engine]].concat();
        let output = crossgrain_os(&arguments, &place);
        nothing_obeyed(&top, &output);
        let (code, _, errors) = told(&output);
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
        let mut arguments = words("run scene.json --engine yade --steps 10 --yade");
        arguments.extend([path.into_os_string(), out(&name_of_out(&name))]);
        let output = cli(&place).args(&arguments).env("TMPDIR", &place).output();
        let output = output.expect("the program starts");
        nothing_obeyed(&top, &output);
        told_by_yade(&name, &output);
    }
}

/// It works everywhere but in a folder whose name is no text, which is said.
fn told_by_yade(name: &OsStr, output: &Output) {
    let (code, _, errors) = told(output);
    if name.to_str().is_some() {
        assert_eq!(code, 0, "{name:?}: {errors}");
    } else {
        assert_eq!(code, 2, "{name:?}: {errors}");
        has(&errors, ["is not UTF-8 text"]);
    }
}

/// Another name of the same kind, since the program has the first one.
fn name_of_out(name: &OsStr) -> OsString {
    OsString::from_vec([name.as_bytes(), b"2"].concat())
}

#[test]
#[cfg_attr(not(feature = "yade"), ignore = "needs YADE: --features yade")]
fn the_real_yade_works_in_a_folder_of_any_name() {
    for name in names() {
        let (top, place) = place_named(&name);
        let run = words("run scene.json --engine yade --steps 5");
        let arguments = [run, vec![out(&name)]].concat();
        let output = crossgrain_os(&arguments, &place);
        nothing_obeyed(&top, &output);
        told_by_yade(&name, &output);
    }
}

#[test]
fn baselines_have_plain_names_and_stores_any() {
    let record = root("fuzz/corpus/record/reproduce");
    for name in names() {
        let (top, place) = place_named(&name);
        let before = fs::read_dir(&place).expect("a folder").count();
        let save = |arguments: &[&OsStr]| {
            let mut all = ["report", "baseline", "save"].map(OsStr::new).to_vec();
            all.extend(arguments);
            crossgrain_os(&all, &place)
        };
        let output = save(&[OsStr::new("--"), record.as_os_str(), &name]);
        nothing_obeyed(&top, &output);
        // Letters and dashes alone may be a name, however long up to a limit.
        let plain = name == "-rf" || name == "--help";
        let (code, _, errors) = told(&output);
        assert_eq!(code, if plain { 0 } else { 2 }, "{name:?}: {errors}");
        if !plain {
            assert_eq!(fs::read_dir(&place).expect("a folder").count(), before);
        }
        let mut store = OsString::from("--store=");
        store.push(&name);
        let output = save(&[record.as_os_str(), OsStr::new("main"), &store]);
        nothing_obeyed(&top, &output);
        assert_eq!(told(&output).0, 0, "{name:?}: {}", told(&output).2);
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
    assert_eq!(fs::read_dir(&place).expect("a folder").count(), 1);
}
