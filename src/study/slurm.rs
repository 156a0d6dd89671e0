//! The job scripts that run a study as a Slurm job array of its shards, and merge it.

use std::path::Path;

use crate::files::{make_folder, whole_path, write_whole};
use crate::study::StudyError;
use crate::study::folder::AnyStudy;
use crate::study::shard::{Shard, TASKS_VARIABLE};

/// Writes `slurm/array.sh` and `slurm/merge.sh` into the study's folder, and tells how they are submitted: two lines for a
/// shell, the second of which uses what the first one found out. Earlier scripts are replaced: what Slurm runs is its own copy.
/// Task k of the array runs shard k of so many `tasks` with so many `threads` and processors; `partition` is where the cluster
/// wants one to be named.
pub fn write(
    folder: &Path,
    study: &dyn AnyStudy,
    tasks: u64,
    threads: u16,
    partition: Option<&str>,
    program: &Path,
) -> Result<[String; 2], StudyError> {
    study.check_program()?;
    Shard::new(1, tasks).map_err(StudyError::Usage)?;
    let rows = study.count();
    if tasks > rows {
        let why = format!("{tasks} tasks for {rows} rows: some would have nothing to do");
        return Err(StudyError::Usage(why));
    }
    let plain = |character: char| character.is_ascii_alphanumeric() || "_-.,".contains(character);
    let strange =
        |name: &&str| name.is_empty() || name.starts_with('-') || !name.chars().all(plain);
    if let Some(name) = partition.filter(strange) {
        let why = format!("{name:?} is no name of a partition");
        return Err(StudyError::Usage(why));
    }
    // A task starts in another folder.
    let folder = whole_path(folder)?;
    let scripts = folder.join("slurm");
    let [array_path, merge_path] = [scripts.join("array.sh"), scripts.join("merge.sh")];
    let (place, program) = (quoted(&folder)?, quoted(program)?);
    let partition = partition.map_or(String::new(), |name| {
        format!("#SBATCH --partition={name}\n")
    });
    // The program replaces the shell, so that signals reach it. What is said goes into a file that the script itself opens:
    // Slurm gives `%` and `\` in the names of its own files a meaning.
    let script =
        |name: &str, processors: u16, first: &str, log: &str, [verb, options]: [&str; 2]| {
            format!(
                "#!/bin/bash\n\
             #SBATCH --job-name={name}\n\
             #SBATCH --ntasks=1\n\
             #SBATCH --cpus-per-task={processors}\n\
             #SBATCH --requeue\n\
             #SBATCH --output=/dev/null\n\
             {partition}\
             {first}\
             folder={place}\n\
             exec >>\"$folder/slurm/{log}\" 2>&1\n\
             echo \"job ${{SLURM_JOB_ID:-}} on $(hostname), $(date -u +%FT%TZ)\"\n\
             exec {program} study {verb} \"$folder\"{options}\n"
            )
        };
    let first = format!(
        "# A task of the array 1-{tasks} is a shard of the study. A task that was ended is submitted again alone,\n\
         # as with --array=3, and goes on with the rows that it had not finished.\n\
         export {TASKS_VARIABLE}={tasks}\n"
    );
    let log = "task-${SLURM_ARRAY_TASK_ID:?is for a task of a job array}.log";
    let options = format!(" --shard auto --threads {threads}");
    let of_array = script("crossgrain", threads, &first, log, ["run", &options]);
    let first = "# Exit code 3: rows are missing; the log says which.\n";
    let of_merge = script("crossgrain-merge", 1, first, "merge.log", ["merge", ""]);
    make_folder((&folder, "slurm"))?;
    write_whole((&folder, "slurm/array.sh"), of_array.as_bytes())?;
    write_whole((&folder, "slurm/merge.sh"), of_merge.as_bytes())?;
    let (array_path, merge_path) = (quoted(&array_path)?, quoted(&merge_path)?);
    // Where there are several clusters, --parsable gives the job's number with a cluster's name after it.
    Ok([
        format!("job=$(sbatch --parsable --array=1-{tasks} {array_path})"),
        format!("sbatch --parsable --dependency=afterany:${{job%%;*}} {merge_path}"),
    ])
}

/// The path as one word of a shell, whatever is in it; lines that are to be copied cannot hold a line's end.
fn quoted(path: &Path) -> Result<String, StudyError> {
    let refused = |why: &str| {
        StudyError::Usage(format!(
            "{} {why}, which job scripts cannot name; give it another name",
            path.display()
        ))
    };
    let text = path.to_str().ok_or_else(|| refused("is not UTF-8 text"))?;
    if text.chars().any(char::is_control) {
        return Err(refused("has a line's end or another control character"));
    }
    Ok(format!("'{}'", text.replace('\'', r"'\''")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn any_path_is_one_word_of_a_shell() {
        for path in [
            "/plain",
            "/with space",
            "/it's",
            r#"/"double" $HOME `id` \back %a #no !x"#,
            "/größe",
            "/''",
        ] {
            let word = quoted(Path::new(path)).expect("a path that can be quoted");
            let told = std::process::Command::new("bash")
                .args(["-c", &format!("printf %s {word}")])
                .output()
                .expect("bash is there");
            assert_eq!(String::from_utf8_lossy(&told.stdout), path);
        }
        for refused in ["/two\nlines", "/a\rb", "/tab\t"] {
            assert!(quoted(Path::new(refused)).is_err(), "{refused:?}");
        }
    }
}
