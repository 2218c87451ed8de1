//! Journal of the changes since a project was saved: one line a gesture, in a file beside it.
//!
//! A line is written in one piece as soon as the gesture is done, so that it outlives the program
//! from then on; a thread asks the disk to keep it at once, so that it outlives the computer's end
//! some milliseconds later, without the window ever waiting for the disk. Each line begins with a
//! part of its hash: one that is not whole is none.

use super::lock::{self, Locked, Owner};
use super::row::{Key, Row, Rows};
use super::text;
use crate::file_in_use::{for_one_writer, is_in_use};
use crate::pipeline::in_hexadecimal;
use bathyscope_log::support::regular_file;
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::fs::{self, File};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{self, SyncSender};
use std::thread::JoinHandle;

/// Bytes of the hash before a line.
const CHECK_BYTES: usize = 4;
/// Most attempts to open a journal that others remove meanwhile.
const TRIES: usize = 20;

/// A line of the journal.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Entry {
    /// The file whose hash this is holds all that was done before this line, if it is the one that
    /// lies there.
    Saved {
        /// SHA-256 of the file's text.
        sha256: String,
        /// Its layout, which is also that of the rows that follow.
        version: u32,
    },
    /// A window opened the project.
    Opened(Owner),
    /// A change was made.
    Done {
        /// Name.
        label: String,
        /// Lines of the project that are new or other.
        #[serde(default, skip_serializing_if = "Vec::is_empty")]
        set: Vec<String>,
        /// Keys of lines that are gone.
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
        // Texts and whole numbers, which can be written.
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

/// A journal that lies on disk.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Read {
    /// Its whole lines.
    pub entries: Vec<Entry>,
    /// Lines between them that are not whole.
    pub damaged: usize,
    /// Bytes up to the end of the last line that ends.
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

    /// Returns the program that had the project open last.
    pub(super) fn owner(&self) -> Option<&Owner> {
        self.entries.iter().rev().find_map(|entry| match entry {
            Entry::Opened(owner) => Some(owner),
            _ => None,
        })
    }
}

/// Reason why there is no journal to write into.
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

/// The journal of an open project, which nobody else writes into.
#[derive(Debug)]
pub(super) struct ProjectJournal {
    path: PathBuf,
    file: File,
    length: u64,
    keeper: Option<Keeper>,
}

/// The thread that asks the disk to keep what was written.
#[derive(Debug)]
struct Keeper {
    wake: SyncSender<()>,
    thread: JoinHandle<()>,
}

impl Keeper {
    fn start(file: &File) -> io::Result<Self> {
        let file = file.try_clone()?;
        // One message is enough: whoever takes it keeps all that was written before.
        let (wake, wakes) = mpsc::sync_channel(1);
        let keep = move || {
            while wakes.recv().is_ok() {
                // A disk that cannot keep it says so when the project is saved.
                file.sync_data().ok();
            }
        };
        let thread = std::thread::Builder::new().name("journal".to_owned()).spawn(keep)?;
        Ok(Self { wake, thread })
    }
}

/// Asks the disk to keep a journal.
#[derive(Debug)]
pub(super) struct Syncing(File);

impl Syncing {
    /// Asks, and waits.
    pub(super) fn sync(&self) -> io::Result<()> {
        self.0.sync_data()
    }
}

impl ProjectJournal {
    /// Opens the journal at a path for this window alone, with what lies in it.
    ///
    /// # Errors
    /// When another window has it, or the folder cannot be written into.
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
            let locked = lock::lock(&file)?;
            if locked == Locked::Ours && !lock::is_still(&file, path) {
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
            // What a program that was killed had half written would spoil the next line.
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

    /// Writes a line; from then on it outlives the program.
    ///
    /// # Errors
    /// The system's error; the journal is as before.
    pub(super) fn append(&mut self, entry: &Entry) -> io::Result<()> {
        let line = entry.to_line();
        if let Err(error) = self.file.write_all(line.as_bytes()) {
            // A disk that is full takes half a line.
            self.file.set_len(self.length)?;
            self.file.seek(SeekFrom::End(0))?;
            return Err(error);
        }
        self.length += line.len() as u64;
        if let Some(keeper) = &self.keeper {
            // Full means that it is awake already.
            keeper.wake.try_send(()).ok();
        }
        Ok(())
    }

    /// Begins anew: all that was done is in the file with this hash.
    pub(super) fn restart(&mut self, sha256: &str, version: u32) -> io::Result<()> {
        self.file.set_len(0)?;
        self.file.seek(SeekFrom::Start(0))?;
        self.length = 0;
        self.append(&Entry::Saved { sha256: sha256.to_owned(), version })?;
        self.append(&Entry::Opened(Owner::now()))
    }

    /// Returns a handle that asks the disk to keep all that was written so far, on any thread.
    pub(super) fn syncing(&self) -> io::Result<Syncing> {
        self.file.try_clone().map(Syncing)
    }

    /// Takes the journal away: nothing in it is missing in the file.
    pub(super) fn remove(self) {
        let path = self.path.clone();
        // On Windows only what nobody has open can be removed.
        let open = (!cfg!(windows)).then_some(self);
        // Left behind, it would be opened next time, and nothing be in it.
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

    /// Cut at any byte, a journal holds all lines but the one that was cut, and goes on from there.
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
}
