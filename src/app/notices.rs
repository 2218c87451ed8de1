//! Keeps the notices to the analyst: those on screen, and all since the program was started.

use super::Action;
use crate::app::system_words::in_plain_words;
use bathyscope_log::support::printable::one_line;
use std::collections::VecDeque;
use std::fmt::Display;
use std::path::Path;
use std::time::SystemTime;

/// Number of notices that are kept in one run of the program.
const KEPT: usize = 500;

/// A sentence for the analyst.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Notice {
    /// Sentence that states what happened and what to do.
    pub text: String,
    /// True if something could not be done; false if something was done.
    pub is_error: bool,
    /// Action that the notice offers; `None` if it offers none.
    pub offer: Option<Action>,
    /// Time of the notice.
    pub at: SystemTime,
}

/// The notices of one run of the program.
#[derive(Debug, Default)]
pub struct Notices {
    shown: Vec<Notice>,
    all: VecDeque<Notice>,
    /// True if the newest notice offers undo, so that the next such notice replaces it.
    ends_with_undo: bool,
}

impl Notices {
    /// Returns the notices on the screen, the oldest first.
    pub fn shown(&self) -> &[Notice] {
        &self.shown
    }

    /// Returns all notices since the program was started, beginning with the newest; the oldest of
    /// very many are dropped.
    pub fn all(&self) -> impl ExactSizeIterator<Item = &Notice> {
        self.all.iter().rev()
    }

    /// Notifies the analyst in a sentence.
    pub(super) fn notify(&mut self, text: impl Display) {
        self.say(in_plain_words(&text.to_string()).as_ref(), false, None);
    }

    /// Notifies the analyst of a fault, or of what is missing, in a sentence.
    pub(super) fn warn(&mut self, text: impl Display) {
        self.say(in_plain_words(&text.to_string()).as_ref(), true, None);
    }

    /// Notifies the analyst of the outcome of some work: what was done, or the error.
    pub(super) fn tell(&mut self, outcome: Result<String, impl Display>) {
        match outcome {
            Ok(text) => self.notify(text),
            Err(error) => self.warn(error),
        }
    }

    /// Notifies the analyst that a command needs a selected box.
    pub(super) fn ask_for_box(&mut self) {
        self.warn("select a box first, with Tab or a click");
    }

    /// Notifies the analyst of the path of a report about a fault of the program in its last run.
    pub(crate) fn tell_of_crash(&mut self, report: &Path) {
        self.warn(format!(
            "A fault of Bathyscope stopped it, or part of its work, the last time it ran. What happened is in {}, and was sent to nobody; attach the file when you report the fault",
            report.display()
        ));
    }

    /// Notifies the analyst, and offers an action that can be taken.
    pub(super) fn offer(&mut self, text: String, action: Action) {
        self.say(&text, false, Some(action));
    }

    /// Notifies the analyst of a change, and offers undo. The notice replaces the last one of this
    /// kind, so that a row of keys leaves one notice.
    pub(super) fn offer_undo(&mut self, text: String) {
        self.withdraw(Action::Undo);
        if self.ends_with_undo {
            self.all.pop_back();
        }
        self.offer(text, Action::Undo);
        self.ends_with_undo = true;
    }

    fn say(&mut self, text: &str, is_error: bool, offer: Option<Action>) {
        let notice = Notice { text: one_line(text), is_error, offer, at: SystemTime::now() };
        self.ends_with_undo = false;
        // A repeated notice replaces its earlier copy on the screen.
        self.shown.retain(|shown| shown.text != notice.text || shown.offer != notice.offer);
        self.all.push_back(notice.clone());
        if self.all.len() > KEPT {
            self.all.pop_front();
        }
        self.shown.push(notice);
    }

    /// Withdraws an offer that was accepted or makes no sense any more.
    pub(super) fn withdraw(&mut self, action: Action) {
        self.shown.retain(|notice| notice.offer != Some(action));
        for notice in &mut self.all {
            notice.offer = notice.offer.filter(|offer| *offer != action);
        }
    }

    /// Removes all notices from the screen; the list keeps them.
    pub fn clear(&mut self) {
        self.shown.clear();
    }

    /// Removes a notice from the screen; the list keeps it.
    pub(super) fn dismiss(&mut self, index: usize) {
        if index < self.shown.len() {
            self.shown.remove(index);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn changes_in_a_row_leave_one_notice_with_undo() {
        let mut notices = Notices::default();
        notices.notify("one");
        notices.offer_undo("two".to_owned());
        notices.offer_undo("three".to_owned());
        let texts = |notices: &Notices| -> Vec<String> {
            notices.all().map(|notice| notice.text.clone()).collect()
        };
        assert_eq!(texts(&notices), ["three", "one"]);
        assert_eq!(notices.shown.len(), 2);
        assert_eq!(notices.shown[1].offer, Some(Action::Undo));
        // The next step makes the offer void, but the notice is still listed.
        notices.withdraw(Action::Undo);
        notices.notify("four");
        notices.offer_undo("five".to_owned());
        assert_eq!(texts(&notices), ["five", "four", "three", "one"]);
        assert_eq!(notices.shown.len(), 3);
    }

    #[test]
    fn what_was_dismissed_is_still_listed_and_an_offer_is_taken_back() {
        let mut notices = Notices::default();
        notices.warn("one");
        notices.offer("two".to_owned(), Action::ShowTogether);
        notices.dismiss(0);
        notices.dismiss(7);
        assert_eq!(notices.shown.len(), 1);
        let texts: Vec<&str> = notices.all().map(|notice| notice.text.as_str()).collect();
        assert_eq!(texts, ["two", "one"]);
        notices.withdraw(Action::ShowTogether);
        assert!(notices.shown.is_empty());
        assert!(notices.all().all(|notice| notice.offer.is_none()));
        for number in 0..2 * KEPT {
            notices.notify(number);
        }
        assert_eq!(notices.all().len(), KEPT);
        let newest = notices.all().next().map(|notice| notice.text.clone());
        assert_eq!(newest.as_deref(), Some("999"));
    }
}
