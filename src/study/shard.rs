//! Shards: the rows that one process makes; and the job scripts that run a study as a Slurm job array of them, and merge it.

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use crate::files::{make_folder, whole_path, write_whole};
use crate::study::StudyError;
use crate::study::machine::Machine;

/// Shard `index` of `of`, both from 1: the rows whose number leaves `index − 1` when counted from 0 and divided by
/// `of`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Shard {
    /// From 1.
    pub index: u64,
    pub of: u64,
}

/// The number of tasks of the whole array, set by our own job scripts: a single task that is submitted again is, to
/// Slurm, an array of one.
pub const TASKS_VARIABLE: &str = "CROSSGRAIN_TASKS";

/// More shards than this are more files than a folder should have.
const MOST: u64 = 100_000;

impl Shard {
    /// Everything in one process.
    pub const WHOLE: Shard = Shard { index: 1, of: 1 };

    pub fn new(index: u64, of: u64) -> Result<Self, String> {
        if of == 0 || of > MOST {
            return Err(format!("{of} shards; there are 1 to {MOST}"));
        }
        if index == 0 || index > of {
            return Err(format!("shard {index} of {of}; shards are counted from 1"));
        }
        Ok(Shard { index, of })
    }

    /// From the variables of a Slurm job array, read by `variable`. The number of shards is CROSSGRAIN_TASKS, or else
    /// that of the array; tasks are counted from the array's first.
    pub fn from_slurm(variable: impl Fn(&str) -> Option<String>) -> Result<Self, String> {
        let number = |name: &str| -> Result<Option<u64>, String> {
            let wrong = |text| format!("{name} is {text:?}, and must be a whole number");
            let parsed = variable(name).map(|text| text.trim().parse().map_err(|_| wrong(text)));
            parsed.transpose()
        };
        let task = number("SLURM_ARRAY_TASK_ID")?.ok_or_else(|| {
            "--shard auto is for a task of a Slurm job array, and SLURM_ARRAY_TASK_ID is not set; name the shard as \
             I/N, or leave --shard away"
                .to_owned()
        })?;
        if let Some(tasks) = number(TASKS_VARIABLE)? {
            return Shard::new(task, tasks);
        }
        let first = number("SLURM_ARRAY_TASK_MIN")?.unwrap_or(1);
        let step = number("SLURM_ARRAY_TASK_STEP")?.unwrap_or(1).max(1);
        let count = number("SLURM_ARRAY_TASK_COUNT")?.ok_or_else(|| {
            format!("SLURM_ARRAY_TASK_COUNT is not set, and neither is {TASKS_VARIABLE}")
        })?;
        let before = || format!("task {task} stands before the array's first, {first}");
        let place = task.checked_sub(first).ok_or_else(before)?;
        if place % step != 0 || place / step >= count {
            return Err(format!(
                "task {task} is not one of {count} from {first} in steps of {step}: number the array without gaps, as \
                 1-{count}, or set {TASKS_VARIABLE}"
            ));
        }
        Shard::new(place / step + 1, count)
    }

    /// Its rows of so many, in order.
    pub fn rows(&self, of: u64) -> impl Iterator<Item = u64> + use<> {
        (self.index..=of).step_by(self.of as usize)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}/{}", self.index, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong =
            || format!("{text:?} is not a shard; shards are named I/N, such as 3/8, or auto");
        let (index, of) = text.split_once('/').ok_or_else(wrong)?;
        Shard::new(
            index.parse().map_err(|_| wrong())?,
            of.parse().map_err(|_| wrong())?,
        )
    }
}

/// Writes `slurm/array.sh` and `slurm/merge.sh` into the study's folder, and tells how they are submitted: two lines for a
/// shell, the second of which uses what the first one found out. Earlier scripts are replaced: what Slurm runs is its own copy.
/// Task k of the array runs shard k of so many `tasks` with so many `threads` and processors; `partition` is where the cluster
/// wants one to be named.
pub fn write(
    folder: &Path,
    study: &dyn Machine,
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
    let plain = |of: char| of.is_ascii_alphanumeric() || "_-.,".contains(of);
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

    #[test]
    fn every_row_belongs_to_one_shard() {
        for of in [1, 2, 3, 7, 50] {
            let mut seen = vec![0; 41];
            for index in 1..=of {
                let shard = Shard::new(index, of).expect("a shard");
                for row in shard.rows(40) {
                    assert_eq!((row - 1) % of, index - 1);
                    seen[row as usize] += 1;
                }
            }
            assert!(seen[1..].iter().all(|times| *times == 1), "{of}: {seen:?}");
        }
    }

    #[test]
    fn tasks_of_an_array_are_shards() {
        let slurm = |task, first, count, tasks: Option<u64>| {
            Shard::from_slurm(|name| {
                let of: Option<u64> = match name {
                    "SLURM_ARRAY_TASK_ID" => task,
                    "SLURM_ARRAY_TASK_MIN" => first,
                    "SLURM_ARRAY_TASK_COUNT" => count,
                    TASKS_VARIABLE => tasks,
                    _ => None,
                };
                of.map(|of| of.to_string())
            })
        };
        let from_zero = slurm(Some(9), Some(0), Some(10), None);
        assert_eq!(from_zero, Ok(Shard { index: 10, of: 10 }));
        // One task again: to Slurm an array of one.
        let again = slurm(Some(3), Some(3), Some(1), Some(8));
        assert_eq!(again, Ok(Shard { index: 3, of: 8 }));
        assert!(slurm(None, None, None, None).is_err());
        let with_gaps = slurm(Some(7), Some(1), Some(3), None);
        assert!(with_gaps.is_err());
    }

    #[test]
    fn names_of_shards() {
        assert_eq!("3/8".parse(), Ok(Shard { index: 3, of: 8 }));
        for wrong in ["0/8", "9/8", "3", "a/b", "1/0", "-1/3", ""] {
            assert!(wrong.parse::<Shard>().is_err(), "{wrong}");
        }
    }
}
