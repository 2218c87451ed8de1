//! Draws the list of changes, with the present step, where a click goes back or forward to a step;
//! the list of all notices since the program was started: time, text, and offered action; and the
//! newest notice, with those that wait for the analyst: a notice that reports no fault and offers
//! no action disappears after a while. They cover the lower edge of the views, where these have no
//! buttons, instead of a separate line: a line that appears and disappears would move the button
//! that is being clicked.

use crate::app::{Action, Command, Notice, ThemeChoice};
use crate::ui::controls::ListKeys;
use crate::ui::panels::parts;
use crate::ui::{ViewContext, theme};
use bathyscope_bottom::presentation::text::{clock, plural};
use egui::text::{LayoutJob, TextWrapping};
use egui::{
    Align, Align2, Area, Button, FontSelection, Frame, Id, Label, Layout, Rect, Response, RichText,
    ScrollArea, Ui, Window, vec2,
};
use std::time::{Duration, UNIX_EPOCH};

const WIDTH: f32 = 320.0;
const HEIGHT: f32 = 420.0;
/// Height of a row, points.
const ROW: f32 = 20.0;

/// The list of changes; closed at the start.
#[derive(Default)]
pub(super) struct HistoryList {
    /// True if the list is shown.
    pub open: bool,
    /// Number of done steps when the list was last drawn; when it changes, the list scrolls to the
    /// present step.
    at: Option<usize>,
}

impl HistoryList {
    /// Draws the list while it is open.
    pub(super) fn ui(&mut self, ctx: &egui::Context, context: &mut ViewContext<'_>) {
        if !self.open {
            self.at = None;
            return;
        }
        let mut open = true;
        Window::new("History")
            .open(&mut open)
            .collapsible(false)
            .default_size([WIDTH, HEIGHT])
            .default_pos(ctx.content_rect().center_top() + egui::vec2(-0.5 * WIDTH, 60.0))
            .show(ctx, |ui| self.list(ui, context));
        self.open &= open;
    }

    fn list(&mut self, ui: &mut Ui, context: &mut ViewContext<'_>) {
        let units = context.units();
        let steps: Vec<(String, bool)> = (context.app.document.history.steps())
            .map(|step| (units.sentence(step.label), step.is_undone))
            .collect();
        let done = steps.iter().filter(|(_, is_undone)| !is_undone).count();
        let opened = std::iter::once(("as opened".to_owned(), false));
        let rows: Vec<(String, bool)> = opened.chain(steps).collect();
        let follows = self.at.replace(done) != Some(done);
        let mut area = ScrollArea::vertical().auto_shrink([false, false]);
        if follows {
            let spacing = ui.spacing().item_spacing.y;
            let middle = (ROW + spacing) * done as f32 - 0.5 * ui.available_height();
            area = area.vertical_scroll_offset(middle.max(0.0));
        }
        let keys = ListKeys::read(ui, "steps", rows.len());
        let each = ROW + ui.spacing().item_spacing.y;
        let area = keys.scroll(area, each, ui.available_height() / each);
        area.show_rows(ui, ROW, rows.len(), |ui, range| {
            for (count, (label, is_undone)) in rows[range.clone()].iter().enumerate() {
                let count = range.start + count;
                let row = row(ui, context, (label, *is_undone), count == done);
                keys.row(ui, count, &row);
                if row.clicked() && count != done {
                    context.push(Command::GoToStep(count));
                }
            }
        });
    }
}

/// Draws a step, in weak text if it was undone.
fn row(
    ui: &mut Ui,
    context: &ViewContext<'_>,
    (label, is_undone): (&str, bool),
    is_here: bool,
) -> Response {
    let text = RichText::new(label);
    let text = match (is_here, is_undone) {
        (true, _) => text.color(theme::accent_colour(context.theme())).strong(),
        (false, true) => text.weak().italics(),
        (false, false) => text,
    };
    let size = egui::vec2(ui.available_width(), ROW);
    let state = match (is_here, is_undone) {
        (true, _) => "here",
        (false, true) => "taken back",
        (false, false) => "done",
    };
    let button = ui.add(Button::selectable(is_here, text).min_size(size).truncate());
    let button = button.accessible_name(format!("Change {label}, {state}"));
    button.on_hover_text("Goes back or forward to this step.")
}

const SIZE: [f32; 2] = [560.0, 420.0];

/// Draws the list of all notices while it is open.
pub(super) fn all_notices(ctx: &egui::Context, context: &mut ViewContext<'_>, open: &mut bool) {
    if !*open {
        return;
    }
    let room = ctx.content_rect().shrink(8.0);
    let size = vec2(SIZE[0], SIZE[1]).min(room.size());
    Window::new("Notices")
        .open(open)
        .collapsible(false)
        .default_size(size)
        .max_size(room.size())
        .default_pos(room.center_bottom() - vec2(0.5 * size.x, size.y + 40.0))
        .show(ctx, |ui| list(ui, context));
}

fn list(ui: &mut Ui, context: &mut ViewContext<'_>) {
    let app = context.app;
    if app.notices.all().len() == 0 {
        parts::remark(ui, "There are no messages yet.");
    }
    ScrollArea::vertical().auto_shrink([false, false]).show(ui, |ui| {
        for notice in app.notices.all() {
            line(ui, context, notice);
        }
    });
}

fn line(ui: &mut Ui, context: &mut ViewContext<'_>, notice: &Notice) {
    let said = context.units().sentence(&notice.text);
    ui.horizontal_top(|ui| {
        severity(ui, context.theme(), notice.is_error);
        let unix_s = notice.at.duration_since(UNIX_EPOCH).unwrap_or_default();
        let clock = clock(Some(0.0), unix_s.as_secs_f64());
        ui.label(RichText::new(clock).monospace().weak());
        ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
            if let Some(action) = notice.offer {
                context.button(ui.small_button(action.label()), action);
            }
            ui.with_layout(Layout::top_down(Align::Min), |ui| {
                ui.add(egui::Label::new(said).wrap());
            });
        });
    });
    ui.add_space(2.0);
}

/// Greatest number of notices that are drawn at once.
const SHOWN: usize = 3;
/// Greatest number of lines of a notice; a longer one is shown completely under the pointer.
const LINES: usize = 4;
/// Greatest width of a notice, points.
const WIDEST: f32 = 460.0;
/// Time after which a notice about a completed action disappears, and one that offers undo.
const PATIENCE: Duration = Duration::from_secs(10);
const UNDO_PATIENCE: Duration = Duration::from_secs(5);
/// Least time between frames that are drawn only because a notice disappears.
const REST: Duration = Duration::from_secs(1);
/// Distance between the notice and the lower edge of the views, points: the labels of a waterfall
/// are there.
const ABOVE_EDGE: f32 = 30.0;

/// Draws the notices over the lower edge of the views, which cover `views`. Draws nothing if
/// there are no notices.
pub(super) fn show_notices(ctx: &egui::Context, context: &mut ViewContext<'_>, views: Rect) {
    let app = context.app;
    if app.notices.shown().is_empty() {
        return;
    }
    let room = (views.width() - 16.0).clamp(160.0, WIDEST);
    let area = Area::new(Id::unique("notices"))
        .pivot(Align2::CENTER_BOTTOM)
        .fixed_pos(views.center_bottom() - vec2(0.0, ABOVE_EDGE));
    let shown = area.show(ctx, |ui| {
        Frame::popup(ui.style()).show(ui, |ui| {
            ui.set_width(room);
            let notices = app.notices.shown();
            let drawn = drawn(notices);
            for &index in &drawn {
                shown_notice(ui, context, index, &notices[index]);
            }
            older_notices(ui, context, notices.len() - drawn.len());
        });
    });
    // A notice under the pointer stays, because the analyst may be reading it.
    if !shown.response.contains_pointer() {
        forget_old(ctx, context);
    }
}

/// Returns the indices of the notices that are drawn, in order: the newest, and of those before it
/// the last few that wait for the analyst.
fn drawn(notices: &[Notice]) -> Vec<usize> {
    let newest = notices.len().saturating_sub(1);
    let is_drawn = |index: &usize| *index == newest || waits(&notices[*index]);
    let mut drawn: Vec<usize> = (0..notices.len()).rev().filter(is_drawn).take(SHOWN).collect();
    drawn.reverse();
    drawn
}

/// Returns true if a notice reports a fault or offers an action, and stays until it is dismissed.
/// An offered undo does not keep a notice: the Edit menu and Ctrl+Z still undo the change.
fn waits(notice: &Notice) -> bool {
    notice.is_error || notice.offer.is_some_and(|offer| offer != Action::Undo)
}

/// Dismisses notices about completed actions that have been visible for a while.
fn forget_old(ctx: &egui::Context, context: &mut ViewContext<'_>) {
    let mut next = None;
    // The order from the last to the first keeps the smaller indices valid.
    for (index, notice) in context.app.notices.shown().iter().enumerate().rev() {
        if waits(notice) {
            continue;
        }
        // After the clock was set back, the notice stays until the clock has caught up.
        let age = notice.at.elapsed().unwrap_or_default();
        let patience = if notice.offer.is_some() { UNDO_PATIENCE } else { PATIENCE };
        match patience.checked_sub(age).filter(|left| !left.is_zero()) {
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

/// Draws the number of notices that are not drawn, which opens the list, and a button that
/// removes all from the screen; draws nothing without such notices.
fn older_notices(ui: &mut Ui, context: &mut ViewContext<'_>, older: usize) {
    if older == 0 {
        return;
    }
    ui.with_layout(Layout::right_to_left(Align::Min), |ui| {
        if ui.small_button("Dismiss all").clicked() {
            // The order from the last to the first keeps the smaller indices valid.
            let all = 0..context.app.notices.shown().len();
            context.commands.extend(all.rev().map(Command::Dismiss));
        }
        let label = ui.small_button(plural(older, "older notice", "older notices"));
        context.button(label, Action::Notices);
    });
}

fn shown_notice(ui: &mut Ui, context: &mut ViewContext<'_>, index: usize, notice: &Notice) {
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

/// Draws the sign of a notice: a triangle with `!` for a failed action, a circle with `i` for a
/// completed one.
fn severity(ui: &mut Ui, look: ThemeChoice, is_error: bool) {
    let (rect, response) = ui.allocate_exact_size(vec2(16.0, 16.0), egui::Sense::hover());
    let (colour, sign, name) = if is_error {
        (theme::error_colour(look), "!", "needs attention")
    } else {
        (theme::accent_colour(look), "i", "was done")
    };
    let (at, painter) = (rect.center(), ui.painter());
    let stroke = egui::Stroke::new(1.4, colour);
    let below = if is_error {
        let corners = [[0.0, -7.0], [7.5, 6.0], [-7.5, 6.0]];
        let points = corners.map(|[x, y]| at + vec2(x, y)).to_vec();
        painter.add(egui::Shape::closed_line(points, stroke));
        1.0
    } else {
        painter.circle_stroke(at, 6.5, stroke);
        0.0
    };
    let font = egui::FontId::proportional(theme::SMALL);
    let centre = egui::Align2::CENTER_CENTER;
    painter.text(at + vec2(0.0, below), centre, sign, font, colour);
    response.widget_info(|| egui::WidgetInfo::labeled(egui::Role::Image, true, name));
}
