//! Draws notices until they are dismissed or, if they report no fault and offer no action, have
//! been visible for a while; the list of notices keeps them. They cover the upper right corner of
//! the views, where a view has no buttons, instead of a separate line: a line that appears and
//! disappears would move the button that is being clicked.

use super::parts::severity;
use crate::app::{Action, Command, Notice};
use crate::ui::ViewContext;
use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align, Align2, Area, FontSelection, Frame, Id, Label, Layout, Rect, RichText, Ui, vec2,
};
use std::time::Duration;

/// Greatest number of notices that are drawn at once.
const SHOWN: usize = 4;
/// Greatest number of lines of a notice; a longer one is shown completely under the pointer.
const LINES: usize = 4;
/// Greatest width of a notice, points.
const WIDEST: f32 = 460.0;
/// Time after which a notice about a completed action disappears.
const PATIENCE: Duration = Duration::from_secs(15);
/// Least time between frames that are drawn only because a notice disappears.
const REST: Duration = Duration::from_secs(1);
/// Space above the notices for the titles of the views, points.
const TITLES: f32 = 30.0;

/// Draws the notices over the upper right corner of the views, which cover `views`. Draws nothing
/// if there are no notices.
pub(crate) fn show(ctx: &egui::Context, context: &mut ViewContext<'_>, views: Rect) {
    let app = context.app;
    if app.notices.shown().is_empty() {
        return;
    }
    let room = (views.width() - 16.0).clamp(160.0, WIDEST);
    let area = Area::new(Id::unique("notices"))
        .pivot(Align2::RIGHT_TOP)
        .fixed_pos(views.right_top() + vec2(-8.0, TITLES));
    let shown = area.show(ctx, |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_width(room);
            let hidden = app.notices.shown().len().saturating_sub(SHOWN);
            for (index, notice) in app.notices.shown().iter().enumerate().skip(hidden) {
                line(ui, context, index, notice);
            }
            if hidden > 0 {
                let older = format!("{hidden} older notices");
                ui.label(RichText::new(older).weak().small());
            }
        });
    });
    // A notice under the pointer stays, because the analyst may be reading it.
    if !shown.response.contains_pointer() {
        forget_old(ctx, context);
    }
}

/// Dismisses notices about completed actions that have been visible for a while.
fn forget_old(ctx: &egui::Context, context: &mut ViewContext<'_>) {
    let mut next = None;
    // The order from the last to the first keeps the smaller indices valid.
    for (index, notice) in context.app.notices.shown().iter().enumerate().rev() {
        // An offered undo does not keep a notice: the Edit menu and Ctrl+Z still undo the change.
        let waits = notice.offer.is_some_and(|offer| offer != Action::Undo);
        if notice.is_error || waits {
            continue;
        }
        // After the clock was set back, the notice stays until the clock has caught up.
        let age = notice.at.elapsed().unwrap_or_default();
        match PATIENCE.checked_sub(age).filter(|left| !left.is_zero()) {
            None => context.commands.push(Command::Dismiss(index)),
            Some(left) => next = Some(next.map_or(left, |next: Duration| next.min(left))),
        }
    }
    if let Some(next) = next {
        // The exact time does not matter, and a shorter wait would redraw the window again and
        // again without need.
        ctx.request_repaint_after(next.max(REST));
    }
}

fn line(ui: &mut Ui, context: &mut ViewContext<'_>, index: usize, notice: &Notice) {
    ui.horizontal_top(|ui| {
        severity(ui, context.theme(), notice.is_error);
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            if ui.small_button("Dismiss").clicked() {
                context.push(Command::Dismiss(index));
            }
            if let Some(action) = notice.offer {
                context.button(ui.small_button(action.label()), action);
            }
            ui.with_layout(Layout::left_to_right(Align::Min), |ui| {
                let text = context.units().sentence(&notice.text);
                // The text is laid out here: a label in a row would be as wide as its text, and
                // cover the buttons.
                let lines = ui.painter().layout_job(words(ui, &text));
                ui.add(Label::new(lines)).on_hover_text(&text);
            });
        });
    });
}

/// Lays the sentence out in a few lines; a path without a space is broken at the end of a line.
fn words(ui: &Ui, text: &str) -> LayoutJob {
    let mut job = LayoutJob::default();
    let colour = ui.visuals().strong_text_color();
    let words = RichText::new(text).strong().color(colour);
    words.append_to(&mut job, ui.style(), FontSelection::Default, Align::Min);
    job.wrap = TextWrapping {
        max_rows: LINES,
        max_width: ui.available_width(),
        ..TextWrapping::default()
    };
    job
}
