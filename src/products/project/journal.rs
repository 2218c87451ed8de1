//! Journal of the changes since a project was saved: one line for each change, in a file beside it;
//! and its lock, which lets only one window open a project.
//!
//! A line is written in one piece as soon as the change is made: from then on a crash of the
//! program does not lose it. A thread then syncs the file to the disk, so that some milliseconds
//! later a crash of the computer does not lose it either; the window never waits for the disk. Each
//! line begins with a part of the hash of its text; a line whose text has another hash, such as an
//! incomplete one, is ignored.
//!
//! The window that has a project open locks its journal. On Windows the journal is opened such that
//! no other program can open it for writing. The system releases the lock when the program ends in
//! any way, so that no lock is left over. On a file system without locks, the journal's last entry
//! about its owner is used instead: a program of this computer that no longer runs does not own the
//! project.

use super::row::{Key, Row, Rows};
use super::text;
use crate::file_in_use::{for_one_writer, is_in_use};
use crate::pipeline::in_hexadecimal;
use bathyscope_log::support::regular_file;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::fmt;
use std::fs::{self, File, TryLockError};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, SyncSender};
use std::thread::JoinHandle;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

/// Number of bytes of the SHA-256 hash of a line that are written before its text, as hexadecimal
/// digits.
const CHECK_BYTES: usize = 4;
/// Largest number of attempts to open a journal, because another program may remove it meanwhile.
const TRIES: usize = 20;
/// Number and interval of the requests for a lock that another program has. A process started by
/// that program has copies of its open files, including a lock that was just released, until the
/// process runs its own code.
const ATTEMPTS: u32 = 6;
const APART: Duration = Duration::from_millis(20);

/// Program that has a project open.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Owner {
    /// Process number of the program.
    pub pid: u32,
    /// Name of the computer on which the program runs; empty if it has no name.
    pub host: String,
    /// Time at which the program opened the project, Unix seconds.
    pub since_unix_s: u64,
}

impl Owner {
    /// Returns this program as the owner from now on.
    pub(super) fn now() -> Self {
        let since = SystemTime::now().duration_since(UNIX_EPOCH);
        Self {
            pid: std::process::id(),
            host: host(),
            since_unix_s: since.map_or(0, |since| since.as_secs()),
        }
    }

    /// Returns true if the program may still run; always true for another computer, where that is
    /// unknown.
    fn may_run(&self) -> bool {
        let is_here = self.host == host();
        let runs = || Path::new("/proc").join(self.pid.to_string()).exists();
        !is_here || !cfg!(target_os = "linux") || runs()
    }
}

impl fmt::Display for Owner {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "process {}", self.pid)?;
        if self.host != host() {
            write!(f, " on {}", self.host)?;
        }
        Ok(())
    }
}

fn host() -> String {
    let hostname = fs::read_to_string("/proc/sys/kernel/hostname").ok();
    let named =
        || ["COMPUTERNAME", "HOSTNAME"].into_iter().find_map(|name| std::env::var(name).ok());
    hostname.or_else(named).unwrap_or_default().trim().to_owned()
}

/// Result of a request for a lock.
#[derive(Debug, PartialEq, Eq)]
enum Locked {
    /// This program has the lock.
    Ours,
    /// Another window has the lock.
    Taken,
    /// The file system has no locks.
    Unknown,
}

/// Requests the lock of an open file; tries for a tenth of a second if another program has it.
fn lock(file: &File) -> io::Result<Locked> {
    for _ in 1..ATTEMPTS {
        match try_lock(file)? {
            Locked::Taken => std::thread::sleep(APART),
            locked => return Ok(locked),
        }
    }
    try_lock(file)
}

fn try_lock(file: &File) -> io::Result<Locked> {
    if cfg!(windows) {
        // The program that could open the file is the only one.
        return Ok(Locked::Ours);
    }
    match file.try_lock() {
        Ok(()) => Ok(Locked::Ours),
        Err(TryLockError::WouldBlock) => Ok(Locked::Taken),
        // The numbers are errors of Linux for file systems without locks.
        Err(TryLockError::Error(error))
            if error.kind() == io::ErrorKind::Unsupported
                || matches!(error.raw_os_error(), Some(37 | 38 | 95)) =>
        {
            Ok(Locked::Unknown)
        }
        Err(TryLockError::Error(error)) => Err(error),
    }
}

/// Returns true if an open file is still the file at the path: another window may have removed it
/// between opening and locking.
#[cfg(unix)]
fn is_still(file: &File, path: &Path) -> bool {
    use std::os::unix::fs::MetadataExt as _;
    let [open, there] = [file.metadata(), fs::metadata(path)];
    matches!((open, there), (Ok(open), Ok(there)) if open.ino() == there.ino() && open.dev() == there.dev())
}

/// Returns true if an open file is still the file at the path; no other program can remove an open
/// file here.
#[cfg(not(unix))]
fn is_still(_: &File, path: &Path) -> bool {
    path.exists()
}

/// Entry of the journal, one line.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Entry {
    /// The project's file with this hash contains all changes before this line; the entry applies
    /// only if the present file has this hash.
    Saved {
        /// SHA-256 of the file's text.
        sha256: String,
        /// Version of the layout of the file and of the rows that follow.
        version: u32,
    },
    /// A program opened the project.
    Opened(Owner),
    /// A change was made.
    Done {
        /// Name of the change.
        label: String,
        /// Lines of the project that are new or changed.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        set: Vec<String>,
        /// Keys of lines that were removed.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        gone: Vec<String>,
    },
}

impl Entry {
    /// Creates the entry of a change from the rows that it sets and the keys that it removes.
    pub(super) fn done(label: &str, set: &Rows, gone: &[Key]) -> Self {
        Self::Done {
            label: label.to_owned(),
            set: set.iter().map(|(key, row)| text::write_row(key, row)).collect(),
            gone: gone.iter().map(Key::to_string).collect(),
        }
    }

    /// Applies the change to the lines of a project.
    pub(super) fn replay(&self, rows: &mut Rows) {
        if let Self::Done { set, gone, .. } = self {
            for key in gone.iter().filter_map(|text| Key::parse(text)) {
                rows.remove(&Key::new(key));
            }
            let set: Vec<(Key, Row)> = set.iter().filter_map(|line| text::read_row(line)).collect();
            rows.extend(set);
        }
    }

    pub(super) fn to_line(&self) -> String {
        // Strings and whole numbers, whose serialization cannot fail.
        let json = serde_json::to_string(self).unwrap_or_default();
        format!("{} {json}\n", check(&json))
    }

    pub(super) fn from_line(line: &str) -> Option<Self> {
        let (sum, json) = line.split_once(' ')?;
        (sum == check(json)).then(|| serde_json::from_str(json).ok()).flatten()
    }
}

fn check(json: &str) -> String {
    in_hexadecimal(&Sha256::digest(json)[..CHECK_BYTES])
}

/// Content of a journal on disk.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Read {
    /// Entries of its valid lines.
    pub entries: Vec<Entry>,
    /// Number of lines that are not valid.
    pub damaged: usize,
    /// Bytes up to the end of the last complete line.
    whole: u64,
}

impl Read {
    pub(super) fn of(bytes: &[u8]) -> Self {
        let whole = bytes.iter().rposition(|byte| *byte == b'\n').map_or(0, |at| at + 1);
        let mut read = Self { whole: whole as u64, ..Self::default() };
        for line in bytes[..whole].split(|byte| *byte == b'\n').filter(|line| !line.is_empty()) {
            match str::from_utf8(line).ok().and_then(Entry::from_line) {
                Some(entry) => read.entries.push(entry),
                None => read.damaged += 1,
            }
        }
        read
    }

    /// Returns the program that opened the project last; `None` if no entry names one.
    pub(super) fn owner(&self) -> Option<&Owner> {
        self.entries.iter().rev().find_map(|entry| match entry {
            Entry::Opened(owner) => Some(owner),
            _ => None,
        })
    }
}

/// Reason why a journal cannot be opened for writing.
#[derive(Debug)]
pub(super) enum NoJournal {
    /// Another window has the project open.
    Taken(Owner),
    /// The system's error.
    Io(io::Error),
}

impl From<io::Error> for NoJournal {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Journal of an open project, into which no other program writes.
#[derive(Debug)]
pub(super) struct ProjectJournal {
    path: PathBuf,
    file: File,
    length: u64,
    keeper: Option<Keeper>,
}

/// Thread that syncs the written lines to the disk.
#[derive(Debug)]
struct Keeper {
    wake: SyncSender<()>,
    thread: JoinHandle<()>,
}

impl Keeper {
    fn start(file: &File) -> io::Result<Self> {
        let file = file.try_clone()?;
        // One message in the channel is enough: its receiver syncs all lines written before.
        let (wake, wakes) = mpsc::sync_channel(1);
        let keep = move || {
            while wakes.recv().is_ok() {
                // A failure of the disk is reported when the project is saved.
                file.sync_data().ok();
            }
        };
        let thread = std::thread::Builder::new().name("journal".to_owned()).spawn(keep)?;
        Ok(Self { wake, thread })
    }
}

impl ProjectJournal {
    /// Opens the journal at a path for this window alone; returns the journal and its content.
    ///
    /// # Errors
    /// When another window has the journal open, or the folder cannot be written into.
    pub(super) fn open(path: &Path) -> Result<(Self, Read), NoJournal> {
        let mut options = File::options();
        options.read(true).write(true).create(true).truncate(false);
        for_one_writer(&mut options);
        for _ in 0..TRIES {
            let mut file = match options.open(path) {
                Err(error) if is_in_use(&error) => {
                    let read = Read::of(&regular_file::read(path, text::LONGEST)?);
                    return Err(NoJournal::Taken(read.owner().cloned().unwrap_or_default()));
                }
                opened => opened?,
            };
            if !file.metadata()?.is_file() {
                return Err(io::Error::other("the journal beside the project is no file").into());
            }
            let locked = lock(&file)?;
            if locked == Locked::Ours && !is_still(&file, path) {
                continue;
            }
            let mut bytes = Vec::new();
            (&mut file).take(text::LONGEST).read_to_end(&mut bytes)?;
            let read = Read::of(&bytes);
            let owner = read.owner().cloned().unwrap_or_default();
            let is_taken = match locked {
                Locked::Ours => false,
                Locked::Taken => true,
                Locked::Unknown => read
                    .owner()
                    .is_some_and(|owner| owner.pid != std::process::id() && owner.may_run()),
            };
            if is_taken {
                return Err(NoJournal::Taken(owner));
            }
            // An incomplete line of a program that was killed would damage the next line.
            file.set_len(read.whole)?;
            file.seek(SeekFrom::End(0))?;
            let journal = Self {
                path: path.to_owned(),
                keeper: Some(Keeper::start(&file)?),
                length: read.whole,
                file,
            };
            return Ok((journal, read));
        }
        Err(io::Error::other("the journal beside the project comes and goes").into())
    }

    /// Writes a line; from then on a crash of the program does not lose it.
    ///
    /// # Errors
    /// The system's error; the journal is then unchanged.
    pub(super) fn append(&mut self, entry: &Entry) -> io::Result<()> {
        let line = entry.to_line();
        if let Err(error) = self.file.write_all(line.as_bytes()) {
            // A full disk may have taken a part of the line.
            self.file.set_len(self.length)?;
            self.file.seek(SeekFrom::End(0))?;
            return Err(error);
        }
        self.length += line.len() as u64;
        if let Some(keeper) = &self.keeper {
            // If the channel is full, the thread has a message already.
            keeper.wake.try_send(()).ok();
        }
        Ok(())
    }

    /// Empties the journal after the project was saved: its first entries say that the file with
    /// the hash `sha256` contains all changes, and that this program has the project open.
    pub(super) fn restart(&mut self, sha256: &str, version: u32) -> io::Result<()> {
        self.file.set_len(0)?;
        self.file.seek(SeekFrom::Start(0))?;
        self.length = 0;
        self.append(&Entry::Saved { sha256: sha256.to_owned(), version })?;
        self.append(&Entry::Opened(Owner::now()))
    }

    /// Returns a handle with which any thread can sync all lines written so far to the disk.
    pub(super) fn handle(&self) -> io::Result<File> {
        self.file.try_clone()
    }

    /// Removes the journal: the project's file contains all its changes.
    pub(super) fn remove(self) {
        let path = self.path.clone();
        // On Windows a file must be closed before it can be removed.
        let open = (!cfg!(windows)).then_some(self);
        // A journal that cannot be removed is opened next time, and adds no change.
        fs::remove_file(path).ok();
        drop(open);
    }
}

impl Drop for ProjectJournal {
    fn drop(&mut self) {
        if let Some(Keeper { wake, thread }) = self.keeper.take() {
            drop(wake);
            thread.join().ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn gesture(label: &str) -> Entry {
        Entry::Done {
            label: label.to_owned(),
            set: vec!["view.map = 1".to_owned()],
            gone: vec!["view.old".to_owned()],
        }
    }

    /// A journal that is cut at any byte contains all lines but the one that was cut, and can be
    /// continued.
    #[test]
    fn a_journal_that_was_cut_anywhere_loses_its_last_line_at_most() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.bathyscope-journal");
        let (mut journal, _) = ProjectJournal::open(&path).expect("a journal");
        journal.restart("00", 1).expect("a journal");
        let labels = ["one", "two", "thr\u{e9}e"];
        for label in labels {
            journal.append(&gesture(label)).expect("a line");
        }
        drop(journal);
        let whole = fs::read(&path).expect("a journal");
        for cut in 0..=whole.len() {
            fs::write(&path, &whole[..cut]).expect("a file");
            let (mut journal, read) = ProjectJournal::open(&path).expect("a journal");
            let ends = whole[..cut].iter().filter(|byte| **byte == b'\n').count();
            assert_eq!((read.entries.len(), read.damaged), (ends, 0), "{cut}");
            journal.append(&gesture("more")).expect("a line");
            drop(journal);
            let again = Read::of(&fs::read(&path).expect("a journal"));
            assert_eq!((again.entries.len(), again.damaged), (ends + 1, 0), "{cut}");
        }
        let mut spoilt = whole.clone();
        spoilt[whole.len() / 2] ^= 1;
        let read = Read::of(&spoilt);
        assert_eq!((read.entries.len(), read.damaged), (4, 1));
    }

    #[test]
    fn a_second_window_is_told_who_has_the_journal() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.bathyscope-journal");
        let (mut journal, _) = ProjectJournal::open(&path).expect("a journal");
        journal.restart("00", 1).expect("a journal");
        match ProjectJournal::open(&path) {
            Err(NoJournal::Taken(owner)) => assert_eq!(owner.pid, std::process::id()),
            other => panic!("{other:?}"),
        }
        journal.remove();
        assert!(!path.exists());
        ProjectJournal::open(&path).expect("a journal of our own");
    }

    #[test]
    fn an_owner_that_ended_owns_nothing() {
        let own = Owner::now();
        assert!(own.may_run());
        // The number is above the largest process number of Linux.
        let ended = Owner { pid: 4_294_967_294, ..own.clone() };
        assert_eq!(ended.may_run(), !cfg!(target_os = "linux"));
        let elsewhere = Owner { host: "another computer".to_owned(), ..ended };
        assert!(elsewhere.may_run());
        assert_eq!(elsewhere.to_string(), "process 4294967294 on another computer");
        assert_eq!(own.to_string(), format!("process {}", std::process::id()));
    }
}
