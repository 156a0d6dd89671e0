//! Where YADE is: the program on the path and the interpreter that its first line names.

use std::env;
use std::fs;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};

use super::YadeError;

/// A YADE that can be started.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Installation {
    /// The `yade` program, itself a Python file that can be imported.
    pub program: PathBuf,
    /// The Python that it was built for.
    pub interpreter: PathBuf,
}

/// The first line of a program is no longer, bytes.
const LONGEST_LINE: u64 = 4096;

/// Finds YADE: `program` if given, else the variable `CROSSGRAIN_YADE`, else `yade` on the path.
pub fn find(program: Option<&Path>) -> Result<Installation, YadeError> {
    let program = match (program, env::var_os("CROSSGRAIN_YADE")) {
        (Some(program), _) => program.to_owned(),
        (None, Some(named)) if !named.is_empty() => PathBuf::from(named),
        _ => on_path("yade").ok_or_else(|| {
            YadeError::Missing("there is no program `yade` on the path".to_owned())
        })?,
    };
    let missing = |why: &str| YadeError::Missing(format!("{} {why}", program.display()));
    let program = fs::canonicalize(&program).map_err(|_| missing("does not exist"))?;
    // Asked before opening: opening a pipe would wait for a writer.
    if !program.is_file() {
        return Err(missing("is not a file"));
    }
    let file = fs::File::open(&program).map_err(|_| missing("cannot be opened"))?;
    let mut first = String::new();
    BufReader::new(file.take(LONGEST_LINE))
        .read_line(&mut first)
        .map_err(|_| missing("is not the Python file that Debian's yade is"))?;
    let interpreter = first
        .strip_prefix("#!")
        .and_then(interpreter)
        .filter(|interpreter| interpreter.is_file())
        .ok_or_else(|| missing("does not name a Python interpreter in its first line"))?;
    Ok(Installation {
        program,
        interpreter,
    })
}

/// The build of the same YADE that has this name (`yade-float128`), which stands beside it.
pub fn sibling(program: Option<&Path>, name: &str) -> Result<PathBuf, YadeError> {
    let of = find(program)?.program.with_file_name(name);
    if of.is_file() {
        Ok(of)
    } else {
        Err(YadeError::Missing(format!(
            "{} does not exist",
            of.display()
        )))
    }
}

/// The program of a first line, looked up if it is left to `env`.
fn interpreter(command: &str) -> Option<PathBuf> {
    let mut words = command.split_whitespace();
    let program = PathBuf::from(words.next()?);
    if program.file_name().is_some_and(|name| name == "env") {
        return on_path(words.next()?);
    }
    Some(program)
}

fn on_path(name: &str) -> Option<PathBuf> {
    env::split_paths(&env::var_os("PATH")?)
        .map(|folder| folder.join(name))
        .find(|program| program.is_file())
}
