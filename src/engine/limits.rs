//! Watching a program that works in a folder: how long it takes, whether it still moves, how much memory and room
//! it takes. Whoever goes beyond a limit is ended with all that it has started.

use std::io::{Read, Seek, SeekFrom};
use std::path::Path;
use std::process::ExitStatus;
use std::thread;
use std::time::{Duration, Instant};

use super::{ProgramError, Result, nonsense};
use crate::child::{Group, LOOK_EVERY};
use crate::files::{Place, failed, regular};
use crate::workers::asked_to_end;
use grains::tables::Stage;

/// The most of a log that is kept, bytes.
const LONGEST_LOG: u64 = 1 << 20;
/// Lines of a log that a message shows.
const LINES_SHOWN: usize = 12;
/// The most of a line that a message shows, characters.
const LONGEST_SHOWN: usize = 400;

/// How far a program may go.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// The whole run may take so long.
    pub time: Duration,
    /// It counts as hung when it has not moved on for so long.
    pub stall: Duration,
    /// Resident memory of the program and all that it has started, bytes.
    pub memory: u64,
    /// All that it may write, its log included, bytes.
    pub output: u64,
}

/// How a program ended, and what it took.
#[derive(Debug, Clone, Copy)]
pub struct Done {
    pub status: ExitStatus,
    /// Time on the clock, s.
    pub wall_seconds: f64,
    /// Processor time of it and of all that it has started and waited for, s, where the system tells.
    pub processor_seconds: Option<f64>,
}

/// Memory and output are looked at every so many looks.
const WEIGH_EVERY: u32 = 4;

/// The shortest time between two looks at a program.
const SOON: Duration = Duration::from_millis(1);

/// Waits for its end. `look` is called now and then and says how much it has done by some count that grows, or nothing
/// if there is no use in going on; what it has written in `work` is counted by `written`. Errors are without the log.
pub fn watch(
    mut child: Group,
    limits: &Limits,
    look: &mut dyn FnMut() -> Option<u64>,
    written: &dyn Fn() -> u64,
    work: &Path,
) -> Result<Done> {
    let hung = |reason: String| ProgramError::Hung {
        reason,
        log: String::new(),
    };
    let began = Instant::now();
    let mut done = 0;
    let mut moved = Instant::now();
    for looks in 0u32.. {
        let ended = child.status().map_err(failed("wait for", work))?;
        let now = look().ok_or_else(|| nonsense("what it says of itself rules it out"))?;
        if looks.is_multiple_of(WEIGH_EVERY) || ended.is_some() {
            weigh(&mut child, limits, written)?;
        }
        if let Some(status) = ended {
            return Ok(Done {
                status,
                wall_seconds: began.elapsed().as_secs_f64(),
                processor_seconds: child.processor_seconds(),
            });
        }
        if now != done {
            done = now;
            moved = Instant::now();
        }
        if asked_to_end() {
            return Err(ProgramError::Interrupted);
        }
        if began.elapsed() > limits.time {
            return Err(hung(format!("not done within {:?}", limits.time)));
        }
        if moved.elapsed() > limits.stall {
            return Err(hung(format!("no sign of life for {:?}", limits.stall)));
        }
        // Most programs are done soon, and waiting longer than a share of their time would cost more than they do.
        thread::sleep((began.elapsed() / 16).clamp(SOON, LOOK_EVERY));
    }
    Err(hung("it never ended".to_owned()))
}

fn weigh(child: &mut Group, limits: &Limits, written: &dyn Fn() -> u64) -> Result<()> {
    is_within("memory", &mut || child.memory(), limits.memory)?;
    is_within("output", &mut &*written, limits.output)
}

/// An error where this is more bytes than the limit, if there is one.
pub fn is_within(what: &str, is: &mut dyn FnMut() -> u64, limit: u64) -> Result<()> {
    let is = if limit < u64::MAX { is() } else { 0 };
    if is <= limit {
        return Ok(());
    }
    let (is, limit) = (is >> 20, limit >> 20);
    let reason = format!("{is} MB of {what}, and {limit} MB is its limit");
    Err(ProgramError::TooMuch { reason })
}

/// What a program wrote on its standard output and error; of a very long log the end.
pub fn log<'a>(place: impl Into<Place<'a>>) -> String {
    let mut bytes = Vec::new();
    // A pipe in its place would never end.
    if let Ok(mut file) = regular(place) {
        let length = file.metadata().map_or(0, |data| data.len());
        // What could be read of it is better than nothing.
        let _ = file.seek(SeekFrom::Start(length.saturating_sub(LONGEST_LOG)));
        let _ = file.take(LONGEST_LOG).read_to_end(&mut bytes);
    }
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The last lines of a log; of a very long line the beginning.
pub fn end_of(log: &str) -> String {
    let lines: Vec<&str> = log.lines().collect();
    let last = &lines[lines.len().saturating_sub(LINES_SHOWN)..];
    let cut = |line: &&str| match line.char_indices().nth(LONGEST_SHOWN) {
        Some((end, _)) => format!("{} …", &line[..end]),
        None => (*line).to_owned(),
    };
    last.iter().map(cut).collect::<Vec<String>>().join("\n")
}

/// Lines `STAGE STEP SHARE` in a file that grows.
#[derive(Debug, Default)]
pub struct Beats {
    read: u64,
}

impl Beats {
    /// The newest whole line since the last look. It is for display only, so what cannot be read is passed over.
    pub fn newest(&mut self, place: Place) -> Option<(Stage, u64, f64)> {
        let mut file = regular(place).ok()?;
        file.seek(SeekFrom::Start(self.read)).ok()?;
        let mut new = Vec::new();
        file.take(1 << 16).read_to_end(&mut new).ok()?;
        let Some(end) = new.iter().rposition(|byte| *byte == b'\n') else {
            // A line so long is none of these.
            self.read += if new.len() == 1 << 16 { 1 << 16 } else { 0 };
            return None;
        };
        self.read += end as u64 + 1;
        let new = String::from_utf8_lossy(&new[..end]);
        new.lines().rev().find_map(beat)
    }
}

fn beat(line: &str) -> Option<(Stage, u64, f64)> {
    let mut words = line.split(' ');
    let name = words.next()?;
    let mut stages = [Stage::Settle, Stage::Load].into_iter();
    let stage = stages.find(|stage| stage.name() == name)?;
    let step = words.next()?.parse().ok()?;
    let share: f64 = words.next()?.parse().ok()?;
    share.is_finite().then_some((stage, step, share))
}
