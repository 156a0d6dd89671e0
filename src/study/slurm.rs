//! Job scripts that run a study as a Slurm job array, and merge it.

use std::path::{Path, PathBuf};

use super::StudyError;
use super::machine::Machine;
use super::shard::{Shard, TASKS_VARIABLE};
use crate::files::{failed, write_whole};

/// What is asked of Slurm.
#[derive(Debug, Clone)]
pub struct Array<'a> {
    /// Tasks of the array; task k runs shard k of so many.
    pub tasks: u64,
    /// Rows at a time in a task, and processors that it asks for.
    pub threads: u16,
    /// Where the cluster wants one to be named.
    pub partition: Option<&'a str>,
    /// The program that the tasks start; an absolute path.
    pub program: &'a Path,
}

/// The scripts, and how they are submitted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Scripts {
    /// `slurm/array.sh` in the study's folder.
    pub array: PathBuf,
    /// `slurm/merge.sh` there.
    pub merge: PathBuf,
    /// Two lines for a shell; the second uses what the first one found out.
    pub submit: [String; 2],
}

/// Writes both scripts into the study's folder. Earlier ones are replaced: what Slurm runs is its own copy.
pub fn write(folder: &Path, study: &dyn Machine, array: &Array<'_>) -> Result<Scripts, StudyError> {
    study.check_program()?;
    Shard::new(1, array.tasks).map_err(StudyError::Usage)?;
    if array.tasks > study.count() {
        return Err(StudyError::Usage(format!(
            "{} tasks for {} rows: some would have nothing to do",
            array.tasks,
            study.count()
        )));
    }
    if let Some(name) = array.partition {
        let plain = |of: char| of.is_ascii_alphanumeric() || "_-.,".contains(of);
        if name.is_empty() || name.starts_with('-') || !name.chars().all(plain) {
            return Err(StudyError::Usage(format!(
                "{name:?} is no name of a partition"
            )));
        }
    }
    // A task starts in another folder.
    let folder = folder.canonicalize().map_err(failed("find", folder))?;
    let texts = Texts {
        folder: quoted(&folder)?,
        program: quoted(array.program)?,
        partition: array
            .partition
            .map(|name| format!("#SBATCH --partition={name}\n"))
            .unwrap_or_default(),
    };
    let scripts = folder.join("slurm");
    std::fs::create_dir_all(&scripts).map_err(failed("create", &scripts))?;
    let [array_path, merge_path] = [scripts.join("array.sh"), scripts.join("merge.sh")];
    write_whole(&array_path, texts.array(array).as_bytes())?;
    write_whole(&merge_path, texts.merge().as_bytes())?;
    // Where there are several clusters, --parsable gives the job's number with a cluster's name after it.
    let submit = [
        format!(
            "job=$(sbatch --parsable --array=1-{} {})",
            array.tasks,
            quoted(&array_path)?
        ),
        format!(
            "sbatch --parsable --dependency=afterany:${{job%%;*}} {}",
            quoted(&merge_path)?
        ),
    ];
    Ok(Scripts {
        array: array_path,
        merge: merge_path,
        submit,
    })
}

/// What both scripts are made of, quoted.
struct Texts {
    folder: String,
    program: String,
    /// A line that names the partition, or nothing.
    partition: String,
}

impl Texts {
    fn array(&self, array: &Array<'_>) -> String {
        let Array { tasks, threads, .. } = array;
        self.script(&Script {
            name: "crossgrain",
            processors: *threads,
            first: format!(
                "# A task of the array 1-{tasks} is a shard of the study. A task that was ended is submitted again alone,\n\
                 # as with --array=3, and goes on with the rows that it had not finished.\n\
                 export {TASKS_VARIABLE}={tasks}\n"
            ),
            log: "task-${SLURM_ARRAY_TASK_ID:?is for a task of a job array}.log",
            verb: "run",
            options: format!(" --shard auto --threads {threads}"),
        })
    }

    fn merge(&self) -> String {
        self.script(&Script {
            name: "crossgrain-merge",
            processors: 1,
            first: "# Exit code 3: rows are missing; the log says which.\n".to_owned(),
            log: "merge.log",
            verb: "merge",
            options: String::new(),
        })
    }

    /// The program replaces the shell, so that signals reach it. What is said goes into a file that the script itself
    /// opens: Slurm gives `%` and `\` in the names of its own files a meaning.
    fn script(&self, script: &Script) -> String {
        let Texts {
            folder,
            program,
            partition,
        } = self;
        let Script {
            name,
            processors,
            first,
            log,
            verb,
            options,
        } = script;
        format!(
            "#!/bin/bash\n\
             #SBATCH --job-name={name}\n\
             #SBATCH --ntasks=1\n\
             #SBATCH --cpus-per-task={processors}\n\
             #SBATCH --requeue\n\
             #SBATCH --output=/dev/null\n\
             {partition}\
             {first}\
             folder={folder}\n\
             exec >>\"$folder/slurm/{log}\" 2>&1\n\
             echo \"job ${{SLURM_JOB_ID:-}} on $(hostname), $(date -u +%FT%TZ)\"\n\
             exec {program} study {verb} \"$folder\"{options}\n"
        )
    }
}

/// How the scripts differ.
struct Script {
    name: &'static str,
    processors: u16,
    /// Lines before all others.
    first: String,
    log: &'static str,
    /// Of `crossgrain study`, with its options.
    verb: &'static str,
    options: String,
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
