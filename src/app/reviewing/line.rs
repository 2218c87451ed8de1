//! Steps through the queue of boxes of all logs, log by log in the order of the list, decides about
//! whole objects, and enlarges a box in all views.

use super::Reviewing;
use crate::app::{App, CloseUp, Enlarged, LogBox, OpenLog, OpenLogs};
use bathyscope_log::survey::Side;
use bathyscope_objects::review::{BoxId, DecisionCounts, Edit, Queue, Reviewed, State};
use std::sync::Arc;

/// Least longer side that a box is given for enlarging, metres, so that the surroundings of small
/// boxes and points are visible, too.
const LEAST_M: f64 = 1.5;

/// Progress of the review of all logs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ReviewCounts {
    /// Counts of the decisions about the boxes.
    pub boxes: DecisionCounts,
    /// Number of boxes that the filter admits.
    pub in_line: usize,
    /// Number of logs that have boxes.
    pub logs: usize,
}

impl OpenLogs {
    /// Returns the logs whose boxes are reviewed, in the order of the list: the visible logs, and
    /// the shown log.
    pub(crate) fn reviewed(&self) -> impl Iterator<Item = &OpenLog> {
        self.all().filter(|log| log.is_visible || log.id == self.shown.id)
    }

    /// Returns true if a reviewed log has boxes.
    pub fn has_boxes(&self) -> bool {
        self.reviewed().any(|log| log.reviewing.has_boxes())
    }

    /// Returns the progress of the review of all logs.
    pub fn review_counts(&self) -> ReviewCounts {
        let logs = self.reviewed().map(|log| &log.reviewing);
        logs.filter(|reviewing| reviewing.has_boxes()).fold(
            ReviewCounts::default(),
            |sum, reviewing| ReviewCounts {
                boxes: sum.boxes.plus(reviewing.counts()),
                in_line: sum.in_line + reviewing.line().len(),
                logs: sum.logs + 1,
            },
        )
    }

    /// Returns the names of the classes that boxes can have, each once: the survey's list, whose
    /// first nine classes have the digits as keys, followed by the other classes of boxes in the
    /// reviewed logs.
    pub fn class_names(&self) -> Vec<&str> {
        let list = self.shown.settings.review.classes.iter();
        let mut names: Vec<&str> = list.map(String::as_str).collect();
        for log in self.reviewed() {
            for name in log.reviewing.review.classes() {
                if !names.contains(&name.as_str()) {
                    names.push(name);
                }
            }
        }
        names
    }

    /// Returns a box of an open log; `None` if there is no such box.
    pub fn log_box(&self, id: LogBox) -> Option<&Reviewed> {
        self.get(id.log)?.reviewing.review.get(id.id)
    }

    /// Sorts and filters the boxes of all logs.
    pub(in crate::app) fn set_queue(&mut self, queue: &Queue) {
        for log in self.all_mut() {
            log.reviewing.queue = queue.clone();
            log.reviewing.sort_and_filter();
            log.reviewing.count_mistakes();
        }
    }

    /// Returns the boxes of the queue, log after log.
    fn line(&self) -> Vec<LogBox> {
        let boxes = |log: &OpenLog| {
            let id = log.id;
            let line = log.reviewing.line().to_vec();
            line.into_iter().map(move |box_id| LogBox { log: id, id: box_id })
        };
        self.reviewed().flat_map(boxes).collect()
    }
}

impl OpenLog {
    /// Returns the selected box, on which keys act; `None` if none is selected.
    pub fn selected_box(&self) -> Option<LogBox> {
        let id = self.reviewing.selected?;
        Some(LogBox { log: self.id, id })
    }
}

impl App {
    /// Shows the log of a box, if it is not shown yet, and the box in all views.
    pub(in crate::app) fn select_log_box(&mut self, id: LogBox) {
        self.show_log(id.log);
        self.select_box(Some(id.id));
    }

    /// Shows the box `by` places after the selected one in the queue of all logs; stops at its
    /// ends.
    pub(in crate::app) fn step_box(&mut self, by: isize) {
        let line = self.logs.line();
        let here = self.logs.shown.selected_box();
        let here = here.and_then(|id| line.iter().position(|queued| *queued == id));
        let last = line.len().saturating_sub(1);
        let is_shown = |queued: &LogBox| queued.log == self.logs.shown.id;
        let next = match here {
            Some(here) => here.saturating_add_signed(by).min(last),
            None if by < 0 => line.iter().rposition(is_shown).unwrap_or(last),
            None => line.iter().position(is_shown).unwrap_or(0),
        };
        if let Some(id) = line.get(next).copied() {
            self.come_to(id);
        }
    }

    /// Decides about the selected box, and shows the next undecided one. Without a selected box it
    /// only shows the next one, because the analyst has not seen a box to decide about.
    pub(in crate::app) fn decide(&mut self, edit: fn(BoxId) -> Edit) {
        let line = self.logs.line();
        let here = self.logs.shown.selected_box();
        if let Some(LogBox { id, .. }) = here {
            self.edit(&edit(id), false);
        }
        self.select_next_open(&line, here);
    }

    /// Decides about all boxes of the selected object, in all logs, as one undo step, and shows the
    /// next undecided box.
    pub(in crate::app) fn decide_object(&mut self, edit: fn(BoxId) -> Edit, label: &'static str) {
        let line = self.logs.line();
        let here = self.logs.shown.selected_box();
        self.edit_object(edit, label);
        if here.is_some() {
            self.select_next_open(&line, here);
        }
    }

    /// Applies an edit to all boxes of the selected object, in all logs, as one undo step.
    pub(in crate::app) fn edit_object(&mut self, edit: fn(BoxId) -> Edit, label: &'static str) {
        let Some(here) = self.logs.shown.selected_box() else {
            return self.notices.ask_for_box();
        };
        let boxes = match self.objects.of_box(here) {
            Some(object) => object.boxes.clone(),
            // The box has no position, so that no other box is known to show the same object.
            None => vec![here],
        };
        let before = self.step_now();
        for sighting in boxes {
            if let Some(log) = self.logs.get_mut(sighting.log)
                && let Some(after) = log.reviewing.review.apply(&edit(sighting.id))
            {
                log.reviewing.set(Arc::new(after));
            }
        }
        self.record_step(&before, label, false);
    }

    /// Shows the next box of the selected object in any log; after the last box comes the first.
    pub(in crate::app) fn step_sighting(&mut self) {
        let Some(here) = self.logs.shown.selected_box() else {
            return self.notices.ask_for_box();
        };
        let boxes = self.objects.of_box(here).map(|object| object.boxes.clone());
        let boxes = boxes.unwrap_or_default();
        if let Some(at) = boxes.iter().position(|sighting| *sighting == here) {
            self.come_to(boxes[(at + 1) % boxes.len()]);
        }
    }

    /// Shows the next undecided box after `here` in the queue, around its end.
    fn select_next_open(&mut self, line: &[LogBox], here: Option<LogBox>) {
        let at = match here {
            Some(here) => line.iter().position(|queued| *queued == here).map(|at| at + 1),
            None => line.iter().position(|queued| queued.log == self.logs.shown.id),
        };
        let (before, after) = line.split_at(at.unwrap_or(0));
        let is_open = |queued: &LogBox| {
            let found = self.logs.log_box(*queued);
            Some(*queued) != here && found.is_some_and(|found| found.state == State::Proposed)
        };
        let next = after.iter().chain(before).copied().find(|queued| is_open(queued));
        if let Some(next) = next {
            self.come_to(next);
        }
    }

    /// Shows the log of a box of the queue, if it is not shown yet, and the box: one to one in the
    /// waterfall, if that option is on.
    fn come_to(&mut self, id: LogBox) {
        let is_enlarged = self.view.options.waterfall.zooms_to_boxes;
        self.show_box(id, if is_enlarged { Enlarged::OneToOne } else { Enlarged::AsItIs });
    }

    /// Toggles whether the boxes of the queue are shown one to one, or at the present scale of the
    /// waterfall.
    pub(in crate::app) fn toggle_zoom_to_boxes(&mut self) {
        let zooms = &mut self.view.options.waterfall.zooms_to_boxes;
        *zooms = !*zooms;
        if let Some(id) = self.logs.shown.selected_box() {
            self.come_to(id);
        }
    }

    /// Shows the log of a box, if it is not shown yet, and the box with its surroundings in all
    /// views, at a scale.
    pub(in crate::app) fn show_box(&mut self, id: LogBox, enlarged: Enlarged) {
        self.select_log_box(id);
        let reviewing = &self.logs.shown.reviewing;
        let selected = reviewing.selected_box();
        let close_up = selected.map(|review_box| close_up(reviewing, review_box, enlarged));
        if let Some(reveal) = &mut self.view.reveal {
            reveal.close_up = close_up;
        }
    }

    /// Enlarges the selected box in all views.
    pub(in crate::app) fn fly_to_selected(&mut self) {
        match self.logs.shown.selected_box() {
            Some(id) => self.show_box(id, Enlarged::Third),
            None => self.notices.ask_for_box(),
        }
    }
}

fn close_up(reviewing: &Reviewing, review_box: &Reviewed, enlarged: Enlarged) -> CloseUp {
    let mark = &review_box.mark;
    let middle_m = 0.5 * (mark.near_m + mark.far_m);
    let half_m = (0.5 * (mark.far_m - mark.near_m)).max(0.5 * LEAST_M);
    let ends_m = [(middle_m - half_m).max(0.0), middle_m + half_m];
    let across_m = match mark.side {
        Side::Port => [-ends_m[1], -ends_m[0]],
        Side::Starboard => ends_m,
    };
    let target = reviewing.placed(review_box.id).map(|placed| &placed.target);
    let size_m = target.map_or(f64::NAN, |target| target.length_m.max(target.width_m));
    CloseUp {
        enlarged,
        pings: [mark.pings.start, mark.pings.end],
        across_m,
        place_m: target.map(|target| [target.east_m, target.north_m, -target.depth_m]),
        // The size of a point is NaN, for which `max` returns the least size.
        size_m: size_m.max(LEAST_M),
    }
}
