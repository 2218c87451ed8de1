//! Finds the folders of a card or drive that contain logs. Only the names of files are used: no
//! file is opened, because reading a slow card would take too long.

use super::table::{FileRole, role_by_name};
use crate::support::progress::Progress;
use std::collections::VecDeque;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

/// Most levels of folders between the top of the drive and a log. Recorders use at most three:
/// `Garmin/Sonar/2026`.
const DEPTH: usize = 4;
/// Most folders that are searched, so that the search in a backup of a whole computer ends.
const FOLDERS: usize = 2_000;
/// Most files that are checked.
const FILES: usize = 200_000;

/// A folder that contains logs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LogFolder {
    /// Path of the folder.
    pub path: PathBuf,
    /// Path of the folder beginning with the name of its card: `NO NAME/Sonar`.
    pub on_card: PathBuf,
    /// Logs in the folder, the newest first.
    pub logs: Vec<FoundLog>,
}

/// A file whose name is that of a log.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FoundLog {
    /// Path of the file.
    pub path: PathBuf,
    /// Time of its last change; `None` where the drive does not state it.
    pub written: Option<SystemTime>,
}

/// Returns the folders below `top` that contain logs; the folder with the newest log comes first.
/// Unreadable folders and links are skipped.
pub fn log_folders(top: &Path, progress: &Progress) -> Vec<LogFolder> {
    let mut found = Vec::new();
    let mut ahead = VecDeque::from([(top.to_owned(), 0)]);
    let (mut folders, mut files) = (0, 0);
    while let Some((path, depth)) = ahead.pop_front() {
        folders += 1;
        if progress.is_cancelled() || folders > FOLDERS || files > FILES {
            break;
        }
        let entries = fs::read_dir(&path).into_iter().flatten().flatten();
        let mut logs = Vec::new();
        for entry in entries.take(FILES - files + 1) {
            files += 1;
            let Ok(kind) = entry.file_type() else {
                continue;
            };
            let is_hidden = entry.file_name().to_string_lossy().starts_with(['.', '$']);
            if kind.is_dir() && depth < DEPTH && !is_hidden {
                ahead.push_back((entry.path(), depth + 1));
            }
            if kind.is_file() && !is_hidden && is_log(&entry.path()) {
                let written = entry.metadata().and_then(|known| known.modified()).ok();
                logs.push(FoundLog { path: entry.path(), written });
            }
        }
        logs.sort_by(|a, b| b.written.cmp(&a.written).then(a.path.cmp(&b.path)));
        if !logs.is_empty() {
            let above = top.parent().unwrap_or(Path::new(""));
            let on_card = path.strip_prefix(above).unwrap_or(&path).to_owned();
            found.push(LogFolder { path, on_card, logs });
        }
    }
    found.sort_by_key(|folder| std::cmp::Reverse(folder.logs[0].written));
    found
}

/// Returns true if a file is a log by its name. Descriptions count only with a folder of the same
/// name beside them, because files of other programs have the same endings.
fn is_log(path: &Path) -> bool {
    match role_by_name(path) {
        Some(FileRole::Log) => true,
        Some(FileRole::Description) => path.with_extension("").is_dir(),
        _ => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs::File;
    use std::time::Duration;

    /// Creates a file whose last change was `written_s` seconds after 1970.
    fn write(path: &Path, written_s: u64) {
        fs::create_dir_all(path.parent().expect("a folder")).expect("a folder");
        let file = File::create(path).expect("a file");
        let written = SystemTime::UNIX_EPOCH + Duration::from_secs(written_s);
        file.set_modified(written).expect("a time");
    }

    fn names(folder: &LogFolder) -> Vec<String> {
        let names = folder.logs.iter().filter_map(|log| log.path.file_name());
        names.map(|name| name.to_string_lossy().into_owned()).collect()
    }

    #[test]
    fn logs_are_found_by_their_names_the_newest_first() {
        let card = tempfile::tempdir().expect("a card");
        let at = |path: &str| card.path().join(path);
        for (path, written_s) in [
            ("Sonar0001.sl2", 100),
            ("Sonar0002.SL2", 200),
            ("photo.jpg", 900),
            ("System.DAT", 900),
            ("Garmin/Sonar/2026/trip.RSD", 300),
            ("RECORD/Rec00001.DAT", 50),
            ("RECORD/Rec00001/B002.SON", 900),
            (".Trashes/old.sl2", 900),
            ("a/b/c/d/e/deep.sl2", 900),
            ("notes/readme.txt", 900),
        ] {
            write(&at(path), written_s);
        }
        let found = log_folders(card.path(), &Progress::new());
        let folders: Vec<&Path> = found.iter().map(|folder| &*folder.path).collect();
        assert_eq!(folders, [at("Garmin/Sonar/2026"), card.path().into(), at("RECORD")]);
        let name = card.path().file_name().map(PathBuf::from).expect("a name");
        assert_eq!(found[0].on_card, name.join("Garmin/Sonar/2026"));
        assert_eq!(names(&found[0]), ["trip.RSD"]);
        assert_eq!(names(&found[1]), ["Sonar0002.SL2", "Sonar0001.sl2"]);
        assert_eq!(names(&found[2]), ["Rec00001.DAT"]);
    }

    #[test]
    fn a_card_that_is_gone_or_empty_holds_none() {
        let card = tempfile::tempdir().expect("a card");
        assert_eq!(log_folders(card.path(), &Progress::new()), []);
        assert_eq!(log_folders(&card.path().join("none"), &Progress::new()), []);
        write(&card.path().join("a.sl2"), 1);
        let cancelled = Progress::new();
        cancelled.cancel();
        assert_eq!(log_folders(card.path(), &cancelled), []);
    }
}
