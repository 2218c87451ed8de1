//! Watches the files of the open logs, and the cards and drives while nothing is open, in threads
//! that do not count as activity.
//!
//! The files of the open logs are checked every second: a log that was cut, overwritten, or cannot
//! be read to its end any more is reported once. A log that grows keeps its contents as far as they
//! were read, and a followed log is read from a copy. The check has its own thread, because a disk
//! may not respond; the thread wakes the window only if there is a fault to report.
//!
//! Cards and drives are searched for logs, because a person most likely came to open these. The
//! drives are listed every few seconds, so that an inserted card is offered and a removed one is
//! not. Each drive is searched once, in its own thread, so that a slow card does not delay the
//! others.

use super::jobs::JobKey;
use super::{App, Jobs, LogId, Notices, OpenLogs, crash_report};
use bathyscope_log::formats::{LogFolder, log_folders};
use bathyscope_log::support::file_error::FileError;
use bathyscope_log::support::mapped_file::FileFault;
use bathyscope_log::support::progress::Progress;
use bathyscope_log::survey::{Bytes, Survey};
use std::path::PathBuf;
use std::sync::{Arc, Weak};
use std::time::{Duration, Instant};

/// Number of naps between two checks; after each nap the check ends if it was cancelled.
const NAPS: u32 = 4;
/// Length of a nap.
const NAP: Duration = Duration::from_millis(250);
/// Time between two listings of the drives.
pub(crate) const LISTED_EVERY: Duration = Duration::from_secs(3);

/// Logs whose files are checked, and faults that were reported.
#[derive(Default)]
pub(super) struct FileWatch {
    /// Weak references to the checked surveys, so that the check does not keep them open.
    logs: Vec<(LogId, Weak<Survey>)>,
    /// Logs whose fault was reported.
    reported: Vec<LogId>,
}

/// A log, and its files that are checked.
type WatchedLog = (LogId, Vec<(PathBuf, Bytes)>);

/// Function that lists the top folders of the drives.
type Drives = fn() -> Vec<PathBuf>;

/// State of the search: the drives, and the folders that were found on them.
#[derive(Default)]
pub struct CardSearch {
    /// Function that lists the drives; `None` if they are not searched.
    drives: Option<Drives>,
    listed: Option<Instant>,
    cards: Vec<Card>,
}

/// A drive, and the folders with logs that were found on it.
struct Card {
    top: PathBuf,
    folders: Vec<LogFolder>,
}

impl CardSearch {
    /// Searches these drives for logs from now on, whenever nothing is open.
    pub fn look_on(&mut self, drives: Drives) {
        self.drives = Some(drives);
    }

    /// Returns the folders with logs that were found so far on cards and drives, beginning with the
    /// folder of the newest log.
    pub fn folders(&self) -> Vec<&LogFolder> {
        let cards = self.cards.iter();
        let mut folders: Vec<&LogFolder> = cards.flat_map(|card| &card.folders).collect();
        folders.sort_by_key(|folder| std::cmp::Reverse(folder.logs[0].written));
        folders
    }
}

impl OpenLogs {
    /// Checks that the files of the open logs still hold the bytes that were read from them; see
    /// [`Survey::check_files`].
    ///
    /// # Errors
    /// Returns the fault of the first file that does not.
    pub(crate) fn check_files(&self) -> Result<(), FileError<FileFault>> {
        let mut surveys = self.all().filter_map(|log| log.survey.as_ref());
        surveys.try_for_each(|survey| survey.check_files())
    }

    /// Notifies the analyst again of the logs that lost bytes, because a file was written that may
    /// be made from them.
    pub(super) fn say_lost(&self, notices: &mut Notices) {
        let surveys = self.all().filter_map(|log| log.survey.as_ref());
        let files = surveys.flat_map(|survey| survey.source.files.iter().zip(&survey.bytes));
        for lost in files.filter_map(|(path, bytes)| Some(FileError::new(bytes.lost()?, path))) {
            notices.warn(lost);
        }
    }
}

impl App {
    /// Starts checking the files of the open logs, unless these logs are being checked already.
    pub(super) fn check_files(&mut self) {
        let reported = &self.file_watch.reported;
        let open = self.logs.all().filter(|log| !reported.contains(&log.id));
        let open = open.filter_map(|log| Some((log.id, log.survey.as_ref()?)));
        // A followed log, which changes all the time, is read from a copy.
        let is_shared = |survey: &Survey| survey.bytes.iter().any(Bytes::is_shared);
        let open = open.filter(|(_, survey)| is_shared(survey));
        let open: Vec<(LogId, &Arc<Survey>)> = open.collect();
        let now = (open.iter()).map(|(id, survey)| (*id, Arc::as_ptr(survey)));
        let known = self.file_watch.logs.iter();
        if now.eq(known.map(|(id, survey)| (*id, survey.as_ptr()))) {
            return;
        }
        crash_report::set_open(open.iter().map(|(_, survey)| kind(survey)).collect());
        let files = |survey: &Survey| -> Vec<(PathBuf, Bytes)> {
            survey.source.files.iter().cloned().zip(survey.bytes.iter().cloned()).collect()
        };
        let watched: Vec<WatchedLog> =
            (open.iter()).map(|(id, survey)| (*id, files(survey))).collect();
        self.file_watch.logs =
            (open.iter()).map(|(id, survey)| (*id, Arc::downgrade(survey))).collect();
        if watched.is_empty() {
            self.jobs.stop(&JobKey::CheckFiles);
            return;
        }
        let repeats = matches!(self.jobs.workers(), Jobs::Threads(_));
        self.jobs.run(
            JobKey::CheckFiles,
            move |progress| look(&watched, repeats, progress),
            |app, found| {
                for (id, text) in found {
                    app.file_watch.reported.push(id);
                    app.notices.warn(text);
                }
            },
        );
    }

    /// Lists the drives every [`LISTED_EVERY`] while no log is open, and drops the listed drives
    /// once a log is open.
    pub(super) fn search_cards(&mut self) {
        let Some(drives) = self.card_search.drives else {
            return;
        };
        if self.logs.shown.survey.is_some() {
            return self.search_drives(&[]);
        }
        let listed = self.card_search.listed;
        let is_due = listed.is_none_or(|listed| listed.elapsed() >= LISTED_EVERY);
        if !is_due || self.jobs.is_running(&JobKey::ListDrives) {
            return;
        }
        self.card_search.listed = Some(Instant::now());
        // A failure would be reported every few seconds.
        self.jobs.run_or(
            JobKey::ListDrives,
            move |_| drives(),
            |app, tops| {
                if app.logs.shown.survey.is_none() {
                    app.search_drives(&tops);
                }
            },
            |_| (),
        );
    }

    /// Starts searching the drives that are new in the list, and drops those that are not in it any
    /// more.
    fn search_drives(&mut self, tops: &[PathBuf]) {
        let cards = &mut self.card_search.cards;
        for gone in cards.extract_if(.., |card| !tops.contains(&card.top)) {
            self.jobs.stop(&JobKey::SearchDrive(gone.top));
        }
        for top in tops {
            if cards.iter().any(|card| card.top == *top) {
                continue;
            }
            cards.push(Card { top: top.clone(), folders: Vec::new() });
            let (of, top) = (top.clone(), top.clone());
            self.jobs.run(
                JobKey::SearchDrive(top.clone()),
                move |progress| log_folders(&of, progress),
                move |app, folders| {
                    let mut cards = app.card_search.cards.iter_mut();
                    if let Some(card) = cards.find(|card| card.top == top) {
                        card.folders = folders;
                    }
                },
            );
        }
    }
}

/// Returns the description of a log for a crash report: without its name and without positions.
fn kind(survey: &Survey) -> String {
    format!(
        "{}, {} bytes, {} side-scan pings, {} depths",
        survey.source.format,
        survey.source.byte_count,
        survey.side_scan.len(),
        survey.soundings.len()
    )
}

/// Checks the files once or, if `repeats` is true, until one has a fault. Returns the fault of each
/// log that has one, or nothing if the work was cancelled.
fn look(logs: &[WatchedLog], repeats: bool, progress: &Progress) -> Vec<(LogId, String)> {
    let fault = |(path, bytes): &(PathBuf, Bytes)| Some(FileError::new(bytes.fault(path)?, path));
    let fault = |(id, files): &WatchedLog| Some((*id, files.iter().find_map(fault)?.to_string()));
    loop {
        let found: Vec<(LogId, String)> = logs.iter().filter_map(fault).collect();
        if !found.is_empty() || !repeats {
            return found;
        }
        for _ in 0..NAPS {
            std::thread::sleep(NAP);
            if progress.is_cancelled() {
                return Vec::new();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::Command;
    use std::fs::{self, File};
    use std::io::Write as _;
    use std::path::Path;
    use std::sync::Mutex;

    const DEMO: &[u8] = include_bytes!("../../assets/demo.sl2");

    /// Returns a window that shows the demo survey, opened from a file, and the path of this file.
    fn opened(folder: &Path) -> (App, PathBuf) {
        let path = folder.join("pond.sl2");
        fs::write(&path, DEMO).expect("a log");
        let mut app = App::new(Jobs::Threads(Arc::new(|| ())));
        app.apply(Command::Open(path.clone()));
        wait(&mut app, |app| app.logs.shown.survey.is_some());
        (app, path)
    }

    fn wait(app: &mut App, is_there: impl Fn(&App) -> bool) {
        for () in bathyscope_test_support::attempts() {
            app.poll();
            if is_there(app) {
                return;
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        panic!("it does not come");
    }

    fn notice_count(app: &App, what: &str) -> usize {
        app.notices.all().filter(|notice| notice.text.contains(what)).count()
    }

    #[test]
    fn a_log_that_is_cut_while_it_is_open_is_said_once_and_nothing_is_written_of_it() {
        let folder = tempfile::tempdir().expect("a folder");
        let (mut app, path) = opened(folder.path());
        wait(&mut app, App::is_idle);
        let file = File::options().write(true).open(&path).expect("the log");
        file.set_len(10_000).expect("a cut");
        let sentence = format!("from {} to 10000 bytes", DEMO.len());
        wait(&mut app, |app| notice_count(app, &sentence) == 1);
        let out = folder.path().join("out");
        app.export(out.clone());
        wait(&mut app, App::is_idle);
        assert!(!out.exists(), "half a log was written");
        for _ in 0..30 {
            app.poll();
            std::thread::sleep(Duration::from_millis(50));
        }
        // The check of the files reports the fault once, and the attempt to write may repeat it.
        assert!((1..=2).contains(&notice_count(&app, &sentence)));
        let survey = app.logs.shown.survey.clone().expect("the log is still open");
        assert!(survey.bytes[0][20_000..].iter().all(|byte| *byte == 0));
    }

    #[test]
    fn a_log_that_grows_or_is_removed_is_as_it_was() {
        let folder = tempfile::tempdir().expect("a folder");
        let (mut app, path) = opened(folder.path());
        let mut file = File::options().append(true).open(&path).expect("the log");
        file.write_all(DEMO).expect("a longer log");
        std::thread::sleep(3 * NAP * NAPS);
        app.poll();
        fs::remove_file(&path).expect("no log");
        std::thread::sleep(2 * NAP * NAPS);
        app.poll();
        assert_eq!(notice_count(&app, "while it was open"), 0);
        // The check of the files still runs after one of them was removed.
        assert!(app.jobs.is_running(&JobKey::CheckFiles));
    }

    static CARDS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

    fn cards() -> Vec<PathBuf> {
        CARDS.lock().expect("a list").clone()
    }

    /// Polls as often as one listing and one search need, and returns the found folders.
    fn folders_found(app: &mut App) -> Vec<PathBuf> {
        app.card_search.listed = None;
        for _ in 0..3 {
            app.poll();
        }
        let folders = app.card_search.folders();
        folders.iter().map(|folder| folder.path.clone()).collect()
    }

    #[test]
    fn a_card_is_offered_while_it_is_there_and_nothing_is_open() {
        let card = tempfile::tempdir().expect("a card");
        let folder = card.path().join("Sonar");
        std::fs::create_dir(&folder).expect("a folder");
        std::fs::write(folder.join("a.sl2"), "").expect("a log");
        let mut app = App::new(Jobs::Inline);
        *CARDS.lock().expect("a list") = vec![card.path().to_owned()];
        assert_eq!(folders_found(&mut app), Vec::<PathBuf>::new(), "it was not asked for");
        app.card_search.look_on(cards);
        assert_eq!(folders_found(&mut app), std::slice::from_ref(&folder));
        CARDS.lock().expect("a list").clear();
        assert_eq!(folders_found(&mut app), Vec::<PathBuf>::new(), "it was taken out");
        *CARDS.lock().expect("a list") = vec![card.path().to_owned()];
        assert_eq!(folders_found(&mut app), [folder]);
        app.apply(Command::OpenDemo);
        assert_eq!(folders_found(&mut app), Vec::<PathBuf>::new(), "a log is open");
    }
}
