//! A campaign as a real Slurm job array. Without the feature `live` this is listed as ignored and not made; with it a
//! missing Slurm is a failure. `ci/test` starts one with `ci/start_slurm` and runs it.

use crate::campaign::{lines, merged_bytes, plan, undisturbed};
use crate::support::*;

/// What a shell prints for these lines, in which every command must succeed.
fn shell(lines: &str) -> String {
    let (code, out, errors) = bash(Path::new("."), &format!("set -eu\n{lines}"), &[]);
    assert_eq!(code, 0, "{lines}: {out}{errors}");
    out.trim().to_owned()
}

/// Waits until the job has left the queue.
fn wait_for(job: &str) {
    let queue = format!("squeue -h -j {job} 2>/dev/null || true");
    within(100, "the job ends", || shell(&queue).is_empty());
}

/// An array of four tasks, two at a time; the third is ended in the middle, and the merge that waited for the array
/// says what is missing. The third is submitted again alone, with a merge after it: the bytes are those of one process.
/// The folder's name would break a script that does not quote it.
#[test]
#[cfg_attr(not(feature = "live"), ignore = "needs Slurm: --features live")]
fn an_array_with_a_killed_task_gives_the_bytes_of_one_process() {
    assert!(
        std::env::var_os("SLURM_CONF").is_some(),
        "no Slurm: ci/start_slurm FOLDER, then SLURM_CONF=FOLDER/slurm.conf"
    );
    // So many that none of them is done before it is ended, on a busy machine too.
    const MEMBERS: u64 = 400;
    let name = "it's $HOME, 100%";
    let place = &plan(&tiny_scene(), MEMBERS, name);
    let folder = place.join(name);
    let (out, _) = ends(place, 0, &["study", "slurm", name, "--tasks", "4"]);
    let submit: Vec<&str> = out.lines().collect();
    assert_eq!(submit.len(), 2, "{out}");

    // The lines as they are printed, two tasks at a time.
    let array = submit[0].replace("--array=1-4", "--array=1-4%2");
    assert_ne!(array, submit[0]);
    let jobs = shell(&format!("{array}\necho \"$job\"\n{}", submit[1]));
    let (job, merge) = jobs.split_once('\n').expect("two jobs");

    let third = folder.join("records/shard-3-of-4.jsonl");
    within(100, "the third task writes", || lines(&third) >= 2);
    shell(&format!("scancel {job}_3"));
    wait_for(job);
    wait_for(merge);
    let written = lines(&third);
    let middle = (2..MEMBERS as usize / 4).contains(&written);
    assert!(middle, "{written} of the third task");
    let says = |name: &str, words: &str| has(&text_of(folder.join("slurm").join(name)), [words]);
    says("task-3.log", "asked to end");
    says("merge.log", "are missing");
    assert!(!folder.join("merged.json").exists());
    ends(place, 3, &["study", "status", name]);

    let again = submit[0].replace("--array=1-4", "--array=3");
    let jobs = shell(&format!("{again}\necho \"$job\"\n{}", submit[1]));
    let merge = jobs.lines().last().expect("two jobs");
    wait_for(merge);
    let goes_on = format!("{written} of them finished before");
    says("task-3.log", &goes_on);
    says("merge.log", &format!("merged {MEMBERS} rows"));
    assert_eq!(merged_bytes(&folder), undisturbed(&tiny_scene(), MEMBERS));
}
