//! Records of the commits of a repository: the history of a check, and the commit that moved it.

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
    let script = "mkdir out; grep -v broken made.json > out/record.json || rm out/record.json\n";
    fs::write(folder.join("make.sh"), script).expect("written");
    let commits = values.iter().enumerate().map(|(index, of)| {
        let text = of.map_or("broken".to_owned(), |[value, speed]| record(value, speed));
        fs::write(folder.join("made.json"), format!("{text}\n")).expect("written");
        fs::write(folder.join("count"), index.to_string()).expect("written");
        git(folder, &["add", "-A"]);
        git(folder, &["commit", "-q", "-m", &format!("change {index}")]);
        git(folder, &["rev-parse", "HEAD"])
    });
    commits.collect()
}

/// What is looked for between which commits, how that ends, and what is said.
const BISECTED: &str = "
    fall/height ⇒ 0 ⇒ 3 ⇒ 0 ⇒ fall/height changed in {2} change 2
    fall/height ⇒ 5 ⇒ 8 ⇒ 3 ⇒ fall/height changed in one of
    pace ⇒ 0 ⇒ 5 ⇒ 0 ⇒ pace changed in {4} change 4
    fall/height ⇒ 2 ⇒ 3 ⇒ 2 ⇒ give two commits between which it changed
    fall/depth ⇒ 0 ⇒ 8 ⇒ 2 ⇒ which is to be good: there is no check fall/depth in its record
    fall/height ⇒ 6 ⇒ 8 ⇒ 2 ⇒ no record; the command ended with
";

#[test]
fn the_commit_that_moved_a_check_or_a_speed_is_found() {
    let folder = &new_folder();
    let sound = Some([1.0, 10.0]);
    let moved = Some([1.5, 10.0]);
    let slow = Some([1.5, 12.0]);
    let failing = Some([2.5, 12.0]);
    let then = [slow, slow, None, failing, failing];
    let commits = repository(folder, &[&[sound, sound, moved, moved][..], &then].concat());
    let bisect = |id: &str, good: usize, bad: usize| {
        let between = format!("--good {} --bad {}", commits[good], commits[bad]);
        format!("report bisect {id} {between} --record out/record.json -- sh make.sh")
    };
    for [id, good, bad, code, words] in rows(BISECTED) {
        let [good, bad, code] = [good, bad, code].map(|of| of.parse::<usize>().expect("a number"));
        let short = |of: usize| &commits[of][..7];
        let words = words.replace("{2}", short(2)).replace("{4}", short(4));
        tells(folder, code as i32, &bisect(id, good, bad), [&words]);
    }
    // By the outcome that changed, though the value had moved before.
    let (found, tried) = ends(folder, 3, &bisect("fall/height", 0, 8));
    has(&found, [&commits[6], &commits[7]]);
    let words = "change 4: as before (pass: height: 1.5 m, must be 0 to 2)";
    has(&tried, [words]);
    assert!(!found.contains(&commits[2]), "{found}");
    let elsewhere = bisect("pace", 0, 5).replace("sh make.sh", "no-such-program");
    let words = "no-such-program could not be started";
    tells(folder, 2, &elsewhere, [words]);
    let unknown = bisect("pace", 0, 5).replace(&commits[0], "nowhere");
    tells(folder, 2, &unknown, ["git rev-parse"]);
    // The user's own tree is as it was.
    assert_eq!(git(folder, &["status", "--porcelain"]), "");
    assert_eq!(git(folder, &["worktree", "list"]).lines().count(), 1);
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
    let short = |of: usize| &commits[of][..12];
    let row = |of: usize, what: &str| {
        let (change, mut lines) = (format!("change {of}"), said.lines());
        let found = lines.any(|line| {
            let cells = line.split("  ").map(str::trim).filter(|of| !of.is_empty());
            let cells: Vec<&str> = cells.collect();
            let wanted = [short(of), what, change.as_str()];
            cells.first() == Some(&wanted[0]) && wanted.iter().all(|of| cells.contains(of))
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
