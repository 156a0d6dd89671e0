//! Job scripts of campaigns whose folder and program have names that a shell would obey: the scripts are run by a real shell,
//! with a program that says what it was given.

use std::ffi::{OsStr, OsString};

use crossgrain::study::slurm::write;
use crossgrain::study::{campaign::Campaign, folder::StudyFolder, plan::Plan, realization::Runner};

use crate::hostile_names::{harmless, names, two_grains};
use crate::support::*;

/// Writes its arguments, a line's end after each, into `given` beside itself.
const STUB: &str = "#!/bin/bash\nprintf '%s\\n' \"$@\" >\"$(dirname \"$0\")/given\"\n";

/// Runs a script or lines in an empty environment, and expects the best.
fn shell(arguments: &[&OsStr], place: &Path, path: &OsStr) {
    let output = Command::new("bash")
        .args(arguments)
        .current_dir(place)
        .env("PATH", path)
        .env("SLURM_ARRAY_TASK_ID", "2")
        .output()
        .expect("bash is there");
    let (code, _, errors) = harmless(place, &output);
    assert_eq!(code, 0, "{arguments:?}: {errors}");
}

#[test]
fn job_scripts_hand_every_name_on_whole() {
    let usual = std::env::var_os("PATH").unwrap_or_default();
    let mut written = 0;
    for name in names() {
        let top = &new_folder();
        let place = top.canonicalize().expect("a folder");
        let folder = place.join(&name);
        let campaign = Campaign::new(&two_grains(), Runner::Native, Vec::new(), 4, 1);
        let plan = Plan::new(campaign, None);
        plan.and_then(|plan| plan.write(&folder))
            .expect("a new campaign");
        let tools = place.join("tools");
        fs::create_dir(&tools).expect("a folder of ours");
        let stub = program(&tools, &name, STUB);
        let campaign = StudyFolder::<Campaign>::open(&folder).expect("a campaign");
        let scripts = || write(&folder, &campaign, 4, 3, None, &stub);
        let control = |letter: char| letter.is_control();
        if name.to_str().is_none_or(|name| name.contains(control)) {
            let refused = scripts().expect_err("no line of a shell holds it");
            has(&refused.to_string(), ["give it another name"]);
            assert!(!folder.join("slurm").exists(), "{name:?}: half-written");
            continue;
        }
        written += 1;
        let submit = scripts().expect("scripts");
        let [array, merge] = ["array.sh", "merge.sh"].map(|name| folder.join("slurm").join(name));
        let text = folder.to_str().expect("text");
        let run = format!("study\nrun\n{text}\n--shard\nauto\n--threads\n3\n");
        for (script, given) in [(&array, run), (&merge, format!("study\nmerge\n{text}\n"))] {
            shell(&[OsStr::new("-n"), script.as_os_str()], &place, &usual);
            shell(&[script.as_os_str()], &place, &usual);
            assert_eq!(text_of(tools.join("given")), given);
        }
        for log in ["task-2.log", "merge.log"] {
            assert!(folder.join("slurm").join(log).is_file(), "{name:?}: {log}");
        }
        // The printed lines, with an `sbatch` that says what it was given and prints a job's number.
        program(&tools, "sbatch", &format!("{STUB}echo '17;cluster'\n"));
        let mut path = OsString::from(&tools);
        path.push(":");
        path.push(&usual);
        let lines = submit.join("\n");
        shell(&[OsStr::new("-euc"), OsStr::new(&lines)], &place, &path);
        let merge = merge.to_str().expect("text");
        let given = format!("--parsable\n--dependency=afterany:17\n{merge}\n");
        assert_eq!(text_of(tools.join("given")), given);
    }
    assert!(written > 8, "{written}");
}
