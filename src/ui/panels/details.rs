//! Draws the right panel: the review of boxes, the measured height, and the selected ping. While
//! there is none of these, the panel gives its place to the views.

use super::review::{self, ReviewPanel};
use super::{parts, selection};
use crate::app::{App, WorkStep};
use crate::ui::ViewContext;
use egui::Ui;

/// Returns the title of the first section; `None` while nothing is selected, measured or reviewed.
pub(in crate::ui) fn first_section(app: &App) -> Option<&'static str> {
    if shows_review(app) {
        return Some(review::TITLE);
    }
    if selection::is_height_measured(app) {
        return Some(selection::SHADOW_TITLE);
    }
    app.view.selection.map(|_| selection::TITLE)
}

/// Returns true if the review is shown: in the step of the objects, and where a box is selected.
fn shows_review(app: &App) -> bool {
    let is_asked_for = app.view.options.panels.step == WorkStep::Objects
        || app.logs.shown.reviewing.selected_box().is_some();
    is_asked_for && app.logs.has_boxes()
}

/// Draws the panel.
pub(in crate::ui) fn ui(ui: &mut Ui, context: &mut ViewContext<'_>, panel: &mut ReviewPanel) {
    if shows_review(context.app) {
        panel.ui(ui, context);
    } else {
        panel.leave(context.app);
    }
    selection::shadow(ui, context);
    selection::ui(ui, context);
    if first_section(context.app).is_none() {
        let hint = "Nothing is selected: click the waterfall, the map, the cloud or the time line.";
        parts::remark(ui, hint);
    }
}
