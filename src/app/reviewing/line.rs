//! The queue of boxes over all logs: from one log on to the next in the order of the list, and
//! decisions about whole objects.

use super::Reviewing;
use crate::app::{App, LogBox, OpenLog};
use bathyscope_objects::review::{BoxId, DecisionCounts, Edit, Queue, Reviewed, State};
use std::sync::Arc;

/// Progress of the review of all logs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReviewCounts {
    /// The boxes in sight.
    pub boxes: DecisionCounts,
    /// Those that the filter lets through.
    pub in_line: usize,
    /// Logs that have boxes.
    pub logs: usize,
}

impl App {
    /// The logs whose boxes are reviewed, in the order of the list: those that are visible, and the
    /// one that is shown.
    pub(crate) fn reviewed_logs(&self) -> impl Iterator<Item = &OpenLog> {
        self.logs().filter(|log| log.is_visible || log.id == self.log.id)
    }

    /// Returns true if there is anything to review.
    pub fn has_boxes(&self) -> bool {
        self.reviewed_logs().any(|log| log.reviewing.has_boxes())
    }

    /// Returns the progress of the review of all logs.
    pub fn review_counts(&self) -> ReviewCounts {
        let logs = self.reviewed_logs().map(|log| &log.reviewing);
        logs.filter(|reviewing| reviewing.has_boxes()).fold(
            ReviewCounts::default(),
            |sum, reviewing| ReviewCounts {
                boxes: sum.boxes.plus(reviewing.counts()),
                in_line: sum.in_line + reviewing.line().len(),
                logs: sum.logs + 1,
            },
        )
    }

    /// Names of the classes that boxes can have, each once: the survey's list, whose first nine the
    /// digits name, and what else boxes of the reviewed logs have.
    pub fn class_names(&self) -> Vec<&str> {
        let list = self.log.settings.review.classes.iter();
        let mut names: Vec<&str> = list.map(String::as_str).collect();
        for log in self.reviewed_logs() {
            for name in log.reviewing.review.classes() {
                if !names.contains(&name.as_str()) {
                    names.push(name);
                }
            }
        }
        names
    }

    /// A box of an open log.
    pub fn log_box(&self, id: LogBox) -> Option<&Reviewed> {
        self.open_log(id.log)?.reviewing.review.get(id.id)
    }

    /// The box that keys act on.
    pub fn selected_log_box(&self) -> Option<LogBox> {
        let id = self.log.reviewing.selected?;
        Some(LogBox { log: self.log.id, id })
    }

    /// The boxes to look at, log after log.
    fn line(&self) -> Vec<LogBox> {
        let boxes = |log: &OpenLog| {
            let id = log.id;
            let line = log.reviewing.line().to_vec();
            line.into_iter().map(move |one| LogBox { log: id, id: one })
        };
        self.reviewed_logs().flat_map(boxes).collect()
    }

    /// Shows the log of a box, if it is another one, and the box in all views.
    pub(in crate::app) fn select_log_box(&mut self, id: LogBox) {
        self.show_log(id.log);
        self.select_box(Some(id.id));
    }

    /// The next box in line, or the one before, in whichever log; at the ends it stays.
    pub(in crate::app) fn step_box(&mut self, by: isize) {
        let line = self.line();
        let here = self.selected_log_box();
        let here = here.and_then(|id| line.iter().position(|one| *one == id));
        let last = line.len().saturating_sub(1);
        let is_shown = |one: &LogBox| one.log == self.log.id;
        let next = match here {
            Some(here) => here.saturating_add_signed(by).min(last),
            None if by < 0 => line.iter().rposition(is_shown).unwrap_or(last),
            None => line.iter().position(is_shown).unwrap_or(0),
        };
        if let Some(id) = line.get(next).copied() {
            self.come_to(id);
        }
    }

    /// Decides about the selected box and moves on to the next undecided one. Without a selected
    /// box it only moves on: nobody decides about a box unseen.
    pub(in crate::app) fn decide(&mut self, edit: fn(BoxId) -> Edit) {
        let line = self.line();
        let here = self.selected_log_box();
        if let Some(LogBox { id, .. }) = here {
            self.edit(&edit(id), false);
        }
        self.select_next_open(&line, here);
    }

    /// Decides about all boxes of the selected object, in whichever logs, as one undo step, and
    /// moves on to the next undecided box.
    pub(in crate::app) fn decide_object(&mut self, edit: fn(BoxId) -> Edit, label: &'static str) {
        let line = self.line();
        let here = self.selected_log_box();
        self.edit_object(edit, label);
        if here.is_some() {
            self.select_next_open(&line, here);
        }
    }

    /// Does the same to all boxes of the selected object, in whichever logs, as one undo step.
    pub(in crate::app) fn edit_object(&mut self, edit: fn(BoxId) -> Edit, label: &'static str) {
        let Some(here) = self.selected_log_box() else {
            return self.ask_for_box();
        };
        let boxes = match self.object_of(here) {
            Some(object) => object.boxes.clone(),
            // It has no place, so nothing else is known to show the same object.
            None => vec![here],
        };
        let before = self.step_now();
        for one in boxes {
            if let Some(log) = self.log_mut(one.log)
                && let Some(after) = log.reviewing.review.apply(&edit(one.id))
            {
                log.reviewing.set(Arc::new(after));
            }
        }
        let after = self.step_now();
        self.record_step(&before, &after, label, false);
    }

    /// The next box of the selected object, in whichever log saw it; around the end.
    pub(in crate::app) fn step_sighting(&mut self) {
        let Some(here) = self.selected_log_box() else {
            return self.ask_for_box();
        };
        let boxes = self.object_of(here).map(|object| object.boxes.clone());
        let boxes = boxes.unwrap_or_default();
        if let Some(at) = boxes.iter().position(|one| *one == here) {
            self.come_to(boxes[(at + 1) % boxes.len()]);
        }
    }

    /// Selects the next box in line after `here` that is undecided, around the end of the line.
    fn select_next_open(&mut self, line: &[LogBox], here: Option<LogBox>) {
        let at = match here {
            Some(here) => line.iter().position(|one| *one == here).map(|at| at + 1),
            None => line.iter().position(|one| one.log == self.log.id),
        };
        let (before, after) = line.split_at(at.unwrap_or(0));
        let is_open = |one: &LogBox| {
            let found = self.log_box(*one);
            Some(*one) != here && found.is_some_and(|found| found.state == State::Proposed)
        };
        let next = after.iter().chain(before).copied().find(|one| is_open(one));
        if let Some(next) = next {
            self.come_to(next);
        }
    }

    pub(in crate::app) fn ask_for_box(&mut self) {
        self.warn("select a box first, with Tab or a click".to_owned());
    }

    /// Sorts and filters the boxes of all logs.
    pub(in crate::app) fn set_queue(&mut self, queue: &Queue) {
        for log in self.logs_mut() {
            log.reviewing.line_up(queue);
        }
    }
}

impl Reviewing {
    fn line_up(&mut self, queue: &Queue) {
        self.queue = queue.clone();
        self.sort_and_filter();
        self.count_mistakes();
    }
}
