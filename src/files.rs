//! Files: bounded reading, writing aside and renaming, digests. Nothing here knows what is in them.

use std::fs;
use std::io::{Read, Write};
use std::os::unix::fs::{OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};
use std::time::Duration;

use crate::exit;
use grains::tables::hex;
pub use grains::tables::{sha256_hex, short_hex};
use grains::task::asked_to_end;
use sha2::{Digest, Sha256};

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
        use std::io::ErrorKind::{AlreadyExists, InvalidFilename, NotADirectory};
        match self {
            FileError::Io { action, source, .. } => match (source.kind(), *action) {
                (NotADirectory | AlreadyExists | InvalidFilename, _) => exit::USAGE,
                (_, "open" | "read" | "find") => exit::USAGE,
                _ => exit::TRY_AGAIN,
            },
            FileError::Busy { .. } | FileError::NotRead { .. } => exit::TRY_AGAIN,
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
    move |source| FileError::Io {
        action,
        path,
        source,
    }
}

/// A folder of one's own among the temporary files; gone with the value.
pub fn work_folder() -> Result<tempfile::TempDir, FileError> {
    let place = std::env::temp_dir();
    remove_litter(&place);
    let folder = tempfile::Builder::new().prefix(&aside_prefix()).tempdir();
    folder.map_err(failed("create a folder in", &place))
}

/// What is written aside is called so.
const ASIDE: &str = ".crossgrain.partial-";

/// How the names of what this process writes aside begin: with the machine and its processes' numbers, and with this one's.
pub fn aside_prefix() -> String {
    let own = format!("{}-{}", std::process::id(), began("self"));
    format!("{ASIDE}{}-{own}-", numbers_of())
}

/// What tells whose processes are counted: the start of the machine and the room of numbers in which this process is.
fn numbers_of() -> String {
    let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    let room = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
    sha256_hex(format!("{boot}{}", room.display()).as_bytes())[..12].to_owned()
}

/// When a process began, in the system's ticks; empty where there is none.
fn began(process: &str) -> String {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    let after_name = stat.rsplit_once(')').map_or("", |of| of.1);
    let began = after_name.split_whitespace().nth(19);
    began.unwrap_or_default().to_owned()
}

/// Removes what processes of this machine that are gone have left in a folder, aside and unfinished. What cannot be removed
/// stays.
pub fn remove_litter(folder: &Path) {
    let ours = format!("{ASIDE}{}-", numbers_of());
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let of = name.to_str().and_then(|name| name.strip_prefix(&ours));
        let mut parts = of.into_iter().flat_map(|of| of.splitn(3, '-'));
        let (Some(process), Some(start), Some(_)) = (parts.next(), parts.next(), parts.next())
        else {
            continue;
        };
        let is_number = |of: &str| of.parse::<u64>().is_ok();
        if is_number(process) && is_number(start) && began(process) != start {
            let path = entry.path();
            let _ = match entry.file_type().is_ok_and(|of| of.is_dir()) {
                true => fs::remove_dir_all(path),
                false => fs::remove_file(path),
            };
        }
    }
}

/// A file aside in this folder; gone with the value unless it is put in its place.
pub fn file_aside(folder: &Path) -> Result<tempfile::NamedTempFile, FileError> {
    let mut named = tempfile::Builder::new();
    let file = named.prefix(&aside_prefix()).tempfile_in(folder);
    file.map_err(failed("write into", folder))
}

/// Reads at most `limit` bytes of text. A name that ends in `.gz` is unpacked, the limit then
/// holding for the unpacked text.
pub fn read_text(path: &Path, limit: u64) -> Result<String, FileError> {
    let file = regular(path)?;
    let mut bytes = Vec::new();
    let file: Box<dyn Read> = match path.extension().is_some_and(|end| end == "gz") {
        // Of all that was packed, one after the other; what follows and is not packed is an error.
        true => Box::new(flate2::read::MultiGzDecoder::new(file)),
        false => Box::new(file),
    };
    let read = file.take(limit.saturating_add(1)).read_to_end(&mut bytes);
    read.map_err(failed("read", path))?;
    let path = path.to_owned();
    if bytes.len() as u64 > limit {
        return Err(FileError::TooLarge { path, limit });
    }
    String::from_utf8(bytes).map_err(|_| FileError::NotText { path })
}

/// The most bytes of a file whose digest is taken.
const LARGEST_DIGESTED: u64 = 1 << 30;

/// Opens a regular file for reading. It is asked before it is opened, since opening a device may do something, and once more
/// afterwards, since another may stand in its place by then; opening a pipe does not wait for a writer.
pub fn regular(path: &Path) -> Result<fs::File, FileError> {
    let of_kind = |is_file: bool| {
        let path = path.to_owned();
        is_file.then_some(()).ok_or(FileError::NotAFile { path })
    };
    let open = || failed("open", path);
    of_kind(fs::metadata(path).map_err(open())?.is_file())?;
    let at_once = rustix::fs::OFlags::NONBLOCK.bits().cast_signed();
    let mut options = fs::OpenOptions::new();
    let file = options.read(true).custom_flags(at_once).open(path);
    let file = file.map_err(open())?;
    of_kind(file.metadata().map_err(open())?.is_file())?;
    Ok(file)
}

/// The text that these packed bytes hold; `path` says where they come from.
pub fn unpacked(path: &Path, bytes: &[u8]) -> Result<String, FileError> {
    let read = std::io::read_to_string(flate2::read::GzDecoder::new(bytes));
    read.map_err(failed("read", path))
}

/// Writes a file aside and renames it into place, so that a reader sees all of it or none.
pub fn write_whole(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    let folder = parent_of(path);
    let mut aside = file_aside(&folder)?;
    aside.write_all(bytes).map_err(failed("write", path))?;
    into_place(aside, path)
}

/// The same under a name that nothing has; of several at once one does.
pub fn write_new(path: &Path, bytes: &[u8]) -> Result<(), FileError> {
    refuse_existing(path)?;
    let folder = parent_of(path);
    let mut aside = file_aside(&folder)?;
    aside.write_all(bytes).map_err(failed("write", path))?;
    aside.as_file().sync_all().map_err(failed("write", path))?;
    readable_by_all(aside.path());
    aside.persist_noclobber(path).map(drop).map_err(|error| {
        let taken = refuse_existing(path).err();
        taken.unwrap_or_else(|| failed("rename into place", path)(error.error))
    })
}

/// Writes a file that people named: whole, or at the end of what a file has; into a pipe or a device of this name instead of in
/// its place. A symbolic link is followed to those alone.
pub fn write_named(path: &Path, bytes: &[u8], at_the_end: bool) -> Result<(), FileError> {
    let is_link = path.symlink_metadata().is_ok_and(|of| of.is_symlink());
    match fs::metadata(path) {
        Ok(of) if !of.is_file() && !of.is_dir() => write_into(path, bytes),
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
    let at_once = rustix::fs::OFlags::NONBLOCK.bits();
    let mut options = fs::OpenOptions::new();
    let options = options.write(true).custom_flags(at_once.cast_signed());
    let mut file = match options.open(path) {
        Err(error) if error.raw_os_error() == Some(rustix::io::Errno::NXIO.raw_os_error()) => {
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

/// Gives a file that was written aside, on the same file system, its name.
pub fn into_place(aside: tempfile::NamedTempFile, path: &Path) -> Result<(), FileError> {
    aside.as_file().sync_all().map_err(failed("write", path))?;
    readable_by_all(aside.path());
    aside
        .persist(path)
        .map_err(|error| failed("rename into place", path)(error.error))?;
    Ok(())
}

/// Writes a file under this name, or under the next free one with a number after it, and says which.
pub fn write_beside(wanted: &Path, bytes: &[u8]) -> Result<PathBuf, FileError> {
    let path = free_name(wanted);
    write_whole(&path, bytes)?;
    Ok(path)
}

/// Gives a temporary folder this name, or the next free one with a number after it, and says which.
pub fn keep_folder(folder: tempfile::TempDir, wanted: &Path) -> Result<PathBuf, FileError> {
    let path = free_name(wanted);
    folder_into_place(folder, &path).map_err(failed("rename into place", &path))?;
    Ok(path)
}

fn folder_into_place(aside: tempfile::TempDir, path: &Path) -> std::io::Result<()> {
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
pub fn locked(path: &Path) -> Result<fs::File, FileError> {
    let mut options = fs::OpenOptions::new();
    let opened = options.create(true).read(true).append(true).open(path);
    let file = opened.map_err(failed("open for writing", path))?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(fs::TryLockError::WouldBlock) => Err(FileError::Busy {
            path: path.to_owned(),
        }),
        Err(fs::TryLockError::Error(error)) => Err(failed("lock", path)(error)),
    }
}

/// The right to write into a folder that is there, for one process at a time; given back with the value.
pub fn folder_lock(folder: &Path) -> Result<fs::File, FileError> {
    let lock = locked(&folder.join(".crossgrain.lock"))?;
    remove_litter(folder);
    Ok(lock)
}

/// A temporary folder on the file system of `path`, whose parents are made; gone with the value.
pub fn folder_aside(path: &Path) -> Result<tempfile::TempDir, FileError> {
    let parent = parent_of(path);
    fs::create_dir_all(&parent).map_err(failed("create", &parent))?;
    remove_litter(&parent);
    tempfile::Builder::new()
        .prefix(&aside_prefix())
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
    let is_folder = path.symlink_metadata().is_ok_and(|of| of.is_dir());
    let is_file = |path: PathBuf| path.symlink_metadata().is_ok_and(|of| of.is_file());
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
pub fn file_digest(path: &Path) -> Result<String, FileError> {
    let file = regular(path)?;
    if file.metadata().is_ok_and(|of| of.len() > LARGEST_DIGESTED) {
        let (path, limit) = (path.to_owned(), LARGEST_DIGESTED);
        return Err(FileError::TooLarge { path, limit });
    }
    digest_of(path, file)
}

/// The same of what a packed file holds.
pub fn unpacked_digest(path: &Path) -> Result<String, FileError> {
    digest_of(path, flate2::read::MultiGzDecoder::new(regular(path)?))
}

fn digest_of(path: &Path, from: impl Read) -> Result<String, FileError> {
    // One that grows is no longer what it was.
    let mut from = from.take(LARGEST_DIGESTED);
    let mut hash = Sha256::new();
    let mut block = vec![0; 1 << 16];
    loop {
        match from.read(&mut block).map_err(failed("read", path))? {
            0 => return Ok(hex(&hash.finalize())),
            count => hash.update(&block[..count]),
        }
    }
}

fn parent_of(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if !parent.as_os_str().is_empty() => parent.to_owned(),
        _ => PathBuf::from("."),
    }
}

/// Temporary files are private to their owner; results are not secrets.
fn readable_by_all(path: &Path) {
    let mode = if path.is_dir() { 0o755 } else { 0o644 };
    // A file system without modes is no reason to lose a result.
    let _ = fs::set_permissions(path, fs::Permissions::from_mode(mode));
}
