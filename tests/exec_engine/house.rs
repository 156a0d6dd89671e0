//! An engine in a repository of its own, judged by `ci/judge_engine` as its CI would.

use crate::support::*;

/// What CI does with the newest commit: the exit code, and the summary.
fn judged(place: &Path, run: &str) -> (Option<i32>, String) {
    git(place, &["clone", "-q", "house.git", run]);
    judged_here(place, run, "engine.py")
}

fn judged_here(place: &Path, run: &str, engine: &str) -> (Option<i32>, String) {
    let code = ended(place, run, engine);
    let summary = text_of(place.join(run).join("crossgrain-out/summary.md"));
    (code, summary)
}

fn ended(place: &Path, run: &str, engine: &str) -> Option<i32> {
    let script = root("ci/judge_engine");
    let mut judge = Command::new("bash");
    judge.arg(script).arg(engine).current_dir(place.join(run));
    judge.env("CROSSGRAIN", env!("CARGO_BIN_EXE_crossgrain"));
    judge.env_remove("GITHUB_STEP_SUMMARY");
    judge.output().expect("bash is there").status.code()
}

#[test]
fn a_difference_that_was_accepted_is_green_until_it_grows() {
    let place = &new_folder();
    let damped = |share: &str| {
        let toy = changed_toy("0.5 * dt", &format!("{share} * dt"));
        program(place, "engine.py", &toy);
        judged_here(place, ".", "engine.py")
    };
    let (code, summary) = damped("0.4");
    assert_eq!(code, Some(1), "{summary}");
    for (record, name) in [("check/check", "main-check"), ("verify/verify", "main")] {
        let save = format!("report baseline save crossgrain-out/{record}.json {name}");
        ends(place, 0, &save);
    }
    let (code, summary) = damped("0.4");
    assert_eq!(code, Some(0), "{summary}");
    has(&summary, ["Nothing is worse than in main-check"]);
    has(&summary, ["Nothing is worse than in main:"]);
    has(&summary, ["accepted failures"]);
    let (code, summary) = damped("0.0");
    assert_eq!(code, Some(1), "{summary}");
    has(&summary, ["WORSE than main:", "WORSE FAILURE"]);
    // No baseline makes an engine green that ends before it has done anything.
    let crash = changed_toy("    steps = run(sys.argv[2])\n", "    sys.exit(1)\n");
    program(place, "engine.py", &crash);
    assert_eq!(ended(place, ".", "engine.py"), Some(4));
    for missing in ["", "nowhere/engine.py", "nowhere/"] {
        assert_eq!(ended(place, ".", missing), Some(2), "«{missing}»");
    }
}

#[test]
fn a_change_that_breaks_an_engine_turns_its_ci_red_and_the_summary_says_why() {
    let place = &new_folder();
    git(place, &"init -q --bare -b main house.git".words());
    git(place, &"clone -q house.git work".words());
    let work = place.join("work");
    let commit = |what: &str| {
        git(&work, &["add", "-A"]);
        git(&work, &["commit", "-q", "-m", what]);
        git(&work, &"push -q origin HEAD:main".words());
    };
    let toy = text_of(adapter_path("toy.py"));
    program(&work, "engine.py", &toy);
    commit("engine");
    let (code, summary) = judged(place, "first");
    assert_eq!(code, Some(0), "{summary}");
    let command = "report baseline save ../first/crossgrain-out/verify/verify.json main";
    ends(&work, 0, command);
    commit("baseline");
    let (code, summary) = judged(place, "second");
    assert_eq!(code, Some(0), "{summary}");
    has(&summary, ["Nothing is worse than in main"]);

    program(&work, "engine.py", &toy.replace("0.5 * dt", "0.0 * dt"));
    commit("faster");
    let (code, summary) = judged(place, "third");
    assert_eq!(code, Some(1), "{summary}");
    has(&summary, ["must be that of a·(v + ½Δt·a)"]);
    has(&summary, ["WORSE than main", "leapfrog-local-damping"]);
    // What an earlier run left is not judged in the place of a program that is missing.
    let (code, more) = judged_here(place, "third", "missing.py");
    assert_eq!(code, Some(2), "{more}");
    let [page, summary] = [&more, &summary].map(|text| text.matches("WORSE").count());
    assert_eq!(page, summary);
}

/// What the action's first step says for this source.
fn of_action(house: &Path, program: &str) -> BTreeMap<String, String> {
    let action = text_of(root("ci/judge/action.yml"));
    let of_step = action.split_once("id: source").expect("a step").1;
    let lines = of_step.split_once("run: |\n").expect("lines").1;
    let lines = lines.split_once("\n    - name").expect("another step").0;
    let output = house.join("output");
    let mut step = Command::new("bash");
    step.args(["-euo", "pipefail", "-c", lines]);
    step.env("GITHUB_ACTION_PATH", house.join("ci/judge"));
    let set = [("GITHUB_JOB", "judge"), ("PROGRAM", program)];
    let status = step.envs(set).env("GITHUB_OUTPUT", &output).status();
    assert!(status.expect("bash is there").success());
    let said = text_of(&output);
    fs::remove_file(&output).expect("removed");
    let pairs = said.lines().filter_map(|line| line.split_once('='));
    pairs
        .map(|(key, value)| (key.to_owned(), value.to_owned()))
        .collect()
}

#[test]
fn the_action_builds_what_its_source_says_and_names_each_use_apart() {
    let house = &new_folder();
    for folder in ["ci/judge", "src", "target"] {
        fs::create_dir_all(house.join(folder)).expect("created");
    }
    let write = |name: &str, text: &str| fs::write(house.join(name), text).expect("written");
    write("src/main.rs", "one");
    let first = of_action(house, "./my engine:2");
    write("target/made", "by the build");
    let second = of_action(house, "./my engine:2");
    assert_eq!(first["digest"], second["digest"]);
    assert!(first["use"].starts_with("judge-my-engine-2-"), "{first:?}");
    assert_ne!(first["use"], second["use"]);
    write("src/main.rs", "two");
    assert_ne!(of_action(house, "./engine")["digest"], first["digest"]);
    let action = text_of(root("ci/judge/action.yml"));
    has(
        &action,
        [
            "-${{ steps.source.outputs.digest }}\n",
            "name: crossgrain-${{ steps.source.outputs.use }}\n",
        ],
    );
}
