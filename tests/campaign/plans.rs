//! A plan is made once and never changed.

use crossgrain::study::{campaign::Campaign, plan::Plan};

use super::{MEMBERS, must, plan, study};

use crate::support::*;

#[test]
fn a_plan_is_written_into_a_folder_of_its_own() {
    let place = &folder_with(&tiny_scene());
    let plan = "study plan campaign scene.json --members 3 --seed 7 --out c";
    let (out, _) = ends(place, 0, plan);
    has(&out, ["realizations 7 to 9"]);
    let before = fs::read(place.join("c/plan.json")).expect("a plan");
    tells(place, 2, plan, ["exists already"]);
    let after = fs::read(place.join("c/plan.json")).expect("a plan");
    assert_eq!(after, before);
    for members in ["0", "1000001"] {
        let plan = format!("study plan campaign scene.json --members {members} --out d");
        tells(place, 2, &plan, ["1 to 1000000"]);
    }
    assert!(!place.join("d").exists());
}

/// What the verbs answer.
fn all_refuse(place: &Path, why: &str) {
    for verb in ["run", "status", "merge"] {
        has(&study(place, 2, verb, &[]).1, [why]);
    }
}

#[test]
fn an_edited_plan_is_refused() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    must(place, "run", &["--shard", "1/8"]);
    let path = place.join("c/plan.json");
    let text = text_of(&path);
    let changed = "was changed after it was made";
    let colour = "\"phases\": [],\n  \"colour\": 1";
    let version = |number: u8| format!("\"version\": {number},\n  \"made_with\"");
    for (from, to, why) in [
        (version(1).as_str(), version(2).as_str(), "has version 2"),
        ("\"members\": 24", "\"members\": 25", changed),
        ("\"seed\": 1,", "\"seed\": 2,", changed),
        ("\"phases\": []", colour, "unknown field `colour`"),
        ("\"crossgrain\": \"", "\"crossgrain\": \"9.", changed),
        ("\"width\": 0.15", "\"width\": 0.16", changed),
        ("\"width\": 0.15", "\"width\": -0.15", changed),
        ("{", "", "plan.json"),
    ] {
        assert!(text.contains(from), "{from} is not in {text}");
        fs::write(&path, text.replacen(from, to, 1)).expect("writable");
        all_refuse(place, why);
    }
}

#[test]
fn a_plan_of_another_version_is_not_run() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    let mut other = Plan::<Campaign>::read(&place.join("c")).expect("a plan");
    other.made_with.crossgrain = "0.0.9".to_owned();
    fs::remove_dir_all(place.join("c")).expect("a folder");
    other.write(&place.join("c")).expect("writable");
    let (_, errors) = study(place, 2, "run", &[]);
    has(&errors, ["planned with crossgrain 0.0.9"]);
    study(place, 2, "slurm", &["--tasks", "2"]);
    study(place, 3, "status", &[]);
}

#[test]
fn a_folder_without_a_plan_is_no_campaign() {
    let place = &new_folder();
    all_refuse(place, "there is no such folder");
    fs::create_dir(place.join("c")).expect("writable");
    all_refuse(place, "it has no plan.json");
}

/// What Slurm is told, and by which scripts; that they work is shown where there is a Slurm.
#[test]
fn scripts_for_slurm() {
    let place = &plan(&tiny_scene(), MEMBERS, "c");
    let options = "--tasks 8 --threads 2 --partition long".words();
    let out = must(place, "slurm", &options);
    let folder = fs::canonicalize(place.join("c")).expect("a folder");
    let expected = format!(
        "job=$(sbatch --parsable --array=1-8 '{0}/slurm/array.sh')\n\
         sbatch --parsable --dependency=afterany:${{job%%;*}} '{0}/slurm/merge.sh'\n",
        folder.display()
    );
    assert_eq!(out, expected);
    let script = text_of(folder.join("slurm/array.sh"));
    has(&script, ["#SBATCH --cpus-per-task=2\n", "--threads 2\n"]);
    has(&script, ["#SBATCH --partition=long\n", "--shard auto "]);
    has(&script, ["export CROSSGRAIN_TASKS=8\n"]);
    // A task by hand: the variables are all that a shard needs.
    let task = |script: &Path, task: &str| {
        let status = Command::new("bash")
            .arg(script)
            .env("SLURM_ARRAY_TASK_ID", task)
            .current_dir("/")
            .status();
        status.expect("bash is there").code()
    };
    assert_eq!(task(&folder.join("slurm/array.sh"), "3"), Some(0));
    assert_eq!(super::lines(&super::records(&folder, "3/8")), 3);
    assert_eq!(task(&folder.join("slurm/merge.sh"), ""), Some(3));
    let said = text_of(folder.join("slurm/merge.log"));
    has(&said, ["are missing, 21 of 24"]);
    for (options, why) in [
        (vec!["--tasks", "25"], "25 tasks for 24 rows"),
        (vec!["--tasks", "0"], "0 shards"),
    ] {
        has(&study(place, 2, "slurm", &options).1, [why]);
    }
    let options = ["--tasks", "2", "--partition", "a b"];
    let (_, errors) = study(place, 2, "slurm", &options);
    has(&errors, ["no name of a partition"]);
}
