//! Sentences for the analyst, until they are dismissed or, where nothing is wrong and nothing to
//! do, have been there for a while: the list of notices keeps them. They lie over the upper right
//! corner of the views, where a view has no buttons, and not in a line of their own: one that came
//! and went would move what is being clicked.

use super::parts::severity;
use crate::app::{Action, Command, Notice};
use crate::ui::ViewContext;
use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align, Align2, Area, FontSelection, Frame, Id, Label, Layout, Rect, RichText, Ui, vec2,
};
use std::time::Duration;

/// Notices shown at once.
const SHOWN: usize = 4;
/// Lines of a notice; what is longer is shown whole under the pointer.
const LINES: usize = 4;
/// Widest that a notice becomes, points.
const WIDEST: f32 = 460.0;
/// Time for which a notice stays that says what was done.
const PATIENCE: Duration = Duration::from_secs(15);
/// Frames that only wait for one to go are so far apart at least.
const REST: Duration = Duration::from_secs(1);
/// Room above them for the titles of the views, points.
const TITLES: f32 = 30.0;

/// Draws them over the upper right corner of the views, which cover `views`. Nothing when there is
/// no notice.
pub(crate) fn show(ctx: &egui::Context, context: &mut ViewContext<'_>, views: Rect) {
    let app = context.app;
    if app.notices.is_empty() {
        return;
    }
    let room = (views.width() - 16.0).clamp(160.0, WIDEST);
    let area = Area::new(Id::unique("notices"))
        .pivot(Align2::RIGHT_TOP)
        .fixed_pos(views.right_top() + vec2(-8.0, TITLES));
    let shown = area.show(ctx, |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_width(room);
            let hidden = app.notices.len().saturating_sub(SHOWN);
            for (index, notice) in app.notices.iter().enumerate().skip(hidden) {
                line(ui, context, index, notice);
            }
            if hidden > 0 {
                let older = format!("{hidden} older notices");
                ui.label(RichText::new(older).weak().small());
            }
        });
    });
    // Whoever reads one keeps it.
    if !shown.response.contains_pointer() {
        forget_old(ctx, context);
    }
}

/// Takes notices off the screen that say what was done and have been there for a while.
fn forget_old(ctx: &egui::Context, context: &mut ViewContext<'_>) {
    let mut next = None;
    // From the last: an index holds while those behind it go.
    for (index, notice) in context.app.notices.iter().enumerate().rev() {
        // What can be taken back stays so: the Edit menu and Ctrl+Z do that as well.
        let waits = notice.offer.is_some_and(|offer| offer != Action::Undo);
        if notice.is_error || waits {
            continue;
        }
        // A clock that was set back says nothing: the notice stays until it has caught up.
        let age = notice.at.elapsed().unwrap_or_default();
        match PATIENCE.checked_sub(age).filter(|left| !left.is_zero()) {
            None => context.commands.push(Command::Dismiss(index)),
            Some(left) => next = Some(next.map_or(left, |next: Duration| next.min(left))),
        }
    }
    if let Some(next) = next {
        // Nobody waits for it, and a shorter time would have the window drawn over and over for
        // nothing.
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
                // Laid out here: a label in a row would be as wide as its text, and lie over the
                // buttons.
                let lines = ui.painter().layout_job(words(ui, &text));
                ui.add(Label::new(lines)).on_hover_text(&text);
            });
        });
    });
}

/// The sentence in a few lines; a path without a space breaks where the line ends.
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
