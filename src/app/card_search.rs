//! Searches cards and drives for logs while nothing is open, because a person most likely came to
//! open these.
//!
//! The drives are listed every few seconds, so that an inserted card is offered and a removed one
//! is not. Each drive is searched once, in its own thread, so that a slow card does not delay the
//! others.

use super::App;
use super::jobs::JobKey;
use bathyscope_log::formats::{LogFolder, log_folders};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time between two lists of the drives.
pub(crate) const LISTED_EVERY: Duration = Duration::from_secs(3);

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

impl App {
    /// Lists the drives when the time has come, while no log is open.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::app::{Command, Jobs};
    use std::sync::Mutex;

    static CARDS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

    fn cards() -> Vec<PathBuf> {
        CARDS.lock().expect("a list").clone()
    }

    /// Polls as often as one listing and one search need, and returns the found folders.
    fn look(app: &mut App) -> Vec<PathBuf> {
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
        assert_eq!(look(&mut app), Vec::<PathBuf>::new(), "it was not asked for");
        app.card_search.look_on(cards);
        assert_eq!(look(&mut app), std::slice::from_ref(&folder));
        CARDS.lock().expect("a list").clear();
        assert_eq!(look(&mut app), Vec::<PathBuf>::new(), "it was taken out");
        *CARDS.lock().expect("a list") = vec![card.path().to_owned()];
        assert_eq!(look(&mut app), [folder]);
        app.apply(Command::OpenDemo);
        assert_eq!(look(&mut app), Vec::<PathBuf>::new(), "a log is open");
    }
}
