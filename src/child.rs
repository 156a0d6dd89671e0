//! Programs that are started: each in a process group of its own, ended with whatever it has started
//! when it ends or nobody waits for it any more, however that came about.

use std::io::Write;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use std::{env, io};

use rustix::param::clock_ticks_per_second;
use rustix::process::{
    Pid, Signal, WaitId, WaitIdOptions, kill_process, kill_process_group, waitid,
};

/// How often a child is looked at.
pub const LOOK_EVERY: Duration = Duration::from_millis(50);

/// A child that does not outlive its watcher, nor does what it has started.
#[derive(Debug)]
pub struct Group {
    child: Child,
    /// In the surroundings of all that it starts, which tells those that left its group.
    mark: String,
    /// A shell that ends the group if this program has gone without a word.
    watcher: Option<Child>,
    /// Its end was seen; its number may belong to another by now.
    seen: bool,
    /// What it took, once it has ended.
    processor_seconds: Option<f64>,
}

/// The variable of the mark.
const MARK: &str = "CROSSGRAIN_STARTED";
static STARTED: AtomicU64 = AtomicU64::new(0);

/// Ends every process with this mark in its surroundings, also one with a session of its own; what takes the mark off is lost.
fn end_all_with(mark: &str) {
    let entry = format!("{MARK}={mark}");
    let has_mark = |process: &PathBuf| {
        let of = std::fs::read(process.join("environ")).unwrap_or_default();
        of.split(|byte| *byte == 0).any(|of| of == entry.as_bytes())
    };
    // One that starts others is gone when none is found.
    for _ in 0..MOST_ROUNDS {
        let Ok(processes) = std::fs::read_dir("/proc") else {
            return;
        };
        let paths = processes.flatten().map(|of| of.path());
        let left = paths.filter(has_mark).filter_map(|of| {
            let number = of.file_name()?.to_str()?.parse().ok()?;
            Pid::from_raw(number)
        });
        let left: Vec<Pid> = left.collect();
        if left.is_empty() {
            return;
        }
        for pid in left {
            let _ = kill_process(pid, Signal::KILL);
        }
    }
}

const MOST_ROUNDS: usize = 100;

/// The program of this name on the path.
pub fn on_path(name: &str) -> Option<PathBuf> {
    env::split_paths(&env::var_os("PATH")?)
        .map(|folder| folder.join(name))
        .find(|program| program.is_file())
}

impl Group {
    /// Starts the command in a group of its own, with nothing on its standard input.
    pub fn spawn(command: &mut Command) -> io::Result<Self> {
        let number = STARTED.fetch_add(1, Ordering::Relaxed);
        let mark = format!("{}-{number}", std::process::id());
        command.env(MARK, &mark);
        let child = command.process_group(0).stdin(Stdio::null()).spawn()?;
        let mut group = Group {
            child,
            mark,
            watcher: None,
            seen: false,
            processor_seconds: None,
        };
        // Its input ends with this program, which nothing can prevent.
        let watcher = Command::new("/bin/sh")
            .args([
                "-c",
                "trap '' HUP INT QUIT TERM; read -r done && exit; kill -KILL \"-$0\"; cd /proc; for each in [0-9]*; do \
                 if tr '\\0' '\\n' <$each/environ | grep -qxF \"$1\"; then kill -KILL $each; fi; done",
            ])
            .arg(group.child.id().to_string())
            .arg(format!("{MARK}={}", group.mark))
            .process_group(0)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()?;
        group.watcher = Some(watcher);
        Ok(group)
    }

    /// How it ended, once it has.
    pub fn status(&mut self) -> io::Result<Option<ExitStatus>> {
        let has_ended = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        // The system forgets what it took as soon as anybody asks how it ended.
        if let Some(pid) = Pid::from_raw(self.child.id().cast_signed())
            && !self.seen
            && let Ok(Some(_)) = waitid(WaitId::Pid(pid), has_ended)
        {
            self.processor_seconds = processor_seconds(pid);
            // Its number is its own until its end is asked for; what it left behind ends with it.
            let _ = kill_process_group(pid, Signal::KILL);
        }
        let status = self.child.try_wait()?;
        if status.is_some() && !self.seen {
            self.seen = true;
            end_all_with(&self.mark);
            self.dismiss_watcher();
        }
        Ok(status)
    }

    /// Nothing is left to be ended; the group's number may belong to others from now on.
    fn dismiss_watcher(&mut self) {
        let Some(mut watcher) = self.watcher.take() else {
            return;
        };
        if let Some(mut input) = watcher.stdin.take() {
            let _ = input.write_all(b"done\n");
        }
        let _ = watcher.wait();
    }

    /// Processor time of it and of all that it has started and waited for, s, to a hundredth of a second; known when
    /// its end was seen, where the system tells.
    pub fn processor_seconds(&self) -> Option<f64> {
        self.processor_seconds
    }

    /// Resident memory of every process of the group, bytes, where the system tells.
    pub fn memory(&self) -> u64 {
        let group = self.child.id().to_string();
        let Ok(processes) = std::fs::read_dir("/proc") else {
            return 0;
        };
        let pages = processes.flatten().filter_map(|process| {
            let path = process.path();
            // After the name in brackets, which may hold anything: state, parent, group.
            let stat = std::fs::read_to_string(path.join("stat")).ok()?;
            let of = stat.rsplit_once(')')?.1.split_whitespace().nth(2)?;
            if of != group {
                return None;
            }
            let size = std::fs::read_to_string(path.join("statm")).ok()?;
            size.split_whitespace().nth(1)?.parse::<u64>().ok()
        });
        pages.sum::<u64>() * rustix::param::page_size() as u64
    }
}

fn processor_seconds(pid: Pid) -> Option<f64> {
    let stat = std::fs::read_to_string(format!("/proc/{}/stat", pid.as_raw_nonzero())).ok()?;
    // After the name in brackets, which may hold anything; its own times and those of its children.
    let times = stat.rsplit_once(')')?.1.split_whitespace();
    let ticks = times.skip(11).take(4).map(str::parse::<u64>);
    let ticks: u64 = ticks.sum::<Result<u64, _>>().ok()?;
    Some(ticks as f64 / clock_ticks_per_second() as f64)
}

impl Drop for Group {
    fn drop(&mut self) {
        // Each fails only for what has ended already.
        if !self.seen {
            if let Some(group) = Pid::from_raw(self.child.id().cast_signed()) {
                let _ = kill_process_group(group, Signal::KILL);
            }
            let _ = self.child.kill();
            let _ = self.child.wait();
            end_all_with(&self.mark);
        }
        self.dismiss_watcher();
    }
}
