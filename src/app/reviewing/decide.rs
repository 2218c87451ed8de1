//! Applies the analyst's decisions and corrections to single boxes, which mark possible objects in
//! the sonar picture; undoes and redoes them; renames their classes.

use super::{BoxEdge, Reviewing, Tool, border_m, middle};
use crate::app::history::{LogStep, UndoStep};
use crate::app::{App, Enlarged, LogBox, LogId, Orientation};
use bathyscope_log::survey::Side;
use bathyscope_objects::review::{BoxId, Edit, Review, Reviewed};
use bathyscope_objects::{Mark, ObjectExtent};
use bathyscope_products::project::UNDONE;
use std::borrow::Cow;
use std::sync::Arc;

/// Movement that the arrow keys ask for, in directions of the screen; a step is a ping along the
/// track, or a pixel of the raster across it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Nudge {
    /// Number of steps to the right.
    pub right: i32,
    /// Number of steps down.
    pub down: i32,
    /// True to move the right and lower edges alone.
    pub resize: bool,
}

impl Reviewing {
    /// Sets an earlier or later version of the boxes; returns the first box that differs in it, or
    /// `None` if none does.
    fn go_to(&mut self, review: Arc<Review>) -> Option<BoxId> {
        if Arc::ptr_eq(&review, &self.review) {
            return None;
        }
        let differs = |new: &&Reviewed| self.review.get(new.id) != Some(*new);
        let changed = review.boxes().find(differs).map(|new| new.id);
        self.set(review);
        changed
    }
}

impl App {
    /// Goes back or forward to an undo step, and to the box that it changes. The name of the step,
    /// or that it was undone, is written into the project's journal.
    pub(in crate::app) fn take_step(&mut self, step: UndoStep, is_back: bool) {
        let done = self.document.history.undo_label().unwrap_or_default();
        let label = if is_back { UNDONE.to_owned() } else { done.to_owned() };
        self.map.measuring.figure = step.figure;
        if self.map.planning.lines != step.planned {
            self.map.planning.selected = None;
        }
        self.map.planning.lines = step.planned;
        self.document.mountings = step.mountings;
        self.open_and_close(&step.closed);
        self.logs.reorder(step.logs.iter().map(|log| log.id));
        let shared = std::mem::replace(&mut self.document.shared, step.shared);
        let same_shared = Arc::ptr_eq(&shared, &self.document.shared);
        let mut changed_box = None;
        for log in step.logs {
            let changed = self.take_log_step(log, same_shared);
            changed_box = changed_box.or(changed);
        }
        if let Some(changed) = changed_box {
            self.show_box(changed, Enlarged::AsItIs);
        }
        self.settle_plane();
        self.keep_decision(&label);
        self.process();
    }

    /// Goes back or forward to the part of an undo step for one log; returns the first box that it
    /// changes, or `None` if it changes none.
    fn take_log_step(&mut self, step: LogStep, same_shared: bool) -> Option<LogBox> {
        let id = step.id;
        let log = self.logs.get_mut(id)?;
        log.is_visible = step.is_visible;
        let survey = log.survey.as_ref();
        let longer = survey.and_then(|survey| step.own.carried_to(survey));
        let own = longer.map_or(step.own, Arc::new);
        if !same_shared || !Arc::ptr_eq(&log.own, &own) {
            self.set_own(id, own, false);
        }
        let changed = self.logs.get_mut(id)?.reviewing.go_to(step.review);
        // The log may have grown since that step, and the settings may have exchanged its sides.
        self.carry_decisions(id);
        changed.map(|box_id| LogBox { log: id, id: box_id })
    }

    /// Replaces the boxes of a log by `review`. The changes of a drag are `live`: they are one undo
    /// step, which ends with the first change that is not live.
    pub(in crate::app) fn take_review(
        &mut self,
        id: LogId,
        review: Arc<Review>,
        label: impl Into<Cow<'static, str>>,
        live: bool,
    ) {
        let before = self.step_now();
        if let Some(log) = self.logs.get_mut(id) {
            log.reviewing.set(review);
        }
        self.record_step(&before, label, live);
    }

    /// Applies an edit to the shown log's boxes, and selects the box that it adds. The edits of a
    /// drag are `live`, apart from the last one.
    pub(in crate::app) fn edit(&mut self, edit: &Edit, live: bool) {
        if let Some(added) = self.edit_of(self.logs.shown.id, edit, live) {
            self.logs.shown.reviewing.tool = Tool::Look;
            self.select_box(Some(added));
        }
    }

    /// Applies an edit to a log's boxes. Returns the box that it adds, or `None` if it adds none.
    pub(in crate::app) fn edit_of(&mut self, id: LogId, edit: &Edit, live: bool) -> Option<BoxId> {
        let now = &self.logs.get_mut(id)?.reviewing.review;
        let next_id = now.next_id();
        let after = now.apply(edit);
        let adds = matches!(edit, Edit::Add { .. } | Edit::AddPoint { .. });
        let is_new = adds && after.is_some();
        // The last edit of a drag changes nothing, but still ends the undo step.
        let after = after.map_or_else(|| now.clone(), Arc::new);
        let target = edit.target().or(is_new.then_some(next_id));
        let label = match target {
            Some(BoxId(number)) => Cow::Owned(format!("{} {number}", edit.label())),
            None => Cow::Borrowed(edit.label()),
        };
        self.take_review(id, after, label, live);
        let reviewing = &mut self.logs.get_mut(id)?.reviewing;
        if let Edit::Classify(box_id, _) = edit {
            let class = reviewing.review.get(*box_id).map(|review_box| review_box.class);
            reviewing.class = class.unwrap_or(reviewing.class);
        }
        is_new.then_some(next_id)
    }

    /// Selects a box of the shown log and brings it into all views; `None` deselects the box.
    pub(in crate::app) fn select_box(&mut self, id: Option<BoxId>) {
        self.logs.shown.reviewing.selected = id;
        self.logs.shown.reviewing.edge = BoxEdge::default();
        self.logs.shown.reviewing.judging.look_away();
        let Some((survey, review_box)) =
            self.logs.shown.survey.as_ref().zip(self.logs.shown.reviewing.selected_box())
        else {
            self.logs.shown.reviewing.selected = None;
            if self.logs.shown.reviewing.tool == Tool::Edit {
                self.logs.shown.reviewing.tool = Tool::Look;
            }
            return;
        };
        let mark = middle(survey, &review_box.mark);
        self.view.reveal(mark);
    }

    /// Applies an edit to the selected box, if there is one.
    pub(in crate::app) fn edit_selected(&mut self, edit: fn(BoxId) -> Edit) {
        match self.logs.shown.reviewing.selected {
            Some(id) => self.edit(&edit(id), false),
            None => self.notices.ask_for_box(),
        }
    }

    /// Renames a class, in the list and for the boxes of all logs.
    pub(in crate::app) fn rename_class(&mut self, from: &str, to: &str) {
        let review = self.logs.shown.settings.review.renamed(from, to);
        if let Err(why) = review.check() {
            return self.notices.warn(why);
        }
        let before = self.step_now();
        for log in self.logs.all_mut() {
            if let Some(after) = log.reviewing.review.with_class_renamed(from, to) {
                log.reviewing.set(Arc::new(after));
            }
        }
        // The change of the list belongs to the same undo step.
        self.record_step(&before, "name of class", true);
        self.edit_settings("name of class", |settings| settings.review = review);
    }

    /// Removes a box that was drawn by hand; rejects a box that a model proposed.
    pub(in crate::app) fn remove_box(&mut self) {
        let selected = self.logs.shown.reviewing.selected_box();
        let manual = selected.filter(|review_box| review_box.model.is_none());
        match manual.map(|review_box| review_box.id) {
            Some(id) => self.edit(&Edit::Remove(id), false),
            None => self.decide(Edit::Reject),
        }
    }

    /// Toggles a tool.
    pub(in crate::app) fn take_tool(&mut self, tool: Tool) {
        if self.logs.shown.survey.is_none() {
            return;
        }
        if tool == Tool::Edit && self.logs.shown.reviewing.selected.is_none() {
            return self.notices.ask_for_box();
        }
        self.leave_measuring();
        let in_hand = self.logs.shown.reviewing.tool == tool;
        self.logs.shown.reviewing.edge = BoxEdge::default();
        self.logs.shown.reviewing.tool = if in_hand { Tool::Look } else { tool };
    }

    /// Moves the selected box by whole pings along the track and pixels of the raster across it.
    pub(in crate::app) fn nudge_box(&mut self, nudge: Nudge) {
        let Some(review_box) = self.logs.shown.reviewing.selected_box() else {
            return;
        };
        let (along, across) = match self.view.options.waterfall.orientation {
            Orientation::Horizontal => (nudge.right, nudge.down),
            Orientation::Vertical => (nudge.down, nudge.right),
        };
        // On the screen the box moves as the arrow points, however the picture is turned.
        let picture = &self.logs.shown.settings.picture;
        let along = if picture.flip { -along } else { along };
        let across = if picture.starboard_first { -across } else { across };
        let reviewing = &self.logs.shown.reviewing;
        let edit = match reviewing.edge {
            edge if nudge.resize || edge == BoxEdge::Whole => {
                let resize = nudge.resize && review_box.extent != ObjectExtent::Point;
                Edit::Reshape(review_box.id, nudged(&review_box.mark, along, across, resize))
            }
            edge => match edge.moved(review_box, border_m(reviewing, review_box), along, across) {
                Some(edit) => edit,
                None => return,
            },
        };
        self.edit(&edit, false);
    }
}

/// Moves a box by `along` pings, later if positive, and by `across` pixels of the raster, to
/// starboard if positive. If only its size changes, its last ping and its edge nearer to starboard
/// move: the far edge to starboard, the near edge to port.
fn nudged(mark: &Mark, along: i32, across: i32, resize: bool) -> Mark {
    let pings = along as isize;
    let across_m = f64::from(across) * super::PIXEL_M;
    let mut moved = mark.clone();
    moved.pings.end = mark.pings.end.saturating_add_signed(pings);
    if !resize {
        moved.pings.start = mark.pings.start.saturating_add_signed(pings);
        // At the start of the log the box keeps its length.
        if moved.pings.start == 0 {
            moved.pings.end = moved.pings.end.max(mark.pings.len());
        }
    }
    match (mark.side, resize) {
        (Side::Starboard, true) => moved.far_m += across_m,
        // The lower or right edge of a box to port is its near edge.
        (Side::Port, true) => moved.near_m -= across_m,
        (side, false) => {
            let outward_m = if side == Side::Port { -across_m } else { across_m };
            let outward_m = outward_m.max(-mark.near_m);
            moved.near_m += outward_m;
            moved.far_m += outward_m;
        }
    }
    moved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrows_move_a_box_as_it_looks() {
        let port = Mark { side: Side::Port, pings: 2..12, near_m: 5.0, far_m: 7.0 };
        let moved = nudged(&port, 1, 10, false);
        assert_eq!(moved.pings, 3..13);
        assert!((moved.near_m - 4.6).abs() < 1e-9, "towards starboard");
        assert!((moved.far_m - 6.6).abs() < 1e-9);
        assert_eq!(nudged(&port, -10, 0, false).pings, 0..10);
        assert_eq!(nudged(&port, 0, 1000, false).near_m, 0.0);
        let larger = nudged(&port, 3, -10, true);
        assert_eq!(larger.pings, 2..15);
        assert!((larger.near_m - 5.4).abs() < 1e-9 && larger.far_m == 7.0);
        let starboard = Mark { side: Side::Starboard, ..port };
        assert!((nudged(&starboard, 0, 10, false).near_m - 5.4).abs() < 1e-9);
        assert!((nudged(&starboard, 0, 10, true).far_m - 7.4).abs() < 1e-9);
    }
}
