//! Other programs, run in a folder of their own under a time limit: what LAMMPS and LIGGGHTS share, and valgrind needs.

use std::env;
use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use super::BenchError;
use crate::child::{Group, Unfinished};
use crate::files::{failed, read_text, write_whole};
use grains::tables::Bodies;

/// The most of a log or table that is read, bytes.
const LARGEST: u64 = 1 << 28;

/// The program of this name on the path.
pub fn on_path(name: &str) -> Option<PathBuf> {
    env::split_paths(&env::var_os("PATH")?)
        .map(|folder| folder.join(name))
        .find(|program| program.is_file())
}

/// Runs a program in `work` and returns what it wrote on both outputs.
pub fn run(
    program: &Path,
    arguments: &[&str],
    work: &Path,
    limit: Duration,
) -> Result<String, BenchError> {
    let path = work.join("program.log");
    let output = File::create(&path).map_err(failed("create", &path))?;
    let errors = output.try_clone().map_err(failed("create", &path))?;
    let mut command = Command::new(program);
    command
        .args(arguments)
        .current_dir(work)
        // One thread, and no message passing over any network.
        .env("OMP_NUM_THREADS", "1")
        .env("OMPI_MCA_btl", "self")
        .env("OMPI_MCA_ess_singleton_isolated", "1")
        .env_remove("DISPLAY")
        .stdout(output)
        .stderr(errors);
    let name = program.file_name().unwrap_or_default().to_string_lossy();
    let group = Group::spawn(&mut command)
        .map_err(|error| BenchError::Failed(format!("{name} cannot be started: {error}")))?;
    let status = group.wait(limit).map_err(|error| match error {
        Unfinished::Interrupted => BenchError::Interrupted,
        other => BenchError::Failed(format!("{name}: {other}")),
    })?;
    let log = read_text(&path, LARGEST)?;
    if status.success() {
        return Ok(log);
    }
    let lines: Vec<&str> = log.lines().collect();
    let end = lines[lines.len().saturating_sub(8)..].join("\n");
    Err(BenchError::Failed(format!("{name}: {status}; {end}")))
}

/// A data file for LAMMPS and LIGGGHTS: x across, y up; ids from 1; diameters, and densities that give
/// the grains' masses.
pub fn write_data(
    path: &Path,
    bodies: &Bodies,
    width: f64,
    density: impl Fn(f64, f64) -> f64,
) -> Result<(), BenchError> {
    use std::fmt::Write;
    let top = bodies.z.iter().copied().fold(0.0, f64::max);
    let thick = bodies.radius.iter().copied().fold(0.0, f64::max);
    let mut text = format!(
        "a bed of crossgrain\n\n{} atoms\n1 atom types\n\n0 {width} xlo xhi\n{} {} ylo yhi\n{} {} zlo zhi\n\nAtoms\n\n",
        bodies.len(),
        -thick,
        top + 10.0 * thick,
        -1.2 * thick,
        1.2 * thick
    );
    for id in 0..bodies.len() {
        let (radius, mass) = (bodies.radius[id], bodies.mass[id]);
        let (x, z) = (bodies.x[id], bodies.z[id]);
        // Writing to a string cannot fail.
        let _ = writeln!(
            text,
            "{} 1 {} {} {x} {z} 0",
            id + 1,
            2.0 * radius,
            density(radius, mass)
        );
    }
    text += "\nVelocities\n\n";
    for id in 0..bodies.len() {
        let _ = writeln!(
            text,
            "{} {} {} 0 0 0 0",
            id + 1,
            bodies.vx[id],
            bodies.vz[id]
        );
    }
    Ok(write_whole(path, text.as_bytes())?)
}

/// A dump with the columns `id x y vx vy` in any order of rows; sizes and masses are those of `of`.
pub fn read_dump(path: &Path, of: &Bodies) -> Result<Bodies, BenchError> {
    let bad = |what: &str| BenchError::Nonsense(format!("{}: {what}", path.display()));
    let text = read_text(path, LARGEST)?;
    let rows = text
        .lines()
        .skip_while(|line| !line.starts_with("ITEM: ATOMS"));
    let mut bodies = of.clone();
    let mut seen = vec![false; of.len()];
    for row in rows.skip(1) {
        let mut words = row.split_whitespace();
        let id: usize = words
            .next()
            .and_then(|word| word.parse().ok())
            .filter(|id| (1..=of.len()).contains(id))
            .ok_or_else(|| bad("a grain that was not given"))?;
        for column in [&mut bodies.x, &mut bodies.z, &mut bodies.vx, &mut bodies.vz] {
            column[id - 1] = words
                .next()
                .and_then(|word| word.parse().ok())
                .filter(|value: &f64| value.is_finite())
                .ok_or_else(|| bad("a number that is none"))?;
        }
        seen[id - 1] = true;
    }
    match seen.iter().position(|seen| !seen) {
        None => Ok(bodies),
        Some(lost) => Err(bad(&format!("grain {lost} is lost"))),
    }
}

/// Seconds and steps of the last "Loop time of T on 1 procs for N steps" in a log.
pub fn loop_time(log: &str) -> Option<(f64, u64)> {
    let line = log.lines().rfind(|line| line.starts_with("Loop time of"))?;
    let words: Vec<&str> = line.split_whitespace().collect();
    let steps = words.iter().position(|word| *word == "steps")?;
    Some((
        words.get(3)?.parse().ok()?,
        words.get(steps - 1)?.parse().ok()?,
    ))
}

/// The value in the last row of the thermodynamic table with this many columns that stands before the last loop time.
pub fn last_row(log: &str, columns: usize) -> Option<Vec<f64>> {
    let end = log.rfind("Loop time of")?;
    let numbers = |line: &str| -> Option<Vec<f64>> {
        line.split_whitespace()
            .map(|word| word.parse().ok())
            .collect()
    };
    let mut rows = log[..end].lines().rev().filter_map(numbers);
    rows.find(|row| row.len() == columns)
}

/// Where a program of this name may have failed to be found.
pub fn missing(name: &str, package: &str) -> BenchError {
    BenchError::Missing(format!(
        "there is no program `{name}` on the path; on Debian install it with \
         `apt-get install --no-install-recommends {package}`"
    ))
}

/// A folder inside `work` for one run.
pub fn folder(work: &Path, name: &str) -> Result<PathBuf, BenchError> {
    let folder = work.join(name);
    if folder.exists() {
        fs::remove_dir_all(&folder).map_err(failed("remove", &folder))?;
    }
    fs::create_dir(&folder).map_err(failed("create", &folder))?;
    Ok(folder)
}
