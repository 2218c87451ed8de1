//! Writes files so that each is either complete or missing.

use crate::Error;
use crate::file_in_use::patiently;
use serde::Serialize;
use std::collections::BTreeSet;
use std::ffi::OsString;
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// Ending of the name of an unfinished file, after the file's own name and the process number of
/// the writer.
const PASSING: &str = ".bathyscope-part";
/// Ending of the name of a file for temporary data, after the name of the file to be written and
/// the process number of the writer.
const SCRATCH: &str = ".scratch.part";

/// Error of writing a file.
#[derive(Debug, thiserror::Error)]
#[error("cannot write the file: {source}: {path}")]
pub struct ExportError {
    /// Path of the file.
    pub path: PathBuf,
    /// Error of the operating system.
    pub source: io::Error,
}

impl ExportError {
    /// Returns a function that creates the error of writing this file from its cause.
    pub(super) fn at(path: &Path) -> impl Fn(io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self { path: path.clone(), source }
    }
}

impl From<ExportError> for Error {
    fn from(error: ExportError) -> Self {
        error.to_string().into()
    }
}

/// Returns true if two paths name the same existing file, in whatever spelling or through whatever
/// link.
pub fn is_same_file(one: &Path, other: &Path) -> bool {
    let there = [one, other].map(fs::canonicalize);
    matches!(there, [Ok(one), Ok(other)] if one == other)
}

/// Writes a file under a temporary name in the same folder and renames it when `write` has
/// succeeded, so that a reader never finds half a file and an old file stays until the new one is
/// complete. `write` must flush its buffers; its result is returned.
pub fn write_atomically<T>(
    path: &Path,
    write: impl FnOnce(File) -> io::Result<T>,
) -> Result<T, ExportError> {
    write_atomically_at(path, |passing| new_file(passing).and_then(write))
}

/// Opens a new or emptied file for reading and writing.
fn new_file(path: &Path) -> io::Result<File> {
    let mut open = File::options();
    open.read(true).write(true).create(true).truncate(true).open(path)
}

/// Does the same as [`write_atomically`] for a writer that opens a file by its path. No file exists
/// yet under the temporary name that is passed to `write`.
pub(super) fn write_atomically_at<T>(
    path: &Path,
    write: impl FnOnce(&Path) -> io::Result<T>,
) -> Result<T, ExportError> {
    let fail = ExportError::at(path);
    let Some(name) = path.file_name() else {
        return Err(fail(io::Error::other("the path names no file")));
    };
    let mut passing = OsString::from(".");
    passing.push(name);
    passing.push(format!(".{}{PASSING}", std::process::id()));
    let passing = path.with_file_name(passing);
    passing.parent().into_iter().for_each(tidy);
    let _leftover = Leftover(&passing);
    let written = match fs::remove_file(&passing) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        _ => write(&passing),
    };
    written.and_then(|made| patiently(|| fs::rename(&passing, path)).map(|()| made)).map_err(fail)
}

/// Makes a folder and its missing parents.
pub fn make_folder(folder: &Path) -> Result<(), Error> {
    let fail = |error| format!("cannot make the folder: {error}: {}", folder.display());
    Ok(fs::create_dir_all(folder).map_err(fail)?)
}

/// Writes bytes, as [`write_atomically`] does.
pub fn write_bytes(path: &Path, bytes: impl AsRef<[u8]>) -> Result<(), ExportError> {
    write_atomically(path, |mut file| file.write_all(bytes.as_ref()))
}

/// Writes a record for scripts: JSON with line breaks, so that people can read it too, and a
/// newline at the end.
pub fn write_json(path: &Path, record: &impl Serialize) -> Result<(), ExportError> {
    let text = serde_json::to_string_pretty(record);
    let text = text.map_err(|error| ExportError::at(path)(error.into()))?;
    write_bytes(path, text + "\n")
}

/// An unfinished file under its temporary name, which is removed however the writing ends; after
/// the renaming there is nothing to remove.
struct Leftover<'a>(&'a Path);

impl Drop for Leftover<'_> {
    fn drop(&mut self) {
        // Best effort: the error that is reported is the earlier one.
        fs::remove_file(self.0).ok();
    }
}

/// Renames a file that must not be overwritten: `pond.bottom.toml` becomes
/// `pond.bottom-older.toml`, or `-older-2` and so on if that name is taken. Returns the new name.
///
/// # Errors
/// When the file cannot be renamed.
pub fn rename_older(path: &Path) -> Result<PathBuf, ExportError> {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().map(|ending| ending.to_string_lossy());
    let named = |count: usize| {
        let number = match count {
            1 => String::new(),
            count => format!("-{count}"),
        };
        let ending = ending.as_ref().map(|ending| format!(".{ending}"));
        let name = format!("{stem}-older{number}{}", ending.unwrap_or_default());
        path.with_file_name(name)
    };
    let mut free = (1..).map(named).filter(|aside| !aside.exists());
    let aside = free.next().unwrap_or_else(|| named(0));
    fs::rename(path, &aside).map_err(ExportError::at(path))?;
    Ok(aside)
}

/// Removes the remains of killed programs from a folder, when the first file is written there:
/// unfinished files and temporary data of processes that have ended. Best effort: a file that
/// cannot be removed stays.
fn tidy(folder: &Path) {
    static TIDIED: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());
    let mut tidied = TIDIED.lock().unwrap_or_else(PoisonError::into_inner);
    if tidied.insert(folder.to_path_buf()) {
        remove_leftovers(folder, |name| {
            let on_its_way = || name.strip_prefix('.')?.strip_suffix(PASSING);
            name.strip_suffix(SCRATCH).or_else(on_its_way)
        });
    }
}

/// Removes the files of processes that have ended. `passing` returns the part of a file name before
/// the temporary ending, `NAME.PID`; `None` for other files, which stay.
pub(crate) fn remove_leftovers(folder: &Path, passing: impl Fn(&str) -> Option<&str>) {
    let here = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    for entry in fs::read_dir(here).into_iter().flatten().flatten() {
        let name = entry.file_name();
        let written_by = |name: &str| passing(name)?.rsplit_once('.')?.1.parse::<u32>().ok();
        let writer = name.to_str().and_then(written_by);
        let is_file = entry.file_type().is_ok_and(|kind| kind.is_file());
        if is_file && writer.is_some_and(|writer| is_dead(writer, &entry.path())) {
            fs::remove_file(entry.path()).ok();
        }
    }
}

/// Returns true if the process that wrote a file has ended. On systems other than Linux, a file
/// that has not changed for an hour counts as left over.
fn is_dead(writer: u32, file: &Path) -> bool {
    if cfg!(target_os = "linux") {
        // A killed process keeps its entry until its parent has read its exit status, which may be
        // seconds later or never.
        let stat = fs::read_to_string(format!("/proc/{writer}/stat"));
        return stat.map_or(true, |stat| has_ended(&stat));
    }
    let touched = file.metadata().and_then(|there| there.modified()).ok();
    let age = touched.and_then(|touched| touched.elapsed().ok());
    age.is_some_and(|age| age.as_secs() > 3600)
}

/// Returns true if the content of `/proc/PID/stat` is that of an ended process: the state, after
/// the name in brackets, is `Z` or `X` (proc(5)).
fn has_ended(stat: &str) -> bool {
    let state = stat.rsplit_once(") ").and_then(|(_, rest)| rest.chars().next());
    matches!(state, Some('Z' | 'X'))
}

/// Opens a file for temporary data in the folder of another file, where there is room for both. The
/// file loses its name as soon as it is open, so that nothing remains of it however the program
/// ends.
pub(super) fn scratch_near(path: &Path) -> io::Result<File> {
    let mut name = path.file_name().unwrap_or_default().to_os_string();
    name.push(format!(".{}{SCRATCH}", std::process::id()));
    let passing = path.with_file_name(name);
    let file = new_file(&passing)?;
    fs::remove_file(&passing)?;
    Ok(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_file_by_two_names_is_known() {
        let folder = tempfile::tempdir().unwrap();
        let [log, other] = ["pond.sl2", "bay.sl2"].map(|name| folder.path().join(name));
        fs::write(&log, b"log").unwrap();
        fs::write(&other, b"log").unwrap();
        assert!(is_same_file(&log, &folder.path().join(".").join("pond.sl2")));
        assert!(!is_same_file(&log, &other));
        let missing = folder.path().join("none");
        assert!(!is_same_file(&missing, &missing));
    }

    #[test]
    fn a_file_is_kept_under_a_name_that_is_free() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("pond.bottom.toml");
        for (content, name) in
            [("one", "pond.bottom-older.toml"), ("two", "pond.bottom-older-2.toml")]
        {
            fs::write(&path, content).unwrap();
            let aside = rename_older(&path).unwrap();
            assert_eq!(aside, folder.path().join(name));
            assert_eq!(fs::read_to_string(aside).unwrap(), content);
        }
        assert!(!path.exists() && rename_older(&path).is_err());
    }

    #[test]
    fn what_a_killed_program_left_is_removed_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let own = format!(".cloud.csv.{}.bathyscope-part", std::process::id());
        // No process has this number: it is above the most that Linux gives.
        let names = [
            ".cloud.csv.4294967294.bathyscope-part",
            &own,
            "surface.tif.4294967294.scratch.part",
            "film.4294967294.part",
            ".notes.x.bathyscope-part",
        ];
        for name in names {
            fs::write(folder.path().join(name), b"ha").unwrap();
        }
        let path = folder.path().join("cloud.csv");
        write_atomically(&path, |mut file| file.write_all(b"whole")).unwrap();
        let left = |name: &&str| folder.path().join(name).exists();
        let left: Vec<&str> = names.into_iter().filter(left).collect();
        // The file of this process was renamed when it was complete.
        let expected = if cfg!(target_os = "linux") {
            vec![names[3], names[4]]
        } else {
            vec![names[0], names[2], names[3], names[4]]
        };
        assert_eq!(left, expected);
    }

    #[test]
    fn a_killed_process_has_ended_before_its_parent_asks_for_its_end() {
        let stat = |state: &str| format!("4711 (bathy) (scope) {state} 4710 4711 4711 0 -1");
        assert!(["Z", "X"].map(stat).iter().all(|stat| has_ended(stat)));
        assert!(!["R", "S", "D", "T"].map(stat).iter().any(|stat| has_ended(stat)));
        if cfg!(target_os = "linux") {
            let mut killed = std::process::Command::new("sleep").arg("60").spawn().unwrap();
            let no_file = Path::new("none");
            assert!(!is_dead(killed.id(), no_file));
            killed.kill().unwrap();
            // The process ends some time after the signal.
            let is_gone = (0..500).any(|_| {
                std::thread::sleep(std::time::Duration::from_millis(10));
                is_dead(killed.id(), no_file)
            });
            killed.wait().unwrap();
            assert!(is_gone);
        }
    }

    #[test]
    fn a_failed_write_leaves_the_old_file_and_nothing_else() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cloud.csv");
        write_atomically(&path, |mut file| file.write_all(b"old")).unwrap();
        let failed = write_atomically(&path, |mut file| {
            file.write_all(b"ne")?;
            Err::<(), _>(io::Error::other("disk full"))
        });
        assert!(failed.unwrap_err().to_string().contains("disk full"));
        let stopped = bathyscope_log::support::catch_panic::catch_panic(|| {
            write_atomically::<()>(&path, |_| panic!("fault"))
        });
        assert!(stopped.is_none());
        assert_eq!(fs::read(&path).unwrap(), b"old");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }
}
