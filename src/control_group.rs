//! Control groups of the system (version 2): a group holds what was put into it and all that this starts, whatever that does to
//! get away. Where there are none, or none may be made, processes are told by other signs ([`crate::child`]).

use std::io::Write;
use std::path::{Path, PathBuf};

use crate::files::{created, listed, new_folder, of_system, remove_empty_folder};

/// Names of our groups begin with it; the number of the program that made the group and a count follow.
const NAME: &str = "crossgrain-";

/// A group of processes, gone with the value once it is empty.
#[derive(Debug)]
pub struct ControlGroup {
    folder: PathBuf,
}

impl ControlGroup {
    /// An empty group below that of this program; none where the system has none or does not allow one. Groups of programs that
    /// have ended are removed.
    pub fn new(name: &str) -> Option<Self> {
        let above = own_folder()?;
        for entry in listed(&above, usize::MAX).ok()? {
            let owner = entry.name.to_str().and_then(|name| name.strip_prefix(NAME));
            let owner = owner.and_then(|rest| rest.split('-').next());
            if owner.is_some_and(|number| of_system(format!("/proc/{number}/stat")).is_none()) {
                // One that still holds a process stays.
                let _ = remove_empty_folder(&above.join(&entry.name));
            }
        }
        let folder = above.join(format!("{NAME}{name}"));
        new_folder(&folder).ok()?;
        Some(ControlGroup { folder })
    }

    /// Where it is among the system's files.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Puts a process into it, and with it all that it starts from now on; whether that could be done.
    pub fn hold(&self, process: u32) -> bool {
        self.tell("cgroup.procs", &process.to_string())
    }

    /// The numbers of the processes that it holds.
    pub fn processes(&self) -> Vec<u32> {
        let told = of_system(self.folder.join("cgroup.procs")).unwrap_or_default();
        let text = String::from_utf8_lossy(&told);
        text.lines().flat_map(str::parse).collect()
    }

    /// Ends all of them at once; what starts meanwhile ends too. Systems before 2021 cannot.
    pub fn end(&self) {
        self.tell("cgroup.kill", "1");
    }

    fn tell(&self, name: &str, text: &str) -> bool {
        let file = created(&self.folder.join(name));
        file.is_ok_and(|mut file| file.write_all(text.as_bytes()).is_ok())
    }
}

impl Drop for ControlGroup {
    fn drop(&mut self) {
        // A process that ends takes a moment to leave it; the next program removes what stays.
        let _ = remove_empty_folder(&self.folder);
    }
}

/// The folder of the group that this program is in.
fn own_folder() -> Option<PathBuf> {
    let read = |path: &str| String::from_utf8(of_system(path)?).ok();
    let own = read("/proc/self/cgroup")?;
    let own = own.lines().find_map(|line| line.strip_prefix("0::/"))?;
    // Fields: number, parent, device, root, mount point, options …, a dash, kind of file system.
    let mounts = read("/proc/self/mountinfo")?;
    let mount = mounts.lines().find(|line| line.contains(" - cgroup2 "))?;
    Some(Path::new(mount.split(' ').nth(4)?).join(own))
}
