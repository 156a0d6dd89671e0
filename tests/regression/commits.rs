//! Records of the commits of a repository: the history of a check, and the commit that made it worse.

use crate::support::*;

/// A record of one check between 0 and 2 and of one speed.
fn record(value: f64, speed: f64) -> String {
    let outcome = if value <= 2.0 { "pass" } else { "fail" };
    format!(
        r#"{{"job": "verify", "version": 1, "crossgrain": "0", "command": "c", "verdict": "{outcome}", "machine_kind": "m",
        "checks": [{{"id": "fall/height", "quantity": "height", "unit": "m", "value": {value}, "expected": 1.0, "lower": 0.0,
        "upper": 2.0, "method": "", "basis": "", "n": 1, "interval": null, "outcome": "{outcome}", "found": ""}}],
        "speeds": [{{"id": "pace", "what": "the pace", "unit": "times", "value": {speed}, "range": [{}, {}],
        "less_is_better": true}}]}}"#,
        0.99 * speed,
        1.01 * speed
    )
}

/// A repository whose commits have these values in a file of their own; none stands for a commit that cannot be built.
fn repository(folder: &Path, values: &[Option<[f64; 2]>]) -> Vec<String> {
    git(folder, &["init", "-q"]);
    let script = "mkdir out; grep -v broken made.json > out/verify.json || rm out/verify.json\n";
    fs::write(folder.join("make.sh"), script).expect("written");
    let commits = values.iter().enumerate().map(|(index, numbers)| {
        let text = numbers.map_or("broken".to_owned(), |[value, speed]| record(value, speed));
        fs::write(folder.join("made.json"), format!("{text}\n")).expect("written");
        fs::write(folder.join("count"), index.to_string()).expect("written");
        git(folder, &["add", "-A"]);
        git(folder, &["commit", "-q", "-m", &format!("change {index}")]);
        git(folder, &["rev-parse", "HEAD"])
    });
    commits.collect()
}

/// The recipe of the docs, word for word but for the two commits. `verify` makes the record that the commit has.
#[test]
fn the_recipe_finds_the_commit_that_made_something_worse() {
    let folder = &new_folder();
    let (sound, moved, slow, failing) = ([1.0, 10.0], [1.5, 10.0], [1.5, 12.0], [2.5, 12.0]);
    let mut values = [
        sound, sound, moved, moved, slow, slow, slow, failing, failing,
    ]
    .map(Some);
    values[6] = None;
    let commits = repository(folder, &values);
    let page = text_of(root("docs/checks.md"));
    let begins = page.find("git bisect start BAD GOOD").expect("a recipe");
    let (recipe, _) = page[begins..].split_once("```").expect("its end");
    let bin = &new_folder();
    let text = format!(
        "#!/bin/sh\n[ $1 = verify ] || exec {0} \"$@\"\n{0} \"$@\" --help >/dev/null && exec sh make.sh\n",
        env!("CARGO_BIN_EXE_crossgrain")
    );
    program(bin, "crossgrain", &text);
    let found = |good: usize, bad: usize| {
        let [value, speed] = values[good].expect("a sound commit");
        fs::write(folder.join("kept.json"), record(value, speed)).expect("written");
        let save = "report baseline save kept.json a --store history --replace";
        ends(folder, 0, save);
        let recipe = recipe.replace("BAD", &commits[bad]);
        let recipe = recipe.replace("GOOD", &commits[good]);
        let path = format!("export LC_ALL=C PATH={}:$PATH", bin.display());
        let (_, said, errors) = bash(folder, &format!("{path}\n{recipe}"), &[]);
        let head = git(folder, &["rev-parse", "HEAD"]);
        assert_eq!(head, commits[8], "{said}{errors}");
        said
    };
    // A value that moves within its limits is no worse.
    has(
        &found(0, 5),
        [&format!("{} is the first bad commit", commits[4])],
    );
    // A commit without a record is skipped.
    let found = found(5, 8);
    has(
        &found,
        [
            "There are only 'skip'ped commits left",
            &commits[6],
            &commits[7],
        ],
    );
    assert!(!found.contains(&commits[8]), "{found}");
}

#[test]
fn a_history_says_which_commit_changed_what() {
    let place = &new_folder();
    let folder = &place.join("engine");
    fs::create_dir(folder).expect("created");
    // The seventh is slow once; nothing follows from one record.
    let values = [
        [1.0, 10.0],
        [1.5, 10.0],
        [1.5, 12.0],
        [1.5, 12.0],
        [2.5, 12.0],
        [1.5, 12.0],
        [1.5, 20.0],
        [1.5, 12.0],
    ];
    let commits = repository(folder, &values.map(Some));
    let keep = |last: usize| {
        for ([value, speed], commit) in values.into_iter().zip(&commits).take(last) {
            fs::write(place.join("record.json"), record(value, speed)).expect("written");
            let command =
                &format!("report baseline save ../record.json {commit} --store ../{last}");
            ends(folder, 0, command);
        }
        format!("report history --repository . --store ../{last} --out ../over-time")
    };
    let (said, _) = ends(folder, 0, &keep(8));
    let short = |index: usize| &commits[index][..12];
    let row = |index: usize, what: &str| {
        let (change, mut lines) = (format!("change {index}"), said.lines());
        let found = lines.any(|line| {
            let cells = line
                .split("  ")
                .map(str::trim)
                .filter(|cell| !cell.is_empty());
            let cells: Vec<&str> = cells.collect();
            let wanted = [short(index), what, change.as_str()];
            cells.first() == Some(&wanted[0]) && wanted.iter().all(|cell| cells.contains(cell))
        });
        assert!(found, "{what}: {said}");
    };
    row(1, "1");
    row(2, "SLOWER");
    row(4, "new failure");
    row(5, "fixed");
    let words = "In 8 records: new or worse failures 1, repaired 1, slower 1, faster 0";
    has(&said, [words]);
    let page = text_of(place.join("over-time/report.html"));
    has(&page, ["fall/height", "the pace", "history.svg"]);
    // The newest fails, or was slowed down by the last but one.
    ends(folder, 1, &keep(5));
    let words = "speeds that became slower in the last two records";
    tells(folder, 1, &keep(4), [words]);
    tells(folder, 2, &keep(1), ["a history needs two records"]);
}

/// Settings of a repository that start a program.
const STARTERS: &str = "
    log.showSignature ⇒ true
    gpg.program ⇒ PROGRAM
    core.fsmonitor ⇒ PROGRAM
    core.hooksPath ⇒ HOOKS
    core.pager ⇒ PROGRAM
    pager.log ⇒ true
    core.sshCommand ⇒ PROGRAM
    filter.all.smudge ⇒ PROGRAM
    filter.all.clean ⇒ PROGRAM
    filter.all.process ⇒ PROGRAM
    diff.all.textconv ⇒ PROGRAM
    diff.external ⇒ PROGRAM
    core.alternateRefsCommand ⇒ PROGRAM
    remote.origin.uploadpack ⇒ PROGRAM
    remote.origin.url ⇒ .
    remote.origin.promisor ⇒ true
";

#[test]
fn a_repository_of_others_starts_no_program_and_is_not_written_into() {
    let place = &new_folder();
    let folder = &place.join("engine");
    fs::create_dir(folder).expect("created");
    fs::write(folder.join(".gitattributes"), "* filter=all diff=all\n").expect("written");
    let mut commits = repository(folder, &[Some([1.0, 10.0]), Some([2.5, 10.0])]);
    // The newest is signed.
    let signed = git(folder, &["cat-file", "-p", "HEAD"]).replacen(
        "\n\n",
        "\ngpgsig -----BEGIN PGP SIGNATURE-----\n \n AAAA\n -----END PGP SIGNATURE-----\n\n",
        1,
    );
    fs::write(place.join("signed"), format!("{signed}\n")).expect("written");
    let object = "hash-object -t commit -w ../signed";
    commits[1] = git(folder, &object.words());
    git(folder, &["reset", "-q", "--hard", &commits[1]]);
    let ran = place.join("ran");
    let text = format!("#!/bin/sh\necho $0 \"$@\" >>{}\ncat\n", ran.display());
    let hooks = place.join("hooks");
    fs::create_dir(&hooks).expect("created");
    for hook in [
        "post-checkout",
        "reference-transaction",
        "post-index-change",
    ] {
        program(&hooks, hook, &text);
        program(&folder.join(".git/hooks"), hook, &text);
    }
    let program = program(place, "program", &text).display().to_string();
    for [name, value] in rows(STARTERS) {
        let value = value.replace("PROGRAM", &program);
        let value = value.replace("HOOKS", &hooks.display().to_string());
        git(folder, &["config", name, &value]);
    }
    git(folder, &["log", "-1"]);
    assert!(ran.exists(), "git itself starts them");
    fs::remove_file(&ran).expect("removed");
    for (commit, value) in commits.iter().zip([1.0, 2.5]) {
        fs::write(place.join("record.json"), record(value, 10.0)).expect("written");
        ends(
            place,
            0,
            &format!("report baseline save record.json {commit} --store kept"),
        );
    }
    let state = || {
        let mut files = below(&folder.join(".git"));
        files.retain(|file| file.is_file());
        files.sort();
        let files = files
            .into_iter()
            .map(|file| (fs::read(&file).expect("read"), file));
        files.collect::<Vec<_>>()
    };
    let before = state();
    let inside = &folder.join("deeper");
    fs::create_dir(inside).expect("created");
    for repository in [folder, inside] {
        let repository = repository.strip_prefix(&**place).expect("inside").display();
        let history = format!("report history --store kept --repository {repository}");
        tells(place, 1, &history, ["change 1"]);
    }
    assert!(!ran.exists(), "{}", text_of(&ran));
    assert!(state() == before);
    tells(
        place,
        2,
        "report history --store kept --repository kept",
        ["is in no git repository; name the folder of one"],
    );
}

#[test]
fn of_eight_that_keep_a_baseline_of_one_name_at_once_one_does() {
    let place = &new_folder();
    fs::write(place.join("record.json"), record(1.0, 10.0)).expect("written");
    for time in 0..12 {
        let save = format!("report baseline save record.json main --store kept-{time}");
        let all: Vec<Child> = (0..8).map(|_| started(place, &save)).collect();
        let codes = all
            .into_iter()
            .map(|mut child| child.wait().expect("it ends"));
        let mut codes: Vec<_> = codes.map(|status| status.code()).collect();
        codes.sort_unstable();
        let one = [0, 2, 2, 2, 2, 2, 2, 2].map(Some);
        assert_eq!(codes, one, "time {time}");
    }
}

#[test]
fn whoever_makes_a_folder_can_use_it_whatever_the_umask() {
    use std::os::unix::fs::PermissionsExt;
    let place = &new_folder();
    fs::write(place.join("record.json"), record(1.0, 10.0)).expect("written");
    let save = "umask 777 && $0 report baseline save record.json main --store deep/kept";
    let (code, _, errors) = bash(place, save, &[]);
    assert_eq!(code, 0, "{errors}");
    for made in ["deep", "deep/kept"] {
        let mode = fs::metadata(place.join(made)).expect("made").permissions();
        assert_eq!(mode.mode() & 0o777, 0o700, "{made}");
    }
}
