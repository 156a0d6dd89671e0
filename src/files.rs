//! Files: every file and folder that the program reads, writes or asks for is opened here and nowhere else. Bounded reading, writing
//! aside and renaming, digests. Nothing here knows what is in them.

use std::ffi::OsString;
use std::fs;
use std::io::{self, Read, Write};
use std::os::fd::{AsRawFd, OwnedFd};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, SystemTime};

use rustix::fs::{
    AtFlags, Mode, OFlags, RenameFlags, ResolveFlags, linkat, openat, openat2, renameat,
    renameat_with, unlinkat,
};
use rustix::io::Errno;

use crate::exit;
use grains::tables::hex;
pub use grains::tables::{sha256_hex, short_hex};
use grains::task::asked_to_end;
use sha2::{Digest, Sha256};
pub use tempfile::TempDir;

/// A file or folder could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum FileError {
    #[error("cannot {action} {path}: {source}{}", hint(source))]
    Io {
        action: &'static str,
        path: PathBuf,
        source: std::io::Error,
    },
    #[error("{path} is larger than {limit} bytes, the most that such a file may have")]
    TooLarge { path: PathBuf, limit: u64 },
    #[error("{path} {}", if path.is_dir() { "is a folder; name a file in it" } else { "is not a regular file" })]
    NotAFile { path: PathBuf },
    #[error("{path} is not UTF-8 text")]
    NotText { path: PathBuf },
    #[error("{path} is in use by another process; wait for it, or name another folder")]
    Busy { path: PathBuf },
    #[error(
        "{path} is a symbolic link, which is never written to or replaced; name the file itself"
    )]
    Link { path: PathBuf },
    #[error(
        "{path} is, or leads through, a symbolic link, and none is followed inside a folder; put what it leads to in its place"
    )]
    LinkInside { path: PathBuf },
    #[error("asked to end while {path} was read or written; start the command again")]
    Ended { path: PathBuf },
    #[error("nobody reads what is written to {path}")]
    NotRead { path: PathBuf },
    #[error("{path} exists already; give another name, nothing is overwritten")]
    Exists { path: PathBuf },
    /// What it holds cannot be used: why, and what to do.
    #[error("{0}")]
    Unfit(String),
}

impl FileError {
    /// What cannot be read was named wrongly; what cannot be written may work another time.
    pub fn exit_code(&self) -> u8 {
        use std::io::ErrorKind::{AlreadyExists, InvalidFilename, IsADirectory, NotADirectory};
        match self {
            FileError::Io { action, source, .. } => match (source.kind(), *action) {
                (AlreadyExists | InvalidFilename | IsADirectory | NotADirectory, _) => exit::USAGE,
                (_, "open" | "read" | "find") => exit::USAGE,
                _ => exit::TRY_AGAIN,
            },
            FileError::Busy { .. } | FileError::NotRead { .. } | FileError::Ended { .. } => {
                exit::TRY_AGAIN
            }
            _ => exit::USAGE,
        }
    }
}

/// What to do about an error of the surroundings; nothing where it says so itself.
fn hint(source: &std::io::Error) -> &'static str {
    use std::io::ErrorKind::{FileTooLarge, QuotaExceeded, ReadOnlyFilesystem, StorageFull};
    match source.kind() {
        StorageFull | QuotaExceeded | FileTooLarge => {
            "; make room, or raise the limit, and start the command again"
        }
        ReadOnlyFilesystem => "; name a folder that can be written",
        _ => "",
    }
}

/// Wraps an I/O error with what was being done to which path.
pub fn failed(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> FileError {
    let path = path.to_owned();
    // A stream has said already what is wrong.
    move |source| match source.downcast::<FileError>() {
        Ok(error) => error,
        Err(source) => FileError::Io {
            action,
            path,
            source,
        },
    }
}

/// Where a file or folder is: `&path` or `(&folder, "name")`.
#[derive(Debug, Clone, Copy)]
pub enum Place<'a> {
    /// As whoever uses the program has named it: links are followed.
    Named(&'a Path),
    /// Below a folder that was named. No link is followed from there on, and nothing outside is reached.
    Inside(&'a Path, &'a str),
}

impl<'a, P: AsRef<Path> + ?Sized> From<&'a P> for Place<'a> {
    fn from(path: &'a P) -> Self {
        Place::Named(path.as_ref())
    }
}

impl<'a, P: AsRef<Path> + ?Sized, N: AsRef<str> + ?Sized> From<(&'a P, &'a N)> for Place<'a> {
    fn from((folder, name): (&'a P, &'a N)) -> Self {
        Place::Inside(folder.as_ref(), name.as_ref())
    }
}

impl Place<'_> {
    pub fn path(self) -> PathBuf {
        match self {
            Place::Named(path) => path.to_owned(),
            Place::Inside(folder, name) => folder.join(name),
        }
    }

    /// Wraps an error with what was being done.
    fn failed(self, action: &'static str) -> impl FnOnce(io::Error) -> FileError {
        let path = self.path();
        move |error| match self.leads_out(&error) {
            true => FileError::LinkInside { path },
            false => failed(action, &path)(error),
        }
    }

    /// Whether a link is why something inside a folder was not opened.
    fn leads_out(self, error: &io::Error) -> bool {
        let is_link = |place: Place| place.about().is_ok_and(|metadata| metadata.is_symlink());
        matches!(self, Place::Inside(..))
            && (error.raw_os_error() == Some(Errno::LOOP.raw_os_error())
                || error.kind() == io::ErrorKind::NotADirectory && is_link(self))
    }

    fn open(self, flags: OFlags) -> io::Result<fs::File> {
        // The system takes neither a mode nor other flags where they mean nothing.
        let flags = flags | OFlags::CLOEXEC;
        let mode = match flags.contains(OFlags::CREATE) {
            true => Mode::from_raw_mode(0o666),
            false => Mode::empty(),
        };
        let file = match self {
            Place::Named(path) => rustix::fs::open(path, flags, mode)?,
            Place::Inside(folder, name) => open_below(folder, name, flags, mode)?,
        };
        Ok(file.into())
    }

    /// The folder that it is in, opened, and its name there.
    fn parent(self) -> Result<(OwnedFd, OsString), FileError> {
        let path = self.path();
        let invalid = || failed("write", &path)(io::ErrorKind::InvalidFilename.into());
        let name = path.file_name().ok_or_else(invalid)?.to_owned();
        let folder = OFlags::PATH | OFlags::DIRECTORY;
        let parent = parent_of(&path);
        let place = match self {
            Place::Named(_) => Place::Named(&parent),
            Place::Inside(root, inside) => {
                let above = inside.rsplit_once('/').map_or(".", |(above, _)| above);
                Place::Inside(root, above)
            }
        };
        let opened = place.open(folder).map_err(place.failed("write into"));
        Ok((opened?.into(), name))
    }

    /// What is there; of a link inside a folder itself.
    fn about(self) -> io::Result<fs::Metadata> {
        self.open(OFlags::PATH)?.metadata()
    }

    /// Whether something is there, a link included.
    pub fn is_taken(self) -> bool {
        use io::ErrorKind::{NotADirectory, NotFound};
        let found = match self {
            Place::Named(path) => path.symlink_metadata(),
            Place::Inside(..) => self.about(),
        };
        found.map_or_else(
            |error| ![NotADirectory, NotFound].contains(&error.kind()),
            |_| true,
        )
    }

    pub fn is_file(self) -> bool {
        self.about().is_ok_and(|metadata| metadata.is_file())
    }

    pub fn is_folder(self) -> bool {
        self.about().is_ok_and(|metadata| metadata.is_dir())
    }

    /// Bytes of a file; 0 if there is none.
    pub fn length(self) -> u64 {
        self.about().map_or(0, |metadata| metadata.len())
    }
}

fn open_below(folder: &Path, name: &str, flags: OFlags, mode: Mode) -> io::Result<OwnedFd> {
    let way = OFlags::PATH | OFlags::DIRECTORY | OFlags::CLOEXEC;
    let flags = flags | OFlags::NOFOLLOW;
    let folder = rustix::fs::open(folder, way, Mode::empty())?;
    let rules = ResolveFlags::NO_SYMLINKS | ResolveFlags::BENEATH;
    match openat2(&folder, name, flags, mode, rules) {
        // Older than Linux 5.6, or forbidden.
        Err(Errno::NOSYS | Errno::PERM) => step_by_step(folder, name, flags, mode),
        opened => Ok(opened?),
    }
}

/// The same by one name after the other.
fn step_by_step(root: OwnedFd, name: &str, flags: OFlags, mode: Mode) -> io::Result<OwnedFd> {
    if name.starts_with('/') || name.split('/').any(|part| part == "..") {
        return Err(Errno::XDEV.into());
    }
    let (way, last) = name.rsplit_once('/').unwrap_or((".", name));
    let mut folder = root;
    for part in way.split('/') {
        let there = OFlags::PATH | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        folder = openat(&folder, part, there, Mode::empty())?;
        if fs::File::from(folder.try_clone()?).metadata()?.is_symlink() {
            return Err(Errno::LOOP.into());
        }
    }
    Ok(openat(&folder, last, flags, mode)?)
}

/// A folder of one's own among the temporary files; gone with the value.
pub fn work_folder() -> Result<TempDir, FileError> {
    let place = std::env::temp_dir();
    remove_litter(&place);
    let folder = tempfile::Builder::new().prefix(&*ASIDE).tempdir();
    folder.map_err(failed("create a folder in", &place))
}

/// How the names of all that is written aside begin.
const ALL_ASIDE: &str = ".crossgrain.partial-";

/// How the names of what this process writes aside begin: with the machine and its processes' numbers, and with this one's.
static ASIDE: LazyLock<String> = LazyLock::new(|| {
    let own = format!("{}-{}", std::process::id(), began("self"));
    format!("{ALL_ASIDE}{}-{own}-", numbers_of())
});

/// What tells whose processes are counted: the start of the machine and the room of numbers in which this process is.
fn numbers_of() -> String {
    let boot = of_system("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let room = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    sha256_hex(&[&boot, room.as_os_str().as_encoded_bytes()].concat())[..12].to_owned()
}

/// When a process began, in the system's ticks; empty where there is none.
fn began(process: &str) -> String {
    let stat = of_system(format!("/proc/{process}/stat")).unwrap_or_default();
    let stat = String::from_utf8_lossy(&stat);
    let after_name = stat.rsplit_once(')').map_or("", |parts| parts.1);
    let began = after_name.split_whitespace().nth(19);
    began.unwrap_or_default().to_owned()
}

/// Removes what processes of this machine that are gone have left in a folder, aside and unfinished. What cannot be removed
/// stays.
pub fn remove_litter(folder: &Path) {
    let ours = format!("{ALL_ASIDE}{}-", numbers_of());
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let rest = name.to_str().and_then(|name| name.strip_prefix(&ours));
        let mut parts = rest.into_iter().flat_map(|text| text.splitn(3, '-'));
        let (Some(process), Some(start), Some(_)) = (parts.next(), parts.next(), parts.next())
        else {
            continue;
        };
        let is_number = |text: &str| text.parse::<u64>().is_ok();
        if is_number(process) && is_number(start) && began(process) != start {
            let path = entry.path();
            let _ = match entry.file_type().is_ok_and(|kind| kind.is_dir()) {
                true => fs::remove_dir_all(path),
                false => fs::remove_file(path),
            };
        }
    }
}

/// A file that is read from the front, never more than so many bytes of it, and not on when the process is asked to end.
pub struct Stream {
    path: PathBuf,
    from: Box<dyn Read>,
    limit: u64,
    left: u64,
    heeds: bool,
}

/// So much is read all the same: what a command says when it is asked to end is in small files.
const SMALL: u64 = 1 << 20;

impl Stream {
    /// A name that ends in `.gz` is unpacked, the limit then holding for what comes out.
    pub fn open<'a>(place: impl Into<Place<'a>>, limit: u64) -> Result<Self, FileError> {
        let place = place.into();
        let is_packed = place.path().extension().is_some_and(|end| end == "gz");
        Stream::of(place, limit, is_packed)
    }

    fn of(place: Place, limit: u64, is_packed: bool) -> Result<Self, FileError> {
        let (file, path) = (regular(place)?, place.path());
        if !is_packed && file.metadata().is_ok_and(|metadata| metadata.len() > limit) {
            return Err(FileError::TooLarge { path, limit });
        }
        let from: Box<dyn Read> = match is_packed {
            // Of all that was packed, one after the other; what follows and is not packed is an error.
            true => Box::new(flate2::read::MultiGzDecoder::new(file)),
            false => Box::new(file),
        };
        Ok(Stream {
            path,
            from,
            limit,
            left: limit,
            heeds: true,
        })
    }
}

impl Read for Stream {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        if self.heeds && self.limit - self.left > SMALL && asked_to_end() {
            let path = self.path.clone();
            return Err(io::Error::other(FileError::Ended { path }));
        }
        let count = self.from.read(into)?;
        match self.left.checked_sub(count as u64) {
            Some(left) => self.left = left,
            None => {
                let (path, limit) = (self.path.clone(), self.limit);
                return Err(io::Error::other(FileError::TooLarge { path, limit }));
            }
        }
        Ok(count)
    }
}

/// Reads at most `limit` bytes of text. A name that ends in `.gz` is unpacked, the limit then
/// holding for the unpacked text.
pub fn read_text<'a>(place: impl Into<Place<'a>>, limit: u64) -> Result<String, FileError> {
    let mut stream = Stream::open(place, limit)?;
    let mut bytes = Vec::new();
    let read = stream.read_to_end(&mut bytes);
    let path = stream.path;
    read.map_err(failed("read", &path))?;
    String::from_utf8(bytes).map_err(|_| FileError::NotText { path })
}

/// The most bytes of a file whose digest is taken.
const LARGEST_DIGESTED: u64 = 1 << 30;

/// Opens a regular file for reading. It is asked before it is opened, since opening a device may do something, and once more
/// afterwards, since another may stand in its place by then; opening a pipe does not wait for a writer.
pub fn regular<'a>(place: impl Into<Place<'a>>) -> Result<fs::File, FileError> {
    let place = place.into();
    of_kind(place, &place.about().map_err(place.failed("open"))?)?;
    let file = place.open(OFlags::RDONLY | OFlags::NONBLOCK);
    let file = file.map_err(place.failed("open"))?;
    of_kind(place, &file.metadata().map_err(place.failed("open"))?)?;
    Ok(file)
}

/// An error if it is no regular file.
fn of_kind(place: Place, about: &fs::Metadata) -> Result<(), FileError> {
    let path = || place.path();
    match about.file_type() {
        kind if kind.is_file() => Ok(()),
        kind if kind.is_symlink() => Err(FileError::LinkInside { path: path() }),
        _ => Err(FileError::NotAFile { path: path() }),
    }
}

/// What stands in a folder.
#[derive(Debug)]
pub struct Listed {
    pub name: OsString,
    pub path: PathBuf,
    /// A folder, and no link to one.
    pub is_folder: bool,
    pub is_file: bool,
}

/// What is in a folder, by name, of at most so many; none where there is no such folder.
pub fn listed<'a>(folder: impl Into<Place<'a>>, most: usize) -> Result<Vec<Listed>, FileError> {
    let place = folder.into();
    let opened = match place.open(OFlags::RDONLY | OFlags::DIRECTORY) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        opened => opened.map_err(place.failed("read"))?,
    };
    let entries = fs::read_dir(format!("/proc/self/fd/{}", opened.as_raw_fd()));
    let mut found = Vec::new();
    for entry in entries.map_err(place.failed("read"))?.take(most) {
        let entry = entry.map_err(place.failed("read"))?;
        let (name, kind) = (entry.file_name(), entry.file_type());
        found.push(Listed {
            path: place.path().join(&name),
            name,
            is_folder: kind.as_ref().is_ok_and(fs::FileType::is_dir),
            is_file: kind.is_ok_and(|kind| kind.is_file()),
        });
    }
    found.sort_by(|a, b| a.name.cmp(&b.name));
    Ok(found)
}

/// Bytes of all files in a folder and in those inside it. What comes or goes meanwhile counts or does not.
pub fn size_of_folder(folder: &Path) -> u64 {
    let Ok(entries) = fs::read_dir(folder) else {
        return 0;
    };
    let size = |entry: fs::DirEntry| match entry.metadata() {
        Ok(metadata) if metadata.is_dir() => size_of_folder(&entry.path()),
        Ok(metadata) => metadata.len(),
        Err(_) => 0,
    };
    entries.flatten().map(size).sum()
}

/// The most of a file of the system's, bytes.
const LARGEST_OF_SYSTEM: u64 = 1 << 23;

/// What the system tells in a file of `/proc` or `/sys`; nothing where it does not.
pub fn of_system(path: impl AsRef<Path>) -> Option<Vec<u8>> {
    let mut bytes = Vec::new();
    let file = fs::File::open(path).ok()?;
    let read = file.take(LARGEST_OF_SYSTEM).read_to_end(&mut bytes);
    read.is_ok().then_some(bytes)
}

/// What changes with a program of that name: its size and when it was written, where the system tells.
pub fn size_and_age(path: &Path) -> Option<(u64, SystemTime)> {
    let about = fs::metadata(path).ok()?;
    Some((about.len(), about.modified().ok()?))
}

/// The path from the root, without links.
pub fn whole_path(path: &Path) -> Result<PathBuf, FileError> {
    fs::canonicalize(path).map_err(failed("find", path))
}

/// The text that these packed bytes hold; `path` says where they come from.
pub fn unpacked(path: &Path, bytes: &[u8]) -> Result<String, FileError> {
    let read = std::io::read_to_string(flate2::read::GzDecoder::new(bytes));
    read.map_err(failed("read", path))
}

/// A file that is written beside its place, on the same file system; gone with the value until it has its name.
#[derive(Debug)]
pub struct Aside {
    folder: OwnedFd,
    aside: String,
    name: OsString,
    path: PathBuf,
    file: io::BufWriter<fs::File>,
}

static WRITTEN: AtomicU64 = AtomicU64::new(0);

impl Aside {
    pub fn of<'a>(place: impl Into<Place<'a>>) -> Result<Self, FileError> {
        let place = place.into();
        let ((folder, name), path) = (place.parent()?, place.path());
        let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::EXCL | OFlags::CLOEXEC;
        loop {
            let number = WRITTEN.fetch_add(1, Ordering::Relaxed);
            let aside = format!("{}{number}", *ASIDE);
            let file = match openat(&folder, &aside, flags, Mode::RUSR | Mode::WUSR) {
                // Of a process that was killed and had the same number.
                Err(Errno::EXIST) => continue,
                made => {
                    made.map_err(|error| failed("write into", &parent_of(&path))(error.into()))?
                }
            };
            let file = io::BufWriter::new(fs::File::from(file));
            return Ok(Aside {
                folder,
                aside,
                name,
                path,
                file,
            });
        }
    }

    /// Gives it its name, so that a reader sees all of it or none.
    pub fn into_place(self) -> Result<(), FileError> {
        self.named(RenameFlags::empty())
    }

    /// The same, if nothing has that name.
    pub fn into_free_place(self) -> Result<(), FileError> {
        self.named(RenameFlags::NOREPLACE)
    }

    fn named(mut self, flags: RenameFlags) -> Result<(), FileError> {
        let written = self.file.flush();
        written.map_err(failed("write", &self.path))?;
        let file = self.file.get_ref();
        file.sync_all().map_err(failed("write", &self.path))?;
        // A file system without modes is no reason to lose a result.
        let _ = file.set_permissions(fs::Permissions::from_mode(0o644));
        let (folder, aside, name) = (&self.folder, &self.aside, &self.name);
        let renamed = match flags.is_empty() {
            true => renameat(folder, aside, folder, name),
            false => match renameat_with(folder, aside, folder, name, flags) {
                // A file system that cannot; what is aside goes with the value.
                Err(Errno::INVAL | Errno::NOSYS) => {
                    linkat(folder, aside, folder, name, AtFlags::empty())
                }
                renamed => renamed,
            },
        };
        let path = self.path.clone();
        renamed.map_err(|error| match error {
            Errno::EXIST => FileError::Exists { path },
            error => failed("rename into place", &path)(error.into()),
        })
    }
}

impl Write for Aside {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        // Nothing has this name once it is in its place.
        let _ = unlinkat(&self.folder, &self.aside, AtFlags::empty());
    }
}

/// Writes until the process is asked to end.
pub struct Heeding<'a>(pub &'a mut dyn Write, pub &'a Path);

impl Write for Heeding<'_> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if asked_to_end() {
            let path = self.1.to_owned();
            return Err(io::Error::other(FileError::Ended { path }));
        }
        self.0.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.0.flush()
    }
}

/// Writes a file aside and renames it into place, so that a reader sees all of it or none.
pub fn write_whole<'a>(place: impl Into<Place<'a>>, bytes: &[u8]) -> Result<(), FileError> {
    let place = place.into();
    let mut aside = Aside::of(place)?;
    aside.write_all(bytes).map_err(place.failed("write"))?;
    aside.into_place()
}

/// Begins a file anew, for a program that writes into it.
pub fn created<'a>(place: impl Into<Place<'a>>) -> Result<fs::File, FileError> {
    let place = place.into();
    let flags = OFlags::WRONLY | OFlags::CREATE | OFlags::TRUNC | OFlags::NONBLOCK;
    let file = place.open(flags).map_err(place.failed("create"))?;
    of_kind(place, &file.metadata().map_err(place.failed("create"))?)?;
    Ok(file)
}

/// Makes a folder, with those above it, unless it is there.
pub fn make_folder<'a>(place: impl Into<Place<'a>>) -> Result<(), FileError> {
    match place.into() {
        Place::Named(path) => fs::create_dir_all(path).map_err(failed("create", path)),
        inside if inside.is_folder() => Ok(()),
        inside => new_folder(inside),
    }
}

/// Makes a folder where there is nothing.
pub fn new_folder<'a>(place: impl Into<Place<'a>>) -> Result<(), FileError> {
    let place = place.into();
    let (parent, name) = place.parent()?;
    let made = rustix::fs::mkdirat(&parent, &name, Mode::from_raw_mode(0o777));
    made.map_err(|error| place.failed("create")(error.into()))
}

/// Removes a folder with all that is in it; links in it are removed, not followed.
pub fn remove_folder(path: &Path) -> Result<(), FileError> {
    fs::remove_dir_all(path).map_err(failed("remove", path))
}

/// Removes a folder that has nothing in it but what the system itself put there.
pub fn remove_empty_folder(path: &Path) -> Result<(), FileError> {
    fs::remove_dir(path).map_err(failed("remove", path))
}

/// Puts a link of this name into a folder of our own.
pub fn link(to: &Path, path: &Path) -> Result<(), FileError> {
    std::os::unix::fs::symlink(to, path).map_err(failed("create", path))
}

/// Lets everyone start it.
pub fn make_executable(path: &Path) -> Result<(), FileError> {
    fs::set_permissions(path, fs::Permissions::from_mode(0o755)).map_err(failed("change", path))
}

/// The same under a name that nothing has; of several at once one does.
pub fn write_new<'a>(place: impl Into<Place<'a>>, bytes: &[u8]) -> Result<(), FileError> {
    let place = place.into();
    let mut aside = Aside::of(place)?;
    aside.write_all(bytes).map_err(place.failed("write"))?;
    aside.into_free_place()
}

/// Writes a file that people named: whole, or at the end of what a file has; into a pipe or a device of this name instead of in
/// its place. A symbolic link is followed to those alone.
pub fn write_named(path: &Path, bytes: &[u8], at_the_end: bool) -> Result<(), FileError> {
    let is_link = path
        .symlink_metadata()
        .is_ok_and(|metadata| metadata.is_symlink());
    match fs::metadata(path) {
        Ok(metadata) if !metadata.is_file() && !metadata.is_dir() => write_into(path, bytes),
        _ if is_link => Err(FileError::Link {
            path: path.to_owned(),
        }),
        _ if at_the_end => {
            let file = fs::OpenOptions::new().create(true).append(true).open(path);
            let written = file.and_then(|mut file| file.write_all(bytes));
            written.map_err(failed("write", path))
        }
        _ => write_whole(path, bytes),
    }
}

/// Writes into a pipe or a device, until a signal to end.
fn write_into(path: &Path, mut bytes: &[u8]) -> Result<(), FileError> {
    let at_once = OFlags::NONBLOCK.bits();
    let mut options = fs::OpenOptions::new();
    let options = options.write(true).custom_flags(at_once.cast_signed());
    let mut file = match options.open(path) {
        Err(error) if error.raw_os_error() == Some(Errno::NXIO.raw_os_error()) => {
            let path = path.to_owned();
            return Err(FileError::NotRead { path });
        }
        opened => opened.map_err(failed("open for writing", path))?,
    };
    while !bytes.is_empty() {
        match file.write(bytes) {
            Ok(written) => bytes = &bytes[written..],
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) if error.kind() == std::io::ErrorKind::WouldBlock && !asked_to_end() => {
                std::thread::sleep(Duration::from_millis(10));
            }
            Err(error) => return Err(failed("write", path)(error)),
        }
    }
    Ok(())
}

/// Writes a file under this name, or under the next free one with a number after it, and says which.
pub fn write_beside(wanted: &Path, bytes: &[u8]) -> Result<PathBuf, FileError> {
    let path = free_name(wanted);
    write_whole(&path, bytes)?;
    Ok(path)
}

/// Gives a temporary folder this name, or the next free one with a number after it, and says which.
pub fn keep_folder(folder: TempDir, wanted: &Path) -> Result<PathBuf, FileError> {
    let path = free_name(wanted);
    folder_into_place(folder, &path).map_err(failed("rename into place", &path))?;
    Ok(path)
}

fn folder_into_place(aside: TempDir, path: &Path) -> std::io::Result<()> {
    readable_by_all(aside.path());
    fs::rename(aside.path(), path)?;
    // It is in its place; under its old name there is nothing left to remove.
    let _ = aside.keep();
    Ok(())
}

/// `wanted`, `wanted-2`, `wanted-3`, …: the first that is not taken.
fn free_name(wanted: &Path) -> PathBuf {
    let mut path = wanted.to_owned();
    for number in 2u64.. {
        if path.symlink_metadata().is_err() {
            break;
        }
        let mut name = wanted.as_os_str().to_owned();
        name.push(format!("-{number}"));
        path = name.into();
    }
    path
}

/// Opens a file for adding to it, made if it is not there. No other process can open it so as long as the file is open.
pub fn locked<'a>(place: impl Into<Place<'a>>) -> Result<fs::File, FileError> {
    let place = place.into();
    if let Ok(about) = place.about() {
        of_kind(place, &about)?;
    }
    let flags = OFlags::RDWR | OFlags::CREATE | OFlags::APPEND | OFlags::NONBLOCK;
    let file = place
        .open(flags)
        .map_err(place.failed("open for writing"))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(fs::TryLockError::WouldBlock) => Err(FileError::Busy { path: place.path() }),
        Err(fs::TryLockError::Error(error)) => Err(place.failed("lock")(error)),
    }
}

/// A folder inside one that was named, and whether it is there.
pub fn real_folder(folder: &Path, name: &str) -> Result<(PathBuf, bool), FileError> {
    let (place, path) = (Place::from((folder, name)), folder.join(name));
    match place.about() {
        Ok(about) if about.is_symlink() => Err(FileError::LinkInside { path }),
        _ => Ok((path, place.is_taken())),
    }
}

/// Kept as long as nobody else may write.
pub type Lock = fs::File;

/// The right to write into a folder that is there, for one process at a time; given back with the value.
pub fn folder_lock(folder: &Path) -> Result<Lock, FileError> {
    let lock = locked((folder, ".crossgrain.lock"))?;
    remove_litter(folder);
    Ok(lock)
}

/// A temporary folder on the file system of `path`, whose parents are made; gone with the value.
pub fn folder_aside(path: &Path) -> Result<TempDir, FileError> {
    let parent = parent_of(path);
    fs::create_dir_all(&parent).map_err(failed("create", &parent))?;
    remove_litter(&parent);
    tempfile::Builder::new()
        .prefix(&*ASIDE)
        .tempdir_in(&parent)
        .map_err(failed("write into", &parent))
}

/// Builds a folder aside with `fill` and renames it into place; an existing folder is never touched.
pub fn write_folder<E: From<FileError>>(
    path: &Path,
    fill: impl FnOnce(&Path) -> Result<(), E>,
) -> Result<(), E> {
    refuse_existing(path)?;
    let aside = folder_aside(path)?;
    fill(aside.path())?;
    folder_into_place(aside, path).map_err(|error| match refuse_existing(path) {
        // Another program was faster.
        Err(taken) => taken.into(),
        Ok(()) => failed("rename into place", path)(error).into(),
    })
}

/// An error if something is there already, or nothing can be: a name that is too long, a file where a folder should be.
pub fn refuse_existing(path: &Path) -> Result<(), FileError> {
    match path.symlink_metadata() {
        Ok(_) => Err(FileError::Exists {
            path: path.to_owned(),
        }),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
        Err(error) => Err(failed("create", path)(error)),
    }
}

/// Whether this folder holds an earlier result, which the file `record` tells.
fn holds(path: &Path, record: &str) -> bool {
    let is_folder = path
        .symlink_metadata()
        .is_ok_and(|metadata| metadata.is_dir());
    let is_file = |path: PathBuf| {
        path.symlink_metadata()
            .is_ok_and(|metadata| metadata.is_file())
    };
    is_folder && path.file_name().is_some() && is_file(path.join(record))
}

/// An error if [`make_room`] could not make this name free.
pub fn has_room(path: &Path, record: &str) -> Result<(), FileError> {
    if holds(path, record) {
        return Ok(());
    }
    refuse_existing(path)
}

/// Makes the name of a folder free: an earlier result in it, which the file `record` tells, gets the next free number
/// after its name. Returns the name that it has now.
pub fn make_room(path: &Path, record: &str) -> Result<Option<PathBuf>, FileError> {
    if !holds(path, record) {
        return Ok(None);
    }
    let numbered = free_name(path);
    fs::rename(path, &numbered).map_err(failed("rename", path))?;
    Ok(Some(numbered))
}

/// SHA-256 of a file's bytes, in hexadecimal.
pub fn file_digest<'a>(place: impl Into<Place<'a>>) -> Result<String, FileError> {
    digest_of(Stream::of(place.into(), LARGEST_DIGESTED, false)?)
}

/// The same of one that was just written, even when the process is asked to end: without it the file would be lost.
pub fn written_digest<'a>(place: impl Into<Place<'a>>) -> Result<String, FileError> {
    let mut stream = Stream::of(place.into(), LARGEST_DIGESTED, false)?;
    stream.heeds = false;
    digest_of(stream)
}

/// The same of what a packed file holds.
pub fn unpacked_digest<'a>(place: impl Into<Place<'a>>) -> Result<String, FileError> {
    digest_of(Stream::of(place.into(), LARGEST_DIGESTED, true)?)
}

fn digest_of(mut from: Stream) -> Result<String, FileError> {
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 16];
    loop {
        match from.read(&mut block) {
            Ok(0) => return Ok(hex(&hash.finalize())),
            Ok(count) => hash.update(&block[..count]),
            Err(error) => return Err(failed("read", &from.path)(error)),
        }
    }
}

fn parent_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Temporary folders are private to their owner; results are not secrets.
fn readable_by_all(path: &Path) {
    // A file system without modes is no reason to lose a result.
    let _ = fs::set_permissions(path, fs::Permissions::from_mode(0o755));
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_below_a_folder_leads_out_of_it_with_old_systems_and_new_ones() {
        let place = tempfile::tempdir().expect("a temporary folder");
        let folder = place.path().join("named");
        fs::create_dir_all(folder.join("deep")).expect("ours");
        fs::write(folder.join("deep/file"), "text").expect("ours");
        for (to, name) in [
            ("deep/file", "link"),
            ("deep", "way"),
            ("/etc/hostname", "out"),
        ] {
            link(to.as_ref(), &folder.join(name)).expect("ours");
        }
        let (flags, mode) = (OFlags::RDONLY | OFlags::CLOEXEC, Mode::empty());
        let way = OFlags::PATH | OFlags::DIRECTORY;
        for (name, is_sound) in [
            ("deep/file", true),
            ("link", false),
            ("way/file", false),
            ("out", false),
            ("../named/deep/file", false),
            ("/etc/hostname", false),
        ] {
            let root = rustix::fs::open(&folder, way, mode).expect("ours");
            let one_by_one = step_by_step(root, name, flags | OFlags::NOFOLLOW, mode);
            let at_once = open_below(&folder, name, flags, mode);
            let opened = [one_by_one.is_ok(), at_once.is_ok()];
            assert_eq!(opened, [is_sound; 2], "{name}");
        }
    }
}
