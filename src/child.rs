//! Programs that are started: each is ended with whatever it has started, at any depth and in sessions of their own, when it ends
//! or nobody waits for it any more, however that came about.

use std::collections::BTreeMap;
use std::os::unix::process::CommandExt;
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use std::{env, io, thread};

use rustix::param::{clock_ticks_per_second, page_size};
use rustix::process::{
    Pid, Signal, WaitId, WaitIdOptions, WaitOptions, getpid, kill_process, kill_process_group,
    set_child_subreaper, waitid, waitpid,
};

use crate::control_group::ControlGroup;
use crate::files::{Place, listed, of_system};
use crate::workers::lock;

/// How often a child is looked at.
pub const LOOK_EVERY: Duration = Duration::from_millis(50);

/// A child that does not outlive its watcher, nor does what it has started.
#[derive(Debug)]
pub struct Group {
    child: Child,
    /// A shell that ends all of it if this program has gone without a word. It leads the process group and was there
    /// first, so that its number stays the group's and an engine that ends its parent at once finds it at work.
    watcher: Child,
    /// In the surroundings of all that it starts, which tells those that left its group.
    mark: String,
    /// What holds all that it starts, where the system has such groups; the rest of what is known here is for where it has not, and
    /// for what was started before the child was put into it.
    control: Option<ControlGroup>,
    /// Its end was seen; its number may belong to another by now.
    seen: bool,
    /// What it took, once it has ended.
    processor_seconds: Option<f64>,
    /// Every process that was looked at, by its number: when it began, and whether it belongs here.
    known: BTreeMap<u32, (u64, bool)>,
}

/// The variable of the mark.
const MARK: &str = "CROSSGRAIN_STARTED";
static STARTED: AtomicU64 = AtomicU64::new(0);
/// Children and watchers of all groups: only their own group asks how they ended.
static CHILDREN: Mutex<Vec<u32>> = Mutex::new(Vec::new());

/// What the watcher does once its input has ended, which nothing can prevent. Its arguments are the mark and the control group.
const WATCH: &str = "trap '' HUP INT QUIT TERM; read -r done; [ -z \"$1\" ] || echo 1 >\"$1/cgroup.kill\"; cd /proc; \
     for round in 1 2 3; do for each in $(grep -lsxzF -e \"$0\" [0-9]*/environ); do kill -KILL ${each%/*}; done; done; \
     [ -z \"$1\" ] || rmdir \"$1\"; kill -KILL 0";

/// A process, as the system tells.
struct Process {
    number: u32,
    parent: u32,
    group: u32,
    session: u32,
    /// When it began, in the system's ticks; with its number it is one of a kind.
    began: u64,
    /// Its end was not asked for yet.
    is_dead: bool,
    /// Resident memory, bytes.
    memory: u64,
}

impl Process {
    fn of(number: u32) -> Option<Self> {
        let stat = stat_of(number)?;
        // After the name in brackets, which may hold anything.
        let words: Vec<&str> = stat.rsplit_once(')')?.1.split_whitespace().collect();
        let number_at = |index: usize| words.get(index)?.parse::<u64>().ok();
        let short_at = |index: usize| u32::try_from(number_at(index)?).ok();
        Some(Process {
            number,
            parent: short_at(1)?,
            group: short_at(2)?,
            session: short_at(3)?,
            began: number_at(19)?,
            is_dead: matches!(*words.first()?, "Z" | "X"),
            memory: number_at(21)? * page_size() as u64,
        })
    }

    /// Of a system that does not tell, none.
    fn all() -> Vec<Self> {
        let entries = listed("/proc", usize::MAX).unwrap_or_default();
        let numbers = entries
            .iter()
            .filter_map(|entry| entry.name.to_str()?.parse().ok());
        numbers.filter_map(Process::of).collect()
    }

    /// None where there are no surroundings, as while another program is put in its place.
    fn has_mark(&self, mark: &str) -> Option<bool> {
        let entry = format!("{MARK}={mark}");
        match of_system(format!("/proc/{}/environ", self.number)) {
            Some(environment) if environment.is_empty() => None,
            Some(environment) => Some(
                environment
                    .split(|byte| *byte == 0)
                    .any(|variable| variable == entry.as_bytes()),
            ),
            None => Some(false),
        }
    }
}

/// What the system tells of a process, in one line.
fn stat_of(process: u32) -> Option<String> {
    String::from_utf8(of_system(format!("/proc/{process}/stat"))?).ok()
}

const MOST_ROUNDS: usize = 500;

/// The program of this name on the path.
pub fn on_path(name: &str) -> Option<PathBuf> {
    env::split_paths(&env::var_os("PATH")?)
        .map(|folder| folder.join(name))
        .find(|program| Place::from(program).is_file())
}

fn started(command: &mut Command) -> io::Result<Child> {
    let child = command.spawn()?;
    lock(&CHILDREN).push(child.id());
    Ok(child)
}

impl Group {
    /// Starts the command in a group of its own, with nothing on its standard input.
    pub fn spawn(command: &mut Command) -> io::Result<Self> {
        // Those whose parents end are then children of this program. Where that cannot be, the mark still tells them.
        let _ = set_child_subreaper(Some(getpid()));
        let number = STARTED.fetch_add(1, Ordering::Relaxed);
        let mark = format!("{}-{number}", std::process::id());
        let control = ControlGroup::new(&mark);
        let mut watcher = Command::new("/bin/sh");
        watcher
            .args(["-c", WATCH, &format!("{MARK}={mark}")])
            .args(control.as_ref().map(ControlGroup::folder))
            .process_group(0)
            .stdin(Stdio::piped())
            .stdout(Stdio::null())
            .stderr(Stdio::null());
        let mut watcher = started(&mut watcher)?;
        command.env(MARK, &mark).stdin(Stdio::null());
        command.process_group(watcher.id().cast_signed());
        match started(command) {
            Ok(child) => Ok(Group {
                control: control.filter(|group| group.hold(child.id())),
                child,
                watcher,
                mark,
                seen: false,
                processor_seconds: None,
                known: BTreeMap::new(),
            }),
            Err(error) => {
                let _ = watcher.kill();
                reap(&mut watcher);
                Err(error)
            }
        }
    }

    /// How it ended, once it has.
    pub fn status(&mut self) -> io::Result<Option<ExitStatus>> {
        let has_ended = WaitIdOptions::EXITED | WaitIdOptions::NOHANG | WaitIdOptions::NOWAIT;
        // The system forgets what it took as soon as anybody asks how it ended.
        if !self.seen
            && let Some(pid) = Pid::from_raw(self.child.id().cast_signed())
            && let Ok(Some(_)) = waitid(WaitId::Pid(pid), has_ended)
        {
            self.processor_seconds = processor_seconds(self.child.id());
            self.end();
        }
        self.child.try_wait()
    }

    /// Processor time of it and of all that it has started and waited for, s, to a hundredth of a second; known when
    /// its end was seen, where the system tells.
    pub fn processor_seconds(&self) -> Option<f64> {
        self.processor_seconds
    }

    /// Resident memory of it and of all that it has started, bytes, where the system tells.
    pub fn memory(&mut self) -> u64 {
        let processes = self.processes();
        processes.iter().map(|process| process.memory).sum()
    }

    /// It and all that it has started: what its control group holds, what is in its process group, has its mark, is a child of such a one, or was one when it was
    /// last looked at. A process that left its group and its parents and took the mark off between two looks is one of
    /// them as long as no other group is at work.
    fn processes(&mut self) -> Vec<Process> {
        let (own, group) = (std::process::id(), self.watcher.id());
        let held = self.control.as_ref().map(ControlGroup::processes);
        let held = held.unwrap_or_default();
        let mut rest = Process::all();
        rest.retain(|process| ![own, group].contains(&process.number));
        let children = lock(&CHILDREN).clone();
        let is_alone = children.len() == 2;
        let session = Process::of(own).map(|process| process.session);
        let since = Process::of(group).map_or(0, |process| process.began);
        let mut known = BTreeMap::new();
        let mut found: Vec<Process> = Vec::new();
        let mut is_of = |process: &Process| {
            let before = self.known.get(&process.number);
            let before = before.filter(|(began, _)| *began == process.began);
            let is_lost = || {
                is_alone
                    && process.parent == own
                    && process.began >= since
                    && Some(process.session) != session
                    && !children.contains(&process.number)
            };
            let is = process.group == group
                || held.contains(&process.number)
                || process.number == self.child.id() && !self.seen
                || is_lost();
            let before = before.map(|(_, is)| *is);
            let is = is.then_some(true).or(before);
            let is = is.or_else(|| process.has_mark(&self.mark));
            known.extend(is.map(|is| (process.number, (process.began, is))));
            is == Some(true)
        };
        let mut newest: Vec<Process> = rest.extract_if(.., |process| is_of(process)).collect();
        while !newest.is_empty() {
            let mut parents: Vec<u32> = newest.iter().map(|process| process.number).collect();
            found.append(&mut newest);
            parents.sort_unstable();
            let is_child = |process: &mut Process| parents.binary_search(&process.parent).is_ok();
            newest = rest.extract_if(.., is_child).collect();
            known.extend(
                newest
                    .iter()
                    .map(|process| (process.number, (process.began, true))),
            );
        }
        self.known = known;
        found
    }

    /// Ends all that it has started, and itself.
    fn end(&mut self) {
        if let Some(control) = &self.control {
            control.end();
        }
        // One that starts others is gone when none is found.
        for round in 0..MOST_ROUNDS {
            let mut left = self.processes();
            let children = lock(&CHILDREN).clone();
            let is_adopted = |process: &Process| {
                process.parent == std::process::id() && !children.contains(&process.number)
            };
            for process in left.extract_if(.., |process| process.is_dead) {
                if is_adopted(&process) {
                    let _ = waitpid(
                        Pid::from_raw(process.number.cast_signed()),
                        WaitOptions::NOHANG,
                    );
                }
            }
            if left.is_empty() {
                break;
            }
            left.iter().for_each(|process| kill(process.number));
            thread::sleep(Duration::from_micros(if round == 0 { 100 } else { 2_000 }));
        }
        // The watcher too: its number, which is the group's, is its own until its end is asked for.
        if let Some(group) = Pid::from_raw(self.watcher.id().cast_signed()) {
            let _ = kill_process_group(group, Signal::KILL);
        }
        reap(&mut self.watcher);
        reap(&mut self.child);
        self.seen = true;
    }
}

/// Waits for one that was ended.
fn reap(child: &mut Child) {
    let _ = child.wait();
    lock(&CHILDREN).retain(|number| *number != child.id());
}

fn kill(number: u32) {
    if let Some(pid) = Pid::from_raw(number.cast_signed()) {
        // It fails only for what has ended already.
        let _ = kill_process(pid, Signal::KILL);
    }
}

fn processor_seconds(child: u32) -> Option<f64> {
    let stat = stat_of(child)?;
    // After the name in brackets, which may hold anything; its own times and those of its children.
    let times = stat.rsplit_once(')')?.1.split_whitespace();
    let ticks = times.skip(11).take(4).map(str::parse::<u64>);
    let ticks: u64 = ticks.sum::<Result<u64, _>>().ok()?;
    Some(ticks as f64 / clock_ticks_per_second() as f64)
}

impl Drop for Group {
    fn drop(&mut self) {
        if !self.seen {
            self.end();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whoever_leaves_group_parents_and_surroundings_ends_too_beside_another_engine() {
        let start = |text: &str| {
            let group = Group::spawn(Command::new("/bin/sh").args(["-c", text]));
            group.expect("there is a shell")
        };
        let seconds = format!("1000.{}", std::process::id());
        // Arguments end with a zero, so the shell that has all this in one is not meant.
        let arguments = format!("sleep\0{seconds}\0");
        let away = || {
            let mut all = Process::all().into_iter();
            all.any(|process| {
                let told = of_system(format!("/proc/{}/cmdline", process.number));
                told.is_some_and(|told| told.starts_with(arguments.as_bytes()))
            })
        };
        let within_seconds = |is: bool| {
            (0..200).any(|_| {
                thread::sleep(LOOK_EVERY);
                away() == is
            })
        };
        // Without control groups it is told by being the only one at work.
        let groups = ControlGroup::new(&format!("{}-test", std::process::id()));
        let _beside = groups.as_ref().map(|_| start("sleep 1000"));
        // The pause is for being put into the control group.
        let text = format!("sleep 0.3; setsid --fork env -i sleep {seconds}; sleep 1000");
        let group = start(&text);
        assert_eq!(group.control.is_some(), groups.is_some());
        assert!(within_seconds(true), "it is started");
        drop(group);
        assert!(within_seconds(false), "it has ended");
    }
}
