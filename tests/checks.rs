//! Checks of a job as files for other programs, and baselines: from the command line.

use crate::support::*;

/// A record with these checks, as `(id, value, outcome)`, each expected to be 1 ± 0.5, and one speed.
fn record(folder: &Path, name: &str, checks: &[(&str, f64, &str)], yade_over_native: f64) {
    let failed = checks.iter().any(|(_, _, outcome)| *outcome == "fail");
    let check = |(id, value, outcome): &(&str, f64, &str)| {
        json!({
            "id": id, "quantity": "height", "unit": "m", "value": value, "expected": 1.0, "lower": 0.5, "upper": 1.5,
            "method": "by looking", "basis": "told so", "n": 1, "interval": null, "outcome": outcome, "found": "",
        })
    };
    let checks: Vec<Value> = checks.iter().map(check).collect();
    let record = json!({
        "job": "reproduce", "version": 1, "crossgrain": "0.1.0", "command": "crossgrain reproduce", "machine_kind": "a machine",
        "verdict": if failed { "fail" } else { "pass" }, "checks": checks, "comparisons": [],
        "speeds": [{"id": "time/ordinary", "what": "time a step of YADE over native", "unit": "times native",
            "value": yade_over_native, "range": null, "less_is_better": false}],
    });
    fs::write(folder.join(name), record.to_string()).expect("written");
}

/// A folder that goes away, with a record of one check that passed, `run.json`, in it.
fn with_a_record() -> Place {
    let folder = new_folder();
    record(&folder, "run.json", &[("a", 1.0, "pass")], 60.0);
    folder
}

const SAVE: &str = "report baseline save before.json main";

/// A folder that goes away, with a scene, a record that is the baseline `main`, and worse ones.
fn with_a_baseline() -> Place {
    let at = folder_with(&tiny_scene());
    let (height, wall, gone) = ("compare/a/height", "faults/wall", "verify/gone");
    let sound = [height, wall, gone].map(|id| (id, 1.0, "pass"));
    let broken = [(height, 1.7, "fail"), (wall, 1.2, "pass"), sound[2]];
    record(&at, "before.json", &sound, 60.0);
    record(&at, "broken.json", &broken, 60.0);
    record(&at, "fewer.json", &sound[..2], 60.0);
    record(&at, "slow.json", &sound, 30.0);
    ends(&at, 0, SAVE);
    at
}

/// A sound run that lacks a check of its baseline agrees with nothing.
#[test]
fn a_job_without_a_check_of_its_baseline_is_incomplete() {
    let at = &with_a_record();
    ends(at, 0, "report baseline save run.json main");
    let job = "reproduce --recorded --quiet --out o --baseline main";
    let (out, _) = ends(at, 3, job);
    has(&out, ["INCOMPLETE: Some of it cannot be told against main"]);
    has(
        &out,
        [" 0 failed", " measured numbers moved. Native against "],
    );
    let page = text_of(at.join("o/report.html"));
    let tally = out.lines().find(|line| line.contains(" checks passed, "));
    let tally = tally.expect("a count");
    has(&page, ["Agreed, but incomplete against main", tally]);
}

#[test]
fn a_regression_shows_in_words_files_and_exit_code() {
    let at = &with_a_baseline();
    // Never silently overwritten.
    tells(at, 2, SAVE, ["--replace"]);
    let list = "report baseline list";
    tells(at, 0, list, ["main: reproduce", "3 checks passed"]);

    let diff = |code: i32, record: &str| {
        let diff = format!("report baseline diff {record} main");
        ends(at, code, &diff).0
    };
    let out = diff(0, "before.json");
    has(&out, ["AGREED: Nothing is worse than in main"]);

    let out = diff(1, "broken.json");
    has(&out, ["WORSE"]);
    let line = |words: &str| {
        out.lines()
            .find(|line| line.contains(words))
            .expect("a row")
    };
    let failed = line("compare/a/height").trim_start();
    assert!(failed.starts_with("NEW FAILURE"), "{out}");
    let moved = line("faults/wall");
    assert!(moved.contains("moved") && moved.ends_with("0.4"), "{out}");

    // What fails as the baseline fails is accepted and named; what fails by far more is worse.
    let failing =
        |name: &str, value| record(at, name, &[("compare/a/height", value, "fail")], 60.0);
    failing("known.json", 4.55);
    ends(at, 0, "report baseline save known.json known");
    for (value, code, words) in [
        (4.55, 0, "1 accepted failure"),
        (5.55, 0, "1 accepted failure"),
        (53_290.0, 1, "WORSE FAILURE"),
    ] {
        failing("again.json", value);
        let diff = "report baseline diff again.json known --summary known.md";
        tells(at, code, diff, [words, "compare/a/height"]);
    }
    has(&text_of(at.join("known.md")), ["accepted failure"]);

    let out = diff(3, "fewer.json");
    has(&out, ["1 removed", "  removed  verify/gone "]);
    let out = diff(1, "slow.json");
    has(&out, ["slower", "2.000 times the cost"]);

    fs::write(at.join("s.md"), "an earlier step\n").expect("written");
    let checks = "report checks broken.json --junit j.xml --csv c.csv --summary s.md";
    let (out, _) = ends(at, 1, checks);
    let first = "            FAIL compare/a/height";
    assert!(out.starts_with(first), "{out}");
    let read = |name: &str| text_of(at.join(name));
    let junit = read("j.xml");
    has(&junit, ["failures=\"1\""]);
    has(&junit, ["height: 1.7 m, must be 0.5 to 1.5"]);
    assert_eq!(read("c.csv").lines().count(), 4);
    let summary = read("s.md");
    let begins = "an earlier step\n## reproduce: Different";
    assert!(summary.starts_with(begins), "{summary}");
}

#[test]
fn what_cannot_be_used_is_said_with_what_to_do() {
    let at = &with_a_record();
    let refused = |command: &[&str], words: &str| {
        let (_, errors) = ends(at, 2, command);
        assert!(errors.contains(words), "{command:?}: {errors}");
        errors
    };
    let baseline =
        |verb, record, name| ["report", "baseline", verb, record, name, "--store", "kept"];
    for (verb, record, name, words) in [
        ("save", "run.json", "../main", "is no name"),
        ("save", "run.json", "a b", "is no name"),
        ("diff", "run.json", "main", "there are none yet"),
        ("save", "missing.json", "main", "missing.json"),
    ] {
        refused(&baseline(verb, record, name), words);
    }
    assert!(!at.join("kept").exists(), "nothing is left behind");
    // What cannot be read is not a store without baselines.
    let mut diff = baseline("diff", "run.json", "main");
    diff[6] = "run.json";
    let errors = refused(&diff, "");
    assert!(!errors.contains("there are none yet"), "{errors}");
    fs::write(at.join("other.json"), "{\"version\": 1}").expect("written");
    refused(&["report", "checks", "other.json"], "no record of a job");
    // Another job's record says nothing of this one.
    let text = text_of(at.join("run.json"));
    let text = text.replace("\"reproduce\"", "\"verify\"");
    fs::write(at.join("other.json"), text).expect("written");
    ends(at, 0, &baseline("save", "run.json", "main"));
    let diff = baseline("diff", "other.json", "main");
    refused(&diff, "a run of the same job");
}

#[test]
fn checks_are_explained() {
    let at = &new_folder();
    let checks = [("parameters/everything/dt", 1.0, "pass")];
    record(at, "run.json", &checks, 60.0);
    let explain = "report explain parameters/everything/dt --record run.json";
    tells(at, 0, explain, ["meaning:", "must be 0.5 to 1.5"]);
    let unknown = "report explain bake/bread";
    tells(at, 2, unknown, ["begins with compare, first-steps"]);
    tells(at, 0, "report explain", ["verify/*"]);
}

#[test]
fn the_schema_in_the_documentation_is_the_one_of_the_types() {
    let written = text_of(root("docs/record.schema.json"));
    let (printed, _) = ends(&root(""), 0, "report checks --schema");
    assert_eq!(
        printed, written,
        "write it anew: crossgrain report checks --schema > docs/record.schema.json"
    );
}

/// A real job's record keeps to the common part, has a check for each figure of each case, and passes as it says.
#[test]
fn the_suite_has_its_checks_in_its_record() {
    let at = &new_folder();
    ends(at, 0, "verify --engine native --quiet --out verified");
    let record = crossgrain::checks::record::read(&at.join("verified/verify.json"));
    let record = record.expect("a record");
    assert_eq!(record.job, "verify");
    let checks = record.checks.iter();
    let fall = checks.filter(|check| check.id.starts_with("verify/tested/free-fall/"));
    assert!(fall.clone().count() > 1);
    for check in fall {
        let (value, upper) = (check.value.expect("a value"), check.upper.expect("a limit"));
        assert!(value <= upper && !check.basis.is_empty(), "{check:?}");
    }
    let ids: BTreeSet<&str> = record
        .checks
        .iter()
        .map(|check| check.id.as_str())
        .collect();
    assert_eq!(ids.len(), record.checks.len(), "ids are unique");
}

#[test]
fn shells_and_man_are_told_the_command_line() {
    let at = &new_folder();
    for shell in ["bash", "zsh", "fish"] {
        let (out, _) = ends(at, 0, &format!("shell completions {shell}"));
        assert!(out.contains("baseline"), "{shell}: {out}");
    }
    tells(at, 0, "shell man", [".TH crossgrain"]);
    ends(at, 0, "shell man --out .");
    assert!(at.join("crossgrain-reproduce.1").exists());
}

/// What has the name of a file that is written to is written into where it is no file, and stays what it is.
#[test]
fn a_pipe_is_written_into_and_not_replaced() {
    use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
    let at = &with_a_record();
    for (option, words) in [("junit", "<testsuites"), ("csv", "outcome,id")] {
        let pipe = a_pipe(at, option);
        // Held open from before: a thread that reads may come too late.
        let waits_for_none = rustix::fs::OFlags::NONBLOCK.bits() as i32;
        let mut reader = fs::OpenOptions::new();
        let reader = reader.read(true).custom_flags(waits_for_none).open(&pipe);
        let checks = format!("report checks run.json --{option} {option}");
        ends(at, 0, &checks);
        let kind = fs::symlink_metadata(&pipe).expect("is there").file_type();
        assert!(kind.is_fifo(), "{option} replaced the pipe");
        let said = std::io::read_to_string(reader.expect("a pipe"));
        assert!(said.expect("text").contains(words));
    }
}

/// The files that a verb that judges is asked for.
const FILES: [&str; 6] = ["--junit", "j.xml", "--csv", "c.csv", "--summary", "s.md"];

/// Runs a verb with those files in a folder, and holds them against each other: the same verdict as the exit code, a test case and a
/// row for each check, lasting ids that are explained. The value is the exit code, and the summary's first lines.
fn told_alike(arguments: &[&str], folder: &Path) -> (i32, String) {
    let (code, _, errors) = say(folder, &[arguments, &FILES].concat());
    let [junit, table, summary] = ["j.xml", "c.csv", "s.md"].map(|name| {
        let text = fs::read_to_string(folder.join(name));
        fs::remove_file(folder.join(name)).expect("was written");
        text.unwrap_or_else(|error| panic!("{arguments:?}: {name}: {error}: {errors}"))
    });
    let junit = roxmltree::Document::parse(&junit).expect("XML");
    let count = |attribute: &str| -> usize {
        let count = junit.root_element().attribute(attribute).expect("a count");
        count.parse().expect("a number")
    };
    let mut table = csv::Reader::from_reader(table.as_bytes());
    let rows: Vec<csv::StringRecord> = table.records().map(|row| row.expect("a row")).collect();
    let with = |outcome: &str| rows.iter().filter(|row| &row[0] == outcome).count();
    let (failed, passed) = (with("FAIL"), with("pass"));
    let skipped = [with("skipped"), with("expected failure")];
    assert_eq!(count("tests"), rows.len(), "{arguments:?}");
    assert_eq!(count("failures"), failed, "{arguments:?}");
    assert_eq!(count("skipped"), skipped[0] + skipped[1], "{arguments:?}");
    let [skips, expected] = skipped;
    let tally = format!(", {failed} failed, {skips} skipped, {expected} expected failures.");
    let tally = format!(" passed{tally}");
    has(&summary, [&format!("{passed} check"), &tally]);
    let (word, failures) = match code {
        0 => ("Agreed", false),
        1 => ("Different", true),
        3 => ("Incomplete", false),
        _ => panic!("{arguments:?}: {code} {errors}"),
    };
    let head = summary.lines().next().expect("a heading").to_owned();
    let told = head.ends_with(&format!(": {word}"));
    assert!(told, "{arguments:?}: {head}");
    assert_eq!(failed > 0, failures, "{arguments:?}");
    let mut seen = BTreeSet::new();
    for id in rows.iter().map(|row| &row[1]) {
        assert!(seen.insert(id.to_owned()), "{arguments:?}: {id} repeats");
        let explained = crossgrain::explain::of(id).is_some();
        assert!(explained, "{id} is not explained");
        let engines = ["yade", "lammps", "liggghts", "esys", "native"];
        assert!(engines.iter().all(|engine| !id.contains(engine)), "{id}");
    }
    (code, summary.lines().take(4).collect::<Vec<_>>().join("\n"))
}

#[test]
fn files_of_every_verb_say_what_its_exit_code_says() {
    let at = &with_a_baseline();
    let campaign = |name: &str| {
        let path = root("reference_data").join(format!("campaign-{name}-1"));
        path.to_str().expect("UTF-8").to_owned()
    };
    ends(at, 0, "study plan campaign scene.json --members 2 --out c");
    let [few, native, sorted] = ["yade-ordinary", "native", "yade-sorted"].map(campaign);
    let [half, lammps] = ["native-half", "lammps-half"].map(campaign);
    let diff = ["report", "baseline", "diff"];
    for (verb, rest, wanted) in [
        (&["paper", "numbers"][..], &[][..], 0),
        (&["study", "run", "c"], &["--quiet"], 0),
        (&["study", "report", "c"], &[], 0),
        (&["study", "compare"], &[&native, &sorted], 0),
        (&["study", "compare"], &[&half, &lammps], 3),
        (&["study", "claims", &few], &["--out", "claims"], 3),
        (&["report", "checks"], &["before.json"], 0),
        (&["report", "checks"], &["broken.json"], 1),
        (&diff, &["before.json", "main"], 0),
        (&diff, &["broken.json", "main"], 1),
        (&diff, &["fewer.json", "main"], 3),
        (&diff, &["slow.json", "main"], 1),
        (&diff, &["slow.json", "main", "--json"], 1),
    ] {
        let (code, head) = told_alike(&[verb, rest].concat(), at);
        assert_eq!(code, wanted, "{verb:?} {rest:?}: {head}");
    }
    // The summary says what the page says.
    let again = at.join("again.md");
    let claims = ["study", "claims", &few, "--out", "claims"];
    for (arguments, page) in [(&["study", "report", "c"][..], "c"), (&claims, "claims")] {
        say(at, &[arguments, &["--summary", "again.md"]].concat());
        let page = text_of(at.join(page).join("report.html")).replace("&#39;", "'");
        let summary = text_of(&again);
        fs::remove_file(&again).expect("was written");
        let head = summary.lines().next().expect("a heading");
        let (title, verdict) = head[3..].split_once(": ").expect("a verdict");
        has(&page, [&format!("<title>{title}: {verdict}</title>")]);
        for heading in summary.lines().filter_map(|line| line.strip_prefix("### ")) {
            let heading = heading.replace('\\', "");
            let on_page = page.contains(&format!(">{heading}</h2>"));
            assert!(on_page || heading.contains(" ("), "{heading}");
        }
    }
    // A part of a study is not judged.
    tells(at, 2, "study run c --shard 1/2 --junit j.xml", ["--shard"]);
}

#[test]
fn other_bits_are_a_failure_where_they_are_demanded() {
    let at = &new_folder();
    let checks = [("verify/a", 1.0, "pass")];
    for (name, value) in [("before.json", 1.0), ("after.json", 1.0 + f64::EPSILON)] {
        record(at, name, &checks, 60.0);
        let path = at.join(name);
        let mut record = json_of(&path);
        record["measured"] = json!([{"id": "height", "unit": "m", "value": value}]);
        fs::write(&path, record.to_string()).expect("written");
    }
    ends(at, 0, SAVE);
    let diff = ["report", "baseline", "diff", "after.json", "main"];
    assert_eq!(told_alike(&diff, at).0, 0);
    assert_eq!(told_alike(&[&diff[..], &["--bits"]].concat(), at).0, 1);
}

/// A job that ended with an error says so in the files of every verb that judges.
#[test]
fn errors_are_told_in_the_files_too() {
    let at = &new_folder();
    for (verb, rest) in [
        ("compare", "nowhere nowhere"),
        ("reproduce", "--scene nowhere.json"),
        ("verify", "--engine exec:./nowhere"),
        ("engine check", "exec:./nowhere"),
        ("engine table", "exec:./nowhere"),
        ("study run", "nowhere"),
        ("study report", "nowhere"),
        ("study compare", "nowhere nowhere"),
        ("study claims", "nowhere"),
        ("stability", "--quick --engine exec:./nowhere"),
        ("bench", "--quick --engine exec:./nowhere"),
        ("report checks", "nowhere.json"),
        ("report baseline diff", "nowhere.json main"),
    ] {
        let given = format!("{verb} {rest} --junit j.xml --summary s.md");
        let (code, out, _) = say(at, &given);
        assert!(code > 1, "{verb}: {code} {out}");
        let text = text_of(at.join("j.xml"));
        let junit = roxmltree::Document::parse(&text).expect("XML");
        let root = junit.root_element();
        let named = format!("crossgrain {verb}");
        let counts = ["name", "errors"].map(|attribute| root.attribute(attribute));
        assert_eq!(counts, [Some(named.as_str()), Some("1")]);
        let kind = format!("type=\"exit code {code}\"");
        assert!(text.contains(&kind), "{verb}: {code} {text}");
        let summary = text_of(at.join("s.md"));
        assert!(summary.starts_with(&format!("## {named}: ")), "{summary}");
        for name in ["j.xml", "s.md"] {
            fs::remove_file(at.join(name)).expect("was written");
        }
    }
}
